//! Rest that is found by Newton's method: stable where it should be, left where it is not, in few steps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::shape::Derivative;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_subdivision::{Cage, SubdivisionSurface};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

fn line(degree: usize, n: usize, to: [f64; 3]) -> Curve {
    let space = Space::clamped_uniform(degree, n).unwrap();
    let end = space.domain().1;
    let points = (0..n).map(|i| Point::from(Point::from(to).coords * (space.greville(i) / end)));
    Curve::new(space.clone(), points.collect()).unwrap()
}

fn sheet(n: usize, size: f64) -> Surface {
    let space = Space::clamped_uniform(3, n).unwrap();
    let at = |i: usize| space.greville(i) * size / space.domain().1;
    let points = (0..n * n).map(|k| Point::new(at(k / n), at(k % n), 0.0)).collect();
    Surface::new(space.clone(), space.clone(), points).unwrap()
}

fn end_of(simulation: &Simulation) -> Point {
    *simulation.shape(0).unwrap().control_vertices().last().unwrap()
}

/// Greenhill (1881): a column that is clamped at its foot falls over by its own weight `w` where `w L³ > 7.8373 EI`.
#[test]
fn a_column_falls_over_where_greenhill_says() {
    let (length, mass) = (10.0, 0.2);
    let critical = mass * 9.81 * length * length * length / 7.8373;
    for scheme in [Scheme::Exact, Scheme::Implicit] {
        for (bending, falls) in [(1.02 * critical, false), (0.9 * critical, true), (0.2 * critical, true)] {
            let column = line(3, 20, [0.0, 0.0, length]);
            let foot = column.derivative(0.0, 1).unwrap();
            let mut simulation = Setup::new(Body::new(&column).mass(mass).stiffness(2e4).bending(bending))
                .gravity(GRAVITY)
                .hold(fixed(0.0).tangent(foot))
                .scheme(scheme)
                .prepare()
                .unwrap();
            let settled = simulation.settle().unwrap();
            assert!(settled.rests && settled.stable == Some(true), "{bending} {settled:?}");
            let top = end_of(&simulation);
            let aside = top.x.hypot(top.y);
            assert_eq!(aside > 0.1 * length, falls, "{bending}: {top}");
            assert!(falls || aside < 1e-6 * length, "{bending}: {top}");
        }
    }
}

/// Without bending and without weight what is compressed stays as it is, and is told to be unstable; with bending it finds its arch, and as Euler says
/// not before `π² EI/L²`.
#[test]
fn what_is_pushed_together_is_told_of_or_buckles() {
    let pushed = |bending: f64, way: f64| {
        let rope = line(3, 24, [10.0, 0.0, 0.0]);
        let end = rope.space().domain().1;
        let mut simulation = Setup::new(Body::new(&rope).stiffness(500.0).bending(bending))
            .hold(fixed(0.0))
            .hold(fixed(end).to([10.0 - way, 0.0, 0.0]))
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{settled:?}");
        let middle = simulation.shape(0).unwrap().value((0.5 * end).into(), Derivative::POSITION).unwrap();
        (settled.stable, middle.y.hypot(middle.z))
    };
    assert_eq!(pushed(0.0, 0.5).0, Some(false));
    // Of the rod that is shortened by a share ε the load is 500 ε.
    let bending = 2.0;
    let critical = std::f64::consts::PI.powi(2) * bending / 100.0 / 500.0 * 10.0;
    let (stable, aside) = pushed(bending, 0.95 * critical);
    assert!(stable == Some(true) && aside < 1e-6, "{stable:?} {aside}");
    let (stable, aside) = pushed(bending, 1.1 * critical);
    assert!(stable == Some(true) && aside > 0.02, "{stable:?} {aside}");
}

/// Sheets and cages come to rest within some dozens of steps, each a factor: forces balance on every vertex, by the multipliers that are told.
#[test]
fn sheets_come_to_rest_in_few_steps() {
    for (bending, gravity, most) in [(2.0, [0.0; 3], 60), (2.0, GRAVITY, 60), (0.0, GRAVITY, 200)] {
        let sheet = sheet(7, 6.0);
        let mut simulation = Setup::new(Body::new(&sheet).mass(0.02).stiffness(200.0).bending(bending))
            .gravity(gravity)
            .hold(fixed([0.0, 0.0]))
            .hold(sliding([1.0, 3.0]).to([1.5, 4.5, 1.2]))
            .hold(sliding([3.0, 1.0]).to([4.5, 1.5, 1.2]))
            .hold(sliding([2.33, 2.33]).to([3.5, 3.5, 0.2]))
            .scheme(Scheme::Implicit)
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests && settled.steps <= most, "{bending} {gravity:?}: {settled:?}");
        // What holds carries the weight.
        let carried: f64 = (0..4).filter_map(|k| simulation.force_of(k).unwrap().get(2)).sum();
        let weight = -0.02 * 36.0 * gravity[2];
        assert!((carried - weight).abs() < 1e-6 * (1.0 + weight), "{carried} {weight}");
        let errors = simulation.errors().unwrap();
        assert!(errors.iter().all(|e| *e < 1e-8), "{errors:?}");
        // Once more, it stays.
        let before = simulation.shape(0).unwrap().control_vertices().to_vec();
        let again = simulation.settle().unwrap();
        assert!(again.rests && again.steps <= 1, "{again:?}");
        let now = simulation.shape(0).unwrap().control_vertices();
        assert!(before.iter().zip(now).all(|(a, b)| (a - b).norm() < 1e-4), "it went on");
    }
    let n = 8;
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| Point::new(i as f64, j as f64, 0.0))).collect();
    let corner = |k: usize| k / n * (n + 1) + k % n;
    let faces: Vec<[usize; 4]> = (0..n * n).map(corner).map(|a| [a, a + n + 1, a + n + 2, a + 1]).collect();
    let cage = SubdivisionSurface::new(Cage::new(points, &faces).unwrap()).unwrap();
    let corners = [0, n].map(|vertex| cage.place_of(vertex).unwrap().unwrap());
    let mut simulation = Setup::new(Body::new(&cage).mass(0.1).stiffness(300.0).bending(5.0))
        .gravity(GRAVITY)
        .hold(fixed(corners[0]))
        .hold(fixed(corners[1]))
        .prepare()
        .unwrap();
    let settled = simulation.settle().unwrap();
    assert!(settled.rests && settled.stable == Some(true) && settled.steps <= 60, "{settled:?}");
}
