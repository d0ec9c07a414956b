//! To turn, to move and to scale commutes with fine tuning, whatever the ends do.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{Ends, FineTune};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::algebra::Function;
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
