//! The least energy among the adjustments that the constraints allow: projected conjugate gradients.
//!
//! Gould, Hribar, Nocedal: On the solution of equality constrained quadratic programming problems arising in optimization
//! (2001). The projection `Π = I - F⁺F` comes from the kernel's solvers, whose work is proportional to what the constraints
//! touch. Steps are `C`-orthogonal to directions without energy, `C⁻¹` the preconditioner; as that is `δ I` along them, the
//! answer differs from where the search starts by nothing that costs no energy: of several fairest shapes it is the nearest.

use loftsman_kernel::Vector;
use loftsman_kernel::error::Error;
use loftsman_kernel::solve::{Factored, SolveError, System};

use crate::null_space::NullSpace;
use crate::precondition::Preconditioner;
use crate::squares::Squares;

/// Steps of one search, and how often it starts again from the true residual.
const STEPS: usize = 500;
const SEARCHES: usize = 8;
/// A search ends where the energy still to be gained is this part of what it was at its start.
const GAIN: f64 = 1e-22;
/// A direction whose energy is this part of the preconditioner's has none.
const FLAT: f64 = 1e-13;
/// The energy that may still be had, relative to the energy itself.
const OPTIMAL: f64 = 1e-20;
/// The square of how much of their size rounding takes from the numbers that squares are made of.
const ROUNDING: f64 = 1e-27;

/// Projects adjustments onto those that leave what is asked as it is.
pub(crate) struct Projection<'a> {
    system: &'a System,
    factored: Box<dyn Factored>,
    values: Vec<f64>,
    touched: Vec<f64>,
    adjustment: Vec<f64>,
    /// Motions that neither energy nor constraints see.
    null_space: NullSpace,
}

impl<'a> Projection<'a> {
    pub(crate) fn new(system: &'a System, factored: Box<dyn Factored>, null_space: NullSpace) -> Self {
        let sides = system.sides();
        let touched = vec![0.0; system.touched().len() * sides];
        Self {
            system,
            factored,
            values: vec![0.0; system.rows().len() * sides],
            adjustment: touched.clone(),
            touched,
            null_space,
        }
    }

    /// Whose rows it projects onto.
    pub(crate) fn system(&self) -> &'a System {
        self.system
    }

    /// From here on every motion has an energy.
    pub(crate) fn tether(&mut self) {
        self.null_space = NullSpace::default();
    }

    fn gather(&mut self, v: &[Vector]) {
        let sides = self.system.sides();
        for (slot, &column) in self.touched.chunks_exact_mut(sides).zip(self.system.touched()) {
            if sides == 3 {
                slot.copy_from_slice(v[column].as_slice());
            } else {
                slot[0] = v[column / 3][column % 3];
            }
        }
        self.system.rows().multiply(&self.touched, sides, &mut self.values);
    }

    /// `v ← v - F⁺F v`, without the null space.
    fn apply(&mut self, v: &mut [Vector]) {
        if !self.values.is_empty() {
            self.gather(v);
            self.factored.solve_into(&self.values, &mut self.adjustment);
            self.add(v, -1.0);
        }
        self.null_space.take_out(v);
    }

    /// `v ← v + F⁺ b`.
    pub(crate) fn correct(&mut self, b: &[f64], v: &mut [Vector]) {
        if !b.is_empty() {
            self.factored.solve_into(b, &mut self.adjustment);
            self.add(v, 1.0);
        }
    }

    /// `λ` with `Fᵀλ` nearest to the gradient `v`.
    pub(crate) fn multipliers(&mut self, v: &[Vector]) -> Vec<f64> {
        let mut multipliers = vec![0.0; self.values.len()];
        if !multipliers.is_empty() {
            self.gather(v);
            self.factored.multipliers_into(&self.values, &mut multipliers);
        }
        multipliers
    }

    fn add(&self, v: &mut [Vector], sign: f64) {
        let sides = self.system.sides();
        for (slot, &column) in self.adjustment.chunks_exact(sides).zip(self.system.touched()) {
            if sides == 3 {
                v[column] += Vector::from_column_slice(slot) * sign;
            } else {
                v[column / 3][column % 3] += slot[0] * sign;
            }
        }
    }
}

/// What the search did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Search {
    pub(crate) steps: usize,
    /// The energy that more steps might still gain, relative to the energy.
    pub(crate) gap: f64,
}

/// Moves `x`, which meets the constraints, to the least energy that can be had by adjustments that leave them met. Only
/// vertices that are `free` move. `O(steps · size)`.
///
/// # Errors
/// When numbers overflow, or the search does not arrive.
pub(crate) fn minimise(
    squares: &Squares,
    free: &[bool],
    projection: &mut Projection<'_>,
    preconditioner: &mut Preconditioner,
    x: &mut [Vector],
) -> Result<Search, SolveError> {
    let n = x.len();
    let (mut r, mut z, mut q) =
        (vec![Vector::zeros(); n], vec![Vector::zeros(); n], vec![Vector::zeros(); n]);
    let project = |v: &mut [Vector], projection: &mut Projection<'_>| {
        for (v, free) in v.iter_mut().zip(free) {
            if !free {
                *v = Vector::zeros();
            }
        }
        projection.apply(v);
    };
    let dot = |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    let mut search = Search::default();
    let mut before = f64::INFINITY;
    // What is rounded away is a part of the numbers that went in, even where they all but vanish.
    let began = squares.energy(x).1;
    for _ in 0..SEARCHES {
        squares.gradient(x, true, &mut r);
        r.iter_mut().for_each(|r| *r = -*r);
        project(&mut r, projection);
        preconditioner.apply(&r, &mut z);
        project(&mut z, projection);
        let start = dot(&r, &z).max(0.0);
        let (energy, size) = squares.energy(x);
        let size = size.max(began);
        let floor = OPTIMAL * energy + ROUNDING * size;
        if !(start.is_finite() && size.is_finite()) {
            return Err(SolveError::Unsupported(
                "the energy overflows: the shape or its parameters are too large".into(),
            ));
        }
        search.gap = if start > 0.0 { start / (energy + ROUNDING * size) } else { 0.0 };
        // Arrived, or as near as rounding lets it.
        if start <= 1e-4 * floor || start >= 0.25 * before && start <= floor {
            return Ok(search);
        }
        before = start;
        let mut p = z.clone();
        let mut rz = start;
        // pᵀC⁻¹p, which says how little energy a direction may have.
        let mut length = start;
        for _ in 0..STEPS {
            squares.gradient(&p, false, &mut q);
            project(&mut q, projection);
            let curvature = dot(&p, &q);
            // NaN ends the search, too: the next one, from the true residual, says why.
            if curvature.is_nan() || curvature <= FLAT * length {
                break;
            }
            let step = rz / curvature;
            for ((x, r), (p, q)) in x.iter_mut().zip(&mut r).zip(p.iter().zip(&q)) {
                *x += p * step;
                *r -= q * step;
            }
            search.steps += 1;
            preconditioner.apply(&r, &mut z);
            project(&mut z, projection);
            let next = dot(&r, &z);
            if next.is_nan() || next <= GAIN * start || next <= 1e-6 * floor {
                break;
            }
            for (p, z) in p.iter_mut().zip(&z) {
                *p = z + *p * (next / rz);
            }
            length = next + (next / rz) * (next / rz) * length;
            rz = next;
        }
    }
    let (energy, size) = squares.energy(x);
    let size = size.max(began);
    if before <= OPTIMAL.sqrt() * energy + ROUNDING * size {
        return Ok(search);
    }
    Err(SolveError::NotConverged {
        iterations: search.steps,
        residual: search.gap.sqrt(),
        worst: "the energy, relative to itself".into(),
    })
}

/// An error of numbers that cannot be computed with.
pub(crate) fn finite(x: &[Vector]) -> Result<(), Error> {
    match x.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(_) => Err(Error::Invalid("the fair shape overflows: ask for less".into())),
    }
}
