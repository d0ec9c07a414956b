//! The volume that surfaces enclose (paper 2, §4).

use std::sync::Arc;

use loftsman_kernel::Result;
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::text::figure;

use crate::NOTHING;
use crate::members::{Members, OBJECT, OBJECTS};
use crate::solid::{Solid, Work};
use crate::ties::Closed;

/// The volume inside closed surfaces, `⅓ ∫∫ S·(S_u × S_v) du dv`: trilinear in the three coordinates. One equation, with
/// gradient `∫∫ R_ij (S_u × S_v)`, by sum-factorised quadrature that is exact for polynomial surfaces.
///
/// *Which surfaces*: periodic ones, ones whose edges coincide or shrink to poles, and closed sets of patches that meet edge
/// to edge, whatever the degrees and knots of the edges. What meets is kept together ([`Closed`]) while it is edited.
///
/// *Its sign*: positive where `S_u × S_v` (of the first patch) points outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    members: Members,
    bound: Option<Arc<Solid>>,
}

/// The volume inside the first shape of the problem.
pub fn volume() -> Volume {
    Volume { members: Members::default(), bound: None }
}

impl Volume {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The volume that these shapes bound together.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self { members: shapes.into_iter().collect(), bound: None }
    }

    fn prepared(&self, shapes: &Shapes<'_>) -> Result<Arc<Solid>> {
        match &self.bound {
            Some(bound) => Ok(Arc::clone(bound)),
            None => Ok(Arc::new(Solid::new(shapes, &self.members.0, false, &self.describe())?)),
        }
    }
}

impl Functional for Volume {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Multilinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let solid = self.prepared(shapes)?;
        let mut work = rows.scratch::<Work>();
        let measured = solid.measure(shapes, &mut work)?;
        rows.equation();
        for (shape, gradients) in &measured.gradients {
            rows.terms(*shape, 0, gradients[0].iter().copied());
        }
        if let Some(value) = value.first_mut() {
            *value = measured.values[0];
        }
        rows.return_scratch(work);
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        if let Some(out) = out.first_mut() {
            *out = match &self.bound {
                Some(solid) => solid.measure(shapes, &mut Work::default())?.values[0],
                None => Solid::volume(None, shapes, &self.members.0, &self.describe())?,
            };
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
                "{what}: nothing is left of it at a volume of {}; ask for one like the present {present:.6}",
                figure(wanted)
            )
        } else {
            format!(
                "{what}: it is {present:.6} (negative where the surface's normals point inwards) and should become \
                 {wanted:.6}, which would turn it inside out; give a volume of the same sign, or reverse the surface"
            )
        }))
    }

    fn describe(&self) -> String {
        format!("volume{}", self.members)
    }

    fn dimension(&self) -> Option<u8> {
        Some(3)
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        vec![Arc::new(Closed::of_members(self.members.clone()))]
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Some(self.prepared(shapes)?);
        Ok(Some(Arc::new(Self { members: self.members.clone(), bound })))
    }
}

impl DeclaredFunctional for Volume {
    const DECLARATION: Declaration = Declaration {
        name: "volume",
        help: "the volume inside a closed surface, or a closed set of patches",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { members: Members::from_parameters(parameters, names, "objects")?, bound: None })
    }
}
