//! A step is a least adjustment: the accelerations of a simulation are those that the kernel's `Problem` finds, with the mass matrix as its
//! energy, locations that float as unknowns, and the same multipliers.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use std::sync::Arc;

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, holds, sliding};
use loftsman_kernel::edit::{Ask, Axis, Edit, Metric};
use loftsman_kernel::functional::{Functional, near, position, vertex};
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::solve::{Automatic, Solver, Symmetric};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::DMatrix;

const MASS: f64 = 0.3;
const EPSILON: f64 = 0.02;

fn rope(round: usize) -> Curve {
    let (p, n) = (2 + round % 4, 9 + round % 7);
    let space = match round % 3 {
        0 => Space::clamped_uniform(p, n).unwrap(),
        1 => Space::floating_uniform(p, n).unwrap(),
        _ => Space::periodic_uniform(p, n).unwrap(),
    };
    let turn = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
    let point = |i: usize| {
        let (sin, cos) = turn(i).sin_cos();
        Point::new(3.0 * cos, 2.0 * sin, 0.4 * (1.7 * i as f64 + round as f64).sin())
    };
    Curve::new(space, (0..n).map(point).collect()).unwrap()
}

fn setup(rope: &Curve, scheme: Scheme) -> Setup {
    // At rest of another length, so that its springs pull; and something pushes.
    Setup::new(Body::new(rope).mass(MASS).stiffness(40.0).rest(0.9).bending(0.02))
        .gravity([0.3, 0.0, -9.81])
        .scheme(scheme)
        .epsilon(EPSILON)
}

/// The accelerations of the first step from rest.
fn accelerations(mut simulation: Simulation) -> (Vec<Vector>, Simulation) {
    let step = 0.01 * simulation.stable_step();
    simulation.step(step).unwrap();
    (simulation.velocities(0).unwrap().into_iter().map(|v| v / step).collect(), simulation)
}

/// The mass matrix, as the simulation has it: from what a unit of force at each vertex does.
fn mass(rope: &Curve) -> DMatrix<f64> {
    let n = rope.control_vertices().len();
    let inverse = DMatrix::from_columns(
        &(0..n)
            .map(|j| {
                let body = Body::new(rope).mass(MASS).stiffness(0.0);
                let mut simulation = Setup::new(body).scheme(Scheme::Exact).step(1e-3).prepare().unwrap();
                simulation.applied_mut(0).unwrap()[3 * j] = 1.0;
                simulation.step(1e-3).unwrap();
                let all = simulation.velocities(0).unwrap();
                nalgebra::DVector::from_iterator(n, all.iter().map(|v| v.x / 1e-3))
            })
            .collect::<Vec<_>>(),
    );
    inverse.try_inverse().unwrap()
}

#[test]
fn a_step_is_the_answer_of_a_problem() {
    for round in 0..36 {
        let rope = rope(round);
        let n = rope.control_vertices().len();
        let middle = i64::try_from(n / 2).unwrap();
        let (start, end) = rope.domain();
        let at = |share: f64| start + share * (end - start);
        let m = mass(&rope);
        let lower = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| (i, j, m[(i, j)]));
        let metric = Metric::Matrix(Arc::new(Symmetric::from_entries(n, lower.collect::<Vec<_>>())));
        // A parameter is measured in lengths, by the mean pace along the shape: 64 chords of it.
        let chords: f64 = (0..64)
            .map(|k| f64::from(k) / 64.0)
            .map(|share| {
                (rope.point(at(share + 1.0 / 64.0)).unwrap() - rope.point(at(share)).unwrap()).norm()
            })
            .sum();
        let parameter = EPSILON * m.sum() / n as f64 * (chords / (end - start)).powi(2);
        for (scheme, weight) in [(Scheme::Exact, 0.0), (Scheme::Epsilon, parameter)] {
            // A nail, a ring, a rail across y, and any functional.
            let free: Arc<dyn Functional> = Arc::new(vertex(middle));
            let still = rope.control_vertices()[n / 2];
            let held = setup(&rope, scheme)
                .hold(fixed(at(0.02)))
                .hold(sliding(at(0.3)))
                .hold(sliding(at(0.8)).axes([false, true, false]))
                .hold(holds(free).value(still.coords.as_slice().to_vec()))
                .prepare()
                .unwrap();
            let (free, _) = accelerations(setup(&rope, scheme).prepare().unwrap());
            let (all, simulation) = accelerations(held);
            // Without constraints all would go by `free`; constraints ask that what they look at goes by nothing.
            let flight =
                Curve::new(rope.space().clone(), free.iter().map(|a| Point::from(*a)).collect()).unwrap();
            let back = |share: f64| -flight.value(at(share).into(), Derivative::POSITION).unwrap();
            let problem = Edit::new(&rope)
                .smooth(0)
                .metric(metric.clone())
                .ask(position(at(0.02)).by(back(0.02)))
                .ask(position(near(at(0.3))).by(back(0.3)))
                .ask(position(near(at(0.8))).axis(Axis::Y).by(back(0.8).y))
                .ask(vertex(middle).by(-free[n / 2]))
                .problem()
                .unwrap();
            let assembly = problem.assemble_floating(weight).unwrap();
            let rhs = problem.misfit(&assembly, &problem.shapes()).unwrap();
            let mut factored = Automatic.factor(assembly.system()).unwrap();
            let mut d = vec![0.0; assembly.system().touched().len()];
            factored.solve_into(&rhs, &mut d);
            assert_eq!((rhs.len(), factored.rank()), simulation.equations(), "round {round}, {scheme:?}");
            let largest = free.iter().map(|a| a.norm()).fold(0.0, f64::max);
            let mut met = 0;
            for (k, vertex) in assembly.vertices().enumerate() {
                let found = free[vertex] + Vector::new(d[3 * k], d[3 * k + 1], d[3 * k + 2]);
                let off = (found - all[vertex]).norm();
                assert!(
                    off < 1e-7 * largest,
                    "round {round}, {scheme:?}, vertex {vertex}: {off} of {largest}"
                );
                met += 1;
            }
            assert_eq!(met, n, "the mass metric takes all along");
            // And the forces with which the constraints hold.
            let mut multipliers = vec![0.0; rhs.len()];
            factored.multipliers_into(&rhs, &mut multipliers);
            let strongest = multipliers.iter().fold(0.0_f64, |m, l| m.max(l.abs()));
            let own: Vec<f64> = (0..4).flat_map(|k| simulation.force_of(k).unwrap().to_vec()).collect();
            assert_eq!(own.len(), multipliers.len());
            for (a, b) in own.iter().zip(&multipliers) {
                assert!(
                    (a - b).abs() < 1e-6 * strongest,
                    "round {round}, {scheme:?}: {own:?} {multipliers:?}"
                );
            }
        }
    }
}
