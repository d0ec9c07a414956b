//! What is to be small, near to a shape as it is: squares of distances from where the feet are, and of energies.

use loftsman_kernel::Vector;
use loftsman_kernel::energy::Squares;
use loftsman_kernel::solve::Symmetric;

use super::foot::Foot;
use super::rows::Rows;

/// Half of `Σ ŵ |Π (S d + e)|² + Σ λ E(x + d)` as a quadratic of the adjustment `d` of the control vertices: `S` a foot's row, `e` the
/// shape's point less the given one, `Π` what is across the directions that the foot can go along, with the part `τ` of what is along
/// these. With `τ = 0` that is the square of the distance to first order, for the foot goes along; with `τ = 1` the foot stays, and the
/// quadratic is never less than what it is a model of.
pub(super) struct Model<'a> {
    pub(super) rows: Rows,
    feet: &'a [Foot],
    order: &'a [u32],
    shares: &'a [f64],
    energies: &'a [(f64, Squares)],
}

impl<'a> Model<'a> {
    /// `shares` are the weights of the points, their sum 1.
    pub(super) fn new(
        feet: &'a [Foot],
        order: &'a [u32],
        shares: &'a [f64],
        energies: &'a [(f64, Squares)],
    ) -> Self {
        let mut rows = Rows::default();
        feet.iter().for_each(|foot| rows.push(&foot.row));
        Self { rows, feet, order, shares, energies }
    }

    /// The mean square of the distances, and what the energies come to, at points `x` relative to the origin of these.
    pub(super) fn value(&self, x: &[Vector]) -> (f64, f64) {
        let squares =
            self.feet.iter().zip(self.shares).map(|(foot, share)| share * foot.distance * foot.distance);
        let energies = self.energies.iter().map(|(weight, squares)| weight * squares.energy(x).0);
        (squares.sum(), energies.sum())
    }

    /// `out = H d`.
    pub(super) fn multiply(&self, tau: f64, d: &[Vector], out: &mut [Vector]) {
        out.fill(Vector::zeros());
        for (k, (foot, share)) in self.feet.iter().zip(self.shares).enumerate() {
            let way = self.rows.sum(k, d);
            self.rows.spread(k, across(foot, tau, way) * *share, out);
        }
        let mut work = vec![Vector::zeros(); if self.energies.is_empty() { 0 } else { d.len() }];
        for (weight, squares) in self.energies {
            squares.gradient(d, false, &mut work);
            out.iter_mut().zip(&work).for_each(|(out, g)| *out += g * *weight);
        }
    }

    /// Half the gradient of what is to be small, at points `x` relative to the origin of the energies.
    pub(super) fn gradient(&self, x: &[Vector], out: &mut [Vector]) {
        out.fill(Vector::zeros());
        for (k, (foot, share)) in self.feet.iter().zip(self.shares).enumerate() {
            self.rows.spread(k, across(foot, 0.0, foot.away) * *share, out);
        }
        let mut work = vec![Vector::zeros(); if self.energies.is_empty() { 0 } else { x.len() }];
        for (weight, squares) in self.energies {
            squares.gradient(x, true, &mut work);
            out.iter_mut().zip(&work).for_each(|(out, g)| *out += g * *weight);
        }
    }

    /// The matrix of the model with `τ = 1`, the same for x, y and z: no other has more. Feet side by side share their vertices, so
    /// that most of it is added in dense blocks.
    pub(super) fn matrix(&self, count: usize) -> Symmetric {
        let mut lower: Vec<Vec<(u32, f64)>> = vec![Vec::new(); count];
        let mut block: (&[u32], Vec<f64>) = (&[], Vec::new());
        for &k in self.order {
            let k = k as usize;
            let (vertices, coefficients) = self.rows.row(k);
            if vertices != block.0 {
                flush(&block, &mut lower);
                block = (vertices, vec![0.0; vertices.len() * vertices.len()]);
            }
            for (line, a) in block.1.chunks_exact_mut(vertices.len().max(1)).zip(coefficients) {
                let by = self.shares[k] * a;
                line.iter_mut().zip(coefficients).for_each(|(sum, b)| *sum += by * b);
            }
        }
        flush(&block, &mut lower);
        for (weight, squares) in self.energies {
            squares.entries(|i, j, value| add(&mut lower, i, j, weight * value));
        }
        let entries = lower.into_iter().enumerate();
        let entries =
            entries.flat_map(|(i, row)| row.into_iter().map(move |(j, value)| (i, j as usize, value)));
        Symmetric::from_entries(count, entries)
    }
}

/// `Π + τ (1 - Π)`.
fn across(foot: &Foot, tau: f64, way: Vector) -> Vector {
    let along = foot.tangents[..foot.free].iter().map(|t| t * t.dot(&way));
    way - along.fold(Vector::zeros(), |sum, part| sum + part) * (1.0 - tau)
}

fn flush((vertices, block): &(&[u32], Vec<f64>), lower: &mut [Vec<(u32, f64)>]) {
    for (a, line) in block.chunks_exact(vertices.len().max(1)).enumerate() {
        for (b, value) in line.iter().enumerate() {
            if vertices[b] <= vertices[a] {
                add(lower, vertices[a] as usize, vertices[b] as usize, *value);
            }
        }
    }
}

fn add(lower: &mut [Vec<(u32, f64)>], i: usize, j: usize, value: f64) {
    let (i, j) = (i.max(j), i.min(j) as u32);
    let row = &mut lower[i];
    match row.binary_search_by_key(&j, |(column, _)| *column) {
        Ok(at) => row[at].1 += value,
        Err(at) => row.insert(at, (j, value)),
    }
}
