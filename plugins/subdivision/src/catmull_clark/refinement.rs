//! A cage and all that it is refined to.

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, parallel};

use super::refine::{refine, refined_points};
use super::weights::{Rows, Weights};
use crate::cage::{Cage, present};
use crate::error::{Result, SubdivisionError};
use crate::row::{Row, Sum};

/// A cage and what becomes of it in a number of refinements, with the way back: from which face of the cage a face comes, and of
/// which of its vertices a vertex is made.
#[derive(Debug, Clone)]
pub struct Refinement {
    /// The cage itself, and one for each level.
    levels: Vec<Cage>,
}

impl Refinement {
    /// The cage refined so many times. Cost: linear in the finest.
    ///
    /// # Errors
    /// As for [`refine`].
    pub fn new(cage: Cage, levels: usize) -> Result<Self> {
        let mut all = vec![cage];
        for _ in 0..levels {
            if let Some(last) = all.last() {
                all.push(refine(last)?);
            }
        }
        Ok(Self { levels: all })
    }

    /// The cage and its refinements: level 0 is the cage.
    pub fn levels(&self) -> &[Cage] {
        &self.levels
    }

    /// The finest level.
    pub fn finest(&self) -> &Cage {
        &self.levels[self.levels.len() - 1]
    }

    /// Moves the vertices of the cage, and with them those of all levels. Cost: linear, a fraction of [`new`](Self::new).
    ///
    /// # Errors
    /// When there are not as many points as vertices of the cage, or a coordinate is not finite.
    pub fn move_to(&mut self, points: Vec<Point>) -> Result<()> {
        let topology = self.levels[0].topology.clone();
        self.levels[0].points = Cage::from_topology(points, topology)?.points;
        for k in 1..self.levels.len() {
            self.levels[k].points = refined_points(&self.levels[k - 1]);
        }
        Ok(())
    }

    fn check(&self, level: usize) -> Result<&Cage> {
        let count = self.levels.len();
        self.levels.get(level).ok_or(SubdivisionError::Missing { what: "level", index: level, count })
    }

    /// The face of the cage that a face of a level comes from. Cost: the level.
    ///
    /// # Errors
    /// When there is no such level or face.
    pub fn base_face(&self, level: usize, face: usize) -> Result<usize> {
        present("face", face, self.check(level)?.topology().face_count())?;
        Ok(self.levels[..level]
            .iter()
            .rfold(face, |corner, parent| parent.topology().face_of(corner as u32) as usize))
    }

    /// The vertices of the cage that a vertex of a level is made of, and how much of each. Cost: the level times the size of the
    /// neighbourhood.
    ///
    /// # Errors
    /// When there is no such level or vertex.
    pub fn stencil(&self, level: usize, vertex: usize) -> Result<Stencil> {
        present("vertex", vertex, self.check(level)?.points.len())?;
        let weights: Vec<Weights> = self.levels[..level].iter().map(Weights::new).collect();
        Ok(back(&weights, vertex).into_stencil())
    }

    /// The [stencils](Self::stencil) of all vertices of a level, in parallel with the feature `parallel`.
    ///
    /// # Errors
    /// When there is no such level.
    pub fn stencils(&self, level: usize) -> Result<Vec<Stencil>> {
        let count = self.check(level)?.points.len();
        let weights: Vec<Weights> = self.levels[..level].iter().map(Weights::new).collect();
        Ok(parallel::map(count, |vertex| back(&weights, vertex).into_stencil()))
    }
}

/// The row of a vertex of the last level, taken back level by level.
fn back(levels: &[Weights], vertex: usize) -> Row {
    let mut row = Row(vec![(vertex as u32, 1.0)]);
    for weights in levels.iter().rev() {
        row = parent(weights, &row);
    }
    row
}

/// What a row over the vertices of a refined cage is over those of its parent.
pub(super) fn parent(weights: &Weights, row: &Row) -> Row {
    let topology = weights.cage.topology();
    let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
    let mut rows = Rows { weights, row: Row::default(), factor: 1.0 };
    for &(child, weight) in &row.0 {
        rows.factor = weight;
        match child as usize {
            v if v < vertices => weights.vertex(v, &mut rows),
            e if e < vertices + edges => weights.edge(e - vertices, &mut rows),
            f => rows.face((f - vertices - edges) as u32, 1.0),
        }
    }
    rows.row.tidy();
    rows.row
}
