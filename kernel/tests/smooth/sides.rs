//! Stencils from either side of a knot, against the evaluator.

use loftsman_kernel::shape::{Location, Shape, Side};
use loftsman_kernel::spline::{CatmullRom, Curve, Spacing, Surface};
use loftsman_kernel::{Point, Vector};

use super::Dice;
use super::evaluator::{joints, on_curve, on_surface};
use super::families::{chain, conic, cornered, inserted};

#[test]
fn a_stencil_has_a_side_at_knots() {
    for seed in 0..200 {
        let mut dice = Dice(seed);
        let curve = [chain, conic, inserted, cornered][seed as usize % 4](&mut dice);
        let periodic = curve.is_periodic();
        for [left, right] in joints(curve.space(), 1, periodic) {
            for (side, place) in [(Side::Left, left), (Side::Right, right)] {
                let expected = on_curve(&curve, place);
                for (order, expected) in expected.into_iter().enumerate() {
                    let row = curve.stencil_on(Location::Curve(right.1), order.into(), side.into()).unwrap();
                    let got = row.apply(curve.points());
                    let size = expected.norm().max(1.0);
                    assert!((got - expected).norm() <= 1e-10 * size, "{seed}, {order}: {got} {expected}");
                }
            }
            let plain = curve.stencil(Location::Curve(right.1), 1.into()).unwrap();
            let right = curve.stencil_on(Location::Curve(right.1), 1.into(), Side::Right.into()).unwrap();
            assert_eq!(plain, right);
        }
        // Where there is no knot, and at the ends of an open curve, the sides are alike.
        let (a, b) = curve.domain();
        let between = [a + 0.377_123 * (b - a), a, b];
        for u in between.into_iter().take(if periodic { 1 } else { 3 }) {
            let [left, right] =
                [Side::Left, Side::Right].map(|s| curve.stencil_on(u.into(), 1.into(), s.into()).unwrap());
            assert_eq!(left, right);
            assert_eq!(right, curve.stencil(u.into(), 1.into()).unwrap());
        }
    }
}

#[test]
fn a_surface_has_sides_in_both_directions() {
    let profile = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&profile, Point::origin(), Vector::z(), 5.0).unwrap();
    for [left, right] in joints(torus.u(), 2, false) {
        for [before, after] in joints(torus.v(), 2, false) {
            for (side, place) in [(Side::Left, left), (Side::Right, right)] {
                for (other, along) in [(Side::Left, before), (Side::Right, after)] {
                    let at = Location::Surface(right.1, after.1);
                    let row = torus.stencil_on(at, [1, 0].into(), [side, other].into()).unwrap();
                    let expected = on_surface(&torus, place, along)[1];
                    assert!((row.apply(torus.points()) - expected).norm() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn a_catmull_rom_curve_has_the_sides_of_its_spline() {
    for seed in 0..40 {
        let mut dice = Dice(100 + seed);
        let closed = seed % 2 == 0;
        let points: Vec<Point> = (0..4 + dice.below(5)).map(|_| Point::from(dice.vector(3.0))).collect();
        let curve = CatmullRom::new(points, closed, Spacing::Centripetal).unwrap();
        let spline = curve.to_curve().unwrap();
        for u in curve.parameters() {
            for (side, order) in [(Side::Left, 1), (Side::Left, 2), (Side::Right, 2)] {
                let value = |shape: &dyn Shape| {
                    let row = shape.stencil_on(u.into(), order.into(), side.into()).unwrap();
                    row.apply(shape.control_vertices())
                };
                let (got, expected) = (value(&curve), value(&spline));
                assert!(
                    (got - expected).norm() <= 1e-10 * expected.norm().max(1.0),
                    "{seed}: {got} {expected}"
                );
            }
        }
    }
}
