//! Cages subdivided here, and by Blender's modifier.

use std::path::Path;

use loftsman_tests::oracle::{Oracle, at, number};
use serde_json::{Value, json};

use crate::{LOFTSMAN, apart, save};

fn points(list: &Value) -> Vec<[f64; 3]> {
    let point = |p: &Value| [0, 1, 2].map(|k| p[k].as_f64().unwrap());
    list.as_array().unwrap().iter().map(point).collect()
}

/// A cage of `tests/golden/opensubdiv.json` subdivided by a recipe: its points and the number of its faces.
fn subdivided(folder: &Path, cage: &Value, levels: usize, limit: bool) -> (Vec<[f64; 3]>, usize) {
    let mesh = json!({ "points": cage["points"], "faces": cage["faces"] });
    let document = json!({ "loftsman": 1, "objects": [{ "name": "cage", "mesh": mesh }] });
    save(folder, "cage.loft.json", &document);
    let mut step =
        json!({ "op": "subdivide", "levels": levels, "limit": limit, "boundary": cage["boundary"] });
    for name in ["creases", "corners"] {
        step[name] = cage[name].clone();
    }
    let recipe = json!({ "input": "cage.loft.json", "output": "fine.loft.json", "step": [step] });
    save(folder, "recipe.json", &recipe);
    LOFTSMAN.done(folder, &["run", "recipe.json"]);
    let text = std::fs::read_to_string(folder.join("fine.loft.json")).unwrap();
    let fine: Value = serde_json::from_str(&text).unwrap();
    let mesh = at(&fine, "objects/0/mesh");
    (points(&mesh["points"]), mesh["faces"].as_array().unwrap().len())
}

/// Every point of one is one of the other, to Blender's single precision.
#[test]
fn blender_makes_the_same_of_cages() {
    let golden = loftsman_tests::repository().join("tests/golden/opensubdiv.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(golden).unwrap()).unwrap();
    let cages = golden["cages"].as_array().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    // Closed and open, n-gons, creases and corners of all sharpnesses; none with a vertex of two creased edges, which Blender sharpens.
    for (number, levels, limit) in [
        (0, 2, false),
        (25, 2, false),
        (60, 1, false),
        (110, 2, false),
        (170, 2, false),
        (0, 2, true),
        (25, 1, true),
    ] {
        let mut cage = cages[number].clone();
        let (ours, faces) = subdivided(folder.path(), &cage, levels, limit);
        cage["levels"] = levels.into();
        cage["limit"] = limit.into();
        let file = save(folder.path(), &format!("cage-{number}-{levels}-{limit}.json"), &cage);
        let Some(reports) = Oracle::BlenderSubdivision.ask(&[file], &[]) else { return };
        let theirs = points(at(&reports[0], "points"));
        assert_eq!(number_of(&reports[0], "levels"), levels);
        assert_eq!(
            (ours.len(), faces),
            (theirs.len(), at(&reports[0], "faces").as_array().unwrap().len()),
            "cage {number}"
        );
        for p in &ours {
            let nearest = theirs.iter().map(|q| apart(*p, *q)).fold(f64::INFINITY, f64::min);
            assert!(
                nearest < 4e-6,
                "cage {number}, level {levels}, limit {limit}: {p:?} is {nearest:e} away"
            );
        }
        compared += 1;
    }
    assert_eq!(compared, 7);
}

fn number_of(report: &Value, path: &str) -> usize {
    number(report, path) as usize
}
