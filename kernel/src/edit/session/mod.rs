//! An edit under way: prepared once, then one cheap event after another.

mod account;
mod border;
mod bounded;
mod curved;
mod edited;
mod effort;
mod event;
mod floating;
mod mixing;
mod prepared;
mod progress;
mod sequential;
mod slide;
mod strategy;
mod support;

use std::collections::BTreeSet;
use std::marker::PhantomData;

use smallvec::SmallVec;

pub use self::edited::Edited;
use self::prepared::{Prepared, prepare};
use super::builder::Edit;
use crate::Point;
use crate::error::{Error, Result};
use crate::functional::value_of;
use crate::problem::bound::{BoundConstraint, add_companions, loosen};
use crate::problem::check::{step, was_finite};
use crate::problem::conflict::quoted;
use crate::problem::known::Known;
use crate::problem::{Asked, Constraint, ConstraintId, EditError, Numbers, Problem, Value, view};
use crate::shape::Shape;
use crate::solve::{Sense, SolveError, Solver};
use crate::text::{counted, figure};

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
    /// What is asked; its shapes are as the last event left them.
    problem: Problem,
    handle: Option<Handle>,
    /// The constraints whose locations float.
    floating: Vec<ConstraintId>,
    /// The axis whose turn it is, where they alternate.
    alternating: Option<usize>,
    /// Whether the shapes are what the last event made of what is asked now.
    solved: bool,
    /// The first shape before knots were inserted to keep the edit in an interval; and whether it is (again) what is shown.
    original: Option<Box<dyn Shape>>,
    pristine: bool,
    solver: Box<dyn Solver>,
    /// Behind a pointer: a session is handed on some times before its first event.
    prepared: Box<Prepared>,
    checkpoints: Vec<State>,
    start: State,
    kind: PhantomData<fn() -> S>,
}

/// Where vertices are: shape, vertex, point.
type State = SmallVec<[(u32, u32, Point); 4]>;

/// What is dragged.
#[derive(Debug)]
struct Handle {
    /// The number of its constraint.
    at: usize,
    /// Its value when it was prepared.
    start: Numbers,
    /// Where it was dragged before, to go back to where an event fails.
    last: Numbers,
    /// The curve as it was and the parameter, where that slides.
    sliding: Option<(Box<dyn Shape>, f64)>,
}

impl Handle {
    fn new(problem: &Problem, at: usize, slides: bool) -> Result<Self> {
        let BoundConstraint { constraint, target, .. } = &problem.bound[at];
        let sliding =
            if slides { Some(slide::begin(problem, constraint.functional().as_ref())?) } else { None };
        let [start, last] = [(); 2].map(|()| Numbers::from_slice(target));
        Ok(Self { at, start, last, sliding })
    }
}

impl<S> std::fmt::Debug for Session<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session").field("constraints", &self.problem.bound).finish_non_exhaustive()
    }
}

impl<S: Shape> Session<S> {
    pub(super) fn new(edit: Edit<S>, asked: Asked, solver: Box<dyn Solver>) -> Result<Self, EditError> {
        let (slides, alternating, minimised, original) = edit.into_rest();
        let mut known = Known::default();
        let (mut problem, dragged) = Problem::new(asked, &mut known)?;
        let handle = dragged.map(|at| Handle::new(&problem, at, slides)).transpose()?;
        if alternating {
            curved::check_alternating(&problem.bound)?;
        }
        let floating = floating::anchor(&mut problem.bound, 0)?;
        if !floating.is_empty() {
            known = Known::default();
        }
        // What is kept smooth comes behind what is asked, whose values stay known.
        problem.renew_smoothness()?;
        let mut handle = handle;
        if minimised {
            problem.start_at_minimum()?;
            known = Known::default();
            if let Some(handle) = &mut handle {
                let functional = problem.bound[handle.at].constraint.functional.as_ref();
                value_of(functional, &view(&problem.shapes), &mut handle.start)?;
            }
        }
        let prepared = prepare(&problem, dragged, solver.as_ref(), &mut known, false)?;
        let mut start = prepared.state();
        if !problem.taken.is_empty() {
            let vertices = prepared.assembly.vertices();
            start.iter_mut().zip(vertices).for_each(|(at, v)| at.2 = problem.taken_from(v).unwrap_or(at.2));
        }
        Ok(Self {
            problem,
            handle,
            floating,
            alternating: alternating.then_some(0),
            solved: false,
            pristine: original.is_some(),
            original,
            solver,
            prepared,
            checkpoints: Vec::new(),
            start,
            kind: PhantomData,
        })
    }

    /// What is asked, with the shapes as they are now.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The shape as it is now.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn shape(&self) -> &S {
        match S::in_box(self.first()) {
            Some(shape) => shape,
            None => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// Shape `index` of the problem as it is now; 0 is [`shape`](Self::shape).
    ///
    /// # Errors
    /// When there are not as many.
    pub fn shape_at(&self, index: usize) -> Result<&dyn Shape> {
        if index == 0 { Ok(self.first().as_ref()) } else { view(&self.problem.shapes).get(index) }
    }

    /// Shape `index` of the problem with all vertices that events can move: where the edit is kept in an interval, with the
    /// knots that it inserted, even while nothing has moved and [`shape_at`](Self::shape_at) is the shape as it was.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn prepared_shape(&self, index: usize) -> Result<&dyn Shape> {
        view(&self.problem.shapes).get(index)
    }

    /// The first shape as it is now: without the knots that the edit inserted, where nothing has moved.
    #[allow(clippy::borrowed_box, reason = "the box may be the shape that was given")]
    fn first(&self) -> &Box<dyn Shape> {
        self.original.as_ref().filter(|_| self.pristine).unwrap_or(&self.problem.shapes[0])
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
        let turned = if self.floating.is_empty() { self.event() } else { self.floating_event() };
        self.problem.shapes.iter_mut().for_each(|shape| shape.follow());
        turned.map_err(|error| self.reasoned(error))?;
        (self.solved, self.pristine) = (true, false);
        Ok(())
    }

    /// An error, with what keeps a value out of reach where a functional that was asked knows it.
    fn reasoned(&self, mut error: EditError) -> EditError {
        let EditError::Solve(found @ (SolveError::Conflict { .. } | SolveError::NotConverged { .. })) =
            &mut error
        else {
            return error;
        };
        let shapes = view(&self.problem.shapes);
        let reach = |b: &BoundConstraint| {
            let reason = b.constraint.functional.out_of_reach(&shapes, &b.target)?;
            // A bound is told with what it bounds.
            let wanted = b.target.first().copied().filter(|_| b.constraint.sense() == Sense::Equal);
            Some((b.constraint.label(), wanted, reason))
        };
        let Some((label, wanted, reason)) = self.problem.bound.iter().find_map(reach) else { return error };
        match found {
            SolveError::Conflict { text, .. } => *text = format!("{text}; {reason}"),
            // That it did not arrive says nothing beside why it cannot.
            _ => {
                let wanted = wanted.map_or_else(String::new, |wanted| format!(" of {}", figure(wanted)));
                let text = format!("{}{wanted} is out of reach: {reason}", quoted(&label));
                *found = SolveError::Conflict { constraints: vec![label], knot: None, text };
            }
        }
        error
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
        let Some(handle) = self.handle.as_ref().map(|handle| handle.at) else {
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
        if self.problem.bound[handle].target.len() != value.len() {
            let (what, needed) =
                (self.problem.bound[handle].constraint.describe(), self.problem.bound[handle].target.len());
            let found = value.len();
            return Err(Error::Invalid(format!(
                "\"{what}\" has {}, not {found}",
                counted(needed, "number[|s]")
            ))
            .into());
        }
        self.slide(value)?;
        let target = &mut self.problem.bound[handle].target;
        if let Some(handle) = &mut self.handle {
            handle.last.copy_from_slice(target);
        }
        target.copy_from_slice(value);
        if let Err(error) = self.turn() {
            if let Some(Handle { last, .. }) = &self.handle {
                self.problem.bound[handle].target.copy_from_slice(last);
            }
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
        let dragged = self.dragged();
        add_companions(&mut fresh, None, &self.problem.bound, dragged);
        let (before, floating) = (self.problem.bound.clone(), self.floating.clone());
        let added = self.problem.bind_all(fresh).and_then(|id| {
            self.floating.extend(floating::anchor(&mut self.problem.bound, before.len())?);
            self.prepare_again().map(|()| id)
        });
        if added.is_err() {
            (self.problem.bound, self.floating) = (before, floating);
        }
        added
    }

    /// Takes a constraint away.
    ///
    /// # Errors
    /// When there is none of this name, or it is the handle, or what is left cannot be factored; the session is as before then.
    pub fn remove(&mut self, id: ConstraintId) -> Result<(), EditError> {
        let Some(at) = self.problem.bound.iter().position(|b| b.id == id) else {
            return Err(Error::Invalid("this constraint is not (or no longer) in the session".into()).into());
        };
        if self.dragged() == Some(at) {
            return Err(Error::Invalid(
                "the handle cannot be removed from a session: commit it instead".into(),
            )
            .into());
        }
        let (before, dragged) = (self.problem.bound.clone(), self.dragged());
        self.problem.bound.remove(at);
        if let Some(handle) = self.handle.as_mut().filter(|handle| handle.at > at) {
            handle.at -= 1;
        }
        let still_dragged = self.dragged();
        loosen(&mut self.problem.bound, still_dragged);
        let removed = self.prepare_again();
        if removed.is_err() {
            self.problem.bound = before;
            if let (Some(handle), Some(at)) = (&mut self.handle, dragged) {
                handle.at = at;
            }
        }
        removed
    }

    /// Remembers the shape as it is now, for [`undo`](Self::undo).
    pub fn checkpoint(&mut self) {
        self.checkpoints.push(snapshot(&self.problem.shapes, &self.prepared));
    }

    /// Goes back to the last [`checkpoint`](Self::checkpoint), or to the start of the session; false where there is
    /// nothing to undo. What is asked stays asked.
    ///
    /// # Errors
    /// When the constraints cannot be asked of the shape as it was; the session is as before then.
    pub fn undo(&mut self) -> Result<bool, EditError> {
        let (state, any) = match self.checkpoints.pop() {
            Some(state) => (state, true),
            None => (self.start.clone(), false),
        };
        let changed = any
            || state
                .iter()
                .any(|&(s, v, p)| self.problem.shapes[s as usize].control_vertices()[v as usize] != p);
        let vertex = |s: u32, v: u32| self.problem.shapes[s as usize].control_vertices()[v as usize];
        let now: State = state.iter().map(|&(s, v, _)| (s, v, vertex(s, v))).collect();
        put(&mut self.problem.shapes, &state);
        let minimised = !any && !self.problem.taken.is_empty();
        let started = if minimised { self.problem.start_at_minimum() } else { Ok(()) };
        let prepared = started.and_then(|()| if changed { self.prepare_again() } else { Ok(()) });
        if let Err(error) = prepared {
            put(&mut self.problem.shapes, &now);
            self.checkpoints.extend(any.then_some(state));
            return Err(error);
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
        self.polish();
        let mut report = self.judged()?;
        if !self.pristine || self.original.is_none() {
            for shape in &mut self.problem.shapes {
                report.notes.extend(shape.settle()?);
            }
        }
        let mut before = self.start;
        if let (Some(original), true) = (&self.original, self.pristine) {
            (self.problem.shapes[0], before) = (original.boxed(), State::new());
        }
        Ok(Edited { shapes: self.problem.shapes, report, before, original: self.original, kind: PhantomData })
    }

    /// Base plus adjustment, into the shapes, and the way into `way`; whether all of it is finite.
    fn place(&mut self) -> bool {
        let Prepared { d, base, places, way, .. } = self.prepared.as_mut();
        let (mut places, mut base, mut d) = (&places[..], &base[..], d.as_chunks::<3>().0);
        let (mut way, mut sum) = (&mut way[..], [0.0; 3]);
        let last = self.problem.shapes.len() - 1;
        for (index, shape) in self.problem.shapes.iter_mut().enumerate() {
            let own = if index == last {
                places.len()
            } else {
                places.partition_point(|&(s, _)| s as usize == index)
            };
            if own == 0 {
                continue;
            }
            let (vertices, here) = (shape.control_vertices_mut(), places[..own].iter());
            for (((&(_, vertex), base), d), way) in here.zip(base).zip(d).zip(&mut *way) {
                (vertices[vertex as usize], *way) = step(base, d, &mut sum);
            }
            (places, base, d) = (&places[own..], &base[own..], &d[own..]);
            way = &mut way[own..];
        }
        was_finite(&sum)
    }

    /// The shapes as they were when prepared.
    fn restore(&mut self) {
        self.prepared.d.fill(0.0);
        self.place();
    }

    /// The number of the handle's constraint.
    fn dragged(&self) -> Option<usize> {
        self.handle.as_ref().map(|handle| handle.at)
    }

    /// Prepares for what is asked now, of the shapes as they are. Where that fails, what was prepared stays good.
    fn prepare_again(&mut self) -> Result<(), EditError> {
        let start = self.handle.as_ref().map(|handle| handle.start.clone());
        let prepared = self.prepare_here();
        // Events move the handle from where it was when the last prepared system was.
        if prepared.is_err()
            && let (Some(handle), Some(start)) = (&mut self.handle, start)
        {
            handle.start = start;
        }
        prepared
    }

    fn prepare_here(&mut self) -> Result<(), EditError> {
        if let Some(handle) = &mut self.handle {
            let functional = self.problem.bound[handle.at].constraint.functional.as_ref();
            value_of(functional, &view(&self.problem.shapes), &mut handle.start)?;
        }
        let before = self.problem.renew_smoothness()?;
        self.prepared = match (
            prepare(&self.problem, self.dragged(), self.solver.as_ref(), &mut Known::default(), false),
            before,
        ) {
            (Ok(prepared), _) => prepared,
            (Err(error), before) => {
                self.problem.bound = before.unwrap_or_else(|| std::mem::take(&mut self.problem.bound));
                return Err(error);
            }
        };
        self.solved = false;
        // What is touched for the first time belongs to the ways back, too: it is where it was.
        let fresh = self.prepared.state();
        for state in std::iter::once(&mut self.start).chain(&mut self.checkpoints) {
            let known: BTreeSet<(u32, u32)> = state.iter().map(|&(s, v, _)| (s, v)).collect();
            state.extend(fresh.iter().copied().filter(|&(s, v, _)| !known.contains(&(s, v))));
        }
        Ok(())
    }
}

fn snapshot(shapes: &[Box<dyn Shape>], prepared: &Prepared) -> State {
    let point = |&(s, v): &(u32, u32)| (s, v, shapes[s as usize].control_vertices()[v as usize]);
    prepared.places.iter().map(point).collect()
}

fn put(shapes: &mut [Box<dyn Shape>], state: &[(u32, u32, Point)]) {
    for &(shape, vertex, point) in state {
        shapes[shape as usize].control_vertices_mut()[vertex as usize] = point;
    }
    shapes.iter_mut().for_each(|shape| shape.follow());
}
