//! Catmull-Clark surfaces: bicubic splines where the cage is a grid, smooth everywhere else, with creases and knot intervals.
//!
//! A cage with intervals is refined by those of Sederberg, Zheng, Sewell and Sabin (1998), one without by the rules of Catmull and
//! Clark (1978); both with the creases of DeRose, Kass and Truong (1998), edge children having one less sharpness (OpenSubdiv's
//! `CREASE_UNIFORM`).

mod limit;
mod masks;
mod patch;
mod refine;
mod refinement;
mod ring;
mod rules;
mod sides;
mod uneven;
pub(crate) mod weights;

pub use limit::{all_limit_stencils, limit_frames, limit_points, limit_stencils, sectors};
pub(crate) use limit::{is_uniform, limit_frames_of, limit_position};
pub use patch::{patch, patch_stencils};
pub(crate) use refine::refined_intervals;
pub use refine::{refine, refine_times};
pub use refinement::Refinement;
pub use sides::limit_normals;
pub(crate) use sides::{is_alike, side_normals};
