//! Subdivision curves and surfaces.
//!
//! A [`Cage`] is a polygon mesh with faces of any size and vertices of any valence; a subdivision scheme refines it again and again, and
//! what it comes to is a smooth surface. [`catmull_clark`] makes bicubic splines of grids, with boundaries, semi-sharp creases and
//! corners, and knot intervals; [`doo_sabin`] biquadratic ones. Where the vertices come to lie, and the tangent planes there, is known at
//! once, in bulk and as rows ([`LimitStencils`]) over the vertices of the cage, of which functionals and constraints are made. A
//! [`Polygon`] is the same for curves, Chaikin's and cubic ones, and is exactly a spline.
//!
//! A [`SubdivisionSurface`] is the limit as a shape, edited like any other; [`doo_sabin::DooSabinSurface`] that of Doo and Sabin's scheme. It becomes triangles within a certified tolerance, and bicubic
//! splines ([`Patches`]): exact where the cage is regular, within a certified tolerance at extraordinary vertices.
//!
//! ```
//! use loftsman_kernel::Point;
//! use loftsman_subdivision::{Cage, catmull_clark};
//!
//! let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
//! let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let cube = Cage::new((0..8).map(corner).collect(), &faces)?.with_crease(4, 5, 1.5)?;
//! let fine = catmull_clark::refine_times(&cube, 3)?;
//! assert_eq!(fine.topology().face_count(), 24 * 16);
//! let frames = catmull_clark::limit_frames(&fine)?;
//! assert_eq!(frames.len(), fine.points().len());
//! # Ok::<(), loftsman_subdivision::SubdivisionError>(())
//! ```

mod cage;
mod carry;
pub mod catmull_clark;
pub mod doo_sabin;
mod eigen;
mod error;
mod frame;
mod leading;
mod natural;
mod operation;
mod own;
mod part;
mod patches;
mod polygon;
mod row;
mod said;
mod surface;
mod together;
mod topology;
mod uniform;
mod used;
mod weld;

pub use cage::{BoundaryRule, Cage, INFINITELY_SHARP};
pub use error::{Result, SubdivisionError};
pub use frame::{LimitFrame, LimitStencils};
pub use operation::Subdivide;
pub use patches::ToPatches;
pub use polygon::{Polygon, Scheme};
pub use surface::{LeftOut, Patches, SubdivisionSurface};
pub use topology::{Around, NONE, Topology};

use loftsman_kernel::plugin::{Plugin, Registry};

/// The plug-in: registers the operations `subdivide` and `patches`, and the kinds of shapes `subdivision` and `doo-sabin`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Subdivision;

impl Plugin for Subdivision {
    fn register(&self, registry: &mut Registry) {
        registry.operation(Subdivide);
        registry.operation(ToPatches);
        registry.shape::<SubdivisionSurface>();
        registry.shape::<doo_sabin::DooSabinSurface>();
    }
}
