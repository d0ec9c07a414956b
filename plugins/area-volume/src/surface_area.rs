//! How large surfaces are.

mod measure;

use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{
    Accuracy, DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes,
};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::shape::{Cell, Share};
use loftsman_kernel::text::short;
use loftsman_kernel::{Result, Vector};

use self::measure::{Area, Measure, extent, points};
use crate::length::positive;
use crate::members::{Members, OBJECT, OBJECTS, name_of, surface};

/// The area `∫∫ |S_u × S_v| du dv` of a surface, or of several together. One nonlinear equation.
///
/// Tensor Gauss–Legendre quadrature on each cell of the knots, by two rules; where they differ most, a part is halved, across
/// the direction to which that is due, until they agree everywhere to 1e-11 of a cell's share of the whole. So the rule
/// follows the surface as it changes, and a line of parameters along which `S_u × S_v` vanishes (where a surface of revolution
/// meets its axis) costs a few halvings. Their number is bounded: where the surface folds over along other lines the integrand
/// has a crease there that no rule gets hold of, the area cannot be told as well as it would have to be kept, and that is
/// said at once.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceArea {
    members: Members,
    /// How well the area can be told, where that is not to rounding.
    inaccuracy: Option<f64>,
    /// The most points at which a look evaluates the surfaces.
    effort: usize,
    /// For each member the cells that count and how much of them, where that is known.
    counted: Option<Arc<Vec<Counted>>>,
}

/// Cells of which something counts.
type Counted = Vec<(Cell, Share)>;

/// The area of the first shape of the problem, a surface.
pub fn surface_area() -> SurfaceArea {
    SurfaceArea::default()
}

/// By how much they may differ in all where that is not reached, relative.
const ENOUGH: f64 = 1e-6;
/// What they may differ by in all and still agree to rounding: the better of them is nearer by far.
const AS_GOOD: f64 = 1e-9;
/// An area below this share of the squared size is what rounding makes of none.
const NOTHING: f64 = 1e3 * f64::EPSILON;

impl SurfaceArea {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The area of all of these.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self { members: shapes.into_iter().collect(), ..Self::default() }
    }

    /// The area, and its gradient on each member where it is wanted.
    fn measure(
        &self,
        shapes: &Shapes<'_>,
        mut found: Option<&mut dyn FnMut(usize, Vec<Vector>)>,
    ) -> Result<Area> {
        let what = self.describe();
        let mut total = Area { area: 0.0, error: 0.0 };
        for (number, on) in self.members.0.iter().enumerate() {
            let own = surface(shapes, on, &what, "ask for the area inside it, or its length")?;
            let known = self.counted.as_ref().and_then(|all| all.get(number));
            let found_now = match known {
                None if own.splines.is_none() => Some(own.cells.counted(own.shape)?),
                _ => None,
            };
            let counted = known.or(found_now.as_ref()).map_or(&[][..], Vec::as_slice);
            let mut gradient = found.as_ref().map(|_| vec![Vector::zeros(); own.points().len()]);
            let Area { area, error } = Measure::new(&own, counted).whole(gradient.as_deref_mut())?;
            let name = name_of(on);
            if !area.is_finite() {
                return Err(Error::Invalid(format!(
                    "{what}: the area of {name} is beyond what numbers can hold; scale it down, or make its weights alike"
                )));
            }
            let size = extent(&own, counted);
            if area <= NOTHING * size * size {
                return Err(Error::Invalid(format!(
                    "{what}: {name} has no area, and no direction to grow in; move a vertex first"
                )));
            }
            if error > ENOUGH * area {
                return Err(Error::Invalid(format!(
                    "{what}: that of {name} can be told to {} of itself only, which is not enough to keep it or bring \
                     it to a value: the surface folds over or is creased along lines that are not knots, as it is or on the way \
                     to what is asked; unfold it, insert knots there, or ask for less at once",
                    short(error / area)
                )));
            }
            total.area += area;
            total.error += error;
            if let (Some(found), Some(gradient)) = (&mut found, gradient) {
                found(on.shape, gradient);
            }
        }
        Ok(total)
    }
}

impl Functional for SurfaceArea {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        rows.equation();
        let mut append = |shape, gradient: Vec<Vector>| {
            rows.terms(shape, 0, gradient.into_iter());
        };
        let total = self.measure(shapes, Some(&mut append))?;
        if let Some(value) = value.first_mut() {
            *value = total.area;
        }
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        if let Some(out) = out.first_mut() {
            *out = self.measure(shapes, None)?.area;
        }
        Ok(())
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        positive(&self.describe(), "surface area", wanted)
    }

    fn describe(&self) -> String {
        format!("surface area{}", self.members)
    }

    fn dimension(&self) -> Option<u8> {
        Some(2)
    }

    fn effort(&self) -> usize {
        self.effort
    }

    fn accuracy(&self) -> Accuracy {
        self.inaccuracy.map_or(Accuracy::Rounding, Accuracy::Within)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let what = self.describe();
        let mut counted = Vec::with_capacity(self.members.0.len());
        let mut effort = 0;
        for on in &self.members.0 {
            let own = surface(shapes, on, &what, "ask for the area inside it, or its length")?;
            // Loops stay as they are while control vertices move.
            let cells = if own.splines.is_some() { Vec::new() } else { own.cells.counted(own.shape)? };
            effort += points(&own, &cells);
            counted.push(cells);
        }
        let bound =
            Self { members: self.members.clone(), counted: Some(Arc::new(counted)), ..Self::default() };
        let Area { area, error } = bound.measure(shapes, None)?;
        let inaccuracy = (error > AS_GOOD * area).then_some(error);
        Ok(Some(Arc::new(Self { inaccuracy, effort, ..bound })))
    }
}

impl DeclaredFunctional for SurfaceArea {
    const DECLARATION: Declaration = Declaration {
        name: "surface-area",
        help: "the area of a surface, or of several together",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { members: Members::from_parameters(parameters, names, "objects")?, ..Self::default() })
    }
}
