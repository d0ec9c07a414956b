//! Faces of files of other programs moved: what met before goes on meeting.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may stop at what should not be")]

use loftsman_kernel::Vector;
use loftsman_kernel::brep::{Brep, Moving};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_step::Step;

pub(super) fn breps() -> Vec<(String, Brep)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/step");
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    let mut all = Vec::new();
    for path in names {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.to_lowercase().ends_with(".stp") && !name.to_lowercase().ends_with(".step") {
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let (scene, _) = Step.read(&Memory::new(name.as_str(), bytes), &ReadOptions::default()).unwrap();
        let definitions = scene.definitions().iter().flat_map(|d| d.objects());
        for object in scene.objects().iter().chain(definitions) {
            if let Geometry::Brep(brep) = object.geometry() {
                all.push((format!("{name}:{}", object.name()), brep.clone()));
            }
        }
    }
    all
}

/// A place on a face well inside its loops, found without what edits know: of a grid, the one that is furthest from the face's edges.
fn inside(brep: &Brep, face: usize) -> Option<[f64; 2]> {
    let curves = brep.parameter_curves(face).ok()?;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut rim = Vec::new();
    let surface = brep.surface(face)?;
    for (one, projected) in brep.loops(face).iter().flatten().zip(curves.iter().flatten()) {
        let (a, b) = projected.curve.curve().bounds();
        for k in 0..2 {
            low[k] = low[k].min(a[k]);
            high[k] = high[k].max(b[k]);
        }
        let edge = brep.edge(one.edge)?;
        let (from, to) = edge.range;
        rim.extend((0..=32).map(|k| edge.curve.point(from + (to - from) * f64::from(k) / 32.0).unwrap()));
    }
    if rim.is_empty() {
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        return Some([0.4 * a + 0.6 * b, 0.5 * (c + d)]);
    }
    let mut best: Option<(f64, [f64; 2])> = None;
    for i in 1..8 {
        for j in 1..8 {
            let at = [
                low[0] + (high[0] - low[0]) * f64::from(i) / 8.0,
                low[1] + (high[1] - low[1]) * f64::from(j) / 8.0,
            ];
            let Ok(point) = surface.point(at[0], at[1]) else { continue };
            let away = rim.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
            if best.is_some_and(|(least, _)| away <= least) {
                continue;
            }
            let closest = brep.closest(point).unwrap();
            if closest.face == face && closest.distance <= 1e-9 * (away + 1.0) {
                best = Some((away, at));
            }
        }
    }
    best.map(|(_, at)| at)
}

/// What came of the edits of some faces of each Brep.
#[derive(Debug, Default)]
struct Outcome {
    done: usize,
    refused: Vec<String>,
    /// The largest distance between faces of an edge beyond what its tolerance says, and the largest that it says, relative to the size of
    /// the face that was moved.
    beyond: f64,
    said: f64,
}

/// Some faces of each Brep pulled out of shape, with so many rings of neighbours.
fn pulled(rings: usize) -> Outcome {
    let mut all = Outcome::default();
    for (name, brep) in breps() {
        let count = brep.face_count();
        // What files themselves are off.
        let before = brep.openings().unwrap();
        for face in (0..count).step_by(count.div_ceil(3).max(1)) {
            let Some([u, v]) = inside(&brep, face) else { continue };
            let at = Location::Face(face as u32, u, v);
            let surface = brep.surface(face).unwrap();
            let size = surface.points().iter().map(|p| (p - surface.points()[0]).norm()).fold(0.0, f64::max);
            let by = Vector::new(0.01, 0.02, 0.015) * size;
            let free = brep.clone().moving(Moving::new().neighbours(rings));
            let edited = match Edit::new(&free).ask(position(at).by(by)).solve() {
                Ok(edited) => edited,
                Err(error) => {
                    all.refused.push(format!("{name} {face}: {error}"));
                    continue;
                }
            };
            all.done += 1;
            let after = edited.shape();
            let way = after.value(at, Derivative::POSITION).unwrap()
                - brep.value(at, Derivative::POSITION).unwrap();
            assert!((way - by).norm() <= 1e-11 * size, "{name} {face}: {way} {by}");
            for edge in 0..brep.edge_count() {
                let (gap, stays) = (gap(after, edge), after.edge(edge) == brep.edge(edge));
                let tolerance = after.edge(edge).unwrap().tolerance;
                // A seam, and a rim of an open shell, belong to the face that moves alone.
                if rings == 0 && brep.uses(edge).iter().any(|one| one.face != face) {
                    assert!(stays, "{name} {face}: edge {edge} has moved");
                }
                if let Some(gap) = gap {
                    let allowed = tolerance.max(before[edge].gap.max(before[edge].off));
                    let beyond = (gap - 1.02 * allowed) / size;
                    assert!(
                        beyond < 1e-10,
                        "{name} {face}: edge {edge} is open by {gap:e}, allowed {allowed:e}"
                    );
                    all.beyond = all.beyond.max(beyond);
                    if !stays {
                        all.said = all.said.max((tolerance - brep.edge(edge).unwrap().tolerance) / size);
                    }
                }
            }
        }
    }
    all
}

/// How far the faces of an edge are apart: points of one along its parameter curve, from the surface of the other by a search there.
/// `None` where a face has no parameter curve of its own, so that it was not touched.
pub(super) fn gap(brep: &Brep, edge: usize) -> Option<f64> {
    let uses = brep.uses(edge);
    let [one, other] = uses else { return None };
    let curve = brep.loops(one.face)[one.chain][one.number].parameters.as_ref()?;
    brep.loops(other.face)[other.chain][other.number].parameters.as_ref()?;
    let (from, to) = curve.range();
    let (own, beside) = (brep.surface(one.face)?, brep.surface(other.face)?);
    let mut start: Option<(f64, f64)> = None;
    let mut worst = 0.0_f64;
    for k in 0..=60 {
        let t = if k == 60 { to } else { from + (to - from) * f64::from(k) / 60.0 };
        let at = curve.curve().point(t).ok()?;
        let into = |t: f64, (a, b): (f64, f64)| t.clamp(a, b);
        let point = own.point(into(at.x, own.u().domain()), into(at.y, own.v().domain())).ok()?;
        let mut found = match start {
            Some(start) => beside.foot(point, start).map(|foot| (foot.at, foot.distance)).ok()?,
            None => ((0.0, 0.0), f64::INFINITY),
        };
        if found.1 > 1e-9 {
            let closest = beside.closest(point).ok()?;
            if closest.distance < found.1 {
                found = (closest.at, closest.distance);
            }
        }
        start = Some(found.0);
        worst = worst.max(found.1);
    }
    Some(worst)
}

#[test]
fn a_face_moves_and_all_edges_stay_to_the_bit() {
    let all = pulled(0);
    println!("{all:?}");
    assert!(all.done >= 60 && all.refused.is_empty(), "{all:?}");
}

#[test]
fn faces_move_with_their_neighbours_within_what_is_told() {
    let all = pulled(1);
    println!("{all:?}");
    assert!(all.done >= 50 && all.refused.len() <= 12, "{all:?}");
    assert!(all.refused.iter().all(|refused| refused.contains("cannot all hold")), "{all:?}");
    assert!(all.beyond < 1e-10 && all.said < 1e-5, "{all:?}");
}
