//! The surface of a face that may move: no larger than the face, with control vertices enough.

use std::collections::BTreeSet;

use super::super::Brep;
use super::touch;
use super::trace::Line;
use crate::Point;
use crate::error::{Error, Result};
use crate::spline::part::Part;
use crate::spline::trimmed::ParameterCurve;
use crate::spline::{Curve, Direction, Product, Space, Surface};

/// The least degree of a surface that is to bend: its pieces then meet with one curvature.
const DEGREE: usize = 3;
/// Of the functions that make a place (their values sum up to 1) at least this part should be able to move.
const FREE: f64 = 0.5;
/// A surface is refined so often that pieces beside a place are halved.
const ROUNDS: usize = 12;
/// And so often where an edge beside it may go along: nearer to that, a place moves with the edge.
const WITHIN: usize = ROUNDS;
/// How far beyond the domain a parameter curve may be by rounding, as a part of it.
const SLACK: f64 = 1e-7;
/// Ends of curves of a loop that are nearer than this part of the domain are one corner.
const NEAR: f64 = 1e-4;
/// Where a seam is put elsewhere, its two sides may be so far apart, as a part of the surface's size.
const CLOSED: f64 = 1e-9;
/// And ends of a surface that are nearer are one, as files give points, where nothing is made of them.
pub(super) const CLOSES: f64 = 1e-7;

/// Whether a place of a surface is on its face.
type Has<'h> = &'h mut dyn FnMut([f64; 2]) -> Result<bool>;

/// A face that may move.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub(super) face: usize,
    pub(super) surface: Surface,
    /// The curves of its loops.
    pub(super) curves: Vec<Vec<ParameterCurve>>,
    /// Whether loops run through them backwards.
    turned: Vec<Vec<bool>>,
    /// What stands still of it, to an order: an edge, or a point of it.
    pub(super) still: Vec<Still>,
    /// Its edges that go along with another face that moves, to the order to which both meet there.
    pub(super) tied: Vec<Still>,
}

/// What of a face stands still.
#[derive(Debug, Clone, Copy)]
pub(super) enum Still {
    /// An edge in a loop, and derivatives across it up to this order; `among` faces that all move it stays since it is a line of parameters of none.
    Edge { edge: usize, chain: usize, number: usize, order: usize, among: bool },
    /// A place where a vertex is that stands still.
    Vertex { vertex: usize, at: [f64; 2] },
}

impl Brep {
    /// A face that may move.
    pub(super) fn sheet(&self, face: usize, places: &[[f64; 2]]) -> Result<Sheet> {
        let surface = self.surface(face).ok_or_else(|| Error::Invalid(format!("there is no face {face}")))?;
        let curves = self.parameter_curves(face)?;
        let curves: Vec<Vec<ParameterCurve>> =
            curves.into_iter().map(|chain| chain.into_iter().map(|one| one.curve).collect()).collect();
        let turned =
            self.loops(face).iter().map(|chain| chain.iter().map(|one| one.reversed).collect()).collect();
        let mut part: Option<Part> = None;
        let mut has = |at: [f64; 2]| -> Result<bool> {
            if part.is_none() {
                part = Some(self.part(face)?);
            }
            Ok(part.as_ref().is_some_and(|part| part.has(at)))
        };
        Sheet::new(face, surface, curves, turned, (places, &mut has))
    }
}

impl Sheet {
    /// The face's surface cut to the box of its loops, or of what is inside beyond these (`has` says whether a place is), of degree 3 or more. Where the face goes across the seam of a closed surface, that is put
    /// elsewhere; parameters then are those in which the loops run on, by periods such that the first of the `places` is among them.
    pub(super) fn new(
        face: usize,
        surface: Surface,
        curves: Vec<Vec<ParameterCurve>>,
        turned: Vec<Vec<bool>>,
        (places, has): (&[[f64; 2]], Has<'_>),
    ) -> Result<Self> {
        let mut sheet = Self { face, surface, curves, turned, still: Vec::new(), tied: Vec::new() };
        if !sheet.curves.is_empty() {
            let reaches = sheet.reaches(has)?;
            for (k, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
                sheet.cut(k, direction, reaches[k], places.first().map(|at| at[k]))?;
            }
        }
        sheet.join_corners()?;
        for direction in [Direction::U, Direction::V] {
            let degree = sheet.surface.space(direction).degree();
            if degree < DEGREE {
                sheet.surface = sheet.surface.elevate(direction, DEGREE - degree)?;
            }
        }
        Ok(sheet)
    }

    /// From where to where its loops reach in a direction.
    fn reach(&self, k: usize) -> Result<(f64, f64)> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for curve in self.curves.iter().flatten() {
            let (from, to) = curve.range();
            let (start, end) = curve.curve().domain();
            let (a, b) = if (from, to) == (start, end) {
                curve.curve().bounds()
            } else {
                curve.curve().between(from, to)?.bounds()
            };
            (low, high) = (low.min(a[k]), high.max(b[k]));
        }
        Ok((low, high))
    }

    /// From where to where the face reaches in each direction: beyond its loops where the surface goes on to a pole, or closes, and what is there is inside.
    fn reaches(&self, has: Has<'_>) -> Result<[(f64, f64); 2]> {
        let size = self.surface.points().iter().map(|p| (p - self.surface.points()[0]).amax());
        let sides = self.surface.parameter_sides(CLOSES * size.fold(0.0, f64::max))?;
        let mut reaches = [self.reach(0)?, self.reach(1)?];
        for (k, (low, high)) in reaches.iter_mut().enumerate() {
            let side = &sides[k];
            let slack = SLACK * side.length();
            // No loop is beyond the loops: one place tells of all there.
            let mut is_inside = |t: f64| {
                let mut at = [0, 1].map(|d: usize| 0.5 * (sides[d].low + sides[d].high));
                at[k] = t;
                has(at)
            };
            if side.closed {
                let rest = *low + side.length() - *high;
                if rest > slack && is_inside(side.wrapped(*high + 0.5 * rest))? {
                    let runs_over = *low < side.low - slack || *high > side.high + slack;
                    (*low, *high) =
                        if runs_over { (*low, *low + side.length()) } else { (side.low, side.high) };
                }
                continue;
            }
            if side.poles[0] && *low > side.low + slack && is_inside(0.5 * (side.low + *low))? {
                *low = side.low;
            }
            if side.poles[1] && *high < side.high - slack && is_inside(0.5 * (*high + side.high))? {
                *high = side.high;
            }
        }
        Ok(reaches)
    }

    fn cut(
        &mut self,
        k: usize,
        direction: Direction,
        (mut low, mut high): (f64, f64),
        place: Option<f64>,
    ) -> Result<()> {
        let space = self.surface.space(direction);
        let (start, end) = space.domain();
        if space.is_periodic() {
            return Ok(());
        }
        let (slack, period) = (SLACK * (end - start), end - start);
        if low < start - slack || high > end + slack {
            if high > low + period + slack {
                return Err(Error::Invalid(format!(
                    "a loop of face {} runs more than once around its surface (its {} from {low} to {high} over [{start}, {end}]), so that it \
                     cannot be moved: let another face move",
                    self.face,
                    ["u", "v"][k],
                )));
            }
            let size = self.surface.points().iter().map(|p| (p - self.surface.points()[0]).amax());
            let size = size.fold(0.0, f64::max);
            let closed = self.surface.to_periodic(direction, CLOSED * size).map_err(|e| {
                Error::Invalid(format!(
                    "a loop of face {} leaves the domain of its surface (its {} runs from {low} to {high} over [{start}, {end}]): {e}",
                    self.face,
                    ["u", "v"][k],
                ))
            })?;
            // By whole periods to where something is asked.
            let inside = |at: f64, shift: f64| at >= low + shift - slack && at <= high + shift + slack;
            let shift = place.map_or(0.0, |at| {
                let turns = [0.0, 1.0, -1.0, 2.0, -2.0].map(|turn| turn * period);
                turns.into_iter().find(|shift| inside(at, *shift)).unwrap_or(0.0)
            });
            let knots = space.breakpoints();
            self.shift(k, shift)?;
            (low, high) = (low + shift, high + shift);
            let snapped = |t: f64| {
                let turn = ((t - start) / period).floor() * period;
                let near = knots.iter().copied().find(|knot| (knot + turn - t).abs() <= slack);
                near.map_or(t, |knot| knot + turn)
            };
            (low, high) = (snapped(low), snapped(high));
            high = if high > low + period - slack { low + period } else { high };
            let part = closed.shape.between(direction, low, high)?;
            self.surface = part.reparametrise(direction, low, high)?;
            return Ok(());
        }
        // Where a loop reaches as far as a knot but for rounding, between the two would be a sliver.
        let knots = space.breakpoints();
        let snapped = |t: f64| knots.iter().copied().find(|knot| (knot - t).abs() <= slack).unwrap_or(t);
        let (from, to) = (snapped(low).max(start), snapped(high).min(end));
        if (from, to) != (start, end) && from < to {
            self.surface = self.surface.between(direction, from, to)?;
        }
        Ok(())
    }

    /// Moves the curves of its loops in the parameter plane.
    fn shift(&mut self, k: usize, by: f64) -> Result<()> {
        if by == 0.0 {
            return Ok(());
        }
        for one in self.curves.iter_mut().flatten() {
            let (from, to) = one.range();
            let (space, mut points, weights) = one.curve().clone().into_parts();
            points.iter_mut().for_each(|p| p[k] += by);
            *one = ParameterCurve::new(Curve::build(space, points, weights)?, from, to)?;
        }
        Ok(())
    }

    /// Makes each curve of a loop end at the very parameters where the next one starts, and lines of constant parameters straight: what is
    /// asked of a corner by both its edges is then one equation, and not nearly one.
    fn join_corners(&mut self) -> Result<()> {
        let spaces = [self.surface.u(), self.surface.v()];
        let domains = spaces.map(Space::domain);
        let into = |k: usize, t: f64| {
            let (a, b) = domains[k];
            if spaces[k].is_periodic() { t } else { t.clamp(a, b) }
        };
        let same = [0, 1].map(|k| SLACK * (domains[k].1 - domains[k].0));
        // Lines that are one but for rounding are one.
        let mut known: [Vec<f64>; 2] = spaces.map(Space::breakpoints);
        for (chain, turned) in self.curves.iter_mut().zip(&self.turned) {
            let count = chain.len();
            let mut lines: Vec<Option<Line>> = chain.iter().map(Line::of).collect();
            for line in lines.iter_mut().flatten() {
                let k = usize::from(line.along_u);
                match known[k].iter().find(|at| (line.at - **at).abs() <= same[k]) {
                    Some(at) => line.at = *at,
                    None => known[k].push(line.at),
                }
            }
            let mut ends: Vec<[[f64; 2]; 2]> =
                chain.iter().map(ParameterCurve::ends).collect::<Result<_>>()?;
            for (line, ends) in lines.iter().zip(&mut ends) {
                if let Some(line) = line {
                    ends.iter_mut().for_each(|end| end[usize::from(line.along_u)] = line.at);
                }
            }
            for first in 0..count {
                let second = (first + 1) % count;
                let (out, back) = (usize::from(!turned[first]), usize::from(turned[second]));
                let (mut at, other) = (ends[first][out], ends[second][back]);
                if (0..2).any(|k| (at[k] - other[k]).abs() > NEAR * (domains[k].1 - domains[k].0)) {
                    continue;
                }
                // Where the second is a line, the corner is on it; the first's own is kept.
                if let Some(line) = lines[second] {
                    at[usize::from(line.along_u)] = line.at;
                }
                if let Some(line) = lines[first] {
                    at[usize::from(line.along_u)] = line.at;
                }
                let at = [0, 1].map(|k| {
                    let near = known[k].iter().copied().find(|line| (at[k] - line).abs() <= same[k]);
                    near.unwrap_or_else(|| into(k, at[k]))
                });
                (ends[first][out], ends[second][back]) = (at, at);
            }
            for ((one, line), ends) in chain.iter_mut().zip(&lines).zip(&ends) {
                *one = ending(one, line.is_some(), ends)?;
            }
        }
        Ok(())
    }

    /// Its control vertices that stand still, by its own numbers.
    pub(super) fn held(&self) -> Result<BTreeSet<usize>> {
        let mut held = BTreeSet::new();
        for still in &self.still {
            held.append(&mut self.held_by(still)?);
        }
        Ok(held)
    }

    fn held_by(&self, still: &Still) -> Result<BTreeSet<usize>> {
        let product = self.surface.product();
        match *still {
            Still::Edge { chain, number, order, .. } => {
                touch::along(&product, &self.curves[chain][number], order)
            }
            Still::Vertex { at: [u, v], .. } => Ok(touch::at(&product, Point::new(u, v, 0.0), 0)),
        }
    }

    /// Knots inserted around places until at each of them there is freedom, and, where it is not too near to an edge, there is as much of it
    /// while all edges stay where they are: what a face can do alone it can do beside faces that may go along.
    pub(super) fn freed(&mut self, places: &[[f64; 2]]) -> Result<()> {
        for &[u, v] in places {
            let outside = |e: Error| Error::Invalid(format!("a place on face {}: {e}", self.face));
            let (u, v) =
                (self.surface.u().locate(u).map_err(outside)?, self.surface.v().locate(v).map_err(outside)?);
            let mut round = 0;
            while self.freedom((u, v), &[])? < FREE {
                round += 1;
                if round > ROUNDS {
                    return Err(self.too_near([u, v])?);
                }
                self.halved(Direction::U, u)?;
                self.halved(Direction::V, v)?;
            }
            let enough = self.surface.clone();
            for _ in 0..WITHIN {
                if self.freedom((u, v), &self.tied)? >= FREE {
                    break;
                }
                self.halved(Direction::U, u)?;
                self.halved(Direction::V, v)?;
            }
            if self.freedom((u, v), &self.tied)? < FREE {
                self.surface = enough;
            }
        }
        Ok(())
    }

    /// How much of what makes a place can move, while these edges stand still, too: from 0 to 1.
    fn freedom(&self, (u, v): (f64, f64), beside: &[Still]) -> Result<f64> {
        let mut held = self.held()?;
        for edge in beside {
            held.append(&mut self.held_by(edge)?);
        }
        let row = self.surface.product().stencil((u, v), crate::shape::Derivative::POSITION, None)?;
        Ok(row.iter().filter(|(vertex, _)| !held.contains(vertex)).map(|(_, c)| c).sum())
    }

    /// What keeps a place where it is.
    fn too_near(&self, [u, v]: [f64; 2]) -> Result<Error> {
        let row = self.surface.product().stencil((u, v), crate::shape::Derivative::POSITION, None)?;
        let further = "choose a place further inside";
        let (mut by, mut remedy) = (
            "what stands still".to_owned(),
            format!("let the neighbours move too (\"neighbours\": 1), or {further}"),
        );
        for still in &self.still {
            let held = self.held_by(still)?;
            if row.vertices().iter().any(|vertex| held.contains(vertex)) {
                by = match still {
                    Still::Edge { edge, among: true, .. } => {
                        further.clone_into(&mut remedy);
                        format!(
                            "edge {edge}, which stays where it is though its faces move, as it is a line of constant parameters of none of them"
                        )
                    }
                    Still::Edge { edge, .. } => format!("edge {edge}, which stays where it is"),
                    Still::Vertex { vertex, .. } => {
                        format!(
                            "vertex {vertex}, which stays where it is since a face does that meets it there"
                        )
                    }
                };
                break;
            }
        }
        Ok(Error::Invalid(format!("[{u}, {v}] of face {} is on, or too near to, {by}: {remedy}", self.face)))
    }

    /// The spans around a parameter halved.
    fn halved(&mut self, direction: Direction, at: f64) -> Result<()> {
        let space = self.surface.space(direction);
        let reach = space.degree();
        let spans: Vec<usize> = space.spans().collect();
        let own = spans.partition_point(|&s| s < space.span(at));
        let around = own.saturating_sub(reach)..(own + reach + 1).min(spans.len());
        let flat = space.flat();
        let middle = |s: usize| 0.5 * (flat[s] + flat[s + 1]);
        let longest = flat[spans[own] + 1] - flat[spans[own]];
        // Those beside it that are shorter already stay.
        let wide = |s: &usize| flat[*s + 1] - flat[*s] >= longest;
        let knots: Vec<f64> = spans[around]
            .iter()
            .copied()
            .filter(wide)
            .map(middle)
            .filter(|knot| space.multiplicity(*knot) == 0)
            .collect();
        if !knots.is_empty() {
            self.surface = self.surface.insert_knots(direction, &knots)?;
        }
        Ok(())
    }

    /// At least this degree in the direction that runs along a line.
    pub(super) fn elevated(&mut self, line: &Line, degree: usize) -> Result<()> {
        let direction = if line.along_u { Direction::U } else { Direction::V };
        let own = self.surface.space(direction).degree();
        if own < degree {
            self.surface = self.surface.elevate(direction, degree - own)?;
        }
        Ok(())
    }

    /// The breakpoints of the direction that runs along a line, inside of it.
    pub(super) fn breaks_along(&self, line: &Line) -> Vec<f64> {
        let direction = if line.along_u { Direction::U } else { Direction::V };
        let (low, high) = (line.from.min(line.to), line.from.max(line.to));
        let sliver = SLACK * (high - low);
        let breaks = self.surface.space(direction).breakpoints();
        breaks.into_iter().filter(|t| *t > low + sliver && *t < high - sliver).collect()
    }

    /// These knots in the direction that runs along a line, so often each, beside those that it has: what is one of these but for rounding
    /// is that.
    pub(super) fn knotted(&mut self, line: &Line, knots: &[(f64, usize)]) -> Result<()> {
        let direction = if line.along_u { Direction::U } else { Direction::V };
        let (low, high) = (line.from.min(line.to), line.from.max(line.to));
        let sliver = SLACK * (high - low);
        let space = self.surface.space(direction);
        let known = self.breaks_along(line);
        let mut all: Vec<(f64, usize)> = Vec::new();
        for &(knot, times) in knots.iter().filter(|(t, _)| *t > low + sliver && *t < high - sliver) {
            let next = known.partition_point(|t| *t < knot);
            let beside = known[next.saturating_sub(1)..].iter().take(2);
            let own = beside.copied().find(|t| (t - knot).abs() <= sliver).unwrap_or(knot);
            all.push((own, times.min(space.degree())));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        all.dedup_by(|b, a| b.0 - a.0 <= sliver);
        let knots: Vec<f64> = all
            .into_iter()
            .flat_map(|(t, times)| std::iter::repeat_n(t, times.saturating_sub(space.multiplicity(t))))
            .collect();
        if !knots.is_empty() {
            self.surface = self.surface.insert_knots(direction, &knots)?;
        }
        Ok(())
    }

    /// At least so many spans of the direction that runs along a line, over it.
    pub(super) fn spanned(&mut self, line: &Line, count: usize) -> Result<()> {
        let direction = if line.along_u { Direction::U } else { Direction::V };
        let (low, high) = (line.from.min(line.to), line.from.max(line.to));
        let space = self.surface.space(direction);
        let mut breaks = vec![low];
        // What is between a knot and an end that lies on it but for rounding is no span.
        let sliver = SLACK * (high - low);
        breaks.extend(space.breakpoints().into_iter().filter(|t| *t > low + sliver && *t < high - sliver));
        breaks.push(high);
        breaks.dedup_by(|b, a| *b - *a <= sliver);
        let each = count.div_ceil(breaks.len() - 1);
        let mut knots = Vec::new();
        for pair in breaks.windows(2) {
            knots.extend((1..each).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / each as f64)));
        }
        if !knots.is_empty() {
            self.surface = self.surface.insert_knots(direction, &knots)?;
        }
        Ok(())
    }

    /// Its surface without control vertices, numbered from `first` on.
    pub(super) fn product(&self, first: usize) -> Product<'_> {
        Product { first, ..self.surface.product() }
    }
}

/// A curve with its ends moved to these parameters; of a line, the straight one between them.
fn ending(curve: &ParameterCurve, line: bool, [start, end]: &[[f64; 2]; 2]) -> Result<ParameterCurve> {
    let point = |at: &[f64; 2]| Point::new(at[0], at[1], 0.0);
    if line {
        let (from, to) = curve.range();
        let space = Space::clamped(1, &[from, to])?;
        return ParameterCurve::whole(Curve::new(space, vec![point(start), point(end)])?);
    }
    let (from, to) = curve.range();
    let (space, mut points, weights) = curve.curve().between(from, to)?.into_parts();
    let last = points.len() - 1;
    points[0] = point(start);
    points[last] = point(end);
    ParameterCurve::whole(Curve::build(space, points, weights)?)
}
