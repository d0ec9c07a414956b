//! Lines, statements and words of an OBJ or MTL file.

use std::borrow::Cow;

use loftsman_kernel::text::{Encoding, clip_to, decoded, unmarked};
use memchr::memchr2;

/// The file as UTF-8: UTF-16 with a byte order mark is decoded, and what is older than either, which is told.
pub(crate) fn decode(bytes: &[u8]) -> (Cow<'_, [u8]>, Option<Encoding>) {
    let wide = |big: bool| {
        let units = bytes[2..].chunks_exact(2).map(|pair| {
            if big { u16::from_be_bytes([pair[0], pair[1]]) } else { u16::from_le_bytes([pair[0], pair[1]]) }
        });
        let text: String =
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        (Cow::Owned(text.into_bytes()), None)
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(false),
        [0xfe, 0xff, ..] => wide(true),
        _ => decoded(unmarked(bytes)),
    }
}

/// The length of the first line of a text with its end, `\n`, `\r\n` or `\r`.
pub(crate) fn line_length(text: &[u8]) -> usize {
    match memchr2(b'\n', b'\r', text) {
        None => text.len(),
        Some(end) => end + 1 + usize::from(text[end] == b'\r' && text.get(end + 1) == Some(&b'\n')),
    }
}

/// Whether a line goes on on the next: its last character that is no blank is a backslash.
fn goes_on(line: &[u8]) -> bool {
    match line.last() {
        // Nearly every line ends in a digit or a letter, perhaps before one line end.
        Some(&last) if last > b' ' => last == b'\\',
        _ => line.trim_ascii_end().last() == Some(&b'\\'),
    }
}

/// Whether a line, with its end, surely ends a statement.
pub(crate) fn ends_statement(line: &[u8]) -> bool {
    !goes_on(line)
}

/// The start of a comment that means something: vertex colours of ZBrush.
pub(crate) const MRGB: &[u8] = b"#MRGB";

/// The start of a comment that was written here, and says what OBJ has no statement for.
pub(crate) const OURS: &[u8] = b"# Loftsman ";

/// Whether a comment means something.
fn speaks(comment: &[u8]) -> bool {
    comment.starts_with(MRGB) || comment.starts_with(OURS)
}

/// The statements of a text: lines joined where they end in a backslash, each with the number of its first line; and
/// the comments that start with [`MRGB`] or [`OURS`]. Without blanks in front; a comment may still follow, where the statement is
/// one line: [`uncommented`] takes it off.
pub(crate) struct Statements<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Statements<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, line: 0 }
    }

    /// The number of lines looked at so far.
    pub(crate) fn lines(&self) -> usize {
        self.line
    }

    /// The number of bytes that have not been looked at yet.
    pub(crate) fn left(&self) -> usize {
        self.rest.len()
    }

    fn line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.line += 1;
        let (line, rest) = self.rest.split_at(line_length(self.rest));
        self.rest = rest;
        Some(line.trim_ascii_start())
    }

    /// A line that goes on, and the lines that it goes on with.
    #[cold]
    fn joined(&mut self, first: &'a [u8]) -> Vec<u8> {
        let mut joined = Vec::new();
        let mut line = first;
        loop {
            let text = if line.first() == Some(&b'#') { &[] } else { uncommented(line) };
            let Some((b'\\', before)) = text.split_last() else {
                joined.extend_from_slice(text);
                return joined;
            };
            joined.extend_from_slice(before);
            joined.push(b' ');
            match self.line() {
                Some(next) => line = next,
                None => return joined,
            }
        }
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let line = self.line()?;
            match line.first() {
                None => continue,
                Some(b'#') if !speaks(line) => continue,
                Some(b'#') => return Some((self.line, Cow::Borrowed(line))),
                Some(_) if !goes_on(line) => return Some((self.line, Cow::Borrowed(line))),
                Some(_) => {}
            }
            let number = self.line;
            let mut joined = self.joined(line);
            // A line of nothing but a backslash leaves a blank in front.
            let blanks = joined.len() - joined.trim_ascii_start().len();
            if blanks < joined.len() {
                joined.drain(..blanks);
                return Some((number, Cow::Owned(joined)));
            }
        }
    }
}

/// A statement without the comment and the blanks behind it. Names may hold a number sign: a comment follows a blank.
pub(crate) fn uncommented(line: &[u8]) -> &[u8] {
    let comment = line.windows(2).position(|w| w[1] == b'#' && w[0].is_ascii_whitespace());
    comment.map_or(line, |at| &line[..at]).trim_ascii_end()
}

/// The keyword of a statement and what follows it.
pub(crate) fn keyword(statement: &[u8]) -> (&[u8], &[u8]) {
    let statement = statement.trim_ascii_start();
    let end = statement.iter().position(u8::is_ascii_whitespace).unwrap_or(statement.len());
    (&statement[..end], &statement[end..])
}

/// What white space separates in a text.
pub(crate) fn tokens(text: &[u8]) -> impl Iterator<Item = &[u8]> + '_ {
    text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A piece of the file for a message: short, one line, printable.
pub(crate) fn show(word: &[u8]) -> String {
    clip_to(40, &String::from_utf8_lossy(&word[..word.len().min(200)]))
}

/// A name as the file has it, without what no name may hold.
pub(crate) fn name(text: &[u8]) -> String {
    String::from_utf8_lossy(text.trim_ascii()).chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_join_lines_drop_comments_and_count() {
        let text =
            b"# C:\\tmp\\\r\nv 1 2 \\\r\n 3 # here\\\r\n\r\n  mtllib a#b.mtl\rp 1\\ \n\nl 1 # 2\\\nlast \\";
        let found: Vec<(usize, String)> = Statements::new(text)
            .map(|(line, s)| {
                let words: Vec<_> = tokens(uncommented(&s)).map(String::from_utf8_lossy).collect();
                (line, words.join(" "))
            })
            .collect();
        let expected = [(2, "v 1 2 3"), (5, "mtllib a#b.mtl"), (6, "p 1"), (8, "l 1"), (9, "last")];
        assert_eq!(found, expected.map(|(n, s)| (n, s.to_owned())));
        // A line of nothing but a backslash goes on, too, and leaves nothing in front.
        let alone: Vec<_> = Statements::new(b"\\\nv 1 2 3\n \\ \n\\\n f 1\n\\\n").collect();
        let alone: Vec<(usize, &[u8])> = alone.iter().map(|(line, s)| (*line, s.trim_ascii_end())).collect();
        assert_eq!(alone, [(1, &b"v 1 2 3"[..]), (3, &b"f 1"[..])]);
    }

    #[test]
    fn utf_16_is_decoded() {
        for big in [false, true] {
            let bytes = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
            let wide: Vec<u8> =
                [0xfeff_u16].into_iter().chain("v 1".encode_utf16()).flat_map(bytes).collect();
            assert_eq!(decode(&wide).0.as_ref(), b"v 1");
        }
    }
}
