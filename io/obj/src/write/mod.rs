//! The writer: one `o` an object, streamed.

mod custom;
mod mesh;
mod mtl;
mod print;
mod spline;
mod state;

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};

use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format as _, FormatError, ParameterError, Place, Sink, Tessellated, UpChoice,
    WriteOptions, WriteReport, Written,
};
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Object, Scene, Up};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point};

use crate::Obj;
use state::State;

/// Whether curves go out in Bézier form or with their own knots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Knots {
    Bezier,
    Any,
}

/// What surfaces go out as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Surfaces {
    Both,
    Exact,
    Mesh,
}

fn choices(options: &WriteOptions<'_>) -> Result<(Knots, Surfaces), ParameterError> {
    let own = &options.own;
    own.check(Obj.declaration().writing_options())?;
    let knots = if own.has("knots") {
        own.choice("knots", &[("bezier", Knots::Bezier), ("any", Knots::Any)])?
    } else {
        Knots::Bezier
    };
    let surfaces = if own.has("surfaces") {
        let words = [("both", Surfaces::Both), ("exact", Surfaces::Exact), ("mesh", Surfaces::Mesh)];
        own.choice("surfaces", &words)?
    } else {
        Surfaces::Both
    };
    Ok((knots, surfaces))
}

/// Writes a scene.
pub(crate) fn write(
    scene: &Scene,
    sink: &mut dyn Sink,
    options: &WriteOptions<'_>,
) -> Result<WriteReport, FormatError> {
    let file = sink.name().to_owned();
    let fail = |problem: String| FormatError::new(&file, Place::File, problem);
    let (knots, surfaces) = choices(options).map_err(|e| fail(e.to_string()))?;
    let unit = options.unit.unwrap_or(scene.unit);
    let up = match options.up {
        UpChoice::Usual => Up::Y,
        UpChoice::Keep => scene.up,
        UpChoice::To(up) => up,
    };
    let scale = if unit == scene.unit { 1.0 } else { scene.unit.metres() / unit.metres() };
    let flat = scene.flattened(MOST_PLACED).map_err(|e| fail(e.to_string()))?;
    let placed = flat.converted(unit, up).map_err(|e| fail(e.to_string()))?;
    let world = placed.world_transforms().map_err(|e| fail(e.to_string()))?;
    let joined = match options.fineness.chord {
        Chord::Relative(_) => placed.joined_diagonals().map_err(|e| fail(e.to_string()))?,
        Chord::Absolute(_) => Vec::new(),
    };
    let mut report = WriteReport::default();
    let library = mtl::library(&placed, &file);
    let mut writer = Writer {
        out: BufWriter::with_capacity(1 << 16, sink.main()),
        text: String::new(),
        names: HashMap::new(),
        written: Counts::default(),
        surface_numbers: HashMap::new(),
        knots,
        surfaces,
        options,
        scale,
        materials: library.names.clone(),
        state: State::default(),
        face_normals: placed.objects().iter().any(|o| match o.geometry() {
            Geometry::Mesh(mesh) => !mesh.normals.is_empty(),
            Geometry::Surface(_) => options.tessellator.is_some() && surfaces != Surfaces::Exact,
            Geometry::Custom(custom) => surfaces != Surfaces::Exact && custom::is_surface(custom),
            _ => false,
        }),
        notes: Notes::default(),
    };
    let axis = ["x", "y", "z"][up as usize];
    let io = |e: std::io::Error| fail(format!("it cannot be written: {e}"));
    writer.line(&format!("# Loftsman; unit {}, {axis} up", unit.name())).map_err(io)?;
    if !library.is_empty() {
        writer.line(&format!("mtllib {}", library.file)).map_err(io)?;
    }
    let total = placed.objects().len() as u64;
    for (index, (object, transform)) in placed.objects().iter().zip(&world).enumerate() {
        if options.observer.cancelled() {
            return Err(fail("writing was cancelled".to_owned()));
        }
        options.observer.progress("writing", index as u64, total);
        let geometry = match transform {
            Some(map) if !object.geometry().is_unknown() => Cow::Owned(
                object.geometry().transformed(map).map_err(|e| fail(e.to_string()).of(object.name()))?,
            ),
            _ => Cow::Borrowed(object.geometry()),
        };
        let mirrored = transform.is_some_and(|m| m.fixed_view::<3, 3>(0, 0).determinant() < 0.0);
        let written = writer
            .object(object, &geometry, mirrored, joined.get(index).copied().flatten())
            .map_err(|e| match e {
                Failure::Geometry(e) => fail(e.to_string()).of(object.name()),
                Failure::Stream(e) => io(e),
            })?;
        report.objects.push(written);
    }
    for connection in placed.connections() {
        writer.connection(connection).map_err(|e| match e {
            Failure::Geometry(e) => fail(e.to_string()),
            Failure::Stream(e) => io(e),
        })?;
    }
    writer.out.flush().map_err(io)?;
    let told = std::mem::take(&mut writer.notes);
    drop(writer);
    library.write(&placed, options.pictures, sink, &mut report)?;
    notes(&placed, &world, &told, &mut report);
    Ok(report)
}

/// What the writer noticed on its way.
#[derive(Debug, Default)]
struct Notes {
    /// Meshes that got a normal for each face.
    given_normals: usize,
    /// Meshes of which colours differ between the faces at a point.
    colors_by_face: usize,
    /// Group names in which a blank became a low line.
    group_names: usize,
    connections_left_out: usize,
}

/// What OBJ cannot hold, counted.
fn notes<T>(scene: &Scene, world: &[Option<T>], told: &Notes, report: &mut WriteReport) {
    let mut say = |count: usize, what: &str| {
        if count > 0 {
            report.notes.push(format!("{count} {what}"));
        }
    };
    say(
        told.given_normals,
        "mesh(es) without normals got one for each face: where a file has any, Blender smooths those without",
    );
    say(
        told.colors_by_face,
        "mesh(es) have colours that differ between the faces at a point: one of them went out",
    );
    say(told.group_names, "group name(s) had blanks, which OBJ does not allow");
    say(told.connections_left_out, "connection(s) are left out: their surfaces were not written exactly");
    let count = |has: &dyn Fn(&Object) -> bool| scene.objects().iter().filter(|o| has(o)).count();
    say(world.iter().flatten().count(), "object(s) have their transform baked in: OBJ has none");
    say(count(&|o| o.parent.is_some()), "object(s) lose their place in the hierarchy");
    say(
        count(&|o| o.animation.is_some()),
        "animation(s) are left out: the frame that the object is in was written",
    );
    say(count(&|o| o.color.is_some()), "object colour(s) are left out");
    say(count(&|o| o.layer.is_some()), "layer name(s) are left out");
    let tangents = |o: &Object| matches!(o.geometry(), Geometry::Mesh(mesh) if !mesh.tangents.is_empty());
    say(count(&tangents), "mesh(es) have tangents, which are left out");
    let of_objects = scene.objects().iter().map(|o| o.statements.len()).sum::<usize>();
    let foreign = |key: &str| !key.starts_with("mtl ");
    let of_materials =
        scene.materials.iter().map(|m| m.statements.iter().filter(|(key, _)| foreign(key)).count());
    say(
        scene.statements.len() + of_objects + of_materials.sum::<usize>(),
        "statement(s) of other formats are left out",
    );
    let more = |o: &Object| matches!(o.geometry(), Geometry::Mesh(mesh) if !mesh.more_uvs.is_empty());
    say(count(&more), "mesh(es) have further texture coordinates, which are left out");
    let cloud = |o: &Object| matches!(o.geometry(), Geometry::Cloud(_));
    say(count(&cloud), "cloud(s) are point statements (p), which Blender passes over");
    report.notes.push("OBJ has no unit: a reader must know it".to_owned());
}

enum Failure {
    Geometry(Error),
    Stream(std::io::Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Geometry(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::Stream(error)
    }
}

/// How many of each were written: indices count through the file.
#[derive(Debug, Default)]
struct Counts {
    points: usize,
    uvs: usize,
    normals: usize,
    parameters: usize,
    plane_curves: usize,
    surfaces: usize,
}

struct Writer<'a, W: Write> {
    out: BufWriter<W>,
    /// The line being made.
    text: String,
    /// The names that are taken, and the last number behind each that was tried: all before it are taken too.
    names: HashMap<String, usize>,
    written: Counts,
    /// Surfaces that went out exactly, by their object's name: `con` refers to their numbers.
    surface_numbers: HashMap<String, usize>,
    knots: Knots,
    surfaces: Surfaces,
    options: &'a WriteOptions<'a>,
    /// Lengths in the scene to lengths in the file.
    scale: f64,
    /// The names of materials in the library, by those of the scene.
    materials: HashMap<String, String>,
    /// What holds for the faces that come now.
    state: State,
    /// Whether meshes without normals get one for each face, because others in the file have normals.
    face_normals: bool,
    notes: Notes,
}

impl<W: Write> Writer<'_, W> {
    fn line(&mut self, text: &str) -> std::io::Result<()> {
        self.out.write_all(text.as_bytes())?;
        self.out.write_all(b"\n")
    }

    fn flush_line(&mut self) -> std::io::Result<()> {
        self.text.push('\n');
        self.out.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }

    /// `joined` is the size of all that the object hangs together with, if it does.
    fn object(
        &mut self,
        object: &Object,
        geometry: &Geometry,
        mirrored: bool,
        joined: Option<f64>,
    ) -> Result<Written, Failure> {
        let mut written = Written {
            object: object.name().to_owned(),
            form: "nothing".to_owned(),
            fate: Fate::Kept,
            tolerance: None,
            error: None,
            reason: None,
        };
        let mut leave_out = |reason: String| {
            (written.fate, written.reason) = (Fate::LeftOut, Some(reason));
        };
        match geometry {
            Geometry::Group => leave_out("OBJ has no hierarchy".to_owned()),
            Geometry::Curve(curve) => {
                self.name(object.name())?;
                self.element_material(object)?;
                self.curve(curve)?;
                written.form = "NURBS curve".to_owned();
            }
            Geometry::Surface(surface) => {
                let fineness = self.fineness(joined);
                self.surface_object(object, surface, mirrored, &fineness, &mut written)?;
            }
            Geometry::Trimmed(_) if self.surfaces == Surfaces::Mesh => {
                let what = "trimmed surfaces cannot be tessellated yet: write them exactly";
                leave_out(format!("{what} (surfaces = \"both\" or \"exact\")"));
            }
            Geometry::Trimmed(trimmed) => {
                self.element_material(object)?;
                let loops = self.trimmed(object.name(), trimmed)?;
                written.form = format!("trimmed surface of {loops} loops (surf)");
                let what = "trimmed surfaces cannot be tessellated yet";
                let reason =
                    format!("{what}: programs that read no surf, as Blender and MeshLab, show nothing");
                written.reason = Some(reason);
            }
            Geometry::Mesh(mesh) => {
                self.name(object.name())?;
                self.mesh(mesh, &object.materials)?;
                written.form = match (mesh.face_count(), mesh.lines().count()) {
                    (0, 0) => format!("{} points", mesh.points().len()),
                    (0, lines) => format!("{lines} line(s)"),
                    (faces, 0) => format!("mesh of {faces} faces"),
                    (faces, lines) => format!("mesh of {faces} faces and {lines} line(s)"),
                };
            }
            Geometry::Polyline(line) if line.points.len() < 2 => {
                leave_out("a line needs two points".to_owned());
            }
            Geometry::Polyline(line) => {
                self.element_material(object)?;
                self.name(object.name())?;
                let segments = self.polyline(line)?;
                written.form = format!("line of {segments} segments");
            }
            Geometry::Cloud(cloud) => {
                self.element_material(object)?;
                self.name(object.name())?;
                self.cloud(cloud)?;
                written.form = format!("{} points", cloud.points.len());
            }
            Geometry::Custom(custom) => {
                let fineness = self.fineness(joined);
                self.custom(object, custom, mirrored, &fineness, &mut written)?;
            }
            other => leave_out(format!("OBJ has no {}", other.kind())),
        }
        Ok(written)
    }

    /// A surface exactly, beside its tessellation, or one of both.
    fn surface_object(
        &mut self,
        object: &Object,
        surface: &Surface,
        mirrored: bool,
        fineness: &Fineness,
        written: &mut Written,
    ) -> Result<(), Failure> {
        let exact = self.surfaces != Surfaces::Mesh;
        let mesh = match self.options.tessellator {
            _ if self.surfaces == Surfaces::Exact => Err("only exact surfaces were asked for".to_owned()),
            None => Err("surfaces need a tessellator, and none is registered".to_owned()),
            Some(tessellator) => tessellator
                .measured_surface(surface, fineness)
                .map_err(|e| format!("it could not be tessellated: {e}")),
        };
        match mesh {
            Ok(Tessellated { mut mesh, tolerance, error }) => {
                if mirrored {
                    mesh.turn_inside_out();
                }
                self.name(object.name())?;
                self.mesh(&mesh, &object.materials)?;
                written.form = format!("{} triangles", mesh.face_count());
                written.tolerance = Some(match self.options.fineness.chord {
                    Chord::Absolute(length) => length,
                    Chord::Relative(_) => tolerance / self.scale,
                });
                written.error = Some(error / self.scale);
                if !exact {
                    written.fate = Fate::Approximated;
                    written.reason = Some("the surface was tessellated".to_owned());
                }
            }
            Err(problem) if exact => {
                let what = "programs that read no surf, as Blender and MeshLab, show nothing";
                written.reason = Some(format!("{problem}: {what}"));
            }
            Err(problem) => (written.fate, written.reason) = (Fate::LeftOut, Some(problem)),
        }
        if exact {
            // An object of its own: Blender makes a curve of what follows a cstype.
            self.element_material(object)?;
            self.name(object.name())?;
            self.surface(object.name(), surface)?;
            let beside =
                if written.tolerance.is_some() { format!(" beside {}", written.form) } else { String::new() };
            written.form = format!("NURBS surface (surf){beside}");
        }
        Ok(())
    }

    /// The fineness in the file's unit: of surfaces that hang together, relative to all of them, so that they still do.
    fn fineness(&self, joined: Option<f64>) -> Fineness {
        let mut fineness = self.options.fineness;
        fineness.chord = match (fineness.chord, joined) {
            (Chord::Absolute(length), _) => Chord::Absolute(length * self.scale),
            (Chord::Relative(fraction), Some(size)) => Chord::Absolute(fraction * size),
            (chord, None) => chord,
        };
        fineness
    }

    fn name(&mut self, name: &str) -> std::io::Result<()> {
        let clean = print::name(name);
        let mut name = clean.clone();
        if let Some(&tried) = self.names.get(&clean) {
            let mut number = tried;
            while self.names.contains_key(&name) {
                number += 1;
                name = format!("{clean}.{number:03}");
            }
            self.names.insert(clean, number);
        }
        self.names.insert(name.clone(), 0);
        self.line(&format!("o {name}"))
    }

    fn vertices(&mut self, points: &[Point], weights: Option<&[f64]>) -> Result<usize, Failure> {
        let first = self.written.points + 1;
        for (index, p) in points.iter().enumerate() {
            if !p.iter().all(|c| c.is_finite()) {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z }.into());
            }
            self.text.push('v');
            print::point(&mut self.text, p);
            if let Some(weights) = weights {
                print::number(&mut self.text, weights[index]);
            }
            self.flush_line()?;
        }
        self.written.points += points.len();
        Ok(first)
    }

    /// The material that a curve or surface has.
    fn element_material(&mut self, object: &Object) -> std::io::Result<()> {
        self.use_material(object.materials.first().map(String::as_str))
    }

    fn use_material(&mut self, material: Option<&str>) -> std::io::Result<()> {
        let name = material.and_then(|m| self.materials.get(m));
        if self.state.material.as_ref() == name {
            return Ok(());
        }
        self.state.material = name.cloned();
        let line = name.map_or_else(|| "usemtl".to_owned(), |name| format!("usemtl {name}"));
        self.line(&line)
    }

    /// `l a b` pairs: MeshLab reads only the first segment of a longer `l`.
    fn polyline(&mut self, line: &Polyline) -> Result<usize, Failure> {
        let first = self.vertices(&line.points, None)?;
        let n = line.points.len();
        let segments = if line.closed { n } else { n - 1 };
        for k in 0..segments {
            _ = write!(self.text, "l {} {}", first + k, first + (k + 1) % n);
            self.flush_line()?;
        }
        Ok(segments)
    }

    fn cloud(&mut self, cloud: &Cloud) -> Result<(), Failure> {
        let first = self.vertices(&cloud.points, None)?;
        for k in 0..cloud.points.len() {
            _ = write!(self.text, "p {}", first + k);
            self.flush_line()?;
        }
        Ok(())
    }

    /// `con`: each side with a curve of its own.
    fn connection(&mut self, connection: &Connection) -> Result<(), Failure> {
        let mut line = "con".to_owned();
        for Side { object, curve } in connection.sides() {
            let Some(&number) = self.surface_numbers.get(object) else {
                self.notes.connections_left_out += 1;
                return Ok(());
            };
            let plane_curve = self.plane_curve(curve.curve())?;
            let (from, to) = curve.range();
            _ = write!(line, " {number}");
            print::number(&mut line, from);
            print::number(&mut line, to);
            _ = write!(line, " {plane_curve}");
        }
        Ok(self.line(&line)?)
    }
}
