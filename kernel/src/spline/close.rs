//! Closed shapes made periodic.

use super::conversion::Direction;
use super::space::Space;
use super::{Curve, Surface};
use crate::Point;
use crate::error::{Error, Result};
use crate::text::figure;

/// What closing gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed<T> {
    /// The periodic shape, over the same domain.
    pub shape: T,
    /// How smoothly it closes: the degree less the multiplicity of the seam's knot. A rational shape may be smoother
    /// than that, since its homogeneous coordinates are what counts here.
    pub continuity: usize,
    /// No point has moved further than this.
    pub deviation: f64,
}

impl Curve {
    /// The periodic curve of a curve that ends where it starts, with the seam's knot as simple as the curve is
    /// smooth there: a seam of continuity `C^(p-1)` leaves no trace. `tolerance` bounds how far any point may move, a
    /// length in the unit of the points. The inverse of [`to_clamped`](Self::to_clamped).
    ///
    /// A periodic curve is returned as it is.
    ///
    /// ```
    /// use loftsman_kernel::{Point, spline::{Curve, Space}};
    /// let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    /// let ring = Curve::new(Space::periodic_uniform(3, 6)?, points)?;
    /// let closed = ring.to_clamped()?.to_periodic(1e-12)?;
    /// assert_eq!((closed.shape.space(), closed.continuity), (ring.space(), 2));
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When the ends are further apart than twice the tolerance, their weights differ by more than 1e-9 of
    /// themselves, the curve is torn or has too few vertices, or the tolerance is negative or not a number.
    pub fn to_periodic(&self, tolerance: f64) -> Result<Closed<Self>> {
        if self.is_periodic() {
            return Ok(closed(self.clone(), self.space(), 0.0));
        }
        let clamped = self.to_clamped()?;
        let net = close(clamped.space(), clamped.points(), clamped.weights(), 1, 1, tolerance)?;
        let seam = net.space.domain().0;
        let removal = Self::build(net.space, net.points, net.weights)?.remove_copies(
            seam,
            usize::MAX,
            tolerance - net.moved,
        )?;
        let space = removal.shape.space().clone();
        Ok(closed(removal.shape, &space, net.moved + removal.deviation))
    }
}

impl Surface {
    /// The surface made periodic in a direction in which it closes; see [`Curve::to_periodic`].
    ///
    /// # Errors
    /// As for [`Curve::to_periodic`].
    pub fn to_periodic(&self, direction: Direction, tolerance: f64) -> Result<Closed<Self>> {
        if self.space(direction).is_periodic() {
            return Ok(closed(self.clone(), self.space(direction), 0.0));
        }
        let clamped = self.convert(direction, &self.space(direction).clamping()?)?;
        let (outer, inner) = match direction {
            Direction::U => (1, self.v().len()),
            Direction::V => (self.u().len(), 1),
        };
        let space = clamped.space(direction);
        let net = close(space, clamped.points(), clamped.weights(), outer, inner, tolerance)?;
        let seam = net.space.domain().0;
        let shape = match direction {
            Direction::U => Self::build(net.space, self.v().clone(), net.points, net.weights)?,
            Direction::V => Self::build(self.u().clone(), net.space, net.points, net.weights)?,
        };
        let removal = shape.remove_copies(direction, seam, usize::MAX, tolerance - net.moved)?;
        let space = removal.shape.space(direction).clone();
        Ok(closed(removal.shape, &space, net.moved + removal.deviation))
    }
}

fn closed<T>(shape: T, space: &Space, deviation: f64) -> Closed<T> {
    Closed {
        shape,
        continuity: space.degree() - space.multiplicity(space.domain().0).min(space.degree()),
        deviation,
    }
}

/// A control net whose last vertices along a direction have become its first ones.
struct ClosedNet {
    space: Space,
    points: Vec<Point>,
    weights: Option<Vec<f64>>,
    /// How far the ends moved to meet.
    moved: f64,
}

/// Joins the end of a clamped space to its start, the knot there repeated `p` times.
fn close(
    space: &Space,
    points: &[Point],
    weights: Option<&[f64]>,
    outer: usize,
    inner: usize,
    tolerance: f64,
) -> Result<ClosedNet> {
    if tolerance.is_nan() || tolerance < 0.0 {
        return Err(Error::Invalid(format!(
            "the tolerance {tolerance} is no length: give zero or a positive number"
        )));
    }
    let n = space.len();
    let mut net = ClosedNet {
        // Vertex 0 meets vertex n - 1, so the first of the period is vertex 1, whose support starts at knot 1.
        space: Space::periodic(space.degree(), space.flat()[1..=n].to_vec())?,
        points: Vec::with_capacity(points.len()),
        weights: weights.map(|w| Vec::with_capacity(w.len())),
        moved: 0.0,
    };
    for o in 0..outer {
        for k in 1..n {
            for c in 0..inner {
                let at = |k: usize| (o * n + k) * inner + c;
                let mut point = points[at(k)];
                if k == n - 1 {
                    let half = 0.5 * (points[at(0)] - point);
                    net.moved = net.moved.max(half.norm());
                    point += half;
                    if let Some(w) = weights.filter(|w| (w[at(0)] - w[at(k)]).abs() > 1e-9 * w[at(k)]) {
                        return Err(Error::Invalid(format!(
                            "the shape starts with weight {} and ends with weight {}: make them equal to close it",
                            w[at(0)],
                            w[at(k)]
                        )));
                    }
                }
                net.points.push(point);
                if let (Some(all), Some(w)) = (&mut net.weights, weights) {
                    all.push(w[at(k)]);
                }
            }
        }
    }
    if net.moved > tolerance {
        return Err(Error::Invalid(format!(
            "the ends are {} apart and cannot meet within the tolerance {}: move them together, or raise it",
            figure(2.0 * net.moved),
            figure(tolerance)
        )));
    }
    Ok(net)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, assert_same_surface, line_of};
    use super::*;
    use crate::Vector;

    proptest! {
        #[test]
        fn opened_and_closed_again(curve in any_curve()) {
            prop_assume!(curve.is_periodic() && curve.degree() <= 5);
            let closed = curve.to_clamped().unwrap().to_periodic(1e-10).unwrap();
            prop_assert!(closed.deviation <= 1e-10);
            prop_assert_eq!(closed.shape.space().len(), curve.space().len());
            prop_assert_eq!(closed.shape.domain(), curve.domain());
            assert_same_curve(&curve, &closed.shape, 1e-10);
            let seam = curve.domain().0;
            prop_assert_eq!(closed.continuity, curve.degree() - curve.space().multiplicity(seam));
        }

        #[test]
        fn surfaces_too(surface in any_surface()) {
            for direction in [Direction::U, Direction::V] {
                if !surface.space(direction).is_periodic() {
                    continue;
                }
                let open = surface.to_clamped().unwrap();
                let closed = open.to_periodic(direction, 1e-9).unwrap();
                prop_assert_eq!(closed.shape.space(direction).len(), surface.space(direction).len());
                assert_same_surface(&surface, &closed.shape, 1e-10);
            }
        }
    }

    #[test]
    fn a_circle_closes_exactly() {
        let circle = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
        let closed = circle.to_periodic(0.0).unwrap();
        assert_eq!((closed.shape.points().len(), closed.deviation), (8, 0.0));
        assert_same_curve(&circle, &closed.shape, 1e-15);
    }

    #[test]
    fn what_does_not_close_is_refused() {
        let curve = line_of(3, 9);
        assert!(curve.to_periodic(1.0).is_err());
        assert!(curve.to_periodic(f64::NAN).is_err());
        assert!(Curve::line(Point::origin(), Point::origin()).unwrap().to_periodic(1.0).is_err());
        let (space, points, _) = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap().into_parts();
        let mut weights = vec![1.0; 9];
        weights[0] = 2.0;
        assert!(Curve::rational(space, points, weights).unwrap().to_periodic(1e-3).is_err());
    }
}
