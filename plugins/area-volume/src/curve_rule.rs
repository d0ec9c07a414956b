//! Integrals along a curve: its functions at Gauss points, and the points and derivatives there.

use loftsman_kernel::error::Error;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result, Vector};

use crate::rule::Rule;

impl Rule {
    /// `per` points on each of `parts` parts of every span, with the curve's (rational) functions.
    pub(crate) fn of_curve(curve: &Curve, per: usize, parts: usize) -> Self {
        let rule = Self::new(curve.space(), per, parts);
        match curve.weights() {
            Some(weights) => rule.weighted(weights),
            None => rule,
        }
    }

    /// A rule for an integrand of degree `degree` in polynomial curves; for rational ones refined until `integral`, of the
    /// curve as it is, changes by less than 1e-13 of its size.
    pub(crate) fn settled(
        curve: &Curve,
        degree: usize,
        integral: impl Fn(&Self, &[Point]) -> f64,
    ) -> Result<Self> {
        let exact = degree / 2 + 1;
        let mut rule = Self::of_curve(curve, exact, 1);
        if curve.weights().is_none() {
            return Ok(rule);
        }
        let mut last = integral(&rule, curve.points());
        for round in 0..16 {
            let (per, parts) = (exact + 4 * (round + 1).min(4), 1 << usize::max(round, 3).saturating_sub(3));
            let finer = Self::of_curve(curve, per, parts);
            let now = integral(&finer, curve.points());
            if (now - last).abs() <= 1e-13 * now.abs() {
                return Ok(rule);
            }
            (rule, last) = (finer, now);
        }
        Err(Error::Invalid("the curve's weights differ too much for its centroid to be told".into()))
    }

    /// Calls `found` with point (from `origin`), derivative, weight, and functions with their vertices, at every Gauss point.
    pub(crate) fn along<'r>(
        &'r self,
        points: &[Point],
        origin: &Point,
        mut found: impl FnMut(Vector, Vector, f64, Local<'r>),
    ) {
        for panel in 0..self.panels() {
            let vertices = self.vertices_of(panel);
            for at in panel * self.per..(panel + 1) * self.per {
                let (values, slopes) = self.functions(at);
                let (mut point, mut slope) = (Vector::zeros(), Vector::zeros());
                for (k, &v) in vertices.iter().enumerate() {
                    let p = points[v as usize] - origin;
                    point += p * values[k];
                    slope += p * slopes[k];
                }
                found(point, slope, self.weights[at], Local { vertices, values, slopes });
            }
        }
    }
}

/// The functions that do not vanish at a Gauss point.
#[derive(Clone, Copy)]
pub(crate) struct Local<'r> {
    vertices: &'r [u32],
    values: &'r [f64],
    slopes: &'r [f64],
}

impl Local<'_> {
    /// `gradient_i += R_i value + R'_i slope`.
    pub(crate) fn add(&self, value: Vector, slope: Vector, gradient: &mut [Vector]) {
        for (k, &v) in self.vertices.iter().enumerate() {
            gradient[v as usize] += value * self.values[k] + slope * self.slopes[k];
        }
    }
}
