//! The numbered lists of a file: vertices, texture coordinates, normals.

use loftsman_kernel::{Point, Vector};

use crate::text::{number, show, words};

/// What has become of an entry of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Use {
    Nothing,
    LeftOut,
    Kept,
}

/// The lists, as the file has them.
#[derive(Debug, Default)]
pub(crate) struct Raw {
    pub(crate) points: Vec<Point>,
    /// One a point; empty while none differs from 1.
    pub(crate) weights: Vec<f64>,
    /// Linear colours, one a point, NaN where it has none; empty while none has.
    pub(crate) colors: Vec<[f64; 4]>,
    pub(crate) uvs: Vec<[f64; 2]>,
    pub(crate) normals: Vec<Vector>,
}

const NO_COLOR: [f64; 4] = [f64::NAN; 4];

impl Raw {
    /// `v x y z`, `v x y z w`, `v x y z r g b` or `v x y z r g b a`.
    pub(crate) fn vertex(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut numbers = [0.0; 7];
        let count = fill(rest, &mut numbers)?;
        let [x, y, z, a, b, c, d] = numbers;
        let before = self.points.len();
        match count {
            3 | 4 | 6 | 7 => self.points.push(Point::new(x, y, z)),
            _ => {
                return Err(format!(
                    "a vertex has {count} numbers: 3, with a weight 4, with a colour 6 or 7 are right"
                ));
            }
        }
        if count == 4 && a != 1.0 && self.weights.is_empty() {
            self.weights.resize(before, 1.0);
            self.weights.push(a);
        } else if !self.weights.is_empty() || (count == 4 && a != 1.0) {
            self.weights.push(if count == 4 { a } else { 1.0 });
        }
        if count >= 6 {
            self.colors.resize(before, NO_COLOR);
            self.colors.push([linear(a), linear(b), linear(c), if count == 7 { d } else { 1.0 }]);
        }
        Ok(())
    }

    /// `vt u`, `vt u v` or `vt u v w`.
    pub(crate) fn texture(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut numbers = [0.0; 3];
        match fill(rest, &mut numbers)? {
            1..=3 => self.uvs.push([numbers[0], numbers[1]]),
            count => return Err(format!("a texture vertex has {count} numbers: 1 to 3 are right")),
        }
        Ok(())
    }

    /// `vn x y z`.
    pub(crate) fn normal(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut numbers = [0.0; 3];
        match fill(rest, &mut numbers)? {
            3 => self.normals.push(Vector::from(numbers)),
            count => return Err(format!("a normal has {count} numbers: 3 are right")),
        }
        Ok(())
    }

    /// The weight of a vertex.
    pub(crate) fn weight(&self, vertex: u32) -> f64 {
        self.weights.get(vertex as usize).copied().unwrap_or(1.0)
    }

    /// The colour of a vertex, where it has one.
    pub(crate) fn color(&self, vertex: u32) -> Option<[f64; 4]> {
        self.colors.get(vertex as usize).copied().filter(|c| !c[0].is_nan())
    }
}

/// Reads numbers into `out`; how many there were.
fn fill(rest: &[u8], out: &mut [f64]) -> Result<usize, String> {
    let mut count = 0;
    for word in words(rest) {
        let value = number(word)?;
        if let Some(slot) = out.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    Ok(count)
}

/// An sRGB value as a linear one (IEC 61966-2-1).
fn linear(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Which entry of a list an index means: from 1 up, or from -1 down from the newest. Entries that come later in
/// the file are allowed; the caller checks the largest index at the end.
pub(crate) fn resolve(word: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let bad = || format!("\"{}\" is not the number of a {what}", show(word));
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return Err(bad());
    }
    let mut value = 0_u64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return Err(bad());
        }
        value = value * 10 + u64::from(digit - b'0');
    }
    let index = match (negative, value) {
        (_, 0) => return Err(format!("there is no {what} 0: numbers start at 1, or at -1 from the end")),
        (false, value) => value - 1,
        (true, value) => (count as u64).checked_sub(value).ok_or_else(|| {
            format!("the index -{value} leads before the first {what}: there are {count} so far")
        })?,
    };
    u32::try_from(index)
        .ok()
        .filter(|&i| i < u32::MAX)
        .ok_or_else(|| format!("the index {value} is too large"))
}
