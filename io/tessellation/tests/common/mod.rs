//! What meshes are asked in the tests: whether they are closed, well formed, and near their surfaces.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::collections::HashMap;

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::spline::Surface;

/// Every directed edge once, its reverse once: closed and oriented. Returns V - E + F.
pub(crate) fn euler(mesh: &Mesh) -> i64 {
    let mut edges: HashMap<(u32, u32), usize> = HashMap::new();
    for face in mesh.faces() {
        for k in 0..3 {
            *edges.entry((face[k], face[(k + 1) % 3])).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert!(count == 1 && edges.get(&(b, a)) == Some(&1), "edge {a}-{b} is used {count} times");
    }
    mesh.points().len() as i64 - edges.len() as i64 / 2 + mesh.face_count() as i64
}

/// Every face has an area, every corner a unit normal and a place in the parameters.
pub(crate) fn no_sliver_of_nothing(mesh: &Mesh) {
    for f in mesh.faces() {
        let [a, b, c] = [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize]);
        assert!(a != b && b != c && c != a && (b - a).cross(&(c - a)).norm() > 0.0);
    }
    mesh.check().unwrap();
    for (corner, &point) in mesh.corners().iter().enumerate() {
        assert!((mesh.normals.at(corner, point).unwrap().norm() - 1.0).abs() < 1e-12);
        assert!(mesh.uvs.at(corner, point).is_some());
    }
}

/// The point of the surface nearest to `to`, from parameters near it: Gauss–Newton steps of which only those that
/// come nearer count.
fn nearest(surface: &Surface, uv: [f64; 2], to: Vector) -> f64 {
    let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
    let (mut u, mut v) = (u0 + (u1 - u0) * uv[0], v0 + (v1 - v0) * uv[1]);
    let away = |u: f64, v: f64| to - surface.point(u, v).unwrap().coords;
    let mut rest = away(u, v);
    for _ in 0..30 {
        let (a, b) = (surface.derivative(u, v, 1, 0).unwrap(), surface.derivative(u, v, 0, 1).unwrap());
        let (aa, ab, bb) = (a.dot(&a), a.dot(&b), b.dot(&b));
        let (e, f) = (a.dot(&rest), b.dot(&rest));
        let det = aa * bb - ab * ab;
        if det <= 1e-14 * aa * bb {
            break;
        }
        let mut step = 1.0;
        let better = loop {
            let x = (u + step * (bb * e - ab * f) / det).clamp(u0, u1);
            let y = (v + step * (aa * f - ab * e) / det).clamp(v0, v1);
            let next = away(x, y);
            if next.norm() < rest.norm() {
                (u, v, rest) = (x, y, next);
                break true;
            }
            step *= 0.5;
            if step < 1e-3 {
                break false;
            }
        };
        if !better {
            break;
        }
    }
    rest.norm()
}

/// The distance from a point to a triangle.
fn to_triangle(p: Vector, [a, b, c]: [Vector; 3]) -> f64 {
    let segment = |a: Vector, b: Vector| {
        let d = b - a;
        let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
        (p - a - d * t).norm()
    };
    let (s, t) = (b - a, c - a);
    let normal = s.cross(&t).normalize();
    let inside = |a: Vector, b: Vector| normal.dot(&(b - a).cross(&(p - a))) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        normal.dot(&(p - a)).abs()
    } else {
        segment(a, b).min(segment(b, c)).min(segment(c, a))
    }
}

/// The largest distances found: from points of the mesh to the surface, and from points of the surface to the mesh
/// (to the triangle of the same parameters and to those around it).
pub(crate) fn deviation(surface: &Surface, mesh: &Mesh, promised: f64) -> (f64, f64) {
    let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
    let corners = |f: &[u32]| [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize].coords);
    let mut around: HashMap<u32, Vec<usize>> = HashMap::new();
    let faces: Vec<&[u32]> = mesh.faces().collect();
    for (face, f) in faces.iter().enumerate() {
        f.iter().for_each(|&c| around.entry(c).or_default().push(face));
    }
    let (mut out, mut back) = (0.0_f64, 0.0_f64);
    for (face, f) in faces.iter().enumerate() {
        let points = corners(f);
        let uvs = [0, 1, 2].map(|k| *mesh.uvs.at(3 * face + k, f[k]).unwrap());
        for [s, t] in [[2.0, 2.0], [4.0, 1.0], [1.0, 4.0], [1.0, 1.0], [0.0, 3.0], [3.0, 0.0], [3.0, 3.0]] {
            let mix = [(6.0 - s - t) / 6.0, s / 6.0, t / 6.0];
            let p: Vector = points.iter().zip(mix).map(|(p, m)| p * m).sum();
            let uv =
                [0, 1].map(|d| uvs.iter().zip(mix).map(|(uv, m)| uv[d] * m).sum::<f64>().clamp(0.0, 1.0));
            let mut near = nearest(surface, uv, p);
            if near > promised {
                // Steps from nearby parameters can stick at a crease.
                near = near.min(surface.closest(p.into()).unwrap().distance);
            }
            out = out.max(near);
            let on = surface.point(u0 + (u1 - u0) * uv[0], v0 + (v1 - v0) * uv[1]).unwrap().coords;
            let mut near = to_triangle(on, points);
            for &other in f.iter().flat_map(|c| &around[c]) {
                near = near.min(to_triangle(on, corners(faces[other])));
            }
            if near > promised {
                near = faces.iter().map(|f| to_triangle(on, corners(f))).fold(near, f64::min);
            }
            back = back.max(near);
        }
    }
    (out, back)
}
