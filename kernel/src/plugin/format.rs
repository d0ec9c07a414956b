//! File formats: scenes from bytes and bytes from scenes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::io::Write;
use std::sync::Arc;

use super::operation::{Observer, Quiet};
use crate::declare::{Field, Parameters};
use crate::kind::ShapeKind;
use crate::scene::{Scene, Unit, Up};
use crate::tessellator::{Fineness, Tessellator};

/// What a format is called, and which way it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct FormatDeclaration {
    /// Its name: `"obj"`.
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    /// File extensions without the dot, lower case; compound ones (`"loft.json"`) too. The first is the usual one.
    pub extensions: &'static [&'static str],
    /// Whether it can be read.
    pub reads: bool,
    /// Whether it can be written.
    pub writes: bool,
    /// Whether the main file is text that can go through a pipe.
    pub plain: bool,
    /// Options of its own, for reading and writing. The help of one that only reading or only writing has begins with
    /// `"reading: "` or `"writing: "`; whoever passes options on refuses it on the other way.
    pub options: &'static [Field],
}

impl FormatDeclaration {
    /// The options that reading has.
    pub fn reading_options(&self) -> impl Iterator<Item = &'static Field> + Clone {
        self.options.iter().filter(|option| !option.help.starts_with("writing: "))
    }

    /// The options that writing has.
    pub fn writing_options(&self) -> impl Iterator<Item = &'static Field> + Clone {
        self.options.iter().filter(|option| !option.help.starts_with("reading: "))
    }
}

/// Where in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
    /// A path inside a structured file: `objects[3].curve.knots`.
    Path(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "file"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Path(path) => write!(f, "{path}"),
        }
    }
}

/// What is wrong with a file, or with a scene for a format: where, which object, what, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatError {
    /// The file (a name as the caller gave it).
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// The object it belongs to, where known.
    pub object: Option<String>,
    /// What is wrong and what to do.
    pub problem: String,
}

impl FormatError {
    /// An error at a place of a file.
    pub fn new(file: impl Into<String>, place: Place, problem: impl Into<String>) -> Self {
        Self { file: file.into(), place, object: None, problem: problem.into() }
    }

    /// The same error, naming the object.
    #[must_use]
    pub fn of(mut self, object: impl Into<String>) -> Self {
        self.object = Some(object.into());
        self
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if self.place != Place::File {
            write!(f, ", {}", self.place)?;
        }
        if let Some(object) = &self.object {
            write!(f, ", object \"{object}\"")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for FormatError {}

/// A file to be read, and its siblings by name.
pub trait Source {
    /// The file's name, as messages should give it.
    fn name(&self) -> &str;

    /// Its bytes.
    fn bytes(&self) -> &[u8];

    /// The bytes of another file of the same folder (`.mtl`, `.bin`), never outside it.
    ///
    /// # Errors
    /// When there is none, or the name leads out of the folder.
    fn sibling(&self, name: &str) -> Result<Cow<'_, [u8]>, FormatError>;
}

/// A file to be written, and its siblings by name. Nothing appears before the writer has returned without error.
pub trait Sink {
    /// The file's name without folder: `"part.obj"`.
    fn name(&self) -> &str;

    /// The stream of the file itself.
    fn main(&mut self) -> &mut dyn Write;

    /// The stream of another file of the same folder.
    ///
    /// # Errors
    /// When the name leads out of the folder or is the file's own.
    fn sibling(&mut self, name: &str) -> Result<&mut dyn Write, FormatError>;

    /// Puts a picture that the file names beside it, under that name, which may lead into folders below. It is not ours
    /// to change: what is there under that name with other bytes must stay.
    ///
    /// # Errors
    /// When the name leads out of the folder, or this sink takes no pictures.
    fn picture(&mut self, name: &str, bytes: &[u8]) -> Result<(), FormatError> {
        let problem = format!("the picture \"{name}\" of {} bytes cannot be put beside it here", bytes.len());
        Err(FormatError::new(self.name(), Place::File, problem))
    }
}

/// A source or sink in memory.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    /// The file's name.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Its siblings.
    pub siblings: BTreeMap<String, Vec<u8>>,
    /// Pictures that it names, by their paths below its folder.
    pub pictures: BTreeMap<String, Vec<u8>>,
}

impl Memory {
    /// A file of these bytes without siblings.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into(), ..Self::default() }
    }

    fn check(&self, sibling: &str) -> Result<(), FormatError> {
        let plain = !sibling.is_empty()
            && sibling != self.name
            && !sibling.contains(['/', '\\', '\0'])
            && sibling != "."
            && sibling != "..";
        if plain {
            return Ok(());
        }
        let problem =
            format!("the name \"{}\" of a second file does not stay in the folder", sibling.escape_debug());
        Err(FormatError::new(&self.name, Place::File, problem))
    }
}

impl Source for Memory {
    fn name(&self) -> &str {
        &self.name
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn sibling(&self, name: &str) -> Result<Cow<'_, [u8]>, FormatError> {
        if let Some(picture) = self.pictures.get(&plain_path(name)) {
            return Ok(Cow::Borrowed(picture));
        }
        self.check(name)?;
        self.siblings.get(name).map(|b| Cow::Borrowed(b.as_slice())).ok_or_else(|| {
            FormatError::new(&self.name, Place::File, format!("the file \"{name}\" beside it is missing"))
        })
    }
}

impl Sink for Memory {
    fn name(&self) -> &str {
        &self.name
    }

    fn main(&mut self) -> &mut dyn Write {
        &mut self.bytes
    }

    fn sibling(&mut self, name: &str) -> Result<&mut dyn Write, FormatError> {
        self.check(name)?;
        Ok(self.siblings.entry(name.to_owned()).or_default())
    }

    fn picture(&mut self, name: &str, bytes: &[u8]) -> Result<(), FormatError> {
        // Each part of the path is a name of its own.
        let path = plain_path(name);
        path.split('/').try_for_each(|part| self.check(part))?;
        self.pictures.entry(path).or_insert_with(|| bytes.to_vec());
        Ok(())
    }
}

/// A path below a folder without what says nothing: `./a//b.png` is `a/b.png`. One that begins at the root still does.
fn plain_path(name: &str) -> String {
    let parts = name.split('/').enumerate();
    let said = parts.filter(|(k, part)| *part != "." && (*k == 0 || !part.is_empty()));
    said.map(|(_, part)| part).collect::<Vec<_>>().join("/")
}

/// How to read.
#[derive(Clone)]
pub struct ReadOptions<'a> {
    /// The unit to note instead of what the file says (or does not say).
    pub unit: Option<Unit>,
    /// The up axis to note instead of what the format says.
    pub up: Option<Up>,
    /// The kinds of shape that plug-ins bring ([`Registry::shape_kinds`](super::Registry::shape_kinds)). Shapes of
    /// other kinds are kept as the file has them, where the format can do that, and the report says so.
    pub kinds: &'a [Arc<dyn ShapeKind>],
    /// The format's own options.
    pub own: Parameters,
    /// Who watches.
    pub observer: &'a dyn Observer,
}

impl<'a> ReadOptions<'a> {
    /// The kind of shape of a name, among those that the options know.
    pub fn kind(&self, name: &str) -> Option<&'a Arc<dyn ShapeKind>> {
        self.kinds.iter().find(|kind| kind.declaration().name == name)
    }
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        Self { unit: None, up: None, kinds: &[], own: Parameters::empty("options"), observer: &Quiet }
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
#[derive(Clone)]
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

impl Default for WriteOptions<'_> {
    fn default() -> Self {
        Self {
            unit: None,
            up: UpChoice::Usual,
            fineness: Fineness::default(),
            tessellator: None,
            pictures: None,
            own: Parameters::empty("options"),
            observer: &Quiet,
        }
    }
}

/// What became of an entity of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// It is in the scene, exactly.
    Kept,
    /// It is in the scene, changed or approximated.
    Approximated,
    /// It is not in the scene.
    LeftOut,
}

/// What a reader found, kept and left out: every entity of the file is counted once.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct ReadReport {
    /// Entities in the file, of whatever the format calls one (statements, nodes, rows).
    pub entities: usize,
    /// Those that are in the scene exactly.
    pub kept: usize,
    /// Those that are in the scene changed, with why; grouped by reason.
    pub approximated: BTreeMap<String, usize>,
    /// Those that are not in the scene, with why; grouped by reason.
    pub left_out: BTreeMap<String, usize>,
    /// Anything else worth saying (a unit assumed, an axis noted).
    pub notes: Vec<String>,
}

impl ReadReport {
    /// Counts one entity.
    pub fn count(&mut self, fate: Fate, reason: &str) {
        self.count_many(fate, reason, 1);
    }

    /// Counts several entities of one fate.
    pub fn count_many(&mut self, fate: Fate, reason: &str, count: usize) {
        if count == 0 {
            return;
        }
        self.entities += count;
        match fate {
            Fate::Kept => self.kept += count,
            Fate::Approximated => *self.approximated.entry(reason.to_owned()).or_default() += count,
            Fate::LeftOut => *self.left_out.entry(reason.to_owned()).or_default() += count,
        }
    }

    /// Whether kept, approximated and left out add up to the entities found.
    pub fn adds_up(&self) -> bool {
        self.entities
            == self.kept + self.approximated.values().sum::<usize>() + self.left_out.values().sum::<usize>()
    }
}

/// How one object went out.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Written {
    /// The object.
    pub object: String,
    /// As what: `"NURBS curve"`, `"1200 triangles"`, `"line strip"`.
    pub form: String,
    /// Exactly, approximated, or not at all.
    pub fate: Fate,
    /// The chord tolerance in the scene's unit, where approximated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// How far the triangles of a surface are from it at most, in the scene's unit: what the tessellator has certified,
    /// before coordinates are rounded to those of the format.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Why, where not exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What a writer wrote, object by object.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct WriteReport {
    /// Every object of the scene.
    pub objects: Vec<Written>,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

/// A file format.
pub trait Format: Send + Sync {
    /// Its name, extensions and options.
    fn declaration(&self) -> FormatDeclaration;

    /// Whether the first bytes of a file (up to 4096 of them) look like this format.
    fn recognises(&self, head: &[u8]) -> bool {
        let _ = head;
        false
    }

    /// The scene of a file, and an account of every entity in it.
    ///
    /// # Errors
    /// When the bytes are not this format, or break its rules; with the place.
    fn read(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError>;

    /// Writes a scene.
    ///
    /// # Errors
    /// When the format cannot hold the scene at all, or the sink fails.
    fn write(
        &self,
        scene: &Scene,
        sink: &mut dyn Sink,
        options: &WriteOptions<'_>,
    ) -> Result<WriteReport, FormatError>;
}
