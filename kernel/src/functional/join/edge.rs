//! What the edges of surfaces are called.

use std::fmt;

use crate::declare::{ParameterError, Parameters, nearest};
use crate::error::{Error, Result};
use crate::shape::{BoundaryEdge, Shape, edges_of};
use crate::text::clip;

/// A whole edge of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// `u` at the start of its domain.
    UStart,
    /// `u` at the end of its domain.
    UEnd,
    /// `v` at the start of its domain.
    VStart,
    /// `v` at the end of its domain.
    VEnd,
    /// The edge of this number, of a surface whose [edges](crate::shape::Edges) have other names; in recipes `"edge 3"`.
    Number(usize),
}

impl Edge {
    /// The edge's number on a shape, its four sides by their names.
    ///
    /// # Errors
    /// When the shape has no edges, or not this one; the error lists those that it has.
    pub fn number_on(self, shape: &dyn Shape) -> Result<usize> {
        let edges = edges_of(shape, "edge")?;
        let found = match self {
            Self::Number(index) => Some(index).filter(|&index| index < edges.count()),
            _ => edges.iter().position(|edge| edge.name == self.to_string()),
        };
        found.ok_or_else(|| {
            // Those of a surface of many faces are asked for by their numbers.
            let told = |(number, edge): (usize, BoundaryEdge)| match EDGES
                .iter()
                .any(|(name, _)| *name == edge.name)
            {
                true => edge.name.into_owned(),
                false if edge.name.starts_with("edge ") => edge.name.into_owned(),
                false => format!("edge {number} ({})", edge.name),
            };
            let mut names: Vec<_> = edges.iter().enumerate().take(LISTED).map(told).collect();
            if edges.count() > LISTED {
                names.push(format!("… up to edge {}", edges.count() - 1));
            }
            let names = if names.is_empty() { "none: it is closed".into() } else { names.join(", ") };
            Error::Invalid(format!("there is no {}: the surface's edges are {names}", self.called()))
        })
    }

    /// The edge in a sentence: `edge u1`, `edge 3`.
    pub fn called(self) -> String {
        match self {
            Self::Number(index) => format!("edge {index}"),
            _ => format!("edge {self}"),
        }
    }

    /// The edge that a field of a recipe names.
    ///
    /// # Errors
    /// When it is missing or no edge's name, with the nearest one.
    pub fn from_parameters(parameters: &Parameters, field: &str) -> Result<Self, ParameterError> {
        let text = parameters.text(field)?;
        if let Some(index) = text.strip_prefix("edge ").and_then(|number| number.parse().ok()) {
            return Ok(Self::Number(index));
        }
        match EDGES.iter().find(|(name, _)| *name == text) {
            Some((_, edge)) => Ok(*edge),
            None => {
                let hint = match nearest(text, EDGES.iter().map(|(name, _)| *name)) {
                    Some(near) => format!("; did you mean \"{near}\"?"),
                    None => String::new(),
                };
                let problem = format!(
                    "unknown edge \"{}\": u0 and u1 are where u starts and ends, v0 and v1 where v does, and those of a surface of many \
                     faces have numbers, \"edge 3\"{hint}",
                    clip(text)
                );
                Err(parameters.error(field, problem))
            }
        }
    }
}

impl fmt::Display for Edge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, EDGES.iter().find(|(_, edge)| edge == self)) {
            (Self::Number(index), _) => write!(f, "edge {index}"),
            (_, Some((name, _))) => f.write_str(name),
            (_, None) => Ok(()),
        }
    }
}

/// So many edges an error lists.
const LISTED: usize = 48;

const EDGES: [(&str, Edge); 4] =
    [("u0", Edge::UStart), ("u1", Edge::UEnd), ("v0", Edge::VStart), ("v1", Edge::VEnd)];
