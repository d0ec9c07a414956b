//! The edges of tensor-product surfaces: the ends of directions that are not periodic.

use super::space::{MAX_ORDER, Space};
use super::{Surface, Trimmed};
use crate::error::Result;
use crate::shape::{BoundaryEdge, Edges, Stencil, Strip, no_edge};

/// Names of the four sides, whether `u` runs along them, and whether they are at an end.
const SIDES: [(&str, bool, bool); 4] =
    [("u0", false, false), ("u1", false, true), ("v0", true, false), ("v1", true, true)];

impl Surface {
    /// The spaces along and across an edge.
    fn run_and_across(&self, along_u: bool) -> (&Space, &Space) {
        if along_u { (self.u(), self.v()) } else { (self.v(), self.u()) }
    }
}

impl Edges for Surface {
    fn count(&self) -> usize {
        2 * (usize::from(!self.u().is_periodic()) + usize::from(!self.v().is_periodic()))
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        let open = |(_, along_u, _): &&(&str, bool, bool)| !self.run_and_across(*along_u).1.is_periodic();
        let &(name, along_u, at_end) = SIDES.iter().filter(open).nth(index)?;
        let (run, across) = self.run_and_across(along_u);
        let ((start, end), (low, high)) = (run.domain(), across.domain());
        let fixed = if at_end { high } else { low };
        Some(BoundaryEdge {
            face: None,
            name: name.into(),
            along_u,
            start,
            end,
            periodic: run.is_periodic(),
            fixed,
            at_end,
        })
    }

    /// `∂ᵏ(w S) = Σ_j M_j(t) Σ_i N_i^(k) w_ij P_ij`: exact, in the space along the edge.
    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        let Some(edge) = self.edge(index) else { return Some(Err(no_edge(self, index, Edges::count(self)))) };
        let (run, across) = self.run_and_across(edge.along_u);
        let (p, columns) = (across.degree(), self.v().len());
        let span = across.span(edge.fixed);
        let heaviest = self.weights().map_or(1.0, |w| w.iter().fold(0.0, |m: f64, w| m.max(*w)));
        let weight = |vertex: usize| self.weights().map_or(1.0, |w| w[vertex] / heaviest);
        let strip = |k: usize| {
            let mut row = [0.0; MAX_ORDER];
            across.basis_into(span, edge.fixed, k, &mut row);
            let terms: Vec<(usize, f64)> =
                (0..=p).map(|i| (across.vertex(span - p + i), row[i])).filter(|(_, c)| *c != 0.0).collect();
            let coefficient = |along: usize| -> Stencil {
                let term = |&(i, c): &(usize, f64)| {
                    let vertex = if edge.along_u { along * columns + i } else { i * columns + along };
                    (vertex, c * weight(vertex))
                };
                terms.iter().map(term).collect()
            };
            let largest = terms.iter().fold(0.0, |m: f64, (_, c)| m.max(c.abs()));
            Strip { space: run.clone(), coefficients: (0..run.len()).map(coefficient).collect(), largest }
        };
        Some(Ok((0..=order).map(strip).collect()))
    }
}

/// Those of the surface that carries it, for one without loops; see [`Shape::edges`](crate::shape::Shape::edges).
impl Edges for Trimmed {
    fn count(&self) -> usize {
        Edges::count(self.surface())
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        self.surface().edge(index)
    }

    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        self.surface().strips(index, order)
    }
}
