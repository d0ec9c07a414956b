//! The boundary of a surface.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{BoundaryEdge, Derivative, Edges, Shape, Stencil, Strip};
use loftsman_kernel::space::Space;

use super::leaf::leaf;
use super::pattern::Quadrant;
use super::{SubdivisionSurface, refused};
use crate::topology::NONE;

/// The sides of faces that have nothing, or a hole, beyond them. An edge of the cage is one, but of a face that is no quad two: halves.
/// Its name is that of its two vertices, `"3-7"`, and of a half `"3-7 first"` or `"3-7 second"`, in the direction in which the face
/// runs.
impl Edges for SubdivisionSurface {
    fn count(&self) -> usize {
        self.layout.edges.len()
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        let &(face, side) = self.layout.edges.get(index)?;
        let [of, corner] = self.layout.faces[face as usize];
        let topology = self.cage.topology();
        let vertices = topology.face(of as usize);
        let count = vertices.len();
        let pair = |from: usize| (vertices[from % count], vertices[(from + 1) % count]);
        let name = match (corner, side) {
            (NONE, _) => {
                let (a, b) = pair(side as usize);
                format!("{a}-{b}")
            }
            (_, 0) => {
                let (a, b) = pair(corner as usize);
                format!("{a}-{b} first")
            }
            _ => {
                let (a, b) = pair(corner as usize + count - 1);
                format!("{a}-{b} second")
            }
        };
        let at_end = matches!(side, 1 | 2);
        Some(BoundaryEdge {
            name: name.into(),
            face: Some(face),
            along_u: side.is_multiple_of(2),
            start: 0.0,
            end: 1.0,
            periodic: false,
            fixed: if at_end { 1.0 } else { 0.0 },
            at_end,
        })
    }

    /// One cubic, where the face is regular, or one is all that the edge itself is.
    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        let &(face, side) = self.layout.edges.get(index)?;
        let edge = self.edge(index)?;
        let pattern = self.layout.pattern(face as usize);
        if pattern.is_regular(Quadrant::WHOLE) {
            return Some(self.regular(face as usize, side as usize, order));
        }
        let ends =
            [side as usize, (side as usize + 1) % 4].map(|corner| pattern.corners[corner].extraordinary);
        // Where neither end is extraordinary, the cells along it are as many as there are: it follows from them.
        ends.contains(&true).then(|| self.irregular(&edge, order))
    }
}

impl SubdivisionSurface {
    fn regular(&self, face: usize, side: usize, order: usize) -> Result<Vec<Strip>> {
        let found = leaf(&self.cage, &self.layout, face, (0.5, 0.5), 0).map_err(refused)?;
        let leaf = found.ok_or_else(|| Error::Invalid(format!("face {face} is not regular")))?;
        let space = Space::floating_uniform(3, 4)?;
        let strip = |k: usize| {
            let (rows, largest) = leaf.strip(side, k);
            Strip { space: space.clone(), coefficients: rows.to_vec(), largest }
        };
        Ok((0..=order).map(strip).collect())
    }

    /// The edge itself as a cubic, checked at two places more than make it one. Derivatives across it are no splines: there are
    /// infinitely many pieces along it.
    fn irregular(&self, edge: &BoundaryEdge, order: usize) -> Result<Vec<Strip>> {
        let wrong = |what: &str| {
            Err(Error::Invalid(format!(
                "{} ends at an extraordinary vertex: {what}; join places of it one by one, or refine the cage and join the half away from \
                 that vertex",
                edge.called()
            )))
        };
        if order > 0 {
            return wrong("derivatives across it are no spline along it");
        }
        let row = |t: f64| self.stencil(edge.at(t), Derivative::POSITION);
        let places = [row(0.0)?, row(1.0 / 3.0)?, row(2.0 / 3.0)?, row(1.0)?];
        let combined = |c: [f64; 4]| -> Stencil {
            places.iter().zip(c).flat_map(|(s, w)| s.iter().map(move |(v, c)| (v, w * c))).collect()
        };
        let bernstein = vec![
            combined([1.0, 0.0, 0.0, 0.0]),
            combined([-5.0 / 6.0, 3.0, -1.5, 1.0 / 3.0]),
            combined([1.0 / 3.0, -1.5, 3.0, -5.0 / 6.0]),
            combined([0.0, 0.0, 0.0, 1.0]),
        ];
        for t in [0.21_f64, 0.83] {
            let s = 1.0 - t;
            let b = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let own = row(t)?.scaled(-1.0);
            let mut sum: Stencil = own;
            bernstein.iter().zip(b).for_each(|(row, w)| row.iter().for_each(|(v, c)| sum.add(v, w * c)));
            if sum.coefficients().iter().any(|c| c.abs() > 1e-9) {
                return wrong("it is no one cubic");
            }
        }
        let space = Space::open(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])?;
        Ok(vec![Strip { space, coefficients: bernstein, largest: 1.0 }])
    }
}
