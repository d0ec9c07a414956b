//! An energy as a sum of squares.

use crate::Vector;
use crate::error::{Error, Result};

/// `‖A P - r‖²` over the control vertices of one shape, the same for x, y and z; `A` in small dense blocks, such as one for each
/// knot span.
///
/// The matrix `AᵀA` need not be relied on: its condition is the square of `A`'s (`n⁴` instead of `n²` for bending `n` vertices).
/// [Energies](Self::energy) and [gradients](Self::gradient) go through `A`.
#[derive(Debug, Clone, Default)]
pub struct Squares {
    blocks: Vec<Place>,
    vertices: Vec<u32>,
    coefficients: Vec<f64>,
    /// `r`, a vector a row.
    targets: Vec<Vector>,
    /// The lowest order of derivative that is integrated; 0 where there is none.
    order: usize,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    vertices: usize,
    width: usize,
    coefficients: usize,
    rows: usize,
    target: usize,
}

/// One block of [squares](Squares).
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    /// Its control vertices.
    pub vertices: &'a [u32],
    /// Its rows one after another, a coefficient for each of its vertices.
    pub rows: &'a [f64],
    /// A vector for each row.
    pub targets: &'a [Vector],
}

impl Squares {
    /// Opens a block over some control vertices, ascending, to be filled with [rows](Self::row).
    pub fn open(&mut self, vertices: impl IntoIterator<Item = usize>) {
        let start = self.vertices.len();
        self.vertices.extend(vertices.into_iter().map(|v| v as u32));
        self.blocks.push(Place {
            vertices: start,
            width: self.vertices.len() - start,
            coefficients: self.coefficients.len(),
            rows: 0,
            target: self.targets.len(),
        });
    }

    /// A row of the block opened last, a coefficient for each of its vertices, and what it should give.
    pub fn row(&mut self, coefficients: impl IntoIterator<Item = f64>, target: Vector) {
        self.coefficients.extend(coefficients);
        self.targets.push(target);
        if let Some(block) = self.blocks.last_mut() {
            block.rows += 1;
        }
    }

    /// How many vertices the block opened last has.
    pub fn width(&self) -> usize {
        self.blocks.last().map_or(0, |b| b.width)
    }

    /// Adds terms, each of a vertex, to a row for the block opened last.
    pub fn place(&self, row: &mut [f64], terms: impl IntoIterator<Item = (usize, f64)>) {
        let Some(block) = self.blocks.last() else { return };
        let vertices = &self.vertices[block.vertices..block.vertices + block.width];
        for (vertex, value) in terms {
            if let Ok(at) = vertices.binary_search(&(vertex as u32)) {
                row[at] += value;
            }
        }
    }

    /// Says that derivatives of an order are integrated: what a shape does between its pieces below that order, no square sees.
    pub fn differentiate(&mut self, order: usize) {
        self.order = if self.order == 0 { order } else { self.order.min(order) };
    }

    /// The lowest order of derivative that is integrated; 0 where there is none.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The blocks, in their order.
    pub fn blocks(&self) -> impl Iterator<Item = Block<'_>> {
        self.blocks.iter().map(|b| Block {
            vertices: &self.vertices[b.vertices..b.vertices + b.width],
            rows: &self.coefficients[b.coefficients..b.coefficients + b.rows * b.width],
            targets: &self.targets[b.target..b.target + b.rows],
        })
    }

    /// Whether all of it is finite, of vertices that there are, and every block has as many coefficients as its rows need.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, count: usize) -> Result<()> {
        let finite = self.coefficients.iter().all(|c| c.is_finite())
            && self.targets.iter().all(|t| t.iter().all(|c| c.is_finite()));
        if !finite {
            return Err(Error::Invalid(
                "the energy overflows: the parameter's domain is too short or a weight too large".into(),
            ));
        }
        if let Some(v) = self.vertices.iter().find(|v| **v as usize >= count) {
            return Err(Error::Invalid(format!(
                "an energy asks for control vertex {v}, but there are {count}, numbered from 0"
            )));
        }
        let ends = self.blocks.iter().skip(1).map(|b| b.coefficients).chain([self.coefficients.len()]);
        if self.blocks.iter().zip(ends).any(|(b, end)| end - b.coefficients != b.rows * b.width) {
            return Err(Error::Invalid(
                "a row of an energy has another number of coefficients than its block has control vertices"
                    .into(),
            ));
        }
        Ok(())
    }

    /// The trace of `AᵀA`.
    pub fn trace(&self) -> f64 {
        self.coefficients.iter().map(|c| c * c).sum()
    }

    /// The entries of `AᵀA`, each pair of vertices of a block once.
    pub fn entries(&self, mut add: impl FnMut(usize, usize, f64)) {
        for block in self.blocks() {
            for (a, &i) in block.vertices.iter().enumerate() {
                for (b, &j) in block.vertices[..=a].iter().enumerate() {
                    let width = block.vertices.len().max(1);
                    let sum = block.rows.chunks_exact(width).map(|row| row[a] * row[b]).sum();
                    add(i as usize, j as usize, sum);
                }
            }
        }
    }

    /// `‖A x - r‖²`, and the sum of the squared sizes of the numbers that it comes from.
    pub fn energy(&self, x: &[Vector]) -> (f64, f64) {
        let (mut energy, mut size) = (0.0, 0.0);
        for block in self.blocks() {
            for (row, target) in block.rows.chunks_exact(block.vertices.len().max(1)).zip(block.targets) {
                let (mut value, mut magnitude) = (-target, target.abs());
                for (c, &v) in row.iter().zip(block.vertices) {
                    value += x[v as usize] * *c;
                    magnitude += (x[v as usize] * *c).abs();
                }
                energy += value.norm_squared();
                size += magnitude.norm_squared();
            }
        }
        (energy, size)
    }

    /// `out = Aᵀ(A x - r)`, or `AᵀA x` where the targets are left out.
    pub fn gradient(&self, x: &[Vector], targets: bool, out: &mut [Vector]) {
        out.fill(Vector::zeros());
        let mut local = Vec::with_capacity(64);
        let mut sum: Vec<Vector> = Vec::with_capacity(64);
        for block in self.blocks() {
            let width = block.vertices.len().max(1);
            local.clear();
            local.extend(block.vertices.iter().map(|&v| x[v as usize]));
            sum.clear();
            sum.resize(width, Vector::zeros());
            for (row, target) in block.rows.chunks_exact(width).zip(block.targets) {
                let mut value = if targets { -target } else { Vector::zeros() };
                for (c, x) in row.iter().zip(&local) {
                    value += x * *c;
                }
                for (c, sum) in row.iter().zip(&mut sum) {
                    *sum += value * *c;
                }
            }
            for (&v, sum) in block.vertices.iter().zip(&sum) {
                out[v as usize] += sum;
            }
        }
    }
}
