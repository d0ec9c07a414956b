//! Lines and the fields in them.

use loftsman_kernel::text::clip_to;

/// The lines of a text, whether they end with `\n`, `\r\n` or `\r`, numbered from 1, without blanks around them.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    // Old Macintosh files have carriage returns only; in all others those are blanks at the end of a line.
    let end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    text.split(move |&b| b == end).enumerate().map(|(i, line)| (i + 1, trim(line)))
}

/// Without blanks, and without the end-of-file mark of DOS.
fn trim(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii();
    line.strip_suffix(&[0x1A]).map_or(line, <[u8]>::trim_ascii_end)
}

/// What separates the fields of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    /// Blanks and tabs.
    Blanks,
    /// A comma, with or without blanks.
    Comma,
    /// A semicolon, with or without blanks.
    Semicolon,
}

impl Separator {
    /// The separator that a line shows. A comma is a decimal sign if blanks separate and it stands between
    /// digits in every place.
    pub(super) fn of(line: &[u8]) -> Self {
        if line.contains(&b';') {
            return Self::Semicolon;
        }
        if !line.contains(&b',') {
            return Self::Blanks;
        }
        let decimal = |token: &[u8]| {
            let mut parts = token.split(|&b| b == b',');
            let whole = parts.next().unwrap_or_default();
            let rest = parts.next();
            let ends = whole.last().is_some_and(u8::is_ascii_digit);
            let goes_on = rest.is_none_or(|rest| rest.first().is_some_and(u8::is_ascii_digit));
            ends && goes_on && parts.next().is_none()
        };
        let tokens = || line.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty());
        if tokens().count() > 1 && tokens().all(decimal) { Self::Blanks } else { Self::Comma }
    }

    /// Whether a comma inside a field is a decimal sign.
    pub(super) fn allows_comma(self) -> bool {
        self != Self::Comma
    }

    /// The fields of a line. An empty one behind the last separator does not count.
    pub(super) fn fields(self, line: &[u8]) -> Fields<'_> {
        Fields { rest: Some(line), separator: self }
    }
}

/// The fields of a line, without quotes and blanks around them.
pub(super) struct Fields<'l> {
    rest: Option<&'l [u8]>,
    separator: Separator,
}

impl<'l> Iterator for Fields<'l> {
    type Item = &'l [u8];

    fn next(&mut self) -> Option<&'l [u8]> {
        let line = self.rest?.trim_ascii_start();
        if line.is_empty() {
            self.rest = None;
            return None;
        }
        let separator = match self.separator {
            Separator::Blanks => {
                let (field, rest) = quoted(line).unwrap_or_else(|| {
                    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
                    line.split_at(end)
                });
                self.rest = Some(rest);
                return Some(field);
            }
            Separator::Comma => b',',
            Separator::Semicolon => b';',
        };
        // Behind a closing quote comes the separator; where something else does, the quotes are plain text.
        let (field, rest) = quoted(line)
            .map(|(field, rest)| (field, rest.trim_ascii_start()))
            .filter(|(_, rest)| rest.is_empty() || rest[0] == separator)
            .unwrap_or_else(|| {
                let end = line.iter().position(|&b| b == separator).unwrap_or(line.len());
                (line[..end].trim_ascii_end(), &line[end..])
            });
        self.rest = rest.get(1..);
        Some(field)
    }
}

/// A field in double quotes at the start of a line, and what follows it.
fn quoted(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let inside = line.strip_prefix(b"\"")?;
    let end = inside.iter().position(|&b| b == b'"')?;
    Some((&inside[..end], &inside[end + 1..]))
}

/// The comment in a line, if all of it is one.
pub(super) fn comment(line: &[u8]) -> Option<&[u8]> {
    line.strip_prefix(b"#")
        .or_else(|| line.strip_prefix(b"!"))
        .or_else(|| line.strip_prefix(b"%"))
        .or_else(|| line.strip_prefix(b"//"))
}

/// A line without the comment at its end, which has a blank before it (`12% thick` is none).
pub(super) fn before_comment(line: &[u8]) -> &[u8] {
    let starts = |w: &[u8]| w[0].is_ascii_whitespace() && matches!(w[1], b'#' | b'!' | b'%');
    match line.windows(2).position(starts) {
        Some(end) => line[..end].trim_ascii_end(),
        None => line,
    }
}

/// Bytes of a text that has been decoded; those of the head of a file, which has not, may have characters cut off.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The start of a text, on one line, for messages.
pub(super) fn clip(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    clip_to(LONGEST, &text(&bytes[..bytes.len().min(4 * LONGEST)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(separator: Separator, line: &str) -> Vec<String> {
        separator.fields(line.as_bytes()).map(text).collect()
    }

    #[test]
    fn separators_show() {
        for (line, separator) in [
            ("1 2", Separator::Blanks),
            ("1\t2", Separator::Blanks),
            ("1,5", Separator::Comma),
            ("1, 2", Separator::Comma),
            ("1 ,2", Separator::Comma),
            ("1.5,2.5", Separator::Comma),
            ("1,5 2,5", Separator::Blanks),
            ("1,5\t2", Separator::Blanks),
            ("1,2,3 4,5,6", Separator::Comma),
            ("1,5;2,5", Separator::Semicolon),
        ] {
            assert_eq!(Separator::of(line.as_bytes()), separator, "{line}");
        }
    }

    #[test]
    fn fields_come_without_quotes_and_blanks() {
        assert_eq!(split(Separator::Comma, "\"Points:0\" , \"a,b\",c ,"), ["Points:0", "a,b", "c"]);
        assert_eq!(split(Separator::Semicolon, "1; ;3"), ["1", "", "3"]);
        assert_eq!(split(Separator::Blanks, "1\t 2  \"a b\" 3"), ["1", "2", "a b", "3"]);
        assert_eq!(split(Separator::Comma, "\"open, 2"), ["\"open", "2"]);
        assert_eq!(split(Separator::Comma, "\"1\"5,2"), ["\"1\"5", "2"]);
        assert!(split(Separator::Comma, "").is_empty());
    }

    #[test]
    fn every_kind_of_line_end() {
        for text in ["a\nb\n", "a\r\nb", "a\rb\r", "a\nb\x1A"] {
            let found: Vec<_> = lines(text.as_bytes()).filter(|(_, l)| !l.is_empty()).collect();
            assert_eq!(found, [(1, &b"a"[..]), (2, b"b")]);
        }
    }
}
