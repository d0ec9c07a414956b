//! What is declared holds: a field that is unknown, missing or of the wrong kind is an error that names the place and the field,
//! and one that is known is not swallowed.

use std::path::Path;

use loftsman::kernel::plugin::{Field, Parameters, ReadOptions, WriteOptions};
use loftsman::recipe::{Recipe, Runner};
use loftsman_tests::curves::Sequence;
use serde_json::{Value, json};

use super::conformance::{merged, operation_sample, with_squares};

/// Runs one step on the document `in.loft.json`: the document after it and the report, or the error's text.
fn run(folder: &Path, op: &str, fields: &Value) -> Result<(Value, Value), String> {
    let mut step = json!({ "op": op });
    for (name, value) in fields.as_object().unwrap() {
        step[name] = value.clone();
    }
    let text = json!({ "input": "in.loft.json", "step": [step] }).to_string();
    let recipe = Recipe::parse("r.json", text.as_bytes(), folder).map_err(|e| e.to_string())?;
    let applied = Runner::new(loftsman::registry()).apply(&recipe).map_err(|e| e.to_string())?;
    loftsman::write(&applied.scene, folder.join("out.loft.json")).unwrap();
    let text = std::fs::read_to_string(folder.join("out.loft.json")).unwrap();
    Ok((serde_json::from_str(&text).unwrap(), serde_json::to_value(&applied.steps).unwrap()))
}

fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    loftsman::write(&with_squares(), folder.path().join("in.loft.json")).unwrap();
    folder
}

fn pick<'a, T>(random: &mut Sequence, all: &'a [T]) -> &'a T {
    &all[((random.next_number() * all.len() as f64) as usize).min(all.len() - 1)]
}

/// A word that no declaration knows: a known one misspelt, or letters.
fn misspelt(random: &mut Sequence, known: &[&str]) -> String {
    loop {
        let mut word: Vec<char> = pick(random, known).chars().collect();
        let at = ((random.next_number() * word.len() as f64) as usize).min(word.len() - 1);
        let letter = *pick(random, &['a', 'e', 'q', 'x', '_', 'é', 'T']);
        match pick(random, &[0, 1, 2, 3]) {
            0 => word[at] = letter,
            1 => word.insert(at, letter),
            2 => drop(word.remove(at)),
            _ => word = (0..3 + at).map(|_| *pick(random, &['q', 'x', 'z', 'k'])).collect(),
        }
        let word: String = word.into_iter().collect();
        if !word.is_empty() && word != "op" && !known.contains(&word.as_str()) {
            return word;
        }
    }
}

/// Every table that a step's fields hold, by its path, and the names known in it.
fn tables(fields: &Value, declared: &[Field]) -> Vec<(String, Vec<&'static str>)> {
    let registry = loftsman::registry();
    let names = |fields: &[Field]| fields.iter().map(|f| f.name).collect::<Vec<_>>();
    let mut all = vec![(String::new(), names(declared))];
    let kind_fields = |table: &Value, more: &[&'static str]| {
        let kind = table["kind"].as_str().unwrap();
        let found = registry.functionals().find(|d| d.name == kind).unwrap();
        [names(found.fields), more.to_vec()].concat()
    };
    for (k, table) in fields["constraints"].as_array().into_iter().flatten().enumerate() {
        let wishes = ["kind", "axis", "to", "by", "scale", "keep", "at_least", "at_most"];
        all.push((format!(".constraints[{k}]"), kind_fields(table, &wishes)));
    }
    if fields["handle"].is_object() {
        all.push((".handle".into(), kind_fields(&fields["handle"], &["kind", "pick"])));
    }
    all
}

fn inside<'a>(fields: &'a mut Value, path: &str) -> &'a mut Value {
    let pointer = path.replace("[", "/").replace(']', "").replace('.', "/");
    fields.pointer_mut(&pointer).unwrap()
}

#[test]
fn unknown_fields_are_errors_that_name_the_place() {
    let folder = bench();
    let mut random = Sequence::new(4711);
    let mut tried = 0;
    for round in 0..10 {
        for operation in loftsman::registry().operations() {
            let declaration = operation.declaration();
            let fields = operation_sample(declaration.name);
            for (path, known) in tables(&fields, declaration.fields) {
                let word = misspelt(&mut random, &known);
                let mut wrong = fields.clone();
                let values = [json!(1), json!(true), json!("x"), json!([1, 2, 3]), json!({})];
                let value = pick(&mut random, &values);
                inside(&mut wrong, &path)[&word] = value.clone();
                let error = run(folder.path(), declaration.name, &wrong).unwrap_err();
                let place = format!("step[0]{path}: unknown field \"{word}\"");
                assert!(error.contains(&place) && error.contains("line 1"), "{round}: not {place}: {error}");
                tried += 1;
            }
        }
    }
    assert!(tried >= 200, "{tried}");
}

#[test]
fn missing_fields_are_errors_that_name_the_place() {
    let folder = bench();
    let mut tried = 0;
    for operation in loftsman::registry().operations() {
        let declaration = operation.declaration();
        for field in declaration.fields.iter().filter(|f| f.default.is_none()) {
            let mut fields = operation_sample(declaration.name);
            fields.as_object_mut().unwrap().remove(field.name);
            let error = run(folder.path(), declaration.name, &fields).unwrap_err();
            let place = format!("step[0]: the field \"{}\" is missing", field.name);
            assert!(error.contains(&place), "{}: not {place}: {error}", declaration.name);
            tried += 1;
        }
    }
    // Of constraints, on a curve; `with` and the like are given where they are needed.
    for declaration in loftsman::registry().functionals() {
        for field in declaration.fields.iter().filter(|f| f.default.is_none()) {
            let mut table = json!({ "kind": declaration.name, "keep": true });
            for other in declaration.fields.iter().filter(|f| f.default.is_none() && f.name != field.name) {
                table[other.name] = match other.name {
                    "at" => json!(1.2),
                    "index" => json!(0),
                    "with" if declaration.name == "match" => json!({ "object": "cap", "edge": "u0" }),
                    "with" => json!({ "object": "rational", "at": 0.0 }),
                    "edge" => json!("u1"),
                    "curve" => json!("rational"),
                    "terms" => json!([{ "vertex": 0, "vector": [1, 2, 3] }]),
                    _ => json!([0, 0, 1]),
                };
            }
            let fields = json!({ "object": "clamped curve", "constraints": [table] });
            let error = run(folder.path(), "edit", &fields).unwrap_err();
            let named =
                error.contains("step[0].constraints[0]") && error.contains(&format!("\"{}\"", field.name));
            assert!(named, "{}: {} is missing: {error}", declaration.name, field.name);
            tried += 1;
        }
    }
    assert!(tried >= 25, "{tried}");
}

/// A kind takes the forms of a location that its declaration lists, and refuses the others at their place.
#[test]
fn places_are_taken_as_they_are_declared() {
    let folder = bench();
    let (mut taken, mut refused) = (0, 0);
    for declaration in loftsman::registry().functionals() {
        for place in declaration.fields.iter().filter(|field| matches!(field.name, "at" | "near")) {
            let (number, pair) = (place.takes.contains("number"), place.takes.contains("[u, v]"));
            assert!(place.takes.contains("{ closest = [x, y, z] }"), "{}: {}", declaration.name, place.takes);
            let closest = json!({ "closest": [0.2, 0.3, 0.1] });
            for (object, value, declared) in [
                ("clamped curve", json!(1.2), number),
                ("patch", json!([0.4, 0.6]), pair),
                ("clamped curve", closest.clone(), number),
                ("patch", closest, pair),
            ] {
                let mut table = json!({ "kind": declaration.name, "keep": true, place.name: value });
                for field in declaration.fields.iter().filter(|f| f.default.is_none() && f.name != place.name)
                {
                    table[field.name] = match field.name {
                        "with" => json!({ "object": "rational", "at": 0.0 }),
                        _ => json!([0, 0, 1]),
                    };
                }
                let fields = json!({ "object": object, "constraints": [table] });
                let at = format!("constraints[0].{}", place.name);
                let error = run(folder.path(), "edit", &fields).err().unwrap_or_default();
                let what = format!("{} {} = {value} on a {object}", declaration.name, place.name);
                assert_eq!(!error.contains(&at), declared, "{what}: {error}");
                if declared { taken += 1 } else { refused += 1 }
            }
        }
    }
    assert!(taken >= 20 && refused >= 10, "{taken} taken, {refused} refused");
}

/// Whether a declaration's words for people let a JSON value be.
fn may_take(field: &Field, value: &Value) -> bool {
    let takes = field.takes;
    let says = |words: &[&str]| words.iter().any(|w| takes.contains(w));
    match value {
        Value::Null => false,
        Value::Bool(_) => says(&["true"]),
        Value::Number(_) => says(&["number", "count", "length", "degrees", "0 |", "to 25", "to 30"]),
        // A name that nothing has, or a word that is none of those listed, is no value either.
        Value::String(_) => false,
        Value::Array(_) => says(&["["]) || takes.contains("rows"),
        Value::Object(_) => says(&["{"]),
    }
}

#[test]
fn values_of_the_wrong_kind_are_errors_that_name_the_field() {
    let folder = bench();
    let mut random = Sequence::new(815);
    let (mut tried, mut swallowed) = (0, Vec::new());
    for _ in 0..2 {
        for operation in loftsman::registry().operations() {
            let declaration = operation.declaration();
            for field in declaration.fields {
                let number = (random.next_number() * 64.0).round() / 8.0;
                let values = [
                    Value::Null,
                    json!(true),
                    json!(number),
                    json!("nonsense"),
                    json!([[true]]),
                    json!({ "no": 1 }),
                ];
                let value = pick(&mut random, &values);
                // A new name may be any.
                let name = matches!(field.name, "name" | "to") && value.is_string();
                if may_take(field, value) && !value.is_array() && !value.is_object() || name {
                    continue;
                }
                let mut fields = operation_sample(declaration.name);
                fields[field.name] = value.clone();
                let place = format!("step[0].{}", field.name);
                let what = format!("{} {} = {value}", declaration.name, field.name);
                match run(folder.path(), declaration.name, &fields) {
                    Ok(_) => swallowed.push(what),
                    Err(error) if !error.contains(&place) => swallowed.push(format!("{what}: {error}")),
                    Err(_) => {}
                }
                tried += 1;
            }
        }
    }
    assert!(swallowed.is_empty(), "{} of {tried}:\n{}", swallowed.len(), swallowed.join("\n"));
    assert!(tried >= 150, "{tried}");
}

/// Two values of a field, and what else must be asked for it to matter. `None` leaves it out.
struct Pair {
    op: &'static str,
    field: &'static str,
    base: Value,
    values: [Value; 2],
}

/// For each field of each operation, values that are not the same; numbers among them are random.
fn pairs(random: &mut Sequence) -> Vec<Pair> {
    let mut n = || 0.1 + (random.next_number() * 256.0).round() / 320.0;
    let mut all = Vec::new();
    let mut add =
        |op, field, base: Value, a: Value, b: Value| all.push(Pair { op, field, base, values: [a, b] });
    let none = || json!({});
    let null = || Value::Null;
    let push = |by: f64| json!([{ "kind": "position", "at": 1.2, "by": [0.0, by, 0.0] }]);
    for op in ["edit", "drag"] {
        let beside = json!({ "metric": null, "lock": null });
        add(op, "object", beside.clone(), json!("clamped curve"), json!("rational"));
        let other = json!([{ "kind": "position", "at": 0.4, "by": [0.0, n(), 0.0] }]);
        add(op, "constraints", beside.clone(), other, push(n()));
        add(op, "solver", none(), json!("householder-qr"), json!("sparse"));
        let bend = json!({ "falloff": 1.0 + n() });
        add(op, "metric", json!({ "lock": null }), json!("stretch"), bend);
        add(op, "lock", json!({ "metric": null }), json!([2]), json!([3]));
        add(op, "locality", beside.clone(), null(), json!(5));
        add(op, "within", beside.clone(), null(), json!([0.5, 1.9]));
        let wide = json!([{ "kind": "position", "at": 1.2, "by": [0, n(), 0] }, { "kind": "position", "at": 1.2, "keep": true }]);
        add(op, "best_effort", json!({ "constraints": wide }), json!(false), json!(true));
        // Two places so near that to move one and keep the other takes an adjustment out of all proportion.
        let near = json!([
            { "kind": "position", "at": 1.2, "keep": true },
            { "kind": "position", "at": 1.200_000_01, "by": [0, 1e4 * n(), 0] },
        ]);
        let mut apart = json!({ "constraints": near, "metric": null });
        if op == "drag" {
            apart["handle"] = json!({ "kind": "position", "at": 2.4 });
        }
        add(op, "force", apart, json!(false), json!(true));
        let area =
            json!([{ "kind": "length", "keep": true }, { "kind": "position", "at": 0.4, "by": [0, n(), 0] }]);
        add(
            op,
            "axes",
            json!({ "constraints": area, "metric": null, "lock": null }),
            json!("together"),
            json!("alternating"),
        );
        add(op, "smooth", json!({ "object": "kinked", "metric": null, "lock": null }), json!(0), json!(1));
        // The top of the block, alone or with the sides; where only the bottom may move nothing can be asked of it.
        let top = json!({ "face": 1, "uv": [1.05, 1.5] });
        let solid = match op {
            "edit" => json!({ "object": "block", "metric": null, "lock": null,
                "constraints": [{ "kind": "position", "at": top, "by": [0, 0, 0.1] }] }),
            _ => json!({ "object": "block", "frames": null, "handle": { "kind": "position", "at": top },
                "path": [[0.95, 1.5, 5.2]] }),
        };
        add(op, "faces", solid.clone(), json!([1]), json!([0]));
        add(op, "neighbours", solid, json!(0), json!(1));
    }
    add(
        "drag",
        "handle",
        none(),
        json!({ "kind": "position", "at": 1.2 }),
        json!({ "kind": "position", "at": 0.4 }),
    );
    add("drag", "path", none(), json!([[1, n(), 3]]), json!([[1, 2.0 + n(), 3]]));
    add("drag", "relative", none(), json!(false), json!(true));
    add("drag", "sliding", none(), json!(false), json!(true));
    add("drag", "frames", none(), json!(false), json!(true));
    add("drag", "frames_per_second", none(), json!(24), json!(1.0 + n()));
    for op in ["refine", "elevate", "reverse", "split"] {
        let base = json!({ "object": "patch", "knots": [0.7], "at": 0.3 });
        let keep: &[&str] = match op {
            "refine" => &["object", "knots"],
            "split" => &["object", "at"],
            _ => &["object"],
        };
        let base: Value = keep
            .iter()
            .map(|k| ((*k).to_owned(), base[*k].clone()))
            .collect::<serde_json::Map<_, _>>()
            .into();
        add(op, "direction", base, json!("u"), json!("v"));
        let curve = if op == "refine" { "ring \"é\" <&>" } else { "rational" };
        add(
            op,
            "object",
            if op == "split" { json!({ "direction": null, "at": 0.5 }) } else { none() },
            json!("clamped curve"),
            json!(curve),
        );
    }
    add("refine", "knots", none(), json!([n()]), json!([1.0 + n()]));
    add("elevate", "by", none(), json!(1), json!(3));
    add("split", "at", json!({ "object": "clamped curve", "direction": null }), json!(n()), json!(1.0 + n()));
    add("simplify", "object", none(), json!("patch"), json!("clamped curve"));
    add("simplify", "tolerance", json!({ "object": "clamped curve" }), json!(0), json!(1e6));
    add("simplify", "direction", json!({ "tolerance": 1e6 }), json!("u"), json!("v"));
    add("simplify", "periodic", json!({ "object": "clamped curve" }), json!(false), json!(true));
    add("untrim", "object", none(), json!("window"), json!("patch"));
    let plain = || json!({ "scale": null, "translate": null });
    add("transform", "object", none(), json!("mesh"), json!("cloud"));
    let row = [0, 0, 0, 1];
    add(
        "transform",
        "matrix",
        plain(),
        json!([[n(), 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], row]),
        json!([[2.0 + n(), 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], row]),
    );
    add("transform", "scale", plain(), json!(n()), json!(1.0 + n()));
    let turn = |degrees: f64| json!({ "axis": [0, 1, 1], "degrees": degrees });
    add("transform", "rotate", plain(), turn(10.0 + n()), turn(50.0 + n()));
    add("transform", "translate", plain(), json!([n(), 0, 0]), json!([0, n(), 0]));
    add("tessellate", "object", none(), json!("patch"), json!("clamped curve"));
    add("tessellate", "tolerance", json!({ "object": "clamped curve" }), json!(20.0 + n()), json!(n()));
    add(
        "tessellate",
        "angle",
        json!({ "object": "round", "tolerance": 0.05 }),
        json!(5.0 + n()),
        json!(60.0 + n()),
    );
    add("tessellate", "colors", json!({ "object": "patch" }), json!("mean"), json!("gaussian"));
    add(
        "tessellate",
        "range",
        json!({ "object": "patch", "colors": "mean" }),
        json!([-n(), n()]),
        json!([0, 10.0 + n()]),
    );
    add("tube", "object", none(), json!("clamped curve"), json!("rational"));
    add("tube", "radius", none(), json!(0.1 + n()), json!(1.1 + n()));
    add("tube", "sides", none(), json!(4), json!(9));
    add("tube", "tolerance", json!({ "sides": null }), json!(20.0 + n()), json!(0.01 + 0.1 * n()));
    add("tube", "angle", json!({ "radius": 0.01, "tolerance": 0.05 }), json!(1.0 + n()), json!(60.0 + n()));
    add("tube", "caps", none(), json!("round"), json!("none"));
    add("tube", "uvs", none(), json!(true), json!(false));
    add("tube", "keep", none(), json!(true), json!(false));
    add("tube", "name", none(), json!("hose"), json!("pipe"));
    add("sew", "objects", none(), json!(["patch", "cap"]), json!(["patch"]));
    add("sew", "tolerance", none(), json!(1e-4), json!(1e5));
    add("sew", "keep", none(), json!(true), json!(false));
    add("sew", "name", none(), json!("one"), json!("other"));
    for op in ["line", "polyline", "circle", "arc", "ellipse", "revolve", "edge", "sample", "offset", "sweep"]
    {
        add(op, "name", none(), json!("one"), json!("other"));
    }
    add("line", "from", none(), json!([n(), 0, 0]), json!([0, n(), 0]));
    add("line", "to", none(), json!([n(), 0, 0]), json!([0, n(), 0]));
    add(
        "polyline",
        "points",
        none(),
        json!([[n(), 0, 0], [1, 1, 1], [2, 1, 0]]),
        json!([[0, n(), 0], [1, 0, 0]]),
    );
    add("polyline", "closed", none(), json!(false), json!(true));
    add("polyline", "curve", none(), json!(false), json!(true));
    add("circle", "radius", none(), json!(n()), json!(1.0 + n()));
    add("circle", "periodic", none(), json!(false), json!(true));
    add("ellipse", "periodic", none(), json!(false), json!(true));
    let apart = || json!({ "center": null, "normal": null });
    for op in ["circle", "arc", "ellipse"] {
        let base = if op == "ellipse" { none() } else { apart() };
        add(op, "center", base.clone(), json!([0, n(), 0]), json!([0, 1.0 + n(), 0]));
        if op != "ellipse" {
            add(op, "normal", base, json!([0, n(), 1]), json!([n(), 0, 2]));
        }
    }
    add("arc", "from", none(), json!([n(), 1, 0]), json!([1.0 + n(), 0, 2]));
    let three = |field: &str| {
        let mut base = json!({ "degrees": null, "through": [0, 2, 1], "to": [-1, 0, 0] });
        base[field] = json!(null);
        base
    };
    add("arc", "through", three("through"), json!([0, n(), 1]), json!([1, 2.0 + n(), 0]));
    add("arc", "to", three("to"), json!([0, n(), 0]), json!([-1, 0, n()]));
    for op in ["arc", "ellipse", "revolve"] {
        add(op, "degrees", none(), json!(10.0 + 90.0 * n()), json!(-180.0 - 90.0 * n()));
    }
    add("ellipse", "x", none(), json!([n(), 0, 0]), json!([1.0 + n(), 0, 0]));
    add("ellipse", "y", none(), json!([0, n(), 0]), json!([0, 1.0 + n(), 0]));
    add("ellipse", "start", none(), json!(90.0 * n()), json!(100.0 + 90.0 * n()));
    add("revolve", "object", none(), json!("clamped curve"), json!("rational"));
    add("revolve", "point", none(), json!([n(), 0, 0]), json!([1.0 + n(), 0, 0]));
    add("revolve", "axis", none(), json!([n(), 0, 1]), json!([0, n(), 1]));
    add("revolve", "periodic", json!({ "degrees": null }), json!(false), json!(true));
    add("isocurve", "object", none(), json!("patch"), json!("clamped curve"));
    add("isocurve", "u", none(), json!(n()), json!([n(), 1.0 + n()]));
    add("isocurve", "v", json!({ "u": null }), json!(n()), json!([0.5 * n(), 0.9 * n()]));
    add("isocurve", "at", json!({ "u": null }), json!([n(), 0.5 * n()]), json!([0.5 * n(), n()]));
    add("isocurve", "direction", json!({ "u": null, "at": 0.3 + 0.1 * n() }), json!("u"), json!("v"));
    add("isocurve", "name", none(), json!("one"), json!("other"));
    add("edge", "object", json!({ "edge": "v0" }), json!("patch"), json!("clamped curve"));
    add("edge", "edge", none(), json!("u0"), json!("v0"));
    let border = json!({ "object": "pane", "edge": "border 0" });
    add("edge", "tolerance", border, json!(1e-2), json!(1e-5));
    add("sample", "object", none(), json!("clamped curve"), json!("chain"));
    add(
        "sample",
        "objects",
        json!({ "object": null }),
        json!(["clamped curve"]),
        json!(["chain", "clamped curve"]),
    );
    add("sample", "count", none(), json!(5), json!(9));
    add("sample", "spacing", json!({ "count": null }), json!(n() * 100.0), json!(n() * 300.0 + 100.0));
    add("sample", "as", none(), json!("cloud"), json!("polyline"));
    add("offset", "object", none(), json!("square"), json!("lid"));
    add("offset", "distance", none(), json!(0.1 + n()), json!(-0.1 - 0.1 * n()));
    add("offset", "tolerance", none(), json!(1e-3), json!(1e-5));
    add("offset", "corners", none(), json!("round"), json!("open"));
    add("offset", "normal", none(), json!([0, 0, 1.0 + n()]), json!([1, 0, n()]));
    add("sweep", "object", none(), json!("rational"), json!("clamped curve"));
    add("sweep", "path", json!({ "frame": "parallel" }), json!("clamped curve"), json!("rational"));
    add("sweep", "frame", none(), json!("parallel"), json!("least"));
    let upright = json!({ "frame": "upright" });
    add("sweep", "up", upright, json!([0, n(), 1.0 + n()]), json!([1.0 + n(), 0, n()]));
    add("sweep", "tolerance", none(), json!(0.05), json!(0.005));
    add("symmetrize", "object", none(), json!("clamped curve"), json!("rational"));
    add("symmetrize", "point", none(), json!([0, n(), 0]), json!([0, 1.0 + n(), 0]));
    add("symmetrize", "normal", none(), json!([0, 0, 1]), json!([1, n(), 0]));
    let across = json!({ "point": [0, 0.1, 0], "normal": [0, 1, 0] });
    add("symmetrize", "half", across, json!("both"), json!("front"));
    add("symmetrize", "direction", json!({ "object": "patch" }), json!("u"), json!("v"));
    add("simulate", "object", none(), json!("clamped curve"), json!("rational"));
    add("simulate", "seconds", none(), json!(0.125), json!(0.5));
    add("simulate", "settle", none(), json!(true), json!(false));
    add("simulate", "scheme", none(), json!("implicit"), json!("exact"));
    add("simulate", "step", none(), json!(0.01), json!(0.02));
    add("simulate", "frames_per_second", none(), json!(12), json!(24));
    add("simulate", "mass", json!({ "stiffness": 50 }), json!(0.5 + n()), json!(1.6 + n()));
    add("simulate", "stiffness", none(), json!(10.0 + n()), json!(90.0 + n()));
    add(
        "simulate",
        "shear",
        json!({ "object": "patch", "constraints": null }),
        json!(5.0 + n()),
        json!(50.0 + n()),
    );
    add("simulate", "rest", none(), json!(0.9 + 0.05 * n()), json!(1.1 + 0.05 * n()));
    add("simulate", "bending", none(), json!(n()), json!(1.0 + n()));
    add("simulate", "damping", none(), json!(n()), json!(1.0 + n()));
    add("simulate", "viscosity", none(), json!(n()), json!(1.0 + n()));
    add("simulate", "gravity", none(), json!([n(), 0, 0]), json!([0, n(), -1]));
    let held = |at: f64| json!([{ "kind": "fixed", "at": at }]);
    add("simulate", "constraints", none(), held(1.2), held(0.5));
    let pulled = |to: f64| json!([{ "at": 1.2, "to": [to, 2, 3], "stiffness": 5 }]);
    add("simulate", "pull", none(), pulled(1.0), pulled(3.0));
    let pushed = |force: f64| json!([{ "at": 1.2, "force": [force, 0, 0] }]);
    add("simulate", "forces", none(), pushed(1.0), pushed(3.0));
    let others = |mass: f64| json!([{ "object": "rational", "mass": mass }]);
    add("simulate", "bodies", none(), others(1.0), json!([{ "object": "rational", "still": true }]));
    let floats = json!({ "scheme": "epsilon", "constraints": [{ "kind": "sliding", "near": 1.2 }] });
    add("simulate", "epsilon", floats.clone(), json!(0.001), json!(0.5));
    let missing = json!({ "constraints": [{ "kind": "fixed", "at": 1.2, "to": [1, 2, 3] }] });
    add("simulate", "draw", missing, json!(0.02), json!(0.2));
    add("simulate", "settle_frames", json!({ "settle": true }), json!(true), json!(false));
    let turns = json!({ "settle": true, "stiffness": 100, "gravity": [0, 0, 0], "constraints": [
        { "kind": "fixed", "at": 0, "to": [0, 0, 0] },
        { "kind": "sliding", "near": 1.2, "to": [4000, 0, 0] },
        { "kind": "fixed", "at": 2.5, "to": [1000, 0, 4000] },
    ] });
    add("simulate", "corners", turns, json!(true), json!(false));
    add("copy", "object", none(), json!("rational"), json!("cloud"));
    add("copy", "to", none(), json!("once"), json!(["twice", "thrice"]));
    add("merge", "file", none(), json!(merged()), json!([merged(), merged()]));
    add("merge", "unit", none(), json!("mm"), json!("in"));
    add("merge", "read", none(), json!({ "as": "cloud" }), json!({ "as": "polyline" }));
    add("delete", "object", none(), json!("mesh"), json!("cloud"));
    add("rename", "object", none(), json!("mesh"), json!("cloud"));
    add("rename", "to", none(), json!("a"), json!("b"));
    add("fair", "object", json!({ "lock": null }), json!("clamped curve"), json!("rational"));
    add(
        "fair",
        "energy",
        none(),
        json!("stretch"),
        json!([{ "kind": "bend" }, { "kind": "near", "weight": 1.0 + n() }]),
    );
    add("fair", "constraints", none(), push(n()), push(-n()));
    add("fair", "lock", none(), json!([0]), json!([0, 3]));
    add("fair", "within", json!({ "constraints": push(0.01) }), null(), json!(1.0 + n()));
    add("fair", "smooth", json!({ "object": "kinked", "lock": [0, -1] }), json!(0), json!(1));
    add("fair", "solver", none(), json!("householder-qr"), json!("sparse"));
    let fit = || json!({ "object": "spiral", "vertices": null, "tolerance": 0.05, "degree": 3 });
    let ring = |more: Value| {
        let mut base = json!({ "object": "round", "ends": null });
        more.as_object().unwrap().iter().for_each(|(name, value)| base[name] = value.clone());
        base
    };
    add("fine-tune", "object", none(), json!("clamped curve"), json!("round"));
    add("fine-tune", "alpha", none(), json!(1.5 + n()), json!(0.5 * n()));
    for name in ["alpha_u", "alpha_v"] {
        add(
            "fine-tune",
            name,
            json!({ "object": "patch", "alpha": null }),
            json!(1.5 + n()),
            json!(0.5 * n()),
        );
    }
    add("fine-tune", "direction", json!({ "object": "patch" }), json!("u"), json!("v"));
    add("fine-tune", "ends", none(), json!("free"), json!("position"));
    add("fine-tune", "range", ring(json!({ "continuity": 0 })), json!([1, 8]), json!([2, 8.5]));
    add("fine-tune", "continuity", ring(json!({ "range": [0.5, 8.5] })), json!(0), json!(1));
    add("fine-tune", "through", ring(json!({})), null(), json!([{ "at": 2, "to": [0.93, 0.01, 0] }]));
    add("fine-tune", "alpha_at", ring(json!({})), null(), json!([{ "at": 2, "to": 1.1 }]));
    let nudge = json!([{ "kind": "position", "at": 3, "by": [0.01, 0, 0] }]);
    add("fine-tune", "constraints", ring(json!({})), null(), nudge);
    add("fine-tune", "lock", json!({ "object": "square", "ends": null }), json!([0]), json!([2]));
    add("fine-tune", "any_sign", json!({ "alpha": -1.0 }), json!(false), json!(true));
    // So near that α would have to be ten million: no positive one does it.
    let near = json!([{ "at": 2, "to": 1.0 }, { "at": 2.000_000_000_2, "to": 1.01 }]);
    let near = ring(json!({ "alpha_at": near, "any_sign": true }));
    add("fine-tune", "force", near, json!(false), json!(true));
    add("fine-tune", "solver", ring(json!({ "range": [0.5, 8.5] })), json!("householder-qr"), json!("lu"));
    add("subdivide", "object", none(), json!("square"), json!("open"));
    add("subdivide", "scheme", none(), json!("cubic"), json!("chaikin"));
    add("subdivide", "levels", none(), json!(1), json!(3));
    add("subdivide", "limit", none(), json!(false), json!(true));
    add("subdivide", "intervals", none(), null(), json!([1, 2, 1, 3]));
    let sheet = || json!({ "object": "sheet" });
    add("subdivide", "surface", json!({ "object": "sheet", "levels": null }), json!(false), json!(true));
    add("subdivide", "creases", sheet(), null(), json!([[1, 4, 0.5 + n()]]));
    add("subdivide", "corners", sheet(), null(), json!([[4, 0.5 + n()]]));
    add("subdivide", "weld", json!({ "object": "split" }), json!(false), json!(true));
    add("subdivide", "holes", sheet(), null(), json!([1]));
    let tuned = |more: Value| {
        let mut base = json!({ "object": "sheet", "scheme": "doo-sabin" });
        more.as_object().unwrap().iter().for_each(|(name, value)| base[name] = value.clone());
        base
    };
    add("subdivide", "alpha", tuned(json!({})), json!(1.5 + n()), json!(0.5 * n()));
    add("subdivide", "lock", tuned(json!({ "alpha": 1.5 })), json!([0]), json!([5]));
    add("subdivide", "boundary", sheet(), json!("edge-only"), json!("edge-and-corner"));
    add("patches", "object", none(), json!("cushion"), json!("bolster"));
    add("patches", "tolerance", none(), json!(0.01 + 0.1 * n()), json!(1e-4));
    add("fit", "object", none(), json!("chain"), json!("spiral"));
    add("fit", "degree", fit(), json!(2), json!(4));
    add("fit", "tolerance", fit(), json!(0.3), json!(0.001 * n()));
    add(
        "fit",
        "relative_tolerance",
        json!({ "object": "spiral", "vertices": null }),
        json!(0.1),
        json!(1e-4 * n()),
    );
    add("fit", "vertices", json!({ "object": "spiral" }), json!(8), json!(12));
    add("fit", "interpolate", json!({ "object": "spiral", "vertices": null }), json!(false), json!(true));
    add("fit", "closed", json!({ "object": "spiral", "vertices": 12 }), json!(false), json!(true));
    add(
        "fit",
        "corners",
        json!({ "object": "square", "tolerance": 0.01, "vertices": null, "degree": 2 }),
        null(),
        json!(40.0 + n()),
    );
    add(
        "fit",
        "parameters",
        json!({ "object": "spiral", "vertices": 9, "corrections": 0 }),
        json!("chord"),
        json!("uniform"),
    );
    add("fit", "corrections", json!({ "object": "spiral", "vertices": 9 }), json!(0), json!(4));
    add("fit", "ends", json!({ "object": "spiral", "vertices": 9 }), json!("keep"), json!("free"));
    add(
        "fit",
        "merge",
        json!({ "object": "stammer", "vertices": null, "interpolate": true, "degree": 3 }),
        json!(false),
        json!(true),
    );
    add(
        "fit",
        "weights",
        json!({ "object": "chain", "vertices": 4, "degree": 3 }),
        json!([1, 1, 1, 1, 1]),
        json!([1, 10.0 + n(), 1, 1, 1]),
    );
    add(
        "fit",
        "constraints",
        json!({ "object": "spiral", "vertices": 9 }),
        null(),
        json!([{ "kind": "position", "at": 0.5, "to": [n(), 0, 0] }]),
    );
    add("fit", "regularization", json!({ "object": "spiral", "vertices": 9 }), json!(0), json!(n()));
    add("fit", "smooth", fit(), json!(false), json!(true));
    let tight = json!({ "object": "spiral", "degree": 2, "vertices": 5, "tolerance": 1e-7 });
    add("fit", "best_effort", tight, json!(false), json!(true));
    for op in ["fill", "extrude", "loft"] {
        let round = match op {
            "loft" => json!({ "sections": ["round", "round top"], "surface": null }),
            "extrude" => json!({ "objects": ["round"], "surfaces": null }),
            _ => json!({ "objects": ["round"], "size": null }),
        };
        let open = match op {
            "loft" => json!({ "sections": ["open", "round top"], "surface": null }),
            _ => json!({ "objects": ["open"] }),
        };
        add(op, "tolerance", round.clone(), json!(0.3), json!(0.01 * n()));
        let mut coarse = round.clone();
        coarse["tolerance"] = json!(0.05);
        add(op, "angle", coarse, json!(5.0 + n()), json!(60.0));
        add(op, "bridge", open, json!(false), json!(true));
        add(op, "size", round.clone(), json!(0.3 + n()), json!(5.0));
        add(op, "min_angle", round.clone(), json!(0), json!(20.0 + n()));
        add(op, "name", none(), json!("a"), json!("b"));
        if op != "loft" {
            add(op, "objects", none(), json!(["square"]), json!(["round"]));
        }
    }
    add("extrude", "by", none(), json!([0, 0, n()]), json!([0, n(), 2]));
    add("extrude", "surfaces", none(), json!(false), json!(true));
    add("loft", "sections", none(), json!(["square", "lid"]), json!(["round", "round top"]));
    add("loft", "degree", json!({ "sections": ["round", "round middle", "round top"] }), json!(1), json!(2));
    add("loft", "caps", none(), json!(true), json!(false));
    add("loft", "surface", none(), json!(false), json!(true));
    let lax = || json!({ "tolerance": 10.0, "angle": 170 });
    add("match", "object", lax(), json!("patch"), json!("clamped curve"));
    add("match", "edge", lax(), json!("u0"), json!("u1"));
    let beside = |edge: &str| json!({ "object": "cap", "edge": edge });
    add("match", "with", lax(), beside("u0"), beside("u1"));
    add("match", "continuity", json!({ "angle": null }), json!(0), json!(1));
    let coarse = json!({ "object": "cap", "edge": "v0", "with": { "object": "patch", "edge": "v0" },
        "continuity": 0, "angle": null, "refine": false });
    add("match", "tolerance", coarse, json!(1e-9), json!(1e5));
    add("match", "angle", json!({ "refine": false }), json!(1e-9), json!(170));
    let curved = || json!({ "continuity": 2, "refine": false, "angle": 180 });
    add("match", "curvature", curved(), json!(1e-9), json!(1e9));
    add("match", "keep", lax(), json!(0), json!("nothing"));
    add("match", "metric", lax(), json!("least"), json!("bend"));
    add("match", "refine", json!({ "angle": 20 }), json!(false), json!(true));
    let meet = || json!({ "object": "short line", "with": "round" });
    add("intersect", "object", json!({ "with": "round" }), json!("line"), json!("round half"));
    add(
        "intersect",
        "with",
        json!({ "object": "line", "tolerance": 1e-6 }),
        json!("round"),
        json!("round half"),
    );
    add("intersect", "tolerance", meet(), json!(1e-6), json!(0.3));
    add("intersect", "name", meet(), json!("a"), json!("b"));
    let cut = || json!({ "object": "round", "axis": "x", "at": 0.1, "count": null });
    add("section", "object", json!({ "axis": "x", "at": 0.1, "count": null }), json!("round"), json!("line"));
    add(
        "section",
        "plane",
        json!({ "object": "round", "axis": null, "count": null }),
        json!({ "normal": [1, 0, n()] }),
        json!({ "point": [0.1, 0, 0], "normal": [1, 0.5, 0] }),
    );
    add("section", "axis", json!({ "object": "round", "at": 0.1, "count": null }), json!("x"), json!("y"));
    add(
        "section",
        "at",
        json!({ "object": "round", "axis": "x", "count": null }),
        json!(0.1),
        json!([0.2, 0.3]),
    );
    add("section", "count", json!({ "object": "round", "axis": "x" }), json!(1), json!(3));
    add("section", "tolerance", json!({ "axis": "x", "count": 2 }), json!(0.1), json!(1e-5));
    add("section", "name", cut(), json!("a"), json!("b"));
    add("fit-shape", "object", none(), json!("clamped curve"), json!("rational"));
    add("fit-shape", "points", none(), json!("chain"), json!("spiral"));
    let even = || json!((0..40).map(|k| 1 + k % 2).collect::<Vec<i32>>());
    let uneven = || json!((0..40).map(|k| 1 + k).collect::<Vec<i32>>());
    add("fit-shape", "weights", json!({ "points": "spiral" }), even(), uneven());
    add("fit-shape", "energy", none(), json!("stretch"), json!("bend"));
    add("fit-shape", "fair", none(), json!(0.01), json!(0.1 * n()));
    let held = |x: f64| json!([{ "kind": "position", "at": 0.5, "by": [x, 0, 0] }]);
    add("fit-shape", "constraints", none(), held(n()), held(-n()));
    add("fit-shape", "lock", none(), json!([0]), json!([0, 3]));
    add("fit-shape", "relative_tolerance", none(), json!(1.0), json!(1e-9));
    add("fit-shape", "iterations", none(), json!(1), json!(20));
    add("fit-shape", "smooth", json!({ "object": "kinked" }), json!(0), json!(1));
    add("fit-shape", "solver", json!({ "constraints": held(0.1) }), json!("householder-qr"), json!("sparse"));
    all
}

/// The scene, and what some fields need to matter: a curve with a corner that was smooth, round outlines, points.
fn furnished() -> tempfile::TempDir {
    let folder = bench();
    let path = folder.path().join("in.loft.json");
    let mut document: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let ring = |z: f64, r: f64| {
        let points: Vec<_> = (0..9)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 9.0).sin_cos();
                json!([r * cos + z, r * sin, z])
            })
            .collect();
        json!({ "degree": 3, "periodic": true, "knots": (0..=9).collect::<Vec<_>>(), "points": points })
    };
    let spiral: Vec<_> = (0..40)
        .map(|i| {
            let t = 0.2 * f64::from(i);
            let r = 1.0 + 0.1 * t + 0.02 * (7.3 * f64::from(i)).sin();
            json!([r * t.cos(), r * t.sin(), 0.1 * t])
        })
        .collect();
    let stammer = json!([[0, 0, 0], [1, 1, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0], [4, 0, 1]]);
    // Two Bézier pieces that meet smoothly.
    let kinked = json!({ "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2],
        "points": [[0, 0, 0], [1, 2, 0], [2, 2, 0], [3, 1, 0], [4, 0, 0], [5, 1, 0], [6, 3, 0]] });
    let net: Vec<_> = (0..9).map(|k| json!([k / 3, k % 3, k % 2])).collect();
    let faces = [0, 1, 3, 4].map(|a| [a, a + 3, a + 4, a + 1]);
    let sheet = json!({ "points": net, "faces": faces });
    // Two quads, each with vertices of its own along the edge that they share.
    let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [2, 0, 1], [2, 1, 0], [1, 1, 0]];
    let split = json!({ "points": corners, "faces": [[0, 1, 2, 3], [4, 5, 6, 7]] });
    let arc: Vec<_> = (0..12)
        .map(|i| {
            let (sin, cos) = (0.5 * f64::from(i)).sin_cos();
            json!([cos, sin, 0])
        })
        .collect();
    let line = |a: f64, b: f64| json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1], "points": [[a, 0, 0], [b, 0, 0]] });
    let side = json!({ "degree": 2, "periodic": false, "knots": [0, 0, 0, 1, 1, 1] });
    let bowl: Vec<_> =
        (0..3).map(|i| (0..3).map(|j| json!([i, j, (i - 1) * (j - 1)])).collect::<Vec<_>>()).collect();
    let loop_of_it = json!({ "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2],
        "points": [[0.2, 0.5, 0], [0.2, 0.1, 0], [0.8, 0.1, 0], [0.8, 0.5, 0], [0.8, 0.9, 0], [0.2, 0.9, 0], [0.2, 0.5, 0]] });
    let pane = json!({ "surface": { "u": side, "v": side, "points": bowl }, "curves": [],
        "regions": [{ "outer": [{ "curve": loop_of_it, "from": 0, "to": 2 }], "holes": [] }] });
    for (name, kind, what) in [
        ("pane", "trimmed", pane),
        ("kinked", "curve", kinked),
        ("line", "curve", line(-2.0, 2.0)),
        // It ends within the ring, 0.2 or so from it.
        ("short line", "curve", line(0.0, 0.7)),
        ("round half", "curve", ring(0.0, 0.5)),
        ("round", "curve", ring(0.0, 1.0)),
        ("round middle", "curve", ring(1.0, 1.6)),
        ("round top", "curve", ring(2.0, 0.8)),
        ("spiral", "cloud", json!({ "points": spiral })),
        ("stammer", "polyline", json!({ "points": stammer })),
        ("open", "polyline", json!({ "points": arc })),
        ("sheet", "mesh", sheet),
        ("split", "mesh", split),
    ] {
        document["objects"].as_array_mut().unwrap().push(json!({ "name": name, kind: what }));
    }
    std::fs::write(path, document.to_string()).unwrap();
    folder
}

#[test]
fn known_fields_change_what_comes_out_or_are_refused() {
    let folder = furnished();
    let mut random = Sequence::new(99);
    let (mut tried, mut swallowed, mut refused) = (0, Vec::new(), 0);
    let all = pairs(&mut random);
    for operation in loftsman::registry().operations() {
        let declaration = operation.declaration();
        for field in declaration.fields {
            let known = all.iter().any(|p| p.op == declaration.name && p.field == field.name);
            assert!(known, "{} {}: no two values: add them", declaration.name, field.name);
        }
    }
    for pair in &all {
        let outcome = |value: &Value| {
            let mut fields = operation_sample(pair.op);
            let table = fields.as_object_mut().unwrap();
            let own = json!({ pair.field: value });
            for (name, value) in pair.base.as_object().unwrap().iter().chain(own.as_object().unwrap()) {
                if value.is_null() {
                    table.remove(name);
                } else {
                    table.insert(name.clone(), value.clone());
                }
            }
            run(folder.path(), pair.op, &fields)
        };
        let [a, b] = [&pair.values[0], &pair.values[1]].map(outcome);
        let what = format!("{} {} = {} and {}", pair.op, pair.field, pair.values[0], pair.values[1]);
        match (&a, &b) {
            (Err(a), Err(b)) => swallowed.push(format!("{what}: both refused: {a}; {b}")),
            (Err(_), _) | (_, Err(_)) => refused += 1,
            _ if a == b => swallowed.push(what),
            _ => {}
        }
        tried += 1;
    }
    println!("{tried} fields, {refused} with one of two values refused");
    assert!(swallowed.is_empty(), "{} of {tried}:\n{}", swallowed.len(), swallowed.join("\n"));
    assert!(tried >= 100, "{tried}");
}

#[test]
fn options_of_formats_are_checked_and_change_the_bytes() {
    let folder = furnished();
    let scene = loftsman::read_scene(folder.path().join("in.loft.json")).unwrap();
    let mut random = Sequence::new(1234);
    let mut tried = 0;
    for format in loftsman::registry().formats() {
        let declaration = format.declaration();
        let known: Vec<&str> = declaration.options.iter().map(|o| o.name).collect();
        let file = folder.path().join(format!("made.{}", declaration.extensions[0].trim_start_matches('.')));
        let write = |own: &Value| -> Result<Vec<u8>, String> {
            let own = Parameters::new(own.clone(), "options").unwrap();
            let options = WriteOptions { own, ..WriteOptions::default() };
            loftsman::write_with(&scene, &file, &options, loftsman::registry()).map_err(|e| e.to_string())?;
            Ok(std::fs::read(&file).unwrap())
        };
        let read = |own: &Value| {
            let own = Parameters::new(own.clone(), "options").unwrap();
            let options = ReadOptions { own, ..ReadOptions::default() };
            loftsman::read_with(&file, &options, loftsman::registry()).map_err(|e| e.to_string())
        };
        let plain = write(&json!({})).unwrap();
        for _ in 0..25 {
            let mut names = known.clone();
            names.push("split");
            let word = misspelt(&mut random, &names);
            if known.contains(&word.as_str()) {
                continue;
            }
            let own = json!({ word.as_str(): pick(&mut random, &[json!(true), json!("any"), json!(1)]) });
            for error in [write(&own).unwrap_err(), read(&own).map(|_| ()).unwrap_err()] {
                let named = error.contains(&format!("\"{word}\"")) && error.contains(declaration.name);
                assert!(named, "{}: {own}: {error}", declaration.name);
                tried += 1;
            }
        }
        for option in declaration.options {
            let reading = option.help.starts_with("reading: ");
            let choices: Vec<Value> = option
                .takes
                .split(" | ")
                .map(|word| serde_json::from_str(word).unwrap_or_else(|_| panic!("{}", option.takes)))
                .collect();
            for value in [json!("nonsense"), json!(7.5), Value::Null, json!([1]), json!({})] {
                let own = json!({ option.name: value });
                let error =
                    if reading { read(&own).map(|_| ()) } else { write(&own).map(|_| ()) }.unwrap_err();
                assert!(error.contains(option.name), "{} {own}: {error}", declaration.name);
                tried += 1;
            }
            write(&json!({})).unwrap();
            let mut outcomes: Vec<String> = Vec::new();
            for value in &choices {
                let own = json!({ option.name: value });
                outcomes.push(if reading {
                    format!("{:?}", read(&own))
                } else {
                    format!("{:?}", write(&own))
                });
            }
            let first = &outcomes[0];
            assert!(outcomes.iter().any(|o| o != first), "{} {}: swallowed", declaration.name, option.name);
        }
        assert_eq!(write(&json!({})).unwrap(), plain);
    }
    assert!(tried >= 200, "{tried}");
}
