//! The native document format, `*.loft.json`: JSON that keeps every number to the last bit.
//!
//! ```json
//! { "loftsman": 1, "unit": "mm", "up": "z",
//!   "objects": [
//!     { "name": "section", "color": [0.8, 0.2, 0.1, 1.0], "layer": "frames",
//!       "curve": { "degree": 1, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [1, 0, 0]], "weights": [1, 2] } } ] }
//! ```
//!
//! A document has the fields `loftsman` (the version, 1), `unit` (default `"m"`), `up` (default `"z"`) and
//! `objects`. An object has a `name`, exactly one geometry, and may have more:
//!
//! | field | value |
//! |---|---|
//! | `curve` | `degree`, `periodic` (default false), `knots`, `points`, `weights` (optional) |
//! | `surface` | `u` and `v` (each `degree`, `periodic`, `knots`), `points` and `weights` in rows along `u` |
//! | `mesh` | `points`, `faces` (indices from 0), and one a point `normals`, `uvs`, `colors` (optional) |
//! | `polyline` | `points`, `closed` (default false) |
//! | `cloud` | `points` |
//! | `group` | `{}`: nothing of its own, others hang under it |
//! | `color` | `[red, green, blue, alpha]` |
//! | `layer` | a text |
//! | `parent` | the name of the object it hangs under |
//! | `transform` | four rows of four numbers, the last `[0, 0, 0, 1]`: own coordinates to the parent's |
//! | `animation` | `rate` (frames a second) and `frames`, each all points of the object, in their order |
//!
//! An open shape has `points + degree + 1` knots, a periodic one `points + 1` over one period. Unknown fields,
//! and anything else that a reader would have to guess, are errors that name the place.
//!
//! Reading and writing are linear in the size of the file and keep one object at a time besides the scene.

mod format;
mod read;
mod write;

pub use format::{Native, NativePlugin as Plugin, VERSION};
