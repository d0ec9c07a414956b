//! The writer: one node an object, one mesh with a primitive a material where it has something to show.

mod animation;
mod bin;
mod material;
mod nodes;
mod schema;
mod shape;

use std::borrow::Cow;

use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, FormatError, Place, Sink, UpChoice, WriteOptions, WriteReport, Written,
};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::{Error, Point};
use nalgebra::{Matrix4, Translation3};
use serde_json::json;

use self::animation::{Keys, Moves};
use self::bin::{Bin, emit};
use self::material::Materials;
use self::schema::{Asset, Mesh, Node, Root, Scene as SceneNodes};
use self::shape::{Failure, LINE_STRIP, POINTS, Shaped};
use crate::OPTIONS;
use crate::extras::{AnimationFields, Own, rows};
use crate::place::{Change, Placement};
use crate::words::EXTRAS;

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
    scene.check().map_err(|e| fail(e.to_string()))?;
    let unit = options.unit.unwrap_or(Unit::Metre);
    let up = match options.up {
        UpChoice::Usual => Up::Y,
        UpChoice::Keep => scene.up,
        UpChoice::To(up) => up,
    };
    let as_usual = (unit, up) == (Unit::Metre, Up::Y);
    // In glTF's own unit and axes numbers are changed as they are poured, and the file notes what they were; else a
    // reader takes them for metres and y up, and so does this.
    let (scene, change) = if as_usual {
        (Cow::Borrowed(scene), Change::between((scene.unit, scene.up), (unit, up)))
    } else {
        (scene.converted(unit, up).map_err(|e| fail(e.to_string()))?, Change::none())
    };
    let scene = scene.as_ref();
    let mut writer = Writer {
        scene,
        options,
        meshes_only,
        change,
        back: if as_usual { Change::between((unit, up), (scene.unit, scene.up)) } else { change },
        bin: Bin::default(),
        materials: Materials::new(scene),
        meshes: Vec::new(),
        keys: Keys::default(),
        rounding: 0.0,
    };
    let (nodes, report) = writer.scene(&file)?;
    let Writer { bin, materials, meshes, keys, rounding, .. } = writer;
    let noted =
        (as_usual && !change.is_none()).then(|| json!({ EXTRAS: { "unit": scene.unit, "up": scene.up } }));
    let generator = concat!("Loftsman ", env!("CARGO_PKG_VERSION")).to_owned();
    let mut root =
        Root { asset: Asset { version: "2.0", generator, extras: noted }, meshes, ..Root::default() };
    let mut notes = notes(scene, rounding / change.scale);
    let mut of_materials = materials.finish(&mut root);
    of_materials.dedup();
    notes.extend(of_materials);
    let (nodes, top, numbers) = nodes;
    root.nodes = nodes;
    root.animations = keys.finish(&numbers);
    // A scene must have nodes; a document need not have a scene.
    if !top.is_empty() {
        root.scene = Some(0);
        root.scenes.push(SceneNodes { nodes: top });
    }
    emit(root, bin, sink)?;
    Ok(WriteReport { objects: report, notes })
}

fn notes(scene: &Scene, rounding: f64) -> Vec<String> {
    let unit = scene.unit.name();
    let mut notes = Vec::new();
    if rounding > 0.0 {
        notes.push(format!(
            "glTF has single precision: coordinates are rounded by at most {rounding:.1e} {unit}"
        ));
    }
    let used: Vec<&str> = scene.objects().iter().flat_map(|o| &o.materials).map(String::as_str).collect();
    let used: std::collections::HashSet<&str> = used.into_iter().collect();
    let unused =
        scene.materials.iter().filter(|m| !used.contains(loftsman_kernel::named::Named::name(*m))).count();
    if unused > 0 {
        notes.push(format!("{unused} material(s) that no object has are left out"));
    }
    if !scene.connections().is_empty() {
        notes.push(format!("{} connection(s) of surfaces are left out", scene.connections().len()));
    }
    notes
}

struct Writer<'a, 'o> {
    scene: &'a Scene,
    options: &'o WriteOptions<'o>,
    meshes_only: bool,
    /// From the scene's unit and axes to the file's, and back.
    change: Change,
    back: Change,
    bin: Bin<'a>,
    materials: Materials<'a>,
    meshes: Vec<Mesh>,
    keys: Keys,
    /// By how much a coordinate was rounded, in the file's unit.
    rounding: f64,
}

/// What hangs over an object: what its parent's node could not hold, in the file's unit and axes.
#[derive(Clone, Copy)]
struct Above {
    /// What was baked into the points above, or moved away from them.
    rest: Matrix4<f64>,
    /// By how much all nodes so far may stretch a length.
    stretch: f64,
}

/// Nodes in the file's order, those at the top, and each object's number.
type Nodes = (Vec<Node>, Vec<usize>, Vec<Option<usize>>);

impl<'a> Writer<'a, '_> {
    fn scene(&mut self, file: &str) -> Result<(Nodes, Vec<Written>), FormatError> {
        let fail = |problem: String| FormatError::new(file, Place::File, problem);
        let scene = self.scene;
        let objects = scene.objects();
        let tree = nodes::Tree::of(scene);
        let mut all: Vec<Node> = (0..objects.len()).map(|_| Node::default()).collect();
        let mut written: Vec<Option<Written>> = vec![None; objects.len()];
        // Parents before their children: each hands down what its own node could not hold.
        let start = Above { rest: Matrix4::identity(), stretch: 1.0 };
        let mut open: Vec<(usize, Above)> = tree.roots.iter().rev().map(|&i| (i, start)).collect();
        let mut done = 0;
        while let Some((index, above)) = open.pop() {
            if self.options.observer.cancelled() {
                return Err(fail("writing was cancelled".to_owned()));
            }
            self.options.observer.progress("writing", done, objects.len() as u64);
            done += 1;
            let object = &objects[index];
            let named = |e: Failure| fail(e.to_string()).of(object.name());
            let (node, below, report) = self.object(index, object, above).map_err(named)?;
            all[index] = node;
            written[index] = Some(report);
            open.extend(tree.children[index].iter().rev().map(|&child| (child, below)));
        }
        let nodes = nodes::number(all, &tree, objects);
        Ok((nodes, written.into_iter().flatten().collect()))
    }

    fn object(
        &mut self,
        index: usize,
        object: &'a Object,
        above: Above,
    ) -> Result<(Node, Above, Written), Failure> {
        let identity = Matrix4::identity();
        let own = object.transform.map_or(above.rest, |own| above.rest * self.change.of_transform(&own));
        // A transform with shear, which glTF forbids, is baked into the points.
        let (mut placement, rest) = match Placement::of(&own) {
            Some(placement) => (placement, identity),
            None => (Placement::none(), own),
        };
        let stretch = above.stretch * placement.scale.amax();
        let mut report = Written {
            object: object.name().to_owned(),
            form: "nothing".to_owned(),
            fate: Fate::Kept,
            tolerance: None,
            reason: None,
        };
        let mut node = Node { name: object.name().to_owned(), ..Node::default() };
        let mut noted = Own::default();
        let mut place = rest;
        if let Some((shaped, moves, fields)) = self.shape(object, &rest, stretch, &mut report)? {
            // The node moves the shape to where it belongs; what hangs under the node must not follow.
            let centre = shaped.frame.centre;
            placement.translation +=
                if rest == identity { own.fixed_view::<3, 3>(0, 0) * centre } else { centre };
            place = Translation3::from(-centre).to_homogeneous() * rest;
            noted = fields;
            self.rounding = self.rounding.max(shaped.frame.rounding() * stretch);
            let mesh = self.mesh(index, object, shaped, moves, &mut noted, &mut report)?;
            node.mesh = Some(mesh);
        }
        if rest != identity {
            let reason =
                "its transform shears or flattens, which glTF's nodes cannot: it is baked into the points";
            explain(&mut report, Fate::Approximated, reason);
        }
        (node.translation, node.rotation, node.scale) =
            (placement.shift(), placement.turn(), placement.stretch());
        self.note(object, &placement, &place, &above.rest, &mut noted);
        if noted != Own::default() {
            let text = serde_json::to_string(&noted).map_err(|e| Failure::Io(e.into()))?;
            node.extras.insert(EXTRAS.to_owned(), text.into());
        }
        Ok((node, Above { rest: place, stretch }, report))
    }

    /// What the reader cannot see from the node itself.
    fn note(
        &self,
        object: &Object,
        placement: &Placement,
        place: &Matrix4<f64>,
        above: &Matrix4<f64>,
        noted: &mut Own,
    ) {
        let identity = Matrix4::identity();
        let moved = *place != identity || *above != identity;
        if moved {
            noted.place = Some(rows(place));
        }
        let seen = self.back.of_transform(&placement.matrix());
        match object.transform {
            Some(transform) if moved || transform != seen => noted.transform = Some(rows(&transform)),
            // What is none must be none again.
            None if moved => noted.transform = Some(rows(&identity)),
            _ => {}
        }
        noted.layer.clone_from(&object.layer);
    }

    /// What to show of an object, moved by `rest`; how it moves; and its exact spline. `stretch` is how much its
    /// transforms may stretch a length.
    #[allow(clippy::type_complexity, reason = "three results of one look at an object")]
    fn shape(
        &mut self,
        object: &'a Object,
        rest: &Matrix4<f64>,
        stretch: f64,
        report: &mut Written,
    ) -> Result<Option<(Shaped, Option<Moves<'a>>, Own)>, Failure> {
        let leave_out = |report: &mut Written, reason: String| {
            (report.fate, report.reason) = (Fate::LeftOut, Some(reason));
            Ok(None)
        };
        let mesh_like = matches!(
            object.geometry,
            Geometry::Group | Geometry::Surface(_) | Geometry::Trimmed(_) | Geometry::Mesh(_)
        );
        if self.meshes_only && !mesh_like {
            return leave_out(report, "only meshes were asked for".to_owned());
        }
        // Shapes that are baked are in the file's coordinates already; others change as they are poured.
        let baked = *rest != Matrix4::identity();
        let total = rest * self.change.map();
        let (geometry, change) = if baked {
            (Cow::Owned(object.geometry.transformed(&total)?), Change::none())
        } else {
            (Cow::Borrowed(&object.geometry), self.change)
        };
        let frames = object.animation.as_ref().map(|animation| {
            if baked {
                let frame = |f: &Vec<Point>| f.iter().map(|p| transform_point(&total, p)).collect();
                Cow::Owned(Animation {
                    rate: animation.rate,
                    frames: animation.frames.iter().map(frame).collect(),
                })
            } else {
                Cow::Borrowed(animation)
            }
        });
        let frames = frames.filter(|f| !f.frames.is_empty());
        let frames = match frames {
            Some(frames) if frames.frames.len() > animation::LARGEST => {
                let reason = format!(
                    "its animation of {} frames was left out: glTF needs the square of their number, at most {} are written",
                    frames.frames.len(),
                    animation::LARGEST
                );
                explain(report, Fate::Approximated, &reason);
                None
            }
            frames => frames,
        };
        let fineness = self.fineness(stretch, baked);
        let in_scene = stretch / if baked { self.change.scale } else { 1.0 };
        let Some(tessellator) = self.options.tessellator else {
            if matches!(object.geometry, Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Trimmed(_)) {
                return leave_out(report, "splines need a tessellator, and none is registered".to_owned());
            }
            return self.plain(geometry, change, frames, report);
        };
        let could_not = |e: Error| format!("it could not be tessellated: {e}");
        match geometry.as_ref() {
            Geometry::Curve(curve) => {
                let line = match tessellator.curve(curve, &fineness) {
                    Ok(line) if line.points.len() >= 2 => line,
                    Ok(_) => return leave_out(report, "the curve has no extent".to_owned()),
                    Err(e) => return leave_out(report, could_not(e)),
                };
                let (line, moves) = match frames {
                    None => (line, None),
                    Some(frames) => {
                        let parameters = tessellator.curve_parameters(curve, &fineness)?;
                        let (line, moves) = animation::of_curve(curve, &parameters, line.closed, &frames)?;
                        (line, Some(moves))
                    }
                };
                report.tolerance = Some(self.tolerance(&fineness, &line.points, in_scene));
                explain(report, Fate::Approximated, "the curve became segments; the exact one is in extras");
                let shaped = shape::chain(
                    Cow::Owned(line.points.clone()),
                    LINE_STRIP,
                    line.closed,
                    change,
                    &mut self.bin,
                )?;
                Ok(Some(self.exact(object, shaped, &line.points, moves)))
            }
            Geometry::Surface(surface) => {
                let mut mesh = match tessellator.surface(surface, &fineness) {
                    Ok(mesh) => mesh,
                    Err(e) => return leave_out(report, could_not(e)),
                };
                // A surface's normal is mirrored inward, a mesh's stays outside.
                if rest.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
                    mesh.turn_inside_out();
                }
                let moves = match frames {
                    None => None,
                    Some(frames) => animation::of_surface(surface, &mesh, &frames)?,
                };
                report.tolerance = Some(self.tolerance(&fineness, mesh.points(), in_scene));
                explain(
                    report,
                    Fate::Approximated,
                    "the surface became triangles; the exact one is in extras",
                );
                self.spline_mesh(object, mesh, change, moves, report)
            }
            _ => self.plain(geometry, change, frames, report),
        }
    }

    fn spline_mesh(
        &mut self,
        object: &Object,
        mesh: loftsman_kernel::mesh::Mesh,
        change: Change,
        moves: Option<Moves<'a>>,
        report: &mut Written,
    ) -> Result<Option<(Shaped, Option<Moves<'a>>, Own)>, Failure> {
        let points = mesh.points().to_vec();
        match shape::mesh(Cow::Owned(mesh), change, self.meshes_only, &mut self.bin)? {
            Some(shaped) => Ok(Some(self.exact(object, shaped, &points, moves))),
            None => {
                (report.fate, report.reason) =
                    (Fate::LeftOut, Some("it has no triangle of any extent".to_owned()));
                Ok(None)
            }
        }
    }

    /// A shape with the exact spline that it shows.
    fn exact(
        &self,
        object: &Object,
        shaped: Shaped,
        points: &[Point],
        moves: Option<Moves<'a>>,
    ) -> (Shaped, Option<Moves<'a>>, Own) {
        let mut own = Own::of(&object.geometry);
        own.shown_by = Some(shape::shown_by(points, &shaped.frame));
        own.animation = object.animation.as_ref().map(AnimationFields::of);
        (shaped, moves, own)
    }

    /// What needs no tessellator.
    #[allow(clippy::type_complexity, reason = "as `shape` has it")]
    fn plain(
        &mut self,
        geometry: Cow<'a, Geometry>,
        change: Change,
        frames: Option<Cow<'a, Animation>>,
        report: &mut Written,
    ) -> Result<Option<(Shaped, Option<Moves<'a>>, Own)>, Failure> {
        let mut leave_out = |reason: String| {
            (report.fate, report.reason) = (Fate::LeftOut, Some(reason));
            Ok(None)
        };
        let base = geometry.points().to_vec_if(frames.is_some());
        let shaped = match geometry {
            Cow::Borrowed(Geometry::Group) | Cow::Owned(Geometry::Group) => {
                report.form = "node".to_owned();
                return Ok(None);
            }
            Cow::Borrowed(Geometry::Polyline(line)) if line.points.len() >= 2 => shape::chain(
                Cow::Borrowed(line.points.as_slice()),
                LINE_STRIP,
                line.closed,
                change,
                &mut self.bin,
            )?,
            Cow::Owned(Geometry::Polyline(line)) if line.points.len() >= 2 => {
                shape::chain(Cow::Owned(line.points), LINE_STRIP, line.closed, change, &mut self.bin)?
            }
            Cow::Borrowed(Geometry::Cloud(cloud)) if !cloud.points.is_empty() => {
                shape::chain(Cow::Borrowed(cloud.points.as_slice()), POINTS, false, change, &mut self.bin)?
            }
            Cow::Owned(Geometry::Cloud(cloud)) if !cloud.points.is_empty() => {
                shape::chain(Cow::Owned(cloud.points), POINTS, false, change, &mut self.bin)?
            }
            Cow::Borrowed(Geometry::Mesh(mesh)) => {
                cut(mesh, report);
                match shape::mesh(Cow::Borrowed(mesh), change, self.meshes_only, &mut self.bin)? {
                    Some(shaped) => shaped,
                    None => return nothing(report),
                }
            }
            Cow::Owned(Geometry::Mesh(mesh)) => {
                cut(&mesh, report);
                match shape::mesh(Cow::Owned(mesh), change, self.meshes_only, &mut self.bin)? {
                    Some(shaped) => shaped,
                    None => return nothing(report),
                }
            }
            other => {
                return leave_out(match other.as_ref() {
                    Geometry::Polyline(_) => "a line needs two points".to_owned(),
                    Geometry::Cloud(_) => "it has no points".to_owned(),
                    other => {
                        format!("a {} cannot be tessellated yet: convert it to a mesh first", other.kind())
                    }
                });
            }
        };
        let moves = frames.map(|frames| Moves::new(base, frames));
        Ok(Some((shaped, moves, Own::default())))
    }

    /// Puts a shape into the document as a mesh.
    fn mesh(
        &mut self,
        index: usize,
        object: &'a Object,
        mut shaped: Shaped,
        moves: Option<Moves<'a>>,
        noted: &mut Own,
        report: &mut Written,
    ) -> Result<usize, Failure> {
        for (primitive, &(slot, sets)) in shaped.primitives.iter_mut().zip(&shaped.slots) {
            let named = object.materials.get(slot as usize);
            let found = named.and_then(|name| self.materials.named(name, sets, &mut self.bin));
            let made_up = || self.materials.color(object.color, shaped.has_colors);
            primitive.material = Some(found.unwrap_or_else(made_up));
        }
        let mut extras = None;
        if let Some(moves) = moves {
            let count = moves.count();
            let targets = moves.targets(&shaped, &mut self.bin)?;
            for primitive in &mut shaped.primitives {
                primitive.targets.clone_from(&targets);
            }
            let names: Vec<String> = (0..count).map(|k| format!("frame {k}")).collect();
            extras = Some(json!({ "targetNames": names }));
            self.keys.add(index, count, moves.rate(), &mut self.bin);
            if noted.animation.is_none() {
                noted.rate = Some(moves.rate());
            }
        }
        report.form.clone_from(&shaped.form);
        for remark in &shaped.remarks {
            explain(report, Fate::Approximated, remark);
        }
        self.meshes.push(Mesh { name: object.name().to_owned(), primitives: shaped.primitives, extras });
        Ok(self.meshes.len() - 1)
    }

    /// The fineness in the coordinates in which a shape is tessellated.
    fn fineness(&self, stretch: f64, baked: bool) -> Fineness {
        let mut fineness = self.options.fineness;
        if let Chord::Absolute(length) = &mut fineness.chord {
            if baked {
                *length *= self.change.scale;
            }
            if stretch > 0.0 {
                *length /= stretch;
            }
        }
        fineness
    }

    /// The chord tolerance in the scene's unit.
    fn tolerance(&self, fineness: &Fineness, points: &[Point], in_scene: f64) -> f64 {
        match (self.options.fineness.chord, fineness.chord) {
            (Chord::Absolute(length), _) => length,
            (_, Chord::Relative(fraction)) | (_, Chord::Absolute(fraction)) => {
                let first = points.first().copied().unwrap_or_default();
                let (low, high) = points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
                fraction * (high - low).norm() * in_scene
            }
        }
    }
}

/// Points that are needed later, or none.
trait Keep {
    fn to_vec_if(&self, needed: bool) -> Vec<Point>;
}

impl Keep for [Point] {
    fn to_vec_if(&self, needed: bool) -> Vec<Point> {
        if needed { self.to_vec() } else { Vec::new() }
    }
}

/// Says that larger faces are cut.
fn cut(mesh: &loftsman_kernel::mesh::Mesh, report: &mut Written) {
    if mesh.faces().any(|f| f.len() > 3) {
        explain(report, Fate::Approximated, "glTF has triangles only: larger faces were cut");
    }
}

fn nothing<T>(report: &mut Written) -> Result<Option<T>, Failure> {
    (report.fate, report.reason) = (Fate::LeftOut, Some("it has nothing that could be seen".to_owned()));
    Ok(None)
}

/// Adds a reason, unless the object is left out anyway.
fn explain(report: &mut Written, fate: Fate, reason: &str) {
    if report.fate == Fate::LeftOut {
        return;
    }
    report.fate = fate;
    report.reason = Some(match report.reason.take() {
        Some(before) => format!("{before}; {reason}"),
        None => reason.to_owned(),
    });
}
