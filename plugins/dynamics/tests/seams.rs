//! Closed ropes and ropes of pieces go on being closed and smooth, as if their knots made them so.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, force, sliding};
use loftsman_kernel::shape::{Derivative, Side};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

const COUNT: usize = 16;

/// A closed rope of simple knots.
fn ring(degree: usize) -> Curve {
    let points = (0..COUNT).map(|k| {
        let t = k as f64 / COUNT as f64 * std::f64::consts::TAU;
        Point::new(1.2 * t.cos(), 0.8 * t.sin(), 0.2 * (2.0 * t).sin())
    });
    Curve::new(Space::periodic_uniform(degree, COUNT).unwrap(), points.collect()).unwrap()
}

fn setup(rope: &Curve, scheme: Scheme) -> Setup {
    Setup::new(
        Body::new(rope)
            .mass(0.2)
            .stiffness(50.0)
            .bending(if rope.space().degree() > 1 { 0.1 } else { 0.0 })
            .damping(0.0),
    )
    .scheme(scheme)
    .step(5e-4)
}

fn hung(rope: &Curve, scheme: Scheme, kept: bool) -> Simulation {
    let (start, _) = rope.space().domain();
    let setup =
        setup(rope, scheme).gravity([0.0, 0.0, -9.81]).hold(fixed(start + 3.3)).hold(fixed(start + 10.1));
    if kept { setup.keep_seams() } else { setup }.prepare().unwrap()
}

fn apart(a: &Simulation, b: &Simulation, rope: &Curve) -> f64 {
    let (start, end) = rope.space().domain();
    let point = |of: &Simulation, u: f64| of.shape(0).unwrap().value(u.into(), Derivative::POSITION).unwrap();
    (0..200)
        .map(|k| start + (end - start) * (f64::from(k) + 0.5) / 200.0)
        .map(|u| (point(a, u) - point(b, u)).norm())
        .fold(0.0, f64::max)
}

/// Cut open at its seam, or at every knot into pieces, it moves as the same rope in periodic form: of degree 2 the space of functions is the same, and so is
/// the motion; of higher degrees both are as far apart as what lies between smooth once and as smooth as can be. Without anything that keeps it, it comes apart.
#[test]
fn a_rope_in_pieces_moves_as_in_periodic_form() {
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        for (degree, near) in [(2, [1e-9, 1e-9]), (3, [0.01, 0.06]), (4, [0.01, 0.06])] {
            let periodic = ring(degree);
            let clamped = periodic.to_clamped().unwrap();
            let pieces = clamped.bezier_form().unwrap();
            let mut first = hung(&periodic, scheme, true);
            assert_eq!(first.constraints(), 2);
            for ((rope, more), near) in [(&clamped, 2), (&pieces, 1 + COUNT)].into_iter().zip(near) {
                let mut kept = hung(rope, scheme, true);
                assert_eq!(kept.constraints(), 2 + more);
                let mut loose = hung(rope, scheme, false);
                (0..6).for_each(|_| {
                    kept.advance(0.05).unwrap();
                    loose.advance(0.05).unwrap();
                });
                if rope.points().len() == clamped.points().len() {
                    (0..6).for_each(|_| first.advance(0.05).unwrap());
                }
                let (found, without) = (apart(&kept, &first, &periodic), apart(&loose, &first, &periodic));
                assert!(found < near, "{scheme:?} {degree} {more}: {found:e} ({without})");
                assert!(without > 4.0 * found, "{scheme:?} {degree} {more}: {found:e} ({without})");
                let (start, end) = rope.space().domain();
                let shape = kept.shape(0).unwrap();
                for order in [0, 1] {
                    let side = |u: f64, side: Side| {
                        let stencil =
                            shape.stencil_on(u.into(), Derivative::from(order), side.into()).unwrap();
                        stencil.apply(shape.control_vertices())
                    };
                    let gap = (side(start, Side::Right) - side(end, Side::Left)).norm();
                    assert!(gap < 2e-6, "{scheme:?} {degree} {more}: {gap:e} of order {order}");
                }
            }
        }
    }
}

/// What keeps a rope closed acts between its own ends: no force from outside, no momentum, no energy.
#[test]
fn what_keeps_it_takes_no_momentum_and_no_energy() {
    let rope = ring(3).to_clamped().unwrap();
    let count = rope.points().len();
    for scheme in [Scheme::Exact, Scheme::Epsilon] {
        let speeds = (0..count).map(|k| Vector::new((k as f64).sin(), 0.4, (2.0 * k as f64).cos()));
        let body = Body::new(&rope).mass(0.2).stiffness(50.0).damping(0.0).moving(speeds.collect());
        let mut simulation = Setup::new(body).scheme(scheme).keep_seams().prepare().unwrap();
        let centre = |simulation: &Simulation| {
            let shape = simulation.shape(0).unwrap();
            let mut sums = (Vector::zeros(), 0.0);
            let (start, end) = rope.space().domain();
            for k in 0..4000 {
                let u = start + (end - start) * (f64::from(k) + 0.5) / 4000.0;
                let weight = rope.derivative(u, 1).unwrap().norm();
                sums.0 += shape.value(u.into(), Derivative::POSITION).unwrap() * weight;
                sums.1 += weight;
            }
            sums.0 / sums.1
        };
        simulation.advance(0.01).unwrap();
        let before = simulation.energy();
        let mut at = vec![centre(&simulation)];
        for _ in 0..3 {
            simulation.advance(0.2).unwrap();
            at.push(centre(&simulation));
        }
        let steps: Vec<Vector> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
        for step in &steps {
            assert!((step - steps[0]).norm() < 1e-6, "{scheme:?}: {steps:?}");
        }
        let after = simulation.energy();
        let moved = before.kinetic + before.elastic;
        assert!((after.total() - before.total()).abs() < 0.02 * moved, "{scheme:?}: {before:?} {after:?}");
    }
}

/// A straight polyline, and ends that others hold, stay as they are.
#[test]
fn what_folds_and_what_is_held_is_left_alone() {
    let line = ring(1).to_clamped().unwrap();
    let names = |setup: Setup| -> Vec<String> {
        let simulation = setup.keep_seams().prepare().unwrap();
        (0..simulation.constraints()).map(|k| simulation.name_of(k).unwrap().to_owned()).collect()
    };
    let found = names(setup(&line, Scheme::Exact));
    assert!(found.len() == 1 && found[0].starts_with("the ends of "), "{found:?}");
    let rope = ring(3).to_clamped().unwrap();
    let (start, end) = rope.space().domain();
    let held = setup(&rope, Scheme::Exact).hold(fixed(start)).hold(fixed(end).to([3.0, 0.0, 0.0]));
    assert_eq!(names(held).len(), 2);
    assert_eq!(names(setup(&rope, Scheme::Exact).hold(fixed(start))).len(), 3);
}

/// Two hooks through which a loop slides, drawn round by a force at a place of it. (A pull is damped by what moves where it acts, which of a piece alone is less.)
fn drawn(rope: &Curve, scheme: Scheme) -> Setup {
    let (start, _) = rope.space().domain();
    let at = |u: f64| rope.point(start + u).unwrap();
    let hook = at(8.8);
    let drawn = force(start + 4.8, 2.5 * (hook - at(4.8)));
    Setup::new(Body::new(rope).mass(0.1).stiffness(50.0).rest(0.7).damping(3.0))
        .scheme(scheme)
        .step(1e-3)
        .hold(sliding(start + 0.8).to(at(0.8)))
        .hold(sliding(start + 8.8).to(hook))
        .push(drawn)
        .keep_seams()
}

/// Where the ends of a loop are kept together there is no end: what slides goes round over them, as on the same loop in periodic form: of degrees 1 and 2 to rounding, for
/// there both are the same functions (but that a place's small mass in `Epsilon` is a share of what there is a control vertex).
#[test]
fn places_slide_over_ends_that_are_kept_together() {
    let mut crossed = 0;
    for degree in [1, 2, 3] {
        let periodic = ring(degree);
        let clamped = periodic.to_clamped().unwrap();
        let mut cut = vec![clamped.clone()];
        if degree > 1 {
            cut.push(clamped.bezier_form().unwrap());
        }
        for rope in &cut {
            for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
                let [mut whole, mut kept] =
                    [&periodic, rope].map(|rope| drawn(rope, scheme).prepare().unwrap());
                let (start, end) = rope.space().domain();
                let mut last = [0, 1].map(|k| kept.locations(k).unwrap()[0].on_curve().unwrap());
                for _ in 0..30 {
                    whole.advance(0.1).unwrap();
                    kept.advance(0.1).unwrap();
                    for (k, last) in last.iter_mut().enumerate() {
                        assert!(kept.holds(k).unwrap(), "{degree} {scheme:?}: {k}");
                        let at = kept.locations(k).unwrap()[0].on_curve().unwrap();
                        crossed += usize::from((at - *last).abs() > 0.5 * (end - start));
                        *last = at;
                        let hook = kept.shape(0).unwrap().value(at.into(), Derivative::POSITION).unwrap();
                        let there = rope.point(start + [0.8, 8.8][k]).unwrap().coords;
                        assert!((hook - there).norm() < 5e-6, "{degree} {scheme:?}: {k}");
                    }
                }
                let found = apart(&kept, &whole, &periodic);
                let near = if scheme == Scheme::Epsilon { 1e-4 } else { 1e-9 };
                assert!(
                    degree > 2 || found < near,
                    "{degree} {scheme:?} of {} vertices: {found:e}",
                    rope.points().len()
                );
            }
        }
    }
    assert!(crossed >= 12, "{crossed}");
}

/// At rest, too: over the ends of a loop the energy goes on falling.
#[test]
fn what_rests_has_slid_over_ends_that_are_kept_together() {
    for degree in [1, 2] {
        let periodic = ring(degree);
        let mut whole = drawn(&periodic, Scheme::Exact).prepare().unwrap();
        let mut kept = drawn(&periodic.to_clamped().unwrap(), Scheme::Exact).prepare().unwrap();
        let [a, b] = [&mut whole, &mut kept].map(|simulation| {
            simulation.settle().unwrap();
            (simulation.holds(0).unwrap(), simulation.energy().total())
        });
        assert!(a.0 && b.0, "{degree}");
        assert!(b.1 <= a.1 + 1e-6 * a.1.abs(), "{degree}: {b:?} {a:?}");
    }
}
