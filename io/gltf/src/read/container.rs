//! The two containers: JSON as a text, and GLB, which holds the JSON and the bytes of the first buffer.

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Place, refuse_utf16, utf8};
use loftsman_kernel::text::counted;
use loftsman_kernel::text::unmarked;

/// A file taken apart.
pub(super) struct Parts<'a> {
    /// The JSON, without a byte order mark.
    pub(super) json: &'a str,
    /// The BIN chunk of a GLB.
    pub(super) binary: Option<&'a [u8]>,
    /// What was passed over.
    pub(super) notes: Vec<String>,
    /// Chunks of types that the standard does not know, which a reader has to ignore.
    pub(super) unknown_chunks: usize,
}

const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// Takes a file apart: GLB by its magic number, else a text.
pub(super) fn parts(bytes: &[u8]) -> Result<Parts<'_>, FormatError> {
    if bytes.starts_with(MAGIC) {
        return glb(bytes);
    }
    refuse_utf16(bytes, 0)?;
    let start = unmarked(bytes).trim_ascii_start();
    if !start.is_empty() && !start.starts_with(b"{") {
        let problem = "this is neither a GLB, which starts with the letters glTF, nor a glTF text, which starts with {: get the \
                       file again, or name it for what it is";
        return Err(FormatError::new(Place::Byte(0), problem));
    }
    let json = text(bytes, 0)?;
    Ok(Parts { json, binary: None, notes: Vec::new(), unknown_chunks: 0 })
}

/// UTF-8 without its byte order mark; `start` is where in the file the bytes are.
fn text(bytes: &[u8], start: usize) -> Result<&str, FormatError> {
    let text = utf8(bytes, start)?;
    if text.trim().is_empty() {
        return Err(FormatError::new(Place::Byte(start), "there is no JSON in it: get the file again"));
    }
    Ok(text)
}

fn glb(bytes: &[u8]) -> Result<Parts<'_>, FormatError> {
    let fail = |at: usize, problem: String| Err(FormatError::new(Place::Byte(at), problem));
    let word = |at: usize| -> Option<u32> {
        bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return fail(0, format!("the GLB ends within its header, after {} bytes: get it again", bytes.len()));
    };
    if version != 2 {
        let problem =
            format!("GLB of version {version}; only version 2 is read: convert it to glTF 2.0 first");
        return Err(FormatError::new(Place::Byte(4), problem).as_kind(FormatErrorKind::Unsupported));
    }
    let mut notes = Vec::new();
    let length = length as usize;
    if length > bytes.len() {
        let missing = length - bytes.len();
        return fail(
            8,
            format!("the GLB says it has {length} bytes, but {missing} are missing: get it again"),
        );
    }
    if length < bytes.len() {
        notes.push(counted(bytes.len() - length, "byte[|s] after the end of the GLB [was|were] passed over"));
    }
    let (mut json, mut binary, mut unknown_chunks) = (None, None, 0);
    let mut at = 12;
    while at < length {
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return fail(at, "the GLB ends within the header of a chunk: get it again".to_owned());
        };
        let end = (at + 8).saturating_add(size as usize);
        let Some(chunk) = bytes.get(at + 8..end).filter(|_| end <= length) else {
            let left = length.saturating_sub(at + 8);
            return fail(
                at,
                format!("a chunk of {size} bytes where the GLB has only {left} left: get it again"),
            );
        };
        match kind {
            JSON if json.is_none() => json = Some((chunk, at + 8)),
            BIN if json.is_some() && binary.is_none() => binary = Some(chunk),
            _ if json.is_none() => {
                return fail(at, "the first chunk of a GLB must be its JSON: the file is damaged".to_owned());
            }
            _ => unknown_chunks += 1,
        }
        at = end;
    }
    let Some((chunk, start)) = json else { return fail(12, "the GLB has no JSON: get it again".to_owned()) };
    let json = text(chunk, start)?;
    // Padding with zeros is against the standard, but harmless.
    Ok(Parts { json: json.trim_end_matches('\0'), binary, notes, unknown_chunks })
}
