//! The operation `simulate` in recipes: what it tells, what it leaves, what it refuses.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use std::cell::RefCell;

use loftsman_dynamics::Dynamics;
use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Context, Observer, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};

use serde_json::{Value, json};

use crate::common::run;

fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.unit = Unit::Metre;
    let points = (0..12).map(|i| Point::new(0.2 * f64::from(i), 0.0, 0.1 * f64::from(i % 2))).collect();
    let rope = Curve::new(Space::clamped_uniform(3, 12).unwrap(), points).unwrap();
    scene.add(Object::new("rope", Geometry::Curve(rope))).unwrap();
    scene
}

#[test]
fn frames_are_kept_and_the_last_is_the_shape() {
    let mut scene = scene();
    let report = run(
        &mut scene,
        json!({ "seconds": 0.5, "mass": 0.2, "damping": 1, "constraints": [
            { "kind": "fixed", "at": 0, "name": "nail" },
            { "kind": "sliding", "near": 4, "name": "ring", "from": 0.25 },
            { "kind": "fixed", "at": 9, "name": "late", "from": 0.6 },
        ] }),
    )
    .unwrap();
    let object = scene.object("rope").unwrap();
    let frames = &object.animation.as_ref().unwrap().frames;
    assert_eq!(frames.len(), 13, "the start and half a second of 24");
    assert_eq!(frames.last().unwrap(), &object.geometry().points().to_vec());
    let told = |what: &str| report.notes.iter().any(|note| note.contains(what));
    assert!(told("\"late\" never holds: it comes at 0.6 s"), "{:?}", report.notes);
    assert!(told(", in mass · m² / s²") && told("constraints drifted"), "{:?}", report.notes);
    let names: Vec<&str> = report.constraints.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["nail", "ring", "late"]);
    // The ring's location is told, that of what never came is not.
    let [nail, ring, late] = &report.constraints[..] else { unreachable!("three") };
    assert_eq!(nail.location, Some(vec![0.0]));
    assert!(ring.location.as_ref().unwrap()[0] != 4.0 && ring.multipliers.len() == 3);
    assert!(late.location.is_none() && late.multipliers.is_empty());
}

/// A functional that looks at the shapes at the start: ends that meet stay together.
#[test]
fn what_is_closed_stays_closed() {
    let mut scene = Scene::new();
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.5, 1.0], [0.5, 1.8], [-0.3, 0.9], [0.0, 0.0]];
    let points = corners.map(|[x, z]| Point::new(x, 0.0, z)).to_vec();
    let loose = Curve::new(Space::clamped_uniform(2, 6).unwrap(), points).unwrap();
    scene.add(Object::new("loop", Geometry::Curve(loose))).unwrap();
    let fields = json!({ "seconds": 0.5, "scheme": "implicit", "constraints": [
        { "kind": "fixed", "at": 0 }, { "kind": "closed" },
    ] });
    run(&mut scene, fields).unwrap();
    let points = scene.object("loop").unwrap().geometry().points().to_vec();
    assert!((points[5] - points[0]).norm() < 1e-8, "{points:?}");
    assert!((points[3] - Point::new(0.5, 0.0, 1.8)).norm() > 0.1, "it moves: {points:?}");
}

#[test]
fn nothing_changes_where_it_is_refused() {
    for (fields, word) in [
        (json!({ "seconds": 1, "mass": 0 }), "mass"),
        (json!({ "seconds": 1, "stiffness": -1 }), "stiffness"),
        (json!({ "seconds": 1, "step": 0 }), "step"),
        (json!({ "seconds": 1, "gravity": [0, 0, 1e300] }), "gravity is 1e300: give numbers below 1e100"),
        (
            json!({ "seconds": 1, "forces": [{ "at": 1, "force": [0, -1e200, 0] }] }),
            "a force is -1e200: give numbers below",
        ),
        (json!({ "seconds": 1, "settle_frames": true }), "`settle = true`"),
        (json!({ "settle": true, "settle_frames": true }), "`seconds`"),
        (
            json!({ "seconds": 1, "stiffness": 1e300 }),
            "stiffness: the stiffness is 1e300: give a number above 0: between 1e-50 and 1e50",
        ),
        (json!({ "seconds": 1, "mass": 1e-300 }), "mass: the mass is 1e-300: give a number above 0"),
        (json!({ "seconds": 1, "mass": 5e-324 }), "mass: the mass is 5e-324: give a number above 0"),
        (json!({ "seconds": 1, "mass": 1e40 }), "mass: the mass is 1e40: give"),
        (json!({ "seconds": 1, "stiffness": 1e-300 }), "stiffness: the stiffness is 1e-300: give"),
        (json!({ "seconds": 1, "bending": 1e-300 }), "bending: the bending stiffness is 1e-300: give 0, or"),
        (
            json!({ "seconds": 1, "damping": 1e50 }),
            "damping: the damping is 1e50: give a number of 0 or more",
        ),
        (
            json!({ "seconds": 1, "damping": 1e50, "scheme": "implicit" }),
            "damping: the damping is 1e50: give a number of 0 or more",
        ),
        (json!({ "seconds": 1, "step": 1e50 }), "step: the step is 1e50: give a number above 0"),
        (json!({ "seconds": 1, "step": 1e-30 }), "step: the step is 1e-30: give a number above 0"),
        (json!({ "seconds": 1, "draw": 1e-30 }), "draw: the time in which constraints are drawn in is 1e-30"),
        (
            json!({ "seconds": 1, "rest": 0 }),
            "rest: the rest length's factor is 0: give a number between 0.001 and 1000",
        ),
        (
            json!({ "seconds": 1, "rest": 1e9 }),
            "rest: the rest length's factor is 1000000000: give a number between 0.001 and 1000",
        ),
        (json!({ "seconds": 1, "epsilon": 0 }), "epsilon: epsilon is 0: give a number above 0"),
        (
            json!({ "seconds": 1, "pull": [{ "at": 3, "to": [0, 0, 1], "stiffness": 0 }] }),
            "pull[0].stiffness: the stiffness of a pull is 0: give a number above 0",
        ),
        (json!({ "seconds": 1, "corners": true }), "corners: corners come where rest is looked for"),
        (
            json!({ "seconds": 1, "constraints": [{ "kind": "join", "near": 3, "with": { "object": "rope", "at": 0 } }] }),
            "constraints[0].near: \"join\" holds at a location that stays: give `at`",
        ),
        (
            json!({ "seconds": 1, "constraints": [{ "kind": "vertex", "near": 3, "index": 1 }] }),
            "constraints[0].near: \"vertex\" is asked of the whole shape, and has no location that could slide",
        ),
        (
            json!({ "seconds": 1, "constraints": [{ "kind": "sliding-tangent", "near": 3, "direction": [0, 0, 0] }] }),
            "constraints[0].direction: the first derivative is to be the zero vector",
        ),
        (json!({ "seconds": 1, "mass": 0 }), "mass: the mass is 0: give a number above 0"),
        (
            json!({ "seconds": 1, "bending": 1e20, "scheme": "implicit" }),
            "\"rope\": its stiffness, bending or pulls",
        ),
        (json!({ "seconds": -1 }), "time"),
        (json!({}), "settle"),
        (json!({ "seconds": 1, "constraints": [{ "kind": "sliding", "near": 20 }] }), "20"),
        (
            json!({ "seconds": 1, "constraints": [
                { "kind": "fixed", "at": 3, "to": [0, 0, 0], "name": "one" },
                { "kind": "fixed", "at": 3, "to": [1, 0, 0], "name": "other" },
            ] }),
            "other",
        ),
    ] {
        let (mut scene, before) = (scene(), scene());
        let refused = run(&mut scene, fields.clone()).unwrap_err().to_string();
        assert!(refused.contains(word), "{fields}: {refused}");
        assert_eq!(scene.object("rope").unwrap(), before.object("rope").unwrap(), "{fields}");
    }
}

/// What lets go of all that holds a rope is told with its time; what only an axis holds is refused by its direction where it is to rest.
#[test]
fn what_nothing_holds_any_more_is_told() {
    let ring = json!([{ "kind": "sliding", "near": 1.0, "name": "ring" }]);
    let falling = |seconds: f64, scheme: &str, constraints: &Value| json!({ "seconds": seconds, "gravity": [-9.81, 0, 0], "scheme": scheme, "constraints": constraints });
    for scheme in ["epsilon", "exact", "implicit"] {
        let report = run(&mut scene(), falling(2.0, scheme, &ring)).unwrap();
        let told = "nothing holds \"rope\" any more since ";
        let [warning] = &report.warnings[..] else { unreachable!("{:?}", report.warnings) };
        assert!(
            warning.contains(told) && warning.contains("\"ring\" let go (it left the shape)"),
            "{warning}"
        );
        assert!(warning.contains("along [-1, 0, 0]"), "{warning}");
        // As long as it holds, nothing is told; nor where its time is over, as was asked.
        let report = run(&mut scene(), falling(0.04, scheme, &ring)).unwrap();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
        let over = json!([{ "kind": "fixed", "at": 0, "until": 0.1 }]);
        let report = run(&mut scene(), falling(0.5, scheme, &over)).unwrap();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    }
    for (seconds, constraints, word) in [
        (json!(null), json!([{ "kind": "fixed", "at": 0, "axis": "x" }]), "along [0, 0, -1]"),
        (json!(2), json!([{ "kind": "sliding", "near": 1.0, "name": "ring" }]), "any more"),
    ] {
        let gravity = if seconds.is_null() { [0.0, 0.0, -9.81] } else { [-9.81, 0.0, 0.0] };
        let mut fields = json!({ "settle": true, "gravity": gravity, "constraints": constraints });
        if !seconds.is_null() {
            fields["seconds"] = seconds;
        }
        let refused = run(&mut scene(), fields).unwrap_err().to_string();
        assert!(refused.contains("nothing holds \"rope\"") && refused.contains(word), "{refused}");
    }
}

/// Kinds whose own field is called as a word of `simulate` have it to themselves; conditions hold.
#[test]
fn a_direction_that_is_called_to_is_the_kinds() {
    let mut scene = scene();
    let fields = json!({ "seconds": 1, "scheme": "implicit", "gravity": [0, 0, -9.81], "constraints": [
        { "kind": "fixed", "at": 0 },
        { "kind": "orthogonal", "at": 3, "to": [1, 0, 1], "name": "across" },
        { "kind": "tangent", "at": 7, "direction": [1, 2, 0], "keep": true },
    ] });
    run(&mut scene, fields).unwrap();
    let Geometry::Curve(rope) = scene.object("rope").unwrap().geometry() else { unreachable!("a curve") };
    let [across, along] = [3.0, 7.0].map(|at| rope.derivative(at, 1).unwrap());
    assert!((across.x + across.z).abs() < 1e-7 * across.norm(), "{across}");
    assert!((2.0 * along.x - along.y).abs() + along.z.abs() < 1e-7 * along.norm(), "{along}");
    for (table, word) in [
        (json!({ "kind": "orthogonal", "at": 3 }), "\"direction\""),
        (json!({ "kind": "orthogonal", "at": 3, "to": "rope" }), "to"),
        (json!({ "kind": "tangent", "at": 3, "keep": false }), "only true makes sense"),
    ] {
        let refused =
            run(&mut self::scene(), json!({ "seconds": 1, "constraints": [table] })).unwrap_err().to_string();
        assert!(refused.contains(word), "{table}: {refused}");
    }
}

/// What is asked by mistake is torn beyond all sense: an error that says so, and the scene as it was.
#[test]
fn what_is_torn_is_refused() {
    let mut scene = scene();
    let before = scene.object("rope").unwrap().geometry().points().to_vec();
    let held = json!([{ "kind": "fixed", "at": 0 }]);
    let force = json!([{ "at": 9, "force": [0, 0, -1e12] }]);
    let fields = json!({ "settle": true, "stiffness": 100, "constraints": held, "forces": force });
    let message = run(&mut scene, fields).unwrap_err().to_string();
    assert!(
        message.contains("times its length at rest after 0 s") && message.contains("smaller forces"),
        "{message}"
    );
    assert!(message.contains("explicit steps are stable up to"), "{message}");
    assert_eq!(scene.object("rope").unwrap().geometry().points(), before);
}

/// What blows up says when, and which steps are stable; a step that is too short which one would do. Nothing is changed.
#[test]
fn what_cannot_go_on_says_when_and_which_step() {
    let mut scene = scene();
    let before = scene.object("rope").unwrap().geometry().points().to_vec();
    let held = json!([{ "kind": "fixed", "at": 0 }]);
    let kick = json!([{ "at": 9, "force": [0, 1e9, 0] }]);
    let fields =
        json!({ "seconds": 1, "scheme": "exact", "stiffness": 100, "constraints": held, "forces": kick });
    let message = run(&mut scene, fields).unwrap_err().to_string();
    assert!(message.contains("blows up after ") && message.contains(" s, in a step of "), "{message}");
    assert!(message.contains("would be stable"), "{message}");
    // No number is told to more than a few figures.
    let longest = message.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap();
    assert!(longest <= 8, "{message}");
    let fields = json!({ "seconds": 1, "step": 1e-12, "scheme": "exact", "constraints": held });
    let message = run(&mut scene, fields).unwrap_err().to_string();
    assert!(message.contains("give a `step` of ") && message.contains("or leave it out"), "{message}");
    assert_eq!(scene.object("rope").unwrap().geometry().points(), before);
}

/// What is pulled too strongly for its stiffness is told that, in every scheme, and no scheme is advised that is the one in use; where nothing slides nothing is said of that, and where stiffness follows
/// from weight more mass is no advice.
#[test]
fn advice_is_of_what_is_asked() {
    let held = json!([{ "kind": "fixed", "at": 0 }]);
    let led = json!([{ "kind": "fixed", "at": 0, "to": [[0, 0, 0], [1e6, 0, 0]] }, { "kind": "sliding", "near": 3 }]);
    for scheme in ["epsilon", "exact", "implicit"] {
        for fields in [
            json!({ "seconds": 0.5, "forces": [{ "at": 2, "force": [0, 0, 1e8] }], "constraints": held }),
            json!({ "seconds": 0.5, "pull": [{ "at": 3, "to": [0, 0, 1e6], "stiffness": 1e6 }], "constraints": held }),
            json!({ "seconds": 0.5, "constraints": led }),
        ] {
            let mut given = fields.clone();
            given["scheme"] = json!(scheme);
            let message = run(&mut scene(), given).unwrap_err().to_string();
            assert!(!message.contains(&format!("scheme \"{scheme}\"")), "{scheme}: {message}");
            if fields["constraints"] == held {
                assert!(message.contains("too strong for its stiffness"), "{scheme}: {message}");
                assert!(!message.contains("slide"), "{scheme}: {message}");
            }
        }
    }
    for (stiffness, word) in [(None, "less gravity, or a `stiffness`"), (Some(1e32), "more mass")] {
        let mut fields =
            json!({ "seconds": 0.5, "scheme": "implicit", "gravity": [0, 0, 1e30], "constraints": held });
        if let Some(stiffness) = stiffness {
            fields["stiffness"] = json!(stiffness);
        }
        let message = run(&mut scene(), fields).unwrap_err().to_string();
        assert!(message.contains("drowns the mass") && message.contains(word), "{message}");
    }
}

/// Four control vertices in one place among simple knots: what helps is named, of curves and of surfaces.
#[test]
fn what_stands_still_is_told_what_helps() {
    let space = Space::clamped_uniform(3, 9).unwrap();
    let place = |i: usize| [0.0, 0.2, 0.5, 0.5, 0.5, 0.5, 1.0, 1.3, 1.5][i];
    let points = (0..9).map(|i| Point::new(place(i), 0.1 * (place(i) * 5.0).sin(), 0.0)).collect();
    let curve = Curve::new(space.clone(), points).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("rope", Geometry::Curve(curve))).unwrap();
    let message = run(&mut scene, json!({ "seconds": 0.1 })).unwrap_err().to_string();
    assert!(message.contains("stands still") && message.contains("(operation sample)"), "{message}");
    let points = (0..81).map(|k| Point::new(place(k / 9), (k % 9) as f64, 0.0)).collect();
    let sheet = Surface::new(space.clone(), space, points).unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("sheet", Geometry::Surface(sheet))).unwrap();
    let message = run(&mut scene, json!({ "seconds": 0.1 })).unwrap_err().to_string();
    assert!(message.contains("stands still") && message.contains("(operation fair"), "{message}");
}

/// A sheet with a pole opens there as soon as it deforms, by what has no bound: that is no reason to refuse it, soft or stiff.
#[test]
fn a_pole_is_not_torn() {
    for stiffness in [300.0, 3e4, 3e5] {
        let space = Space::clamped_uniform(3, 5).unwrap();
        let at = |k: usize| {
            let (r, turn) = ((k / 5) as f64 / 4.0, (k % 5) as f64 / 4.0 * std::f64::consts::FRAC_PI_2);
            Point::new(r * turn.cos(), r * turn.sin(), 0.3 * (1.0 - r * r))
        };
        let fan = Surface::new(space.clone(), space, (0..25).map(at).collect()).unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("fan", Geometry::Surface(fan))).unwrap();
        let held = json!([{ "kind": "fixed", "at": [2, 0] }, { "kind": "fixed", "at": [2, 2] }]);
        for mut fields in [json!({ "seconds": 0.2 }), json!({ "settle": true })] {
            (fields["stiffness"], fields["constraints"]) = (json!(stiffness), held.clone());
            if let Err(error) = run(&mut scene.clone(), fields) {
                panic!("{stiffness}: {error}");
            }
        }
    }
}

/// Times are told to a thousandth of the motion where that is shorter than a second.
#[test]
fn short_times_are_told_apart() {
    let space = Space::clamped_uniform(3, 6).unwrap();
    for size in [1.0, 1e-9] {
        let points = (0..6).map(|i| Point::new(0.2 * size * f64::from(i), 0.0, 0.0)).collect();
        let curve = Curve::new(space.clone(), points).unwrap();
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        scene.add(Object::new("rope", Geometry::Curve(curve))).unwrap();
        let time = 0.5 * f64::sqrt(size);
        let fields = json!({ "seconds": time, "frames_per_second": 20.0 / time, "constraints": [
            { "kind": "fixed", "at": 0, "name": "nail", "until": 0.61 * time },
        ] });
        let notes = run(&mut scene, fields).unwrap().notes;
        let wanted = if size == 1.0 { "0.305 s: \"nail\"" } else { "9.64e-6 s: \"nail\"" };
        assert!(notes.iter().any(|note| note.starts_with(wanted)), "{notes:?}");
    }
}

/// What comes after the end is told of, constraints, pulls and forces alike, and blames no field that was not given.
#[test]
fn what_never_comes_is_told() {
    for (list, item, word) in [
        (
            "constraints",
            json!({ "kind": "fixed", "at": 3, "from": 5 }),
            "never holds: it comes at 5 s, after the end",
        ),
        (
            "constraints",
            json!({ "kind": "fixed", "at": 3, "to": [0, 0, 1], "from": 5 }),
            "never holds: it comes at 5 s",
        ),
        (
            "pull",
            json!({ "at": 3, "to": [[0, 0, 1], [1, 0, 1]], "stiffness": 5, "from": 5 }),
            "never acts: it comes at 5 s, after the end",
        ),
        (
            "forces",
            json!({ "at": 3, "force": [0, 0, 1], "from": 5 }),
            "never acts: it comes at 5 s, after the end",
        ),
    ] {
        let notes = run(&mut scene(), json!({ "seconds": 0.25, list: [item] })).unwrap().notes;
        assert!(notes.iter().any(|note| note.contains(word)), "{list}: {notes:?}");
    }
    // A time of arrival that was given is blamed.
    let early = json!({ "seconds": 1, "pull": [{ "at": 3, "to": [0, 0, 1], "stiffness": 5, "from": 0.5, "arrive": 0.2 }] });
    let message = run(&mut scene(), early).unwrap_err().to_string();
    assert!(message.contains("pull[0].arrive: 0.2 s is before 0.5 s"), "{message}");
}

/// What a model does that a rope or a sheet would not is said: bending that shrinks, a fold within a span, mass beside the area.
#[test]
fn what_is_not_as_in_nature_is_told() {
    let held = json!([{ "kind": "fixed", "at": 0 }]);
    let arc = |degree: usize, n: usize| {
        let at = |i: usize| std::f64::consts::PI * i as f64 / (n - 1) as f64;
        let points = (0..n).map(|i| Point::new(-0.5 * at(i).cos(), 0.0, 0.5 * at(i).sin())).collect();
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        let curve = Curve::new(Space::clamped_uniform(degree, n).unwrap(), points).unwrap();
        scene.add(Object::new("arc", Geometry::Curve(curve))).unwrap();
        scene
    };
    for (bending, shrinks) in [(1.0, false), (1e3, true)] {
        let fields = json!({ "settle": true, "stiffness": 100, "bending": bending, "gravity": [0, 0, 0], "constraints": held });
        let warnings = run(&mut arc(3, 9), fields).unwrap().warnings;
        let told =
            warnings.iter().any(|w| w.contains("% shorter than at rest") && w.contains("more stiffness"));
        assert_eq!(told, shrinks, "{bending}: {warnings:?}");
    }
    // An exact half circle is of degree 2, whose bending shrinks it before it straightens it, from a hundredth of what is called strong.
    let half = Curve::arc(
        Point::new(1.0, 0.0, 0.0),
        Point::origin(),
        loftsman_kernel::Vector::z(),
        std::f64::consts::PI,
    )
    .unwrap();
    for (share, shrinks) in [(1e-4, false), (0.01, true), (0.05, true), (0.099, true)] {
        let mut scene = Scene::new();
        scene.add(Object::new("arc", Geometry::Curve(half.clone()))).unwrap();
        let bending = 100.0 * share * std::f64::consts::PI.powi(2);
        let fields = json!({ "settle": true, "stiffness": 100, "bending": bending, "gravity": [0, 0, 0] });
        let warnings = run(&mut scene, fields).unwrap().warnings;
        assert_eq!(
            warnings.iter().any(|w| w.contains("% shorter than at rest")),
            shrinks,
            "{share}: {warnings:?}"
        );
    }
    // A ring cannot unbend: by `λ = 1/(1 + bending/(stiffness r²))` it is smaller at rest.
    for (bending, shrinks) in [(0.0005, false), (0.5, true)] {
        let points = (0..24).map(|i| {
            let t = f64::from(i) * std::f64::consts::TAU / 24.0;
            Point::new(0.5 * t.cos(), 0.5 * t.sin(), 0.0)
        });
        let curve = Curve::new(Space::periodic_uniform(3, 24).unwrap(), points.collect()).unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("ring", Geometry::Curve(curve))).unwrap();
        let held = json!([{ "kind": "fixed", "at": 0 }]);
        let fields = json!({ "settle": true, "stiffness": 100, "bending": bending, "gravity": [0, 0, 0], "constraints": held });
        let warnings = run(&mut scene, fields).unwrap().warnings;
        // x = 0.5/(100 · 0.5²) = 2 %: by x/(1 + x) = 1.96 %, all of it by its bending.
        let told = |w: &String| w.contains("2 % shorter than at rest") && w.contains("by about 2 %");
        assert_eq!(warnings.iter().any(told), shrinks, "{bending}: {warnings:?}");
    }
    // Drawn through a point to where it came from, without a vertex to turn at.
    let held = json!([
        { "kind": "fixed", "at": 0, "to": [0, 0, 0] },
        { "kind": "sliding", "near": 3.5, "to": [1, 0, 0] },
        { "kind": "fixed", "at": 7, "to": [0, 0, 0] },
    ]);
    for (to, folds) in [([0.0, 0.0, 0.0], true), ([0.0, 1.0, 0.0], false)] {
        let mut held = held.clone();
        held[2]["to"] = json!(to);
        let fields = json!({ "settle": true, "corners": false, "stiffness": 100, "bending": 1e-3, "gravity": [0, 0, 0], "constraints": held });
        let warnings = run(&mut arc(2, 9), fields).unwrap().warnings;
        let told = warnings.iter().any(|w| w.contains("turns back at 3.5, within a span"));
        assert_eq!(told, folds, "{to:?}: {warnings:?}");
    }
    for (corner, off) in [([2.0, 2.0, 0.0], false), ([3.0, 3.0, 0.0], true)] {
        let corners = [[0.0; 3], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], corner];
        let line = || Space::clamped_uniform(1, 2).unwrap();
        let sheet = Surface::new(line(), line(), corners.map(Point::from).to_vec()).unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("kite", Geometry::Surface(sheet))).unwrap();
        let fields =
            json!({ "settle": true, "stiffness": 1e4, "constraints": [{ "kind": "fixed", "at": [0, 0] }] });
        let notes = run(&mut scene, fields).unwrap().notes;
        let told = notes.iter().find(|note| note.contains("its centre lies"));
        assert_eq!(told.is_some(), off, "{notes:?}");
    }
}

/// How far a motion is is told frame by frame, and who has seen enough stops it: nothing has changed then.
#[test]
fn a_motion_tells_how_far_it_is() {
    #[derive(Default)]
    struct Watch {
        seen: RefCell<Vec<(String, u64, u64)>>,
        enough: Option<u64>,
    }
    impl Observer for Watch {
        fn progress(&self, work: &str, done: u64, total: u64) {
            self.seen.borrow_mut().push((work.to_owned(), done, total));
        }
        fn cancelled(&self) -> bool {
            let last = self.seen.borrow().last().map(|(_, done, _)| *done);
            self.enough.is_some_and(|enough| last >= Some(enough))
        }
    }
    for enough in [None, Some(5)] {
        let mut registry = Registry::new();
        registry.add(&Dynamics);
        let operation = registry.find_operation("simulate", "step[0]").unwrap();
        let fields = json!({ "seconds": 0.5, "settle": true, "constraints": [{ "kind": "fixed", "at": 0 }] });
        let watch = Watch { enough, ..Watch::default() };
        let context = Context { observer: &watch, ..Context::quiet(&registry) };
        let mut scene = scene();
        let before = scene.object("rope").unwrap().geometry().points().to_vec();
        let done = operation.apply(&mut scene, &Parameters::new(fields, "step[0]").unwrap(), &context);
        let seen = watch.seen.into_inner();
        let last = enough.unwrap_or(12);
        let frames: Vec<u64> = seen.iter().filter(|s| s.0 == "simulate" && s.2 == 12).map(|s| s.1).collect();
        assert_eq!(frames, (1..=last).collect::<Vec<_>>(), "{seen:?}");
        assert_eq!(seen.iter().any(|s| s.0 == "settle"), enough.is_none(), "{seen:?}");
        assert_eq!(done.is_ok(), enough.is_none());
        assert_eq!(scene.object("rope").unwrap().geometry().points() == before, enough.is_some());
    }
}

/// An end that passes its ring is warned of, where others still hold the rope; times that are no whole frames are told.
#[test]
fn an_end_that_has_passed_is_warned_of() {
    let held = json!([
        { "kind": "fixed", "at": 9, "to": [[2.2, 0, 0.1], [4.2, 0, 0.1]], "name": "hand" },
        { "kind": "sliding", "near": 0.5, "name": "ring" },
    ]);
    let fields = json!({ "seconds": 0.99, "scheme": "implicit", "gravity": [0, 0, 0], "constraints": held });
    let report = run(&mut scene(), fields).unwrap();
    let [warning] = &report.warnings[..] else { unreachable!("one: {:?}", report.warnings) };
    assert!(warning.contains("has passed \"ring\" (") && !warning.contains("hand"), "{warning}");
    assert!(report.notes.iter().any(|note| note.ends_with(": 24 whole frames")), "{:?}", report.notes);
    let cut = run(&mut scene(), json!({ "seconds": 0.05 })).unwrap();
    assert!(cut.notes.iter().any(|note| note.contains(": 1 whole frame, and no path")), "{:?}", cut.notes);
    let short = run(&mut scene(), json!({ "seconds": 0.03 })).unwrap();
    assert!(short.notes.iter().any(|note| note.ends_with(": 1 whole frame")), "{:?}", short.notes);
}

/// What is told of a motion into which nothing is put, and of both sides of a ring at rest.
#[test]
fn energies_and_sides_are_told() {
    let mut scene = scene();
    let held = json!([{ "kind": "fixed", "at": 0 }, { "kind": "sliding", "near": 4, "name": "ring" }, { "kind": "fixed", "at": 9 }]);
    let fields =
        json!({ "seconds": 0.5, "settle": true, "gravity": [0, 0, 0], "rest": 0.8, "constraints": held });
    let first = scene.clone();
    let report = run(&mut scene, fields).unwrap();
    let notes = &report.notes;
    // Where it is no more than rounding no figure is told.
    let rose = notes.iter().find_map(|note| note.strip_prefix("nothing was put in, and energy ")).unwrap();
    let figure =
        rose.strip_prefix("rose by ").map(|rest| rest.split(' ').next().unwrap().parse::<f64>().unwrap());
    let told = figure.map_or(rose == "never rose", |rose| (1e-10..100.0 / 3.0).contains(&rose));
    assert!(told, "{notes:?}");
    let sides =
        notes.iter().find_map(|note| note.strip_prefix("\"ring\": on both sides stretched by ")).unwrap();
    let numbers: Vec<f64> =
        sides.split(" % and ").map(|n| n.trim_end_matches(" %").parse().unwrap()).collect();
    // As long as chords say, over what they say of the rope at the start, of which 0.8 is its rest.
    let ring = report.constraints.iter().find(|c| c.name == "ring").unwrap().location.clone().unwrap()[0];
    let first = first.object("rope").unwrap().geometry().clone();
    let now = scene.object("rope").unwrap().geometry();
    let length = |of: &Geometry, from: f64, to: f64| -> f64 {
        let Geometry::Curve(curve) = of else { unreachable!("a curve") };
        let at = |k: usize| curve.point(from + (to - from) * k as f64 / 2000.0).unwrap();
        (0..2000).map(|k| (at(k + 1) - at(k)).norm()).sum()
    };
    for (told, [from, to]) in numbers.iter().zip([[0.0, ring], [ring, 9.0]]) {
        let own = 100.0 * (length(now, from, to) / (0.8 * length(&first, from, to)) - 1.0);
        assert!((told - own).abs() < 0.02, "{sides}: {own} from {from} to {to}");
    }
    // To half a span of each side.
    let apart = ((100.0 + numbers[0]) / (100.0 + numbers[1]) - 1.0).abs();
    assert!(numbers.len() == 2 && apart < 0.5 / ring + 0.5 / (9.0 - ring), "{sides}");
}

/// A circle of clamped knots closes by its points, and runs smoothly over double knots by these: what of that a motion loses is said.
#[test]
fn what_comes_open_or_folds_is_said() {
    let hoop = |periodic: bool| {
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        let mut circle = Curve::circle(Point::origin(), loftsman_kernel::Vector::y(), 0.15).unwrap();
        if periodic {
            let points =
                (0..9).map(|k| circle.point(f64::from(k) * std::f64::consts::TAU / 9.0).unwrap()).collect();
            circle = Curve::new(Space::periodic_uniform(3, 9).unwrap(), points).unwrap();
        }
        scene.add(Object::new("hoop", Geometry::Curve(circle))).unwrap();
        scene
    };
    let told = |periodic: bool, more: Value| {
        let mut constraints = vec![json!({ "kind": "fixed", "at": 0 })];
        constraints.extend(more.as_array().unwrap().iter().cloned());
        let fields = json!({ "seconds": 0.5, "scheme": "implicit", "mass": 0.1, "stiffness": 100,
            "bending": 0.01, "damping": 2, "constraints": constraints });
        run(&mut hoop(periodic), fields).unwrap().warnings.join("; ")
    };
    let end = json!({ "kind": "fixed", "at": std::f64::consts::TAU, "to": [0.1, 0.0, 0.1] });
    let open = told(false, json!([end]));
    assert!(open.contains("\"hoop\" has come open"), "{open}");
    for (periodic, more) in [(false, json!([])), (false, json!([{ "kind": "closed" }])), (true, json!([]))] {
        let smooth = told(periodic, more);
        assert!(!smooth.contains("open") && !smooth.contains("folded"), "{smooth}");
    }
}

/// A tube that closes by its control vertices only, a dome whose pole does, and a sheet that runs smoothly over full knots lose that: each is said, and
/// what keeps it is not.
#[test]
fn what_comes_open_or_folds_of_a_surface_is_said() {
    use loftsman_kernel::Vector;
    use loftsman_kernel::spline::{Direction, Surface};
    let told = |surface: Surface, more: Value, held: Value| {
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        scene.add(Object::new("sheet", Geometry::Surface(surface))).unwrap();
        let mut fields = json!({ "seconds": 0.3, "scheme": "implicit", "mass": 1, "stiffness": 3000, "constraints": held });
        fields.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        run(&mut scene, fields).unwrap().warnings.join("; ")
    };
    let line = |from: [f64; 3], to: [f64; 3]| Curve::line(from.into(), to.into()).unwrap();
    let revolved = |profile: &Curve| {
        Surface::revolution(profile, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
    };
    let hung = json!([{ "kind": "fixed", "at": [std::f64::consts::PI, 0] }]);
    let tube = revolved(&line([1.0, 0.0, 0.0], [1.0, 0.0, 1.0]));
    let open = told(tube.clone(), json!({}), hung.clone());
    assert!(
        open.contains("\"sheet\" has come open: its edges at the ends of u, which met, are up to "),
        "{open}"
    );
    let cone = revolved(&line([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
    let open = told(
        cone,
        json!({ "stiffness": 300 }),
        json!([{ "kind": "fixed", "at": [std::f64::consts::PI, 1] }]),
    );
    assert!(open.contains("which was one point, is "), "{open}");
    let round = tube.to_periodic(Direction::U, 1e-3);
    if let Ok(round) = round {
        let shut = told(round.shape, json!({}), json!([{ "kind": "fixed", "at": [0, 0] }]));
        assert!(!shut.contains("come open"), "{shut}");
    }
    // Two bicubic pieces along u, smooth where they meet, and the same with simple knots.
    let flat = |knots: Vec<f64>| {
        let (u, v) = (Space::open(3, knots).unwrap(), Space::open(1, vec![0.0, 0.0, 1.0, 1.0]).unwrap());
        let points = (0..u.len()).flat_map(|i| (0..2).map(move |j| (i, j)));
        let across = (u.len() - 1) as f64;
        let points = points.map(|(i, j)| Point::new(2.0 * i as f64 / across, j as f64, 0.0)).collect();
        Surface::new(u, v, points).unwrap()
    };
    let ends = json!([{ "kind": "fixed", "at": [0, 0] }, { "kind": "fixed", "at": [0, 1] }, { "kind": "fixed", "at": [2, 0] }, { "kind": "fixed", "at": [2, 1] },
        { "kind": "fixed", "at": [1, 0.5], "to": [1, 0.5, 0.6] }]);
    let loose = json!({ "gravity": [0, 0, 0], "damping": 3, "draw": 0.05 });
    let folded =
        told(flat(vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]), loose.clone(), ends.clone());
    assert!(folded.contains("\"sheet\" has folded along u = 1 by up to "), "{folded}");
    let smooth = told(flat(vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.5, 2.0, 2.0, 2.0, 2.0]), loose, ends);
    assert!(!smooth.contains("folded"), "{smooth}");
}

/// Two places of a flat sheet that are to be one come together where they are one: the constraint lets go, and the sheet rests as if without it.
#[test]
fn places_of_a_sheet_that_come_together_let_go() {
    use loftsman_kernel::spline::Surface;
    let space = || Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let points = (0..16).map(|k| Point::new(f64::from(k / 4) / 3.0, f64::from(k % 4) / 3.0, 0.0)).collect();
    let sheet = Surface::new(space(), space(), points).unwrap();
    let fixed = |u: f64, v: f64| json!({ "kind": "fixed", "at": [u, v] });
    let mut shut = 0;
    for (more, near) in [
        (json!({ "settle": true }), [[0.2, 0.9], [1.8, 1.1]]),
        (json!({ "settle": true }), [[0.5, 0.7], [1.4, 1.3]]),
        (json!({ "seconds": 1, "settle": true, "damping": 3 }), [[0.6, 1.1], [1.4, 1.3]]),
    ] {
        let done = |constraints: Value| {
            let mut scene = Scene::new();
            scene.unit = Unit::Metre;
            scene.add(Object::new("sheet", Geometry::Surface(sheet.clone()))).unwrap();
            let mut fields = json!({ "mass": 0.3, "stiffness": 60, "constraints": constraints });
            fields.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            let report = run(&mut scene, fields).unwrap();
            (scene.object("sheet").unwrap().geometry().points().to_vec(), report)
        };
        let both = json!([fixed(0.0, 0.0), fixed(0.0, 2.0), { "kind": "double-sliding", "near": near }]);
        let (_, report) = done(both);
        let words = format!("{:?} {:?}", report.notes, report.warnings);
        // Or over the edge, where that is nearer.
        let is_shut = words.contains("its loop is drawn shut");
        shut += usize::from(is_shut);
        let warned = report
            .warnings
            .iter()
            .any(|warning| warning.contains("loops are drawn shut at \"double sliding"));
        assert_eq!(is_shut, warned, "{words}");
        assert!(words.contains("its loop is drawn shut") || words.contains("it left the shape"), "{words}");
        // What holds it bears its weight, straight up.
        let supports = report
            .constraints
            .iter()
            .take(2)
            .map(|c| loftsman_kernel::Vector::from_column_slice(&c.multipliers));
        let sum: loftsman_kernel::Vector = supports.sum();
        let weight = 0.3 * 9.81;
        assert!(
            (sum.norm() - weight).abs() < 2e-3 * weight && (sum.z.abs() - weight).abs() < 2e-3 * weight,
            "{sum:?}"
        );
    }
    assert!(shut > 0);
}

/// Where a rope turns at a ring it rests with a corner there: all its frames have the same control vertices, and are the same curves as without.
#[test]
fn a_corner_goes_into_all_frames() {
    let held = json!([
        { "kind": "fixed", "at": 0, "name": "nail" },
        { "kind": "sliding", "near": 4, "to": [0.8, 0, 0.1], "name": "ring" },
        { "kind": "fixed", "at": 9, "to": [0.7, 0, 1.6] },
    ]);
    for settle_frames in [false, true] {
        let done = |corners: bool| {
            let mut scene = scene();
            let fields = json!({ "seconds": 0.5, "scheme": "implicit", "settle": true, "gravity": [0, 0, 0],
                "settle_frames": settle_frames, "corners": corners, "constraints": held });
            let report = run(&mut scene, fields).unwrap();
            (scene.object("rope").unwrap().clone(), report)
        };
        let ((smooth, told), (object, report)) = (done(false), done(true));
        let corner =
            |report: &StepReport| report.notes.iter().any(|note| note.contains("it has a corner there"));
        assert!(corner(&report) && !corner(&told), "{:?} {:?}", report.notes, told.notes);
        let curve = |object: &Object, points: &[Point]| {
            let Geometry::Curve(own) = object.geometry() else { unreachable!("a curve") };
            Curve::new(own.space().clone(), points.to_vec()).unwrap()
        };
        let [cornered, plain] = [&object, &smooth].map(|object| &object.animation.as_ref().unwrap().frames);
        assert_eq!(
            (cornered.len(), plain.len()),
            (13 + usize::from(settle_frames), 13 + usize::from(settle_frames))
        );
        for (frame, (a, b)) in cornered.iter().zip(plain).take(13).enumerate() {
            assert_eq!((a.len(), b.len()), (object.geometry().points().len(), 12), "{frame}");
            let (a, b) = (curve(&object, a), curve(&smooth, b));
            let off = |k: i32| {
                (a.point(0.09 * f64::from(k)).unwrap() - b.point(0.09 * f64::from(k)).unwrap()).norm()
            };
            assert!((0..=100).all(|k| off(k) < 1e-12), "{frame}");
        }
        if settle_frames {
            assert_eq!(cornered[13], object.geometry().points());
        }
        // Both sides are told, alike.
        let sides =
            report.notes.iter().find_map(|note| note.strip_prefix("\"ring\": on both sides stretched by "));
        let numbers: Vec<&str> = sides.unwrap().split(" % and ").map(|n| n.trim_end_matches(" %")).collect();
        assert_eq!(numbers[0], numbers[1]);
    }
}

/// What settles at once is led to the end of its path, whenever it is to arrive.
#[test]
fn what_settles_at_once_is_at_the_end_of_its_path() {
    for arrive in [json!(null), json!(2)] {
        let mut hand = json!({ "kind": "fixed", "at": 9, "to": [[1, 0, 0], [1.2, 0, 1], [1.5, 0, 1.2]] });
        if !arrive.is_null() {
            hand["arrive"] = arrive.clone();
        }
        let mut scene = scene();
        let fields = json!({ "settle": true, "constraints": [{ "kind": "fixed", "at": 0 }, hand] });
        run(&mut scene, fields).unwrap();
        let end = *scene.object("rope").unwrap().geometry().points().last().unwrap();
        assert!((end - Point::new(1.5, 0.0, 1.2)).norm() < 1e-8, "{arrive}: {end}");
    }
}

/// Of what holds no more there is no error: `null` in JSON, not 0.
#[test]
fn what_let_go_has_no_error() {
    let held = json!([{ "kind": "fixed", "at": 0, "until": 0.1 }, { "kind": "fixed", "at": 9 }]);
    let report =
        run(&mut scene(), json!({ "seconds": 0.5, "scheme": "implicit", "constraints": held })).unwrap();
    let told = serde_json::to_value(&report).unwrap();
    assert!(told["constraints"][0]["residual"].is_null(), "{told}");
    assert!(told["constraints"][1]["residual"].as_f64().unwrap() < 1e-6, "{told}");
    assert!(told["residual"].as_f64().unwrap() < 1e-6, "{told}");
}

/// The stiffness that is not said follows from the curve, not from its control vertices: more of them change nothing, and the closing piece of a closed one counts.
#[test]
fn the_stiffness_that_is_not_said_is_the_curves() {
    let elastic = |curve: Curve| {
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        scene.add(Object::new("rope", Geometry::Curve(curve))).unwrap();
        // From what gravity does to it in one short moment.
        let held = json!([{ "kind": "fixed", "at": 0.0, "to": [0.0, 0.0, 0.02] }]);
        let fields = json!({ "seconds": 0.05, "gravity": [0, 0, 0], "draw": 0.01, "constraints": held });
        let report = run(&mut scene, fields).unwrap();
        let stable = report.notes.iter().find_map(|note| note.split_once("(stable to ")).unwrap().1;
        stable.split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    // The longest stable step goes by the root of the stiffness, and by the spans.
    let line = |points: &[[f64; 3]]| {
        let points: Vec<Point> = points.iter().copied().map(Point::from).collect();
        Curve::new(Space::clamped_uniform(1, points.len()).unwrap(), points).unwrap()
    };
    let long = elastic(line(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]));
    let back = elastic(line(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]));
    assert!((long / back - 1.0).abs() < 1e-3, "{long} {back}");
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    let closed =
        Curve::new(Space::periodic_uniform(1, 4).unwrap(), square.map(Point::from).to_vec()).unwrap();
    let open = line(&[square[0], square[1], square[2], square[3], square[0]]);
    let (closed, open) = (elastic(closed), elastic(open));
    assert!((closed / open - 1.0).abs() < 1e-3, "{closed} {open}");
}

/// A second derivative that slides along a cubic is no more than continuous at each knot: where it rests on one the report says so, in words of knots and not of corners.
#[test]
fn a_curvature_that_rests_on_a_knot_is_told() {
    let mut on_knots = 0;
    for near in [2.2, 3.6, 4.5, 5.3, 6.7] {
        for by in [-0.6, 0.3, 0.8] {
            let mut scene = scene();
            let constraints = json!([
                { "kind": "fixed", "at": 0 },
                { "kind": "fixed", "at": 9 },
                { "kind": "sliding-curvature", "near": near, "curvature": [0, 0, by], "name": "bow" },
            ]);
            let fields = json!({ "settle": true, "mass": 0.2, "bending": 0.1, "constraints": constraints });
            let Ok(report) = run(&mut scene, fields) else { continue };
            let Some(note) = report.notes.iter().find(|note| note.starts_with("\"bow\" ends at ")) else {
                continue;
            };
            assert!(!note.contains("corner"), "{note}");
            let at: f64 = note["\"bow\" ends at ".len()..].split(',').next().unwrap().parse().unwrap();
            let told = note.ends_with(", on a knot, where what it holds is no more than continuous");
            assert_eq!(told, at.fract() == 0.0, "{note}");
            on_knots += usize::from(told);
        }
    }
    assert!(on_knots > 0, "none rested on a knot");
}

/// Curvature is linear beside a derivative that stands still, which none does in a motion: it is refused, as all that is not linear.
#[test]
fn what_is_linear_only_beside_something_else_is_refused() {
    for kind in ["curvature", "magnitude"] {
        let table = json!({ "kind": kind, "at": 0.5, "keep": true });
        let message =
            run(&mut scene(), json!({ "seconds": 1, "constraints": [table] })).unwrap_err().to_string();
        assert!(message.contains(kind) && message.contains("not linear"), "{message}");
    }
}

/// A lace drawn zigzag through rings is held back where it turns within its spans: both sides of each ring are told after a motion, and where that is. A straight one is not.
#[test]
fn what_holds_a_lace_back_in_a_motion_is_told() {
    for (width, jams) in [(0.6, true), (0.0, false)] {
        let points: Vec<Point> = (0..41)
            .map(|i| {
                let (leg, along) = (i / 10, f64::from(i % 10) / 10.0);
                let across = if leg % 2 == 0 { along } else { 1.0 - along };
                Point::new(0.02 * f64::from(i), width * across, 0.0)
            })
            .collect();
        let curve = Curve::new(Space::clamped_uniform(2, 41).unwrap(), points).unwrap();
        let mut scene = Scene::new();
        scene.unit = Unit::Metre;
        let rings = [9.5, 19.5, 29.5]
            .map(|at| json!({ "kind": "sliding", "near": at, "name": format!("ring {at}") }));
        let [a, b, c] = rings;
        let end = curve.points()[40];
        let held = json!([{ "kind": "fixed", "at": 0 }, a, b, c,
            { "kind": "fixed", "at": 39, "to": [[end.x, end.y, 0], [end.x + 0.5, end.y - 0.1 * width, 0]], "arrive": 1, "name": "hand" }]);
        scene.add(Object::new("lace", Geometry::Curve(curve))).unwrap();
        let fields = json!({ "seconds": 3, "scheme": "implicit", "step": 0.01, "stiffness": 50, "damping": 5, "gravity": [0, 0, 0], "constraints": held });
        let report = run(&mut scene, fields).unwrap();
        let sides = report.notes.iter().filter(|note| note.contains("on both sides stretched by ")).count();
        assert_eq!(sides, 3, "{:?}", report.notes);
        let held_back = report.notes.iter().find(|note| note.contains("holds it back as friction would"));
        assert_eq!(held_back.is_some(), jams, "{:?}", report.notes);
        assert!(held_back.is_none_or(|note| note.contains("\"ring 29.5\"")), "{held_back:?}");
    }
}
