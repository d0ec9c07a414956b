//! Curves with knots at which corners can appear, some of them smooth there.

use std::f64::consts::TAU;

use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::Dice;

/// A Bézier chain of any degree from 1 to 7, smooth by construction, its ratios unequal; polynomial or rational; over knots
/// of uneven spacing, each repeated as often as the degree, or once oftener. Some are closed, with a smooth seam.
pub(crate) fn chain(dice: &mut Dice) -> Curve {
    let p = 1 + dice.below(7);
    chain_of(p, dice)
}

/// One of degree `p`.
pub(crate) fn chain_of(p: usize, dice: &mut Dice) -> Curve {
    let pieces = 2 + dice.below(5);
    let closed = p > 1 && pieces > 2 && dice.below(3) == 0;
    let torn = dice.below(4) == 0;
    // Directions at the joints, positions at the joints, then what is between.
    let heading = dice.vector(1.0).normalize();
    let mut joints: Vec<(Point, Vector)> = (0..=pieces)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / pieces as f64).sin_cos();
            let at = Point::new(4.0 * cos, 4.0 * sin, 0.0) + dice.vector(0.6);
            (at, (Vector::new(-sin, cos, 0.0) + dice.vector(0.5)).normalize())
        })
        .collect();
    if closed {
        joints[pieces] = joints[0];
    }
    if p == 1 {
        // Nothing but a straight line is smooth.
        let mut at = Point::from(dice.vector(2.0));
        for joint in &mut joints {
            *joint = (at, heading);
            at += heading * dice.between(0.2, 2.0);
        }
    }
    let mut polygon: Vec<Vec<Point>> = Vec::new();
    for k in 0..pieces {
        let ((a, s), (b, e)) = (joints[k], joints[k + 1]);
        let mut piece = vec![a];
        if p > 2 {
            piece.push(a + s * dice.between(0.2, 2.0));
            piece.extend((0..p - 3).map(|_| a + (b - a) * dice.between(0.2, 0.8) + dice.vector(0.5)));
            piece.push(b - e * dice.between(0.2, 2.0));
        } else if p == 2 {
            piece.push(a + (b - a) * 0.5 + dice.vector(0.6));
        }
        piece.push(b);
        polygon.push(piece);
    }
    if p == 2 {
        // The joints lie between the corners.
        for k in 0..pieces {
            let next = (k + 1) % pieces;
            if next == 0 && !closed {
                continue;
            }
            let (c, d) = (polygon[k][1], polygon[next][1]);
            let joint = c + (d - c) * dice.between(0.2, 0.8);
            polygon[k][2] = joint;
            polygon[next][0] = joint;
        }
    }
    let mut knots = vec![0.0; p + 1];
    let mut points = polygon[0].clone();
    let mut u = 0.0;
    for (k, piece) in polygon.iter().enumerate() {
        u += dice.between(0.3, 3.0);
        let last = k + 1 == pieces;
        knots.extend(std::iter::repeat_n(u, if last || torn { p + 1 } else { p }));
        if k > 0 {
            points.extend_from_slice(&piece[usize::from(!torn)..]);
        }
    }
    let weights: Option<Vec<f64>> =
        (dice.below(2) == 0).then(|| points.iter().map(|_| dice.between(0.3, 3.0)).collect());
    Curve::build(Space::open(p, knots).unwrap(), points, weights).unwrap()
}

/// Circles and ellipses as they are made: nine vertices, double knots; open with a seam, or periodic; arcs.
pub(crate) fn conic(dice: &mut Dice) -> Curve {
    let (center, x, y) = (Point::from(dice.vector(3.0)), dice.vector(2.0), dice.vector(2.0));
    match dice.below(4) {
        0 => Curve::circle(center, x, dice.between(0.5, 4.0)).unwrap(),
        1 => Curve::circle(center, x, 2.0).unwrap().to_periodic(1e-9).unwrap().shape,
        2 => Curve::ellipse(center, x, y).unwrap(),
        _ => Curve::elliptic_arc(center, x, y, dice.between(0.0, 6.0), dice.between(2.0, 6.0)).unwrap(),
    }
}

/// A smooth spline (clamped, floating or periodic), every knot inserted until it is a Bézier chain: what our own OBJ files
/// hold.
pub(crate) fn inserted(dice: &mut Dice) -> Curve {
    let p = 2 + dice.below(4);
    let n = p + 2 + dice.below(5);
    let points: Vec<Point> = (0..n)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            Point::new(3.0 * cos, 3.0 * sin, 0.0) + dice.vector(0.7)
        })
        .collect();
    let curve = match dice.below(3) {
        0 => Curve::new(Space::clamped_uniform(p, n).unwrap(), points).unwrap(),
        1 => Curve::new(Space::periodic_uniform(p, n).unwrap(), points).unwrap(),
        _ => Curve::new(Space::periodic_uniform(p, n).unwrap(), points).unwrap().to_clamped().unwrap(),
    };
    let inner: Vec<f64> = curve.space().breakpoints();
    let (a, b) = curve.domain();
    let missing = |k: f64| std::iter::repeat_n(k, p - curve.space().multiplicity(k));
    let knots: Vec<f64> = inner.into_iter().filter(|&k| k > a && k < b).flat_map(missing).collect();
    curve.insert_knots(&knots).unwrap()
}

/// A chain in which some joints are corners and (where knots allow it) some are torn apart.
pub(crate) fn cornered(dice: &mut Dice) -> Curve {
    let (space, mut points, weights) = chain(dice).into_parts();
    for point in &mut points {
        if dice.below(6) == 0 {
            *point += dice.vector(0.8);
        }
    }
    Curve::build(space, points, weights).unwrap()
}
