//! Wavefront OBJ: polygon meshes, lines, points, free-form curves and surfaces, trimmed or not, in and out.
//!
//! **Reading.** Every statement is accounted for in the report; what is malformed is left out with its line, with what
//! uses it, and the rest is read. A file is an error where nothing is left of it. Files are read in parallel, part by
//! part; text may be UTF-8 or UTF-16, with any line ends.
//!
//! * *Objects.* Each `o` starts a scene object; `split = "group"` makes one of each `g` instead. Names come from `o`,
//!   else the file (of curves and surfaces also from `g`, where no `o` names them or one names the faces, lines or points before them). The faces and lines of a section are one mesh; lines without
//!   faces are a polyline a chain, points a cloud (meshes of nothing else where the vertices have colours), each curve
//!   and surface an object. Objects of one name become several with names of their own, and keep it as their label; OBJ
//!   has no labels, since what has one name is one object to its readers: unique names go out.
//! * *Faces* of any size, every form of index, also negative. Normals and texture coordinates keep their own indices;
//!   groups, smoothing groups and materials are kept face by face.
//! * *Materials* of all libraries that can be found; what a material of the kernel has no place for is kept word for
//!   word.
//! * *Vertex colours* (`v x y z r g b`, or `#MRGB` of ZBrush) are taken as sRGB, as Blender does, and kept as linear
//!   numbers.
//! * *Curves and surfaces*: `bspline` and `bezier` as they are; `bmatrix`, `cardinal` and `taylor` (whose powers are of
//!   the parameter itself) by an exact change of basis; rational or not. Those whose control points and knots wrap around,
//!   as far as the digits of the knots tell, are periodic. `trim`, `hole`, `scrv` and `sp` make trimmed surfaces, `con` connections of the scene.
//!
//! **Writing.** Curves go out as NURBS, in Bézier form unless `knots = "any"`: Blender draws uneven simple knots as if
//! they were even. Surfaces, trimmed or not, go out as `surf` and, by the tessellator of the options, as a mesh; Breps as a mesh, in which each
//! face is a group (`face_12`, with its name where it has one) and faces that have colours a material of that colour. Materials go into a
//! library beside the file. Transforms are baked, as OBJ has none; numbers read back exactly.
//!
//! **There and back.** Comments that start with `# Loftsman` say what OBJ has no statement for, and are read while what
//! stands beside them is as it was written: unit and axis (the first line); a curve itself, where its Bézier form follows
//! (`curve 3 open; knots …; points …; weights …`); a mesh and the surface that it was made of, by fingerprints of both
//! (`mesh …`, `surface … of mesh …`), which are one object; normals that were made for faces (`normals`).

mod fingerprint;
mod number;
mod read;
mod text;
mod write;

use loftsman_kernel::plugin::{
    Confidence, Field, Format, FormatDeclaration, FormatError, Holds, MeshPart, Outgoing, Parameters,
    ReadOptions, ReadReport, Sink, Source, WriteReport,
};
use loftsman_kernel::scene::{Scene, Up};

/// The format `"obj"`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Obj;

pub use Obj as Plugin;

const OPTIONS: &[Field] = &[
    Field::optional(
        "split",
        "\"object\" | \"group\" | \"none\"",
        "\"object\"",
        "reading: what starts a new object: every o, every g, or nothing",
    ),
    Field::optional(
        "knots",
        "\"bezier\" | \"any\"",
        "\"bezier\"",
        "writing: curves in Bézier form, which Blender draws exactly, or with their own knots",
    ),
    Field::optional(
        "surfaces",
        "\"both\" | \"exact\" | \"mesh\"",
        "\"both\"",
        "writing: surfaces exactly (surf), tessellated for programs that read no surf, or both",
    ),
];

impl Format for Obj {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "obj",
            help: "Wavefront OBJ: polygon meshes, lines, points, NURBS curves and surfaces",
            extensions: &["obj"],
            reads: true,
            writes: true,
            plain: true,
            options: OPTIONS,
            holds: Holds {
                unused_materials: true,
                up: Some(Up::Y),
                exact: &["curve", "surface", "trimmed", "mesh", "polyline", "cloud"],
                tessellated: &["surface", "trimmed", "brep", "shape"],
                meshes: &[
                    MeshPart::Polygons,
                    MeshPart::Normals,
                    MeshPart::Uvs,
                    MeshPart::Colors,
                    MeshPart::Lines,
                    MeshPart::Corners,
                    MeshPart::Groups,
                    MeshPart::Smoothing,
                ],
                colors: true,
                materials: true,
                unclamped: true,
                connections: true,
                statements: &["mtl "],
                ..Holds::NOTHING
            },
        }
    }

    fn holds(&self, own: &Parameters) -> Result<Holds, FormatError> {
        write::holds(self.declaration().holds, own)
    }

    /// Names that cannot stand in a file as they are.
    fn further_losses(&self, scene: &Scene) -> Vec<String> {
        write::changed_names(scene)
    }

    fn confidence(&self, head: &[u8]) -> Confidence {
        if read::recognises(head) { Confidence::Sure } else { Confidence::No }
    }

    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        read::read(source, options)
    }

    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        write::write(outgoing, sink)
    }
}
