//! Lengths of closed polygons, whose least adjustment is found slowly.

use std::f64::consts::TAU;

use loftsman_area_volume::length;
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit, Edited};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::{Curve, Space};

use crate::folded::random;

/// A closed polygon on the circle of radius about 1.2, its knots unevenly spaced.
fn polygon(vertices: usize, next: &mut impl FnMut() -> f64) -> Curve {
    let mut knots = vec![0.0];
    for _ in 0..vertices {
        knots.push(knots[knots.len() - 1] + [0.5, 1.0, 2.0, 0.3 + next()][(4.0 * next()) as usize]);
    }
    let points = (0..vertices).map(|i| {
        let (s, c) = (TAU * i as f64 / vertices as f64).sin_cos();
        let r = 1.0 + 0.4 * next();
        Point::new(r * c, r * s, 0.0)
    });
    let points = points.collect();
    Curve::new(Space::periodic(1, knots).unwrap(), points).unwrap()
}

fn perimeter(curve: &Curve) -> f64 {
    let p = curve.points();
    (0..p.len()).map(|i| (p[(i + 1) % p.len()] - p[i]).norm()).sum()
}

/// The eight vertices whose length could be 8.5 and 9, but not between: the way there passes a place where the adjustment is
/// stationary and not least.
#[test]
fn a_length_is_reached_past_a_place_where_the_way_lingers() {
    let knots = vec![
        0.0,
        0.5,
        1.5,
        2.3280579911342256,
        3.3280579911342256,
        5.328057991134226,
        5.903406718463872,
        6.903406718463872,
        8.354410696740649,
    ];
    let points = [
        [1.1769441908257814, 0.0],
        [0.7764209795877033, 0.7770394703600769],
        [0.0, 1.2944060261393036],
        [-0.8425585834911637, 0.7629483263597808],
        [-1.2019180134181826, 0.0],
        [-0.736661545645808, -0.9036862757802823],
        [0.0, -1.1698113854730126],
        [0.7758571426969041, -0.852139855677253],
    ];
    let points = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let curve = Curve::new(Space::periodic(1, knots).unwrap(), points).unwrap();
    for step in 0..=20 {
        let wanted = 8.4 + 0.03 * f64::from(step);
        let edited = Edit::new(&curve)
            .ask(length().to(wanted))
            .ask(position(0.3698823707423251).keep())
            .ask(position(4.934091955808485).by([-0.2273828796281347, -0.1879247408795758, 0.0]))
            .ask(position(2.1783258203280735).by([0.10331606138819453, -0.03323263329747712, 0.0]))
            .solve()
            .unwrap_or_else(|e| panic!("{wanted}: {e}"));
        let found = perimeter(edited.shape());
        assert!((found - wanted).abs() < 1e-12 * wanted, "{wanted}: {found}");
    }
}

#[test]
fn lengths_of_polygons_beside_positions_are_reached() {
    for seed in 0..120 {
        let mut next = random(seed);
        let curve = polygon(6 + (6.0 * next()) as usize, &mut next);
        let (a, b) = curve.domain();
        let wanted = perimeter(&curve) * (1.05 + 0.35 * next());
        let mut edit = Edit::new(&curve).ask(length().to(wanted));
        for k in 0..3 {
            let at = a + (b - a) * (f64::from(k) + 0.8 * next()) / 3.0;
            let by = [0.4 * next() - 0.2, 0.4 * next() - 0.2, 0.0];
            edit = edit.ask(position(at).by(by));
        }
        let found = edit.solve().map(Edited::into_shape).map(|shape| perimeter(&shape));
        match found {
            Ok(found) => assert!((found - wanted).abs() < 1e-12 * wanted, "{seed}: {wanted} {found}"),
            Err(error) => panic!("{seed}: {wanted}: {error}"),
        }
    }
}
