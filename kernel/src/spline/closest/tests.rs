use crate::spline::{Curve, Space, Surface};
use crate::{Point, Vector};

fn noise(state: &mut u32) -> f64 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*state) / 4_294_967_296.0
}

#[test]
fn no_sample_of_a_random_curve_is_closer() {
    let mut state = 7;
    for case in 0..30 {
        let n = 6 + case;
        let points: Vec<Point> =
            (0..n).map(|_| Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0))).collect();
        let weights = (0..n).map(|_| 0.3 + 3.0 * noise(&mut state)).collect();
        let space = if case % 2 == 0 {
            Space::clamped_uniform(3, n).unwrap()
        } else {
            Space::periodic_uniform(2, n).unwrap()
        };
        let curve = Curve::build(space, points, (case % 3 == 0).then_some(weights)).unwrap();
        let query = Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0));
        let found = curve.closest(query).unwrap();
        let (a, b) = curve.domain();
        assert!(found.gap <= 1e-9, "case {case}: gap {}", found.gap);
        assert!((curve.point(found.at).unwrap() - found.point).norm() < 1e-14);
        for i in 0..=2000 {
            let sample = curve.point(a + (b - a) * f64::from(i) / 2000.0).unwrap();
            assert!((sample - query).norm() >= found.distance - 1e-9, "case {case}");
        }
    }
}

#[test]
fn no_sample_of_a_random_surface_is_closer() {
    let mut state = 11;
    for case in 0..6 {
        let (n, m) = (5, 6);
        let points: Vec<Point> =
            (0..n * m).map(|k| Point::new((k / m) as f64, (k % m) as f64, 3.0 * noise(&mut state))).collect();
        let weights = (0..n * m).map(|_| 0.3 + 3.0 * noise(&mut state)).collect();
        let space = |n| Space::clamped_uniform(3, n).unwrap();
        let surface = Surface::build(space(n), space(m), points, (case % 2 == 0).then_some(weights)).unwrap();
        let query = Point::from(Vector::from_fn(|_, _| noise(&mut state) * 4.0));
        let found = surface.closest(query).unwrap();
        assert!(found.gap <= 1e-8, "case {case}: gap {}", found.gap);
        for i in 0..=60 {
            for j in 0..=60 {
                let (u, v) = (2.0 * f64::from(i) / 60.0, 3.0 * f64::from(j) / 60.0);
                assert!((surface.point(u, v).unwrap() - query).norm() >= found.distance - 1e-9);
            }
        }
    }
}

/// The place does not depend on the size, up to the ends of numbers.
#[test]
fn sizes_whose_squares_are_no_numbers_are_found_as_others() {
    let points = [[0.0, 0.0], [1.0, 2.0], [2.0, -1.0], [3.0, 2.0], [4.0, 0.0]];
    let query = [2.6, 1.7];
    let of = |size: f64| {
        let at = |[x, y]: [f64; 2]| Point::new(x * size, y * size, 0.1 * size);
        let points: Vec<Point> = points.map(at).to_vec();
        let curve = Curve::new(Space::clamped_uniform(3, 5).unwrap(), points.clone()).unwrap();
        let net = points.iter().flat_map(|p| [*p, p + Vector::z() * size]).collect();
        let line = Space::clamped_uniform(1, 2).unwrap();
        let sheet = Surface::new(Space::clamped_uniform(3, 5).unwrap(), line, net).unwrap();
        (curve.closest(at(query)).unwrap(), sheet.closest(at(query)).unwrap())
    };
    let (curve, sheet) = of(1.0);
    for size in [1e-300, 1e-160, 1e-90, 1e-59, 1e59, 1e90, 1e154, 1e160, 1e300, 2e307] {
        let (c, s) = of(size);
        assert!((c.at - curve.at).abs() < 1e-7, "{size:e}: {c:?}");
        assert!((c.distance / size - curve.distance).abs() < 1e-9, "{size:e}: {c:?}");
        assert!((s.at.0 - sheet.at.0).abs() < 1e-7, "{size:e}: {s:?}");
        assert!((s.distance / size - sheet.distance).abs() < 1e-9, "{size:e}: {s:?}");
        assert!(c.gap <= 1e-8 * size && s.gap <= 1e-8 * size, "{size:e}: {c:?} {s:?}");
    }
    // Small differences far out are left as they are.
    let near = Curve::bezier(vec![Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1e-200, 0.0)]).unwrap();
    assert_eq!(near.closest(Point::new(1.0, 1e-200, 0.0)).unwrap().distance, 0.0);
    let line = Curve::bezier(vec![Point::new(1.7e308, 0.0, 0.0), Point::new(1.7e308, 1.0, 0.0)]).unwrap();
    let error = line.closest(Point::new(-1.7e308, 0.0, 0.0)).unwrap_err().to_string();
    assert!(error.contains("larger than any number"), "{error}");
}

#[test]
fn a_slope_of_exactly_zero_is_the_root() {
    // x = 2t - 1 from (0, 1): Newton's method lands on the slope 0 at t = 1/2 at once.
    let line = Curve::bezier(vec![Point::new(-1.0, 0.0, 0.0), Point::new(1.0, 0.0, 0.0)]).unwrap();
    let found = line.closest(Point::new(0.0, 1.0, 0.0)).unwrap();
    assert_eq!((found.at, found.distance), (0.5, 1.0));
    let found = line.closest(Point::new(0.25, 1.0, 0.0)).unwrap();
    assert_eq!((found.at, found.distance), (0.625, 1.0));
}

#[test]
fn the_centre_of_an_arc_and_points_on_curves_are_quick() {
    let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
    let points = vec![Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0), Point::new(0.0, 1.0, 0.0)];
    let arc = Curve::rational(space, points, vec![1.0, 0.5_f64.sqrt(), 1.0]).unwrap();
    let found = arc.closest(Point::origin()).unwrap();
    assert!((found.distance - 1.0).abs() < 1e-14 && found.at == 0.0);
    for u in [0.0, 0.2, 1.0] {
        let found = arc.closest(arc.point(u).unwrap()).unwrap();
        assert!((found.at - u).abs() < 1e-7 && found.distance < 1e-12, "{found:?}");
    }
    assert!(arc.closest(Point::new(f64::NAN, 0.0, 0.0)).is_err());
}

/// The ends of pieces on both sides of a tear are there to be found.
#[test]
fn the_ends_before_a_tear_are_points_of_the_shape() {
    let space = Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap();
    let points = [[0.0, 0.0], [1.0, 0.0], [5.0, 5.0], [6.0, 5.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let torn = Curve::new(space.clone(), points.to_vec()).unwrap();
    for (query, end, distance) in [([1.25, 0.0], [1.0, 0.0], 0.25), ([4.0, 5.0], [5.0, 5.0], 1.0)] {
        let found = torn.closest(Point::new(query[0], query[1], 0.0)).unwrap();
        assert!((found.distance - distance).abs() < 1e-15, "{found:?}");
        assert!((found.point - Point::new(end[0], end[1], 0.0)).norm() < 1e-15, "{found:?}");
        assert!((torn.point(found.at).unwrap() - found.point).norm() < 1e-15, "its place is that point");
    }
    let net = points.iter().flat_map(|p| [*p, p + Vector::z()]).collect();
    let sheet = Surface::new(space, Space::clamped_uniform(1, 2).unwrap(), net).unwrap();
    let found = sheet.closest(Point::new(1.25, 0.0, 0.5)).unwrap();
    assert!((found.distance - 0.25).abs() < 1e-15, "{found:?}");
}

#[test]
fn a_hundred_thousand_vertices_leave_few_pieces_to_look_at() {
    let n = 100_000;
    let points = (0..n).map(|i| f64::from(i) * 0.01).map(|s| Point::new(s.cos() * s, s.sin() * s, 0.0));
    let curve = Curve::new(Space::clamped_uniform(3, n as usize).unwrap(), points.collect()).unwrap();
    for size in [0.5, 300.0, 2000.0] {
        let found = curve.closest(Point::new(size, 0.3 * size, 0.1)).unwrap();
        assert!(found.gap <= 1e-9 * size, "{found:?}");
    }
}

/// A span 1e-9 long at 1000 has some ten thousand parameters only: places between them are nobody's, and no search looks for them.
#[test]
fn a_span_of_few_parameters_is_not_searched_beyond_them() {
    let (a, b) = (1000.0, 1000.01);
    let (low, high) = (1_000.004_999_999, 1_000.005);
    let v = [[a; 4].as_slice(), &[low, high, high, high], &[b; 4]].concat();
    let (u, v) = (Space::clamped_uniform(3, 4).unwrap(), Space::open(3, v).unwrap());
    let columns = v.len();
    let at = |k: usize| {
        let (i, j) = ((k / columns) as f64 / 3.0, (k % columns) as f64 / (columns - 1) as f64);
        Point::new(i, j, 0.3 * (5.0 * i).sin() * (4.0 * j).cos())
    };
    let sheet = Surface::new(u, v, (0..4 * columns).map(at).collect()).unwrap();
    let mut most = 0;
    for (x, y) in [(0.1, 0.25), (0.3, 0.3), (0.5, 0.4), (0.6, 0.5), (0.9, 0.45), (0.5, 0.6)] {
        for z in [-0.4, -0.05, 0.0, 0.07, 0.3] {
            let point = Point::new(x, y, z);
            let (found, count) = sheet.nearly_closest_of(point, 0.0, 0.0, 200_000).unwrap();
            most = most.max(count);
            assert!(found.gap <= 2e-4 * (1.0 + found.distance), "{point}: {found:?}");
            let pieces = [(a, low), (low, high), (high, b)];
            for (k, (from, to)) in (0..=60).flat_map(|k| pieces.map(|piece| (k, piece))) {
                for l in 0..=60 {
                    let at = from + (to - from) * f64::from(l) / 60.0;
                    let sample = sheet.point(f64::from(k) / 60.0, at.min(to)).unwrap();
                    assert!((sample - point).norm() >= found.distance - found.gap, "{point}: {found:?}");
                }
            }
        }
    }
    assert!(most < 2000, "{most}");
}
