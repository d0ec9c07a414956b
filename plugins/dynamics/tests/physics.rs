//! Against closed forms.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, Spot, fixed, force, sliding, tied};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::common::line;

/// A rod of uniform mass that swings about its end: `T = 2π √(2L/3g)`, for small swings; of several degrees, by every scheme.
#[test]
fn a_pendulum_has_its_period() {
    let angle: f64 = 0.01;
    for (degree, n, stiffness) in [(1, 2, 1e6), (3, 5, 1e5)] {
        // What swings and steps of a thousandth of a period are of it: 6e-6 and 2e-6; of implicit ones, of first order, more, and of a softer rod its stretch.
        for (scheme, within) in [(Scheme::Exact, 1.5e-5), (Scheme::Epsilon, 1.5e-5), (Scheme::Implicit, 1e-4)]
        {
            let within = within + 30.0 / stiffness;
            let rod = line(degree, n, [0.0; 3], [angle.sin(), 0.0, -angle.cos()]);
            let mut simulation =
                Setup::new(Body::new(&rod).stiffness(stiffness).bending(if degree > 1 { 1e4 } else { 0.0 }))
                    .gravity([0.0, 0.0, -9.81])
                    .hold(fixed(0.0))
                    .scheme(scheme)
                    .prepare()
                    .unwrap();
            let period = std::f64::consts::TAU * (2.0 / (3.0 * 9.81_f64)).sqrt();
            // Crossings of the vertical.
            let (mut last, mut crossings) = (angle.sin(), Vec::new());
            let dt = period / 1000.0;
            while crossings.len() < 5 {
                simulation.advance(dt).unwrap();
                let x = simulation.shape(0).unwrap().control_vertices()[n - 1].x;
                if last * x < 0.0 {
                    crossings.push(simulation.time() - dt * x / (x - last));
                }
                last = x;
            }
            let found = (crossings[4] - crossings[0]) / 2.0;
            assert!((found / period - 1.0).abs() < within, "{degree} {scheme:?}: {found} {period}");
            assert!(simulation.worst_error() < 1e-6, "{scheme:?}: {}", simulation.worst_error());
        }
    }
}

/// Equal stretch on both sides of a ring, and not of a nail.
#[test]
fn a_rope_through_a_ring_settles_with_equal_stretch() {
    let rope = line(3, 41, [0.0; 3], [10.0, 0.0, 0.0]);
    let ends = rope.space().domain().1;
    let stretch = |ring: bool| {
        let middle = if ring { sliding(0.4 * ends) } else { fixed(0.4 * ends) };
        let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(100.0))
            .hold(fixed(0.0))
            .hold(fixed(ends).to([16.0, 0.0, 0.0]))
            .hold(middle)
            .scheme(Scheme::Exact)
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        let shape = simulation.shape(0).unwrap();
        let speed =
            |u: f64| shape.value((u * ends).into(), Derivative::from(1)).unwrap().norm() * ends / 10.0;
        (speed(0.1), speed(0.9))
    };
    let (left, right) = stretch(true);
    assert!((left / right - 1.0).abs() < 1e-6 && (left - 1.6).abs() < 1e-6, "{left} {right}");
    let (left, right) = stretch(false);
    assert!((left - 1.0).abs() < 0.01 && (right - 2.0).abs() < 0.01, "{left} {right}");
}

/// A ring that draws a rope aside pulls across it, never along: `λ · P' = 0`, with both sides stretched alike; by `settle` and by waiting.
#[test]
fn a_ring_pulls_across_its_rope() {
    for (n, to, bending) in [
        (21, [3.0, 0.0, 4.0], 0.0),
        (21, [3.0, 0.0, 4.0], 5.0),
        (41, [2.0, 1.0, 3.0], 10.0),
        (41, [6.0, 0.0, 0.5], 0.5),
    ] {
        for (scheme, waits) in [
            (Scheme::Implicit, false),
            (Scheme::Exact, false),
            (Scheme::Epsilon, false),
            (Scheme::Implicit, true),
        ] {
            let rope = line(3, n, [0.0; 3], [10.0, 0.0, 0.0]);
            let ends = rope.space().domain().1;
            let body = Body::new(&rope).mass(0.2).stiffness(100.0).bending(bending).damping(2.0);
            let mut simulation = Setup::new(body)
                .hold(fixed(0.0))
                .hold(fixed(ends).to([12.0, 0.0, 0.0]))
                .hold(sliding(0.35 * ends).to(to))
                .scheme(scheme)
                .prepare()
                .unwrap();
            if waits {
                for _ in 0..30 * 24 {
                    simulation.advance(1.0 / 24.0).unwrap();
                }
            } else {
                let settled = simulation
                    .settle_without_corners()
                    .unwrap_or_else(|e| panic!("{n} {to:?} {bending} {scheme:?}: {e}"));
                assert!(settled.rests, "{n} {to:?} {bending} {scheme:?}: {settled:?}");
            }
            let at = simulation.locations(2).unwrap()[0];
            let force = simulation.force_of(2).unwrap();
            let force = Vector::new(force[0], force[1], force[2]);
            let shape = simulation.shape(0).unwrap();
            let tangent = shape.value(at, Derivative::from(1)).unwrap();
            let along = force.dot(&tangent) / (force.norm() * tangent.norm());
            assert!(along.abs() < 1e-8, "{n} {to:?} {bending} {scheme:?} {waits}: {along} at {at}");
            // Tension is the same on both sides where the rope does not bend: half way to each end, but for how far spans of a cubic reach that
            // cannot kink.
            if bending < 1.0 {
                let [Location::Curve(u)] = simulation.locations(2).unwrap()[..] else { panic!("a place") };
                let speed = |u: f64| shape.value(u.into(), Derivative::from(1)).unwrap().norm();
                let (left, right) = (speed(0.5 * u), speed(0.5 * (u + ends)));
                assert!(
                    (left / right - 1.0).abs() < if n == 21 { 0.022 } else { 1e-9 },
                    "{n} {to:?} {bending} {scheme:?} {waits}: {left} {right}"
                );
            }
        }
    }
}

#[test]
fn a_ring_slides_down_a_wire() {
    // A bead on an inclined wire that stands still: s = ½ g sin(α) t².
    let wire = line(3, 8, [0.0; 3], [10.0, 0.0, -10.0]);
    let bead = line(1, 2, [1.0, 0.0, -1.0], [1.0, 0.1, -1.0]);
    let ends = wire.space().domain().1;
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        let mut simulation = Setup::new(Body::new(&bead).stiffness(1e3))
            .and(Body::new(&wire).still())
            .gravity([0.0, 0.0, -9.81])
            .hold(tied(Spot::at(0, 0.5), Spot::near(1, 0.1 * ends)))
            .epsilon(1e-6)
            .scheme(scheme)
            .prepare()
            .unwrap();
        for _ in 0..1000 {
            simulation.advance(1e-3).unwrap();
        }
        let p = simulation.shape(0).unwrap().value(0.5.into(), Derivative::POSITION).unwrap();
        let expected = 1.0 + 0.5 * 9.81 * 0.5;
        assert!((p.x - expected).abs() < 5e-3 * expected, "{scheme:?} {p} {expected}");
        assert!((p.x + p.z).abs() < 1e-6);
    }
}

/// A bead on a hoop that stands still: `T = 2π √(R/g)` for small swings.
#[test]
fn a_bead_on_a_hoop_has_its_period() {
    let radius = 2.0;
    let n = 40;
    // A closed cubic through a circle to 1e-6.
    let space = Space::periodic_uniform(3, n).unwrap();
    let turn = std::f64::consts::TAU / n as f64;
    let reach = radius * 3.0 / (2.0 + turn.cos());
    let points = (0..n).map(|i| {
        let a = turn * i as f64;
        Point::new(reach * a.cos(), 0.0, reach * a.sin())
    });
    let hoop = Curve::new(space, points.collect()).unwrap();
    // A little beside the lowest place.
    let lowest = (0..4000).map(|i| f64::from(i) / 4000.0 * n as f64).min_by(|a, b| {
        let z = |u: f64| hoop.point(u).unwrap().z;
        z(*a).total_cmp(&z(*b))
    });
    let start = lowest.unwrap() + 0.05;
    let p = hoop.point(start).unwrap();
    let bead = line(1, 2, [p.x, -1e-4, p.z], [p.x, 1e-4, p.z]);
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        let mut simulation = Setup::new(Body::new(&bead).stiffness(1.0))
            .and(Body::new(&hoop).still())
            .gravity([0.0, 0.0, -9.81])
            .hold(tied(Spot::at(0, 0.5), Spot::near(1, start)))
            .scheme(scheme)
            .prepare()
            .unwrap();
        let period = std::f64::consts::TAU * (radius / 9.81_f64).sqrt();
        let (mut last, mut crossings, dt) = (p.x, Vec::new(), period / 2000.0);
        while crossings.len() < 5 {
            simulation.advance(dt).unwrap();
            let x = simulation.shape(0).unwrap().value(0.5.into(), Derivative::POSITION).unwrap().x;
            if last * x < 0.0 {
                crossings.push(simulation.time() - dt * x / (x - last));
            }
            last = x;
        }
        let found = (crossings[4] - crossings[0]) / 2.0;
        assert!((found / period - 1.0).abs() < 1e-3, "{scheme:?}: {found} {period}");
    }
}

/// Irvine's elastic catenary between two nails on one level.
#[test]
fn a_hanging_rope_is_the_elastic_catenary() {
    // How near 60 cubic vertices come: nearer the less the rope bends between them.
    for (span, length, stiffness, near) in
        [(8.0, 10.0, 50.0, 1e-7), (9.0, 10.0, 5000.0, 1e-8), (3.0, 10.0, 200.0, 4e-5)]
    {
        let (w, n) = (0.3 * 9.81, 60);
        let rope = line(3, n, [0.0; 3], [length, 0.0, 0.0]);
        let end = rope.space().domain().1;
        let mut simulation = Setup::new(Body::new(&rope).mass(0.3).stiffness(stiffness).damping(1.0))
            .gravity([0.0, 0.0, -9.81])
            .hold(fixed(0.0))
            .hold(fixed(end).to([span, 0.0, 0.0]))
            .scheme(Scheme::Implicit)
            .prepare()
            .unwrap();
        // It falls first: a straight rope does not know which way to bend.
        for _ in 0..48 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        let v = w * length / 2.0;
        let x = |h: f64, s: f64| h * s / stiffness + h / w * ((v / h).asinh() - ((v - w * s) / h).asinh());
        let (mut low, mut high) = (1e-6, 1e6);
        for _ in 0..200 {
            let h = f64::sqrt(low * high);
            if x(h, length) < span { low = h } else { high = h }
        }
        let h = low;
        let z = |s: f64| {
            let root = |t: f64| (1.0 + (t / h) * (t / h)).sqrt();
            s / stiffness * (w * s / 2.0 - v) - h / w * (root(v) - root(v - w * s))
        };
        let shape = simulation.shape(0).unwrap();
        // By mass, the parameter is the length at rest.
        for i in 1..20 {
            let share = f64::from(i) / 20.0;
            let p = shape.value((share * end).into(), Derivative::POSITION).unwrap();
            let (want_x, want_z) = (x(h, share * length), z(share * length));
            let off = (p.x - want_x).hypot(p.z - want_z);
            assert!(off < near * length, "span {span}: {share} {p} ({want_x}, {want_z})");
        }
        // The nails carry the rope.
        let force = |k: usize| simulation.force_of(k).unwrap().to_vec();
        let weight = force(0)[2] + force(1)[2];
        assert!((weight / (w * length) - 1.0).abs() < 1e-8, "{weight} {}", w * length);
        assert!((force(1)[0] / h - 1.0).abs() < 6e-5, "{} {h}", force(1)[0]);
    }
}

/// Mattiasson's elastica (1981), and Euler and Bernoulli for a small load.
#[test]
fn a_cantilever_bends_as_it_should() {
    for (load, down, back) in
        [(0.01, 0.01 / 3.0, 0.0), (1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (10.0, 0.81061, 0.555)]
    {
        let rod = line(3, 24, [0.0; 3], [1.0, 0.0, 0.0]);
        let end = rod.space().domain().1;
        let direction = rod.derivative(0.0, 1).unwrap();
        let mut simulation = Setup::new(Body::new(&rod).stiffness(1e6).bending(1.0))
            .hold(fixed(0.0).tangent(direction))
            .push(force(end, [0.0, 0.0, -load]))
            .scheme(Scheme::Implicit)
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        let tip = simulation.shape(0).unwrap().value(end.into(), Derivative::POSITION).unwrap();
        assert!((-tip.z / down - 1.0).abs() < 0.01, "load {load}: {tip}");
        assert!((1.0 - tip.x - back).abs() < 0.01, "load {load}: {tip}");
    }
}

/// Beside PyElastica's Cosserat rod (`golden/cantilever.py`): where its tip rests under five loads, and how long a swing takes.
#[test]
fn a_cantilever_is_that_of_pyelastica() {
    let golden: serde_json::Value = serde_json::from_str(include_str!("golden/cantilever.json")).unwrap();
    let number = |name: &str| golden[name].as_f64().unwrap();
    let length = number("length");
    let clamped = |n: usize, load: f64, scheme: Scheme| {
        let rod = line(3, n, [0.0; 3], [length, 0.0, 0.0]);
        let end = rod.space().domain().1;
        let direction = rod.derivative(0.0, 1).unwrap();
        let material = Body::new(&rod).mass(number("mass")).stiffness(number("stiffness"));
        let mut simulation = Setup::new(material.bending(number("bending")))
            .hold(fixed(0.0).tangent(direction))
            .push(force(end, [0.0, 0.0, -load]))
            .scheme(scheme)
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        simulation
    };
    let tip = |simulation: &Simulation| *simulation.shape(0).unwrap().control_vertices().last().unwrap();
    let loads = golden["loads"].as_array().unwrap();
    for (load, wanted) in loads.iter().zip(golden["tips"].as_array().unwrap()) {
        let load = load.as_f64().unwrap();
        let tip = tip(&clamped(24, load, Scheme::Implicit));
        for axis in 0..3 {
            let off = tip[axis] - wanted[axis].as_f64().unwrap();
            assert!(off.abs() < 0.002 * length, "load {load}: {tip}, {wanted}");
        }
        assert!((tip.z / wanted[2].as_f64().unwrap() - 1.0).abs() < 0.01, "load {load}: {tip}, {wanted}");
    }
    // Let go from the smallest.
    let mut simulation = clamped(8, loads[0].as_f64().unwrap(), Scheme::Exact);
    simulation.push_with(0, [0.0; 3]).unwrap();
    let (start, dt) = (simulation.time(), 0.02);
    let (mut last, mut ups) = (tip(&simulation).z, Vec::new());
    while ups.len() < 2 && simulation.time() < start + 40.0 {
        simulation.advance(dt).unwrap();
        let z = tip(&simulation).z;
        if last < 0.0 && z >= 0.0 {
            ups.push(simulation.time() - dt * z / (z - last));
        }
        last = z;
    }
    let (period, wanted) = (ups[1] - ups[0], number("period"));
    assert!((period / wanted - 1.0).abs() < 0.002, "{period} {wanted}");
    // Euler and Bernoulli: 2π / (1.8751² √(EI/m) / L²), but for the second mode, which swings along 6.27 times as fast and moves the crossings.
    let beam = std::f64::consts::TAU * length * length
        / (1.875_104_069_f64.powi(2) * (number("bending") / number("mass")).sqrt());
    assert!((period / beam - 1.0).abs() < 0.01, "{period} {beam}");
}

fn thrown(n: usize) -> (Curve, Vec<Vector>) {
    let rope = line(3, n, [0.0; 3], [3.0, 0.0, 0.0]);
    let turn = |i: usize| f64::from(i as u32);
    let velocities = (0..n)
        .map(|i| Vector::new((0.7 * turn(i)).sin(), (0.4 * turn(i)).cos(), (0.2 * turn(i)).sin()))
        .collect();
    (rope, velocities)
}

#[test]
fn momentum_and_energy_stay() {
    let (rope, velocities) = thrown(20);
    for scheme in [Scheme::Exact, Scheme::Epsilon] {
        let body = Body::new(&rope).mass(0.5).stiffness(200.0).bending(0.01).moving(velocities.clone());
        let mut simulation = Setup::new(body).scheme(scheme).prepare().unwrap();
        // Mass of each vertex: what a unit of gravity pulls at it.
        let momentum = |s: &Simulation| {
            let weights = mass_of(&rope, 0.5);
            let v = s.velocities(0).unwrap();
            weights.iter().zip(&v).fold(Vector::zeros(), |sum, (m, v)| sum + v * *m)
        };
        let (before, energy) = (momentum(&simulation), simulation.energy().total());
        let mut most = 0.0_f64;
        for _ in 0..200 {
            simulation.advance(0.01).unwrap();
            most = most.max((simulation.energy().total() / energy - 1.0).abs());
        }
        let drift = (momentum(&simulation) - before).norm() / before.norm();
        assert!(drift < 1e-10, "{drift}");
        assert!(most < 0.01, "{most}");
    }
}

/// What is held changes its momentum by the forces of its constraints and its weight, and by nothing else: step by step, with a nail and a ring that slides.
#[test]
fn constraints_give_the_momentum_that_they_say() {
    let (rope, velocities) = thrown(12);
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        let gravity = Vector::new(0.0, 0.0, -9.81);
        let body = Body::new(&rope).mass(0.5).stiffness(50.0).moving(velocities.clone());
        let mut simulation = Setup::new(body)
            .gravity(gravity)
            .hold(fixed(0.0))
            .hold(sliding(5.2))
            .scheme(scheme)
            .draw(0.01)
            .prepare()
            .unwrap();
        let weights = mass_of(&rope, 0.5);
        let whole: f64 = weights.iter().sum();
        let momentum = |s: &Simulation| {
            let v = s.velocities(0).unwrap();
            weights.iter().zip(&v).fold(Vector::zeros(), |sum, (m, v)| sum + v * *m)
        };
        let (step, mut given) = (1e-5, Vector::zeros());
        let before = momentum(&simulation);
        let mut pushed = 0.0;
        for _ in 0..20_000 {
            simulation.step(step).unwrap();
            given += gravity * (whole * step);
            for constraint in 0..2 {
                let force = simulation.force_of(constraint).unwrap();
                let force = Vector::new(force[0], force[1], force[2]);
                pushed += force.norm() * step;
                given += force * step;
            }
        }
        let off = (momentum(&simulation) - before - given).norm();
        // Half a step at both ends, of forces of some hundred times the weight.
        assert!(pushed > 0.5, "{scheme:?}: they hold it: {pushed}");
        assert!(off < 2e-3 * pushed, "{scheme:?}: {off} of {pushed}");
    }
}

/// A rod that is held at one end and stretched along itself swings as `cos ωt`, `ω² = 3 k/(m L²)` of a rod of one span: explicit steps miss that by their square, implicit
/// ones by themselves.
#[test]
fn steps_come_to_the_closed_form_by_their_order() {
    let (mass, stiffness, length, stretch): (f64, f64, f64, f64) = (0.7, 40.0, 1.5, 0.2);
    let omega = (3.0 * stiffness / (mass * length * length)).sqrt();
    // Neither where it turns nor where it is as at rest: amplitude and time both tell.
    let end = 0.62;
    let exact = length + length * stretch * (omega * end).cos();
    let run = |scheme: Scheme, step: f64| {
        // As long as it is stretched at the start: its rest is the shorter length.
        let rod = line(1, 2, [0.0; 3], [length * (1.0 + stretch), 0.0, 0.0]);
        let share = 1.0 / (1.0 + stretch);
        let body = Body::new(&rod).mass(mass * share).stiffness(stiffness).rest(share);
        let mut simulation = Setup::new(body).hold(fixed(0.0)).scheme(scheme).prepare().unwrap();
        let steps = (end / step).round() as usize;
        (0..steps).for_each(|_| simulation.step(step).unwrap());
        (simulation.shape(0).unwrap().control_vertices()[1].x - exact).abs()
    };
    for (scheme, order) in [(Scheme::Exact, 2.0), (Scheme::Epsilon, 2.0), (Scheme::Implicit, 1.0)] {
        let [coarse, fine] = [1600.0, 3200.0].map(|steps| run(scheme, end / steps));
        let found = (coarse / fine).log2();
        assert!((found - order).abs() < 0.1, "{scheme:?}: {coarse} {fine}, order {found}");
        assert!(fine < if order > 1.5 { 1e-5 } else { 1e-2 } * length, "{scheme:?}: {fine}");
    }
}

/// What hangs on a nail pulls at it with its mass times its length, however jagged it is.
#[test]
fn a_jagged_rope_weighs_its_length() {
    for degree in [2, 3, 6] {
        let n = degree + 4;
        let points = (0..n).map(|i| {
            let i = i as f64;
            Point::new((5.3 * i).sin(), (7.1 * i).cos(), 0.4 * (3.7 * i).sin())
        });
        let rope = Curve::new(Space::clamped_uniform(degree, n).unwrap(), points.collect()).unwrap();
        let (a, b) = rope.space().domain();
        let parts = 200_000;
        let at = |i: usize| rope.point(a + (b - a) * i as f64 / parts as f64).unwrap();
        let length: f64 = (0..parts).map(|i| (at(i + 1) - at(i)).norm()).sum();
        let mut simulation = Setup::new(Body::new(&rope).mass(0.3).stiffness(1000.0))
            .gravity([0.0, 0.0, -9.81])
            .hold(fixed(a))
            .scheme(Scheme::Implicit)
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{degree}: {settled:?}");
        let weight = simulation.force_of(0).unwrap()[2];
        assert!((weight / (0.3 * 9.81 * length) - 1.0).abs() < 1e-6, "{degree}: {weight} of {length}");
    }
}

/// `∫ m b_i`, by the knots: `m |P'| (t_{i+p+1} - t_i)/(p+1)` of a line of constant speed.
fn mass_of(curve: &Curve, mass: f64) -> Vec<f64> {
    let space = curve.space();
    let (p, flat) = (space.degree(), space.flat());
    let speed = curve.derivative(0.5, 1).unwrap().norm();
    (0..space.len()).map(|i| mass * speed * (flat[i + p + 1] - flat[i]) / (p + 1) as f64).collect()
}

#[test]
fn steps_are_of_second_order_and_implicit_ones_of_first() {
    let run = |scheme: Scheme, step: f64| {
        let (rope, velocities) = thrown(8);
        let body = Body::new(&rope).mass(0.5).stiffness(20.0).rest(0.8).moving(velocities);
        let mut simulation = Setup::new(body)
            .gravity([0.0, 0.0, -9.81])
            .hold(fixed(0.0))
            .hold(sliding(3.1))
            .scheme(scheme)
            .step(step)
            .draw(0.02)
            .prepare()
            .unwrap();
        while simulation.time() < 0.5 - 1e-9 {
            simulation.step(step).unwrap();
        }
        simulation.shape(0).unwrap().control_vertices().to_vec()
    };
    let apart = |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let all = [
        (Scheme::Exact, 2.0, 1.0 / 800.0),
        (Scheme::Epsilon, 2.0, 1.0 / 800.0),
        (Scheme::Implicit, 1.0, 1.0 / 6400.0),
    ];
    for (scheme, order, h) in all {
        let best = run(scheme, h / 16.0);
        let (coarse, fine) = (apart(&run(scheme, h), &best), apart(&run(scheme, h / 2.0), &best));
        let found = (coarse / fine).log2();
        assert!((found - order).abs() < 0.35, "{scheme:?}: {coarse} {fine}, order {found}");
    }
}

#[test]
fn a_small_mass_of_parameters_is_none() {
    let run = |scheme: Scheme, epsilon: f64| {
        let rope = line(3, 16, [0.0; 3], [4.0, 0.0, 0.0]);
        let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(80.0).damping(0.5))
            .gravity([0.0, 0.0, -9.81])
            .hold(fixed(0.0))
            .hold(sliding(6.0))
            .scheme(scheme)
            .epsilon(epsilon)
            .prepare()
            .unwrap();
        for _ in 0..50 {
            simulation.advance(0.01).unwrap();
        }
        simulation.shape(0).unwrap().control_vertices().to_vec()
    };
    let exact = run(Scheme::Exact, 1.0);
    let off =
        |e: f64| run(Scheme::Epsilon, e).iter().zip(&exact).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let all = [off(1e-1), off(1e-2), off(1e-3), off(1e-5)];
    assert!(all[0] > all[1] && all[1] > all[2] && all[3] < 1e-3 * all[0].max(1e-2), "{all:?}");
}

/// A stiff rope, 24 steps a second: explicit steps would be a thousand times shorter.
#[test]
fn implicit_steps_are_stable() {
    let rope = line(3, 40, [0.0; 3], [4.0, 0.0, 0.0]);
    let mut simulation = Setup::new(Body::new(&rope).mass(0.05).stiffness(1e6).bending(1e-3))
        .gravity([0.0, 0.0, -9.81])
        .hold(fixed(0.0))
        .hold(sliding(10.0))
        .scheme(Scheme::Implicit)
        .prepare()
        .unwrap();
    let stable = simulation.stable_step();
    assert!(stable < 1.0 / 24.0 / 1000.0, "{stable}");
    let before = simulation.energy().total();
    let mut last = before;
    for _ in 0..96 {
        simulation.advance(1.0 / 24.0).unwrap();
        let now = simulation.energy().total();
        // It takes energy out, and never puts any in (rounding of a stiffness of 1e6 aside).
        assert!(now <= last + 1e-6 * before.abs().max(1.0), "{} s: {last} → {now}", simulation.time());
        last = now;
        let errors = simulation.errors().unwrap();
        assert!(errors.iter().all(|e| *e < 1e-6 * 4.0), "{errors:?}");
    }
}
