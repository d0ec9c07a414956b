//! The writer: one `o` an object, streamed.

mod print;

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};

use loftsman_kernel::mesh::{Cloud, Mesh, NONE, Polyline};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, FormatError, Place, Sink, UpChoice, WriteOptions, WriteReport, Written,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Up};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Error, Point};

use crate::OPTIONS;

/// Whether curves go out in Bézier form or with their own knots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Knots {
    Bezier,
    Any,
}

/// Writes a scene.
pub(crate) fn write(
    scene: &Scene,
    sink: &mut dyn Sink,
    options: &WriteOptions<'_>,
) -> Result<WriteReport, FormatError> {
    let file = sink.name().to_owned();
    let fail = |problem: String| FormatError::new(&file, Place::File, problem);
    options.own.check(OPTIONS).map_err(|e| fail(e.to_string()))?;
    let knots = if options.own.has("knots") {
        let words = [("bezier", Knots::Bezier), ("any", Knots::Any)];
        options.own.choice("knots", &words).map_err(|e| fail(e.to_string()))?
    } else {
        Knots::Bezier
    };
    let unit = options.unit.unwrap_or(scene.unit);
    let up = match options.up {
        UpChoice::Usual => Up::Y,
        UpChoice::Keep => scene.up,
        UpChoice::To(up) => up,
    };
    let scale = if unit == scene.unit { 1.0 } else { scene.unit.metres() / unit.metres() };
    let placed = scene.converted(unit, up).map_err(|e| fail(e.to_string()))?;
    let world = placed.world_transforms().map_err(|e| fail(e.to_string()))?;
    let mut report = WriteReport::default();
    let mut writer = Writer {
        out: BufWriter::with_capacity(1 << 16, sink.main()),
        text: String::new(),
        names: HashSet::new(),
        points: 0,
        uvs: 0,
        normals: 0,
        knots,
        options,
        scale,
        face_normals: placed.objects().iter().any(|o| match &o.geometry {
            Geometry::Mesh(mesh) => !mesh.normals.is_empty(),
            Geometry::Surface(_) => options.tessellator.is_some(),
            _ => false,
        }),
        given: 0,
    };
    let axis = ["x", "y", "z"][up as usize];
    let io = |e: std::io::Error| fail(format!("it cannot be written: {e}"));
    writer.line(&format!("# Loftsman; unit {}, {axis} up", unit.name())).map_err(io)?;
    let total = placed.objects().len() as u64;
    for (index, (object, transform)) in placed.objects().iter().zip(&world).enumerate() {
        if options.observer.cancelled() {
            return Err(fail("writing was cancelled".to_owned()));
        }
        options.observer.progress("writing", index as u64, total);
        let geometry = match transform {
            Some(map) => Cow::Owned(
                object.geometry.transformed(map).map_err(|e| fail(e.to_string()).of(object.name()))?,
            ),
            None => Cow::Borrowed(&object.geometry),
        };
        let mirrored = transform.is_some_and(|m| m.fixed_view::<3, 3>(0, 0).determinant() < 0.0);
        let written = writer.object(object, &geometry, mirrored).map_err(|e| match e {
            Failure::Geometry(e) => fail(e.to_string()).of(object.name()),
            Failure::Stream(e) => io(e),
        })?;
        report.objects.push(written);
    }
    writer.out.flush().map_err(io)?;
    if writer.given > 0 {
        let what = "mesh(es) without normals got one for each face: where a file has any, Blender smooths those without";
        report.notes.push(format!("{} {what}", writer.given));
    }
    notes(&placed, &world, &mut report);
    Ok(report)
}

/// What OBJ cannot hold, counted.
fn notes<T>(scene: &Scene, world: &[Option<T>], report: &mut WriteReport) {
    let mut say = |count: usize, what: &str| {
        if count > 0 {
            report.notes.push(format!("{count} {what}"));
        }
    };
    let count = |has: &dyn Fn(&Object) -> bool| scene.objects().iter().filter(|o| has(o)).count();
    say(world.iter().flatten().count(), "object(s) have their transform baked in: OBJ has none");
    say(count(&|o| o.parent.is_some()), "object(s) lose their place in the hierarchy");
    say(
        count(&|o| o.animation.is_some()),
        "animation(s) are left out: the frame that the object is in was written",
    );
    say(count(&|o| o.color.is_some()), "object colour(s) are left out");
    say(count(&|o| o.layer.is_some()), "layer name(s) are left out");
    let cloud = |o: &Object| matches!(o.geometry, Geometry::Cloud(_));
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

struct Writer<'a, W: Write> {
    out: BufWriter<W>,
    /// The line being made.
    text: String,
    names: HashSet<String>,
    /// How many of each were written: indices count through the file.
    points: usize,
    uvs: usize,
    normals: usize,
    knots: Knots,
    options: &'a WriteOptions<'a>,
    /// Lengths in the scene to lengths in the file.
    scale: f64,
    /// Whether meshes without normals get one for each face, because others in the file have normals.
    face_normals: bool,
    /// How many did.
    given: usize,
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

    fn object(&mut self, object: &Object, geometry: &Geometry, mirrored: bool) -> Result<Written, Failure> {
        let mut written = Written {
            object: object.name().to_owned(),
            form: "nothing".to_owned(),
            fate: Fate::Kept,
            tolerance: None,
            reason: None,
        };
        let mut leave_out = |reason: String| {
            (written.fate, written.reason) = (Fate::LeftOut, Some(reason));
        };
        match geometry {
            Geometry::Group => leave_out("OBJ has no hierarchy".to_owned()),
            Geometry::Curve(curve) => {
                self.name(object)?;
                self.curve(curve)?;
                written.form = "NURBS curve".to_owned();
            }
            Geometry::Surface(surface) => match self.options.tessellator {
                None => leave_out("surfaces need a tessellator, and none is registered".to_owned()),
                Some(tessellator) => match tessellator.surface(surface, &self.fineness()) {
                    Err(e) => leave_out(format!("it could not be tessellated: {e}")),
                    Ok(mut mesh) => {
                        if mirrored {
                            mesh.turn_inside_out();
                        }
                        self.name(object)?;
                        self.mesh(&mesh)?;
                        written.form = format!("{} triangles", mesh.face_count());
                        written.fate = Fate::Approximated;
                        written.tolerance = Some(self.tolerance(&mesh));
                        written.reason = Some("the surface was tessellated".to_owned());
                    }
                },
            },
            Geometry::Mesh(mesh) => {
                self.name(object)?;
                self.mesh(mesh)?;
                written.form = format!("mesh of {} faces", mesh.face_count());
            }
            Geometry::Polyline(line) if line.points.len() < 2 => {
                leave_out("a line needs two points".to_owned());
            }
            Geometry::Polyline(line) => {
                self.name(object)?;
                let segments = self.polyline(line)?;
                written.form = format!("line of {segments} segments");
            }
            Geometry::Cloud(cloud) => {
                self.name(object)?;
                self.cloud(cloud)?;
                written.form = format!("{} points", cloud.points.len());
            }
            other => leave_out(format!("OBJ has no {}", other.kind())),
        }
        Ok(written)
    }

    /// The fineness in the file's unit.
    fn fineness(&self) -> Fineness {
        let mut fineness = self.options.fineness;
        if let Chord::Absolute(length) = &mut fineness.chord {
            *length *= self.scale;
        }
        fineness
    }

    /// The chord tolerance in the scene's unit, as a report gives it.
    fn tolerance(&self, mesh: &Mesh) -> f64 {
        match self.options.fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(fraction) => {
                let points = mesh.points();
                let first = points.first().copied().unwrap_or_default();
                let (low, high) = points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
                fraction * (high - low).norm() / self.scale
            }
        }
    }

    fn name(&mut self, object: &Object) -> std::io::Result<()> {
        let clean = print::name(object.name());
        let mut name = clean.clone();
        let mut number = 1;
        while !self.names.insert(name.clone()) {
            name = format!("{clean}.{number:03}");
            number += 1;
        }
        self.line(&format!("o {name}"))
    }

    fn vertices(&mut self, points: &[Point]) -> Result<usize, Failure> {
        let first = self.points + 1;
        for (index, p) in points.iter().enumerate() {
            if !p.iter().all(|c| c.is_finite()) {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z }.into());
            }
            self.text.push('v');
            print::point(&mut self.text, p);
            self.flush_line()?;
        }
        self.points += points.len();
        Ok(first)
    }

    fn curve(&mut self, curve: &Curve) -> Result<(), Failure> {
        let form =
            if self.knots == Knots::Bezier { Cow::Owned(curve.bezier_form()?) } else { Cow::Borrowed(curve) };
        let (space, p) = (form.space(), form.degree());
        let first = self.points + 1;
        for (i, point) in form.points().iter().enumerate() {
            self.text.push('v');
            print::point(&mut self.text, point);
            if let Some(weights) = form.weights() {
                print::number(&mut self.text, weights[i]);
            }
            self.flush_line()?;
        }
        self.points += form.points().len();
        self.line(if form.weights().is_some() { "cstype rat bspline" } else { "cstype bspline" })?;
        self.line(&format!("deg {p}"))?;
        let (a, b) = space.domain();
        self.text.push_str("curv");
        print::number(&mut self.text, a);
        print::number(&mut self.text, b);
        // A periodic curve repeats its first control vertices: that is how OBJ closes one.
        for k in 0..space.unrolled_len() {
            _ = write!(self.text, " {}", first + space.vertex(k));
        }
        self.flush_line()?;
        self.text.push_str("parm u");
        space.flat().iter().for_each(|&t| print::number(&mut self.text, t));
        self.flush_line()?;
        Ok(self.line("end")?)
    }

    fn mesh(&mut self, mesh: &Mesh) -> Result<(), Failure> {
        let color = |corner: usize, point: u32| mesh.colors.at(corner, point);
        let point = if mesh.colors.is_empty() {
            self.vertices(mesh.points())?
        } else {
            // OBJ has one colour a vertex: that of the first corner there, white where there is none.
            let mut colors: Vec<_> = (0..mesh.points().len()).map(|i| color(usize::MAX, i as u32)).collect();
            for (corner, &point) in mesh.corners().iter().enumerate().rev() {
                colors[point as usize] = color(corner, point);
            }
            for (p, color) in mesh.points().iter().zip(colors) {
                self.text.push('v');
                print::point(&mut self.text, p);
                let color = color.copied().unwrap_or([1.0; 4]);
                color[..3].iter().for_each(|&c| print::number(&mut self.text, print::srgb(c)));
                self.flush_line()?;
            }
            self.points += mesh.points().len();
            self.points + 1 - mesh.points().len()
        };
        let (uv, normal) = (self.uvs + 1, self.normals + 1);
        for uv in mesh.uvs.values() {
            self.text.push_str("vt");
            uv.iter().for_each(|&c| print::number(&mut self.text, c));
            self.flush_line()?;
        }
        self.uvs += mesh.uvs.values().len();
        for n in mesh.normals.values() {
            self.text.push_str("vn");
            n.iter().for_each(|&c| print::number(&mut self.text, c));
            self.flush_line()?;
        }
        self.normals += mesh.normals.values().len();
        let own_normals = self.face_normals && mesh.normals.is_empty();
        self.given += usize::from(own_normals);
        self.line(if mesh.normals.is_empty() { "s off" } else { "s 1" })?;
        for (face, pair) in mesh.starts().windows(2).enumerate() {
            // Where the file has normals, a mesh without them gives each face its own; one without area has none.
            let flat = if own_normals { mesh.face_normal(face) } else { None };
            if let Some(flat) = flat {
                self.text.push_str("vn");
                flat.iter().for_each(|&c| print::number(&mut self.text, c));
                self.flush_line()?;
                self.normals += 1;
            }
            self.text.push('f');
            for corner in pair[0]..pair[1] {
                let vertex = mesh.corners()[corner];
                _ = write!(self.text, " {}", point + vertex as usize);
                let place = |first: usize, index: u32| (index != NONE).then(|| first + index as usize);
                let uv = place(uv, mesh.uvs.index(corner, vertex));
                let normal = flat.map(|_| self.normals).or(place(normal, mesh.normals.index(corner, vertex)));
                if uv.is_some() || normal.is_some() {
                    self.text.push('/');
                }
                if let Some(uv) = uv {
                    _ = write!(self.text, "{uv}");
                }
                if let Some(normal) = normal {
                    _ = write!(self.text, "/{normal}");
                }
            }
            self.flush_line()?;
        }
        Ok(())
    }

    /// `l a b` pairs: MeshLab reads only the first segment of a longer `l`.
    fn polyline(&mut self, line: &Polyline) -> Result<usize, Failure> {
        let first = self.vertices(&line.points)?;
        let n = line.points.len();
        let segments = if line.closed { n } else { n - 1 };
        for k in 0..segments {
            _ = write!(self.text, "l {} {}", first + k, first + (k + 1) % n);
            self.flush_line()?;
        }
        Ok(segments)
    }

    fn cloud(&mut self, cloud: &Cloud) -> Result<(), Failure> {
        let first = self.vertices(&cloud.points)?;
        for k in 0..cloud.points.len() {
            _ = write!(self.text, "p {}", first + k);
            self.flush_line()?;
        }
        Ok(())
    }
}
