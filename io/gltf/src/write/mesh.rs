//! Meshes as primitives: one for each material, one for the lines, all with the same vertices.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::triangulate;
use loftsman_kernel::mesh::{Layer, Mesh, NONE};
use loftsman_kernel::placement::Change;
use loftsman_kernel::plugin::FormatError;

use super::bin::{Bin, Kind, Out, Use};
use super::frame::Frame;
use super::material::shade;
use super::shape::{
    LINES, NORMAL, POINTS, Shaped, TRIANGLES, Turning, positions, primitive, put, put_index, values,
};
use super::tangent::with_tangents;
use loftsman_kernel::text::counted;

/// A mesh: its faces by material, its lines (unless `faces_only`), or its points where it has neither. Slots of which
/// `maps` says that the material has a normal map, and for which set of texture coordinates, have tangents. Where it
/// `moves`, what its normals turn with is kept. `None` where nothing is to be seen.
pub(super) fn mesh<'a>(
    mesh: Cow<'a, Mesh>,
    change: Change,
    faces_only: bool,
    maps: &BTreeMap<u32, u32>,
    moves: bool,
    bin: &mut Bin<'a>,
) -> Result<Option<Shaped>, FormatError> {
    if let Some(mut cut) = with_tangents(&mesh, maps)? {
        // Only to say that they are left out.
        cut.groups.clone_from(&mesh.groups);
        let shaped = shaped(Cow::Owned(cut), change, faces_only, moves, bin)?;
        return Ok(shaped.map(|shaped| Shaped { made_tangents: true, ..shaped }));
    }
    shaped(mesh, change, faces_only, moves, bin)
}

fn shaped<'a>(
    mesh: Cow<'a, Mesh>,
    change: Change,
    faces_only: bool,
    moves: bool,
    bin: &mut Bin<'a>,
) -> Result<Option<Shaped>, FormatError> {
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
                    moves,
                    doubled: Vec::new(),
                }
                .plan(bin),
                Cow::Owned(flat) => {
                    let doubled = by_point.doubled;
                    Planner { original: mesh, flat: &flat, lent: None, change, faces_only, moves, doubled }
                        .plan(bin)
                }
            }
        }
        Cow::Owned(mesh) => {
            let by_point = mesh.by_point()?;
            let doubled = by_point.doubled;
            Planner { original: &mesh, flat: &by_point.mesh, lent: None, change, faces_only, moves, doubled }
                .plan(bin)
        }
    }
}

/// A normal whose product with that of its triangle is at least this is the triangle's own.
const FLAT: f64 = 1.0 - 1e-6;

/// Whether a normal points anywhere.
fn is_direction(n: &Vector) -> bool {
    n.iter().all(|x| x.is_finite()) && n.amax() > 0.0
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
    moves: bool,
    doubled: Vec<u32>,
}

impl<'a> Planner<'_, 'a> {
    fn lend<T: Clone>(&self, list: impl for<'x> Fn(&'x Mesh) -> &'x [T]) -> Cow<'a, [T]> {
        match self.lent {
            Some(mesh) => Cow::Borrowed(list(mesh)),
            None => Cow::Owned(list(self.flat).to_vec()),
        }
    }

    fn plan(self, bin: &mut Bin<'a>) -> Result<Option<Shaped>, FormatError> {
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
        let short = if self.moves { self.flat_all_round(&faces) } else { Vec::new() };
        let attributes = self.attributes(frame, &short, bin, &mut remarks)?;
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
        let mut form = if triangles > 0 { counted(triangles, "triangle[|s]") } else { String::new() };
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
            form = counted(count, "point[|s]");
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
        let turning = match attributes.normals.is_some() && self.moves {
            true => Some(self.turning(short)?),
            false => None,
        };
        let (doubled, made_tangents) = (self.doubled, false);
        Ok(Some(Shaped {
            primitives,
            slots,
            paints: Vec::new(),
            frame,
            form,
            remarks,
            has_colors,
            doubled,
            made_tangents,
            turning,
        }))
    }

    /// What the normals turn with.
    fn turning(&self, short: Vec<bool>) -> Result<Turning, FormatError> {
        let (original, flat) = (self.original, self.flat);
        let corners = original.corners().to_vec();
        let mut mesh = Mesh::from_parts(original.points().to_vec(), corners, original.starts().to_vec())?;
        mesh.normals = original.normals.clone();
        // The corners of both are in one order. What no face has stays as it is.
        let mut of = vec![NONE; flat.points().len()];
        for (corner, (&own, &point)) in flat.corners().iter().zip(original.corners()).enumerate() {
            let index = original.normals.index(corner, point);
            // What was filled in stays as it is.
            let turns = original.normals.values().get(index as usize).is_some_and(is_direction);
            of[own as usize] = if turns { index } else { NONE };
        }
        Ok(Turning { mesh, of, short })
    }

    /// The normals of all points, and how many of them were filled in: where one has no length or is not finite, it is the mean of the faces'
    /// at the point; where these have no area, that of another corner of them; else an axis.
    fn filled_normals(&self) -> (Vec<Vector>, usize) {
        let (flat, normals) = (self.flat, self.flat.normals.values());
        let mut found: Vec<Vector> = normals.to_vec();
        let mut sums: BTreeMap<u32, (Vector, Option<Vector>)> = BTreeMap::new();
        for (at, face) in flat.faces().enumerate() {
            let lacks = |p: &u32| !normals.get(*p as usize).is_some_and(is_direction);
            if !face.iter().any(lacks) {
                continue;
            }
            let own = flat.face_normal(at).unwrap_or_else(Vector::zeros);
            let other = face.iter().find(|p| !lacks(p)).map(|&p| normals[p as usize]);
            for &p in face.iter().filter(|p| lacks(p)) {
                let (sum, beside) = sums.entry(p).or_insert((Vector::zeros(), None));
                *sum += own;
                *beside = beside.or(other);
            }
        }
        let filled = sums.len();
        for (p, (sum, beside)) in sums {
            let direction = sum.try_normalize(0.0).filter(is_direction);
            found[p as usize] = direction.or(beside).unwrap_or_else(Vector::z);
        }
        (found, filled)
    }

    /// The points that flat triangles share whose normals are all the triangle's own; empty where there are none. Their faces are to look smooth
    /// once they bend.
    fn flat_all_round(&self, faces: &[(u32, Indices)]) -> Vec<bool> {
        let (points, normals) = (self.flat.points(), self.flat.normals.values());
        if normals.len() != points.len() {
            return Vec::new();
        }
        let lists = || {
            faces.iter().flat_map(|(_, list)| match list {
                Indices::Corners(_) => self.flat.corners().chunks_exact(3),
                Indices::List(list) => list.chunks_exact(3),
            })
        };
        let mut uses = vec![0_u8; points.len()];
        lists().flatten().for_each(|&p| uses[p as usize] = uses[p as usize].saturating_add(1));
        let mut short = Vec::new();
        for triangle in lists() {
            let [a, b, c] = [0, 1, 2].map(|k| triangle[k] as usize);
            let across = (points[b] - points[a]).cross(&(points[c] - points[a]));
            let along = |p: usize| normals[p].dot(&across) >= FLAT * normals[p].norm() * across.norm();
            if let Some(shared) = [a, b, c].into_iter().find(|&p| uses[p] > 1)
                && [a, b, c].into_iter().all(along)
            {
                short.resize(points.len(), false);
                short[shared] = true;
            }
        }
        short
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
            remarks.push(counted(
                flat,
                "[triangle that uses|triangles that use] a point twice [was|were] left out",
            ));
        }
        if large {
            remarks.push("very large faces were cut as fans".to_owned());
        }
        by_slot.into_iter().map(|(slot, list)| (slot, Indices::List(list))).collect()
    }

    fn attributes(
        &self,
        frame: Frame,
        short: &[bool],
        bin: &mut Bin<'a>,
        remarks: &mut Vec<String>,
    ) -> Result<Attributes, FormatError> {
        let (flat, original) = (self.flat, self.original);
        let mut found = Attributes::default();
        if !flat.normals.is_empty() {
            // Points without faces may lack one.
            let of_corners = || flat.corners().iter().filter_map(|&p| flat.normals.values().get(p as usize));
            let is_whole = flat.normals.values().iter().all(is_direction) || of_corners().all(is_direction);
            if is_whole || of_corners().any(is_direction) {
                let accessor = if !is_whole {
                    let (normals, filled) = self.filled_normals();
                    remarks.push(counted(
                        filled,
                        "point[|s] without a normal of any length [has|have] that of [its|their] faces",
                    ));
                    let one = move |n: &Vector, out: &mut Out<'_>| put(frame.normal(n), out);
                    values(bin, Cow::Owned(normals), Kind::floats(3), Use::Vertices, None, one)?
                } else if short.is_empty() {
                    let list = self.lend(|m: &Mesh| m.normals.values());
                    let one = move |n: &Vector, out: &mut Out<'_>| put(frame.normal(n), out);
                    values(bin, list, Kind::floats(3), Use::Vertices, None, one)?
                } else {
                    let written = |(n, short): (&Vector, &bool)| {
                        if *short { frame.short_normal(n) } else { frame.normal(n) }
                    };
                    let list: Vec<[f32; 3]> = flat.normals.values().iter().zip(short).map(written).collect();
                    let one = |n: &[f32; 3], out: &mut Out<'_>| put(*n, out);
                    values(bin, Cow::Owned(list), Kind::floats(3), Use::Vertices, None, one)?
                };
                found.normals = Some((accessor, self.slots(&original.normals, "normals", remarks)));
            } else {
                remarks.push("its normals, none of which has any length, were left out".to_owned());
            }
        }
        if !flat.tangents.is_empty() {
            let good = |t: &[f64; 4]| {
                t.iter().all(|x| x.is_finite()) && t[..3].iter().any(|x| *x != 0.0) && t[3] != 0.0
            };
            if flat.tangents.values().iter().all(good) {
                let list = self.lend(|m: &Mesh| m.tangents.values());
                let one = move |t: &[f64; 4], out: &mut Out<'_>| put(frame.tangent(t), out);
                let accessor = values(bin, list, Kind::floats(4), Use::Vertices, None, one)?;
                found.tangents = Some((accessor, self.slots(&original.tangents, "tangents", remarks)));
            } else {
                remarks.push(
                    "tangents without length or sign were left out, and all others with them".to_owned(),
                );
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
    tangents: Option<Attribute>,
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
            map.insert(NORMAL.to_owned(), accessor);
            // Only faces have tangents, and only beside normals.
            if let Some(accessor) = has(&self.tangents).filter(|_| slot.is_some()) {
                map.insert("TANGENT".to_owned(), accessor);
            }
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
