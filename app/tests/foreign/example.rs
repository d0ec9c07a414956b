//! The README's main command: Blender shows what the blade section's recipe says it wrote.

use loftsman_tests::curves::curve_from_json;
use loftsman_tests::oracle::{Oracle, number, object};
use serde_json::Value;

use crate::blender_curves::check_drawn;

use crate::LOFTSMAN;

#[test]
fn blender_shows_the_blade_section() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = loftsman_tests::repository().join("examples/blade-section/recipe.toml");
    let out = |extension: &str| folder.path().join(format!("section.{extension}"));
    let names = ["loft.json", "obj", "glb"].map(|extension| out(extension).to_string_lossy().into_owned());
    let recipe = recipe.to_string_lossy();
    LOFTSMAN.done(folder.path(), &["run", &recipe, "-o", &names[0], "-o", &names[1], "-o", &names[2]]);
    let document: Value = serde_json::from_slice(&std::fs::read(out("loft.json")).unwrap()).unwrap();
    let curves: Vec<_> =
        document["objects"].as_array().unwrap().iter().filter(|o| o["curve"].is_object()).collect();
    assert!(!curves.is_empty(), "the example is about a curve");

    if let Some(reports) = Oracle::GltfValidator.ask(&[out("glb")], &[]) {
        assert_eq!(
            (&reports[0]["errors"], &reports[0]["warnings"]),
            (&0.into(), &0.into()),
            "{:#}",
            reports[0]
        );
    }
    let Some(reports) = Oracle::Blender.ask(&[out("obj"), out("glb")], &["--eval"]) else { return };
    for described in curves {
        let name = described["name"].as_str().unwrap();
        let ours = curve_from_json(&described["curve"]);
        check_drawn(name, &ours, &reports[0], 1e-5);
        // In the GLB it is a line strip of the same length, within the tessellation's tolerance.
        let (drawn, strip) = (object(&reports[0], name), object(&reports[1], name));
        let (length, strip) = (number(drawn, "evaluated/edge_length"), number(strip, "wire_length"));
        assert!((strip / length - 1.0).abs() < 1e-3, "{name}: {strip} in the GLB, {length} as a NURBS curve");
    }
}
