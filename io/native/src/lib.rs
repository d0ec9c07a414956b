//! The native document format, `*.loft.json`: JSON that keeps every number to the last bit.
//!
//! ```json
//! { "loftsman": 1, "unit": "mm", "up": "z",
//!   "objects": [
//!     { "name": "section", "color": [0.8, 0.2, 0.1, 1.0], "layer": "frames",
//!       "curve": { "degree": 1, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [1, 0, 0]], "weights": [1, 2] } } ] }
//! ```
//!
//! A document has the fields `loftsman` (the version, 1), `unit` (default `"m"`), `up` (default `"z"`), `layers`, `images` and
//! `materials` (optional), `statements`, `definitions` and `connections` (optional), and `objects`. An object has a `name`, exactly one geometry, and may have more:
//!
//! | field | value |
//! |---|---|
//! | `curve` | `degree`, `periodic` (default false), `knots`, `points`, `weights` (optional) |
//! | `surface` | `u` and `v` (each `degree`, `periodic`, `knots`), `points` and `weights` in rows along `u` |
//! | `trimmed` | `surface`, `regions` (each `outer` and `holes`), `curves`, `points`, as below |
//! | `brep` | `vertices`, `edges`, `faces`, `shells`, `solids`, as below |
//! | `mesh` | `points`, `faces` (indices from 0), and what is said below |
//! | `polyline` | `points`, `closed` (default false) |
//! | `cloud` | `points` |
//! | `shape` | a plug-in's shape: `kind`, the name of its kind, and the fields that this has |
//! | `group` | `{}`: nothing of its own, others hang under it |
//! | `instance` | `definition`: the name of the definition whose objects are all shown here |
//! | `same_as` | `object`: the name of an object before it, of the same list, whose geometry it has too; with `definition`, of that definition |
//! | `color` | `[red, green, blue, alpha]` |
//! | `materials` | the names of its materials; the faces of a mesh say which, all else has the first |
//! | `label` | what it is called where it comes from, where others are called so too |
//! | `layer` | the name of its layer, whether that is among `layers` or not |
//! | `statements` | pairs of texts: what other formats say that the document has no field for, word for word |
//! | `parent` | the name of the object it hangs under |
//! | `transform` | four rows of four numbers, the last `[0, 0, 0, 1]`: own coordinates to the parent's |
//! | `animation` | `rate` (frames a second) and `frames`, each all points of the object, in their order |
//!
//! A definition has a `name`, `statements` (optional) and `objects`, which are as above; their names and parents are its
//! own. Its objects may be instances of other definitions, but not of one that shows it. Geometry that
//! objects share is written once, and as `same_as` from then on; they share it again when they are read.
//!
//! A `unit` is one of `nm`, `um`, `mm`, `cm`, `dm`, `m`, `km`, `mil`, `in`, `ft`, `us-ft`, `yd`, `mi`, any number of metres
//! (`"0.3 m"`), or `"unknown"`.
//!
//! A layer has a `name`, and may have a `color` (of what is on it and has none), `visible` (`false` hides it and all layers below
//! it) and a `parent`, the layer below which it lies. A layer of which there is no more to say than its name need not be there.
//!
//! A shape whose `kind` no plug-in here knows is kept word for word and written again as it was; the reports say so.
//!
//! An open shape has `points + degree + 1` knots, a periodic one `points + 1` over one period. Unknown fields,
//! and anything else that a reader would have to guess, are errors that name the place.
//!
//! *Trimmed surfaces and Breps.* A piece of a curve in a parameter plane has a `curve`, whose points are `[u, v, 0]`, and `from` and `to` on it. Loops
//! of a trimmed surface, and its special `curves`, are lists of pieces, its special `points` pairs. What a Brep is made of names one another by numbers
//! from 0:
//!
//! | list | each entry |
//! |---|---|
//! | `vertices` | `at`, `tolerance` (0 if left out) |
//! | `edges` | `curve`, `from` and `to` on it (all of it if left out; on a periodic curve the end may be up to a period behind the start), `vertices` at its start and end, `tolerance`, `form` |
//! | `faces` | `surface`, `loops` (each a list of `edge`, `reversed`, and `parameters`, the piece that the edge is in the parameter plane, where known), `reversed`, `form`, `name`, `color`, `points` (vertices alone in it) |
//! | `shells` | a list of faces |
//! | `solids` | `outer` and `voids`, shells; `name` |
//!
//! A `form` says what a curve or surface is beside a spline, to rounding: a `kind`, and but for `"line"` where it is (`origin`, `x` and the
//! axis `z`, of unit length): `"circle"`, `"cylinder"` and `"sphere"` have a `radius`, `"ellipse"` `radii`, `"cone"` `radius` and `angle` (half of it, in radians),
//! `"torus"` `major` and `minor`, `"plane"` no more, `"parabola"` its `focal` length, `"hyperbola"` `radii` as the ellipse. An `"extrusion"` has the vector
//! `along` instead of a place, a `"revolution"` its axis `z`; both the form of the swept curve as their `profile`, where that is more than a spline. A curve that is an object
//! may have a `form`, too, of a line or conic; there it says as well which piece, `from` and `to`: angles of a circle or ellipse from `x` on, `t` of `f t² x + 2 f t y` (parabola) or of
//! `a cosh t x + b sinh t y` (hyperbola), the second more than the first, `y` being `z` × `x`. A surface
//! that is an object may have one of a plane, cylinder, cone, sphere or torus, with the ranges `u` and `v` of its parameters on that: of a plane lengths along `x` and `y`, else angles about `z` from `x` on, and
//! heights along `z` (cylinder, cone), latitudes (sphere) or angles around the tube from outside (torus); the second less than the first where the spline runs the other way. A form that is not that of the spline, to rounding, is refused. Loops that do not close, and solids whose shells do not, are errors.
//!
//! A mesh may have the layers `normals`, `tangents` (`[x, y, z, sign]`), `uvs`, `more_uvs` (a list of layers) and `colors` (linear red, green, blue,
//! alpha). A layer is a list, one value a point, or a table `{ "values": […], "corners": […] }` with the index of the
//! value of each corner, face after face, -1 for none. It may have `lines` (chains of point indices), and for each
//! face a number in `materials` (an entry of the object's list) and in `smoothing` (a group, 0 for flat), and
//! `groups`, each a `name` and `faces` in ascending order.
//!
//! An image has a `name`, and either `file` (a name relative to the document's folder) or `media_type` and `base64`.
//! A picture that is a file goes along when a document is written elsewhere.
//! A material has:
//!
//! | field | value |
//! |---|---|
//! | `name` | by which objects name it |
//! | `base_color`, `metallic`, `roughness` | linear red, green, blue, alpha; 0 to 1; 0 to 1 (1, 0 and 0.5 if left out) |
//! | `emissive` | linear red, green, blue |
//! | `alpha_cutoff`, or `blend` | opaque from that alpha on, or `true` for see-through; opaque without both |
//! | `double_sided` | `true` or `false` |
//! | `textures` | each with its `channel` (`base_color`, `metallic_roughness`, `normal`, `occlusion`, `emissive`) or `other` (a format's name for it), the `image`, and optional `set`, `strength`, `offset`, `tiling`, `rotation`, `wrap` (two of `repeat`, `mirror`, `clamp`), `magnify` and `minify` (`nearest`, `linear`, `nearest_of_nearest`, `linear_of_nearest`, `nearest_of_mixed`, `linear_of_mixed`) |
//! | `statements` | pairs of texts that a format keeps for itself |
//!
//! Reading and writing are linear in the size of the file and keep one object at a time besides the scene.

mod format;
mod names;
mod read;
mod unknown;
mod write;

pub use format::{Native, Native as Plugin, VERSION};
