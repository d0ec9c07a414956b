//! The subdivision surface that an object is, of either scheme.

use std::any::Any;

use loftsman_kernel::scene::Geometry;

use crate::doo_sabin::DooSabinSurface;
use crate::{Cage, Patches, Result, SubdivisionSurface};

/// A surface of either scheme.
pub(crate) enum Own<'a> {
    CatmullClark(&'a SubdivisionSurface),
    DooSabin(&'a DooSabinSurface),
}

impl Own<'_> {
    /// The cage as it was given.
    pub(crate) fn cage(&self) -> &Cage {
        match self {
            Self::CatmullClark(surface) => surface.cage(),
            Self::DooSabin(surface) => surface.cage(),
        }
    }

    pub(crate) fn size(&self) -> Result<f64> {
        match self {
            Self::CatmullClark(surface) => surface.size(),
            Self::DooSabin(surface) => surface.size(),
        }
    }

    pub(crate) fn patches(&self, tolerance: f64) -> Result<Patches> {
        match self {
            Self::CatmullClark(surface) => surface.patches(tolerance),
            Self::DooSabin(surface) => surface.patches(tolerance),
        }
    }
}

/// The subdivision surface that a geometry is.
pub(crate) fn surface(geometry: &Geometry) -> Option<Own<'_>> {
    let Geometry::Custom(custom) = geometry else { return None };
    let any: &dyn Any = custom.shape().ok()?;
    any.downcast_ref().map(Own::CatmullClark).or_else(|| any.downcast_ref().map(Own::DooSabin))
}
