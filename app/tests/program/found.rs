//! What reviewers found, as they ran it: each once, by the program.

use serde_json::json;

use crate::LOFTSMAN;

/// Two cubic pieces that do not meet: an inner knot of multiplicity degree + 1.
const TORN: &str = r#"{"loftsman": 1, "objects": [{"name": "c", "curve": {"degree": 3, "periodic": false,
  "knots": [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2],
  "points": [[0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0], [4, 0, 0], [5, 1, 0], [6, 0, 0], [7, 1, 0]]}}]}"#;

#[test]
fn a_torn_curve_is_drawn_and_converted_in_its_pieces() {
    let bench = LOFTSMAN.bench();
    bench.write("c.loft.json", TORN);
    bench.write("r.toml", "input = 'c.loft.json'\noutput = ['r.svg', 'r.png', 'r.glb', 'r.obj']\n");
    bench.done(&["plot", "c.loft.json", "o.svg", "--profile=arc-length", "--beads", "2"]);
    bench.done(&["run", "r.toml"]);
    let svg = String::from_utf8(bench.read("o.svg")).unwrap();
    let data = svg.split("class=\"curve\"").nth(1).and_then(|s| s.split(" d=\"").nth(1)).unwrap();
    let data = data.split('"').next().unwrap();
    assert_eq!((data.matches('M').count(), data.matches('C').count()), (2, 2), "{data}");
    let said = bench.json(&["convert", "c.loft.json", "o.glb"]);
    assert!(said["objects"][0]["form"].as_str().unwrap().starts_with("2 line strips"), "{said}");
    // What is between the pieces is in no file: both come back with the gap.
    for file in ["o.glb", "r.obj"] {
        bench.done(&["convert", file, "back.loft.json"]);
        let back = bench.json(&["info", "back.loft.json"]);
        assert_eq!(back["objects"][0]["vertices"], 8, "{file}: {back}");
    }
}

#[test]
fn weights_beyond_all_numbers_are_refused_at_once() {
    let bench = LOFTSMAN.bench();
    bench.write(
        "x.obj",
        "v 0 0 0\nv 1 1 0\nv 2 0 0 1e308\nv 3 1 0 1e-308\nv 4 0 0\nv 5 1 0\ncstype rat bspline\ndeg 3\n\
         curv 0 3 1 2 3 4 5 6\nparm u 0 0 0 0 1 2 3 3 3 3\nend\n",
    );
    let start = std::time::Instant::now();
    bench.fails(&["convert", "x.obj", "o.glb"], 1, &["weights", "more alike"]);
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn thousands_of_instances_in_one_place_are_drawn_in_seconds() {
    let bench = LOFTSMAN.bench();
    let bin = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";
    let list = |one: &dyn Fn(usize) -> String| (0..5000).map(one).collect::<Vec<_>>().join(",");
    bench.write(
        "x.gltf",
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [{}]}}],
            "nodes": [{}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
            {{"bufferView": 0, "byteOffset": 36, "componentType": 5121, "count": 3, "type": "SCALAR"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 40}}],
            "buffers": [{{"byteLength": 40, "uri": "data:;base64,{bin}"}}]}}"#,
            list(&|k| k.to_string()),
            list(&|_| r#"{"mesh": 0}"#.to_owned()),
        ),
    );
    let start = std::time::Instant::now();
    bench.done(&["plot", "x.gltf", "o.png", "--pixels", "200"]);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn solvers_are_compared_by_what_can_be_compared() {
    let bench = LOFTSMAN.bench();
    let circle: Vec<String> = (0..8)
        .map(|k| std::f64::consts::TAU * f64::from(k) / 8.0)
        .map(|a| format!("[{:?}, {:?}, 0]", a.cos(), a.sin()))
        .collect();
    bench.write(
        "c.loft.json",
        format!(
            r#"{{"loftsman": 1, "objects": [{{"name": "p", "curve": {{"degree": 3, "periodic": true,
            "knots": [0, 1, 2, 3, 4, 5, 6, 7, 8], "points": [{}]}}}}]}}"#,
            circle.join(", ")
        ),
    );
    let recipe = |fill: &str| {
        format!(
            r#"{{"input": "c.loft.json", "output": "o.loft.json", "step": [{{"op": "edit", "object": "p", "constraints": [
            {{"kind": "position", "at": 1.3, "by": [0.1, 0, 0]}}, {{"kind": "position", "at": 4.3, "by": [0.1, 0, 0]}}]}}{fill}]}}"#
        )
    };
    bench.write("r.json", recipe(r#", {"op": "fill", "objects": ["p"], "size": 0.05}"#));
    bench.write("plain.json", recipe(""));
    let plain = bench.json(&["compare", "plain.json"]);
    assert!(plain["agreement"].as_f64().unwrap() < 1e-12 && plain["unlike"].is_null(), "{plain}");
    // Rounding may make other triangles of the fill: then that is said; there is no infinite number.
    let filled = bench.json(&["compare", "r.json"]);
    assert!(!filled.to_string().contains("null"), "{filled}");
    assert!(filled["agreement"].as_f64().unwrap() < 1e-12, "{filled}");
    let text = bench.done(&["compare", "r.json"]);
    assert!(text.contains("agree") && !text.contains("inf "), "{text}");
    assert_eq!(text.contains("cannot be compared"), filled["unlike"].is_array(), "{text}");
}

#[test]
fn an_animation_beyond_single_precision_is_refused_and_one_that_bends_bends() {
    let bench = LOFTSMAN.bench();
    let points = |k: f64| {
        let one = |i: u32| format!("[{i}, {:?}, 0]", 0.2 * k * f64::from(i).sin());
        format!("[{}]", (0..9).map(one).collect::<Vec<_>>().join(", "))
    };
    let line = |rate: &str| {
        let frames: Vec<String> = (0..11).map(|k| points(f64::from(k))).collect();
        format!(
            r#"{{"loftsman": 1, "objects": [{{"name": "line", "curve": {{"degree": 3, "periodic": false,
            "knots": [0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 6, 6, 6], "points": {}}},
            "animation": {{"rate": {rate}, "frames": [{}]}}}}]}}"#,
            points(0.0),
            frames.join(", ")
        )
    };
    for rate in ["1e-39", "1e46", "1e300", "1e-300"] {
        bench.write("x.loft.json", line(rate));
        for out in ["o.glb", "o.gltf"] {
            bench.fails(&["convert", "x.loft.json", out], 1, &["line", "single precision", "rate"]);
        }
    }
    bench.write("x.loft.json", line("10"));
    let said = bench.json(&["convert", "x.loft.json", "o.glb"]);
    let object = &said["objects"][0];
    assert!(object["error"].as_f64().unwrap() <= object["tolerance"].as_f64().unwrap(), "{said}");
    let segments: usize =
        object["form"].as_str().unwrap().split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!(segments > 20, "{said}");
}

#[test]
fn curves_as_blender_writes_them_are_read_and_what_was_mended_is_said() {
    let bench = LOFTSMAN.bench();
    let vertices = "v 0 0 0\nv 1 2 0\nv 3 1 0\nv 4 0 0\n";
    bench.write(
        "beyond.obj",
        format!(
            "{vertices}v 5 2 0\ncstype bspline\ndeg 3\ncurv 0.0 1.0 1 2 3 4 5\n\
             parm u 0.0 0.125 0.25 0.375 0.5 0.625 0.75 0.875 1.0\nend\n"
        ),
    );
    bench.write(
        "extra.obj",
        format!(
            "{vertices}cstype bspline\ndeg 1\ncurv 0.0 1.0 1 2 3 4\nparm u 0.0 0.0 0.25 0.5 0.75 1.0 1.0\nend\n"
        ),
    );
    assert!(bench.done(&["info", "beyond.obj"]).contains("clipped"));
    // What is left of a uniform cubic: where its knots define it, (1, 4, 1) / 6 of three vertices at each of them.
    let read = |name: &str| loftsman::read_scene(bench.path(name)).unwrap();
    let scene = read("beyond.obj");
    let loftsman::kernel::scene::Geometry::Curve(curve) = scene.objects()[0].geometry() else {
        unreachable!()
    };
    assert_eq!(curve.domain(), (0.375, 0.625));
    let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 1.0], [4.0, 0.0], [5.0, 2.0]];
    for (k, t) in [0.375, 0.5, 0.625].into_iter().enumerate() {
        let found = curve.point(t).unwrap();
        for axis in 0..2 {
            let wanted = (points[k][axis] + 4.0 * points[k + 1][axis] + points[k + 2][axis]) / 6.0;
            assert!((found[axis] - wanted).abs() < 1e-15, "{t}: {found}");
        }
    }
    // Of the knots of degree 1, the last is too many: vertices at 0, 0.25, 0.5 and 0.75.
    let scene = read("extra.obj");
    let loftsman::kernel::scene::Geometry::Curve(curve) = scene.objects()[0].geometry() else {
        unreachable!()
    };
    assert_eq!(curve.domain(), (0.0, 0.75));
    for (t, [x, y]) in [(0.0, [0.0, 0.0]), (0.25, [1.0, 2.0]), (0.5, [3.0, 1.0]), (0.75, [4.0, 0.0])] {
        assert_eq!((curve.point(t).unwrap().x, curve.point(t).unwrap().y), (x, y), "{t}");
    }
    let extra = bench.done(&["info", "extra.obj"]);
    assert!(extra.contains("clipped") && extra.contains("dropped"), "{extra}");
}

#[test]
fn options_that_nothing_takes_are_refused_and_combs_of_a_surface_said() {
    let bench = LOFTSMAN.bench().with_wave();
    for (arguments, words) in [
        (["--write", "surface=exact"], ["surface", "obj has knots, surfaces"]),
        (["--write", "split=none"], ["split", "obj"]),
        (["--read", "knots=any"], ["knots", "loft"]),
    ] {
        bench.fails(&[&["convert", "wave.loft.json", "o.obj"], &arguments[..]].concat(), 2, &words);
    }
    bench.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.done(&["convert", "t.obj", "t.glb"]);
    // An option of writing, when reading.
    bench.fails(&["convert", "t.glb", "u.obj", "--read", "meshes-only=true"], 2, &["meshes-only", "gltf"]);
    let recipe = |rest: &str| format!("input = 'wave.loft.json'\noutput = 'a.glb'\n{rest}");
    for (rest, words) in [
        ("[write.obj]\nknots = 'any'\n", ["write.obj", "no output"]),
        ("[write.gltf]\nmesh-only = true\n", ["mesh-only", "did you mean \"meshes-only\""]),
        ("[picture]\ncombs = true\n", ["picture", "no output"]),
        ("[read]\nsplit = 'none'\n", ["split", "loft"]),
    ] {
        bench.write("r.toml", recipe(rest));
        bench.fails(&["run", "r.toml"], 1, &words);
    }
    bench.write("r.toml", "output = 'a.glb'\n[read]\nsplit = 'none'\n");
    bench.fails(&["run", "r.toml"], 1, &["read", "no input"]);
    // A surface has combs and no beads.
    bench.write(
        "s.loft.json",
        r#"{"loftsman": 1, "objects": [{"name": "s", "surface": {
        "u": {"degree": 1, "periodic": false, "knots": [0, 0, 1, 1]},
        "v": {"degree": 1, "periodic": false, "knots": [0, 0, 1, 1]},
        "points": [[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 1]]]}}]}"#,
    );
    bench.write("s.toml", "input = 's.loft.json'\noutput = 's.svg'\n[picture]\ncombs = true\nknots = true\n");
    let said = bench.json(&["run", "s.toml"]);
    assert!(
        said["outputs"][0]["notes"].to_string().contains("beads at knots are of curves: none for"),
        "{said}"
    );
    assert!(!said.to_string().contains("combs"), "{said}");
    let run = bench.run(&["plot", "s.loft.json", "s.png", "--pixels", "100", "--beads", "2"]);
    assert!(run.code == Some(0) && run.err.contains("beads at knots are of curves"), "{}", run.err);
    let run = bench.run(&["plot", "s.loft.json", "s.png", "--pixels", "100", "--comb-scale", "0.1"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    let run = bench.run(&["plot", "s.loft.json", "s.png", "--pixels", "100"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
}

/// Curves of all degrees with knots of all multiplicities, through every format.
#[test]
fn torn_shapes_go_through_every_format() {
    use loftsman::file::Outputs;
    use loftsman::kernel::Point;
    use loftsman::kernel::plugin::WriteOptions;
    use loftsman::kernel::scene::{Object, Scene};
    use loftsman::kernel::spline::{Curve, Space, Surface};
    use loftsman::read_scene;
    let bench = LOFTSMAN.bench();
    let mut seed = 1_u64;
    let mut throw = |sides: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % sides
    };
    let mut scene = Scene::new();
    for member in 0..120 {
        let mut space = |most: usize| {
            let p = [1, 2, 3, 4, 5, 7, 25][throw(most)];
            let is_periodic = throw(3) == 0;
            let full = if is_periodic { p } else { p + 1 };
            let inner: Vec<f64> = (1..=1 + throw(3))
                .flat_map(|k| vec![k as f64; if throw(2) == 0 { full } else { 1 + throw(full) }])
                .collect();
            if is_periodic {
                return Space::periodic(p, [vec![0.0], inner, vec![5.0]].concat()).unwrap();
            }
            Space::open(p, [vec![0.0; p + 1], inner, vec![5.0; p + 1]].concat()).unwrap()
        };
        let is_surface = member % 3 == 0;
        let (u, v) = (space(if is_surface { 3 } else { 7 }), space(3));
        let n = if is_surface { u.len() * v.len() } else { u.len() };
        let points = (0..n)
            .map(|k| Point::new((k % 7) as f64 + throw(100) as f64 / 50.0, (k / 7) as f64, throw(9) as f64))
            .collect();
        let weights = (throw(2) == 0).then(|| (0..n).map(|_| 0.25 + throw(8) as f64).collect());
        let geometry = if is_surface {
            Surface::build(u, v, points, weights).unwrap().into()
        } else {
            Curve::build(u, points, weights).unwrap().into()
        };
        scene.add(Object::new(format!("m{member}"), geometry)).unwrap();
    }
    for file in ["a.loft.json", "a.glb", "a.gltf", "a.obj"] {
        let mut outputs = Outputs::new();
        let mut options = WriteOptions::default();
        options.fineness.chord = loftsman::kernel::plugin::Chord::Relative(0.02);
        options.fineness.angle = 3.0;
        outputs.scene(&scene, bench.path(file), &options, loftsman::registry()).unwrap();
        outputs.commit().unwrap();
        let back = read_scene(bench.path(file)).unwrap();
        for object in scene.objects() {
            let found = back.get(object.name()).unwrap_or_else(|| panic!("{file} has no {}", object.name()));
            if !file.ends_with(".obj") {
                assert_eq!(found.geometry(), object.geometry(), "{file}: {}", object.name());
            }
        }
    }
}

/// Areas, volumes and sizes as Blender 5.0.1 measures them (its meshes, placed, points within 1e-6 welded; single precision).
#[test]
fn what_is_placed_is_as_large_as_it_stands() {
    let bench = LOFTSMAN.bench();
    let data = loftsman_tests::repository().join("tests/data/gltf");
    let near = |found: &serde_json::Value, wanted: f64| {
        let found = found.as_f64().unwrap();
        assert!((found / wanted - 1.0).abs() < 1e-5, "{found} is not {wanted}");
    };
    let blocks = [
        ("block01", 1.806_070_655_6, 0.165_068_826_1, [0.538_762_9, 0.568_682_2, 0.538_763]),
        ("block02", 4.890_634_536_7, 0.580_531_077, [0.538_763, 1.999_999_9, 0.538_763]),
        ("block03", 1.980_498_939_8, 0.153_179_160_5, [0.354_279_9, 1.220_412_5, 0.354_279_9]),
    ];
    let file = data.join("nested.glb");
    let info = bench.json(&["info", file.to_str().unwrap()]);
    for (name, area, volume, size) in blocks {
        let block = info["objects"].as_array().unwrap().iter().find(|o| o["name"] == name).unwrap();
        near(&block["area"], area);
        near(&block["volume"], volume);
        for (axis, size) in size.into_iter().enumerate() {
            let end = |k: usize| block["bounds"][k][axis].as_f64().unwrap();
            assert!((end(1) - end(0) - size).abs() < 1e-5, "{block}");
        }
        near(&block["own"]["area"], 24.0);
        near(&block["own"]["volume"], 8.0);
    }
    let text = bench.done(&["info", file.to_str().unwrap()]);
    let line = text.lines().find(|line| line.contains("block02")).unwrap();
    assert!(line.contains("area 4.891 m² · volume 0.5805 m³ · watertight · size 0.5388 × 2 × 0.5388 m · in its own coordinates area 24 m², volume 8 m³, size 2 × 2 × 2 m"), "{line}");
    let info = bench.json(&["info", data.join("VertexColorTest.glb").to_str().unwrap()]);
    let plate = info["objects"].as_array().unwrap().iter().find(|o| o["name"] == "VertexColorTest").unwrap();
    near(&plate["area"], 9.486_981_904);
}

/// Closed forms: a line of length 5 below a mirror that doubles, a square patch stretched by one axis, and an instance of both.
#[test]
fn curves_surfaces_and_instances_are_as_large_as_they_stand() {
    let bench = LOFTSMAN.bench();
    let scale = |x: f64, y: f64, z: f64| json!([[x, 0, 0, 9], [0, y, 0, 0], [0, 0, z, 0], [0, 0, 0, 1]]);
    let flat = json!({ "degree": 1, "knots": [0, 0, 1, 1] });
    let line = json!({ "degree": 1, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [3, 4, 0]] });
    let patch = json!({ "u": flat, "v": flat, "points": [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]] });
    let scene = json!({
        "loftsman": 1, "unit": "m",
        "definitions": [{ "name": "both", "objects": [
            { "name": "rail", "curve": line }, { "name": "sheet", "surface": patch, "transform": scale(2.0, 1.0, 1.0) },
        ] }],
        "objects": [
            { "name": "mirror", "group": {}, "transform": scale(-2.0, 2.0, 2.0) },
            { "name": "rail", "parent": "mirror", "curve": line },
            { "name": "sheet", "parent": "mirror", "surface": patch, "transform": scale(3.0, 1.0, 1.0) },
            { "name": "shown", "parent": "mirror", "instance": { "definition": "both" } },
        ],
    });
    bench.write("s.loft.json", scene.to_string());
    let info = bench.json(&["info", "s.loft.json"]);
    let near = |found: &serde_json::Value, wanted: f64| {
        assert!((found.as_f64().unwrap() - wanted).abs() < 1e-9, "{found} is not {wanted}");
    };
    let objects = &info["objects"];
    near(&objects[1]["length"], 10.0);
    near(&objects[1]["own"]["length"], 5.0);
    near(&objects[2]["area"], 12.0);
    near(&objects[3]["area"], 8.0);
    near(&info["definitions"][0]["objects"][1]["area"], 2.0);
    // x: 9 - 2 (9 + 3 u) from -15 to -9.
    assert_eq!(objects[2]["bounds"], json!([[-15.0, 0.0, 0.0], [-9.0, 2.0, 0.0]]));
    assert!(bench.done(&["info", "s.loft.json"]).contains("of both · area 8 m²"));
}

#[test]
fn what_is_missing_is_named_and_formats_that_are_not_read_are_called_by_their_names() {
    let bench = LOFTSMAN.bench();
    let run = bench.run(&["info", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let told = told.to_string();
    assert!(told.contains("required arguments were not provided: <"), "{told}");
    for (file, name) in
        [("a.stl", "STL is not read"), ("b.PLY", "PLY is not read"), ("c.3dm", "Rhino's 3DM is not read")]
    {
        bench.write(file, "solid x\nendsolid x\n");
        bench.fails(&["info", file], 1, &[file, name, "obj"]);
    }
    bench.write("d.xyzzy", "what is this?");
    bench.fails(&["info", "d.xyzzy"], 1, &["neither its name nor its content"]);
}

/// A sheet that folds over along the diagonal of its parameters: `x = u`, `y = (v - u)²`, whose area is `∫∫ 2 |v - u| = 2/3`; a sweep whose path bends
/// more narrowly than the profile is wide; and one with more folds than bounded work can follow.
#[test]
fn what_folds_has_an_area_or_it_is_said_why_not() {
    let bench = LOFTSMAN.bench();
    let flat = json!({ "degree": 2, "knots": [0, 0, 0, 1, 1, 1] });
    let sheet = json!({ "name": "s", "surface": { "u": flat, "v": flat, "points": [
        [[0, 0, 0], [0, 0, 0], [0, 1, 0]],
        [[0.5, 0, 0], [0.5, -0.5, 0], [0.5, 0, 0]],
        [[1, 1, 0], [1, 0, 0], [1, 0, 0]],
    ] } });
    let mut random = loftsman_tests::curves::Sequence::new(5);
    let mut coordinate = || random.next_number();
    let net: Vec<Vec<[f64; 3]>> =
        (0..66).map(|_| (0..66).map(|_| [coordinate(), coordinate(), 0.0]).collect()).collect();
    let knots: Vec<usize> = [0, 0, 0].into_iter().chain(1..64).chain([64, 64, 64]).collect();
    let space = json!({ "degree": 2, "knots": knots });
    let wild = json!({ "name": "w", "surface": { "u": space, "v": space, "points": net } });
    let scene = loftsman_tests::curves::document("mm", &[sheet, wild]);
    bench.write("s.loft.json", scene.to_string());
    let said = bench.done(&["info", "s.loft.json"]);
    let line = |name: &str| said.lines().find(|line| line.trim_start().starts_with(name)).unwrap().to_owned();
    assert!(line("s ").contains("area 0.6667 mm²"), "{said}");
    assert!(line("w ").contains("not measured: area: the surface folds over"), "{said}");
    let told = bench.json(&["info", "s.loft.json"]);
    assert!((told["objects"][0]["area"].as_f64().unwrap() * 1.5 - 1.0).abs() < 1e-7, "{told}");
    assert!(told["objects"][1]["unmeasured"][0].as_str().unwrap().starts_with("area: "), "{told}");
    // And in what a step says that makes one.
    bench.write("sweep.loft.json", FOLDED_SWEEP);
    bench.write(
        "r.toml",
        "input = 'sweep.loft.json'\noutput = ['o.loft.json']\n[[step]]\nop = 'sweep'\nobject = 'a'\npath = 'p'\nname = 'r'\nframe = 'upright'\n\
         tolerance = 1000.0\n",
    );
    let step = &bench.json(&["run", "r.toml"])["steps"][0];
    let area = step["objects"][0]["area"]["after"].as_f64().unwrap();
    // By composite Gauss-Legendre rules of numpy on the surface that is written, refined until they agree.
    assert!((area / 3.375_177_027_88e17 - 1.0).abs() < 1e-7, "{area:e}");
}

/// A profile and a path that bends more narrowly than the profile is wide.
const FOLDED_SWEEP: &str = r#"{"loftsman": 1, "unit": "mm", "up": "z", "objects": [
  {"name": "a", "curve": {"degree": 2, "periodic": false, "knots": [0.0, 0.0, 0.0, 0.47146792051441955, 1.0, 1.0, 1.0], "points":
  [[-945850749.5036429, 350772029.94513404, 306007125.75076044], [-977357385.1543244, 332372957.74984056, 295367197.5441908], [-1007976663.0311085, 316356234.44365436, 294867273.3361217], [-1012842344.152072, 322987405.0455374, 343227283.95537823]], "weights": [0.7563804566597009, 30.342060706223315, 3.597372936893349, 0.10720260524272422]}},
  {"name": "p", "curve": {"degree": 3, "periodic": false, "knots": [0.0, 0.0, 0.0, 0.0, 0.6231554594115649, 0.7125829020433939, 0.9066987612693792, 0.9066987612693792, 1.0, 1.0, 1.0, 1.0], "points":
  [[-988068215.6497669, 328672570.0842176, 305234390.96004146], [-716876675.4805256, -192849847.43168652, 404031633.12852085], [-359640272.76324517, -521350824.46703964, 140380972.0578158], [-161274525.9304597, -467321700.1198086, -77940634.25029895], [140744747.22394362, -51195591.44388579, -248475317.56321448], [359845662.5835845, 343560904.6014343, -349144781.4695518], [704769168.1965014, 656441010.3273064, -322157116.5177845], [967459102.81985, 399869835.36413634, -273889543.25841576]]}}]}"#;

/// Who types an operation or a constraint where a command belongs is told where it is written.
#[test]
fn an_operation_as_a_command_is_sent_to_recipes() {
    let bench = LOFTSMAN.bench();
    for (word, said) in [
        ("simulate", "tip: simulate is an operation of recipes"),
        ("edit", "`loftsman plugins edit`"),
        ("position", "tip: position is a constraint"),
    ] {
        let error = bench.fails(&[word, "--help"], 2, &["unrecognized subcommand", said]);
        assert!(!error.contains("similar subcommand"), "{error}");
    }
}

/// An area that is no object's own, across a direction of a curve in space, is told as it was asked; an object's own once.
#[test]
fn what_was_asked_is_told() {
    let bench = LOFTSMAN.bench();
    bench.write(
        "c.loft.json",
        r#"{"loftsman": 1, "unit": "mm", "objects": [{"name": "c", "curve": {"degree": 2, "periodic": true, "knots": [0, 1, 2, 3, 4],
        "points": [[1, 1, 0.2], [-1, 1, -0.2], [-1, -1, 0.2], [1, -1, -0.2]]}},
        {"name": "flat", "curve": {"degree": 2, "periodic": true, "knots": [0, 1, 2, 3, 4],
        "points": [[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]}}]}"#,
    );
    let step = |object: &str, asked: &str| {
        bench.write(
            "r.toml",
            format!(
                "input = 'c.loft.json'\n[[step]]\nop = 'edit'\nobject = '{object}'\nconstraints = [{asked}]\n"
            ),
        );
        bench.done(&["run", "r.toml"])
    };
    // The square of a uniform quadratic: 4 - 4 / 6 of its corners cut off, by hand: each leaves 1/6 of its parallelogram.
    let own = 4.0 - 4.0 / 6.0;
    let told = step("c", "{ kind = 'area', normal = [0, 0, 1], scale = 1.1 }");
    let line = told.lines().find(|line| line.contains("across")).unwrap_or_else(|| panic!("{told}"));
    assert!(line.contains(&format!("{own:.3} → {:.3} mm² (× 1.1)", 1.1 * own)), "{line}");
    let told = step("flat", "{ kind = 'area', scale = 1.1 }");
    assert_eq!(told.matches("→").count(), told.matches("length").count() + 1, "{told}");
}
