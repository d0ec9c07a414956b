//! A surface as triangles between limits of vertices.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::plugin::{Faceted, Fineness};

use super::facing::Aim;
use super::tree::Batches;
use super::{SubdivisionSurface, refused};
use crate::cage::Cage;
use crate::catmull_clark::{limit_points, refine};

/// The states of a surface as the same triangles: each face refined as often as it needs in the worst of them, vertices at their limits,
/// quads halved, or cut from their middle where a neighbour is refined further, so that nothing gapes. Faces side by side are no more than
/// one level apart.
///
/// The error is a bound of the distance that any point of the surface has from the triangles: of regular quads by the second
/// differences of their Bézier points, of others by those of the quadrants they consist of, down to one whose neighbourhood, in the hull of which
/// it lies, is near enough. Where that takes more than some levels beyond what is found to be enough in the middles of edges and faces, it
/// is that, and not certified. For the sake of the angle faces are refined that turn by more and are larger than the chord. Cost: linear in
/// the triangles, for every state.
///
/// # Errors
/// [`Error::NoExtent`] where all is one point; when there is no state, the states are different surfaces, the fineness is not positive,
/// or more than two million vertices are needed.
pub(super) fn tessellate(states: &[&SubdivisionSurface], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
    };
    let alike = |s: &&SubdivisionSurface| {
        let (a, b) = (&s.cage, &first.cage);
        a.topology() == b.topology()
            && (&a.creases, &a.corners, &a.holes, &a.intervals, a.boundary)
                == (&b.creases, &b.corners, &b.holes, &b.intervals, b.boundary)
    };
    if !states.iter().all(alike) {
        return Err(Error::Invalid(
            "the states of the surface have different faces or creases: they are not one surface".into(),
        ));
    }
    let sizes: Vec<f64> = states.iter().map(|s| size(&s.cage).map_err(refused)).collect::<Result<_>>()?;
    let aim = Aim::new(fineness, &sizes)?;
    let (batches, quads) =
        Batches::new(states.iter().map(|s| s.cage.clone()).collect(), &first.layout.first)?;
    aim.faceted(batches, quads)
}

/// The diagonal of the box around the limits of a cage's vertices; where these are one point but for rounding, of those of the refined cage;
/// 0 where these are, too.
fn size(cage: &Cage) -> crate::error::Result<f64> {
    let least = 1e-12 * diagonal(cage.points());
    let own = diagonal(&limit_points(cage)?);
    if own > least || !own.is_finite() {
        return Ok(own);
    }
    let finer = diagonal(&limit_points(&refine(cage)?)?);
    Ok(if finer > least { finer } else { 0.0 })
}

pub(crate) fn diagonal(points: &[Point]) -> f64 {
    let start = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    let (low, high) = points.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}
