//! How an edge is brought to lie on a curve whose parameters run otherwise: which places of the curve it meets.

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::Curve;

use crate::beside::Beside;

/// An edge is on a curve already where it is nearer to it everywhere than this part of the size of both.
const ON: f64 = 1e-12;
/// The accuracy of lengths by which places are chosen.
const LENGTHS: f64 = 1e-9;

/// Whether every point of an edge is on a curve, to rounding, looked at as [`Beside::between`] says.
///
/// # Errors
/// When numbers overflow.
pub(crate) fn lies_on(beside: &Beside, curve: &Curve) -> Result<bool> {
    let own = &beside.edge.curve;
    let largest = |curve: &Curve| curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let near = ON * largest(own).max(largest(curve));
    for t in beside.between(false) {
        if curve.closest(own.point(t)?)?.distance > near {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Places of a curve that an edge meets at its Greville abscissae, and how far it is from the curve between them.
#[derive(Debug)]
pub(crate) struct Nearest {
    /// The edge's parameters, and the points.
    pub(crate) targets: Vec<(f64, Point)>,
    /// The largest distance of the edge through these from the curve, or of the curve from it.
    pub(crate) distance: f64,
    /// Where that is.
    pub(crate) place: Point,
}

/// Of the ways to run along the curve (evenly by parameter, by length as the edge does now, by the points that are closest to the
/// edge now, where these go one way) the one that leaves an edge through its places nearest to the curve; the first of equals.
///
/// # Errors
/// When numbers overflow.
pub(crate) fn nearest(beside: &Beside, curve: &Curve) -> Result<Nearest> {
    let evenly = beside.greville();
    let ways = [Some(evenly.clone()), by_length(beside, &evenly)?, by_closest(beside, &evenly)?];
    let mut best: Option<Nearest> = None;
    for way in ways.into_iter().flatten() {
        let point = |(t, u): (&f64, &f64)| Ok((*t, beside.curve.point(*u)?));
        let targets = evenly.iter().zip(&way).map(point).collect::<Result<Vec<_>>>()?;
        let Some(found) = through(beside, curve, targets)? else { continue };
        if best.as_ref().is_none_or(|best| found.distance < best.distance) {
            best = Some(found);
        }
    }
    best.ok_or_else(|| {
        let name = beside.edge.edge.called();
        Error::Invalid(format!(
            "no curve in the space of {name} passes as many points as it has control vertices"
        ))
    })
}

/// Parameters of the curve beside the edge at which as much of its length is behind as of the edge's at `places`; none where
/// either has no length.
fn by_length(beside: &Beside, places: &[f64]) -> Result<Option<Vec<f64>>> {
    let (edge, curve) = (beside.edge.curve.arc_length(LENGTHS)?, beside.curve.arc_length(LENGTHS)?);
    let (all, whole) = (edge.length().value, curve.length().value);
    if !(all > 0.0 && whole > 0.0) {
        return Ok(None);
    }
    let at = |t: &f64| curve.parameter((edge.up_to(*t)? / all * whole).clamp(0.0, whole));
    places.iter().map(at).collect::<Result<Vec<_>>>().map(Some)
}

/// The closest points of the curve beside the edge to the edge at `places`, its ends to its ends; none where they do not go one way.
fn by_closest(beside: &Beside, places: &[f64]) -> Result<Option<Vec<f64>>> {
    let (a, b) = beside.edge.curve.domain();
    let at = |t: &f64| -> Result<f64> {
        if *t == a || *t == b { Ok(*t) } else { Ok(beside.curve.closest(beside.edge.curve.point(*t)?)?.at) }
    };
    let found = places.iter().map(at).collect::<Result<Vec<_>>>()?;
    // Round a periodic edge the first Greville abscissae may lie before its start.
    let turns = found.windows(2).filter(|pair| pair[0] >= pair[1]).count();
    let whole = usize::from(beside.edge.curve.is_periodic());
    Ok((turns <= whole).then_some(found))
}

/// The curve in the edge's space through these points, measured; none where there is none.
fn through(beside: &Beside, curve: &Curve, targets: Vec<(f64, Point)>) -> Result<Option<Nearest>> {
    let mut edit = Edit::new(&beside.edge.curve).smooth(0);
    for (t, point) in &targets {
        edit = edit.ask(position(*t).to(*point));
    }
    let Ok(edited) = edit.solve() else { return Ok(None) };
    let edge = edited.shape();
    let (mut distance, mut place) = (0.0, targets.first().map_or_else(Point::origin, |(_, point)| *point));
    for t in beside.between(false) {
        let (on_edge, on_curve) = (edge.point(t)?, beside.curve.point(t)?);
        for (point, found) in [(on_edge, curve.closest(on_edge)?), (on_curve, edge.closest(on_curve)?)] {
            if found.distance > distance {
                (distance, place) = (found.distance, point);
            }
        }
    }
    Ok(Some(Nearest { targets, distance, place }))
}
