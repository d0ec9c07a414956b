//! What may be asked of shapes: functionals.
//!
//! A functional is a number, or several, that a shape has: where it passes, how it is directed, how much area
//! it encloses. It is written once and works on every [`Shape`](crate::shape::Shape).

mod at;
mod checked;
mod curvature;
mod derivative;
mod evaluate;
mod jet;
mod join;
mod linear;
mod magnitude;
mod normal;
mod on;
mod orthogonal;
mod position;
mod rows;
mod shapes;
mod signed_curvature;
mod symmetry;
mod tangent;
mod vertex;

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

pub use at::{At, near};
pub(crate) use checked::{equations_of, usable};
pub use checked::{linearize_of, rows_of, value_of};
pub use curvature::{Curvature, curvature};
pub use derivative::{DerivativeAt, derivative};
pub use evaluate::{Evaluate, Numbers};
pub use join::{Edge, Join, Place, join};
pub use linear::{Linear, linear};
pub use magnitude::{Magnitude, magnitude};
pub use normal::{Normal, normal, present_normal};
pub use on::On;
pub use orthogonal::{Orthogonal, orthogonal};
pub use position::{Position, position};
pub use rows::{Equation, Rows, Store};
pub use shapes::Shapes;
pub use signed_curvature::{SignedCurvature, signed_curvature};
pub use symmetry::{Symmetry, symmetry};
pub use tangent::{Tangent, tangent};
pub use vertex::{VertexAt, vertex};

use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Derivative, Location};

/// How a functional depends on the control vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Linearity {
    /// `f(P) = Σ a_i·P_i + c`.
    Linear,
    /// Linear in each axis while the other axes are held (area, volume).
    Multilinear,
    /// Anything else with a gradient.
    Nonlinear,
}

/// How well an equation holds that is said to hold. Whoever hands out an answer has it measured afresh, and judged by this.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Accuracy {
    /// To rounding, at the size of the coordinates and targets that went in.
    #[default]
    Rounding,
    /// To this, absolutely: in the units of the functional's value.
    Within(f64),
}

impl Accuracy {
    /// What it adds to rounding, in the units of the functional's value.
    pub fn tolerance(self) -> f64 {
        match self {
            Self::Rounding => 0.0,
            Self::Within(tolerance) => tolerance,
        }
    }
}

/// What a functional has become, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Told {
    /// What was found: `position 0.0012, angle 0.03°`.
    pub found: String,
    /// What to do where that is too much.
    pub remedy: String,
}

/// Something that may be asked of shapes: `f(P)`, one number or several.
pub trait Functional: Any + Debug + Send + Sync {
    /// How many numbers it is.
    fn equations(&self) -> usize;

    /// How it depends on the control vertices.
    fn linearity(&self) -> Linearity;

    /// Appends its linearization at the shapes' present state: [`equations`](Self::equations) rows of partial
    /// derivatives with respect to control vertices, and for linear functionals the constant as well.
    ///
    /// # Errors
    /// When the functional cannot be asked of these shapes (a location outside the domain, a tangent that
    /// vanishes, …).
    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()>;

    /// Its present value, [`equations`](Self::equations) numbers. For a linear functional the default, rows
    /// times vertices plus constants, is right.
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let mut store = Store::default();
        self.rows(shapes, &mut store.rows(shapes))?;
        store.evaluate(shapes, out);
        Ok(())
    }

    /// Value and linearization at once, for functionals that share most of the work between the two; what Newton's
    /// iteration asks for. By default [`value`](Self::value), then [`rows`](Self::rows).
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        self.value(shapes, value)?;
        self.rows(shapes, rows)
    }

    /// Whether values like `wanted` can be had where those at the start are `present` (both as many as it has
    /// equations): an area of the other sign cannot. By default everything finite can.
    ///
    /// # Errors
    /// Naming what is wanted, and what to do.
    fn check_target(&self, present: &[f64], wanted: &[f64]) -> Result<()> {
        let _ = (present, wanted);
        Ok(())
    }

    /// What it is, for people and reports: `position at 0.25`.
    fn describe(&self) -> String;

    /// Whether another functional is of the same thing: asking for it leaves no say to this one. By default one of the same type
    /// and name ([`describe`](Self::describe)).
    fn same_as(&self, other: &dyn Functional) -> bool {
        self.type_id() == other.type_id() && self.describe() == other.describe()
    }

    /// Functionals that should stand still beside this one; each is kept unless the edit asks for the
    /// [same thing](Self::same_as) itself (of a vector of which only some axes are asked, the others are kept), or for something
    /// that [supersedes](Self::supersedes) it. Where this one means something else then, [`beside`](Self::beside) says what to
    /// ask. None by default.
    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        Vec::new()
    }

    /// Whether a companion of another functional is not to be kept because this one changes what it holds: the length of a
    /// tangent cannot be scaled while the first derivative stands still. Only asked where this one is to change. The
    /// [same thing](Self::same_as) always gives way.
    fn supersedes(&self, companion: &dyn Functional) -> bool {
        let _ = companion;
        false
    }

    /// The functional to ask instead where not all of its companions stand still, as `stands_still` tells of each: curvature
    /// is linear only while the first derivative stays. `None` (the default) where that does not matter.
    fn beside(&self, stands_still: &dyn Fn(&dyn Functional) -> bool) -> Option<Arc<dyn Functional>> {
        let _ = stands_still;
        None
    }

    /// As many numbers as it has equations from fewer that say the same: a curvature in its present plane is one number.
    /// Asked of values to have and of changes; `None` (the default) where all numbers must be given.
    fn complete(&self, given: &[f64]) -> Option<Vec<f64>> {
        let _ = given;
        None
    }

    /// The functional with everything that it takes from the shapes' state at the start of an edit made fixed
    /// (a direction to keep, vertices paired by position); `None` where there is nothing to fix.
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let _ = shapes;
        Ok(None)
    }

    /// Where on which shape it looks, where it is one place.
    fn location(&self) -> Option<(usize, Location)> {
        None
    }

    /// Whether its location floats: the parameters are then unknowns of the problem, beside the control vertices and without
    /// weight. A session asks for it [moved](Self::moved) to where it finds the adjustment least. False by default.
    fn floats(&self) -> bool {
        false
    }

    /// The same at another location of the same shape, come to rest there if it floats; `None` (the default) where it cannot
    /// move.
    fn moved(&self, to: Location) -> Option<Arc<dyn Functional>> {
        let _ = to;
        None
    }

    /// Moves this one itself to another location of the same shape, where it floats on; false (the default) where it cannot. For those
    /// who follow a location through thousands of steps, which must allocate nothing.
    fn slide(&mut self, to: Location) -> bool {
        let _ = to;
        false
    }

    /// The derivative of its value along its location, into `out` (as many numbers as it has equations): by `order.u` times the
    /// first parameter and `order.v` times the second. For those that can be [moved](Self::moved). By default what
    /// [`along_rows`](Self::along_rows) make of the control vertices, which is right for linear ones; those who follow a location
    /// through thousands of steps want it without allocating.
    ///
    /// # Errors
    /// As for [`along_rows`](Self::along_rows).
    fn along(&self, shapes: &Shapes<'_>, order: Derivative, out: &mut [f64]) -> Result<()> {
        let mut store = Store::default();
        self.along_rows(shapes, order, &mut store.rows(shapes))?;
        store.evaluate(shapes, out);
        Ok(())
    }

    /// The derivative of its [rows](Self::rows) along its location, as many: by `order.u` times the first parameter and `order.v` times
    /// the second. For linear ones that can be [moved](Self::moved).
    ///
    /// # Errors
    /// By default: how it changes along its shape is not known. As for [`rows`](Self::rows).
    fn along_rows(&self, shapes: &Shapes<'_>, order: Derivative, rows: &mut Rows<'_>) -> Result<()> {
        let _ = (shapes, order, rows);
        Err(Error::Invalid(format!(
            "{} cannot move along its shape: how it changes there is not known",
            self.describe()
        )))
    }

    /// The highest derivative of its shape that it takes at its location, along one parameter: 0 (the default) where it looks at points
    /// alone. Where that derivative jumps, or bends sharply, so does its value along the shape.
    fn takes_derivatives(&self) -> usize {
        0
    }

    /// Whether it names control vertices of shape `shape` of the problem by their numbers: then it means others once knots
    /// are inserted there. False by default.
    fn by_number(&self, shape: usize) -> bool {
        let _ = shape;
        false
    }

    /// Whether it is a condition, which holds where its value is zero, so that nothing more need be said
    /// (parallel to a direction, symmetric, joined).
    fn is_condition(&self) -> bool {
        false
    }

    /// For a [condition](Self::is_condition) whose numbers mean nothing to people, so that nothing but zero can be asked of
    /// them: what to ask instead. `None` by default.
    fn only_holds(&self) -> Option<&'static str> {
        None
    }

    /// Why no control vertex of shapes like these has any influence on it, wherever they are, and what to do: the fourth derivative of
    /// a cubic. Then nothing can be asked of it, not even to stay. `None` (the default) where that does not happen by itself.
    fn powerless(&self, shapes: &Shapes<'_>) -> Option<String> {
        let _ = shapes;
        None
    }

    /// What keeps a value like `wanted` out of reach of shapes like these, and what would have to give way: a curve is no shorter than
    /// its ends are apart. For the message of an edit that failed; `None` (the default) where nothing is known.
    fn out_of_reach(&self, shapes: &Shapes<'_>, wanted: &[f64]) -> Option<String> {
        let _ = (shapes, wanted);
        None
    }

    /// The power of length that its values have, for reports with units: 1 for a place or a length, 2 for an area, 3 for a volume, 0 for
    /// numbers without a unit. `None` (the default) where that is not known, or where they are not all alike.
    fn dimension(&self) -> Option<u8> {
        None
    }

    /// What it is in Rust, for messages about functionals that are wrong.
    fn type_name(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// How well its equations hold where they are said to. To rounding by default.
    fn accuracy(&self) -> Accuracy {
        Accuracy::Rounding
    }

    /// What a look at it takes at most, in evaluations of its shapes, for functionals that take thousands of them (quadrature
    /// that adapts itself to the shape): an edit that such a constraint does not let arrive is given up the sooner, the more
    /// each look takes. None (the default) is too little to count.
    fn effort(&self) -> usize {
        0
    }

    /// The same condition elsewhere: for a condition that is meant along an edge but imposed at some places of it, a
    /// functional that looks *between* these places. Its value, zero where it holds, is measured on what is handed out
    /// and judged by its own [`accuracy`](Self::accuracy). `None` (the default) where the equations say all there is.
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn witness(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let _ = shapes;
        Ok(None)
    }

    /// What else there is to say of what it asks (what is given up so that it can hold), for the report. Nothing by default.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// What it has become on shapes, in quantities that people know (angles, parts of a curvature), where its equations are made of
    /// others: for the report, and for the error where it does not hold. `None` (the default) where its value says all.
    ///
    /// # Errors
    /// As for [`rows`](Self::rows).
    fn told(&self, shapes: &Shapes<'_>) -> Result<Option<Told>> {
        let _ = shapes;
        Ok(None)
    }

    /// Whether its equations are one vector's x, y and z, so that it can be narrowed to an axis and be given a
    /// vector as target.
    fn is_vector(&self) -> bool {
        false
    }
}

/// Whether a functional equals one whose type is known.
fn equals<F: Functional + PartialEq>(one: &F, other: &dyn Functional) -> bool {
    let any: &dyn Any = other;
    any.downcast_ref::<F>() == Some(one)
}

/// Resolves names of objects in a recipe to shapes of the problem.
pub trait ShapeNames {
    /// The number of the shape in the problem ([`Shapes`]); it is added to the problem where needed.
    ///
    /// # Errors
    /// When there is no such object or it is not an editable shape.
    fn shape(&mut self, object: &str) -> Result<usize>;

    /// The name of a shape that is in the problem already (0 is the step's own object), where it is known.
    fn name(&self, shape: usize) -> Option<&str> {
        let _ = shape;
        None
    }
}

/// A functional that recipes can ask for by name.
pub trait DeclaredFunctional: Functional + Sized + 'static {
    /// Its name, help and fields.
    const DECLARATION: Declaration;

    /// The functional that the fields describe. The fields have been checked against the declaration.
    ///
    /// # Errors
    /// When a field's value is wrong.
    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError>;
}
