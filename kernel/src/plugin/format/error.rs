//! What can be wrong with a file, or with a scene for a format.

use std::fmt;

use crate::declare::ParameterError;
use crate::error::Error;
use crate::plugin::operation::Cancelled;

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

/// What kind of thing is wrong.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FormatErrorKind {
    /// The bytes break the rules of the format, or the scene those of scenes.
    Malformed,
    /// What is there is well formed, but beyond what is read, or what the format holds.
    Unsupported,
    /// There is more than a limit allows.
    Limit,
    /// An option of the format is unknown or wrong.
    Option,
    /// The observer stopped it.
    Cancelled,
    /// The system would not give or take the bytes.
    Io,
}

/// What is wrong with a file, or with a scene for a format: of what kind, where, which object, what, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatError {
    /// What kind of thing.
    pub kind: FormatErrorKind,
    /// The file (a name as the caller gave it); formats leave it empty, and their caller fills it in.
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// The object it belongs to, where known.
    pub object: Option<String>,
    /// What is wrong and what to do.
    pub problem: String,
}

impl FormatError {
    /// Something malformed at a place of the file at hand.
    pub fn new(place: Place, problem: impl Into<String>) -> Self {
        Self {
            kind: FormatErrorKind::Malformed,
            file: String::new(),
            place,
            object: None,
            problem: problem.into(),
        }
    }

    /// Something malformed in the file or the scene as a whole.
    pub fn whole(problem: impl Into<String>) -> Self {
        Self::new(Place::File, problem)
    }

    /// The same error, of another kind.
    #[must_use]
    pub fn as_kind(self, kind: FormatErrorKind) -> Self {
        Self { kind, ..self }
    }

    /// The same error, naming the object.
    #[must_use]
    pub fn of(mut self, object: impl Into<String>) -> Self {
        self.object = Some(object.into());
        self
    }

    /// The same error, naming the file where it names none.
    #[must_use]
    pub fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            file.clone_into(&mut self.file);
        }
        self
    }
}

impl From<Error> for FormatError {
    fn from(error: Error) -> Self {
        let kind = match error {
            Error::UnknownKind { .. } | Error::NoExtent(_) => FormatErrorKind::Unsupported,
            _ => FormatErrorKind::Malformed,
        };
        Self::whole(error.to_string()).as_kind(kind)
    }
}

impl From<ParameterError> for FormatError {
    fn from(error: ParameterError) -> Self {
        Self::whole(error.to_string()).as_kind(FormatErrorKind::Option)
    }
}

impl From<Cancelled> for FormatError {
    fn from(cancelled: Cancelled) -> Self {
        Self::whole(cancelled.to_string()).as_kind(FormatErrorKind::Cancelled)
    }
}

impl From<std::io::Error> for FormatError {
    fn from(error: std::io::Error) -> Self {
        Self::whole(format!("it cannot be written: {error}")).as_kind(FormatErrorKind::Io)
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = Some(self.file.clone()).filter(|file| !file.is_empty());
        let place = Some(self.place.to_string()).filter(|_| self.place != Place::File);
        let object = self.object.as_ref().map(|object| format!("object \"{object}\""));
        let spot: Vec<String> = [file, place, object].into_iter().flatten().collect();
        let colon = if spot.is_empty() { "" } else { ": " };
        write!(f, "{}{colon}{}", spot.join(", "), self.problem)
    }
}

impl std::error::Error for FormatError {}
