//! A finished edit.

use std::marker::PhantomData;

use super::{State, put};
use crate::edit::report::Report;
use crate::error::Result;
use crate::problem::{Boxes, view};
use crate::shape::Shape;

/// A finished edit: the new shapes, the report and the way back.
#[derive(Debug)]
pub struct Edited<S> {
    pub(super) shapes: Boxes,
    pub(super) report: Report,
    pub(super) before: State,
    /// The first shape before knots were inserted to keep the edit in an interval.
    pub(super) original: Option<Box<dyn Shape>>,
    pub(super) kind: PhantomData<fn() -> S>,
}

impl<S: Shape> Edited<S> {
    /// The edited shape.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn shape(&self) -> &S {
        match S::in_box(&self.shapes[0]) {
            Some(shape) => shape,
            None => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// Shape `index` of the problem; 0 is [`shape`](Self::shape).
    ///
    /// # Errors
    /// When there are not as many.
    pub fn shape_at(&self, index: usize) -> Result<&dyn Shape> {
        view(&self.shapes).get(index)
    }

    /// The edited shape, out of the box.
    ///
    /// # Panics
    /// Never: the first shape is what the edit was made of.
    pub fn into_shape(mut self) -> S {
        match S::from_box(self.shapes.swap_remove(0)) {
            Some(shape) => shape,
            None => unreachable!("the first shape of an edit has the edit's type"),
        }
    }

    /// What solving gave.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Takes the edit back: the shape as it was, without the knots that the edit inserted.
    #[must_use]
    pub fn undo(mut self) -> S {
        match self.original.take() {
            Some(original) => self.shapes[0] = original,
            None => put(&mut self.shapes, &self.before),
        }
        self.into_shape()
    }
}
