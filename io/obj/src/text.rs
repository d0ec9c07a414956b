//! Lines and words of an OBJ or MTL file.

use std::borrow::Cow;

/// The file as text in UTF-8 or any of its supersets of ASCII: UTF-16 with a byte order mark is decoded.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, [u8]> {
    let wide = |big: bool| {
        let units = bytes[2..].chunks_exact(2).map(|pair| {
            if big { u16::from_be_bytes([pair[0], pair[1]]) } else { u16::from_le_bytes([pair[0], pair[1]]) }
        });
        let text: String =
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        Cow::Owned(text.into_bytes())
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(false),
        [0xfe, 0xff, ..] => wide(true),
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        _ => Cow::Borrowed(bytes),
    }
}

/// The statements of a file: lines joined where they end in a backslash, without comments, never empty; each
/// with the number of its first line.
pub(crate) struct Statements<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Statements<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, line: 0 }
    }

    /// The number of bytes that have not been looked at yet.
    pub(crate) fn left(&self) -> usize {
        self.rest.len()
    }

    /// One line without its end, comment and outer blanks, and whether it goes on on the next.
    fn line(&mut self) -> Option<(&'a [u8], bool)> {
        if self.rest.is_empty() {
            return None;
        }
        self.line += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        let gap = match self.rest[end..] {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        self.rest = &self.rest[end + gap..];
        let line = line.trim_ascii_start();
        if line.first() == Some(&b'#') {
            return Some((&[], false));
        }
        // Names may hold a number sign; a comment after a statement follows a blank.
        let comment = line.windows(2).position(|w| w[1] == b'#' && w[0].is_ascii_whitespace());
        let line = comment.map_or(line, |at| &line[..at]).trim_ascii_end();
        Some(match line.split_last() {
            Some((b'\\', before)) => (before, true),
            _ => (line, false),
        })
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (line, more) = self.line()?;
            let number = self.line;
            if !more {
                if line.is_empty() {
                    continue;
                }
                return Some((number, Cow::Borrowed(line)));
            }
            let mut joined = line.to_vec();
            while let Some((next, more)) = self.line() {
                joined.push(b' ');
                joined.extend_from_slice(next);
                if !more {
                    break;
                }
            }
            if !joined.trim_ascii().is_empty() {
                return Some((number, Cow::Owned(joined)));
            }
        }
    }
}

/// The keyword of a statement and what follows it.
pub(crate) fn keyword(statement: &[u8]) -> (&[u8], &[u8]) {
    let statement = statement.trim_ascii_start();
    let end = statement.iter().position(u8::is_ascii_whitespace).unwrap_or(statement.len());
    (&statement[..end], statement[end..].trim_ascii())
}

/// The words of a text.
pub(crate) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> + '_ {
    text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A piece of the file for a message: short, one line, printable.
pub(crate) fn show(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(200)]);
    let mut short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().count() > 40 {
        short.push_str("...");
    }
    short
}

/// A finite number.
pub(crate) fn number(word: &[u8]) -> Result<f64, String> {
    let value = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok());
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(value) => Err(format!("the number \"{}\" is {value}: every number must be finite", show(word))),
        None => Err(format!("\"{}\" is not a number", show(word))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_join_lines_drop_comments_and_count() {
        let text = b"# C:\\tmp\\\r\nv 1 2 \\\r\n 3 # here\r\n\r\n  mtllib a#b.mtl\rp 1\\\n\nlast \\";
        let found: Vec<(usize, String)> = Statements::new(text)
            .map(|(line, s)| {
                (line, words(&s).map(|w| String::from_utf8_lossy(w)).collect::<Vec<_>>().join(" "))
            })
            .collect();
        let expected = [(2, "v 1 2 3"), (5, "mtllib a#b.mtl"), (6, "p 1"), (8, "last")];
        assert_eq!(found, expected.map(|(n, s)| (n, s.to_owned())));
    }

    #[test]
    fn numbers_are_finite_or_errors() {
        for (text, value) in [("+1.", 1.0), ("-.5", -0.5), ("2.e1", 20.0), ("1E-2", 0.01)] {
            assert_eq!(number(text.as_bytes()), Ok(value));
        }
        for text in ["nan", "inf", "1e999", "3.1+e2", "0x10", "1,5", ""] {
            assert!(number(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn utf_16_is_decoded() {
        let wide: Vec<u8> =
            [0xfeff_u16].into_iter().chain("v 1".encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(decode(&wide).as_ref(), b"v 1");
    }
}
