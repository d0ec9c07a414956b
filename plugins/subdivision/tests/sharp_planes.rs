//! Tangent planes on creases, at corners, on boundaries and at ends of creases, against ten explicit levels of refinement.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::nalgebra::DMatrix;
use loftsman_kernel::shape::{Derivative, Location, Shape, Stencil};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{limit_stencils, sectors};
use loftsman_subdivision::{Cage, LimitFrame, SubdivisionSurface};

use crate::shapes::levels::explicit;
use crate::shapes::plain::Plain;
use crate::shapes::wild;

/// What lasts is sharp from here on.
const LASTING: f64 = 10.0;

/// A vertex after some levels: the ways to its neighbours, counterclockwise, those across its faces, and which edges are sharp.
struct Star {
    spokes: Vec<Vector>,
    across: Vec<Vector>,
    sharp: Vec<usize>,
    is_corner: bool,
}

impl Star {
    fn new(cage: &Cage) -> Self {
        let topology = cage.topology();
        let way = |v: u32| cage.points()[v as usize] - cage.points()[0];
        let edges: Vec<usize> = topology.vertex_edges(0).map(|e| e as usize).collect();
        let spoke = |&e: &usize| way(topology.edge(e).unwrap().into_iter().sum());
        let is_sharp = |&k: &usize| topology.is_boundary_edge(edges[k]) || cage.crease(edges[k]) >= LASTING;
        let sharp: Vec<usize> = (0..edges.len()).filter(is_sharp).collect();
        let faces: Vec<usize> = topology.vertex_faces(0).map(|f| f as usize).collect();
        let opposite = |f: &usize| {
            let face = topology.face(*f);
            assert_eq!(face.len(), 4);
            way(face[(face.iter().position(|&v| v == 0).unwrap() + 2) % 4])
        };
        let lone = topology.is_boundary_vertex(0)
            && faces.len() == 1
            && cage.boundary() == loftsman_subdivision::BoundaryRule::EdgeAndCorner;
        Self {
            is_corner: cage.corner(0) >= LASTING || sharp.len() > 2 || lone,
            spokes: edges.iter().map(spoke).collect(),
            across: faces.iter().map(opposite).collect(),
            sharp,
        }
    }
}

/// The eigenvalues of the wave `j` between two sharp edges with `k` faces between them.
fn wave(k: usize, j: usize) -> [f64; 2] {
    let cos = (std::f64::consts::PI * j as f64 / k as f64).cos();
    let root = ((1.0 + cos) * (9.0 + cos)).max(0.0).sqrt();
    [(5.0 + cos + root) / 16.0, (5.0 + cos - root) / 16.0]
}

/// Levels until nothing finite is sharp.
fn decay(cage: &Cage) -> usize {
    let edges = (0..cage.topology().edge_count()).map(|e| cage.crease(e));
    let all = edges.chain((0..cage.points().len()).map(|v| cage.corner(v)));
    all.filter(|s| *s < LASTING).fold(0.0, |m: f64, s| m.max(s.ceil())) as usize
}

/// Those of every kind; at random, open and sharp, some faces being holes.
fn cages() -> Vec<(String, Cage)> {
    let mut all = crate::shapes::all();
    for seed in 0..90 {
        let mut plain = wild::sharpened(wild::closed(seed), seed);
        if seed % 3 > 0 {
            plain = wild::opened(plain, seed);
        }
        let mut dice = wild::Dice::new(seed + 95_000);
        let cage = plain.cage().unwrap();
        let cage = cage.clone().with_hole(dice.below(plain.faces.len())).unwrap_or(cage);
        all.push((format!("wild {seed}"), cage));
    }
    all
}

fn frame(cage: &Cage, vertex: usize, sector: usize) -> LimitFrame {
    let rows = limit_stencils(cage, vertex, sector).unwrap();
    LimitFrame { point: Point::origin(), tangents: rows.tangents.map(|t| t.apply(cage.points())) }
}

/// The sine of the angle between two lines.
fn turned(a: Vector, b: Vector) -> f64 {
    a.normalize().cross(&b.normalize()).norm()
}

fn lifted<'a>(ways: impl Iterator<Item = &'a Vector>, normal: Vector) -> f64 {
    ways.map(|x| x.normalize().dot(&normal).abs()).fold(0.0, f64::max)
}

/// On a crease and on the boundary, of any number of faces on a side: the difference of the crease's two edges keeps its direction from level to level, and
/// is the one tangent. In the plane with the other come to lie the crease's edges, by a half each level, for a crease bends by a quarter where it
/// shrinks by a half; and what is between them by `μ/λ`, `λ` being the eigenvalue of the first wave between the creases and `μ` the largest of
/// what else there is: the second wave's, and a quarter.
#[test]
fn planes_beside_creases_and_boundaries() {
    let (mut creases, mut rims, mut odd) = (0, 0, 0);
    for (name, cage) in cages() {
        let start = decay(&cage);
        let step = cage.points().len().div_ceil(6);
        for v in (0..cage.points().len()).step_by(step) {
            let [five, ten] = [5, 10].map(|k| Star::new(&explicit(&cage, v, start + k)));
            if ten.is_corner || ten.sharp.len() != 2 {
                continue;
            }
            let (n, faces) = (ten.spokes.len(), ten.across.len());
            let count = sectors(&cage, v).unwrap();
            assert_eq!(count, 1 + usize::from(n == faces), "{name}, vertex {v}");
            for sector in 0..count {
                let context = format!("{name}, vertex {v}, sector {sector}");
                let (from, to) = (ten.sharp[sector], ten.sharp[1 - sector]);
                let k = (to + n - from) % n;
                let frame = frame(&cage, v, sector);
                let [along, aside] = frame.tangents;
                // Twelve digits of the edges are left after ten levels.
                let own = ten.spokes[from] - ten.spokes[to];
                assert!(turned(along, own) < 1e-9, "{context}: {along} {own}");
                assert!(along.dot(&own) > 0.0, "{context}");
                let Some(normal) = frame.normal() else { continue };
                let inside = |star: &Star| -> Vec<Vector> {
                    let spokes = (1..k).map(|i| star.spokes[(from + i) % n]);
                    spokes.chain((0..k).map(|i| star.across[(from + i) % faces])).collect()
                };
                let ends = |star: &Star| lifted([from, to].map(|i| &star.spokes[i]).into_iter(), normal);
                let (before, after) = (ends(&five), ends(&ten));
                assert!(after <= 1.1 * 0.5_f64.powi(5) * before + 1e-9, "{context}: {before:e} {after:e}");
                // The second tangent points to where the faces are.
                let left = aside - along * (aside.dot(&along) / along.norm_squared());
                let sum: Vector = inside(&ten).into_iter().sum();
                let (before, after) =
                    (lifted(inside(&five).iter(), normal), lifted(inside(&ten).iter(), normal));
                if k == 1 {
                    // All eigenvalues but the crease's own are a quarter, in one chain: the way across is `(a L + b) / 4^L` with `a` in the plane, and
                    // its slope to the plane goes to nothing as `1/L`.
                    let steepness = |levels: usize| {
                        let sine =
                            lifted(inside(&Star::new(&explicit(&cage, v, start + levels))).iter(), normal);
                        (1.0 / (sine * sine) - 1.0).sqrt()
                    };
                    let [a, b, c] = [6, 9, 12].map(steepness);
                    let flat = a > 1e6;
                    assert!(flat || b > a && c - b > 0.9 * (b - a), "{context}: {a} {b} {c}");
                } else {
                    assert!(sum.dot(&left) > 0.0, "{context}");
                    let [first, small] = wave(k, 1);
                    let ratio = wave(k, 2)[0].max(small).max(0.25) / first;
                    // What comes behind that may have hidden half of it at five levels.
                    let allowed = 2.0 * ratio.powi(5) * before + 1e-9;
                    assert!(after <= allowed, "{context}, {k} faces: {before:e} {after:e}, rate {ratio}");
                    assert!(after <= 40.0 * ratio.powi(10), "{context}, {k} faces: {after:e}, rate {ratio}");
                }
                creases += usize::from(n == faces);
                rims += usize::from(n != faces);
                odd += usize::from(k != 2);
            }
        }
    }
    println!("{creases} beside creases, {rims} on boundaries, {odd} of other than two faces");
    assert!(creases > 40 && rims > 300 && odd > 100, "{creases} {rims} {odd}");
}

/// At a corner sharp edges keep their directions from level to level: those are the tangents of the faces beside them; and between two sharp edges the corner
/// across comes into their plane by a half each level.
#[test]
fn tangents_at_corners() {
    let (mut along, mut planes) = (0, 0);
    for (name, cage) in cages() {
        let start = decay(&cage);
        let step = cage.points().len().div_ceil(6);
        for v in (0..cage.points().len()).step_by(step) {
            let [five, ten] = [5, 10].map(|k| Star::new(&explicit(&cage, v, start + k)));
            if !ten.is_corner {
                continue;
            }
            let (n, faces) = (ten.spokes.len(), ten.across.len());
            assert_eq!(sectors(&cage, v).unwrap(), faces, "{name}, vertex {v}");
            for face in 0..faces {
                let context = format!("{name}, vertex {v}, face {face}");
                let frame = frame(&cage, v, face);
                let both = [face, (face + 1) % n];
                for (tangent, spoke) in frame.tangents.into_iter().zip(both) {
                    if ten.sharp.contains(&spoke) {
                        let own = ten.spokes[spoke];
                        assert!(turned(tangent, own) < 1e-9 && tangent.dot(&own) > 0.0, "{context}");
                        along += 1;
                    }
                }
                if let Some(normal) = frame.normal().filter(|_| both.iter().all(|k| ten.sharp.contains(k))) {
                    let [before, after] =
                        [&five, &ten].map(|star| lifted(std::iter::once(&star.across[face]), normal));
                    assert!(
                        after <= 1.3 * 0.5_f64.powi(5) * before + 1e-9,
                        "{context}: {before:e} {after:e}"
                    );
                    planes += 1;
                }
            }
        }
    }
    println!("{along} along sharp edges, {planes} planes between two");
    assert!(along > 200 && planes > 60, "{along} {planes}");
}

/// The sizes of the eigenvalues of one refinement of the faces round a vertex, quads all, the largest first, by hand.
fn spectrum(cage: &Cage) -> Vec<f64> {
    let topology = cage.topology();
    let faces: Vec<Vec<usize>> = topology
        .vertex_faces(0)
        .map(|f| topology.face(f as usize).iter().map(|&v| v as usize).collect())
        .collect();
    let mut kept: Vec<usize> = faces.iter().flatten().copied().collect();
    kept.sort_unstable();
    kept.dedup();
    let at = |v: &usize| kept.binary_search(v).unwrap();
    let all = Plain::of(cage);
    let mut ring =
        Plain { faces: faces.iter().map(|f| f.iter().map(at).collect()).collect(), ..Plain::default() };
    for (edge, sharpness) in &all.creases {
        if let [Ok(a), Ok(b)] = edge.map(|v| kept.binary_search(&v)) {
            ring.creases.insert([a.min(b), a.max(b)], *sharpness);
        }
    }
    let n = kept.len();
    let mut matrix = DMatrix::zeros(n, n);
    for k in 0..n {
        ring.points = vec![Vector::zeros(); n];
        ring.points[k].x = 1.0;
        let fine = ring.refined();
        // In the place of each vertex: the vertex, the middles of its edges, those of its faces; the refined faces have them in order.
        matrix[(0, k)] = fine.points[0].x;
        let spot = |of: usize, corner: usize| {
            let first: usize = ring.faces[..of].iter().map(Vec::len).sum();
            fine.faces[first + corner].clone()
        };
        for (f, face) in ring.faces.iter().enumerate() {
            let own = face.iter().position(|&v| v == 0).unwrap();
            let small = spot(f, own);
            for (step, target) in small.iter().enumerate() {
                matrix[(face[(own + step) % 4], k)] = fine.points[*target].x;
            }
        }
    }
    let mut sizes: Vec<f64> = matrix.complex_eigenvalues().iter().map(|x| x.norm()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    sizes
}

/// At the end of a crease: all edges come into the plane, as the third eigenvalue below one goes to nothing beside the second.
#[test]
fn planes_at_ends_of_creases() {
    let mut count = 0;
    for (name, cage) in cages() {
        let start = decay(&cage);
        let step = cage.points().len().div_ceil(6);
        for v in (0..cage.points().len()).step_by(step) {
            let crop = explicit(&cage, v, start + 10);
            let ten = Star::new(&crop);
            if ten.is_corner || ten.sharp.len() != 1 {
                continue;
            }
            let context = format!("{name}, vertex {v}");
            let Some(normal) = frame(&cage, v, 0).normal() else { continue };
            let sizes = spectrum(&crop);
            assert!((sizes[0] - 1.0).abs() < 1e-9, "{context}: {sizes:?}");
            let ratio = sizes[3] / sizes[2];
            // Of seven edges and more the fourth is so near to the third (0.462 and 0.475) that at ten levels one still hides the other: as many levels as leave
            // eight digits of the smallest edges, and half of them.
            let last = ((1e-8_f64.ln() / sizes[2].ln()) as usize).saturating_sub(start).clamp(10, 40);
            let after = Star::new(&explicit(&cage, v, start + last));
            let before = Star::new(&explicit(&cage, v, start + last / 2));
            let all = |star: &Star| lifted(star.spokes.iter().chain(&star.across), normal);
            let (before, after) = (all(&before), all(&after));
            // A plane that is another keeps its angle.
            let allowed = 4.0 * ratio.powi((last - last / 2) as i32) * before + 1e-6;
            assert!(after <= allowed, "{context}, {last}: {before:e} {after:e}, {sizes:?}");
            count += 1;
        }
    }
    println!("{count} ends of creases");
    assert!(count > 20, "{count}");
}

/// A vertex with several tangent planes has no tangents as such, the places that the refusal names have each those of a side, and all sides are among them
/// (of up to four); any other vertex has its own.
#[test]
fn whose_tangents_are_meant_is_to_be_said() {
    let (mut refused, mut own) = (0, 0);
    for (name, cage) in cages() {
        let Ok(surface) = SubdivisionSurface::new(cage.clone()) else { continue };
        let row = |at: Location, u: usize, v: usize| surface.stencil(at, Derivative { u, v });
        let applied =
            |stencil: &Stencil| -> Vector { stencil.iter().map(|(k, c)| cage.points()[k].coords * c).sum() };
        for vertex in 0..cage.points().len() {
            let at = Location::Vertex(vertex as u32);
            if row(at, 0, 0).is_err() {
                continue;
            }
            let sides = sectors(&cage, vertex).unwrap();
            if sides == 1 {
                assert!(row(at, 1, 0).is_ok() && row(at, 0, 1).is_ok(), "{name} {vertex}");
                own += 1;
                continue;
            }
            refused += 1;
            let said = row(at, 1, 0).unwrap_err().to_string();
            assert!(said.contains(&format!("vertex {vertex} has tangents")), "{said}");
            let normal = |[a, b]: [&Stencil; 2]| applied(a).cross(&applied(b)).try_normalize(1e-12);
            let of_sides = (0..sides).map(|side| {
                let limit = limit_stencils(&cage, vertex, side).unwrap();
                normal([&limit.tangents[0], &limit.tangents[1]])
            });
            let of_sides: Vec<Option<Vector>> = of_sides.collect();
            let places: Vec<&str> = said.split("{ face = ").skip(1).collect();
            assert!(!places.is_empty() && places.len() <= 4, "{said}");
            let mut met = vec![false; sides];
            for place in &places {
                let face: usize = place.split(',').next().unwrap().parse().unwrap();
                let uv = place.split("uv = ").nth(1).unwrap();
                let (u, v) = (&uv[1..2] == "1", &uv[4..5] == "1");
                let at = Location::Face(face as u32, f64::from(u8::from(u)), f64::from(u8::from(v)));
                let point = applied(&row(at, 0, 0).unwrap());
                let limit = applied(&row(Location::Vertex(vertex as u32), 0, 0).unwrap());
                assert!((point - limit).norm() < 1e-10, "{name} {vertex} {place}: {point} {limit}");
                let (a, b) = (row(at, 1, 0).unwrap(), row(at, 0, 1).unwrap());
                let Some(found) = normal([&a, &b]) else { continue };
                let same = |n: &Option<Vector>| n.is_some_and(|n| n.cross(&found).norm() < 1e-8);
                assert!(of_sides.iter().any(same), "{name} {vertex} {place}: {found} {of_sides:?}");
                of_sides.iter().zip(&mut met).for_each(|(n, met)| *met |= same(n));
            }
            // Where no hole has a side of its own.
            if places.len() < 4 && places.len() == cage.topology().vertex_faces(vertex).count() {
                assert!(
                    of_sides.iter().zip(&met).all(|(n, met)| n.is_none() || *met),
                    "{name} {vertex}: {said}"
                );
            }
        }
    }
    assert!(refused > 100 && own > 1000, "{refused} {own}");
}
