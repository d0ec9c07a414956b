//! Integrals along a curve: its functions at Gauss points, and the points and derivatives there.

use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{Derivative, rows_at};
use loftsman_kernel::{Point, Result, Vector};

use crate::members::Member;
use crate::rule::Rule;

impl Rule {
    /// `per` points on each of `parts` parts of every cell, with the curve's (rational) functions.
    pub(crate) fn of_curve(curve: &Member<'_>, per: usize, parts: usize) -> Result<Self> {
        let Some(splines) = curve.splines else { return Self::of_cells(curve, per, parts) };
        let rule = Self::new(splines.u, per, parts);
        Ok(match splines.weights {
            Some(weights) => rule.weighted(weights),
            None => rule,
        })
    }

    /// The same of a curve that is no spline, by its stencils.
    fn of_cells(curve: &Member<'_>, per: usize, parts: usize) -> Result<Self> {
        let (shape, cells) = (curve.shape, curve.cells.checked(curve.shape)?);
        let width = cells.iter().map(|cell| cell.vertices.len()).max().unwrap_or(0).max(1);
        let (vertices, values, slopes, weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut rule = Self { width, per, vertices, values, slopes, weights };
        for cell in &cells {
            // Shorter cells are filled up with a vertex that has no part in them.
            let own = cell.vertices.iter().map(|&v| v as u32).chain(std::iter::repeat(0)).take(width);
            let own: Vec<u32> = own.collect();
            for part in 0..parts {
                rule.vertices.extend_from_slice(&own);
                let share = |x: f64| (part as f64 + x) / parts as f64;
                let mut piece = cell.clone();
                for side in &mut piece.sides {
                    let length = side.end - side.start;
                    (side.start, side.end) =
                        (side.start + length * share(0.0), side.start + length * share(1.0));
                }
                let points = piece.gauss_points([per, 1]);
                let both = [
                    rows_at(shape, cell, &points, Derivative::POSITION)?,
                    rows_at(shape, cell, &points, 1.into())?,
                ];
                for (rows, all) in both.iter().zip([&mut rule.values, &mut rule.slopes]) {
                    for row in rows.chunks_exact(cell.vertices.len().max(1)) {
                        all.extend(row.iter().copied().chain(std::iter::repeat(0.0)).take(width));
                    }
                }
                rule.weights.extend(points.iter().map(|(_, weight)| weight));
            }
        }
        Ok(rule)
    }

    /// A rule for an integrand of degree `degree` in polynomial curves; for rational ones refined until `integral`, of the
    /// curve as it is, changes by less than 1e-13 of its size.
    pub(crate) fn settled(
        curve: &Member<'_>,
        degree: usize,
        integral: impl Fn(&Self, &[Point]) -> f64,
    ) -> Result<Self> {
        let exact = degree / 2 + 1;
        let mut rule = Self::of_curve(curve, exact, 1)?;
        if !curve.cells.is_rational() {
            return Ok(rule);
        }
        let mut last = integral(&rule, curve.points());
        for round in 0..16 {
            let (per, parts) = (exact + 4 * (round + 1).min(4), 1 << usize::max(round, 3).saturating_sub(3));
            let finer = Self::of_curve(curve, per, parts)?;
            let now = integral(&finer, curve.points());
            if (now - last).abs() <= 1e-13 * now.abs() {
                return Ok(rule);
            }
            (rule, last) = (finer, now);
        }
        Err(Error::Invalid("the curve's weights differ too much for its area or centroid to be told".into()))
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
