//! Ends, points and whatever else is asked, as equations for the values of α.

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis, Constraint, Edit, EditError, Report, Unknowns, Value, Wanted};
use loftsman_kernel::functional::{Linearity, Position, Shapes, derivative, position, value_of};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::{Operator, SolveError, Solver, Symmetric};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::text::short;

use crate::alpha::{MOST, extremes};
use crate::closed::{OfClosed, Opened};
use crate::curvature::bend;
use crate::error::{FineTuneError, Result};
use crate::flat::{axes, extent};
use crate::idle::take_out;
use crate::lift::{Alpha, Place};
use crate::local::{Host, within};
use crate::measure::{gram, mean, undone};
use crate::operator::{Hosted, Tuning};
use crate::positive::{Above, Bound, POSITIVE, bound, bounded, reaches_zero, told};
use crate::scale::Scale;

/// What α has to make true.
pub(crate) struct Asked<'a> {
    /// The given curve, or the part of it that is tuned.
    pub(crate) given: &'a Curve,
    /// All of the given curve, where that is a part of it, and something is asked of it.
    pub(crate) host: Option<Host>,
    /// How many derivatives the tuned curve has in common with the given one at its start and at its end.
    pub(crate) continuity: [u8; 2],
    pub(crate) through: &'a [(f64, Point)],
    pub(crate) constraints: &'a [Constraint],
    pub(crate) solver: Arc<dyn Solver>,
    /// Whether α need not be positive.
    pub(crate) any_sign: bool,
    /// Whether the answer is taken where what is asked nearly contradicts itself.
    pub(crate) forced: bool,
}

/// A curve, its α, and how it was solved for.
type Answer = (Curve, Function<f64>, Report);

/// What was found.
pub(crate) struct Found {
    pub(crate) curve: Curve,
    pub(crate) alpha: Function<f64>,
    pub(crate) report: Report,
    /// `(mean (Δα)²)^½`.
    pub(crate) change: f64,
    /// The smallest and the largest value of α.
    pub(crate) values: [f64; 2],
}

/// The curve that `α` of a space that the map is from gives, with α nearest to the one asked for that makes true what is asked.
pub(crate) fn solve(tuning: Arc<Tuning>, alpha: &Function<f64>, asked: &Asked<'_>) -> Result<Found> {
    let asked_for = extremes(alpha)?;
    if !asked_for.iter().all(|value| value.abs() <= MOST) {
        let size = asked_for[0].abs().max(asked_for[1]);
        return Err(FineTuneError::TooLarge { value: size });
    }
    let mut problem = Problem::new(tuning, alpha, asked)?;
    let is_linear = |c: &Constraint| c.functional().linearity() == Linearity::Linear;
    if !problem.conditions.iter().all(is_linear) {
        // The point of α's space nearest to the one asked for that meets what is linear, first: distances from there to all others that do
        // are those from the α asked for, less a constant (Pythagoras), so that the answer is the same, and what is asked of a closed
        // curve is asked of a closed one.
        let all = problem.conditions.clone();
        problem.conditions.retain(is_linear);
        let (_, near, _) = problem.solve(&[]).map_err(|error| problem.too_few(error))?;
        problem = Problem { conditions: all, ..Problem::new(problem.tuning, &near, asked)? };
    }
    let mut done = problem.solve(&[]).map_err(|error| problem.too_few(error))?;
    let last = extremes(&done.1)?;
    if asked.through.is_empty() && asked.constraints.is_empty() && is_one(last) && !is_one(extremes(alpha)?) {
        return Err(problem.no_freedom(done.2.rank));
    }
    let mut values = last;
    if !asked.any_sign && reaches_zero(last) {
        let bound = bound(extremes(alpha)?[0], last);
        done = problem.bounded(&done.1, bound).map_err(|error| match error {
            FineTuneError::Edit(EditError::Solve(SolveError::Conflict { .. })) => {
                FineTuneError::NoPositive { least: last[0], most: last[1], bound: bound.at_least }
            }
            other => other,
        })?;
        values = extremes(&done.1)?;
        if reaches_zero(values) {
            return Err(FineTuneError::NoPositive { least: last[0], most: last[1], bound: bound.at_least });
        }
    }
    let (curve, found, mut report) = done;
    report.notes.extend(problem.notes.iter().cloned());
    let apart = |a: &[f64], b: &[f64]| mean(&problem.gram, a, b, alpha.space().length());
    let change = apart(alpha.coefficients(), found.coefficients());
    // From 1 to what was asked, and from there back to what came.
    let wanted = apart(&vec![1.0; alpha.coefficients().len()], alpha.coefficients());
    let held = asked.constraints.iter().any(|c| matches!(c.functional().location(), Some((1, _))));
    report.notes.extend(undone(change, wanted, held, values));
    Ok(Found { curve, alpha: found, report, change, values })
}

/// Whether nothing is scaled.
fn is_one([least, most]: [f64; 2]) -> bool {
    (least - 1.0).abs() <= 1e-9 && (most - 1.0).abs() <= 1e-9
}

/// `start + ∫ α C'`.
fn tuned_curve(tuning: &Tuning, alpha: &[f64], start: Point) -> Result<Curve> {
    let vertices = tuning.vertices(alpha).into_iter().map(|v| start + v).collect();
    Ok(Curve::new(tuning.space().clone(), vertices)?)
}

impl Asked<'_> {
    /// The number of the shape that is tuned. What others ask is asked of shape 0, α is shape 1; a part of a curve follows them.
    fn part(&self) -> usize {
        if self.host.is_some() { 2 } else { 0 }
    }

    /// The curve that others ask things of, as it was given.
    fn asked_curve(&self) -> &Curve {
        self.host.as_ref().map_or(self.given, Host::curve)
    }

    /// The equations for the ends and the points, and what else is asked with its targets as the given curve has them.
    fn conditions(&self, tuning: &Tuning, alpha: &Space) -> Result<Vec<Constraint>> {
        let (a, b) = self.given.domain();
        let end = if self.given.is_periodic() { a } else { b };
        let name = if self.given.is_periodic() { "closing".to_owned() } else { format!("the end at {b}") };
        self.check_points()?;
        let mut all = vec![position(b).on(self.part()).to(self.given.point(end)?).called(&name)];
        let through = self.through.iter().enumerate();
        all.extend(through.map(|(k, (at, to))| position(*at).to(*to).called(&format!("through[{k}]"))));
        if !self.given.is_periodic() {
            for (end, continuity) in [a, b].into_iter().zip(self.continuity) {
                let of = |order: &str| format!("the {order} derivative at {end} (continuity)");
                if continuity > 0 {
                    all.push(position(end).on(1).axis(Axis::X).to(1.0).called(&of("first")));
                }
                if continuity > 1 {
                    all.push(derivative(end, 1).on(1).axis(Axis::X).to(0.0).called(&of("second")));
                }
            }
        }
        let numbers = self.numbers(tuning, alpha)?;
        for constraint in self.constraints {
            if let Some(numbers) = numbers.as_ref().filter(|_| constraint.functional().by_number(0)) {
                all.push(self.as_given(&numbers.asked(constraint)?, &numbers.given)?);
                continue;
            }
            let mut held = self.held_beside(constraint);
            let part = self.host.as_ref().map(|_| self.given.domain());
            if let Some(bend) = bend(constraint, self.asked_curve(), alpha, part, self.any_sign)? {
                all.extend(bend.conditions);
                held = held.filter(|_| bend.is_inside);
            } else {
                all.push(self.as_given(&Self::alone(constraint), self.asked_curve())?);
            }
            if let Some(held) = held.filter(|held| !all.iter().any(|c| c.functional().same_as(held))) {
                all.push(self.as_given(&held.keep(), self.asked_curve())?);
            }
        }
        Ok(all)
    }

    /// Points that no α brings the curve to: at a place that stays, or off the plane or line that all of its tangents keep it in.
    fn check_points(&self) -> Result<()> {
        let curve = self.asked_curve();
        let (a, b) = self.given.domain();
        let (start, _) = curve.domain();
        let size = curve.points().iter().map(|p| (p - curve.points()[0]).norm()).fold(0.0, f64::max);
        for (k, (at, to)) in self.through.iter().enumerate() {
            let Ok(u) = curve.space().locate(*at) else { continue };
            let there = curve.point(u)?;
            let refused =
                |why: String| Err(FineTuneError::Contradiction(format!("through[{k}], at {at}: {why}")));
            let far = (to - there).norm() > REACH * size;
            let outside = self.host.is_some() && within(curve.space(), (a, b), u).is_none();
            if far && outside {
                return refused(format!(
                    "the curve stays where it is there, for only what is between {a} and {b} is tuned: give a place inside of the range, or tune a \
                     longer one"
                ));
            }
            if far && u == start && self.host.is_none() {
                let what = if curve.is_periodic() {
                    "where the curve starts and ends stays"
                } else {
                    "the start stays"
                };
                return refused(format!("{what} where it is: give another place, or move the curve first"));
            }
            let (dimensions, off) = off_span(self.given, to);
            if off > REACH * size {
                let what = if dimensions < 2 {
                    "a straight curve stays on its line"
                } else {
                    "a plane curve stays in its plane"
                };
                return refused(format!(
                    "the point is {} off: tangents keep their directions, so that {what}; give a point of that, or bend the curve first (edit)",
                    short(off)
                ));
            }
        }
        Ok(())
    }

    /// The position that stands still beside what is asked at a place (curvature), unless it is asked for itself. The derivative, that would too in an
    /// edit, is what α scales.
    fn held_beside(&self, constraint: &Constraint) -> Option<Position> {
        let Some((shape, Location::Curve(at))) = constraint.functional().location() else { return None };
        let held = position(at).on(shape);
        let companions = constraint.functional().companions();
        let asked = |c: &Constraint| c.functional().same_as(&held);
        (companions.iter().any(|c| c.same_as(&held)) && !self.constraints.iter().any(asked)).then_some(held)
    }

    /// What is asked at a place without what an edit would hold there: as it is where the derivatives may change.
    fn alone(constraint: &Constraint) -> Constraint {
        let functional = constraint.functional();
        if functional.location().is_none() {
            return constraint.clone();
        }
        let alone = functional.beside(&|_| false).unwrap_or_else(|| Arc::clone(functional));
        let same = constraint.clone().of(alone);
        same.called(&constraint.describe()).by_itself()
    }

    /// What is asked by the numbers of control vertices means those of the tuned curve, where anything is. `None` where those are the asked curve's
    /// own.
    fn numbers(&self, tuning: &Tuning, alpha: &Space) -> Result<Option<Numbers>> {
        if self.host.is_some() || !self.constraints.iter().any(|c| c.functional().by_number(0)) {
            return Ok(None);
        }
        let start = self.given.point(self.given.domain().0)?;
        let opened = tuning.closed().map(|closed| Opened::new(closed, tuning.space())).transpose()?;
        Ok(Some(Numbers {
            given: tuned_curve(tuning, &vec![1.0; alpha.len()], start)?,
            is_closed: self.given.is_periodic(),
            opened: opened.map(Arc::new),
        }))
    }

    /// A constraint whose target is a value that the given curve has, changes or multiplies, with that number.
    fn as_given(&self, constraint: &Constraint, given: &Curve) -> Result<Constraint> {
        let functional = constraint.functional();
        let present = || -> Result<Vec<f64>> {
            let mut values = vec![0.0; functional.equations()];
            let one = Scale::new(&Function::constant(self.given.space().clone(), 1.0)?);
            let shapes: [&dyn Shape; 2] = [given, &one];
            value_of(functional.as_ref(), &Shapes::new(shapes), &mut values)?;
            if let Some(axis) = constraint.narrowed() {
                values = values.get(axis as usize).copied().into_iter().collect();
            }
            Ok(values)
        };
        let to = match constraint.wanted() {
            Wanted::Keep => present()?,
            Wanted::Scale(factor) => present()?.into_iter().map(|v| v * factor).collect(),
            Wanted::By(Value(by)) => {
                let each = |(k, v): (usize, f64)| v + by.get(k).or(by.first()).copied().unwrap_or(0.0);
                present()?.into_iter().enumerate().map(each).collect()
            }
            _ => return Ok(constraint.clone()),
        };
        Ok(constraint.clone().wanting(Wanted::To(Value(to))).called(&constraint.describe()))
    }
}

/// The control vertices of the tuned curve.
struct Numbers {
    /// The given curve in the tuned one's degree and knots.
    given: Curve,
    is_closed: bool,
    /// Those of a closed curve.
    opened: Option<Arc<Opened>>,
}

impl Numbers {
    /// What is asked of them, asked of the curve that is solved for.
    fn asked(&self, constraint: &Constraint) -> Result<Constraint> {
        if !self.is_closed {
            return Ok(constraint.clone());
        }
        let Some(opened) = &self.opened else {
            return Err(FineTuneError::Contradiction(format!(
                "{}: how many control vertices a closed curve has that is tuned with a corner, or by an α that is not periodic, is known only when it is \
                 tuned; ask for a position on it",
                constraint.describe()
            )));
        };
        let functional = OfClosed::new(constraint.functional(), opened);
        Ok(constraint.clone().of(Arc::new(functional)).called(&constraint.describe()))
    }
}

struct Problem<'a> {
    tuned: Curve,
    scale: Scale,
    /// `∫ α²` of the values of α.
    gram: Symmetric,
    tuning: Arc<Tuning>,
    asked: &'a Asked<'a>,
    conditions: Vec<Constraint>,
    /// What there is to say of what was asked and holds by itself.
    notes: Vec<String>,
}

impl<'a> Problem<'a> {
    /// From α's values as they are to start with.
    fn new(tuning: Arc<Tuning>, alpha: &Function<f64>, asked: &'a Asked<'a>) -> Result<Self> {
        let start = asked.given.point(asked.given.domain().0)?;
        let scale = Scale::new(alpha);
        let tuned = tuned_curve(&tuning, alpha.coefficients(), start)?;
        let mut conditions = asked.conditions(&tuning, alpha.space())?;
        let notes = match &asked.host {
            None => take_out(&mut conditions, &Shapes::new([&tuned as &dyn Shape, &scale]), tuning.as_ref())?,
            Some(host) => {
                let (whole, map) = (host.with(tuned.points())?, Hosted::new(Arc::clone(&tuning), host));
                take_out(&mut conditions, &Shapes::new([&whole as &dyn Shape, &scale, &tuned]), &map)?
            }
        };
        Ok(Self { gram: gram(alpha.space()), scale, tuned, conditions, tuning, asked, notes })
    }

    /// The same with α at least `bound` everywhere, where it is not so in the first answer.
    fn bounded(&self, first: &Function<f64>, bound: Bound) -> Result<Answer> {
        let first = Alpha::Line(first.clone());
        let solve = |held: &[Place]| -> Result<Answer> {
            let bounds = held.iter().map(|place| -> Result<Constraint> {
                Ok(Above { terms: first.row(*place)?, accuracy: bound.near }
                    .at_least(bound.at_least)
                    .called(POSITIVE))
            });
            Ok(self.solve(&bounds.collect::<Result<Vec<_>>>()?)?)
        };
        let values = |(_, alpha, _): &Answer| alpha.coefficients().to_vec();
        let (curve, alpha, mut report) = bounded(&first, bound, solve, values)?;
        // Nobody asked for these: told together.
        report.constraints.truncate(self.conditions.len());
        report.active.retain(|name| self.conditions.iter().any(|c| c.label() == *name));
        report.active.push(format!("alpha ≥ {}", bound.at_least));
        report.notes.push(told(&Alpha::Line(alpha.clone()), bound, "ends")?);
        Ok((curve, alpha, report))
    }

    /// The least change of α, `∫ (Δα)²`, that makes the conditions true, and these bounds.
    fn solve(&self, bounds: &[Constraint]) -> Result<Answer, EditError> {
        let count = self.tuned.points().len() + self.scale.control_vertices().len();
        let tuning = Arc::clone(&self.tuning);
        let (edit, count, map): (_, _, Arc<dyn Operator>) = match &self.asked.host {
            None => (Edit::new(&self.tuned).with(self.scale.boxed()), count, tuning),
            Some(host) => {
                let whole = host.with(self.tuned.points())?;
                let edit = Edit::new(&whole).with(self.scale.boxed()).with(self.tuned.boxed());
                let all = count + whole.points().len();
                (edit.named(2, "the part"), all, Arc::new(Hosted::new(tuning, host)))
            }
        };
        let unknowns = Unknowns::operator((0..count).collect(), map)?.measured(Some(self.gram.clone()))?;
        let mut edit = edit.named(1, "α").through(unknowns).smooth(0);
        if self.asked.forced {
            edit = edit.force();
        }
        for condition in &self.conditions {
            edit = edit.ask(condition.clone());
        }
        for bound in bounds {
            edit = edit.ask(bound.clone());
        }
        let done = edit.solve_with(Arc::clone(&self.asked.solver))?;
        let alpha: Vec<f64> = done.shape_at(1)?.control_vertices().iter().map(|p| p.x).collect();
        let alpha = Function::new(self.scale.function()?.into_parts().0, alpha)?;
        let part = match &self.asked.host {
            None => done.shape().clone(),
            Some(_) => Curve::new(self.tuned.space().clone(), done.shape_at(2)?.control_vertices().to_vec())?,
        };
        Ok((part, alpha, done.report().clone()))
    }

    /// Ends that leave α no choice: α = 1 meets them, and no other does or none that is nearer to what is asked, so that nothing would be tuned.
    fn no_freedom(&self, rank: usize) -> FineTuneError {
        let values = self.scale.control_vertices().len();
        let equations = self.equations().max(rank);
        if values > equations {
            return FineTuneError::Nothing { asked: self.what() };
        }
        FineTuneError::TooFewValues { asked: self.what(), equations, needed: equations + 1, values }
    }

    /// What an error comes from, where α has fewer values than there are equations.
    fn too_few(&self, error: EditError) -> FineTuneError {
        let (values, equations) = (self.scale.control_vertices().len(), self.equations());
        if equations <= values || !matches!(error, EditError::Solve(_)) {
            return error.into();
        }
        // 1 is what as many values as equations have where nothing but the ends is asked for.
        let is_plain = self.asked.through.is_empty() && self.asked.constraints.is_empty();
        let needed = equations + usize::from(is_plain);
        FineTuneError::TooFewValues { asked: self.what(), equations, needed, values }
    }

    /// How many equations there are as a rule.
    fn equations(&self) -> usize {
        let slopes = if self.asked.given.is_periodic() {
            0
        } else {
            self.asked.continuity.into_iter().map(usize::from).sum()
        };
        dimensions(self.asked.given) * (1 + self.asked.through.len()) + slopes + self.values_held()
    }

    /// How many values of α are asked for.
    fn values_held(&self) -> usize {
        let held = |c: &&Constraint| matches!(c.functional().location(), Some((1, _)));
        self.asked.constraints.iter().filter(held).count()
    }

    /// What is asked of the ends and between them, for people.
    fn what(&self) -> String {
        let closed = self.asked.given.is_periodic();
        let mut asked = vec![if closed { "a loop that closes" } else { "ends that stay" }.to_owned()];
        match self.asked.through.len() {
            0 => {}
            1 => asked.push("a point to pass through".into()),
            more => asked.push(format!("{more} points to pass through")),
        }
        match self.values_held() {
            0 => {}
            1 => asked.push("a value of α".into()),
            more => asked.push(format!("{more} values of α")),
        }
        let order = |level: u8| ["", "first derivatives", "first and second derivatives"][usize::from(level)];
        match self.asked.continuity {
            _ if closed => {}
            [0, 0] => {}
            [first, last] if first == last => asked.push(format!("{} that stay at both ends", order(first))),
            [first, 0] => asked.push(format!("{} that stay at the start", order(first))),
            [0, last] => asked.push(format!("{} that stay at the end", order(last))),
            [first, last] => {
                asked.push(format!("{} that stay at the start", order(first)));
                asked.push(format!("{} that stay at the end", order(last)));
            }
        }
        asked.join(", ")
    }
}

/// The part of a curve's size up to which what is off a line or a plane is in it.
const REACH: f64 = 1e-9;

/// Of how many dimensions a curve is: 1 for a straight one, 2 for a plane one, else 3.
fn dimensions(curve: &Curve) -> usize {
    axes(curve, REACH * extent(curve)).len()
}

/// The same, and how far a point is from the line or the plane that the curve is in.
fn off_span(curve: &Curve, to: &Point) -> (usize, f64) {
    let axes = axes(curve, REACH * extent(curve));
    let first = curve.points().first().copied().unwrap_or_default();
    (axes.len(), axes.iter().fold(to - first, |rest, axis| rest - axis * axis.dot(&rest)).norm())
}
