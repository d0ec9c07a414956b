//! Surfaces by knot intervals as shapes: against tensor-product splines, against explicit levels, and as shapes.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_area_volume::{surface_area, volume, volume_of};
use loftsman_kernel::conformance::shape_conformance;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Functional, Shapes, normal, position};
use loftsman_kernel::plugin::{Chord, DeclaredShape, Fineness};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::space::Space;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{Refinement, limit_points, refine};
use loftsman_subdivision::{Cage, SubdivisionSurface};

fn area_of(shape: &dyn Shape) -> f64 {
    let mut out = [0.0];
    surface_area().value(&Shapes::one(shape), &mut out).unwrap();
    out[0]
}

fn value(surface: &dyn Shape, face: u32, u: f64, v: f64, by: [usize; 2]) -> Vector {
    surface.value(Location::Face(face, u, v), Derivative::from(by)).unwrap()
}

/// One interval for each row of faces: for edges that are opposite in a quad, or next but one in another face.
pub(crate) fn rows(cage: &Cage, spread: f64, seed: u64) -> Cage {
    let topology = cage.topology();
    let mut row: Vec<usize> = (0..topology.edge_count()).collect();
    loop {
        let mut changed = false;
        for face in 0..topology.face_count() {
            let edges = topology.face_edges(face);
            for k in 0..edges.len() {
                let (a, b) = (edges[k] as usize, edges[(k + 2) % edges.len()] as usize);
                let least = row[a].min(row[b]);
                changed |= row[a] != least || row[b] != least;
                (row[a], row[b]) = (least, least);
            }
        }
        if !changed {
            break;
        }
    }
    (0..topology.edge_count()).fold(cage.clone(), |cage, e| {
        let [a, b] = topology.edge(e).unwrap();
        let number = row[e] as u64 + 1000 * seed;
        let d = spread.powf(crate::shapes::noise(7 * number + 3));
        cage.with_interval(a as usize, b as usize, d).unwrap()
    })
}

#[test]
fn a_grid_is_its_spline_with_all_derivatives() {
    for zero in [false, true] {
        let mut sides = [[1.0, 2.5, 0.3, 1.7, 0.9].to_vec(), [0.4, 1.0, 3.0, 0.8, 1.1, 2.0].to_vec()];
        if zero {
            (sides[0][2], sides[1][3]) = (0.0, 0.0);
        }
        let [d, e] = &sides;
        let (cage, spline) = crate::shapes::torus(d, e);
        let surface = SubdivisionSurface::new(cage).unwrap();
        let (r, c) = (d.len(), e.len());
        for face in 0..r * c {
            assert!(surface.is_regular(face as u32).unwrap());
            let (i, j) = (face / c, face % c);
            if d[i] == 0.0 || e[j] == 0.0 {
                continue;
            }
            let knot = |space: &Space, k: usize| space.knots()[(k + 2) % space.len()];
            let from = [knot(spline.u(), i), knot(spline.v(), j)];
            for (s, t) in [(0.3, 0.8), (0.0, 0.5), (0.9, 0.1)] {
                let at = Location::Surface(from[0] + s * d[i], from[1] + t * e[j]);
                for by in [[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [3, 3]] {
                    let wanted = spline.value(at, Derivative::from(by)).unwrap()
                        * d[i].powi(by[0] as i32)
                        * e[j].powi(by[1] as i32);
                    let own = value(&surface, face as u32, s, t, by);
                    let off = (own - wanted).norm();
                    assert!(off < 2e-12, "{zero}, face {face}, {s} {t} {by:?}: {off:e}");
                }
            }
        }
    }
}

/// Against explicit refinement by intervals, whose limits are known where its vertices are.
#[test]
fn it_is_where_refinement_goes() {
    let mut places = 0;
    for (k, (name, cage)) in crate::shapes::all().into_iter().enumerate() {
        if name.contains("crease") || name.contains("sharp") {
            // Of those that are sharp for some levels a few.
            if k % 9 > 0 || name.contains("9.9") {
                continue;
            }
        }
        let cage = rows(&cage, 2.5, k as u64);
        let levels = 3;
        let surface = SubdivisionSurface::new(cage.clone()).unwrap();
        let refinement = Refinement::new(cage.clone(), levels).unwrap();
        let limits = limit_points(refinement.finest()).unwrap();
        let topology = refinement.finest().topology();
        for face in (0..surface.faces().unwrap() as u32).step_by(2) {
            let (of, part) = surface.cage_face(face).unwrap();
            let (start, used) = match part {
                None => (of, 0),
                Some(corner) => (cage.topology().face_corners(of).start + corner, 1),
            };
            let mut all = vec![(start, [0.0, 0.0], [1.0, 0.0], [0.0, 1.0])];
            for _ in used..levels {
                let mut next = Vec::new();
                for (child, at, u, v) in all {
                    let half = |w: [f64; 2]| [0.5 * w[0], 0.5 * w[1]];
                    let (u, v) = (half(u), half(v));
                    let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
                    let less = |a: [f64; 2]| [-a[0], -a[1]];
                    let corners = [
                        (at, u, v),
                        (sum(at, sum(u, u)), v, less(u)),
                        (sum(sum(at, sum(u, u)), sum(v, v)), less(u), less(v)),
                        (sum(at, sum(v, v)), less(v), u),
                    ];
                    for (k, (at, u, v)) in corners.into_iter().enumerate() {
                        next.push((4 * child + k, at, u, v));
                    }
                }
                if used == 0 && next.len() == 4 {
                    // The first refinement numbers faces by corners of the cage.
                    let corner = cage.topology().face_corners(of).start;
                    next.iter_mut().enumerate().for_each(|(k, n)| n.0 = corner + k);
                }
                all = next;
            }
            for (child, at, ..) in all.into_iter().step_by(3) {
                let limit = limits[topology.face(child)[0] as usize];
                let own = value(&surface, face, at[0], at[1], [0, 0]);
                let off = (own - limit.coords).norm();
                assert!(off < 1e-12, "{name}, face {face}, {at:?}: {off:e}");
                places += 1;
            }
        }
    }
    assert!(places > 5000, "{places}");
}

#[test]
fn it_is_a_shape() {
    for (name, cage) in [
        ("cube", crate::shapes::cube()),
        ("fan", crate::shapes::fan(5, 4, true, 0.1)),
        ("of sixes", crate::shapes::fan(3, 6, true, 0.1)),
        ("open", crate::shapes::grid(4, 5, [false, true], 0.2)),
    ] {
        let surface = SubdivisionSurface::with_depth(rows(&cage, 2.0, 5), 6).unwrap();
        assert!(surface.cage().has_intervals());
        let verdict = shape_conformance(&surface);
        assert!(verdict.passed(), "{name}: {}", verdict.to_string().chars().take(1500).collect::<String>());
        let fields = surface.fields();
        let again = SubdivisionSurface::from_parameters(&fields).unwrap();
        assert_eq!(surface.cage(), again.cage(), "{name}");
    }
}

/// Areas and volumes by the cells against those of triangles between limits of refined vertices, which go to them by a quarter a level;
/// what is left out is within its bound, and tessellation and patches within their tolerances.
#[test]
fn it_is_measured_cut_and_made_of_patches() {
    for (name, cage) in [("cube", crate::shapes::cube()), ("fan", crate::shapes::double_fan(5, 0.1))] {
        let surface = SubdivisionSurface::new(rows(&cage, 2.0, 9)).unwrap();
        let coarse = SubdivisionSurface::with_depth(rows(&cage, 2.0, 9), 3).unwrap();
        let area = |s: &SubdivisionSurface| area_of(s);
        let (bound, fine) = (coarse.left_out().unwrap(), surface.left_out().unwrap());
        let missing = area(&surface) - area(&coarse);
        assert!(missing > 0.0 && missing < bound.area, "{name}: {missing:e} {bound:?}");
        assert!(
            bound.area < 60.0 * missing && fine.area < bound.area / 100.0,
            "{name}: {bound:?} {fine:?} {missing:e}"
        );
        let fineness = Fineness { chord: Chord::Absolute(2e-3), angle: 0.5 };
        let cut = SubdivisionSurface::tessellate(&[&surface], &fineness).unwrap();
        assert!(cut.certified && cut.error <= 2e-3, "{name}: {}", cut.error);
        let patches = surface.patches(1e-3).unwrap();
        assert!(patches.deviation <= 1e-3 && patches.exact < patches.surfaces.len(), "{name}");
        let area_of_patches: f64 = patches.surfaces.iter().map(|s| area_of(s)).sum();
        assert!((area_of_patches / area(&surface) - 1.0).abs() < 2e-3, "{name}: {area_of_patches}");
    }
}

/// A limit between vertices is moved, a normal held, the volume kept.
#[test]
fn it_is_edited() {
    let surface = SubdivisionSurface::new(rows(&refine(&crate::shapes::cube()).unwrap(), 2.0, 4)).unwrap();
    assert!(surface.cage().has_intervals());
    let at = Location::Face(3, 0.3, 0.6);
    let wanted =
        Point::from(surface.value(at, Derivative::POSITION).unwrap() + Vector::new(0.03, 0.02, -0.04));
    let facing = |s: &SubdivisionSurface| {
        let [a, b] = [[1, 0], [0, 1]].map(|by| s.value(Location::Vertex(7), Derivative::from(by)).unwrap());
        a.cross(&b).normalize()
    };
    let was = volume_of(&surface).unwrap();
    let edited = Edit::new(&surface)
        .ask(position(at).to(wanted))
        .ask(normal(Location::Vertex(7), facing(&surface)).hold())
        .ask(volume().keep())
        .solve()
        .unwrap();
    let after = edited.shape();
    assert!((after.value(at, Derivative::POSITION).unwrap() - wanted.coords).norm() < 1e-12);
    assert!((facing(after) - facing(&surface)).norm() < 1e-12);
    let off = (volume_of(after).unwrap() - was).abs();
    assert!(off < 1e-12 * was, "{off:e}");
}

#[test]
fn what_has_no_pieces_is_refused_by_name() {
    let cage = crate::shapes::cube().with_interval(0, 1, 2.0).unwrap();
    let error = SubdivisionSurface::new(cage).unwrap_err().to_string();
    assert!(
        error.contains("face 0") && error.contains("opposite edges") && error.contains("1, 1, 1, 2"),
        "{error}"
    );
    let cage = [(0, 2), (1, 3), (4, 6), (5, 7)]
        .into_iter()
        .try_fold(crate::shapes::cube(), |cage, (a, b)| cage.with_interval(a, b, 0.0));
    let error = SubdivisionSurface::new(cage.unwrap()).unwrap_err().to_string();
    assert!(error.contains("vertices 0 and 2") && error.contains("knot interval 0"), "{error}");
}
