//! The stated steps are stable.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, fixed};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Ropes of all degrees, with uneven and repeated knots and with weights, stiff and soft, bending or not, thrown so that all frequencies are in them:
/// a thousand steps of the stated length keep what energy there is, to the third that the highest frequency of leapfrogs with `h ω ≤ 1` has
/// of swing.
#[test]
fn a_thousand_steps_of_the_stated_length_are_stable() {
    let mut seed = 4711_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut blown = 0;
    for round in 0..80_usize {
        let degree = 1 + round % 7;
        let n = degree + 2 + (random() * 9.0) as usize;
        let inner = n - degree - 1;
        let mut knots: Vec<f64> = (0..inner)
            .map(|i| if round % 3 == 0 { random() } else { (i + 1) as f64 / (inner + 1) as f64 })
            .collect();
        knots.sort_by(f64::total_cmp);
        if degree > 1 && inner > 2 && round % 5 == 0 {
            knots[1] = knots[0];
        }
        let space = match round % 4 {
            3 => Space::periodic_uniform(degree, n.max(degree + 2)).unwrap(),
            _ => Space::open(degree, [vec![0.0; degree + 1], knots, vec![1.0; degree + 1]].concat()).unwrap(),
        };
        let n = space.len();
        let size = 10_f64.powf(2.0 * random() - 1.0);
        let points = (0..n).map(|i| {
            let turn = std::f64::consts::TAU * i as f64 / n as f64;
            Point::new(size * turn.cos(), size * turn.sin(), size * 0.3 * (random() - 0.5))
        });
        let points = points.collect();
        let weights = (round % 6 == 1).then(|| (0..n).map(|_| 0.5 + 1.5 * random()).collect());
        let rope = Curve::build(space, points, weights).unwrap();
        let stiffness = 10_f64.powf(4.0 * random());
        let bending = if round % 2 == 0 || degree == 1 {
            0.0
        } else {
            stiffness * size * size * 10_f64.powf(-2.0 - 3.0 * random())
        };
        let speed = 0.01 * (stiffness / 0.4).sqrt();
        let thrown =
            (0..n).map(|_| Vector::new(random() - 0.5, random() - 0.5, random() - 0.5) * speed).collect();
        let body =
            Body::new(&rope).mass(0.4).stiffness(stiffness).bending(bending).damping(0.0).moving(thrown);
        let start = rope.space().domain().0;
        let setup = Setup::new(body).scheme(Scheme::Exact);
        let mut simulation = if round % 3 == 2 { setup.hold(fixed(start)) } else { setup }.prepare().unwrap();
        let step = simulation.stable_step();
        // Bending is at rest where the rope is straight: what it starts with may all become motion.
        let before = simulation.energy().total();
        for k in 0..1000 {
            simulation.step(step).unwrap_or_else(|e| panic!("round {round}, degree {degree}: {e}"));
            let now = simulation.energy().total();
            assert!(now < 1.4 * before, "round {round}, degree {degree}, step {k}: {before} → {now}");
        }
        // What is stated is not far below what there is: a half is kept, and a span alone swings up to nine times as fast as with its neighbours.
        let blows = (0..1000).any(|_| {
            simulation.step(30.0 * step).is_err() || {
                let now = simulation.energy().total();
                now.is_nan() || now >= 1.4 * before
            }
        });
        blown += usize::from(blows);
    }
    assert!(blown >= 50, "{blown} of 80 blow up");
}

/// Where bending is what swings fastest the stated step is a half of what is just stable, less some per cent, in every degree: three times as long it blows up.
#[test]
fn the_stated_step_of_bending_is_sharp() {
    for degree in 2..=7 {
        for (uneven, weighted) in [(false, false), (true, false), (false, true)] {
            let n = 14;
            let knots: Vec<f64> = (0..n + degree + 1)
                .map(|i| (i as f64 - degree as f64).clamp(0.0, (n - degree) as f64))
                .map(|t| if uneven { t * (1.0 + 0.1 * t) } else { t })
                .collect();
            let points = (0..n).map(|i| {
                let turn = 5.0 * f64::from(i) / f64::from(n);
                Point::new(turn.cos(), turn.sin(), 0.1 * turn)
            });
            let weights = weighted.then(|| (0..n).map(|i| 1.0 + 0.5 * f64::from(i % 3)).collect());
            let rope = Curve::build(Space::open(degree as usize, knots).unwrap(), points.collect(), weights)
                .unwrap();
            let thrown =
                (0..n).map(|i| Vector::new(0.0, 0.0, if i % 2 == 0 { 1e-3 } else { -1e-3 })).collect();
            let body = Body::new(&rope).mass(0.4).stiffness(1e-3).bending(10.0).damping(0.0).moving(thrown);
            let mut simulation = Setup::new(body).scheme(Scheme::Exact).prepare().unwrap();
            let step = simulation.stable_step();
            let before = simulation.energy().total();
            for _ in 0..500 {
                simulation.step(step).unwrap();
            }
            let now = simulation.energy().total();
            assert!(now < 1.4 * before, "degree {degree}: {before} → {now}");
            let blows = (0..500).any(|_| {
                simulation.step(3.0 * step).is_err() || {
                    let now = simulation.energy().total();
                    now.is_nan() || now >= 10.0 * before
                }
            });
            assert!(blows, "degree {degree}, uneven {uneven}, weighted {weighted}: {step:e}");
        }
    }
}
