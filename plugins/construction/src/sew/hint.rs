//! With which tolerance more would be sewn.

use loftsman_kernel::Point;
use loftsman_kernel::brep::Parts;
use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;

use super::gather::Healed;
use super::join::{join, open, segment};

/// Of so many open edges it is looked how far they are from one another.
const COMPARED: usize = 1000;
/// Chords of an edge by which it is seen which others are near; and places at which it is measured how near.
const CHORDS: usize = 32;
const PLACES: usize = 9;
/// So many tolerances are tried, the least first, and then the one that may close all.
const TRIED: usize = 4;
/// What is told is more than what was measured, by more than rounding.
const ROOM: f64 = 1.0 + 1e-9;
/// A tolerance is no larger than this part of the size of what is open.
const MOST: f64 = 0.1;

/// What is known of larger tolerances.
#[derive(Debug, Default)]
pub(super) struct Hint {
    pub(super) next: Option<f64>,
    pub(super) closes: Option<f64>,
}

/// A number in three digits, none of which makes it less.
pub(super) fn rounded_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return x;
    }
    let digit = 10.0_f64.powf(x.log10().floor() - 2.0);
    let up = (x * ROOM / digit).ceil();
    // By the decimal text: what is told is what was tried.
    format!("{up}e{}", digit.log10().round()).parse().unwrap_or(x)
}

/// Tries larger tolerances on faces as they were `given`, of which `parts` came with some edges open: those by which an open edge is away from all other open ones,
/// along all of it. `O(open²)`, and a sewing for each that is tried.
///
/// # Errors
/// When an evaluation overflows.
pub(super) fn find(given: &Parts, parts: &Parts, edges: &[usize], near: f64) -> Result<Hint> {
    let mut hint = Hint::default();
    if edges.len() < 2 || edges.len() > COMPARED {
        return Ok(hint);
    }
    let curves = edges.iter().map(|&edge| segment(&parts.edges[edge])).collect::<Result<Vec<_>>>()?;
    let mut away = distances(&curves)?;
    let ends = curves.iter().map(Curve::hull_bounds);
    let Some((low, high)) = ends.reduce(|(a, b), (c, d)| (a.inf(&c), b.sup(&d))) else { return Ok(hint) };
    let most = MOST * (high - low).amax();
    away.sort_by(f64::total_cmp);
    let furthest = away.last().copied().unwrap_or(f64::INFINITY);
    away.retain(|distance| *distance > near && rounded_up(*distance) < most);
    away.dedup_by(|b, a| *b <= *a * (1.0 + 1e-6));
    for distance in away.into_iter().take(TRIED) {
        let left = left_open(given, rounded_up(distance))?;
        if left < edges.len() {
            hint.next = Some(distance);
            hint.closes = (left == 0).then_some(distance);
            break;
        }
    }
    if hint.next.is_some() && hint.closes.is_none() && rounded_up(furthest) < most && furthest > near {
        hint.closes = (left_open(given, rounded_up(furthest))? == 0).then_some(furthest);
    }
    Ok(hint)
}

/// How many edges are open with a tolerance.
fn left_open(given: &Parts, near: f64) -> Result<usize> {
    let mut parts = given.clone();
    join(&mut parts, near, &mut Healed::default())?;
    // Where nothing is left all is gone, not closed.
    Ok(if parts.faces.is_empty() { usize::MAX } else { open(&parts).len() })
}

/// How far each curve is from the others, at its furthest place.
fn distances(curves: &[Curve]) -> Result<Vec<f64>> {
    let mut lines = Vec::with_capacity(curves.len());
    for curve in curves {
        let (from, to) = curve.domain();
        let at = |k: usize| curve.point(from + (to - from) * (k as f64 / CHORDS as f64));
        lines.push((0..=CHORDS).map(at).collect::<Result<Vec<Point>>>()?);
    }
    let boxes: Vec<(Point, Point)> = curves.iter().map(Curve::hull_bounds).collect();
    let mut all = Vec::with_capacity(curves.len());
    for (k, curve) in curves.iter().enumerate() {
        let (from, to) = curve.domain();
        let mut worst = 0.0_f64;
        for place in 0..PLACES {
            let point = curve.point(from + (to - from) * (place as f64 / (PLACES - 1) as f64))?;
            let (mut best, mut nearest) = (f64::INFINITY, None);
            for (other, line) in lines.iter().enumerate().filter(|(other, _)| *other != k) {
                let (low, high) = boxes[other];
                let outside = (low - point).sup(&(point - high)).sup(&nalgebra::zero());
                if outside.norm() >= best {
                    continue;
                }
                let own = line.windows(2).map(|pair| to_chord(&point, pair)).fold(f64::INFINITY, f64::min);
                if own < best {
                    (best, nearest) = (own, Some(other));
                }
            }
            let Some(nearest) = nearest else { continue };
            worst = worst.max(curves[nearest].closest(point)?.distance);
        }
        all.push(worst);
    }
    Ok(all)
}

/// How far a point is from a chord.
fn to_chord(point: &Point, pair: &[Point]) -> f64 {
    let [a, b] = pair else { return f64::INFINITY };
    let (way, to) = (b - a, point - a);
    let squared = way.norm_squared();
    let share = if squared > 0.0 { (to.dot(&way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (to - way * share).norm()
}
