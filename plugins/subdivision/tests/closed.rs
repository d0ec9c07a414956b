//! Volumes of closed surfaces: cones over what the cells leave out make them those of a surface without a gap.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::f64::consts::TAU;

use loftsman_area_volume::{centroid, volume, volume_of};
use loftsman_kernel::conformance::shape_conformance;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Equation, Functional, On, Shapes, Store, position, rows_of};
use loftsman_kernel::shape::{Cell, Cells, Derivative, Domain, Hole, Location, Shape, Share, Stencil};
use loftsman_kernel::{Point, Result, Vector};
use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::doo_sabin::DooSabinSurface;
use loftsman_subdivision::{Cage, SubdivisionSurface};

use crate::rows::rows;
use crate::shapes::{cube, double_fan, noise, rowed, tetrahedron};

/// Whole numbers below a bound that look random and are always the same.
fn below(seed: u64, bound: usize) -> usize {
    (((0.5 + 0.5 * noise(seed)) * bound as f64) as usize).min(bound - 1)
}

fn stirred(cage: &Cage, by: f64) -> Cage {
    let mut cage = cage.clone();
    for (k, p) in cage.points_mut().iter_mut().enumerate() {
        *p += Vector::from([0, 1, 2].map(|axis| by * noise((5000 + 3 * k + axis) as u64)));
    }
    cage
}

/// Some edges and vertices made sharp, to degrees that differ from one to the next.
fn sharpened(cage: &Cage, seed: u64) -> Cage {
    let topology = cage.topology();
    let mut sharp = cage.clone();
    for k in 0..1 + below(seed, 5) as u64 {
        let edge = below(100 * seed + 3 * k, topology.edge_count());
        let [a, b] = topology.edge(edge).unwrap().map(|v| v as usize);
        let sharpness = [0.5, 1.0, 2.5, f64::INFINITY][below(100 * seed + 3 * k + 1, 4)];
        sharp = sharp.with_crease(a, b, sharpness).unwrap();
        if k == 3 {
            let vertex = below(100 * seed + 3 * k + 2, topology.vertex_count());
            sharp = sharp.with_corner(vertex, [1.0, f64::INFINITY][below(seed + 77, 2)]).unwrap();
        }
    }
    sharp
}

/// Closed cages with extraordinary vertices of every kind.
fn cages() -> Vec<(String, Cage)> {
    let fine = |cage: &Cage| stirred(&refine(cage).unwrap(), 0.03);
    let mut all = vec![("cube".to_owned(), cube()), ("fine cube".to_owned(), fine(&cube()))];
    all.push(("tetrahedron".into(), tetrahedron()));
    for n in 3..=8 {
        all.push((format!("double fan of {n}"), double_fan(n, 0.1)));
        all.push((format!("fine double fan of {n}"), fine(&double_fan(n, 0.1))));
    }
    for seed in 0..24_u64 {
        let (kind, base) = [
            ("cube", fine(&cube())),
            ("fan", fine(&double_fan(3 + seed as usize % 6, 0.1))),
            ("coarse fan", double_fan(3 + seed as usize % 5, 0.1)),
            ("tetrahedron", fine(&tetrahedron())),
        ][seed as usize % 4]
            .clone();
        all.push((format!("sharp {kind} {seed}"), sharpened(&base, seed)));
    }
    // Creases through a vertex, on one side of which it is regular, and corners that are.
    for n in [5, 6] {
        let cage = fine(&double_fan(n, 0.1));
        let around: Vec<usize> = cage.topology().vertex_edges(0).map(|e| e as usize).collect();
        for kept in [vec![0, 2], vec![0, 1, 3]] {
            let sharp = kept.iter().fold(cage.clone(), |cage, &k| {
                let [a, b] = cage.topology().edge(around[k]).unwrap().map(|v| v as usize);
                cage.with_crease(a, b, f64::INFINITY).unwrap()
            });
            all.push((format!("uneven sharp through {n}, {}", kept.len()), rows(&sharp, 1.5, n as u64)));
            all.push((format!("sharp through {n}, {}", kept.len()), sharp));
        }
    }
    for seed in 0..4 {
        all.push((format!("uneven cube {seed}"), rows(&fine(&cube()), 2.0, seed)));
        all.push((format!("uneven fan {seed}"), rows(&double_fan(3 + seed as usize, 0.1), 2.0, seed)));
        all.push((
            format!("uneven sharp {seed}"),
            rows(&sharpened(&fine(&double_fan(4 + seed as usize, 0.1)), seed), 1.5, seed),
        ));
    }
    all
}

/// A closed surface of some depth.
type Make = Box<dyn Fn(u32) -> Box<dyn Shape>>;

/// Those of all cages, by Catmull and Clark and, where nothing is sharp, by Doo and Sabin with equal intervals and others.
fn surfaces() -> Vec<(String, Make)> {
    let mut all: Vec<(String, Make)> = Vec::new();
    for (name, cage) in cages() {
        let plain = !name.contains("sharp") && !name.contains("uneven");
        let own = cage.clone();
        all.push((
            name.clone(),
            Box::new(move |depth| Box::new(SubdivisionSurface::with_depth(own.clone(), depth).unwrap())),
        ));
        if plain {
            let uneven = rowed(&cage, |row| 1.0 + 0.2 * noise(row));
            for (name, cage) in
                [(format!("{name}, Doo-Sabin"), cage), (format!("{name}, Doo-Sabin, uneven"), uneven)]
            {
                all.push((
                    name,
                    Box::new(move |depth| {
                        Box::new(DooSabinSurface::with_depth(cage.clone(), depth).unwrap())
                    }),
                ));
            }
        }
    }
    all
}

fn together(shapes: &[&dyn Shape]) -> f64 {
    let (mut out, all) = ([0.0], (0..shapes.len()).map(On::from));
    volume().of(all).value(&Shapes::new(shapes.iter().copied()), &mut out).unwrap();
    out[0]
}

fn shifted(shape: &dyn Shape, by: Vector) -> Box<dyn Shape> {
    let mut shape = shape.boxed();
    shape.control_vertices_mut().iter_mut().for_each(|p| *p += by);
    shape
}

/// A torus: no vertex is extraordinary.
fn ring() -> Cage {
    let mut cage = crate::shapes::grid(4, 5, [true, true], 0.0);
    for (k, p) in cage.points_mut().iter_mut().enumerate() {
        let (s, t) = (TAU * (k / 5) as f64 / 4.0, TAU * (k % 5) as f64 / 5.0);
        let r = 0.6 + 0.3 * t.cos();
        *p = Point::new(r * s.cos(), r * s.sin(), 0.3 * t.sin());
    }
    cage
}

/// A shape between two others: volumes and centroids are taken from the middle between a surface and itself a thousand sizes away, so that those of
/// both together are those of each only where nothing depends on the origin.
#[test]
fn volumes_do_not_depend_on_the_origin() {
    let (mut unlike, mut whole) = (0, 0);
    let away = Vector::new(1024.0, -512.0, 256.0);
    let torus = SubdivisionSurface::new(ring()).unwrap();
    assert!(torus.holes().is_empty());
    let torus = shifted(&torus, away);
    for (name, make) in surfaces() {
        for depth in [1, 3] {
            let own = make(depth);
            let far = shifted(own.as_ref(), away);
            // Beside one that has no holes, for what two like ones lose on either side of the middle is as much.
            let [alone, other] = [own.as_ref(), torus.as_ref()].map(|shape| together(&[shape]));
            let off = (together(&[own.as_ref(), torus.as_ref()]) - alone - other).abs();
            assert!(off <= 1e-11 * (alone + other), "{name}, depth {depth}: {off:e} of {alone}");
            let middle = |shapes: &[&dyn Shape]| {
                let mut out = [0.0; 3];
                let all = (0..shapes.len()).map(On::from);
                centroid().of(all).value(&Shapes::new(shapes.iter().copied()), &mut out).unwrap();
                Vector::from(out)
            };
            let off = middle(&[own.as_ref(), far.as_ref()]) - middle(&[own.as_ref()]) - away * 0.5;
            assert!(off.norm() <= 1e-9, "{name}, depth {depth}: {off}");
            let holes = own.cells().unwrap().holes();
            let chains = |hole: &Hole| hole.border[0].from != hole.apex && hole.border.len() > 2;
            unlike += holes.iter().filter(|hole| depth > 1 && chains(hole)).count();
            whole += holes.iter().filter(|hole| hole.border[0].from == hole.apex).count();
        }
    }
    // Beside holes of another size, and beside none: both occur, in cages with triangles or with a few sharp edges.
    assert!(unlike > 100 && whole > 10, "{unlike} {whole}");
}

/// What is off falls by `λ² μ` from a level to the next, as area times height: 16 where the sub-dominant eigenvalue `λ` is one half and `μ`, the next
/// that does not turn, a quarter. Of Doo and Sabin it always is; of Catmull and Clark both are known (Ball and Storry 1988).
#[test]
fn volumes_come_to_their_limit_with_the_fourth_power() {
    let share = |n: usize| {
        let (c, n) = ((TAU / n as f64).cos(), n as f64);
        let lambda = (c + 5.0 + ((c + 9.0) * (c + 1.0)).sqrt()) / 16.0;
        let (own, faces) = (3.0 - 7.0 / n, 1.5 / n);
        lambda * lambda * (own + (own * own + 8.0 * faces - 4.0).sqrt()) / 8.0
    };
    let mut looked = 0;
    for (name, make) in surfaces() {
        let fan = name.strip_prefix("double fan of ").and_then(|rest| rest[..1].parse::<usize>().ok());
        let (Some(n), false) = (fan, name.contains("uneven")) else { continue };
        // Middles of triangles have three edges, too, and of four quads nothing is left out.
        let n = if n == 4 { 3 } else { n };
        let by = if name.contains("Doo") { 16.0 } else { 1.0 / share(n).max(share(3)) };
        let deep = together(&[make(13).as_ref()]);
        let off = [3, 4, 5].map(|depth| (together(&[make(depth).as_ref()]) - deep).abs());
        for pair in off.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!(ratio > 0.9 * by && ratio < 1.15 * by, "{name}: {ratio}, and not {by}");
            looked += 1;
        }
    }
    assert!(looked >= 24, "{looked}");
}

/// The gradient is that of the volume that is told: by differences, which are exact, for the volume is linear in each coordinate of a vertex. No motion
/// of the whole changes it.
#[test]
fn gradients_are_those_of_a_closed_surface() {
    for (number, (name, make)) in surfaces().into_iter().enumerate() {
        let surface = make(2);
        let shapes = Shapes::one(surface.as_ref());
        let bound = volume().bind(&shapes).unwrap().unwrap();
        let mut store = Store::default();
        rows_of(bound.as_ref(), &shapes, &mut store.rows(&shapes)).unwrap();
        let mut gradient = vec![Vector::zeros(); surface.control_vertices().len()];
        for equation in store.equations() {
            let Equation::Coupled { vertices, vectors, .. } = equation else { panic!("{name}: alike") };
            vertices.iter().zip(vectors).for_each(|(&v, g)| gradient[v] += g);
        }
        let sum = gradient.iter().fold(Vector::zeros(), |sum, g| sum + g);
        let size: f64 = gradient.iter().map(Vector::norm).sum();
        assert!(sum.norm() <= 1e-13 * size, "{name}: {sum} of {size}");
        if number % 3 > 0 {
            continue;
        }
        let value = |vertex: usize, axis: usize, by: f64| {
            let mut moved = surface.boxed();
            moved.control_vertices_mut()[vertex][axis] += by;
            together(&[moved.as_ref()])
        };
        for vertex in (0..gradient.len()).step_by(gradient.len().div_ceil(3)) {
            for axis in 0..3 {
                let rate = (value(vertex, axis, 0.5) - value(vertex, axis, -0.5)) - gradient[vertex][axis];
                assert!(rate.abs() <= 1e-12 * size, "{name}: {rate:e} of {size} at {vertex}");
            }
        }
    }
}

/// A volume that is kept in an edit is the same when it is measured afterwards, from another origin.
#[test]
fn volumes_that_are_kept_are_measured_as_kept() {
    for (name, make) in surfaces().into_iter().step_by(4) {
        let surface = make(2);
        let at = Location::Face(0, 0.3, 0.4);
        let there = surface.value(at, Derivative::POSITION).unwrap();
        let wanted = Point::from(there) + Vector::new(0.05, -0.04, 0.08);
        let edited = Edit::new(&surface)
            .ask(position(at).to(wanted))
            .ask(volume().keep())
            .solve()
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let (was, is) = (volume_of(surface.as_ref()).unwrap(), volume_of(edited.shape()).unwrap());
        assert!((is / was - 1.0).abs() < 1e-11, "{name}: {was} {is}");
    }
}

/// What they say of holes is so.
#[test]
fn holes_are_what_is_left_out() {
    for (name, make) in surfaces().into_iter().step_by(5) {
        let verdict = shape_conformance(make(6).as_ref());
        assert!(verdict.passed(), "{name}: {}", verdict.to_string().chars().take(1500).collect::<String>());
    }
    let open = [
        crate::shapes::fan(3, 4, false, 0.1),
        crate::shapes::fan(1, 4, false, 0.1),
        crate::shapes::fan(5, 3, false, 0.1).with_crease(0, 2, 2.5).unwrap(),
        cube().with_hole(1).unwrap(),
    ];
    for (k, cage) in open.into_iter().enumerate() {
        let surface = SubdivisionSurface::with_depth(cage, 6).unwrap();
        // Derivatives across edges that end at extraordinary vertices they do not have.
        let verdict = shape_conformance(&surface).to_string();
        assert!(!verdict.contains("hole") && !verdict.contains("cell"), "{k}: {verdict}");
    }
}

/// Two open surfaces with extraordinary vertices on their common boundary are closed together.
#[test]
fn open_surfaces_close_together() {
    for (n, creased) in [(3, false), (4, false), (5, true)] {
        let crease = |cage: Cage| if creased { cage.with_crease(0, 2, f64::INFINITY).unwrap() } else { cage };
        let lid = crease(crate::shapes::fan(n, 4, false, 0.1));
        // The same from below: faces run the other way, and vertices that are not on the boundary lie elsewhere.
        let topology = lid.topology();
        let faces: Vec<Vec<usize>> = (0..topology.face_count())
            .map(|f| topology.face(f).iter().rev().map(|&v| v as usize).collect())
            .collect();
        let mut points = lid.points().to_vec();
        (0..points.len()).filter(|&v| !topology.is_boundary_vertex(v)).for_each(|v| points[v].z -= 2.0);
        let inner = (0..points.len()).any(|v| !topology.is_boundary_vertex(v));
        let (mut lid, mut floor) = (lid.clone(), crease(Cage::new(points, &faces).unwrap()));
        if !inner {
            (lid, floor) = (refine(&lid).unwrap(), refine(&floor).unwrap());
            let topology = floor.topology().clone();
            let own: Vec<usize> =
                (0..floor.points().len()).filter(|&v| !topology.is_boundary_vertex(v)).collect();
            own.into_iter().for_each(|v| floor.points_mut()[v].z -= 2.0);
        }
        for depth in [1, 3] {
            let [lid, floor] =
                [&lid, &floor].map(|cage| SubdivisionSurface::with_depth(cage.clone(), depth).unwrap());
            let away = Vector::new(1024.0, -512.0, 256.0);
            let [far_lid, far_floor] = [&lid, &floor].map(|s| shifted(s, away));
            let alone = together(&[&lid, &floor]);
            let both = together(&[&lid, &floor, far_lid.as_ref(), far_floor.as_ref()]);
            let off = (both - 2.0 * alone).abs();
            assert!(off <= 1e-11 * alone.abs(), "{n} {depth}: {off:e} of {alone}");
        }
    }
}

/// A surface that says which way its faces point, and perhaps that not all of it counts.
#[derive(Debug, Clone)]
struct Said {
    surface: SubdivisionSurface,
    sense: f64,
    partial: bool,
}

impl Shape for Said {
    fn control_vertices(&self) -> &[Point] {
        self.surface.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.surface.control_vertices_mut()
    }

    fn stencil(&self, at: Location, by: Derivative) -> Result<Stencil> {
        self.surface.stencil(at, by)
    }

    fn domain(&self) -> Domain {
        self.surface.domain()
    }

    fn faces(&self) -> Option<usize> {
        self.surface.faces()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }
}

impl Cells for Said {
    fn count(&self) -> usize {
        Cells::count(&self.surface)
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        self.surface.cell(index)
    }

    fn holes(&self) -> Vec<Hole> {
        self.surface.holes()
    }

    fn is_partial(&self) -> bool {
        self.partial
    }

    fn shares(&self) -> Result<Option<Vec<Share>>> {
        Ok(self.partial.then(|| vec![Share::Whole; Cells::count(self)]))
    }

    fn senses(&self) -> Option<Result<Vec<f64>>> {
        Some(Ok(vec![self.sense; self.surface.faces().unwrap_or(0)]))
    }
}

/// Holes count as their faces do; where only a part of a surface counts they do not.
#[test]
fn holes_count_as_their_faces_do() {
    let surface = SubdivisionSurface::with_depth(double_fan(5, 0.1), 2).unwrap();
    let said = |sense: f64, partial: bool| together(&[&Said { surface: surface.clone(), sense, partial }]);
    let whole = together(&[&surface]);
    assert!((said(1.0, false) - whole).abs() < 1e-13 * whole, "{} {whole}", said(1.0, false));
    assert!((said(-1.0, false) + whole).abs() < 1e-13 * whole);
    assert!((said(1.0, true) - whole).abs() > 1e-2 * whole, "{} {whole}", said(1.0, true));
    // Then it depends on the origin: beside another a thousand sizes away it is another.
    let torus = shifted(&SubdivisionSurface::new(ring()).unwrap(), Vector::new(1024.0, -512.0, 256.0));
    let beside = |shape: &dyn Shape| {
        let [alone, other] = [shape, torus.as_ref()].map(|shape| together(&[shape]));
        (together(&[shape, torus.as_ref()]) - alone - other).abs()
    };
    assert!(beside(&surface) < 1e-11 * whole);
    // Holes at the two ends of a double fan have opposite areas; those of this one do not.
    let surface = SubdivisionSurface::with_depth(stirred(&refine(&cube()).unwrap(), 0.2), 2).unwrap();
    let open = beside(&Said { surface, sense: 1.0, partial: true });
    assert!(open > 1e-6 * whole, "{open:e}");
}
