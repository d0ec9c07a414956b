//! Any shape brought near to a cloud of points.

mod crossed;
mod descent;
mod foot;
mod handed_out;
mod merged;
mod model;
mod near;
pub(crate) mod operation;
mod patches;
mod plate;
mod rows;
mod sliding;
mod step;
mod tree;
mod turned;
mod weight;

use loftsman_kernel::text::{figure, short};
use std::fmt;
use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Constraint, Edit};
use loftsman_kernel::energy::Energy;
use loftsman_kernel::plugin::{ConstraintReport, Observer, Quiet};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::{Automatic, Solver};

use crate::error::Result;

pub use plate::DerivativeEnergy;
pub use turned::Turned;

/// Steps, at most, and the change that ends them, of the size of the points.
const ITERATIONS: usize = 100;
const TOLERANCE: f64 = 1e-9;
/// As many times as far from the points, or as large, as it was is a shape that went astray; and as many root mean squares farther.
const ASTRAY: f64 = 1.5;
const SCATTER: f64 = 3.0;

/// Moves the control vertices of a shape so that it comes as near as it can to points of which nobody knows where on the shape they
/// belong: the limit surface of a cage, a spline curve or surface, a shape of any other kind.
///
/// It makes `Σ w_k dist(Q_k, S)² / Σ w_k + Σ λ E` least under linear constraints, dist the distance from the nearest point of the
/// whole shape (its *foot*), `E` energies for the sake of fairness. Each step finds all feet, and takes the least of a quadratic
/// that has the first and second derivatives of the squared distances, feet going along with the shape (compare Pottmann and Hofer
/// 2003, who measure curvatures for it), but held back by as much as it takes to come nearer (Levenberg and Marquardt): so no step
/// makes it larger, and close to the least each step squares the error. Equations hold all the time; what conflicts, is redundant or left
/// open is named.
///
/// What is handed out is never more than what was there: distances are measured on it, feet looked for afresh. No place of the shape goes farther from
/// where it began than ten times the size of points and shape together, so that a loop that no point sees does not grow for ever: a step that would go
/// farther, or farther than that size at once, has the mean square of the shape's way added, with as little weight as keeps it within, so that where points
/// are it goes on.
///
/// Where it ends depends on where it starts, as with every search of this kind: the shape should be roughly in place. Where a shape
/// may reach beyond its points at an open border, steps gain less, and a hundred may not settle the last digits: the report says so.
///
/// *Cost.* A step finds every foot anew (up to 0.1 ms a point on a limit surface, less on splines) and factors a matrix as sparse as the
/// shape's control vertices are neighbours.
///
/// ```
/// use loftsman_fitting::CloudFit;
/// use loftsman_kernel::Point;
/// use loftsman_kernel::shape::{Derivative, Shape};
/// use loftsman_kernel::spline::Curve;
///
/// // Points of a parabola, from nobody knows which parameters, and a cubic that starts as a straight line.
/// let points: Vec<Point> = (0..50).map(|k| f64::from(k) / 49.0).map(|x| Point::new(x, x * x, 0.0)).collect();
/// let line = Curve::bezier((0..4).map(|k| Point::new(f64::from(k) / 3.0, 0.3, 0.0)).collect())?;
/// let fit = CloudFit::new(&line).to(&points)?;
/// assert!(fit.report().largest < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CloudFit<S> {
    shape: S,
    others: Vec<Box<dyn Shape>>,
    energies: Vec<(f64, Arc<dyn Energy>)>,
    fair: Option<DerivativeEnergy>,
    constraints: Vec<Constraint>,
    locks: Vec<i64>,
    weights: Option<Vec<f64>>,
    steady: bool,
    tolerance: f64,
    iterations: usize,
    smooth: u8,
}

impl<S: Shape + Clone> CloudFit<S> {
    /// A fit of a copy of a shape, from where it is.
    pub fn new(shape: &S) -> Self {
        Self {
            shape: shape.clone(),
            others: Vec::new(),
            energies: Vec::new(),
            fair: None,
            constraints: Vec::new(),
            locks: Vec::new(),
            weights: None,
            steady: false,
            tolerance: TOLERANCE,
            iterations: ITERATIONS,
            smooth: 1,
        }
    }

    /// Adds an energy to the mean of the squared distances, with a weight; it must be known by its [squares](Energy::squares). The
    /// energies of derivatives ([`DerivativeEnergy`], those of fairing) have the unit of a squared length, too: their weights are
    /// numbers, the same for shapes of any size. It determines what the points leave open.
    #[must_use]
    pub fn energy(mut self, weight: f64, energy: impl Energy + 'static) -> Self {
        self.energies.push((weight, Arc::new(energy)));
        self
    }

    /// Adds an energy whose weight follows from the noise of the points and from points left out. First `λ E = (3 / c) σ² γ / (N - d - γ)`, with `σ²` the mean of the squared
    /// distances of `N` points, `c` the coordinates that these see (two from a curve, one from a surface), `d` the dimensions of shapes without
    /// any of the energy, and `γ` those of the others that points determine beside it: the free vertices less `d` and the trace of `λ K` by the matrix of all. With
    /// as much as that the shape is, of all, the likeliest one under noise of this size in the points and in the energy's squares (the fixed
    /// point of the evidence, MacKay 1992). The search starts with far more and comes down to it, which keeps shapes from folding on the way;
    /// the less noise, the less energy, and none but for rounding where the shape can pass through all points ([`CloudReport::met`] where it can through any so few). Where even the most is not enough,
    /// as for points of a line with noise, the shape has no energy.
    ///
    /// A shape that winds through its points leaves less than their noise and has much energy, and the weight that follows is too small then. So,
    /// where noise is left, each quarter of the points is left out once, and a second weight is the largest of those, from a large one down to the one
    /// that followed, with which shapes fitted to the others come as near to these as they can. With both the fit begins anew from several places, the
    /// shape as it was given among them. Of where these lead, as far as noise explains how far the points are off, that is handed out which the points
    /// likelier come from: with the least of `2 log A + λ E / σ²`, `A` its area or length, so that no shape bends less by going where no point is.
    /// A surface is held from sliding along itself on all of the way ([`steady`](Self::steady)).
    /// [`CloudReport::fair`] says the weight. Cost: each weight that is tried factors one matrix more; points left out and starts anew, which
    /// [`iterations`](Self::iterations) does not count, are some three times as many steps as the rest, fewer where all lead to one place.
    #[must_use]
    pub fn fair(mut self, energy: DerivativeEnergy) -> Self {
        self.fair = Some(energy);
        self
    }

    /// Holds a surface from sliding along itself as much as the noise of the points calls for, as [`fair`](Self::fair) does by itself.
    ///
    /// No foot sees how a surface lies within itself, nor where it ends beyond its points: it crumples to follow noise, or leaves its border. So
    /// `n² σ² / (N (A/100)) · mean |P (S - S₀)|²` is added to what is least, `P` what is tangent to the given surface `S₀` of area `A` and `n`
    /// control vertices, `σ²` the mean square of the distances of those of `N` points that are not beyond the border: each control vertex is taken for
    /// given as well as to a tenth of its distance from the next, along the surface. Points beyond the border move this all the same, and without noise
    /// there is none of it. Multipliers of constraints are of what is least with it; [`CloudReport::energy`] is without.
    #[must_use]
    pub fn steady(mut self) -> Self {
        self.steady = true;
        self
    }

    /// Asks something that holds exactly. Everything linear can be asked for a value.
    #[must_use]
    pub fn ask(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Locks control vertices: they stay where they are. Negative numbers count from the end.
    #[must_use]
    pub fn lock(mut self, vertices: impl IntoIterator<Item = i64>) -> Self {
        self.locks.extend(vertices);
        self
    }

    /// Adds another shape to the problem: the next number (1, 2, …) for functionals' `on`. Constraints look at it, and it stays as it is; in an
    /// [edit](Edit::with) it may move, too.
    #[must_use]
    pub fn with(mut self, shape: Box<dyn Shape>) -> Self {
        self.others.push(shape);
        self
    }

    /// A positive weight for each point's squared distance; by default all are alike.
    #[must_use]
    pub fn weights(mut self, weights: Vec<f64>) -> Self {
        self.weights = Some(weights);
        self
    }

    /// The search ends when no point's foot is moved by more than this part of the diagonal of the points' box; `1e-9` by default.
    #[must_use]
    pub fn tolerance(mut self, relative: f64) -> Self {
        self.tolerance = relative;
        self
    }

    /// The most steps on the way to the weight that follows from the noise and with the one that is taken; 100 by default. Steps with points left out and
    /// from other places, by which that one is found, are not counted: with each weight 8 at most for each quarter, and 20 for each place.
    /// [`CloudReport::converged`] says whether they were enough.
    #[must_use]
    pub fn iterations(mut self, most: usize) -> Self {
        self.iterations = most;
        self
    }

    /// How smooth what was smooth stays, at knots where corners can appear, as in an [edit](Edit::smooth): 1 by default.
    #[must_use]
    pub fn smooth(mut self, level: u8) -> Self {
        self.smooth = level.min(2);
        self
    }

    /// Fits.
    ///
    /// # Errors
    /// When a point is not finite or there is none; when points, energies and constraints leave control vertices open
    /// ([`Undetermined`](crate::FitError::Undetermined), with the rank); when constraints conflict or are not linear.
    pub fn to(&self, points: &[Point]) -> Result<CloudFitted<S>> {
        self.watched(points, &Automatic, &Quiet)
    }

    /// The same with a solver for the constraints, watched: one unit of work is a step.
    ///
    /// # Errors
    /// As for [`to`](Self::to); [`Cancelled`](crate::FitError::Cancelled).
    pub fn watched(
        &self,
        points: &[Point],
        solver: &dyn Solver,
        observer: &dyn Observer,
    ) -> Result<CloudFitted<S>> {
        descent::fit(self, points, solver, observer)
    }

    /// An edit of the shape beside the others, which stay.
    fn edit(&self) -> Edit<S> {
        let mut edit = Edit::new(&self.shape).smooth(self.smooth).smooth_everywhere();
        edit = edit.lock(self.locks.iter().copied());
        for (index, other) in self.others.iter().enumerate() {
            let count = other.control_vertices().len() as i64;
            edit = edit.with(other.boxed()).lock_on(index + 1, 0..count);
        }
        self.constraints.iter().cloned().fold(edit, Edit::ask)
    }
}

/// A fitted shape, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudFitted<S> {
    shape: S,
    feet: Vec<Location>,
    report: CloudReport,
}

impl<S> CloudFitted<S> {
    /// The shape.
    pub fn shape(&self) -> &S {
        &self.shape
    }

    /// The shape, given away.
    pub fn into_shape(self) -> S {
        self.shape
    }

    /// Where each point's foot is.
    pub fn feet(&self) -> &[Location] {
        &self.feet
    }

    /// What the fit gave.
    pub fn report(&self) -> &CloudReport {
        &self.report
    }
}

/// What a fit to a cloud gave, measured on the shape that is handed out: printed by `Display`, kept by serde.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct CloudReport {
    /// The root of the (weighted) mean of the squared distances, of the shape as it was.
    pub before: f64,
    /// The same of the fitted shape.
    pub rms: f64,
    /// The largest distance of a point from the shape.
    pub largest: f64,
    /// The point that has it.
    pub worst: usize,
    /// What the energies come to, with their weights.
    pub energy: f64,
    /// The weight that followed from the noise, where that was asked for.
    pub fair: Option<f64>,
    /// Steps taken.
    pub iterations: usize,
    /// Whether they ended because nothing changed any more.
    pub converged: bool,
    /// Whether the last one was held back, since some of the shape would have gone farther from where it began than ten times the size of points and
    /// shape, or farther than that size at once.
    pub at_reach: bool,
    /// How far the last step moved a foot, at most.
    pub change: f64,
    /// The area of a surface, or the length of a curve, as it was and as it is.
    pub measure: [f64; 2],
    /// How far the shape lies from the nearest of the points, at most, as it was and as it is: where no point is.
    pub beyond: [f64; 2],
    /// Where a surface looks the other way than it did.
    pub turned: Turned,
    /// Whether an energy of a given weight leaves little to the points: the root mean square is more than a quarter of the points' own distance from
    /// their centre, and larger than it was, or the area (or length) less than half.
    pub outweighed: bool,
    /// Whether points are so few that the shape may pass through any: noise is not seen then, or too little of it.
    pub few: bool,
    /// Whether the shape passes through all points, but for a millionth of their size, and they are so few that it may pass through any: noise is not
    /// seen then.
    pub met: bool,
    /// Scalar equations of the constraints.
    pub equations: usize,
    /// Independent ones among them.
    pub rank: usize,
    /// Constraints (or parts of them) that the others imply: they were dropped, and hold.
    pub redundant: Vec<String>,
    /// The largest error of any constraint, in document units.
    pub residual: f64,
    /// `(Σ‖dᵢ‖²)^½` of the control vertices.
    pub adjustment: f64,
    /// The solver of the constraints.
    pub solver: String,
    /// Every constraint with its error and its multipliers: how much what is least would change with its value.
    pub constraints: Vec<ConstraintReport>,
}

impl CloudReport {
    /// Whether the shape went where no point is: it lies more than half as far again from the nearest point as it did, by more than the points are off,
    /// or is more than half as large again though it was in place.
    pub fn is_beyond(&self) -> bool {
        let ([near, far], [was, is]) = (self.beyond, self.measure);
        far > ASTRAY * near + SCATTER * self.rms || is > ASTRAY * was && self.before <= SCATTER * self.rms
    }
}

impl fmt::Display for CloudReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { before, rms, largest, worst, iterations, .. } = self;
        write!(
            f,
            "rms {before} → {rms} · largest {largest} at point {worst} · {iterations} steps",
            before = figure(*before),
            rms = figure(*rms),
            largest = figure(*largest)
        )?;
        if self.at_reach {
            write!(f, ", held back where no point is")?;
        } else if !self.converged {
            write!(f, ", not enough (the last one still moved a foot by {})", short(self.change))?;
        }
        if self.outweighed {
            let [was, is] = self.measure.map(figure);
            write!(f, " · the energy outweighs the points (size {was} → {is})")?;
        }
        if let Some(weight) = self.fair {
            write!(f, " · energy with weight {weight}", weight = short(weight))?;
        }
        if self.equations > 0 {
            write!(f, " · rank {} of {} · residual {}", self.rank, self.equations, short(self.residual))?;
        }
        Ok(())
    }
}
