//! Layers, labels, unknown units and objects of definitions, as the program shows and edits them.

use serde_json::{Value, json};

use loftsman_tests::bench::Bench;

use crate::LOFTSMAN;

/// Two wheels of one definition; what is below the layer "hidden" is not seen.
const CAR: &str = r#"{ "loftsman": 1, "unit": "mm",
  "layers": [ { "name": "steel", "color": [1, 0, 0, 1], "parent": "hidden" }, { "name": "hidden", "visible": false } ],
  "definitions": [ { "name": "wheel", "objects": [
    { "name": "rim", "label": "ring", "curve": { "degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1],
      "points": [[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]] } } ] } ],
  "objects": [
    { "name": "left", "instance": { "definition": "wheel" } },
    { "name": "right", "transform": [[1, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
      "instance": { "definition": "wheel" } },
    { "name": "chassis", "layer": "steel", "polyline": { "points": [[0, 0, 0], [10, 0, 0]] } },
    { "name": "roof", "layer": "glass", "polyline": { "points": [[0, 5, 0], [10, 5, 0]] } } ] }"#;

/// A recipe that pushes the middle of a rim.
fn push(object: &str, more: &str) -> String {
    format!(
        "input = 'car.loft.json'\noutput = ['out.loft.json', 'out.svg']\n[[step]]\nop = 'edit'\nobject = '{object}'\n{more}\n\
         constraints = [{{ kind = 'position', at = 0.5, by = [0, 1, 0] }}]\n"
    )
}

fn car() -> Bench {
    let bench = LOFTSMAN.bench();
    bench.write("car.loft.json", CAR);
    bench
}

/// The height of the first inner vertex of the rim of each definition, by its name.
fn rims(bench: &Bench) -> Vec<(String, f64)> {
    let document: Value = serde_json::from_slice(&bench.read("out.loft.json")).unwrap();
    let definitions = document["definitions"].as_array().unwrap().clone();
    let height = |d: &Value| d["objects"][0]["curve"]["points"][1][1].as_f64().unwrap();
    definitions.iter().map(|d| (d["name"].as_str().unwrap().to_owned(), height(d))).collect()
}

#[test]
fn an_edit_of_a_definition_edits_all_instances_and_says_so() {
    let bench = car();
    bench.write("r.toml", push("right/rim", ""));
    let report = bench.json(&["run", "r.toml"]);
    let notes = report["steps"][0]["notes"].to_string();
    assert!(notes.contains("the definition \\\"wheel\\\", which is shown 2 times: all of them"), "{report}");
    assert_eq!(report["steps"][0]["object"], "right/rim");
    let found = rims(&bench);
    assert!(found.len() == 1 && found[0].1 > 1.5, "{found:?}");
    let objects = bench.json(&["info", "out.loft.json"])["objects"].as_array().unwrap().len();
    assert_eq!(objects, 4);
}

#[test]
fn unique_edits_the_one_that_is_named() {
    let bench = car();
    bench.write("r.toml", push("right/rim", "unique = true"));
    let report = bench.json(&["run", "r.toml"]);
    let notes = report["steps"][0]["notes"].to_string();
    assert!(notes.contains("edited here alone") && notes.contains("wheel.001"), "{report}");
    let found = rims(&bench);
    assert_eq!((found.len(), found[0].0.as_str(), found[0].1), (2, "wheel", 1.0), "{found:?}");
    assert!(found[1].0 == "wheel.001" && found[1].1 > 1.5, "{found:?}");
    let info = bench.json(&["info", "out.loft.json"]);
    assert_eq!(
        (&info["objects"][0]["shows"], &info["objects"][1]["shows"]),
        (&json!("wheel"), &json!("wheel.001"))
    );
    // The same numbers, wherever the instance is: they are of the definition's coordinates.
    bench.write("all.toml", push("left/rim", "").replace("out.", "all."));
    bench.done(&["run", "all.toml"]);
    let all: Value = serde_json::from_slice(&bench.read("all.loft.json")).unwrap();
    let one: Value = serde_json::from_slice(&bench.read("out.loft.json")).unwrap();
    assert_eq!(all["definitions"][0]["objects"], one["definitions"][1]["objects"]);
}

#[test]
fn what_cannot_be_edited_of_a_definition_is_said() {
    let bench = car();
    for (object, more, words) in [
        ("roof", "unique = true", &["step[0].unique", "names no object of a definition"][..]),
        ("right/rom", "", &["no object \"right/rom\""]),
        ("right/rim", "unique = 1", &["unique", "true or false"]),
        ("right/rim", "unqiue = true", &["unqiue"]),
    ] {
        bench.write("r.toml", push(object, more));
        bench.fails(&["run", "r.toml"], 1, words);
    }
    let two =
        "constraints = [{ kind = 'join', at = 1, with = { object = 'left/rim', at = 0 }, keep = true }]";
    let recipe = push("right/rim", "");
    let join = recipe.lines().filter(|l| !l.starts_with("constraints")).collect::<Vec<_>>().join("\n");
    bench.write("r.toml", format!("{join}\n{two}\n"));
    bench.fails(&["run", "r.toml"], 1, &["\"left/rim\" and \"right/rim\" are one object", "unique = true"]);
    for step in ["op = 'delete'\nobject = 'left/rim'", "op = 'rename'\nobject = 'left/rim'\nto = 'x'"] {
        bench.write(
            "r.toml",
            format!("input = 'car.loft.json'\noutput = 'out.loft.json'\n[[step]]\n{step}\n"),
        );
        bench.fails(
            &["run", "r.toml"],
            1,
            &["of the definition \"wheel\"", "cannot be taken out or named anew"],
        );
    }
    assert!(!bench.files().contains(&"out.loft.json".to_owned()));
}

#[test]
fn info_lists_layers_and_labels_and_pictures_leave_out_what_is_hidden() {
    let bench = car();
    let info = bench.json(&["info", "car.loft.json"]);
    let layers = json!([
        { "name": "steel", "color": [1.0, 0.0, 0.0, 1.0], "hidden": true, "parent": "hidden", "objects": 1 },
        { "name": "hidden", "hidden": true, "objects": 0 },
        { "name": "glass", "objects": 1 },
    ]);
    assert_eq!(info["layers"], layers);
    assert_eq!(info["definitions"][0]["objects"][0]["label"], "ring");
    let text = bench.done(&["info", "car.loft.json"]);
    for words in ["layer steel", "hidden", "below hidden", "labelled ring"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let losses = bench.json(&["info", "car.loft.json", "--to", "obj"])["conversion"]["losses"].to_string();
    assert!(losses.contains("hidden layer") && losses.contains("1 label is"), "{losses}");
    let run = bench.run(&["plot", "car.loft.json", "car.svg"]);
    assert!(run.code == Some(0) && run.err.contains("one object is on a hidden layer"), "{}", run.err);
    let svg = String::from_utf8(bench.read("car.svg")).unwrap();
    assert!(svg.contains("roof") && !svg.contains("chassis"), "{svg}");
    // Conversions keep it.
    let said = bench.json(&["convert", "car.loft.json", "car.glb"])["notes"].to_string();
    assert!(said.contains("1 object is on a hidden layer"), "{said}");
    bench.done(&["convert", "car.glb", "back.loft.json"]);
    let back = bench.json(&["info", "back.loft.json"]);
    assert_eq!(back["layers"][0], layers[0]);
    assert_eq!(back["objects"][1]["label"], Value::Null);
}

#[test]
fn a_file_without_a_unit_has_an_unknown_one_until_it_is_named() {
    let bench = LOFTSMAN.bench();
    bench.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(bench.json(&["info", "part.obj"])["unit"], "unknown");
    assert!(bench.done(&["info", "part.obj"]).contains("unknown unit"));
    let losses = bench.json(&["info", "part.obj", "--to", "glb"])["conversion"]["losses"].to_string();
    assert!(losses.contains("unit of the scene is unknown"), "{losses}");
    let said = bench.json(&["convert", "part.obj", "part.glb"]);
    assert!(said["notes"].to_string().contains("unit of the scene is unknown"), "{said}");
    let said = bench.json(&["convert", "part.obj", "part.glb", "--unit", "mm"]);
    assert!(!said.to_string().contains("unknown"), "{said}");
    // A document keeps that it is unknown; one without the field means metres.
    bench.done(&["convert", "part.obj", "part.loft.json"]);
    assert_eq!(bench.json(&["info", "part.loft.json"])["unit"], "unknown");
    bench.write("plain.loft.json", r#"{ "loftsman": 1, "objects": [] }"#);
    assert_eq!(bench.json(&["info", "plain.loft.json"])["unit"], "m");
    // Any number of metres is a unit.
    bench.done(&["convert", "part.obj", "feet.loft.json", "--unit", "0.3 m"]);
    assert_eq!(bench.json(&["info", "feet.loft.json"])["unit"], "0.3 m");
    bench.done(&["convert", "feet.loft.json", "metres.loft.json", "--unit", "m"]);
    let metres: Value = serde_json::from_slice(&bench.read("metres.loft.json")).unwrap();
    assert_eq!(metres["objects"][0]["mesh"]["points"][1][0], 0.3);
    for unit in ["furlong", "unknown", "0 m"] {
        bench.fails(&["convert", "part.obj", "x.glb", "--unit", unit], 2, &["unit", unit]);
    }
    // Areas and volumes of who knows what.
    bench.write("rim.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\no rim\nl 1 2 3 1\n");
    let extrude = "input = 'rim.obj'\n[[step]]\nop = 'extrude'\nobjects = ['rim']\nby = [0, 0, 1]\n";
    bench.write("r.toml", extrude);
    let notes =
        |bench: &Bench| bench.json(&["run", "r.toml", "-o", "x.loft.json"])["steps"][0]["notes"].to_string();
    assert!(notes(&bench).contains("the unit is unknown: areas and volumes"), "{}", notes(&bench));
    bench.write("r.toml", format!("unit = 'mm'\n{extrude}"));
    assert!(!notes(&bench).contains("unknown"), "{}", notes(&bench));
}
