//! Faces sewn: solids taken apart and put together again, against closed forms, for every way that faces come in.

use std::f64::consts::{PI, TAU};

use loftsman::construction::{Sewn, sew};
use loftsman::kernel::brep::Brep;
use loftsman::kernel::plugin::{Chord, Context, Fineness, Parameters};
use loftsman::kernel::scene::{Geometry, Object, Scene};
use loftsman::kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman::kernel::spline::{Curve, Direction, Space, Surface, Trimmed};
use loftsman::kernel::{Point, Vector};
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn sewn(geometries: &[Geometry], near: f64) -> Sewn {
    sew(geometries, near, loftsman::registry().tessellator().unwrap()).unwrap()
}

/// The volume of a fine mesh, which must be watertight.
fn volume(brep: &Brep) -> f64 {
    let fineness = Fineness { chord: Chord::Relative(1e-4), angle: 0.2 };
    let cut = loftsman::registry().tessellator().unwrap().measured_brep(brep, &fineness).unwrap();
    assert!(cut.left_out.is_empty(), "{:?}", cut.left_out);
    let mut edges = std::collections::BTreeMap::new();
    for corners in cut.mesh.corners().chunks(3) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|count| *count == 0), "it is not watertight");
    let p = |k: u32| cut.mesh.points()[k as usize].coords;
    cut.mesh.corners().chunks(3).map(|t| p(t[0]).dot(&p(t[1]).cross(&p(t[2]))) / 6.0).sum()
}

fn flat(corners: [Point; 4]) -> Surface {
    let space = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let [a, b, c, d] = corners;
    Surface::new(space(), space(), vec![a, d, b, c]).unwrap()
}

/// The sides of a box as surfaces, each turned, swapped and reversed in another way.
fn sides(size: f64, at: Point, seed: usize) -> Vec<Geometry> {
    let corner =
        |k: usize| at + Vector::new((k & 1) as f64, (k >> 1 & 1) as f64 * 2.0, (k >> 2) as f64 * 3.0) * size;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (0..6)
        .map(|face| {
            let mut surface = flat(faces[face].map(corner));
            if (seed >> face) & 1 == 1 {
                surface = surface.reverse(Direction::U).unwrap();
            }
            if (seed >> (face + 3)) & 1 == 1 {
                surface = surface.reverse(Direction::V).unwrap();
            }
            surface.into()
        })
        .collect()
}

#[test]
fn sides_of_a_box_become_a_solid_however_they_are_turned() {
    for (seed, size) in [(0, 1.0), (11, 1e-9), (173, 1e9), (298, 1.0), (511, 1e-3)] {
        for at in [Point::origin(), Point::new(7.0, -5.0, 100.0) * size] {
            let made = sewn(&sides(size, at, seed), 1e-7 * size);
            assert_eq!((made.joined, made.open.len(), made.cut, made.short), (12, 0, 0, 0));
            assert_eq!(
                (made.brep.solids().len(), made.brep.edge_count(), made.brep.vertices().len()),
                (1, 12, 8)
            );
            assert!(made.gap <= 1e-13 * 100.0 * size && made.flaws.is_empty());
            let found = volume(&made.brep);
            assert!((found / (6.0 * size.powi(3)) - 1.0).abs() < 1e-9, "{seed} {size:e} {found:e}");
        }
    }
}

/// A gap below the tolerance is closed and measured, one above it left and told.
#[test]
fn gaps_are_measured() {
    for near in [1e-1, 1e-2, 1e-4] {
        let mut faces = sides(1.0, Point::origin(), 77);
        let gap = 0.4 * near;
        let moved = faces[0].transformed(&Matrix4::new_translation(&Vector::new(0.0, 0.0, gap))).unwrap();
        faces[0] = moved;
        let made = sewn(&faces, near);
        assert_eq!((made.open.len(), made.brep.solids().len()), (0, 1));
        assert!((made.gap - gap).abs() < 1e-9, "{} {gap}", made.gap);
        let most = (0..12).map(|edge| made.brep.edge(edge).unwrap().tolerance).fold(0.0, f64::max);
        assert!((gap..2.0 * near).contains(&(most + 1e-12)), "{most} {gap}");
        let made = sewn(&faces, 0.2 * near);
        assert!(made.brep.solids().is_empty() && made.open.len() == 8, "{:?}", made.open);
        assert!((made.next.unwrap() - gap).abs() < 1e-9, "{:?} {gap}", made.next);
    }
}

/// Faces of closed surfaces: seams, poles, both.
#[test]
fn surfaces_that_close_are_sewn_to_themselves() {
    let at = Point::new(3.0, -2.0, 1.0);
    let half = Curve::elliptic_arc(at, Vector::z() * -2.0, Vector::x() * 2.0, 0.0, PI).unwrap();
    let sphere = Surface::revolution(&half, at, Vector::z(), TAU).unwrap();
    let ring = Curve::circle(at + Vector::x() * 3.0, Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&ring, at, Vector::z(), TAU).unwrap();
    for (name, surface, exact, edges) in
        [("sphere", sphere, 4.0 / 3.0 * PI * 8.0, 1), ("torus", torus, 2.0 * PI * PI * 3.0, 2)]
    {
        for surface in [surface.clone(), surface.reverse(Direction::U).unwrap()] {
            let made = sewn(&[surface.into()], 1e-6);
            assert_eq!((made.open.len(), made.brep.solids().len()), (0, 1), "{name}");
            assert_eq!(made.brep.edge_count(), edges, "{name}");
            let found = volume(&made.brep);
            assert!((found / exact - 1.0).abs() < 1e-3, "{name} {found} {exact}");
        }
    }
}

/// A cylinder between lids that other loops bound: circles that start elsewhere, run the other way, in halves.
#[test]
fn lids_of_a_cylinder_start_anywhere() {
    let (radius, high) = (2.0, 5.0);
    let line = Curve::line(Point::new(radius, 0.0, 0.0), Point::new(radius, 0.0, high)).unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
    for (k, turn) in [0.0_f64, 0.3, 1.0, 2.5].into_iter().enumerate() {
        let lid = |z: f64, halves: bool, backwards: bool| -> Geometry {
            let corner = |x: f64, y: f64| Point::new(4.0 * (x - 0.5), 4.0 * (y - 0.5), 0.0);
            let plane = flat([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
            let plane = plane.transformed(&Matrix4::new_translation(&Vector::new(0.0, 0.0, z))).unwrap();
            let (x, y) = (
                Vector::new(turn.cos(), turn.sin(), 0.0) * 0.5,
                Vector::new(-turn.sin(), turn.cos(), 0.0) * 0.5,
            );
            let middle = Point::new(0.5, 0.5, 0.0);
            let arc = |from: f64, sweep: f64| {
                let arc = Curve::elliptic_arc(middle, x, y, from, sweep).unwrap();
                ParameterCurve::whole(if backwards { arc.reverse().unwrap() } else { arc }).unwrap()
            };
            let mut outer = if halves { vec![arc(0.0, PI), arc(PI, PI)] } else { vec![arc(0.0, TAU)] };
            if backwards {
                outer.reverse();
            }
            let region = Region { outer, holes: vec![] };
            Trimmed::new(plane, vec![region], vec![], vec![]).unwrap().into()
        };
        let faces = [tube.clone().into(), lid(0.0, k % 2 == 0, k > 1), lid(high, k % 2 == 1, k < 2)];
        let made = sewn(&faces, 1e-6);
        assert_eq!((made.open.len(), made.brep.solids().len()), (0, 1), "{turn}: {:?}", made.open);
        let (found, exact) = (volume(&made.brep), PI * radius * radius * high);
        assert!((found / exact - 1.0).abs() < 1e-3, "{turn}: {found} {exact}");
    }
}

/// One long edge along several short ones.
#[test]
fn edges_are_cut_where_others_end() {
    let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    let mut faces = sides(1.0, Point::origin(), 0);
    faces.retain(|face| face.points().iter().any(|q| q.z < 3.0));
    assert_eq!(faces.len(), 5);
    // The lid of three strips.
    for (a, b) in [(0.0, 0.3), (0.3, 1.1), (1.1, 2.0)] {
        faces.push(flat([p(0.0, a, 3.0), p(0.0, b, 3.0), p(1.0, b, 3.0), p(1.0, a, 3.0)]).into());
    }
    let made = sewn(&faces, 1e-6);
    assert_eq!((made.open.len(), made.brep.solids().len(), made.cut), (0, 1, 4));
    assert_eq!(made.brep.edge_count(), 8 + 2 + 2 + 6);
    assert!((volume(&made.brep) - 6.0).abs() < 1e-9);
}

/// A shell within another bounds what is hollow, one within that is a solid again; beside it they are solids all.
#[test]
fn shells_within_one_another_are_hollows() {
    for seed in [0, 9, 500] {
        let mut faces = Vec::new();
        for (size, at) in [(4.0, 0.0), (2.0, 0.9), (1.0, 1.1), (0.4, 1.3), (1.0, 50.0), (0.3, 2.35)] {
            faces.extend(sides(size, Point::new(at, at, at), seed));
        }
        let made = sewn(&faces, 1e-6);
        let voids: Vec<usize> = made.brep.solids().iter().map(|solid| solid.voids.len()).collect();
        // Of size 4 with 2 in it, of 1 in that with .4 in it, of .3 in the hollow beside that, and one far away.
        assert_eq!((made.open.len(), voids), (0, vec![1, 1, 0, 0]), "{seed}");
        let expected = 6.0 * (64.0 - 8.0 + 1.0 - 0.064 + 1.0 + 0.027);
        assert!((volume(&made.brep) - expected).abs() < 1e-9, "{seed}");
    }
}

/// What no way of turning fits, and where three faces meet.
#[test]
fn one_side_and_three_faces_are_told() {
    // A band of four pieces with half a turn.
    let rung = |k: usize| {
        let (t, half) = (TAU * k as f64 / 5.0, PI * k as f64 / 5.0);
        let out = Vector::new(t.cos(), t.sin(), 0.0);
        let across = out * half.cos() + Vector::z() * half.sin();
        [Point::origin() + out * 3.0 - across, Point::origin() + out * 3.0 + across]
    };
    let band: Vec<Geometry> = (0..5)
        .map(|k| {
            let ([a, b], [mut d, mut c]) = (rung(k), rung((k + 1) % 5));
            if k == 4 {
                std::mem::swap(&mut c, &mut d);
            }
            flat([a, b, c, d]).into()
        })
        .collect();
    let made = sewn(&band, 1e-6);
    assert_eq!((made.one_sided, made.joined, made.brep.solids().len()), (1, 5, 0));
    let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    let leaf = |t: f64| -> Geometry {
        flat([p(0.0, 0.0, 0.0), p(0.0, 0.0, 1.0), p(t.cos(), t.sin(), 1.0), p(t.cos(), t.sin(), 0.0)]).into()
    };
    let made = sewn(&[leaf(0.0), leaf(2.0), leaf(4.0)], 1e-6);
    assert_eq!((made.joined, made.open.len(), made.brep.shells().len()), (1, 10, 2));
}

/// A face without loops is the whole of a surface that closes: sewn with others, it stays a solid of its own. Tolerances below rounding stop at what is equal.
#[test]
fn faces_without_edges_are_whole() {
    let half = Curve::elliptic_arc(Point::origin(), Vector::z() * -2.0, Vector::x() * 2.0, 0.0, PI).unwrap();
    let sphere = Surface::revolution(&half, Point::origin(), Vector::z(), TAU).unwrap();
    let made = sewn(&[sphere.into()], 1e-6).brep;
    let mut parts = made.parts();
    (parts.shells, parts.solids, parts.faces[0].loops) = (vec![], vec![], vec![]);
    parts.drop_unused();
    let ball: Geometry = Brep::new(parts).unwrap().into();
    let mut faces = sides(1.0, Point::new(9.0, 0.0, 0.0), 3);
    faces.push(ball);
    for near in [1e-6, 1e-18, 1e-300] {
        let made = sewn(&faces, near);
        assert_eq!((made.brep.face_count(), made.brep.solids().len()), (7, 2), "{near:e}");
        let exact = 6.0 + 4.0 / 3.0 * PI * 8.0;
        assert!((volume(&made.brep) / exact - 1.0).abs() < 1e-3);
    }
}

/// Objects in frames that change their sizes: the tolerance and the gap are the scene's.
#[test]
fn the_tolerance_is_one_of_the_scene() {
    let square = |from: f64| {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        flat([p(from, 0.0), p(from + 1.0, 0.0), p(from + 1.0, 1.0), p(from, 1.0)])
    };
    for map in [
        Matrix4::new_scaling(100.0),
        Matrix4::new_scaling(0.01),
        Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 0.5, 1.0)),
    ] {
        let mut scene = Scene::new();
        let back = map.try_inverse().unwrap();
        let mut one = Object::new("one", Geometry::from(square(0.0)).transformed(&back).unwrap());
        one.transform = Some(map);
        scene.add(one).unwrap();
        scene.add(Object::new("two", square(1.03).into())).unwrap();
        let mut other = scene.clone();
        let said = run(&mut scene, json!({ "objects": ["one", "two"], "tolerance": 0.031 })).unwrap();
        assert!(said[0].contains("1 pair of edges is joined, 0.03 m apart"), "{said:?}");
        assert_eq!(scene.objects()[0].transform, None);
        let said = run(&mut other, json!({ "objects": ["one", "two"], "tolerance": 0.029 })).unwrap();
        assert!(said.iter().any(|note| note.contains("open at 8 edges")), "{said:?}");
    }
}

fn run(scene: &mut Scene, fields: Value) -> Result<Vec<String>, String> {
    let registry = loftsman::registry();
    let operation = registry.find_operation("sew", "op").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    let report = operation.apply(scene, &parameters, &Context::quiet(registry)).map_err(|e| e.to_string())?;
    Ok(report.notes.into_iter().chain(report.warnings).collect())
}

#[test]
fn objects_become_one_in_the_frame_of_the_first() {
    let mut scene = Scene::new();
    for (k, face) in sides(1.0, Point::origin(), 5).into_iter().enumerate() {
        let map = Matrix4::new_rotation(Vector::new(0.1, 0.2, 0.3) * k as f64)
            * Matrix4::new_translation(&Vector::new(k as f64, 1.0, 0.0));
        let back = map.try_inverse().unwrap();
        let mut object = Object::new(format!("side {k}"), face.transformed(&back).unwrap());
        object.transform = Some(map);
        object.color = (k == 2).then_some([1.0, 0.0, 0.0, 1.0]);
        scene.add(object).unwrap();
    }
    let before = scene.clone();
    let said = run(&mut scene, json!({ "objects": ["side*"], "name": "box" })).unwrap();
    assert!(said[0].starts_with("6 faces: 12 pairs of edges are joined"), "{said:?}");
    assert_eq!(scene.objects().len(), 1);
    let Geometry::Brep(brep) = scene.object("box").unwrap().geometry() else { panic!("a brep") };
    assert_eq!((brep.solids().len(), brep.face_color(2)), (1, Some([1.0, 0.0, 0.0, 1.0])));
    assert_eq!(brep.face_name(3), Some("side 3"));
    assert!((volume(brep) - 6.0).abs() < 1e-9);
    // Again: there is nothing to do, and that is said.
    let error = run(&mut scene, json!({ "objects": ["box"] })).unwrap_err();
    assert!(error.contains("a solid already"), "{error}");
    let mut scene = before.clone();
    let said = run(&mut scene, json!({ "objects": ["side 0", "side 1", "side 2"], "keep": true })).unwrap();
    assert_eq!(scene.objects().len(), 7);
    assert!(said.iter().any(|note| note.contains("open at ")), "{said:?}");
    for (fields, problem) in [
        (json!({ "objects": [] }), "empty"),
        (json!({ "objects": ["side 0"], "tolerance": 0 }), "no length"),
        (json!({ "objects": ["side 0"], "tolerance": 100 }), "no tolerance"),
        (json!({ "objects": ["side 0"], "tolerance": 1e-18 }), "above rounding"),
        (json!({ "objects": ["side 0"], "tolerance": 1e-300 }), "above rounding"),
        (json!({ "objects": ["nothing"] }), "step[0].objects: "),
    ] {
        let mut scene = before.clone();
        let error = run(&mut scene, fields).unwrap_err();
        assert!(error.contains(problem), "{error}");
        assert_eq!(scene.objects(), before.objects());
    }
}
