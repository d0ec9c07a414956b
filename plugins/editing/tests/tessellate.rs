//! `tessellate` of what loops bound.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_editing::Editing;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Context, OperationError, Parameters, Registry, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Tessellation;
use serde_json::{Value, json};
use std::collections::BTreeMap;

fn run(scene: &mut Scene, parameters: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Editing);
    registry.add(&Tessellation);
    let operation = registry.find_operation("tessellate", "step[0].op")?.clone();
    let parameters = Parameters::new(parameters, "step[0]")?;
    parameters.check(operation.declaration().fields)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn of(geometry: Geometry) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("it", geometry)).unwrap();
    scene
}

fn mesh(scene: &Scene) -> Mesh {
    let Geometry::Mesh(mesh) = scene.object("it").unwrap().geometry() else { panic!("no mesh") };
    mesh.clone()
}

/// The sum of the triangles' vectors' lengths, and the volume they bound.
fn measured(mesh: &Mesh) -> (f64, f64) {
    let corner = |k: u32| mesh.points()[k as usize].coords;
    mesh.faces().fold((0.0, 0.0), |(area, volume), face| {
        let [a, b, c] = [0, 1, 2].map(|k| corner(face[k]));
        let normal: Vector = (b - a).cross(&(c - a));
        (area + 0.5 * normal.norm(), volume + a.dot(&normal) / 6.0)
    })
}

#[test]
fn a_solid_becomes_a_mesh_that_closes_with_the_colours_of_its_faces() {
    let block = Brep::block(Point::new(-1.0, 0.0, 2.0), Point::new(2.0, 2.0, 3.0)).unwrap();
    let mut parts = block.parts();
    parts.faces[1].color = Some([1.0, 0.0, 0.0, 1.0]);
    let mut scene = of(Brep::new(parts).unwrap().into());
    let report = run(&mut scene, json!({})).unwrap();
    assert!(report.warnings.is_empty() && report.notes[0] == "12 triangles", "{report:?}");
    assert!(report.notes[1].starts_with("nowhere off the shape ("), "{report:?}");
    let mesh = mesh(&scene);
    let (area, volume) = measured(&mesh);
    assert!((area - 22.0).abs() < 1e-12 && (volume - 6.0).abs() < 1e-12, "{area} {volume}");
    let mut sides: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for face in mesh.faces() {
        (0..3).for_each(|k| *sides.entry([face[k], face[(k + 1) % 3]]).or_default() += 1);
    }
    assert!(sides.iter().all(|([a, b], count)| *count == 1 && sides.contains_key(&[*b, *a])));
    let red = (0..12).filter(|face| mesh.colors.at(*face * 3, 0) == Some(&[1.0, 0.0, 0.0, 1.0]));
    assert_eq!(red.count(), 2);
}

#[test]
fn a_trimmed_surface_becomes_what_its_loops_leave() {
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let at = |x: f64, y: f64| Point::new(x, y, 0.0);
    let net = vec![at(0.0, 0.0), at(0.0, 1.0), at(1.0, 0.0), at(1.0, 1.0)];
    let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
    let side =
        |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 3]).unwrap()).unwrap();
    let outer = (0..3).map(side).collect();
    let surface = Surface::new(line(), line(), net).unwrap();
    let trimmed =
        Trimmed::new(surface, vec![Region { outer, holes: Vec::new() }], Vec::new(), Vec::new()).unwrap();
    let mut scene = of(trimmed.into());
    run(&mut scene, json!({})).unwrap();
    assert!((measured(&mesh(&scene)).0 - 0.5).abs() < 1e-13);
}

#[test]
fn curvature_as_colours_is_refused_where_no_mesh_takes_it() {
    let block = Brep::block(Point::origin(), Point::new(1.0, 1.0, 1.0)).unwrap();
    let mut scene = of(block.into());
    let before = scene.clone();
    let error = run(&mut scene, json!({ "colors": "mean" })).unwrap_err().to_string();
    assert!(error.contains("colors") && error.contains("faces"), "{error}");
    assert_eq!(scene, before);
}

/// What is told is no less than the closed form, and no more than was asked for: of a circle the sagitta of its segments, of a ball the depth of the
/// deepest triangle below it.
#[test]
fn how_far_it_is_at_most_is_told() {
    for (radius, unit, name) in [(2.0, Unit::Millimetre, " mm"), (3000.0, Unit::Unknown, " units")] {
        let ring = Curve::circle(Point::new(radius, 0.0, 0.0), Vector::z(), radius).unwrap();
        let half =
            Curve::arc(Point::new(0.0, 0.0, -radius), Point::origin(), Vector::y(), -std::f64::consts::PI);
        let ball =
            Surface::revolution(&half.unwrap(), Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
        for geometry in [Geometry::from(ring), Geometry::from(ball)] {
            let is_curve = matches!(geometry, Geometry::Curve(_));
            let mut scene = of(geometry);
            scene.unit = unit;
            let report = run(&mut scene, json!({ "tolerance": 0.01 * radius, "angle": 170 })).unwrap();
            let said = |name: &str| report.numbers[name].as_f64().unwrap();
            let deepest = match scene.object("it").unwrap().geometry() {
                Geometry::Polyline(line) => {
                    let ends = line.points.iter().zip(line.points.iter().cycle().skip(1));
                    let middles = ends.map(|(p, q)| middle(p, q) - Vector::new(radius, 0.0, 0.0));
                    middles.map(|m| radius - m.coords.norm()).fold(0.0, f64::max)
                }
                Geometry::Mesh(mesh) => {
                    let corner = |k: u32| mesh.points()[k as usize].coords;
                    let planes = mesh.faces().filter_map(|face| {
                        let [a, b, c] = [0, 1, 2].map(|k| corner(face[k]));
                        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
                        Some(radius - ((a + b + c) / 3.0).norm().max(normal.dot(&a).abs()))
                    });
                    planes.fold(0.0, f64::max)
                }
                other => panic!("{}", other.kind()),
            };
            let (deviation, tolerance) = (said("deviation"), said("tolerance"));
            assert!(deepest > 0.2 * tolerance, "{deepest}: {report:?}");
            assert!(deepest <= deviation * (1.0 + 1e-9), "{deepest}: {report:?}");
            assert!(deviation <= tolerance && tolerance == 0.01 * radius, "{report:?}");
            if is_curve {
                assert!(deviation < 1.1 * deepest, "{deepest}: {report:?}");
            }
            let note = &report.notes[1];
            let wanted = format!("within {} of the shape everywhere", unit.quantity(deviation, 1));
            assert!(note.starts_with(&wanted) && note.contains(name), "{report:?}");
            assert_eq!(report.numbers["certified"], true);
        }
    }
}

fn middle(p: &Point, q: &Point) -> Point {
    Point::from(0.5 * (p.coords + q.coords))
}
