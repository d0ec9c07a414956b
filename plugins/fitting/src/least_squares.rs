//! Least squares: the spline curve of a given space that is nearest to points at their parameters.

use loftsman_kernel::Vector;
use loftsman_kernel::edit::Constraint;
use loftsman_kernel::spline::{Curve, Space};

use crate::banded::Stencils;
use crate::constraint::{Held, Holding, Kept, rough};
use crate::error::{FitError, Result};
use crate::frame::Frame;
use crate::knots::check_data;
use crate::smoothing::{smooth, straighten};
use crate::solve::factor;

const ADVICE: &str = "remove knots where there are few points, give more points, or ask for regularization";

/// A least-squares fit in a given space: `min Σ w_k |C(u_k) - Q_k|²` among the curves that meet the constraints.
///
/// ```
/// # use loftsman_fitting::LeastSquares;
/// # use loftsman_kernel::{Point, spline::Space};
/// let space = Space::clamped(3, &[0.0, 0.5, 1.0])?;
/// let parameters: Vec<f64> = (0..=20).map(|i| f64::from(i) / 20.0).collect();
/// let points: Vec<Point> = parameters.iter().map(|u| Point::new(*u, u * u, u * u * u)).collect();
/// let fitted = LeastSquares::new(space).curve(&parameters, &points)?;
/// assert!(fitted.max_error < 1e-14); // a cubic is in the space
/// # Ok::<(), loftsman_fitting::FitError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LeastSquares {
    /// The space of the curve: degree and knots, open or periodic.
    pub space: Space,
    /// A positive weight `w_k` a point; all 1 where left out. Only their ratios matter.
    pub weights: Option<Vec<f64>>,
    /// What must hold exactly.
    pub constraints: Vec<Constraint>,
    /// How strongly to hold vertices to a straight, even polygon where the data leave them open, relative to the
    /// data (1e-6 is little). 0, the default: such vertices are an error.
    pub regularization: f64,
}

/// A least-squares curve and how near it comes.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The curve.
    pub curve: Curve,
    /// The largest distance of a point from the curve at its parameter, in document units.
    pub max_error: f64,
    /// The point that has it.
    pub worst: usize,
    /// The root of the mean square of these distances, not weighted.
    pub rms_error: f64,
    /// Estimate of the condition number of the equations (of `A`, not of `AᵀA`).
    pub condition: f64,
    /// What became of the constraints.
    pub kept: Kept,
}

impl LeastSquares {
    /// A fit in this space, all points alike, no constraints.
    pub fn new(space: Space) -> Self {
        Self { space, weights: None, constraints: Vec::new(), regularization: 0.0 }
    }

    /// The curve nearest to `points` at `parameters` (any order; a periodic space wraps them).
    ///
    /// By orthogonal rotations of the banded equations, never by normal equations, whose condition is the square:
    /// `O(m p²)` for `m` points, memory `O(m p)`; `c` constraint equations add `O(n c (p + c))`.
    ///
    /// # Errors
    /// When points, parameters or weights are unusable or a parameter is outside an open space; when the points
    /// do not determine a vertex ([`FitError::NoData`], with the knot to remove); when constraints conflict. Whether
    /// the curve goes where the points go is not judged, since their parameters may come in any order:
    /// [`Fit`](crate::Fit) does.
    pub fn curve(&self, parameters: &[f64], points: &[loftsman_kernel::Point]) -> Result<Fitted> {
        if parameters.len() != points.len() {
            return Err(FitError::ParameterCount { parameters: parameters.len(), points: points.len() });
        }
        let frame = Frame::of(points)?;
        let local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
        let request = Request {
            space: &self.space,
            sites: parameters,
            points: &local,
            weights: self.weights.as_deref(),
            regularization: self.regularization,
            smoothing: &[],
        };
        request.check()?;
        let held = if self.constraints.is_empty() {
            Held::default()
        } else {
            Held::new(&self.constraints, &request.rough(&frame)?, &frame)?
        };
        let local_fit = request.solve(&held)?;
        let curve = Curve::new(self.space.clone(), frame.raise(&local_fit.vertices)?)?;
        // Measured on the curve that is handed out.
        let handed = frame.lower(&curve)?;
        let pairs = parameters.iter().zip(&local);
        let distances: Vec<f64> =
            pairs.map(|(&u, q)| Ok((handed.derivative(u, 0)? - q).norm())).collect::<Result<_>>()?;
        let worst = (0..distances.len()).fold(0, |w, k| if distances[k] > distances[w] { k } else { w });
        let mean = distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64;
        Ok(Fitted {
            max_error: frame.leave_length(distances[worst]),
            worst,
            rms_error: frame.leave_length(mean.sqrt()),
            condition: local_fit.condition,
            kept: local_fit.held.measured(&curve, points)?,
            curve,
        })
    }
}

/// A least-squares problem in local coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Request<'a> {
    pub(crate) space: &'a Space,
    pub(crate) sites: &'a [f64],
    pub(crate) points: &'a [Vector],
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) regularization: f64,
    /// The factor of each row of `∫ |C'''|²` in what is minimized; empty where it is not.
    pub(crate) smoothing: &'a [f64],
}

/// Its answer.
#[derive(Debug)]
pub(crate) struct LocalFit {
    pub(crate) vertices: Vec<f64>,
    pub(crate) condition: f64,
    pub(crate) held: Holding,
}

impl Request<'_> {
    /// Whether parameters, weights and regularization can be used.
    pub(crate) fn check(&self) -> Result<()> {
        let (start, end) = self.space.domain();
        for (index, &value) in self.sites.iter().enumerate() {
            if self.space.locate(value).is_err() {
                return Err(FitError::Parameter { index, value, start, end });
            }
        }
        if let Some(weights) = self.weights {
            check_weights(weights, self.points.len())?;
        }
        if !(self.regularization >= 0.0 && self.regularization.is_finite()) {
            let value = self.regularization;
            return Err(FitError::Request(format!("a regularization of {value} makes no sense: 0 or more")));
        }
        Ok(())
    }

    /// A curve over the space that follows the points roughly, in document coordinates.
    pub(crate) fn rough(&self, frame: &Frame) -> Result<Curve> {
        if self.sites.windows(2).all(|w| w[0] <= w[1]) {
            return rough(self.space, self.sites, self.points, frame);
        }
        let mut order: Vec<usize> = (0..self.sites.len()).collect();
        order.sort_by(|&a, &b| self.sites[a].total_cmp(&self.sites[b]));
        let sites: Vec<f64> = order.iter().map(|&k| self.sites[k]).collect();
        let points: Vec<Vector> = order.iter().map(|&k| self.points[k]).collect();
        rough(self.space, &sites, &points, frame)
    }

    /// Solves it.
    pub(crate) fn solve(&self, held: &Held) -> Result<LocalFit> {
        let space = self.space;
        if held.is_empty() && self.regularization == 0.0 && !space.is_periodic() {
            self.check_data()?;
        }
        let mut matrix = Stencils::collocation(space, self.sites)?;
        let mut rhs: Vec<f64> = self.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        // Rows are scaled by the roots of weights; the largest becomes 1, so that all rows stay comparable.
        let mut scales = match self.weights {
            None => Vec::new(),
            Some(weights) => {
                let largest = weights.iter().fold(0.0_f64, |m, &w| m.max(w));
                weights.iter().map(|w| (w / largest).sqrt()).collect()
            }
        };
        held.augment(&mut matrix, &mut rhs);
        let weighted = !scales.is_empty() || self.regularization > 0.0 || !self.smoothing.is_empty();
        if weighted {
            scales.resize(matrix.len(), 1.0);
        }
        if self.regularization > 0.0 {
            straighten(space, &mut matrix);
            rhs.resize(3 * matrix.len(), 0.0);
            scales.resize(matrix.len(), self.regularization.sqrt());
        }
        if !self.smoothing.is_empty() {
            smooth(space, &mut matrix);
            rhs.resize(3 * matrix.len(), 0.0);
            scales.extend(self.smoothing.iter().map(|f| f.sqrt()));
            scales.resize(matrix.len(), 0.0);
        }
        let weights = weighted.then_some(scales.as_slice());
        let (qr, condition) = factor(space, &matrix, weights, &rhs, 3, ADVICE)?;
        let mut vertices = qr.solve();
        let held = if held.is_empty() { Holding::default() } else { held.hold(&qr, &mut vertices)? };
        Ok(LocalFit { vertices, condition, held })
    }

    /// The distance of each point from the curve at its parameter.
    pub(crate) fn distances(&self, vertices: &[f64]) -> Result<Vec<f64>> {
        let matrix = Stencils::collocation(self.space, self.sites)?;
        let distance = |k: usize| (Vector::from(matrix.point(k, vertices)) - self.points[k]).norm();
        Ok((0..matrix.len()).map(distance).collect())
    }

    fn check_data(&self) -> Result<()> {
        if self.sites.windows(2).all(|w| w[0] <= w[1]) {
            return check_data(self.space, self.sites);
        }
        let mut sorted = self.sites.to_vec();
        sorted.sort_by(f64::total_cmp);
        check_data(self.space, &sorted)
    }
}

/// Whether there is one positive, finite weight a point.
pub(crate) fn check_weights(weights: &[f64], points: usize) -> Result<()> {
    if weights.len() != points {
        return Err(FitError::Weights { found: weights.len(), points });
    }
    match weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w > 0.0)) {
        Some((index, &value)) => Err(FitError::Weight { index, value }),
        None => Ok(()),
    }
}
