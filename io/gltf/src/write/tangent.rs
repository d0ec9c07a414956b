//! Tangents for normal maps where a mesh has none.
//!
//! As MikkTSpace has them (Mikkelsen, *Simulation of Wrinkled Surfaces Revisited*, 2008), which glTF takes as given. Each
//! triangle has a direction in which `u` grows, `∂P/∂u`. At a vertex (point, normal and texture coordinates) the triangles
//! that join along edges and show the picture the same way round share one tangent: their directions, laid into the plane
//! of the normal, weighted by the triangles' angles there. Its sign is that of `∂u/∂P × ∂v/∂P` against the triangle,
//! with `v` up: normal maps are made so.

use std::collections::{BTreeMap, HashMap};

use loftsman_kernel::mesh::triangulate;
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::{Point, Result, Vector};

/// The mesh in triangles with a tangent at each corner, right for the slots whose material has a normal map; `maps` says which
/// set of texture coordinates that uses. Normals are the faces' own where the mesh has none. `None` where nothing is
/// wanted, can be made, or has to be made because the mesh has tangents. `O(corners)`.
pub(super) fn with_tangents(mesh: &Mesh, maps: &BTreeMap<u32, u32>) -> Result<Option<Mesh>> {
    let set = |slot: u32| match maps.get(&slot)? {
        0 => Some(&mesh.uvs),
        more => mesh.more_uvs.get(*more as usize - 1),
    };
    let has = |slot: u32| set(slot).is_some_and(|uvs| !uvs.is_empty());
    let slot = |face: usize| mesh.materials.get(face).copied().unwrap_or(0);
    if !mesh.tangents.is_empty() || !(0..mesh.face_count()).any(|face| has(slot(face))) {
        return Ok(None);
    }
    let (cut, of) = triangles(mesh)?;
    let mut corners = Vec::with_capacity(of.len());
    for (c, (&old, &point)) in of.iter().zip(cut.corners()).enumerate() {
        let uvs = set(slot(face_of(mesh, old))).filter(|uvs| !uvs.is_empty());
        let uv = uvs.and_then(|uvs| uvs.at(old, point));
        let normal = cut.normals.at(c, point).copied().or_else(|| cut.face_normal(c / 3));
        corners.push(Corner {
            point: cut.points()[point as usize],
            normal: normal.and_then(|n| n.try_normalize(0.0)).unwrap_or_else(Vector::z),
            uv: uv.copied(),
        });
    }
    // Corners of other materials take what their point has, so that no point is doubled for them.
    let made = tangents(&corners);
    let mut at_point = vec![None; cut.points().len()];
    for (tangent, &point) in made.iter().zip(cut.corners()) {
        at_point[point as usize] = at_point[point as usize].or(*tangent);
    }
    let each = made.iter().zip(&corners).zip(cut.corners()).map(|((tangent, corner), &point)| {
        tangent.or(at_point[point as usize]).unwrap_or_else(|| any(&corner.normal))
    });
    let values: Vec<[f64; 4]> = each.collect();
    let places = (0..values.len() as u32).collect();
    let mut cut = cut;
    cut.tangents = Layer::per_corner(values, places);
    Ok(Some(cut))
}

fn face_of(mesh: &Mesh, corner: usize) -> usize {
    mesh.starts().partition_point(|&start| start <= corner) - 1
}

/// The mesh cut into triangles, and which corner each corner was. Every corner has a normal or its face has none.
fn triangles(mesh: &Mesh) -> Result<(Mesh, Vec<usize>)> {
    let (mut of, mut faces, mut local) = (Vec::new(), Vec::new(), Vec::new());
    let mut around: Vec<Point> = Vec::new();
    for (face, pair) in mesh.starts().windows(2).enumerate() {
        let corners = &mesh.corners()[pair[0]..pair[1]];
        around.clear();
        around.extend(corners.iter().map(|&p| mesh.points()[p as usize]));
        local.clear();
        let numbers: Vec<u32> = (0..corners.len() as u32).collect();
        triangulate::face(&around, &numbers, &mut local);
        for t in local.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|k| corners[k as usize]);
            if a != b && b != c && c != a {
                of.extend(t.iter().map(|&k| pair[0] + k as usize));
                faces.push(face);
            }
        }
    }
    fn spread<T: Clone>(layer: &Layer<T>, of: &[usize]) -> Layer<T> {
        match layer.corners() {
            None => layer.clone(),
            Some(corners) => {
                Layer::per_corner(layer.values().to_vec(), of.iter().map(|&c| corners[c]).collect())
            }
        }
    }
    let corners = of.iter().map(|&c| mesh.corners()[c]).collect();
    let starts = (0..=faces.len()).map(|f| 3 * f).collect();
    let mut cut = Mesh::from_parts(mesh.points().to_vec(), corners, starts)?;
    cut.normals = spread(&mesh.normals, &of);
    if mesh.normals.is_empty() {
        // Without normals glTF's faces are flat; with tangents it must be said.
        let values = (0..mesh.face_count()).map(|f| mesh.face_normal(f).unwrap_or_else(Vector::z)).collect();
        cut.normals = Layer::per_corner(values, faces.iter().flat_map(|&f| [f as u32; 3]).collect());
    }
    cut.uvs = spread(&mesh.uvs, &of);
    cut.more_uvs = mesh.more_uvs.iter().map(|layer| spread(layer, &of)).collect();
    cut.colors = spread(&mesh.colors, &of);
    for (list, old) in [(&mut cut.materials, &mesh.materials), (&mut cut.smoothing, &mesh.smoothing)] {
        if !old.is_empty() {
            *list = faces.iter().map(|&f| old[f]).collect();
        }
    }
    let chains: Vec<&[u32]> = mesh.lines().collect();
    let mut ends = vec![0];
    ends.extend(chains.iter().scan(0, |at, chain| {
        *at += chain.len();
        Some(*at)
    }));
    if !chains.is_empty() {
        cut.set_lines(chains.concat(), ends)?;
    }
    Ok((cut, of))
}

/// What a corner of a triangle has; without texture coordinates it gets no tangent.
struct Corner {
    point: Point,
    normal: Vector,
    uv: Option<[f64; 2]>,
}

/// A triangle's direction of growing `u`, and whether `u, v` run round it as its corners do.
fn direction(corners: &[Corner], uv: [[f64; 2]; 3]) -> Option<(Vector, bool)> {
    let (d1, d2) = (corners[1].point - corners[0].point, corners[2].point - corners[0].point);
    let to = |k: usize| [uv[k][0] - uv[0][0], uv[k][1] - uv[0][1]];
    let ([u1, v1], [u2, v2]) = (to(1), to(2));
    let area = u1 * v2 - v1 * u2;
    let along = (d1 * v2 - d2 * v1) * area.signum();
    let along = along.try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite()))?;
    (area != 0.0 && area.is_finite()).then_some((along, area > 0.0))
}

/// The tangent of each corner, three to a triangle.
fn tangents(corners: &[Corner]) -> Vec<Option<[f64; 4]>> {
    let vertices = weld(corners);
    let faces: Vec<Option<(Vector, bool)>> =
        corners.chunks_exact(3).map(|c| direction(c, [c[0].uv?, c[1].uv?, c[2].uv?])).collect();
    // Corners that share a tangent, as trees: two triangles along an edge, the same way round, share both its ends'.
    let mut above: Vec<u32> = (0..corners.len() as u32).collect();
    let mut edges: HashMap<(u32, u32, bool), (u32, u32)> = HashMap::new();
    for (f, face) in faces.iter().enumerate() {
        let Some((_, way)) = *face else { continue };
        for (a, b) in [(3 * f, 3 * f + 1), (3 * f + 1, 3 * f + 2), (3 * f + 2, 3 * f)] {
            let (a, b) = if vertices[a] <= vertices[b] { (a, b) } else { (b, a) };
            let ends = (a as u32, b as u32);
            let known = *edges.entry((vertices[a], vertices[b], way)).or_insert(ends);
            join(&mut above, known.0, ends.0);
            join(&mut above, known.1, ends.1);
        }
    }
    let mut sums = vec![Vector::zeros(); corners.len()];
    for (f, face) in faces.iter().enumerate() {
        let Some((along, _)) = face else { continue };
        for k in 0..3 {
            let corner = &corners[3 * f + k];
            let flat = |v: Vector| {
                let in_plane = v - corner.normal * corner.normal.dot(&v);
                in_plane.try_normalize(0.0).unwrap_or_else(Vector::zeros)
            };
            let arm = |j: usize| flat(corners[3 * f + (k + j) % 3].point - corner.point);
            let angle = arm(1).dot(&arm(2)).clamp(-1.0, 1.0).acos();
            let top = root(&mut above, (3 * f + k) as u32);
            sums[top as usize] += flat(*along) * angle;
        }
    }
    // What lies flat in the picture takes the tangent of a neighbour at its vertex, else any.
    let mut near: HashMap<u32, [f64; 4]> = HashMap::new();
    let mut out = vec![None; corners.len()];
    for (c, corner) in corners.iter().enumerate() {
        let Some((_, way)) = faces[c / 3] else { continue };
        let sum = sums[root(&mut above, c as u32) as usize];
        let unit = sum.try_normalize(0.0).unwrap_or_else(|| across(&corner.normal));
        let tangent = [unit.x, unit.y, unit.z, if way { 1.0 } else { -1.0 }];
        near.entry(vertices[c]).or_insert(tangent);
        out[c] = Some(tangent);
    }
    for (c, corner) in corners.iter().enumerate() {
        if out[c].is_none() && corner.uv.is_some() {
            out[c] = Some(near.get(&vertices[c]).copied().unwrap_or_else(|| any(&corner.normal)));
        }
    }
    out
}

/// Any direction across a unit vector: the axis furthest from it, laid into its plane.
fn across(normal: &Vector) -> Vector {
    let axis = normal.iamin();
    let mut unit = Vector::zeros();
    unit[axis] = 1.0;
    let flat: Vector = unit - normal * normal[axis];
    flat.try_normalize(0.0).unwrap_or(unit)
}

/// A tangent where the picture has no direction.
fn any(normal: &Vector) -> [f64; 4] {
    let unit = across(normal);
    [unit.x, unit.y, unit.z, 1.0]
}

/// The vertex of each corner: the first corner with the same point, normal and texture coordinates.
fn weld(corners: &[Corner]) -> Vec<u32> {
    let mut known = HashMap::new();
    let number = |c: usize, corner: &Corner| {
        let [u, v] = corner.uv.unwrap_or([f64::NAN; 2]);
        let (p, n) = (corner.point, corner.normal);
        // Adding 0 makes minus zero zero.
        let key = [p.x, p.y, p.z, n.x, n.y, n.z, u, v].map(|x| (x + 0.0).to_bits());
        *known.entry(key).or_insert(c as u32)
    };
    let mut number = number;
    corners.iter().enumerate().map(|(c, corner)| number(c, corner)).collect()
}

/// The top of a corner's tree; the way up is halved.
fn root(above: &mut [u32], corner: u32) -> u32 {
    let mut at = corner;
    while above[at as usize] != at {
        above[at as usize] = above[above[at as usize] as usize];
        at = above[at as usize];
    }
    at
}

/// Puts two trees together under the lower top.
fn join(above: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(above, a), root(above, b));
    above[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Reference {
        corners: Vec<Corner>,
        found: Vec<Option<[f32; 4]>>,
    }

    impl bevy_mikktspace::Geometry for Reference {
        fn num_faces(&self) -> usize {
            self.corners.len() / 3
        }
        fn num_vertices_of_face(&self, _: usize) -> usize {
            3
        }
        fn position(&self, face: usize, vert: usize) -> [f32; 3] {
            let p = self.corners[3 * face + vert].point;
            [p.x as f32, p.y as f32, p.z as f32]
        }
        fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
            let n = self.corners[3 * face + vert].normal;
            [n.x as f32, n.y as f32, n.z as f32]
        }
        fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
            self.corners[3 * face + vert].uv.unwrap().map(|x| x as f32)
        }
        fn set_tangent(&mut self, found: Option<bevy_mikktspace::TangentSpace>, face: usize, vert: usize) {
            self.found[3 * face + vert] = found.map(|t| t.tangent_encoded());
        }
    }

    /// A bumpy net of `n × n` squares with smooth normals; `mirror` turns the picture round in its right half, and
    /// `crease` gives every face its own normal.
    fn net(n: usize, mirror: bool, crease: bool) -> Vec<Corner> {
        let place = |i: usize, j: usize| {
            let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
            Point::new(x, y, 0.3 * (5.0 * x).sin() * (4.0 * y).cos())
        };
        let slope = |p: &Point| {
            let (x, y) = (p.x, p.y);
            let du = 1.5 * (5.0 * x).cos() * (4.0 * y).cos();
            let dv = -1.2 * (5.0 * x).sin() * (4.0 * y).sin();
            Vector::new(-du, -dv, 1.0).normalize()
        };
        let mut out = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let turned = mirror && 2 * i >= n;
                let square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                for t in [[0, 1, 2], [0, 2, 3]] {
                    let p = t.map(|k: usize| place(square[k].0, square[k].1));
                    let flat = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
                    for point in p {
                        let u = if turned { 1.0 - point.x } else { point.x };
                        let uv = Some([u + 0.2 * point.y, point.y - 0.1 * u * u]);
                        out.push(Corner { point, normal: if crease { flat } else { slope(&point) }, uv });
                    }
                }
            }
        }
        out
    }

    #[test]
    fn tangents_are_those_of_mikktspace() {
        for (mirror, crease) in [(false, false), (true, false), (false, true), (true, true)] {
            let corners = net(12, mirror, crease);
            let ours = tangents(&corners);
            let found = vec![None; corners.len()];
            let mut reference = Reference { corners, found };
            bevy_mikktspace::generate_tangents(&mut reference).unwrap();
            let mut compared = 0;
            for (ours, theirs) in ours.iter().zip(&reference.found) {
                let (ours, theirs) = (ours.unwrap(), theirs.unwrap());
                for k in 0..4 {
                    let off = (ours[k] - f64::from(theirs[k])).abs();
                    assert!(off < 2e-5, "{ours:?} {theirs:?} ({mirror}, {crease})");
                }
                compared += 1;
            }
            assert_eq!(compared, 6 * 12 * 12);
        }
    }

    #[test]
    fn triangles_without_a_picture_have_tangents_too() {
        let mut corners = net(2, false, false);
        for corner in &mut corners[0..3] {
            corner.uv = Some([0.5, 0.5]);
        }
        for corner in &mut corners[3..6] {
            corner.uv = None;
        }
        let found = tangents(&corners);
        let unit = |t: &[f64; 4]| (t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1.0).abs() < 1e-12;
        assert!(found[0..3].iter().all(|t| t.as_ref().is_some_and(unit)));
        assert!(found[3..6].iter().all(Option::is_none));
        assert!(found[6..].iter().all(|t| t.as_ref().is_some_and(unit)));
    }

    #[test]
    fn a_pole_of_many_triangles_costs_no_square() {
        let n = 200_000;
        let at = |k: usize| {
            let angle = k as f64 * std::f64::consts::TAU / n as f64;
            (Point::new(angle.cos(), angle.sin(), 0.0), [0.5 + angle.cos() / 2.0, 0.5 + angle.sin() / 2.0])
        };
        let corner = |(point, uv): (Point, [f64; 2])| Corner { point, normal: Vector::z(), uv: Some(uv) };
        let corners: Vec<Corner> = (0..n)
            .flat_map(|k| [(Point::origin(), [0.5, 0.5]), at(k), at((k + 1) % n)].map(corner))
            .collect();
        for tangent in tangents(&corners) {
            let [x, y, z, sign] = tangent.unwrap();
            assert!((x - 1.0).abs() < 1e-5 && y.abs() < 1e-5 && z == 0.0 && sign == 1.0, "{tangent:?}");
        }
    }
}
