//! From a guess of the active inequalities to the set that is right: block principal pivoting.

use super::active_set::{Outcome, Program, Sense};
use super::saddle::Bordered;
use super::symmetric::Symmetric;
use super::system::SparseRows;

/// A violation below this, relative to the size of the numbers at hand, is rounding.
const MET: f64 = 1e-12;
/// A multiplier below this part of the largest is none.
const IDLE: f64 = 1e-12;
/// Guesses before it is given up, and how many may be no better than the best before they change one row at a time.
const GUESSES: usize = 60;
const PATIENCE: usize = 8;

impl Program<'_> {
    /// `P` and `G` of the same program without a metric beside them: the [system's](super::System::matrices). `xᵀPx` is to be least, each
    /// row of `G x` on its side.
    pub fn matrices(&self) -> (Symmetric, SparseRows) {
        self.system.matrices()
    }

    /// The outcome, found from a guess of the active inequalities: the least adjustment under these; what pulls the wrong way
    /// is let go and what is violated taken in, all at once while that helps and one at a time where it does not (Júdice and
    /// Pires 1994, after Murty). What it ends with meets the conditions of Karush, Kuhn and Tucker to rounding, whatever the
    /// guess. `None` where it does not get there (and always where there is a contradiction): ask an active-set method then.
    ///
    /// A guess costs a factorisation of the bordered matrix within its envelope: `O(m b²)` for `m` columns and rows that reach
    /// over `b` of them. For bounds on curves that is linear, and a few guesses are enough for hundreds of active ones.
    pub fn pivot(&self, guess: &[usize]) -> Option<Outcome> {
        let count = self.system.rows().len();
        if self.system.sides() != 1
            || self.system.free() > 0
            || [self.rhs.len(), self.senses.len(), self.size.len()] != [count; 3]
        {
            return None;
        }
        let (metric, rows) = self.matrices();
        let mut unit = SparseRows::with_capacity(rows.width(), count, rows.entries());
        let mut scale = Vec::with_capacity(count);
        for row in 0..count {
            let length = rows.norm(row);
            let turned = if self.senses[row] == Sense::AtMost { -1.0 } else { 1.0 };
            scale.push(if length > 0.0 { turned / length } else { turned });
            unit.push(rows.iter_row(row).map(|(c, v)| (c, v * scale[row])));
        }
        let rhs: Vec<f64> = self.rhs.iter().zip(&scale).map(|(b, s)| b * s).collect();
        let rounding = self.size.iter().zip(self.rhs).map(|(size, b)| size + b.abs());
        let rounding: Vec<f64> = rounding.zip(&scale).map(|(size, s)| MET * size * s.abs()).collect();
        let bordered = Bordered::new(&metric, &unit);
        let mut state = Pivoting {
            program: self,
            metric: &metric,
            rows: &unit,
            rhs,
            rounding,
            bordered,
            active: vec![false; count],
        };
        for &row in guess {
            if self.senses.get(row).is_some_and(|s| *s != Sense::Equal) {
                state.active[row] = true;
            }
        }
        let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
        for steps in 1..=GUESSES {
            let Tried { wrong, rows } = state.attempt()?;
            let (Some(&last), found) = (wrong.last(), wrong.len()) else {
                return Some(Outcome::Active { rows, steps });
            };
            let all = found < fewest || patience > 0;
            patience = if found < fewest { PATIENCE } else { patience.saturating_sub(1) };
            fewest = fewest.min(found);
            let flipped = if all { wrong.as_slice() } else { std::slice::from_ref(&last) };
            flipped.iter().for_each(|&row| state.active[row] = !state.active[row]);
        }
        None
    }
}

struct Pivoting<'a> {
    program: &'a Program<'a>,
    metric: &'a Symmetric,
    /// Of unit length, and turned so that every inequality is `≥`.
    rows: &'a SparseRows,
    rhs: Vec<f64>,
    /// How far a row's value may be off.
    rounding: Vec<f64>,
    bordered: Bordered<'a>,
    active: Vec<bool>,
}

/// What a guess came to.
struct Tried {
    /// The inequalities that are violated, or active and pull the wrong way, ascending.
    wrong: Vec<usize>,
    /// The active ones that are independent.
    rows: Vec<usize>,
}

impl Pivoting<'_> {
    fn attempt(&self) -> Option<Tried> {
        let senses = self.program.senses;
        let equal = |row: usize| senses[row] == Sense::Equal;
        let mut kept: Vec<(Option<usize>, usize)> = (0..senses.len())
            .filter(|&row| equal(row) || self.active[row])
            .map(|row| (self.bordered.last(row), row))
            .collect();
        // Of rows that say the same, the equation comes first, then the one that asks for most.
        kept.sort_by(|a, b| {
            let demand = self.rhs[b.1].total_cmp(&self.rhs[a.1]);
            (a.0, !equal(a.1)).cmp(&(b.0, !equal(b.1))).then(demand).then(a.1.cmp(&b.1))
        });
        let kept: Vec<usize> = kept.into_iter().map(|(_, row)| row).collect();
        let saddle = self.bordered.factor(&kept).ok()?;
        let mut left_out = vec![false; kept.len()];
        saddle.left_out().for_each(|k| left_out[k] = true);
        let n = self.rows.width();
        let (mut x, mut y) = (vec![0.0; n], vec![0.0; kept.len()]);
        let (mut force, mut missing) = (vec![0.0; n], vec![0.0; kept.len()]);
        let mut room = Vec::with_capacity(n + kept.len());
        // The last two passes take away what rounding, without pivots, left of the first.
        for _ in 0..3 {
            self.metric.multiply(&x, 1, &mut force);
            for (k, &row) in kept.iter().enumerate() {
                let mut reached = 0.0;
                for (column, value) in self.rows.iter_row(row) {
                    force[column] += value * y[k];
                    reached += value * x[column];
                }
                missing[k] = if left_out[k] { 0.0 } else { self.rhs[row] - reached };
            }
            force.iter_mut().for_each(|f| *f = -*f);
            saddle.solve(&force, &missing, &mut x, &mut y, &mut room);
        }
        if x.iter().chain(&y).any(|v| !v.is_finite()) {
            return None;
        }
        let strongest = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut holds = vec![false; senses.len()];
        let mut tried = Tried { wrong: Vec::new(), rows: Vec::new() };
        for (k, &row) in kept.iter().enumerate().filter(|(k, _)| !left_out[*k]) {
            holds[row] = true;
            if !equal(row) {
                tried.rows.push(row);
                // P x + Gᵀy = 0: the multiplier is -y.
                if y[k] > IDLE * strongest {
                    tried.wrong.push(row);
                }
            }
        }
        for row in 0..senses.len() {
            let reached: f64 = self.rows.iter_row(row).map(|(column, value)| value * x[column]).sum();
            let short = self.rhs[row] - reached;
            if holds[row] || equal(row) {
                // Not solved well enough; or an equation that others imply, and deny.
                if short.abs() > 100.0 * self.rounding[row] {
                    return None;
                }
            } else if short > self.rounding[row] {
                tried.wrong.push(row);
            }
        }
        tried.wrong.sort_unstable();
        tried.rows.sort_unstable();
        Some(tried)
    }
}
