//! What the operations say of wrong fields: the scene stays as it was, and the message says what is wrong.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should panic")]

use loftsman_construction::Construction;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{Context, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface, Trimmed};
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn scene() -> Scene {
    let mut scene = Scene::new();
    let mut add = |name: &str, geometry: Geometry| scene.add(Object::new(name, geometry)).unwrap();
    let p = Point::new;
    add("line", Curve::line(p(0.0, 0.0, 0.0), p(0.0, 0.0, 2.0)).unwrap().into());
    add("ring", Curve::circle(p(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap().into());
    add(
        "helix",
        Curve::bezier((0..5).map(f64::from).map(|t| p(t.cos(), t.sin(), t)).collect()).unwrap().into(),
    );
    let bent = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0)];
    add("bent", Curve::new(Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(), bent).unwrap().into());
    let torn = (0..4).map(|k| p(f64::from(k), f64::from(k % 2), 0.0)).collect();
    add(
        "torn",
        Curve::new(Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap(), torn).unwrap().into(),
    );
    let ring = Curve::circle(p(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    let torus = Surface::revolution(&ring, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let torus = torus.to_periodic(Direction::U, 0.0).unwrap().shape;
    add("torus", torus.to_periodic(Direction::V, 0.0).unwrap().shape.into());
    add("sheet", Surface::extrusion(&ring, Vector::y()).unwrap().into());
    add("block", Brep::block(Point::origin(), p(3.0, 4.0, 12.0)).unwrap().into());
    add("dots", Cloud { points: vec![p(1.0, 2.0, 3.0)] }.into());
    add("dot", Polyline { points: vec![p(1.0, 2.0, 3.0); 3], closed: true }.into());
    scene
}

fn run(scene: &mut Scene, op: &str, fields: Value) -> Result<StepReport, String> {
    let mut registry = Registry::new();
    registry.add(&Construction);
    let operation = registry.find_operation(op, "op").unwrap().clone();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry)).map_err(|e| e.to_string())
}

#[test]
fn wrong_fields_are_told() {
    let cases = [
        ("line", json!({ "from": [1, 2, 3], "to": [1, 2, 3] }), "to: is where the line starts"),
        (
            "line",
            json!({ "from": [0, 0, 0], "to": [1, 0, 0], "name": "ring" }),
            "there is an object \"ring\" already",
        ),
        ("polyline", json!({ "points": [[0, 0, 0]] }), "a polyline needs 2 points at least, and has 1"),
        ("polyline", json!({ "points": [[0, 0, 0], [1, 0, 0]], "closed": true }), "needs 3 points at least"),
        ("circle", json!({ "radius": 0 }), "0 is no length: give a number above 0"),
        ("circle", json!({ "radius": 1, "normal": [0, 0, 0] }), "normal: [0, 0, 0] has no direction"),
        ("arc", json!({ "from": [1, 0, 0], "degrees": 400 }), "400 degrees cannot be turned"),
        ("arc", json!({ "from": [1, 0, 0], "degrees": 0 }), "0 degrees cannot be turned"),
        ("arc", json!({ "from": [0, 0, 1] }), "from: "),
        ("arc", json!({ "from": [0, 0, 0], "through": [1, 0, 0], "to": [2, 0, 0] }), "lie on a line"),
        (
            "arc",
            json!({ "from": [0, 0, 0], "through": [1, 1, 0], "to": [2, 0, 0], "degrees": 5 }),
            "says nothing of an arc",
        ),
        ("ellipse", json!({ "x": [1, 0, 0], "y": [0, 0, 0] }), "y: "),
        (
            "ellipse",
            json!({ "x": [1, 0, 0], "y": [0, 1, 0], "degrees": 90, "periodic": true }),
            "an arc has ends",
        ),
        ("revolve", json!({ "object": "line" }), "\"line\" lies on the axis"),
        (
            "revolve",
            json!({ "object": "ring", "point": [3, 0, 0], "axis": [0, -2, 0] }),
            "\"ring\" runs along its own circle about the axis",
        ),
        (
            "revolve",
            json!({ "object": "ring", "degrees": 90, "periodic": true }),
            "a part of a turn has ends",
        ),
        ("revolve", json!({ "object": "dots" }), "object: "),
        ("isocurve", json!({ "object": "torus" }), "say where: u or v"),
        ("isocurve", json!({ "object": "sheet", "direction": "u" }), "it goes with at = number"),
        ("isocurve", json!({ "object": "sheet", "at": [0.5] }), "a place of a surface is [u, v]"),
        ("isocurve", json!({ "object": "sheet", "at": [0.5, 0.5], "direction": "u" }), "at: "),
        ("isocurve", json!({ "object": "sheet", "at": [0.5, 1.5] }), "at: 1.5 is outside the domain [0, 1]"),
        ("isocurve", json!({ "object": "sheet", "v": 1.5 }), "1.5 is outside the domain [0, 1]"),
        (
            "edge",
            json!({ "object": "torus", "edge": "u0" }),
            "there is no edge u0: the surface's edges are none: it is closed",
        ),
        ("edge", json!({ "object": "dots", "edge": "u0" }), "which has no edges: name a surface or a brep"),
        (
            "edge",
            json!({ "object": "block", "edge": "u0" }),
            "the brep's edges are \"edge 0\" to \"edge 11\"",
        ),
        ("edge", json!({ "object": "block", "edge": "edge 12" }), "there is no edge 12"),
        ("edge", json!({ "object": "block", "edge": { "closest": [1, 2] } }), "closest"),
        ("edge", json!({ "object": "block", "edge": { "near": [1, 2, 3] } }), "near"),
        ("edge", json!({ "object": "torus", "edge": { "closest": [1, 2, 3] } }), "\"torus\" has no edges"),
        ("sample", json!({ "object": "ring", "objects": ["line"], "count": 5 }), "object is given, too"),
        ("sample", json!({ "objects": [], "count": 5 }), "is empty: name an object at least"),
        ("sample", json!({ "objects": ["ring", "ring"], "count": 5 }), "\"ring\" is named twice"),
        ("sample", json!({ "objects": ["ring", 3], "count": 5 }), "entry 1 is 3"),
        ("sample", json!({ "objects": ["ring", "dots"], "count": 5 }), "objects: \"dots\" is a cloud"),
        ("sample", json!({ "objects": ["ring", "nobody"], "count": 5 }), "nobody"),
        ("sample", json!({ "object": "ring" }), "say count = …, or spacing"),
        ("sample", json!({ "object": "ring", "count": 5, "spacing": 1 }), "leave one of them out"),
        ("sample", json!({ "object": "dot", "count": 5 }), "\"dot\" has no length"),
        ("sample", json!({ "object": "torus", "count": 5 }), "name a curve or a polyline"),
        ("offset", json!({ "object": "ring", "distance": 0 }), "distance: 0 moves nothing"),
        ("offset", json!({ "object": "ring", "distance": 1, "tolerance": -1 }), "tolerance: -1 is no length"),
        (
            "offset",
            json!({ "object": "ring", "distance": -2 }),
            "\"ring\": nothing of the curve is 2 m away on that side",
        ),
        (
            "offset",
            json!({ "object": "line", "distance": 1 }),
            "\"line\": the curve is straight and lies in many planes",
        ),
        (
            "offset",
            json!({ "object": "helix", "distance": 1 }),
            "the curve leaves its plane by 0.352136 m: only planar",
        ),
        ("offset", json!({ "object": "torus", "distance": 1 }), "name a curve or a polyline"),
        ("offset", json!({ "object": "ring", "distance": 1, "corners": "mitre" }), "corners: "),
        ("offset", json!({ "object": "dot", "distance": 1 }), "\"dot\": the curve is a point"),
        (
            "sweep",
            json!({ "object": "ring", "path": "bent" }),
            "\"ring\": beside the corners around 0.5 of the path",
        ),
        ("sweep", json!({ "object": "ring", "path": "torn" }), "\"ring\": the path is torn at 1"),
        ("sweep", json!({ "object": "ring", "path": "dots" }), "path: "),
        ("sweep", json!({ "object": "torus", "path": "line" }), "object: "),
        (
            "sweep",
            json!({ "object": "ring", "path": "line", "frame": "upright" }),
            "runs along the upright direction at 0",
        ),
        (
            "sweep",
            json!({ "object": "ring", "path": "line", "up": [1, 0, 0] }),
            "up: is for frame = \"upright\" only",
        ),
        ("sweep", json!({ "object": "ring", "path": "line", "tolerance": 0 }), "tolerance: 0 is no length"),
        ("symmetrize", json!({ "object": "ring" }), "\"ring\": the closed curve does not cross the plane"),
        (
            "symmetrize",
            json!({ "object": "line", "half": "front" }),
            "\"line\": the curve lies in the plane, and is its own mirror image",
        ),
        ("symmetrize", json!({ "object": "line", "direction": "v" }), "direction: is of a surface"),
        (
            "symmetrize",
            json!({ "object": "sheet", "half": "back" }),
            "nothing of the surface is behind the plane: keep the other half",
        ),
        (
            "symmetrize",
            json!({ "object": "torus", "half": "front" }),
            "\"torus\": the surface is periodic in u and has no ends there",
        ),
        ("symmetrize", json!({ "object": "dots" }), "is a cloud, not a curve or a surface"),
        (
            "symmetrize",
            json!({ "object": "line", "normal": [0, 0, 0] }),
            "normal: [0, 0, 0] has no direction",
        ),
    ];
    for (op, fields, said) in cases {
        let mut after = scene();
        let error =
            run(&mut after, op, fields.clone()).err().unwrap_or_else(|| panic!("{op} {fields} is taken"));
        assert!(error.contains(said), "{op} {fields}: not \"{said}\" but \"{error}\"");
        assert_eq!(after, scene(), "{op} {fields}");
    }
}

#[test]
fn reports_say_what_was_measured() {
    let mut scene = scene();
    let wider =
        run(&mut scene, "offset", json!({ "object": "ring", "distance": 0.5, "name": "wider" })).unwrap();
    assert!(
        wider.notes.iter().any(|n| n.contains("from where it should be at most, measured both ways")),
        "{wider:?}"
    );
    assert!(
        wider
            .notes
            .iter()
            // One thing needs no second name, and how long it is is measured by who runs the step.
            .any(|n| n == "degree 2, 9 control vertices"),
        "{wider:?}"
    );
    let pipe =
        run(&mut scene, "sweep", json!({ "object": "ring", "path": "helix", "name": "pipe" })).unwrap();
    assert!(pipe.notes.iter().any(|n| n.contains("from where it should be at most, measured")), "{pipe:?}");
    let shifted =
        run(&mut scene, "sweep", json!({ "object": "ring", "path": "torn", "frame": "parallel" })).unwrap();
    assert!(shifted.notes.contains(&"exact".to_owned()), "{shifted:?}");
    let even = run(&mut scene, "symmetrize", json!({ "object": "bent" })).unwrap();
    assert!(even.notes[0].starts_with("places moved by 1 m at most"), "{even:?}");
    // The mean of what is on one side of the plane lies in that: said, with what keeps it.
    assert!(
        even.notes[1].contains("one side of the plane") && even.notes[1].contains("half = \"front\""),
        "{even:?}"
    );
    let split = json!({ "object": "bent" });
    let split = run(&mut scene, "symmetrize", split).unwrap();
    assert_eq!(split.notes.len(), 1, "{split:?}");
    // What a curve with a tear has of offsets: each part its own.
    let parts =
        run(&mut scene, "offset", json!({ "object": "torn", "distance": 0.1, "name": "part" })).unwrap();
    assert!(scene.get("part").is_some() && scene.get("part.001").is_some(), "{parts:?}");
}

/// A mitre that reaches far is warned of, with place and figures.
#[test]
fn a_spike_of_a_sweep_is_warned_of() {
    let mut scene = scene();
    let p = Point::new;
    for (name, degrees) in [("blunt", 90.0_f64), ("sharp", 172.0)] {
        let turn = degrees.to_radians();
        let points = vec![p(-9.0, 0.0, 0.0), p(0.0, 0.0, 0.0), p(9.0 * turn.cos(), 9.0 * turn.sin(), 0.0)];
        let path = Curve::new(Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(), points).unwrap();
        scene.add(Object::new(name, path.into())).unwrap();
    }
    let hoop = Curve::circle(p(-9.0, 0.0, 0.0), Vector::x(), 0.1).unwrap();
    scene.add(Object::new("hoop", hoop.into())).unwrap();
    let blunt = run(&mut scene, "sweep", json!({ "object": "hoop", "path": "blunt" })).unwrap();
    assert!(blunt.warnings.is_empty(), "{blunt:?}");
    assert!((blunt.numbers["mitre"].as_f64().unwrap() - 0.1 * f64::sqrt(2.0)).abs() < 1e-9, "{blunt:?}");
    let sharp = run(&mut scene, "sweep", json!({ "object": "hoop", "path": "sharp" })).unwrap();
    let [said] = &sharp.warnings[..] else { panic!("{sharp:?}") };
    assert!(
        said.contains("turns by 172 degrees, at 1 of it")
            && said.contains("reaches 1.434 m from it, 14 times as far"),
        "{said}"
    );
    assert!(said.contains("split the path"), "{said}");
    // Of many the eight that reach furthest are told, each with its place: with half the turn's cosine.
    let mut way = vec![p(-9.0, 0.0, 0.0)];
    let mut ahead = 0.0_f64;
    let mut told = Vec::new();
    for k in 0..11 {
        let last = way[way.len() - 1];
        way.push(last + Vector::new(ahead.cos(), ahead.sin(), 0.0) * 9.0);
        let turn = 130.0 + 4.0 * f64::from(k * 7 % 11);
        ahead += turn.to_radians() * if k % 2 == 0 { 1.0 } else { -1.0 };
        told.push((0.1 / (0.5 * turn.to_radians()).cos(), k + 1, turn));
    }
    let last = way[way.len() - 1];
    way.push(last + Vector::new(ahead.cos(), ahead.sin(), 0.0) * 9.0);
    let knots: Vec<f64> = (0..way.len()).map(|k| k as f64).collect();
    let path = Curve::new(Space::clamped(1, &knots).unwrap(), way).unwrap();
    scene.add(Object::new("saw", path.into())).unwrap();
    let saw = run(&mut scene, "sweep", json!({ "object": "hoop", "path": "saw" })).unwrap();
    let [said] = &saw.warnings[..] else { panic!("{saw:?}") };
    told.sort_by(|x, y| y.0.total_cmp(&x.0));
    let (reach, at, turn) = told[0];
    let first =
        format!("turns by {turn} degrees, at {at} of it, the mitre of \"hoop\" reaches {} m", figure(reach));
    assert!(said.contains(&first), "{said}");
    let rest: Vec<String> =
        told[1..8].iter().map(|(r, at, turn)| format!("{} m at {at} ({turn} degrees)", figure(*r))).collect();
    let rest = format!(
        "and at 10 other corners more than twice as far: {}, and at 3 more: put an arc",
        rest.join(", ")
    );
    assert!(said.contains(&rest), "{said}\n{rest}");
}

/// A closed profile that leans far off the plane across the path gives a flattened pipe: warned of with the angle.
#[test]
fn a_leaning_profile_is_warned_of() {
    let mut scene = scene();
    let p = Point::new;
    let way = Curve::bezier(vec![p(0.0, 0.0, 0.0), p(0.0, 0.0, 9.0), p(4.0, 0.0, 12.0)]).unwrap();
    scene.add(Object::new("way", way.into())).unwrap();
    for (degrees, warned) in [
        (0.0_f64, false),
        (45.0, false),
        (59.0, false),
        (61.0, true),
        (82.0, true),
        (119.0, true),
        (150.0, false),
    ] {
        let turn = degrees.to_radians();
        let name = format!("hoop {degrees}");
        let hoop = Curve::circle(p(0.0, 0.0, 0.0), Vector::new(turn.sin(), 0.0, turn.cos()), 0.5).unwrap();
        scene.add(Object::new(&name, hoop.into())).unwrap();
        let swept = run(&mut scene, "sweep", json!({ "object": name, "path": "way" })).unwrap();
        let said = swept.warnings.iter().find(|w| w.contains("off the one across the path"));
        assert_eq!(said.is_some(), warned, "{degrees}: {swept:?}");
        if let Some(said) = said {
            assert!(said.contains(&format!("leans {} degrees", degrees.min(180.0 - degrees))), "{said}");
            assert!(degrees != 82.0 || said.contains("14 % as wide"), "{said}");
        }
        let parallel = json!({ "object": name, "path": "way", "frame": "parallel" });
        assert!(run(&mut scene, "sweep", parallel).unwrap().warnings.is_empty());
    }
    // What lies along it is told as laid double.
    let along = Curve::circle(p(0.0, 0.0, 0.0), Vector::x(), 0.5).unwrap();
    scene.add(Object::new("along", along.into())).unwrap();
    let flat = run(&mut scene, "sweep", json!({ "object": "along", "path": "way" })).unwrap();
    assert!(flat.warnings.is_empty() && flat.notes.iter().any(|n| n.contains("laid double")), "{flat:?}");
}

/// Where a curve is wanted and a polyline is there, the message says what makes a curve of it, and that does.
#[test]
fn a_polyline_is_refused_with_the_way_to_a_curve() {
    let way = "the operation \"polyline\" with curve = true, or \"fit\" with degree = 1 and interpolate = true, makes a curve of a polyline";
    let points = json!([[1, 0, 0], [2, 0, 0], [2, 0, 3]]);
    let mut lines = Scene::new();
    run(&mut lines, "polyline", json!({ "points": points, "name": "way" })).unwrap();
    let mut both = lines.clone();
    run(&mut both, "circle", json!({ "radius": 1, "name": "c" })).unwrap();
    for (scene, op, fields) in [
        (&both, "sweep", json!({ "object": "c", "path": "way" })),
        (&both, "sweep", json!({ "object": "way", "path": "c" })),
        (&both, "revolve", json!({ "object": "way" })),
        (&both, "symmetrize", json!({ "object": "way" })),
        (&lines, "revolve", json!({})),
        (&lines, "symmetrize", json!({})),
    ] {
        let told = run(&mut scene.clone(), op, fields).unwrap_err();
        assert!(told.contains("\"way\" is a polyline") && told.contains(way), "{op}: {told}");
    }
    // Where a polyline would do it is not sent away.
    let mut dots = scene();
    dots.retain(|object| object.name() == "dots");
    let told = run(&mut dots, "sample", json!({ "count": 5 })).unwrap_err();
    assert!(told.contains("\"dots\" is a cloud") && !told.contains(way), "{told}");
    let mut made = Scene::new();
    run(&mut made, "polyline", json!({ "points": points, "name": "way", "curve": true })).unwrap();
    run(&mut made, "revolve", json!({ "object": "way" })).unwrap();
}

/// Every edge of a block by its number, and each by a point beyond its middle.
#[test]
fn edges_of_solids_are_taken_by_number_or_by_a_point_near_to_them() {
    let mut all = scene();
    let Geometry::Brep(block) = all.object("block").unwrap().geometry().clone() else { unreachable!() };
    let mut lengths = Vec::new();
    for k in 0..block.edge_count() {
        let report =
            run(&mut all, "edge", json!({ "object": "block", "edge": format!("edge {k}") })).unwrap();
        let name = report.object.unwrap();
        assert_eq!(name, format!("block edge {k}"));
        let curve = all.curve(&name).unwrap().clone();
        let (start, end) = curve.domain();
        let ends = [curve.point(start).unwrap(), curve.point(end).unwrap()];
        assert_eq!(ends, block.ends(k).unwrap().map(|vertex| block.vertices()[vertex]));
        lengths.push((ends[1] - ends[0]).norm());
        let near = Point::from((ends[0].coords + ends[1].coords) / 2.0);
        let out = near + (near - p_middle()) * 0.1;
        let asked = json!({ "object": "block", "edge": { "closest": [out.x, out.y, out.z] }, "name": format!("n{k}") });
        let report = run(&mut all, "edge", asked).unwrap();
        assert!(report.notes[0].starts_with(&format!("edge {k} comes nearest to the point")), "{report:?}");
        assert_eq!(all.curve(&format!("n{k}")).unwrap(), &curve);
    }
    lengths.sort_by(f64::total_cmp);
    assert_eq!(lengths, [[3.0; 4], [4.0; 4], [12.0; 4]].concat());
    // At a corner three edges meet: the first is taken, and it is said.
    let report =
        run(&mut all, "edge", json!({ "object": "block", "edge": { "closest": [0, 0, 0] } })).unwrap();
    assert!(report.notes[0].ends_with("; 2 others are as near"), "{report:?}");
    // Of a surface, too.
    let report =
        run(&mut all, "edge", json!({ "object": "sheet", "edge": { "closest": [3, 1.5, 1] } })).unwrap();
    assert_eq!(report.object.as_deref(), Some("sheet v1"), "{report:?}");
}

fn p_middle() -> Point {
    Point::new(1.5, 2.0, 6.0)
}

/// Several curves at once: the same points as one by one, each with its name; nothing is made where one of them is wrong.
#[test]
fn several_curves_are_sampled_in_one_step() {
    let (mut together, mut alone) = (scene(), scene());
    let names = ["line", "ring", "helix"];
    let report = run(&mut together, "sample", json!({ "objects": names, "count": 7 })).unwrap();
    assert_eq!(report.notes.len(), 3, "{report:?}");
    for (k, name) in names.iter().enumerate() {
        let one = run(&mut alone, "sample", json!({ "object": name, "count": 7 })).unwrap();
        let made = one.object.unwrap();
        assert_eq!(made, format!("{name} points"));
        let points = |scene: &Scene| scene.object(&made).unwrap().geometry().clone();
        assert_eq!(points(&together), points(&alone));
        assert_eq!(report.numbers["length"][k], one.numbers["length"]);
    }
    assert_eq!(together.objects().len(), alone.objects().len());
    // One name for all gets numbers.
    let mut named = scene();
    run(&mut named, "sample", json!({ "objects": names, "count": 2, "name": "p" })).unwrap();
    assert!(
        ["p", "p.001", "p.002"].iter().all(|name| named.get(name).is_some()),
        "{:?}",
        named.objects().iter().map(Object::name).collect::<Vec<_>>()
    );
}

/// A profile on both sides of the axis makes a surface that runs through itself: where is told, and what to do. One that begins, ends or bends in the axis, or
/// passes beside it, is none.
#[test]
fn a_profile_across_the_axis_is_told_where() {
    let p = Point::new;
    let told = |curve: Curve| {
        let mut scene = Scene::new();
        scene.add(Object::new("profile", curve.into())).unwrap();
        let notes = run(&mut scene, "revolve", json!({})).unwrap().notes.join("; ");
        notes.contains("crosses the axis").then_some(notes)
    };
    let ring = told(Curve::circle(p(3.0, 0.0, 0.0), Vector::y(), 5.0).unwrap()).unwrap();
    assert!(ring.contains("0, -4)") && ring.contains("0, 4)") && ring.contains("`split`"), "{ring}");
    let line = told(Curve::line(p(-1.0, 0.0, 5.0), p(2.0, 0.0, 8.0)).unwrap()).unwrap();
    assert!(line.contains(", 6)") && line.contains("move the profile or the axis"), "{line}");
    let arch = |x: f64| vec![p(0.0, 0.0, 0.0), p(x, 0.0, 1.0), p(x, 0.0, 2.0), p(0.0, 0.0, 3.0)];
    for clear in [
        Curve::circle(p(7.0, 0.0, 0.0), Vector::y(), 5.0).unwrap(),
        Curve::bezier(arch(2.0)).unwrap(),
        Curve::bezier(arch(-2.0)).unwrap(),
        Curve::line(p(-1.0, 1.0, 5.0), p(2.0, 1.0, 8.0)).unwrap(),
        Curve::bezier(vec![p(1.0, 0.0, 0.0), p(-1.0, 0.0, 1.0), p(1.0, 0.0, 2.0)]).unwrap(),
    ] {
        let told = told(clear);
        assert!(told.is_none(), "{told:?}");
    }
}

/// Two groups above two curves: turned and scaled, and mirrored and stretched.
fn placed() -> [(Scene, [Matrix4<f64>; 2]); 4] {
    let turned = Matrix4::new_translation(&Vector::new(5.0, -2.0, 1.0))
        * Matrix4::from_axis_angle(&Vector::x_axis(), 1.1)
        * Matrix4::new_scaling(2.5);
    let mirrored = Matrix4::new_nonuniform_scaling(&Vector::new(-1.0, 1.0, 1.0)) * Matrix4::new_scaling(0.5);
    let sheared =
        Matrix4::new(1.0, 0.4, 0.0, 0.0, 0.0, 2.0, -0.3, 1.0, 0.2, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let flat = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 1.0, 0.0));
    [(turned, mirrored), (mirrored, turned), (sheared, mirrored), (flat, sheared)].map(|(first, second)| {
        let mut scene = Scene::new();
        for (group, map) in [("first", first), ("second", second)] {
            let mut object = Object::new(group, Geometry::Group);
            object.transform = Some(map);
            scene.add(object).unwrap();
        }
        // Both also by transforms of their own.
        let nudged = Matrix4::from_axis_angle(&Vector::y_axis(), 0.3);
        (scene, [first * nudged, second * nudged])
    })
}

/// A sweep of curves placed otherwise is the sweep of the curves as they stand, where the profile hangs: whatever places them.
#[test]
fn what_is_placed_is_swept_as_it_stands() {
    let p = Point::new;
    for (mut scene, [first, second]) in placed() {
        let ring = Curve::circle(p(3.0, 0.0, 0.0), Vector::new(0.2, 1.0, 0.0), 1.0).unwrap();
        let path = Curve::bezier((0..5).map(f64::from).map(|t| p(3.0 * t.cos(), 3.0 * t.sin(), t)).collect());
        let path = path.unwrap();
        for (name, curve, group) in [("ring", &ring, "first"), ("path", &path, "second")] {
            let mut object = Object::new(name, curve.clone().into());
            object.transform = Some(Matrix4::from_axis_angle(&Vector::y_axis(), 0.3));
            object.parent = Some(group.to_owned());
            scene.add(object).unwrap();
        }
        // The same without any placement.
        let mut plain = Scene::new();
        for (name, curve, map) in [("ring", &ring, first), ("path", &path, second)] {
            plain.add(Object::new(name, Geometry::from(curve.clone()).transformed(&map).unwrap())).unwrap();
        }
        for frame in ["least", "parallel", "upright"] {
            let fields = json!({ "object": "ring", "path": "path", "frame": frame, "name": frame });
            let [found, wanted] = [&mut scene, &mut plain].map(|s| run(s, "sweep", fields.clone()).unwrap());
            // Rounding apart the same is said of both.
            let numbers = [&found, &wanted].map(|report| report.numbers["tolerance"].as_f64().unwrap());
            assert!((numbers[0] / numbers[1] - 1.0).abs() < 1e-9, "{numbers:?}");
            assert!(found.notes.iter().any(|note| note.contains("placed otherwise")), "{found:?}");
            let standing = scene.standing(frame).unwrap();
            let there = standing.seen(scene.get(frame).unwrap().geometry()).unwrap();
            let points = plain.get(frame).unwrap().geometry().points();
            assert_eq!(there.points().len(), points.len());
            for (a, b) in there.points().iter().zip(points) {
                assert!((a - b).norm() < 1e-12 * (1.0 + b.coords.norm()), "{frame}: {a} {b}");
            }
        }
        let hangs = scene.get("least").unwrap().parent.as_deref();
        let is_flat = first.determinant() == 0.0;
        assert_eq!(hangs, if is_flat { None } else { Some("first") });
    }
}

/// What is placed is told as long as it stands, each way to the next as it is where a transform stretches one axis: of a quarter of a circle the quarter of an ellipse.
#[test]
fn points_of_a_stretched_curve_are_told_as_they_stand() {
    let mut scene = Scene::new();
    let p = Point::new;
    let quarter =
        Curve::arc(p(1.0, 0.0, 0.0), Point::origin(), Vector::z(), std::f64::consts::FRAC_PI_2).unwrap();
    let mut arc = Object::new("arc", quarter.into());
    arc.transform = Some(Matrix4::new_nonuniform_scaling(&Vector::new(2.0, 1.0, 1.0)));
    scene.add(arc).unwrap();
    let report = run(&mut scene, "sample", json!({ "object": "arc", "count": 3 })).unwrap();
    let (whole, longest) =
        (report.numbers["length"].as_f64().unwrap(), report.numbers["spacing"].as_f64().unwrap());
    // A quarter of the ellipse of the half axes 2 and 1, by Simpson's rule over the angle: the rule is exact to rounding on so many places.
    let length = |from: f64, to: f64| {
        let speed = |t: f64| (2.0 * t.sin()).hypot(t.cos());
        let step = (to - from) / 2000.0;
        let weight = |k: i32| {
            if k == 0 || k == 2000 {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=2000).map(|k| weight(k) * speed(from + step * f64::from(k))).sum::<f64>() * step / 3.0
    };
    let half = std::f64::consts::FRAC_PI_4;
    assert!((whole - length(0.0, 2.0 * half)).abs() < 1e-10, "{whole}");
    assert!((longest - length(half, 2.0 * half)).abs() < 1e-10, "{longest}");
    assert!(report.notes.iter().any(|n| n.contains(" m to ")), "{report:?}");
    assert!(report.notes.iter().any(|n| n.contains("count is in its own coordinates")), "{report:?}");
    // Tolerances and deviations of an offset.
    let offset =
        run(&mut scene, "offset", json!({ "object": "arc", "distance": 0.25, "tolerance": 1e-5 })).unwrap();
    assert_eq!(offset.numbers["tolerance"].as_f64(), Some(2e-5));
}

/// A surface of which a ring is left: a square in its parameters with a round hole in the middle, and a line of constant v at its lower side.
fn trimmed(surface: Surface) -> Geometry {
    let flat = |x: f64, y: f64| Point::new(x, y, 0.0);
    let corners = [flat(0.1, 0.1), flat(0.9, 0.1), flat(0.9, 0.9), flat(0.1, 0.9)];
    let line =
        |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 4]).unwrap()).unwrap();
    let hole = Curve::circle(flat(0.5, 0.5), Vector::z(), 0.2).unwrap();
    let region =
        Region { outer: (0..4).map(line).collect(), holes: vec![vec![ParameterCurve::whole(hole).unwrap()]] };
    Trimmed::new(surface, vec![region], Vec::new(), Vec::new()).unwrap().into()
}

/// Of a plane the border is exact: lines, and a circle. Which piece is meant a point says, or its number.
#[test]
fn the_border_of_a_trimmed_plane_is_exact() {
    let mut all = scene();
    let space = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let corners = [[0.0, 0.0], [0.0, 5.0], [5.0, 0.0], [5.0, 5.0]].map(|[x, y]| Point::new(x, y, 2.0));
    let plane = Surface::new(space.clone(), space, corners.to_vec()).unwrap();
    all.add(Object::new("plate", trimmed(plane))).unwrap();
    let report =
        run(&mut all, "edge", json!({ "object": "plate", "edge": { "closest": [2.5, 3.4, 2] } })).unwrap();
    assert_eq!(report.notes[0], "border 4 comes nearest to the point: 0.1 m away", "{report:?}");
    assert!(report.notes.contains(&"exact".to_owned()) && report.numbers["border"] == 4, "{report:?}");
    let hole = all.curve("plate border 4").unwrap();
    assert!((hole.length(1e-12).unwrap().value - std::f64::consts::TAU).abs() < 1e-11);
    let (a, b) = hole.domain();
    for k in 0..=100 {
        let p = hole.point(a + (b - a) * f64::from(k) / 100.0).unwrap();
        assert!(((p - Point::new(2.5, 2.5, 2.0)).norm() - 1.0).abs() < 1e-14);
    }
    run(&mut all, "edge", json!({ "object": "plate", "edge": "border 0", "name": "side" })).unwrap();
    let side = all.curve("side").unwrap();
    assert_eq!((side.degree(), side.points().len()), (1, 2));
    assert!((side.length(1e-12).unwrap().value - 4.0).abs() < 1e-14);
    // The surface that carries it still has its edges.
    let report = run(&mut all, "edge", json!({ "object": "plate", "edge": "u0" })).unwrap();
    assert!(report.notes.iter().any(|note| note.contains("of which its loops leave nothing")), "{report:?}");
    for (fields, says) in [
        (json!({ "object": "plate", "edge": "border 5" }), "\"border 0\" to \"border 4\""),
        (json!({ "object": "plate", "edge": "border 0", "tolerance": 0 }), "tolerance: 0 is no length"),
        (json!({ "object": "block", "edge": "edge 1", "tolerance": 0.1 }), "tolerance: an edge is exact"),
    ] {
        let error = run(&mut all, "edge", fields).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    let error = run(&mut all, "isocurve", json!({ "object": "plate", "u": 0.5 })).unwrap_err();
    assert!(error.contains("trimmed surface") && error.contains("`untrim`"), "{error}");
}

/// On a cylinder lines along its parameters are exact, and a circle in its parameters is within the tolerance, which is told with how far off it is.
#[test]
fn the_border_of_a_trimmed_cylinder_is_within_its_tolerance() {
    let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, 3.0)).unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), 1.0).unwrap();
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let mut all = scene();
        all.add(Object::new("tube", trimmed(tube.clone()))).unwrap();
        let fields = json!({ "object": "tube", "edge": "border 4", "tolerance": tolerance });
        let report = run(&mut all, "edge", fields).unwrap();
        let told = report.numbers["deviation"].as_f64().unwrap();
        assert!(told > 0.0 && told <= tolerance, "{told}");
        let hole = all.curve("tube border 4").unwrap();
        let flat = Curve::circle(Point::new(0.5, 0.5, 0.0), Vector::z(), 0.2).unwrap();
        let (a, b) = hole.domain();
        for k in 0..=1000 {
            let at = a + (b - a) * f64::from(k) / 1000.0;
            let p = flat.point(at).unwrap();
            let off = (hole.point(at).unwrap() - tube.point(p.x, p.y).unwrap()).norm();
            assert!(off <= 1.1 * told + 1e-15, "{off} {told}");
        }
        let report = run(&mut all, "edge", json!({ "object": "tube", "edge": "border 0" })).unwrap();
        assert!(report.notes.contains(&"exact".to_owned()), "{report:?}");
        // An arc of radius 2 between its ends.
        let level = all.curve("tube border 0").unwrap();
        let [from, to] = [0.1, 0.9].map(|u| tube.point(u, 0.1).unwrap());
        let turn = to.y.atan2(to.x) - from.y.atan2(from.x);
        assert!((level.length(1e-12).unwrap().value - 2.0 * turn).abs() < 1e-11);
    }
}

#[test]
fn a_name_with_a_star_is_all_that_begin_so() {
    let mut all = scene();
    for k in 0..300_u16 {
        let start = Point::new(0.0, f64::from(k), 0.0);
        let hair = Curve::line(start, start + Vector::x() * (1.0 + f64::from(k) / 300.0)).unwrap();
        all.add(Object::new(format!("hair{k:03}"), hair.into())).unwrap();
    }
    all.add(Object::new("hairpin", Cloud { points: vec![Point::origin()] }.into())).unwrap();
    let report = run(&mut all, "sample", json!({ "objects": ["hair007", "hair*"], "count": 5 })).unwrap();
    assert_eq!(report.object.as_deref(), Some("hair007 points"));
    assert_eq!(report.numbers["length"].as_array().unwrap().len(), 300);
    assert!(all.get("hair299 points").is_some() && all.get("hairpin points").is_none());
    assert!(report.notes.len() < 12, "{report:?}");
    assert_eq!(
        report.notes.last().unwrap(),
        "and 292 more, 0.2567 m to 0.4992 m from each to the next along them"
    );
    for (name, says) in
        [("wool*", "no object's name begins with \"wool\""), ("hairp*", "\"hairpin\" is a cloud")]
    {
        let error = run(&mut all, "sample", json!({ "objects": [name], "count": 5 })).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
}

/// A profile that is turned so that its faces look inwards is told, with what to do.
#[test]
fn what_is_revolved_inside_out_is_told() {
    let inwards = |report: &StepReport| report.notes.iter().any(|note| note.contains("`reverse`"));
    for (normal, degrees, told) in
        [(1.0, 360.0, true), (-1.0, 360.0, false), (1.0, -360.0, false), (1.0, 90.0, false)]
    {
        let mut all = Scene::new();
        let ring = Curve::circle(Point::new(10.0, 0.0, 0.0), Vector::y() * normal, 3.0).unwrap();
        all.add(Object::new("ring", ring.into())).unwrap();
        let report = run(&mut all, "revolve", json!({ "object": "ring", "degrees": degrees })).unwrap();
        assert_eq!(inwards(&report), told, "{normal} {degrees}: {report:?}");
    }
}
