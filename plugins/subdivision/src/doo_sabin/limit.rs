//! Where the middles of faces come to lie: on the surface, at once.

use std::f64::consts::TAU;

use loftsman_kernel::{Point, parallel};

use super::refine::waves;
use crate::cage::{Cage, present};
use crate::error::{Result, SubdivisionError};
use crate::frame::{LimitFrame, LimitStencils};
use crate::row::Row;

/// The rows of the limit of a face's middle, which is the mean of its vertices, and of two tangents there: sums by cosines and sines
/// round the face, whose eigenvalue is one half. The limit of an inner vertex is that of its face once refined. Exact. Cost: the size of
/// the face.
///
/// # Errors
/// When there is no such face; when intervals differ, for then no limit is known.
pub fn limit_stencils(cage: &Cage, face: usize) -> Result<LimitStencils> {
    check_uniform(cage)?;
    present("face", face, cage.topology().face_count())?;
    let vertices = cage.topology().face(face);
    let n = vertices.len() as f64;
    let row = |weight: &dyn Fn(f64) -> f64| {
        let mut row = Row::default();
        vertices.iter().enumerate().for_each(|(i, &v)| row.add(v, weight(TAU * i as f64 / n)));
        row.into_stencil()
    };
    Ok(LimitStencils { position: row(&|_| 1.0 / n), tangents: [row(&f64::cos), row(&f64::sin)] })
}

/// The limits of the middles of all faces with their tangents. Cost: linear, in parallel with the feature `parallel`.
///
/// # Errors
/// When intervals differ, for then no limit is known.
pub fn limit_frames(cage: &Cage) -> Result<Vec<LimitFrame>> {
    check_uniform(cage)?;
    Ok(parallel::map(cage.topology().face_count(), |face| {
        let [point, cosines, sines] = waves(cage, face);
        LimitFrame { point: Point::from(point), tangents: [cosines, sines] }
    }))
}

/// Whether the scheme is uniform: no intervals, or all the same.
pub(super) fn check_uniform(cage: &Cage) -> Result<()> {
    let Some(&[first, _]) = cage.end_intervals.first() else { return Ok(()) };
    let Some(edge) = cage.end_intervals.iter().position(|&ends| ends != [first; 2]) else { return Ok(()) };
    let [from, to] = cage.topology.ends(edge).map(|v| v as usize);
    let [a, b] = cage.end_intervals[edge];
    let problem = format!(
        "has the intervals {a} and {b}, others {first}: limits are known where all are equal; refine instead"
    );
    Err(SubdivisionError::Edge { from, to, problem })
}
