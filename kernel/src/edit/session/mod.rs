//! An edit under way: prepared once, then one cheap event after another.

mod account;
mod border;
mod bound;
mod check;
mod curved;
mod edited;
mod effort;
mod event;
mod inspect;
mod mixing;
mod prepared;
mod program;
mod progress;
mod sequential;
mod slide;
mod smoothing;

use std::any::Any;
use std::marker::PhantomData;

use self::bound::{Bound, add_companions, bind, loosen};
pub use self::edited::Edited;
use self::prepared::{Prepared, prepare};
use self::smoothing::Smoothing;
use super::ask::{Constraint, Value, Wanted};
use super::assembly::Freedom;
use super::conflict::quoted;
use super::error::EditError;
use super::metric::Metric;
use super::problem::Edit;
use crate::Point;
use crate::error::{Error, Result};
use crate::functional::{Linearity, Shapes, value_of};
use crate::shape::{Location, Shape, check_shape};
use crate::solve::{Sense, SolveError, Solver};

/// Names a constraint of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConstraintId(u64);

/// An edit under way. Events do not allocate and do not depend on the size of the shapes (as long as everything
/// asked is a linear equation and the handle does not slide). Where something is not linear, an event costs a few times what that
/// touches; the linear constraints beside it are factored once, and it allocates nothing of its own (nor do areas and volumes).
///
/// *What holds after every event*: the linear constraints to rounding, the others to 2e-13 of the value wanted (or to the
/// rounding of their terms, where those nearly cancel). Where something is not linear, the adjustment is the least one to
/// 1e-6 of itself in its vertices, and so to about 1e-12 in its length; [`commit`](Self::commit) goes on to 1e-11. Where the
/// axes [alternate](Edit::alternating), each event makes up with one axis for what is missing, and nothing is said of the
/// length of the way.
///
/// *Nobody believes the solver*: every event checks all prepared rows on the vertices that it hands out, and that the way there
/// is in [proportion](Edit::force); `commit` asks the functionals themselves ([`measure`](crate::measure)). What does not hold
/// is an error, and the shapes are as they were.
pub struct Session<S> {
    shapes: Vec<Box<dyn Shape>>,
    bound: Vec<Bound>,
    handle: Option<usize>,
    /// The handle's value when it was prepared.
    handle_start: Vec<f64>,
    /// Where it was dragged before, to go back to where an event fails.
    handle_last: Vec<f64>,
    sliding: Option<(Box<dyn Shape>, f64)>,
    freedom: Freedom,
    metric: Metric,
    smoothing: Smoothing,
    best_effort: bool,
    /// The axis whose turn it is, where they alternate.
    alternating: Option<usize>,
    forced: bool,
    /// Whether the shapes are what the last event made of what is asked now.
    solved: bool,
    /// The first shape before knots were inserted to keep the edit in an interval; and whether it is (again) what is shown.
    original: Option<Box<dyn Shape>>,
    pristine: bool,
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
        let mut smoothing = Smoothing::new(edit.smooth, edit.everywhere, edit.names());
        let Edit {
            mut shapes,
            mut constraints,
            mut handle,
            sliding,
            best_effort,
            alternating,
            forced,
            original,
            ..
        } = edit;
        for shape in &mut shapes {
            check_shape(shape.as_mut())?;
        }
        add_companions(&mut constraints, handle.as_mut(), &[], None);
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
        if alternating {
            check_alternating(&bound)?;
        }
        smoothing.renew(&shapes, &mut bound, &freedom, &metric)?;
        let prepared =
            prepare(&shapes, &bound, handle, &freedom, &metric, solver.as_ref(), !best_effort, false)?;
        let start = snapshot(&shapes, &prepared);
        Ok(Self {
            shapes,
            bound,
            handle,
            handle_last: handle_start.clone(),
            handle_start,
            sliding: slide,
            freedom,
            metric,
            smoothing,
            best_effort,
            alternating: alternating.then_some(0),
            forced,
            solved: false,
            pristine: original.is_some(),
            original,
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
        let any: &dyn Any = self.first();
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
        if index == 0 { Ok(self.first()) } else { view(&self.shapes).get(index) }
    }

    /// Shape `index` of the problem with all vertices that events can move: where the edit is kept in an interval, with the
    /// knots that it inserted, even while nothing has moved and [`shape_at`](Self::shape_at) is the shape as it was.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn prepared_shape(&self, index: usize) -> Result<&dyn Shape> {
        view(&self.shapes).get(index)
    }

    /// The first shape as it is now: without the knots that the edit inserted, where nothing has moved.
    fn first(&self) -> &dyn Shape {
        let original = self.original.as_deref().filter(|_| self.pristine);
        original.unwrap_or(self.shapes[0].as_ref())
    }

    /// Solves for what is asked, the handle where it is.
    ///
    /// # Errors
    /// When the constraints cannot all hold; the shapes are as they were then.
    pub fn apply(&mut self) -> Result<&S, EditError> {
        self.turn()?;
        Ok(self.shape())
    }

    /// An event; what it hands out is solved for.
    fn turn(&mut self) -> Result<(), EditError> {
        self.event()?;
        (self.solved, self.pristine) = (true, false);
        Ok(())
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
        let target = &mut self.bound[handle].target;
        self.handle_last.copy_from_slice(target);
        target.copy_from_slice(value);
        if let Err(error) = self.turn() {
            self.bound[handle].target.copy_from_slice(&self.handle_last);
            return Err(error);
        }
        Ok(self.shape())
    }

    /// One more constraint from now on. What was asked before holds as absolute values; the shape as it is now
    /// becomes the one that later events adjust.
    ///
    /// # Errors
    /// When it cannot be asked of the shapes or the system cannot be factored; the session is as before then.
    pub fn add(&mut self, constraint: Constraint) -> Result<ConstraintId, EditError> {
        let mut fresh = vec![constraint];
        add_companions(&mut fresh, None, &self.bound, self.handle);
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
        loosen(&mut self.bound, self.handle);
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
        self.pristine |= !any;
        Ok(changed)
    }

    /// Ends the session: the shapes as they are now, with a report and the way back. Where something is not linear, the last
    /// event's adjustment is brought to within 1e-11 of the least one first (to rounding where that is more), at the cost of
    /// another event. All that was asked is then measured afresh, by the functionals themselves on these shapes.
    ///
    /// # Errors
    /// When a constraint that an event solved for does not hold to the [accuracy](crate::functional::Accuracy) that it
    /// promises (unless only a best effort was asked for), or a length overflows.
    pub fn commit(mut self) -> Result<Edited<S>, EditError> {
        self.settle();
        let report = self.judged()?;
        let mut before = self.start;
        if let (Some(original), true) = (&self.original, self.pristine) {
            (self.shapes[0], before) = (original.boxed(), Vec::new());
        }
        Ok(Edited { shapes: self.shapes, report, before, original: self.original, kind: PhantomData })
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
            value_of(bound.constraint.functional.as_ref(), &view(&self.shapes), &mut self.handle_start)?;
        }
        let before = self.smoothing.renew(&self.shapes, &mut self.bound, &self.freedom, &self.metric)?;
        let prepared = prepare(
            &self.shapes,
            &self.bound,
            self.handle,
            &self.freedom,
            &self.metric,
            self.solver.as_ref(),
            !self.best_effort,
            false,
        );
        self.prepared = match (prepared, before) {
            (Ok(prepared), _) => prepared,
            (Err(error), before) => {
                self.bound = before.unwrap_or_else(|| std::mem::take(&mut self.bound));
                return Err(error);
            }
        };
        self.solved = false;
        // What is touched for the first time belongs to the way back, too.
        let known: std::collections::BTreeSet<(u32, u32)> =
            self.start.iter().map(|&(s, v, _)| (s, v)).collect();
        let fresh = snapshot(&self.shapes, &self.prepared);
        self.start.extend(fresh.into_iter().filter(|&(s, v, _)| !known.contains(&(s, v))));
        Ok(())
    }
}

/// Alternating axes are for constraints that are linear in each of them, and for equations: what one axis makes up for may
/// break a bound that only another axis could meet again, so that an event would fail though there is a solution.
fn check_alternating(bound: &[Bound]) -> Result<(), EditError> {
    let with = |linearity| bound.iter().find(|b| b.constraint.functional.linearity() == linearity);
    if let Some(b) = with(Linearity::Nonlinear) {
        return Err(SolveError::Unsupported(format!(
            "{} is not linear in each axis, so the axes cannot alternate; let them move together",
            quoted(&b.constraint.describe())
        ))
        .into());
    }
    let limit = bound.iter().find(|b| b.constraint.sense() != Sense::Equal);
    match (with(Linearity::Multilinear), limit) {
        (Some(kept), Some(limit)) => Err(SolveError::Unsupported(format!(
            "the axes cannot alternate where there are bounds: the one axis that makes up for {} may break {}, and only \
             another axis could meet it again; let them move together",
            quoted(&kept.constraint.describe()),
            quoted(&limit.constraint.label())
        ))
        .into()),
        _ => Ok(()),
    }
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
