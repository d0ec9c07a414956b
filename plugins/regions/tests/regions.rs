//! `fill`, `extrude` and `loft` against closed forms.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use std::f64::consts::{PI, TAU};

use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_regions::{Regions, area, boundary_loops, loft, volume};
use loftsman_tessellation::Tessellation;
use proptest::prelude::*;
use serde_json::{Value, json};

fn run(scene: &mut Scene, op: &str, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Regions);
    registry.add(&Tessellation);
    let operation = registry.find_operation(op, "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn fails(scene: &Scene, op: &str, fields: Value) -> String {
    let mut changed = scene.clone();
    let error = run(&mut changed, op, fields).unwrap_err().to_string();
    assert_eq!(&changed, scene, "a failed step leaves the scene alone");
    error
}

fn mesh<'a>(scene: &'a Scene, name: &str) -> &'a Mesh {
    match scene.object(name).unwrap().geometry() {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{name} is a {}", other.kind()),
    }
}

fn circle(x: f64, y: f64, z: f64, r: f64) -> Curve {
    Curve::circle(Point::new(x, y, z), Vector::z(), r).unwrap()
}

fn polygon(corners: &[[f64; 2]]) -> Polyline {
    Polyline { points: corners.iter().map(|c| Point::new(c[0], c[1], 0.0)).collect(), closed: true }
}

fn square(half: f64) -> Polyline {
    polygon(&[[-half, -half], [half, -half], [half, half], [-half, half]])
}

fn scene(objects: Vec<(&str, Geometry)>) -> Scene {
    let mut scene = Scene::new();
    for (name, geometry) in objects {
        scene.add(Object::new(name, geometry)).unwrap();
    }
    scene
}

/// Relative to what is expected.
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} instead of {expected}");
}

fn closed(mesh: &Mesh) {
    mesh.check().unwrap();
    assert!(boundary_loops(mesh, "").unwrap().is_empty(), "the mesh has open edges");
}

#[test]
fn a_square_with_a_hole_with_an_island() {
    let mut scene = scene(vec![
        ("hole", square(2.0).into()),
        ("outer", square(3.0).into()),
        ("island", square(1.0).into()),
    ]);
    let report = run(&mut scene, "fill", json!({ "objects": ["hole", "outer", "island"] })).unwrap();
    near(report.area.unwrap(), 36.0 - 16.0 + 4.0, 1e-14);
    let filled = mesh(&scene, "hole face");
    near(area(filled), 24.0, 1e-14);
    // Three squares of four corners: a ring of 8 triangles and an island of 2, all facing up.
    assert_eq!((filled.points().len(), filled.face_count()), (12, 10));
    assert!((0..10).all(|f| (filled.face_normal(f).unwrap() - Vector::z()).norm() < 1e-15));
    assert_eq!(boundary_loops(filled, "").unwrap().len(), 3);
}

#[test]
fn refinement_bounds_triangles_and_keeps_the_outline() {
    let mut scene = scene(vec![("outer", square(1.0).into()), ("hole", circle(0.2, 0.1, 0.0, 0.3).into())]);
    let fields = json!({ "objects": ["outer", "hole"], "size": 0.2, "min_angle": 20.0, "name": "sheet" });
    run(&mut scene, "fill", fields).unwrap();
    let sheet = mesh(&scene, "sheet");
    let most = 3_f64.sqrt() / 4.0 * 0.04;
    let largest = sheet
        .faces()
        .map(|f| {
            let p = |k: usize| sheet.points()[f[k] as usize];
            (p(1) - p(0)).cross(&(p(2) - p(0))).norm() / 2.0
        })
        .fold(0.0, f64::max);
    assert!(largest <= most * (1.0 + 1e-9), "{largest} > {most}");
    // Two loops, and edges of the square cut into equal or halved parts: its area and corners stay.
    assert_eq!(boundary_loops(sheet, "").unwrap().len(), 2);
    for corner in square(1.0).points {
        assert!(sheet.points().contains(&corner));
    }
    assert!(sheet.face_count() > 200);
    let mut solids = Scene::new();
    for object in scene.objects().iter().take(2) {
        solids.add(object.clone()).unwrap();
    }
    let fields = json!({ "objects": ["outer", "hole"], "by": [0, 0, 1], "size": 0.2, "name": "block" });
    let report = run(&mut solids, "extrude", fields).unwrap();
    closed(mesh(&solids, "block"));
    let told = report.numbers["deviation"].as_f64().unwrap();
    assert!(told > 0.0 && told <= report.numbers["tolerance"].as_f64().unwrap(), "{:?}", report.notes);
    // What is bounded by lines is nowhere off.
    let mut lines = self::scene(vec![("square", square(1.0).into())]);
    let report = run(&mut lines, "extrude", json!({ "objects": ["square"], "by": [0.3, 0, 1] })).unwrap();
    assert_eq!(report.numbers["deviation"], 0.0, "{:?}", report.notes);
}

#[test]
fn a_disc_converges_at_second_order() {
    let error = |tolerance: f64| {
        let mut scene = scene(vec![("ring", circle(1.0, 2.0, 3.0, 2.0).into())]);
        let fields = json!({ "objects": ["ring"], "tolerance": tolerance, "angle": 170 });
        let report = run(&mut scene, "fill", fields).unwrap();
        // How far the chords are from the circle is told: from the widest of them.
        let points = mesh(&scene, "ring face").points();
        let chord = points.windows(2).map(|p| (p[1] - p[0]).norm()).fold(0.0, f64::max);
        let sagitta = 2.0 - (4.0 - 0.25 * chord * chord).sqrt();
        let told = report.numbers["deviation"].as_f64().unwrap();
        assert!(sagitta <= told * (1.0 + 1e-9) && told <= tolerance, "{sagitta} {told}");
        assert!(told < 1.1 * sagitta, "{sagitta} {told}");
        assert!(report.notes[1].starts_with("within ") && report.notes[1].ends_with(" asked for)"));
        4.0 * PI - report.area.unwrap()
    };
    // Chords of n sides miss an area of h² where they miss a distance of h²: a hundredth of one is of the other.
    let ratio = error(1e-2) / error(1e-4);
    assert!((50.0..200.0).contains(&ratio), "{ratio}");
}

#[test]
fn open_curves_are_joined_end_to_end() {
    let arc = |from: f64, to: f64| {
        Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::y(), from, to - from).unwrap()
    };
    let mut scene = scene(vec![
        ("first", arc(0.0, PI).into()),
        // Runs the other way round, and is turned.
        ("second", arc(PI, TAU).reverse().unwrap().into()),
    ]);
    let fields = json!({ "objects": ["first", "second"], "tolerance": 1e-5 });
    near(run(&mut scene, "fill", fields).unwrap().area.unwrap(), PI, 1e-4);
    let text = fails(&scene, "fill", json!({ "objects": ["first"] }));
    assert!(text.contains("\"first\" is open: its ends are 2 apart"), "{text}");
    let fields = json!({ "objects": ["first"], "tolerance": 1e-5, "bridge": true, "name": "half" });
    near(run(&mut scene, "fill", fields).unwrap().area.unwrap(), PI / 2.0, 1e-4);
}

#[test]
fn extruded_solids_have_the_volume_of_prisms_and_cylinders() {
    for by in [[0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [3.0, -1.0, 2.0]] {
        for reversed in [false, true] {
            let mut outer = square(3.0);
            if reversed {
                outer.points.reverse();
            }
            let mut scene = scene(vec![("outer", outer.into()), ("hole", square(1.0).into())]);
            let fields = json!({ "objects": ["outer", "hole"], "by": by, "name": "tube", "surfaces": true });
            let report = run(&mut scene, "extrude", fields).unwrap();
            closed(mesh(&scene, "tube"));
            near(report.volume.unwrap(), 2.0 * 32.0, 1e-13);
            near(volume(mesh(&scene, "tube")), 64.0, 1e-13);
            assert_eq!(scene.object("hole wall").unwrap().geometry().kind(), "surface");
        }
    }
    let mut scene = scene(vec![("ring", circle(0.0, 0.0, 0.0, 2.0).into())]);
    let fields = json!({ "objects": ["ring"], "by": [0, 0, 5], "tolerance": 1e-4, "angle": 170 });
    let report = run(&mut scene, "extrude", fields).unwrap();
    closed(mesh(&scene, "ring solid"));
    near(report.volume.unwrap(), PI * 4.0 * 5.0, 3e-4);
    near(report.area.unwrap(), 2.0 * PI * 4.0 + TAU * 2.0 * 5.0, 3e-4);
}

#[test]
fn a_loft_between_two_circles_is_a_frustum() {
    // The second runs the other way round.
    let upper = circle(0.0, 0.0, 3.0, 1.0).reverse().unwrap();
    let mut scene = scene(vec![("lower", circle(0.0, 0.0, 0.0, 2.0).into()), ("upper", upper.into())]);
    let fields = json!({ "sections": ["lower", "upper"], "tolerance": 1e-4, "surface": true });
    let report = run(&mut scene, "loft", fields).unwrap();
    closed(mesh(&scene, "lower loft"));
    near(report.volume.unwrap(), PI * 3.0 / 3.0 * (4.0 + 2.0 + 1.0), 3e-4);
    assert_eq!(scene.object("lower loft surface").unwrap().geometry().kind(), "surface");
}

#[test]
fn a_loft_passes_through_its_sections() {
    let sections: Vec<Curve> = (0..5)
        .map(|k| {
            let t = f64::from(k);
            let ring = Curve::new(
                Space::periodic_uniform(3, 6 + k as usize).unwrap(),
                (0..6 + k)
                    .map(|i| {
                        let a = TAU * f64::from(i) / f64::from(6 + k);
                        Point::new((2.0 + t.sin()) * a.cos(), (1.0 + 0.2 * t) * a.sin(), t * 1.5)
                    })
                    .collect(),
            );
            ring.unwrap()
        })
        .collect();
    let lofted = loft(&sections, 3).unwrap();
    let surface = &lofted.surface;
    // These rings start at other angles each, and run alike.
    assert!(
        lofted.sections.iter().all(|s| !s.reversed) && lofted.sections[1..].iter().all(|s| s.turned > 0.0)
    );
    let mut worst: f64 = 0.0;
    for (section, &v) in sections.iter().zip(&lofted.parameters) {
        for i in 0..97 {
            let (a, b) = surface.u().domain();
            let on = surface.point(a + (b - a) * f64::from(i) / 97.0, v).unwrap();
            worst = worst.max(section.closest(on).unwrap().distance);
        }
    }
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn what_cannot_be_filled_is_refused_with_the_place() {
    let bow = polygon(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    let mut bent = square(1.0);
    bent.points[2].z = 0.01;
    let scene = scene(vec![
        ("bow", bow.into()),
        ("bent", bent.into()),
        ("line", polygon(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).into()),
        ("square", square(1.0).into()),
        ("across", polygon(&[[0.0, 0.0], [5.0, 0.1], [5.0, 0.3]]).into()),
        ("touching", polygon(&[[1.0, 0.0], [5.0, 0.1], [5.0, 0.3]]).into()),
        ("scan", Cloud { points: vec![Point::origin()] }.into()),
    ]);
    let fill = |names: &[&str]| fails(&scene, "fill", json!({ "objects": names }));
    for (names, words) in [
        (vec!["bow"], "\"bow\" crosses or touches itself at ("),
        (vec!["bent"], "\"bent\" is not planar: it leaves the plane of the region by"),
        (vec!["line"], "\"line\" bounds no area"),
        (vec!["square", "across"], "cross or touch at ("),
        (vec!["square", "touching"], "\"touching\""),
        (vec!["scan"], "\"scan\" is a cloud: a region is bounded by"),
        (vec!["squre"], "did you mean \"square\"?"),
        (vec!["square", "square"], "named twice"),
        (vec![], "is empty"),
    ] {
        let text = fill(&names);
        assert!(text.contains(words), "{names:?}: {text}");
    }
    let text = fails(&scene, "fill", json!({ "objects": ["square"], "size": 1e-9 }));
    assert!(text.contains("ask for a larger size"), "{text}");
    let text = fails(&scene, "extrude", json!({ "objects": ["square"], "by": [1, 0, 0] }));
    assert!(text.contains("lies in the plane of \"square\""), "{text}");
    let text = fails(&scene, "loft", json!({ "sections": ["square"] }));
    assert!(text.contains("a loft needs two sections"), "{text}");
    let text = fails(&scene, "loft", json!({ "sections": ["square", "square"] }));
    assert!(text.contains("named twice"), "{text}");
}

/// The numbers in the parentheses behind "at" in a message.
fn place(message: &str) -> Point {
    let inside = message.split("at (").nth(1).and_then(|rest| rest.split(')').next()).unwrap();
    let numbers: Vec<f64> = inside.split(", ").map(|n| n.parse().unwrap()).collect();
    Point::new(numbers[0], numbers[1], numbers[2])
}

#[test]
fn a_crossing_is_told_where_it_is_and_a_line_that_closes_is_named() {
    // The line from (2, 0) to (0, 1) meets the diagonal at (2/3, 2/3), whichever corner comes first.
    let corners = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]];
    for first in 0..4 {
        let turned: Vec<[f64; 2]> = (0..4).map(|k| corners[(first + k) % 4]).collect();
        let text = fails(&scene(vec![("e", polygon(&turned).into())]), "fill", json!({ "objects": ["e"] }));
        let found = place(&text);
        assert!((found - Point::new(2.0 / 3.0, 2.0 / 3.0, 0.0)).norm() < 1e-12, "{text}");
    }
    let open = |list: &[[f64; 2]]| {
        let points = list.iter().map(|[x, y]| Point::new(*x, *y, 0.0)).collect();
        Polyline { points, closed: false }
    };
    // Closed by a line from (8, 1) to (0, 0), which meets the notch; closed by itself, a knot is its own.
    let notch = open(&[[0.0, 0.0], [0.0, 2.0], [3.0, 2.0], [4.0, 0.2], [5.0, 2.0], [8.0, 2.0], [8.0, 1.0]]);
    let knot = open(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]);
    let lines = scene(vec![("c", notch.into()), ("knot", knot.into())]);
    let text = fails(&lines, "fill", json!({ "objects": ["c"], "bridge": true }));
    assert!(text.contains("the straight line that closes \"c\" crosses or touches \"c\""), "{text}");
    let found = place(&text);
    assert!((found.y - found.x / 8.0).abs() < 1e-12 && found.x > 3.0 && found.x < 5.0, "{text}");
    let text = fails(&lines, "fill", json!({ "objects": ["knot"], "bridge": true }));
    assert!(text.contains("\"knot\" crosses or touches itself at (0.66"), "{text}");
    // The notch is out of the way here: the line meets another outline.
    let scene = scene(vec![
        ("c", open(&[[0.0, 0.0], [0.0, 2.0], [8.0, 2.0], [8.0, 1.0]]).into()),
        ("post", polygon(&[[1.0, -1.0], [2.0, -1.0], [2.0, 1.0], [1.0, 1.0]]).into()),
    ]);
    for names in [["c", "post"], ["post", "c"]] {
        let text = fails(&scene, "fill", json!({ "objects": names, "bridge": true }));
        assert!(text.contains("that closes \"c\" crosses or touches \"post\""), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A star polygon anywhere, of any size, in any plane: its area is the shoelace formula's.
    #[test]
    fn areas_hold_at_any_size_and_in_any_plane(
        radii in prop::collection::vec(0.3_f64..1.0, 3..40),
        exponent in -9_i32..=9,
        axis in prop::array::uniform3(-1.0_f64..1.0),
        shift in prop::array::uniform3(-3.0_f64..3.0),
        refined in any::<bool>(),
    ) {
        let axis = Vector::from(axis);
        prop_assume!(axis.norm() > 0.1);
        let size = 10_f64.powi(exponent);
        let turn = nalgebra_rotation(axis);
        let n = radii.len();
        let flat: Vec<[f64; 2]> = radii.iter().enumerate().map(|(i, r)| {
            let a = TAU * i as f64 / n as f64;
            [r * a.cos(), r * a.sin()]
        }).collect();
        let shoelace: f64 = (0..n).map(|i| {
            let (a, b) = (flat[i], flat[(i + 1) % n]);
            (a[0] * b[1] - a[1] * b[0]) / 2.0
        }).sum();
        let points = flat.iter().map(|p| {
            Point::from(turn(Vector::new(p[0], p[1], 0.0) + Vector::from(shift)) * size)
        }).collect();
        let mut scene = scene(vec![("star", Polyline { points, closed: true }.into())]);
        let mut fields = json!({ "objects": ["star"] });
        if refined {
            fields["size"] = json!(0.2 * size);
        }
        let report = run(&mut scene, "fill", fields).unwrap();
        let found = report.area.unwrap() / size / size;
        prop_assert!((found - shoelace.abs()).abs() < 1e-12, "{found} instead of {shoelace}");
    }
}

/// A rotation about an axis by its length in radians (Rodrigues).
fn nalgebra_rotation(axis: Vector) -> impl Fn(Vector) -> Vector {
    let (angle, k) = (axis.norm(), axis.normalize());
    move |v| v * angle.cos() + k.cross(&v) * angle.sin() + k * k.dot(&v) * (1.0 - angle.cos())
}
