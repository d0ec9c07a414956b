//! Whatever the bytes: a scene or one error that says where and what, never a panic.

use super::common::{everything, read, write};
use loftsman_kernel::mesh::{Cloud, Layer, Mesh};
use loftsman_kernel::plugin::{Confidence, Format, Memory, WriteOptions};
use loftsman_kernel::scene::{Object, Scene, Unit};
use loftsman_kernel::{Point, Vector};
use loftsman_native::Native;
use proptest::prelude::*;

/// The message for one object `a` with these fields.
fn refused(fields: &str) -> String {
    document(&format!(r#"{{ "loftsman": 1, "objects": [ {{ "name": "a", {fields} }} ] }}"#))
}

fn document(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
    assert!(message.chars().count() < 400, "too long: {message}");
}

#[test]
fn wrong_fields_name_the_nearest_right_one() {
    says(&refused(r#""curv": {}"#), &["objects[0]", "object \"a\"", "\"curv\"", "did you mean \"curve\"?"]);
    says(
        &refused(r#""curve": { "degre": 3 }"#),
        &["objects[0].curve", "a curve has no field \"degre\"; did you mean \"degree\"?", "line 1"],
    );
    says(&refused(r#""group": { "x": 1 }"#), &["objects[0].group", "it takes none"]);
    says(&document(r#"{ "loftsman": 1, "unit": "metre", "objects": [] }"#), &["unit", "metre", "\"m\""]);
    says(&document(r#"{ "loftsman": 1, "up": "w", "objects": [] }"#), &["up: ", "\"w\"", "x, y, z"]);
    says(&document(r#"{ "loftsman": 1, "objects": [], "objects": [] }"#), &["there twice"]);
    says(&document(r#"{ "objects": [] }"#), &["needs the field \"loftsman\""]);
    says(&document(r#"{ "loftsman": 1 }"#), &["needs the field \"objects\""]);
    says(&document(r#"{ "loftsman": 2, "objects": [] }"#), &["loftsman", "version 2", "newer program"]);
    says(&document(r#"{ "loftsman": 1, "objects": [] } x"#), &["line 1", "trailing characters"]);
    says(&document("[1, 2]"), &["line 1", "expected a document"]);
}

#[test]
fn layers_that_cannot_be_name_the_entry() {
    let layers = |list: &str| document(&format!(r#"{{ "loftsman": 1, "layers": {list}, "objects": [] }}"#));
    says(&layers(r#"[{ "color": [1, 0, 0, 1] }]"#), &["layers[0]", "a layer needs the field \"name\""]);
    says(&layers(r#"[{ "name": "a" }, { "name": "a" }]"#), &["layers[1].name", "two layers are named \"a\""]);
    says(&layers(r#"[{ "name": "" }]"#), &["layers[0].name", "empty name"]);
    says(&layers(r#"[{ "name": "a", "colour": 1 }]"#), &["layers[0]", "did you mean \"color\"?"]);
    says(&layers(r#"[{ "name": "a", "visible": 1 }]"#), &["layers[0].visible"]);
    says(&layers(r#"[{ "name": "a", "color": [1, 0] }]"#), &["layers[0].color"]);
    says(
        &layers(r#"[{ "name": "walls" }, { "name": "a", "parent": "wals" }]"#),
        &["layers[1].parent", "no layer \"wals\" to lie below; did you mean \"walls\"?"],
    );
    says(
        &layers(r#"[{ "name": "a", "parent": "b" }, { "name": "b", "parent": "a" }]"#),
        &["layers", "cyclic: \"a\" → \"b\" → \"a\"", "take the parent"],
    );
    says(&layers(r#"[{ "name": "a", "parent": "a" }]"#), &["cyclic: \"a\" → \"a\""]);
    let circle: Vec<String> =
        (0..500).map(|i| format!(r#"{{ "name": "{i}", "parent": "{}" }}"#, (i + 1) % 500)).collect();
    says(&layers(&format!("[{}]", circle.join(","))), &["cyclic", "499 more"]);
}

#[test]
fn units_are_names_or_metres() {
    let unit = |name: &str| {
        read(format!(r#"{{ "loftsman": 1, "unit": "{name}", "objects": [] }}"#))
            .map(|(scene, report)| (scene.unit, report.notes))
    };
    assert_eq!(unit("0.3 m").unwrap(), (Unit::of_metres(0.3).unwrap(), vec![]));
    assert_eq!(unit("0.0254 m").unwrap().0, Unit::Inch);
    let (unknown, notes) = unit("unknown").unwrap();
    assert!(unknown == Unit::Unknown && notes.is_empty(), "{notes:?}");
    for name in ["0 m", "-1 m", "1e999 m", "NaN m", ""] {
        says(&unit(name).unwrap_err().to_string(), &["unknown unit", &format!("\"{name}\"")]);
    }
}

#[test]
fn geometry_that_cannot_be_names_the_entry() {
    let curve = |fields: &str| refused(&format!(r#""curve": {{ {fields} }}"#));
    let two = r#""points": [[0, 0, 0], [1, 0, 0]]"#;
    says(
        &curve(&format!(r#""degree": 1, "knots": [0, 1, 2], {two}"#)),
        &["objects[0].curve.knots", "3 knots do not fit 2 control vertices", "needs 4"],
    );
    says(
        &curve(&format!(r#""degree": 1, "periodic": true, "knots": [0, 1], {two}"#)),
        &["curve.knots", "periodic", "needs 3"],
    );
    says(
        &curve(&format!(r#""degree": 1000000000, "knots": [0, 1, 2], {two}"#)),
        &["curve.degree", "degree 1000000000", "1 to 25"],
    );
    says(&curve(&format!(r#""degree": -1, "knots": [], {two}"#)), &["curve.degree", "a whole number from 0"]);
    says(
        &curve(&format!(r#""degree": 1.5, "knots": [], {two}"#)),
        &["curve.degree", "a whole number from 0"],
    );
    says(
        &curve(&format!(r#""degree": 1, "knots": [0, 0, 1, 1], {two}, "weights": [1, 0]"#)),
        &["curve.weights[1]", "weight 1 is 0", "positive"],
    );
    says(
        &curve(&format!(r#""degree": 1, "knots": [0, 0, 1, 1], {two}, "weights": [1]"#)),
        &["curve.weights", "1 weights"],
    );
    says(
        &curve(&format!(r#""degree": 1, "knots": [0, 1, 0, 2], {two}"#)),
        &["curve.knots[2]", "must not decrease"],
    );
    says(
        &curve(r#""degree": 1, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [1, 0]]"#),
        &["curve.points[1]", "a list of 2 numbers where [x, y, z] is needed"],
    );
    says(&curve(r#""points": [[0, 0, 0, 0]]"#), &["curve.points[0]", "more than 3"]);
    says(&curve(r#""points": [[0, NaN, 0]]"#), &["curve.points[0][1]", "NaN is not a number", "finite"]);
    says(&curve(r#""points": [[0, -Infinity, 0]]"#), &["curve.points[0]", "Infinity is not a number"]);
    says(&curve(r#""points": [[0, 1e999, 0]]"#), &["curve.points[0][1]", "too large"]);
    says(&curve(r#""points": [[0, null, 0]]"#), &["curve.points[0][1]", "null", "a number"]);
    let surface = |points: &str, weights: &str| {
        let u = r#"{ "degree": 1, "knots": [0, 0, 1, 1] }"#;
        refused(&format!(r#""surface": {{ "u": {u}, "v": {u}, "points": {points}{weights} }}"#))
    };
    says(&surface("[[[0,0,0],[1,0,0]],[[0,1,0]]]", ""), &["surface.points[1]", "1 entries", "2"]);
    says(
        &surface("[[[0,0,0],[1,0,0]],[[0,1,0],[1,1,0]]]", r#", "weights": [[1,1],[1,-2]]"#),
        &["surface.weights[1][1]", "-2"],
    );
    says(&surface("[[[0,0,0],[1,0,0]]]", ""), &["surface.points", "1 control vertices are too few"]);
    says(&surface("[]", ""), &["surface.points", "too few"]);
    says(&refused(r#""surface": { "u": {}, "v": {}, "points": [] }"#), &["needs the field \"degree\""]);
    let mesh = |faces: &str| {
        refused(&format!(r#""mesh": {{ "points": [[0,0,0],[1,0,0],[0,1,0]], "faces": {faces} }}"#))
    };
    says(&mesh("[[0, 1, 2], [0, 1, 3]]"), &["mesh.faces[1]", "point 3", "only 3"]);
    says(&mesh("[[0, 1]]"), &["mesh.faces[0]", "2 corners"]);
    says(&mesh("[[0, 1, -1]]"), &["mesh.faces[0][2]", "-1"]);
    says(&mesh("[[0, 1, 4294967296]]"), &["mesh.faces[0][2]", "4294967296"]);
    says(&mesh(r#"[[0, 1, 2]], "uvs": [[0, 0]]"#), &["mesh.uvs", "1 uvs for 3 points"]);
    let layer = |text: &str| mesh(&format!(r#"[[0, 1, 2]], {text}"#));
    says(&layer(r#""uvs": { "values": [[0, 0]] }"#), &["mesh.uvs", "needs the field \"corners\""]);
    says(&layer(r#""uvs": { "values": [[0, 0]], "corners": [0] }"#), &["mesh.uvs", "1 indices", "3 corners"]);
    says(
        &layer(r#""uvs": { "values": [[0, 0]], "corners": [0, -1, 1] }"#),
        &["mesh.uvs", "entry 1", "only 1"],
    );
    says(&layer(r#""normals": { "values": [], "corners": [0.5] }"#), &["mesh.normals.corners[0]", "0.5"]);
    says(&layer(r#""normals": { "values": [], "corners": [-2] }"#), &["mesh.normals.corners[0]", "-2"]);
    says(&layer(r#""colors": 3"#), &["mesh.colors", "a list of [red, green, blue, alpha]"]);
    says(&layer(r#""more_uvs": [[[0, 0, 0]]]"#), &["mesh.more_uvs[0][0]", "more than 2"]);
    says(&layer(r#""lines": [[0, 1], [2]]"#), &["mesh.lines", "line 1", "at least 2"]);
    says(&layer(r#""lines": [[0, 7]]"#), &["mesh.lines", "point 7", "only 3"]);
    says(&layer(r#""smoothing": [1, 2]"#), &["objects[0].mesh", "2 smoothing groups for 1 faces"]);
    says(&layer(r#""groups": [{ "name": "g", "faces": [1] }]"#), &["objects[0].mesh", "the group \"g\""]);
    says(&layer(r#""materials": [1]"#), &["objects[0].mesh.materials[0]", "entry 1"]);
    says(&layer(r#""materials": [4294967296]"#), &["mesh.materials[0]", "4294967296"]);
}

#[test]
fn materials_that_cannot_be_say_which() {
    let material = |fields: &str| {
        document(&format!(
            r#"{{ "loftsman": 1, "materials": [{{ "name": "m", {fields} }}], "objects": [] }}"#
        ))
    };
    says(&material(r#""blend": true, "alpha_cutoff": 0.5"#), &["materials[0].blend", "take one away"]);
    says(&material(r#""base_color": [1, 1, 1]"#), &["materials[0].base_color", "3 numbers"]);
    says(&material(r#""statements": [["a"]]"#), &["materials[0].statements[0]", "1 texts"]);
    let texture = |fields: &str| material(&format!(r#""textures": [{{ {fields} }}]"#));
    says(
        &texture(r#""channel": "normals", "image": "i""#),
        &["materials[0].textures[0].channel", "\"normal\"?"],
    );
    says(&texture(r#""image": "i""#), &["materials[0].textures[0]", "needs the field \"channel\""]);
    says(&texture(r#""other": "x", "image": "i""#), &["materials[0].textures", "no image \"i\""]);
    says(&texture(r#""wrap": ["repeat"]"#), &["textures[0].wrap", "1 words"]);
    says(&texture(r#""minify": "cubic""#), &["textures[0].minify", "\"cubic\"", "known are nearest"]);
    let image = |fields: &str| {
        document(&format!(r#"{{ "loftsman": 1, "images": [{{ "name": "m", {fields} }}], "objects": [] }}"#))
    };
    says(&image(r#""media_type": "image/png""#), &["images[0]", "\"base64\""]);
    says(&image(r#""media_type": "image/png", "base64": "!!""#), &["images[0].base64", "not base 64"]);
    says(
        &image(r#""file": "a" }, { "name": "m", "file": "b""#),
        &["images[1].name", "two images are named \"m\""],
    );
    let cloud = r#""cloud": { "points": [] }, "materials": ["wod"]"#;
    let text = format!(
        r#"{{ "loftsman": 1, "objects": [ {{ "name": "a", {cloud} }} ], "materials": [{{ "name": "wood" }}] }}"#
    );
    says(&document(&text), &["objects[0].materials[0]", "object \"a\"", "did you mean \"wood\"?"]);
}

#[test]
fn objects_that_cannot_be_say_which() {
    let cloud = r#""cloud": { "points": [] }"#;
    says(
        &refused(&format!(r#"{cloud}, "group": {{}}"#)),
        &["a \"cloud\" and a \"group\"", "an object of its own"],
    );
    says(&refused(r#""color": [1, 1, 1, 1]"#), &["objects[0]", "no geometry"]);
    says(&refused(&format!(r#"{cloud}, "color": [1, 1, 1]"#)), &["objects[0].color", "3 numbers"]);
    says(
        &refused(&format!(r#"{cloud}, "transform": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[5,0,0,1]]"#)),
        &["objects[0].transform", "last row"],
    );
    says(&refused(&format!(r#"{cloud}, "transform": [[1,0,0,0]]"#)), &["objects[0].transform", "1 rows"]);
    says(
        &refused(&format!(r#"{cloud}, "animation": {{ "rate": 0, "frames": [] }}"#)),
        &["objects[0].animation.rate", "positive"],
    );
    says(
        &refused(&format!(r#"{cloud}, "animation": {{ "rate": 1, "frames": [[[0,0,0]]] }}"#)),
        &["objects[0].animation.frames[0]", "1 points"],
    );
    says(&refused(&format!(r#"{cloud}, "parent": "b""#)), &["objects[0].parent", "no object \"b\""]);
    let objects = |text: &str| document(&format!(r#"{{ "loftsman": 1, "objects": [ {text} ] }}"#));
    let named = |name: &str, rest: &str| format!(r#"{{ "name": "{name}", {cloud}{rest} }}"#);
    says(
        &objects(&[named("a", ""), named("a", "")].join(",")),
        &["objects[1].name", "object \"a\"", "two objects are named \"a\""],
    );
    says(&objects(&named("", "")), &["objects[0].name", "empty name"]);
    let cycle = [named("a", r#", "parent": "b""#), named("b", r#", "parent": "a""#)].join(",");
    says(&objects(&cycle), &["objects", "cyclic", "take one parent away"]);
    says(
        &objects(&[named("frame", ""), named("b", r#", "parent": "frames""#)].join(",")),
        &["objects[1].parent", "did you mean \"frame\"?"],
    );
}

#[test]
fn bytes_that_are_no_document() {
    for (bytes, part) in [
        (&b""[..], "empty"),
        (b" \n", "empty"),
        (b"\xEF\xBB\xBF", "empty"),
        (b"{", "ends in the middle"),
        (b"1", "expected a document"),
        (b"\x00", "expected value"),
        (b"\xFF\xFE{\0", "UTF-16"),
        (b"{ \"loftsman\": 1,\n \"unit\": \"\xE9\" }", "line 2: byte 27 is not UTF-8"),
    ] {
        says(&read(bytes).unwrap_err().to_string(), &[part]);
    }
    let brackets = "[".repeat(200_000);
    says(&document(&brackets), &["expected a document"]);
    let tables = "{\"objects\":".repeat(200_000);
    says(&document(&tables), &["objects"]);
    for inside in ["objects", "objects\": [{\"curve\": {\"points"] {
        says(&document(&format!("{{\"loftsman\": 1, \"{inside}\": {brackets}")), &["objects[0]"]);
    }
    let long = "x".repeat(1_000_000);
    says(&document(&format!("{{\"loftsman\": \"{long}\"}}")), &["loftsman", "a whole number"]);
    says(&document(&format!("{{\"{long}\": 1}}")), &["no field \"xxx"]);
    says(&refused(&format!("\"parent\": \"{long}\", \"group\": {{}}")), &["parent"]);
}

#[test]
fn a_byte_order_mark_is_no_harm() {
    let mut bytes = b"\xEF\xBB\xBF".to_vec();
    bytes.extend(write(&everything()));
    assert_eq!(Native.confidence(&bytes), Confidence::Sure);
    assert_eq!(read(bytes).unwrap().0.objects().len(), everything().objects().len());
}

#[test]
fn scenes_that_no_document_can_hold_are_not_written() {
    let refuse = |change: &dyn Fn(&mut Scene)| {
        let mut scene = everything();
        change(&mut scene);
        let mut sink = Memory::new("out.loft.json", "");
        let error = Native.write(&scene, &mut sink, &WriteOptions::default()).unwrap_err();
        assert!(sink.bytes.is_empty());
        error.to_string()
    };
    let nan = || Cloud { points: vec![Point::new(0.0, f64::NAN, 0.0)] };
    says(&refuse(&|s| s.replace("scan", nan()).unwrap()), &["\"scan\"", "point 0", "NaN"]);
    says(&refuse(&|s| s.object_mut("hull").unwrap().parent = Some("hull".into())), &["cyclic", "\"hull\""]);
    let mesh = || {
        let points = vec![Point::origin(); 3];
        let mut mesh = Mesh::new(points, &[[0, 1, 2]]).unwrap();
        mesh.normals = Layer::per_point(vec![Vector::z(); 2]);
        mesh
    };
    says(&refuse(&|s| s.replace("panel", mesh()).unwrap()), &["\"panel\"", "2 normals for 3 points"]);
    says(&refuse(&|s| s.object_mut("section").unwrap().color = Some([f64::INFINITY; 4])), &["colour", "inf"]);
    says(
        &refuse(&|s| s.object_mut("scan").unwrap().transform = Some(nalgebra::Matrix4::zeros())),
        &["affine"],
    );
    let mut scene = Scene::new();
    scene.add(Object::new("ok", Cloud::default().into())).unwrap();
    assert!(read(write(&scene)).is_ok());
}

#[test]
fn a_document_cut_within_a_letter_is_said_to_be_cut() {
    let bytes = "{ \"loftsman\": 1, \"objects\": [{ \"name\": \"é".as_bytes();
    let error = read(&bytes[..bytes.len() - 1]).unwrap_err();
    assert!(error.problem.contains("ends in the middle of a letter"), "{error}");
}

proptest! {
    #[test]
    fn arbitrary_bytes_give_one_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(!read(bytes).unwrap_err().problem.is_empty());
    }

    #[test]
    fn arbitrary_json_gives_one_error(text in r#"[\[\]{}:,"0-9a-z.eE+\- ]{0,120}"#) {
        prop_assert!(!read(text).unwrap_err().problem.is_empty());
    }

    #[test]
    fn a_truncated_document_is_an_error(cut in 0.0..1.0_f64) {
        let bytes = write(&everything());
        // The last byte is the line break behind the document.
        let end = ((bytes.len() - 1) as f64 * cut) as usize;
        let error = read(&bytes[..end]).unwrap_err();
        prop_assert!(error.problem.contains("ends in the middle") || error.problem.contains("empty"), "{}", error);
    }

    #[test]
    fn a_changed_byte_never_panics(at in 0.0..1.0_f64, byte: u8) {
        let mut bytes = write(&everything());
        let at = (bytes.len() as f64 * at) as usize;
        bytes[at] = byte;
        if let Ok((scene, report)) = read(bytes) {
            prop_assert!(report.adds_up() && report.entities == scene.objects().len());
        }
    }
}
