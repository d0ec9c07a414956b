//! An energy's squares, and tethers beside them.
//!
//! The matrix `AᵀA` is never relied on: its condition is the square of `A`'s (`n⁴` instead of `n²` for bending `n` vertices).
//! Residuals and products go through `A`; `AᵀA` only preconditions.

use std::ops::Deref;
use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::energy;

use crate::orthogonal::add;

/// `‖A P - r‖²` over the control vertices of one shape, beside what ties them to where they rest.
#[derive(Debug, Clone, Default)]
pub(crate) struct Squares {
    own: Arc<energy::Squares>,
    /// Tethers: `Σ τ_i |x_i - rest_i|²` beside all that, where there are any.
    tethers: Vec<f64>,
    rest: Vec<Vector>,
}

impl Deref for Squares {
    type Target = energy::Squares;

    fn deref(&self) -> &energy::Squares {
        &self.own
    }
}

impl From<energy::Squares> for Squares {
    fn from(own: energy::Squares) -> Self {
        Self { own: Arc::new(own), ..Self::default() }
    }
}

impl Squares {
    /// Ties every vertex to where it rests, with these weights.
    pub(crate) fn tether(&mut self, weights: &[f64], rest: &[Vector]) {
        self.tethers = weights.to_vec();
        self.rest = rest.to_vec();
    }

    /// The weight that ties each vertex; none where nothing is tied.
    pub(crate) fn tethers(&self) -> &[f64] {
        &self.tethers
    }

    /// The diagonal of `AᵀA`, the energy of each vertex's own motion; where that is nothing, the largest.
    pub(crate) fn stiffness(&self, count: usize) -> Vec<f64> {
        let mut stiffness = vec![0.0; count];
        for block in self.blocks() {
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                block.vertices.iter().zip(row).for_each(|(&v, c)| stiffness[v as usize] += c * c);
            }
        }
        let largest = stiffness.iter().fold(0.0, |m: f64, h| m.max(*h));
        stiffness.iter_mut().filter(|h| **h == 0.0).for_each(|h| *h = largest);
        stiffness
    }

    /// Whether a motion costs no energy: in no block more than this part of what the block's numbers would make of a motion
    /// as large. Tethers are left out.
    pub(crate) fn vanishes(&self, motion: &[f64], part: f64) -> bool {
        let far = motion.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        self.blocks().all(|block| {
            let (mut energy, mut size) = (0.0, 0.0);
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                let value: f64 = row.iter().zip(block.vertices).map(|(c, &v)| c * motion[v as usize]).sum();
                let all: f64 = row.iter().map(|c| c.abs()).sum();
                energy += value * value;
                size += all * all;
            }
            energy <= part * far * far * size
        })
    }

    /// The energy, and the sum of the squared sizes of the numbers that it comes from.
    pub(crate) fn energy(&self, x: &[Vector]) -> (f64, f64) {
        let (mut energy, mut size) = self.own.energy(x);
        for ((weight, x), rest) in self.tethers.iter().zip(x).zip(&self.rest) {
            energy += weight * (x - rest).norm_squared();
            size += weight * (x.abs() + rest.abs()).norm_squared();
        }
        (energy, size)
    }

    /// The largest force on a vertex, `|A|ᵀ(|A| |x| + |r|)`: what the parts of a gradient would come to if none cancelled.
    pub(crate) fn strain(&self, x: &[Vector]) -> f64 {
        let mut forces = vec![0.0; x.len()];
        for block in self.blocks() {
            for (row, target) in block.rows.chunks_exact(block.vertices.len().max(1)).zip(block.targets) {
                let terms = row.iter().zip(block.vertices);
                let all = terms
                    .clone()
                    .fold(target.lp_norm(1), |sum, (c, &v)| sum + c.abs() * x[v as usize].lp_norm(1));
                terms.for_each(|(c, &v)| forces[v as usize] += c.abs() * all);
            }
        }
        forces.into_iter().fold(0.0, f64::max)
    }

    /// Half the gradient; that of the squares without their targets where these are left out.
    pub(crate) fn gradient(&self, x: &[Vector], targets: bool, out: &mut [Vector]) {
        self.own.gradient(x, targets, out);
        for (((out, weight), x), rest) in out.iter_mut().zip(&self.tethers).zip(x).zip(&self.rest) {
            *out += if targets { x - rest } else { *x } * *weight;
        }
    }

    /// `(A V)ᵀ(A V)` of some motions, tethers left out.
    pub(crate) fn gram(&self, motions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut gram = vec![vec![0.0; motions.len()]; motions.len()];
        for block in self.blocks() {
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                let of = |m: &Vec<f64>| -> f64 {
                    row.iter().zip(block.vertices).map(|(c, &v)| c * m[v as usize]).sum()
                };
                let values: Vec<f64> = motions.iter().map(of).collect();
                for (line, value) in gram.iter_mut().zip(&values) {
                    add(line, *value, &values);
                }
            }
        }
        gram
    }
}
