//! Shapes that are no splines, faired by their cells alone.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_fairing::{Fair, bend, near, stretch};
use loftsman_kernel::Point;
use loftsman_kernel::conformance::Patches;
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::spline::{CatmullRom, Spacing};

/// The control vertices on the boundary of the patches.
const RIM: [i64; 14] = [0, 1, 2, 3, 5, 6, 8, 9, 13, 14, 15, 16, 17, 18];

#[test]
fn a_membrane_of_patches_over_a_straight_rim_is_flat() {
    let mut crumpled = Patches::flat();
    for (k, p) in crumpled.control_vertices_mut().iter_mut().enumerate() {
        if !RIM.contains(&(k as i64)) {
            *p += loftsman_kernel::Vector::new(0.1, -0.05, 0.3) * (k % 3 + 1) as f64;
        }
    }
    // Its own parameters are harmonic, so that of all surfaces over this rim it is the one of least stretch.
    let fair = Fair::new(&crumpled).energy(stretch()).lock(RIM).solve().unwrap();
    for (p, flat) in fair.shape().control_vertices().iter().zip(Patches::flat().control_vertices()) {
        assert!((p - flat).norm() < 1e-10, "{p} {flat}");
    }
    assert!((fair.report().energy_after - 4.0).abs() < 1e-10, "{:?}", fair.report());
    // With a weight on where it was, between both; and through a point.
    let fair =
        Fair::new(&crumpled).energy(bend() + near()).lock(RIM).ask(position([1.3, 0.4]).to([1.3, 0.4, 0.5]));
    let fair = fair.solve().unwrap();
    let through = fair.shape().value([1.3, 0.4].into(), Derivative::POSITION).unwrap();
    assert!((through.z - 0.5).abs() < 1e-12);
    assert!(fair.report().energy_after > 0.0);
}

#[test]
fn a_curve_through_its_vertices_bends_least_as_a_line() {
    let points = (0..8).map(|k| Point::new(f64::from(k), f64::from(k % 3), 0.2 * f64::from(k % 2))).collect();
    let curve = CatmullRom::new(points, false, Spacing::Uniform).unwrap();
    let [a, b] = [curve.points()[0], curve.points()[7]];
    let fair =
        Fair::new(&curve).energy(bend()).ask(position(0.0).keep()).ask(position(7.0).keep()).solve().unwrap();
    for (k, p) in fair.shape().points().iter().enumerate() {
        let line = a + (b - a) * (k as f64 / 7.0);
        assert!((p - line).norm() < 1e-6, "{p} {line}");
    }
    assert!(fair.report().energy_after < 1e-12 * fair.report().energy_before);
}
