//! Without input energy does not grow, but by what is stated of the scheme.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Audit, Body, Material, Scheme, Setup, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Curves of all degrees, open and closed, taut and slack, with rings and without, by all schemes; undamped, for half a second each.
#[test]
fn energy_does_not_grow_without_input() {
    let (mut motions, mut rises) = (0, [Vec::new(), Vec::new(), Vec::new()]);
    for degree in [1, 2, 3, 5] {
        for closed in [false, true] {
            for rings in [0, 2] {
                for (stiffness, bending) in [(5.0, 0.0), (100.0, if degree > 1 { 0.5 } else { 0.0 })] {
                    for (index, scheme) in
                        [Scheme::Epsilon, Scheme::Exact, Scheme::Implicit].into_iter().enumerate()
                    {
                        let n = degree + 4;
                        let space = if closed {
                            Space::periodic_uniform(degree, n)
                        } else {
                            Space::clamped_uniform(degree, n)
                        };
                        let at = |i: usize| {
                            let turn = std::f64::consts::TAU * i as f64 / n as f64;
                            if closed {
                                Point::new(turn.cos(), turn.sin(), 0.1 * (2.0 * turn).sin())
                            } else {
                                Point::new(turn, 0.3 * turn.sin(), 0.0)
                            }
                        };
                        let curve = Curve::new(space.unwrap(), (0..n).map(at).collect()).unwrap();
                        let (a, b) = curve.space().domain();
                        let material = Material { mass: 0.3, stiffness, bending, ..Material::default() };
                        let mut setup = Setup::new(Body::new(&curve).material(material))
                            .gravity(GRAVITY)
                            .scheme(scheme)
                            .hold(fixed(a + 0.07 * (b - a)));
                        for ring in 0..rings {
                            setup = setup.hold(sliding(a + (0.35 + 0.3 * ring as f64) * (b - a)));
                        }
                        let mut simulation = setup.prepare().unwrap();
                        let what = format!(
                            "degree {degree}, closed: {closed}, {rings} rings, {stiffness}, {scheme:?}"
                        );
                        assert!(!simulation.is_fed(), "{what}");
                        let mut audit = Audit::default();
                        audit.look(&mut simulation);
                        for _ in 0..12 {
                            simulation.advance(1.0 / 24.0).unwrap_or_else(|error| panic!("{what}: {error}"));
                            audit.look(&mut simulation);
                        }
                        assert!(audit.most() > 0.01, "{what}: it moves");
                        let bound = if scheme == Scheme::Implicit { 1e-6 } else { 1.0 / 3.0 };
                        assert!(audit.rise() <= bound, "{what}: {audit:?}");
                        rises[index].push(audit.rise());
                        motions += 1;
                    }
                }
            }
        }
    }
    assert!(motions >= 90, "{motions}");
    for (all, bound) in rises.iter_mut().zip([0.01, 0.01, 1e-9]) {
        all.sort_by(f64::total_cmp);
        assert!(all[all.len() / 2] <= bound, "{all:?}");
    }
}
