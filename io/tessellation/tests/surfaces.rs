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
    for n in mesh.normals.values() {
        assert!((n.norm() - 1.0).abs() < 1e-12);
    }
    assert_eq!(mesh.normals.values().len(), mesh.points().len());
    assert_eq!(mesh.uvs.values().len(), mesh.points().len());
}

#[test]
fn a_sphere_is_closed_has_fans_at_its_poles_and_exact_normals() {
    for radius in [1e-9, 1.0, 1e9] {
        let mesh = Adaptive::default().surface(&sphere(radius), &Fineness::default()).unwrap();
        assert_eq!(euler(&mesh), 2);
        no_sliver_of_nothing(&mesh);
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
    let apex = mesh.points().iter().position(|p| p.z > 1.0 - 1e-9).unwrap();
    assert!(mesh.normals.values()[apex].xy().norm() < 1e-2);
    // A fan: as many triangles meet at the apex as the rim has points.
    let fan = mesh.faces().filter(|f| f.contains(&(apex as u32))).count();
    assert_eq!(fan, mesh.points().iter().filter(|p| p.z < 1e-9).count());
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
    assert_eq!(mesh.uvs.values(), [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn a_tolerance_beyond_reason_is_refused_by_name() {
    for tolerance in [1e-9, 1e-12, 1e-14] {
        let fine = Fineness { chord: Chord::Absolute(tolerance), angle: 0.1 };
        let message = Adaptive::default().surface(&sphere(1.0), &fine).unwrap_err().to_string();
        assert!(message.contains(&format!("{tolerance:e}")) && message.contains("triangles"), "{message}");
    }
    let fine = Fineness { chord: Chord::Absolute(1e-3), angle: 1e-9 };
    assert!(Adaptive::default().surface(&sphere(1.0), &fine).is_err());
}

/// Barycentric samples of every triangle against the surface at the same parameters (open surfaces only, where
/// `uvs` do not wrap).
fn deviation(surface: &Surface, mesh: &Mesh) -> f64 {
    let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
    let mut worst = 0.0_f64;
    for f in mesh.faces() {
        for [s, t] in [[1.0, 1.0], [4.0, 1.0], [1.0, 4.0], [0.0, 1.0], [1.0, 0.0], [5.0, 0.0], [0.0, 5.0]] {
            let (a, b) = (s / 6.0, t / 6.0);
            let mix = [1.0 - a - b, a, b];
            let (mut p, mut uv) = (Vector::zeros(), [0.0, 0.0]);
            for (k, m) in f.iter().zip(mix) {
                p += mesh.points()[*k as usize].coords * m;
                let here = mesh.uvs.values()[*k as usize];
                (uv[0], uv[1]) = (uv[0] + here[0] * m, uv[1] + here[1] * m);
            }
            let exact = surface.point(u0 + (u1 - u0) * uv[0], v0 + (v1 - v0) * uv[1]).unwrap();
            worst = worst.max((exact.coords - p).norm());
        }
    }
    worst
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
        let mesh = Adaptive::default().surface(&surface, &fineness).unwrap();
        no_sliver_of_nothing(&mesh);
        let worst = deviation(&surface, &mesh);
        prop_assert!(worst <= 0.02, "{worst}");
        prop_assert_eq!(&mesh, &Adaptive::default().surface(&surface, &fineness).unwrap());
    }
}
