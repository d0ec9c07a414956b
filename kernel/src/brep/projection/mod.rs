//! Edges in the parameter planes of the faces that they bound.

mod feet;
mod fit;
mod layout;
mod straight;
#[cfg(test)]
mod tests;

use super::{Brep, Edge, Use};
use crate::Point;
use crate::error::{Error, Result};
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, ParameterRegion, ParameterSide, Surface};
use feet::{Feet, Sample};

/// What a fitted curve may be off, as a share of the size of the edge and of its tolerance.
const OF_SIZE: f64 = 1e-9;
const OF_TOLERANCE: f64 = 0.1;

/// An edge in the parameter plane of a face's surface, from the edge's start to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Projected {
    /// The curve.
    pub curve: ParameterCurve,
    /// The largest distance between the surface along the curve and the edge, measured at many places: what the edge itself is off
    /// the surface is a part of it.
    pub error: f64,
}

/// What is known of a use before the loop is laid out.
enum Found {
    Curve(Projected),
    /// The edge is a point; how large it is.
    Point(f64),
}

impl Brep {
    /// The edges of a face in the parameter plane of its surface, use by use of each loop: the file's curve where there is one that is as near to the edge as
    /// the edge's tolerance says, else one that is computed.
    ///
    /// *Computed ones* are the straight line where the edge lies along a line of constant `u` or `v` (or any straight line of the plane, at the
    /// edge's speed), and the edge's own curve where the surface is affine, both exact; all others are of degree 7 piece by
    /// piece through feet of the edge's points, at the edge's speed (the parameters are those of the edge's
    /// [part](Curve::between)), with pieces halved until the surface along it is within the larger of 1e-9 of the edge's size and a tenth
    /// of its tolerance; where the surface is so singular that no halving helps, [`error`](Projected::error) says what is left.
    ///
    /// *Loops run on*: each curve starts where the one before it ends. Where the surface closes, parameters go beyond
    /// its domain, by less than a period where they can ([`ParameterSide::wrapped`] brings them back). At a pole, the rest of
    /// the loop starts elsewhere on the side of the domain that the pole is: with the face to the left of the way from here to there. An edge
    /// that is a point is that way.
    ///
    /// Each place costs a search on the surface, most of them from the place before.
    ///
    /// # Errors
    /// When there is no such face, or an evaluation overflows.
    pub fn parameter_curves(&self, face: usize) -> Result<Vec<Vec<Projected>>> {
        let surface = self.surface(face).ok_or_else(|| {
            Error::Invalid(format!("face {face} is asked for, but there are {} faces", self.face_count()))
        })?;
        let edges: Vec<Vec<(&Use, Edge)>> = self
            .loops(face)
            .iter()
            .map(|chain| chain.iter().filter_map(|one| Some((one, self.edge(one.edge)?))).collect())
            .collect();
        let sides = self.parameter_sides(face, &surface)?;
        let reversed = self.is_reversed(face);
        edges.iter().map(|chain| self.project_loop(face, &surface, sides, chain, reversed)).collect()
    }

    /// What a face's surface does where its parameters end: as [`Surface::parameter_sides`], within the widest tolerance of the face's edges, but no more
    /// than what can be seen.
    fn parameter_sides(&self, face: usize, surface: &Surface) -> Result<[ParameterSide; 2]> {
        let size = size_of(surface.points());
        let uses = self.loops(face).iter().flatten();
        let tolerances = uses.filter_map(|one| self.edges.get(one.edge)).map(|edge| edge.tolerance);
        let widest = tolerances.fold(0.0, f64::max);
        surface.parameter_sides(widest.clamp(OF_SIZE * size, 1e-4 * size))
    }

    /// What the loops of a face leave of its surface's parameter plane; `None` where it has none, and is the whole surface. Its edges
    /// are [projected](Self::parameter_curves) where their parameter curves are not known.
    ///
    /// # Errors
    /// When loops do not say what is inside, or an evaluation overflows.
    pub fn parameter_region(&self, face: usize) -> Result<Option<ParameterRegion>> {
        let loops = self.loops(face);
        if loops.is_empty() {
            return Ok(None);
        }
        let found = self.parameter_curves(face)?;
        let Some(surface) = self.surface(face) else { return Ok(None) };
        let sides = self.parameter_sides(face, &surface)?;
        let reversed = self.is_reversed(face);
        let mut chains = Vec::with_capacity(loops.len());
        for (uses, curves) in loops.iter().zip(&found) {
            let all = uses.iter().zip(curves).map(|(one, found)| (&found.curve, one.reversed != reversed));
            let all: Vec<(&ParameterCurve, bool)> =
                if reversed { all.rev().collect() } else { all.collect() };
            chains.push(all);
        }
        ParameterRegion::new(&surface, &sides, &chains).map(Some)
    }

    fn project_loop(
        &self,
        face: usize,
        surface: &Surface,
        sides: [ParameterSide; 2],
        chain: &[(&Use, Edge)],
        reversed: bool,
    ) -> Result<Vec<Projected>> {
        let mut found = Vec::with_capacity(chain.len());
        // A seam is used twice; it is projected once.
        let mut known: Vec<(usize, usize)> = Vec::new();
        for (number, (one, edge)) in chain.iter().enumerate() {
            let before = known
                .iter()
                .find(|(known, at)| *known == one.edge && one.parameters == chain[*at].0.parameters);
            let copy = before.and_then(|&(_, at)| match found.get(at) {
                Some(Found::Curve(curve)) => Some(Found::Curve(Projected::clone(curve))),
                Some(Found::Point(size)) => Some(Found::Point(*size)),
                None => None,
            });
            found.push(match copy {
                Some(copy) => copy,
                None => project(surface, sides, edge, one.parameters.as_ref()).map_err(|error| {
                    Error::Invalid(format!("edge {} in the parameters of face {face}: {error}", one.edge))
                })?,
            });
            known.push((one.edge, number));
        }
        let turned: Vec<bool> = chain.iter().map(|(one, _)| one.reversed).collect();
        layout::lay_out(found, &turned, &sides, reversed)
    }
}

/// The diagonal of the box around some points.
fn size_of(points: &[Point]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

fn project(
    surface: &Surface,
    sides: [ParameterSide; 2],
    edge: &Edge,
    own: Option<&ParameterCurve>,
) -> Result<Found> {
    let curve = edge.curve.between(edge.range.0, edge.range.1)?;
    let (size, whole) = (size_of(curve.points()), size_of(surface.points()));
    if size <= 1e-12 * whole || size <= 2.0 * edge.tolerance.min(1e-6 * whole) {
        return Ok(Found::Point(size));
    }
    let bound = (OF_SIZE * size).max(OF_TOLERANCE * edge.tolerance);
    let feet = Feet::new(surface, sides, bound.max(edge.tolerance));
    let given = match own {
        Some(own) => Some(Projected { curve: own.clone(), error: feet.measured(own, &curve)? }),
        None => None,
    };
    if let Some(given) = given.as_ref().filter(|given| given.error <= bound.max(edge.tolerance)) {
        return Ok(Found::Curve(given.clone()));
    }
    let computed = computed(&feet, &curve, bound)?;
    Ok(Found::Curve(match given {
        // The file's is worse than it should be: it stays unless the other one is really better.
        Some(given) if given.error <= 2.0 * computed.error => given,
        _ => computed,
    }))
}

fn computed(feet: &Feet<'_>, curve: &Curve, bound: f64) -> Result<Projected> {
    if let Some(affine) = straight::affine(feet, curve)?
        && affine.error <= bound
    {
        return Ok(affine);
    }
    let samples: Vec<Sample> = feet.along(curve)?;
    if let Some(line) = straight::line(feet, curve, &samples, bound)? {
        return Ok(line);
    }
    fit::fitted(feet, curve, &samples, bound)
}
