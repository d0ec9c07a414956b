//! Files as formats see them: bytes by name, and their siblings.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;

use super::error::{FormatError, FormatErrorKind, Place};
use crate::text::{clip, unmarked};

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
        Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported))
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
        let problem = format!("the name \"{}\" of a second file does not stay in the folder", clip(sibling));
        Err(FormatError::whole(problem))
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
        let found = self.siblings.get(name).map(|b| Cow::Borrowed(b.as_slice()));
        found.ok_or_else(|| FormatError::whole(format!("the file \"{}\" beside it is missing", clip(name))))
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

/// The text of bytes that are UTF-8, without a byte order mark. `start` is where in the file they are.
///
/// # Errors
/// When they are not, with the line and the byte.
pub fn utf8(bytes: &[u8], start: usize) -> Result<&str, FormatError> {
    refuse_utf16(bytes, start)?;
    let text = unmarked(bytes);
    std::str::from_utf8(text).map_err(|error| {
        let good = &text[..error.valid_up_to()];
        let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
        let byte = start + bytes.len() - text.len() + good.len();
        let problem = match error.error_len() {
            // Nothing is wrong but that a letter's last bytes are missing.
            None => format!(
                "it ends in the middle of a letter, at byte {byte}: it was cut off, or is in another encoding than UTF-8"
            ),
            Some(_) => {
                format!("byte {byte} is not UTF-8: this is no text, or one in another encoding; save it as UTF-8")
            }
        };
        FormatError::new(Place::Line(line), problem)
    })
}

/// Refuses UTF-16, as far as a byte order mark shows it. `start` is where in the file the bytes are.
///
/// # Errors
/// Where it is.
pub fn refuse_utf16(bytes: &[u8], start: usize) -> Result<(), FormatError> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        let problem = "the text is UTF-16: save it again as UTF-8";
        return Err(FormatError::new(Place::Byte(start), problem).as_kind(FormatErrorKind::Unsupported));
    }
    Ok(())
}
