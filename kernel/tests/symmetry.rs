//! Shapes that are their own mirror images, edited.
#![allow(missing_docs, clippy::unwrap_used, reason = "tests")]

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{position, symmetry, vertex};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

#[test]
fn symmetry_pairs_by_position() {
    let points =
        (0..9).map(|i| Point::new(f64::from(i) - 4.0, f64::from((i - 4) * (i - 4)) * 0.1, 0.3)).collect();
    let arch = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points).unwrap();
    let edited = Edit::new(&arch)
        .ask(symmetry([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]).hold())
        .ask(position(1.0).by([0.0, 1.0, 0.5]))
        .solve()
        .unwrap();
    for i in 0..9 {
        let (a, b) = (edited.shape().points()[i], edited.shape().points()[8 - i]);
        assert!((a.x + b.x).abs() < 1e-13 && (a.y - b.y).abs() < 1e-13 && (a.z - b.z).abs() < 1e-13);
    }
    assert!(
        (edited.shape().point(1.0).unwrap() - arch.point(1.0).unwrap() - Vector::new(0.0, 1.0, 0.5)).norm()
            < 1e-13
    );
}

/// Exact circles and balls, clamped, their seams anywhere: vertices that are one point share a partner.
#[test]
fn symmetry_takes_seams_and_poles_as_the_points_that_they_are() {
    let mut held = 0;
    for turn in 0..24 {
        let angle = f64::from(turn as u8) * std::f64::consts::TAU / 24.0;
        let size = [1.0, 1e-6, 1e6][turn % 3];
        let normal = [angle.cos(), angle.sin(), 0.0];
        let normal = Vector::from(normal);
        let mirrored = |p: &Point| p - normal * (2.0 * normal.dot(&p.coords));
        let symmetric = |points: &[Point]| {
            points.iter().all(|p| points.iter().any(|q| (q - mirrored(p)).norm() < 1e-9 * size))
        };
        let circle = Curve::circle(Point::origin(), Vector::z(), size).unwrap();
        // The polygon of four arcs is symmetric in eight planes, of which none or one has the seam.
        // Within the plane, in which some of the vertices lie.
        let way = (Vector::new(-angle.sin(), angle.cos(), 2.0)) * (0.05 * size);
        let pull = vertex(1).by(way);
        if symmetric(circle.points()) {
            let edit = Edit::new(&circle).ask(symmetry(normal, Point::origin()).hold()).ask(pull);
            let edited = edit.solve().unwrap();
            assert!(symmetric(edited.shape().points()), "{turn}");
            let half = Curve::elliptic_arc(
                Point::origin(),
                -Vector::z() * size,
                Vector::x() * size,
                0.0,
                std::f64::consts::PI,
            );
            let ball =
                Surface::revolution(&half.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU)
                    .unwrap();
            let pull = vertex(7).by(way);
            let edit = Edit::new(&ball).ask(symmetry(normal, Point::origin()).hold()).ask(pull);
            let edited = edit.solve().unwrap();
            assert!(symmetric(edited.shape().points()), "{turn}");
            held += 1;
        }
    }
    assert_eq!(held, 8);
}
