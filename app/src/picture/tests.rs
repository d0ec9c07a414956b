use super::*;
use serde_json::json;

fn look(table: Value) -> std::result::Result<Look, String> {
    let fields = Parameters::new(table, "picture").map_err(|e| e.to_string())?;
    Look::from_parameters(&fields).map_err(|e| e.to_string())
}

#[test]
fn the_fields_of_a_panel_are_declared() {
    let takes = FIELDS.iter().find(|field| field.name == "panel").unwrap().takes;
    let inner = takes.strip_prefix("[{ ").and_then(|takes| takes.strip_suffix(" }, …]")).unwrap();
    let mut told: Vec<&str> = inner.split(", ").collect();
    let mut taken: Vec<&str> = PANEL.iter().map(|field| field.name).collect();
    told.sort_unstable();
    taken.sort_unstable();
    assert_eq!(told, taken);
}

#[test]
fn tables_say_how_a_picture_looks() {
    assert_eq!(look(json!({})), Ok(Look::default()));
    let found = look(json!({
        "title": "t", "combs": 0.5, "knots": 3, "before": false, "view": [1, 2, 3],
        "panel": [{ "view": "top", "caption": "above" }, { "profile": "parameter", "objects": ["a"] }],
    }))
    .unwrap();
    assert_eq!((found.combs, found.beads, found.before), (Combs::Scale(0.5), Beads::Uniform(3), false));
    let panels = [Panel::view(View::Top).caption("above"), Panel::profile(Against::Parameter).objects(["a"])];
    assert_eq!(found.panels, panels);
    assert_eq!(found.view, View::From(loftsman_kernel::Vector::new(1.0, 2.0, 3.0)));
}

#[test]
fn what_is_not_drawn_of_a_shape_is_said() {
    use loftsman_kernel::mesh::Cloud;
    use loftsman_kernel::scene::Object;
    use loftsman_kernel::spline::{Curve, Space, Surface};
    let points = |n: usize| (0..n).map(|k| loftsman_kernel::Point::new(k as f64, 0.0, 0.0)).collect();
    let space = Space::clamped_uniform(1, 2).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("c", Curve::bezier(points(2)).unwrap().into())).unwrap();
    scene.add(Object::new("s", Surface::new(space.clone(), space, points(4)).unwrap().into())).unwrap();
    scene.add(Object::new("p", Cloud { points: points(3) }.into())).unwrap();
    let said = |table: Value| look(table).unwrap().unmet(&scene).join("\n");
    assert_eq!(said(json!({})), "");
    let combs = said(json!({ "combs": true }));
    assert!(combs.contains("combs") && combs.contains("\"p\" (cloud)"), "{combs}");
    assert!(!combs.contains("\"c\"") && !combs.contains("\"s\""), "{combs}");
    assert_eq!(said(json!({ "combs": 0.5, "objects": ["c"] })), "");
    assert_eq!(
        said(
            json!({ "combs": true, "panel": [{ "view": "top", "objects": ["c"] }, { "profile": "parameter" }] })
        ),
        ""
    );
    assert_eq!(said(json!({ "knots": 2, "segments": true, "objects": ["s"] })).lines().count(), 2);
}

/// A name that ends in `*` is of all that begin so, unless one is called that.
#[test]
fn names_that_begin_alike_are_named_together() {
    use loftsman_kernel::Point;
    use loftsman_kernel::mesh::Cloud;
    let mut scene = Scene::new();
    for name in ["rib", "rib.001", "rib.002", "keel", "odd*", "odd one"] {
        scene.add(Object::new(name, Cloud { points: vec![Point::origin()] }.into())).unwrap();
    }
    let look = |names: Value| {
        look(json!({ "objects": names, "panel": [{ "view": "top" }, { "objects": ["k*"] }] })).unwrap()
    };
    let shown = |names: Value| look(names).spelt(&scene).objects.unwrap();
    assert_eq!(shown(json!(["keel", "rib*"])), ["keel", "rib", "rib.001", "rib.002"]);
    assert_eq!(shown(json!(["odd*"])), ["odd*"]);
    assert_eq!(shown(json!(["*"])).len(), 6);
    assert_eq!(look(json!(["rib*"])).spelt(&scene).panels[1].chosen().unwrap(), ["keel"]);
    assert_eq!(look(json!(["rib*", "keel", "odd*"])).absent(&scene), None);
    let (place, problem) = look(json!(["rib*", "deck*"])).absent(&scene).unwrap();
    assert!(place == "picture.objects[1]" && problem.contains("deck*"), "{place}: {problem}");
}

#[test]
fn what_is_wrong_has_its_place() {
    for (table, place, words) in [
        (json!({ "titel": "t" }), "picture", "did you mean \"title\""),
        (json!({ "view": "tip" }), "picture.view", "did you mean \"top\""),
        (
            json!({ "panel": [{ "view": "top" }, { "profil": 1 }] }),
            "picture.panel[1]",
            "did you mean \"profile\"",
        ),
        (json!({ "panel": [{ "view": "top", "profile": "parameter" }] }), "panel[0].view", "leave one"),
        (json!({ "objects": ["a", 2] }), "picture.objects[1]", "name of an object"),
        (json!({ "combs": "big" }), "picture.combs", "true or false"),
    ] {
        let problem = look(table).unwrap_err();
        assert!(problem.contains(place) && problem.contains(words), "{problem}");
    }
}
