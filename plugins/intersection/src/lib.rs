//! Where curves meet curves, surfaces and planes, and sections of surfaces and meshes by planes.
mod bernstein;
mod certificate;
mod error;
mod intersections;
mod meeting;
mod net;
mod pair;
mod pieces;
mod plane;
mod search;
mod section;
mod together;
pub use error::{IntersectionError, Result};
pub use intersections::{Contact, Intersections, Meeting, Options, Overlap, Plane, Undecided};
pub use pair::{curve_surface, curves};
pub use plane::curve_plane;
pub use section::{Section, SectionCurve, section};
