//! Places that slide: on surfaces, on two shapes at once, with derivatives; and the forces with which they hold.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{
    Body, Scheme, Setup, Simulation, Spot, double_sliding, fixed, force, pull, sliding, sliding_curvature,
    sliding_tangent, tied,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::json;

use crate::common::{line, run};

/// `z = (x² + y²)/2R` over a square, exactly, its parameters from 0 to 1; and where a point of it is.
fn bowl(radius: f64, reach: f64) -> (Surface, impl Fn(f64, f64) -> [f64; 2]) {
    let space = || Space::clamped_uniform(2, 3).unwrap();
    // x = reach (2u - 1) has the control values -1, 0, 1; its square 1, -1, 1.
    let (x, square) = ([-reach, 0.0, reach], [1.0, -1.0, 1.0]);
    let lift = reach * reach / (2.0 * radius);
    let points = (0..9).map(|k| {
        let (i, j) = (k / 3, k % 3);
        Point::new(x[i], x[j], lift * (square[i] + square[j]))
    });
    let end = space().domain().1;
    let surface = Surface::new(space(), space(), points.collect()).unwrap();
    (surface, move |x, y| [x, y].map(|x| 0.5 * (x / reach + 1.0) * end))
}

fn middle(simulation: &Simulation) -> Vector {
    simulation.shape(0).unwrap().value(0.5.into(), Derivative::POSITION).unwrap()
}

/// A bead on a paraboloid: at any height it goes round with `ω = √(g/R)`, on a level circle.
#[test]
fn a_bead_goes_round_in_a_bowl_at_its_height() {
    let (radius, g, start) = (2.0, 9.81, 0.8);
    let (surface, at) = bowl(radius, 2.0);
    let omega = f64::sqrt(g / radius);
    let height = start * start / (2.0 * radius);
    for scheme in [Scheme::Exact, Scheme::Epsilon] {
        let bead = line(1, 2, [start, 0.0, height - 1e-4], [start, 0.0, height + 1e-4]);
        let speed = vec![Vector::new(0.0, omega * start, 0.0); 2];
        let mut simulation = Setup::new(Body::new(&bead).stiffness(1.0).moving(speed))
            .and(Body::new(&surface).still())
            .gravity([0.0, 0.0, -g])
            .hold(tied(Spot::at(0, 0.5), Spot::near(1, at(start, 0.0))))
            .draw(0.005)
            .epsilon(1e-7)
            .scheme(scheme)
            .prepare()
            .unwrap();
        let period = std::f64::consts::TAU / omega;
        let steps = 4000;
        for k in 1..=steps {
            simulation.advance(period / f64::from(steps)).unwrap();
            let p = middle(&simulation);
            // It stays on the bowl, at its height, on its circle, and is where it should be: from the start, for its parameters start with
            // the speed that it has.
            let off = p.z - (p.x * p.x + p.y * p.y) / (2.0 * radius);
            assert!(off.abs() < 1e-6 * 4.0, "{scheme:?}: off the bowl by {off:e}");
            assert!((p.z - height).abs() < 1e-3 * height, "{scheme:?}: {} for {height}", p.z);
            let angle = omega * simulation.time();
            let wanted = Vector::new(start * angle.cos(), start * angle.sin(), height);
            assert!((p - wanted).norm() < 2e-3 * start, "{scheme:?} at {k}: {p} for {wanted}");
            let [_, Location::Surface(u, v)] = simulation.locations(0).unwrap()[..] else {
                panic!("a place")
            };
            let [x, y] = at(p.x, p.y);
            assert!((u - x).abs() + (v - y).abs() < 1e-5, "{scheme:?}: [{u}, {v}] for [{x}, {y}]");
        }
    }
}

/// A bead on a slope of a plane, both parameters free: it goes down the steepest way by `½ g sin(α) t²`, and on along the level by what it has.
#[test]
fn a_bead_slides_down_a_plane() {
    let (a, b) = (Vector::new(3.0, 0.0, -4.0), Vector::new(0.0, 5.0, 0.0));
    let space = || Space::clamped_uniform(3, 6).unwrap();
    let end = space().domain().1;
    let points = (0..36).map(|k| {
        let share = |i: usize| space().greville(i) / end * 4.0;
        Point::from(a * share(k / 6) + b * share(k % 6))
    });
    let plane = Surface::new(space(), space(), points.collect()).unwrap();
    let from = a * 0.4 + b * 0.8;
    for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
        let across = Vector::new(0.8, 0.0, 0.6) * 1e-3;
        let bead = line(1, 2, (from - across).into(), (from + across).into());
        let speed = vec![Vector::new(0.0, 2.0, 0.0); 2];
        let mut simulation = Setup::new(Body::new(&bead).stiffness(1.0).moving(speed))
            .and(Body::new(&plane).still())
            .gravity([0.0, 0.0, -9.81])
            .hold(tied(Spot::at(0, 0.5), Spot::near(1, [0.1 * end, 0.2 * end])))
            .epsilon(1e-7)
            .scheme(scheme)
            .prepare()
            .unwrap();
        for _ in 0..1000 {
            simulation.advance(1e-3).unwrap();
        }
        let way = 0.5 * 9.81 * 0.8;
        let wanted = from + a / 5.0 * way + Vector::y() * 2.0;
        let found = middle(&simulation);
        // Backward Euler is of first order.
        let near = if scheme == Scheme::Implicit { 2e-3 } else { 1e-6 };
        assert!((found - wanted).norm() < near * way, "{scheme:?}: {found} for {wanted}");
        let off = found.dot(&Vector::new(0.8, 0.0, 0.6));
        assert!(off.abs() < 1e-8, "{scheme:?}: off the plane by {off:e}");
    }
}

/// Two strings that hook each other, both places floating: the force between them is across both, and each is stretched alike on both sides.
#[test]
fn two_strings_slide_on_each_other() {
    let (n, degree) = (41, 3);
    let one = line(degree, n, [-1.0, 0.2, 0.0], [2.0, 0.0, 0.0]);
    let other = line(degree, n, [0.4, -1.0, 0.0], [0.4, 1.0, 0.0]);
    let end = one.space().domain().1;
    // They cross at x = 0.4; the second is lifted at its ends.
    let share = 1.4 / 3.0;
    let y = 0.2 * (1.0 - share);
    let body = |curve: &Curve| Body::new(curve).mass(0.1).stiffness(50.0).rest(0.9).damping(3.0);
    for scheme in [Scheme::Exact, Scheme::Implicit] {
        let mut simulation = Setup::new(body(&one))
            .and(body(&other))
            .hold(tied(Spot::near(0, share * end), Spot::near(1, 0.5 * (1.0 + y) * end)))
            .hold(fixed(0.0))
            .hold(fixed(end))
            .hold(fixed(0.0).on(1).to([0.7, -1.0, 0.8]))
            .hold(fixed(end).on(1).to([1.0, 1.2, 0.8]))
            .scheme(scheme)
            .prepare()
            .unwrap();
        for _ in 0..240 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        let [Location::Curve(u), Location::Curve(v)] = simulation.locations(0).unwrap()[..] else {
            panic!("two places")
        };
        assert!((u / end - share).abs() > 0.03, "the first does not slide: {u}");
        assert!((v / end - 0.5 * (1.0 + y)).abs() > 0.01, "the second does not slide: {v}");
        let value = |body: usize, u: f64, order: usize| {
            simulation.shape(body).unwrap().value(u.into(), Derivative::from(order)).unwrap()
        };
        let apart = (value(0, u, 0) - value(1, v, 0)).norm();
        assert!(apart < 1e-6, "{scheme:?}: {apart:e} apart");
        let force = Vector::from_column_slice(simulation.force_of(0).unwrap());
        assert!(force.norm() > 1.0, "they hook: {force}");
        for (body, at) in [(0, u), (1, v)] {
            let tangent = value(body, at, 1);
            let along = force.dot(&tangent) / (force.norm() * tangent.norm());
            assert!(along.abs() < 1e-3, "{scheme:?}: string {body} is pulled along itself: {along}");
            let stretch = |u: f64| value(body, u, 1).norm();
            let (left, right) = (stretch(0.5 * at), stretch(0.5 * (at + end)));
            assert!((left / right - 1.0).abs() < 0.01, "{scheme:?} {body}: {left} {right}");
        }
    }
}

/// After the transient (twenty time constants) a tangent and a curvature that slide are what was asked, at each frame while the rope swings.
#[test]
fn sliding_derivatives_hold_their_vectors() {
    for (order, scheme) in [
        (1, Scheme::Exact),
        (1, Scheme::Epsilon),
        (1, Scheme::Implicit),
        (2, Scheme::Exact),
        (2, Scheme::Implicit),
    ] {
        let rope = {
            let flat = line(3, 16, [0.0; 3], [4.0, 0.0, 0.0]);
            let bent = flat.points().iter().map(|p| Point::new(p.x, 0.0, 0.3 * (1.5 * p.x).sin()));
            Curve::new(flat.space().clone(), bent.collect()).unwrap()
        };
        let near = 6.3;
        let now = rope.derivative(near, order).unwrap();
        let vector = now + Vector::new(0.02, 0.03, -0.04) * now.norm();
        let own = if order == 1 { sliding_tangent(near, vector) } else { sliding_curvature(near, vector) };
        let mut simulation =
            Setup::new(Body::new(&rope).mass(0.2).stiffness(80.0).bending(0.05).damping(0.5))
                .gravity([0.0, 0.0, -9.81])
                .hold(fixed(0.0))
                .hold(own)
                .scheme(scheme)
                .prepare()
                .unwrap();
        let mut moved = 0.0_f64;
        // Later it hangs on the steps where it goes: it passes places where the derivative hardly turns along the curve.
        for frame in 0..36 {
            simulation.advance(1.0 / 24.0).unwrap();
            if frame < 24 {
                continue;
            }
            assert!(simulation.holds(1).unwrap(), "{order} {scheme:?}: it let go: {:?}", simulation.events());
            let at = simulation.locations(1).unwrap()[0];
            let found = simulation.shape(0).unwrap().value(at, Derivative::from(order)).unwrap();
            // As all constraints: to 1e-6 of the size.
            let off = (found - vector).norm();
            assert!(off < 1e-6 * 4.0, "{order} {scheme:?}: off by {off:e} at {at}");
            let Location::Curve(u) = at else { panic!("a curve") };
            moved = moved.max((u - near).abs());
        }
        assert!(moved > 1e-3, "{order} {scheme:?}: it does not slide");
    }
}

/// What hangs on nails and rings: the multipliers together are the weight, those of a ring point across its rope, and a ring between two nails
/// carries what the catenaries on both sides of it do: half of the weight where it is in the middle of level nails.
#[test]
fn what_slides_carries_its_share_of_the_weight() {
    // Taut ropes: of a slack one the longer side would draw all of it through the ring.
    let mut shares = Vec::new();
    for (n, share, lifted) in [(61, 0.5, 0.0), (121, 0.5, 0.0), (61, 0.5, 0.4), (61, 0.37, 0.2)] {
        let (length, mass, g) = (6.0, 0.3, 9.81);
        let rope = line(3, n, [0.0; 3], [length, 0.0, 0.0]);
        let end = rope.space().domain().1;
        let body = Body::new(&rope).mass(mass).stiffness(500.0).damping(1.0);
        let mut simulation = Setup::new(body)
            .gravity([0.0, 0.0, -g])
            .hold(fixed(0.0))
            .hold(sliding(share * end).to([share * 6.3, 0.0, lifted]))
            .hold(fixed(end).to([6.3, 0.0, 0.0]))
            .scheme(Scheme::Implicit)
            .prepare()
            .unwrap();
        for _ in 0..72 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        let settled = simulation.settle_without_corners().unwrap();
        assert!(settled.rests, "{share} {lifted}: {settled:?}");
        let force = |k: usize| Vector::from_column_slice(simulation.force_of(k).unwrap());
        let [left, ring, right] = [0, 1, 2].map(force);
        let weight = mass * g * length;
        let sum = left + ring + right - Vector::z() * weight;
        assert!(sum.norm() < 1e-6 * weight, "{share} {lifted}: {sum}");
        let Location::Curve(u) = simulation.locations(1).unwrap()[0] else { panic!("a curve") };
        let tangent = simulation.shape(0).unwrap().value(u.into(), Derivative::from(1)).unwrap();
        let along = ring.dot(&tangent) / (ring.norm() * tangent.norm());
        assert!(along.abs() < 1e-3, "{share} {lifted}: {along}");
        if share == 0.5 {
            // Alike on both sides, by symmetry.
            assert!((u - 0.5 * end).abs() < 1e-3 * end && ring.x.abs() < 1e-3 * weight, "{u} {ring}");
            assert!((left.z - right.z).abs() < 1e-3 * weight, "{left} {right}");
        }
        if (share, lifted) == (0.5, 0.0) {
            shares.push(ring.z / weight - 0.5);
        }
    }
    // A cubic does not kink at its ring: what it carries too much is of the order of a span.
    assert!(shares[0].abs() < 7e-3 && shares[1].abs() < 0.6 * shares[0].abs(), "{shares:?}");
}

/// A loop through which the rope slides both ways: both its parameters are told, and both are one point.
#[test]
fn both_places_of_a_loop_are_told() {
    let space = Space::clamped_uniform(3, 24).unwrap();
    let end = space.domain().1;
    let at = |s: f64| Point::new(4.0 * s - (9.0 * s).sin(), 0.0, -1.5 * (9.0 * s).cos());
    let points = (0..24).map(|i| at(space.greville(i) / end)).collect();
    let rope = Curve::new(space, points).unwrap();
    // Where it crosses itself.
    let (mut best, mut crossing) = (f64::INFINITY, [0.0; 2]);
    for i in 0..400 {
        for j in i + 60..400 {
            let [a, b] = [i, j].map(|k| f64::from(k) / 400.0 * end);
            let apart = (rope.point(a).unwrap() - rope.point(b).unwrap()).norm();
            if apart < best {
                (best, crossing) = (apart, [a, b]);
            }
        }
    }
    assert!(best < 0.1, "{best}");
    let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(60.0).bending(0.05).damping(1.0))
        .gravity([0.0, 0.0, -9.81])
        .hold(fixed(0.0))
        .hold(fixed(end))
        .hold(double_sliding(crossing))
        .scheme(Scheme::Implicit)
        .step(0.005)
        .prepare()
        .unwrap();
    for _ in 0..48 {
        simulation.advance(1.0 / 24.0).unwrap();
    }
    assert!(simulation.slides(2).unwrap() && !simulation.slides(0).unwrap());
    let [Location::Curve(a), Location::Curve(b)] = simulation.locations(2).unwrap()[..] else {
        panic!("two")
    };
    assert!((a - crossing[0]).abs() > 1e-2 && (b - crossing[1]).abs() > 1e-2, "{a} {b} {crossing:?}");
    let shape = simulation.shape(0).unwrap();
    let point = |u: f64| shape.value(u.into(), Derivative::POSITION).unwrap();
    assert!((point(a) - point(b)).norm() < 1e-6, "{a} {b}");
}

/// A rope on a sheet, both of whose places float: it goes through it where it crosses it, and is refused where it lies along it, for nothing tells then where
/// they meet; before, that made energy of nothing.
#[test]
fn a_rope_along_a_sheet_is_refused() {
    let side = Space::clamped_uniform(3, 7).unwrap();
    let end = side.domain().1;
    let points = (0..49).map(|k| {
        let [x, y] = [k / 7, k % 7].map(|i| side.greville(i) / end * 3.0);
        Point::new(x, y - 1.5, 0.0)
    });
    let sheet = Surface::new(side.clone(), side.clone(), points.collect()).unwrap();
    for (tilt, refused) in [
        (1.0, false),
        (0.3, false),
        (0.1, false),
        (0.03, false),
        (0.009, true),
        (1e-3, true),
        (1e-5, true),
        (0.0, true),
    ] {
        for still in [true, false] {
            for scheme in [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit] {
                let rope = line(3, 12, [0.4, 0.0, -tilt], [2.4, 0.2, tilt]);
                let middle = 0.5 * rope.space().domain().1;
                let body = Body::new(&sheet).mass(0.2).stiffness(100.0);
                let at = [1.4 / 3.0 * end, 1.6 / 3.0 * end];
                let setup = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
                    .and(if still { body.still() } else { body })
                    .hold(tied(Spot::near(0, middle), Spot::near(1, at)).called("ring"))
                    .hold(fixed(0.0))
                    .gravity([0.0, 0.0, -9.81])
                    .scheme(scheme);
                let what = format!("{tilt} {still} {scheme:?}");
                let mut simulation = match setup.prepare() {
                    Ok(simulation) if !refused => simulation,
                    Err(error) if refused => {
                        let told = error.to_string();
                        assert!(told.contains("\"ring\"") && told.contains("lies along"), "{what}: {told}");
                        continue;
                    }
                    other => panic!("{what}: {:?}", other.map(|_| ())),
                };
                // It goes on, or is told later to lie along; energy does not come of nothing.
                let before = simulation.energy().total();
                for _ in 0..12 {
                    match simulation.advance(1.0 / 48.0) {
                        Ok(()) => {}
                        Err(error) => {
                            assert!(error.to_string().contains("lies along"), "{what}: {error}");
                            break;
                        }
                    }
                    let now = simulation.energy().total();
                    assert!(now < before + 0.02, "{what}: {before} → {now}");
                }
            }
        }
    }
}

/// A rope without weight through a ring at which it turns: both sides are stretched alike to half a span of the shorter sides, and to 1.1 % with 200
/// vertices, whatever it turns by and wherever the ring was put at first; the energy is above that of the two straight sides by what the turn costs, and the same from everywhere.
#[test]
fn both_sides_of_a_ring_are_stretched_alike() {
    for degree in [1, 2, 3, 5] {
        for n in [20, 60, if degree == 2 { 200 } else { 100 }] {
            for turn in [0.0_f64, 60.0, 110.0, 150.0] {
                let (sine, cosine) = turn.to_radians().sin_cos();
                let mut found: Option<f64> = None;
                for near in [0.2, 0.5] {
                    let space = Space::clamped_uniform(degree, n).unwrap();
                    let end = space.domain().1;
                    let points =
                        (0..n).map(|i| Point::new(10.0 * space.greville(i) / end, 0.0, 0.0)).collect();
                    let rope = Curve::new(space, points).unwrap();
                    let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
                        .hold(fixed(0.0))
                        .hold(fixed(end).to([4.0 + 8.0 * cosine, 0.0, 8.0 * sine]))
                        .hold(sliding(near * end).to([4.0, 0.0, 0.0]))
                        .prepare()
                        .unwrap();
                    let settled = simulation.settle_without_corners().unwrap();
                    let what = format!("degree {degree}, {n} vertices, by {turn}°, from {near}: {settled:?}");
                    assert!(settled.rests, "{what}");
                    let [behind, ahead] = simulation.side_stretches(2).unwrap()[0];
                    let apart = ((1.0 + behind) / (1.0 + ahead) - 1.0).abs();
                    let Location::Curve(at) = simulation.locations(2).unwrap()[0] else { panic!("{what}") };
                    let half = 0.5 / at + 0.5 / (end - at);
                    assert!(apart <= half, "{what}: {behind} {ahead}, half a span is {half}");
                    // What it is, for few vertices, some and many; by 60° and less it is under 1 %, but of polylines, whose ring comes to a vertex.
                    let most = match degree {
                        1 => [0.0834, 0.0251, 1e-8],
                        2 => [0.079, 0.0103, 0.0105],
                        3 => [0.042, 0.003, 0.0154],
                        _ => [0.002, 0.017, 0.0095],
                    }[usize::from(n > 20) + usize::from(n > 60)];
                    let bound = match turn {
                        0.0 => 1e-8,
                        60.0 if degree > 1 => 0.0091,
                        _ => most,
                    };
                    assert!(apart < bound, "{what}: {behind} {ahead}");
                    // The rope of two straight sides: 12 long instead of 10.
                    let energy = simulation.energy().elastic / 20.0;
                    assert!(energy > 1.0 - 1e-9 && (turn > 0.0 || energy < 1.0 + 1e-9), "{what}: {energy}");
                    let before = *found.get_or_insert(energy);
                    assert!((energy - before).abs() < 1e-5 * before, "{what}: {energy} {before}");
                }
            }
        }
    }
}

/// Whatever the degree, the number of vertices and the turn, both sides pull alike along the rope at the ring, where its tangent is: what holds the ends, seen
/// along it, is the same to 1e-6, so that nothing is left to draw it through. Their tensions are the same where the rope goes straight on, or the ring is in the middle;
/// else to what half a span is, since the tangent within a span is not half way between the sides.
#[test]
fn both_sides_of_a_ring_pull_alike() {
    let mut turned = 0;
    for degree in [2, 3, 4, 5, 7] {
        for n in [12, 20, 40] {
            for turn in [0.0_f64, 60.0, 110.0, 150.0] {
                for share in [0.25, 0.4, 0.5] {
                    let (sine, cosine) = turn.to_radians().sin_cos();
                    let space = Space::clamped_uniform(degree, n).unwrap();
                    let end = space.domain().1;
                    let at = |i: usize| Point::new(10.0 * space.greville(i) / end, 0.0, 0.0);
                    let rope = Curve::new(space.clone(), (0..n).map(at).collect()).unwrap();
                    let (behind, ahead) = (12.0 * share, 12.0 * (1.0 - share));
                    let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
                        .hold(fixed(0.0))
                        .hold(fixed(end).to([behind + ahead * cosine, 0.0, ahead * sine]))
                        .hold(sliding(share * end).to([behind, 0.0, 0.0]))
                        .prepare()
                        .unwrap();
                    let settled = simulation.settle_without_corners().unwrap();
                    let what = format!("degree {degree}, {n} vertices, by {turn}°, at {share}: {settled:?}");
                    assert!(settled.rests, "{what}");
                    let place = simulation.locations(2).unwrap()[0];
                    let tangent =
                        simulation.shape(0).unwrap().value(place, Derivative::from(1)).unwrap().normalize();
                    let pulls = [0, 1].map(|k| Vector::from_column_slice(simulation.force_of(k).unwrap()));
                    let along = pulls.map(|pull| pull.dot(&tangent));
                    // The ends are held away from the ring.
                    assert!(along[0] < 0.0 && along[1] > 0.0, "{what}: {along:?}");
                    assert!((along[0] + along[1]).abs() < 1e-6 * 100.0, "{what}: {along:?}");
                    let tensions = pulls.map(|pull| pull.norm());
                    let Location::Curve(u) = place else { panic!("{what}") };
                    let half = 0.5 / u + 0.5 / (end - u);
                    let most = match degree {
                        2 => [0.122, 0.087, 0.047],
                        3 => [0.087, 0.059, 0.039],
                        4 => [0.042, 0.036, 0.031],
                        5 => [0.027, 0.017, 0.021],
                        _ => [0.009, 0.0193, 0.013],
                    }[usize::from(n > 12) + usize::from(n > 20)];
                    let bound = match turn {
                        0.0 => 1e-8,
                        60.0 => 0.017,
                        _ => half.min(most),
                    };
                    let apart = ((100.0 + tensions[0]) / (100.0 + tensions[1]) - 1.0).abs();
                    assert!(apart <= bound, "{what}: {tensions:?}, half a span is {half}");
                    turned += usize::from(turn > 0.0);
                }
            }
        }
    }
    assert!(turned > 100);
}

/// A side ends where a force or a pull acts: what is beyond has another tension. Straight ropes, so that nothing turns.
#[test]
fn sides_end_where_something_acts() {
    for degree in 1..=5 {
        for pulled in [false, true] {
            let rope = line(degree, 30, [0.0; 3], [10.0, 0.0, 0.0]);
            let end = rope.space().domain().1;
            let setup = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
                .hold(fixed(0.0))
                .hold(fixed(end).to([12.0, 0.0, 0.0]))
                .hold(sliding(0.4 * end));
            let setup = if pulled {
                setup.pull(pull(0.7 * end, [11.0, 0.0, 0.0], 20.0))
            } else {
                setup.push(force(0.7 * end, [30.0, 0.0, 0.0]))
            };
            let mut simulation = setup.prepare().unwrap();
            assert!(simulation.settle_without_corners().unwrap().rests);
            let [behind, ahead] = simulation.side_stretches(2).unwrap()[0];
            let what = format!("degree {degree}, pulled: {pulled}: {behind} {ahead}");
            // The rope is not kinked by a force at a point but over a span or two.
            assert!((behind - ahead).abs() < 0.02 * behind, "{what}");
            // Beyond it is less taut: the nails differ by the force.
            let forces = [0, 1].map(|k| simulation.force_of(k).unwrap()[0]);
            assert!(-forces[0] > forces[1] + 5.0, "{what}: {forces:?}");
            assert!((behind + forces[0] / 100.0).abs() < 1e-3, "{what}: {forces:?}");
        }
    }
}

/// A fixed point in the place of the ring keeps the sides as they are.
#[test]
fn both_sides_of_a_fixed_point_differ() {
    let space = Space::clamped_uniform(3, 60).unwrap();
    let end = space.domain().1;
    let points = (0..60).map(|i| Point::new(10.0 * space.greville(i) / end, 0.0, 0.0)).collect();
    let rope = Curve::new(space, points).unwrap();
    for slides in [false, true] {
        let held = if slides { sliding(0.2 * end) } else { fixed(0.2 * end) };
        let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
            .hold(fixed(0.0))
            .hold(fixed(end).to([4.0, 0.0, 8.0]))
            .hold(held.to([4.0, 0.0, 0.0]))
            .prepare()
            .unwrap();
        assert!(simulation.settle_without_corners().unwrap().rests);
        let sides = simulation.side_stretches(2).unwrap();
        assert_eq!(sides.len(), usize::from(slides));
        let middle = |share: f64| {
            let shape = simulation.shape(0).unwrap();
            shape.value((share * end).into(), Derivative { u: 1, v: 0 }).unwrap().norm() * end / 10.0
        };
        // 4 instead of 2 and 8 instead of 8; or 12 instead of 10 on both sides.
        let wanted = if slides { [1.2, 1.2] } else { [2.0, 1.0] };
        assert!((middle(0.1) / wanted[0] - 1.0).abs() < 0.02, "{} {slides}", middle(0.1));
        assert!((middle(0.6) / wanted[1] - 1.0).abs() < 0.02, "{} {slides}", middle(0.6));
        for stretch in sides.iter().flatten() {
            assert!((stretch - 0.2).abs() < 0.01, "{sides:?}");
        }
    }
}

/// A sheet that passes itself somewhere along a line, both places sliding: as a recipe says it, `near` two pairs.
#[test]
fn a_sheet_passes_itself() {
    for degree in 2..=4 {
        let side = Space::clamped_uniform(degree, 12).unwrap();
        let across = Space::clamped_uniform(degree, 6).unwrap();
        let [end, top] = [&side, &across].map(|space| space.domain().1);
        let at = |s: f64, t: f64| Point::new(4.0 * s - 1.3 * (9.0 * s).sin(), t, -1.5 * (9.0 * s).cos());
        let points = (0..72).map(|k| at(side.greville(k / 6) / end, across.greville(k % 6) / top));
        let sheet = Surface::new(side.clone(), across.clone(), points.collect()).unwrap();
        let middle = |u: f64| sheet.point(u, 0.5 * top).unwrap();
        let (mut best, mut crossing) = (f64::INFINITY, [0.0; 2]);
        for i in 0..200 {
            for j in i + 40..200 {
                let [a, b] = [i, j].map(|k| f64::from(k) / 200.0 * end);
                let apart = (middle(a) - middle(b)).norm();
                if apart < best {
                    (best, crossing) = (apart, [a, b]);
                }
            }
        }
        assert!(best < 0.1, "{best}");
        let mut scene = Scene::new();
        scene.add(Object::new("sheet", Geometry::Surface(sheet))).unwrap();
        let fixed = |u: f64, v: f64| json!({ "kind": "fixed", "at": [u, v] });
        let near = crossing.map(|u| [u, 0.5 * top]);
        let report = run(
            &mut scene,
            json!({ "seconds": 1.5, "mass": 0.1, "stiffness": 60, "damping": 1, "scheme": "implicit",
                "constraints": [fixed(0.0, 0.0), fixed(0.0, top), fixed(end, 0.0), fixed(end, top),
                    { "kind": "double-sliding", "near": near, "name": "loop" }] }),
        )
        .unwrap();
        let places =
            report.constraints.iter().find(|found| found.name == "loop").unwrap().location.clone().unwrap();
        let [a, b, c, d] = places[..] else { panic!("{places:?}") };
        let Geometry::Surface(sheet) = scene.object("sheet").unwrap().geometry() else { panic!("a surface") };
        let [one, other] = [sheet.point(a, b).unwrap(), sheet.point(c, d).unwrap()];
        assert!((one - other).norm() < 1e-6, "degree {degree}: {one} {other}");
        assert!((a - c).abs() > 0.1 * end, "two places: {places:?}");
        let wrong = json!({ "seconds": 0.5, "constraints": [{ "kind": "double-sliding", "near": [0.5] }] });
        let error = run(&mut scene, wrong).unwrap_err().to_string();
        assert!(error.contains("constraints[0].near") && error.contains("two locations"), "{error}");
    }
}
