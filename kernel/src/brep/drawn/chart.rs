//! The parameters of a surface, angles and lengths on an elementary one, at points and back.

use std::f64::consts::{PI, TAU};

use crate::Point;
use crate::brep::{Frame, SurfaceForm};
use crate::error::Result;
use crate::spline::{ParameterSide, Surface};

/// Points nearer to a pole than this part of the size have no parameter around it.
const POLE: f64 = 1e-7;
/// How far beyond the domain of a spline a parameter may be, as a part of it: what is within its tolerance of an end is on it.
const SLACK: f64 = 1e-6;

/// A surface that closes, by the parameters that belong to its form.
///
/// Of a cylinder, a cone, a sphere and a torus `u` is the angle about the axis from the frame's `x` on, and `v` the height along the axis (of a cone, too: its
/// parameter is not the way along the line), the latitude, the angle about the tube from outside, in radians; of a spline they are its own.
pub(super) enum Chart<'s> {
    /// An elementary surface, and the size of what is on it.
    Form(&'s SurfaceForm, f64),
    /// A spline and what it does at its ends.
    Spline(&'s Surface, [ParameterSide; 2]),
}

/// An angle within half a turn of another.
fn beside(angle: f64, other: f64) -> f64 {
    other + (angle - other + PI).rem_euclid(TAU) - PI
}

impl<'s> Chart<'s> {
    /// That of an elementary surface which closes; `None` of a plane and of what is none.
    pub(super) fn of_form(form: &'s SurfaceForm, size: f64) -> Option<Self> {
        let closes = matches!(
            form,
            SurfaceForm::Cylinder { .. }
                | SurfaceForm::Cone { .. }
                | SurfaceForm::Sphere { .. }
                | SurfaceForm::Torus { .. }
        );
        closes.then_some(Self::Form(form, size))
    }

    /// That of a spline which closes, within a distance; `None` of one that does not.
    pub(super) fn of_spline(surface: &'s Surface, within: f64) -> Result<Option<Self>> {
        let sides = surface.parameter_sides(within)?;
        Ok(sides.iter().any(|side| side.closed).then_some(Self::Spline(surface, sides)))
    }

    /// By how much each parameter grows once around; `None` where the surface does not close.
    pub(super) fn turns(&self) -> [Option<f64>; 2] {
        match self {
            Self::Form(SurfaceForm::Torus { .. }, _) => [Some(TAU); 2],
            Self::Form(..) => [Some(TAU), None],
            Self::Spline(_, sides) => sides.map(|side| side.closed.then(|| side.length())),
        }
    }

    /// Where, between two values of a parameter, the surface is not as smooth as elsewhere: the knots of a spline.
    pub(super) fn rough(&self, d: usize, [low, high]: [f64; 2]) -> Vec<f64> {
        let Self::Spline(surface, _) = self else { return Vec::new() };
        let space = if d == 0 { surface.u() } else { surface.v() };
        space.breakpoints().into_iter().filter(|knot| (low..high).contains(knot) && *knot > low).collect()
    }

    /// The parameters of the nearest point of the surface, as near to `near` as they can be: around a pole they are those.
    ///
    /// Of a spline it is the nearest one on the way downhill from `near`.
    pub(super) fn at(&self, p: Point, near: [f64; 2]) -> Result<[f64; 2]> {
        match self {
            Self::Form(form, size) => Ok(at_form(form, p, near, *size)),
            Self::Spline(surface, sides) => {
                let start = [0, 1].map(|d: usize| sides[d].wrapped(near[d]));
                let mut foot = surface.foot(p, (start[0], start[1]))?;
                for (d, side) in sides.iter().enumerate().filter(|(_, side)| side.closed) {
                    // The search stops where the domain ends; the surface goes on from its other end.
                    let mut at = [foot.at.0, foot.at.1];
                    if at[d] == side.low || at[d] == side.high {
                        at[d] = side.low + (side.high - at[d]);
                        let other = surface.foot(p, (at[0], at[1]))?;
                        foot = if other.distance < foot.distance { other } else { foot };
                    }
                }
                let (u, v) = foot.at;
                let mut found = [sides[0].unwrapped(u, near[0]), sides[1].unwrapped(v, near[1])];
                for d in 0..2 {
                    let side = &sides[d];
                    let on = |end: f64| (found[d] - end).abs() <= POLE * side.length();
                    if (side.poles[0] && on(side.low)) || (side.poles[1] && on(side.high)) {
                        found[1 - d] = near[1 - d];
                    }
                }
                Ok(found)
            }
        }
    }

    /// Where its parameters start to count, once around.
    pub(super) fn starts(&self) -> [f64; 2] {
        match self {
            Self::Form(..) => [0.0; 2],
            Self::Spline(_, sides) => sides.map(|side| side.low),
        }
    }

    /// These parameters within the domain of a spline, of which they may be out by rounding.
    pub(super) fn inside(&self, at: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Form(..) => at,
            Self::Spline(_, sides) => [0, 1].map(|d: usize| at[d].clamp(sides[d].low, sides[d].high)),
        }
    }

    /// The point at these parameters; `None` beyond the domain of a spline, which ends there.
    pub(super) fn point(&self, at: [f64; 2]) -> Result<Option<Point>> {
        match self {
            Self::Form(form, _) => Ok(point_of(form, at)),
            Self::Spline(surface, sides) => {
                let [u, v] = self.inside(at);
                if [(u - at[0], 0), (v - at[1], 1)]
                    .iter()
                    .any(|(by, d)| by.abs() > SLACK * sides[*d].length())
                {
                    return Ok(None);
                }
                Ok(Some(surface.point(u, v)?))
            }
        }
    }

    /// What parameters of the form's [covering](SurfaceForm::covering) are here, of which angles run almost alike, and are the same at each quarter.
    pub(super) fn of_covering(&self, covering: &Surface, [u, v]: [f64; 2]) -> Result<[f64; 2]> {
        let Self::Form(form, _) = self else { return Ok([u, v]) };
        let wrapped = |t: f64, (low, high): (f64, f64)| low + (t - low).rem_euclid(high - low);
        let (rows, columns) = (covering.u().domain(), covering.v().domain());
        // Where the surface is widest: a pole has no angle.
        let mut widest = (0.0, covering.point(rows.0, columns.0)?);
        for share in [0.0, 0.5, 1.0] {
            let row = (1.0 - share) * columns.0 + share * columns.1;
            let p = covering.point(wrapped(u, rows), row)?;
            let wide = frame_of(form).map_or(0.0, |frame| {
                let d = p - frame.origin;
                d.dot(&frame.x).hypot(d.dot(&frame.y()))
            });
            if wide > widest.0 {
                widest = (wide, p);
            }
        }
        let around = self.at(widest.1, [u, v])?[0];
        let closes = self.turns()[1].is_some();
        let column = if closes { wrapped(v, columns) } else { v.clamp(columns.0, columns.1) };
        Ok([around, self.at(covering.point(rows.0, column)?, [u, v])?[1]])
    }
}

fn frame_of(form: &SurfaceForm) -> Option<&Frame> {
    match form {
        SurfaceForm::Cylinder { frame, .. }
        | SurfaceForm::Cone { frame, .. }
        | SurfaceForm::Sphere { frame, .. }
        | SurfaceForm::Torus { frame, .. } => Some(frame),
        _ => None,
    }
}

fn at_form(form: &SurfaceForm, p: Point, near: [f64; 2], size: f64) -> [f64; 2] {
    let Some(frame) = frame_of(form) else { return near };
    let d = p - frame.origin;
    let (x, y, height) = (d.dot(&frame.x), d.dot(&frame.y()), d.dot(&frame.z));
    let wide = x.hypot(y);
    let around = |sign: f64| {
        if wide <= POLE * size { near[0] } else { beside((sign * y).atan2(sign * x), near[0]) }
    };
    match form {
        SurfaceForm::Cone { radius, angle, .. } => {
            // Beyond the tip its radius is negative.
            let sign = if radius + height * angle.tan() < 0.0 { -1.0 } else { 1.0 };
            let (sin, cos) = angle.sin_cos();
            let along = (sign * wide - radius) * sin + height * cos;
            [around(sign), along * cos]
        }
        SurfaceForm::Sphere { .. } => [around(1.0), height.atan2(wide)],
        SurfaceForm::Torus { major, .. } => [around(1.0), beside(height.atan2(wide - major), near[1])],
        _ => [around(1.0), height],
    }
}

fn point_of(form: &SurfaceForm, [u, v]: [f64; 2]) -> Option<Point> {
    let frame = frame_of(form)?;
    let (wide, height) = match form {
        SurfaceForm::Cylinder { radius, .. } => (*radius, v),
        SurfaceForm::Cone { radius, angle, .. } => (radius + v * angle.tan(), v),
        SurfaceForm::Sphere { radius, .. } => (radius * v.cos(), radius * v.sin()),
        SurfaceForm::Torus { major, minor, .. } => (major + minor * v.cos(), minor * v.sin()),
        _ => return None,
    };
    let across = frame.x * u.cos() + frame.y() * u.sin();
    Some(frame.origin + across * wide + frame.z * height)
}
