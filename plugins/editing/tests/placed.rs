//! Objects that are placed differently, edited together: as if they stood in the world with their coordinates there.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_editing::Editing;
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix4, Rotation3};
use serde_json::{Value, json};

struct Dice(u64);

impl Dice {
    fn between(&mut self, a: f64, b: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        a + (b - a) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> Vector {
        Vector::from_fn(|_, _| self.between(-size, size))
    }

    /// Turned, stretched (not alike in all directions), sheared, moved.
    fn placement(&mut self) -> Matrix4<f64> {
        let turned = Rotation3::from_scaled_axis(self.vector(2.0)).to_homogeneous();
        let stretched = Matrix4::new_nonuniform_scaling(&Vector::from_fn(|_, _| self.between(0.4, 2.5)));
        let mut sheared = Matrix4::identity();
        sheared[(0, 1)] = self.between(-0.5, 0.5);
        Matrix4::new_translation(&self.vector(5.0)) * turned * stretched * sheared
    }
}

fn moved(map: &Matrix4<f64>, p: &Point) -> Point {
    map.transform_point(p)
}

fn surface(dice: &mut Dice) -> Surface {
    let (u, v) = (Space::clamped_uniform(2, 5).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    let net = (0..30).map(|k| Point::new((k / 6) as f64, (k % 6) as f64, 0.0) + dice.vector(0.2)).collect();
    Surface::build(u, v, net, None).unwrap()
}

fn run(scene: &mut Scene, op: &str, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let operation = registry.find_operation(op, "step[0].op")?.clone();
    let parameters = Parameters::new(fields, "step[0]")?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

/// Two objects, the second under a group: their placements, and the scene.
fn placed(a: &Surface, b: &Surface, dice: &mut Dice) -> (Scene, [Matrix4<f64>; 2]) {
    let [own, group, below] = [dice.placement(), dice.placement(), dice.placement()];
    let mut scene = Scene::new();
    let mut first = Object::new("a", a.clone().into());
    first.transform = Some(own);
    scene.add(first).unwrap();
    let mut above = Object::new("group", loftsman_kernel::scene::Geometry::Group);
    above.transform = Some(group);
    scene.add(above).unwrap();
    let mut second = Object::new("b", b.clone().into());
    (second.transform, second.parent) = (Some(below), Some("group".into()));
    scene.add(second).unwrap();
    (scene, [own, group * below])
}

/// The same shapes with their coordinates in the world.
fn in_world(shapes: [(&str, &Surface); 2], maps: &[Matrix4<f64>; 2]) -> Scene {
    let mut scene = Scene::new();
    for ((name, shape), map) in shapes.into_iter().zip(maps) {
        let net = shape.points().iter().map(|p| moved(map, p)).collect();
        let there = Surface::build(shape.u().clone(), shape.v().clone(), net, None).unwrap();
        scene.add(Object::new(name, there.into())).unwrap();
    }
    scene
}

#[test]
fn a_join_across_placements_is_what_it_is_in_the_world() {
    let mut dice = Dice(11);
    for round in 0..120 {
        let (a, b) = (surface(&mut dice), surface(&mut dice));
        let (mut scene, maps) = placed(&a, &b, &mut dice);
        let mut world = in_world([("a", &a), ("b", &b)], &maps);
        let to: [f64; 3] = (moved(&maps[0], &a.point(0.4, 0.7).unwrap()) + dice.vector(0.3)).coords.into();
        let asked = json!({ "object": "a", "constraints": [
            { "kind": "join", "at": "u1", "with": { "object": "b", "at": "u0" }, "continuity": round % 2 },
            { "kind": "position", "at": [0.4, 0.7], "to": to } ] });
        let report = run(&mut scene, "edit", asked.clone()).unwrap();
        assert!(report.notes.iter().any(|n| n.contains("coordinates of the world")), "{:?}", report.notes);
        let plain = run(&mut world, "edit", asked).unwrap();
        assert!(!plain.notes.iter().any(|n| n.contains("coordinates of the world")));
        let size = 40.0;
        for ((name, map), before) in ["a", "b"].into_iter().zip(&maps).zip([&a, &b]) {
            let (own, there) = (scene.surface(name).unwrap(), world.surface(name).unwrap());
            let stood = moved_net(before, map);
            for (k, (own, there)) in own.points().iter().zip(there.points()).enumerate() {
                assert!((moved(map, own) - there).norm() < 1e-10 * size, "{round} {name} {k}");
                // What does not move there has not moved here, by one bit.
                if *there == stood[k] {
                    assert_eq!(*own, before.points()[k]);
                }
            }
        }
        // They meet in the world, point by point of the edge.
        let (one, other) = (scene.surface("a").unwrap(), scene.surface("b").unwrap());
        // Whichever way round they were the nearer.
        let gap = |turned: bool| {
            let each = (0..=10).map(|k| {
                let v = 3.0 * f64::from(k) / 10.0;
                let (p, q) =
                    (one.point(3.0, v).unwrap(), other.point(0.0, if turned { 3.0 - v } else { v }).unwrap());
                (moved(&maps[0], &p) - moved(&maps[1], &q)).norm()
            });
            each.fold(0.0, f64::max)
        };
        assert!(gap(false).min(gap(true)) < 1e-10 * size, "{} {}", gap(false), gap(true));
        assert!((moved(&maps[0], &one.point(0.4, 0.7).unwrap()) - Point::from(to)).norm() < 1e-10 * size);
    }
}

fn moved_net(shape: &Surface, map: &Matrix4<f64>) -> Vec<Point> {
    shape.points().iter().map(|p| moved(map, p)).collect()
}

#[test]
fn frames_of_a_drag_are_in_their_objects_own_coordinates() {
    let mut dice = Dice(5);
    let (a, b) = (surface(&mut dice), surface(&mut dice));
    let (mut scene, maps) = placed(&a, &b, &mut dice);
    let path: Vec<[f64; 3]> = (1..5)
        .map(|k| {
            (moved(&maps[0], &a.point(1.0, 1.0).unwrap()) + Vector::new(0.1, 0.0, 0.1) * f64::from(k))
                .coords
                .into()
        })
        .collect();
    let step = json!({ "object": "a", "handle": { "kind": "position", "at": [1.0, 1.0] }, "path": path, "frames": true,
        "constraints": [{ "kind": "join", "at": "u1", "with": { "object": "b", "at": "u0" } }] });
    let report = run(&mut scene, "drag", step).unwrap();
    // Marks are where the shapes are, in their own coordinates, too.
    for mark in &report.marks {
        let shape = scene.surface(&mark.object).unwrap();
        assert!(shape.bounds().contains_about(&mark.position), "{mark:?}");
    }
    for name in ["a", "b"] {
        let object = scene.object(name).unwrap();
        let frames = &object.animation.as_ref().unwrap().frames;
        assert_eq!(frames.len(), 5);
        // The first frame is the shape as it was, to the last bit; the last the shape as it is.
        assert_eq!(frames[0], [&a, &b][usize::from(name == "b")].points());
        assert_eq!(frames[4], scene.surface(name).unwrap().points());
    }
}

/// A box with some room.
trait About {
    fn contains_about(&self, p: &Point) -> bool;
}

impl About for (Point, Point) {
    fn contains_about(&self, p: &Point) -> bool {
        (0..3).all(|k| p[k] > self.0[k] - 1.0 && p[k] < self.1[k] + 1.0)
    }
}

#[test]
fn one_object_or_several_placed_alike_stay_in_their_own_coordinates() {
    let mut dice = Dice(3);
    let line = |dice: &mut Dice| {
        let points = (0..8).map(|k| Point::new(f64::from(k), 0.0, 0.0) + dice.vector(0.2)).collect();
        Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap()
    };
    let (one, other, map) = (line(&mut dice), line(&mut dice), dice.placement());
    let mut scene = Scene::new();
    for (name, curve) in [("a", &one), ("b", &other)] {
        let mut object = Object::new(name, curve.clone().into());
        object.transform = Some(map);
        scene.add(object).unwrap();
    }
    let step = json!({ "object": "a", "constraints": [
        { "kind": "position", "at": 2.0, "to": [2.0, 1.0, 0.0] },
        { "kind": "position", "object": "b", "at": 1.0, "keep": true } ] });
    let report = run(&mut scene, "edit", step).unwrap();
    assert!(
        report.notes.len() == 1 && report.notes[0].contains("in its own coordinates"),
        "{:?}",
        report.notes
    );
    assert!((scene.curve("a").unwrap().point(2.0).unwrap() - Point::new(2.0, 1.0, 0.0)).norm() < 1e-13);
    assert_eq!(scene.curve("b").unwrap(), &other);
    // What is flattened has no way back.
    scene.object_mut("b").unwrap().transform =
        Some(Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 0.0, 1.0)));
    let step = json!({ "object": "a", "constraints": [
        { "kind": "join", "at": 5.0, "with": { "object": "b", "at": 0.0 } }] });
    let before = scene.clone();
    let error = run(&mut scene, "edit", step).unwrap_err().to_string();
    assert!(error.contains("\"b\" is placed by a transform that flattens it"), "{error}");
    assert_eq!(scene, before);
}
