//! The solver of paper 1: the adjoint matrix of `F̂ = F Fᵀ`, in closed form for one, two and three equations.

use std::sync::Arc;

use smallvec::SmallVec;

use super::rank::{Dependency, Diagnosis, condition_of, reduce};
use super::refine::Refinement;
use super::system::{SparseRows, System};
use super::unit::UnitRows;
use super::{Factored, SolveError, Solver};

/// `C = Fᵀ adj(F̂) / f̂` (paper 1, equation (6)): closed forms for one to three equations, general cofactors up to
/// six. The fastest for them, with the condition number squared; larger systems are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct Adjoint;

impl Adjoint {
    /// The most equations it takes.
    pub const LIMIT: usize = 6;
}

/// Below this determinant (of unit rows) the rows are looked at by reflections.
const SUSPECT: f64 = 1e-9;

/// Below this determinant an answer is corrected once by its own residual.
const CORRECT: f64 = 1e-2;
/// Below this it is corrected until it holds, and tried whether it does.
const REFINE: f64 = 1e-4;

struct FactoredAdjoint {
    core: Core,
    /// Corrections without a look at what they are for.
    corrections: usize,
    refinement: Option<Box<Refinement>>,
    dependencies: Vec<Dependency>,
}

struct Core {
    /// The rows that are used, and beside them `adj(F̂)/f̂` (of unit rows).
    rows: UnitRows,
    sides: usize,
}

impl Solver for Adjoint {
    fn name(&self) -> &'static str {
        "adjoint"
    }

    fn help(&self) -> &'static str {
        "up to six equations; in closed form up to three"
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let equations = system.rows().len();
        if equations > Self::LIMIT {
            return Err(SolveError::TooLarge {
                solver: self.name().into(),
                equations,
                unknowns: system.rows().width(),
                better: "sparse",
            });
        }
        let mut done = Box::new(FactoredAdjoint {
            core: Core { rows: UnitRows::empty(), sides: system.sides() },
            corrections: 0,
            refinement: None,
            dependencies: Vec::new(),
        });
        let determinant = done.factor(system)?;
        done.correct(system, determinant)?;
        Ok(done)
    }
}

/// `adj(F̂)/f̂` of unit rows beside them; `f̂`.
fn adjoint(rows: &mut UnitRows) -> f64 {
    let c = rows.len();
    let f = |i: usize, j: usize| rows.dot(i, j);
    match c {
        0 => 1.0,
        1 => {
            // Unit rows: f̂₀₀ = 1.
            rows.beside_mut().fill(1.0);
            1.0
        }
        2 => {
            let f01 = f(0, 1);
            let det = 1.0 - f01 * f01;
            let (diagonal, off) = (1.0 / det, -f01 / det);
            rows.beside_mut().copy_from_slice(&[diagonal, off, off, diagonal]);
            det
        }
        3 => {
            let (f01, f02, f12) = (f(0, 1), f(0, 2), f(1, 2));
            let a02 = f01 * f12 - f02;
            let a12 = f01 * f02 - f12;
            let a22 = 1.0 - f01 * f01;
            let a01 = f02 * f12 - f01;
            let (a00, a11) = (1.0 - f12 * f12, 1.0 - f02 * f02);
            let det = f02 * a02 + f12 * a12 + a22;
            let adj = [a00, a01, a02, a01, a11, a12, a02, a12, a22];
            rows.beside_mut().copy_from_slice(&adj.map(|a| a / det));
            det
        }
        _ => {
            let gram: SmallVec<[f64; 36]> =
                (0..c * c).map(|k| if k / c == k % c { 1.0 } else { f(k / c, k % c) }).collect();
            let minor = |i: usize, j: usize| -> SmallVec<[f64; 36]> {
                (0..c * c).filter(|k| k / c != i && k % c != j).map(|k| gram[k]).collect()
            };
            let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
            let inverse = rows.beside_mut();
            for (k, a) in inverse.iter_mut().enumerate() {
                *a = sign(k / c, k % c) * determinant_of(&minor(k % c, k / c), c - 1);
            }
            let det: f64 = (0..c).map(|j| gram[j] * inverse[j * c]).sum();
            inverse.iter_mut().for_each(|a| *a /= det);
            det
        }
    }
}

/// The determinant of an `n × n` matrix by cofactors of the first row; for `n ≤ 5` only.
fn determinant_of(a: &[f64], n: usize) -> f64 {
    match n {
        0 => 1.0,
        1 => a[0],
        2 => a[0] * a[3] - a[1] * a[2],
        _ => (0..n)
            .map(|j| {
                let minor: SmallVec<[f64; 36]> = (n..n * n).filter(|k| k % n != j).map(|k| a[k]).collect();
                let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
                sign * a[j] * determinant_of(&minor, n - 1)
            })
            .sum(),
    }
}

impl FactoredAdjoint {
    /// The determinant of the rows that are kept.
    fn factor(&mut self, system: &System) -> Result<f64, SolveError> {
        let rows = system.rows();
        if let Some(determinant) = self.core.invert(rows, 0..rows.len() as u32) {
            return Ok(determinant);
        }
        let (kept, dependencies) = reduce(system, self.solver())?;
        self.dependencies = dependencies;
        let inverted = self.core.invert(rows, kept.iter().map(|&r| r as u32));
        inverted.ok_or_else(|| ill_conditioned(condition_of(rows, &kept)))
    }

    /// How answers are to be corrected.
    #[inline]
    fn correct(&mut self, system: &System, determinant: f64) -> Result<(), SolveError> {
        if system.is_corrected_elsewhere() {
            return Ok(());
        }
        let core = &mut self.core;
        if determinant < REFINE {
            let kept: Vec<u32> = core.rows.kept().collect();
            let refinement = Refinement::new(system, kept.into_iter(), |rhs, d| core.solve_into(rhs, d));
            self.refinement = Some(refinement.ok_or_else(|| ill_conditioned(core.condition()))?);
        } else {
            self.corrections = usize::from(determinant < CORRECT);
        }
        Ok(())
    }
}

fn ill_conditioned(condition: f64) -> SolveError {
    SolveError::IllConditioned { solver: Adjoint.name().into(), condition, better: "householder-qr" }
}

impl Core {
    /// The determinant of the kept rows; `None` where it is not safely positive. (The smallest eigenvalue of unit rows' Gram
    /// matrix is no less than a third of it.)
    fn invert(&mut self, rows: &Arc<SparseRows>, kept: impl ExactSizeIterator<Item = u32>) -> Option<f64> {
        let c = kept.len();
        if !self.rows.scale(rows, kept, c * c) {
            return None;
        }
        let determinant = adjoint(&mut self.rows);
        (determinant > SUSPECT && determinant.is_finite()).then_some(determinant)
    }

    fn solve_into(&self, rhs: &[f64], d: &mut [f64]) {
        d.fill(0.0);
        self.adjust_all(rhs, d, false);
    }

    #[inline]
    fn adjust_all(&self, rhs: &[f64], e: &mut [f64], again: bool) {
        match self.sides {
            3 => self.adjust::<3>(rhs, 0, e, again),
            sides => (0..sides).for_each(|side| self.adjust::<1>(rhs, side, e, again)),
        }
    }

    fn condition(&self) -> f64 {
        let rank = self.rows.len();
        if rank < 2 {
            return 1.0;
        }
        let width = (0..rank).flat_map(|i| self.rows.row(i).1).map(|(column, _)| column + 1).max();
        let mut unit = SparseRows::new(width.unwrap_or(0));
        (0..rank).for_each(|i| unit.push(self.rows.row(i).1));
        condition_of(&unit, &(0..rank).collect::<Vec<_>>())
    }

    /// `e ← e + Fᵀ F̂⁻¹ (b - F e)` where `again`, `e ← Fᵀ F̂⁻¹ b` (with `e` zero before) where not.
    #[inline]
    fn adjust<const S: usize>(&self, rhs: &[f64], side: usize, e: &mut [f64], again: bool) {
        let sides = if S == 3 { 3 } else { self.sides };
        let e = e.get_mut(side..).unwrap_or_default();
        let c = self.rows.len();
        let mut b = [[0.0; S]; Adjoint::LIMIT];
        for (i, b) in b[..c].iter_mut().enumerate() {
            let (row, entries, scale) = self.rows.row(i);
            let wanted = &rhs[row * sides + side..][..S];
            (0..S).for_each(|s| b[s] = wanted[s] * scale);
            if again {
                for (column, v) in entries {
                    let e = &e[column * sides..][..S];
                    (0..S).for_each(|s| b[s] -= v * e[s]);
                }
            }
        }
        for (i, inverse) in self.rows.beside().chunks_exact(c.max(1)).enumerate() {
            let mut value = [0.0; S];
            for (a, b) in inverse.iter().zip(&b) {
                (0..S).for_each(|s| value[s] += a * b[s]);
            }
            self.rows.add(i, value, e, sides);
        }
    }
}

impl Factored for FactoredAdjoint {
    fn solver(&self) -> &'static str {
        "adjoint"
    }

    fn rank(&self) -> usize {
        self.core.rows.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let (rank, condition) = (self.rank(), self.core.condition());
        Diagnosis { rank, condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        if let Some(refinement) = refinement {
            core.solve_into(rhs, d);
            refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
            return;
        }
        d.fill(0.0);
        for round in 0..=self.corrections {
            core.adjust_all(rhs, d, round > 0);
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        multipliers.fill(0.0);
        let Core { rows, sides, .. } = &self.core;
        let (sides, c) = (*sides, rows.len());
        for (i, inverse) in rows.beside().chunks_exact(c.max(1)).enumerate() {
            let (row, _, scale) = rows.row(i);
            for side in 0..sides {
                let terms = inverse.iter().enumerate().map(|(k, a)| {
                    let (row, _, scale) = rows.row(k);
                    a * rhs[row * sides + side] * scale
                });
                multipliers[row * sides + side] = terms.sum::<f64>() * scale;
            }
        }
    }
}
