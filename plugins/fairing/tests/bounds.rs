//! Inequalities: obstacle problems whose answers are known, and the conditions that every answer meets.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fairing::{Fair, bend, near, stretch};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::{Curve, Space};

fn flat(n: usize, degree: usize) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let points = (0..n).map(|i| Point::new(space.greville(i), 0.0, 0.0)).collect();
    Curve::new(space, points).unwrap()
}

/// A position whose y is bounded.
fn y(constraint: Constraint) -> Constraint {
    constraint.axis(Axis::Y)
}

#[test]
fn a_string_over_pegs_is_its_upper_hull() {
    // A polyline: its stretch is least where it is the least concave function above the pegs. It is straight, so that it has to
    // be allowed its corners.
    let string = flat(11, 1);
    let pegs = [(2.0, 1.0), (3.0, 2.0), (4.0, 1.5), (6.0, 2.0), (7.0, 0.5), (8.0, 1.2)];
    let fair = Fair::new(&string).energy(stretch()).smooth(0);
    let mut fair = fair.ask(position(0.0).keep()).ask(position(10.0).keep());
    for (u, height) in pegs {
        fair = fair.ask(y(position(u).at_least(height)));
    }
    let fair = fair.solve().unwrap();
    for (u, height) in
        [(0.0, 0.0), (1.5, 1.0), (3.0, 2.0), (4.5, 2.0), (6.0, 2.0), (7.0, 1.6), (8.0, 1.2), (10.0, 0.0)]
    {
        assert!((fair.shape().point(u).unwrap().y - height).abs() < 1e-12, "{u}: {}", fair.report());
    }
    assert_eq!(
        fair.report().active,
        ["y of position at 3 ≥ 2", "y of position at 6 ≥ 2", "y of position at 8 ≥ 1.2"]
    );
    // What each peg carries: twice the change of slope. d/dy of Σ Δy²/Δu.
    let carried = |name: &str| {
        let told = fair.report().constraints.iter().find(|c| c.name.starts_with(name)).unwrap();
        told.multipliers[0]
    };
    assert!(
        (carried("y of position at 3") - 2.0 * (2.0 / 3.0)).abs() < 1e-11,
        "{:?}",
        fair.report().constraints
    );
    assert!((carried("y of position at 6") - 2.0 * 0.4).abs() < 1e-11);
    assert!((carried("y of position at 8") - 2.0 * (0.6 - 0.4)).abs() < 1e-11);
    assert_eq!(carried("y of position at 2"), 0.0);
}

#[test]
fn a_curve_through_gates_meets_every_gate_and_no_gate_could_let_go() {
    let wire = flat(40, 3);
    let end = wire.domain().1;
    let gates: Vec<(f64, f64)> =
        (1..12).map(|i| (end * f64::from(i) / 12.0, 4.0 * (1.9 * f64::from(i)).sin())).collect();
    let ask = |scale: f64| {
        let mut fair = Fair::new(&wire).energy(bend()).ask(position(0.0).keep()).ask(position(end).keep());
        for &(u, middle) in &gates {
            fair = fair
                .ask(y(position(u).at_least(scale * (middle - 0.8))))
                .ask(y(position(u).at_most(scale * (middle + 0.8))));
        }
        fair.solve().unwrap()
    };
    let fair = ask(1.0);
    let report = fair.report();
    assert!(report.residual < 1e-11 && report.active.len() >= 5, "{report}");
    for &(u, middle) in &gates {
        assert!((fair.shape().point(u).unwrap().y - middle).abs() < 0.8 + 1e-11);
    }
    // Multipliers of both kinds of bound push the right way.
    for told in &report.constraints[2..] {
        let sign = if told.name.contains('≥') { 1.0 } else { -1.0 };
        assert!(sign * told.multipliers[0] >= 0.0, "{told:?}");
    }
    // Through the middle of every gate it costs more; without any one that it touches it would go through that gate's post,
    // for less; and a gate that it does not touch carries nothing.
    let mut hit = Fair::new(&wire).energy(bend()).ask(position(0.0).keep()).ask(position(end).keep());
    for &(u, middle) in &gates {
        hit = hit.ask(y(position(u).to(middle)));
    }
    let least = report.energy_after;
    assert!(least < hit.solve().unwrap().report().energy_after);
    for told in &report.constraints[2..] {
        assert_eq!(told.multipliers[0] != 0.0, report.active.contains(&told.name), "{told:?}");
    }
    for (k, &(u, middle)) in gates.iter().enumerate() {
        let side = fair.shape().point(u).unwrap().y - middle;
        let mut rest = Fair::new(&wire).energy(bend()).ask(position(0.0).keep()).ask(position(end).keep());
        for (_, &(u, middle)) in gates.iter().enumerate().filter(|(other, _)| *other != k) {
            rest = rest.ask(y(position(u).at_least(middle - 0.8))).ask(y(position(u).at_most(middle + 0.8)));
        }
        let rest = rest.solve().unwrap();
        let passed = rest.shape().point(u).unwrap().y - middle;
        if side.abs() < 0.8 - 1e-9 {
            assert!((rest.report().energy_after / least - 1.0).abs() < 1e-9, "gate {k}: {}", rest.report());
        } else {
            let lower = rest.report().energy_after < least * (1.0 - 1e-9);
            assert!(lower && passed * side > 0.0 && passed.abs() > 0.8, "gate {k}: {}", rest.report());
        }
    }
    // The same at other scales: energies go with the square.
    for scale in [1e-6, 1e6] {
        let other = ask(scale);
        assert!(
            (other.report().energy_after / (scale * scale) / report.energy_after - 1.0).abs() < 1e-10,
            "{scale:e}: {}",
            other.report()
        );
        let size = 10.0_f64.max(4.0 * scale);
        for (a, b) in other.shape().points().iter().zip(fair.shape().points()) {
            assert!(
                (a.y - scale * b.y).abs() < 1e-11 * size && (a.x - b.x).abs() < 1e-11 * size,
                "{scale:e}"
            );
        }
    }
}

#[test]
fn bounds_that_hold_anyway_change_nothing_and_impossible_ones_are_refused() {
    let wire = flat(14, 3);
    let plain = Fair::new(&wire).energy(bend() + near()).ask(position(4.0).to([4.0, 1.0, 0.0]));
    let plain = plain.solve().unwrap();
    let loose = Fair::new(&wire)
        .energy(bend() + near())
        .ask(position(4.0).to([4.0, 1.0, 0.0]))
        .ask(position(6.0).at_most([100.0, 100.0, 100.0]))
        .solve()
        .unwrap();
    assert_eq!(plain.shape(), loose.shape());
    assert!(loose.report().active.is_empty());
    // The same a hair above where the shape passes; a hair below, the bound is met, and carries something.
    let passes = plain.shape().point(6.0).unwrap().y;
    let at_most = |bound: f64| {
        let fair = Fair::new(&wire).energy(bend() + near()).ask(position(4.0).to([4.0, 1.0, 0.0]));
        fair.ask(y(position(6.0).at_most(bound))).solve().unwrap()
    };
    let above = at_most(passes + 1e-9);
    assert!(above.shape() == plain.shape() && above.report().active.is_empty(), "{}", above.report());
    let below = at_most(passes - 1e-3);
    assert!((below.shape().point(6.0).unwrap().y - passes + 1e-3).abs() < 1e-13, "{}", below.report());
    assert_eq!(below.report().active.len(), 1);
    assert!(below.report().energy_after > plain.report().energy_after, "{}", below.report());
    let apart = Fair::new(&wire)
        .energy(bend())
        .ask(position(4.0).to([4.0, 1.0, 0.0]))
        .ask(y(position(4.0).at_least(2.0)))
        .solve();
    let text = apart.unwrap_err().to_string();
    assert!(text.contains("position at 4") && text.contains("cannot all hold"), "{text}");
    let both = Fair::new(&wire).energy(bend()).within(1.0).ask(y(position(4.0).at_least(2.0)));
    let text = both.solve().unwrap_err().to_string();
    assert!(text.contains("none may move further than 1"), "{text}");
    let odd = Fair::new(&wire).energy(bend()).ask(position(4.0).at_least(vec![1.0, 2.0]));
    assert!(odd.solve().is_err());
}

/// A distance that is small beside the size is kept as well as coordinates can tell.
#[test]
fn a_distance_of_a_few_roundings_is_kept() {
    for size in [1e-6, 1.0, 1e6] {
        let point = |i: u32| size * Point::new(f64::from(i), (2.3 * f64::from(i)).sin(), 0.0);
        let wild = Curve::new(Space::clamped_uniform(3, 20).unwrap(), (0..20).map(point).collect()).unwrap();
        for share in [1e-7, 1e-8, 1e-9, 1e-10, 1e-11] {
            let within = share * size;
            let faired = Fair::new(&wild).energy(bend()).within(within).solve().unwrap();
            let far = wild.points().iter().zip(faired.shape().points()).map(|(a, b)| (a - b).norm());
            let far = far.fold(0.0, f64::max);
            assert!(far <= within + 4.0 * f64::EPSILON * 20.0 * size, "{size} {share}: {far}");
            assert!(far >= 0.9 * within, "{size} {share}: {far}");
        }
    }
}

/// Bounds and a distance at once: both hold, and no other shape that keeps to both has noticeably less energy.
#[test]
fn within_a_distance_and_between_bounds() {
    let points = (0..20).map(|i| Point::new(f64::from(i), (2.3 * f64::from(i)).sin(), 0.0)).collect();
    let wild = Curve::new(Space::clamped_uniform(3, 20).unwrap(), points).unwrap();
    let end = wild.domain().1;
    let ask = |distance: f64, gates: bool| {
        let mut fair = Fair::new(&wild).energy(bend()).ask(position(0.0).keep()).within(distance);
        if gates {
            fair = fair.ask(y(position(4.25).at_least(0.3))).ask(y(position(0.6 * end).at_most(-0.25)));
        }
        fair.solve().unwrap()
    };
    for distance in [0.9, 1.0, 1.3, 2.0, 50.0] {
        let (plain, both) = (ask(distance, false), ask(distance, true));
        let report = both.report();
        let far =
            wild.points().iter().zip(both.shape().points()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(far <= distance && report.farthest <= distance, "{distance}: {far}, {report}");
        assert!(both.shape().point(4.25).unwrap().y >= 0.3 - 1e-12, "{distance}: {report}");
        assert!(both.shape().point(0.6 * end).unwrap().y <= -0.25 + 1e-12, "{distance}: {report}");
        assert!(report.gap <= 1.1e-3 && report.residual < 1e-12, "{distance}: {report}");
        assert_eq!(report.active.len(), 2, "{distance}: {report}");
        assert!(report.energy_after > plain.report().energy_after * 0.999, "{distance}: {report}");
        assert!(report.energy_after < 0.5 * report.energy_before, "{distance}: {report}");
        // The energy on the way to other shapes that keep to both: none is lower by more than the gap.
        let kept = |shape: &Curve| {
            let near = wild.points().iter().zip(shape.points()).all(|(a, b)| (a - b).norm() <= distance);
            let (low, high) = (shape.point(4.25).unwrap().y, shape.point(0.6 * end).unwrap().y);
            near && low >= 0.3 - 1e-13 && high <= -0.25 + 1e-13
        };
        let energy = |shape: &Curve| {
            Fair::new(shape).energy(bend()).lock(0..20).solve().unwrap().report().energy_before
        };
        let mut tried = 0;
        for k in 0..304_usize {
            // One vertex after another, up and down.
            let push = |i: usize| match i == k % 19 + 1 {
                true => [1.0, -1.0][k / 19 % 2],
                false => 0.0,
            };
            let size = [1e-1, 1e-2, 1e-3, 1e-4][k / 38 % 4];
            let moved = both
                .shape()
                .points()
                .iter()
                .enumerate()
                .map(|(i, p)| Point::new(p.x, if i == 0 { p.y } else { p.y + size * push(i) }, p.z));
            let other = Curve::new(wild.space().clone(), moved.collect()).unwrap();
            if kept(&other) {
                tried += 1;
                assert!(
                    energy(&other) >= report.energy_after * (1.0 - 1.2e-3),
                    "{distance}: {}",
                    energy(&other)
                );
            }
        }
        assert!(tried > 10, "{distance}: {tried}");
    }
    // Farther may be fairer.
    let energies: Vec<f64> = [0.9, 1.3, 50.0].map(|d| ask(d, true).report().energy_after).to_vec();
    assert!(energies.windows(2).all(|w| w[1] <= w[0] * 1.002), "{energies:?}");
}
