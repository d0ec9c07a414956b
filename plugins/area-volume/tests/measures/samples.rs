//! Shapes that close.

use std::f64::consts::{PI, TAU};

use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// An ellipse's control polygon of half axes 2 and 1, on any periodic space.
pub(crate) fn ring(space: Space) -> Curve {
    let n = space.len();
    let at = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
        Point::new(2.0 * cos, sin, 0.0)
    };
    Curve::new(space, (0..n).map(at).collect()).unwrap()
}

/// Twelve vertices on a uniform periodic cubic.
pub(crate) fn oval() -> Curve {
    ring(Space::periodic_uniform(3, 12).unwrap())
}

/// Knots that are nowhere evenly spaced.
pub(crate) fn uneven(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 + 0.37 * (i % 3) as f64).collect()
}

/// A rational circle, clamped, its ends meeting.
pub(crate) fn circle(radius: f64) -> Curve {
    Curve::circle(Point::new(0.3, -0.2, 0.0) * radius, Vector::z(), radius).unwrap()
}

/// A clamped quartic whose ends meet, about as round as it can be drawn by hand.
pub(crate) fn pebble() -> Curve {
    let space = Space::clamped(4, &[0.0, 0.5, 1.2, 2.0, 2.1, 3.0]).unwrap();
    let n = space.len();
    let at = |i: usize| {
        let (sin, cos) = (TAU * (i % (n - 1)) as f64 / (n - 1) as f64).sin_cos();
        Point::new(1.5 * cos + 0.2 * (3.0 * sin), sin + 0.1 * cos, 0.0)
    };
    Curve::new(space, (0..n).map(at).collect()).unwrap()
}

/// A torus of control vertices, polynomial, periodic in both directions.
pub(crate) fn torus(nu: usize, nv: usize, degree: usize) -> Surface {
    let space = |n: usize| Space::periodic(degree, uneven(n + 1)).unwrap();
    let at = |i: usize, j: usize| {
        let ((su, cu), (sv, cv)) =
            ((TAU * i as f64 / nu as f64).sin_cos(), (TAU * j as f64 / nv as f64).sin_cos());
        let r = 2.0 + 0.7 * cv + 0.1 * su;
        Point::new(r * cu, r * su, 0.7 * sv + 0.05 * cu)
    };
    let net = (0..nu * nv).map(|k| at(k / nv, k % nv)).collect();
    Surface::new(space(nu), space(nv), net).unwrap()
}

/// A ball with poles: periodic around, clamped from pole to pole. Polynomial; its outward normal is `S_u × S_v`.
pub(crate) fn ball(around: usize, up: usize) -> Surface {
    let (u, v) = (Space::periodic_uniform(3, around).unwrap(), Space::clamped_uniform(3, up).unwrap());
    let at = |i: usize, j: usize| {
        let (lat, lon) = (PI * (j as f64 / (up - 1) as f64 - 0.5), TAU * i as f64 / around as f64);
        let r = if j == 0 || j + 1 == up { 0.0 } else { lat.cos() };
        Point::new(1.5 * r * lon.cos(), 1.2 * r * lon.sin(), lat.sin())
    };
    Surface::new(u, v, (0..around * up).map(|k| at(k / up, k % up)).collect()).unwrap()
}

/// An exact sphere: a rational surface of revolution with a seam and two poles. Its normal points outwards.
pub(crate) fn sphere(radius: f64) -> Surface {
    let meridian = Curve::elliptic_arc(Point::origin(), -Vector::z() * radius, Vector::x() * radius, 0.0, PI);
    let turned = Surface::revolution(&meridian.unwrap(), Point::origin(), Vector::z(), TAU).unwrap();
    let normal = |s: &Surface| {
        let mid = |d: (f64, f64)| 0.4 * d.0 + 0.6 * d.1;
        let (u, v) = (mid(s.u().domain()), mid(s.v().domain()));
        let outward = s.point(u, v).unwrap().coords;
        s.derivative(u, v, 1, 0).unwrap().cross(&s.derivative(u, v, 0, 1).unwrap()).dot(&outward)
    };
    if normal(&turned) > 0.0 { turned } else { turned.reverse(Direction::U).unwrap() }
}

/// A box of six bilinear or bicubic patches, bulging, that meet edge to edge; some turned inside out.
pub(crate) fn patches(degree: usize, bulge: f64) -> Vec<Surface> {
    let faces: [(usize, usize, usize, f64, bool); 6] = [
        (0, 1, 2, 1.0, false),
        (1, 2, 0, 1.0, false),
        (2, 0, 1, 1.0, true),
        (0, 1, 2, -1.0, false),
        (1, 2, 0, -1.0, true),
        (2, 0, 1, -1.0, false),
    ];
    faces
        .iter()
        .map(|&(a, b, c, side, swapped)| {
            let n = degree + 1;
            let grid = |k: usize| 2.0 * k as f64 / degree as f64 - 1.0;
            let at = |k: usize| {
                let (s, t) = (grid(k / n), grid(k % n));
                let mut p = Point::origin();
                (p[a], p[b]) = (s, t);
                p[c] = side * (1.0 + bulge * (1.0 - s * s) * (1.0 - t * t));
                p
            };
            let space = Space::clamped(degree, &[0.0, 1.0]).unwrap();
            // The first two axes and the third are right-handed: outwards where the side is +.
            let net = Surface::new(space.clone(), space, (0..n * n).map(at).collect()).unwrap();
            if swapped == (side > 0.0) { net.reverse(Direction::V).unwrap() } else { net }
        })
        .collect()
}
