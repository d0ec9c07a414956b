//! The mesh of a face, and of all of them.

use std::collections::BTreeMap;

use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::{Error, Point, Result, Vector};

use super::fill::Filled;
use super::plane::Plane;
use crate::fineness::Frame;

/// Normals of a point that are this near are one.
const SAME: f64 = 1e-9;
/// A triangle with less area than this part of the square of its longest edge is a line.
const LINE: f64 = 1e-12;

/// The triangles of a face.
#[derive(Debug, Default)]
pub(crate) struct Piece {
    /// Numbers of points: those of the whole, then the face's own.
    pub(crate) corners: Vec<[u32; 3]>,
    /// The face's own points, in the frame.
    pub(crate) own: Vec<Vector>,
    normals: Vec<Vector>,
    uvs: Vec<[f64; 2]>,
    /// Which of them each corner has.
    values: Vec<[u32; 3]>,
    /// Where each corner is, in the frame.
    places: Vec<[Vector; 3]>,
    /// The largest distance of a triangle from the surface, in the frame.
    pub(crate) error: f64,
}

impl Piece {
    /// A face that has been filled.
    ///
    /// # Errors
    /// When it has no area.
    pub(crate) fn new(plane: &Plane<'_>, filled: Filled, reversed: bool, first_own: u32) -> Result<Self> {
        let mut piece = Self { error: filled.error, ..Self::default() };
        let mut numbers: Vec<u32> = Vec::with_capacity(plane.vertices.len());
        let mut next = first_own;
        for vertex in &plane.vertices {
            next = next.max(vertex.point.map_or(0, |point| point + 1));
        }
        let own = (next - first_own) as usize;
        piece.own = vec![Vector::zeros(); own];
        for vertex in &plane.vertices {
            let number = vertex.point.unwrap_or_else(|| {
                piece.own.push(Vector::zeros());
                first_own + piece.own.len() as u32 - 1
            });
            if number >= first_own {
                piece.own[(number - first_own) as usize] = vertex.place;
            }
            numbers.push(number);
        }
        let mut plain: Vec<Option<u32>> = vec![None; plane.vertices.len()];
        let mut sided: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for triangle in filled.triangles {
            let points = triangle.map(|k| numbers[k as usize]);
            let [a, b, c] = points;
            if a == b || b == c || c == a {
                continue;
            }
            let vertices = triangle.map(|k| &plane.vertices[k as usize]);
            let flat = {
                let [a, b, c] = vertices.map(|v| v.place);
                let (s, t) = (b - a, c - a);
                s.cross(&t).try_normalize(0.0)
            };
            let centre = [0, 1].map(|d: usize| vertices.iter().map(|v| v.at[d]).sum::<f64>() / 3.0);
            let mut values = [0; 3];
            for k in 0..3 {
                let vertex = triangle[k];
                if let Some(known) = plain[vertex as usize] {
                    values[k] = known;
                    continue;
                }
                let mut at = vertices[k].at;
                if let Some((d, _)) = plane.carrier.pole_at(at) {
                    // A fan: every triangle takes what lies between its two other corners.
                    at[1 - d] = 0.5 * (vertices[(k + 1) % 3].at[1 - d] + vertices[(k + 2) % 3].at[1 - d]);
                }
                let mut normal = plane.normal(vertex, if at == vertices[k].at { centre } else { at });
                if normal == Vector::zeros() {
                    normal = flat.unwrap_or_else(Vector::z);
                }
                if reversed {
                    normal = -normal;
                }
                let uv = plane.carrier.uv(at);
                if vertices[k].normal.is_some() {
                    values[k] = piece.add(normal, uv);
                    plain[vertex as usize] = Some(values[k]);
                    continue;
                }
                let known = sided.entry(vertex).or_default();
                let same = known.iter().copied().find(|&value| {
                    piece.uvs[value as usize] == uv && (piece.normals[value as usize] - normal).norm() <= SAME
                });
                values[k] = match same {
                    Some(value) => value,
                    None => {
                        let value = piece.normals.len() as u32;
                        known.push(value);
                        piece.normals.push(normal);
                        piece.uvs.push(uv);
                        value
                    }
                };
            }
            let turn = |[a, b, c]: [u32; 3]| if reversed { [a, c, b] } else { [a, b, c] };
            let turned = |[a, b, c]: [Vector; 3]| if reversed { [a, c, b] } else { [a, b, c] };
            piece.corners.push(turn(points));
            piece.values.push(turn(values));
            piece.places.push(turned(vertices.map(|v| v.place)));
        }
        piece.straighten();
        if piece.corners.is_empty() {
            return Err(Error::NoExtent("it has no area".into()));
        }
        Ok(piece)
    }

    /// Turns edges so that no triangle has all corners on a line, as where straight lines of the surface run into a pole: the corner
    /// between the two others lies on the next triangle's edge, which it divides.
    fn straighten(&mut self) {
        let is_line = |[a, b, c]: &[Vector; 3]| {
            let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            (b - a).cross(&(c - a)).norm() <= LINE * longest
        };
        let lines: Vec<usize> = (0..self.corners.len()).filter(|&t| is_line(&self.places[t])).collect();
        if lines.is_empty() {
            return;
        }
        let mut of: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for (t, corners) in self.corners.iter().enumerate() {
            (0..3).for_each(|k| _ = of.insert([corners[k], corners[(k + 1) % 3]], t));
        }
        for t in lines {
            let (corners, values, ends) = (self.corners[t], self.values[t], self.places[t]);
            if !is_line(&ends) {
                continue;
            }
            let length = |k: usize| (ends[(k + 1) % 3] - ends[k]).norm_squared();
            let Some(k) = (0..3).max_by(|&k, &l| length(k).total_cmp(&length(l))) else { continue };
            let [from, to, middle] = [k, (k + 1) % 3, (k + 2) % 3];
            let Some(&n) = of.get(&[corners[to], corners[from]]) else { continue };
            let Some(l) = (0..3).find(|&l| self.corners[n][l] == corners[to]) else { continue };
            let (other, other_values, other_ends) = (self.corners[n], self.values[n], self.places[n]);
            let far = (l + 2) % 3;
            if n == t || other[far] == corners[middle] || of.contains_key(&[corners[middle], other[far]]) {
                continue;
            }
            // The two that are left: from the middle to both halves of the edge.
            self.corners[t] = [corners[middle], other[(l + 1) % 3], other[far]];
            self.values[t] = [values[middle], other_values[(l + 1) % 3], other_values[far]];
            self.places[t] = [ends[middle], other_ends[(l + 1) % 3], other_ends[far]];
            self.corners[n] = [corners[middle], other[far], other[l]];
            self.values[n] = [values[middle], other_values[far], other_values[l]];
            self.places[n] = [ends[middle], other_ends[far], other_ends[l]];
            of.remove(&[corners[from], corners[to]]);
            of.remove(&[corners[to], corners[from]]);
            for t in [t, n] {
                let corners = self.corners[t];
                (0..3).for_each(|k| _ = of.insert([corners[k], corners[(k + 1) % 3]], t));
            }
        }
    }

    /// A face that is a whole surface, which shares nothing.
    pub(crate) fn whole(mesh: &Mesh, frame: &Frame, reversed: bool, first_own: u32, error: f64) -> Self {
        let mut piece = Self { error, ..Self::default() };
        piece.own = mesh.points().iter().map(|p| (p - frame.centre) / frame.size).collect();
        for (face, corners) in mesh.faces().enumerate() {
            let mut values = [0; 3];
            for k in 0..3 {
                let normal = mesh.normals.at(3 * face + k, corners[k]).copied().unwrap_or_else(Vector::z);
                let uv = mesh.uvs.at(3 * face + k, corners[k]).copied().unwrap_or_default();
                values[k] = piece.add(if reversed { -normal } else { normal }, uv);
            }
            let turn = |[a, b, c]: [u32; 3]| if reversed { [a, c, b] } else { [a, b, c] };
            piece.corners.push(turn([0, 1, 2].map(|k: usize| first_own + corners[k])));
            piece.values.push(turn(values));
        }
        piece
    }

    fn add(&mut self, normal: Vector, uv: [f64; 2]) -> u32 {
        self.normals.push(normal);
        self.uvs.push(uv);
        self.normals.len() as u32 - 1
    }
}

/// One mesh of all faces; `shared` are the points of the whole.
pub(crate) struct Whole {
    pub(crate) mesh: Mesh,
    /// The face of each triangle.
    pub(crate) faces: Vec<usize>,
    /// The new number of each point of the whole; none where no triangle has it.
    pub(crate) numbers: Vec<Option<u32>>,
}

/// Puts the meshes of faces together.
///
/// # Errors
/// When there are more points than numbers for them.
pub(crate) fn assemble(pieces: &[(usize, Piece)], shared: &[Point], frame: &Frame) -> Result<Whole> {
    let first_own = shared.len() as u32;
    let mut numbers: Vec<Option<u32>> = vec![None; shared.len()];
    let mut points: Vec<Point> = Vec::new();
    for corner in pieces.iter().flat_map(|(_, piece)| piece.corners.iter().flatten()) {
        if let Some(number) = numbers.get_mut(*corner as usize) {
            *number = Some(0);
        }
    }
    for (number, point) in numbers.iter_mut().zip(shared) {
        if number.is_some() {
            *number = Some(points.len() as u32);
            points.push(*point);
        }
    }
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    let (mut normals, mut uvs, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (face, piece) in pieces {
        let mut own: Vec<Option<u32>> = vec![None; piece.own.len()];
        let base = normals.len() as u32;
        for (triangle, of) in piece.corners.iter().zip(&piece.values) {
            for (&corner, value) in triangle.iter().zip(of) {
                let number = match numbers.get(corner as usize) {
                    Some(number) => number.unwrap_or_default(),
                    None => {
                        let local = (corner - first_own) as usize;
                        *own[local].get_or_insert_with(|| {
                            points.push(frame.centre + piece.own[local] * frame.size);
                            points.len() as u32 - 1
                        })
                    }
                };
                corners.push(number);
                values.push(base + value);
            }
            faces.push(*face);
        }
        normals.extend_from_slice(&piece.normals);
        uvs.extend_from_slice(&piece.uvs);
        if u32::try_from(normals.len().max(corners.len())).is_err() {
            return Err(Error::Invalid("the mesh would have more corners than can be numbered".into()));
        }
    }
    let starts = (0..=faces.len()).map(|f| 3 * f).collect();
    let mut mesh = Mesh::from_parts(points, corners, starts)?;
    mesh.normals = Layer::per_corner(normals, values.clone());
    mesh.uvs = Layer::per_corner(uvs, values);
    Ok(Whole { mesh, faces, numbers })
}
