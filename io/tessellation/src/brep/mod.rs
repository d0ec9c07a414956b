//! Breps and trimmed surfaces as triangles.
//!
//! Each edge is cut once, by its own bend and by what the faces along it bend there (`cut`), and its points are on the surfaces of these
//! by their feet. In the plane of each surface's parameters chords, seams, creases and poles are laid out (`arrange`) and joined into a
//! constrained Delaunay triangulation (`plane`; crate `spade`, whose predicates are exact, so that no loop of real files makes it
//! fail), which is refined (`fill`) until every triangle is certified from bounds (`bounds`) of the second derivatives. Edges are never cut
//! there, so that faces are worked on side by side.

mod arrange;
mod assemble;
mod bounds;
mod carrier;
mod cut;
mod fill;
mod plane;
mod solid;
mod trimmed;

pub(crate) use solid::mesh;
pub(crate) use trimmed::mesh as trimmed_mesh;
