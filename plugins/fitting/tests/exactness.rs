//! What fits must do to rounding: reproduce, stay orthogonal, commute with affine maps, whatever the size.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fitting::{Ends, Fit, Interpolation, LeastSquares, Parametrization, Target};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use proptest::prelude::*;

/// A sequence without a library: the fractional parts of a multiple of the golden ratio.
fn scatter(i: usize, k: f64) -> f64 {
    ((i as f64 + 1.0) * 0.618_033_988_749_894_9 * k).fract() - 0.5
}

fn wavy(m: usize) -> Vec<Point> {
    (0..m)
        .map(|i| {
            let x = i as f64 / m as f64 * 9.0 + 0.03 * scatter(i, 1.0);
            Point::new(x, (1.3 * x).sin(), 0.4 * (0.7 * x).cos())
        })
        .collect()
}

fn ring(m: usize) -> Vec<Point> {
    (0..m)
        .map(|i| {
            let a = std::f64::consts::TAU * (i as f64 + 0.3 * scatter(i, 1.0)) / m as f64;
            Point::new(2.0 * a.cos() + 0.3 * (3.0 * a).cos(), a.sin(), 0.2 * (2.0 * a).sin())
        })
        .collect()
}

fn largest(curve: &Curve, other: &Curve) -> f64 {
    let (a, b) = curve.domain();
    (0..=200)
        .map(|i| a + (b - a) * f64::from(i) / 200.0)
        .map(|u| (curve.point(u).unwrap() - other.point(u).unwrap()).norm())
        .fold(0.0, f64::max)
}

#[test]
fn polynomials_are_reproduced_by_every_degree_and_end() {
    for degree in 1..=12_usize {
        let sites: Vec<f64> = (0..degree + 6).map(|i| i as f64 / (degree + 5) as f64).collect();
        let q =
            |u: f64| Point::new(u, (1.0 - 2.0 * u).powi(degree as i32), 1.0 - u * u.powi(degree as i32 - 1));
        let points: Vec<Point> = sites.iter().map(|&u| q(u)).collect();
        for ends in [Ends::Averaged, Ends::NotAKnot] {
            let through = Interpolation {
                parameters: Parametrization::Given(sites.clone()),
                ends: ends.clone(),
                ..Interpolation::new(degree)
            }
            .curve(&points)
            .unwrap();
            for i in 0..=40 {
                let u = f64::from(i) / 40.0;
                let error = (through.curve.point(u).unwrap() - q(u)).norm();
                assert!(
                    error < 4e-15 * through.condition.max(10.0),
                    "degree {degree} {ends:?} at {u}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn splines_of_the_space_come_back_open_and_closed() {
    for degree in 1..=7_usize {
        for closed in [false, true] {
            let breaks: Vec<f64> = (0..=11).map(|i| f64::from(i) + 0.3 * scatter(i as usize, 1.0)).collect();
            let space = if closed {
                Space::periodic(degree, breaks).unwrap()
            } else {
                Space::clamped(degree, &breaks).unwrap()
            };
            let vertices: Vec<Point> = (0..space.len())
                .map(|i| Point::new(scatter(i, 1.0), scatter(i, 2.0), scatter(i, 3.0)))
                .collect();
            let curve = Curve::new(space.clone(), vertices).unwrap();
            let (a, b) = space.domain();
            // Against the order of the parameters, too: any will do.
            let sites: Vec<f64> = (0..67).map(|i| a + (b - a) * f64::from((i * 29) % 67) / 66.5).collect();
            let points: Vec<Point> = sites.iter().map(|&u| curve.point(u).unwrap()).collect();
            let fitted = LeastSquares::new(space).curve(&sites, &points).unwrap();
            assert!(fitted.max_error < 1e-14, "degree {degree} closed {closed}: {:e}", fitted.max_error);
            assert!(largest(&fitted.curve, &curve) < 1e-14 * fitted.condition.max(10.0));
        }
    }
}

#[test]
fn residuals_are_orthogonal_to_the_space() {
    for closed in [false, true] {
        let points = if closed { ring(80) } else { wavy(80) };
        let sites: Vec<f64> = (0..80).map(|i| f64::from(i) / 79.9).collect();
        let breaks: Vec<f64> = (0..=9).map(|i| f64::from(i) / 9.0).collect();
        let space =
            if closed { Space::periodic(3, breaks).unwrap() } else { Space::clamped(3, &breaks).unwrap() };
        let mut fit = LeastSquares::new(space.clone());
        let weights: Vec<f64> = (0..80).map(|i| 1.0 + 0.8 * scatter(i, 5.0)).collect();
        fit.weights = Some(weights.clone());
        let fitted = fit.curve(&sites, &points).unwrap();
        assert!(fitted.max_error > 1e-4, "the points must not be in the space");
        let mut products = vec![Vector::zeros(); space.len()];
        for ((u, q), w) in sites.iter().zip(&points).zip(&weights) {
            let stencil =
                loftsman_kernel::shape::Shape::stencil(&fitted.curve, (*u).into(), 0.into()).unwrap();
            let off = fitted.curve.point(*u).unwrap() - q;
            for (vertex, coefficient) in stencil.iter() {
                products[vertex] += off * (coefficient * w);
            }
        }
        for product in products {
            assert!(product.norm() < 1e-13);
        }
    }
}

#[test]
fn interpolation_of_every_size_is_the_same_curve() {
    for exponent in [-300, -100, -9, -3, 3, 9, 100, 300] {
        let size = 10.0_f64.powi(exponent);
        for closed in [false, true] {
            let plain = if closed { ring(25) } else { wavy(25) };
            let scaled: Vec<Point> = plain.iter().map(|p| p * size).collect();
            let make =
                |points: &[Point]| Interpolation { closed, ..Interpolation::new(3) }.curve(points).unwrap();
            let (one, other) = (make(&plain), make(&scaled));
            for (a, b) in one.curve.points().iter().zip(other.curve.points()) {
                assert!((a - b / size).norm() < 1e-12, "1e{exponent}");
            }
            assert!(other.residual <= 1e-14 * size * 10.0);
        }
    }
}

#[test]
fn fits_of_every_size_and_far_away_are_the_same_curve() {
    let plain = wavy(150);
    let fit =
        |points: &[Point], tolerance: f64| Fit::new(3, Target::Tolerance(tolerance)).curve(points).unwrap();
    let one = fit(&plain, 1e-3);
    for exponent in [-9, 9] {
        let size = 2.0_f64.powi(exponent * 3);
        let scaled: Vec<Point> = plain.iter().map(|p| p * size).collect();
        let other = fit(&scaled, 1e-3 * size);
        assert_eq!(other.curve.points().len(), one.curve.points().len());
        for (a, b) in one.curve.points().iter().zip(other.curve.points()) {
            assert!((a - b / size).norm() < 1e-12);
        }
    }
    let far = Vector::new(1e9, -3e8, 5e8);
    let moved: Vec<Point> = plain.iter().map(|p| p + far).collect();
    let other = fit(&moved, 1e-3);
    assert!(other.max_error <= 1e-3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn interpolation_commutes_with_affine_maps(
        degree in 1_usize..6,
        closed in any::<bool>(),
        map in proptest::array::uniform9(-2.0_f64..2.0),
    ) {
        let points = if closed { ring(21) } else { wavy(21) };
        let sites: Vec<f64> = (0..21 + usize::from(closed)).map(|i| i as f64 + 0.2 * scatter(i, 4.0)).collect();
        let affine = |p: &Point| Point::new(
            map[0] * p.x + map[1] * p.y + map[2] * p.z + 1.0,
            map[3] * p.x + map[4] * p.y + map[5] * p.z - 2.0,
            map[6] * p.x + map[7] * p.y + map[8] * p.z,
        );
        let mapped: Vec<Point> = points.iter().map(affine).collect();
        let make = |points: &[Point]| Interpolation {
            closed,
            parameters: Parametrization::Given(sites.clone()),
            ..Interpolation::new(degree)
        }.curve(points);
        let (one, other) = (make(&points).unwrap(), make(&mapped).unwrap());
        for (a, b) in one.curve.points().iter().zip(other.curve.points()) {
            prop_assert!((affine(a) - b).norm() < 1e-13 * one.condition.max(10.0));
        }
    }

    #[test]
    fn closed_interpolation_closes_smoothly(degree in 1_usize..8, m in 7_usize..30) {
        let points = ring(m);
        let through = Interpolation { closed: true, ..Interpolation::new(degree) }.curve(&points).unwrap();
        prop_assert!(through.residual < 1e-12);
        prop_assert_eq!(through.curve.points().len(), m);
        prop_assert!(through.curve.is_periodic());
    }
}
