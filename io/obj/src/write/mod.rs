//! The writer: one `o` an object, streamed.

mod custom;
mod exchange;
mod mesh;
mod mtl;
mod names;
mod print;
mod spline;
mod state;
mod surface;

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::io::{BufWriter, Write};

use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{
    Chord, FormatError, Holds, InWorld, Outgoing, ParameterError, Parameters, Sink, Tessellator, WriteReport,
    Written,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::{Error, Point};

use loftsman_kernel::text::counted;
pub(crate) use names::changed as changed_names;
use print::Names;
use state::State;
use surface::Fine;

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

fn choices(own: &Parameters) -> Result<(Knots, Surfaces), ParameterError> {
    let knots = [("bezier", Knots::Bezier), ("any", Knots::Any)];
    let surfaces = [("both", Surfaces::Both), ("exact", Surfaces::Exact), ("mesh", Surfaces::Mesh)];
    let knots = own.choice_or("knots", &knots, Knots::Bezier)?;
    Ok((knots, own.choice_or("surfaces", &surfaces, Surfaces::Both)?))
}

/// What files hold that are written with these options, where those written without hold `usual`.
pub(crate) fn holds(usual: Holds, own: &Parameters) -> Result<Holds, FormatError> {
    let (knots, surfaces) = choices(own)?;
    let holds = Holds { knots: knots == Knots::Any, ..usual };
    Ok(match surfaces {
        Surfaces::Both => holds,
        Surfaces::Exact => Holds { tessellated: &["shape"], ..holds },
        Surfaces::Mesh => {
            Holds { exact: &["curve", "mesh", "polyline", "cloud"], connections: false, ..holds }
        }
    })
}

/// Writes a scene.
pub(crate) fn write(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    let options = outgoing.options;
    let (knots, surfaces) = choices(&options.own)?;
    let placed = outgoing.converted()?;
    let scale = outgoing.scale();
    let cuts = outgoing.cuts(&placed, scale)?;
    let mut report = WriteReport::default();
    let triangles = options.tessellator.is_some() && surfaces != Surfaces::Exact;
    let goes_out = |object: &Object| match object.geometry() {
        Geometry::Polyline(line) => line.points.len() > 1,
        Geometry::Brep(_) => triangles,
        Geometry::Surface(_) | Geometry::Trimmed(_) => triangles || surfaces != Surfaces::Mesh,
        Geometry::Custom(custom) => custom.shape().is_ok(),
        Geometry::Curve(_) | Geometry::Mesh(_) | Geometry::Cloud(_) => true,
        _ => false,
    };
    let mut library = mtl::library(&placed, sink.name(), goes_out);
    let mut writer = Writer {
        out: BufWriter::with_capacity(1 << 16, sink.main()),
        text: String::new(),
        names: Names::beside(placed.objects().iter().filter(|object| goes_out(object)).map(Object::name)),
        written: Counts::default(),
        surface_numbers: HashMap::new(),
        exchanged: HashSet::new(),
        knots,
        surfaces,
        tessellator: options.tessellator,
        chord: options.fineness.chord,
        scale,
        library: &mut library,
        paint: None,
        color: None,
        state: State::default(),
        face_normals: placed.objects().iter().any(|o| match o.geometry() {
            Geometry::Mesh(mesh) => !mesh.normals.is_empty(),
            Geometry::Surface(_) | Geometry::Trimmed(_) | Geometry::Brep(_) => triangles,
            Geometry::Custom(custom) => surfaces != Surfaces::Exact && custom::is_surface(custom),
            _ => false,
        }),
        notes: Notes::default(),
    };
    let (unit, up) = (outgoing.unit.name(), outgoing.up.name());
    writer.line(&format!("# Loftsman; unit {unit}, {up} up"))?;
    if !writer.library.is_empty() {
        writer.line(&format!("mtllib {}", writer.library.file))?;
    }
    for (index, found) in outgoing.in_world(&placed)?.enumerate() {
        let found = found?;
        let object = found.object;
        writer.paint = mtl::paint(&placed, object);
        writer.color = object.color.filter(|color| color.iter().all(|x| x.is_finite()));
        let written = writer.object(found, Fine { fineness: cuts.of(index), beside: cuts.beside(index) });
        report.objects.push(written.map_err(|e| e.of(object.name()))?);
    }
    for connection in placed.connections() {
        writer.connection(connection)?;
    }
    writer.out.flush()?;
    let told = std::mem::take(&mut writer.notes);
    drop(writer);
    library.write(&placed, outgoing, sink, &mut report)?;
    notes(&placed, &told, &mut report);
    Ok(report)
}

/// What the writer noticed on its way.
#[derive(Debug, Default)]
struct Notes {
    /// Meshes that got a normal for each face.
    given_normals: usize,
    connections_left_out: usize,
    /// Surfaces that went out with `u` and `v` exchanged.
    exchanged: usize,
}

/// What OBJ cannot hold of meshes and connections, counted.
fn notes(scene: &Scene, told: &Notes, report: &mut WriteReport) {
    report.say(
        told.given_normals,
        "mesh[|es] without normals got one for each face: where a file has any, Blender smooths those without",
    );
    report.say(
        told.connections_left_out,
        "connection[|s] [is|are] left out: [its|their] surfaces were not written exactly",
    );
    report.say(
        told.exchanged,
        "surface[|s] [has|have] u and v exchanged: placed by a mirror, [its|their] normal[|s] would turn inward",
    );
    let cloud = |o: &Object| matches!(o.geometry(), Geometry::Cloud(_));
    report.say(
        scene.objects().iter().filter(|o| cloud(o)).count(),
        "[cloud is|clouds are] point statements (p), which Blender passes over",
    );
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
    names: Names,
    written: Counts,
    /// Surfaces that went out exactly, by their object's name: `con` refers to their numbers.
    surface_numbers: HashMap<String, usize>,
    /// Of these, which have `u` and `v` exchanged.
    exchanged: HashSet<String>,
    knots: Knots,
    surfaces: Surfaces,
    tessellator: Option<&'a dyn Tessellator>,
    /// The chord tolerance that was asked for, in the scene's unit.
    chord: Chord,
    /// Lengths in the scene to lengths in the file.
    scale: f64,
    /// The materials beside the file.
    library: &'a mut mtl::Library,
    /// The present object's colour, where nothing else says how it looks: a material shows it.
    paint: Option<[f64; 4]>,
    /// The present object's own colour.
    color: Option<[f64; 4]>,
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

    /// A line of a keyword and numbers.
    fn statement(&mut self, keyword: &str, numbers: impl IntoIterator<Item = f64>) -> std::io::Result<()> {
        self.text.push_str(keyword);
        numbers.into_iter().for_each(|x| print::number(&mut self.text, x));
        self.flush_line()
    }

    fn flush_line(&mut self) -> std::io::Result<()> {
        self.text.push('\n');
        self.out.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }

    fn object(
        &mut self,
        InWorld { object, geometry, is_mirrored }: InWorld<'_>,
        fine: Fine<'_>,
    ) -> Result<Written, FormatError> {
        let mut written = Written::kept(object, "nothing");
        let geometry = if is_mirrored { exchange::exchanged(geometry)? } else { geometry };
        match &*geometry {
            Geometry::Group => written.leave_out("OBJ has no hierarchy"),
            Geometry::Curve(curve) => {
                self.name(object.name())?;
                self.element_material(object)?;
                self.curve(curve)?;
                written.form = "NURBS curve".to_owned();
            }
            Geometry::Surface(_) | Geometry::Trimmed(_) | Geometry::Brep(_) => {
                if is_mirrored && !matches!(&*geometry, Geometry::Brep(_)) {
                    self.notes.exchanged += usize::from(self.surfaces != Surfaces::Mesh);
                    self.exchanged.insert(object.name().to_owned());
                }
                self.tessellated(object, &geometry, fine, &mut written)?;
            }
            Geometry::Mesh(mesh) => {
                self.name(object.name())?;
                let looks = self.looks(&object.materials);
                self.mesh(mesh, &looks)?;
                written.form = match (mesh.face_count(), mesh.lines().count()) {
                    (0, 0) => counted(mesh.points().len(), "point[|s]"),
                    (0, lines) => counted(lines, "line[|s]"),
                    (faces, 0) => format!("mesh of {}", counted(faces, "face[|s]")),
                    (faces, lines) => {
                        format!("mesh of {} and {}", counted(faces, "face[|s]"), counted(lines, "line[|s]"))
                    }
                };
            }
            Geometry::Polyline(line) if line.points.len() < 2 => {
                written.leave_out("a line needs two points");
            }
            Geometry::Polyline(line) => {
                self.element_material(object)?;
                self.name(object.name())?;
                let segments = self.polyline(line)?;
                written.form = format!("line of {}", counted(segments, "segment[|s]"));
            }
            Geometry::Cloud(cloud) => {
                self.element_material(object)?;
                self.name(object.name())?;
                self.cloud(cloud)?;
                written.form = counted(cloud.points.len(), "point[|s]");
            }
            Geometry::Custom(custom) => {
                self.custom(object, custom, is_mirrored, &fine.fineness, &mut written)?;
            }
            other => written.leave_out(format!("OBJ has no {}", other.kind())),
        }
        Ok(written)
    }

    /// Begins an object; the name that it got.
    fn name(&mut self, name: &str) -> std::io::Result<String> {
        let name = self.names.unique(name);
        self.line(&format!("o {name}"))?;
        if let Some(color) = self.color {
            self.statement("# Loftsman color", color)?;
        }
        Ok(name)
    }

    fn vertices(&mut self, points: &[Point], weights: Option<&[f64]>) -> Result<usize, FormatError> {
        let first = self.written.points + 1;
        for (index, p) in points.iter().enumerate() {
            if !p.iter().all(|c| c.is_finite()) {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z }.into());
            }
            self.statement("v", p.iter().copied().chain(weights.map(|weights| weights[index])))?;
        }
        self.written.points += points.len();
        Ok(first)
    }

    /// The material that a curve or surface has.
    fn element_material(&mut self, object: &Object) -> std::io::Result<()> {
        let look = self.looks(&object.materials).into_iter().next();
        self.use_look(look.as_ref())
    }

    /// The names in the library of an object's materials.
    fn looks(&self, materials: &[String]) -> Vec<Option<String>> {
        materials.iter().map(|material| self.library.name(material).cloned()).collect()
    }

    /// The look of a slot; where there is none, what shows the object's colour.
    fn use_look(&mut self, look: Option<&Option<String>>) -> std::io::Result<()> {
        let wanted = match look {
            Some(look) => look.clone(),
            None => self.paint.map(|color| self.library.paint(color)),
        };
        let name = match (wanted, &self.state.material) {
            (Some(name), _) => name,
            (None, None) => return Ok(()),
            // Programs pass over a `usemtl` without a name, and would go on with the one before.
            (None, Some(_)) => self.library.plain(),
        };
        if self.state.material.as_ref() == Some(&name) {
            return Ok(());
        }
        let line = format!("usemtl {name}");
        self.state.material = Some(name);
        self.line(&line)
    }

    /// What follows is in no group of the faces before it: curves would be named after these.
    fn ungroup(&mut self) -> std::io::Result<()> {
        if std::mem::take(&mut self.state.groups) { self.line("g default") } else { Ok(()) }
    }

    /// `l a b` pairs: MeshLab reads only the first segment of a longer `l`.
    fn polyline(&mut self, line: &Polyline) -> Result<usize, FormatError> {
        self.ungroup()?;
        let first = self.vertices(&line.points, None)?;
        let n = line.points.len();
        let segments = if line.closed { n } else { n - 1 };
        for k in 0..segments {
            _ = write!(self.text, "l {} {}", first + k, first + (k + 1) % n);
            self.flush_line()?;
        }
        Ok(segments)
    }

    fn cloud(&mut self, cloud: &Cloud) -> Result<(), FormatError> {
        self.ungroup()?;
        let first = self.vertices(&cloud.points, None)?;
        for k in 0..cloud.points.len() {
            _ = write!(self.text, "p {}", first + k);
            self.flush_line()?;
        }
        Ok(())
    }

    /// `con`: each side with a curve of its own.
    fn connection(&mut self, connection: &Connection) -> Result<(), FormatError> {
        let mut line = "con".to_owned();
        for Side { object, curve } in connection.sides() {
            let Some(&number) = self.surface_numbers.get(object) else {
                self.notes.connections_left_out += 1;
                return Ok(());
            };
            let plane_curve = if self.exchanged.contains(object) {
                self.plane_curve(&exchange::plane_curve(curve.curve())?)?
            } else {
                self.plane_curve(curve.curve())?
            };
            let (from, to) = curve.range();
            _ = write!(line, " {number}");
            print::number(&mut line, from);
            print::number(&mut line, to);
            _ = write!(line, " {plane_curve}");
        }
        Ok(self.line(&line)?)
    }
}
