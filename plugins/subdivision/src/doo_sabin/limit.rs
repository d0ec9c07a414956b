//! Where the middles of faces come to lie: on the surface, at once.

use std::f64::consts::TAU;

use loftsman_kernel::{Point, Vector, parallel};

use super::refine::{matrix, waves};
use crate::cage::{Cage, present};
use crate::eigen::{self, Matrix, Plane};
use crate::error::{Result, SubdivisionError};
use crate::frame::{LimitFrame, LimitStencils};
use crate::row::Row;

/// The rows of the limit of a face, and of two tangents there. The limit of an inner vertex is that of its face once refined.
///
/// Uniform: the mean of its vertices, and sums by cosines and sines round the face, whose eigenvalue is one half. By end intervals a face
/// is refined by the same matrix for ever, so that the rows are its left eigenvectors, to rounding; on grids with an interval for each
/// row and column the point and the tangent plane of the biquadratic spline where its knots cross. Cost: the size of the face; by
/// intervals some fifty times its square.
///
/// # Errors
/// When there is no such face; when intervals leave it without a limit or a tangent plane.
pub fn limit_stencils(cage: &Cage, face: usize) -> Result<LimitStencils> {
    present("face", face, cage.topology().face_count())?;
    let vertices = cage.topology().face(face);
    let n = vertices.len() as f64;
    let over = |weights: &[f64]| {
        let mut row = Row::default();
        vertices.iter().zip(weights).for_each(|(&v, &w)| row.add(v, w));
        row.into_stencil()
    };
    if !is_uniform(cage) {
        let (position, tangents) = uneven(cage, face)?;
        let tangents = tangents.ok_or_else(|| SubdivisionError::Face {
            face,
            problem:
                "has a limit by its intervals, and no tangent plane there: bring them nearer to each other"
                    .to_owned(),
        })?;
        return Ok(LimitStencils { position: over(&position), tangents: tangents.map(|t| over(&t)) });
    }
    let row = |weight: &dyn Fn(f64) -> f64| {
        over(&(0..vertices.len()).map(|i| weight(TAU * i as f64 / n)).collect::<Vec<_>>())
    };
    Ok(LimitStencils { position: row(&|_| 1.0 / n), tangents: [row(&f64::cos), row(&f64::sin)] })
}

/// The limits of all faces with their tangents, which are zero where intervals leave no tangent plane. Cost: linear, in parallel with the
/// feature `parallel`.
///
/// # Errors
/// When intervals leave a face without a limit.
pub fn limit_frames(cage: &Cage) -> Result<Vec<LimitFrame>> {
    let uniform = is_uniform(cage);
    let frame = |face| {
        if uniform {
            let [point, cosines, sines] = waves(cage, face, &Point::origin());
            return Ok(LimitFrame { point: Point::from(point), tangents: [cosines, sines] });
        }
        let (position, tangents) = uneven(cage, face)?;
        let points = cage.topology().face(face).iter().map(|&v| cage.points()[v as usize].coords);
        let apply = |row: &[f64]| points.clone().zip(row).map(|(p, c)| p * *c).sum::<Vector>();
        let tangents = tangents.map_or([Vector::zeros(); 2], |rows| rows.map(|row| apply(&row)));
        Ok(LimitFrame { point: Point::from(apply(&position)), tangents })
    };
    parallel::map(cage.topology().face_count(), frame).into_iter().collect()
}

/// The limit of a face over its corners, and two tangents, where there are any.
type Rows = (Vec<f64>, Option<[Vec<f64>; 2]>);

/// By intervals. They are halved alike at every level, so that the matrix stays the same.
fn uneven(cage: &Cage, face: usize) -> Result<Rows> {
    let matrix: Matrix = matrix(cage, face);
    let position = position(&matrix).ok_or_else(|| {
        let problem = "comes to no point by its intervals: bring them nearer to each other".to_owned();
        SubdivisionError::Face { face, problem }
    })?;
    let tangents = plane(&matrix, &position).map(|plane| plane.rows);
    Ok((position, tangents))
}

/// The row of the limit of a face that is refined by a matrix: that which the first corner comes to, where all others come there, too. Of five corners and
/// more an eigenvalue can be 1 and larger by intervals far from each other.
pub(super) fn position(matrix: &Matrix) -> Option<Vec<f64>> {
    let position = eigen::position(matrix)?;
    // All of them at once, in a sum of which no eigenvector has nothing but by chance.
    let mut all: Vec<f64> = (0..matrix.len()).map(|k| 1.0 + (1.7 * k as f64).sin()).collect();
    let total: f64 = all.iter().sum();
    all.iter_mut().for_each(|c| *c /= total);
    for level in 0..eigen::MOST {
        let off = all.iter().zip(&position).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        if level >= SETTLED && off <= NEAR {
            return Some(position);
        }
        if !off.is_finite() {
            return None;
        }
        all = eigen::times(&all, matrix);
    }
    None
}

/// Levels before which nothing is said: what has an eigenvalue of one half is gone by then to rounding.
const SETTLED: usize = 60;
/// The rest from which on all comes to the point, as it goes down: by the largest eigenvalue each level.
const NEAR: f64 = 1e-2;

/// The tangent plane of a face that is refined by a matrix, with the places of its corners in it, where there is one.
pub(super) fn plane(matrix: &Matrix, position: &[f64]) -> Option<Plane> {
    let n = matrix.len();
    let wave = |of: fn(f64) -> f64| (0..n).map(|i| of(TAU * i as f64 / n as f64)).collect();
    let area = |columns: &[Vec<f64>; 2]| {
        let at = |k: usize| [columns[0][k % n], columns[1][k % n]];
        (0..n).map(|k| at(k)[0] * at(k + 1)[1] - at(k)[1] * at(k + 1)[0]).sum()
    };
    eigen::plane(matrix, position, [wave(f64::cos), wave(f64::sin)], area)
}

/// Whether there are no intervals, or all are the same.
pub(super) fn is_uniform(cage: &Cage) -> bool {
    cage.end_intervals
        .first()
        .is_none_or(|&[first, _]| cage.end_intervals.iter().all(|&ends| ends == [first; 2]))
}

/// Whether the scheme is uniform: no intervals, or all the same.
pub(super) fn check_uniform(cage: &Cage) -> Result<()> {
    let Some(&[first, _]) = cage.end_intervals.first() else { return Ok(()) };
    let Some(edge) = cage.end_intervals.iter().position(|&ends| ends != [first; 2]) else { return Ok(()) };
    let [from, to] = cage.topology.ends(edge).map(|v| v as usize);
    let [a, b] = cage.end_intervals[edge];
    let problem = format!(
        "has the intervals {a} and {b}, others {first}: a bicubic cage is known where all are equal; leave intervals out"
    );
    Err(SubdivisionError::Edge { from, to, problem })
}
