//! Edges of polygons and meshes scaled.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::Springs;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

fn ring(n: usize, size: f64) -> Vec<Point> {
    let at = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
    (0..n).map(|i| Point::new(3.0 * at(i).cos(), 2.0 * at(i).sin(), (5.0 * at(i)).sin()) * size).collect()
}

/// A grid of quads, bent.
fn grid(n: usize, size: f64) -> Mesh {
    let points = (0..n * n).map(|k| ((k / n) as f64, (k % n) as f64));
    let points = points.map(|(x, y)| Point::new(x, y, (0.4 * x).sin() * (0.3 * y).cos()) * size).collect();
    let faces: Vec<[usize; 4]> = (0..(n - 1) * (n - 1))
        .map(|k| (k / (n - 1)) * n + k % (n - 1))
        .map(|a| [a, a + n, a + n + 1, a + 1])
        .collect();
    Mesh::new(points, &faces).unwrap()
}

#[test]
fn one_changes_nothing_and_a_constant_scales_about_the_pin() {
    for size in [1.0, 1e-9, 1e9] {
        let mesh = grid(9, size);
        for (alpha, pin) in [(1.0, 0), (0.4, 17), (3.0, 80)] {
            let mut springs = Springs::of_mesh(&mesh);
            springs.scale_all(alpha);
            springs.pin(pin).unwrap();
            let tuned = springs.solve(mesh.points()).unwrap();
            assert!(tuned.strain < 1e-12, "{}", tuned.strain);
            let fixed = mesh.points()[pin];
            for (before, after) in mesh.points().iter().zip(&tuned.points) {
                assert!((fixed + (before - fixed) * alpha - after).norm() < 1e-11 * size, "{size} {alpha}");
            }
        }
    }
}

/// Around a closed polygon every edge gives way by the same vector: the closing error over the number of edges.
#[test]
fn the_closing_error_is_spread() {
    for n in [3, 4, 12, 200] {
        let points = ring(n, 1.0);
        let alpha = |i: usize| 0.5 + (i * 7 % 5) as f64 / 4.0;
        let mut springs = Springs::of_polygon(n, true);
        (0..n).for_each(|i| springs.scale([i, (i + 1) % n], alpha(i)).unwrap());
        let tuned = springs.solve(&points).unwrap();
        let edge = |p: &[Point], i: usize| p[(i + 1) % n] - p[i];
        let error = (0..n).fold(Vector::zeros(), |sum, i| sum + edge(&points, i) * alpha(i)) / n as f64;
        for i in 0..n {
            let expected = edge(&points, i) * alpha(i) - error;
            assert!((edge(&tuned.points, i) - expected).norm() < 1e-11, "{n}");
        }
        assert_eq!(tuned.points[0], points[0]);
    }
    // An open one closes no loop: each edge is what it wants to be.
    let points = ring(9, 1.0);
    let mut springs = Springs::of_polygon(9, false);
    springs.scale([3, 4], 2.0).unwrap();
    assert!(springs.solve(&points).unwrap().strain < 1e-14);
}

/// The answer is the least: no vertex can be moved to make the sum of squares smaller. Rigid motions commute with it.
#[test]
fn springs_are_in_balance() {
    let mesh = grid(7, 1.0);
    let mut springs = Springs::of_mesh(&mesh);
    let factor = |a: usize, b: usize| 0.6 + ((a * 13 + b * 7) % 9) as f64 / 8.0;
    let mut edges = Vec::new();
    for face in mesh.faces() {
        for k in 0..4 {
            let (a, b) = (face[k] as usize, face[(k + 1) % 4] as usize);
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges.iter().for_each(|[a, b]| springs.scale([*a, *b], factor(*a, *b)).unwrap());
    springs.pin(0).unwrap();
    springs.pin(48).unwrap();
    let tuned = springs.solve(mesh.points()).unwrap();
    let mut force = vec![Vector::zeros(); 49];
    for &[a, b] in &edges {
        let missing =
            (mesh.points()[b] - mesh.points()[a]) * factor(a, b) - (tuned.points[b] - tuned.points[a]);
        force[a] -= missing;
        force[b] += missing;
    }
    for (vertex, force) in force.iter().enumerate().filter(|(v, _)| ![0, 48].contains(v)) {
        assert!(force.norm() < 1e-12, "{vertex}: {force}");
    }
    assert!(tuned.strain > 0.05);
    let turn = Rotation3::from_euler_angles(0.5, 1.1, -0.3);
    let by = Vector::new(5.0, -3.0, 2.0);
    let moved: Vec<Point> = mesh.points().iter().map(|p| turn * p + by).collect();
    let other = springs.solve(&moved).unwrap();
    for (a, b) in tuned.points.iter().zip(&other.points) {
        assert!((turn * a + by - b).norm() < 1e-11);
    }
}

#[test]
fn pieces_and_what_is_refused() {
    let mut points = ring(4, 1.0);
    points.extend(ring(3, 2.0).iter().map(|p| p + Vector::new(20.0, 0.0, 0.0)));
    let mesh = Mesh::new(points, &[&[0, 1, 2, 3][..], &[4, 5, 6]]).unwrap();
    let mut springs = Springs::of_mesh(&mesh);
    springs.scale_all(0.5);
    let tuned = springs.solve(mesh.points()).unwrap();
    assert_eq!((tuned.points[0], tuned.points[4]), (mesh.points()[0], mesh.points()[4]));
    assert!(springs.scale([0, 2], 1.0).unwrap_err().to_string().contains("no edge between vertices 0 and 2"));
    assert!(springs.pin(7).unwrap_err().to_string().contains('7'));
    springs.scale([0, 1], -1.0).unwrap();
    let error = springs.solve(mesh.points()).unwrap_err().to_string();
    assert!(error.contains("-1") && error.contains("vertices 0 and 1"), "{error}");
    springs.any_sign();
    assert!(springs.solve(mesh.points()).is_ok());
    assert!(springs.solve(&mesh.points()[1..]).is_err());
    assert!(Springs::of_polygon(0, true).solve(&[]).unwrap().points.is_empty());
    assert_eq!(Springs::of_polygon(1, false).solve(&[Point::origin()]).unwrap().points.len(), 1);
}
