//! Creases: where the normals of neighbouring nodes are opposite.

use loftsman_kernel::spline::space::MAX_ORDER;

use super::EXTRA;
use crate::nets::Across;

/// Of two normals beside one another that are opposite, the less is more than this part of the other: else it is rounding beside a fold.
const BLUR: f64 = 1e-9;

/// The most nodes of a rule, with the ends.
const MOST_NODES: usize = MAX_ORDER + EXTRA[1] + 1;

/// Normals of neighbouring nodes beside one another.
pub(super) struct Turns {
    /// The normals of the row before, as far as this one is not there yet.
    row: [[f64; 3]; MOST_NODES],
    pub(super) creased: bool,
}

impl Default for Turns {
    fn default() -> Self {
        Self { row: [[0.0; 3]; MOST_NODES], creased: false }
    }
}

impl Turns {
    /// The next normal, in this column.
    pub(super) fn see(&mut self, column: usize, normal: [f64; 3]) {
        let beside =
            column.checked_sub(1).and_then(|before| self.row.get(before)).is_some_and(|&n| turned(n, normal));
        if let Some(place) = self.row.get_mut(column) {
            self.creased |= beside || turned(*place, normal);
            *place = normal;
        }
    }
}

/// Whether a normal of a row of nodes is opposite to that before it, or to that of the row before, as [`Turns::see`] says of one after another.
pub(super) fn creased(row: &Across, before: &Across, count: usize) -> bool {
    let at = |all: &Across, k: usize| [0, 1, 2].map(|a| all[a][k]);
    let mut least = 0.0_f64;
    for k in 0..count {
        least = least.min(product(at(row, k), at(before, k)));
    }
    for k in 1..count {
        least = least.min(product(at(row, k), at(row, k - 1)));
    }
    // Most rows turn nowhere.
    least < 0.0
        && (0..count)
            .any(|k| turned(at(before, k), at(row, k)) || k > 0 && turned(at(row, k - 1), at(row, k)))
}

fn product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn turned(a: [f64; 3], b: [f64; 3]) -> bool {
    product(a, b) < -BLUR * product(a, a).max(product(b, b))
}
