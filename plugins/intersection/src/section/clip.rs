//! Branches of a surface's section cut where they leave a face, and what is left put together across faces.

use std::collections::HashMap;

use loftsman_kernel::spline::{Curve, Direction, Space};
use loftsman_kernel::{Point, Vector};

use super::SectionCurve;
use super::exact::is_drawn;
use crate::error::Result;

/// A place on a border that two pieces share: an edge's number, and the number of the meeting on it.
pub(crate) type Event = (usize, usize);

/// Where a branch meets the border of a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gate {
    /// The branch's parameter.
    pub(crate) at: f64,
    /// 1 where it comes in, -1 where it goes out, running along its parameter; 0 where that is not known.
    pub(crate) turn: i32,
    pub(crate) point: Point,
    pub(crate) event: Event,
}

/// A part of a section inside a face.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) curve: Curve,
    /// Where on borders it starts and ends; none where it ends at nothing, or is closed.
    pub(crate) ends: [Option<Event>; 2],
    pub(crate) closed: bool,
    pub(crate) distance: f64,
    pub(crate) face: usize,
    /// As of the branch.
    pub(crate) isocurve: Option<(Direction, f64)>,
}

/// How near on a branch, as a part of its length, gates are at one place: seams, and corners.
const ONE: f64 = 1e-7;
/// How near on a branch, as a part of its length, a gate is to a knot that is at it.
const KNOT: f64 = 1e-12;

/// The parts of a branch between gates, and whether each is inside: by the gates' turns where these alternate, else as `inside` says
/// of their middles. Gates at one place at which it comes in and goes out are none. `None` where it cannot be said.
pub(crate) fn clipped(
    branch: &SectionCurve,
    mut gates: Vec<Gate>,
    face: usize,
    inside: impl Fn(Point) -> Result<Option<bool>>,
) -> Result<Option<Vec<Part>>> {
    let (start, end) = branch.curve.domain();
    let length = end - start;
    let is_signed = gates.iter().any(|gate| gate.turn != 0);
    gates.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.event.cmp(&b.event)));
    // Places: what is at one of them, together.
    let mut places: Vec<Gate> = Vec::with_capacity(gates.len());
    for gate in gates {
        match places.last_mut() {
            Some(last) if gate.at - last.at <= ONE * length && is_signed => last.turn += gate.turn,
            _ => places.push(gate),
        }
    }
    if branch.closed && places.len() > 1 {
        let (first, last) = (places[0], places[places.len() - 1]);
        if first.at - start + (end - last.at) <= ONE * length && is_signed {
            places[0].turn += last.turn;
            places.pop();
        }
    }
    if is_signed {
        places.retain(|gate| gate.turn != 0);
    }
    let whole = |curve: Curve| Part {
        curve,
        ends: [None; 2],
        closed: branch.closed,
        distance: branch.distance,
        face,
        isocurve: branch.isocurve,
    };
    if places.is_empty() {
        let middle = branch.curve.point(0.5 * (start + end))?;
        return Ok(inside(middle)?.map(|is| if is { vec![whole(branch.curve.clone())] } else { Vec::new() }));
    }
    // From each place to the next; of an open branch also before the first and behind the last.
    let count = places.len();
    let mut spans: Vec<(f64, f64, Option<usize>, Option<usize>)> = Vec::with_capacity(count + 1);
    for k in 0..count.saturating_sub(1) {
        spans.push((places[k].at, places[k + 1].at, Some(k), Some(k + 1)));
    }
    let (first, last) = (places[0].at, places[count - 1].at);
    if branch.closed {
        spans.push((last, first + length, Some(count - 1), Some(0)));
    } else {
        spans.insert(0, (start, first, None, Some(0)));
        spans.push((last, end, Some(count - 1), None));
    }
    let turn = |k: Option<usize>| k.map_or(0, |k| places[k].turn.signum());
    // Coming in, then going out, all the way round.
    let alternates = is_signed
        && spans.iter().all(|&(.., a, b)| a.is_none() || b.is_none() || turn(a) != turn(b) || count == 1);
    let mut knots = branch.curve.space().breakpoints();
    if branch.closed {
        knots.extend(knots.clone().into_iter().skip(1).map(|t| t + length));
    }
    let mut parts = Vec::new();
    for (from, to, a, b) in spans {
        if to - from <= ONE * length {
            continue;
        }
        let is_inside = if alternates && (count > 1 || !branch.closed) {
            // Where it starts or ends at no border of the face, the border of the surface stands for that.
            if a.is_some() { turn(a) > 0 } else { turn(b) < 0 }
        } else {
            let middle = 0.5 * (from + to);
            let middle = if middle > end { middle - length } else { middle };
            match inside(branch.curve.point(middle)?)? {
                Some(is) => is,
                None => return Ok(None),
            }
        };
        if !is_inside {
            continue;
        }
        let near = KNOT * length;
        let mut from = on_knot(&knots, from, near);
        let mut to = on_knot(&knots, to, near);
        // What starts where a loop ends is in its first round: its knots are the curve's own there, and not those a round later, rounded.
        if branch.closed && from >= end {
            from = start;
            to = on_knot(&knots, to - length, near);
        }
        let curve = branch.curve.between(from, to)?;
        let (space, mut points, weights) = curve.into_parts();
        let rim = points.len() - 1;
        for (at, gate) in [(0, a), (rim, b)] {
            if let Some(gate) = gate {
                // Both faces have the point of the edge itself.
                points[at] = places[gate].point;
            }
        }
        let curve = Curve::build(space, points, weights)?;
        let ends = [a, b].map(|k| k.map(|k| places[k].event));
        let (distance, isocurve) = (branch.distance, branch.isocurve);
        parts.push(Part { curve, ends, closed: false, distance, face, isocurve });
    }
    Ok(Some(parts))
}

/// The least span between knots, as a part of these.
const SPAN: f64 = 64.0 * f64::EPSILON;

/// A parameter, or the knot that it is beside: what would be between them is shorter than can be told.
fn on_knot(knots: &[f64], t: f64, near: f64) -> f64 {
    knots.iter().copied().find(|knot| (knot - t).abs() <= near).unwrap_or(t)
}

/// A branch of the section of several faces.
#[derive(Debug, Clone, PartialEq)]
pub struct ShellCurve {
    /// The branch: a cubic spline, or what is left of an [isocurve](Self::isocurve). Where it is closed, it ends where it starts.
    pub curve: Curve,
    /// Whether it is a loop.
    pub closed: bool,
    /// The largest distance from the section that was measured between its points.
    pub distance: f64,
    /// The faces that it runs through, in order.
    pub faces: Vec<usize>,
    /// Of a branch that is exact, because it is an isocurve of a trimmed surface: which parameter stands still, and where.
    pub isocurve: Option<(Direction, f64)>,
}

/// Parts joined where one ends at the place at which another starts. In the order of the parts; `O(parts)`.
pub(crate) fn joined(parts: Vec<Part>) -> Result<Vec<ShellCurve>> {
    let mut starts: HashMap<Event, Vec<usize>> = HashMap::new();
    let mut reached: HashMap<Event, usize> = HashMap::new();
    for (k, part) in parts.iter().enumerate() {
        if let [Some(from), to] = part.ends {
            starts.entry(from).or_default().push(k);
            to.into_iter().for_each(|to| *reached.entry(to).or_default() += 1);
        } else if let [None, Some(to)] = part.ends {
            *reached.entry(to).or_default() += 1;
        }
    }
    starts.values_mut().for_each(|list| list.reverse());
    let mut used = vec![false; parts.len()];
    let mut curves = Vec::new();
    // First those that begin where nothing ends, then what is left are loops.
    let begins = |k: &usize| parts[*k].ends[0].is_none_or(|from| !reached.contains_key(&from));
    let order: Vec<usize> = (0..parts.len()).filter(begins).chain(0..parts.len()).collect();
    for first in order {
        if used[first] {
            continue;
        }
        let mut chain = vec![first];
        used[first] = true;
        let from = parts[first].ends[0];
        let mut to = parts[first].ends[1];
        while let Some(event) = to.filter(|to| Some(*to) != from) {
            let next = starts.get_mut(&event).and_then(|list| {
                while let Some(k) = list.pop() {
                    if !used[k] {
                        return Some(k);
                    }
                }
                None
            });
            let Some(next) = next else { break };
            used[next] = true;
            chain.push(next);
            to = parts[next].ends[1];
        }
        let closed = parts[first].closed || (from.is_some() && to == from);
        let distance = chain.iter().map(|&k| parts[k].distance).fold(0.0, f64::max);
        let faces = chain.iter().map(|&k| parts[k].face).collect();
        let isocurve = if let [only] = chain[..] { parts[only].isocurve } else { None };
        curves.push(ShellCurve {
            curve: one(chain.iter().map(|&k| &parts[k].curve))?,
            closed,
            distance,
            faces,
            isocurve,
        });
    }
    Ok(curves)
}

/// Curves, each of which starts where the one before ends, as one.
fn one<'a>(curves: impl ExactSizeIterator<Item = &'a Curve> + Clone) -> Result<Curve> {
    if curves.len() > 1 && !curves.clone().all(is_drawn) {
        let mut all: Option<Curve> = None;
        for curve in curves {
            all = Some(match all {
                // They end at the same place of the border, but for rounding.
                Some(all) => all.join(curve, f64::INFINITY)?.shape,
                None => curve.clone(),
            });
        }
        return all.ok_or_else(|| loftsman_kernel::Error::Invalid("there is nothing to join".into()).into());
    }
    let alone = curves.len() == 1;
    let (mut knots, mut points): (Vec<f64>, Vec<Point>) = (Vec::new(), Vec::new());
    for curve in curves {
        if alone {
            return Ok(curve.clone());
        }
        let (start, end) = curve.domain();
        let shift = knots.last().map_or(0.0, |last| last - start);
        let own = curve.space().flat();
        let skip = if points.is_empty() {
            knots.extend([start; 4]);
            0
        } else {
            1
        };
        // Behind a long curve a short one's knots may round to one: each lies so far behind the one before that the span between is one.
        let mut last = (start, knots.last().copied().unwrap_or(start));
        for &u in own.iter().filter(|&&u| u > start && u < end).chain([&end; 3]) {
            if u > last.0 {
                last = (u, (u + shift).max(last.1 + (SPAN * last.1.abs()).max(f64::MIN_POSITIVE)));
            }
            knots.push(last.1);
        }
        points.extend(curve.points().iter().skip(skip));
    }
    knots.extend(knots.last().copied());
    Ok(Curve::new(Space::open(3, knots)?, points)?)
}

/// Twice the area that a plane curve goes around, counterclockwise as seen from the tip of the normal: exact for cubics, of others to rounding or so.
pub(crate) fn doubled_area(curve: &Curve, normal: &Vector) -> Result<f64> {
    let mut area = doubled_area_by(curve, normal, 1)?;
    if curve.weights().is_none() && curve.degree() <= 3 {
        return Ok(area);
    }
    // Errors of three places of Gauss fall by 64 with each halving.
    for halvings in 1..=FINEST {
        let finer = doubled_area_by(curve, normal, 1 << halvings)?;
        let change = (finer - area).abs();
        area = finer;
        if change <= 64.0 * f64::EPSILON * area.abs() {
            break;
        }
    }
    Ok(area)
}

/// The most halvings of a span whose area is added up.
const FINEST: u32 = 8;

/// The same by three places of each of so many parts of a span.
fn doubled_area_by(curve: &Curve, normal: &Vector, parts: usize) -> Result<f64> {
    // Of degree 5 on each span: three places of Gauss.
    let nodes = [(0.5 - 0.15_f64.sqrt(), 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + 0.15_f64.sqrt(), 5.0 / 18.0)];
    let mut sum = 0.0;
    let Some(origin) = curve.points().first().copied() else { return Ok(0.0) };
    for span in curve.space().breakpoints().windows(2) {
        let length = (span[1] - span[0]) / parts as f64;
        for part in 0..parts {
            for (x, weight) in nodes {
                let u = span[0] + length * (part as f64 + x);
                let (r, d) = (curve.point(u)? - origin, curve.derivative(u, 1)?);
                sum += weight * length * r.cross(&d).dot(normal);
            }
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

    use loftsman_kernel::spline::Surface;

    use super::*;
    use crate::{Options, Plane, section};

    /// A part that starts where a loop ends has the loop's own knots: none that are those but for rounding. So do parts behind one another.
    #[test]
    fn parts_have_no_spans_of_rounding() {
        for k in 0..40 {
            let radius = 1.0 + 0.137 * f64::from(k);
            let ring = Curve::circle(Point::origin(), Vector::z(), radius).unwrap();
            let pipe = Surface::extrusion(&ring, Vector::z() * 5.0).unwrap();
            let plane = Plane::new(Point::new(0.0, 0.0, 2.0), Vector::z()).unwrap();
            let cut = section(&pipe, &plane, &Options::within(1e-6)).unwrap();
            let branch = &cut.curves[0];
            let (start, end) = branch.curve.domain();
            let knots = branch.curve.space().breakpoints();
            let middle = knots[knots.len() / 2];
            assert!(branch.closed && start < middle && middle < end);
            let gate = |at: f64, turn: i32, event: usize| {
                let point = branch.curve.point(at).unwrap();
                Gate { at, turn, point, event: (event, 0) }
            };
            let least = |curve: &Curve| {
                let knots = curve.space().breakpoints();
                knots.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min)
            };
            for way in [1, -1] {
                let gates = vec![gate(middle, -way, 0), gate(end, way, 1)];
                let parts = clipped(branch, gates, 0, |_| Ok(None)).unwrap().unwrap();
                assert_eq!(parts.len(), 1);
                assert!(
                    least(&parts[0].curve) > 1e-6,
                    "{radius}: {:?}",
                    parts[0].curve.space().breakpoints()
                );
            }
        }
        // Behind a long curve one that is shorter than rounding of its end.
        let line = |from: f64, to: f64| {
            let [a, b] = [from, to].map(|x| Point::new(x, 0.0, 0.0));
            Curve::line(a, b).unwrap().elevate(2).unwrap().reparametrise(from, to).unwrap()
        };
        let (long, short) = (line(0.0, 1e9), line(0.0, 1e-9));
        let both = one([long, short].iter()).unwrap();
        for span in both.bezier_segments().unwrap() {
            assert!(span.reparametrise(0.0, 1.0).is_ok());
        }
    }
}
