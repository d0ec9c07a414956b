//! Two shapes that meet: curve ends, points of shapes, whole edges of surfaces.

mod between;
mod conditions;
mod dense;
mod edge;
mod places;

use std::fmt;
use std::sync::Arc;

use self::between::{Between, SHOWN, Sample, samples};
use self::conditions::Conditions;
pub use self::edge::Edge;
use super::position::OBJECT;
use super::{Accuracy, DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes, Store};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Derivative, Location};
use crate::topology::pair::Track;
use crate::topology::{Pair, SurfaceEdge};

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
/// the joint, odd orders change sign, so that the joint is smooth as a path.
///
/// *Along whole edges* the surfaces' degrees and knots may be unlike; the parameters of both run evenly with one another, the
/// way (and where both edges are closed, from the place) that brings them nearest when the edit starts. With weights fixed, the
/// equations are those under which `S_A = S_B` and their derivatives across hold **everywhere** on the edge, to rounding:
///
/// * Where the weights are alike (none; or `w_B = λ w_A` along the edge, and with derivatives `w_B' = λ w_A' + λ' w_A` …), those
///   of the edges' homogeneous coefficients in one space: least common degree, knots of both. A cubic edge against a linear one
///   becomes linear; what is given up so is [said](Functional::notes).
/// * Where they are unlike, those of `w_B (w_A S_A) - w_A (w_B S_B) = 0`, as long as that leaves more than edges shrunk to a
///   point. It does not where `w_A` and `w_B` have no factor in common; then the join is refused, with what to do: equal weights,
///   or higher degrees along the edge (by `q`, and the edges can meet in any polynomial curve of degree `q`).
/// * With a [tolerance](Self::within), where the edges are not alike: they meet at as many places as the larger one has control
///   vertices, and between them as nearly as that makes them.
///
/// [`witness`](Functional::witness) looks between; [`gaps`](Self::gaps) measures. Equations of derivatives of order `k` are
/// multiplied by the `k`-th power of a parameter step by which they become lengths, those by which the vertices next to the
/// edge would have to move.
#[derive(Debug, Clone, PartialEq)]
pub struct Join {
    first: (On, Place),
    second: (On, Place),
    continuity: usize,
    tolerance: Option<f64>,
    bound: Option<Arc<Resolved>>,
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
        tolerance: None,
        bound: None,
    }
}

/// What is fixed when an edit starts.
#[derive(Debug, PartialEq)]
enum Resolved {
    /// At a location each: those, and the factor of the second shape's derivative of each order.
    Places { first: Location, second: Location, factors: Vec<f64> },
    /// Whole edges.
    Edges { track: Track, conditions: Conditions },
}

impl Join {
    /// The same with another shape of the problem in place of the first.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.first.0 = shape.into();
        self
    }

    /// The same for whole edges, which need meet only to within a length: where they cannot simply be made the same, they meet
    /// at as many places as the larger one has control vertices, and what is left between is measured, and refused where it
    /// is more. Derivatives count as lengths, in the parameter step described above.
    #[must_use]
    pub fn within(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// How far the shapes are from what the join says, now: for each order up to the continuity the largest difference of
    /// these derivatives (0: the largest gap). Along edges it is the largest at `p + q + 1` places of each piece (degrees `p` and
    /// `q`), sixteen times as many with a tolerance; they lie between those where it was imposed.
    ///
    /// # Errors
    /// When the join cannot be asked of these shapes.
    pub fn gaps(&self, shapes: &Shapes<'_>) -> Result<Vec<f64>> {
        Ok(self.differences(shapes)?.iter().map(Vector::norm).collect())
    }

    /// The largest angle between two surfaces joined along an edge, now, at the same places: between the ways in which they
    /// leave it, 0 where they are tangent to one another. Nothing at locations, and where no place has such an angle.
    ///
    /// # Errors
    /// When the join cannot be asked of these shapes.
    pub fn crease(&self, shapes: &Shapes<'_>) -> Result<Option<f64>> {
        let bound = self.fixed(shapes)?;
        if matches!(*bound, Resolved::Places { .. }) {
            return Ok(None);
        }
        let between = self.between(shapes, &bound)?;
        let (a, b) = (shapes.get(between.first)?, shapes.get(between.second)?);
        let mut largest = None;
        for sample in &between.samples {
            if let Some(angle) = sample.angle(a, b)? {
                largest = Some(angle.max(largest.unwrap_or(0.0)));
            }
        }
        Ok(largest)
    }

    /// For each order the difference where it is largest.
    fn differences(&self, shapes: &Shapes<'_>) -> Result<Vec<Vector>> {
        let bound = self.fixed(shapes)?;
        let between = self.between(shapes, &bound)?;
        let (a, b) = (shapes.get(between.first)?, shapes.get(between.second)?);
        let mut largest = vec![Vector::zeros(); self.continuity + 1];
        for sample in &between.samples {
            for (k, largest) in largest.iter_mut().enumerate() {
                let (first, second) = sample.stencils(a, b, k)?;
                let difference = first.apply(a.control_vertices()) - second.apply(b.control_vertices());
                if difference.norm() > largest.norm() {
                    *largest = difference;
                }
            }
        }
        Ok(largest)
    }

    fn fail<T>(&self, what: impl fmt::Display) -> Result<T> {
        Err(Error::Invalid(format!("{}: {what}", self.describe())))
    }

    fn fixed(&self, shapes: &Shapes<'_>) -> Result<Arc<Resolved>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        if self.continuity > 2 {
            return self.fail(format!("continuity {} is not 0, 1 or 2", self.continuity));
        }
        if let Some(tolerance) = self.tolerance.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return self.fail(format!("tolerance {tolerance} is not a length; give a positive number"));
        }
        match (self.first.1, self.second.1) {
            (Place::At(a), Place::At(b)) => self.places(shapes, a, b).map(Arc::new),
            (Place::Along(a), Place::Along(b)) => {
                if self.first.0.shape == self.second.0.shape && a == b {
                    return self.fail("an edge cannot be joined with itself; name another one");
                }
                let (first, second) =
                    (self.edge(shapes, &self.first.0, a)?, self.edge(shapes, &self.second.0, b)?);
                let pair = Pair::new(&first, &second)?;
                match Conditions::new(&pair, self.continuity, self.tolerance.is_some())? {
                    Ok(conditions) => Ok(Arc::new(Resolved::Edges { track: pair.track(), conditions })),
                    Err(refusal) => self.fail(refusal),
                }
            }
            _ => self.fail("an edge can only be joined with an edge, a location with a location"),
        }
    }

    fn edge<'a>(&self, shapes: &Shapes<'a>, on: &On, edge: Edge) -> Result<SurfaceEdge<'a>> {
        let shape = shapes.get(on.shape)?;
        let index = edge.number_on(shape).or_else(|error| self.fail(format!("{error}{on}")))?;
        SurfaceEdge::new(shape, index, self.continuity, &self.describe())
    }

    fn places(&self, shapes: &Shapes<'_>, a: Location, b: Location) -> Result<Resolved> {
        if self.tolerance.is_some() {
            return self.fail("a tolerance has a meaning for whole edges only; locations meet exactly");
        }
        if a.parameters() == 2 && self.continuity > 0 {
            return self.fail("at one point of surfaces only continuity 0 has a meaning; join whole edges");
        }
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
        let factor = |k| if reversed && k % 2 == 1 { -1.0 } else { 1.0 };
        Ok(Resolved::Places { first: a, second: b, factors: (0..=self.continuity).map(factor).collect() })
    }

    fn between(&self, shapes: &Shapes<'_>, bound: &Resolved) -> Result<Between> {
        let samples = match bound {
            Resolved::Places { first, second, factors } => {
                vec![Sample {
                    first: (*first, [Derivative::POSITION, 1.into(), 2.into()]),
                    second: (*second, [Derivative::POSITION, 1.into(), 2.into()]),
                    factors: [0, 1, 2].map(|k| factors.get(k).copied().unwrap_or(1.0)),
                }]
            }
            Resolved::Edges { track, conditions } => {
                let (Place::Along(a), Place::Along(b)) = (self.first.1, self.second.1) else {
                    return self.fail("it is bound to edges and names none");
                };
                let (first, second) =
                    (self.edge(shapes, &self.first.0, a)?, self.edge(shapes, &self.second.0, b)?);
                samples(&Pair::on(&first, &second, *track), &conditions.breakpoints, self.tolerance.is_some())
            }
        };
        Ok(Between {
            name: self.describe(),
            first: self.first.0.shape,
            second: self.second.0.shape,
            continuity: self.continuity,
            step: match bound {
                Resolved::Places { .. } => 1.0,
                Resolved::Edges { conditions, .. } => conditions.step,
            },
            // Between the places where it is looked at a gap may be larger by so much.
            accuracy: self.tolerance.map_or(Accuracy::Rounding, |t| Accuracy::Within(SHOWN * t)),
            samples,
        })
    }
}

impl Functional for Join {
    fn equations(&self) -> usize {
        match self.bound.as_deref() {
            Some(Resolved::Edges { conditions, .. }) => 3 * conditions.rows.len(),
            _ => 3 * (self.continuity + 1),
        }
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let (a, b) = (self.first.0.shape, self.second.0.shape);
        let (first, second) = (shapes.get(a)?, shapes.get(b)?);
        match (&*self.fixed(shapes)?, &self.bound) {
            (Resolved::Places { first: at, second: with, factors }, _) => {
                for (k, factor) in factors.iter().enumerate() {
                    let first = first.stencil(*at, k.into())?;
                    let second = second.stencil(*with, k.into())?.scaled(*factor);
                    rows.difference((a, &first), (b, &second));
                }
            }
            (Resolved::Edges { conditions, .. }, Some(_)) => {
                for (first, second) in &conditions.rows {
                    rows.difference((a, first), (b, second));
                }
            }
            (Resolved::Edges { .. }, None) => {
                return self.fail(
                    "how many equations it has is known once it is bound; bind it to the shapes first",
                );
            }
        }
        Ok(())
    }

    /// Of whole edges before they are bound, for each order the difference where it is largest.
    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        if let (None, Place::Along(_), Place::Along(_)) = (&self.bound, self.first.1, self.second.1) {
            let largest = self.differences(shapes)?;
            out.iter_mut().zip(largest.iter().flatten()).for_each(|(out, value)| *out = *value);
            return Ok(());
        }
        let mut store = Store::default();
        self.rows(shapes, &mut store.rows(shapes))?;
        store.evaluate(shapes, out);
        Ok(())
    }

    fn describe(&self) -> String {
        let place = |place: &Place| match place {
            Place::At(location) => location.to_string(),
            Place::Along(edge) => edge.to_string(),
        };
        let ((a, at), (b, with)) = (&self.first, &self.second);
        format!("C{} join at {}{a} with {}{b}", self.continuity, place(at), place(with))
    }

    fn dimension(&self) -> Option<u8> {
        // Derivatives are lengths by parameters.
        (self.continuity == 0).then_some(1)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Self { bound: None, ..self.clone() }.fixed(shapes)?;
        Ok(Some(Arc::new(Self { bound: Some(bound), ..self.clone() })))
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.tolerance.map_or(Accuracy::Rounding, Accuracy::Within)
    }

    fn witness(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = self.fixed(shapes)?;
        match &*bound {
            Resolved::Places { .. } => Ok(None),
            Resolved::Edges { .. } => Ok(Some(Arc::new(self.between(shapes, &bound)?))),
        }
    }

    fn notes(&self) -> Vec<String> {
        match self.bound.as_deref() {
            Some(Resolved::Edges { conditions, .. }) => {
                conditions.note.iter().map(|note| format!("{}: {note}", self.describe())).collect()
            }
            _ => Vec::new(),
        }
    }
}

impl DeclaredFunctional for Join {
    const DECLARATION: Declaration = Declaration {
        name: "join",
        help: "two shapes meet, with continuity 0, 1 or 2",
        fields: &[
            Field::required(
                "at",
                "number, [u, v], { closest = [x, y, z] }, or an edge \"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"",
                "where on this shape",
            ),
            Field::required("with", "{ object, at }", "the other shape and where on it"),
            Field::optional("continuity", "0 | 1 | 2", "0", "derivatives that agree too"),
            Field::optional(
                "tolerance",
                "length",
                "none: to rounding, or refused",
                "whole edges: how far apart they may be, in position (from continuity 1 on, also the vertices beside the edge); angles are told, not bounded",
            ),
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
        let first = (On::from_parameters(parameters, names)?, place(parameters)?);
        let tolerance = parameters.has("tolerance").then(|| parameters.number("tolerance")).transpose()?;
        if let Some(tolerance) = tolerance.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return Err(
                parameters.error("tolerance", format!("{tolerance} is not a length; give a positive number"))
            );
        }
        Ok(Self { first, second, continuity, tolerance, bound: None })
    }
}

fn place(parameters: &Parameters) -> Result<Place, ParameterError> {
    if parameters.value("at").is_some_and(|at| at.is_string()) {
        Edge::from_parameters(parameters, "at").map(Place::Along)
    } else {
        parameters.location("at").map(Place::At)
    }
}
