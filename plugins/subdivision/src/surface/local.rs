//! A face with the faces round it, refined where a place is: as rows over the vertices of its neighbourhood.

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::shape::Stencil;

use super::regular;
use crate::cage::{BoundaryRule, Cage, decayed};
use crate::catmull_clark::{limit_stencils, sectors, weights::Weights};
use crate::error::{Result, SubdivisionError};
use crate::frame::LimitStencils;
use crate::row::Sum;
use crate::topology::{NONE, Topology};

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
}

impl Local {
    /// A face of a cage as it is.
    pub(super) fn new(cage: &Cage, part: &Part) -> Result<Self> {
        let width = part.kept.len();
        let mut rows = vec![0.0; width * width];
        rows.iter_mut().step_by(width + 1).for_each(|c| *c = 1.0);
        let small = part.cage(cage.topology(), |e| cage.crease(e), |v| cage.corner(v), cage.boundary())?;
        Ok(Self { cage: small, width, rows })
    }

    /// The refined face at a corner, with what is round it; its first corner is number `start` of corner, edge that follows, middle,
    /// edge before. Cost: the number of vertices round it times the length of a row.
    pub(super) fn refined(&self, corner: usize, start: usize) -> Result<Self> {
        let (cage, width) = (&self.cage, self.width);
        let topology = cage.topology();
        let split = topology.split()?;
        let part = Part::new(&split, topology.face_corners(0).start + corner, start)?;
        let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
        let mut faces = vec![0.0; topology.face_count() * width];
        for (face, row) in faces.chunks_exact_mut(width).enumerate() {
            let corners = topology.face(face);
            let share = 1.0 / corners.len() as f64;
            corners.iter().for_each(|&v| add(row, self.row(v as usize), share));
        }
        let weights = Weights::new(cage);
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
        let crease = |e: usize| if e < 2 * edges { decayed(cage.crease(e / 2)) } else { 0.0 };
        let sharp = |v: usize| if v < vertices { decayed(cage.corner(v)) } else { 0.0 };
        let small = part.cage(&split, crease, sharp, cage.boundary())?;
        Ok(Self { cage: small, width, rows })
    }

    /// The number of vertices that rows are over.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The face and those round it: a cage without points.
    pub(super) fn cage(&self) -> &Cage {
        &self.cage
    }

    /// The row of a vertex of [`cage`](Self::cage).
    pub(super) fn row(&self, vertex: usize) -> &[f64] {
        &self.rows[vertex * self.width..(vertex + 1) * self.width]
    }

    /// For each vertex that rows are over the 16 numbers by which it counts in the vertices of the bicubic net; `None` where the face is
    /// not regular.
    pub(super) fn net(&self) -> Option<Vec<[f64; 16]>> {
        let net = regular::net(&self.cage, 0)?;
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

/// Which faces and vertices are round a face, in an order that follows from how they hang together alone: whatever their numbers in the
/// whole, faces with the same surroundings have the same part.
#[derive(Debug)]
pub(super) struct Part {
    /// Corners of the whole, face after face, the face itself first.
    halves: Vec<u32>,
    starts: Vec<usize>,
    /// The vertices of the whole that are kept, in the order in which the corners come to them.
    pub(super) kept: Vec<u32>,
    /// The number among these of the vertex at each corner.
    corners: Vec<u32>,
}

impl Part {
    /// Round a face, from its corner `start` on. Cost: the corners of the faces there.
    pub(super) fn new(topology: &Topology, face: usize, start: usize) -> Result<Self> {
        let own = topology.face_corners(face);
        let size = own.len();
        let mut halves: Vec<u32> =
            (0..size).map(|k| (own.start + (start + k) % size.max(1)) as u32).collect();
        let mut starts = vec![0, size];
        for first in firsts(&round(topology, &halves), |h| topology.face_of(h)) {
            if topology.face_of(first) as usize == face {
                continue;
            }
            let mut half = first;
            loop {
                halves.push(half);
                half = topology.next(half);
                if half == first {
                    break;
                }
            }
            starts.push(halves.len());
        }
        let part = Self::numbered(topology, halves, starts);
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

    /// Faces, in their order, with all that share a vertex with one of them. Cost: the corners of the faces there.
    pub(super) fn of_faces(topology: &Topology, faces: &[usize]) -> Self {
        let own: Vec<u32> = faces.iter().flat_map(|&f| topology.face_corners(f).map(|h| h as u32)).collect();
        let round = own.iter().flat_map(|&h| topology.vertex_faces(topology.origin(h) as usize));
        let all: Vec<u32> = faces.iter().map(|&f| f as u32).chain(round).collect();
        let (mut halves, mut starts) = (Vec::new(), vec![0]);
        for face in firsts(&all, |f| f) {
            halves.extend(topology.face_corners(face as usize).map(|h| h as u32));
            starts.push(halves.len());
        }
        Self::numbered(topology, halves, starts)
    }

    /// With its vertices numbered.
    fn numbered(topology: &Topology, halves: Vec<u32>, starts: Vec<usize>) -> Self {
        let vertices: Vec<u32> = halves.iter().map(|&h| topology.origin(h)).collect();
        let kept = firsts(&vertices, |v| v);
        let mut places: Vec<(u32, u32)> = kept.iter().zip(0..).map(|(&v, k)| (v, k)).collect();
        places.sort_unstable();
        let place = |v: &u32| match places.binary_search_by_key(v, |p| p.0) {
            Ok(at) => places[at].1,
            Err(_) => 0,
        };
        let corners = vertices.iter().map(place).collect();
        Self { halves, starts, kept, corners }
    }

    /// The part as a cage of its own, with the points and the sharpness of the whole; no holes.
    pub(super) fn to_cage(&self, whole: &Cage) -> Result<Cage> {
        let (crease, corner) = (|e| whole.crease(e), |v| whole.corner(v));
        let mut cage = self.cage(whole.topology(), crease, corner, whole.boundary())?;
        cage.points = self.kept.iter().map(|&v| whole.points()[v as usize]).collect();
        Ok(cage)
    }

    /// All that rows round the face depend on, as numbers: equal where these are equal.
    pub(super) fn key(&self, cage: &Cage) -> Vec<u32> {
        let mut key = vec![u32::from(cage.boundary() == BoundaryRule::EdgeOnly), self.starts.len() as u32];
        key.extend(self.starts.iter().map(|&s| s as u32));
        key.extend_from_slice(&self.corners);
        let mut say = |at: usize, sharpness: f64| {
            if sharpness > 0.0 {
                let bits = sharpness.to_bits();
                key.extend([at as u32, (bits >> 32) as u32, bits as u32]);
            }
        };
        for (k, &h) in self.halves.iter().enumerate() {
            say(k, cage.crease(cage.topology().edge_of(h) as usize));
        }
        for (k, &v) in self.kept.iter().enumerate() {
            say(k + self.halves.len(), cage.corner(v as usize));
        }
        key
    }

    /// The small cage, with the sharpness that the whole has.
    fn cage(
        &self,
        whole: &Topology,
        crease: impl Fn(usize) -> f64,
        corner: impl Fn(usize) -> f64,
        boundary: BoundaryRule,
    ) -> Result<Cage> {
        let topology = Topology::part(self.kept.len(), self.corners.clone(), &self.starts)?;
        let points = vec![Point::origin(); self.kept.len()];
        let mut cage = Cage::from_topology(points, Arc::new(topology))?.with_boundary(boundary);
        for (k, &h) in self.halves.iter().enumerate() {
            let sharpness = crease(whole.edge_of(h) as usize);
            if sharpness > 0.0 {
                cage.creases.resize(cage.topology.edge_count(), 0.0);
                let edge = cage.topology.edge_of(k as u32) as usize;
                cage.creases[edge] = sharpness;
            }
        }
        let corners: Vec<f64> = self.kept.iter().map(|&v| corner(v as usize)).collect();
        if corners.iter().any(|&s| s > 0.0) {
            cage.corners = corners;
        }
        Ok(cage)
    }
}

/// The half-edges that leave the corners of a face, into all faces that share a corner with it: corner after corner, counterclockwise as
/// far as there are faces, then clockwise.
fn round(topology: &Topology, corners: &[u32]) -> Vec<u32> {
    let mut all = Vec::new();
    for &own in corners {
        let mut half = topology.twin(topology.previous(own));
        while half != own && half != NONE {
            all.push(half);
            half = topology.twin(topology.previous(half));
        }
        if half == NONE {
            let mut twin = topology.twin(own);
            while twin != NONE {
                half = topology.next(twin);
                all.push(half);
                twin = topology.twin(half);
            }
        }
    }
    all
}

/// Of those with the same name the first, in their order.
fn firsts(all: &[u32], name: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut sorted: Vec<(u32, usize)> = all.iter().enumerate().map(|(k, &x)| (name(x), k)).collect();
    sorted.sort_unstable();
    sorted.dedup_by_key(|pair| pair.0);
    let mut places: Vec<usize> = sorted.into_iter().map(|pair| pair.1).collect();
    places.sort_unstable();
    places.into_iter().map(|k| all[k]).collect()
}
