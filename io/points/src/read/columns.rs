//! Which columns are the coordinates.

use loftsman_kernel::Point;

use super::line::{Separator, clip, text};
use super::number::{NumberFault, Signs, parse};

/// The columns of a file, known from its first row on.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    separator: Separator,
    /// How many there are.
    pub(super) count: usize,
    /// Which are x, y and z; z is none where there are two only.
    x: usize,
    y: usize,
    z: Option<usize>,
    /// Their names, if the file has any.
    pub(super) names: Option<Vec<String>>,
    /// Whether the names said which columns are the coordinates.
    pub(super) named: bool,
}

/// What is wrong with a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum RowFault {
    /// Another number of columns than the rows before.
    Count(usize),
    /// A field that is no coordinate: its text and why.
    Field(String, NumberFault),
}

impl Columns {
    /// The columns that a first row shows, if the line is a row: two fields or more, numbers as far as they are
    /// needed. `header` are names from a line before, which count where they are as many.
    pub(super) fn of(line: &[u8], header: &dyn Fn(Separator, usize) -> Option<Vec<String>>) -> Option<Self> {
        let separator = Separator::of(line);
        let fields: Vec<&[u8]> = separator.fields(line).collect();
        let count = fields.len();
        if count < 2 {
            return None;
        }
        let numeric = |i: usize| {
            // NaN counts here: the row is one, and will be refused with its line.
            let parsed = parse(fields[i], separator.allows_comma(), &mut Signs::default());
            !matches!(parsed, Err(NumberFault::Word))
        };
        let names = header(separator, count);
        let find = |axis: usize| names.as_ref().and_then(|n| n.iter().position(|n| is_axis(n, axis)));
        let named = find(0).zip(find(1));
        let (x, y, z) = match named {
            Some((x, y)) => (x, y, find(2)),
            None => (0, 1, (count > 2 && numeric(2)).then_some(2)),
        };
        // Text beside the coordinates is a label in a table, but a sentence between blanks.
        let labelled = separator != Separator::Blanks;
        let row = numeric(x) && numeric(y) && z.is_none_or(numeric) && (labelled || (0..count).all(numeric));
        row.then_some(Self { separator, count, x, y, z, names, named: named.is_some() })
    }

    /// The point of a row.
    pub(super) fn point(&self, line: &[u8], signs: &mut Signs) -> Result<Point, RowFault> {
        let mut point = Point::origin();
        let mut found = 0;
        let mut fault = None;
        for field in self.separator.fields(line) {
            let axis = match found {
                i if i == self.x => 0,
                i if i == self.y => 1,
                i if Some(i) == self.z => 2,
                _ => 3,
            };
            found += 1;
            if axis == 3 || fault.is_some() {
                continue;
            }
            match parse(field, self.separator.allows_comma(), signs) {
                Ok(value) => point[axis] = value,
                Err(why) => fault = Some(RowFault::Field(clip(field), why)),
            }
        }
        match fault {
            // A word is the better reason where a line has neither the columns nor the numbers.
            Some(fault) => Err(fault),
            None if found != self.count => Err(RowFault::Count(found)),
            None => Ok(point),
        }
    }

    /// How many coordinates a row has: 2 or 3.
    pub(super) fn dimension(&self) -> usize {
        if self.z.is_some() { 3 } else { 2 }
    }

    /// What separates them.
    pub(super) fn separator(&self) -> Separator {
        self.separator
    }

    /// The columns that are not coordinates: their names, or their numbers from 1.
    pub(super) fn others(&self) -> impl Iterator<Item = String> + '_ {
        let taken = move |i: &usize| *i == self.x || *i == self.y || Some(*i) == self.z;
        (0..self.count).filter(move |i| !taken(i)).map(|i| match &self.names {
            Some(names) => format!("\"{}\"", clip(names[i].as_bytes())),
            None => format!("{}", i + 1),
        })
    }
}

/// The names in a header line, if it has as many fields as the rows and none is a number.
pub(super) fn header(line: &[u8], separator: Separator, count: usize) -> Option<Vec<String>> {
    let names: Vec<&[u8]> = separator.fields(line).collect();
    let word = |field: &&[u8]| parse(field, true, &mut Signs::default()).is_err();
    (names.len() == count && names.iter().all(word)).then(|| names.into_iter().map(text).collect())
}

/// Whether names of columns tell which are x and y.
pub(super) fn names_axes(names: &[String]) -> bool {
    (0..2).all(|axis| names.iter().any(|name| is_axis(name, axis)))
}

/// Whether the name of a column means an axis (0, 1, 2): `x`, `X [mm]`, `x/c`, `Points:0`, …
fn is_axis(name: &str, axis: usize) -> bool {
    let end = name.find(['[', '(']).unwrap_or(name.len());
    let name = name[..end].trim().to_ascii_lowercase();
    let letter = ["x", "y", "z"][axis];
    let digit = ["0", "1", "2"][axis];
    let rest = |prefix: &str| name.strip_prefix(prefix);
    name == letter
        || rest(letter)
            .is_some_and(|rest| matches!(rest, "/c" | "_mm" | "_m" | "-coordinate" | "_coordinate"))
        || ["points:", "points_", "coordinates:", "position:"].iter().any(|p| rest(p) == Some(digit))
        || ["p", "pos_", "pos", "coordinate", "coord"].iter().any(|p| rest(p) == Some(letter))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(header_line: &str, row: &str) -> Columns {
        let names = |separator, count| header(header_line.as_bytes(), separator, count);
        Columns::of(row.as_bytes(), &names).unwrap()
    }

    #[test]
    fn a_header_chooses_the_columns() {
        let found = columns("id,Z [mm],X [mm],Y [mm]", "a,3,1,2");
        assert_eq!(found.point(b"b,6,4,5", &mut Signs::default()), Ok(Point::new(4.0, 5.0, 6.0)));
        assert_eq!(found.others().collect::<Vec<_>>(), ["\"id\""]);
        let found = columns("\"Points:0\",\"Points:1\",\"Points:2\"", "1,2,3");
        assert!(found.named && found.dimension() == 3);
    }

    #[test]
    fn without_one_the_first_three_are_taken() {
        let found = columns("", "1 2 3 4 5");
        assert_eq!(found.point(b"1 2 3 9 9", &mut Signs::default()), Ok(Point::new(1.0, 2.0, 3.0)));
        assert_eq!(found.others().collect::<Vec<_>>(), ["4", "5"]);
        assert_eq!(found.point(b"1 2 3", &mut Signs::default()), Err(RowFault::Count(3)));
        let word = RowFault::Field("end".into(), NumberFault::Word);
        assert_eq!(found.point(b"end", &mut Signs::default()), Err(word));
        assert!(Columns::of(b"63 412 A", &|_, _| None).is_none());
        assert_eq!(columns("", "1,2,nose").dimension(), 2);
    }
}
