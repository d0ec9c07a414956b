//! Creases: where the normals of neighbouring nodes are opposite.

use loftsman_kernel::spline::space::MAX_ORDER;

use super::EXTRA;

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
        let product = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let turned = |a: [f64; 3]| product(a, normal) < -BLUR * product(a, a).max(product(normal, normal));
        let beside =
            column.checked_sub(1).and_then(|before| self.row.get(before)).is_some_and(|&n| turned(n));
        if let Some(place) = self.row.get_mut(column) {
            self.creased |= beside || turned(*place);
            *place = normal;
        }
    }
}
