//! A bicubic Bézier patch over a quad that has an extraordinary point at its first corner and is regular elsewhere, and how near it is.

use loftsman_kernel::Vector;

use super::left_out::first_of;
use super::net::{Net, cut, largest, turned};
use super::pattern::Quadrant;
use crate::error::Result;

/// Levels that are compared, at most.
const LEVELS: u32 = 40;

/// The points of a patch round its three regular corners: with the positions, slopes and twists of Bézier patches of the surface there, those at
/// corners 1 to 3, each with how many times the quad is as large.
pub(crate) fn around(regular: &[(Net, f64); 3]) -> Net {
    let mut all = [Vector::zeros(); 16];
    for (turn, (piece, times)) in (1..).zip(regular) {
        let own = turned(piece, turn);
        let (a, b, c, d) = (own[0], own[4], own[1], own[5]);
        let (u, v) = (a + (b - a) * *times, a + (c - a) * *times);
        let seen = [(0, a), (4, u), (1, v), (5, u + v - a + (d - b - c + a) * (times * times))];
        let mut other = turned(&all, turn);
        seen.into_iter().for_each(|(k, p)| other[k] = p);
        all = turned(&other, 4 - turn);
    }
    all
}

/// The Bézier points of a side from the extraordinary point, of which the last two, and the middle of the surface there, are known: through that middle;
/// where the direction that the surface has at the point is given, the second lies on that, as near to this as it can.
pub(crate) fn side(start: Vector, along: Option<&Vector>, middle: Vector, far: [Vector; 2]) -> [Vector; 4] {
    // What the second point would have to be, less the first, for the curve to pass through the middle.
    let through = (middle * 8.0 - start * 4.0 - far[0] * 3.0 - far[1]) / 3.0;
    let step = match along.map(|t| (t, t.norm_squared())) {
        Some((t, size)) if size > 0.0 && through.dot(t) > 0.0 => t * (through.dot(t) / size),
        _ => through,
    };
    [start, start + step, far[0], far[1]]
}

/// The rest of the points: both sides from the extraordinary point, and the one within so that the middle is the surface's.
pub(crate) fn close(all: &mut Net, along_u: [Vector; 4], along_v: [Vector; 4], middle: Vector) {
    for k in 0..4 {
        (all[4 * k], all[k]) = (along_u[k], along_v[k]);
    }
    let weights = [1.0, 3.0, 3.0, 1.0];
    let others = (0..16).filter(|k| *k != 5);
    let sum = others.fold(Vector::zeros(), |sum, k| sum + all[k] * (weights[k / 4] * weights[k % 4]));
    all[5] = (middle * 64.0 - sum) / 9.0;
}

/// What a patch is compared with.
pub(crate) trait Surrounded {
    /// The Bézier points of the surface over a quadrant; nothing where it is no piece.
    fn piece(&mut self, quadrant: Quadrant) -> Result<Option<Net>>;
    /// Points in whose convex hull the surface lies over the quadrant of a level at the extraordinary point.
    fn hull(&mut self, level: u32) -> Result<Vec<Vector>>;
}

/// A bound of the distance of points of equal parameters; `None` where that is more than the tolerance.
pub(crate) fn apart(patch: &Net, tolerance: f64, surface: &mut impl Surrounded) -> Result<Option<f64>> {
    let size = largest(patch.iter().map(Vector::amax));
    let mut most = 64.0 * f64::EPSILON * size;
    for level in 1..=LEVELS {
        let part = 0.5_f64.powi(level as i32);
        let mut rest = first_of(level - 1).parts()[1..].to_vec();
        while let Some(quadrant) = rest.pop() {
            let piece = match surface.piece(quadrant)? {
                Some(piece) => piece,
                None if quadrant.level == level => {
                    rest.extend(quadrant.parts());
                    continue;
                }
                None => return Ok(None),
            };
            let part = 0.5_f64.powi(quadrant.level as i32);
            let side = |k: u64| [k as f64 * part, (k + 1) as f64 * part];
            let own = cut(patch, side(quadrant.i), side(quadrant.j));
            let apart = piece.iter().zip(&own).map(|(a, b)| (a - b).norm());
            most = most.max(largest(apart));
        }
        if most > tolerance {
            return Ok(None);
        }
        let hull = surface.hull(level)?;
        let own = cut(patch, [0.0, part], [0.0, part]);
        let pairs = hull.iter().flat_map(|a| own.iter().map(move |b| (a - b).norm()));
        let rest = largest(pairs);
        if rest <= most || (level == LEVELS && rest <= tolerance) {
            return Ok(Some(most.max(rest)));
        }
    }
    Ok(None)
}
