//! Where the pieces of a spline meet with less continuity than is to be kept.

use smallvec::SmallVec;

use super::columns::unrolled;
use crate::shape::Side;
use crate::spline::Space;

/// A knot (or the seam of a closed open space) at which the pieces on both sides may differ in a derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Joint {
    /// The span before it, and where that ends.
    pub(super) left: (usize, f64),
    /// The span after it, and where that starts.
    pub(super) right: (usize, f64),
    /// Whether the end meets the start there.
    pub(super) seam: bool,
    /// Whether even the position may differ: at a knot of multiplicity `p + 1`, at the seam of an open space.
    pub(super) torn: bool,
    /// Whether the first derivative may differ: from multiplicity `p` on.
    pub(super) sharp: bool,
}

impl Joint {
    /// The joint at a knot inside the domain that is repeated `least` times or oftener.
    fn at(space: &Space, knot: f64, least: usize) -> Option<Self> {
        let ((a, b), p) = (space.domain(), space.degree());
        let knot = if space.is_periodic() && knot == b { a } else { knot };
        let inside = space.is_periodic() && knot >= a && knot < b || knot > a && knot < b;
        let multiplicity = if inside { space.multiplicity(knot) } else { 0 };
        (inside && multiplicity >= least).then(|| Self {
            left: space.span_on(knot, Side::Left),
            right: space.span_on(knot, Side::Right),
            seam: knot == a,
            torn: multiplicity > p,
            sharp: multiplicity >= p,
        })
    }

    /// Where the end of an open space meets its start.
    pub(super) fn closing(space: &Space) -> Self {
        let (a, b) = space.domain();
        Self {
            left: space.span_on(b, Side::Left),
            right: space.span_on(a, Side::Right),
            seam: true,
            torn: true,
            sharp: true,
        }
    }

    /// The lengths of the spans before and after it.
    pub(super) fn lengths(&self, space: &Space) -> [f64; 2] {
        [self.left.0, self.right.0].map(|s| space.flat()[s + 1] - space.flat()[s])
    }
}

/// The joints in reach of a control vertex: at knots inside the domain that are repeated `least` times or oftener, and
/// where the space `closes` its seam. `O(p log n)`.
pub(super) fn joints_near(space: &Space, vertex: usize, least: usize, closes: bool) -> SmallVec<[Joint; 4]> {
    let p = space.degree();
    let mut found: SmallVec<[Joint; 4]> = SmallVec::new();
    for k in unrolled(space, vertex) {
        if space.most_repeated() >= least {
            let knots = &space.flat()[k..=k + p + 1];
            let distinct = knots.iter().enumerate().filter(|&(i, t)| i == 0 || knots[i - 1] != *t);
            found.extend(distinct.filter_map(|(_, &t)| Joint::at(space, t, least)));
        }
        if closes {
            let joint = Joint::closing(space);
            if k <= joint.right.0 || k + p >= joint.left.0 {
                found.push(joint);
            }
        }
    }
    found.sort_by_key(|joint| joint.left.0);
    found.dedup_by_key(|joint| joint.left.0);
    found
}

/// The joint at a parameter: an inner knot, or an end where the space `closes` its seam.
pub(super) fn joint_at(space: &Space, u: f64, least: usize, closes: bool) -> Option<Joint> {
    let (a, b) = space.domain();
    if closes && (u == a || u == b) {
        return Some(Joint::closing(space));
    }
    Joint::at(space, u, least)
}
