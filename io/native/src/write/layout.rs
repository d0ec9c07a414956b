//! JSON as people like to read it: a field a line, a point a line, numbers side by side.

use std::io::{self, BufWriter, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use loftsman_kernel::{Point, text};
use serde_json::Value;

/// How many plain numbers go on a line.
const NUMBERS_A_LINE: usize = 10;

/// How many indices go on a line.
const INDICES_A_LINE: usize = 20;

/// Writes JSON, indented by two blanks a level.
pub(super) struct Layout<'w> {
    out: BufWriter<&'w mut dyn Write>,
    depth: usize,
    /// Whether nothing has been written into the innermost table or list yet.
    first: bool,
}

impl<'w> Layout<'w> {
    /// Writes to `out`.
    pub(super) fn new(out: &'w mut dyn Write) -> Self {
        Self { out: BufWriter::with_capacity(1 << 16, out), depth: 0, first: true }
    }

    /// Ends the last line and flushes.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        self.out.write_all(b"\n")?;
        self.out.flush()
    }

    pub(super) fn open_table(&mut self) -> io::Result<()> {
        self.open(b"{")
    }

    pub(super) fn close_table(&mut self) -> io::Result<()> {
        self.close(b"}")
    }

    pub(super) fn open_list(&mut self) -> io::Result<()> {
        self.open(b"[")
    }

    pub(super) fn close_list(&mut self) -> io::Result<()> {
        self.close(b"]")
    }

    /// Starts the next field of a table.
    pub(super) fn key(&mut self, name: &str) -> io::Result<()> {
        self.entry()?;
        self.text(name)?;
        self.out.write_all(b": ")
    }

    /// Starts the next entry of a list of tables or lists.
    pub(super) fn entry(&mut self) -> io::Result<()> {
        if !self.first {
            self.out.write_all(b",")?;
        }
        self.first = false;
        self.line()
    }

    pub(super) fn text(&mut self, text: &str) -> io::Result<()> {
        Ok(serde_json::to_writer(&mut self.out, text)?)
    }

    pub(super) fn flag(&mut self, flag: bool) -> io::Result<()> {
        self.out.write_all(if flag { b"true" } else { b"false" })
    }

    pub(super) fn count(&mut self, count: u64) -> io::Result<()> {
        Ok(serde_json::to_writer(&mut self.out, &count)?)
    }

    /// JSON as it stands in another document.
    pub(super) fn verbatim(&mut self, json: &str) -> io::Result<()> {
        self.out.write_all(json.as_bytes())
    }

    /// Any value: numbers in one line or several, lists of anything else an entry a line.
    pub(super) fn value(&mut self, value: &Value) -> io::Result<()> {
        match value {
            Value::Object(fields) => {
                self.open_table()?;
                for (name, value) in fields {
                    self.key(name)?;
                    self.value(value)?;
                }
                self.close_table()
            }
            Value::Array(list) => {
                let numbers: Option<Vec<f64>> = list.iter().map(float).collect();
                if let Some(numbers) = numbers {
                    return self.numbers(&numbers);
                }
                self.open_list()?;
                for value in list {
                    self.entry()?;
                    self.value(value)?;
                }
                self.close_list()
            }
            other => match float(other) {
                Some(number) => self.number(number),
                None => Ok(serde_json::to_writer(&mut self.out, other)?),
            },
        }
    }

    /// The shortest decimals that read back as the same bits.
    pub(super) fn number(&mut self, x: f64) -> io::Result<()> {
        text::number(&mut self.out, x)
    }

    /// Numbers in one line.
    pub(super) fn row(&mut self, numbers: &[f64]) -> io::Result<()> {
        self.out.write_all(b"[")?;
        self.side_by_side(numbers)?;
        self.out.write_all(b"]")
    }

    /// Numbers, several a line.
    pub(super) fn numbers(&mut self, numbers: &[f64]) -> io::Result<()> {
        if numbers.len() <= NUMBERS_A_LINE {
            return self.row(numbers);
        }
        self.open_list()?;
        for line in numbers.chunks(NUMBERS_A_LINE) {
            self.entry()?;
            self.side_by_side(line)?;
        }
        self.close_list()
    }

    /// Whole numbers in one line or, where there are many, several a line; `None` is written as -1.
    pub(super) fn indices(&mut self, indices: impl ExactSizeIterator<Item = Option<u32>>) -> io::Result<()> {
        let long = indices.len() > INDICES_A_LINE;
        if long {
            self.open_list()?;
        } else {
            self.out.write_all(b"[")?;
        }
        for (i, index) in indices.enumerate() {
            if long && i % INDICES_A_LINE == 0 {
                self.entry()?;
            } else {
                self.comma(i)?;
            }
            match index {
                Some(index) => self.count(u64::from(index))?,
                None => self.out.write_all(b"-1")?,
            }
        }
        if long { self.close_list() } else { self.out.write_all(b"]") }
    }

    /// Texts in one line.
    pub(super) fn texts<'a>(&mut self, texts: impl Iterator<Item = &'a str>) -> io::Result<()> {
        self.out.write_all(b"[")?;
        for (i, text) in texts.enumerate() {
            self.comma(i)?;
            self.text(text)?;
        }
        self.out.write_all(b"]")
    }

    /// Bytes as a text, in base 64 (RFC 4648, with padding).
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(b"\"")?;
        // A multiple of three: pieces put together are the whole.
        for piece in bytes.chunks(3 << 12) {
            self.out.write_all(STANDARD.encode(piece).as_bytes())?;
        }
        self.out.write_all(b"\"")
    }

    /// Rows of numbers, a row a line.
    pub(super) fn rows<const N: usize>(&mut self, rows: impl Iterator<Item = [f64; N]>) -> io::Result<()> {
        self.open_list()?;
        for row in rows {
            self.entry()?;
            self.row(&row)?;
        }
        self.close_list()
    }

    /// Points, a point a line.
    pub(super) fn points(&mut self, points: &[Point]) -> io::Result<()> {
        self.rows(points.iter().map(|p| [p.x, p.y, p.z]))
    }

    /// Faces, a face a line.
    pub(super) fn faces<'a>(&mut self, faces: impl Iterator<Item = &'a [u32]>) -> io::Result<()> {
        self.open_list()?;
        for face in faces {
            self.entry()?;
            self.out.write_all(b"[")?;
            for (i, &corner) in face.iter().enumerate() {
                self.comma(i)?;
                self.count(u64::from(corner))?;
            }
            self.out.write_all(b"]")?;
        }
        self.close_list()
    }

    fn side_by_side(&mut self, numbers: &[f64]) -> io::Result<()> {
        for (i, &x) in numbers.iter().enumerate() {
            self.comma(i)?;
            self.number(x)?;
        }
        Ok(())
    }

    fn comma(&mut self, i: usize) -> io::Result<()> {
        if i == 0 { Ok(()) } else { self.out.write_all(b", ") }
    }

    fn open(&mut self, bracket: &[u8]) -> io::Result<()> {
        self.out.write_all(bracket)?;
        self.depth += 1;
        self.first = true;
        Ok(())
    }

    fn close(&mut self, bracket: &[u8]) -> io::Result<()> {
        self.depth -= 1;
        if !self.first {
            self.line()?;
        }
        self.first = false;
        self.out.write_all(bracket)
    }

    fn line(&mut self) -> io::Result<()> {
        const BLANKS: [u8; 65] = {
            let mut blanks = [b' '; 65];
            blanks[0] = b'\n';
            blanks
        };
        // Documents are six levels deep.
        self.out.write_all(&BLANKS[..=(2 * self.depth).min(64)])
    }
}

/// A number that is a float; whole ones may be beyond what floats can tell apart.
fn float(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) if number.is_f64() => number.as_f64(),
        Value::Number(number) => number.as_f64().filter(|x| x.abs() < 9e15),
        _ => None,
    }
}
