//! The kernel's own kinds of functional, by name.

use super::Registry;
use crate::functional::{
    Curvature, DerivativeAt, Join, Linear, Magnitude, Normal, Orthogonal, Position, SignedCurvature,
    Symmetry, Tangent, VertexAt,
};

/// Registers all functionals of the kernel.
pub fn register_functionals(registry: &mut Registry) {
    registry.functional::<Position>();
    registry.functional::<DerivativeAt>();
    registry.functional::<Tangent>();
    registry.functional::<Magnitude>();
    registry.functional::<Orthogonal>();
    registry.functional::<Normal>();
    registry.functional::<Curvature>();
    registry.functional::<SignedCurvature>();
    registry.functional::<VertexAt>();
    registry.functional::<Symmetry>();
    registry.functional::<Join>();
    registry.functional::<Linear>();
}
