//! The limit surface as a shape.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::conformance::shape_conformance;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{Refinement, limit_points, patch, sectors};
use loftsman_subdivision::{Cage, SubdivisionSurface};

fn value(surface: &dyn Shape, face: u32, u: f64, v: f64, by: [usize; 2]) -> Vector {
    surface.value(Location::Face(face, u, v), Derivative::from(by)).unwrap()
}

#[test]
fn it_is_a_shape() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all() {
        // Derivatives across boundaries are splines only where these are regular.
        let irregular = name.contains("one face") || name.contains("fan of") || name == "cube with a hole";
        if irregular && !name.contains("double") && !name.contains("fan of 4 faces of 4") {
            continue;
        }
        // A face that is sharp for ten levels has thousands of cells: two degrees of sharpness are enough, and infinity.
        let sharp = name.contains("crease") || name.contains("sharp");
        let taken = ["1.7", "2.5", "inf"].iter().any(|s| name.contains(&format!(" {s}")));
        if sharp && !(taken && (name.contains("cube") || name.contains("sharp")) && name.ends_with('4')) {
            continue;
        }
        count += 1;
        let surface = SubdivisionSurface::with_depth(cage, 6).unwrap();
        let verdict = shape_conformance(&surface);
        assert!(verdict.passed(), "{name}: {}", verdict.to_string().chars().take(1500).collect::<String>());
    }
    assert!(count > 25, "{count}");
}

/// Against explicit refinement, whose limits are known where its vertices are.
#[test]
fn it_is_where_refinement_goes() {
    let mut places = 0;
    for (name, cage) in crate::shapes::all() {
        let levels = if cage.topology().face_count() < 8 { 4 } else { 3 };
        let refinement = Refinement::new(cage.clone(), levels).unwrap();
        let surface = SubdivisionSurface::new(cage.clone()).unwrap();
        let (level, fine) = (levels as i32, refinement.finest());
        let limits = limit_points(fine).unwrap();
        // Follow each face of the surface down by its corners.
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, part) = surface.cage_face(face).unwrap();
            let (start, used) = match part {
                None => (of, 0),
                Some(corner) => (cage.topology().face_corners(of).start + corner, 1),
            };
            // A face of a level, with its origin and its two axes in parameters.
            let mut all = vec![(start, [0.0, 0.0], [1.0, 0.0], [0.0, 1.0])];
            for _ in used..levels {
                let mut next = Vec::new();
                for (f, o, a, b) in all {
                    let [a, b] = [a, b].map(|x: [f64; 2]| [0.5 * x[0], 0.5 * x[1]]);
                    let at = |i: f64, j: f64| [0, 1].map(|k| o[k] + i * a[k] + j * b[k]);
                    let minus = |x: [f64; 2]| x.map(|c| -c);
                    next.push((4 * f, at(0., 0.), a, b));
                    next.push((4 * f + 1, at(2., 0.), b, minus(a)));
                    next.push((4 * f + 2, at(2., 2.), minus(a), minus(b)));
                    next.push((4 * f + 3, at(0., 2.), minus(b), a));
                }
                if used == 0 && next.len() == 4 {
                    // The first refinement numbers faces by corners of the cage.
                    let corner = cage.topology().face_corners(of).start;
                    next.iter_mut().enumerate().for_each(|(k, n)| n.0 = corner + k);
                }
                all = next;
            }
            for (f, o, ..) in all.into_iter().step_by(5) {
                let vertex = fine.topology().face(f)[0] as usize;
                let found = value(&surface, face, o[0], o[1], [0, 0]);
                let off = (found - limits[vertex].coords).norm();
                assert!(off < 1e-13, "{name}, face {face}, {o:?}, level {level}: {off:e}");
                places += 1;
            }
        }
    }
    assert!(places > 5000, "{places}");
}

#[test]
fn derivatives_are_rates_everywhere() {
    for (name, cage) in crate::shapes::all().into_iter().step_by(2) {
        let surface = SubdivisionSurface::new(cage).unwrap();
        let faces = surface.faces().unwrap() as u32;
        for face in (0..faces).step_by(3) {
            for (u, v) in [(0.3, 0.7), (1e-3, 0.02), (0.99, 0.995), (0.013, 0.91)] {
                let h = 1e-5 * f64::min(u, 1.0 - u).min(v).min(1.0 - v);
                for (lower, by) in [([0, 0], [1, 0]), ([0, 1], [1, 1]), ([1, 0], [2, 0])] {
                    let rate = (value(&surface, face, u + h, v, lower)
                        - value(&surface, face, u - h, v, lower))
                        / (2.0 * h);
                    let own = value(&surface, face, u, v, by);
                    let size =
                        own.norm().max(value(&surface, face, u, v, lower).norm() / f64::min(u, 1.0 - u));
                    assert!((rate - own).norm() < 1e-3 * size, "{name} {face} {u} {v} {by:?}: {rate} {own}");
                }
            }
        }
    }
}

#[test]
fn a_regular_face_is_its_patch() {
    let cage = crate::shapes::grid(5, 6, [false, true], 0.3);
    let surface = SubdivisionSurface::new(cage.clone()).unwrap();
    for face in 0..cage.topology().face_count() {
        let spline = patch(&cage, face).unwrap().unwrap();
        let own = surface.face_of(face, 0).unwrap().unwrap();
        assert!(surface.is_regular(own).unwrap());
        for (u, v) in [(0.0, 0.0), (0.25, 0.6), (1.0, 0.3), (1.0, 1.0)] {
            for by in [[0, 0], [1, 0], [0, 1], [2, 1], [3, 0], [4, 0]] {
                let there = spline.value([u, v].into(), Derivative::from(by)).unwrap();
                assert!((value(&surface, own, u, v, by) - there).norm() < 1e-12);
            }
        }
    }
}

/// Corners and vertices, tangents with them, in their planes.
#[test]
fn vertices_are_corners_of_faces() {
    for (name, cage) in crate::shapes::all() {
        let surface = SubdivisionSurface::new(cage.clone()).unwrap();
        for v in 0..cage.points().len() {
            let place = surface.place_of(v).unwrap().unwrap();
            let vertex = Location::Vertex(v as u32);
            let [a, b] = [place, vertex].map(|at| surface.value(at, Derivative::POSITION).unwrap());
            assert!((a - b).norm() < 1e-14, "{name}: {a} {b}");
            // With several planes a vertex does not say whose.
            let is_one_sided = sectors(&cage, v).unwrap() == 1;
            for by in [[1, 0], [0, 1]] {
                assert!(surface.stencil(place, Derivative::from(by)).is_ok());
                assert_eq!(surface.stencil(vertex, Derivative::from(by)).is_ok(), is_one_sided, "{name} {v}");
            }
            assert!(surface.stencil(vertex, Derivative::from([2, 0])).is_err());
        }
    }
}

/// Tangents at corners are limits of those beside them, in direction.
#[test]
fn tangents_at_extraordinary_corners_are_limits() {
    let mut count = 0;
    for n in [3, 5, 6, 9] {
        let surface = SubdivisionSurface::new(crate::shapes::double_fan(n, 0.1)).unwrap();
        for face in 0..surface.faces().unwrap() as u32 {
            for (u, v) in [(0.0, 0.0), (1.0, 1.0)] {
                let near = 1e-7;
                let (du, dv) = (if u > 0.5 { -near } else { near }, if v > 0.5 { -near } else { near });
                for (by, at) in [([1, 0], (u + du, v)), ([0, 1], (u, v + dv))] {
                    let there = value(&surface, face, u, v, by).normalize();
                    let beside = value(&surface, face, at.0, at.1, by).normalize();
                    assert!((there - beside).norm() < 2e-2, "{n} {face} {u} {v} {by:?}: {there} {beside}");
                    count += 1;
                }
            }
        }
    }
    assert!(count > 100);
}

#[test]
fn holes_are_no_faces() {
    let cage = crate::shapes::cube().with_hole(2).unwrap();
    let surface = SubdivisionSurface::new(cage).unwrap();
    assert_eq!(surface.faces(), Some(5));
    assert_eq!(surface.face_of(2, 0).unwrap(), None);
    assert_eq!(surface.face_of(3, 0).unwrap(), Some(2));
    assert_eq!(surface.edges().unwrap().count(), 4);
    let all = (0..6).try_fold(crate::shapes::cube(), |cage: Cage, f| cage.with_hole(f)).unwrap();
    assert!(SubdivisionSurface::new(all).is_err());
}

#[test]
fn far_too_many_neighbours_are_refused() {
    let mut points = vec![Point::origin()];
    let n = 3000;
    points.extend((0..n).map(|k| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
        Point::new(c, s, 0.0)
    }));
    let faces: Vec<[usize; 3]> = (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]).collect();
    let surface = SubdivisionSurface::new(Cage::new(points, &faces).unwrap()).unwrap();
    let error = surface.value(Location::Face(0, 0.3, 0.3), Derivative::POSITION).unwrap_err().to_string();
    assert!(error.contains("face 0"), "{error}");
    assert!(surface.value(Location::Vertex(0), Derivative::POSITION).is_ok());
}

/// What was asked before does not show, not in a bit.
#[test]
fn what_was_asked_before_does_not_matter() {
    let cage = crate::shapes::double_fan(5, 0.1).with_crease(0, 2, 2.5).unwrap();
    let asked = SubdivisionSurface::new(cage.clone()).unwrap();
    for k in 0..200_u64 {
        let [u, v] =
            [k, k + 1000].map(|seed| (16.0 * (0.5 + 0.5 * crate::shapes::noise(seed))).floor() / 16.0);
        let at = Location::Face((k % 7) as u32 / 2, u, v);
        let fresh = SubdivisionSurface::new(cage.clone()).unwrap();
        let by = Derivative::POSITION;
        assert_eq!(asked.stencil(at, by).unwrap(), fresh.stencil(at, by).unwrap(), "{at}");
    }
}

/// A vertex among holes is on no surface, and says so.
#[test]
fn a_vertex_among_holes_has_no_place() {
    let cage = crate::shapes::grid(4, 4, [false; 2], 0.1);
    let holes: Vec<usize> = cage.topology().vertex_faces(5).map(|f| f as usize).collect();
    let cage = holes.iter().fold(cage, |cage, &f| cage.with_hole(f).unwrap());
    let surface = SubdivisionSurface::new(cage).unwrap();
    assert_eq!(surface.place_of(5).unwrap(), None);
    let value = |v: u32| surface.value(Location::Vertex(v), Derivative::POSITION);
    let error = value(5).unwrap_err().to_string();
    assert!(error.contains("vertex 5 has nothing but holes"), "{error}");
    assert!((0..16).filter(|&v| value(v).is_err()).eq(surface_hidden(&surface)));
}

/// The vertices that have no place on the surface.
fn surface_hidden(surface: &SubdivisionSurface) -> impl Iterator<Item = u32> + '_ {
    (0..16).filter(|&v| surface.place_of(v as usize).unwrap().is_none())
}
