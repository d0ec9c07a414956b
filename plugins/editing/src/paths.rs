//! How far, and along which ways, places of faces have moved.

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::spline::Space;

/// Places in each direction of a face's domain: so many at least, more where it has more spans, and at most so many.
const LEAST: usize = 24;
const MOST: usize = 96;

/// A place of a face that moved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Path {
    pub(crate) face: usize,
    /// Its parameters.
    pub(crate) at: [f64; 2],
    pub(crate) from: Point,
    pub(crate) to: Point,
}

/// What places have gone through that are on faces that moved, inside their loops: those that were asked about, by face and parameters, and a grid on each face
/// of the ends of its spans (where an edit has given it knots it has most to say) and places between them, 25 × 25 at least. Displacements are those of equal
/// parameters.
pub(crate) fn paths(before: &Brep, after: &Brep, asked: &[(u32, [f64; 2])]) -> Vec<Path> {
    let mut all = Vec::new();
    for face in 0..after.face_count() {
        let (Some(old), Some(new)) = (before.surface(face), after.surface(face)) else { continue };
        if old == new {
            continue;
        }
        let Ok(part) = before.part(face) else { continue };
        let [along_u, along_v] = [new.u(), new.v()].map(|space| cuts(space, LEAST, MOST));
        let grid = along_u.iter().flat_map(|&u| along_v.iter().map(move |&v| [u, v]));
        let own = asked.iter().filter(|(on, _)| *on as usize == face).map(|(_, at)| *at);
        for at in own.chain(grid) {
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

/// Parameters all over a domain, both ends among them: the ends of spans and as many places between them as make so many parts at `least`; where there are more spans
/// than `most`, equal parts.
pub(crate) fn cuts(space: &Space, least: usize, most: usize) -> Vec<f64> {
    let (a, b) = space.domain();
    let ends = space.breakpoints();
    let spans = ends.len().saturating_sub(1).max(1);
    if spans > most {
        return (0..=most).map(|k| a + (b - a) * (k as f64 / most as f64)).collect();
    }
    let each = least.div_ceil(spans);
    let within = |pair: &[f64]| {
        let [from, to] = [pair[0], pair[1]];
        (0..each).map(move |k| from + (to - from) * (k as f64 / each as f64))
    };
    ends.windows(2).flat_map(within).chain([b]).collect()
}
