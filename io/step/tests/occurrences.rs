//! What is shown more than once: geometries held once, and the colours and names of single occurrences.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use std::collections::BTreeSet;
use std::sync::Arc;

use loftsman_kernel::mesh::{Cloud, Mesh};
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, ReadReport, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use nalgebra::Matrix4;

const RED: [f64; 4] = [1.0, 0.0, 0.0, 1.0];
const GREEN: [f64; 4] = [0.0, 1.0, 0.0, 1.0];
const BLUE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];
const YELLOW: [f64; 4] = [1.0, 1.0, 0.0, 1.0];
const CYAN: [f64; 4] = [0.0, 1.0, 1.0, 1.0];

fn read(bytes: &[u8]) -> (Scene, ReadReport) {
    let (scene, report) = Step.read(&Memory::new("t.step", bytes), &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene.check().unwrap();
    (scene, report)
}

fn write(scene: &Scene) -> (String, WriteReport) {
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    (String::from_utf8(memory.bytes).unwrap(), report)
}

fn made() -> String {
    let path = format!("{}/../../tests/data/made/occurrences.step", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

fn at(k: u32) -> Option<Matrix4<f64>> {
    Some(Matrix4::new_translation(&Vector::new(f64::from(k), 0.0, 0.0)))
}

/// A triangle, a curve, points and a tetrahedron.
fn geometries() -> Vec<Geometry> {
    let corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)];
    let points: Vec<Point> =
        corners.iter().map(|&(x, y, z)| Point::new(f64::from(x), f64::from(y), f64::from(z))).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 4).unwrap(), points.clone()).unwrap();
    let solid = Mesh::new(points.clone(), &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).unwrap();
    let brick = read(made().as_bytes()).0.definition("brick").unwrap().objects()[0].geometry().clone();
    vec![solid.into(), curve.into(), Cloud { points }.into(), brick]
}

/// Objects that share a geometry keep their names, labels, colours and layers, and one geometry for each colour and layer.
#[test]
fn what_objects_share_is_written_once() {
    for geometry in geometries() {
        let geometry = Arc::new(geometry);
        let mut scene = Scene::new();
        for k in 0..1000 {
            let mut object = Object::sharing(format!("o{k}"), Arc::clone(&geometry)).labelled("screw");
            object.transform = at(k).filter(|_| k % 5 != 0);
            object.color = [None, Some(RED), Some(BLUE)][k as usize % 3];
            object.layer = (k % 2 == 0).then(|| "even".to_owned());
            object.parent = (k % 100 == 99).then(|| "o7".to_owned());
            scene.add(object).unwrap();
        }
        let mut part = Definition::new("part");
        part.add(Object::sharing("inner", Arc::clone(&geometry))).unwrap();
        part.add(Object::new("beside", Geometry::Group)).unwrap();
        scene.define(part).unwrap();
        for k in 0..2 {
            let mut object = Object::new(format!("shown{k}"), Geometry::Instance("part".into()));
            object.transform = at(k + 1);
            scene.add(object).unwrap();
        }
        let (text, report) = write(&scene);
        // Three colours on and off a layer, and the one that others hang under.
        assert!(text.len() < 1_200_000, "{} bytes", text.len());
        assert!(report.objects.iter().all(|told| told.fate == Fate::Kept), "{report:?}");
        let (second, _) = read(text.as_bytes());
        let objects = |scene: &Scene| {
            let mut all: Vec<Object> = scene.objects().to_vec();
            all.sort_by(|a, b| a.name().cmp(b.name()));
            all
        };
        let (first, again) = (objects(&scene), objects(&second));
        assert_eq!(first.len(), again.len());
        for (a, b) in first.iter().zip(&again) {
            assert_eq!((a.name(), a.label(), a.color, &a.layer), (b.name(), b.label(), b.color, &b.layer));
            assert_eq!((a.transform, &a.parent), (b.transform, &b.parent), "{}", a.name());
            assert_eq!(a.geometry().kind(), b.geometry().kind());
        }
        let held: BTreeSet<usize> = second
            .objects()
            .iter()
            .chain(second.definition("part").unwrap().objects())
            .filter(|object| object.geometry().kind() == geometry.kind())
            .map(Object::geometry_id)
            .collect();
        assert_eq!(held.len(), 7, "{}", geometry.kind());
        assert_eq!(write(&second).0, write(&read(write(&second).0.as_bytes()).0).0);
    }
}

/// Nothing around what stands where it is, but a scene that holds the occurrences.
#[test]
fn two_of_one_geometry_in_one_place_come_back_as_two() {
    let geometry = Arc::new(geometries().remove(0));
    let mut scene = Scene::new();
    for name in ["a", "b"] {
        scene.add(Object::sharing(name, Arc::clone(&geometry))).unwrap();
    }
    let (second, _) = read(write(&scene).0.as_bytes());
    assert_eq!(second.objects().iter().map(Object::name).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(second.objects()[0].geometry_id(), second.objects()[1].geometry_id());
    assert!(second.objects().iter().all(|object| object.parent.is_none()));
}

#[test]
fn instances_have_colours_where_what_they_show_has_none() {
    for geometry in geometries() {
        let mut scene = Scene::new();
        let mut part = Definition::new("part");
        part.add(Object::new("part", geometry.clone())).unwrap();
        scene.define(part).unwrap();
        let mut pair = Definition::new("pair");
        for (k, color) in [(0, None), (1, Some(GREEN))] {
            let mut object = Object::new(format!("p{k}"), Geometry::Instance("part".into()));
            (object.transform, object.color) = (at(k + 1), color);
            pair.add(object).unwrap();
        }
        scene.define(pair).unwrap();
        for (k, of, color) in
            [(0, "part", None), (1, "part", Some(RED)), (2, "pair", None), (3, "pair", Some(BLUE))]
        {
            let mut object = Object::new(format!("i{k}"), Geometry::Instance(of.into()));
            (object.transform, object.color) = (at(10 * k + 1), color);
            scene.add(object).unwrap();
        }
        let (text, report) = write(&scene);
        assert!(report.objects.iter().all(|told| told.fate == Fate::Kept), "{report:?}");
        let (second, told) = read(text.as_bytes());
        let shown = |scene: &Scene| -> Vec<_> {
            let all = scene.placed(100).unwrap();
            let things = all.filter(|placed| placed.object.geometry().kind() == geometry.kind());
            things.map(|placed| (placed.path.to_string(), placed.color())).collect()
        };
        assert_eq!(shown(&scene), shown(&second));
        assert_eq!(shown(&scene).iter().filter(|(_, color)| *color == Some(GREEN)).count(), 2);
        // An instance of what has colours in it gives its own to the rest, which is told.
        assert!(told.notes.iter().any(|note| note.contains("no colour of its own here")), "{:?}", told.notes);
    }
}

/// As OpenCASCADE reads it but for the second pair, whose bricks keep the colours that they have in it.
#[test]
fn colours_and_names_of_single_occurrences_are_those_of_the_file() {
    let (scene, report) = read(made().as_bytes());
    let color = |name: &str| scene.object(name).unwrap().color;
    assert_eq!(["left", "right"].map(color), [Some(RED), Some(GREEN)]);
    assert_eq!(["seen", "unseen"].map(color), [Some(YELLOW), None]);
    let pin = scene.object("pin").unwrap();
    assert_eq!((pin.color, pin.statement("step occurrence")), (Some(CYAN), Some("the only pin")));
    // In a sub-assembly that is there once, and whose occurrence is red, the post is blue as it is, the cube has nothing of its own.
    assert_eq!([color("post"), color("the cube")], [Some(BLUE), Some(RED)]);
    assert_eq!(color("frame"), None);
    let inner = scene.definition("pair").unwrap();
    let inner: Vec<_> = inner.objects().iter().map(|object| (object.name(), object.color)).collect();
    assert_eq!(inner, [("one", Some(RED)), ("two", Some(BLUE))]);
    for name in ["brick", "bare"] {
        assert_eq!(scene.definition(name).unwrap().objects()[0].color, None, "{name}");
    }
    let told: Vec<_> = report.notes.iter().filter(|note| note.contains("colour")).collect();
    assert!(
        told.len() == 2 && told.iter().all(|one| one.contains("NEXT_ASSEMBLY_USAGE_OCCURRENCE")),
        "{told:?}"
    );
    // Written and read again all is the same, but for the colour that has no effect.
    let (text, report) = write(&scene);
    let changed: Vec<_> = report.objects.iter().filter(|told| told.fate != Fate::Kept).collect();
    assert!(matches!(&changed[..], [one] if one.object == "second pair"), "{changed:?}");
    let (mut first, (second, _)) = (scene.clone(), read(text.as_bytes()));
    first.object_mut("second pair").unwrap().color = None;
    assert_eq!(first.objects(), second.objects());
    assert!(text.contains("'the only pin'"));
}

/// What an instance cannot have is told by the entity: colours of a face, of some solids, or several.
#[test]
fn colours_that_no_instance_has_are_told() {
    let text = made();
    let styled = text.lines().find(|line| line.contains("OVER_RIDING_STYLED_ITEM")).unwrap();
    let item = styled.split(",#").nth(1).unwrap().to_owned();
    let face = text.lines().find(|line| line.contains("ADVANCED_FACE")).unwrap().split(' ').next().unwrap();
    let changed = text.replace(styled, &styled.replace(&format!(",#{}", &item), &format!(",{face}")));
    assert_ne!(changed, text);
    let (scene, report) = read(changed.as_bytes());
    let told = report.left_out.keys().map(String::as_str).collect::<Vec<_>>().join("\n");
    assert!(told.contains("faces have the same colours wherever"), "{told}");
    assert!(
        scene.objects().iter().all(|object| object.geometry().kind() != "group" || object.color.is_none())
    );
}
