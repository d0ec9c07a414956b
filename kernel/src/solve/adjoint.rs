//! The solver of paper 1: the adjoint matrix of `F̂ = F Fᵀ`, in closed form for one, two and three equations.

use smallvec::SmallVec;

use super::metric::Whitened;
use super::rank::{Dependency, Diagnosis, Reflections, reduce};
use super::system::System;
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

struct FactoredAdjoint {
    whitened: Whitened,
    sides: usize,
    /// The rows that are used.
    kept: SmallVec<[usize; 6]>,
    /// Reciprocal length of each used row.
    scale: SmallVec<[f64; 6]>,
    /// `adj(F̂)/f̂` of the unit rows.
    inverse: SmallVec<[f64; 9]>,
    corrections: usize,
    dependencies: Vec<Dependency>,
}

impl Solver for Adjoint {
    fn name(&self) -> &'static str {
        "adjoint"
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let rows = system.rows();
        if rows.len() > Self::LIMIT {
            return Err(SolveError::TooLarge {
                solver: self.name().into(),
                equations: rows.len(),
                unknowns: rows.width(),
                better: "sparse",
            });
        }
        let whitened = system.whitened()?;
        let mut all: SmallVec<[usize; 6]> = SmallVec::new();
        all.extend(0..rows.len());
        if let Some(done) = invert(&whitened, &all) {
            return Ok(Box::new(finish(whitened, system.sides(), all, done, Vec::new())));
        }
        let (kept, diagnosis) = reduce(&whitened, self.name())?;
        let kept: SmallVec<[usize; 6]> = kept.into_iter().collect();
        match invert(&whitened, &kept) {
            Some(done) => Ok(Box::new(finish(whitened, system.sides(), kept, done, diagnosis.dependencies))),
            None => Err(SolveError::IllConditioned {
                solver: self.name().into(),
                condition: diagnosis.condition,
                better: "householder-qr",
            }),
        }
    }
}

struct Inverse {
    scale: SmallVec<[f64; 6]>,
    inverse: SmallVec<[f64; 9]>,
    determinant: f64,
}

fn finish(
    whitened: Whitened,
    sides: usize,
    kept: SmallVec<[usize; 6]>,
    done: Inverse,
    dependencies: Vec<Dependency>,
) -> FactoredAdjoint {
    let corrections = usize::from(done.determinant < CORRECT);
    FactoredAdjoint {
        whitened,
        sides,
        kept,
        scale: done.scale,
        inverse: done.inverse,
        corrections,
        dependencies,
    }
}

/// `adj(F̂)/f̂` of the kept rows, scaled to unit length; `None` where the determinant is not safely positive.
fn invert(whitened: &Whitened, kept: &[usize]) -> Option<Inverse> {
    let rows = &whitened.rows;
    let c = kept.len();
    let mut scale: SmallVec<[f64; 6]> = SmallVec::new();
    scale.extend(kept.iter().map(|&r| 1.0 / rows.norm(r)));
    if scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return None;
    }
    let f = |i: usize, j: usize| rows.dot(kept[i], kept[j]) * scale[i] * scale[j];
    let (inverse, determinant): (SmallVec<[f64; 9]>, f64) = match c {
        0 => (SmallVec::new(), 1.0),
        // Unit rows: f̂₀₀ = 1.
        1 => (SmallVec::from_slice(&[1.0]), 1.0),
        2 => {
            let f01 = f(0, 1);
            let det = 1.0 - f01 * f01;
            (SmallVec::from_slice(&[1.0 / det, -f01 / det, -f01 / det, 1.0 / det]), det)
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
            (adj.iter().map(|a| a / det).collect(), det)
        }
        _ => {
            let gram: SmallVec<[f64; 36]> =
                (0..c * c).map(|k| if k / c == k % c { 1.0 } else { f(k / c, k % c) }).collect();
            let minor = |i: usize, j: usize| -> SmallVec<[f64; 36]> {
                (0..c * c).filter(|k| k / c != i && k % c != j).map(|k| gram[k]).collect()
            };
            let sign = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
            let adj: SmallVec<[f64; 36]> = (0..c * c)
                .map(|k| sign(k / c, k % c) * determinant_of(&minor(k % c, k / c), c - 1))
                .collect();
            let det: f64 = (0..c).map(|j| gram[j] * adj[j * c]).sum();
            (adj.iter().map(|a| a / det).collect(), det)
        }
    };
    (determinant > SUSPECT && determinant.is_finite()).then_some(Inverse { scale, inverse, determinant })
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
    /// `λ = S adj(F̂)/f̂ S b` for one side.
    fn multiplier(&self, k: usize, b: &[f64; 6]) -> f64 {
        let c = self.kept.len();
        let sum: f64 = self.inverse[k * c..(k + 1) * c].iter().zip(b).map(|(a, b)| a * b).sum();
        sum * self.scale[k]
    }

    fn scaled(&self, rhs: &[f64], side: usize) -> [f64; 6] {
        let mut b = [0.0; 6];
        for (k, &row) in self.kept.iter().enumerate() {
            b[k] = rhs[row * self.sides + side] * self.scale[k];
        }
        b
    }

    fn add_transposed(&self, k: usize, side: usize, multiplier: f64, d: &mut [f64]) {
        for (column, value) in self.whitened.rows.iter_row(self.kept[k]) {
            d[column * self.sides + side] += value * multiplier;
        }
    }
}

impl Factored for FactoredAdjoint {
    fn solver(&self) -> &'static str {
        "adjoint"
    }

    fn rank(&self) -> usize {
        self.kept.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let whitened_rows = &self.whitened.rows;
        let condition = match self.kept.len() {
            0 | 1 => 1.0,
            _ => {
                let mut rows = super::system::SparseRows::new(whitened_rows.width());
                for &row in &self.kept {
                    rows.push(whitened_rows.iter_row(row));
                }
                Reflections::new(&rows, "adjoint").map_or(f64::INFINITY, |r| r.diagnosis().condition)
            }
        };
        Diagnosis { rank: self.kept.len(), condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        d.fill(0.0);
        for side in 0..self.sides {
            let b = self.scaled(rhs, side);
            for k in 0..self.kept.len() {
                self.add_transposed(k, side, self.multiplier(k, &b), d);
            }
            for _ in 0..self.corrections {
                let mut b = b;
                for (k, &row) in self.kept.iter().enumerate() {
                    let reached: f64 =
                        self.whitened.rows.iter_row(row).map(|(c, v)| v * d[c * self.sides + side]).sum();
                    b[k] -= reached * self.scale[k];
                }
                for k in 0..self.kept.len() {
                    self.add_transposed(k, side, self.multiplier(k, &b), d);
                }
            }
        }
        self.whitened.finish(d, self.sides);
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        multipliers.fill(0.0);
        for side in 0..self.sides {
            let b = self.scaled(rhs, side);
            for (k, &row) in self.kept.iter().enumerate() {
                multipliers[row * self.sides + side] = self.multiplier(k, &b);
            }
        }
    }
}
