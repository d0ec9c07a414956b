//! Inequalities: which of them hold with equality at the least adjustment.

use super::SolveError;
use super::envelope::dot;
use super::system::{SparseRows, System};

/// Which side of its right-hand side a row's value must be on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sense {
    /// `f·d = b`.
    #[default]
    Equal,
    /// `f·d ≥ b`.
    AtLeast,
    /// `f·d ≤ b`.
    AtMost,
}

/// A quadratic program: `dᵀWd` least, each row of the system on its side of the right-hand side. The system has one side:
/// its columns are coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Program<'a> {
    /// Rows and metric.
    pub system: &'a System,
    /// The right-hand side of each row.
    pub rhs: &'a [f64],
    /// Which side of it each row must be on.
    pub senses: &'a [Sense],
    /// The size of the numbers that each right-hand side comes from: rounding errors are of this size times ε.
    pub size: &'a [f64],
}

/// What a quadratic program came to.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// It has a solution: the least adjustment under the equations, and under these inequalities as equations.
    Active {
        /// The inequalities that hold with equality, ascending.
        rows: Vec<usize>,
        /// Rows that were added or dropped on the way.
        steps: usize,
    },
    /// It has none: these rows cannot all hold. With any one of them left out, the others can.
    Infeasible {
        /// The rows, ascending.
        rows: Vec<usize>,
    },
}

/// A violation below this, relative to the size of the numbers at hand, is rounding.
const MET: f64 = 1e-12;
/// A row whose part outside the span of the active ones is shorter than this (of its own length) lies in it.
const DEPENDENT: f64 = 1e-11;
/// More rows than this are guessed at first.
const MANY: usize = 48;
/// The most numbers that the active rows may have: 400 MB.
const LIMIT: usize = 50_000_000;

/// The dual active-set method of Goldfarb and Idnani (1983). It starts from the least adjustment under the equations,
/// makes the most violated inequality active, and lets go of those whose multiplier would change sign. Every iterate is
/// the least adjustment under its active rows, and longer than the one before, so that no set comes twice and the last one
/// is exact. Where no step is left, the violated row is a combination of active ones with the wrong signs (Farkas 1902);
/// active rows are independent, so that the combination is unique and none of its rows can be spared.
///
/// The active rows are kept as an orthonormal basis `Q` and a triangle `R`, in coordinates in which the metric is the
/// Euclidean one: the condition number is not squared. Work: `O(q m)` a step, for `q` active rows over `m` columns.
///
/// # Errors
/// When the metric is not positive definite, or the active rows become too many numbers.
pub(super) fn active_set(program: &Program<'_>) -> Result<Outcome, SolveError> {
    let count = program.system.rows().len();
    if program.system.sides() != 1
        || [program.rhs.len(), program.senses.len(), program.size.len()] != [count; 3]
    {
        return Err(SolveError::Unsupported(
            "a quadratic program needs a system with one side, and a right-hand side, a sense and a size a row".into(),
        ));
    }
    if program.system.free() > 0 {
        return Err(SolveError::Unsupported(
            "unknowns that float without weight cannot stand beside inequalities: give them a weight".into(),
        ));
    }
    // Many rows: a few good guesses are cheaper than one row at a time, where they arrive.
    if count > MANY
        && let Some(outcome) = program.pivot(&[])
    {
        return Ok(outcome);
    }
    let mut whitened = program.system.whitened()?;
    let rows = whitened.as_ref().map_or(program.system.rows(), |w| &w.rows).clone();
    let mut search = Search::new(program, &rows);
    for row in 0..count {
        if program.senses[row] == Sense::Equal {
            search.equation(row);
        }
    }
    let mut d = vec![0.0; program.system.rows().width()];
    // A row comes and goes a few times at most; the bound is for what rounding might do.
    let patience = 20 * count + 100;
    while search.steps <= patience {
        match &mut whitened {
            Some(whitened) => whitened.finish(&search.e, &mut d, 1),
            None => d.copy_from_slice(&search.e),
        }
        let Some(row) = search.most_violated(&d) else {
            return Ok(Outcome::Active { rows: search.inequalities(), steps: search.steps });
        };
        if search.active.len() * rows.width() > LIMIT {
            let unknowns = rows.width();
            return Err(SolveError::Unsupported(format!(
                "{count} equations and inequalities with {unknowns} unknowns are too many to find out which are \
                 active: ask for fewer at once"
            )));
        }
        if let Some(contradiction) = search.add(row) {
            return Ok(Outcome::Infeasible { rows: contradiction });
        }
    }
    Err(SolveError::Unsupported(format!(
        "which of {count} equations and inequalities are active could not be decided in {patience} steps: they are \
         nearly dependent; ask for less at once"
    )))
}

struct Search<'a> {
    program: &'a Program<'a>,
    /// The rows in the metric's coordinates.
    rows: &'a SparseRows,
    /// Reciprocal length of each row, negative where it is turned round (`≤`): scaled, every inequality is `≥`.
    scale: Vec<f64>,
    /// The point.
    e: Vec<f64>,
    /// The part of a row outside the span of the active rows, and its coefficients within.
    z: Vec<f64>,
    within: Vec<f64>,
    /// Active rows, the equations first, and their multipliers.
    active: Vec<usize>,
    is_active: Vec<bool>,
    equations: usize,
    multipliers: Vec<f64>,
    /// `Q`, a vector an active row; `R`, a column an active row: `N = Q R` of the scaled rows.
    q: Vec<Vec<f64>>,
    r: Vec<Vec<f64>>,
    steps: usize,
}

impl<'a> Search<'a> {
    fn new(program: &'a Program<'a>, rows: &'a SparseRows) -> Self {
        let scale = (0..rows.len()).map(|row| {
            let length = rows.norm(row);
            let turned = if program.senses[row] == Sense::AtMost { -1.0 } else { 1.0 };
            if length > 0.0 { turned / length } else { turned }
        });
        let (scale, width) = (scale.collect(), rows.width());
        Self {
            program,
            rows,
            scale,
            e: vec![0.0; width],
            z: vec![0.0; width],
            within: Vec::new(),
            active: Vec::new(),
            is_active: vec![false; rows.len()],
            equations: 0,
            multipliers: Vec::new(),
            q: Vec::new(),
            r: Vec::new(),
            steps: 0,
        }
    }

    /// How far the point is from meeting a scaled row (positive: violated).
    fn missing(&self, row: usize) -> f64 {
        let reached: f64 = self.rows.iter_row(row).map(|(column, value)| value * self.e[column]).sum();
        (self.program.rhs[row] - reached) * self.scale[row]
    }

    /// `z` and `within` of a row; whether `z` is more than rounding.
    fn project(&mut self, row: usize) -> bool {
        self.z.fill(0.0);
        for (column, value) in self.rows.iter_row(row) {
            self.z[column] = value * self.scale[row];
        }
        self.within.clear();
        self.within.resize(self.q.len(), 0.0);
        // Twice is enough: the second pass takes away what rounding left of the first.
        for _ in 0..2 {
            for (q, within) in self.q.iter().zip(&mut self.within) {
                let share = dot(q, &self.z);
                *within += share;
                self.z.iter_mut().zip(q).for_each(|(z, q)| *z -= share * q);
            }
        }
        dot(&self.z, &self.z).sqrt() > DEPENDENT
    }

    /// Makes the row that was projected last active, with a multiplier.
    fn activate(&mut self, row: usize, multiplier: f64) {
        let length = dot(&self.z, &self.z).sqrt();
        self.q.push(self.z.iter().map(|z| z / length).collect());
        let mut column = std::mem::take(&mut self.within);
        column.push(length);
        self.r.push(column);
        self.active.push(row);
        self.is_active[row] = true;
        self.multipliers.push(multiplier);
        self.steps += 1;
    }

    /// An equation, met at once; one that the others imply is left out.
    fn equation(&mut self, row: usize) {
        if self.project(row) {
            let step = self.missing(row) / dot(&self.z, &self.z);
            self.e.iter_mut().zip(&self.z).for_each(|(e, z)| *e += step * z);
            self.activate(row, step);
            self.equations += 1;
        }
    }

    /// The inequality that is violated most at `d`, in units of distance.
    fn most_violated(&self, d: &[f64]) -> Option<usize> {
        let Program { system, rhs, senses, size } = *self.program;
        let mut worst = None;
        for row in (0..rhs.len()).filter(|&row| !self.is_active[row] && senses[row] != Sense::Equal) {
            let reached: f64 = system.rows().iter_row(row).map(|(column, value)| value * d[column]).sum();
            let missing = if senses[row] == Sense::AtMost { reached - rhs[row] } else { rhs[row] - reached };
            if missing > MET * (size[row] + rhs[row].abs()) {
                let distance = missing * self.scale[row].abs();
                if worst.is_none_or(|(most, _)| distance > most) {
                    worst = Some((distance, row));
                }
            }
        }
        worst.map(|(_, row)| row)
    }

    /// `R⁻¹ within`: by how much the active multipliers fall when the new row's grows by 1.
    fn fall(&self) -> Vec<f64> {
        let mut fall = self.within.clone();
        for j in (0..fall.len()).rev() {
            let value = fall[j] / self.r[j][j];
            fall[j] = value;
            fall[..j].iter_mut().zip(&self.r[j]).for_each(|(f, r)| *f -= r * value);
        }
        fall
    }

    /// Makes a violated inequality hold, dropping those that stand in the way; the contradiction where it cannot.
    fn add(&mut self, row: usize) -> Option<Vec<usize>> {
        let mut multiplier = 0.0;
        loop {
            let free = self.project(row);
            let fall = self.fall();
            let largest = fall.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            // The first multiplier to reach zero: an inequality's, for an equation's may have any sign.
            let mut first = None;
            for (j, (fall, u)) in fall.iter().zip(&self.multipliers).enumerate().skip(self.equations) {
                if *fall > DEPENDENT * largest.max(1.0) {
                    let step = (u / fall).max(0.0);
                    if first.is_none_or(|(_, least)| step < least) {
                        first = Some((j, step));
                    }
                }
            }
            let full = if free { self.missing(row).max(0.0) / dot(&self.z, &self.z) } else { f64::INFINITY };
            match first {
                Some((j, step)) if step < full => {
                    self.step(step, free, &fall);
                    multiplier += step;
                    self.release(j);
                }
                _ if free => {
                    self.step(full, free, &fall);
                    self.activate(row, multiplier + full);
                    return None;
                }
                _ => {
                    let part = |(f, r): (&f64, &usize)| (f.abs() > 1e-9 * largest).then_some(*r);
                    let mut rows: Vec<usize> = fall.iter().zip(&self.active).filter_map(part).collect();
                    rows.push(row);
                    rows.sort_unstable();
                    return Some(rows);
                }
            }
        }
    }

    fn step(&mut self, step: f64, free: bool, fall: &[f64]) {
        if free {
            self.e.iter_mut().zip(&self.z).for_each(|(e, z)| *e += step * z);
        }
        self.multipliers.iter_mut().zip(fall).for_each(|(u, f)| *u -= step * f);
    }

    /// Takes an active row out: its column of `R` goes, and rotations make the rest a triangle again.
    fn release(&mut self, j: usize) {
        self.is_active[self.active.remove(j)] = false;
        self.multipliers.remove(j);
        self.r.remove(j);
        for k in j..self.r.len() {
            let (a, b) = (self.r[k][k], self.r[k][k + 1]);
            let length = a.hypot(b);
            let (c, s) = if length > 0.0 { (a / length, b / length) } else { (1.0, 0.0) };
            for column in &mut self.r[k..] {
                let (a, b) = (column[k], column[k + 1]);
                (column[k], column[k + 1]) = (c * a + s * b, c * b - s * a);
            }
            self.r[k].truncate(k + 1);
            let (upper, lower) = self.q.split_at_mut(k + 1);
            for (x, y) in upper[k].iter_mut().zip(&mut lower[0]) {
                (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
            }
        }
        self.q.pop();
        self.steps += 1;
    }

    fn inequalities(&self) -> Vec<usize> {
        let mut rows = self.active[self.equations..].to_vec();
        rows.sort_unstable();
        rows
    }
}
