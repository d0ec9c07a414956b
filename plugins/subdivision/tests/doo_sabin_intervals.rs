//! Doo-Sabin surfaces by knot intervals as shapes: of grids they are biquadratic splines, elsewhere what refinement comes to.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::shapes::{noise, quadratic_torus, rowed};
use loftsman_kernel::conformance::{kind_conformance, shape_conformance};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, DeclaredShape, Drawn, Fineness, KindOf, ShapeKind, Splines};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Direction, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::doo_sabin::{DooSabinSurface, limit_frames, refine};
use loftsman_subdivision::{Cage, LimitFrame};

const POSITION: Derivative = Derivative::POSITION;

fn stirred(count: usize, seed: u64) -> Vec<f64> {
    (0..count as u64).map(|k| 1.0 + 0.95 * noise(100 * seed + k)).collect()
}

/// Intervals of rows in a ratio of 1:2, which any number of edges bears; of a hundred where there are no more than four.
fn spread(name: &str, seed: u64) -> impl Fn(u64) -> f64 {
    let few = ["cube", "cube with a hole", "tetrahedron", "torus", "sheet", "ring"].contains(&name);
    move |row| if few { 10.0_f64 } else { 1.414 }.powf(noise(1000 * seed + row))
}

/// Where the spans of vertices `i` and `i + 1` meet.
fn knot(space: &Space, i: usize) -> f64 {
    space.knots()[(i + 2) % space.len()]
}

/// Cages of which there is a surface by any intervals, of each valence from 3 to 12.
fn some() -> Vec<(String, Cage)> {
    let mut all = vec![
        ("cube".to_owned(), crate::shapes::cube()),
        ("cube with a hole".to_owned(), crate::shapes::cube().with_hole(1).unwrap()),
        ("tetrahedron".to_owned(), crate::shapes::tetrahedron()),
        ("torus".to_owned(), crate::shapes::grid(5, 6, [true, true], 0.2)),
        ("sheet".to_owned(), crate::shapes::grid(5, 6, [false, false], 0.3)),
        ("ring".to_owned(), crate::shapes::grid(5, 6, [true, false], 0.3)),
    ];
    for n in 3..=12 {
        all.push((format!("fan of {n}"), crate::shapes::fan(n, 4, true, 0.2)));
        all.push((format!("double fan of {n}"), crate::shapes::double_fan(n, 0.1)));
        all.push((format!("pentagons round {n}"), crate::shapes::fan(n, 5, true, 0.1)));
        all.push((format!("pillow of {n}, refined"), refine(&crate::shapes::pillow(n)).unwrap()));
    }
    all
}

/// With one interval a row, and of each row another.
pub(crate) fn uneven() -> Vec<(String, Cage)> {
    let each = |(k, (name, cage)): (usize, (String, Cage))| {
        let by_rows = rowed(&cage, spread(&name, k as u64));
        (name, by_rows)
    };
    some().into_iter().enumerate().map(each).collect()
}

/// Places, first and second derivatives of a torus are those of the spline, double knots in either direction and in both included; so are its
/// splines.
#[test]
fn of_a_grid_it_is_the_spline() {
    let mut seen = 0;
    for seed in 0..5 {
        let (mut rows, mut columns) = (stirred(6, seed), stirred(7, seed + 50));
        match seed {
            1 => rows[2] = 0.0,
            2 => (rows[2], columns[3]) = (0.0, 0.0),
            3 => (rows[1], rows[3], columns[0], columns[4]) = (0.0, 0.0, 0.0, 0.0),
            // Numbers that add up without rounding.
            4 => {
                (rows, columns) = (
                    vec![1.0 / 1024.0, 1024.0, 1.0, 0.5, 3.0, 2.0],
                    vec![1.0, 256.0, 0.25, 4.0, 4.0, 8.0, 1.5],
                );
            }
            _ => {}
        }
        let (cage, spline) = quadratic_torus(&rows, &columns);
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        assert_eq!(surface.faces(), Some(4 * 42));
        // Any of these would be further away if an interval were wrong.
        let plain = DooSabinSurface::new(
            Cage::from_topology(cage.points().to_vec(), cage.shared_topology()).unwrap(),
        )
        .unwrap();
        let mut apart = 0.0_f64;
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, corner) = surface.cage_corner(face).unwrap();
            let (i, j) = (of / columns.len(), of % columns.len());
            let vertex = [(0, 0), (1, 0), (1, 1), (0, 1)][corner];
            let size = [rows[(i + vertex.0) % rows.len()], columns[(j + vertex.1) % columns.len()]];
            // Along u and v from the middle of the cage's face: each half the vertex's span.
            let out: [[f64; 2]; 2] = match corner {
                0 => [[-1.0, 0.0], [0.0, -1.0]],
                1 => [[0.0, -1.0], [1.0, 0.0]],
                2 => [[1.0, 0.0], [0.0, 1.0]],
                _ => [[0.0, 1.0], [-1.0, 0.0]],
            };
            let ways = out.map(|way| [0, 1].map(|axis| 0.5 * way[axis] * size[axis]));
            let wrapped = |space: &Space, x: f64| {
                let (start, end) = space.domain();
                start + (x - start).rem_euclid(end - start)
            };
            for (s, t) in [(0.0, 0.0), (0.25, 0.75), (1.0, 0.5), (0.125, 1.0), (1.0, 1.0), (0.625, 0.375)] {
                let at = |k: usize| s * ways[0][k] + t * ways[1][k];
                let u = wrapped(spline.u(), knot(spline.u(), i) + at(0));
                let v = wrapped(spline.v(), knot(spline.v(), j) + at(1));
                let ours =
                    |a, b| surface.value(Location::Face(face, s, t), Derivative { u: a, v: b }).unwrap();
                let theirs = |a, b| spline.derivative(u, v, a, b).unwrap();
                let context = format!("{seed}: face {face}, {s} {t}");
                assert!(
                    (ours(0, 0) - theirs(0, 0)).norm() < 1e-13,
                    "{context}: {} {}",
                    ours(0, 0),
                    theirs(0, 0)
                );
                apart = apart
                    .max((ours(0, 0) - plain.value(Location::Face(face, s, t), POSITION).unwrap()).norm());
                // Inside, where there is one derivative.
                if 0.0 < s.min(t) && s.max(t) < 1.0 && size[0].min(size[1]) > 0.0 {
                    let along = |way: [f64; 2]| theirs(1, 0) * way[0] + theirs(0, 1) * way[1];
                    let scale = size[0].max(size[1]).max(1.0);
                    for (k, own) in [ours(1, 0), ours(0, 1)].into_iter().enumerate() {
                        assert!((own - along(ways[k])).norm() < 1e-13 * scale, "{context}");
                    }
                    let ([a, b], [c, d]) = (ways[0], ways[1]);
                    let mixed =
                        theirs(2, 0) * (a * c) + theirs(1, 1) * (a * d + b * c) + theirs(0, 2) * (b * d);
                    assert!((ours(1, 1) - mixed).norm() < 1e-12 * scale, "{context}");
                    seen += 1;
                }
            }
        }
        assert!(apart > 0.05, "{apart}");
        let Some(Splines::Surfaces(all)) = surface.splines() else { panic!("it is all splines") };
        let shown = rows.iter().filter(|d| **d > 0.0).count() * columns.iter().filter(|d| **d > 0.0).count();
        let mut spans = 0;
        for patch in &all {
            let middles = |direction| {
                let breaks = patch.space(direction).breakpoints();
                breaks.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect::<Vec<_>>()
            };
            for u in middles(Direction::U) {
                for v in middles(Direction::V) {
                    let there = patch.point(u, v).unwrap();
                    let near = (0..surface.faces().unwrap() as u32)
                        .map(|f| {
                            let at = Location::Face(f, 0.5, 0.5);
                            (surface.value(at, POSITION).unwrap() - there.coords).norm()
                        })
                        .fold(f64::MAX, f64::min);
                    assert!(near < 1e-14, "{near:e}");
                    spans += 1;
                }
            }
        }
        assert_eq!(spans, 4 * shown);
    }
    assert!(seen > 1000, "{seen}");
}

/// All levels of a torus with double knots stay on the spline: middles of faces are where its knots cross, whatever stands beside.
#[test]
fn levels_stay_on_the_spline_at_double_knots() {
    for seed in 0..3 {
        let (mut rows, mut columns) = (stirred(5, seed), stirred(6, seed + 50));
        (rows[2], columns[3]) = (0.0, if seed > 0 { 0.0 } else { 1.0 });
        let (mut cage, spline) = quadratic_torus(&rows, &columns);
        let (mut us, mut vs) = (spline.u().breakpoints().to_vec(), spline.v().breakpoints().to_vec());
        for level in 0..4 {
            let places: Vec<Vector> =
                us.iter().flat_map(|u| vs.iter().map(|v| spline.point(*u, *v).unwrap().coords)).collect();
            for frame in limit_frames(&cage).unwrap() {
                let near = places.iter().map(|p| (p - frame.point.coords).norm()).fold(f64::MAX, f64::min);
                assert!(near < 1e-13, "{seed}, level {level}: {near:e}");
            }
            for knots in [&mut us, &mut vs] {
                let middles: Vec<f64> = knots.windows(2).map(|p| 0.5 * (p[0] + p[1])).collect();
                knots.extend(middles);
                knots.sort_unstable_by(f64::total_cmp);
            }
            cage = refine(&cage).unwrap();
        }
    }
}

/// A mesh of limits has one point where zero intervals bring several together, and no face without an extent.
#[test]
fn a_mesh_of_limits_has_no_double_points() {
    use loftsman_kernel::mesh::Mesh;
    use loftsman_kernel::plugin::{Context, Parameters, Registry};
    use loftsman_kernel::scene::{Geometry, Object, Scene};
    let (mut rows, mut columns) = (stirred(5, 7), stirred(6, 8));
    (rows[2], columns[3]) = (0.0, 0.0);
    let (cage, _) = quadratic_torus(&rows, &columns);
    let topology = cage.topology();
    let intervals: Vec<serde_json::Value> = (0..topology.edge_count())
        .flat_map(|e| {
            let ([a, b], [d, c]) = (topology.edge(e).unwrap(), cage.end_interval(e));
            [serde_json::json!([a, b, d]), serde_json::json!([b, a, c])]
        })
        .collect();
    let mut registry = Registry::new();
    registry.add(&loftsman_subdivision::Subdivision);
    for levels in 0..3 {
        let mut scene = Scene::new();
        scene.add(Object::new("torus", cage.to_mesh().unwrap().into())).unwrap();
        let fields = serde_json::json!({
            "scheme": "doo-sabin", "levels": levels, "limit": true, "intervals": intervals.clone()
        });
        let operation = registry.find_operation("subdivide", "step[0]").unwrap();
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
        let Geometry::Mesh(mesh) = scene.object("torus").unwrap().geometry() else { panic!("a mesh") };
        let mesh: &Mesh = mesh;
        // As a torus of a row and a column less.
        let count = (4 << levels) * (5 << levels);
        assert_eq!((mesh.points().len(), mesh.face_count()), (count, count), "{levels}");
        for (k, p) in mesh.points().iter().enumerate() {
            assert!(mesh.points()[..k].iter().all(|q| (p - q).norm() > 1e-6));
        }
    }
}

/// Equal intervals, however large, are none, to the last bit; and far from those that differ there is nothing of them.
#[test]
fn equal_intervals_are_none() {
    for (name, cage) in some() {
        let plain = DooSabinSurface::new(cage.clone()).unwrap();
        let same = DooSabinSurface::new(rowed(&cage, |_| 0.37)).unwrap();
        for face in 0..plain.faces().unwrap() as u32 {
            for (u, v) in [(0.0, 0.0), (0.3, 0.8), (1.0, 1.0)] {
                let at = Location::Face(face, u, v);
                assert_eq!(plain.value(at, POSITION).unwrap(), same.value(at, POSITION).unwrap(), "{name}");
            }
        }
        assert_eq!(plain.fields(), same.fields(), "{name}");
        // By intervals that differ but for rounding it takes the other way, to the same place.
        let nearly = DooSabinSurface::new(rowed(&cage, |k| 1.0 + 2e-16 * (k % 2) as f64)).unwrap();
        for face in 0..plain.faces().unwrap() as u32 {
            for (u, v) in [(0.0, 0.0), (0.3, 0.8), (1e-3, 2e-4), (1.0, 1.0)] {
                let at = Location::Face(face, u, v);
                for by in [POSITION, Derivative { u: 1, v: 0 }] {
                    if by == POSITION || u > 0.0 && u < 1.0 {
                        let (a, b) = (plain.value(at, by).unwrap(), nearly.value(at, by).unwrap());
                        assert!((a - b).norm() < 1e-12 * a.norm().max(1.0), "{name}: {a} {b}");
                    }
                }
            }
        }
    }
}

/// Middles of faces are the limits of refinement, with their planes, and so are those of vertices; the refined cage has the same surface, its faces
/// quarters of the first.
#[test]
fn refined_cages_have_the_same_surface() {
    for (name, cage) in uneven() {
        let surface = DooSabinSurface::new(cage.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let size = cage.points().iter().fold(1.0_f64, |m, p| m.max(p.coords.amax()));
        let frames = limit_frames(&cage).unwrap();
        let fine = refine(&cage).unwrap();
        let finer = DooSabinSurface::new(fine.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (topology, inner) = (cage.topology(), fine.topology());
        let inner_edges = (0..topology.edge_count()).filter(|&e| !topology.is_boundary_edge(e)).count();
        for face in 0..surface.faces().unwrap() as u32 {
            let value = |u: f64, v: f64| surface.value(Location::Face(face, u, v), POSITION).unwrap();
            let (of, corner) = surface.cage_corner(face).unwrap();
            assert!((value(0.0, 0.0) - frames[of].point.coords).norm() < 1e-13 * size, "{name}");
            let [du, dv] = [[1, 0], [0, 1]]
                .map(|[u, v]| surface.value(Location::Face(face, 0.0, 0.0), Derivative { u, v }).unwrap());
            let [a, b] = frames[of].tangents;
            let (ours, theirs) = (du.cross(&dv).normalize(), a.cross(&b).normalize());
            // The two sheets of a pillow touch where they meet.
            assert!((ours - theirs).norm() < 1e-9 || name.starts_with("pillow"), "{name}: {ours} {theirs}");
            // The quarter at the middle of the cage's face, and that at the vertex.
            let quarter = finer.face_of(of, corner).unwrap().unwrap();
            let half = topology.face_corners(of).start + corner;
            let vertex = topology.corners()[half] as usize;
            let before =
                (0..vertex).filter(|&v| !topology.is_boundary_vertex(v) && topology.valence(v) > 2).count();
            let round = topology.face_count() + inner_edges + before;
            let place = inner.face(round).iter().position(|&v| v as usize == half).unwrap();
            let last = finer.face_of(round, place).unwrap().unwrap();
            for (u, v) in [(0.0, 0.0), (0.3, 0.9), (0.01, 0.02), (1.0, 0.4), (1.0, 1.0)] {
                let there = |f| finer.value(Location::Face(f, u, v), POSITION).unwrap();
                assert!((value(0.5 * u, 0.5 * v) - there(quarter)).norm() < 1e-13 * size, "{name}");
                assert!((value(1.0 - 0.5 * u, 1.0 - 0.5 * v) - there(last)).norm() < 1e-13 * size, "{name}");
            }
        }
    }
}

/// Neighbours meet along their sides with one tangent plane, near extraordinary points, too.
#[test]
fn it_is_smooth_across_sides() {
    // The two sheets of a pillow touch, and have no plane where they meet.
    for (name, cage) in uneven().into_iter().filter(|(name, _)| !name.starts_with("pillow")) {
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        let topology = cage.topology();
        for face in 0..surface.faces().unwrap() as u32 {
            let (of, corner) = surface.cage_corner(face).unwrap();
            let size = topology.face(of).len();
            let Some(other) = surface.face_of(of, (corner + size - 1) % size).unwrap() else { continue };
            for t in [1e-5, 0.1, 0.37, 0.5, 0.9, 1.0 - 1e-5] {
                let (one, two) = (Location::Face(face, t, 0.0), Location::Face(other, 0.0, t));
                let value = |at, u, v| surface.value(at, Derivative { u, v }).unwrap();
                assert!((value(one, 0, 0) - value(two, 0, 0)).norm() < 1e-12, "{name}");
                let normal = |at| {
                    let tangents = [value(at, 1, 0), value(at, 0, 1)];
                    LimitFrame { point: Point::origin(), tangents }.normal()
                };
                if let (Some(a), Some(b)) = (normal(one), normal(two)) {
                    assert!((a - b).norm() < 1e-6, "{name}, {face} {t}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn it_is_a_shape_and_a_kind() {
    let mut cages = uneven();
    let (mut rows, columns) = (stirred(5, 3), stirred(6, 4));
    rows[2] = 0.0;
    cages.push(("double knot".to_owned(), quadratic_torus(&rows, &columns).0));
    for (name, cage) in &cages {
        if !["sheet", "double knot", "tetrahedron"].contains(&name.as_str()) {
            continue;
        }
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        let verdict = shape_conformance(&surface);
        assert!(verdict.passed(), "{name}: {}", verdict.to_string().chars().take(2000).collect::<String>());
    }
    let some = ["cube with a hole", "fan of 5"];
    let samples: Vec<Box<dyn Shape>> = cages
        .into_iter()
        .filter(|(name, _)| some.contains(&name.as_str()))
        .map(|(_, cage)| Box::new(DooSabinSurface::with_depth(cage, 3).unwrap()) as Box<dyn Shape>)
        .collect();
    assert_eq!(samples.len(), some.len());
    let kind: Arc<dyn ShapeKind> = Arc::new(KindOf::<DooSabinSurface>::default());
    let verdict = kind_conformance(&kind, &samples);
    assert!(verdict.passed(), "{}", verdict.to_string().chars().take(3000).collect::<String>());
}

fn triangles(surface: &DooSabinSurface, part: f64) -> Mesh {
    let fineness = Fineness { chord: Chord::Relative(part), angle: 10.0 };
    let faceted = DooSabinSurface::tessellate(&[surface], &fineness).unwrap();
    assert!(faceted.certified && faceted.error <= faceted.tolerance);
    let Drawn::Mesh(mesh) = faceted.drawn else { panic!("it is a surface") };
    for (p, at) in mesh.points().iter().zip(&faceted.places) {
        let there = surface.value(*at, POSITION).unwrap();
        assert!((p.coords - there).norm() < 1e-12 * there.norm());
    }
    mesh
}

/// Vertices less edges plus faces, and the number of open sides.
fn counts(mesh: &Mesh) -> (i64, usize) {
    let mut sides: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for c in mesh.corners().chunks(3) {
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            assert_ne!(a, b);
            *sides.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    assert!(sides.values().all(|count| *count < 3));
    let open = sides.values().filter(|count| **count == 1).count();
    (mesh.points().len() as i64 - sides.len() as i64 + mesh.face_count() as i64, open)
}

/// Triangles are certified and do not gape, of closed surfaces with Euler's characteristic; lines without extent leave no faces behind.
#[test]
fn triangles_are_closed() {
    for (name, cage) in uneven() {
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        let (characteristic, open) = counts(&triangles(&surface, 2e-2));
        let topology = cage.topology();
        let closed = (0..topology.edge_count()).all(|e| !topology.is_boundary_edge(e));
        if closed && !cage.is_hole(1) {
            let [v, e, f] = [topology.vertex_count(), topology.edge_count(), topology.face_count()];
            assert_eq!((characteristic, open), (v as i64 - e as i64 + f as i64, 0), "{name}");
        } else {
            assert!(open > 0, "{name}");
        }
    }
    let (mut rows, mut columns) = (stirred(6, 1), stirred(7, 51));
    (rows[2], rows[4], columns[3]) = (0.0, 0.0, 0.0);
    let surface = DooSabinSurface::new(quadratic_torus(&rows, &columns).0).unwrap();
    let mesh = triangles(&surface, 1e-2);
    assert_eq!(counts(&mesh), (0, 0));
    let area = |c: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points()[c[k] as usize]);
        (b - a).cross(&(c - a)).norm()
    };
    assert!(mesh.corners().chunks(3).all(|c| area(c) > 1e-9), "no triangle is a line");
    // A sheet whose double knot runs into its boundary, and one whose outermost vertices inside have none: sides have lengths.
    for line in [2, 1] {
        let sheet = crate::shapes::grid(6, 7, [false, false], 0.3);
        let at = |i: usize, j: usize| 7 * i + j;
        let sheet = (0..7).fold(sheet, |sheet, j| {
            let (own, next, before) = (at(line, j), at(line + 1, j), at(line - 1, j));
            sheet.with_end_interval(own, next, 0.0).unwrap().with_end_interval(own, before, 0.0).unwrap()
        });
        let surface = DooSabinSurface::new(sheet).unwrap();
        let (characteristic, open) = counts(&triangles(&surface, 1e-2));
        assert!(characteristic == 1 && open > 0, "{line}");
        let edges = surface.edges().unwrap();
        // Two sides of half a face each for every face along the rim that has an extent: 3 of 4 rows, 5 columns.
        assert_eq!(edges.count(), 2 * (2 * 3 + 2 * 5), "{line}");
        for k in 0..edges.count() {
            let edge = edges.edge(k).unwrap();
            let at = |t: f64| {
                let (u, v) = if edge.along_u { (t, edge.fixed) } else { (edge.fixed, t) };
                surface.value(Location::Face(edge.face.unwrap(), u, v), POSITION).unwrap()
            };
            assert!((at(1.0) - at(0.0)).norm() > 0.1, "{line}: {}", edge.name);
        }
    }
}

/// What moves, turns or grows with its vertices: rows know nothing of coordinates, and triangles are cut at any size.
#[test]
fn it_goes_with_its_cage() {
    let turn = loftsman_kernel::nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for (name, cage) in uneven().into_iter().step_by(5) {
        let surface = DooSabinSurface::new(cage.clone()).unwrap();
        for scale in [1e-9, 1.0, 1e9] {
            let move_by = |p: &Point| Point::from((turn * p.coords + Vector::new(1.0, -2.0, 0.5)) * scale);
            let mut moved = surface.clone();
            moved.control_vertices_mut().iter_mut().for_each(|p| *p = move_by(p));
            for face in (0..surface.faces().unwrap() as u32).step_by(3) {
                for (u, v) in [(0.0, 0.0), (0.2, 0.7), (1.0, 1.0)] {
                    let at = Location::Face(face, u, v);
                    let [was, is] = [&surface, &moved].map(|s| s.value(at, POSITION).unwrap());
                    assert!((is - move_by(&Point::from(was)).coords).norm() < 2e-14 * scale, "{name}");
                }
            }
        }
        // Powers of two, so that no coordinate is rounded.
        let counts = [-30, 0, 30].map(|power| {
            let mut scaled = surface.clone();
            scaled.control_vertices_mut().iter_mut().for_each(|p| *p *= 2.0_f64.powi(power));
            triangles(&scaled, 2e-2).face_count()
        });
        assert!(counts.iter().all(|count| *count == counts[0]), "{name}: {counts:?}");
    }
}

/// Where places between are not known, the face or vertex is named, and what to do.
#[test]
fn what_there_is_none_of_says_so() {
    let grid = || crate::shapes::grid(5, 5, [false, false], 0.1);
    let refused = |cage: Cage| {
        let error = DooSabinSurface::new(cage).unwrap_err().to_string();
        assert!(error.contains("limit = true"), "{error}");
        error
    };
    let error = refused(grid().with_end_interval(6, 7, 2.0).unwrap());
    assert!(error.starts_with("face ") && error.contains("vertex 6 towards 7"), "{error}");
    let zero = |row: std::ops::Range<usize>| {
        row.fold(grid(), |cage, i| {
            (0..5).fold(cage, |cage, j| {
                let (own, next, before) = (5 * i + j, 5 * (i + 1) + j, 5 * (i - 1) + j);
                cage.with_end_interval(own, next, 0.0).unwrap().with_end_interval(own, before, 0.0).unwrap()
            })
        })
    };
    assert!(DooSabinSurface::new(zero(2..3)).is_ok());
    // Two beside each other, and a half without the other.
    assert!(refused(zero(1..3)).contains("has the interval 0 towards"));
    let half = (0..5).fold(grid(), |cage, j| cage.with_end_interval(10 + j, 15 + j, 0.0).unwrap());
    assert!(refused(half).contains("has the interval 0 towards"));
    // All alike they are none; at an extraordinary vertex there is no double knot.
    let fan = crate::shapes::fan(5, 4, true, 0.1);
    assert!(DooSabinSurface::new(rowed(&fan, |_| 0.0)).is_ok());
    let none = refused(fan.with_end_interval(0, 1, 0.0).unwrap());
    assert!(none.starts_with("face "), "{none}");
    let fan = crate::shapes::fan(5, 4, true, 0.1);
    let none = refused(rowed(&fan, |row| if row == 0 { 0.0 } else { 1.0 }));
    assert!(none.contains("has the interval 0 towards"), "{none}");
    // Twelve edges bear a ratio of 1:2 and not one of 1:100; three any.
    for (n, ratio, smooth) in [(12, 2.0, true), (12, 100.0, false), (5, 9.0, true), (3, 1e6, true)] {
        let cage = rowed(&crate::shapes::fan(n, 4, true, 0.1), |row| if row % 3 == 0 { ratio } else { 1.0 });
        match DooSabinSurface::new(cage) {
            Ok(_) => assert!(smooth, "{n} {ratio}"),
            Err(error) => {
                assert!(
                    !smooth && error.to_string().starts_with("vertex 0 has 12 edges"),
                    "{n} {ratio}: {error}"
                );
            }
        }
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1e-200] {
        let error = grid().with_end_interval(6, 7, bad).unwrap_err().to_string();
        assert!(error.contains("interval of vertex 6 towards 7"), "{error}");
    }
    assert!(grid().with_end_interval(6, 8, 1.0).unwrap_err().to_string().contains("no edge"));
}
