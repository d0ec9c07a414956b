//! Left eigenvectors of the matrix that refines the ring of a vertex.

use super::levels::{Levels, Matrix, times};
use crate::row::Row;

/// Multiplications after which a vertex is said to come to no point, or to have no tangent plane.
const MOST: usize = 20_000;
/// What changes by no more than this is looked on as found, and multiplied as often again: the error is then its square.
const NEARLY: f64 = 4e-15;
/// The part of a second tangent beside the first below which there is none but by rounding.
const PLANE: f64 = 1e-12;

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

/// The row of the limit: what `e M^k` comes to for the row `e` of the vertex itself.
pub(super) fn position(matrix: &Matrix) -> Option<Vec<f64>> {
    let mut row = vec![0.0; matrix.len()];
    row[0] = 1.0;
    let mut found = None;
    for step in 0..MOST {
        let mut next = times(&row, matrix);
        let total: f64 = next.iter().sum();
        next.iter_mut().for_each(|c| *c /= total);
        let change = row.iter().zip(&next).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        row = next;
        if found.is_none() && change <= NEARLY {
            found = Some(2 * step);
        }
        if found.is_some_and(|last| step >= last) {
            return Some(row);
        }
    }
    None
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
        let rows = invariant(&small, &own, sector)?;
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

/// Two orthonormal rows whose plane stays under multiplication, turned like the ring.
fn invariant(matrix: &Matrix, position: &[f64], sector: &Sector) -> Option<[Vec<f64>; 2]> {
    let mut rows = settle(start(matrix.len(), sector), |row| without(times(row, matrix), position))?;
    let columns = settle(rows.clone(), |column| {
        let image = matrix.iter().map(|row| row.iter().map(|&(k, c)| c * column[k as usize]).sum());
        let image: Vec<f64> = image.collect();
        let mean: f64 = image.iter().zip(position).map(|(a, b)| a * b).sum();
        image.iter().map(|c| c - mean).collect()
    })?;
    // The ring as it comes to look, in the coordinates that the rows measure.
    let by = |a: usize, b: usize| dot(&rows[a], &columns[b]);
    let determinant = by(0, 0) * by(1, 1) - by(0, 1) * by(1, 0);
    let at = |k: usize| [0, 1].map(|c| columns[c][k] - columns[c][0]);
    let count = sector.edges.len();
    let turns = if sector.closed { count } else { count - 1 };
    let area: f64 = (0..turns)
        .map(|k| (at(1 + k), at(1 + (k + 1) % count)))
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum();
    // Coordinates are the columns times the inverse of `by`, whose determinant turns the area.
    let turned = area * determinant;
    if turned == 0.0 || !turned.is_finite() {
        return None;
    }
    if turned < 0.0 {
        rows[1].iter_mut().for_each(|c| *c = -*c);
    }
    Some(rows)
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

/// Multiplies a plane until it stays.
fn settle(mut plane: [Vec<f64>; 2], image: impl Fn(&[f64]) -> Vec<f64>) -> Option<[Vec<f64>; 2]> {
    orthonormalise(&mut plane).then_some(())?;
    let mut found = None;
    for step in 0..MOST {
        let mut next = [image(&plane[0]), image(&plane[1])];
        orthonormalise(&mut next).then_some(())?;
        let change = next.iter().fold(0.0, |most: f64, row| {
            let (a, b) = (dot(row, &plane[0]), dot(row, &plane[1]));
            let off = |k: usize| (row[k] - a * plane[0][k] - b * plane[1][k]).abs();
            (0..row.len()).map(off).fold(most, f64::max)
        });
        plane = next;
        if found.is_none() && change <= NEARLY {
            found = Some(2 * step);
        }
        if found.is_some_and(|last| step >= last) {
            return Some(plane);
        }
    }
    None
}

/// What of a row sums to zero.
fn without(mut row: Vec<f64>, constant: &[f64]) -> Vec<f64> {
    let total: f64 = row.iter().sum();
    row.iter_mut().zip(constant).for_each(|(c, p)| *c -= total * p);
    row
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Makes it a unit vector; what was its length.
fn normalise(row: &mut [f64]) -> f64 {
    let size = row.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if size > 0.0 {
        row.iter_mut().for_each(|c| *c /= size);
        let length = dot(row, row).sqrt();
        row.iter_mut().for_each(|c| *c /= length);
        return size * length;
    }
    0.0
}

/// Makes two rows orthonormal without turning them over; false where they are one direction but for rounding.
fn orthonormalise([a, b]: &mut [Vec<f64>; 2]) -> bool {
    if normalise(a) == 0.0 || normalise(b) == 0.0 {
        return false;
    }
    let along = dot(a, b);
    b.iter_mut().zip(a.iter()).for_each(|(b, a)| *b -= along * a);
    if normalise(b) <= PLANE {
        return false;
    }
    // Once more, for what rounding left of the first.
    let along = dot(a, b);
    b.iter_mut().zip(a.iter()).for_each(|(b, a)| *b -= along * a);
    normalise(b) > 0.0
}
