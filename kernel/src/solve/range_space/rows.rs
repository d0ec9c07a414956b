//! Rows as they come: pushed, half-solved, and looked at again.

use super::{Piece, RangeSpace, Row, Weight};
use crate::solve::system::SparseRows;

impl RangeSpace {
    /// Three equations `Σ c_k x_k = e`, of x, y and z, which share the coefficients. A vertex may repeat.
    pub fn push_alike(&mut self, entries: impl Iterator<Item = (usize, f64)> + Clone) {
        if self.coordinates {
            for axis in 0..3 {
                let unit = move |c: f64| std::array::from_fn(|k| if k == axis { c } else { 0.0 });
                self.push_coupled(entries.clone().map(|(v, c)| (v, unit(c))));
            }
            return;
        }
        let row = self.open(true);
        for (vertex, c) in entries {
            self.vertices.push(vertex);
            self.coefficients.push(c);
        }
        self.close::<1>(row);
    }

    /// One equation `Σ a_k · x_k = e`. A vertex may repeat.
    pub fn push_coupled(&mut self, entries: impl Iterator<Item = (usize, [f64; 3])>) {
        let row = self.open(false);
        for (vertex, a) in entries {
            self.vertices.push(vertex);
            self.coefficients.extend_from_slice(&a);
        }
        self.close::<3>(row);
    }

    fn open(&self, alike: bool) -> Row {
        let (vertices, pieces) = (self.vertices.len(), self.pieces.len());
        Row {
            alike,
            equation: self.equations,
            vertices: vertices..vertices,
            coefficients: self.coefficients.len(),
            pieces: pieces..pieces,
        }
    }

    /// Solves the row half, block after block.
    fn close<const S: usize>(&mut self, mut row: Row) {
        row.vertices.end = self.vertices.len();
        let Self { blocks, vertices, coefficients, pieces, values, work, touched, .. } = self;
        let entries = &vertices[row.vertices.clone()];
        for block in blocks.iter() {
            let (start, count) = (block.start, block.weight.vertices());
            touched.clear();
            let x = &mut work[start * S..(start + count) * S];
            for (k, vertex) in entries.iter().enumerate() {
                let Some(own) = vertex.checked_sub(start).filter(|own| *own < count) else { continue };
                let place = block.places.as_ref().map_or(own, |places| places[own]);
                touched.push(place);
                for s in 0..S {
                    x[place * S + s] += coefficients[row.coefficients + k * S + s];
                }
            }
            if matches!(block.weight, Weight::Still(_)) {
                touched.iter().for_each(|t| x[t * S..(t + 1) * S].fill(0.0));
                continue;
            }
            let first = pieces.len();
            block.weight.forward_row::<S>(x, touched, block.tails, |range| {
                if range.start < range.end {
                    pieces.push(Piece { start: range.start, len: range.end - range.start, at: 0 });
                }
            });
            for piece in &mut pieces[first..] {
                let part = &mut x[piece.start * S..(piece.start + piece.len) * S];
                piece.at = values.len();
                values.extend_from_slice(part);
                part.fill(0.0);
                piece.start += start;
            }
        }
        row.pieces.end = self.pieces.len();
        self.equations += if row.alike { 3 } else { 1 };
        self.rows.push(row);
    }

    /// So many parameters float, each with `½ weight · s²`; with 0 they cost nothing. [`change`](Self::change) says what they do.
    pub fn float(&mut self, parameters: usize, weight: f64) {
        (self.parameters, self.weight) = (parameters, weight);
        self.damping.clear();
        self.damping.resize(parameters, 0.0);
        self.free.clear();
        self.free.resize(parameters * self.equations, 0.0);
    }

    /// Lets a parameter without weight go a `1 / (1 + factor)` of its way: beside the rows' own stiffness `L_sᵀG⁻¹L_s` it has `factor`
    /// times as much more. For iterations of a system that changes along with its parameters, which would overshoot: all equations are met, and
    /// where the parameter rests, `L_sᵀλ = 0` holds as it does without.
    pub fn damp(&mut self, parameter: usize, factor: f64) {
        if let Some(damping) = self.damping.get_mut(parameter) {
            *damping = factor.max(0.0);
        }
    }

    /// Adds to how an equation changes with a parameter: an entry of `L_s`.
    pub fn change(&mut self, equation: usize, parameter: usize, by: f64) {
        self.free[equation * self.parameters + parameter] += by;
    }

    /// `L x + L_s s` of all equations, into `out`.
    pub fn apply(&self, x: &[f64], s: &[f64], out: &mut [f64]) {
        for row in &self.rows {
            let vertices = &self.vertices[row.vertices.clone()];
            if row.alike {
                let coefficients = &self.coefficients[row.coefficients..];
                let mut sum = [0.0; 3];
                for (&v, c) in vertices.iter().zip(coefficients) {
                    for axis in 0..3 {
                        sum[axis] += c * x[3 * v + axis];
                    }
                }
                out[row.equation..row.equation + 3].copy_from_slice(&sum);
            } else {
                let coefficients = self.coefficients[row.coefficients..].chunks_exact(3);
                let terms = vertices.iter().zip(coefficients);
                out[row.equation] =
                    terms.map(|(&v, a)| (0..3).map(|k| a[k] * x[3 * v + k]).sum::<f64>()).sum();
            }
        }
        if self.parameters > 0 {
            for (out, row) in out.iter_mut().zip(self.free.chunks_exact(self.parameters)) {
                *out += row.iter().zip(s).map(|(a, s)| a * s).sum::<f64>();
            }
        }
    }

    /// Every entry of `L` as `(equation, coordinate, value)`, coordinates being `3 · vertex + axis`; a pair may come repeatedly, and its values
    /// add up. Vertices that stay have theirs, too.
    pub fn entries(&self, mut each: impl FnMut(usize, usize, f64)) {
        for row in &self.rows {
            let coefficients = &self.coefficients[row.coefficients..];
            for (k, &vertex) in self.vertices[row.vertices.clone()].iter().enumerate() {
                for axis in 0..3 {
                    if row.alike {
                        each(row.equation + axis, 3 * vertex + axis, coefficients[k]);
                    } else {
                        each(row.equation, 3 * vertex + axis, coefficients[3 * k + axis]);
                    }
                }
            }
        }
    }

    /// All rows `[L L_s]` over the coordinates that they touch and that move, ascending, and the parameters: for a look at what depends on
    /// what. Allocates.
    pub fn rows(&self) -> SparseRows {
        let moves = |vertex: usize| {
            let block = self.blocks.iter().rfind(|block| block.start <= vertex);
            block.is_some_and(|block| !matches!(block.weight, Weight::Still(_)))
        };
        let mut touched: Vec<usize> = self.vertices.iter().copied().filter(|&v| moves(v)).collect();
        touched.sort_unstable();
        touched.dedup();
        let place = |vertex: &usize| touched.binary_search(vertex).ok();
        let width = 3 * touched.len();
        let mut all = SparseRows::new(width + self.parameters);
        for row in &self.rows {
            let vertices = &self.vertices[row.vertices.clone()];
            let coefficients = &self.coefficients[row.coefficients..];
            for own in 0..if row.alike { 3 } else { 1 } {
                let mut dense = vec![0.0; width];
                for (k, vertex) in vertices.iter().enumerate() {
                    let Some(at) = place(vertex) else { continue };
                    if row.alike {
                        dense[3 * at + own] += coefficients[k];
                    } else {
                        (0..3).for_each(|axis| dense[3 * at + axis] += coefficients[3 * k + axis]);
                    }
                }
                let equation = row.equation + own;
                let free = &self.free[equation * self.parameters..(equation + 1) * self.parameters];
                let terms = dense.into_iter().chain(free.iter().copied()).enumerate();
                all.push(terms.filter(|(_, value)| *value != 0.0));
            }
        }
        all
    }
}
