//! Two curves, or two surfaces along an edge, made into one.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::Point;
use crate::error::{Error, Result};
use crate::text::figure;

/// What joining gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined<T> {
    /// The one shape: the first over its own domain, then the second, its parameters shifted.
    pub shape: T,
    /// The largest distance by which the ends were apart; each was moved by half of it.
    pub gap: f64,
    /// The order up to which derivatives agree at the joint: 0 where only the ends meet, up to the degree.
    /// They count as agreeing within 1e-9 of their size, or within what rounding of the vertices can do.
    pub continuity: usize,
}

impl Curve {
    /// This curve and another that starts where it ends, as one curve. Both are clamped, the lower degree raised,
    /// and the other's domain shifted to start where this one's ends. The knot at the joint is repeated `p` times.
    ///
    /// `tolerance` is the largest gap between the ends that is closed, a length in the unit of the points; each end
    /// vertex moves by half the gap.
    ///
    /// # Errors
    /// When a curve is periodic (it has no ends: [`split`](Self::split) it first), the gap is wider than
    /// `tolerance`, or that is negative or not a number.
    pub fn join(&self, other: &Self, tolerance: f64) -> Result<Joined<Self>> {
        let (ways, joint) = ways(self.space(), other.space())?;
        let convert = |curve: &Self, steps: &[Conversion]| {
            steps.iter().try_fold(curve.clone(), |curve, step| curve.convert(step))
        };
        let (first, second) = (convert(self, &ways[0])?, convert(other, &ways[1])?);
        let space = joined_space(first.space(), second.space())?;
        let nets = [(first.points(), first.weights()), (second.points(), second.weights())];
        let lengths = [first.space().len(), second.space().len()];
        let net = JoinedNet::join(nets, lengths, 1, 1, tolerance)?;
        let continuity = net.continuity(&space, joint, lengths[0], 1, 1);
        Ok(Joined { shape: Self::build(space, net.points, net.weights)?, gap: net.gap, continuity })
    }
}

impl Surface {
    /// This surface and another that continues it across the end of `direction`, as one surface; along the edge
    /// both are brought to a common space ([`Space::common`]). See [`Curve::join`].
    ///
    /// # Errors
    /// As for [`Curve::join`]; also when the weights along the two edges are not proportional (to 1e-9).
    pub fn join(&self, direction: Direction, other: &Self, tolerance: f64) -> Result<Joined<Self>> {
        let across = match direction {
            Direction::U => Direction::V,
            Direction::V => Direction::U,
        };
        let common = self.space(across).common(other.space(across))?;
        let (ways, joint) = ways(self.space(direction), other.space(direction))?;
        let convert = |surface: &Self, along: &[Conversion], edge: &[Conversion]| {
            let surface = along.iter().try_fold(surface.clone(), |s, step| s.convert(direction, step))?;
            edge.iter().try_fold(surface, |s, step| s.convert(across, step))
        };
        let first = convert(self, &ways[0], &common.first)?;
        let second = convert(other, &ways[1], &common.second)?;
        let space = joined_space(first.space(direction), second.space(direction))?;
        let edge = first.space(across).clone();
        let nets = [(first.points(), first.weights()), (second.points(), second.weights())];
        let lengths = [first.space(direction).len(), second.space(direction).len()];
        let (outer, inner) = match direction {
            Direction::U => (1, edge.len()),
            Direction::V => (edge.len(), 1),
        };
        let net = JoinedNet::join(nets, lengths, outer, inner, tolerance)?;
        let continuity = net.continuity(&space, joint, lengths[0], outer, inner);
        let (u, v) = match direction {
            Direction::U => (space, edge),
            Direction::V => (edge, space),
        };
        Ok(Joined { shape: Self::build(u, v, net.points, net.weights)?, gap: net.gap, continuity })
    }
}

/// The steps of both spaces to clamped ones of one degree whose domains follow one another, and where they meet.
fn ways(first: &Space, second: &Space) -> Result<([Vec<Conversion>; 2], f64)> {
    let degree = first.degree().max(second.degree());
    let (_, joint) = first.domain();
    let mut ways = [Vec::new(), Vec::new()];
    for (i, space) in [first, second].into_iter().enumerate() {
        if space.is_periodic() {
            return Err(Error::Invalid(format!(
                "the {} shape is periodic and has no end to join: split it where it should open",
                ["first", "second"][i]
            )));
        }
        let mut space = space.clone();
        let mut step = |conversion: Conversion| {
            let to = conversion.to().clone();
            ways[i].push(conversion);
            to
        };
        if !space.is_clamped() {
            space = step(space.clamping()?);
        }
        while space.degree() < degree {
            space = step(space.elevating()?);
        }
        if i == 1 && space.domain().0 != joint {
            step(space.reparametrising(joint, joint + space.length())?);
        }
    }
    Ok((ways, joint))
}

/// One clamped space after another, the knot between them repeated `p` times.
fn joined_space(first: &Space, second: &Space) -> Result<Space> {
    let p = first.degree();
    let (before, after) = (first.flat(), second.flat());
    Space::open(p, [&before[..before.len() - 1], &after[p + 1..]].concat())
}

/// Control vertices of two shapes joined: an array `outer × n × inner`, joined along its middle axis.
struct JoinedNet {
    points: Vec<Point>,
    weights: Option<Vec<f64>>,
    gap: f64,
}

impl JoinedNet {
    fn join(
        nets: [(&[Point], Option<&[f64]>); 2],
        lengths: [usize; 2],
        outer: usize,
        inner: usize,
        tolerance: f64,
    ) -> Result<Self> {
        let [(first, first_weights), (second, second_weights)] = nets;
        if tolerance.is_nan() || tolerance < 0.0 {
            return Err(Error::Invalid(format!(
                "the tolerance {tolerance} is no length: give zero or a positive number"
            )));
        }
        let [n, m] = lengths;
        let rational = first_weights.is_some() || second_weights.is_some();
        let weight = |weights: Option<&[f64]>, i: usize| weights.map_or(1.0, |w| w[i]);
        // A common factor on all weights changes nothing: choose the one that makes the joint's weights equal.
        let factor = weight(first_weights, (n - 1) * inner) / weight(second_weights, 0);
        let count = outer * (n + m - 1) * inner;
        let mut net = Self {
            points: Vec::with_capacity(count),
            weights: rational.then(|| Vec::with_capacity(count)),
            gap: 0.0,
        };
        for o in 0..outer {
            for k in 0..n + m - 1 {
                for c in 0..inner {
                    let i = (o * n + k.min(n - 1)) * inner + c;
                    let j = (o * m + (k + 1).saturating_sub(n)) * inner + c;
                    let (mut point, mut w) = (first[i], weight(first_weights, i));
                    let w2 = weight(second_weights, j) * factor;
                    if k == n - 1 {
                        let step = second[j] - point;
                        net.gap = net.gap.max(step.norm());
                        if (w - w2).abs() > 1e-9 * w {
                            return Err(Error::Invalid(format!(
                                "weight {w} on the first edge meets {w2} on the second: the weights along both must \
                                 be the same but for one factor"
                            )));
                        }
                        point += 0.5 * step;
                    } else if k >= n {
                        (point, w) = (second[j], w2);
                    }
                    net.points.push(point);
                    if let Some(weights) = &mut net.weights {
                        weights.push(w);
                    }
                }
            }
        }
        if net.gap > tolerance {
            return Err(Error::Invalid(format!(
                "the ends are {} apart, more than the tolerance {}: move them together, or raise it",
                figure(net.gap),
                figure(tolerance)
            )));
        }
        Ok(net)
    }

    /// The order up to which derivatives at the joint agree along every line of the net.
    ///
    /// The k-th derivatives of homogeneous coordinates at the end of a clamped spline are made of the last `k + 1`
    /// vertices; a rational curve whose homogeneous derivatives agree up to `k` is C^k.
    fn continuity(&self, space: &Space, joint: f64, n: usize, outer: usize, inner: usize) -> usize {
        let p = space.degree();
        let m = self.points.len() / (outer * inner);
        let span = space.span(joint);
        let at = |derivative: usize, left: bool| {
            let (span, mut row) = (if left { span - p } else { span }, [0.0; super::space::MAX_ORDER]);
            space.basis_into(span, joint, derivative, &mut row);
            row
        };
        for k in 1..=p {
            let (left, right) = (at(k, true), at(k, false));
            for o in 0..outer {
                for c in 0..inner {
                    // The p + 1 vertices on the left of the joint and as many on its right share the one at it.
                    let vertex = |i: usize| {
                        let i = (o * m + i) * inner + c;
                        let w = self.weights.as_ref().map_or(1.0, |w| w[i]);
                        (self.points[i].coords * w).push(w)
                    };
                    let sum = |row: &[f64], first: usize| {
                        let terms = row[..=p].iter().enumerate().map(|(j, &r)| (vertex(first + j), r));
                        terms.fold((nalgebra::Vector4::zeros(), 0.0_f64), |(sum, size), (v, r)| {
                            (sum + v * r, size + v.amax() * r.abs())
                        })
                    };
                    let ((l, noise_l), (r, noise_r)) = (sum(&left, n - 1 - p), sum(&right, n - 1));
                    let rounding = 16.0 * f64::EPSILON * (noise_l + noise_r);
                    if (l - r).amax() > 1e-9 * l.amax().max(r.amax()) + rounding {
                        return k - 1;
                    }
                }
            }
        }
        p
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{
        any_curve, any_surface, assert_same_curve, assert_same_surface, is_torn, line_of,
    };
    use super::*;
    use crate::Vector;

    proptest! {
        #[test]
        fn what_was_split_joins_again(curve in any_curve(), s in 0.1..0.9_f64) {
            let (a, b) = curve.domain();
            let curve = if curve.is_periodic() { curve.to_clamped().unwrap() } else { curve };
            let parts = curve.split(a + s * (b - a)).unwrap();
            let joined = parts[0].join(&parts[1], 0.0).unwrap();
            assert_same_curve(&curve, &joined.shape, 1e-12);
            let multiplicity = curve.space().multiplicity(a + s * (b - a));
            prop_assert!(joined.continuity >= curve.degree() - multiplicity, "{}", joined.continuity);
        }

        #[test]
        fn different_degrees_and_weights(first in any_curve(), second in any_curve()) {
            prop_assume!(!is_torn(second.space()));
            prop_assume!(!first.is_periodic() && !second.is_periodic());
            let end = first.point(first.domain().1).unwrap();
            let start = second.point(second.domain().0).unwrap();
            let (space, mut points, weights) = second.into_parts();
            points.iter_mut().for_each(|p| *p += end - start);
            let second = Curve::build(space, points, weights).unwrap();
            let joined = first.join(&second, 1e-10).unwrap().shape;
            let (a, b) = first.domain();
            assert_same_curve(&first, &joined.between(a, b).unwrap(), 1e-11);
            let tail = joined.between(b, joined.domain().1).unwrap();
            let (c, d) = second.domain();
            assert_same_curve(&second, &tail.reparametrise(c, d).unwrap(), 1e-11);
        }

        #[test]
        fn surfaces_along_either_direction(surface in any_surface(), s in 0.1..0.9_f64) {
            let surface = surface.to_clamped().unwrap();
            for direction in [Direction::U, Direction::V] {
                let (a, b) = surface.space(direction).domain();
                let parts = surface.split(direction, a + s * (b - a)).unwrap();
                let joined = parts[0].join(direction, &parts[1], 0.0).unwrap();
                assert_same_surface(&surface, &joined.shape, 1e-12);
            }
        }
    }

    #[test]
    fn the_continuity_is_told() {
        let line = |a: [f64; 2], b: [f64; 2]| {
            Curve::bezier(vec![Point::new(a[0], a[1], 0.0), Point::new(b[0], b[1], 0.0)]).unwrap()
        };
        let first = line([0.0, 0.0], [1.0, 1.0]);
        assert_eq!(first.join(&line([1.0, 1.0], [2.0, 2.0]), 0.0).unwrap().continuity, 1);
        assert_eq!(first.join(&line([1.0, 1.0], [2.0, 1.0]), 0.0).unwrap().continuity, 0);
        let curve = line_of(3, 9);
        let parts = curve.split(2.5).unwrap();
        assert_eq!(parts[0].join(&parts[1], 0.0).unwrap().continuity, 3);
        let parts = curve.split(2.0).unwrap();
        assert_eq!(parts[0].join(&parts[1], 0.0).unwrap().continuity, 2);
    }

    #[test]
    fn gaps_and_closed_curves() {
        let curve = line_of(3, 9);
        let mut parts = curve.split(2.5).unwrap();
        let (space, mut points, _) = parts[1].clone().into_parts();
        points[0] += Vector::new(0.0, 3e-3, 0.0);
        parts[1] = Curve::new(space, points).unwrap();
        assert!(parts[0].join(&parts[1], 1e-3).is_err());
        assert!(parts[0].join(&parts[1], f64::NAN).is_err());
        assert!((parts[0].join(&parts[1], 4e-3).unwrap().gap - 3e-3).abs() < 1e-15);
        let ring = Curve::new(Space::periodic_uniform(3, 9).unwrap(), curve.points().to_vec()).unwrap();
        assert!(ring.join(&curve, 1.0).is_err() && curve.join(&ring, 1.0).is_err());
    }
}
