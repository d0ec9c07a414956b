//! Surfaces that a placement mirrors: `∂u × ∂v` would point inward, where meshes keep their outside.

use std::borrow::Cow;

use loftsman_kernel::plugin::FormatError;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};
use loftsman_kernel::{Point, Result};

/// A surface, trimmed or not, with `u` and `v` exchanged, which turns its normal round and rounds no number; what else there is, as it is.
pub(super) fn exchanged(geometry: Cow<'_, Geometry>) -> std::result::Result<Cow<'_, Geometry>, FormatError> {
    Ok(match &*geometry {
        Geometry::Surface(found) => Cow::Owned(surface(found)?.into()),
        Geometry::Trimmed(found) => Cow::Owned(trimmed(found)?.into()),
        _ => geometry,
    })
}

/// `S(v, u)`.
pub(super) fn surface(surface: &Surface) -> Result<Surface> {
    let (u, v) = (surface.u(), surface.v());
    let order = || (0..v.len()).flat_map(|j| (0..u.len()).map(move |i| i * v.len() + j));
    let points = order().map(|k| surface.points()[k]).collect();
    let weights = surface.weights().map(|weights| order().map(|k| weights[k]).collect());
    Surface::build(v.clone(), u.clone(), points, weights)
}

/// A curve in the parameter plane with its coordinates exchanged.
pub(super) fn plane_curve(curve: &Curve) -> Result<Curve> {
    let points = curve.points().iter().map(|p| Point::new(p.y, p.x, 0.0)).collect();
    Curve::build(curve.space().clone(), points, curve.weights().map(<[f64]>::to_vec))
}

fn trimmed(trimmed: &Trimmed) -> Result<Trimmed> {
    let regions = trimmed.regions().iter().map(|region| {
        let holes = region.holes.iter().map(|hole| turned(hole)).collect::<Result<_>>()?;
        Ok(Region { outer: turned(&region.outer)?, holes })
    });
    let part = |part: &ParameterCurve| {
        let (from, to) = part.range();
        ParameterCurve::new(plane_curve(part.curve())?, from, to)
    };
    let curves = trimmed.curves().iter().map(|chain| chain.iter().map(part).collect());
    let points = trimmed.points().iter().map(|&[u, v]| [v, u]).collect();
    Trimmed::new(
        surface(trimmed.surface())?,
        regions.collect::<Result<_>>()?,
        curves.collect::<Result<_>>()?,
        points,
    )
}

/// A loop with its coordinates exchanged, which turns it the other way round, run backwards: outer loops run counterclockwise, holes
/// clockwise.
fn turned(chain: &[ParameterCurve]) -> Result<Vec<ParameterCurve>> {
    chain
        .iter()
        .rev()
        .map(|part| {
            let curve = plane_curve(part.curve())?.reverse()?;
            let (start, end) = curve.domain();
            let ((from, to), (a, b)) = (part.range(), part.curve().domain());
            let back = |t: f64| {
                if t == b {
                    start
                } else if t == a {
                    end
                } else {
                    (a + (b - t)).clamp(start, end)
                }
            };
            ParameterCurve::new(curve, back(to), back(from))
        })
        .collect()
}
