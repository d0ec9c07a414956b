//! Loftsman edits splines under constraints and hands them to Blender, MeshLab and CAD.
//!
//! This crate is the facade: it re-exports the [`kernel`], reads and writes files ([`read`](fn@read),
//! [`write`](fn@write)), runs [recipes](recipe) and is the program `loftsman`.

pub mod compare;
pub mod convert;
pub mod describe;
mod error;
pub mod file;
pub mod picture;
pub mod prelude;
pub mod recipe;
mod registry;

pub use error::{Error, Result};
pub use file::{read, read_with, write, write_with};
pub use loftsman_editing as editing;
pub use loftsman_fitting as fitting;
pub use loftsman_kernel as kernel;
pub use loftsman_gltf as gltf;
pub use loftsman_native as native;
pub use loftsman_obj as obj;
pub use loftsman_points as points;
pub use loftsman_tessellation as tessellation;
pub use registry::{BuiltIn, registry};
