//! What steps leave of what earlier ones made: animations, marks, and pictures of both.

use serde_json::Value;

use loftsman_tests::bench::Bench;

use crate::LOFTSMAN;

const DRAG: &str = r#"
input = "wave.loft.json"
output = ["moving.loft.json"]
[[step]]
op = "drag"
object = "wave"
handle = { kind = "position", at = 2.5 }
path = [[0, 0.1, 0], [0, 0.3, 0]]
relative = true
frames = true
"#;

/// A folder with the wave and, in `moving.loft.json`, the wave with three frames.
fn moving() -> Bench {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("drag.toml", DRAG);
    bench.done(&["run", "drag.toml"]);
    bench
}

/// Runs steps on the moving wave; the report, and the object `wave` as it was written.
fn after(bench: &Bench, steps: &str) -> (Value, Value) {
    let head = "input = 'moving.loft.json'\noutput = ['after.loft.json', 'after.glb']\n";
    bench.write("r.toml", format!("{head}{steps}"));
    let report = bench.json(&["run", "r.toml"]);
    let document: Value = serde_json::from_slice(&bench.read("after.loft.json")).unwrap();
    (report, document["objects"][0].clone())
}

#[test]
fn an_animation_of_another_shape_is_taken_off_and_told_of() {
    let bench = moving();
    for step in [
        "op = 'edit'\nconstraints = [{ kind = 'position', at = 2.5, by = [0, 1, 0] }]",
        "op = 'fair'\nconstraints = [{ kind = 'position', at = 0, keep = true }]",
        "op = 'tessellate'",
        "op = 'simplify'\ntolerance = 2",
    ] {
        let (report, object) = after(&bench, &format!("[[step]]\n{step}\n"));
        let notes = report["steps"][0]["notes"].to_string();
        assert!(notes.contains("the animation of \\\"wave\\\" (3 frames) was taken off"), "{step}: {notes}");
        assert!(object.get("animation").is_none(), "{step}: {object}");
        let glb = String::from_utf8_lossy(&bench.read("after.glb")).contains("\"animations\"");
        assert!(!glb, "{step}: the GLB still moves");
        let text = bench.done(&["run", "r.toml"]);
        assert!(text.contains("was taken off"), "{text}");
    }
}

#[test]
fn an_animation_goes_along_with_its_shape_in_silence() {
    let bench = moving();
    for step in [
        "op = 'refine'\nknots = [1.5]",
        "op = 'elevate'",
        "op = 'reverse'",
        "op = 'split'\nat = 2.5",
        "op = 'transform'\ntranslate = [1, 0, 0]",
        "op = 'edit'\nconstraints = [{ kind = 'position', at = 2.5, by = [0, 0, 0] }]",
    ] {
        let (report, object) = after(&bench, &format!("[[step]]\n{step}\n"));
        assert!(!report["steps"][0].to_string().contains("taken off"), "{step}: {report}");
        let frames = object["animation"]["frames"].as_array().unwrap_or_else(|| panic!("{step}: {object}"));
        assert_eq!(frames.len(), 3, "{step}");
        // The last frame of a drag is what stays.
        assert_eq!(frames[2], object["curve"]["points"], "{step}");
        assert!(String::from_utf8_lossy(&bench.read("after.glb")).contains("\"animations\""), "{step}");
    }
    // A drag that keeps its own frames takes the place of the old ones.
    let again = DRAG.split("[[step]]").nth(1).unwrap();
    let (report, object) = after(&bench, &format!("[[step]]{again}"));
    assert!(!report.to_string().contains("taken off"), "{report}");
    assert_eq!(object["animation"]["frames"][2], object["curve"]["points"]);
}

/// An operation that moves points in place and forgets frames; one that leaves frames of another number of points.
struct Careless(&'static str);

impl loftsman::kernel::plugin::Operation for Careless {
    fn declaration(&self) -> loftsman::kernel::plugin::Declaration {
        loftsman::kernel::plugin::Declaration { name: self.0, help: "careless", fields: &[] }
    }

    fn apply(
        &self,
        scene: &mut loftsman::kernel::scene::Scene,
        _: &loftsman::kernel::plugin::Parameters,
        _: &loftsman::kernel::plugin::Context<'_>,
    ) -> Result<loftsman::kernel::plugin::StepReport, loftsman::kernel::plugin::OperationError> {
        let object = scene.object_mut("wave")?;
        if self.0 == "nudge" {
            let points = object.geometry().points().iter().map(|p| p * 2.0).collect();
            let moved = object.geometry().with_points(points)?;
            object.set_geometry(moved);
        } else if let Some(animation) = &mut object.animation {
            animation.frames[1].pop();
        }
        Ok(loftsman::kernel::plugin::StepReport::default())
    }
}

#[test]
fn an_operation_of_ones_own_cannot_leave_stale_frames() {
    let bench = moving();
    for name in ["nudge", "shorten"] {
        let mut registry = loftsman::registry().clone();
        registry.operation(Careless(name));
        let text = format!("input = 'moving.loft.json'\n[[step]]\nop = '{name}'\n");
        bench.write("own.toml", text);
        let recipe = loftsman::recipe::Recipe::read(bench.path("own.toml")).unwrap();
        let applied = loftsman::recipe::Runner::new(&registry).apply(&recipe).unwrap();
        assert_eq!(applied.scene.object("wave").unwrap().animation, None, "{name}");
        assert!(applied.steps[0].notes.iter().any(|n| n.contains("(3 frames) was taken off")), "{name}");
    }
}

/// Marks and the scene after the steps of a recipe.
fn applied(bench: &Bench, steps: &str) -> loftsman::recipe::Applied {
    bench.write("marks.toml", format!("input = 'wave.loft.json'\n{steps}"));
    let recipe = loftsman::recipe::Recipe::read(bench.path("marks.toml")).unwrap();
    loftsman::recipe::Runner::new(loftsman::registry()).apply(&recipe).unwrap()
}

#[test]
fn marks_go_where_their_places_go() {
    let bench = LOFTSMAN.bench().with_wave();
    let edit = "[[step]]\nop = 'edit'\nlock = [0]\nconstraints = [{ kind = 'position', at = 1.25, by = [0, 0.4, 0] }]\n";
    let on_curve = |applied: &loftsman::recipe::Applied, name: &str| {
        let curve = applied.scene.curve(name).unwrap();
        let near = applied.marks[0].position;
        let (a, b) = curve.domain();
        (0..=4000)
            .map(|i| (curve.point(a + (b - a) * f64::from(i) / 4000.0).unwrap() - near).norm())
            .fold(f64::INFINITY, f64::min)
    };
    let first = applied(&bench, edit);
    assert_eq!((first.marks.len(), first.lost_marks), (2, 0));
    for (step, name, moved) in [
        ("op = 'transform'\ntranslate = [5, 0, 0]", "wave", Some([5.0, 0.0, 0.0])),
        ("op = 'transform'\ntranslate = [0.25, 0, 0]", "wave", Some([0.25, 0.0, 0.0])),
        ("op = 'reverse'", "wave", Some([0.0; 3])),
        ("op = 'refine'\nknots = [1.25]", "wave", Some([0.0; 3])),
        ("op = 'rename'\nobject = 'wave'\nto = 'sea'", "sea", Some([0.0; 3])),
        (
            "op = 'edit'\nconstraints = [{ kind = 'position', at = 1.25, by = [0, 0, 1] }]",
            "wave",
            Some([0.0, 0.0, 1.0]),
        ),
        ("op = 'edit'\nconstraints = [{ kind = 'position', at = 2.0, by = [0, 0, 1] }]", "wave", None),
    ] {
        let later = applied(&bench, &format!("{edit}[[step]]\n{step}\n"));
        assert_eq!(later.lost_marks, 0, "{step}");
        let mark = &later.marks[0];
        assert_eq!(mark.object, name, "{step}");
        assert!(on_curve(&later, name) < 2e-3, "{step}: {mark:?}");
        if let Some(by) = moved {
            let by = loftsman::kernel::Vector::from(by);
            assert!((mark.position - first.marks[0].position - by).norm() < 1e-9, "{step}: {mark:?}");
        }
        let locked = later.marks.iter().find(|m| m.label.contains("locked")).unwrap();
        let points = later.scene.curve(name).unwrap().points();
        assert!(points.contains(&locked.position), "{step}: {locked:?}");
    }
    // The second half has the place now, or nobody.
    let late = edit.replace("1.25", "3.75");
    let split = applied(&bench, &format!("{late}[[step]]\nop = 'split'\nat = 2.5\n"));
    assert_eq!(split.marks[0].object, "wave.001");
    // The locked end is a point of the polyline too; the place between its points is not.
    let gone = applied(&bench, &format!("{edit}[[step]]\nop = 'tessellate'\n"));
    assert_eq!((gone.marks.len(), gone.lost_marks), (1, 1));
    bench.write(
        "lost.toml",
        format!("input = 'wave.loft.json'\noutput = ['l.svg']\n{edit}[[step]]\nop = 'tessellate'\n"),
    );
    let report = bench.json(&["run", "lost.toml"]);
    assert!(report["outputs"][0]["notes"].to_string().contains("1 mark left out"), "{report}");
}

#[test]
fn kept_points_of_fair_are_marked_as_those_of_edit() {
    let bench = LOFTSMAN.bench().with_wave();
    let asked = "constraints = [{ kind = 'position', at = 1, keep = true }, { kind = 'position', at = 3, by = [0, 0.1, 0] }]";
    let kinds = |op: &str| {
        let applied = applied(&bench, &format!("[[step]]\nop = '{op}'\n{asked}\n"));
        applied.marks.iter().map(|mark| mark.kind).collect::<Vec<_>>()
    };
    use loftsman::kernel::plugin::MarkKind::{Kept, Moved};
    assert_eq!(kinds("edit"), [Kept, Moved]);
    assert_eq!(kinds("fair"), [Kept, Moved]);
}

#[test]
fn active_bounds_are_told_in_text_by_every_operation() {
    let bench = LOFTSMAN.bench().with_wave();
    for op in ["edit", "fair"] {
        let bound = "{ kind = 'position', at = 1.5, axis = 'y', at_most = -0.5 }";
        let ends = "{ kind = 'position', at = 0, keep = true }, { kind = 'position', at = 5, keep = true }";
        bench.write(
            "b.toml",
            format!("input = 'wave.loft.json'\n[[step]]\nop = '{op}'\nconstraints = [{bound}, {ends}]\n"),
        );
        let step = &bench.json(&["run", "b.toml"])["steps"][0];
        let active = step["active"][0].as_str().unwrap_or_else(|| panic!("{op}: {step}")).to_owned();
        let text = bench.done(&["run", "b.toml"]);
        assert_eq!(text.matches(&format!("bounds touched: {active}")).count(), 1, "{op}: {text}");
    }
}

#[test]
fn a_best_effort_says_what_it_missed() {
    let bench = LOFTSMAN.bench().with_wave();
    let asked = "constraints = [{ kind = 'position', at = 0, by = [0, 1, 0] }, { kind = 'position', at = 2.5, keep = true }]";
    bench.write(
        "b.toml",
        format!("input = 'wave.loft.json'\n[[step]]\nop = 'edit'\nlock = [0]\nbest_effort = true\n{asked}\n"),
    );
    let text = bench.done(&["run", "b.toml"]);
    assert!(text.contains("missed: position at 0 by 1 mm") && !text.contains("follows from"), "{text}");
    let step = &bench.json(&["run", "b.toml"])["steps"][0];
    assert_eq!(step["constraints"][0]["dimension"], 1, "{step}");
}

#[test]
fn a_pictures_objects_are_those_of_its_panels() {
    let bench = LOFTSMAN.bench().with_wave();
    let steps = "[[step]]\nop = 'copy'\nobject = 'wave'\nto = 'twin'\n";
    let picture = |fields: &str| {
        let head = "input = 'wave.loft.json'\noutput = ['p.svg']\n";
        bench.write("p.toml", format!("{head}{steps}[picture]\n{fields}\n"));
        bench.done(&["run", "p.toml"]);
        let svg = String::from_utf8(bench.read("p.svg")).unwrap();
        (svg.matches(">wave<").count() > 0, svg.matches(">twin<").count() > 0)
    };
    assert_eq!(picture("objects = ['wave']"), (true, false));
    assert_eq!(picture("objects = ['wave']\npanel = [{ view = 'top' }]"), (true, false));
    assert_eq!(picture("objects = ['wave']\npanel = [{ profile = 'parameter' }]"), (true, false));
    // What a panel says itself goes first.
    assert_eq!(picture("objects = ['wave']\npanel = [{ view = 'top', objects = ['twin'] }]"), (false, true));
    let both = "objects = ['wave']\npanel = [{ view = 'top', objects = ['twin'] }, { view = 'front' }]";
    assert_eq!(picture(both), (true, true));
}
