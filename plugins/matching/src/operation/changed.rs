//! How a match has changed the whole of a surface: how far it went, and where it folds back over itself.

use loftsman_kernel::error::Error;
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::turned::{Look, Turned};
use crate::foot::{Foot, descend};

/// Places by each parameter, about, and those of a piece between knots.
const PLACES: usize = 48;
const OF_A_PIECE: [usize; 2] = [3, 16];
/// What goes more than so many times as far as it has to, at the edge, or as it does another way, goes far.
const FAR: f64 = 1.5;
/// Control vertices this many times as far apart as they were are lost.
const LOST: f64 = 30.0;
/// What goes no farther than this, of the edge's size, never does.
const NEAR: f64 = 0.01;

/// What has become of a surface, looked at on a grid within its pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Changed {
    /// The largest distance of what is from what was: what slides along itself goes nowhere.
    pub(super) moved: f64,
    /// The same of the edge that was moved, from where that was.
    pub(super) edge: f64,
    /// Where it folds back over itself, if it does, and did not before: where the normals are turned back most.
    pub(super) fold: Option<[f64; 2]>,
    /// How much of the grid is so.
    pub(super) share: f64,
    /// What is no distance to speak of.
    near: f64,
    /// Whether control vertices have gone where rounding hides the surface from them.
    lost: bool,
}

impl Changed {
    /// Of a surface, before and after, whose edge is `at_end` of its parameter across, or at its start; `size` is that of the edge. A place is folded where the
    /// unit normal is at more than a right angle to what it was, turned as the surface round it is turned ([`Turned`]), and not at the edge beside it, which
    /// the other surface turned; or to that of a place next to it, and was not: a surface that folds over turns its normal round within less than any grid.
    /// `O(n)` places, [`PLACES`] squared and some for each piece.
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
        let look = |surface: &Surface| -> Result<Vec<Look>, Error> {
            let all = places.iter().flat_map(|t| depths.iter().map(move |s| parameters(*t, *s)));
            all.map(|[u, v]| Look::at(surface, u, v)).collect()
        };
        let looks = [look(before)?, look(after)?];
        let counts = [places.len(), depths.len()];
        let extent = |surface: &Surface| {
            let points = surface.points();
            points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max)
        };
        // Those of knots that are open outwards may have next to no say in the surface: bending does not see them.
        let lost = extent(after) > LOST * extent(before);
        let mut found = Self { moved: 0.0, edge: 0.0, fold: None, share: 0.0, near: NEAR * size, lost };
        let edge = Foot::new(before.isocurve(across, depths[0])?)?;
        for (k, (old, new)) in looks[0].iter().zip(&looks[1]).enumerate() {
            let (t, s) = (places[k / counts[1]], depths[k % counts[1]]);
            let apart = (old.point - new.point).norm();
            let at = Point::from(new.point);
            if k % counts[1] == 0 && apart > found.edge {
                found.edge = found.edge.max(edge.of(t, &at)?.1.norm());
            }
            if apart > found.moved {
                found.moved = found.moved.max(descend(before, parameters(t, s), &at)?);
            }
        }
        found.folds(counts, &looks, |[i, j]| parameters(places[i], depths[j]));
        Ok(found)
    }

    /// Finds where it folds.
    fn folds(&mut self, counts: [usize; 2], looks: &[Vec<Look>; 2], at: impl Fn([usize; 2]) -> [f64; 2]) {
        let turned = Turned::new(counts, &looks[0], &looks[1]);
        let normals =
            |[i, j]: [usize; 2]| [0, 1].map(|which: usize| looks[which][i * counts[1] + j].normal());
        let back = |place: [usize; 2]| {
            let [Some(m), Some(n)] = normals(place) else { return None };
            turned.expected(place, &m).map(|expected| expected.dot(&n))
        };
        let (mut lowest, mut folded) = (f64::INFINITY, 0_usize);
        for i in 0..counts[0] {
            let by_the_other = back([i, 0]).is_some_and(|back| back < 0.0);
            for j in 1..counts[1] {
                let here = normals([i, j]);
                let mut beside = f64::INFINITY;
                for place in [Some([i, j - 1]), i.checked_sub(1).map(|i| [i, j])].into_iter().flatten() {
                    let there = normals(place);
                    let side = |which: usize| cosine([there[which], here[which]]);
                    if let (Some(was), Some(is)) = (side(0), side(1))
                        && was >= 0.0
                    {
                        beside = beside.min(is);
                    }
                }
                let turned_back = !by_the_other && back([i, j]).is_some_and(|back| back < 0.0);
                if !turned_back && beside >= 0.0 {
                    continue;
                }
                folded += 1;
                // Of all those the one that is turned most, from what it was or from one to the next.
                let most = cosine(here).filter(|_| turned_back).unwrap_or(1.0).min(beside);
                if most < lowest {
                    lowest = most;
                    self.fold = Some(at([i, j]));
                }
            }
        }
        self.share = folded as f64 / (counts[0] * (counts[1] - 1)).max(1) as f64;
    }

    /// Whether it folds nowhere and nothing of it goes much farther than the edge has to.
    pub(super) fn is_plain(&self) -> bool {
        self.fold.is_none() && !self.goes_far() && !self.lost
    }

    /// Whether it is neither folded nor lost.
    pub(super) fn is_whole(&self) -> bool {
        self.fold.is_none() && !self.lost
    }

    /// Whether control vertices have gone many times as far as the surface is large.
    pub(super) fn is_lost(&self) -> bool {
        self.lost
    }

    /// Whether something of it goes much farther than the edge has to.
    pub(super) fn goes_far(&self) -> bool {
        self.moved > self.near.max(FAR * self.edge)
    }

    /// Whether another way is better: it folds nowhere, and this one does, or goes much farther; or much less of it folds.
    pub(super) fn is_worse_than(&self, other: &Self) -> bool {
        if self.lost != other.lost {
            return self.lost;
        }
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

fn cosine([a, b]: [Option<Vector>; 2]) -> Option<f64> {
    Some(a?.dot(&b?))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use loftsman_kernel::Point;

    /// A sheet over the unit square, its inner row of control vertices shifted along `u` and lifted, and its last lifted.
    fn sheet(by: f64, lift: f64, tower: f64) -> Surface {
        let space = Space::clamped_uniform(2, 4).unwrap();
        let shift = [0.0, 0.0, by, 0.0];
        let raise = [0.0, 0.0, tower, lift];
        let at =
            |k: usize| Point::new((k / 4) as f64 / 3.0 + shift[k / 4], (k % 4) as f64 / 3.0, raise[k / 4]);
        Surface::new(space.clone(), space, (0..16).map(at).collect()).unwrap()
    }

    #[test]
    fn what_turns_back_is_a_fold_and_what_goes_along_is_none() {
        let plain = sheet(0.0, 0.0, 0.0);
        let tower = |by, lift, tower| {
            Changed::of([&plain, &sheet(by, lift, tower)], Direction::V, true, 1.0).unwrap()
        };
        let look = |by, lift| tower(by, lift, 0.0);
        assert!(look(0.0, 0.0).fold.is_none() && look(0.0, 0.0).is_plain());
        let lifted = look(0.0, 0.4);
        assert!(lifted.is_plain() && (lifted.edge - 0.4).abs() < 1e-12 && lifted.share == 0.0, "{lifted:?}");
        let folded = look(0.9, 0.0);
        let [u, _] = folded.fold.unwrap();
        assert!(u > 0.5 && folded.share > 0.02 && folded.share < 0.5, "{folded:?}");
        assert!(folded.is_worse_than(&lifted) && !lifted.is_worse_than(&folded));
        // Along itself, without a fold: it is where it was.
        let slid = look(0.2, 0.0);
        assert!(slid.is_plain() && slid.moved < 1e-9, "{slid:?}");
        // Farther than the edge, and without a fold.
        let far = tower(0.0, 0.0, 0.3);
        assert!(far.fold.is_none() && !far.is_plain() && far.moved > 0.1 && far.moved < 0.3, "{far:?}");
    }
}
