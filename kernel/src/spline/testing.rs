//! What the tests of splines share: random spaces and shapes of every kind, and comparison of shapes.

use proptest::prelude::*;

use super::{Curve, Space, Surface};
use crate::Point;

/// A space of a degree: clamped, floating or periodic, knots repeated here and there, breakpoints mostly integers.
pub(crate) fn any_space(degrees: impl Strategy<Value = usize>) -> impl Strategy<Value = Space> {
    (degrees, 0..3_u8).prop_flat_map(|(degree, kind)| {
        let gaps = prop::collection::vec((prop_oneof![Just(1.0), 0.05..3.0_f64], 1..=degree + 1), 2..9);
        gaps.prop_map(move |gaps| {
            // A knot repeated p + 1 times tears a shape; periodic ones cannot be torn.
            let most = if kind == 2 { degree } else { degree + 1 };
            let mut t = -2.0;
            let mut knots = Vec::new();
            for (gap, times) in gaps {
                t += gap;
                // Half of the knots stay simple.
                knots.extend(std::iter::repeat_n(t, if gap == 1.0 { times.min(most) } else { 1 }));
            }
            match kind {
                0 => {
                    knots.splice(0..0, vec![-2.0; degree + 1]);
                    knots.extend(vec![t + 1.0; degree + 1]);
                    Space::open(degree, knots).unwrap()
                }
                1 if knots[0] == -1.0 => {
                    // Floating, with a knot that may be repeated where the domain starts.
                    knots.splice(0..0, (0..degree).map(|i| -2.0 - (degree - 1 - i) as f64 / 2.0));
                    knots.extend((0..=degree).map(|i| t + 0.5 + 0.3 * i as f64));
                    Space::open(degree, knots).unwrap()
                }
                1 => {
                    knots.splice(0..0, (0..=degree).map(|i| -2.0 - 0.7 * (degree - i) as f64));
                    knots.extend((0..=degree).map(|i| t + 0.5 + 0.3 * i as f64));
                    Space::open(degree, knots).unwrap()
                }
                _ => {
                    // At times the seam is a knot repeated p times, some copies at the start and some at the end.
                    let extra = if knots[0] == -1.0 { degree - 1 } else { 0 };
                    knots.splice(0..0, vec![-2.0; 1 + extra / 2]);
                    knots.extend(vec![t + 0.75; 1 + extra - extra / 2]);
                    Space::periodic(degree, knots).unwrap()
                }
            }
        })
    })
}

fn any_net(count: usize) -> impl Strategy<Value = (Vec<Point>, Option<Vec<f64>>)> {
    let coordinate = || -10.0..10.0_f64;
    let point = (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| Point::new(x, y, z));
    (prop::collection::vec(point, count), prop::option::of(prop::collection::vec(0.2..5.0_f64, count)))
}

/// A curve of degree 1 to 5, now and then 25, polynomial or rational.
pub(crate) fn any_curve() -> impl Strategy<Value = Curve> {
    let degrees = prop_oneof![9 => 1..=5_usize, 1 => Just(25_usize)];
    any_space(degrees).prop_flat_map(|space| {
        any_net(space.len())
            .prop_map(move |(points, weights)| Curve::build(space.clone(), points, weights).unwrap())
    })
}

/// A surface of degrees 1 to 4, polynomial or rational.
pub(crate) fn any_surface() -> impl Strategy<Value = Surface> {
    (any_space(1..=4_usize), any_space(1..=4_usize)).prop_flat_map(|(u, v)| {
        any_net(u.len() * v.len())
            .prop_map(move |(points, weights)| Surface::build(u.clone(), v.clone(), points, weights).unwrap())
    })
}

/// Whether a space is torn: at such a knot a rounded parameter may belong to either side.
pub(crate) fn is_torn(space: &Space) -> bool {
    let (a, b) = space.domain();
    space.breakpoints().iter().any(|&t| t > a && t < b && space.multiplicity(t) > space.degree())
}

/// A clamped uniform curve of some wiggly shape.
pub(crate) fn line_of(degree: usize, vertices: usize) -> Curve {
    let points = (0..vertices).map(|i| i as f64).map(|i| Point::new(i, i.sin(), (0.7 * i).cos())).collect();
    Curve::new(Space::clamped_uniform(degree, vertices).unwrap(), points).unwrap()
}

/// Parameters spread over an interval, both ends included.
pub(crate) fn parameters(a: f64, b: f64) -> impl Iterator<Item = f64> {
    (0..=32).map(move |i| (a + (b - a) * f64::from(i) / 32.0).clamp(a, b))
}

/// Asserts equal points everywhere in `found`'s domain, within `tolerance` of the size of the control polygon.
pub(crate) fn assert_same_curve(expected: &Curve, found: &Curve, tolerance: f64) {
    let (a, b) = found.domain();
    let size = expected.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    for u in parameters(a, b) {
        let (e, f) = (expected.point(u).unwrap(), found.point(u).unwrap());
        assert!((e - f).norm() <= tolerance * size, "at {u}: {f}, not {e}\n{expected:?}\n{found:?}");
    }
}

/// Asserts equal points everywhere in `found`'s domain, within `tolerance` of the size of the control net.
pub(crate) fn assert_same_surface(expected: &Surface, found: &Surface, tolerance: f64) {
    let ((a, b), (c, d)) = (found.u().domain(), found.v().domain());
    let size = expected.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    for u in parameters(a, b).step_by(4) {
        for v in parameters(c, d).step_by(3) {
            let (e, f) = (expected.point(u, v).unwrap(), found.point(u, v).unwrap());
            assert!(
                (e - f).norm() <= tolerance * size,
                "at ({u}, {v}): {f}, not {e}\n{expected:?}\n{found:?}"
            );
        }
    }
}
