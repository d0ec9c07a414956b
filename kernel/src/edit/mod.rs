//! Editing under constraints: the least adjustment of shapes that meets what is asked of them.
//!
//! ```
//! use loftsman_kernel::edit::{Ask, Edit};
//! use loftsman_kernel::functional::{position, tangent};
//! use loftsman_kernel::spline::{Curve, Space};
//! use loftsman_kernel::Point;
//!
//! let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
//! let curve = Curve::new(Space::clamped_uniform(3, 12)?, points)?;
//! let moved = Edit::new(&curve)
//!     .ask(position(4.5).by([0.0, 1.0, 0.0]))
//!     .ask(tangent(4.5).keep())
//!     .lock([0, -1])
//!     .solve()?;
//! assert!((moved.shape().point(4.5)?.y - 1.0).abs() < 1e-15);
//! println!("{}", moved.report());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Edit`] says what is asked; [`Edit::prepare`] does all the work that can be done once (mouse down) and gives a
//! [`Session`], whose events (mouse moves) cost what the constraints touch, whatever the size of the shape.

mod builder;
mod locality;
mod report;
mod session;

pub use self::builder::Edit;
pub use self::locality::{Locality, localise, localities, pick};
pub use self::report::{ConstraintReport, Convergence, Corner, Report, Smoothness};
pub use self::session::{Edited, Session};
pub use crate::problem::{
    Ask, Axis, AxisOf, Constraint, ConstraintId, EditError, Measured, Metric, SmoothKnot, Tie, Unknowns,
    Value, Wanted,
};
