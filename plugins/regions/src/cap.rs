//! Walls closed by caps.

use loftsman_kernel::mesh::{FaceGroup, Layer, Mesh, NONE};
use loftsman_kernel::{Point, Vector};

use crate::error::{RegionError, Result};
use crate::fill::{Refinement, fill};

/// The loops of edges that have a face on one side only, each against the direction in which its faces run it: the
/// direction in which a cap's faces must. Each starts at its smallest index; loops are in the order of these.
/// `O(edges log edges)`.
///
/// # Errors
/// When such edges branch, or an edge has more than two faces; `object` is for the message.
pub fn boundary_loops(mesh: &Mesh, object: &str) -> Result<Vec<Vec<u32>>> {
    let mut edges: Vec<(u32, u32)> = mesh
        .faces()
        .flat_map(|face| face.iter().copied().zip(face.iter().copied().cycle().skip(1)).take(face.len()))
        .collect();
    edges.sort_unstable();
    let walls = || RegionError::Walls { object: object.to_owned() };
    if edges.windows(2).any(|w| w[0] == w[1]) {
        return Err(walls());
    }
    let mut next = vec![NONE; mesh.points().len()];
    for &(a, b) in edges.iter().filter(|(a, b)| edges.binary_search(&(*b, *a)).is_err()) {
        // The cap runs from b to a.
        if next[b as usize] != NONE {
            return Err(walls());
        }
        next[b as usize] = a;
    }
    let mut loops = Vec::new();
    for start in 0..next.len() {
        let mut ring = Vec::new();
        let mut at = start;
        while next[at] != NONE {
            ring.push(at as u32);
            at = std::mem::replace(&mut next[at], NONE) as usize;
        }
        if !ring.is_empty() {
            if at != start {
                return Err(walls());
            }
            loops.push(ring);
        }
    }
    Ok(loops)
}

/// A mesh with caps.
#[derive(Debug, Clone, PartialEq)]
pub struct Capped {
    /// Walls and caps.
    pub mesh: Mesh,
    /// Whether the caps' triangles are as fine as asked for: next to long edges they cannot always be.
    pub refined: bool,
}

/// Walls and caps as one mesh: each cap fills the loops that it is given by the even-odd rule, with the walls' own
/// points. Caps get flat normals and are named groups of faces, beside `"walls"`.
///
/// # Errors
/// When the loops of a cap are not planar, bound no area, or meet one another.
pub fn cap(walls: &Mesh, caps: &[(&str, Vec<&[u32]>)], refinement: &Refinement) -> Result<Capped> {
    let mut refined = true;
    let mut points = walls.points().to_vec();
    let mut corners = walls.corners().to_vec();
    let mut starts = walls.starts().to_vec();
    let mut normals = Indexed::of(&walls.normals, walls);
    let mut uvs = Indexed::of(&walls.uvs, walls);
    let walls_faces = walls.face_count() as u32;
    let mut groups = vec![FaceGroup { name: "walls".into(), faces: (0..walls_faces).collect() }];
    for (name, loops) in caps {
        let rings: Vec<(&str, &[u32])> = loops.iter().map(|ring| (*name, *ring)).collect();
        let filled = fill(&points, &rings, refinement)?;
        refined &= filled.refined;
        // Counted in the plane's normal, the outer loop runs as its cap must; so do all triangles.
        let first = (starts.len() - 1) as u32;
        points.extend(filled.added);
        let place = uvs.values.len() as u32;
        let mut seen = vec![NONE; points.len()];
        for triangle in &filled.triangles {
            for &k in triangle {
                corners.push(k);
                if seen[k as usize] == NONE {
                    seen[k as usize] = uvs.values.len() as u32 - place;
                    let [x, y] = filled.plane.flatten(&points[k as usize]);
                    uvs.values.push([x + 0.5, y + 0.5]);
                }
                uvs.corners.push(place + seen[k as usize]);
                normals.corners.push(normals.values.len() as u32);
            }
            starts.push(corners.len());
        }
        normals.values.push(filled.plane.normal());
        let last = (starts.len() - 1) as u32;
        groups.push(FaceGroup { name: (*name).to_owned(), faces: (first..last).collect() });
    }
    let mut mesh = Mesh::from_parts(points, corners, starts)?;
    mesh.normals = Layer::per_corner(normals.values, normals.corners);
    mesh.uvs = Layer::per_corner(uvs.values, uvs.corners);
    mesh.groups = groups;
    Ok(Capped { mesh, refined })
}

/// A layer with an index for every corner.
struct Indexed<T> {
    values: Vec<T>,
    corners: Vec<u32>,
}

impl<T: Clone> Indexed<T> {
    fn of(layer: &Layer<T>, mesh: &Mesh) -> Self {
        let corners = mesh.corners().iter().enumerate().map(|(c, &p)| layer.index(c, p)).collect();
        Self { values: layer.values().to_vec(), corners }
    }
}

/// Several meshes as one, each with its own points.
pub(crate) fn together(meshes: &[Mesh]) -> Result<Mesh> {
    let mut points: Vec<Point> = Vec::new();
    let mut corners = Vec::new();
    let mut starts = vec![0];
    let mut normals = Indexed::<Vector> { values: Vec::new(), corners: Vec::new() };
    let mut uvs = Indexed::<[f64; 2]> { values: Vec::new(), corners: Vec::new() };
    for mesh in meshes {
        let (base, first) = (points.len() as u32, corners.len());
        points.extend(mesh.points());
        corners.extend(mesh.corners().iter().map(|&p| p + base));
        starts.extend(mesh.starts().iter().skip(1).map(|&s| s + first));
        let shift = |index: u32, by: usize| if index == NONE { NONE } else { index + by as u32 };
        let own = Indexed::of(&mesh.normals, mesh);
        normals.corners.extend(own.corners.iter().map(|&i| shift(i, normals.values.len())));
        normals.values.extend(own.values);
        let own = Indexed::of(&mesh.uvs, mesh);
        uvs.corners.extend(own.corners.iter().map(|&i| shift(i, uvs.values.len())));
        uvs.values.extend(own.values);
    }
    let mut mesh = Mesh::from_parts(points, corners, starts)?;
    mesh.normals = Layer::per_corner(normals.values, normals.corners);
    mesh.uvs = Layer::per_corner(uvs.values, uvs.corners);
    Ok(mesh)
}
