//! Lines of 80 columns: 72 of data, the letter of the section, a number.

use std::borrow::Cow;

/// Where the letter of the section stands.
const LETTER: usize = 72;
/// Columns between the stops of a tab.
const TAB: usize = 8;

/// A section, by its letter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Section {
    Start,
    Global,
    Directory,
    Parameters,
    Terminate,
}

impl Section {
    fn of(letter: u8) -> Option<Self> {
        Some(match letter {
            b'S' => Self::Start,
            b'G' => Self::Global,
            b'D' => Self::Directory,
            b'P' => Self::Parameters,
            b'T' => Self::Terminate,
            _ => return None,
        })
    }
}

/// One line of a file.
#[derive(Debug, Clone)]
pub(crate) struct Line<'f> {
    /// Its number in the file, from 1.
    pub(crate) number: usize,
    /// Where it starts in the file.
    pub(crate) at: usize,
    /// All of it but its end; tabs are blanks here.
    pub(crate) text: Cow<'f, [u8]>,
}

/// The lines of a file, which end with LF, CR LF or CR; blank ones are left out.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let (mut at, mut number) = (0, 0);
    std::iter::from_fn(move || {
        loop {
            if at >= bytes.len() {
                return None;
            }
            let (start, rest) = (at, &bytes[at..]);
            let end = rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
            let crlf = rest[end..].starts_with(b"\r\n");
            at += end + if crlf { 2 } else { 1 };
            number += 1;
            let text = expanded(&rest[..end]);
            if !text.trim_ascii().is_empty() {
                return Some(Line { number, at: start, text });
            }
        }
    })
}

/// The line that starts at a place of a file.
pub(crate) fn line_at(bytes: &[u8], at: usize) -> Cow<'_, [u8]> {
    let rest = bytes.get(at..).unwrap_or_default();
    let end = rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    expanded(&rest[..end])
}

/// Tabs as blanks up to the next stop.
fn expanded(text: &[u8]) -> Cow<'_, [u8]> {
    if !text.contains(&b'\t') {
        return Cow::Borrowed(text);
    }
    let mut plain = Vec::with_capacity(text.len() + TAB);
    for &b in text {
        if b == b'\t' {
            let to = (plain.len() / TAB + 1) * TAB;
            plain.resize(to, b' ');
        } else {
            plain.push(b);
        }
    }
    Cow::Owned(plain)
}

/// The section of a line, where the letter stands, and the number behind it. Lines of writers that padded with too few or too
/// many blanks have the letter elsewhere: before the number at their end.
pub(crate) fn section(text: &[u8]) -> Option<(Section, usize, Option<u32>)> {
    let number = |from: usize| {
        let text = text.get(from..).unwrap_or_default();
        std::str::from_utf8(text.trim_ascii()).ok().and_then(|text| text.parse().ok())
    };
    if let Some(section) = text.get(LETTER).and_then(|&letter| Section::of(letter)) {
        let behind = text.get(LETTER + 1..).unwrap_or_default();
        if behind.iter().all(|b| b.is_ascii_digit() || b.is_ascii_whitespace()) {
            return Some((section, LETTER, number(LETTER + 1)));
        }
    }
    let at = text.iter().rposition(|b| !(b.is_ascii_digit() || b.is_ascii_whitespace()))?;
    let number = number(at + 1)?;
    Some((Section::of(text[at])?, at, Some(number)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_ends() {
        let found: Vec<_> =
            lines(b"a\r\nb\n\n\rc\td\r").map(|l| (l.number, l.at, l.text.into_owned())).collect();
        let expected = [(1, 0, b"a".to_vec()), (2, 3, b"b".to_vec()), (5, 7, b"c       d".to_vec())];
        assert_eq!(found, expected);
    }

    #[test]
    fn letters_are_found_where_they_should_not_be() {
        let line = format!("{:<72}S      1", "text");
        assert_eq!(section(line.as_bytes()), Some((Section::Start, 72, Some(1))));
        assert_eq!(section(&line.as_bytes()[..73]), Some((Section::Start, 72, None)));
        assert_eq!(section(b"text   G     12"), Some((Section::Global, 7, Some(12))));
        let long = format!("{:<75}P      7  ", "1,2;");
        assert_eq!(section(long.as_bytes()), Some((Section::Parameters, 75, Some(7))));
        assert_eq!(section(b"some words"), None);
        assert_eq!(section(b"ends with D"), None);
    }
}
