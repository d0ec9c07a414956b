//! Points, lines and triangles as primitives: what goes into the buffer, and what the document says of it.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use loftsman_kernel::mesh::{Layer, Mesh, NONE};
use loftsman_kernel::{Error, Point, Result, Vector};

use super::bin::{Bin, Kind, Out, Use};
use super::material::shade;
use super::schema::Primitive;
use crate::extras::fingerprint;
use crate::place::Change;
use crate::triangulate;

pub(super) const POINTS: u8 = 0;
pub(super) const LINES: u8 = 1;
pub(super) const LINE_STRIP: u8 = 3;
pub(super) const TRIANGLES: u8 = 4;

/// How far from the origin, in multiples of its own size, a shape may be before it is moved there. A coordinate
/// then is rounded by less than 5e-7 of the size.
const FAR: f64 = 8.0;

/// How far the square of a normal's length may be from 1. Within it, it is written as it is: quantised normals are no
/// longer, and the validator allows more.
const UNIT: f64 = 0.01;

/// From points of a shape to what is written: the change of unit and axes, and a move towards the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    change: Change,
    pub(super) centre: Vector,
    low: [f32; 3],
    high: [f32; 3],
}

impl Frame {
    /// The frame of a shape's points.
    pub(super) fn of(points: &[Point], change: Change) -> Result<Self> {
        let mut frame = Self { change, centre: Vector::zeros(), low: [0.0; 3], high: [0.0; 3] };
        let Some(first) = points.first() else { return Ok(frame) };
        let (mut low, mut high) = (frame.moved(first), frame.moved(first));
        for (index, p) in points.iter().enumerate() {
            let q = frame.moved(p);
            (low, high) = (low.inf(&q), high.sup(&q));
            // Comparisons pass over NaN.
            if !(q.x + q.y + q.z).is_finite() {
                return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
            }
        }
        let largest = low.amax().max(high.amax());
        let size = (high - low).norm();
        if size > 0.0 && size.is_finite() && largest > FAR * size {
            frame.centre = low + (high - low) * 0.5;
        }
        // Rounding keeps the order: the bounds of the rounded numbers are the rounded bounds.
        (frame.low, frame.high) = (single(low - frame.centre), single(high - frame.centre));
        if !frame.low.iter().chain(&frame.high).all(|x| x.is_finite()) {
            let far = |p: &&Point| !single(frame.moved(p)).iter().all(|x| x.is_finite());
            let index = points.iter().position(|p| far(&p)).unwrap_or(0);
            let p = points[index];
            return Err(Error::Invalid(format!(
                "point {index} is ({}, {}, {}), beyond single precision, which glTF has: choose another unit",
                p.x, p.y, p.z
            )));
        }
        Ok(frame)
    }

    fn moved(&self, p: &Point) -> Vector {
        if self.change.is_none() { p.coords } else { self.change.turn * p.coords * self.change.scale }
    }

    /// A point as it is written.
    pub(super) fn position(&self, p: &Point) -> [f32; 3] {
        single(self.moved(p) - self.centre)
    }

    /// A normal as it is written; one without length (of a point that no face has) is any.
    fn normal(&self, n: &Vector) -> [f32; 3] {
        let n = if self.change.is_none() { *n } else { self.change.turn * n };
        let is_unit = (n.norm_squared() - 1.0).abs() <= UNIT;
        single(if is_unit { n } else { n.try_normalize(0.0).unwrap_or_else(Vector::z) })
    }

    fn bounds(&self) -> [Vec<f32>; 2] {
        [self.low.to_vec(), self.high.to_vec()]
    }

    /// By how much coordinates may be rounded.
    pub(super) fn rounding(&self) -> f64 {
        let largest = self.low.iter().chain(&self.high).fold(0.0_f32, |m, x| m.max(x.abs()));
        f64::from(largest) * f64::from(f32::EPSILON) / 2.0
    }
}

fn single(v: Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn put<const N: usize>(numbers: [f32; N], out: &mut Out<'_>) -> io::Result<()> {
    numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn put_index(index: u32, kind: Kind, out: &mut Out<'_>) -> io::Result<()> {
    if kind.is_narrow() {
        out.write_all(&(index as u16).to_le_bytes())
    } else {
        out.write_all(&index.to_le_bytes())
    }
}

/// An object's shape, written.
#[derive(Debug)]
pub(super) struct Shaped {
    pub(super) primitives: Vec<Primitive>,
    /// The slot of each primitive's material, and how many sets of texture coordinates it has.
    pub(super) slots: Vec<(u32, u32)>,
    pub(super) frame: Frame,
    /// What it became: `"12 triangles"`.
    pub(super) form: String,
    /// What had to be changed.
    pub(super) remarks: Vec<String>,
    pub(super) has_colors: bool,
    /// For each point that was written, the point of the shape that it comes from, where they are not the same.
    pub(super) doubled: Vec<u32>,
}

/// What can go wrong: with the shape, or with memory that is written to (which does not fail).
#[derive(Debug)]
pub(super) enum Failure {
    Shape(Error),
    Io(io::Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Shape(error)
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Shape(error) => write!(f, "{error}"),
            Self::Io(error) => write!(f, "it cannot be written: {error}"),
        }
    }
}

/// Values that are poured later where the scene lends them, or else now.
fn values<'a, T>(
    bin: &mut Bin<'a>,
    list: Cow<'a, [T]>,
    kind: Kind,
    used: Use,
    bounds: Option<[Vec<f32>; 2]>,
    one: impl Fn(&T, &mut Out<'_>) -> io::Result<()> + 'a,
) -> io::Result<usize>
where
    [T]: ToOwned,
{
    match list {
        Cow::Borrowed(list) => {
            let pour = move |out: &mut Out<'_>| list.iter().try_for_each(|v| one(v, out));
            Ok(bin.later(kind, used, list.len(), bounds, Box::new(pour)))
        }
        Cow::Owned(_) => {
            bin.now(kind, used, list.len(), bounds, |out| list.iter().try_for_each(|v| one(v, out)))
        }
    }
}

fn positions<'a>(bin: &mut Bin<'a>, points: Cow<'a, [Point]>, frame: Frame) -> io::Result<usize> {
    let one = move |p: &Point, out: &mut Out<'_>| put(frame.position(p), out);
    values(bin, points, Kind::floats(3), Use::Vertices, Some(frame.bounds()), one)
}

fn primitive(attributes: BTreeMap<String, usize>, indices: Option<usize>, mode: u8) -> Primitive {
    Primitive { attributes, indices, material: None, mode, targets: Vec::new() }
}

/// Loose points (mode [`POINTS`]), or a chain of them ([`LINE_STRIP`]); a closed one comes back to its first vertex by its
/// indices.
pub(super) fn chain<'a>(
    points: Cow<'a, [Point]>,
    mode: u8,
    closed: bool,
    change: Change,
    bin: &mut Bin<'a>,
) -> std::result::Result<Shaped, Failure> {
    let frame = Frame::of(&points, change)?;
    let count = points.len();
    let position = positions(bin, points, frame)?;
    let indices = if closed {
        let (kind, n) = (Kind::indices(count), count as u32);
        let all = move |out: &mut Out<'_>| (0..n).chain([0]).try_for_each(|i| put_index(i, kind, out));
        Some(bin.later(kind, Use::Indices, count + 1, None, Box::new(all)))
    } else {
        None
    };
    let form = match mode {
        POINTS => format!("{count} points"),
        _ => format!("line strip of {} segments", count - usize::from(!closed)),
    };
    Ok(Shaped {
        primitives: vec![primitive(BTreeMap::from([("POSITION".to_owned(), position)]), indices, mode)],
        slots: vec![(0, 0)],
        frame,
        form,
        remarks: Vec::new(),
        has_colors: false,
        doubled: Vec::new(),
    })
}

/// The fingerprint of the points as they are written.
pub(super) fn shown_by(points: &[Point], frame: &Frame) -> String {
    fingerprint(points.iter().map(|p| frame.position(p)))
}

/// A mesh: its faces by material, its lines (unless `faces_only`), or its points where it has neither. `None` where
/// nothing is to be seen.
pub(super) fn mesh<'a>(
    mesh: Cow<'a, Mesh>,
    change: Change,
    faces_only: bool,
    bin: &mut Bin<'a>,
) -> std::result::Result<Option<Shaped>, Failure> {
    match mesh {
        Cow::Borrowed(mesh) => {
            let by_point = mesh.by_point()?;
            match by_point.mesh {
                Cow::Borrowed(flat) => Planner {
                    original: mesh,
                    flat,
                    lent: Some(flat),
                    change,
                    faces_only,
                    doubled: Vec::new(),
                }
                .plan(bin),
                Cow::Owned(flat) => {
                    let doubled = by_point.doubled;
                    Planner { original: mesh, flat: &flat, lent: None, change, faces_only, doubled }.plan(bin)
                }
            }
        }
        Cow::Owned(mesh) => {
            let by_point = mesh.by_point()?;
            let doubled = by_point.doubled;
            Planner { original: &mesh, flat: &by_point.mesh, lent: None, change, faces_only, doubled }
                .plan(bin)
        }
    }
}

struct Planner<'m, 'a> {
    /// As the scene has it.
    original: &'m Mesh,
    /// With all layers by point.
    flat: &'m Mesh,
    /// The same, where the scene lends it.
    lent: Option<&'a Mesh>,
    change: Change,
    faces_only: bool,
    doubled: Vec<u32>,
}

impl<'a> Planner<'_, 'a> {
    fn lend<T: Clone>(&self, list: impl for<'x> Fn(&'x Mesh) -> &'x [T]) -> Cow<'a, [T]> {
        match self.lent {
            Some(mesh) => Cow::Borrowed(list(mesh)),
            None => Cow::Owned(list(self.flat).to_vec()),
        }
    }

    fn plan(self, bin: &mut Bin<'a>) -> std::result::Result<Option<Shaped>, Failure> {
        let mut remarks = Vec::new();
        let faces = self.faces(&mut remarks);
        let lines = if self.faces_only { 0 } else { self.flat.lines().map(|l| l.len() - 1).sum::<usize>() };
        let has_faces = faces.iter().any(|(_, list)| list.count() > 0);
        let points_only = !self.faces_only && self.flat.face_count() == 0 && lines == 0;
        if self.flat.points().is_empty() || !(has_faces || lines > 0 || points_only) {
            return Ok(None);
        }
        let frame = Frame::of(self.flat.points(), self.change)?;
        let position = positions(bin, self.lend(Mesh::points), frame)?;
        let attributes = self.attributes(frame, bin, &mut remarks)?;
        let count = self.flat.points().len();
        let kind = Kind::indices(count);
        let (mut primitives, mut slots, mut triangles) = (Vec::new(), Vec::new(), 0);
        let mut has_colors = false;
        let mut add = |attributes: &Attributes, indices, mode, slot| {
            let (map, sets) = attributes.of(slot, position);
            has_colors |= map.contains_key("COLOR_0");
            primitives.push(primitive(map, indices, mode));
            slots.push((slot.unwrap_or(0), sets));
        };
        for (slot, list) in faces {
            if list.count() == 0 {
                continue;
            }
            triangles += list.count() / 3;
            let one = move |i: &u32, out: &mut Out<'_>| put_index(*i, kind, out);
            let indices = match list {
                Indices::Corners(_) => values(bin, self.lend(Mesh::corners), kind, Use::Indices, None, one)?,
                Indices::List(list) => values(bin, Cow::Owned(list), kind, Use::Indices, None, one)?,
            };
            add(&attributes, Some(indices), TRIANGLES, Some(slot));
        }
        let mut form = if triangles > 0 { format!("{triangles} triangles") } else { String::new() };
        if lines > 0 {
            let pairs: Vec<u32> =
                self.flat.lines().flat_map(|l| l.windows(2).flatten().copied().collect::<Vec<_>>()).collect();
            let one = move |i: &u32, out: &mut Out<'_>| put_index(*i, kind, out);
            let indices = values(bin, Cow::Owned(pairs), kind, Use::Indices, None, one)?;
            add(&attributes, Some(indices), LINES, None);
            form += if triangles > 0 { ", " } else { "" };
            form += &format!("{lines} line segments");
        }
        if points_only {
            add(&attributes, None, POINTS, None);
            form = format!("{count} points");
        }
        if self.faces_only && self.flat.lines().next().is_some() {
            remarks.push("its lines were left out, as only meshes were asked for".to_owned());
        }
        if !self.original.groups.is_empty() {
            remarks.push("its groups of faces were left out".to_owned());
        }
        if !self.original.smoothing.is_empty() {
            remarks.push("its smoothing groups were left out".to_owned());
        }
        Ok(Some(Shaped { primitives, slots, frame, form, remarks, has_colors, doubled: self.doubled }))
    }

    /// The triangles of each slot.
    fn faces(&self, remarks: &mut Vec<String>) -> Vec<(u32, Indices)> {
        let mesh = self.flat;
        let first = mesh.materials.first().copied().unwrap_or(0);
        let one_slot = mesh.materials.iter().all(|&s| s == first);
        let only_triangles = mesh.corners().len() == 3 * mesh.face_count();
        let is_flat = |t: &[u32]| t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
        if one_slot && only_triangles && !mesh.corners().chunks_exact(3).any(is_flat) {
            return vec![(first, Indices::Corners(mesh.corners().len()))];
        }
        let mut by_slot: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let (mut large, mut flat) = (false, 0);
        for (face, corners) in mesh.faces().enumerate() {
            let slot = mesh.materials.get(face).copied().unwrap_or(0);
            let list = by_slot.entry(slot).or_default();
            let before = list.len();
            triangulate::face(mesh.points(), corners, list);
            flat += corners.len() - 2 - (list.len() - before) / 3;
            large |= corners.len() > triangulate::EARS;
        }
        if flat > 0 {
            remarks.push(format!("{flat} triangle(s) that use a point twice were left out"));
        }
        if large {
            remarks.push("very large faces were cut as fans".to_owned());
        }
        by_slot.into_iter().map(|(slot, list)| (slot, Indices::List(list))).collect()
    }

    fn attributes(
        &self,
        frame: Frame,
        bin: &mut Bin<'a>,
        remarks: &mut Vec<String>,
    ) -> std::result::Result<Attributes, Failure> {
        let (flat, original) = (self.flat, self.original);
        let mut found = Attributes::default();
        if !flat.normals.is_empty() {
            let good = |n: &Vector| n.iter().all(|x| x.is_finite()) && n.amax() > 0.0;
            // Points without faces may lack one.
            let of_corners = || flat.corners().iter().filter_map(|&p| flat.normals.values().get(p as usize));
            if flat.normals.values().iter().all(good) || of_corners().all(good) {
                let list = self.lend(|m: &Mesh| m.normals.values());
                let one = move |n: &Vector, out: &mut Out<'_>| put(frame.normal(n), out);
                let accessor = values(bin, list, Kind::floats(3), Use::Vertices, None, one)?;
                found.normals = Some((accessor, self.slots(&original.normals, "normals", remarks)));
            } else {
                remarks.push("normals without length were left out, and all others with them".to_owned());
            }
        }
        let sets = std::iter::once(&flat.uvs).chain(&flat.more_uvs);
        let originals = std::iter::once(&original.uvs).chain(&original.more_uvs);
        for (k, (layer, original)) in sets.zip(originals).enumerate() {
            let finite = |uv: &[f64; 2]| (uv[0] as f32).is_finite() && ((1.0 - uv[1]) as f32).is_finite();
            if layer.is_empty() || !layer.values().iter().all(finite) {
                if !layer.is_empty() {
                    remarks.push("texture coordinates that are not finite were left out".to_owned());
                }
                found.uvs.push(None);
                continue;
            }
            let list = self.lend(|m: &Mesh| if k == 0 { m.uvs.values() } else { m.more_uvs[k - 1].values() });
            let one = |uv: &[f64; 2], out: &mut Out<'_>| put([uv[0] as f32, (1.0 - uv[1]) as f32], out);
            let accessor = values(bin, list, Kind::floats(2), Use::Vertices, None, one)?;
            found.uvs.push(Some((accessor, self.slots(original, "texture coordinates", remarks))));
        }
        // Sets count up from 0 without a gap.
        while found.uvs.last().is_some_and(Option::is_none) {
            found.uvs.pop();
        }
        if found.uvs.iter().any(Option::is_none) {
            let count = flat.points().len();
            let zeros = move |out: &mut Out<'_>| (0..count).try_for_each(|_| put([0.0, 0.0], out));
            found.filler = Some(bin.later(Kind::floats(2), Use::Vertices, count, None, Box::new(zeros)));
        }
        if !flat.colors.is_empty() {
            let colors = flat.colors.values();
            if !colors.iter().flatten().all(|c| (0.0..=1.0).contains(c)) {
                remarks.push("colours outside 0 to 1 were cut off there".to_owned());
            }
            let list = self.lend(|m: &Mesh| m.colors.values());
            let is_opaque = colors.iter().all(|c| c[3] == 1.0);
            let accessor = if is_opaque {
                let one =
                    |c: &[f64; 4], out: &mut Out<'_>| put([c[0], c[1], c[2]].map(|x| shade(x) as f32), out);
                values(bin, list, Kind::floats(3), Use::Vertices, None, one)?
            } else {
                let one = |c: &[f64; 4], out: &mut Out<'_>| put(c.map(|x| shade(x) as f32), out);
                values(bin, list, Kind::floats(4), Use::Vertices, None, one)?
            };
            found.colors = Some((accessor, self.slots(&original.colors, "colours", remarks)));
        }
        Ok(found)
    }

    /// The slots whose faces have values in a layer: `None` for all, lines and points too.
    fn slots<T>(&self, layer: &Layer<T>, what: &str, remarks: &mut Vec<String>) -> Option<BTreeSet<u32>> {
        let corners = layer.corners()?;
        let (mut with, mut without) = (BTreeSet::new(), BTreeSet::new());
        for (face, pair) in self.original.starts().windows(2).enumerate() {
            let slot = self.original.materials.get(face).copied().unwrap_or(0);
            for &corner in &corners[pair[0]..pair[1]] {
                if corner == NONE {
                    without.insert(slot)
                } else {
                    with.insert(slot)
                };
            }
        }
        if with.intersection(&without).next().is_some() {
            remarks.push(format!("{what} that some corners lack were filled in there"));
        }
        Some(with)
    }
}

/// Indices of triangles.
enum Indices {
    /// All of the mesh's corners, so many.
    Corners(usize),
    List(Vec<u32>),
}

impl Indices {
    fn count(&self) -> usize {
        match self {
            Self::Corners(count) => *count,
            Self::List(list) => list.len(),
        }
    }
}

/// An accessor, and the slots that refer to it (`None` for all).
type Attribute = (usize, Option<BTreeSet<u32>>);

/// The accessors of a mesh's layers.
#[derive(Default)]
struct Attributes {
    normals: Option<Attribute>,
    uvs: Vec<Option<Attribute>>,
    /// Zeros for sets that a later set needs before it.
    filler: Option<usize>,
    colors: Option<Attribute>,
}

impl Attributes {
    /// The attributes of a slot's primitive (of lines and points without one), and how many sets it has.
    fn of(&self, slot: Option<u32>, position: usize) -> (BTreeMap<String, usize>, u32) {
        let has = |attribute: &Option<Attribute>| match (attribute, slot) {
            (Some((accessor, None)), _) => Some(*accessor),
            (Some((accessor, Some(slots))), Some(slot)) => slots.contains(&slot).then_some(*accessor),
            _ => None,
        };
        let mut map = BTreeMap::from([("POSITION".to_owned(), position)]);
        if let Some(accessor) = has(&self.normals) {
            map.insert("NORMAL".to_owned(), accessor);
        }
        if let Some(accessor) = has(&self.colors) {
            map.insert("COLOR_0".to_owned(), accessor);
        }
        let last = self.uvs.iter().rposition(|set| has(set).is_some());
        let sets = last.map_or(0, |last| last + 1);
        for (k, set) in self.uvs.iter().enumerate().take(sets) {
            let any = set.as_ref().map(|(accessor, _)| *accessor).or(self.filler);
            if let Some(accessor) = has(set).or(any) {
                map.insert(format!("TEXCOORD_{k}"), accessor);
            }
        }
        (map, sets as u32)
    }
}

/// What each frame adds to the points, as accessors of morph targets. `frame` gives the points of a frame, in the order
/// of `points`.
pub(super) fn targets<'a>(
    points: &[Point],
    shaped: &Shaped,
    frames: usize,
    frame: impl Fn(usize) -> Result<Vec<Point>>,
    bin: &mut Bin<'a>,
) -> std::result::Result<Vec<BTreeMap<&'static str, usize>>, Failure> {
    let at = shaped.frame;
    let mut targets = Vec::with_capacity(frames);
    for k in 0..frames {
        let moved = frame(k)?;
        let sources = (0..points.len()).chain(shaped.doubled.iter().map(|&p| p as usize));
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let mut moves = Vec::with_capacity(points.len() + shaped.doubled.len());
        for i in sources {
            let (Some(p), Some(q)) = (points.get(i), moved.get(i)) else { continue };
            // From what is written, so that the sum is the frame to rounding.
            let base = Vector::from(at.position(p).map(f64::from));
            let delta = single(at.moved(q) - at.centre - base);
            if !delta.iter().all(|x| x.is_finite()) {
                return Err(
                    Error::Invalid(format!("point {i} of frame {k} is beyond single precision")).into()
                );
            }
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(delta[axis]), high[axis].max(delta[axis]));
            }
            moves.push(delta);
        }
        let bounds = Some([low.to_vec(), high.to_vec()]);
        let one = |d: &[f32; 3], out: &mut Out<'_>| put(*d, out);
        let accessor = values(bin, Cow::Owned(moves), Kind::floats(3), Use::Vertices, bounds, one)?;
        targets.push(BTreeMap::from([("POSITION", accessor)]));
    }
    Ok(targets)
}
