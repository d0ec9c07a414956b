//! What goes to the standard output, and to whom.

use std::io::Read;

use loftsman_tests::bench::WAVE;

use crate::LOFTSMAN;

#[test]
fn info_says_what_is_in_a_file() {
    let bench = LOFTSMAN.bench().with_wave();
    let info = bench.json(&["info", "wave.loft.json"]);
    assert_eq!((info["unit"].as_str(), info["up"].as_str()), (Some("mm"), Some("z")));
    let wave = &info["objects"][0];
    assert_eq!((wave["name"].as_str(), wave["type"].as_str()), (Some("wave"), Some("curve")));
    assert_eq!((wave["degree"].as_u64(), wave["vertices"].as_u64()), (Some(3), Some(8)));
    assert_eq!(wave["domain"], serde_json::json!([[0.0, 5.0]]));
    assert_eq!((wave["closed"].as_bool(), wave["periodic"][0].as_bool()), (Some(false), Some(false)));
    // By adaptive quadrature in scipy.
    assert!((wave["length"].as_f64().unwrap() - 8.182_391_751_322_32).abs() < 1e-9, "{wave}");
    assert_eq!(wave["bounds"].as_array().map(Vec::len), Some(2), "{wave}");
    assert!(info["report"]["kept"].as_u64().unwrap() > 0);
    let text = bench.done(&["info", "wave.loft.json"]);
    for words in ["wave", "curve", "degree 3", "8 vertices", "8.182"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains('\x1b'), "{text}");
}

#[test]
fn info_lists_definitions_and_counts_what_is_shown() {
    let bench = LOFTSMAN.bench();
    let text = r#"{ "loftsman": 1,
      "definitions": [ { "name": "bolt", "objects": [ { "name": "head", "cloud": { "points": [[0, 0, 0], [1, 2, 4]] } } ] } ],
      "objects": [ { "name": "left", "instance": { "definition": "bolt" } },
                   { "name": "right", "instance": { "definition": "bolt" }, "transform":
                     [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]] } ] }"#;
    bench.write("a.loft.json", text);
    let info = bench.json(&["info", "a.loft.json"]);
    assert_eq!((info["shown"].as_u64(), info["objects"][1]["shows"].as_str()), (Some(4), Some("bolt")));
    assert_eq!(info["definitions"][0]["objects"][0]["vertices"].as_u64(), Some(2));
    assert!(info["objects"][1].get("vertices").is_none());
    let text = bench.done(&["info", "a.loft.json"]);
    for words in
        ["2 objects", "1 definition", "4 shown", "instance", "of bolt", "definition bolt", "2 points"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    // Flat where a format has none.
    bench.done(&["convert", "a.loft.json", "a.xyz"]);
    let rows = String::from_utf8(bench.read("a.xyz")).unwrap();
    assert!(rows.contains("left/head") && rows.contains("right/head") && rows.contains("\n6 2 4"), "{rows}");
}

#[test]
fn numbers_in_json_read_back_exactly() {
    let bench = LOFTSMAN.bench();
    let third = 1.0 / 3.0 * 1e-7;
    bench.write("a.loft.json", WAVE.replace("[1, 1, 0]", &format!("[1, {third}, -1e-300]")));
    bench.done(&["convert", "a.loft.json", "b.loft.json"]);
    let document: serde_json::Value = serde_json::from_slice(&bench.read("b.loft.json")).unwrap();
    let point = &document["objects"][0]["curve"]["points"][1];
    assert_eq!((point[1].as_f64(), point[2].as_f64()), (Some(third), Some(-1e-300)));
}

#[test]
fn the_standard_streams_are_files_too() {
    let bench = LOFTSMAN.bench().with_wave();
    let obj = bench.done(&["convert", "wave.loft.json", "-", "--to", "obj"]);
    assert!(obj.contains("o wave"), "{obj}");
    let info = bench.feed(&["info", "-", "--json"], WAVE.as_bytes());
    assert_eq!(info.code, Some(0), "{}", info.err);
    let back = bench.feed(&["convert", "-", "back.loft.json", "--from", "obj"], obj.as_bytes());
    assert_eq!(back.code, Some(0), "{}", back.err);
    assert_eq!(bench.json(&["info", "back.loft.json"])["objects"][0]["name"], "wave");
    bench.fails(&["convert", "wave.loft.json", "-"], 2, &["--to"]);
    bench.fails(&["convert", "wave.loft.json", "-", "--to", "glb"], 2, &["plain"]);
    bench.fails(&["convert", "wave.loft.json", "-", "--to", "obj", "--json"], 2, &["--json"]);
}

#[test]
fn exit_status_2_is_for_the_command_line() {
    let bench = LOFTSMAN.bench().with_wave();
    for arguments in [
        &["frobnicate"][..],
        &["convert"],
        &["convert", "wave.loft.json"],
        &["convert", "wave.loft.json", "b.obj", "--unit", "furlong"],
        &["convert", "wave.loft.json", "b.obj", "--up", "w"],
        &["convert", "wave.loft.json", "b.obj", "--tolerance", "0"],
        &["convert", "wave.loft.json", "b.obj", "--tolerance", "nan"],
        &["convert", "wave.loft.json", "b.unheard-of"],
        &["convert", "wave.loft.json", "--to", "obj", "--into", ".", "--jobs", "0"],
        &["plot", "wave.loft.json", "b.obj"],
        &["run", "wave.loft.json", "--solver", "householder"],
        &["plugins", "positon"],
        &["completions", "cobol"],
    ] {
        bench.fails(arguments, 2, &[]);
    }
    bench.fails(&["run", "r.toml", "--solver", "householder"], 2, &["householder-qr"]);
    bench.fails(&["plugins", "positon"], 2, &["position"]);
    bench.fails(&["convert", "wave.loft.json", "b.obj", "--unit", "milimetre"], 2, &["mm"]);
    // Without a command, help is what is wanted; it is not an output, and not a success.
    assert_eq!(bench.run(&[]).code, Some(2));
    assert!(bench.done(&["--help"]).contains("Exit status"));
}

#[test]
fn plugins_lists_everything_with_its_fields() {
    let bench = LOFTSMAN.bench();
    let known = bench.json(&["plugins"]);
    for (list, name) in [
        ("formats", "obj"),
        ("operations", "edit"),
        ("operations", "fit"),
        ("constraints", "position"),
        ("constraints", "curvature"),
    ] {
        let entry = known[list].as_array().unwrap().iter().find(|e| e["name"] == name);
        assert!(entry.is_some_and(|e| !e["help"].as_str().unwrap().is_empty()), "{list} {name}");
    }
    assert!(known["solvers"].as_array().unwrap().iter().any(|s| s == "householder-qr"));
    let text = bench.done(&["plugins", "edit"]);
    assert!(text.contains("constraints") && text.contains("solver"), "{text}");
    // What words stand for that a field takes is told where they are used, and alone.
    let location = "location  a place on a shape: a number, the parameter of a curve";
    for (name, says) in [("simulate", true), ("location", true), ("words", true), ("line", false)] {
        let text = bench.done(&["plugins", name]);
        assert_eq!(text.contains(location), says, "{name}: {text}");
    }
    let text = bench.done(&["plugins", "document"]);
    assert!(text.contains("    rate  a number, frames a second\n") && !text.contains(location), "{text}");
    // What other programs call otherwise, and what the help of others speaks of.
    let others = [
        ("mirror", "loftsman plugins symmetrize"),
        ("Slice", "loftsman plugins section"),
        ("seams", "speak"),
        ("Fillet", "for a CAD program"),
        ("decimate", "for Blender or MeshLab"),
    ];
    for (name, ours) in others {
        bench.fails(&["plugins", name], 2, &["nothing is called", ours]);
    }
    // Formats are found by the endings of their files, and the formats of pictures have the fields of pictures.
    for (ending, name) in [("glb", "gltf"), (".STP", "step"), ("obj", "obj")] {
        let formats = bench.json(&["plugins", ending])["formats"].clone();
        assert!(formats.as_array().unwrap().len() == 1 && formats[0]["name"] == name, "{ending}: {formats}");
    }
    let picture = bench.json(&["plugins", "picture"]);
    assert!(picture["picture"].to_string().contains("parameters"), "{picture}");
    for ending in ["svg", "png", ".png"] {
        assert_eq!(bench.json(&["plugins", ending]), picture, "{ending}");
    }
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let bench = LOFTSMAN.bench();
    let mut child = bench.command(&["plugins", "--json"]).spawn().unwrap();
    let mut first = [0; 1];
    let mut out = child.stdout.take().unwrap();
    out.read_exact(&mut first).unwrap();
    drop(out);
    let end = child.wait_with_output().unwrap();
    assert_eq!(end.status.code(), Some(0));
    assert_eq!(end.stderr, b"");
}

#[test]
fn every_shell_gets_completions() {
    let bench = LOFTSMAN.bench();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(bench.done(&["completions", shell]).contains("loftsman"), "{shell}");
    }
}

#[test]
fn points_become_a_curve_and_curves_a_picture() {
    let bench = LOFTSMAN.bench().with_wave();
    let rows: String = (0..=60).map(|i| f64::from(i) * 0.1).map(|x| format!("{x} {}\n", x.sin())).collect();
    bench.write("sine.dat", rows);
    let report = bench.json(&["fit", "sine.dat", "sine.loft.json", "--tolerance", "1e-4"]);
    assert_eq!(report["steps"][0]["op"], "fit");
    let curve = &bench.json(&["info", "sine.loft.json"])["objects"][0];
    assert_eq!((curve["type"].as_str(), curve["degree"].as_u64()), (Some("curve"), Some(3)));
    assert!(curve["vertices"].as_u64().unwrap() < 30, "{curve}");
    bench.done(&["fit", "sine.dat", "sine.svg", "--vertices", "8", "--degree", "2"]);
    let svg = String::from_utf8(bench.read("sine.svg")).unwrap();
    assert!(svg.contains("id=\"clouds\"") && svg.contains("points of sine"), "{svg}");
    bench.fails(&["fit", "wave.loft.json", "a.obj"], 1, &["wave.loft.json", "points"]);
    bench.fails(&["fit", "sine.dat", "a.obj", "--degree", "26"], 2, &["26"]);
    bench.fails(&["fit", "sine.dat", "a.obj", "--object", "sinus"], 1, &["sine"]);
    bench.fails(&["fit", "sine.dat", "a.obj", "--tolerance", "-1"], 2, &[]);
    for out in ["a.svg", "a.png"] {
        bench.done(&["plot", "wave.loft.json", out, "--dark", "--view", "top", "--pixels", "400"]);
    }
    assert!(bench.read("a.svg").starts_with(b"<?xml") && bench.read("a.png").starts_with(b"\x89PNG"));
    let all = ["--view", "all", "--profile=parameter", "--title", "Wave", "--columns", "2"];
    bench.done(&[&["plot", "wave.loft.json", "all.svg", "--before", "sine.loft.json"], &all[..]].concat());
    let svg = String::from_utf8(bench.read("all.svg")).unwrap();
    for words in [">perspective<", ">right<", ">parameter u<", ">Wave<", "id=\"curves-5\""] {
        assert!(svg.contains(words), "{words}");
    }
    bench.fails(&["plot", "wave.loft.json", "b.svg", "--object", "wafe"], 1, &["wafe", "did you mean"]);
    bench.fails(&["plot", "wave.loft.json", "b.svg", "--view", "bottom"], 2, &["perspective"]);
}

#[test]
fn fit_has_every_option_of_the_operation() {
    let bench = LOFTSMAN.bench();
    let known = bench.json(&["plugins"]);
    let operation = known["operations"].as_array().unwrap().iter().find(|o| o["name"] == "fit").unwrap();
    let help = bench.done(&["fit", "--help"]);
    let fields = operation["fields"].as_array().unwrap();
    assert!(fields.len() >= 17, "{fields:?}");
    for field in fields {
        let option = format!("--{}", field["name"].as_str().unwrap().replace('_', "-"));
        let listed = |line: &str| line.trim_start().split([' ', '[', '=']).any(|word| word == option);
        assert!(help.lines().any(listed), "{option} is no option of `loftsman fit`\n{help}");
    }
    // They arrive.
    let rows: String =
        (0..=40).map(|i| f64::from(i) * 0.1).map(|x| format!("{x} {}\n", (x - 2.0).abs())).collect();
    bench.write("roof.dat", rows);
    let fit = |more: &[&str]| {
        bench.json(&[&["fit", "roof.dat", "roof.loft.json"], more].concat())["steps"][0].clone()
    };
    let notes = |step: &serde_json::Value| step["notes"].to_string();
    let cornered = fit(&["--corners", "30"]);
    assert!(notes(&cornered).contains("corner"), "{cornered}");
    assert!(notes(&fit(&["--corners", "auto"])).contains("corner"));
    let held = fit(&[
        "--constraints",
        "{ kind = \"position\", at = 0.25, to = [1.0, 1.1, 0.0] }",
        "--constraints",
        r#"{"kind": "position", "at": 0.75, "to": [3.0, 1.1, 0.0]}"#,
        "--corrections",
        "0",
        "--parameters",
        "centripetal",
        "--relative-tolerance",
        "0.1",
        "--smooth=false",
        "--regularization",
        "1e-9",
        "--ends",
        "free",
        "--best-effort",
        "--closed=false",
    ]);
    assert_eq!(held["constraints"].as_array().map(Vec::len), Some(2), "{held}");
    assert!(
        notes(&fit(&["--interpolate", "--merge", "--ends", "not-a-knot"])).contains("41 control vertices")
    );
    let weights = ["1"; 41].join(",");
    let parameters: Vec<String> = (0..41).map(|i| i.to_string()).collect();
    fit(&["--weights", &weights, "--parameters", &parameters.join(","), "--vertices", "12"]);
    bench.fails(&["fit", "roof.dat", "a.obj", "--constraints", "position"], 2, &["table"]);
    bench.fails(&["fit", "roof.dat", "a.obj", "--corners", "sharp"], 2, &["--corners"]);
    bench.fails(&["fit", "roof.dat", "a.obj", "--weights", "1,2"], 1, &["weight"]);
}

#[test]
fn plot_and_fit_report_to_programs_and_warn_of_what_is_missing() {
    let bench = LOFTSMAN.bench().with_wave();
    let plotted = bench.json(&["plot", "wave.loft.json", "wave.svg"]);
    assert_eq!(
        (plotted["input"].as_str(), plotted["output"].as_str()),
        (Some("wave.loft.json"), Some("wave.svg"))
    );
    assert_eq!(plotted["bytes"].as_u64(), Some(bench.read("wave.svg").len() as u64));
    assert_eq!(plotted["format"].as_str(), Some("loft"));
    assert!(plotted["report"]["kept"].as_u64().unwrap() > 0);
    // How a line is displayed is left out.
    bench.write("part.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 1 0\nbevel on\nl 1 2 3 4\n");
    let run = bench.run(&["convert", "part.obj", "part.loft.json", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let warning = run.err;
    assert!(warning.starts_with("warning: part.obj: left out"), "{warning}");
    std::fs::create_dir(bench.path("out")).unwrap();
    for arguments in [
        &["plot", "part.obj", "part.svg", "--json"][..],
        &["fit", "part.obj", "fit.loft.json", "--degree", "2", "--json"],
        &["convert", "part.obj", "--to", "loft.json", "--into", "out"],
    ] {
        let run = bench.run(arguments);
        assert_eq!((run.code, run.err.as_str()), (Some(0), warning.as_str()), "{arguments:?}");
    }
}

#[test]
fn fineness_that_nothing_needs_is_told() {
    let bench = LOFTSMAN.bench().with_wave();
    let said = "nothing was tessellated, so that the tolerance or angle asked for changes nothing";
    for (option, value) in [("--tolerance", "0.1"), ("--tolerance", "0.1%"), ("--angle", "5")] {
        let text = bench.done(&["convert", "wave.loft.json", "o.loft.json", option, value]);
        assert!(text.contains(said), "{option} {value}: {text}");
        let report = bench.json(&["convert", "wave.loft.json", "o.loft.json", option, value]);
        assert_eq!(report["notes"], serde_json::json!([said]), "{option} {value}");
        let piped = bench.run(&["convert", "wave.loft.json", "-", "--to", "loft.json", option, value]);
        assert!(piped.code == Some(0) && piped.err.contains(said), "{}", piped.err);
        let used = bench.done(&["convert", "wave.loft.json", "o.glb", option, value]);
        assert!(!used.contains(said), "{used}");
    }
    assert!(!bench.done(&["convert", "wave.loft.json", "o.loft.json"]).contains(said));
    let recipe = |outputs: &str| {
        bench.write("r.toml", format!("input = 'wave.loft.json'\noutput = [{outputs}]\ntolerance = '1%'\n"));
        bench.done(&["run", "r.toml"])
    };
    assert!(recipe("'o.loft.json'").contains(said));
    assert!(recipe("'o.loft.json', 'w.svg'").contains(said));
    assert!(!recipe("'o.loft.json', 'o.glb'").contains(said));
}
