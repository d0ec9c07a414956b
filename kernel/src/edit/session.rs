//! An edit under way: prepared once, then one cheap event after another.

use std::any::Any;
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::sync::Arc;

use super::ask::{Constraint, Value, Wanted};
use super::assembly::{Assembly, Freedom};
use super::conflict::{agrees, explain, involved};
use super::error::EditError;
use super::metric::Metric;
use super::problem::Edit;
use super::report::{ConstraintReport, Report};
use crate::Point;
use crate::error::{Error, Result};
use crate::functional::{Functional, Linearity, Shapes, position};
use crate::shape::{Location, Shape};
use crate::solve::{Dependency, Factored, SolveError, Solver};

/// Names a constraint of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConstraintId(u64);

/// Iterations before a nonlinear problem is given up.
const ITERATIONS: usize = 60;
/// A nonlinear constraint is met at this error, relative to the numbers it is made of.
const MET: f64 = 1e-12;

/// A constraint whose functional is bound and whose target is a number.
#[derive(Debug, Clone)]
struct Bound {
    id: ConstraintId,
    constraint: Constraint,
    /// The wanted value: all of the functional's numbers, asked or not.
    target: Vec<f64>,
}

/// What is known for one set of constraints at one state of the shapes.
struct Prepared {
    assembly: Assembly,
    factored: Box<dyn Factored>,
    dependencies: Vec<Dependency>,
    /// Wanted changes, and the sizes of the numbers they come from.
    rhs: Vec<f64>,
    size: Vec<f64>,
    /// The adjustment of the touched columns, and what it is without the handle.
    d: Vec<f64>,
    still: Vec<f64>,
    /// The adjustment that each number of the handle asks for by changing by 1.
    response: Vec<Vec<f64>>,
    /// Where the touched columns' vertices were.
    base: Vec<Point>,
    /// Shape and vertex of each.
    places: Vec<(u32, u32)>,
    iterations: usize,
}

/// An edit under way. Events do not allocate and do not depend on the size of the shapes (as long as everything
/// asked is linear and the handle does not slide).
pub struct Session<S> {
    shapes: Vec<Box<dyn Shape>>,
    bound: Vec<Bound>,
    handle: Option<usize>,
    /// The handle's value when it was prepared.
    handle_start: Vec<f64>,
    sliding: Option<(Box<dyn Shape>, f64)>,
    freedom: Freedom,
    metric: Metric,
    best_effort: bool,
    solver: Box<dyn Solver>,
    prepared: Prepared,
    next_id: u64,
    checkpoints: Vec<Vec<(u32, u32, Point)>>,
    start: Vec<(u32, u32, Point)>,
    kind: PhantomData<fn() -> S>,
}

impl<S> std::fmt::Debug for Session<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session").field("constraints", &self.bound).finish_non_exhaustive()
    }
}

fn view(shapes: &[Box<dyn Shape>]) -> Shapes<'_> {
    Shapes::new(shapes.iter().map(AsRef::as_ref))
}

impl<S: Shape> Session<S> {
    pub(super) fn new(
        edit: Edit<S>,
        solver: Box<dyn Solver>,
        freedom: Freedom,
        metric: Metric,
    ) -> Result<Self, EditError> {
        let Edit { shapes, mut constraints, handle, sliding, best_effort, .. } = edit;
        add_companions(&mut constraints, handle.as_deref());
        let mut bound = Vec::with_capacity(constraints.len() + 1);
        let mut next_id = 0;
        for constraint in constraints {
            bound.push(bind(&view(&shapes), constraint, ConstraintId(next_id))?);
            next_id += 1;
        }
        let mut slide = None;
        let mut handle_start = Vec::new();
        let handle = match handle {
            None => None,
            Some(functional) => {
                if sliding {
                    let Some((shape, Location::Curve(u))) =
                        functional.location().filter(|_| functional.is_vector())
                    else {
                        let what = functional.describe();
                        return Err(Error::Invalid(format!(
                            "\"{what}\" cannot slide: only a position on a curve can"
                        ))
                        .into());
                    };
                    slide = Some((view(&shapes).get(shape)?.boxed(), u));
                }
                let constraint = Constraint::new(functional, Wanted::Keep);
                bound.push(bind(&view(&shapes), constraint, ConstraintId(next_id))?);
                next_id += 1;
                handle_start.clone_from(&bound[bound.len() - 1].target);
                Some(bound.len() - 1)
            }
        };
        let prepared = prepare(&shapes, &bound, handle, &freedom, &metric, solver.as_ref())?;
        let start = snapshot(&shapes, &prepared);
        Ok(Self {
            shapes,
            bound,
            handle,
            handle_start,
            sliding: slide,
            freedom,
            metric,
            best_effort,
            solver,
            prepared,
            next_id,
            checkpoints: Vec::new(),
            start,
            kind: PhantomData,
        })
    }

    /// The shape as it is now.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn shape(&self) -> &S {
        let any: &dyn Any = self.shapes[0].as_ref();
        match any.downcast_ref() {
            Some(shape) => shape,
            None => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// Shape `index` of the problem as it is now; 0 is [`shape`](Self::shape).
    ///
    /// # Errors
    /// When there are not as many.
    pub fn shape_at(&self, index: usize) -> Result<&dyn Shape> {
        view(&self.shapes).get(index)
    }

    /// Solves for what is asked, the handle where it is.
    ///
    /// # Errors
    /// When the constraints cannot all hold; the shapes are as they were then.
    pub fn apply(&mut self) -> Result<&S, EditError> {
        self.event()?;
        Ok(self.shape())
    }

    /// Drags the handle to a value: the least adjustment *of the shape as it was when prepared* that brings it there.
    ///
    /// # Errors
    /// When there is no handle, the value has the wrong number of entries, or the constraints conflict; the shapes are
    /// as they were before the event then.
    pub fn to(&mut self, value: impl Into<Value>) -> Result<&S, EditError> {
        let Value(value) = value.into();
        self.drag_to(&value)
    }

    /// [`to`](Self::to) for a cursor in space, without allocation.
    ///
    /// # Errors
    /// As for [`to`](Self::to).
    pub fn to_point(&mut self, point: Point) -> Result<&S, EditError> {
        self.drag_to(point.coords.as_slice())
    }

    fn drag_to(&mut self, value: &[f64]) -> Result<&S, EditError> {
        let Some(handle) = self.handle else {
            return Err(Error::Invalid(
                "this edit has no handle to drag: give it one before preparing".into(),
            )
            .into());
        };
        if let Some(bad) = value.iter().find(|v| !v.is_finite()) {
            return Err(Error::Invalid(format!(
                "the handle cannot be dragged to {bad}: give finite numbers"
            ))
            .into());
        }
        if self.bound[handle].target.len() != value.len() {
            let (what, needed) = (self.bound[handle].constraint.describe(), self.bound[handle].target.len());
            let found = value.len();
            return Err(Error::Invalid(format!("\"{what}\" has {needed} number(s), not {found}")).into());
        }
        if self.sliding.is_some() {
            self.slide(handle, value)?;
        }
        self.bound[handle].target.copy_from_slice(value);
        self.event()?;
        Ok(self.shape())
    }

    /// Moves the handle's parameter to where the cursor's foot on the original curve is, and prepares there.
    fn slide(&mut self, handle: usize, cursor: &[f64]) -> Result<(), EditError> {
        let Some((original, u)) = &mut self.sliding else { return Ok(()) };
        let cursor = crate::Vector::from_column_slice(&cursor[..3]);
        *u = foot(original.as_ref(), cursor, *u)?;
        let moved = position(*u);
        let shape = self.bound[handle].constraint.functional.location().map_or(0, |(shape, _)| shape);
        self.restore();
        let constraint = Constraint::new(Arc::new(moved.on(shape)), Wanted::Keep);
        let id = self.bound[handle].id;
        self.bound[handle] = bind(&view(&self.shapes), constraint, id)?;
        self.handle_start.clone_from(&self.bound[handle].target);
        self.prepare_again()
    }

    /// One more constraint from now on. What was asked before holds as absolute values; the shape as it is now
    /// becomes the one that later events adjust.
    ///
    /// # Errors
    /// When it cannot be asked of the shapes or the system cannot be factored; the session is as before then.
    pub fn add(&mut self, constraint: Constraint) -> Result<ConstraintId, EditError> {
        let mut fresh = vec![constraint];
        let handle = self.handle.map(|h| Arc::clone(&self.bound[h].constraint.functional));
        add_companions(&mut fresh, handle.as_deref());
        let before = self.bound.clone();
        let id = ConstraintId(self.next_id);
        for constraint in fresh {
            let known = self.bound.iter().any(|b| b.constraint.describe() == constraint.describe());
            if known && constraint.wanted == Wanted::Keep && self.next_id > id.0 {
                continue;
            }
            self.bound.push(bind(&view(&self.shapes), constraint, ConstraintId(self.next_id))?);
            self.next_id += 1;
        }
        if let Err(error) = self.prepare_again() {
            self.bound = before;
            return Err(error);
        }
        Ok(id)
    }

    /// Takes a constraint away.
    ///
    /// # Errors
    /// When there is none of this name, or it is the handle.
    pub fn remove(&mut self, id: ConstraintId) -> Result<(), EditError> {
        let Some(at) = self.bound.iter().position(|b| b.id == id) else {
            return Err(Error::Invalid("this constraint is not (or no longer) in the session".into()).into());
        };
        if self.handle == Some(at) {
            return Err(Error::Invalid(
                "the handle cannot be removed from a session: commit it instead".into(),
            )
            .into());
        }
        let gone = self.bound.remove(at);
        self.handle = self.handle.map(|h| if h > at { h - 1 } else { h });
        if let Err(error) = self.prepare_again() {
            self.bound.insert(at, gone);
            self.handle = self.handle.map(|h| if h >= at { h + 1 } else { h });
            return Err(error);
        }
        Ok(())
    }

    /// Remembers the shape as it is now, for [`undo`](Self::undo).
    pub fn checkpoint(&mut self) {
        self.checkpoints.push(snapshot(&self.shapes, &self.prepared));
    }

    /// Goes back to the last [`checkpoint`](Self::checkpoint), or to the start of the session; false where there is
    /// nothing to undo. What is asked stays asked.
    ///
    /// # Errors
    /// When the constraints can no longer be asked of the shape as it was.
    pub fn undo(&mut self) -> Result<bool, EditError> {
        let (state, any) = match self.checkpoints.pop() {
            Some(state) => (state, true),
            None => (self.start.clone(), false),
        };
        let changed =
            any || state.iter().any(|&(s, v, p)| self.shapes[s as usize].control_vertices()[v as usize] != p);
        put(&mut self.shapes, &state);
        if changed {
            self.prepare_again()?;
        }
        Ok(changed)
    }

    /// Ends the session: the shapes as they are now, with a report and the way back.
    pub fn commit(self) -> Edited<S> {
        let report = self.report();
        Edited { shapes: self.shapes, report, before: self.start, kind: PhantomData }
    }

    /// What solving gave: residuals, rank, condition, multipliers. Not free: not for every event.
    pub fn report(&self) -> Report {
        let shapes = view(&self.shapes);
        let prepared = &self.prepared;
        let diagnosis = prepared.factored.diagnosis();
        let sides = prepared.assembly.system.sides();
        let mut report = Report {
            solver: prepared.factored.solver().to_owned(),
            equations: prepared.assembly.slots.len(),
            rank: diagnosis.rank * sides,
            condition: diagnosis.condition,
            iterations: prepared.iterations,
            ..Report::default()
        };
        let mut lost: BTreeMap<usize, usize> = BTreeMap::new();
        for dependency in &diagnosis.dependencies {
            *lost.entry(prepared.assembly.constraint_of(dependency.row)).or_default() += 1;
        }
        for (k, lost) in lost {
            let rows = prepared.assembly.slots(k).len() / sides;
            let name = self.bound[k].constraint.describe();
            report.redundant.push(if lost < rows { format!("{name} ({lost} of {rows} rows)") } else { name });
        }
        let mut adjustment = 0.0_f64;
        for &(shape, vertex, before) in &self.start {
            let now = self.shapes[shape as usize].control_vertices()[vertex as usize];
            adjustment = adjustment.hypot((now - before).norm());
        }
        report.adjustment = adjustment;
        for (k, bound) in self.bound.iter().enumerate() {
            let mut value = vec![0.0; bound.constraint.functional.equations()];
            let residual = match bound.constraint.functional.value(&shapes, &mut value) {
                Err(_) => f64::NAN,
                Ok(()) => prepared
                    .assembly
                    .slots(k)
                    .iter()
                    .map(|s| (value[s.equation as usize] - bound.target[s.equation as usize]).abs())
                    .fold(0.0, f64::max),
            };
            report.residual = report.residual.max(residual);
            report.constraints.push(ConstraintReport {
                name: bound.constraint.describe(),
                residual,
                multipliers: Vec::new(),
            });
        }
        self.add_multipliers(&mut report);
        report.best_effort = self.best_effort
            && diagnosis
                .dependencies
                .iter()
                .any(|d| !agrees(&prepared.assembly, d, &prepared.rhs, &prepared.size));
        for bound in &self.bound {
            if let Some(note) = reversed(&shapes, bound) {
                report.notes.push(note);
            }
        }
        report
    }

    fn add_multipliers(&self, report: &mut Report) {
        let prepared = &self.prepared;
        let mut multipliers = vec![0.0; prepared.rhs.len()];
        // Solving for them needs the factor's scratch; a report is rare enough to factor once more.
        if let Ok(mut factored) = self.solver.factor(&prepared.assembly.system) {
            factored.multipliers_into(&prepared.rhs, &mut multipliers);
        }
        for (k, constraint) in report.constraints.iter_mut().enumerate() {
            constraint.multipliers =
                prepared.assembly.slots(k).iter().map(|s| multipliers[prepared.assembly.entry(s)]).collect();
        }
    }

    fn is_linear(&self) -> bool {
        self.bound.iter().all(|b| b.constraint.functional.linearity() == Linearity::Linear)
    }

    /// Solves for the present targets and moves the vertices.
    fn event(&mut self) -> Result<(), EditError> {
        if !self.is_linear() {
            return self.iterate();
        }
        let prepared = &mut self.prepared;
        if let Some(handle) = self.handle {
            let target = &self.bound[handle].target;
            for slot in prepared.assembly.slots(handle) {
                let at = prepared.assembly.entry(slot);
                prepared.rhs[at] = target[slot.equation as usize] - self.handle_start[slot.equation as usize];
            }
        }
        let conflict = prepared
            .dependencies
            .iter()
            .position(|d| !agrees(&prepared.assembly, d, &prepared.rhs, &prepared.size));
        if let Some(at) = conflict {
            if !self.best_effort {
                return Err(self.conflict(at).into());
            }
            let softened = soften(&prepared.assembly, &prepared.dependencies, &prepared.rhs);
            prepared.factored.solve_into(&softened, &mut prepared.d);
        } else if self.handle.is_some() {
            // d = C₀b₀ + Σ response · change: only the columns of C whose b is ever non-zero.
            prepared.d.copy_from_slice(&prepared.still);
            let sides = prepared.assembly.system.sides();
            let handle = self.handle.unwrap_or(0);
            for (slot, response) in
                prepared.assembly.slots(handle).iter().zip(response_of(&prepared.response, sides))
            {
                let change = prepared.rhs[prepared.assembly.entry(slot)];
                if sides == 3 {
                    let side = slot.side as usize;
                    for (d, r) in prepared.d.chunks_exact_mut(3).zip(response) {
                        d[side] += change * r;
                    }
                } else {
                    for (d, r) in prepared.d.iter_mut().zip(response) {
                        *d += change * r;
                    }
                }
            }
        } else {
            prepared.factored.solve_into(&prepared.rhs, &mut prepared.d);
        }
        self.place();
        Ok(())
    }

    /// Newton's iteration for the least adjustment under constraints that are not linear: linearized where the shapes
    /// are, with the whole adjustment since the start as unknown, so that it converges to the least one.
    fn iterate(&mut self) -> Result<(), EditError> {
        let state = snapshot(&self.shapes, &self.prepared);
        let result = self.iterate_from_here();
        if result.is_err() {
            put(&mut self.shapes, &state);
        }
        result
    }

    fn iterate_from_here(&mut self) -> Result<(), EditError> {
        self.restore();
        let mut worst = (f64::INFINITY, String::new());
        let mut previous = vec![0.0; self.prepared.d.len()];
        for iteration in 1..=ITERATIONS {
            let shapes = view(&self.shapes);
            let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
            let assembly = Assembly::new(&shapes, &constraints, &self.freedom, &self.metric)?;
            if assembly.system.touched() != self.prepared.assembly.system.touched() {
                return Err(Error::Invalid(
                    "a constraint touches other control vertices than when the edit was prepared; prepare anew".into(),
                )
                .into());
            }
            let (mut rhs, mut size) = (Vec::new(), Vec::new());
            let error = right_hand_side(&shapes, &self.bound, &assembly, &mut rhs, &mut size)?;
            let met = error.iter().all(|(e, s)| *e <= MET * s);
            let step = {
                let change =
                    previous.iter().zip(&self.prepared.d).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let whole = self.prepared.d.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                iteration > 1 && change <= 1e-10 * whole
            };
            if met && (step || iteration > ITERATIONS / 2) {
                self.prepared.iterations = iteration - 1;
                self.prepared.rhs = rhs;
                return Ok(());
            }
            worst = error.iter().zip(&self.bound).fold((0.0, String::new()), |w, ((e, _), b)| {
                if *e > w.0 { (*e, b.constraint.describe()) } else { w }
            });
            // b + F (P - P₀): the unknown is the adjustment from the start, not from here.
            let mut sofar = vec![0.0; rhs.len()];
            if iteration > 1 {
                assembly.system.rows().multiply(&self.prepared.d, assembly.system.sides(), &mut sofar);
            }
            rhs.iter_mut().zip(&sofar).for_each(|(b, s)| *b += s);
            let mut factored = self.solver.factor(&assembly.system)?;
            let dependencies = factored.diagnosis().dependencies;
            self.prepared.assembly = assembly;
            self.prepared.dependencies = dependencies;
            let disagree = self
                .prepared
                .dependencies
                .iter()
                .position(|d| !agrees(&self.prepared.assembly, d, &rhs, &size));
            if let Some(at) = disagree {
                if !self.best_effort {
                    return Err(self.conflict(at).into());
                }
                rhs = soften(&self.prepared.assembly, &self.prepared.dependencies, &rhs);
            }
            previous.copy_from_slice(&self.prepared.d);
            factored.solve_into(&rhs, &mut self.prepared.d);
            self.prepared.factored = factored;
            self.prepared.rhs = rhs;
            self.prepared.size = size;
            self.place();
        }
        let (residual, worst) = worst;
        Err(SolveError::NotConverged { iterations: ITERATIONS, residual, worst }.into())
    }

    fn conflict(&self, at: usize) -> SolveError {
        let constraints: Vec<&Constraint> = self.bound.iter().map(|b| &b.constraint).collect();
        let dependency = &self.prepared.dependencies[at];
        debug_assert!(!involved(&self.prepared.assembly, dependency).is_empty());
        explain(&self.shapes, &constraints, &self.freedom, &self.prepared.assembly, dependency)
    }

    /// Base plus adjustment, into the shapes.
    fn place(&mut self) {
        let Prepared { d, base, places, .. } = &self.prepared;
        let mut from = 0;
        for (index, shape) in self.shapes.iter_mut().enumerate() {
            let until = from + places[from..].partition_point(|&(s, _)| s as usize == index);
            if until == from {
                continue;
            }
            let vertices = shape.control_vertices_mut();
            for ((&(_, vertex), base), d) in
                places[from..until].iter().zip(&base[from..until]).zip(d[3 * from..3 * until].chunks_exact(3))
            {
                vertices[vertex as usize] = Point::new(base.x + d[0], base.y + d[1], base.z + d[2]);
            }
            from = until;
        }
    }

    /// The shapes as they were when prepared.
    fn restore(&mut self) {
        self.prepared.d.fill(0.0);
        self.place();
    }

    fn prepare_again(&mut self) -> Result<(), EditError> {
        if let Some(handle) = self.handle {
            let bound = &mut self.bound[handle];
            bound.constraint.functional.value(&view(&self.shapes), &mut self.handle_start)?;
        }
        let prepared = prepare(
            &self.shapes,
            &self.bound,
            self.handle,
            &self.freedom,
            &self.metric,
            self.solver.as_ref(),
        )?;
        self.prepared = prepared;
        // What is touched for the first time belongs to the way back, too.
        let known: std::collections::BTreeSet<(u32, u32)> =
            self.start.iter().map(|&(s, v, _)| (s, v)).collect();
        let fresh = snapshot(&self.shapes, &self.prepared);
        self.start.extend(fresh.into_iter().filter(|&(s, v, _)| !known.contains(&(s, v))));
        Ok(())
    }
}

/// The responses in the order of the handle's slots: with three sides, all share the one column.
fn response_of(response: &[Vec<f64>], sides: usize) -> impl Iterator<Item = &Vec<f64>> {
    (0..).map_while(move |i| response.get(if sides == 3 { i / 3 } else { i }))
}

/// Functionals that must stand still for others, unless they are asked for themselves.
fn add_companions(constraints: &mut Vec<Constraint>, handle: Option<&dyn Functional>) {
    let mut asked: Vec<String> = constraints.iter().map(|c| c.functional.describe()).collect();
    asked.extend(handle.map(Functional::describe));
    let mut wanted: Vec<Arc<dyn Functional>> =
        constraints.iter().flat_map(|c| c.functional.companions()).collect();
    wanted.extend(handle.into_iter().flat_map(Functional::companions));
    for companion in wanted {
        let name = companion.describe();
        if !asked.contains(&name) {
            asked.push(name);
            constraints.push(Constraint::new(companion, Wanted::Keep));
        }
    }
}

fn bind(shapes: &Shapes<'_>, mut constraint: Constraint, id: ConstraintId) -> Result<Bound, EditError> {
    if let Some(bound) = constraint.functional.bind(shapes)? {
        constraint.functional = bound;
    }
    let name = constraint.describe();
    if constraint.axis.is_some() && !constraint.functional.is_vector() {
        return Err(
            Error::Invalid(format!("{name} cannot be narrowed to an axis: it is not a vector")).into()
        );
    }
    let count = constraint.functional.equations();
    let mut target = vec![0.0; count];
    constraint.functional.value(shapes, &mut target)?;
    let check = |value: &Value| -> Result<Vec<f64>, EditError> {
        if let Some(bad) = value.0.iter().find(|v| !v.is_finite()) {
            return Err(Error::Invalid(format!("{name}: {bad} is not a finite number")).into());
        }
        match (value.0.len(), constraint.axis) {
            (found, _) if found == count => Ok(value.0.clone()),
            // One number for the one axis that is asked.
            (1, Some(_)) => Ok(vec![value.0[0]; count]),
            (found, _) => {
                Err(Error::Invalid(format!("{name}: {found} number(s) were given where {count} are needed"))
                    .into())
            }
        }
    };
    match &constraint.wanted {
        Wanted::Keep => {}
        Wanted::Hold => target.fill(0.0),
        Wanted::To(value) => target = check(value)?,
        Wanted::By(value) => target.iter_mut().zip(check(value)?).for_each(|(t, by)| *t += by),
        Wanted::Scale(factor) if factor.is_finite() => target.iter_mut().for_each(|t| *t *= factor),
        Wanted::Scale(factor) => {
            return Err(
                Error::Invalid(format!("{name}: {factor} is not a factor; give a finite number")).into()
            );
        }
        Wanted::AtLeast(_) | Wanted::AtMost(_) => {
            return Err(SolveError::Unsupported(format!(
                "{name}: \"at_least\" and \"at_most\" need a solver of inequalities, and none is registered; \
                 ask \"to\" or \"keep\" instead"
            ))
            .into());
        }
    }
    if let Some(bad) = target.iter().find(|t| !t.is_finite()) {
        return Err(Error::Invalid(format!("{name}: its value would be {bad}; ask for less")).into());
    }
    Ok(Bound { id, constraint, target })
}

/// Wanted minus present values into `rhs`, the sizes of the numbers they come from into `size`; and for each
/// constraint its largest error and the size to measure it by.
fn right_hand_side(
    shapes: &Shapes<'_>,
    bound: &[Bound],
    assembly: &Assembly,
    rhs: &mut Vec<f64>,
    size: &mut Vec<f64>,
) -> Result<Vec<(f64, f64)>> {
    let entries = assembly.system.rows().len() * assembly.system.sides();
    rhs.clear();
    rhs.resize(entries, 0.0);
    size.clear();
    size.resize(entries, 0.0);
    let mut errors = Vec::with_capacity(bound.len());
    let mut value = Vec::new();
    for (k, b) in bound.iter().enumerate() {
        value.clear();
        value.resize(b.constraint.functional.equations(), 0.0);
        b.constraint.functional.value(shapes, &mut value)?;
        let mut worst = (0.0_f64, 0.0_f64);
        for slot in assembly.slots(k) {
            let (at, equation) = (assembly.entry(slot), slot.equation as usize);
            rhs[at] = b.target[equation] - value[equation];
            size[at] = slot.magnitude + b.target[equation].abs() + value[equation].abs();
            worst = (worst.0.max(rhs[at].abs()), worst.1.max(size[at]));
        }
        errors.push(worst);
    }
    Ok(errors)
}

fn prepare(
    boxes: &[Box<dyn Shape>],
    bound: &[Bound],
    handle: Option<usize>,
    freedom: &Freedom,
    metric: &Metric,
    solver: &dyn Solver,
) -> Result<Prepared, EditError> {
    let shapes = view(boxes);
    let constraints: Vec<&Constraint> = bound.iter().map(|b| &b.constraint).collect();
    let assembly = Assembly::new(&shapes, &constraints, freedom, metric)?;
    let (mut rhs, mut size) = (Vec::new(), Vec::new());
    right_hand_side(&shapes, bound, &assembly, &mut rhs, &mut size)?;
    let mut factored = solver.factor(&assembly.system)?;
    let sides = assembly.system.sides();
    let touched = assembly.system.touched();
    let vertex_of = |column: usize| if sides == 3 { column } else { column / 3 };
    let step = if sides == 3 { 1 } else { 3 };
    let vertices: Vec<usize> = touched.iter().step_by(step).map(|&c| vertex_of(c)).collect();
    let mut places = Vec::with_capacity(vertices.len());
    let mut base = Vec::with_capacity(vertices.len());
    let mut shape = 0;
    for vertex in vertices {
        while vertex >= shapes.offset(shape + 1) {
            shape += 1;
        }
        places.push((shape as u32, (vertex - shapes.offset(shape)) as u32));
        base.push(shapes.vertex(vertex));
    }
    let d = vec![0.0; touched.len() * sides];
    let mut still = Vec::new();
    let mut response = Vec::new();
    if let Some(handle) = handle {
        for slot in assembly.slots(handle) {
            rhs[assembly.entry(slot)] = 0.0;
        }
        still = d.clone();
        factored.solve_into(&rhs, &mut still);
        let mut one = vec![0.0; rhs.len()];
        let mut column = d.clone();
        for slot in assembly.slots(handle) {
            // With three sides, x, y and z share one column of C.
            if slot.side > 0 {
                continue;
            }
            one[assembly.entry(slot)] = 1.0;
            factored.solve_into(&one, &mut column);
            one[assembly.entry(slot)] = 0.0;
            response.push(column.iter().step_by(sides).copied().collect());
        }
    }
    let dependencies = if needs_diagnosis(factored.as_ref(), &assembly) {
        factored.diagnosis().dependencies
    } else {
        Vec::new()
    };
    Ok(Prepared {
        assembly,
        factored,
        dependencies,
        rhs,
        size,
        d,
        still,
        response,
        base,
        places,
        iterations: 1,
    })
}

/// Whether rows may have been dropped. The rank is always known without asking for the condition.
fn needs_diagnosis(factored: &dyn Factored, assembly: &Assembly) -> bool {
    factored.rank() < assembly.system.rows().len()
}

/// The right-hand side on the independent rows that misses all rows least (each scaled as it stands): least squares
/// over `[I; C]`, `C` the combinations of the dependent ones, by the normal equations of the few that are dependent:
/// `y = b + Cᵀ (I + C Cᵀ)⁻¹ (b_dep - C b)`.
fn soften(assembly: &Assembly, dependencies: &[Dependency], rhs: &[f64]) -> Vec<f64> {
    let sides = assembly.system.sides();
    let rows = assembly.system.rows();
    let norm = |row: usize| rows.norm(row).max(f64::MIN_POSITIVE);
    // In unit rows: c' = c · |other| / |row|, b' = b / |row|.
    let live: Vec<&Dependency> = dependencies.iter().filter(|d| !d.combination.is_empty()).collect();
    let m = live.len();
    let factor = |d: &Dependency, i: usize| d.combination[i].1 * norm(d.combination[i].0) / norm(d.row);
    let mut gram = vec![0.0; m * m];
    for (i, a) in live.iter().enumerate() {
        for (j, b) in live.iter().enumerate().take(i + 1) {
            let mut sum = f64::from(u8::from(i == j));
            for (x, &(row, _)) in a.combination.iter().enumerate() {
                if let Ok(y) = b.combination.binary_search_by_key(&row, |&(r, _)| r) {
                    sum += factor(a, x) * factor(b, y);
                }
            }
            gram[i * m + j] = sum;
        }
    }
    let mut softened = rhs.to_vec();
    let first = vec![0; m];
    let Ok(cholesky) = crate::solve::EnvelopeCholesky::factor(first, 0.0, |i, j| gram[i * m + j]) else {
        return softened;
    };
    let mut missing = vec![0.0; m * sides];
    for (i, d) in live.iter().enumerate() {
        for side in 0..sides {
            let implied: f64 = d.combination.iter().map(|&(row, c)| c * rhs[row * sides + side]).sum();
            missing[i * sides + side] = (rhs[d.row * sides + side] - implied) / norm(d.row);
        }
    }
    cholesky.solve(&mut missing, sides);
    for (i, d) in live.iter().enumerate() {
        for (x, &(row, _)) in d.combination.iter().enumerate() {
            for side in 0..sides {
                softened[row * sides + side] += factor(d, x) * missing[i * sides + side] * norm(row);
            }
        }
    }
    softened
}

/// A tangent that was asked to be parallel to a direction but came out the other way round.
fn reversed(shapes: &Shapes<'_>, bound: &Bound) -> Option<String> {
    let any: &dyn Any = bound.constraint.functional.as_ref();
    let tangent = any.downcast_ref::<crate::functional::Tangent>()?;
    let along = tangent.sense(shapes)?;
    (along < 0.0).then(|| format!("{} now points against its direction", bound.constraint.describe()))
}

/// The parameter near `u` whose point on the curve is nearest to the cursor: Newton on `(C(u) - cursor)·C' = 0`, kept
/// within the domain, each step halved until the distance does not grow.
fn foot(curve: &dyn Shape, cursor: crate::Vector, start: f64) -> Result<f64> {
    let domain = curve.domain();
    let Some(interval) = domain.first() else { return Ok(start) };
    let clamp = |u: f64| if interval.periodic { u } else { u.max(interval.start).min(interval.end) };
    let distance = |u: f64| -> Result<f64> { Ok((curve.value(u.into(), 0.into())? - cursor).norm_squared()) };
    let mut u = clamp(start);
    let mut best = distance(u)?;
    for _ in 0..32 {
        let offset = curve.value(u.into(), 0.into())? - cursor;
        let (first, second) = (curve.value(u.into(), 1.into())?, curve.value(u.into(), 2.into())?);
        let slope = offset.dot(&first);
        let bend = first.norm_squared() + offset.dot(&second);
        // Where the bend is not that of a minimum, fall back to Gauss–Newton, which always descends.
        let bend = if bend > 0.1 * first.norm_squared() { bend } else { first.norm_squared() };
        if bend.is_nan() || bend <= 0.0 {
            break;
        }
        let mut step = -slope / bend;
        let mut moved = false;
        for _ in 0..20 {
            let next = clamp(u + step);
            let reached = distance(next)?;
            if reached < best {
                (u, best, moved) = (next, reached, true);
                break;
            }
            step *= 0.5;
        }
        if !moved || step.abs() <= 1e-14 * (interval.end - interval.start) {
            break;
        }
    }
    Ok(u)
}

fn snapshot(shapes: &[Box<dyn Shape>], prepared: &Prepared) -> Vec<(u32, u32, Point)> {
    let point = |&(s, v): &(u32, u32)| (s, v, shapes[s as usize].control_vertices()[v as usize]);
    prepared.places.iter().map(point).collect()
}

fn put(shapes: &mut [Box<dyn Shape>], state: &[(u32, u32, Point)]) {
    for &(shape, vertex, point) in state {
        shapes[shape as usize].control_vertices_mut()[vertex as usize] = point;
    }
}

/// A finished edit: the new shapes, the report and the way back.
#[derive(Debug)]
pub struct Edited<S> {
    shapes: Vec<Box<dyn Shape>>,
    report: Report,
    before: Vec<(u32, u32, Point)>,
    kind: PhantomData<fn() -> S>,
}

impl<S: Shape> Edited<S> {
    /// The edited shape.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn shape(&self) -> &S {
        let any: &dyn Any = self.shapes[0].as_ref();
        match any.downcast_ref() {
            Some(shape) => shape,
            None => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// Shape `index` of the problem; 0 is [`shape`](Self::shape).
    ///
    /// # Errors
    /// When there are not as many.
    pub fn shape_at(&self, index: usize) -> Result<&dyn Shape> {
        view(&self.shapes).get(index)
    }

    /// The edited shape, out of the box.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn into_shape(mut self) -> S {
        let any: Box<dyn Any> = self.shapes.swap_remove(0);
        match any.downcast() {
            Ok(shape) => *shape,
            Err(_) => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// What solving gave.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Takes the edit back: the shapes as they were.
    #[must_use]
    pub fn undo(mut self) -> S {
        put(&mut self.shapes, &self.before);
        self.into_shape()
    }
}
