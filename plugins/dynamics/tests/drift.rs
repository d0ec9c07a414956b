//! Constraints hold while things move: also where the steps that are stable are long.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Frame by frame, and at each step between, no constraint misses more than 1e-6 of the size.
fn holds(mut simulation: Simulation, size: f64, what: &str) -> usize {
    let first = simulation.shape(0).unwrap().control_vertices().to_vec();
    for frame in 0..24 {
        simulation.advance(1.0 / 24.0).unwrap();
        let errors = simulation.errors().unwrap();
        let most = errors.iter().fold(0.0_f64, |most, e| most.max(*e));
        // Three coordinates together, where each is within a millionth.
        assert!(most <= 3.0_f64.sqrt() * 1e-6 * size, "{what}, frame {frame}: {most:e} of {size}");
        let worst = simulation.worst_error();
        assert!(worst <= 1e-6 * size, "{what}, frame {frame}: {worst:e} of {size}");
    }
    // It moves, and something slides.
    let now = simulation.shape(0).unwrap().control_vertices();
    let moved = first.iter().zip(now).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(moved > 1e-2 * size, "{what}: {moved} of {size}");
    assert!(simulation.slides(2).unwrap() && simulation.holds(2).unwrap(), "{what}");
    simulation.sub_steps()
}

/// A large closed curve, soft enough that a frame is one stable step.
#[test]
fn long_steps_keep_what_is_held() {
    let knots = vec![0.0, 1.0463, 2.5455, 3.9587, 5.4419, 6.9008, 7.8734];
    let points = [
        [96.15, 1.11, -23.90],
        [50.62, 82.51, 20.11],
        [-38.40, 84.40, 22.10],
        [-95.90, 3.84, 32.65],
        [-42.43, -89.57, -3.31],
        [48.38, -81.17, 17.75],
    ];
    let curve = Curve::new(Space::periodic(2, knots).unwrap(), points.map(Point::from).to_vec()).unwrap();
    for scheme in [Scheme::Exact, Scheme::Epsilon] {
        let body = Body::new(&curve).mass(0.126).stiffness(1609.0).bending(4492.0).viscosity(1.56);
        let simulation = Setup::new(body)
            .gravity(GRAVITY)
            .hold(fixed(2.984))
            .hold(fixed(6.124))
            .hold(sliding(0.855).axes([false, false, true]))
            .scheme(scheme)
            .prepare()
            .unwrap();
        assert!(simulation.stable_step() > 1.0 / 24.0);
        let steps = holds(simulation, 192.05, &format!("{scheme:?}"));
        assert!(steps < 24 * 40, "{scheme:?}: {steps} steps");
    }
}

/// Open and closed curves, soft and stiff.
#[test]
fn curves_of_many_degrees_keep_what_is_held() {
    for degree in 3..=5 {
        for closed in [false, true] {
            for (stiffness, scheme) in [(2.0, Scheme::Exact), (2.0, Scheme::Epsilon), (60.0, Scheme::Exact)] {
                let n = degree + 5;
                let space = if closed {
                    Space::periodic_uniform(degree, n)
                } else {
                    Space::clamped_uniform(degree, n)
                }
                .unwrap();
                let at = |i: usize| {
                    let turn = std::f64::consts::TAU * i as f64 / n as f64;
                    if closed {
                        Point::new(turn.cos(), turn.sin(), 0.1 * (2.0 * turn).sin())
                    } else {
                        Point::new(turn, turn.sin(), 0.0)
                    }
                };
                let curve = Curve::new(space, (0..n).map(at).collect()).unwrap();
                let (a, b) = curve.space().domain();
                let place = |share: f64| a + share * (b - a);
                let simulation =
                    Setup::new(Body::new(&curve).mass(0.3).stiffness(stiffness).bending(0.01 * stiffness))
                        .gravity(GRAVITY)
                        .hold(fixed(place(0.1)))
                        .hold(fixed(place(0.8)))
                        .hold(sliding(place(0.45)).axes([true, false, true]))
                        .scheme(scheme)
                        .prepare()
                        .unwrap();
                let x = || curve.points().iter().map(|p| p.x);
                let size = x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min);
                holds(
                    simulation,
                    size,
                    &format!("degree {degree}, closed: {closed}, {stiffness} {scheme:?}"),
                );
            }
        }
    }
}

/// Ropes that slide through two rings and hang on a nail, of every degree from 2 on (of degree 1 they slide over corners), closed ones, ones of uneven knots and
/// quotients, soft, tiny and huge: no constraint misses more than 1e-6 of the size in any step.
#[test]
fn all_ropes_keep_what_holds_them() {
    let mut all = 0;
    for degree in [2, 3, 4, 5, 7] {
        for kind in ["closed", "uneven", "quotient"] {
            for (stiffness, size, scheme) in [
                (5.0, 1.0, Scheme::Exact),
                (5.0, 1.0, Scheme::Epsilon),
                (20.0, 1e-9, Scheme::Exact),
                (20.0, 1e9, Scheme::Epsilon),
                // So soft that a frame is far shorter than what is stable.
                (1e-2, 1.0, Scheme::Exact),
            ] {
                let space = match kind {
                    "closed" => Space::periodic_uniform(degree, degree + 6),
                    "uneven" => Space::clamped(degree, &[0.0, 0.1, 0.35, 0.4, 0.7, 0.9, 1.0]),
                    _ => Space::clamped_uniform(degree, degree + 6),
                }
                .unwrap();
                let n = space.len();
                let at = |i: usize| {
                    let turn = std::f64::consts::TAU * i as f64 / n as f64;
                    let place = match kind {
                        "closed" => Point::new(turn.cos(), turn.sin(), 0.1 * (2.0 * turn).sin()),
                        _ => Point::new(turn / 3.0, 0.3 * turn.sin(), 0.0),
                    };
                    place * size
                };
                let weights = |i: usize| 1.0 + 0.5 * (i as f64 * 1.7).sin();
                let weights = (kind == "quotient").then(|| (0..n).map(weights).collect());
                let curve = Curve::build(space, (0..n).map(at).collect(), weights).unwrap();
                let (a, b) = curve.space().domain();
                let place = |share: f64| a + share * (b - a);
                let mut simulation =
                    Setup::new(Body::new(&curve).mass(0.3 / size).stiffness(stiffness * size))
                        .gravity([0.0, 0.0, -9.81 * size])
                        .hold(fixed(place(0.07)))
                        .hold(sliding(place(0.4)))
                        .hold(sliding(place(0.65)))
                        .scheme(scheme)
                        .prepare()
                        .unwrap();
                let what = format!("degree {degree}, {kind}, {stiffness}, {size:e}, {scheme:?}");
                for frame in 0..8 {
                    simulation.advance(1.0 / 24.0).unwrap();
                    let worst = simulation.worst_error();
                    assert!(worst <= 1e-6 * 2.0 * size, "{what}, frame {frame}: {worst:e}");
                }
                let moved = curve.points().iter().zip(simulation.shape(0).unwrap().control_vertices());
                let moved = moved.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                assert!(moved > 0.01 * size, "{what}: {moved}");
                all += 1;
            }
        }
    }
    assert_eq!(all, 75);
}
