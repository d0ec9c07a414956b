//! Constraints that are not linear, as a border of the factored system of those that are.
//!
//! With `F d = b` the linear constraints and `G` the gradients of the others where the shapes are, the least adjustment of
//! the linearized problem is `d = d_F + Q μ`: `d_F` meets the linear constraints alone, `Q = W⁻¹Gᵀ - C (F W⁻¹Gᵀ)` are the
//! gradients with everything taken out that would disturb those (`C = W⁻¹Fᵀ(FW⁻¹Fᵀ)⁻¹`, factored at mouse down), and
//! `S μ = …` with the small matrix `S = G Q`. So an event redoes only the rows that change: `O(n)` for each that touches
//! all vertices, whatever the linear constraints are.

mod dense;
mod scatter;

use self::dense::{add, cholesky, dot, solve};
use self::scatter::{Stray, scatter};
use super::support::strayed;
use crate::Point;
use crate::error::Result;
use crate::functional::{Equation, Linearity, Shapes, Store, linearize_of};
use crate::problem::assembly::Assembly;
use crate::problem::bound::BoundConstraint;
use crate::solve::{Factored, InverseMetric, SolveError};

/// The most equations that a border may have; more are solved as one system.
const MOST: usize = 16;

/// The constraints of a session that are not linear, and what is known of them.
pub(super) struct Border {
    /// Vertices that a gradient reaches and that are not among those that move: those that never may, and those that it did
    /// not reach where the shapes were when prepared.
    fixed: Vec<usize>,
    pub(super) strayed: Vec<usize>,
    /// Constraint and equation of each row.
    pub(super) rows: Vec<(usize, usize)>,
    members: Vec<usize>,
    inverse: InverseMetric,
    moving: Moving,
    sides: usize,
    store: Store,
    numbers: Vec<f64>,
    raised: Vec<f64>,
    work: Vec<f64>,
    /// `F q` of a projected gradient, which should vanish.
    missed: Vec<f64>,
    /// Linearized where the shapes were when prepared, and where they are now.
    pub(super) base: Linearization,
    pub(super) here: Linearization,
    /// The adjustment that meets the linear constraints, and the last one that met all.
    pub(super) linear: Vec<f64>,
    pub(super) before: Vec<f64>,
    /// Whether an event has succeeded since it was prepared.
    pub(super) moved: bool,
    /// The adjustment that is tried next.
    pub(super) next: Vec<f64>,
    /// The tangential way that was remembered last.
    way: Vec<f64>,
    /// The size of the coordinates that the shapes started with, as a length over all of them.
    pub(super) reach: f64,
    /// Multipliers of the rows.
    pub(super) multipliers: Vec<f64>,
    right: Vec<f64>,
}

/// Values and gradients at one state of the shapes; a row is as wide as an adjustment.
#[derive(Debug, Clone, Default)]
pub(super) struct Linearization {
    pub(super) value: Vec<f64>,
    gradient: Vec<f64>,
    /// `Q`.
    projected: Vec<f64>,
    /// `F W⁻¹ g` of each row.
    coupling: Vec<f64>,
    /// `S`, then its Cholesky factor with reciprocal diagonal.
    schur: Vec<f64>,
}

/// Which vertices move, by global number.
enum Moving {
    /// All from the first on.
    Run(usize, usize),
    /// These, ascending.
    Some(Vec<usize>),
}

impl Moving {
    fn new(vertices: Vec<usize>) -> Self {
        match (vertices.first(), vertices.last()) {
            (Some(&first), Some(&last)) if last - first + 1 == vertices.len() => Self::Run(first, last),
            _ => Self::Some(vertices),
        }
    }

    fn place(&self, vertex: usize) -> Option<usize> {
        match self {
            Self::Run(first, last) => (vertex >= *first && vertex <= *last).then(|| vertex - first),
            Self::Some(all) => all.binary_search(&vertex).ok(),
        }
    }
}

/// The constraints that go to the border: those that are not linear, where they are few.
pub(super) fn members(bound: &[BoundConstraint]) -> Vec<usize> {
    let curved = |b: &BoundConstraint| b.constraint.functional.linearity() != Linearity::Linear;
    let members: Vec<usize> = (0..bound.len()).filter(|&k| curved(&bound[k])).collect();
    let rows: usize = members.iter().map(|&k| bound[k].constraint.functional.equations()).sum();
    if rows > MOST { Vec::new() } else { members }
}

impl Border {
    /// The border of an assembly of the linear constraints, not yet linearized. `moving` are global vertices, ascending.
    pub(super) fn new(
        members: Vec<usize>,
        bound: &[BoundConstraint],
        assembly: &Assembly,
        moving: Vec<usize>,
        base: &[Point],
    ) -> Result<Self, SolveError> {
        let reach = base.iter().map(|p| p.coords.norm_squared()).sum::<f64>().sqrt();
        let asked = |&k: &usize| {
            let constraint = &bound[k].constraint;
            (0..constraint.functional.equations()).filter(|&e| constraint.asks(e)).map(move |e| (k, e))
        };
        let rows: Vec<(usize, usize)> = members.iter().flat_map(asked).collect();
        let most = members.iter().map(|&k| bound[k].constraint.functional.equations()).max().unwrap_or(0);
        let (m, width) = (rows.len(), 3 * moving.len());
        let system = &assembly.system;
        let room = Linearization {
            value: vec![0.0; m],
            gradient: vec![0.0; m * width],
            projected: vec![0.0; m * width],
            coupling: vec![0.0; m * system.rows().len() * system.sides()],
            schur: vec![0.0; m * m],
        };
        Ok(Self {
            fixed: Vec::new(),
            strayed: Vec::new(),
            rows,
            members,
            inverse: system.inverse_metric()?,
            moving: Moving::new(moving),
            sides: system.sides(),
            store: Store::default(),
            numbers: vec![0.0; most],
            raised: vec![0.0; width],
            work: vec![0.0; width],
            missed: vec![0.0; system.rows().len() * system.sides()],
            base: room.clone(),
            here: room,
            linear: vec![0.0; width],
            before: vec![0.0; width],
            moved: false,
            next: vec![0.0; width],
            way: vec![0.0; width],
            reach,
            multipliers: vec![0.0; m],
            right: vec![0.0; m],
        })
    }

    /// The same where the columns are all vertices that are reached and may move: others never may, and what is reached later
    /// has strayed.
    pub(super) fn learn(&mut self, shapes: &Shapes<'_>, bound: &[BoundConstraint]) -> Result<()> {
        let result = self.evaluate(shapes, bound);
        if self.strayed.is_empty() {
            return result;
        }
        self.fix();
        self.evaluate(shapes, bound)
    }

    /// What has strayed may never move.
    pub(super) fn fix(&mut self) {
        self.fixed.append(&mut self.strayed);
        self.fixed.sort_unstable();
        self.fixed.dedup();
    }

    /// Values and gradients where the shapes are, into `here`.
    ///
    /// # Errors
    /// When something cannot be asked of the shapes as they are, or reaches vertices that it did not when prepared.
    pub(super) fn evaluate(&mut self, shapes: &Shapes<'_>, bound: &[BoundConstraint]) -> Result<()> {
        let width = self.raised.len();
        self.here.gradient.fill(0.0);
        let mut row = 0;
        for &k in &self.members {
            let constraint = &bound[k].constraint;
            let count = constraint.functional.equations();
            self.store.clear();
            let mut rows = self.store.rows(shapes);
            linearize_of(constraint.functional.as_ref(), shapes, &mut rows, &mut self.numbers[..count])?;
            let mut equation = 0;
            for block in self.store.equations() {
                match block {
                    Equation::Coupled { vertices, vectors, .. } => {
                        if constraint.asks(equation) {
                            let gradient = &mut self.here.gradient[row * width..(row + 1) * width];
                            let mut stray = Stray { fixed: &self.fixed, strayed: &mut self.strayed };
                            scatter(&self.moving, vertices, vectors, gradient, &mut stray);
                            self.here.value[row] = self.numbers[equation];
                            row += 1;
                        }
                        equation += 1;
                    }
                    Equation::Alike { vertices, coefficients, .. } => {
                        for axis in 0..3 {
                            if constraint.asks(equation) {
                                for (&v, c) in vertices.iter().zip(coefficients) {
                                    match self.moving.place(v) {
                                        Some(at) => self.here.gradient[row * width + 3 * at + axis] += c,
                                        None => Stray { fixed: &self.fixed, strayed: &mut self.strayed }
                                            .add(v, *c),
                                    }
                                }
                                self.here.value[row] = self.numbers[equation];
                                row += 1;
                            }
                            equation += 1;
                        }
                    }
                }
            }
        }
        if self.strayed.is_empty() { Ok(()) } else { Err(strayed()) }
    }

    /// Only the components along one axis of the gradients in `here`.
    pub(super) fn narrow(&mut self, axis: usize) {
        for vector in self.here.gradient.chunks_exact_mut(3) {
            for (k, g) in vector.iter_mut().enumerate() {
                *g = if k == axis { *g } else { 0.0 };
            }
        }
    }

    /// `Q` and `S` of `here`; false where a gradient vanishes or depends on the others.
    ///
    /// # Errors
    /// When a value or a gradient overflows; the row.
    pub(super) fn project(
        &mut self,
        assembly: &Assembly,
        factored: &mut dyn Factored,
    ) -> std::result::Result<bool, usize> {
        let (m, width) = (self.rows.len(), self.raised.len());
        let here = &mut self.here;
        let linear = assembly.system.rows();
        let entries = linear.len() * self.sides;
        let mut own = [0.0; MOST];
        for i in 0..m {
            let gradient = &here.gradient[i * width..(i + 1) * width];
            let (before, rest) = here.projected.split_at_mut(i * width);
            let projected = &mut rest[..width];
            let raised = match &mut self.inverse {
                InverseMetric::Same => gradient,
                inverse => {
                    inverse.apply(gradient, self.sides, &mut self.raised, &mut self.work);
                    &self.raised[..]
                }
            };
            if entries == 0 {
                projected.copy_from_slice(raised);
            } else {
                let coupling = &mut here.coupling[i * entries..(i + 1) * entries];
                linear.multiply(raised, self.sides, coupling);
                factored.solve_into(coupling, projected);
                for (p, r) in projected.iter_mut().zip(raised) {
                    *p = r - *p;
                }
                // A metric's condition (that of bending grows with the fourth power of the vertices' number) leaves the
                // linear constraints disturbed by more than rounding; taken out once more, they are not.
                if !matches!(self.inverse, InverseMetric::Same) {
                    linear.multiply(projected, self.sides, &mut self.missed);
                    factored.solve_into(&self.missed, &mut self.work);
                    projected.iter_mut().zip(&self.work).for_each(|(p, w)| *p -= w);
                }
            }
            own[i] = dot(gradient, raised);
            if !(own[i].is_finite() && here.value[i].is_finite()) {
                return Err(i);
            }
            for j in 0..i {
                here.schur[i * m + j] = dot(gradient, &before[j * width..(j + 1) * width]);
            }
            here.schur[i * m + i] = dot(gradient, projected);
        }
        Ok(cholesky(&mut here.schur, m, &own))
    }

    /// What was evaluated becomes the state that events start from.
    pub(super) fn keep_as_base(&mut self) {
        self.base.clone_from(&self.here);
    }

    /// `d = d_F + Q μ` with `S μ = wanted - value + G (d₀ - d_F)`, linearized at the base (where `d₀ = 0`).
    pub(super) fn step_from_base(&mut self, bound: &[BoundConstraint], d: &mut [f64]) {
        let (m, width) = (self.rows.len(), self.raised.len());
        for (i, &(k, e)) in self.rows.iter().enumerate() {
            let gradient = &self.base.gradient[i * width..(i + 1) * width];
            self.right[i] = bound[k].target[e] - self.base.value[i] - dot(gradient, &self.linear);
        }
        solve(&self.base.schur, m, &mut self.right);
        self.multipliers.copy_from_slice(&self.right);
        d.copy_from_slice(&self.linear);
        for (i, &mu) in self.right.iter().enumerate() {
            add(d, mu, &self.base.projected[i * width..(i + 1) * width]);
        }
    }

    /// What row `row` misses of its target, relative to the numbers wanted.
    pub(super) fn error_of(&self, bound: &[BoundConstraint], row: usize) -> f64 {
        let (k, e) = self.rows[row];
        let (wanted, value) = (bound[k].target[e], self.here.value[row]);
        let error = (wanted - value).abs();
        // A value and a target of zero agree; otherwise what counts is the larger of the two.
        if error == 0.0 { 0.0 } else { error / wanted.abs().max(value.abs()) }
    }

    /// The largest of these errors, and its row.
    pub(super) fn error(&self, bound: &[BoundConstraint]) -> (f64, usize) {
        let each = (0..self.rows.len()).map(|row| (self.error_of(bound, row), row));
        each.fold((0.0, 0), |worst, own| if own.0 > worst.0 { own } else { worst })
    }

    /// The same over the rows that miss their targets by more than a `share` of their terms.
    pub(super) fn error_above(
        &self,
        bound: &[BoundConstraint],
        share: f64,
        base: &[Point],
        d: &[f64],
    ) -> (f64, usize) {
        let (error, worst) = self.error(bound);
        if !self.is_rounding(bound, worst, share, base, d) {
            return (error, worst);
        }
        let others = (0..self.rows.len()).filter(|&row| !self.is_rounding(bound, row, share, base, d));
        let each = others.map(|row| (self.error_of(bound, row), row));
        each.fold((0.0, worst), |worst, own| if own.0 > worst.0 { own } else { worst })
    }

    /// Whether row `row` misses its target by no more than a `share` of its terms and the accuracy that its functional promises.
    /// With [`ITERATED`](crate::measure::ITERATED), nothing that is measured on the answer will say otherwise.
    pub(super) fn is_rounding(
        &self,
        bound: &[BoundConstraint],
        row: usize,
        share: f64,
        base: &[Point],
        d: &[f64],
    ) -> bool {
        let width = self.raised.len();
        let (k, e) = self.rows[row];
        let gradient = self.here.gradient[row * width..(row + 1) * width].chunks_exact(3);
        let points = base.iter().zip(d.chunks_exact(3));
        let size: f64 = gradient
            .zip(points)
            .map(|(g, (p, d))| (0..3).map(|a| (g[a] * (p[a] + d[a])).abs()).sum::<f64>())
            .sum();
        let (target, own) = (bound[k].target[e], bound[k].constraint.functional.accuracy().tolerance());
        (target - self.here.value[row]).abs() <= own + share * (size + target.abs())
    }

    /// The way from the adjustment `d`: what restores the values (along `Q`), and what makes the adjustment less without
    /// changing them to first order; `next` becomes `d + normal + share · tangential`.
    pub(super) fn step_from_here(&mut self, bound: &[BoundConstraint], share: f64, d: &[f64]) -> Step {
        let (m, width) = (self.rows.len(), self.raised.len());
        let mut normal = [0.0; MOST];
        // What is left of the adjustment beyond the linear one: d_F - d.
        for ((r, l), d) in self.raised.iter_mut().zip(&self.linear).zip(d) {
            *r = l - d;
        }
        for (i, &(k, e)) in self.rows.iter().enumerate() {
            normal[i] = bound[k].target[e] - self.here.value[i];
            self.right[i] = -dot(&self.here.gradient[i * width..(i + 1) * width], &self.raised);
        }
        solve(&self.here.schur, m, &mut self.right);
        solve(&self.here.schur, m, &mut normal[..m]);
        // All rows but the last one beforehand: there is mostly but one, and one pass does it all.
        self.next.copy_from_slice(d);
        for i in 0..m {
            self.multipliers[i] = self.right[i] + normal[i];
            if i + 1 < m {
                let q = &self.here.projected[i * width..(i + 1) * width];
                add(&mut self.raised, self.right[i], q);
                add(&mut self.next, normal[i], q);
            }
        }
        let last = (m.max(1) - 1) * width;
        let q = &self.here.projected[last..last + width];
        let (along, across) = (self.right[m.max(1) - 1], normal[m.max(1) - 1]);
        let mut sums = [[0.0; 3]; 4];
        let lanes = width - width % 4;
        let mut one = |lane: usize, next: &mut f64, d: f64, t: f64, q: f64| {
            let t = t + along * q;
            *next += across * q + share * t;
            let change = *next - d;
            sums[lane][0] += t * t;
            sums[lane][1] += change * change;
            sums[lane][2] += *next * *next;
        };
        let (next, rest) = self.next.split_at_mut(lanes);
        let four = next.as_chunks_mut::<4>().0.iter_mut().zip(d.as_chunks::<4>().0);
        for ((next, d), (t, q)) in four.zip(self.raised.as_chunks::<4>().0.iter().zip(q.as_chunks::<4>().0)) {
            for lane in 0..4 {
                one(lane, &mut next[lane], d[lane], t[lane], q[lane]);
            }
        }
        for (lane, next) in rest.iter_mut().enumerate() {
            let at = lanes + lane;
            one(lane, next, d[at], self.raised[at], q[at]);
        }
        let total = |k: usize| ((sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k])).sqrt();
        Step { tangential: total(0), change: total(1), whole: total(2) }
    }

    /// Remembers the tangential way of the last step from here, and returns its product with the one remembered before.
    pub(super) fn remember_way(&mut self) -> f64 {
        let width = self.raised.len();
        let last = self.rows.len().max(1) - 1;
        let (along, q) = (self.right[last], &self.here.projected[last * width..(last + 1) * width]);
        let mut product = 0.0;
        for ((way, t), q) in self.way.iter_mut().zip(&self.raised).zip(q) {
            let t = t + along * q;
            product += t * *way;
            *way = t;
        }
        product
    }

    /// Takes out of `next` what disturbs the linear constraints: `next ← next - C F (next - d_F)`. A step by a share `s` of the
    /// tangential way leaves `1 - s` of the rounding errors in these, and many such steps add up.
    pub(super) fn stay(&mut self, assembly: &Assembly, factored: &mut dyn Factored) {
        if self.missed.is_empty() {
            return;
        }
        for ((r, next), l) in self.raised.iter_mut().zip(&self.next).zip(&self.linear) {
            *r = next - l;
        }
        assembly.system.rows().multiply(&self.raised, self.sides, &mut self.missed);
        factored.solve_into(&self.missed, &mut self.work);
        self.next.iter_mut().zip(&self.work).for_each(|(n, w)| *n -= w);
    }

    /// Restores the values only: `d ← d + Q S⁻¹ (wanted - value)`.
    pub(super) fn restore(&mut self, bound: &[BoundConstraint], d: &mut [f64]) {
        let (m, width) = (self.rows.len(), self.raised.len());
        for (i, &(k, e)) in self.rows.iter().enumerate() {
            self.right[i] = bound[k].target[e] - self.here.value[i];
        }
        solve(&self.here.schur, m, &mut self.right);
        for (i, &mu) in self.right.iter().enumerate() {
            add(d, mu, &self.here.projected[i * width..(i + 1) * width]);
            self.multipliers[i] = mu;
        }
    }

    /// `Σ μ F W⁻¹ g`: what the border takes of the linear constraints' right-hand side.
    pub(super) fn taken(&self, out: &mut [f64]) {
        for (row, mu) in self.here.coupling.chunks_exact(out.len().max(1)).zip(&self.multipliers) {
            out.iter_mut().zip(row).for_each(|(o, c)| *o += mu * c);
        }
    }
}

/// How far a step went.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Step {
    /// The length of the tangential way, all of it.
    pub(super) tangential: f64,
    /// The length of the change.
    pub(super) change: f64,
    /// The length of the adjustment after it; not finite where something overflows.
    pub(super) whole: f64,
}
