//! Tensor-product B-spline surfaces: polynomial and rational, open and periodic in either direction.

use nalgebra::Matrix4;
use smallvec::{SmallVec, smallvec};

use super::binomial;
use super::curve::{check_curve_space, check_net, knot_count};
use super::form::{SurfacePiece, affine};
use super::space::{MAX_ORDER, Space};
use crate::error::{Error, MAX_DEGREE, Result};
use crate::shape::{
    Cells, Derivative, Domain, Edges, Grid, Interval, Location, Refine, Shape, Sides, Stencil,
};
use crate::solve::Symmetric;
use crate::{Point, Vector};

/// A tensor-product surface `S(u, v) = Σ_i Σ_j N_i(u) M_j(v) P_ij`, or its rational form with weights.
///
/// The control net is kept row after row: `P_ij` is `points()[i * v().len() + j]`, `i` along `u`. One that is a rectangle of a plane, a cylinder or their
/// like may have that [beside it](Self::form), for files that know such things.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    u: Space,
    v: Space,
    points: Vec<Point>,
    weights: Option<Vec<f64>>,
    /// Checked against the others; whoever changes one of them drops it.
    form: Option<Box<SurfacePiece>>,
}

impl Surface {
    /// The polynomial surface with this control net.
    ///
    /// # Errors
    /// When the net is not `u.len() × v.len()`, a space cannot be a curve's, or a coordinate is not finite.
    pub fn new(u: Space, v: Space, points: Vec<Point>) -> Result<Self> {
        Self::build(u, v, points, None)
    }

    /// The rational surface with this control net and weights.
    ///
    /// # Errors
    /// As for [`new`](Self::new); also when the weights are not as many, or one is not positive and finite.
    pub fn rational(u: Space, v: Space, points: Vec<Point>, weights: Vec<f64>) -> Result<Self> {
        Self::build(u, v, points, Some(weights))
    }

    /// A surface with or without weights.
    ///
    /// # Errors
    /// As for [`rational`](Self::rational).
    pub fn build(u: Space, v: Space, points: Vec<Point>, weights: Option<Vec<f64>>) -> Result<Self> {
        check_curve_space(&u)?;
        check_curve_space(&v)?;
        if Some(points.len()) != u.len().checked_mul(v.len()) {
            let rows = points.len() / v.len();
            return Err(if rows * v.len() == points.len() {
                knot_count(&u, rows)
            } else {
                Error::Grid { row: rows, found: points.len() - rows * v.len(), expected: v.len() }
            });
        }
        check_net(&points, weights.as_deref())?;
        Ok(Self { u, v, points, weights, form: None })
    }

    /// What it is beside a spline: a rectangle of an elementary surface; `None` where nothing says so.
    ///
    /// Whatever makes another surface of this one, or changes a vertex, makes one without a form; only [`transformed`](Self::transformed) takes it along.
    pub fn form(&self) -> Option<&SurfacePiece> {
        self.form.as_deref()
    }

    /// The same surface with what it is beside a spline. `O(vertices)`.
    ///
    /// # Errors
    /// When it is not that, [to rounding](SurfacePiece::check).
    pub fn with_form(mut self, form: SurfacePiece) -> Result<Self> {
        form.check(&self)?;
        self.form = Some(Box::new(form));
        Ok(self)
    }

    /// The same surface as a spline and no more.
    #[must_use]
    pub fn without_form(mut self) -> Self {
        self.form = None;
        self
    }

    /// The surface moved by an affine map (the last row is taken as `0 0 0 1`): its control vertices are, and its weights stay. Its form goes along where
    /// the map keeps angles. `O(vertices)`.
    ///
    /// # Errors
    /// When a coordinate overflows.
    pub fn transformed(&self, map: &Matrix4<f64>) -> Result<Self> {
        let points = self.points.iter().map(|p| affine(map, p)).collect();
        let moved = Self::build(self.u.clone(), self.v.clone(), points, self.weights.clone())?;
        let form = self.form.as_ref().and_then(|form| form.moved(map));
        Ok(match form.filter(|form| form.check(&moved).is_ok()) {
            Some(form) => Self { form: Some(Box::new(form)), ..moved },
            None => moved,
        })
    }

    /// The space along `u`.
    pub fn u(&self) -> &Space {
        &self.u
    }

    /// The space along `v`.
    pub fn v(&self) -> &Space {
        &self.v
    }

    /// The control net, row after row (`i * v().len() + j`).
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The weights of a rational surface, in the order of the points.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Its spaces and weights.
    pub(crate) fn product(&self) -> Product<'_> {
        Product { u: &self.u, v: &self.v, weights: self.weights.as_deref(), first: 0 }
    }

    /// The surface's parts: both spaces, control net, weights.
    pub fn into_parts(self) -> (Space, Space, Vec<Point>, Option<Vec<f64>>) {
        (self.u, self.v, self.points, self.weights)
    }

    /// The point at `(u, v)`. `O(p² + q² + pq + log n)`.
    ///
    /// # Errors
    /// When a parameter is outside the domain (a periodic direction wraps it).
    pub fn point(&self, u: f64, v: f64) -> Result<Point> {
        let (u, v) = (self.u.locate(u)?, self.v.locate(v)?);
        Ok(self.point_on((self.u.span(u), self.v.span(v)), (u, v)))
    }

    /// The mixed derivative `∂^(a+b) S / ∂u^a ∂v^b`. Costs as [`derivatives_into`](Self::derivatives_into) of that
    /// order, which gives the lower ones too.
    ///
    /// # Errors
    /// When a parameter is outside the domain or an order is beyond 25.
    pub fn derivative(&self, u: f64, v: f64, a: usize, b: usize) -> Result<Vector> {
        check_orders([a, b])?;
        let mut all: SmallVec<[Vector; 9]> = smallvec![Vector::zeros(); (a + 1) * (b + 1)];
        self.derivatives_into(u, v, [a, b], &mut all)?;
        Ok(all.pop().unwrap_or_default())
    }

    /// All mixed derivatives `∂^(k+l) S / ∂u^k ∂v^l` up to `k = a` and `l = b`, that one at `out[k (b + 1) + l]`: the
    /// point first, and for `[1, 1]` then `S_v`, `S_u`, `S_uv`. `O(p² + q² + pq (b + 1) + p (a + 1)(b + 1))`; no
    /// allocation up to second orders.
    ///
    /// A rational surface's come from those of `A = W S` and of `W` by
    /// `S^(k,l) = (A^(k,l) - Σ_{(i,j) ≠ (0,0)} C(k,i) C(l,j) W^(i,j) S^(k-i,l-j)) / W`.
    ///
    /// # Errors
    /// When a parameter is outside the domain, an order is beyond 25, or `out` is not `(a + 1)(b + 1)` long.
    pub fn derivatives_into(&self, u: f64, v: f64, [a, b]: [usize; 2], out: &mut [Vector]) -> Result<()> {
        check_orders([a, b])?;
        if out.len() != (a + 1) * (b + 1) {
            return Err(Error::Invalid(format!(
                "derivatives up to order {a} by u and {b} by v are {}, and there is room for {}: make both equal",
                (a + 1) * (b + 1),
                out.len()
            )));
        }
        let (u, v) = (self.u.locate(u)?, self.v.locate(v)?);
        self.derivatives_on((self.u.span(u), self.v.span(v)), (u, v), [a, b], out);
        Ok(())
    }
}

/// A tensor-product surface without its control vertices: what its rows are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Product<'a> {
    /// The spaces along `u` and along `v`.
    pub(crate) u: &'a Space,
    pub(crate) v: &'a Space,
    pub(crate) weights: Option<&'a [f64]>,
    /// The number of its first control vertex.
    pub(crate) first: usize,
}

impl Product<'_> {
    /// The row of a derivative; on these sides of knots, where some are given.
    pub(crate) fn stencil(
        &self,
        (u, v): (f64, f64),
        derivative: Derivative,
        sides: Option<Sides>,
    ) -> Result<Stencil> {
        let (u, v) = (self.u.locate(u)?, self.v.locate(v)?);
        let Some(sides) = sides else {
            return self.stencil_in((self.u.span(u), self.v.span(v)), (u, v), derivative);
        };
        let ((su, u), (sv, v)) = (self.u.span_on(u, sides.u), self.v.span_on(v, sides.v));
        self.stencil_in((su, sv), (u, v), derivative)
    }

    /// The row of a derivative at parameters of a pair of spans.
    fn stencil_in(
        &self,
        (su, sv): (usize, usize),
        (u, v): (f64, f64),
        derivative: Derivative,
    ) -> Result<Stencil> {
        let (a, b) = (derivative.u, derivative.v);
        check_orders([a, b])?;
        let (p, q) = (self.u.degree(), self.v.degree());
        let own = |i: usize, j: usize| self.u.vertex(su - p + i) * self.v.len() + self.v.vertex(sv - q + j);
        let index = |i: usize, j: usize| self.first + own(i, j);
        let (mut row_u, mut row_v) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        let Some(weights) = self.weights else {
            self.u.basis_into(su, u, a, &mut row_u);
            self.v.basis_into(sv, v, b, &mut row_v);
            return Ok((0..=p)
                .flat_map(|i| (0..=q).map(move |j| (i, j)))
                .map(|(i, j)| (index(i, j), row_u[i] * row_v[j]))
                .collect());
        };
        // R^(k,l) = (n^(k,l) - Σ_{(i,j) ≠ 0} C(k,i) C(l,j) W^(i,j) R^(k-i,l-j)) / W, with n_ij = w_ij N_i M_j.
        let cells = (p + 1) * (q + 1);
        let mut rational = vec![0.0; cells * (a + 1) * (b + 1)];
        let mut denominators = vec![0.0; (a + 1) * (b + 1)];
        for k in 0..=a {
            self.u.basis_into(su, u, k, &mut row_u);
            for l in 0..=b {
                self.v.basis_into(sv, v, l, &mut row_v);
                let here = k * (b + 1) + l;
                let (before, rest) = rational.split_at_mut(here * cells);
                let row = &mut rest[..cells];
                for i in 0..=p {
                    for j in 0..=q {
                        let value = row_u[i] * row_v[j] * weights[own(i, j)];
                        row[i * (q + 1) + j] = value;
                        denominators[here] += value;
                    }
                }
                for i in 0..=k {
                    for j in 0..=l {
                        if i + j == 0 {
                            continue;
                        }
                        let factor = binomial(k, i) * binomial(l, j) * denominators[i * (b + 1) + j];
                        let lower = ((k - i) * (b + 1) + l - j) * cells;
                        for (value, r) in row.iter_mut().zip(&before[lower..lower + cells]) {
                            *value -= factor * r;
                        }
                    }
                }
                for value in row {
                    *value /= denominators[0];
                }
            }
        }
        let row = &rational[rational.len() - cells..];
        Ok((0..=p)
            .flat_map(|i| (0..=q).map(move |j| (i, j)))
            .map(|(i, j)| (index(i, j), row[i * (q + 1) + j]))
            .collect())
    }
}

fn check_orders([a, b]: [usize; 2]) -> Result<()> {
    if a.max(b) > MAX_DEGREE { Err(Error::DerivativeOrder { order: a.max(b) }) } else { Ok(()) }
}

impl Shape for Surface {
    fn control_vertices(&self) -> &[Point] {
        &self.points
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.form = None;
        &mut self.points
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.product().stencil(at.on_surface()?, derivative, None)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        self.product().stencil(at.on_surface()?, derivative, Some(sides))
    }

    fn domain(&self) -> Domain {
        let interval = |space: &Space| {
            let (start, end) = space.domain();
            Interval { start, end, periodic: space.is_periodic() }
        };
        smallvec![interval(&self.u), interval(&self.v)]
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        Some(super::gram::smoothness_of_product(&self.u, &self.v, order))
    }

    fn grid(&self) -> Option<Grid> {
        Some(Grid {
            rows: self.u.len(),
            columns: self.v.len(),
            rows_wrap: self.u.is_periodic(),
            columns_wrap: self.v.is_periodic(),
        })
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn edges(&self) -> Option<&dyn Edges> {
        Some(self)
    }

    fn refine(&self) -> Option<&dyn Refine> {
        Some(self)
    }
}
