//! Against closed forms.

use loftsman_dynamics::{Body, Scheme, Setup, Spot, fixed, sliding, tied};
use loftsman_kernel::Point;
use loftsman_kernel::shape::Derivative;
use loftsman_kernel::spline::{Curve, Space};

fn line(degree: usize, n: usize, from: [f64; 3], to: [f64; 3]) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let (a, b) = (Point::from(from), Point::from(to));
    let end = space.domain().1;
    let points = (0..n).map(|i| a + (b - a) * (space.greville(i) / end)).collect();
    Curve::new(space, points).unwrap()
}

/// A rod of uniform mass that swings about its end: `T = 2π √(2L/3g)`, for small swings.
#[test]
fn a_pendulum_has_its_period() {
    let angle: f64 = 0.01;
    let rod = line(1, 2, [0.0; 3], [angle.sin(), 0.0, -angle.cos()]);
    let mut simulation = Setup::new(Body::new(&rod).stiffness(1e6))
        .gravity([0.0, 0.0, -9.81])
        .hold(fixed(0.0))
        .scheme(Scheme::Exact)
        .prepare()
        .unwrap();
    let period = std::f64::consts::TAU * (2.0 / (3.0 * 9.81_f64)).sqrt();
    // Crossings of the vertical.
    let (mut last, mut crossings) = (angle.sin(), Vec::new());
    let dt = period / 1000.0;
    while crossings.len() < 5 {
        simulation.advance(dt).unwrap();
        let x = simulation.shape(0).unwrap().control_vertices()[1].x;
        if last * x < 0.0 {
            crossings.push(simulation.time() - dt * x / (x - last));
        }
        last = x;
    }
    let found = (crossings[4] - crossings[0]) / 2.0;
    assert!((found / period - 1.0).abs() < 1e-3, "{found} {period}");
    assert!(simulation.worst_error() < 1e-6, "{}", simulation.worst_error());
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
        let speed = |u: f64| shape.value((u * ends).into(), Derivative::from(1)).unwrap().norm() * ends / 10.0;
        (speed(0.1), speed(0.9))
    };
    let (left, right) = stretch(true);
    assert!((left / right - 1.0).abs() < 0.01 && (left - 1.6).abs() < 0.016, "{left} {right}");
    let (left, right) = stretch(false);
    assert!((left - 1.0).abs() < 0.01 && (right - 2.0).abs() < 0.01, "{left} {right}");
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
