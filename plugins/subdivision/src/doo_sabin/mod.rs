//! Doo-Sabin surfaces: biquadratic splines where the cage is a grid, smooth everywhere.
//!
//! Every corner becomes a vertex; every face, inner edge and inner vertex becomes a face. The boundary is not kept: the surface ends
//! where its last complete pieces do, as a spline with floating (not clamped) ends does. Creases and corners count for nothing.

mod elevate;
mod limit;
mod refine;
mod surface;
mod tune;

pub use elevate::elevated;
pub use limit::{limit_frames, limit_stencils};
pub(crate) use refine::double_knots;
pub use refine::{refine, refine_times, stencil};
pub use surface::DooSabinSurface;
pub(crate) use tune::irregular;
pub use tune::{FineTune, Tuned};
