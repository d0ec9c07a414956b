//! The tables that fields of operations list, declared by `Operation::tables`: a field that is unknown or missing is an error that names the
//! place, each declared field is taken, and two values of it do not come to the same.

use std::path::Path;

use loftsman::kernel::plugin::{Declaration, Field};
use loftsman::recipe::{Recipe, Runner};
use serde_json::{Value, json};

/// A rope with a loop, one beside it, and a sheet.
fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let knots = |n: usize| [vec![0; 3], (0..=n - 3).collect(), vec![n - 3; 3]].concat();
    let curve = |points: Vec<Value>| json!({ "degree": 3, "knots": knots(points.len()), "points": points });
    let looped = (0..12).map(|i| {
        let angle = 0.7 * f64::from(i);
        json!([0.3 * f64::from(i) + angle.sin(), 0.1 * f64::from(i), angle.cos()])
    });
    let beside = (0..8).map(|i| json!([0.4 * f64::from(i), 0.5, 0.1 * f64::from(i % 3)]));
    let side = json!({ "degree": 3, "knots": knots(5) });
    let net: Vec<Vec<Value>> = (0..5)
        .map(|i| (0..5).map(|j| json!([0.5 * f64::from(i), 0.5 * f64::from(j), 2])).collect())
        .collect();
    let objects = [
        json!({ "name": "rope", "curve": curve(looped.collect()) }),
        json!({ "name": "beside", "curve": curve(beside.clone().collect()) }),
        json!({ "name": "third", "curve": curve(beside.rev().collect()) }),
        json!({ "name": "sheet", "surface": { "u": side, "v": side, "points": net } }),
    ];
    let document = json!({ "loftsman": 1, "objects": objects });
    std::fs::write(folder.path().join("in.loft.json"), document.to_string()).unwrap();
    folder
}

/// Runs `simulate` with one table in one of its lists: the document after it and the report, or the error's text.
fn run(folder: &Path, field: &str, table: &Value) -> Result<(Value, Value), String> {
    let step =
        json!({ "op": "simulate", "object": "rope", "seconds": 0.25, "scheme": "implicit", field: [table] });
    run_step(folder, &step)
}

/// The same while the object beside moves along.
fn run_beside(folder: &Path, field: &str, table: &Value) -> Result<(Value, Value), String> {
    let bodies = json!([{ "object": "beside" }]);
    let step = json!({ "op": "simulate", "object": "rope", "seconds": 0.25, "scheme": "implicit", "bodies": bodies, field: [table] });
    run_step(folder, &step)
}

fn run_step(folder: &Path, step: &Value) -> Result<(Value, Value), String> {
    let text = json!({ "input": "in.loft.json", "step": [step] }).to_string();
    let recipe = Recipe::parse("r.json", text.as_bytes(), folder).map_err(|e| e.to_string())?;
    let applied = Runner::new(loftsman::registry()).apply(&recipe).map_err(|e| e.to_string())?;
    loftsman::write(&applied.scene, folder.join("out.loft.json")).unwrap();
    let text = std::fs::read_to_string(folder.join("out.loft.json")).unwrap();
    Ok((serde_json::from_str(&text).unwrap(), serde_json::to_value(&applied.steps).unwrap()))
}

/// A table with what it needs.
fn sample(field: &str, kind: &str) -> Value {
    match (field, kind) {
        ("constraints", "fixed") => json!({ "at": 4.0 }),
        ("constraints", "sliding") => json!({ "near": 4.0 }),
        ("constraints", "knot") => json!({ "near": 7.5, "at": 0.5 }),
        ("constraints", "double-sliding") => json!({ "near": [1.0, 8.0] }),
        ("constraints", "sliding-tangent") => json!({ "near": 4.0, "direction": [0.3, 0.1, 0.6] }),
        ("constraints", "sliding-curvature") => json!({ "near": 4.0, "curvature": [0.1, 0, 0.3] }),
        ("constraints", "tied") => json!({ "at": 4.0, "other": "beside", "other_near": 2.0 }),
        ("pull", "") => json!({ "at": 4.0, "to": [1, 0, 2], "stiffness": 20 }),
        ("forces", "") => json!({ "at": 4.0, "force": [0, 3, 0] }),
        ("bodies", "") => json!({ "object": "beside" }),
        other => panic!("{other:?} has no sample: add one"),
    }
}

/// What else must be said for a field to matter, and two values of it; `null` leaves it out.
fn values(field: &str, kind: &str, name: &str) -> (Value, [Value; 2]) {
    let way = json!({ "to": [[1, 0, 0], [2, 0, 1]] });
    let none = json!({});
    let null = Value::Null;
    match (field, kind, name) {
        ("constraints", "double-sliding", "near") => (none, [json!([1.0, 8.0]), json!([0.8, 7.5])]),
        ("constraints", "tied", "near") => (json!({ "at": null }), [json!(4.0), json!(3.0)]),
        ("constraints", "tied", "other_at") => (json!({ "other_near": null }), [json!(2.0), json!(3.0)]),
        ("constraints", _, "kind") => {
            (json!({ "near": null, "at": 4.0 }), [json!("fixed"), json!("position")])
        }
        ("constraints" | "pull", _, "to") => (none, [json!([1, 0, 0]), json!([[1, 0, 0], [1, 1, 0]])]),
        (_, _, "arrive") => (way, [json!(0.1), json!(0.25)]),
        (_, _, "axis") => (none, [json!("x"), json!(["x", "z"])]),
        ("bodies", _, "object") => (none, [json!("beside"), json!("third")]),
        ("bodies", _, "shear") => (json!({ "object": "sheet" }), [json!(3.0), json!(300.0)]),
        ("bodies", _, "still") => (none, [json!(true), json!(false)]),
        // Where both have it.
        ("constraints", "knot", "object") => (json!({ "near": 3.5 }), [null, json!("beside")]),
        ("constraints", "double-sliding", "object") => {
            (json!({ "near": [1.0, 4.0] }), [null, json!("beside")])
        }
        ("constraints", "tied", "object") => (json!({ "other": "third" }), [null, json!("beside")]),
        (_, _, "object") => (none, [null, json!("beside")]),
        (_, _, "other") => (none, [json!("beside"), json!("third")]),
        (_, _, "name") => (none, [json!("one"), json!("two")]),
        (_, _, "from") => (none, [json!(0), json!(0.125)]),
        (_, _, "until") => (none, [null, json!(0.125)]),
        (_, _, "at" | "near" | "other_near") => (none, [json!(3.5), json!(2.5)]),
        (_, _, "direction" | "curvature") => (none, [json!([0.2, 0, 0.4]), json!([0, 0.3, 0.2])]),
        (_, _, "force") => (none, [json!([0, 3, 0]), json!([0, 0, 3])]),
        (_, _, "stiffness" | "mass" | "damping" | "bending" | "viscosity") => {
            (none, [json!(3.0), json!(30.0)])
        }
        (_, _, "rest") => (none, [json!(0.9), json!(1.1)]),
        other => panic!("{other:?} has no two values: add them"),
    }
}

/// Every table that `simulate` declares: its field, its kind, and all fields of it.
fn tables() -> Vec<(&'static str, &'static str, Vec<Field>)> {
    let operation = loftsman::registry().find_operation("simulate", "").unwrap();
    let mut all = Vec::new();
    for table in operation.tables() {
        let listed = operation.declaration().fields.iter().any(|f| f.name == table.field);
        assert!(listed && !table.help.is_empty(), "{} lists tables and is no field", table.field);
        if table.kinds.is_empty() {
            all.push((table.field, "", table.fields.to_vec()));
        }
        for Declaration { name, help, fields } in table.kinds {
            assert!(!help.is_empty(), "{name}");
            all.push((table.field, *name, [table.fields, *fields].concat()));
        }
    }
    all
}

fn whole(field: &str, kind: &str) -> Value {
    let mut table = sample(field, kind);
    if !kind.is_empty() {
        table["kind"] = json!(kind);
    }
    table
}

#[test]
fn tables_take_what_is_declared_and_nothing_else() {
    let folder = bench();
    let all = tables();
    assert_eq!(all.len(), 10, "{all:?}");
    for (field, kind, fields) in &all {
        run(folder.path(), field, &whole(field, kind)).unwrap_or_else(|e| panic!("{field} {kind}: {e}"));
        // A name of none of its fields, each of which is one of another table.
        let others = all.iter().flat_map(|(_, _, others)| others).map(|f| f.name).chain(["nearr", "ätt"]);
        for name in others.filter(|name| fields.iter().all(|f| f.name != *name)) {
            let mut table = whole(field, kind);
            table[name] = json!(1);
            let refused = run(folder.path(), field, &table).unwrap_err();
            let place = format!("step[0].{field}[0]: unknown field \"{name}\"");
            assert!(refused.contains(&place) && refused.contains("line 1"), "not {place}: {refused}");
        }
        for needed in fields.iter().filter(|f| f.default.is_none()) {
            let mut table = whole(field, kind);
            table.as_object_mut().unwrap().remove(needed.name).unwrap_or_else(|| panic!("{kind} {needed:?}"));
            let refused = run(folder.path(), field, &table).unwrap_err();
            let place = format!("step[0].{field}[0]: the field \"{}\" is missing", needed.name);
            assert!(refused.contains(&place), "not {place}: {refused}");
        }
    }
}

#[test]
fn fields_of_tables_change_what_comes_out() {
    let folder = bench();
    let (mut tried, mut swallowed) = (0, Vec::new());
    for (field, kind, fields) in tables() {
        for Field { name, .. } in fields {
            let (base, both) = values(field, kind, name);
            let outcome = |value: &Value| {
                let mut table = whole(field, kind);
                let own = json!({ name: value });
                for (name, value) in base.as_object().unwrap().iter().chain(own.as_object().unwrap()) {
                    if value.is_null() {
                        table.as_object_mut().unwrap().remove(name);
                    } else {
                        table[name] = value.clone();
                    }
                }
                // Other kinds have other fields.
                if name == "kind" {
                    table.as_object_mut().unwrap().retain(|name, _| name == "kind" || name == "at");
                }
                // Another object moves too, or it could not do what is asked of it.
                if name == "object" && field != "bodies" {
                    run_beside(folder.path(), field, &table)
                } else {
                    run(folder.path(), field, &table)
                }
            };
            let what = format!("{field} {kind} {name} = {} and {}", both[0], both[1]);
            match both.each_ref().map(outcome) {
                [Ok(a), Ok(b)] if a != b => {}
                [Ok(_), Ok(_)] => swallowed.push(what),
                [a, b] => swallowed.push(format!("{what}: {:?} {:?}", a.err(), b.err())),
            }
            tried += 1;
        }
    }
    assert!(swallowed.is_empty(), "{} of {tried}:\n{}", swallowed.len(), swallowed.join("\n"));
    assert!(tried >= 80, "{tried}");
}

#[test]
fn axes_are_one_or_a_list() {
    let folder = bench();
    for (axis, word) in [
        (json!("xy"), "\"xy\" is no axis"),
        (json!([]), "the list is empty"),
        (json!(["x", "x"]), "\"x\" is listed twice"),
        (json!(["x", 3]), "3 is no axis"),
        (json!(true), "true is no axis"),
    ] {
        let table = json!({ "kind": "fixed", "at": 4.0, "axis": axis });
        let refused = run(folder.path(), "constraints", &table).unwrap_err();
        assert!(refused.contains("step[0].constraints[0].axis") && refused.contains(word), "{refused}");
    }
}

/// Every kind of constraint that is registered and linear holds in `simulate`: with its location fixed, and where the kind has `near`, floating. The
/// others are refused in words.
#[test]
fn every_linear_kind_holds_while_things_move() {
    let folder = bench();
    let (mut held, mut floating, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    for declaration in loftsman::registry().functionals() {
        let name = declaration.name;
        let has = |field: &str| declaration.fields.iter().any(|f| f.name == field);
        let mut table = json!({ "kind": name, "name": "it" });
        for field in declaration.fields {
            table[field.name] = match field.name {
                "at" => json!(if name == "position" { 4.0 } else { 3.0 }),
                "index" => json!(2),
                "terms" => json!([{ "vertex": 0, "vector": [1, 2, 3] }]),
                "to" => json!([0.3, 0.1, 1]),
                "with" if name == "match" => json!({ "object": "sheet", "edge": "u0" }),
                "with" => json!({ "object": "beside", "at": 1.0 }),
                _ if field.default.is_some() => continue,
                "edge" => json!("u1"),
                "curve" => json!("beside"),
                _ => json!([0, 0, 1]),
            };
        }
        // Drawn in soon, so that conditions hold at the end.
        let step = |table: &Value| {
            let step = json!({ "op": "simulate", "object": "rope", "seconds": 0.25, "scheme": "implicit", "draw": 0.005, "constraints": [table] });
            run_step(folder.path(), &step)
        };
        match step(&table) {
            Ok((_, report)) => {
                let error = report[0]["constraints"][0]["residual"].as_f64().unwrap();
                assert!(error < 1e-6, "{name}: {error}");
                held.push(name);
            }
            // What is of surfaces, not linear, or not to be had of this rope, by its name; never its fields.
            Err(error) => {
                let word = error.contains("not linear") || error.contains("surface") || error.contains(name);
                let fields = error.contains("unknown field") || error.contains("is missing");
                assert!(error.contains("step[0]") && word && !fields, "{name}: {error}");
                refused.push(name);
                continue;
            }
        }
        if has("near") {
            table.as_object_mut().unwrap().remove("at");
            table["near"] = json!(4.0);
            step(&table).unwrap_or_else(|e| panic!("{name} near: {e}"));
            floating.push(name);
        }
    }
    println!("held {held:?}, floating {floating:?}, refused {refused:?}");
    for name in ["position", "derivative", "vertex", "linear", "tangent", "orthogonal"] {
        assert!(held.contains(&name), "{name} of {held:?}, {refused:?}");
    }
    // What a rope cannot be asked: not linear, of surfaces, or not to be had of this one.
    let never = [
        "magnitude",
        "normal",
        "curvature",
        "signed-curvature",
        "symmetry",
        "area",
        "volume",
        "centroid",
        "length",
        "surface-area",
        "closed",
        "edge",
        "match",
    ];
    assert_eq!(refused, never);
    assert_eq!(floating, ["position", "derivative", "tangent", "orthogonal"]);
}
