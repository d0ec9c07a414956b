//! Surfaces on a grid of cells whose every few rows and columns are isoparametric lines.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Space, Surface};

use crate::sheet::Sheet;
use crate::stage::trim::{Mask, Trim};

/// At least about this many isoparametric lines each way, and at most twice as many.
const LINES: usize = 8;

/// Of more surfaces than this the lines inside would cover the faces: they have their borders.
const MANY: usize = 200;

/// Cells from one isoparametric line to the next, so that lines look round.
const CELLS: usize = 8;

/// Cells are halved so often where chords turn by more than this, in radians, and are as far from the surface, in units of the stage (two are the page): a
/// fortieth of a millimetre.
const FINER: usize = 3;
const TURN: f64 = 0.14;
const SAGITTA: f64 = 3e-4;

/// Of more surfaces than this none has finer cells.
const FEW: usize = 12;

/// What a row or column of the grid is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Line {
    /// A row between lines.
    None,
    /// An isoparametric line.
    Inner,
    /// A border of the surface.
    Border,
    /// A border of the surface where it is torn: beyond it the next line begins, with nothing in between.
    Tear,
}

/// A surface sampled on a grid.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Row after row.
    pub(crate) points: Vec<Vector>,
    /// The parameters of each row and of each column.
    pub(crate) u: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// What each row and each column is; as many as there are.
    pub(crate) rows: Vec<Line>,
    pub(crate) columns: Vec<Line>,
}

impl Samples {
    fn new(surface: &Surface, lines: usize, cells: [usize; 2]) -> Self {
        let (u, rows) = parameters(surface.u(), lines, cells[0]);
        let (v, columns) = parameters(surface.v(), lines, cells[1]);
        let mut points = Vec::with_capacity(u.len() * v.len());
        for &u in &u {
            for &v in &v {
                // The parameters are in the domain; a failure could only repeat the point before.
                let last = points.last().copied().unwrap_or_else(Vector::zeros);
                points.push(surface.point(u, v).map_or(last, |p| p.coords));
            }
        }
        Self { points, u, v, rows, columns }
    }

    /// Whether lines along `u`, or along `v`, look like polygons, but at corners, which stay.
    fn is_rough(&self, surface: &Surface, along_u: bool) -> bool {
        let width = self.columns.len();
        let (space, at, lines, step, other) = if along_u {
            (surface.u(), &self.u, &self.rows, width, width)
        } else {
            (surface.v(), &self.v, &self.columns, 1, self.rows.len())
        };
        let smooth = |k: &usize| {
            let tears = [k - 1, *k].iter().any(|k| lines[*k] == Line::Tear);
            !tears && space.multiplicity(at[*k]) < space.degree()
        };
        (1..at.len() - 1).filter(smooth).any(|k| {
            (0..other).any(|line| {
                let middle = k * step + if along_u { line } else { line * width };
                let [a, b, c] = [middle - step, middle, middle + step].map(|i| self.points[i]);
                let (before, after) = (b - a, c - b);
                let turns = before.angle(&after) > TURN;
                turns && (after - before).norm() > 8.0 * SAGITTA
            })
        })
    }

    /// Takes back tears on both sides of which the surface is the same: it may be torn there, but is not.
    fn mend(&mut self) {
        let (height, width) = (self.rows.len(), self.columns.len());
        let points = &self.points;
        let near = |a: usize, b: usize| (points[a] - points[b]).amax() <= MET;
        let row = |r: usize| (0..width).all(|c| near(r * width + c, (r + 1) * width + c));
        let column = |c: usize| (0..height).all(|r| near(r * width + c, r * width + c + 1));
        let mended = |lines: &[Line], met: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..lines.len()).filter(|&at| lines[at] == Line::Tear && met(at)).collect()
        };
        let (of_rows, of_columns) = (mended(&self.rows, &row), mended(&self.columns, &column));
        for (lines, list) in [(&mut self.rows, of_rows), (&mut self.columns, of_columns)] {
            for at in list {
                (lines[at], lines[at + 1]) = (Line::None, Line::Inner);
            }
        }
    }

    /// Whether there is something of the surface between a row (of `u`) or column and the next.
    pub(crate) fn joined(lines: &[Line], at: usize) -> bool {
        lines[at] != Line::Tear
    }
}

/// Samples a surface, one of `among`: the more there are, the fewer cells each has. Cells are as many times finer as is asked.
pub(crate) fn samples(surface: &Surface, among: usize, finer: usize) -> Samples {
    let cells = match among {
        0..=4 => CELLS,
        5..=12 => 6,
        13..=40 => 3,
        _ => 1,
    };
    let lines = if among > MANY { 1 } else { LINES };
    let cells = cells * finer * (LINES / lines);
    let mut grid = Samples::new(surface, lines, [cells; 2]);
    let mut finest = [cells; 2];
    // Where lines turn so fast that they look like polygons, more cells. Of many surfaces each is small.
    for _ in 0..FINER {
        let rough = [true, false].map(|along_u| among <= FEW && grid.is_rough(surface, along_u));
        let next = [0, 1].map(|k| if rough[k] { 2 * finest[k] } else { finest[k] });
        if next == finest {
            break;
        }
        finest = next;
        grid = Samples::new(surface, lines, finest);
    }
    grid.mend();
    grid
}

/// What is no tear on the stage, which is two units large.
const MET: f64 = 1e-9;

/// Parameters of a grid in one direction: lines at knots where their number is right, more between few knots,
/// fewer of many. Where the surface may be torn (a knot of multiplicity `p + 1`) the number just below the knot stands for
/// the end of the part before.
fn parameters(space: &Space, least: usize, cells: usize) -> (Vec<f64>, Vec<Line>) {
    let breaks = space.breakpoints();
    let torn = |u: &f64| !space.is_periodic() && space.multiplicity(*u) > space.degree();
    let inner = 1..breaks.len() - 1;
    let tears: Vec<usize> = inner.filter(|&k| torn(&breaks[k])).collect();
    if tears.is_empty() {
        return part(&breaks, space.is_periodic(), least, cells);
    }
    // All parts together have about as many lines as one.
    let lines = least.div_ceil(tears.len() + 1);
    let cells = if tears.len() < least { cells } else { 1 };
    let (mut all, mut kinds) = (Vec::new(), Vec::new());
    let ends = tears.iter().copied().chain([breaks.len() - 1]);
    let mut start = 0;
    for end in ends {
        let mut knots = breaks[start..=end].to_vec();
        let more = end + 1 < breaks.len();
        if let Some(last) = knots.last_mut().filter(|_| more) {
            *last = last.next_down();
        }
        let (values, mut lines) = part(&knots, false, lines, cells);
        if let Some(last) = lines.last_mut().filter(|_| more) {
            *last = Line::Tear;
        }
        all.extend(values);
        kinds.extend(lines);
        start = end;
    }
    (all, kinds)
}

/// The parameters of the isoparametric lines across a direction.
pub(crate) fn lines(space: &Space) -> Vec<f64> {
    let (all, kinds) = parameters(space, LINES, 1);
    all.into_iter().zip(kinds).filter(|(_, kind)| *kind != Line::None).map(|(at, _)| at).collect()
}

/// The parameters between tears, with at least about so many lines.
fn part(breaks: &[f64], periodic: bool, least: usize, cells: usize) -> (Vec<f64>, Vec<Line>) {
    let spans = breaks.len() - 1;
    let lines: Vec<f64> = if spans > 2 * least {
        let step = spans.div_ceil(2 * least);
        let mut lines: Vec<f64> = breaks.iter().copied().step_by(step).collect();
        if !spans.is_multiple_of(step) {
            lines.push(breaks[spans]);
        }
        lines
    } else {
        subdivided(breaks, least.div_ceil(spans))
    };
    let all = subdivided(&lines, cells);
    let last = all.len() - 1;
    let end = if periodic { Line::Inner } else { Line::Border };
    let kind = |i: usize| match i {
        _ if i == 0 || i == last => end,
        _ if i.is_multiple_of(cells) => Line::Inner,
        _ => Line::None,
    };
    let kinds = (0..=last).map(kind).collect();
    (all, kinds)
}

/// The values with `parts - 1` even steps between each two.
fn subdivided(values: &[f64], parts: usize) -> Vec<f64> {
    let between = |pair: &[f64]| {
        let (a, b) = (pair[0], pair[1]);
        (0..parts).map(move |i| a + (b - a) * (i as f64 / parts as f64)).collect::<Vec<_>>()
    };
    let mut all: Vec<f64> = values.windows(2).flat_map(between).collect();
    all.extend(values.last());
    all
}

/// The isoparametric lines and loops of a surface that hides nothing, as far as no face hides them, as path data.
pub(crate) fn wires(sheet: &mut Sheet, surface: &Surface, trim: Option<&Trim>, among: usize) -> String {
    let grid = samples(surface, among, 1);
    let mask = trim.map(|trim| Mask::new(trim, surface));
    let (rows, columns) = (grid.rows.len(), grid.columns.len());
    let mut data = String::new();
    let mut add = |sheet: &mut Sheet, at: &mut dyn Iterator<Item = usize>| {
        let line: Vec<_> = at.map(|i| ([grid.u[i / columns], grid.v[i % columns]], grid.points[i])).collect();
        let chains = match &mask {
            Some(mask) => kept(&line, &|at| mask.has(at)),
            None => vec![line.into_iter().map(|(_, place)| place).collect()],
        };
        chains.iter().for_each(|chain| data.push_str(&sheet.parted(chain, 1)[0]));
    };
    for row in (0..rows).filter(|&r| grid.rows[r] != Line::None) {
        for part in parts(&grid.columns) {
            add(sheet, &mut part.map(|column| row * columns + column));
        }
    }
    for column in (0..columns).filter(|&c| grid.columns[c] != Line::None) {
        for part in parts(&grid.rows) {
            add(sheet, &mut part.map(|row| row * columns + column));
        }
    }
    for points in trim.iter().flat_map(|trim| &trim.loops) {
        let edge = loop_of(surface, points);
        data.push_str(&sheet.parted(&edge, 1)[0]);
    }
    data
}

/// The ranges of lines between tears.
pub(crate) fn parts(lines: &[Line]) -> Vec<std::ops::Range<usize>> {
    let ends = (0..lines.len()).filter(|&at| !Samples::joined(lines, at)).map(|at| at + 1);
    let mut start = 0;
    let mut parts: Vec<_> = ends.map(|end| std::mem::replace(&mut start, end)..end).collect();
    parts.push(start..lines.len());
    parts
}

/// A loop of a trimmed surface, in space.
pub(crate) fn loop_of(surface: &Surface, points: &[[f64; 2]]) -> Vec<Vector> {
    let closed = points.iter().chain(points.first());
    closed.filter_map(|[u, v]| surface.point(*u, *v).ok()).map(|p| p.coords).collect()
}

/// The parts of a line (parameters and places) that count, to an eighth of a step.
pub(crate) fn kept(line: &[([f64; 2], Vector)], has: &impl Fn([f64; 2]) -> bool) -> Vec<Vec<Vector>> {
    let mut chains = Vec::new();
    let mut chain: Vec<Vector> = Vec::new();
    for pair in line.windows(2) {
        let [(a, p), (b, q)] = [pair[0], pair[1]];
        for i in 0..=8 {
            let t = f64::from(i) / 8.0;
            if has([0, 1].map(|k| a[k] + (b[k] - a[k]) * t)) {
                chain.push(p + (q - p) * t);
            } else if !chain.is_empty() {
                chains.push(std::mem::take(&mut chain));
            }
        }
    }
    chains.push(chain);
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torn_direction_has_parts_that_do_not_meet() {
        for tears in [1, 3, 40] {
            let mut knots = vec![0.0; 3];
            knots.extend((1..=tears).flat_map(|t| [f64::from(t); 3]));
            knots.extend([f64::from(tears + 1); 3]);
            let space = Space::open(2, knots).unwrap();
            let (all, kinds) = parameters(&space, LINES, 8);
            let parts = parts(&kinds);
            assert_eq!(parts.len(), tears as usize + 1);
            for (k, part) in parts.iter().enumerate() {
                let k = k as f64;
                assert_eq!(all[part.start], k);
                let end = all[part.end - 1];
                assert!(if part.end == all.len() { end == k + 1.0 } else { end == (k + 1.0).next_down() });
            }
            assert!(all.windows(2).all(|w| w[0] < w[1]) && all.len() <= 3 * 9 * 8);
        }
    }

    #[test]
    fn lines_are_neither_few_nor_many() {
        for spans in [1, 2, 7, 16, 17, 40, 1000] {
            let breaks: Vec<f64> = (0..=spans).map(f64::from).collect();
            for cells in [1, 3, 6] {
                let (all, kinds) = parameters(&Space::clamped(3, &breaks).unwrap(), LINES, cells);
                let lines = kinds.iter().filter(|k| **k != Line::None).count();
                assert!((LINES..=2 * LINES + 2).contains(&lines), "{spans}: {lines}");
                assert_eq!((all[0], all[all.len() - 1]), (0.0, f64::from(spans)));
                assert!(all.windows(2).all(|w| w[0] < w[1]));
                assert_eq!(all.len(), kinds.len());
            }
        }
    }
}
