//! What is said of it: reports, conflicts, distances, notes; shapes that have nothing to keep; long chains.

use loftsman_fairing::{Fair, bend, near, variation};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis};
use loftsman_kernel::functional::{derivative, position, vertex};
use loftsman_kernel::spline::{Curve, Space};

use super::Dice;
use super::evaluator::{angle, joints, on_curve};

/// Two cubic pieces that are smooth at 1, unequally long, flat at the joint.
fn wave() -> Curve {
    let at = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [5.0, 1.0], [6.0, 0.0], [7.0, 0.0]];
    let space = Space::open(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0]).unwrap();
    Curve::new(space, at.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect()).unwrap()
}

#[test]
fn a_report_keeps_apart_what_was_asked() {
    let ends = || Fair::new(&wave()).energy(bend()).ask(position(0.0).keep()).ask(position(3.0).keep());
    let fair = ends().ask(position(1.0).by([0.0, 0.5, 0.0])).solve().unwrap();
    let report = fair.report();
    assert_eq!((report.constraints.len(), report.equations, report.rank), (3, 12, 12));
    assert_eq!((report.smooth.knots, report.smooth.equations), (1, 3));
    assert!(report.to_string().contains("kept smooth at 1 knot (3 equations)"), "{report}");
    // It cannot break there, so it is not told that it might.
    assert!(report.notes.is_empty() && report.redundant.is_empty(), "{report}");
    let torn = ends().ask(position(1.0).by([0.0, 0.5, 0.0])).smooth(0).solve().unwrap();
    let report = torn.report();
    assert_eq!((report.smooth.knots, report.smooth.corners.len(), report.equations), (0, 1, 9));
    assert!(report.notes.iter().any(|n| n.starts_with("a corner of ")), "{report}");
    assert!(report.notes.iter().any(|n| n.contains("a corner costs no energy")), "{report}");
    // A jump of the curvature is another matter.
    let curved = |level: u8| Fair::new(&wave()).energy(variation()).smooth(level).solve().unwrap();
    assert!(curved(1).report().notes.iter().any(|n| n.contains("jump of curvature costs no energy")));
}

#[test]
fn conflicts_name_the_knot_and_what_lets_go() {
    let refused = |fair: &dyn Fn() -> Fair<Curve>| {
        let text = fair().solve().unwrap_err().to_string();
        assert!(text.contains("\"smooth knot at 1\"") && text.contains("smooth = 0"), "{text}");
        fair().smooth(0).solve().unwrap();
    };
    let wave = || Fair::new(&wave()).energy(bend());
    refused(&|| wave().lock([2, 3]).ask(derivative(1.0, 1).to([0.0, 3.0, 0.0])));
    // A bound that the lock and the knot forbid.
    refused(&|| wave().lock([2, 3]).ask(vertex(4).axis(Axis::Y).at_least(2.0)));
    // A distance within which only a corner could meet what is asked.
    let up = |k: i64, by: f64| vertex(k).axis(Axis::Y).by(by);
    let far = || wave().within(0.3).ask(up(4, 0.28)).ask(up(2, -0.28));
    assert!(far().solve().is_ok());
    refused(&|| far().ask(up(3, 0.2)));
    refused(&|| {
        wave().within(0.3).ask(up(4, 0.29)).ask(vertex(2).axis(Axis::Y).at_most(0.75)).ask(up(3, 0.1))
    });
}

#[test]
fn what_locked_vertices_decide_contradicts_nothing() {
    let wave = wave();
    for locks in [vec![2, 3, 4], vec![0, 1, 2, 3, 4], (0..7).collect::<Vec<i64>>()] {
        let count = locks.len();
        let fair = Fair::new(&wave).energy(bend()).lock(locks).ask(position(1.0).keep());
        let fair = fair.ask(position(1.0).axis(Axis::Y).at_least(0.5)).within(2.0).solve().unwrap();
        let report = fair.report();
        assert_eq!(report.smooth.knots, 0, "{count}: {report}");
        assert!(report.smooth.corners.is_empty() && report.residual < 1e-14, "{count}: {report}");
    }
    // Kept points that imply what is kept: nothing is told to be redundant but what was asked twice.
    let fair = Fair::new(&wave).energy(bend());
    let fair = [2, 3, 4].iter().fold(fair, |fair, &k| fair.ask(vertex(k).keep())).solve().unwrap();
    assert!(fair.report().redundant.is_empty() && fair.report().rank < fair.report().equations);
}

#[test]
fn shapes_without_such_knots_answer_what_they_did() {
    let points: Vec<Point> = (0..14).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.3)).collect();
    let knots = [vec![0.0; 4], vec![1.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 5.0, 6.0, 6.0], vec![7.0; 4]].concat();
    let spaces = [
        Space::clamped_uniform(3, 14).unwrap(),
        Space::floating_uniform(4, 14).unwrap(),
        Space::periodic_uniform(2, 14).unwrap(),
        Space::open(3, knots).unwrap(),
    ];
    for space in spaces {
        let curve = Curve::new(space, points.clone()).unwrap();
        let (a, b) = curve.domain();
        for within in [None, Some(0.8)] {
            let solve = |level: u8| {
                let fair = Fair::new(&curve).energy(bend() + near()).smooth(level);
                let fair = within.into_iter().fold(fair, Fair::within);
                let fair = fair.ask(position(0.5 * (a + b)).by([0.1, 0.2, 0.0]));
                fair.ask(position(0.3 * a + 0.7 * b).axis(Axis::Y).at_least(1.0)).solve().unwrap()
            };
            let (default, let_go) = (solve(1), solve(0));
            assert_eq!(default.shape().points(), let_go.shape().points());
            assert_eq!(default.report(), let_go.report());
            assert!(default.report().smooth.is_empty());
        }
    }
}

/// The smooth ellipse that got corners of 13°, 36° and 13°.
#[test]
fn an_ellipse_within_a_distance_keeps_its_tangents() {
    let (k, a) = (0.552_284_749_8, 2.0 * 0.552_284_749_8);
    let points = [
        [2.0, 0.0],
        [2.0, k],
        [a, 1.0],
        [0.0, 1.0],
        [-a, 1.0],
        [-2.0, k],
        [-2.0, 0.0],
        [-2.0, -k],
        [-a, -1.0],
        [0.0, -1.0],
        [a, -1.0],
        [2.0, -k],
        [2.0, 0.0],
    ];
    let points = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let knots = [vec![0.0; 4], vec![1.0; 3], vec![2.0; 3], vec![3.0; 3], vec![4.0; 4]].concat();
    let ellipse = Curve::new(Space::open(3, knots).unwrap(), points).unwrap();
    let corners = |curve: &Curve| -> Vec<f64> {
        let each = joints(curve.space(), 3, true).into_iter();
        each.map(|[l, r]| angle(on_curve(curve, l)[1], on_curve(curve, r)[1])).collect()
    };
    for level in [1, 2] {
        let fair = Fair::new(&ellipse).energy(variation()).within(0.1).smooth(level).solve().unwrap();
        let report = fair.report();
        assert!(corners(fair.shape()).iter().all(|c| *c < 1e-9), "{level}: {:?}", corners(fair.shape()));
        assert!(report.farthest <= 0.1 && report.energy_after < 0.9 * report.energy_before, "{report}");
        assert!((fair.shape().point(0.0).unwrap() - fair.shape().point(4.0).unwrap()).norm() < 1e-13);
        if level == 2 {
            for [l, r] in joints(ellipse.space(), 3, true) {
                let bent = |at| {
                    let [_, d, e] = on_curve(fair.shape(), at);
                    d.cross(&e) / d.norm().powi(3)
                };
                assert!((bent(l) - bent(r)).norm() < 1e-9);
            }
        }
    }
    let torn = Fair::new(&ellipse).energy(variation()).within(0.1).smooth(0).solve().unwrap();
    assert!(corners(torn.shape()).iter().any(|c| c.to_degrees() > 10.0));
    assert!(torn.report().smooth.corners.len() >= 3, "{}", torn.report());
}

/// Bézier chains as long as people have them, with more knots than there can be told motions.
#[test]
fn long_chains_come_to_an_end() {
    let mut dice = Dice(0x10c6_c4a1);
    for (pieces, energy) in [(60, bend()), (200, variation()), (300, bend()), (600, variation())] {
        let n = pieces + 3;
        let space = Space::clamped_uniform(3, n).unwrap();
        let at = |i: usize| Point::new(i as f64, dice.between(-0.5, 0.5), 0.0);
        let smooth = Curve::new(space, (0..n).map(at).collect()).unwrap();
        let knots = (1..pieces).flat_map(|k| [k as f64; 2]).collect::<Vec<f64>>();
        let chain = smooth.insert_knots(&knots).unwrap();
        let end = pieces as f64;
        let fair = Fair::new(&chain).energy(energy.clone()).ask(position(0.0).keep());
        let fair = fair.ask(position(0.5 * end).by([0.0, 1.0, 0.0])).ask(position(end).keep());
        let fair = fair.solve().unwrap();
        let report = fair.report();
        assert_eq!(report.smooth.knots, pieces - 1);
        for [l, r] in joints(chain.space(), 3, false) {
            let (l, r) = (on_curve(fair.shape(), l)[1], on_curve(fair.shape(), r)[1]);
            assert!(angle(l, r) < 1e-8 && (l - r).norm() < 1e-9 * (1.0 + l.norm()), "{energy}: {report}");
        }
        assert!(report.energy_after < 0.2 * report.energy_before, "{energy}: {report}");
    }
}
