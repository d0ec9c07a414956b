//! The solver `clarabel`: quadratic programs by an interior-point library.
//!
//! [`Clarabel`](https://clarabel.org) (Goulart and Chen 2024) walks through the inside of what the inequalities allow, a few dozen
//! sparse factorisations whatever number of them will be active, and stops some `1e-8` away from the solution. Which
//! inequalities are active is read off there: where the multiplier outweighs the room that is left. The kernel then
//! solves with these as equations, exactly, and puts right what was read off wrongly ([`Program::pivot`]). Of a contradiction
//! it gives a certificate; the rows in it are reduced to those of which none can be spared.
//!
//! So the answer is the exact one whichever way it was found: where the library does not arrive, the kernel's own
//! method decides.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use loftsman_kernel::plugin::{Plugin, Registry};
use loftsman_kernel::solve::{
    Automatic, Factored, Outcome, Program, Sense, SolveError, Solver, System, SystemMetric,
};

/// The solver: equations as [`Automatic`] does them, inequalities by Clarabel.
#[derive(Debug, Clone, Copy, Default)]
pub struct InteriorPoint;

impl Plugin for InteriorPoint {
    fn register(&self, registry: &mut Registry) {
        registry.solver(*self);
    }
}

/// A multiplier of a certificate below this part of the largest is none.
const IDLE: f64 = 1e-6;

impl Solver for InteriorPoint {
    fn name(&self) -> &'static str {
        "clarabel"
    }

    fn help(&self) -> &'static str {
        "hundreds of inequalities: an interior-point method finds which of them are active"
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        Automatic.factor_minimum_norm(system)
    }

    fn takes(&self, metric: &SystemMetric) -> bool {
        Automatic.takes(metric)
    }

    fn program(&self, program: &Program<'_>) -> Result<Outcome, SolveError> {
        match interior(program) {
            Some(Interior::Active(guess)) => {
                if let Some(outcome) = program.pivot(&guess) {
                    return Ok(outcome);
                }
            }
            Some(Interior::Certificate(rows)) => {
                if let Outcome::Infeasible { rows: least } = part(program, &rows)? {
                    return Ok(Outcome::Infeasible { rows: least.into_iter().map(|k| rows[k]).collect() });
                }
            }
            None => {}
        }
        Automatic.program(program)
    }
}

/// What the interior point says.
enum Interior {
    /// The inequalities that are probably active.
    Active(Vec<usize>),
    /// Rows that probably contradict each other.
    Certificate(Vec<usize>),
}

/// The outcome with only some of the rows.
fn part(program: &Program<'_>, rows: &[usize]) -> Result<Outcome, SolveError> {
    let of = |values: &[f64]| -> Vec<f64> { rows.iter().map(|&r| values[r]).collect() };
    let (rhs, size) = (of(program.rhs), of(program.size));
    let senses: Vec<Sense> = rows.iter().map(|&r| program.senses[r]).collect();
    let system = program.system.select(rows);
    Automatic.program(&Program { system: &system, rhs: &rhs, senses: &senses, size: &size })
}

/// Asks the library. Unknowns are scaled so that the metric's diagonal is 1, rows to unit length and right-hand sides to the
/// largest of them, so that its tolerances mean the same for every size. `None` where it does not arrive.
fn interior(program: &Program<'_>) -> Option<Interior> {
    let count = program.system.rows().len();
    if program.system.sides() != 1
        || program.system.free() > 0
        || [program.rhs.len(), program.senses.len(), program.size.len()] != [count; 3]
    {
        return None;
    }
    let (metric, rows) = program.matrices();
    let n = metric.size();
    let stretch: Vec<f64> = (0..n).map(|i| 1.0 / metric.entry(i, i).sqrt()).collect();
    let (mut p, mut a) = (Triplets::default(), Triplets::default());
    for i in 0..n {
        for (j, value) in metric.row(i).filter(|(j, _)| *j >= i) {
            p.push(i, j, value * stretch[i] * stretch[j]);
        }
    }
    // Equations first: A x + s = b with s zero, and not negative for the others.
    let (equations, bounds): (Vec<usize>, Vec<usize>) =
        (0..count).partition(|&row| program.senses[row] == Sense::Equal);
    if bounds.is_empty() {
        return None;
    }
    let mut b = Vec::with_capacity(count);
    for (k, &row) in equations.iter().chain(&bounds).enumerate() {
        let entries: Vec<(usize, f64)> = rows.iter_row(row).map(|(j, v)| (j, v * stretch[j])).collect();
        let length = entries.iter().map(|(_, v)| v * v).sum::<f64>().sqrt();
        let turned = if program.senses[row] == Sense::AtLeast { -1.0 } else { 1.0 };
        let scale = if length > 0.0 { turned / length } else { turned };
        entries.iter().for_each(|&(j, v)| a.push(k, j, v * scale));
        b.push(program.rhs[row] * scale);
    }
    let largest = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest > 0.0 {
        b.iter_mut().for_each(|v| *v /= largest);
    }
    let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
    if !(finite(&b) && finite(&p.values) && finite(&a.values)) {
        return None;
    }
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        // Rows keep their numbers.
        .presolve_enable(false)
        .tol_gap_abs(1e-10)
        .tol_gap_rel(1e-10)
        .tol_feas(1e-10)
        .build()
        .ok()?;
    let cones = [ZeroConeT(equations.len()), NonnegativeConeT(bounds.len())];
    let (p, a) = (p.matrix(n, n), a.matrix(count, n));
    let mut solver = DefaultSolver::new(&p, &vec![0.0; n], &a, &b, &cones, settings).ok()?;
    solver.solve();
    let (z, s) = (solver.solution.z.get(equations.len()..)?, solver.solution.s.get(equations.len()..)?);
    match solver.solution.status {
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
            let z = &solver.solution.z;
            let most = z.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let all = equations.iter().chain(&bounds).zip(z);
            let mut rows: Vec<usize> =
                all.filter(|(_, z)| z.abs() > IDLE * most).map(|(&row, _)| row).collect();
            rows.sort_unstable();
            Some(Interior::Certificate(rows))
        }
        // However far it came: what is read off is put right.
        SolverStatus::Solved
        | SolverStatus::AlmostSolved
        | SolverStatus::InsufficientProgress
        | SolverStatus::MaxIterations => {
            let active = bounds.iter().zip(z.iter().zip(s)).filter(|(_, (z, s))| z > s);
            Some(Interior::Active(active.map(|(&row, _)| row).collect()))
        }
        _ => None,
    }
}

/// Entries of a sparse matrix.
#[derive(Default)]
struct Triplets {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Triplets {
    fn push(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}
