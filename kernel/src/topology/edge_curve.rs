//! Edges as curves over the control vertices of their surfaces, and whether two are one.

use super::TOGETHER;
use crate::Point;
use crate::error::Result;
use crate::shape::{BoundaryEdge, Shape, Stencil, Strip, edges_of, no_edge, strips};
use crate::spline::{Conversion, Curve, Space};

/// One edge of a surface, as a curve along it whose control vertices are combinations of the surface's.
#[derive(Debug, Clone)]
pub struct EdgeCurve {
    /// The edge.
    pub edge: BoundaryEdge,
    /// The curve as it is now.
    pub curve: Curve,
    /// Each of its control vertices in terms of the surface's.
    pub stencils: Vec<Stencil>,
}

/// Two edges that are one curve, in one space: their control vertices in pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Match {
    /// The first one's, in terms of its surface's control vertices.
    pub first: Vec<Stencil>,
    /// The second one's.
    pub second: Vec<Stencil>,
    /// Whether the second runs the other way.
    pub reversed: bool,
}

impl EdgeCurve {
    /// The curve of an edge of a surface; `what` needs it. Of a rational one its weights are `W_j = Σ N_i w_ij`, and its vertices
    /// `Σ N_i w_ij P_ij / W_j`.
    ///
    /// # Errors
    /// As for [`strips`].
    pub fn of(shape: &dyn Shape, index: usize, what: &str) -> Result<Self> {
        let edges = edges_of(shape, what)?;
        let edge = edges.edge(index).ok_or_else(|| no_edge(shape, index, edges.count()))?;
        let Some(Strip { space, coefficients, .. }) = strips(shape, index, 0)?.into_iter().next() else {
            return Err(no_edge(shape, index, edges.count()));
        };
        let weights: Vec<f64> = coefficients.iter().map(|s| s.coefficients().iter().sum()).collect();
        let stencils: Vec<Stencil> =
            coefficients.into_iter().zip(&weights).map(|(s, w)| s.scaled(1.0 / w)).collect();
        let points: Vec<Point> =
            stencils.iter().map(|s| Point::from(s.apply(shape.control_vertices()))).collect();
        let rational = shape.cells().is_some_and(|cells| cells.is_rational());
        let curve = Curve::build(space, points, rational.then_some(weights))?;
        Ok(Self { edge, curve, stencils })
    }

    /// The diagonal of the box around its control vertices: of a pole nothing.
    pub fn spread(&self) -> f64 {
        let points = self.curve.points();
        let Some(&first) = points.first() else { return 0.0 };
        let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        (high - low).norm()
    }

    /// The point in the middle of its parameters, wherever they run from; none of a closed edge, which may start anywhere.
    pub fn middle(&self, near: f64) -> Option<Point> {
        let (a, b) = self.curve.domain();
        let (start, end) = (self.curve.point(a).ok()?, self.curve.point(b).ok()?);
        if self.curve.is_periodic() || (end - start).norm() <= near {
            None
        } else {
            self.curve.point(0.5 * a + 0.5 * b).ok()
        }
    }

    /// The edge in another space: of a rational one, `c_i W_i / Σ c_i W_i` of each stencil. `O(n p)`.
    ///
    /// # Errors
    /// When the conversion is of another space, or a number overflows.
    pub fn convert(&self, conversion: &Conversion) -> Result<Self> {
        let weight = |i: usize| self.curve.weights().map_or(1.0, |w| w[i]);
        let row = |k: usize| -> Stencil {
            let total: f64 = conversion.row(k).map(|(i, c)| c * weight(i)).sum();
            let terms = conversion.row(k).filter(|(_, c)| *c != 0.0);
            let terms = terms.map(|(i, c)| (i, c * weight(i) / total));
            terms.flat_map(|(i, share)| self.stencils[i].iter().map(move |(v, c)| (v, share * c))).collect()
        };
        Ok(Self {
            curve: self.curve.convert(conversion)?,
            stencils: (0..conversion.to().len()).map(row).collect(),
            edge: self.edge.clone(),
        })
    }

    fn through(&self, steps: &[Conversion]) -> Result<Self> {
        let mut edge = self.clone();
        for step in steps {
            edge = edge.convert(step)?;
        }
        Ok(edge)
    }
}

/// Whether two edges are one curve, run either way with parameters that differ by scale and shift, and closed ones from
/// anywhere: in the space that holds both, their weights are proportional and their vertices the same to `near`. The ties of
/// these vertices keep them one, however the edges' own knots and degrees differ.
pub fn coincide(first: &EdgeCurve, second: &EdgeCurve, near: f64) -> Option<Match> {
    if first.curve.is_periodic() && !second.curve.is_periodic() {
        let Match { first, second, reversed } = coincide(second, first, near)?;
        return Some(Match { first: second, second: first, reversed });
    }
    let reversed = second.convert(&second.curve.space().reversing().ok()?).ok()?;
    let mut candidates = vec![(second, false), (&reversed, true)];
    // A periodic curve starts where the other one does.
    let mut turned = Vec::new();
    for &(edge, reversed) in &candidates {
        if edge.curve.is_periodic()
            && let Some(turned_edge) = starting(edge, first.curve.point(first.curve.domain().0).ok()?)
        {
            turned.push((turned_edge, reversed));
        }
    }
    candidates.extend(turned.iter().map(|(edge, reversed)| (edge, *reversed)));
    candidates.into_iter().find_map(|(second, reversed)| {
        let (first, second) = if same(first.curve.space(), second.curve.space()) {
            (first.through(&[]).ok()?, second.through(&[]).ok()?)
        } else {
            let second = snapped(second, first.curve.space())?;
            let common = first.curve.space().common(second.curve.space()).ok()?;
            (first.through(&common.first).ok()?, second.through(&common.second).ok()?)
        };
        let pairs = first.curve.points().iter().zip(second.curve.points());
        let together = pairs.into_iter().all(|(a, b)| (a - b).norm() <= near);
        (together && proportional(&first.curve, &second.curve)).then_some(Match {
            first: first.stencils,
            second: second.stencils,
            reversed,
        })
    })
}

/// The edge over another space's domain, its knots on those of that space where they are nearly there: else the spans between
/// them, made of nothing but rounding, would ask for ties that say nearly the same.
fn snapped(edge: &EdgeCurve, to: &Space) -> Option<EdgeCurve> {
    let (a, b) = to.domain();
    let moved = edge.convert(&edge.curve.space().reparametrising(a, b).ok()?).ok()?;
    let (targets, slack) = (to.breakpoints(), TOGETHER * (b - a));
    let nearest = |&k: &f64| {
        let at = targets.partition_point(|&t| t < k - slack);
        targets.get(at).filter(|&&t| t <= k + slack).copied().unwrap_or(k)
    };
    let space = moved.curve.space();
    let knots: Vec<f64> = space.knots().iter().map(nearest).collect();
    let p = space.degree();
    let space = if space.is_periodic() { Space::periodic(p, knots) } else { Space::open(p, knots) }.ok()?;
    let (_, points, weights) = moved.curve.into_parts();
    Some(EdgeCurve {
        curve: Curve::build(space, points, weights).ok()?,
        edge: moved.edge,
        stencils: moved.stencils,
    })
}

/// A periodic edge opened where it is nearest to a point.
fn starting(edge: &EdgeCurve, point: Point) -> Option<EdgeCurve> {
    let space = edge.curve.space();
    let found = edge.curve.closest(point).ok()?.at;
    // Where that is a knot but for rounding, it is the knot.
    let slack = TOGETHER * space.length();
    let start = space.breakpoints().into_iter().find(|k| (k - found).abs() <= slack).unwrap_or(found);
    edge.convert(&space.restricting(start, start + space.length()).ok()?).ok()
}

/// Whether two spaces are the same but for where their domains lie.
fn same(a: &Space, b: &Space) -> bool {
    let relative = |space: &Space, k: f64| (k - space.domain().0) / space.length();
    a.degree() == b.degree()
        && a.is_periodic() == b.is_periodic()
        && a.len() == b.len()
        && a.flat().iter().zip(b.flat()).all(|(x, y)| (relative(a, *x) - relative(b, *y)).abs() <= TOGETHER)
}

fn proportional(a: &Curve, b: &Curve) -> bool {
    let weight = |curve: &Curve, i: usize| curve.weights().map_or(1.0, |w| w[i]);
    let factor = weight(a, 0) / weight(b, 0);
    (0..a.points().len()).all(|i| {
        let (x, y) = (weight(a, i), factor * weight(b, i));
        (x - y).abs() <= TOGETHER * x
    })
}
