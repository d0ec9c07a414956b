//! What `loftsman plugins document` says a document holds is what the reader takes: it names all fields of a table when it meets one that it
//! does not know.

use std::collections::BTreeSet;

use loftsman::document::FIELDS;
use serde_json::{Value, json};

/// A field that nothing has, unlike any name.
const JUNK: &str = "qqqqzzzz";

/// What the reader says of a document.
fn refusal(document: &Value) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("d.loft.json");
    std::fs::write(&file, document.to_string()).unwrap();
    loftsman::read_scene(&file).map(|_| ()).unwrap_err().to_string()
}

/// The fields that the reader takes where the junk stands.
fn taken(document: &Value) -> BTreeSet<String> {
    let said = refusal(document);
    let rest = said.split_once(&format!("has no field \"{JUNK}\"; ")).unwrap_or_else(|| panic!("{said}")).1;
    if rest.starts_with("it takes none") {
        return BTreeSet::new();
    }
    let list = rest.strip_prefix("known are ").unwrap_or_else(|| panic!("{said}"));
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The names in each pair of braces of what a field takes.
fn braces(takes: &str) -> Vec<BTreeSet<String>> {
    let tables = takes.split('{').skip(1).map(|rest| rest.split_once('}').unwrap().0);
    let names =
        |inner: &str| inner.split(',').map(str::trim).filter(|n| !n.is_empty()).map(str::to_owned).collect();
    tables.map(names).collect()
}

fn declared(name: &str) -> Vec<BTreeSet<String>> {
    braces(FIELDS.iter().find(|f| f.name == name).unwrap_or_else(|| panic!("{name} is not declared")).takes)
}

#[test]
fn what_a_document_holds_is_what_the_reader_takes() {
    let junk = || json!({ JUNK: 1 });
    let names = |prefix: &str| -> BTreeSet<String> {
        let all = FIELDS.iter().filter_map(|f| f.name.strip_prefix(prefix));
        all.filter(|name| !name.contains('[')).map(str::to_owned).collect()
    };
    let object =
        |field: &str, value: Value| json!({ "loftsman": 1, "objects": [{ "name": "o", field: value }] });
    let top = |field: &str, value: Value| json!({ "loftsman": 1, "objects": [], field: value });
    assert_eq!(taken(&json!({ "loftsman": 1, JUNK: 1 })), names(""));
    assert_eq!(taken(&object(JUNK, json!(1))), names("objects[]."));
    let mut tables = 0;
    for (name, document) in [
        ("definitions", top("definitions", json!([junk()]))),
        ("layers", top("layers", json!([junk()]))),
        ("materials", top("materials", json!([junk()]))),
        ("images", top("images", json!([junk()]))),
        ("connections", top("connections", json!([junk()]))),
        ("objects[].animation", object("animation", junk())),
        ("objects[].curve", object("curve", junk())),
        ("objects[].surface", object("surface", junk())),
        ("objects[].trimmed", object("trimmed", junk())),
        ("objects[].brep", object("brep", junk())),
        ("objects[].mesh", object("mesh", junk())),
        ("objects[].polyline", object("polyline", junk())),
        ("objects[].cloud", object("cloud", junk())),
        ("objects[].group", object("group", junk())),
        ("objects[].instance", object("instance", junk())),
        ("objects[].same_as", object("same_as", junk())),
    ] {
        assert_eq!(taken(&document), declared(name)[0], "{name}");
        tables += 1;
    }
    // Tables within these.
    assert_eq!(taken(&top("connections", json!([{ "first": junk() }]))), declared("connections")[1]);
    for side in ["u", "v"] {
        assert_eq!(taken(&object("surface", json!({ side: junk() }))), declared("objects[].surface")[1]);
    }
    let brep = declared("objects[].brep");
    for (k, inner) in [
        json!({ "vertices": [junk()] }),
        json!({ "edges": [junk()] }),
        json!({ "faces": [junk()] }),
        json!({ "faces": [{ "loops": [[junk()]] }] }),
        json!({ "solids": [junk()] }),
        json!({ "faces": [{ "form": junk() }] }),
    ]
    .into_iter()
    .enumerate()
    {
        assert_eq!(taken(&object("brep", inner)), brep[k + 1], "table {k} of a brep");
    }
    // No table of names is left unlooked at; what a plug-in's kind has, and names of formats, are not of this list.
    let listed = FIELDS
        .iter()
        .filter(|f| f.takes.contains('{') && !f.name.ends_with("shape") && !f.name.ends_with("statements"));
    assert_eq!(listed.count(), tables);
}

#[test]
fn what_a_document_needs_is_what_the_reader_misses() {
    let whole = json!({ "loftsman": 1, "objects": [{ "name": "o", "group": {} }] });
    for field in FIELDS {
        let mut document = whole.clone();
        let (table, name) = match field.name.strip_prefix("objects[].") {
            Some(name) => (&mut document["objects"][0], name),
            None => (&mut document, field.name),
        };
        let there = table.as_object_mut().unwrap().remove(name).is_some();
        match field.default {
            None => {
                let said = refusal(&document);
                assert!(
                    there && said.contains(&format!("needs the field \"{name}\"")),
                    "{}: {said}",
                    field.name
                );
            }
            Some(_) => assert!(!there || name == "group", "{} may be left out", field.name),
        }
    }
}

/// A recipe's own fields: what is not of its list is refused by name, and all of the list are read, so that a value that none takes is refused.
#[test]
fn recipes_take_the_fields_that_are_declared() {
    let refusal = |recipe: Value| {
        let text = recipe.to_string();
        loftsman::recipe::Recipe::parse("r.json", text.as_bytes(), "").map(|_| ()).unwrap_err().to_string()
    };
    let said = refusal(json!({ JUNK: 1 }));
    assert!(said.contains(&format!("unknown field \"{JUNK}\"")), "{said}");
    let known = said.split_once("known here: ").unwrap_or_else(|| panic!("{said}")).1;
    let known: Vec<&str> = known.split(", ").map(str::trim).collect();
    let declared: Vec<&str> = loftsman::recipe::FIELDS.iter().map(|f| f.name).collect();
    assert_eq!(known, declared);
    for name in declared {
        let said = refusal(json!({ name: [[true]] }));
        assert!(said.contains(name), "{name}: {said}");
    }
}
