//! Ropes that turn at places that slide: with a corner there both sides are stretched alike, however sharply they turn and however few control vertices there are.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Corner, Scheme, Setup, Simulation, Spot, fixed, pull, sliding, tied};
use loftsman_kernel::Point;
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Space};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A rope of a length of 10 along x.
fn rope(space: Space, weights: bool) -> Curve {
    let (start, end) = space.domain();
    let n = space.len();
    let at = |i: usize| Point::new(10.0 * (space.greville(i) - start) / (end - start), 0.0, 0.0);
    let points = (0..n).map(at).collect();
    let weights = weights.then(|| (0..n).map(|i| 1.0 + 0.5 * (i as f64 * 1.7).sin()).collect());
    Curve::build(space, points, weights).unwrap()
}

/// How much both sides of a place differ: their stretches, as a share of the larger.
fn apart(simulation: &Simulation, constraint: usize) -> f64 {
    let [behind, ahead] = simulation.side_stretches(constraint).unwrap()[0];
    (behind - ahead).abs() / behind.abs().max(ahead.abs())
}

/// Through a ring `share` of the way along, which turns it by so many degrees; 12 long instead of 10.
fn turned(curve: &Curve, turn: f64, share: f64, near: f64, scheme: Scheme) -> Simulation {
    let (sine, cosine) = turn.to_radians().sin_cos();
    let (a, b) = curve.space().domain();
    let (behind, ahead) = (12.0 * share, 12.0 * (1.0 - share));
    Setup::new(Body::new(curve).mass(0.2).stiffness(100.0))
        .hold(fixed(a))
        .hold(fixed(b).to([behind + ahead * cosine, 0.0, ahead * sine]))
        .hold(sliding(a + near * (b - a)).to([behind, 0.0, 0.0]))
        .scheme(scheme)
        .prepare()
        .unwrap()
}

fn settled(simulation: &mut Simulation, what: &str) -> Vec<Corner> {
    let settled = simulation.settle().unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(settled.rests && settled.residual < 1e-9 && settled.turns == 0, "{what}: {settled:?}");
    assert!(settled.stable != Some(false), "{what}: {settled:?}");
    simulation.corners().to_vec()
}

/// Of all degrees, by all turns, few vertices and many: the stretches of both sides are the same within a millionth, not within 1 % alone.
#[test]
fn both_sides_of_a_ring_are_stretched_alike_however_they_turn() {
    let mut cornered = 0;
    for degree in [1, 2, 3, 4, 5] {
        for n in [20, 60, 200] {
            for turn in [0.0, 30.0, 90.0, 150.0] {
                for share in [1.0 / 3.0, 0.5] {
                    let curve = rope(Space::clamped_uniform(degree, n).unwrap(), false);
                    let mut simulation = turned(&curve, turn, share, 0.4, Scheme::Epsilon);
                    let what = format!("degree {degree}, {n} vertices, by {turn}°, at {share}");
                    let corners = settled(&mut simulation, &what);
                    let apart = apart(&simulation, 2);
                    assert!(apart < 1e-6, "{what}: {apart} {corners:?}");
                    assert_eq!(corners.len(), usize::from(turn > 0.0), "{what}");
                    let elastic = simulation.energy().elastic;
                    // 12 instead of 10: the rope of two straight sides.
                    assert!((elastic / 20.0 - 1.0).abs() < 1e-6, "{what}: {elastic}");
                    for Corner { constraint, body, at, knots } in corners {
                        let shape = simulation.shape(0).unwrap();
                        assert_eq!((constraint, body), (2, 0), "{what}");
                        assert_eq!(simulation.locations(2).unwrap(), [Location::Curve(at)], "{what}");
                        assert_eq!(shape.control_vertices().len(), n + knots, "{what}");
                        assert_eq!(simulation.on_corners(2).unwrap(), [true], "{what}");
                        assert!((at / curve.space().domain().1 - share).abs() < 1e-6, "{what}: {at}");
                        cornered += 1;
                    }
                }
            }
        }
    }
    assert_eq!(cornered, 5 * 3 * 3 * 2);
}

/// Closed, floating and quotients, of knots that are uneven or repeated, of degree 7, tiny and huge: wherever the ring was put at first, by any scheme.
#[test]
fn ropes_of_every_kind_turn_at_corners() {
    let ends = |degree: usize, inside: &[f64], end: f64| {
        let knots = [vec![0.0; degree + 1], inside.to_vec(), vec![end; degree + 1]].concat();
        Space::open(degree, knots).unwrap()
    };
    let uneven: Vec<f64> = (1..30).map(|i| f64::from(i) + 0.45 * (f64::from(i) * 2.3).sin()).collect();
    let chain: Vec<f64> = (1..12).flat_map(|i| [f64::from(i); 3]).collect();
    let spaces = [
        ("floating", Space::floating_uniform(3, 30).unwrap()),
        ("uneven", ends(3, &uneven, 30.0)),
        ("degree 7", Space::clamped_uniform(7, 24).unwrap()),
        ("repeated", ends(2, &[1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 6.0, 7.0, 7.0, 8.0, 9.0, 10.0, 11.0], 12.0)),
        ("pieces", ends(3, &chain, 12.0)),
    ];
    for (kind, space) in spaces {
        for (turn, near, scheme) in
            [(150.0, 0.2, Scheme::Exact), (60.0, 0.7, Scheme::Implicit), (110.0, 0.4, Scheme::Epsilon)]
        {
            let curve = rope(space.clone(), false);
            let mut simulation = turned(&curve, turn, 0.4, near, scheme);
            let what = format!("{kind}, by {turn}°, from {near}");
            let corners = settled(&mut simulation, &what);
            assert!(
                corners.len() == 1 && apart(&simulation, 2) < 1e-6,
                "{what}: {} {corners:?}",
                apart(&simulation, 2)
            );
            // It can go on from there: steps as long as are said to be stable make no energy.
            let before = simulation.energy().total();
            let step = simulation.stable_step().min(1.0 / 24.0);
            (0..100).for_each(|_| simulation.advance(step).unwrap());
            let now = simulation.energy().total();
            assert!(now < 1.01 * before, "{what}: {before} → {now}");
        }
    }
}

/// Sizes do not matter.
#[test]
fn tiny_and_huge_ropes_turn_at_corners() {
    for size in [1e-9, 1e9] {
        let curve = rope(Space::clamped_uniform(3, 40).unwrap(), false);
        let points = curve.points().iter().map(|p| p * size).collect();
        let curve = Curve::new(curve.space().clone(), points).unwrap();
        let end = curve.space().domain().1;
        let mut simulation = Setup::new(Body::new(&curve).mass(0.2).stiffness(100.0))
            .hold(fixed(0.0))
            .hold(fixed(end).to([4.0 * size, 0.0, 7.0 * size]))
            .hold(sliding(0.5 * end).to([5.0 * size, 0.0, 0.0]))
            .prepare()
            .unwrap();
        let corners = settled(&mut simulation, &format!("{size:e}"));
        assert!(corners.len() == 1 && apart(&simulation, 2) < 1e-6, "{size:e}: {}", apart(&simulation, 2));
    }
}

/// A lace that zigzags through eight rings, each of which turns it by a right angle or more: nine sides of different lengths, all stretched alike. A fixed point among
/// the rings keeps what is before it from what is behind.
#[test]
fn a_lace_is_stretched_alike_through_all_its_rings() {
    for degree in [2, 3] {
        for nail in [false, true] {
            let curve = rope(Space::clamped_uniform(degree, 60).unwrap(), false);
            let end = curve.space().domain().1;
            let place = |k: usize| {
                [0.7 * k as f64, if k.is_multiple_of(2) { 0.0 } else { 0.8 + 0.1 * k as f64 }, 0.0]
            };
            let mut setup = Setup::new(Body::new(&curve).mass(0.2).stiffness(100.0))
                .hold(fixed(0.0).to(place(0)))
                .hold(fixed(end).to(place(9)));
            for k in 1..9 {
                let near = k as f64 / 9.0 * end;
                let held = if nail && k == 4 { fixed(near) } else { sliding(near) };
                setup = setup.hold(held.to(place(k)));
            }
            let mut simulation = setup.prepare().unwrap();
            let what = format!("degree {degree}, {nail}");
            let corners = settled(&mut simulation, &what);
            let rings: Vec<usize> = (2..10).filter(|k| !(nail && *k == 5)).collect();
            assert_eq!(corners.len(), rings.len(), "{what}: {corners:?}");
            let mut sides = Vec::new();
            for ring in rings {
                // A side that ends at the nail turns there within its spans.
                if !nail || ![4, 6].contains(&ring) {
                    assert!(apart(&simulation, ring) < 1e-5, "{what}, {ring}: {}", apart(&simulation, ring));
                }
                sides.push(simulation.side_stretches(ring).unwrap()[0][0]);
            }
            let most = sides.iter().fold(f64::MIN, |most, side| most.max(*side));
            let least = sides.iter().fold(f64::MAX, |least, side| least.min(*side));
            assert_eq!(nail, most - least > 0.02 * most, "{what}: {sides:?}");
        }
    }
}

/// With weight it is the tension at the ring that is the same on both sides: what the nails carry and the ring does agree with Irvine's elastic catenaries of both sides,
/// whose tensions at the ring are one, as they do with four times as many vertices.
#[test]
fn with_weight_tensions_meet_at_the_ring() {
    let (mass, stiffness, length) = (0.2, 400.0, 10.0);
    let held = |n: usize| {
        let curve = rope(Space::clamped_uniform(3, n).unwrap(), false);
        let end = curve.space().domain().1;
        let mut simulation = Setup::new(Body::new(&curve).mass(mass).stiffness(stiffness))
            .gravity(GRAVITY)
            .hold(fixed(0.0))
            .hold(fixed(end).to([1.0, 0.0, -1.0]))
            .hold(sliding(0.5 * end).to([5.5, 0.0, 1.0]))
            .prepare()
            .unwrap();
        let corners = settled(&mut simulation, &format!("{n}"));
        assert_eq!(corners.len(), 1);
        let shape = simulation.shape(0).unwrap();
        let strains = [-1e-7, 1e-7].map(|by| {
            let speed = shape.value((corners[0].at + by).into(), Derivative::from(1)).unwrap().norm();
            speed * end / length - 1.0
        });
        let forces = [0, 1].map(|k| simulation.force_of(k).unwrap().to_vec());
        (corners[0].at / end, strains, forces)
    };
    let (coarse, fine) = (held(40), held(160));
    for (at, strains, _) in [&coarse, &fine] {
        assert!((strains[0] - strains[1]).abs() < 1e-6, "{at} {strains:?}");
    }
    // What nails carry of a side hangs on how much rope there is in it.
    assert!((coarse.0 - fine.0).abs() < 1e-6, "{} {}", coarse.0, fine.0);
    for (a, b) in coarse.2.iter().flatten().zip(fine.2.iter().flatten()) {
        assert!((a - b).abs() < 1e-6 * stiffness, "{:?} {:?}", coarse.2, fine.2);
    }
}

/// A ring that another object carries, and a rope that is pulled: corners there, too.
#[test]
fn rings_that_move_along_turn_ropes() {
    let curve = rope(Space::clamped_uniform(3, 30).unwrap(), false);
    let end = curve.space().domain().1;
    let ring = {
        let points = [[4.0, 0.0, 0.0], [4.0, 0.2, 0.0]].map(Point::from).to_vec();
        Curve::new(Space::clamped_uniform(1, 2).unwrap(), points).unwrap()
    };
    let mut simulation = Setup::new(Body::new(&curve).mass(0.05).stiffness(200.0))
        .and(Body::new(&ring).mass(20.0).stiffness(1e3))
        .gravity(GRAVITY)
        .hold(fixed(0.0))
        .hold(fixed(end).to([9.0, 0.0, 2.0]))
        .hold(tied(Spot::at(1, 0.0), Spot::near(0, 0.4 * end)))
        .pull(pull(0.8 * end, [8.0, 1.0, 1.0], 5.0))
        .prepare()
        .unwrap();
    let corners = settled(&mut simulation, "a ring that is carried");
    assert_eq!((corners.len(), corners[0].body), (1, 0));
    let shape = simulation.shape(0).unwrap();
    let speeds =
        [-1e-7, 1e-7].map(|by| shape.value((corners[0].at + by).into(), Derivative::from(1)).unwrap().norm());
    // At the pull it turns within a span or two.
    assert!((speeds[0] / speeds[1] - 1.0).abs() < 1e-3, "{speeds:?}");
    // Without corners it is given no more.
    let before = simulation.shape(0).unwrap().control_vertices().len();
    assert!(simulation.settle_without_corners().unwrap().rests);
    assert_eq!(simulation.shape(0).unwrap().control_vertices().len(), before);
}

/// What bends is not given corners, nor is what somebody knows by its vertices' numbers.
#[test]
fn what_bends_has_no_corners() {
    let curve = rope(Space::clamped_uniform(3, 30).unwrap(), false);
    let end = curve.space().domain().1;
    for bending in [0.0, 0.1] {
        let mut simulation = Setup::new(Body::new(&curve).mass(0.2).stiffness(100.0).bending(bending))
            .hold(fixed(0.0))
            .hold(fixed(end).to([4.0, 0.0, 8.0]))
            .hold(sliding(0.4 * end).to([4.0, 0.0, 0.0]))
            .prepare()
            .unwrap();
        let corners = settled(&mut simulation, "what bends");
        assert_eq!(corners.len(), usize::from(bending == 0.0));
        let count = simulation.shape(0).unwrap().control_vertices().len();
        assert_eq!(count == 30, bending > 0.0);
    }
}

/// A closed rope of a circle's length on two hooks.
fn hung(degree: usize, n: usize, near: [f64; 2], scheme: Scheme) -> Simulation {
    let space = Space::periodic_uniform(degree, n).unwrap();
    let (start, end) = space.domain();
    let points = (0..n).map(|i| {
        let a = std::f64::consts::TAU * i as f64 / n as f64;
        Point::new(a.cos(), 0.02 * (3.0 * a).sin(), a.sin())
    });
    let curve = Curve::new(space, points.collect()).unwrap();
    let [first, second] = near.map(|share| start + share * (end - start));
    Setup::new(Body::new(&curve).mass(0.2).stiffness(100.0))
        .gravity(GRAVITY)
        .hold(sliding(first).to([-0.5, 0.0, 1.0]))
        .hold(sliding(second).to([0.5, 0.0, 1.1]))
        .scheme(scheme)
        .prepare()
        .unwrap()
}

/// Closed ropes on two hooks, as chains over two pulleys: that both bights are as long is a balance, but the highest of all; none with corners is taken that is not as low as without, nor
/// one that is not stable where that is. Places that come to rest close to knots do not tear spans from them.
#[test]
fn closed_ropes_on_two_hooks_rest_no_higher_with_corners() {
    let (mut cornered, mut turned) = (0, 0);
    for degree in [1, 2, 3, 5] {
        for n in [16, 20] {
            for near in [[0.404, 0.915], [0.3, 0.6], [0.13, 0.71]] {
                let what = format!("degree {degree}, {n} vertices, from {near:?}");
                let energy = |corners: bool| {
                    let mut simulation = hung(degree, n, near, Scheme::Implicit);
                    let settled =
                        if corners { simulation.settle() } else { simulation.settle_without_corners() };
                    let settled = settled.unwrap_or_else(|error| panic!("{what}: {error}"));
                    let all = simulation.energy().total() + simulation.unseen_energy().unwrap();
                    (settled, all, simulation.corners().len(), simulation)
                };
                let (settled, with, corners, simulation) = energy(true);
                let (plain, without, ..) = energy(false);
                assert!(settled.rests && plain.rests, "{what}: {settled:?} {plain:?}");
                assert!(with <= without + 1e-6 * without.abs().max(1.0), "{what}: {with} over {without}");
                assert!(plain.stable != Some(true) || settled.stable == Some(true), "{what}: {settled:?}");
                assert!(corners == 0 || settled.turns == 0, "{what}: {settled:?}");
                (cornered, turned) = (cornered + corners, turned + settled.turns);
                if corners == 2 {
                    // The strain in which both sides meet, and knots that let steps be long.
                    assert!(simulation.stable_step() > 1e-6, "{what}: {}", simulation.stable_step());
                }
            }
        }
    }
    assert!(cornered >= 46 && cornered + turned == 48, "{cornered} corners, {turned} without");
}

/// A ring that comes to rest close to a knot, in a domain far from zero: the corner is on the knot, or there is none; it is no error.
#[test]
fn rings_close_to_knots_are_no_error() {
    let (a, b, c) = (100.0, 100.000_017_346_037_58, 100.003_530_728_151_09);
    let space = Space::open(3, vec![a, a, a, a, b, c, c, c, c]).unwrap();
    for size in [1.0, 1e6] {
        let points = (0..5).map(|i| Point::new(0.25 * size * f64::from(i), 0.0, 0.0)).collect();
        let curve = Curve::new(space.clone(), points).unwrap();
        let mut simulation = Setup::new(Body::new(&curve).mass(1.0).stiffness(100.0))
            .hold(fixed(a))
            .hold(fixed(c))
            .hold(sliding(100.000_924_333_795_78).to([
                0.027_197_66 * size,
                -0.104_263_49 * size,
                0.05 * size,
            ]))
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        let [behind, ahead] = simulation.side_stretches(2).unwrap()[0];
        let made = !simulation.corners().is_empty();
        assert!(made == (settled.turns == 0), "{settled:?}");
        assert!(!made || (behind - ahead).abs() < 2e-3 * ahead.abs(), "{behind} {ahead}");
    }
}
