//! Linear functionals of the kernel whose location slides: directions of ropes, normals of sheets.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use std::sync::Arc;

use loftsman_dynamics::{Body, DynamicsError, Path, Scheme, Setup, Simulation, fixed, holds, sliding};
use loftsman_kernel::functional::{near, normal, orthogonal, tangent};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::common::line;

const SCHEMES: [Scheme; 3] = [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit];

/// A rope of 3 that hangs from ends 2.4 apart, where one is led to from 3.
fn rope(degree: usize, bending: f64, scheme: Scheme, damping: f64) -> Simulation {
    let rope = line(degree, 20, [0.0; 3], [3.0, 0.0, 0.0]);
    let end = rope.space().domain().1;
    Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0).bending(bending).damping(damping))
        .gravity([0.0, -9.81, 0.0])
        .hold(fixed(0.0))
        .hold(fixed(end).to([2.4, 0.4, 0.0]))
        .draw(0.02)
        .scheme(scheme)
        .prepare()
        .unwrap()
}

fn advance(simulation: &mut Simulation, frames: usize) {
    (0..frames).for_each(|_| simulation.advance(1.0 / 24.0).unwrap());
}

fn direction(simulation: &Simulation, u: f64) -> Vector {
    simulation.shape(0).unwrap().value(u.into(), Derivative::from(1)).unwrap()
}

fn place(simulation: &Simulation, constraint: usize) -> f64 {
    let Location::Curve(u) = simulation.locations(constraint).unwrap()[0] else { panic!("a curve") };
    u
}

/// What a rope does anyhow somewhere is only followed: where it is level is its lowest place, in a motion and at rest, and nothing holds it there.
#[test]
fn where_a_rope_is_level_is_followed_and_costs_nothing() {
    for scheme in SCHEMES {
        for degree in [3, 5] {
            let mut simulation = rope(degree, 0.0, scheme, 2.0);
            let end = match degree {
                3 => 17.0,
                _ => 15.0,
            };
            advance(&mut simulation, 12);
            simulation.settle_without_corners().unwrap();
            let held =
                simulation.hold(holds(Arc::new(orthogonal(near(0.4 * end), [0.0, 1.0, 0.0]))), 0.02).unwrap();
            let now = simulation.time();
            let way = vec![Point::new(2.4, 0.4, 0.0), Point::new(2.2, 0.8, 0.0)];
            simulation.retarget(1, Path::new(way, now, now + 1.0).unwrap()).unwrap();
            for frame in 0..36 {
                simulation.advance(1.0 / 24.0).unwrap();
                let way = direction(&simulation, place(&simulation, held));
                let steep = way.y.abs() / way.norm();
                // A millionth of the size, of a derivative of a sixth.
                assert!(frame < 8 || steep < 1e-5, "{scheme:?} {degree} {frame}: {steep:e}");
            }
            let settled = simulation.settle_without_corners().unwrap();
            assert!(settled.rests, "{scheme:?} {degree}: {settled:?}");
            let (u, way) = (place(&simulation, held), direction(&simulation, place(&simulation, held)));
            assert!(way.y.abs() < 1e-9 * way.norm(), "{scheme:?} {degree}: {way}");
            let force = simulation.force_of(held).unwrap()[0];
            assert!(force.abs() < 1e-8, "{scheme:?} {degree}: {force:e}");
            // Where the same rope is lowest that knows nothing of it.
            let mut free = rope(degree, 0.0, scheme, 2.0);
            advance(&mut free, 12);
            free.retarget(1, Path::from(Point::new(2.2, 0.8, 0.0))).unwrap();
            advance(&mut free, 24);
            free.settle_without_corners().unwrap();
            let (mut low, mut high) = (0.1 * end, 0.9 * end);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if direction(&free, middle).y < 0.0 { low = middle } else { high = middle }
            }
            assert!((u - low).abs() < 1e-6, "{scheme:?} {degree}: {u} for {low}");
        }
    }
}

/// A direction that a hanging rope has nowhere, out of its plane: it slides to where that costs the least energy of all places near, and in a motion
/// without damping it takes no energy and gives none.
#[test]
fn a_direction_comes_to_where_it_costs_least() {
    let lean = Vector::new(1.0, 0.0, 1.0);
    for degree in [2, 3, 5] {
        let settled = |at: Option<f64>| {
            let mut simulation = rope(degree, 0.05, Scheme::Implicit, 2.0);
            advance(&mut simulation, 24);
            let functional = match at {
                Some(u) => tangent(u).direction(lean),
                None => tangent(near(6.0)).direction(lean),
            };
            let held = simulation.hold(holds(Arc::new(functional)), 0.05).unwrap();
            advance(&mut simulation, 24);
            let settled = simulation.settle_without_corners().unwrap();
            assert!(settled.rests, "{degree} {at:?}: {settled:?}");
            let u = place(&simulation, held);
            let way = direction(&simulation, u);
            assert!(way.cross(&lean).norm() < 1e-9 * way.norm(), "{degree} {at:?}: {way}");
            (u, simulation.energy().total())
        };
        let (u, least) = settled(None);
        let (_, there) = settled(Some(u));
        assert!((there - least).abs() < 1e-7 * least.abs(), "{degree} at {u}: {least} and {there}");
        for beside in [-0.05, 0.05] {
            let (_, more) = settled(Some(u + beside));
            assert!(more > least + 1e-9 * least.abs(), "{degree} at {u}: {least}, beside it {more}");
        }
    }
    for scheme in [Scheme::Exact, Scheme::Epsilon] {
        let mut simulation = rope(3, 0.05, scheme, 0.0);
        simulation.settle_without_corners().unwrap();
        let held = simulation.hold(holds(Arc::new(tangent(near(6.0)).direction(lean))), 0.04).unwrap();
        advance(&mut simulation, 24);
        let before = simulation.energy();
        for _ in 0..24 {
            simulation.advance(1.0 / 24.0).unwrap();
            let now = simulation.energy();
            let change = (now.total() - before.total()).abs();
            let moves = now.kinetic.max(before.kinetic) + now.elastic.max(before.elastic);
            assert!(change < 0.05 * moves, "{scheme:?}: {change} of {moves}");
            let way = direction(&simulation, place(&simulation, held));
            assert!(way.cross(&lean).norm() < 1e-5 * way.norm() * lean.norm(), "{scheme:?}: {way}");
        }
    }
}

/// The level place of a sheet that hangs on its corners, both parameters sliding.
#[test]
fn where_a_sheet_is_level_is_followed() {
    let side = Space::clamped_uniform(3, 6).unwrap();
    let end = side.domain().1;
    let points = (0..36).map(|k| {
        let [x, y] = [k / 6, k % 6].map(|i| side.greville(i) / end);
        Point::new(x, y, 0.3 * x)
    });
    let sheet = Surface::new(side.clone(), side.clone(), points.collect()).unwrap();
    let mut setup = Setup::new(Body::new(&sheet).mass(0.3).stiffness(40.0).damping(2.0))
        .gravity([0.0, 0.0, -9.81])
        .draw(0.05)
        .scheme(Scheme::Implicit);
    for corner in [[0.0, 0.0], [0.0, end], [end, 0.0], [end, end]] {
        let [x, y] = corner.map(|c| 0.1 + 0.8 * c / end);
        setup = setup.hold(fixed(corner).to([x, y, 0.3 * x]));
    }
    let mut simulation = setup.prepare().unwrap();
    advance(&mut simulation, 24);
    let level = normal(near([0.4 * end, 0.5 * end]), [0.0, 0.0, 1.0]);
    let held = simulation.hold(holds(Arc::new(level)), 0.05).unwrap();
    advance(&mut simulation, 24);
    let settled = simulation.settle().unwrap();
    assert!(settled.rests, "{settled:?}");
    let at = simulation.locations(held).unwrap()[0];
    for order in [Derivative { u: 1, v: 0 }, Derivative { u: 0, v: 1 }] {
        let way = simulation.shape(0).unwrap().value(at, order).unwrap();
        assert!(way.z.abs() < 1e-8 * way.norm(), "{at}: {way}");
    }
    assert!(simulation.force_of(held).unwrap().iter().all(|force| force.abs() < 1e-7));
    let Location::Surface(u, v) = at else { panic!("a surface") };
    assert!((v - 0.5 * end).abs() < 1e-4 * end && u < 0.45 * end, "{u} {v}");
}

/// Where what is only followed vanishes, an error says what and when; with a small mass (`Epsilon`) it holds the last place that there is, and there goes on being one.
#[test]
fn what_is_followed_and_vanishes_is_told() {
    let arch = |scheme: Scheme, near: f64, weight: f64| {
        let points = (0..9).map(|i| {
            let x = f64::from(i) / 2.0 - 2.0;
            Point::new(x, 0.0, 1.0 - x * x / 4.0)
        });
        let rope = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points.collect()).unwrap();
        Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0).damping(1.0))
            .gravity([0.0, 0.0, -weight])
            .hold(fixed(0.0))
            .hold(fixed(6.0))
            .hold(sliding(near).axes([false, false, true]))
            .scheme(scheme)
            .prepare()
            .unwrap()
    };
    for near in [1.2, 2.5] {
        for scheme in [Scheme::Exact, Scheme::Implicit] {
            let mut simulation = arch(scheme, near, 9.81);
            let error = (0..48).find_map(|_| simulation.advance(1.0 / 24.0).err()).unwrap();
            assert!(matches!(error, DynamicsError::Vanishes { .. }), "{scheme:?} {near}: {error}");
            let text = error.to_string();
            assert!(text.contains("sliding near") && text.contains("epsilon"), "{text}");
            // Without weight it stays where it is.
            let mut still = arch(scheme, near, 0.0);
            advance(&mut still, 24);
            assert!((place(&still, 2) - near).abs() < 1e-6, "{scheme:?} {near}");
        }
        let mut held = arch(Scheme::Epsilon, near, 9.81);
        let height = held.shape(0).unwrap().value(near.into(), Derivative::POSITION).unwrap().z;
        advance(&mut held, 48);
        let shape = held.shape(0).unwrap();
        let highest = (0..=600)
            .map(|k| shape.value((0.01 * f64::from(k)).into(), Derivative::POSITION).unwrap().z)
            .fold(f64::NEG_INFINITY, f64::max);
        assert!(held.holds(2).unwrap() && highest > height - 1e-5, "{near}: {highest} {height}");
    }
}
