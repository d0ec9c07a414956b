//! The least change under equations that are others at every step, in a metric that stays.
//!
//! A simulation asks at every step for accelerations `x`, least in the mass metric `W`, under `L x + L_s s = e` with other rows each
//! time, and for the floating parameters' `s`, which cost `½ ε s²` each. With `W = C Cᵀ` factored once, the rows are solved
//! half, `Y = C⁻¹Lᵀ`: in a banded metric these die away within some dozens of vertices, so that they cost nothing that grows with the
//! curve. Then
//!
//! ```text
//! R = YᵀY = L W⁻¹ Lᵀ,   (R + L_s L_sᵀ/ε) λ = e - Yᵀ C⁻¹ f,   x = C⁻ᵀ(C⁻¹ f + Y λ),   ε s = L_sᵀ λ,
//! ```
//!
//! which is paper 3's equation (13), `f` being the forces; and for `ε = 0` its (11). Both are `S s = L_sᵀ R⁻¹ e`, `S = ε + L_sᵀ R⁻¹ L_s`, where `R`
//! has full rank. All in all one solve in the metric a step, whatever the rows.

mod dense;
mod rows;
#[cfg(test)]
mod tests;
mod weight;

use std::ops::Range;

pub use self::weight::Weight;

/// Rows, their half-solves and the small dense system of their products. Rows are pushed, then [factored](Self::factor) and
/// [solved](Self::solve); after the first steps nothing is allocated.
#[derive(Debug, Clone)]
pub struct RangeSpace {
    blocks: Vec<Block>,
    count: usize,
    /// Whether unknowns are coordinates, which the metric may couple.
    coordinates: bool,
    rows: Vec<Row>,
    /// The vertices of all rows, and their coefficients: one a vertex, or three.
    vertices: Vec<usize>,
    coefficients: Vec<f64>,
    pieces: Vec<Piece>,
    values: Vec<f64>,
    equations: usize,
    /// `L_s`: a row for each equation.
    free: Vec<f64>,
    parameters: usize,
    weight: f64,
    /// Of each parameter, how much stiffer it is than the rows make it.
    damping: Vec<f64>,
    /// What `L_s L_sᵀ` has of the small matrix.
    share: f64,
    /// How the small system is solved.
    small: Small,
    gram: Vec<f64>,
    /// `G⁻¹ L_s`, half solved, and the factor of `S`.
    half: Vec<f64>,
    schur: Vec<f64>,
    work: Vec<f64>,
    touched: Vec<usize>,
    forces: Vec<f64>,
    right: Vec<f64>,
    missed: Vec<f64>,
    rates: Vec<f64>,
    solved: Vec<f64>,
}

#[derive(Debug, Clone)]
struct Block {
    weight: Weight,
    start: usize,
    tails: [usize; 2],
    /// Where in the factor each vertex stands, if not in its own order.
    places: Option<Vec<usize>>,
}

#[derive(Debug, Clone)]
struct Row {
    alike: bool,
    equation: usize,
    vertices: Range<usize>,
    coefficients: usize,
    pieces: Range<usize>,
}

/// Half-solved entries of vertices (in the factor's order, through all blocks) from `start` on.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: usize,
    len: usize,
    at: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Small {
    /// x, y and z share one matrix of a third of the size.
    #[default]
    Alike,
    /// All equations, `R`.
    Whole,
    /// `R + L_s L_sᵀ`, for rows that depend on one another but for their parameters.
    Combined,
}

impl RangeSpace {
    /// For vertices with these metrics, block after block. Each may name an order: position in the factor → vertex of the block.
    pub fn new(weights: impl IntoIterator<Item = (Weight, Option<Vec<usize>>)>) -> Self {
        let (mut blocks, mut start, mut coordinates) = (Vec::new(), 0, false);
        for (weight, order) in weights {
            let places = order.map(|order| {
                let mut places = vec![0; order.len()];
                order.iter().enumerate().for_each(|(place, &vertex)| places[vertex] = place);
                places
            });
            coordinates |= matches!(weight, Weight::Coordinates(_));
            let (tails, count) = (weight.tails(), weight.vertices());
            blocks.push(Block { weight, start, tails, places });
            start += count;
        }
        Self {
            blocks,
            count: start,
            coordinates,
            rows: Vec::new(),
            vertices: Vec::new(),
            coefficients: Vec::new(),
            pieces: Vec::new(),
            values: Vec::new(),
            equations: 0,
            free: Vec::new(),
            parameters: 0,
            weight: 0.0,
            damping: Vec::new(),
            share: 0.0,
            small: Small::Alike,
            gram: Vec::new(),
            half: Vec::new(),
            schur: Vec::new(),
            work: vec![0.0; 3 * start],
            touched: Vec::new(),
            forces: vec![0.0; 3 * start],
            right: Vec::new(),
            missed: Vec::new(),
            rates: Vec::new(),
            solved: Vec::new(),
        }
    }

    /// The metric of a block, to be put anew. Its rows must be pushed again.
    pub fn weight_mut(&mut self, block: usize) -> Option<&mut Weight> {
        self.blocks.get_mut(block).map(|block| &mut block.weight)
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.count
    }

    /// How many equations have been pushed.
    pub fn equations(&self) -> usize {
        self.equations
    }

    /// Forgets all rows and parameters.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.vertices.clear();
        self.coefficients.clear();
        self.pieces.clear();
        self.values.clear();
        self.equations = 0;
        self.free.clear();
        self.parameters = 0;
    }

    /// The small system of the rows' products. How many of the equations are independent; what depends on those before it takes no part.
    /// `O(m³)` for `m` equations, a third of them where all are alike.
    pub fn factor(&mut self) -> usize {
        self.small = if self.rows.iter().all(|row| row.alike) { Small::Alike } else { Small::Whole };
        let mut rank = self.factor_products(0.0);
        if rank < self.equations && self.parameters > 0 {
            // What the vertices do not tell apart, the parameters may.
            self.small = Small::Combined;
            let products: f64 = self.rows.iter().map(|row| self.product(row, row, 0, 0).abs()).sum();
            let changes: f64 = self.free.iter().map(|v| v * v).sum();
            let share = match self.weight {
                0.0 if changes > 0.0 && products > 0.0 => products / changes,
                0.0 => 1.0,
                weight => 1.0 / weight,
            };
            self.share = share;
            rank = self.factor_products(share);
        }
        if self.parameters > 0 {
            self.factor_schur();
        }
        rank
    }

    /// The number of rows of the small matrix, and how many numbers each has in a right-hand side.
    fn small(&self) -> (usize, usize) {
        if self.small == Small::Alike { (self.rows.len(), 3) } else { (self.equations, 1) }
    }

    fn factor_products(&mut self, share: f64) -> usize {
        let (n, sides) = self.small();
        let mut gram = std::mem::take(&mut self.gram);
        gram.clear();
        gram.resize(n * n, 0.0);
        for (a, one) in self.rows.iter().enumerate() {
            for (b, other) in self.rows[..=a].iter().enumerate() {
                if sides == 3 {
                    gram[a * n + b] = self.product(one, other, 0, 0);
                    continue;
                }
                let axes = |row: &Row| if row.alike { 3 } else { 1 };
                for i in 0..axes(one) {
                    for j in 0..axes(other) {
                        let value = self.product(one, other, i, j);
                        gram[(one.equation + i) * n + other.equation + j] = value;
                    }
                }
            }
        }
        if self.small == Small::Combined {
            let k = self.parameters;
            for i in 0..n {
                for j in 0..=i {
                    let (a, b) = (&self.free[i * k..(i + 1) * k], &self.free[j * k..(j + 1) * k]);
                    gram[i * n + j] += share * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                }
            }
        }
        let rank = dense::factor(&mut gram, n) * sides;
        self.gram = gram;
        rank
    }

    /// The product of two half-solved rows: of their equations for the axes `i` and `j`, where they are alike.
    fn product(&self, one: &Row, other: &Row, i: usize, j: usize) -> f64 {
        if one.alike && other.alike && i != j {
            return 0.0;
        }
        let (a, b) = (&self.pieces[one.pieces.clone()], &self.pieces[other.pieces.clone()]);
        let (mut x, mut y, mut sum) = (0, 0, 0.0);
        while x < a.len() && y < b.len() {
            let (p, q) = (a[x], b[y]);
            let (from, to) = (p.start.max(q.start), (p.start + p.len).min(q.start + q.len));
            if from < to {
                let count = to - from;
                sum += match (one.alike, other.alike) {
                    (true, true) => {
                        let (p, q) =
                            (&self.values[p.at + from - p.start..], &self.values[q.at + from - q.start..]);
                        super::envelope::dot(&p[..count], &q[..count])
                    }
                    (false, false) => {
                        let p = &self.values[p.at + 3 * (from - p.start)..][..3 * count];
                        let q = &self.values[q.at + 3 * (from - q.start)..][..3 * count];
                        super::envelope::dot(p, q)
                    }
                    (true, false) => {
                        let p = &self.values[p.at + from - p.start..][..count];
                        let q = self.values[q.at + 3 * (from - q.start)..].chunks_exact(3);
                        p.iter().zip(q).map(|(p, q)| p * q[i]).sum()
                    }
                    (false, true) => {
                        let p = self.values[p.at + 3 * (from - p.start)..].chunks_exact(3);
                        let q = &self.values[q.at + from - q.start..][..count];
                        q.iter().zip(p).map(|(q, p)| q * p[j]).sum()
                    }
                };
            }
            if p.start + p.len <= q.start + q.len { x += 1 } else { y += 1 }
        }
        sum
    }

    /// `S = ε + L_sᵀ G⁻¹ L_s`, of the parameters.
    fn factor_schur(&mut self) {
        let ((n, sides), k) = (self.small(), self.parameters);
        self.half.clear();
        self.half.extend_from_slice(&self.free);
        dense::forward(&self.gram, n, &mut self.half, sides * k);
        self.schur.clear();
        self.schur.resize(k * k, 0.0);
        for row in self.half.chunks_exact(k) {
            for i in 0..k {
                for j in 0..=i {
                    self.schur[i * k + j] += row[i] * row[j];
                }
            }
        }
        if self.weight == 0.0 {
            for i in 0..k {
                self.schur[i * k + i] *= 1.0 + self.damping[i];
            }
        }
        // With the parameters' share in G, they are told by L_sᵀλ alone; without weight they are unknowns still.
        if self.small != Small::Combined {
            (0..k).for_each(|i| self.schur[i * k + i] += self.weight);
        }
        dense::factor(&mut self.schur, k);
    }

    /// `x`, in place of the forces `f` (three numbers a vertex), the multipliers `λ` of all equations and the parameters' `s`:
    /// `W x = f + Lᵀλ`, `L x + L_s s = e`, `ε s = L_sᵀλ`. The answer is measured in the rows as they were pushed, and corrected
    /// where it misses by more than rounding; the largest error that stays in equations that take part is handed out, relative to
    /// the largest of the equations' right-hand sides and terms. The cost is one solve in the metric, and `O(m²)`.
    pub fn solve(&mut self, x: &mut [f64], e: &[f64], multipliers: &mut [f64], s: &mut [f64]) -> f64 {
        let mut forces = std::mem::take(&mut self.forces);
        self.arrange(x, &mut forces, true);
        for block in &self.blocks {
            block.weight.forward(&mut forces[3 * block.start..3 * (block.start + block.weight.vertices())]);
        }
        let mut right = std::mem::take(&mut self.right);
        right.clear();
        right.extend_from_slice(e);
        self.subtract_products(&forces, &mut right);
        multipliers.fill(0.0);
        s.fill(0.0);
        let mut missed = std::mem::take(&mut self.missed);
        missed.clear();
        missed.resize(self.equations, 0.0);
        let mut error = 0.0;
        for round in 0..3 {
            self.solve_small(&mut right, multipliers, s);
            self.add_rows(&right, &mut forces);
            self.arrange(x, &mut forces, false);
            if self.equations == 0 {
                break;
            }
            self.apply(x, s, &mut missed);
            let size = e.iter().chain(&missed).fold(0.0_f64, |size, v| size.max(v.abs()));
            missed.iter_mut().zip(e).for_each(|(m, e)| *m = e - *m);
            self.silence(&mut missed);
            let now = missed.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
            error = if size > 0.0 { now / size } else { 0.0 };
            if round == 2 || error.is_nan() || error <= 1e-13 {
                break;
            }
            right.copy_from_slice(&missed);
        }
        (self.forces, self.right, self.missed) = (forces, right, missed);
        error
    }

    /// What depends on others takes no part.
    fn silence(&self, equations: &mut [f64]) {
        let (n, sides) = self.small();
        for i in 0..n {
            if self.gram[i * n + i] == 0.0 {
                equations[i * sides..(i + 1) * sides].fill(0.0);
            }
        }
    }

    /// Vertices in their own order to the factors' (`in_order`: from `x`); or solved back, to `x`.
    fn arrange(&mut self, x: &mut [f64], forces: &mut [f64], in_order: bool) {
        if in_order {
            forces.copy_from_slice(x);
        } else {
            x.copy_from_slice(forces);
        }
        for block in &self.blocks {
            let range = 3 * block.start..3 * (block.start + block.weight.vertices());
            let x = &mut x[range.clone()];
            if !in_order {
                block.weight.backward(x);
            }
            let Some(places) = &block.places else { continue };
            let (into, from) = (&mut forces[range], x);
            if in_order {
                for (vertex, place) in places.iter().enumerate() {
                    into[3 * place..3 * place + 3].copy_from_slice(&from[3 * vertex..3 * vertex + 3]);
                }
            } else {
                // The half-solved forces stay: they are solved back into another room first.
                self.solved.clear();
                self.solved.extend_from_slice(from);
                let solved = &self.solved;
                for (vertex, place) in places.iter().enumerate() {
                    from[3 * vertex..3 * vertex + 3].copy_from_slice(&solved[3 * place..3 * place + 3]);
                }
            }
        }
    }

    /// `right ← right - Yᵀ w`.
    fn subtract_products(&self, w: &[f64], right: &mut [f64]) {
        for row in &self.rows {
            for piece in &self.pieces[row.pieces.clone()] {
                let w = &w[3 * piece.start..3 * (piece.start + piece.len)];
                if row.alike {
                    let values = &self.values[piece.at..piece.at + piece.len];
                    let out = &mut right[row.equation..row.equation + 3];
                    for (y, w) in values.iter().zip(w.chunks_exact(3)) {
                        for axis in 0..3 {
                            out[axis] -= y * w[axis];
                        }
                    }
                } else {
                    right[row.equation] -=
                        super::envelope::dot(&self.values[piece.at..piece.at + 3 * piece.len], w);
                }
            }
        }
    }

    /// `w ← w + Y λ`.
    fn add_rows(&self, multipliers: &[f64], w: &mut [f64]) {
        for row in &self.rows {
            for piece in &self.pieces[row.pieces.clone()] {
                let w = &mut w[3 * piece.start..3 * (piece.start + piece.len)];
                if row.alike {
                    let lambda = &multipliers[row.equation..row.equation + 3];
                    let values = &self.values[piece.at..piece.at + piece.len];
                    for (y, w) in values.iter().zip(w.chunks_exact_mut(3)) {
                        for axis in 0..3 {
                            w[axis] += y * lambda[axis];
                        }
                    }
                } else {
                    let lambda = multipliers[row.equation];
                    let values = &self.values[piece.at..piece.at + 3 * piece.len];
                    w.iter_mut().zip(values).for_each(|(w, y)| *w += y * lambda);
                }
            }
        }
    }

    /// The multipliers of one right-hand side, in its place, and added to `multipliers` and `s`.
    fn solve_small(&mut self, right: &mut [f64], multipliers: &mut [f64], s: &mut [f64]) {
        let ((n, sides), k) = (self.small(), self.parameters);
        dense::forward(&self.gram, n, right, sides);
        let by_multipliers = self.small == Small::Combined && self.weight > 0.0;
        if k > 0 && !by_multipliers {
            let mut rates = std::mem::take(&mut self.rates);
            rates.clear();
            rates.resize(k, 0.0);
            for (right, row) in right.iter().zip(self.half.chunks_exact(k)) {
                rates.iter_mut().zip(row).for_each(|(rate, half)| *rate += half * right);
            }
            dense::forward(&self.schur, k, &mut rates, 1);
            dense::backward(&self.schur, k, &mut rates, 1);
            for (right, row) in right.iter_mut().zip(self.half.chunks_exact(k)) {
                *right -= row.iter().zip(&rates).map(|(half, rate)| half * rate).sum::<f64>();
            }
            s.iter_mut().zip(&rates).for_each(|(s, rate)| *s += rate);
            self.rates = rates;
        }
        dense::backward(&self.gram, n, right, sides);
        if k > 0 && by_multipliers {
            for (lambda, row) in right.iter().zip(self.free.chunks_exact(k)) {
                s.iter_mut().zip(row).for_each(|(s, change)| *s += change * lambda / self.weight);
            }
        } else if k > 0 && self.small == Small::Combined && self.damping.iter().any(|d| *d > 0.0) {
            // What is damped leaves `L_sᵀλ`: its share in G is a part of the parameter.
            for (lambda, row) in right.iter().zip(self.free.chunks_exact(k)) {
                s.iter_mut().zip(row).for_each(|(s, change)| *s += self.share * change * lambda);
            }
        }
        multipliers.iter_mut().zip(&*right).for_each(|(all, new)| *all += new);
    }
}
