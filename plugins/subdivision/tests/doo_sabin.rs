//! Doo-Sabin surfaces: their rules, and that grids are quadratic splines.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::Point;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::{Direction, Surface};
use loftsman_subdivision::doo_sabin::{limit_frames, limit_stencils, refine, refine_times, stencil};
use loftsman_subdivision::{Cage, LimitFrame};

#[test]
fn corners_become_what_doo_and_sabin_say() {
    for n in 3..12 {
        let cage = crate::shapes::one_face(n);
        for corner in 0..n {
            let row = stencil(&cage, corner).unwrap();
            for (vertex, weight) in row.iter() {
                let j = (vertex + n - corner) % n;
                let wave = 3.0 + 2.0 * (std::f64::consts::TAU * j as f64 / n as f64).cos();
                let expected = if j == 0 { n as f64 + 5.0 } else { wave } / (4.0 * n as f64);
                assert!((weight - expected).abs() < 1e-15, "{n} {j}: {weight} {expected}");
            }
        }
    }
}

#[test]
fn a_cube_becomes_26_faces() {
    let fine = refine(&crate::shapes::cube()).unwrap();
    let sizes = |cage: &Cage, n: usize| {
        (0..cage.topology().face_count()).filter(|&f| cage.topology().face(f).len() == n).count()
    };
    assert_eq!((fine.points().len(), sizes(&fine, 4), sizes(&fine, 3)), (24, 18, 8));
    assert!((0..24).all(|v| fine.topology().valence(v) == 4));
}

#[test]
fn rows_give_the_points_and_faces_keep_their_middle() {
    for (name, cage) in crate::shapes::all() {
        let fine = refine(&cage).unwrap();
        for v in 0..fine.points().len() {
            let row = stencil(&cage, v).unwrap();
            assert!((row.apply(cage.points()) - fine.points()[v].coords).norm() < 1e-14, "{name}");
            assert!((row.coefficients().iter().sum::<f64>() - 1.0).abs() < 1e-14, "{name}");
        }
        let (before, after) =
            (limit_frames(&cage).unwrap(), limit_frames(&refine_times(&fine, 2).unwrap()).unwrap());
        for (f, (a, b)) in before.iter().zip(after).enumerate() {
            assert!((a.point - b.point).norm() < 1e-14, "{name}");
            for k in 0..2 {
                assert!((a.tangents[k] / 8.0 - b.tangents[k]).norm() < 1e-14, "{name}: eigenvalue one half");
            }
            let rows = limit_stencils(&cage, f).unwrap();
            assert!((rows.position.apply(cage.points()) - a.point.coords).norm() < 1e-14);
            assert!((rows.tangents[1].apply(cage.points()) - a.tangents[1]).norm() < 1e-13);
        }
    }
    assert!(
        stencil(&crate::shapes::cube(), 24).is_err() && limit_stencils(&crate::shapes::cube(), 6).is_err()
    );
}

/// An open grid is a floating spline; its middles at all levels lie on it.
#[test]
fn a_grid_is_a_biquadratic_spline() {
    let (rows, columns) = (5, 4);
    let cage = crate::shapes::grid(rows, columns, [false, false], 0.4);
    let [u, v] = [rows, columns].map(|n| Space::floating_uniform(2, n).unwrap());
    let spline = Surface::new(u, v, cage.points().to_vec()).unwrap();
    let frames = limit_frames(&cage).unwrap();
    for (f, frame) in frames.iter().enumerate() {
        let (i, j) = (f / (columns - 1), f % (columns - 1));
        assert!((frame.point - spline.point(i as f64, j as f64).unwrap()).norm() < 1e-14);
    }
    let fine = refine(&cage).unwrap();
    let on = limit_frames(&fine).unwrap();
    for frame in &on {
        let near = spline.closest(frame.point).unwrap();
        assert!(near.distance < 1e-12, "{}", near.distance);
    }
}

/// The intervals of a torus of `rows × columns` vertices, and its spline.
fn by_intervals(equal: bool) -> (Cage, Surface, [usize; 2]) {
    let size = [5, 6];
    let [rows, columns] = size;
    let d = |axis: usize, k: usize| {
        if equal { 2.5 } else { 1.0 + 0.9 * crate::shapes::noise((axis * 100 + k) as u64) }
    };
    let mut cage = crate::shapes::grid(rows, columns, [true, true], 0.4);
    let at = |i: usize, j: usize| i % rows * columns + j % columns;
    for i in 0..rows {
        for j in 0..columns {
            for (next, axis, k) in [
                (at(i + 1, j), 0, i),
                (at(i + rows - 1, j), 0, i),
                (at(i, j + 1), 1, j),
                (at(i, j + columns - 1), 1, j),
            ] {
                cage = cage.with_end_interval(at(i, j), next, d(axis, k)).unwrap();
            }
        }
    }
    let spaces = [0, 1].map(|axis| {
        let n = size[axis];
        // Span j is the interval of the vertex whose support starts one knot before.
        let mut knots = vec![0.0];
        (0..n).for_each(|j| knots.push(knots[j] + d(axis, (j + n - 1) % n)));
        Space::periodic(2, knots).unwrap()
    });
    let [u, v] = spaces;
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
fn by_intervals_a_grid_is_the_spline_with_knots_inserted() {
    let (cage, spline, [rows, columns]) = by_intervals(false);
    let (once, twice) = (with_middles(&spline), with_middles(&with_middles(&spline)));
    let fine = refine(&cage).unwrap();
    let topology = cage.topology();
    let mut place = vec![[0; 2]; fine.points().len()];
    for face in 0..topology.face_count() {
        let (i, j) = (face / columns, face % columns);
        for h in topology.face_corners(face) {
            let v = topology.corners()[h] as usize;
            // The low end of an edge i, i + 1 is vertex 2i + 2 of the spline, the high end 2(i + 1) + 1.
            let one = |edge: usize, own: usize, n: usize| if own == edge { 2 * own + 2 } else { 2 * own + 1 } % (2 * n);
            place[h] = [one(i, v / columns, rows) % (2 * rows), one(j, v % columns, columns) % (2 * columns)];
            let expected = once.points()[place[h][0] * 2 * columns + place[h][1]];
            assert!((fine.points()[h] - expected).norm() < 1e-14, "{h}");
        }
    }
    // Once more: so the intervals are handed on rightly.
    let finer = refine(&fine).unwrap();
    for point in finer.points() {
        let near = twice.points().iter().map(|p| (p - point).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
    // The limits of faces are where knots cross, and their planes.
    let at = |space: &Space, i: usize| space.knots()[(i + 2) % space.len()];
    for (face, frame) in limit_frames(&cage).unwrap().iter().enumerate() {
        let (u, v) = (at(spline.u(), face / columns), at(spline.v(), face % columns));
        assert!((frame.point - spline.point(u, v).unwrap()).norm() < 1e-14, "{face}");
        let [a, b] = [(1, 0), (0, 1)]
            .map(|by| spline.value(Location::Surface(u, v), Derivative { u: by.0, v: by.1 }).unwrap());
        let normal = LimitFrame { tangents: [a, b], ..*frame }.normal().unwrap();
        assert!((frame.normal().unwrap() - normal).norm() < 1e-13, "{face}");
        let rows = limit_stencils(&cage, face).unwrap();
        assert!((rows.position.apply(cage.points()) - frame.point.coords).norm() < 1e-14);
    }
}

#[test]
fn equal_intervals_are_none() {
    let (cage, _, _) = by_intervals(true);
    let plain = Cage::from_topology(cage.points().to_vec(), cage.shared_topology()).unwrap();
    let (a, b) = (refine_times(&cage, 2).unwrap(), refine_times(&plain, 2).unwrap());
    let apart = |a: &Cage, b: &Cage| {
        a.points().iter().zip(b.points()).fold(0.0, |m: f64, (p, q)| m.max((p - q).norm()))
    };
    assert!(apart(&a, &b) < 1e-14);
    for (name, cage) in crate::shapes::all().into_iter().step_by(4) {
        let mut same = cage.clone();
        for edge in 0..cage.topology().edge_count() {
            let [a, b] = cage.topology().edge(edge).unwrap().map(|v| v as usize);
            same = same.with_end_interval(a, b, 3.0).unwrap().with_end_interval(b, a, 3.0).unwrap();
        }
        let (a, b) = (refine_times(&cage, 2).unwrap(), refine_times(&same, 2).unwrap());
        assert!(apart(&a, &b) < 1e-14, "{name}");
        assert!(limit_frames(&same).is_ok());
        // Nothing at all to go by: still points.
        let mut none = same;
        for edge in 0..cage.topology().edge_count() {
            let [a, b] = cage.topology().edge(edge).unwrap().map(|v| v as usize);
            none = none.with_end_interval(a, b, 0.0).unwrap().with_end_interval(b, a, 0.0).unwrap();
        }
        assert!(
            refine_times(&none, 2).unwrap().points().iter().all(|p: &Point| p.iter().all(|c| c.is_finite()))
        );
    }
}
