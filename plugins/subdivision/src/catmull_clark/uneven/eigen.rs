//! The tangents at a vertex, from the matrices that refine its ring.

use super::levels::Levels;
use crate::eigen::{Matrix, PLANE, invariant, normalise, orthonormalise, times, without};
use crate::row::Row;

/// The part of a ring on which the surface has tangents of its own.
pub(super) struct Sector {
    /// Edges in order, by their place round the vertex.
    edges: Vec<usize>,
    /// Faces in order; none where one face lies between two creases.
    faces: Vec<usize>,
    closed: bool,
    corner: bool,
}

impl Sector {
    /// All round a vertex.
    pub(super) fn whole(edges: usize) -> Self {
        Self { edges: (0..edges).collect(), faces: (0..edges).collect(), closed: true, corner: false }
    }

    /// So many faces between two edges of a crease. One face has no say in the tangents: they are those of the crease and of how it
    /// bends.
    pub(super) fn between(edges: usize, from: usize, count: usize) -> Self {
        let faces = if count > 1 { (0..count).map(|k| (from + k) % edges).collect() } else { Vec::new() };
        let all = if count > 1 {
            (0..=count).map(|k| (from + k) % edges).collect()
        } else {
            vec![from, (from + count) % edges]
        };
        Self { edges: all, faces, closed: false, corner: false }
    }

    /// A face at a corner.
    pub(super) fn corner(edges: usize, faces: usize, sector: usize) -> Self {
        let sector = sector % faces.max(1);
        Self { edges: vec![sector, (sector + 1) % edges], faces: Vec::new(), closed: false, corner: true }
    }

    /// Which numbers of a row over the ring of `edges` edges belong to it.
    fn places(&self, edges: usize) -> Vec<usize> {
        let faces = self.faces.iter().map(|k| 1 + edges + k);
        std::iter::once(0).chain(self.edges.iter().map(|k| 1 + k)).chain(faces).collect()
    }
}

/// The rows of two tangents, over the cage, the second to the left of the first: the left invariant plane of the two largest
/// eigenvalues below one. `None` where there is none.
pub(super) fn tangents(levels: &Levels, position: &[f64], sector: &Sector) -> Option<[Row; 2]> {
    let edges = levels.edges();
    let places = sector.places(edges);
    let mut plane = if sector.corner {
        along_edges(position.len(), sector)
    } else {
        let small = restricted(levels.last(), &places);
        let own: Vec<f64> = places.iter().map(|&k| position[k]).collect();
        let rows = invariant(&small, &own, start(small.len(), sector), |columns| area(columns, sector))?;
        rows.map(|row| {
            let mut all = vec![0.0; position.len()];
            places.iter().zip(row).for_each(|(&k, c)| all[k] = c);
            all
        })
    };
    // At every level what rounding left of the constant, which grows fastest, is taken out, and the two are kept apart.
    let mut constant = position.to_vec();
    for matrix in levels.before() {
        constant = times(&constant, matrix);
        plane = plane.map(|row| without(times(&row, matrix), &constant));
        if !sector.corner && !orthonormalise(&mut plane) {
            return None;
        }
        if sector.corner {
            plane.iter_mut().for_each(|row| {
                normalise(row);
            });
        }
    }
    let rows = plane.map(|row| levels.first(&row));
    rows.iter().all(|row| row.0.iter().any(|(_, c)| c.abs() > PLANE)).then_some(rows)
}

/// From the vertex along both edges of a corner.
fn along_edges(size: usize, sector: &Sector) -> [Vec<f64>; 2] {
    [0, 1].map(|k| {
        let mut row = vec![0.0; size];
        row[0] = -1.0;
        row[1 + sector.edges[k]] = 1.0;
        row
    })
}

/// The rows and columns at some places.
fn restricted(matrix: &Matrix, places: &[usize]) -> Matrix {
    let mut own = vec![None; matrix.len()];
    places.iter().enumerate().for_each(|(at, &k)| own[k] = Some(at as u32));
    let row = |&k: &usize| matrix[k].iter().filter_map(|&(c, w)| own[c as usize].map(|at| (at, w))).collect();
    places.iter().map(row).collect()
}

/// What the ends of the edges enclose.
fn area(columns: &[Vec<f64>; 2], sector: &Sector) -> f64 {
    let at = |k: usize| [0, 1].map(|c| columns[c][k] - columns[c][0]);
    let count = sector.edges.len();
    let turns = if sector.closed { count } else { count - 1 };
    let pairs = (0..turns).map(|k| (at(1 + k), at(1 + (k + 1) % count)));
    pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

/// A plane to start from: cosines and sines round the vertex, or along and across a sector.
fn start(size: usize, sector: &Sector) -> [Vec<f64>; 2] {
    let (count, faces) = (sector.edges.len(), sector.faces.len());
    let sweep = if sector.closed {
        std::f64::consts::TAU / count as f64
    } else {
        std::f64::consts::PI / (count - 1) as f64
    };
    let wave = |of: fn(f64) -> f64| {
        let mut row = vec![0.0; size];
        (0..count).for_each(|k| row[1 + k] = of(sweep * k as f64));
        (0..faces).for_each(|k| row[1 + count + k] = of(sweep * (k as f64 + 0.5)));
        row[0] = -row.iter().sum::<f64>();
        row
    };
    let mut rows = [wave(f64::cos), wave(f64::sin)];
    if faces == 0 {
        rows[1] = vec![-2.0, 1.0, 1.0];
    }
    rows
}
