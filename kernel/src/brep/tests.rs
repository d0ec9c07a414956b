//! Breps built, refused, moved and measured.

use nalgebra::Matrix4;

use super::*;
use crate::{Point, Vector};

fn corner(k: usize) -> Point {
    Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)
}

/// The cube from 0 to 1, its faces planes, its normals outwards.
fn cube() -> Parts {
    Brep::block(corner(0), corner(7)).unwrap().parts()
}

#[test]
fn a_cube_is_built_and_taken_apart() {
    let parts = cube();
    let brep = Brep::new(parts.clone()).unwrap();
    assert_eq!((brep.face_count(), brep.edge_count(), brep.vertices().len()), (6, 12, 8));
    assert!(brep.is_closed(&[0, 1, 2, 3, 4, 5]) && !brep.is_closed(&[0, 1, 2]));
    assert_eq!(brep.open_edges(&[0]).len(), 4);
    assert!((0..12).all(|edge| brep.uses(edge).len() == 2));
    assert_eq!(brep.flaws(0.0).unwrap(), vec![]);
    assert_eq!(brep.parts(), parts);
    assert_eq!(Brep::new(brep.parts()).unwrap(), brep);
}

fn frame() -> Frame {
    Frame::new(Point::origin(), Vector::z(), Vector::x()).unwrap()
}

#[test]
fn what_does_not_fit_is_refused_by_number() {
    let refused = |spoil: &dyn Fn(&mut Parts), says: &str| {
        let mut parts = cube();
        spoil(&mut parts);
        let error = Brep::new(parts).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    refused(
        &|p| p.faces[2].loops[0][1].edge = 99,
        "face 2: loop 0: it names edge 99, but there are 12 edges",
    );
    refused(&|p| p.faces[2].loops[0].swap(0, 1), "face 2: loop 0: it is torn");
    refused(&|p| drop(p.faces[2].loops[0].pop()), "does not close");
    refused(&|p| p.faces[2].loops[0].clear(), "it has no edges");
    refused(&|p| p.edges[3].ends[0] = 8, "edge 3: it names vertex 8");
    refused(&|p| p.edges[3].range = (0.5, 0.5), "edge 3: it runs from 0.5 to 0.5");
    refused(&|p| p.edges[3].range = (0.5, 1.5), "at most 1");
    refused(&|p| p.edges[3].tolerance = f64::NAN, "edge 3: the tolerance NaN is no length");
    refused(&|p| p.vertices[1].point.x = f64::INFINITY, "every coordinate");
    refused(&|p| p.vertices[1].tolerance = -1.0, "vertex 1: the tolerance -1");
    refused(&|p| p.shells[0].faces.push(0), "shell 0: face 0 is in shell 0 already");
    refused(&|p| p.shells[0].faces.push(6), "names face 6");
    refused(&|p| p.solids[0].voids.push(0), "solid 0: shell 0 is in solid 0 already");
    refused(&|p| p.shells[0].faces.truncate(5), "does not close at 4 of its edges");
    refused(&|p| p.solids[0].outer = 1, "names shell 1");
    refused(
        &|p| p.faces[0].form = SurfaceForm::Cylinder { frame: frame(), radius: 0.0 },
        "face 0: a radius of 0 is no size",
    );
    let skew = Frame { x: Vector::z(), ..frame() };
    refused(&|p| p.edges[2].form = CurveForm::Circle { frame: skew, radius: 1.0 }, "edge 2: the frame");
    refused(&|p| p.faces[0].points.push(9), "face 0: it names vertex 9");
    refused(
        &|p| {
            p.faces.push(Face { loops: vec![], ..p.faces[0].clone() });
            p.shells[0].faces.push(6);
        },
        "a face without loops on a surface that does not close",
    );
    // A face turned over: its edges run the same way as their other faces'.
    refused(
        &|p| {
            let chain = &mut p.faces[0].loops[0];
            chain.reverse();
            chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
        },
        "does not close at 4 of its edges",
    );
}

#[test]
fn moved_breps_keep_their_forms_where_they_may() {
    let mut parts = cube();
    parts.edges.iter_mut().for_each(|edge| edge.tolerance = 1e-9);
    let brep = Brep::new(parts).unwrap();
    let moved = |map: &Matrix4<f64>| {
        let points = brep.points().iter().map(|p| map.transform_point(p)).collect();
        brep.transformed(points, map).unwrap()
    };
    let turn = Matrix4::from_axis_angle(&nalgebra::Unit::new_normalize(Vector::new(1.0, 2.0, 3.0)), 0.7)
        .append_translation(&Vector::new(5.0, 0.0, 1.0))
        * Matrix4::new_scaling(3.0);
    let turned = moved(&turn);
    assert!(matches!(turned.surface_form(0), SurfaceForm::Plane { .. }));
    assert_eq!(turned.edge(0).unwrap().form, CurveForm::Line);
    assert!((turned.edge(0).unwrap().tolerance - 3e-9).abs() < 1e-22);
    assert_eq!(turned.flaws(1e-12).unwrap(), vec![]);
    let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-1.0, 2.0, 1.0));
    let mirrored = moved(&mirror);
    assert!(mirrored.is_reversed(0) && mirrored.is_closed(&mirrored.shells()[0].faces));
    assert_eq!(
        Brep::new(mirrored.parts()).unwrap(),
        mirrored,
        "its chains still close, and its uses are where it says"
    );
    let SurfaceForm::Plane { frame } = mirrored.surface_form(5) else { unreachable!() };
    assert!(
        mirrored.surface(5).unwrap().points().iter().all(|p| (p - frame.origin).dot(&frame.z).abs() < 1e-14)
    );

    assert_eq!(brep.with_points(brep.points().to_vec()).unwrap(), brep);
    let mut points = brep.points().to_vec();
    points[0].z += 0.25;
    let bent = brep.with_points(points.clone()).unwrap();
    assert_eq!((bent.surface_form(0), bent.surface_form(1)), (SurfaceForm::Spline, brep.surface_form(1)));
    points.pop();
    assert!(brep.with_points(points).is_err());
}

#[test]
fn flaws_are_found_where_they_are() {
    let mut parts = cube();
    parts.vertices[0].point.x -= 0.25;
    let flaws = Brep::new(parts).unwrap().flaws(0.0).unwrap();
    assert_eq!(flaws.len(), 3, "{flaws:?}");
    assert!(flaws.iter().all(|f| matches!(f, Flaw::End { vertex: 0, .. }) && f.distance() == 0.25));

    let mut parts = cube();
    // An edge that bulges out of its two faces.
    let [a, b] = parts.edges[0].ends.map(corner);
    let middle = nalgebra::center(&a, &b) + Vector::new(-0.1, -0.1, -0.2);
    parts.edges[0].curve = Curve::bezier(vec![a, middle, b]).unwrap();
    let brep = Brep::new(parts).unwrap();
    let flaws = brep.flaws(0.0).unwrap();
    assert_eq!(flaws.len(), 2, "{flaws:?}");
    for flaw in &flaws {
        let Flaw::Off { edge: 0, face, at, distance } = *flaw else { unreachable!("{flaw:?}") };
        let expected =
            brep.surface(face).unwrap().closest(brep.curve(0).unwrap().point(0.5).unwrap()).unwrap();
        assert!(at == 0.5 && (distance - expected.distance).abs() < 1e-9, "{flaw} {expected:?}");
    }
    assert_eq!(brep.flaws(0.2).unwrap(), vec![]);
}

#[test]
fn blocks_without_extent_are_refused() {
    for (low, high) in [(0, 0), (0, 3), (7, 0)] {
        assert!(Brep::block(corner(low), corner(high)).is_err());
    }
    assert!(Brep::block(corner(0), Point::new(1.0, f64::NAN, 1.0)).is_err());
}

#[test]
fn a_sphere_without_edges_is_a_solid() {
    let form = SurfaceForm::Sphere { frame: frame(), radius: 2.0 };
    let face = Face {
        name: None,
        color: None,
        surface: form.covering(&[]).unwrap(),
        form,
        reversed: false,
        loops: vec![],
        points: vec![],
    };
    let parts = Parts {
        faces: vec![face],
        shells: vec![Shell { faces: vec![0] }],
        solids: vec![Solid::default()],
        ..Parts::default()
    };
    let brep = Brep::new(parts).unwrap();
    assert!(brep.is_closed(&[0]) && brep.points().len() == 9 * 5);
}

#[test]
fn blocks_of_any_size_have_six_planes() {
    for size in [1e-300, 1e-9, 1.0, 1e9, 1e150, 1e300] {
        let block = Brep::block(Point::origin(), Point::new(size, 2.0 * size, 3.0 * size)).unwrap();
        assert!((0..6).all(|face| matches!(block.surface_form(face), SurfaceForm::Plane { .. })), "{size:e}");
        let far = block.vertices().iter().map(|p| p.z).fold(0.0, f64::max);
        assert!(far == 3.0 * size, "{far:e}");
    }
    for wrong in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let error = Brep::block(Point::origin(), Point::new(wrong, 1.0, 1.0)).unwrap_err().to_string();
        assert!(error.contains("no block lies between"), "{error}");
    }
}
