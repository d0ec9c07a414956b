//! Limit surfaces of subdivision cages in motion: they fall, hang, swing and keep what holds them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{Body, Scheme, Setup, fixed, sliding};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{limit_points, refine_times};
use loftsman_subdivision::{Cage, SubdivisionSurface};

const GRAVITY: Vector = Vector::new(0.0, 0.0, -9.81);

fn cube() -> Cage {
    let at = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Cage::new((0..8).map(at).collect(), &faces).unwrap()
}

/// An open sheet with a pentagon in its middle and vertices of five edges and of three.
fn sheet() -> Cage {
    let ring = |count: usize, radius: f64, turn: f64| {
        (0..count).map(move |k| {
            let (sin, cos) = (std::f64::consts::TAU * (k as f64 + turn) / count as f64).sin_cos();
            Point::new(radius * cos, radius * sin, 0.0)
        })
    };
    let points: Vec<Point> = ring(5, 1.0, 0.0).chain(ring(5, 2.0, 0.0)).chain(ring(5, 3.0, 0.0)).collect();
    let mut faces = vec![vec![0, 1, 2, 3, 4]];
    for level in 0..2 {
        for k in 0..5 {
            let (a, b) = (5 * level + k, 5 * level + (k + 1) % 5);
            faces.push(vec![a, a + 5, b + 5, b]);
        }
    }
    Cage::new(points, &faces).unwrap()
}

/// The area of the limit surface, as triangles of its limit points after four refinements.
fn area(cage: &Cage) -> f64 {
    let fine = refine_times(cage, 4).unwrap();
    let points = limit_points(&fine).unwrap();
    let topology = fine.topology();
    (0..topology.face_count())
        .map(|f| {
            let corners: Vec<Point> = topology.face(f).iter().map(|&v| points[v as usize]).collect();
            (1..corners.len() - 1)
                .map(|k| 0.5 * (corners[k] - corners[0]).cross(&(corners[k + 1] - corners[0])).norm())
                .sum::<f64>()
        })
        .sum()
}

/// A cube, subdivided once: its own limit does not see vertices that move in and out by turns.
fn block() -> Cage {
    refine_times(&cube(), 1).unwrap()
}

#[test]
fn a_cage_whose_limit_does_not_tell_its_vertices_is_refused() {
    let refused = Setup::new(Body::new(&SubdivisionSurface::new(cube()).unwrap())).prepare().unwrap_err();
    let refused = refused.to_string();
    assert!(refused.contains("subdivide the cage once") && !refused.contains("curve"), "{refused}");
}

#[test]
fn they_fall_as_all_does() {
    for (name, cage) in [("block", block()), ("sheet", sheet())] {
        let surface = SubdivisionSurface::new(cage).unwrap();
        for scheme in [Scheme::Exact, Scheme::Implicit] {
            let body = Body::new(&surface).mass(0.7).stiffness(30.0);
            let mut simulation = Setup::new(body).gravity(GRAVITY).scheme(scheme).prepare().unwrap();
            let step = simulation.stable_step().min(0.01);
            for _ in 0..20 {
                simulation.step(step).unwrap();
            }
            let t = 20.0 * step;
            // Backward Euler is ahead by half a step.
            let way = 0.5 * t * if scheme == Scheme::Implicit { t + step } else { t };
            let now = simulation.shape(0).unwrap().control_vertices();
            for (before, now) in surface.control_vertices().iter().zip(now) {
                let off = (now - before - way * GRAVITY).norm();
                assert!(off < 1e-9 * (1.0 + way * 9.81), "{name}, {scheme:?}: {off}");
            }
        }
    }
}

#[test]
fn what_hangs_weighs_what_it_has_of_area() {
    for (name, cage) in [("block", block()), ("sheet", sheet())] {
        let surface = SubdivisionSurface::new(cage.clone()).unwrap();
        let place = surface.place_of(0).unwrap().unwrap();
        let body = Body::new(&surface).mass(0.7).stiffness(2000.0);
        let setup = Setup::new(body).gravity(GRAVITY).hold(fixed(place)).scheme(Scheme::Implicit);
        let mut simulation = setup.prepare().unwrap();
        let at = surface.value(place, Derivative::POSITION).unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests, "{name}: {settled:?}");
        let weight = 0.7 * 9.81 * area(&cage);
        let force = simulation.force_of(0).unwrap();
        assert!((force[2] / weight - 1.0).abs() < 0.01, "{name}: {force:?} of {weight}");
        assert!(force[0].hypot(force[1]) < 1e-5 * weight, "{name}: {force:?}");
        let now = simulation.shape(0).unwrap().value(place, Derivative::POSITION).unwrap();
        assert!((now - at).norm() < 1e-6 * 3.0, "{name}: {now} {at}");
    }
}

#[test]
fn they_do_not_slide_yet_and_say_so() {
    let surface = SubdivisionSurface::new(block()).unwrap();
    let refused =
        Setup::new(Body::new(&surface)).hold(sliding(Location::Face(0, 0.3, 0.4))).prepare().unwrap_err();
    let message = refused.to_string();
    assert!(message.contains("face"), "{message}");
}

/// A torus of a regular cage is a bicubic spline, vertex by vertex: thrown and dented, both move alike, but for where the product of a tensor-product surface's mass puts its area.
#[test]
fn a_regular_cage_moves_as_the_spline_that_it_is() {
    let (m, n) = (9, 7);
    let angle = |k: usize, of: usize| k as f64 / of as f64 * std::f64::consts::TAU;
    let points: Vec<Point> = (0..m * n)
        .map(|k| {
            let ((s, c), (z, r)) = (angle(k / n, m).sin_cos(), angle(k % n, n).sin_cos());
            Point::new((2.0 + 0.6 * r) * c, (2.0 + 0.6 * r) * s, 0.6 * z)
        })
        .collect();
    let vertex = |i: usize, j: usize| (i % m) * n + j % n;
    let faces: Vec<[usize; 4]> = (0..m * n)
        .map(|k| (k / n, k % n))
        .map(|(i, j)| [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)])
        .collect();
    let cage = SubdivisionSurface::new(Cage::new(points.clone(), &faces).unwrap()).unwrap();
    let periodic = |count: usize| Space::periodic_uniform(3, count).unwrap();
    let spline = Surface::new(periodic(m), periodic(n), points.clone()).unwrap();
    let speeds: Vec<Vector> =
        points.iter().map(|p| Vector::new(1.5 * p.z * p.x, 0.3, 0.8 * (2.0 * p.x).sin())).collect();
    for scheme in [Scheme::Exact, Scheme::Implicit] {
        let mut moved = Vec::new();
        for body in [Body::new(&cage), Body::new(&spline)] {
            let body = body.mass(0.7).stiffness(40.0).damping(0.2).moving(speeds.clone());
            let mut simulation = Setup::new(body).scheme(scheme).step(0.002).prepare().unwrap();
            (0..10).for_each(|_| simulation.advance(0.05).unwrap());
            moved.push(simulation.shape(0).unwrap().control_vertices().to_vec());
        }
        let drift: Vector = (0..m * n).map(|k| moved[0][k] - points[k]).sum::<Vector>() / (m * n) as f64;
        let way = |k: usize| (moved[0][k] - points[k] - drift).norm();
        let most = (0..m * n).map(way).fold(0.0, f64::max);
        let apart = (0..m * n).map(|k| (moved[0][k] - moved[1][k]).norm()).fold(0.0, f64::max);
        assert!(most > 0.2 && apart < 0.02 * most, "{scheme:?}: {apart} of {most}");
    }
}
