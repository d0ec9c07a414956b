//! What is placed by a transform falls as it does in the scene.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix3, Matrix4};
use serde_json::json;

use crate::common::run;

fn placement(linear: &Matrix3<f64>) -> Matrix4<f64> {
    let mut all = Matrix4::identity();
    all.fixed_view_mut::<3, 3>(0, 0).copy_from(linear);
    all.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vector::new(3.0, -1.0, 2.0));
    all
}

/// Turned, mirrored, larger, smaller, and by different factors; the last with whether lengths stay alike.
fn placements() -> Vec<(Matrix3<f64>, bool)> {
    let turned = Matrix4::new_rotation(Vector::new(0.7, -1.1, 0.4)).fixed_view::<3, 3>(0, 0).into_owned();
    let quarter = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
    let mirror = Matrix3::from_diagonal(&Vector::new(-1.0, 1.0, 1.0));
    let mut all: Vec<(Matrix3<f64>, bool)> =
        vec![(Matrix3::identity(), true), (quarter, true), (mirror, true)];
    for scale in [1e-9, 1e-3, 2.0, 1e3, 1e9] {
        all.push((turned * scale, true));
        all.push((mirror * turned * scale, true));
    }
    all.push((Matrix3::from_diagonal(&Vector::new(1.0, 2.0, 0.5)) * turned, false));
    all
}

/// The rope or sheet that stands at these points in the scene, placed by such a map: alone, or half of the map on a parent.
fn scene(up: Up, unit: Unit, linear: &Matrix3<f64>, sheet: bool, parent: bool) -> Scene {
    let own = placement(linear).try_inverse().unwrap();
    let at = |p: Point| own.transform_point(&p);
    let geometry = if sheet {
        let space = Space::clamped_uniform(2, 4).unwrap();
        let points =
            (0..16).map(|k| at(Point::new(f64::from(k / 4), f64::from(k % 4), 0.1 * f64::from(k % 3))));
        Geometry::Surface(Surface::new(space.clone(), space, points.collect()).unwrap())
    } else {
        let points = (0..9).map(|k| at(Point::new(f64::from(k), 0.3 * f64::from(k % 2), 0.0)));
        Geometry::Curve(Curve::new(Space::clamped_uniform(3, 9).unwrap(), points.collect()).unwrap())
    };
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (unit, up);
    let mut object = Object::new("body", geometry);
    object.transform = Some(placement(linear));
    if parent {
        let mut above = Matrix4::new_rotation(Vector::new(0.2, 0.5, -0.3)) * 4.0;
        above[(3, 3)] = 1.0;
        let mut group = Object::new("group", Geometry::Group);
        group.transform = Some(above);
        scene.add(group).unwrap();
        object.transform = Some(above.try_inverse().unwrap() * placement(linear));
        object.parent = Some("group".into());
    }
    scene.add(object).unwrap();
    scene
}

fn standing(scene: &Scene) -> Vec<Point> {
    let map =
        scene.world_transforms().unwrap()[scene.position("body").unwrap()].unwrap_or_else(Matrix4::identity);
    scene.object("body").unwrap().geometry().points().iter().map(|p| map.transform_point(p)).collect()
}

/// Nothing holds it and the air is away: every vertex goes by `½ g t²` down in the scene, however it is placed, which axis is up and whatever the unit.
#[test]
fn what_falls_freely_falls_down_in_the_scene() {
    for (linear, _) in placements() {
        for (up, down) in [(Up::X, -Vector::x()), (Up::Y, -Vector::y()), (Up::Z, -Vector::z())] {
            for (unit, metre) in [(Unit::Metre, 1.0), (Unit::Millimetre, 1e3), (Unit::Inch, 1.0 / 0.0254)] {
                for (sheet, parent) in [(false, false), (true, true)] {
                    let mut scene = scene(up, unit, &linear, sheet, parent);
                    let before = standing(&scene);
                    // As long as it takes to fall as far in any unit.
                    let root = f64::sqrt(metre);
                    let fields =
                        json!({ "seconds": 0.1 / root, "frames_per_second": 10.0 * root, "damping": 0 });
                    let report = run(&mut scene, fields).unwrap();
                    let fallen = down * (0.5 * 9.81 * 0.01);
                    for (now, was) in standing(&scene).iter().zip(&before) {
                        let off = (now - was - fallen).norm();
                        assert!(off < 1e-8, "{linear} {up:?} {unit:?}: {} for {fallen}", now - was);
                    }
                    let told = report.notes.iter().any(|note| note.contains("gravity is the scene's"));
                    assert!(parent || told == (linear != Matrix3::identity()), "{:?}", report.notes);
                }
            }
        }
    }
}

/// Hung up with all that is not said, it swings as it does where nothing places it: lengths alike, stiffness goes with weight.
#[test]
fn what_hangs_swings_alike() {
    let fields = || json!({ "seconds": 0.4, "constraints": [{ "kind": "fixed", "at": 0 }] });
    let mut first = scene(Up::Z, Unit::Metre, &Matrix3::identity(), false, false);
    run(&mut first, fields()).unwrap();
    let wanted = standing(&first);
    for (linear, alike) in placements() {
        for parent in [false, true] {
            let mut scene = scene(Up::Z, Unit::Metre, &linear, false, parent);
            let report = run(&mut scene, fields()).unwrap();
            let off = standing(&scene).iter().zip(&wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(!alike || off < 1e-6, "{linear}: {off}");
            let told =
                report.notes.iter().any(|note| note.contains("stretches some directions more than others"));
            assert_eq!(told, !alike, "{:?}", report.notes);
        }
    }
}

/// What is given is in the object's own coordinates; what is flat in the scene has no way down there.
#[test]
fn gravity_that_is_given_stays_in_own_coordinates() {
    let turned = Matrix4::new_rotation(Vector::new(0.7, -1.1, 0.4)).fixed_view::<3, 3>(0, 0).into_owned();
    let mut placed = scene(Up::Z, Unit::Metre, &turned, false, false);
    let before = standing(&placed);
    let given = Vector::new(1.0, -2.0, 0.5);
    let fields = json!({ "seconds": 0.5, "damping": 0, "gravity": [1.0, -2.0, 0.5] });
    let notes = run(&mut placed, fields).unwrap().notes;
    assert!(!notes.iter().any(|note| note.contains("gravity is the scene's")), "{notes:?}");
    for (now, was) in standing(&placed).iter().zip(&before) {
        assert!((now - was - turned * given * 0.125).norm() < 1e-9, "{}", now - was);
    }
    let flat = |scene: &mut Scene| {
        let mut flat = Matrix4::identity();
        flat[(2, 2)] = 0.0;
        scene.object_mut("body").unwrap().transform = Some(flat);
    };
    let mut scene = scene(Up::Z, Unit::Metre, &Matrix3::identity(), false, false);
    flat(&mut scene);
    let error = run(&mut scene.clone(), json!({ "seconds": 0.5 })).unwrap_err().to_string();
    assert!(error.contains("gravity") && error.contains("flattens it"), "{error}");
    run(&mut scene, json!({ "seconds": 0.5, "gravity": [0, 0, -9.81] })).unwrap();
}
