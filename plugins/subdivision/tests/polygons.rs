//! Subdivision curves are splines.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::Point;
use loftsman_kernel::spline::Curve;
use loftsman_subdivision::{Polygon, Scheme};

/// Polygons of all kinds: open and closed, uniform and not, with zeros.
fn all() -> Vec<Polygon> {
    let mut all = Vec::new();
    for scheme in [Scheme::Chaikin, Scheme::Cubic] {
        for closed in [false, true] {
            for n in 3..9 {
                for size in [1e-9, 1.0, 1e9] {
                    let point = |k: u64| {
                        Point::new(
                            crate::shapes::noise(k) * size,
                            crate::shapes::noise(k + 50) * size,
                            k as f64 * size,
                        )
                    };
                    let Ok(polygon) = Polygon::new(scheme, (0..n).map(point).collect(), closed) else {
                        assert!(n == 3 && !closed && scheme == Scheme::Cubic);
                        continue;
                    };
                    let spans = polygon.spans().len();
                    all.push(polygon.clone());
                    let uneven: Vec<f64> =
                        (0..spans).map(|k| 1.0 + 0.95 * crate::shapes::noise(k as u64)).collect();
                    all.push(polygon.clone().with_intervals(uneven.clone()).unwrap());
                    if spans > 3 {
                        let mut zero = uneven;
                        zero[2] = 0.0;
                        all.push(polygon.with_intervals(zero).unwrap());
                    }
                }
            }
        }
    }
    all
}

fn size(polygon: &Polygon) -> f64 {
    polygon.points().iter().fold(0.0, |most: f64, p| most.max(p.coords.norm()))
}

/// The distance of control vertices, whichever comes first: closed ones may begin elsewhere.
fn apart(polygon: &Polygon, curve: &Curve) -> f64 {
    let n = polygon.points().len();
    assert_eq!(n, curve.points().len());
    let shifted = |by: usize| {
        (0..n).fold(0.0, |most: f64, k| most.max((polygon.points()[k] - curve.points()[(k + by) % n]).norm()))
    };
    if polygon.is_closed() { (0..n).map(shifted).fold(f64::MAX, f64::min) } else { shifted(0) }
}

#[test]
fn refinement_is_knot_insertion() {
    let polygons = all();
    assert!(polygons.len() > 150);
    for polygon in polygons {
        let curve = polygon.to_curve().unwrap();
        let breaks = curve.space().breakpoints();
        let middles: Vec<f64> = breaks.windows(2).map(|p| 0.5 * (p[0] + p[1])).collect();
        let (fine, inserted) = (polygon.refine(), curve.insert_knots(&middles).unwrap());
        assert!(apart(&fine, &inserted) < 1e-14 * size(&polygon), "{polygon:?}");
        // The refined polygon is the same curve, at the same parameters.
        let (a, b) = curve.domain();
        let again = polygon.refine_times(3).to_curve().unwrap();
        for k in 0..=20 {
            let u = a + (b - a) * f64::from(k) / 20.0;
            assert!(
                (curve.point(u).unwrap() - again.point(shift(u, &again)).unwrap()).norm()
                    < 1e-13 * size(&polygon)
            );
        }
    }
}

/// A parameter of the same period.
fn shift(u: f64, curve: &Curve) -> f64 {
    let (a, b) = curve.domain();
    if curve.is_periodic() { a + (u - a).rem_euclid(b - a) } else { u.clamp(a, b) }
}

#[test]
fn curves_and_polygons_go_both_ways() {
    for polygon in all() {
        let curve = polygon.to_curve().unwrap();
        let back = Polygon::from_curve(&curve).unwrap();
        assert_eq!(back.points(), polygon.points());
        assert_eq!((back.scheme(), back.is_closed()), (polygon.scheme(), polygon.is_closed()));
        for (a, b) in back.spans().iter().zip(polygon.spans()) {
            assert!((a - b).abs() < 1e-14);
        }
        let again = back.to_curve().unwrap();
        for (a, b) in again.space().knots().iter().zip(curve.space().knots()) {
            assert!((a - b).abs() < 1e-14);
        }
    }
    let line = Curve::line(Point::origin(), Point::new(1., 0., 0.)).unwrap();
    assert!(Polygon::from_curve(&line).unwrap_err().to_string().contains("degree 1"));
    let circle = Curve::circle(Point::origin(), loftsman_kernel::Vector::z(), 1.0).unwrap();
    assert!(Polygon::from_curve(&circle).unwrap_err().to_string().contains("rational"));
}

#[test]
fn limit_points_lie_on_the_curve_at_its_knots() {
    for polygon in all() {
        let curve = polygon.to_curve().unwrap();
        let points = polygon.limit_points();
        // Knots, each as often as it is there.
        let mut at = 0.0;
        let mut knots = vec![0.0];
        for d in polygon.spans() {
            at += d;
            knots.push(at);
        }
        let first = if polygon.is_closed() && polygon.scheme() == Scheme::Chaikin { 1 } else { 0 };
        for (k, point) in points.iter().enumerate() {
            let on = curve.point(shift(knots[(k + first).min(knots.len() - 1)], &curve)).unwrap();
            assert!((on - point).norm() < 2e-14 * size(&polygon), "{k} {on} {point} {polygon:?}");
        }
        assert_eq!(points.len(), polygon.spans().len() + usize::from(!polygon.is_closed()));
    }
}

#[test]
fn what_is_wrong_is_named() {
    let points = |n: usize| (0..n).map(|k| Point::new(k as f64, 0., 0.)).collect::<Vec<_>>();
    let says = |polygon: Result<Polygon, loftsman_subdivision::SubdivisionError>, what: &str| {
        let message = polygon.unwrap_err().to_string();
        assert!(message.contains(what), "{message}");
    };
    says(Polygon::new(Scheme::Cubic, points(3), false), "at least 4");
    says(Polygon::new(Scheme::Chaikin, points(2), true), "at least 3");
    says(Polygon::new(Scheme::Chaikin, vec![Point::new(f64::NAN, 0., 0.); 3], true), "vertex 0");
    let five = Polygon::new(Scheme::Cubic, points(5), false).unwrap();
    says(five.clone().with_intervals(vec![1.0; 3]), "2 spans");
    says(five.clone().with_intervals(vec![1.0, -1.0]), "span 1 is -1");
    assert!(five.with_intervals(vec![0.0; 2]).unwrap().to_curve().is_err());
}

/// Chaikin's curve as a cubic one: the same at every parameter, by intervals `h, 0, h, 0, …`.
#[test]
fn chaikin_s_curve_elevated_is_the_same_curve() {
    let mut count = 0;
    for polygon in all() {
        if polygon.scheme() == Scheme::Cubic {
            assert!(polygon.elevated().unwrap_err().to_string().contains("cubic already"));
            continue;
        }
        let cubic = polygon.elevated().unwrap();
        assert_eq!(cubic.is_closed(), polygon.is_closed());
        let inner = polygon.spans().iter().filter(|d| **d > 0.0).count();
        assert!(cubic.spans().iter().filter(|d| **d > 0.0).count() == inner);
        if polygon.spans().contains(&0.0) {
            continue;
        }
        let (one, other) = (polygon.to_curve().unwrap(), cubic.to_curve().unwrap());
        let (a, b) = one.domain();
        for i in 0..=60 {
            let u = a + (b - a) * f64::from(i) / 60.0;
            let off = (one.point(u).unwrap() - other.point(u).unwrap()).norm();
            assert!(off <= 4e-15 * size(&polygon), "{u}: {off:e}");
        }
        count += 1;
    }
    assert!(count > 60, "{count}");
    // Uniform: (Q₋ + 5 Q)/6 and (5 Q + Q₊)/6.
    let points: Vec<Point> =
        (0..5).map(|k| Point::new(crate::shapes::noise(k), crate::shapes::noise(k + 9), k as f64)).collect();
    let cubic = Polygon::new(Scheme::Chaikin, points.clone(), true).unwrap().elevated().unwrap();
    for k in 0..5 {
        let [before, own, after] = [k + 4, k, k + 1].map(|k| points[k % 5].coords);
        assert!((cubic.points()[2 * k].coords - (before + own * 5.0) / 6.0).norm() < 1e-15);
        assert!((cubic.points()[2 * k + 1].coords - (own * 5.0 + after) / 6.0).norm() < 1e-15);
        assert_eq!(cubic.spans()[2 * k..2 * k + 2], [1.0, 0.0]);
    }
}
