//! Batches against the same parameters one by one.

use proptest::prelude::*;

use super::double::derivatives;
use super::*;
use crate::spline::testing::{any_curve, any_surface, line_of};
use crate::spline::{Curve, Space, Surface};
use crate::{Point, Vector};

fn many(a: f64, b: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| if i + 1 == count { b } else { a + (b - a) * i as f64 / (count - 1) as f64 }).collect()
}

/// Every parameter in a far corner of the batch: `i ↦ 7919 i mod n`, a permutation for `n` not a multiple of 7919.
fn shuffled(us: &[f64]) -> Vec<f64> {
    (0..us.len()).map(|i| us[i * 7919 % us.len()]).collect()
}

fn size(points: &[Point]) -> f64 {
    points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max)
}

/// How far rounding may move a derivative: weights from 0.2 to 5 and the degree `p` multiply by at most this.
fn scale(curve: &Curve, order: usize) -> f64 {
    let shortest = curve.space().breakpoints().windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    size(curve.points()) * (60.0 * curve.degree() as f64 / shortest).powi(order as i32)
}

/// Points and derivatives of a batch are those of single parameters.
fn assert_like_single(curve: &Curve, us: &[f64], orders: usize) {
    let mut points = vec![Point::origin(); us.len()];
    curve.points_into(us, &mut points).unwrap();
    let mut rows = vec![Vector::zeros(); us.len() * orders];
    curve.derivatives_many_into(us, orders, &mut rows).unwrap();
    for (i, &u) in us.iter().enumerate() {
        let (p, size) = (curve.degree(), size(curve.points()));
        let single = curve.point(u).unwrap();
        assert!((points[i] - single).norm() <= 2e-14 * size, "degree {p} at {u}: {} {single}", points[i]);
        for (order, row) in rows[orders * i..orders * (i + 1)].iter().enumerate() {
            let single = curve.derivative(u, order).unwrap();
            let wrong = (row - single).norm();
            assert!(wrong <= 1e-13 * scale(curve, order), "degree {p}, order {order} at {u}: {row} {single}");
        }
    }
}

/// A curve of a degree with spans that grow by a half each, and a double knot.
fn uneven(degree: usize, periodic: bool, rational: bool, unit: f64, metre: f64) -> Curve {
    let mut knots = vec![0.0];
    let mut gap = unit;
    for _ in 0..7 {
        knots.push(knots[knots.len() - 1] + gap);
        gap *= 1.5;
    }
    if degree > 1 {
        knots.insert(3, knots[3]);
    }
    let space = if periodic {
        Space::periodic(degree, knots).unwrap()
    } else {
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        knots.splice(0..0, vec![first; degree]);
        knots.extend(vec![last; degree]);
        Space::open(degree, knots).unwrap()
    };
    let at = |i: usize| i as f64;
    let points = (0..space.len())
        .map(|i| Point::from(Vector::new(at(i).sin(), (1.7 * at(i)).cos(), (0.4 * at(i)).sin()) * metre))
        .collect();
    let weights = rational.then(|| (0..space.len()).map(|i| 1.0 + 0.7 * (2.3 * at(i)).sin()).collect());
    Curve::build(space, points, weights).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_batch_on_a_curve_is_what_single_points_are(curve in any_curve(), order in 0..3_u8, count in 1..300_usize) {
        let (a, b) = curve.domain();
        let mut us = many(a, b, count.max(2));
        match order {
            0 => {}
            1 => us.reverse(),
            _ => us = shuffled(&us),
        }
        assert_like_single(&curve, &us, 3);
    }

    #[test]
    fn a_grid_is_what_single_points_are(surface in any_surface()) {
        let (us, vs) = (surface.u().domain(), surface.v().domain());
        let (us, vs) = (many(us.0, us.1, 7), many(vs.0, vs.1, 9));
        let mut points = vec![Point::origin(); 63];
        surface.grid_into(&us, &vs, &mut points).unwrap();
        let mut oriented = vec![OrientedPoint::ZERO; 63];
        surface.grid_oriented_into(&us, &vs, &mut oriented).unwrap();
        let mut samples = vec![Sample::ZERO; 63];
        surface.grid_frames_into(&us, &vs, &mut samples).unwrap();
        for (i, &u) in us.iter().enumerate() {
            for (j, &v) in vs.iter().enumerate() {
                let (sample, k) = (samples[i * 9 + j], i * 9 + j);
                prop_assert!((sample.point - surface.point(u, v).unwrap()).norm() < 1e-12);
                prop_assert!((points[k] - sample.point).norm() < 1e-12);
                prop_assert!((oriented[k].point - sample.point).norm() < 1e-12);
                prop_assert!((oriented[k].normal - sample.normal).norm() < 1e-6, "{:?} {sample:?}", oriented[k]);
                let (du, dv) = (surface.derivative(u, v, 1, 0).unwrap(), surface.derivative(u, v, 0, 1).unwrap());
                prop_assert!((sample.du - du).norm() <= 1e-11 * (1.0 + du.norm()));
                prop_assert!((sample.dv - dv).norm() <= 1e-11 * (1.0 + dv.norm()));
                prop_assert!(sample.normal.dot(&sample.du).abs() <= 1e-9 * (1.0 + du.norm()));
            }
        }
    }

    #[test]
    fn pairs_are_what_single_points_are(surface in any_surface()) {
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        let (us, vs) = (many(a, b, 97), shuffled(&many(c, d, 97)));
        let at: Vec<(f64, f64)> = us.into_iter().zip(vs).collect();
        let mut points = vec![Point::origin(); 97];
        surface.points_into(&at, &mut points).unwrap();
        let mut oriented = vec![OrientedPoint::ZERO; 97];
        surface.oriented_into(&at, &mut oriented).unwrap();
        let mut samples = vec![Sample::ZERO; 97];
        surface.frames_into(&at, &mut samples).unwrap();
        for (k, &(u, v)) in at.iter().enumerate() {
            prop_assert_eq!(points[k], surface.point(u, v).unwrap());
            let (du, dv) = (surface.derivative(u, v, 1, 0).unwrap(), surface.derivative(u, v, 0, 1).unwrap());
            let sample = samples[k];
            prop_assert!((sample.point - points[k]).norm() < 1e-12);
            prop_assert!((sample.du - du).norm() <= 1e-11 * (1.0 + du.norm()));
            prop_assert!((sample.dv - dv).norm() <= 1e-11 * (1.0 + dv.norm()));
            prop_assert!((oriented[k].normal - sample.normal).norm() < 1e-6);
        }
    }

    #[test]
    fn all_derivatives_of_a_surface_and_its_stencils_are_those_of_double_the_digits(surface in any_surface(), u in 0.0..=1.0_f64, v in 0.0..=1.0_f64) {
        use crate::shape::{Derivative, Location, Shape};
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        let (u, v) = (a + (b - a) * u, c + (d - c) * v);
        for (m, n) in [(0, 0), (1, 1), (2, 0), (0, 2), (2, 2), (1, 4), (5, 3)] {
            let mut all = vec![Vector::zeros(); (m + 1) * (n + 1)];
            surface.derivatives_into(u, v, [m, n], &mut all).unwrap();
            let exact = derivatives(&surface, [u, v], [m, n]);
            for k in 0..=m {
                for l in 0..=n {
                    let stencil = surface.stencil(Location::Surface(u, v), Derivative { u: k, v: l }).unwrap();
                    let (found, summed) = (all[k * (n + 1) + l], stencil.apply(surface.points()));
                    let (expected, size) = &exact[k * (n + 1) + l];
                    for (what, found) in [("derivative", found), ("stencil", summed)] {
                        prop_assert!(
                            (found - expected).amax() <= 1e-14 * size,
                            "{what} {k}, {l} at {u}, {v}: {found} {expected} {size:e}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn every_degree_periodic_or_not_rational_or_not() {
    for degree in 1..=25 {
        for (periodic, rational) in [(false, false), (false, true), (true, false), (true, true)] {
            let curve = uneven(degree, periodic, rational, 1.0, 1.0);
            let (a, b) = curve.domain();
            let us = many(a, b, 150);
            assert_like_single(&curve, &us, 3);
            assert_like_single(&curve, &shuffled(&us), 5);
        }
    }
}

#[test]
fn tiny_and_huge_shapes_over_tiny_and_huge_domains() {
    for unit in [1e-9, 1.0, 1e9] {
        for metre in [1e-9, 1.0, 1e9] {
            for degree in [1, 3, 5, 6, 12] {
                let curve = uneven(degree, degree % 2 == 0, true, unit, metre);
                let (a, b) = curve.domain();
                assert_like_single(&curve, &many(a, b, 100), 3);
            }
            let across = uneven(3, false, true, unit, metre);
            let weights = across.weights().unwrap();
            let (n, net) = (across.points().len(), across.points());
            let surface = Surface::rational(
                across.space().clone(),
                across.space().clone(),
                (0..n * n).map(|k| net[k / n] + net[k % n].coords.yzx() * 0.5).collect(),
                (0..n * n).map(|k| weights[k / n] * weights[k % n]).collect(),
            )
            .unwrap();
            let (a, b) = across.domain();
            let us = many(a, b, 17);
            let mut oriented = vec![OrientedPoint::ZERO; 17 * 17];
            surface.grid_oriented_into(&us, &us, &mut oriented).unwrap();
            for (k, found) in oriented.iter().enumerate() {
                let (u, v) = (us[k / 17], us[k % 17]);
                assert!((found.point - surface.point(u, v).unwrap()).norm() <= 1e-14 * metre);
                let normal = surface.normal(u, v).unwrap().vector().unwrap();
                assert!((found.normal - normal).norm() <= 1e-9, "{found:?} {normal}");
            }
        }
    }
}

#[test]
fn parameters_beyond_a_period_are_wrapped_in_a_batch_too() {
    for degree in [1, 3, 7] {
        let curve = uneven(degree, true, true, 1.0, 1.0);
        let (a, b) = curve.domain();
        assert_like_single(&curve, &many(a - 2.5 * (b - a), b + 2.5 * (b - a), 400), 3);
    }
}

#[test]
fn work_in_many_blocks_is_work_in_one() {
    let curve = uneven(3, false, false, 1.0, 1.0);
    let (a, b) = curve.domain();
    let us = many(a, b, 3 * BLOCK + 17);
    let mut points = vec![Point::origin(); us.len()];
    curve.points_into(&us, &mut points).unwrap();
    for (us, found) in us.chunks(BLOCK).zip(points.chunks(BLOCK)) {
        let mut points = vec![Point::origin(); us.len()];
        curve.points_into(us, &mut points).unwrap();
        assert_eq!(points, found);
    }
    for i in (0..us.len()).step_by(101) {
        assert!((points[i] - curve.point(us[i]).unwrap()).norm() < 1e-14);
    }
}

#[test]
fn a_normal_where_there_is_none_is_zero() {
    let space = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let corner = |x: f64, y: f64| Point::new(x, y, 0.0);
    let net = vec![corner(0.0, 0.0), corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)];
    let triangle = Surface::new(space.clone(), space, net).unwrap();
    let mut found = [OrientedPoint::ZERO; 4];
    triangle.grid_oriented_into(&[0.0, 1.0], &[0.0, 1.0], &mut found).unwrap();
    assert_eq!(found.map(|o| o.normal.z), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn wrong_lengths_and_parameters_are_errors() {
    let curve = line_of(3, 8);
    let mut out = vec![Point::origin(); 2];
    assert!(curve.points_into(&[0.0], &mut out).is_err());
    assert!(curve.points_into(&[0.0, f64::NAN], &mut out).is_err());
    assert!(curve.points_into(&[0.0, 1e9], &mut out).is_err());
    assert!(curve.derivatives_many_into(&[0.0], 0, &mut []).is_err());
    assert!(curve.derivatives_many_into(&[0.0], 1000, &mut []).is_err());
    curve.points_into(&[], &mut []).unwrap();
    let surface = Surface::extrusion(&curve, Vector::z()).unwrap();
    assert!(surface.grid_into(&[0.0, 1.0], &[0.5], &mut out[..1]).is_err());
    assert!(surface.grid_into(&[0.0, f64::INFINITY], &[0.5], &mut out).is_err());
    assert!(surface.grid_into(&[0.0], &[0.5, -3.0], &mut out).is_err());
    assert!(surface.points_into(&[(0.0, 0.5), (0.0, f64::NAN)], &mut out).is_err());
    assert!(surface.points_into(&[(0.0, 0.5)], &mut out).is_err());
    surface.grid_into(&[], &[0.5], &mut []).unwrap();
    surface.grid_into(&[0.5], &[], &mut []).unwrap();
    assert!(surface.derivatives_into(0.5, 0.5, [1, 1], &mut [Vector::zeros(); 3]).is_err());
    assert!(surface.derivatives_into(0.5, 0.5, [26, 0], &mut [Vector::zeros(); 27]).is_err());
    assert!(surface.derivative(0.5, 0.5, 0, usize::MAX).is_err());
}
