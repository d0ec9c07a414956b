//! How far two edges are from one another at a place, and how the surfaces lie there: by the places that are nearest, not by parameters.

use loftsman_kernel::error::Result;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::topology::{EdgeCurve, TOGETHER};
use loftsman_kernel::{Point, Vector};

use crate::contact::{Contact, Frame, Measured};

/// The most steps to a nearest place, and halvings of one.
const STEPS: usize = 12;
/// Newton's step is taken where the distance bends up by more than this part of what it would along a straight line.
const BENDS: f64 = 0.1;

/// A place between those where anything is imposed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Place {
    /// Where on both edges, by the first one's parameter.
    pub(crate) t: f64,
    pub(crate) point: Point,
    /// The other edge's own parameter there.
    pub(crate) u: f64,
    pub(crate) contact: Contact,
}

/// Both edges as they are, for the places of them that are nearest to one another.
pub(crate) struct Near<'a> {
    other: &'a dyn Shape,
    there: Foot,
    /// The shape that moves.
    on: usize,
    own: Foot,
    /// The edge that stands still, for its places.
    edge: EdgeCurve,
    /// Places of the edges that are no further apart are at one another.
    apart: f64,
}

/// What lies where.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    /// From the edge that stands still to the one that moves: of the ways from a place of each to the nearest one of the other, the longer.
    pub(crate) apart: Vector,
    pub(crate) measured: Measured,
}

impl<'a> Near<'a> {
    /// Of the edge `there` of the surface `other`, and of shape `on`'s edge `own`.
    ///
    /// # Errors
    /// When numbers overflow.
    pub(crate) fn new(
        other: &'a dyn Shape,
        there: EdgeCurve,
        on: usize,
        own: EdgeCurve,
        apart: f64,
    ) -> Result<Self> {
        let edge = there.clone();
        Ok(Self { other, there: Foot::new(there.curve)?, on, own: Foot::new(own.curve)?, edge, apart })
    }

    /// How far the edges are apart at a place of both: the place of each that is nearest to that of the other (a descent from there: no
    /// nearer one is beside it), and how the surface lies to the other one where that is.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn measure(&self, shapes: &Shapes<'_>, place: &Place) -> Result<Found> {
        let shape = shapes.get(self.on)?;
        let at = Point::from(shape.value(place.contact.at, Derivative::POSITION)?);
        let apart = at - place.point;
        if apart.norm() <= self.apart {
            return Ok(Found { apart, measured: place.contact.measure(shape)? });
        }
        let (u, here) = self.there.of(place.u, &at)?;
        let (_, back) = self.own.of(place.t, &place.point)?;
        let apart = if back.norm() > here.norm() { back } else { -here };
        let measured = match Frame::new(self.other, &self.edge.edge, u) {
            Ok(frame) => place.contact.beside(frame).measure(shape)?,
            // A pole that is nearer tells nothing.
            Err(_) => place.contact.measure(shape)?,
        };
        Ok(Found { apart, measured })
    }
}

/// A curve whose nearest places are looked for.
struct Foot {
    curve: Curve,
    /// Whether it ends where it begins, so that there is no end to stop at.
    closed: bool,
}

impl Foot {
    fn new(curve: Curve) -> Result<Self> {
        let (a, b) = curve.domain();
        let start = curve.point(a)?;
        let spread = curve.points().iter().map(|p| (p - start).norm()).fold(0.0, f64::max);
        let closed = curve.is_periodic() || (curve.point(b)? - start).norm() <= TOGETHER * spread;
        Ok(Self { curve, closed })
    }

    /// The parameter near to `u` where the curve is nearest to a point, and the way from the point to it: Newton's steps for the squared distance, or
    /// along the tangent where that does not bend up, each halved until it comes nearer.
    fn of(&self, mut u: f64, point: &Point) -> Result<(f64, Vector)> {
        let (a, b) = self.curve.domain();
        let inside = |u: f64| match u {
            u if self.closed && u < a => (u + (b - a)).clamp(a, b),
            u if self.closed && u > b => (u - (b - a)).clamp(a, b),
            u => u.clamp(a, b),
        };
        let mut from = self.curve.point(u)? - point;
        for _ in 0..STEPS {
            let (tangent, second) = (self.curve.derivative(u, 1)?, self.curve.derivative(u, 2)?);
            let straight = tangent.norm_squared();
            let bent = straight + from.dot(&second);
            let step = from.dot(&tangent) / if bent > BENDS * straight { bent } else { straight };
            let nearer = (0..STEPS as i32).find_map(|half| {
                let next = inside(u - step * 0.5_f64.powi(half));
                let now = self.curve.point(next).ok()? - point;
                (now.norm() < from.norm()).then_some((next, now))
            });
            let Some((next, now)) = nearer else { break };
            let done = (next - u).abs() <= 1e-9 * (b - a);
            (u, from) = (next, now);
            if done {
                break;
            }
        }
        Ok((u, from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_foot_of_a_circle_is_on_the_ray_to_its_middle() {
        let circle = Foot::new(Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap()).unwrap();
        assert!(circle.closed);
        // Beyond the seam as well.
        for (degrees, from) in
            [(3.0, 20.0), (50.0, 70.0), (130.0, 150.0), (275.0, 295.0), (350.0, 10.0), (10.0, 350.0)]
        {
            let (s, c) = f64::to_radians(degrees).sin_cos();
            let (at, way) = circle.of(f64::to_radians(from), &Point::new(2.3 * c, 2.3 * s, 0.4)).unwrap();
            let found = circle.curve.point(at).unwrap();
            assert!((found - Point::new(2.0 * c, 2.0 * s, 0.0)).norm() < 1e-7, "{degrees}: {found}");
            assert!((way.norm() - 0.5).abs() < 1e-9, "{degrees}: {way}");
        }
    }
}
