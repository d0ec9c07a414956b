//! Least adjustments against dense linear algebra: `tests/golden/edits.json`, made by `edits.py` beside it.

use std::sync::Arc;

use loftsman_kernel::edit::{Axis, Constraint, Edit, EditError, Metric, Wanted};
use loftsman_kernel::functional::{Functional, derivative, linear, orthogonal, position, tangent, vertex};
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, SolveError, Solver, Sparse,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

fn vector(value: &Value) -> Vector {
    Vector::from_column_slice(&numbers(value))
}

fn list<'a>(value: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    value[name].as_array().unwrap().iter()
}

fn curve(value: &Value) -> Curve {
    let (degree, knots) = (value["degree"].as_u64().unwrap() as usize, numbers(&value["knots"]));
    let periodic = value["periodic"] == true;
    let space = if periodic { Space::periodic(degree, knots) } else { Space::open(degree, knots) };
    let points = list(value, "points").map(|p| Point::from(vector(p))).collect();
    Curve::build(space.unwrap(), points, value.get("weights").map(numbers)).unwrap()
}

fn constraint(value: &Value) -> Constraint {
    let at = || value["at"].as_f64().unwrap();
    let kind = value["kind"].as_str().unwrap();
    let functional: Arc<dyn Functional> = match kind {
        "position" => Arc::new(position(at())),
        "derivative" => Arc::new(derivative(at(), value["order"].as_u64().unwrap() as usize)),
        "vertex" => Arc::new(vertex(value["index"].as_i64().unwrap())),
        "tangent" => Arc::new(tangent(at()).direction(vector(&value["direction"]))),
        "orthogonal" => Arc::new(orthogonal(at(), vector(&value["to"]))),
        "linear" => Arc::new(linear(
            list(value, "terms").map(|t| (t["vertex"].as_i64().unwrap(), vector(&t["vector"]))),
        )),
        other => panic!("unknown kind {other}"),
    };
    let axis = value.get("axis").map(|axis| match axis.as_str().unwrap() {
        "x" => Axis::X,
        "y" => Axis::Y,
        _ => Axis::Z,
    });
    let amount = |name: &str| value.get(name).map(|v| loftsman_kernel::edit::Value(numbers(v)));
    let wanted = match (kind, amount("by")) {
        ("tangent" | "orthogonal", _) => Wanted::Hold,
        (_, Some(by)) => Wanted::By(by),
        _ => amount("to").map_or(Wanted::Keep, Wanted::To),
    };
    let constraint = Constraint::new(functional, wanted);
    axis.into_iter().fold(constraint, Constraint::axis)
}

/// Solves every case; how many the solver took. Only too large or too ill-conditioned a system may be refused.
fn check(solver: &Arc<dyn Solver>) -> usize {
    let golden: Value = serde_json::from_str(include_str!("../golden/edits.json")).unwrap();
    let mut solved = 0;
    for (number, case) in list(&golden, "cases").enumerate() {
        let before = curve(&case["curve"]);
        let locked = list(case, "lock").map(|v| v.as_i64().unwrap());
        let edit = Edit::new(&before).lock(locked);
        let edit = list(case, "constraints").map(constraint).fold(edit, Edit::ask);
        let edited = match edit.solve_with(Arc::clone(solver)) {
            Ok(edited) => edited,
            Err(EditError::Solve(SolveError::TooLarge { .. } | SolveError::IllConditioned { .. })) => {
                continue;
            }
            Err(error) => panic!("case {number}, {}: {error}", solver.name()),
        };
        solved += 1;
        let mut expected = before.points().to_vec();
        for moved in list(case, "points").map(numbers) {
            expected[moved[0] as usize] = Point::new(moved[1], moved[2], moved[3]);
        }
        let size = expected.iter().map(|p| p.coords.amax()).fold(1.0, f64::max);
        for (i, (got, want)) in edited.shape().points().iter().zip(&expected).enumerate() {
            let error = (got - want).amax();
            assert!(
                error <= 1e-9 * size,
                "case {number}, {}, vertex {i}: {got:?} is not {want:?}: {error:e}",
                solver.name()
            );
        }
        let (adjustment, wanted) = (edited.report().adjustment, case["adjustment"].as_f64().unwrap());
        assert!((adjustment - wanted).abs() <= 1e-9 * wanted, "case {number}: {adjustment} is not {wanted}");
    }
    solved
}

#[test]
fn every_solver_agrees_with_dense_linear_algebra() {
    assert_eq!(check(&(Arc::new(Sparse) as _)), 300);
    assert_eq!(check(&(Arc::new(HouseholderQr) as _)), 300);
    assert_eq!(check(&(Arc::new(DenseLu) as _)), 300);
    assert_eq!(check(&(Arc::new(Automatic) as _)), 300);
    // The adjoint takes up to six equations.
    assert!(check(&(Arc::new(Adjoint) as _)) > 150);
}

/// Weights, falloff, stretch and bend against matrices made from their definitions: `metrics.json`, by `metrics.py`.
#[test]
fn every_solver_agrees_in_other_metrics_too() {
    let golden: Value = serde_json::from_str(include_str!("../golden/metrics.json")).unwrap();
    let solvers: [Arc<dyn Solver>; 6] = [
        Arc::new(Sparse),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
        Arc::new(Automatic),
        Arc::new(Adjoint),
    ];
    let mut solved = 0;
    for (number, case) in list(&golden, "cases").enumerate() {
        let before = curve(&case["curve"]);
        let metric = match case["metric"].as_str() {
            Some("stretch") => Metric::Stretch,
            Some("bend") => Metric::Bend,
            _ => match case["metric"].get("falloff") {
                Some(radius) => Metric::Falloff(radius.as_f64().unwrap()),
                None => Metric::Weights(numbers(&case["metric"]["weights"])),
            },
        };
        for solver in &solvers {
            let edit = Edit::new(&before).metric(metric.clone());
            let edit = edit.lock(list(case, "lock").map(|v| v.as_i64().unwrap()));
            let edit = list(case, "constraints").map(constraint).fold(edit, Edit::ask);
            let edited = edit.solve_with(Arc::clone(solver));
            let edited = edited.unwrap_or_else(|e| panic!("case {number}, {}: {e}", solver.name()));
            let expected: Vec<Vector> = list(case, "points").map(vector).collect();
            let size = expected.iter().map(Vector::amax).fold(1.0, f64::max);
            for (i, (got, want)) in edited.shape().points().iter().zip(&expected).enumerate() {
                let error = (got.coords - want).amax();
                let (metric, name) = (&case["metric"], solver.name());
                assert!(error <= 1e-9 * size, "case {number} ({metric}), {name}, vertex {i}: {error:e}");
            }
            solved += 1;
        }
    }
    assert_eq!(solved, 128 * solvers.len());
}
