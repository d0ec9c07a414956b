//! Fair shapes that are known: Hermite's cubic, natural splines, straight lines, planes; and what does not depend on the axes,
//! the scale or the number of vertices.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fairing::{Fair, bend, near, stretch, variation};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::{derivative, join, position, tangent};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// A curve of little order, its numbers the same on every machine.
fn wild(space: Space) -> Curve {
    let n = space.len();
    let at = |i: usize| {
        let t = i as f64;
        Point::new(t + (1.7 * t).sin(), 2.0 * (2.3 * t).cos(), (0.9 * t).sin() - 0.1 * t)
    };
    Curve::new(space, (0..n).map(at).collect()).unwrap()
}

#[test]
fn two_ends_with_tangents_give_hermite_s_cubic() {
    let curve = wild(Space::clamped(3, &[0.0, 0.1, 0.35, 0.4, 0.7, 0.71, 1.0]).unwrap());
    let (a, b) = (Point::new(1.0, 2.0, 3.0), Point::new(4.0, 0.0, -1.0));
    let (da, db) = (Vector::new(3.0, 6.0, 0.0), Vector::new(0.0, -9.0, 3.0));
    let fair = Fair::new(&curve)
        .energy(bend())
        .ask(position(0.0).to(a))
        .ask(derivative(0.0, 1).to(da))
        .ask(position(1.0).to(b))
        .ask(derivative(1.0, 1).to(db))
        .solve()
        .unwrap();
    let hermite = Curve::bezier(vec![a, a + da / 3.0, b - db / 3.0, b]).unwrap();
    for i in 0..=50 {
        let u = f64::from(i) / 50.0;
        assert!((fair.shape().point(u).unwrap() - hermite.point(u).unwrap()).norm() < 1e-12);
    }
    // ∫ |C''|² of a cubic: C'' is linear between its ends' c₀ and c₁, so (|c₀|² + c₀·c₁ + |c₁|²) / 3.
    let (c, d) = (hermite.derivative(0.0, 2).unwrap(), hermite.derivative(1.0, 2).unwrap());
    let energy = (c.norm_squared() + c.dot(&d) + d.norm_squared()) / 3.0;
    assert!((fair.report().energy_after - energy).abs() < 1e-12 * energy, "{}", fair.report());
}

/// The second derivatives at the sites of the natural cubic spline through values: the tridiagonal system of every textbook.
fn natural(sites: &[f64], values: &[f64]) -> Vec<f64> {
    let n = sites.len();
    let h = |i: usize| sites[i + 1] - sites[i];
    let (mut diagonal, mut right) = (vec![1.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        diagonal[i] = 2.0 * (h(i - 1) + h(i));
        right[i] = 6.0 * ((values[i + 1] - values[i]) / h(i) - (values[i] - values[i - 1]) / h(i - 1));
    }
    for i in 2..n - 1 {
        let factor = h(i - 1) / diagonal[i - 1];
        diagonal[i] -= factor * h(i - 1);
        right[i] -= factor * right[i - 1];
    }
    let mut second = vec![0.0; n];
    for i in (1..n - 1).rev() {
        second[i] = (right[i] - h(i) * second[i + 1]) / diagonal[i];
    }
    second
}

#[test]
fn of_all_curves_through_points_the_natural_spline_bends_least() {
    let sites = [0.0, 1.0, 2.5, 3.0, 5.0, 6.0];
    let values = [0.0, 2.0, -1.0, 0.5, 1.0, 1.5];
    // Knots at the sites, and more: the fair curve does not use them.
    let knots: Vec<f64> = (0..=24).map(|i| 0.25 * f64::from(i)).collect();
    let mut fair = Fair::new(&wild(Space::clamped(3, &knots).unwrap())).energy(bend());
    for (&u, &y) in sites.iter().zip(&values) {
        fair = fair.ask(position(u).to([u, y, 0.0]));
    }
    let fair = fair.solve().unwrap();
    let second = natural(&sites, &values);
    for (i, &u) in sites.iter().enumerate() {
        let found = fair.shape().derivative(u, 2).unwrap();
        assert!((found.y - second[i]).abs() < 1e-11 && found.x.abs() < 1e-11, "at {u}: {found:?}");
    }
    let h = |i: usize| sites[i + 1] - sites[i];
    let energy: f64 = (0..5)
        .map(|i| h(i) / 3.0 * (second[i].powi(2) + second[i] * second[i + 1] + second[i + 1].powi(2)))
        .sum();
    assert!((fair.report().energy_after - energy).abs() < 1e-12 * energy);
}

#[test]
fn a_stretched_line_is_straight_and_even_and_a_loop_shrinks_to_a_point() {
    let curve = wild(Space::clamped_uniform(4, 11).unwrap());
    let fair = Fair::new(&curve).energy(stretch()).ask(position(0.0).keep()).ask(position(7.0).keep());
    let fair = fair.solve().unwrap();
    let (a, b) = (curve.point(0.0).unwrap(), curve.point(7.0).unwrap());
    for i in 0..=14 {
        let u = f64::from(i) / 2.0;
        assert!((fair.shape().point(u).unwrap() - (a + (b - a) * (u / 7.0))).norm() < 1e-13);
    }
    assert!((fair.report().energy_after - (b - a).norm_squared() / 7.0).abs() < 1e-12);

    let ring = wild(Space::periodic_uniform(3, 9).unwrap());
    let shrunk = Fair::new(&ring).energy(stretch()).ask(position(2.0).keep()).solve().unwrap();
    let at = ring.point(2.0).unwrap();
    assert!(shrunk.shape().points().iter().all(|p| (p - at).norm() < 1e-13));
    assert!(shrunk.report().energy_after < 1e-24);
}

#[test]
fn what_nothing_is_said_about_stays_near() {
    // Nothing asked: the nearest straight line, evenly run through. Its vertices are the least-squares fit over Greville's abscissae.
    let curve = wild(Space::clamped_uniform(3, 10).unwrap());
    let fair = Fair::new(&curve).energy(bend()).solve().unwrap();
    let sites: Vec<f64> = (0..10).map(|i| curve.space().greville(i)).collect();
    let mean = sites.iter().sum::<f64>() / 10.0;
    let spread: f64 = sites.iter().map(|s| (s - mean).powi(2)).sum();
    let centre = curve.points().iter().fold(Vector::zeros(), |s, p| s + p.coords) / 10.0;
    let slope = sites.iter().zip(curve.points()).fold(Vector::zeros(), |s, (u, p)| s + p.coords * (u - mean))
        / spread;
    for (u, p) in sites.iter().zip(fair.shape().points()) {
        assert!((p.coords - centre - slope * (u - mean)).norm() < 1e-13, "{p}");
    }
    assert_eq!(fair.report().rank, 0);
    assert!(fair.report().notes[0].contains("(6 numbers free)"), "{:?}", fair.report().notes);
    // One point kept: still free to turn.
    let one = Fair::new(&curve).energy(bend()).ask(position(3.0).keep()).solve().unwrap();
    assert!(one.report().notes[0].contains("(3 numbers free)"), "{:?}", one.report().notes);
    let two = Fair::new(&curve).energy(bend()).ask(position(3.0).keep()).ask(position(5.0).keep());
    assert!(two.solve().unwrap().report().notes.is_empty());
}

#[test]
fn multipliers_say_what_a_target_costs() {
    let curve = wild(Space::clamped_uniform(3, 14).unwrap());
    let at = |y: f64| {
        let fair = Fair::new(&curve).energy(bend() + 0.2 * near());
        let fair = fair.ask(position(2.0).to([1.0, y, 0.5])).ask(position(9.0).keep());
        fair.solve().unwrap().report().clone()
    };
    let (low, middle, high) = (at(2.0 - 1e-3), at(2.0), at(2.0 + 1e-3));
    let slope = (high.energy_after - low.energy_after) / 2e-3;
    assert_eq!(middle.constraints[0].name, "position at 2");
    assert!((middle.constraints[0].multipliers[1] - slope).abs() < 1e-7 * slope.abs(), "{slope} {middle:?}");
}

#[test]
fn axes_places_and_scales_do_not_matter() {
    let curve = wild(Space::clamped_uniform(3, 12).unwrap());
    let fair = |curve: &Curve, scale: f64, shift: Vector| {
        let to = Point::from(Vector::new(3.0, 1.0, 2.0) * scale + shift);
        let fair = Fair::new(curve).energy(bend()).ask(position(0.0).keep()).ask(position(4.5).to(to));
        fair.ask(position(9.0).keep()).ask(tangent(2.0).keep()).solve().unwrap()
    };
    let plain = fair(&curve, 1.0, Vector::zeros());
    for exponent in [-9, -6, -3, 3, 6, 9] {
        let scale = 10_f64.powi(exponent);
        let scaled: Vec<Point> = curve.points().iter().map(|p| p * scale).collect();
        let scaled = fair(&Curve::new(curve.space().clone(), scaled).unwrap(), scale, Vector::zeros());
        for (a, b) in plain.shape().points().iter().zip(scaled.shape().points()) {
            assert!((a * scale - b).norm() < 1e-12 * scale, "{scale:e}");
        }
        // The same curve over another domain: the bending energy changes, the shape does not.
        let knots = curve.space().knots().iter().map(|k| k * scale).collect();
        let other = Curve::new(Space::open(3, knots).unwrap(), curve.points().to_vec()).unwrap();
        let ask =
            Fair::new(&other).energy(bend()).ask(position(0.0).keep()).ask(position(9.0 * scale).keep());
        let ask = ask.ask(position(4.5 * scale).to([3.0, 1.0, 2.0])).ask(tangent(2.0 * scale).keep());
        for (a, b) in plain.shape().points().iter().zip(ask.solve().unwrap().shape().points()) {
            assert!((a - b).norm() < 1e-11, "{scale:e}");
        }
    }
    // A million times its size away, it is as fair as its coordinates allow.
    let shift = Vector::new(1e6, -2e6, 3e6);
    let moved: Vec<Point> = curve.points().iter().map(|p| p + shift).collect();
    let moved = fair(&Curve::new(curve.space().clone(), moved).unwrap(), 1.0, shift);
    for (a, b) in plain.shape().points().iter().zip(moved.shape().points()) {
        assert!((a + shift - b).norm() < 1e-8);
    }
}

#[test]
fn many_vertices_take_few_steps() {
    let (mut steps, mut energies) = (Vec::new(), Vec::new());
    for n in [100, 1000, 10_000] {
        let curve = wild(Space::clamped_uniform(3, n).unwrap());
        let end = (n - 3) as f64;
        let mut fair = Fair::new(&curve).energy(bend());
        for i in 0..=20 {
            let u = end * f64::from(i) / 20.0;
            fair = fair.ask(position(u).to([u, if i % 2 == 0 { 0.0 } else { end / 20.0 }, 0.0]));
        }
        let fair = fair.solve().unwrap();
        let report = fair.report();
        assert!(report.residual < 1e-15 * end * 50.0, "{report}");
        assert!(report.gap < 1e-12, "{report}");
        steps.push(report.iterations);
        // Sites h apart, heights h: second derivatives go with 1/h, their integral too.
        energies.push(report.energy_after * end);
    }
    assert!((energies[2] / energies[1] - 1.0).abs() < 1e-3, "{energies:?}");
    assert!(steps.iter().all(|&s| s <= 60), "{steps:?}");
}

#[test]
fn a_plate_on_three_feet_is_flat_and_one_on_four_saddles() {
    let space = Space::clamped_uniform(3, 7).unwrap();
    let net = (0..49).map(|k| Point::new(f64::from(k / 7), f64::from(k % 7), f64::from(k * k % 5))).collect();
    let plate = Surface::new(space.clone(), space, net).unwrap();
    let ask = |corners: &[([f64; 2], f64)]| {
        let mut fair = Fair::new(&plate).energy(bend());
        for &(at, z) in corners {
            fair = fair.ask(position(at).to([at[0], at[1], z]));
        }
        fair.solve().unwrap()
    };
    let flat = ask(&[([0.0, 0.0], 0.0), ([4.0, 0.0], 4.0), ([0.0, 4.0], 8.0)]);
    assert!(flat.report().energy_after < 1e-22, "{}", flat.report());
    let at = flat.shape().point(3.0, 1.0).unwrap();
    assert!((at - Point::new(3.0, 1.0, 5.0)).norm() < 1e-12, "{at}");
    // z = uv/4 bends nowhere along the axes and least of all: ∫∫ 2 |S_uv|² = 2 · 16/16.
    let saddle = ask(&[([0.0, 0.0], 0.0), ([4.0, 0.0], 0.0), ([0.0, 4.0], 0.0), ([4.0, 4.0], 4.0)]);
    assert!((saddle.report().energy_after - 2.0).abs() < 1e-12, "{}", saddle.report());
    assert!((saddle.shape().point(2.0, 2.0).unwrap().z - 1.0).abs() < 1e-12);
}

#[test]
fn another_shape_that_is_joined_stays_as_it_is() {
    let (a, b) = (wild(Space::clamped_uniform(3, 9).unwrap()), wild(Space::clamped_uniform(3, 8).unwrap()));
    let joined = Fair::new(&a)
        .energy(variation())
        .with(Box::new(b.clone()))
        .ask(position(0.0).keep())
        .ask(join(6.0, 1, 0.0, 2).hold())
        .solve()
        .unwrap();
    for order in 0..3 {
        let (end, start) =
            (joined.shape().derivative(6.0, order).unwrap(), b.derivative(0.0, order).unwrap());
        assert!((end - start).norm() < 1e-12);
    }
}
