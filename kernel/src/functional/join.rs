//! Two shapes that meet: curve ends, points of shapes, whole edges of surfaces.

use std::sync::Arc;

use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::error::{Error, Result};
use crate::plugin::{Declaration, Field, ParameterError, Parameters, nearest};
use crate::shape::{Derivative, Interval, Location};
use crate::spline::Space;

/// A whole edge of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// `u` at the start of its domain.
    UStart,
    /// `u` at the end of its domain.
    UEnd,
    /// `v` at the start of its domain.
    VStart,
    /// `v` at the end of its domain.
    VEnd,
}

const EDGES: [(&str, Edge); 4] =
    [("u0", Edge::UStart), ("u1", Edge::UEnd), ("v0", Edge::VStart), ("v1", Edge::VEnd)];

/// Where a shape is joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// At one location.
    At(Location),
    /// Along a whole edge.
    Along(Edge),
}

impl<L: Into<Location>> From<L> for Place {
    fn from(location: L) -> Self {
        Self::At(location.into())
    }
}

impl From<Edge> for Place {
    fn from(edge: Edge) -> Self {
        Self::Along(edge)
    }
}

/// Two shapes meet: position, then first, then second derivatives of one equal those of the other. Linear rows of
/// the joint control vertices, alike in all axes; zero where they hold.
///
/// Derivatives are taken outwards on one side and inwards on the other: where both curves start (or both end) at
/// the joint, odd orders change sign, so that the joint is smooth as a path. Along edges, the equations are those at
/// the Greville abscissae of the edge, which are as many as the edge has vertices: they make the edges equal
/// everywhere, if both have the same degree and (up to scale) the same knots, which is checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Join {
    first: (On, Place),
    second: (On, Place),
    continuity: usize,
    samples: Vec<Sample>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample {
    first: (Location, Derivative),
    second: (Location, Derivative),
    /// The factor of the second shape's derivative.
    factor: f64,
}

/// A join of the first shape at a place with shape `other` at its place, with continuity 0, 1 or 2.
pub fn join(
    at: impl Into<Place>,
    other: impl Into<On>,
    other_at: impl Into<Place>,
    continuity: usize,
) -> Join {
    Join {
        first: (On::default(), at.into()),
        second: (other.into(), other_at.into()),
        continuity,
        samples: Vec::new(),
    }
}

impl Join {
    /// The same with another shape of the problem in place of the first.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.first.0 = shape.into();
        self
    }

    fn sampled(&self, shapes: &Shapes<'_>) -> Result<Vec<Sample>> {
        if self.continuity > 2 {
            let found = self.continuity;
            return Err(Error::Invalid(format!("{}: continuity {found} is not 0, 1 or 2", self.describe())));
        }
        match (self.first.1, self.second.1) {
            (Place::At(a), Place::At(b)) => {
                let end = |on: &On, at: Location| -> Result<Option<bool>> {
                    let domain = shapes.get(on.shape)?.domain();
                    let Location::Curve(u) = at else { return Ok(None) };
                    Ok(domain.first().and_then(|d| {
                        if u == d.start {
                            Some(false)
                        } else if u == d.end {
                            Some(true)
                        } else {
                            None
                        }
                    }))
                };
                let reversed = match (end(&self.first.0, a)?, end(&self.second.0, b)?) {
                    (Some(x), Some(y)) => x == y,
                    _ => false,
                };
                if a.parameters() == 2 && self.continuity > 0 {
                    return Err(Error::Invalid(format!(
                        "{}: at one point of surfaces only continuity 0 has a meaning; join whole edges",
                        self.describe()
                    )));
                }
                Ok((0..=self.continuity)
                    .map(|k| Sample {
                        first: (a, k.into()),
                        second: (b, k.into()),
                        factor: if reversed && k % 2 == 1 { -1.0 } else { 1.0 },
                    })
                    .collect())
            }
            (Place::Along(a), Place::Along(b)) => self.along(shapes, a, b),
            _ => Err(Error::Invalid(format!(
                "{}: an edge can only be joined with an edge, a location with a location",
                self.describe()
            ))),
        }
    }

    fn along(&self, shapes: &Shapes<'_>, a: Edge, b: Edge) -> Result<Vec<Sample>> {
        let (sa, sb) = (edge_of(shapes, &self.first.0, a)?, edge_of(shapes, &self.second.0, b)?);
        let fail = |what: String| Err(Error::Invalid(format!("{}: {what}", self.describe())));
        if sa.places.len() != sb.places.len() {
            return fail(format!(
                "the edges have {} and {} control vertices; refine or elevate one so that they match",
                sa.places.len(),
                sb.places.len()
            ));
        }
        let relative = |edge: &Side, t: f64| (t - edge.run.start) / (edge.run.end - edge.run.start);
        let differ = |reversed: bool| {
            sa.places.iter().enumerate().any(|(i, &t)| {
                let j = if reversed { sb.places.len() - 1 - i } else { i };
                let other = relative(&sb, sb.places[j]);
                (relative(&sa, t) - if reversed { 1.0 - other } else { other }).abs() > 1e-9
            })
        };
        if differ(false) && differ(true) {
            return fail("the edges have different knots; refine both to the same ones".into());
        }
        // Run the way in which the ends of the edges lie nearer to one another.
        let corner =
            |on: &On, side: &Side, t: f64| shapes.get(on.shape)?.value(side.at(t), Derivative::POSITION);
        let (p0, p1) = (corner(&self.first.0, &sa, sa.run.start)?, corner(&self.first.0, &sa, sa.run.end)?);
        let (q0, q1) = (corner(&self.second.0, &sb, sb.run.start)?, corner(&self.second.0, &sb, sb.run.end)?);
        let straight = (p0 - q0).norm() + (p1 - q1).norm() <= (p0 - q1).norm() + (p1 - q0).norm();
        let reversed = if straight { differ(false) } else { !differ(true) };
        let outward = sa.at_end == sb.at_end;
        let mut samples = Vec::new();
        for order in 0..=self.continuity {
            for (i, &t) in sa.places.iter().enumerate() {
                let j = if reversed { sb.places.len() - 1 - i } else { i };
                let factor = if outward && order % 2 == 1 { -1.0 } else { 1.0 };
                samples.push(Sample {
                    first: (sa.at(t), sa.across(order)),
                    second: (sb.at(sb.places[j]), sb.across(order)),
                    factor,
                });
            }
        }
        Ok(samples)
    }
}

/// One edge of a surface: the parameter that runs along it, where the other one stands, and where to sample.
struct Side {
    run: Interval,
    fixed: f64,
    along_u: bool,
    at_end: bool,
    places: Vec<f64>,
}

impl Side {
    fn at(&self, t: f64) -> Location {
        if self.along_u { Location::Surface(t, self.fixed) } else { Location::Surface(self.fixed, t) }
    }

    fn across(&self, order: usize) -> Derivative {
        if self.along_u { Derivative { u: 0, v: order } } else { Derivative { u: order, v: 0 } }
    }
}

/// As many parameters as the space has vertices, at which a function of it is determined (Schoenberg and Whitney): the
/// Greville abscissae, for a floating space those of the clamped one that spans the same functions on the domain.
fn samples_of(space: &Space) -> Vec<f64> {
    if space.is_periodic() {
        return (0..space.len()).map(|i| space.greville(i)).collect();
    }
    let ((a, b), p, flat) = (space.domain(), space.degree(), space.flat());
    let inside = |k: f64| k.max(a).min(b);
    (0..space.len())
        .map(|i| inside(flat[i + 1..=i + p].iter().map(|&k| inside(k) / p as f64).sum()))
        .collect()
}

fn edge_of(shapes: &Shapes<'_>, on: &On, edge: Edge) -> Result<Side> {
    let shape = shapes.get(on.shape)?;
    let domain = shape.domain();
    let [u, v] = domain[..] else {
        return Err(Error::Invalid(format!(
            "a curve has ends, no edges{on}: join it at one parameter, such as its domain's start or end"
        )));
    };
    let (along_u, at_end) = match edge {
        Edge::UStart => (false, false),
        Edge::UEnd => (false, true),
        Edge::VStart => (true, false),
        Edge::VEnd => (true, true),
    };
    let (run, across) = if along_u { (u, v) } else { (v, u) };
    let any: &dyn std::any::Any = shape;
    let places = any.downcast_ref::<crate::spline::Surface>().map(|surface| {
        let space = if along_u { surface.u() } else { surface.v() };
        samples_of(space)
    });
    let Some(places) = places else {
        return Err(Error::Invalid(format!("only B-spline surfaces can be joined along an edge{on}")));
    };
    Ok(Side { run, fixed: if at_end { across.end } else { across.start }, along_u, at_end, places })
}

impl Functional for Join {
    fn equations(&self) -> usize {
        3 * if self.samples.is_empty() { self.continuity + 1 } else { self.samples.len() }
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let fresh;
        let samples = if self.samples.is_empty() {
            fresh = self.sampled(shapes)?;
            &fresh
        } else {
            &self.samples
        };
        let (a, b) = (self.first.0.shape, self.second.0.shape);
        for sample in samples {
            let first = shapes.get(a)?.stencil(sample.first.0, sample.first.1)?;
            let second = shapes.get(b)?.stencil(sample.second.0, sample.second.1)?.scaled(sample.factor);
            rows.difference((a, &first), (b, &second));
        }
        Ok(())
    }

    fn describe(&self) -> String {
        let place = |place: &Place| match place {
            Place::At(location) => location.to_string(),
            Place::Along(edge) => {
                EDGES.iter().find(|(_, e)| e == edge).map_or("", |(name, _)| *name).to_owned()
            }
        };
        let ((a, at), (b, with)) = (&self.first, &self.second);
        format!("C{} join at {}{a} with {}{b}", self.continuity, place(at), place(with))
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let samples = self.sampled(shapes)?;
        Ok(Some(Arc::new(Self { samples, ..self.clone() })))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Join {
    const DECLARATION: Declaration = Declaration {
        name: "join",
        help: "two shapes meet, with continuity 0, 1 or 2",
        fields: &[
            Field::required(
                "at",
                "number, [u, v], or an edge \"u0\" | \"u1\" | \"v0\" | \"v1\"",
                "where on this shape",
            ),
            Field::required("with", "{ object, at }", "the other shape and where on it"),
            Field::optional("continuity", "0 | 1 | 2", "0", "derivatives that agree too"),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        const WITH: [Field; 2] = [
            Field::required("object", "text", "the other object"),
            Field::required("at", "number, [u, v], or an edge", "where on it"),
        ];
        let with = parameters.table("with")?;
        with.check(&WITH)?;
        let continuity = parameters.count_or("continuity", 0)?;
        if continuity > 2 {
            return Err(parameters.error("continuity", format!("{continuity} is not 0, 1 or 2")));
        }
        let second = (On::from_parameters(&with, names)?, place(&with)?);
        Ok(Self {
            first: (On::from_parameters(parameters, names)?, place(parameters)?),
            second,
            continuity,
            samples: Vec::new(),
        })
    }
}

fn place(parameters: &Parameters) -> Result<Place, ParameterError> {
    let Some(text) = parameters.value("at").and_then(|v| v.as_str()) else {
        return parameters.location("at").map(Place::At);
    };
    match EDGES.iter().find(|(name, _)| *name == text) {
        Some((_, edge)) => Ok(Place::Along(*edge)),
        None => {
            let hint = nearest(text, EDGES.iter().map(|(name, _)| *name)).unwrap_or("u0");
            Err(parameters
                .error("at", format!("unknown edge \"{text}\": u0, u1, v0 or v1; did you mean \"{hint}\"?")))
        }
    }
}
