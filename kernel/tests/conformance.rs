//! Our own solvers and functionals pass the suites that others run.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_kernel::conformance::{
    declaration_conformance, functional_conformance, sample_shapes, solver_conformance,
};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{self, ShapeNames};
use loftsman_kernel::plugin::{Parameters, Registry};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Solver, Sparse};
use serde_json::json;

#[test]
fn every_solver() {
    let solvers: [&dyn Solver; 6] = [&Adjoint, &Sparse, &SaddlePoint, &HouseholderQr, &DenseLu, &Automatic];
    for solver in solvers {
        let verdict = solver_conformance(solver);
        assert!(verdict.passed(), "{}: {verdict}", solver.name());
        assert!(verdict.checks > 500 || solver.name() == "adjoint", "{}: {}", solver.name(), verdict.checks);
    }
}

struct Two;

impl ShapeNames for Two {
    fn shape(&mut self, _: &str) -> Result<usize, Error> {
        Ok(1)
    }
}

/// Parameters for every kind that is registered; a new kind without an entry here fails the test.
fn samples(kind: &str) -> Vec<(bool, serde_json::Value)> {
    match kind {
        "position" => vec![
            (false, json!({ "at": 0.9 })),
            (true, json!({ "at": [0.9, 1.3] })),
            (false, json!({ "near": 0.9 })),
            (true, json!({ "near": [0.9, 1.3] })),
        ],
        "derivative" => vec![
            (false, json!({ "at": 0.9, "order": 3 })),
            (false, json!({ "near": 0.9, "order": 1 })),
            (true, json!({ "at": [0.9, 1.3], "order": [1, 1] })),
        ],
        "tangent" => {
            vec![
                (false, json!({ "at": 0.9 })),
                (false, json!({ "at": 0.9, "direction": [1, 2, 3] })),
                (false, json!({ "near": 0.9 })),
                (false, json!({ "near": 0.9, "direction": [1, 2, 3] })),
            ]
        }
        "magnitude" | "curvature" => vec![(false, json!({ "at": 0.9 }))],
        "signed-curvature" => {
            vec![(false, json!({ "at": 0.9 })), (false, json!({ "at": 0.9, "normal": [1, 2, 3] }))]
        }
        "orthogonal" => vec![
            (false, json!({ "at": 0.9, "to": [1, 2, 3] })),
            (false, json!({ "near": 0.9, "to": [1, 2, 3] })),
        ],
        "normal" => vec![
            (true, json!({ "at": [0.9, 1.3], "to": [1, 2, 3] })),
            (true, json!({ "near": [0.9, 1.3], "to": [1, 2, 3] })),
        ],
        "vertex" => vec![(false, json!({ "index": -1 })), (true, json!({ "index": 4 }))],
        "linear" => vec![(
            false,
            json!({ "terms": [{ "vertex": 0, "vector": [1, 2, 3] }, { "vertex": -1, "vector": [0, 1, 0] }] }),
        )],
        "join" => vec![
            (false, json!({ "at": 1.9, "with": { "object": "b", "at": 0.2 }, "continuity": 2 })),
            (true, json!({ "at": "v1", "with": { "object": "b", "at": "v0" }, "continuity": 1 })),
        ],
        // Needs a symmetric shape: tested with one below.
        "symmetry" => Vec::new(),
        other => panic!("the kind \"{other}\" has no sample: add one"),
    }
}

#[test]
fn every_registered_functional() {
    let mut registry = Registry::new();
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let kinds: Vec<_> = registry.functionals().map(|d| d.name).collect();
    assert!(kinds.len() >= 12);
    for declaration in registry.functionals() {
        // Conditions of whose direction the field is called `to`.
        let condition = ["orthogonal", "normal"].contains(&declaration.name);
        let verdict = declaration_conformance(&declaration, condition);
        assert!(verdict.passed(), "{verdict}");
    }
    let mut checks = 0;
    for kind in kinds {
        for (surfaces, fields) in samples(kind) {
            let parameters = Parameters::new(fields, "test").unwrap();
            let functional = registry.build_functional(kind, &parameters, &mut Two).unwrap();
            for shape in sample_shapes(surfaces) {
                let shapes: Vec<Box<dyn Shape>> = vec![shape.boxed(), shape];
                let verdict = functional_conformance(functional.as_ref(), &shapes);
                assert!(verdict.passed(), "{verdict}");
                checks += verdict.checks;
            }
        }
    }
    assert!(checks > 1000, "only {checks} checks");
}

/// Curvature beside a first derivative that changes, on curves whose tangent is another one than where it was bound: a
/// little turned, out of the plane, and right round.
#[test]
fn curvature_where_the_tangent_turns() {
    use loftsman_kernel::functional::{Functional, Shapes, curvature};
    use loftsman_kernel::{Point, Vector};
    let turns = [(0.0, 1.0), (0.6, 1.0), (1.5, 1.0), (2.5, 1.0), (std::f64::consts::PI, 1.0), (0.0, -1.0)];
    for shape in sample_shapes(false) {
        for place in [0.1, 0.9, 1.9] {
            let bound = curvature(place).alone().bind(&Shapes::one(shape.as_ref())).unwrap().unwrap();
            for axis in [Vector::z(), Vector::new(1.0, 2.0, -0.5).normalize()] {
                for (angle, mirror) in turns {
                    let rotation = nalgebra::Rotation3::from_scaled_axis(axis * angle);
                    let mut other = shape.boxed();
                    for p in other.control_vertices_mut() {
                        *p = Point::from(rotation * p.coords * mirror * 1.3);
                    }
                    let verdict = functional_conformance(bound.as_ref(), &[other]);
                    assert!(verdict.passed() && verdict.checks > 30, "{place} {angle} {mirror}: {verdict}");
                }
            }
        }
    }
}

#[test]
fn symmetry_on_a_symmetric_shape() {
    use loftsman_kernel::Point;
    use loftsman_kernel::spline::{Curve, Space};
    let points = (0..7).map(|i| Point::new(f64::from(i) - 3.0, f64::from((i - 3) * (i - 3)), 0.5)).collect();
    let arch = Curve::new(Space::clamped_uniform(3, 7).unwrap(), points).unwrap();
    let symmetry = functional::symmetry([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]);
    let verdict = functional_conformance(&symmetry, &[Box::new(arch)]);
    assert!(verdict.passed() && verdict.checks > 80, "{verdict}");
}

#[test]
fn shared_solvers_are_solvers() {
    let shared: Arc<dyn Solver> = Arc::new(Automatic);
    assert_eq!(shared.name(), "automatic");
    assert!(solver_conformance(&shared).passed());
}
