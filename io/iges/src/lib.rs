//! IGES 5.3 (ANS US PRO/IPO-100-1996): curves, surfaces, trimmed surfaces, solids with their faces, groups, subfigures, names, colours,
//! levels and units.
//!
//! **Why by our own code.** The one usable crate drops the trims that OpenCASCADE writes. A file is looked through once for where its
//! lines are and what its directory says; parameters are parsed where an entity is asked for.
//!
//! **Reading.** Shown is what no other entity owns, but for definitions, annotations and curves in parameters. Every entity of the
//! directory is accounted for in the report. What is malformed is left out with its number (`D17`: as others name it) and its line, with what
//! uses it, and the rest is read; a file is an error where its sections cannot be told or nothing of it is left.
//! A file without its terminate section is refused as cut off, unless all that its directory names is there. Where no unit is named lengths
//! are inches, the default of the standard, and the report says so. What is read but not where it should be is noted: edges of solids and shells
//! that are off their surfaces or vertices by more than their tolerance and a ten-thousandth of the size, and loops that lie outside of what the
//! other ones of their face bound.
//!
//! | in the file | becomes |
//! |---|---|
//! | line (110), arc (100), conic (104), offset of these (130), B-spline (126), parametric spline (112), composite (102) | an exact spline |
//! | copious data (106): forms 1–3; 11–13 and 63 | a cloud; a polyline |
//! | points (116) without names | a cloud of those of one layer and colour |
//! | B-spline (128), parametric spline (114), ruled (118), revolved (120), tabulated (122) surface, sphere, torus | an exact spline |
//! | trimmed (144, 142) and bounded (143, 141) surface, bounded plane (108) | a trimmed surface, see below |
//! | solid (186), shell (514), face (510) by themselves | a Brep each, its faces' surfaces with what they are (190–198, 108, 120) |
//! | group (402, forms 1, 7, 14, 15), solid assembly (184) | a group with what is in it |
//! | subfigure (308) that is shown (408) more than once | a definition, and instances of it; shown once, what is in it |
//! | name (406, form 15), else label | the name of an object or a face |
//! | colour (314) or its number | the colour of an object or a face |
//! | level, with its name (406, form 3); blank status | layers, hidden ones |
//! | matrix (124), also in others | baked in; of a subfigure, the transform |
//! | unit, smallest distance | the scene's unit, the tolerance of edges and vertices |
//!
//! A **trimmed surface** has the parameter curves of the file where these run evenly in the spline's parameters, or along one of them, and
//! are not further than a ten-thousandth of its size from the model curves; on a plane, the model curves as they are. Where a file has model
//! curves only, or others than its parameter curves say, the face becomes a Brep of one face, whose edges they are: nothing is approximated,
//! and nothing sewn. Where model curves are torn or missing and parameter curves close, these are taken, fitted within 1e-9 of the surface's size
//! where they run askew over angles; the report says so. A boundary that closes neither way bounds nothing: the whole surface is kept, and the report
//! says so. Parameter curves of the edges of solids are left out: they are computed where they are needed. Offsets of free-form shapes, CSG, finite
//! elements, drawings and annotations are not read.
//!
//! **Writing.** Curves and surfaces as B-splines (126, 128), trimmed surfaces (144) with the curves of their loops in parameters, exactly, and
//! in space (exactly where they run along a parameter, else cubic pieces within 1e-7 of the size), Breps as solids (186) and shells (514) with
//! lines, circles, planes, cylinders, cones, spheres and tori as what they are, polylines as copious data (106, form 12), clouds as groups of
//! points. What hangs under another object is in a group with it; what is placed is a subfigure instance (408) of its parts, and so are
//! instances, whose definition is written once; a transform that is no turn, mirror, scale and shift is baked in. Numbers read back to the
//! same bits. Periodic splines are opened and all are clamped, as other programs take other knots amiss. Units that IGES has not
//! become millimetres.

mod format;
mod read;
mod text;
mod write;

pub use format::{Iges, Iges as Plugin};

/// The system that files which were written here say they come from.
const SYSTEM: &str = "Loftsman";
