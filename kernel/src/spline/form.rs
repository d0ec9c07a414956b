//! What curves, and surfaces of a Brep, are beside splines: lines, circles, planes, cylinders and their like.

mod patch;
mod piece;
mod swept;

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Matrix4};

use crate::error::{Error, Result};
use crate::{Point, Vector};

pub use patch::SurfacePiece;
pub use piece::CurvePiece;

/// A place and two directions at right angles: where an elementary curve or surface is. All of unit length; `y = z × x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The centre, or a point of the axis or plane.
    pub origin: Point,
    /// The direction from which angles count.
    pub x: Vector,
    /// The axis, or the normal of the plane.
    pub z: Vector,
}

impl Frame {
    /// The frame with axis `z` whose `x` is the part of `toward` across it; where `toward` says nothing of that (it is zero or
    /// along the axis), the coordinate axis most across `z` is taken instead. `None` where `z` has no direction or a number is
    /// not finite.
    pub fn new(origin: Point, z: Vector, toward: Vector) -> Option<Self> {
        let finite = |v: &Vector| v.iter().all(|c| c.is_finite());
        if !(finite(&origin.coords) && finite(&z) && finite(&toward)) {
            return None;
        }
        let z = direction(&z)?;
        // What is at right angles to rounding stays to the bit, so that a frame of a frame's own directions is the same.
        let part = |v: Vector| {
            let lean = z.dot(&v);
            if lean.abs() <= ROUNDING { v } else { v - z * lean }
        };
        let across = |v: Vector| {
            let part = part(direction(&v)?);
            if part.norm() > 1e-9 { direction(&part) } else { None }
        };
        let x = across(toward).or_else(|| across(Vector::ith(z.iamin(), 1.0)))?;
        // Once more: where the two were nearly along one another, the first part kept some of `z`.
        let x = direction(&part(x))?;
        Some(Self { origin, x, z })
    }

    /// The third direction, `z × x`.
    pub fn y(&self) -> Vector {
        self.z.cross(&self.x)
    }

    /// The frame moved by a map that keeps angles: `linear` is `s R`, with or without a mirror.
    fn moved(&self, origin: Point, linear: &Matrix3<f64>) -> Option<Self> {
        Self::new(origin, linear * self.z, linear * self.x)
    }
}

/// So far from 1 is the square of a length of 1 whose coordinates are rounded, and from 0 the product of two directions at right angles.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A vector of unit length, whatever its own is; one of unit length stays as it is.
fn direction(v: &Vector) -> Option<Vector> {
    if (v.norm_squared() - 1.0).abs() <= ROUNDING {
        return Some(*v);
    }
    let largest = v.amax();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    (v / largest).try_normalize(0.0)
}

/// Which set of points the spline of an edge, or a [curve by itself](crate::spline::Curve::with_form), is a part of. A spline of another form
/// than [`Spline`](Self::Spline) is exactly (to rounding) on it; programs that know the form are told it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum CurveForm {
    /// None but its own.
    #[default]
    Spline,
    /// The straight line through its ends.
    Line,
    /// A circle about the frame's axis.
    Circle {
        /// Its centre and plane.
        frame: Frame,
        /// Its radius.
        radius: f64,
    },
    /// An ellipse, its half diameters along the frame's `x` and `y`.
    Ellipse {
        /// Its centre and plane.
        frame: Frame,
        /// The half diameters.
        radii: [f64; 2],
    },
    /// The parabola `origin + f t² x + 2 f t y`.
    Parabola {
        /// Its vertex, its axis `x` and its plane.
        frame: Frame,
        /// The focal length `f`.
        focal: f64,
    },
    /// The branch `origin + a cosh t x + b sinh t y` of a hyperbola.
    Hyperbola {
        /// Its centre, its axis `x` and its plane.
        frame: Frame,
        /// The half diameters `a` and `b`.
        radii: [f64; 2],
    },
}

/// Which set of points the spline of a face, or a [surface by itself](crate::spline::Surface::with_form), is a part of, as [`CurveForm`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum SurfaceForm {
    /// None but its own.
    #[default]
    Spline,
    /// The plane of the frame's `x` and `y`.
    Plane {
        /// Where it is.
        frame: Frame,
    },
    /// A circular cylinder about the frame's axis.
    Cylinder {
        /// Its axis.
        frame: Frame,
        /// Its radius.
        radius: f64,
    },
    /// A circular cone about the frame's axis: its radius at height `h` is `radius + h tan angle`.
    Cone {
        /// Its axis, from where the radius is taken.
        frame: Frame,
        /// The radius at the frame's origin; it may be 0.
        radius: f64,
        /// Half the opening angle, in radians, more than 0 and less than a quarter turn.
        angle: f64,
    },
    /// A sphere.
    Sphere {
        /// Its centre, and the axis of its poles.
        frame: Frame,
        /// Its radius.
        radius: f64,
    },
    /// A torus about the frame's axis.
    Torus {
        /// Its centre and axis.
        frame: Frame,
        /// From the centre to the middle of the tube.
        major: f64,
        /// The radius of the tube.
        minor: f64,
    },
    /// A curve along a vector: `u` runs along the curve, `v` along the vector.
    Extrusion {
        /// The vector.
        along: Vector,
        /// What the curve is beside a spline, at any place along the vector. Of one that is no more the surface has it, where `v` stands still.
        profile: CurveForm,
    },
    /// A curve turned about an axis: `u` runs around, `v` along the curve.
    Revolution {
        /// The axis `z` through its origin; `x` matters not.
        frame: Frame,
        /// What the curve where `u` starts is beside a spline.
        profile: CurveForm,
    },
}

impl Frame {
    /// How far directions may be from unit length and right angles: files write them with nine digits or fewer.
    const SQUARE: f64 = 1e-6;

    fn check(&self) -> Result<()> {
        let numbers = self.origin.iter().chain(self.x.iter()).chain(self.z.iter());
        let off = (self.x.norm_squared() - 1.0)
            .abs()
            .max((self.z.norm_squared() - 1.0).abs())
            .max(self.x.dot(&self.z).abs());
        if numbers.copied().all(f64::is_finite) && off <= Self::SQUARE {
            return Ok(());
        }
        Err(Error::Invalid(format!(
            "the frame at {:?} with x {:?} and z {:?} is none: x and z must be of length 1 and at right angles",
            self.origin.coords.as_slice(),
            self.x.as_slice(),
            self.z.as_slice()
        )))
    }
}

/// That these are lengths.
fn sizes<const N: usize>(sizes: [f64; N]) -> Result<()> {
    match sizes.into_iter().find(|size| !(*size > 0.0 && size.is_finite())) {
        None => Ok(()),
        Some(size) => Err(Error::Invalid(format!("a radius of {size} is no size: it must be positive"))),
    }
}

impl CurveForm {
    /// That its numbers can be.
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            Self::Spline | Self::Line => Ok(()),
            Self::Circle { frame, radius } => frame.check().and_then(|()| sizes([*radius])),
            Self::Ellipse { frame, radii } | Self::Hyperbola { frame, radii } => {
                frame.check().and_then(|()| sizes(*radii))
            }
            Self::Parabola { frame, focal } => frame.check().and_then(|()| sizes([*focal])),
        }
    }
}

impl SurfaceForm {
    /// That its numbers can be.
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            Self::Spline => Ok(()),
            Self::Plane { frame } => frame.check(),
            Self::Cylinder { frame, radius } | Self::Sphere { frame, radius } => {
                frame.check().and_then(|()| sizes([*radius]))
            }
            Self::Torus { frame, major, minor } => frame.check().and_then(|()| sizes([*major, *minor])),
            Self::Revolution { frame, profile } => frame.check().and_then(|()| profile.check()),
            Self::Extrusion { along, profile } => {
                if direction(along).is_none() {
                    let along = along.as_slice();
                    return Err(Error::Invalid(format!(
                        "an extrusion along {along:?}: the vector has no direction"
                    )));
                }
                profile.check()
            }
            Self::Cone { frame, radius, angle } => {
                frame.check()?;
                if *radius >= 0.0 && radius.is_finite() && *angle > 0.0 && *angle < FRAC_PI_2 {
                    return Ok(());
                }
                Err(Error::Invalid(format!(
                    "a cone of radius {radius} and half angle {angle}: the radius must be 0 or more and the angle between 0 and a quarter turn"
                )))
            }
        }
    }
}

/// An affine map on a point: `A p + t`.
pub(crate) fn affine(map: &Matrix4<f64>, p: &Point) -> Point {
    let row = |i: usize| map[(i, 0)] * p.x + map[(i, 1)] * p.y + map[(i, 2)] * p.z + map[(i, 3)];
    Point::new(row(0), row(1), row(2))
}

/// A map `p → A p + t` that keeps angles, and by what it stretches.
pub(crate) struct Similarity<'m> {
    linear: &'m Matrix3<f64>,
    shift: Vector,
    /// The factor of lengths.
    scale: f64,
}

impl<'m> Similarity<'m> {
    /// `None` where the map does not keep angles to within some rounding.
    pub(crate) fn of(linear: &'m Matrix3<f64>, shift: Vector) -> Option<Self> {
        let largest = linear.amax();
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        let unit = linear / largest;
        let squared = unit.transpose() * unit;
        let size = squared.trace() / 3.0;
        let off = (squared - Matrix3::identity() * size).amax();
        (off <= 1e-13 * size).then(|| Self { linear, shift, scale: largest * size.sqrt() })
    }

    /// By what it multiplies lengths.
    fn scale(&self) -> f64 {
        self.scale
    }

    fn frame(&self, frame: &Frame) -> Option<Frame> {
        frame.moved(Point::from(self.linear * frame.origin.coords + self.shift), self.linear)
    }
}

impl CurveForm {
    /// The form of the curve moved; [`Spline`](Self::Spline) where `map` is none that keeps it.
    pub(crate) fn moved(&self, map: Option<&Similarity<'_>>) -> Self {
        let moved = |form: &Self| {
            let map = map?;
            Some(match form {
                Self::Spline | Self::Line => *form,
                Self::Circle { frame, radius } => {
                    Self::Circle { frame: map.frame(frame)?, radius: radius * map.scale }
                }
                Self::Ellipse { frame, radii } => {
                    Self::Ellipse { frame: map.frame(frame)?, radii: radii.map(|r| r * map.scale) }
                }
                Self::Parabola { frame, focal } => {
                    Self::Parabola { frame: map.frame(frame)?, focal: focal * map.scale }
                }
                Self::Hyperbola { frame, radii } => {
                    Self::Hyperbola { frame: map.frame(frame)?, radii: radii.map(|r| r * map.scale) }
                }
            })
        };
        match self {
            Self::Line => Self::Line,
            form => moved(form).unwrap_or_default(),
        }
    }

    /// What it is called in documents: `"spline"`, `"line"`, `"circle"`, `"ellipse"`, `"parabola"`, `"hyperbola"`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Spline => "spline",
            Self::Line => "line",
            Self::Circle { .. } => "circle",
            Self::Ellipse { .. } => "ellipse",
            Self::Parabola { .. } => "parabola",
            Self::Hyperbola { .. } => "hyperbola",
        }
    }
}

impl SurfaceForm {
    /// The form at a distance along its normal, which points outwards (of a plane along `z`): another of its kind. `None` where nothing of it is left, and
    /// of a [spline](Self::Spline) and of swept curves, whose offsets are none ([`Surface::offset`](crate::spline::Surface::offset)).
    pub fn offset(&self, by: f64) -> Option<Self> {
        let positive = |radius: f64| (radius > 0.0).then_some(radius);
        Some(match *self {
            Self::Spline | Self::Extrusion { .. } | Self::Revolution { .. } => return None,
            Self::Plane { mut frame } => {
                frame.origin += frame.z * by;
                Self::Plane { frame }
            }
            Self::Cylinder { frame, radius } => Self::Cylinder { frame, radius: positive(radius + by)? },
            Self::Cone { mut frame, radius, angle } => {
                // Along the axis, the sine of the angle the other way; outwards, the cosine.
                frame.origin -= frame.z * (by * angle.sin());
                let radius = radius + by * angle.cos();
                if radius < 0.0 {
                    return None;
                }
                Self::Cone { frame, radius, angle }
            }
            Self::Sphere { frame, radius } => Self::Sphere { frame, radius: positive(radius + by)? },
            Self::Torus { frame, major, minor } => Self::Torus { frame, major, minor: positive(minor + by)? },
        })
    }

    /// The form of the surface moved; [`Spline`](Self::Spline) where `map` is none that keeps it.
    pub(crate) fn moved(&self, map: Option<&Similarity<'_>>) -> Self {
        let moved = || {
            let map = map?;
            let frame = |frame: &Frame| map.frame(frame);
            let by = map.scale;
            Some(match self {
                Self::Spline => Self::Spline,
                Self::Plane { frame: f } => Self::Plane { frame: frame(f)? },
                Self::Cylinder { frame: f, radius } => {
                    Self::Cylinder { frame: frame(f)?, radius: radius * by }
                }
                Self::Cone { frame: f, radius, angle } => {
                    Self::Cone { frame: frame(f)?, radius: radius * by, angle: *angle }
                }
                Self::Sphere { frame: f, radius } => Self::Sphere { frame: frame(f)?, radius: radius * by },
                Self::Torus { frame: f, major, minor } => {
                    Self::Torus { frame: frame(f)?, major: major * by, minor: minor * by }
                }
                Self::Extrusion { along, profile } => {
                    Self::Extrusion { along: map.linear * along, profile: profile.moved(Some(map)) }
                }
                Self::Revolution { frame: f, profile } => {
                    Self::Revolution { frame: frame(f)?, profile: profile.moved(Some(map)) }
                }
            })
        };
        moved().unwrap_or_default()
    }

    /// What it is called in documents: `"spline"`, `"plane"`, `"cylinder"`, `"cone"`, `"sphere"`, `"torus"`, `"extrusion"`, `"revolution"`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Spline => "spline",
            Self::Plane { .. } => "plane",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Extrusion { .. } => "extrusion",
            Self::Revolution { .. } => "revolution",
        }
    }
}
