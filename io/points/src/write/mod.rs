//! Writing: clouds and polylines as rows.

use std::io::{self, BufWriter, Write};

use loftsman_kernel::Point;
use loftsman_kernel::error::Figure;
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{FormatError, Outgoing, Sink, WriteReport, Written};
use loftsman_kernel::scene::{Geometry, Object};
use loftsman_kernel::text::a;
use loftsman_kernel::text::number;
use nalgebra::Matrix4;

use crate::marks::{self, Kind};
use loftsman_kernel::text::counted;

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
pub(crate) fn file(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    let own = &outgoing.options.own;
    let comments = !own.has("comments") || own.flag("comments")?;
    let scene = outgoing.converted()?;
    let world = scene.world_transforms()?;
    let mut report = WriteReport::default();
    let mut out = Vec::new();
    for (done, (object, place)) in scene.objects().iter().zip(&world).enumerate() {
        outgoing.proceed(done, world.len())?;
        let Some(kind) = kind_of(object) else {
            report.objects.push(Written::left_out(object, reason(object.geometry().kind())));
            continue;
        };
        let rows = Rows { object, kind, place: place.as_ref() };
        if let Some((i, p)) = rows.points().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            let problem = format!(
                "point {i} is ({}, {}, {}): every coordinate must be finite",
                Figure(p.x),
                Figure(p.y),
                Figure(p.z)
            );
            return Err(FormatError::whole(problem).of(object.name()));
        }
        let by = if place.is_some() { ", placed by its transforms" } else { "" };
        let form = format!(
            "{} of {}{by}",
            object.geometry().kind(),
            counted(object.geometry().points().len(), "point[|s]")
        );
        report.objects.push(Written::kept(object, form));
        out.push(rows);
    }
    if out.len() > 1 && !comments {
        return Err(FormatError::whole(
            "several objects need the comments that tell them apart: leave comments = false away, or write \
             one object",
        ));
    }
    let separator = if sink.name().to_ascii_lowercase().ends_with(".csv") { b"," } else { b" " };
    let mut writer = BufWriter::with_capacity(1 << 16, sink.main());
    let head = comments.then(|| marks::file_mark(outgoing.unit, outgoing.up));
    write_rows(&out, head.as_deref(), separator, &mut writer)?;
    Ok(report)
}

fn kind_of(object: &Object) -> Option<Kind> {
    match object.geometry() {
        Geometry::Cloud(_) => Some(Kind::Cloud),
        Geometry::Polyline(line) => Some(Kind::Polyline { closed: Some(line.closed) }),
        _ => None,
    }
}

/// Why an object of a kind does not go out.
fn reason(kind: &str) -> String {
    match kind {
        "group" => "a group has no points of its own".to_owned(),
        "curve" => {
            "a point file holds clouds and polylines, not a curve: tessellate or sample it first".to_owned()
        }
        kind => format!("a point file holds clouds and polylines, not {}", a(kind)),
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
            for (k, c) in p.iter().enumerate() {
                out.write_all(if k == 0 { b"" } else { separator })?;
                number(out, *c)?;
            }
            out.write_all(b"\n")?;
        }
    }
    out.flush()
}
