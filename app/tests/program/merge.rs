//! The operation `merge`: further files of a recipe, and what is wrong with them.

use serde_json::json;

use crate::LOFTSMAN;

/// A straight line of some length along x, in a unit.
fn line(name: &str, unit: &str, length: f64) -> String {
    let points = json!([[0, 0, 0], [length, 0, 0]]);
    let curve = json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1], "points": points });
    json!({ "loftsman": 1, "unit": unit, "objects": [{ "name": name, "curve": curve }] }).to_string()
}

#[test]
fn files_join_the_scene_as_it_is_at_their_step() {
    let bench = LOFTSMAN.bench();
    bench.write("parts/beam.loft.json", line("beam", "mm", 2000.0));
    bench.write("parts/points.csv", "0,0,0\n1,2,3\n2,3,5\n");
    bench.write("deck.loft.json", line("beam", "m", 3.0));
    // Relative to the recipe, whose folder is not the one that the program runs in.
    bench.write(
        "parts/r.toml",
        "input = '../deck.loft.json'\noutput = '../all.loft.json'\n\
         [[step]]\nop = 'rename'\nobject = 'beam'\nto = 'deck'\n\
         [[step]]\nop = 'merge'\nfile = 'beam.loft.json'\n\
         [[step]]\nop = 'merge'\nfile = ['beam.loft.json', 'points.csv']\nunit = 'mm'\n",
    );
    let report = bench.json(&["run", "parts/r.toml"]);
    let notes = report["steps"][1]["notes"].to_string();
    assert!(notes.contains("1 object of beam.loft.json (loft)") && !notes.contains("taken"), "{notes}");
    let notes = report["steps"][2]["notes"].to_string();
    assert!(
        notes.contains("the object \\\"beam\\\" is \\\"beam.001\\\" here: its name was taken"),
        "{notes}"
    );
    let files = &report["steps"][2]["numbers"]["files"];
    let beam = json!({ "file": "beam.loft.json", "format": "loft", "objects": 1, "renamed": { "beam": "beam.001" }, "left_out": 0 });
    assert_eq!((&files[0], &files[1]["objects"]), (&beam, &json!(1)), "{files}");
    let info = bench.json(&["info", "all.loft.json"]);
    let objects = info["objects"].as_array().unwrap();
    let of = |name: &str, what: &str| objects.iter().find(|o| o["name"] == name).unwrap()[what].clone();
    assert_eq!((objects.len(), &info["unit"]), (4, &json!("m")), "{info}");
    assert_eq!((of("deck", "length"), of("beam", "length")), (json!(3.0), json!(2.0)), "{info}");
    // What has no unit is in the one that the step gives it.
    let read = loftsman::read_scene(bench.path("all.loft.json")).unwrap();
    let points = read.object("points").unwrap().geometry().points();
    assert!((points[2].z - 0.005).abs() < 1e-15, "{points:?}");
}

/// A file without a unit is told with what gives it one, and that does: not the recipe's `unit` where it has one.
#[test]
fn the_unit_that_is_missing_is_asked_for_where_it_helps() {
    let bench = LOFTSMAN.bench();
    bench.write("points.csv", "0,0,0\n1,2,3\n2,3,5\n");
    bench.write("beam.loft.json", line("beam", "m", 3.0));
    let notes = |recipe: &str| {
        bench.write("r.toml", recipe);
        bench.json(&["run", "r.toml"])["steps"][0]["notes"].to_string()
    };
    let recipe = "unit = 'mm'\noutput = 'o.loft.json'\n[[step]]\nop = 'merge'\nfile = 'points.csv'\n";
    let told = notes(recipe);
    assert!(told.contains("no unit") && told.contains("give this step a `unit`"), "{told}");
    let told = notes(&format!("{recipe}unit = 'mm'\n"));
    assert!(!told.contains("no unit"), "{told}");
    let recipe = "output = 'o.loft.json'\n[[step]]\nop = 'merge'\nfile = 'beam.loft.json'\n";
    let told = notes(&format!("input = 'points.csv'\n{recipe}"));
    assert!(told.contains("no unit") && told.contains("give the recipe a `unit`"), "{told}");
    let told = notes(&format!("input = 'points.csv'\nunit = 'mm'\n{recipe}"));
    assert!(!told.contains("no unit"), "{told}");
}

#[test]
fn a_file_that_cannot_join_is_refused_with_its_place() {
    let bench = LOFTSMAN.bench();
    bench.write("a.loft.json", line("a", "m", 1.0));
    bench.write("torn.loft.json", "{ \"loftsman\": 1, ");
    bench.write("text.zzz", "nothing that is known\n");
    std::fs::create_dir(bench.path("folder")).unwrap();
    let recipe = |fields: &str| {
        format!("input = 'a.loft.json'\noutput = 'o.loft.json'\n[[step]]\nop = 'merge'\n{fields}\n")
    };
    for (fields, words) in [
        ("", &["step[0]", "the field \"file\" is missing"][..]),
        ("file = 'none.obj'", &["step[0].file", "none.obj: there is no such file"]),
        ("file = ['a.loft.json', 'none.obj']", &["step[0].file[1]", "none.obj: there is no such file"]),
        ("file = 'folder'", &["step[0].file", "is a folder"]),
        ("file = 'torn.loft.json'", &["step[0].file", "torn.loft.json"]),
        ("file = 'text.zzz'", &["step[0].file", "text.zzz"]),
        ("file = []", &["step[0].file", "no file is named"]),
        ("file = 3", &["step[0].file", "3 where a text is needed"]),
        ("file = ['a.loft.json', 3]", &["step[0].file[1]", "a file name is needed here"]),
        ("file = 'a.loft.json'\nunit = 'parsec'", &["step[0].unit", "unknown unit \"parsec\""]),
        ("file = 'a.loft.json'\nread = { no = 1 }", &["step[0]", "\"no\""]),
        ("file = 'a.loft.json'\nfiles = 'a.loft.json'", &["step[0]", "unknown field \"files\"", "file"]),
    ] {
        bench.write("r.toml", recipe(fields));
        bench.fails(&["run", "r.toml"], 1, words);
        assert!(!bench.path("o.loft.json").exists(), "{fields}");
    }
    // What is read is not written over.
    bench.write(
        "r.toml",
        "input = 'a.loft.json'\noutput = 'b.loft.json'\n[[step]]\nop = 'merge'\nfile = 'b.loft.json'\n",
    );
    bench.write("b.loft.json", line("b", "m", 1.0));
    bench.fails(&["run", "r.toml"], 1, &["b.loft.json"]);
    assert!(String::from_utf8(bench.read("b.loft.json")).unwrap().contains("\"b\""));
}

/// A place that is pointed at wherever a parameter stands, at sizes whose squares are no numbers, too.
#[test]
fn places_are_pointed_at_wherever_parameters_stand() {
    let bench = LOFTSMAN.bench();
    for size in [1.0, 1e155, 1e-200] {
        let points: Vec<_> = [[0.0, 0.0], [1.0, 2.0], [2.0, -1.0], [3.0, 2.0], [4.0, 0.0]]
            .map(|[x, y]| json!([x * size, y * size, 0]))
            .to_vec();
        let net: Vec<_> = [[0, 0, 0], [0, 4, 0], [2, 0, 0], [2, 4, 0]]
            .chunks(2)
            .map(|row| row.iter().map(|p| json!(p.map(|c| f64::from(c) * size))).collect::<Vec<_>>())
            .collect();
        let side = json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1] });
        let document = json!({ "loftsman": 1, "objects": [
            { "name": "c", "curve": { "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 2, 2, 2, 2], "points": points } },
            { "name": "s", "surface": { "u": side, "v": side, "points": net } },
        ] });
        bench.write("a.loft.json", document.to_string());
        let place = |x: f64, y: f64| json!({ "closest": [x * size, y * size, 0] });
        let step = json!([
            { "op": "refine", "object": "c", "knots": [0.25, place(2.0, 0.3)] },
            { "op": "edit", "object": "c", "within": [0.25, place(4.0, 0.0)],
              "constraints": [{ "kind": "position", "at": place(2.0, 0.3), "by": [0, 0.1 * size, 0] }] },
            { "op": "isocurve", "object": "s", "u": [place(0.5, 1.0), 0.75], "v": place(0.5, 1.0) },
        ]);
        bench.write(
            "r.json",
            json!({ "input": "a.loft.json", "output": "o.loft.json", "step": step }).to_string(),
        );
        let report = bench.json(&["run", "r.json"]);
        let said = report["steps"].to_string();
        for told in [
            "knots[1] = 1 on",
            "within[1] = 2 on",
            "constraints[0].at = 1 on",
            "u[0] = 0.25 on",
            "v = 0.25 on",
        ] {
            assert!(said.contains(told), "{size:e}: {told}: {said}");
        }
    }
}

/// An interval of a closed curve does not run over its seam; what is told of that, done, works.
#[test]
fn an_interval_over_a_seam_is_told_how_it_can_be() {
    let bench = LOFTSMAN.bench();
    let circle = json!({ "op": "circle", "radius": 1, "name": "c" });
    let edit = |within: [f64; 2], at: f64| {
        json!({ "op": "edit", "object": "c", "within": within,
            "constraints": [{ "kind": "position", "at": at, "by": [0.1, 0.1, 0] }] })
    };
    for (within, at) in [([6.0, 0.5], 0.1), ([6.0, 6.7], 6.5)] {
        bench.write(
            "r.json",
            json!({ "output": "o.loft.json", "step": [circle, edit(within, at)] }).to_string(),
        );
        bench.fails(
            &["run", "r.json"],
            1,
            &["simplify with periodic = true, then split where it is to begin"],
        );
    }
    let begin = [
        json!({ "op": "simplify", "object": "c", "periodic": true }),
        json!({ "op": "split", "object": "c", "at": 3.0 }),
    ];
    let [first, second] = begin;
    let steps = json!([circle, first, second, edit([6.0, 6.7], 6.5)]);
    bench.write("r.json", json!({ "output": "o.loft.json", "step": steps }).to_string());
    bench.done(&["run", "r.json"]);
}

/// The unit of a recipe without an input is that of the numbers that it gives, whatever goes out: a format that fixes its unit gets them
/// converted. Who asks for numbers in another unit gets them, and is told how others take them.
#[test]
fn the_unit_of_a_recipe_without_input_is_converted() {
    let bench = LOFTSMAN.bench();
    let recipe = json!({ "output": ["c.glb", "c.obj", "c.step", "c.loft.json"], "unit": "mm", "step": [{ "op": "circle", "radius": 30 }] });
    bench.write("c.json", recipe.to_string());
    let told = bench.done(&["run", "c.json"]);
    assert!(!told.contains("other programs take them"), "{told}");
    // What other programs see: the largest coordinate of the GLB's own numbers.
    let reach = |file: &str| {
        let bytes = bench.read(file);
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let root: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        root["accessors"][0]["max"][0].as_f64().unwrap()
    };
    assert!((reach("c.glb") / 0.03 - 1.0).abs() < 1e-6, "{}", reach("c.glb"));
    // And what comes back is as it was said, in every format.
    for file in ["c.glb", "c.obj", "c.step", "c.loft.json"] {
        let info = bench.json(&["info", file]);
        let length = info["objects"][0]["length"].as_f64().unwrap();
        assert!((length / (std::f64::consts::TAU * 30.0) - 1.0).abs() < 1e-6, "{file}: {length}");
        assert_eq!(info["unit"], "mm", "{file}");
    }
    let told = bench.done(&["convert", "c.loft.json", "mm.glb", "--unit", "mm"]);
    assert!((reach("mm.glb") / 30.0 - 1.0).abs() < 1e-6, "{}", reach("mm.glb"));
    assert!(
        told.contains("numbers go out in the unit mm, as asked for, and other programs take them for m"),
        "{told}"
    );
}
