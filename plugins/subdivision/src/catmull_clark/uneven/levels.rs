//! The faces round a vertex, refined until the weights stay what they are.

use crate::cage::{Cage, decayed};
use crate::catmull_clark::refine::refined_intervals;
use crate::catmull_clark::weights::{Rows, Weights};
use crate::eigen::{Matrix, times};
use crate::error::{Result, SubdivisionError};
use crate::part::{Part, Said};
use crate::row::Row;

/// Intervals across come nearer to those along an edge by half each level: after so many they are the same to rounding.
const MOST: usize = 80;

/// The matrices that refine the ring of a vertex: the vertex itself, its neighbours along edges, the vertices across its faces, all
/// counterclockwise.
pub(super) struct Levels {
    /// The ring of level 1 over the vertices of the cage.
    first: Vec<Row>,
    /// Level after level; the last stands for all that would follow.
    rest: Vec<Matrix>,
    edges: usize,
}

impl Levels {
    /// Cost: the size of the neighbourhood for each of some fifty levels; three where it is a grid but for the vertex.
    ///
    /// # Errors
    /// When 32 bits cannot count what would be there; when weights do not settle.
    pub(super) fn new(cage: &Cage, vertex: usize) -> Result<Self> {
        let mut local = Local::new(cage, vertex)?;
        let edges = cage.topology().valence(vertex);
        let first = local.ring_rows(|v| local.names[v as usize]);
        let mut rest: Vec<Matrix> = Vec::new();
        while rest.len() < MOST {
            local = local.refined()?;
            let ring = local.ring();
            let mut place = vec![u32::MAX; local.names.len()];
            ring.iter().enumerate().for_each(|(at, v)| place[*v as usize] = at as u32);
            let next: Matrix = local.ring_rows(|v| place[v as usize]).into_iter().map(|row| row.0).collect();
            let settled =
                rest.len() > 2 && !local.is_semi_sharp() && rest.last().is_some_and(|m| same(m, &next));
            if settled {
                return Ok(Self { first, rest, edges });
            }
            rest.push(next);
        }
        let problem = format!(
            "has weights that still change after {MOST} refinements: bring its knot intervals nearer to each other"
        );
        Err(SubdivisionError::Vertex { vertex, problem })
    }

    /// The matrix that all levels come to.
    pub(super) fn last(&self) -> &Matrix {
        &self.rest[self.rest.len() - 1]
    }

    /// Those before it, the finest first.
    pub(super) fn before(&self) -> impl Iterator<Item = &Matrix> {
        self.rest[..self.rest.len() - 1].iter().rev()
    }

    /// The number of edges at the vertex.
    pub(super) fn edges(&self) -> usize {
        self.edges
    }

    /// A row over the ring of the last level as one over the cage.
    pub(super) fn back(&self, row: &[f64]) -> Row {
        self.first(&self.before().fold(row.to_vec(), |row, matrix| times(&row, matrix)))
    }

    /// A row over the ring of level 1 as one over the cage.
    pub(super) fn first(&self, row: &[f64]) -> Row {
        let mut sum = Row::default();
        for (weight, of) in row.iter().zip(&self.first) {
            of.0.iter().for_each(|&(v, c)| sum.add(v, weight * c));
        }
        sum.tidy();
        sum
    }
}

/// Whether two matrices are the same to rounding.
fn same(a: &Matrix, b: &Matrix) -> bool {
    let dense = |row: &[(u32, f64)]| {
        let mut all = vec![0.0; a.len()];
        row.iter().for_each(|&(k, c)| all[k as usize] += c);
        all
    };
    a.iter()
        .zip(b)
        .all(|(a, b)| dense(a).iter().zip(dense(b)).all(|(x, y)| (x - y).abs() <= 2.0 * f64::EPSILON))
}

/// The faces at a vertex and those round them as a cage of their own.
pub(in crate::catmull_clark) struct Local {
    pub(in crate::catmull_clark) cage: Cage,
    pub(in crate::catmull_clark) vertex: usize,
    /// What the vertices are called in the cage that this was taken out of.
    pub(in crate::catmull_clark) names: Vec<u32>,
}

impl Local {
    pub(in crate::catmull_clark) fn new(cage: &Cage, vertex: usize) -> Result<Self> {
        let said = Said {
            crease: &|e| cage.crease(e),
            corner: &|v| cage.corner(v),
            interval: Some(&|e| cage.interval(e)),
        };
        let part = Part::around_vertex(cage.topology(), vertex);
        let small = part.cage(cage.topology(), &said, cage.boundary())?;
        Ok(Self { cage: small, vertex: part.place(vertex as u32) as usize, names: part.kept })
    }

    /// The same of the refined cage. Intervals are doubled, for only their ratios count.
    fn refined(&self) -> Result<Self> {
        let (cage, topology) = (&self.cage, self.cage.topology());
        let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
        let split = topology.split()?;
        let intervals = refined_intervals(cage);
        let said = Said {
            crease: &|e| if e < 2 * edges { decayed(cage.crease(e / 2)) } else { 0.0 },
            corner: &|v| if v < vertices { decayed(cage.corner(v)) } else { 0.0 },
            interval: Some(&|e| 2.0 * intervals[e]),
        };
        let part = Part::around_vertex(&split, self.vertex);
        let small = part.cage(&split, &said, cage.boundary())?;
        Ok(Self { cage: small, vertex: part.place(self.vertex as u32) as usize, names: part.kept })
    }

    /// The vertex, its neighbours and the vertices across its quads.
    fn ring(&self) -> Vec<u32> {
        let (topology, vertex) = (self.cage.topology(), self.vertex);
        let near = topology.vertex_edges(vertex).map(|e| topology.other_end(e, vertex) as u32);
        let far = topology.around(vertex).map(|h| topology.origin(topology.next(topology.next(h))));
        std::iter::once(self.vertex as u32).chain(near).chain(far).collect()
    }

    /// What the ring of the next level is made of.
    fn ring_rows(&self, name: impl Fn(u32) -> u32) -> Vec<Row> {
        let (topology, vertex) = (self.cage.topology(), self.vertex);
        let weights = Weights::new(&self.cage);
        let row = |add: &dyn Fn(&mut Rows<'_>)| {
            let mut rows = Rows { weights: &weights, row: Row::default(), factor: 1.0 };
            add(&mut rows);
            rows.row.0.iter_mut().for_each(|(v, _)| *v = name(*v));
            rows.row.tidy();
            rows.row
        };
        let mut all = vec![row(&|rows| weights.vertex(vertex, rows))];
        all.extend(topology.vertex_edges(vertex).map(|e| row(&|rows| weights.edge(e as usize, rows))));
        all.extend(
            topology
                .vertex_faces(vertex)
                .map(|f| row(&|rows| weights.face(f as usize, |v, c| rows.row.add(v, c)))),
        );
        all
    }

    /// Whether anything round the vertex is sharp for some levels only.
    fn is_semi_sharp(&self) -> bool {
        let finite = |s: f64| s > 0.0 && s < crate::INFINITELY_SHARP;
        self.cage.creases.iter().chain(&self.cage.corners).any(|&s| finite(s))
    }
}
