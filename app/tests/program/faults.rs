//! Whose fault it is: exit status 2 where the command line is wrong, before anything is written.

use serde_json::json;

use crate::LOFTSMAN;

#[test]
fn a_wrong_command_line_is_told_from_a_wrong_input() {
    let bench = LOFTSMAN.bench().with_wave();
    let wave = "wave.loft.json";
    bench.write("points.xyz", "0 0 0\n1 1 0\n2 0 0\n3 1 0\n4 0 0\n5 1 0\n");
    bench.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (arguments, words) in [
        (vec!["plot", wave, "x.png", "--pixels", "0"], vec!["--pixels", "1..=16384"]),
        (vec!["plot", wave, "x.png", "--pixels", "-5"], vec!["--pixels", "-5"]),
        (vec!["plot", wave, "x.svg", "--width", "-1"], vec!["--width", "positive"]),
        (vec!["fit", "points.xyz", "x.loft.json", "--degree", "40"], vec!["--degree", "from 1 to 25", "40"]),
        (vec!["fit", "points.xyz", "x.loft.json", "--degree", "0"], vec!["--degree", "from 1 to 25"]),
        (vec!["fit", "points.xyz", "x.loft.json", "--vertices", "2"], vec!["--vertices", "4 or more"]),
        (vec!["fit", "points.xyz", "x.loft.json", "--vertices", "-2"], vec!["--vertices", "-2"]),
        (vec!["fit", "points.xyz", "x.loft.json", "--tolerance", "-1"], vec!["--tolerance", "positive"]),
        (vec!["convert", wave, "x.obj", "--tolerance", "-1"], vec!["--tolerance", "-1"]),
        (
            vec!["convert", wave, "x.obj", "--write", "meshes-only=true"],
            vec!["meshes-only", "obj has", "gltf"],
        ),
        (vec!["convert", wave, "x.glb", "--write", "knots=any"], vec!["knots", "gltf has no such", "obj"]),
        (vec!["convert", wave, "x.obj", "--write", "knots=some"], vec!["knots", "some"]),
        (vec!["convert", "part.obj", "x.glb", "--read", "as=cloud"], vec!["as", "obj has no such", "points"]),
        (vec!["convert", "part.obj", "x.glb", "--read", "split=some"], vec!["split", "some"]),
        (vec!["info", wave, "--to", "glb", "--write", "knots=any"], vec!["knots", "gltf has no such"]),
    ] {
        let said = bench.fails(&arguments, 2, &words);
        assert!(!said.contains("use '-- -"), "{said}");
    }
    // These are the input's.
    bench.write("two.xyz", "0 0 0\n1 1 0\n");
    bench.fails(&["fit", "two.xyz", "x.loft.json", "--interpolate"], 1, &["two.xyz"]);
    bench.write("noise.glb", [0x93_u8, 0x1f, 0xe2, 0x07, 0xff, 0x80].repeat(100));
    bench.fails(&["info", "noise.glb"], 1, &["neither a GLB", "nor a glTF text"]);
}

/// A step in one pair of brackets; what other programs do and no operation here.
#[test]
fn slips_of_a_step_are_told_with_what_to_write() {
    let bench = LOFTSMAN.bench().with_wave();
    let recipe = |step: &str| format!("input = 'wave.loft.json'\n{step}\n");
    bench.write("one.toml", recipe("[step]\nop = 'copy'\nobject = 'wave'\nto = ['again']"));
    bench.fails(&["run", "one.toml"], 1, &["write [[step]], with two brackets"]);
    bench.write("odd.toml", recipe("[[step]]\nop = 'fillet'\nobject = 'wave'"));
    bench.fails(&["run", "odd.toml"], 1, &["no operation \"fillet\"", "for a CAD program"]);
    // What a copy adds is told as what every other step adds.
    bench.write("two.toml", recipe("[[step]]\nop = 'copy'\nobject = 'wave'\nto = ['again']"));
    assert!(bench.done(&["run", "two.toml"]).contains("\"again\"  new"));
}

#[test]
fn what_a_format_refuses_is_told_beforehand() {
    let bench = LOFTSMAN.bench();
    bench.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let refused = bench.fails(&["convert", "part.obj", "part.csv"], 1, &["no cloud", "tessellate"]);
    let told = bench.json(&["info", "part.obj", "--to", "csv"])["conversion"].clone();
    let problem = told["refused"].as_str().unwrap();
    assert!(refused.contains(problem), "{refused}: {problem}");
    assert!(bench.done(&["info", "part.obj", "--to", "csv"]).contains("a conversion to points is refused"));
    // So it is where every object is one that the format has not.
    let refused = bench.fails(&["convert", "part.obj", "part.igs"], 1, &["nothing would be in it"]);
    let told = bench.json(&["info", "part.obj", "--to", "igs"])["conversion"].clone();
    assert!(refused.contains(told["refused"].as_str().unwrap()), "{refused}: {told}");
    assert_eq!(told["losses"], serde_json::json!([]));
    let notes = bench.json(&["convert", "part.obj", "part.glb"])["notes"].clone();
    let told = bench.json(&["info", "part.obj", "--to", "glb"])["conversion"]["losses"].clone();
    let told = told.as_array().unwrap();
    assert!(!told.is_empty() && told.iter().all(|loss| notes.as_array().unwrap().contains(loss)), "{told:?}");
}

#[test]
fn many_instances_of_a_definition_are_one_line() {
    let bench = LOFTSMAN.bench();
    let shows = |k: usize| json!({ "name": format!("bolt {k}"), "instance": { "definition": "bolt" } });
    let scene = |count: usize| {
        let objects: Vec<_> = (0..count).map(shows).collect();
        let bolt =
            json!({ "name": "bolt", "objects": [{ "name": "dot", "cloud": { "points": [[0, 0, 0]] } }] });
        json!({ "loftsman": 1, "objects": objects, "definitions": [bolt] }).to_string()
    };
    bench.write("few.loft.json", scene(3)).write("many.loft.json", scene(500));
    assert!(bench.done(&["info", "few.loft.json"]).contains("bolt 2"));
    let text = bench.done(&["info", "many.loft.json"]);
    assert!(text.contains("500 instances of bolt") && text.lines().count() < 10, "{text}");
    assert_eq!(bench.json(&["info", "many.loft.json"])["objects"].as_array().map(Vec::len), Some(500));
}

#[test]
fn letters_that_no_png_shows_are_said() {
    let bench = LOFTSMAN.bench().with_wave();
    let wave = "wave.loft.json";
    let warned = |out: &str| bench.run(&["plot", wave, out, "--title", "船 1"]).err;
    let said = warned("x.png");
    assert!(said.contains("船") && said.contains("drawn as boxes"), "{said}");
    assert_eq!(warned("x.svg"), "");
    let recipe = format!("input = '{wave}'\noutput = 'y.png'\n[picture]\ntitle = '船 1'\n");
    bench.write("r.toml", recipe);
    let notes = bench.json(&["run", "r.toml"])["outputs"][0]["notes"].to_string();
    assert!(notes.contains("drawn as boxes"), "{notes}");
}
