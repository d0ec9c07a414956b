//! Whether a format is one: round trips, reports that add up, hostile bytes.

use std::sync::Arc;

use nalgebra::Matrix4;

use super::{Lcg, Verdict};
use crate::brep::Brep;
use crate::mesh::{Cloud, Mesh, Polyline};
use crate::plugin::{Fate, Format, Holds, Memory, ReadOptions, ShapeKind, WriteOptions, WriteReport};
use crate::scene::{Definition, Geometry, Object, Scene, Unit, Up};
use crate::shape::{Derivative, Location, Shape};
use crate::spline::trimmed::{ParameterCurve, Region};
use crate::spline::{Curve, Space, Surface, Trimmed};
use crate::text::counted;
use crate::{Point, Vector};

/// A scene with one object of each kind, awkward numbers and awkward names.
pub fn sample_scene() -> Scene {
    let mut random = Lcg::new(5);
    let mut points = |n: usize| -> Vec<Point> {
        (0..n)
            .map(|i| Point::new(i as f64 + random.next(), random.next() * 1e3, random.next() / 3.0))
            .collect()
    };
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.up = Up::Z;
    let uneven = || Space::clamped(3, &[0.0, 0.1, 1.0 / 3.0, 2.0, 2.5]);
    let mut objects = vec![Object::new("group", Geometry::Group)];
    let mut add = |name: &str, geometry: Geometry| objects.push(Object::new(name, geometry));
    if let Ok(curve) = uneven().and_then(|s| Curve::new(s, points(7))) {
        add("clamped curve", curve.into());
    }
    if let Ok(curve) =
        Space::periodic(3, vec![0.0, 0.5, 1.25, 2.0, 2.1, 3.0]).and_then(|s| Curve::new(s, points(5)))
    {
        add("ring \"é\" <&>", curve.into());
    }
    let weights = vec![1.0, 0.5_f64.sqrt(), 1.0, 2.0, 1.0];
    if let Ok(curve) = Space::clamped_uniform(2, 5).and_then(|s| Curve::rational(s, points(5), weights)) {
        add("rational", curve.into());
    }
    let net = |points: Vec<Point>| {
        points.into_iter().enumerate().map(|(k, p)| p + Vector::z() * (k % 4) as f64).collect()
    };
    if let Ok(surface) =
        Space::clamped_uniform(2, 4).and_then(|v| Surface::new(uneven()?, v, net(points(28))))
    {
        add("patch", surface.into());
    }
    if let Ok(trimmed) = window(net(points(28))) {
        add("window", trimmed.into());
    }
    if let Ok(block) = Brep::block(Point::new(-0.1, 0.0, 1.0 / 3.0), Point::new(2.0, 3.0, 5.0)) {
        add("block", block.into());
    }
    let corners = [[0, 1, 2, 3], [3, 2, 5, 4]];
    if let Ok(mesh) = Mesh::new(points(6), &corners) {
        add("mesh", mesh.into());
    }
    add("chain", Polyline { points: points(5), closed: false }.into());
    add("cloud", Cloud { points: points(4) }.into());
    for mut object in objects {
        object.color = Some([0.25, 0.5, 0.75, 1.0]);
        object.layer = Some("frames".into());
        if object.name() != "group" {
            object.parent = Some("group".into());
        }
        // Names are unique here.
        let _ = scene.add(object);
    }
    scene
}

/// The objects of [`sample_scene`] as a definition, which another one shows twice, and the scene twice that: what a format
/// without instances writes one by one.
pub fn sample_assembly() -> Scene {
    let sample = sample_scene();
    let mut part = Definition::new("part");
    let mut pair = Definition::new("pair \"é\"");
    let mut scene = sample.around();
    let shows = |name: &str, of: &str, x: f64| {
        let mut object = Object::new(name, Geometry::Instance(of.into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(x, 0.0, 1.0 / 3.0)));
        object
    };
    // Names are unique here.
    for object in sample.objects() {
        let _ = part.add(object.clone());
    }
    for (name, x) in [("left", -1e3), ("right", 1e3)] {
        let _ = pair.add(shows(name, "part", x));
        let _ = scene.add(shows(name, "pair \"é\"", 1e2 * x));
    }
    let _ = scene.define(pair);
    let _ = scene.define(part);
    scene
}

/// A surface with a round part cut out of a square one.
fn window(net: Vec<Point>) -> crate::Result<Trimmed> {
    let u = Space::clamped(3, &[0.0, 0.1, 1.0 / 3.0, 2.0, 2.5])?;
    let surface = Surface::new(u, Space::clamped_uniform(2, 4)?, net)?;
    let at = |x: f64, y: f64| Point::new(x, y, 0.0);
    let corners = [at(0.1, 0.1), at(2.4, 0.1), at(2.4, 0.9), at(0.1, 0.9)];
    let side = |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 4])?);
    let outer = (0..4).map(side).collect::<crate::Result<_>>()?;
    let hole = vec![ParameterCurve::whole(Curve::circle(at(1.0, 0.5), Vector::z(), 0.3)?)?];
    let seam = vec![side(0)?];
    Trimmed::new(surface, vec![Region { outer, holes: vec![hole] }], vec![seam], vec![[1.0 / 3.0, 0.5]])
}

/// Checks a format on a scene: what it writes it reads again (where it does both), what it says it kept is there then, by
/// name, kind and numbers, writing is deterministic and what was read is written alike, reports account for everything, and
/// truncated, altered and random bytes give errors that name the file.
pub fn format_conformance(format: &dyn Format, scene: &Scene) -> Verdict {
    let mut verdict = Verdict::default();
    let declaration = format.declaration();
    let kinds = kinds(scene);
    let options = ReadOptions { kinds: &kinds, ..ReadOptions::default() };
    let extension = declaration.extensions.first().copied().unwrap_or_default();
    verdict.check(!extension.is_empty() && !declaration.help.is_empty(), || "no extension or no help".into());
    let file = format!("sample.{extension}");
    let write = |scene: &Scene| {
        let mut memory = Memory::new(file.clone(), Vec::new());
        format.write(scene, &mut memory, &WriteOptions::default()).map(|report| (memory, report))
    };
    let mut bytes = b"1 2 3\n4 5 6\n7 8 9\n".to_vec();
    if declaration.writes {
        match (write(scene), write(scene)) {
            (Ok((first, report)), Ok((second, _))) => {
                verdict.check(
                    first.bytes == second.bytes
                        && first.siblings == second.siblings
                        && first.pictures == second.pictures,
                    || "writing twice gives other bytes".into(),
                );
                for object in scene.objects() {
                    let name = object.name();
                    let Some(written) = report.objects.iter().find(|w| w.object == name) else {
                        verdict.check(false, || format!("the report does not say what became of \"{name}\""));
                        continue;
                    };
                    // An instance may be a group that stands for it.
                    let is_exact = declaration.holds.exactly(object.geometry());
                    let as_declared = match written.fate {
                        Fate::Kept => is_exact || matches!(object.geometry(), Geometry::Instance(_)),
                        Fate::Approximated => true,
                        Fate::LeftOut => !is_exact,
                    };
                    verdict.check(as_declared, || {
                        format!("what the report says of \"{name}\" is not what the format declares to hold")
                    });
                }
                bytes.clone_from(&first.bytes);
                if declaration.reads {
                    round_trip(&mut verdict, (format, &options), (scene, &report), &first, &write);
                }
            }
            (Err(error), _) | (_, Err(error)) => {
                verdict.check(false, || format!("a sample is not written: {error}"));
            }
        }
    }
    if declaration.reads {
        hostile(&mut verdict, (format, &options), &file, &bytes);
    }
    verdict
}

/// The kinds of the shapes of plug-ins in a scene.
fn kinds(scene: &Scene) -> Vec<Arc<dyn ShapeKind>> {
    let defined = scene.definitions().iter().flat_map(Definition::objects);
    let kind = |object: &Object| match object.geometry() {
        Geometry::Custom(custom) => custom.shape_kind().cloned(),
        _ => None,
    };
    defined.chain(scene.objects()).filter_map(kind).collect()
}

type Write<'a> = dyn Fn(&Scene) -> Result<(Memory, WriteReport), crate::plugin::FormatError> + 'a;

fn round_trip(
    verdict: &mut Verdict,
    (format, options): (&dyn Format, &ReadOptions<'_>),
    (scene, told): (&Scene, &WriteReport),
    written: &Memory,
    write: &Write<'_>,
) {
    let read = match format.read(written, options) {
        Ok((scene, report)) => {
            verdict.check(report.adds_up(), || format!("the read report does not add up: {report:?}"));
            verdict.check(scene.check().is_ok(), || "the hierarchy that was read is broken".into());
            scene
        }
        Err(error) => return verdict.check(false, || format!("what was written is not read: {error}")),
    };
    for written in told.objects.iter().filter(|written| written.fate == Fate::Kept) {
        if let Some(before) = scene.get(&written.object) {
            kept(verdict, before, read.get(&written.object), (scene, &read), &format.declaration().holds);
        }
    }
    // Once through the format, a scene is what the format can hold: from there on nothing may change.
    match write(&read) {
        Ok((again, _)) => match format.read(&again, options) {
            Ok((twice, _)) => {
                let same = twice == if format.declaration().holds.labels { read } else { unlabelled(&read) };
                verdict.check(same, || "a second round trip changes the scene".into());
            }
            Err(error) => verdict.check(false, || format!("the second writing is not read: {error}")),
        },
        Err(error) => verdict.check(false, || format!("what was read is not written: {error}")),
    }
}

/// A scene whose objects have names and no labels.
fn unlabelled(scene: &Scene) -> Scene {
    let mut plain = scene.clone();
    for object in scene.objects() {
        if let Ok(object) = plain.object_mut(object.name()) {
            object.label = None;
        }
    }
    plain
}

/// Numbers of a format in single precision are those that went in to this part of the largest.
const SINGLE: f64 = 1e-6;
/// Splines are looked at in so many places of each parameter, and one more.
const PLACES: usize = 24;

/// An object that is said to have gone out exactly is there after reading: of the same kind (instances perhaps as groups), with
/// the same points; of splines those at the same parameters, since the same spline has other knots in other forms. In the unit
/// and axes of either scene: not every format has these.
fn kept(
    verdict: &mut Verdict,
    before: &Object,
    after: Option<&Object>,
    (scene, read): (&Scene, &Scene),
    holds: &Holds,
) {
    let name = before.name();
    let Some(after) = after else {
        return verdict
            .check(false, || format!("\"{name}\" is said to be kept, and is not there after reading"));
    };
    verdict.check(!holds.labels || before.label() == after.label(), || {
        format!("\"{name}\" is labelled \"{}\", and comes back as \"{}\"", before.label(), after.label())
    });
    let of = |object: &Object, scene: &Scene| {
        let layer = object.layer.clone();
        let hidden = scene.hidden_layers().hides(object);
        (layer, hidden, scene.color_of(object).is_some())
    };
    verdict.check(!holds.layers || of(before, scene) == of(after, read), || {
        format!("\"{name}\" comes back on another layer, or one that is hidden or has a colour where it was not so")
    });
    if matches!(before.geometry(), Geometry::Instance(_)) {
        return;
    }
    let kinds = (before.geometry().kind(), after.geometry().kind());
    verdict.check(kinds.0 == kinds.1, || {
        format!("\"{name}\" is said to be kept, and comes back as a {}, not a {}", kinds.1, kinds.0)
    });
    let was = looked_at(before.geometry());
    let size = was.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    let same = |scene: &Scene| {
        let is = scene.get(name).map(|object| looked_at(object.geometry())).unwrap_or_default();
        was.len() == is.len() && was.iter().zip(&is).all(|(a, b)| (a - b).amax() <= SINGLE * size)
    };
    let mut turned = read.clone();
    turned.unit = scene.unit;
    let ways = [read.converted(scene.unit, scene.up), turned.converted(scene.unit, scene.up)];
    verdict.check(same(read) || ways.iter().flatten().any(|way| same(way)), || {
        format!("\"{name}\" is said to be kept, and comes back elsewhere")
    });
}

/// The points of a geometry, or of a spline at places all over.
fn looked_at(geometry: &Geometry) -> Vec<Point> {
    if let Geometry::Brep(brep) = geometry {
        return (0..brep.face_count()).map(|face| middle_of_loops(brep, face)).collect();
    }
    let Ok(shape) = geometry.shape() else { return geometry.points().to_vec() };
    places(shape, PLACES)
        .into_iter()
        .filter_map(|at| Some(shape.value(at, Derivative::POSITION).ok()?.into()))
        .collect()
}

/// The mean of some points of a face's edges: where it is, whatever piece of its plane carries it, and in whatever order its edges come.
fn middle_of_loops(brep: &Brep, face: usize) -> Point {
    let uses = brep.loops(face).iter().flatten().filter_map(|one| brep.edge(one.edge));
    let points = uses.flat_map(|edge| {
        let (from, to) = edge.range;
        let at = |k: usize| from + (to - from) * (k as f64 + 0.5) / PLACES as f64;
        (0..PLACES).filter_map(|k| edge.curve.point(at(k)).ok()).collect::<Vec<_>>()
    });
    let (sum, count) = points.fold((Vector::zeros(), 0), |(sum, count), p| (sum + p.coords, count + 1));
    Point::from(sum / f64::from(count.max(1)))
}

/// So many places of each parameter of a shape, and one more.
pub(super) fn places(shape: &dyn Shape, count: usize) -> Vec<Location> {
    let domain = shape.domain();
    let at =
        |k: usize, j: usize| domain[k].start + (domain[k].end - domain[k].start) * j as f64 / count as f64;
    match (domain.len(), shape.faces()) {
        (1, _) => (0..=count).map(|j| Location::Curve(at(0, j))).collect(),
        (_, Some(faces)) => {
            let step = faces.div_ceil(count * count).max(1);
            // Of few faces several places each.
            let each = ((count as f64 / (faces.max(1) as f64).sqrt()) as usize).clamp(2, count.max(2));
            let share = |face: u32, k: usize, j: usize| {
                let domain = shape.face_domain(face);
                domain
                    .get(k)
                    .map_or(0.0, |side| side.start + (side.end - side.start) * j as f64 / each as f64)
            };
            let some = (0..u32::try_from(faces).unwrap_or(u32::MAX)).step_by(step);
            let pairs = (0..=each).flat_map(|i| (0..=each).map(move |j| (i, j)));
            some.flat_map(|face| pairs.clone().map(move |(i, j)| (face, i, j)))
                .map(|(face, i, j)| Location::Face(face, share(face, 0, i), share(face, 1, j)))
                .collect()
        }
        _ => {
            let pairs = (0..=count).flat_map(|i| (0..=count).map(move |j| (i, j)));
            pairs.map(|(i, j)| Location::Surface(at(0, i), at(1, j))).collect()
        }
    }
}

fn hostile(
    verdict: &mut Verdict,
    (format, options): (&dyn Format, &ReadOptions<'_>),
    file: &str,
    good: &[u8],
) {
    let mut random = Lcg::new(11);
    let mut samples: Vec<Vec<u8>> =
        vec![Vec::new(), vec![0], vec![b'{'], vec![0xff; 64], b"\xef\xbb\xbf".to_vec()];
    samples.extend((0..24).map(|k| good[..good.len() * k / 24].to_vec()));
    samples.extend((0..48).map(|_| {
        let mut bytes = good.to_vec();
        for _ in 0..3 {
            let at = random.below(bytes.len());
            if let Some(byte) = bytes.get_mut(at) {
                *byte = random.below(256) as u8;
            }
        }
        bytes
    }));
    samples.push((0..4096).map(|_| random.below(256) as u8).collect());
    samples.push(b"[".repeat(200_000));
    samples.push(b"{\"a\":".repeat(100_000));
    for bytes in samples {
        let memory = Memory::new(file, bytes);
        match format.read(&memory, options) {
            Ok((scene, report)) => {
                verdict.check(report.adds_up(), || format!("the read report does not add up: {report:?}"));
                let finite = scene
                    .objects()
                    .iter()
                    .flat_map(|o| o.geometry().points())
                    .all(|p| p.iter().all(|c| c.is_finite()));
                verdict.check(finite, || "NaN or infinity came through".into());
            }
            Err(error) => verdict.check(error.file == file && !error.problem.is_empty(), || {
                format!("an error does not name its file or its problem: {error}")
            }),
        }
    }
    for bytes in [Vec::new(), vec![b'x']] {
        let refused = format.read(&Memory::new(file, bytes.clone()), options).is_err();
        verdict.check(refused, || format!("a file of {} is accepted", counted(bytes.len(), "byte[|s]")));
    }
}
