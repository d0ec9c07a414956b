//! Places on edges, moved while the faces beside them may go along.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may stop at what should not be")]

use loftsman_kernel::Vector;
use loftsman_kernel::brep::Moving;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Derivative, Location, Shape};

use super::editing::{breps, gap};

/// What came of the edits of a file's edges.
#[derive(Debug, Default)]
struct Outcome {
    done: usize,
    refused: Vec<String>,
    /// Largest of all edits: how much further edges are open than they were, relative to the face that was asked about; the same beyond what
    /// tolerances say; condition; how far anything moved, as a part of the way that was asked.
    open: f64,
    beyond: f64,
    condition: f64,
    furthest: f64,
    pieces: usize,
}

/// Edges of each Brep of a file between two faces moved at a place of their own, as each of these faces has it: one of so many places.
fn moved(file: &str, each: usize) -> Outcome {
    let (mut all, mut count) = (Outcome::default(), 0);
    for (name, brep) in breps().into_iter().filter(|(name, _)| name.starts_with(file)) {
        let before = brep.openings().unwrap();
        let free = brep.clone().moving(Moving::new().neighbours(1));
        for edge in 0..brep.edge_count() {
            let [one, other] = brep.uses(edge) else { continue };
            if one.face == other.face {
                continue;
            }
            for place in [one, other] {
                count += 1;
                if count % each != 0 {
                    continue;
                }
                let curves = brep.parameter_curves(place.face).unwrap();
                let curve = &curves[place.chain][place.number].curve;
                let (from, to) = curve.range();
                let at = curve.curve().point(from + (to - from) * 0.45).unwrap();
                let surface = brep.surface(place.face).unwrap();
                let into = |t: f64, (a, b): (f64, f64)| t.clamp(a, b);
                let at = if surface.u().is_periodic() || surface.v().is_periodic() {
                    Location::Face(place.face as u32, at.x, at.y)
                } else {
                    let (u, v) = (into(at.x, surface.u().domain()), into(at.y, surface.v().domain()));
                    Location::Face(place.face as u32, u, v)
                };
                let rim = brep.loops(place.face).iter().flatten().map(|one| brep.edge(one.edge).unwrap());
                let rim: Vec<_> =
                    rim.map(|e| e.curve.point(e.range.0 + 0.3 * (e.range.1 - e.range.0)).unwrap()).collect();
                let size = rim.iter().map(|p| (p - rim[0]).norm()).fold(0.0, f64::max);
                let size = if size > 0.0 {
                    size
                } else {
                    surface.points().iter().map(|p| (p - surface.points()[0]).norm()).fold(0.0, f64::max)
                };
                let by = Vector::new(0.01, 0.02, 0.015) * size;
                let started = std::time::Instant::now();
                let edited = match Edit::new(&free).ask(position(at).by(by)).solve() {
                    Ok(edited) => edited,
                    Err(error) => {
                        println!("{name} edge {edge} face {}: REFUSED {error}", place.face);
                        all.refused.push(format!("{name}: edge {edge} of face {}: {error}", place.face));
                        continue;
                    }
                };
                all.done += 1;
                let after = edited.shape();
                let way = after.value(at, Derivative::POSITION).unwrap()
                    - brep.value(at, Derivative::POSITION).unwrap();
                assert!((way - by).norm() <= 1e-10 * size, "{name} {edge} {}: {way} {by}", place.face);
                let mut furthest = 0.0_f64;
                for face in 0..brep.face_count() {
                    let (Some(a), Some(b)) = (brep.surface(face), after.surface(face)) else { continue };
                    if a == b {
                        continue;
                    }
                    for i in 0..=10 {
                        for j in 0..=10 {
                            let ((c, d), (e, f)) = (b.u().domain(), b.v().domain());
                            let (u, v) =
                                (c + (d - c) * f64::from(i) / 10.0, e + (f - e) * f64::from(j) / 10.0);
                            if let (Ok(p), Ok(q)) = (a.point(u, v), b.point(u, v)) {
                                furthest = furthest.max((p - q).norm() / by.norm());
                            }
                        }
                    }
                }
                all.furthest = all.furthest.max(furthest);
                let (mut open, mut wide) = (0.0_f64, 0);
                for own in 0..brep.edge_count() {
                    let Some(gap) = gap(after, own) else { continue };
                    let was = before[own].gap.max(before[own].off);
                    if (gap - was) / size > open {
                        (open, wide) = ((gap - was) / size, own);
                    }
                    let tolerance = after.edge(own).unwrap().tolerance.max(was);
                    all.beyond = all.beyond.max((gap - 1.02 * tolerance) / size);
                }
                let report = edited.report();
                all.open = all.open.max(open);
                all.condition = all.condition.max(report.condition);
                all.pieces = all.pieces.max(after.control_vertices().len());
                println!(
                    "{name} edge {edge} face {}: open {open:.1e} ({wide}) cond {:.1e} far {furthest:.2} rank {}/{} net {} in {:.2}s",
                    place.face,
                    report.condition,
                    report.rank,
                    report.equations,
                    after.control_vertices().len(),
                    started.elapsed().as_secs_f64()
                );
            }
        }
    }
    println!(
        "{file}: done {} refused {} open {:.1e} beyond {:.1e} cond {:.1e} far {:.2} net {}",
        all.done,
        all.refused.len(),
        all.open,
        all.beyond,
        all.condition,
        all.furthest,
        all.pieces
    );
    all
}

#[test]
fn places_on_edges_of_a_sliced_cylinder() {
    let all = moved("sliced_cylinder", 1);
    // Two edges are lines of parameters of neither face: they stay, as each of their faces has them.
    let stay = all
        .refused
        .iter()
        .filter(|refused| refused.contains("as it is a line of constant parameters of none"))
        .count();
    assert!(all.done >= 10 && all.refused.len() <= stay + 4 && stay == 4, "{all:?}");
    assert!(all.open < 5e-6 && all.beyond < 1e-10 && all.condition < 1e10 && all.furthest < 2.0, "{all:?}");
}

#[test]
fn places_on_edges_of_a_part() {
    let all = moved("NIST_MBE_PMI_11", 1);
    assert!(all.done == 52 && all.refused.is_empty(), "{all:?}");
    assert!(all.open < 3e-4 && all.beyond < 1e-10 && all.condition < 1e10 && all.furthest < 3.0, "{all:?}");
}

#[test]
fn places_on_edges_of_a_housing() {
    let all = moved("MAINBODY_FRONT", 3);
    assert!(all.done >= 27 && all.refused.len() <= 2, "{all:?}");
    assert!(all.open < 2e-5 && all.beyond < 1e-10 && all.furthest < 4.0, "{all:?}");
}
