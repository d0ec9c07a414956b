//! Planar regions: closed curves with holes become filled meshes, and sections become solids.
//!
//! * `fill` fills what closed planar curves bound, by the even-odd rule: a curve inside another is a hole, one inside
//!   the hole an island. Constrained Delaunay triangles, refined to a size and an angle where that is asked for.
//! * `extrude` moves such a region along a vector: a closed mesh with caps, and on request the exact surfaces.
//! * `loft` lays a surface through closed sections and caps its ends.
//!
//! Walls come from the tessellator that is registered; caps use the walls' own points, so that solids are watertight.

mod cap;
mod error;
mod fill;
mod loft;
mod measure;
mod operations;
mod outline;
mod plane;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use cap::{Capped, boundary_loops, cap};
pub use error::{RegionError, Result};
pub use fill::{Filled, Refinement, fill};
pub use loft::{Aligned, Lofted, Narrow, loft};
pub use measure::{area, volume};
pub use operations::{Extrude, Fill, Loft};
pub use outline::{Outline, outlines};
pub use plane::Plane;

/// Registers `fill`, `extrude` and `loft`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Regions;

impl Plugin for Regions {
    fn register(&self, registry: &mut Registry) {
        registry.operation(Fill);
        registry.operation(Extrude);
        registry.operation(Loft);
    }
}
