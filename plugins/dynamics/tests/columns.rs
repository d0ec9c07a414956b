//! Straight ropes that are pushed together bend out, wherever their knots are.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Setup, fixed};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

#[test]
fn a_straight_rope_that_bends_leaves_its_balance_wherever_its_knots_are() {
    let mut bending = 0;
    for (degree, inner) in
        [(5, vec![0.3, 0.4]), (5, vec![0.3, 0.45]), (7, vec![0.3]), (4, vec![0.3, 0.4]), (6, vec![0.3, 0.4])]
    {
        let breaks: Vec<f64> = [0.0].into_iter().chain(inner.clone()).chain([1.0]).collect();
        let space = Space::clamped(degree, &breaks).unwrap();
        let n = space.len();
        let points = (0..n).map(|i| Point::new(3.0 * i as f64 / (n - 1) as f64, 0.0, 0.0));
        let rope = Curve::new(space, points.collect()).unwrap();
        let body = Body::new(&rope).stiffness(600.0).bending(0.5).rest(1.1).damping(0.5);
        let mut simulation = Setup::new(body).hold(fixed(0.0)).hold(fixed(1.0)).prepare().unwrap();
        let settled = simulation.settle().unwrap();
        let energy = simulation.energy().total();
        let bent = settled.stable == Some(true) && energy < 0.15;
        // Where it stays straight, since no way leads on to rest, it says what that is worth.
        let told = bent || settled.stable == Some(false);
        assert!(settled.rests && told, "{degree} {inner:?}: {settled:?} {energy}");
        bending += usize::from(bent);
    }
    assert!(bending >= 5, "{bending}");
}
