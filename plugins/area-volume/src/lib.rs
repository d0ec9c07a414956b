//! What shapes enclose and measure, as constraints: the area inside curves, the volume inside surfaces, centroids, arc
//! length and surface area (after Elber, *Linearizing the Area and Volume Constraints*).
//!
//! [`AreaVolume`] registers them for recipes. In programs:
//!
//! ```
//! use loftsman_area_volume::area;
//! use loftsman_kernel::Point;
//! use loftsman_kernel::edit::{Ask, Edit};
//! use loftsman_kernel::functional::position;
//! use loftsman_kernel::solve::Automatic;
//! use loftsman_kernel::spline::{Curve, Space};
//!
//! let ring = (0..12).map(|i| (f64::from(i) * 30.0).to_radians().sin_cos());
//! let ring = ring.map(|(sin, cos)| Point::new(2.0 * cos, sin, 0.0)).collect();
//! let section = Curve::new(Space::periodic_uniform(3, 12)?, ring)?;
//! let mut drag = Edit::new(&section)
//!     .ask(area().keep())
//!     .handle(position(0.0))
//!     .prepare(Automatic)?;
//! let start = section.point(0.0)?;
//! for step in 1..=10 {
//!     let shape = drag.to_point(Point::new(start.x + 0.1 * f64::from(step), start.y, 0.0))?;
//!     assert!((loftsman_area_volume::area_of(shape)? - 5.733_247_420_397_618_5).abs() < 1e-11);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod area;
mod cell_flux;
mod centroid;
mod cone;
mod contour;
mod curve_rule;
mod flux;
mod form;
mod length;
mod members;
mod net_volume;
mod nets;
mod plane;
mod region;
mod row_flux;
mod rule;
mod solid;
mod span_flux;
mod sparse_form;
mod surface_area;
mod tie;
mod ties;
mod volume;

use loftsman_kernel::functional::{Evaluate, Functional, On, Shapes, value_of};
use loftsman_kernel::plugin::{Plugin, Registry};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::{Point, Result};

use crate::solid::Solid;

/// The share of the present area or volume below which nothing is left of a shape: its points' rounding is more.
const NOTHING: f64 = 1e-12;

pub use area::{Area, area};
pub use centroid::{Centroid, centroid};
pub use form::AreaForm;
pub use length::{Length, length};
pub use surface_area::{SurfaceArea, surface_area, surface_area_of};
pub use ties::{Closed, closed, gap};
pub use volume::{Volume, volume};

/// The plug-in: the functionals of this crate.
#[derive(Debug, Clone, Copy, Default)]
pub struct AreaVolume;

impl Plugin for AreaVolume {
    fn register(&self, registry: &mut Registry) {
        registry.functional::<Area>();
        registry.functional::<Volume>();
        registry.functional::<Centroid>();
        registry.functional::<Length>();
        registry.functional::<SurfaceArea>();
        registry.functional::<Closed>();
    }
}

/// The area inside a closed planar curve, positive: `area().evaluate(curve)`.
///
/// # Errors
/// When it is not closed or not planar, or encloses nothing.
pub fn area_of(curve: &dyn Shape) -> Result<f64> {
    area().evaluate(curve)
}

/// The volume inside a closed surface, positive where its normals point outwards: what `volume().evaluate(surface)` is. Nothing is kept for a second
/// time: where the surface says the [nets](loftsman_kernel::shape::Cells::nets) of its cells, these are summed side by side, without rows.
///
/// # Errors
/// When it is not closed, or encloses nothing.
pub fn volume_of(surface: &dyn Shape) -> Result<f64> {
    let mut value = [0.0];
    value_of(&volume(), &Shapes::one(surface), &mut value)?;
    Ok(value[0])
}

/// The same, with coordinates taken from `origin` and not from the middle of the box around its control vertices. What closes but for gaps, as the solids of files
/// do, has a volume that depends on it: by `(o₁ - o₀)·∮ n dA / 3` between two origins. Compared volumes, as those before and after an edit, have to be taken from
/// one.
///
/// # Errors
/// As for [`volume_of`].
pub fn volume_from(surface: &dyn Shape, origin: Point) -> Result<f64> {
    Solid::volume(Some(origin), &Shapes::one(surface), &[On::default()], &volume().describe())
}
