//! What slides over corners, and rests on them: thrown off by no more than a short step's way.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

/// Polygons and chains of Bézier pieces that fall through a ring, soft ones, whose stable steps are long: steps are as short as their drift asks, at
/// once, so that no more than 1e-4 of the size is missed in any frame, and no energy comes of it.
#[test]
fn steps_are_shortened_at_once_where_a_corner_comes() {
    for degree in [1, 2, 3] {
        let knots = (0..4).flat_map(|k| vec![f64::from(k); if k % 3 == 0 { degree + 1 } else { degree }]);
        let space = match degree {
            1 => Space::clamped_uniform(1, 9).unwrap(),
            _ => Space::open(degree, knots.collect()).unwrap(),
        };
        let (n, end) = (space.len(), space.domain().1);
        let points = (0..n).map(|i| {
            let t = i as f64;
            Point::new(t, (0.9 * t).sin(), (0.5 * t).cos())
        });
        let size = n as f64 - 1.0;
        let shape = Curve::new(space, points.collect()).unwrap();
        for (at, scheme) in [(0.37, Scheme::Exact), (0.45, Scheme::Epsilon), (0.62, Scheme::Exact)] {
            let body = Body::new(&shape).mass(0.3).stiffness(50.0).damping(0.0);
            let mut simulation = Setup::new(body)
                .gravity([0.0, 0.0, -9.81])
                .hold(fixed(0.0))
                .hold(sliding(at * end))
                .scheme(scheme)
                .prepare()
                .unwrap();
            let before = simulation.energy().total();
            let (mut missed, mut most, mut motion) = (0.0_f64, 0.0_f64, 0.0_f64);
            for _ in 0..120 {
                simulation.advance(1.0 / 60.0).unwrap();
                missed = missed.max(simulation.errors().unwrap()[1]);
                let now = simulation.energy();
                (most, motion) = (most.max(now.total() - before), motion.max(now.kinetic));
            }
            let what = format!("degree {degree}, {scheme:?}, {at}");
            assert!(missed < 1e-4 * size, "{what}: {missed:e}");
            assert!(most < 1e-3 * motion, "{what}: {most:e} of {motion}");
        }
    }
}
