//! An energy as a sum of squares `‖A P - r‖²`, `A` kept in small dense blocks: one for each knot span and datum.
//!
//! The matrix `AᵀA` is never relied on: its condition is the square of `A`'s (`n⁴` instead of `n²` for bending `n` vertices).
//! Residuals and products go through `A`; `AᵀA` only preconditions.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::{Point, Vector};

use crate::energy::{EnergySum, Term};
use crate::orthogonal::add;

/// `‖A P - r‖²` over the control vertices of one shape.
#[derive(Debug, Clone, Default)]
pub(crate) struct Squares {
    blocks: Vec<Block>,
    vertices: Vec<u32>,
    coefficients: Vec<f64>,
    /// `r`, a vector a row.
    targets: Vec<Vector>,
    /// The lowest order of derivative that is integrated; 0 where there is none.
    order: usize,
    /// Tethers: `Σ τ_i |x_i - rest_i|²` beside all that, where there are any.
    tethers: Vec<f64>,
    rest: Vec<Vector>,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    vertices: usize,
    width: usize,
    coefficients: usize,
    rows: usize,
    target: usize,
}

/// One block as its users see it: its vertices, and its rows one after another.
pub(crate) struct View<'a> {
    pub(crate) vertices: &'a [u32],
    pub(crate) rows: &'a [f64],
    pub(crate) targets: &'a [Vector],
}

impl Squares {
    /// The squares of an energy for a shape; points are taken relative to `origin`, which loses nothing of a shape far away.
    pub(crate) fn new(shape: &dyn Shape, energy: &EnergySum, origin: Point) -> Result<Self> {
        if energy.terms.is_empty() {
            return Err(Error::Invalid(
                "say what should be small: give an energy, \"stretch\", \"bend\" or \"variation\"".into(),
            ));
        }
        let mut squares = Self::default();
        for (weight, term) in &energy.terms {
            if !(*weight >= 0.0 && weight.is_finite()) {
                return Err(Error::Invalid(format!(
                    "an energy's weight is {weight}: every weight must be a finite number, and not negative"
                )));
            }
            if *weight == 0.0 {
                continue;
            }
            match term {
                Term::Derivative(order) => {
                    squares.order = if squares.order == 0 { *order } else { squares.order.min(*order) };
                    squares.integrals(shape, *order, *weight, None)?;
                }
                Term::Near => squares.integrals(shape, 0, *weight, Some(origin))?,
                Term::Data(points) => {
                    for datum in points {
                        let good = datum.weight > 0.0
                            && datum.weight.is_finite()
                            && datum.to.coords.iter().all(|c| c.is_finite());
                        if !good {
                            return Err(Error::Invalid(format!(
                                "the point to be near to at {} needs a positive weight and finite coordinates",
                                datum.at
                            )));
                        }
                        let stencil = shape.stencil(datum.at, Derivative::POSITION)?;
                        let root = (weight * datum.weight).sqrt();
                        squares.open(stencil.vertices().iter().copied());
                        let target = (datum.to - origin) * root;
                        squares.row(stencil.coefficients().iter().map(|c| c * root), target);
                    }
                }
            }
        }
        if squares.coefficients.iter().any(|c| !c.is_finite()) {
            return Err(Error::Invalid(
                "the energy overflows: the parameter's domain is too short or a weight too large".into(),
            ));
        }
        Ok(squares)
    }

    /// Ties every vertex to where it rests, with these weights.
    pub(crate) fn tether(&mut self, weights: &[f64], rest: &[Vector]) {
        self.tethers = weights.to_vec();
        self.rest = rest.to_vec();
    }

    /// The weight that ties each vertex; none where nothing is tied.
    pub(crate) fn tethers(&self) -> &[f64] {
        &self.tethers
    }

    pub(crate) fn blocks(&self) -> impl Iterator<Item = View<'_>> {
        self.blocks.iter().map(|b| View {
            vertices: &self.vertices[b.vertices..b.vertices + b.width],
            rows: &self.coefficients[b.coefficients..b.coefficients + b.rows * b.width],
            targets: &self.targets[b.target..b.target + b.rows],
        })
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

    /// The entries of `AᵀA`, each pair of vertices of a block once.
    pub(crate) fn entries(&self, mut add: impl FnMut(usize, usize, f64)) {
        for block in self.blocks() {
            for (a, &i) in block.vertices.iter().enumerate() {
                for (b, &j) in block.vertices[..=a].iter().enumerate() {
                    let width = block.vertices.len();
                    let sum = block.rows.chunks_exact(width).map(|row| row[a] * row[b]).sum();
                    add(i as usize, j as usize, sum);
                }
            }
        }
    }

    /// The lowest order of derivative that is integrated; 0 where there is none.
    pub(crate) fn order(&self) -> usize {
        self.order
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

    /// `‖A x - r‖²`, and the sum of the squared sizes of the numbers that it comes from.
    pub(crate) fn energy(&self, x: &[Vector]) -> (f64, f64) {
        let (mut energy, mut size) = (0.0, 0.0);
        for block in self.blocks() {
            for (row, target) in block.rows.chunks_exact(block.vertices.len()).zip(block.targets) {
                let (mut value, mut magnitude) = (-target, target.abs());
                for (c, &v) in row.iter().zip(block.vertices) {
                    value += x[v as usize] * *c;
                    magnitude += (x[v as usize] * *c).abs();
                }
                energy += value.norm_squared();
                size += magnitude.norm_squared();
            }
        }
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

    /// `out = Aᵀ(A x - r)`, or `AᵀA x` where the targets are left out.
    pub(crate) fn gradient(&self, x: &[Vector], targets: bool, out: &mut [Vector]) {
        out.fill(Vector::zeros());
        let mut local = Vec::with_capacity(64);
        let mut sum: Vec<Vector> = Vec::with_capacity(64);
        for block in self.blocks() {
            let width = block.vertices.len();
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

    /// A block over some vertices, to be filled with rows.
    pub(crate) fn open(&mut self, vertices: impl IntoIterator<Item = usize>) {
        let start = self.vertices.len();
        self.vertices.extend(vertices.into_iter().map(|v| v as u32));
        self.blocks.push(Block {
            vertices: start,
            width: self.vertices.len() - start,
            coefficients: self.coefficients.len(),
            rows: 0,
            target: self.targets.len(),
        });
    }

    /// A row of the block opened last, and its target.
    pub(crate) fn row(&mut self, coefficients: impl IntoIterator<Item = f64>, target: Vector) {
        self.coefficients.extend(coefficients);
        self.targets.push(target);
        if let Some(block) = self.blocks.last_mut() {
            block.rows += 1;
        }
    }

    /// The trace of `AᵀA`.
    pub(crate) fn trace(&self) -> f64 {
        self.coefficients.iter().map(|c| c * c).sum()
    }

    /// How many vertices the block opened last has.
    pub(crate) fn width(&self) -> usize {
        self.blocks.last().map_or(0, |b| b.width)
    }

    /// Adds terms to a row of the block opened last.
    pub(crate) fn place(&self, row: &mut [f64], terms: impl IntoIterator<Item = (usize, f64)>) {
        let Some(block) = self.blocks.last() else { return };
        let vertices = &self.vertices[block.vertices..block.vertices + block.width];
        for (vertex, value) in terms {
            if let Ok(at) = vertices.binary_search(&(vertex as u32)) {
                row[at] += value;
            }
        }
    }
}
