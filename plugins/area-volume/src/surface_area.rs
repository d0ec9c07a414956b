//! How large surfaces are.

mod left;
mod measure;

use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{
    Accuracy, DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes,
};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::shape::{Cell, Shape, Share};
use loftsman_kernel::text::short;
use loftsman_kernel::{Result, Vector};

use self::left::Left;
use self::measure::{Area, Effort, Measure, points};
use crate::length::positive;
use crate::members::{Member, Members, OBJECT, OBJECTS, name_of, surface};
use crate::nets::Nets;

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

/// The cells of which something counts, of a surface that is summed neither by spans nor by nets.
fn counted_of(surface: &Member<'_>) -> Result<Counted> {
    let otherwise = surface.splines.is_some() || Nets::of(surface).is_some();
    if otherwise { Ok(Vec::new()) } else { surface.cells.counted(surface.shape) }
}

/// The area of the first shape of the problem, a surface.
pub fn surface_area() -> SurfaceArea {
    SurfaceArea::default()
}

/// By how much they may differ in all where that is not reached, relative.
const ENOUGH: f64 = 1e-6;
/// What they may differ by in all and still agree to rounding: the better of them is nearer by far.
const AS_GOOD: f64 = 1e-9;
/// What may be missing where an area is told once, and neither kept nor brought to a value, and the surface folds over: a part with a crease
/// counts as a part of its area then, for both rules may miss as much.
const TOLD: f64 = 1e-7;

/// The area `∫∫ |S_u × S_v| du dv` of a surface, parts that lie over one another each for itself.
///
/// The quadrature of [`SurfaceArea`], and where the surface folds over along lines that are no knots, where a constraint gives up, up to
/// sixty times as many halvings, until no more than 1e-7 of the whole may be missing: `m` parts along such a line leave an error of the
/// order of `m⁻²`. Rounding at the size of the surface is 0.
///
/// # Errors
/// When it is no surface, has no cells, its loops do not say what is inside, its area is beyond what numbers can hold, its control vertices are so
/// far off it that their rounding is as much as its area, or more than 1e-6 of it may be missing still.
pub fn surface_area_of(surface: &dyn Shape) -> Result<f64> {
    let (shapes, what) = (Shapes::one(surface), "surface area");
    let own = self::surface(&shapes, &On::from(0), what, "ask for the area inside it, or its length")?;
    let counted = counted_of(&own)?;
    let effort = Effort::Telling(TOLD);
    let Area { area, error } = Measure::new(&own, &counted, effort).whole(None, effort)?;
    if !area.is_finite() {
        return Err(Error::Invalid("it is beyond what numbers can hold".into()));
    }
    match Left::of(area, &own, &counted) {
        Left::Nothing => return Ok(0.0),
        Left::Rounding(times) => return Err(Error::Invalid(left::too_far(times))),
        Left::Area => {}
    }
    // Also where the error is no number.
    if error <= ENOUGH * area {
        return Ok(area);
    }
    Err(Error::Invalid(format!(
        "the surface folds over or is creased along lines that are not knots, and can be told to {} of itself only",
        short(error / area)
    )))
}

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
            let found_now = if known.is_none() { Some(counted_of(&own)?) } else { None };
            let counted = known.or(found_now.as_ref()).map_or(&[][..], Vec::as_slice);
            let mut gradient = found.as_ref().map(|_| vec![Vector::zeros(); own.points().len()]);
            let Area { area, error } = Measure::new(&own, counted, Effort::Keeping)
                .whole(gradient.as_deref_mut(), Effort::Keeping)?;
            let name = name_of(on);
            if !area.is_finite() {
                return Err(Error::Invalid(format!(
                    "{what}: the area of {name} is beyond what numbers can hold; scale it down, or make its weights alike"
                )));
            }
            match Left::of(area, &own, counted) {
                Left::Nothing => {
                    return Err(Error::Invalid(format!(
                        "{what}: {name} has no area, and no direction to grow in; move a vertex first"
                    )));
                }
                Left::Rounding(times) => {
                    let why = left::too_far(times);
                    return Err(Error::Invalid(format!("{what}: that of {name} cannot be told: {why}")));
                }
                Left::Area => {}
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
            let cells = counted_of(&own)?;
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
