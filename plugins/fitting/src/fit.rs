//! The whole way from points to a curve: parameters, knots where they are needed, a tolerance that holds.

use loftsman_kernel::edit::Constraint;
use loftsman_kernel::spline::Curve;

use crate::constraint::Kept;
use crate::corner::{Corners, Scatter};
use crate::parameters::Parametrization;

/// What distance does not matter to a corner where there is no tolerance, as a share of the points' box.
pub(crate) const CORNER_SCALE: f64 = 1e-4;

/// How a fit decides that it is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// No point farther from the curve than this, in document units.
    Tolerance(f64),
    /// No point farther from the curve than this share of the diagonal of the box around the points.
    Relative(f64),
    /// This many control vertices, whatever the error.
    Vertices(usize),
    /// A tolerance in document units, with at most so many control vertices.
    AtMost {
        /// The tolerance.
        tolerance: f64,
        /// The most control vertices.
        vertices: usize,
    },
}

/// Fits a B-spline curve to points, given in order.
///
/// Least squares with parameters by chord length, knots added in the spans where the error is largest, until every point
/// is within the tolerance: measured, not assumed. Then even knots and knots spread evenly over the error are tried, fewer
/// and fewer. The same is done with parameters that are corrected (Hoschek 1988), and the curve with the fewest vertices
/// (where their number is given: with the least error) is the answer. So corrections never do harm, and a smooth curve's
/// points take no more vertices than least squares on even knots.
///
/// A curve can be near every point and yet go astray between them, where it has nearly as many unknowns as there are
/// points. So the curve must also travel as the points do, measured on the curve that is handed out:
/// * it is at most twice as long as the polygon of the points (longer only by four times the way that constraints
///   pull it);
/// * between two neighbouring points it is at most four times as long as the polygon there, or before or behind it;
/// * its tangent at a point makes no more than a right angle with the direction in which the polygon passes it (the
///   mean of the directions before and behind; where the polygon turns by more than 160° any tangent will do), unless
///   it goes back by no more than twice the largest error;
/// * it leaves the box of the points by no more than half the longest side of that (and what constraints pull it).
///
/// Points that are within ten times the largest error of the one before have no say in the last two, nor are these asked of
/// curves under constraints. The search is stricter, and a parameter correction that makes the curve longer is taken
/// back. Where least squares do not meet the tolerance with such a curve, the points are interpolated, by the
/// parameters asked for or by centripetal ones, or by a curve of lower degree raised to the one asked for:
/// [`remarks`](FittedCurve::remarks) tell.
///
/// ```
/// # use loftsman_fitting::{Fit, Target};
/// # use loftsman_kernel::Point;
/// let points: Vec<Point> = (0..=200).map(|i| 0.03 * f64::from(i)).map(|x| Point::new(x, x.sin(), 0.0)).collect();
/// let fitted = Fit::new(3, Target::Tolerance(1e-4)).curve(&points)?;
/// assert!(fitted.max_error <= 1e-4 && fitted.curve.points().len() < 25);
/// # Ok::<(), loftsman_fitting::FitError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Fit {
    /// The degree `p`, 1 to 25.
    pub degree: usize,
    /// When it is done.
    pub target: Target,
    /// Whether the curve closes smoothly (periodic). A last point that repeats the first is left out then.
    pub closed: bool,
    /// The parameters to start from.
    pub parameters: Parametrization,
    /// The most parameter corrections between two additions of knots; 0 keeps the parameters, in less time.
    pub corrections: usize,
    /// Whether an open curve starts in the first point and ends in the last one exactly (the default).
    pub keep_ends: bool,
    /// A positive weight a point; all 1 where left out.
    pub weights: Option<Vec<f64>>,
    /// What must hold exactly, on the domain of the parameters (0 to 1 but for given ones).
    pub constraints: Vec<Constraint>,
    /// As in [`LeastSquares::regularization`](crate::LeastSquares::regularization).
    pub regularization: f64,
    /// Where the curve has corners: it is fitted in pieces between them, which meet in the corner points.
    pub corners: Corners,
    /// Whether to spend what the tolerance leaves over on a curve that is as smooth as can be (the default): of
    /// small `∫ |C'''|²`, so that its curvature does not swing where the points are uneven.
    pub smooth: bool,
    /// Whether to return the best curve found, with `met = false`, where the tolerance cannot be met. Otherwise
    /// that is an error.
    pub best_effort: bool,
}

/// A fitted curve and how near it comes.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCurve {
    /// The curve: clamped, or periodic.
    pub curve: Curve,
    /// The parameter of each point.
    pub parameters: Vec<f64>,
    /// The largest distance of a point from the curve at its parameter, so never too small, in document units.
    pub max_error: f64,
    /// The largest distance of a point from the point of the curve that is nearest to it, in document units.
    pub distance: f64,
    /// The point that has this distance.
    pub farthest: usize,
    /// The length of the curve.
    pub length: f64,
    /// The length of the polygon of the points.
    pub polygon_length: f64,
    /// The points at which the curve has corners.
    pub corners: Vec<usize>,
    /// How far the points scatter, in document units, and where that leaves corners in doubt; none where it did not count.
    pub scatter: Option<Scatter>,
    /// What was done that was not asked for, in words.
    pub remarks: Vec<String>,
    /// The point that is farthest from the curve at its parameter.
    pub worst: usize,
    /// The root of the mean square of the distances at the parameters.
    pub rms_error: f64,
    /// The tolerance in document units, where there was one.
    pub tolerance: Option<f64>,
    /// Whether the tolerance holds (or the number of vertices is the one asked for).
    pub met: bool,
    /// Least-squares problems solved on the way.
    pub iterations: usize,
    /// Estimate of the condition number of the last one.
    pub condition: f64,
    /// Whether the points ended up interpolated, because nothing less met the tolerance.
    pub interpolated: bool,
    /// Whether the last point was left out because it repeats the first.
    pub closing_point_dropped: bool,
    /// What became of the constraints (the kept ends included).
    pub kept: Kept,
}

impl Fit {
    /// An open fit by chord length with up to four corrections a round and its ends kept.
    pub fn new(degree: usize, target: Target) -> Self {
        Self {
            degree,
            target,
            closed: false,
            parameters: Parametrization::default(),
            corrections: 4,
            keep_ends: true,
            weights: None,
            constraints: Vec::new(),
            regularization: 0.0,
            corners: Corners::None,
            smooth: true,
            best_effort: false,
        }
    }
}
