//! What is written is read again: the same to the last bit, or told to be another.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;

use loftsman_kernel::brep::{Brep, SurfaceForm};
use loftsman_kernel::conformance::{format_conformance, sample_assembly, sample_scene};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use nalgebra::Matrix4;

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/step/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn read(bytes: &[u8]) -> Scene {
    let (scene, report) = Step.read(&Memory::new("t.step", bytes), &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene.check().unwrap();
    scene
}

fn write(scene: &Scene) -> (Vec<u8>, WriteReport) {
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    (memory.bytes, report)
}

#[test]
fn it_is_a_format() {
    for scene in [sample_scene(), sample_assembly()] {
        let verdict = format_conformance(&Step, &scene);
        assert!(verdict.passed(), "{verdict}");
    }
}

/// The Breps of a scene and its definitions, by the names of these and of the objects.
fn breps(scene: &Scene) -> BTreeMap<(&str, &str), &Brep> {
    let defined = scene.definitions().iter().flat_map(|d| d.objects().iter().map(|o| (d.name(), o)));
    let all = scene.objects().iter().map(|o| ("", o)).chain(defined);
    all.filter_map(|(list, o)| match o.geometry() {
        Geometry::Brep(brep) => Some(((list, o.name()), brep)),
        _ => None,
    })
    .collect()
}

#[test]
fn files_of_others_are_written_and_read_to_the_last_bit() {
    let mut count = 0;
    for name in [
        "NIST_MBE_PMI_11.stp",
        "MAINBODY_FRONT.stp",
        "as1-oc-214.stp",
        "dm1-id-214.stp",
        "io1-cm-214.stp",
        "base_interface_AP214.STEP",
        "featuretype.STEP",
        "nacelle.stp",
        "test_pipe.step",
        "red_cube_blue_cylinder.step",
        "revolved_sphere.step",
        "tet.step",
        "sliced_cylinder.step",
        "face.stp",
    ] {
        let first = read(&data(name));
        let (bytes, report) = write(&first);
        assert!(report.objects.iter().all(|o| o.fate != Fate::LeftOut), "{name}: {report:?}");
        let second = read(&bytes);
        assert_eq!(first.unit, second.unit, "{name}");
        let (before, after) = (breps(&first), breps(&second));
        assert!(before.keys().eq(after.keys()), "{name}");
        for ((name, before), after) in before.iter().zip(after.values()) {
            let name = format!("{name:?}");
            assert_eq!(before.face_count(), after.face_count(), "{name}");
            assert_eq!(before.edge_count(), after.edge_count(), "{name}");
            assert_eq!(before.solids(), after.solids(), "{name}");
            // Where edges are further off their faces than the file said, what is written says so.
            let gap = before.gap().unwrap();
            let said: Vec<f64> = before.tolerances().iter().map(|tolerance| tolerance.max(gap)).collect();
            assert_eq!(said, after.tolerances(), "{name}");
            for face in 0..before.face_count() {
                // In the order of their shells, which is that of the file.
                assert_eq!(before.surface_form(face), after.surface_form(face), "{name}");
                assert_eq!(before.is_reversed(face), after.is_reversed(face), "{name} face {face}");
                assert_eq!(before.face_color(face).is_some(), after.face_color(face).is_some(), "{name}");
                if before.surface_form(face) == SurfaceForm::Spline {
                    assert_eq!(before.surface(face), after.surface(face), "{name}");
                }
            }
            let size = before.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
            assert!(after.flaws(1e-4 * size).unwrap().is_empty(), "{name}");
        }
        // From there on nothing changes.
        let (again, _) = write(&second);
        assert!(read(&again) == second, "{name}");
        count += 1;
    }
    assert!(count >= 14);
}

#[test]
fn splines_of_every_family_read_back_to_the_last_bit() {
    let mut scene = Scene::new();
    scene.unit = Unit::Inch;
    let point = |k: usize| {
        let t = k as f64;
        Point::new(t / 3.0, (1.7 * t).sin() * 1e3, (t * 0.3).cos() * 1e-9)
    };
    for degree in [1, 2, 3, 5, 7, 25] {
        let knots: Vec<f64> = (0..4).map(|k| (f64::from(k) / 7.0).exp()).collect();
        let mut spaces = vec![("clamped", Space::clamped(degree, &knots).unwrap())];
        spaces.push(("floating", Space::floating_uniform(degree, degree + 3).unwrap()));
        spaces.push(("periodic", Space::periodic_uniform(degree, degree + 4).unwrap()));
        let mut repeated = vec![0.0; degree + 1];
        repeated.extend(vec![0.1; degree]);
        repeated.extend(vec![1.0; degree + 1]);
        spaces.push(("repeated", Space::open(degree, repeated).unwrap()));
        for (kind, space) in spaces {
            let points: Vec<Point> = (0..space.len()).map(point).collect();
            let weights: Vec<f64> = (0..space.len()).map(|k| 1.0 + 0.1 * (k % 3) as f64).collect();
            let plain = Curve::new(space.clone(), points.clone()).unwrap();
            let rational = Curve::rational(space, points, weights).unwrap();
            scene.add(Object::new(format!("{kind} {degree}"), plain.into())).unwrap();
            scene.add(Object::new(format!("rational {kind} {degree}"), rational.into())).unwrap();
        }
    }
    let v = Space::clamped(2, &[0.0, 0.3, 1.0]).unwrap();
    let u = Space::clamped(3, &[0.0, 1.0]).unwrap();
    let net: Vec<Point> = (0..u.len() * v.len()).map(point).collect();
    scene.add(Object::new("patch", Surface::new(u, v, net).unwrap().into())).unwrap();
    let torus = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&torus, Point::origin(), Vector::z(), 6.0).unwrap();
    scene.add(Object::new("rational patch", torus.into())).unwrap();
    let (bytes, report) = write(&scene);
    let second = read(&bytes);
    assert_eq!(second.unit, Unit::Inch);
    for (object, told) in scene.objects().iter().zip(&report.objects) {
        let found = second.object(object.name()).unwrap();
        let clamped = !object.name().contains("floating") && !object.name().contains("periodic");
        assert_eq!(told.fate == Fate::Kept, clamped, "{told:?}");
        if clamped {
            assert_eq!(found.geometry(), object.geometry(), "{}", object.name());
        } else {
            let (Geometry::Curve(a), Geometry::Curve(b)) = (object.geometry(), found.geometry()) else {
                panic!()
            };
            let (start, end) = a.domain();
            assert_eq!(b.domain(), (start, end));
            for k in 0..=20 {
                let t = start + (end - start) * f64::from(k) / 20.0;
                let size = 1e3;
                assert!(
                    (a.point(t).unwrap() - b.point(t).unwrap()).norm() < 1e-11 * size,
                    "{}",
                    object.name()
                );
            }
        }
    }
}

#[test]
fn places_names_layers_and_labels_come_back() {
    let mut scene = Scene::new();
    scene.unit = Unit::of_metres(0.3).unwrap();
    let line = |name: &str| {
        let points = vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0)];
        Object::new(name, Polyline { points, closed: true }.into())
    };
    let place = |x: f64| Some(Matrix4::new_translation(&Vector::new(x, 0.0, 0.0)));
    let mut bolt = Definition::new("bolt");
    bolt.add(line("shaft")).unwrap();
    bolt.add(Object::new("head", Cloud { points: vec![Point::origin()] }.into())).unwrap();
    let mut pair = Definition::new("pair");
    for (name, x) in [("left", -1.0), ("right", 1.0)] {
        let mut object = Object::new(name, Geometry::Instance("bolt".into())).labelled("bolt é");
        object.transform = place(x);
        pair.add(object).unwrap();
    }
    scene.define(bolt).unwrap();
    scene.define(pair).unwrap();
    scene.add(Object::new("group", Geometry::Group)).unwrap();
    for (name, x) in [("one", 5.0), ("two", 7.0)] {
        let mut object = Object::new(name, Geometry::Instance("pair".into()));
        object.transform = place(x);
        object.parent = Some("group".into());
        scene.add(object).unwrap();
    }
    let mut stretched = line("stretched");
    stretched.transform = Some(Matrix4::new_nonuniform_scaling(&Vector::new(2.0, 3.0, 1.0)));
    scene.add(stretched).unwrap();
    let mut turned = line("it's 'turned'").labelled("turned");
    turned.transform = Some(Matrix4::new_rotation(Vector::new(0.3, 0.2, 0.1)));
    turned.layer = Some("hidden é".into());
    turned.color = Some([0.2, 0.4, 0.6, 1.0]);
    scene.add(turned).unwrap();
    let mut seen = line("seen");
    seen.layer = Some("below".into());
    scene.add(seen).unwrap();
    scene.layers.add(Layer::new("hidden é").hidden().colored([1.0, 0.5, 0.25, 1.0])).unwrap();
    scene.layers.add(Layer::new("below").below("hidden é")).unwrap();
    let (bytes, report) = write(&scene);
    let second = read(&bytes);
    let names = |scene: &Scene| {
        let mut all: Vec<_> = scene
            .objects()
            .iter()
            .map(|o| {
                (
                    o.name().to_owned(),
                    o.label().to_owned(),
                    o.parent.clone(),
                    o.layer.clone(),
                    o.geometry().kind().to_owned(),
                )
            })
            .collect();
        all.sort();
        all
    };
    assert_eq!(names(&scene), names(&second));
    assert_eq!(scene.unit, second.unit);
    let told = report.objects.iter().find(|o| o.object == "stretched").unwrap();
    assert!(told.fate == Fate::Approximated && told.reason.as_deref().unwrap().contains("baked"), "{told:?}");
    assert_eq!(second.object("stretched").unwrap().geometry().points()[2], Point::new(2.0, 3.0, 0.0));
    for name in ["one", "two", "it's 'turned'"] {
        let map = |scene: &Scene| scene.object(name).unwrap().transform.unwrap();
        assert!((map(&scene) - map(&second)).amax() < 1e-15, "{name}");
    }
    assert_eq!(second.layers.get("hidden é"), scene.layers.get("hidden é"));
    assert_eq!(second.layers.get("below"), scene.layers.get("below"));
    assert_eq!(scene.placed_count().unwrap(), second.placed_count().unwrap());
    assert_eq!(read(&write(&second).0), second);
}

#[test]
fn a_thousand_occurrences_hold_one_geometry() {
    let mut scene = Scene::new();
    let mut part = Definition::new("part");
    let points = (0..1000).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
    part.add(Object::new("part", Cloud { points }.into())).unwrap();
    scene.define(part).unwrap();
    for k in 0..1000 {
        let mut object = Object::new(format!("{k}"), Geometry::Instance("part".into()));
        object.transform = Some(Matrix4::new_translation(&Vector::new(f64::from(k), 0.0, 0.0)));
        scene.add(object).unwrap();
    }
    let (bytes, _) = write(&scene);
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert_eq!(text.matches("CARTESIAN_POINT").count(), 1000 + 1000 + 1);
    let second = read(&bytes);
    assert_eq!(second.objects().len(), 1000);
    assert_eq!(second.definitions().iter().map(|d| d.objects().len()).sum::<usize>(), 1);
}

/// An edge that is too short for its square to be a number.
#[test]
fn edges_of_almost_no_length_are_read_again() {
    let text = String::from_utf8(data("face.stp")).unwrap();
    let short = text.replacen("(1.E+03,1.E+03,0.)", "(1.E+03,1.E-300,0.)", 2);
    assert_ne!(text, short);
    let scene = read(short.as_bytes());
    let again = read(&write(&scene).0);
    assert_eq!(breps(&again).values().map(|brep| brep.edge_count()).sum::<usize>(), 4);
}

#[test]
fn what_hangs_too_deep_is_refused() {
    let mut scene = Scene::new();
    for k in 0..5000 {
        let mut object = Object::new(format!("{k}"), Geometry::Group);
        object.parent = (k > 0).then(|| format!("{}", k - 1));
        scene.add(object).unwrap();
    }
    let mut memory = Memory::new("t.step", Vec::new());
    let error = Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap_err();
    assert!(error.to_string().contains("200 deep"), "{error}");
}
