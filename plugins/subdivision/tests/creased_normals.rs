//! Normals along creases that never end: each side has its own.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{DeclaredShape, Drawn, Fineness};
use loftsman_subdivision::{Cage, SubdivisionSurface, catmull_clark};

/// A cube whose top is bounded by creases of a sharpness.
fn box_with_edge(sharpness: f64) -> Cage {
    let cube = crate::shapes::cube();
    let top = cube.topology().face(1).to_vec();
    (0..4).fold(cube, |cage, k| {
        cage.with_crease(top[k] as usize, top[(k + 1) % 4] as usize, sharpness).unwrap()
    })
}

/// The largest angle between a corner's normal and its face's, in degrees.
fn worst(mesh: &Mesh) -> f64 {
    let mut most = 0.0_f64;
    for face in 0..mesh.face_count() {
        let Some(normal) = mesh.face_normal(face) else { continue };
        for corner in mesh.starts()[face]..mesh.starts()[face + 1] {
            let own = mesh.normals.at(corner, mesh.corners()[corner]).unwrap();
            most = most.max(own.angle(&normal).to_degrees());
        }
    }
    most
}

fn at_limit(cage: &Cage, levels: usize) -> Mesh {
    let fine = catmull_clark::refine_times(cage, levels).unwrap();
    let frames = catmull_clark::limit_frames(&fine).unwrap();
    let mut mesh = fine.to_mesh().unwrap();
    mesh.points_mut().iter_mut().zip(&frames).for_each(|(p, frame)| *p = frame.point);
    mesh.normals = catmull_clark::limit_normals(&fine, &frames).unwrap();
    mesh.check().unwrap();
    mesh
}

fn triangles(cage: &Cage) -> Mesh {
    let surface = SubdivisionSurface::new(cage.clone()).unwrap();
    let faceted = SubdivisionSurface::tessellate(&[&surface], &Fineness::default()).unwrap();
    let Drawn::Mesh(mesh) = faceted.drawn else { panic!("a surface is triangles") };
    mesh.check().unwrap();
    mesh
}

#[test]
fn limits_of_vertices_have_the_normals_of_their_sides() {
    for (levels, most) in [(2, 25.0), (3, 13.0), (4, 7.0)] {
        let mesh = at_limit(&box_with_edge(10.0), levels);
        let worst = worst(&mesh);
        assert!(worst < most, "{levels} levels: {worst}");
        let once = 4 << levels;
        assert_eq!(mesh.normals.values().len(), mesh.points().len() + once, "one more a point of the edge");
    }
}

#[test]
fn triangles_have_the_normals_of_their_sides() {
    for sharpness in [10.0, f64::INFINITY] {
        let mesh = triangles(&box_with_edge(sharpness));
        let worst = worst(&mesh);
        assert!(worst < 6.0, "{worst}");
        assert!(mesh.normals.corners().is_some());
    }
}

#[test]
fn a_corner_has_one_a_face() {
    let corner = crate::shapes::cube().with_corner(0, 10.0).unwrap();
    let mesh = at_limit(&corner, 3);
    assert_eq!(mesh.normals.values().len(), mesh.points().len() + 2);
    let mesh = triangles(&corner);
    let tip = *corner.points().first().unwrap();
    let at: Vec<usize> =
        (0..mesh.corners().len()).filter(|c| mesh.points()[mesh.corners()[*c] as usize] == tip).collect();
    let mut own: Vec<u32> = at.iter().map(|c| mesh.normals.index(*c, mesh.corners()[*c])).collect();
    own.sort_unstable();
    own.dedup();
    assert_eq!(own.len(), 3);
}

#[test]
fn a_corner_of_three_creases_has_three() {
    let cube = crate::shapes::cube();
    let edges: Vec<_> = (0..12).filter_map(|e| cube.topology().edge(e)).collect();
    let sharp =
        edges.iter().fold(cube, |cage, [a, b]| cage.with_crease(*a as usize, *b as usize, 10.0).unwrap());
    for mesh in [at_limit(&sharp, 1), triangles(&sharp)] {
        assert!(worst(&mesh) < 1e-6, "all faces are plane: {}", worst(&mesh));
    }
}

#[test]
fn what_is_smooth_in_the_limit_has_one_a_point() {
    let cages = [
        box_with_edge(3.0),
        crate::shapes::cube().with_crease(0, 1, 10.0).unwrap(),
        crate::shapes::grid(3, 4, [false, false], 0.2),
        crate::shapes::fan(3, 5, true, 0.1),
    ];
    for (k, cage) in cages.iter().enumerate() {
        // A crease of one edge has two ends, and no inner vertex yet.
        assert!(at_limit(cage, 0).normals.corners().is_none(), "{k}");
        let split = triangles(cage).normals.corners().is_some();
        assert_eq!(split, k == 1, "{k}");
    }
}

#[test]
fn holes_and_intervals_keep_their_corners() {
    let cage = box_with_edge(10.0).with_hole(0).unwrap();
    let mesh = at_limit(&cage, 2);
    assert!(worst(&mesh) < 25.0, "{}", worst(&mesh));
    let [a, b] = cage.topology().edge(0).unwrap().map(|v| v as usize);
    let uneven = cage.with_interval(a, b, 2.0).unwrap();
    let mesh = at_limit(&uneven, 2);
    assert!(worst(&mesh) < 35.0, "{}", worst(&mesh));
}
