//! Points to pass, points and areas kept and lengths asked for in one step with α: against quadrature of our own, of α times the given derivative.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_area_volume::{area, length};
use loftsman_fine_tuning::{FineTune, Tuned, alpha_of, alpha_space};
use loftsman_kernel::edit::{Ask, Axis};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Numbers of a fixed sequence, in [0, 1).
struct Lcg(u64);

impl Lcg {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// `∫ f` from one parameter to another, span by span of a curve.
fn integral<T>(curve: &Curve, from: f64, to: f64, nodes: usize, f: impl Fn(f64) -> T) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::iter::Sum<T>,
{
    let (x, w) = gauss_legendre(nodes);
    let mut all: Vec<f64> = curve.space().breakpoints().to_vec();
    all.retain(|t| *t > from && *t < to);
    all.insert(0, from);
    all.push(to);
    let pieces: Vec<[f64; 2]> = all.windows(2).map(|p| [p[0], p[1] - p[0]]).collect();
    pieces
        .iter()
        .flat_map(|[a, h]| x.iter().zip(&w).map(move |(x, w)| (a + h * x, h * w)))
        .map(|(t, weight)| f(t) * weight)
        .sum()
}

/// Where the tuned curve is: where the given one starts, and α times its derivative from there.
fn tuned_at(given: &Curve, tuned: &Tuned, t: f64) -> Point {
    let start = given.domain().0;
    let way: Vector =
        integral(given, start, t, 12, |t| given.derivative(t, 1).unwrap() * tuned.alpha().value(t).unwrap());
    given.point(start).unwrap() + way
}

fn length_of(curve: &Curve) -> f64 {
    let (a, b) = curve.domain();
    integral(curve, a, b, 40, |t| curve.derivative(t, 1).unwrap().norm())
}

fn area_of(curve: &Curve) -> f64 {
    let (a, b) = curve.domain();
    integral(curve, a, b, 12, |t| {
        let (p, d) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
        0.5 * (p.x * d.y - p.y * d.x)
    })
}

/// The tuned curve is that of its α, whatever was asked.
fn assert_is_tuned(given: &Curve, tuned: &Tuned, size: f64, context: &str) {
    let (a, b) = given.domain();
    for k in 0..=10 {
        let t = a + (b - a) * f64::from(k) / 10.0;
        let off = (tuned.curve().point(t).unwrap() - tuned_at(given, tuned, t)).norm();
        assert!(off < 1e-11 * size, "{context}, {t}: {off:e}");
    }
    assert!(tuned.report().alpha[0] > 0.0, "{context}");
}

/// Closed curves in the plane: one point passed, another kept, the area kept or a tenth larger, all exactly, at any size.
#[test]
fn an_area_beside_points() {
    for seed in 0..12 {
        let mut random = Lcg(seed);
        (0..9).for_each(|_| {
            random.next();
        });
        let size = [1.0, 1e-9, 1e9][seed as usize % 3];
        let n = 16 + seed as usize % 5;
        let mut knots = vec![0.0];
        (0..n).for_each(|k| knots.push(knots[k] + 0.5 + random.next()));
        let points = (0..n)
            .map(|i| {
                let (a, r) = (i as f64 / n as f64 * std::f64::consts::TAU, 0.9 + 0.2 * random.next());
                Point::new(3.0 * r * a.cos(), 2.0 * r * a.sin(), 0.0) * size
            })
            .collect();
        let curve = Curve::new(Space::periodic(3, knots).unwrap(), points).unwrap();
        let values = (0..n).map(|_| 0.9 + 0.2 * random.next()).collect();
        let alpha = alpha_of(&curve, values).unwrap();
        let (a, b) = curve.domain();
        let at = |part: f64| a + (b - a) * part;
        let (pass, keep) = (at(0.3 + 0.1 * random.next()), at(0.6 + 0.2 * random.next()));
        let by = Vector::new(random.next() - 0.5, random.next() - 0.5, 0.0) * (0.1 * size);
        let to = curve.point(pass).unwrap() + by;
        let before = area_of(&curve);
        let target = before * if seed % 2 == 0 { 1.0 } else { 1.02 };
        let tuned = FineTune::new(&curve, alpha)
            .through(pass, to)
            .ask(position(keep).keep())
            .ask(if seed % 2 == 0 { area().keep() } else { area().to(target) })
            .solve()
            .unwrap_or_else(|e| panic!("{seed}: {e}"));
        let context = format!("seed {seed}");
        assert_is_tuned(&curve, &tuned, size, &context);
        let off = (tuned_at(&curve, &tuned, pass) - to).norm();
        assert!(off < 1e-11 * size, "{context}: {off:e}");
        let off = (tuned_at(&curve, &tuned, keep) - curve.point(keep).unwrap()).norm();
        assert!(off < 1e-11 * size, "{context}: {off:e}");
        let off = (tuned_at(&curve, &tuned, b) - curve.point(a).unwrap()).norm();
        assert!(off < 1e-11 * size, "{context}: it stays closed, {off:e}");
        let off = area_of(tuned.curve()) / target - 1.0;
        assert!(off.abs() < 1e-10, "{context}: {off:e}");
        // Without the area it is another.
        let apart = |t: &Tuned| (area_of(t.curve()) / target - 1.0).abs();
        let alpha = tuned.alpha().clone();
        let free =
            FineTune::new(&curve, alpha_of(&curve, vec![1.0; n]).unwrap()).through(pass, to).solve().unwrap();
        assert!(apart(&free) > 1e-6, "{context}: the area would stay by itself");
        assert_eq!(alpha.space(), &alpha_space(&curve).unwrap());
    }
}

/// Curves in space: a point passed, a coordinate kept and the length asked for, of all of it and of a range.
#[test]
fn a_length_beside_points() {
    for seed in 0..12 {
        let mut random = Lcg(100 + seed);
        (0..9).for_each(|_| {
            random.next();
        });
        let size = [1.0, 1e-9, 1e9][seed as usize % 3];
        let n = 18 + seed as usize % 5;
        let points = (0..n)
            .map(|i| {
                let x = i as f64;
                Point::new(x + 0.3 * random.next(), (0.6 * x).sin() * 2.0, (0.37 * x).cos() * 1.5) * size
            })
            .collect();
        let curve = Curve::new(Space::clamped_uniform(3, n).unwrap(), points).unwrap();
        let alpha = alpha_of(&curve, (0..n - 1).map(|_| 0.9 + 0.2 * random.next()).collect()).unwrap();
        let (a, b) = curve.domain();
        let at = |part: f64| a + (b - a) * part;
        let (pass, keep) = (at(0.4 + 0.05 * random.next()), at(0.6 + 0.05 * random.next()));
        let by = Vector::new(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5) * (0.2 * size);
        let to = curve.point(pass).unwrap() + by;
        let target = length_of(&curve) * 1.01;
        let whole = FineTune::new(&curve, alpha)
            .through(pass, to)
            .ask(position(keep).axis(Axis::Y).keep())
            .ask(length().to(target));
        let is_range = seed % 2 == 1;
        let tune = if is_range { whole.between(at(0.1), at(0.9)).continuity(1) } else { whole };
        let tuned = tune.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        let context = format!("seed {seed}");
        let point = |t: f64| tuned.curve().point(t).unwrap();
        if !is_range {
            assert_is_tuned(&curve, &tuned, size, &context);
        }
        for (t, wanted) in [(pass, to), (a, curve.point(a).unwrap()), (b, curve.point(b).unwrap())] {
            let off = (point(t) - wanted).norm();
            assert!(off < 1e-11 * size, "{context}, {t}: {off:e}");
        }
        let off = (point(keep).y - curve.point(keep).unwrap().y).abs();
        assert!(off < 1e-11 * size, "{context}: {off:e}");
        let off = length_of(tuned.curve()) / target - 1.0;
        assert!(off.abs() < 1e-8, "{context}: {off:e}");
        if is_range {
            for t in [at(0.03), at(0.95)] {
                assert!((point(t) - curve.point(t).unwrap()).norm() < 1e-13 * n as f64 * size, "{context}");
            }
            // On the range α times what was there.
            for k in 1..10 {
                let t = at(0.1) + (at(0.9) - at(0.1)) * f64::from(k) / 10.0;
                let scaled = curve.derivative(t, 1).unwrap() * tuned.alpha().value(t).unwrap();
                let off = (tuned.curve().derivative(t, 1).unwrap() - scaled).norm();
                assert!(off < 1e-10 * size, "{context}, {t}: {off:e}");
            }
        }
    }
}

/// What contradicts itself beside a point to pass is said: a point that is to be in two places, and a length that is too short for its ends.
#[test]
fn what_does_not_go_together_is_said() {
    let points = (0..14).map(f64::from).map(|x| Point::new(x, (0.7 * x).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 14).unwrap(), points).unwrap();
    let tune = || FineTune::new(&curve, alpha_of(&curve, vec![1.0; 13]).unwrap());
    let there = curve.point(4.0).unwrap();
    let twice = tune().through(4.0, there + Vector::x() * 0.1).ask(position(4.0).keep()).solve();
    let error = twice.unwrap_err().to_string();
    assert!(error.contains("through[0]") && error.contains("position"), "{error}");
    let short = tune().through(4.0, there).ask(length().to(1.0)).solve().unwrap_err().to_string();
    assert!(short.contains("length") || short.contains("α"), "{short}");
}
