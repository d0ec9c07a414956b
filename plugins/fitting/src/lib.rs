//! Interpolation and least-squares fitting of B-spline curves: from points to curves and surfaces.
//!
//! | question | answer |
//! |---|---|
//! | a curve through these points | [`Interpolation`] |
//! | the nearest curve with these knots | [`LeastSquares`] |
//! | a curve within a tolerance, knots where they are needed | [`Fit`] |
//! | a surface through, or near to, a grid of points | [`GridFit`] |
//! | which parameters the points get | [`Parametrization`] |
//! | what must hold exactly | [`Constraint`](loftsman_kernel::edit::Constraint), any linear functional |
//! | the same in a recipe | the operation `fit`: [`FitPoints`], brought by the plug-in [`Fitting`] |
//! | any shape, of whatever kind, near to a cloud | [`CloudFit`]; in a recipe the operation `fit-shape`: [`FitShape`] |
//!
//! All equations are banded (around a circle for closed curves) and solved by orthogonal rotations, in time linear
//! in the number of points. Every answer comes with its residual and the condition of its equations; where these
//! are singular, the tolerance is not met, or the curve goes astray between the points (far longer than their polygon,
//! or turned back), there is an error that says what to do, and no curve. All of that is measured on the curve that is
//! handed out.

mod banded;
pub mod cloud;
mod constraint;
mod corner;
pub mod error;
pub mod fit;
mod fitted;
mod foot;
mod frame;
mod goal;
mod grading;
pub mod interpolation;
mod knots;
pub mod least_squares;
mod leeway;
mod measure;
pub mod operation;
pub mod parameters;
mod pieces;
mod placing;
mod refine;
mod round;
mod search;
mod smoothing;
mod solve;
mod state;
mod surely;
pub mod surface;
mod through;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use cloud::operation::FitShape;
pub use cloud::{CloudFit, CloudFitted, CloudReport, DerivativeEnergy, Turned};
pub use constraint::Kept;
pub use corner::{Corners, Doubt, Scatter};
pub use error::{Astray, FitError};
pub use fit::{Fit, FittedCurve, Target};
pub use interpolation::{Duplicates, Ends, Interpolated, Interpolation};
pub use least_squares::{Fitted, LeastSquares};
pub use operation::FitPoints;
pub use parameters::Parametrization;
pub use surface::{FittedSurface, GridFit};

/// The plug-in: registers the operation `fit`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fitting;

impl Plugin for Fitting {
    fn register(&self, registry: &mut Registry) {
        registry.operation(FitPoints);
        registry.operation(FitShape);
    }
}
