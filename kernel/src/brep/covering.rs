//! Elementary surfaces as exact rational splines, as large as some points on them need.

use std::f64::consts::{PI, TAU};

use super::{CurveForm, Edge, Frame, SurfaceForm};
use crate::error::{Error, Result};
use crate::spline::{Curve, Space, Surface};
use crate::{Point, Vector};

/// By how much of their extent a plane's piece and a cylinder's height go beyond the points.
const MARGIN: f64 = 1.0 / 64.0;

impl SurfaceForm {
    /// An exact spline of the form that holds points on it, with its normal `S_u × S_v` where the form has it: a plane's along its
    /// frame's `z`, all others' outwards. Of a plane a rectangle along `x` and `y`, of a cylinder and a cone all around (`u` from the frame's
    /// `x` on, an angle) and as high as the points need and a 64th more (`v` the height along the axis); a cone ends at its tip. Spheres and tori
    /// are whole: `u` around the axis, `v` the latitude from `-π/2`, or around the tube from outside.
    ///
    /// # Errors
    /// When it is a spline or a swept curve, whose surface is known; when a number is no size, or there are no points and some are needed.
    pub fn covering(&self, points: &[Point]) -> Result<Surface> {
        self.check()?;
        match *self {
            Self::Spline | Self::Extrusion { .. } | Self::Revolution { .. } => Err(Error::Invalid(
                "a surface that is a spline, extruded or turned is no elementary one: take it as it is"
                    .into(),
            )),
            Self::Plane { frame } => plane(&frame, points),
            Self::Cylinder { frame, radius } => {
                let [low, high] = padded(range(points, frame.origin, frame.z)?, radius);
                turned(&frame, &[(radius, low), (radius, high)])
            }
            Self::Cone { frame, radius, angle } => {
                let slope = angle.tan();
                let [low, high] = range(points, frame.origin, frame.z)?;
                let tip = -radius / slope;
                // Points lie on one side of the tip: that on which their middle is.
                let [low, high] = padded([low, high], (0.5 * (low + high) - tip).abs() * slope);
                let ends =
                    if 0.5 * (low + high) >= tip { [low.max(tip), high] } else { [low, high.min(tip)] };
                let at = |h: f64| if h == tip { (0.0, h) } else { (radius + h * slope, h) };
                let profile = ends.map(at);
                if profile.iter().all(|(r, _)| *r <= 0.0) {
                    // The nappe beyond the tip: its radius is negative, turned by half.
                    let mirrored = Frame { x: -frame.x, ..frame };
                    return turned(&mirrored, &profile.map(|(r, h)| (-r, h)));
                }
                turned(&frame, &profile)
            }
            Self::Sphere { frame, radius } => {
                let meridian =
                    Curve::elliptic_arc(frame.origin, frame.x * radius, frame.z * radius, -0.5 * PI, PI)?;
                // The poles to the bit: they are one point each.
                let (space, mut net, weights) = meridian.into_parts();
                let last = net.len() - 1;
                net[0] = frame.origin - frame.z * radius;
                net[last] = frame.origin + frame.z * radius;
                let meridian = Curve::build(space, net, weights)?.reparametrise(-0.5 * PI, 0.5 * PI)?;
                revolved(&meridian, &frame)
            }
            Self::Torus { frame, major, minor } => {
                let center = frame.origin + frame.x * major;
                let tube = Curve::elliptic_arc(center, frame.x * minor, frame.z * minor, 0.0, TAU)?;
                revolved(&tube, &frame)
            }
        }
    }
}

/// An edge is looked at at so many places of each span.
const EACH: usize = 8;

impl Edge {
    /// Points for [`SurfaceForm::covering`] that hold an edge: of a spline the control vertices with knots at eighths of each span, in whose hull it is; of lines and
    /// conics so many places that a 64th of their extent more holds all of it. `O(p²)` for each knot.
    ///
    /// # Errors
    /// When its range is none of its curve's, or an evaluation overflows.
    pub fn reach(&self) -> Result<Vec<Point>> {
        let (from, to) = self.range;
        if self.form != CurveForm::Spline {
            let spans = self.curve.space().spans().count();
            let steps = if self.form == CurveForm::Line { 1 } else { EACH * spans };
            return (0..=steps)
                .map(|k| self.curve.point(from + (to - from) * (k as f64 / steps as f64)))
                .collect();
        }
        let own = self.curve.between(from, to)?;
        let ends = own.space().breakpoints();
        let within = |pair: &[f64]| {
            let [from, to] = [pair[0], pair[1]];
            let places = (1..EACH).map(move |k| from + (to - from) * (k as f64 / EACH as f64));
            places.filter(move |t| *t > from && *t < to)
        };
        let mut knots: Vec<f64> = ends.windows(2).flat_map(within).collect();
        knots.dedup();
        Ok(own.insert_knots(&knots)?.into_parts().1)
    }
}

fn plane(frame: &Frame, points: &[Point]) -> Result<Surface> {
    let (x, y) = (range(points, frame.origin, frame.x)?, range(points, frame.origin, frame.y())?);
    let longest = (x[1] - x[0]).max(y[1] - y[0]);
    let [x, y] = [padded(x, longest), padded(y, longest)];
    let at = |a: f64, b: f64| frame.origin + frame.x * a + frame.y() * b;
    let net = vec![at(x[0], y[0]), at(x[0], y[1]), at(x[1], y[0]), at(x[1], y[1])];
    Surface::new(Space::clamped(1, &x)?, Space::clamped(1, &y)?, net)
}

/// A straight profile of two `(radius, height)` turned about the frame's axis.
fn turned(frame: &Frame, profile: &[(f64, f64); 2]) -> Result<Surface> {
    let heights = profile.map(|(_, h)| h);
    let net = profile.map(|(r, h)| frame.origin + frame.x * r + frame.z * h).to_vec();
    revolved(&Curve::new(Space::clamped(1, &heights)?, net)?, frame)
}

fn revolved(profile: &Curve, frame: &Frame) -> Result<Surface> {
    Surface::revolution(profile, frame.origin, frame.z, TAU)
}

/// From where to where points reach along a direction.
fn range(points: &[Point], origin: Point, along: Vector) -> Result<[f64; 2]> {
    let heights = points.iter().map(|p| (p - origin).dot(&along));
    let [low, high] =
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    if low.is_finite() && high.is_finite() {
        return Ok([low, high]);
    }
    Err(Error::Invalid("no points say how large a piece of the surface is needed".into()))
}

/// The range with a margin; with one of the `size` of the thing where it has no length.
fn padded([low, high]: [f64; 2], size: f64) -> [f64; 2] {
    let by = MARGIN * if high - low > 1e-6 * size { high - low } else { size };
    [low - by, high + by]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        Frame::new(Point::new(1.0, -2.0, 0.5), Vector::new(0.3, 0.2, 1.0), Vector::new(1.0, 0.1, -0.4))
            .unwrap()
    }

    /// How far a point is from the form, by its equation.
    fn off(form: &SurfaceForm, p: Point) -> f64 {
        let parts = |f: &Frame| {
            let d = p - f.origin;
            let h = d.dot(&f.z);
            ((d - f.z * h).norm(), h, d.norm())
        };
        match form {
            SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => f64::NAN,
            SurfaceForm::Plane { frame } => parts(frame).1.abs(),
            SurfaceForm::Cylinder { frame, radius } => (parts(frame).0 - radius).abs(),
            SurfaceForm::Cone { frame, radius, angle } => {
                let (r, h, _) = parts(frame);
                ((r - (radius + h * angle.tan()).abs()) * angle.cos()).abs()
            }
            SurfaceForm::Sphere { frame, radius } => (parts(frame).2 - radius).abs(),
            SurfaceForm::Torus { frame, major, minor } => {
                let (r, h, _) = parts(frame);
                // The inner side of a spindle is beyond the axis.
                [r - major, r + major]
                    .map(|r| (r.hypot(h) - minor).abs())
                    .into_iter()
                    .fold(f64::INFINITY, f64::min)
            }
        }
    }

    #[test]
    fn splines_of_forms_are_exact_and_hold_the_points() {
        let frame = frame();
        let cone =
            |radius: f64, heights: [f64; 2]| (SurfaceForm::Cone { frame, radius, angle: 0.4 }, heights);
        let forms = [
            (SurfaceForm::Plane { frame }, [0.0, 0.0]),
            (SurfaceForm::Cylinder { frame, radius: 2.0 }, [-3.0, 5.0]),
            (SurfaceForm::Sphere { frame, radius: 2.0 }, [0.0, 0.0]),
            (SurfaceForm::Torus { frame, major: 3.0, minor: 1.0 }, [0.0, 0.0]),
            (SurfaceForm::Torus { frame, major: 1.0, minor: 1.5 }, [0.0, 0.0]),
            cone(2.0, [-1.0, 5.0]),
            cone(0.0, [0.0, 5.0]),
            cone(2.0, [-20.0, -10.0]),
        ];
        for (form, heights) in forms {
            let radius = |h: f64| match form {
                SurfaceForm::Cylinder { radius, .. } => radius,
                SurfaceForm::Cone { radius, angle, .. } => radius + h * angle.tan(),
                _ => 1.0,
            };
            let ring = |h: f64| {
                (0..8).map(move |k| {
                    let (sin, cos) = f64::from(k).sin_cos();
                    frame.origin + (frame.x * cos + frame.y() * sin) * radius(h) + frame.z * h
                })
            };
            let points: Vec<Point> = heights.into_iter().flat_map(ring).collect();
            let surface = form.covering(&points).unwrap();
            let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
            for i in 0..=24 {
                for j in 0..=24 {
                    let (u, v) = (a + (b - a) * f64::from(i) / 24.0, c + (d - c) * f64::from(j) / 24.0);
                    assert!(off(&form, surface.point(u, v).unwrap()) < 3e-14 * 30.0, "{form:?} at {u} {v}");
                }
            }
            if !matches!(form, SurfaceForm::Sphere { .. } | SurfaceForm::Torus { .. }) {
                for p in &points {
                    assert!(surface.closest(*p).unwrap().distance < 1e-12, "{form:?} {p}");
                }
            }
            let n = {
                let (u, v) = (a + 0.3 * (b - a), c + 0.4 * (d - c));
                let at = surface.point(u, v).unwrap();
                let n =
                    surface.derivative(u, v, 1, 0).unwrap().cross(&surface.derivative(u, v, 0, 1).unwrap());
                (at, n)
            };
            let outwards = match form {
                SurfaceForm::Plane { frame } => frame.z,
                SurfaceForm::Torus { frame, major, .. } => {
                    let d = n.0 - frame.origin;
                    let flat = d - frame.z * d.dot(&frame.z);
                    n.0 - (frame.origin + flat.normalize() * major)
                }
                SurfaceForm::Sphere { frame, .. } => n.0 - frame.origin,
                _ => {
                    let d = n.0 - frame.origin;
                    d - frame.z * d.dot(&frame.z)
                }
            };
            let torus_inside_out = matches!(form, SurfaceForm::Torus { major, minor, .. } if minor > major);
            assert!(torus_inside_out || n.1.dot(&outwards) > 0.0, "{form:?}");
        }
    }

    /// Planes around edges that run about between the places at which they are looked at: few spans of any degree, weights unlike by a thousand, parts of curves.
    #[test]
    fn planes_hold_all_of_their_edges() {
        let frame = frame();
        let (mut wide, mut beyond) = (0, 0);
        for degree in (1..8).chain([25]) {
            for seed in 0..40 {
                let noise = |k: usize, way: f64| {
                    let phase = (k as f64 + 1.0) * (f64::from(seed) + way) * 12.9898;
                    (phase.sin() * 43_758.545_3).fract()
                };
                let count = degree + 1 + seed as usize % 3;
                let at =
                    |k: usize| frame.origin + frame.x * noise(k, 0.3) + frame.y() * (3.0 * noise(k, 0.7));
                let net: Vec<Point> = (0..count).map(at).collect();
                let weights = (seed % 2 == 1)
                    .then(|| (0..count).map(|k| 1000.0_f64.powf(noise(k, 0.9).abs())).collect::<Vec<f64>>());
                let curve =
                    Curve::build(Space::clamped_uniform(degree, count).unwrap(), net, weights).unwrap();
                let (start, end) = curve.domain();
                let range = if seed % 5 == 0 { (start + 0.1 * (end - start), end) } else { (start, end) };
                let edge = Edge { curve, range, ends: [0, 1], tolerance: 0.0, form: CurveForm::Spline };
                let surface = SurfaceForm::Plane { frame }.covering(&edge.reach().unwrap()).unwrap();
                let domains = [surface.u().domain(), surface.v().domain()];
                let looks = 4096;
                let places = (0..=looks).map(|k| {
                    let t = range.0 + (range.1 - range.0) * f64::from(k) / f64::from(looks);
                    let way = edge.curve.point(t).unwrap() - frame.origin;
                    [way.dot(&frame.x), way.dot(&frame.y())]
                });
                let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
                for place in places {
                    for k in 0..2 {
                        ends[k] = [ends[k][0].min(place[k]), ends[k][1].max(place[k])];
                        assert!(
                            domains[k].0 <= place[k] && place[k] <= domains[k].1,
                            "degree {degree}, {seed}: {place:?} is not within {domains:?}"
                        );
                    }
                }
                wide += usize::from(
                    (0..2).any(|k| domains[k].1 - domains[k].0 > 1.2 * (ends[k][1] - ends[k][0])),
                );
                // What places alone would hold.
                let steps = EACH * edge.curve.space().spans().count();
                let looked: Vec<Point> = (0..=steps)
                    .map(|k| {
                        edge.curve.point(range.0 + (range.1 - range.0) * k as f64 / steps as f64).unwrap()
                    })
                    .collect();
                let domains = [frame.x, frame.y()].map(|way| {
                    let [low, high] = self::range(&looked, frame.origin, way).unwrap();
                    padded([low, high], 1.0)
                });
                beyond +=
                    usize::from((0..2).any(|k| domains[k][0] > ends[k][0] || domains[k][1] < ends[k][1]));
            }
        }
        assert!(
            wide <= 32 && beyond >= 10,
            "{wide} planes are wide, and {beyond} curves are beyond their places"
        );
    }

    #[test]
    fn what_is_no_size_is_refused() {
        let frame = frame();
        for form in [
            SurfaceForm::Spline,
            SurfaceForm::Cylinder { frame, radius: 0.0 },
            SurfaceForm::Cylinder { frame, radius: f64::NAN },
            SurfaceForm::Sphere { frame, radius: -1.0 },
            SurfaceForm::Cone { frame, radius: 1.0, angle: 0.0 },
            SurfaceForm::Cone { frame, radius: 1.0, angle: 2.0 },
            SurfaceForm::Torus { frame, major: 1.0, minor: 0.0 },
        ] {
            assert!(form.covering(&[Point::origin()]).is_err(), "{form:?}");
        }
        assert!(SurfaceForm::Plane { frame }.covering(&[]).is_err());
        // One point is enough for a small piece around it.
        assert!(SurfaceForm::Cylinder { frame, radius: 1.0 }.covering(&[Point::origin()]).is_ok());
    }
}
