//! What recipes and the program ask of pictures, where the feature `picture` is off: each is refused with what to do.

use std::path::Path;

use loftsman_kernel::plugin::{Field, Mark, ParameterError, Parameters, Registry};
use loftsman_kernel::scene::Scene;

use crate::error::{Error, Result};
pub use crate::picture_name::is_picture;

/// Why there are none, and what to do.
pub const ABSENT: &str = "pictures were left out of this build: build it with its feature `picture`, as `cargo build --release` does";

/// The fields of a recipe's table `picture`: none.
pub const FIELDS: &[Field] = &[];

/// How a picture is to look: no picture has one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Look {
    /// Marks of what was asked.
    pub marks: bool,
    /// Whether the points are shown that something was fitted to.
    pub points: bool,
}

impl Look {
    /// Refuses a table.
    ///
    /// # Errors
    /// Always.
    pub fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        // The error names the table itself.
        Err(fields.error("", ABSENT))
    }

    /// The same: there is no moment of what is not drawn.
    #[must_use]
    pub fn at(self, _: f64) -> Self {
        self
    }

    /// What was asked for and is not drawn: nothing is.
    pub fn unmet(&self, _: &Scene) -> Vec<String> {
        Vec::new()
    }

    /// Nothing is drawn, so that nothing is missing.
    #[allow(clippy::unused_self, reason = "as with pictures")]
    pub(crate) fn absent(&self, _: &Scene) -> Option<(String, String)> {
        None
    }
}

/// Refuses a picture.
///
/// # Errors
/// Where the file is to be one.
pub fn check(path: &Path) -> Result<()> {
    if is_picture(path) { Err(Error::file(path.display().to_string(), ABSENT)) } else { Ok(()) }
}

/// Refuses a picture.
///
/// # Errors
/// Always.
pub fn draw(
    path: &Path,
    _: &Look,
    _: &Scene,
    _: Option<&Scene>,
    _: &[Mark],
    _: &Registry,
) -> Result<(Vec<u8>, Vec<String>)> {
    Err(Error::file(path.display().to_string(), ABSENT))
}
