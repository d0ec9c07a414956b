//! Limits of Catmull-Clark surfaces: against refinement itself, against splines, and by their symmetries.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{
    all_limit_stencils, limit_frames, limit_points, limit_stencils, refine, refine_times, sectors,
};
use loftsman_subdivision::{BoundaryRule, Cage, LimitFrame};

/// The faces round a vertex and nothing else, with their creases: what a limit depends on. The vertex keeps its place round which
/// edges are counted; it is vertex 0.
fn cropped(cage: &Cage, vertex: usize) -> Cage {
    let topology = cage.topology();
    let mut kept = vec![vertex];
    let mut faces = Vec::new();
    for half in topology.around(vertex) {
        let face = (0..topology.face_count())
            .find(|&f| topology.face_corners(f).contains(&(half as usize)))
            .unwrap();
        let start = half as usize - topology.face_corners(face).start;
        let mut corners: Vec<usize> = topology.face(face).iter().map(|&v| v as usize).collect();
        corners.rotate_left(start);
        faces.push(
            corners
                .iter()
                .map(|&v| {
                    kept.iter().position(|&k| k == v).unwrap_or_else(|| {
                        kept.push(v);
                        kept.len() - 1
                    })
                })
                .collect::<Vec<_>>(),
        );
    }
    let points = kept.iter().map(|&v| cage.points()[v]).collect();
    let mut crop = Cage::new(points, &faces)
        .unwrap()
        .with_boundary(cage.boundary())
        .with_corner(0, cage.corner(vertex))
        .unwrap();
    for edge in topology.vertex_edges(vertex) {
        let [a, b] = topology.edge(edge as usize).unwrap();
        let place = |v: u32| kept.iter().position(|&k| k == v as usize).unwrap();
        crop = crop.with_crease(place(a), place(b), cage.crease(edge as usize)).unwrap();
    }
    crop
}

fn normal(a: Vector, b: Vector) -> Option<Vector> {
    LimitFrame { point: Point::origin(), tangents: [a, b] }.normal()
}

/// How many explicit levels position is compared with.
const LEVELS: usize = 45;

#[test]
fn positions_are_where_refinement_goes() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all() {
        let limits = limit_points(&cage).unwrap();
        let rows = all_limit_stencils(&cage).unwrap();
        for v in [0, 1, 4].into_iter().filter(|&v| v < cage.points().len()) {
            let stencils = limit_stencils(&cage, v, 0).unwrap();
            assert_eq!(stencils, rows[v]);
            let total: f64 = stencils.position.coefficients().iter().sum();
            assert!((total - 1.0).abs() < 4e-15, "{name}, vertex {v}: {total}");
            assert!(
                (stencils.position.apply(cage.points()) - limits[v].coords).norm() < 1e-14,
                "{name}, vertex {v}"
            );
            let mut ring = cropped(&cage, v);
            for level in 0..LEVELS {
                ring = refine(&ring).unwrap();
                ring = cropped(&ring, 0);
                if level == 3 || level == 11 {
                    // The limit is that of every refinement, too.
                    let p = limit_points(&ring).unwrap()[0];
                    assert!(
                        (p - limits[v]).norm() < 1e-14,
                        "{name}, vertex {v}, level {level}: {p} {}",
                        limits[v]
                    );
                }
            }
            // The slowest valence here is 12, by a factor of 0.75 a level.
            let far = (ring.points()[0] - limits[v]).norm();
            assert!(far < 1e-4 * 0.75f64.powi(LEVELS as i32 - 15).max(1e-8), "{name}, vertex {v}: {far:e}");
            count += 1;
        }
    }
    assert!(count > 600, "{count}");
}

#[test]
fn tangents_stay_in_their_plane_under_refinement() {
    for (name, cage) in crate::shapes::all() {
        let frames = limit_frames(&cage).unwrap();
        for v in [0, 1, 4].into_iter().filter(|&v| v < cage.points().len()) {
            for sector in 0..sectors(&cage, v).unwrap() {
                let stencils = limit_stencils(&cage, v, sector).unwrap();
                let rows = stencils.tangents;
                for row in &rows {
                    let total: f64 = row.coefficients().iter().sum();
                    assert!(total.abs() < 1e-14, "{name}, vertex {v}: {total}");
                }
                let tangents = rows.map(|row| row.apply(cage.points()));
                if sector == 0 {
                    let same = |k: usize| (frames[v].tangents[k] - tangents[k]).norm() < 1e-13;
                    assert!(same(0) && same(1), "{name}, vertex {v}: {:?} {tangents:?}", frames[v].tangents);
                }
                let Some(here) = normal(tangents[0], tangents[1]) else { continue };
                let mut ring = cropped(&cage, v);
                for level in 0..14 {
                    ring = cropped(&refine(&ring).unwrap(), 0);
                    let child = limit_stencils(&ring, 0, sector)
                        .unwrap()
                        .tangents
                        .map(|row| row.apply(ring.points()));
                    let there = normal(child[0], child[1]).unwrap();
                    // A flat valence-2 vertex or corner has no plane of its own.
                    let plane = cage.topology().valence(v) > 2 || sectors(&cage, v).unwrap() == 1;
                    if level > 0 && (level == 3 || level == 11) && plane && !is_corner(&cage, v) {
                        assert!(
                            (here - there).norm() < 2e-7,
                            "{name}, vertex {v}, sector {sector}: {here} {there}"
                        );
                    }
                }
            }
        }
    }
}

/// Whether the edges at a vertex go on turning: only first differences of a corner stay.
fn is_corner(cage: &Cage, v: usize) -> bool {
    sectors(cage, v).unwrap() == cage.topology().around(v).count() && !cage.topology().is_boundary_vertex(v)
        || cage.corner(v) >= 10.0
        || cage.topology().is_boundary_vertex(v) && sectors(cage, v).unwrap() > 1
}

/// The normals of the faces of deep refinements come to the normal that is computed, for valences where they do so quickly.
#[test]
fn normals_are_where_refinement_goes() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all() {
        let frames = limit_frames(&cage).unwrap();
        for v in 0..cage.points().len().min(4) {
            let valence = cage.topology().valence(v);
            let inner = !cage.topology().is_boundary_vertex(v);
            if !(3..=6).contains(&valence) && inner || valence > 4 && !inner || is_corner(&cage, v) {
                continue;
            }
            let two_sided = sectors(&cage, v).unwrap() > 1;
            if two_sided || (valence == 2 && cage.boundary() == BoundaryRule::EdgeOnly) {
                continue;
            }
            let Some(expected) = frames[v].normal() else { continue };
            let mut ring = cropped(&cage, v);
            let mut off = f64::MAX;
            for _ in 0..22 {
                ring = cropped(&refine(&ring).unwrap(), 0);
                let topology = ring.topology();
                let mut sum = Vector::zeros();
                for edges in topology.around(0) {
                    let face = topology.face(edges as usize / 4);
                    let at = face.iter().position(|&k| k == 0).unwrap();
                    let p = |k: usize| ring.points()[face[(at + k) % face.len()] as usize] - ring.points()[0];
                    sum += p(1).cross(&p(3)).normalize();
                }
                off = off.min((sum.normalize() - expected).norm());
            }
            assert!(off < 3e-3, "{name}, vertex {v}: off {off:e}");
            count += 1;
        }
    }
    assert!(count > 300, "{count}");
}

#[test]
fn the_numbers_of_a_cube() {
    let cube = crate::shapes::cube();
    let stencil = limit_stencils(&cube, 0, 0).unwrap().position;
    let expected = [3.0 / 8.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 24.0];
    for (v, c) in stencil.iter() {
        assert!((c - expected[v]).abs() < 1e-15, "{v}: {c}");
    }
    assert_eq!(stencil.vertices().len(), 7);
}

#[test]
fn a_closed_grid_is_a_periodic_bicubic_spline() {
    for times in 0..2 {
        let (rows, columns) = (5, 7);
        let cage = crate::shapes::grid(rows, columns, [true, true], 0.4);
        let spline = Surface::new(
            Space::periodic_uniform(3, rows).unwrap(),
            Space::periodic_uniform(3, columns).unwrap(),
            cage.points().to_vec(),
        )
        .unwrap();
        let fine = refine_times(&cage, times).unwrap();
        let frames = limit_frames(&fine).unwrap();
        // Vertex (i, j) is where the middle of its support is: two knots after its start.
        for (k, frame) in frames.iter().enumerate().take(rows * columns) {
            let (u, v) = ((k / columns + 2) % rows, (k % columns + 2) % columns);
            let at = Location::Surface(u as f64, v as f64);
            let p = spline.value(at, Derivative { u: 0, v: 0 }).unwrap();
            assert!((frame.point.coords - p).norm() < 1e-14);
            let [du, dv] = [(1, 0), (0, 1)].map(|(u, v)| spline.value(at, Derivative { u, v }).unwrap());
            let (a, b) = (normal(du, dv).unwrap(), frame.normal().unwrap());
            assert!((a - b).norm() < 1e-13, "{a} {b}");
        }
    }
}

#[test]
fn valences_of_hundreds_are_no_trouble() {
    for n in [40, 500] {
        for sharpness in [0.0, 2.5, f64::INFINITY] {
            let cage = crate::shapes::fan(n, 4, true, 0.0).with_crease(0, 1, sharpness).unwrap();
            let frame = limit_frames(&cage).unwrap()[0];
            let z = frame.normal().unwrap();
            assert!(z.z > 0.9, "{n} {sharpness}: {z}");
            let total: f64 = limit_stencils(&cage, 0, 0).unwrap().position.coefficients().iter().sum();
            assert!((total - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn frames_go_with_rigid_motions_and_sizes() {
    let turn = |p: &Point| Point::new(-p.y, p.x, p.z);
    for (name, cage) in crate::shapes::all().into_iter().step_by(2) {
        let frames = limit_frames(&cage).unwrap();
        for size in [1e-9, 1.0, 1e9] {
            let mut moved = cage.clone();
            moved.points_mut().iter_mut().for_each(|p| *p = Point::from(turn(p).coords * size));
            for (a, b) in frames.iter().zip(limit_frames(&moved).unwrap()) {
                assert!((turn(&a.point).coords * size - b.point.coords).norm() < 1e-14 * size, "{name}");
                if let (Some(a), Some(b)) = (a.normal(), b.normal())
                    && a.iter().all(|c| c.abs() < 1.0)
                {
                    let conditioned = a.norm() > 0.5;
                    assert!(
                        !conditioned || (turn(&Point::from(a)).coords - b).norm() < 1e-9,
                        "{name}: {a} {b}"
                    );
                }
            }
        }
    }
}

#[test]
fn coincident_points_give_points_and_no_normal() {
    let mut cage = crate::shapes::fan(5, 5, true, 0.1);
    cage.points_mut().fill(Point::new(1.0, 2.0, 3.0));
    for frame in limit_frames(&cage).unwrap() {
        assert!((frame.point - Point::new(1.0, 2.0, 3.0)).norm() < 1e-14);
    }
    assert!(
        limit_stencils(&crate::shapes::cube(), 8, 0).is_err()
            && limit_stencils(&crate::shapes::cube(), 0, 1).is_err()
    );
}
