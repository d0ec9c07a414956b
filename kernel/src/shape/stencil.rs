//! How a value of a shape depends on its control vertices.

use smallvec::SmallVec;

use crate::{Point, Vector};

/// The sparse row `S` with `value = Σ S_i P_i`: which control vertices a point (or derivative) of a shape is
/// made of, and how much of each. On the stack up to bicubic surfaces. Vertices ascend and do not repeat.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stencil {
    vertices: SmallVec<[usize; ROOM]>,
    coefficients: SmallVec<[f64; ROOM]>,
}

/// So many vertices of a stencil are kept on the stack.
const ROOM: usize = 16;

impl Stencil {
    /// An empty stencil: the value zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// The stencil of a run of vertices from `first` on: one for each of the coefficients `row[..count]`.
    #[inline]
    pub(crate) fn run(first: usize, row: &[f64], count: usize) -> Self {
        // Made as a whole where it has room for all: no vertex needs to find its place.
        match row.first_chunk::<ROOM>() {
            Some(row) if count <= ROOM => Self {
                vertices: SmallVec::from_buf_and_len(std::array::from_fn(|k| first + k), count),
                coefficients: SmallVec::from_buf_and_len(*row, count),
            },
            _ => Self { vertices: (first..first + count).collect(), coefficients: row[..count].into() },
        }
    }

    /// Adds `coefficient` at `vertex`, to what is there already where the vertex repeats.
    pub fn add(&mut self, vertex: usize, coefficient: f64) {
        match self.vertices.last() {
            Some(&last) if last >= vertex => match self.vertices.binary_search(&vertex) {
                Ok(at) => self.coefficients[at] += coefficient,
                Err(at) => {
                    self.vertices.insert(at, vertex);
                    self.coefficients.insert(at, coefficient);
                }
            },
            _ => {
                self.vertices.push(vertex);
                self.coefficients.push(coefficient);
            }
        }
    }

    /// The vertices, ascending.
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// The coefficient of each vertex.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// `(vertex, coefficient)` pairs.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.vertices.iter().copied().zip(self.coefficients.iter().copied())
    }

    /// `Σ S_i P_i`. Vertices that do not exist count as zero.
    pub fn apply(&self, points: &[Point]) -> Vector {
        self.iter().fold(Vector::zeros(), |sum, (i, c)| points.get(i).map_or(sum, |p| sum + p.coords * c))
    }

    /// The stencil times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for c in &mut self.coefficients {
            *c *= factor;
        }
        self
    }
}

impl FromIterator<(usize, f64)> for Stencil {
    fn from_iter<I: IntoIterator<Item = (usize, f64)>>(pairs: I) -> Self {
        let mut stencil = Self::new();
        for (vertex, coefficient) in pairs {
            stencil.add(vertex, coefficient);
        }
        stencil
    }
}
