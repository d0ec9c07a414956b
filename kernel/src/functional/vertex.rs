//! A control vertex.

use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::Result;
use crate::shape::{Stencil, vertex_index};

/// A control vertex itself: three linear equations with one coefficient 1.
#[derive(Debug, Clone, PartialEq)]
pub struct VertexAt {
    on: On,
    index: i64,
}

/// Control vertex `index`; negative numbers count from the end.
pub fn vertex(index: i64) -> VertexAt {
    VertexAt { on: On::default(), index }
}

impl VertexAt {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for VertexAt {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let index = vertex_index(self.index, shapes.get(self.on.shape)?.control_vertices().len())?;
        rows.alike(self.on.shape, &Stencil::from_iter([(index, 1.0)]));
        Ok(())
    }

    fn describe(&self) -> String {
        format!("vertex {}{}", self.index, self.on)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn by_number(&self, shape: usize) -> bool {
        shape == self.on.shape
    }

    fn is_vector(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for VertexAt {
    const DECLARATION: Declaration = Declaration {
        name: "vertex",
        help: "a control vertex",
        fields: &[Field::required("index", "whole number", "its index; -1 is the last"), OBJECT],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { on: On::from_parameters(parameters, names)?, index: parameters.integer("index")? })
    }
}
