//! The file in parts that are read independently of one another, in parallel.
//!
//! A first pass counts the vertices of each part, so that the second knows where a part's vertices go and what its
//! negative indices mean. What depends on the order of the file (names, groups, materials, free-form statements) is
//! left in the part as marks for [`Reader`](super::reader::Reader), which takes the parts one after the other.

mod elements;

use std::borrow::Cow;

use loftsman_kernel::mesh::color::from_srgb;
use loftsman_kernel::{Point, Vector};

use super::statement::{DISPLAY, Known, OBSOLETE, known};
use super::tally::{Tallies, Tally};
use crate::number::{fill, next_number};
use crate::text::{MRGB, OURS, Statements, ends_statement, keyword, line_length, show, tokens, uncommented};

/// About how long a part is: long enough that threads need not wait for one another, short enough that what a wave
/// of parts holds beside the scene stays small.
const LENGTH: usize = 1 << 19;

/// The largest number of different unknown statements that are counted one by one, so that a hostile file cannot make
/// the report as large as itself.
const UNKNOWN: usize = 32;

/// The largest number of wrong statements of a part that are named one by one.
pub(crate) const WRONG: usize = 16;

/// How many of each there are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) points: usize,
    pub(crate) uvs: usize,
    pub(crate) normals: usize,
    pub(crate) parameters: usize,
    pub(crate) lines: usize,
}

impl Counts {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            points: self.points + other.points,
            uvs: self.uvs + other.uvs,
            normals: self.normals + other.normals,
            parameters: self.parameters + other.parameters,
            lines: self.lines + other.lines,
        }
    }
}

/// The text in parts of whole statements.
pub(crate) fn split(text: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let mut end = LENGTH.min(rest.len());
        // The line that is cut belongs here, and those that it goes on with.
        loop {
            end += line_length(&rest[end..]);
            let body = without_end(&rest[..end]);
            let start = body.iter().rposition(|&b| b == b'\n' || b == b'\r').map_or(0, |at| at + 1);
            if end == rest.len() || ends_statement(&rest[start..end]) {
                break;
            }
        }
        let (part, after) = rest.split_at(end);
        parts.push(part);
        rest = after;
    }
    parts
}

fn without_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// The vertices and lines of a part.
pub(crate) fn count(part: &[u8]) -> Counts {
    let mut counts = Counts::default();
    let mut statements = Statements::new(part);
    for (_, statement) in statements.by_ref() {
        match *statement {
            [b'v', b't', b, ..] if b.is_ascii_whitespace() => counts.uvs += 1,
            [b'v', b'n', b, ..] if b.is_ascii_whitespace() => counts.normals += 1,
            [b'v', b'p', b, ..] if b.is_ascii_whitespace() => counts.parameters += 1,
            [b'v', b, ..] if b.is_ascii_whitespace() => counts.points += 1,
            _ => {}
        }
    }
    counts.lines = statements.lines();
    counts
}

/// Where a part's vertices go.
pub(crate) struct Slots<'s> {
    pub(crate) points: &'s mut [Point],
    pub(crate) uvs: &'s mut [[f64; 2]],
    pub(crate) normals: &'s mut [Vector],
    pub(crate) parameters: &'s mut [[f64; 3]],
}

/// A statement that changes what those after it mean, and how far the part was when it came.
#[derive(Debug)]
pub(crate) struct Mark<'a> {
    pub(crate) known: Known,
    /// What follows the keyword.
    pub(crate) rest: Cow<'a, [u8]>,
    pub(crate) line: usize,
    pub(crate) faces: u32,
    pub(crate) chains: u32,
    pub(crate) dots: u32,
    pub(crate) points: u32,
    pub(crate) parameters: u32,
}

/// What a part holds beside its vertices.
#[derive(Debug, Default)]
pub(crate) struct Parsed<'a> {
    /// Vertex of every corner, face after face, and where each face ends.
    pub(crate) corners: Vec<u32>,
    pub(crate) ends: Vec<u32>,
    /// Texture vertex and normal of every corner, or [`NONE`]; shorter where the last ones have none.
    pub(crate) textures: Vec<u32>,
    pub(crate) normals: Vec<u32>,
    /// Vertices of the lines, line after line, and where each ends.
    pub(crate) chains: Vec<u32>,
    pub(crate) chain_ends: Vec<u32>,
    /// Vertices of the point statements, and where each ends.
    pub(crate) dots: Vec<u32>,
    pub(crate) dot_ends: Vec<u32>,
    /// Weights and linear colours (NaN: none) of the part's vertices; shorter where the last ones have none.
    pub(crate) weights: Vec<f64>,
    pub(crate) colors: Vec<[f64; 4]>,
    pub(crate) marks: Vec<Mark<'a>>,
    /// The first wrong statements with their lines, and how many more there are.
    pub(crate) wrong: Vec<(usize, String)>,
    pub(crate) more_wrong: usize,
    /// Vertices, texture vertices and normals whose statement is wrong, counted through the file.
    pub(crate) broken: [Vec<u32>; 3],
    /// Texture vertices of which a third coordinate was left out, lines with texture vertices.
    pub(crate) third: usize,
    pub(crate) line_textures: usize,
    pub(crate) display: usize,
    pub(crate) obsolete: Tally,
    pub(crate) unknown: Tallies,
    /// Statements understood.
    pub(crate) understood: usize,
}

const NO_COLOR: [f64; 4] = [f64::NAN; 4];

/// Reads a part; `before` is what the file has before it, `total` what it has in all.
///
/// A statement that is wrong is left out with its line. Those of vertices keep their number, since others count them.
pub(crate) fn parse<'a>(part: &'a [u8], before: Counts, total: Counts, slots: Slots<'_>) -> Parsed<'a> {
    let mut parser = Parser { out: Parsed::default(), before, total, slots, here: Counts::default() };
    let mut seen = 0_usize;
    for (line, statement) in Statements::new(part) {
        let line = before.lines + line;
        seen += 1;
        if let Err(problem) = parser.statement(statement, line, seen) {
            parser.out.wrong(line, problem);
        }
    }
    parser.out
}

impl Parsed<'_> {
    #[cold]
    fn wrong(&mut self, line: usize, problem: String) {
        if self.wrong.len() < WRONG {
            self.wrong.push((line, problem));
        } else {
            self.more_wrong += 1;
        }
    }
}

struct Parser<'a, 's> {
    out: Parsed<'a>,
    before: Counts,
    total: Counts,
    slots: Slots<'s>,
    here: Counts,
}

impl<'a> Parser<'a, '_> {
    fn statement(&mut self, statement: Cow<'a, [u8]>, line: usize, seen: usize) -> Result<(), String> {
        match *statement {
            [b'v', b, ref rest @ ..] if b.is_ascii_whitespace() => self.vertex(rest, line)?,
            [b'v', b'n', b, ref rest @ ..] if b.is_ascii_whitespace() => self.normal(rest)?,
            [b'v', b't', b, ref rest @ ..] if b.is_ascii_whitespace() => self.texture(rest)?,
            [b'v', b'p', b, ref rest @ ..] if b.is_ascii_whitespace() => self.parameter(rest)?,
            [b'f', b, ref rest @ ..] if b.is_ascii_whitespace() => self.face(rest)?,
            _ => return self.other(statement, line, seen),
        }
        self.out.understood += 1;
        Ok(())
    }

    #[cold]
    fn other(&mut self, statement: Cow<'a, [u8]>, line: usize, seen: usize) -> Result<(), String> {
        if statement.starts_with(MRGB) {
            self.mark(Known::Mrgb, statement, MRGB.len(), line);
            return Ok(());
        }
        if statement.starts_with(OURS) {
            self.mark(Known::Ours, statement, OURS.len(), line);
            return Ok(());
        }
        let statement = match statement {
            Cow::Borrowed(text) => Cow::Borrowed(uncommented(text)),
            joined => joined,
        };
        let (word, rest) = keyword(&statement);
        let skip = statement.len() - rest.len();
        match word {
            b"f" | b"fo" => self.face(rest)?,
            b"l" => self.chain(rest)?,
            b"p" => self.dots(rest)?,
            // A vertex statement without anything behind it.
            b"v" | b"vt" | b"vn" | b"vp" => return Err(format!("\"{}\" without numbers", show(word))),
            _ if DISPLAY.contains(&word) => self.out.display += 1,
            _ if OBSOLETE.contains(&word) => self.out.obsolete.add(1, line),
            _ => match known(word) {
                Some(known) => self.mark(known, statement, skip, line),
                None => return self.unknown(word, line, seen),
            },
        }
        self.out.understood += 1;
        Ok(())
    }

    fn unknown(&mut self, word: &[u8], line: usize, seen: usize) -> Result<(), String> {
        if !word.iter().all(u8::is_ascii_graphic)
            || (self.before.lines == 0 && self.out.understood == 0 && seen > 64)
        {
            return Err(format!("\"{}\" is no statement of an OBJ file", show(word)));
        }
        let unknown = &mut self.out.unknown;
        let name = show(word);
        let name =
            if unknown.len() < UNKNOWN || unknown.contains_key(&name) { name } else { "others".into() };
        unknown.entry(name).or_default().add(1, line);
        Ok(())
    }

    fn mark(&mut self, known: Known, statement: Cow<'a, [u8]>, skip: usize, line: usize) {
        let rest = match statement {
            Cow::Borrowed(text) => Cow::Borrowed(&text[skip..]),
            Cow::Owned(text) => Cow::Owned(text[skip..].to_vec()),
        };
        self.out.marks.push(Mark {
            known,
            rest,
            line,
            faces: self.out.ends.len() as u32,
            chains: self.out.chain_ends.len() as u32,
            dots: self.out.dot_ends.len() as u32,
            points: self.here.points as u32,
            parameters: self.here.parameters as u32,
        });
    }

    /// `v x y z`, `v x y z w`, `v x y z r g b` or `v x y z r g b a`.
    fn vertex(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        let at = self.here.points;
        self.here.points += 1;
        let mut n = [0.0; 7];
        let mut count = fill(rest, &mut n);
        // A colour that is none does not cost the vertex.
        if let Err(problem) = &count
            && matches!(tokens(uncommented(rest)).count(), 6 | 7)
            && let Some(xyz) = three(rest)
        {
            self.out.wrong(line, format!("the vertex has no colour: {problem}"));
            n[..3].copy_from_slice(&xyz);
            count = Ok(3);
        }
        let count = match count {
            Ok(count @ (3 | 4 | 6 | 7)) => count,
            other => {
                if let Some(slot) = self.slots.points.get_mut(at) {
                    *slot = Point::new(f64::NAN, f64::NAN, f64::NAN);
                }
                self.out.broken[0].push((self.before.points + at) as u32);
                let count = other?;
                return Err(format!(
                    "a vertex has {count} numbers: 3, with a weight 4, with a colour 6 or 7 are right"
                ));
            }
        };
        if let Some(slot) = self.slots.points.get_mut(at) {
            *slot = Point::new(n[0], n[1], n[2]);
        }
        if count == 4 && n[3] != 1.0 {
            self.out.weights.resize(at, 1.0);
            self.out.weights.push(n[3]);
        }
        if count >= 6 {
            let alpha = if count == 7 { n[6] } else { 1.0 };
            let color = [from_srgb(n[3]), from_srgb(n[4]), from_srgb(n[5]), alpha];
            if let Some(k) = color.iter().position(|c| !c.is_finite()) {
                return Err(format!(
                    "the vertex has no colour: {:e} is beyond all measure, colours lie between 0 and 1",
                    n[3 + k]
                ));
            }
            self.out.colors.resize(at, NO_COLOR);
            self.out.colors.push(color);
        }
        Ok(())
    }

    /// `vn x y z`.
    fn normal(&mut self, rest: &[u8]) -> Result<(), String> {
        let at = self.here.normals;
        self.here.normals += 1;
        let mut n = [0.0; 3];
        let count = fill(rest, &mut n);
        if count != Ok(3) {
            self.out.broken[2].push((self.before.normals + at) as u32);
            return Err(format!("a normal has {} numbers: 3 are right", count?));
        }
        if let Some(slot) = self.slots.normals.get_mut(at) {
            *slot = Vector::from(n);
        }
        Ok(())
    }

    /// `vt u`, `vt u v` or `vt u v w`.
    fn texture(&mut self, rest: &[u8]) -> Result<(), String> {
        let at = self.here.uvs;
        self.here.uvs += 1;
        let mut n = [0.0; 3];
        let count = fill(rest, &mut n);
        if !matches!(count, Ok(1..=3)) {
            self.out.broken[1].push((self.before.uvs + at) as u32);
            return Err(format!("a texture vertex has {} numbers: 1 to 3 are right", count?));
        }
        if let Some(slot) = self.slots.uvs.get_mut(at) {
            *slot = [n[0], n[1]];
        }
        self.out.third += usize::from(n[2] != 0.0);
        Ok(())
    }

    /// `vp u`, `vp u v` or `vp u v w`: the weight is 1 where none is given.
    fn parameter(&mut self, rest: &[u8]) -> Result<(), String> {
        let at = self.here.parameters;
        self.here.parameters += 1;
        let mut n = [0.0, 0.0, 1.0];
        let count = fill(rest, &mut n);
        let is_right = matches!(count, Ok(1..=3));
        if let Some(slot) = self.slots.parameters.get_mut(at) {
            // Whatever uses a broken one is refused as not finite.
            *slot = if is_right { n } else { [f64::NAN; 3] };
        }
        if is_right {
            return Ok(());
        }
        Err(format!("a parameter vertex has {} numbers: 1 to 3 are right", count?))
    }
}

/// The first three numbers of a text, if they are some.
#[cold]
fn three(mut text: &[u8]) -> Option<[f64; 3]> {
    let mut next = || next_number(&mut text).ok().flatten();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_whole_statements_and_count_alike() {
        let mut text = Vec::new();
        for k in 0..250_000_u32 {
            let statement = match k % 5 {
                0 => format!("v {k} 2 \\\r\n 3\r\n"),
                1 => "vt 1 2\nv\\\n 1 2 3\n".to_owned(),
                2 => "# vn 1 2 3 \\\nvn 1 2 3\r".to_owned(),
                3 => "  vp 1\n\n".to_owned(),
                _ => "g a \\\nv 1 2 3 \\\n\\\nb\n".to_owned(),
            };
            text.extend_from_slice(statement.as_bytes());
        }
        let parts = split(&text);
        assert!(parts.len() > 3 && parts.concat() == text);
        let sum = parts.iter().map(|p| count(p)).fold(Counts::default(), Counts::and);
        let n = 50_000;
        assert_eq!(sum, count(&text));
        assert_eq!((sum.points, sum.uvs, sum.normals, sum.parameters), (2 * n, n, n, n));
    }
}
