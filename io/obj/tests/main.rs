//! The tests of this crate, as one program.

mod blender;
mod files;
mod hostile;
mod mended;
mod odd;
mod omissions;
mod round_trip;
mod scenes;
mod solids;
mod stable;
