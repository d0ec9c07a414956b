//! Fitting done: parameters, corners, a search for the number of vertices, and what comes of it.

use loftsman_kernel::plugin::{Observer, Quiet};
use loftsman_kernel::{Point, Vector};

use crate::corner::Scatter;
use crate::error::Result;
use crate::fit::{CORNER_SCALE, Fit, FittedCurve};
use crate::frame::Frame;
use crate::goal::Goal;
use crate::least_squares::check_weights;
use crate::pieces::Whole;

impl Fit {
    /// Fits the points. `O(m p²)` a solve; the number of solves grows with the logarithm of the vertices.
    ///
    /// # Errors
    /// When points, weights or the target are unusable; there are too few points for the degree; constraints
    /// conflict; the tolerance is not met and `best_effort` is not set; or the curve goes astray between the points.
    pub fn curve(&self, points: &[Point]) -> Result<FittedCurve> {
        self.watched(points, &Quiet)
    }

    /// As [`curve`](Self::curve), watched: told of each round, and cancelled between two solves.
    ///
    /// # Errors
    /// As for [`curve`](Self::curve); also [`FitError::Cancelled`](crate::FitError::Cancelled).
    pub fn watched(&self, points: &[Point], observer: &dyn Observer) -> Result<FittedCurve> {
        if self.degree == 0 || self.degree > loftsman_kernel::error::MAX_DEGREE {
            return Err(loftsman_kernel::Error::Degree { degree: self.degree }.into());
        }
        let frame = Frame::of(points)?;
        let mut local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
        let closing_point_dropped = self.closed && local.first() == local.last();
        if closing_point_dropped {
            local.pop();
        }
        let weights = match &self.weights {
            None => None,
            Some(weights) => {
                check_weights(weights, points.len())?;
                Some(&weights[..local.len()])
            }
        };
        let sites = self.parameters.of_local(&local, self.closed)?;
        let goal = Goal::new(self, &frame, &local)?;
        let size = local.iter().fold(0.0_f64, |m, p| m.max((p - local[0]).amax()));
        let (corners, scatter) =
            self.corners.find(&local, self.closed, goal.tolerance.unwrap_or(CORNER_SCALE * size));
        let whole =
            Whole { fit: self, frame: &frame, points: &local, sites: &sites, weights, goal, observer };
        let found = whole.search(&corners)?;
        let fitted = whole.finish(found, points, corners, closing_point_dropped)?;
        let scatter = scatter.map(|s| Scatter { deviation: frame.leave_length(s.deviation), ..s });
        Ok(FittedCurve { scatter, ..fitted })
    }
}
