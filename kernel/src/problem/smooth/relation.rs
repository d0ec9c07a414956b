//! How the pieces on both sides of a joint are related, measured, and the rows that keep it.

use smallvec::SmallVec;

use super::columns::Columns;
use super::joint::Joint;
use crate::Vector;
use crate::shape::{SMOOTH, Stencil};
use crate::spline::curve::row_in;

/// Ends that are no farther apart than this part of the size of the pieces that end there meet.
const MEETS: f64 = 1e-6;
/// A derivative that takes a piece no farther than this part of its size vanishes: it has no direction to keep.
const VANISHES: f64 = 1e-9;
/// Factors between weights that differ by no more than this are one factor.
const ALIKE: f64 = 1e-9;
/// Coordinates are known to this many units in their last place.
pub(super) const ULPS: f64 = 64.0;

/// Rows of position, first and second derivative of one column, from one side, over the column's vertices.
type Rows = [Stencil; 3];

/// One column of control vertices seen from both sides of a joint: it is a curve across the knots.
#[derive(Debug, Clone)]
pub(super) struct Column {
    rows: [Rows; 2],
    jets: [[Vector; 3]; 2],
    /// The derivatives of `Σ w_i N_i`, divided by itself, and the factor between its values on the right and on the left.
    weights: [[f64; 2]; 2],
    factor: f64,
    /// How far its vertices on both spans are from the joint.
    size: f64,
    /// How well lengths are known there.
    noise: f64,
    lengths: [f64; 2],
}

impl Column {
    pub(super) fn new(net: &Columns<'_>, joint: &Joint, column: usize) -> Self {
        let space = net.across;
        let sides = [joint.left, joint.right];
        let weight = |i: usize| net.weight(i, column);
        let plain =
            sides.map(|(span, u)| [0, 1, 2].map(|k| row_in(space, span, u, k, None::<fn(usize) -> f64>)));
        let (rows, weights, factor) = if net.is_rational() {
            let total = |row: &Stencil| -> f64 { row.iter().map(|(i, c)| c * weight(i)).sum() };
            let totals = plain.each_ref().map(|rows| rows.each_ref().map(total));
            let rows = sides.map(|(span, u)| [0, 1, 2].map(|k| row_in(space, span, u, k, Some(weight))));
            (rows, totals.map(|[w, d, e]| [d / w, e / w]), totals[1][0] / totals[0][0])
        } else {
            (plain, [[0.0; 2]; 2], 1.0)
        };
        let value = |row: &Stencil| {
            row.iter().fold(Vector::zeros(), |sum, (i, c)| sum + net.point(i, column).coords * c)
        };
        let jets = rows.each_ref().map(|rows| rows.each_ref().map(value));
        let (mut size, mut reach) = (0.0_f64, 0.0_f64);
        for (rows, jet) in rows.iter().zip(&jets) {
            for &i in rows[0].vertices() {
                let p = net.point(i, column).coords;
                size = size.max((p - jet[0]).norm());
                reach = reach.max(p.amax());
            }
        }
        let noise = ULPS * f64::EPSILON * reach;
        Self { rows, jets, weights, factor, size, noise, lengths: joint.lengths(space) }
    }

    /// Whether both sides have a position in common.
    fn meets(&self) -> bool {
        (self.jets[1][0] - self.jets[0][0]).norm() <= MEETS * self.size + self.noise
    }

    /// Whether a side's first derivative has a direction.
    fn moves(&self, side: usize) -> bool {
        let way = self.jets[side][1].norm() * self.lengths[side];
        way.is_finite() && way > (VANISHES * self.size).max(self.noise)
    }

    /// How well the `k`-th derivative of a side is known.
    fn doubt(&self, side: usize, k: i32) -> f64 {
        let p = self.rows[side][0].vertices().len() as f64;
        self.noise * (p / self.lengths[side]).powi(k)
    }
}

/// What both sides of a joint have in common, for all columns that have influence on one span of the other direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Relation {
    /// Their position.
    pub(super) meets: bool,
    /// `C'₊ = r C'₋`.
    pub(super) ratio: Option<f64>,
    /// `C''₊ = r² C''₋ + s C'₋`.
    pub(super) bend: Option<f64>,
}

impl Relation {
    /// The relation that all these columns share. `None` where the sides do not even meet.
    ///
    /// Column by column, because that is what makes `S_u₊ = r S_u₋` linear and true along the whole line. Where there are
    /// weights, `Q₊ = σ(u) Q₋(φ(u))` in homogeneous coordinates with the same `σ` and `φ` for all columns up to the
    /// derivative that is kept: else the line is not smooth between the places where the columns are felt most, and the
    /// relation does not exist.
    pub(super) fn common(joint: &Joint, columns: &[&Column], level: u8) -> Self {
        // Ends of nothing (a pole is a column without size) meet where others do that have some.
        let meets = || columns.iter().all(|c| c.meets()) && columns.iter().any(|c| c.size > c.noise);
        let mut relation = Self { meets: !joint.torn || meets(), ..Self::default() };
        let along = |c: &&&Column| c.jets[0][1].norm().max(c.jets[1][1].norm());
        let Some(&widest) = columns.iter().max_by(|a, b| along(a).total_cmp(&along(b))) else {
            return relation;
        };
        let one = |of: &dyn Fn(&Column) -> f64, scale: f64| {
            columns.iter().all(|c| (of(c) - of(widest)).abs() <= ALIKE * scale)
        };
        let alike = relation.meets && one(&|c| c.factor, widest.factor.abs());
        if !(alike && widest.moves(0) && widest.moves(1)) {
            return relation;
        }
        let [left, right] = [0, 1].map(|side: usize| widest.jets[side][1].norm());
        let r = if joint.sharp { right / left } else { 1.0 };
        let fits = |c: &&Column| {
            let miss = (c.jets[1][1] - c.jets[0][1] * r).norm();
            let own = c.jets[1][1].norm().max(r * c.jets[0][1].norm());
            miss <= SMOOTH * own + VANISHES * right + c.doubt(1, 1) + r * c.doubt(0, 1)
        };
        let turn = |c: &Column| c.weights[1][0] - r * c.weights[0][0];
        let size = |k: usize| {
            let each =
                columns.iter().map(|c| c.weights[1][k].abs() + r.powi(k as i32 + 1) * c.weights[0][k].abs());
            each.fold(0.0, f64::max) + (columns[0].lengths[1]).powi(-1 - k as i32)
        };
        // In a curve the one column has the factor of its own weights; it has no others to agree with.
        if !(r.is_finite() && r > 0.0 && columns.iter().all(fits) && one(&turn, size(0))) {
            return relation;
        }
        relation.ratio = Some(r);
        if level < 2 {
            return relation;
        }
        let rest = |c: &Column| c.jets[1][2] - c.jets[0][2] * (r * r);
        let s = rest(widest).dot(&widest.jets[0][1]) / (left * left);
        let bends = |c: &&Column| {
            let miss = (rest(c) - c.jets[0][1] * s).norm();
            let own = c.jets[1][2].norm() + r * r * c.jets[0][2].norm() + s.abs() * c.jets[0][1].norm();
            miss <= SMOOTH * own + c.doubt(1, 2) + r * r * c.doubt(0, 2)
        };
        let twice = |c: &Column| {
            c.weights[1][1] - r * r * c.weights[0][1] - (s + 2.0 * turn(widest) * r) * c.weights[0][0]
        };
        let scale = size(1) + (s.abs() + 2.0 * r * turn(widest).abs()) * size(0) / r;
        if s.is_finite() && columns.iter().all(bends) && one(&twice, scale) {
            relation.bend = Some(s);
        }
        relation
    }

    /// Up to which derivative both sides agree; `None` where they do not meet.
    pub(super) fn order(&self) -> Option<usize> {
        match (self.ratio, self.bend) {
            _ if !self.meets => None,
            (Some(_), Some(_)) => Some(2),
            (Some(_), None) => Some(1),
            _ => Some(0),
        }
    }

    /// The rows over a column's vertices that keep it: each a length (its largest coefficient is 1), zero at the start but
    /// for rounding.
    pub(super) fn rows(&self, joint: &Joint, column: &Column) -> SmallVec<[Stencil; 3]> {
        let [left, right] = &column.rows;
        let mut rows: SmallVec<[Stencil; 3]> = SmallVec::new();
        if joint.torn && self.meets {
            rows.push(sum(&[(&right[0], 1.0), (&left[0], -1.0)]));
        }
        if let Some(r) = self.ratio.filter(|_| joint.sharp) {
            rows.push(sum(&[(&right[1], 1.0), (&left[1], -r)]));
        }
        if let (Some(r), Some(s)) = (self.ratio, self.bend) {
            rows.push(sum(&[(&right[2], 1.0), (&left[2], -r * r), (&left[1], -s)]));
        }
        rows.retain(|row| !row.vertices().is_empty());
        rows
    }
}

/// A sum of rows, its largest coefficient made 1, without those that are rounding.
fn sum(terms: &[(&Stencil, f64)]) -> Stencil {
    let all: Stencil =
        terms.iter().flat_map(|(row, factor)| row.iter().map(move |(i, c)| (i, c * factor))).collect();
    let largest = all.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return Stencil::new();
    }
    all.iter().map(|(i, c)| (i, c / largest)).filter(|(_, c)| c.abs() > 8.0 * f64::EPSILON).collect()
}

/// The vertices of a column that the derivatives up to `order` are made of, on either side.
pub(super) fn reach(net: &Columns<'_>, joint: &Joint, order: usize) -> SmallVec<[usize; 16]> {
    let mut all: SmallVec<[usize; 16]> = SmallVec::new();
    for (span, u) in [joint.left, joint.right] {
        for k in 0..=order {
            let row = row_in(net.across, span, u, k, None::<fn(usize) -> f64>);
            all.extend(row.iter().filter(|(_, c)| *c != 0.0).map(|(i, _)| i));
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// Whether a column starts where it ends. Of every open curve that is edited this is asked, so cheaply: of a clamped one
/// without evaluating anything.
pub(super) fn ends_meet(net: &Columns<'_>, column: usize) -> bool {
    let space = net.across;
    let (p, last) = (space.degree(), space.unrolled_len() - 1);
    let (ends, spans) = if space.is_clamped() {
        ([net.point(last, column).coords, net.point(0, column).coords], [last, p])
    } else {
        let joint = Joint::closing(space);
        let end = |(span, u): (usize, f64)| {
            let weight = |i: usize| net.weight(i, column);
            let row = row_in(space, span, u, 0, net.is_rational().then_some(weight));
            row.iter().fold(Vector::zeros(), |sum, (i, c)| sum + net.point(i, column).coords * c)
        };
        ([end(joint.left), end(joint.right)], [joint.left.0, joint.right.0])
    };
    let mut size = 0.0_f64;
    for (span, end) in spans.into_iter().zip(&ends) {
        for i in span - p..span + 1 {
            size = size.max((net.point(i, column).coords - end).norm_squared());
        }
    }
    let size = size.sqrt();
    let apart = (ends[1] - ends[0]).norm();
    // Mostly they are far apart, and where the origin is does not matter: no coordinate is farther from it than an end's, and
    // the way from there.
    let most = ends[0].amax().max(ends[1].amax()) + size;
    if apart > 2.0 * (MEETS * size + ULPS * f64::EPSILON * most) {
        return false;
    }
    let around = spans.into_iter().flat_map(|span| span - p..span + 1);
    let reach = around.map(|i| net.point(i, column).coords.amax()).fold(0.0, f64::max);
    apart <= MEETS * size + ULPS * f64::EPSILON * reach
}
