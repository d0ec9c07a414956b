//! What the manual says of bending that shrinks, measured.

#![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Setup};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

fn length(curve: &Curve) -> f64 {
    let (a, b) = curve.space().domain();
    let count = 4000;
    let at = |i: usize| curve.point(a + (b - a) * i as f64 / count as f64).unwrap();
    (0..count).map(|i| (at(i + 1) - at(i)).norm()).sum()
}

/// Half circles that may unbend, at `bending = stiffness · length²`, ten and a hundred times that: by how many per cent they end too short.
#[test]
fn half_circles_end_too_short_by_what_the_manual_says() {
    for (degree, n, even, shares) in [
        (2, 8, false, [15.46, 64.65, 94.82]),
        (2, 20, false, [2.27, 18.88, 69.95]),
        (3, 8, false, [0.27, 2.63, 21.29]),
        (3, 8, true, [1.38, 12.25, 58.27]),
        (3, 20, true, [0.072, 0.72, 6.75]),
        (5, 12, true, [0.167, 1.65, 14.35]),
    ] {
        let space = Space::clamped_uniform(degree, n).unwrap();
        let whole = space.domain().1;
        let points = (0..n).map(|i| {
            let share = if even { i as f64 / (n - 1) as f64 } else { space.greville(i) / whole };
            let turn = std::f64::consts::PI * share;
            Point::new(turn.cos(), turn.sin(), 0.0)
        });
        let curve = Curve::new(space.clone(), points.collect()).unwrap();
        let before = length(&curve);
        for (times, share) in [1.0, 10.0, 100.0].into_iter().zip(shares) {
            let body = Body::new(&curve).stiffness(100.0).bending(100.0 * times * before * before);
            let mut simulation = Setup::new(body).prepare().unwrap();
            assert!(simulation.settle().unwrap().rests);
            let points = simulation.shape(0).unwrap().control_vertices().to_vec();
            let found = 100.0 * (1.0 - length(&Curve::new(space.clone(), points).unwrap()) / before);
            assert!((found / share - 1.0).abs() < 0.02, "{degree} {n} {even} {times}: {found} {share}");
        }
    }
}
