//! The interfaces that other crates fill, and the registry that holds what they bring.
//!
//! A [`Plugin`] registers [`Format`]s, [`Operation`]s, kinds of functional and of shape, and solvers with a
//! [`Registry`]; there is no link-time magic. Each comes with a [`Declaration`] of its fields, from which help, checks
//! of unknown fields and `loftsman plugins` are made.

mod change;
mod constraints;
mod format;
mod frames;
mod functionals;
mod mark;
mod operation;
mod registry;
mod step;

pub use crate::declare::{Declaration, Field, ParameterError, Parameters, Table, hint, nearest};
pub use crate::kind::{CustomShape, DeclaredShape, Drawn, Faceted, KindOf, ShapeKind, Splines, sampled};
pub use crate::problem::{ConstraintReport, Convergence, Corner, Name, Smoothness};
pub use crate::tessellator::{
    Apart, Beside, Chord, Fineness, MovingLine, MovingMesh, Tessellated, TessellatedBrep, Tessellator,
};
pub use change::{AskedQuantity, ChangeKind, Measured, ObjectChange};
pub(crate) use constraints::{EVERYWHERE, WISHES};
pub use constraints::{constraint_from, functional_from};
pub use format::{
    Confidence, Cuts, Fate, Format, FormatDeclaration, FormatError, FormatErrorKind, Holds, InWorld, Limits,
    Memory, MeshPart, Outgoing, Place, ReadOptions, ReadReport, Sink, Source, UnitRule, UpChoice,
    WriteOptions, WriteReport, Written, refuse_utf16, utf8,
};
pub use frames::{Frames, asked_in_own_coordinates, in_own_coordinates};
pub use functionals::register_functionals;
pub use mark::{Mark, MarkKind, Spot, Track};
pub use operation::{
    Cancelled, Clock, Context, NoClock, Observer, Operation, OperationError, Quiet, StepReport,
};
pub use registry::{Plugin, Registry};
pub use step::{
    SceneShapes, SeenShapes, ask_once, editable, object_among, object_name, object_names, other_object_name,
    put_back, shape_of,
};
