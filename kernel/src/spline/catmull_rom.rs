//! Catmull–Rom curves: cubic, through every control vertex.

use smallvec::{SmallVec, smallvec};

use super::{Curve, Space};
use crate::Point;
use crate::error::{Error, MAX_DEGREE, Result};
use crate::shape::{
    Cell, CellSide, Cells, Derivative, Domain, Grid, Interval, Location, Shape, Sides, Stencil,
};
use crate::spline::curve::check_net;

/// How the parameters at which a [`CatmullRom`] curve passes its vertices are spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spacing {
    /// `0, 1, 2, …`: the original.
    Uniform,
    /// By the square root of the distance of neighbours: no cusps or loops within a segment (Yuksel, Schaefer and
    /// Keyser 2011).
    #[default]
    Centripetal,
    /// By the distance of neighbours.
    Chordal,
}

/// A curve that passes its vertices `P_i` at the parameters `u_i`, cubic between them, with the derivatives
/// `m_i = (d_i s_{i-1} + d_{i-1} s_i) / (d_{i-1} + d_i)`, `d_i = u_{i+1} - u_i`, `s_i = (P_{i+1} - P_i) / d_i`: that of
/// the parabola through three neighbours, `(P_{i+1} - P_{i-1}) / 2` where uniform. An open curve's first and last
/// derivatives are those of the parabolas through its first and last three vertices.
///
/// Once the `u_i` are chosen they stay, so that the curve depends linearly on its vertices, however those move.
/// (Catmull and Rom 1974; for parameters that are not uniform, Barry and Goldman 1988.)
///
/// ```
/// use loftsman_kernel::{Point, spline::{CatmullRom, Spacing}};
/// let points: Vec<Point> = (0..5).map(|i| Point::new(f64::from(i), f64::from(i * i % 3), 0.0)).collect();
/// let curve = CatmullRom::new(points.clone(), false, Spacing::Centripetal)?;
/// let spline = curve.to_curve()?;
/// for (u, p) in curve.parameters().into_iter().zip(points) {
///     assert!((spline.point(u)? - p).norm() < 1e-14);
/// }
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CatmullRom {
    /// The polygon's own space: its knots are the parameters.
    space: Space,
    points: Vec<Point>,
}

impl CatmullRom {
    /// The curve through these vertices, closed or not, its parameters spaced as told, from 0 on.
    ///
    /// # Errors
    /// When there are fewer than 2 vertices (3 where closed), a coordinate is not finite, or neighbours coincide
    /// where the spacing depends on their distance.
    pub fn new(points: Vec<Point>, closed: bool, spacing: Spacing) -> Result<Self> {
        check_net(&points, None)?;
        let gaps = if closed { points.len() } else { points.len().saturating_sub(1) };
        let mut parameters = Vec::with_capacity(gaps + 1);
        let mut u = 0.0;
        parameters.push(u);
        for i in 0..gaps {
            let next = (i + 1) % points.len();
            let chord = points[next] - points[i];
            // Scaled first, so that squares neither overflow nor vanish.
            let size = chord.amax();
            let length = if size > 0.0 { (chord / size).norm() * size } else { 0.0 };
            let gap = match spacing {
                Spacing::Uniform => 1.0,
                Spacing::Centripetal => length.sqrt(),
                Spacing::Chordal => length,
            };
            let before = u;
            u += gap;
            if u <= before {
                return Err(Error::Invalid(format!(
                    "control vertices {i} and {next} coincide (or nearly so): remove one, or space the curve uniformly"
                )));
            }
            parameters.push(u);
        }
        Self::with_parameters(parameters, points, closed)
    }

    /// The curve that passes its vertices at these parameters: one for each, and one more where closed, at which
    /// the first vertex is met again.
    ///
    /// # Errors
    /// When there are fewer than 2 vertices (3 where closed), the parameters are not as many, do not increase, or a
    /// number is not finite.
    pub fn with_parameters(parameters: Vec<f64>, points: Vec<Point>, closed: bool) -> Result<Self> {
        let needed = if closed { 3 } else { 2 };
        if points.len() < needed {
            return Err(Error::TooFewVertices { vertices: points.len(), degree: 3, needed });
        }
        let expected = points.len() + usize::from(closed);
        if parameters.len() != expected {
            return Err(Error::KnotCount {
                knots: parameters.len(),
                vertices: points.len(),
                degree: 3,
                kind: if closed { "a closed Catmull–Rom" } else { "an open Catmull–Rom" },
                expected,
            });
        }
        if let Some(w) = parameters.windows(2).find(|w| w[0] == w[1]) {
            return Err(Error::Multiplicity { value: w[0], multiplicity: 2, degree: 3, allowed: 1 });
        }
        check_net(&points, None)?;
        let space = if closed { Space::periodic(1, parameters)? } else { Space::clamped(1, &parameters)? };
        Ok(Self { space, points })
    }

    /// The vertices.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The parameters at which the vertices are passed; where closed, at last that at which the first is met again.
    pub fn parameters(&self) -> Vec<f64> {
        self.space.breakpoints()
    }

    /// Whether the curve is closed.
    pub fn is_closed(&self) -> bool {
        self.space.is_periodic()
    }

    /// The same curve as a cubic B-spline with double knots: `2n` vertices, periodic where closed. Exact.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn to_curve(&self) -> Result<Curve> {
        let (n, t) = (self.points.len(), self.parameters());
        let third = |vertex: usize, length: f64| -> Point {
            self.points[vertex] + self.tangent(vertex).apply(&self.points) * (length / 3.0)
        };
        let mut knots: Vec<f64> = t[..t.len() - 1].iter().flat_map(|&u| [u; 2]).collect();
        let mut points = Vec::with_capacity(2 * n);
        // Function i's vertices between knots: a third of the way before and after each of the polygon's.
        if self.is_closed() {
            knots.push(t[n]);
            for i in 0..n {
                let next = (i + 1) % n;
                points.push(third(next, t[i] - t[i + 1]));
                points.push(third(next, t[next + 1] - t[next]));
            }
            return Curve::new(Space::periodic(3, knots)?, points);
        }
        knots.splice(0..0, [t[0]; 2]);
        knots.extend([t[n - 1]; 4]);
        points.push(self.points[0]);
        points.push(third(0, t[1] - t[0]));
        for i in 1..n - 1 {
            points.push(third(i, t[i - 1] - t[i]));
            points.push(third(i, t[i + 1] - t[i]));
        }
        points.push(third(n - 1, t[n - 2] - t[n - 1]));
        points.push(self.points[n - 1]);
        Curve::new(Space::open(3, knots)?, points)
    }

    /// Length of segment `i`, which starts at vertex `i`.
    fn gap(&self, i: usize) -> f64 {
        self.space.flat()[i + 2] - self.space.flat()[i + 1]
    }

    /// The derivative at a vertex in terms of the vertices.
    fn tangent(&self, i: usize) -> Stencil {
        let n = self.points.len();
        let slope = |a: usize, b: usize, gap: f64, factor: f64| [(a, -factor / gap), (b, factor / gap)];
        let between = |before: usize, i: usize, after: usize, shares: (f64, f64)| -> Stencil {
            let (first, second) =
                (slope(before, i, self.gap(before), shares.0), slope(i, after, self.gap(i), shares.1));
            first.into_iter().chain(second).collect()
        };
        if self.is_closed() || i > 0 && i < n - 1 {
            let (before, after) = ((i + n - 1) % n, (i + 1) % n);
            let (a, b) = (self.gap(before), self.gap(i));
            return between(before, i, after, (b / (a + b), a / (a + b)));
        }
        if n == 2 {
            return slope(0, 1, self.gap(0), 1.0).into_iter().collect();
        }
        // The parabola's slope at its end: twice that of the chord less the one at the middle vertex.
        let middle = if i == 0 { 1 } else { n - 2 };
        let (a, b) = (self.gap(middle - 1), self.gap(middle));
        let end_gap = if i == 0 { a } else { b };
        let (near, far) = (1.0 + end_gap / (a + b), -end_gap / (a + b));
        between(middle - 1, middle, middle + 1, if i == 0 { (near, far) } else { (far, near) })
    }

    /// The row of a derivative at a parameter of a span.
    fn stencil_in(&self, span: usize, u: f64, derivative: Derivative) -> Result<Stencil> {
        if derivative.v > 0 {
            return Err(Error::Invalid(format!(
                "a derivative [{}, {}] is one of a surface, by u and v: a curve's has one order",
                derivative.u, derivative.v
            )));
        }
        let order = derivative.u;
        if order > MAX_DEGREE {
            return Err(Error::DerivativeOrder { order });
        }
        let (i, start) = (span - 1, self.space.flat()[span]);
        let (h, next) = (self.gap(i), (i + 1) % self.points.len());
        let t = (u - start) / h;
        // Cubic Hermite functions of t, differentiated by t: for the values at both ends and the slopes at both.
        let [p, q, m, k] = match order {
            0 => [
                (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t),
                t * t * (3.0 - 2.0 * t),
                t * (1.0 - t) * (1.0 - t),
                t * t * (t - 1.0),
            ],
            1 => [6.0 * t * (t - 1.0), 6.0 * t * (1.0 - t), (1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0)],
            2 => [12.0 * t - 6.0, 6.0 - 12.0 * t, 6.0 * t - 4.0, 6.0 * t - 2.0],
            3 => [12.0, -12.0, 6.0, 6.0],
            _ => [0.0; 4],
        };
        let scale = h.powi(-(order as i32));
        let slopes = self.tangent(i).scaled(m * h * scale);
        let slopes =
            slopes.iter().chain(self.tangent(next).scaled(k * h * scale).iter()).collect::<Stencil>();
        Ok([(i, p * scale), (next, q * scale)].into_iter().chain(slopes.iter()).collect())
    }
}

impl Shape for CatmullRom {
    fn control_vertices(&self) -> &[Point] {
        &self.points
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
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
        smallvec![Interval { start, end, periodic: self.is_closed() }]
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn grid(&self) -> Option<Grid> {
        Some(Grid { rows: 1, columns: self.points.len(), rows_wrap: false, columns_wrap: self.is_closed() })
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }
}

/// The segments between neighbouring vertices: cubic, made of these and the vertices before and after.
impl Cells for CatmullRom {
    fn count(&self) -> usize {
        self.points.len() - usize::from(!self.is_closed())
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let (start, end) = (*self.space.flat().get(index + 1)?, *self.space.flat().get(index + 2)?);
        if index >= Cells::count(self) {
            return None;
        }
        let next = (index + 1) % self.points.len();
        let (here, there) = (self.tangent(index), self.tangent(next));
        let mut vertices: SmallVec<[usize; 16]> =
            here.vertices().iter().chain(there.vertices()).copied().chain([index, next]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Some(Cell {
            face: None,
            sides: smallvec![CellSide { start, end, degree: 3 }],
            rational: false,
            vertices,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::parameters;
    use super::*;

    fn any_polygon() -> impl Strategy<Value = Vec<Point>> {
        prop::collection::vec((-5.0..5.0_f64, -5.0..5.0_f64), 3..12)
            .prop_map(|xy| xy.into_iter().enumerate().map(|(i, (x, y))| Point::new(x, y, i as f64)).collect())
    }

    fn any_spacing() -> impl Strategy<Value = Spacing> {
        prop_oneof![Just(Spacing::Uniform), Just(Spacing::Centripetal), Just(Spacing::Chordal)]
    }

    proptest! {
        #[test]
        fn the_spline_is_the_same_curve(points in any_polygon(), closed in any::<bool>(), spacing in any_spacing()) {
            let curve = CatmullRom::new(points.clone(), closed, spacing).unwrap();
            let spline = curve.to_curve().unwrap();
            prop_assert_eq!(spline.is_periodic(), closed);
            prop_assert_eq!(spline.points().len(), 2 * points.len());
            let (a, b) = spline.domain();
            for u in parameters(a, b) {
                for order in 0..5 {
                    let expected = spline.derivative(u, order).unwrap();
                    let found = curve.value(u.into(), order.into()).unwrap();
                    // Differences of vertices 20 apart over steps as short as the shortest gap.
                    let step = curve.parameters().windows(2).map(|w| w[1] - w[0]).fold(1.0, f64::min);
                    let size = 1e-13 * 20.0 * (6.0 / step).powi(order as i32);
                    prop_assert!((found - expected).norm() < size, "order {order} at {u}: {found} not {expected}");
                }
            }
            for (u, p) in curve.parameters().into_iter().zip(&points) {
                prop_assert!((curve.value(u.into(), 0.into()).unwrap() - p.coords).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn uniform_is_the_classical_matrix() {
        let x = [1.0, 4.0, 2.0, 7.0];
        let points = x.iter().map(|&x| Point::new(x, 0.0, 0.0)).collect();
        let curve = CatmullRom::new(points, false, Spacing::Uniform).unwrap();
        for t in [0.0, 0.3, 0.8] {
            let stencil = curve.stencil((1.0 + t).into(), 0.into()).unwrap();
            let expected = [
                -0.5 * t + t * t - 0.5 * t * t * t,
                1.0 - 2.5 * t * t + 1.5 * t * t * t,
                0.5 * t + 2.0 * t * t - 1.5 * t * t * t,
                -0.5 * t * t + 0.5 * t * t * t,
            ];
            for (c, e) in stencil.coefficients().iter().zip(expected) {
                assert!((c - e).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn parabolas_are_reproduced_whatever_the_spacing() {
        let parameters = vec![0.0, 0.4, 1.7, 2.0, 5.0];
        let at = |u: f64| Point::new(u, 3.0 * u * u - u, 1.0);
        let points = parameters.iter().map(|&u| at(u)).collect();
        let curve = CatmullRom::with_parameters(parameters, points, false).unwrap();
        for i in 0..=50 {
            let u = f64::from(i) / 10.0;
            assert!((curve.value(u.into(), 0.into()).unwrap() - at(u).coords).norm() < 1e-13);
        }
    }

    #[test]
    fn sizes_from_tiny_to_huge() {
        for size in [1e-300, 1e-9, 1e9, 1e200] {
            let points =
                (0..4).map(|i| Point::new(size * f64::from(i), size * f64::from(i % 2), 0.0)).collect();
            let curve = CatmullRom::new(points, true, Spacing::Centripetal).unwrap().to_curve().unwrap();
            let middle = curve.point(curve.domain().1 * 0.4).unwrap();
            assert!(middle.coords.amax() > 0.1 * size && middle.coords.amax() < 4.0 * size);
        }
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        assert!(CatmullRom::new(vec![], true, Spacing::Uniform).is_err());
        assert!(CatmullRom::new(vec![p(0.0)], false, Spacing::Uniform).is_err());
        assert!(CatmullRom::new(vec![p(0.0), p(1.0)], true, Spacing::Uniform).is_err());
        assert!(CatmullRom::new(vec![p(0.0), p(0.0)], false, Spacing::Chordal).is_err());
        assert!(CatmullRom::new(vec![p(0.0), p(f64::NAN)], false, Spacing::Uniform).is_err());
        assert!(CatmullRom::with_parameters(vec![0.0, 0.0], vec![p(0.0), p(1.0)], false).is_err());
        assert!(CatmullRom::with_parameters(vec![1.0, 0.0], vec![p(0.0), p(1.0)], false).is_err());
        assert!(CatmullRom::with_parameters(vec![1.0], vec![p(0.0), p(1.0)], false).is_err());
        let line = CatmullRom::new(vec![p(0.0), p(3.0)], false, Spacing::Chordal).unwrap();
        assert!((line.value(1.2.into(), 0.into()).unwrap().x - 1.2).abs() < 1e-15);
        assert!(
            line.stencil(4.0.into(), 0.into()).is_err() && line.stencil([0.0, 0.0].into(), 0.into()).is_err()
        );
        assert!(line.stencil(1.0.into(), 26.into()).is_err());
    }
}
