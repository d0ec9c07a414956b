//! Curves: fine tuning being said, and what comes of it.

use std::fmt;
use std::sync::Arc;

use loftsman_kernel::edit::{Constraint, Report};
use loftsman_kernel::solve::{Automatic, Solver};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Vector};

use crate::alpha::{check_degree, clamped, derivative, extremes, polynomial, restricted};
use crate::ends::matched;
use crate::error::{FineTuneError, Result};
use crate::exact::{Asked, solve};
use crate::flat::level;
use crate::lift::Alpha;
use crate::local::{Host, part};
use crate::measure::{EXACT, Inexact, inexact};
use crate::operator::Tuning;
use crate::positive::check_positive;

/// The gap of a closed curve that was tuned with its end let go, as a part of its size, up to which it closes: rounding.
pub(crate) const CLOSES: f64 = 1e-12;
/// Turns of so many degrees and more are told.
const TOLD_TURN: f64 = 0.01;

/// What the ends of a tuned curve do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Ends {
    /// They stay, a closed curve stays closed, and given points are passed, because α is changed for it, as little as it can be
    /// (in `∫ (Δα)²`): `κ_D = κ/α` holds everywhere, for the α that is reported.
    #[default]
    Exact,
    /// The start stays, the end goes where it goes (paper 5, equation 1). A closed curve that closes all the same stays closed.
    Free,
    /// Both stay: the whole is turned by the least angle, and scaled (paper 5, §2.1): `κ_D = κ / (α · scale)`.
    Position,
    /// The same of the second control points from the ends, the outermost put to where they were.
    Tangent,
    /// The same of the third control points.
    Curvature,
}

/// Says how a curve should be tuned: `D(t) = C(t₀) + ∫ α C'`, so that `D' = α C'` and `κ_D = κ/α` (paper 5).
///
/// ```
/// use loftsman_fine_tuning::{FineTune, alpha_of};
/// use loftsman_kernel::Point;
/// use loftsman_kernel::spline::{Curve, Space};
///
/// let points = (0..9).map(|i| Point::new(f64::from(i), f64::from(i * i % 7), 0.0)).collect();
/// let curve = Curve::new(Space::clamped_uniform(3, 9)?, points)?;
/// // Half the curvature in the middle; the ends stay.
/// let alpha = alpha_of(&curve, vec![1.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 1.0])?;
/// let tuned = FineTune::new(&curve, alpha).solve()?;
/// assert_eq!(tuned.curve().degree(), 5);
/// assert!((tuned.curve().point(6.0)? - curve.point(6.0)?).norm() < 1e-12);
/// let at = 2.5;
/// let scaled = curve.derivative(at, 1)? * tuned.alpha().value(at)?;
/// assert!((tuned.curve().derivative(at, 1)? - scaled).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct FineTune {
    curve: Curve,
    alpha: Function<f64>,
    ends: Ends,
    range: Option<(f64, f64)>,
    continuity: Option<u8>,
    through: Vec<(f64, Point)>,
    constraints: Vec<Constraint>,
    solver: Arc<dyn Solver>,
    any_sign: bool,
    forced: bool,
}

/// A tuned curve.
#[derive(Debug, Clone)]
pub struct Tuned {
    curve: Curve,
    alpha: Function<f64>,
    report: TuneReport,
}

/// What a tuning did.
#[derive(Debug, Clone, Default)]
pub struct TuneReport {
    /// How the equations for α were solved, where there were any.
    pub solved: Option<Report>,
    /// By what the tuned curve was scaled to keep its ends; 1 where it was not.
    pub scale: f64,
    /// `(∫ (Δα)² / ∫ 1)^½`: how far α had to be changed from the one asked for.
    pub change: f64,
    /// The smallest and the largest value of α in the end.
    pub alpha: [f64; 2],
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

impl fmt::Debug for FineTune {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FineTune")
            .field("curve", &self.curve)
            .field("alpha", &self.alpha)
            .finish_non_exhaustive()
    }
}

impl FineTune {
    /// The tuning of a curve by α: a spline function over the curve's domain, or over the range that is tuned.
    pub fn new(curve: &Curve, alpha: Function<f64>) -> Self {
        Self {
            curve: curve.clone(),
            alpha,
            ends: Ends::default(),
            range: None,
            continuity: None,
            through: Vec::new(),
            constraints: Vec::new(),
            solver: Arc::new(Automatic),
            any_sign: false,
            forced: false,
        }
    }

    /// What the ends do.
    #[must_use]
    pub fn ends(mut self, ends: Ends) -> Self {
        self.ends = ends;
        self
    }

    /// Tunes the part from `a` to `b` and nothing else: knots are inserted there to full multiplicity, the rest is the same
    /// curve in a higher degree. Of a closed curve `b` may be beyond the end of its period, by `a` and a period at most: the part goes over the seam then,
    /// and α is over `[a, b]`, or periodic.
    #[must_use]
    pub fn between(mut self, a: f64, b: f64) -> Self {
        self.range = Some((a, b));
        self
    }

    /// How many derivatives the tuned part has in common with the rest where they meet, in the exact mode: 0, 1 (`α = 1` there)
    /// or 2 (`α' = 0` too). By default 2 where a range joins the rest, 0 at the ends of the curve.
    #[must_use]
    pub fn continuity(mut self, derivatives: u8) -> Self {
        self.continuity = Some(derivatives.min(2));
        self
    }

    /// A point that the tuned curve passes at a parameter of its whole domain; in the exact mode.
    #[must_use]
    pub fn through(mut self, at: f64, point: Point) -> Self {
        self.through.push((at, point));
        self
    }

    /// Anything else that should hold, in the exact mode: of the tuned curve (shape 0), by any functional, also area and other
    /// nonlinear ones; or of α (shape 1, a [`Scale`](crate::Scale)). What is kept, scaled or changed by is the given curve's. Of a
    /// curve of which only a range is tuned it is asked of the whole curve, what is outside of the range standing still.
    #[must_use]
    pub fn ask(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Lets α be what it is where it is not positive: tangents turn round there.
    #[must_use]
    pub fn any_sign(mut self) -> Self {
        self.any_sign = true;
        self
    }

    /// Takes the answer also where what is asked nearly contradicts itself, so that α changes by far more than each alone would take.
    #[must_use]
    pub fn force(mut self) -> Self {
        self.forced = true;
        self
    }

    /// The same with a solver of one's own for these equations.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    pub fn solve_with(mut self, solver: impl Solver + 'static) -> Result<Tuned> {
        self.solver = Arc::new(solver);
        self.solve()
    }

    /// The tuned curve. `O(n)` but for what is asked beyond the ends.
    ///
    /// # Errors
    /// When the curve is rational or torn, the degree would be above 25, α is not positive (and need be), is over another domain,
    /// the range is none, the ends cannot be kept that way, or what is asked contradicts itself, α or itself not having enough
    /// freedom.
    pub fn solve(&self) -> Result<Tuned> {
        if !self.any_sign {
            check_positive(&Alpha::Line(self.alpha.clone()))?;
        }
        if self.ends != Ends::Exact && !(self.through.is_empty() && self.constraints.is_empty()) {
            return Err(FineTuneError::Contradiction(
                "points to pass through and other constraints are met by changing α: that is ends = \"exact\"; with the paper's own \
                 ends α stays as it is"
                    .into(),
            ));
        }
        if self.ends != Ends::Exact && self.continuity.is_some() {
            return Err(FineTuneError::Contradiction(
                "derivatives stay at the ends because α is 1 there, which is ends = \"exact\"; \"tangent\" and \"curvature\" keep them \
                 by their control points"
                    .into(),
            ));
        }
        let Some((a, b)) = self.range else {
            if self.curve.is_periodic() && self.continuity.is_some() {
                return Err(FineTuneError::Contradiction(
                    "a closed curve has no ends at which derivatives could stay: continuity is for a range of it".into(),
                ));
            }
            return self.whole(&self.curve, &self.alpha, [self.continuity.unwrap_or(0); 2]);
        };
        if self.ends == Ends::Free {
            return Err(FineTuneError::Contradiction(
                "a part with free ends would be torn off the rest: keep them (\"exact\", \"position\", \"tangent\", \"curvature\")"
                    .into(),
            ));
        }
        let (start, end) = self.curve.domain();
        let periodic = self.curve.is_periodic();
        // Over the seam of a closed curve, too: once round at most.
        let last = if periodic && a < end { a + (end - start) } else { end };
        if !(a < b && start <= a && b <= last) {
            return Err(FineTuneError::Range { from: a, to: b, start, end, periodic });
        }
        let alpha = if self.alpha.space().domain() == (a, b) {
            self.alpha.clone()
        } else {
            restricted(&self.alpha, a, b)?
        };
        let given = part(&self.curve, a, b)?;
        let joins = [periodic || a > start, periodic || b < end];
        let continuity = joins.map(|joins| self.continuity.unwrap_or(if joins { 2 } else { 0 }));
        let mut tuned = self.whole(&given, &alpha, continuity)?;
        tuned.report.notes.extend(corners(&given, &tuned.curve)?);
        let host = Host::new(&self.curve, tuned.curve.space())?;
        Ok(Tuned { curve: host.with(tuned.curve.points())?, ..tuned })
    }

    /// In the fewest knots; in pieces, where products of high degree would lose digits in those: the same curve, whose knots are repeated as often as can be.
    fn whole(&self, given: &Curve, alpha: &Function<f64>, continuity: [u8; 2]) -> Result<Tuned> {
        let given = &*level(polynomial(given)?)?;
        let tuned = self.knotted(given, alpha, continuity);
        if given.degree().saturating_sub(1) + alpha.space().degree() <= EXACT
            || !matches!(self.ends, Ends::Exact | Ends::Free)
        {
            return tuned;
        }
        let lost = match &tuned {
            Ok(tuned) => self.lost(tuned, given)?,
            Err(_) => None,
        };
        if tuned.is_ok() && lost.is_none() {
            return tuned;
        }
        let mut pieces = match (self.knotted(&in_pieces(given)?, alpha, continuity), &lost) {
            (Ok(pieces), _) => pieces,
            // An end that does not stay is no answer.
            (Err(error), Some((_, true))) => return Err(error),
            (Err(_), Some((lost, false))) => {
                let mut tuned = tuned?;
                tuned.report.notes.push(lost.told());
                return Ok(tuned);
            }
            (Err(_), None) => return tuned,
        };
        if let Some((left, _)) = self.lost(&pieces, given)? {
            pieces.report.notes.push(left.told());
        }
        if let Some((lost, _)) = lost {
            pieces.report.notes.push(lost.avoided(pieces.curve.degree()));
        }
        Ok(pieces)
    }

    /// What products of high degree have lost, measured on the tuned curve: of its derivative, or of an end that was to stay, and whether it is that.
    fn lost(&self, tuned: &Tuned, given: &Curve) -> Result<Option<(Inexact, bool)>> {
        if self.ends == Ends::Exact {
            let end = given.domain().1;
            let size = given.points().iter().fold(0.0_f64, |m, p| m.max((p - given.points()[0]).norm()));
            let off = (tuned.curve.point(end)? - given.point(end)?).norm();
            let degree = given.degree() - 1 + tuned.alpha.space().degree();
            if let Some(lost) = Inexact::beyond(off / size, end, degree) {
                return Ok(Some((lost, true)));
            }
        }
        Ok(inexact(&tuned.curve, &derivative(given)?, &tuned.alpha)?.map(|lost| (lost, false)))
    }

    fn knotted(&self, given: &Curve, alpha: &Function<f64>, continuity: [u8; 2]) -> Result<Tuned> {
        let derivative = derivative(given)?;
        let exact = self.ends == Ends::Exact && !given.is_periodic();
        let alpha = &if exact { clamped(alpha)? } else { alpha.clone() };
        check_degree(derivative.space(), alpha.space())?;
        let start = given.point(given.domain().0)?;
        let free = || -> Result<Curve> { Ok(derivative.times(alpha)?.integral(start.coords)?.into_curve()?) };
        let mut report = TuneReport { scale: 1.0, ..TuneReport::default() };
        let (curve, tuned_alpha) = match self.ends {
            Ends::Exact => {
                let tuning = Arc::new(Tuning::new(&derivative, alpha.space())?);
                // What is asked beside a range is asked of all of the curve.
                let asks = !(self.through.is_empty() && self.constraints.is_empty());
                let host = (self.range.is_some() && asks).then(|| Host::new(&self.curve, tuning.space()));
                let asked = Asked {
                    given,
                    host: host.transpose()?,
                    continuity,
                    through: &self.through,
                    constraints: &self.constraints,
                    solver: Arc::clone(&self.solver),
                    any_sign: self.any_sign,
                    forced: self.forced,
                };
                let found = solve(tuning, alpha, &asked)?;
                (report.solved, report.change) = (Some(found.report), found.change);
                report.alpha = found.values;
                (closed(found.curve, given, &derivative, &found.alpha)?, found.alpha)
            }
            Ends::Free => {
                let open = free()?;
                let (a, b) = open.domain();
                let size = open.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
                let closes = (open.point(b)? - open.point(a)?).norm() <= CLOSES * size;
                (if closes { closed(open, given, &derivative, alpha)? } else { open }, alpha.clone())
            }
            Ends::Position | Ends::Tangent | Ends::Curvature => {
                let fixed = match self.ends {
                    Ends::Position => 1,
                    Ends::Tangent => 2,
                    _ => 3,
                };
                // The given curve in the tuned one's space: the same integral with α = 1.
                let one = Function::constant(alpha.space().clone(), 1.0)?;
                let same = derivative.times(&one)?.integral(start.coords)?.into_curve()?;
                let (curve, scale, turn) = matched(&free()?, &same, fixed)?;
                report.scale = scale;
                if turn.to_degrees() >= TOLD_TURN {
                    report
                        .notes
                        .push(format!("turned by {}°, so that its ends stay", figure(turn.to_degrees())));
                }
                (curve, alpha.clone())
            }
        };
        if self.ends != Ends::Exact {
            report.alpha = extremes(&tuned_alpha)?;
        }
        // Polygons have no curvature.
        if curve.is_periodic() && given.degree() > 1 {
            report.notes.extend(seam(&tuned_alpha)?);
        }
        Ok(Tuned { curve, alpha: tuned_alpha, report })
    }
}

/// The part of α by which its ends may differ.
pub(crate) const SEAM: f64 = 1e-9;

/// What there is to say of a closed curve whose α ends with another value than it starts with.
fn seam(alpha: &Function<f64>) -> Result<Option<String>> {
    let (a, b) = alpha.space().domain();
    let [first, last] = [alpha.value(a)?, alpha.value(b)?];
    if alpha.space().is_periodic() || (first - last).abs() <= SEAM * first.abs().max(last.abs()) {
        return Ok(None);
    }
    Ok(Some(format!(
        "alpha is {} where the closed curve starts and {} where it ends: its curvature jumps there, from the end to the start by the factor {}; an alpha that is periodic itself \
         (as numbers and lists of values are) leaves it as it was",
        figure(first),
        figure(last),
        figure(last / first)
    )))
}

/// The same curve in Bézier pieces; a closed one stays closed.
fn in_pieces(curve: &Curve) -> Result<Curve> {
    let (space, degree) = (curve.space(), curve.degree());
    if !space.is_periodic() {
        return Ok(curve.bezier_form()?);
    }
    // Around a period both ends are one knot.
    let once = space.breakpoints().into_iter().filter(|t| *t < space.domain().1);
    let lacking = |t: f64| std::iter::repeat_n(t, degree.saturating_sub(space.multiplicity(t)));
    Ok(curve.insert_knots(&once.flat_map(lacking).collect::<Vec<_>>())?)
}

/// What there is to say of corners where a tuned part meets the rest, which is as the given part is.
fn corners(given: &Curve, tuned: &Curve) -> Result<Vec<String>> {
    let (a, b) = given.domain();
    let mut notes = Vec::new();
    for at in [a, b] {
        let (before, after) = (given.derivative(at, 1)?, tuned.derivative(at, 1)?);
        let angle = before.cross(&after).norm().atan2(before.dot(&after)).to_degrees();
        if angle > 1e-6 {
            notes.push(format!(
                "a corner of {angle:.3}° where the part meets the rest, at {at}: ends = \"tangent\" or \"exact\" leave none"
            ));
        }
    }
    Ok(notes)
}

/// The tuned curve of a periodic one is made periodic again: in the space of the integral where that has no corners in its
/// derivative, else by its seam alone.
fn closed(
    curve: Curve,
    given: &Curve,
    derivative: &Function<Vector>,
    alpha: &Function<f64>,
) -> Result<Curve> {
    if !given.is_periodic() {
        return Ok(curve);
    }
    let integrand = derivative.times(alpha)?;
    if integrand.space().is_periodic() && integrand.space().degree() > 0 {
        let start = given.point(given.domain().0)?;
        return Ok(integrand.closed_integral(start.coords)?.into_curve()?);
    }
    let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    Ok(curve.to_periodic(CLOSES * size)?.shape)
}

impl Tuned {
    /// The tuned curve: degree `p + q + 1` for α of degree `q`, so `2p - 1` with the [usual α](crate::alpha_space).
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// α as it is in the end; of a range, on the range.
    pub fn alpha(&self) -> &Function<f64> {
        &self.alpha
    }

    /// What was done.
    pub fn report(&self) -> &TuneReport {
        &self.report
    }

    /// The tuned curve itself.
    pub fn into_curve(self) -> Curve {
        self.curve
    }
}
