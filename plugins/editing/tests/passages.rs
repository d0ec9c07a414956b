//! What an edit tells of faces that have moved through others.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should panic")]

use loftsman_editing::Editing;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Context, Parameters, Registry};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn block(size: f64) -> Brep {
    Brep::block(Point::new(size, 0.0, -size), Point::new(3.0 * size, 3.0 * size, 3.0 * size)).unwrap()
}

/// The middle of a face, and its direction outwards.
fn middle(brep: &Brep, face: usize) -> ([f64; 2], Point, Vector) {
    let surface = brep.surface(face).unwrap();
    let at = [surface.u(), surface.v()].map(|space| {
        let (a, b) = space.domain();
        0.5 * (a + b)
    });
    let normal = surface.normal(at[0], at[1]).unwrap().vector().unwrap();
    let sign = if brep.is_reversed(face) { -1.0 } else { 1.0 };
    (at, surface.point(at[0], at[1]).unwrap(), normal * sign)
}

/// What is told of passages where the middle of a face is moved.
fn told(brep: &Brep, placed: Matrix4<f64>, faces: &[usize], by: Vector, more: Option<Value>) -> Vec<String> {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let mut object = Object::new("block", brep.clone().into());
    object.transform = Some(placed);
    let mut scene = Scene::new();
    scene.add(object).unwrap();
    let (at, ..) = middle(brep, faces[0]);
    let moved = json!({ "kind": "position", "at": { "face": faces[0], "uv": at }, "by": [by.x, by.y, by.z] });
    let asked: Vec<Value> = std::iter::once(moved).chain(more).collect();
    let parameters = Parameters::new(json!({ "faces": faces, "constraints": asked }), "step[0]").unwrap();
    let operation = registry.find_operation("edit", "op").unwrap();
    let report = operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
    let Geometry::Brep(after) = scene.object("block").unwrap().geometry() else { panic!("a brep") };
    assert_ne!(after, brep);
    report.warnings.into_iter().filter(|warning| warning.contains("moved through")).collect()
}

/// How far beyond a face a place is told to be.
fn beyond(told: &str) -> f64 {
    let quantity = told.split(" beyond it").next().unwrap().rsplit(" is ").next().unwrap();
    quantity.split(' ').next().unwrap().parse().unwrap()
}

/// Each face of a block is pushed towards the one across, whose middle is straight ahead: up to it, and beyond. Whatever the size.
#[test]
fn a_face_that_passes_the_one_across_is_told_with_how_far() {
    for size in [1e-6, 1.0, 1e6] {
        let brep = block(size);
        for face in 0..6 {
            let (_, from, out) = middle(&brep, face);
            let across = (0..6).max_by(|&a, &b| {
                let far = |face: usize| (from - middle(&brep, face).1).dot(&out);
                far(a).total_cmp(&far(b))
            });
            let across = across.unwrap();
            let depth = (from - middle(&brep, across).1).norm();
            let told = |share: f64| told(&brep, Matrix4::identity(), &[face], -out * (share * depth), None);
            for share in [0.9, 0.999_99, -1.5] {
                assert!(told(share).is_empty(), "{size} {face} {share}: {:?}", told(share));
            }
            for share in [1.001, 1.3] {
                let told = told(share);
                let [one] = &told[..] else { panic!("{size} {face} {share}: {told:?}") };
                assert!(
                    one.starts_with(&format!("face {face} has moved through face {across}, which")),
                    "{one}"
                );
                assert!((beyond(one) / ((share - 1.0) * depth) - 1.0).abs() < 1e-3, "{one}");
            }
        }
    }
}

/// A top that is pulled aside passes a wall where it goes down as well, and none where it goes up over it. It stands twice as large in the scene.
#[test]
fn what_goes_over_a_wall_does_not_pass_it() {
    let brep = block(1.0);
    let top = (0..6).max_by(|&a, &b| middle(&brep, a).1.z.total_cmp(&middle(&brep, b).1.z)).unwrap();
    let wall = (0..6).max_by(|&a, &b| middle(&brep, a).1.x.total_cmp(&middle(&brep, b).1.x)).unwrap();
    let twice = Matrix4::new_scaling(2.0);
    assert!(told(&brep, twice, &[top], Vector::new(1.5, 0.0, 1.0), None).is_empty());
    let told = told(&brep, twice, &[top], Vector::new(1.5, 0.0, -1.0), None);
    let [one] = &told[..] else { panic!("{told:?}") };
    assert!(
        one.starts_with(&format!("face {top} has moved through face {wall}, which stands still")),
        "{one}"
    );
    // The middle is at 3.5, the wall at 3; something is further.
    let x: f64 = one.split("near [").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(x >= 3.5 && (beyond(one) - 2.0 * (x - 3.0)).abs() < 2e-3, "{one}");
}

/// Faces that move along are not what others pass: those that move together stay as far apart as they were.
#[test]
fn faces_that_move_together_do_not_pass_one_another() {
    let brep = block(1.0);
    let top = (0..6).max_by(|&a, &b| middle(&brep, a).1.z.total_cmp(&middle(&brep, b).1.z)).unwrap();
    let floor = (0..6).min_by(|&a, &b| middle(&brep, a).1.z.total_cmp(&middle(&brep, b).1.z)).unwrap();
    let by = Vector::new(0.0, 0.0, -5.0);
    assert_eq!(told(&brep, Matrix4::identity(), &[top], by, None).len(), 1);
    let (at, ..) = middle(&brep, floor);
    let along = json!({ "kind": "position", "at": { "face": floor, "uv": at }, "by": [0.0, 0.0, -5.0] });
    assert!(told(&brep, Matrix4::identity(), &[top, floor], by, Some(along)).is_empty());
}
