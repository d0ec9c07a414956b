//! The tests of this crate, as one program.

mod adaptive;
mod certified;
mod closed;
mod creased_normals;
mod doo_sabin;
mod doo_sabin_intervals;
mod doo_sabin_patches;
mod doo_sabin_surface;
mod editing;
mod elevated;
mod golden;
mod hostile;
mod intervals;
mod joins;
mod kind;
mod limits;
mod natural;
mod operation;
mod patches;
mod polygons;
mod refinement;
mod rows;
mod shapes;
mod surface;
mod ten_levels;
mod uneven;
