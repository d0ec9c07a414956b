//! Both derivatives by least squares.

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling, surface_alpha_of, surface_alpha_spaces};
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::Field;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::family::*;

fn net(space: [&Space; 2], value: impl Fn(f64, f64) -> f64) -> Field<f64> {
    let [u, v] = space;
    let each = (0..u.len()).flat_map(|i| (0..v.len()).map(move |j| (i, j)));
    let values = each.map(|(i, j)| value(u.greville(i), v.greville(j))).collect();
    Field::new(u.clone(), v.clone(), values).unwrap()
}

/// Both derivatives by a constant: the exact surface, scaled about its corner.
#[test]
fn least_squares_of_what_is_integrable() {
    for case in 0..60 {
        let surface = any_surface(case);
        let [u, v] = surface_alpha_spaces(&surface).unwrap();
        let (u0, v0) = (surface.u().domain().0, surface.v().domain().0);
        let start = surface.point(u0, v0).unwrap();
        for c in [1.0, 0.4, 1.7] {
            let alpha = net([&u, &v], |_, _| c);
            let tuned =
                FineTuneSurface::new(&surface, Scaling::both(alpha)).ends(Ends::Free).solve().unwrap();
            for (u, v) in places(&surface) {
                let expected = start + (surface.point(u, v).unwrap() - start) * c;
                let off = (tuned.surface().point(u, v).unwrap() - expected).norm() / size(&surface);
                assert!(off <= 1e-10, "{case} {c} at {u} {v}: {off:e}");
            }
            assert!(tuned.report().residual.unwrap() <= 1e-10, "{case} {:?}", tuned.report());
            assert_eq!(tuned.surface().u().is_periodic(), surface.u().is_periodic());
            assert_eq!(tuned.surface().v().is_periodic(), surface.v().is_periodic());
        }
    }
}

/// Gauss's rule on [0, 1]: Newton's method on the Legendre polynomial.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let at = |x: f64| {
        let (mut p, mut q) = (1.0, 0.0);
        for k in 1..=n {
            let k = k as f64;
            (p, q) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * q) / k, p);
        }
        (p, n as f64 * (x * p - q) / (x * x - 1.0))
    };
    let node = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        (0..20).for_each(|_| x -= at(x).0 / at(x).1);
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * at(x).1.powi(2)))
    };
    (0..n).map(node).collect()
}

/// `∫∫ |D_u - αS_u|² + |D_v - αS_v|²`, by Gauss's rule with eight points a span, which is exact to degree 15.
fn energy(given: &Surface, tuned: &Surface, alpha: &Field<f64>) -> f64 {
    let rule_of_8 = gauss(8);
    let rule = |space: &Space| {
        let each = space.breakpoints();
        let pairs = each.windows(2).flat_map(|w| {
            let (a, h) = (w[0], w[1] - w[0]);
            rule_of_8.iter().map(move |(x, w)| (a + h * x, h * w))
        });
        pairs.collect::<Vec<_>>()
    };
    let mut sum = 0.0;
    let in_v = rule(tuned.v());
    for (u, w) in rule(tuned.u()) {
        for (v, y) in &in_v {
            let a = alpha.value(u, *v).unwrap();
            for direction in [U, V] {
                let off = slope(tuned, direction, (u, *v)) - slope(given, direction, (u, *v)) * a;
                sum += w * y * off.norm_squared();
            }
        }
    }
    sum
}

/// No direction in which vertices may move makes the sum of squares smaller, and it is the one that is reported.
#[test]
fn least_squares_are_least() {
    let mut done = 0;
    for case in 0..120 {
        let (surface, mut random) = (any_surface(case), Lcg::new(case + 6000));
        if surface.u().degree() > 3 || surface.v().degree() > 3 {
            continue;
        }
        let values = |n: usize, random: &mut Lcg| (0..n).map(|_| 0.5 + random.next()).collect::<Vec<_>>();
        let [u, v] = surface_alpha_spaces(&surface).unwrap();
        let alpha = surface_alpha_of(&surface, values(u.len() * v.len(), &mut random)).unwrap();
        let ends = [Ends::Free, Ends::Position, Ends::Tangent, Ends::Curvature][random.below(4)];
        let Ok(tuned) = FineTuneSurface::new(&surface, Scaling::both(alpha.clone())).ends(ends).solve()
        else {
            continue;
        };
        done += 1;
        let own = tuned.surface();
        let whole = raised(&surface, own);
        let kept = match ends {
            Ends::Position => 1,
            Ends::Tangent => 2,
            Ends::Curvature => 3,
            _ => 0,
        };
        let (rows, columns) = (own.u().len(), own.v().len());
        let of_u = if own.u().is_periodic() { 0 } else { kept };
        let of_v = if own.v().is_periodic() { 0 } else { kept };
        let edge = |k: usize, of: usize, kept: usize| k < kept || k + kept >= of;
        let is_kept = |k: usize| edge(k / columns, rows, of_u) || edge(k % columns, columns, of_v);
        // A closed direction may be numbered from elsewhere.
        let numbered = whole.u() == own.u() && whole.v() == own.v();
        for k in (0..rows * columns).filter(|k| numbered && is_kept(*k)) {
            assert!((own.points()[k] - whole.points()[k]).norm() <= 1e-12 * size(&surface), "{case} {k}");
        }
        let least = energy(&surface, own, &alpha);
        let all = energy(
            &surface,
            &Surface::new(own.u().clone(), own.v().clone(), vec![Point::origin(); rows * columns]).unwrap(),
            &alpha,
        );
        let reported = tuned.report().residual.unwrap();
        assert!(
            ((least / all).sqrt() - reported).abs() <= 1e-9,
            "{case}: {} {reported}",
            (least / all).sqrt()
        );
        for _ in 0..3 {
            let step: Vec<Vector> = (0..rows * columns)
                .map(|k| {
                    let way = Vector::new(random.next(), random.next(), random.next()) - Vector::repeat(0.5);
                    if is_kept(k) { Vector::zeros() } else { way * size(&surface) }
                })
                .collect();
            let moved = |by: f64| {
                let points = own.points().iter().zip(&step).map(|(p, s)| p + s * by).collect();
                energy(&surface, &Surface::new(own.u().clone(), own.v().clone(), points).unwrap(), &alpha)
            };
            // A parabola: its slope at 0 against its curvature.
            let (ahead, behind) = (moved(1e-2), moved(-1e-2));
            let (slope, bend) = ((ahead - behind) / 2.0, (ahead + behind) / 2.0 - least);
            assert!(
                slope.abs() <= 1e-9 * (bend * least.max(1e-6 * all)).sqrt().max(bend),
                "{case} {ends:?}: {slope:e} {bend:e} {least:e}"
            );
        }
    }
    assert!(done >= 12, "{done}");
}

/// Another β than α, where both together are the derivatives of a surface: a plane net stretched along its two axes.
#[test]
fn least_squares_of_two_scales() {
    let (u, v) = (Space::clamped_uniform(3, 7).unwrap(), Space::periodic_uniform(2, 6).unwrap());
    let at = |i: u32, j: u32| Point::new(f64::from(i * i), f64::from(j * 5 % 6), 0.0);
    let points = (0..7).flat_map(|i| (0..6).map(move |j| at(i, j))).collect();
    let surface = Surface::new(u, v, points).unwrap();
    let [u, v] = surface_alpha_spaces(&surface).unwrap();
    let scaling = Scaling::Both { u: net([&u, &v], |_, _| 2.0), v: net([&u, &v], |_, _| 0.5) };
    let tuned = FineTuneSurface::new(&surface, scaling).ends(Ends::Free).solve().unwrap();
    let start = surface.point(0.0, 0.0).unwrap();
    for (u, v) in places(&surface) {
        let way = surface.point(u, v).unwrap() - start;
        let expected = start + Vector::new(2.0 * way.x, 0.5 * way.y, 0.0);
        assert!((tuned.surface().point(u, v).unwrap() - expected).norm() <= 1e-11 * size(&surface));
    }
    assert!(tuned.report().residual.unwrap() <= 1e-12);
}
