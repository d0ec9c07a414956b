//! Writing: clouds and polylines as rows.

use std::io::{self, BufWriter, Write};

use loftsman_kernel::Point;
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{Fate, FormatError, Place, Sink, UpChoice, WriteOptions, WriteReport, Written};
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Object, Scene};
use nalgebra::Matrix4;

use crate::marks::{self, Kind};

/// An object that goes out, and its way into the scene's coordinates.
struct Rows<'s> {
    object: &'s Object,
    kind: Kind,
    place: Option<&'s Matrix4<f64>>,
}

impl Rows<'_> {
    /// Its points in the scene's coordinates, one after the other: nothing is kept of them.
    fn points(&self) -> impl Iterator<Item = Point> + '_ {
        let place = |p: &Point| self.place.map_or(*p, |map| transform_point(map, p));
        self.object.geometry().points().iter().map(place)
    }
}

/// Writes a point file.
pub(crate) fn file(
    scene: &Scene,
    sink: &mut dyn Sink,
    options: &WriteOptions<'_>,
) -> Result<WriteReport, FormatError> {
    let file = sink.name().to_owned();
    let fail = |problem: String| FormatError::new(&file, Place::File, problem);
    let comments =
        !options.own.has("comments") || options.own.flag("comments").map_err(|e| fail(e.to_string()))?;
    let up = match options.up {
        UpChoice::To(up) => up,
        UpChoice::Usual | UpChoice::Keep => scene.up,
    };
    let unit = options.unit.unwrap_or(scene.unit);
    let flat = scene.flattened(MOST_PLACED).map_err(|e| fail(e.to_string()))?;
    let scene = flat.converted(unit, up).map_err(|e| fail(e.to_string()))?;
    let world = scene.world_transforms().map_err(|e| fail(e.to_string()))?;

    let mut report = WriteReport::default();
    let mut out = Vec::new();
    let mut plain = 0;
    for (object, place) in scene.objects().iter().zip(&world) {
        let Some(kind) = kind_of(object) else {
            report.objects.push(left_out(object));
            continue;
        };
        let rows = Rows { object, kind, place: place.as_ref() };
        if let Some((i, p)) = rows.points().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            let problem =
                format!("point {i} is ({}, {}, {}): every coordinate must be finite", p.x, p.y, p.z);
            return Err(fail(problem).of(object.name()));
        }
        let by = if place.is_some() { ", placed by its transforms" } else { "" };
        report.objects.push(Written {
            object: object.name().to_owned(),
            form: format!("{} of {} points{by}", object.geometry().kind(), object.geometry().points().len()),
            fate: Fate::Kept,
            tolerance: None,
            error: None,
            reason: None,
        });
        plain += usize::from(object.color.is_some() || object.layer.is_some() || object.animation.is_some());
        out.push(rows);
    }
    if out.is_empty() {
        let problem = "there is no cloud and no polyline in the scene, and a point file holds nothing else: \
                       tessellate curves first, or choose another format";
        return Err(fail(problem.to_owned()));
    }
    if out.len() > 1 && !comments {
        let problem = "several objects need the comments that tell them apart: leave comments = false away, \
                       or write one object";
        return Err(fail(problem.to_owned()));
    }
    if plain > 0 {
        report
            .notes
            .push(format!("colours, layers and animations of {plain} objects: point files have none"));
    }
    let separator = if file.to_ascii_lowercase().ends_with(".csv") { b"," } else { b" " };
    let mut writer = BufWriter::with_capacity(1 << 16, sink.main());
    let head = comments.then(|| marks::file_mark(unit, up));
    write_rows(&out, head.as_deref(), separator, &mut writer)
        .map_err(|error| fail(format!("cannot be written: {error}")))?;
    Ok(report)
}

fn kind_of(object: &Object) -> Option<Kind> {
    match object.geometry() {
        Geometry::Cloud(_) => Some(Kind::Cloud),
        Geometry::Polyline(line) => Some(Kind::Polyline { closed: Some(line.closed) }),
        _ => None,
    }
}

fn left_out(object: &Object) -> Written {
    Written {
        object: object.name().to_owned(),
        form: "nothing".to_owned(),
        fate: Fate::LeftOut,
        tolerance: None,
        error: None,
        reason: Some(match object.geometry().kind() {
            "group" => "a group has no points of its own".to_owned(),
            kind => format!("a point file holds clouds and polylines, not a {kind}: tessellate it first"),
        }),
    }
}

fn write_rows(
    objects: &[Rows<'_>],
    head: Option<&str>,
    separator: &[u8],
    out: &mut impl Write,
) -> io::Result<()> {
    if separator == b"," {
        writeln!(out, "x,y,z")?;
    }
    if let Some(head) = head {
        writeln!(out, "#{head}")?;
    }
    for rows in objects {
        if head.is_some() {
            writeln!(out, "#{}", marks::object_mark(rows.object.name(), rows.kind))?;
        }
        let closing = match rows.kind {
            Kind::Polyline { closed: Some(true) } => rows.points().next(),
            _ => None,
        };
        for p in rows.points().chain(closing) {
            number(p.x, out)?;
            out.write_all(separator)?;
            number(p.y, out)?;
            out.write_all(separator)?;
            number(p.z, out)?;
            out.write_all(b"\n")?;
        }
    }
    out.flush()
}

/// The shortest decimals that read back as the same bits; whole numbers without a point, but for minus zero.
fn number(x: f64, out: &mut impl Write) -> io::Result<()> {
    // Below 2^53 the conversion is exact.
    let whole = x as i64;
    if whole as f64 == x && whole.unsigned_abs() < 1 << 53 && (whole != 0 || x.is_sign_positive()) {
        Ok(serde_json::to_writer(out, &whole)?)
    } else {
        Ok(serde_json::to_writer(out, &x)?)
    }
}
