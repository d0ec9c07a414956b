//! The solver passes the kernel's suite, and finds what the kernel's own finds.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_interior_point::InteriorPoint;
use loftsman_kernel::Point;
use loftsman_kernel::conformance::solver_conformance;
use loftsman_kernel::edit::{Ask, Axis, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::plugin::Registry;
use loftsman_kernel::solve::{
    Automatic, Outcome, Program, Sense, Solver, SparseRows, Symmetric, System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};

#[test]
fn it_is_a_solver() {
    let mut registry = Registry::new();
    registry.add(&InteriorPoint);
    let solver = registry.find_solver("clarabel", "test").unwrap();
    let verdict = solver_conformance(solver.as_ref());
    assert!(verdict.passed() && verdict.checks > 500, "{verdict}");
}

/// Coordinates that bend least, each within bounds of its own, at several sizes.
#[test]
fn hundreds_of_active_bounds_are_the_same_ones() {
    for (n, scale) in [(200, 1e-9), (200, 1.0), (200, 1e9), (800, 1.0)] {
        let band =
            |i: usize| [(0, 6.1), (1, -4.0), (2, 1.0)].map(|(k, v)| i.checked_sub(k).map(|j| (i, j, v)));
        let matrix = Symmetric::from_entries(n, (0..n).flat_map(band).flatten());
        let (mut rows, mut senses, mut rhs) = (SparseRows::new(n), Vec::new(), Vec::new());
        for i in 0..n {
            let wave = 0.3 * (0.7 * i as f64).sin();
            for (sense, b) in [(Sense::AtLeast, wave - 0.25), (Sense::AtMost, wave + 0.05)] {
                rows.push([(i, 1.0)]);
                senses.push(sense);
                rhs.push(b * scale);
            }
        }
        let size: Vec<f64> = rhs.iter().map(|b| b.abs()).collect();
        let system = System::new(rows, (0..n).collect(), 1, SystemMetric::Matrix(Arc::new(matrix)));
        let program = Program { system: &system, rhs: &rhs, senses: &senses, size: &size };
        let (own, library) = (Automatic.program(&program).unwrap(), InteriorPoint.program(&program).unwrap());
        let (Outcome::Active { rows: own, .. }, Outcome::Active { rows: library, steps }) = (own, library)
        else {
            panic!("there is a solution")
        };
        assert!(own.len() > n / 5 && own == library, "{n}, {scale:e}: {} and {}", own.len(), library.len());
        assert!(steps <= 3, "what was read off took {steps} guesses to put right");
    }
}

#[test]
fn an_edit_says_what_is_active_and_what_contradicts() {
    let space = Space::clamped_uniform(3, 12).unwrap();
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.9 * f64::from(i)).sin(), 0.0)).collect();
    let before = Curve::new(space, points).unwrap();
    let above = |solver: Arc<dyn Solver>| {
        let mut edit = Edit::new(&before).ask(position(0.0).keep());
        for k in 0..=36 {
            edit = edit.ask(position(0.25 * f64::from(k)).axis(Axis::Y).at_least(-0.3));
        }
        edit.solve_with(solver).unwrap()
    };
    let (own, library) = (above(Arc::new(Automatic)), above(Arc::new(InteriorPoint)));
    assert_eq!(own.report().active, library.report().active);
    assert!(!own.report().active.is_empty());
    for (a, b) in own.shape().points().iter().zip(library.shape().points()) {
        assert!((a - b).amax() < 1e-13);
    }
    let told = library.report().constraints.iter().filter(|c| c.multipliers.iter().any(|m| *m > 0.0)).count();
    assert!(told >= library.report().active.len(), "{:?}", library.report().constraints);
    let message = Edit::new(&before)
        .ask(position(8.0).keep())
        .ask(position(4.0).axis(Axis::Y).at_least(2.0))
        .ask(position(4.0).axis(Axis::Y).at_most(1.0))
        .ask(position(1.0).axis(Axis::Y).at_most(5.0))
        .solve_with(Arc::new(InteriorPoint) as Arc<dyn Solver>)
        .unwrap_err()
        .to_string();
    assert!(message.contains("at 4 ≥ 2") && message.contains("at 4 ≤ 1"), "{message}");
    assert!(!message.contains("at 8") && !message.contains("at 1 "), "{message}");
}
