//! What is asked of shapes, as one problem: shapes, what may move, constraints, and what "least" means.
//!
//! A [`Problem`] is the layer between functionals and solvers. It binds targets to numbers, checks them, adds the functionals
//! that should stand still beside others and the rows that keep smooth what is smooth, and assembles the linear
//! [`System`]. [Sessions](crate::edit::Session) solve it event after event; [`Problem::solve`] solves it
//! once; who looks for another answer than the least adjustment (fairing) takes its rows, and has the answer judged by
//! [`Problem::verify`] before it is handed out.
//!
//! ```
//! use loftsman_kernel::Point;
//! use loftsman_kernel::edit::{Ask, Edit};
//! use loftsman_kernel::functional::position;
//! use loftsman_kernel::solve::Automatic;
//! use loftsman_kernel::spline::{Curve, Space};
//!
//! let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
//! let curve = Curve::new(Space::clamped_uniform(3, 12)?, points)?;
//! let problem = Edit::new(&curve).ask(position(4.5).by([0.0, 1.0, 0.0])).problem()?;
//! assert_eq!(problem.assemble(false)?.system().rows().len(), 1);
//! let answer = problem.solve(&Automatic)?;
//! assert_eq!((answer.rank(), answer.adjustments().count()), (3, 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod assembly;
pub(crate) mod bound;
pub(crate) mod check;
pub(crate) mod conflict;
pub(crate) mod constraint;
pub(crate) mod effort;
mod error;
mod falloff;
mod floating;
mod freedom;
pub(crate) mod judge;
mod knots;
pub(crate) mod known;
pub(crate) mod metric;
mod minimum;
mod name;
pub(crate) mod program;
mod report;
pub(crate) mod smooth;
mod smoothing;
pub(crate) mod solution;
mod unknowns;

use std::sync::Arc;

use smallvec::SmallVec;

pub use self::assembly::{Assembly, Parameter};
use self::bound::{BoundConstraint, add_companions, bind};
pub use self::constraint::{Ask, Axis, AxisOf, Constraint, Value, Wanted};
pub use self::error::EditError;
pub(crate) use self::freedom::Freedom;
use self::known::{Known, Linear};
pub use self::metric::{Measured, Metric};
pub use self::name::Name;
pub(crate) use self::report::angle;
pub use self::report::{ConstraintReport, Convergence, Corner, Smoothness};
pub use self::smooth::SmoothKnot;
pub(crate) use self::smoothing::Smoothing;
pub use self::solution::Solution;
pub use self::unknowns::{Tie, Unknowns};
use crate::Point;
use crate::error::Result;
use crate::functional::{Functional, Linearity, Shapes};
use crate::shape::{Shape, check_shape};
use crate::solve::System;

/// Names a constraint of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConstraintId(u64);

impl ConstraintId {
    /// That of what nobody asked for by itself.
    const OURS: Self = Self(u64::MAX);
}

/// Shapes and what is asked of them, bound to numbers where the shapes are now. Made by [`Edit::problem`](crate::edit::Edit::problem).
#[derive(Debug)]
pub struct Problem {
    pub(crate) shapes: Boxes,
    pub(crate) bound: Vec<BoundConstraint>,
    pub(crate) freedom: Freedom,
    pub(crate) metric: Metric,
    /// Where the vertices were that the energy alone took to where it is least.
    pub(crate) taken: Vec<(usize, Point)>,
    /// Whether the nearest thing to a solution will do, and whether an adjustment out of all proportion is taken.
    pub(crate) best_effort: bool,
    pub(crate) forced: bool,
    smoothing: Smoothing,
    next_id: u64,
}

/// The numbers of a vector, or of a row for x, y and z: kept in place.
pub(crate) type Numbers = SmallVec<[f64; 3]>;

/// The shapes of a problem in their boxes: mostly there is one.
pub(crate) type Boxes = SmallVec<[Box<dyn Shape>; 1]>;

/// The shapes in their boxes, as functionals see them.
pub(crate) fn view(shapes: &[Box<dyn Shape>]) -> Shapes<'_> {
    match shapes {
        [one] => Shapes::one(one.as_ref()),
        _ => Shapes::new(shapes.iter().map(AsRef::as_ref)),
    }
}

/// What a problem is made of before anything is bound.
pub(crate) struct Asked {
    pub(crate) shapes: Boxes,
    pub(crate) constraints: Vec<Constraint>,
    /// What will be dragged: bound behind the constraints.
    pub(crate) handle: Option<Arc<dyn Functional>>,
    pub(crate) freedom: Freedom,
    pub(crate) metric: Metric,
    pub(crate) smoothing: Smoothing,
    pub(crate) best_effort: bool,
    pub(crate) forced: bool,
}

impl Problem {
    /// The problem and the number of the constraint that is the handle; what is found of all of them goes to what is `known`.
    ///
    /// # Errors
    /// When something cannot be asked of these shapes.
    pub(crate) fn new(asked: Asked, known: &mut Known) -> Result<(Self, Option<usize>), EditError> {
        let Asked {
            mut shapes,
            mut constraints,
            mut handle,
            freedom,
            metric,
            smoothing,
            best_effort,
            forced,
        } = asked;
        for shape in &mut shapes {
            check_shape(shape.as_mut())?;
        }
        add_companions(&mut constraints, handle.as_mut(), &[], None);
        let dragged = handle.as_ref().map(|_| constraints.len());
        let count = constraints.len() + usize::from(handle.is_some());
        let mut bound = Vec::with_capacity(count);
        known.reserve(count);
        let all = constraints.into_iter().chain(handle.map(|handle| Constraint::new(handle, Wanted::Keep)));
        {
            let shapes = view(&shapes);
            for (id, constraint) in all.enumerate() {
                bound.push(bind(&shapes, constraint, ConstraintId(id as u64), known)?);
            }
        }
        let next_id = bound.len() as u64;
        let taken = Vec::new();
        let problem = Self { shapes, bound, freedom, metric, taken, best_effort, forced, smoothing, next_id };
        Ok((problem, dragged))
    }

    /// One more constraint, bound where the shapes are.
    pub(crate) fn bind(&mut self, constraint: Constraint) -> Result<ConstraintId, EditError> {
        let id = ConstraintId(self.next_id);
        self.bound.push(bind(&view(&self.shapes), constraint, id, &mut Known::default())?);
        self.next_id += 1;
        Ok(id)
    }

    /// A constraint and those that should stand still beside it, unless they are asked already; the number of the first.
    pub(crate) fn bind_all(&mut self, fresh: Vec<Constraint>) -> Result<ConstraintId, EditError> {
        let first = ConstraintId(self.next_id);
        for constraint in fresh {
            let same = |b: &BoundConstraint| {
                b.constraint.axis == constraint.axis
                    && b.constraint.functional.same_as(constraint.functional.as_ref())
            };
            let known = self.bound.iter().any(same);
            if !(known && constraint.wanted == Wanted::Keep && self.next_id > first.0) {
                self.bind(constraint)?;
            }
        }
        Ok(first)
    }

    /// The shapes as they are.
    pub fn shapes(&self) -> Shapes<'_> {
        view(&self.shapes)
    }

    /// What is asked, in the order in which it was; then what stands still beside it, and what is kept smooth.
    pub fn constraints(&self) -> impl Iterator<Item = &Constraint> {
        self.bound.iter().map(|bound| &bound.constraint)
    }

    /// The numbers that a constraint's functional should have: all of them, asked or not.
    pub fn target(&self, constraint: usize) -> Option<&[f64]> {
        self.bound.get(constraint).map(|bound| &bound.target[..])
    }

    /// The first thing asked that is not linear.
    pub fn nonlinear(&self) -> Option<&Arc<dyn Functional>> {
        let functionals = self.bound.iter().map(|b| &b.constraint.functional);
        functionals.into_iter().find(|f| f.linearity() != Linearity::Linear)
    }

    /// The linear system of all that is asked, linearized where the shapes are. `finely`: rows that the others nearly imply are
    /// not left out ([`System::finely`]). The cost is proportional to what the constraints touch.
    ///
    /// # Errors
    /// When something cannot be asked of the shapes as they are.
    pub fn assemble(&self, finely: bool) -> Result<Assembly> {
        self.assemble_beside(&self.shapes(), &mut Linear::default(), finely, &|_| false)
    }

    /// The same without the rows of the constraints on the `border`; the vertices that they touch are among the columns. `shapes` are
    /// its own, and some rows on them may be `known`.
    pub(crate) fn assemble_beside(
        &self,
        shapes: &Shapes<'_>,
        known: &mut Linear,
        finely: bool,
        border: &dyn Fn(usize) -> bool,
    ) -> Result<Assembly> {
        let constraints = self.bound.iter().map(|bound| &bound.constraint);
        let mut assembly =
            Assembly::beside(shapes, constraints, known, (&self.freedom, &self.metric), border, true)?;
        if finely {
            assembly.decide(System::FINE);
        }
        Ok(assembly)
    }
}
