//! Where the edge that stands still is nearest to a place of the edge that moves.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::topology::EdgeCurve;

use crate::contact::{Contact, Frame, Measured};

/// The most steps to a nearest place, and halvings of one.
const STEPS: usize = 12;

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

/// The edge that stands still, for the places of it that are nearest.
pub(crate) struct Near<'a> {
    other: &'a dyn Shape,
    there: EdgeCurve,
    /// The shape that moves.
    on: usize,
    /// Places of the edges that are no further apart are at one another.
    apart: f64,
}

impl<'a> Near<'a> {
    pub(crate) fn new(other: &'a dyn Shape, there: EdgeCurve, on: usize, apart: f64) -> Self {
        Self { other, there, on, apart }
    }

    /// The worse of how the surface lies to the other one beside a place, by the parameters, and where that one's edge is nearest to it.
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn measure(&self, shapes: &Shapes<'_>, place: &Place, at: &Point) -> Result<Measured> {
        let shape = shapes.get(self.on)?;
        let found = place.contact.measure(shape)?;
        if (at - place.point).norm() <= self.apart {
            return Ok(found);
        }
        let u = foot(&self.there.curve, place.u, at)?;
        // A pole that is nearer tells nothing.
        let Ok(frame) = Frame::new(self.other, &self.there.edge, u) else { return Ok(found) };
        let near = place.contact.beside(frame).measure(shape)?;
        let worse = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        Ok(Measured {
            angle: found.angle.max(near.angle),
            curvature: worse(found.curvature, near.curvature),
            ..found
        })
    }
}

/// The parameter of a curve near to `u` where it is nearest to a point: steps along its tangent, each shortened until it comes nearer.
fn foot(curve: &Curve, mut u: f64, point: &Point) -> Result<f64> {
    let (a, b) = curve.domain();
    let mut from = curve.point(u)? - point;
    for _ in 0..STEPS {
        let tangent = curve.derivative(u, 1)?;
        let step = from.dot(&tangent) / tangent.norm_squared();
        let nearer = (0..STEPS as i32).find_map(|half| {
            let next = (u - step * 0.5_f64.powi(half)).clamp(a, b);
            let now = curve.point(next).ok()? - point;
            (now.norm() < from.norm()).then_some((next, now))
        });
        let Some((next, now)) = nearer else { break };
        let done = (next - u).abs() <= 1e-9 * (b - a);
        (u, from) = (next, now);
        if done {
            break;
        }
    }
    Ok(u)
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Vector;

    use super::*;

    #[test]
    fn the_foot_of_a_circle_is_on_the_ray_to_its_middle() {
        let circle = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
        for degrees in [3.0_f64, 50.0, 130.0, 275.0] {
            let (s, c) = degrees.to_radians().sin_cos();
            let near = (degrees + 20.0).to_radians().min(6.2);
            let at = foot(&circle, near, &Point::new(2.3 * c, 2.3 * s, 0.4)).unwrap();
            let found = circle.point(at).unwrap();
            assert!((found - Point::new(2.0 * c, 2.0 * s, 0.0)).norm() < 1e-7, "{degrees}: {found}");
        }
    }
}
