//! What loops bound in a surface's parameter plane, cell by cell.
//!
//! The lines of constant `u` between cells are thought to lie a trifle (of the size of rounding) beyond their knots, so that what runs along a knot line belongs to the cell before
//! it, and every loop either crosses a line or does not. How often loops go around places on a line follows from the crossings: it
//! changes by one at each, is the same all along a row of cells but for what is crossed there, and is 0 or 1 everywhere. So nothing depends
//! on which way loops wind around a surface that closes.

mod count;
mod net;
#[cfg(test)]
mod tests;

use super::trimmed::ParameterCurve;
use super::{ParameterSide, Surface};
use crate::error::{Error, Result};
use crate::shape::share::{CellPart, Share};
use count::{Crossing, Windings};
use net::{Net, cut, ends, pieces, range, shifted};

/// How far beyond its knot a line is, as a share of the domain.
const BEYOND: f64 = 5e-14;
/// What is nearer to a side of a cell than this, as a share of the domain, runs along it.
const ALONG: f64 = 2e-13;
/// What is off a seam by less than this part of the domain runs along it.
const SEAM: f64 = 1e-9;
/// The row that is looked along is at an odd share of something.
const SHARES: [f64; 4] = [0.483_7, 0.517_13, 0.391_7, 0.631_9];

/// A part of a loop within a cell: the cell's column and row, counted on where the loop goes around the surface, and which turn of the row
/// looked along it is in.
struct Part {
    net: Net,
    column: i64,
    row: i64,
    turn: i64,
}

/// The part of a surface's parameter plane that loops bound.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRegion {
    breaks: [Vec<f64>; 2],
    shares: Vec<Share>,
}

/// One direction: the ends of its cells, and how to count them.
struct Axis {
    breaks: Vec<f64>,
    /// Where cells start and end for what runs along their sides: a trifle beyond their knots in `u`; the first a trifle before its own, where
    /// the surface does not go on. In `v` at the knots, since what runs along these bounds nothing.
    lines: Vec<f64>,
    side: ParameterSide,
}

impl Axis {
    fn new(breaks: Vec<f64>, side: ParameterSide, beyond: f64) -> Self {
        let beyond = beyond * side.length();
        let mut lines: Vec<f64> = breaks.iter().map(|b| b + beyond).collect();
        if let (Some(line), false) = (lines.first_mut(), side.closed) {
            *line = breaks[0] - beyond;
        }
        Self { breaks, lines, side }
    }

    fn cells(&self) -> i64 {
        self.breaks.len() as i64 - 1
    }

    /// The lines that something between two places may cross.
    fn lines(&self, low: f64, high: f64) -> Vec<f64> {
        let length = self.side.length();
        let turns = if self.side.closed {
            let turn = |x: f64| ((x - self.side.low) / length).floor() as i64;
            turn(low) - 1..=turn(high)
        } else {
            0..=0
        };
        let mut all = Vec::new();
        for turn in turns {
            let skip = usize::from(self.side.closed);
            let shift = turn as f64 * length;
            all.extend(self.lines[skip..].iter().map(|x| x + shift).filter(|x| *x > low && *x < high));
        }
        all
    }

    /// The number of the cell of a place: before the first one -1, after the last one their number; counted on where the surface closes.
    fn cell(&self, x: f64) -> i64 {
        let length = self.side.length();
        let turn = if self.side.closed { ((x - self.lines[0]) / length).ceil() - 1.0 } else { 0.0 };
        let own = x - turn * length;
        // Cells end with their upper side, and do not start with their lower one.
        let index = self.lines.partition_point(|line| *line < own) as i64 - 1;
        let index = if self.side.closed { index.clamp(0, self.cells() - 1) } else { index };
        turn as i64 * self.cells() + index
    }

    /// The cell within the domain, and by how many periods it is away.
    fn within(&self, cell: i64) -> (i64, f64) {
        if self.side.closed {
            (cell.rem_euclid(self.cells()), cell.div_euclid(self.cells()) as f64 * self.side.length())
        } else {
            (cell, 0.0)
        }
    }
}

impl ParameterRegion {
    /// What is to the left of loops: chains of curves, each with whether it is run backwards. Where one does not start where the one before
    /// ends, the way there is straight; in directions that close, to the nearest such place.
    ///
    /// `O(pieces)`, and the cells that they cross.
    ///
    /// # Errors
    /// When loops bound nothing, or do not separate what is inside from what is outside.
    pub fn new(
        surface: &Surface,
        sides: &[ParameterSide; 2],
        loops: &[Vec<(&ParameterCurve, bool)>],
    ) -> Result<Self> {
        let axes = [(surface.u(), sides[0], BEYOND), (surface.v(), sides[1], 0.0)]
            .map(|(space, side, beyond)| Axis::new(space.breakpoints(), side, beyond));
        let mut chains = Vec::with_capacity(loops.len());
        for chain in loops {
            chains.push(joined(chain, sides)?);
        }
        if is_all(&chains, sides) {
            let cells: usize = axes.iter().map(|axis| axis.breaks.len() - 1).product();
            return Ok(Self { breaks: axes.map(|axis| axis.breaks), shares: vec![Share::Whole; cells] });
        }
        let row = row_looked_along(&axes[1], &chains);
        let mut windings = Windings::new([axes[0].cells(), axes[1].cells()], sides);
        let mut parts: Vec<Part> = Vec::new();
        for (nets, turns) in &chains {
            let first = parts.len();
            for net in nets {
                parts.extend(in_cells(net, &axes, row));
            }
            crossings(&parts[first..], *turns, &axes, &mut windings);
        }
        let levels = windings.levels(row)?;
        let mut cells = Cells::new(&axes);
        for part in parts {
            cells.border(part, levels.flipped);
        }
        for (line, steps) in levels.lines.iter().enumerate() {
            cells.side(line, steps);
        }
        let shares = cells.shares();
        Ok(Self { breaks: axes.map(|axis| axis.breaks), shares })
    }

    /// How much counts of the cell between the knots from these on.
    pub fn share(&self, starts: [f64; 2]) -> &Share {
        let index = |d: usize| {
            let cells = self.breaks[d].len() - 1;
            self.breaks[d].partition_point(|b| *b <= starts[d]).clamp(1, cells) - 1
        };
        let columns = self.breaks[1].len() - 1;
        self.shares.get(index(0) * columns + index(1)).unwrap_or(&Share::Nothing)
    }
}

/// The pieces of a loop, one where the other ends, and by how many periods its end is away from its start.
fn joined(chain: &[(&ParameterCurve, bool)], sides: &[ParameterSide; 2]) -> Result<(Vec<Net>, [i64; 2])> {
    let mut all: Vec<Net> = Vec::new();
    let mut at: Option<[f64; 2]> = None;
    let step = |all: &mut Vec<Net>, from: [f64; 2], to: [f64; 2]| {
        let near = [0, 1].map(|d: usize| sides[d].unwrapped(to[d], from[d]));
        if near != from {
            all.push(vec![[from[0], from[1], 1.0], [near[0], near[1], 1.0]]);
        }
        near
    };
    for &(curve, reversed) in chain {
        for net in pieces(curve, reversed)? {
            let [start, end] = ends(&net);
            let near = at.map_or(start, |at| step(&mut all, at, start));
            let by = [near[0] - start[0], near[1] - start[1]];
            all.push(shifted(&net, by));
            at = Some([end[0] + by[0], end[1] + by[1]]);
        }
    }
    let (Some(first), Some(at)) = (all.first(), at) else { return Ok((all, [0; 2])) };
    let start = ends(first)[0];
    let near = step(&mut all, at, start);
    let turns = [0, 1].map(|d: usize| {
        if sides[d].closed { ((near[d] - start[d]) / sides[d].length()).round() as i64 } else { 0 }
    });
    Ok((all, turns))
}

/// Whether all there is of a surface that closes both ways is one loop along its seams: there and back along each, so that what is on both sides counts.
fn is_all(chains: &[(Vec<Net>, [i64; 2])], sides: &[ParameterSide; 2]) -> bool {
    let [(nets, [0, 0])] = chains else { return false };
    let near = |d: usize| SEAM * sides[d].length();
    let along = |net: &Net| {
        let [from, to] = ends(net);
        let points = || net.iter().map(|[u, v, w]| [u / w, v / w]);
        let runs = |d: usize| points().all(|at| (at[d] - from[d]).abs() <= near(d));
        (0..2).find(|&d| runs(d)).map(|d| (d, [from[d], to[1 - d] - from[1 - d]]))
    };
    // What runs along u, and what along v: at which places of the other, and how far each way.
    let mut far = [[0.0; 2]; 2];
    let mut places = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for net in nets {
        let Some((d, [at, way])) = along(net) else { return false };
        far[d][usize::from(way < 0.0)] += way.abs();
        places[d] = [places[d][0].min(at), places[d][1].max(at)];
    }
    (0..2).all(|d| {
        let (own, other) = (sides[d].length(), sides[1 - d].length());
        sides[d].closed
            && (places[d][1] - places[d][0] - own).abs() <= near(d)
            && far[d].iter().all(|way| (way - other).abs() <= near(1 - d))
    })
}

/// A value of `v` at which loops are crossed: within the piece that is longest along `v`.
fn row_looked_along(axis: &Axis, chains: &[(Vec<Net>, [i64; 2])]) -> f64 {
    let mut longest = (0.0, [axis.side.low, axis.side.high]);
    for net in chains.iter().flat_map(|(nets, _)| nets) {
        let [a, b] = ends(net).map(|end| end[1]);
        if (b - a).abs() > longest.0 {
            longest = ((b - a).abs(), [a.min(b), a.max(b)]);
        }
    }
    let (length, [low, high]) = longest;
    let [low, high] =
        if length <= ALONG * axis.side.length() { [axis.side.low, axis.side.high] } else { [low, high] };
    let clear = |row: &f64| {
        let own = axis.side.wrapped(*row);
        let near = ALONG * axis.side.length();
        axis.breaks.iter().all(|b| (b - own).abs() > near)
            && chains.iter().flat_map(|(nets, _)| nets).all(|net| {
                let [a, b] = range(net, 1).map(|y| axis.side.wrapped(y));
                (a - own).abs() > near && (b - own).abs() > near
            })
    };
    let rows = SHARES.map(|share| low + (high - low) * share);
    let row = rows.into_iter().find(clear).unwrap_or(rows[0]);
    axis.side.wrapped(row)
}

/// A piece cut where it goes from cell to cell, and where it crosses the row looked along.
fn in_cells(net: &Net, axes: &[Axis; 2], row: f64) -> Vec<Part> {
    let [low, high] = range(net, 0);
    let mut all = Vec::new();
    for part in cut(net.clone(), 0, axes[0].lines(low, high).into_iter()) {
        let [low, high] = range(&part, 1);
        let mut lines = axes[1].lines(low, high);
        let side = &axes[1].side;
        if side.closed {
            let turn = |y: f64| ((y - row) / side.length()).floor() as i64;
            lines.extend((turn(low)..=turn(high)).map(|turn| row + turn as f64 * side.length()));
        } else {
            lines.push(row);
        }
        all.extend(cut(part, 1, lines.into_iter()));
    }
    let placed = |net: Net| {
        let (at, _) = crate::shape::share::place(&net, 0.5);
        let turn = if axes[1].side.closed {
            ((at[1] - row) / axes[1].side.length()).floor() as i64
        } else {
            i64::from(at[1] > row)
        };
        Part { column: axes[0].cell(at[0]), row: axes[1].cell(at[1]), turn, net }
    };
    all.into_iter().map(placed).collect()
}

/// Where a loop goes from column to column, and across the row looked along.
fn crossings(parts: &[Part], turns: [i64; 2], axes: &[Axis; 2], windings: &mut Windings) {
    for (k, part) in parts.iter().enumerate() {
        let next = &parts[(k + 1) % parts.len()];
        let around = if k + 1 == parts.len() { turns } else { [0; 2] };
        let joint = ends(&part.net)[1];
        let column = next.column + around[0] * axes[0].cells();
        let steps = column - part.column;
        for step in 0..steps.abs() {
            // The line after cell `k` is number `k + 1`.
            let line = if steps > 0 { part.column + 1 + step } else { part.column - step };
            windings.line(axes[0].within(line - 1).0 + 1, Crossing { at: joint[1], up: steps.signum() });
        }
        let steps = next.turn + around[1] - part.turn;
        if steps != 0 {
            let (column, by) = axes[0].within(part.column);
            windings.row(column, Crossing { at: joint[0] - by, up: -steps });
        }
    }
}

/// The cells of a surface, while they are filled.
struct Cells<'a> {
    axes: &'a [Axis; 2],
    boxes: Vec<Vec<(f64, f64, f64)>>,
    borders: Vec<Vec<Net>>,
}

/// Boxes of a cell that count, and borders through it.
type Parts = (Vec<(f64, f64, f64)>, Vec<Net>);

impl<'a> Cells<'a> {
    fn new(axes: &'a [Axis; 2]) -> Self {
        let count = (axes[0].cells() * axes[1].cells()) as usize;
        Self { axes, boxes: vec![Vec::new(); count], borders: vec![Vec::new(); count] }
    }

    fn index(&self, column: i64, row: i64) -> Option<usize> {
        let inside = (0..self.axes[0].cells()).contains(&column) && (0..self.axes[1].cells()).contains(&row);
        inside.then(|| (column * self.axes[1].cells() + row) as usize)
    }

    /// A part of a loop. What runs along `u`, or along the lower side in `u`, bounds nothing in Green's theorem; what runs along the upper side
    /// bounds a box, however low: [`Cells::side`] counts what lies between two such parts, and they have to end where it starts.
    fn border(&mut self, part: Part, flipped: bool) {
        let (column, by_u) = self.axes[0].within(part.column);
        let (row, by_v) = self.axes[1].within(part.row);
        let Some(index) = self.index(column, row) else { return };
        let net = shifted(&part.net, [-by_u, -by_v]);
        let near = self.axes.each_ref().map(|axis| ALONG * axis.side.length());
        let of = |d: usize, k: i64| (self.axes[d].breaks[k as usize], self.axes[d].breaks[k as usize + 1]);
        let [low, high] = range(&net, 0);
        let (start, end) = of(0, column);
        let [bottom, top] = range(&net, 1);
        if high <= start + near[0] {
            return;
        }
        let sign = if flipped { -1.0 } else { 1.0 };
        if low >= end - near[0] {
            let [a, b] = ends(&net).map(|end| end[1]);
            let (low, high) = of(1, row);
            self.boxes[index].push((a.clamp(low, high), b.clamp(low, high), sign));
            return;
        }
        if top - bottom > near[1] {
            self.borders[index].push(if flipped { net.into_iter().rev().collect() } else { net });
        }
    }

    /// What counts on the upper side of a column: from where to where, and how often.
    fn side(&mut self, line: usize, intervals: &[(f64, f64, i64)]) {
        let axis = &self.axes[1];
        for row in 0..axis.cells() {
            let (low, high) = (axis.breaks[row as usize], axis.breaks[row as usize + 1]);
            let Some(index) = self.index(line as i64, row) else { continue };
            for &(from, to, times) in intervals {
                let (from, to) = (from.max(low), to.min(high));
                if from < to {
                    self.boxes[index].push((from, to, times as f64));
                }
            }
        }
    }

    /// What became of them.
    fn shares(self) -> Vec<Share> {
        let rows = self.axes[1].cells();
        let near = ALONG * self.axes[1].side.length();
        let each = self.boxes.into_iter().zip(self.borders).enumerate();
        let share = |(index, (boxes, borders)): (usize, Parts)| {
            let (column, row) = (index / rows as usize, index % rows as usize);
            let ends = |d: usize, k: usize| (self.axes[d].breaks[k], self.axes[d].breaks[k + 1]);
            let ((left, right), (low, high)) = (ends(0, column), ends(1, row));
            let boxes = summed(&boxes, near);
            if borders.is_empty() {
                match boxes[..] {
                    [] => return Share::Nothing,
                    [(from, to, times)] if times == 1.0 && from <= low + near && to >= high - near => {
                        return Share::Whole;
                    }
                    _ => {}
                }
            }
            Share::Part(CellPart::new([left, low], [right, high], boxes, borders))
        };
        each.map(share).collect()
    }
}

/// Intervals with how often they count, as intervals side by side.
fn summed(boxes: &[(f64, f64, f64)], near: f64) -> Vec<(f64, f64, f64)> {
    let mut steps: Vec<(f64, f64)> =
        boxes.iter().flat_map(|&(from, to, times)| [(from, times), (to, -times)]).collect();
    steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut all: Vec<(f64, f64, f64)> = Vec::new();
    let mut times = 0.0;
    let mut k = 0;
    while k < steps.len() {
        let at = steps[k].0;
        // Steps that rounding set apart are one.
        while k < steps.len() && steps[k].0 <= at + near {
            times += steps[k].1;
            k += 1;
        }
        let next = steps.get(k).map_or(at, |step| step.0);
        if times != 0.0 && next > at {
            match all.last_mut() {
                Some(last) if last.1 == at && last.2 == times => last.1 = next,
                _ => all.push((at, next, times)),
            }
        }
    }
    all
}

/// That loops do not say what is inside.
fn unclear(why: &str) -> Error {
    Error::Invalid(format!(
        "its loops do not separate what is inside from what is outside: {why}; they must close and run counterclockwise around it"
    ))
}
