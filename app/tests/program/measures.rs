//! Areas and volumes asked of what has none: one error each, which names the recipe's place, the object, and what to do; and
//! nothing is written.

use loftsman_tests::curves::document;
use serde_json::{Value, json};

use crate::LOFTSMAN;

fn ring(name: &str, points: Value) -> Value {
    let knots: Vec<usize> = (0..=points.as_array().unwrap().len()).collect();
    json!({ "name": name, "curve": { "degree": 3, "periodic": true, "knots": knots, "points": points } })
}

fn objects() -> Vec<Value> {
    let flat = json!({ "degree": 1, "knots": [0, 0, 1, 1] });
    vec![
        ring("rib", json!([[0, 0, 0], [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 2, 0], [-1, 1, 0]])),
        ring("bent", json!([[0, 0, 0], [1, 0, 0], [2, 1, 0], [1, 2, 1], [0, 2, 0], [-1, 1, 0]])),
        ring("flat", json!([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [2, 0, 0], [1, 0, 0]])),
        json!({ "name": "open", "curve": { "degree": 3, "knots": [0, 0, 0, 0, 1, 2, 2, 2, 2],
                "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-0.5, 0.5, 0]] } }),
        json!({ "name": "sail", "surface": { "u": flat, "v": flat,
                "points": [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]] } }),
        json!({ "name": "panel", "mesh": { "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]] } }),
    ]
}

#[test]
fn what_encloses_nothing_is_told_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let scene = document("m", &objects());
    std::fs::write(folder.path().join("scene.loft.json"), scene.to_string()).unwrap();
    const CONSTRAINT: &str = "step[0].constraints[0]";
    let locked = json!({ "lock": [0, 1, 2, 3, 4, 5] });
    let alternating = json!({ "axes": "alternating" });
    let nothing = json!({});
    let keep = |kind: &str| json!([{ "kind": kind, "keep": true }]);
    let cases: Vec<(&str, Value, &Value, &[&str])> = vec![
        ("open", keep("area"), &nothing, &[CONSTRAINT, "the end of \"open\" is 0.7071 away", "close it"]),
        ("bent", keep("area"), &nothing, &[CONSTRAINT, "\"bent\"", "not planar", "0.8427", "\"normal\""]),
        ("flat", keep("area"), &nothing, &[CONSTRAINT, "\"flat\"", "encloses no area", "give it some first"]),
        (
            "rib",
            json!([{ "kind": "area", "normal": [1, 0, 0], "keep": true }]),
            &nothing,
            &[CONSTRAINT, "\"rib\"", "area is zero", "is the normal right?"],
        ),
        ("sail", keep("volume"), &nothing, &[CONSTRAINT, "\"sail\"", "open", "1.225 away", "close it"]),
        ("sail", keep("area"), &nothing, &[CONSTRAINT, "\"sail\" is a surface", "ask for its volume"]),
        ("rib", keep("volume"), &nothing, &[CONSTRAINT, "\"rib\" is a curve", "ask for its area"]),
        ("panel", keep("volume"), &nothing, &["\"panel\" is a mesh", "fit"]),
        (
            "rib",
            json!([{ "kind": "area", "to": -3.0 }]),
            &nothing,
            &["\"rib\"", "is 3.344444", "-3.000000", "inside out", "same sign, or reverse the curve"],
        ),
        (
            "rib",
            json!([{ "kind": "area", "to": 0 }]),
            &nothing,
            &["\"rib\"", "nothing is left", "the present 3.344444"],
        ),
        (
            "rib",
            json!([{ "kind": "area", "scale": 1.5 }]),
            &locked,
            &["area of \"rib\" cannot be met", "no control vertex that may move", "unlock one"],
        ),
        (
            "rib",
            json!([{ "kind": "area", "keep": true }, { "kind": "position", "at": 1, "axis": "x", "at_most": 3 }]),
            &alternating,
            &["cannot alternate where there are bounds", "area of \"rib\"", "let them move together"],
        ),
        (
            "rib",
            json!([{ "kind": "length", "keep": true }]),
            &alternating,
            &["length of \"rib\" is not linear in each axis", "let them move together"],
        ),
    ];
    for (object, constraints, more, words) in cases {
        let mut step = json!({ "op": "edit", "object": object, "constraints": constraints });
        step.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let recipe = json!({ "input": "scene.loft.json", "output": ["out.loft.json"], "step": [step] });
        std::fs::write(folder.path().join("recipe.json"), recipe.to_string()).unwrap();
        let run = LOFTSMAN.run(folder.path(), &["run", "recipe.json"]);
        let error = run.err;
        assert_eq!(run.code, Some(1), "{step}: {error}");
        assert!(error.trim_end().lines().count() == 1 && error.contains("recipe.json"), "one error: {error}");
        for word in words {
            assert!(error.contains(word), "\"{word}\" is not in: {error}");
        }
        assert!(!folder.path().join("out.loft.json").exists(), "nothing is written");
    }
}

/// `n × n` quads round a torus, or twice as many triangles, as the cage of a subdivision surface.
fn torus(n: usize, in_triangles: bool) -> Value {
    let turn = |k: usize| (k as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
    let points: Vec<[f64; 3]> = (0..n * n)
        .map(|k| {
            let ((sin, cos), (up, out)) = (turn(k / n), turn(k % n));
            [(3.0 + out) * cos, (3.0 + out) * sin, up]
        })
        .collect();
    let at = |i: usize, j: usize| (i % n) * n + j % n;
    let quads = (0..n * n)
        .map(|k| (k / n, k % n))
        .map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    let faces: Vec<Vec<usize>> = if in_triangles {
        quads.flat_map(|[a, b, c, d]| [vec![a, b, c], vec![a, c, d]]).collect()
    } else {
        quads.map(|quad| quad.to_vec()).collect()
    };
    json!({ "name": "cage", "shape": { "kind": "subdivision", "scheme": "catmull-clark", "points": points, "faces": faces } })
}

/// Cages with more pieces than there may be of a surface that has to be asked for rows: near a torus of radii 3 and 1.
#[test]
fn large_cages_have_their_area_and_volume() {
    let folder = tempfile::tempdir().unwrap();
    for (n, in_triangles) in [(16, true), (70, false)] {
        std::fs::write(
            folder.path().join("m.loft.json"),
            document("m", &[torus(n, in_triangles)]).to_string(),
        )
        .unwrap();
        let run = LOFTSMAN.run(folder.path(), &["info", "m.loft.json", "--json"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        let told: Value = serde_json::from_str(&run.out).unwrap();
        let object = &told["objects"][0];
        let pi = std::f64::consts::PI;
        for (field, of_torus) in [("area", 12.0 * pi * pi), ("volume", 6.0 * pi * pi)] {
            let found = object[field].as_f64().unwrap_or_else(|| panic!("{object}")).abs();
            // A cage is outside its surface: the limits are some percent inside.
            let low = if in_triangles { 0.85 } else { 0.99 };
            assert!((low * of_torus..of_torus).contains(&found), "{field}: {found} {of_torus}");
        }
        assert_eq!(object["unmeasured"], Value::Null);
    }
}
