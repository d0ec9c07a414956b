//! Places that slide over corners while ropes move: steps stop there, and constraints keep to what they ask.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the ropes of the tests cannot fail")]

use loftsman_dynamics::{Body, Path, Scheme, Setup, Simulation, fixed, sliding};
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

const EXPLICIT: [Scheme; 2] = [Scheme::Exact, Scheme::Epsilon];

fn polyline(points: Vec<Point>) -> Curve {
    Curve::new(Space::clamped_uniform(1, points.len()).unwrap(), points).unwrap()
}

fn at(simulation: &Simulation, constraint: usize) -> f64 {
    match simulation.locations(constraint).unwrap()[0] {
        Location::Curve(u) => u,
        other => panic!("{other}"),
    }
}

/// A zigzag of corners of so many degrees, pulled through a ring by its end: over a dozen of them.
#[test]
fn zigzags_are_pulled_through_a_ring() {
    for degrees in [5.0_f64, 40.0, 75.0, 120.0, 150.0] {
        for scheme in EXPLICIT {
            let half = 0.5 * degrees.to_radians();
            let mut points = vec![Point::origin()];
            for k in 0..24 {
                let side = if k % 2 == 0 { half.sin() } else { -half.sin() };
                let last = points[points.len() - 1];
                points.push(last + Vector::new(half.cos(), side, 0.0));
            }
            let rope = polyline(points.clone());
            let size = points[24].x;
            let end = points[24];
            // What lies in folds is straightened first.
            let way = 14.0 * half.cos() + 8.0 * (1.0 - half.cos());
            let path = Path::new(vec![end, end + Vector::new(way, 0.0, 0.0)], 0.0, 2.0).unwrap();
            let mut simulation = Setup::new(Body::new(&rope).mass(0.2).stiffness(400.0).damping(1.0))
                .hold(sliding(18.4))
                .hold(fixed(24.0).to(path))
                .scheme(scheme)
                .prepare()
                .unwrap();
            let start = at(&simulation, 0);
            for _ in 0..60 {
                simulation.advance(1.0 / 24.0).unwrap();
            }
            let worst = simulation.worst_error();
            assert!(worst <= 1e-6 * size, "{degrees}°, {scheme:?}: {worst} of {size}");
            let now = at(&simulation, 0);
            assert!(start - now > 5.0, "{degrees}°, {scheme:?}: it slid from {start} to {now} only");
        }
    }
}

/// A chain of straight links that flies through a ring: what goes over a corner loses energy there, and gains none.
#[test]
fn corners_take_energy_and_give_none() {
    for scheme in EXPLICIT {
        let at_vertex = |k: u32| Point::new(f64::from(k), 0.2 * f64::from(k % 2), 0.0);
        let rope = polyline((0..=20).map(at_vertex).collect());
        let mut simulation =
            Setup::new(
                Body::new(&rope).mass(0.1).stiffness(200.0).moving(vec![Vector::new(-3.0, 0.0, 0.0); 21]),
            )
            .hold(sliding(4.5))
            .scheme(scheme)
            .prepare()
            .unwrap();
        let first = simulation.energy().total();
        let mut least = first;
        for _ in 0..300 {
            simulation.advance(1.0 / 100.0).unwrap();
            let now = simulation.energy().total();
            assert!(now < least + 1e-3 * first, "{scheme:?}: {now} after {least}, of {first}");
            least = least.min(now);
        }
        assert!(at(&simulation, 0) > 11.0 && least < 0.995 * first, "{scheme:?}: {least} of {first}");
        let worst = simulation.worst_error();
        assert!(worst <= 20e-6, "{scheme:?}: {worst}");
    }
}

/// A V whose sides pull alike rests with its corner in the ring: it comes there, stands, and what draws it off later draws it off.
#[test]
fn a_place_stands_on_a_corner_that_holds_it_and_leaves_when_it_is_drawn() {
    for scheme in EXPLICIT {
        let points = vec![Point::new(-4.0, 0.0, -1.5), Point::origin(), Point::new(4.0, 0.0, -1.5)];
        let rope = polyline(points);
        let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(50.0).damping(4.0))
            .hold(fixed(0.0))
            .hold(sliding(1.1).to([0.0, 0.0, 0.6]))
            .hold(fixed(2.0))
            .scheme(scheme)
            .prepare()
            .unwrap();
        for _ in 0..200 {
            simulation.advance(1.0 / 50.0).unwrap();
        }
        assert_eq!(at(&simulation, 1), 1.0, "{scheme:?}");
        assert_eq!(simulation.on_corners(1).unwrap(), [true]);
        assert!(simulation.errors().unwrap()[1] < 1e-12);
        // Pulled on one side by far more.
        simulation.retarget(2, [12.0, 0.0, -4.5]).unwrap();
        for _ in 0..200 {
            simulation.advance(1.0 / 50.0).unwrap();
        }
        let there = at(&simulation, 1);
        assert!(there < 1.0 - 1e-3, "{scheme:?}: {there}");
        let worst = simulation.worst_error();
        assert!(worst <= 9e-6, "{scheme:?}: {worst}");
    }
}

/// Sheets of flat pieces over a point.
#[test]
fn sheets_slide_over_their_edges() {
    for scheme in EXPLICIT {
        let [u, v] = [Space::clamped_uniform(1, 9).unwrap(), Space::clamped_uniform(1, 5).unwrap()];
        let points = (0..45).map(|k| {
            let (i, j) = (f64::from(k / 5), f64::from(k % 5));
            Point::new(i, j, 0.4 * (i + 0.3 * j).sin())
        });
        let sheet = Surface::new(u, v, points.collect()).unwrap();
        let from = [[8.0, 0.0], [8.0, 4.0]];
        let mut setup = Setup::new(Body::new(&sheet).mass(0.2).stiffness(100.0).damping(1.0))
            .hold(sliding([4.3, 2.2]))
            .scheme(scheme);
        for place in from {
            let start = sheet.point(place[0], place[1]).unwrap();
            let path = Path::new(vec![start, start + Vector::new(2.5, 0.0, 0.0)], 0.0, 1.5).unwrap();
            setup = setup.hold(fixed(place).to(path));
        }
        let mut simulation = setup.prepare().unwrap();
        for _ in 0..48 {
            simulation.advance(1.0 / 24.0).unwrap();
        }
        let Location::Surface(u, _) = simulation.locations(0).unwrap()[0] else { panic!("a surface") };
        assert!(u < 3.0, "{scheme:?}: {u}");
        let worst = simulation.worst_error();
        assert!(worst <= 8e-6, "{scheme:?}: {worst}");
    }
}
