//! The smallest values of α in each of its spans, found in their Bernstein form: none is between two looks.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use loftsman_kernel::shape::Side;
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::error::Result;
use crate::lift::{Alpha, Place};

/// So often a span is halved at most, where α turns more than once in it.
const HALVINGS: usize = 24;
/// So many parts a patch is cut into at most.
const CELLS: usize = 800;
/// The part of α's size, or of what it is to be below, to which a smallest value of a net is found.
const CLOSE: f64 = 1e-7;

/// In each span each smallest value of α that is below `below`: where α turns, and where a span starts or ends. Of a net the smallest of each patch.
/// `O(n p²)` and some twenty halvings, each `O(p²)`, for spans in which it turns more than once.
///
/// # Errors
/// When numbers overflow.
pub(crate) fn lowest(alpha: &Alpha, below: f64) -> Result<Vec<(f64, Place)>> {
    match alpha {
        Alpha::Line(line) => {
            let place = |(value, at, side)| (value, ((at, 0.0), [side, Side::Right]));
            Ok(of_line(line, below)?.into_iter().map(place).collect())
        }
        Alpha::Net(net) => of_net(net, below),
    }
}

/// A smallest value, where it is, and from which side.
type Low = (f64, f64, Side);

fn of_line(line: &Function<f64>, below: f64) -> Result<Vec<Low>> {
    let space = line.space();
    let mut all: Vec<Low> = Vec::new();
    if space.degree() == 0 {
        for start in steps(space) {
            let value = line.value(start)?;
            all.extend((value < below).then_some((value, start, Side::Right)));
        }
        return Ok(all);
    }
    let (p, (_, end)) = (space.degree(), space.domain());
    let form = line.convert(&space.to_bezier()?)?;
    let mut dips = Vec::new();
    for span in form.space().spans() {
        let (from, to) = (form.space().flat()[span], form.space().flat()[span + 1]);
        dips.clear();
        let whole = Piece { values: form.coefficients()[span - p..=span].to_vec(), from: 0.0, to: 1.0 };
        whole.dips(below, HALVINGS, &mut dips);
        for (value, t) in &dips {
            let last = *t >= 1.0;
            let at = if last { to } else { from + (to - from) * t };
            // Where α is continuous it has one value at a knot, which is that of what follows.
            let side =
                if last && (to == end || space.multiplicity(to) > p) { Side::Left } else { Side::Right };
            if !all.iter().rev().take(2).any(|low| low.1 == at && low.2 == side) {
                all.push((*value, at, side));
            }
        }
    }
    Ok(all)
}

/// Where the spans of a space of degree 0 start.
fn steps(space: &Space) -> Vec<f64> {
    let mut breaks = space.breakpoints();
    breaks.pop();
    breaks
}

/// Bernstein coefficients on a part of a span.
struct Piece {
    values: Vec<f64>,
    from: f64,
    to: f64,
}

impl Piece {
    /// Its smallest values, with where in the span they are.
    fn dips(&self, below: f64, left: usize, found: &mut Vec<(f64, f64)>) {
        let Self { values, from, to } = self;
        // Where no coefficient is below, the function is not.
        if !values.iter().any(|value| *value < below) {
            return;
        }
        let size = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let rounding = 8.0 * f64::EPSILON * size;
        let mut turns: Vec<bool> = Vec::new();
        for pair in values.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| d.abs() > rounding) {
            if turns.last() != Some(&(pair > 0.0)) {
                turns.push(pair > 0.0);
            }
        }
        let mut put = |value: f64, at: f64| {
            if value < below {
                found.push((value, at));
            }
        };
        let [first, last] = [values[0], values[values.len() - 1]];
        // As often as its coefficients a function turns at most.
        match turns.as_slice() {
            [false, true] => {
                let at = root(values);
                put(value(values, at), from + (to - from) * at);
            }
            [] => put(first, 0.5 * (from + to)),
            _ if turns.len() < 3 => {
                let (rises, falls) = (turns[0], !turns[turns.len() - 1]);
                if rises && *from == 0.0 {
                    put(first, 0.0);
                }
                if falls && *to == 1.0 {
                    put(last, 1.0);
                }
            }
            _ if left == 0 => put(first.min(last), if first < last { *from } else { *to }),
            _ => {
                let [left_half, right_half] = halves(values);
                let middle = 0.5 * (from + to);
                let slope = right_half[1] - right_half[0];
                let turn = right_half[0];
                Self { values: left_half, from: *from, to: middle }.dips(below, left - 1, found);
                if slope.abs() <= rounding && turn < below {
                    found.push((turn, middle));
                }
                Self { values: right_half, from: middle, to: *to }.dips(below, left - 1, found);
            }
        }
    }
}

/// Where a function stops falling and begins to rise, of its Bernstein coefficients that do so.
fn root(values: &[f64]) -> f64 {
    let slopes: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if let [a, b] = slopes[..] {
        return a / (a - b);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if value(&slopes, middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The value of a polynomial in Bernstein form: convex combinations.
fn value(values: &[f64], t: f64) -> f64 {
    let mut row = values.to_vec();
    for last in (1..row.len()).rev() {
        for k in 0..last {
            row[k] += (row[k + 1] - row[k]) * t;
        }
    }
    row[0]
}

/// Both halves of a polynomial in Bernstein form.
fn halves(values: &[f64]) -> [Vec<f64>; 2] {
    let (mut row, mut left) = (values.to_vec(), Vec::with_capacity(values.len()));
    let mut right = vec![0.0; values.len()];
    for last in (0..row.len()).rev() {
        left.push(row[0]);
        right[last] = row[last];
        for k in 0..last {
            row[k] = 0.5 * (row[k] + row[k + 1]);
        }
    }
    [left, right]
}

fn of_net(net: &Field<f64>, below: f64) -> Result<Vec<(f64, Place)>> {
    let (u, v) = (net.space(Direction::U), net.space(Direction::V));
    let values = net.coefficients();
    if u.degree() == 0 || v.degree() == 0 {
        // Each row, or each column, is a function of its own.
        let rows = u.degree() == 0;
        let (along, over) = if rows { (v, u) } else { (u, v) };
        let mut all = Vec::new();
        for (k, start) in steps(over).into_iter().enumerate() {
            let own = |i: usize| if rows { values[k * v.len() + i] } else { values[i * v.len() + k] };
            let line = Function::new(along.clone(), (0..along.len()).map(own).collect())?;
            let place = |(value, at, side)| match rows {
                true => (value, ((start, at), [Side::Right, side])),
                false => (value, ((at, start), [side, Side::Right])),
            };
            all.extend(of_line(&line, below)?.into_iter().map(place));
        }
        return Ok(all);
    }
    let points = values.iter().map(|c| Point::from(Vector::x() * *c)).collect();
    let form = Surface::new(u.clone(), v.clone(), points)?.bezier_form()?;
    let (p, q, columns) = (u.degree(), v.degree(), form.v().len());
    let mut all = Vec::new();
    for i in form.u().spans() {
        for j in form.v().spans() {
            let vertices = (i - p..=i).flat_map(|r| (j - q..=j).map(move |c| r * columns + c));
            let patch: Vec<f64> = vertices.map(|k| form.points()[k].x).collect();
            let Some((value, [s, t])) = least(patch, q + 1, below) else { continue };
            let at = |space: &Space, span: usize, s: f64| {
                let (from, to) = (space.flat()[span], space.flat()[span + 1]);
                if s >= 1.0 { (to, Side::Left) } else { (from + (to - from) * s, Side::Right) }
            };
            let ((a, first), (b, second)) = (at(form.u(), i, s), at(form.v(), j, t));
            all.push((value, ((a, b), [first, second])));
        }
    }
    Ok(all)
}

/// A part of a patch: the least of its coefficients, and where it is.
struct Cell {
    bound: f64,
    net: Vec<f64>,
    corner: [f64; 2],
    size: [f64; 2],
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    /// The one with the least bound is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

/// The least value of a patch, and where, if it is below.
fn least(net: Vec<f64>, columns: usize, below: f64) -> Option<(f64, [f64; 2])> {
    let size = net.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let close = CLOSE * if below.is_finite() { below.abs() } else { size };
    let mut known = (f64::INFINITY, [0.0; 2]);
    let mut heap = BinaryHeap::new();
    let mut add = |heap: &mut BinaryHeap<Cell>, net: Vec<f64>, corner: [f64; 2], size: [f64; 2]| {
        let last = net.len() - 1;
        for (k, [s, t]) in
            [(0, [0.0, 0.0]), (columns - 1, [0.0, 1.0]), (last + 1 - columns, [1.0, 0.0]), (last, [1.0; 2])]
        {
            if net[k] < known.0 {
                known = (net[k], [corner[0] + size[0] * s, corner[1] + size[1] * t]);
            }
        }
        let bound = net.iter().fold(f64::INFINITY, |m, v| m.min(*v));
        heap.push(Cell { bound, net, corner, size });
        known
    };
    let mut best = add(&mut heap, net, [0.0; 2], [1.0; 2]);
    for _ in 0..CELLS {
        let Some(cell) = heap.pop() else { break };
        if cell.bound >= below.min(best.0 - close) {
            break;
        }
        let Cell { net, corner, size, .. } = cell;
        let rows = net.len() / columns;
        let bend = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
        let across = net.chunks(columns).flat_map(|row| row.windows(3).map(|w| bend(w[0], w[1], w[2])));
        let across = across.fold(0.0, f64::max);
        let along = (columns..net.len().saturating_sub(columns).max(columns))
            .map(|k| bend(net[k - columns], net[k], net[k + columns]));
        let along = along.fold(0.0, f64::max);
        // Of two straight directions the longer one.
        let by_rows = if along == across { size[0] >= size[1] } else { along > across };
        let (mut first, mut second) = (Vec::with_capacity(net.len()), Vec::with_capacity(net.len()));
        let (mut far, mut half) = (corner, size);
        if by_rows {
            first.resize(net.len(), 0.0);
            second.resize(net.len(), 0.0);
            for column in 0..columns {
                let line: Vec<f64> = (0..rows).map(|row| net[row * columns + column]).collect();
                let [low, high] = halves(&line);
                for row in 0..rows {
                    (first[row * columns + column], second[row * columns + column]) = (low[row], high[row]);
                }
            }
            half[0] *= 0.5;
            far[0] += half[0];
        } else {
            for row in net.chunks(columns) {
                let [low, high] = halves(row);
                first.extend(low);
                second.extend(high);
            }
            half[1] *= 0.5;
            far[1] += half[1];
        }
        add(&mut heap, first, corner, half);
        best = add(&mut heap, second, far, half);
    }
    (best.0 < below).then_some(best)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn any(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Clamped, floating or periodic, with knots repeated, now and then to a jump.
    fn any_space(degree: usize, kind: usize, seed: &mut u64) -> Space {
        let mut knots: Vec<f64> = Vec::new();
        let mut at = 0.0;
        for _ in 0..4 {
            at += 0.01 + any(seed).powi(3);
            let times = 1 + (any(seed) * 1.5 * (degree + 1) as f64) as usize;
            knots.extend(std::iter::repeat_n(
                at,
                times.min(if kind == 2 { degree.max(1) } else { degree + 1 }),
            ));
        }
        let end = at + 0.5;
        let around = |step: f64| (0..=degree).map(move |k| k as f64 * step);
        match kind {
            2 => {
                knots.insert(0, 0.0);
                while knots.len() < degree + 3 {
                    knots.push(knots[knots.len() - 1] + 0.3);
                }
                knots.push(knots[knots.len() - 1] + 0.4);
                Space::periodic(degree, knots).unwrap()
            }
            kind => {
                let step = if kind == 0 { 0.0 } else { 0.3 };
                let before = around(step).map(|x| -x).collect::<Vec<_>>();
                let all = before.into_iter().rev().chain(knots).chain(around(step).map(|x| end + x));
                Space::open(degree, all.collect()).unwrap()
            }
        }
    }

    /// No value between the looks of five hundred a span is below what was found there, and what was found is α's own value.
    #[test]
    fn nothing_is_below_what_is_found() {
        let mut seed = 5;
        let (mut dips, mut spans) = (0, 0);
        for degree in [0, 1, 2, 3, 4, 5, 6, 7, 13] {
            for kind in 0..3 {
                for size in [1.0, 1e-9, 1e9] {
                    if degree == 0 && kind == 2 {
                        continue;
                    }
                    let space = any_space(degree, kind, &mut seed);
                    let values = (0..space.len()).map(|_| size * (any(&mut seed) - 0.3)).collect();
                    let line = Function::new(space.clone(), values).unwrap();
                    let alpha = Alpha::Line(line.clone());
                    let found = lowest(&alpha, 0.1 * size).unwrap();
                    dips += found.len();
                    for (value, place) in &found {
                        let own = alpha.at(place).unwrap();
                        assert!(
                            (own - value).abs() < 1e-12 * size,
                            "{degree} {kind} {place:?}: {own} {value}"
                        );
                    }
                    for pair in space.breakpoints().windows(2) {
                        spans += 1;
                        let inside = |at: f64| pair[0] <= at && at <= pair[1];
                        let here = found.iter().filter(|(_, ((at, _), _))| inside(*at));
                        let least = here.map(|(value, _)| *value).fold(0.1 * size, f64::min);
                        for k in 1..500 {
                            let at = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 500.0;
                            let value = line.value(at).unwrap();
                            assert!(value > least - 1e-12 * size, "{degree} {kind} {at}: {value}, {least}");
                        }
                    }
                }
            }
        }
        assert!(dips > 100 && spans > 300, "{dips} {spans}");
    }

    /// The same of nets, in every patch: to the part of what they are to be below to which it is looked for.
    #[test]
    fn no_patch_has_less_than_is_found() {
        let mut seed = 11;
        let mut dips = 0;
        for (p, q) in [(1, 1), (2, 3), (3, 2), (4, 1), (5, 5), (0, 3), (2, 0), (0, 0)] {
            for kinds in [[0, 0], [1, 0], [0, 2], [2, 2]] {
                if p == 0 && kinds[0] == 2 || q == 0 && kinds[1] == 2 {
                    continue;
                }
                let (u, v) = (any_space(p, kinds[0], &mut seed), any_space(q, kinds[1], &mut seed));
                let values = (0..u.len() * v.len()).map(|_| any(&mut seed) - 0.3).collect();
                let net = Field::new(u.clone(), v.clone(), values).unwrap();
                let alpha = Alpha::Net(net.clone());
                let found = lowest(&alpha, 0.1).unwrap();
                dips += found.len();
                for (value, place) in &found {
                    let own = alpha.at(place).unwrap();
                    assert!((own - value).abs() < 1e-12, "{p} {q} {place:?}: {own} {value}");
                }
                for a in u.breakpoints().windows(2) {
                    for b in v.breakpoints().windows(2) {
                        let inside = |(s, t): (f64, f64)| a[0] <= s && s <= a[1] && b[0] <= t && t <= b[1];
                        let here = found.iter().filter(|(_, (at, _))| inside(*at));
                        let least = here.map(|(value, _)| *value).fold(0.1, f64::min);
                        for k in 0..400 {
                            let (i, j) = (f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5);
                            let at = (a[0] + (a[1] - a[0]) * i / 20.0, b[0] + (b[1] - b[0]) * j / 20.0);
                            let value = net.value(at.0, at.1).unwrap();
                            assert!(value > least - 1e-8, "{p} {q} {at:?}: {value}, {least}");
                        }
                    }
                }
            }
        }
        assert!(dips > 300, "{dips}");
    }
}
