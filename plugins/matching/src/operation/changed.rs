//! How a match has changed the whole of a surface: how far it went, and where it folds back over itself.

use loftsman_kernel::Vector;
use loftsman_kernel::error::Error;
use loftsman_kernel::spline::{Direction, Space, Surface};

/// Places by each parameter, about, and those of a piece between knots.
const PLACES: usize = 48;
const OF_A_PIECE: [usize; 2] = [3, 16];
/// What goes more than so many times as far as it has to, at the edge, or as it does another way, goes far.
const FAR: f64 = 1.5;
/// What goes no farther than this, of the edge's size, never does.
const NEAR: f64 = 0.01;

/// What has become of a surface, looked at on a grid within its pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Changed {
    /// The largest distance between what was and what is, at the same parameters.
    pub(super) moved: f64,
    /// The same along the edge that was moved.
    pub(super) edge: f64,
    /// Where it folds back over itself, if it does, and did not before: where the normals are turned back most.
    pub(super) fold: Option<[f64; 2]>,
    /// How much of the grid is so.
    pub(super) share: f64,
    /// What is no distance to speak of.
    near: f64,
}

impl Changed {
    /// Of a surface, before and after, whose edge is `at_end` of its parameter across, or at its start; `size` is that of the edge. A place is folded where the unit normal is at more than a right angle to
    /// what it was, and not at the edge beside it, which the other surface turned; or to that of a place next to it, and was not: a surface
    /// that folds over turns its normal round within less than any grid. `O(n)` places, [`PLACES`] squared and some for each piece.
    pub(super) fn of(
        [before, after]: [&Surface; 2],
        along: Direction,
        at_end: bool,
        size: f64,
    ) -> Result<Self, Error> {
        let across = along.other();
        let (places, mut depths) = (places(after.space(along)), places(after.space(across)));
        let (start, end) = after.space(across).domain();
        // The edge first, then away from it.
        if at_end {
            depths.reverse();
        }
        depths.insert(0, if at_end { end } else { start });
        let parameters = |t: f64, s: f64| if along == Direction::U { [t, s] } else { [s, t] };
        let mut found = Self { moved: 0.0, edge: 0.0, fold: None, share: 0.0, near: NEAR * size };
        let (mut lowest, mut folded) = (f64::INFINITY, 0_usize);
        let mut beside: Vec<[Option<Vector>; 2]> = Vec::new();
        for &t in &places {
            let (mut column, mut turned) = (Vec::with_capacity(depths.len()), 1.0);
            for (depth, &s) in depths.iter().enumerate() {
                let [u, v] = parameters(t, s);
                let ([p, m], [q, n]) = (look(before, u, v)?, look(after, u, v)?);
                let (distance, normals) = ((p - q).norm(), [unit(m), unit(n)]);
                found.moved = found.moved.max(distance);
                let back = cosine(normals);
                if depth == 0 {
                    found.edge = found.edge.max(distance);
                    turned = back.unwrap_or(1.0);
                    column.push(normals);
                    continue;
                }
                let mut worst = back.filter(|_| turned >= 0.0).unwrap_or(1.0);
                let neighbours = [column.last(), beside.get(depth)];
                for other in neighbours.into_iter().flatten() {
                    let side = |which: usize| cosine([other[which], normals[which]]);
                    if let (Some(was), Some(is)) = (side(0), side(1))
                        && was >= 0.0
                    {
                        worst = worst.min(is);
                    }
                }
                folded += usize::from(worst < 0.0);
                if worst < lowest.min(0.0) {
                    lowest = worst;
                    found.fold = Some([u, v]);
                }
                column.push(normals);
            }
            beside = column;
        }
        found.share = folded as f64 / (places.len() * (depths.len() - 1)).max(1) as f64;
        Ok(found)
    }

    /// Whether it folds nowhere and nothing of it goes much farther than the edge has to.
    pub(super) fn is_plain(&self) -> bool {
        self.fold.is_none() && !self.goes_far()
    }

    /// Whether something of it goes much farther than the edge has to.
    pub(super) fn goes_far(&self) -> bool {
        self.moved > self.near.max(FAR * self.edge)
    }

    /// Whether another way is better: it folds nowhere, and this one does, or goes much farther; or much less of it folds.
    pub(super) fn is_worse_than(&self, other: &Self) -> bool {
        match (self.fold, other.fold) {
            (None, None) => self.moved > self.near.max(FAR * other.moved),
            (Some(_), None) => true,
            (Some(_), Some(_)) => self.share > FAR * other.share,
            (None, Some(_)) => false,
        }
    }
}

/// Places within the pieces of a space, none at a knot.
fn places(space: &Space) -> Vec<f64> {
    let breaks = space.breakpoints();
    let [least, most] = OF_A_PIECE;
    let count = PLACES.div_ceil(breaks.len().saturating_sub(1).max(1)).clamp(least, most);
    let piece = |pair: &[f64]| {
        let (a, b) = (pair[0], pair[1]);
        (0..count).map(move |k| a + (b - a) * (k as f64 + 0.5) / count as f64).collect::<Vec<_>>()
    };
    breaks.windows(2).flat_map(piece).collect()
}

/// The point, and the product of the first derivatives.
fn look(surface: &Surface, u: f64, v: f64) -> Result<[Vector; 2], Error> {
    let mut all = [Vector::zeros(); 4];
    surface.derivatives_into(u, v, [1, 1], &mut all)?;
    // Of unit length each, so that their product is a number whatever the size.
    let normal = match [unit(all[2]), unit(all[1])] {
        [Some(x), Some(y)] => x.cross(&y),
        _ => Vector::zeros(),
    };
    Ok([all[0], normal])
}

fn unit(vector: Vector) -> Option<Vector> {
    let length = vector.norm();
    (length > 0.0 && length.is_finite()).then(|| vector / length)
}

fn cosine([a, b]: [Option<Vector>; 2]) -> Option<f64> {
    Some(a?.dot(&b?))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use loftsman_kernel::Point;

    /// A sheet over the unit square, its inner row of control vertices shifted along `u`, and its last lifted.
    fn sheet(by: f64, lift: f64) -> Surface {
        let space = Space::clamped_uniform(2, 4).unwrap();
        let shift = [0.0, 0.0, by, 0.0];
        let raise = [0.0, 0.0, 0.0, lift];
        let at =
            |k: usize| Point::new((k / 4) as f64 / 3.0 + shift[k / 4], (k % 4) as f64 / 3.0, raise[k / 4]);
        Surface::new(space.clone(), space, (0..16).map(at).collect()).unwrap()
    }

    #[test]
    fn what_turns_back_is_a_fold_and_what_goes_along_is_none() {
        let plain = sheet(0.0, 0.0);
        let look = |by, lift| Changed::of([&plain, &sheet(by, lift)], Direction::V, true, 1.0).unwrap();
        assert!(look(0.0, 0.0).fold.is_none() && look(0.0, 0.0).is_plain());
        let lifted = look(0.0, 0.4);
        assert!(lifted.is_plain() && (lifted.edge - 0.4).abs() < 1e-12 && lifted.share == 0.0, "{lifted:?}");
        let folded = look(0.9, 0.0);
        let [u, _] = folded.fold.unwrap();
        assert!(u > 0.5 && folded.share > 0.02 && folded.share < 0.5, "{folded:?}");
        assert!(folded.is_worse_than(&lifted) && !lifted.is_worse_than(&folded));
        // Farther than the edge, and without a fold.
        let far = look(0.2, 0.0);
        assert!(far.fold.is_none() && !far.is_plain() && far.moved > 0.05, "{far:?}");
    }
}
