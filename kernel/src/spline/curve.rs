//! B-spline curves: polynomial and rational, open and periodic.

use nalgebra::Matrix4;
use smallvec::smallvec;

use super::binomial;
use super::form::{CurvePiece, affine};
use super::space::{MAX_ORDER, Space};
use crate::error::{Error, MAX_DEGREE, Result};
use crate::shape::{Cells, Derivative, Domain, Grid, Interval, Location, Refine, Shape, Sides, Stencil};
use crate::solve::Symmetric;
use crate::{Point, Vector};

/// A B-spline curve `C(u) = Σ N_i(u) P_i`, or, with weights, `C(u) = Σ w_i N_i(u) P_i / Σ w_i N_i(u)`.
///
/// One that is a line or a piece of a conic may have that [beside it](Self::form), for files that know such things.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    space: Space,
    points: Vec<Point>,
    weights: Option<Vec<f64>>,
    /// Checked against the others; whoever changes one of them drops it.
    form: Option<Box<CurvePiece>>,
}

impl Curve {
    /// The polynomial curve with these control vertices.
    ///
    /// # Errors
    /// When the space has another number of vertices or degree 0, or a coordinate is not finite.
    pub fn new(space: Space, points: Vec<Point>) -> Result<Self> {
        Self::build(space, points, None)
    }

    /// The rational curve with these control vertices and weights.
    ///
    /// # Errors
    /// As for [`new`](Self::new); also when the weights are not as many, or one is not positive and finite.
    pub fn rational(space: Space, points: Vec<Point>, weights: Vec<f64>) -> Result<Self> {
        Self::build(space, points, Some(weights))
    }

    /// A curve with or without weights.
    ///
    /// # Errors
    /// As for [`rational`](Self::rational).
    pub fn build(space: Space, points: Vec<Point>, weights: Option<Vec<f64>>) -> Result<Self> {
        check_curve_space(&space)?;
        if points.len() != space.len() {
            return Err(knot_count(&space, points.len()));
        }
        check_net(&points, weights.as_deref())?;
        Ok(Self { space, points, weights, form: None })
    }

    /// What it is beside a spline: a line, or a piece of a conic; `None` where nothing says so.
    ///
    /// Whatever makes another curve of this one, or changes a vertex, makes one without a form; only [`transformed`](Self::transformed) takes it along.
    pub fn form(&self) -> Option<&CurvePiece> {
        self.form.as_deref()
    }

    /// The same curve with what it is beside a spline. `O(vertices)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, brep::{CurveForm, Frame}, spline::{Curve, CurvePiece}};
    /// let arc = Curve::elliptic_arc(Point::origin(), Vector::x() * 2.0, Vector::y() * 2.0, 0.5, 1.0)?;
    /// let frame = Frame { origin: Point::origin(), x: Vector::x(), z: Vector::z() };
    /// let circle = CurvePiece { form: CurveForm::Circle { frame, radius: 2.0 }, range: [0.5, 1.5] };
    /// assert!(arc.clone().with_form(circle)?.form().is_some());
    /// assert!(arc.with_form(CurvePiece { range: [0.5, 1.6], ..circle }).is_err());
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When it is not that, [to rounding](CurvePiece::check).
    pub fn with_form(mut self, form: CurvePiece) -> Result<Self> {
        form.check(&self)?;
        self.form = Some(Box::new(form));
        Ok(self)
    }

    /// The same curve as a spline and no more.
    #[must_use]
    pub fn without_form(mut self) -> Self {
        self.form = None;
        self
    }

    /// The curve moved by an affine map (the last row is taken as `0 0 0 1`): its control vertices are, and its weights stay. Its form goes along where
    /// the map keeps that: a line is one under any map, a conic where angles stay. `O(vertices)`.
    ///
    /// # Errors
    /// When a coordinate overflows.
    pub fn transformed(&self, map: &Matrix4<f64>) -> Result<Self> {
        let points = self.points.iter().map(|p| affine(map, p)).collect();
        let moved = Self::build(self.space.clone(), points, self.weights.clone())?;
        let form = self.form.as_ref().and_then(|form| form.moved(map));
        Ok(match form.filter(|form| form.check(&moved).is_ok()) {
            Some(form) => Self { form: Some(Box::new(form)), ..moved },
            None => moved,
        })
    }

    /// The Bézier curve of degree `points.len() - 1` over `[0, 1]`.
    ///
    /// # Errors
    /// When there are fewer than 2 or more than 26 points, or a coordinate is not finite.
    pub fn bezier(points: Vec<Point>) -> Result<Self> {
        let degree = points.len().saturating_sub(1);
        if degree == 0 {
            return Err(Error::TooFewVertices { vertices: points.len(), degree: 1, needed: 2 });
        }
        Self::new(Space::clamped(degree, &[0.0, 1.0])?, points)
    }

    /// The space of functions the curve is made of.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// The degree `p`.
    pub fn degree(&self) -> usize {
        self.space.degree()
    }

    /// The control vertices.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The weights of a rational curve.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Start and end of the domain.
    pub fn domain(&self) -> (f64, f64) {
        self.space.domain()
    }

    /// Whether the curve is periodic.
    pub fn is_periodic(&self) -> bool {
        self.space.is_periodic()
    }

    /// The curve's parts: space, control vertices, weights.
    pub fn into_parts(self) -> (Space, Vec<Point>, Option<Vec<f64>>) {
        (self.space, self.points, self.weights)
    }

    /// The point at `u`. `O(p² + log n)`.
    ///
    /// # Errors
    /// When `u` is outside the domain (a periodic curve wraps it).
    pub fn point(&self, u: f64) -> Result<Point> {
        let u = self.space.locate(u)?;
        Ok(self.point_on(self.space.span(u), u))
    }

    /// The point at a parameter of a span.
    #[inline]
    pub(super) fn point_on(&self, span: usize, u: f64) -> Point {
        match self.degree() {
            1 => self.combine(span, &self.space.values::<2>(span, u)),
            2 => self.combine(span, &self.space.values::<3>(span, u)),
            3 => self.combine(span, &self.space.values::<4>(span, u)),
            4 => self.combine(span, &self.space.values::<5>(span, u)),
            5 => self.combine(span, &self.space.values::<6>(span, u)),
            p => {
                let mut row = [0.0; MAX_ORDER];
                self.space.basis_into(span, u, 0, &mut row);
                self.combine(span, &row[..=p])
            }
        }
    }

    /// The point that basis values on a span give.
    #[inline]
    fn combine(&self, span: usize, row: &[f64]) -> Point {
        if self.weights.is_none() && !self.space.is_periodic() {
            // The vertices lie side by side.
            let vertices = &self.points[span + 1 - row.len()..=span];
            let sum =
                row.iter().zip(vertices).fold(Vector::zeros(), |sum, (value, p)| sum + p.coords * *value);
            return Point::from(sum);
        }
        let (sum, total) = self.weigh(span, row);
        Point::from(if self.weights.is_some() { sum / total } else { sum })
    }

    /// `Σ w_i N_i P_i` and `Σ w_i N_i` for a row of basis functions (or derivatives) on a span; without weights only
    /// the first sum means anything.
    #[inline]
    fn weigh(&self, span: usize, row: &[f64]) -> (Vector, f64) {
        let first = span + 1 - row.len();
        let (mut sum, mut total) = (Vector::zeros(), 0.0);
        if self.space.is_periodic() {
            for (j, value) in row.iter().enumerate() {
                let i = self.space.vertex(first + j);
                let value = self.weights.as_ref().map_or(*value, |w| value * w[i]);
                sum += self.points[i].coords * value;
                total += value;
            }
            return (sum, total);
        }
        // The vertices lie side by side.
        let vertices = &self.points[first..=span];
        if let Some(weights) = &self.weights {
            for ((value, p), w) in row.iter().zip(vertices).zip(&weights[first..=span]) {
                sum += p.coords * (value * w);
                total += value * w;
            }
        } else {
            for (value, p) in row.iter().zip(vertices) {
                sum += p.coords * *value;
            }
        }
        (sum, total)
    }

    /// The derivative of the given order at `u`.
    ///
    /// # Errors
    /// When `u` is outside the domain or the order is beyond 25.
    pub fn derivative(&self, u: f64, order: usize) -> Result<Vector> {
        let mut out = [Vector::zeros(); MAX_ORDER];
        self.derivatives_into(u, out.get_mut(..=order).ok_or(Error::DerivativeOrder { order })?)?;
        Ok(out[order])
    }

    /// The point and the derivatives `C, C', C'', …` at `u`, as many as `out` has room for. `O(p² · orders)`,
    /// no allocation.
    ///
    /// A rational curve's come from the quotient rule `C^(k) = (A^(k) - Σ_j C(k,j) W^(j) C^(k-j)) / W`.
    ///
    /// # Errors
    /// When `u` is outside the domain or there is room for more than 26 of them.
    pub fn derivatives_into(&self, u: f64, out: &mut [Vector]) -> Result<()> {
        if out.len() > MAX_ORDER {
            return Err(Error::DerivativeOrder { order: out.len() - 1 });
        }
        let u = self.space.locate(u)?;
        self.derivatives_on(self.space.span(u), u, out);
        Ok(())
    }

    /// The derivatives at a parameter of a span; `out` has room for 26 at most.
    #[inline]
    pub(super) fn derivatives_on(&self, span: usize, u: f64, out: &mut [Vector]) {
        match (self.degree(), out.len()) {
            (1, ..=3) => self.differentiate::<2>(span, u, out),
            (2, ..=3) => self.differentiate::<3>(span, u, out),
            (3, ..=3) => self.differentiate::<4>(span, u, out),
            (4, ..=3) => self.differentiate::<5>(span, u, out),
            (5, ..=3) => self.differentiate::<6>(span, u, out),
            (_, ..=4) => self.differentiate_any::<4>(span, u, out),
            _ => self.differentiate_any::<MAX_ORDER>(span, u, out),
        }
    }

    fn differentiate<const N: usize>(&self, span: usize, u: f64, out: &mut [Vector]) {
        match out.len() {
            1 => self.apply(span, self.space.rows::<N, 1>(span, u).iter().map(|row| &row[..]), out),
            2 => self.apply(span, self.space.rows::<N, 2>(span, u).iter().map(|row| &row[..]), out),
            _ => self.apply(span, self.space.rows::<N, 3>(span, u).iter().map(|row| &row[..]), out),
        }
    }

    /// Of any degree, `K` orders at most.
    fn differentiate_any<const K: usize>(&self, span: usize, u: f64, out: &mut [Vector]) {
        let mut rows = [[0.0; MAX_ORDER]; K];
        let rows = &mut rows[..out.len().min(K)];
        self.space.rows_into(span, u, rows);
        self.apply(span, rows.iter().map(|row| &row[..=self.degree()]), out);
    }

    /// The `p + 1` control vertices of a span, `x, y, z` or (for `L = 4`) `w x, w y, w z, w`, in room for `N`.
    #[inline]
    pub(super) fn net_on<const N: usize, const L: usize>(&self, span: usize) -> [[f64; L]; N] {
        let mut net = [[0.0; L]; N];
        let p = self.degree();
        for (j, vertex) in net.iter_mut().enumerate().take(p + 1) {
            let i = self.space.vertex(span - p + j);
            let (p, w) = (self.points[i], self.weights.as_ref().map_or(1.0, |w| w[i]));
            for (lane, value) in vertex.iter_mut().zip([p.x * w, p.y * w, p.z * w, w]) {
                *lane = value;
            }
        }
        net
    }

    /// The row of a derivative at a parameter of a span.
    #[inline]
    fn stencil_in(&self, span: usize, u: f64, derivative: Derivative) -> Result<Stencil> {
        if derivative.v > 0 {
            return Err(Error::Invalid(format!(
                "a derivative [{}, {}] is one of a surface, by u and v: a curve's has one order",
                derivative.u, derivative.v
            )));
        }
        if derivative.u > MAX_DEGREE {
            return Err(Error::DerivativeOrder { order: derivative.u });
        }
        Ok(row_in(&self.space, span, u, derivative.u, self.weights.as_ref().map(|w| |i: usize| w[i])))
    }

    #[inline]
    fn apply<'a>(&self, span: usize, rows: impl Iterator<Item = &'a [f64]>, out: &mut [Vector]) {
        let mut weights = [0.0; MAX_ORDER];
        for ((value, weight), row) in out.iter_mut().zip(&mut weights).zip(rows) {
            (*value, *weight) = self.weigh(span, row);
        }
        if self.weights.is_some() {
            quotient(out, &weights);
        }
    }
}

/// Derivatives of `A / W` from those of `A` (in place) and of `W`: `C^(k) = (A^(k) - Σ_j C(k,j) W^(j) C^(k-j)) / W`.
#[inline]
pub(super) fn quotient(row: &mut [Vector], weights: &[f64]) {
    for order in 0..row.len() {
        for j in 1..=order {
            let lower = row[order - j] * (binomial(order, j) * weights[j]);
            row[order] -= lower;
        }
        row[order] /= weights[0];
    }
}

/// The row of a derivative of order `order` (25 at most) at a parameter of a span, for vertices with these weights: of
/// a curve, or of one column of a surface's net, across the other direction.
#[inline]
pub(crate) fn row_in(
    space: &Space,
    span: usize,
    u: f64,
    order: usize,
    weight: Option<impl Fn(usize) -> f64>,
) -> Stencil {
    let p = space.degree();
    let vertex = |j: usize| space.vertex(span - p + j);
    let mut row = [0.0; MAX_ORDER];
    let Some(weight) = weight else {
        space.basis_into(span, u, order, &mut row);
        if !space.is_periodic() {
            return Stencil::run(span - p, &row, p + 1);
        }
        return (0..=p).map(|j| (vertex(j), row[j])).collect();
    };
    // Rational basis functions R_i = w_i N_i / W, differentiated by the quotient rule.
    let mut rational = vec![[0.0; MAX_ORDER]; order + 1];
    let mut denominators = [0.0; MAX_ORDER];
    for k in 0..=order {
        space.basis_into(span, u, k, &mut row);
        for j in 0..=p {
            row[j] *= weight(vertex(j));
            denominators[k] += row[j];
        }
        for i in 1..=k {
            let factor = binomial(k, i) * denominators[i];
            for j in 0..=p {
                row[j] -= factor * rational[k - i][j];
            }
        }
        for j in 0..=p {
            rational[k][j] = row[j] / denominators[0];
        }
    }
    (0..=p).map(|j| (vertex(j), rational[order][j])).collect()
}

impl Shape for Curve {
    fn control_vertices(&self) -> &[Point] {
        &self.points
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.form = None;
        &mut self.points
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let u = self.space.locate(at.on_curve()?)?;
        self.stencil_in(self.space.span(u), u, derivative)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        let (span, u) = self.space.span_on(self.space.locate(at.on_curve()?)?, sides.u);
        self.stencil_in(span, u, derivative)
    }

    fn domain(&self) -> Domain {
        let (start, end) = self.space.domain();
        smallvec![Interval { start, end, periodic: self.space.is_periodic() }]
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        Some(super::gram::smoothness(&self.space, order))
    }

    fn grid(&self) -> Option<Grid> {
        Some(Grid {
            rows: 1,
            columns: self.points.len(),
            rows_wrap: false,
            columns_wrap: self.space.is_periodic(),
        })
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn refine(&self) -> Option<&dyn Refine> {
        Some(self)
    }
}

/// A space that a curve or one direction of a surface can have: degree at least 1. (An interior knot of multiplicity
/// `p + 1` tears the shape in two there; that is allowed, as in the formats that shapes come from.)
pub(super) fn check_curve_space(space: &Space) -> Result<()> {
    match space.degree() {
        0 => Err(Error::Degree { degree: 0 }),
        _ => Ok(()),
    }
}

/// Finite control vertices, and weights that fit them.
pub(super) fn check_net(points: &[Point], weights: Option<&[f64]>) -> Result<()> {
    if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
        return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
    }
    let Some(weights) = weights else { return Ok(()) };
    if weights.len() != points.len() {
        return Err(Error::WeightCount { weights: weights.len(), vertices: points.len() });
    }
    match weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w > 0.0)) {
        Some((index, &value)) => Err(Error::Weight { index, value }),
        None => Ok(()),
    }
}

/// The error for a number of control vertices that does not fit the knots.
pub(super) fn knot_count(space: &Space, vertices: usize) -> Error {
    let degree = space.degree();
    let (kind, expected) =
        if space.is_periodic() { ("a periodic", vertices + 1) } else { ("an open", vertices + degree + 1) };
    Error::KnotCount { knots: space.knots().len(), vertices, degree, kind, expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter_circle() -> Curve {
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let points = vec![Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        Curve::rational(space, points, vec![1.0, 0.5_f64.sqrt(), 1.0]).unwrap()
    }

    #[test]
    fn rational_quarter_circle_stays_on_the_circle() {
        let arc = quarter_circle();
        for i in 0..=16 {
            let u = f64::from(i) / 16.0;
            let p = arc.point(u).unwrap().coords;
            let d = arc.derivative(u, 1).unwrap();
            assert!((p.norm() - 1.0).abs() < 1e-15 && p.dot(&d).abs() < 1e-15);
        }
    }

    #[test]
    fn stencil_and_evaluation_agree_on_every_order() {
        let arc = quarter_circle();
        for order in 0..6 {
            let by_stencil = Shape::value(&arc, 0.3.into(), order.into()).unwrap();
            let direct = arc.derivative(0.3, order).unwrap();
            assert!((by_stencil - direct).norm() <= 1e-13 * direct.norm().max(1.0), "order {order}");
        }
    }
}
