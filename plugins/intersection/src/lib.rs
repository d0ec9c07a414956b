//! Where curves meet curves, surfaces and planes, and sections of surfaces and meshes by planes.
mod certificate;
mod error;
mod intersections;
mod meeting;
mod net;
mod pair;
mod pieces;
mod search;
mod together;
pub use error::{IntersectionError, Result};
pub use intersections::{Contact, Intersections, Meeting, Options, Overlap, Plane, Undecided};
pub use pair::{curve_surface, curves};
