//! Meshes against their surfaces: deviation, topology, normals, seams and poles.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::collections::HashMap;

use crate::common::{deviation, euler, no_sliver_of_nothing};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellated, Tessellator};
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

fn area(mesh: &Mesh) -> f64 {
    let p = |k: u32| mesh.points()[k as usize];
    mesh.faces().map(|f| 0.5 * (p(f[1]) - p(f[0])).cross(&(p(f[2]) - p(f[0]))).norm()).sum()
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

fn heights(p: usize, q: usize, z: impl Fn(f64, f64) -> f64) -> Surface {
    let (n, m) = (p + 4, q + 3);
    let points = (0..n * m).map(|k| (k / m) as f64).zip((0..n * m).map(|k| (k % m) as f64));
    let points = points.map(|(x, y)| Point::new(x, y, z(x, y))).collect();
    Surface::new(Space::clamped_uniform(p, n).unwrap(), Space::clamped_uniform(q, m).unwrap(), points)
        .unwrap()
}

/// The points of a mesh on the line `x = at`, in order.
fn on_line(mesh: &Mesh, at: f64) -> Vec<Point> {
    let mut points: Vec<Point> = mesh.points().iter().copied().filter(|p| p.x == at).collect();
    points.sort_by(|a, b| a.y.total_cmp(&b.y));
    points
}

#[test]
fn surfaces_that_meet_have_the_same_points_where_they_do() {
    // The same edge (x = 0) of a flat and of a wild surface, the wild one also run through backwards.
    let edge = |y: f64| (1.3 * y).sin();
    let calm = heights(1, 3, |_, y| edge(y));
    let wild = heights(3, 3, |x, y| edge(y) + x * (2.0 * x + y).cos());
    let (u, v, points, _) = wild.clone().into_parts();
    let reversed: Vec<Point> = points.chunks(v.len()).flat_map(|row| row.iter().rev().copied()).collect();
    let reversed = Surface::new(u, v, reversed).unwrap();
    for chord in [0.3, 0.01, 1e-4] {
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: 0.5 };
        let [a, b, c] = [&calm, &wild, &reversed]
            .map(|surface| on_line(&Adaptive::default().surface(surface, &fineness).unwrap(), 0.0));
        assert!(a.len() > 2 && a == b, "{} and {} points", a.len(), b.len());
        assert_eq!(b.len(), c.len());
        assert!(
            b.iter().zip(&c).all(|(x, y)| (x - y).norm() <= 1e-14),
            "to rounding: the knots run backwards"
        );
    }
}

#[test]
fn a_twisted_patch_with_straight_edges_keeps_them_whole() {
    let points =
        [[0.0, 0.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]].map(Point::from).to_vec();
    let line = Space::clamped_uniform(1, 2).unwrap();
    let saddle = Surface::new(line.clone(), line, points).unwrap();
    let fineness = Fineness { chord: Chord::Absolute(1e-3), angle: 0.3 };
    let Tessellated { mesh, error: certified, .. } =
        Adaptive::default().measured_surface(&saddle, &fineness).unwrap();
    assert_eq!(on_line(&mesh, 0.0).len(), 2);
    no_sliver_of_nothing(&mesh);
    let (out, back) = deviation(&saddle, &mesh, certified);
    assert!(certified <= 1e-3 && out <= certified && back <= certified, "{out} {back} {certified}");
}

/// A surface of degree (2, 1) with a double knot at u = 1 whose first row after it is bent by `bend`.
fn folded(bend: f64) -> Surface {
    let u = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let rows = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.5], [3.0, 1.0 + bend], [4.0, 3.0]];
    let points = rows.iter().flat_map(|&[x, z]| [Point::new(x, 0.0, z), Point::new(x, 2.0, z)]).collect();
    Surface::new(u, Space::clamped_uniform(1, 2).unwrap(), points).unwrap()
}

#[test]
fn normals_split_at_real_creases_only() {
    let smooth = Adaptive::default().surface(&folded(0.0), &Fineness::default()).unwrap();
    assert!(
        smooth.normals.corners().is_none(),
        "a double knot across which the tangent goes on is no crease"
    );
    let sharp = Adaptive::default().surface(&folded(0.5), &Fineness::default()).unwrap();
    assert!(sharp.normals.corners().is_some());
    let mut at_fold: HashMap<u32, Vec<u32>> = HashMap::new();
    for (corner, &point) in sharp.corners().iter().enumerate() {
        at_fold.entry(point).or_default().push(sharp.normals.index(corner, point));
    }
    for (point, mut found) in at_fold {
        found.sort_unstable();
        found.dedup();
        let crease = (sharp.points()[point as usize].x - 2.0).abs() < 1e-12;
        assert_eq!(found.len(), if crease { 2 } else { 1 });
    }
    assert!(sharp.uvs.corners().is_none(), "parameters do not split there");
}

#[test]
fn seams_and_poles_have_their_own_parameters() {
    let mesh = Adaptive::default().surface(&sphere(1.0), &Fineness::default()).unwrap();
    for (face, f) in mesh.faces().enumerate() {
        let uvs = [0, 1, 2].map(|k| *mesh.uvs.at(3 * face + k, f[k]).unwrap());
        for d in 0..2 {
            let (low, high) = uvs.iter().fold((1.0_f64, 0.0_f64), |(l, h), uv| (l.min(uv[d]), h.max(uv[d])));
            assert!(high - low < 0.3, "no triangle runs back over the texture: {uvs:?}");
        }
    }
}

#[test]
fn weights_of_any_ratio_and_sizes_of_any_magnitude_are_met() {
    for ratio in [1e-6, 1.0, 1e6] {
        for size in [1e-9, 1.0, 1e9] {
            let points: Vec<Point> = (0..16)
                .map(|k| Point::new((k / 4) as f64, (k % 4) as f64, (k as f64 * 1.7).sin()) * size)
                .collect();
            let weights = (0..16).map(|k| if k % 3 == 0 { ratio } else { 1.0 }).collect();
            let bezier = Space::clamped_uniform(3, 4).unwrap();
            let surface = Surface::rational(bezier.clone(), bezier, points, weights).unwrap();
            let fineness = Fineness { chord: Chord::Relative(2e-3), angle: 2.0 };
            let Tessellated { mesh, error: certified, .. } =
                Adaptive::default().measured_surface(&surface, &fineness).unwrap();
            no_sliver_of_nothing(&mesh);
            assert!(certified <= 2e-3 * 5.5 * size);
            let (out, back) = deviation(&surface, &mesh, certified);
            assert!(out <= certified && back <= certified, "{ratio} {size}: {out} {back} {certified}");
        }
    }
}

#[test]
fn degenerate_surfaces_are_meshed_without_empty_faces_or_refused_by_name() {
    let bezier = || Space::clamped_uniform(2, 3).unwrap();
    let of = |f: &dyn Fn(f64, f64) -> [f64; 3]| {
        let points = (0..9).map(|k| Point::from(f((k / 3) as f64, (k % 3) as f64))).collect();
        Surface::new(bezier(), bezier(), points).unwrap()
    };
    let refused = |surface: &Surface| {
        Adaptive::default().surface(surface, &Fineness::default()).unwrap_err().to_string()
    };
    assert!(refused(&of(&|_, _| [1.0, 2.0, 3.0])).contains("coincide"));
    assert!(refused(&of(&|x, y| [x + y, 0.0, 0.0])).contains("no area"));
    assert!(refused(&of(&|x, _| [x, x * x, 0.0])).contains("no area"));
    // One edge, two opposite edges, two edges that meet: each one point.
    for f in [
        &|x: f64, y: f64| [x * y, y, x * y * (2.0 - x)] as [f64; 3],
        &|x: f64, y: f64| [x * y * (2.0 - y), y, 0.3 * x * y * (2.0 - y)],
        &|x: f64, y: f64| [x * y, x * y * (x + y), x * x * y],
    ] as [&dyn Fn(f64, f64) -> [f64; 3]; 3]
    {
        let surface = of(f);
        let Tessellated { mesh, error: certified, .. } =
            Adaptive::default().measured_surface(&surface, &Fineness::default()).unwrap();
        no_sliver_of_nothing(&mesh);
        let (out, back) = deviation(&surface, &mesh, certified);
        assert!(out <= certified && back <= certified, "{out} {back} {certified}");
    }
}

#[test]
fn a_wild_surface_stays_within_its_budget() {
    let wild = heights(3, 3, |x, y| 40.0 * ((12.9898 * x + 78.233 * y).sin() * 43758.547).fract());
    let mesh = Adaptive::default().surface(&wild, &Fineness::default()).unwrap();
    assert!(mesh.face_count() < 500_000, "{}", mesh.face_count());
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let surfaces = [heights(3, 2, |x, y| (x * y).sin()), sphere(2.0), periodic_torus()];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            surfaces.each_ref().map(|s| Adaptive::default().surface(s, &Fineness::default()).unwrap())
        })
    };
    assert_eq!(run(1), run(4));
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
        let Tessellated { mesh, error: certified, .. } = Adaptive::default().measured_surface(&surface, &fineness).unwrap();
        no_sliver_of_nothing(&mesh);
        let (out, back) = deviation(&surface, &mesh, certified);
        prop_assert!(certified <= 0.02 && out <= certified && back <= certified, "{out} {back} {certified}");
        prop_assert_eq!(&mesh, &Adaptive::default().surface(&surface, &fineness).unwrap());
    }
}

/// Pieces of a plane between straight edges are two triangles each, however unevenly their parameters run within it: the image of a diagonal is no straight line then.
#[test]
fn plane_pieces_between_lines_are_two_triangles() {
    let fineness = Fineness { chord: Chord::Absolute(1e-3), angle: 0.26 };
    // A frame of four mitred bars, each side a trapezoid.
    let corner = |k: usize, inset: f64, z: f64| {
        let (x, y) = [(0.0, 0.0), (20.0, 0.0), (20.0, 14.0), (0.0, 14.0)][k];
        let inward = |at: f64, far: f64| if at == 0.0 { inset } else { far - inset };
        Point::new(inward(x, 20.0), inward(y, 14.0), z)
    };
    let bar = [(0.0, -1.0), (0.0, 1.0), (2.0, 1.5), (2.5, -1.0)];
    let net = (0..4).flat_map(|k| bar.map(|(inset, z)| corner(k, inset, z))).collect();
    let ring = |n: usize| Space::periodic(1, (0..=n).map(|k| k as f64).collect()).unwrap();
    let frame = Surface::new(ring(4), ring(4), net).unwrap();
    for surface in [frame.clone(), frame.elevate(loftsman_kernel::spline::Direction::U, 2).unwrap()] {
        let Tessellated { mesh, error, .. } =
            Adaptive::default().measured_surface(&surface, &fineness).unwrap();
        assert_eq!(mesh.triangle_count(), 32);
        assert!(error < 1e-12, "{error:e}");
        let (out, back) = deviation(&surface, &mesh, 1e-9);
        assert!(out.max(back) < 1e-9, "{out:e} {back:e}");
    }
}

/// What is certified is so: of four points in a plane, in any order, whose bilinear patch may fold over, and of pieces whose edges bend within the plane.
#[test]
fn plane_pieces_are_as_near_as_told() {
    let mut random = 7_u64;
    let mut next = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / 16_777_216.0 - 0.5
    };
    let (right, up) = (Vector::new(1.0, 0.2, -0.3), Vector::new(0.1, 0.9, 0.4));
    for trial in 0..120 {
        let degree = 1 + trial % 3;
        let n = degree + 1;
        let wild = [0.1, 0.4, 1.0][trial / 3 % 3];
        let points: Vec<Point> = (0..n * n)
            .map(|k| ((k / n) as f64 / degree as f64, (k % n) as f64 / degree as f64))
            .map(|(u, v)| Point::origin() + right * (u + wild * next()) + up * (v + wild * next()))
            .collect();
        let space = Space::clamped_uniform(degree, n).unwrap();
        let weights = (0..n * n).map(|_| 1.0 + next()).collect();
        let surface = if trial % 2 == 0 {
            Surface::new(space.clone(), space, points).unwrap()
        } else {
            Surface::rational(space.clone(), space, points, weights).unwrap()
        };
        let fineness = Fineness { chord: Chord::Absolute(0.02), angle: std::f64::consts::PI };
        let Tessellated { mesh, error, .. } =
            Adaptive::default().measured_surface(&surface, &fineness).unwrap();
        let (out, back) = deviation(&surface, &mesh, error);
        assert!(error <= 0.02 && out.max(back) <= error + 1e-9, "{trial}: {out} {back} {error}");
    }
}
