//! Limits where knot intervals differ.
//!
//! A vertex whose neighbourhood is a grid with an interval for each row and column is on a tensor-product spline, whose point and
//! tangents are known ([`grid`]). Elsewhere the neighbourhood is refined as often as its weights change ([`levels`]): intervals stand
//! in the same ratios along each edge of the vertex from the second level on, and those across come nearer to them by half each level,
//! so that the matrix which refines the ring is the same to rounding after some fifty at most. Its left eigenvectors, taken back through
//! these levels, are the rows of the limit ([`eigen`]).

mod eigen;
mod grid;
mod levels;

use super::limit;
use super::ring::{Limit, Ring};
use super::weights::Weights;
use crate::cage::Cage;
use crate::eigen::position as position_row;
use crate::error::{Result, SubdivisionError};
use crate::row::Row;
use eigen::Sector;
use levels::Levels;
pub(super) use levels::Local;

/// The row of the limit of a vertex of a cage with intervals.
///
/// # Errors
/// When refinement there comes to nothing.
pub(super) fn position(weights: &Weights<'_>, vertex: usize) -> Result<Row> {
    match grid::Neighbourhood::at(weights, vertex) {
        grid::Neighbourhood::Even => Ok(limit::even_position(weights.cage, vertex)),
        grid::Neighbourhood::Grid(grid) => Ok(grid.position()),
        grid::Neighbourhood::Other => {
            let levels = Levels::new(weights.cage, vertex)?;
            let position = position_row(levels.last()).ok_or_else(|| wanders(vertex))?;
            Ok(affine(levels.back(&position)))
        }
    }
}

/// The rows of the limit of a vertex and of two tangents in a sector, where there is a tangent plane.
///
/// # Errors
/// As for [`position`].
pub(super) fn frame(weights: &Weights<'_>, vertex: usize, sector: usize) -> Result<(Row, Option<[Row; 2]>)> {
    let cage = weights.cage;
    match grid::Neighbourhood::at(weights, vertex) {
        grid::Neighbourhood::Even => {
            let (position, tangents) = limit::even_rows(cage, vertex, sector);
            Ok((position, Some(tangents)))
        }
        grid::Neighbourhood::Grid(grid) => Ok((grid.position(), grid.tangents())),
        grid::Neighbourhood::Other => {
            let levels = Levels::new(cage, vertex)?;
            let position = position_row(levels.last()).ok_or_else(|| wanders(vertex))?;
            let part = sector_of(cage, vertex, sector);
            let tangents = eigen::tangents(&levels, &position, &part);
            Ok((affine(levels.back(&position)), tangents))
        }
    }
}

/// What of the ring a sector is.
fn sector_of(cage: &Cage, vertex: usize, sector: usize) -> Sector {
    let ring = Ring::new(cage, vertex);
    let (edges, faces) = ring.size();
    match ring.limit() {
        Limit::Smooth | Limit::Dart(_) => Sector::whole(edges),
        Limit::Crease([a, b]) => {
            let (from, to) = if sector == 0 { (a, b) } else { (b, a) };
            Sector::between(edges, from, (to + edges - from) % edges)
        }
        Limit::Corner => Sector::corner(edges, faces, sector),
    }
}

/// A row whose coefficients sum to one, by what rounding left of it on the way.
fn affine(mut row: Row) -> Row {
    let total: f64 = row.0.iter().map(|(_, c)| c).sum();
    row.0.iter_mut().for_each(|(_, c)| *c /= total);
    row
}

/// The error of a vertex whose row does not settle.
fn wanders(vertex: usize) -> SubdivisionError {
    let problem =
        "comes to no point by its knot intervals: bring the intervals of its edges nearer to each other"
            .to_owned();
    SubdivisionError::Vertex { vertex, problem }
}
