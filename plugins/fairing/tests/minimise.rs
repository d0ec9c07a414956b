//! Energies made least by edits, against fairing, which does it by other means.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use crate::dice::Dice;
use loftsman_fairing::{Datum, EnergySum, Fair, bend, data, near, stretch, variation};
use loftsman_kernel::edit::{Ask, Axis, Edit, Measured, Metric};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::{Automatic, DenseLu, HouseholderQr, SaddlePoint, SolveError, Solver, Sparse};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Sparse),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
    ]
}

fn wavy(dice: &mut Dice, round: usize) -> Curve {
    let p = 3 + round % 3;
    let n = p + 6 + dice.below(10);
    let space = match round % 3 {
        0 => Space::clamped_uniform(p, n).unwrap(),
        1 => Space::floating_uniform(p, n).unwrap(),
        _ => Space::periodic(p, (0..=n).map(|k| k as f64).collect()).unwrap(),
    };
    let points = (0..space.len())
        .map(|k| Point::new(k as f64, (1.3 * k as f64).sin(), 0.2 * (k % 4) as f64))
        .collect();
    if round % 4 == 3 {
        let weights = (0..space.len()).map(|_| dice.between(0.5, 2.0)).collect();
        return Curve::rational(space, points, weights).unwrap();
    }
    Curve::new(space, points).unwrap()
}

/// One that sees every motion.
fn energy(curve: &Curve, round: usize) -> EnergySum {
    let (start, end) = curve.domain();
    let toward = data((0..5).map(|k| Datum {
        at: Location::Curve(start + (end - start) * (0.1 + 0.17 * f64::from(k))),
        to: Point::new(f64::from(k), 1.0, 0.5),
        weight: 0.3,
    }));
    match round % 4 {
        0 => bend() + 0.1 * near(),
        1 => stretch() + 0.5 * near(),
        2 => variation() + 0.2 * near() + toward,
        _ => 2.0 * bend() + 0.1 * stretch() + 0.05 * near(),
    }
}

fn at(curve: &Curve, share: f64) -> f64 {
    let (start, end) = curve.domain();
    start + share * (end - start)
}

fn far(a: &impl Shape, b: &impl Shape) -> f64 {
    let pairs = a.control_vertices().iter().zip(b.control_vertices());
    pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).norm()))
}

#[test]
fn an_edit_that_makes_an_energy_least_is_fairing_with_every_solver() {
    let mut dice = Dice(7);
    let mut solved = 0;
    for round in 0..48 {
        let curve = wavy(&mut dice, round);
        let energy = energy(&curve, round);
        let (u, v) = (at(&curve, 0.33), at(&curve, 0.7));
        let way = Vector::new(0.2, 0.5, -0.3);
        let fair = Fair::new(&curve)
            .smooth(0)
            .energy(energy.clone())
            .ask(position(u).by(way))
            .ask(derivative(v, 1).keep())
            .lock([0])
            .solve()
            .unwrap();
        for solver in solvers() {
            let edited = Edit::new(&curve)
                .smooth(0)
                .minimise(energy.clone())
                .ask(position(u).by(way))
                .ask(derivative(v, 1).keep())
                .lock([0])
                .solve_with(Arc::clone(&solver));
            let edited = match edited {
                Ok(edited) => edited,
                Err(loftsman_kernel::edit::EditError::Solve(SolveError::IllConditioned { .. })) => continue,
                Err(error) => panic!("round {round}, {}: {error}", solver.name()),
            };
            solved += 1;
            assert!(
                far(edited.shape(), fair.shape()) < 1e-6,
                "round {round}, {}: {}",
                solver.name(),
                far(edited.shape(), fair.shape())
            );
            assert!((edited.shape().point(u).unwrap() - curve.point(u).unwrap() - way).norm() < 1e-12);
            assert_eq!(edited.shape().control_vertices()[0], curve.control_vertices()[0], "to the last bit");
            assert_eq!(edited.undo().control_vertices(), curve.control_vertices(), "the way back");
        }
    }
    assert!(solved > 220, "{solved} of 240");
}

#[test]
fn bounds_and_drags_do_the_same() {
    let mut dice = Dice(7);
    for round in 0..24 {
        let curve = wavy(&mut dice, round);
        let energy = energy(&curve, round);
        let (u, v) = (at(&curve, 0.4), at(&curve, 0.75));
        let here = curve.point(u).unwrap();
        let bound = here.y + 0.4;
        let fair = Fair::new(&curve)
            .smooth(0)
            .energy(energy.clone())
            .ask(position(u).axis(Axis::Y).at_least(bound))
            .ask(position(v).keep())
            .solve()
            .unwrap();
        let edited = Edit::new(&curve)
            .smooth(0)
            .minimise(energy.clone())
            .ask(position(u).axis(Axis::Y).at_least(bound))
            .ask(position(v).keep())
            .solve()
            .unwrap();
        assert!(
            far(edited.shape(), fair.shape()) < 1e-6,
            "round {round}: {}",
            far(edited.shape(), fair.shape())
        );

        let mut drag = Edit::new(&curve)
            .smooth(0)
            .minimise(energy.clone())
            .ask(position(v).keep())
            .handle(position(u))
            .prepare(Automatic)
            .unwrap();
        for k in 0..3 {
            let to = here + Vector::new(0.1, 0.3, -0.2) * f64::from(k);
            let fair = Fair::new(&curve)
                .smooth(0)
                .energy(energy.clone())
                .ask(position(u).to(to))
                .ask(position(v).keep());
            let fair = fair.solve().unwrap();
            let dragged = drag.to_point(to).unwrap();
            assert!(
                far(dragged, fair.shape()) < 1e-6,
                "round {round}, event {k}: {}",
                far(dragged, fair.shape())
            );
        }
        // Back at the start, and on from there.
        drag.undo().unwrap();
        let to = here + Vector::new(-0.2, 0.1, 0.0);
        let fair = Fair::new(&curve).smooth(0).energy(energy).ask(position(u).to(to)).ask(position(v).keep());
        assert!(
            far(drag.to_point(to).unwrap(), fair.solve().unwrap().shape()) < 1e-6,
            "round {round}, after undo"
        );
    }
}

#[test]
fn surfaces_and_adjustments_measured_by_an_energy() {
    let space = || Space::clamped_uniform(3, 8).unwrap();
    let net = (0..64).map(|k| Point::new((k / 8) as f64, (k % 8) as f64, (1.7 * k as f64).sin())).collect();
    let surface = Surface::new(space(), space(), net).unwrap();
    let energy = || bend() + 0.01 * near();
    let at = (1.3, 2.2);
    let fair = Fair::new(&surface).energy(energy()).ask(position(at).by([0.0, 0.0, 1.0])).solve().unwrap();
    let edited =
        Edit::new(&surface).minimise(energy()).ask(position(at).by([0.0, 0.0, 1.0])).solve().unwrap();
    assert!(far(edited.shape(), fair.shape()) < 1e-6, "{}", far(edited.shape(), fair.shape()));
    // As a metric it leaves alone what nothing asks for: a keep changes nothing.
    let metric = || Metric::Energy(Measured(Arc::new(energy())));
    let kept = Edit::new(&surface).metric(metric()).ask(position(at).keep()).solve().unwrap();
    assert_eq!(far(kept.shape(), &surface), 0.0);
    // Measured by an energy that has `|d|²` and `|d''|²` as the metric "bend" has them, adjustments are the same.
    let curve = Curve::new(space(), (0..8).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect()).unwrap();
    let length = curve.domain().1 - curve.domain().0;
    let as_bend = near() + length.powi(4) * bend();
    let own = Edit::new(&curve)
        .metric(Metric::Energy(Measured(Arc::new(as_bend))))
        .ask(position(2.0).by([0.0, 1.0, 0.0]));
    let bent = Edit::new(&curve).metric(Metric::Bend).ask(position(2.0).by([0.0, 1.0, 0.0]));
    let apart = far(own.solve().unwrap().shape(), bent.solve().unwrap().shape());
    assert!(apart < 1e-9, "{apart:.1e}");
}

#[test]
fn what_does_not_see_every_motion_is_refused_and_says_what_to_add() {
    let curve = wavy(&mut Dice(7), 0);
    let error = Edit::new(&curve).minimise(bend()).ask(position(1.0).keep()).solve().map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("near"), "{error}");
    let flat =
        Curve::new(Space::clamped_uniform(1, 4).unwrap(), curve.control_vertices()[..4].to_vec()).unwrap();
    let error =
        Edit::new(&flat).minimise(bend() + near()).ask(position(0.5).keep()).solve().map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("degree"), "{error}");
}
