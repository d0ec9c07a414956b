//! Numbers, and lists of them, read straight into the vectors that the geometry keeps.

use std::fmt;

use loftsman_kernel::Point;
use loftsman_kernel::mesh::NONE;
use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};

use super::trail::Trail;

/// Reads a number; JSON has finite ones only.
#[derive(Clone, Copy)]
pub(super) struct Number;

impl<'de> DeserializeSeed<'de> for Number {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        deserializer.deserialize_f64(self)
    }
}

impl Visitor<'_> for Number {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        Ok(value)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }
}

/// Reads a whole number from 0, written `3` or `3.0`.
#[derive(Clone, Copy)]
pub(super) struct Count;

impl<'de> DeserializeSeed<'de> for Count {
    type Value = u64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<u64, D::Error> {
        deserializer.deserialize_u64(self)
    }
}

impl Visitor<'_> for Count {
    type Value = u64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a whole number from 0")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<u64, E> {
        Ok(value)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<u64, E> {
        // 2^53: up to there every whole number is a float of its own.
        if value >= 0.0 && value.fract() == 0.0 && value <= 9_007_199_254_740_992.0 {
            Ok(value as u64)
        } else {
            Err(E::invalid_value(serde::de::Unexpected::Float(value), &self))
        }
    }
}

/// Reads an index from 0 that fits in 32 bits.
#[derive(Clone, Copy)]
pub(super) struct Index<'t>(pub(super) &'t Trail);

impl<'de> DeserializeSeed<'de> for Index<'_> {
    type Value = u32;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<u32, D::Error> {
        let index = Count.deserialize(deserializer)?;
        u32::try_from(index)
            .map_err(|_| self.0.refuse(format!("{index} is beyond the largest index, {}", u32::MAX)))
    }
}

/// Reads an index from 0, or -1 for [`NONE`].
#[derive(Clone, Copy)]
pub(super) struct IndexOrNone<'t>(pub(super) &'t Trail);

impl<'de> DeserializeSeed<'de> for IndexOrNone<'_> {
    type Value = u32;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<u32, D::Error> {
        let index = Number.deserialize(deserializer)?;
        if index == -1.0 {
            return Ok(NONE);
        }
        // The largest index is NONE itself.
        if index >= 0.0 && index.fract() == 0.0 && index < f64::from(NONE) {
            return Ok(index as u32);
        }
        Err(self.0.refuse(format!("{index} is neither an index from 0 nor -1 for no value")))
    }
}

/// Reads a text.
#[derive(Clone, Copy)]
pub(super) struct Text;

impl<'de> DeserializeSeed<'de> for Text {
    type Value = String;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<String, D::Error> {
        serde::Deserialize::deserialize(deserializer)
    }
}

/// Reads exactly `N` numbers.
#[derive(Clone, Copy)]
pub(super) struct Fixed<'t, const N: usize> {
    pub(super) trail: &'t Trail,
    /// What they are: `"[x, y, z]"`.
    pub(super) what: &'static str,
}

impl<'de, const N: usize> DeserializeSeed<'de> for Fixed<'_, N> {
    type Value = [f64; N];

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<[f64; N], D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, const N: usize> Visitor<'de> for Fixed<'_, N> {
    type Value = [f64; N];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<[f64; N], A::Error> {
        let mut out = [0.0; N];
        for (i, slot) in out.iter_mut().enumerate() {
            *slot = self.trail.index(i, list.next_element_seed(Number))?.ok_or_else(|| {
                self.trail.refuse(format!("a list of {i} numbers where {} is needed", self.what))
            })?;
        }
        match self.trail.index(N, list.next_element_seed(Number))? {
            None => Ok(out),
            Some(_) => Err(self.trail.refuse(format!("more than {N} numbers where {} is needed", self.what))),
        }
    }
}

/// Reads a point `[x, y, z]`.
#[derive(Clone, Copy)]
pub(super) struct PointSeed<'t>(pub(super) &'t Trail);

impl<'de> DeserializeSeed<'de> for PointSeed<'_> {
    type Value = Point;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Point, D::Error> {
        Fixed::<3> { trail: self.0, what: "[x, y, z]" }.deserialize(deserializer).map(Point::from)
    }
}

/// Reads a list of anything.
#[derive(Clone, Copy)]
pub(super) struct List<'t, S> {
    pub(super) trail: &'t Trail,
    /// What it is a list of: `"numbers"`.
    pub(super) what: &'static str,
    /// Reads one of them.
    pub(super) item: S,
}

impl<'t> List<'t, Number> {
    /// Numbers.
    pub(super) fn numbers(trail: &'t Trail) -> Self {
        Self { trail, what: "numbers", item: Number }
    }
}

impl<'t> List<'t, PointSeed<'t>> {
    /// Points.
    pub(super) fn points(trail: &'t Trail) -> Self {
        Self { trail, what: "points [x, y, z]", item: PointSeed(trail) }
    }
}

impl<'de, S: DeserializeSeed<'de> + Copy> DeserializeSeed<'de> for List<'_, S> {
    type Value = Vec<S::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<S::Value>, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, S: DeserializeSeed<'de> + Copy> Visitor<'de> for List<'_, S> {
    type Value = Vec<S::Value>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}", self.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<S::Value>, A::Error> {
        let mut out = Vec::new();
        while let Some(item) = self.trail.index(out.len(), list.next_element_seed(self.item))? {
            out.push(item);
        }
        Ok(out)
    }
}

/// Rows of equal length, one after another.
pub(super) struct Grid<T> {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) items: Vec<T>,
}

/// Reads a [`Grid`].
#[derive(Clone, Copy)]
pub(super) struct GridSeed<'t, S>(pub(super) List<'t, S>);

impl<'de, S: DeserializeSeed<'de> + Copy> DeserializeSeed<'de> for GridSeed<'_, S> {
    type Value = Grid<S::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, S: DeserializeSeed<'de> + Copy> Visitor<'de> for GridSeed<'_, S> {
    type Value = Grid<S::Value>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of rows of {}", self.0.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let trail = self.0.trail;
        let mut grid = Grid { rows: 0, columns: 0, items: Vec::new() };
        while let Some(row) = trail.index(grid.rows, list.next_element_seed(self.0))? {
            if grid.rows == 0 {
                grid.columns = row.len();
            } else if row.len() != grid.columns {
                let (found, expected) = (row.len(), grid.columns);
                let problem = format!(
                    "the row has {found} entries, the first row {expected}: make all rows equally long"
                );
                return trail.index(grid.rows, Err(trail.refuse(problem)));
            }
            grid.items.extend(row);
            grid.rows += 1;
        }
        Ok(grid)
    }
}

/// The corners of all faces, one after another, and where each face starts.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) corners: Vec<u32>,
    pub(super) starts: Vec<usize>,
}

/// Reads the faces of a mesh, or its lines.
#[derive(Clone, Copy)]
pub(super) struct FacesSeed<'t> {
    pub(super) trail: &'t Trail,
    /// What one is: `"face"`.
    pub(super) what: &'static str,
}

impl<'de> DeserializeSeed<'de> for FacesSeed<'_> {
    type Value = Faces;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Faces, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for FacesSeed<'_> {
    type Value = Faces;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}s, each a list of point indices", self.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Faces, A::Error> {
        let mut faces = Faces { corners: Vec::new(), starts: vec![0] };
        loop {
            let face = faces.starts.len() - 1;
            let seed = FaceSeed { trail: self.trail, what: self.what, corners: &mut faces.corners };
            if self.trail.index(face, list.next_element_seed(seed))?.is_none() {
                return Ok(faces);
            }
            faces.starts.push(faces.corners.len());
        }
    }
}

/// Appends the corners of one face.
struct FaceSeed<'t, 'c> {
    trail: &'t Trail,
    what: &'static str,
    corners: &'c mut Vec<u32>,
}

impl<'de> DeserializeSeed<'de> for FaceSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for FaceSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {}, a list of point indices", self.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let first = self.corners.len();
        loop {
            let at = self.corners.len() - first;
            let Some(index) = self.trail.index(at, list.next_element_seed(Count))? else { return Ok(()) };
            let corner = u32::try_from(index).map_err(|_| {
                self.trail.refuse(format!("point {index} is beyond what a mesh can number ({})", u32::MAX))
            });
            self.corners.push(self.trail.index(at, corner)?);
        }
    }
}
