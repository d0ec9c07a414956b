//! What holds a ring on a corner of a polyline, and what lets it pass: the balance of forces there, in motion and at rest alike.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the ropes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, force, sliding};
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

const SCHEMES: [Scheme; 3] = [Scheme::Exact, Scheme::Epsilon, Scheme::Implicit];

/// Nine vertices, the fifth in the ring, where the rope turns by so many degrees; and the ways out to both ends.
fn bent(degrees: f64) -> (Curve, [Vector; 2]) {
    let turn = degrees.to_radians();
    let ways = [Vector::new(-1.0, 0.0, 0.0), Vector::new(turn.cos(), -turn.sin(), 0.0)];
    let points = (0..9).map(|k| Point::from(ways[usize::from(k > 4)] * f64::from(k - 4).abs())).collect();
    (Curve::new(Space::clamped_uniform(1, 9).unwrap(), points).unwrap(), ways)
}

fn at(simulation: &Simulation) -> f64 {
    let Location::Curve(u) = simulation.locations(0).unwrap()[0] else { panic!("a curve") };
    u
}

/// The ends are drawn straight outwards by `T₁` and `T₂`: the ring stays on its corner unless the stronger one, as much of it as points along the other side, is more than
/// that one: `T₂ cos φ > T₁`. Beyond a right angle nothing moves it.
#[test]
fn a_ring_passes_a_corner_where_the_pull_along_the_next_segment_wins() {
    for scheme in SCHEMES {
        for (degrees, ratio) in
            [(40.0, 1.2), (40.0, 1.4), (60.0, 1.8), (60.0, 2.2), (85.0, 10.0), (85.0, 14.0), (100.0, 30.0)]
        {
            let passes = ratio * f64::to_radians(degrees).cos() > 1.0;
            let (rope, [back, forth]) = bent(degrees);
            let small = 2.0 / ratio;
            for turned in [false, true] {
                let [first, last] = if turned { [2.0, small] } else { [small, 2.0] };
                let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(40.0).damping(8.0))
                    .hold(sliding(4.0))
                    .push(force(0.0, back * first))
                    .push(force(8.0, forth * last))
                    .scheme(scheme)
                    .step(5e-4)
                    .prepare()
                    .unwrap();
                (0..25).for_each(|_| simulation.advance(0.02).unwrap());
                let way = at(&simulation) - 4.0;
                let told = format!("{scheme:?} {degrees}° {ratio} {turned}: {way}");
                if passes {
                    // The rope goes where it is drawn, the ring the other way along it.
                    assert!(if turned { way > 1e-3 } else { way < -1e-3 }, "{told}");
                } else {
                    assert!(way.abs() < 1e-4, "{told}");
                }
            }
        }
    }
}

/// It is no artefact of the motion: where it stays, the least energy of the rope with any other place of it in the ring is more, to first order by
/// `(T₂ - T₁ cos φ) |C'|` ahead and `(T₁ - T₂ cos φ) |C'|` behind.
#[test]
fn on_the_corner_that_holds_it_energy_is_least() {
    for degrees in [60.0, 90.0, 120.0] {
        let (rope, [back, forth]) = bent(degrees);
        // The ends are drawn out by different shares and held.
        let ends = [back * 4.4, forth * 4.7];
        let energy = |place: Option<f64>| {
            let mut setup = Setup::new(Body::new(&rope).mass(0.1).stiffness(40.0)).gravity([0.0; 3]);
            setup = match place {
                Some(u) => setup.hold(fixed(u).to([0.0; 3])),
                None => setup.hold(sliding(4.0)),
            };
            let [a, b] = ends.map(Point::from);
            let mut simulation = setup
                .hold(fixed(0.0).to(a))
                .hold(fixed(8.0).to(b))
                .scheme(Scheme::Implicit)
                .prepare()
                .unwrap();
            assert!(simulation.settle_without_corners().unwrap().rests, "{degrees} {place:?}");
            let tension = |k: usize| Vector::from_column_slice(simulation.force_of(k).unwrap()).norm();
            let found = (at(&simulation), [tension(1), tension(2)]);
            (found, simulation.energy().total())
        };
        let ((place, [behind, ahead]), least) = energy(None);
        let cosine = f64::to_radians(degrees).cos();
        assert!(
            (behind - 4.0).abs() < 1e-6 && (ahead - 7.0).abs() < 1e-6 && place == 4.0,
            "{degrees}: {behind} {ahead} {place}"
        );
        let step = 1e-4;
        for (side, slope) in
            [(1.0, (ahead - behind * cosine) * 4.7 / 4.0), (-1.0, (behind - ahead * cosine) * 4.4 / 4.0)]
        {
            let (_, beside) = energy(Some(4.0 + side * step));
            let found = (beside - least) / step;
            assert!((found - slope).abs() < 2e-2 * slope && slope > 0.0, "{degrees}: {found} for {slope}");
        }
    }
}

/// Places that are drawn to a corner from both sides stand on it in implicit steps, too: before, steps did not arrive there, and hundreds to thousands of halves were taken for
/// a second of motion.
#[test]
fn implicit_steps_stand_on_corners() {
    for count in [12_u32, 20, 31] {
        let points = (0..=count).map(|k| {
            let t = f64::from(k % count) / f64::from(count) * std::f64::consts::TAU;
            let wave = 1.0 + 0.05 * (7.0 * t).sin() + 0.04 * (5.0 * t).cos();
            Point::new(0.6 * wave * t.cos(), 0.6 * wave * t.sin(), 0.03 * (3.0 * t).sin())
        });
        let rope =
            Curve::new(Space::clamped_uniform(1, count as usize + 1).unwrap(), points.collect()).unwrap();
        let end = f64::from(count);
        let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(100.0).damping(0.5))
            .gravity([0.0, 0.0, -9.81])
            .hold(fixed(0.0))
            .hold(sliding(0.31 * end))
            .hold(sliding(0.77 * end))
            .scheme(Scheme::Implicit)
            .keep_seams()
            .prepare()
            .unwrap();
        for _ in 0..24 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        assert!(
            simulation.sub_steps() == 24 && simulation.pauses() <= 60,
            "{count}: {}",
            simulation.pauses()
        );
        let worst = simulation.worst_error();
        assert!(worst < 1e-6, "{count}: {worst:e}");
        let settled = simulation.settle_without_corners().unwrap();
        assert!(settled.rests, "{count}: {settled:?}");
    }
}
