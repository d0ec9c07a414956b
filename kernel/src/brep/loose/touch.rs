//! Which control vertices of a surface have a part in what happens along a curve in its parameter plane.

use std::collections::BTreeSet;

use crate::Point;
use crate::error::{MAX_DEGREE, Result};
use crate::shape::Side;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Product, Space};

/// Pieces of a curve are halved until they lie in one cell, or are this part of a cell's sides.
const FINEST: f64 = 1.0 / 64.0;
/// And not oftener than this.
const DEPTH: usize = 24;
/// Values of functions below this part of the largest are rounding: of a parameter beside the end of the domain, or a knot.
const ROUNDING: f64 = 1e-14;

/// The control vertices (numbers of the whole shape) on which the derivatives up to an `order` across a curve depend, or a few more where
/// the curve passes close by their functions' supports: everything that all others move stays there as it is.
pub(super) fn along(product: &Product<'_>, curve: &ParameterCurve, order: usize) -> Result<BTreeSet<usize>> {
    let mut touched = BTreeSet::new();
    let (from, to) = curve.range();
    let (start, end) = curve.curve().domain();
    let part =
        if (from, to) == (start, end) { curve.curve().clone() } else { curve.curve().between(from, to)? };
    // Halving leaves rounding in a coordinate that is constant, and nothing that is wide, however little, is a line.
    let constant = [0, 1].map(|k| {
        let first = part.points().first()?[k];
        part.points().iter().all(|p| p[k] == first).then_some(first)
    });
    let bounds = |k: usize, low: f64, high: f64| constant[k].map_or((low, high), |at| (at, at));
    let mut open: Vec<(Curve, usize)> =
        part.bezier_segments()?.into_iter().map(|segment| (segment, 0)).collect();
    while let Some((segment, depth)) = open.pop() {
        let (low, high) = segment.hull_bounds();
        let (u, v) = (bounds(0, low.x, high.x), bounds(1, low.y, high.y));
        let sides = [(product.u, u.0, u.1), (product.v, v.0, v.1)];
        let coarse = sides.iter().any(|(space, low, high)| is_coarse(space, *low, *high));
        let (a, b) = segment.domain();
        let middle = 0.5 * (a + b);
        if coarse && depth < DEPTH && a < middle && middle < b {
            open.extend(segment.split(middle)?.into_iter().map(|half| (half, depth + 1)));
            continue;
        }
        let [rows, columns] = sides.map(|(space, low, high)| active(space, low, high, order));
        touched.extend(
            rows.iter()
                .flat_map(|i| columns.iter().map(move |j| (i, j)))
                .map(|(i, j)| product.first + i * product.v.len() + j),
        );
    }
    Ok(touched)
}

/// The same at one place.
pub(super) fn at(product: &Product<'_>, at: Point, order: usize) -> BTreeSet<usize> {
    let rows = active(product.u, at.x, at.x, order);
    let columns = active(product.v, at.y, at.y, order);
    let vertex = |(i, j)| product.first + i * product.v.len() + j;
    rows.iter().flat_map(|i| columns.iter().map(move |j| (*i, *j))).map(vertex).collect()
}

/// Whether an interval is in more than one span of a space, and not short beside the spans that it is in.
fn is_coarse(space: &Space, low: f64, high: f64) -> bool {
    if low == high {
        return false;
    }
    let (first, last) = spans(space, low, high);
    let flat = space.flat();
    let shortest =
        (first..=last).map(|s| flat[s + 1] - flat[s]).filter(|h| *h > 0.0).fold(f64::INFINITY, f64::min);
    first < last && high - low > FINEST * shortest
}

/// The spans that the inside of an interval meets; parameters beyond the domain count as its ends, or go round where it is closed.
fn spans(space: &Space, low: f64, high: f64) -> (usize, usize) {
    let (a, b) = space.domain();
    if space.is_periodic() {
        let turn = ((low - a) / (b - a)).floor() * (b - a);
        let (low, high) = (low - turn, high - turn);
        if high > b {
            // Across the seam: all of it is as good as what would have to be put together.
            return (space.degree(), space.unrolled_len() - 1);
        }
        return (space.span(low.clamp(a, b)), before(space, high.clamp(a, b)));
    }
    let (low, high) = (low.clamp(a, b), high.clamp(a, b));
    let (first, last) = (space.span(low), before(space, high));
    (first.min(last), first.max(last))
}

/// The non-empty span that ends at a parameter or has it inside.
fn before(space: &Space, u: f64) -> usize {
    space.span_on(u, Side::Left).0
}

/// The vertices of a space whose functions, or their derivatives up to an order, are not zero on an interval.
fn active(space: &Space, low: f64, high: f64, order: usize) -> BTreeSet<usize> {
    let p = space.degree();
    if low < high {
        let (first, last) = spans(space, low, high);
        return (first - p..=last).map(|k| space.vertex(k)).collect();
    }
    let (a, b) = space.domain();
    let Ok(u) = space.locate(if space.is_periodic() { low } else { low.clamp(a, b) }) else {
        return BTreeSet::new();
    };
    let mut all = BTreeSet::new();
    for side in [Side::Left, Side::Right] {
        let (span, u) = space.span_on(u, side);
        for k in 0..=order.min(p) {
            let mut row = [0.0; MAX_DEGREE + 1];
            space.basis_into(span, u, k, &mut row);
            let largest = row[..=p].iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            let some = |i: &usize| row[*i].abs() > ROUNDING * largest;
            all.extend((0..=p).filter(some).map(|i| space.vertex(span - p + i)));
        }
    }
    all
}
