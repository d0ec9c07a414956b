//! The place of a Brep that is nearest to a point.

use std::collections::HashMap;

use super::Brep;
use crate::error::{Error, Result};
use crate::spline::closest::Kept;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{ParameterSide, Surface};
use crate::{Point, parallel};

/// Places of each span of a loop's curve at which the nearest one is looked for.
const LOOKS: usize = 16;
/// Chords of each span of a loop's curve: a quarter of a circle is a 10,000th of its radius from them.
const CHORDS: usize = 48;
/// The most cells in each direction in which chords are looked up.
const CELLS: usize = 256;

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
    /// The parameters of the surface in equal cells, and the chords whose boxes reach into each, shifted by the periods that bring them there.
    sides: [ParameterSide; 2],
    cells: usize,
    chords: Vec<Vec<[[f64; 2]; 2]>>,
}

impl Kept for Outline {
    fn has(&self, at: [f64; 2]) -> bool {
        Self::has(self, at)
    }

    fn share(&self, box_: [(f64, f64); 2]) -> Option<bool> {
        let of = |d: usize, x: f64| cell(&self.sides[d], self.cells, x);
        let range = |d: usize| of(d, box_[d].0)..=of(d, box_[d].1);
        for i in range(0) {
            for j in range(1) {
                if self.chords[i * self.cells + j].iter().any(|chord| reaches(chord, &box_)) {
                    return None;
                }
            }
        }
        Some(Self::has(self, box_.map(|(low, high)| 0.5 * low + 0.5 * high)))
    }
}

/// The number of the cell, of so many, of a parameter.
fn cell(side: &ParameterSide, cells: usize, x: f64) -> usize {
    let share = (x - side.low) / side.length() * cells as f64;
    // Below 0 it is 0, and so is what is no number.
    (share as usize).min(cells - 1)
}

/// Whether a chord reaches into a box, its border included.
fn reaches([a, b]: &[[f64; 2]; 2], box_: &[(f64, f64); 2]) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for d in 0..2 {
        let (low, high) = box_[d];
        let step = b[d] - a[d];
        if step == 0.0 {
            if a[d] < low || a[d] > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - a[d]) / step, (high - a[d]) / step);
        (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
    }
    // Rounding does not make a chord miss a box.
    from <= to + 1e-12
}

impl Outline {
    fn new(lines: Vec<Vec<[f64; 2]>>, sides: [ParameterSide; 2]) -> Self {
        let periods = sides.map(|side| side.closed.then_some(side.length()));
        let count: usize = lines.iter().map(Vec::len).sum();
        let cells = ((count as f64).sqrt() as usize).clamp(1, CELLS);
        let mut chords = vec![Vec::new(); cells * cells];
        let turns = |k: usize| periods[k].map_or(vec![0.0], |t| vec![-2.0 * t, -t, 0.0, t, 2.0 * t]);
        let shifts: Vec<[f64; 2]> =
            turns(0).into_iter().flat_map(|u| turns(1).into_iter().map(move |v| [u, v])).collect();
        for (a, b) in lines.iter().flat_map(|line| line.iter().zip(line.iter().skip(1))) {
            for by in &shifts {
                let chord = [a, b].map(|p| [p[0] + by[0], p[1] + by[1]]);
                let range = |d: usize| {
                    let (low, high) = (chord[0][d].min(chord[1][d]), chord[0][d].max(chord[1][d]));
                    // What lies along an end of the domain is at it, but for rounding.
                    let near = 1e-9 * sides[d].length();
                    let beside = high < sides[d].low - near || low > sides[d].high + near;
                    (!beside).then(|| cell(&sides[d], cells, low)..=cell(&sides[d], cells, high))
                };
                let (Some(rows), Some(columns)) = (range(0), range(1)) else { continue };
                for i in rows {
                    for j in columns.clone() {
                        chords[i * cells + j].push(chord);
                    }
                }
            }
        }
        Self { lines, periods, sides, cells, chords }
    }

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
        // A seam bounds nothing: what is on its one side goes on on the other.
        let mut known: HashMap<usize, Vec<[f64; 2]>> = HashMap::new();
        for (one, curve) in
            self.loops(face).iter().zip(curves).flat_map(|(uses, chain)| uses.iter().zip(chain))
        {
            let start = curve.curve().point(curve.range().0)?;
            known.entry(one.edge).or_default().push([start.x, start.y]);
        }
        let is_seam = |edge: usize| match known.get(&edge).map(Vec::as_slice) {
            Some([a, b]) => (0..2).any(|d| {
                let away = (a[d] - b[d]).abs() / sides[d].length();
                sides[d].closed && (away - 1.0).abs() <= 1e-6
            }),
            _ => false,
        };
        let mut lines = Vec::with_capacity(curves.len());
        for (uses, chain) in self.loops(face).iter().zip(curves) {
            let mut line = Vec::new();
            for (one, curve) in uses.iter().zip(chain) {
                if is_seam(one.edge) {
                    lines.push(std::mem::take(&mut line));
                    continue;
                }
                let (from, to) = curve.range();
                let count = CHORDS * (curve.curve().space().breakpoints().len() - 1);
                for k in 0..=count {
                    let share = k as f64 / count as f64;
                    let share = if one.reversed { 1.0 - share } else { share };
                    let at =
                        curve.curve().point(if share >= 1.0 { to } else { from + (to - from) * share })?;
                    line.push([at.x, at.y]);
                }
            }
            lines.push(line);
        }
        lines.retain(|line| line.len() > 1);
        if self.is_reversed(face) {
            lines.iter_mut().for_each(|line| line.reverse());
        }
        Ok(Outline::new(lines, sides))
    }

    /// The place of the Brep that is nearest to a point: on each face that may have it, the nearest place of its surface where that is inside the
    /// loops, else the nearest one of what is inside and of the edges. A search or two on each such surface.
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
        let place = |(u, v): (f64, f64)| -> Result<FacePlace> {
            let at = [outline.sides[0].wrapped(u), outline.sides[1].wrapped(v)];
            let on = surface.point(at[0], at[1])?;
            Ok(FacePlace { face, at, point: on, distance: (on - point).norm() })
        };
        let first = place(surface.closest(point)?.at)?;
        if outline.has(first.at) {
            return Ok(first);
        }
        let mut border: Option<((f64, f64), f64)> = None;
        for curve in curves.iter().flatten() {
            let found = nearest_along(&surface, &outline.sides, curve, point)?;
            if border.is_none_or(|(_, best)| found.1 < best) {
                border = Some(found);
            }
        }
        // Without a border all of it is inside.
        let Some((start, _)) = border else { return Ok(first) };
        place(surface.closest_kept(point, &outline, start)?.at)
    }
}

/// The parameters where a surface along a curve in its plane is nearest to a point, and how near: downhill from each place that is nearer than
/// those beside it.
fn nearest_along(
    surface: &Surface,
    sides: &[ParameterSide; 2],
    curve: &ParameterCurve,
    point: Point,
) -> Result<((f64, f64), f64)> {
    let (from, to) = curve.range();
    // Loops run on where a surface closes; elsewhere they are outside by rounding alone.
    let into = |d: usize, t: f64| sides[d].wrapped(t);
    let at = |t: f64| -> Result<((f64, f64), f64)> {
        let c = curve.curve().point(t)?;
        let place = (into(0, c.x), into(1, c.y));
        Ok((place, (surface.point(place.0, place.1)? - point).norm()))
    };
    let count = LOOKS * (curve.curve().space().breakpoints().len() - 1);
    let step = (to - from) / count as f64;
    let parameter = |k: usize| if k == count { to } else { from + step * k as f64 };
    let looks: Vec<((f64, f64), f64)> = (0..=count).map(|k| at(parameter(k))).collect::<Result<_>>()?;
    let mut best = looks[0];
    for (k, look) in looks.iter().enumerate() {
        let beside = [k.saturating_sub(1), (k + 1).min(count)].map(|k| looks[k].1);
        // Between two looks it comes no nearer than by what it does from one to the next, or so.
        let gain = beside.map(|other| (other - look.1).abs()).into_iter().fold(0.0, f64::max);
        if beside.iter().any(|other| *other < look.1) || look.1 - gain > best.1 {
            continue;
        }
        let mut found = (parameter(k), *look);
        let mut reach = step;
        while reach > 1e-12 * (to - from) {
            let before = found.1.1;
            for t in [found.0 - reach, found.0 + reach].map(|t| t.clamp(from, to)) {
                let next = at(t)?;
                if next.1 < found.1.1 {
                    found = (t, next);
                }
            }
            if found.1.1 >= before {
                reach *= 0.5;
            }
        }
        if found.1.1 < best.1 {
            best = found.1;
        }
    }
    Ok(best)
}
