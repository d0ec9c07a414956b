//! Control vertices of the tuned curve by their numbers: kept, moved by, set, against the given curve brought to the tuned one's degree and knots by
//! tuning it with α = 1, which changes nothing.

#![allow(clippy::unwrap_used, reason = "tests")]

use loftsman_fine_tuning::{FineTune, alpha_of, alpha_space};
use loftsman_kernel::edit::{Ask, Axis};
use loftsman_kernel::functional::{linear, vertex};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Knots of a domain from 0 to 6, unlike ones, one of them `double`.
fn breaks(double: bool) -> Vec<f64> {
    let mut knots = vec![0.0, 0.9, 2.2, 2.9, 4.0, 4.7, 6.0];
    if double {
        knots.insert(3, 2.2);
    }
    knots
}

/// A curve of a kind: 0 clamped, 1 floating, 2 periodic.
fn wave(degree: usize, kind: usize, double: bool) -> Curve {
    let knots = breaks(double && degree > 1);
    let space = if kind == 2 {
        Space::periodic(degree, knots).unwrap()
    } else {
        let before = |k: usize| if kind == 0 { 0.0 } else { -0.8 * (degree - k) as f64 };
        let after = |k: usize| if kind == 0 { 6.0 } else { 6.0 + 1.1 * k as f64 };
        let all = (0..degree).map(before).chain(knots).chain((1..=degree).map(after)).collect();
        Space::open(degree, all).unwrap()
    };
    let at = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / space.len() as f64;
        Point::new(
            3.0 * angle.cos(),
            2.0 * angle.sin() + 0.4 * (3.0 * angle).cos(),
            0.2 * (2.0 * angle).sin(),
        )
    };
    let points = (0..space.len()).map(at).collect();
    Curve::new(space, points).unwrap()
}

/// What is kept stays where the given curve has that vertex, what is moved is moved from there, at each number and from either end; of closed curves, too.
#[test]
fn vertices_of_the_tuned_curve() {
    let (mut met, mut refused) = (0, 0);
    for degree in 2..=5 {
        for (kind, double) in [(0, false), (0, true), (1, false), (2, false), (2, true)] {
            let given = wave(degree, kind, double);
            let space = alpha_space(&given).unwrap();
            let values = (0..space.len()).map(|k| 1.0 + 0.15 * (1.3 * k as f64).sin()).collect();
            let alpha = alpha_of(&given, values).unwrap();
            let one = Function::constant(space, 1.0).unwrap();
            let same = FineTune::new(&given, one).solve().unwrap().into_curve();
            let free = FineTune::new(&given, alpha.clone()).solve().unwrap();
            let n = same.points().len();
            if (degree, kind, double) == (2, 2, true) {
                // A corner: how many vertices the closed curve has depends on α.
                let error = FineTune::new(&given, alpha).ask(vertex(3).keep()).solve().unwrap_err();
                assert!(error.to_string().contains("ask for a position"), "{error}");
                continue;
            }
            assert_eq!(free.curve().points().len(), n);
            for index in (0..n as i64).step_by(3).chain([-1, -2]) {
                let number = index.rem_euclid(n as i64) as usize;
                for by in [0.0, 0.003] {
                    let way = Vector::new(by, 0.0, 0.0);
                    let ask = vertex(index).axis(Axis::X);
                    let ask = if by == 0.0 { ask.keep() } else { ask.by(by) };
                    let case = format!("degree {degree}, kind {kind}, {double}, vertex {index}, by {by}");
                    match FineTune::new(&given, alpha.clone()).any_sign().force().ask(ask).solve() {
                        Ok(tuned) => {
                            let found = tuned.curve().points()[number];
                            let off = (found - same.points()[number] - way).x;
                            assert!(off.abs() < 1e-9, "{case}: {off:e}");
                            met += 1;
                        }
                        // The first and the last vertex of an open curve are its ends, which stay.
                        Err(error) => {
                            let is_end = kind < 2 && (number == 0 || number + 1 == n) && by != 0.0;
                            assert!(is_end, "{case}: {error}");
                            refused += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(met > 250 && refused < 60, "{met} met, {refused} refused");
}

/// Sums of numbered vertices; and a number that is not there is told with how many there are.
#[test]
fn sums_and_numbers_that_are_not_there() {
    for kind in 0..3 {
        let given = wave(3, kind, false);
        let alpha = alpha_of(
            &given,
            vec![1.0, 1.1, 0.9, 1.2, 1.0, 0.8, 1.1, 1.05][..alpha_space(&given).unwrap().len()].to_vec(),
        );
        let alpha = alpha.unwrap();
        let one = Function::constant(alpha.space().clone(), 1.0).unwrap();
        let same = FineTune::new(&given, one).solve().unwrap().into_curve();
        let (a, b) = (Vector::new(1.0, 0.5, 0.0), Vector::new(0.0, -1.0, 0.3));
        let ask = linear([(2, a), (7, b)]).keep();
        let tuned = FineTune::new(&given, alpha.clone()).ask(ask).solve().unwrap();
        let sum = |c: &Curve| a.dot(&c.points()[2].coords) + b.dot(&c.points()[7].coords);
        let off = (sum(tuned.curve()) - sum(&same)).abs();
        assert!(off < 1e-12, "{kind}: {off:e}");
        let n = same.points().len();
        let error =
            FineTune::new(&given, alpha).ask(vertex(n as i64).keep()).solve().unwrap_err().to_string();
        assert!(error.contains(&n.to_string()), "{kind}, {n}: {error}");
    }
}
