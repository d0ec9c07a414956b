//! Euler's characteristic, by counting, with holes, boundaries, tunnels and several pieces.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use std::collections::{BTreeMap, BTreeSet};

use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::{Cage, Polygon, Scheme, doo_sabin};

use crate::shapes::plain::{Plain, ends};
use crate::shapes::wild::{self, Dice};
use crate::shapes::{noise, rowed};

/// What can be counted of some faces: vertices less edges and faces, pieces that hang together by edges, loops of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Count {
    euler: i64,
    pieces: usize,
    loops: usize,
}

/// The number of sets of things that hang together.
fn pieces(links: &[[usize; 2]], all: &BTreeSet<usize>) -> usize {
    let mut beside: BTreeMap<usize, Vec<usize>> = all.iter().map(|&v| (v, Vec::new())).collect();
    for &[a, b] in links {
        beside.get_mut(&a).unwrap().push(b);
        beside.get_mut(&b).unwrap().push(a);
    }
    let (mut seen, mut count) = (BTreeSet::new(), 0);
    for &first in all {
        let mut way = vec![first];
        count += usize::from(!seen.contains(&first));
        while let Some(v) = way.pop() {
            if seen.insert(v) {
                way.extend(&beside[&v]);
            }
        }
    }
    count
}

fn count(faces: &[Vec<usize>]) -> Count {
    let mut edges: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for face in faces {
        for k in 0..face.len() {
            *edges.entry(ends(face[k], face[(k + 1) % face.len()])).or_default() += 1;
        }
    }
    let vertices: BTreeSet<usize> = faces.iter().flatten().copied().collect();
    let all: Vec<[usize; 2]> = edges.keys().copied().collect();
    let rim: Vec<[usize; 2]> = edges.iter().filter(|(_, n)| **n == 1).map(|(e, _)| *e).collect();
    let on_rim: BTreeSet<usize> = rim.iter().flatten().copied().collect();
    Count {
        euler: vertices.len() as i64 - edges.len() as i64 + faces.len() as i64,
        pieces: pieces(&all, &vertices),
        loops: pieces(&rim, &on_rim),
    }
}

/// The faces of a cage, or those that are no holes.
fn faces(cage: &Cage, shown: bool) -> Vec<Vec<usize>> {
    let topology = cage.topology();
    (0..topology.face_count())
        .filter(|&f| !(shown && cage.is_hole(f)))
        .map(|f| topology.face(f).iter().map(|&v| v as usize).collect())
        .collect()
}

/// The outside of unit cubes, which no two touch along an edge or at a corner alone.
fn of_cubes(cubes: &BTreeSet<[i64; 3]>) -> Plain {
    let mut plain = Plain::default();
    let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    for cube in cubes {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = *cube;
                beyond[axis] += 2 * side - 1;
                if cubes.contains(&beyond) {
                    continue;
                }
                let corner = |a: i64, b: i64| {
                    let mut at = *cube;
                    at[axis] += side;
                    at[(axis + 1) % 3] += a;
                    at[(axis + 2) % 3] += b;
                    at
                };
                let mut corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side == 0 {
                    corners.reverse();
                }
                let face = corners.map(|at| {
                    *known.entry(at).or_insert_with(|| {
                        plain.points.push(at.map(|x| x as f64).into());
                        plain.points.len() - 1
                    })
                });
                plain.faces.push(face.to_vec());
            }
        }
    }
    plain
}

/// A slab with so many tunnels through it: a sphere with as many handles.
fn tunnels(genus: i64) -> Plain {
    let slab = (0..2 * genus + 1).flat_map(|i| (0..3).map(move |j| [i, j, 0]));
    of_cubes(&slab.filter(|[i, j, _]| !(i % 2 == 1 && *j == 1)).collect())
}

/// Side by side.
fn together(parts: &[Plain]) -> Plain {
    let mut all = Plain::default();
    for part in parts {
        let first = all.points.len();
        all.points.extend(&part.points);
        all.faces.extend(part.faces.iter().map(|f| f.iter().map(|v| v + first).collect::<Vec<_>>()));
        all.creases.extend(part.creases.iter().map(|([a, b], s)| ([a + first, b + first], *s)));
        all.corners.extend(part.corners.iter().map(|(v, s)| (v + first, *s)));
    }
    all
}

fn with_holes(plain: &Plain, count: usize, dice: &mut Dice) -> Cage {
    let mut cage = plain.cage().unwrap();
    for _ in 0..count {
        let face = dice.below(plain.faces.len());
        cage = cage.clone().with_hole(face).unwrap_or(cage);
    }
    cage
}

/// Every kind, with what is known of some of them.
fn cages() -> Vec<(String, Cage, Option<Count>)> {
    let mut all: Vec<(String, Cage, Option<Count>)> =
        crate::shapes::all().into_iter().step_by(3).map(|(name, cage)| (name, cage, None)).collect();
    for genus in 0..4 {
        let known = Count { euler: 2 - 2 * genus, pieces: 1, loops: 0 };
        all.push((format!("{genus} tunnels"), tunnels(genus).cage().unwrap(), Some(known)));
    }
    let torus = crate::shapes::grid(5, 6, [true, true], 0.2);
    all.push(("torus".to_owned(), torus.clone(), Some(Count { euler: 0, pieces: 1, loops: 0 })));
    let tube = crate::shapes::grid(5, 6, [true, false], 0.2);
    all.push(("tube".to_owned(), tube.clone(), Some(Count { euler: 0, pieces: 1, loops: 2 })));
    let parts = [Plain::of(&torus), Plain::of(&tube), tunnels(2), Plain::of(&crate::shapes::cube())];
    let known = Count { euler: -2 + 2, pieces: 4, loops: 2 };
    all.push(("four pieces".to_owned(), together(&parts).cage().unwrap(), Some(known)));
    for seed in 0..120 {
        let mut dice = Dice::new(seed + 90_000);
        let closed = wild::closed(seed);
        let plain = match seed % 4 {
            0 => closed,
            1 => wild::opened(wild::sharpened(closed, seed), seed),
            2 => together(&[closed, wild::opened(wild::closed(seed + 1), seed), tunnels(1)]),
            _ => together(&[wild::sharpened(closed, seed), Plain::of(&tube)]),
        };
        let holes = dice.below(4);
        all.push((format!("wild {seed}"), with_holes(&plain, holes, &mut dice), None));
    }
    all
}

/// The cage with an interval for each row of faces, for either scheme, where it bears them.
fn uneven(cage: &Cage) -> Cage {
    let by_rows = rowed(cage, |row| 1.4_f64.powf(noise(row)));
    let topology = cage.topology();
    (0..topology.edge_count()).fold(by_rows, |cage, e| {
        let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
        cage.with_interval(a, b, 1.5_f64.powf(noise(e as u64))).unwrap()
    })
}

/// Of all faces both schemes keep it, with the pieces and the loops of the boundary; of those that are no holes Catmull and Clark's, that divides each face
/// by itself.
#[test]
fn refinement_keeps_it() {
    let (mut with_holes, mut open, mut dual) = (0, 0, 0);
    for (name, cage, known) in cages() {
        let (whole, shown) = (count(&faces(&cage, false)), count(&faces(&cage, true)));
        if let Some(known) = known {
            assert_eq!(whole, known, "{name}");
        }
        with_holes += usize::from(whole != shown);
        open += usize::from(whole.loops > 0);
        for (kind, start) in [("", cage.clone()), (" by intervals", uneven(&cage))] {
            let mut fine = start.clone();
            for level in 1..=3 {
                fine = refine(&fine).unwrap();
                let context = format!("{name}{kind}, level {level}");
                assert_eq!(count(&faces(&fine, false)), whole, "{context}");
                assert_eq!(count(&faces(&fine, true)).euler, shown.euler, "{context}, shown");
                let mesh = fine.to_mesh().unwrap();
                let drawn: Vec<Vec<usize>> =
                    mesh.faces().map(|f| f.iter().map(|&v| v as usize).collect()).collect();
                assert_eq!(count(&drawn).euler, shown.euler, "{context}, as a mesh");
            }
            // A vertex of two faces is between two edges only, whose faces meet along one edge of the next mesh.
            let mut fine = start;
            for level in 1..=3 {
                let Ok(next) = doo_sabin::refine(&fine) else {
                    assert!(level == 1, "{name}: level {level} can be refined and is not");
                    break;
                };
                fine = next;
                let context = format!("{name}{kind}, Doo-Sabin, level {level}");
                let found = count(&faces(&fine, false));
                assert_eq!((found.euler, found.loops), (whole.euler, whole.loops), "{context}");
                assert_eq!(found.pieces, whole.pieces, "{context}");
                dual += 1;
            }
        }
    }
    assert!(with_holes > 40 && open > 60 && dual > 500, "{with_holes} {open} {dual}");
}

/// Of Doo and Sabin's scheme a hole's own face is a hole, which each time touches no other and no boundary: one less for each of those inside.
#[test]
fn holes_of_doo_and_sabin_are_apart() {
    let mut seen = 0;
    for (name, cage, _) in cages() {
        let holes = (0..cage.topology().face_count()).filter(|&f| cage.is_hole(f)).count();
        let topology = cage.topology();
        let is_inside = (0..topology.face_count())
            .filter(|&f| cage.is_hole(f))
            .all(|f| topology.face_edges(f).iter().all(|&e| !topology.is_boundary_edge(e as usize)));
        if holes == 0 || !is_inside {
            continue;
        }
        // One with a vertex on the boundary opens the boundary's loop there.
        let is_apart = (0..topology.face_count())
            .filter(|&f| cage.is_hole(f))
            .all(|f| topology.face(f).iter().all(|&v| !topology.is_boundary_vertex(v as usize)));
        let whole = count(&faces(&cage, false));
        let mut fine = cage;
        for level in 1..=3 {
            fine = doo_sabin::refine(&fine).unwrap();
            let found = count(&faces(&fine, true));
            assert_eq!(found.euler, whole.euler - holes as i64, "{name}, level {level}");
            assert!(!is_apart || found.loops == whole.loops + holes, "{name}, level {level}: {found:?}");
        }
        seen += 1;
    }
    assert!(seen > 30, "{seen}");
}

/// The elevated cage of Doo and Sabin's scheme, too, is the same surface.
#[test]
fn elevation_keeps_it() {
    let mut seen = 0;
    for (name, cage, _) in cages() {
        let whole = count(&faces(&cage, false));
        let Ok(fine) = doo_sabin::elevated(&cage) else { continue };
        assert_eq!(count(&faces(&fine, false)), whole, "{name}");
        seen += 1;
    }
    assert!(seen > 100, "{seen}");
}

/// Of polygons it is 0 where they close and 1 where they do not: as many vertices as edges, and one more.
#[test]
fn polygons_keep_it() {
    for scheme in [Scheme::Chaikin, Scheme::Cubic] {
        for closed in [false, true] {
            for n in 4..9 {
                let points = (0..n).map(|k| [k as f64, noise(k), 0.0].into()).collect();
                let mut polygon = Polygon::new(scheme, points, closed).unwrap();
                for level in 1..=4 {
                    let before = polygon.points().len();
                    polygon = polygon.refine();
                    let now = polygon.points().len();
                    // Each span has a knot in its middle, and one more vertex for it: all vertices' of a closed one, an open one's but as many as
                    // the degree.
                    let spans = if closed { before } else { before - scheme.degree() };
                    let wanted = before + spans;
                    assert_eq!(polygon.is_closed(), closed);
                    assert_eq!(now, wanted, "{scheme:?}, {closed}, {n}, level {level}");
                }
            }
        }
    }
}
