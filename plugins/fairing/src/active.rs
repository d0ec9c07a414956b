//! The point nearest to another under equations and inequalities, in whatever metric: a dual active-set method.
//!
//! Goldfarb and Idnani (1983): it starts from the nearest point under the equations, makes the most violated inequality
//! active, and lets go of those whose multiplier would change sign. Every iterate is the nearest point under its active rows,
//! and farther than the one before, so that no set comes twice. Active rows are kept as `N = Q R` in coordinates in which
//! the metric is Euclid's. Those may be stretched a million times one way against another: so whenever the active set has
//! changed, point and multipliers are computed from it anew, and what the point misses of the rows, measured in the shape's own
//! coordinates, is corrected.

use loftsman_kernel::Vector;

use crate::orthogonal::{add, dot};

/// A violation below this, relative to the size of the numbers at hand, is rounding.
const MET: f64 = 12.0 * f64::EPSILON;
/// A violation of a row that the others imply is enlarged rounding below this.
const NEARLY: f64 = 1e-10;
/// A row whose part outside the span of the active ones is shorter than this (of its own length) lies in it.
const DEPENDENT: f64 = 1e-11;
/// A multiplier that pushes the wrong way by less than this part of the largest is none.
const IDLE: f64 = 1e-10;
/// Corrections of a point by what it misses.
const CORRECTIONS: usize = 3;
/// The most numbers that the active rows may have: 400 MB.
const LIMIT: usize = 50_000_000;

/// `Σ c x ≥ b`, or `= b`; a coordinate is `3 · vertex + axis`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    pub(crate) terms: Vec<(usize, f64)>,
    pub(crate) value: f64,
    pub(crate) equation: bool,
    /// The size of the numbers that it comes from.
    pub(crate) size: f64,
}

impl Row {
    /// How far `x` is from meeting it (positive: too little), and the size of the numbers that says.
    pub(crate) fn missing(&self, x: &[Vector]) -> (f64, f64) {
        let (mut reached, mut size) = (0.0, self.size + self.value.abs());
        for &(at, c) in &self.terms {
            let term = c * x[at / 3][at % 3];
            reached += term;
            size += term.abs();
        }
        (self.value - reached, size)
    }

    fn length(&self) -> f64 {
        self.terms.iter().fold(0.0, |m: f64, (_, c)| m.hypot(*c))
    }
}

/// Coordinates `v` in which the metric is Euclid's and the point to be near to is zero.
pub(crate) trait Space {
    /// The gradient of a row's value.
    fn whiten(&self, row: &Row) -> Vec<f64>;
    /// The shape of some coordinates.
    fn place(&self, v: &[f64], x: &mut [Vector]);
}

/// The nearest point.
pub(crate) struct Nearest {
    pub(crate) x: Vec<Vector>,
    /// The inequalities that hold with equality, and are independent, in the order in which they came.
    pub(crate) active: Vec<usize>,
    /// Of all rows: how much half the squared distance would grow with their values.
    pub(crate) multipliers: Vec<f64>,
}

/// Why there is none.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A row that no step brings nearer: it contradicts the others, or nearly depends on them.
    Contradiction,
    /// It took too many steps, too many numbers, or they overflow.
    Work,
}

/// The nearest point; `guess` are inequalities that are probably active. `O(steps · active · size)`.
pub(crate) fn nearest(
    rows: &[Row],
    space: &dyn Space,
    n: usize,
    guess: &[usize],
) -> Result<Nearest, Failure> {
    let mut search = Search {
        rows,
        space,
        white: vec![None; rows.len()],
        lengths: rows.iter().map(Row::length).collect(),
        active: Vec::new(),
        is_active: vec![false; rows.len()],
        passed: vec![false; rows.len()],
        equations: 0,
        q: Vec::new(),
        r: Vec::new(),
        multipliers: Vec::new(),
        z: Vec::new(),
        within: Vec::new(),
        v: Vec::new(),
        start: vec![Vector::zeros(); n],
        x: vec![Vector::zeros(); n],
    };
    search.run(guess)?;
    let mut multipliers = vec![0.0; rows.len()];
    for (&row, u) in search.active.iter().zip(&search.multipliers) {
        multipliers[row] = u / search.white[row].as_ref().map_or(1.0, |w| w.norm);
    }
    let active = search.active[search.equations..].to_vec();
    Ok(Nearest { x: search.x, active, multipliers })
}

/// A row in the metric's coordinates, of unit length, and the length that it had.
#[derive(Clone)]
struct White {
    row: Vec<f64>,
    norm: f64,
}

struct Search<'a> {
    rows: &'a [Row],
    space: &'a dyn Space,
    white: Vec<Option<White>>,
    /// Of the rows in the shape's coordinates.
    lengths: Vec<f64>,
    /// Active rows, the equations first, and their multipliers.
    active: Vec<usize>,
    is_active: Vec<bool>,
    /// Rows that are met as nearly as they can be.
    passed: Vec<bool>,
    equations: usize,
    q: Vec<Vec<f64>>,
    r: Vec<Vec<f64>>,
    multipliers: Vec<f64>,
    /// The part of a row outside the span of the active rows, and its coefficients within.
    z: Vec<f64>,
    within: Vec<f64>,
    v: Vec<f64>,
    /// The shape at `v = 0`, and at `v`.
    start: Vec<Vector>,
    x: Vec<Vector>,
}

impl Search<'_> {
    fn run(&mut self, guess: &[usize]) -> Result<(), Failure> {
        let width = self.space.whiten(&Row::default()).len();
        self.v = vec![0.0; width];
        self.space.place(&self.v, &mut self.start);
        self.x.clone_from(&self.start);
        for row in 0..self.rows.len() {
            if self.rows[row].equation && self.project(row) {
                self.activate(row, 0.0);
                self.bounded()?;
            }
        }
        self.equations = self.active.len();
        for &row in guess {
            let known = self.rows.get(row).is_some_and(|r| !r.equation) && !self.is_active[row];
            if known && self.project(row) {
                self.activate(row, 0.0);
                self.bounded()?;
            }
        }
        self.recompute()?;
        // A row comes and goes a few times at most; the bound is for what rounding might do.
        let mut patience = 20 * self.rows.len() + 100;
        while let Some(row) = self.most_violated() {
            self.add(row, &mut patience)?;
            self.bounded()?;
        }
        Ok(())
    }

    fn bounded(&self) -> Result<(), Failure> {
        if self.active.len() * self.v.len() > LIMIT { Err(Failure::Work) } else { Ok(()) }
    }

    /// The inequality that is violated most, in units of distance.
    fn most_violated(&self) -> Option<usize> {
        let mut worst = None;
        let waiting = |row: usize| !self.rows[row].equation && !self.is_active[row] && !self.passed[row];
        for (row, of) in self.rows.iter().enumerate().filter(|(row, _)| waiting(*row)) {
            let (missing, size) = of.missing(&self.x);
            if missing > MET * size {
                let distance = missing / self.lengths[row].max(f64::MIN_POSITIVE);
                if worst.is_none_or(|(most, _)| distance > most) {
                    worst = Some((distance, row));
                }
            }
        }
        worst.map(|(_, row)| row)
    }

    /// `z` and `within` of a row; whether `z` is more than rounding.
    fn project(&mut self, row: usize) -> bool {
        let white = self.white[row].get_or_insert_with(|| {
            let mut white = self.space.whiten(&self.rows[row]);
            let norm = dot(&white, &white).sqrt();
            if norm > 0.0 && norm.is_finite() {
                white.iter_mut().for_each(|w| *w /= norm);
                White { row: white, norm }
            } else {
                White { row: Vec::new(), norm: 0.0 }
            }
        });
        self.within.clear();
        self.within.resize(self.q.len(), 0.0);
        self.z.clone_from(&white.row);
        if self.z.is_empty() {
            self.z.resize(self.v.len(), 0.0);
            return false;
        }
        // Twice is enough: the second pass takes away what rounding left of the first.
        for _ in 0..2 {
            for (q, within) in self.q.iter().zip(&mut self.within) {
                let share = dot(q, &self.z);
                *within += share;
                add(&mut self.z, -share, q);
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
    }

    fn norm(&self, row: usize) -> f64 {
        self.white[row].as_ref().map_or(1.0, |w| w.norm)
    }

    /// Point and multipliers of the active rows, computed anew; inequalities that pull the wrong way are let go.
    fn recompute(&mut self) -> Result<(), Failure> {
        loop {
            let mut y = vec![0.0; self.active.len()];
            self.v.fill(0.0);
            self.x.clone_from(&self.start);
            for _ in 0..=CORRECTIONS {
                let missing = |&row: &usize| self.rows[row].missing(&self.x).0 / self.norm(row);
                let mut more: Vec<f64> = self.active.iter().map(missing).collect();
                for j in 0..more.len() {
                    let column = &self.r[j];
                    more[j] = (more[j] - dot(&column[..j], &more[..j])) / column[j];
                }
                for (more, q) in more.iter().zip(&self.q) {
                    add(&mut self.v, *more, q);
                }
                add(&mut y, 1.0, &more);
                self.space.place(&self.v, &mut self.x);
            }
            if !self.x.iter().all(|x| x.iter().all(|c| c.is_finite())) {
                return Err(Failure::Work);
            }
            self.multipliers = self.solved(&y);
            let strongest = self.multipliers.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            let weakest = self.multipliers.iter().copied().enumerate().skip(self.equations);
            match weakest.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((j, u)) if u < -IDLE * strongest => self.release(j),
                _ => break,
            }
        }
        self.multipliers[self.equations..].iter_mut().for_each(|u| *u = u.max(0.0));
        Ok(())
    }

    /// `R⁻¹ y`.
    fn solved(&self, y: &[f64]) -> Vec<f64> {
        let mut out = y.to_vec();
        for j in (0..out.len()).rev() {
            let value = out[j] / self.r[j][j];
            out[j] = value;
            add(&mut out[..j], -value, &self.r[j][..j]);
        }
        out
    }

    /// Makes a violated inequality hold, dropping those that stand in the way.
    fn add(&mut self, row: usize, patience: &mut usize) -> Result<(), Failure> {
        let mut multiplier = 0.0;
        loop {
            *patience = patience.checked_sub(1).ok_or(Failure::Work)?;
            let free = self.project(row);
            // By how much the active multipliers fall when the new row's grows by 1.
            let fall = self.solved(&self.within);
            let largest = fall.iter().fold(1.0_f64, |m, f| m.max(f.abs()));
            // The first multiplier to reach zero: an inequality's, for an equation's may have any sign.
            let mut first: Option<(usize, f64)> = None;
            for (j, (fall, u)) in fall.iter().zip(&self.multipliers).enumerate().skip(self.equations) {
                if *fall > DEPENDENT * largest {
                    let step = (u / fall).max(0.0);
                    if first.is_none_or(|(_, least)| step < least) {
                        first = Some((j, step));
                    }
                }
            }
            let missing = self.rows[row].missing(&self.x).0 / self.norm(row);
            let full = if free { missing.max(0.0) / dot(&self.z, &self.z) } else { f64::INFINITY };
            let (step, blocking) = match first {
                Some((j, step)) if step < full => (step, Some(j)),
                _ if free => (full, None),
                // What the active rows imply but for rounding that they enlarged: whoever hands the point out will judge.
                _ if missing * self.norm(row) <= NEARLY * self.rows[row].missing(&self.x).1 => {
                    self.passed[row] = true;
                    return self.recompute();
                }
                _ => return Err(Failure::Contradiction),
            };
            if !step.is_finite() {
                return Err(Failure::Work);
            }
            if free && step > 0.0 {
                add(&mut self.v, step, &self.z);
                self.space.place(&self.v, &mut self.x);
            }
            add(&mut self.multipliers, -step, &fall);
            multiplier += step;
            match blocking {
                Some(j) => self.release(j),
                None => {
                    self.activate(row, multiplier);
                    return self.recompute();
                }
            }
        }
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
    }
}
