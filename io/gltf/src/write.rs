//! The writer: one node an object, one mesh with one primitive where it has something to show.

use std::collections::HashMap;

use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, FormatError, Place, Sink, UpChoice, WriteOptions, WriteReport, Written,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::{Error, Point};
use nalgebra::{Matrix4, Translation3};
use serde_json::json;

use crate::OPTIONS;
use crate::binary::{Binary, emit};
use crate::extras::exact;
use crate::pieces::{LINE_STRIP, POINTS, Piece, shade};
use crate::place::Placement;
use crate::schema::{Asset, Attributes, Material, Mesh, Node, Pbr, Primitive, Root, Scene as SceneNodes};

/// Writes a scene.
pub(crate) fn write(
    scene: &Scene,
    sink: &mut dyn Sink,
    options: &WriteOptions<'_>,
) -> Result<WriteReport, FormatError> {
    let file = sink.name().to_owned();
    let fail = |problem: String| FormatError::new(&file, Place::File, problem);
    options.own.check(OPTIONS).map_err(|e| fail(e.to_string()))?;
    let meshes_only = options.own.flag("meshes-only").map_err(|e| fail(e.to_string()))?;
    let unit = options.unit.unwrap_or(Unit::Metre);
    let up = match options.up {
        UpChoice::Usual => Up::Y,
        UpChoice::Keep => scene.up,
        UpChoice::To(up) => up,
    };
    let placed = scene.converted(unit, up).map_err(|e| fail(e.to_string()))?;
    placed.check().map_err(|e| fail(e.to_string()))?;
    let scale = if unit == scene.unit { 1.0 } else { scene.unit.metres() / unit.metres() };
    let mut writer = Writer {
        binary: Binary::default(),
        meshes: Vec::new(),
        materials: Vec::new(),
        colors: HashMap::new(),
        meshes_only,
        options,
        scale,
    };
    let objects = placed.objects();
    let children = children(&placed);
    let mut nodes: Vec<Node> = (0..objects.len()).map(|_| Node::default()).collect();
    let mut written: Vec<Option<Written>> = vec![None; objects.len()];
    let mut baked = 0;
    // Parents before their children: each hands down what its own node could not hold, and how much the nodes so
    // far may stretch a length.
    let roots: Vec<usize> = (0..objects.len()).filter(|&i| objects[i].parent.is_none()).collect();
    let mut open: Vec<(usize, Matrix4<f64>, f64)> =
        roots.iter().rev().map(|&i| (i, Matrix4::identity(), 1.0)).collect();
    let mut done = 0;
    while let Some((index, above, stretch_above)) = open.pop() {
        let object = &objects[index];
        if options.observer.cancelled() {
            return Err(fail("writing was cancelled".to_owned()));
        }
        options.observer.progress("writing", done, objects.len() as u64);
        done += 1;
        let own = object.transform.map_or(above, |own| above * own);
        let (mut placement, rest) = match Placement::of(&own) {
            Some(placement) => (placement, Matrix4::identity()),
            None => {
                baked += 1;
                (
                    Placement {
                        translation: Default::default(),
                        rotation: [0.0, 0.0, 0.0, 1.0],
                        scale: [1.0; 3].into(),
                    },
                    own,
                )
            }
        };
        let stretch = stretch_above * placement.scale.amax();
        let (piece, report) =
            writer.piece(object, &rest, stretch).map_err(|e| fail(e.to_string()).of(object.name()))?;
        let mut shift = Matrix4::identity();
        if let Some(piece) = piece {
            // The node moves the shape to where it belongs; what hangs under the node must not follow.
            if rest == Matrix4::identity() {
                placement.translation += own.fixed_view::<3, 3>(0, 0) * piece.centre;
            } else {
                placement.translation += piece.centre;
            }
            shift = Translation3::from(-piece.centre).to_homogeneous();
            nodes[index].mesh = Some(writer.mesh(object, piece));
            nodes[index].extras = exact(&scene.objects()[index].geometry);
        }
        nodes[index].name = object.name().to_owned();
        nodes[index].translation = placement.shift();
        nodes[index].rotation = placement.turn();
        nodes[index].scale = placement.stretch();
        written[index] = Some(report);
        open.extend(children[index].iter().rev().map(|&child| (child, shift * rest, stretch)));
    }
    let report =
        WriteReport { objects: written.into_iter().flatten().collect(), notes: notes(&placed, baked) };
    let mut root = Root {
        asset: Asset {
            version: "2.0",
            generator: concat!("Loftsman ", env!("CARGO_PKG_VERSION")).to_owned(),
            extras: json!({ "loftsman": { "unit": scene.unit, "up": scene.up } }),
        },
        meshes: writer.meshes,
        materials: writer.materials,
        ..Root::default()
    };
    let top = keep_shown(nodes, &children, &roots, objects, &mut root);
    // A scene must have nodes; a document need not have a scene.
    if !top.is_empty() {
        root.scene = Some(0);
        root.scenes.push(SceneNodes { nodes: top });
    }
    emit(root, writer.binary, sink)?;
    Ok(report)
}

/// The objects that hang under each.
fn children(scene: &Scene) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); scene.objects().len()];
    let index: HashMap<&str, usize> =
        scene.objects().iter().enumerate().map(|(i, o)| (o.name(), i)).collect();
    for (i, object) in scene.objects().iter().enumerate() {
        if let Some(&parent) = object.parent.as_deref().and_then(|name| index.get(name)) {
            children[parent].push(i);
        }
    }
    children
}

/// Leaves out the nodes of objects that could not be written and have nothing below them that was, numbers the
/// others, and returns those without a parent.
fn keep_shown(
    nodes: Vec<Node>,
    children: &[Vec<usize>],
    roots: &[usize],
    objects: &[Object],
    root: &mut Root,
) -> Vec<usize> {
    // From the leaves up, in the reverse of an order that has parents first.
    let mut order = roots.to_vec();
    let mut next = 0;
    while let Some(&index) = order.get(next) {
        order.extend(&children[index]);
        next += 1;
    }
    let mut shown = vec![false; nodes.len()];
    for &index in order.iter().rev() {
        let group = matches!(objects[index].geometry, Geometry::Group);
        shown[index] = group || nodes[index].mesh.is_some() || children[index].iter().any(|&c| shown[c]);
    }
    let mut number = vec![0; nodes.len()];
    for (count, index) in (0..nodes.len()).filter(|&i| shown[i]).enumerate() {
        number[index] = count;
    }
    for (index, mut node) in nodes.into_iter().enumerate().filter(|(i, _)| shown[*i]) {
        node.children = children[index].iter().filter(|&&c| shown[c]).map(|&c| number[c]).collect();
        root.nodes.push(node);
    }
    roots.iter().filter(|&&i| shown[i]).map(|&i| number[i]).collect()
}

fn notes(scene: &Scene, baked: usize) -> Vec<String> {
    let mut notes = vec!["glTF keeps coordinates in single precision".to_owned()];
    let mut say = |count: usize, what: &str| {
        if count > 0 {
            notes.push(format!("{count} {what}"));
        }
    };
    say(baked, "transform(s) shear or flatten, which glTF nodes cannot: they are baked into the points");
    let count = |has: &dyn Fn(&Object) -> bool| scene.objects().iter().filter(|o| has(o)).count();
    say(
        count(&|o| o.animation.is_some()),
        "animation(s) are left out: the frame that the object is in was written",
    );
    say(count(&|o| o.layer.is_some()), "layer name(s) are left out");
    notes
}

struct Writer<'a> {
    binary: Binary,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    /// The material of each colour, by its bits.
    colors: HashMap<[u64; 4], usize>,
    meshes_only: bool,
    options: &'a WriteOptions<'a>,
    /// Lengths in the scene to lengths in the file.
    scale: f64,
}

impl Writer<'_> {
    /// What to show of an object (moved by `rest`), and how it went out. `stretch` is how much its transforms may
    /// stretch a length.
    fn piece(
        &self,
        object: &Object,
        rest: &Matrix4<f64>,
        stretch: f64,
    ) -> Result<(Option<Piece>, Written), Error> {
        let mut written = Written {
            object: object.name().to_owned(),
            form: "nothing".to_owned(),
            fate: Fate::Kept,
            tolerance: None,
            reason: None,
        };
        let left_out = |mut written: Written, reason: &str| {
            (written.fate, written.reason) = (Fate::LeftOut, Some(reason.to_owned()));
            Ok((None, written))
        };
        let moved;
        let geometry = if *rest == Matrix4::identity() {
            &object.geometry
        } else {
            moved = object.geometry.transformed(rest)?;
            &moved
        };
        let mesh_like = matches!(geometry, Geometry::Group | Geometry::Surface(_) | Geometry::Mesh(_));
        if self.meshes_only && !mesh_like {
            return left_out(written, "only meshes were asked for");
        }
        let tessellator = self.options.tessellator;
        let no_tessellator = "splines need a tessellator, and none is registered";
        let fineness = self.fineness(stretch);
        let piece = match geometry {
            Geometry::Group => {
                written.form = "node".to_owned();
                return Ok((None, written));
            }
            Geometry::Curve(curve) => {
                let Some(tessellator) = tessellator else { return left_out(written, no_tessellator) };
                let line = match tessellator.curve(curve, &fineness) {
                    Ok(line) if line.points.len() >= 2 => line,
                    Ok(_) => return left_out(written, "the curve has no extent"),
                    Err(e) => return left_out(written, &format!("it could not be tessellated: {e}")),
                };
                written.fate = Fate::Approximated;
                written.tolerance = Some(self.tolerance(&fineness, &line.points, stretch));
                written.reason = Some("the curve became segments; the exact one is in extras".to_owned());
                Piece::line(&line)?
            }
            Geometry::Surface(surface) => {
                let Some(tessellator) = tessellator else { return left_out(written, no_tessellator) };
                // A surface's normal is mirrored inward, a mesh's stays outside.
                let inside_out = rest.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
                let mesh = match tessellator.surface(surface, &fineness) {
                    Ok(mut mesh) => {
                        if inside_out {
                            mesh.turn_inside_out();
                        }
                        mesh
                    }
                    Err(e) => return left_out(written, &format!("it could not be tessellated: {e}")),
                };
                written.fate = Fate::Approximated;
                written.tolerance = Some(self.tolerance(&fineness, mesh.points(), stretch));
                written.reason = Some("the surface became triangles; the exact one is in extras".to_owned());
                Piece::mesh(&mesh)?
            }
            Geometry::Trimmed(_) => {
                return left_out(
                    written,
                    "trimmed surfaces cannot be tessellated yet: take its surface, or trim a mesh",
                );
            }
            Geometry::Mesh(mesh) => {
                let piece = Piece::mesh(mesh)?;
                if mesh.faces().any(|f| f.len() > 3) {
                    written.fate = Fate::Approximated;
                    written.reason = Some("glTF has triangles only: larger faces were cut".to_owned());
                }
                piece
            }
            Geometry::Polyline(line) if line.points.len() < 2 => {
                return left_out(written, "a line needs two points");
            }
            Geometry::Polyline(line) => Piece::line(line)?,
            Geometry::Cloud(cloud) if cloud.points.is_empty() => {
                return left_out(written, "it has no points");
            }
            Geometry::Cloud(cloud) => Piece::cloud(&cloud.points)?,
            other => return left_out(written, &format!("glTF has no {}", other.kind())),
        };
        if piece.indices.as_ref().is_some_and(Vec::is_empty) {
            return left_out(written, "it has no triangle of any extent");
        }
        let points = piece.positions.len();
        written.form = match piece.mode {
            POINTS => format!("{points} points"),
            LINE_STRIP => {
                let segments = piece.indices.as_ref().map_or(points, Vec::len) - 1;
                format!("line strip of {segments} segments")
            }
            _ => format!("{} triangles", piece.indices.as_ref().map_or(0, Vec::len) / 3),
        };
        if !piece.remarks.is_empty() {
            let before = written.reason.take().map(|r| vec![r]).unwrap_or_default();
            let all = before.into_iter().chain(piece.remarks.iter().map(|&r| r.to_owned()));
            written.reason = Some(all.collect::<Vec<_>>().join("; "));
            written.fate = Fate::Approximated;
        }
        Ok((Some(piece), written))
    }

    /// The fineness in the coordinates of a shape that is stretched later.
    fn fineness(&self, stretch: f64) -> Fineness {
        let mut fineness = self.options.fineness;
        if let Chord::Absolute(length) = &mut fineness.chord {
            *length *= self.scale;
            if stretch > 0.0 {
                *length /= stretch;
            }
        }
        fineness
    }

    /// The chord tolerance in the scene's unit.
    fn tolerance(&self, fineness: &Fineness, points: &[Point], stretch: f64) -> f64 {
        match (self.options.fineness.chord, fineness.chord) {
            (Chord::Absolute(length), _) => length,
            (_, Chord::Relative(fraction)) | (_, Chord::Absolute(fraction)) => {
                let first = points.first().copied().unwrap_or_default();
                let (low, high) = points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
                fraction * (high - low).norm() * stretch / self.scale
            }
        }
    }

    fn mesh(&mut self, object: &Object, piece: Piece) -> usize {
        let attributes = Attributes {
            position: self.binary.floats(&piece.positions, true),
            normal: (!piece.normals.is_empty()).then(|| self.binary.floats(&piece.normals, false)),
            texcoord: (!piece.uvs.is_empty()).then(|| self.binary.floats(&piece.uvs, false)),
            color: (!piece.colors.is_empty()).then(|| self.binary.floats(&piece.colors, false)),
        };
        let indices = piece.indices.map(|list| self.binary.indices(&list, piece.positions.len()));
        // Vertex colours multiply the material's: white leaves them as they are.
        let neutral = if attributes.color.is_some() { 1.0 } else { 0.8 };
        let color = object.color.unwrap_or([neutral, neutral, neutral, 1.0]);
        let material = Some(self.material(color, object.color.is_none()));
        let primitive = Primitive { attributes, indices, material, mode: piece.mode };
        self.meshes.push(Mesh { name: object.name().to_owned(), primitives: vec![primitive] });
        self.meshes.len() - 1
    }

    fn material(&mut self, color: [f64; 4], neutral: bool) -> usize {
        let color = color.map(shade);
        let next = self.materials.len();
        let index = *self.colors.entry(color.map(f64::to_bits)).or_insert(next);
        if index == next {
            let name = if neutral { "default".to_owned() } else { format!("color {}", next + 1) };
            self.materials.push(Material {
                name,
                pbr_metallic_roughness: Pbr {
                    base_color_factor: color,
                    metallic_factor: 0.0,
                    roughness_factor: 0.5,
                },
                alpha_mode: (color[3] < 1.0).then_some("BLEND"),
                double_sided: true,
            });
        }
        index
    }
}
