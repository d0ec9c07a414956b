//! The limit of Doo and Sabin's scheme as a shape.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use std::collections::BTreeMap;
use std::sync::Arc;

use loftsman_area_volume::{volume, volume_of};
use loftsman_fairing::{Fair, bend};
use loftsman_kernel::conformance::{kind_conformance, shape_conformance};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, DeclaredShape, Drawn, Faceted, Fineness, KindOf, ShapeKind, Splines};
use loftsman_kernel::shape::{Derivative, Location, Shape, cells_of, strips};
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::{Direction, Surface};
use loftsman_kernel::{Error, Point, Vector};
use loftsman_subdivision::Cage;
use loftsman_subdivision::doo_sabin::{DooSabinSurface, limit_frames, refine, refine_times};

/// Cages of which there is a surface.
pub(crate) fn some() -> Vec<(String, Cage)> {
    let plain = |cage: &Cage| (0..cage.topology().edge_count()).all(|e| cage.crease(e) == 0.0);
    let all: Vec<(String, Cage)> = crate::shapes::all()
        .into_iter()
        .filter(|(_, cage)| plain(cage) && DooSabinSurface::new(cage.clone()).is_ok())
        .collect();
    assert!(all.len() > 40, "{}", all.len());
    all
}

#[test]
fn it_is_a_shape_and_a_kind() {
    let mut edges = 0;
    for (name, cage) in some().into_iter().step_by(3) {
        let surface = DooSabinSurface::new(cage).unwrap();
        // A side that ends at an extraordinary point has no strip.
        let count = surface.edges().unwrap().count();
        if let Some(error) = (0..count).find_map(|edge| strips(&surface, edge, 0).err()) {
            assert!(error.to_string().contains("ends at an extraordinary point"), "{name}: {error}");
            continue;
        }
        edges += count;
        let verdict = shape_conformance(&surface);
        assert!(verdict.passed(), "{name}: {}", verdict.to_string().chars().take(2000).collect::<String>());
    }
    assert!(edges > 20, "{edges}");
    let cages = [
        crate::shapes::cube().with_hole(2).unwrap(),
        crate::shapes::grid(3, 4, [false, false], 0.2),
        crate::shapes::fan(5, 4, true, 0.1),
    ];
    let samples: Vec<Box<dyn Shape>> = cages
        .into_iter()
        .map(|cage| Box::new(DooSabinSurface::with_depth(cage, 7).unwrap()) as Box<dyn Shape>)
        .collect();
    let kind: Arc<dyn ShapeKind> = Arc::new(KindOf::<DooSabinSurface>::default());
    let verdict = kind_conformance(&kind, &samples);
    assert!(verdict.passed(), "{}", verdict.to_string().chars().take(3000).collect::<String>());
}

/// Of a grid it is the biquadratic spline, with all derivatives.
#[test]
fn of_a_grid_it_is_the_spline() {
    let (rows, columns) = (5, 6);
    let cage = crate::shapes::grid(rows, columns, [false, false], 0.4);
    let [u, v] = [rows, columns].map(|n| Space::floating_uniform(2, n).unwrap());
    let spline = Surface::new(u, v, cage.points().to_vec()).unwrap();
    let surface = DooSabinSurface::new(cage).unwrap();
    assert_eq!(surface.faces(), Some(4 * (rows - 2) * (columns - 2)));
    let mut seen = 0;
    for face in 0..surface.faces().unwrap() as u32 {
        assert!(surface.is_regular(face).unwrap());
        let (of, corner) = surface.cage_corner(face).unwrap();
        // The middle of the face, and the ways to the vertex of the corner: u is the way against the edge before it.
        let (i, j) = (of / (columns - 1), of % (columns - 1));
        let out: [[f64; 2]; 2] = match corner {
            0 => [[-1.0, 0.0], [0.0, -1.0]],
            1 => [[0.0, -1.0], [1.0, 0.0]],
            2 => [[1.0, 0.0], [0.0, 1.0]],
            _ => [[0.0, 1.0], [-1.0, 0.0]],
        };
        for (s, t) in [(0.0, 0.0), (0.25, 0.75), (1.0, 0.5), (0.1, 1.0), (1.0, 1.0)] {
            let way = [0, 1].map(|k| 0.5 * (s * out[0][k] + t * out[1][k]));
            let at = (i as f64 + way[0], j as f64 + way[1]);
            if !(0.0..=(rows - 2) as f64).contains(&at.0) || !(0.0..=(columns - 2) as f64).contains(&at.1) {
                continue;
            }
            seen += 1;
            let ours = |u, v| surface.value(Location::Face(face, s, t), Derivative { u, v }).unwrap();
            let theirs = |u, v| spline.derivative(at.0, at.1, u, v).unwrap();
            assert!((ours(0, 0) - theirs(0, 0)).norm() < 1e-14, "{face} {s} {t}");
            let (du, dv) = (theirs(1, 0), theirs(0, 1));
            let along = |k: usize| (du * out[k][0] + dv * out[k][1]) * 0.5;
            assert!((ours(1, 0) - along(0)).norm() < 1e-14, "{face} {s} {t}");
            assert!((ours(0, 1) - along(1)).norm() < 1e-14, "{face} {s} {t}");
        }
    }
    assert!(seen > 200, "{seen}");
    let Some(Splines::Surfaces(all)) = surface.splines() else { panic!("it is all splines") };
    // One spline goes round it, and the middle of each of its spans is that of one face.
    assert_eq!(all.len(), 1);
    let middles = |direction| {
        let breaks = all[0].space(direction).breakpoints();
        breaks.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect::<Vec<_>>()
    };
    let middle = |face: u32| surface.value(Location::Face(face, 0.5, 0.5), Derivative::POSITION).unwrap();
    let mut met = vec![0; surface.faces().unwrap()];
    for u in middles(Direction::U) {
        for v in middles(Direction::V) {
            let at = all[0].point(u, v).unwrap().coords;
            let near = (0..met.len()).filter(|face| (middle(*face as u32) - at).norm() < 1e-13);
            near.collect::<Vec<_>>().into_iter().for_each(|face| met[face] += 1);
        }
    }
    assert!(met.iter().all(|times| *times == 1), "{met:?}");
    assert!(DooSabinSurface::new(crate::shapes::cube()).unwrap().splines().is_none());
}

/// Middles of faces of the refined cages lie on it, where they are said to; in the middle the planes are those of the scheme's limit.
#[test]
fn refined_cages_come_to_it() {
    for (name, cage) in some() {
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        let size = cage.points().iter().fold(1.0_f64, |m, p| m.max(p.coords.amax()));
        let frames = limit_frames(&cage).unwrap();
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, _) = surface.cage_corner(face).unwrap();
            let at = Location::Face(face, 0.0, 0.0);
            let off = surface.value(at, Derivative::POSITION).unwrap() - frames[of].point.coords;
            assert!(off.norm() < 1e-13 * size, "{name}: {off}");
            let [du, dv] = [Derivative { u: 1, v: 0 }, Derivative { u: 0, v: 1 }]
                .map(|by| surface.value(at, by).unwrap());
            let [a, b] = frames[of].tangents;
            let (ours, theirs) = (du.cross(&dv).normalize(), a.cross(&b).normalize());
            assert!((ours - theirs).norm() < 1e-10, "{name}: {ours} {theirs}");
        }
        // Two levels on, the middle of each face of a face's own is a quarter of the way from its corner.
        let fine = refine(&cage).unwrap();
        let limits = limit_frames(&refine(&fine).unwrap()).unwrap();
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, corner) = surface.cage_corner(face).unwrap();
            let half = cage.topology().face_corners(of).start + corner;
            // Vertex `half` of the refined cage lies in the middle of the face; its own face comes after those of faces and inner edges.
            let inner = fine.topology();
            let edges = (0..inner.edge_count()).filter(|&e| !inner.is_boundary_edge(e)).count();
            let before = (0..half)
                .filter(|&v| !inner.is_boundary_vertex(v) && inner.around(v).nth(2).is_some())
                .count();
            let middle = surface.value(Location::Face(face, 0.5, 0.5), Derivative::POSITION).unwrap();
            let there = limits[inner.face_count() + edges + before].point.coords;
            assert!((middle - there).norm() < 1e-13 * size, "{name}, face {face}: {middle} {there}");
        }
    }
}

/// Neighbours meet along their sides, in position and tangent plane, also near extraordinary points.
#[test]
fn it_is_smooth_across_sides() {
    for cage in [
        crate::shapes::cube(),
        crate::shapes::tetrahedron(),
        crate::shapes::double_fan(7, 0.1),
        refine(&crate::shapes::double_fan(5, 0.1)).unwrap(),
    ] {
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        let topology = cage.topology();
        let mut sides = 0;
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, corner) = surface.cage_corner(face).unwrap();
            let size = topology.face(of).len();
            let Some(other) = surface.face_of(of, (corner + size - 1) % size).unwrap() else { continue };
            for t in [1e-6, 0.1, 0.37, 0.5, 0.9, 1.0 - 1e-6] {
                let (one, two) = (Location::Face(face, t, 0.0), Location::Face(other, 0.0, t));
                let value = |at, u, v| surface.value(at, Derivative { u, v }).unwrap();
                assert!((value(one, 0, 0) - value(two, 0, 0)).norm() < 1e-13);
                let normal = |at| value(at, 1, 0).cross(&value(at, 0, 1)).normalize();
                assert!((normal(one) - normal(two)).norm() < 1e-7, "{} {}", normal(one), normal(two));
                sides += 1;
            }
        }
        assert!(sides > 30, "{sides}");
    }
}

/// A volume kept, a point and a tangent asked for, a fair shape: what constraints and energies do on other shapes.
#[test]
fn it_is_edited_and_faired() {
    let surface = DooSabinSurface::new(crate::shapes::cube()).unwrap();
    let wanted = Point::new(0.9, 0.85, 0.95);
    let before = surface.value(Location::Face(3, 0.2, 0.4), Derivative { u: 1, v: 0 }).unwrap();
    let edited = Edit::new(&surface)
        .ask(position(Location::Vertex(7)).to(wanted))
        .ask(derivative(Location::Face(3, 0.2, 0.4), Derivative { u: 1, v: 0 }).keep())
        .ask(volume().keep())
        .solve()
        .unwrap();
    let there = edited.shape().value(Location::Vertex(7), Derivative::POSITION).unwrap();
    assert!((there - wanted.coords).norm() < 1e-12);
    let after = edited.shape().value(Location::Face(3, 0.2, 0.4), Derivative { u: 1, v: 0 }).unwrap();
    assert!((after - before).norm() < 1e-12);
    let (was, is) = (volume_of(&surface).unwrap(), volume_of(edited.shape()).unwrap());
    assert!((was - is).abs() < 1e-12, "{was} {is}");
    let fair = [7, 0, 3].iter().fold(Fair::new(edited.shape()).energy(bend()), |fair, &v| {
        fair.ask(position(Location::Vertex(v)).keep())
    });
    let report = fair.solve().unwrap();
    let report = report.report();
    assert!(report.energy_after < report.energy_before, "{report:?}");
}

/// At extraordinary points a level adds a quarter of what the one before did to the energy of first derivatives, and as much to that of second
/// ones, whatever the face: with what half as much is off each level, for the eigenvalue behind the two halves is a quarter.
#[test]
fn energies_of_levels_go_on_as_is_said() {
    for n in [3, 5, 6, 8] {
        let surface = DooSabinSurface::with_depth(crate::shapes::fan(n, 4, true, 0.1), 8).unwrap();
        let cells = cells_of(&surface, "energy").unwrap();
        let mut levels: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for index in 0..cells.count() {
            let cell = cells.cell(index).unwrap();
            let side = cell.sides[0];
            let level = -(side.end - side.start).log2().round() as i32;
            let own = levels.entry(level as u32).or_default();
            for (at, weight) in cell.gauss_points([3, 3]) {
                let square = |u, v| surface.value(at, Derivative { u, v }).unwrap().norm_squared();
                own[0] += weight * (square(1, 0) + square(0, 1));
                own[1] += weight * (square(2, 0) + 2.0 * square(1, 1) + square(0, 2));
            }
        }
        let share = |k: usize| 2.0 * levels[&8][k] / levels[&7][k] - levels[&7][k] / levels[&6][k];
        assert!(
            (share(0) - 0.25).abs() < 1e-3 && (share(1) - 1.0).abs() < 1e-2,
            "{n}: {} {}",
            share(0),
            share(1)
        );
    }
}

fn triangles(surface: &DooSabinSurface, chord: Chord, angle: f64) -> (Faceted, Mesh) {
    let faceted = DooSabinSurface::tessellate(&[surface], &Fineness { chord, angle }).unwrap();
    assert!(faceted.certified && faceted.error <= faceted.tolerance, "{}", faceted.error);
    let Drawn::Mesh(mesh) = faceted.drawn.clone() else { panic!("it is a surface") };
    (faceted, mesh)
}

/// The sides of triangles that have no other beside them; no side has more than one, or one that runs the same way.
fn open_sides(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut sides: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
    for c in mesh.corners().chunks(3) {
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            assert_ne!(a, b);
            sides.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
    }
    assert!(sides.values().all(|ways| ways[0] <= 1 && ways[1] <= 1));
    sides.into_iter().filter(|(_, ways)| ways[0] + ways[1] == 1).map(|(side, _)| side).collect()
}

/// How long the boundary of a surface is, by chords of many places.
fn boundary_length(surface: &DooSabinSurface) -> f64 {
    let edges = surface.edges().unwrap();
    let length = |index: usize| {
        let edge = edges.edge(index).unwrap();
        let at = |k: u32| {
            let t = f64::from(k) / 512.0;
            let (u, v) = if edge.along_u { (t, edge.fixed) } else { (edge.fixed, t) };
            surface.value(Location::Face(edge.face.unwrap(), u, v), Derivative::POSITION).unwrap()
        };
        (0..512).map(|k| (at(k + 1) - at(k)).norm()).sum::<f64>()
    };
    (0..edges.count()).map(length).sum()
}

/// Every valence from 3 to 8, round faces and round vertices, closed and open, level ones and folded ones.
fn of_many_valences() -> Vec<(String, Cage)> {
    let mut all = vec![
        ("cube".to_owned(), crate::shapes::cube()),
        ("tetrahedron".to_owned(), crate::shapes::tetrahedron()),
        ("hole".to_owned(), crate::shapes::cube().with_hole(1).unwrap()),
        ("torus".to_owned(), crate::shapes::grid(5, 6, [true, true], 0.2)),
        ("sheet".to_owned(), crate::shapes::grid(4, 5, [false, false], 0.3)),
    ];
    for n in 3..=8 {
        all.push((format!("open fan of {n}"), crate::shapes::fan(n, 4, true, 0.3)));
        all.push((format!("double fan of {n}"), crate::shapes::double_fan(n, 0.2)));
        all.push((format!("pillow of {n}"), refine(&crate::shapes::pillow(n)).unwrap()));
    }
    all
}

#[test]
fn triangles_are_near_and_do_not_gape() {
    let mut ratios = Vec::new();
    for (name, cage) in of_many_valences() {
        let surface = DooSabinSurface::new(cage).unwrap();
        for part in [2e-2, 3e-3] {
            let (faceted, mesh) = triangles(&surface, Chord::Relative(part), 10.0);
            for (p, at) in mesh.points().iter().zip(&faceted.places) {
                let there = surface.value(*at, Derivative::POSITION).unwrap();
                assert!((p.coords - there).norm() < 1e-13, "{name}");
            }
            // A point of the mesh on the side of a triangle, not at its end, would leave both open: the open ones are as long as the boundary, no longer.
            let length = |[a, b]: &[u32; 2]| (mesh.points()[*a as usize] - mesh.points()[*b as usize]).norm();
            let open: f64 = open_sides(&mesh).iter().map(length).sum();
            let there = boundary_length(&surface);
            assert!(open <= there * (1.0 + 1e-9) && open >= 0.97 * there, "{name} {open} {there}");
            // Places all over the faces, many at their corners, against the nearest triangle of all.
            let faces = surface.faces().unwrap() as u32;
            let mut most = 0.0_f64;
            for k in 0..u64::from(faces) * 10 {
                let [mut u, mut v] = [2 * k, 2 * k + 1].map(|seed| 0.5 + 0.5 * crate::shapes::noise(seed));
                if k % 3 == 0 {
                    (u, v) = (u.powi(4), v.powi(4));
                }
                let (u, v) = [(u, v), (1.0 - u, v), (1.0 - u, 1.0 - v), (u, 1.0 - v)][(k % 4) as usize];
                let at = Location::Face((k % u64::from(faces)) as u32, u, v);
                let p = surface.value(at, Derivative::POSITION).unwrap();
                most = most.max(from_mesh(p, &mesh));
            }
            assert!(most <= faceted.error + 1e-14, "{name}: {most:e} {:e}", faceted.error);
            ratios.push(faceted.error / most);
        }
    }
    // What is said is not far from what is so.
    ratios.sort_by(f64::total_cmp);
    let [middle, last] = [ratios[ratios.len() / 2], ratios[ratios.len() - 1]];
    assert!(middle < 2.0 && last < 10.0, "{middle} {last} {ratios:?}");
}

fn from_mesh(p: Vector, mesh: &Mesh) -> f64 {
    let mut best = f64::INFINITY;
    for c in mesh.corners().chunks(3) {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points()[c[k] as usize].coords);
        if (p - a).norm() - (b - a).norm().max((c - a).norm()) < best {
            best = best.min(distance(p, [a, b, c]));
        }
    }
    best
}

/// Of a surface that bends the number of triangles grows like one over the distance, also round extraordinary points, where parameters are
/// not smooth: a plain cube, at what GLB files are written with, too.
#[test]
fn triangles_are_few() {
    let surface = DooSabinSurface::new(crate::shapes::cube()).unwrap();
    let count = |part: f64, angle: f64| {
        let (_, mesh) = triangles(&surface, Chord::Relative(part), angle);
        assert!(open_sides(&mesh).is_empty());
        mesh.face_count()
    };
    let counts = [1e-2, 1e-3, 1e-4].map(|part| count(part, 10.0));
    // A hundred times as near takes about a hundred times as many, give or take a level.
    assert!(counts[1] <= 3_500 && counts[2] <= 50_000 && counts[2] <= 300 * counts[0], "{counts:?}");
    let in_glb = count(1e-4, Fineness::default().angle);
    assert!(in_glb <= 50_000, "{in_glb}");
}

/// Where only the angle asks for more, there is more: normals at the ends of sides turn by no more.
#[test]
fn triangles_turn_no_more_than_asked() {
    let surface = DooSabinSurface::new(crate::shapes::cube()).unwrap();
    for angle in [0.3, 0.1] {
        let (_, mesh) = triangles(&surface, Chord::Relative(1e-2), angle);
        let most =
            mesh.corners().chunks(3).flat_map(|c| [[c[0], c[1]], [c[1], c[2]]]).fold(0.0_f64, |m, side| {
                let [a, b] = side.map(|k| mesh.normals.values()[k as usize]);
                m.max(a.angle(&b))
            });
        assert!(most <= 2.0 * angle, "{most} {angle}");
    }
}

/// States are the same triangles, as fine as the worst of them asks for; one that is a point asks for nothing, and all that are say so.
#[test]
fn states_are_the_same_triangles() {
    let cage = crate::shapes::fan(5, 4, true, 0.3);
    let moved = |by: f64| {
        let mut cage = cage.clone();
        cage.points_mut().iter_mut().for_each(|p| *p = Point::new(p.x * by, p.y * by, p.z * by * by));
        DooSabinSurface::new(cage).unwrap()
    };
    let states = [moved(1.0), moved(1.3), moved(0.0)];
    let fine = Fineness { chord: Chord::Relative(1e-2), angle: 10.0 };
    let faceted = DooSabinSurface::tessellate(&states.each_ref(), &fine).unwrap();
    assert!(faceted.certified && faceted.states.len() == 3);
    for (surface, points) in states.iter().zip(&faceted.states) {
        assert_eq!(points.len(), faceted.places.len());
        for (p, at) in points.iter().zip(&faceted.places) {
            assert!((p.coords - surface.value(*at, Derivative::POSITION).unwrap()).norm() < 1e-13);
        }
    }
    assert!(matches!(DooSabinSurface::tessellate(&[&states[2]], &fine), Err(Error::NoExtent(_))));
}

/// Of a point from a triangle, by many places of it.
fn distance(p: Vector, [a, b, c]: [Vector; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(x, y)| (y - x).cross(&(p - x)).dot(&normal) >= 0.0);
    if inside {
        return (p - a).dot(&normal).abs() / normal.norm();
    }
    let segment = |x: Vector, y: Vector| {
        let t = ((p - x).dot(&(y - x)) / (y - x).norm_squared()).clamp(0.0, 1.0);
        (p - x - (y - x) * t).norm()
    };
    segment(a, b).min(segment(b, c)).min(segment(c, a))
}

#[test]
fn what_there_is_none_of_says_so() {
    let refused = |cage: Cage| DooSabinSurface::new(cage).unwrap_err().to_string();
    assert!(refused(crate::shapes::pillow(5)).contains("vertex 0 has two faces and two edges"));
    assert!(DooSabinSurface::new(refine_times(&crate::shapes::pillow(5), 1).unwrap()).is_ok());
    assert!(refused(crate::shapes::one_face(4)).contains("shows no piece"));
    let uneven = crate::shapes::grid(4, 4, [false, false], 0.1).with_end_interval(5, 6, 2.0).unwrap();
    let error = refused(uneven);
    assert!(error.contains("intervals") && error.contains("limit = true"), "{error}");
    let surface = DooSabinSurface::new(crate::shapes::fan(5, 4, true, 0.1)).unwrap();
    assert!(
        surface
            .value(Location::Vertex(3), Derivative::POSITION)
            .unwrap_err()
            .to_string()
            .contains("boundary")
    );
    assert!(
        surface
            .value(Location::Vertex(0), Derivative { u: 2, v: 0 })
            .unwrap_err()
            .to_string()
            .contains("extraordinary")
    );
    assert!(surface.value(Location::Face(99, 0.0, 0.0), Derivative::POSITION).is_err());
    assert!(surface.value(Location::Face(0, 1.5, 0.0), Derivative::POSITION).is_err());
    assert!(surface.value(Location::Face(0, f64::NAN, 0.0), Derivative::POSITION).is_err());
    assert!(DooSabinSurface::with_depth(crate::shapes::cube(), 0).is_err());
}
