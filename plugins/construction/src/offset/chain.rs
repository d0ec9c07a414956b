//! What is kept, put together: where one element goes over into the next, and where two cross.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;

use super::Job;
use super::element::Element;
use super::keep::Interval;

/// A part of no more than this of the curve's parameters is none.
const SHORTEST: f64 = 1e-14;

/// A piece of the offset: its intervals, and the curve that they became.
pub(super) struct Chain {
    pub(super) curve: Curve,
    /// Whether it goes round.
    pub(super) closed: bool,
    /// Its intervals, each with the parameters of the curve that it has become.
    pub(super) parts: Vec<(Interval, (f64, f64))>,
}

pub(super) fn chains(
    job: &Job<'_>,
    elements: &[Element],
    mut intervals: Vec<Interval>,
    round: u32,
) -> Result<Vec<Chain>> {
    let next = follow(job, elements, &mut intervals)?;
    let mut is_start = vec![true; intervals.len()];
    next.iter().flatten().for_each(|&j| is_start[j] = false);
    let mut used = vec![false; intervals.len()];
    let mut chains = Vec::new();
    // Those with a start first; what is left over goes round.
    let starts =
        (0..intervals.len()).filter(|&i| is_start[i]).chain((0..intervals.len()).filter(|&i| !is_start[i]));
    let mut order: Vec<(usize, Vec<usize>, bool)> = Vec::new();
    for start in starts {
        if used[start] {
            continue;
        }
        let (mut members, mut at, mut closed) = (Vec::new(), Some(start), false);
        while let Some(i) = at {
            if used[i] {
                closed = i == start;
                break;
            }
            used[i] = true;
            members.push(i);
            at = next[i];
        }
        order.push((start, members, closed));
    }
    order.sort_by_key(|(_, members, _)| members.iter().min().copied());
    for (_, members, closed) in order {
        let parts: Vec<Interval> = members.iter().map(|&i| intervals[i]).collect();
        if let Some(chain) = assembled(job, elements, &parts, closed, round)? {
            chains.push(chain);
        }
    }
    Ok(chains)
}

/// For each interval the one that goes on where it ends.
fn follow(job: &Job<'_>, elements: &[Element], intervals: &mut [Interval]) -> Result<Vec<Option<usize>>> {
    let n = intervals.len();
    let point = |i: &Interval, end: bool| {
        elements[i.element].place(job, if end { i.to } else { i.from }).map(|p| p.point)
    };
    let mut next = vec![None; n];
    let mut taken = vec![false; n];
    // From the end of an element into the next one; at the seam, too.
    for i in 0..n {
        let (this, j) = (intervals[i], (i + 1) % n);
        let other = intervals[j];
        let whole =
            this.to == elements[this.element].domain().1 && other.from == elements[other.element].domain().0;
        let beside = (this.element + 1) % elements.len() == other.element && (j > i || job.plane.closed);
        if whole && beside && (point(&this, true)? - point(&other, false)?).norm() <= job.snap() {
            next[i] = Some(j);
            taken[j] = true;
        }
    }
    // Elsewhere ends were found to rounding of the distance, which may leave them apart where elements cross at small angles.
    let reach = (1e-3 * job.distance.abs()).max(job.tolerance);
    let mut pairs = Vec::new();
    for i in (0..n).filter(|&i| next[i].is_none()) {
        let end = point(&intervals[i], true)?;
        for j in (0..n).filter(|&j| !taken[j]) {
            let gap = (end - point(&intervals[j], false)?).norm();
            if gap <= reach {
                pairs.push((gap, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    for (_, i, j) in pairs {
        if next[i].is_some() || taken[j] {
            continue;
        }
        if let Some((to, from)) = crossing(job, elements, &intervals[i], &intervals[j])? {
            intervals[i].to = to;
            intervals[j].from = from;
            next[i] = Some(j);
            taken[j] = true;
        }
    }
    Ok(next)
}

/// Where the end of one interval and the start of another cross, by Newton's method in the plane.
fn crossing(
    job: &Job<'_>,
    elements: &[Element],
    end: &Interval,
    start: &Interval,
) -> Result<Option<(f64, f64)>> {
    let (first, second) = (&elements[end.element], &elements[start.element]);
    let (mut s, mut t) = (end.to, start.from);
    let mut best: Option<(f64, f64, f64)> = None;
    for _ in 0..20 {
        let (p, q) = (first.place(job, s)?, second.place(job, t)?);
        let away = q.point - p.point;
        if best.is_some_and(|(least, ..)| away.norm() >= least) {
            break;
        }
        best = Some((away.norm(), s, t));
        // p + p' ds = q + q' dt.
        let normal = job.plane.normal;
        let area = p.derivative.cross(&q.derivative).dot(&normal);
        let ((a, b), (c, d)) = (first.domain(), second.domain());
        if area.abs() <= 1e-12 * p.derivative.norm() * q.derivative.norm() {
            if p.derivative.dot(&q.derivative) <= 0.0 {
                break;
            }
            // In one line the first goes on to where the second starts, and where it cannot, that starts earlier.
            let further = (s + away.dot(&p.derivative) / p.derivative.norm_squared()).clamp(a, b);
            let rest = away - p.derivative * (further - s);
            s = further;
            t = (t - rest.dot(&q.derivative) / q.derivative.norm_squared()).clamp(c, d);
            continue;
        }
        s = (s + away.cross(&q.derivative).dot(&normal) / area).clamp(a, b);
        t = (t + away.cross(&p.derivative).dot(&normal) / area).clamp(c, d);
    }
    Ok(best.and_then(|(gap, s, t)| (gap <= job.snap() && s > end.from && t < start.to).then_some((s, t))))
}

/// The curve of a chain; none where all of it is within the tolerance of one point.
pub(super) fn assembled(
    job: &Job<'_>,
    elements: &[Element],
    parts: &[Interval],
    closed: bool,
    round: u32,
) -> Result<Option<Chain>> {
    let fit = 0.3 * job.tolerance / 10_f64.powi(round as i32);
    let mut curves = Vec::new();
    let mut placed = Vec::new();
    let mut at = parts.first().map_or(0.0, |p| p.from);
    // What two cuts leave between them by rounding has no parameters of its own.
    let whole = job.curve.space().length();
    let usable = |p: &&Interval| p.to - p.from > SHORTEST * (p.from.abs().max(p.to.abs()) + whole);
    for part in parts.iter().filter(usable) {
        let curve = elements[part.element].curve(job, part.from, part.to, fit)?;
        let width = curve.space().length();
        placed.push((*part, (at, at + width)));
        curves.push(curve.reparametrise(at, at + width)?);
        at += width;
    }
    if curves.is_empty() {
        return Ok(None);
    }
    let mut curve = joined(job, curves)?;
    let (low, high) = curve.hull_bounds();
    if (high - low).amax() <= job.tolerance {
        return Ok(None);
    }
    curve = curve.remove_knots(0.0)?.shape;
    curve = curve.remove_knots(fit)?.shape;
    // What ends where it starts goes round, however it was put together.
    let gap = |points: &[Point]| match points {
        [first, .., last] => (last - first).norm(),
        _ => f64::INFINITY,
    };
    let closed = closed || job.plane.closed && parts.len() > 1 && gap(curve.points()) <= job.snap();
    if closed {
        let (space, mut points, weights) = curve.into_parts();
        if let [first, .., last] = &mut points[..] {
            *last = *first;
        }
        curve = Curve::build(space, points, weights)?;
        if job.curve.is_periodic() {
            curve = curve.to_periodic(0.1 * job.tolerance)?.shape;
        }
    }
    Ok(Some(Chain { curve, closed, parts: placed }))
}

/// All curves as one, two by two, so that each is copied a few times only.
fn joined(job: &Job<'_>, mut curves: Vec<Curve>) -> Result<Curve> {
    while curves.len() > 1 {
        let mut pairs = curves.chunks(2);
        let mut next = Vec::with_capacity(curves.len().div_ceil(2));
        for pair in &mut pairs {
            next.push(match pair {
                [a, b] => a.join(b, 2.0 * job.snap())?.shape,
                [a] => a.clone(),
                _ => continue,
            });
        }
        curves = next;
    }
    curves.pop().ok_or_else(|| loftsman_kernel::Error::Invalid("no part of the curve is left".into()))
}
