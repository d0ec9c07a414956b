//! Velocities at the start: what slides, slides from the start.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Spot, fixed, sliding, tied};
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::common::line;

/// A rope that is drawn through its rings along itself, each vertex at the same speed: nothing stops it, and nothing jumps. It keeps energy and
/// momentum, in the first step as later, until an end comes.
#[test]
fn a_rope_goes_on_through_its_rings() {
    for degree in [1, 2, 3, 5, 7] {
        for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
            let n = degree + 8;
            let rope = line(degree, n, [0.0; 3], [4.0, 1.0, -2.0]);
            let end = rope.space().domain().1;
            let along = Vector::new(4.0, 1.0, -2.0) * 0.3;
            let body = Body::new(&rope).mass(0.5).stiffness(80.0).damping(0.0).moving(vec![along; n]);
            let mut simulation = Setup::new(body)
                .hold(sliding(0.31 * end))
                .hold(sliding(0.52 * end))
                .hold(sliding(0.83 * end))
                .epsilon(1e-6)
                .scheme(scheme)
                .prepare()
                .unwrap();
            let before = simulation.energy().total();
            let kinetic = 0.5 * 0.5 * 21_f64.sqrt() * along.norm_squared();
            assert!((before / kinetic - 1.0).abs() < 1e-9, "{before} {kinetic}");
            let step = if scheme == Scheme::Implicit { 1e-3 } else { simulation.stable_step() };
            let mut steps = 0;
            while simulation.time() < 0.2 {
                simulation.step(step).unwrap();
                steps += 1;
                let what = format!("degree {degree}, {scheme:?}, step {steps}");
                let now = simulation.energy().total();
                assert!((now / before - 1.0).abs() < 1e-6, "{what}: {before} → {now}");
                for v in simulation.velocities(0).unwrap() {
                    assert!((v - along).norm() < 1e-5 * along.norm(), "{what}: {v} for {along}");
                }
                assert!(simulation.errors().unwrap().iter().all(|e| *e < 1e-9), "{what}");
            }
            let Location::Curve(u) = simulation.locations(1).unwrap()[0] else { panic!("a curve") };
            let wanted = (0.52 - 0.3 * simulation.time()) * end;
            assert!((u - wanted).abs() < 1e-6 * end, "degree {degree}, {scheme:?}: {u} for {wanted}");
        }
    }
}

/// Thrown any way, held any way: the least change of its velocities, in the mass metric, that all its constraints allow. So its energy of
/// motion at the start is no more than that of what it was thrown with, and the first steps change it by no more than the forces do.
#[test]
fn what_is_thrown_starts_as_its_constraints_allow() {
    for round in 0..24_usize {
        let degree = 1 + round % 5;
        let n = degree + 9;
        let bent = |i: usize| {
            let t = i as f64;
            Point::new(0.5 * t, (0.7 * t + round as f64).sin() * 0.3, (0.9 * t).cos() * 0.3)
        };
        let space = Space::clamped_uniform(degree, n).unwrap();
        let end = space.domain().1;
        let rope = Curve::new(space, (0..n).map(bent).collect()).unwrap();
        let thrown: Vec<Vector> = (0..n)
            .map(|i| {
                let t = (i * (round + 2)) as f64;
                Vector::new((0.7 * t).sin(), (0.4 * t).cos(), (0.2 * t).sin())
            })
            .collect();
        // A line whose middle its end is on.
        let tip = rope.points()[n - 1];
        let [from, to] = [-1.0, 1.0].map(|side| tip + Vector::new(0.3, 1.0, 0.2) * side);
        let beside = line(3, 6, from.coords.into(), to.coords.into());
        let scheme = [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit][round % 3];
        let body = || Body::new(&rope).mass(0.4).stiffness(30.0).damping(0.0).moving(thrown.clone());
        let free = Setup::new(body()).prepare().unwrap().energy().kinetic;
        let mut simulation = Setup::new(body())
            .and(Body::new(&beside).mass(0.2).stiffness(30.0).damping(0.0))
            .hold(fixed(0.0))
            .hold(sliding(0.33 * end))
            .hold(sliding(0.71 * end).axes([true, round % 2 == 0, true]))
            .hold(
                tied(Spot::at(0, end), Spot::near(1, 1.5))
                    .during(if round % 4 == 3 { 9.0 } else { 0.0 }, 10.0),
            )
            .scheme(scheme)
            .prepare()
            .unwrap();
        let start = simulation.energy();
        assert!(start.kinetic < free, "round {round}: {} of {free}", start.kinetic);
        // What is fixed stands still, and what slides does so along itself.
        let velocities = simulation.velocities(0).unwrap();
        let flight =
            Curve::new(rope.space().clone(), velocities.iter().map(|v| Point::from(*v)).collect()).unwrap();
        let speed = |u: f64| flight.point(u).unwrap().coords;
        assert!(speed(0.0).norm() < 1e-12, "round {round}: {}", speed(0.0));
        let u = 0.33 * end;
        let tangent = rope.derivative(u, 1).unwrap();
        let across = speed(u).cross(&tangent).norm() / tangent.norm();
        assert!(across < 1e-12, "round {round}: {across:e}");
        // Short steps: what moves keeps its energy, but for what the forces do.
        let step = 0.02 * simulation.stable_step();
        let mut last = start.total();
        for _ in 0..10 {
            simulation.step(step).unwrap();
            let now = simulation.energy().total();
            assert!((now / last - 1.0).abs() < 2e-3, "round {round}, {scheme:?}: {last} → {now}");
            last = now;
        }
    }
}

/// Of still shapes and paths nothing is asked at the start: they begin at rest, and are drawn in.
#[test]
fn what_is_at_rest_starts_at_rest() {
    let rope = line(3, 12, [0.0; 3], [4.0, 0.0, 0.0]);
    let end = rope.space().domain().1;
    let path = loftsman_dynamics::Path::new(vec![[4.0, 0.0, 0.0].into(), [6.0, 0.0, 0.0].into()], 0.0, 1.0);
    let mut simulation = Setup::new(Body::new(&rope).mass(0.5).stiffness(80.0))
        .hold(fixed(end).to(path.unwrap()))
        .prepare()
        .unwrap();
    assert_eq!(simulation.energy().kinetic, 0.0);
}

/// What a constraint misses when it comes is drawn in by `(1 + t/τ) e^(-t/τ)`, however short τ is beside what is stable and beside the frames, of what is fixed and of what slides.
#[test]
fn constraints_are_drawn_in_by_their_law() {
    for degree in [1, 2, 3, 5] {
        for draw in [1e-6, 1e-4, 1e-3, 0.01, 0.05, 0.2] {
            for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
                for slides in [false, true] {
                    let (length, missed) = (600.0, 6.0);
                    let rope = line(degree, degree + 5, [0.0; 3], [length, 0.0, 0.0]);
                    let end = rope.space().domain().1;
                    let to = [if slides { 0.5 * length } else { length }, 0.0, missed];
                    let held = if slides { sliding(0.5 * end).to(to) } else { fixed(end).to(to) };
                    let setup = Setup::new(Body::new(&rope).mass(0.1).stiffness(1e4))
                        .hold(fixed(0.0))
                        .hold(held)
                        .scheme(scheme)
                        .draw(draw);
                    let mut simulation = setup.prepare().unwrap();
                    for frame in 1..8 {
                        simulation.advance(0.02).unwrap();
                        let t = 0.02 * f64::from(frame) / draw;
                        let left = missed * (1.0 + t) * (-t).exp();
                        let Location::Curve(at) = simulation.locations(1).unwrap()[0] else {
                            panic!("a curve")
                        };
                        let shape = simulation.shape(0).unwrap();
                        let now =
                            shape.value(at.into(), loftsman_kernel::shape::Derivative::POSITION).unwrap();
                        let misses = Vector::from(to) - now;
                        let what =
                            format!("{degree} {draw} {scheme:?} {slides} {frame}: {misses:?} for {left}");
                        assert!(
                            (misses.z - left).abs() < 0.01 * missed && misses.x.abs() < 0.01 * missed,
                            "{what}"
                        );
                    }
                }
            }
        }
    }
}
