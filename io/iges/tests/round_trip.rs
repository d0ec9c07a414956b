//! What is written is read again: the same to the last bit, or told to be another.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;

use loftsman_iges::Iges;
use loftsman_kernel::brep::{Brep, Face, Frame, Parts, Shell, Solid, SurfaceForm};
use loftsman_kernel::conformance::{format_conformance, sample_assembly, sample_scene};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/iges/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn read(bytes: &[u8]) -> Scene {
    let (scene, report) = Iges.read(&Memory::new("t.igs", bytes), &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene.check().unwrap();
    scene
}

fn write(scene: &Scene) -> (Vec<u8>, WriteReport) {
    let mut memory = Memory::new("t.igs", Vec::new());
    let report = Iges.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    (memory.bytes, report)
}

#[test]
fn it_is_a_format() {
    for scene in [sample_scene(), sample_assembly()] {
        let verdict = format_conformance(&Iges, &scene);
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
        "D150WithGuides_wing.igs",
        "as1_pe_203.igs",
        "input.igs",
        "sample_curves.igs",
        "test_pipe.iges",
        "test_pipe.igs",
        "test_pipe_hollow.iges",
        "test_pipe_hollow_out_true.iges",
        "test_pipe_out_true.iges",
        "test_pipe_out_true.igs",
    ] {
        let first = read(&data(name));
        let (bytes, report) = write(&first);
        assert!(report.objects.iter().all(|o| o.fate != Fate::LeftOut), "{name}: {report:?}");
        let second = read(&bytes);
        assert_eq!(first.unit, second.unit, "{name}");
        let (before, after) = (breps(&first), breps(&second));
        assert!(before.keys().eq(after.keys()), "{name}");
        for ((at, before), after) in before.iter().zip(after.values()) {
            let name = format!("{name} {at:?}");
            assert_eq!(before.face_count(), after.face_count(), "{name}");
            assert_eq!(before.edge_count(), after.edge_count(), "{name}");
            for face in 0..before.face_count() {
                assert_eq!(before.is_reversed(face), after.is_reversed(face), "{name} face {face}");
                if before.surface_form(face) == SurfaceForm::Spline {
                    assert_eq!(before.surface(face), after.surface(face), "{name}");
                }
            }
        }
        for object in first.objects() {
            let found = second.object(object.name()).unwrap();
            let name = format!("{name} {}", object.name());
            match (object.geometry(), found.geometry()) {
                (Geometry::Brep(_), Geometry::Brep(_)) => {}
                (before, after) => assert!(before == after, "{name}"),
            }
            assert_eq!((&object.parent, &object.layer), (&found.parent, &found.layer), "{name}");
        }
        // From there on nothing changes.
        let (again, _) = write(&second);
        assert!(read(&again) == second, "{name}");
        count += 1;
    }
    assert!(count >= 10);
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
fn places_names_and_layers_come_back() {
    let mut scene = Scene::new();
    scene.unit = Unit::Centimetre;
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
            .map(|o| (o.name().to_owned(), o.parent.clone(), o.layer.clone(), o.geometry().kind().to_owned()))
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
    // Layers have names here and are hidden or not: what lies below a hidden one is hidden itself.
    for name in ["hidden é", "below"] {
        assert_eq!(second.layers.get(name), Some(&Layer::new(name).hidden()));
    }
    assert!(report.notes.iter().any(|note| note.starts_with("2 layers lose")), "{:?}", report.notes);
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
    assert_eq!(text.lines().filter(|line| line.starts_with("116,")).count(), 1000);
    assert_eq!(text.lines().filter(|line| line.starts_with("308,")).count(), 1);
    let second = read(&bytes);
    assert_eq!(second.objects().len(), 1000);
    assert_eq!(second.definitions().iter().map(|d| d.objects().len()).sum::<usize>(), 1);
}

#[test]
fn what_hangs_too_deep_is_refused() {
    let mut scene = Scene::new();
    for k in 0..5000 {
        let mut object = Object::new(format!("{k}"), Geometry::Group);
        object.parent = (k > 0).then(|| format!("{}", k - 1));
        scene.add(object).unwrap();
    }
    let mut memory = Memory::new("t.igs", Vec::new());
    let error = Iges.write(&scene, &mut memory, &WriteOptions::default()).unwrap_err();
    assert!(error.to_string().contains("60 deep"), "{error}");
}

/// OpenCASCADE shows a group that is all of a subfigure a second time, where it is not placed.
#[test]
fn members_of_placed_groups_are_in_the_subfigure_itself() {
    let line = |x: f64| Curve::line(Point::new(x, 0.0, 0.0), Point::new(x, 1.0, 0.0)).unwrap();
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.layers.add(Layer::new("7")).unwrap();
    let shift = Matrix4::new_translation(&Vector::new(5.0, 0.0, 0.0));
    let mut group = Object::new("group", Geometry::Group);
    (group.transform, group.color, group.layer) = (Some(shift), Some([1.0, 0.0, 0.0, 1.0]), Some("7".into()));
    let mut head = Object::new("head", line(9.0).into());
    head.transform = Some(shift);
    let mut lone = Object::new("lone", Geometry::Group);
    lone.transform = Some(shift);
    let under = |name: &str, x: f64, parent: &str, map: Option<Matrix4<f64>>| {
        let mut object = Object::new(name, line(x).into());
        (object.parent, object.transform) = (Some(parent.to_owned()), map);
        object
    };
    for object in [
        group,
        under("a", 0.0, "group", None),
        under("b", 1.0, "group", Some(shift)),
        head,
        under("c", 2.0, "head", None),
        under("d", 3.0, "head", Some(shift)),
        lone,
        under("e", 4.0, "lone", None),
    ] {
        scene.add(object).unwrap();
    }
    let (bytes, _) = write(&scene);
    let text = String::from_utf8(bytes.clone()).unwrap();
    let starts = |what: &str| text.lines().filter(|line| line.starts_with(what)).count();
    assert_eq!((starts("308,0,,2,"), starts("308,0,,3,"), starts("402,1,")), (1, 1, 1), "{text}");
    let second = read(&bytes);
    for object in scene.objects() {
        let found = second.object(object.name()).unwrap();
        assert_eq!((&object.parent, object.transform), (&found.parent, found.transform), "{}", object.name());
        assert!(object.geometry() == found.geometry(), "{}", object.name());
        assert_eq!((object.color, &object.layer), (found.color, &found.layer), "{}", object.name());
    }
}

/// The global section wants a positive real.
#[test]
fn files_without_tolerances_have_a_resolution() {
    for size in [1e-9, 1.0, 1e9] {
        let mut scene = Scene::new();
        let line = Curve::line(Point::origin(), Point::new(size, 0.0, 0.0)).unwrap();
        scene.add(Object::new("line", line.into())).unwrap();
        let (bytes, _) = write(&scene);
        let text = String::from_utf8(bytes).unwrap();
        let global: String =
            text.lines().filter(|line| &line[72..73] == "G").map(|line| line[..72].trim_end()).collect();
        let fields: Vec<&str> = global.split(',').collect();
        // The delimiters hold a comma, the date stands before.
        let at = fields.iter().position(|field| field.starts_with("15H")).unwrap();
        let found: f64 = fields[at + 1].replace('D', "e").parse().unwrap();
        assert!((found / size - 1e-7).abs() < 1e-12, "{size}: {found}");
    }
}

/// Lists of vertices and edges have at least one.
#[test]
fn spheres_have_no_lists_of_edges() {
    let (scene, _) = crate::common::read(&crate::common::file(&[
        crate::common::entity(0, "116,0.,0.,0.;"),
        crate::common::entity(0, "196,1,2.;"),
        crate::common::entity(1, "510,3,0,0;"),
        crate::common::entity(1, "514,1,5,1;"),
        crate::common::entity(0, "186,7,1,0;"),
    ]))
    .unwrap();
    let (bytes, report) = write(&scene);
    assert!(report.objects.iter().all(|object| object.fate != Fate::LeftOut), "{report:?}");
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains("\n186,"), "{text}");
    assert!(!text.contains("\n504,") && !text.contains("\n502,"), "{text}");
    let second = read(&bytes);
    assert!(breps(&second).values().all(|brep| brep.face_count() == 1 && brep.edge_count() == 0));
}

/// A face that is all of a closed spline surface has no edges here; in the file it has those along which the surface closes, and its poles.
#[test]
fn faces_without_edges_get_the_seams_of_their_splines() {
    let frame = Frame::new(Point::new(1.0, 2.0, 3.0), Vector::z(), Vector::x()).unwrap();
    for (form, edges, vertices) in [
        (SurfaceForm::Sphere { frame, radius: 2.0 }, 1, 2),
        (SurfaceForm::Torus { frame, major: 3.0, minor: 1.0 }, 2, 1),
    ] {
        let surface = form.covering(&[]).unwrap();
        let face = Face {
            name: None,
            color: None,
            surface: surface.clone(),
            form: SurfaceForm::Spline,
            reversed: false,
            loops: Vec::new(),
            points: Vec::new(),
        };
        let brep = Brep::new(Parts {
            vertices: Vec::new(),
            edges: Vec::new(),
            faces: vec![face],
            shells: vec![Shell { faces: vec![0] }],
            solids: vec![Solid { name: None, outer: 0, voids: Vec::new() }],
        })
        .unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("closed", brep.into())).unwrap();
        let (bytes, _) = write(&scene);
        let second = read(&bytes);
        let found = breps(&second).into_values().next().unwrap();
        assert_eq!((found.edge_count(), found.vertices().len(), found.solids().len()), (edges, vertices, 1));
        assert!(found.is_closed(&[0]) && found.flaws(1e-9).unwrap().is_empty());
        assert_eq!(found.surface(0).unwrap().points(), surface.clamped().unwrap().points());
    }
}
