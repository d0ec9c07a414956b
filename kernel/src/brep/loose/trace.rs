//! What a surface is along a line of its parameters, as a spline along it.

use crate::Point;
use crate::error::MAX_DEGREE;
use crate::error::Result;
use crate::shape::Stencil;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Conversion, Curve, Product, Space, Surface};

/// What leaves a line by a smaller part of its length is the line.
const STRAIGHT: f64 = 1e-12;

/// A part of a line `u = at` or `v = at` of a surface's parameters, run through by an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Whether `u` runs.
    pub(super) along_u: bool,
    pub(super) at: f64,
    /// Where the running parameter starts and ends: the second may be less.
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Line {
    /// The line that a parameter curve is, where it is one but for rounding.
    pub(super) fn of(curve: &ParameterCurve) -> Option<Self> {
        let points = curve.curve().points();
        let first = points.first()?;
        let reach = |k: usize| points.iter().fold(0.0_f64, |m, p| m.max((p[k] - first[k]).abs()));
        let (by_u, by_v) = (reach(0), reach(1));
        let along_u = by_v <= STRAIGHT * by_u;
        if !along_u && by_u > STRAIGHT * by_v {
            return None;
        }
        let run = |p: &Point| if along_u { p.x } else { p.y };
        let forth = points.windows(2).all(|pair| run(&pair[0]) <= run(&pair[1]));
        let back = points.windows(2).all(|pair| run(&pair[0]) >= run(&pair[1]));
        let [a, b] = curve.ends().ok()?;
        let (from, to) = if along_u { (a[0], b[0]) } else { (a[1], b[1]) };
        let at = if along_u { first.y } else { first.x };
        ((forth || back) && from != to).then_some(Self { along_u, at, from, to })
    }

    /// The space of a surface that runs along it.
    pub(super) fn space<'a>(&self, surface: &'a Surface) -> &'a Space {
        if self.along_u { surface.u() } else { surface.v() }
    }

    /// The parameters of the surface where this share of the line is run through.
    pub(super) fn point(&self, share: f64) -> [f64; 2] {
        let run = self.from + (self.to - self.from) * share;
        if self.along_u { [run, self.at] } else { [self.at, run] }
    }
}

/// A surface along a line, `Σ_k M_k(t) H_k / Σ_k M_k(t) w_k`: each `H_k` a row over the control vertices.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    pub(super) space: Space,
    rows: Vec<Stencil>,
    weights: Option<Vec<f64>>,
}

impl Trace {
    /// The trace along the whole of a line, from its start to its end; its space is clamped.
    pub(super) fn of(product: &Product<'_>, line: &Line) -> Result<Self> {
        let (run, across) = if line.along_u { (product.u, product.v) } else { (product.v, product.u) };
        let (at, p) = (across.locate(line.at)?, across.degree());
        let span = across.span(at);
        let mut row = [0.0; MAX_DEGREE + 1];
        across.basis_into(span, at, 0, &mut row);
        let columns = product.v.len();
        let (mut rows, mut weights) = (Vec::with_capacity(run.len()), Vec::with_capacity(run.len()));
        for j in 0..run.len() {
            let (mut sum, mut total) = (Stencil::new(), 0.0);
            for (k, &value) in row[..=p].iter().enumerate().filter(|(_, c)| **c != 0.0) {
                let i = across.vertex(span - p + k);
                let own = if line.along_u { j * columns + i } else { i * columns + j };
                let value = value * product.weights.map_or(1.0, |w| w[own]);
                sum.add(product.first + own, value);
                total += value;
            }
            rows.push(sum);
            weights.push(total);
        }
        let whole = Self { space: run.clone(), rows, weights: product.weights.map(|_| weights) };
        let (low, high) = (line.from.min(line.to), line.from.max(line.to));
        let part = whole.converted(&run.restricting(low, high)?);
        if line.from < line.to { Ok(part) } else { Ok(part.converted(&part.space.reversing()?)) }
    }

    /// The same in another space.
    pub(super) fn converted(&self, conversion: &Conversion) -> Self {
        let to = conversion.to();
        let rows = (0..to.len()).map(|k| {
            conversion.row(k).flat_map(|(j, c)| self.rows[j].iter().map(move |(v, x)| (v, c * x))).collect()
        });
        let weights = self.weights.as_ref().map(|weights| {
            (0..to.len()).map(|k| conversion.row(k).map(|(j, c)| c * weights[j]).sum()).collect()
        });
        Self { rows: rows.collect(), weights, space: to.clone() }
    }

    pub(super) fn all_converted(&self, steps: &[Conversion]) -> Self {
        steps.iter().fold(self.clone(), |trace, step| trace.converted(step))
    }

    pub(super) fn weight(&self, k: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[k])
    }

    /// Control vertex `k` of the curve along the line, as a row.
    pub(super) fn row(&self, k: usize) -> Stencil {
        self.rows[k].clone().scaled(1.0 / self.weight(k))
    }

    /// The curve along the line.
    pub(super) fn curve(&self, net: &[Point]) -> Result<Curve> {
        let points = (0..self.space.len()).map(|k| self.row(k).apply(net).into()).collect();
        Curve::build(self.space.clone(), points, self.weights.clone())
    }

    /// How the control vertices of two curves along lines that run side by side differ, in a space of both: zero as long as the curves are
    /// one. `None` where their weights differ, so that they are one curve for no displacement but some.
    pub(super) fn difference(&self, other: &Self) -> Result<Option<Vec<Stencil>>> {
        let common = self.space.common(&other.space)?;
        let (a, b) = (self.all_converted(&common.first), other.all_converted(&common.second));
        let ratio = a.weight(0) / b.weight(0);
        let alike = |k: usize| (a.weight(k) / (ratio * b.weight(k)) - 1.0).abs() <= 1e-9;
        if a.space.len() != b.space.len() || !(0..a.space.len()).all(alike) {
            return Ok(None);
        }
        let minus = |k: usize| a.row(k).iter().chain(b.row(k).scaled(-1.0).iter()).collect();
        Ok(Some((0..a.space.len()).map(minus).collect()))
    }
}
