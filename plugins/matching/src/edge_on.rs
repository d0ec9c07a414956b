//! An edge kept on a curve.

use std::sync::Arc;

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::functional::{
    Accuracy, DeclaredFunctional, Edge, Functional, Linearity, On, Rows, ShapeNames, Shapes,
};
use loftsman_kernel::plugin::{Declaration, Field, ParameterError, Parameters};
use loftsman_kernel::shape::{Derivative, Location, Stencil};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::text::figure;
use loftsman_kernel::topology::EdgeCurve;
use loftsman_kernel::{Point, Vector};

use crate::along::{lies_on, nearest};
use crate::beside::{Beside, curve_of, edge_of};

pub(crate) const OBJECT: Field =
    Field::optional("object", "text", "the step's object", "the surface whose edge it is");

/// A whole edge of a surface that lies on a curve. The curve is another shape of the problem and stands still: the edge goes to
/// where it was at the start.
///
/// Linear, alike in all axes. What the equations are is decided when the edit starts:
///
/// * An edge that lies on the curve already, each point of it to rounding, stays as it is, however its parameters run.
/// * Where the edge's space, with its weights, holds the curve (no lower degree, all of its knots) and the parameters of both are to
///   run evenly with one another, the equations are those of coefficients, and the edge **is** the curve, to rounding.
/// * Elsewhere it is refused, or with a [tolerance](Self::within) it meets the curve at as many places as it has control vertices (its
///   Greville abscissae). Which places of the curve these are is what brings it nearest: evenly by parameter, by length, or
///   the closest ones to where the edge is. Measured is the distance from the curve, whatever the parameters.
///
/// The edge runs the way (and where both are closed, from the place) that brings the two nearest when the edit starts.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeOn {
    on: On,
    edge: Edge,
    curve: On,
    tolerance: Option<f64>,
    bound: Option<Arc<Bound>>,
}

/// An edge of the first shape on a curve, shape `curve` of the problem.
pub fn edge_on(edge: Edge, curve: impl Into<On>) -> EdgeOn {
    EdgeOn { on: On::default(), edge, curve: curve.into(), tolerance: None, bound: None }
}

/// What is fixed when an edit starts.
#[derive(Debug, PartialEq)]
struct Bound {
    rows: Vec<(Stencil, Point)>,
    /// Places all along the edge, and what each should be: a point, or anywhere on the curve.
    between: Vec<(Location, Point)>,
    curve: Arc<Curve>,
    kept: Kept,
    /// What cannot be within its tolerance, and where.
    too_far: Option<Error>,
}

/// How an edge is on a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    /// It is there already.
    Already,
    /// It is the curve, parameter by parameter.
    Exactly,
    /// It meets it at some places, and is near between.
    Nearly,
}

impl EdgeOn {
    /// The same with the edge of another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    /// The same where the edge need lie on the curve only to within a length.
    #[must_use]
    pub fn within(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    fn fixed(&self, shapes: &Shapes<'_>) -> Result<Arc<Bound>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        let what = self.describe();
        if let Some(tolerance) = self.tolerance.filter(|t| !(*t > 0.0 && t.is_finite())) {
            let problem =
                format!("{what}: tolerance {} is no length; give a number above 0", Figure(tolerance));
            return Err(Error::Invalid(problem));
        }
        if self.on.shape == self.curve.shape {
            return Err(Error::Invalid(format!("{what}: a curve is needed, not the surface itself")));
        }
        let curve = curve_of(shapes, &self.curve, &what)?;
        let edge = edge_of(shapes, &self.on, self.edge, &what)?;
        let beside = Beside::new(edge, curve, self.tolerance.is_none())?;
        let places = |exact: bool| -> Result<Vec<_>> {
            let each = beside.between(exact).into_iter();
            each.map(|t| Ok((beside.at(t), beside.curve.point(t)?))).collect()
        };
        let bound = |rows, between, kept, too_far| {
            Ok(Arc::new(Bound { rows, between, curve: Arc::new(curve.clone()), kept, too_far }))
        };
        if lies_on(&beside, curve)? {
            let EdgeCurve { stencils, curve: own, .. } = &beside.edge;
            let rows = stencils.iter().cloned().zip(own.points().iter().copied()).collect();
            return bound(rows, places(false)?, Kept::Already, None);
        }
        match (beside.exactly()?, self.tolerance) {
            (Ok(rows), _) => bound(rows, places(true)?, Kept::Exactly, None),
            (Err(why), None) => Err(refused(&what, &why)),
            (Err(why), Some(tolerance)) => {
                let nearest = nearest(&beside, curve)?;
                let too_far = (nearest.distance > tolerance).then(|| {
                    let [x, y, z] = nearest.place.coords.into();
                    Error::Invalid(format!(
                        "{what}: {why}, and as near as it comes it is {} from it at ({}, {}, {}), where {} is allowed: allow more, or \
                         elevate or refine the surface along the edge",
                        figure(nearest.distance),
                        figure(x),
                        figure(y),
                        figure(z),
                        figure(tolerance)
                    ))
                });
                let shape = shapes.get(self.on.shape)?;
                let row = |(t, point): (f64, Point)| {
                    Ok((shape.stencil(beside.at(t), Derivative::POSITION)?, point))
                };
                let rows = nearest.targets.into_iter().map(row).collect::<Result<_>>()?;
                bound(rows, places(false)?, Kept::Nearly, too_far)
            }
        }
    }

    /// How far the edge is from the curve, now: the largest distance at places all along it, whatever the parameters.
    ///
    /// # Errors
    /// When it cannot be asked of these shapes.
    pub fn distance(&self, shapes: &Shapes<'_>) -> Result<f64> {
        Ok(self.gap(shapes)?.iter().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// The difference where it is largest.
    fn gap(&self, shapes: &Shapes<'_>) -> Result<[f64; 3]> {
        let mut largest = [0.0; 3];
        let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        let bound = self.fixed(shapes)?;
        for (at, _) in &bound.between {
            let apart: [f64; 3] = away(shapes, self.on.shape, *at, &bound.curve)?.into();
            if square(&apart) > square(&largest) {
                largest = apart;
            }
        }
        Ok(largest)
    }
}

/// From the curve to a place of a shape.
fn away(shapes: &Shapes<'_>, on: usize, at: Location, curve: &Curve) -> Result<Vector> {
    let point = shapes.value(on, at, Derivative::POSITION)?;
    Ok(point - curve.closest(point.into())?.point.coords)
}

/// That an edge cannot be the curve.
fn refused(what: &str, why: &str) -> Error {
    Error::Invalid(format!(
        "{what}: {why}, so that the edge cannot lie on it to rounding: elevate or refine the surface along the edge, or give a \
         `tolerance`"
    ))
}

/// The equations of an edge that is a curve, and whether they hold everywhere or only at some places.
///
/// # Errors
/// Without a tolerance where they would not: why, and what to do.
pub(crate) fn rows(
    beside: &Beside,
    shapes: &Shapes<'_>,
    on: &On,
    tolerance: Option<f64>,
    what: &str,
) -> Result<(Vec<(Stencil, Point)>, bool)> {
    match (beside.exactly()?, tolerance) {
        (Ok(rows), _) => Ok((rows, true)),
        (Err(_), Some(_)) => Ok((beside.at_places(shapes.get(on.shape)?)?, false)),
        (Err(why), None) => Err(refused(what, &why)),
    }
}

impl Functional for EdgeOn {
    fn equations(&self) -> usize {
        self.bound.as_ref().map_or(3, |bound| 3 * bound.rows.len())
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let Some(bound) = &self.bound else { return Err(unbound(&self.describe())) };
        for (stencil, point) in &bound.rows {
            rows.alike(self.on.shape, stencil);
            rows.constant(-point.coords);
        }
        Ok(())
    }

    /// Before it is bound, the difference where it is largest.
    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let Some(bound) = &self.bound else {
            out.copy_from_slice(&self.gap(shapes)?);
            return Ok(());
        };
        let vertices = shapes.get(self.on.shape)?.control_vertices();
        for ((stencil, point), out) in bound.rows.iter().zip(out.chunks_exact_mut(3)) {
            out.copy_from_slice((stencil.apply(vertices) - point.coords).as_slice());
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}{} on the curve{}", self.edge.called(), self.on, self.curve)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Self { bound: None, ..self.clone() }.fixed(shapes)?;
        if let Some(error) = &bound.too_far {
            return Err(error.clone());
        }
        Ok(Some(Arc::new(Self { bound: Some(bound), ..self.clone() })))
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.tolerance.map_or(Accuracy::Rounding, Accuracy::Within)
    }

    fn notes(&self) -> Vec<String> {
        let already = self.bound.as_ref().is_some_and(|bound| bound.kept == Kept::Already);
        let note = || format!("{}: it lies there already, and stays as it is", self.describe());
        already.then(note).into_iter().collect()
    }

    fn witness(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = self.fixed(shapes)?;
        Ok(match bound.kept {
            // Its equations say all of its control vertices.
            Kept::Already => None,
            _ => Some(Arc::new(Between {
                name: self.describe(),
                on: self.on.shape,
                accuracy: self.accuracy(),
                bound,
            })),
        })
    }
}

/// That a functional has been asked for rows too early.
pub(crate) fn unbound(what: &str) -> Error {
    Error::Invalid(format!("{what}: its equations are known once it is bound; bind it to the shapes first"))
}

/// The edge looked at between the places where it was imposed.
#[derive(Debug)]
struct Between {
    name: String,
    on: usize,
    bound: Arc<Bound>,
    accuracy: Accuracy,
}

impl Functional for Between {
    fn equations(&self) -> usize {
        3 * self.bound.between.len()
    }

    fn linearity(&self) -> Linearity {
        if self.bound.kept == Kept::Nearly { Linearity::Nonlinear } else { Linearity::Linear }
    }

    /// With the closest point of the curve standing still, which moves along the curve only.
    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        for (at, point) in &self.bound.between {
            rows.alike(self.on, &shapes.stencil(self.on, *at, Derivative::POSITION)?);
            rows.constant(-point.coords);
        }
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        for ((at, point), out) in self.bound.between.iter().zip(out.chunks_exact_mut(3)) {
            let apart = match self.bound.kept {
                Kept::Nearly => away(shapes, self.on, *at, &self.bound.curve)?,
                _ => shapes.value(self.on, *at, Derivative::POSITION)? - point.coords,
            };
            out.copy_from_slice(apart.as_slice());
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}, all along", self.name)
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }
}

impl DeclaredFunctional for EdgeOn {
    const DECLARATION: Declaration = Declaration {
        name: "edge",
        help: "an edge of a surface lies on a curve, which stands still",
        fields: &[
            Field::required(
                "edge",
                "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"",
                "the edge: where u or v starts or ends",
            ),
            Field::required("curve", "text", "the curve that it lies on, another object of the scene"),
            Field::optional(
                "tolerance",
                "length",
                "none: to rounding, or refused",
                "how far it may be from the curve",
            ),
            OBJECT,
        ],
    };

    fn from_parameters(p: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self {
            edge: Edge::from_parameters(p, "edge")?,
            curve: named(p, "curve", names)?,
            on: On::from_parameters(p, names)?,
            tolerance: tolerance(p, "tolerance")?,
            bound: None,
        })
    }
}

/// The shape of the problem that a field names.
pub(crate) fn named(p: &Parameters, field: &str, names: &mut dyn ShapeNames) -> Result<On, ParameterError> {
    let name = p.text(field)?;
    let shape = names.shape(name).map_err(|e| p.error(field, e.to_string()))?;
    Ok(On { shape, name: Some(name.into()) })
}

/// A number above 0, where there is one.
pub(crate) fn tolerance(p: &Parameters, field: &str) -> Result<Option<f64>, ParameterError> {
    if !p.has(field) {
        return Ok(None);
    }
    match p.number(field)? {
        t if t > 0.0 => Ok(Some(t)),
        t => Err(p.error(field, format!("{} is too small: give a number above 0", Figure(t)))),
    }
}
