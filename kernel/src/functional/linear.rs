//! Any linear functional of control vertices.

use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::Vector;
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::Result;
use crate::shape::vertex_index;

/// `Σ a_i·P_i`, one linear equation with a vector a vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    on: On,
    terms: Vec<(i64, Vector)>,
}

/// The linear functional with these `(vertex, vector)` terms; negative vertices count from the end.
pub fn linear(terms: impl IntoIterator<Item = (i64, Vector)>) -> Linear {
    Linear { on: On::default(), terms: terms.into_iter().collect() }
}

impl Linear {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }
}

impl Functional for Linear {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let count = shapes.get(self.on.shape)?.control_vertices().len();
        rows.equation();
        for &(index, vector) in &self.terms {
            rows.term(self.on.shape, vertex_index(index, count)?, vector);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        let some: Vec<String> = self.terms.iter().take(3).map(|(i, _)| i.to_string()).collect();
        let more = if self.terms.len() > 3 { ", …" } else { "" };
        format!("linear in vertices {}{more}{}", some.join(", "), self.on)
    }

    fn by_number(&self, shape: usize) -> bool {
        shape == self.on.shape
    }
}

impl DeclaredFunctional for Linear {
    const DECLARATION: Declaration = Declaration {
        name: "linear",
        help: "any linear functional, the sum of vector · vertex",
        fields: &[
            Field::required(
                "terms",
                "[{ vertex, vector }, …]",
                "control vertices and their vectors [x, y, z]",
            ),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        const TERM: [Field; 2] = [
            Field::required("vertex", "whole number", "the control vertex"),
            Field::required("vector", "[x, y, z]", "its vector"),
        ];
        let mut terms = Vec::new();
        for term in parameters.tables("terms")? {
            term.check(&TERM)?;
            terms.push((term.integer("vertex")?, term.vector("vector")?));
        }
        if terms.is_empty() {
            return Err(parameters.error("terms", "at least one term is needed"));
        }
        Ok(Self { on: On::from_parameters(parameters, names)?, terms })
    }
}
