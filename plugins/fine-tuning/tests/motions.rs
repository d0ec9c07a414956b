//! To turn, to move and to scale commutes with fine tuning, whatever the ends do.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{Ends, FineTune};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

use crate::curves::{any_alpha, any_curve, places, size};

/// What is asked for, of a curve whose domain is known.
type Asking = fn(FineTune, (f64, f64)) -> FineTune;

#[test]
fn similarities_commute_with_every_kind_of_ends() {
    let all: [(&str, Asking); 7] = [
        ("free", |tune, _| tune.ends(Ends::Free)),
        ("exact", |tune, _| tune),
        ("position", |tune, _| tune.ends(Ends::Position)),
        ("tangent", |tune, _| tune.ends(Ends::Tangent)),
        ("curvature", |tune, _| tune.ends(Ends::Curvature)),
        ("a part", |tune, (a, b)| tune.between(a + 0.2 * (b - a), a + 0.9 * (b - a))),
        ("a part up to the end", |tune, (a, b)| tune.between(a + 0.4 * (b - a), b).continuity(1)),
    ];
    let (mut refused, mut done) = (0, 0);
    for case in 0..120 {
        let curve = any_curve(case);
        let alpha = any_alpha(&curve, case);
        let turn = Rotation3::from_euler_angles(0.3 + case as f64, -1.1, 2.0);
        let by = Vector::new(3.0, -2.0, 1.0) * size(&curve);
        let factor = [1.0, 1e-6, 1e6][case as usize % 3];
        let to = |p: &Point| Point::from((turn * p.coords + by) * factor);
        let (space, points, _) = curve.clone().into_parts();
        let moved = Curve::new(space, points.iter().map(to).collect()).unwrap();
        for (name, asking) in all {
            let tuned = |curve: &Curve, alpha: &Function<f64>| {
                asking(FineTune::new(curve, alpha.clone()), curve.domain()).solve()
            };
            match (tuned(&curve, &alpha), tuned(&moved, &alpha)) {
                (Ok(one), Ok(other)) => {
                    done += 1;
                    let digits = if curve.degree() > 7 { 1e-9 } else { 1e-11 };
                    for u in places(&curve) {
                        let expected = to(&one.curve().point(u).unwrap());
                        let off = (other.curve().point(u).unwrap() - expected).norm() / size(&moved);
                        assert!(off < digits, "{case} {name}: {off:e} at {u}");
                    }
                }
                (Err(one), Err(other)) => {
                    assert_eq!(std::mem::discriminant(&one), std::mem::discriminant(&other), "{one} {other}");
                    refused += 1;
                }
                (one, other) => panic!("{case} {name}: {:?} {:?}", one.err(), other.err()),
            }
        }
    }
    println!("{done} done, {refused} refused");
    assert!(done > 500, "{done} done, {refused} refused");
}

/// A plane curve is one wherever its plane is, at whatever height above the origin and however far away: what rounding makes of its third direction is no
/// equation. Tuned as it lies in z = 0 and moved, or moved and tuned, whole and in part: the same α and the same curve.
#[test]
fn a_plane_is_a_plane_wherever_it_is() {
    let mut tuned = 0;
    for seed in 0..60 {
        let any = any_curve(seed);
        let size = size(&any);
        // Of size 1, and plane.
        let flat: Vec<Point> = any.points().iter().map(|p| Point::new(p.x / size, p.y / size, 0.0)).collect();
        let curve = Curve::new(any.space().clone(), flat.clone()).unwrap();
        let alpha = any_alpha(&curve, seed);
        let (a, b) = curve.domain();
        let range = (seed % 2 == 1).then_some((a + 0.2 * (b - a), a + 0.83 * (b - a)));
        let tune = |curve: &Curve| {
            let plain = FineTune::new(curve, alpha.clone());
            match range {
                Some((from, to)) => plain.between(from, to),
                None => plain,
            }
            .any_sign()
            .solve()
        };
        let Ok(here) = tune(&curve) else { continue };
        let askew = Rotation3::from_euler_angles(0.7, -0.4, 1.9);
        let places: [(Rotation3<f64>, Vector); 5] = [
            (Rotation3::identity(), Vector::new(0.0, 0.0, 0.7)),
            (Rotation3::identity(), Vector::new(3.3, -2.1, 100.1)),
            (Rotation3::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0), Vector::new(0.0, 0.3, 0.0)),
            (askew, Vector::new(0.1, 0.2, 0.3)),
            (askew, Vector::new(500.0, -200.0, 70.0)),
        ];
        for (k, (turn, shift)) in places.iter().enumerate() {
            let at = |p: &Point| turn * p + shift;
            let moved = Curve::new(curve.space().clone(), flat.iter().map(at).collect()).unwrap();
            let there = tune(&moved).unwrap_or_else(|e| panic!("{seed} {k}: {e}"));
            let far = 1.0 + shift.amax();
            let alphas = here.alpha().coefficients().iter().zip(there.alpha().coefficients());
            let most = here.alpha().coefficients().iter().fold(1.0_f64, |m, c| m.max(c.abs()));
            for (one, other) in alphas {
                assert!((one - other).abs() < 1e-8 * far * most, "{seed} {k}: {one} {other}");
            }
            for i in 0..=20 {
                let u = a + (b - a) * f64::from(i) / 20.0;
                let (one, other) = (at(&here.curve().point(u).unwrap()), there.curve().point(u).unwrap());
                assert!((one - other).norm() < 1e-9 * far * most, "{seed} {k} {u}: {one} {other}");
            }
            tuned += 1;
        }
        // Noise of rounding above the plane.
        let noise = |k: usize| 1e-16 * (k as f64 * 1.7).sin();
        let noisy = flat.iter().enumerate().map(|(k, p)| Point::new(p.x, p.y, noise(k)));
        let noisy = tune(&Curve::new(curve.space().clone(), noisy.collect()).unwrap());
        let noisy = noisy.unwrap_or_else(|e| panic!("{seed}: {e}"));
        for (one, other) in here.alpha().coefficients().iter().zip(noisy.alpha().coefficients()) {
            assert!((one - other).abs() < 1e-9 * one.abs().max(1.0), "{seed}: {one} {other}");
        }
    }
    assert!(tuned > 200, "{tuned}");
}

/// A loop that closes whatever α is (one number, as a step over all of it) or in one coordinate (halves that are alike) is no equation there.
#[test]
fn what_closes_by_itself_is_no_equation() {
    for degree in 2..=5 {
        let space = Space::periodic_uniform(degree, 12).unwrap();
        let ring = (0..12).map(|i| f64::from(i) / 12.0 * std::f64::consts::TAU);
        let points = ring.map(|a| Point::new(3.0 * a.cos() + 0.7, 2.0 * a.sin(), 0.7)).collect();
        let curve = Curve::new(space, points).unwrap();
        let (a, b) = curve.domain();
        for value in [0.64, 1.0, 2.3] {
            let alpha = Function::new(Space::open(0, vec![a, b]).unwrap(), vec![value]).unwrap();
            let tuned =
                FineTune::new(&curve, alpha).solve().unwrap_or_else(|e| panic!("{degree} {value}: {e}"));
            let [low, high] = tuned.report().alpha;
            assert!((low - value).abs() + (high - value).abs() < 1e-12, "{degree} {value}: {low} {high}");
            let start = curve.point(a).unwrap();
            for i in 0..=12 {
                let u = a + (b - a) * f64::from(i) / 12.0;
                let wanted = start + (curve.point(u).unwrap() - start) * value;
                assert!((tuned.curve().point(u).unwrap() - wanted).norm() < 1e-12, "{degree} {value} {u}");
            }
        }
        // Halves on either side of an axis of symmetry: nothing but the other axis has anything to say.
        let middle = 0.5 * (a + b);
        let halves = Function::new(Space::open(0, vec![a, middle, b]).unwrap(), vec![1.3, 0.9]).unwrap();
        let tuned = FineTune::new(&curve, halves).solve().unwrap_or_else(|e| panic!("{degree}: {e}"));
        let [low, high] = tuned.report().alpha;
        assert!((low - 1.1).abs() < 1e-9 && (high - 1.1).abs() < 1e-9, "{degree}: {low} {high}");
    }
}
