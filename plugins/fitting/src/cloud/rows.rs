//! Sparse rows over control vertices, many of them.

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, Vector};

/// Rows, one behind the other.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    starts: Vec<usize>,
    vertices: Vec<u32>,
    coefficients: Vec<f64>,
}

impl Default for Rows {
    fn default() -> Self {
        Self { starts: vec![0], vertices: Vec::new(), coefficients: Vec::new() }
    }
}

impl Rows {
    /// One more.
    pub(super) fn push(&mut self, stencil: &Stencil) {
        for (vertex, coefficient) in stencil.iter() {
            self.vertices.push(vertex as u32);
            self.coefficients.push(coefficient);
        }
        self.starts.push(self.vertices.len());
    }

    /// One more, of others.
    pub(super) fn push_row(&mut self, (vertices, coefficients): (&[u32], &[f64])) {
        self.vertices.extend_from_slice(vertices);
        self.coefficients.extend_from_slice(coefficients);
        self.starts.push(self.vertices.len());
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The vertices and coefficients of a row.
    pub(super) fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.starts[row]..self.starts[row + 1];
        (&self.vertices[range.clone()], &self.coefficients[range])
    }

    /// A row's sum with points.
    pub(super) fn apply(&self, row: usize, points: &[Point]) -> Vector {
        let (vertices, coefficients) = self.row(row);
        vertices
            .iter()
            .zip(coefficients)
            .fold(Vector::zeros(), |sum, (&v, &c)| sum + points[v as usize].coords * c)
    }

    /// A row's sum with vectors.
    pub(super) fn sum(&self, row: usize, ways: &[Vector]) -> Vector {
        let (vertices, coefficients) = self.row(row);
        vertices.iter().zip(coefficients).fold(Vector::zeros(), |sum, (&v, &c)| sum + ways[v as usize] * c)
    }

    /// Adds a row times a vector.
    pub(super) fn spread(&self, row: usize, by: Vector, out: &mut [Vector]) {
        let (vertices, coefficients) = self.row(row);
        vertices.iter().zip(coefficients).for_each(|(&v, &c)| out[v as usize] += by * c);
    }
}
