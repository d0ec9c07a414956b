//! Subdivision curves and surfaces.

mod cage;
pub mod catmull_clark;
mod error;
mod row;
mod topology;

pub use cage::{BoundaryRule, Cage, INFINITELY_SHARP};
pub use error::{Result, SubdivisionError};
pub use topology::{Around, NONE, Topology};
