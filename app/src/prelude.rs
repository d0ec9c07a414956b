//! The names that most programs want: `use loftsman::prelude::*`.

pub use loftsman_area_volume::{area, centroid, length, surface_area, volume};
pub use loftsman_fitting::{Fit, Target};
pub use loftsman_kernel::edit::{Ask, Axis, Edit, Edited, Metric, Report, Session};
pub use loftsman_kernel::functional::{
    Evaluate, curvature, derivative, join, linear, magnitude, normal, orthogonal, position, present_normal,
    signed_curvature, symmetry, tangent, vertex,
};
pub use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
pub use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
pub use loftsman_kernel::shape::{Location, Shape};
pub use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Sparse};
pub use loftsman_kernel::spline::{Curve, Space, Surface};
pub use loftsman_kernel::{Point, Vector};
