//! Dense LU with partial pivoting of the bordered system.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::elimination::reduce;
use super::metric::SystemMetric;
use super::rank::{Dependency, Diagnosis, Reflections};
use super::refine::Refinement;
use super::system::System;
use super::{Factored, SolveError, Solver};

/// Gaussian elimination with partial pivoting of `[αW Fᵀ; F 0] [d; -αλ] = [0; b]`, which takes any metric as it is. With rows
/// and metric of unit size, the condition of this matrix is the square of that of `F` for `α = 1`, and hardly above it for `α`
/// the smallest singular value of `F` (Björck 1967), which rank has to be found for anyway. Answers are corrected by their own
/// residuals, and where that is not enough, refused. Work: `O((m + c)³)` for `c` rows over `m` touched columns; systems above
/// 3000 are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct DenseLu;

/// With a row whose part outside the span of the others is shorter than this, answers are corrected, and tried whether they
/// hold.
const SUSPECT: f64 = 1e-2;

impl DenseLu {
    /// The largest bordered system it takes.
    pub const LIMIT: usize = 3000;

    /// Whether a system is not too large.
    pub(crate) fn takes(system: &System) -> bool {
        system.rows().len() + system.rows().width() <= Self::LIMIT
    }
}

struct FactoredLu {
    core: Core,
    dependencies: Vec<Dependency>,
    reflections: Reflections,
    refinement: Option<Box<Refinement>>,
}

struct Core {
    sides: usize,
    kept: Vec<usize>,
    scale: Vec<f64>,
    /// The metric was divided by this, `α` put in.
    mean: f64,
    columns: usize,
    lu: LU<f64, Dyn, Dyn>,
    work: DVector<f64>,
}

impl Solver for DenseLu {
    fn name(&self) -> &'static str {
        "lu"
    }

    fn help(&self) -> &'static str {
        "small systems: elimination, an independent check of the others"
    }

    fn takes(&self, metric: &SystemMetric) -> bool {
        !matches!(metric, SystemMetric::Through(_))
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let rows = system.rows();
        let (equations, unknowns) = (rows.len(), rows.width());
        // Dependent rows make the bordered matrix singular, and elimination alone does not show which they are.
        if !Self::takes(system) {
            return Err(SolveError::TooLarge {
                solver: self.name().into(),
                equations,
                unknowns,
                better: "sparse",
            });
        }
        let whitened = system.whitened()?;
        let (kept, dependencies) = reduce(system);
        let reflections = Reflections::new(
            whitened.as_ref().map_or(rows, |w| &w.rows),
            kept.iter().copied(),
            0.0,
            self.name(),
        )?;
        let n = unknowns + kept.len();
        let mut matrix = DMatrix::zeros(n, n);
        // The metric's block: W, or, where its inverse K is what is known, d - K Fᵀλ = 0 instead of W d - Fᵀλ = 0.
        // Rows are scaled to unit length and W by its mean diagonal, so that pivots compare.
        let scale: Vec<f64> = kept.iter().map(|&r| 1.0 / rows.norm(r)).collect();
        let mut transposed = vec![0.0; unknowns * kept.len()];
        for (k, &row) in kept.iter().enumerate() {
            for (column, value) in rows.iter_row(row) {
                matrix[(unknowns + k, column)] = value * scale[k];
                transposed[column * kept.len() + k] = value * scale[k];
            }
        }
        let mut mean = 1.0;
        let mut block = |i: usize, j: usize, value: f64| matrix[(i, j)] = value;
        match system.metric() {
            // (What unknowns are measured by was taken out above.)
            SystemMetric::Least | SystemMetric::Through(_) => (0..unknowns).for_each(|i| block(i, i, 1.0)),
            SystemMetric::Weights(weights) => {
                mean = weights.iter().sum::<f64>() / unknowns.max(1) as f64;
                (0..unknowns).for_each(|i| block(i, i, weights[i] / mean));
            }
            SystemMetric::Matrix(w) => {
                mean = (0..unknowns).map(|i| w.entry(i, i)).sum::<f64>() / unknowns.max(1) as f64;
                for i in 0..unknowns {
                    w.row(i).for_each(|(j, value)| block(i, j, value / mean));
                }
            }
            SystemMetric::Inverse(k) => {
                (0..unknowns).for_each(|i| block(i, i, 1.0));
                let plain = transposed.clone();
                k.multiply(&plain, kept.len().max(1), &mut transposed);
            }
        }
        let part = |(row, length): (usize, f64)| {
            kept.binary_search(&row).map_or(1.0, |k| length * scale[k] * mean.sqrt())
        };
        let alpha = reflections.outside().map(part).fold(1.0_f64, f64::min).max(f64::EPSILON);
        matrix.view_mut((0, 0), (unknowns, unknowns)).iter_mut().for_each(|v| *v *= alpha);
        for column in 0..unknowns {
            for k in 0..kept.len() {
                matrix[(column, unknowns + k)] = transposed[column * kept.len() + k];
            }
        }
        let ill_conditioned = || SolveError::IllConditioned {
            solver: self.name().into(),
            condition: reflections.condition(),
            better: "householder-qr",
        };
        let lu = matrix.lu();
        let pivots = lu.u();
        if !pivots.diagonal().iter().all(|pivot| pivot.abs() > 0.0 && pivot.is_finite()) {
            return Err(ill_conditioned());
        }
        let mut core = Core {
            sides: system.sides(),
            kept,
            scale,
            mean: mean / alpha,
            columns: unknowns,
            lu,
            work: DVector::zeros(n),
        };
        let mut refinement = None;
        if whitened.is_some() || reflections.weakest() < SUSPECT {
            let kept: Vec<u32> = core.kept.iter().map(|&row| row as u32).collect();
            refinement = Refinement::new(system, kept.into_iter(), |rhs, d| core.solve_into(rhs, d));
            if refinement.is_none() {
                return Err(ill_conditioned());
            }
        }
        Ok(Box::new(FactoredLu { core, dependencies, reflections, refinement }))
    }
}

impl Core {
    /// Solves for one side; `work` holds `d` and then `-λ` (of scaled rows).
    fn solve_side(&mut self, rhs: &[f64], side: usize) {
        self.work.fill(0.0);
        for (k, &row) in self.kept.iter().enumerate() {
            self.work[self.columns + k] = rhs[row * self.sides + side] * self.scale[k];
        }
        // (nalgebra's elimination subtracts one from the size.)
        if !self.work.is_empty() {
            self.lu.solve_mut(&mut self.work);
        }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        for side in 0..self.sides {
            self.solve_side(rhs, side);
            for (d, value) in d.chunks_exact_mut(self.sides).zip(&self.work.as_slice()[..self.columns]) {
                d[side] = *value;
            }
        }
    }
}

impl Factored for FactoredLu {
    fn solver(&self) -> &'static str {
        "lu"
    }

    fn rank(&self) -> usize {
        self.core.kept.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        Diagnosis {
            rank: self.rank(),
            condition: self.reflections.condition(),
            dependencies: self.dependencies.clone(),
        }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        core.solve_into(rhs, d);
        if let Some(refinement) = refinement {
            refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        multipliers.fill(0.0);
        let core = &mut self.core;
        for side in 0..core.sides {
            core.solve_side(rhs, side);
            for (k, &row) in core.kept.iter().enumerate() {
                multipliers[row * core.sides + side] =
                    -core.work[core.columns + k] * core.scale[k] * core.mean;
            }
        }
    }
}
