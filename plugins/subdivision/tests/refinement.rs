//! Catmull-Clark refinement: its rules, its rows, what is inherited.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{Refinement, refine};
use loftsman_subdivision::{Cage, SubdivisionError, doo_sabin};

#[test]
fn a_cube_becomes_what_catmull_and_clark_say() {
    let cage = refine(&crate::shapes::cube()).unwrap();
    assert_eq!(
        (cage.points().len(), cage.topology().face_count(), cage.topology().edge_count()),
        (26, 24, 48)
    );
    // A vertex: P/3 + Σ E/9 + Σ F/9 = (5/27 + ...): by symmetry all coordinates are equal.
    let p = cage.points()[0];
    let expected = (3.0 * 0.0 + 1.0 + (0.0 + 0.5 + 0.5)) / 9.0;
    assert!((p - Point::new(expected, expected, expected)).norm() < 1e-15, "{p}");
    // An edge: a quarter of its ends and of its faces' points.
    for edge in 8..20 {
        let from_middle = cage.points()[edge] - Point::new(0.5, 0.5, 0.5);
        let mut sizes: Vec<f64> = from_middle.iter().map(|c| c.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        assert!(
            (sizes[0]).abs() < 1e-15 && (sizes[1] - 0.375).abs() < 1e-15 && (sizes[2] - 0.375).abs() < 1e-15
        );
    }
}

#[test]
fn rows_give_the_points_and_sum_to_one() {
    for (name, cage) in crate::shapes::all() {
        let refinement = Refinement::new(cage.clone(), 3).unwrap();
        for level in [1, 3] {
            let fine = &refinement.levels()[level];
            let stencils = refinement.stencils(level).unwrap();
            for (v, stencil) in stencils.iter().enumerate() {
                let from_row = stencil.apply(cage.points());
                assert!(
                    (from_row - fine.points()[v].coords).norm() < 1e-13,
                    "{name}: level {level}, vertex {v}"
                );
                let total: f64 = stencil.coefficients().iter().sum();
                assert!((total - 1.0).abs() < 1e-14, "{name}: level {level}, vertex {v}: {total}");
                assert!(stencil.coefficients().iter().all(|&c| c >= 0.0), "{name}");
            }
            assert_eq!(refinement.stencil(level, 0).unwrap(), stencils[0]);
        }
    }
}

#[test]
fn moved_points_are_refined_again() {
    let cage = crate::shapes::fan(5, 5, true, 0.1).with_crease(0, 1, 1.5).unwrap();
    let mut refinement = Refinement::new(cage.clone(), 3).unwrap();
    let shift = Vector::new(1.0, -2.0, 0.5);
    let moved: Vec<Point> = cage.points().iter().map(|p| Point::from(p.coords * 2.0) + shift).collect();
    let before = refinement.finest().clone();
    refinement.move_to(moved).unwrap();
    for (a, b) in before.points().iter().zip(refinement.finest().points()) {
        assert!((Point::from(a.coords * 2.0) + shift - b).norm() < 1e-14);
    }
    assert!(refinement.move_to(vec![Point::origin()]).is_err());
}

#[test]
fn creases_holes_and_parents_are_inherited() {
    let cage = crate::shapes::cube().with_crease(0, 1, 2.5).unwrap().with_crease(1, 3, 20.0).unwrap();
    let cage = cage.with_hole(2).unwrap().with_corner(7, 1.25).unwrap();
    let refinement = Refinement::new(cage, 2).unwrap();
    let one = &refinement.levels()[1];
    let sharp =
        |level: &Cage, s: f64| (0..level.topology().edge_count()).filter(|&e| level.crease(e) == s).count();
    assert_eq!((sharp(one, 1.5), sharp(one, 20.0)), (2, 2));
    let two = &refinement.levels()[2];
    assert_eq!((sharp(two, 0.5), sharp(two, 20.0)), (4, 4));
    assert_eq!((one.corner(7), two.corner(7)), (0.25, 0.0));
    for level in 0..3 {
        let cage = &refinement.levels()[level];
        for face in 0..cage.topology().face_count() {
            assert_eq!(cage.is_hole(face), refinement.base_face(level, face).unwrap() == 2);
        }
    }
    assert_eq!(two.to_mesh().unwrap().face_count(), 5 * 16);
    assert!(matches!(refinement.base_face(3, 0), Err(SubdivisionError::Missing { what: "level", .. })));
    assert!(matches!(refinement.base_face(1, 24), Err(SubdivisionError::Missing { what: "face", .. })));
}

#[test]
fn refinement_goes_with_maps() {
    for (name, cage) in crate::shapes::all().into_iter().step_by(3) {
        for size in [1e-9, 1e9] {
            let mut scaled = cage.clone();
            scaled.points_mut().iter_mut().for_each(|p| *p = Point::from(p.coords * size));
            let (a, b) = (Refinement::new(cage.clone(), 2).unwrap(), Refinement::new(scaled, 2).unwrap());
            for (p, q) in a.finest().points().iter().zip(b.finest().points()) {
                assert!((p.coords * size - q.coords).norm() < 1e-14 * size, "{name}");
            }
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let points = |n: usize| (0..n).map(|k| Point::new(k as f64, (k * k) as f64, 0.0)).collect::<Vec<_>>();
    let says = |n: usize, faces: &[&[usize]], what: &str| {
        let message = Cage::new(points(n), faces).unwrap_err().to_string();
        assert!(message.contains(what), "{message}");
    };
    says(3, &[], "face 0 is missing");
    says(3, &[&[0, 1]], "face 0 has 2 corners");
    says(3, &[&[0, 1, 3]], "face 0 refers to vertex 3, but there are only 3");
    says(4, &[&[0, 1, 2, 3], &[0, 1, 0]], "face 1 has vertex 0 twice");
    says(5, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]], "the edge between vertices 0 and 1 has 3 faces (0, 1, 2)");
    says(
        4,
        &[&[0, 1, 2], &[0, 1, 3]],
        "the edge between vertices 0 and 1 is run the same way by faces 0 and 1: turn face 1 over",
    );
    // Of a ring of six all but two run one way, and of a Möbius band of five no turning makes that of all.
    let ring = |k: usize| [2 * k, (2 * k + 2) % 12, (2 * k + 3) % 12, 2 * k + 1];
    let mut rings: Vec<Vec<usize>> = (0..6).map(|k| ring(k).to_vec()).collect();
    rings[2].reverse();
    rings[4].reverse();
    let rings: Vec<&[usize]> = rings.iter().map(Vec::as_slice).collect();
    says(12, &rings, "turn faces 2, 4 over");
    let band: &[&[usize]] = &[&[0, 2, 3, 1], &[2, 4, 5, 3], &[4, 6, 7, 5], &[6, 8, 9, 7], &[8, 1, 0, 9]];
    says(10, band, "one side only, as a Möbius band");
    says(4, &[&[0, 1, 2, 3], &[2, 3, 0, 1]], "faces 0 and 1, which have the same vertices: remove one");
    says(6, &[&[0, 1, 2, 3], &[1, 0, 4, 5], &[2, 1, 0, 3]], "faces 0 and 2, which have the same vertices");
    says(5, &[&[0, 1, 2], &[0, 3, 4]], "vertex 0 joins several fans of faces (1 of its 2");
    says(4, &[&[0, 1, 2]], "vertex 3 belongs to no face");
    let mut bad = points(3);
    bad[1].y = f64::NAN;
    assert!(Cage::new(bad, &[[0, 1, 2]]).unwrap_err().to_string().starts_with("vertex 1 is (1, NaN, 0)"));
    let cube = crate::shapes::cube();
    let message = |cage: Result<Cage, SubdivisionError>| cage.unwrap_err().to_string();
    assert!(message(cube.clone().with_crease(0, 7, 1.0)).contains("no edge between vertices 0 and 7"));
    assert!(message(cube.clone().with_crease(0, 99, 1.0)).contains("no edge between vertices 0 and 99"));
    assert!(message(cube.clone().with_crease(0, 1, -1.0)).contains("vertices 0 and 1 is -1"));
    assert!(message(cube.clone().with_crease(0, 1, f64::NAN)).contains("is NaN"));
    assert!(message(cube.clone().with_corner(8, 1.0)).contains("no vertex 8"));
    assert!(message(cube.clone().with_corner(1, -0.5)).contains("vertex 1 is -0.5"));
    assert!(message(cube.clone().with_interval(0, 1, -0.5)).contains("interval"));
    assert!(message(cube.clone().with_interval(0, 1, f64::INFINITY)).contains("interval"));
    assert!(message(cube.clone().with_end_interval(0, 1, f64::NAN)).contains("vertex 0 towards 1"));
    assert!(message(cube.with_hole(6)).contains("no face 6"));
}

/// Vertices less edges and faces: kept by Catmull and Clark's scheme on every cage, by Doo and Sabin's on those that are closed; of both each level
/// is as closed as the one before.
#[test]
fn eulers_characteristic_is_kept() {
    let euler = |cage: &Cage| {
        let topology = cage.topology();
        topology.vertex_count() as i64 - topology.edge_count() as i64 + topology.face_count() as i64
    };
    let rim = |cage: &Cage| {
        let topology = cage.topology();
        (0..topology.edge_count()).filter(|&e| topology.is_boundary_edge(e)).count()
    };
    let (mut all, mut closed) = (0, 0);
    for (name, cage) in crate::shapes::all() {
        let (mut fine, mut doo) = (cage.clone(), cage.clone());
        for level in 1..=3 {
            fine = refine(&fine).unwrap();
            assert_eq!(
                (euler(&fine), rim(&fine)),
                (euler(&cage), rim(&cage) << level),
                "{name}, level {level}"
            );
            all += 1;
            if rim(&cage) == 0 {
                doo = doo_sabin::refine_times(&doo, 1).unwrap();
                assert_eq!((euler(&doo), rim(&doo)), (euler(&cage), 0), "{name}, Doo-Sabin, level {level}");
                closed += 1;
            }
        }
    }
    assert!(all > 600 && closed > 100, "{all} {closed}");
}
