//! Whatever comes in: an answer or an error, never a panic.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::Point;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_subdivision::{BoundaryRule, Cage, Polygon, Scheme, catmull_clark, doo_sabin};
use proptest::prelude::*;

/// Everything that can be asked of a cage.
fn ask(cage: &Cage) {
    let refinement = catmull_clark::Refinement::new(cage.clone(), 2).unwrap();
    refinement.stencils(2).unwrap();
    let small = cage.points().iter().all(|p| p.coords.amax() < 1e300);
    for (depth, level) in refinement.levels().iter().enumerate() {
        assert!(!small || level.points().iter().all(|p| p.iter().all(|c| c.is_finite())));
        doo_sabin::refine_times(level, 2).unwrap();
        let _ = (doo_sabin::limit_frames(level), level.to_mesh());
        if level.has_intervals() {
            if depth == 0 {
                ask_uneven(level, small);
            }
            continue;
        }
        if let (Ok(points), Ok(frames)) =
            (catmull_clark::limit_points(level), catmull_clark::limit_frames(level))
        {
            assert_eq!(points.len(), frames.len());
            frames.iter().for_each(|f| assert!(f.normal().is_none_or(|n| (n.norm() - 1.0).abs() < 1e-12)));
            for vertex in 0..points.len() {
                for sector in 0..catmull_clark::sectors(level, vertex).unwrap() {
                    catmull_clark::limit_stencils(level, vertex, sector).unwrap();
                }
            }
            for face in 0..level.topology().face_count() {
                catmull_clark::patch_stencils(level, face).unwrap();
            }
        }
    }
}

/// What can be asked of one with intervals: limits are there and affine, or a vertex is named.
fn ask_uneven(cage: &Cage, small: bool) {
    let named = |error: String| assert!(error.starts_with("vertex "), "{error}");
    match catmull_clark::limit_frames(cage) {
        Ok(frames) => {
            for frame in frames.iter().filter(|_| small) {
                assert!(frame.point.iter().all(|c| c.is_finite()));
                assert!(frame.normal().is_none_or(|n| (n.norm() - 1.0).abs() < 1e-12));
            }
        }
        Err(error) => named(error.to_string()),
    }
    for vertex in 0..cage.points().len() {
        match catmull_clark::limit_stencils(cage, vertex, 0) {
            Ok(rows) => {
                let sum: f64 = rows.position.coefficients().iter().sum();
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            }
            Err(error) => named(error.to_string()),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_faces(faces in prop::collection::vec(prop::collection::vec(0usize..9, 0..6), 0..8)) {
        let points = (0..8).map(|k| Point::new(crate::shapes::noise(k), crate::shapes::noise(k + 9), crate::shapes::noise(k + 99)));
        if let Ok(cage) = Cage::new(points.collect(), &faces) {
            ask(&cage);
        }
    }

    #[test]
    fn some_faces_of_a_solid(
        which in 0usize..8,
        kept in prop::collection::vec(any::<bool>(), 40),
        sharp in prop::collection::vec(prop_oneof![Just(0.0), 0.0..3.0, Just(f64::INFINITY)], 40),
        intervals in prop::collection::vec(prop_oneof![Just(0.0), 0.0..3.0, Just(1e-100), Just(1e100)], 40),
        by_intervals in 0usize..4,
        size in prop_oneof![Just(1.0), Just(1e-300), Just(1e308), Just(0.0)],
    ) {
        let whole = match which {
            0 => crate::shapes::cube(),
            1 => crate::shapes::tetrahedron(),
            2 => crate::shapes::double_fan(7, 0.1),
            3 => crate::shapes::fan(6, 5, true, 0.1),
            4 => crate::shapes::pillow(5),
            5 => crate::shapes::grid(3, 4, [true, true], 0.1),
            6 => crate::shapes::grid(3, 4, [false, false], 0.1),
            _ => crate::shapes::fan(5, 3, false, 0.1),
        };
        // What is left of it, vertices numbered anew.
        let mut places = vec![usize::MAX; whole.points().len()];
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        for face in (0..whole.topology().face_count()).filter(|&f| kept[f % 40]) {
            faces.push(whole.topology().face(face).iter().map(|&v| {
                if places[v as usize] == usize::MAX {
                    places[v as usize] = points.len();
                    points.push(Point::from(whole.points()[v as usize].coords * size));
                }
                places[v as usize]
            }).collect::<Vec<_>>());
        }
        if let Ok(mut cage) = Cage::new(points, &faces) {
            if kept[0] { cage = cage.with_boundary(BoundaryRule::EdgeOnly); }
            for edge in 0..cage.topology().edge_count() {
                let [a, b] = cage.topology().edge(edge).unwrap().map(|v| v as usize);
                cage = cage.with_crease(a, b, sharp[edge % 40]).unwrap();
                if by_intervals % 2 == 1 { cage = cage.with_interval(a, b, intervals[edge % 40]).unwrap(); }
                if by_intervals > 1 { cage = cage.with_end_interval(a, b, intervals[edge % 40]).unwrap(); }
            }
            cage = cage.with_corner(0, sharp[39]).unwrap().with_hole(0).unwrap();
            ask(&cage);
        }
    }

    #[test]
    fn a_row_of_any_interval(
        which in 0usize..9,
        rows in prop::collection::vec(prop_oneof![0.2..3.0, 0.2..3.0, Just(0.0), Just(1e-100), Just(1e100), 1e-6..1e6], 40),
        zeros: bool,
    ) {
        let cage = match which {
            0 => crate::shapes::cube(),
            1 => crate::shapes::tetrahedron(),
            2 => crate::shapes::double_fan(7, 0.1),
            3 => crate::shapes::fan(6, 5, true, 0.1),
            4 => crate::shapes::pillow(5),
            5 => crate::shapes::grid(4, 5, [true, true], 0.1),
            6 => crate::shapes::grid(4, 5, [false, false], 0.1),
            7 => crate::shapes::cube().with_hole(3).unwrap(),
            _ => doo_sabin::refine(&crate::shapes::double_fan(5, 0.1)).unwrap(),
        };
        let interval = |row: u64| {
            let d = rows[row as usize % 40];
            if zeros || d > 0.0 { d } else { 1.0 }
        };
        let cage = crate::shapes::rowed(&cage, interval);
        match doo_sabin::DooSabinSurface::new(cage) {
            Err(error) => {
                let error = error.to_string();
                assert!(error.starts_with("face ") || error.starts_with("vertex "), "{error}");
            }
            Ok(surface) => {
                for face in 0..surface.faces().unwrap() as u32 {
                    for (u, v) in [(0.0, 0.0), (0.25, 0.7), (1e-9, 2e-9), (1.0, 1.0)] {
                        let row = surface.stencil(Location::Face(face, u, v), Derivative::POSITION).unwrap();
                        let sum: f64 = row.coefficients().iter().sum();
                        assert!((sum - 1.0).abs() < 1e-9, "{which} {face} {u} {v}: {sum}");
                    }
                }
            }
        }
    }

    #[test]
    fn any_polygon(
        n in 0usize..9,
        closed: bool,
        cubic: bool,
        intervals in prop::collection::vec(prop_oneof![Just(0.0), 0.0..3.0, Just(1e-99), Just(1e99)], 9),
    ) {
        let scheme = if cubic { Scheme::Cubic } else { Scheme::Chaikin };
        let points = (0..n).map(|k| Point::new(crate::shapes::noise(k as u64), 0.0, 1.0)).collect();
        if let Ok(polygon) = Polygon::new(scheme, points, closed) {
            let spans = polygon.spans().len();
            let polygon = polygon.with_intervals(intervals[..spans].to_vec()).unwrap();
            let fine = polygon.refine_times(3);
            assert!(fine.limit_points().iter().chain(fine.points()).all(|p| p.iter().all(|c| c.is_finite())));
            if let Ok(curve) = polygon.to_curve() {
                Polygon::from_curve(&curve).unwrap();
            }
        }
    }
}
