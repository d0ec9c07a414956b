//! A face with the faces round it, refined where a place is: as rows over the vertices of its neighbourhood.

use loftsman_kernel::shape::Stencil;

use super::regular;
use crate::cage::{Cage, decayed};
use crate::catmull_clark::weights::{Weights, beyond_of};
use crate::catmull_clark::{limit_stencils, refined_intervals, sectors};
use crate::error::{Result, SubdivisionError};
use crate::frame::LimitStencils;
use crate::part::{Part, Said};
use crate::row::Sum;
use crate::topology::Topology;

/// Vertices round one face, at most: rows over them are kept densely, so that this many take 32 MB.
pub(super) const MOST: usize = 2048;

/// A face, number 0 of a small cage, with all faces that share a vertex with it, and what each vertex is made of.
#[derive(Debug)]
pub(super) struct Local {
    cage: Cage,
    /// The number of vertices of the face's neighbourhood in the whole cage, which rows are over: those of its [`Part`], in that order.
    width: usize,
    /// One row after another, each as long.
    rows: Vec<f64>,
    /// What is beyond the ends of edges, with knot intervals: on the rim it is not there to be seen.
    beyond: Vec<[f64; 2]>,
}

impl Local {
    /// A face of a cage as it is, and what is [beyond](Part::beyond) the edges of its part.
    pub(super) fn new(cage: &Cage, part: &Part, beyond: &[[f64; 2]]) -> Result<Self> {
        let width = part.kept.len();
        let mut rows = vec![0.0; width * width];
        rows.iter_mut().step_by(width + 1).for_each(|c| *c = 1.0);
        let interval = |e| cage.interval(e);
        let said = Said {
            crease: &|e| cage.crease(e),
            corner: &|v| cage.corner(v),
            interval: cage.has_intervals().then_some(&interval as &dyn Fn(usize) -> f64),
        };
        let small = part.cage(cage.topology(), &said, cage.boundary())?;
        let beyond = if cage.has_intervals() { Part::by_edge(small.topology(), beyond) } else { Vec::new() };
        Ok(Self { cage: small, width, rows, beyond })
    }

    /// The refined face at a corner, with what is round it; its first corner is number `start` of corner, edge that follows, middle,
    /// edge before. Cost: the number of vertices round it times the length of a row.
    pub(super) fn refined(&self, corner: usize, start: usize) -> Result<Self> {
        let (cage, width) = (&self.cage, self.width);
        let topology = cage.topology();
        let split = topology.split()?;
        let part = around(&split, topology.face_corners(0).start + corner, start)?;
        let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
        let mut faces = vec![0.0; topology.face_count() * width];
        let weights = Weights::with_beyond(cage, self.beyond.clone());
        for (face, row) in faces.chunks_exact_mut(width).enumerate() {
            if cage.has_intervals() {
                weights.face(face, |v, share| add(row, self.row(v as usize), share));
                continue;
            }
            let corners = topology.face(face);
            let share = 1.0 / corners.len() as f64;
            corners.iter().for_each(|&v| add(row, self.row(v as usize), share));
        }
        let mut rows = vec![0.0; part.kept.len() * width];
        for (&child, row) in part.kept.iter().zip(rows.chunks_exact_mut(width)) {
            let child = child as usize;
            let mut sum = Dense { vertices: &self.rows, faces: &faces, row };
            if child < vertices {
                weights.vertex(child, &mut sum);
            } else if child < vertices + edges {
                weights.edge(child - vertices, &mut sum);
            } else {
                sum.face((child - vertices - edges) as u32, 1.0);
            }
        }
        if cage.has_intervals() {
            return self.by_intervals(split, &part, rows);
        }
        let said = Said {
            crease: &|e| if e < 2 * edges { decayed(cage.crease(e / 2)) } else { 0.0 },
            corner: &|v| if v < vertices { decayed(cage.corner(v)) } else { 0.0 },
            interval: None,
        };
        let small = part.cage(&split, &said, cage.boundary())?;
        Ok(Self { cage: small, width, rows, beyond: Vec::new() })
    }

    /// A part of the refined neighbourhood with its knot intervals. These are doubled, for only their ratios count.
    fn by_intervals(&self, split: Topology, part: &Part, rows: Vec<f64>) -> Result<Self> {
        let cage = &self.cage;
        let (vertices, edges) = (cage.topology().vertex_count(), cage.topology().edge_count());
        let fine = Cage {
            points: Vec::new(),
            creases: (0..2 * edges).map(|e| decayed(cage.crease(e / 2))).collect(),
            corners: (0..vertices).map(|v| decayed(cage.corner(v))).collect(),
            holes: Vec::new(),
            intervals: refined_intervals(cage).into_iter().map(|d| 2.0 * d).collect(),
            end_intervals: Vec::new(),
            boundary: cage.boundary(),
            topology: split.into(),
        };
        let small = Self::new(&fine, part, &part.beyond(fine.topology(), |e| beyond_of(&fine, e)))?;
        Ok(Self { width: self.width, rows, ..small })
    }

    /// The count of all numbers that it holds, about.
    pub(super) fn numbers(&self) -> usize {
        // What is said of a vertex and of its edges and faces is some forty numbers.
        self.rows.len() + 40 * self.cage.topology().vertex_count()
    }

    /// The face and those round it: a cage without points.
    pub(super) fn cage(&self) -> &Cage {
        &self.cage
    }

    /// What is beyond the ends of an edge of [`cage`](Self::cage), where there are knot intervals.
    pub(super) fn beyond(&self, edge: usize) -> [f64; 2] {
        self.beyond.get(edge).copied().unwrap_or_default()
    }

    /// The row of a vertex of [`cage`](Self::cage).
    pub(super) fn row(&self, vertex: usize) -> &[f64] {
        &self.rows[vertex * self.width..(vertex + 1) * self.width]
    }

    /// For each vertex that rows are over the 16 numbers by which it counts in the vertices of the bicubic net; `None` where the face is
    /// not regular.
    pub(super) fn net(&self) -> Option<Vec<[f64; 16]>> {
        let net = regular::net_by(&self.cage, 0, &|e| self.beyond[e])?;
        let mut columns = vec![[0.0; 16]; self.width];
        for (place, row) in net.iter().enumerate() {
            for &(v, weight) in row {
                columns
                    .iter_mut()
                    .zip(self.row(v as usize))
                    .for_each(|(column, c)| column[place] += weight * c);
            }
        }
        Some(columns)
    }

    /// The limit of a corner of the face, as rows over the neighbourhood: its point, and its tangents along `u` and `v` of the face, in the face's sector.
    ///
    /// At a smooth vertex and at a corner these are along the face's edges; elsewhere they span the tangent plane.
    pub(super) fn limit(&self, corner: usize) -> Result<LimitStencils> {
        let topology = self.cage.topology();
        let half = topology.face_corners(0).start + corner;
        let vertex = topology.face(0)[corner] as usize;
        let place = topology.around(vertex).position(|h| h as usize == half).unwrap_or(0);
        let sides = sectors(&self.cage, vertex)?;
        let lasting = self.lasting(vertex);
        let is_corner = lasting.len() > 2 || self.cage.vertex_sharpness(vertex) >= crate::INFINITELY_SHARP;
        let sector = match lasting[..] {
            [a, b] if !is_corner => usize::from(sides > 1 && !(a..b).contains(&place)),
            _ => {
                if sides > 1 {
                    place
                } else {
                    0
                }
            }
        };
        let limit = limit_stencils(&self.cage, vertex, sector)?;
        let [a, b] = limit.tangents.map(|t| self.back(&t));
        let position = self.back(&limit.position);
        let [along, before] = if lasting.is_empty() && !is_corner {
            // The first wave is along edge 0; the others are turned from it.
            let n = topology.around(vertex).count() as f64;
            [place, place + 1].map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / n).sin_cos();
                mixed(&a, cos, &b, sin)
            })
        } else {
            [a, b]
        };
        let tangents = match corner {
            0 => [along, before],
            1 => [before.scaled(-1.0), along],
            2 => [along.scaled(-1.0), before.scaled(-1.0)],
            _ => [before, along.scaled(-1.0)],
        };
        Ok(LimitStencils { position, tangents })
    }

    /// The places of the infinitely sharp edges round a vertex.
    fn lasting(&self, vertex: usize) -> Vec<usize> {
        let edges = self.cage.topology().vertex_edges(vertex).enumerate();
        edges
            .filter(|(_, e)| self.cage.sharpness(*e as usize) >= crate::INFINITELY_SHARP)
            .map(|(k, _)| k)
            .collect()
    }

    /// A row over the small cage as one over the neighbourhood.
    fn back(&self, stencil: &Stencil) -> Stencil {
        let mut sum = vec![0.0; self.width];
        stencil.iter().for_each(|(v, c)| add(&mut sum, self.row(v), c));
        sum.into_iter().enumerate().filter(|(_, c)| *c != 0.0).collect()
    }
}

fn mixed(a: &Stencil, x: f64, b: &Stencil, y: f64) -> Stencil {
    a.iter().map(|(v, c)| (v, c * x)).chain(b.iter().map(|(v, c)| (v, c * y))).collect()
}

/// `sum += by row`.
fn add(sum: &mut [f64], row: &[f64], by: f64) {
    sum.iter_mut().zip(row).for_each(|(s, c)| *s += by * c);
}

/// A sum of rows.
struct Dense<'a> {
    vertices: &'a [f64],
    faces: &'a [f64],
    row: &'a mut [f64],
}

impl Sum for Dense<'_> {
    fn vertex(&mut self, vertex: u32, weight: f64) {
        let width = self.row.len();
        add(self.row, &self.vertices[vertex as usize * width..], weight);
    }

    fn face(&mut self, face: u32, weight: f64) {
        let width = self.row.len();
        add(self.row, &self.faces[face as usize * width..], weight);
    }
}

/// A face with those round it, if these are not too many to be looked at.
pub(super) fn around(topology: &Topology, face: usize, start: usize) -> Result<Part> {
    let part = Part::around_face(topology, face, start);
    if part.kept.len() > MOST {
        let problem = format!(
            "has {} vertices in the faces round it, and at most {MOST} can be looked at: refine the cage, or divide its largest \
             faces and fans",
            part.kept.len()
        );
        return Err(SubdivisionError::Face { face, problem });
    }
    Ok(part)
}
