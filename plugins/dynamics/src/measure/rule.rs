//! The two rules: that of Lobatto, which looks at ends, and that of Legendre.

use loftsman_kernel::shape::{Cell, CellSide};
use loftsman_kernel::spline::gram::{gauss_legendre, gauss_lobatto};

/// Points of both rules beyond the degree, and beyond these on quotients of polynomials: that of Lobatto, then that of Legendre.
const MORE: [usize; 2] = [5, 6];
const RATIONAL: usize = 4;
/// Ends are looked at so far within, as a share of a part: beyond them is another cell.
const WITHIN: f64 = 1e-12;

/// Nodes and weights on `[0, 1]`, and Legendre's polynomial of twice the degree there.
pub(super) struct Rule {
    nodes: Vec<f64>,
    pub(super) weights: Vec<f64>,
    pub(super) highest: Vec<f64>,
}

/// Which rule: one of the two, by the number of its points, and twice the degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    with_ends: bool,
    pub(super) count: usize,
    highest: usize,
}

impl Key {
    /// The rule of a cell in one direction.
    pub(super) fn new(cell: &Cell, k: usize, with_ends: bool) -> Self {
        let degree = cell.sides.get(k).map_or(0, |side| side.degree);
        let more = MORE[usize::from(!with_ends)] + if cell.rational { RATIONAL } else { 0 };
        Self { with_ends, count: degree + more, highest: 2 * degree }
    }
}

impl Rule {
    pub(super) fn new(key: Key) -> Self {
        let (nodes, weights) =
            if key.with_ends { gauss_lobatto(key.count) } else { gauss_legendre(key.count) };
        let highest = nodes.iter().map(|x| legendre(key.highest, 2.0 * x - 1.0)).collect();
        Self { nodes, weights, highest }
    }

    /// Its nodes as shares of a side, none of them on its ends.
    pub(super) fn within(&self, side: Option<&CellSide>) -> impl Iterator<Item = f64> {
        let rounded = side.map_or(0.0, |side| {
            4.0 * f64::EPSILON * side.start.abs().max(side.end.abs()) / (side.end - side.start)
        });
        let end = WITHIN.max(rounded).min(0.5);
        self.nodes.iter().map(move |x| x.clamp(end, 1.0 - end))
    }
}

/// Legendre's polynomial, by its recurrence.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut value, mut before) = (1.0, 0.0);
    for k in 0..degree {
        let next = ((2 * k + 1) as f64 * x * value - k as f64 * before) / (k + 1) as f64;
        (before, value) = (value, next);
    }
    value
}
