//! STEP (ISO 10303-21, of AP203, AP214 and AP242): curves, surfaces, solids with their faces, assemblies, names, colours, layers
//! and units.
//!
//! **Why by our own code.** What files need of the schemas is a few dozen of their thousands of entities; `step-io`, the best of
//! the crates that read all of them, takes minutes to build, changes its interface from version to version, has no parameter curves and holds
//! the whole file as objects. Here a file is scanned once for where its entities are, and parsed where one is asked for.
//!
//! **Reading.** Every entity is accounted for in the report. What is malformed is left out with its number and line, with the face,
//! curve or solid that uses it, and the rest is read; a file is an error where its text is broken (where it was cut off that says up to which entity it is whole) or nothing of it is left:
//! then the first cause is named, or what stands where geometry should.
//! What is read but not where it should be is noted: edges that are off their surfaces or vertices by more than their tolerance and a ten-thousandth
//! of the size, and loops that lie outside of what the other ones of their face bound.
//!
//! | in the file | becomes |
//! |---|---|
//! | solid, surface model, shell, face | a Brep each; a solid whose shell does not close is kept as its shell, with a note |
//! | plane, cylinder, cone, sphere, torus | an exact rational spline as large as the face needs, and what it is |
//! | surface of revolution, of extrusion | an exact spline, as large as the face needs where it has no ends, and what it is |
//! | offset of an elementary surface | the elementary surface |
//! | line, circle, ellipse, parabola, hyperbola, polyline, trimmed and composite curve | an exact spline, with what it is |
//! | B-spline in any form | itself; curves said to be closed keep the knots that are listed |
//! | parameter curve on a B-spline surface, of an edge that runs along no line of parameters | that of the edge's use, where it is as near as the edge's tolerance says |
//! | B-spline surface that B-splines in its parameters bound | a trimmed surface |
//! | elements of geometric sets | curves, polylines, surfaces; points together as a cloud |
//! | triangulated faces and solids (AP242) | a mesh each; what is read exactly, too, is there once: its tessellation is left out, with a note |
//! | product | an object named after it, a group where it holds several things or others |
//! | product that is used more than once, mapped representation | a definition, and instances of it |
//! | occurrence of a part that is used once | its name, where it is another one than the part's, is kept for STEP |
//! | styled item | the colour of an object or a face |
//! | styled item in the context of an occurrence | the colour of that instance; the part's own becomes that of its other instances |
//! | layer assignment, invisibility | layers, hidden ones |
//! | length unit | the scene's unit; parts in other units are brought to the first one |
//! | uncertainty | the tolerance of edges and vertices |
//!
//! Other parameter curves of edges are left out: they are computed where they are needed, exactly along lines of parameters. Dimensions,
//! annotations and who approved what are not read.
//!
//! **Writing.** AP242. Each object is a product under its name, with its label; groups and definitions are assemblies, instances occurrences of a
//! product that is written once, with colours of their own for what has none; so do objects that share a geometry. Curves, polylines, points, surfaces and trimmed surfaces go into geometric sets, Breps out as solids or surface
//! models, their faces and edges as what they are: planes, cylinders, extrusions and revolutions, lines, circles, conics, else B-splines, with the parameter curves that are known on
//! these. A face that meets itself along a seam and is no rectangle of its surface has those of all its edges, on a cylinder, a cone, a sphere and a torus, too: fitted to a tenth of their tolerance and
//! measured, or none. Trimmed surfaces are bounded by their loops in parameters (`CURVE_BOUNDED_SURFACE`), exactly; meshes are tessellated shells of
//! triangles. Numbers read back to the same bits; so do colours, whose names say them as light where no numbers of sRGB do, and definitions keep their order.
//! Periodic splines are opened and all are clamped, as other programs take other knots amiss. A transform that is no turn and shift is baked in. What a layer
//! has beyond its name stands in its description.

mod format;
mod layers;
mod light;
mod part21;
mod read;
mod write;

pub use format::{Step, Step as Plugin};

/// The system that files which were written here say they come from.
const SYSTEM: &str = "Loftsman";

/// What stands in the description of the product that is nothing but the scene as a whole.
const SCENE: &str = "the scene as a whole";

/// What the product of a definition is said to be: instances show it, however many there are.
const DEFINITION: &str = "what instances show";

/// The heading under which an object keeps what its part is called where it is used, in a file by another program.
const OCCURRENCE: &str = "step occurrence";

/// What a product is said to be whose geometry several objects share.
const SHARED: &str = "what objects share";

/// What the product of a group without anything in it is said to be.
const GROUP: &str = "a group";
