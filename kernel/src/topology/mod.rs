//! Which edges are one: where surfaces meet, whether they close, and how two edges lie to one another.
//!
//! Everything here is written on the [edges](crate::shape::Edges) that shapes have, whatever shapes these are. Three questions are
//! asked of edges:
//!
//! * Do some surfaces *close*, edge to edge, and which control vertices stay together then? [`Shell`], with edges compared
//!   exactly, as [curves](EdgeCurve) in the space that holds both.
//! * Which shapes *hang together*? [`CommonEdges`], with edges compared at some of their points; which surfaces of a scene do, also where an
//!   edge is another one as a set of points only, [`Scene::joined`](crate::scene::Scene::joined).
//! * How are two given edges *run through* side by side, and in which space can they be made one? `Pair`, for joins.

mod common_edges;
mod edge_curve;
mod nearby;
pub(crate) mod pair;
mod shell;
pub(crate) mod side;

pub(crate) use common_edges::Groups;
pub use common_edges::{CommonEdges, SAMPLES};
pub use edge_curve::{EdgeCurve, Match, coincide};
pub(crate) use nearby::Nearby;
pub use shell::{Member, Shell, Tie};
pub(crate) use {pair::Pair, side::SurfaceEdge};

/// Edges, ends and parameters nearer than this, of the size of the whole, are one.
pub const TOGETHER: f64 = 1e-9;
