//! What is known of constraints from when they were bound.

use smallvec::SmallVec;

use super::Numbers;
use crate::error::Result;
use crate::functional::{Functional, Linearity, Shapes, Store, linearize_of, usable, value_of};

/// What was found of the first constraints, on the shapes as they are: whoever goes on with them need not ask again. By default
/// nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known {
    /// The values of these, one behind the other.
    pub(crate) values: Numbers,
    pub(crate) linear: Linear,
    constraints: usize,
}

/// The rows of the first constraints, as far as these are linear.
#[derive(Debug, Clone, Default)]
pub(crate) struct Linear {
    pub(crate) store: Store,
    /// Where the blocks of each constraint start, and where the last ones end; empty where none is known.
    pub(crate) blocks: SmallVec<[usize; 4]>,
}

impl Linear {
    /// Room for so many constraints in all, where none is known yet.
    pub(crate) fn reserve(&mut self, constraints: usize) {
        if self.blocks.is_empty() {
            self.blocks.reserve_exact(constraints + 1);
            self.blocks.push(0);
            self.store.reserve(constraints);
        }
    }

    /// Of how many constraints the rows are known.
    pub(crate) fn constraints(&self) -> usize {
        self.blocks.len().saturating_sub(1)
    }
}

impl Known {
    /// Room for so many constraints in all, where none is known yet.
    pub(super) fn reserve(&mut self, constraints: usize) {
        self.values.reserve_exact(3 * constraints);
        self.linear.reserve(constraints);
    }

    /// The value of the next constraint's functional, which has so many equations; with it the rows, where all up to here are linear:
    /// both are made of the same stencils.
    ///
    /// # Errors
    /// As for [`Functional::linearize`].
    pub(super) fn ask(
        &mut self,
        functional: &dyn Functional,
        shapes: &Shapes<'_>,
        equations: usize,
    ) -> Result<&[f64]> {
        let first = self.values.len();
        self.values.resize(first + equations, 0.0);
        let value = &mut self.values[first..];
        let linear = &mut self.linear;
        if linear.blocks.len() == self.constraints + 1 && functional.linearity() == Linearity::Linear {
            linearize_of(functional, shapes, &mut linear.store.rows(shapes), value)?;
            linear.blocks.push(linear.store.blocks());
        } else {
            value_of(functional, shapes, value)?;
        }
        self.constraints += 1;
        Ok(value)
    }

    /// Whether the rows of the constraint asked last are finite, if they are known.
    ///
    /// # Errors
    /// Where they are not, naming the functional.
    pub(super) fn check(&self, functional: &dyn Functional) -> Result<()> {
        let Linear { store, blocks } = &self.linear;
        match blocks[..] {
            [.., first, _] if blocks.len() == self.constraints + 1 => usable(functional, store, first),
            _ => Ok(()),
        }
    }
}
