//! What cannot be wrong with a curve, told from its control polygon for a fraction of what measuring costs.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Curve;

use crate::error::Result;
use crate::measure::{Bounds, Course, jets};

/// A leg of the control polygon, and how fast a curve is that goes along it.
struct Leg {
    along: Vector,
    speed: f64,
}

impl Course<'_> {
    /// Whether a curve that passes the points has no [trouble](crate::measure::Travel::trouble), whatever its exact
    /// length. `false` says nothing.
    ///
    /// The derivative's control vertices are the legs of the polygon, each times `p / (t_{i+p+1} - t_{i+1})`, and on a span
    /// the derivative is a mean of `p` of them. So no stretch of the curve is longer than its way in the parameter times the
    /// longest of these, nor does a quadrature of its speed find it so; and where all of them go forward along the chords
    /// before and behind a point, the tangent there does; at other points it is asked. `O(n + m p)`.
    ///
    /// # Errors
    /// As for [`Curve::derivative`].
    pub(crate) fn surely_follows(&self, curve: &Curve, bounds: &Bounds) -> Result<bool> {
        let (p, space, m) = (curve.degree(), curve.space(), self.points.len());
        let (start, end) = space.domain();
        let whole = self.closed || (self.sites[0] == start && self.sites[m - 1] == end);
        if m < 3 || !whole || curve.weights().is_some() {
            return Ok(false);
        }
        let (legs, spans) = (legs(curve), self.spans(curve));
        let pieces = if self.closed { m } else { m - 1 };
        let chord = |j: usize| self.points[if j + 1 == m { 0 } else { j + 1 }] - self.points[j];
        let chords: Vec<(Vector, f64)> = (0..pieces).map(chord).map(|c| (c, c.norm())).collect();
        let forward = |j: usize, before: usize| {
            let (a, b) = (&chords[before].0, &chords[j].0);
            legs[spans[j] - p..spans[j]].iter().all(|leg| leg.along.dot(a) > 0.0 && leg.along.dot(b) > 0.0)
        };
        let reach = |from: usize, to: usize, way: f64| {
            way * legs[from - p..to].iter().fold(0.0_f64, |most, leg| most.max(leg.speed))
        };
        let (mut total, mut polygon, mut turning) = (0.0, 0.0, Vec::new());
        for (j, &(_, arc)) in chords.iter().enumerate() {
            let length = if j + 1 < m {
                reach(spans[j], spans[j + 1], self.sites[j + 1] - self.sites[j])
            } else {
                // Around: to the end, and from the start on.
                reach(spans[j], space.unrolled_len() - 1, end - self.sites[j])
                    + reach(p, spans[0], self.sites[0] - start)
            };
            if length > bounds.detour * arc {
                return Ok(false);
            }
            total += length;
            polygon += arc;
            let before = j.checked_sub(1).or(self.closed.then_some(m - 1));
            turning.extend(before.filter(|&before| !forward(j, before)).map(|before| (before, j)));
        }
        // Also where it is not a number.
        let short = total <= bounds.length * polygon;
        if !short || turning.is_empty() {
            return Ok(short);
        }
        let sites: Vec<f64> = turning.iter().map(|&(_, j)| self.sites[j]).collect();
        let jets = jets(curve, &sites)?;
        let forward = |(&(before, j), [_, tangent]): (&(usize, usize), &[Vector; 2])| {
            let (a, b) = (chords[before], chords[j]);
            tangent.dot(&(a.0 / a.1 + b.0 / b.1)) > 0.0
        };
        Ok(turning.iter().zip(&jets).all(forward))
    }

    /// The span of each site, `O(n + m)`.
    fn spans(&self, curve: &Curve) -> Vec<usize> {
        let (flat, last) = (curve.space().flat(), curve.space().unrolled_len() - 1);
        let mut span = curve.degree();
        let place = |&u: &f64| {
            while span < last && flat[span + 1] <= u {
                span += 1;
            }
            span
        };
        self.sites[..self.points.len()].iter().map(place).collect()
    }
}

/// The legs of a control polygon, on the unrolled line. Where knots coincide so that a leg stands for no stretch of the
/// curve, its speed is infinite.
fn legs(curve: &Curve) -> Vec<Leg> {
    let (p, space, vertices) = (curve.degree(), curve.space(), curve.points());
    let flat = space.flat();
    let leg = |i: usize| {
        let along = vertices[space.vertex(i + 1)] - vertices[space.vertex(i)];
        let width = flat[i + p + 1] - flat[i + 1];
        let speed = if width > 0.0 { p as f64 * along.norm() / width } else { f64::INFINITY };
        Leg { along, speed }
    };
    (0..space.unrolled_len() - 1).map(leg).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::interpolation::Interpolation;
    use crate::measure::LIMIT;
    use loftsman_kernel::Point;

    #[test]
    fn it_is_never_sure_of_what_measuring_refuses() {
        let mut x = 1_u32;
        let mut unit = || {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(x) / 4_294_967_296.0
        };
        let (mut sure, mut fine, mut refused) = (0, 0, 0);
        for case in 0..3000_usize {
            let (degree, closed) = (1 + case % 7, case % 2 == 0);
            let m = 9 + case % 30;
            let noise = [0.0, 0.003, 0.03, 0.3][case % 4];
            let mut point = |i: usize| {
                let a = std::f64::consts::TAU * (i as f64 + noise * 3.0 * unit()) / m as f64;
                let z = if closed { 0.0 } else { a };
                Point::new(a.cos() + noise * unit(), a.sin() + noise * unit(), z)
            };
            let points: Vec<Point> = (0..m).map(&mut point).collect();
            let frame = Frame::of(&points).unwrap();
            let local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
            let through = Interpolation { closed, ..Interpolation::new(degree) };
            let sites = through.parameters.of_local(&local, closed).unwrap();
            let Ok(found) = through.local(&frame, local, sites) else { continue };
            let vertices = found.vertices.as_chunks::<3>().0.iter().map(|&v| v.into()).collect();
            let curve = Curve::new(found.space, vertices).unwrap();
            let sites = &found.sites[..found.points.len()];
            let course = Course { points: &found.points, sites, closed, corners: &[] };
            let travel = course.travel(&curve, 0.0).unwrap();
            let trouble = travel.trouble(&LIMIT, 0.0, false);
            if course.surely_follows(&curve, &LIMIT).unwrap() {
                sure += 1;
                assert_eq!(trouble, None, "case {case}");
            } else if trouble.is_some() {
                refused += 1;
            } else {
                fine += 1;
            }
        }
        // It settles most, and there is something to refuse.
        assert!(sure > 2 * fine && refused > 50, "{sure} sure, {fine} measured and fine, {refused} refused");
    }
}
