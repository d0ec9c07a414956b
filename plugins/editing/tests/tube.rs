//! Tubes round curves of every family: where their points are, which way they face, that they close, and what they do in time.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use loftsman_editing::Editing;
use loftsman_kernel::mesh::{Mesh, Polyline};
use loftsman_kernel::plugin::{
    Cancelled, Context, NoClock, Observer, OperationError, Parameters, Registry, StepReport,
};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Tessellation;
use serde_json::{Value, json};

fn registry() -> Registry {
    let mut registry = Registry::new();
    registry.add(&Editing);
    registry.add(&Tessellation);
    registry
}

fn scene(geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("rope", geometry.into())).unwrap();
    scene
}

fn run(scene: &mut Scene, parameters: Value) -> Result<StepReport, OperationError> {
    let registry = registry();
    let operation = registry.find_operation("tube", "step[0].op")?.clone();
    let parameters = Parameters::new(parameters, "step[0]")?;
    parameters.check(operation.declaration().fields)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn mesh(scene: &Scene, name: &str) -> Mesh {
    match scene.object(name).unwrap().geometry() {
        Geometry::Mesh(mesh) => mesh.clone(),
        other => panic!("{}", other.kind()),
    }
}

/// The tube of a geometry.
fn tube(geometry: impl Into<Geometry>, parameters: Value) -> (Mesh, StepReport) {
    let mut scene = scene(geometry);
    let report = run(&mut scene, parameters).unwrap();
    (mesh(&scene, "rope tube"), report)
}

/// A gently winding curve in a space, of a size.
fn winding(space: Space, weights: bool, size: f64) -> Curve {
    let count = space.len();
    let points = (0..count)
        .map(|k| {
            let a = if space.is_periodic() { TAU * k as f64 / count as f64 } else { 0.5 * k as f64 };
            let lift = if space.is_periodic() { (2.0 * a).sin() } else { a };
            Point::new(5.0 * a.cos(), 5.0 * a.sin(), 0.4 * lift) * size
        })
        .collect();
    let weights = weights.then(|| (0..count).map(|k| 1.0 + 0.15 * (k as f64).sin()).collect());
    Curve::build(space, points, weights).unwrap()
}

/// Spaces of every family, of smooth curves.
fn spaces() -> Vec<Space> {
    let mut all = Vec::new();
    for degree in (2..=7).chain([25]) {
        all.push(Space::clamped_uniform(degree, degree + 6).unwrap());
        all.push(Space::floating_uniform(degree, degree + 6).unwrap());
        all.push(Space::periodic_uniform(degree, degree.max(7) + 6).unwrap());
    }
    all.push(Space::clamped(3, &[0.0, 1.0, 1.0, 1.3, 4.0]).unwrap());
    all
}

/// How often each directed edge is used, and whether its other way is used once, too.
fn open_edges(mesh: &Mesh) -> usize {
    let mut uses: HashMap<(u32, u32), usize> = HashMap::new();
    for face in mesh.faces() {
        for k in 0..face.len() {
            *uses.entry((face[k], face[(k + 1) % face.len()])).or_default() += 1;
        }
    }
    assert!(uses.values().all(|&n| n == 1), "an edge is used twice the same way");
    uses.keys().filter(|(a, b)| !uses.contains_key(&(*b, *a))).count()
}

fn volume(mesh: &Mesh) -> f64 {
    let points = mesh.points();
    let origin = points[0];
    let at = |i: u32| points[i as usize] - origin;
    let fan = |face: &[u32]| -> f64 {
        (1..face.len() - 1).map(|k| at(face[0]).dot(&at(face[k]).cross(&at(face[k + 1]))) / 6.0).sum()
    };
    mesh.faces().map(fan).sum()
}

/// Normals have length 1 and look the way their faces do, texture coordinates are within the unit square.
fn well_dressed(mesh: &Mesh, most_degrees: f64) {
    mesh.check().unwrap();
    for (face, corners) in mesh.faces().enumerate() {
        let normal = mesh.face_normal(face).unwrap_or_else(|| panic!("face {face} has no area"));
        for (k, &point) in corners.iter().enumerate() {
            let corner = mesh.starts()[face] + k;
            let own = mesh.normals.at(corner, point).unwrap();
            assert!((own.norm() - 1.0).abs() < 1e-9);
            let apart = own.angle(&normal).to_degrees();
            assert!(apart < most_degrees, "face {face}: {apart} degrees");
            let uv = mesh.uvs.at(corner, point).unwrap();
            assert!(uv.iter().all(|c| (-1e-12..=1.0 + 1e-12).contains(c)), "{uv:?}");
        }
    }
}

/// The distance of a point from a curve, by many samples and their chords.
fn distance(samples: &[Point], p: &Point) -> f64 {
    let from = |pair: &[Point]| {
        let (way, arm) = (pair[1] - pair[0], p - pair[0]);
        let t = (way.dot(&arm) / way.norm_squared()).clamp(0.0, 1.0);
        (arm - way * t).norm()
    };
    samples.windows(2).map(from).fold(f64::INFINITY, f64::min)
}

fn samples(curve: &Curve, count: usize) -> Vec<Point> {
    let (a, b) = curve.domain();
    (0..=count).map(|k| curve.point(a + (b - a) * k as f64 / count as f64).unwrap()).collect()
}

#[test]
fn points_are_a_radius_away_and_faces_as_near_as_asked() {
    let mut cases = 0;
    for space in spaces() {
        for weights in [false, true] {
            for size in [1e-9, 1.0, 1e9] {
                let curve = winding(space.clone(), weights, size);
                let (radius, tolerance) = (0.2 * size, 0.004 * size);
                let asked = json!({ "radius": radius, "tolerance": tolerance, "caps": "none" });
                let (mesh, report) = tube(&curve, asked);
                assert!(!report.notes.iter().any(|n| n.contains("overlaps")), "{:?}", report.notes);
                // At the ends of a clamped curve of high degree samples are far apart.
                let line = samples(&curve, if space.degree() > 7 { 20_000 } else { 4000 });
                for p in mesh.points().iter().step_by(7) {
                    let off = (distance(&line, p) - radius).abs();
                    assert!(off < 1e-4 * radius, "{off:e} at size {size}: {:?} {weights}", curve.space());
                }
                // The middles of faces and edges are where a mesh is furthest from what it stands for.
                for (face, corners) in mesh.faces().enumerate().step_by(5) {
                    let sum: Vector = corners.iter().map(|&c| mesh.points()[c as usize].coords).sum();
                    let middle = Point::from(sum / corners.len() as f64);
                    let off = (distance(&line, &middle) - radius).abs();
                    assert!(off < tolerance, "face {face}: {off:e} of {tolerance:e}");
                }
                well_dressed(&mesh, 16.0);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, spaces().len() * 6);
}

#[test]
fn caps_close_what_is_open() {
    for space in spaces() {
        let closed = space.is_periodic();
        let curve = winding(space, false, 1.0);
        let line = samples(&curve, 4000);
        let length: f64 = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let radius = 0.2;
        let body = PI * radius * radius * length;
        for (caps, open, ends) in
            [("none", true, 0.0), ("flat", false, 0.0), ("round", false, 4.0 / 3.0 * PI * radius.powi(3))]
        {
            let (mesh, _) = tube(&curve, json!({ "radius": radius, "tolerance": 1e-3, "caps": caps }));
            assert_eq!(open_edges(&mesh) > 0, open && !closed, "{caps}");
            if !open {
                let expected = body + if closed { 0.0 } else { ends };
                let found = volume(&mesh);
                assert!((found / expected - 1.0).abs() < 0.012, "{caps}: {found} against {expected}");
            }
            well_dressed(&mesh, 16.0);
        }
    }
}

#[test]
fn normals_are_those_of_the_torus() {
    // The rational circle of radius 3 by four quarters.
    let half = 0.5_f64.sqrt();
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points =
        corners.iter().map(|&(x, y)| Point::new(3.0 * f64::from(x), 3.0 * f64::from(y), 0.0)).collect();
    let weights = (0..9).map(|k| if k % 2 == 0 { 1.0 } else { half }).collect();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let circle = Curve::rational(Space::open(2, knots).unwrap(), points, weights).unwrap();
    let (mesh, _) = tube(&circle, json!({ "radius": 1.0, "sides": 12, "tolerance": 0.01 }));
    assert_eq!(open_edges(&mesh), 0, "it closes without caps");
    for (corner, &point) in mesh.corners().iter().enumerate() {
        let p = mesh.points()[point as usize];
        let middle = Vector::new(p.x, p.y, 0.0).normalize() * 3.0;
        let exact = p.coords - middle;
        assert!((exact.norm() - 1.0).abs() < 1e-12);
        let own = mesh.normals.at(corner, point).unwrap();
        assert!((own - exact).norm() < 1e-12, "{own} against {exact}");
    }
    // Twelve sides by arc length: v is the angle.
    let [u, v] = [0, 1].map(|c| mesh.uvs.values().iter().map(|uv| uv[c]).fold(0.0, f64::max));
    assert_eq!((u, v), (1.0, 1.0));
    let rows = mesh.points().len() / 12;
    assert_eq!((mesh.face_count(), mesh.points().len() % 12), (12 * rows, 0));
}

#[test]
fn corners_are_mitred() {
    // A square frame: the tubes of its sides meet in the planes half way, so that its volume is exact.
    let square = [(0, 0), (4, 0), (4, 4), (0, 4)].map(|(x, y)| Point::new(f64::from(x), f64::from(y), 0.0));
    let line = Polyline { points: square.to_vec(), closed: true };
    let (mesh, report) = tube(line, json!({ "radius": 0.5, "sides": 16 }));
    let area = 8.0 * 0.25 * (TAU / 16.0).sin();
    assert!((volume(&mesh) - 16.0 * area).abs() < 1e-12, "{}", volume(&mesh));
    assert_eq!(open_edges(&mesh), 0);
    well_dressed(&mesh, 12.0);
    assert_eq!(report.notes.len(), 1, "{:?}", report.notes);
    // Of degree 1 the same.
    let points = [0, 1, 2, 3, 0].map(|i| square[i]).to_vec();
    let curve = Curve::new(Space::clamped_uniform(1, 5).unwrap(), points).unwrap();
    let (other, _) = tube(&curve, json!({ "radius": 0.5, "sides": 16 }));
    assert!((volume(&other) - 16.0 * area).abs() < 1e-12);
    // A radius that the sides leave no room for is said: half a side over the tangent of half a right angle.
    let line = Polyline { points: square.to_vec(), closed: true };
    let (_, report) = tube(line, json!({ "radius": 2.5, "sides": 16 }));
    assert!(
        report.notes.iter().any(|n| n.contains("overlaps") && n.contains("curvature is 2")),
        "{:?}",
        report.notes
    );
}

#[test]
fn too_wide_is_said_with_the_least_radius() {
    let parabola = Curve::bezier(vec![
        Point::new(-1.0, 1.0, 0.0),
        Point::new(0.0, -1.0, 0.0),
        Point::new(1.0, 1.0, 0.0),
    ]);
    let parabola = parabola.unwrap();
    let (_, fits) = tube(&parabola, json!({ "radius": 0.49 }));
    assert_eq!(fits.notes.len(), 1, "{:?}", fits.notes);
    let (_, wide) = tube(&parabola, json!({ "radius": 0.51 }));
    let said = wide.notes.last().unwrap();
    // y = x²: 1/2 at the bottom, which is at parameter 1/2.
    assert!(
        said.contains("0.51") && said.contains("curvature is 0.5 ") && said.contains("(at 0.5000)"),
        "{said}"
    );
}

#[test]
fn what_is_awkward_has_a_tube_without_holes() {
    let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
    let cusp = Curve::bezier(vec![p(0.0, 0.0, 0.0), p(2.0, 1.0, 0.0), p(0.0, 1.0, 0.0), p(2.0, 0.0, 0.0)]);
    let turning =
        Curve::bezier(vec![p(0.0, 0.0, 0.0), p(3.0, 0.0, 0.0), p(-1.0, 0.0, 0.0), p(2.0, 0.0, 0.0)]);
    let straight = Curve::bezier(vec![p(0.0, 0.0, 0.0), p(1.0, 1.0, 1.0)]);
    let stopped = Curve::bezier(vec![p(0.0, 0.0, 0.0), p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 0.0, 0.0)]);
    let repeated = Curve::new(
        Space::clamped_uniform(3, 9).unwrap(),
        [0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 3.0, 4.0].map(|x| p(x, x * x, 0.0)).to_vec(),
    );
    let mut all: Vec<Geometry> = [cusp, turning, straight, stopped, repeated]
        .into_iter()
        .map(|c| Geometry::from(c.unwrap()))
        .collect();
    let lines = [
        (vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 0.0, 0.0)], false),
        (
            vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, 1.0, 0.0)],
            false,
        ),
        (vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.001, 0.0, 0.0)], true),
        (vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(0.0, 0.0, 0.0)], true),
        (vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0)], true),
    ];
    all.extend(lines.map(|(points, closed)| Geometry::from(Polyline { points, closed })));
    for geometry in all {
        for caps in ["flat", "round"] {
            let (mesh, _) = tube(geometry.clone(), json!({ "radius": 0.05, "sides": 9, "caps": caps }));
            assert!(mesh.points().iter().all(|p| p.iter().all(|c| c.is_finite())));
            assert!(mesh.normals.values().iter().all(|n| (n.norm() - 1.0).abs() < 1e-9));
            assert_eq!(open_edges(&mesh), 0, "{}", geometry.kind());
        }
    }
}

#[test]
fn torn_curves_have_a_tube_for_each_part() {
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    let points = (0..6).map(|k| Point::new(f64::from(k), f64::from(k * k % 3), f64::from(k / 3))).collect();
    let torn = Curve::new(Space::open(2, knots).unwrap(), points).unwrap();
    let (mesh, _) = tube(&torn, json!({ "radius": 0.05, "sides": 6 }));
    assert_eq!(open_edges(&mesh), 0);
    assert_eq!(mesh.faces().filter(|f| f.len() == 6).count(), 4, "two parts have four ends");
    // Nothing leads from one part to the other.
    assert!(mesh.faces().all(|f| {
        let parts: Vec<bool> = f.iter().map(|&p| mesh.points()[p as usize].z < 0.5).collect();
        parts.iter().all(|&part| part == parts[0])
    }));
}

/// A rope of many frames: it swings, twists out of its plane and comes back.
fn swinging(space: Space, frames: usize) -> Object {
    let count = space.len();
    let at = |time: f64| -> Vec<Point> {
        let of = |k: usize| {
            let a = if space.is_periodic() { TAU * k as f64 / count as f64 } else { 0.4 * k as f64 };
            let (sine, cosine) = (a + 0.4 * time.sin()).sin_cos();
            Point::new(3.0 * cosine, 3.0 * sine, 1.5 * (a * 2.0 + time).sin() * (0.7 * time).sin())
        };
        (0..count).map(of).collect()
    };
    let frames: Vec<Vec<Point>> = (0..frames).map(|k| at(0.1 * k as f64)).collect();
    let last = frames.last().unwrap().clone();
    let mut object = Object::new("rope", Curve::new(space, last).unwrap().into());
    object.animation = Some(Animation { rate: 25.0, frames });
    object
}

#[test]
fn a_tube_moves_with_its_curve_and_does_not_jump() {
    for space in [Space::clamped_uniform(3, 12).unwrap(), Space::periodic_uniform(3, 9).unwrap()] {
        let mut scene = Scene::new();
        let rope = swinging(space, 120);
        scene.add(rope.clone()).unwrap();
        let report = run(&mut scene, json!({ "radius": 0.2, "sides": 12, "caps": "round" })).unwrap();
        let tube = scene.object("rope tube").unwrap();
        let animation = tube.animation.as_ref().unwrap();
        assert_eq!((animation.rate, animation.frames.len()), (25.0, 120));
        let now = tube.geometry().points();
        assert!(animation.frames.iter().all(|frame| frame.len() == now.len()));
        assert_eq!(animation.frames[119], now, "the last frame is what stays: {:?}", report.notes);
        // In each frame all points are a radius away from the frame's own curve.
        let Geometry::Curve(curve) = rope.geometry() else { panic!() };
        for k in [0, 17, 60, 119] {
            let points = rope.animation.as_ref().unwrap().frames[k].clone();
            let line = samples(&Curve::new(curve.space().clone(), points).unwrap(), 3000);
            for p in animation.frames[k].iter().step_by(5) {
                let off = (distance(&line, p) - 0.2).abs();
                assert!(off < 1e-3, "{off} in frame {k}");
            }
        }
        // From frame to frame nothing moves further than its curve does and a twelfth of a turn; a frame that jumped would.
        let pairs = animation.frames.windows(2).zip(rope.animation.as_ref().unwrap().frames.windows(2));
        for (k, (tube, curve)) in pairs.enumerate() {
            let most =
                |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let (tube, curve) = (most(&tube[0], &tube[1]), most(&curve[0], &curve[1]));
            assert!(tube < curve + 0.1, "frame {k}: {tube} against {curve}");
        }
    }
}

#[test]
fn frames_without_extent_keep_the_directions_of_those_before() {
    let line = |s: f64| vec![Point::origin(), Point::new(s, 0.0, 0.0), Point::new(s, s, 0.0)];
    let mut object = Object::new("rope", Polyline { points: line(1.0), closed: false }.into());
    let frames = vec![line(0.0), line(0.5), line(0.0), line(1.0)];
    object.animation = Some(Animation { rate: 24.0, frames });
    let mut scene = Scene::new();
    scene.add(object).unwrap();
    run(&mut scene, json!({ "radius": 0.1, "sides": 5 })).unwrap();
    let frames = &scene.object("rope tube").unwrap().animation.as_ref().unwrap().frames;
    assert!(frames.iter().flatten().all(|p| p.iter().all(|c| c.is_finite())));
    assert!(frames[0].iter().all(|p| (p.coords.norm() - 0.1).abs() < 0.05), "a ring about the point");
}

#[test]
fn the_curve_stays_or_goes() {
    let line = || Polyline { points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0)], closed: false };
    let mut one = scene(line());
    one.object_mut("rope").unwrap().color = Some([1.0, 0.0, 0.0, 1.0]);
    run(&mut one, json!({ "radius": 0.1 })).unwrap();
    assert_eq!(one.objects().len(), 2);
    assert_eq!(one.object("rope tube").unwrap().color, Some([1.0, 0.0, 0.0, 1.0]));
    let mut two = scene(line());
    run(&mut two, json!({ "radius": 0.1, "keep": false, "uvs": false })).unwrap();
    assert_eq!(two.objects().len(), 1);
    assert!(mesh(&two, "rope").uvs.is_empty());
    let mut three = scene(line());
    run(&mut three, json!({ "radius": 0.1, "keep": false, "name": "hose" })).unwrap();
    assert_eq!(three.objects()[0].name(), "hose");
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let line = |points: Vec<Point>| Geometry::from(Polyline { points, closed: false });
    let good = || line(vec![Point::origin(), Point::new(1.0, 0.0, 0.0)]);
    let far = || line(vec![Point::new(1.5e308, 0.0, 0.0), Point::new(1.5e308, 1e300, 0.0)]);
    let cases: Vec<(Geometry, Value, &[&str])> = vec![
        (good(), json!({}), &["radius"]),
        (good(), json!({ "radius": 0 }), &["step[0].radius", "above 0"]),
        (good(), json!({ "radius": -1 }), &["step[0].radius", "above 0"]),
        (good(), json!({ "radius": 1e-20 }), &["step[0].radius", "resolve"]),
        (good(), json!({ "radius": 1, "sides": 2 }), &["step[0].sides", "3 to"]),
        (good(), json!({ "radius": 1, "sides": 1_000_000 }), &["step[0].sides", "3 to"]),
        (good(), json!({ "radius": 1, "tolerance": 0 }), &["step[0].tolerance", "above 0"]),
        (good(), json!({ "radius": 1e6, "tolerance": 1e-9 }), &["step[0].tolerance", "sides"]),
        (good(), json!({ "radius": 1, "angle": 0 }), &["step[0].angle", "180"]),
        (good(), json!({ "radius": 1, "caps": "rond" }), &["step[0].caps", "round"]),
        (good(), json!({ "radius": 1, "name": "rope" }), &["step[0].name", "taken"]),
        (good(), json!({ "radius": 1, "object": "rop" }), &["step[0].object", "rope"]),
        (line(vec![Point::origin(); 3]), json!({ "radius": 1 }), &["rope", "no extent"]),
        (line(vec![]), json!({ "radius": 1 }), &["rope", "no extent"]),
        (
            Curve::bezier(vec![Point::origin(); 4]).unwrap().into(),
            json!({ "radius": 1 }),
            &["rope", "no extent"],
        ),
        (
            Mesh::new(vec![Point::origin(); 3], &[[0, 1, 2]]).unwrap().into(),
            json!({ "radius": 1, "object": "rope" }),
            &["rope", "a mesh", "curve or a polyline"],
        ),
        (good(), json!({ "radius": 1e300 }), &["step[0].sides", "1.2e152"]),
        (far(), json!({ "radius": 1.7e308, "sides": 7, "caps": "round" }), &["finite number"]),
    ];
    for (geometry, asked, words) in cases {
        let mut scene = scene(geometry);
        let before = scene.clone();
        let message = run(&mut scene, asked.clone()).unwrap_err().to_string();
        words.iter().for_each(|w| assert!(message.contains(w), "{asked}: {message} lacks {w}"));
        assert_eq!(scene, before);
    }
}

#[test]
fn whoever_watches_may_stop_it() {
    struct Stops;
    impl Observer for Stops {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let registry = registry();
    let operation = registry.find_operation("tube", "op").unwrap();
    let mut scene = Scene::new();
    scene.add(swinging(Space::clamped_uniform(3, 12).unwrap(), 5)).unwrap();
    let before = scene.clone();
    let context = Context { registry: &registry, observer: &Stops, clock: &NoClock };
    let asked = Parameters::new(json!({ "radius": 0.2 }), "step[0]").unwrap();
    let stopped = operation.apply(&mut scene, &asked, &context).unwrap_err();
    assert_eq!(stopped, OperationError::from(Cancelled));
    assert_eq!(scene, before);
}
