//! The mesh of a section: the points that it uses in the order of the file, and layers with their own indices.

use loftsman_kernel::mesh::{Layer, Mesh, NONE};
use loftsman_kernel::{Point, Vector};

use super::raw::{Raw, Use};
use super::section::Section;

/// What has become of every entry of the lists.
pub(crate) struct Uses {
    pub(crate) points: Vec<Use>,
    pub(crate) uvs: Vec<Use>,
    pub(crate) normals: Vec<Use>,
    /// Normals that were not of unit length.
    pub(crate) rescaled: Odd,
    /// Normals of no length, which have no direction.
    pub(crate) without_direction: Odd,
    /// Colours of vertices that only some of the vertices of lines, points or free-form elements have.
    pub(crate) colors_left_out: usize,
}

/// How many entries of a list are odd, and the first of them by its number in the file.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Odd {
    pub(crate) count: usize,
    pub(crate) first: Option<u32>,
}

impl Odd {
    fn add(&mut self, number: u32) {
        self.count += 1;
        self.first = Some(self.first.map_or(number, |first| first.min(number)));
    }
}

/// Where faces and lines of a mesh refer to: entries of a list of the file, ascending; `None` for all of it.
type Origin = Option<Vec<u32>>;

/// The entries of a list of `total` that `lists` use, ascending; the lists then refer to those. [`NONE`] stays. `O(n)`,
/// or `O(n log n)` where few of a wide range are used, so that many small objects of a large file do not cost its square.
fn share(lists: &mut [&mut Vec<u32>], total: usize) -> Origin {
    let used = || NONE;
    let (mut low, mut high, mut count) = (used(), 0, 0);
    for &entry in lists.iter().flat_map(|list| list.iter()).filter(|&&e| e != NONE) {
        (low, high, count) = (low.min(entry), high.max(entry), count + 1);
    }
    if count == 0 {
        return Some(Vec::new());
    }
    let range = (high - low) as usize + 1;
    if range <= 4 * count + 64 {
        let mut place = vec![NONE; range];
        for &entry in lists.iter().flat_map(|list| list.iter()).filter(|&&e| e != NONE) {
            place[(entry - low) as usize] = 0;
        }
        if low == 0 && range == total && place.iter().all(|&p| p == 0) {
            return None;
        }
        let mut origin = Vec::new();
        for (offset, slot) in place.iter_mut().enumerate().filter(|(_, slot)| **slot == 0) {
            *slot = origin.len() as u32;
            origin.push(low + offset as u32);
        }
        for entry in lists.iter_mut().flat_map(|list| list.iter_mut()).filter(|e| **e != NONE) {
            *entry = place[(*entry - low) as usize];
        }
        return Some(origin);
    }
    let mut origin: Vec<u32> =
        lists.iter().flat_map(|list| list.iter()).copied().filter(|&e| e != NONE).collect();
    origin.sort_unstable();
    origin.dedup();
    for entry in lists.iter_mut().flat_map(|list| list.iter_mut()).filter(|e| **e != NONE) {
        *entry = origin.partition_point(|o| o < entry) as u32;
    }
    Some(origin)
}

/// The values at an origin; the list itself where it is all of it and nothing else needs it.
fn gather<T: Copy>(list: &mut Vec<T>, origin: &Origin, last: bool, uses: &mut [Use]) -> Vec<T> {
    match origin {
        None => {
            uses.fill(Use::Kept);
            if last { std::mem::take(list) } else { list.clone() }
        }
        Some(origin) => {
            origin.iter().for_each(|&entry| uses[entry as usize] = Use::Kept);
            origin.iter().map(|&entry| list[entry as usize]).collect()
        }
    }
}

/// Values by corner, and which of the list they are; by point, where every corner has the value of its point's number.
fn layer<T: Copy>(
    list: &mut Vec<T>,
    mut corners: Vec<u32>,
    mesh: &Mesh,
    last: bool,
    uses: &mut [Use],
) -> (Layer<T>, Origin) {
    if corners.iter().all(|&corner| corner == NONE) {
        return (Layer::none(), None);
    }
    let origin = share(&mut [&mut corners], list.len());
    let values = gather(list, &origin, last, uses);
    if values.len() == mesh.points().len() && corners == mesh.corners() {
        return (Layer::per_point(values), origin);
    }
    (Layer::per_corner(values, corners), origin)
}

/// How much the square of a normal's length may differ from 1: files print six digits or fewer.
const UNIT: f64 = 1e-3;

/// A direction of length 1; `None` where there is none. Squares of lengths may be beyond what numbers hold.
fn direction(normal: &Vector) -> Option<Vector> {
    (normal / normal.amax()).try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()))
}

/// Normals are directions: those of another length get length 1, those of none go.
fn directions((layer, origin): (Layer<Vector>, Origin), mesh: &Mesh, uses: &mut Uses) -> Layer<Vector> {
    let off = |n: &Vector| (n.norm_squared() - 1.0).abs() > UNIT;
    if !layer.values().iter().any(off) {
        return layer;
    }
    let (mut values, corners) = layer.into_parts();
    let mut gone = Vec::new();
    for (index, normal) in values.iter_mut().enumerate().filter(|(_, n)| off(n)) {
        let number = origin.as_ref().map_or(index as u32, |origin| origin[index]);
        match direction(normal) {
            Some(unit) => {
                *normal = unit;
                uses.rescaled.add(number);
            }
            None => {
                uses.without_direction.add(number);
                gone.push(index);
            }
        }
    }
    if gone.is_empty() {
        return match corners {
            Some(corners) => Layer::per_corner(values, corners),
            None => Layer::per_point(values),
        };
    }
    let mut place = vec![NONE; values.len()];
    let mut kept = Vec::with_capacity(values.len() - gone.len());
    let mut next_gone = gone.iter().copied().peekable();
    for (index, normal) in values.into_iter().enumerate() {
        if next_gone.next_if_eq(&index).is_none() {
            place[index] = kept.len() as u32;
            kept.push(normal);
        }
    }
    if kept.is_empty() {
        return Layer::none();
    }
    let corners = corners.unwrap_or_else(|| mesh.corners().to_vec());
    Layer::per_corner(kept, corners.iter().map(|&c| place.get(c as usize).copied().unwrap_or(NONE)).collect())
}

/// The mesh of a section's faces and lines. `last` says that nothing else needs the lists of the file.
pub(crate) fn mesh(
    raw: &mut Raw,
    section: &mut Section,
    last: bool,
    uses: &mut Uses,
) -> loftsman_kernel::Result<Mesh> {
    let (mut corners, mut chains) =
        (std::mem::take(&mut section.corners), std::mem::take(&mut section.chains));
    let origin = share(&mut [&mut corners, &mut chains], raw.points.len());
    let colors = colors(raw, &origin);
    let points: Vec<Point> = gather(&mut raw.points, &origin, last, &mut uses.points);
    let mut mesh = Mesh::from_parts(points, corners, std::mem::take(&mut section.starts))?;
    if !chains.is_empty() {
        mesh.set_lines(chains, std::mem::take(&mut section.chain_starts))?;
    }
    mesh.uvs = layer(&mut raw.uvs, std::mem::take(&mut section.textures), &mesh, last, &mut uses.uvs).0;
    let normals =
        layer(&mut raw.normals, std::mem::take(&mut section.normals), &mesh, last, &mut uses.normals);
    if !section.made_normals {
        mesh.normals = directions(normals, &mesh, uses);
    }
    mesh.colors = match colors {
        Some((values, true)) => Layer::per_point(values.into_iter().flatten().collect()),
        Some((values, false)) => {
            let mut seen = vec![false; values.len()];
            mesh.corners().iter().for_each(|&c| seen[c as usize] = true);
            uses.colors_left_out +=
                (values.iter().zip(seen)).filter(|(c, seen)| c.is_some() && !seen).count();
            by_corner(&values, mesh.corners())
        }
        None => Layer::none(),
    };
    mesh.materials = std::mem::take(&mut section.materials);
    mesh.smoothing = std::mem::take(&mut section.smoothing);
    mesh.groups = std::mem::take(&mut section.groups);
    Ok(mesh)
}

/// The colours of points, and whether all have one; nothing where none has.
fn colors(raw: &Raw, origin: &Origin) -> Option<(Vec<Option<[f64; 4]>>, bool)> {
    if !raw.colored() {
        return None;
    }
    let values: Vec<_> = match origin {
        None => (0..raw.points.len()).map(|v| raw.color(v as u32)).collect(),
        Some(origin) => origin.iter().map(|&v| raw.color(v)).collect(),
    };
    let all = values.iter().all(Option::is_some);
    values.iter().any(Option::is_some).then_some((values, all))
}

/// A chain of lines whose vertices all have colours, as a mesh of that line.
pub(crate) fn colored_chain(
    points: Vec<Point>,
    colors: Vec<[f64; 4]>,
    closed: bool,
) -> loftsman_kernel::Result<Mesh> {
    let mut chain: Vec<u32> = (0..points.len() as u32).collect();
    chain.extend(closed.then_some(0));
    let mut mesh = colored_points(points, colors)?;
    let starts = vec![0, chain.len()];
    mesh.set_lines(chain, starts)?;
    Ok(mesh)
}

/// Points that all have colours, as a mesh of nothing else.
pub(crate) fn colored_points(points: Vec<Point>, colors: Vec<[f64; 4]>) -> loftsman_kernel::Result<Mesh> {
    let mut mesh = Mesh::from_parts(points, Vec::new(), vec![0])?;
    mesh.colors = Layer::per_point(colors);
    Ok(mesh)
}

/// Colours that some points do not have.
fn by_corner(values: &[Option<[f64; 4]>], corners: &[u32]) -> Layer<[f64; 4]> {
    let mut next = 0;
    let place: Vec<u32> = values
        .iter()
        .map(|value| {
            let at = if value.is_some() { next } else { NONE };
            next += u32::from(value.is_some());
            at
        })
        .collect();
    let corners = corners.iter().map(|&c| place[c as usize]).collect();
    Layer::per_corner(values.iter().flatten().copied().collect(), corners)
}
