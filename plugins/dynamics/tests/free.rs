//! Small ropes that nothing holds: energy is what leapfrogs have, and stays within the stated bound at the stated step.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Audit, Body, Scheme, Setup, fixed};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

/// A straight rope of two vertices, `m = k = ℓ = 1` and its own `ω² = 12 k/(r m ℓ²)`: at each step of a leapfrog its length at rest is missed by `a cos nθ`, `sin θ/2 = h ω/2`, its velocity
/// is `-a sin nθ · 2 sin(θ/2) cos(θ/2)/h`, so that its energy swings between all of it and `1 - (hω)²/4` of it.
#[test]
fn two_vertices_swing_as_a_leapfrog_does() {
    for (rest, share) in [(0.8, 1.0), (1.5, 1.0), (0.95, 0.7), (1.05, 0.3), (0.8, 0.1)] {
        for scheme in [Scheme::Exact, Scheme::Epsilon] {
            let line = Curve::new(
                Space::clamped_uniform(1, 2).unwrap(),
                vec![Point::origin(), Point::new(1.0, 0.0, 0.0)],
            );
            let body = Body::new(&line.unwrap()).mass(1.0).stiffness(1000.0).rest(rest);
            let mut simulation = Setup::new(body).scheme(scheme).prepare().unwrap();
            let omega = (12.0 * 1000.0 / rest).sqrt();
            assert!((simulation.stable_step() * omega - 1.0).abs() < 1e-9);
            let step = share / omega;
            let (a, theta) = (1.0 - rest, 2.0 * (0.5 * share).asin());
            let whole = 0.5 * 1000.0 * a * a / rest;
            for n in 0..300 {
                let turn = f64::from(n) * theta;
                let wanted = whole * (turn.cos().powi(2) + (1.0 - share * share / 4.0) * turn.sin().powi(2));
                let found = simulation.energy();
                assert!(
                    (found.total() - wanted).abs() < 1e-9 * whole,
                    "{rest} {share} {n}: {found:?} {wanted}"
                );
                simulation.step(step).unwrap();
            }
        }
    }
}

/// To look at energy changes nothing: the same numbers come whether it is looked at in each step or never.
#[test]
fn looking_changes_nothing() {
    let points = (0..9).map(|i| Point::new(f64::from(i), (1.3 * f64::from(i)).sin(), 0.0));
    let curve = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points.collect()).unwrap();
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        let run = |looks: bool| {
            let setup =
                Setup::new(Body::new(&curve).stiffness(50.0)).gravity([0.0, 0.0, -9.81]).scheme(scheme);
            let mut simulation =
                setup.hold(fixed(0.0)).hold(loftsman_dynamics::sliding(3.2)).prepare().unwrap();
            for _ in 0..12 {
                if looks {
                    simulation.energy();
                }
                simulation.advance(1.0 / 24.0).unwrap();
            }
            simulation.shape(0).unwrap().control_vertices().to_vec()
        };
        assert_eq!(run(true), run(false), "{scheme:?}");
    }
}

/// Ropes of two to five vertices and degrees 1 to 4, on even, uneven and repeated knots, closed ones, from slack (half as long as at rest) to stretched to twice that, stiff and soft: a second of default
/// steps each.
#[test]
fn small_free_ropes_stay_within_the_bound() {
    let mut seed = 20_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut worst, mut steps) = (0.0_f64, 0);
    for round in 0..600 {
        let degree = 1 + round % 4;
        let n = (degree + 1).max(2) + (random() * (5 - degree) as f64) as usize;
        let closed = round % 7 == 6;
        let space = if closed {
            Space::periodic_uniform(degree, n.max(degree + 1).max(3)).unwrap()
        } else if round % 3 == 1 {
            let mut inner: Vec<f64> = (0..n - degree - 1).map(|_| 0.05 + 0.9 * random()).collect();
            inner.sort_by(f64::total_cmp);
            Space::open(degree, [vec![0.0; degree + 1], inner, vec![1.0; degree + 1]].concat()).unwrap()
        } else {
            Space::clamped_uniform(degree, n).unwrap()
        };
        let n = space.len();
        let across = [0.0, 0.05, 0.4, 1.0][(random() * 4.0) as usize];
        let points = (0..n).map(|i| {
            let turn = std::f64::consts::TAU * i as f64 / n as f64;
            let [x, y] = if closed { [turn.cos(), turn.sin()] } else { [i as f64, 0.0] };
            Point::new(x, y + across * (random() - 0.5), across * (random() - 0.5))
        });
        let Ok(curve) = Curve::new(space, points.collect()) else { continue };
        let (rest, stiffness) = (0.5 * 4.0_f64.powf(random()), 10.0_f64.powf(1.0 + 4.0 * random()));
        let scheme = if round % 2 == 0 { Scheme::Exact } else { Scheme::Epsilon };
        let damping = if random() < 0.5 { 0.0 } else { 0.5 };
        let body = Body::new(&curve).mass(1.0).stiffness(stiffness).rest(rest).damping(damping);
        let mut simulation = Setup::new(body).scheme(scheme).prepare().unwrap();
        let what = format!(
            "{round}: degree {degree}, {n} vertices, closed: {closed}, across {across}, rest {rest}, {stiffness}, damping {damping}"
        );
        let mut audit = Audit::default();
        audit.look(&mut simulation);
        for _ in 0..24 {
            simulation.advance(1.0 / 24.0).unwrap_or_else(|error| panic!("{what}: {error}"));
            audit.look(&mut simulation);
        }
        steps += simulation.sub_steps();
        worst = worst.max(audit.rise());
        assert!(!audit.is_broken(), "{what}: {audit:?}");
    }
    assert!(worst > 0.05 && steps > 1000, "{worst} {steps}");
}
