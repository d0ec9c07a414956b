//! The functional that keeps what was smooth.

use crate::error::Result;
use crate::functional::{Functional, Linearity, On, Rows, Shapes};
use crate::shape::Stencil;

/// What a shape's pieces on both sides of a knot have in common: linear rows over its control vertices that were zero (but
/// for rounding) at mouse down, and stay what they were. See [`Relation`](super::relation::Relation).
#[derive(Debug, Clone)]
pub(crate) struct Smooth {
    pub(super) on: On,
    /// What is kept, for people: `smooth knot at 2`.
    pub(super) place: String,
    pub(super) rows: Vec<Stencil>,
}

impl Functional for Smooth {
    fn equations(&self) -> usize {
        3 * self.rows.len()
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        for row in &self.rows {
            rows.alike(self.on.shape, row);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}{}", self.place, self.on)
    }
}
