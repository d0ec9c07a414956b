//! The functional that keeps what was smooth.

use crate::error::Result;
use crate::functional::{Functional, Linearity, On, Rows, Shapes};
use crate::shape::{Bond, Shape, Stencil};

/// What a shape's pieces on both sides of a knot have in common: linear rows over its control vertices that were zero (but
/// for rounding) at mouse down, and stay what they were. See [`Relation`](super::relation::Relation).
#[derive(Debug, Clone)]
pub(crate) struct Smooth {
    pub(super) on: On,
    /// The knot; `None` for a pole.
    pub(super) knot: Option<SmoothKnot>,
    /// What is kept, for people: `smooth knot at 2`.
    pub(super) place: String,
    pub(super) rows: Vec<Stencil>,
    /// Whether it keeps pieces together that are no pieces of one spline.
    pub(super) bond: bool,
}

/// A knot (or the seam) of a curve, or such a knot line of a surface, at which a session keeps what was smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothKnot {
    /// The shape's number in the problem.
    pub shape: usize,
    /// 0 for knots of a curve, or of a surface's `u`; 1 for those of its `v`.
    pub direction: usize,
    /// The knot; of a seam, where the domain starts.
    pub at: f64,
    /// Up to which derivative both sides go on agreeing, all along a knot line, but for the speed: 0 position, 1 direction of
    /// the tangent, 2 curvature. Nothing where somewhere they need not even meet.
    pub order: Option<usize>,
}

impl Smooth {
    /// What holds a shape of several pieces together.
    pub(crate) fn of_bonds<'s>(shape: &'s dyn Shape, on: &On) -> impl Iterator<Item = Self> + use<'s> {
        let on = on.clone();
        let bonds = shape.bonds().map_or(&[][..], |bonds| bonds.bonds());
        bonds.iter().map(move |Bond { name, rows }| Self {
            on: on.clone(),
            knot: None,
            place: name.clone(),
            rows: rows.clone(),
            bond: true,
        })
    }

    /// Whether it keeps pieces together that are no pieces of one spline.
    pub(crate) fn is_bond(&self) -> bool {
        self.bond
    }

    /// Where it is, and how much is kept there; `None` for a pole.
    pub(crate) fn knot(&self) -> Option<SmoothKnot> {
        self.knot
    }
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
