//! Recipes: what they do, what they report, and what is said when they are wrong.

use serde_json::{Value, json};

use crate::LOFTSMAN;

const EDIT: &str = r#"
input = "wave.loft.json"
output = ["a.loft.json", "a.obj", "a.glb", "a.svg", "a.png"]

[[step]]
op = "edit"
object = "wave"
constraints = [
  { kind = "position", at = 2.5, by = [0.0, 0.5, 0.0] },
  { kind = "position", at = 0, keep = true },
  { kind = "tangent", at = 0, keep = true },
]
"#;

#[test]
fn an_edit_reports_what_it_did_and_writes_every_output() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("r.toml", EDIT);
    let report = bench.json(&["run", "r.toml"]);
    let step = &report["steps"][0];
    assert_eq!((step["op"].as_str(), step["object"].as_str()), (Some("edit"), Some("wave")));
    assert!(step["solver"].is_string() && step["equations"].is_u64() && step["rank"].is_u64(), "{step}");
    assert!(step["residual"].as_f64().unwrap() < 1e-12, "{step}");
    assert!(step["adjustment"].as_f64().unwrap() > 0.1, "{step}");
    let outputs = report["outputs"].as_array().unwrap();
    assert_eq!(outputs.len(), 5);
    for output in outputs {
        let path = std::path::Path::new(output["path"].as_str().unwrap());
        let name = path.file_name().unwrap().to_str().unwrap();
        assert_eq!(output["bytes"].as_u64().unwrap(), bench.read(name).len() as u64, "{name}");
    }
    assert!(bench.read("a.svg").starts_with(b"<") && bench.read("a.png").starts_with(b"\x89PNG"));
    // Here and there alike: the same point has moved by what was asked.
    let document: Value = serde_json::from_slice(&bench.read("a.loft.json")).unwrap();
    let start = document["objects"][0]["curve"]["points"][0].as_array().unwrap();
    assert!(start.iter().all(|c| c.as_f64() == Some(0.0)), "{start:?}");
    let text = bench.done(&["run", "r.toml"]);
    assert!(text.contains("edit \"wave\"") && text.contains("residual") && text.contains("a.png"), "{text}");
}

#[test]
fn the_same_recipe_in_json_gives_the_same_bytes() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("r.toml", EDIT);
    bench.done(&["run", "r.toml"]);
    let outputs = ["a.loft.json", "a.obj", "a.glb", "a.svg", "a.png"];
    let first: Vec<_> = outputs.map(|f| bench.read(f)).into();
    bench.write(
        "r.json",
        r#"{ "input": "wave.loft.json", "output": ["a.loft.json", "a.obj", "a.glb", "a.svg", "a.png"],
             "step": [{ "op": "edit", "object": "wave", "constraints": [
                { "kind": "position", "at": 2.5, "by": [0, 0.5, 0] },
                { "kind": "position", "at": 0, "keep": true }, { "kind": "tangent", "at": 0, "keep": true } ] }] }"#,
    );
    bench.done(&["run", "r.json"]);
    assert_eq!(first, outputs.map(|f| bench.read(f)));
}

#[test]
fn a_location_that_floats_comes_to_rest_where_the_change_is_least() {
    let bench = LOFTSMAN.bench().with_wave();
    let step = |place: &str| {
        EDIT.replace("at = 2.5, by = [0.0, 0.5, 0.0]", &format!("{place}, to = [3.0, 1.0, 0.0]"))
    };
    let adjusted = |place: &str| {
        bench.write("r.toml", step(place));
        bench.json(&["run", "r.toml"])["steps"][0].clone()
    };
    let floated = adjusted("near = 2.5");
    let told = &floated["constraints"][0];
    assert_eq!(told["name"], "position near 2.5");
    let u = told["location"][0].as_f64().unwrap();
    let least = floated["adjustment"].as_f64().unwrap();
    // In the note to six figures, in full beside the constraint.
    let notes = floated["notes"].to_string();
    let noted = notes.split("position near 2.5: it holds at ").nth(1).unwrap().split('"').next().unwrap();
    assert!(noted.len() <= 7 && (noted.parse::<f64>().unwrap() - u).abs() < 1e-5, "{floated}");
    // The curve is there, by its own evaluator; at rest there it costs the same, and beside it more.
    let near = |at: f64| adjusted(&format!("at = {at}"))["adjustment"].as_f64().unwrap();
    assert!((near(u) - least).abs() < 1e-9 * least);
    assert!(near(u + 0.01) > least && near(u - 0.01) > least && near(2.5) > least);
    for place in ["at = 2.5, near = 2.5", "scale = 2.0"] {
        bench.write("r.toml", step(place));
        bench.fails(&["run", "r.toml"], 1, &["constraints[0]"]);
    }
}

#[test]
fn the_command_line_replaces_outputs_and_solver() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("recipes/r.toml", EDIT.replace("wave.loft.json", "../wave.loft.json"));
    let report = bench.json(&["run", "recipes/r.toml", "-o", "b.obj", "-o", "b.loft.json", "--solver", "lu"]);
    assert_eq!(report["steps"][0]["solver"], "lu");
    assert_eq!(bench.files(), ["b.loft.json", "b.obj", "recipes", "recipes/r.toml", "wave.loft.json"]);
}

#[test]
fn every_solver_agrees() {
    let bench = LOFTSMAN.bench().with_wave();
    // The adjoint is for small systems: six equations it takes, the tangent's two more it leaves to others.
    bench.write("r.toml", EDIT.replace("  { kind = \"tangent\", at = 0, keep = true },\n", ""));
    let before = bench.files();
    let comparison = bench.json(&["compare", "r.toml"]);
    assert!(comparison["agreement"].as_f64().unwrap() < 1e-12, "{comparison}");
    let solvers = comparison["solvers"].as_array().unwrap();
    assert!(solvers.len() >= 4);
    for trial in solvers {
        assert!(trial["error"].is_null(), "{trial}");
        assert!(trial["steps"][0]["residual"].as_f64().unwrap() < 1e-12);
    }
    assert_eq!(bench.files(), before);
    assert!(bench.done(&["compare", "r.toml"]).contains("agree"));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let bench = LOFTSMAN.bench().with_wave();
    let good = "{ kind = 'position', at = 2.5, by = [0, 1, 0] }";
    let step = |fields: &str| {
        format!(
            "input = 'wave.loft.json'\noutput = 'a.obj'\n[[step]]\nop = 'edit'\nobject = 'wave'\n{fields}\n"
        )
    };
    let constraint = |fields: &str| step(&format!("constraints = [{good},\n {{ {fields} }}]"));
    let cases: &[(String, &[&str])] = &[
        ("inptu = 'wave.loft.json'".into(), &["inptu", "did you mean \"input\"?"]),
        ("steps = []".into(), &["steps", "did you mean \"step\"?"]),
        ("input = 3".into(), &["r.toml, line 1", "input"]),
        ("input = 'gone.obj'".into(), &["gone.obj", "no such file"]),
        ("output = [1]".into(), &["output[0]"]),
        ("tolerance = -1".into(), &["tolerance"]),
        ("unit = 'furlong'".into(), &["unit"]),
        ("[[step]]\nobject = 'wave'".into(), &["step[0]", "\"op\" is missing"]),
        (step("").replace("'edit'", "'edti'"), &["line 4", "step[0].op", "did you mean \"edit\"?"]),
        (step("constrants = []"), &["step[0]", "did you mean \"constraints\"?"]),
        (
            step(&format!("constraints = [{good}]\nsolver = 'householder'")),
            &["line 7", "step[0].solver", "householder-qr"],
        ),
        (step(&format!("constraints = [{good}]\nmetric = 'leest'")), &["line 7", "metric", "least"]),
        (
            step(&format!("constraints = [{good}]")).replace("object = 'wave'", "object = 'wvae'"),
            &["wvae", "wave"],
        ),
        (step(&format!("constraints = [{good}]\nlock = [0, 1, 2, 3, 4, 5, 6, 7]")), &["step[0]"]),
        (
            constraint("kind = 'positon', at = 1, keep = true"),
            &["line 7", "step[0].constraints[1]", "did you mean \"position\"?"],
        ),
        (
            constraint("kind = 'position', at = 1, to = [0, 0, 0], by = [0, 0, 0]"),
            &["step[0].constraints[1]", "to", "by"],
        ),
        (constraint("kind = 'position', at = 1"), &["step[0].constraints[1]", "keep"]),
        (constraint("kind = 'position', at = 5.5, keep = true"), &["step[0].constraints[1]", "outside"]),
        (constraint("kind = 'position', at = [1, 2], keep = true"), &["step[0].constraints[1]"]),
        (constraint("kind = 'position', at = nan, keep = true"), &["step[0].constraints[1].at", "finite"]),
        (constraint("kind = 'position', at = 2.5, to = [9, 9, 9]"), &["position at 2.5"]),
        (constraint("kind = 'vertex', index = 8, keep = true"), &["step[0].constraints[1]", "8"]),
        (
            constraint("kind = 'derivative', at = 1, order = 1000000000, keep = true"),
            &["step[0].constraints[1]"],
        ),
        (constraint("kind = 'derivative', at = 1, ordr = 1, keep = true"), &["order"]),
        (
            "input = 'wave.loft.json'\noutput = 'a.png'\n[picture]\nobjects = ['wave', 'wvae']\n".into(),
            &[
                "line 4, column 20",
                "picture.objects[1]",
                "the scene has no object \"wvae\"; did you mean \"wave\"?",
            ],
        ),
        (
            "input = 'wave.loft.json'\noutput = 'a.svg'\n[picture]\npanel = [{}, { objects = ['x'] }]\n"
                .into(),
            &["line 4", "picture.panel[1].objects[0]", "the scene has no object \"x\""],
        ),
    ];
    for (recipe, words) in cases {
        bench.write("r.toml", recipe);
        bench.fails(&["run", "r.toml"], 1, &[&["r.toml"], *words].concat());
    }
}

/// A triangle in metres with a picture in a folder of its own, and a wave in millimetres, z up.
#[test]
fn several_inputs_become_one_scene() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("parts/paint.png", b"\x89PNG not looked into");
    bench.write("parts/paint.mtl", "newmtl paint\nKd 1 0.5 0\nmap_Kd paint.png\n");
    bench.write(
        "parts/sail.obj",
        "# Loftsman; unit m, y up\nmtllib paint.mtl\no wave\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 2 0\nvt 0 0\nf 1/1 2/1 3/1\n",
    );
    let recipe =
        "input = [\"wave.loft.json\", \"parts/sail.obj\"]\noutput = [\"all.loft.json\", \"all.glb\"]\n";
    bench.write("r.toml", recipe);
    let report = bench.json(&["run", "r.toml"]);
    assert_eq!(report["input"]["path"].as_str().unwrap().rsplit('/').next(), Some("wave.loft.json"));
    let more = &report["more_inputs"][0];
    assert_eq!(more["format"], "obj");
    let notes = more["notes"].to_string();
    assert!(notes.contains("the object \\\"wave\\\" is \\\"wave.001\\\" here"), "{notes}");
    let all: Value = serde_json::from_slice(&bench.read("all.loft.json")).unwrap();
    let objects = all["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 2);
    assert_eq!((objects[1]["name"].as_str(), objects[1]["label"].as_str()), (Some("wave.001"), Some("wave")));
    // Millimetres, as the first; OBJ's y up is z up here.
    let points: Vec<[f64; 3]> = serde_json::from_value(objects[1]["mesh"]["points"].clone()).unwrap();
    assert_eq!(points, [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [0.0, 0.0, 2000.0]]);
    // The picture comes along although it lies in another folder than the outputs.
    let glb = bench.read("all.glb");
    assert!(glb.windows(16).any(|w| w == b"PNG not looked i"), "the picture is in the glb");
    let text = bench.done(&["run", "r.toml"]);
    assert!(text.contains("read ") && text.contains("sail.obj") && text.contains("wave.001"), "{text}");

    bench.write("bad.toml", "input = [\"wave.loft.json\", \"mast.glb\"]\noutput = \"x.glb\"\n");
    bench.fails(&["run", "bad.toml"], 1, &["input[1]", "mast.glb"]);
    // What is read is never written over.
    bench.write(
        "over.toml",
        "input = [\"wave.loft.json\", \"parts/sail.obj\"]\noutput = \"parts/sail.obj\"\n",
    );
    bench.fails(&["run", "over.toml"], 1, &["sail.obj"]);
}

#[test]
fn a_derivative_above_the_degree_says_what_to_do() {
    let bench = LOFTSMAN.bench().with_wave();
    let recipe = |more: &str, wish: &str| {
        format!(
            "input = \"wave.loft.json\"\noutput = \"o.obj\"\n[[step]]\nop = \"edit\"\nobject = \"wave\"\n{more}constraints = [{{ \
             kind = \"derivative\", at = 2.5, order = 4, {wish} }}]\n"
        )
    };
    let told = "derivative of order 4 at 2.5: derivative 4 of degree 3 is always 0; elevate first";
    // Whatever is asked of it, and whatever is locked.
    for wish in ["by = [0, 1, 0]", "to = [0, 0, 0]", "scale = 2", "keep = true", "at_least = 1, axis = \"x\""]
    {
        for lock in ["", "lock = [0]\n"] {
            bench.write("r.toml", recipe(lock, wish));
            bench.fails(&["run", "r.toml"], 1, &[told]);
        }
    }
}

/// Edges of a cage's surface as curves: along the boundary of an open one run cubic splines, which meet where its vertices come to.
#[test]
fn edges_of_a_cage_are_curves_that_go_round_it() {
    let bench = LOFTSMAN.bench();
    let at = |k: usize| [(k / 4) as f64, (k % 4) as f64, 0.3 * ((k * k) as f64).sin()];
    let mut obj = String::from("o sheet\n");
    for [x, y, z] in (0..16).map(at) {
        obj += &format!("v {x} {y} {z}\n");
    }
    for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
        let corner = 4 * i + j + 1;
        obj += &format!("f {corner} {} {} {}\n", corner + 4, corner + 5, corner + 1);
    }
    bench.write("sheet.obj", obj);
    let mut steps = vec![json!({ "op": "subdivide", "surface": true })];
    steps.extend((0..12).map(|k| json!({ "op": "edge", "object": "sheet", "edge": format!("edge {k}"), "name": format!("rim {k}") })));
    let recipe = |steps: &[Value]| {
        json!({ "input": "sheet.obj", "output": "rims.loft.json", "step": steps }).to_string()
    };
    bench.write("r.json", recipe(&steps)).done(&["run", "r.json"]);
    let document: Value = serde_json::from_slice(&bench.read("rims.loft.json")).unwrap();
    let ends: Vec<[Vec<f64>; 2]> = document["objects"].as_array().unwrap()[1..]
        .iter()
        .map(|object| {
            let curve = &object["curve"];
            assert_eq!(
                (&curve["degree"], curve["knots"].as_array().unwrap().len()),
                (&json!(3), 8),
                "{curve}"
            );
            let points: Vec<Vec<f64>> = serde_json::from_value(curve["points"].clone()).unwrap();
            // Its knots are uniform, and none is repeated.
            [0, 1].map(|k| {
                (0..3).map(|i| (points[k][i] + 4.0 * points[k + 1][i] + points[k + 2][i]) / 6.0).collect()
            })
        })
        .collect();
    assert_eq!(ends.len(), 12);
    // Where vertices of the boundary come to: a corner stays, others are (a + 4b + c) / 6.
    let ring = [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4];
    for (k, &vertex) in ring.iter().enumerate() {
        let [a, b, c] = [ring[(k + 11) % 12], vertex, ring[(k + 1) % 12]].map(at);
        let corner = k % 3 == 0;
        let limit = [0, 1, 2].map(|i| if corner { b[i] } else { (a[i] + 4.0 * b[i] + c[i]) / 6.0 });
        let there = |p: &Vec<f64>| p.iter().zip(limit).all(|(p, q)| (p - q).abs() < 1e-12);
        assert_eq!(ends.iter().flatten().filter(|p| there(p)).count(), 2, "{vertex}: {limit:?} of {ends:?}");
    }
    steps.push(json!({ "op": "edge", "object": "sheet", "edge": "edge 12" }));
    bench.write("r.json", recipe(&steps));
    bench.fails(&["run", "r.json"], 1, &["there is no edge", "12"]);
}

/// Where an operation does not take a cage's surface its message says what makes of it what it takes.
#[test]
fn operations_on_cages_say_what_makes_splines_of_them() {
    let bench = LOFTSMAN.bench();
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    bench.write("Cube.obj", format!("o Cube\n{cube}"));
    for step in [
        json!({ "op": "section", "object": "Cube", "axis": "z", "at": 0.5 }),
        json!({ "op": "isocurve", "object": "Cube", "u": 0.5 }),
        json!({ "op": "symmetrize", "object": "Cube", "normal": [1, 0, 0] }),
        json!({ "op": "reverse", "object": "Cube" }),
        json!({ "op": "fine-tune", "object": "Cube", "alpha": 2 }),
    ] {
        let steps = json!([{ "op": "subdivide", "object": "Cube", "surface": true }, step]);
        let recipe = json!({ "input": "Cube.obj", "output": "o.loft.json", "step": steps });
        bench.write("r.json", recipe.to_string());
        let error = bench.fails(&["run", "r.json"], 1, &["\"Cube\" is a ", "step[1]"]);
        let way = "; patches makes splines of it, tessellate a mesh";
        assert_eq!(error.trim_end().matches(way).count(), 1, "{error}");
    }
    // The cage comes back as quads.
    let steps = json!([{ "op": "subdivide", "surface": true }, { "op": "subdivide", "levels": 0 }]);
    bench.write("r.json", json!({ "input": "Cube.obj", "output": "o.obj", "step": steps }).to_string());
    bench.done(&["run", "r.json"]);
    let text = String::from_utf8(bench.read("o.obj")).unwrap();
    let faces: Vec<&str> = text.lines().filter(|line| line.starts_with("f ")).collect();
    assert_eq!(faces.len(), 6, "{text}");
    assert!(faces.iter().all(|face| face.split(' ').count() == 5), "{text}");
}
