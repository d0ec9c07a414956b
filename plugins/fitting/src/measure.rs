//! What a fit is judged by: measured on the curve that is handed out, never taken from the solver.

use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use crate::error::{Astray, Result};

/// Nodes and weights of Gauss and Legendre's rule of five points on `[-1, 1]`.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];
/// The same rule of three points.
const GAUSS_3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// Distances below this are rounding, of coordinates of size 1.
const ROUNDING: f64 = 1e-14;
/// Points nearer to the one before than this many times the largest error say nothing about the direction of travel.
const SCALE: f64 = 10.0;
/// Points that were passed over must be within this many times the error of the chord, for its direction to count.
const STRAIGHT: f64 = 3.0;
/// Samples of a curve that may go back.
const RETREAT: u32 = 64;
/// Where the polygon turns by more than about 160° (half the sum of its directions is shorter than this), a smooth
/// curve may pass the point in any direction.
const REVERSAL: f64 = 0.17;

/// What a curve may do at most.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Its length, in lengths of the polygon.
    pub(crate) length: f64,
    /// [`Travel::detour`].
    pub(crate) detour: f64,
    /// [`Travel::heading`], at least.
    heading: f64,
}

/// What is refused: a curve that is more than twice as long as the polygon of its points, that between two points is
/// more than four times as long as the polygon about there, or that passes a point backwards.
///
/// Interpolation by centripetal parameters stays far below: cubics through hundreds of jagged, noisy and uneven sets
/// of points are 1.19 times as long at most, and 1.54 times between two points.
pub(crate) const LIMIT: Bounds = Bounds { length: 2.0, detour: 4.0, heading: -1e-9 };
/// What interpolation takes without looking for another way.
pub(crate) const ACCEPTED: Bounds = Bounds { length: 1.5, detour: 3.0, heading: 0.0 };
/// What a search does not go on from while something better can be had.
pub(crate) const PREFERRED: Bounds = Bounds { length: 1.25, detour: 2.0, heading: 0.0 };

/// A curve beside the polygon of the points that it was fitted to. Lengths are in the units of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Travel {
    /// The length of the curve.
    pub(crate) length: f64,
    /// The length of the polygon of the points.
    pub(crate) polygon: f64,
    /// The largest ratio of the curve's length between two points to the polygon's, there or in the piece before or
    /// behind it, whichever is longest; and the point where that piece starts.
    pub(crate) detour: (f64, usize),
    /// The least cosine of the angle between the tangent at a point and the direction in which the polygon passes
    /// it, and the point.
    pub(crate) heading: (f64, usize),
}

impl Travel {
    /// What is wrong with it, if anything. `allowance`: how much longer than its bound the curve may be because of
    /// constraints; `free`: whether constraints may also send it off, or back, between the points.
    pub(crate) fn trouble(&self, bounds: &Bounds, allowance: f64, free: bool) -> Option<Astray> {
        let longest = bounds.length * self.polygon + allowance;
        if self.length.is_nan() || self.length > longest {
            return Some(Astray::Long(self.length / self.polygon));
        }
        if !free && self.detour.0 > bounds.detour {
            return Some(Astray::Detour(self.detour.1, self.detour.0));
        }
        (!free && self.heading.0 < bounds.heading).then_some(Astray::Back(self.heading.1))
    }
}

/// A curve may leave the box of its points by this part of the box's longest side: a circle through three points leaves theirs
/// by less than a third.
const OUTSIDE: f64 = 0.5;
/// Places on a knot span at which it is looked how far the curve leaves the box.
const PLACES: usize = 32;

/// Where points are expected on a curve.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<'a> {
    /// The points.
    pub(crate) points: &'a [Vector],
    /// Their parameters, which do not decrease.
    pub(crate) sites: &'a [f64],
    /// Whether the last point is followed by the first.
    pub(crate) closed: bool,
    /// Points at which the curve may have a corner, in order.
    pub(crate) corners: &'a [usize],
}

impl Course<'_> {
    /// The distance of each point from the curve at its parameter.
    ///
    /// # Errors
    /// As for [`Curve::point`].
    pub(crate) fn distances(&self, curve: &Curve) -> Result<Vec<f64>> {
        let mut found = vec![Point::origin(); self.points.len()];
        curve.points_into(&self.sites[..self.points.len()], &mut found)?;
        Ok(found.iter().zip(self.points).map(|(p, q)| (p.coords - q).norm()).collect())
    }

    /// The largest true distance of a point from the curve, from the nearest point of all of it, and the point that has it. `distances` are
    /// those at the parameters, which bound it from above, so that few points need the search.
    ///
    /// # Errors
    /// As for [`Curve::closest`].
    pub(crate) fn farthest(&self, curve: &Curve, distances: &[f64]) -> Result<(f64, usize)> {
        let mut order: Vec<usize> = (0..distances.len()).collect();
        order.sort_by(|&a, &b| distances[b].total_cmp(&distances[a]).then(a.cmp(&b)));
        let mut farthest = (0.0_f64, order.first().copied().unwrap_or(0));
        for k in order {
            // Nothing is left to find: below rounding there is no nearer point.
            let last = distances[k] <= farthest.0.max(ROUNDING);
            let found = if last { ROUNDING } else { curve.closest(Point::from(self.points[k]))?.distance };
            let found = found.min(distances[k]);
            if found > farthest.0 {
                farthest = (found, k);
            }
            if last {
                break;
            }
        }
        Ok(farthest)
    }

    /// How the curve travels along the points; `error` is the largest of the distances. `O((m + n) p²)`.
    ///
    /// # Errors
    /// As for [`Curve::derivative`].
    pub(crate) fn travel(&self, curve: &Curve, error: f64) -> Result<Travel> {
        let chain = self.chain(SCALE * error);
        let count = chain.len();
        let around = self.closed && count > 2;
        let chords: Vec<Vector> = (0..if around { count } else { count.saturating_sub(1) })
            .map(|j| self.points[chain[(j + 1) % count]] - self.points[chain[j]])
            .collect();
        // What lies between two points of the chain: how long the polygon is there, and whether it is straight, so that
        // its direction can be compared with the curve's.
        let m = self.points.len();
        let between = |j: usize| {
            let (from, to) = (chain[j], if j + 1 < count { chain[j + 1] } else { chain[0] + m });
            let at = |k: usize| self.points[k % m];
            let arc: f64 = (from..to).map(|k| (at(k + 1) - at(k)).norm()).sum();
            let along = chords[j].normalize();
            let off = |k: usize| {
                let q = at(k) - at(from);
                let t = q.dot(&along).clamp(0.0, chords[j].norm());
                (q - along * t).norm()
            };
            (arc, (from + 1..to).all(|k| off(k) <= STRAIGHT * error))
        };
        let (arcs, straight): (Vec<f64>, Vec<bool>) = (0..chords.len()).map(between).unzip();
        let lengths = self.pieces(curve, &chain)?;
        let total: f64 = lengths.iter().sum();
        let polygon = self.polygon();
        let sites: Vec<f64> = chain.iter().map(|&k| self.sites[k]).collect();
        let jets = jets(curve, &sites)?;
        let mut detour = (0.0_f64, 0);
        let mut heading = (1.0_f64, 0);
        let pieces = chords.len();
        let arc = |j: Option<usize>| j.and_then(|j| arcs.get(j)).copied().unwrap_or(0.0);
        for j in 0..pieces {
            let before = if around { Some((j + pieces - 1) % pieces) } else { j.checked_sub(1) };
            let after = if around { (j + 1) % pieces } else { j + 1 };
            let longest = arc(before).max(arc(Some(j))).max(arc(Some(after)));
            // Before the first point and behind the last one of an open chain there is nothing, so pieces are
            // lengths[1..]; around, the first and the last interval are one piece.
            let length = if around && j + 1 == pieces { lengths[0] + lengths[j + 1] } else { lengths[j + 1] };
            if length > detour.0 * longest {
                detour = (length / longest, chain[j]);
            }
            let Some(before) = before else { continue };
            let k = chain[j];
            if !(straight[before] && straight[j]) || self.corners.binary_search(&k).is_ok() {
                continue;
            }
            let along = (chords[before].normalize() + chords[j].normalize()) * 0.5;
            let [_, tangent] = jets[j];
            let (course, speed) = (along.norm(), tangent.norm());
            if course > REVERSAL && speed > 0.0 {
                let cosine = along.dot(&tangent) / (course * speed);
                let window = (sites[before.min(j)], sites[(j + 1) % count].max(sites[j]));
                if cosine < heading.0 && (cosine >= 0.0 || retreat(curve, window, &along)? > 2.0 * error) {
                    heading = (cosine, k);
                }
            }
        }
        Ok(Travel { length: total, polygon, detour, heading })
    }

    /// The same with the length to six digits: for a curve that is handed out.
    ///
    /// # Errors
    /// As for [`travel`](Self::travel).
    pub(crate) fn travelled(&self, curve: &Curve, error: f64) -> Result<Travel> {
        Ok(Travel { length: curve.length(1e-6)?.value, ..self.travel(curve, error)? })
    }

    /// What is wrong with how far the curve leaves the box of the points, if anything; `allowance`: how much farther it may
    /// because of constraints. Where the control vertices do not leave it, neither does the curve, and no point is asked.
    ///
    /// # Errors
    /// As for [`Curve::point`].
    pub(crate) fn outside(&self, curve: &Curve, allowance: f64) -> Result<Option<Astray>> {
        let Some(&first) = self.points.first() else { return Ok(None) };
        let (low, high) = self.points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let side = (high - low).amax();
        let beyond = |p: &Point| (p.coords - high).sup(&(low - p.coords)).max();
        let farthest = |points: &[Point]| points.iter().map(beyond).fold(0.0_f64, f64::max);
        let most = OUTSIDE * side + allowance;
        if farthest(curve.points()) <= most {
            return Ok(None);
        }
        let at: Vec<f64> = curve
            .space()
            .breakpoints()
            .windows(2)
            .flat_map(|w| (0..PLACES).map(move |i| w[0] + (w[1] - w[0]) * (i as f64 + 0.5) / PLACES as f64))
            .collect();
        let mut points = vec![Point::origin(); at.len()];
        curve.points_into(&at, &mut points)?;
        let out = farthest(&points);
        Ok((out > most).then_some(Astray::Outside(out / side)))
    }

    /// The length of the polygon.
    pub(crate) fn polygon(&self) -> f64 {
        let around = if self.closed { self.points.first().zip(self.points.last()) } else { None };
        let open: f64 = self.points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        open + around.map_or(0.0, |(a, b)| (a - b).norm())
    }

    /// The points without those that are within `least` of the one before (and, at the end, of the last one).
    fn chain(&self, least: f64) -> Vec<usize> {
        let mut chain: Vec<usize> = Vec::with_capacity(self.points.len());
        let far = |a: usize, b: usize| (self.points[a] - self.points[b]).norm() > least;
        for k in 0..self.points.len() {
            if chain.last().is_none_or(|&before| far(before, k)) {
                chain.push(k);
            }
        }
        if self.closed {
            while chain.len() > 1 && !far(chain[0], chain[chain.len() - 1]) {
                chain.pop();
            }
        }
        chain
    }

    /// The lengths of the curve from its start to the first point of the chain, from one to the next, and from the
    /// last to its end: Gauss's rule between neighbouring knots and points, where the speed is smooth.
    fn pieces(&self, curve: &Curve, chain: &[usize]) -> Result<Vec<f64>> {
        let breaks = curve.space().breakpoints();
        let mut ends = chain.iter().map(|&k| self.sites[k]).peekable();
        // Intervals without a knot inside, and the piece that each belongs to.
        let mut intervals: Vec<(f64, f64, usize)> = Vec::with_capacity(breaks.len() + chain.len());
        let mut piece = 0;
        let mut from = breaks[0];
        for &to in &breaks {
            while let Some(site) = ends.next_if(|&u| u <= to) {
                intervals.push((from, site, piece));
                piece += 1;
                from = from.max(site);
            }
            intervals.push((from, to, piece));
            from = from.max(to);
        }
        intervals.retain(|(a, b, _)| a < b);
        let short = intervals.iter().map(|&(a, b, _)| (a, b));
        let spans = if curve.degree() > 5 {
            stretches(curve, short, &GAUSS)?
        } else {
            stretches(curve, short, &GAUSS_3)?
        };
        // A parameter that lies beyond the end has no piece.
        let mut lengths = vec![0.0; chain.len() + 1];
        for ((_, _, piece), length) in intervals.into_iter().zip(spans) {
            lengths[piece] += length;
        }
        Ok(lengths)
    }
}

/// How far a curve goes back against a direction between two parameters.
fn retreat(curve: &Curve, (a, b): (f64, f64), along: &Vector) -> Result<f64> {
    let (mut farthest, mut back) = (f64::NEG_INFINITY, 0.0_f64);
    for i in 0..=RETREAT {
        let reached = curve.derivative(a + (b - a) * f64::from(i) / f64::from(RETREAT), 0)?.dot(along);
        farthest = farthest.max(reached);
        back = back.max((farthest - reached) / along.norm());
    }
    Ok(back)
}

/// `∫ |C'|` over intervals without a knot inside, in ascending order.
fn stretches(
    curve: &Curve,
    intervals: impl Iterator<Item = (f64, f64)> + Clone,
    rule: &[(f64, f64)],
) -> Result<Vec<f64>> {
    let nodes = |(a, b): (f64, f64)| {
        let (middle, half) = (0.5 * a + 0.5 * b, 0.5 * b - 0.5 * a);
        rule.iter().map(move |(node, _)| (middle + half * node).clamp(a, b))
    };
    let at: Vec<f64> = intervals.clone().flat_map(nodes).collect();
    let jets = jets(curve, &at)?;
    let sums = jets.chunks_exact(rule.len()).zip(intervals).map(|(jets, (a, b))| {
        let sum: f64 = jets.iter().zip(rule).map(|([_, tangent], (_, weight))| weight * tangent.norm()).sum();
        (0.5 * b - 0.5 * a) * sum
    });
    Ok(sums.collect())
}

/// Points and tangents at many parameters.
pub(crate) fn jets(curve: &Curve, at: &[f64]) -> Result<Vec<[Vector; 2]>> {
    let mut flat = vec![Vector::zeros(); 2 * at.len()];
    curve.derivatives_many_into(at, 2, &mut flat)?;
    Ok(flat.as_chunks::<2>().0.to_vec())
}

/// The length of a curve, by Gauss's rule on every knot span.
///
/// # Errors
/// As for [`Curve::derivative`].
pub(crate) fn length(curve: &Curve) -> Result<f64> {
    let breaks = curve.space().breakpoints();
    Ok(stretches(curve, breaks.windows(2).map(|w| (w[0], w[1])), &GAUSS)?.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(points: &[Vector]) -> Course<'_> {
        Course { points, sites: &[0.0, 0.5, 1.0], closed: false, corners: &[] }
    }

    #[test]
    fn an_arc_is_measured_and_found_good() {
        let curve = Curve::bezier(vec![
            Point::new(-1.0, 1.0, 0.0),
            Point::new(0.0, -1.0, 0.0),
            Point::new(1.0, 1.0, 0.0),
        ])
        .unwrap();
        let points = [Vector::new(-1.0, 1.0, 0.0), Vector::new(0.0, 0.3, 0.0), Vector::new(1.0, 1.0, 0.0)];
        let distances = course(&points).distances(&curve).unwrap();
        assert!((distances[1] - 0.3).abs() < 1e-15 && distances[0] == 0.0);
        // The parabola y = x² is nearest to (0, 0.3) at its vertex, as long as 0.3 is below 1/2.
        let (farthest, at) = course(&points).farthest(&curve, &distances).unwrap();
        assert!((farthest - 0.3).abs() < 1e-12 && at == 1);
        let travel = course(&points).travel(&curve, 0.0).unwrap();
        let exact = 5.0_f64.sqrt() + 0.5 * 2.0_f64.asinh();
        assert!((travel.length - exact).abs() < 1e-3 && (length(&curve).unwrap() - exact).abs() < 1e-2);
        assert!((travel.polygon - 2.0 * 1.49_f64.sqrt()).abs() < 1e-15);
        assert_eq!(travel.trouble(&LIMIT, 0.0, false), None);
    }

    #[test]
    fn loops_and_turns_are_found() {
        let far = Curve::bezier(vec![
            Point::origin(),
            Point::new(40.0, 0.9, 0.0),
            Point::new(-39.0, 0.9, 0.0),
            Point::new(1.0, 0.0, 0.0),
        ])
        .unwrap();
        let middle = far.point(0.5).unwrap().coords;
        let points = [Vector::zeros(), middle, Vector::x()];
        let travel = course(&points).travel(&far, 0.0).unwrap();
        assert!(matches!(travel.trouble(&LIMIT, 0.0, false), Some(Astray::Long(ratio)) if ratio > 2.0));
        assert!(matches!(travel.trouble(&LIMIT, 1e3, false), Some(Astray::Back(1) | Astray::Detour(..))));
        assert_eq!(travel.trouble(&LIMIT, 1e3, true), None);
    }

    #[test]
    fn what_lies_within_the_error_has_no_say() {
        let line = Curve::bezier(vec![Point::origin(), Point::new(1.0, 0.0, 0.0)]).unwrap();
        let points = [Vector::zeros(), Vector::new(0.5, 0.1, 0.0), Vector::new(0.45, -0.1, 0.0), Vector::x()];
        let all = Course { points: &points, sites: &[0.0, 0.48, 0.49, 1.0], closed: false, corners: &[] };
        assert!(all.travel(&line, 0.0).unwrap().heading.0 < 0.75);
        assert!(all.travel(&line, 0.1).unwrap().heading.0 > 0.9);
    }
}
