//! The golden edits once more, as one recipe of three hundred steps: what recipes say is what the library solves.

use serde_json::{Value, json};

use crate::LOFTSMAN;

#[test]
fn a_recipe_of_three_hundred_edits_agrees_with_dense_linear_algebra() {
    let golden: Value = serde_json::from_str(include_str!("../../../tests/golden/edits.json")).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    let name = |number: usize| format!("curve {number}");
    let objects: Vec<Value> = cases
        .iter()
        .enumerate()
        .map(|(i, case)| json!({ "name": name(i), "curve": case["curve"] }))
        .collect();
    let solvers = ["automatic", "sparse", "householder-qr", "lu"];
    let steps: Vec<Value> = cases
        .iter()
        .enumerate()
        .map(|(i, case)| {
            json!({ "op": "edit", "object": name(i), "solver": solvers[i % solvers.len()],
                    "lock": case["lock"], "constraints": case["constraints"] })
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let recipe = json!({ "input": "in.loft.json", "output": ["out.loft.json"], "step": steps });
    let document = json!({ "loftsman": 1, "objects": objects });
    std::fs::write(folder.path().join("in.loft.json"), document.to_string()).unwrap();
    std::fs::write(folder.path().join("recipe.json"), recipe.to_string()).unwrap();

    let report = LOFTSMAN.json(folder.path(), &["run", "recipe.json"]);
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), cases.len());
    let out: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("out.loft.json")).unwrap()).unwrap();
    for (i, case) in cases.iter().enumerate() {
        let object = &out["objects"][i];
        assert_eq!(object["name"], name(i));
        let (was, now) = (&case["curve"]["points"], &object["curve"]["points"]);
        let mut expected: Vec<Vec<f64>> = serde_json::from_value(was.clone()).unwrap();
        for moved in case["points"].as_array().unwrap() {
            let index = moved[0].as_u64().unwrap() as usize;
            expected[index] = (1..4).map(|k| moved[k].as_f64().unwrap()).collect();
        }
        let now: Vec<Vec<f64>> = serde_json::from_value(now.clone()).unwrap();
        assert_eq!(now.len(), expected.len());
        let size = expected.iter().flatten().fold(1.0_f64, |m, x| m.max(x.abs()));
        for (got, want) in now.iter().flatten().zip(expected.iter().flatten()) {
            assert!((got - want).abs() <= 1e-9 * size, "{}: {now:?} is not {expected:?}", name(i));
        }
        let adjustment = steps[i]["adjustment"].as_f64().unwrap();
        let wanted = case["adjustment"].as_f64().unwrap();
        assert!((adjustment - wanted).abs() <= 1e-9 * wanted, "{}: {}", name(i), steps[i]);
        assert!(steps[i]["residual"].as_f64().unwrap() <= 1e-12 * size, "{}", steps[i]);
    }
}
