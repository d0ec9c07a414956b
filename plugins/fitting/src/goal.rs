//! What a fit is to reach, in local coordinates.

use loftsman_kernel::Vector;
use loftsman_kernel::error::Figure;

use crate::error::{FitError, Result};
use crate::fit::{Fit, Target};
use crate::frame::Frame;
use crate::interpolation::unclosed;

/// The target in local coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    pub(crate) tolerance: Option<f64>,
    /// The most control vertices.
    pub(crate) vertices: usize,
    /// Whether it must be exactly so many.
    pub(crate) exact: bool,
    /// Whether somebody asked for a limit; otherwise it is the number of points.
    pub(crate) limited: bool,
}

impl Goal {
    pub(crate) fn new(fit: &Fit, frame: &Frame, points: &[Vector]) -> Result<Self> {
        let positive = |tolerance: f64| {
            if tolerance > 0.0 && tolerance.is_finite() {
                return Ok(tolerance);
            }
            Err(FitError::Request(format!(
                "a tolerance of {} cannot be met: give a positive length",
                Figure(tolerance)
            )))
        };
        let m = points.len();
        let least = if fit.closed { 3 } else { fit.degree + 1 };
        if m < least && fit.closed {
            return Err(unclosed(m, fit.degree));
        }
        if m < least {
            return Err(FitError::TooFewPoints {
                found: m,
                needed: least,
                degree: fit.degree,
                possible: m.saturating_sub(1),
            });
        }
        let counted = |vertices: usize| {
            if vertices >= least && vertices <= m {
                return Ok(vertices);
            }
            Err(FitError::Request(format!(
                "{vertices} control vertices cannot be fitted: choose from {least} (the degree is {}) to {m} (the points)",
                fit.degree
            )))
        };
        let limited = matches!(fit.target, Target::Vertices(_) | Target::AtMost { .. });
        let (tolerance, vertices, exact) = match fit.target {
            Target::Tolerance(t) => (Some(frame.enter_length(positive(t)?)), m, false),
            Target::Relative(t) => {
                let (low, high) =
                    points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
                (Some(positive(t)? * (high - low).norm()), m, false)
            }
            Target::Vertices(n) => (None, counted(n)?, true),
            Target::AtMost { tolerance, vertices } => {
                // Fewer points than that many vertices leave fewer to choose from, and are no reason to refuse.
                (Some(frame.enter_length(positive(tolerance)?)), counted(vertices.min(m))?, false)
            }
        };
        Ok(Self { tolerance, vertices, exact, limited })
    }

    pub(crate) fn holds(&self, error: f64) -> bool {
        self.tolerance.is_some_and(|t| error <= t)
    }
}
