//! Triangles of any shape by its values: where on it their corners are.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_kernel::plugin::{Chord, Drawn, Fineness, sampled};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// Closed in one direction, and at a tip all of it one point.
fn drop() -> Surface {
    let ring = Space::periodic_uniform(3, 8).unwrap();
    let points = (0..48).map(|k| {
        let (row, column) = (f64::from(k / 8), f64::from(k % 8));
        let (s, c) = (std::f64::consts::TAU * column / 8.0).sin_cos();
        Point::new(row * c, row * s, row * row * 0.3)
    });
    Surface::new(Space::clamped_uniform(3, 6).unwrap(), ring, points.collect()).unwrap()
}

/// Closed by a seam that it does not know of, with two poles.
fn sphere() -> Surface {
    let half =
        Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, std::f64::consts::PI).unwrap();
    Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
}

#[test]
fn corners_are_where_they_say_and_so_is_all_between_them() {
    for surface in [drop(), sphere()] {
        let chord = 1e-2;
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: 0.3 };
        let found = sampled(&[&surface], &fineness).unwrap();
        let Drawn::Mesh(mesh) = &found.drawn else { panic!("a surface") };
        assert_eq!(found.corners.len(), mesh.corners().len());
        for (points, at) in mesh.faces().zip(found.corners.chunks(3)) {
            let value = |at: Location| surface.value(at, Derivative::POSITION).unwrap();
            let corners = [0, 1, 2].map(|k| mesh.points()[points[k] as usize].coords);
            for (p, at) in corners.iter().zip(at) {
                assert!((p - value(*at)).norm() < 1e-12, "{at}");
            }
            // At seams and poles, too, the middle of the places is over the triangle.
            let uv = |at: Location| at.on_surface().unwrap();
            let sum = at.iter().fold((0.0, 0.0), |(u, v), at| (u + uv(*at).0, v + uv(*at).1));
            let middle = value(Location::Surface(sum.0 / 3.0, sum.1 / 3.0));
            let longest = (0..3).map(|k| (corners[k] - corners[(k + 1) % 3]).norm()).fold(0.0, f64::max);
            let off = (middle - (corners[0] + corners[1] + corners[2]) / 3.0).norm();
            assert!(off < 0.5 * longest, "{at:?}: {off} of {longest}");
        }
    }
}
