//! Parameters that float as unknowns of a system: paper 3's equations by Gauß's principle of least constraint, against dense
//! linear algebra.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::collections::BTreeMap;

use crate::smooth::dice::Dice;
use crate::smooth::solvers;
use loftsman_kernel::edit::{Ask, Axis, Edit, Metric, Unknowns};
use loftsman_kernel::functional::{near, position};
use loftsman_kernel::problem::{Assembly, Problem};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{
    Automatic, Factored, HouseholderQr, SolveError, Solver, Sparse, SparseRows, System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::{DMatrix, DVector};

fn rope(dice: &mut Dice, round: usize) -> Curve {
    let (p, n) = (2 + round % 4, 9 + round % 7);
    let space = if round % 3 == 2 {
        Space::periodic(p, (0..=n).map(|k| k as f64).collect()).unwrap()
    } else {
        Space::clamped_uniform(p, n).unwrap()
    };
    let points =
        (0..n).map(|k| Point::new(k as f64, (0.7 * k as f64).sin(), 0.0) + dice.vector(0.3)).collect();
    Curve::new(space, points).unwrap()
}

fn at(curve: &Curve, share: f64) -> f64 {
    let (start, end) = curve.domain();
    start + share * (end - start)
}

/// Two rings that the rope slides through, one of which holds x and y only, and an end that stays.
fn problem(curve: &Curve, metric: Metric) -> Problem {
    let (a, b) = (at(curve, 0.3), at(curve, 0.65));
    Edit::new(curve)
        .smooth(0)
        .metric(metric)
        .ask(position(near(a)).by([0.1, 0.2, -0.1]))
        .ask(position(at(curve, 0.02)).keep())
        .ask(position(near(b)).axis(Axis::X).by(0.05))
        .ask(position(near(b)).axis(Axis::Y).by(-0.1))
        .problem()
        .unwrap()
}

fn dense(rows: &SparseRows) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(rows.len(), rows.width());
    for row in 0..rows.len() {
        rows.iter_row(row).for_each(|(c, v)| all[(row, c)] += v);
    }
    all
}

fn mass(curve: &Curve, bend: bool) -> DMatrix<f64> {
    let n = curve.control_vertices().len();
    let matrix = curve.smoothness(1).unwrap();
    DMatrix::from_fn(3 * n, 3 * n, |i, j| match (bend, i % 3 == j % 3) {
        (true, true) => matrix.entry(i / 3, j / 3),
        (false, true) if i == j => 1.0,
        _ => 0.0,
    })
}

fn solve(assembly: &Assembly, solver: &dyn Solver, rhs: &[f64]) -> Option<(Vec<f64>, Vec<f64>, usize)> {
    let mut factored: Box<dyn Factored> = match solver.factor(assembly.system()) {
        Ok(factored) => factored,
        Err(SolveError::TooLarge { .. } | SolveError::IllConditioned { .. }) => return None,
        Err(error) => panic!("{}: {error}", solver.name()),
    };
    let mut d = vec![f64::NAN; assembly.system().touched().len()];
    let mut multipliers = vec![f64::NAN; rhs.len()];
    factored.solve_into(rhs, &mut d);
    factored.multipliers_into(rhs, &mut multipliers);
    Some((d, multipliers, factored.rank()))
}

#[test]
fn a_step_of_paper_3_is_a_least_adjustment() {
    let mut dice = Dice(3);
    let mut solved = 0;
    for round in 0..60 {
        let curve = rope(&mut dice, round);
        let bend = round % 2 == 1;
        let problem = problem(&curve, if bend { Metric::Stretch } else { Metric::Least });
        for weight in [0.0, 1e-6, 0.3] {
            let assembly = problem.assemble_floating(weight).unwrap();
            let rhs = problem.misfit(&assembly, &problem.shapes()).unwrap();
            let system = assembly.system();
            let n = assembly.vertices().len();
            assert_eq!((assembly.parameters().len(), system.touched().len()), (3, 3 * n + 3));
            assert_eq!(system.free(), if weight == 0.0 { 3 } else { 0 });
            // L and L_s, the latter as the curve's own derivative says it.
            let whole = dense(system.rows());
            let (l, s) = (whole.columns(0, 3 * n).into_owned(), whole.columns(3 * n, 3).into_owned());
            let slope = curve.derivative(at(&curve, 0.3), 1).unwrap();
            (0..3).for_each(|k| assert!((s[(k, 0)] - slope[k]).abs() < 1e-12));
            let own = mass(&curve, bend);
            let places: Vec<usize> =
                assembly.vertices().flat_map(|v| [3 * v, 3 * v + 1, 3 * v + 2]).collect();
            let m = DMatrix::from_fn(3 * n, 3 * n, |i, j| own[(places[i], places[j])]);
            // [M 0 -Lᵀ; 0 ε -L_sᵀ; L L_s 0]
            let c = l.nrows();
            let mut kkt = DMatrix::zeros(3 * n + 3 + c, 3 * n + 3 + c);
            kkt.view_mut((0, 0), (3 * n, 3 * n)).copy_from(&m);
            (0..3).for_each(|k| kkt[(3 * n + k, 3 * n + k)] = weight);
            kkt.view_mut((0, 3 * n + 3), (3 * n, c)).copy_from(&-l.transpose());
            kkt.view_mut((3 * n, 3 * n + 3), (3, c)).copy_from(&-s.transpose());
            kkt.view_mut((3 * n + 3, 0), (c, 3 * n)).copy_from(&l);
            kkt.view_mut((3 * n + 3, 3 * n), (c, 3)).copy_from(&s);
            let mut right = DVector::zeros(3 * n + 3 + c);
            right.rows_mut(3 * n + 3, c).copy_from_slice(&rhs);
            let wanted = kkt.clone().full_piv_lu().solve(&right).unwrap();
            let size = wanted.rows(0, 3 * n + 3).amax();
            for solver in solvers() {
                let Some((d, multipliers, rank)) = solve(&assembly, solver.as_ref(), &rhs) else { continue };
                solved += 1;
                assert_eq!(rank, c, "{}", solver.name());
                let far = (0..d.len()).fold(0.0_f64, |m, i| m.max((d[i] - wanted[i]).abs()));
                assert!(
                    far < 1e-8 * size,
                    "round {round}, ε = {weight}, {}: {far:.1e} of {size:.1e}",
                    solver.name()
                );
                let reach = multipliers.iter().fold(0.0_f64, |m, l| m.max(l.abs()));
                let off = (0..c).fold(0.0_f64, |m, i| m.max((multipliers[i] - wanted[3 * n + 3 + i]).abs()));
                assert!(off < 1e-6 * reach, "{}: multipliers {off:.1e} of {reach:.1e}", solver.name());
            }
        }
    }
    assert!(solved > 900, "{solved}");
}

/// A system of some rows with free columns behind, by hand.
fn system(rows: &[Vec<f64>], free: usize) -> System {
    let width = rows[0].len();
    let mut all = SparseRows::new(width);
    rows.iter().for_each(|row| all.push(row.iter().copied().enumerate().filter(|(_, v)| *v != 0.0)));
    System::new(all, (0..width).collect(), 1, SystemMetric::Least).with_free(free)
}

#[test]
fn what_is_free_meets_what_it_can_and_dependencies_are_those_of_all_columns() {
    // Three rows, the first two of which share one free unknown; the third says what their difference says.
    let rows = vec![
        vec![1.0, 0.0, 0.0, 2.0, 0.0],
        vec![0.0, 1.0, 0.0, 2.0, 0.0],
        vec![1.0, -1.0, 0.0, 0.0, 0.0],
        // Met by its own free unknown alone, whatever is asked.
        vec![0.0, 0.0, 0.0, 0.0, 1e-5],
    ];
    for solver in solvers() {
        let system = system(&rows, 2);
        let mut factored = solver.factor(&system).unwrap();
        let diagnosis = factored.diagnosis();
        assert_eq!((factored.rank(), diagnosis.dependencies.len()), (3, 1), "{}", solver.name());
        let dependency = &diagnosis.dependencies[0];
        let mut implied = [0.0; 5];
        for (row, factor) in &dependency.combination {
            implied.iter_mut().zip(&rows[*row]).for_each(|(i, v)| *i += factor * v);
        }
        assert!(
            implied.iter().zip(&rows[dependency.row]).all(|(a, b)| (a - b).abs() < 1e-12),
            "{dependency:?}"
        );
        let mut d = vec![0.0; 5];
        let rhs = [1.0, 0.5, 0.5, 3.0];
        factored.solve_into(&rhs, &mut d);
        assert!(dependency.agrees(&system, &rhs, &[1.0; 4], &d));
        // Least without the free ones: x₀ - x₁ = ½.
        let wanted = [0.25, -0.25, 0.0, 0.375, 3e5];
        assert!(d.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12 * b.abs().max(1.0)), "{d:?}");
        let denied = [1.0, 0.5, 0.6, 3.0];
        factored.solve_into(&denied, &mut d);
        assert!(!dependency.agrees(&system, &denied, &[1.0; 4], &d), "a contradiction is seen");
    }
    // A free unknown that nothing asks for, and two that do the same: of these only their sum is told.
    let rows = vec![vec![1.0, 1.0, 1.0, 0.0], vec![2.0, -1.0, -1.0, 0.0]];
    let mut factored = HouseholderQr.factor(&system(&rows, 3)).unwrap();
    let mut d = [0.0; 4];
    factored.solve_into(&[3.0, 0.0], &mut d);
    assert_eq!((factored.rank(), d[3]), (2, 0.0));
    assert!((d[0] - 1.0).abs() < 1e-14 && (d[1] + d[2] - 2.0).abs() < 1e-14, "{d:?}");
    // All free.
    let mut factored = Sparse.factor(&system(&[vec![2.0]], 1)).unwrap();
    let mut d = [0.0];
    factored.solve_into(&[3.0], &mut d);
    assert_eq!((factored.rank(), d[0]), (1, 1.5));
}

#[test]
fn where_a_session_comes_to_rest_the_free_parameters_feel_no_force() {
    let mut dice = Dice(9);
    let (mut rested, mut tried) = (0, 0);
    for round in 0..40 {
        let curve = rope(&mut dice, 3 * round);
        let u = at(&curve, 0.45);
        let target = curve.point(u).unwrap() + Vector::new(0.3, 0.4, 0.2);
        let edited = Edit::new(&curve)
            .smooth(0)
            .ask(position(near(u)).to(target))
            .ask(position(at(&curve, 0.0)).keep())
            .solve()
            .unwrap();
        let at_rest = edited.report().constraints[0].location.as_ref().unwrap()[0];
        let (start, end) = curve.domain();
        tried += 1;
        if at_rest <= start || at_rest >= end {
            continue;
        }
        rested += 1;
        let force = &edited.report().constraints[0].multipliers;
        let slope = edited.shape().derivative(at_rest, 1).unwrap();
        let along: f64 = (0..3).map(|k| force[k] * slope[k]).sum();
        let size = slope.norm() * force.iter().map(|f| f * f).sum::<f64>().sqrt();
        assert!(along.abs() < 1e-5 * size, "round {round}: {along:.1e} of {size:.1e}");
    }
    assert!(rested > 30, "{rested} of {tried}");
}

#[test]
fn what_cannot_be_is_said() {
    let curve = rope(&mut Dice(1), 0);
    let problem = problem(&curve, Metric::Least);
    for weight in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(problem.assemble_floating(weight).unwrap_err().to_string().contains("weight"));
    }
    // Unknowns other than vertices have no weight to stand beside, and need none where parameters have none.
    let tied = Edit::new(&curve)
        .through(Unknowns::tied(curve.control_vertices().len(), &[]).unwrap())
        .ask(position(near(at(&curve, 0.3))).by([0.1, 0.2, 0.0]))
        .problem()
        .unwrap();
    assert!(tied.assemble_floating(1.0).unwrap_err().to_string().contains("give it the weight 0"));
    let plain = Edit::new(&curve).ask(position(near(at(&curve, 0.3))).by([0.1, 0.2, 0.0])).problem().unwrap();
    let [tied, plain] = [tied, plain].map(|problem| {
        let assembly = problem.assemble_floating(0.0).unwrap();
        let rhs = problem.misfit(&assembly, &problem.shapes()).unwrap();
        let (d, ..) = solve(&assembly, &Automatic, &rhs).unwrap();
        assembly.system().touched().iter().copied().zip(d).collect::<BTreeMap<_, _>>()
    });
    let way = |of: &BTreeMap<usize, f64>, column: usize| of.get(&column).copied().unwrap_or(0.0);
    assert!(tied.keys().all(|&c| (way(&plain, c) - way(&tied, c)).abs() < 1e-9), "{plain:?}\n{tied:?}");
    let three = SparseRows::per_axis(&{
        let mut rows = SparseRows::new(2);
        rows.push([(0, 1.0), (1, 1.0)]);
        rows
    });
    let three = System::new(three, (0..6).collect(), 3, SystemMetric::Least).with_free(1);
    assert!(Automatic.factor(&three).map(|_| ()).unwrap_err().to_string().contains("one side"));
}

fn with_one_free(rows: &[&[f64]]) -> System {
    let width = rows[0].len();
    let mut all = SparseRows::new(width);
    rows.iter().for_each(|row| all.push(row.iter().copied().enumerate()));
    System::new(all, (0..width).collect(), 1, SystemMetric::Least).with_free(1)
}

/// What a free column leaves of a row that another one repeats is rounding, not a row; and what is left out is made of rows that are
/// kept.
#[test]
fn proportional_rows_and_many_dependent_ones_keep_their_rank() {
    let mut dice = Dice(23);
    for _ in 0..400 {
        let first = [dice.between(0.1, 1.1), dice.between(0.1, 1.1)];
        let factor = dice.between(-2.0, 2.0);
        let second = first.map(|c| c * factor);
        let system = with_one_free(&[&first, &second]);
        for solver in solvers() {
            let mut factored = solver.factor(&system).unwrap();
            assert_eq!(factored.rank(), 1, "{}: {first:?} x {factor}", solver.name());
            assert_eq!(factored.diagnosis().dependencies.len(), 1);
            let mut d = [0.0; 2];
            factored.solve_into(&[1.0, factor], &mut d);
            assert!(d[0].abs() < 1e-9 && (d[1] * first[1] - 1.0).abs() < 1e-9, "{}: {d:?}", solver.name());
        }
    }
    let rows: [&[f64]; 4] = [&[1.0, 2.0], &[3.0, 1.0], &[2.0, 5.0], &[1.0, -1.0]];
    for solver in solvers() {
        let diagnosis = solver.factor(&with_one_free(&rows)).unwrap().diagnosis();
        assert_eq!((diagnosis.rank, diagnosis.dependencies.len()), (2, 2), "{}", solver.name());
        let out: Vec<usize> = diagnosis.dependencies.iter().map(|d| d.row).collect();
        for dependency in &diagnosis.dependencies {
            let mut sum = [0.0; 2];
            for &(row, factor) in &dependency.combination {
                assert!(!out.contains(&row), "{}: {dependency:?}", solver.name());
                (0..2).for_each(|k| sum[k] += factor * rows[row][k]);
            }
            (0..2).for_each(|k| assert!((sum[k] - rows[dependency.row][k]).abs() < 1e-12, "{dependency:?}"));
        }
    }
}
