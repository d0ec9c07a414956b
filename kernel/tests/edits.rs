//! Edits against answers that we did not compute: the golden cases, the papers' figures, closed forms.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use loftsman_kernel::edit::{Ask, Axis, Constraint, Edit, EditError, Metric, Wanted};
use loftsman_kernel::functional::{
    Functional, Linearity, Rows, Shapes, curvature, derivative, magnitude, orthogonal, position, tangent,
    vertex,
};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, SolveError, Solver, Sparse,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn solvers() -> Vec<std::sync::Arc<dyn Solver>> {
    vec![
        std::sync::Arc::new(Adjoint),
        std::sync::Arc::new(Sparse),
        std::sync::Arc::new(HouseholderQr),
        std::sync::Arc::new(SaddlePoint),
        std::sync::Arc::new(DenseLu),
        std::sync::Arc::new(Automatic),
    ]
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<Point> {
    value.as_array().unwrap().iter().map(|p| Point::from_slice(&numbers(p))).collect()
}

fn curve(value: &Value) -> Curve {
    let (degree, knots) = (value["degree"].as_u64().unwrap() as usize, numbers(&value["knots"]));
    let space =
        if value["periodic"] == true { Space::periodic(degree, knots) } else { Space::open(degree, knots) }
            .unwrap();
    Curve::new(space, points(&value["points"])).unwrap()
}

fn constraint(value: &Value) -> Constraint {
    let at = value["at"].as_f64().unwrap();
    let order = value.get("order").map_or(0, |o| o.as_u64().unwrap() as usize);
    let vector = |v: &Value| Vector::from_vec(numbers(v));
    let functional: std::sync::Arc<dyn Functional> = match value["kind"].as_str().unwrap() {
        "position" => std::sync::Arc::new(position(at)),
        "derivative" => std::sync::Arc::new(derivative(at, order)),
        other => panic!("unknown kind {other}"),
    };
    let wanted = if let Some(to) = value.get("to") {
        Wanted::To(vector(to).into())
    } else if let Some(by) = value.get("by") {
        Wanted::By(vector(by).into())
    } else if let Some(factor) = value.get("scale") {
        Wanted::Scale(factor.as_f64().unwrap())
    } else {
        Wanted::Keep
    };
    Constraint::new(functional, wanted)
}

#[test]
fn golden_edits_with_every_solver() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/edit.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut solved = 0;
    for (number, case) in golden["cases"].as_array().unwrap().iter().enumerate() {
        let before = curve(&case["curve"]);
        let expected = points(&case["points"]);
        let size = expected.iter().chain(before.points()).fold(1.0_f64, |m, p| m.max(p.coords.amax()));
        for solver in solvers() {
            let mut edit =
                Edit::new(&before).lock(case["lock"].as_array().unwrap().iter().map(|v| v.as_i64().unwrap()));
            for c in case["constraints"].as_array().unwrap() {
                edit = edit.ask(constraint(c));
            }
            let name = solver.name().to_owned();
            match edit.solve_with(solver) {
                Ok(edited) => {
                    for (got, want) in edited.shape().points().iter().zip(&expected) {
                        let error = (got - want).norm();
                        let condition = case["condition"].as_f64().unwrap();
                        assert!(
                            error <= 1e-10 * size * condition.max(1.0),
                            "case {number}, {name}: off by {error:e} of {size}"
                        );
                    }
                    let wanted = case["adjustment"].as_f64().unwrap();
                    assert!((edited.report().adjustment - wanted).abs() <= 1e-9 * wanted.max(size));
                    solved += 1;
                }
                Err(EditError::Solve(SolveError::TooLarge { .. })) if name == "adjoint" => {}
                Err(error) => panic!("case {number}, {name}: {error}"),
            }
        }
    }
    assert!(solved >= 38 * 4, "only {solved} golden edits were solved");
}

/// Twelve vertices of theory.md §1.
fn twelve() -> Curve {
    let space = Space::clamped(3, &(0..=9).map(f64::from).collect::<Vec<_>>()).unwrap();
    let points = (0..12)
        .map(|i| Point::new(f64::from(i), (f64::from(i) * 0.9).sin(), 0.1 * f64::from(i % 3)))
        .collect();
    Curve::new(space, points).unwrap()
}

fn moves(before: &Curve, after: &Curve) -> Vec<Vector> {
    before.points().iter().zip(after.points()).map(|(a, b)| b - a).collect()
}

#[test]
fn theory_test_values() {
    let curve = twelve();
    for solver in solvers() {
        let edited = Edit::new(&curve).ask(position(4.5).by([0.0, 1.0, 0.0])).solve_with(solver).unwrap();
        let d = moves(&curve, edited.shape());
        let expected = [
            0.045_283_018_867_924_5,
            1.041_509_433_962_264_1,
            1.041_509_433_962_264_1,
            0.045_283_018_867_924_5,
        ];
        for (i, d) in d.iter().enumerate() {
            if (4..8).contains(&i) {
                assert!((d.y - expected[i - 4]).abs() < 1e-14 && d.x == 0.0 && d.z == 0.0);
            } else {
                assert_eq!(*d, Vector::zeros(), "vertex {i} must move by exactly nothing");
            }
        }
    }
    for solver in solvers() {
        let edited = Edit::new(&curve)
            .ask(position(4.5).keep())
            .ask(derivative(4.5, 1).keep())
            .ask(derivative(4.5, 2).by([0.0, 1.0, 0.0]))
            .solve_with(solver)
            .unwrap();
        let d = moves(&curve, edited.shape());
        for (i, expected) in [23.0 / 24.0, -1.0 / 24.0, -1.0 / 24.0, 23.0 / 24.0].iter().enumerate() {
            assert!((d[4 + i].y - expected).abs() < 1e-13, "{:?}", d[4 + i]);
        }
    }
}

fn kappa(curve: &Curve, u: f64) -> f64 {
    let (a, b) = (curve.derivative(u, 1).unwrap(), curve.derivative(u, 2).unwrap());
    a.cross(&b).norm() / a.norm().powi(3)
}

/// Paper 1, figure 3: (a) tangency varied while position and second derivative are preserved; (b) position varied
/// while curvature, determined by first and second derivatives, is preserved.
#[test]
fn paper_1_figure_3() {
    let (curve, u) = (twelve(), 4.3);
    let a = Edit::new(&curve)
        .ask(position(u).keep())
        .ask(derivative(u, 1).by([0.3, -0.8, 0.0]))
        .ask(derivative(u, 2).keep())
        .solve()
        .unwrap();
    let a = a.shape();
    assert!((a.point(u).unwrap() - curve.point(u).unwrap()).norm() < 1e-14);
    assert!((a.derivative(u, 2).unwrap() - curve.derivative(u, 2).unwrap()).norm() < 1e-13);
    let turned = a.derivative(u, 1).unwrap() - curve.derivative(u, 1).unwrap();
    assert!((turned - Vector::new(0.3, -0.8, 0.0)).norm() < 1e-14);

    let b = Edit::new(&curve)
        .ask(position(u).by([0.0, 0.7, 0.0]))
        .ask(derivative(u, 1).keep())
        .ask(derivative(u, 2).keep())
        .solve()
        .unwrap();
    assert!((kappa(b.shape(), u) - kappa(&curve, u)).abs() < 1e-13);
    // The functional says the same thing without the second derivative along the tangent.
    let c = Edit::new(&curve).ask(position(u).by([0.0, 0.7, 0.0])).ask(curvature(u).keep()).solve().unwrap();
    assert!((kappa(c.shape(), u) - kappa(&curve, u)).abs() < 1e-13);
    assert!(c.report().adjustment <= b.report().adjustment + 1e-12);
}

/// Paper 1, figure 4: at a fixed position and first derivative, (a) curvature varied by moving the second derivative
/// across the first, (b) preserved by moving it along.
#[test]
fn paper_1_figure_4() {
    let (curve, u) = (twelve(), 4.3);
    let first = curve.derivative(u, 1).unwrap();
    for factor in [0.0, 0.5, 2.0, -1.0] {
        let edited = Edit::new(&curve).ask(curvature(u).scale(factor)).solve().unwrap();
        let shape = edited.shape();
        assert!((shape.point(u).unwrap() - curve.point(u).unwrap()).norm() < 1e-14);
        assert!((shape.derivative(u, 1).unwrap() - first).norm() < 1e-13);
        assert!((kappa(shape, u) - factor.abs() * kappa(&curve, u)).abs() < 1e-13);
        // C'' ← C'' + (s - 1) perp(C'')
        let second = curve.derivative(u, 2).unwrap();
        let across = second - first * (first.dot(&second) / first.norm_squared());
        assert!((shape.derivative(u, 2).unwrap() - second - across * (factor - 1.0)).norm() < 1e-12);
    }
    let along = first.normalize() * 0.8;
    let b = Edit::new(&curve)
        .ask(position(u).keep())
        .ask(derivative(u, 1).keep())
        .ask(derivative(u, 2).by(along))
        .solve()
        .unwrap();
    assert!((kappa(b.shape(), u) - kappa(&curve, u)).abs() < 1e-13);
    assert!(b.report().adjustment > 0.1);
}

#[test]
fn tangent_direction_and_magnitude() {
    let (curve, u) = (twelve(), 4.3);
    let turned = Edit::new(&curve)
        .ask(position(u).keep())
        .ask(tangent(u).direction([1.0, 1.0, 0.5]).hold())
        .ask(magnitude(u).keep())
        .solve()
        .unwrap();
    let (old, new) = (curve.derivative(u, 1).unwrap(), turned.shape().derivative(u, 1).unwrap());
    assert!(new.cross(&Vector::new(1.0, 1.0, 0.5)).norm() < 1e-12);
    assert!((new.norm() - old.norm()).abs() < 1e-12);
    assert!(turned.report().iterations > 1);
    let scaled = Edit::new(&curve)
        .ask(position(u).keep())
        .ask(tangent(u).keep())
        .ask(magnitude(u).scale(2.0))
        .solve()
        .unwrap();
    assert!((scaled.shape().derivative(u, 1).unwrap() - old * 2.0).norm() < 1e-11);
    let square = Edit::new(&curve).ask(orthogonal(u, [0.0, 1.0, 0.0]).hold()).solve().unwrap();
    assert!(square.shape().derivative(u, 1).unwrap().y.abs() < 1e-14);
}

#[test]
fn conflicts_are_named_and_redundancy_is_dropped() {
    let curve = twelve();
    let twice = |by: f64| {
        Edit::new(&curve).ask(position(4.5).by([0.0, 1.0, 0.0])).ask(position(4.5).by([0.0, by, 0.0]))
    };
    for solver in solvers() {
        let report = twice(1.0).solve_with(std::sync::Arc::clone(&solver)).unwrap().report().clone();
        assert_eq!((report.rank, report.equations, report.redundant.len()), (3, 6, 1), "{}", solver.name());
        let message = twice(2.0).solve_with(solver).unwrap_err().to_string();
        assert!(
            message.starts_with(
                "\"position at 4.5\" (constraints[0]), \"position at 4.5\" (constraints[1]) cannot all hold; release one"
            ),
            "{message}"
        );
    }
    let effort = twice(2.0).best_effort().solve().unwrap();
    assert!(effort.report().best_effort);
    assert!((effort.shape().point(4.5).unwrap().y - curve.point(4.5).unwrap().y - 1.5).abs() < 1e-13);
    assert!(effort.report().to_string().contains("BEST EFFORT"));
}

/// One axis of what should stand still, asked for something else, leaves the others still.
#[test]
fn an_axis_of_a_companion_lets_go_of_that_axis_only() {
    let curve = twelve();
    let u = 4.3;
    let (at, slope) = (curve.point(u).unwrap(), curve.derivative(u, 1).unwrap());
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        // Eight equations, two more than "adjoint" takes.
        for solver in solvers().into_iter().filter(|solver| solver.name() != "adjoint") {
            let edited = Edit::new(&curve)
                .ask(curvature(u).scale(0.5))
                .ask(position(u).axis(axis).by(0.25))
                .solve_with(solver)
                .unwrap();
            let way = edited.shape().point(u).unwrap() - at;
            assert!((way - Vector::ith(axis as usize, 0.25)).norm() < 1e-13, "{way}");
            assert!((edited.shape().derivative(u, 1).unwrap() - slope).norm() < 1e-12);
            // Two of three axes, told as what they are.
            let still = |c: &&loftsman_kernel::edit::ConstraintReport| c.name.contains(" of position at 4.3");
            assert_eq!(edited.report().constraints.iter().filter(still).count(), 3);
        }
    }
}

#[test]
fn too_few_vertices_suggest_a_knot_that_helps() {
    let curve = twelve();
    // Five positions in one span of a cubic: four vertices.
    let ask = |curve: &Curve| {
        let mut edit = Edit::new(curve);
        for i in 0..5 {
            edit =
                edit.ask(position(4.1 + 0.2 * f64::from(i)).by([0.0, 0.1 * f64::from(i * i * i * i), 0.0]));
        }
        edit
    };
    let error = ask(&curve).solve().unwrap_err();
    let message = error.to_string();
    assert!(message.contains("insert a knot at 4."), "{message}");
    let EditError::Solve(SolveError::Conflict { constraints, knot: Some(knot), text }) = error else {
        panic!("{message}")
    };
    assert!(text.contains(&format!("insert a knot at {knot}: ")) && knot > 4.0 && knot < 5.0, "{text}");
    assert_eq!(constraints.len(), 5);
    assert!(constraints.iter().all(|name| text.contains(name)), "{constraints:?}");
}

#[test]
fn everything_locked_is_a_conflict() {
    let curve = twelve();
    let message =
        Edit::new(&curve).lock(0..12).ask(position(4.5).by([0.0, 1.0, 0.0])).solve().unwrap_err().to_string();
    assert!(message.contains("no control vertex that may move"), "{message}");
    assert!(Edit::new(&curve).lock(0..12).ask(position(4.5).keep()).solve().is_ok());
}

#[test]
fn a_session_drags_adds_removes_and_undoes() {
    let curve = twelve();
    let mut drag =
        Edit::new(&curve).ask(position(0.0).keep()).handle(position(4.5)).prepare(HouseholderQr).unwrap();
    let start = curve.point(4.5).unwrap();
    for i in 1..=10 {
        let target = start + Vector::new(0.0, 0.1 * f64::from(i), 0.0);
        let reached = drag.to_point(target).unwrap().point(4.5).unwrap();
        assert!((reached - target).norm() < 1e-14);
    }
    // Ten events are one: each is an adjustment of the shape at mouse down.
    let once =
        Edit::new(&curve).ask(position(0.0).keep()).ask(position(4.5).by([0.0, 1.0, 0.0])).solve().unwrap();
    for (a, b) in drag.shape().points().iter().zip(once.shape().points()) {
        assert!((a - b).norm() < 1e-13);
    }
    drag.checkpoint();
    let kept = drag.shape().clone();
    let id = drag.add(tangent(4.5).keep()).unwrap();
    drag.to(Value3::from([4.0, 3.0, 0.0])).unwrap();
    let (a, b) = (kept.derivative(4.5, 1).unwrap(), drag.shape().derivative(4.5, 1).unwrap());
    assert!(a.cross(&b).norm() < 1e-12 * a.norm() * b.norm().max(1.0));
    assert!(drag.undo().unwrap());
    for (a, b) in drag.shape().points().iter().zip(kept.points()) {
        assert_eq!(a, b);
    }
    drag.remove(id).unwrap();
    assert!(drag.remove(id).is_err());
    drag.to_point(start).unwrap();
    let edited = drag.commit().unwrap();
    assert_eq!(edited.undo(), curve);
}

use loftsman_kernel::edit::Value as Value3;

#[test]
fn an_edit_does_not_depend_on_axis_or_scale() {
    let curve = twelve();
    let solve = |curve: &Curve, by: Vector| {
        Edit::new(curve)
            .ask(position(2.2).keep())
            .ask(tangent(4.5).keep())
            .ask(position(4.5).by(by))
            .ask(vertex(-1).keep())
            .solve()
            .unwrap()
            .into_shape()
    };
    let plain = solve(&curve, Vector::new(0.1, 1.0, 0.2));
    for scale in [1e-9, 1e-3, 1e9] {
        for turn in 0..3 {
            let map =
                |p: &Point| Point::new(p[turn] * scale, p[(turn + 1) % 3] * scale, p[(turn + 2) % 3] * scale);
            let mapped = Curve::new(curve.space().clone(), curve.points().iter().map(map).collect()).unwrap();
            let by = map(&Point::new(0.1, 1.0, 0.2)).coords;
            for (a, b) in solve(&mapped, by).points().iter().zip(plain.points()) {
                assert!((a - map(b)).norm() <= 1e-12 * scale * 12.0);
            }
        }
    }
    // And not on the scale of the parameter.
    for scale in [1e-9, 1e9] {
        let knots = curve.space().knots().iter().map(|k| k * scale).collect();
        let stretched = Curve::new(Space::open(3, knots).unwrap(), curve.points().to_vec()).unwrap();
        let edited = Edit::new(&stretched)
            .ask(position(2.2 * scale).keep())
            .ask(tangent(4.5 * scale).keep())
            .ask(position(4.5 * scale).by([0.1, 1.0, 0.2]))
            .ask(vertex(-1).keep())
            .solve()
            .unwrap();
        for (a, b) in edited.shape().points().iter().zip(plain.points()) {
            assert!((a - b).norm() <= 1e-11, "{a} {b}");
        }
    }
}

#[test]
fn an_event_that_fails_leaves_the_session_as_it_was() {
    let curve = twelve();
    let mut drag =
        Edit::new(&curve).ask(position(4.5).keep()).handle(position(4.5)).prepare(Automatic).unwrap();
    assert!(drag.to([0.0, 9.0, 0.0]).unwrap_err().to_string().contains("position at 4.5"));
    assert!(drag.to([0.0, f64::NAN, 0.0]).is_err() && drag.to(1.0).is_err());
    assert_eq!(drag.shape(), &curve);
    assert!(drag.report().residual < 1e-14);
    let error = Edit::new(&curve)
        .ask(derivative(4.5, 3).by([0.0, 1.7e308, 0.0]))
        .ask(position(4.5).by([0.0, -1.7e308, 0.0]))
        .solve();
    assert!(error.unwrap_err().to_string().contains("overflows"));
}

#[test]
fn locality_moves_only_so_many_vertices() {
    let curve = twelve();
    for count in 1..=4 {
        let edited =
            Edit::new(&curve).locality(count).ask(position(4.4).by([0.0, 1.0, 0.0])).solve().unwrap();
        let moved = moves(&curve, edited.shape()).iter().filter(|d| d.norm() > 0.0).count();
        assert_eq!(moved, count);
        assert!(
            (edited.shape().point(4.4).unwrap() - curve.point(4.4).unwrap() - Vector::y()).norm() < 1e-13
        );
    }
    assert!(Edit::new(&curve).locality(5).ask(position(4.4).by([0.0, 1.0, 0.0])).solve().is_err());
}

#[test]
fn metrics_agree_with_a_dense_reference() {
    let curve = twelve();
    let n = 12;
    let weights: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
    let weights_matrix = loftsman_kernel::solve::Symmetric::from_entries(
        n,
        weights.iter().enumerate().map(|(i, w)| (i, i, *w)),
    );
    for (name, metric, matrix) in [
        ("weights", Metric::Weights(weights.clone()), weights_matrix),
        ("bend", Metric::Bend, curve.smoothness(2).unwrap()),
        ("stretch", Metric::Stretch, curve.smoothness(1).unwrap()),
    ] {
        // d = W⁻¹Fᵀ(FW⁻¹Fᵀ)⁻¹b, densely.
        let w = nalgebra::DMatrix::from_fn(n, n, |i, j| matrix.entry(i, j));
        let mut f = nalgebra::DMatrix::zeros(2, n);
        for (row, order) in [(0, 0_usize), (1, 1)] {
            for (v, c) in curve.stencil(4.5.into(), order.into()).unwrap().iter() {
                f[(row, v)] = c;
            }
        }
        let inverse = w.clone().cholesky().unwrap().inverse();
        let gram = &f * &inverse * f.transpose();
        let expected = &inverse
            * f.transpose()
            * gram.try_inverse().unwrap()
            * nalgebra::DVector::from_vec(vec![1.0, 0.0]);
        for solver in solvers() {
            let edited = Edit::new(&curve)
                .metric(metric.clone())
                .ask(position(4.5).by([0.0, 1.0, 0.0]))
                .ask(derivative(4.5, 1).keep())
                .solve_with(std::sync::Arc::clone(&solver))
                .unwrap();
            for (d, e) in moves(&curve, edited.shape()).iter().zip(expected.iter()) {
                assert!((d.y - e).abs() < 1e-9, "{name} {}: {} {e}", solver.name(), d.y);
            }
        }
    }
}

#[test]
fn falloff_takes_neighbours_along() {
    let curve = twelve();
    for solver in solvers() {
        let edited = Edit::new(&curve)
            .metric(Metric::Falloff(3.0))
            .lock([3])
            .ask(position(4.5).by([0.0, 1.0, 0.0]))
            .solve_with(std::sync::Arc::clone(&solver))
            .unwrap();
        let d = moves(&curve, edited.shape());
        assert_eq!(d[3], Vector::zeros());
        assert!(d[2].y > 0.0 && d[9].y > 0.0 && d[10] == Vector::zeros() && d[1] == Vector::zeros(), "{d:?}");
        assert!(
            (edited.shape().point(4.5).unwrap() - curve.point(4.5).unwrap() - Vector::y()).norm() < 1e-12
        );
    }
    let ring = Curve::new(
        Space::periodic_uniform(3, 12).unwrap(),
        (0..12).map(|i| Point::new((f64::from(i) * 0.52).cos(), (f64::from(i) * 0.52).sin(), 0.0)).collect(),
    )
    .unwrap();
    let edited =
        Edit::new(&ring).metric(Metric::Falloff(4.0)).ask(position(0.0).by([1.0, 0.0, 0.0])).solve().unwrap();
    assert!((edited.shape().point(12.0).unwrap() - ring.point(0.0).unwrap() - Vector::x()).norm() < 1e-12);
    assert!(
        Edit::new(&ring).metric(Metric::Falloff(7.0)).ask(position(0.0).by([1.0, 0.0, 0.0])).solve().is_err()
    );
}

#[test]
fn axes_can_be_narrowed() {
    let curve = twelve();
    let edited = Edit::new(&curve).ask(position(4.5).to([0.0, 9.0, 0.0]).axis(Axis::Y)).solve().unwrap();
    let d = edited.shape().point(4.5).unwrap() - curve.point(4.5).unwrap();
    assert!((edited.shape().point(4.5).unwrap().y - 9.0).abs() < 1e-13 && d.x == 0.0 && d.z == 0.0);
}

#[test]
fn a_sliding_handle_moves_across_only() {
    let curve = twelve();
    let mut drag = Edit::new(&curve).handle(position(4.5)).sliding().prepare(Automatic).unwrap();
    // Along the curve: the shape does not change.
    let target = curve.point(5.1).unwrap();
    let after = drag.to_point(target).unwrap();
    for (a, b) in after.points().iter().zip(curve.points()) {
        assert!((a - b).norm() < 1e-8, "{a} {b}");
    }
    let lifted = target + Vector::new(0.0, 0.2, 0.3);
    drag.to_point(lifted).unwrap();
    let report = drag.report();
    assert!(report.residual < 1e-12, "{report}");
}

#[test]
fn an_edit_stays_within_its_interval() {
    let curve = twelve();
    for (a, b) in [(4.2, 4.7), (3.5, 6.0), (0.0, 0.4)] {
        let u = 0.5 * (a + b);
        let edited = Edit::new(&curve)
            .within(a, b)
            .ask(position(u).by([0.0, 0.5, 0.0]))
            .ask(tangent(u).keep())
            .solve()
            .unwrap();
        for i in 0..=200 {
            let t = 9.0 * f64::from(i) / 200.0;
            let moved = (edited.shape().point(t).unwrap() - curve.point(t).unwrap()).norm();
            assert!(t > a && t < b || moved < 1e-13, "at {t} outside [{a}, {b}] it moved by {moved}");
        }
        assert!(
            (edited.shape().point(u).unwrap() - curve.point(u).unwrap() - Vector::y() * 0.5).norm() < 1e-12
        );
    }
    assert!(Edit::new(&curve).within(4.0, 4.0).ask(position(4.0).by([0.0, 0.5, 0.0])).solve().is_err());
}

/// The middle of two vertices, a vector whose coordinates are three equations of their own.
#[derive(Debug)]
struct Middle(usize, usize);

impl Functional for Middle {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> loftsman_kernel::error::Result<()> {
        for way in [Vector::x(), Vector::y(), Vector::z()] {
            rows.equation().term(0, self.0, 0.5 * way).term(0, self.1, 0.5 * way);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("the middle of {} and {}", self.0, self.1)
    }

    fn is_vector(&self) -> bool {
        true
    }
}

#[test]
fn one_axis_of_a_vector_of_three_equations() {
    let curve = twelve();
    for solver in solvers() {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let edit = Edit::new(&curve).ask(Middle(4, 7).axis(axis).by(0.3));
            let edited = edit.solve_with(std::sync::Arc::clone(&solver)).unwrap();
            for (k, (p, q)) in curve.points().iter().zip(edited.shape().points()).enumerate() {
                for other in 0..3 {
                    let wanted = if other == axis as usize && (k == 4 || k == 7) { 0.3 } else { 0.0 };
                    assert!((q[other] - p[other] - wanted).abs() < 1e-12, "{axis:?} {k} {other}: {p} {q}");
                }
            }
        }
    }
}
