//! What holds for every spline space and every curve: partition of unity, derivatives that are slopes, independence
//! of the knots' scale and origin, and of a map of the vertices.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, reason = "tests")]

use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use proptest::prelude::*;

/// Spaces of degree 1 to 6, open (clamped or not) and periodic, with knots up to `p` times.
fn any_space() -> impl Strategy<Value = Space> {
    (1..=6_usize, any::<bool>(), any::<bool>()).prop_flat_map(|(degree, periodic, clamped)| {
        let gaps = prop::collection::vec((0.1..2.0_f64, 1..=degree), 2 * degree + 2..2 * degree + 8);
        gaps.prop_map(move |gaps| {
            let mut t = 0.0;
            let mut knots = Vec::new();
            for (i, &(gap, times)) in gaps.iter().enumerate() {
                t += gap;
                // Every third knot is a multiple one; those at the ends are simple.
                let times = if i % 3 == 2 && i + 1 < gaps.len() { times } else { 1 };
                knots.extend(std::iter::repeat_n(t, times));
            }
            if periodic {
                return Space::periodic(degree, knots).unwrap();
            }
            if clamped {
                knots.splice(0..0, vec![knots[0]; degree]);
                knots.extend(vec![t; degree]);
            }
            Space::open(degree, knots).unwrap()
        })
    })
}

fn any_points(count: usize) -> impl Strategy<Value = Vec<Point>> {
    let coordinate = || -10.0..10.0_f64;
    let point = (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| Point::new(x, y, z));
    prop::collection::vec(point, count)
}

fn any_curve() -> impl Strategy<Value = Curve> {
    any_space().prop_flat_map(|space| {
        let n = space.len();
        (any_points(n), prop::option::of(prop::collection::vec(0.3..3.0_f64, n)))
            .prop_map(move |(points, weights)| Curve::build(space.clone(), points, weights).unwrap())
    })
}

/// A place within a span, away from its ends by a tenth of it, and the span's length.
fn inside(space: &Space, choice: f64, share: f64) -> (f64, f64) {
    let ends = space.breakpoints();
    let i = (choice * (ends.len() - 1) as f64) as usize;
    let length = ends[i + 1] - ends[i];
    (ends[i] + (0.1 + 0.8 * share) * length, length)
}

fn basis(space: &Space, u: f64, order: usize) -> Vec<f64> {
    let mut row = [0.0; MAX_ORDER];
    space.basis_into(space.span(u), u, order, &mut row);
    row[..=space.degree()].to_vec()
}

/// The space over the knots `scale · t + shift`.
fn mapped(space: &Space, scale: f64, shift: f64) -> Space {
    let knots = space.knots().iter().map(|t| scale * t + shift).collect();
    let make = if space.is_periodic() { Space::periodic } else { Space::open };
    make(space.degree(), knots).unwrap()
}

fn size(curve: &Curve) -> f64 {
    curve.points().iter().fold(0.0, |m, p| m.max(p.coords.amax()))
}

/// How large a derivative of this order may be for vertices of size 1 and weights from 0.3 to 3: the bound of a
/// polynomial curve, and a generous factor for a rational one.
fn scale(curve: &Curve, order: usize) -> f64 {
    let ends = curve.space().breakpoints();
    let shortest = ends.windows(2).map(|b| b[1] - b[0]).fold(f64::INFINITY, f64::min);
    let rational = if curve.weights().is_some() { 10.0 } else { 1.0 };
    (rational * 2.0 * curve.degree() as f64 / shortest).powi(order as i32)
}

proptest! {
    #[test]
    fn basis_functions_are_positive_and_sum_to_one(space in any_space(), share in 0.0..=1.0_f64) {
        let (a, b) = space.domain();
        for u in [a, (a + share * (b - a)).min(b), b] {
            let row = basis(&space, u, 0);
            prop_assert!(row.iter().all(|&x| (0.0..=1.0 + 1e-15).contains(&x)), "{:?}", row);
            prop_assert!((row.iter().sum::<f64>() - 1.0).abs() <= 1e-14);
            for order in 1..=space.degree() {
                // The derivative of 1.
                let row = basis(&space, u, order);
                let largest = row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                prop_assert!(row.iter().sum::<f64>().abs() <= 1e-13 * largest, "{:?}", row);
            }
        }
    }

    #[test]
    fn derivatives_are_the_limits_of_central_differences(
        curve in any_curve(), choice in 0.0..1.0_f64, share in 0.0..=1.0_f64,
    ) {
        let (u, length) = inside(curve.space(), choice, share);
        for order in 1..=curve.degree().min(4) {
            // Two steps and Richardson's extrapolation: the error is of fourth order in the step.
            let h = 1e-3 * length;
            let slope = |h: f64| -> Vector {
                let at = |u: f64| curve.derivative(u, order - 1).unwrap();
                (at(u + h) - at(u - h)) / (2.0 * h)
            };
            let expected = (slope(0.5 * h) * 4.0 - slope(h)) / 3.0;
            let found = curve.derivative(u, order).unwrap();
            let scale = size(&curve) * scale(&curve, order);
            prop_assert!((found - expected).norm() <= 1e-7 * scale, "order {}: {} {}", order, found, expected);
        }
    }

    #[test]
    fn an_affine_change_of_knots_changes_nothing_but_the_speed(
        curve in any_curve(), share in 0.0..=1.0_f64, exponent in -9..=9_i32, shift in -100.0..100.0_f64,
    ) {
        let factor = 10_f64.powi(exponent);
        let (space, points, weights) = curve.clone().into_parts();
        let other = Curve::build(mapped(&space, factor, factor * shift), points, weights).unwrap();
        let (u, _) = inside(&space, 0.999 * share, share);
        for order in 0..=curve.degree().min(3) {
            let expected = curve.derivative(u, order).unwrap();
            let found = other.derivative(factor * (u + shift), order).unwrap() * factor.powi(order as i32);
            // Knots around 100 are rounded to 1e-14, spans are at least 0.1 long.
            let scale = size(&curve) * scale(&curve, order);
            prop_assert!((found - expected).norm() <= 1e-11 * scale, "order {}: {} {}", order, found, expected);
        }
    }

    #[test]
    fn an_affine_map_of_the_vertices_maps_the_curve(
        curve in any_curve(), share in 0.0..=1.0_f64, exponent in -9..=9_i32,
    ) {
        let factor = 10_f64.powi(exponent);
        let map = |p: Point| Point::new(p.x - 2.0 * p.y, p.y + 0.5 * p.z, p.z + 3.0 * p.x + 1.0) * factor;
        let (space, points, weights) = curve.clone().into_parts();
        let other = Curve::build(space.clone(), points.into_iter().map(map).collect(), weights).unwrap();
        let (a, b) = space.domain();
        let u = (a + share * (b - a)).min(b);
        let (expected, found) = (map(curve.point(u).unwrap()), other.point(u).unwrap());
        prop_assert!((found - expected).norm() <= 1e-13 * factor * (1.0 + 4.0 * size(&curve)));
    }

    #[test]
    fn a_surface_is_a_curve_of_curves(
        u_space in any_space(), v_space in any_space(), s in 0.0..=1.0_f64, t in 0.0..=1.0_f64,
    ) {
        // P_ij = a_i b_j: the product of two functions, whose derivatives are products too.
        let wave = |n: usize, k: f64| -> Vec<f64> { (0..n).map(|i| (k * i as f64).sin()).collect() };
        let (a, b) = (wave(u_space.len(), 1.3), wave(v_space.len(), 0.7));
        let on_line = |space: &Space, values: &[f64]| {
            Curve::new(space.clone(), values.iter().map(|&x| Point::new(x, 0.0, 0.0)).collect()).unwrap()
        };
        let (first, second) = (on_line(&u_space, &a), on_line(&v_space, &b));
        let net = a.iter().flat_map(|x| b.iter().map(move |y| Point::new(x * y, 0.0, 0.0))).collect();
        let surface = Surface::new(u_space.clone(), v_space.clone(), net).unwrap();
        let ((u, _), (v, _)) = (inside(&u_space, 0.999 * s, t), inside(&v_space, 0.999 * t, s));
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let expected = first.derivative(u, i).unwrap().x * second.derivative(v, j).unwrap().x;
            let found = surface.derivative(u, v, i, j).unwrap().x;
            let scale = scale(&first, i) * scale(&second, j);
            prop_assert!((found - expected).abs() <= 1e-13 * scale, "({}, {}): {} {}", i, j, found, expected);
        }
    }
}
