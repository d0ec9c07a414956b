//! Parameter curves at the pace of the curves that stand for their edges in space.

use super::pace::Pace;
use crate::brep::Edge;
use crate::error::Result;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Direction, Space, Surface};

/// Places in each span of an edge and of its parameter curve at which their pace is compared.
const EACH: usize = 5;
/// How far they may be apart, as a part of the edge's size, where its tolerance says less.
const NEAR: f64 = 1e-7;
/// So much further off than the surface's nearest point a place may be.
const AS_GOOD: f64 = 1.01;
/// How far beyond the domain of a surface a parameter may be by rounding, as a part of it.
const SLACK: f64 = 1e-12;
/// Domains that differ by a smaller part of them are the same.
const SAME: f64 = 1e-12;

/// A parameter curve at another pace: over `pace`, from the edge's start to its end. `None` where it is not the edge at that pace.
///
/// # Errors
/// When an evaluation overflows.
pub fn at_pace(
    parameters: &ParameterCurve,
    edge: &Edge,
    surface: &Surface,
    pace: Pace,
) -> Result<Option<Curve>> {
    let (start, end) = parameters.range();
    let whole = (start, end) == parameters.curve().domain();
    let part =
        if whole { parameters.curve().to_clamped()? } else { parameters.curve().between(start, end)? };
    let into = |t: f64, direction: Direction| {
        let ((a, b), space) = (surface.space(direction).domain(), surface.space(direction));
        let slack = SLACK * space.length();
        (t >= a - slack && t <= b + slack).then(|| t.clamp(a, b))
    };
    let (low, high) = part.bounds();
    for (k, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
        if into(low[k], direction).is_none() || into(high[k], direction).is_none() {
            return Ok(None);
        }
    }
    let part = if pace.along() { part } else { part.reverse()? };
    let (from, to) = (pace.from.min(pace.to), pace.from.max(pace.to));
    let (a, b) = part.domain();
    // Angles are computed: what is the same but for rounding stays.
    let same = (a - from).abs().max((b - to).abs()) <= SAME * (to - from);
    let fitting = if same { part } else { part.reparametrise(from, to)? };
    let own = edge.curve.between(edge.range.0, edge.range.1)?;
    let points = own.points();
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let near = edge.tolerance.max(NEAR * size);
    let share = |space: &Space| -> Vec<f64> {
        let (a, b) = space.domain();
        space.breakpoints().into_iter().map(|t| (t - a) / (b - a)).collect()
    };
    // Shares of the edge, which a curve against it runs through from the end.
    let mut shares = share(fitting.space());
    if !pace.along() {
        shares.iter_mut().for_each(|share| *share = 1.0 - *share);
    }
    if pace.is_even() {
        shares.extend(share(own.space()));
    }
    shares.sort_by(f64::total_cmp);
    let (first, last) = fitting.domain();
    for pair in shares.windows(2) {
        for k in 0..=EACH {
            let share = pair[0] + (pair[1] - pair[0]) * (k as f64 / EACH as f64);
            let along = if pace.along() { share } else { 1.0 - share };
            let at = fitting.point((first + (last - first) * along).clamp(first, last))?;
            let point = pace.point(&own, share)?;
            let (Some(u), Some(v)) = (into(at.x, Direction::U), into(at.y, Direction::V)) else {
                return Ok(None);
            };
            let apart = nalgebra::distance(&surface.point(u, v)?, &point);
            // An edge that is off its surface is nowhere nearer: then the nearest place is as good as can be.
            if apart > near && apart > AS_GOOD * surface.foot(point, (u, v))?.distance {
                return Ok(None);
            }
        }
    }
    Ok(Some(fitting))
}
