//! Derivatives that slide: energy does not come from them, and what loses its place says so.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Audit, Body, Scheme, Setup, fixed, sliding_curvature, sliding_tangent};
use loftsman_kernel::Point;
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::spline::{Curve, Space};

/// Ropes that hang from one end, waved as chance has it, on even and uneven knots, open and closed: somewhere near they keep a derivative that they have. Nothing else is asked, and
/// nothing is put in.
fn ropes(rounds: usize, mut each: impl FnMut(usize, &Curve, f64, f64)) {
    let mut seed = 6_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for round in 0..rounds {
        let degree = 2 + round % 6;
        let n = degree + 4 + (random() * (16 - degree) as f64) as usize;
        let space = match round % 5 {
            4 => Space::periodic_uniform(degree, n).unwrap(),
            3 => {
                let inner = (1..n - degree).map(|i| i as f64 + 0.6 * (random() - 0.5));
                let ends = |at: f64| std::iter::repeat_n(at, degree + 1);
                Space::open(degree, ends(0.0).chain(inner).chain(ends((n - degree) as f64)).collect())
                    .unwrap()
            }
            _ => Space::clamped_uniform(degree, n).unwrap(),
        };
        let closed = round % 5 == 4;
        let [a, b, c] = [2.0 + 6.0 * random(), 2.0 + 4.0 * random(), 6.0 * random()];
        let points = (0..n).map(|i| {
            let t = i as f64 / n as f64;
            let turn = std::f64::consts::TAU * t;
            if closed {
                Point::new(
                    turn.cos(),
                    0.15 * (a.floor() * turn).sin(),
                    turn.sin() + 0.1 * (b.floor() * turn + c).sin(),
                )
            } else {
                Point::new(2.0 * t, 0.15 * (a * t).sin(), 0.3 * (b * t + c).sin())
            }
        });
        let curve = Curve::new(space, points.collect()).unwrap();
        let (start, end) = curve.space().domain();
        let near = start + (0.2 + 0.6 * random()) * (end - start);
        each(round, &curve, near, 10.0_f64.powf(2.0 + 2.0 * random()));
    }
}

#[test]
fn implicit_steps_put_no_energy_in_where_a_derivative_slides() {
    let (mut motions, mut halved) = (0, 0);
    for times in [1, 2] {
        for rate in [24.0, 200.0] {
            ropes(30, |round, curve, near, stiffness| {
                if times == 2 && curve.space().degree() < 3 {
                    return;
                }
                let value = curve.value(near.into(), Derivative::from(times)).unwrap();
                let hold =
                    if times == 1 { sliding_tangent(near, value) } else { sliding_curvature(near, value) };
                let body = Body::new(curve).mass(1.0).stiffness(stiffness).damping(0.5);
                let setup = Setup::new(body).gravity([0.0, 0.0, -9.81]).scheme(Scheme::Implicit);
                let mut simulation =
                    setup.hold(fixed(curve.space().domain().0)).hold(hold).prepare().unwrap();
                let what =
                    format!("{round}: derivative {times} of degree {} at {rate}", curve.space().degree());
                assert!(!simulation.is_fed(), "{what}");
                let mut audit = Audit::default();
                audit.look(&mut simulation);
                let frames = if rate < 100.0 { 48 } else { 100 };
                for _ in 0..frames {
                    simulation.advance(1.0 / rate).unwrap_or_else(|error| panic!("{what}: {error}"));
                    audit.look(&mut simulation);
                }
                assert!(audit.most() > 0.1 && audit.rise() <= 0.01, "{what}: {audit:?}");
                halved += usize::from(simulation.sub_steps() > frames);
                motions += 1;
            });
        }
    }
    // Where nothing would rise in whole steps nothing would be shown.
    assert!(halved >= 3 && motions >= 100, "{halved} of {motions}");
}

/// With a place that has no mass nothing tells where it is as the second derivative vanishes there: it runs away along the shape. That is what the error says, and what does not lose it; nothing was
/// asked to move.
#[test]
fn a_place_that_is_lost_is_named() {
    let mut lost = 0;
    ropes(24, |round, curve, near, stiffness| {
        let value = curve.value(near.into(), Derivative::from(1)).unwrap();
        let run = |scheme: Scheme| {
            let body = Body::new(curve).mass(1.0).stiffness(stiffness).damping(0.5);
            let setup = Setup::new(body).gravity([0.0, 0.0, -9.81]).scheme(scheme);
            let hold = sliding_tangent(near, value);
            let mut simulation = setup.hold(fixed(curve.space().domain().0)).hold(hold).prepare().unwrap();
            (0..24).try_for_each(|_| simulation.advance(1.0 / 24.0)).err().map(|error| error.to_string())
        };
        let Some(error) = run(Scheme::Exact) else { return };
        let named = error.contains("\"sliding tangent near") && error.contains("runs away along its shape");
        assert!(named && error.contains("epsilon") && !error.contains("is asked moves"), "{round}: {error}");
        assert_eq!(run(Scheme::Epsilon), None, "{round}");
        lost += 1;
    });
    assert!(lost >= 2, "{lost}");
}
