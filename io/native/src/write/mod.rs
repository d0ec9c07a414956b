//! Writing: a scene to bytes, the same ones every time.

mod brep;
mod check;
mod layout;
mod material;
mod mesh;
mod shape;
mod spline;

use std::collections::HashMap;
use std::io;

use loftsman_kernel::material::ImageData;
use loftsman_kernel::named::NamedList;
use loftsman_kernel::plugin::{FormatError, Outgoing, Sink, WriteReport, Written};
use loftsman_kernel::scene::{Geometry, Layer, Object, Scene};

use crate::VERSION;
use layout::Layout;
use loftsman_kernel::text::counted;

/// Writes a document.
pub(crate) fn document(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    let scene = outgoing.converted()?;
    check::scene(&scene)?;
    let mut report = WriteReport::default();
    let mut layout = Layout::new(sink.main());
    write_scene(&scene, &mut layout, outgoing, &mut report)?;
    drop(layout);
    let files = scene.images.iter().filter_map(|image| match &image.data {
        ImageData::File(file) => Some(file.as_str()),
        ImageData::Embedded { .. } => None,
    });
    // The document only names them.
    outgoing.pictures(files, sink, &mut report)?;
    report.notes.extend(crate::unknown::unknown(&scene));
    Ok(report)
}

fn write_scene(
    scene: &Scene,
    out: &mut Layout<'_>,
    outgoing: &Outgoing<'_>,
    report: &mut WriteReport,
) -> Result<(), FormatError> {
    out.open_table()?;
    out.key("loftsman")?;
    out.count(VERSION)?;
    out.key("unit")?;
    out.text(&scene.unit.name())?;
    out.key("up")?;
    out.text(scene.up.name())?;
    material::statements(&scene.statements, out)?;
    write_layers(&scene.layers, out)?;
    material::write_images(&scene.images, out)?;
    material::write_materials(&scene.materials, out)?;
    let mut known = Known::of(scene);
    if !scene.definitions().is_empty() {
        out.key("definitions")?;
        out.open_list()?;
        for definition in scene.definitions() {
            out.entry()?;
            out.open_table()?;
            out.key("name")?;
            out.text(definition.name())?;
            material::statements(&definition.statements, out)?;
            let name = Some(definition.name());
            write_objects(definition.objects(), name, &mut known, out, outgoing, report)?;
            out.close_table()?;
        }
        out.close_list()?;
    }
    write_objects(scene.objects(), None, &mut known, out, outgoing, report)?;
    if !scene.connections().is_empty() {
        out.key("connections")?;
        spline::connections(scene.connections(), out)?;
    }
    out.close_table()?;
    out.finish()?;
    Ok(())
}

/// The layers of which there is more to say than that objects name them.
fn write_layers(layers: &NamedList<Layer>, out: &mut Layout<'_>) -> io::Result<()> {
    material::list("layers", layers, out, |layer, out| {
        out.key("name")?;
        out.text(layer.name())?;
        if let Some(color) = &layer.color {
            out.key("color")?;
            out.row(color)?;
        }
        if !layer.visible {
            out.key("visible")?;
            out.flag(false)?;
        }
        if let Some(parent) = &layer.parent {
            out.key("parent")?;
            out.text(parent)?;
        }
        Ok(())
    })
}

/// Geometry that objects share, by [`Object::geometry_id`].
struct Known<'s> {
    /// How often it is there.
    uses: HashMap<usize, usize>,
    /// Where it stands: the definition, and the object.
    first: HashMap<usize, (Option<&'s str>, &'s str)>,
}

impl Known<'_> {
    fn of(scene: &Scene) -> Self {
        let mut uses = HashMap::new();
        let defined = scene.definitions().iter().flat_map(|definition| definition.objects());
        for object in defined.chain(scene.objects()) {
            *uses.entry(object.geometry_id()).or_default() += 1;
        }
        Self { uses, first: HashMap::new() }
    }

    /// Whether an object's geometry is written only once.
    fn is_spared(&self, object: &Object) -> bool {
        let uses = self.uses.get(&object.geometry_id()).copied().unwrap_or_default();
        if object.geometry().is_unknown() {
            // Only where the document said so do such objects share.
            return uses > 1;
        }
        uses > 1 && !object.geometry().points().is_empty()
    }
}

/// The objects of a definition, or of the scene.
fn write_objects<'s>(
    objects: &'s [Object],
    of: Option<&'s str>,
    known: &mut Known<'s>,
    out: &mut Layout<'_>,
    outgoing: &Outgoing<'_>,
    report: &mut WriteReport,
) -> Result<(), FormatError> {
    out.key("objects")?;
    out.open_list()?;
    for (done, object) in objects.iter().enumerate() {
        outgoing.proceed(done, objects.len())?;
        out.entry()?;
        report.objects.push(write_object(object, of, known, out)?);
    }
    out.close_list()?;
    Ok(())
}

fn write_object<'s>(
    object: &'s Object,
    of: Option<&'s str>,
    known: &mut Known<'s>,
    out: &mut Layout<'_>,
) -> io::Result<Written> {
    out.open_table()?;
    out.key("name")?;
    out.text(object.name())?;
    if let Some(label) = &object.label {
        out.key("label")?;
        out.text(label)?;
    }
    if let Some(color) = &object.color {
        out.key("color")?;
        out.row(color)?;
    }
    if !object.materials.is_empty() {
        out.key("materials")?;
        out.texts(object.materials.iter().map(String::as_str))?;
    }
    if let Some(layer) = &object.layer {
        out.key("layer")?;
        out.text(layer)?;
    }
    if let Some(parent) = &object.parent {
        out.key("parent")?;
        out.text(parent)?;
    }
    if let Some(transform) = &object.transform {
        out.key("transform")?;
        out.rows((0..4).map(|i| [0, 1, 2, 3].map(|j| transform[(i, j)])))?;
    }
    material::statements(&object.statements, out)?;
    let written = write_geometry(object, of, known, out)?;
    if let Some(animation) = &object.animation {
        out.key("animation")?;
        out.open_table()?;
        out.key("rate")?;
        out.number(animation.rate)?;
        out.key("frames")?;
        out.open_list()?;
        for frame in &animation.frames {
            out.entry()?;
            out.points(frame)?;
        }
        out.close_list()?;
        out.close_table()?;
    }
    out.close_table()?;
    Ok(written)
}

fn write_geometry<'s>(
    object: &'s Object,
    of: Option<&'s str>,
    known: &mut Known<'s>,
    out: &mut Layout<'_>,
) -> io::Result<Written> {
    let mut written = Written::kept(object, "");
    if known.is_spared(object) {
        if let Some((definition, first)) = known.first.get(&object.geometry_id()) {
            out.key("same_as")?;
            out.open_table()?;
            out.key("object")?;
            out.text(first)?;
            if let Some(definition) = definition.filter(|_| *definition != of) {
                out.key("definition")?;
                out.text(definition)?;
            }
            out.close_table()?;
            written.form = format!("{}, the same as \"{first}\"", object.geometry().kind());
            return Ok(written);
        }
        known.first.insert(object.geometry_id(), (of, object.name()));
    }
    if let Geometry::Custom(custom) = object.geometry() {
        out.key("shape")?;
        written.form = shape::write(custom, out)?;
        return Ok(written);
    }
    out.key(object.geometry().kind())?;
    out.open_table()?;
    written.form = match object.geometry() {
        Geometry::Group => "group".to_owned(),
        Geometry::Instance(definition) => {
            out.key("definition")?;
            out.text(definition)?;
            format!("instance of \"{definition}\"")
        }
        Geometry::Curve(curve) => {
            spline::curve(curve, out)?;
            if let Some(form) = curve.form() {
                brep::curve_piece(form, out)?;
            }
            format!("curve of degree {} with {} vertices", curve.degree(), curve.points().len())
        }
        Geometry::Surface(surface) => {
            spline::surface(surface, out)?;
            if let Some(form) = surface.form() {
                brep::surface_piece(form, out)?;
            }
            format!("surface with {} by {} vertices", surface.u().len(), surface.v().len())
        }
        Geometry::Trimmed(trimmed) => {
            spline::trimmed(trimmed, out)?;
            format!("trimmed surface with {}", counted(trimmed.loops().count(), "loop[|s]"))
        }
        Geometry::Brep(brep) => {
            brep::brep(brep, out)?;
            format!(
                "brep of {} faces, {} edges, {} vertices",
                brep.face_count(),
                brep.edge_count(),
                brep.vertices().len()
            )
        }
        Geometry::Mesh(mesh) => {
            mesh::write(mesh, out)?;
            format!("mesh of {}", counted(mesh.face_count(), "face[|s]"))
        }
        Geometry::Polyline(line) => {
            if line.closed {
                out.key("closed")?;
                out.flag(true)?;
            }
            out.key("points")?;
            out.points(&line.points)?;
            format!("polyline of {}", counted(line.points.len(), "point[|s]"))
        }
        Geometry::Cloud(cloud) => {
            out.key("points")?;
            out.points(&cloud.points)?;
            format!("cloud of {}", counted(cloud.points.len(), "point[|s]"))
        }
        // `check` refuses kinds that this version has no name for.
        _ => String::new(),
    };
    out.close_table()?;
    Ok(written)
}
