//! Unknowns that are not control vertices, against a dense evaluator of the same conditions; and constraints that reach other
//! vertices on the way.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Edit, EditError, Metric, Tie, Unknowns};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{
    Functional, Linearity, Rows, Shapes, derivative, magnitude, position, vertex,
};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, HouseholderQr, Operator, SaddlePoint, SolveError, Solver, Sparse,
    SparseRows, Symmetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::{DMatrix, DVector, Matrix3};

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Adjoint),
        Arc::new(Sparse),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
    ]
}

fn curve(random: &mut Random) -> Curve {
    let degree = [1, 2, 3, 3, 4, 5, 7][random.below(7)];
    let count = degree + 3 + random.below(12);
    let space = match random.below(3) {
        0 => Space::clamped_uniform(degree, count).unwrap(),
        1 => Space::floating_uniform(degree, count).unwrap(),
        _ => Space::periodic(degree, (0..=count).map(|i| i as f64 + 0.4 * (i % 3) as f64).collect()).unwrap(),
    };
    let points: Vec<Point> = (0..space.len())
        .map(|i| {
            Point::new(
                i as f64 + random.between(-0.3, 0.3),
                random.between(-1.0, 1.0),
                random.between(-1.0, 1.0),
            )
        })
        .collect();
    if random.below(3) == 0 {
        let weights = (0..points.len()).map(|_| random.between(0.3, 3.0)).collect();
        return Curve::rational(space, points, weights).unwrap();
    }
    Curve::new(space, points).unwrap()
}

/// A parameter of the domain.
fn at(curve: &Curve, share: f64) -> f64 {
    let (start, end) = curve.domain();
    start + share * (end - start)
}

/// The rows of positions, over coordinates.
fn rows(curve: &Curve, places: &[f64]) -> DMatrix<f64> {
    let n = curve.control_vertices().len();
    let mut rows = DMatrix::zeros(3 * places.len(), 3 * n);
    for (k, &u) in places.iter().enumerate() {
        let stencil = curve.stencil(Location::Curve(u), Derivative::POSITION).unwrap();
        for (vertex, c) in stencil.iter() {
            (0..3).for_each(|axis| rows[(3 * k + axis, 3 * vertex + axis)] += c);
        }
    }
    rows
}

/// `B x` with `xᵀMx` least under `F B x = b`, by a singular value decomposition of `F B M^(-1/2)`.
fn dense(b: &DMatrix<f64>, m: &DMatrix<f64>, f: &DMatrix<f64>, rhs: &DVector<f64>) -> DVector<f64> {
    let half = m.clone().cholesky().unwrap().l();
    let back = half.transpose().try_inverse().unwrap();
    let e = (f * b * &back).svd(true, true).solve(rhs, 1e-10).unwrap();
    b * back * e
}

fn adjustment(before: &Curve, after: &Curve) -> DVector<f64> {
    let ways = before.control_vertices().iter().zip(after.control_vertices()).flat_map(|(a, b)| {
        let way = b - a;
        [way.x, way.y, way.z]
    });
    DVector::from_iterator(3 * before.control_vertices().len(), ways)
}

fn close(found: &DVector<f64>, wanted: &DVector<f64>, share: f64, what: &str) {
    let far = (found - wanted).amax() / wanted.amax().max(1e-300);
    assert!(far <= share, "{what}: {far:.1e}");
}

/// The map of ties as it is meant.
fn ties_by_hand(count: usize, ties: &[Tie]) -> DMatrix<f64> {
    let follows = |v: usize| ties.iter().find(|tie| tie.vertex == v);
    let free: Vec<usize> = (0..count).filter(|v| follows(*v).is_none()).collect();
    let mut b = DMatrix::zeros(3 * count, 3 * free.len());
    for vertex in 0..count {
        let (mut by, mut at) = (Matrix3::identity(), vertex);
        while let Some(tie) = follows(at) {
            by *= tie.by;
            at = tie.to;
        }
        let column = free.iter().position(|v| *v == at).unwrap();
        b.view_mut((3 * vertex, 3 * column), (3, 3)).copy_from(&by);
    }
    b
}

#[test]
fn ties_with_every_solver_and_metric_as_a_dense_evaluator_says() {
    let mut random = Random(7);
    let (mut solved, mut refused) = (0, 0);
    for member in 0..160 {
        let curve = curve(&mut random);
        let n = curve.control_vertices().len();
        let turned = member % 2 == 1;
        let mut ties: Vec<Tie> = Vec::new();
        // Each follows one before it, some by a chain.
        for vertex in 1..n {
            if random.below(3) == 0 {
                let by = if turned {
                    Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.3, 1.0)
                } else {
                    Matrix3::identity()
                };
                ties.push(Tie { vertex, to: random.below(vertex), by });
            }
        }
        let b = ties_by_hand(n, &ties);
        let (metric, w) = match member % 3 {
            0 => (Metric::Least, DMatrix::identity(3 * n, 3 * n)),
            1 => {
                let weights: Vec<f64> = (0..n).map(|_| random.between(0.5, 4.0)).collect();
                let each = DVector::from_iterator(3 * n, weights.iter().flat_map(|w| [*w; 3]));
                (Metric::Weights(weights), DMatrix::from_diagonal(&each))
            }
            _ => {
                let matrix = curve.smoothness(1).unwrap();
                let mut w = DMatrix::zeros(3 * n, 3 * n);
                for i in 0..n {
                    for (j, value) in matrix.row(i) {
                        (0..3).for_each(|axis| w[(3 * i + axis, 3 * j + axis)] = value);
                    }
                }
                (Metric::Stretch, w)
            }
        };
        let m = b.transpose() * w * &b;
        let places: Vec<f64> = (0..1 + random.below(2)).map(|k| at(&curve, 0.2 + 0.5 * k as f64)).collect();
        let ways: Vec<Vector> = places
            .iter()
            .map(|_| Vector::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.5))
            .collect();
        let rhs = DVector::from_iterator(3 * ways.len(), ways.iter().flat_map(|w| [w.x, w.y, w.z]));
        let wanted = dense(&b, &m, &rows(&curve, &places), &rhs);
        let missed = (rows(&curve, &places) * &wanted - &rhs).amax();
        for solver in solvers() {
            let mut edit =
                Edit::new(&curve).smooth(0).metric(metric.clone()).through(Unknowns::tied(n, &ties).unwrap());
            for (u, way) in places.iter().zip(&ways) {
                edit = edit.ask(position(*u).by(*way));
            }
            match edit.solve_with(Arc::clone(&solver)) {
                Ok(edited) => {
                    // The reference squares nothing, but inverts the metric's factor.
                    close(&adjustment(&curve, edited.shape()), &wanted, 1e-8, solver.name());
                    assert!(edited.report().residual < 1e-12);
                    solved += 1;
                }
                // Ties may leave two places to one unknown.
                Err(EditError::Solve(SolveError::Conflict { .. })) => {
                    assert!(missed > 1e-9, "{}", solver.name());
                }
                Err(error) => {
                    refused += 1;
                    assert!(refused <= 6, "{}: {error}", solver.name());
                }
            }
        }
    }
    assert!(solved > 800, "{solved}");
}

/// Paper 5 in its plainest form: `P_i = P_0 + Σ_(j<i) x_j (v_(j+1) - v_j)`, a running sum.
#[derive(Debug)]
struct Legs(Vec<Vector>);

impl Legs {
    fn of(curve: &Curve) -> Self {
        Self(curve.control_vertices().windows(2).map(|pair| pair[1] - pair[0]).collect())
    }

    fn dense(&self) -> DMatrix<f64> {
        let n = self.0.len() + 1;
        let mut b = DMatrix::zeros(3 * n, n - 1);
        for (j, leg) in self.0.iter().enumerate() {
            for i in j + 1..n {
                (0..3).for_each(|axis| b[(3 * i + axis, j)] = leg[axis]);
            }
        }
        b
    }
}

impl Operator for Legs {
    fn unknowns(&self) -> usize {
        self.0.len()
    }

    fn columns(&self) -> usize {
        3 * self.0.len() + 3
    }

    fn apply(&self, x: &[f64], d: &mut [f64]) {
        let mut sum = Vector::zeros();
        d[..3].fill(0.0);
        for ((leg, x), d) in self.0.iter().zip(x).zip(d[3..].chunks_exact_mut(3)) {
            sum += leg * *x;
            d.copy_from_slice(sum.as_slice());
        }
    }

    fn apply_transposed(&self, f: &[f64], x: &mut [f64]) {
        let mut sum = Vector::zeros();
        for ((leg, x), f) in self.0.iter().zip(x).zip(f[3..].chunks_exact(3)).rev() {
            sum += Vector::from_column_slice(f);
            *x = leg.dot(&sum);
        }
    }
}

fn through(curve: &Curve) -> Unknowns {
    let all = (0..curve.control_vertices().len()).collect();
    Unknowns::operator(all, Arc::new(Legs::of(curve))).unwrap()
}

#[test]
fn an_operator_is_applied_and_never_stored_with_every_solver() {
    let mut random = Random(11);
    for member in 0..60 {
        let curve = curve(&mut random);
        let n = curve.control_vertices().len();
        let b = Legs::of(&curve).dense();
        let gram = (member % 2 == 1).then(|| {
            Symmetric::from_entries(
                n - 1,
                (0..n - 1).flat_map(|i| [(i, i, 4.0), (i, i.saturating_sub(1), 1.0)]),
            )
        });
        let m = match &gram {
            None => DMatrix::identity(n - 1, n - 1),
            Some(gram) => DMatrix::from_fn(n - 1, n - 1, |i, j| gram.entry(i, j)),
        };
        // One end stays, a coordinate of the middle moves.
        let (far, middle) = (at(&curve, 0.9), at(&curve, 0.5));
        let f = rows(&curve, &[far, middle]);
        let kept: Vec<usize> = vec![0, 1, 2, 4];
        let f = f.select_rows(&kept);
        let rhs = DVector::from_vec(vec![0.0, 0.0, 0.0, 0.2]);
        let wanted = dense(&b, &m, &f, &rhs);
        let possible = (&f * &wanted - &rhs).amax() < 1e-9;
        for solver in solvers() {
            let edited = Edit::new(&curve)
                .smooth(0)
                .through(through(&curve).measured(gram.clone()).unwrap())
                .ask(position(far).keep())
                .ask(position(middle).by([0.0, 0.2, 0.0]).axis(loftsman_kernel::edit::Axis::Y))
                .solve_with(Arc::clone(&solver));
            match edited {
                Ok(edited) => {
                    close(&adjustment(&curve, edited.shape()), &wanted, 1e-8, solver.name());
                }
                Err(EditError::Solve(SolveError::Conflict { .. })) if !possible => {}
                Err(error) => assert!(
                    matches!(error, EditError::Solve(SolveError::TooLarge { .. })),
                    "{member} {}: {error}",
                    solver.name()
                ),
            }
        }
    }
}

#[test]
fn what_is_not_linear_bounds_and_drags_go_through_unknowns() {
    let mut random = Random(5);
    for _ in 0..40 {
        let curve = curve(&mut random);
        let b = Legs::of(&curve).dense();
        let (first, second) = (at(&curve, 0.4), at(&curve, 0.8));
        let length = curve.derivative(first, 1).unwrap().norm();
        // The least change of x: what is left of x beside the gradients of what holds is nothing.
        let edited = Edit::new(&curve)
            .smooth(0)
            .through(through(&curve).measured(None).unwrap())
            .ask(magnitude(first).to(1.1 * length))
            .ask(position(second).by([0.05, 0.0, 0.0]).axis(loftsman_kernel::edit::Axis::X))
            .solve();
        let Ok(edited) = edited else { panic!("{}", edited.unwrap_err()) };
        assert!((edited.shape().derivative(first, 1).unwrap().norm() / (1.1 * length) - 1.0).abs() < 1e-11);
        let d = adjustment(&curve, edited.shape());
        let x = b.clone().svd(true, true).solve(&d, 1e-12).unwrap();
        assert!((&b * &x - &d).amax() < 1e-10 * d.amax(), "nothing else moves");
        let n = curve.control_vertices().len();
        let mut gradients = DMatrix::zeros(2, 3 * n);
        let tangent = edited.shape().derivative(first, 1).unwrap().normalize();
        let stencil = curve.stencil(Location::Curve(first), Derivative { u: 1, v: 0 }).unwrap();
        for (v, c) in stencil.iter() {
            (0..3).for_each(|axis| gradients[(0, 3 * v + axis)] += c * tangent[axis]);
        }
        for (v, c) in curve.stencil(Location::Curve(second), Derivative::POSITION).unwrap().iter() {
            gradients[(1, 3 * v)] += c;
        }
        let g = (gradients * &b).transpose();
        let multipliers = g.clone().svd(true, true).solve(&x, 1e-12).unwrap();
        assert!((&g * multipliers - &x).amax() < 1e-7 * x.amax(), "least");

        // A bound that is met already is idle, one that is not holds with equality.
        let here = curve.point(second).unwrap().x;
        let bounded = |least: f64| {
            Edit::new(&curve)
                .smooth(0)
                .through(through(&curve).measured(None).unwrap())
                .ask(position(second).axis(loftsman_kernel::edit::Axis::X).at_least(least))
                .solve()
                .unwrap()
        };
        assert!(adjustment(&curve, bounded(here - 1.0).shape()).amax() == 0.0);
        let pushed = bounded(here + 0.1);
        assert!((pushed.shape().point(second).unwrap().x - here - 0.1).abs() < 1e-12);

        let mut drag = Edit::new(&curve)
            .smooth(0)
            .through(through(&curve).measured(None).unwrap())
            .ask(position(first).keep())
            .handle(position(second))
            .prepare(Automatic)
            .unwrap();
        let from = curve.point(second).unwrap();
        for k in 1..4 {
            let to = from + Vector::new(0.1, -0.2, 0.1) * f64::from(k);
            if drag.to_point(to).is_ok() {
                assert!((drag.shape().point(second).unwrap() - to).norm() < 1e-12);
                assert!((drag.shape().point(first).unwrap() - curve.point(first).unwrap()).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn locks_are_equations_and_conflicts_are_named() {
    let points = (0..8).map(|i| Point::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap();
    let tied = || Unknowns::tied(8, &[Tie::together(7, 0), Tie::together(3, 2)]).unwrap();
    let edited =
        Edit::new(&curve).through(tied()).ask(vertex(3).by([0.0, 0.0, 1.0])).lock([-1]).solve().unwrap();
    let moved = adjustment(&curve, edited.shape());
    assert_eq!(moved.iter().filter(|v| **v != 0.0).count(), 2, "both of the pair, and no other");
    assert_eq!((moved[8], moved[11]), (1.0, 1.0));
    for solver in solvers() {
        let error = Edit::new(&curve)
            .through(tied())
            .ask(vertex(0).by([1.0, 0.0, 0.0]))
            .lock([7])
            .solve_with(Arc::clone(&solver))
            .map(|_| ())
            .unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, EditError::Solve(SolveError::Conflict { .. })), "{text}");
        assert!(text.contains("vertex 0") && text.contains("vertex 7"), "{}: {text}", solver.name());
    }
    // What the unknowns do not reach cannot be had.
    let few = SparseRows::per_axis(&{
        let mut rows = SparseRows::new(1);
        rows.push([(0, 1.0)]);
        rows.push([(0, 1.0)]);
        rows
    });
    let few = Unknowns::sparse(vec![0, 1], few).unwrap();
    let error =
        Edit::new(&curve).through(few).ask(vertex(5).by([1.0, 0.0, 0.0])).solve().map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("vertex 5") && error.to_string().contains("unknowns"), "{error}");
}

#[derive(Debug)]
struct Crooked(Legs);

impl Operator for Crooked {
    fn unknowns(&self) -> usize {
        self.0.unknowns()
    }

    fn columns(&self) -> usize {
        self.0.columns()
    }

    fn apply(&self, x: &[f64], d: &mut [f64]) {
        self.0.apply(x, d);
    }

    fn apply_transposed(&self, f: &[f64], x: &mut [f64]) {
        self.0.apply_transposed(f, x);
        x[1] = -x[1];
    }
}

#[test]
fn what_cannot_be_is_said() {
    let points = (0..6).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap();
    let text = |result: Result<Unknowns>| result.unwrap_err().to_string();
    assert!(text(Unknowns::tied(6, &[Tie::together(6, 0)])).contains("control vertex 6"));
    assert!(text(Unknowns::tied(6, &[Tie::together(1, 0), Tie::together(1, 2)])).contains("tied twice"));
    assert!(text(Unknowns::tied(6, &[Tie::together(1, 2), Tie::together(2, 1)])).contains("follows itself"));
    assert!(text(Unknowns::tied(6, &[Tie::together(4, 4)])).contains("follows itself"));
    let crooked = Unknowns::operator((0..6).collect(), Arc::new(Crooked(Legs::of(&curve))));
    assert!(text(crooked).contains("apply_transposed"));
    assert!(
        text(Unknowns::operator((0..5).collect(), Arc::new(Legs::of(&curve)))).contains("three for each")
    );
    assert!(text(Unknowns::sparse(vec![1, 0], SparseRows::new(1))).contains("ascend"));
    let solve = |unknowns: Unknowns, metric: Metric| {
        let edit = Edit::new(&curve).through(unknowns).metric(metric).ask(position(0.5).by([0.0, 1.0, 0.0]));
        edit.solve().map(|_| ()).unwrap_err().to_string()
    };
    assert!(solve(through(&curve), Metric::Falloff(2.0)).contains("falloff"));
    assert!(solve(through(&curve).measured(None).unwrap(), Metric::Bend).contains("measured by themselves"));
    let far = Unknowns::tied(9, &[Tie::together(8, 0)]).unwrap();
    assert!(solve(far, Metric::Least).contains("control vertex 8"));
    // Two unknowns that do the same cannot be told apart by what they move.
    let mut same = SparseRows::new(2);
    (0..18).for_each(|_| same.push([(0, 1.0), (1, 1.0)]));
    let same = Unknowns::sparse((0..6).collect(), same).unwrap();
    let problem = solve(same.clone(), Metric::Least);
    assert!(
        problem.contains("moves nothing that others do not") && problem.contains("measured(None)"),
        "{problem}"
    );
    // Measured themselves they can.
    let ask = || position(0.5).by([1.0, 1.0, 1.0]);
    assert!(Edit::new(&curve).through(same.measured(None).unwrap()).ask(ask()).solve().is_ok());
    let one = |c: f64| {
        let mut rows = SparseRows::new(1);
        (0..18).for_each(|_| rows.push([(0, c)]));
        Unknowns::sparse((0..6).collect(), rows).unwrap()
    };
    assert!(solve(one(1e200), Metric::Least).contains("beyond what numbers hold"));
    let by = |m: f64| one(1.0).measured(Some(Symmetric::from_entries(1, [(0, 0, m)])));
    assert!(text(by(f64::NAN)).contains("row 0 of the matrix"));
    let problem = solve(by(-1.0).unwrap(), Metric::Least);
    assert!(problem.contains("not positive definite") && problem.contains("measured(None)"), "{problem}");
    let few = Unknowns::tied(5, &[Tie::together(4, 0)]).unwrap();
    assert!(
        solve(few, Metric::Least).contains("5 control vertices are tied, but the shapes of the edit have 6")
    );
    let within =
        Edit::new(&curve).through(through(&curve)).within(0.2, 0.8).ask(position(0.5).by([0.0, 1.0, 0.0]));
    assert!(within.solve().map(|_| ()).unwrap_err().to_string().contains("leave one of the two out"));
}

/// The height of a curve where it crosses `x = c`, nonlinear, and about other vertices wherever that is.
#[derive(Debug, Clone, PartialEq)]
struct Crossing(f64);

impl Crossing {
    fn parameter(&self, shape: &dyn Shape) -> Result<f64> {
        let domain = shape.domain()[0];
        let x = |u: f64, order: usize| -> Result<f64> {
            let stencil = shape.stencil(Location::Curve(u), Derivative { u: order, v: 0 })?;
            Ok(stencil.iter().map(|(v, c)| c * shape.control_vertices()[v].x).sum())
        };
        let (mut low, mut high) = (domain.start, domain.end);
        if !(x(low, 0)? <= self.0 && x(high, 0)? >= self.0) {
            return Err(Error::Invalid("does not cross".into()));
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if x(middle, 0)? < self.0 { low = middle } else { high = middle }
        }
        Ok(0.5 * (low + high))
    }
}

impl Functional for Crossing {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let shape = shapes.get(0)?;
        let u = self.parameter(shape)?;
        let at = Location::Curve(u);
        let slope = shapes.stencil(0, at, Derivative { u: 1, v: 0 })?;
        let along: Vector =
            slope.iter().fold(Vector::zeros(), |sum, (v, c)| sum + shape.control_vertices()[v].coords * c);
        let stencil = shapes.stencil(0, at, Derivative::POSITION)?;
        let steep = along.y / along.x;
        let terms = rows.equation();
        stencil.iter().for_each(|(v, c)| {
            terms.term(0, v, Vector::new(-steep * c, c, 0.0));
        });
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let shape = shapes.get(0)?;
        let u = self.parameter(shape)?;
        let stencil = shape.stencil(Location::Curve(u), Derivative::POSITION)?;
        out[0] = stencil.iter().map(|(v, c)| c * shape.control_vertices()[v].y).sum();
        Ok(())
    }

    fn describe(&self) -> String {
        format!("height at x = {}", self.0)
    }
}

#[test]
fn a_constraint_may_reach_other_vertices_on_the_way() {
    let (mut border, mut sequential) = (0, 0);
    for member in 0..24 {
        let points = (0..24).map(|i| Point::new(f64::from(i), 0.3 * f64::from(i % 3), 0.0)).collect();
        let curve = Curve::new(Space::clamped_uniform(3, 24).unwrap(), points).unwrap();
        // Moving a point along the curve by several vertices' distance takes the crossing elsewhere.
        let (place, by) = (0.3 + 0.015 * f64::from(member), 3.0 + 0.2 * f64::from(member));
        let u = at(&curve, place);
        let crossing = curve.point(u).unwrap().x + 0.1 + 0.2 * f64::from(member % 5);
        let mut edit = Edit::new(&curve).ask(position(u).by([by, 0.0, 0.0])).ask(
            loftsman_kernel::edit::Constraint::new(
                Arc::new(Crossing(crossing)),
                loftsman_kernel::edit::Wanted::By(2.0.into()),
            ),
        );
        let inequality = member % 2 == 1;
        if inequality {
            edit = edit.ask(vertex(20).axis(loftsman_kernel::edit::Axis::Y).at_least(-1.0));
        }
        let mut before = [0.0];
        let wanted = {
            let shapes = Shapes::one(&curve);
            Crossing(crossing).value(&shapes, &mut before).unwrap();
            before[0] + 2.0
        };
        match edit.solve() {
            Ok(edited) => {
                let mut after = [0.0];
                Crossing(crossing).value(&Shapes::one(edited.shape()), &mut after).unwrap();
                assert!((after[0] - wanted).abs() < 1e-9, "{member}: {} for {wanted}", after[0]);
                assert!((edited.shape().point(u).unwrap().x - curve.point(u).unwrap().x - by).abs() < 1e-9);
                // All of the way back is known, however far it reached.
                assert_eq!(edited.undo().control_vertices(), curve.control_vertices());
                *(if inequality { &mut sequential } else { &mut border }) += 1;
            }
            Err(error) => panic!("{member}: {error}"),
        }
    }
    assert_eq!((border, sequential), (12, 12));
}

#[test]
fn derivatives_scale_by_a_map_and_the_rest_of_the_polygon_follows() {
    // With every leg asked 1.5 times as long where only the first vertex stays, the whole curve is scaled.
    let points = (0..9).map(|i| Point::new(f64::from(i), f64::from(i * i) * 0.1, 0.0)).collect();
    let curve = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points).unwrap();
    let end = at(&curve, 1.0);
    let far = curve.point(end).unwrap();
    let edited = Edit::new(&curve)
        .through(through(&curve).measured(None).unwrap())
        .ask(position(end).by(far.coords * 0.5))
        .ask(derivative(at(&curve, 0.0), 1).scale(1.5))
        .solve()
        .unwrap();
    assert!((edited.shape().point(end).unwrap() - far * 1.5).norm() < 1e-12);
    let direction = |c: &Curve, i: usize| (c.control_vertices()[i + 1] - c.control_vertices()[i]).normalize();
    for i in 0..8 {
        assert!(
            (direction(&curve, i) - direction(edited.shape(), i)).norm() < 1e-12,
            "legs keep their directions"
        );
    }
}

#[test]
fn a_map_of_nothing_moves_nothing() {
    let curve =
        Curve::new(Space::clamped_uniform(1, 2).unwrap(), vec![Point::origin(), Point::new(1.0, 0.0, 0.0)])
            .unwrap();
    let none = Unknowns::sparse(Vec::new(), SparseRows::new(0)).unwrap();
    let error = Edit::new(&curve)
        .through(none)
        .ask(position(0.5).by([0.0, 1.0, 0.0]))
        .solve()
        .map(|_| ())
        .unwrap_err();
    assert!(error.to_string().contains("position at 0.5"), "{error}");
}
