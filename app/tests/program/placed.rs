//! What is told of objects that transforms place: as they stand in the scene, as `info` tells it, whatever operation made or changed them.

use serde_json::{Value, json};

use crate::LOFTSMAN;

/// A square, a line beside it, a bent curve and a sheet.
fn objects() -> Vec<Value> {
    let curve = |name: &str, degree: usize, knots: Value, points: Value| json!({ "name": name, "curve": { "degree": degree, "periodic": false, "knots": knots, "points": points } });
    let flat = json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1] });
    vec![
        curve(
            "c",
            1,
            json!([0, 0, 1, 2, 3, 4, 4]),
            json!([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]]),
        ),
        curve("p", 1, json!([0, 0, 1, 1]), json!([[0, 0, 0], [0, 0, 4]])),
        curve("b", 2, json!([0, 0, 0, 1, 1, 1]), json!([[0, 0, 0], [1, 2, 0], [3, 0, 1]])),
        json!({ "name": "s", "surface": { "u": flat, "v": flat, "points": [[[0, 0, 0], [0, 2, 0]], [[3, 0, 0], [3, 2, 1]]] } }),
    ]
}

/// Three ways to place: a group above that turns and doubles, one that mirrors, and one that stretches.
fn maps() -> [Value; 3] {
    [
        json!([[0, -2, 0, 5], [2, 0, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1]]),
        json!([[-0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]]),
        json!([[1, 0.5, 0, 0], [0, 3, 0, 2], [0, 0, 0.25, 0], [0, 0, 0, 1]]),
    ]
}

#[test]
fn what_operations_tell_is_what_info_tells() {
    let steps = [
        json!({ "op": "extrude", "objects": ["c"], "by": [0, 0.3, 1], "name": "e" }),
        json!({ "op": "fill", "objects": ["c"], "name": "f" }),
        json!({ "op": "revolve", "object": "c", "point": [5, 0, 0], "axis": [0, 1, 0], "name": "r" }),
        json!({ "op": "offset", "object": "c", "distance": 0.5, "name": "o" }),
        json!({ "op": "tube", "object": "b", "radius": 0.1, "name": "t" }),
        json!({ "op": "sweep", "object": "c", "path": "p", "name": "w" }),
        json!({ "op": "sample", "object": "b", "count": 7, "name": "d" }),
        json!({ "op": "isocurve", "object": "s", "u": 0.4, "name": "i" }),
        json!({ "op": "edge", "object": "s", "edge": "u1", "name": "g" }),
        json!({ "op": "edit", "object": "b", "constraints": [{ "kind": "position", "at": 1, "to": [3, 1, 1] }] }),
        json!({ "op": "symmetrize", "object": "p", "normal": [0, 0, 1], "point": [0, 0, 1] }),
        json!({ "op": "tessellate", "object": "s" }),
    ];
    for map in maps() {
        let bench = LOFTSMAN.bench();
        let mut all = objects();
        all.iter_mut().for_each(|object| object["parent"] = json!("above"));
        all.push(json!({ "name": "above", "transform": map, "group": {} }));
        let scene = json!({ "loftsman": 1, "unit": "mm", "up": "z", "objects": all });
        bench.write("in.loft.json", scene.to_string());
        let recipe = json!({ "input": "in.loft.json", "output": "out.loft.json", "step": steps });
        bench.write("r.json", recipe.to_string());
        let report = bench.json(&["run", "r.json"]);
        let info = bench.json(&["info", "out.loft.json"]);
        let mut compared = 0;
        for (step, asked) in report["steps"].as_array().unwrap().iter().zip(&steps) {
            for change in step["objects"].as_array().unwrap() {
                let name = change["name"].as_str().unwrap();
                let stands = info["objects"].as_array().unwrap().iter().find(|o| o["name"] == name).unwrap();
                for quantity in ["length", "area", "volume"] {
                    let (told, is) = (&change[quantity]["after"], &stands[quantity]);
                    if let (Some(told), Some(is)) = (told.as_f64(), is.as_f64()) {
                        assert!((told - is).abs() <= 1e-9 * is.abs(), "{asked}: {quantity} {told}, {stands}");
                        compared += 1;
                    } else {
                        assert!(told.is_null(), "{asked}: {change}, {stands}");
                    }
                }
                // Of what was made the step itself tells the area, too.
                if let (Some(told), Some(is)) = (step["area"].as_f64(), stands["area"].as_f64()) {
                    assert!((told - is).abs() <= 1e-6 * is.abs(), "{asked}: {told}, {stands}");
                }
            }
        }
        assert!(compared >= 14, "{compared}");
    }
}

/// A square of 1 that is placed twice as large: what is asked stays in its own coordinates, which is said, and what is told is as large as it stands.
#[test]
fn what_is_asked_in_own_coordinates_is_said_to_be() {
    let bench = LOFTSMAN.bench();
    let mut all = objects();
    let double = json!([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]);
    all.iter_mut().for_each(|object| object["transform"] = double.clone());
    let scene = json!({ "loftsman": 1, "unit": "mm", "up": "z", "objects": all });
    bench.write("in.loft.json", scene.to_string());
    let cases = [
        (
            json!({ "op": "sample", "object": "p", "spacing": 1 }),
            &["2 mm from each to the next", "spacing is in its own coordinates"][..],
        ),
        (
            json!({ "op": "revolve", "object": "p", "point": [1, 0, 0] }),
            &["area 100.5 mm²", "point and axis are in its own coordinates"],
        ),
        (json!({ "op": "offset", "object": "c", "distance": 1 }), &["distance is in its own coordinates"]),
        (json!({ "op": "tube", "object": "p", "radius": 0.1 }), &["radius is in its own coordinates"]),
        (
            json!({ "op": "tessellate", "object": "b", "tolerance": 0.1 }),
            &["(0.2 mm asked for)", "tolerance is in its own coordinates"],
        ),
        (
            json!({ "op": "symmetrize", "object": "p", "normal": [0, 0, 1], "point": [0, 0, 1] }),
            &["moved by 2 mm at most", "deviates by up to 2 mm"],
        ),
        (
            json!({ "op": "edit", "object": "p", "constraints": [{ "kind": "position", "at": 1, "to": [0, 0, 5] }] }),
            &[
                "length 8 → 10 mm",
                "deviates by up to 2 mm",
                "how well that is met, is in its own coordinates",
            ],
        ),
        (
            json!({ "op": "section", "object": "s", "axis": "x", "at": 1 }),
            &["axis and at are in its own coordinates"],
        ),
        (
            json!({ "op": "refine", "object": "p", "knots": [{ "closest": [1, 0, 1] }] }),
            &["the nearest place to (1, 0, 1) in its own coordinates, 1 mm away"],
        ),
    ];
    for (step, wanted) in cases {
        let recipe = json!({ "input": "in.loft.json", "output": "out.loft.json", "step": [step] });
        bench.write("r.json", recipe.to_string());
        let said = bench.done(&["run", "r.json"]);
        for wanted in wanted {
            assert!(said.contains(wanted), "{step}: {wanted:?} is not in {said}");
        }
    }
}
