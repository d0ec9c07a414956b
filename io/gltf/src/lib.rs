//! glTF 2.0, `.glb` and `.gltf` with its `.bin`: out.
//!
//! * *Meshes* are triangles with normals, texture coordinates and colours where the scene has them; polygons are cut
//!   into triangles by their corners (ears), so that concave faces stay right. *Surfaces* and *curves* go through
//!   the tessellator of the options: triangles with smooth normals, and line strips. *Clouds* are points.
//! * *The exact spline* goes along: the node of a curve or surface has `extras.loftsman`, a text that holds
//!   `{"curve": …}` or `{"surface": …}` as a `*.loft.json` document has it, in the scene's own unit and axes, which
//!   `asset.extras.loftsman` names. (A text, because Blender cannot take lists of lists as custom properties.)
//! * *Names, hierarchy, transforms* become nodes. glTF fixes metres and y up: points and transforms are turned and
//!   scaled, no node is added. A transform with shear, which glTF forbids, is baked into the points below it.
//! * *Large coordinates*: glTF has single precision. A shape further from its origin than eight times its own size
//!   is moved to it, and its node back.
//! * *Materials*: one for each colour, `metallicFactor` 0.
//! * *Texture coordinates* point up in Loftsman and down in glTF: `v` goes out as `1 - v`.
//!
//! The option `meshes-only` leaves lines and points out: MeshLab reads every primitive as triangles.

mod binary;
mod extras;
mod pieces;
mod place;
mod schema;
mod triangulate;
mod write;

use loftsman_kernel::plugin::{
    Field, Format, FormatDeclaration, FormatError, Place, Plugin as Register, ReadOptions, ReadReport,
    Registry, Sink, Source, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::Scene;

/// The format `"gltf"`: `.glb` in one file, `.gltf` with a `.bin` beside it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gltf;

const OPTIONS: &[Field] = &[Field::optional(
    "meshes-only",
    "true | false",
    "false",
    "leave curves, lines and points out, for programs like MeshLab that take them for triangles",
)];

impl Format for Gltf {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "gltf",
            help: "glTF 2.0: meshes, lines and points with names, hierarchy and exact splines in extras",
            extensions: &["glb", "gltf"],
            reads: false,
            writes: true,
            plain: false,
            options: OPTIONS,
        }
    }

    fn read(
        &self,
        source: &dyn Source,
        _options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        Err(FormatError::new(source.name(), Place::File, "glTF can be written, but not read"))
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

/// Registers [`Gltf`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Plugin;

impl Register for Plugin {
    fn register(&self, registry: &mut Registry) {
        registry.format(Gltf);
    }
}
