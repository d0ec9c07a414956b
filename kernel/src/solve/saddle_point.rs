//! The solver for many equations in a metric: `L D Lᵀ` of the saddle-point matrix within its envelope.

use super::metric::SystemMetric;
use super::rank::{Dependency, Diagnosis, reduce};
use super::refine::Refinement;
use super::saddle::{Bordered, Refusal, Saddle};
use super::symmetric::Symmetric;
use super::system::{SparseRows, System};
use super::{Factored, SolveError, Solver};

/// Factors `[W Fᵀ; F 0]`, each row right behind the last column that it touches, so that the matrix stays as narrow as the metric
/// and the rows are. Nothing is squared but the rows' own condition, and nothing becomes dense: in a metric that is a band (that
/// of bending), work is linear in the columns that matter and in the rows, where taking the metric out beforehand makes each
/// row as long as there are columns. A metric that is known by its inverse is taken as `[W⁻¹ W⁻¹Fᵀ; F W⁻¹ 0]`.
///
/// Rows whose part outside the span of the others is short are looked at by reflections, as by [`Sparse`](super::Sparse);
/// answers are corrected by their own residuals in the rows and in the metric.
#[derive(Debug, Clone, Copy, Default)]
pub struct SaddlePoint;

/// Rows with a smaller part (squared) outside the span of those before them are looked at by reflections.
const SUSPECT: f64 = 1e-8;
/// Corrections of the whole: what elimination without pivots leaves, the second and third pass take away.
const PASSES: usize = 3;

struct FactoredSaddle {
    core: Core,
    refinement: Box<Refinement>,
    dependencies: Vec<Dependency>,
}

struct Core {
    metric: Symmetric,
    /// Of unit length.
    rows: SparseRows,
    /// The reciprocal length of each.
    scale: Vec<f64>,
    /// Whether the unknowns are `W d`.
    inverse: bool,
    saddle: Saddle,
    /// The rows that are kept, in the order of their last columns.
    kept: Vec<usize>,
    sides: usize,
    room: Room,
}

/// One side of an answer, and what is missing of it.
#[derive(Default)]
struct Room {
    x: Vec<f64>,
    y: Vec<f64>,
    force: Vec<f64>,
    missing: Vec<f64>,
    all: Vec<f64>,
}

impl Solver for SaddlePoint {
    fn name(&self) -> &'static str {
        "saddle-point"
    }

    fn help(&self) -> &'static str {
        "many equations in a metric that bends or stretches: nothing becomes dense"
    }

    fn takes(&self, metric: &SystemMetric) -> bool {
        !matches!(metric, SystemMetric::Through(_))
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let count = system.rows().len();
        let (metric, rows) = system.matrices();
        let length = |row| Some(rows.norm(row)).filter(|n| *n > 0.0).map_or(1.0, |n| 1.0 / n);
        let scale: Vec<f64> = (0..count).map(length).collect();
        let mut unit = SparseRows::with_capacity(rows.width(), count, rows.entries());
        for (row, scale) in scale.iter().enumerate() {
            unit.push(rows.iter_row(row).map(|(c, v)| (c, v * scale)));
        }
        let bordered = Bordered::new(&metric, &unit);
        let order = |rows: &mut Vec<usize>| rows.sort_by_key(|&row| (bordered.last(row), row));
        let refused = |refusal| match refusal {
            Refusal::Work => SolveError::TooLarge {
                solver: self.name().into(),
                equations: count,
                unknowns: rows.width(),
                better: "sparse",
            },
            Refusal::Indefinite(column) => system.bad_metric(column),
        };
        let mut kept: Vec<usize> = (0..count).collect();
        order(&mut kept);
        let mut saddle = bordered.factor(&kept).map_err(refused)?;
        let mut dependencies = Vec::new();
        if saddle.weakest() < SUSPECT {
            (kept, dependencies) = reduce(system, self.name())?;
            order(&mut kept);
            saddle = bordered.factor(&kept).map_err(refused)?;
            if saddle.left_out().next().is_some() {
                return Err(ill_conditioned(&saddle));
            }
        }
        let (sides, n) = (system.sides(), rows.width());
        let room = Room {
            x: vec![0.0; n],
            y: vec![0.0; kept.len()],
            force: vec![0.0; n],
            missing: vec![0.0; kept.len()],
            all: Vec::with_capacity(n + kept.len()),
        };
        let inverse = matches!(system.metric(), SystemMetric::Inverse(_));
        let mut core = Core { metric, rows: unit, scale, inverse, saddle, kept, sides, room };
        let all: Vec<u32> = core.kept.iter().map(|&row| row as u32).collect();
        match Refinement::new(system, all.into_iter(), |rhs, d| core.solve_into(rhs, d)) {
            Some(refinement) => Ok(Box::new(FactoredSaddle { core, refinement, dependencies })),
            None => Err(ill_conditioned(&core.saddle)),
        }
    }
}

#[cold]
fn ill_conditioned(saddle: &Saddle) -> SolveError {
    let condition = condition(saddle);
    SolveError::IllConditioned { solver: SaddlePoint.name().into(), condition, better: "householder-qr" }
}

fn condition(saddle: &Saddle) -> f64 {
    1.0 / saddle.weakest().sqrt()
}

impl Core {
    /// `x` and `y` of one side, into the room.
    fn solve_side(&mut self, rhs: &[f64], side: usize) {
        let Self { metric, rows, scale, saddle, kept, sides, room, .. } = self;
        room.x.fill(0.0);
        room.y.fill(0.0);
        for _ in 0..PASSES {
            metric.multiply(&room.x, 1, &mut room.force);
            for (k, &row) in kept.iter().enumerate() {
                let (mut reached, y) = (0.0, room.y[k]);
                for (column, value) in rows.iter_row(row) {
                    room.force[column] += value * y;
                    reached += value * room.x[column];
                }
                room.missing[k] = rhs[row * *sides + side] * scale[row] - reached;
            }
            room.force.iter_mut().for_each(|f| *f = -*f);
            saddle.solve(&room.force, &room.missing, &mut room.x, &mut room.y, &mut room.all);
        }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        for side in 0..self.sides {
            self.solve_side(rhs, side);
            let Room { x, force, .. } = &mut self.room;
            let answer = if self.inverse {
                self.metric.multiply(x, 1, force);
                force
            } else {
                x
            };
            d.chunks_exact_mut(self.sides).zip(answer.iter()).for_each(|(d, x)| d[side] = *x);
        }
    }
}

impl Factored for FactoredSaddle {
    fn solver(&self) -> &'static str {
        "saddle-point"
    }

    fn rank(&self) -> usize {
        self.core.kept.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let (rank, condition) = (self.core.kept.len(), condition(&self.core.saddle));
        Diagnosis { rank, condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        core.solve_into(rhs, d);
        refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
    }

    /// `W d + Fᵀ y = 0`, so that `λ = -y`.
    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        let core = &mut self.core;
        multipliers.fill(0.0);
        for side in 0..core.sides {
            core.solve_side(rhs, side);
            for (k, &row) in core.kept.iter().enumerate() {
                multipliers[row * core.sides + side] = -core.room.y[k] * core.scale[row];
            }
        }
    }
}
