//! What is said of errors is so: triangles, patches and what cells leave out.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::functional::{Functional, Shapes};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, DeclaredShape, Drawn, Fineness};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point};
use loftsman_subdivision::{Cage, SubdivisionSurface};

/// Cages whose faces are regular, irregular in every way, creased, open, holed.
fn cages() -> Vec<(String, Cage)> {
    let wanted = |name: &str| {
        let plain = ["cube", "tetrahedron", "one face of 5", "one face of 3, no corners", "pillow of 5"];
        let fans = [
            "double fan of 3",
            "double fan of 5",
            "double fan of 12",
            "fan of 6 faces of 5",
            "open fan of 3 of 4",
        ];
        let open = [
            "open fan of 1 of 4, no corners",
            "open fan of 5 of 3",
            "grid [false, false]",
            "grid [true, true]",
        ];
        let sharp = [
            "fan of 5, 1 creases of 10",
            "fan of 5, 2 creases of inf",
            "fan of 7, 3 creases of 1.7",
            "sharp vertex 2.5 of 5",
        ];
        plain.iter().chain(&fans).chain(&open).chain(&sharp).any(|s| *s == name)
    };
    let mut all: Vec<(String, Cage)> =
        crate::shapes::all().into_iter().filter(|(name, _)| wanted(name)).collect();
    assert_eq!(all.len(), 18);
    all.push(("cube with a hole".into(), crate::shapes::cube().with_hole(1).unwrap()));
    all
}

fn scaled(cage: &Cage, by: f64) -> Cage {
    let mut cage = cage.clone();
    cage.points_mut().iter_mut().for_each(|p| *p *= by);
    cage
}

/// Places all over a face, many of them near its corners.
pub(crate) fn places(face: u32, count: u64) -> impl Iterator<Item = Location> {
    (0..count).map(move |k| {
        let seed = 7919 * u64::from(face) + 2 * k;
        let [mut u, mut v] = [seed, seed + 1].map(|s| 0.5 + 0.5 * crate::shapes::noise(s));
        if k % 3 == 0 {
            (u, v) = (u.powi(4), v.powi(4));
        }
        let turned = [(u, v), (1.0 - u, v), (1.0 - u, 1.0 - v), (u, 1.0 - v)][(k % 4) as usize];
        Location::Face(face, turned.0, turned.1)
    })
}

pub(crate) fn point(surface: &dyn Shape, at: Location) -> Point {
    Point::from(surface.value(at, Derivative::POSITION).unwrap())
}

fn from_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let along = b - a;
    let size = along.norm_squared();
    let t = if size > 0.0 { ((p - a).dot(&along) / size).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + along * t)).norm()
}

fn from_triangle(p: &Point, [a, b, c]: [&Point; 3]) -> f64 {
    let sides = from_segment(p, a, b).min(from_segment(p, b, c)).min(from_segment(p, c, a));
    let normal = (b - a).cross(&(c - a));
    let inside = |a: &Point, b: &Point| (b - a).cross(&(p - a)).dot(&normal) >= 0.0;
    if normal.norm() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        ((p - a).dot(&normal) / normal.norm()).abs()
    } else {
        sides
    }
}

fn from_mesh(p: &Point, mesh: &Mesh) -> f64 {
    let mut best = f64::INFINITY;
    for f in mesh.faces() {
        let [a, b, c] = [0, 1, 2].map(|k| &mesh.points()[f[k] as usize]);
        if (p - a).norm() - (b - a).norm().max((c - a).norm()) < best {
            best = best.min(from_triangle(p, [a, b, c]));
        }
    }
    best
}

/// Every point of the surface is as near to the triangles as they say, and what they say is not far from what is so.
#[test]
fn triangles_are_as_near_as_they_say() {
    let (mut looked, mut ratios) = (0, Vec::new());
    for (name, cage) in cages() {
        for (chord, by) in [(2e-2, 1.0), (4e-3, 1e9)] {
            let surface = SubdivisionSurface::new(scaled(&cage, by)).unwrap();
            let fineness = Fineness { chord: Chord::Relative(chord), angle: 10.0 };
            let faceted = SubdivisionSurface::tessellate(&[&surface], &fineness).unwrap();
            assert!(faceted.certified && faceted.error <= faceted.tolerance, "{name}");
            let Drawn::Mesh(mesh) = &faceted.drawn else { panic!("{name}: no mesh") };
            let faces = surface.faces().unwrap() as u32;
            let mut most: f64 = 0.0;
            for face in 0..faces {
                for at in places(face, 24) {
                    most = most.max(from_mesh(&point(&surface, at), mesh));
                    looked += 1;
                }
            }
            assert!(most <= faceted.error, "{name}: {most:e}, certified {:e}", faceted.error);
            ratios.push(faceted.error / most);
        }
    }
    ratios.sort_by(f64::total_cmp);
    let (middle, last) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
    println!("certified / found: {middle} in the middle, {last} at most, {looked} places");
    assert!(looked > 10_000 && middle < 2.5, "{looked}: {ratios:?}");
}

/// What patches say of their distance holds; each place of the surface is on one of them.
#[test]
fn patches_are_as_near_as_they_say() {
    // Where a surface lies on itself the nearest of its places is hard to find: a grid closed over itself is looked at below.
    for (name, cage) in
        cages().into_iter().filter(|(name, _)| !name.contains("pillow") && !name.contains("true, true"))
    {
        let surface = SubdivisionSurface::new(cage.clone()).unwrap();
        let mut counts = Vec::new();
        for tolerance in [1e-2, 1e-4] {
            let patches = surface.patches(tolerance).unwrap();
            assert!(patches.deviation <= tolerance, "{name}");
            assert_eq!(patches.deviation > 0.0, patches.exact < patches.surfaces.len(), "{name}");
            counts.push(patches.surfaces.len());
            let pieces = pieces(&patches.surfaces);
            for face in (0..surface.faces().unwrap() as u32).step_by(2) {
                for at in places(face, 12) {
                    let p = point(&surface, at);
                    let off = nearest(&p, pieces.iter());
                    assert!(off <= patches.deviation + 1e-9, "{name}, {at}: {off:e} {:e}", patches.deviation);
                }
            }
        }
        // The logarithm of the tolerance, and not a power of it.
        assert!(counts[1] <= 6 * counts[0] + 400, "{name}: {counts:?}");
    }
}

/// A polynomial piece, and points of it.
pub(crate) type Sampled = (Surface, Vec<(f64, f64, Point)>);

pub(crate) fn pieces(surfaces: &[Surface]) -> Vec<Sampled> {
    let all = surfaces.iter().flat_map(|s| s.bezier_patches().unwrap());
    all.map(|s| {
        let [(u0, u1), (v0, v1)] = [s.u().domain(), s.v().domain()];
        let grid = (0..81)
            .map(|k| (u0 + (u1 - u0) * f64::from(k / 9) / 8.0, v0 + (v1 - v0) * f64::from(k % 9) / 8.0));
        let points = grid.map(|(u, v)| (u, v, s.point(u, v).unwrap())).collect();
        (s, points)
    })
    .collect()
}

/// The distance from the nearest of some pieces: from the nearest point of each, step by step.
pub(crate) fn nearest<'a>(p: &Point, pieces: impl Iterator<Item = &'a Sampled>) -> f64 {
    let mut best = f64::INFINITY;
    for (surface, points) in pieces {
        let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
        let off = |q: &(f64, f64, Point)| (q.2 - p).norm();
        let Some(first) = points.iter().min_by(|a, b| off(a).total_cmp(&off(b))) else { continue };
        // No nearer than by what neighbours are apart.
        let spacing = points.windows(2);
        if off(first) - spacing.map(|w| (w[0].2 - w[1].2).norm()).fold(0.0, f64::max) > best {
            continue;
        }
        let (mut u, mut v) = (first.0, first.1);
        let mut reach = 0.0625;
        for _ in 0..24 {
            let off = p - surface.point(u, v).unwrap();
            best = best.min(off.norm());
            let (a, b) = (surface.derivative(u, v, 1, 0).unwrap(), surface.derivative(u, v, 0, 1).unwrap());
            let (aa, ab, bb) = (a.dot(&a), a.dot(&b), b.dot(&b));
            let (x, y, det) = (off.dot(&a), off.dot(&b), aa * bb - ab * ab);
            let to = |u: f64, v: f64| (u.clamp(u0, u1), v.clamp(v0, v1));
            // Newton's step, and where the surface is folded a step to either side.
            let (h, k) = (reach * (u1 - u0), reach * (v1 - v0));
            let mut steps = vec![to(u + h, v), to(u - h, v), to(u, v + k), to(u, v - k)];
            if det > 1e-12 * aa * bb {
                steps.push(to(u + (bb * x - ab * y) / det, v + (aa * y - ab * x) / det));
            }
            let at = |s: &(f64, f64)| (p - surface.point(s.0, s.1).unwrap()).norm();
            let Some(&next) = steps.iter().min_by(|a, b| at(a).total_cmp(&at(b))) else { break };
            if at(&next) < off.norm() {
                (u, v) = next;
            } else {
                reach *= 0.5;
            }
        }
    }
    best
}

/// All of the surface is there: of each cage of quads, n-gons and boundaries the patches have the area of the triangles.
#[test]
fn patches_leave_nothing_out() {
    // Rectangles that begin furthest left and down from a quad, and do not reach back to it.
    let points = [
        [3, 0, 0],
        [3, 0, 1],
        [2, 0, 1],
        [1, 0, -1],
        [2, 0, -1],
        [-2, 3, 0],
        [-1, 2, 1],
        [-1, 1, 1],
        [-1, 2, -1],
        [-2, -3, 0],
        [-2, -2, 1],
        [-1, -1, 1],
        [-1, -1, -1],
        [-1, -2, -1],
    ];
    let points = points.map(|p| Point::from(p.map(f64::from))).to_vec();
    let faces: [&[usize]; 6] = [
        &[5, 9, 10, 6],
        &[6, 10, 11, 7],
        &[8, 13, 9, 5],
        &[12, 3, 4, 13],
        &[13, 4, 0, 9],
        &[1, 2, 11, 10, 9, 0],
    ];
    let mut all: Vec<_> = crate::shapes::all().into_iter().step_by(3).collect();
    all.push(("a band with a fin".into(), Cage::new(points, &faces).unwrap()));
    let mut count = 0;
    for (name, cage) in all {
        let Ok(surface) = SubdivisionSurface::new(cage) else { continue };
        // Some fold over, and have no area that can be told well.
        let Ok(whole) = loftsman_area_volume::surface_area_of(&surface) else { continue };
        let patches = surface.patches(1e-3).unwrap();
        let each = patches.surfaces.iter().map(|s| loftsman_area_volume::surface_area_of(s).unwrap());
        let own = each.sum::<f64>();
        count += 1;
        assert!((own / whole - 1.0).abs() < 2e-3, "{name}: {own} {whole}");
    }
    assert!(count > 20, "{count}");
}

/// Sides of patches lie on sides of others: nothing gapes where the surface is closed.
#[test]
fn patches_close() {
    for (name, cage) in [
        ("cube", crate::shapes::cube()),
        ("fan", crate::shapes::double_fan(5, 0.1)),
        ("tetrahedron", crate::shapes::tetrahedron()),
    ] {
        let patches = SubdivisionSurface::new(cage).unwrap().patches(1e-3).unwrap();
        let pieces = pieces(&patches.surfaces);
        for (k, (surface, _)) in pieces.iter().enumerate() {
            let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
            for t in [0.13, 0.5, 0.77] {
                let (u, v) = (u0 + (u1 - u0) * t, v0 + (v1 - v0) * t);
                for (u, v) in [(u, v0), (u, v1), (u0, v), (u1, v)] {
                    let p = surface.point(u, v).unwrap();
                    let gap = nearest(&p, pieces.iter().enumerate().filter(|(o, _)| *o != k).map(|(_, s)| s));
                    assert!(gap < 1e-12, "{name}, {k}: {gap:e}");
                }
            }
        }
    }
}

/// A grid is one surface, closed or not, and that is the tensor-product spline.
#[test]
fn a_grid_is_one_surface() {
    for wrap in [[false, false], [true, false], [true, true]] {
        let surface = SubdivisionSurface::new(crate::shapes::grid(6, 7, wrap, 0.3)).unwrap();
        let patches = surface.patches(1e-3).unwrap();
        assert_eq!((patches.surfaces.len(), patches.exact, patches.deviation), (1, 1, 0.0), "{wrap:?}");
        // Each face is a piece of it, perhaps turned.
        let pieces = pieces(&patches.surfaces);
        assert_eq!(pieces.len(), surface.faces().unwrap());
        for face in 0..pieces.len() as u32 {
            let p = point(&surface, Location::Face(face, 0.3, 0.4));
            let near = pieces.iter().flat_map(|(s, _)| {
                let [(u, _), (v, _)] = [s.u().domain(), s.v().domain()];
                [(0.3, 0.4), (0.6, 0.3), (0.7, 0.6), (0.4, 0.7)].map(|(x, y)| s.point(u + x, v + y).unwrap())
            });
            assert!(near.map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min) < 1e-13);
        }
    }
    let creased = (0..5).try_fold(crate::shapes::grid(6, 5, [false; 2], 0.3), |cage, k| {
        if k == 4 { Ok(cage) } else { cage.with_crease(10 + k, 11 + k, 10.0) }
    });
    assert_eq!(SubdivisionSurface::new(creased.unwrap()).unwrap().patches(1e-3).unwrap().surfaces.len(), 2);
}

#[test]
fn tolerances_that_cannot_be_met_are_refused() {
    let surface = SubdivisionSurface::new(crate::shapes::cube()).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-17] {
        assert!(surface.patches(tolerance).unwrap_err().to_string().contains("tolerance"), "{tolerance}");
    }
    assert!(surface.patches(1e-12).unwrap().deviation <= 1e-12);
}

/// Area and volume to any depth differ from those of a greater one by less than is said, and not by so very much less.
#[test]
fn what_is_left_out_is_bounded() -> Result<(), Error> {
    let (mut tight, mut solids): (f64, u32) = (f64::INFINITY, 0);
    for (name, cage) in cages() {
        let closed = cage.topology().edge_count() > 0
            && (0..cage.topology().vertex_count()).all(|v| !cage.topology().is_boundary_vertex(v))
            && !(0..cage.topology().face_count()).any(|f| cage.is_hole(f));
        let measured = |depth: u32| -> Result<(f64, f64), Error> {
            let surface = SubdivisionSurface::with_depth(cage.clone(), depth).unwrap();
            let (mut area, mut volume) = ([0.0], [0.0]);
            let shapes = Shapes::new([&surface as &dyn Shape]);
            loftsman_area_volume::surface_area().value(&shapes, &mut area)?;
            match loftsman_area_volume::volume().value(&shapes, &mut volume) {
                _ if !closed => volume = [0.0],
                // Both sides of these are one.
                Err(error) if name.starts_with("pillow") => {
                    assert!(error.to_string().contains("encloses no volume"), "{name}: {error}");
                }
                found => found?,
            }
            Ok((area[0], volume[0]))
        };
        let deep = measured(14)?;
        for depth in [2, 4, 8] {
            let surface = SubdivisionSurface::with_depth(cage.clone(), depth).unwrap();
            let bound = surface.left_out().unwrap();
            let own = measured(depth)?;
            let rounding = 1e-10 * deep.0;
            let (area, volume) = ((deep.0 - own.0).abs(), (deep.1 - own.1).abs());
            assert!(area <= bound.area + rounding, "{name} {depth}: {area:e} {bound:?}");
            assert!(volume <= bound.volume + rounding, "{name} {depth}: {volume:e} {bound:?}");
            if closed && volume > 100.0 * rounding {
                assert!(bound.volume < 16.0 * volume, "{name} {depth}: {volume:e} {bound:?}");
                solids += 1;
            }
            if bound.count == 0 {
                assert!(area <= rounding && bound.area == 0.0);
            } else if area > 100.0 * rounding {
                tight = tight.min(bound.area / area);
                assert!(bound.area < 40.0 * area, "{name} {depth}: {area:e} {bound:?}");
            }
        }
    }
    println!("bound / left out: {tight} at least");
    assert!(solids > 10, "{solids}");
    Ok(())
}

/// The same at every size, and the same bytes every time; what overflows is refused.
#[test]
fn sizes_do_not_matter() {
    let cage = crate::shapes::double_fan(5, 0.1).with_crease(0, 2, 1.5).unwrap();
    let surface = SubdivisionSurface::new(cage.clone()).unwrap();
    let (patches, left) = (surface.patches(1e-3).unwrap(), surface.left_out().unwrap());
    assert_eq!(patches, SubdivisionSurface::new(cage.clone()).unwrap().patches(1e-3).unwrap());
    assert!(left.count > 0 && left.area > 0.0 && left.volume > 0.0);
    for by in [1e-9, 1e9] {
        let other = SubdivisionSurface::new(scaled(&cage, by)).unwrap();
        let (scaled, own) = (other.patches(1e-3 * by).unwrap(), other.left_out().unwrap());
        assert_eq!((scaled.surfaces.len(), scaled.exact), (patches.surfaces.len(), patches.exact), "{by}");
        assert!((scaled.deviation / by / patches.deviation - 1.0).abs() < 1e-9, "{by}");
        assert!((own.area / (by * by) / left.area - 1.0).abs() < 1e-9, "{by}");
        assert!((own.volume / (by * by * by) / left.volume - 1.0).abs() < 1e-9, "{by}");
    }
    let huge = SubdivisionSurface::new(scaled(&cage, 5e307)).unwrap();
    assert!(huge.patches(1e300).is_err());
    let fineness = Fineness { chord: Chord::Absolute(1e305), angle: 10.0 };
    assert!(SubdivisionSurface::tessellate(&[&huge], &fineness).is_err());
    let bound = huge.left_out().unwrap();
    assert!(bound.area == f64::INFINITY && bound.volume == f64::INFINITY, "{bound:?}");
}

/// Cages that differ in nothing but the numbers of their vertices and faces have the same surface: what is kept for one place serves all.
#[test]
fn numbers_do_not_matter() {
    let mut tried = 0;
    for (name, cage) in cages() {
        let topology = cage.topology();
        let (n, m) = (topology.vertex_count(), topology.face_count());
        let moved = |v: usize| (v * 7 + 3) % n;
        let order = |f: usize| (f * 11 + 5) % m;
        if n % 7 == 0 || m % 11 == 0 {
            continue;
        }
        tried += 1;
        let mut points = vec![Point::origin(); n];
        (0..n).for_each(|v| points[moved(v)] = cage.points()[v]);
        let mut faces = vec![Vec::new(); m];
        for f in 0..m {
            faces[order(f)] = topology.face(f).iter().map(|&v| moved(v as usize)).collect::<Vec<_>>();
        }
        let mut other = Cage::new(points, &faces).unwrap().with_boundary(cage.boundary());
        for (e, [a, b]) in (0..topology.edge_count()).filter_map(|e| topology.edge(e).map(|ends| (e, ends))) {
            if cage.crease(e) > 0.0 {
                other = other.with_crease(moved(a as usize), moved(b as usize), cage.crease(e)).unwrap();
            }
        }
        for v in (0..n).filter(|&v| cage.corner(v) > 0.0) {
            other = other.with_corner(moved(v), cage.corner(v)).unwrap();
        }
        for f in (0..m).filter(|&f| cage.is_hole(f)) {
            other = other.with_hole(order(f)).unwrap();
        }
        let (one, two) =
            (SubdivisionSurface::new(cage.clone()).unwrap(), SubdivisionSurface::new(other).unwrap());
        for f in (0..m).filter(|&f| !cage.is_hole(f)) {
            let [a, b] = [one.face_of(f, 1).unwrap().unwrap(), two.face_of(order(f), 1).unwrap().unwrap()];
            for at in places(a, 6) {
                let Location::Face(_, u, v) = at else { continue };
                let [p, q] = [point(&one, Location::Face(a, u, v)), point(&two, Location::Face(b, u, v))];
                assert!((p - q).norm() < 1e-14, "{name}, {f}, {at}: {p} {q}");
            }
        }
    }
    assert!(tried > 10, "{tried}");
}
