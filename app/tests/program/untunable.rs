//! Fine tuning and subdivision asked for what cannot be: one clear error with the recipe, the place in it and what of the shape is meant, exit status 1,
//! nothing written.

use loftsman_tests::bench::Bench;
use serde_json::{Value, json};

use crate::LOFTSMAN;

/// A step on an input, refused with these words, and the recipe's name and line among them.
fn refused(bench: &Bench, input: &str, step: Value, words: &[&str]) {
    bench.write("r.json", json!({ "input": input, "output": "out.loft.json", "step": [step] }).to_string());
    let said = bench.fails(&["run", "r.json"], 1, words);
    assert!(said.starts_with("error: r.json, line 1, column ") && said.contains("step[0]"), "{said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
}

fn tune(mut fields: Value) -> Value {
    fields["op"] = "fine-tune".into();
    fields
}

fn subdivide(mut fields: Value) -> Value {
    fields["op"] = "subdivide".into();
    fields
}

const BOX: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                   f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

#[test]
fn alphas_that_are_not_positive() {
    let bench = LOFTSMAN.bench().with_wave();
    let wave = |alpha: Value, words: &[&str]| {
        refused(&bench, "wave.loft.json", tune(json!({ "alpha": alpha })), words);
    };
    // Where it is lowest: on the knots of the derivative value 2 lives from 0 to 3, and α = (1 - 0.5 · 3) / 4 at 1.5.
    wave(json!([1, 1, -0.5, 1, 1, 1, 1]), &["α is -0.125 at 1.5", "value 2", "any_sign"]);
    wave(json!(0), &["α is 0 at 0", "value 0"]);
    wave(json!(-2), &["α is -2"]);
    wave(json!({ "degree": 1, "knots": [0, 0, 5, 5], "values": [1, -1] }), &["α is -1 at 5", "value 1"]);
    bench.write("box.obj", BOX);
    let mesh = |fields: Value, words: &[&str]| refused(&bench, "box.obj", tune(fields), words);
    mesh(json!({ "alpha": -1 }), &["α is -1 at the edge of vertices 0 and 1"]);
    mesh(
        json!({ "alpha": [{ "edge": [0, 1], "value": 2 }, { "edge": [5, 4], "value": 0 }] }),
        &["α is 0 at the edge of vertices 4 and 5", "any_sign"],
    );
    let spline = json!({ "loftsman": 1, "objects": [{ "name": "sheet", "surface": {
        "u": { "degree": 1, "knots": [0, 0, 1, 1] }, "v": { "degree": 2, "knots": [0, 0, 0, 2, 2, 2] },
        "points": [[[0, 0, 0], [0, 1, 0], [0, 2, 1]], [[1, 0, 0], [1, 1, 0], [1, 2, 0]]] } }] });
    bench.write("sheet.loft.json", spline.to_string());
    let sheet = |fields: Value, words: &[&str]| refused(&bench, "sheet.loft.json", tune(fields), words);
    sheet(json!({ "alpha_v": [1, -1] }), &["α is -1 at 2", "value 1"]);
    sheet(json!({ "alpha_u": 0 }), &["α is 0 at 0"]);
    sheet(json!({ "alpha_v": [1, 1, 1] }), &["step[0].alpha_v", "3 values", "have 2"]);
}

#[test]
fn alphas_of_too_few_or_too_many_values() {
    let bench = LOFTSMAN.bench().with_wave();
    let wave = |alpha: Value, words: &[&str]| {
        refused(&bench, "wave.loft.json", tune(json!({ "alpha": alpha })), words);
    };
    for count in [0, 1, 3, 6, 8, 40] {
        wave(json!(vec![1; count]), &["step[0].alpha", &format!("{count} value"), "needs 7"]);
    }
    wave(
        json!({ "degree": 2, "knots": [0, 0, 0, 5, 5, 5], "values": [1, 1] }),
        &["step[0].alpha", "6 knots and 2 values", "has 5 knots"],
    );
    wave(
        json!({ "degree": 2, "knots": [0, 0, 0, 4, 4, 4], "values": [1, 1, 1] }),
        &["step[0].alpha", "over [0, 4]", "[0, 5]"],
    );
    wave(
        json!({ "degree": 2, "knots": [0, 0, 0, 5, 4, 5], "values": [1, 1, 1] }),
        &["step[0].alpha.knots", "knot 4 is 4", "must not decrease"],
    );
    wave(
        json!({ "degree": 2, "knots": [0, 0, 0, 5, 5, 5], "values": [1, "a", 1] }),
        &["step[0].alpha.values[1]", "\"a\""],
    );
    refused(&bench, "wave.loft.json", tune(json!({})), &["\"alpha\" is missing"]);
}

#[test]
fn ranges_outside_and_reversed() {
    let bench = LOFTSMAN.bench().with_wave();
    for (range, words) in [
        (json!([3, 1]), ["[3, 1] is reversed", "[1, 3]"]),
        (json!([2, 2]), ["[2, 2] is empty", "larger"]),
        (json!([-1, 2]), ["[-1, 2] reaches out of the domain", "[0, 5]"]),
        (json!([1, 9]), ["[1, 9] reaches out of the domain", "[0, 5]"]),
        (json!([7, 9]), ["[7, 9]", "[0, 5]"]),
        (json!([1]), ["step[0].range", "two parameters"]),
        (json!([1, 2, 3]), ["step[0].range", "two parameters"]),
    ] {
        refused(&bench, "wave.loft.json", tune(json!({ "alpha": 2, "range": range })), &words);
    }
    refused(
        &bench,
        "wave.loft.json",
        tune(json!({ "alpha": 2, "through": [{ "at": 7, "to": [1, 1, 1] }] })),
        &["7 is outside the domain [0, 5]"],
    );
}

/// Which conditions, how many equations, and how many values α would need: two a point, for the curve is plane.
#[test]
fn ends_that_ask_for_more_than_alpha_has() {
    let bench = LOFTSMAN.bench().with_wave();
    let linear = |count: usize| {
        let inner = (1..count - 1).map(|k| 5.0 * k as f64 / (count - 1) as f64);
        let knots: Vec<f64> = [0.0, 0.0].into_iter().chain(inner).chain([5.0, 5.0]).collect();
        json!({ "degree": 1, "knots": knots, "values": vec![1.5; count] })
    };
    for (fields, words) in [
        (
            json!({ "alpha": { "degree": 0, "knots": [0, 5], "values": [2] } }),
            vec!["ends that stay", "2 equations", "α has 1 value", "at least 3"],
        ),
        (
            json!({ "alpha": linear(2), "continuity": 2 }),
            vec![
                "first and second derivatives that stay at both ends",
                "6 equations",
                "2 values",
                "at least 7",
            ],
        ),
        (
            json!({ "alpha": linear(3), "through": [
                { "at": 1, "to": [1, 1, 0] }, { "at": 2, "to": [1, 1, 0] }, { "at": 3, "to": [1, 1, 0] }
            ] }),
            vec!["ends that stay", "3 points to pass through", "8 equations", "3 values", "at least 8"],
        ),
    ] {
        refused(&bench, "wave.loft.json", tune(fields), &words);
    }
    // Enough values, and no α that is positive.
    refused(
        &bench,
        "wave.loft.json",
        tune(json!({ "alpha": [1, 1, 1, 1, 1, 1, 1], "through": [{ "at": 2.5, "to": [2.5, 500, 0] }] })),
        &["α", "not positive"],
    );
    refused(
        &bench,
        "wave.loft.json",
        tune(json!({ "alpha": 2, "ends": "free", "through": [{ "at": 2, "to": [1, 1, 1] }] })),
        &["ends = \"exact\""],
    );
    refused(
        &bench,
        "wave.loft.json",
        tune(json!({ "alpha": 2, "ends": "sharp" })),
        &["step[0].ends", "\"sharp\"", "tangent"],
    );
    refused(
        &bench,
        "wave.loft.json",
        tune(json!({ "alpha": 2, "continuity": 3 })),
        &["step[0].continuity", "0, 1 or 2"],
    );
}

#[test]
fn edges_that_are_not_there() {
    let bench = LOFTSMAN.bench();
    bench.write("box.obj", BOX);
    let at = |edges: Value| json!({ "alpha": edges });
    for (fields, words) in [
        (at(json!([{ "edge": [0, 7], "value": 2 }])), ["step[0].alpha[0].edge", "vertices 0 and 7"]),
        (at(json!([{ "edge": [0, 99], "value": 2 }])), ["step[0].alpha[0].edge", "no control vertex 99"]),
        (at(json!([{ "edge": [0], "value": 2 }])), ["step[0].alpha[0].edge", "two vertices"]),
        (at(json!([{ "edge": [0, 1] }])), ["step[0].alpha[0]", "\"value\" is missing: number, what it is"]),
        (
            at(json!([{ "edge": [0, 1], "value": 2 }, { "edge": [1, 0], "value": 3 }])),
            ["step[0].alpha[1].edge", "named before"],
        ),
        (json!({ "alpha": 2, "lock": [99] }), ["step[0].lock", "no control vertex 99"]),
        (json!({ "alpha": 2, "range": [0, 1] }), ["step[0].range", "for curves and surfaces"]),
    ] {
        refused(&bench, "box.obj", tune(fields), &words);
    }
}

/// Cages that are no surface: by both schemes, as meshes and as shapes.
#[test]
fn cages_that_are_no_surface() {
    let bench = LOFTSMAN.bench();
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nv 2 2 0\nv 3 1 0\n";
    let band: String = (0..10).map(|k| format!("v {} {k} {}\n", k % 2, k * k % 7)).collect();
    for (text, words) in [
        (format!("{points}f 1 2 3\nf 2 1 4\nf 1 2 5\n"), ["vertices 0 and 1 has 3 faces (0, 1, 2)", "weld"]),
        (
            format!("{points}f 1 2 3\nf 1 2 4\n"),
            ["vertices 0 and 1 is run the same way by faces 0 and 1", "turn face 1 over"],
        ),
        (format!("{points}f 1 2 3\nf 1 4 5\n"), ["vertex 0 joins several fans", "a vertex of its own"]),
        (format!("{points}f 2 3 4\nf 1 2 3 1\n"), ["face 1 has vertex 0 twice", "split it"]),
        (
            format!("{points}f 1 2 3\nf 3 1 2\n"),
            ["vertices 0 and 1 belongs to faces 0 and 1", "the same vertices"],
        ),
        (
            format!("{band}f 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\nf 7 9 10 8\nf 9 2 1 10\n"),
            ["run the same way by faces 0 and 4", "Möbius"],
        ),
        (
            "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n".to_owned(),
            ["the edge between vertices 0 and 1 has no length", "merge"],
        ),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n".to_owned(), ["face 0 has no area", "on one line"]),
    ] {
        bench.write("bad.obj", &text);
        for scheme in ["catmull-clark", "doo-sabin"] {
            for fields in
                [json!({ "levels": 1 }), json!({ "surface": true }), json!({ "levels": 2, "limit": true })]
            {
                let mut fields = fields;
                fields["scheme"] = scheme.into();
                refused(&bench, "bad.obj", subdivide(fields), &words);
            }
        }
    }
    // What the file itself has wrong is told by its own line.
    for (text, words) in [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", ["bad.obj, line 4", "2 corners"]),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 30\n", ["bad.obj, line 4", "vertex 30"]),
        ("v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["bad.obj, line 1", "finite"]),
    ] {
        bench.write("bad.obj", text);
        let recipe = json!({ "input": "bad.obj", "output": "out.obj", "step": [subdivide(json!({}))] });
        bench.write("r.json", recipe.to_string());
        bench.fails(&["run", "r.json"], 1, &words);
    }
}

#[test]
fn fields_of_subdivide_that_name_what_is_not_there() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("box.obj", BOX);
    for (fields, words) in [
        (json!({ "creases": [[0, 7, 1]] }), ["step[0].creases[0]", "no edge between vertices 0 and 7"]),
        (json!({ "creases": [[0, 1, 1], [2, 3, -1]] }), ["step[0].creases[1]", "vertices 2 and 3 is -1"]),
        (json!({ "corners": [[99, 1]] }), ["step[0].corners[0]", "no vertex 99"]),
        (json!({ "holes": [77] }), ["step[0].holes", "no face 77"]),
        (json!({ "holes": [0, 1, 2, 3, 4, 5] }), ["step[0].holes", "all 6 faces are holes"]),
        (json!({ "intervals": [[0, 7, 1]] }), ["step[0].intervals[0]", "vertices 0 and 7"]),
        (json!({ "intervals": [[0, 1, -1]] }), ["step[0].intervals[0]", "-1"]),
        (json!({ "scheme": "loop" }), ["step[0].scheme", "\"loop\""]),
        (json!({ "scheme": "chaikin" }), ["step[0].scheme", "polylines"]),
        (json!({ "levels": -1 }), ["step[0].levels", "negative"]),
        (json!({ "levels": 99 }), ["step[0].levels", "99 levels"]),
        (json!({ "levels": 1.5 }), ["step[0].levels", "whole number"]),
        (json!({ "level": 2 }), ["step[0]", "did you mean \"levels\""]),
    ] {
        refused(&bench, "box.obj", subdivide(fields), &words);
    }
    refused(&bench, "wave.loft.json", subdivide(json!({})), &["\"wave\" is a curve"]);
}
