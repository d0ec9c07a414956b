//! Inequalities: quadratic programs that Clarabel solved, the conditions of Karush, Kuhn and Tucker, and edits with bounds.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Axis, Edit};
use loftsman_kernel::functional::{curvature, derivative, magnitude, position, signed_curvature, vertex};
use loftsman_kernel::solve::{
    Automatic, HouseholderQr, Outcome, Program, Sense, Solver, SparseRows, Symmetric, System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

/// The solution of a program, and the multipliers of all its rows; the rows of the contradiction where there is none.
fn solve(solver: &dyn Solver, program: &Program<'_>) -> Result<(Vec<f64>, Vec<f64>), Vec<usize>> {
    let rows = program.system.rows();
    let active = match solver.program(program).unwrap() {
        Outcome::Active { rows, .. } => rows,
        Outcome::Infeasible { rows } => return Err(rows),
        other => panic!("{other:?}"),
    };
    let mut kept: Vec<usize> = (0..rows.len()).filter(|&r| program.senses[r] == Sense::Equal).collect();
    kept.extend(active);
    kept.sort_unstable();
    let system = program.system.select(&kept);
    let rhs: Vec<f64> = kept.iter().map(|&r| program.rhs[r]).collect();
    let mut factored = solver.factor(&system).unwrap();
    let (mut d, mut some) = (vec![0.0; rows.width()], vec![0.0; kept.len()]);
    factored.solve_into(&rhs, &mut d);
    factored.multipliers_into(&rhs, &mut some);
    let mut multipliers = vec![0.0; rows.len()];
    kept.iter().zip(some).for_each(|(&row, m)| multipliers[row] = m);
    Ok((d, multipliers))
}

fn reached(rows: &SparseRows, d: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; rows.len()];
    rows.multiply(d, 1, &mut out);
    out
}

/// Feasible, `W d = Fᵀλ` with λ of the right sign, and zero where a row has room: then d is the least adjustment (the
/// program is convex), whoever found it.
fn check_optimal(
    program: &Program<'_>,
    metric: Option<&Symmetric>,
    d: &[f64],
    multipliers: &[f64],
    name: &str,
) {
    let rows = program.system.rows();
    let size = d.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
    for (row, value) in reached(rows, d).into_iter().enumerate() {
        let (missing, multiplier) = (program.rhs[row] - value, multipliers[row]);
        let (violation, sign) = match program.senses[row] {
            Sense::Equal => (missing.abs(), 0.0),
            Sense::AtLeast => (missing.max(0.0), multiplier.min(0.0)),
            Sense::AtMost => ((-missing).max(0.0), multiplier.max(0.0)),
        };
        assert!(violation <= 1e-11 * size, "{name}: row {row} is violated by {violation:e}");
        assert!(sign.abs() <= 1e-9 * size, "{name}: row {row} pulls the wrong way, {multiplier:e}");
        assert!((missing * multiplier).abs() <= 1e-9 * size, "{name}: row {row} has room and still pulls");
    }
    let mut gradient = d.to_vec();
    if let Some(metric) = metric {
        metric.multiply(d, 1, &mut gradient);
    }
    for (row, multiplier) in multipliers.iter().enumerate() {
        rows.iter_row(row).for_each(|(column, value)| gradient[column] -= value * multiplier);
    }
    let worst = gradient.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(worst <= 1e-8 * size, "{name}: W d misses Fᵀλ by {worst:e}");
}

#[test]
fn programs_that_clarabel_solved() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/programs.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let numbers =
        |v: &Value| -> Vec<f64> { v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let (mut solved, mut contradicting) = (0, 0);
    for (number, case) in golden["cases"].as_array().unwrap().iter().enumerate() {
        let n = case["n"].as_u64().unwrap() as usize;
        let mut rows = SparseRows::new(n);
        for row in case["rows"].as_array().unwrap() {
            let terms = row.as_array().unwrap().iter().map(numbers).map(|t| (t[0] as usize, t[1]));
            rows.push(terms.collect::<Vec<_>>());
        }
        let senses: Vec<Sense> = case["senses"]
            .as_array()
            .unwrap()
            .iter()
            .map(|s| match s.as_str().unwrap() {
                "=" => Sense::Equal,
                ">" => Sense::AtLeast,
                _ => Sense::AtMost,
            })
            .collect();
        let matrix = (!case["metric"].is_null()).then(|| {
            let (diagonal, beside) = (numbers(&case["metric"][0]), numbers(&case["metric"][1]));
            let beside = beside.into_iter().enumerate().map(|(i, v)| (i + 1, i, v));
            Symmetric::from_entries(n, diagonal.into_iter().enumerate().map(|(i, v)| (i, i, v)).chain(beside))
        });
        let metric = matrix.clone().map_or(SystemMetric::Least, |m| SystemMetric::Matrix(Arc::new(m)));
        let system = System::new(rows, (0..n).collect(), 1, metric);
        let (rhs, size) = (numbers(&case["rhs"]), vec![1.0; senses.len()]);
        let program = Program { system: &system, rhs: &rhs, senses: &senses, size: &size };
        let name = format!("case {number}");
        match (solve(&HouseholderQr, &program), case["d"].is_null()) {
            (Ok((d, multipliers)), false) => {
                let expected = numbers(&case["d"]);
                let size = expected.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
                let worst = d.iter().zip(&expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(worst <= 1e-6 * size, "{name}: off by {worst:e} of {size}");
                check_optimal(&program, matrix.as_ref(), &d, &multipliers, &name);
                solved += 1;
            }
            (Err(rows), true) => {
                irreducible(&program, &rows, &name);
                contradicting += 1;
            }
            (ours, _) => panic!("{name}: ours is {ours:?}, Clarabel's {}", case["d"]),
        }
    }
    assert!(solved >= 20 && contradicting >= 5, "{solved} solved, {contradicting} contradictions");
}

/// The rows cannot all hold; without any one of them, the others can.
fn irreducible(program: &Program<'_>, rows: &[usize], name: &str) {
    let of = |kept: &[usize]| {
        let system = program.system.select(kept);
        let rhs: Vec<f64> = kept.iter().map(|&r| program.rhs[r]).collect();
        // Equations that contradict each other are found by factoring, before there are inequalities.
        let senses: Vec<Sense> = kept.iter().map(|&r| program.senses[r]).collect();
        let size = vec![1.0; kept.len()];
        solve(&HouseholderQr, &Program { system: &system, rhs: &rhs, senses: &senses, size: &size }).is_ok()
    };
    assert!(!of(rows), "{name}: {rows:?} can all hold");
    for leave in 0..rows.len() {
        let others: Vec<usize> =
            rows.iter().enumerate().filter(|(k, _)| *k != leave).map(|(_, r)| *r).collect();
        assert!(
            of(&others),
            "{name}: {rows:?} is not a smallest contradiction, {} can be spared",
            rows[leave]
        );
    }
}

/// A box around 200 coordinates, two of them pulled out of it: 400 bounds, with a bending metric.
#[test]
fn a_large_box_is_optimal_at_every_size() {
    for scale in [1e-9, 1.0, 1e9] {
        let n = 200;
        let band =
            |i: usize| [(0, 6.1), (1, -4.0), (2, 1.0)].map(|(k, v)| i.checked_sub(k).map(|j| (i, j, v)));
        let bend = (0..n).flat_map(band).flatten();
        let matrix = Symmetric::from_entries(n, bend);
        let mut rows = SparseRows::new(n);
        let (mut senses, mut rhs) = (Vec::new(), Vec::new());
        for i in 0..n {
            let wave = (0.7 * i as f64).sin();
            for (sense, b) in [(Sense::AtLeast, 0.3 * wave - 0.25), (Sense::AtMost, 0.3 * wave + 0.05)] {
                rows.push([(i, 1.0)]);
                senses.push(sense);
                rhs.push(b * scale);
            }
        }
        let size: Vec<f64> = rhs.iter().map(|b| b.abs()).collect();
        let metric = SystemMetric::Matrix(Arc::new(matrix.clone()));
        let system = System::new(rows, (0..n).collect(), 1, metric);
        let program = Program { system: &system, rhs: &rhs, senses: &senses, size: &size };
        let (d, multipliers) = solve(&Automatic, &program).unwrap();
        let active = multipliers.iter().filter(|m| **m != 0.0).count();
        assert!(active > 40, "{active}");
        let unit: Vec<f64> = d.iter().map(|v| v / scale).collect();
        let forces: Vec<f64> = multipliers.iter().map(|v| v / scale).collect();
        let rhs: Vec<f64> = rhs.iter().map(|v| v / scale).collect();
        let program = Program { rhs: &rhs, ..program };
        check_optimal(&program, Some(&matrix), &unit, &forces, &format!("scale {scale:e}"));
    }
}

/// Twelve vertices on a wave.
fn wave() -> Curve {
    let space = Space::clamped(3, &(0..=9).map(f64::from).collect::<Vec<_>>()).unwrap();
    let points = (0..12).map(|i| Point::new(f64::from(i), (0.9 * f64::from(i)).sin(), 0.0)).collect();
    Curve::new(space, points).unwrap()
}

#[test]
fn a_curve_stays_above_a_plane() {
    let before = wave();
    let samples: Vec<f64> = (0..=36).map(|k| 0.25 * f64::from(k)).collect();
    let mut edit = Edit::new(&before).ask(position(0.0).keep());
    for &u in &samples {
        edit = edit.ask(position(u).axis(Axis::Y).at_least(-0.3));
    }
    let edited = edit.solve().unwrap();
    let report = edited.report();
    for &u in &samples {
        let y = edited.shape().point(u).unwrap().y;
        assert!(y >= -0.3 - 1e-13, "{y} at {u}");
    }
    assert!(!report.active.is_empty() && report.residual < 1e-13, "{report}");
    assert!(report.active[0].contains("y of position at") && report.active[0].contains("≥ -0.3"), "{report}");
    for constraint in report.constraints.iter().filter(|c| c.name.contains('≥')) {
        let active = report.active.contains(&constraint.name);
        assert_eq!(constraint.multipliers.len(), 1, "{}", constraint.name);
        assert!(if active { constraint.multipliers[0] > 0.0 } else { constraint.multipliers[0] == 0.0 });
    }
    // x and z are not asked of: they stay, and so does a curve that is in bounds already.
    assert!(before.points().iter().zip(edited.shape().points()).all(|(a, b)| a.x == b.x && a.z == b.z));
    let low = Edit::new(&before).ask(position(4.0).at_least([-9.0; 3])).solve().unwrap();
    assert_eq!(low.report().adjustment, 0.0);
    assert!(low.report().active.is_empty());
}

#[test]
fn bounds_hold_through_a_drag_and_let_go() {
    let before = wave();
    let mut session = Edit::new(&before)
        .ask(position(2.0).at_most([100.0, 1.0, 0.5]))
        .ask(position(6.0).keep())
        .ask(derivative(4.5, 1).axis(Axis::Y).at_most(1.0))
        .handle(position(3.0))
        .prepare(Automatic)
        .unwrap();
    let mut touched = 0;
    for k in 0..20 {
        let height = 0.25 * f64::from(k);
        let shape = session.to_point(Point::new(3.0, height, 0.2)).unwrap();
        assert!((shape.point(3.0).unwrap() - Point::new(3.0, height, 0.2)).amax() < 1e-12);
        assert!(shape.point(2.0).unwrap().y <= 1.0 + 1e-12);
        assert!(shape.derivative(4.5, 1).unwrap().y <= 1.0 + 1e-12);
        assert!((shape.point(6.0).unwrap() - before.point(6.0).unwrap()).amax() < 1e-12);
        touched += usize::from(!session.report().active.is_empty());
    }
    assert!(touched > 5 && touched < 20, "{touched} of 20 events touched a bound");
    // Back where it was: nothing is left of the bounds.
    let start = before.point(3.0).unwrap();
    let back = session.to_point(start).unwrap();
    assert!(before.points().iter().zip(back.points()).all(|(a, b)| (a - b).amax() < 1e-12));
    let id = session.add(position(3.0).axis(Axis::X).at_least(0.0)).unwrap();
    session.to_point(start).unwrap();
    session.remove(id).unwrap();
}

#[test]
fn a_contradiction_is_named_with_all_that_is_in_it_and_nothing_else() {
    let before = wave();
    let mut session = Edit::new(&before)
        .ask(position(8.0).keep())
        .ask(position(4.0).axis(Axis::Y).at_least(2.0))
        .ask(position(4.0).axis(Axis::Y).at_most(1.0))
        .ask(position(1.0).axis(Axis::Y).at_most(5.0))
        .prepare(Automatic)
        .unwrap();
    let message = session.apply().unwrap_err().to_string();
    assert!(
        message.contains("y of position at 4 ≥ 2") && message.contains("y of position at 4 ≤ 1"),
        "{message}"
    );
    assert!(!message.contains("at 8") && !message.contains("at 1 "), "{message}");
    assert_eq!(session.shape(), &before, "nothing moved");
    let locked = Edit::new(&before)
        .lock(0..12)
        .ask(position(4.0).axis(Axis::Y).at_least(2.0))
        .solve()
        .unwrap_err()
        .to_string();
    assert!(locked.contains("unlock"), "{locked}");
    // Against an equation, and a vertex against the box that its curve must be in.
    let equation = Edit::new(&before)
        .ask(position(4.0).by([0.0, 0.0, 0.0]))
        .ask(position(4.0).axis(Axis::Y).at_least(2.0))
        .solve()
        .unwrap_err()
        .to_string();
    assert!(equation.contains("\"position at 4\"") && equation.contains("≥ 2"), "{equation}");
    let inside = Edit::new(&before)
        .ask(vertex(5).at_least([4.0, 0.5, 0.0]))
        .ask(vertex(5).at_most([4.5, 0.75, 1.0]))
        .solve()
        .unwrap();
    let at = inside.shape().points()[5];
    assert!((at - Point::new(4.5, 0.5, 0.0)).amax() < 1e-14, "{at}");
}

#[test]
fn a_curve_turns_one_way_at_its_samples() {
    let before = wave();
    let samples: Vec<f64> = (1..36).map(|k| 0.25 * f64::from(k)).collect();
    let mut edit = Edit::new(&before).ask(position(0.0).keep()).ask(position(9.0).keep());
    for &u in &samples {
        edit = edit.ask(signed_curvature(u, [0.0, 0.0, 1.0]).at_most(0.0));
    }
    let edited = edit.solve().unwrap();
    let report = edited.report();
    for &u in &samples {
        let (a, b) = (edited.shape().derivative(u, 1).unwrap(), edited.shape().derivative(u, 2).unwrap());
        let bend = a.cross(&b).z / a.norm().powi(3);
        assert!(bend <= 1e-10, "it turns {bend:e} at {u}");
    }
    let convergence = report.convergence.expect("it is not linear");
    assert!(report.iterations > 1 && convergence.change <= 1e-7, "{convergence:?}");
    assert!(!report.active.is_empty());
}

/// Far from where the constraint was linearized: the tangent is asked to shrink to a hundredth and to grow a hundredfold.
#[test]
fn steps_that_overshoot_are_shortened_and_arrive() {
    let before = wave();
    for factor in [0.01, 0.1, 0.3, 3.0, 30.0, 100.0] {
        let edited = Edit::new(&before)
            .ask(position(4.3).keep())
            .ask(position(5.6).axis(Axis::Y).at_least(0.0))
            .ask(magnitude(4.3).scale(factor))
            .solve()
            .unwrap();
        let speed = |c: &Curve| c.derivative(4.3, 1).unwrap().norm();
        let wanted = factor * speed(&before);
        assert!((speed(edited.shape()) - wanted).abs() < 1e-11 * wanted.max(1.0), "{factor}");
        // The least adjustment: its gradient W d is a combination of the constraints'.
        assert!(edited.report().residual < 1e-9, "{}", edited.report());
    }
}

#[test]
fn what_cannot_converge_is_an_error_and_changes_nothing() {
    let before = wave();
    let mut session = Edit::new(&before)
        .ask(position(4.3).keep())
        .ask(magnitude(4.3).at_most(0.5))
        .ask(magnitude(4.3).at_least(0.75))
        .prepare(Automatic)
        .unwrap();
    let message = session.apply().unwrap_err().to_string();
    assert!(message.contains("tangent magnitude at 4.3"), "{message}");
    assert_eq!(session.shape(), &before);
}

#[test]
fn a_curvature_can_be_bounded() {
    let before = wave();
    let turn = |c: &Curve| {
        let (first, second) = (c.derivative(2.0, 1).unwrap(), c.derivative(2.0, 2).unwrap());
        (second - first * (first.dot(&second) / first.norm_squared())) / first.norm_squared()
    };
    let old = turn(&before);
    // No companions: position and tangent are free, and the curvature in the plane in which the curve turns is bounded, and
    // that across it.
    let edited = Edit::new(&before)
        .ask(position(2.0).by([0.0, -0.4, 0.0]))
        .ask(curvature(2.0).at_least([1.5 * old.norm(), -1e-9]))
        .solve()
        .unwrap();
    let new = turn(edited.shape());
    // The curve lies in a plane, and so do its curvature vectors.
    assert!(new.norm() >= 1.5 * old.norm() - 1e-12 && old.z == 0.0 && new.z.abs() < 1e-9, "{new} {old}");
    let first = |c: &Curve| c.derivative(2.0, 1).unwrap().normalize();
    let (before_turned, after_turned) = (first(&before).cross(&old).z, first(edited.shape()).cross(&new).z);
    assert!(before_turned * after_turned > 0.0, "to the same side");
    assert!(
        (edited.shape().point(2.0).unwrap() - before.point(2.0).unwrap() - Vector::new(0.0, -0.4, 0.0))
            .amax()
            < 1e-13
    );
}
