//! Curvature as colours of a mesh, against closed forms.

use loftsman::kernel::plugin::{Context, CustomShape, Parameters};
use loftsman::kernel::scene::{Geometry, Object, Scene};
use loftsman::kernel::spline::{Curve, Surface};
use loftsman::kernel::{Point, Vector};
use loftsman::subdivision::doo_sabin::DooSabinSurface;
use loftsman::subdivision::{Cage, SubdivisionSurface};
use serde_json::{Value, json};

fn tessellated(geometry: Geometry, fields: Value) -> Result<(Scene, String), String> {
    let registry = loftsman::registry();
    let operation = registry.find_operation("tessellate", "op").unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("s", geometry)).unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    parameters.check(operation.declaration().fields).map_err(|e| e.to_string())?;
    let report =
        operation.apply(&mut scene, &parameters, &Context::quiet(registry)).map_err(|e| e.to_string())?;
    Ok((scene, report.notes.join("; ")))
}

/// A torus round the z axis, by exact circles.
fn torus(large: f64, small: f64) -> Surface {
    let circle = Curve::circle(Point::new(large, 0.0, 0.0), Vector::y(), small).unwrap();
    Surface::revolution(&circle, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
}

/// Where a linear colour is between blue (0), white and vermilion (1): red grows before the middle, blue falls behind it.
fn share(color: [f64; 4]) -> f64 {
    let [red, _, blue, _] =
        color.map(|x| 255.0 * if x <= 0.0031308 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 });
    if blue >= red { red / 490.0 } else { 1.0 - blue / 490.0 }
}

#[test]
fn a_torus_has_the_colours_of_its_curvature() {
    let (large, small) = (2.0, 0.5);
    // The curvatures of the circle of the tube and across it, seen from outside or inside.
    type Measure = fn(f64, f64) -> f64;
    let measures: [(&str, Measure); 4] = [
        ("gaussian", |a, b| a * b),
        ("mean", |a, b| 0.5 * (a + b)),
        ("maximum", f64::max),
        ("minimum", f64::min),
    ];
    for (word, measure) in measures {
        for [low, high] in [[-2.5, 3.5], [-3.0, 3.0]] {
            let fields = json!({ "colors": word, "range": [low, high] });
            let (scene, said) = tessellated(torus(large, small).into(), fields).unwrap();
            assert!(said.contains("curvature from ") && !said.contains("beyond"), "{said}");
            let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
            assert_eq!(mesh.colors.values().len(), mesh.points().len());
            assert!(mesh.points().len() > 500);
            let apart = |side: f64| {
                let at = |(p, color): (&Point, &[f64; 4])| {
                    let out = p.x.hypot(p.y);
                    let across = (out - large) / small / out;
                    let wanted = measure(side / small, side * across);
                    (share(*color) - (wanted - low) / (high - low)).abs()
                };
                mesh.points().iter().zip(mesh.colors.values()).map(at).fold(0.0, f64::max)
            };
            let most = f64::min(apart(1.0), apart(-1.0));
            assert!(most < 1e-9, "{word}: {most:e}");
        }
    }
}

#[test]
fn a_limit_surface_has_colours_too_and_a_plane_none() {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube = SubdivisionSurface::new(Cage::new((0..8).map(corner).collect(), &faces).unwrap()).unwrap();
    let cube: Geometry = CustomShape::from(cube).into();
    let (scene, said) = tessellated(cube, json!({ "colors": "gaussian" })).unwrap();
    // The cube's eight corners stay extraordinary.
    assert!(said.contains("8 points without one"), "{said}");
    let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
    // Alike where the cube is: by symmetry.
    let middle = Point::new(0.5, 0.5, 0.5);
    for (p, color) in mesh.points().iter().zip(mesh.colors.values()) {
        let mut key: Vec<f64> = (p - middle).iter().map(|x| x.abs()).collect();
        key.sort_by(f64::total_cmp);
        for (q, other) in mesh.points().iter().zip(mesh.colors.values()) {
            let mut other_key: Vec<f64> = (q - middle).iter().map(|x| x.abs()).collect();
            other_key.sort_by(f64::total_cmp);
            if key.iter().zip(&other_key).all(|(a, b)| (a - b).abs() < 1e-9) {
                assert!((0..3).all(|k| (color[k] - other[k]).abs() < 1e-6), "{p} {color:?}, {q} {other:?}");
            }
        }
    }
    let space = || loftsman::kernel::spline::Space::clamped(2, &[0.0, 0.5, 1.0]).unwrap();
    let net = (0..16).map(|k| Point::new(f64::from(k / 4), f64::from(k % 4), 0.0)).collect();
    let plane = Surface::new(space(), space(), net).unwrap();
    let (scene, said) = tessellated(plane.into(), json!({ "colors": "mean" })).unwrap();
    assert!(said.contains("mean curvature 0 everywhere"), "{said}");
    let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
    assert!(mesh.colors.values().iter().all(|c| c[0] == c[2]));
}

/// What bends one way only has no Gaussian curvature: white, not noise from blue to vermilion, at every size
/// and place.
#[test]
fn rounding_is_no_curvature() {
    for size in [1e-9, 1e-3, 1.0, 0.7e4, 1e9] {
        let at = |x: f64, y: f64, z: f64| Point::new(x, y, z) * size;
        let line = |a: Point, b: Point| Curve::line(a, b).unwrap();
        let turned = |line: Curve, sweep: f64| {
            Surface::revolution(&line, at(0.3, 0.2, 0.1), Vector::z(), sweep).unwrap()
        };
        let cylinder = turned(line(at(1.3, 0.2, 0.0), at(1.3, 0.2, 2.0)), std::f64::consts::TAU);
        let cone = turned(line(at(1.3, 0.2, 0.0), at(0.7, 0.2, 2.0)), 2.0);
        // Twelve times as long as it is wide.
        let rod = turned(line(at(0.37, 0.2, 0.0), at(0.37, 0.2, 12.0)), std::f64::consts::TAU);
        for (name, surface) in [("cylinder", cylinder), ("cone", cone), ("rod", rod)] {
            for word in ["gaussian", "minimum", "maximum"] {
                let (scene, said) = tessellated(surface.clone().into(), json!({ "colors": word })).unwrap();
                let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
                let none = said.contains("curvature 0 everywhere");
                // Seen from one side one principal curvature is none; the other is that of the circles.
                assert!(none || word != "gaussian", "{name} {size:e}: {said}");
                let white = mesh.colors.values().iter().all(|c| c[0] == c[2]);
                assert_eq!(white, none, "{name} {size:e} {word}: {said}");
                let colored = mesh.colors.values().iter().all(|c| (c[0] - c[2]).abs() > 0.02);
                assert!(white || colored, "{name} {size:e} {word}: {said}");
            }
        }
    }
}

/// At a crease each side has its own curvature: nothing of the bent side is blended into the flat one. A surface of degree 2 has jumps between its pieces,
/// so that each triangle has its own.
#[test]
fn a_crease_parts_the_colours() {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cage = || Cage::new((0..8).map(corner).collect(), &faces).unwrap();
    let mut creased = cage();
    for [a, b] in [[4, 5], [5, 7], [7, 6], [6, 4]] {
        creased = creased.with_crease(a, b, 20.0).unwrap();
    }
    let shape = SubdivisionSurface::new(creased).unwrap();
    let fields = json!({ "colors": "mean", "range": [-4, 4] });
    let (scene, said) = tessellated(CustomShape::from(shape).into(), fields.clone()).unwrap();
    let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
    mesh.check().unwrap();
    let corners: Vec<(Point, f64)> = mesh
        .corners()
        .iter()
        .enumerate()
        .map(|(k, &p)| (mesh.points()[p as usize], share(*mesh.colors.at(k, p).unwrap())))
        .collect();
    let (mut flat, mut bent) = (0, 0);
    for triangle in corners.chunks(3) {
        let is_high = |p: &Point| (p.z - 1.0).abs() < 1e-9;
        let is_top = triangle.iter().all(|(p, _)| is_high(p));
        for (p, value) in triangle {
            if is_top {
                assert!((value - 0.5).abs() < 1e-9, "{p} {value} on the flat top: {said}");
                flat += 1;
            } else if is_high(p) {
                assert!((value - 0.5).abs() > 0.01, "{p} {value} below the crease: {said}");
                bent += 1;
            }
        }
    }
    assert!(flat > 100 && bent > 50, "{flat} {bent}");
    let shape = DooSabinSurface::new(cage()).unwrap();
    let (scene, _) = tessellated(CustomShape::from(shape).into(), fields).unwrap();
    let Geometry::Mesh(mesh) = scene.object("s").unwrap().geometry() else { panic!("a mesh") };
    mesh.check().unwrap();
    assert_eq!(mesh.colors.values().len(), 3 * mesh.face_count());
}

#[test]
fn what_has_no_colours_is_told() {
    let line = || Curve::bezier((0..4).map(|i| Point::new(f64::from(i), 2.0, 1.0)).collect()).unwrap();
    for (geometry, fields, words) in [
        (line().into(), json!({ "colors": "mean" }), "a curve has none"),
        (torus(2.0, 0.5).into(), json!({ "range": [0, 1] }), "give \"colors\" too"),
        (torus(2.0, 0.5).into(), json!({ "colors": "mean", "range": [1, 0] }), "the smaller first"),
        (torus(2.0, 0.5).into(), json!({ "colors": "mean", "range": [1] }), "the smaller first"),
        (torus(2.0, 0.5).into(), json!({ "colors": "meen" }), "did you mean \"mean\""),
    ] {
        let error = tessellated(geometry, fields).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}
