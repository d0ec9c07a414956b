//! It is a solver, and an edit can use it.

use loftsman_example_solver::Textbook;
use loftsman_kernel::Point;
use loftsman_kernel::conformance::solver_conformance;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::spline::{Curve, Space};

#[test]
fn it_conforms() {
    let verdict = solver_conformance(&Textbook);
    assert!(verdict.passed(), "{verdict}");
}

#[test]
fn an_edit_agrees_with_the_default() {
    let points = (0..9).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points).unwrap();
    let edit = || Edit::new(&curve).ask(position(2.4).by([0.0, 1.0, 0.0])).ask(derivative(2.4, 1).keep());
    let (ours, own) = (edit().solve().unwrap(), edit().solve_with(Textbook).unwrap());
    assert_eq!(own.report().solver, "textbook");
    for (a, b) in ours.shape().points().iter().zip(own.shape().points()) {
        assert!((a - b).norm() < 1e-13);
    }
}
