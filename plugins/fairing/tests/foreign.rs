//! Energies that fairing has never seen, known by their squares, against their normal equations solved densely.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use crate::dice::Dice;
use loftsman_fairing::Fair;
use loftsman_kernel::edit::{Ask, Axis, Edit};
use loftsman_kernel::energy::{Energy, Squares};
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Shapes, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{Symmetric, SystemMetric};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::{DMatrix, DVector};

/// The polygon of control vertices is a chain of beams, `Σ |P_(k-1) - 2 P_k + P_(k+1)|²`, each vertex on a spring to a place of its
/// own, `stiff Σ |P_k - Q_k|²`.
#[derive(Debug, Clone)]
struct Chain {
    places: Vec<Point>,
    stiff: f64,
}

impl Chain {
    fn rows(&self) -> Vec<(Vec<(usize, f64)>, Vector)> {
        let n = self.places.len();
        let beams = (1..n - 1).map(|k| (vec![(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)], Vector::zeros()));
        let root = self.stiff.sqrt();
        let springs = self.places.iter().enumerate().map(|(k, q)| (vec![(k, root)], q.coords * root));
        beams.chain(springs).collect()
    }
}

impl Energy for Chain {
    fn describe(&self) -> String {
        "chain".into()
    }

    fn squares(&self, _: &dyn Shape, origin: Point) -> Result<Option<Squares>> {
        let mut squares = Squares::default();
        for (terms, target) in self.rows() {
            let sum: f64 = terms.iter().map(|(_, c)| c).sum();
            squares.open(terms.iter().map(|(v, _)| *v));
            squares.row(terms.iter().map(|(_, c)| *c), target - origin.coords * sum);
        }
        Ok(Some(squares))
    }
}

/// The same known by its matrix alone.
#[derive(Debug)]
struct Matrix;

impl Energy for Matrix {
    fn describe(&self) -> String {
        "matrix".into()
    }

    fn form(&self, _: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric> {
        let ones = (0..moving.len()).map(|k| (k, k, 1.0));
        Ok(SystemMetric::Matrix(Arc::new(Symmetric::from_entries(moving.len(), ones))))
    }
}

fn wavy(dice: &mut Dice, round: usize) -> Curve {
    let p = 1 + round % 7;
    let n = p + 3 + dice.below(9);
    let space = match round % 3 {
        0 => Space::clamped_uniform(p, n).unwrap(),
        1 => Space::floating_uniform(p, n).unwrap(),
        _ => Space::periodic(p, (0..=n).map(|k| k as f64).collect()).unwrap(),
    };
    // Far from the origin, too: energies are relative to the shape.
    let away = if round % 5 == 4 { 1e6 } else { 0.0 };
    let points = (0..space.len())
        .map(|k| Point::new(away + k as f64, (1.3 * k as f64).sin(), 0.2 * (k % 4) as f64))
        .collect();
    Curve::new(space, points).unwrap()
}

/// `[AᵀA fᵀ; f 0] [P; λ] = [Aᵀr; b]`, one coordinate after another, by full pivoting.
fn by_hand(chain: &Chain, row: &[(usize, f64)], wanted: Vector) -> Vec<Point> {
    let n = chain.places.len();
    let mut matrix = DMatrix::zeros(n + 1, n + 1);
    let mut right = vec![DVector::zeros(n + 1); 3];
    for (terms, target) in chain.rows() {
        for &(i, a) in &terms {
            terms.iter().for_each(|&(j, b)| matrix[(i, j)] += a * b);
            (0..3).for_each(|axis| right[axis][i] += a * target[axis]);
        }
    }
    for &(v, c) in row {
        (matrix[(n, v)], matrix[(v, n)]) = (matrix[(n, v)] + c, matrix[(v, n)] + c);
    }
    (0..3).for_each(|axis| right[axis][n] = wanted[axis]);
    let lu = matrix.full_piv_lu();
    let each: Vec<_> = right.iter().map(|right| lu.solve(right).unwrap()).collect();
    (0..n).map(|k| Point::new(each[0][k], each[1][k], each[2][k])).collect()
}

#[test]
fn an_energy_known_by_its_squares_is_faired_and_made_least_like_any_other() {
    let mut dice = Dice(11);
    for round in 0..42 {
        let curve = wavy(&mut dice, round);
        let size = 1.0 + curve.control_vertices().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let places =
            curve.control_vertices().iter().map(|p| p + Vector::new(0.0, dice.between(-0.5, 0.5), 0.1));
        let chain = Chain { places: places.collect(), stiff: 0.05 };
        let (start, end) = curve.domain();
        let u = start + 0.37 * (end - start);
        let wanted = curve.point(u).unwrap() + Vector::new(0.1, 0.4, -0.3);
        let stencil = curve.stencil(u.into(), 0.into()).unwrap();
        let expected = by_hand(&chain, &stencil.iter().collect::<Vec<_>>(), wanted.coords);
        let far = |shape: &Curve| {
            let pairs = shape.control_vertices().iter().zip(&expected);
            pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).norm()))
        };
        let fair =
            Fair::new(&curve).smooth(0).energy(chain.clone()).ask(position(u).to(wanted)).solve().unwrap();
        assert!(far(fair.shape()) < 1e-8 * size, "round {round}: {}", far(fair.shape()));
        assert!(fair.report().energy.contains("chain"));
        let edit =
            Edit::new(&curve).smooth(0).minimise(chain.clone()).ask(position(u).to(wanted)).solve().unwrap();
        assert!(far(edit.shape()) < 1e-8 * size, "round {round}: {}", far(edit.shape()));

        // Between bounds: what is least of all keeps to one that asks for less, and meets one that asks for more.
        let height = |bound: f64| {
            let ask = position(u).axis(Axis::Y).at_least(bound);
            let fair = Fair::new(&curve).smooth(0).energy(chain.clone()).ask(ask).solve().unwrap();
            fair.shape().point(u).unwrap().y
        };
        let least = height(-1e3 * size);
        assert!((height(least - 0.3) - least).abs() <= 1e-7 * size, "round {round}");
        assert!((height(least + 0.3) - least - 0.3).abs() <= 1e-7 * size, "round {round}");
    }
}

#[test]
fn what_has_no_squares_or_wrong_ones_is_told() {
    let curve = wavy(&mut Dice(1), 0);
    let count = curve.control_vertices().len();
    let told = |fair: Fair<Curve>| fair.solve().map(|_| ()).unwrap_err().to_string();
    assert!(told(Fair::new(&curve).energy(Matrix)).contains("\"matrix\" is known by its matrix alone"));
    assert!(told(Fair::new(&curve)).contains("say what should be small"));
    let long = Chain { places: vec![Point::origin(); count + 1], stiff: 1.0 };
    assert!(
        told(Fair::new(&curve).energy(long))
            .contains(&format!("control vertex {count}, but there are {count}"))
    );
    let wild = Chain { places: vec![Point::new(f64::NAN, 0.0, 0.0); count], stiff: 1.0 };
    assert!(told(Fair::new(&curve).energy(wild.clone())).contains("the energy overflows"));
    let edit = Edit::new(&curve).minimise(wild).ask(position(0.5).keep()).solve().map(|_| ()).unwrap_err();
    assert!(edit.to_string().contains("the energy overflows"), "{edit}");
}

/// Pulls everything so far away that numbers there no longer see what is asked.
#[derive(Debug)]
struct Far(f64);

impl Energy for Far {
    fn describe(&self) -> String {
        "far".into()
    }

    fn form(&self, _: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric> {
        Ok(SystemMetric::Weights(vec![1.0; moving.len()].into()))
    }

    fn pull(&self, _: &Shapes<'_>, moving: &[usize]) -> Result<Vec<Vector>> {
        Ok(vec![Vector::x() * self.0; moving.len()])
    }
}

/// Has a block without vertices.
#[derive(Debug)]
struct Empty;

impl Energy for Empty {
    fn describe(&self) -> String {
        "empty".into()
    }

    fn squares(&self, shape: &dyn Shape, _: Point) -> Result<Option<Squares>> {
        let mut squares = Squares::default();
        squares.open([]);
        for vertex in 0..shape.control_vertices().len() {
            squares.open([vertex]);
            squares.row([1.0], Vector::zeros());
        }
        Ok(Some(squares))
    }
}

#[test]
fn a_minimum_out_of_reach_is_refused_and_an_empty_block_is_nothing() {
    let curve = wavy(&mut Dice(1), 0);
    let (start, end) = curve.domain();
    let at = 0.5 * (start + end);
    let to = Point::new(2.5, 1.0, 0.0);
    for far in [1e20, 1e18, 1e16, 1e12, 1e9] {
        let error =
            Edit::new(&curve).minimise(Far(far)).ask(position(at).to(to)).solve().map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("times the size of the shapes"), "{error}");
    }
    for far in [1.0, 1e3] {
        let edited = Edit::new(&curve).minimise(Far(far)).ask(position(at).to(to)).solve().unwrap();
        assert!((edited.shape().point(at).unwrap() - to).norm() < 1e-12 * (1.0 + far));
    }
    let edited = Edit::new(&curve).minimise(Empty).ask(position(at).to(to)).solve().unwrap();
    assert!((edited.shape().point(at).unwrap() - to).norm() < 1e-12);
}
