//! Fine tuning: curves and surfaces deformed by scaling their derivatives (Miura, Cheng and Wang, paper 5).
//!
//! `D(t) = C(t₀) + ∫ α C'` has the tangent directions of `C` and its curvature divided by `α`: "make this part's curvature twice
//! as big" is `α = ½` there. With `α` a spline function `D` is a spline, computed exactly. [`FineTune`] says and does it for a
//! curve. The ends stay because α's values are the unknowns of linear equations which the kernel's engine solves with the least
//! change of the α asked for ([`Ends::Exact`], the default), closed curves and any other constraint included, or as in the paper.
//!
//! [`FineTuneSurface`] does it for a surface, in one direction or in both ([`Scaling`]).

mod alpha;
mod closed;
mod curvature;
mod curve;
mod edges;
mod ends;
mod error;
mod exact;
mod fit;
mod flat;
mod idle;
mod lift;
mod lines;
mod local;
mod lowest;
mod measure;
mod operation;
mod operator;
mod patch;
mod positive;
mod scale;
mod scaling;
mod similar;
mod springs;
mod surface;
mod tune;
mod turn;

pub use alpha::{alpha_of, alpha_space, derivative};
pub use curve::{Ends, FineTune, TuneReport, Tuned};
pub use error::{FineTuneError, Result};
pub use operation::FineTuneOperation;
pub use scale::Scale;
pub use scaling::{Scaling, surface_alpha_of, surface_alpha_spaces};
pub use springs::{Springs, Sprung};
pub use surface::{FineTuneSurface, SurfaceReport, TunedSurface};

use loftsman_kernel::plugin::{Plugin, Registry};

/// The plug-in: registers the operation `fine-tune`.
#[derive(Debug, Clone, Copy, Default)]
pub struct FineTuning;

impl Plugin for FineTuning {
    fn register(&self, registry: &mut Registry) {
        registry.operation(FineTuneOperation);
    }
}
