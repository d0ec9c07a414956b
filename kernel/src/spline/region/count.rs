//! How often loops go around places on the lines between cells.

use super::unclear;
use crate::error::{Error, Result};
use crate::spline::ParameterSide;

/// Crossings that are nearer than this share of the domain are at one place.
const ONE_PLACE: f64 = 1e-9;

/// A place where a loop crosses a line: from there on it counts so many times more.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) at: f64,
    pub(super) up: i64,
}

/// All crossings.
pub(super) struct Windings {
    cells: [i64; 2],
    sides: [ParameterSide; 2],
    /// Of the line after each column.
    lines: Vec<Vec<Crossing>>,
    /// Of the row looked along, in each column; before the first one those that are left of it.
    columns: Vec<Vec<Crossing>>,
}

/// How often loops go around places.
pub(super) struct Levels {
    /// Of the line after each column: from which `v` to which one, and how often.
    pub(super) lines: Vec<Vec<(f64, f64, i64)>>,
    /// Whether all loops run the other way.
    pub(super) flipped: bool,
}

impl Windings {
    pub(super) fn new(cells: [i64; 2], sides: &[ParameterSide; 2]) -> Self {
        let count = cells[0] as usize;
        Self { cells, sides: *sides, lines: vec![Vec::new(); count], columns: vec![Vec::new(); count + 2] }
    }

    /// A crossing of line number `line`, the one after cell `line - 1`: that before the first cell leads nowhere.
    pub(super) fn line(&mut self, line: i64, crossing: Crossing) {
        if (1..=self.cells[0]).contains(&line) {
            self.lines[line as usize - 1].push(crossing);
        }
    }

    /// A crossing of the row looked along within a column.
    pub(super) fn row(&mut self, column: i64, crossing: Crossing) {
        self.columns[(column + 1).clamp(0, self.cells[0] + 1) as usize].push(crossing);
    }

    /// How often places count, found from the row at `v = row` outwards.
    pub(super) fn levels(mut self, row: f64) -> Result<Levels> {
        let [u, v] = self.sides;
        let mut seen = vec![0];
        let mut level = 0;
        let mut at_row = Vec::with_capacity(self.lines.len());
        let count = self.columns.len();
        for (k, column) in self.columns.iter_mut().enumerate() {
            level = walk(column, level, ONE_PLACE * u.length(), &mut seen);
            if k > 0 && k + 1 < count {
                at_row.push(level);
            }
        }
        if u.closed && level != 0 {
            return Err(one_way());
        }
        let mut lines = Vec::with_capacity(self.lines.len());
        for (own, &start) in self.lines.iter_mut().zip(&at_row) {
            if v.closed {
                // Counted from the row on, where nothing is crossed.
                let period = v.length();
                own.iter_mut().for_each(|one| one.at = row + (one.at - row).rem_euclid(period));
            }
            own.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
            // Downwards from the row, each crossing counts the other way.
            let below: i64 = own.iter().take_while(|one| one.at <= row).map(|one| one.up).sum();
            let first = start - below;
            let last = walk(own, first, ONE_PLACE * v.length(), &mut seen);
            if v.closed && last != first {
                return Err(one_way());
            }
            let mut all = vec![(f64::NEG_INFINITY, first)];
            let mut level = first;
            for one in own.iter() {
                level += one.up;
                all.push((one.at, level));
            }
            lines.push(all);
        }
        let (low, high) = seen.iter().fold((i64::MAX, i64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        // Where the surface does not go on, what is left of all is outside.
        let known = !u.closed && u.poles == [false; 2];
        let (base, flipped) = match (low, high) {
            (0, 0) => return Err(unclear("they bound nothing")),
            (-1, 0) if known => (0, true),
            (0, 1) if known => (0, false),
            _ if known => return Err(unclear("they go around something more than once")),
            (low, high) if high - low == 1 => (low, false),
            _ => return Err(unclear("they go around something more than once")),
        };
        let right = |level: i64| if flipped { base - level } else { level - base };
        let mut all = Vec::with_capacity(lines.len());
        for steps in lines {
            let level = |step: Option<&(f64, i64)>| step.map_or(0, |step| right(step.1));
            let open = [level(steps.first()), level(steps.last())];
            if !v.closed && open.iter().zip(v.poles).any(|(level, pole)| !pole && *level != 0) {
                return Err(unclear("what is inside goes on where the surface ends"));
            }
            let mut intervals = Vec::new();
            for (k, &(from, level)) in steps.iter().enumerate() {
                let end = if v.closed { row + v.length() } else { f64::INFINITY };
                let to = steps.get(k + 1).map_or(end, |step| step.0);
                let from = if v.closed { from.max(row) } else { from };
                let times = right(level);
                if times == 0 || from >= to {
                    continue;
                }
                intervals.push((from, to, times));
                // What goes on beyond the seam.
                if v.closed && to > v.high {
                    intervals.push((from - v.length(), to - v.length(), times));
                }
            }
            all.push(intervals);
        }
        let lines = all;
        Ok(Levels { lines, flipped })
    }
}

fn one_way() -> Error {
    unclear("they do not go around the surface as often one way as the other")
}

/// The level behind some crossings; those seen on the way, but for slivers between crossings that are one but for rounding.
fn walk(crossings: &mut [Crossing], level: i64, near: f64, seen: &mut Vec<i64>) -> i64 {
    crossings.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    let mut level = level;
    seen.push(level);
    for (k, one) in crossings.iter().enumerate() {
        level += one.up;
        if crossings.get(k + 1).is_none_or(|next| next.at - one.at > near) {
            seen.push(level);
        }
    }
    level
}
