//! The place of a Brep that is nearest to a point.

use super::Brep;
use crate::error::{Error, Result};
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Space, Surface};
use crate::{Point, parallel};

/// Places of each span of a loop's curve at which it is looked at.
const LOOKS: usize = 16;
/// Starts, in each direction of a face, of searches downhill where the nearest place of its surface is not on the face.
const STARTS: usize = 6;

/// A place on a Brep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePlace {
    /// The face.
    pub face: usize,
    /// The parameters of its surface.
    pub at: [f64; 2],
    /// The place itself.
    pub point: Point,
    /// How far it is from the point that was asked for.
    pub distance: f64,
}

/// The loops of a face as lines in the parameter plane, each run through with the face on its left. Those that go around a closed surface end a
/// period from where they start.
pub(super) struct Outline {
    lines: Vec<Vec<[f64; 2]>>,
    /// The periods of directions in which the surface closes.
    periods: [Option<f64>; 2],
}

impl Outline {
    /// Whether a place is inside: the first piece of a loop beside it, in any direction along the axes, has it on its left.
    pub(super) fn has(&self, at: [f64; 2]) -> bool {
        if self.lines.is_empty() {
            return true;
        }
        let mut nearest: Option<(f64, bool)> = None;
        for (along, across) in [(1, 0), (0, 1)] {
            let turns = |k: usize| self.periods[k].map_or(vec![0.0], |t| vec![-2.0 * t, -t, 0.0, t, 2.0 * t]);
            for line in &self.lines {
                for (a, b) in line.iter().zip(line.iter().skip(1)) {
                    for turn in turns(across) {
                        let (low, high) = (a[across] + turn - at[across], b[across] + turn - at[across]);
                        if (low <= 0.0) == (high <= 0.0) {
                            continue;
                        }
                        let share = low / (low - high);
                        let met = a[along] + (b[along] - a[along]) * share;
                        for turn in turns(along) {
                            let away = met + turn - at[along];
                            // Rising across, the left side of the piece is towards smaller values along u, larger ones along v.
                            let rises = high > low;
                            let left_is_after = if along == 1 { rises } else { !rises };
                            let inside = (away < 0.0) == left_is_after;
                            if nearest.is_none_or(|(best, _)| away.abs() < best) {
                                nearest = Some((away.abs(), inside));
                            }
                        }
                    }
                }
            }
        }
        nearest.is_some_and(|(_, inside)| inside)
    }
}

impl Brep {
    /// The loops of a face, from its curves in the parameter plane.
    pub(super) fn outline(
        &self,
        face: usize,
        surface: &Surface,
        curves: &[Vec<ParameterCurve>],
    ) -> Result<Outline> {
        let size = surface.points().iter().map(|p| (p - surface.points()[0]).amax()).fold(0.0, f64::max);
        let sides = surface.parameter_sides(1e-6 * size)?;
        let periods = sides.map(|side| side.closed.then_some(side.length()));
        let mut lines = Vec::with_capacity(curves.len());
        for (uses, chain) in self.loops(face).iter().zip(curves) {
            let mut line = Vec::new();
            for (one, curve) in uses.iter().zip(chain) {
                let (from, to) = curve.range();
                let count = LOOKS * (curve.curve().space().breakpoints().len() - 1);
                for k in 0..=count {
                    let share = k as f64 / count as f64;
                    let share = if one.reversed { 1.0 - share } else { share };
                    let at =
                        curve.curve().point(if share >= 1.0 { to } else { from + (to - from) * share })?;
                    line.push([at.x, at.y]);
                }
            }
            if self.is_reversed(face) {
                line.reverse();
            }
            lines.push(line);
        }
        Ok(Outline { lines, periods })
    }

    /// The place of the Brep that is nearest to a point: on each face that may have it, the nearest place of its surface where that is inside the
    /// loops, else the nearest one on its edges, and those that are found downhill from places inside. A search on each such surface.
    ///
    /// # Errors
    /// When the point is not finite, there are no faces, or an evaluation overflows.
    pub fn closest(&self, point: Point) -> Result<FacePlace> {
        if !point.iter().all(|c| c.is_finite()) {
            return Err(Error::Invalid("the point is not finite".into()));
        }
        let mut faces: Vec<(f64, usize)> =
            (0..self.face_count()).map(|face| (self.at_least(face, point), face)).collect();
        faces.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<FacePlace> = None;
        // Some faces at once; those that cannot be nearer than what is found are left out.
        for some in faces.chunks(8) {
            let reach = best.map_or(f64::INFINITY, |best| best.distance);
            let near: Vec<usize> =
                some.iter().filter(|(least, _)| *least <= reach).map(|(_, face)| *face).collect();
            for found in parallel::map(near.len(), |k| self.closest_on(near[k], point)) {
                let found = found?;
                if best.is_none_or(|best| found.distance < best.distance) {
                    best = Some(found);
                }
            }
        }
        best.ok_or_else(|| Error::Invalid("a brep without faces has no place".into()))
    }

    /// No place of a face is nearer than this: the box of its surface's control vertices.
    fn at_least(&self, face: usize, point: Point) -> f64 {
        let net = &self.net[self.range_of(face)];
        let Some(first) = net.first() else { return f64::INFINITY };
        let (low, high) = net.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        let beside = (0..3).map(|k| (low[k] - point[k]).max(point[k] - high[k]).max(0.0));
        beside.map(|d| d * d).sum::<f64>().sqrt()
    }

    fn closest_on(&self, face: usize, point: Point) -> Result<FacePlace> {
        let surface = self.surface(face).ok_or_else(|| Error::Invalid(format!("there is no face {face}")))?;
        let curves: Vec<Vec<ParameterCurve>> = self
            .parameter_curves(face)?
            .into_iter()
            .map(|chain| chain.into_iter().map(|one| one.curve).collect())
            .collect();
        let outline = self.outline(face, &surface, &curves)?;
        let whole = surface.closest(point)?;
        let place = |(u, v): (f64, f64)| -> Result<FacePlace> {
            let at = surface.point(u, v)?;
            Ok(FacePlace { face, at: [u, v], point: at, distance: (at - point).norm() })
        };
        let first = place(whole.at)?;
        if outline.has(first.at) {
            return Ok(first);
        }
        let mut best: Option<FacePlace> = None;
        let mut take = |found: FacePlace| {
            if best.is_none_or(|best| found.distance < best.distance) {
                best = Some(found);
            }
        };
        for curve in curves.iter().flatten() {
            take(place(nearest_along(&surface, curve, point)?)?);
        }
        let sides = [surface.u().domain(), surface.v().domain()];
        for i in 0..STARTS * STARTS {
            let share = |k: usize| (k as f64 + 0.5) / STARTS as f64;
            let start = [share(i / STARTS), share(i % STARTS)];
            let start = [0, 1].map(|k| sides[k].0 + (sides[k].1 - sides[k].0) * start[k]);
            if outline.has(start) {
                let foot = surface.foot(point, (start[0], start[1]))?;
                if outline.has([foot.at.0, foot.at.1]) {
                    take(place(foot.at)?);
                }
            }
        }
        Ok(best.unwrap_or(first))
    }
}

/// The parameters where a surface along a curve in its plane is nearest to a point.
fn nearest_along(surface: &Surface, curve: &ParameterCurve, point: Point) -> Result<(f64, f64)> {
    let (from, to) = curve.range();
    let into = |space: &Space, t: f64| {
        let (a, b) = space.domain();
        if space.is_periodic() || (a..=b).contains(&t) {
            return t;
        }
        // Loops run on where a surface closes.
        let turned = t - ((t - a) / (b - a)).floor() * (b - a);
        turned.clamp(a, b)
    };
    let at = |t: f64| -> Result<((f64, f64), f64)> {
        let c = curve.curve().point(t)?;
        let place = (into(surface.u(), c.x), into(surface.v(), c.y));
        Ok((place, (surface.point(place.0, place.1)? - point).norm()))
    };
    let count = LOOKS * (curve.curve().space().breakpoints().len() - 1);
    let step = (to - from) / count as f64;
    let mut best = (from, at(from)?);
    for k in 1..=count {
        let t = if k == count { to } else { from + step * k as f64 };
        let found = at(t)?;
        if found.1 < best.1.1 {
            best = (t, found);
        }
    }
    let mut reach = step;
    while reach > 1e-12 * (to - from) {
        let before = best.1.1;
        for t in [best.0 - reach, best.0 + reach].map(|t| t.clamp(from, to)) {
            let found = at(t)?;
            if found.1 < best.1.1 {
                best = (t, found);
            }
        }
        if best.1.1 >= before {
            reach *= 0.5;
        }
    }
    Ok(best.1.0)
}
