//! Everything that is registered passes the kernel's suites; what is new and has no sample here fails.

use loftsman::kernel::Point;
use loftsman::kernel::conformance::{
    format_conformance, functional_conformance, operation_conformance, sample_assembly, sample_scene,
    solver_conformance,
};
use loftsman::kernel::error::Error;
use loftsman::kernel::functional::ShapeNames;
use loftsman::kernel::mesh::Polyline;
use loftsman::kernel::plugin::Parameters;
use loftsman::kernel::scene::{Geometry, Layer, Object, Scene};
use loftsman::kernel::shape::Shape;
use loftsman::kernel::spline::{Curve, Space, Surface};
use loftsman::subdivision::{Cage, SubdivisionSurface};
use serde_json::{Value, json};

#[test]
fn every_format() {
    let formats = loftsman::registry().formats();
    assert!(formats.len() >= 4);
    for format in formats {
        // A scene of what the format can hold, one of everything, and one that shows everything four times.
        let mut clouds = Scene::new();
        for object in sample_scene().objects() {
            if matches!(object.geometry(), Geometry::Cloud(_) | Geometry::Polyline(_)) {
                let mut object = object.clone();
                object.parent = None;
                clouds.add(object).unwrap();
            }
        }
        for scene in [clouds, sample_scene(), sample_assembly(), layered()] {
            let verdict = format_conformance(format.as_ref(), &scene);
            assert!(verdict.passed(), "{}: {verdict}", format.declaration().name);
        }
    }
}

/// The sample with layers below one another, one of them hidden, colours by layer, and a mesh that is called as another one.
fn layered() -> Scene {
    let mut scene = sample_scene();
    scene.layers.add(Layer::new("frames").below("off")).unwrap();
    scene.layers.add(Layer::new("off").hidden()).unwrap();
    scene.layers.add(Layer::new("violet").colored([0.5, 0.25, 1.0, 1.0])).unwrap();
    let mesh = scene.object("mesh").unwrap().renamed("mesh.001").labelled("mesh");
    scene.add(mesh).unwrap();
    for name in ["mesh.001", "clamped curve", "patch", "cloud"] {
        let object = scene.object_mut(name).unwrap();
        (object.color, object.layer) = (None, Some("violet".into()));
    }
    scene.check().unwrap();
    scene
}

#[test]
fn every_solver() {
    let solvers = loftsman::registry().solvers();
    assert!(solvers.len() >= 6);
    for solver in solvers {
        let verdict = solver_conformance(solver.as_ref());
        assert!(verdict.passed(), "{}: {verdict}", solver.name());
    }
}

#[test]
fn every_operation() {
    let registry = loftsman::registry();
    for operation in registry.operations() {
        let name = operation.declaration().name;
        let parameters = operation_sample(name);
        let parameters = Parameters::new(parameters, "step[0]").unwrap();
        let verdict = operation_conformance(operation.as_ref(), &with_squares(), &parameters, registry);
        assert!(verdict.passed(), "{name}: {verdict}");
    }
}

/// Fields that an operation takes, for the scene [`with_squares`].
pub(crate) fn operation_sample(name: &str) -> Value {
    let curve = "clamped curve";
    let position = json!({ "kind": "position", "at": 1.2, "by": [0.0, 1.0, 0.0] });
    match name {
        "edit" => json!({ "object": curve, "constraints": [position], "metric": "bend", "lock": [0] }),
        "drag" => {
            let handle = json!({ "kind": "position", "at": 1.2 });
            json!({ "object": curve, "handle": handle, "path": [[1, 2, 3], [2, 3, 4]], "frames": true })
        }
        "fair" => json!({ "object": curve, "energy": "bend", "constraints": [position], "lock": [0] }),
        "refine" => json!({ "object": curve, "knots": [0.2, 0.7, 0.7] }),
        "elevate" => json!({ "object": "patch", "by": 2 }),
        "simplify" => json!({ "object": "patch", "tolerance": 0.1 }),
        "reverse" => json!({ "object": "rational" }),
        "split" => json!({ "object": "patch", "at": 1.0, "direction": "v" }),
        "untrim" => json!({ "object": "window" }),
        "transform" => json!({ "object": "mesh", "scale": [1, -2, 1], "translate": [1, 0, 0] }),
        "tessellate" => json!({ "object": "patch", "tolerance": 20.0, "angle": 170 }),
        "tube" => json!({ "object": curve, "radius": 0.5, "sides": 5 }),
        "copy" => json!({ "object": "rational", "to": ["once", "twice"] }),
        "merge" => json!({ "file": merged() }),
        "delete" => json!({ "object": "group" }),
        "rename" => json!({ "object": "group", "to": "all" }),
        "fill" => json!({ "objects": ["square"], "size": 0.5 }),
        "extrude" => json!({ "objects": ["square"], "by": [0, 0, 2], "surfaces": true }),
        "intersect" => json!({ "object": curve, "with": "patch", "tolerance": 0.5 }),
        "section" => json!({ "object": "patch", "axis": "x", "count": 2 }),
        "loft" => json!({ "sections": ["square", "lid"], "surface": true }),
        "fine-tune" => json!({ "object": curve, "alpha": 1.3, "ends": "free" }),
        "subdivide" => json!({ "object": "square", "levels": 2 }),
        "patches" => json!({ "object": "cushion", "tolerance": 0.01 }),
        "fit" => json!({ "object": "chain", "degree": 2, "vertices": 4 }),
        "fit-shape" => json!({ "object": curve, "points": "chain", "fair": 0.01 }),
        "simulate" => {
            let held = json!([{ "kind": "position", "at": 1.2 }]);
            json!({ "object": curve, "seconds": 0.25, "scheme": "implicit", "gravity": [0, 0, -9.81], "constraints": held })
        }
        "line" => json!({ "from": [0, 0, 0], "to": [1, 2, 3] }),
        "polyline" => json!({ "points": [[0, 0, 0], [1, 2, 3], [2, 0, 1]], "curve": true }),
        "circle" => json!({ "radius": 2.0, "center": [1, 2, 3], "normal": [0, 1, 1] }),
        "arc" => json!({ "from": [1, 0, 0], "degrees": 100 }),
        "ellipse" => json!({ "x": [2, 0, 0], "y": [0, 1, 0.5] }),
        "revolve" => json!({ "object": curve, "axis": [0, 1, 1], "degrees": 200 }),
        "isocurve" => json!({ "object": "patch", "u": 0.7, "name": "iso" }),
        "edge" => json!({ "object": "patch", "edge": "v1" }),
        "match" => {
            json!({ "object": "patch", "edge": "u1", "with": { "object": "cap", "edge": "u0" }, "tolerance": 10.0, "angle": 100 })
        }
        "sample" => json!({ "object": curve, "count": 12 }),
        "offset" => json!({ "object": "square", "distance": 0.1, "corners": "sharp" }),
        "sweep" => json!({ "object": "rational", "path": curve, "tolerance": 0.01 }),
        "sew" => json!({ "objects": ["patch", "cap"] }),
        "symmetrize" => json!({ "object": curve, "normal": [0, 1, 1] }),
        other => panic!("the operation \"{other}\" has no sample: add one"),
    }
}

/// The sample scene, two planar outlines above one another, a sheet beside its patch, and two surfaces of cages.
pub(crate) fn with_squares() -> Scene {
    let mut scene = sample_scene();
    for (name, z) in [("square", 0.0), ("lid", 2.0)] {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = corners.iter().map(|c| Point::new(c[0], c[1], z)).collect();
        scene.add(Object::new(name, Polyline { points, closed: true }.into())).unwrap();
    }
    let (u, v) = (Space::clamped_uniform(2, 3).unwrap(), Space::clamped_uniform(2, 4).unwrap());
    let at = |k: usize| Point::new(8.0 + (k / 4) as f64, 300.0 * (k % 4) as f64, (k % 3) as f64);
    scene.add(Object::new("cap", Surface::new(u, v, (0..12).map(at).collect()).unwrap().into())).unwrap();
    for (name, length) in [("cushion", 1.0), ("bolster", 3.0)] {
        let corner = |k: usize| Point::new(length * (k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cage = Cage::new((0..8).map(corner).collect(), &faces).unwrap();
        scene.add(Object::new(name, SubdivisionSurface::new(cage).unwrap().into())).unwrap();
    }
    scene
}

/// A file that `merge` reads: points without a unit.
pub(crate) fn merged() -> String {
    let data = loftsman_tests::repository().join("examples/blade-section/IEA-15-240-RWT_AF20_Coords.txt");
    data.display().to_string()
}

/// Two shapes by any names.
struct Two;

impl ShapeNames for Two {
    fn shape(&mut self, name: &str) -> Result<usize, Error> {
        Ok(usize::from(name == "b"))
    }
}

#[test]
fn every_functional() {
    let registry = loftsman::registry();
    let turn = |i: usize, n: usize| std::f64::consts::TAU * i as f64 / n as f64;
    let ring = |n: usize| {
        let at =
            |i: usize| Point::new((2.0 + (3.0 * turn(i, n)).sin()) * turn(i, n).cos(), turn(i, n).sin(), 0.0);
        Curve::new(Space::periodic_uniform(3, n).unwrap(), (0..n).map(at).collect()).unwrap()
    };
    let torus = {
        let at = |k: usize| {
            let (a, b) = (turn(k / 6, 7), turn(k % 6, 6));
            Point::new((3.0 + b.cos()) * a.cos(), (3.0 + b.cos()) * a.sin(), b.sin() * (1.2 + 0.2 * a.cos()))
        };
        let (u, v) = (Space::periodic_uniform(3, 7).unwrap(), Space::periodic_uniform(2, 6).unwrap());
        Surface::new(u, v, (0..42).map(at).collect()).unwrap()
    };
    let arch = {
        let at = |i: i32| Point::new(f64::from(i) - 3.0, f64::from((i - 3) * (i - 3)), 0.5);
        Curve::new(Space::clamped_uniform(3, 7).unwrap(), (0..7).map(at).collect()).unwrap()
    };
    let sheet = |x: f64| {
        let (u, v) = (Space::clamped_uniform(3, 5).unwrap(), Space::clamped_uniform(2, 5).unwrap());
        let at = |k: usize| Point::new(x + (k / 5) as f64, (k % 5) as f64, 0.3 * ((3 * k) % 7) as f64);
        Surface::new(u, v, (0..25).map(at).collect()).unwrap()
    };
    let rail = {
        let at = |k: i32| Point::new(4.5, f64::from(k), 0.2 * f64::from(k * k % 3));
        Curve::new(Space::clamped_uniform(2, 5).unwrap(), (0..5).map(at).collect()).unwrap()
    };
    let curves = || -> Vec<Box<dyn Shape>> { vec![Box::new(arch.clone()), Box::new(ring(9))] };
    let loops = || -> Vec<Box<dyn Shape>> { vec![Box::new(ring(9)), Box::new(ring(8))] };
    let surfaces = || -> Vec<Box<dyn Shape>> { vec![Box::new(torus.clone())] };
    let mut kinds = 0;
    for declaration in registry.functionals() {
        let samples = match declaration.name {
            "position" | "tangent" | "magnitude" | "curvature" | "signed-curvature" => {
                vec![(curves(), json!({ "at": 0.9 }))]
            }
            "derivative" => vec![(curves(), json!({ "at": 0.9, "order": 3 }))],
            "orthogonal" => vec![
                (curves(), json!({ "at": 0.9, "direction": [1, 2, 3] })),
                (curves(), json!({ "at": 0.9, "to": [1, 2, 3] })),
            ],
            "normal" => vec![
                (surfaces(), json!({ "at": [0.9, 1.3], "direction": [1, 2, 3] })),
                (surfaces(), json!({ "at": [0.9, 1.3], "to": [1, 2, 3] })),
            ],
            "vertex" => vec![(curves(), json!({ "index": -1 })), (surfaces(), json!({ "index": 4 }))],
            "linear" => vec![(curves(), json!({ "terms": [{ "vertex": 0, "vector": [1, 2, 3] }] }))],
            "join" => {
                vec![(loops(), json!({ "at": 1.9, "with": { "object": "b", "at": 0.2 }, "continuity": 2 }))]
            }
            "edge" => {
                let with_rail =
                    || -> Vec<Box<dyn Shape>> { vec![Box::new(sheet(0.0)), Box::new(rail.clone())] };
                vec![(with_rail(), json!({ "edge": "u1", "curve": "b" }))]
            }
            "match" => {
                let two = || -> Vec<Box<dyn Shape>> { vec![Box::new(sheet(0.0)), Box::new(sheet(5.0))] };
                let fields = |k: usize| json!({ "edge": "u1", "with": { "object": "b", "edge": "u0" }, "continuity": k });
                vec![(two(), fields(0)), (two(), fields(1)), (two(), fields(2))]
            }
            "symmetry" => vec![(curves(), json!({ "normal": [1, 0, 0] }))],
            "area" => vec![(loops(), json!({})), (loops(), json!({ "normal": [0.3, -0.2, 1.0] }))],
            "length" => vec![(curves(), json!({}))],
            "volume" | "surface-area" => vec![(surfaces(), json!({}))],
            "centroid" => vec![(loops(), json!({})), (surfaces(), json!({}))],
            "closed" => {
                let mut points = arch.points().to_vec();
                points[6] = points[0];
                let lasso = Curve::new(arch.space().clone(), points).unwrap();
                vec![(vec![Box::new(lasso) as Box<dyn Shape>], json!({}))]
            }
            other => panic!("the kind \"{other}\" has no sample: add one"),
        };
        for (shapes, fields) in samples {
            let parameters = Parameters::new(fields, "test").unwrap();
            let functional = registry.build_functional(declaration.name, &parameters, &mut Two).unwrap();
            let verdict = functional_conformance(functional.as_ref(), &shapes);
            assert!(verdict.passed() && verdict.checks >= 12, "{}: {verdict}", declaration.name);
        }
        kinds += 1;
    }
    assert!(kinds >= 20, "{kinds}");
}
