//! A join of whole edges looked at between the places where it was imposed.

use super::places::nodes;
use crate::error::Result;
use crate::functional::{Accuracy, Functional, Linearity, Rows, Shapes};
use crate::shape::{Derivative, Location, Shape, Stencil};
use crate::topology::Pair;

/// The differences of positions and of cross derivatives at places all along an edge: zero where the join holds. Derivatives
/// of order `k` are multiplied by `step^k`, as the join's own equations are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Between {
    pub(super) name: String,
    pub(super) first: usize,
    pub(super) second: usize,
    pub(super) continuity: usize,
    pub(super) step: f64,
    pub(super) accuracy: Accuracy,
    pub(super) samples: Vec<Sample>,
}

/// A place on both shapes, with the derivatives that should be equal there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) first: (Location, [Derivative; 3]),
    pub(super) second: (Location, [Derivative; 3]),
    /// The factor of the second's, for each order.
    pub(super) factors: [f64; 3],
}

impl Sample {
    /// Both derivatives of an order in terms of the control vertices.
    pub(super) fn stencils(&self, a: &dyn Shape, b: &dyn Shape, order: usize) -> Result<(Stencil, Stencil)> {
        let second = b.stencil(self.second.0, self.second.1[order])?;
        Ok((a.stencil(self.first.0, self.first.1[order])?, second.scaled(self.factors[order])))
    }

    /// The angle between the ways in which the shapes leave the edge: their derivatives across, less what of them runs along it.
    pub(super) fn angle(&self, a: &dyn Shape, b: &dyn Shape) -> Result<Option<f64>> {
        let (first, second) = self.stencils(a, b, 1)?;
        let Derivative { u, v } = self.first.1[1];
        let along = a.value(self.first.0, Derivative { u: v, v: u })?;
        let Some(along) = along.try_normalize(0.0) else { return Ok(None) };
        let [first, second] = [first.apply(a.control_vertices()), second.apply(b.control_vertices())]
            .map(|across| (across - along * across.dot(&along)).try_normalize(0.0));
        let (Some(first), Some(second)) = (first, second) else { return Ok(None) };
        Ok(Some(first.cross(&second).norm().atan2(first.dot(&second))))
    }
}

/// So many times as many places show how large a polynomial is: nowhere more than `1/cos(π/2k)` times as large as there.
const FINER: usize = 16;
/// `cos(π/2k)`.
pub(super) const SHOWN: f64 = 0.995_18;

/// Places along an edge: as many of each piece as determine a polynomial of the sum of both degrees, which is what the
/// numerator of the difference is, inside the piece, so that derivatives are never asked for at a knot. Where the difference
/// is not to vanish, as many times more as show how large it is.
pub(super) fn samples(pair: &Pair<'_>, breakpoints: &[f64], tolerant: bool) -> Vec<Sample> {
    let (first, second) = (pair.first, pair.second);
    let degree = first.space().degree() + second.space().degree();
    let each = if tolerant { FINER * degree } else { degree + 1 };
    nodes(breakpoints, each)
        .map(|t| {
            let (t, u) = pair.place(t);
            Sample {
                first: (first.at(t), [0, 1, 2].map(|k| first.across(k))),
                second: (second.at(u), [0, 1, 2].map(|k| second.across(k))),
                factors: [0, 1, 2].map(|k| pair.sign(k)),
            }
        })
        .collect()
}

impl Functional for Between {
    fn equations(&self) -> usize {
        3 * self.samples.len() * (self.continuity + 1)
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let (a, b) = (shapes.get(self.first)?, shapes.get(self.second)?);
        for sample in &self.samples {
            for k in 0..=self.continuity {
                let (first, second) = sample.stencils(a, b, k)?;
                let by = self.step.powi(k as i32);
                rows.difference((self.first, &first.scaled(by)), (self.second, &second.scaled(by)));
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}, all along", self.name)
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }
}
