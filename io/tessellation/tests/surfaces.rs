//! Meshes against their surfaces: deviation, topology, normals, seams and poles.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::collections::HashMap;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use proptest::prelude::*;

const FULL: [(f64, f64, f64); 9] = {
    const H: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [
        (1.0, 0.0, 1.0),
        (1.0, 1.0, H),
        (0.0, 1.0, 1.0),
        (-1.0, 1.0, H),
        (-1.0, 0.0, 1.0),
        (-1.0, -1.0, H),
        (0.0, -1.0, 1.0),
        (1.0, -1.0, H),
        (1.0, 0.0, 1.0),
    ]
};

fn arcs(quarters: usize) -> Space {
    let mut knots = vec![0.0; 3];
    (1..quarters).for_each(|k| knots.extend([k as f64; 2]));
    knots.extend([quarters as f64; 3]);
    Space::open(2, knots).unwrap()
}

/// A circle of radius `small` about `(large, 0, 0)` in the xz plane, `part` of it, revolved about z.
fn revolved(large: f64, small: f64, profile: &[(f64, f64, f64)]) -> Surface {
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (cx, cy, w) in FULL {
        for &(px, pz, pw) in profile {
            let r = large + small * px;
            points.push(Point::new(r * cx, r * cy, small * pz));
            weights.push(w * pw);
        }
    }
    Surface::rational(arcs(4), arcs((profile.len() - 1) / 2), points, weights).unwrap()
}

fn sphere(radius: f64) -> Surface {
    // The right half of the circle, from the south pole to the north pole.
    let half: Vec<_> = FULL[2..7].iter().map(|&(x, y, w)| (x.abs(), -y, w)).collect();
    revolved(0.0, radius, &half)
}

fn periodic_torus() -> Surface {
    let n = 12;
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (i as f64 * std::f64::consts::TAU / 12.0, j as f64 * std::f64::consts::TAU / 12.0);
            let r = 3.0 + b.cos();
            points.push(Point::new(r * a.cos(), r * a.sin(), b.sin()));
        }
    }
    let space = Space::periodic_uniform(3, n).unwrap();
    Surface::new(space.clone(), space, points).unwrap()
}

/// Every directed edge once, its reverse once: closed and oriented. Returns V - E + F.
fn euler(mesh: &Mesh) -> i64 {
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

fn area(mesh: &Mesh) -> f64 {
    let p = |k: u32| mesh.points()[k as usize];
    mesh.faces().map(|f| 0.5 * (p(f[1]) - p(f[0])).cross(&(p(f[2]) - p(f[0]))).norm()).sum()
}

fn no_sliver_of_nothing(mesh: &Mesh) {
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

#[test]
fn a_sphere_is_closed_has_fans_at_its_poles_and_exact_normals() {
    for radius in [1e-9, 1.0, 1e9] {
        let mesh = Adaptive::default().surface(&sphere(radius), &Fineness::default()).unwrap();
        assert_eq!(euler(&mesh), 2);
        no_sliver_of_nothing(&mesh);
        assert!(mesh.normals.corners().is_none(), "one normal a point, at the poles and the seam too");
        for (p, n) in mesh.points().iter().zip(mesh.normals.values()) {
            assert!((p.coords / radius - n).norm() < 1e-7, "{p} {n}");
            assert!((p.coords.norm() / radius - 1.0).abs() < 1e-14);
        }
        // No triangle is further from the sphere than a thousandth of the diagonal.
        let tolerance = 1e-3 * 12_f64.sqrt() * radius;
        for f in mesh.faces() {
            let [a, b, c] = [f[0], f[1], f[2]].map(|k| mesh.points()[k as usize].coords);
            assert!(radius - ((a + b + c) / 3.0).norm() <= tolerance);
            assert!(radius - ((a + b) / 2.0).norm() <= tolerance);
            // Faces look where the normals look.
            assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
        }
        let exact = 4.0 * std::f64::consts::PI * radius * radius;
        assert!((area(&mesh) / exact - 1.0).abs() < 0.01);
    }
}

#[test]
fn tori_are_closed_whether_periodic_or_only_meeting() {
    for surface in [revolved(3.0, 1.0, &FULL), periodic_torus()] {
        let mesh = Adaptive::default().surface(&surface, &Fineness::default()).unwrap();
        assert_eq!(euler(&mesh), 0);
        no_sliver_of_nothing(&mesh);
    }
}

#[test]
fn a_cone_has_an_apex_and_an_open_rim() {
    let circle: Vec<_> = FULL.to_vec();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (x, y, w) in circle {
        points.extend([Point::new(0.0, 0.0, 1.0), Point::new(x, y, 0.0)]);
        weights.extend([w, w]);
    }
    let cone = Surface::rational(arcs(4), Space::clamped_uniform(1, 2).unwrap(), points, weights).unwrap();
    let mesh = Adaptive::default().surface(&cone, &Fineness::default()).unwrap();
    no_sliver_of_nothing(&mesh);
    // A fan at the apex, each face with its own normal there: across its own generator, not up.
    let apex = mesh.points().iter().position(|p| p.z > 1.0 - 1e-9).unwrap() as u32;
    let mut fan = 0;
    for (face, corners) in mesh.faces().enumerate() {
        if let Some(k) = corners.iter().position(|&c| c == apex) {
            fan += 1;
            let normal = mesh.normals.at(3 * face + k, apex).unwrap();
            let middle =
                corners.iter().filter(|c| **c != apex).map(|&c| mesh.points()[c as usize].coords.xy());
            let expected = middle.sum::<nalgebra::Vector2<f64>>().normalize().push(1.0) * 0.5_f64.sqrt();
            // The parameters run so that the inside is in front.
            assert!((normal + expected).norm() < 1e-2, "{normal} {expected}");
        }
    }
    assert!(fan >= 8);
}

#[test]
fn a_plane_is_two_triangles() {
    let points =
        [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 5.0)).to_vec();
    let line = Space::clamped_uniform(1, 2).unwrap();
    let mesh =
        Adaptive::default().surface(&Surface::new(line.clone(), line, points).unwrap(), &Fineness::default());
    let mesh = mesh.unwrap();
    assert_eq!((mesh.points().len(), mesh.face_count()), (4, 2));
    assert_eq!(mesh.normals.values(), [Vector::z(); 4]);
    for (corner, &point) in mesh.corners().iter().enumerate() {
        let (p, uv) = (mesh.points()[point as usize], mesh.uvs.at(corner, point).unwrap());
        assert_eq!([p.x, p.y], *uv);
    }
}

#[test]
fn a_tolerance_beyond_reason_is_refused_by_name() {
    for tolerance in [1e-9, 1e-12, 1e-14] {
        let fine = Fineness { chord: Chord::Absolute(tolerance), angle: 0.1 };
        let message = Adaptive::default().surface(&sphere(1.0), &fine).unwrap_err().to_string();
        assert!(message.contains(&format!("{tolerance:e}")) && message.contains("triangles"), "{message}");
    }
    let fine = Fineness { chord: Chord::Absolute(1e-3), angle: 1e-9 };
    let small = Adaptive { budget: 10_000 };
    let message = small.surface(&sphere(1.0), &fine).unwrap_err().to_string();
    assert!(message.contains("10000") && message.contains("degrees"), "{message}");
    assert!(small.surface(&sphere(1.0), &Fineness::default()).is_ok());
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
fn deviation(surface: &Surface, mesh: &Mesh) -> (f64, f64) {
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
            out = out.max(nearest(surface, uv, p));
            let on = surface.point(u0 + (u1 - u0) * uv[0], v0 + (v1 - v0) * uv[1]).unwrap().coords;
            let mut near = to_triangle(on, points);
            for &other in f.iter().flat_map(|c| &around[c]) {
                near = near.min(to_triangle(on, corners(faces[other])));
            }
            back = back.max(near);
        }
    }
    (out, back)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn random_open_surfaces_are_met(
        p in 1_usize..5, q in 1_usize..5, more in 0_usize..4,
        heights in prop::collection::vec(-1.0_f64..1.0, 64),
        weights in prop::collection::vec(0.2_f64..5.0, 64),
        rational in any::<bool>(),
    ) {
        let (rows, columns) = (p + 1 + more, q + 1);
        let points: Vec<Point> = (0..rows * columns)
            .map(|k| Point::new((k / columns) as f64, (k % columns) as f64, heights[k])).collect();
        let surface = Surface::build(
            Space::clamped_uniform(p, rows).unwrap(),
            Space::clamped_uniform(q, columns).unwrap(),
            points,
            rational.then(|| weights[..rows * columns].to_vec()),
        ).unwrap();
        let fineness = Fineness { chord: Chord::Absolute(0.02), angle: 0.8 };
        let (mesh, certified) = Adaptive::default().measured_surface(&surface, &fineness).unwrap();
        no_sliver_of_nothing(&mesh);
        let (out, back) = deviation(&surface, &mesh);
        prop_assert!(certified <= 0.02 && out <= certified && back <= certified, "{out} {back} {certified}");
        prop_assert_eq!(&mesh, &Adaptive::default().surface(&surface, &fineness).unwrap());
    }
}
