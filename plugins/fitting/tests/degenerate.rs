//! Points that are too few, equal, in line, repeated, not numbers; spaces they do not fill; constraints that fight.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fitting::{
    Duplicates, Ends, Fit, FitError, Interpolation, LeastSquares, Parametrization, Target,
};
use loftsman_kernel::edit::{Ask, Axis};
use loftsman_kernel::functional::{curvature, derivative, linear, orthogonal, position, tangent};
use loftsman_kernel::spline::Space;
use loftsman_kernel::{Point, Vector};

fn wave(m: usize) -> Vec<Point> {
    (0..m).map(|i| 0.1 * i as f64).map(|x| Point::new(x, x.sin(), 0.3 * x)).collect()
}

fn interpolate(degree: usize, closed: bool, points: &[Point]) -> Result<(), FitError> {
    Interpolation { closed, ..Interpolation::new(degree) }.curve(points).map(|_| ())
}

#[test]
fn no_point_one_point_equal_points() {
    let p = Point::new(1.0, 2.0, 3.0);
    for closed in [false, true] {
        assert!(matches!(interpolate(3, closed, &[]), Err(FitError::TooFewPoints { found: 0, .. })));
        assert!(matches!(interpolate(3, closed, &[p]), Err(FitError::AllEqual { count: 1 })));
        assert!(matches!(interpolate(3, closed, &[p; 9]), Err(FitError::AllEqual { count: 9 })));
        let fit = Fit { closed, ..Fit::new(3, Target::Tolerance(0.1)) };
        assert!(matches!(fit.curve(&[]), Err(FitError::TooFewPoints { .. })));
        assert!(matches!(fit.curve(&[p; 5]), Err(FitError::AllEqual { count: 5 })));
    }
}

#[test]
fn too_few_for_the_degree() {
    for degree in [1, 2, 3, 8, 25] {
        for m in 2..=degree {
            let Err(FitError::TooFewPoints { found, needed, possible, .. }) =
                interpolate(degree, false, &wave(m))
            else {
                panic!("degree {degree}, {m} points")
            };
            assert_eq!((found, needed, possible), (m, degree + 1, m - 1));
        }
        interpolate(degree, false, &wave(degree + 1)).unwrap();
    }
    assert!(matches!(interpolate(3, true, &wave(2)), Err(FitError::TooFewPoints { needed: 3, .. })));
    interpolate(3, true, &wave(3)).unwrap();
    assert!(interpolate(0, false, &wave(5)).is_err());
    assert!(interpolate(1_000_000_000, false, &wave(5)).is_err());
    assert!(interpolate(1_000_000_000, true, &wave(5)).is_err());
    assert!(Fit::new(1_000_000_000, Target::Tolerance(1.0)).curve(&wave(5)).is_err());
    assert!(matches!(
        Fit::new(5, Target::Tolerance(1.0)).curve(&wave(4)),
        Err(FitError::TooFewPoints { possible: 3, .. })
    ));
}

#[test]
fn not_numbers() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut points = wave(10);
        points[7].y = bad;
        assert!(matches!(interpolate(3, false, &points), Err(FitError::PointNotFinite { index: 7, .. })));
        let fit = Fit::new(3, Target::Tolerance(1.0)).curve(&points);
        assert!(matches!(fit, Err(FitError::PointNotFinite { index: 7, .. })));
        assert!(Fit::new(3, Target::Tolerance(bad)).curve(&wave(10)).is_err());
        assert!(Fit::new(3, Target::Relative(bad)).curve(&wave(10)).is_err());
        let fit = Fit { weights: Some(vec![bad; 10]), ..Fit::new(3, Target::Tolerance(1.0)) };
        assert!(matches!(fit.curve(&wave(10)), Err(FitError::Weight { index: 0, .. })));
        let fit = Fit { regularization: bad, ..Fit::new(3, Target::Tolerance(1.0)) };
        assert!(fit.curve(&wave(10)).is_err());
    }
    assert!(Fit::new(3, Target::Tolerance(0.0)).curve(&wave(10)).is_err());
    assert!(Fit::new(3, Target::Vertices(3)).curve(&wave(10)).is_err());
    assert!(Fit::new(3, Target::Vertices(11)).curve(&wave(10)).is_err());
}

#[test]
fn repeated_points_are_named_or_merged() {
    let mut points = wave(12);
    points.insert(4, points[3]);
    points.insert(9, points[8]);
    points.insert(9, points[8]);
    let refused = interpolate(3, false, &points);
    let Err(FitError::Coincident { indices, count: 3 }) = refused else { panic!("{refused:?}") };
    assert_eq!(indices, [4, 9, 10]);
    let merge = Interpolation { duplicates: Duplicates::Merge, ..Interpolation::new(3) };
    let merged = merge.curve(&points).unwrap();
    assert_eq!(merged.merged, [4, 9, 10]);
    assert_eq!(merged.parameters.len(), 12);
    let plain = Interpolation::new(3).curve(&wave(12)).unwrap();
    for (a, b) in merged.curve.points().iter().zip(plain.curve.points()) {
        assert!((a - b).norm() < 1e-13);
    }
    // At the ends, and around a closed curve, too.
    for place in [0, 12] {
        let mut points = wave(12);
        points.insert(place.min(11), wave(12)[place.min(11)]);
        let merged = merge.curve(&points).unwrap();
        assert_eq!(merged.curve.points().len(), 12);
        assert!((merged.curve.points()[11] - wave(12)[11]).norm() < 1e-15);
    }
    // Least squares takes them as they are.
    Fit::new(3, Target::Tolerance(1e-3)).curve(&points).unwrap();
}

#[test]
fn closed_with_the_first_point_repeated() {
    let mut ring: Vec<Point> = (0..20)
        .map(|i| std::f64::consts::TAU * f64::from(i) / 20.0)
        .map(|a| Point::new(a.cos(), a.sin(), 0.0))
        .collect();
    let plain = Interpolation { closed: true, ..Interpolation::new(3) };
    let without = plain.curve(&ring).unwrap();
    ring.push(ring[0]);
    assert!(matches!(plain.curve(&ring), Err(FitError::Coincident { count: 1, .. })));
    let with = Interpolation { duplicates: Duplicates::Merge, ..plain }.curve(&ring).unwrap();
    assert_eq!(with.merged, [20]);
    assert_eq!(with.curve.points().len(), 20);
    for (a, b) in with.curve.points().iter().zip(without.curve.points()) {
        assert!((a - b).norm() < 1e-13);
    }
    let fit = Fit { closed: true, ..Fit::new(3, Target::Tolerance(1e-3)) }.curve(&ring).unwrap();
    assert!(fit.closing_point_dropped && fit.curve.is_periodic() && fit.max_error <= 1e-3);
}

#[test]
fn points_in_line_give_a_line() {
    let line: Vec<Point> = [0.0, 0.1, 0.15, 0.7, 0.71, 1.0, 2.5].map(|t| Point::new(t, 2.0 * t, -t)).to_vec();
    let through = Interpolation::new(3).curve(&line).unwrap();
    let fitted = Fit::new(3, Target::Relative(1e-9)).curve(&line).unwrap();
    assert_eq!(fitted.curve.points().len(), 4);
    for curve in [&through.curve, &fitted.curve] {
        for i in 0..=50 {
            let p = curve.point(f64::from(i) / 50.0).unwrap();
            assert!((p.y - 2.0 * p.x).abs() < 1e-14 && (p.z + p.x).abs() < 1e-14);
            // By chord length it is run through evenly.
            assert!((p.x - 2.5 * f64::from(i) / 50.0).abs() < 1e-13);
        }
    }
    // There and back again: the end point equals the start.
    let back: Vec<Point> = line.iter().chain(line.iter().rev().skip(1)).copied().collect();
    Fit::new(3, Target::Relative(1e-3)).curve(&back).unwrap();
}

#[test]
fn even_degrees_close_where_knots_at_the_points_would_be_singular() {
    for m in [4, 5, 8, 11, 40] {
        let ring: Vec<Point> = (0..m)
            .map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(m))
            .map(|a| Point::new(a.cos(), a.sin(), 0.0))
            .collect();
        for degree in [2, 4, 6] {
            let through = Interpolation { closed: true, ..Interpolation::new(degree) }.curve(&ring).unwrap();
            assert!(through.residual < 1e-13 && through.condition < 1e6, "{m} points, degree {degree}");
        }
    }
}

#[test]
fn a_span_without_points_is_named_or_regularized() {
    let space = Space::clamped(3, &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0]).unwrap();
    let sites: Vec<f64> = (0..40).map(|i| 0.5 + f64::from(i) / 78.0).chain([0.0, 0.02, 0.04]).collect();
    let points: Vec<Point> = sites.iter().map(|&u| Point::new(u, u * u, 0.0)).collect();
    let mut fit = LeastSquares::new(space);
    let Err(FitError::NoData { start, end, knot, .. }) = fit.curve(&sites, &points) else { panic!() };
    assert!(start < knot && knot < end && knot < 0.5);
    fit.regularization = 1e-6;
    let fitted = fit.curve(&sites, &points).unwrap();
    assert!(fitted.max_error < 1e-3);
    assert!((fitted.curve.point(0.3).unwrap() - Point::new(0.3, 0.09, 0.0)).norm() < 0.05);
    // A closed one likewise: found by rank.
    let ring = Space::periodic_uniform(3, 12).unwrap();
    let sites: Vec<f64> = (0..30).map(|i| f64::from(i) / 6.0).collect();
    let points = wave(30);
    let closed = LeastSquares::new(ring).curve(&sites, &points);
    assert!(matches!(closed, Err(FitError::IllConditioned { .. })), "{closed:?}");
}

#[test]
fn constraints_hold_exactly() {
    let points: Vec<Point> = (0..60)
        .map(|i| f64::from(i) / 59.0)
        .map(|t| Point::new(4.0 * t, (5.0 * t).sin(), 0.2 * (9.0 * t).cos()))
        .collect();
    for (closed, offset) in [(false, 0.0), (true, 0.0), (false, 1e6)] {
        let shift = Vector::new(offset, -offset, 0.0);
        let moved: Vec<Point> = points.iter().map(|p| p + shift).collect();
        let mut fit = Fit { closed, ..Fit::new(3, Target::Vertices(14)) };
        let place = Point::new(2.1, 0.4, 0.0) + shift;
        let slope = Vector::new(3.0, 1.0, -2.0);
        fit.constraints = vec![
            position(0.5).to(<[f64; 3]>::from(place.coords)),
            derivative(0.5, 1).to(<[f64; 3]>::from(slope)),
            tangent(0.25).direction([1.0, 1.0, 0.5]).hold(),
            orthogonal(0.8, [0.0, 0.0, 1.0]).hold(),
            linear([(3, Vector::x()), (-2, Vector::y())]).to(0.7),
        ];
        let fitted = fit.curve(&moved).unwrap();
        let tiny = 1e-11 * (1.0 + offset);
        let curve = &fitted.curve;
        assert!((curve.point(0.5).unwrap() - place).norm() < tiny);
        assert!((curve.derivative(0.5, 1).unwrap() - slope).norm() < 10.0 * tiny);
        let along = curve.derivative(0.25, 1).unwrap();
        assert!(along.cross(&Vector::new(1.0, 1.0, 0.5)).norm() < 100.0 * tiny);
        assert!(curve.derivative(0.8, 1).unwrap().z.abs() < 10.0 * tiny);
        let n = curve.points().len();
        assert!((curve.points()[3].x + curve.points()[n - 2].y - 0.7).abs() < tiny);
        assert!(fitted.kept.residuals.iter().all(|(_, r)| *r < 10.0 * tiny));
        assert!(fitted.kept.residuals.len() == if closed { 5 } else { 7 });
    }
}

#[test]
fn constrained_least_squares_is_least() {
    // The answer is a minimum: moves that keep the constraints only make it worse.
    let points = wave(40);
    let sites: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
    let mut fit = LeastSquares::new(Space::clamped(3, &[0.0, 0.25, 0.5, 0.75, 1.0]).unwrap());
    fit.constraints = vec![position(0.4).to([2.0, 0.0, 1.0])];
    let fitted = fit.curve(&sites, &points).unwrap();
    let sum = |curve: &loftsman_kernel::spline::Curve| -> f64 {
        sites.iter().zip(&points).map(|(&u, q)| (curve.point(u).unwrap() - q).norm_squared()).sum()
    };
    let least = sum(&fitted.curve);
    let stencil = loftsman_kernel::shape::Shape::stencil(&fitted.curve, 0.4.into(), 0.into()).unwrap();
    let norm: f64 = stencil.coefficients().iter().map(|c| c * c).sum();
    for seed in 0..20_usize {
        let mut change: Vec<Vector> = (0..7)
            .map(|i| {
                Vector::new(1.0, (i * seed) as f64, -2.0)
                    .map(|v| (v * (1 + i + 7 * seed) as f64).sin() * 1e-3)
            })
            .collect();
        let total = stencil.iter().fold(Vector::zeros(), |s, (v, c)| s + change[v] * c);
        for (v, c) in stencil.iter() {
            change[v] -= total * (c / norm);
        }
        let moved = fitted.curve.points().iter().zip(&change).map(|(p, d)| p + d).collect();
        let other = loftsman_kernel::spline::Curve::new(fitted.curve.space().clone(), moved).unwrap();
        assert!((other.point(0.4).unwrap() - Point::new(2.0, 0.0, 1.0)).norm() < 1e-13);
        assert!(sum(&other) > least);
    }
}

#[test]
fn constraints_may_determine_what_the_points_do_not() {
    // No points in the middle third; a position there.
    let sites: Vec<f64> =
        (0..10).map(|i| f64::from(i) / 30.0).chain((0..10).map(|i| 0.7 + f64::from(i) / 30.0)).collect();
    let points: Vec<Point> = sites.iter().map(|&u| Point::new(u, u * (1.0 - u), 0.0)).collect();
    let mut fit = LeastSquares::new(Space::clamped(1, &[0.0, 0.3, 0.4, 0.5, 0.7, 1.0]).unwrap());
    assert!(matches!(fit.curve(&sites, &points), Err(FitError::NoData { .. })));
    fit.constraints = vec![position(0.4).to([0.5, 0.25, 0.0]), position(0.45).to([0.5, 0.75, 0.0])];
    let fitted = fit.curve(&sites, &points).unwrap();
    assert!((fitted.curve.point(0.5).unwrap() - Point::new(0.5, 1.25, 0.0)).norm() < 1e-14);
}

#[test]
fn redundant_is_reported_and_conflict_is_named() {
    let points = wave(40);
    let mut fit = Fit::new(3, Target::Vertices(10));
    let here = [1.5, 1.0, 0.4];
    fit.constraints = vec![position(0.4).to(here), derivative(0.4, 0).to(here)];
    let fitted = fit.curve(&points).unwrap();
    assert_eq!(
        fitted.kept.redundant,
        ["derivative 0 at 0.4".to_owned()].map(|_| fit.constraints[1].describe())
    );
    fit.constraints[1] = derivative(0.4, 0).to([1.5, 1.2, 0.4]);
    let Err(FitError::Conflict { name, with }) = fit.curve(&points) else { panic!() };
    assert_eq!(name, fit.constraints[1].describe());
    assert_eq!(with, ["position at 0.4"]);
}

#[test]
fn one_axis_of_a_place_is_held_and_the_others_are_free() {
    let points = wave(60);
    let sites: Vec<f64> = (0..60).map(|k| f64::from(k) / 59.0).collect();
    let mut fit = LeastSquares::new(Space::clamped(3, &[0.0, 0.2, 0.45, 0.7, 1.0]).unwrap());
    let free = fit.curve(&sites, &points).unwrap().curve;
    let before = free.point(0.3).unwrap();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let k = axis as usize;
        fit.constraints = vec![position(0.3).axis(axis).to(before[k] + 0.5)];
        let held = fit.curve(&sites, &points).unwrap();
        // The other axes are the least-squares curve's.
        for (now, was) in held.curve.points().iter().zip(free.points()) {
            let way = now - was;
            assert!((0..3).all(|other| other == k || way[other].abs() < 1e-12), "{way}");
        }
        assert!((held.curve.point(0.3).unwrap()[k] - before[k] - 0.5).abs() < 1e-13);
        assert!(held.kept.residuals[0].0.ends_with("of position at 0.3"), "{:?}", held.kept.residuals);
    }
    let Err(FitError::Constraint { reason, .. }) = ({
        let mut fit = Fit::new(3, Target::Vertices(12));
        fit.constraints = vec![curvature(0.3).to([0.1, 0.0])];
        fit.curve(&points)
    }) else {
        panic!()
    };
    assert!(reason.contains("no curve yet to keep them of"), "{reason}");
}

#[test]
fn constraints_that_cannot_be_are_refused() {
    let points = wave(40);
    let mut fit = Fit::new(3, Target::Vertices(10));
    for bad in [
        position(0.4).keep(),
        position(0.4).to(1.0),
        position(0.4).to([1.0, f64::NAN, 2.0]),
        loftsman_kernel::functional::magnitude(0.4).to(1.0),
        derivative(0.4, 7).to([0.0; 3]),
        position(0.4).by([0.0; 3]),
        position(0.4).axis(Axis::X).at_least(0.5),
        curvature(0.4).to([0.1, 0.0]),
        tangent(0.4).axis(Axis::Z).keep(),
    ] {
        fit.constraints = vec![bad];
        let error = fit.curve(&points).unwrap_err();
        assert!(matches!(error, FitError::Constraint { .. }), "{error}");
    }
    fit.constraints = vec![position(1.4).to([0.0; 3])];
    assert!(matches!(fit.curve(&points), Err(FitError::Geometry(_))));
}

#[test]
fn a_tolerance_out_of_reach_is_an_error_or_a_best_effort() {
    let points = wave(60);
    let mut fit = Fit::new(3, Target::AtMost { tolerance: 1e-9, vertices: 8 });
    let Err(FitError::NotMet { error, vertices: 8, .. }) = fit.curve(&points) else { panic!() };
    assert!(error > 1e-9);
    fit.best_effort = true;
    let best = fit.curve(&points).unwrap();
    assert!(!best.met && best.max_error > 1e-9 && best.curve.points().len() <= 8);
    // Without a limit everything is met: at last by interpolation.
    let rough: Vec<Point> =
        (0..30).map(|i| Point::new(f64::from(i), f64::from((i * 37) % 11), 0.0)).collect();
    let through = Fit::new(3, Target::Tolerance(1e-9)).curve(&rough).unwrap();
    assert!(through.met && through.max_error <= 1e-9);
}

#[test]
fn a_tolerance_that_nothing_meets_ends() {
    // Two places at one parameter: no curve passes both.
    let mut points = wave(3000);
    points[1500].y += 1.0;
    let mut parameters: Vec<f64> = (0..3000).map(f64::from).collect();
    parameters[1500] = parameters[1499];
    let parameters = Parametrization::Given(parameters);
    let fit = Fit { parameters, corrections: 0, ..Fit::new(3, Target::Tolerance(1e-3)) };
    assert!(matches!(fit.curve(&points), Err(FitError::NotMet { .. })));
    // As many vertices as points, but not as many places.
    let doubled: Vec<Point> = wave(20).into_iter().flat_map(|p| [p, p]).collect();
    let refused = Fit::new(3, Target::Vertices(38)).curve(&doubled);
    assert!(matches!(
        refused,
        Err(FitError::NoData { .. } | FitError::IllConditioned { .. } | FitError::Request(_))
    ));
    assert!(Fit::new(3, Target::Vertices(15)).curve(&doubled).is_ok());
}

#[test]
fn end_conditions_that_cannot_be() {
    let natural = Interpolation { ends: Ends::Natural, ..Interpolation::new(4) };
    assert!(matches!(natural.curve(&wave(9)), Err(FitError::Request(_))));
    let closed = Interpolation { closed: true, ends: Ends::NotAKnot, ..Interpolation::new(3) };
    assert!(matches!(closed.curve(&wave(9)), Err(FitError::Request(_))));
    let ends = Ends::Derivatives { start: vec![Vector::x(); 3], end: vec![] };
    let many = Interpolation { ends, ..Interpolation::new(3) };
    assert!(matches!(many.curve(&wave(9)), Err(FitError::Request(_))));
    let parameters = Parametrization::Given(vec![0.0, 1.0]);
    let few = Interpolation { parameters, ..Interpolation::new(3) };
    assert!(matches!(few.curve(&wave(9)), Err(FitError::ParameterCount { .. })));
}

#[test]
fn tangents_at_the_ends_are_those_given() {
    let (a, b) = (Vector::new(3.0, -1.0, 0.5), Vector::new(1.0, 4.0, 2.0));
    for degree in 2..=6 {
        for (start, end) in [(vec![a], vec![b]), (vec![a], vec![]), (vec![], vec![b])] {
            let ends = Ends::Derivatives { start: start.clone(), end: end.clone() };
            let through = Interpolation { ends, ..Interpolation::new(degree) }.curve(&wave(12)).unwrap();
            assert!(through.residual < 1e-13);
            for (u, given) in [(0.0, start), (1.0, end)] {
                for given in given {
                    let found = through.curve.derivative(u, 1).unwrap();
                    assert!((found - given).norm() < 1e-11, "degree {degree}: {found}");
                }
            }
        }
    }
}

#[test]
fn a_hundred_thousand_points_are_no_more_than_a_hundred_thousand() {
    let many = |m: usize| -> Vec<Point> {
        (0..m).map(|i| 200.0 * i as f64 / m as f64).map(|x| Point::new(x.cos() * x, x.sin() * x, x)).collect()
    };
    let points = many(100_000);
    for closed in [false, true] {
        let through = Interpolation { closed, ..Interpolation::new(3) }.curve(&points).unwrap();
        // The step that closes the spiral is a thousand times the others, which costs condition but no accuracy.
        assert!(through.residual < 1e-11 && through.condition < if closed { 1e6 } else { 10.0 });
    }
    let fitted = Fit::new(3, Target::Relative(1e-4)).curve(&many(5000)).unwrap();
    assert!(fitted.met && fitted.curve.points().len() < 2000);
}
