//! How to read and to write.

use std::sync::Arc;

use super::error::{FormatError, FormatErrorKind};
use super::stream::Source;
use crate::declare::Parameters;
use crate::kind::ShapeKind;
use crate::plugin::operation::Observer;
use crate::scene::{Scene, Unit, Up};
use crate::tessellator::{Fineness, Tessellator};

/// How to read.
#[derive(Clone, Default)]
pub struct ReadOptions<'a> {
    /// The unit to note instead of what the file says (or does not say).
    pub unit: Option<Unit>,
    /// The up axis to note instead of what the format says.
    pub up: Option<Up>,
    /// The kinds of shape that plug-ins bring ([`Registry::shape_kinds`](crate::plugin::Registry::shape_kinds)). Shapes of
    /// other kinds are kept as the file has them, where the format can do that, and the report says so.
    pub kinds: &'a [Arc<dyn ShapeKind>],
    /// The most that is read.
    pub limits: Limits,
    /// The format's own options.
    pub own: Parameters,
    /// Who watches.
    pub observer: &'a dyn Observer,
}

/// The most that is read of a file; what has more is refused ([`FormatErrorKind::Limit`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the file itself.
    pub bytes: u64,
    /// Entities in it, of whatever the format calls one (statements, nodes, rows).
    pub entities: u64,
    /// How far down objects may hang under one another: 1 where none does.
    pub depth: u64,
}

impl Default for Limits {
    /// As many as there are.
    fn default() -> Self {
        Self { bytes: u64::MAX, entities: u64::MAX, depth: u64::MAX }
    }
}

impl Limits {
    /// Refuses more bytes than are read.
    pub(super) fn check_bytes(&self, found: usize) -> Result<(), FormatError> {
        within("the file has", found, self.bytes, "bytes")
    }

    /// Refuses more entities than are read: for readers that can count them beforehand.
    ///
    /// # Errors
    /// Where there are more.
    pub fn check_entities(&self, found: usize) -> Result<(), FormatError> {
        within("there are", found, self.entities, "entities in it")
    }

    /// Refuses objects that hang further down than is read.
    pub(super) fn check_depth(&self, scene: &Scene) -> Result<(), FormatError> {
        within("objects hang under one another", scene.depth()?, self.depth, "levels deep")
    }
}

fn within(there: &str, found: usize, most: u64, what: &str) -> Result<(), FormatError> {
    if found as u64 <= most {
        return Ok(());
    }
    let problem =
        format!("{there} {found} {what}, and at most {most} are asked for: allow more, or split the file");
    Err(FormatError::whole(problem).as_kind(FormatErrorKind::Limit))
}

impl<'a> ReadOptions<'a> {
    /// The kind of shape of a name, among those that the options know.
    pub fn kind(&self, name: &str) -> Option<&'a Arc<dyn ShapeKind>> {
        self.kinds.iter().find(|kind| kind.declaration().name == name)
    }
}

/// Which way is up in the file that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpChoice {
    /// The format's own axis; the numbers are turned where the scene's differs.
    #[default]
    Usual,
    /// Numbers as they are.
    Keep,
    /// This axis.
    To(Up),
}

/// How to write.
#[derive(Clone, Default)]
pub struct WriteOptions<'a> {
    /// The unit of the numbers written; `None` for the scene's, or the format's where it fixes one.
    pub unit: Option<Unit>,
    /// The up axis.
    pub up: UpChoice,
    /// How fine splines are tessellated where the format cannot hold them.
    pub fineness: Fineness,
    /// Who tessellates; `None` leaves such objects out, and the report says so.
    pub tessellator: Option<&'a dyn Tessellator>,
    /// Where the scene's pictures that are files are found, by their names; `None`: they are named and nothing else.
    pub pictures: Option<&'a dyn Source>,
    /// The format's own options.
    pub own: Parameters,
    /// Who watches.
    pub observer: &'a dyn Observer,
}
