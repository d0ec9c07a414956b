//! Limits by knot intervals: against tensor-product splines, against explicit levels, and where there are none.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use crate::shapes::levels::explicit;
use loftsman_kernel::shape::{Derivative, Location, Shape, Side, Sides};
use loftsman_kernel::space::Space;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{limit_frames, limit_points, limit_stencils, refine, sectors};
use loftsman_subdivision::{Cage, LimitFrame};

fn place(space: &Space, i: usize) -> f64 {
    space.knots()[(i + 2) % space.len()]
}

fn normal(a: Vector, b: Vector) -> Option<Vector> {
    LimitFrame { point: Point::origin(), tangents: [a, b] }.normal()
}

fn stirred(count: usize, seed: u64) -> Vec<f64> {
    (0..count as u64).map(|k| 1.0 + 0.95 * crate::shapes::noise(100 * seed + k)).collect()
}

#[test]
fn a_grid_is_a_tensor_product_spline() {
    let mut seen = [0; 3];
    for seed in 0..6 {
        let (mut rows, mut columns) = (stirred(6, seed), stirred(7, seed + 50));
        // Double knots, in one direction, in both; triple ones.
        match seed {
            1 => rows[2] = 0.0,
            2 => (rows[2], columns[3]) = (0.0, 0.0),
            3 => (rows[1], rows[3], columns[0], columns[4]) = (0.0, 0.0, 0.0, 0.0),
            4 => (rows[2], rows[3]) = (0.0, 0.0),
            5 => (rows[2], rows[3], columns[4], columns[5]) = (0.0, 0.0, 0.0, 0.0),
            _ => {}
        }
        let (mut cage, spline) = crate::shapes::torus(&rows, &columns);
        let at = |v: usize| {
            let (i, j) = (v / columns.len(), v % columns.len());
            Location::Surface(place(spline.u(), i), place(spline.v(), j))
        };
        for level in 0..3 {
            let points = limit_points(&cage).unwrap();
            let frames = limit_frames(&cage).unwrap();
            // The vertices of the cage keep their numbers, and their places while their limits do.
            for v in 0..rows.len() * columns.len() {
                let p = spline.value(at(v), Derivative { u: 0, v: 0 }).unwrap();
                assert!((points[v].coords - p).norm() < 4e-15 * 8.0, "{seed}, level {level}, vertex {v}");
                assert_eq!(points[v], frames[v].point);
                let (i, j) = (v / columns.len(), v % columns.len());
                let corner = |d: &[f64], k: usize| d[k] == 0.0 && d[(k + d.len() - 1) % d.len()] == 0.0;
                let Some(found) = frames[v].normal() else {
                    assert!(corner(&rows, i) || corner(&columns, j) || level > 0, "{seed}: {v}");
                    seen[1] += 1;
                    continue;
                };
                // At a triple knot a vertex has the tangents of the side that it is on.
                let side = |d: &[f64], k: usize| if d[k] == 0.0 { Side::Left } else { Side::Right };
                let sides = Sides { u: side(&rows, i), v: side(&columns, j) };
                let [a, b] = [[1, 0], [0, 1]].map(|[by_u, by_v]| {
                    let row = spline.stencil_on(at(v), Derivative { u: by_u, v: by_v }, sides).unwrap();
                    row.apply(spline.points())
                });
                assert!((found - normal(a, b).unwrap()).norm() < 1e-12, "{seed}, level {level}, vertex {v}");
                seen[0] += 1;
            }
            if level == 0 {
                for v in [0, 8, 17, 30] {
                    if let Ok(rows) = limit_stencils(&cage, v, 0) {
                        assert!((rows.position.apply(cage.points()) - points[v].coords).norm() < 1e-14);
                        seen[2] += 1;
                    }
                }
            }
            cage = refine(&cage).unwrap();
        }
    }
    assert!(seen[0] > 500 && seen[1] > 40 && seen[2] > 15, "{seen:?}");
}

/// The cage with intervals that differ, one in `zeros` of them zero (none for 0).
fn uneven(cage: &Cage, spread: f64, zeros: u64) -> Cage {
    let topology = cage.topology();
    (0..topology.edge_count()).fold(cage.clone(), |cage, e| {
        let [a, b] = topology.edge(e).unwrap();
        let zero = zeros > 0 && (e as u64).is_multiple_of(zeros);
        let d = if zero { 0.0 } else { spread.powf(crate::shapes::noise(7 * e as u64 + 3)) };
        cage.with_interval(a as usize, b as usize, d).unwrap()
    })
}

/// Rows sum to one, go with the points, and are the limits that refinement by hand comes to.
#[test]
fn limits_are_where_refinement_goes() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all().into_iter().step_by(7) {
        for (spread, zeros) in [(3.0, 0), (30.0, 0), (2.0, 3)] {
            let cage = uneven(&cage, spread, zeros);
            let points = limit_points(&cage).unwrap_or_else(|e| panic!("{name}: {e}"));
            let fine = refine(&cage).unwrap();
            let finer = limit_points(&fine).unwrap();
            for v in [0, 1, 4].into_iter().filter(|&v| v < points.len()) {
                let context = format!("{name}, {spread} {zeros}, vertex {v}");
                assert!(
                    (points[v] - finer[v]).norm() < 2e-14,
                    "{context}: {:e}",
                    (points[v] - finer[v]).norm()
                );
                // What is left goes down by the same factor a level once the largest eigenvalue leads, to rounding: slowly (0.98) where
                // intervals differ by a thousand.
                let [some, less, least] =
                    [20, 30, 40].map(|k| (explicit(&cage, v, k).points()[0] - points[v]).norm());
                assert!(
                    least < 4e-14 || least < 0.9 * less && least < 1.5 * less * less / some,
                    "{context}: {some:e} {less:e} {least:e}"
                );
                count += 1;
            }
        }
    }
    assert!(count > 150, "{count}");
}

#[test]
fn rows_are_affine_and_turn_the_right_way() {
    let mut count = [0; 2];
    for (name, cage) in crate::shapes::all().into_iter().step_by(5) {
        let cage = uneven(&cage, 3.0, 0);
        let points = limit_points(&cage).unwrap();
        for v in 0..points.len().min(5) {
            for sector in 0..sectors(&cage, v).unwrap() {
                let Ok(rows) = limit_stencils(&cage, v, sector) else {
                    count[1] += 1;
                    continue;
                };
                let sum: f64 = rows.position.coefficients().iter().sum();
                assert!((sum - 1.0).abs() < 4e-15, "{name}, {v}: {sum}");
                assert!((rows.position.apply(cage.points()) - points[v].coords).norm() < 1e-14);
                for row in &rows.tangents {
                    let sum: f64 = row.coefficients().iter().sum();
                    assert!(sum.abs() < 1e-13, "{name}, {v}: {sum}");
                }
                // The plane is that of the refined cage, and it is turned the same way.
                let fine = refine(&cage).unwrap();
                let Ok(child) = limit_stencils(&fine, v, sector) else { panic!("{name}, {v}") };
                let [a, b] = rows.tangents.map(|t| t.apply(cage.points()));
                let [c, d] = child.tangents.map(|t| t.apply(fine.points()));
                if let (Some(one), Some(other)) = (normal(a, b), normal(c, d)) {
                    let off = (one - other).norm();
                    assert!(off < 1e-7, "{name}, vertex {v}, sector {sector}: {off:e}");
                    count[0] += 1;
                }
            }
        }
    }
    assert!(count[0] > 150, "{count:?}");
}
