//! Entities as text: two lines in the directory and their parameters, in lines of 64 columns.

use loftsman_kernel::plugin::{FormatError, FormatErrorKind};
use loftsman_kernel::text;

/// Columns of a line of parameters that are data.
const DATA: usize = 64;
/// Columns of a line of the global section.
const GLOBAL: usize = 72;
/// Numbers of lines have seven digits.
const MOST: usize = 9_999_999;

/// What the directory says of an entity, beside its type.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Look {
    pub(crate) form: i32,
    /// The number of a colour entity.
    pub(crate) color: Option<u32>,
    pub(crate) level: i32,
    /// The number of a matrix.
    pub(crate) matrix: Option<u32>,
    pub(crate) blank: bool,
    pub(crate) owned: bool,
    pub(crate) purpose: Purpose,
}

/// What an entity is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Purpose {
    #[default]
    Geometry = 0,
    Definition = 2,
    Other = 3,
    /// A curve in the parameters of a surface.
    Parametric = 5,
}

impl Look {
    /// A part of another entity.
    pub(crate) const PART: Self = Self {
        form: 0,
        color: None,
        level: 0,
        matrix: None,
        blank: false,
        owned: true,
        purpose: Purpose::Geometry,
    };

    pub(crate) fn form(self, form: i32) -> Self {
        Self { form, ..self }
    }

    pub(crate) fn purpose(self, purpose: Purpose) -> Self {
        Self { purpose, ..self }
    }
}

/// The parameters of one entity.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    kind: u32,
    tokens: Vec<Vec<u8>>,
}

impl Record {
    pub(crate) fn new(kind: u32) -> Self {
        Self { kind, tokens: vec![kind.to_string().into_bytes()] }
    }

    pub(crate) fn whole(mut self, number: i64) -> Self {
        self.tokens.push(number.to_string().into_bytes());
        self
    }

    pub(crate) fn count(self, count: usize) -> Self {
        self.whole(i64::try_from(count).unwrap_or(i64::MAX))
    }

    pub(crate) fn entity(self, number: u32) -> Self {
        self.whole(i64::from(number))
    }

    pub(crate) fn entities(self, numbers: &[u32]) -> Self {
        numbers.iter().fold(self, |record, &number| record.entity(number))
    }

    pub(crate) fn real(mut self, number: f64) -> Self {
        self.tokens.push(real(number).into_bytes());
        self
    }

    pub(crate) fn reals<'n>(self, numbers: impl IntoIterator<Item = &'n f64>) -> Self {
        numbers.into_iter().fold(self, |record, &number| record.real(number))
    }

    pub(crate) fn text(mut self, words: &str) -> Self {
        self.tokens.push(hollerith(words));
        self
    }

    /// What is said of the entity: nothing that it is associated with, and these properties.
    pub(crate) fn properties(self, numbers: &[u32]) -> Self {
        if numbers.is_empty() { self } else { self.whole(0).count(numbers.len()).entities(numbers) }
    }
}

/// A text with its length.
fn hollerith(words: &str) -> Vec<u8> {
    let plain = plain(words);
    if plain.is_empty() {
        return Vec::new();
    }
    [format!("{}H", plain.len()).as_bytes(), plain.as_bytes()].concat()
}

/// A text as it comes back: without line breaks and the like, and without blanks around it.
pub(crate) fn plain(words: &str) -> String {
    let shown = words.chars().map(|c| if c.is_control() { ' ' } else { c });
    shown.collect::<String>().trim().to_owned()
}

/// A number with a point, as the format wants it, in double precision; it reads back as the same bits.
pub(crate) fn real(x: f64) -> String {
    let mut digits = Vec::new();
    // Writing to a list cannot fail, and digits are ASCII.
    let _ = text::number(&mut digits, x);
    let plain = String::from_utf8_lossy(&digits).into_owned();
    match plain.split_once('e') {
        Some((mantissa, exponent)) if mantissa.contains('.') => format!("{mantissa}D{exponent}"),
        Some((mantissa, exponent)) => format!("{mantissa}.D{exponent}"),
        None if plain.contains('.') => plain,
        None => plain + ".",
    }
}

/// Whether a line of so many columns, of which some are full, ends before a token: one that fits into a line is not cut, and a longer
/// text not within the count of its characters.
fn breaks(full: usize, token: &[u8], columns: usize) -> bool {
    let whole = token.len() + 1;
    let count = 1 + token.iter().take_while(|b| b.is_ascii_digit()).count();
    full > 0 && full + if whole > columns { count + 1 } else { whole } > columns
}

/// What has been written so far.
#[derive(Debug, Default)]
pub(crate) struct Printer {
    directory: Vec<u8>,
    parameters: Vec<u8>,
    /// Lines of both.
    entries: usize,
    lines: usize,
}

impl Printer {
    /// Writes an entity; its number.
    pub(crate) fn put(&mut self, record: Record, look: Look) -> u32 {
        let number = self.entries + 1;
        let first = self.lines + 1;
        self.record(&record.tokens, number);
        let Look { form, color, level, matrix, blank, owned, purpose } = look;
        let color = color.map_or(0, |color| -i64::from(color));
        let status = format!("{:02}{:02}{:02}00", u8::from(blank), u8::from(owned), purpose as u8);
        let count = self.lines + 1 - first;
        let (kind, matrix) = (record.kind, matrix.unwrap_or(0));
        let lines = [
            format!("{kind:8}{first:8}{0:8}{0:8}{level:8}{0:8}{matrix:8}{0:8}{status}D{number:7}\n", 0),
            format!("{kind:8}{0:8}{color:8}{count:8}{form:8}{1:24}{0:8}D{2:7}\n", 0, "", number + 1),
        ];
        self.entries += 2;
        lines.iter().for_each(|line| self.directory.extend_from_slice(line.as_bytes()));
        u32::try_from(number).unwrap_or(u32::MAX)
    }

    /// Parameters in lines: numbers whole, texts filling them.
    fn record(&mut self, tokens: &[Vec<u8>], number: usize) {
        let mut line: Vec<u8> = Vec::with_capacity(DATA);
        for (k, token) in tokens.iter().enumerate() {
            let end = if k + 1 == tokens.len() { b';' } else { b',' };
            if breaks(line.len(), token, DATA) {
                self.line(&mut line, number);
            }
            for &byte in token.iter().chain([&end]) {
                if line.len() == DATA {
                    self.line(&mut line, number);
                }
                line.push(byte);
            }
        }
        self.line(&mut line, number);
    }

    fn line(&mut self, line: &mut Vec<u8>, number: usize) {
        self.lines += 1;
        line.resize(DATA, b' ');
        self.parameters.append(line);
        self.parameters.extend_from_slice(format!("{number:8}P{:7}\n", self.lines).as_bytes());
    }

    /// The whole file, with its name, a unit by flag and name, how exact it is and the largest coordinate.
    pub(crate) fn file(
        self,
        name: &str,
        (flag, unit): (u8, &str),
        resolution: f64,
        largest: f64,
    ) -> Result<[Vec<u8>; 4], FormatError> {
        if self.entries > MOST || self.lines > MOST {
            let problem = format!(
                "{} lines: IGES numbers its lines with seven digits; write fewer objects to one file",
                self.entries.max(self.lines)
            );
            return Err(FormatError::whole(problem).as_kind(FormatErrorKind::Limit));
        }
        // A date would be another one each time.
        let date = "19700101.000000";
        let system = format!("{} {}", crate::SYSTEM, env!("CARGO_PKG_VERSION"));
        let name = plain(name);
        let global = Record::new(0)
            .text(&name)
            .text(&name)
            .text(crate::SYSTEM)
            .text(&system)
            .reals([])
            .whole(32)
            .whole(308)
            .whole(15)
            .whole(308)
            .whole(15)
            .text(&name)
            .real(1.0)
            .whole(i64::from(flag))
            .text(unit)
            .whole(1)
            .real(0.01)
            .text(date)
            .real(resolution)
            .real(largest)
            .text("")
            .text("")
            .whole(11)
            .whole(0)
            .text(date);
        let mut lines = vec![b"1H,,1H;,".to_vec()];
        // Without the type, which entities begin with.
        for (k, token) in global.tokens.iter().enumerate().skip(1) {
            let end = if k + 1 == global.tokens.len() { b';' } else { b',' };
            let mut fresh = lines.last().is_some_and(|line| breaks(line.len(), token, GLOBAL));
            for &byte in token.iter().chain([&end]) {
                match lines.last_mut() {
                    Some(line) if !fresh && line.len() < GLOBAL => line.push(byte),
                    _ => lines.push(vec![byte]),
                }
                fresh = false;
            }
        }
        let count = lines.len();
        let mut head = format!("{:72}S{:7}\n", "", 1).into_bytes();
        for (k, mut line) in lines.into_iter().enumerate() {
            line.resize(GLOBAL, b' ');
            head.extend_from_slice(&line);
            head.extend_from_slice(format!("G{:7}\n", k + 1).as_bytes());
        }
        let last =
            format!("S{:7}G{count:7}D{:7}P{:7}{:40}T{:7}\n", 1, self.entries, self.lines, "", 1).into_bytes();
        Ok([head, self.directory, self.parameters, last])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_and_read_back() {
        for x in [0.0, -0.0, 1.0, -2.5, 1e-7, 1.5e-300, 1e21, f64::MAX, 5e-324, 1.0 / 3.0, 123_456_789.0] {
            let text = real(x);
            assert!(text.contains('.'), "{text}");
            assert_eq!(text.replace('D', "e").parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
        }
    }

    #[test]
    fn counts_of_texts_are_not_cut() {
        for length in 1..400 {
            let mut printer = Printer::default();
            let text = "x".repeat(length);
            printer.put(Record::new(406).text(&text).text(&text).text("end"), Look::default().form(15));
            let parts = printer.file(&text, (2, "MM"), 1e-7, 1.0).unwrap();
            for (part, columns) in [(&parts[0], GLOBAL), (&parts[2], DATA)] {
                let lines: Vec<_> = part.split(|&b| b == b'\n').collect();
                let found = lines.iter().filter(|line| {
                    let line = String::from_utf8_lossy(line.get(..columns).unwrap_or_default()).into_owned();
                    line.contains(&format!("{length}Hx"))
                });
                let texts = lines.iter().map(|line| String::from_utf8_lossy(line).matches("Hx").count());
                assert!(found.count() > 0 && texts.sum::<usize>() > 1, "{length}");
                assert!(!lines.iter().any(|line| line.starts_with(b"Hx")), "{length}");
                let cut = |line: &&[u8]| line.starts_with(format!("{}Hx", length % 10).as_bytes());
                assert!(length < 10 || !lines.iter().any(cut), "{length}");
                let unit = lines.iter().any(|line| line.windows(4).any(|four| four == b"2HMM"));
                assert!(columns == DATA || unit, "{length}");
            }
        }
    }

    #[test]
    fn lines_have_eighty_columns() {
        let mut printer = Printer::default();
        let long = "a, b; ".repeat(40);
        let name = printer.put(Record::new(406).whole(1).text(&long), Look::default().form(15));
        let look = Look { level: 12, color: Some(name), ..Look::PART.purpose(Purpose::Parametric) };
        let numbers: Vec<f64> = (0..40).map(|k| f64::from(k) / 7.0).collect();
        printer.put(Record::new(126).reals(&numbers), look);
        let parts = printer.file("n", (2, "MM"), 0.0, 1.0).unwrap().concat();
        let text = String::from_utf8(parts).unwrap();
        assert!(text.lines().all(|line| line.len() == 80), "{text}");
        let second = text.lines().find(|line| line.ends_with("D      3")).unwrap();
        assert_eq!(&second[32..40], "      12");
        assert_eq!(&second[64..72], "00010500");
        let colored = text.lines().find(|line| line.ends_with("D      4")).unwrap();
        assert_eq!(&colored[16..24], "      -1");
    }
}
