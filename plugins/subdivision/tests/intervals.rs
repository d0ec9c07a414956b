//! Catmull-Clark refinement by knot intervals.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::Point;
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::{Direction, Surface};
use loftsman_subdivision::Cage;
use loftsman_subdivision::catmull_clark::{Refinement, limit_points, refine, refine_times};

fn apart(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most: f64, (p, q)| most.max((p - q).norm()))
}

/// A torus with an interval for each row and column, and its spline.
fn torus(zero: bool) -> (Cage, Surface, [usize; 2]) {
    let size = [5, 6];
    let [rows, columns] = size;
    let d = |axis: usize, k: usize| {
        if zero && k == 2 { 0.0 } else { 1.0 + 0.9 * crate::shapes::noise((axis * 100 + k) as u64) }
    };
    let mut cage = crate::shapes::grid(rows, columns, [true, true], 0.4);
    let at = |i: usize, j: usize| i % rows * columns + j % columns;
    for i in 0..rows {
        for j in 0..columns {
            cage = cage.with_interval(at(i, j), at(i + 1, j), d(0, i)).unwrap();
            cage = cage.with_interval(at(i, j), at(i, j + 1), d(1, j)).unwrap();
        }
    }
    let [u, v] = [0, 1].map(|axis| {
        let n = size[axis];
        // The support of vertex i starts two intervals before its place.
        let mut knots = vec![0.0];
        (0..n).for_each(|j| knots.push(knots[j] + d(axis, (j + n - 2) % n)));
        Space::periodic(3, knots).unwrap()
    });
    let spline = Surface::new(u, v, cage.points().to_vec()).unwrap();
    (cage, spline, size)
}

fn with_middles(spline: &Surface) -> Surface {
    let mut spline = spline.clone();
    for direction in [Direction::U, Direction::V] {
        let knots = spline.space(direction).breakpoints();
        let middles: Vec<f64> = knots.windows(2).map(|p| 0.5 * (p[0] + p[1])).collect();
        spline = spline.insert_knots(direction, &middles).unwrap();
    }
    spline
}

#[test]
fn a_grid_is_the_spline_with_knots_inserted() {
    let (cage, spline, [rows, columns]) = torus(false);
    let once = with_middles(&spline);
    let fine = refine(&cage).unwrap();
    // Vertex i is vertex 2i + 2 of the spline, the edge after it 2i + 3.
    let at = |i: usize, j: usize| once.points()[i % (2 * rows) * 2 * columns + j % (2 * columns)];
    let (vertices, edges) = (rows * columns, cage.topology().edge_count());
    for v in 0..vertices {
        assert!((fine.points()[v] - at(2 * (v / columns) + 2, 2 * (v % columns) + 2)).norm() < 1e-14);
    }
    for face in 0..cage.topology().face_count() {
        let (i, j) = (face / columns, face % columns);
        assert!((fine.points()[vertices + edges + face] - at(2 * i + 3, 2 * j + 3)).norm() < 1e-14);
        // The first edge of a face runs along u.
        let edge = cage.topology().face_edges(face)[0] as usize;
        assert!((fine.points()[vertices + edge] - at(2 * i + 3, 2 * j + 2)).norm() < 1e-14);
    }
    // And again, so that intervals are handed on rightly.
    let finer = refine(&fine).unwrap();
    let twice = with_middles(&once);
    for point in finer.points() {
        let near = twice.points().iter().map(|p| (p - point).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}

/// Zero intervals are split into zeros: all of it still lies on the spline with a double knot.
#[test]
fn zero_intervals_make_double_knots() {
    let (cage, spline, _) = torus(true);
    let fine = refine(&cage).unwrap();
    let once = with_middles(&spline);
    // Every vertex of the spline is there.
    for p in once.points() {
        let near = fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}

#[test]
fn equal_intervals_are_none() {
    for (name, cage) in crate::shapes::all() {
        for interval in [1.0, 3.7e-3] {
            let mut same = cage.clone();
            for edge in 0..cage.topology().edge_count() {
                let [a, b] = cage.topology().edge(edge).unwrap();
                same = same.with_interval(a as usize, b as usize, interval).unwrap();
            }
            let (a, b) = (refine_times(&cage, 2).unwrap(), refine_times(&same, 2).unwrap());
            assert!(apart(a.points(), b.points()) < 1e-14, "{name}: {:e}", apart(a.points(), b.points()));
            assert!(apart(&limit_points(&cage).unwrap(), &limit_points(&same).unwrap()) < 1e-14);
        }
    }
}

#[test]
fn any_intervals_give_affine_rows() {
    for (name, cage) in crate::shapes::all().into_iter().step_by(2) {
        let mut uneven = cage.clone();
        for edge in 0..cage.topology().edge_count() {
            let [a, b] = cage.topology().edge(edge).unwrap();
            // A third of them zero.
            let d = (1.0 + 1.5 * crate::shapes::noise(edge as u64)).max(0.0);
            uneven = uneven.with_interval(a as usize, b as usize, d).unwrap();
        }
        let refinement = Refinement::new(uneven, 2).unwrap();
        for level in 1..=2 {
            for (v, row) in refinement.stencils(level).unwrap().iter().enumerate() {
                let total: f64 = row.coefficients().iter().sum();
                assert!((total - 1.0).abs() < 1e-14, "{name}: {total}");
                let p = refinement.levels()[level].points()[v];
                assert!((row.apply(cage.points()) - p.coords).norm() < 1e-13, "{name}");
            }
        }
    }
}

/// The edge of a grid is the cubic spline of its own vertices, by their intervals.
#[test]
fn the_boundary_is_a_spline_of_its_own() {
    use loftsman_subdivision::{BoundaryRule, Polygon, Scheme};
    let n = 7;
    let mut cage = crate::shapes::grid(n, 3, [true, false], 0.3).with_boundary(BoundaryRule::EdgeOnly);
    let d: Vec<f64> = (0..n).map(|k| 1.0 + 0.8 * crate::shapes::noise(k as u64)).collect();
    for i in 0..n {
        for j in 0..3 {
            cage = cage.with_interval(3 * i + j, 3 * ((i + 1) % n) + j, d[i]).unwrap();
        }
    }
    let rim: Vec<Point> = (0..n).map(|i| cage.points()[3 * i]).collect();
    let polygon = Polygon::new(Scheme::Cubic, rim, true).unwrap().with_intervals(d).unwrap().refine_times(2);
    let fine = refine_times(&cage, 2).unwrap();
    for p in polygon.points() {
        let near = fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}
