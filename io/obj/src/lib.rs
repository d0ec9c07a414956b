//! Wavefront OBJ: polygon meshes, lines, points and free-form curves, in and out.
//!
//! **Reading.** Every statement is accounted for in the report; what is malformed is an error with its line.
//!
//! * *Objects.* Each `o` starts a scene object; in a file without any `o`, each `g` does (the same name again goes
//!   on with the same object). Option `split` chooses otherwise. Names come from `o`, else `g`, else the file; a
//!   section that holds faces, lines, points and curves gives one scene object for the faces, one for each chain
//!   of lines, one for all its points and one for each curve.
//! * *Faces* of any size, every form of index, also negative. The points stay as the file has them, so that
//!   neighbouring faces stay joined; normals and texture coordinates are kept where all faces at a point agree on
//!   them. `corners = "split"` doubles the points where they do not, and keeps all of them.
//! * *Materials.* An object of one material whose `Kd` can be found has that colour.
//! * *Vertex colours* (`v x y z r g b`) are taken as sRGB, as Blender does, and kept as linear numbers.
//! * *Lines* that follow one another from end to end are one polyline.
//! * *Curves*: `bspline` and `bezier`, rational or not, exactly. A B-spline whose control points and knots wrap
//!   around is periodic.
//!
//! **Writing.** Curves go out as NURBS, in Bézier form unless `knots = "any"`: Blender draws uneven simple knots
//! as if they were even. Surfaces are tessellated by the tessellator of the options. Transforms are baked, as OBJ
//! has none; numbers read back exactly.

mod read;
mod text;
mod write;

use loftsman_kernel::plugin::{
    Field, Format, FormatDeclaration, FormatError, Plugin as Register, ReadOptions, ReadReport, Registry,
    Sink, Source, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::Scene;

/// The format `"obj"`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Obj;

const OPTIONS: &[Field] = &[
    Field::optional(
        "split",
        "\"auto\" | \"object\" | \"group\" | \"none\"",
        "\"auto\"",
        "reading: what starts a new object; auto is every o, or every g where there is no o",
    ),
    Field::optional(
        "corners",
        "\"share\" | \"split\"",
        "\"share\"",
        "reading: keep points as they are, or double those whose normals or texture coordinates differ by face",
    ),
    Field::optional(
        "knots",
        "\"bezier\" | \"any\"",
        "\"bezier\"",
        "writing: curves in Bézier form, which Blender draws exactly, or with their own knots",
    ),
];

impl Format for Obj {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "obj",
            help: "Wavefront OBJ: polygon meshes, lines, points and NURBS curves",
            extensions: &["obj"],
            reads: true,
            writes: true,
            plain: true,
            options: OPTIONS,
        }
    }

    fn recognises(&self, head: &[u8]) -> bool {
        read::recognises(head)
    }

    fn read(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        read::read(source, options)
    }

    fn write(
        &self,
        scene: &Scene,
        sink: &mut dyn Sink,
        options: &WriteOptions<'_>,
    ) -> Result<WriteReport, FormatError> {
        write::write(scene, sink, options)
    }
}

/// Registers [`Obj`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Plugin;

impl Register for Plugin {
    fn register(&self, registry: &mut Registry) {
        registry.format(Obj);
    }
}
