//! What a file says beside geometry and must not be lost on the way: voids, names, frames that are turned, and what is told of objects inside definitions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use nalgebra::{Matrix4, Rotation3};

fn made(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../tests/data/made/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn read(text: &str) -> Scene {
    Step.read(&Memory::new("t.step", text.as_bytes()), &ReadOptions::default()).unwrap().0
}

fn written(scene: &Scene) -> (String, Vec<(String, Fate, Option<String>)>) {
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    let told = report.objects.into_iter().map(|one| (one.object, one.fate, one.reason)).collect();
    (String::from_utf8(memory.bytes).unwrap(), told)
}

fn brep(scene: &Scene) -> &Brep {
    match scene.objects()[0].geometry() {
        Geometry::Brep(brep) => brep,
        other => panic!("{other:?}"),
    }
}

/// Exactly one place of a text is another one.
fn with(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from}");
    text.replace(from, to)
}

/// Normals of faces point out of what is solid: around a hollow towards its middle.
fn looks_inwards(brep: &Brep, face: usize, middle: Point) -> bool {
    let surface = brep.surface(face).unwrap();
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let at = Location::Face(face as u32, a + 0.3 * (b - a), c + 0.4 * (d - c));
    let value = |by: [usize; 2]| brep.value(at, Derivative::from(by)).unwrap();
    let normal = value([1, 0]).cross(&value([0, 1])) * if brep.is_reversed(face) { -1.0 } else { 1.0 };
    normal.dot(&(middle.coords - value([0, 0]))) > 0.0
}

#[test]
fn a_hollow_stays_hollow() {
    let text = made("hollow.step");
    let first = read(&text);
    let (again, _) = written(&first);
    assert!(again.contains("BREP_WITH_VOIDS("), "{again}");
    // A flag that says that its shell is the other way round, and faces that are.
    let turned = with(&with(&text, "#346,.F.)", "#346,.T.)"), "(#348),#352,.T.)", "(#348),#352,.F.)");
    for scene in [first, read(&again), read(&turned)] {
        let brep = brep(&scene);
        let [solid] = brep.solids() else { panic!("{:?}", brep.solids()) };
        let [void] = solid.voids[..] else { panic!("{solid:?}") };
        let [ball] = brep.shells()[void].faces[..] else { panic!("{:?}", brep.shells()) };
        assert!(looks_inwards(brep, ball, Point::new(5.0, 4.0, 3.0)));
        for &face in &brep.shells()[solid.outer].faces {
            assert!(!looks_inwards(brep, face, Point::new(5.0, 4.0, 3.0)), "{face}");
        }
    }
}

#[test]
fn faces_and_solids_keep_their_names() {
    let text = with(&made("hollow.step"), "#17 = ADVANCED_FACE(''", "#17 = ADVANCED_FACE('lid'");
    let text = with(&text, "BREP_WITH_VOIDS(''", "BREP_WITH_VOIDS('cheese'");
    let first = read(&text);
    let (again, _) = written(&first);
    for scene in [first, read(&again)] {
        let brep = brep(&scene);
        let names: Vec<Option<&str>> = (0..brep.face_count()).map(|face| brep.face_name(face)).collect();
        assert_eq!(names, [Some("lid"), None, None, None, None, None, None]);
        assert_eq!(brep.solids()[0].name.as_deref(), Some("cheese"));
    }
}

/// An occurrence stands where its first frame comes to lie on the second one: with these exchanged, the other way.
#[test]
fn occurrences_stand_from_one_frame_to_the_other() {
    let turn = Rotation3::from_axis_angle(&Vector::z_axis(), 0.7)
        * Rotation3::from_axis_angle(&Vector::x_axis(), 0.4);
    let place = Matrix4::new_translation(&Vector::new(3.0, -1.0, 2.0)) * turn.to_homogeneous();
    let mut part = Definition::new("part");
    let block = Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0)).unwrap();
    part.add(Object::new("block", block.into())).unwrap();
    let mut scene = Scene::new();
    scene.define(part).unwrap();
    let mut shown = Object::new("shown", Geometry::Instance("part".to_owned()));
    shown.transform = Some(place);
    scene.add(shown).unwrap();
    let (text, _) = written(&scene);
    let stands = |text: &str| {
        let scene = read(text);
        let placed = scene.objects().iter().find_map(|object| object.transform);
        placed.unwrap()
    };
    assert!((stands(&text) - place).amax() < 1e-14);
    let start = text.find("ITEM_DEFINED_TRANSFORMATION('','',").unwrap() + 34;
    let end = start + text[start..].find(')').unwrap();
    let (from, to) = text[start..end].split_once(',').unwrap();
    let turned = format!("{}{to},{from}{}", &text[..start], &text[end..]);
    assert!((stands(&turned) - place.try_inverse().unwrap()).amax() < 1e-13);
    // Both frames the same: it stands where it is, wherever that is.
    let still = format!("{}{to},{to}{}", &text[..start], &text[end..]);
    let there = read(&still).objects().iter().find_map(|object| object.transform);
    assert!(there.is_none_or(|map| (map - Matrix4::identity()).amax() < 1e-14), "{there:?}");
}

/// What does not go out of a definition, or comes back changed, is told as it is of objects of the scene.
#[test]
fn losses_inside_definitions_are_told() {
    let block = || -> Geometry { Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0)).unwrap().into() };
    let line = Polyline { points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0)], closed: false };
    let mut stretched = Object::new("stretched", block());
    stretched.transform = Some(Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0)));
    let mut pale = Object::new("pale", line.into());
    pale.color = Some([1.0, 0.0, 0.0, 0.5]);
    let none = Object::new("none", Polyline { points: vec![Point::origin()], closed: false }.into());
    let mut part = Definition::new("part");
    for object in [Object::new("kept", block()), stretched, pale, none] {
        part.add(object).unwrap();
    }
    let mut lone = Definition::new("lone");
    lone.add(Object::new("nothing", Cloud { points: Vec::new() }.into())).unwrap();
    let mut scene = Scene::new();
    scene.define(part).unwrap();
    scene.define(lone).unwrap();
    for (name, of) in [("one", "part"), ("two", "part"), ("three", "lone")] {
        scene.add(Object::new(name, Geometry::Instance(of.to_owned()))).unwrap();
    }
    let (_, told) = written(&scene);
    let list: Vec<(&str, Fate)> = told.iter().map(|(name, fate, _)| (name.as_str(), *fate)).collect();
    assert_eq!(
        list,
        [
            ("one", Fate::Kept),
            ("two", Fate::Kept),
            ("three", Fate::LeftOut),
            ("lone/nothing", Fate::LeftOut),
            ("part/stretched", Fate::Approximated),
            ("part/pale", Fate::Approximated),
            ("part/none", Fate::LeftOut),
        ],
        "{told:?}"
    );
    assert!(told[4].2.as_ref().unwrap().contains("baked in"), "{told:?}");
    assert!(told[5].2.as_ref().unwrap().contains("transparency"), "{told:?}");
}
