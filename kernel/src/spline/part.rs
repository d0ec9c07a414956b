//! The part of a surface that loops bound, prepared for many questions: whether a place is in it, and which place of it is nearest.

use super::closest::{Closest, Kept};
use super::trimmed::ParameterCurve;
use super::{ParameterSide, Surface};
use crate::Point;
use crate::error::Result;

/// Places of each span of a loop's curve at which the nearest one is looked for.
const LOOKS: usize = 16;
/// Chords of each span of a loop's curve: a quarter of a circle is a 10,000th of its radius from them.
const CHORDS: usize = 48;
/// The most cells in each direction in which chords are looked up.
const CELLS: usize = 256;

/// The part of a surface that loops in its parameter plane bound: of a trimmed surface ([`Trimmed::part`](super::trimmed::Trimmed::part)) or of a face
/// ([`Brep::part`](crate::brep::Brep::part)).
///
/// Where the border of it is, is known to the chords that stand for its curves, 48 of each span.
pub struct Part {
    surface: Surface,
    outline: Outline,
    border: Vec<ParameterCurve>,
}

impl std::fmt::Debug for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Part")
            .field("surface", &self.surface)
            .field("border", &self.border)
            .finish_non_exhaustive()
    }
}

impl Part {
    /// Lines with the part on their left (none: all of the surface), and the curves of its border.
    pub(crate) fn new(
        surface: Surface,
        lines: Vec<Vec<[f64; 2]>>,
        sides: [ParameterSide; 2],
        border: Vec<ParameterCurve>,
    ) -> Self {
        Self { surface, outline: Outline::new(lines, sides), border }
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The curves of its border, in the parameter plane.
    pub fn border(&self) -> &[ParameterCurve] {
        &self.border
    }

    /// Whether a place is in it. `O(chords)`.
    pub fn has(&self, at: [f64; 2]) -> bool {
        self.outline.has(at)
    }

    /// The parameters within the domain of a place that may be beyond an end at which the surface closes; elsewhere the nearest ones.
    pub fn wrapped(&self, at: [f64; 2]) -> [f64; 2] {
        [self.outline.sides[0].wrapped(at[0]), self.outline.sides[1].wrapped(at[1])]
    }

    /// The place of it that is nearest to a point: the nearest place of the surface where that is in it, else the nearest one of what is inside and of
    /// its border. One search or two, as [`Surface::closest`].
    ///
    /// # Errors
    /// When the point is not finite, or an evaluation overflows.
    pub fn closest(&self, point: Point) -> Result<Closest<(f64, f64)>> {
        let place = |found: Closest<(f64, f64)>| -> Result<Closest<(f64, f64)>> {
            let [u, v] = self.wrapped(found.at.into());
            let on = self.surface.point(u, v)?;
            Ok(Closest { at: (u, v), point: on, distance: (on - point).norm(), gap: found.gap })
        };
        let first = place(self.surface.closest(point)?)?;
        if self.has(first.at.into()) {
            return Ok(first);
        }
        let border = self.nearest_of_border(point)?;
        // Without a border all of it is inside.
        let Some((start, _)) = border else { return Ok(first) };
        place(self.surface.closest_kept(point, &self.outline, start)?)
    }

    /// A distance of the part from a point that is never less than the true one: that of the nearest place of the surface where that is in the part, which is the true
    /// one, else of the nearest place of the border. It costs a search of the surface and a walk along the border, where [`closest`](Self::closest) may look at
    /// ten thousand pieces.
    ///
    /// # Errors
    /// As for [`closest`](Self::closest).
    pub fn distance_at_most(&self, point: Point) -> Result<f64> {
        let foot = self.surface.closest_foot(point)?;
        if self.has(self.wrapped(foot.at.into())) {
            return Ok(foot.distance);
        }
        Ok(self.nearest_of_border(point)?.map_or(foot.distance, |(_, distance)| distance))
    }

    /// The place of the border that is nearest to a point, and how near.
    fn nearest_of_border(&self, point: Point) -> Result<Option<((f64, f64), f64)>> {
        let mut border: Option<((f64, f64), f64)> = None;
        for curve in &self.border {
            let found = nearest_along(&self.surface, &self.outline.sides, curve, point)?;
            if border.is_none_or(|(_, best)| found.1 < best) {
                border = Some(found);
            }
        }
        Ok(border)
    }
}

/// The chords of a curve in the parameter plane, added to a line: from its start to its end, or backwards.
pub(crate) fn follow(line: &mut Vec<[f64; 2]>, curve: &ParameterCurve, backwards: bool) -> Result<()> {
    let (from, to) = curve.range();
    let count = CHORDS * (curve.curve().space().breakpoints().len() - 1);
    for k in 0..=count {
        let share = k as f64 / count as f64;
        let share = if backwards { 1.0 - share } else { share };
        let at = curve.curve().point(if share >= 1.0 { to } else { from + (to - from) * share })?;
        line.push([at.x, at.y]);
    }
    Ok(())
}

/// Loops as lines in the parameter plane, each run through with the face on its left. Those that go around a closed surface end a
/// period from where they start.
struct Outline {
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
    fn has(&self, at: [f64; 2]) -> bool {
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
