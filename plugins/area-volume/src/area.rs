//! The area that curves enclose (paper 2).

use std::sync::Arc;

use loftsman_kernel::Result;
use loftsman_kernel::Vector;
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::text::figure;

use crate::NOTHING;
use crate::members::{OBJECT, OBJECTS};
use crate::region::{HOLES, NORMAL, Outline, Region, Work};

/// The area inside closed curves, `½ ∮ n·(C × C') du`: bilinear in the coordinates of the plane, `½ xᵀΦy` with the banded
/// [`AreaForm`](crate::AreaForm), which is computed once for an edit. One equation, with gradient `½ (ΦP)_i × n`; `O(n p)` an evaluation.
///
/// *Which curves*: periodic ones, open ones whose ends meet, several that are joined end to end; of a compound, each closed
/// part counts with its own direction, and [`holes`](Self::holes) count less whichever way they run.
///
/// *Its sign*: with a [`normal`](Self::normal), positive where the curve runs counter-clockwise seen against the normal; of
/// a curve in space it is the area of its projection along the normal. Without one, the curve must be planar, and its area
/// is positive.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Area {
    region: Region,
    bound: Option<Arc<Outline>>,
}

/// The area inside the first shape of the problem.
pub fn area() -> Area {
    Area::default()
}

impl Area {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The area that these shapes bound together.
    #[must_use]
    pub fn of<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.region.members = shapes.into_iter().collect();
        self
    }

    /// Less the areas inside these, whichever way they run.
    #[must_use]
    pub fn holes<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.region.holes = Some(shapes.into_iter().collect());
        self
    }

    /// Measured across this normal.
    #[must_use]
    pub fn normal(mut self, normal: impl Into<Vector>) -> Self {
        self.region.normal = Some(normal.into());
        self
    }

    fn prepared(&self, shapes: &Shapes<'_>) -> Result<Arc<Outline>> {
        match &self.bound {
            Some(bound) => Ok(Arc::clone(bound)),
            None => Ok(Arc::new(self.region.outline(shapes, &self.describe())?)),
        }
    }
}

impl Functional for Area {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Multilinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let bound = self.prepared(shapes)?;
        let plane = &bound.plane;
        let mut work = rows.scratch::<Work>();
        let mut total = 0.0;
        rows.equation();
        for piece in &bound.pieces {
            let points = shapes.get(piece.shape)?.control_vertices();
            total += piece.measure(points, plane, &mut work);
            let (x, y) = (plane.x * (0.5 * piece.sign), plane.y * (0.5 * piece.sign));
            let gradient = work.fx.iter().zip(&work.fy).map(|(fx, fy)| x * *fy - y * *fx);
            rows.terms(piece.shape, 0, gradient);
        }
        if let Some(value) = value.first_mut() {
            *value = total;
        }
        rows.return_scratch(work);
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let bound = self.prepared(shapes)?;
        let mut work = Work::default();
        let mut total = 0.0;
        for piece in &bound.pieces {
            total += piece.measure(shapes.get(piece.shape)?.control_vertices(), &bound.plane, &mut work);
        }
        if let Some(out) = out.first_mut() {
            *out = total;
        }
        Ok(())
    }

    fn check_target(&self, present: &[f64], wanted: &[f64]) -> Result<()> {
        let (Some(&present), Some(&wanted)) = (present.first(), wanted.first()) else { return Ok(()) };
        if wanted * present > 0.0 && wanted / present > NOTHING {
            return Ok(());
        }
        let what = self.describe();
        Err(Error::Invalid(if wanted.abs() <= NOTHING * present.abs() {
            format!(
                "{what}: nothing is left of it at an area of {}; ask for one like the present {present:.6}",
                figure(wanted)
            )
        } else {
            format!(
                "{what}: it is {present:.6} and should become {wanted:.6}, which would turn the curve inside out; give an \
                 area of the same sign, or reverse the curve or the normal"
            )
        }))
    }

    fn describe(&self) -> String {
        format!("area{}", self.region.describe())
    }

    fn dimension(&self) -> Option<u8> {
        Some(2)
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        self.region.companions()
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Some(self.prepared(shapes)?);
        Ok(Some(Arc::new(Self { bound, ..self.clone() })))
    }
}

impl DeclaredFunctional for Area {
    const DECLARATION: Declaration = Declaration {
        name: "area",
        help: "the area inside a closed planar curve, or several",
        fields: &[NORMAL, OBJECT, OBJECTS, HOLES],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { region: Region::from_parameters(parameters, names)?, bound: None })
    }
}
