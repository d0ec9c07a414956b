//! Interpolation: the spline curve that passes through points.

use loftsman_kernel::functional::{Functional, Shapes, derivative};
use loftsman_kernel::measure::{Error, ROUNDING, measure, place};
use loftsman_kernel::solve::Sense;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::banded::Stencils;
use crate::error::{FitError, Result};
use crate::frame::Frame;
use crate::knots;
use crate::measure::{Course, LIMIT};
use crate::parameters::{Parametrization, coincident};
use crate::solve::{Solution, residual, solve};

/// Larger residuals than this share of the points' size are not an interpolation.
const RESIDUAL: f64 = 1e-9;
const ASTRAY: &str = "try centripetal parameters, a lower degree, or a fit to a tolerance";
const ADVICE: &str = "give the points more even parameters, a lower degree, or (closed curves) an odd degree";

/// What an interpolating open curve does at its ends.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Ends {
    /// As many vertices as points, knots by averaging the parameters: the default.
    #[default]
    Averaged,
    /// As many vertices as points, knots at the points but the outermost ones (between them for even degrees).
    NotAKnot,
    /// Knots at the points; derivatives of order `(p+1)/2 … p-1` vanish at both ends. Odd degrees only.
    Natural,
    /// The derivatives of order 1, 2, … by the curve's parameter, at the start and at the end. With `(p-1)/2` of
    /// them at each end the knots are at the points (the *complete* spline), otherwise by averaging.
    Derivatives {
        /// At the start: the first derivative, then the second, …
        start: Vec<Vector>,
        /// At the end.
        end: Vec<Vector>,
    },
}

impl Ends {
    /// The derivatives that were given on the domain from `a` to `b`: order, place and value.
    fn given(&self, a: f64, b: f64) -> impl Iterator<Item = (usize, f64, &Vector)> {
        let (start, end): (&[Vector], &[Vector]) = match self {
            Self::Derivatives { start, end } => (start, end),
            _ => (&[], &[]),
        };
        let at = |u: f64| move |(k, vector)| (k + 1, u, vector);
        start.iter().enumerate().map(at(a)).chain(end.iter().enumerate().map(at(b)))
    }
}

/// Derivatives at an end: their orders and values.
type Orders = Vec<(usize, Vector)>;

/// What to do about neighbouring points that coincide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Duplicates {
    /// An error that names them: the default.
    #[default]
    Refuse,
    /// Leave the later one out, and say so.
    Merge,
}

/// Interpolation of points by a B-spline curve.
///
/// ```
/// # use loftsman_fitting::Interpolation;
/// # use loftsman_kernel::Point;
/// let points = [(0.0, 0.0), (1.0, 2.0), (3.0, 1.0), (4.0, 3.0), (6.0, 0.0)].map(|(x, y)| Point::new(x, y, 0.0));
/// let through = Interpolation::new(3).curve(&points)?;
/// assert!(through.residual < 1e-14);
/// # Ok::<(), loftsman_fitting::FitError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    /// The degree `p` of the curve, 1 to 25.
    pub degree: usize,
    /// Whether the curve closes smoothly (periodic) from the last point to the first.
    pub closed: bool,
    /// Which parameters the points get.
    pub parameters: Parametrization,
    /// What an open curve does at its ends. A closed curve has none.
    pub ends: Ends,
    /// What to do about points that coincide with the one before.
    pub duplicates: Duplicates,
}

/// An interpolating curve and how well it interpolates.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolated {
    /// The curve.
    pub curve: Curve,
    /// The parameter of each point that was kept.
    pub parameters: Vec<f64>,
    /// The largest distance of a point from the curve at its parameter, in document units: rounding.
    pub residual: f64,
    /// Estimate of the condition number of the equations.
    pub condition: f64,
    /// Points left out because they coincide with the one before ([`Duplicates::Merge`]).
    pub merged: Vec<usize>,
}

/// An interpolating curve in local coordinates, with the points and parameters that were kept.
#[derive(Debug)]
pub(crate) struct Local {
    pub(crate) space: Space,
    pub(crate) vertices: Vec<f64>,
    pub(crate) points: Vec<Vector>,
    pub(crate) sites: Vec<f64>,
    pub(crate) condition: f64,
    pub(crate) merged: Vec<usize>,
}

impl Interpolation {
    /// Open, by chord length, knots by averaging; coincident points refused.
    pub fn new(degree: usize) -> Self {
        Self {
            degree,
            closed: false,
            parameters: Parametrization::default(),
            ends: Ends::default(),
            duplicates: Duplicates::default(),
        }
    }

    /// The curve through the points.
    ///
    /// Open: a clamped curve, its domain from the first parameter to the last. Closed: a periodic curve with one
    /// vertex a point; a last point that repeats the first is an error or merged like other duplicates. Odd
    /// degrees have their knots at the points, even ones halfway between (their domain starts half a step before
    /// the first point). The equations are banded and solved by orthogonal rotations: `O(n p²)`, memory `O(n p)`.
    ///
    /// # Errors
    /// When a coordinate is not finite; there are too few points for the degree; points coincide and are not to
    /// be merged; end conditions do not fit the degree; or the equations are singular (possible for closed
    /// curves of even degree); or the curve goes astray between the points ([`FitError::Astray`]): measured on the
    /// curve, it is more than twice as long as their polygon, more than four times as long as the chords about one
    /// place, or passes a point backwards. Curves with given end derivatives may do as these say.
    pub fn curve(&self, points: &[Point]) -> Result<Interpolated> {
        if self.degree == 0 {
            return Err(loftsman_kernel::Error::Degree { degree: 0 }.into());
        }
        let frame = Frame::of(points)?;
        let local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
        let sites = self.parameters.of_local(&local, self.closed)?;
        let Local { space, mut vertices, points: local, sites, condition, merged } =
            self.local(&frame, local, sites)?;
        if let (false, Some(last)) = (self.closed, local.len().checked_sub(1)) {
            // A clamped curve's ends are its outermost vertices: to the last bit.
            let end = vertices.len() - 3;
            vertices[..3].copy_from_slice(local[0].as_slice());
            vertices[end..].copy_from_slice(local[last].as_slice());
        }
        let curve = Curve::new(space, frame.raise(&vertices)?)?;
        // Measured on the curve that is handed out.
        let handed = frame.lower(&curve)?;
        let course =
            Course { points: &local, sites: &sites[..local.len()], closed: self.closed, corners: &[] };
        let mut found = vec![Point::origin(); local.len()];
        curve.points_into(course.sites, &mut found)?;
        let residual = if frame.only_scales() {
            let pairs = found.iter().zip(&local);
            pairs.map(|(&found, point)| (frame.enter(found) - point).norm()).fold(0.0, f64::max)
        } else {
            course.distances(&handed)?.into_iter().fold(0.0, f64::max)
        };
        self.check(&curve, points, &merged, &found)?;
        // Given derivatives may send the curve anywhere between the points.
        let free = matches!(self.ends, Ends::Derivatives { .. });
        if !free && !course.surely_follows(&handed, &LIMIT)? {
            let travel = course.travel(&handed, 0.0)?;
            let number = |k: usize| (0..points.len()).filter(|i| !merged.contains(i)).nth(k).unwrap_or(k);
            if let Some(astray) = travel.trouble(&LIMIT, 0.0, false) {
                return Err(FitError::Astray { astray: astray.renumbered(number), advice: ASTRAY });
            }
        }
        if let (false, Some(astray)) = (free, course.outside(&handed, 0.0)?) {
            return Err(FitError::Astray { astray, advice: ASTRAY });
        }
        Ok(Interpolated {
            curve,
            parameters: course.sites.to_vec(),
            residual: frame.leave_length(residual),
            condition,
            merged,
        })
    }

    /// Whether the curve that is handed out passes the points, and has the derivatives that were given.
    /// `found`: where it is at the parameters.
    fn check(&self, curve: &Curve, points: &[Point], merged: &[usize], found: &[Point]) -> Result<()> {
        let largest = |points: &[Point]| points.iter().fold(0.0_f64, |most, p| most.max(p.coords.amax()));
        let (vertices, reach) = (largest(curve.points()), largest(points));
        let mut merged = merged.iter().peekable();
        let distinct = (0..points.len()).filter(|i| merged.next_if_eq(&i).is_none());
        for (index, found) in distinct.zip(found) {
            // Every place is allowed as much.
            if (found - points[index]).amax() <= ROUNDING * reach {
                continue;
            }
            let measured = place(found, &points[index], vertices, reach);
            if !measured.holds() {
                let Error { error, allowed } = measured;
                return Err(FitError::Missed { name: format!("point {index}"), error, allowed });
            }
        }
        let (a, b) = curve.domain();
        for (order, u, vector) in self.ends.given(a, b) {
            let functional = derivative(u, order);
            let shapes = Shapes::one(curve);
            let found = measure(&shapes, &functional, Sense::Equal, vector.as_slice(), &|_| true, reach)?;
            if !found.holds() {
                let (name, Error { error, allowed }) = (functional.describe(), found.verdict());
                return Err(FitError::Missed { name, error, allowed });
            }
        }
        Ok(())
    }

    /// The same in local coordinates, not yet judged: only that the equations hold.
    pub(crate) fn local(&self, frame: &Frame, mut points: Vec<Vector>, mut sites: Vec<f64>) -> Result<Local> {
        let merged = self.merge(&mut points, &mut sites)?;
        let (space, matrix, rhs) = if self.closed {
            self.closed_system(&points, &sites)?
        } else {
            self.open_system(frame, &points, &sites)?
        };
        let solution = solve(&space, &matrix, None, &rhs, 3, ADVICE)?;
        let (largest, _) = residual(&matrix, &solution.vertices, &rhs);
        if largest.is_nan() || largest > RESIDUAL {
            let near = space.domain().0;
            return Err(FitError::IllConditioned { condition: solution.condition, near, advice: ADVICE });
        }
        let Solution { vertices, condition } = solution;
        Ok(Local { space, vertices, points, sites, condition, merged })
    }

    /// Leaves coincident points out, where asked.
    fn merge(&self, local: &mut Vec<Vector>, sites: &mut Vec<f64>) -> Result<Vec<usize>> {
        let mut equal = coincident(sites);
        if equal.is_empty() {
            return Ok(equal);
        }
        let count = equal.len();
        // The first point again, a period later: it is the last one that goes.
        for i in &mut equal {
            *i = (*i).min(local.len() - 1);
        }
        equal.dedup();
        if self.duplicates == Duplicates::Refuse {
            equal.truncate(8);
            return Err(FitError::Coincident { indices: equal, count });
        }
        let mut gone = equal.iter().peekable();
        let mut index = 0;
        let mut keep = || {
            let stays = gone.next_if(|&&i| i == index).is_none();
            index += 1;
            stays
        };
        let flags: Vec<bool> = (0..local.len()).map(|_| keep()).collect();
        let mut at = 0;
        local.retain(|_| {
            at += 1;
            flags[at - 1]
        });
        at = 0;
        let last = sites.len() - 1;
        sites.retain(|_| {
            at += 1;
            // The closing parameter always stays; an open end keeps its parameter through the point before it.
            flags.get(at - 1).copied().unwrap_or(at - 1 == last)
        });
        Ok(equal)
    }

    fn closed_system(&self, local: &[Vector], sites: &[f64]) -> Result<(Space, Stencils, Vec<f64>)> {
        if self.ends != Ends::Averaged {
            return Err(FitError::Request("a closed curve has no ends: leave the end conditions out".into()));
        }
        if local.len() < 3 {
            return Err(unclosed(local.len(), self.degree));
        }
        let space = knots::around(self.degree, sites)?;
        let matrix = Stencils::collocation(&space, &sites[..local.len()])?;
        Ok((space, matrix, flat(local)))
    }

    fn open_system(
        &self,
        frame: &Frame,
        local: &[Vector],
        sites: &[f64],
    ) -> Result<(Space, Stencils, Vec<f64>)> {
        let p = self.degree;
        let (start, end): (Orders, Orders) = match &self.ends {
            Ends::Averaged | Ends::NotAKnot => (Vec::new(), Vec::new()),
            Ends::Natural if p.is_multiple_of(2) => {
                return Err(FitError::Request(format!(
                    "natural ends need an odd degree, not {p}: choose {} or other ends",
                    p + 1
                )));
            }
            Ends::Natural if sites.len() < p.div_ceil(2) => {
                let (found, needed) = (sites.len(), p.div_ceil(2));
                return Err(FitError::TooFewPoints { found, needed, degree: p, possible: 2 * found - 1 });
            }
            Ends::Natural => {
                let zero: Vec<_> = (p.div_ceil(2)..p).map(|order| (order, Vector::zeros())).collect();
                (zero.clone(), zero)
            }
            Ends::Derivatives { start, end } => {
                let enter = |vectors: &[Vector]| -> Result<Orders> {
                    if vectors.len() >= p {
                        return Err(FitError::Request(format!(
                            "{} end derivatives are too many for degree {p}: at most {} can be given",
                            vectors.len(),
                            p - 1
                        )));
                    }
                    if vectors.iter().any(|v| !v.iter().all(|c| c.is_finite())) {
                        return Err(FitError::Request("an end derivative is not finite".into()));
                    }
                    Ok((1..).zip(vectors.iter().map(|&v| frame.enter_vector(v))).collect())
                };
                (enter(start)?, enter(end)?)
            }
        };
        let complete = p % 2 == 1 && start.len() == (p - 1) / 2 && end.len() == (p - 1) / 2;
        let space = match &self.ends {
            Ends::NotAKnot => knots::not_a_knot(p, sites)?,
            Ends::Natural => knots::at_sites(p, sites)?,
            Ends::Derivatives { .. } if complete => knots::at_sites(p, sites)?,
            _ => {
                // An end with derivatives counts once more for each of them.
                let (first, last) = (sites.first().copied(), sites.last().copied());
                let repeat = |u: Option<f64>, times: usize| std::iter::repeat_n(u.unwrap_or(0.0), times);
                let all: Vec<f64> = repeat(first, start.len())
                    .chain(sites.iter().copied())
                    .chain(repeat(last, end.len()))
                    .collect();
                knots::averaged(p, &all)?
            }
        };
        let mut matrix = Stencils::new(&space, space.len());
        let mut rhs = Vec::with_capacity(3 * space.len());
        let condition =
            |matrix: &mut Stencils, rhs: &mut Vec<f64>, u: f64, order: usize, value: Vector| -> Result<()> {
                matrix.collocate(&space, &[u], order)?;
                // Derivatives are larger than values by the knots' distance to a power: rows of one length keep the
                // equations comparable.
                let factor = matrix.normalize(matrix.len() - 1);
                rhs.extend(<[f64; 3]>::from(value * factor));
                Ok(())
            };
        let (a, b) = space.domain();
        for &(order, value) in &start {
            condition(&mut matrix, &mut rhs, a, order, value)?;
        }
        matrix.collocate(&space, sites, 0)?;
        rhs.extend(flat(local));
        for &(order, value) in &end {
            condition(&mut matrix, &mut rhs, b, order, value)?;
        }
        Ok((space, matrix, rhs))
    }
}

/// So many points are no closed curve of any degree.
pub(crate) fn unclosed(found: usize, degree: usize) -> FitError {
    FitError::TooFewPoints { found, needed: 3, degree, possible: 0 }
}

pub(crate) fn flat(points: &[Vector]) -> Vec<f64> {
    points.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
}
