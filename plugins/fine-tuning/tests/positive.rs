//! α that is positive although some of its values are not, against an interior-point solver that knows α at two thousand places of each span
//! (`tests/golden/positive.py` makes `golden/positive.json`).

#![allow(clippy::unwrap_used, reason = "tests")]

use loftsman_fine_tuning::{Ends, FineTune, FineTuneSurface, Scaling, alpha_space, surface_alpha_spaces};
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

use crate::curves::{any_curve, size};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn least(alpha: &Function<f64>) -> f64 {
    let (a, b) = alpha.space().domain();
    (0..=20_000)
        .map(|k| alpha.value(a + (b - a) * f64::from(k) / 20_000.0).unwrap())
        .fold(f64::INFINITY, f64::min)
}

/// `(mean (α - 1)²)^½`, by Gauss's rule in each span.
fn from_one(alpha: &Function<f64>) -> f64 {
    let (x, w) = gauss_legendre(12);
    let breaks = alpha.space().breakpoints();
    let span = |pair: &[f64]| -> f64 {
        let h = pair[1] - pair[0];
        x.iter().zip(&w).map(|(x, w)| (alpha.value(pair[0] + h * x).unwrap() - 1.0).powi(2) * w * h).sum()
    };
    (breaks.windows(2).map(span).sum::<f64>() / alpha.space().length()).sqrt()
}

fn held(at: f64, to: f64) -> Constraint {
    position(at).on(1).axis(Axis::X).to(to)
}

/// An α that is asked to be next to nothing, where the ends do not let it: 1 is positive and keeps them.
#[test]
fn next_to_nothing_is_asked() {
    let (mut bounded, mut refused) = (0, 0);
    for seed in 0..60 {
        let given = any_curve(seed);
        let Ok(space) = alpha_space(&given) else { continue };
        for small in [1e-6, 1e-9, 1e-12] {
            let alpha = Function::constant(space.clone(), small).unwrap();
            match FineTune::new(&given, alpha).solve() {
                Ok(tuned) => {
                    let (a, b) = given.domain();
                    let off = (tuned.curve().point(b).unwrap() - given.point(b).unwrap()).norm();
                    let moved = (tuned.curve().point(a).unwrap() - given.point(a).unwrap()).norm();
                    assert!(off.max(moved) < 1e-9 * size(&given), "{seed} {small}: {off:e} {moved:e}");
                    let [least, most] = tuned.report().alpha;
                    assert!(least > 0.0, "{seed} {small}: {least}");
                    bounded += usize::from(least < 1e-5 * most);
                }
                // That 1 is the nearest, and too few values for more.
                Err(error) => {
                    let said = error.to_string();
                    let is_one = said.contains("1 is the nearest")
                        || said.contains("values where it needs")
                        || said.contains("1 value where it needs");
                    refused += usize::from(!is_one);
                }
            }
        }
    }
    assert!(bounded >= 20 && refused == 0, "{bounded} bounded, {refused} refused");
}

/// An α that is asked to be huge, where the ends do not let it: the curve that comes is huge, too, and so is what rounding leaves of a bound.
#[test]
fn a_million_times_as_long() {
    let (mut bounded, mut all) = (0, 0);
    for big in [1e4, 1e6, 1e8] {
        for seed in 0..60 {
            let given = any_curve(seed);
            let Ok(space) = alpha_space(&given) else { continue };
            let wavy = |k: usize| big * (1.0 + 0.5 * (k as f64).sin());
            let values = [vec![big; space.len()], (0..space.len()).map(wavy).collect()];
            for values in values {
                let alpha = Function::new(space.clone(), values).unwrap();
                let tuned =
                    FineTune::new(&given, alpha).solve().unwrap_or_else(|e| panic!("{seed} {big}: {e}"));
                let [least, most] = tuned.report().alpha;
                let (a, b) = given.domain();
                let off = (tuned.curve().point(b).unwrap() - given.point(b).unwrap()).norm();
                let moved = (tuned.curve().point(a).unwrap() - given.point(a).unwrap()).norm();
                // Beside the size of what was asked for.
                assert!(off.max(moved) < 1e-13 * big * size(&given), "{seed} {big}: {off:e} {moved:e}");
                assert!(least > 0.0, "{seed} {big}: {least}");
                all += 1;
                bounded += usize::from(least < 0.2 && most > 1e3);
            }
        }
    }
    assert!(all == 360 && bounded > 20, "{all} {bounded}");
}

/// α is found wherever there is one that is positive, it is the one of least change, and beyond the largest value that one can have it is refused.
#[test]
fn whatever_a_positive_alpha_reaches() {
    let all: Value = serde_json::from_str(include_str!("golden/positive.json")).unwrap();
    let (mut cases, mut negative) = (0, 0);
    for case in all["cases"].as_array().unwrap() {
        let degree = case["degree"].as_u64().unwrap() as usize;
        let space = Space::open(degree, numbers(&case["knots"])).unwrap();
        let points = case["points"].as_array().unwrap().iter().map(numbers);
        let points = points.map(|p| Point::new(p[0], p[1], 0.0)).collect();
        let curve = Curve::new(space, points).unwrap();
        let alpha_degree = case["alpha_degree"].as_u64().unwrap() as usize;
        let space = Space::clamped(alpha_degree, &curve.space().breakpoints()).unwrap();
        let name = format!("degree {degree}, α of {alpha_degree}, {} values", space.len());
        let number = |field: &str| case[field].as_f64().unwrap();
        let (at, most, to) = (number("at"), number("most"), number("to"));
        let tune = |to: f64| {
            let alpha = Function::constant(space.clone(), 1.0).unwrap();
            FineTune::new(&curve, alpha).ask(held(at, to))
        };
        let tuned = tune(to).solve().unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = tuned.alpha();
        assert!((found.value(at).unwrap() - to).abs() < 1e-11, "{name}");
        assert!(least(found) > 0.9999e-3, "{name}: {}", least(found));
        let best = Function::new(space.clone(), numbers(&case["alpha"])).unwrap();
        let (ours, theirs) = (from_one(found), from_one(&best));
        assert!(ours > theirs * (1.0 - 1e-6) && ours < theirs * (1.0 + 1e-6), "{name}: {ours}, {theirs}");
        assert!((tuned.report().change - ours).abs() < 1e-9 * ours, "{name}");
        negative += usize::from(found.coefficients().iter().any(|c| *c < 0.0));
        // Nearly all of what there is, and more than there is.
        let near = tune(1.0 + 0.998 * (most - 1.0)).solve();
        assert!(near.is_ok(), "{name}: {}", near.unwrap_err());
        let error = tune(most * 1.0001 + 0.001).solve().unwrap_err().to_string();
        assert!(error.contains("none that is at least 0.001 everywhere does it"), "{name}: {error}");
        let any = tune(most * 1.0001 + 0.001).any_sign().solve().unwrap();
        assert!(least(any.alpha()) < 1e-3, "{name}");
        cases += 1;
    }
    assert!(cases >= 39 && negative >= 20, "{cases} {negative}");
}

/// What is given may have negative values, too, where it is positive itself: of curves and surfaces, clamped, floating and periodic.
#[test]
fn what_is_given_is_judged_by_itself() {
    let mut refused = 0;
    for degree in 2..=5 {
        for kind in 0..3 {
            let knots = || (0..7).map(f64::from);
            let space = |degree: usize| match kind {
                0 => Space::clamped(degree, &knots().collect::<Vec<_>>()).unwrap(),
                1 => {
                    let all = (0..degree).map(|k| k as f64 - degree as f64).chain(knots());
                    Space::open(degree, all.chain((1..=degree).map(|k| 6.0 + k as f64)).collect()).unwrap()
                }
                _ => Space::periodic(degree, knots().collect()).unwrap(),
            };
            let own = space(degree + 1);
            let points = (0..own.len()).map(|k| Point::new((k as f64).cos() * 3.0, (k as f64).sin(), 0.1));
            let curve = Curve::new(own, points.collect()).unwrap();
            for (dip, good) in [(-0.1, true), (-5.0, false)] {
                let mut values = vec![1.0; space(degree).len()];
                values[3] = dip;
                let alpha = Function::new(space(degree), values).unwrap();
                assert_eq!(least(&alpha) > 0.0, good, "{degree} {kind} {dip}");
                let tuned = FineTune::new(&curve, alpha.clone()).ends(Ends::Free).solve();
                assert_eq!(tuned.is_ok(), good, "{degree} {kind} {dip}");
                if let Err(error) = tuned {
                    let error = error.to_string();
                    let told: f64 = error.split(' ').nth(2).unwrap().parse().unwrap();
                    assert!((told - least(&alpha)).abs() < 1e-6 && error.contains("(value 3)"), "{error}");
                    refused += 1;
                }
            }
        }
    }
    assert_eq!(refused, 12);
    let space = || Space::clamped_uniform(3, 6).unwrap();
    let points =
        (0..36).map(|k| Point::new(f64::from(k / 6), f64::from(k % 6), f64::from(k % 5) * 0.2)).collect();
    let surface = Surface::new(space(), space(), points).unwrap();
    let [u, v] = surface_alpha_spaces(&surface).unwrap();
    for direction in [loftsman_kernel::spline::Direction::U, loftsman_kernel::spline::Direction::V] {
        let (a, b) = (u.clone(), space());
        let [a, b] = if direction == loftsman_kernel::spline::Direction::U { [a, b] } else { [b, v.clone()] };
        let columns = b.len();
        for (dip, good) in [(-0.2, true), (-2.0, false)] {
            let mut values = vec![1.0; a.len() * columns];
            values[2 * columns + 3] = dip;
            let alpha = Field::new(a.clone(), b.clone(), values).unwrap();
            let tuned =
                FineTuneSurface::new(&surface, Scaling::along(direction, alpha)).ends(Ends::Free).solve();
            assert_eq!(tuned.is_ok(), good, "{dip}");
            if let Err(error) = tuned {
                assert!(error.to_string().contains("(value [2, 3])"), "{error}");
            }
        }
    }
}

/// Hundreds of values of α of which most are held: the bounds are those that count, and the ends stay.
#[test]
fn hundreds_of_places() {
    let n = 300;
    let points = (0..n).map(|k| Point::new(f64::from(k), 8.0 * (0.05 * f64::from(k)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, n as usize).unwrap(), points).unwrap();
    let space = alpha_space(&curve).unwrap();
    let (_, end) = curve.domain();
    let tall = |k: usize| if space.greville(k) < 0.6 * end { 0.004 } else { 4.0 };
    let alpha = Function::new(space.clone(), (0..space.len()).map(tall).collect()).unwrap();
    let tuned = FineTune::new(&curve, alpha).solve().unwrap();
    assert!(least(tuned.alpha()) > 0.0, "{}", least(tuned.alpha()));
    let off: Vector = tuned.curve().point(end).unwrap() - curve.point(end).unwrap();
    assert!(off.norm() < 1e-9, "{off}");
}

/// Far below zero over half of a curve, of which α is to be held all along: it is found span by span and not from its ends inwards, and where it leaves the
/// bound, between two places that are held.
#[test]
fn half_of_a_curve() {
    let n = 400;
    let points = (0..n).map(|k| Point::new(f64::from(k), 8.0 * (0.05 * f64::from(k)).sin(), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, n as usize).unwrap(), points).unwrap();
    let space = alpha_space(&curve).unwrap();
    let last = (space.len() - 1) as f64;
    let rising = (0..space.len()).map(|k| 0.01 + 9.99 * k as f64 / last).collect();
    let alpha = Function::new(space, rising).unwrap();
    let tuned = FineTune::new(&curve, alpha).solve().unwrap();
    let (found, (_, end)) = (tuned.alpha(), curve.domain());
    let [low, high] = tuned.report().alpha;
    assert!(low > 0.0 && least(found) > 0.9999e-6 * high, "{low} {high}");
    let off: Vector = tuned.curve().point(end).unwrap() - curve.point(end).unwrap();
    assert!(off.norm() < 1e-9, "{off}");
    let held = (0..4000).map(|k| found.value(end * f64::from(k) / 4000.0).unwrap());
    assert!(held.filter(|value| *value < 1e-4).count() > 1500);
}
