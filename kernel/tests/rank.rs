//! Edits whose constraints depend on one another: what agrees is met, what contradicts is refused and named, with every solver.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use crate::smooth::solvers;
use loftsman_kernel::edit::{Ask, Constraint, Edit, EditError, Metric};
use loftsman_kernel::functional::{linear, position, vertex};
use loftsman_kernel::solve::{Automatic, SolveError, Solver};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn cubic() -> Curve {
    let space = Space::clamped(3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 2.0, 0.0],
        [2.0, -1.0, 1.0],
        [3.0, 2.0, 0.0],
        [4.0, 0.0, -1.0],
        [5.0, 2.0, 0.0],
        [6.0, 0.0, 0.0],
        [7.0, 1.0, 0.0],
    ];
    Curve::new(space, points.into_iter().map(Point::from).collect()).unwrap()
}

fn up() -> Vector {
    Vector::y()
}

fn solve(curve: &Curve, constraints: &[Constraint], solver: Arc<dyn Solver>) -> Result<Curve, EditError> {
    let edit = constraints.iter().fold(Edit::new(curve), |edit, c| edit.ask(c.clone()));
    edit.solve_with(solver).map(|edited| {
        let residual = edited.report().residual;
        assert!(
            residual <= 1e-13 * curve.points().iter().map(|p| p.coords.amax()).fold(1.0, f64::max),
            "{residual}"
        );
        edited.into_shape()
    })
}

/// Whether the solver is for fewer equations, or for better conditions, and says so.
fn names_a_better_one(error: &EditError) -> bool {
    matches!(error, EditError::Solve(SolveError::TooLarge { .. } | SolveError::IllConditioned { .. }))
}

#[test]
fn what_kept_vertices_contradict_is_refused() {
    let curve = cubic();
    for solver in solvers() {
        let name = solver.name().to_owned();
        let mut asked: Vec<Constraint> = (0..4).map(|i| vertex(i).keep()).collect();
        asked.push(position(0.0015).by(up()));
        let error = solve(&curve, &asked, Arc::clone(&solver)).unwrap_err();
        assert!(error.to_string().contains("cannot all hold"), "{name}: {error}");

        let space = Space::clamped(7, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let points = (0..12).map(|i| Point::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
        let seventh = Curve::new(space, points).unwrap();
        let mut asked: Vec<Constraint> = (0..12).map(|i| vertex(i).keep()).collect();
        asked.push(position(0.3).by(up()));
        let error = solve(&seventh, &asked, solver).unwrap_err();
        assert!(
            error.to_string().contains("cannot all hold") || names_a_better_one(&error),
            "{name}: {error}"
        );
    }
}

#[test]
fn what_a_translation_meets_is_met() {
    let curve = cubic();
    let (first, second) = (Vector::x(), Vector::x());
    let many: Vec<Constraint> =
        (0..400).map(|k| position(5.0 * f64::from(k) / 400.0 * (599.0 / 600.0)).by(up())).collect();
    let kept_and_near: Vec<Constraint> =
        (0..4).map(|i| vertex(i).by(up())).chain([position(0.0015).by(up())]).collect();
    let sums = vec![
        linear([(0, first)]).to(1.0),
        linear([(1, second)]).to(1000.0),
        linear([(0, first), (1, second * 5e-10)]).to(1.000_000_5),
    ];
    for solver in solvers() {
        for (asked, name) in [(&many, "400 positions"), (&kept_and_near, "an end"), (&sums, "sums")] {
            match solve(&curve, asked, Arc::clone(&solver)) {
                Ok(_) => {}
                Err(error) => {
                    assert!(
                        solver.name() == "adjoint" && names_a_better_one(&error),
                        "{name}, {}: {error}",
                        solver.name()
                    );
                }
            }
        }
    }
}

#[test]
fn clusters_of_positions_are_met_or_refused() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("golden/nearly_dependent.json")).unwrap();
    let numbers = |v: &Value| v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    let vectors =
        |v: &Value| v.as_array().unwrap().iter().map(|x| Vector::from_vec(numbers(x))).collect::<Vec<_>>();
    assert_eq!(cases.len(), 24);
    for case in &cases {
        let degree = case["degree"].as_u64().unwrap() as usize;
        let space = Space::periodic(degree, numbers(&case["knots"])).unwrap();
        let points = vectors(&case["points"]).into_iter().map(Point::from).collect();
        let weights = case["weights"].is_array().then(|| numbers(&case["weights"]));
        let curve = Curve::build(space, points, weights).unwrap();
        let asked: Vec<Constraint> = numbers(&case["at"])
            .into_iter()
            .zip(vectors(&case["by"]))
            .map(|(u, by)| position(u).by(by))
            .collect();
        for solver in solvers() {
            let name = solver.name().to_owned();
            if let Err(error) = solve(&curve, &asked, solver) {
                assert!(
                    names_a_better_one(&error)
                        && ["adjoint", "sparse", "saddle-point"].contains(&name.as_str()),
                    "{name}: {error}"
                );
            }
        }
    }
}

#[test]
fn near_conflicts_are_met_to_rounding_or_refused() {
    let curve = cubic();
    let mut solved = 0;
    for power in 1..=14 {
        let apart = 10_f64.powi(-power);
        for solver in solvers() {
            let asked = [position(2.3).keep(), position(2.3 + apart).by(up())];
            let edit = asked.into_iter().fold(Edit::new(&curve), Edit::ask);
            if let Ok(edited) = edit.solve_with(solver) {
                // The answer is as large as one over the distance: so is what rounding leaves.
                let report = edited.report();
                assert!(report.residual <= 1e-14 * report.adjustment.max(1.0), "{apart}: {report}");
                solved += 1;
            }
        }
    }
    assert!(solved >= 3 * 5, "{solved}");
}

#[test]
fn a_drag_beyond_what_is_nearly_implied_looks_closer() {
    let curve = cubic();
    let mut drag =
        Edit::new(&curve).ask(position(2.3 + 1e-11).keep()).handle(position(2.3)).prepare(Automatic).unwrap();
    let start = curve.point(2.3).unwrap();
    // Within rounding of standing still.
    drag.to_point(start).unwrap();
    assert!(drag.report().rank == 3);
    let reached = drag.to_point(start + up() * 1e-9).map(|shape| shape.point(2.3).unwrap());
    match reached {
        Ok(reached) => {
            assert!((reached - start - up() * 1e-9).norm() <= 1e-13);
            assert!(drag.report().rank == 6 && drag.report().residual <= 1e-13);
            drag.to_point(start).unwrap();
            assert!((drag.shape().point(2.3).unwrap() - start).norm() <= 1e-13);
        }
        // Named as a near conflict.
        Err(error) => {
            assert!(error.to_string().contains("position at 2.3"), "{error}");
            assert_eq!(drag.shape(), &curve);
        }
    }
}

/// The names in quotes of a message.
fn quoted(message: &str) -> Vec<String> {
    message.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn conflicts_are_named_with_none_that_can_be_spared() {
    let mut state = 5_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut named = 0;
    for round in 0..120 {
        let degree = 1 + round % 4;
        let n = degree + 6;
        let space = if round % 3 == 2 {
            Space::periodic_uniform(degree, n).unwrap()
        } else {
            Space::clamped_uniform(degree, n).unwrap()
        };
        let points = (0..n).map(|i| Point::new(i as f64, next(), next())).collect();
        let curve = Curve::new(space, points).unwrap();
        let (low, high) = curve.domain();
        let span = (high - low) / curve.space().breakpoints().len().saturating_sub(1).max(1) as f64;
        let mut within = |k: usize| low + span * (k as f64 + 0.3 + 0.4 * next());
        let mut asked: Vec<Constraint> = match round % 3 {
            // More positions in one span than it has vertices.
            0 => (0..=degree + 1).map(|_| position(within(2)).keep()).collect(),
            // Every vertex and some positions.
            _ => (0..n)
                .map(|i| vertex(i as i64).keep())
                .chain((0..3).map(|k| position(within(k)).keep()))
                .collect(),
        };
        // Those that have nothing to do with it.
        asked.extend([position(within(0)).keep(), position(within(3)).keep()]);
        asked.push(position(within(2)).by(up()));
        let metric = [Metric::Least, Metric::Bend, Metric::Falloff(3.0)][round / 3 % 3].clone();
        for solver in solvers() {
            let run = |asked: &[Constraint]| {
                let edit = asked
                    .iter()
                    .fold(Edit::new(&curve).metric(metric.clone()), |edit, c| edit.ask(c.clone()));
                edit.solve_with(Arc::clone(&solver))
            };
            let error = match run(&asked) {
                Err(error)
                    if names_a_better_one(&error)
                        && ["adjoint", "sparse", "saddle-point"].contains(&solver.name()) =>
                {
                    continue;
                }
                Err(error) => error.to_string(),
                Ok(edited) => panic!("{round}, {}: {}", solver.name(), edited.report()),
            };
            assert!(error.contains("cannot all hold") || error.contains("contradicts itself"), "{error}");
            let names = quoted(&error);
            let part: Vec<Constraint> =
                asked.iter().filter(|c| names.contains(&c.describe())).cloned().collect();
            assert!(part.len() == names.len() && names.len() > 1, "{error}");
            assert!(run(&part).is_err(), "{round}, {}: {error}", solver.name());
            for name in &names {
                let others: Vec<Constraint> =
                    part.iter().filter(|c| c.describe() != *name).cloned().collect();
                match run(&others) {
                    // What is left can all hold, if only out of all proportion.
                    Ok(_) | Err(EditError::Solve(SolveError::NearConflict { .. })) => {}
                    Err(error) if names_a_better_one(&error) && solver.name() == "saddle-point" => {}
                    Err(still) => {
                        panic!("{round}, {}: {name} can be spared: {error}; {still}", solver.name());
                    }
                }
            }
            named += 1;
        }
    }
    // Bending makes a few too ill-conditioned for `sparse`.
    assert!(named >= 120 * 4 - 5, "{named}");
}
