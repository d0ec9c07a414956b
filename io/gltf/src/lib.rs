//! glTF 2.0, `.glb` and `.gltf` with its `.bin`: in and out.
//!
//! # Out
//!
//! * *Meshes* are triangles with normals, texture coordinates and colours where the scene has them, a primitive for each
//!   material; points are doubled only where corners at a point differ. Polygons are cut into triangles by their corners
//!   (ears), so that concave faces stay right. Lines of a mesh are one more primitive. *Surfaces*, trimmed or not, *Breps* and *curves* go
//!   through the tessellator of the options: triangles with smooth normals, and line strips. Faces of Breps that have colours are a primitive
//!   for each colour; a face that cannot be cut is left out, and named in the report. *Clouds* are points.
//! * *The exact spline* goes along: a node has `extras.loftsman`, a text that holds `curve`, `surface` or `trimmed` as a
//!   `*.loft.json` document has them, in the scene's own unit and axes, which it names, as `asset.extras.loftsman` does for the whole
//!   (Blender passes on what belongs to nodes only); and the name of the layer, and the exact transform where the node's parts round it.
//!   (A text, because Blender cannot take lists of lists as custom properties.)
//! * *Objects that share their geometry* share its vertices, and its mesh where their materials are the same too, unless they
//!   move or shear. Instances become nodes with nodes of what they show below them, which share it likewise.
//! * *Names, hierarchy, transforms* become nodes. glTF fixes metres and y up: points and transforms are turned and
//!   scaled, no node is added. A transform with shear, which glTF forbids, is baked into the points below it.
//! * *Names* may be equal in glTF: an object with a label goes out by that, and comes back with it.
//! * *Layers* are listed in `asset.extras.loftsman.layers`, as a document has them. What has its colour by layer gets a
//!   material of that colour, and a mark by which our reader knows it again. glTF cannot hide a layer without hiding what
//!   hangs under its nodes: everything goes out, and the report says what other programs will show.
//! * *Large coordinates*: glTF has single precision. A shape further from its origin than eight times its own size
//!   is moved to it, and its node back. The report says by how much numbers are rounded.
//! * *Materials* with their textures and pictures, and one for each colour of objects that have none, `metallicFactor`
//!   0. What a material kept of glTF's extensions goes out again. Pictures that are files go into a GLB, and beside a
//!   `.gltf` by their names, where the options say where to find them; else they are named only.
//! * *Texture coordinates* point up in Loftsman and down in glTF: `v` goes out as `1 - v`.
//! * *Frames* of an animation are morph targets, shown one after the other by an animation of their weights. A spline is cut
//!   at the same parameters in all of them, as finely as each needs, and the report's error is that of the worst. Vertices
//!   are those of the shape itself (of its first frame where it is eight times as large as all of these), and the mesh's weights
//!   show its first frame. Normals are moved, too: turned as the faces around them are; a millionth shorter where flat faces will
//!   bend, which Blender would else leave flat. Between frames points go straight (`LINEAR`). Of what does not move
//!   in a frame, and of weights, which are zero but for one a frame, nothing is written (sparse accessors).
//! * *Torn curves* are a strip for each of their parts.
//! * *Numbers* that single precision does not hold or tell apart (coordinates, places, times) are refused by the object's name,
//!   those of materials left out with a note. So is a spline that cannot be cut as finely as asked; what has no extent, and a trimmed surface that cannot be cut,
//!   is a node with the exact spline alone.
//! * *Tangents* go out as they are; where a material has a normal map and the mesh has texture coordinates but no
//!   tangents, they are made as MikkTSpace has them, and marked so that our reader drops them again.
//! * *What other programs noted* in `extras` of the file, the asset, the scene, nodes, meshes and materials, the names of
//!   the scene and of meshes, and the copyright go out again.
//!
//! The option `meshes-only` leaves lines and points out: MeshLab reads every primitive as triangles.
//!
//! # In
//!
//! Every node of the scene that is shown becomes an object, its mesh with a slot for each material; a mesh that several
//! nodes show is one geometry, which their objects share until one of them is changed, and so are meshes of the same
//! vertices that differ in their materials. Strips and fans become triangles;
//! lines the mesh's lines, or a polyline where there is one strip, or lines that make one, and nothing else; points a cloud; lines and points with
//! colours or other layers are a mesh of nothing else.
//! Accessors may be sparse, interleaved, normalised or quantised. An exact spline is taken from the extras as long as the
//! mesh has the vertices that were written with it, or the node no mesh at all. The unit and axes of the scene are those that the asset
//! notes, else those of all nodes that note any; splines that were noted in others are changed into these. Tangents and the `extras` of other programs are kept. Skins, cameras,
//! lights, animations of nodes, morph targets that nothing animates (weights bend the shape once), attributes and
//! extensions that Loftsman has nothing for are counted in the report. Extensions that a file needs and this reader does
//! not know, compression above all, are refused by name. A scene may take 64 times the memory that the file has bytes
//! (and 64 MB at least): what asks for more is refused.

mod extras;
mod place;
mod read;
mod texture;
mod words;
mod write;

use loftsman_kernel::plugin::{
    Chord, Confidence, Field, Fineness, Format, FormatDeclaration, FormatError, Holds, MeshPart, Outgoing,
    Parameters, ReadOptions, ReadReport, Sink, Source, UnitRule, WriteReport,
};
use loftsman_kernel::scene::{Scene, Unit, Up};
use loftsman_kernel::text;

/// The format `"gltf"`: `.glb` in one file, `.gltf` with a `.bin` beside it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gltf;

pub use Gltf as Plugin;

const OPTIONS: &[Field] = &[Field::optional(
    "meshes-only",
    "true | false",
    "false",
    "writing: leave curves, lines and points out, for programs like MeshLab that take them for triangles",
)];

impl Format for Gltf {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "gltf",
            help: "glTF 2.0: meshes, lines and points with materials, hierarchy, frames, and exact splines in extras",
            extensions: &["glb", "gltf"],
            reads: true,
            writes: true,
            plain: false,
            options: OPTIONS,
            holds: Holds {
                unit: UnitRule::Fixed(Unit::Metre),
                up: Some(Up::Y),
                exact: &["group", "mesh", "polyline", "cloud"],
                tessellated: &["curve", "surface", "trimmed", "brep", "shape"],
                carried: &["curve", "surface", "trimmed", "shape"],
                // Colours that differ at a point are there with the points that are doubled.
                meshes: &[
                    MeshPart::Normals,
                    MeshPart::Uvs,
                    MeshPart::Colors,
                    MeshPart::Lines,
                    MeshPart::CornerColors,
                    MeshPart::Tangents,
                    MeshPart::FurtherUvs,
                    MeshPart::BareLines,
                ],
                hides: false,
                unused: false,
                unused_materials: false,
                connections: false,
                statements: &[words::PREFIX],
                single_precision: true,
                ..Holds::EVERYTHING
            },
        }
    }

    /// A ten-thousandth of the diagonal: its meshes are what is looked at.
    fn fineness(&self) -> Fineness {
        Fineness { chord: Chord::Relative(1e-4), ..Fineness::default() }
    }

    fn holds(&self, own: &Parameters) -> Result<Holds, FormatError> {
        let holds = self.declaration().holds;
        Ok(if own.flag("meshes-only")? {
            Holds {
                exact: &["group", "mesh"],
                tessellated: &["surface", "trimmed", "brep", "shape"],
                carried: &["surface", "trimmed", "shape"],
                ..holds
            }
        } else {
            holds
        })
    }

    /// The magic number of GLB, or a JSON object with the key `"asset"`.
    fn confidence(&self, head: &[u8]) -> Confidence {
        let is_ours = head.starts_with(b"glTF") || text::has_key(head, "asset");
        if is_ours { Confidence::Sure } else { Confidence::No }
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
