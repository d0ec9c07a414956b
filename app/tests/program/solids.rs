//! Solids from CAD: what `info` says of them, how they go out, what a picture and a section show.

use std::path::Path;

use loftsman_tests::repository;
use serde_json::{Value, json};

use crate::LOFTSMAN;

fn data(name: &str) -> String {
    repository().join("tests/data/step").join(name).to_string_lossy().into_owned()
}

fn object<'v>(list: &'v Value, name: &str) -> &'v Value {
    list.as_array().unwrap().iter().find(|o| o["name"] == name).unwrap()
}

#[test]
fn info_shows_an_assembly_as_a_tree() {
    let folder = tempfile::tempdir().unwrap();
    let file = data("as1-oc-214.stp");
    let found = LOFTSMAN.json(folder.path(), &["info", &file]);
    assert_eq!(found["totals"], json!({ "breps": 18, "solids": 18, "faces": 160, "edges": 354 }));
    assert_eq!(found["shown"], 36);
    let bracket = object(&found["definitions"], "l-bracket-assembly");
    assert_eq!(bracket["totals"]["solids"], 7);
    let nut = object(&object(&found["definitions"], "nut")["objects"], "nut");
    assert_eq!((&nut["solids"], &nut["faces"], &nut["edges"]), (&json!(1), &json!(8), &json!(18)));
    // A square of 20 by 15 and 3 high with a hole of 10 through it.
    let exact = 20.0 * 15.0 * 3.0 - std::f64::consts::PI * 25.0 * 3.0;
    let volume = nut["volume"].as_f64().unwrap();
    assert!(
        (volume / exact - 1.0).abs() < 5e-3 && nut["within"].as_f64().unwrap() < 0.01,
        "{volume} {exact}"
    );
    let text = LOFTSMAN.done(folder.path(), &["info", &file]);
    let depth = |name: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        line.len() - line.trim_start().len()
    };
    assert_eq!(
        (depth("as1 "), depth("rod-assembly"), depth("nut_1"), depth("plate")),
        (2, 4, 6, 4),
        "{text}"
    );
    assert!(text.contains("18 solids · 160 faces · 354 edges") && !text.contains("not measured"), "{text}");
}

#[test]
fn what_is_open_is_named_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let found = LOFTSMAN.json(folder.path(), &["info", &data("test_pipe.step")]);
    let first = &found["objects"][0];
    assert_eq!((&first["open_edges"], &first["closed"]), (&json!(1), &json!(false)));
    assert_eq!(first["open_at"][0]["edge"], 0);
    // A disc of radius 1000; its rim runs through its middle's place on the circle.
    let at: Vec<f64> =
        first["open_at"][0]["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!((at[0].hypot(at[1]) - 1000.0).abs() < 1e-3, "{at:?}");
    let text = LOFTSMAN.done(folder.path(), &["info", &data("test_pipe.step"), "--to", "obj"]);
    assert!(
        text.contains("1 open edge: 0 near (") && text.contains("brep becomes segments or triangles (6)"),
        "{text}"
    );
}

#[test]
fn colours_of_faces_go_along() {
    let folder = tempfile::tempdir().unwrap();
    let file = data("io1-cm-214.stp");
    let said = LOFTSMAN.json(folder.path(), &["convert", &file, "part.obj"]);
    let written = &said["objects"][0];
    assert_eq!(
        (&written["fate"], &written["reason"]),
        (&json!("approximated"), &json!("the brep was tessellated"))
    );
    let text = std::fs::read_to_string(folder.path().join("part.obj")).unwrap();
    assert!(text.contains("usemtl color-1") && text.contains("g face_28"), "no material, or no groups");
    LOFTSMAN.done(folder.path(), &["convert", &file, "part.gltf"]);
    let gltf: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("part.gltf")).unwrap()).unwrap();
    assert!(
        gltf["materials"]
            .as_array()
            .unwrap()
            .iter()
            .any(|m| m["pbrMetallicRoughness"]["baseColorFactor"] != json!([0.8, 0.8, 0.8, 1.0]))
    );
}

#[test]
fn pictures_and_sections_of_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let file = data("base_interface_AP214.STEP");
    LOFTSMAN.done(folder.path(), &["plot", &file, "part.svg"]);
    let svg = std::fs::read_to_string(folder.path().join("part.svg")).unwrap();
    assert!(
        svg.contains("class=\"outline\"") && svg.contains("class=\"shading\"") && !svg.contains("not drawn")
    );
    let recipe = format!(
        "input = {file:?}\noutput = [\"cut.step\", \"cut.svg\"]\n[[step]]\nop = \"section\"\nobject = {:?}\naxis = \"z\"\ncount = 2\n",
        LOFTSMAN.json(folder.path(), &["info", &file])["objects"][0]["name"].as_str().unwrap()
    );
    std::fs::write(folder.path().join("cut.toml"), recipe).unwrap();
    let report = LOFTSMAN.json(folder.path(), &["run", "cut.toml"]);
    let notes = report["steps"][0]["notes"].to_string();
    assert_eq!(notes.matches("cuts an area of ").count(), 2, "{notes}");
    assert!(Path::new(&folder.path().join("cut.step")).exists());
    let back = LOFTSMAN.json(folder.path(), &["info", "cut.step"]);
    let curves = back["objects"].as_array().unwrap().iter().filter(|o| o["type"] == "curve");
    assert!(curves.clone().count() >= 2 && curves.clone().all(|c| c["closed"] == true), "{back}");
}
