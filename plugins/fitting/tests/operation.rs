//! The operation `fit` in recipes.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fitting::Fitting;
use loftsman_kernel::Point;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use serde_json::{Value, json};

fn scene() -> Scene {
    let points: Vec<Point> = (0..80)
        .map(|i| std::f64::consts::TAU * f64::from(i) / 80.0)
        .map(|a| Point::new(3.0 * a.cos(), 2.0 * a.sin(), 0.0))
        .collect();
    let mesh = Mesh::new(points[..4].to_vec(), &[[0, 1, 2, 3]]).unwrap();
    let mut scene = Scene::new();
    let ring = Polyline { points: points.clone(), closed: true };
    scene.add(Object::new("ring", Geometry::Polyline(ring))).unwrap();
    scene.add(Object::new("scan", Geometry::Cloud(Cloud { points }))).unwrap();
    scene.add(Object::new("panel", Geometry::Mesh(mesh))).unwrap();
    scene.add(Object::new("group", Geometry::Group)).unwrap();
    scene
}

fn run(scene: &mut Scene, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Fitting);
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let operation = registry.find_operation("fit", "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn fails(fields: Value) -> String {
    let mut scene = scene();
    let error = run(&mut scene, fields).unwrap_err().to_string();
    assert_eq!(scene, self::scene(), "a failed step leaves the scene alone");
    error
}

#[test]
fn a_closed_polyline_becomes_a_periodic_curve() {
    let mut scene = scene();
    let report = run(&mut scene, json!({ "object": "ring", "tolerance": 1e-3 })).unwrap();
    let curve = scene.curve("ring").unwrap();
    assert!(curve.is_periodic() && curve.degree() == 3 && curve.points().len() < 20);
    assert_eq!(report.op, "fit");
    assert!(report.notes[0].starts_with("largest distance from the points 0.000"), "{:?}", report.notes);
    // Lengths have the scene's unit; errors that are rounding are none.
    let unit = scene.unit.symbol();
    assert_eq!(report.notes[1], format!("the tolerance 0.001 {unit} is met"));
    for (note, count) in [(0, 2), (2, 2)] {
        let words = report.notes[note].split([' ', ',', ';']);
        assert_eq!(words.filter(|word| *word == unit).count(), count, "{:?}", report.notes);
    }
    assert!(report.iterations.unwrap() > 1 && report.condition.unwrap() >= 1.0);
}

#[test]
fn a_cloud_becomes_an_open_curve_with_constraints() {
    let mut scene = scene();
    let fields = json!({
        "object": "scan", "degree": 4, "vertices": 12,
        "constraints": [
            { "kind": "position", "at": 0.5, "to": [-3.1, 0.0, 0.2] },
            { "kind": "tangent", "at": 0.0, "direction": [0, 1, 0] },
            { "kind": "orthogonal", "at": 0.25, "to": [0, 1, 0], "object": "scan" },
        ],
    });
    let report = run(&mut scene, fields).unwrap();
    let curve = scene.curve("scan").unwrap();
    assert_eq!(curve.points().len(), 12);
    assert!((curve.point(0.5).unwrap() - Point::new(-3.1, 0.0, 0.2)).norm() < 1e-13);
    assert!(curve.derivative(0.0, 1).unwrap().x.abs() < 1e-11);
    assert!(curve.derivative(0.25, 1).unwrap().y.abs() < 1e-11);
    assert_eq!(report.constraints.len(), 5);
    assert!(report.residual.unwrap() < 1e-11);
}

#[test]
fn interpolation_and_meshes() {
    let mut scene = scene();
    let fields =
        json!({ "object": "scan", "interpolate": true, "ends": "natural", "parameters": "centripetal" });
    let report = run(&mut scene, fields).unwrap();
    assert!(report.residual.unwrap() < 1e-14);
    assert_eq!(scene.curve("scan").unwrap().points().len(), 82);
    run(&mut scene, json!({ "object": "panel" })).unwrap();
    assert_eq!(scene.curve("panel").unwrap().points().len(), 4);
    let given: Vec<f64> = (0..=80).map(f64::from).collect();
    run(&mut scene, json!({ "object": "ring", "interpolate": true, "parameters": given })).unwrap();
    assert_eq!(scene.curve("ring").unwrap().domain(), (0.0, 80.0));
}

#[test]
fn a_corner_at_the_seam_is_told_and_can_be_kept() {
    let drop: Vec<Point> = (0..60)
        .map(|i| std::f64::consts::TAU * f64::from(i) / 60.0)
        .map(|a| Point::new(a.cos(), a.sin() * (0.5 * a).sin().powi(2), 0.0))
        .collect();
    let mut scene = Scene::new();
    scene.add(Object::new("drop", Geometry::Polyline(Polyline { points: drop, closed: true }))).unwrap();
    let mut other = scene.clone();
    let smooth = run(&mut other, json!({ "object": "drop", "relative_tolerance": 1e-2 })).unwrap();
    assert!(smooth.notes.iter().any(|n| n.contains("at point 0") && n.contains("closed = false")));
    let kept = run(&mut scene, json!({ "object": "drop", "closed": false })).unwrap();
    assert!(kept.notes.iter().all(|n| !n.contains("turn by")), "{:?}", kept.notes);
    let curve = scene.curve("drop").unwrap();
    assert!(!curve.is_periodic() && curve.point(0.0).unwrap() == curve.point(1.0).unwrap());
    assert!(curve.points().len() < 25, "{}", curve.points().len());
}

#[test]
fn corners_are_asked_for_in_degrees_or_found() {
    let star: Vec<Point> = (0..10)
        .map(|i| (std::f64::consts::TAU * f64::from(i) / 10.0, if i % 2 == 0 { 40.0 } else { 16.0 }))
        .map(|(a, r)| Point::new(r * a.cos(), r * a.sin(), 0.0))
        .collect();
    let mut scene = Scene::new();
    scene.add(Object::new("star", Geometry::Polyline(Polyline { points: star, closed: true }))).unwrap();
    for corners in [json!("auto"), json!(40.0)] {
        let mut scene = scene.clone();
        let report =
            run(&mut scene, json!({ "object": "star", "tolerance": 0.1, "corners": corners })).unwrap();
        assert!(
            report.notes.iter().any(|n| n.starts_with("10 corners, at points 0, 1, 2")),
            "{:?}",
            report.notes
        );
        assert_eq!(scene.curve("star").unwrap().points().len(), 30);
    }
    // Where every point is interpolated corners cannot be kept: what is advised can be done.
    let hook =
        (0..11).map(|k: i32| Point::new(f64::from(k.min(5)), f64::from((k - 5).max(0)), 0.0)).collect();
    let mut other = Scene::new();
    other.add(Object::new("hook", Geometry::Polyline(Polyline { points: hook, closed: false }))).unwrap();
    let through = run(&mut other, json!({ "object": "hook", "interpolate": true })).unwrap();
    let told = through.notes.iter().find(|n| n.contains("overshoot")).unwrap();
    assert!(told.contains("a `fit` without `interpolate` keeps such corners"), "{told}");
    // Degree 1 through all points is the star itself: nothing is rounded, nothing is said; with fewer vertices it is no longer.
    let mut sharp = scene.clone();
    let told = run(&mut sharp, json!({ "object": "star", "degree": 1, "interpolate": true })).unwrap();
    let length =
        20.0 * (40.0_f64.powi(2) + 16.0_f64.powi(2) - 1280.0 * 36_f64.to_radians().cos()).sqrt() / 2.0;
    assert!((sharp.curve("star").unwrap().length(1e-12).unwrap().value / length - 1.0).abs() < 1e-12);
    assert!(!told.notes.iter().any(|n| n.contains("turn by")), "{:?}", told.notes);
    let told = run(&mut scene.clone(), json!({ "object": "star", "degree": 1, "vertices": 7 })).unwrap();
    let told = told.notes.iter().find(|n| n.contains("turn by")).unwrap();
    assert!(told.contains("which a curve of degree 1 keeps only where it has a vertex there"), "{told}");
    let smooth = run(&mut scene, json!({ "object": "star", "tolerance": 0.1 })).unwrap();
    assert!(smooth.notes.iter().any(|n| n.contains("corners = \"auto\"")), "{:?}", smooth.notes);
    assert!(smooth.notes.iter().any(|n| n.starts_with("length ")), "{:?}", smooth.notes);
}

#[test]
fn what_is_wrong_is_said() {
    for (fields, words) in [
        (json!({ "object": "rign" }), "did you mean \"ring\"?"),
        (json!({ "object": "group" }), "\"group\" is a group"),
        (json!({ "object": "ring", "tolerence": 1.0 }), "did you mean \"tolerance\"?"),
        (json!({ "object": "ring", "tolerance": -1.0 }), "give a positive length"),
        (json!({ "object": "ring", "tolerance": 1.0, "relative_tolerance": 1.0 }), "give one of them"),
        (json!({ "object": "ring", "degree": 1_000_000_000 }), "degree: is from 1 to 25"),
        (json!({ "object": "ring", "vertices": 1_000_000 }), "cannot be fitted: choose from 3"),
        (json!({ "object": "ring", "tolerance": 1e-12, "vertices": 5 }), "is not met"),
        (json!({ "object": "ring", "parameters": "cord" }), "did you mean \"chord\"?"),
        (json!({ "object": "ring", "interpolate": true, "tolerance": 1.0 }), "no meaning"),
        (json!({ "object": "ring", "corners": 200 }), "between 0 and 180"),
        (json!({ "object": "ring", "corners": "atuo" }), "did you mean \"auto\"?"),
        (json!({ "object": "ring", "weights": [1.0] }), "one positive, finite weight a point"),
        (
            json!({ "object": "ring", "constraints": [{ "kind": "position", "at": 0.5, "keep": true }] }),
            "step[0].constraints[0].keep",
        ),
        (
            json!({ "object": "ring", "constraints": [{ "kind": "positoin", "at": 0.5 }] }),
            "did you mean \"position\"?",
        ),
        (json!({ "object": "ring", "constraints": [{ "kind": "position", "at": 0.5 }] }), "`to`"),
        (
            json!({ "object": "ring", "constraints": [{ "kind": "position", "at": 0.5, "object": "scan", "to": [0, 0, 0] }] }),
            "on \"ring\" only",
        ),
    ] {
        let message = fails(fields.clone());
        assert!(message.contains(words), "{fields}\n{message}");
    }
}

/// The only polyline need not be named, whatever else there is; of a mesh of lines that are no one chain no curve is made through all.
#[test]
fn one_chain_is_fitted() {
    let at = |k: usize| Point::new(0.3 * k as f64, (0.3 * k as f64).sin(), 0.0);
    let mut scene = Scene::new();
    let lines = |chains: &[&[u32]]| {
        let mut mesh = Mesh::new::<[usize; 3]>((0..8).map(at).collect(), &[]).unwrap();
        let mut starts = vec![0];
        starts.extend(chains.iter().scan(0, |sum, chain| {
            *sum += chain.len();
            Some(*sum)
        }));
        mesh.set_lines(chains.concat(), starts).unwrap();
        mesh
    };
    scene.add(Object::new("two", lines(&[&[0, 1, 2, 3], &[4, 5, 6, 7]]).into())).unwrap();
    let told = run(&mut scene, json!({})).unwrap_err().to_string();
    assert!(told.contains("\"two\" is a mesh of 2 separate lines") && told.contains("OBJ"), "{told}");
    scene.add(Object::new("star", lines(&[&[0, 1, 2], &[1, 3, 4, 5, 6, 7]]).into())).unwrap();
    let told = run(&mut scene, json!({ "object": "star" })).unwrap_err().to_string();
    assert!(told.contains("lines that branch"), "{told}");
    // In parts that hang together it is one.
    let pairs: Vec<[u32; 2]> = (0..7).map(|k| [k, k + 1]).collect();
    let pairs: Vec<&[u32]> = pairs.iter().map(|pair| &pair[..]).collect();
    scene.add(Object::new("one", lines(&pairs).into())).unwrap();
    run(&mut scene, json!({ "object": "one" })).unwrap();
    assert!(scene.curve("one").is_ok());
    let line = Polyline { points: (0..30).map(at).collect(), closed: false };
    scene.add(Object::new("wave", line.into())).unwrap();
    assert_eq!(run(&mut scene, json!({})).unwrap().object.as_deref(), Some("wave"));
    assert!(scene.curve("wave").is_ok());
}

/// Points at which the distance at the parameter is largest at another point than that from the nearest point of the curve.
const APART: [[f64; 3]; 32] = [
    [87543970.4520976, -694294299.405775, 0.0],
    [188683712.4236251, -718928643.9199872, 0.0],
    [191848183.80150768, -719426337.1919053, 0.0],
    [191848183.80150768, -719426337.1919053, 0.0],
    [411008818.7006532, -686643733.2301083, 0.0],
    [530951098.19416475, -585693487.8069319, 0.0],
    [576667907.6762956, -528312845.2594561, 0.0],
    [680610286.1512443, -372181996.4657579, 0.0],
    [767521671.1528128, -241147642.94628337, 0.0],
    [817256631.9782513, -172307351.7956602, 0.0],
    [894672572.5261786, 202223972.548401, 0.0],
    [858947365.8695422, 246232583.68410882, 0.0],
    [791272491.2510523, 303846522.69501513, 0.0],
    [188451880.18899262, 564663811.7261119, 0.0],
    [121118181.89340083, 578930992.9745829, 0.0],
    [-295475136.8831116, 578521062.4807868, 0.0],
    [-438313475.6911559, 531172778.0876139, 0.0],
    [-519914395.6169332, 485108785.8003528, 0.0],
    [-549147327.6436478, 463794004.3303002, 0.0],
    [-572252740.6312244, 444664897.7654167, 0.0],
    [-659103420.6508267, 347194227.0195805, 0.0],
    [-734518290.9152473, 199365771.1403659, 0.0],
    [-750919763.4517062, 156250644.3630813, 0.0],
    [-754308854.8079842, 147583006.31119937, 0.0],
    [-875648002.4860251, -20080430.960898854, 0.0],
    [-917433892.4000988, -68179740.54423702, 0.0],
    [-918284080.0112332, -69340220.70192748, 0.0],
    [-907858000.5943118, -301683562.19085157, 0.0],
    [-889253894.0282899, -321049523.0831446, 0.0],
    [-748835900.4617512, -409873022.1191756, 0.0],
    [-712234605.1987062, -425196987.57817256, 0.0],
    [-79682926.0282978, -632600198.6972169, 0.0],
];

/// A report tells one largest distance: that from the nearest point of the curve, at the point that has it; the distances at the parameters, which steer the
/// search, are larger, and another point's here.
#[test]
fn one_largest_distance_is_told() {
    let points: Vec<Point> = APART.map(Point::from).to_vec();
    let mut scene = Scene::new();
    let line = Polyline { points: points.clone(), closed: false };
    scene.add(Object::new("wave", line.into())).unwrap();
    let tolerance = 181_023.536_086_331_82;
    let report = run(&mut scene, json!({ "degree": 2, "tolerance": tolerance })).unwrap();
    let curve = scene.curve("wave").unwrap();
    let distances: Vec<f64> = points.iter().map(|&p| curve.closest(p).unwrap().distance).collect();
    let at = (0..points.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b])).unwrap();
    let told = scene.unit.quantity(distances[at], 1);
    let expected = format!("largest distance from the points {told}, at point {at} (");
    assert!(report.notes[0].starts_with(&expected), "{expected}: {:?}", report.notes);
    assert!(!report.notes.iter().any(|note| note.contains("away")), "{:?}", report.notes);
    let fitted = loftsman_fitting::Fit::new(2, loftsman_fitting::Target::Tolerance(tolerance));
    let fitted = fitted.curve(&points).unwrap();
    assert!(fitted.farthest == at && fitted.distance == distances[at], "{fitted:?}");
    assert!(fitted.worst != at && fitted.max_error > 2.0 * fitted.distance, "{fitted:?}");
}

/// Degree 5 and 7 through noise swings between the points: the refusal names a degree, and that one follows them.
#[test]
fn what_a_refused_interpolation_advises_works() {
    let (mut refused, mut named) = (0, 0);
    for seed in 0..40 {
        let mut r = crate::common::families::Random::new(seed);
        let many = r.whole(12, 70);
        let mut places: Vec<f64> = (0..many).map(|_| r.unit()).collect();
        places.sort_by(f64::total_cmp);
        let points: Vec<Point> = places
            .iter()
            .map(|t| Point::new(2.0 * t, (5.0 * t).sin(), 0.0))
            .map(|p| p + loftsman_kernel::Vector::new(r.normal(), r.normal(), r.normal()) * 0.02)
            .collect();
        let degree = if seed % 2 == 0 { 5 } else { 7 };
        let through = |degree: u64| {
            let mut scene = Scene::new();
            let line = Polyline { points: points.clone(), closed: false };
            scene.add(Object::new("line", Geometry::Polyline(line))).unwrap();
            run(&mut scene, json!({ "interpolate": true, "degree": degree }))
        };
        let Err(error) = through(degree) else { continue };
        refused += 1;
        let text = error.to_string();
        let after = text.split("degree = ").nth(1).and_then(|rest| rest.split(' ').next());
        if let Some(lower) = after.and_then(|word| word.parse().ok()) {
            named += 1;
            assert!(lower < degree, "{text}");
            through(lower).unwrap();
        }
    }
    println!("{refused} of 40 refused, {named} of them with a degree that follows");
    assert!(refused >= 3 && named == refused, "{refused} {named}");
}

/// A hexagon turns by 60° and not by more: with points on its sides it has no corners by "auto", which is told with what to do; one without turns all round.
#[test]
fn a_corner_that_is_rounded_though_corners_were_asked_for_is_told() {
    let hexagon = |each: usize| -> Scene {
        let corner = |i: usize| {
            let a = std::f64::consts::TAU * i as f64 / 6.0;
            Point::new(a.cos(), a.sin(), 0.0)
        };
        let at = |k: usize| {
            let t = (k % each) as f64 / each as f64;
            corner(k / each) + (corner(k / each + 1) - corner(k / each)) * t
        };
        let points = (0..6 * each).map(at).collect();
        let mut scene = Scene::new();
        let line = Polyline { points, closed: true };
        scene.add(Object::new("ring", Geometry::Polyline(line))).unwrap();
        scene
    };
    let fields = json!({ "tolerance": 1e-4, "corners": 61 });
    let told = |scene: &mut Scene, fields: Value| {
        let notes = run(scene, fields).unwrap().notes;
        notes.into_iter().find(|note| note.contains("between straight sides"))
    };
    let note = told(&mut hexagon(4), fields.clone()).unwrap();
    assert!(note.contains("turn by 60° at point") && note.contains("corners = 59 keeps"), "{note}");
    assert_eq!(told(&mut hexagon(4), json!({ "tolerance": 1e-4, "corners": 59 })), None);
    assert_eq!(told(&mut hexagon(1), fields), None, "as far as anybody can tell it is a circle");
}
