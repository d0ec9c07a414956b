//! What rests and moves is stretched as its steps take it for: nothing hides between the points at which energy is summed up.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

/// Bézier chains, kept smooth by their vertices or with corners, and curves of few spans; shaken.
fn ropes() -> Vec<(String, Curve)> {
    let mut all = Vec::new();
    for degree in 2..=7 {
        for spans in [1, 2, 4] {
            for chain in [false, true] {
                let knots = |at: usize| vec![at as f64; if chain { degree } else { 1 }];
                let inner = (1..spans).flat_map(knots);
                let ends = |at: f64| std::iter::repeat_n(at, degree + 1);
                let space = Space::open(degree, ends(0.0).chain(inner).chain(ends(spans as f64)).collect());
                let space = space.unwrap();
                let n = space.len();
                let shaken = |k: usize| (k as f64 * 1.7 + degree as f64).sin() * 0.05;
                let at = |i: usize| 2.0 * space.greville(i) / spans as f64;
                let point = |i: usize| Point::new(at(i), shaken(i), shaken(3 * i + 1) - 0.3 * at(i));
                let points = (0..n).map(point).collect();
                all.push((
                    format!("degree {degree}, {spans} spans, chain {chain}"),
                    Curve::new(space, points).unwrap(),
                ));
            }
        }
    }
    all
}

fn setup(rope: &Curve) -> Setup {
    let body = Body::new(rope).mass(1.0).stiffness(100.0).rest(0.7).damping(3.0);
    Setup::new(body).hold(fixed(0.0)).keep_seams()
}

fn whole(simulation: &mut Simulation) -> f64 {
    simulation.energy().total() + simulation.unseen_energy().unwrap()
}

/// Held at one end and shorter by nature, without weight: it rests where it is stretched nowhere, whatever its degree and knots.
#[test]
fn what_is_free_rests_as_long_as_it_is_by_nature() {
    for (what, rope) in ropes() {
        let mut simulation = setup(&rope).prepare().unwrap();
        let settled = simulation.settle().unwrap();
        let stretch = simulation.largest_stretch(0).unwrap();
        assert!(settled.rests && stretch.abs() < 0.01, "{what}: {stretch} {settled:?}");
        let (seen, more) = (simulation.energy().elastic, simulation.unseen_energy().unwrap());
        assert!(seen + more < 1e-4, "{what}: {seen} and {more}");
    }
}

/// The same in motion, which the air ends: what there is of energy at the end, folds within spans counted, is no thousandth of what there was at the start.
#[test]
fn what_comes_to_rest_in_motion_hides_no_folds() {
    for (what, rope) in ropes() {
        for scheme in [Scheme::Epsilon, Scheme::Implicit] {
            let mut simulation = setup(&rope).scheme(scheme).step(1.0 / 48.0).prepare().unwrap();
            let before = whole(&mut simulation);
            (0..96).for_each(|_| simulation.advance(1.0 / 24.0).unwrap());
            let after = whole(&mut simulation);
            let slow = 5e-3 * before;
            assert!(after < slow, "{what}, {scheme:?}: {before} at the start, {after} at the end");
            let (seen, more) = (simulation.energy().elastic, simulation.unseen_energy().unwrap());
            assert!(more.abs() < 0.2 * seen + 1e-4 * before, "{what}, {scheme:?}: {seen} and {more}");
        }
    }
}
