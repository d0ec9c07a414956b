//! What is slack at first, pushed together or led through rings: it comes to rest where nothing leads farther down, in few steps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Settled, Setup, Simulation, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

fn line(degree: usize, n: usize, length: f64) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let end = space.domain().1;
    let points = (0..n).map(|i| Point::new(length * space.greville(i) / end, 0.0, 0.0)).collect();
    Curve::new(space, points).unwrap()
}

/// `-m g ∫ y ds` of what hangs between level places, by the catenary of its length: `y = a cosh(x/a) - a cosh(d/2a)`, `2 a sinh(d/2a) = L`.
fn catenary(length: f64, apart: f64, weight: f64) -> f64 {
    let (mut low, mut high) = (1e-3, 1e3);
    for _ in 0..200 {
        let a: f64 = 0.5 * (low + high);
        if 2.0 * a * (0.5 * apart / a).sinh() > length { low = a } else { high = a }
    }
    let a = 0.5 * (low + high);
    weight * (0.5 * a * (apart + a * (apart / a).sinh()) - a * (0.5 * apart / a).cosh() * length)
}

/// The same forces on all vertices, as if by chance.
fn nudge(simulation: &mut Simulation, by: f64) {
    let mut seed = 1_u64;
    for force in simulation.applied_mut(0).unwrap() {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *force = by * ((seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5);
    }
}

/// Straight ropes whose ends are pushed together hang as the catenary does, whatever their degree; and pushed a little, they come back, or find nothing that
/// lies lower. Saddles, where crumpled ropes balance, are left.
#[test]
fn straight_ropes_that_are_pushed_together_hang() {
    for degree in 2..=7 {
        for n in [12, 20, 30, 40] {
            for apart in [0.6, 0.3, 0.8] {
                let rope = line(degree, n, 1.0);
                let end = rope.space().domain().1;
                let stiffness = 200.0 * 9.81;
                let mut simulation = Setup::new(Body::new(&rope).mass(1.0).stiffness(stiffness).damping(1.0))
                    .gravity(GRAVITY)
                    .hold(fixed(0.0))
                    .hold(fixed(end).to([apart, 0.0, 0.0]))
                    .scheme(Scheme::Implicit)
                    .prepare()
                    .unwrap();
                let settled = simulation.settle_without_corners().unwrap();
                let what = format!("degree {degree}, {n} vertices, {apart} apart: {settled:?}");
                assert!(settled.rests && settled.stable == Some(true) && settled.steps <= 200, "{what}");
                let energy = simulation.energy().total();
                let hung = catenary(1.0, apart, 9.81);
                // Few spans are short of its bend.
                assert!((energy - hung).abs() < 0.02 * hung.abs(), "{what}: {energy} for {hung}");
                if n == 20 {
                    nudge(&mut simulation, 0.02);
                    (0..3).for_each(|_| simulation.advance(0.02).unwrap());
                    nudge(&mut simulation, 0.0);
                    assert!(simulation.settle_without_corners().unwrap().rests, "{what}");
                    let again = simulation.energy().total();
                    assert!(again > energy - 1e-6 * energy.abs(), "{what}: {again} after {energy}");
                }
            }
        }
    }
}

/// A long rope through a ring, slack on both sides.
#[test]
fn a_long_slack_rope_comes_to_rest_in_its_ring() {
    let rope = line(3, 300, 10.0);
    let end = rope.space().domain().1;
    let mut simulation = Setup::new(Body::new(&rope).mass(0.3).stiffness(2000.0))
        .gravity(GRAVITY)
        .hold(fixed(0.0))
        .hold(sliding(0.5 * end))
        .hold(fixed(end).to([9.0, 0.0, 0.0]))
        .prepare()
        .unwrap();
    let settled = simulation.settle_without_corners().unwrap();
    assert!(settled.rests && settled.stable == Some(true) && settled.steps <= 400, "{settled:?}");
    let at = simulation.locations(1).unwrap()[0].on_curve().unwrap();
    let tangent = simulation.shape(0).unwrap().value(at.into(), 1.into()).unwrap();
    let force = simulation.force_of(1).unwrap();
    let along = (0..3).map(|k| force[k] * tangent[k]).sum::<f64>() / tangent.norm();
    assert!(along.abs() < 1e-8 * 0.3 * 9.81 * 10.0, "{along}");
}

/// Ropes with corners: of degree 1, closed ones, and of higher degrees with knots as often as that.
fn cornered() -> Vec<(String, Curve, f64)> {
    let mut all = Vec::new();
    for degree in 1..=4 {
        for pieces in [2, 3, 6] {
            let knots: Vec<f64> = (0..=pieces)
                .flat_map(|k| vec![f64::from(k); if k % pieces == 0 { degree + 1 } else { degree }])
                .collect();
            let space = Space::open(degree, knots).unwrap();
            let n = space.len();
            let points: Vec<Point> =
                (0..n).map(|i| Point::new(6.0 * i as f64 / (n - 1) as f64, 0.0, 0.0)).collect();
            for weights in [None, Some((0..n).map(|i| 1.0 + 0.3 * (i % 2) as f64).collect::<Vec<_>>())] {
                let curve = Curve::build(space.clone(), points.clone(), weights).unwrap();
                all.push((format!("degree {degree}, {pieces} pieces"), curve, f64::from(pieces)));
            }
        }
    }
    all
}

fn rests_on_a_corner_or_within(simulation: &Simulation, settled: Settled, what: &str) -> bool {
    assert!(settled.rests && settled.stable == Some(true) && settled.steps <= 300, "{what}: {settled:?}");
    let at = simulation.locations(1).unwrap()[0].on_curve().unwrap();
    let force = simulation.force_of(1).unwrap();
    let size = force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    let pull = |u: f64| {
        let tangent = simulation.shape(0).unwrap().value(u.into(), 1.into()).unwrap();
        (0..3).map(|k| force[k] * tangent[k]).sum::<f64>() / tangent.norm()
    };
    let corner = at.round();
    let on = (at - corner).abs() < 1e-9 * 6.0;
    if on {
        // Forth from behind, back from ahead.
        let (behind, ahead) = (pull(corner - 1e-9), pull(corner + 1e-9));
        assert!(behind > -1e-7 * size && ahead < 1e-7 * size, "{what} at {at}: {behind} {ahead}");
    } else {
        assert!(pull(at).abs() < 1e-7 * size, "{what} at {at}: {}", pull(at));
    }
    on
}

/// A ring that draws a taut rope aside rests where forces along it balance: often on a corner, where what pulls jumps from forth to back.
#[test]
fn places_rest_on_corners() {
    let mut corners = 0;
    for (what, rope, end) in cornered() {
        for (near, to) in [(0.4, [2.4, 0.0, 2.0]), (0.55, [4.0, 0.5, 1.5]), (0.23, [3.5, 0.0, -2.0])] {
            for gravity in [[0.0; 3], GRAVITY] {
                let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0))
                    .gravity(gravity)
                    .hold(fixed(0.0))
                    .hold(sliding(near * end).to(to))
                    .hold(fixed(end).to([7.0, 0.0, 0.0]))
                    .prepare()
                    .unwrap();
                let settled = simulation.settle_without_corners().unwrap();
                let what = format!("{what}, from {near}, {gravity:?}");
                let on = rests_on_a_corner_or_within(&simulation, settled, &what);
                assert_eq!(simulation.on_corners(1).unwrap(), [on], "{what}");
                corners += usize::from(on);
            }
        }
    }
    assert!(corners >= 40, "{corners}");
}
