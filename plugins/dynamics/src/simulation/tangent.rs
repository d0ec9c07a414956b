//! Newton's system of an equilibrium: how forces, rows and parameters change together, factored.
//!
//! Where things rest, `L = E(q) - λᵀg(q, s)` is stationary in vertices `q`, parameters `s` and multipliers `λ`. Newton's step solves
//!
//! ```text
//! [ H + δW  -Aᵀ ] [ dx ]   [ Q + Aᵀλ ]      H = ∂²L/∂(q, s)²,   A = [L  L_s],   x = (q, s),
//! [   A      0  ] [ dλ ] = [   -g    ]
//! ```
//!
//! with the mass `W` times a shift `δ`, which shortens the step. `H` alone is singular (a body may be carried away) and may be indefinite where the
//! constraints keep it from falling that way; `N = H + δW + Σ ρ a aᵀ` over the rows `a` of `A` gives the same step, and for `ρ` large enough it is
//! positive definite just where `H + δW` is so on all that the constraints allow (Debreu 1952; Nocedal and Wright 2006, theorem 17.5). So a
//! Cholesky factor of `N` tells whether the step goes downhill and, with `δ = 0`, whether rest is stable.

use loftsman_kernel::solve::EnvelopeCholesky;

use super::corners::Corners;
use super::{Moving, Simulation, shapes};
use crate::error::Result;
use crate::link::Curving;
use crate::stiffness::{Part, Room};

/// Rows count for so many times the stiffness of what they hold.
const HELD: f64 = 100.0;
/// A pivot below this share of its diagonal entry is none.
const SINGULAR: f64 = 1e-12;
/// A row depends on those before it where this share of its diagonal entry is left, or less.
const DEPENDENT: f64 = 1e-13;

/// Newton's system, kept from step to step for its rooms.
#[derive(Debug, Default)]
pub(crate) struct Tangent {
    /// Where each coordinate of each body stands; `usize::MAX` where it stays.
    places: Vec<usize>,
    /// Of each unknown of a body, the first that it meets in the stiffness.
    first: Vec<u32>,
    /// How many unknowns vertices have, and parameters.
    vertices: usize,
    parameters: usize,
    /// What a parameter weighs in the shift.
    weight: f64,
    factor: EnvelopeCholesky,
    /// The rows `A`, and how much each counts in `N`.
    rows: Vec<Vec<(usize, f64)>>,
    held: Vec<f64>,
    /// `R⁻¹Aᵀ` with `N = R Rᵀ`, row after row; and the factor of `A N⁻¹ Aᵀ`.
    half: Vec<f64>,
    gram: Vec<f64>,
    rank: usize,
    curving: Curving,
    room: Room,
    /// Where shapes have corners; which parameters stay where they are, and which of them stayed in the step before.
    pub(super) corners: Corners,
    pub(super) stays: Vec<bool>,
    pub(super) tried: Vec<bool>,
}

impl Tangent {
    pub(crate) fn new(bodies: &[Moving]) -> Self {
        let mut all = Self { weight: f64::INFINITY, ..Self::default() };
        for body in bodies {
            let n = body.count();
            let Some(mass) = &body.mass else {
                all.places.resize(all.places.len() + 3 * n, usize::MAX);
                continue;
            };
            let mut place: Vec<usize> = (0..n).collect();
            if let Some(order) = &mass.order {
                order.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = at);
            }
            let start = all.first.len();
            all.places.extend((0..3 * n).map(|c| start + 3 * place[c / 3] + c % 3));
            let row_at = |i: usize| mass.order.as_ref().map_or(i, |order| order[i]);
            all.first.extend((0..3 * n).map(|row| {
                let least = mass.matrix.row(row_at(row / 3)).map(|(j, _)| place[j]).min();
                (start + 3 * least.unwrap_or(row / 3).min(row / 3)) as u32
            }));
            all.weight = all.weight.min(mass.lumped.iter().sum::<f64>() / n as f64);
        }
        all.vertices = all.first.len();
        all
    }

    /// How many unknowns there are: coordinates that move, and parameters.
    pub(crate) fn unknowns(&self) -> usize {
        self.vertices + self.parameters
    }

    /// Whether a parameter stays where it is.
    pub(super) fn stays(&self, parameter: usize) -> bool {
        self.stays.get(parameter) == Some(&true)
    }

    /// How many rows are independent.
    pub(crate) fn rank(&self) -> usize {
        self.rank
    }

    /// Takes over the rows that were collected.
    pub(crate) fn take_rows(&mut self, simulation: &Simulation) {
        let equations = simulation.space.equations();
        self.parameters = simulation.desk.parameters;
        self.rows.resize_with(equations, Vec::new);
        self.rows.iter_mut().for_each(Vec::clear);
        simulation.space.entries(|equation, coordinate, value| {
            let at = self.places[coordinate];
            if at != usize::MAX && value != 0.0 {
                self.rows[equation].push((at, value));
            }
        });
        for &(equation, parameter, by) in &simulation.desk.changes {
            if !self.stays(parameter) {
                self.rows[equation].push((self.vertices + parameter, by));
            }
        }
        for row in &mut self.rows {
            row.sort_by_key(|(at, _)| *at);
            row.dedup_by(|later, kept| {
                let same = later.0 == kept.0;
                kept.1 += if same { later.1 } else { 0.0 };
                same
            });
        }
    }

    /// The unknown's number of a coordinate of all bodies, where it moves.
    pub(crate) fn place(&self, coordinate: usize) -> Option<usize> {
        self.places.get(coordinate).copied().filter(|at| *at != usize::MAX)
    }

    /// Which unknowns are a row's first and last vertices, without its parameters.
    fn reach(row: &[(usize, f64)], vertices: usize) -> Option<(usize, usize)> {
        let own = || row.iter().map(|(at, _)| *at).filter(|at| *at < vertices);
        own().min().zip(own().max())
    }

    /// Factors `N` where things are; whether it is positive definite. `O(Σ w²)` over the widths `w` of the rows of its envelope.
    ///
    /// # Errors
    /// When a shape cannot be asked how it curves.
    pub(crate) fn factor(&mut self, simulation: &Simulation, part: Part, shift: f64) -> Result<bool> {
        self.curving.mixed.clear();
        self.curving.twice.clear();
        let mut parameter = 0;
        let all = shapes(&simulation.bodies);
        for link in simulation.links.iter().filter(|link| link.is_held()) {
            link.curve(&all, parameter, &mut self.curving)?;
            parameter += link.slides.len();
        }
        let stays = &self.stays;
        let moves = |parameter: usize| stays.get(parameter) != Some(&true);
        self.curving.mixed.retain(|(_, parameter, _)| moves(*parameter));
        self.curving.twice.retain(|(a, b, _)| moves(*a) && moves(*b));
        let first = self.envelope(part);
        self.factor = EnvelopeCholesky::envelope(first);
        self.add_bodies(simulation, part, shift);
        self.add_parameters(part, shift);
        self.add_held();
        if self.factor.factor_in_place(SINGULAR).is_err() {
            return Ok(false);
        }
        self.factor_rows();
        Ok(true)
    }

    /// Where each row of `N` starts; and which rows of `A` take part in it: those that do not make it much larger.
    fn envelope(&mut self, part: Part) -> Vec<u32> {
        let Self { first, vertices, parameters, rows, held, curving, .. } = self;
        let (vertices, parameters) = (*vertices, *parameters);
        let mut all = first.clone();
        let area: usize = all.iter().enumerate().map(|(i, f)| i + 1 - *f as usize).sum();
        let mut room = area.max(10_000);
        held.clear();
        for row in &*rows {
            let Some((least, _)) = Self::reach(row, vertices) else {
                held.push(0.0);
                continue;
            };
            let own = || row.iter().map(|(at, _)| *at).filter(|at| *at < vertices);
            let more: usize = own().map(|at| (all[at] as usize).saturating_sub(least)).sum();
            if more > room {
                held.push(0.0);
                continue;
            }
            room -= more;
            own().for_each(|at| all[at] = all[at].min(least as u32));
            held.push(1.0);
        }
        // Parameters meet the vertices of their rows, those of how they curve, and one another.
        all.extend((0..parameters).map(|k| (vertices + k) as u32));
        for row in rows.iter().zip(&*held).filter(|(_, held)| **held > 0.0).map(|(row, _)| row) {
            if let Some(&(least, _)) = row.first() {
                for (at, _) in row.iter().filter(|(at, _)| *at >= vertices) {
                    all[*at] = all[*at].min(least as u32);
                }
            }
        }
        if part == Part::Whole {
            for &(vertex, parameter, _) in &curving.mixed {
                let places = &self.places[3 * vertex..3 * vertex + 3];
                let least = places.iter().copied().min().unwrap_or(usize::MAX);
                let own = &mut all[vertices + parameter];
                *own = if least == usize::MAX { *own } else { (*own).min(least as u32) };
            }
        }
        for &(a, b, _) in &curving.twice {
            let (high, low) = (vertices + a.max(b), vertices + a.min(b));
            all[high] = all[high].min(low as u32);
        }
        all
    }

    fn add(factor: &mut EnvelopeCholesky, a: usize, b: usize, value: f64) {
        let at = factor.place(a.max(b), a.min(b));
        factor.entries_mut()[at] += value;
    }

    /// `K + δM` of all bodies, and pulls.
    fn add_bodies(&mut self, simulation: &Simulation, part: Part, shift: f64) {
        let Self { factor, places, room, .. } = self;
        for body in &simulation.bodies {
            let (Some(mass), Some(elastic)) = (&body.mass, &body.elastic) else { continue };
            let places = &places[body.range()];
            let mut add = |i: usize, j: usize, value: f64| Self::add(factor, places[i], places[j], value);
            if shift > 0.0 {
                for i in 0..mass.matrix.size() {
                    for (j, m) in mass.matrix.row(i).filter(|(j, _)| *j <= i) {
                        (0..3).for_each(|axis| add(3 * i + axis, 3 * j + axis, shift * m));
                    }
                }
            }
            elastic.add_stiffness(body.body.shape.control_vertices(), part, 1.0, 0.0, room, &mut add);
            let first = 3 * body.start;
            let time = simulation.time;
            for load in simulation.loads.iter().filter(|load| load.acts(time) && load.offset() == body.start)
            {
                load.add_stiffness(1.0, 0.0, |i, j, value| add(i - first, j - first, value));
            }
        }
    }

    /// What of `H` belongs to parameters; of the convex part only what is positive.
    fn add_parameters(&mut self, part: Part, shift: f64) {
        let Self { factor, places, vertices, parameters, weight, curving, stays, .. } = self;
        for k in 0..*parameters {
            // What stays meets nothing else.
            let own = if stays.get(k) == Some(&true) { 1.0 } else { shift };
            Self::add(factor, *vertices + k, *vertices + k, own * *weight);
        }
        if part == Part::Whole {
            for &(vertex, parameter, by) in &curving.mixed {
                for axis in 0..3 {
                    let at = places[3 * vertex + axis];
                    if at != usize::MAX {
                        Self::add(factor, *vertices + parameter, at, -by[axis]);
                    }
                }
            }
        }
        for &(a, b, by) in &curving.twice {
            if part == Part::Whole || (a == b && by < 0.0) {
                Self::add(factor, *vertices + a, *vertices + b, -by);
            }
        }
    }

    /// `Σ ρ a aᵀ`.
    fn add_held(&mut self) {
        let Self { factor, vertices, rows, held, .. } = self;
        for (row, held) in rows.iter().zip(held.iter_mut()).filter(|(_, held)| **held > 0.0) {
            let (mut stiffness, mut size) = (0.0, 0.0);
            for (at, a) in row.iter().filter(|(at, _)| at < vertices) {
                let diagonal = factor.place(*at, *at);
                stiffness += a * a * factor.entries_mut()[diagonal].abs();
                size += a * a;
            }
            *held = if size > 0.0 { HELD * stiffness / (size * size) } else { 0.0 };
        }
        for (row, held) in rows.iter().zip(held.iter()).filter(|(_, held)| **held > 0.0) {
            for (k, (i, a)) in row.iter().enumerate() {
                row[..=k].iter().for_each(|(j, b)| Self::add(factor, *i, *j, held * a * b));
            }
        }
    }

    /// `A N⁻¹ Aᵀ`, factored; what depends on rows before it takes no part.
    fn factor_rows(&mut self) {
        let (n, m) = (self.unknowns(), self.rows.len());
        self.half.clear();
        self.half.resize(n * m, 0.0);
        for (row, half) in self.rows.iter().zip(self.half.chunks_exact_mut(n.max(1))) {
            row.iter().for_each(|(at, a)| half[*at] = *a);
            self.factor.forward(half, 1);
        }
        self.gram.clear();
        self.gram.resize(m * m, 0.0);
        self.rank = 0;
        for i in 0..m {
            for j in 0..=i {
                self.gram[i * m + j] = dot(&self.half[i * n..(i + 1) * n], &self.half[j * n..(j + 1) * n]);
            }
        }
        for i in 0..m {
            let (done, rest) = self.gram.split_at_mut(i * m);
            let row = &mut rest[..=i];
            let whole = row[i];
            let mut diagonal = whole;
            for j in 0..i {
                let other = &done[j * m..=j * m + j];
                let value = (row[j] - dot(&row[..j], &other[..j])) * other[j];
                row[j] = value;
                diagonal -= value * value;
            }
            if diagonal > DEPENDENT * whole && diagonal.is_finite() {
                row[i] = 1.0 / diagonal.sqrt();
                self.rank += 1;
            } else {
                row.fill(0.0);
            }
        }
    }

    /// Solves `N dx - Aᵀμ = r`, `A dx = e`: `r` becomes `dx`, `e` becomes `μ`.
    pub(crate) fn solve(&self, r: &mut [f64], e: &mut [f64]) {
        let (n, m) = (self.unknowns(), self.rows.len());
        self.factor.forward(r, 1);
        for (e, half) in e.iter_mut().zip(self.half.chunks_exact(n.max(1))) {
            *e -= dot(half, r);
        }
        for i in 0..m {
            let row = &self.gram[i * m..=i * m + i];
            e[i] = (e[i] - dot(&row[..i], &e[..i])) * row[i];
        }
        for i in (0..m).rev() {
            let row = &self.gram[i * m..=i * m + i];
            e[i] *= row[i];
            let own = e[i];
            e[..i].iter_mut().zip(row).for_each(|(e, a)| *e -= a * own);
        }
        for (e, half) in e.iter().zip(self.half.chunks_exact(n.max(1))) {
            r.iter_mut().zip(half).for_each(|(r, half)| *r += e * half);
        }
        self.factor.backward(r, 1);
    }

    /// How much the multiplier of each row changes: `μ` less what its share of `N` did with `-g` being asked of it.
    pub(crate) fn multipliers(&self, mu: &mut [f64], gaps: &[f64]) {
        for ((mu, held), gap) in mu.iter_mut().zip(&self.held).zip(gaps) {
            *mu += held * gap;
        }
    }

    /// `W x`, the mass of vertices and the parameters' own.
    pub(crate) fn weigh(&self, bodies: &[Moving], x: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.resize(x.len(), 0.0);
        for body in bodies {
            let Some(mass) = &body.mass else { continue };
            let places = &self.places[body.range()];
            for i in 0..mass.matrix.size() {
                for (j, m) in mass.matrix.row(i) {
                    (0..3).for_each(|axis| out[places[3 * i + axis]] += m * x[places[3 * j + axis]]);
                }
            }
        }
        for k in self.vertices..x.len() {
            out[k] = self.weight * x[k];
        }
    }
}

/// `a · b` in a fixed order, in eight sums.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
