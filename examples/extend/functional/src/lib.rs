//! A functional of one's own: the mean height of a shape's control vertices' curve, `∫ z du / (b - a)`.

use loftsman_kernel::Vector;
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters, Plugin, Registry};
use loftsman_kernel::shape::Location;

/// The mean height of a curve: `∫ z du / (b - a)`, by the midpoint rule with 64 places. Linear; one equation.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeanHeight;

impl Functional for MeanHeight {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let shape = shapes.get(0)?;
        let domain = shape.domain()[0];
        rows.equation();
        for i in 0..64 {
            let u = domain.start + (domain.end - domain.start) * (f64::from(i) + 0.5) / 64.0;
            let stencil = shape.stencil(Location::Curve(u), 0.into())?;
            rows.along(0, &stencil, Vector::z() / 64.0);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        "mean height".into()
    }
}

impl DeclaredFunctional for MeanHeight {
    const DECLARATION: Declaration =
        Declaration { name: "mean-height", help: "the mean height of a curve", fields: &[] };

    fn from_parameters(_: &Parameters, _: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self)
    }
}

impl Plugin for MeanHeight {
    fn register(&self, registry: &mut Registry) {
        registry.functional::<Self>();
    }
}
