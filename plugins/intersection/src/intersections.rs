//! The answer to "where does a curve meet something", and how sure it is.

use loftsman_kernel::shape::Location;
use loftsman_kernel::{Point, Vector};

/// How near is near enough.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Two points no further apart than this count as one: a length. `None`: 1e-9 of the size of the shapes together.
    pub tolerance: Option<f64>,
}

impl Options {
    /// With a tolerance of one's own.
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance) }
    }
}

/// How two shapes meet at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// They pass through one another: the curve comes from one side and goes to the other, at an angle or running along it there, or their
    /// directions differ. Where one of them ends on the other, these differ.
    Crossing,
    /// They run along one another there, as far as the tolerance tells (a touching, or crossings too near to tell apart), or one has a
    /// corner there, and the curve stays on one side of the other.
    Touching,
}

/// A point where a curve meets another shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// The curve's parameter.
    pub at: f64,
    /// Where on the other shape; `None` where that is a plane.
    pub with: Option<Location>,
    /// The curve's point.
    pub point: Point,
    /// How far the other shape's point is from it, measured on the shapes.
    pub distance: f64,
    /// How they meet.
    pub contact: Contact,
}

/// A part of a curve that runs together with another shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Where it starts and ends: the curve's parameters.
    pub range: (f64, f64),
    /// The other shape's locations there; `None` where that is a plane.
    pub with: Option<[Location; 2]>,
    /// The curve's points there.
    pub points: [Point; 2],
    /// The largest distance that was measured along it.
    pub distance: f64,
}

/// A part of a curve where the search was given up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undecided {
    /// The curve's parameters.
    pub range: (f64, f64),
    /// A point of it.
    pub near: Point,
}

/// All meetings of a curve with another shape, along the curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intersections {
    /// The points.
    pub meetings: Vec<Meeting>,
    /// The parts that run together; no point of them is among the meetings.
    pub overlaps: Vec<Overlap>,
    /// What could not be decided: where this is empty, every pair of pieces was shown to be apart or to meet once, but for what is
    /// closer together than the tolerance, or to an overlap than that. Bounds are computed in floating point, without directed rounding.
    pub undecided: Vec<Undecided>,
    /// The tolerance that was used.
    pub tolerance: f64,
}

impl Intersections {
    /// Whether all was settled: every part of the curve was shown to have what is listed and nothing else.
    pub fn is_complete(&self) -> bool {
        self.undecided.is_empty()
    }

    /// The largest distance left at a meeting or along an overlap.
    pub fn distance(&self) -> f64 {
        let all = self.meetings.iter().map(|m| m.distance).chain(self.overlaps.iter().map(|o| o.distance));
        all.fold(0.0, f64::max)
    }
}

/// A plane through a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    point: Point,
    normal: Vector,
}

impl Plane {
    /// The plane through a point, with a normal of any length.
    ///
    /// # Errors
    /// When a number is not finite or the normal has no direction.
    pub fn new(point: Point, normal: Vector) -> crate::Result<Self> {
        use crate::IntersectionError::Plane as Bad;
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Bad("point"));
        }
        let largest = normal.amax();
        if !normal.iter().all(|x| x.is_finite()) || largest == 0.0 {
            return Err(Bad("normal"));
        }
        Ok(Self { point, normal: (normal / largest).normalize() })
    }

    /// The point it was made through.
    pub fn point(&self) -> Point {
        self.point
    }

    /// Its unit normal.
    pub fn normal(&self) -> Vector {
        self.normal
    }

    /// The signed distance of a point: positive on the normal's side.
    pub fn distance(&self, point: &Point) -> f64 {
        (point - self.point).dot(&self.normal)
    }
}
