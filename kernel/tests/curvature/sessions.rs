//! The same in sessions, where things asked come and go.

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{curvature, derivative, magnitude, orthogonal, position, tangent};
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::book::{Random, Spline, turned};

fn wave() -> Curve {
    let mut random = Random::new(5);
    let points = (0..14)
        .map(|i| Point::from(Vector::new(i as f64, (i as f64).sin(), 0.3) + random.vector() * 0.4))
        .collect();
    Spline { degree: 4, periodic: false, knots: (0..19).map(f64::from).collect(), points, weights: None }
        .curve()
}

const U: f64 = 8.3;

fn check(before: &Curve, after: &Curve, factor: f64) {
    let (old, new) = (Spline::of(before).turn(U), Spline::of(after).turn(U));
    let wanted = turned(old.vector, old.tangent, new.tangent) * factor;
    assert!(
        (new.vector - wanted).norm() < 1e-9 * old.kappa,
        "{:e} of {}",
        (new.vector - wanted).norm(),
        old.kappa
    );
}

#[test]
fn a_dragged_derivative_keeps_the_curvature_at_every_event() {
    let before = wave();
    let first = Spline::of(&before).turn(U).first;
    let mut session =
        Edit::new(&before).ask(curvature(U).keep()).handle(derivative(U, 1)).prepare(Automatic).unwrap();
    for k in 1..=20 {
        let t = 0.1 * f64::from(k);
        let to = first * (1.0 + t) + Vector::new(0.0, t.sin(), t) * first.norm();
        let after = session.to(to).unwrap().clone();
        check(&before, &after, 1.0);
        assert!((Spline::of(&after).turn(U).first - to).norm() < 1e-10);
    }
    check(&before, session.commit().unwrap().shape(), 1.0);
}

#[test]
fn a_derivative_that_is_let_go_no_longer_makes_curvature_linear() {
    let before = wave();
    let mut session = Edit::new(&before)
        .ask(curvature(U).scale(1.5))
        .ask(position(7.0).by([0.0, 0.5, 0.2]))
        .prepare(Automatic)
        .unwrap();
    session.apply().unwrap();
    let kept = session.add(derivative(U, 1).keep()).unwrap();
    session.apply().unwrap();
    check(&before, session.shape(), 1.5);
    // Both the companion and this one said so; when only the latter goes, the former remains.
    session.remove(kept).unwrap();
    session.apply().unwrap();
    check(&before, session.shape(), 1.5);

    let mut session = Edit::new(&before).ask(position(U).keep()).prepare(Automatic).unwrap();
    let first = session.add(derivative(U, 1).keep()).unwrap();
    session.add(curvature(U).keep()).unwrap();
    session.remove(first).unwrap();
    session.add(magnitude(U).scale(2.0)).unwrap();
    session.add(position(7.0).by([0.0, 0.5, 0.2])).unwrap();
    session.apply().unwrap();
    check(&before, session.shape(), 1.0);
}

#[test]
fn a_curvature_added_beside_a_derivative_that_changes_is_a_true_one() {
    let before = wave();
    let mut session = Edit::new(&before).ask(derivative(U, 1).scale(0.5)).prepare(Automatic).unwrap();
    session.add(curvature(U).keep()).unwrap();
    session.apply().unwrap();
    check(&before, session.shape(), 1.0);
}

#[test]
fn what_is_asked_of_the_tangent_decides_what_stands_still() {
    let before = wave();
    let old = Spline::of(&before).turn(U);
    let to = Vector::new(0.3, 1.0, 0.2);
    let edits = [
        Edit::new(&before).ask(orthogonal(U, to).hold()).ask(curvature(U).keep()),
        Edit::new(&before).ask(tangent(U).direction(old.tangent + to * 0.3).keep()).ask(curvature(U).keep()),
        Edit::new(&before)
            .ask(derivative(U, 1).axis(loftsman_kernel::edit::Axis::Y).by(0.4))
            .ask(curvature(U).keep()),
    ];
    for edit in edits {
        let after = edit.solve().unwrap();
        check(&before, after.shape(), 1.0);
        let moved = Spline::of(after.shape()).jet(U)[0] - Spline::of(&before).jet(U)[0];
        assert!(moved.norm() < 1e-11, "the position stands still");
        assert!((Spline::of(after.shape()).turn(U).tangent - old.tangent).norm() > 1e-3);
    }
    // Nothing of the tangent asked: linear, with one solve, and all of the first derivative stands still.
    let plain = Edit::new(&before).ask(curvature(U).scale(3.0)).solve().unwrap();
    assert_eq!(plain.report().iterations, 1);
    let after = Spline::of(plain.shape()).turn(U);
    assert!((after.first - old.first).norm() < 1e-12 && (after.kappa - 3.0 * old.kappa).abs() < 1e-11);
}
