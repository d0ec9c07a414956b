//! Shapes made from nothing and from one another, exactly where that can be:
//!
//! * `line`, `polyline`, `circle`, `arc`, `ellipse`: curves from numbers;
//! * `revolve`: the surface that a curve goes through when turned about an axis;
//! * `isocurve`, `edge`: curves of surfaces, edges of Breps;
//! * `offset`: planar curves at a distance from one, within a tolerance, loops cut away;
//! * `sew`: faces that lie beside one another made one shell or solid;
//! * `sweep`: the surface that a curve goes through when moved along another;
//! * `symmetrize`: shapes made exactly symmetric about a plane;
//! * `sample`: points spread evenly along a curve or polyline.
//!
//! ```
//! use loftsman_construction::{Spread, spread};
//! use loftsman_kernel::{Point, Vector, spline::Curve};
//! let circle = Curve::circle(Point::origin(), Vector::z(), 2.0)?;
//! let ring = spread(&circle, Spread::Count(12))?;
//! assert!(ring.closed && ring.points.len() == 12);
//! # Ok::<(), loftsman_kernel::Error>(())
//! ```

mod edge;
mod fields;
mod isocurve;
mod offset;
mod primitives;
mod revolve;
mod sample;
mod sense;
mod sew;
mod sweep;
mod symmetrize;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use edge::EdgeOf;
pub use isocurve::Isocurve;
pub use offset::{Corners, Offset, OffsetOf, OffsetOptions, offset};
pub use primitives::{Arc, Circle, Ellipse, Line, PolylineOf, arc_through};
pub use revolve::Revolve;
pub use sample::{Sample, Sampled, Spread, spread};
pub use sew::{Sew, Sewn, sew};
pub use sweep::{Mitre, Sweep, Swept, Turning, sweep};
pub use symmetrize::{
    Corner, Half, Mirror, Symmetric, Symmetrize, symmetrize, symmetrize_surface, symmetrize_surface_best,
};

/// Registers the operations.
#[derive(Debug, Clone, Copy, Default)]
pub struct Construction;

impl Plugin for Construction {
    fn register(&self, registry: &mut Registry) {
        registry.operation(Line);
        registry.operation(PolylineOf);
        registry.operation(Circle);
        registry.operation(Arc);
        registry.operation(Ellipse);
        registry.operation(Revolve);
        registry.operation(Isocurve);
        registry.operation(EdgeOf);
        registry.operation(Sample);
        registry.operation(OffsetOf);
        registry.operation(Sew);
        registry.operation(Sweep);
        registry.operation(Symmetrize);
    }
}
