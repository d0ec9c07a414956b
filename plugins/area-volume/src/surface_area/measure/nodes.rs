//! Rules of quadrature that see what they miss.

use loftsman_kernel::spline::gram::gauss_legendre;

use super::{EXTRA, WITH_ENDS};

/// A rule in each direction.
pub(super) struct Nodes {
    pub(super) u: Along,
    pub(super) v: Along,
}

impl Nodes {
    /// For cells of some degrees the rule of a number: the rougher and the better one, and this with its ends.
    pub(super) fn of_rule([p, q]: [usize; 2], rule: usize) -> Self {
        let extra = EXTRA[rule.min(1)];
        let make = if rule == WITH_ENDS { Along::with_ends } else { Along::new };
        Self { u: make(p + extra), v: make(q + extra) }
    }
}

/// Nodes on `[0, 1]` with three weights each: Gauss and Legendre's, those of the highest divided difference, which is zero for
/// all polynomials that have one coefficient less than there are nodes, and these times the distance from the middle, for
/// polynomials with one coefficient less still. One of the two is even, the other odd about the middle, so that not both
/// overlook a crease there. They are scaled to a sum of 1 without signs.
pub(super) struct Along(pub(super) Vec<(f64, [f64; 3])>);

impl Along {
    pub(super) fn new(count: usize) -> Self {
        let (nodes, weights) = gauss_legendre(count);
        let difference = |k: usize| {
            let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
            others.map(|(_, x)| nodes[k] - x).product::<f64>().recip()
        };
        let off = |k: usize| (nodes[k] - 0.5) * difference(k);
        let whole: f64 = (0..count).map(|k| difference(k).abs()).sum();
        let other: f64 = (0..count).map(|k| off(k).abs()).sum();
        let all = |k: usize| [weights[k], difference(k) / whole, off(k) / other];
        Self((0..count).map(|k| (nodes[k], all(k))).collect())
    }

    /// The same, and it looks at the ends, which have no weight: a crease that touches an end from inside is seen.
    pub(super) fn with_ends(count: usize) -> Self {
        let Self(mut nodes) = Self::new(count);
        nodes.insert(0, (0.0, [0.0; 3]));
        nodes.push((1.0, [0.0; 3]));
        Self(nodes)
    }
}
