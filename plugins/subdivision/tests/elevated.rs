//! Biquadratic cages made bicubic, and tuned: against tensor-product splines and Doo and Sabin's own limits.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling, surface_alpha_spaces};
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{limit_frames, limit_points, refine_times};
use loftsman_subdivision::doo_sabin::{self, FineTune, elevated};
use loftsman_subdivision::{Cage, LimitFrame};

/// The biquadratic surface of an open grid.
fn spline(cage: &Cage, rows: usize, columns: usize) -> Surface {
    let [u, v] = [rows, columns].map(|n| Space::floating_uniform(2, n).unwrap());
    Surface::new(u, v, cage.points().to_vec()).unwrap()
}

/// The parameters of the elevated vertices of a grid: where the limits of its corners are.
fn parameters(cage: &Cage, columns: usize) -> Vec<[f64; 2]> {
    let topology = cage.topology();
    // Face (i, j) is where knots i and j cross; all its corners come there.
    let face = |f: usize| [(f / (columns - 1)) as f64, (f % (columns - 1)) as f64];
    (0..topology.face_count()).flat_map(|f| vec![face(f); topology.face(f).len()]).collect()
}

#[test]
fn a_grid_is_the_same_surface() {
    for (rows, columns, size) in [(5, 4, 1.0), (3, 3, 1e-9), (6, 5, 1e9)] {
        let mut cage = crate::shapes::grid(rows, columns, [false, false], 0.4);
        cage.points_mut().iter_mut().for_each(|p| *p *= size);
        let surface = spline(&cage, rows, columns);
        let fine = elevated(&cage).unwrap();
        let points = limit_points(&fine).unwrap();
        for (point, [u, v]) in points.iter().zip(parameters(&cage, columns)) {
            let there = surface.point(u, v).unwrap();
            assert!((point - there).norm() < 2e-14 * size, "{u} {v}: {:e}", (point - there).norm() / size);
        }
        // And in between: on finer levels every vertex is on the surface, and so is its tangent plane.
        let finer = refine_times(&fine, 2).unwrap();
        let mut normals = 0;
        for frame in limit_frames(&finer).unwrap() {
            let near = surface.closest(frame.point).unwrap();
            assert!(near.distance < 1e-11 * size, "{:e}", near.distance / size);
            normals += usize::from(frame.normal().is_some());
        }
        assert!(normals > 50, "{normals}");
    }
}

/// Round inner vertices of four quads the surface is Doo and Sabin's; in the middle of inner faces point and plane are.
#[test]
fn what_is_kept_of_any_form() {
    let mut count = [0; 3];
    for (name, cage) in crate::shapes::all() {
        let topology = cage.topology();
        let fine = elevated(&cage).unwrap();
        let (expected, frames) = (doo_sabin::limit_frames(&cage).unwrap(), limit_frames(&fine).unwrap());
        for (face, expected) in expected.iter().enumerate() {
            if topology.face(face).iter().any(|&v| topology.is_boundary_vertex(v as usize)) {
                continue;
            }
            for h in topology.face_corners(face) {
                let off = (frames[h].point - expected.point).norm();
                assert!(off < 4e-15, "{name}, face {face}: {off:e}");
                count[0] += 1;
                let valence = topology.valence(topology.corners()[h] as usize);
                if let (true, Some(one), Some(other)) = (valence > 2, frames[h].normal(), expected.normal()) {
                    assert!((one - other).norm() < 1e-7, "{name}, face {face}: {one} {other}");
                    count[1] += 1;
                }
            }
            for &edge in fine.topology().face_edges(face) {
                let [a, b] = fine.topology().edge(edge as usize).unwrap().map(|v| v as usize);
                assert_eq!(fine.interval(edge as usize), 0.0);
                assert!((frames[a].point - frames[b].point).norm() < 4e-15, "{name}");
                count[2] += 1;
            }
        }
    }
    assert!(count[0] > 500 && count[1] > 300 && count[2] > 500, "{count:?}");
}

#[test]
fn one_changes_nothing_a_constant_scales_and_motions_commute() {
    let turn = |v: &Vector| Vector::new(-v.y, v.x, v.z);
    for (name, cage) in crate::shapes::all().into_iter().step_by(3) {
        let plain = elevated(&cage).unwrap();
        let mut tune = FineTune::new(cage.clone());
        let same = tune.solve().unwrap();
        assert!(same.strain < 1e-15, "{name}: {}", same.strain);
        assert_eq!(same.cage.points(), plain.points());
        tune.pin(0).unwrap();
        tune.scale_all(1.75);
        let fixed = plain.points()[cage.topology().around(0).next().unwrap() as usize];
        let scaled = tune.solve().unwrap();
        let one_pin = cage.topology().around(0).count() == 1;
        for (a, b) in plain.points().iter().zip(scaled.cage.points()).filter(|_| one_pin) {
            assert!((fixed + (a - fixed) * 1.75 - b).norm() < 1e-12, "{name}");
        }
        for edge in (0..cage.topology().edge_count()).step_by(3) {
            let [a, b] = cage.topology().edge(edge).unwrap().map(|v| v as usize);
            tune.scale([a, b], 0.6 + 0.1 * (edge % 7) as f64).unwrap();
        }
        let tuned = tune.solve().unwrap();
        let mut moved = cage.clone();
        moved
            .points_mut()
            .iter_mut()
            .for_each(|p| *p = Point::from(turn(&p.coords) + Vector::new(5.0, -3.0, 2.0)));
        let mut other = FineTune::new(moved);
        for edge in 0..cage.topology().edge_count() {
            let [a, b] = cage.topology().edge(edge).unwrap().map(|v| v as usize);
            let alpha = if edge.is_multiple_of(3) { 0.6 + 0.1 * (edge % 7) as f64 } else { 1.75 };
            other.scale([a, b], alpha).unwrap();
        }
        other.pin(0).unwrap();
        let other = other.solve().unwrap();
        for (a, b) in tuned.cage.points().iter().zip(other.cage.points()) {
            assert!((turn(&a.coords) + Vector::new(5.0, -3.0, 2.0) - b.coords).norm() < 1e-12, "{name}");
        }
        assert!((tuned.strain - other.strain).abs() < 1e-12 && (one_pin || tuned.strain > 1e-3), "{name}");
    }
}

/// Tuned forms have a tangent plane in the middle of each inner face, the same from all sides, and so have their zero edges one point.
#[test]
fn tuned_forms_are_smooth_in_the_middle_of_faces() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all() {
        let topology = cage.topology();
        let mut tune = FineTune::new(cage.clone());
        for edge in 0..topology.edge_count() {
            let [a, b] = topology.edge(edge).unwrap().map(|v| v as usize);
            tune.scale([a, b], 0.7 + 0.1 * ((edge * 5) % 7) as f64).unwrap();
        }
        let frames = limit_frames(&tune.solve().unwrap().cage).unwrap();
        for face in 0..topology.face_count() {
            let inner =
                |v: &u32| !topology.is_boundary_vertex(*v as usize) && topology.valence(*v as usize) > 2;
            if !topology.face(face).iter().all(inner) {
                continue;
            }
            let own: Vec<&LimitFrame> = topology.face_corners(face).map(|h| &frames[h]).collect();
            for pair in own.windows(2) {
                assert!((pair[0].point - pair[1].point).norm() < 1e-14, "{name}, face {face}");
                let [a, b] = [pair[0].normal().unwrap(), pair[1].normal().unwrap()];
                assert!((a - b).norm() < 1e-6, "{name}, face {face}: {a} {b}");
                count += 1;
            }
        }
    }
    // A prism of seven sides: its ends have seven corners.
    let n = 7;
    let at = |k: usize| {
        let t = std::f64::consts::TAU * (k % n) as f64 / n as f64;
        Point::new(
            t.cos(),
            t.sin() + 0.1 * crate::shapes::noise(k as u64),
            (k / n) as f64 + 0.2 * crate::shapes::noise(k as u64 + 40),
        )
    };
    let mut faces = vec![(0..n).rev().collect::<Vec<_>>(), (n..2 * n).collect()];
    faces.extend((0..n).map(|a| vec![a, (a + 1) % n, n + (a + 1) % n, n + a]));
    let prism = Cage::new((0..2 * n).map(at).collect(), &faces).unwrap();
    let mut tune = FineTune::new(prism.clone());
    (0..n).for_each(|a| tune.scale([a, (a + 1) % n], 0.6 + 0.15 * a as f64).unwrap());
    let frames = limit_frames(&tune.solve().unwrap().cage).unwrap();
    for face in 0..2 {
        let own: Vec<&LimitFrame> = prism.topology().face_corners(face).map(|h| &frames[h]).collect();
        for pair in own.windows(2) {
            assert!((pair[0].point - pair[1].point).norm() < 1e-14);
            assert!((pair[0].normal().unwrap() - pair[1].normal().unwrap()).norm() < 1e-7, "{face}");
        }
    }
    assert!(count > 100, "{count}");
}

/// α at the inner knots as a spline function along `u` of the surface.
fn along(space: &Space, alpha: &[f64]) -> Function<f64> {
    Function::new(space.clone(), alpha.to_vec()).unwrap()
}

/// The surface of α(u) along one direction alone: lines across are left out, the first row of points stays.
#[test]
fn along_one_direction_it_is_the_tensor_product() {
    let (rows, columns) = (6, 5);
    let cage = crate::shapes::grid(rows, columns, [false, false], 0.35);
    let surface = spline(&cage, rows, columns);
    let [space, across] = surface_alpha_spaces(&surface).unwrap();
    // α(u) is linear with a value at each knot; α(u, v) has values for each line, but is constant across here or not.
    let at_knots: Vec<f64> = (0..rows - 1).map(|i| 0.5 + 0.3 * ((i * 5) % 4) as f64).collect();
    assert_eq!((space.degree(), space.len(), across.len()), (1, rows - 1, columns - 1));
    let expected =
        FineTuneSurface::new(&surface, Scaling::Directional { u: Some(along(&space, &at_knots)), v: None })
            .ends(Ends::Free)
            .solve()
            .unwrap();
    let mut tune = FineTune::new(cage.clone());
    let at = |i: usize, j: usize| i * columns + j;
    for i in 0..rows {
        for j in 0..columns {
            if i + 1 < rows {
                tune.scale([at(i, j), at(i + 1, j)], at_knots[i]).unwrap();
            }
            if j + 1 < columns {
                tune.leave_out([at(i, j), at(i, j + 1)]).unwrap();
            }
        }
    }
    (0..columns).for_each(|j| tune.pin(at(0, j)).unwrap());
    let tuned = tune.solve().unwrap();
    assert!(tuned.strain < 1e-14, "{}", tuned.strain);
    let points = limit_points(&tuned.cage).unwrap();
    let mut most: f64 = 0.0;
    for (point, [u, v]) in points.iter().zip(parameters(&cage, columns)) {
        most = most.max((point - expected.surface().point(u, v).unwrap()).norm());
    }
    assert!(most < 4e-14, "{most:e}");
    // Everywhere, not only at knots.
    let finer = refine_times(&tuned.cage, 2).unwrap();
    for point in limit_points(&finer).unwrap() {
        let near = expected.surface().closest(point).unwrap();
        assert!(near.distance < 1e-11, "{:e}", near.distance);
    }
}

/// A grid that is a sum of two polygons: both directions at once, α(u) and β(v).
#[test]
fn a_sum_of_polygons_is_tuned_in_both_directions() {
    let (rows, columns) = (5, 6);
    let mut cage = crate::shapes::grid(rows, columns, [false, false], 0.0);
    let part = |seed: u64, k: usize| {
        Vector::new(
            crate::shapes::noise(seed + 3 * k as u64),
            crate::shapes::noise(seed + 50 + k as u64),
            k as f64,
        )
    };
    for (k, p) in cage.points_mut().iter_mut().enumerate() {
        *p = Point::from(part(1, k / columns) + part(900, k % columns));
    }
    let surface = spline(&cage, rows, columns);
    let [u, v] = surface_alpha_spaces(&surface).unwrap();
    let alpha: Vec<f64> = (0..rows - 1).map(|i| 0.4 + 0.35 * i as f64).collect();
    let beta: Vec<f64> = (0..columns - 1).map(|i| 1.4 - 0.2 * i as f64).collect();
    let scaling = Scaling::Directional { u: Some(along(&u, &alpha)), v: Some(along(&v, &beta)) };
    let expected = FineTuneSurface::new(&surface, scaling).ends(Ends::Free).solve().unwrap();
    let mut tune = FineTune::new(cage.clone());
    let at = |i: usize, j: usize| i * columns + j;
    for i in 0..rows {
        for j in 0..columns {
            if i + 1 < rows {
                tune.scale([at(i, j), at(i + 1, j)], alpha[i]).unwrap();
            }
            if j + 1 < columns {
                tune.scale([at(i, j), at(i, j + 1)], beta[j]).unwrap();
            }
        }
    }
    tune.pin(0).unwrap();
    let tuned = tune.solve().unwrap();
    assert!(tuned.strain < 1e-14, "{}", tuned.strain);
    for (point, [u, v]) in limit_points(&tuned.cage).unwrap().iter().zip(parameters(&cage, columns)) {
        assert!((point - expected.surface().point(u, v).unwrap()).norm() < 2e-14);
    }
}

/// The answer is the least: at every vertex that may move the springs are in balance; and errors name the edge.
#[test]
fn what_is_refused() {
    let mut tune = FineTune::new(crate::shapes::cube());
    assert!(tune.scale([0, 7], 2.0).unwrap_err().to_string().contains("0 and 7"));
    assert!(tune.pin(8).unwrap_err().to_string().contains('8'));
    for alpha in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        tune.scale([6, 7], alpha).unwrap();
        let error = tune.solve().unwrap_err().to_string();
        assert!(error.contains("vertices") && error.contains('6') && error.contains('7'), "{error}");
    }
    tune.any_sign();
    assert!(tune.solve().is_err());
    tune.scale([6, 7], -1.0).unwrap();
    assert!(tune.solve().is_ok());
    let uneven = crate::shapes::cube().with_end_interval(0, 1, 2.0).unwrap();
    assert!(elevated(&uneven).unwrap_err().to_string().contains("intervals"));
}
