//! Surfaces that are rectangles of planes, cylinders, cones, spheres and tori: the form kept beside the spline, and checked against it.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Matrix4, Rotation3, Unit};

use super::{Frame, Similarity, SurfaceForm};
use crate::error::{Error, Result};
use crate::spline::{Curve, Direction, Space, Surface};
use crate::{Point, Vector};

/// How far a spline may be from the one that its form is, in parts of the largest coordinate, of the weights and of the domains: what a few dozen
/// roundings make, and no more.
const ROUNDING: f64 = 1e-12;

/// A rectangle of an elementary surface, or a curve along a vector or about an axis: of which, and from where to where on it.
///
/// The parameters are those of ISO 10303-42: of a plane lengths along `x` and `y`; of the others `u` is the angle about the axis from `x` on, and `v` of a cylinder
/// and a cone the height along the axis, of a sphere the latitude, of a torus the angle around the tube from outside.
/// Of an extrusion `u` is the parameter of its profile ([`CurvePiece`](super::CurvePiece); of a spline its own) and `v` from 0 to 1 the way along the vector; of a
/// revolution `u` is the angle, from 0, and `v` the parameter of the profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePiece {
    /// The surface.
    pub form: SurfaceForm,
    /// Where `u` starts and ends, and where `v` does; where the second is less, the spline runs the other way.
    pub ranges: [[f64; 2]; 2],
}

impl SurfaceForm {
    /// The rectangle of an elementary surface between parameters, as [`SurfacePiece`] counts them, exactly: of degree 1 along what is straight and 2
    /// around, `v` over its range where it is straight and all other domains from 0.
    ///
    /// # Errors
    /// When it is no elementary surface, a range is empty or more than all around, or a number is no size.
    pub fn patch(&self, ranges: [[f64; 2]; 2]) -> Result<Surface> {
        self.check()?;
        let [[a, b], [c, d]] = ranges;
        let ([u, v], turned) = ([[a.min(b), a.max(b)], [c.min(d), c.max(d)]], [a > b, c > d]);
        let mut surface = self.rectangle(u, v)?;
        for (direction, _) in
            [Direction::U, Direction::V].into_iter().zip(turned).filter(|(_, turned)| *turned)
        {
            surface = surface.reverse(direction)?;
        }
        Ok(surface)
    }

    fn rectangle(&self, u: [f64; 2], v: [f64; 2]) -> Result<Surface> {
        let [low, high] = v;
        let line = |at: &dyn Fn(f64) -> Point| Curve::line(at(low), at(high))?.reparametrise(low, high);
        match *self {
            Self::Spline | Self::Extrusion { .. } | Self::Revolution { .. } => {
                Err(Error::Invalid(format!("a {} is no elementary surface: take it as it is", self.name())))
            }
            Self::Plane { frame } => {
                let [a, b] = u;
                let at = |x: f64, y: f64| frame.origin + frame.x * x + frame.y() * y;
                let side = Curve::line(at(a, low), at(b, low))?.reparametrise(a, b)?;
                Surface::extrusion(&side, frame.y() * (high - low))?.reparametrise(Direction::V, low, high)
            }
            Self::Cylinder { frame, radius } => {
                around(&line(&|h| frame.origin + frame.x * radius + frame.z * h)?, &frame, u)
            }
            Self::Cone { frame, radius, angle } => {
                // Along a cone `v` is the height over the circle of its radius.
                let at = |h: f64| frame.origin + frame.x * (radius + h * angle.tan()) + frame.z * h;
                around(&line(&at)?, &frame, u)
            }
            Self::Sphere { frame, radius } => {
                let (x, z) = (frame.x * radius, frame.z * radius);
                around(&Curve::elliptic_arc(frame.origin, x, z, low, high - low)?, &frame, u)
            }
            Self::Torus { frame, major, minor } => {
                let (center, x, z) = (frame.origin + frame.x * major, frame.x * minor, frame.z * minor);
                around(&Curve::elliptic_arc(center, x, z, low, high - low)?, &frame, u)
            }
        }
    }

    /// The ranges of the whole surface, where it is closed: of a sphere and a torus.
    pub fn whole(&self) -> Option<[[f64; 2]; 2]> {
        match self {
            Self::Sphere { .. } => Some([[0.0, TAU], [-FRAC_PI_2, FRAC_PI_2]]),
            Self::Torus { .. } => Some([[0.0, TAU]; 2]),
            _ => None,
        }
    }
}

/// A profile in the half plane of the frame's `x`, turned from one angle to another.
fn around(profile: &Curve, frame: &Frame, [from, to]: [f64; 2]) -> Result<Surface> {
    let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(frame.z), from);
    let (space, points, weights) = profile.clone().into_parts();
    let points = points.iter().map(|p| frame.origin + turn * (p - frame.origin)).collect();
    Surface::revolution(&Curve::build(space, points, weights)?, frame.origin, frame.z, to - from)
}

impl SurfacePiece {
    /// What it is in words: `"plane"`, `"cylinder"`, `"cone"`, `"sphere"`, `"torus"`, `"extrusion"`, `"revolution"`.
    pub fn noun(&self) -> &'static str {
        self.form.name()
    }

    /// The piece under the map of a surface. `None` where that does not keep the form.
    pub(crate) fn moved(&self, map: &Matrix4<f64>) -> Option<Self> {
        if let SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } = self.form {
            return self.moved_sweep(map);
        }
        let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector = map.fixed_view::<3, 1>(0, 3).into_owned();
        let similarity = Similarity::of(&linear, shift)?;
        let mut form = self.form.moved(Some(&similarity));
        let by = similarity.scale();
        let [mut u, mut v] = self.ranges;
        match &mut form {
            SurfaceForm::Plane { .. } => (u, v) = (u.map(|t| t * by), v.map(|t| t * by)),
            SurfaceForm::Cylinder { .. } | SurfaceForm::Cone { .. } => v = v.map(|t| t * by),
            SurfaceForm::Sphere { .. } | SurfaceForm::Torus { .. } => {}
            SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
                return None;
            }
        }
        // Axis and `x` go where the map brings them, and `y = z × x` does not where that mirrors.
        if (linear / linear.amax()).determinant() < 0.0 {
            match &mut form {
                SurfaceForm::Plane { .. } => v = v.map(|t| -t),
                // Seen from its other end; a cone opens there.
                SurfaceForm::Cylinder { frame, .. }
                | SurfaceForm::Sphere { frame, .. }
                | SurfaceForm::Torus { frame, .. } => {
                    frame.z = -frame.z;
                    v = v.map(|t| -t);
                }
                _ => u = u.map(|t| -t),
            }
        }
        Some(Self { form, ranges: [u, v] })
    }

    /// That a surface is this piece, to rounding: the [patch](SurfaceForm::patch), over whatever domains, or its [profile](Self::profile) along the vector or
    /// about the axis. `O(vertices)`.
    ///
    /// # Errors
    /// When it is not, with what is wrong.
    pub fn check(&self, surface: &Surface) -> Result<()> {
        let no = |why: String| Err(Error::Invalid(format!("the surface is no {}: {why}", self.form.name())));
        if !self.ranges.iter().flatten().all(|t| t.is_finite()) {
            return no(format!("it runs from and to {:?}", self.ranges));
        }
        if let SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } = self.form {
            return self.check_sweep(surface);
        }
        let own = self.form.patch(self.ranges)?;
        for (space, own) in [(surface.u(), own.u()), (surface.v(), own.v())] {
            let same = space.degree() == own.degree() && space.len() == own.len() && space.is_clamped();
            if !same || !alike(space, own) {
                return no("it has other knots than that between these parameters".to_owned());
            }
        }
        let weight = |surface: &Surface, k: usize| surface.weights().map_or(1.0, |weights| weights[k]);
        let reach = own.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        for (k, (p, q)) in surface.points().iter().zip(own.points()).enumerate() {
            let off = (p - q).amax();
            if off > ROUNDING * reach || off.is_nan() {
                return no(format!("a vertex is {off:e} from where that between these parameters has it"));
            }
            if (weight(surface, k) - weight(&own, k)).abs() > ROUNDING {
                return no("it has other weights than that between these parameters".to_owned());
            }
        }
        Ok(())
    }
}

/// Whether knots are at the same shares of their domains.
pub(super) fn alike(one: &Space, other: &Space) -> bool {
    let share = |space: &Space, k: usize| {
        let (a, b) = space.domain();
        (space.knots()[k] - a) / (b - a)
    };
    (0..one.knots().len()).all(|k| (share(one, k) - share(other, k)).abs() <= ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn family(scale: f64) -> Vec<SurfacePiece> {
        let origin = Point::new(3.0, -2.0, 7.0) * scale;
        let frame = Frame::new(origin, Vector::new(0.3, -0.5, 0.8), Vector::new(1.0, 0.2, 0.1)).unwrap();
        let lengths = |range: [f64; 2]| range.map(|t| t * scale);
        let (radius, major) = (2.0 * scale, 5.0 * scale);
        vec![
            SurfacePiece {
                form: SurfaceForm::Plane { frame },
                ranges: [lengths([-1.0, 2.0]), lengths([0.5, 4.0])],
            },
            SurfacePiece {
                form: SurfaceForm::Cylinder { frame, radius },
                ranges: [[0.3, 2.9], lengths([-1.0, 4.0])],
            },
            SurfacePiece {
                form: SurfaceForm::Cylinder { frame, radius },
                ranges: [[0.0, TAU], lengths([4.0, -1.0])],
            },
            SurfacePiece {
                form: SurfaceForm::Cone { frame, radius, angle: 0.4 },
                ranges: [[-1.0, 2.0], lengths([0.0, 3.0])],
            },
            SurfacePiece {
                form: SurfaceForm::Sphere { frame, radius },
                ranges: [[0.0, TAU], [-FRAC_PI_2, FRAC_PI_2]],
            },
            SurfacePiece { form: SurfaceForm::Sphere { frame, radius }, ranges: [[2.0, 0.5], [-0.2, 1.1]] },
            SurfacePiece {
                form: SurfaceForm::Torus { frame, major, minor: radius },
                ranges: [[0.0, TAU]; 2],
            },
            SurfacePiece {
                form: SurfaceForm::Torus { frame, major, minor: radius },
                ranges: [[1.0, 2.0], [3.0, 5.5]],
            },
        ]
    }

    #[test]
    fn patches_are_where_their_parameters_say() {
        for piece in family(1.0) {
            let surface = piece.form.patch(piece.ranges).unwrap();
            let ends = |space: &Space| [space.domain().0, space.domain().1];
            for (i, u) in ends(surface.u()).into_iter().enumerate() {
                for (j, v) in ends(surface.v()).into_iter().enumerate() {
                    let (s, t) = (piece.ranges[0][i], piece.ranges[1][j]);
                    let at = |f: &Frame, r: f64, h: f64| {
                        f.origin + (f.x * s.cos() + f.y() * s.sin()) * r + f.z * h
                    };
                    let expected = match piece.form {
                        SurfaceForm::Plane { frame: f } => f.origin + f.x * s + f.y() * t,
                        SurfaceForm::Cylinder { frame, radius } => at(&frame, radius, t),
                        SurfaceForm::Cone { frame, radius, angle } => at(&frame, radius + t * angle.tan(), t),
                        SurfaceForm::Sphere { frame, radius } => {
                            at(&frame, radius * t.cos(), radius * t.sin())
                        }
                        SurfaceForm::Torus { frame, major, minor } => {
                            at(&frame, major + minor * t.cos(), minor * t.sin())
                        }
                        _ => unreachable!(),
                    };
                    assert!((surface.point(u, v).unwrap() - expected).norm() < 1e-14 * 20.0, "{piece:?}");
                }
            }
        }
    }

    #[test]
    fn pieces_are_told_from_what_is_none_and_move() {
        use crate::shape::Shape;
        for piece in [1.0, 1e-9, 1e9].into_iter().flat_map(family) {
            let plain = piece.form.patch(piece.ranges).unwrap();
            let formed = plain.clone().with_form(piece).unwrap();
            assert!(formed != plain && formed.form() == Some(&piece));
            for k in 0..plain.points().len() {
                let mut bent = plain.clone();
                let by = (plain.points()[0] - plain.points()[plain.points().len() / 2]) * 1e-6;
                bent.control_vertices_mut()[k] += by;
                assert!(bent.with_form(piece).is_err());
            }
            let [u, [c, d]] = piece.ranges;
            for ranges in [
                [u, [c, d + 1e-6 * (d - c)]],
                [u, [d, c]],
                [[u[1], u[0]], [c, d]],
                [u, [c, c]],
                [u, [c, f64::NAN]],
            ] {
                assert!(SurfacePiece { ranges, ..piece }.check(&plain).is_err(), "{piece:?} {ranges:?}");
            }
            for direction in [Direction::U, Direction::V] {
                assert!(formed.elevate(direction, 1).unwrap().form().is_none());
                assert!(formed.reverse(direction).unwrap().form().is_none());
            }
            let turn = Matrix4::new_rotation(Vector::new(0.4, 1.0, -2.0));
            let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-1.0, 1.0, 1.0));
            let shift = Matrix4::new_translation(&Vector::new(5.0, -6.0, 1.0));
            for map in [
                turn,
                mirror,
                shift,
                shift * mirror * turn * Matrix4::new_scaling(25.4),
                Matrix4::new_scaling(1e-3),
            ] {
                let moved = formed.transformed(&map).unwrap();
                moved.form().unwrap_or_else(|| panic!("{piece:?} {map}")).check(&moved).unwrap();
            }
            let stretch = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0));
            assert!(formed.transformed(&stretch).unwrap().form().is_none());
            let mut touched = formed.clone();
            touched.control_vertices_mut()[0].x += 1.0;
            assert!(touched.form().is_none() && formed.without_form().form().is_none());
        }
    }
}
