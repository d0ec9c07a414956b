//! Vertices of a mesh in one place made one, as far as they can be.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::text::{counted, figure};

use crate::cage::Cage;
use crate::weld::root;

/// A mesh whose vertices in one place are one.
#[derive(Debug, Clone)]
pub(crate) struct Together {
    pub(crate) mesh: Mesh,
    /// How many vertices are one with another.
    pub(crate) merged: usize,
    /// The vertices of each place that has several, and where that is.
    pub(crate) apart: Vec<(Vec<usize>, Point)>,
}

/// The mesh with one vertex at each place, numbered in the order in which places come first, without its loose lines; files that keep normals and
/// texture coordinates by vertex have several where these differ. Such values are those of the corners of faces then; normals, which are those of what
/// was split, are left out.
///
/// A place has as many vertices as fans of faces end there: faces that hang together round it, across edges of two faces. Of an edge that has more
/// those are two that run it in opposite directions between the same vertices of the mesh, and two that are left over. The first fan's vertex has the number of
/// the place, those of others come after all places. Cost: `O(n log n)`.
pub(crate) fn together(mesh: &Mesh) -> Result<Together> {
    let first = mesh.welded();
    let mut place = vec![0_u32; first.len()];
    let mut points = Vec::new();
    for (k, &own) in first.iter().enumerate() {
        if own as usize == k {
            place[k] = points.len() as u32;
            points.push(mesh.points()[k]);
        }
    }
    let places: Vec<u32> = mesh.corners().iter().map(|&v| place[first[v as usize] as usize]).collect();
    let mut fan = fans(mesh, &places);
    // The number of each fan's vertex, at the first of its corners.
    let (mut number, mut taken) = (vec![None; places.len()], vec![false; points.len()]);
    let mut own: Vec<(u32, u32)> = Vec::new();
    let mut corners = Vec::with_capacity(places.len());
    for (corner, &place) in places.iter().enumerate() {
        let fan = root(&mut fan, corner);
        let number = *number[fan].get_or_insert_with(|| {
            if std::mem::replace(&mut taken[place as usize], true) {
                own.push((place, points.len() as u32));
                points.push(points[place as usize]);
                points.len() as u32 - 1
            } else {
                place
            }
        });
        corners.push(number);
    }
    let merged = merged(mesh, &first, &corners);
    own.sort_unstable();
    let apart = own.chunk_by(|a, b| a.0 == b.0).map(|run| {
        let all = std::iter::once(run[0].0).chain(run.iter().map(|pair| pair.1));
        (all.map(|v| v as usize).collect(), points[run[0].0 as usize])
    });
    let apart = apart.collect();
    let mut one = Mesh::from_parts(points, corners, mesh.starts().to_vec())?;
    one.uvs = of_corners(&mesh.uvs, mesh);
    one.more_uvs = mesh.more_uvs.iter().map(|layer| of_corners(layer, mesh)).collect();
    one.colors = of_corners(&mesh.colors, mesh);
    (one.materials, one.smoothing) = (mesh.materials.clone(), mesh.smoothing.clone());
    one.groups.clone_from(&mesh.groups);
    Ok(Together { mesh: one, merged, apart })
}

impl Together {
    /// What was done, in words, to go on with.
    pub(crate) fn told(&self) -> String {
        let merged = match self.merged {
            0 => "; no vertex is made one with another".to_owned(),
            merged => format!(
                "; {} made one with another in the same place",
                counted(merged, "vert[ex is|ices are]")
            ),
        };
        let Some((vertices, at)) = self.apart.first() else { return merged };
        let last = vertices.len() - 1;
        let numbers: Vec<String> = vertices.iter().map(usize::to_string).collect();
        let [x, y, z] = [at.x, at.y, at.z].map(figure);
        let others = if self.apart.len() > 1 { ", the first of them," } else { "" };
        format!(
            "{merged}; at {} vertices stay apart, for one would join several fans of faces there: {} and {}{others} at [{x}, {y}, {z}]",
            counted(self.apart.len(), "place[|s]"),
            numbers[..last].join(", "),
            numbers[last]
        )
    }
}

/// What is to be said of vertices in one place that are not made one.
pub(crate) fn coincident(cage: &Cage, mesh: &Mesh) -> Result<String> {
    let pairs = cage.coincident();
    let Some([first, second]) = pairs.first() else { return Ok(String::new()) };
    let more = match pairs.len() {
        1 => String::new(),
        2 => ", and so is 1 other".to_owned(),
        count => format!(", and so are {} others", count - 1),
    };
    let Together { merged, apart, .. } = together(mesh)?;
    let what = match (merged, apart.is_empty()) {
        (0, _) => "they stay apart, for one vertex would join several fans of faces there",
        (_, true) => {
            "they stay apart, and a seam between them is a boundary; weld = true makes them one, so that the surface goes on"
        }
        (_, false) => {
            "they stay apart, and a seam between them is a boundary; weld = true makes those one that join no several fans of faces, so that \
             the surface goes on"
        }
    };
    Ok(format!("; vertices {first} and {second} are in one place{more}: {what}"))
}

/// An error of a cage with the advice to weld it, where that mends what is wrong with its faces.
pub(crate) fn advised(error: OperationError, may_be_welded: bool, mesh: &Mesh) -> OperationError {
    let is_sound = |mesh: &Mesh| Cage::from_mesh(mesh).is_ok_and(|cage| cage.check_shape().is_ok());
    if may_be_welded && !is_sound(mesh) && together(mesh).is_ok_and(|one| is_sound(&one.mesh)) {
        let advice = "weld = true does: it makes vertices in one place one, and gives each fan of faces one of its own";
        return Error::Invalid(format!("{error}; {advice}")).into();
    }
    error
}

/// For each corner of a face another one of the same fan, as a forest ([`root`]); corners are at `places`.
fn fans(mesh: &Mesh, places: &[u32]) -> Vec<usize> {
    let mut next: Vec<usize> = (1..=places.len()).collect();
    for pair in mesh.starts().windows(2).filter(|pair| pair[0] < pair[1]) {
        next[pair[1] - 1] = pair[0];
    }
    let ends = |at: &[u32], half: usize| {
        let (a, b) = (at[half], at[next[half]]);
        (a.min(b), a.max(b))
    };
    let runs_up = |half: usize| places[half] < places[next[half]];
    let mut halves: Vec<usize> = (0..places.len()).collect();
    halves.sort_unstable_by_key(|&half| (ends(places, half), ends(mesh.corners(), half), half));
    let mut fan: Vec<usize> = (0..places.len()).collect();
    let mut join = |one: usize, other: usize| {
        let [a, b] =
            [one, other].map(|half| if runs_up(half) { [half, next[half]] } else { [next[half], half] });
        for (a, b) in a.into_iter().zip(b) {
            let (a, b) = (root(&mut fan, a), root(&mut fan, b));
            fan[a.max(b)] = a.min(b);
        }
    };
    for run in halves.chunk_by(|&a, &b| ends(places, a) == ends(places, b)) {
        // Two that run an edge the same way are one edge, too: a cage says what is wrong with it.
        if let [one, other] = *run {
            join(one, other);
            continue;
        }
        let mut left = Vec::new();
        for same in run.chunk_by(|&a, &b| ends(mesh.corners(), a) == ends(mesh.corners(), b)) {
            match *same {
                [one, other] if runs_up(one) != runs_up(other) => join(one, other),
                _ => left.extend_from_slice(same),
            }
        }
        if let [one, other] = left[..]
            && runs_up(one) != runs_up(other)
        {
            join(one, other);
        }
    }
    fan
}

/// How many vertices of a mesh are one with another that has the number of a corner of theirs, and of those without faces how many lie where another does.
fn merged(mesh: &Mesh, first: &[u32], corners: &[u32]) -> usize {
    let mut pairs: Vec<(u32, u32)> = corners.iter().copied().zip(mesh.corners().iter().copied()).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let ones = pairs.chunk_by(|a, b| a.0 == b.0).count();
    let mut is_used = vec![false; first.len()];
    mesh.corners().iter().for_each(|&v| is_used[v as usize] = true);
    let loose = (0..first.len()).filter(|&k| !is_used[k] && first[k] as usize != k).count();
    pairs.len() - ones + loose
}

/// What belongs to points, for the corners at them.
fn of_corners<T: Copy>(layer: &Layer<T>, mesh: &Mesh) -> Layer<T> {
    if layer.corners().is_some() || layer.is_empty() {
        return layer.clone();
    }
    Layer::per_corner(layer.values().to_vec(), mesh.corners().to_vec())
}
