//! What an edit says of what was dropped, what was missed, and what could be done.
#![allow(clippy::unwrap_used, reason = "tests")]

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::spline::{Curve, Space};

/// A cubic of twelve vertices over [0, 9].
fn twelve() -> Curve {
    let heights = [0.0, 1.0, 0.5, -0.5, 0.8, 1.2, 0.2, -0.6, 0.0, 1.0, 0.7, 0.0];
    let points = heights.iter().enumerate().map(|(i, h)| Point::new(i as f64, *h, 0.0)).collect();
    Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap()
}

#[test]
fn a_best_effort_says_what_it_missed_and_calls_nothing_of_it_redundant() {
    let curve = twelve();
    let (a, _) = curve.domain();
    // Nothing moves the locked start; what is asked twice agrees; what is asked twice and differs is missed by half.
    let cases: [(Edit<Curve>, usize, &[&str]); 5] = [
        (
            Edit::new(&curve).lock([0]).ask(position(a).by([0.0, 1.0, 0.0])).ask(position(4.5).keep()),
            0,
            &["position at 0 by 1"],
        ),
        (
            Edit::new(&curve).ask(position(4.5).by([0.0, 1.0, 0.0])).ask(position(4.5).by([0.0, 2.0, 0.0])),
            0,
            &["by 0.5", "by 0.5"],
        ),
        // By the distance, half of (3, -4, 0), and not by a coordinate.
        (
            Edit::new(&curve).ask(position(4.5).by([3.0, 0.0, 0.0])).ask(position(4.5).by([0.0, 4.0, 0.0])),
            0,
            &["by 2.5", "by 2.5"],
        ),
        (
            Edit::new(&curve).ask(position(4.5).by([0.0, 1.0, 0.0])).ask(position(4.5).by([0.0, 1.0, 0.0])),
            1,
            &[],
        ),
        (Edit::new(&curve).lock([0]).ask(position(a).keep()).ask(position(4.5).by([0.0, 1.0, 0.0])), 1, &[]),
    ];
    for (number, (edit, redundant, missed)) in cases.into_iter().enumerate() {
        let solved = edit.best_effort().solve().unwrap();
        let report = solved.report();
        assert_eq!(report.redundant.len(), redundant, "{number}: {report}");
        assert_eq!(report.best_effort, !missed.is_empty(), "{number}: {report}");
        let told = report.missed();
        assert_eq!(told.len(), missed.len(), "{number}: {told:?}");
        assert!(told.iter().zip(missed).all(|(told, words)| told.contains(words)), "{number}: {told:?}");
        // A place is missed by a length.
        let lengths = report.missed_in(Unit::Millimetre);
        assert_eq!(lengths, told.iter().map(|told| format!("{told} mm")).collect::<Vec<_>>(), "{number}");
    }
}

#[test]
fn what_nothing_moves_is_answered_with_what_was_given() {
    let curve = twelve();
    let outside = |edit: Edit<Curve>| {
        let edit = edit.ask(position(4.5).by([0.0, 0.1, 0.0])).ask(position(0.5).by([0.0, 0.1, 0.0]));
        edit.solve().unwrap_err().to_string()
    };
    let within = outside(Edit::new(&curve).within(2.0, 8.0));
    assert!(within.contains("widen within = [2, 8]") && !within.contains("lock"), "{within}");
    let local = outside(Edit::new(&curve).locality(2));
    assert!(local.contains("widen the locality") && !local.contains("unlock"), "{local}");
    let locked = outside(Edit::new(&curve).lock([0, 1, 2, 3]));
    assert!(locked.contains("unlock one") && !locked.contains("locality"), "{locked}");
}

#[test]
fn redundant_rows_of_smoothness_make_up_the_rank_that_is_missing() {
    // An exact circle in nine vertices.
    let w = 0.5_f64.sqrt();
    let net = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
    let net = net.map(|[x, y]| Point::new(f64::from(x), f64::from(y), 0.0)).to_vec();
    let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    let weights = (0..9).map(|k| if k % 2 == 0 { 1.0 } else { w }).collect();
    let circle = Curve::rational(Space::open(2, knots).unwrap(), net, weights).unwrap();
    for u in [0.5, 1.25, 3.75] {
        // Both ends are held, so that the seam need not be kept closed beside that.
        let held = Edit::new(&circle).ask(position(0.0).keep()).ask(position(4.0).keep());
        let solved = held.ask(position(u).by([0.3, 0.3, 0.0])).solve().unwrap();
        let report = solved.report();
        assert!(report.rank < report.equations, "{report}");
        assert_eq!(report.rank + report.smooth.redundant, report.equations, "{report}");
        let (equations, redundant) = (report.smooth.equations, report.smooth.redundant);
        let said = match redundant {
            1 => "1 of which follows from the others".to_owned(),
            all if all == equations => "all of which follow from the others".to_owned(),
            some => format!("{some} of which follow from the others"),
        };
        assert!(report.to_string().contains(&said), "{said}: {report}");
    }
}

#[test]
fn a_few_of_many_redundant_constraints_are_named() {
    let curve = twelve();
    let ask = |count: usize| {
        let all = (0..count).map(|_| position(4.5).by([0.0, 1.0, 0.0]));
        all.fold(Edit::new(&curve), Edit::ask).solve().unwrap().report().clone()
    };
    let text = ask(4).to_string();
    assert!(
        text.ends_with(
            "3 constraints that the others imply: position at 4.5, position at 4.5, position at 4.5"
        ),
        "{text}"
    );
    let report = ask(300);
    let text = report.to_string();
    assert_eq!(report.redundant.len(), 299);
    assert!(text.ends_with("position at 4.5 and 294 more") && text.len() < 300, "{text}");
}

/// What a best effort makes of equations that contradict one another is their least squares, whether a bound elsewhere is touched or not, and in whatever order they are asked.
#[test]
fn a_bound_that_is_touched_changes_nothing_of_a_best_effort() {
    let curve = twelve();
    let z = |by: f64| position(1.3).axis(Axis::Z).at_least(by);
    let ask = |edit: Edit<Curve>, by: f64| edit.ask(position(4.5).axis(Axis::Y).by(by));
    let start = curve.point(4.5).unwrap().y;
    for bounds in [vec![], vec![-1.0], vec![3.0], vec![3.0, 0.5], vec![0.25, 2.0]] {
        for wishes in [[0.4, 0.0], [0.0, 0.4], [0.1, 0.7]] {
            let edit = wishes.into_iter().fold(Edit::new(&curve), ask);
            let edit = bounds.iter().fold(edit, |edit, by| edit.ask(z(*by)));
            let edit = edit.ask(position(8.0).axis(Axis::X).at_most(100.0));
            let solved = edit.best_effort().solve().unwrap();
            let (case, report) = (format!("{bounds:?} {wishes:?}"), solved.report());
            let mean = 0.5 * (wishes[0] + wishes[1]);
            let found = solved.shape().point(4.5).unwrap().y - start;
            assert!((found - mean).abs() < 1e-12, "{case}: {found}");
            let high = bounds.iter().copied().fold(0.0, f64::max);
            assert!((solved.shape().point(1.3).unwrap().z - high).abs() < 1e-12, "{case}");
            assert!(report.best_effort && report.missed().len() == 2, "{case}: {report}");
            let half = 0.5 * (wishes[1] - wishes[0]).abs();
            for missed in &report.constraints[..2] {
                assert!((missed.residual - half).abs() < 1e-12, "{case}: {}", missed.residual);
            }
        }
    }
}

/// Bounds are not given way where equations can be; where they contradict one another, they are by least squares.
#[test]
fn bounds_that_contradict_one_another_are_given_way_by_a_best_effort() {
    let curve = twelve();
    let start = curve.point(4.5).unwrap().z;
    let z = || position(4.5).axis(Axis::Z);
    let cases = [
        (vec![z().at_least(3.0), z().at_most(1.0)], 2.0, 2),
        (vec![z().at_most(1.0), z().at_least(3.0), z().at_least(2.0)], 2.0, 2),
        (vec![z().at_least(3.0), z().keep()], 3.0, 1),
        (vec![z().keep(), z().at_least(3.0), z().at_most(1.0)], 2.0, 3),
    ];
    for (number, (all, high, missed)) in cases.into_iter().enumerate() {
        let solved = all.into_iter().fold(Edit::new(&curve).best_effort(), Edit::ask).solve().unwrap();
        let report = solved.report();
        let found = solved.shape().point(4.5).unwrap().z - start;
        assert!((found - high).abs() < 1e-9, "{number}: {found}: {report}");
        assert!(report.best_effort && report.missed().len() == missed, "{number}: {report}");
    }
}
