//! Sheets that leave their common edge at less than a right angle to one another: bent round to go on from each other (a J), by as much as 180° but for
//! their angle.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::Edge;
use loftsman_kernel::plugin::{Context, NoClock, Operation, Parameters, Plugin, Quiet, Registry};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_matching::{Limits, MatchOperation, MatchingPlugin, matching};
use serde_json::json;

/// A flat sheet from the line `x = 0` on, `long`, in the direction at `degrees` to the x axis, towards z.
fn sheet(rows: usize, long: f64, degrees: f64) -> Surface {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (u, v) = (Space::clamped_uniform(3, rows).unwrap(), Space::clamped_uniform(3, 4).unwrap());
    let at = |k: usize| {
        let far = long * (k / 4) as f64 / (rows - 1) as f64;
        Point::new(far * cos, 2.0 * (k % 4) as f64 / 3.0, far * sin)
    };
    Surface::new(u, v, (0..4 * rows).map(at).collect()).unwrap()
}

/// The sheet `a`, towards negative x, at its edge `u0` matched to one that leaves that edge at `degrees` from the direction of the x axis.
fn bent(degrees: f64, continuity: usize, metric: Option<&str>) -> Result<(Surface, Vec<String>), String> {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let mut fields = json!({ "object": "a", "edge": "u0", "with": { "object": "b", "edge": "u0" },
        "continuity": continuity });
    if let Some(metric) = metric {
        fields["metric"] = json!(metric);
    }
    let mut scene = Scene::new();
    scene.add(Object::new("a", sheet(7, 2.0, 180.0).into())).unwrap();
    scene.add(Object::new("b", sheet(4, 1.0, degrees).into())).unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    let report = MatchOperation.apply(&mut scene, &parameters, &context).map_err(|e| e.to_string())?;
    Ok((scene.surface("a").unwrap().clone(), report.notes))
}

/// Directions in the plane `y = const`, in degrees, from the far end of the bent sheet to the edge, without jumps of whole turns.
fn directions(bent: &Surface) -> Vec<f64> {
    let ((a, b), (c, d)) = (bent.u().domain(), bent.v().domain());
    let mut all: Vec<f64> = Vec::new();
    for k in (0..=20_000).rev() {
        let t = bent.derivative(a + (b - a) * f64::from(k) / 20_000.0, 0.5 * (c + d), 1, 0).unwrap();
        let now = (-t.z).atan2(-t.x).to_degrees();
        let last = all.last().copied().unwrap_or(now);
        all.push(now - 360.0 * ((now - last) / 360.0).round());
    }
    all
}

#[test]
fn a_sheet_is_bent_round_by_whatever_angle_the_other_stands_over_it() {
    let mut made = 0;
    for degrees in [60.0, 80.0, 95.0, 110.0, 130.0, 160.0, 175.0, -95.0, -130.0, -160.0] {
        for continuity in [1, 2] {
            for metric in [None, Some("bend"), Some("least")] {
                let case = format!("{degrees}° G{continuity} {metric:?}");
                let (a, notes) = bent(degrees, continuity, metric).unwrap_or_else(|e| panic!("{case}: {e}"));
                let found = directions(&a);
                // It leaves the edge as the other goes on, and ends as it did.
                assert!((found[0]).abs() < 1e-9, "{case}: {}", found[0]);
                let end = found[found.len() - 1];
                assert!((end - degrees).abs() < 0.1, "{case}: {end} {notes:?}");
                // A curve that is smooth all along, without a cusp; moved least, or bent round by nearly all, it may have a
                // hairpin, which is said.
                let jump = found.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, f64::max);
                let folds = notes.iter().any(|note| note.contains("folds back over itself"));
                let free = degrees.abs() > 90.0 && metric == Some("least") || degrees.abs() > 170.0;
                assert!(jump < 5.0 || folds && free, "{case}: {jump} {notes:?}");
                assert!(!folds || free, "{case}: {notes:?}");
                let led = notes.iter().any(|note| note.contains("left free it would fold back on the other"));
                assert_eq!(led, degrees.abs() > 90.0, "{case}: {notes:?}");
                made += 1;
            }
        }
    }
    assert_eq!(made, 60);
}

/// What lies on the other, within what counts as one tangent plane, has no side to be bent round on.
#[test]
fn a_sheet_that_lies_on_the_other_is_refused() {
    for degrees in [180.0, 179.95, -179.95] {
        for continuity in [1, 2] {
            let told = bent(degrees, continuity, None).unwrap_err();
            assert!(told.contains("the surface lies on the other, folded back"), "{degrees}: {told}");
            assert!(told.contains("ask for continuity 0"), "{degrees}: {told}");
        }
    }
    bent(179.0, 1, None).unwrap();
}

/// The constraint moves as little as it can, and says what would bend the sheet round.
#[test]
fn the_constraint_says_what_bends_a_sheet_round() {
    for (degrees, words) in
        [(110.0, "the operation `match`, which bends it round"), (180.0, "lies folded back on the other")]
    {
        let asked = matching(Edge::UStart, 1, Edge::UStart, 1, Limits::default());
        let (a, b) = (sheet(7, 2.0, 180.0), sheet(4, 1.0, degrees));
        let told = Edit::new(&a).with(Box::new(b)).ask(asked.hold()).solve().unwrap_err().to_string();
        assert!(told.contains(words), "{degrees}: {told}");
    }
}

/// How far it goes, bent little and moved little, is told as the distance from the sheet that it was: what slides along itself goes nowhere.
#[test]
fn how_far_it_goes_is_told_from_the_sheet_that_was() {
    let (least, notes) = bent(80.0, 1, None).unwrap();
    let (bend, _) = bent(80.0, 1, Some("bend")).unwrap();
    let note = notes.iter().find(|note| note.contains("bent as little as can be it would go ")).unwrap();
    let told: f64 =
        note.split("it would go ").nth(1).unwrap().split(" times as far").next().unwrap().parse().unwrap();
    let [far, near] = [&bend, &least].map(|s| {
        let ((a, b), (c, d)) = (s.u().domain(), s.v().domain());
        let far = |k: usize| {
            let share = |k: usize| k as f64 / 200.0;
            let p = s.point(a + (b - a) * share(k / 201), c + (d - c) * share(k % 201)).unwrap();
            let out = |x: f64, low: f64, high: f64| (low - x).max(x - high).max(0.0);
            out(p.x, -2.0, 0.0).hypot(out(p.y, 0.0, 2.0)).hypot(p.z)
        };
        (0..201 * 201).map(far).fold(0.0, f64::max)
    });
    assert!((told - far / near).abs() < 0.02 * told, "{told}, found {far} and {near}: {note}");
}
