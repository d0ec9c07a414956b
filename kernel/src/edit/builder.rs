//! An edit being said: shapes, what is asked of them, what may move.

use std::marker::PhantomData;
use std::sync::Arc;

use smallvec::smallvec;

use super::locality::{Intervals, influence, localise_beside, most_influential};
use super::session::{Edited, Session};
use crate::energy::Energy;
use crate::error::{Error, Result};
use crate::functional::{Functional, Shapes, vertex};
use crate::problem::conflict::quoted;
use crate::problem::known::Known;
use crate::problem::smooth::frozen;
use crate::problem::{
    Ask, Asked, Boxes, Constraint, EditError, Freedom, Measured, Metric, Problem, Smoothing, Unknowns, Wanted,
};
use crate::shape::{Location, Shape, vertex_index};
use crate::solve::{Automatic, Solver};

/// Says an edit: what is asked of a shape (and perhaps others with it), what may move and what "least" means.
#[derive(Debug)]
pub struct Edit<S> {
    shapes: Boxes,
    constraints: Vec<Constraint>,
    handle: Option<Arc<dyn Functional>>,
    sliding: bool,
    best_effort: bool,
    alternating: bool,
    forced: bool,
    /// The first shape before knots were inserted to keep the edit in an interval.
    original: Option<Box<dyn Shape>>,
    locks: Vec<(usize, i64)>,
    locality: Option<usize>,
    window: Option<(f64, f64)>,
    metric: Metric,
    unknowns: Option<Box<Unknowns>>,
    minimised: bool,
    smooth: u8,
    everywhere: bool,
    names: Vec<(usize, Arc<str>)>,
    kind: PhantomData<fn() -> S>,
}

impl<S: Shape + Clone> Edit<S> {
    /// An edit of a copy of a shape.
    pub fn new(shape: &S) -> Self {
        Self::of(shape.clone())
    }
}

impl<S: Shape> Edit<S> {
    /// An edit of a shape that is given away, so that nothing is copied.
    pub fn of(shape: S) -> Self {
        Self {
            shapes: smallvec![shape.into_box()],
            constraints: Vec::new(),
            handle: None,
            sliding: false,
            best_effort: false,
            alternating: false,
            forced: false,
            original: None,
            locks: Vec::new(),
            locality: None,
            window: None,
            metric: Metric::Least,
            unknowns: None,
            minimised: false,
            smooth: 1,
            everywhere: false,
            names: Vec::new(),
            kind: PhantomData,
        }
    }

    /// Adds another shape to the problem: the next number (1, 2, …) for functionals' `on`. It may move as the first does.
    #[must_use]
    pub fn with(mut self, shape: Box<dyn Shape>) -> Self {
        self.shapes.push(shape);
        self
    }

    /// Asks something.
    #[must_use]
    pub fn ask(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Locks control vertices of the first shape: they may not move. Negative numbers count from the end.
    #[must_use]
    pub fn lock(self, vertices: impl IntoIterator<Item = i64>) -> Self {
        self.lock_on(0, vertices)
    }

    /// Locks control vertices of shape `shape`.
    #[must_use]
    pub fn lock_on(mut self, shape: usize, vertices: impl IntoIterator<Item = i64>) -> Self {
        self.locks.extend(vertices.into_iter().map(|v| (shape, v)));
        self
    }

    /// Lets only this many vertices move: those with the largest influence at the handle, or at the first location
    /// where something is to change (paper 4, §2).
    #[must_use]
    pub fn locality(mut self, vertices: usize) -> Self {
        self.locality = Some(vertices);
        self
    }

    /// Keeps the edit within an interval of a curve (preparing refuses other shapes): knots are inserted around the location until as many vertices
    /// as [`locality`](Self::locality) says (by default one more than there are constraints, up to `p + 1`) can move
    /// without changing anything outside (paper 4, §5).
    #[must_use]
    pub fn within(mut self, start: f64, end: f64) -> Self {
        self.window = Some((start, end));
        self
    }

    /// What "least" means.
    #[must_use]
    pub fn metric(mut self, metric: Metric) -> Self {
        self.metric = metric;
        self
    }

    /// Makes an energy least, not the adjustment: of all shapes that meet what is asked, the one of least energy. Preparing brings
    /// the shapes to where the energy is least by itself; what is asked is then met by the least adjustment from there, measured by
    /// its form. It takes the place of the [metric](Self::metric). An energy that does not see some motion (bending alone) is
    /// refused: add some distance from the shape as it was, or [fair](crate::problem::Problem) under constraints that hold it.
    #[must_use]
    pub fn minimise(mut self, energy: impl Energy + 'static) -> Self {
        self.metric = Metric::Energy(Measured(Arc::new(energy)));
        self.minimised = true;
        self
    }

    /// Makes these the unknowns, and not the control vertices: vertices tied to others, coefficients of whatever moves them.
    /// Vertices that are [locked](Self::lock) stay by equations of their own then.
    #[must_use]
    pub fn through(mut self, unknowns: Unknowns) -> Self {
        self.unknowns = Some(Box::new(unknowns));
        self
    }

    /// How smooth what was smooth stays, at knots that are repeated so often that corners can appear there (every joint of a
    /// Bézier chain, an exact circle or revolution; the seam of a closed curve). By default 1: where both sides have one
    /// direction (within 1e-5 radian) at such a knot that the edit touches, `C'₊ = r C'₋` with the ratio as it is, and
    /// where they meet, they go on meeting; on a surface so along a knot line, for each column of the net. With 2 the
    /// curvature as well (`C''₊ = r² C''₋ + s C'₋`), where both sides have the same: on a quadratic circle that leaves
    /// affine images only, on a long chain it moves everything. With 0 corners (and gaps) may appear. More counts as 2.
    ///
    /// What is kept is no constraint of the report: [`Report::smooth`](super::Report::smooth) says at how many knots, and
    /// what corners the edit made.
    #[must_use]
    pub fn smooth(mut self, level: u8) -> Self {
        self.smooth = level.min(2);
        self
    }

    /// Keeps what is [smooth](Self::smooth) at all knots around control vertices that may move, whether what is asked touches
    /// them or not: for those who prepare a session to look for another answer than the least adjustment (fairing).
    #[must_use]
    pub fn smooth_everywhere(mut self) -> Self {
        self.everywhere = true;
        self
    }

    /// What messages call shape `shape` of the problem, where they speak of it by themselves.
    #[must_use]
    pub fn named(mut self, shape: usize, name: impl Into<Arc<str>>) -> Self {
        self.names.push((shape, name.into()));
        self
    }

    /// What [`Session::to`] drags.
    #[must_use]
    pub fn handle(mut self, functional: impl Functional + 'static) -> Self {
        self.handle = Some(Arc::new(functional));
        self
    }

    /// The same, for a functional that is shared.
    #[must_use]
    pub fn shared_handle(mut self, functional: Arc<dyn Functional>) -> Self {
        self.handle = Some(functional);
        self
    }

    /// Lets the handle's parameter slide along with the tangential part of the motion (paper 4, §5): only the part
    /// across the curve moves it. For a position on a curve. Each event then prepares anew at its parameter.
    #[must_use]
    pub fn sliding(mut self) -> Self {
        self.sliding = true;
        self
    }

    /// Accepts the nearest thing to a solution (least squares, each equation scaled to unit length) where the
    /// constraints conflict; the report says so.
    #[must_use]
    pub fn best_effort(mut self) -> Self {
        self.best_effort = true;
        self
    }

    /// Lets the axes alternate where constraints are multilinear (area, volume; paper 2): each event meets the linear
    /// constraints from where the last one arrived, and then one axis, the next one each time, makes up for what is missing,
    /// in one linear solve. By default all axes move together, for the least adjustment of the shape as it was when prepared.
    #[must_use]
    pub fn alternating(mut self) -> Self {
        self.alternating = true;
        self
    }

    /// Takes an adjustment that is out of all proportion to what is asked. Without it, one that is more than 10⁶ times as long
    /// as the adjustments together that each equation alone would cost is refused as a near conflict. It never excuses an
    /// equation that is missed.
    #[must_use]
    pub fn force(mut self) -> Self {
        self.forced = true;
        self
    }

    /// Solves with the default solver.
    ///
    /// # Errors
    /// When something cannot be asked of the shapes, or the constraints cannot all hold.
    pub fn solve(self) -> Result<Edited<S>, EditError> {
        self.solve_with(Automatic)
    }

    /// Solves with a solver.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve); also when the solver refuses the system.
    pub fn solve_with(self, solver: impl Solver + 'static) -> Result<Edited<S>, EditError> {
        let mut session = self.prepare(solver)?;
        session.apply()?;
        session.commit()
    }

    /// Does all the work that can be done once. The cost depends on what the constraints touch, not on the size of
    /// the shape (beyond the copy that [`new`](Self::new) made).
    ///
    /// # Errors
    /// As for [`solve_with`](Self::solve_with).
    pub fn prepare(mut self, solver: impl Solver + 'static) -> Result<Session<S>, EditError> {
        let asked = self.asked()?;
        Session::new(self, asked, Box::new(solver))
    }

    /// What is asked as a problem, bound where the shapes are: for those who take its rows, solve it once, or look for another
    /// answer than the least adjustment. (Handles, sliding and alternating axes are a session's: a handle is kept where it is.)
    ///
    /// # Errors
    /// When something cannot be asked of the shapes.
    pub fn problem(mut self) -> Result<Problem, EditError> {
        let (mut problem, _) = Problem::new(self.asked()?, &mut Known::default())?;
        problem.renew_smoothness()?;
        if self.minimised {
            problem.start_at_minimum()?;
        }
        Ok(problem)
    }

    /// All that a problem is made of, taken out.
    fn asked(&mut self) -> Result<Asked, EditError> {
        self.make_ready()?;
        if self.unknowns.is_some() {
            self.hold_locks()?;
        }
        if let Some((start, end)) = self.window {
            self.localise_window(start, end)?;
        }
        Ok(Asked {
            freedom: Freedom { unknowns: self.unknowns.take(), ..self.freedom()? },
            smoothing: Smoothing::new(self.smooth, self.everywhere, std::mem::take(&mut self.names)),
            shapes: std::mem::take(&mut self.shapes),
            constraints: std::mem::take(&mut self.constraints),
            handle: self.handle.take(),
            metric: std::mem::take(&mut self.metric),
            best_effort: self.best_effort,
            forced: self.forced,
        })
    }

    /// Makes shapes of several pieces ready to be moved where something is asked of them.
    fn make_ready(&mut self) -> Result<()> {
        for index in 0..self.shapes.len() {
            let Some(bonds) = self.shapes[index].bonds().filter(|bonds| !bonds.is_ready()) else { continue };
            let functionals = || self.constraints.iter().map(|c| &c.functional).chain(&self.handle);
            if let Some(numbered) = functionals().find(|f| f.by_number(index)) {
                return Err(Error::Invalid(format!(
                    "an edit of faces that hang together may give them more control vertices, which renumbers them, so that {} would mean                      others: ask for a position on a face in its place",
                    quoted(&numbered.describe())
                )));
            }
            if self.locks.iter().any(|&(shape, _)| shape == index) {
                return Err(Error::Invalid(
                    "an edit of faces that hang together may give them more control vertices, which renumbers them: lock none of them; faces                      that are not to move stand still"
                        .into(),
                ));
            }
            let places: Vec<(u32, [f64; 2])> = functionals()
                .filter_map(|f| match f.location() {
                    Some((shape, Location::Face(face, u, v))) if shape == index => Some((face, [u, v])),
                    _ => None,
                })
                .collect();
            let ready = bonds.ready(&places)?;
            let before = std::mem::replace(&mut self.shapes[index], ready);
            if index == 0 {
                self.original = Some(before);
            }
        }
        Ok(())
    }

    /// What is left for a session: whether the handle slides, whether axes alternate, whether an energy is to be least, and the
    /// first shape before knots were inserted.
    pub(super) fn into_rest(self) -> (bool, bool, bool, Option<Box<dyn Shape>>) {
        (self.sliding, self.alternating, self.minimised, self.original)
    }

    /// The location that the edit is about: the handle's, else that of the first constraint that changes something.
    fn focus(&self) -> Option<(usize, Location)> {
        let changing = |c: &&Constraint| !matches!(c.wanted, Wanted::Keep | Wanted::Hold);
        self.handle
            .as_ref()
            .and_then(|h| h.location())
            .or_else(|| self.constraints.iter().filter(changing).find_map(|c| c.functional.location()))
    }

    fn freedom(&self) -> Result<Freedom> {
        let bonded = self.shapes.iter().any(|shape| shape.bonds().is_some());
        if self.locks.is_empty() && self.locality.is_none() && self.window.is_none() && !bonded {
            return Ok(Freedom::default());
        }
        let shapes = Shapes::new(self.shapes.iter().map(AsRef::as_ref));
        let mut locked = Vec::with_capacity(self.locks.len());
        for (index, shape) in self.shapes.iter().enumerate() {
            let held = shape.bonds().map_or(&[][..], |bonds| bonds.held());
            locked.extend(held.iter().map(|vertex| shapes.offset(index) + vertex));
        }
        for &(shape, vertex) in &self.locks {
            let count = shapes.get(shape)?.control_vertices().len();
            locked.push(shapes.offset(shape) + vertex_index(vertex, count)?);
        }
        locked.sort_unstable();
        locked.dedup();
        let only = match (self.locality, self.window) {
            (Some(count), None) => {
                let (shape, at) = self.focus().ok_or_else(|| {
                    Error::Invalid(
                        "a locality needs a place: ask for a change at a location, or give a handle".into(),
                    )
                })?;
                Some(most_influential(&shapes, shape, at, count)?)
            }
            (_, Some((start, end))) => {
                Some(Intervals::of(first(&self.shapes)?)?.supported_inside(start, end))
            }
            (None, None) => None,
        };
        Ok(Freedom { locked, only, within: self.window, ..Freedom::default() })
    }

    /// Where unknowns move several vertices, one that is locked is an equation, not a column less.
    fn hold_locks(&mut self) -> Result<()> {
        if self.shapes.iter().any(|shape| shape.bonds().is_some()) {
            return Err(Error::Invalid(
                "faces that hang together say which control vertices move, and so do unknowns of one's own: edit one face's surface by itself,                  or leave the unknowns out"
                    .into(),
            ));
        }
        if self.locality.is_some() || self.window.is_some() {
            return Err(Error::Invalid(
                "unknowns of one's own say which control vertices move, and so does a locality or an interval: leave one of the \
                 two out"
                    .into(),
            ));
        }
        let mut held = std::mem::take(&mut self.locks);
        let shapes = Shapes::new(self.shapes.iter().map(AsRef::as_ref));
        for (shape, index) in &mut held {
            *index = vertex_index(*index, shapes.get(*shape)?.control_vertices().len())? as i64;
        }
        held.sort_unstable();
        held.dedup();
        self.constraints.extend(held.into_iter().map(|(shape, index)| vertex(index).on(shape).keep()));
        Ok(())
    }

    /// Refines the first shape so that the edit fits into the interval, and moves locks along with their vertices.
    fn localise_window(&mut self, start: f64, end: f64) -> Result<()> {
        let at = self.focus();
        let curve = first(&self.shapes)?;
        let most = influence(curve)?;
        let Some((0, Location::Curve(u))) = at else {
            return Err(Error::Invalid(
                "an edit within an interval needs a place in it: ask for a change at a location, or give a handle".into(),
            ));
        };
        if self.locks.iter().any(|&(shape, _)| shape == 0) {
            return Err(Error::Invalid(
                "an edit within an interval inserts knots, which renumbers control vertices: lock none of them \
                 (nothing outside the interval moves), or refine first"
                    .into(),
            ));
        }
        let functionals = self.constraints.iter().map(|c| &c.functional).chain(&self.handle);
        if let Some(numbered) = functionals.into_iter().find(|f| f.by_number(0)) {
            return Err(Error::Invalid(format!(
                "an edit within an interval inserts knots, which renumbers control vertices, so that {} would mean \
                 others: ask for a position in its place, or refine first and edit without an interval",
                quoted(&numbered.describe())
            )));
        }
        let vertices = self.locality.unwrap_or_else(|| (self.constraints.len() + 1).min(most));
        // What must stay for the curve to be as smooth at the interval's ends as it is does not count as free.
        let kept = |curve: &dyn Shape, inside: &[usize]| {
            [start, end]
                .into_iter()
                .flat_map(|u| frozen(curve, u, inside, self.smooth))
                .collect::<Vec<usize>>()
        };
        let (refined, _) = localise_beside(curve, start, end, u, vertices, &kept)?;
        self.original = Some(std::mem::replace(&mut self.shapes[0], refined));
        Ok(())
    }
}

fn first(shapes: &[Box<dyn Shape>]) -> Result<&dyn Shape> {
    shapes.first().map(AsRef::as_ref).ok_or_else(|| Error::Invalid("an edit of no shape".into()))
}
