//! How long curves are.

use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Result, Vector};

use crate::members::{Member, Members, OBJECT, OBJECTS, curve, name_of};
use crate::rule::Basis;

/// The arc length `∫ |C'| du` of a curve, or of several together. One nonlinear equation, with gradient `∫ R'_i C'/|C'|`.
///
/// Gauss–Legendre quadrature, each interval halved until both halves agree with the whole to 1e-13 of the length; so the
/// rule follows the curve as it changes. At a cusp the intervals shrink towards it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Length {
    members: Members,
}

/// The length of the first shape of the problem.
pub fn length() -> Length {
    Length::default()
}

/// Halvings of a span, after which an interval is taken as it is.
const DEPTH: usize = 48;
/// Halvings allowed in all, for each span.
const HALVINGS: usize = 200;
/// The rule's points beyond the degree.
const EXTRA: usize = 6;

impl Length {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The length of all of these.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self { members: shapes.into_iter().collect() }
    }
}

/// The rule of one curve at work.
struct Measure<'c> {
    shape: &'c dyn Shape,
    /// Space and weights, of a spline.
    spline: Option<(&'c Space, Option<&'c [f64]>)>,
    points: &'c [Point],
    /// The pieces: for a spline the number of the span, and from where to where.
    pieces: Vec<(usize, f64, f64)>,
    nodes: Vec<f64>,
    shares: Vec<f64>,
    basis: Basis,
    /// What a stencil could not be had for.
    failed: Option<Error>,
}

impl<'c> Measure<'c> {
    fn new(curve: &Member<'c>) -> Result<Self> {
        let [degree, _] = curve.cells.degrees();
        let (nodes, shares) = gauss_legendre(degree + EXTRA);
        let spline = curve.splines.map(|splines| (splines.u, splines.weights));
        let pieces = match spline {
            Some((space, _)) => space.spans().map(|s| (s, space.flat()[s], space.flat()[s + 1])).collect(),
            None => {
                let cells = curve.cells.checked(curve.shape)?;
                let each = cells.iter().flat_map(|cell| cell.sides.first()).enumerate();
                each.map(|(k, side)| (k, side.start, side.end)).collect()
            }
        };
        let (shape, points, basis) = (curve.shape, curve.points(), Basis::default());
        Ok(Self { shape, spline, points, pieces, nodes, shares, basis, failed: None })
    }

    /// Goes to a piece.
    fn enter(&mut self, piece: usize) {
        if let Some((space, _)) = self.spline {
            self.basis.enter(space, piece);
        }
    }

    /// The length from `a` to `b` within the piece entered last, and the gradient if there is room for it.
    fn part(&mut self, piece: usize, a: f64, b: f64, gradient: Option<&mut [Vector]>) -> f64 {
        match self.spline {
            Some((space, weights)) => self.part_of_span((space, weights), piece, a, b, gradient),
            None => self.part_by_stencils(a, b, gradient).unwrap_or_else(|error| {
                self.failed.get_or_insert(error);
                0.0
            }),
        }
    }

    fn part_by_stencils(&self, a: f64, b: f64, mut gradient: Option<&mut [Vector]>) -> Result<f64> {
        let mut length = 0.0;
        for (node, share) in self.nodes.iter().zip(&self.shares) {
            let slopes = self.shape.stencil((a + (b - a) * node).into(), 1.into())?;
            let (tangent, weight) = (slopes.apply(self.points), share * (b - a));
            let speed = tangent.norm();
            length += weight * speed;
            if let Some(gradient) = gradient.as_deref_mut().filter(|_| speed > 0.0) {
                for (vertex, slope) in slopes.iter() {
                    gradient[vertex] += tangent * (weight * slope / speed);
                }
            }
        }
        Ok(length)
    }

    fn part_of_span(
        &mut self,
        (space, weights): (&Space, Option<&[f64]>),
        span: usize,
        a: f64,
        b: f64,
        mut gradient: Option<&mut [Vector]>,
    ) -> f64 {
        let p = space.degree();
        let first = span - p;
        let mut length = 0.0;
        for (node, share) in self.nodes.iter().zip(&self.shares) {
            self.basis.at(a + (b - a) * node);
            let (values, slopes) = (&mut self.basis.values[..=p], &mut self.basis.slopes[..=p]);
            if let Some(weights) = weights {
                let (mut total, mut slope) = (0.0, 0.0);
                for k in 0..=p {
                    let w = weights[space.vertex(first + k)];
                    values[k] *= w;
                    slopes[k] *= w;
                    total += values[k];
                    slope += slopes[k];
                }
                for k in 0..=p {
                    slopes[k] = (slopes[k] - values[k] / total * slope) / total;
                }
            }
            let mut tangent = Vector::zeros();
            for k in 0..=p {
                tangent += self.points[space.vertex(first + k)].coords * slopes[k];
            }
            let speed = tangent.norm();
            let weight = share * (b - a);
            length += weight * speed;
            if let Some(gradient) = gradient.as_deref_mut()
                && speed > 0.0
            {
                for k in 0..=p {
                    gradient[space.vertex(first + k)] += tangent * (weight * slopes[k] / speed);
                }
            }
        }
        length
    }

    /// The whole length; `gradient` has as many entries as there are vertices, or none.
    fn whole(&mut self, mut gradient: Option<&mut [Vector]>) -> Result<f64> {
        let pieces = std::mem::take(&mut self.pieces);
        let mut rough = Vec::with_capacity(pieces.len());
        for &(piece, a, b) in &pieces {
            self.enter(piece);
            rough.push(self.part(piece, a, b, None));
        }
        let aim = 1e-13 * rough.iter().sum::<f64>() / pieces.len().max(1) as f64;
        let mut total = 0.0;
        for (&(span, a, b), &rough) in pieces.iter().zip(&rough) {
            self.enter(span);
            let mut todo = vec![(a, b, rough, 0)];
            let mut halvings = HALVINGS;
            while let Some((a, b, rough, depth)) = todo.pop() {
                let middle = 0.5 * a + 0.5 * b;
                let (left, right) = (self.part(span, a, middle, None), self.part(span, middle, b, None));
                let off = (left + right - rough).abs();
                let done = off <= aim.max(1e-14 * rough) || depth >= DEPTH || halvings == 0;
                if done || !(a < middle && middle < b) {
                    total += left + right;
                    if let Some(gradient) = gradient.as_deref_mut() {
                        self.part(span, a, middle, Some(gradient));
                        self.part(span, middle, b, Some(gradient));
                    }
                } else {
                    halvings -= 1;
                    todo.push((middle, b, right, depth + 1));
                    todo.push((a, middle, left, depth + 1));
                }
            }
        }
        self.pieces = pieces;
        self.failed.take().map_or(Ok(total), Err)
    }
}

impl Functional for Length {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let what = self.describe();
        let mut total = 0.0;
        rows.equation();
        for on in &self.members.0 {
            let own = curve(shapes, on, &what, "ask for its surface-area")?;
            let mut gradient = vec![Vector::zeros(); own.points().len()];
            let length = Measure::new(&own)?.whole(Some(&mut gradient))?;
            if length == 0.0 {
                return Err(Error::Invalid(format!(
                    "{what}: {} has no length, and no direction to grow in; move a vertex first",
                    name_of(on)
                )));
            }
            total += length;
            rows.terms(on.shape, 0, gradient.into_iter());
        }
        if let Some(value) = value.first_mut() {
            *value = total;
        }
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let what = self.describe();
        let mut total = 0.0;
        for on in &self.members.0 {
            total += Measure::new(&curve(shapes, on, &what, "ask for its surface-area")?)?.whole(None)?;
        }
        if let Some(out) = out.first_mut() {
            *out = total;
        }
        Ok(())
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        positive(&self.describe(), "length", wanted)
    }

    fn describe(&self) -> String {
        format!("length{}", self.members)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn out_of_reach(&self, shapes: &Shapes<'_>, wanted: &[f64]) -> Option<String> {
        let [on] = &self.members.0[..] else { return None };
        let own = curve(shapes, on, &self.describe(), "").ok()?;
        let range = own.shape.domain().into_iter().next()?;
        let at = |u: f64| own.shape.value(Location::Curve(u), Derivative::POSITION).ok();
        let apart = (at(range.end)? - at(range.start)?).norm();
        let short = wanted.first().is_some_and(|wanted| *wanted < apart);
        short.then(|| {
            format!(
                "the ends of {} are {} apart: while both are held it cannot be shorter",
                name_of(on),
                figure(apart)
            )
        })
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        for on in &self.members.0 {
            curve(shapes, on, &self.describe(), "ask for its surface-area")?;
        }
        Ok(None)
    }
}

/// Lengths and surface areas are more than nothing.
pub(crate) fn positive(what: &str, kind: &str, wanted: &[f64]) -> Result<()> {
    match wanted.iter().find(|w| **w <= 0.0) {
        None => Ok(()),
        Some(w) => {
            let w = figure(*w);
            Err(Error::Invalid(format!("{what}: a {kind} of {w} cannot be; ask for more than 0")))
        }
    }
}

impl DeclaredFunctional for Length {
    const DECLARATION: Declaration = Declaration {
        name: "length",
        help: "the arc length of a curve, or of several together",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { members: Members::from_parameters(parameters, names, "objects")? })
    }
}
