//! The operation `subdivide` in recipes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use loftsman_kernel::Point;
use loftsman_kernel::mesh::{FaceGroup, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_subdivision::Subdivision;
use serde_json::{Value, json};

const CUBE: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cube() -> Mesh {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    Mesh::new((0..8).map(corner).collect(), &CUBE).unwrap()
}

pub(crate) fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("cube", cube().into())).unwrap();
    let points =
        [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    scene.add(Object::new("loop", Polyline { points, closed: true }.into())).unwrap();
    scene
}

pub(crate) fn run(scene: &mut Scene, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Subdivision);
    let operation = registry.find_operation("subdivide", "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    parameters.check(operation.declaration().fields).map_err(OperationError::from)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn done(fields: Value) -> Geometry {
    let mut scene = scene();
    let name = fields["object"].as_str().unwrap().to_owned();
    run(&mut scene, fields).unwrap();
    scene.object(&name).unwrap().geometry().clone()
}

fn mesh(fields: Value) -> Mesh {
    match done(fields) {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

/// Vertices, edges and faces of a closed mesh: their alternating sum is kept.
fn characteristic(mesh: &Mesh) -> i64 {
    let edges = mesh.corners().len() / 2;
    mesh.points().len() as i64 - edges as i64 + mesh.face_count() as i64
}

/// What zero intervals bring together is one point wherever the form is, and however small it becomes.
#[test]
fn tuned_forms_are_closed_far_away_and_small() {
    for (far, alpha) in [(0.0, 1.1), (1e3, 1.1), (1e5, 1.1), (1e6, 1.0), (0.0, 1e-4), (0.0, 1e-9)] {
        let mut scene = Scene::new();
        let mut cube = cube();
        cube.points_mut().iter_mut().for_each(|p| p.coords.add_scalar_mut(far));
        scene.add(Object::new("cube", cube.into())).unwrap();
        let fields = json!({ "scheme": "doo-sabin", "levels": 3, "limit": true, "alpha": alpha });
        run(&mut scene, fields).unwrap();
        let Geometry::Mesh(mesh) = scene.object("cube").unwrap().geometry() else { panic!("a mesh") };
        assert_eq!((mesh.points().len(), characteristic(mesh)), (386, 2), "{far} {alpha}");
        assert!(mesh.starts().windows(2).all(|face| face[1] - face[0] == 4), "{far} {alpha}");
    }
    let error = |fields: Value| run(&mut scene(), fields).unwrap_err().to_string();
    for name in ["creases", "corners"] {
        let mut fields = json!({ "object": "cube", "scheme": "doo-sabin" });
        fields[name] = json!([[0, 1, 2]]);
        assert!(error(fields).contains("Doo-Sabin has none"));
    }
}

#[test]
fn meshes() {
    let fine = mesh(json!({ "object": "cube", "levels": 3 }));
    assert_eq!((fine.points().len(), fine.face_count(), characteristic(&fine)), (386, 384, 2));
    // A corner of the cube, and where it comes to: (3/8, 1/6, 1/24 each) of the corner, its neighbours and the rest.
    let first = mesh(json!({ "object": "cube" }));
    assert!((first.points()[0] - Point::new(2.0, 2.0, 2.0) / 9.0).norm() < 1e-15, "{}", first.points()[0]);
    let limit = mesh(json!({ "object": "cube", "limit": true }));
    assert!((limit.points()[0].x - (1.0 / 6.0 + 2.0 / 24.0)).abs() < 1e-15, "{}", limit.points()[0]);
    assert_eq!(limit.normals.values().len(), limit.points().len());
    let same = mesh(json!({ "object": "cube", "levels": 4, "limit": true }));
    assert!((same.points()[0] - limit.points()[0]).norm() < 1e-15, "the limit is one at every level");
    // All edges sharp: the cube itself, in quads.
    let edges: Vec<Value> = CUBE
        .iter()
        .flat_map(|f| (0..4).map(|k| (f[k], f[(k + 1) % 4])))
        .filter(|(a, b)| a < b)
        .map(|(a, b)| json!([a, b, 10]))
        .collect();
    let sharp = mesh(json!({ "object": "cube", "levels": 3, "limit": true, "creases": edges }));
    let at = |c: &f64| c.abs() < 1e-14 || (c - 1.0).abs() < 1e-14;
    let off = |p: &&Point| !p.iter().any(at) || p.iter().any(|c| !at(c) && !(0.0..=1.0).contains(c));
    assert_eq!(sharp.points().iter().find(off), None);
    let Geometry::Custom(surface) = done(json!({ "object": "cube", "surface": true })) else {
        panic!("a shape")
    };
    let at = |v: u32| surface.shape().unwrap().value(Location::Vertex(v), Derivative::POSITION).unwrap();
    assert!((at(0) - limit.points()[0].coords).norm() < 1e-15, "the same limit");
    let hole = mesh(json!({ "object": "cube", "holes": [1], "levels": 2 }));
    assert_eq!(hole.face_count(), 80);
    let doo = mesh(json!({ "object": "cube", "scheme": "doo-sabin", "levels": 2 }));
    assert_eq!(characteristic(&doo), 2);
    let doo = mesh(json!({ "object": "cube", "scheme": "doo-sabin", "levels": 2, "limit": true }));
    assert_eq!(characteristic(&doo), 2);
}

/// What is in one place, said twice, or would leave nothing.
#[test]
fn what_contradicts_itself_is_said() {
    let refused = |fields: Value| run(&mut scene(), fields).unwrap_err().to_string();
    for surface in [true, false] {
        let twice = json!({ "object": "cube", "surface": surface, "creases": [[0, 1, 2], [1, 0, 3]] });
        let error = refused(twice);
        assert!(error.contains("step[0].creases") && error.contains("twice, as 2 and as 3"), "{error}");
        let error =
            refused(json!({ "object": "cube", "surface": surface, "corners": [[4, 1], [5, 1], [4, 2]] }));
        assert!(error.contains("vertex 4 is said twice"), "{error}");
        let error = refused(json!({ "object": "cube", "surface": surface, "holes": [0, 1, 2, 3, 4, 5] }));
        assert!(error.contains("step[0].holes") && error.contains("all 6 faces are holes"), "{error}");
        let same = json!({ "object": "cube", "surface": surface, "creases": [[0, 1, 2], [1, 0, 2]] });
        assert!(run(&mut scene(), same).is_ok());
    }
    let error = refused(json!({ "object": "cube", "intervals": [[0, 1, 2], [0, 1, 3]] }));
    assert!(error.contains("interval") && error.contains("twice"), "{error}");

    // Two squares side by side, each with corners of its own.
    let at = [[0, 0], [1, 0], [1, 1], [0, 1], [1, 0], [2, 0], [2, 1], [1, 1]];
    let points = at.map(|[x, y]| Point::new(f64::from(x), f64::from(y), 0.0)).to_vec();
    let seam = Mesh::new(points, &[[0, 1, 2, 3], [4, 5, 6, 7]]).unwrap();
    for fields in [json!({}), json!({ "surface": true }), json!({ "scheme": "doo-sabin" })] {
        let mut scene = Scene::new();
        scene.add(Object::new("seam", seam.clone().into())).unwrap();
        let report = run(&mut scene, fields).unwrap();
        let note = &report.notes[0];
        assert!(note.contains("vertices 1 and 4 are in one place, and so is 1 other"), "{note}");
    }
    assert!(!run(&mut scene(), json!({ "object": "cube" })).unwrap().notes[0].contains("in one place"));
}

/// Edges without length and faces without area are refused by name, at any size; slivers are not.
#[test]
fn what_is_degenerate_is_refused() {
    for size in [1e-200, 1e-9, 1.0, 1e9, 1e200] {
        let square = |points: [[f64; 2]; 6]| {
            let points = points.map(|[x, y]| Point::new(size * x, size * y, 0.3 * size)).to_vec();
            let mut scene = Scene::new();
            let mesh = Mesh::new(points, &[[0, 1, 2, 3], [1, 4, 5, 2]]).unwrap();
            scene.add(Object::new("two", mesh.into())).unwrap();
            scene
        };
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for fields in [json!({}), json!({ "surface": true }), json!({ "scheme": "doo-sabin" })] {
            let refused = |points| run(&mut square(points), fields.clone()).unwrap_err().to_string();
            let error = refused([a, b, c, d, b, [2.0, 1.0]]);
            assert!(error.contains("between vertices 1 and 4 has no length"), "{error}");
            let error = refused([a, b, c, d, [1.0, -1.0], [1.0, 3.0]]);
            assert!(error.contains("face 1 has no area") && error.contains("(1, 4, …)"), "{error}");
            let sliver = square([a, b, c, d, [1.0 + 1e-9, 0.0], [1.0 + 1e-9, 1.0]]);
            assert!(run(&mut sliver.clone(), json!({})).is_ok());
        }
    }
}

/// What is left beside a hole is subdivided again, with no points that no face has.
#[test]
fn beside_a_hole_it_goes_on() {
    let grid = (0..36).map(|k| Point::new(f64::from(k / 6), f64::from(k % 6), 0.0)).collect();
    let face = |k: usize| {
        let at = 6 * (k / 5) + k % 5;
        [at, at + 6, at + 7, at + 1]
    };
    let faces: Vec<[usize; 4]> = (0..25).map(face).collect();
    let grid = Mesh::new(grid, &faces).unwrap();
    // Four faces round vertex 14, which no other has.
    let holes = json!([6, 7, 11, 12]);
    for (scheme, limit) in
        [("catmull-clark", false), ("catmull-clark", true), ("doo-sabin", false), ("doo-sabin", true)]
    {
        let mut scene = Scene::new();
        scene.add(Object::new("grid", grid.clone().into())).unwrap();
        run(&mut scene, json!({ "scheme": scheme, "holes": holes, "limit": limit })).unwrap();
        let Geometry::Mesh(once) = scene.object("grid").unwrap().geometry().clone() else { panic!("a mesh") };
        let mut has = vec![false; once.points().len()];
        once.corners().iter().for_each(|&v| has[v as usize] = true);
        assert!(has.iter().all(|has| *has), "{scheme}");
        assert!(once.normals.is_empty() || once.normals.values().len() == once.points().len());
        once.check().unwrap();
        run(&mut scene, json!({ "scheme": scheme })).unwrap();
    }
}

/// Materials, groups and texture coordinates go on to the faces that come of a face.
#[test]
fn what_belongs_to_faces_goes_on() {
    let mut cube = cube();
    cube.materials = vec![0, 1, 2, 0, 1, 2];
    cube.smoothing = vec![1; 6];
    cube.groups.push(FaceGroup { name: "top".into(), faces: vec![1, 4] });
    let corners = (0..24).map(|c| c % 4).collect();
    cube.uvs = Layer::per_corner(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], corners);
    let mut scene = Scene::new();
    scene.add(Object::new("cube", cube.into())).unwrap();
    run(&mut scene, json!({ "levels": 2, "holes": [0] })).unwrap();
    let Geometry::Mesh(fine) = scene.object("cube").unwrap().geometry() else { panic!("a mesh") };
    assert_eq!(fine.materials, [1, 2, 0, 1, 2].iter().flat_map(|m| [*m; 16]).collect::<Vec<u32>>());
    assert_eq!(fine.groups[0].faces, (0..16).chain(48..64).collect::<Vec<u32>>());
    assert_eq!((fine.smoothing.len(), fine.corners().len()), (80, 320));
    // Each quad of the square of texture coordinates is a sixteenth of it.
    let at = fine.uvs.corners().unwrap();
    for face in at.chunks(4) {
        let uv: Vec<[f64; 2]> = face.iter().map(|k| fine.uvs.values()[*k as usize]).collect();
        let area: f64 =
            (0..4).map(|k| uv[k][0] * uv[(k + 1) % 4][1] - uv[(k + 1) % 4][0] * uv[k][1]).sum::<f64>() / 2.0;
        assert!((area - 1.0 / 16.0).abs() < 1e-15, "{uv:?}");
    }
}

/// A surface's cage comes back as a mesh, as it was or refined by its own scheme; what a mesh has no place for is told.
#[test]
fn a_surface_gives_its_cage_back() {
    for scheme in ["catmull-clark", "doo-sabin"] {
        for (levels, limit) in [(0, false), (1, false), (2, false), (2, true)] {
            let once = |steps: &[Value]| {
                let mut scene = Scene::new();
                scene.add(Object::new("cube", cube().into())).unwrap();
                let mut notes = Vec::new();
                for step in steps {
                    notes = run(&mut scene, step.clone()).unwrap().notes;
                }
                let Geometry::Mesh(mesh) = scene.object("cube").unwrap().geometry().clone() else {
                    panic!("a mesh")
                };
                (mesh, notes)
            };
            let fields = json!({ "levels": levels, "limit": limit });
            let (back, notes) = once(&[json!({ "scheme": scheme, "surface": true }), fields]);
            let expected = match levels {
                0 => cube(),
                _ => once(&[json!({ "scheme": scheme, "levels": levels, "limit": limit })]).0,
            };
            assert_eq!(back.corners(), expected.corners(), "{scheme} {levels}");
            for (a, b) in back.points().iter().zip(expected.points()) {
                assert!((a - b).norm() < 1e-14, "{scheme} {levels}: {a} {b}");
            }
            assert!(!notes[0].contains("left out"), "{notes:?}");
        }
    }
    let mut scene = Scene::new();
    scene.add(Object::new("cube", cube().into())).unwrap();
    run(&mut scene, json!({ "surface": true, "creases": [[0, 1, 2.5]], "holes": [3] })).unwrap();
    let error = run(&mut scene, json!({ "levels": 0, "creases": [[0, 1, 1]] })).unwrap_err().to_string();
    assert!(error.contains("creases") && error.contains("whose cage has its own"), "{error}");
    let notes = run(&mut scene, json!({ "levels": 0 })).unwrap().notes;
    assert!(notes[0].contains("no place: creases, holes"), "{notes:?}");
}

/// What a surface, or Doo and Sabin's refinement, has no place for is told.
#[test]
fn what_is_left_behind_is_told() {
    let mut painted = cube();
    painted.materials = vec![0, 1, 1, 1, 0, 1];
    painted.groups.push(FaceGroup { name: "top".into(), faces: vec![1, 4] });
    for fields in [
        json!({ "surface": true }),
        json!({ "scheme": "doo-sabin", "surface": true }),
        json!({ "scheme": "doo-sabin" }),
    ] {
        let note = |mesh: Mesh| {
            let mut scene = Scene::new();
            scene.add(Object::new("cube", mesh.into())).unwrap();
            run(&mut scene, fields.clone()).unwrap().notes.join(" ")
        };
        let told = note(painted.clone());
        assert!(
            told.contains("no place: materials of single faces (all have the first now), groups"),
            "{told}"
        );
        assert!(!note(cube()).contains("no place"), "{fields}");
    }
}

#[test]
fn polylines() {
    let Geometry::Polyline(line) = done(json!({ "object": "loop", "scheme": "chaikin" })) else {
        panic!("a polyline")
    };
    assert_eq!((line.points.len(), line.closed), (8, true));
    let Geometry::Curve(curve) = done(json!({ "object": "loop", "limit": true })) else { panic!("a curve") };
    assert_eq!((curve.degree(), curve.is_periodic()), (3, true));
    let Geometry::Polyline(line) = done(json!({ "object": "loop", "levels": 9 })) else {
        panic!("a polyline")
    };
    let (a, b) = curve.domain();
    // Some point of the spline is near every point of the polygon that it comes of.
    for p in line.points.iter().step_by(37) {
        let near = (0..=4000).map(|i| curve.point(a + (b - a) * f64::from(i) / 4000.0).unwrap());
        let least = near.map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
        assert!(least < 2e-3, "{least}");
    }
    let Geometry::Curve(curve) =
        done(json!({ "object": "loop", "scheme": "chaikin", "limit": true, "intervals": [1, 2, 1, 3] }))
    else {
        panic!("a curve")
    };
    assert_eq!(curve.degree(), 2);
}

/// A Doo-Sabin form tuned: with α = 1 its own surface, one point for the corners of each face, all faces with area; with another the same
/// scaled.
#[test]
fn a_form_tuned() {
    let form = |more: Value| {
        let mut fields = json!({ "object": "cube", "scheme": "doo-sabin", "limit": true, "levels": 2 });
        more.as_object().unwrap().iter().for_each(|(name, value)| fields[name] = value.clone());
        mesh(fields)
    };
    let same = form(json!({ "alpha": 1 }));
    assert_eq!(characteristic(&same), 2);
    // A vertex of the cube has three corners, and each of these four quads a level: no other face is left.
    assert_eq!(same.face_count(), 8 * 3 * 4);
    assert!((0..same.face_count()).all(|f| same.face_normal(f).is_some()));
    assert!(!same.normals.is_empty());
    for middle in [[0.5, 0.5, 0.0], [0.5, 1.0, 0.5], [1.0, 0.5, 0.5]] {
        let near = same.points().iter().map(|p| (p - Point::from(middle)).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-15, "{near:e}");
    }
    let large = form(json!({ "alpha": 2 }));
    let [a, b] = [&same, &large].map(|m| m.points()[1] - m.points()[0]);
    assert!((b - a * 2.0).norm() < 1e-14);
    let longer = form(json!({ "alpha": [{ "edge": [4, 5], "value": 1.8 }], "lock": [0] }));
    let wide = |m: &Mesh| m.points().iter().map(|p| p.x).fold(f64::MIN, f64::max);
    assert!(longer.face_count() == same.face_count() && wide(&longer) > wide(&same) + 0.02);
    let control = mesh(json!({ "object": "cube", "scheme": "doo-sabin", "levels": 0, "alpha": 1 }));
    assert_eq!((control.points().len(), control.face_count()), (24, 26));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let fails = |fields: Value| {
        let mut changed = scene();
        let error = run(&mut changed, fields).unwrap_err().to_string();
        assert_eq!(changed, scene(), "a failed step leaves the scene alone");
        error
    };
    for (fields, words) in [
        (json!({ "levels": 1 }), "object"),
        (json!({ "object": "cube", "scheme": "cubic" }), "polylines"),
        (json!({ "object": "loop", "scheme": "doo-sabin" }), "meshes"),
        (json!({ "object": "cube", "levels": 40 }), "take fewer"),
        (json!({ "object": "loop", "levels": 60 }), "take fewer"),
        (json!({ "object": "cube", "creases": [[0, 1, 2], [0, 7, 1]] }), "creases[1]"),
        (json!({ "object": "cube", "creases": [[0, 1]] }), "creases[0]"),
        (json!({ "object": "cube", "creases": [[0, 1, -2]] }), "between vertices 0 and 1"),
        (json!({ "object": "cube", "corners": [[0, 1], [9, 1]] }), "corners[1]"),
        (json!({ "object": "cube", "corners": [[0.5, 1]] }), "0.5"),
        (json!({ "object": "cube", "holes": [6] }), "6"),
        (json!({ "object": "loop", "creases": [[0, 1, 1]] }), "for meshes"),
        (json!({ "object": "loop", "intervals": [1, 2] }), "interval"),
        (json!({ "object": "cube", "boundary": "sharp" }), "edge-only"),
        (json!({ "object": "cube", "alpha": 2 }), "doo-sabin"),
        (json!({ "object": "loop", "alpha": 2 }), "for meshes"),
        (json!({ "object": "cube", "scheme": "doo-sabin", "lock": [0] }), "alpha"),
        (json!({ "object": "cube", "scheme": "doo-sabin", "alpha": 0 }), "α"),
        (json!({ "object": "cube", "scheme": "doo-sabin", "alpha": 2, "lock": [8] }), "8"),
        (
            json!({ "object": "cube", "scheme": "doo-sabin", "alpha": [{ "edge": [0, 7], "value": 2 }] }),
            "alpha[0]",
        ),
        (
            json!({
                "object": "cube", "scheme": "doo-sabin",
                "alpha": [{ "edge": [4, 5], "value": 2 }, { "edge": [5, 4], "value": 3 }],
            }),
            "alpha[1].value: the alpha of the edge between vertices 5 and 4 is said twice",
        ),
        (json!({ "object": "cube", "scheme": "doo-sabin", "alpha": 2, "levels": 40 }), "take fewer"),
    ] {
        let error = fails(fields.clone());
        assert!(error.contains(words), "{fields}: {error}");
    }
    // Three faces at an edge.
    let mut scene = Scene::new();
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let fan = Mesh::new(points.map(Point::from).to_vec(), &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    scene.add(Object::new("fan", fan.into())).unwrap();
    let error = run(&mut scene, json!({})).unwrap_err().to_string();
    assert!(error.contains("edge between vertices 0 and 1"), "{error}");
}

fn apply(scene: &mut Scene, op: &str, fields: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Subdivision);
    let operation = registry.find_operation(op, "step[0]").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    parameters.check(operation.declaration().fields).map_err(OperationError::from)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

/// A mesh becomes the cage of Doo and Sabin's surface, too.
#[test]
fn a_doo_sabin_surface_is_a_shape() {
    let fields = json!({ "object": "cube", "scheme": "doo-sabin", "surface": true });
    let Geometry::Custom(surface) = done(fields.clone()) else { panic!("it is a shape of the plug-in") };
    let shape = surface.shape().unwrap();
    assert_eq!((shape.faces(), shape.control_vertices().len()), (Some(24), 8));
    let middle = shape.value(Location::Face(0, 0.0, 0.0), Derivative::POSITION).unwrap();
    assert!((middle - Point::new(0.5, 0.5, 0.0).coords).norm() < 1e-15, "{middle}");
    let report = run(&mut scene(), fields).unwrap();
    assert!(
        report.notes[0].contains("of 24 faces") && report.notes[0].contains("areas leave out at most"),
        "{report:?}"
    );
    let refused = |fields| run(&mut scene(), fields).unwrap_err().to_string();
    let tuned = json!({ "object": "cube", "scheme": "doo-sabin", "surface": true, "alpha": 2.0 });
    assert!(refused(tuned).contains("alpha"));
    let levels = json!({ "object": "cube", "scheme": "doo-sabin", "surface": true, "levels": 2 });
    assert!(refused(levels).contains("levels"));
}

/// By knot intervals of vertices towards others, as `levels`, with `limit` and as a surface.
#[test]
fn doo_sabin_by_intervals() {
    let fields = |more: Value| {
        let mut all = json!({ "object": "cube", "scheme": "doo-sabin" });
        more.as_object().unwrap().iter().for_each(|(name, value)| all[name] = value.clone());
        all
    };
    let plain = mesh(fields(json!({})));
    let edges: Vec<[usize; 2]> = CUBE.iter().flat_map(|f| (0..4).map(|k| [f[k], f[(k + 1) % 4]])).collect();
    // All alike are none.
    let alike: Vec<Value> = edges.iter().map(|[a, b]| json!([a, b, 2.5])).collect();
    let same = mesh(fields(json!({ "intervals": alike.clone() })));
    assert!(same.points().iter().zip(plain.points()).all(|(p, q)| (p - q).norm() < 1e-15));
    // Upwards and downwards, on all sides the same, others than along the rest.
    let upright = |a: usize, b: usize| a ^ b == 4;
    let rows: Vec<Value> =
        edges.iter().map(|&[a, b]| json!([a, b, if upright(a, b) && a < 4 { 0.25 } else { 1.0 }])).collect();
    let fine = mesh(fields(json!({ "intervals": rows.clone() })));
    assert_eq!(characteristic(&fine), 2);
    // A corner of a side: by 1/8 of the way across, and 1/20 up where the interval is 1/4, 2/5 down where it is 1.
    let near = |p: Point| fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
    assert!(near(Point::new(0.25, 0.0, 0.1)) < 1e-15 && near(Point::new(0.25, 0.0, 0.6)) < 1e-15);
    let limit = mesh(fields(json!({ "intervals": rows.clone(), "levels": 2, "limit": true })));
    assert_eq!(characteristic(&limit), 2);
    let Geometry::Custom(surface) = done(fields(json!({ "intervals": rows, "surface": true }))) else {
        panic!("a shape")
    };
    let shape = surface.shape().unwrap();
    // The middle of a side, where the knots cross: 1/5 of the way up.
    let middle = shape.value(Location::Face(8, 0.0, 0.0), Derivative::POSITION).unwrap();
    assert!((middle - Point::new(0.5, 0.0, 0.2).coords).norm() < 1e-15, "{middle}");
    let at = |v: u32| shape.value(Location::Vertex(v), Derivative::POSITION).unwrap();
    assert!(limit.points().iter().any(|p| (p.coords - at(0)).norm() < 1e-14), "the same limit");

    let refused = |more: Value| run(&mut scene(), fields(more)).unwrap_err().to_string();
    for surface in [false, true] {
        for (intervals, place, words) in [
            (
                json!([[0, 1, 1], [0, 1, 2]]),
                "step[0].intervals[1]",
                "vertex 0 towards 1 is said twice, as 1 and as 2",
            ),
            (json!([[0, 7, 1]]), "step[0].intervals[0]", "no edge between vertices 0 and 7"),
            (json!([[0, 1, 1], [1, 3, -2]]), "step[0].intervals[1]", "vertex 1 towards 3 is -2"),
            (json!([[0, 1, 1e-300]]), "step[0].intervals[0]", "vertex 0 towards 1"),
            (json!([[0, 1]]), "intervals[0]", "3 numbers"),
            (json!([[0, 8, 1]]), "step[0].intervals[0]", "8"),
        ] {
            let error = refused(json!({ "intervals": intervals, "surface": surface }));
            assert!(error.contains(place) && error.contains(words), "{error}");
        }
        // The other way it is another.
        let both = json!({ "intervals": [[0, 1, 2], [1, 0, 3]] });
        assert!(surface || run(&mut scene(), fields(both)).is_ok());
    }
    let error = refused(json!({ "intervals": [[0, 1, 2]], "surface": true }));
    assert!(error.contains("face ") && error.contains("limit = true"), "{error}");
    let error = refused(json!({ "intervals": [[0, 1, 2]], "alpha": 1.5 }));
    assert!(error.contains("edge between vertices 1 and 0") && error.contains("intervals"), "{error}");
}

/// A surface becomes a group of splines that hang under it; where that fails, nothing has changed.
#[test]
fn patches_are_objects() {
    let mut all = scene();
    apply(&mut all, "subdivide", json!({ "object": "cube", "surface": true })).unwrap();
    let before = all.clone();
    for (fields, words) in [
        (json!({ "object": "loop" }), "not a subdivision surface"),
        (json!({ "tolerance": 0 }), "tolerance"),
        (json!({ "tolerance": 1e-18 }), "larger"),
        (json!({ "object": "none" }), "none"),
    ] {
        let error = apply(&mut all, "patches", fields).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        assert_eq!(all, before);
    }
    let report = apply(&mut all, "patches", json!({ "tolerance": 1e-3 })).unwrap();
    assert!(report.notes[0].contains(" exactly, ") && report.notes[0].ends_with(" m"), "{report:?}");
    assert!(matches!(all.object("cube").unwrap().geometry(), Geometry::Group));
    let parts: Vec<_> = all.objects().iter().filter(|o| o.parent.as_deref() == Some("cube")).collect();
    assert!(parts.len() > 8 && parts.iter().all(|o| matches!(o.geometry(), Geometry::Surface(_))));
    assert!(report.notes[0].starts_with(&format!("{} bicubic surfaces", parts.len())));
    // What is no subdivision surface any more is not found again.
    assert!(apply(&mut all, "patches", json!({})).is_err());
    // So does one of Doo and Sabin; their regular pieces are biquadratic.
    let mut all = scene();
    apply(&mut all, "subdivide", json!({ "object": "cube", "surface": true, "scheme": "doo-sabin" }))
        .unwrap();
    let report = apply(&mut all, "patches", json!({ "object": "cube", "tolerance": 1e-3 })).unwrap();
    assert!(report.notes[0].contains(" biquadratic exactly, "), "{report:?}");
    assert!(report.notes[0].contains(" bicubic within "), "{report:?}");
}

/// What integrals leave out is said where a surface is made.
#[test]
fn what_is_left_out_is_said() {
    let mut all = scene();
    let report = apply(&mut all, "subdivide", json!({ "object": "cube", "surface": true })).unwrap();
    assert!(report.notes[0].contains("areas leave out at most"), "{report:?}");
}

/// A mesh without a vertex inside has no limit by Doo and Sabin, and that is said.
#[test]
fn nothing_is_no_result() {
    let mut all = scene();
    let triangle =
        Mesh::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point::from).to_vec(), &[[0, 1, 2]])
            .unwrap();
    all.replace("cube", Geometry::Mesh(triangle)).unwrap();
    let error = run(&mut all, json!({ "object": "cube", "scheme": "doo-sabin", "limit": true }))
        .unwrap_err()
        .to_string();
    assert!(error.contains("leaves nothing"), "{error}");
}

/// Along a crease that is sharp for ever each side of a mesh of limits has its own normals: no corner's is far from its face's.
#[test]
fn limits_have_normals_on_both_sides_of_creases() {
    let creases: Vec<_> = [[0, 1], [1, 3], [3, 2], [2, 0]].map(|[a, b]| json!([a, b, 10])).to_vec();
    let fields = json!({ "object": "cube", "levels": 3, "limit": true, "creases": creases });
    let Geometry::Mesh(mesh) = done(fields) else { panic!("a mesh") };
    assert!(mesh.normals.corners().is_some() && mesh.normals.values().len() > mesh.points().len());
    for (face, corners) in mesh.starts().windows(2).enumerate() {
        let flat = mesh.face_normal(face).unwrap();
        for corner in corners[0]..corners[1] {
            let own = mesh.normals.at(corner, mesh.corners()[corner]).unwrap();
            assert!(own.dot(&flat) > 0.9, "face {face}: {own} {flat}");
        }
    }
}
