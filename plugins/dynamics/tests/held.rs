//! What rests must be held: in every direction in which something draws it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, DynamicsError, Scheme, Setup, Spot, fixed, force, holds, pull, sliding, tied};
use loftsman_kernel::Point;
use loftsman_kernel::Vector;
use loftsman_kernel::functional::derivative;
use loftsman_kernel::spline::{Curve, Space, Surface};
use std::sync::Arc;

use crate::common::line;

fn sheet(n: usize) -> Surface {
    let space = Space::clamped_uniform(2, n).unwrap();
    let points = (0..n * n).map(|k| Point::new((k / n) as f64, (k % n) as f64, 0.0)).collect();
    Surface::new(space.clone(), space, points).unwrap()
}

const DOWN: [f64; 3] = [0.0, 0.0, -9.81];

#[track_caller]
fn falls(setup: Setup, body: &str, way: [f64; 3]) {
    match setup.prepare().unwrap().settle() {
        Err(DynamicsError::Unheld { body: found, way: along, let_go }) => {
            assert_eq!(found, body);
            assert!(let_go.is_empty(), "{let_go:?}");
            assert!((along - Vector::from(way).normalize()).norm() < 1e-6, "{along} for {way:?}");
        }
        other => panic!("{other:?}"),
    }
}

/// What only an axis holds goes on for ever along the others, if something draws it there; the error names the direction.
#[test]
fn what_nothing_holds_does_not_settle() {
    for degree in [1, 2, 3, 5] {
        let rope = line(degree, degree + 6, [0.0; 3], [3.0, 0.0, 0.0]);
        let end = rope.space().domain().1;
        let body = || Body::new(&rope).mass(0.3).stiffness(50.0).called("rope");
        let down = || Setup::new(body()).gravity(DOWN);
        falls(down(), "rope", DOWN);
        falls(down().hold(fixed(0.0).axes([true, false, false])), "rope", DOWN);
        falls(
            down().hold(fixed(0.0).axes([true, true, false])).hold(sliding(1.0).axes([false, true, false])),
            "rope",
            DOWN,
        );
        // A tangent alone holds it nowhere; a force aside of what its nail leaves free does.
        falls(down().hold(holds(Arc::new(derivative(0.0, 1)))), "rope", DOWN);
        let aside = Setup::new(body()).hold(fixed(0.0).axes([false, true, true]));
        falls(aside.push(force(end, [2.0, 1.0, 0.0])), "rope", [1.0, 0.0, 0.0]);
        // What is tied to what falls, falls; the direction that is held is taken out.
        let other = line(3, 5, [0.0, 1.0, 0.0], [3.0, 1.0, 0.0]);
        let two = Setup::new(body())
            .and(Body::new(&other).mass(10.0).stiffness(50.0).called("other"))
            .gravity([3.0, 0.0, -4.0])
            .hold(fixed(0.0).axes([true, false, false]))
            .hold(tied(Spot::at(0, end), Spot::near(1, 0.5)));
        falls(two, "rope", [0.0, 0.0, -1.0]);
    }
    falls(
        Setup::new(Body::new(&sheet(5)).called("sheet"))
            .gravity(DOWN)
            .hold(fixed([0.0, 0.0]).axes([true, true, false])),
        "sheet",
        DOWN,
    );
}

/// What is held where something draws it rests, though it may go elsewhere, and turn.
#[test]
fn what_is_held_where_it_is_drawn_settles() {
    let rope = line(3, 9, [0.0; 3], [3.0, 0.0, 0.0]);
    let end = rope.space().domain().1;
    let body = || Body::new(&rope).mass(0.3).stiffness(50.0).bending(0.01);
    let down = || Setup::new(body()).gravity(DOWN);
    for setup in [
        down().hold(fixed(0.0)),
        down().hold(fixed(0.0).axes([false, false, true])),
        down().hold(fixed(0.0).axes([false, false, true])).hold(fixed(end).axes([false, false, true])),
        down().pull(pull(0.5 * end, [1.5, 0.0, 0.0], 10.0)),
        Setup::new(body()),
        Setup::new(body()).hold(fixed(0.0)).push(force(end, [1.0, 0.5, 0.0])),
    ] {
        let settled = setup.prepare().unwrap().settle().unwrap();
        assert!(settled.rests, "{settled:?}");
    }
}

/// A rope on a slope that its one ring lets go on the way: said, with the ring that did.
#[test]
fn what_lets_go_on_the_way_does_not_settle() {
    let rope = line(3, 9, [0.0; 3], [0.2, 0.0, -3.0]);
    let mut simulation = Setup::new(Body::new(&rope).mass(0.3).stiffness(50.0).called("rope"))
        .gravity(DOWN)
        .hold(sliding(1.0).called("ring"))
        .prepare()
        .unwrap();
    match simulation.settle() {
        Err(DynamicsError::Unheld { body, way, let_go }) => {
            assert_eq!((body.as_str(), way), ("rope", -Vector::z()));
            assert_eq!(let_go, ["\"ring\": it left the shape"]);
        }
        other => panic!("{other:?}"),
    }
    for scheme in [Scheme::Exact, Scheme::Implicit] {
        let mut simulation = Setup::new(Body::new(&rope).mass(0.3).stiffness(50.0))
            .gravity(DOWN)
            .hold(sliding(1.0))
            .scheme(scheme)
            .prepare()
            .unwrap();
        assert_eq!(simulation.unheld().unwrap(), None);
        for _ in 0..48 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        assert_eq!(simulation.unheld().unwrap(), Some((0, -Vector::z())), "{scheme:?}");
    }
}

/// What lets go on the way to rest, and holds where it ends, is not told to have let go.
#[test]
fn what_holds_at_rest_has_not_let_go() {
    let space = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let points = [0.0, 1.0, 3.0, 4.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
    let rope = Curve::new(space, points).unwrap();
    let (mut held, mut gone) = (0, 0);
    for i in 0..60 {
        let near = 0.3 + 0.8 * f64::from(i % 12) / 12.0;
        let to = [1.0 + 0.2 * f64::from(i / 12), 0.3, 0.3];
        let mut simulation = Setup::new(Body::new(&rope).mass(1.0).stiffness(100.0))
            .gravity([0.0, 0.0, -1.0])
            .hold(fixed(0.2))
            .hold(sliding(near).to(to).called("ring"))
            .hold(fixed(1.2))
            .prepare()
            .unwrap();
        let Ok(settled) = simulation.settle() else { continue };
        let told = simulation.events().iter().any(|event| event.constraint == 1 && event.let_go);
        let holds = simulation.holds(1).unwrap();
        assert_eq!(told, !holds, "{near} {to:?}: {settled:?} {:?}", simulation.events());
        *(if holds { &mut held } else { &mut gone }) += 1;
    }
    assert!(held + gone >= 55 && held >= 20, "{held} hold, {gone} let go");
}
