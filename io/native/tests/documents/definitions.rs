//! Definitions, instances, and geometry that objects share.

use std::sync::Arc;

use super::common::{everything, read, write};
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

fn document(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
}

fn cloud(x: f64) -> Geometry {
    Cloud { points: vec![Point::new(x, 1.0 / 3.0, -0.0); 100] }.into()
}

/// A definition in another, objects that share what one of them has, and instances.
fn assembly() -> Scene {
    let mut scene = everything();
    let mut bolt = Definition::new("bolt");
    bolt.statements.push(("step".into(), "#17".into()));
    let mut head = Object::new("head", cloud(0.1));
    head.materials = vec!["wood".into()];
    bolt.add(head).unwrap();
    bolt.add(bolt.object("head").unwrap().renamed("thread")).unwrap();
    let mut plate = Definition::new("plate");
    for k in 0..3 {
        let mut instance = Object::new(format!("bolt {k}"), Geometry::Instance("bolt".into()));
        instance.transform = Some(Matrix4::new_translation(&Vector::new(0.1, f64::from(k), 0.0)));
        instance.parent = (k > 0).then(|| "bolt 0".into());
        plate.add(instance).unwrap();
    }
    plate.add(bolt.object("head").unwrap().renamed("spare")).unwrap();
    let spare = bolt.object("head").unwrap().renamed("spare");
    // What shows comes before what is shown.
    scene.define(plate).unwrap();
    scene.define(bolt).unwrap();
    scene.add(spare).unwrap();
    scene.add(scene.object("scan").unwrap().renamed("scan again")).unwrap();
    scene.add(Object::new("plate", Geometry::Instance("plate".into()))).unwrap();
    scene
}

#[test]
fn definitions_and_what_is_shared_come_back_and_do_not_grow() {
    let scene = assembly();
    let bytes = write(&scene);
    let (back, report) = read(bytes.clone()).unwrap();
    assert_eq!(back, scene);
    assert_eq!(write(&back), bytes);
    assert!(report.adds_up() && report.entities == scene.objects().len() + 4 + 2);
    let geometry = |of: &str, name: &str| match of {
        "" => Arc::clone(back.object(name).unwrap().shared_geometry()),
        of => Arc::clone(back.definition(of).unwrap().object(name).unwrap().shared_geometry()),
    };
    for (of, name) in [("bolt", "thread"), ("plate", "spare"), ("", "spare")] {
        assert!(Arc::ptr_eq(&geometry("bolt", "head"), &geometry(of, name)), "{of} {name}");
    }
    // However small it is.
    assert!(Arc::ptr_eq(&geometry("", "scan"), &geometry("", "scan again")));
    let text = String::from_utf8(bytes).unwrap();
    // The plate's spare stands first, a hundred points once.
    assert_eq!(text.matches("[0.1, 0.3333333333333333, -0.0]").count(), 100);
    assert!(text.contains(r#""definition": "plate""#) && text.contains(r#""object": "scan""#), "{text}");
    let placed: Vec<_> =
        back.placed(100).unwrap().map(|p| format!("{}/{}", p.path, p.object.name())).collect();
    assert!(placed.contains(&"plate/bolt 2/thread".to_owned()), "{placed:?}");
}

#[test]
fn people_write_it_in_any_order() {
    let text = r#"{ "loftsman": 1,
      "objects": [ { "name": "a", "cloud": { "points": [[1, 2, 3]] } },
                   { "name": "b", "same_as": { "object": "a" } },
                   { "name": "c", "instance": { "definition": "d" } } ],
      "definitions": [ { "objects": [ { "name": "a", "polyline": { "points": [[0, 0, 0], [1, 0, 0]] } },
                                      { "name": "b", "same_as": { "object": "a" } } ], "name": "d" } ] }"#;
    let (scene, _) = read(text).unwrap();
    let of = |o: &Object| o.geometry().points().len();
    assert_eq!(scene.objects().iter().map(of).collect::<Vec<_>>(), [1, 1, 0]);
    assert_eq!(scene.definition("d").unwrap().objects().iter().map(of).collect::<Vec<_>>(), [2, 2]);
    assert_eq!(scene.placed(10).unwrap().count(), 5);
}

#[test]
fn what_is_not_there_is_named() {
    let with = |objects: &str, definitions: &str| {
        document(&format!(r#"{{ "loftsman": 1, "definitions": [{definitions}], "objects": [{objects}] }}"#))
    };
    let bolt = r#"{ "name": "bolt", "objects": [ { "name": "head", "cloud": { "points": [] } } ] }"#;
    says(
        &with(r#"{ "name": "a", "instance": { "definition": "bold" } }"#, bolt),
        &["objects[0].instance", "object \"a\"", "\"bold\"", "did you mean \"bolt\"?"],
    );
    says(
        &with(r#"{ "name": "a", "same_as": { "object": "b" } }, { "name": "b", "group": {} }"#, ""),
        &["objects[0].same_as", "no object \"b\" before this"],
    );
    says(
        &with(r#"{ "name": "a", "same_as": { "object": "hed", "definition": "bolt" } }"#, bolt),
        &["objects[0].same_as", "did you mean \"head\"?"],
    );
    says(
        &with(r#"{ "name": "a", "same_as": { "object": "head", "definition": "nut" } }"#, bolt),
        &["objects[0].same_as", "no definition \"nut\" before this"],
    );
    says(&with(r#"{ "name": "a", "same_as": {} }"#, ""), &["needs the field \"object\""]);
    says(&with(r#"{ "name": "a", "instance": {} }"#, ""), &["needs the field \"definition\""]);
    says(&with("", r#"{ "name": "d" }"#), &["definitions[0]", "needs the field \"objects\""]);
    says(&with("", &format!("{bolt}, {bolt}")), &["definitions[1]", "two definitions are named \"bolt\""]);
    let shows = |name: &str, of: &str| {
        format!(
            r#"{{ "name": "{name}", "objects": [ {{ "name": "i", "instance": {{ "definition": "{of}" }} }} ] }}"#
        )
    };
    says(
        &with("", &[shows("a", "b"), shows("b", "c"), shows("c", "a")].join(",")),
        &["definitions", "\"a\" → \"b\" → \"c\" → \"a\""],
    );
    says(&with("", &shows("a", "z")), &["in the definition \"a\"", "\"z\", which does not exist"]);
    says(
        &with("", r#"{ "name": "d", "objects": [ { "name": "x", "materials": ["no"], "group": {} } ] }"#),
        &["definitions[0].objects[0].materials[0]", "\"no\""],
    );
    says(&with(r#"{ "name": "a", "same_as": { "object": "b" }, "group": {} }"#, ""), &["no object \"b\""]);
}
