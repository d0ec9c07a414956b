//! Where a closed curve begins so that it is as near to its mirror image, run backwards from there, as can be.
//!
//! Run backwards and mirrored, with `M` the mirror, `C` becomes `M C(s - t)`; begun at `s / 2` both begin together. What is least is
//! `F(s) = Σ |C(t) - M C(s - t)|²` over places `t` of even parameters: found on a grid of `s`, where all these are places of one grid, and then by the
//! sign of `F'(s) = -2 Σ (C(t) - M C(s - t))·M C'(s - t)`.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::{Curve, Direction, Surface};
use loftsman_kernel::{Point, Vector};

use super::{IN_PLANE, Mirror, crossings, long};

/// Places on the curve, at least and at most; four of each span between.
const PLACES: [usize; 2] = [256, 1024];
/// What is nearer to a start that knots suggest than this part of the domain is that start.
const SNAP: f64 = 1e-9;
/// Halvings of a step of the grid.
const HALVINGS: usize = 60;

/// The parameter at which it is best begun.
pub(super) fn best(curve: &Curve, mirror: &Mirror) -> Result<f64> {
    let (a, b) = curve.domain();
    let length = b - a;
    let breaks = curve.space().breakpoints();
    let count = (4 * breaks.len()).clamp(PLACES[0], PLACES[1]);
    // At the size 1, at which squares are numbers, seen from the mirror; moved there, which changes no sum over all of the curve, but where it is only over places.
    let size = curve.points().iter().map(|p| (p - mirror.point).amax()).fold(0.0, f64::max);
    let mut shift = Vector::zeros();
    let flip = |v: Vector| v - mirror.normal * (2.0 * v.dot(&mirror.normal));
    let inside = |t: f64| (a + (t - a).rem_euclid(length)).min(b);
    let place = |k: usize| a + length * k as f64 / count as f64;
    let mut points = Vec::with_capacity(count);
    for k in 0..count {
        let seen = (curve.point(place(k))? - mirror.point) / size;
        shift += mirror.normal * (mirror.normal.dot(&seen) / count as f64);
        points.push(seen);
    }
    points.iter_mut().for_each(|p| *p -= shift);
    let scaled = |p: &Point| (p - mirror.point) / size - shift;
    let images: Vec<Vector> = points.iter().map(|v| flip(*v)).collect();
    // `s = 2 a + j length / count`: the image of the place `k` is the place `j - k`.
    let sum = |j: usize| -> f64 {
        (0..count).map(|k| (points[k] - images[(j + count - k) % count]).norm_squared()).sum()
    };
    let sums: Vec<f64> = (0..count).map(sum).collect();
    let most = sums.iter().fold(0.0_f64, |most, x| most.max(*x));
    // The first one of those that are equal to rounding.
    let mut least = 0;
    for (j, x) in sums.iter().enumerate() {
        if *x < sums[least] - 1e-12 * most {
            least = j;
        }
    }
    let slope = |s: f64| -> Result<f64> {
        let mut slope = 0.0;
        let mut there = [Vector::zeros(); 2];
        for (k, point) in points.iter().enumerate() {
            curve.derivatives_into(inside(s - place(k)), &mut there)?;
            let off = point - flip(scaled(&Point::from(there[0])));
            slope -= off.dot(&flip(there[1] * (length / size)));
        }
        Ok(slope)
    };
    let step = length / count as f64;
    let mut sought = 2.0 * a + step * least as f64;
    let (mut low, mut high) = (sought - step, sought + step);
    if slope(low)? < 0.0 && slope(high)? > 0.0 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * low + 0.5 * high;
            if !(low < middle && middle < high) {
                break;
            }
            if slope(middle)? < 0.0 { low = middle } else { high = middle }
        }
        sought = 0.5 * low + 0.5 * high;
    }
    let near = SNAP * length;
    // The knot nearest to a parameter, where that is one.
    let knot = |t: f64| {
        let t = inside(t);
        let after = breaks.partition_point(|k| *k < t);
        let both = [after.checked_sub(1).map(|k| breaks[k]), breaks.get(after).copied()];
        both.into_iter().flatten().find(|k| (k - t).abs() <= near)
    };
    // Knots that mirror one another nearly are to do so.
    let pair = breaks.iter().find_map(|&k| {
        let other = knot(sought - k)?;
        let turns = ((sought - k - other) / length).round();
        Some(k + other + turns * length)
    });
    let sought = pair.unwrap_or(sought);
    // The two places that are their own images: one where a knot is, or the one nearer to where the curve begins.
    let both = [inside(0.5 * sought), inside(0.5 * sought + 0.5 * length)];
    let off_start = |t: f64| (t - a).min(b - t);
    let rank = |t: f64| (off_start(t) > near, knot(t).is_none(), off_start(t));
    let [first, second] = both;
    let first_is_better = rank(first).partial_cmp(&rank(second)).is_none_or(std::cmp::Ordering::is_le);
    let at = if first_is_better { first } else { second };
    Ok(if off_start(at) <= near { a } else { knot(at).unwrap_or(at) })
}

/// A clamped surface that is closed in a direction, begun where the curve in its middle is begun best; any other as it is.
pub(super) fn begun(surface: &Surface, mirror: &Mirror, direction: Direction) -> Result<Surface> {
    let size = surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    let (low, high) = surface.space(direction.other()).domain();
    // At a pole there is nothing to see: the longest of a few.
    let mut line: Option<(f64, Curve)> = None;
    for share in [0.5, 0.25, 0.75] {
        let curve = surface.isocurve(direction.other(), low * (1.0 - share) + high * share)?;
        let reach = curve.points().iter().map(|p| long(&(p - curve.points()[0]))).fold(0.0, f64::max);
        if line.as_ref().is_none_or(|(most, _)| reach > *most) {
            line = Some((reach, curve));
        }
    }
    let Some((_, line)) = line else { return Ok(surface.clone()) };
    let (a, b) = surface.space(direction).domain();
    let [first, last] = [surface.isocurve(direction, a)?, surface.isocurve(direction, b)?];
    let near = 64.0 * f64::EPSILON * size;
    let closed = first.points().iter().zip(last.points()).all(|(p, q)| long(&(p - q)) <= near);
    if !closed || crossings(&line, mirror)?.is_empty() {
        return Ok(surface.clone());
    }
    let at = best(&line, mirror)?;
    // A knot to rounding is the knot.
    let slack = IN_PLANE * (b - a);
    let breaks = surface.space(direction).breakpoints();
    let at = breaks.iter().copied().find(|k| (k - at).abs() <= slack).unwrap_or(at);
    if !(a < at && at < b) {
        return Ok(surface.clone());
    }
    let parts = surface.split(direction, at)?;
    let [before, after] = &parts[..] else { return Ok(surface.clone()) };
    Ok(after.join(direction, before, near)?.shape)
}
