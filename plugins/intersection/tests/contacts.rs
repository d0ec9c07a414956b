//! Kinds of meetings: by derivatives on both sides, at knots and beside them.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use loftsman_intersection::{
    Contact, Intersections, Options, Plane, curve_plane, curve_surface, curves, self_intersections,
};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

fn line(from: [f64; 3], to: [f64; 3]) -> Curve {
    Curve::line(Point::from(from), Point::from(to)).unwrap()
}

fn polygon(points: &[[f64; 3]]) -> Curve {
    let space = Space::clamped_uniform(1, points.len()).unwrap();
    Curve::new(space, points.iter().map(|p| Point::from(*p)).collect()).unwrap()
}

/// The kind of the only meeting.
fn only(found: &Intersections) -> Contact {
    assert!(found.meetings.len() == 1 && found.overlaps.is_empty() && found.is_complete(), "{found:#?}");
    found.meetings[0].contact
}

/// Tangent lines at knots (every 90 degrees), at halves of pieces, and elsewhere; the same askew by a little cross.
#[test]
fn a_tangent_of_a_circle_touches_it_wherever_that_is() {
    let options = Options::default();
    for size in [1e-9, 1.0, 5.0, 1e9] {
        let ring = Curve::circle(Point::origin(), Vector::z(), size).unwrap();
        let pipe = Surface::extrusion(&ring, Vector::z() * 4.0 * size).unwrap();
        let pipe = pipe.to_owned();
        for degrees in [0.0, 30.0, 45.0, 90.0, 100.0, 135.0, 180.0, 270.0, 360.0, 22.5] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let foot = Vector::new(cos, sin, 0.0) * size;
            let along = Vector::new(-sin, cos, 0.0) * size;
            let tangent = |from: f64, to: f64, up: f64| {
                let at = |x: f64| Point::from(foot + along * x + Vector::z() * up * size);
                Curve::line(at(from), at(to)).unwrap()
            };
            for (from, to) in [(-1.8, 1.8), (-1.3, 0.7), (2.0, -1.0)] {
                let found = curves(&tangent(from, to, 0.0), &ring, &options).unwrap();
                assert_eq!(only(&found), Contact::Touching, "{size} {degrees}");
                let off = (found.meetings[0].point.coords - foot).norm();
                assert!(off <= 1e-13 * size, "{size} {degrees}: {off:e}");
                let found = curve_surface(&tangent(from, to, 1.5), &pipe, &options).unwrap();
                assert_eq!(only(&found), Contact::Touching, "{size} {degrees}");
                let off = (found.meetings[0].point.coords - foot - Vector::z() * 1.5 * size).norm();
                assert!(off <= 1e-13 * size, "{size} {degrees}: {off:e}");
            }
            let plane = Plane::new(Point::from(foot), foot).unwrap();
            let found = curve_plane(&ring, &plane, &options).unwrap();
            assert_eq!(only(&found), Contact::Touching, "{size} {degrees}");
            // Through the same place, at a small angle.
            let askew = along + foot * 1e-2;
            let (a, b) = (Point::from(foot - askew), Point::from(foot + askew));
            let found = curves(&Curve::line(a, b).unwrap(), &ring, &options).unwrap();
            assert!(found.meetings.len() == 2, "{size} {degrees}: {found:#?}");
            assert!(found.meetings.iter().all(|m| m.contact == Contact::Crossing), "{found:#?}");
        }
    }
}

#[test]
fn a_corner_touches_what_it_stays_on_one_side_of() {
    let options = Options::default();
    let level = line([-3.0, 0.0, 0.0], [2.0, 0.0, 0.0]);
    let plane = Plane::new(Point::origin(), Vector::y()).unwrap();
    let wall = Surface::extrusion(&line([-3.0, 0.0, -1.0], [3.0, 0.0, -1.0]), Vector::z() * 2.5).unwrap();
    let cases = [
        ([[-1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 2.0, 0.0]], Contact::Touching),
        ([[-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.1, -2.0, 0.0]], Contact::Touching),
        ([[-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]], Contact::Crossing),
        ([[-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 2.0, 0.0]], Contact::Crossing),
    ];
    for (points, kind) in cases {
        for reversed in [false, true] {
            let corner = polygon(&points);
            let corner = if reversed { corner.reverse().unwrap() } else { corner };
            assert_eq!(only(&curves(&corner, &level, &options).unwrap()), kind, "{points:?}");
            assert_eq!(only(&curves(&level, &corner, &options).unwrap()), kind, "{points:?}");
            assert_eq!(only(&curve_plane(&corner, &plane, &options).unwrap()), kind, "{points:?}");
            assert_eq!(only(&curve_surface(&corner, &wall, &options).unwrap()), kind, "{points:?}");
        }
    }
    // Two corners, tip to tip and through one another.
    let up = polygon(&[[-1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    let down = polygon(&[[-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], [1.0, -1.0, 0.0]]);
    let side = polygon(&[[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [2.0, -1.0, 0.0]]);
    assert_eq!(only(&curves(&up, &down, &options).unwrap()), Contact::Touching);
    assert_eq!(only(&curves(&up, &side, &options).unwrap()), Contact::Crossing);
    // A ridge is touched from above and crossed from the side.
    let roof = polygon(&[[-1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [1.0, 0.0, -1.0]]);
    let roof = Surface::extrusion(&roof, Vector::y() * 2.0).unwrap();
    let above = line([-1.0, 1.0, 0.3], [1.0, 1.0, -0.3]);
    assert_eq!(only(&curve_surface(&above, &roof, &options).unwrap()), Contact::Touching);
    let through = line([-0.2, 1.0, 1.0], [0.2, 1.0, -1.0]);
    assert_eq!(only(&curve_surface(&through, &roof, &options).unwrap()), Contact::Crossing);
}

/// At a pole, where no derivative tells directions apart, the normal does.
#[test]
fn a_line_through_a_pole_crosses_and_one_along_it_touches() {
    let half =
        Curve::arc(Point::new(0.0, 0.0, -2.0), Point::origin(), Vector::y(), std::f64::consts::PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let options = Options::default();
    let through = line([0.5, 0.0, 1.0], [-0.5, 0.0, 3.0]);
    assert_eq!(only(&curve_surface(&through, &ball, &options).unwrap()), Contact::Crossing);
    let along = line([-1.0, 0.3, 2.0], [1.0, -0.3, 2.0]);
    assert_eq!(only(&curve_surface(&along, &ball, &options).unwrap()), Contact::Touching);
}

#[test]
fn a_curve_that_meets_itself_at_a_knot_is_told_as_elsewhere() {
    let knot = polygon(&[
        [-1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, -1.0, 0.0],
        [0.0, 0.0, 0.0],
        [-1.0, -1.0, 0.0],
    ]);
    assert_eq!(only(&self_intersections(&knot, &Options::default()).unwrap()), Contact::Touching);
    let knot = polygon(&[
        [-1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [-1.0, -1.0, 0.0],
    ]);
    assert_eq!(only(&self_intersections(&knot, &Options::default()).unwrap()), Contact::Crossing);
}

/// What runs along something and goes to its other side crosses it: a polyline that comes along a tangent and turns inwards, an inflection; what turns
/// outwards, or bends away to the same side, touches.
#[test]
fn what_runs_along_and_changes_sides_crosses() {
    let options = Options::default();
    for size in [1e-6, 1.0, 1e6] {
        let ring = Curve::ellipse(Point::origin(), Vector::x() * 5.0 * size, Vector::y() * size).unwrap();
        let pipe = Surface::extrusion(&ring, Vector::z() * 2.0 * size).unwrap();
        let cases = [
            ([0.0, 0.25], Contact::Crossing),
            ([1.0, 0.5], Contact::Crossing),
            ([1.0, 1.5], Contact::Touching),
        ];
        for ([x, y], kind) in cases {
            for reversed in [false, true] {
                let at = |z: f64| {
                    let corner =
                        polygon(&[[-7.0, 1.0, z], [0.0, 1.0, z], [x, y, z]].map(|p| p.map(|c| c * size)));
                    if reversed { corner.reverse().unwrap() } else { corner }
                };
                let (flat, corner) = (at(0.0), at(1.0));
                assert_eq!(only(&curves(&flat, &ring, &options).unwrap()), kind, "{size} {x} {y}");
                assert_eq!(only(&curves(&ring, &flat, &options).unwrap()), kind, "{size} {x} {y}");
                assert_eq!(only(&curve_surface(&corner, &pipe, &options).unwrap()), kind, "{size} {x} {y}");
            }
        }
        // y = x³ and y = x⁴ over [-1, 1], and the line y = 0.
        let axis = line([-2.0 * size, 0.0, 0.0], [2.0 * size, 0.0, 0.0]);
        let plane = Plane::new(Point::origin(), Vector::y()).unwrap();
        for (heights, kind) in [
            (vec![-1.0, 1.0, -1.0, 1.0], Contact::Crossing),
            (vec![1.0, -1.0, 1.0, -1.0, 1.0], Contact::Touching),
        ] {
            let degree = (heights.len() - 1) as f64;
            let points = heights
                .iter()
                .enumerate()
                .map(|(k, y)| Point::new(size * (2.0 * k as f64 / degree - 1.0), size * y, 0.0));
            let power = Curve::bezier(points.collect()).unwrap();
            assert_eq!(only(&curves(&power, &axis, &options).unwrap()), kind, "{size} {heights:?}");
            assert_eq!(only(&curves(&axis, &power, &options).unwrap()), kind, "{size} {heights:?}");
            assert_eq!(only(&curve_plane(&power, &plane, &options).unwrap()), kind, "{size} {heights:?}");
        }
    }
}
