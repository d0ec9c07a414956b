//! Elementary surfaces by their parameters, as the schema has them, and rectangles of these.

use std::f64::consts::{FRAC_PI_2, TAU};

use loftsman_kernel::brep::SurfaceForm;
use loftsman_kernel::spline::{Curve, Direction, Surface};
use loftsman_kernel::{Error, Point, Result};

/// A rectangle of an elementary surface, `u` and `v` from the first to the second; without one in a direction where the surface
/// closes, all around.
pub(crate) fn rectangle(form: &SurfaceForm, [u, v]: [Option<[f64; 2]>; 2]) -> Result<Surface> {
    let unbounded = || Error::Invalid(format!("a {} without ends", form.name()));
    let around = u.unwrap_or([0.0, TAU]);
    let line = |at: &dyn Fn(f64) -> Point| {
        let [low, high] = v.ok_or_else(unbounded)?;
        Curve::line(at(low), at(high))?.reparametrise(low, high)
    };
    match *form {
        SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
            Err(unbounded())
        }
        SurfaceForm::Plane { frame } => {
            let ([a, b], [c, d]) = (u.ok_or_else(unbounded)?, v.ok_or_else(unbounded)?);
            let at = |x: f64, y: f64| frame.origin + frame.x * x + frame.y() * y;
            let side = Curve::line(at(a, c), at(b, c))?.reparametrise(a, b)?;
            Surface::extrusion(&side, frame.y() * (d - c))?.reparametrise(Direction::V, c, d)
        }
        SurfaceForm::Cylinder { frame, radius } => {
            let profile = line(&|h| frame.origin + frame.x * radius + frame.z * h)?;
            turned(&profile, &frame, around)
        }
        SurfaceForm::Cone { frame, radius, angle } => {
            // Along a cone `v` is the height over the circle of its radius.
            let profile = line(&|h| frame.origin + frame.x * (radius + h * angle.tan()) + frame.z * h)?;
            turned(&profile, &frame, around)
        }
        SurfaceForm::Sphere { frame, radius } => {
            let [low, high] = v.unwrap_or([-FRAC_PI_2, FRAC_PI_2]);
            let profile =
                Curve::elliptic_arc(frame.origin, frame.x * radius, frame.z * radius, low, high - low)?;
            turned(&profile, &frame, around)
        }
        SurfaceForm::Torus { frame, major, minor } => {
            let [low, high] = v.unwrap_or([0.0, TAU]);
            let center = frame.origin + frame.x * major;
            let profile = Curve::elliptic_arc(center, frame.x * minor, frame.z * minor, low, high - low)?;
            turned(&profile, &frame, around)
        }
    }
}

/// A profile in the half plane of the frame's `x`, turned from one angle to another.
fn turned(profile: &Curve, frame: &loftsman_kernel::brep::Frame, [from, to]: [f64; 2]) -> Result<Surface> {
    let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_unchecked(frame.z), from);
    let (space, points, weights) = profile.clone().into_parts();
    let points = points.iter().map(|p| frame.origin + turn * (p - frame.origin)).collect();
    let start = Curve::build(space, points, weights)?;
    Surface::revolution(&start, frame.origin, frame.z, to - from)
}
