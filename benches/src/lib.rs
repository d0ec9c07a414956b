//! What the benches share: [`inputs`] defined by formulas, [`shapes`] made of them and of files, plain [`floor`] references, and how to [`measure`]; for meshes
//! their [`deviation`].
//!
//! Each file under `benches/` asks one question and puts Loftsman, its peers and a floor side by side on the same
//! input in the same run: on shared machines only ratios taken in one run mean anything. The floor is a plain
//! scalar program for just that input, with no checks, no report and nothing general: what the structure allows.

pub mod deviation;
pub mod floor;
pub mod inputs;
pub mod measure;
pub mod shapes;
