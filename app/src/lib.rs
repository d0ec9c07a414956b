//! Loftsman edits B-spline curves and surfaces under constraints, with the least change that meets them, and hands
//! the result to Blender, MeshLab and CAD.
//!
//! Measured points become a spline, and one of its points is pushed out while nose and trailing edge stay:
//!
//! ```standalone_crate
//! # let folder = std::env::temp_dir().join(format!("loftsman-doctest-{}", std::process::id()));
//! # std::fs::create_dir_all(folder.join("examples"))?;
//! # let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/blade-section");
//! # std::fs::create_dir_all(folder.join("examples/blade-section"))?;
//! # let points = "IEA-15-240-RWT_AF20_Coords.txt";
//! # std::fs::copy(format!("{examples}/{points}"), folder.join("examples/blade-section").join(points))?;
//! # std::env::set_current_dir(&folder)?;
//! use loftsman::prelude::*;
//!
//! let mut scene = loftsman::read_scene("examples/blade-section/IEA-15-240-RWT_AF20_Coords.txt")?;
//! scene.rename("IEA-15-240-RWT_AF20_Coords", "section")?;
//! let measured = scene.object("section")?.geometry().points();
//! let section = Fit::new(3, Target::Tolerance(1e-4)).curve(measured)?.curve;
//!
//! let thicker = Edit::new(&section)
//!     .ask(position(0.75).by([0.0, 0.03, 0.0]))   // push this point out,
//!     .ask(position(0.5).keep())                  // leave the nose where it is,
//!     .ask(tangent(0.5).keep())                   // as it points
//!     .ask(curvature(0.5).keep())                 // and as round as it is,
//!     .lock([0, -1])                              // and the trailing edge;
//!     .metric(Metric::Bend)                       // of all ways, bend least.
//!     .solve()?;
//!
//! println!("{}", thicker.report());               // rank 11 of 13 · residual 2.2e-16 · ‖d‖ 0.0777 · …
//! scene.replace("section", thicker.shape())?;
//! loftsman::write(&scene, "section.obj")?;
//! # let (before, after) = (section.point(0.75)?, thicker.shape().point(0.75)?);
//! # assert!((after - before - Vector::new(0.0, 0.03, 0.0)).norm() < 1e-14);
//! # assert!((thicker.shape().point(0.5)? - section.point(0.5)?).norm() < 1e-14);
//! # let bend = |c: &Curve| Ok::<_, Box<dyn std::error::Error>>(c.derivative(0.5, 1)?.cross(&c.derivative(0.5, 2)?));
//! # assert!((bend(thicker.shape())? - bend(&section)?).norm() < 1e-9 * bend(&section)?.norm());
//! # assert_eq!(thicker.shape().point(0.0)?, section.point(0.0)?);
//! # let back = loftsman::read_scene("section.obj")?;
//! # let turned = Vector::new(after.x, after.z, -after.y); // OBJ is y-up
//! # assert!((back.curve("section")?.point(0.75)?.coords - turned).norm() < 1e-12);
//! # std::fs::remove_dir_all(folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This crate is the facade: it re-exports the [`kernel`], the formats and the plug-ins, reads and writes files
//! ([`read`](fn@read), [`write`](fn@write)), runs [recipes](recipe), and is the program `loftsman`.
//!
//! | question | answer |
//! |---|---|
//! | the names that most programs want | [`prelude`] |
//! | a file's scene, a scene's file, several files or none | [`mod@file`] |
//! | steps in TOML or JSON | [`recipe`] |
//! | what is in a scene | [`describe`] |
//! | a file in another format | [`convert`](fn@convert), [`mod@convert`] |
//! | do the solvers agree | [`mod@compare`] |
//! | the command line with a registry of one's own | [`program`] |
//! | what is known by name, and how to add to it | [`registry`](fn@registry), [`BuiltIn`] |

mod built_in;
pub mod compare;
pub mod convert;
pub mod describe;
pub mod document;
mod error;
mod facts;
pub mod file;
pub mod measures;
#[cfg_attr(not(feature = "picture"), path = "no_picture.rs")]
pub mod picture;
mod picture_name;
mod placed;
pub mod prelude;
pub mod program;
pub mod recipe;
mod recipe_error;
mod registry;
mod words;

pub use built_in::{read, read_scene, write};
pub use convert::convert;
pub use error::{Error, Result};
pub use file::{read_with, write_with};
pub use loftsman_area_volume as area_volume;
pub use loftsman_construction as construction;
pub use loftsman_dynamics as dynamics;
pub use loftsman_editing as editing;
pub use loftsman_fairing as fairing;
pub use loftsman_fine_tuning as fine_tuning;
pub use loftsman_fitting as fitting;
pub use loftsman_gltf as gltf;
#[cfg(feature = "iges")]
pub use loftsman_iges as iges;
pub use loftsman_intersection as intersection;
pub use loftsman_kernel as kernel;
pub use loftsman_kernel::nalgebra;
pub use loftsman_matching as matching;
pub use loftsman_native as native;
pub use loftsman_obj as obj;
pub use loftsman_points as points;
pub use loftsman_regions as regions;
#[cfg(feature = "step")]
pub use loftsman_step as step;
pub use loftsman_subdivision as subdivision;
pub use loftsman_tessellation as tessellation;
pub use registry::{BuiltIn, registry};

/// The library's page of the manual, whose examples are tested.
#[cfg(doctest)]
#[doc = include_str!("../../docs/manual/src/library.md")]
struct Manual;

#[cfg(test)]
mod tests {
    /// What the README shows is what the documentation tests, line for line.
    #[test]
    fn the_example_of_the_readme_is_the_tested_one() {
        let readme = include_str!("../../README.md");
        let shown: Vec<&str> =
            readme.split("```rust\n").nth(1).unwrap().split("```").next().unwrap().lines().collect();
        let documented =
            include_str!("lib.rs").lines().skip_while(|l| !l.contains("```standalone_crate")).skip(1);
        let tested: Vec<&str> = documented
            .map(|l| l.trim_start_matches("//!").strip_prefix(' ').unwrap_or(""))
            .take_while(|l| !l.starts_with("```"))
            .filter(|l| !l.starts_with("# "))
            .collect();
        assert_eq!(tested, shown);
    }
}
