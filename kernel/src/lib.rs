//! The kernel of Loftsman: the vocabulary (splines, meshes, scenes), the interfaces (shapes, functionals,
//! solvers, formats, operations) and the classical solvers.
//!
//! One sentence holds it together: everything that depends linearly on its control vertices is a
//! [`Shape`](shape::Shape); everything we may ask of a shape is a [`Functional`](functional::Functional); a
//! problem is shapes and functionals; a [`Solver`](solve::Solver) turns it into the least adjustment; a
//! [`Format`](plugin::Format) brings shapes in and takes them out.
//!
//! Most users want the facade crate `loftsman`, which re-exports all of this with a short prelude.

pub mod brep;
pub mod conformance;
mod declare;
mod direction;
pub mod edit;
pub mod energy;
pub mod error;
pub mod functional;
mod kind;
pub mod material;
pub mod measure;
pub mod mesh;
pub mod named;
pub mod parallel;
pub mod plugin;
pub mod problem;
mod quadrature;
pub mod scene;
pub mod shape;
pub mod solve;
pub mod space;
pub mod spline;
mod tessellator;
pub mod text;
pub mod topology;
mod unit;

pub use direction::direction;
pub use error::{Error, Result};
/// The crate of points, vectors and matrices here: who uses this one has the version that fits.
pub use nalgebra;
pub use scene::{connection, placement};

/// A position in space. A planar shape has `z = 0`.
pub type Point = nalgebra::Point3<f64>;

/// A displacement, a derivative or a direction in space.
pub type Vector = nalgebra::Vector3<f64>;
