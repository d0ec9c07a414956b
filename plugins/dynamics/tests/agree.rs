//! Constraints that ask the same of nearly the same place, and those that do not.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, DynamicsError, Scheme, Setup, fixed, sliding};
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Curves of many degrees, clamped, floating and periodic, with weights and without, of three sizes.
fn curves() -> Vec<(String, Curve)> {
    let mut all = Vec::new();
    for degree in [1, 2, 3, 5] {
        let n = degree + 6;
        for (what, space) in [
            ("clamped", Space::clamped_uniform(degree, n).unwrap()),
            ("floating", Space::floating_uniform(degree, n).unwrap()),
            ("periodic", Space::periodic_uniform(degree, n).unwrap()),
        ] {
            for (size, weighted) in [(1.0, false), (1e-3, true), (1e4, false)] {
                let turn = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
                let points = (0..n).map(|i| {
                    let (sin, cos) = turn(i).sin_cos();
                    Point::new(size * cos, size * sin, size * 0.2 * (i as f64).sin())
                });
                let weights = weighted.then(|| (0..n).map(|i| 1.0 + 0.5 * (i % 3) as f64).collect());
                let curve = Curve::build(space.clone(), points.collect(), weights).unwrap();
                all.push((format!("{what} of degree {degree} and size {size}"), curve));
            }
        }
    }
    all
}

/// Two points a hair's breadth apart on the shape cannot be far apart, however near to one another their rows are; nor is one dropped.
#[test]
fn places_that_nearly_coincide_contradict_or_agree() {
    let (mut refused, mut held) = (0, 0);
    for (what, curve) in curves() {
        let domain = Shape::domain(&curve)[0];
        let (at, span) = (domain.start + 0.37 * (domain.end - domain.start), domain.end - domain.start);
        let size = curve.points().iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
        let here = |u: f64| Point::from(Shape::value(&curve, u.into(), Derivative::POSITION).unwrap());
        for apart in [0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
            let other = at + apart * span;
            for scheme in [Scheme::Exact, Scheme::Implicit] {
                let body = Body::new(&curve).mass(0.3).stiffness(50.0 * size * size).damping(1.0);
                let setup = |first: Point, second: Point, floats: bool| {
                    let one = if floats { sliding(at) } else { fixed(at) };
                    Setup::new(body.clone())
                        .gravity([0.0, 0.0, -9.81 * size])
                        .scheme(scheme)
                        .hold(fixed(domain.start))
                        .hold(one.to(first).called("one"))
                        .hold(fixed(other).to(second).called("other"))
                };
                // Across the shape, where what slides does not help either.
                let tangent = Shape::value(&curve, at.into(), Derivative::from(1)).unwrap();
                let away = tangent.cross(&Vector::new(0.3, 0.2, 0.9)).normalize() * (0.3 * size);
                for floats in [false, true] {
                    let error =
                        setup(here(at), here(at) + away, floats).prepare().map(|_| what.clone()).unwrap_err();
                    let DynamicsError::Conflict { names, apart: by } = error else {
                        panic!("{what}, {apart:e} apart: {error}")
                    };
                    assert_eq!(names, ["one", "other"], "{what}, {apart:e} apart");
                    // Where one slides, what they ask for is told in its equations, which lean.
                    let lean = if floats { 2.0 } else { 1.5 };
                    let ratio = by / away.norm();
                    assert!((1.0 / lean..lean).contains(&ratio), "{what}, {apart:e} apart: {by:e} of {away}");
                    refused += 1;
                }
                // The same place, and where each of them is.
                for second in [here(at), here(other)] {
                    let mut simulation = setup(here(at), second, false).prepare().unwrap();
                    let step = if scheme == Scheme::Implicit { 1.0 / 60.0 } else { simulation.stable_step() };
                    for _ in 0..20 {
                        simulation.advance(step).unwrap_or_else(|e| panic!("{what}, {apart:e} apart: {e}"));
                    }
                    let errors = simulation.errors().unwrap();
                    assert!(
                        errors.iter().all(|e| *e < 1e-5 * size),
                        "{what}, {apart:e} apart, {scheme:?}: {errors:?}"
                    );
                    held += 1;
                }
            }
        }
    }
    assert_eq!((refused, held), (720, 720));
}
