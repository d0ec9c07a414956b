//! Where curves meet curves, surfaces and planes, and sections of surfaces and meshes by planes.
//!
//! | question | answer |
//! |---|---|
//! | where do two curves meet | [`curves`] |
//! | where does a curve meet itself | [`self_intersections`] |
//! | where does a curve meet a surface | [`curve_surface`] |
//! | where does a curve meet a plane | [`curve_plane`] |
//! | the section of a surface by a plane | [`section`](fn@section) |
//! | of a Brep, or of a trimmed surface | [`brep_section`], [`trimmed_section`] |
//! | the section of a mesh by a plane, its area, and where its loose lines meet it | [`mesh_section`], [`mesh_section_area`], [`mesh_section_above`], [`mesh_lines_section`] |
//! | the same in a recipe | the operations `intersect` ([`Intersect`]) and `section` ([`CutBy`]) |
//!
//! Answers say how sure they are: which places, how far apart the shapes are there (measured on them), whether they cross,
//! touch or run together, and what could not be decided.

mod bernstein;
mod certificate;
mod contact;
mod error;
mod gap;
mod intersections;
mod itself;
mod limits;
mod meeting;
mod mesh;
mod net;
mod operations;
mod pair;
mod pieces;
mod plane;
mod search;
mod section;
mod together;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use error::{IntersectionError, Result};
pub use gap::{Gap, gap_of_curve_and_surface, gap_of_curves};
pub use intersections::{Contact, Intersections, Meeting, Options, Overlap, Plane, Undecided};
pub use itself::self_intersections;
pub use mesh::{LineMeetings, mesh_lines_section, mesh_section, mesh_section_above, mesh_section_area};
pub use operations::{CutBy, Intersect};
pub use pair::{curve_surface, curves};
pub use plane::curve_plane;
pub use section::{Section, SectionCurve, ShellCurve, ShellSection, brep_section, section, trimmed_section};

/// Registers `intersect` and `section`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Intersection;

impl Plugin for Intersection {
    fn register(&self, registry: &mut Registry) {
        registry.operation(Intersect);
        registry.operation(CutBy);
    }
}
