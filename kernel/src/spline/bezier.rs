//! Bézier form: the pieces of a spline as polynomials, each with control vertices of its own.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::Point;
use crate::error::{Error, Result};

impl Space {
    /// The conversion to the open space with the same breakpoints in which every interior knot is repeated `p` times
    /// and both ends `p + 1` times. Its vertices `ip ..= ip + p` are the Bézier vertices of piece `i`. A periodic
    /// space is opened at its seam. Knots of multiplicity `p + 1`, where a shape is torn, stay so, and each moves the
    /// vertices after it on by one. `O(n p²)` for simple knots.
    ///
    /// # Errors
    /// When the degree is 0.
    pub fn to_bezier(&self) -> Result<Conversion> {
        let p = self.degree();
        if p == 0 {
            return Err(Error::Degree { degree: p });
        }
        let (a, b) = self.domain();
        let mut knots = vec![a; p + 1];
        // The knots inside the domain, run by run.
        let mut rest = &self.flat()[p + 1..self.unrolled_len()];
        while let Some(&t) = rest.first() {
            let run = rest.iter().take_while(|&&k| k == t).count();
            if t > a && t < b {
                knots.extend(std::iter::repeat_n(t, run.max(p)));
            }
            rest = &rest[run..];
        }
        knots.extend(std::iter::repeat_n(b, p + 1));
        Conversion::refining(self, Self::open(p, knots)?)
    }
}

impl Curve {
    /// The same curve with its Bézier vertices: open, clamped, every interior knot repeated `p` times (`p + 1` times
    /// where the curve is torn). For programs that do not know other knots.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn bezier_form(&self) -> Result<Self> {
        self.convert(&self.space().to_bezier()?)
    }

    /// The polynomial (or rational) pieces as curves of their own, each on its own part of the domain.
    ///
    /// # Errors
    /// When a piece of the domain is too short to be a domain of its own, or when numbers overflow.
    pub fn bezier_segments(&self) -> Result<Vec<Self>> {
        let p = self.degree();
        let form = self.bezier_form()?;
        let piece = |span: usize| {
            let (ends, vertices) = (&form.space().flat()[span..=span + 1], span - p..=span);
            Self::build(
                Space::clamped(p, ends)?,
                form.points()[vertices.clone()].to_vec(),
                form.weights().map(|w| w[vertices].to_vec()),
            )
        };
        form.space().spans().map(piece).collect()
    }
}

impl Surface {
    /// The same surface with its Bézier net: open and clamped in both directions, every interior knot at full
    /// multiplicity.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn bezier_form(&self) -> Result<Self> {
        self.convert(Direction::U, &self.u().to_bezier()?)?.convert(Direction::V, &self.v().to_bezier()?)
    }

    /// The polynomial (or rational) patches as surfaces of their own, each on its own part of the domain, row after
    /// row: all along `v` for the first piece of `u`, then for the next.
    ///
    /// # Errors
    /// When a piece of the domain is too short to be a domain of its own, or when numbers overflow.
    pub fn bezier_patches(&self) -> Result<Vec<Self>> {
        let form = self.bezier_form()?;
        let (p, q, columns) = (self.u().degree(), self.v().degree(), form.v().len());
        let mut patches = Vec::new();
        for i in form.u().spans() {
            for j in form.v().spans() {
                let net = || (i - p..=i).flat_map(|r| (j - q..=j).map(move |c| r * columns + c));
                patches.push(Self::build(
                    Space::clamped(p, &form.u().flat()[i..=i + 1])?,
                    Space::clamped(q, &form.v().flat()[j..=j + 1])?,
                    net().map(|k| form.points()[k]).collect(),
                    form.weights().map(|w| net().map(|k| w[k]).collect()),
                )?);
            }
        }
        Ok(patches)
    }
}

/// The point at `t` of the Bézier curve with these vertices: de Casteljau's repeated linear interpolation, for `t`
/// in `[0, 1]` a chain of convex combinations. `O(p²)`, one allocation.
///
/// With weights, every step interpolates in homogeneous coordinates (Farin 1983).
///
/// # Errors
/// When there are no vertices, the weights are not as many, or `t` is not finite.
pub fn de_casteljau(points: &[Point], weights: Option<&[f64]>, t: f64) -> Result<Point> {
    let (left, _) = de_casteljau_split(points, weights, t)?;
    match left.points.last() {
        Some(&point) => Ok(point),
        None => Err(Error::TooFewVertices { vertices: 0, degree: 1, needed: 2 }),
    }
}

/// Bézier vertices and their weights, where there are any.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BezierVertices {
    /// The vertices.
    pub points: Vec<Point>,
    /// Their weights; empty for a polynomial curve.
    pub weights: Vec<f64>,
}

/// The Bézier vertices of the parts before and after `t` of the Bézier curve with these vertices.
///
/// # Errors
/// When there are no vertices, the weights are not as many, or `t` is not finite.
pub fn de_casteljau_split(
    points: &[Point],
    weights: Option<&[f64]>,
    t: f64,
) -> Result<(BezierVertices, BezierVertices)> {
    if points.is_empty() {
        return Err(Error::TooFewVertices { vertices: 0, degree: 1, needed: 2 });
    }
    if let Some(w) = weights.filter(|w| w.len() != points.len()) {
        return Err(Error::WeightCount { weights: w.len(), vertices: points.len() });
    }
    if !t.is_finite() {
        return Err(Error::Outside { value: t, start: 0.0, end: 1.0 });
    }
    let mut right =
        BezierVertices { points: points.to_vec(), weights: weights.map_or_else(Vec::new, <[f64]>::to_vec) };
    let mut left = BezierVertices::default();
    for last in (0..points.len()).rev() {
        left.points.push(right.points[0]);
        left.weights.extend(right.weights.first());
        for i in 0..last {
            let mut share = t;
            if let [a, b] = right.weights.get(i..i + 2).unwrap_or_default() {
                let weight = (1.0 - t) * a + t * b;
                share = t * b / weight;
                right.weights[i] = weight;
            }
            let step = (right.points[i + 1] - right.points[i]) * share;
            right.points[i] += step;
        }
    }
    Ok((left, right))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, assert_same_surface, parameters};
    use super::*;

    proptest! {
        #[test]
        fn bezier_form_is_the_same_curve(curve in any_curve()) {
            let form = curve.bezier_form().unwrap();
            prop_assert!(form.space().is_clamped());
            let breakpoints = form.space().breakpoints();
            for &t in &breakpoints[1..breakpoints.len() - 1] {
                let expected = curve.degree().max(curve.space().multiplicity(t));
                prop_assert_eq!(form.space().multiplicity(t), expected);
            }
            assert_same_curve(&curve, &form, 1e-12);
        }

        #[test]
        fn pieces_by_de_casteljau_are_the_same_curve(curve in any_curve()) {
            let pieces = curve.bezier_segments().unwrap();
            prop_assert_eq!(pieces.len(), curve.space().spans().count());
            let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
            for piece in pieces {
                let (a, b) = piece.domain();
                for t in parameters(0.0, 1.0) {
                    // Short of the end, beyond which a torn curve goes on elsewhere.
                    let u = (a + t * (b - a)).clamp(a, b);
                    if u == b && b < curve.domain().1 {
                        continue;
                    }
                    let expected = curve.point(u).unwrap();
                    let found = de_casteljau(piece.points(), piece.weights(), (u - a) / (b - a)).unwrap();
                    prop_assert!((found - expected).norm() <= 1e-12 * size, "{found} is not {expected}");
                }
            }
        }

        #[test]
        fn surfaces_too(surface in any_surface()) {
            let form = surface.bezier_form().unwrap();
            assert_same_surface(&surface, &form, 1e-12);
            let patches = surface.bezier_patches().unwrap();
            prop_assert_eq!(patches.len(), surface.u().spans().count() * surface.v().spans().count());
            for patch in patches {
                let ((a, b), (c, d)) = (patch.u().domain(), patch.v().domain());
                let (u, v) = (0.3 * a + 0.7 * b, 0.6 * c + 0.4 * d);
                prop_assert!((patch.point(u, v).unwrap() - surface.point(u, v).unwrap()).norm() < 1e-11);
            }
        }
    }

    #[test]
    fn bezier_form_of_a_uniform_cubic_has_the_known_coefficients() {
        let points: Vec<Point> = [1.0, 5.0, -2.0, 7.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let curve = Curve::new(Space::floating_uniform(3, 4).unwrap(), points).unwrap();
        let form = curve.bezier_form().unwrap();
        let expected =
            [(1.0 + 20.0 - 2.0) / 6.0, (10.0 - 2.0) / 3.0, (5.0 - 4.0) / 3.0, (5.0 - 8.0 + 7.0) / 6.0];
        for (p, x) in form.points().iter().zip(expected) {
            assert!((p.x - x).abs() < 1e-15);
        }
    }

    #[test]
    fn bad_input_of_de_casteljau_is_refused() {
        let points = [Point::origin(), Point::new(1.0, 0.0, 0.0)];
        assert!(de_casteljau(&[], None, 0.5).is_err());
        assert!(de_casteljau(&points, Some(&[1.0]), 0.5).is_err());
        assert!(de_casteljau(&points, None, f64::NAN).is_err());
    }
}
