//! The operation `fair`, as recipes run it, and what it refuses.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests may fail the test")]

use loftsman_fairing::{Datum, Fair, Fairing, bend, data, stretch, variation};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Constraint, Wanted};
use loftsman_kernel::functional::{self, magnitude, position};
use loftsman_kernel::plugin::{Context, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space};
use serde_json::{Value, json};

fn curve(degree: usize, n: usize) -> Curve {
    let at = |i: usize| Point::new(i as f64, (2.1 * i as f64).sin(), 0.0);
    Curve::new(Space::clamped_uniform(degree, n).unwrap(), (0..n).map(at).collect()).unwrap()
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("wire", curve(3, 12).into())).unwrap();
    scene.add(Object::new("rail", curve(3, 8).into())).unwrap();
    scene
}

fn run(scene: &mut Scene, step: Value) -> Result<StepReport, String> {
    let mut registry = Registry::new();
    registry.add(&Fairing);
    registry.solver(Automatic);
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let parameters = Parameters::new(step, "step[0]").unwrap();
    let operation = registry.find_operation("fair", "step[0].op").map_err(|e| e.to_string())?;
    parameters.check(operation.declaration().fields).map_err(|e| e.to_string())?;
    operation.apply(scene, &parameters, &Context::quiet(&registry)).map_err(|e| e.to_string())
}

#[test]
fn a_sum_of_energies_under_constraints() {
    let mut scene = scene();
    let report = run(
        &mut scene,
        json!({
            "object": "wire",
            "energy": [
                { "kind": "bend" },
                { "kind": "stretch", "weight": 0.1 },
                { "kind": "data", "points": [{ "at": 4.0, "to": [4.0, 3.0, 0.0], "weight": 5.0 }] },
            ],
            "constraints": [
                { "kind": "position", "at": 0.0, "keep": true },
                { "kind": "position", "at": 9.0, "axis": "y", "to": 1.0 },
                { "kind": "join", "at": 9.0, "with": { "object": "rail", "at": 0.0 }, "continuity": 0 },
            ],
        }),
    );
    // The join says that y is 0 there, the position that it is 1.
    let conflict = report.unwrap_err();
    assert!(conflict.contains("y of position at 9") && conflict.contains("cannot all hold"), "{conflict}");

    let report = run(
        &mut scene,
        json!({
            "object": "wire", "energy": "bend", "lock": [0],
            "constraints": [
                { "kind": "position", "at": 4.5, "by": [0.0, 2.0, 0.0] },
                { "kind": "join", "at": 9.0, "with": { "object": "rail", "at": 0.0 }, "continuity": 1 },
            ],
        }),
    );
    let report = report.unwrap();
    let (wire, rail, old) = (scene.curve("wire").unwrap(), scene.curve("rail").unwrap(), curve(3, 12));
    assert_eq!(rail, &curve(3, 8));
    assert_eq!(wire.points()[0], old.points()[0]);
    assert!((wire.point(9.0).unwrap() - rail.point(0.0).unwrap()).norm() < 1e-13);
    assert!((wire.derivative(9.0, 1).unwrap() - rail.derivative(0.0, 1).unwrap()).norm() < 1e-12);
    assert!((wire.point(4.5).unwrap().y - old.point(4.5).unwrap().y - 2.0).abs() < 1e-13);
    let [before, after] = report.energy.unwrap();
    assert!(after < 0.5 * before && report.residual.unwrap() < 1e-12, "{report:?}");
    assert_eq!((report.rank, report.equations, report.marks.len()), (Some(9), Some(9), 1));
    let told = serde_json::to_value(&report).unwrap();
    assert_eq!(told["energy"][1].as_f64(), Some(after));
}

#[test]
fn what_is_wrong_is_said() {
    for (step, part) in [
        (json!({ "object": "wires" }), "wires"),
        (json!({ "object": "wire", "energy": "bending" }), "did you mean \"bend\""),
        (json!({ "object": "wire", "energy": [] }), "at least one"),
        (json!({ "object": "wire", "energy": [{ "kind": "bend", "weight": -1 }] }), "energy[0].weight"),
        (json!({ "object": "wire", "energy": [{ "kind": "bend", "points": [] }] }), "points"),
        (
            json!({ "object": "wire", "energy": [{ "kind": "data", "points": [{ "at": 99, "to": [0, 0, 0] }] }] }),
            "outside",
        ),
        (json!({ "object": "wire", "lock": [99] }), "no control vertex 99"),
        (json!({ "object": "wire", "solver": "magic" }), "magic"),
        (
            json!({ "object": "wire", "constraints": [{ "kind": "magnitude", "at": 2.0, "scale": 2.0 }] }),
            "not linear",
        ),
        (json!({}), "say which object"),
    ] {
        let mut scene = scene();
        let error = run(&mut scene, step.clone()).expect_err(&step.to_string());
        assert!(error.contains(part), "{step}: {error}");
    }
    let wire = curve(3, 12);
    assert!(Fair::new(&wire).solve().unwrap_err().to_string().contains("give an energy"));
    let line = Fair::new(&curve(1, 5)).energy(bend()).solve().unwrap_err().to_string();
    assert!(line.contains("degree 1") && line.contains("elevate"), "{line}");
    assert!(Fair::new(&curve(2, 5)).energy(variation()).solve().is_err());
    assert!(Fair::new(&wire).energy(f64::NAN * bend()).solve().is_err());
    let datum = |weight| Datum { at: 2.0.into(), to: Point::origin(), weight };
    assert!(Fair::new(&wire).energy(data([datum(-1.0)])).solve().is_err());
    assert!(Fair::new(&wire).energy(bend() + data([datum(1.0)])).solve().is_ok());
    assert!(Fair::new(&wire).energy(0.0 * bend()).solve().is_err());
    let long = magnitude(2.0).to(3.0);
    assert!(
        Fair::new(&wire).energy(stretch()).ask(long).solve().unwrap_err().to_string().contains("not linear")
    );
    let nowhere = Constraint::new(std::sync::Arc::new(position(2.0)), Wanted::To(vec![f64::NAN; 3].into()));
    assert!(Fair::new(&wire).energy(bend()).ask(nowhere).solve().is_err());
}

#[test]
fn corners_that_cost_nothing_are_noted() {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0];
    let points = (0..9).map(|i| Point::new(f64::from(i), f64::from(i % 3), 0.0)).collect();
    let kinked = Curve::new(Space::open(3, knots).unwrap(), points).unwrap();
    let fair = |level: u8| {
        let fair = Fair::new(&kinked).energy(bend()).smooth(level);
        fair.ask(position(0.0).keep()).ask(position(4.0).keep()).solve().unwrap().report().clone()
    };
    let report = fair(0);
    assert!(
        report.notes.iter().any(|n| n.starts_with("at 2 ") && n.contains("corner")),
        "{:?}",
        report.notes
    );
    // Where the curve is kept smooth there will be none.
    let report = fair(1);
    assert!(report.smooth.knots == 1 && report.notes.is_empty(), "{report}");
}

#[test]
fn smoothness_is_a_field_and_reported_apart() {
    let wave = |points: [[f64; 2]; 7]| {
        let points = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0];
        Curve::new(Space::open(3, knots).unwrap(), points).unwrap()
    };
    let wave = wave([[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [5.0, 1.0], [6.0, 0.0], [7.0, 0.0]]);
    let told = |level: Option<u8>| {
        let mut scene = Scene::new();
        scene.add(Object::new("wave", wave.clone().into())).unwrap();
        let mut step = json!({
            "object": "wave", "energy": "stretch",
            "constraints": [
                { "kind": "position", "at": 0.0, "keep": true }, { "kind": "position", "at": 1.0, "keep": true },
                { "kind": "position", "at": 3.0, "keep": true },
            ],
        });
        if let Some(level) = level {
            step["smooth"] = json!(level);
        }
        run(&mut scene, step).map(|report| serde_json::to_value(&report).unwrap())
    };
    let (default, kept, torn) = (told(None).unwrap(), told(Some(1)).unwrap(), told(Some(0)).unwrap());
    assert_eq!(default["smooth"], json!({ "knots": 1, "equations": 3 }));
    assert_eq!((&default["smooth"], &default["constraints"]), (&kept["smooth"], &kept["constraints"]));
    assert_eq!(default["constraints"].as_array().map(Vec::len), Some(3));
    assert_eq!(torn["smooth"]["knots"], json!(0));
    // The two straight lines.
    let corner = torn["smooth"]["corners"][0]["degrees"].as_f64().unwrap();
    let expected = (1.0_f64 / 3.0).atan() + (1.0_f64 / 4.0).atan();
    assert!((corner.to_radians() - expected).abs() < 1e-9, "{torn}");
    let note = format!("a corner of {corner:.1}° at 1 (was 0°)");
    assert!(torn["notes"].as_array().unwrap().iter().any(|n| n == &json!(note)), "{torn}");
    assert!(told(Some(2)).is_ok());
    assert!(told(Some(3)).unwrap_err().contains("smooth"));
}

/// A functional that writes none of its rows, and one that writes none of its values.
#[derive(Debug)]
struct Liar(bool);

impl functional::Functional for Liar {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> functional::Linearity {
        functional::Linearity::Linear
    }

    fn rows(
        &self,
        _: &functional::Shapes<'_>,
        rows: &mut functional::Rows<'_>,
    ) -> loftsman_kernel::error::Result<()> {
        if self.0 {
            rows.equation().term(0, 1, loftsman_kernel::Vector::y());
        }
        Ok(())
    }

    fn value(&self, _: &functional::Shapes<'_>, out: &mut [f64]) -> loftsman_kernel::error::Result<()> {
        if !self.0 {
            out.fill(0.0);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        "liar".into()
    }
}

#[test]
fn what_bounds_hand_over_is_checked() {
    for rows in [true, false] {
        let bound = Constraint::new(std::sync::Arc::new(Liar(rows)), Wanted::AtLeast(vec![1.0].into()));
        let text = Fair::new(&curve(3, 6)).energy(bend()).ask(bound).solve().unwrap_err().to_string();
        let part = if rows { "writes 0 values" } else { "appends 0" };
        assert!(text.contains("\"liar\"") && text.contains(part), "{text}");
    }
}

#[test]
fn everything_locked_is_left_alone() {
    let wire = curve(3, 6);
    let fair = Fair::new(&wire).energy(bend()).lock(0..6).solve().unwrap();
    assert_eq!(fair.shape(), &wire);
    assert!(
        Fair::new(&wire).energy(bend()).lock(0..6).ask(position(1.0).by([1.0, 0.0, 0.0])).solve().is_err()
    );
}

#[test]
fn the_wildest_numbers_give_a_shape_or_an_error() {
    for scale in [1e-300, 1e-160, 1e-100, 1e100, 1e150, 1e160, 1e300] {
        for domain in [1e-100, 1e-30, 1.0, 1e30, 1e100] {
            let points = curve(3, 8).points().iter().map(|p| p * scale).collect();
            let knots = curve(3, 8).space().knots().iter().map(|k| k * domain).collect();
            let Ok(wild) = Space::open(3, knots).and_then(|s| Curve::new(s, points)) else { continue };
            for energy in [stretch(), bend(), variation()] {
                let asked = Fair::new(&wild).energy(energy).ask(position(0.0).keep());
                if let Ok(fair) = asked.solve() {
                    assert!(fair.shape().points().iter().all(|p| p.coords.iter().all(|c| c.is_finite())));
                }
            }
        }
    }
}
