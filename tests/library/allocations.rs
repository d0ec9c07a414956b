//! What is promised about cost: an event allocates nothing and does not depend on the size of the curve.

use allocation_counter::measure;
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit, Session};
use loftsman_kernel::functional::{curvature, position, tangent};
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, Solver, Sparse};
use loftsman_kernel::spline::{Curve, Space};

fn coil(vertices: usize) -> Curve {
    let at = |i: usize| {
        let (sin, cos) = (0.3 * i as f64).sin_cos();
        Point::new(cos, sin, 0.1 * i as f64)
    };
    Curve::new(Space::clamped_uniform(3, vertices).unwrap(), (0..vertices).map(at).collect()).unwrap()
}

fn session(vertices: usize, solver: impl Solver + 'static) -> Session<Curve> {
    let edit = Edit::of(coil(vertices)).ask(position(1.5).keep()).ask(position(7.25).by([0.0, 0.0, 0.1]));
    edit.handle(position(4.5)).prepare(solver).unwrap()
}

#[test]
fn an_event_allocates_nothing() {
    fn check(name: &str, mut session: Session<Curve>) {
        session.to_point(Point::new(1.0, 2.0, 3.0)).unwrap();
        let counted = measure(|| {
            for i in 0..100 {
                session.to_point(Point::new(1.0, 2.0, 3.0 + 0.01 * f64::from(i))).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{name}: {counted:?}");
        let at = session.shape().point(4.5).unwrap();
        assert!((at - Point::new(1.0, 2.0, 3.99)).amax() < 1e-12, "and it is where it was dragged: {at}");
    }
    check("adjoint", session(1000, Adjoint));
    check("sparse", session(1000, Sparse));
    check("householder-qr", session(1000, HouseholderQr));
    check("lu", session(1000, DenseLu));
    check("automatic", session(1000, Automatic));
}

#[test]
fn an_event_with_coupled_constraints_allocates_nothing() {
    let edit = Edit::of(coil(100)).ask(tangent(2.5).keep()).ask(curvature(6.5).keep());
    let mut session = edit.handle(position(4.5)).prepare(Automatic).unwrap();
    let counted = measure(|| {
        for i in 0..100 {
            session.to_point(Point::new(1.0, 2.0, 3.0 + 0.01 * f64::from(i))).unwrap();
        }
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

#[test]
fn preparing_does_not_depend_on_the_size_of_the_curve() {
    // Allocated bytes stand for work here: the same on every machine, and any pass over all vertices would show.
    let bytes = |vertices| {
        let curve = coil(vertices);
        let mut session = None;
        let counted = measure(|| {
            let edit = Edit::of(curve).ask(position(1.5).keep()).handle(position(4.5));
            session = Some(edit.prepare(Automatic).unwrap());
        });
        assert!(session.is_some());
        counted.bytes_total
    };
    assert_eq!(bytes(100), bytes(100_000));
}
