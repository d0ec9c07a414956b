//! How far, and along which ways, places of faces have moved.

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;

/// Steps of a grid over each face's domain.
const STEPS: usize = 24;

/// A place of a face that moved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Path {
    pub(crate) face: usize,
    /// Its parameters.
    pub(crate) at: [f64; 2],
    pub(crate) from: Point,
    pub(crate) to: Point,
}

/// What the places of a grid of 25 × 25 on each face that moved have gone through which its loops leave: displacements are those of equal parameters.
pub(crate) fn paths(before: &Brep, after: &Brep) -> Vec<Path> {
    let mut all = Vec::new();
    for face in 0..after.face_count() {
        let (Some(old), Some(new)) = (before.surface(face), after.surface(face)) else { continue };
        if old == new {
            continue;
        }
        let Ok(part) = before.part(face) else { continue };
        let ((a, b), (c, d)) = (new.u().domain(), new.v().domain());
        for k in 0..(STEPS + 1) * (STEPS + 1) {
            let share = [k / (STEPS + 1), k % (STEPS + 1)].map(|k| k as f64 / STEPS as f64);
            let at = [a + (b - a) * share[0], c + (d - c) * share[1]];
            let there = part.wrapped(at);
            if !part.has(there) {
                continue;
            }
            if let (Ok(from), Ok(to)) = (old.point(there[0], there[1]), new.point(at[0], at[1])) {
                all.push(Path { face, at, from, to });
            }
        }
    }
    all
}
