//! How far a face of a surface is from triangles between limits of vertices, certified.

use loftsman_kernel::error::Result;
use loftsman_kernel::{Point, Vector};

use super::cut::Cut;
use super::net::{Net, beyond_all, bezier, hull_of, largest, net_of};
use super::pattern::{Pattern, Quadrant};
use super::refused;
use super::regular;
use super::template::{Near, Templates};
use super::triangle::from_triangle;
use crate::cage::Cage;

/// A neighbourhood that is no further from a triangle than this part of the chord is not looked into.
const ENOUGH: f64 = 0.02;
/// Levels that are looked into, at most. Neighbourhoods shrink by a third and more a level, so that this is beyond rounding.
const LEVELS: u32 = 56;

/// A face, a quad, and its triangles.
pub(super) struct Faced<'a> {
    pub(super) cage: &'a Cage,
    pub(super) face: usize,
    pub(super) cut: Cut,
    /// Its corners, the middles of edges and of itself; of middles that its cut does not have any.
    pub(super) at: [Point; 9],
}

/// A bound of the distance that the limit of a face has from its triangles or, where that is more than the chord, from all triangles
/// `round` it and its own; whether it took these. More than the chord where that cannot be told. Cost: of an irregular face that of its
/// quadrants.
pub(super) fn apart(
    templates: &Templates,
    faced: &Faced<'_>,
    chord: f64,
    round: &dyn Fn() -> Vec<[Point; 3]>,
) -> Result<(f64, bool)> {
    let Faced { cage, face, cut, at } = *faced;
    let mut from_others = false;
    let mut of_patch = |patch: &Net, quadrant: Quadrant| {
        let own = cut.beyond(patch, quadrant, &at, chord);
        if own <= chord {
            return own;
        }
        from_others = true;
        beyond_all(patch, &round(), chord, 0)
    };
    if let Some(rows) = regular::net(cage, face) {
        let point = |v: u32| cage.points()[v as usize].coords;
        let net: Net = rows.map(|row| row.iter().fold(Vector::zeros(), |sum, &(v, c)| sum + point(v) * c));
        let bound = of_patch(&bezier(&net), Quadrant::WHOLE);
        return Ok((bound, from_others));
    }
    let triangles: Vec<[Point; 3]> = cut.triangles().iter().map(|t| t.map(|k| at[usize::from(k)])).collect();
    let pattern = Pattern::of_quad(cage, face);
    let near = Near::from_corner(cage, face, 0).map_err(refused)?;
    let point = |k: usize| cage.points()[near.base[k] as usize].coords;
    let (mut most, mut rest) = (0.0_f64, Quadrant::WHOLE.parts().to_vec());
    while let Some(quadrant) = rest.pop() {
        if most > chord {
            break;
        }
        if pattern.is_regular(quadrant)
            && let Some(piece) = templates.piece(cage, &near, quadrant).map_err(refused)?
        {
            most = most.max(of_patch(&bezier(&net_of(&piece, point)), quadrant));
            continue;
        }
        let local = templates.local(cage, &near, quadrant).map_err(refused)?;
        let hull: Vec<Point> = hull_of(&local, point).into_iter().map(Point::from).collect();
        let from = |t: &[Point; 3]| largest(hull.iter().map(|q| from_triangle(q, t)));
        let bound = triangles.iter().map(from).fold(f64::INFINITY, f64::min);
        if bound <= most.max(ENOUGH * chord) || quadrant.level >= LEVELS {
            most = most.max(bound);
        } else {
            rest.extend(quadrant.parts());
        }
    }
    Ok((most, from_others))
}
