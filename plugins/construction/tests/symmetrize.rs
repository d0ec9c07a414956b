//! Shapes made symmetric.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::TAU;

use loftsman_construction::{Half, Mirror, symmetrize, symmetrize_surface, symmetrize_surface_best};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

fn mirror() -> (Mirror, impl Fn(Point) -> Point) {
    let (point, normal) = (Point::new(0.3, -0.2, 0.1), Vector::new(1.0, 0.5, -0.2));
    let unit = normal.normalize();
    (Mirror::new(point, normal).unwrap(), move |p: Point| p - unit * (2.0 * (p - point).dot(&unit)))
}

fn wave(space: Space, rational: bool) -> Curve {
    let n = space.len();
    let points = (0..n)
        .map(|i| (i as f64, i as f64 * 1.3))
        .map(|(i, a)| Point::new(i - 0.5 * n as f64, a.sin(), a.cos()));
    let weights = (0..n).map(|i| 1.0 + 0.5 * (2.1 * i as f64).sin()).collect();
    Curve::build(space, points.collect(), rational.then_some(weights)).unwrap()
}

#[test]
fn the_mean_is_symmetric_and_near() {
    let (plane, image) = mirror();
    for degree in [1, 2, 3, 4, 5, 6, 7, 25] {
        for rational in [false, true] {
            let n = degree + 5;
            let mut knots = vec![0.0; degree + 1];
            // Knots that are not symmetric, one of them of the highest multiplicity.
            knots.push(0.3);
            knots.extend(vec![1.1; degree]);
            knots.extend(vec![2.0; degree + 1]);
            let spaces = [
                Space::clamped_uniform(degree, n).unwrap(),
                Space::floating_uniform(degree, n).unwrap(),
                Space::open(degree, knots).unwrap(),
            ];
            for space in spaces {
                let curve = wave(space, rational);
                let even = symmetrize(&curve, &plane, Half::Both).unwrap();
                let (a, b) = even.shape.domain();
                assert_eq!((a, b), curve.domain());
                let mut largest = 0.0_f64;
                for k in 0..=40 {
                    let u = (a + (b - a) * f64::from(k) / 40.0).min(b);
                    let (p, q) =
                        (even.shape.point(u).unwrap(), even.shape.point((a + (b - u)).clamp(a, b)).unwrap());
                    assert!((image(p) - q).norm() < 1e-11, "{degree} {rational}: {p} {q}");
                    largest = largest.max((p - curve.point(u).unwrap()).norm());
                }
                if !rational {
                    assert!(largest <= even.moved.unwrap() * (1.0 + 1e-9), "{largest} {:?}", even.moved);
                }
                // Once symmetric it stays as it is.
                let again = symmetrize(&even.shape, &plane, Half::Both).unwrap();
                assert!(again.moved.unwrap() < 1e-11 * n as f64, "{:?}", again.moved);
            }
        }
    }
}

/// Sizes whose squares are no numbers: the shape is that of size 1, and so is what it moved by.
#[test]
fn what_moves_is_told_at_all_sizes() {
    let plane = Mirror::new(Point::origin(), Vector::x()).unwrap();
    let of = |size: f64| {
        let points = [[-2.0, 0.1], [-1.0, 2.0], [1.1, 2.0], [2.0, 0.0]];
        let points = points.map(|[x, y]| Point::new(x * size, y * size, 0.0)).to_vec();
        symmetrize(&Curve::bezier(points).unwrap(), &plane, Half::Both).unwrap()
    };
    let one = of(1.0);
    for size in [1e-300, 1e-160, 1e160, 1e300] {
        let even = of(size);
        let moved = even.moved.unwrap() / size;
        assert!((moved - one.moved.unwrap()).abs() < 1e-12, "{size:e}: {moved}");
        assert_eq!(even.shape.points().len(), one.shape.points().len(), "{size:e}");
        for (p, q) in even.shape.points().iter().zip(one.shape.points()) {
            assert!((p / size - q).norm() < 1e-12, "{size:e}: {p}");
        }
    }
}

#[test]
fn closed_curves_begin_in_the_plane() {
    let (plane, image) = mirror();
    for degree in [2, 3, 5] {
        let at = |i: usize| {
            let a = TAU * i as f64 / 9.0 + 0.4;
            Point::new(2.0 * a.cos() + 0.2 * (3.0 * a).cos(), 2.0 * a.sin(), 0.3 * a.sin())
        };
        let ring = Curve::new(Space::periodic_uniform(degree, 9).unwrap(), (0..9).map(at).collect()).unwrap();
        for half in [Half::Both, Half::Front, Half::Back] {
            for curve in [ring.clone(), ring.to_clamped().unwrap()] {
                let even = symmetrize(&curve, &plane, half).unwrap();
                let shape = &even.shape;
                assert_eq!(shape.is_periodic(), curve.is_periodic());
                assert_eq!(even.moved.is_some(), half == Half::Both);
                let (a, b) = shape.domain();
                assert!((image(shape.point(a).unwrap()) - shape.point(a).unwrap()).norm() < 1e-13);
                for k in 0..=40 {
                    let u = (a + (b - a) * f64::from(k) / 40.0).min(b);
                    let q = shape.point((a + (b - u)).clamp(a, b)).unwrap();
                    assert!((image(shape.point(u).unwrap()) - q).norm() < 1e-12);
                    if half == Half::Both {
                        assert!(ring.closest(q).unwrap().distance <= even.moved.unwrap() * 1.0001);
                    }
                }
            }
        }
    }
}

#[test]
fn a_half_is_kept_to_the_bit() {
    let plane = Mirror::new(Point::new(0.25, 0.0, 0.0), Vector::x()).unwrap();
    let curve = wave(Space::clamped_uniform(3, 8).unwrap(), true);
    for (half, kept) in [(Half::Front, 1.0), (Half::Back, 0.0)] {
        let even = symmetrize(&curve, &plane, half).unwrap().shape;
        let (a, b) = even.domain();
        let end = even.point(a + kept * (b - a)).unwrap();
        let (c, d) = curve.domain();
        assert_eq!(end, curve.point(c + kept * (d - c)).unwrap());
        for k in 0..=60 {
            let p = even.point((a + (b - a) * f64::from(k) / 60.0).min(b)).unwrap();
            let inside =
                if (p.x > 0.25) == (half == Half::Front) { p } else { Point::new(0.5 - p.x, p.y, p.z) };
            assert!(curve.closest(inside).unwrap().distance < 1e-13);
        }
    }
}

#[test]
fn surfaces_are_symmetric_along_either_direction() {
    let (plane, image) = mirror();
    for degree in [1, 3, 6] {
        let (u, v) =
            (Space::clamped_uniform(degree, degree + 3).unwrap(), Space::floating_uniform(2, 6).unwrap());
        let (n, m) = (u.len(), v.len());
        let at = |k: usize| {
            let (i, j) = ((k / m) as f64, (k % m) as f64);
            Point::new(i, j, (i * 1.3 + j).sin())
        };
        let weights = (0..n * m).map(|k| 1.0 + 0.3 * (k as f64).sin()).collect();
        let sheet = Surface::rational(u, v, (0..n * m).map(at).collect(), weights).unwrap();
        for direction in [Direction::U, Direction::V] {
            let even = symmetrize_surface(&sheet, &plane, direction, Half::Both).unwrap().shape;
            let ((a, b), (c, d)) = (even.u().domain(), even.v().domain());
            for i in 0..=10 {
                for j in 0..=10 {
                    let (u, v) = (a + (b - a) * f64::from(i) / 10.0, c + (d - c) * f64::from(j) / 10.0);
                    let (x, y) = if direction == Direction::U { (a + (b - u), v) } else { (u, c + (d - v)) };
                    let (p, q) = (
                        even.point(u.min(b), v.min(d)).unwrap(),
                        even.point(x.clamp(a, b), y.clamp(c, d)).unwrap(),
                    );
                    assert!((image(p) - q).norm() < 1e-11);
                }
            }
        }
    }
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap().to_periodic(0.0).unwrap().shape;
    let pipe = Surface::extrusion(&ring, Vector::z()).unwrap();
    let message = symmetrize_surface(&pipe, &plane, Direction::U, Half::Front).unwrap_err().to_string();
    assert!(message.contains("periodic in u"), "{message}");
    assert!(symmetrize_surface(&pipe, &plane, Direction::V, Half::Both).is_ok());
}

#[test]
fn what_has_no_mirror_image_is_told_why() {
    let plane = Mirror::new(Point::new(9.0, 0.0, 0.0), Vector::x()).unwrap();
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let said = |curve: &Curve, half| symmetrize(curve, &plane, half).unwrap_err().to_string();
    assert!(said(&ring, Half::Both).contains("does not cross the plane"));
    assert!(
        said(&ring, Half::Front)
            .contains("crosses the plane nowhere: to keep one half, it is to cross it twice")
    );
    let line = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
    assert!(
        said(&line, Half::Back)
            .contains("crosses the plane nowhere: to keep one half, it is to cross it once")
    );
    assert!(symmetrize(&line, &plane, Half::Both).is_ok());
    assert!(Mirror::new(Point::origin(), Vector::zeros()).is_err());
    assert!(Mirror::new(Point::new(f64::NAN, 0.0, 0.0), Vector::x()).is_err());
}

/// One half of a surface and its mirror image: where the plane is a line of the parameter, else it is said where it is not.
#[test]
fn half_of_a_surface_is_mirrored_where_the_plane_is_a_line_of_it() {
    let wave = |i: usize, j: usize| 0.3 * (1.3 * i as f64 + 0.7 * j as f64).sin();
    for (p, q) in [(1, 1), (2, 3), (3, 2), (5, 4), (7, 7)] {
        for weighted in [false, true] {
            let (u, v) =
                (Space::clamped_uniform(p, p + 5).unwrap(), Space::clamped_uniform(q, q + 2).unwrap());
            // Straight across in x, so that x = 0.3 is a line of u, whatever y and z do.
            let greville: Vec<f64> = (0..u.len()).map(|i| u.greville(i)).collect();
            let columns = v.len();
            let points = (0..u.len() * columns)
                .map(|k| (k / columns, k % columns))
                .map(|(i, j)| Point::new(greville[i] - 1.3, j as f64 + wave(i, j), wave(j, i)))
                .collect();
            let weights = weighted
                .then(|| (0..u.len() * columns).map(|k| 1.0 + 0.3 * ((k % columns) as f64).sin()).collect());
            let sheet = Surface::build(u, v, points, weights).unwrap();
            let plane = Mirror::new(Point::new(0.3, 0.0, 0.0), Vector::x()).unwrap();
            for (half, side) in [(Half::Front, 1.0), (Half::Back, -1.0)] {
                let whole = symmetrize_surface(&sheet, &plane, Direction::U, half).unwrap();
                assert_eq!(whole.moved, None);
                let whole = whole.shape;
                let ((a, b), (c, d)) = (whole.u().domain(), whole.v().domain());
                let at = |s: f64, t: f64| whole.point(a + (b - a) * s, c + (d - c) * t).unwrap();
                for k in 0..=40 {
                    let (s, t) = (f64::from(k) / 40.0, f64::from(k * 7 % 41) / 40.0);
                    let (x, y) = (at(s, t), at(1.0 - s, t));
                    assert!(
                        (x.x + y.x - 0.6).abs() < 1e-12
                            && (x.y - y.y).abs() < 1e-12
                            && (x.z - y.z).abs() < 1e-12
                    );
                    // What was on that side is there still, where it was.
                    if (x.x - 0.3) * side > 1e-6 {
                        let was = sheet.point(x.x + 1.3, c + (d - c) * t).unwrap();
                        assert!((was - x).norm() < 1e-11, "{p} {q} {weighted}: {was} {x}");
                    }
                }
                // A half that ends in the plane has all of it.
                let parts = sheet.split(Direction::U, 1.6).unwrap();
                let own = if side > 0.0 { &parts[1] } else { &parts[0] };
                let again = symmetrize_surface(own, &plane, Direction::U, half).unwrap().shape;
                let largest = again
                    .points()
                    .iter()
                    .zip(whole.points())
                    .map(|(x, y)| (x - y).norm())
                    .fold(0.0, f64::max);
                assert!(again.points().len() == whole.points().len() && largest < 1e-12);
                let other = if side > 0.0 { Half::Back } else { Half::Front };
                assert!(
                    symmetrize_surface(own, &plane, Direction::U, other)
                        .unwrap_err()
                        .to_string()
                        .contains("nothing of the surface")
                );
            }
            let slanted = Mirror::new(Point::new(0.3, 2.0, 0.0), Vector::new(1.0, 0.1, 0.0)).unwrap();
            let refused =
                symmetrize_surface(&sheet, &slanted, Direction::U, Half::Front).unwrap_err().to_string();
            assert!(refused.contains("along no line of u") && refused.contains(" at ("), "{refused}");
            let beyond = Mirror::new(Point::new(90.0, 0.0, 0.0), Vector::x()).unwrap();
            let refused =
                symmetrize_surface(&sheet, &beyond, Direction::U, Half::Back).unwrap_err().to_string();
            assert!(refused.contains("meets the plane nowhere"), "{refused}");
        }
    }
}

/// A half profile that begins in the plane, as people draw it, is a half as it stands; one that ends there, too; one that does both is closed.
#[test]
fn a_half_that_begins_in_the_plane_is_kept_as_it_is() {
    let (plane, image) = mirror();
    let (across, along) = (Vector::new(1.0, 0.5, -0.2).normalize(), Vector::new(0.5, -1.0, 0.0).normalize());
    for size in [1e-6, 1.0, 1e6] {
        let plane = if size == 1.0 { plane } else { Mirror::new(Point::origin(), across).unwrap() };
        let origin = if size == 1.0 { Point::new(0.3, -0.2, 0.1) } else { Point::origin() };
        let image =
            |p: Point| if size == 1.0 { image(p) } else { p - across * (2.0 * p.coords.dot(&across)) };
        for degree in [1, 2, 3, 5] {
            // Heights above the plane, from one end to the other.
            for heights in [
                [0.0, 2.0, 1.0, 3.0, 2.5, 3.0],
                [3.0, 1.0, 2.0, 0.5, 1.0, 0.0],
                [0.0, 1.0, 2.0, 2.0, 1.0, 0.0],
            ] {
                for side in [1.0, -1.0] {
                    let at = |(k, h): (usize, &f64)| {
                        origin + (across * (h * side) + along * (k as f64 - 1.3)) * size
                    };
                    let points = heights.iter().enumerate().map(at).collect();
                    let space = Space::clamped_uniform(degree, heights.len()).unwrap();
                    let curve = Curve::new(space, points).unwrap();
                    let (half, other) =
                        if side > 0.0 { (Half::Front, Half::Back) } else { (Half::Back, Half::Front) };
                    let whole = symmetrize(&curve, &plane, half).unwrap().shape;
                    let (a, b) = whole.domain();
                    for k in 0..=40 {
                        let x = f64::from(k) / 40.0;
                        let p = whole.point((a + (b - a) * x).min(b)).unwrap();
                        let q = whole.point((b - (b - a) * x).max(a)).unwrap();
                        assert!((image(p) - q).norm() < 1e-11 * size, "{size} {degree} {heights:?}");
                    }
                    let (c, d) = curve.domain();
                    for k in 0..=20 {
                        let p = curve.point((c + (d - c) * f64::from(k) / 20.0).min(d)).unwrap();
                        assert!(whole.closest(p).unwrap().distance < 1e-11 * size);
                    }
                    let length = whole.length(1e-9 * size).unwrap().value;
                    assert!((length - 2.0 * curve.length(1e-9 * size).unwrap().value).abs() < 1e-7 * size);
                    let closes = (whole.point(a).unwrap() - whole.point(b).unwrap()).norm() < 1e-11 * size;
                    assert_eq!(closes, heights[0] == 0.0 && heights[5] == 0.0);
                    let refused = symmetrize(&curve, &plane, other).unwrap_err().to_string();
                    assert!(refused.contains("keep the other half"), "{refused}");
                }
            }
        }
    }
}

/// A circle whose centre is off the plane stays a circle of its radius, about the foot of its centre, with its own vertices; so does one that was begun
/// elsewhere, turned or weighted otherwise.
#[test]
fn a_circle_stays_a_circle() {
    let distance = |curve: &Curve, center: Point, normal: Vector, radius: f64| {
        let (a, b) = curve.domain();
        let at = |k: i32| curve.point((a + (b - a) * f64::from(k) / 97.0).min(b)).unwrap() - center;
        (0..=97).map(|k| (at(k).norm() - radius).abs().max(at(k).dot(&normal).abs())).fold(0.0, f64::max)
    };
    for size in [1e-6, 1.0, 1e6] {
        let center = Point::new(size, 0.4 * size, 0.0);
        for angle in [0.0, 0.3, 1.0, 2.5] {
            let across = Vector::new(f64::cos(angle), f64::sin(angle), 0.0);
            let plane = Mirror::new(Point::origin(), across * 7.0).unwrap();
            let foot = center - across * center.coords.dot(&across);
            let circle = Curve::circle(center, Vector::z(), 5.0 * size).unwrap();
            let ring = circle.to_periodic(0.0).unwrap().shape;
            for (curve, same) in [
                (circle.clone(), true),
                (circle.reverse().unwrap(), true),
                (circle.started_at(circle.domain().1 / 4.0).unwrap(), true),
                (ring, true),
                (circle.elevate(3).unwrap(), true),
                // Begun within a quarter its knots are not symmetric: it gets those of a circle.
                (circle.started_at(0.7).unwrap(), false),
                (circle.elevate(1).unwrap().insert_knots(&[0.4, 0.4, 1.9]).unwrap(), false),
            ] {
                let even = symmetrize(&curve, &plane, Half::Both).unwrap();
                let off = distance(&even.shape, foot, Vector::z(), 5.0 * size);
                let moved = even.moved.unwrap();
                assert!(off < 1e-12 * size, "{size} {angle}: {off}");
                assert!((moved - (center - foot).norm()).abs() < 1e-12 * size, "{moved}");
                assert_eq!(even.shape.degree(), curve.degree());
                let (before, after) = (even.shape.domain(), curve.domain());
                assert!((before.1 - before.0 - (after.1 - after.0)).abs() < 1e-12);
                if same {
                    assert_eq!(even.shape.points().len(), curve.points().len(), "{size} {angle}");
                }
                let (a, b) = even.shape.domain();
                for k in 0..=40 {
                    let u = (a + (b - a) * f64::from(k) / 40.0).min(b);
                    let (p, q) =
                        (even.shape.point(u).unwrap(), even.shape.point((b - (u - a)).max(a)).unwrap());
                    assert!((p - across * (2.0 * p.coords.dot(&across)) - q).norm() < 1e-13 * 50.0 * size);
                }
                let again = symmetrize(&even.shape, &plane, Half::Both).unwrap();
                assert!(again.moved.unwrap() < 1e-12 * size, "{:?}", again.moved);
            }
        }
    }
}

/// A closed curve that is symmetric but for where it lies and begins comes back as it was, moved: by the start that fits, which is no crossing of the plane.
#[test]
fn a_closed_curve_begins_where_its_image_fits() {
    let plane = Mirror::new(Point::origin(), Vector::x()).unwrap();
    for (degree, count) in [(1, 12), (2, 9), (3, 14), (5, 16)] {
        // An egg, symmetric about x = 0.8.
        let at = |i: usize| {
            let a = TAU * i as f64 / count as f64;
            Point::new(0.8 + (2.0 + 0.5 * a.cos()) * a.sin(), 3.0 * a.cos(), 0.2 * (2.0 * a).cos())
        };
        let space = Space::periodic_uniform(degree, count).unwrap();
        let egg = Curve::new(space, (0..count).map(at).collect()).unwrap();
        let (a, b) = egg.domain();
        for share in [0.0, 1.0 / 3.0, 0.41, 0.77] {
            for curve in [egg.started_at(a + (b - a) * share).unwrap(), egg.to_clamped().unwrap()] {
                let even = symmetrize(&curve, &plane, Half::Both).unwrap();
                assert!((even.moved.unwrap() - 0.8).abs() < 1e-9, "{degree} {share}: {:?}", even.moved);
                let (c, d) = even.shape.domain();
                for k in 0..50 {
                    let p = even.shape.point(c + (d - c) * f64::from(k) / 50.0).unwrap();
                    let off = egg.closest(p + Vector::x() * 0.8).unwrap().distance;
                    assert!(off < 1e-9, "{degree} {share}: {off}");
                }
            }
        }
    }
}

/// A drum about an axis that the plane holds is symmetric, wherever its seam is, closed or periodic; beside the plane it is moved there. By itself the direction
/// is the one round it: along its axis it would become the mean of opposite sides, a line.
#[test]
fn drums_stay_drums() {
    for (seam, offset) in
        [(0.0_f64, 0.0), (0.7, 0.0), (0.0, 1.0), (0.7, 1.0), (std::f64::consts::FRAC_PI_2, 0.3)]
    {
        let plane = Mirror::new(Point::new(offset, 0.0, 0.0), Vector::x()).unwrap();
        let [from, to] = [0.0, 12.0].map(|z| Point::new(10.0 * seam.cos(), 10.0 * seam.sin(), z));
        let line = Curve::new(Space::clamped_uniform(1, 2).unwrap(), vec![from, to]).unwrap();
        let drum = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
        let round = if (drum.isocurve(Direction::U, drum.u().domain().0).unwrap().points().len()) > 2 {
            Direction::V
        } else {
            Direction::U
        };
        let ring = drum.to_periodic(round, 1e-12).unwrap().shape;
        for surface in [&drum, &ring] {
            let (even, way) = symmetrize_surface_best(surface, &plane, Half::Both).unwrap();
            assert!(
                even.moved.unwrap() < 12.0
                    && even.shape.space(way).is_periodic() == surface.space(round).is_periodic()
            );
            assert_eq!(way, round, "{seam} {offset}");
            let ((a, b), (c, d)) = (even.shape.u().domain(), even.shape.v().domain());
            for i in 0..=20 {
                for j in 0..=20 {
                    let at = |x: f64, y: f64| {
                        even.shape.point((a + (b - a) * x).min(b), (c + (d - c) * y).min(d)).unwrap()
                    };
                    let (x, y) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let p = at(x, y);
                    let q = if way == Direction::U { at(1.0 - x, y) } else { at(x, 1.0 - y) };
                    let image = Point::new(2.0 * offset - p.x, p.y, p.z);
                    assert!((image - q).norm() < 1e-11, "{seam} {offset}: {p} {q}");
                    // What begins in the middle of an arc is no circle any more, as a curve's mean with its image, but as near as that is.
                    let radius = (p.x - offset).hypot(p.y);
                    assert!(
                        (radius - 10.0).abs() < if seam == 0.7 { 0.5 } else { 1e-10 },
                        "{seam} {offset}: {radius}"
                    );
                }
            }
        }
    }
}

/// A closed curve that begins beside the plane by rounding begins in it.
#[test]
fn what_begins_beside_the_plane_by_rounding_begins_in_it() {
    let plane = Mirror::new(Point::origin(), Vector::x()).unwrap();
    for degree in [1, 2, 3] {
        for off in [-1e-15, -1e-16, 0.0, 1e-16, 1e-15] {
            let around =
                [[off, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [off, 0.0]];
            let points: Vec<Point> = around.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect();
            let curve = Curve::new(Space::clamped_uniform(degree, 7).unwrap(), points).unwrap();
            for half in [Half::Front, Half::Back] {
                let found = symmetrize(&curve, &plane, half).unwrap().shape;
                let again = symmetrize(&found, &plane, half).unwrap().shape;
                for shape in [&found, &again] {
                    let (a, b) = shape.domain();
                    for k in 0..=40 {
                        let at = |x: f64| shape.point((a + (b - a) * x).min(b)).unwrap();
                        let (p, q) = (at(f64::from(k) / 40.0), at(1.0 - f64::from(k) / 40.0));
                        assert!((Point::new(-p.x, p.y, p.z) - q).norm() < 1e-12, "{degree} {off} {half:?}");
                    }
                }
            }
        }
    }
}

/// The exact ellipse `c + x cos θ + y sin θ`, as nine vertices.
fn ellipse(center: Point, x: Vector, y: Vector) -> Curve {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let (space, points, weights) = circle.into_parts();
    let points = points.iter().map(|p| center + x * p.x + y * p.y).collect();
    Curve::build(space, points, weights).unwrap()
}

/// The mean of an ellipse and its mirror image is an ellipse: of all `c + X cos θ + Y sin θ` the one whose matrix `X Xᵀ + Y Yᵀ` is symmetric, without a corner, begun in the mirror.
#[test]
fn an_ellipse_stays_an_ellipse() {
    let (plane, image) = mirror();
    let (x, y) = (Vector::new(5.0, 3.0, 0.5), Vector::new(-2.0, 6.0, 1.0));
    for size in [1e-160, 1.0, 1e150] {
        let (plane, center) = if size == 1.0 {
            (plane, Point::new(1.0, 0.5, -0.3))
        } else {
            (Mirror::new(Point::origin(), Vector::new(1.0, 0.5, -0.2)).unwrap(), Point::origin())
        };
        let flip = |v: Vector| {
            let normal = Vector::new(1.0, 0.5, -0.2).normalize();
            v - normal * (2.0 * v.dot(&normal))
        };
        let given = ellipse(center, x * size, y * size);
        let periodic = given.to_periodic(1e-12 * size).unwrap().shape;
        for curve in [given.clone(), given.elevate(2).unwrap(), given.started_at(0.1).unwrap(), periodic] {
            let even = symmetrize(&curve, &plane, Half::Both).unwrap();
            assert!(even.corners.is_empty(), "{:?}", even.corners);
            assert_eq!(
                (even.shape.degree(), even.shape.is_periodic()),
                (curve.degree(), curve.is_periodic())
            );
            // On a conic: a piece of a rational curve of degree p is one if 2p + 1 places are; its own middle and half diameters from four places a quarter apart, which the usual weights have.
            let (a, b) = even.shape.domain();
            let at = |share: f64| (even.shape.point(a + (b - a) * share).unwrap() - center) / size;
            let middle = (at(0.0) + at(0.5)) / 2.0;
            let (u, v) = (at(0.0) - middle, at(0.25) - middle);
            let mut furthest = 0.0_f64;
            for k in 0..=400 {
                let place = at(f64::from(k) / 400.0) - middle;
                let gram = nalgebra::Matrix2::new(u.dot(&u), u.dot(&v), u.dot(&v), v.dot(&v));
                let seen = gram.try_inverse().unwrap() * nalgebra::Vector2::new(u.dot(&place), v.dot(&place));
                assert!((seen.norm() - 1.0).abs() < 1e-11, "{size:e} {k}: {seen}");
                let other = at(1.0 - f64::from(k) / 400.0);
                if size == 1.0 {
                    let mirrored = image(center + at(f64::from(k) / 400.0));
                    assert!((mirrored - (center + other)).norm() < 1e-12);
                }
                let nearest = (0..2000)
                    .map(|j| {
                        let angle = TAU * f64::from(j) / 2000.0;
                        (at(f64::from(k) / 400.0) - x * angle.cos() - y * angle.sin()).norm()
                    })
                    .fold(f64::INFINITY, f64::min);
                furthest = furthest.max(nearest);
            }
            assert!(furthest * size <= even.moved.unwrap() * 1.01, "{furthest} {:?}", even.moved);
            // Of the means with the image, run through from any phase, the one nearest to the given ellipse in the square, all round: each is symmetric.
            // Half the sum of the squares of what the half diameters move by.
            let mut least = (f64::INFINITY, [x, y]);
            for k in 0..100_000 {
                let (sine, cosine) = (TAU * f64::from(k) / 100_000.0).sin_cos();
                let turned = [flip(x) * cosine + flip(y) * sine, flip(x) * sine - flip(y) * cosine];
                let arms = [0.5 * (x + turned[0]), 0.5 * (y + turned[1])];
                let square = (x - arms[0]).norm_squared() + (y - arms[1]).norm_squared();
                if square < least.0 {
                    least = (square, arms);
                }
            }
            // The same ellipse, whatever its half diameters: the same `X Xᵀ + Y Yᵀ`; the phase is known to 6e-5.
            let spread = |[p, q]: [Vector; 2]| p * p.transpose() + q * q.transpose();
            let off = (spread([u, v]) - spread(least.1)).norm() / spread(least.1).norm();
            assert!(off < 1e-4, "{size:e}: {off}");
            // About the foot of the centre.
            let foot = nalgebra::center(&center, &(if size == 1.0 { image(center) } else { center }));
            assert!((center + middle * size - foot).norm() < 1e-12 * size);
            let again = symmetrize(&even.shape, &plane, Half::Both).unwrap();
            assert!(again.moved.unwrap() < 1e-11 * size, "{size:e} {:?}", again.moved);
        }
    }
}

/// A rational curve whose weights are not symmetric is smooth where its derivative is, and so is the mean of its points; the mean of its vertices would turn.
#[test]
fn the_mean_of_a_smooth_rational_curve_is_smooth() {
    let (plane, image) = mirror();
    // Two rational pieces of degree 2 whose derivatives agree in the middle: `2 w₁/w (P₂ - P₁)` on both sides.
    let space = Space::open(2, vec![0.0, 0.0, 0.0, 0.3, 0.3, 1.0, 1.0, 1.0]).unwrap();
    let (before, after) = (Vector::new(-0.3, 0.0, 0.0), Vector::new(0.7, 0.0, 0.0));
    let joint = Point::new(0.1, 1.0, 0.0);
    let points = vec![
        Point::new(-1.0, 0.0, 0.2),
        joint + before / 0.5,
        joint,
        joint + after / 2.0,
        Point::new(1.5, -0.4, 0.0),
    ];
    let curve = Curve::rational(space, points, vec![1.0, 0.5, 1.0, 2.0, 1.0]).unwrap();
    let even = symmetrize(&curve, &plane, Half::Both).unwrap();
    assert!(even.corners.is_empty(), "{:?}", even.corners);
    assert_eq!(even.shape.degree(), 4);
    for k in 0..=100 {
        let u = f64::from(k) / 100.0;
        let p = even.shape.point(u).unwrap();
        assert!((image(p) - even.shape.point(1.0 - u).unwrap()).norm() < 1e-13);
        let (q, r) = (curve.point(u).unwrap(), image(curve.point(1.0 - u).unwrap()));
        assert!((p - nalgebra::center(&q, &r)).norm() < 1e-13, "{u}: {p}");
        assert!((p - q).norm() <= even.moved.unwrap() * (1.0 + 1e-12));
    }
    // Once symmetric it is its own mean.
    let again = symmetrize(&even.shape, &plane, Half::Both).unwrap();
    assert!(again.moved.unwrap() < 1e-13 && again.shape.degree() == 4, "{:?}", again.moved);
}

/// What turns by its speed, as a spline whose joint is smooth by direction only, is told: where, and by how much.
#[test]
fn corners_that_were_not_there_are_told() {
    let plane = Mirror::new(Point::origin(), Vector::x()).unwrap();
    let space = Space::open(1, vec![0.0, 0.0, 0.25, 1.0, 1.0]).unwrap();
    let points = [[-2.0, 0.0], [-1.0, 1.0], [2.0, 4.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let even = symmetrize(&Curve::new(space, points).unwrap(), &plane, Half::Both).unwrap();
    // A straight line run through evenly and its image: straight at 0.25, but at 0.75, where only the image's knot is, no less.
    assert!(even.corners.is_empty(), "{:?}", even.corners);
    let space = Space::open(2, vec![0.0, 0.0, 0.0, 0.25, 0.25, 1.0, 1.0, 1.0]).unwrap();
    let points =
        [[-2.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [2.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let curve = Curve::new(space, points.to_vec()).unwrap();
    let even = symmetrize(&curve, &plane, Half::Both).unwrap();
    // Of two corners that mirror one another each: measured just beside.
    assert_eq!(even.corners.len(), 2, "{:?}", even.corners);
    for (corner, u) in even.corners.iter().zip([0.25, 0.75]) {
        assert!((corner.place - even.shape.point(u).unwrap()).norm() < 1e-12);
        let (before, after) =
            (even.shape.derivative(u - 1e-9, 1).unwrap(), even.shape.derivative(u + 1e-9, 1).unwrap());
        assert!((before.angle(&after) - corner.angle).abs() < 1e-6, "{corner:?}");
    }
    // A half of a circle's arc that meets the plane askew: twice the angle that it is off.
    let arc =
        Curve::bezier(vec![Point::new(0.0, 0.0, 0.0), Point::new(1.0, 0.2, 0.0), Point::new(2.0, 2.0, 0.0)])
            .unwrap();
    let even = symmetrize(&arc, &plane, Half::Front).unwrap();
    let [corner] = even.corners[..] else { panic!("{:?}", even.corners) };
    assert!((corner.angle - 2.0 * 0.2_f64.atan()).abs() < 1e-12 && corner.place.coords.norm() < 1e-12);
    // An ellipse: at both ends of its half.
    let tilted = ellipse(Point::origin(), Vector::new(5.0, 3.0, 0.0), Vector::new(-2.0, 6.0, 0.0));
    for half in [Half::Front, Half::Back] {
        let even = symmetrize(&tilted, &plane, half).unwrap();
        assert_eq!(even.corners.len(), 2, "{:?}", even.corners);
        for corner in &even.corners {
            // x = 5 cos θ - 2 sin θ = 0 where tan θ = 5/2: the tangent there is -5 sin θ - 2 cos θ : -3 sin θ + 6 cos θ.
            let (sine, cosine) = 2.5_f64.atan().sin_cos();
            let off = ((-3.0 * sine + 6.0 * cosine) / (-5.0 * sine - 2.0 * cosine)).atan().abs();
            assert!((corner.angle - 2.0 * off).abs() < 1e-9, "{corner:?} {off}");
        }
        // Its corners were there: of a shape that is symmetric nothing is said.
        let again = symmetrize(&even.shape, &plane, half).unwrap();
        assert!(again.corners.is_empty(), "{:?}", again.corners);
    }
}

/// As the curves do, swept: the crease lies along the plane.
#[test]
fn creases_that_were_not_there_are_told() {
    let plane = Mirror::new(Point::origin(), Vector::x()).unwrap();
    let ends = [[0.0, 0.0], [1.0, 0.2], [2.0, 2.0]];
    let points = ends.iter().flat_map(|[x, y]| [Point::new(*x, *y, 0.0), Point::new(*x, *y, 3.0)]).collect();
    let (u, v) = (Space::clamped_uniform(2, 3).unwrap(), Space::clamped_uniform(1, 2).unwrap());
    let even =
        symmetrize_surface(&Surface::new(u, v, points).unwrap(), &plane, Direction::U, Half::Front).unwrap();
    let [crease] = even.corners[..] else { panic!("{:?}", even.corners) };
    assert!((crease.angle - 2.0 * 0.2_f64.atan()).abs() < 1e-12 && crease.place.x.abs() < 1e-12);
    // A drum over an ellipse: the mean of its vertices turns where the curve's does.
    let tilted = ellipse(Point::origin(), Vector::new(5.0, 3.0, 0.0), Vector::new(-2.0, 6.0, 0.0));
    let (space, points, weights) = tilted.into_parts();
    let net = points.iter().flat_map(|p| [*p, p + Vector::z()]).collect();
    let weights = weights.unwrap().iter().flat_map(|w| [*w, *w]).collect();
    let drum = Surface::rational(space, Space::clamped_uniform(1, 2).unwrap(), net, weights).unwrap();
    let even = symmetrize_surface(&drum, &plane, Direction::U, Half::Both).unwrap();
    assert!(!even.corners.is_empty());
    assert!(even.corners.iter().all(|c| c.angle > 1e-4 && c.angle < 0.1), "{:?}", even.corners);
}

/// A half made symmetric once is its own half: also where the curve begins in the plane, with a corner, to rounding beside it.
#[test]
fn a_half_of_what_is_symmetric_is_it() {
    let normal = Vector::new(-0.1438992708614152, 0.7149839988395522, -0.6841716752752603);
    let mut random = 1_u64;
    let mut next = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / 16_777_216.0 - 0.5
    };
    let (mut halves, mut refusals) = (0, Vec::new());
    for trial in 0..200 {
        let plane = Mirror::new(
            Point::new(next(), next(), next()) * 0.1,
            normal + Vector::new(next(), next(), next()),
        )
        .unwrap();
        let n = 7 + trial % 5;
        let (a, b) = (Vector::new(1.0, 0.3, 0.0), Vector::new(0.2, 0.8, -0.9));
        let points = (0..=n).map(|i| {
            let (sine, cosine) = (TAU * (i % n) as f64 / n as f64 + 0.3).sin_cos();
            Point::from(a * cosine + b * sine)
        });
        let degree = 1 + trial % 3;
        let curve = Curve::new(Space::clamped_uniform(degree, n + 1).unwrap(), points.collect()).unwrap();
        for half in [Half::Front, Half::Back] {
            let once = match symmetrize(&curve, &plane, half) {
                Ok(once) => once,
                Err(error) => {
                    refusals.push(format!("{trial} {half:?}: {error}"));
                    continue;
                }
            };
            halves += 1;
            for again in [Half::Front, Half::Back, Half::Both] {
                let twice = symmetrize(&once.shape, &plane, again).unwrap();
                let (c, d) = once.shape.domain();
                assert!(twice.corners.is_empty(), "{trial} {half:?} {again:?}: {:?}", twice.corners);
                if again != half {
                    continue;
                }
                for k in 0..=50 {
                    let u = c + (d - c) * f64::from(k) / 50.0;
                    let (e, f) = twice.shape.domain();
                    let v = e + (f - e) * f64::from(k) / 50.0;
                    let off =
                        (once.shape.point(u.min(d)).unwrap() - twice.shape.point(v.min(f)).unwrap()).norm();
                    assert!(off < 1e-9, "{trial} {half:?} {k}: {off}");
                }
            }
        }
    }
    assert_eq!(halves, 400, "{}", refusals.join("\n"));
}

/// Where the plane meets only a part of a surface's lines this is said, and where nothing is on the side that is kept this, whatever the direction.
#[test]
fn why_a_half_of_a_surface_is_refused_is_true() {
    let arc =
        Curve::bezier([[0.0, 0.0], [10.0, 8.0], [20.0, 0.0]].map(|[x, z]| Point::new(x, 0.0, z)).to_vec());
    let hood = Surface::extrusion(&arc.unwrap(), Vector::y() * 30.0).unwrap();
    let round = if hood.isocurve(Direction::U, hood.u().domain().0).unwrap().points().len() > 2 {
        Direction::V
    } else {
        Direction::U
    };
    let told = |plane: &Mirror, way: Direction, half: Half| {
        symmetrize_surface(&hood, plane, way, half).unwrap_err().to_string()
    };
    let askew = Mirror::new(Point::new(9.0, 0.0, 0.0), Vector::new(1.0, 1.0, 0.0)).unwrap();
    for half in [Half::Front, Half::Back] {
        let told = told(&askew, round, half);
        assert!(told.contains("on a part of its lines only") && !told.contains("nowhere"), "{told}");
    }
    // In the one direction it meets the plane twice, in the other nowhere: all is in front.
    let below = Mirror::new(Point::origin(), Vector::z()).unwrap();
    for way in [Direction::U, Direction::V] {
        let told = told(&below, way, Half::Back);
        assert!(told.contains("nothing of the surface is behind the plane: keep the other half"), "{told}");
    }
    let told = symmetrize_surface_best(&hood, &below, Half::Back).unwrap_err().to_string();
    assert!(told.contains("keep the other half"), "{told}");
}

/// A half of what was made of a half is that, parameters and all, however often: of curves open and closed, and of surfaces.
#[test]
fn a_half_again_has_the_same_parameters() {
    let plane = Mirror::new(Point::new(0.25, 0.0, 0.0), Vector::x()).unwrap();
    let near = |x: (f64, f64), y: (f64, f64)| (x.0 - y.0).abs() < 1e-12 && (x.1 - y.1).abs() < 1e-12;
    for rational in [false, true] {
        let closed = Curve::circle(Point::new(0.1, 0.2, 0.0), Vector::z(), 1.5).unwrap();
        for curve in [wave(Space::clamped_uniform(3, 8).unwrap(), rational), closed] {
            for half in [Half::Front, Half::Back] {
                let once = symmetrize(&curve, &plane, half).unwrap().shape;
                let twice = symmetrize(&once, &plane, half).unwrap().shape;
                assert!(near(once.domain(), twice.domain()), "{:?} {:?}", once.domain(), twice.domain());
                for (x, y) in once.space().flat().iter().zip(twice.space().flat()) {
                    assert!((x - y).abs() < 1e-12, "{x} {y}");
                }
                for (p, q) in once.points().iter().zip(twice.points()) {
                    assert!((p - q).norm() < 1e-12, "{p} {q}");
                }
            }
        }
    }
    let (u, v) = (Space::clamped_uniform(3, 8).unwrap(), Space::clamped_uniform(2, 4).unwrap());
    let greville: Vec<f64> = (0..8).map(|i| u.greville(i)).collect();
    let at = |k: usize| Point::new(greville[k / 4] - 1.3, (k % 4) as f64, (k as f64).sin());
    let sheet = Surface::new(u, v, (0..32).map(at).collect()).unwrap();
    let plane = Mirror::new(Point::new(0.3, 0.0, 0.0), Vector::x()).unwrap();
    for half in [Half::Front, Half::Back] {
        let once = symmetrize_surface(&sheet, &plane, Direction::U, half).unwrap().shape;
        let twice = symmetrize_surface(&once, &plane, Direction::U, half).unwrap().shape;
        assert!(near(once.u().domain(), twice.u().domain()), "{:?}", twice.u().domain());
        assert!((once.u().domain().0 - sheet.u().domain().0).abs() < 1e-12);
        for (p, q) in once.points().iter().zip(twice.points()) {
            assert!((p - q).norm() < 1e-12, "{p} {q}");
        }
    }
}
