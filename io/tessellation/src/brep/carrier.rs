//! The surface of a face, prepared: its patches, what of it is one (seams, poles), where it creases, how much it bends.

use std::sync::Arc;

use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point, Result, Vector};

use super::bounds::{Bounds, Spread, exactly};
use crate::fineness::Frame;
use crate::normals::normal;
use crate::patch::{Homogeneous, Jet, Patch, Patches, project};
use crate::weights;

/// Of boxes across more patches than this the cells are enough.
const MOST_PATCHES: usize = 6;
/// The least part of a patch that derivatives are bounded over.
const THIN: f64 = 1e-6;
/// Steps to a foot at most, and those that are too short (in the frame) to be taken: they end in rounding.
const DESCENTS: usize = 30;
const STILL: f64 = 1e-15;
/// A step no longer than this that leads no closer has met rounding.
const ALMOST_STILL: f64 = 1e-10;
/// Of a point that is not on the surface, the part of its distance by which another place of the surface may be nearer than the one found.
const OFF: f64 = 1e-3;
/// The most pieces of a surface that are looked at for where one edge is on it, about a second's work. On files of CAD programs a place takes some tens, if
/// it is not found without; on those with one wrong number in them all places of an edge may be about as far from any number of pieces.
const SEARCHED: usize = 100_000;
/// So many patches cost as much as one piece before any is looked at.
const PREPARED: usize = 16;
/// Points of a surface's own edges that are closer than this, in the frame of the whole, are one.
const ONE_POINT: f64 = 1e-9;

/// How long places of an edge on a surface may still be searched for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Searches(usize);

impl Default for Searches {
    fn default() -> Self {
        Self(SEARCHED)
    }
}

impl Searches {
    /// Whether places are no longer searched for all over the surface.
    pub(crate) fn are_over(self) -> bool {
        self.0 == 0
    }

    /// How many pieces may be looked at: one at least, so that there is a place.
    fn left(self) -> usize {
        self.0.max(1)
    }

    fn spend(&mut self, pieces: usize) {
        self.0 = self.0.saturating_sub(pieces);
    }
}

/// A direction of a surface's parameters.
#[derive(Debug)]
pub(crate) struct Side {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether the surface closes in it.
    pub(crate) closed: bool,
    /// Where in it triangles must not reach across: creases, and both ends where it closes; ascending.
    pub(crate) lines: Vec<f64>,
    /// What the first derivative jumps by at the other knots, where it does at all; ascending.
    jumps: Vec<(f64, f64)>,
}

impl Side {
    pub(crate) fn length(&self) -> f64 {
        self.high - self.low
    }

    /// The same place within the domain, where the direction is closed.
    pub(crate) fn wrapped(&self, x: f64) -> f64 {
        if !self.closed {
            return x;
        }
        let x = x - self.length() * ((x - self.low) / self.length()).floor();
        if x >= self.high { self.low } else { x.max(self.low) }
    }

    /// The same place, as near to another as it can be.
    pub(crate) fn unwrapped(&self, x: f64, near: f64) -> f64 {
        if self.closed { x + self.length() * ((near - x) / self.length()).round() } else { x }
    }
}

/// A surface as faces need it. Points are in the frame of the whole, parameters are the surface's own.
#[derive(Debug)]
pub(crate) struct Carrier {
    pub(crate) surface: Surface,
    frame: Frame,
    patches: Arc<[Patch]>,
    breaks: [Vec<f64>; 2],
    pub(crate) sides: [Side; 2],
    /// The point that a side of the domain is, where it is one: `[u or v][low or high]`.
    pub(crate) poles: [[Option<Vector>; 2]; 2],
    pub(crate) bounds: Bounds,
    /// Whether it does not bend at all.
    pub(crate) flat: bool,
    /// Of a plane whose parameters are coordinates on it, how to find these.
    affine: Option<Affine>,
}

/// A plane `origin + u a + v b`, over a domain. Feet are found by a division each.
#[derive(Debug)]
struct Affine {
    origin: Vector,
    along: [Vector; 2],
    /// The vectors that have the product 1 with one of these and 0 with the other.
    dual: [Vector; 2],
    /// The unit normal.
    normal: Vector,
    low: [f64; 2],
    high: [f64; 2],
}

impl Affine {
    /// Of a single patch of degree 1 in both directions that is a parallelogram, to rounding.
    fn of(patches: &[Patch], breaks: &[Vec<f64>; 2]) -> Option<Self> {
        let [patch] = patches else { return None };
        let (false, 2, 2) = (patch.rational, patch.rows, patch.columns) else { return None };
        let [a, b, c, d] = [0, 1, 2, 3].map(|k: usize| project(&patch.net[k]));
        let low = [breaks[0][0], breaks[1][0]];
        let high = [breaks[0][1], breaks[1][1]];
        let along = [(c - a) / (high[0] - low[0]), (b - a) / (high[1] - low[1])];
        let [uu, uv, vv] = [along[0].norm_squared(), along[0].dot(&along[1]), along[1].norm_squared()];
        let area = uu * vv - uv * uv;
        let size = (c - a).norm().max((b - a).norm());
        // Slanted directions and long strips would lose digits: those are searched for as on any surface.
        if (d - c - (b - a)).norm() > 1e-14 * size || area.is_nan() || area <= 1e-2 * uu * vv {
            return None;
        }
        let dual = [(along[0] * vv - along[1] * uv) / area, (along[1] * uu - along[0] * uv) / area];
        let normal = normal(patch, [0.5; 2], &patch.jet([0.5; 2]));
        Some(Self { origin: a, along, dual, normal, low, high })
    }

    /// The nearest place, where it lies within the domain or is brought there by rounding alone, and its distance.
    fn foot(&self, point: &Vector) -> Option<([f64; 2], f64)> {
        let off = point - self.origin;
        let mut at = [0.0; 2];
        for d in 0..2 {
            let (low, high) = (self.low[d], self.high[d]);
            let x = low + self.dual[d].dot(&off);
            at[d] = x.clamp(low, high);
            if (x - at[d]).abs() > 1e-12 * (high - low) || x.is_nan() {
                return None;
            }
        }
        let on = self.along[0] * (at[0] - self.low[0]) + self.along[1] * (at[1] - self.low[1]);
        Some((at, (off - on).norm()))
    }
}

impl Carrier {
    /// `chord` is the tolerance in the frame; `one` is how near to each other sides are one: where a surface
    /// that is not periodic closes, and where a side is a point. `None` for those of no other: they are left apart.
    ///
    /// # Errors
    /// When the surface is torn at a knot, or its weights are too unlike.
    pub(crate) fn new(surface: Surface, frame: Frame, chord: f64, one: Option<f64>) -> Result<Self> {
        let spaces = [surface.u(), surface.v()];
        let domains = spaces.map(|space| space.domain());
        let of = Patches::new(&surface, &frame);
        let counts = of.counts();
        let breaks = [0, 1].map(|d: usize| {
            let mut ends = (0..counts[d]).map(|k| of.ends(d, k));
            let mut all: Vec<f64> = ends.clone().map(|(a, _)| a).collect();
            all.extend(ends.next_back().map(|(_, b)| b));
            all
        });
        let patches: Arc<[Patch]> =
            (0..counts[0] * counts[1]).map(|k| of.get(k / counts[1], k % counts[1])).collect();
        if surface.weights().is_some() {
            patches.iter().try_for_each(|patch| weights::resolved_net(&patch.net, patch.columns))?;
        }
        let net = Net { patches: &patches, counts, one: one.unwrap_or(0.0).max(ONE_POINT) };
        let poles = [0, 1].map(|d| [0, 1].map(|end| net.pole(d, end)));
        let bounds = Bounds::new(Arc::clone(&patches), &breaks);
        let mut sides = Vec::with_capacity(2);
        for d in 0..2 {
            let (low, high) = domains[d];
            let closed = spaces[d].is_periodic() || one.is_some() && net.meets(d, counts[d] - 1, 0);
            let mut side = Side { low, high, closed, lines: Vec::new(), jumps: Vec::new() };
            if closed {
                side.lines.push(low);
            }
            for k in 1..counts[d] {
                let at = breaks[d][k];
                if spaces[d].multiplicity(at) < spaces[d].degree() {
                    continue;
                }
                if !net.meets(d, k - 1, k) {
                    let name = ["u", "v"][d];
                    return Err(Error::Invalid(format!(
                        "its surface is torn at {name} = {at}: split it there, and the face with it"
                    )));
                }
                let around = [at - breaks[d][k - 1], breaks[d][k + 1] - at];
                let jump = net.jump(d, k, around);
                if jump * (around[0] + around[1]) > CREASE * chord {
                    side.lines.push(at);
                } else if jump > 0.0 {
                    side.jumps.push((at, jump));
                }
            }
            if closed {
                side.lines.push(high);
            }
            sides.push(side);
        }
        let [Some(v), Some(u)] = [sides.pop(), sides.pop()] else {
            return Err(Error::Invalid("a surface has two directions".into()));
        };
        let sides = [u, v];
        // A surface of few patches may be flat; of others it is not worth the search. Its patches as wholes tell.
        let whole = |k: usize| {
            let at = [k / counts[1], k % counts[1]];
            (&patches[k], [0.0; 2], [1.0; 2], [0, 1].map(|d: usize| breaks[d][at[d] + 1] - breaks[d][at[d]]))
        };
        let lengths = [sides[0].length(), sides[1].length()];
        let bend = if patches.len() <= MOST_PATCHES {
            exactly((0..patches.len()).map(whole)).whole(lengths)
        } else {
            f64::INFINITY
        };
        let kinks = sides
            .iter()
            .any(|side| !side.jumps.is_empty() || side.lines.len() > 2 * usize::from(side.closed));
        let flat = !kinks && bend <= 1e-9 * chord;
        let affine = if flat { Affine::of(&patches, &breaks) } else { None };
        Ok(Self { surface, frame, patches, breaks, sides, poles, bounds, flat, affine })
    }

    /// A point of space in the frame, and back.
    pub(crate) fn framed(&self, point: &Point) -> Vector {
        (point - self.frame.centre) / self.frame.size
    }

    pub(crate) fn unframed(&self, point: &Vector) -> Point {
        self.frame.centre + point * self.frame.size
    }

    /// The patch of a place and where in it that is; at a knot, the patch towards another place.
    fn spot(&self, at: [f64; 2], toward: [f64; 2]) -> (usize, [f64; 2]) {
        let mut index = [0; 2];
        let mut local = [0.0; 2];
        for d in 0..2 {
            let breaks = &self.breaks[d];
            let last = breaks.len() - 2;
            let mut k = breaks.partition_point(|b| *b <= at[d]).saturating_sub(1).min(last);
            if k > 0 && breaks[k] == at[d] && toward[d] < at[d] {
                k -= 1;
            }
            index[d] = k;
            local[d] = ((at[d] - breaks[k]) / (breaks[k + 1] - breaks[k])).clamp(0.0, 1.0);
        }
        (index[0] * (self.breaks[1].len() - 1) + index[1], local)
    }

    fn jet(&self, at: [f64; 2], toward: [f64; 2]) -> (&Patch, [f64; 2], Jet) {
        let (k, local) = self.spot(at, toward);
        let patch = &self.patches[k];
        (patch, local, patch.jet(local))
    }

    /// The point and the first derivatives by the surface's own parameters.
    fn slopes(&self, at: [f64; 2]) -> (Vector, Vector, Vector) {
        let (k, local) = self.spot(at, at);
        let jet = self.patches[k].jet(local);
        let columns = self.breaks[1].len() - 1;
        let length = |d: usize, k: usize| self.breaks[d][k + 1] - self.breaks[d][k];
        (jet.point, jet.u / length(0, k / columns), jet.v / length(1, k % columns))
    }

    pub(crate) fn point(&self, at: [f64; 2]) -> Vector {
        let (k, local) = self.spot(at, at);
        self.patches[k].point(local)
    }

    /// The unit normal `S_u × S_v`, or its limit from the side of another place; zero where there is none.
    pub(crate) fn normal(&self, at: [f64; 2], toward: [f64; 2]) -> Vector {
        if let Some(plane) = &self.affine {
            return plane.normal;
        }
        let (patch, local, jet) = self.jet(at, toward);
        normal(patch, local, &jet)
    }

    /// How far the surface can be from its linear interpolation over what lies in a box, at equal parameters.
    pub(crate) fn whole(&self, low: [f64; 2], high: [f64; 2]) -> f64 {
        if self.flat {
            return 0.0;
        }
        self.bounds.spread(low, high).whole([high[0] - low[0], high[1] - low[1]]) + self.kinks(low, high)
    }

    /// As [`whole`](Self::whole), more sharply where that is more than `enough`.
    pub(crate) fn whole_within(&self, low: [f64; 2], high: [f64; 2], enough: f64) -> f64 {
        let found = self.whole(low, high);
        if found <= enough {
            return found;
        }
        let sides = [high[0] - low[0], high[1] - low[1]];
        found.min(self.spread(low, high).whole(sides) + self.kinks(low, high))
    }

    /// What the second derivatives can be in a box, from the Bézier points of just that box.
    pub(crate) fn spread(&self, low: [f64; 2], high: [f64; 2]) -> Spread {
        let range = |d: usize| {
            let breaks = &self.breaks[d];
            let last = breaks.len() - 2;
            let first = breaks.partition_point(|b| *b <= low[d]).saturating_sub(1).min(last);
            let end = breaks.partition_point(|b| *b < high[d]).clamp(first + 1, last + 1);
            first..end
        };
        let (rows, columns) = (range(0), range(1));
        if rows.len() * columns.len() > MOST_PATCHES {
            return self.bounds.spread(low, high);
        }
        let count = self.breaks[1].len() - 1;
        exactly(rows.flat_map(|i| columns.clone().map(move |j| [i, j])).map(|index| {
            let (mut a, mut b, mut lengths) = ([0.0; 2], [1.0; 2], [1.0; 2]);
            for d in 0..2 {
                let (start, end) = (self.breaks[d][index[d]], self.breaks[d][index[d] + 1]);
                let local = |x: f64| ((x - start) / (end - start)).clamp(0.0, 1.0);
                (a[d], b[d]) = (local(low[d]), local(high[d]));
                // A box without extent is widened to what can be told apart.
                if b[d] - a[d] < THIN {
                    (a[d], b[d]) = ((a[d] - THIN).max(0.0), (b[d] + THIN).min(1.0));
                }
                lengths[d] = (b[d] - a[d]) * (end - start);
            }
            (&self.patches[index[0] * count + index[1]], a, b, lengths)
        }))
    }

    /// What first derivatives that jump within a box add to that: a quarter of each jump, times the side of the box.
    pub(crate) fn kinks(&self, low: [f64; 2], high: [f64; 2]) -> f64 {
        let sum = |d: usize| {
            let jumps = &self.sides[d].jumps;
            let first = jumps.partition_point(|(at, _)| *at <= low[d]);
            let inside = jumps[first..].iter().take_while(|(at, _)| *at < high[d]);
            inside.map(|(_, jump)| jump).sum::<f64>() * 0.25 * (high[d] - low[d])
        };
        sum(0) + sum(1)
    }

    /// Whether a place lies on a line that triangles do not reach across.
    pub(crate) fn on_line(&self, at: [f64; 2]) -> bool {
        (0..2).any(|d| self.sides[d].lines.contains(&at[d]))
    }

    /// The side of the domain that is a point and has a place: direction and end.
    pub(crate) fn pole_at(&self, at: [f64; 2]) -> Option<(usize, usize)> {
        let ends = |d: usize| [self.sides[d].low, self.sides[d].high];
        (0..4).map(|k| (k / 2, k % 2)).find(|&(d, end)| self.poles[d][end].is_some() && at[d] == ends(d)[end])
    }

    /// Scaled to `[0, 1]²`.
    pub(crate) fn uv(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d: usize| {
            let side = &self.sides[d];
            if at[d] >= side.high { 1.0 } else { (at[d] - side.low) / side.length() }
        })
    }

    /// Where a point of space is on the surface, and how far from it (in the frame): from a place nearby, where one is known
    /// and that leads within `enough`; else from places all over the surface; else the closest of all, as long as searches may go on. What is
    /// told is always how far the point is from the place that is told.
    ///
    /// # Errors
    /// When the point is not finite.
    pub(crate) fn foot(
        &self,
        point: &Point,
        near: Option<[f64; 2]>,
        enough: f64,
        searches: &mut Searches,
    ) -> Result<([f64; 2], f64)> {
        if let Some(found) = self.affine.as_ref().and_then(|plane| plane.foot(&self.framed(point))) {
            return Ok(found);
        }
        let framed = self.framed(point);
        if let Some(found) = near.and_then(|near| self.descend(&framed, near, enough)) {
            return Ok(found);
        }
        let size = self.frame.size;
        let mut best: Option<([f64; 2], f64)> = None;
        let mut better = |at: (f64, f64), distance: f64| {
            let distance = distance / size;
            if best.is_none_or(|(_, known)| distance < known) {
                best = Some(([at.0, at.1], distance));
            }
            distance <= enough
        };
        if let Some([u, v]) = near {
            let foot = self.surface.foot(*point, (u, v))?;
            if better(foot.at, foot.distance) || searches.are_over() {
                return Ok(best.unwrap_or_default());
            }
        }
        for [u, v] in self.bounds.near(&framed) {
            if let Some(found) = self.descend(&framed, [u, v], enough) {
                return Ok(found);
            }
            let foot = self.surface.foot(*point, (u, v))?;
            if better(foot.at, foot.distance) {
                return Ok(best.unwrap_or_default());
            }
        }
        // It is further off than it should be: which of the places that are about as near it gets matters no more.
        let (closest, looked) =
            self.surface.nearly_closest_of(*point, 0.25 * enough * size, OFF, searches.left())?;
        searches.spend(looked.max(self.patches.len() / PREPARED));
        better(closest.at, closest.distance);
        Ok(best.unwrap_or_default())
    }

    /// Where a point (in the frame) is on the surface, reached from a place nearby by Gauss and Newton's steps, each of which has to come
    /// closer; `None` where that leads nowhere within `enough`. On the surface the steps are quadratic. It is what
    /// [`Surface::foot`] does, on Bézier patches, across seams, and without a way out where steps do not come closer.
    fn descend(&self, point: &Vector, start: [f64; 2], enough: f64) -> Option<([f64; 2], f64)> {
        let inside = |at: [f64; 2]| {
            [0, 1].map(|d: usize| {
                let side = &self.sides[d];
                if side.closed { side.wrapped(at[d]) } else { at[d].clamp(side.low, side.high) }
            })
        };
        let mut at = inside(start);
        let (on, mut su, mut sv) = self.slopes(at);
        let mut away = point - on;
        for _ in 0..DESCENTS {
            let (mut a, mut b, mut c) = (su.norm_squared(), su.dot(&sv), sv.norm_squared());
            let (mut g, mut h) = (su.dot(&away), sv.dot(&away));
            // A parameter at its limit that would have to leave the domain stays there.
            let held = [(0, g), (1, h)].map(|(d, g)| {
                let side = &self.sides[d];
                !side.closed && (at[d] <= side.low && g < 0.0 || at[d] >= side.high && g > 0.0)
            });
            if held[0] {
                (a, b, g) = (1.0, 0.0, 0.0);
            }
            if held[1] {
                (b, c, h) = (0.0, 1.0, 0.0);
            }
            let det = a * c - b * b;
            if det.is_nan() || det <= 1e-8 * a * c {
                return None;
            }
            let step = [(c * g - b * h) / det, (a * h - b * g) / det];
            // How far it leads, in the frame.
            let far = step[0].abs() * su.norm() + step[1].abs() * sv.norm();
            if far <= STILL {
                break;
            }
            let next = inside([at[0] + step[0], at[1] + step[1]]);
            let (on, u, v) = self.slopes(next);
            let further = point - on;
            if further.norm_squared() < away.norm_squared() {
                (at, su, sv, away) = (next, u, v, further);
            } else if far <= ALMOST_STILL {
                break;
            } else {
                return None;
            }
        }
        let distance = away.norm();
        (distance <= enough).then_some((at, distance))
    }

    /// A place moved onto a pole or onto lines that are nearer than a length (in the frame), wrapped into the domain; along the side that
    /// a pole is, it is not a number.
    pub(crate) fn settled(&self, at: [f64; 2], point: &Vector, snap: f64) -> [f64; 2] {
        let mut at = [0, 1].map(|d: usize| self.sides[d].wrapped(at[d]));
        for d in 0..2 {
            for (end, pole) in self.poles[d].iter().enumerate() {
                if pole.is_some_and(|pole| (pole - point).norm() <= snap) {
                    at[d] = [self.sides[d].low, self.sides[d].high][end];
                    at[1 - d] = f64::NAN;
                    return at;
                }
            }
        }
        let speeds = if self.sides.iter().all(|side| side.lines.is_empty()) {
            [f64::INFINITY; 2]
        } else {
            let (_, u, v) = self.slopes(at);
            [u.norm(), v.norm()]
        };
        for d in 0..2 {
            let side = &self.sides[d];
            let reach = (snap / speeds[d]).min(1e-3 * side.length());
            // What runs along an end of the domain is on it, not beside it by rounding.
            let ends =
                [side.low, side.high].into_iter().filter(|end| (end - at[d]).abs() <= 1e-9 * side.length());
            let near = side.lines.iter().copied().find(|line| (line - at[d]).abs() <= reach);
            let near = near.or_else(|| ends.into_iter().next());
            if let Some(line) = near {
                at[d] = side.wrapped(line);
            }
        }
        at
    }
}

/// A jump of the first derivative over the spans around a knot that is more than this part of the tolerance is a crease.
const CREASE: f64 = 0.05;

/// The patches of a surface side by side.
struct Net<'p> {
    patches: &'p [Patch],
    counts: [usize; 2],
    /// How near to each other points are one.
    one: f64,
}

impl Net<'_> {
    fn patch(&self, direction: usize, along: usize, across: usize) -> &Patch {
        let [i, j] = if direction == 0 { [along, across] } else { [across, along] };
        &self.patches[i * self.counts[1] + j]
    }

    /// The sides of patches at the low and at the high end of a direction.
    fn side(direction: usize, end: usize) -> usize {
        [[3, 1], [0, 2]][direction][end]
    }

    /// The point that a side of the domain is.
    fn pole(&self, direction: usize, end: usize) -> Option<Vector> {
        let along = [0, self.counts[direction] - 1][end];
        let points = (0..self.counts[1 - direction]).flat_map(|across| {
            self.patch(direction, along, across).side(Self::side(direction, end)).map(project)
        });
        let mut points = points;
        let first = points.next()?;
        points.all(|p| (p - first).norm() <= self.one).then_some(first)
    }

    /// Whether the patches `before` end where those `after` begin.
    fn meets(&self, direction: usize, before: usize, after: usize) -> bool {
        (0..self.counts[1 - direction]).all(|across| {
            let a = self.patch(direction, before, across).side(Self::side(direction, 1));
            let b = self.patch(direction, after, across).side(Self::side(direction, 0));
            let scale =
                |mut side: Box<dyn Iterator<Item = &Homogeneous> + '_>| side.next().map_or(1.0, |h| h[3]);
            let (wa, wb) = (scale(Box::new(a.clone())), scale(Box::new(b.clone())));
            a.zip(b).all(|(x, y)| {
                let (x3, y3) = (x[3] / wa, y[3] / wb);
                (project(x) - project(y)).norm() <= self.one && (x3 - y3).abs() <= 1e-6 * x3.max(y3)
            })
        })
    }

    /// The most that the first derivative across a knot line jumps by: with the jump `(D, d)` of `(A, W)`'s derivative,
    /// that of `A / W` is `(D W - A d) / W²`, whose numerator is bounded by its Bézier points.
    fn jump(&self, direction: usize, k: usize, [before, after]: [f64; 2]) -> f64 {
        let mut most = 0.0_f64;
        for across in 0..self.counts[1 - direction] {
            let (one, other) = (self.patch(direction, k - 1, across), self.patch(direction, k, across));
            let lines = |patch: &Patch, last: bool| -> [Vec<Homogeneous>; 2] {
                let (p, q) = (patch.rows, patch.columns);
                let order = [p, q][direction];
                let row = |r: usize| -> Vec<Homogeneous> {
                    if direction == 0 {
                        patch.net[r * q..(r + 1) * q].to_vec()
                    } else {
                        (0..p).map(|i| patch.net[i * q + r]).collect()
                    }
                };
                if last { [row(order - 2), row(order - 1)] } else { [row(0), row(1)] }
            };
            let degree = [one.rows, one.columns][direction] as f64 - 1.0;
            let [inner, edge] = lines(one, true);
            let [start, next] = lines(other, false);
            // Patches scale their weights on their own.
            let same = edge[0][3] / start[0][3];
            let slope = |k: usize, l: usize| {
                degree * ((next[k][l] - start[k][l]) * same / after - (edge[k][l] - inner[k][l]) / before)
            };
            let order = edge.len();
            let light = edge.iter().map(|h| h[3]).fold(f64::INFINITY, f64::min);
            let binomials = |n: usize| {
                let mut row = vec![1.0; n + 1];
                for i in 1..=n {
                    row[i] = row[i - 1] * (n + 1 - i) as f64 / i as f64;
                }
                row
            };
            let (single, double) = (binomials(order - 1), binomials(2 * order - 2));
            let mut product = vec![Vector::zeros(); 2 * order - 1];
            for a in 0..order {
                let d = [0, 1, 2, 3].map(|l| slope(a, l));
                let d = (Vector::new(d[0], d[1], d[2]), d[3]);
                for b in 0..order {
                    let h = &edge[b];
                    let share = single[a] * single[b] / double[a + b];
                    product[a + b] += (d.0 * h[3] - Vector::new(h[0], h[1], h[2]) * d.1) * share;
                }
            }
            let largest = product.iter().map(Vector::norm).fold(0.0, f64::max);
            most = most.max(largest / (light * light));
        }
        // What is left of equal derivatives after rounding.
        let rounding = 1e-12 / before.min(after);
        if most <= rounding { 0.0 } else { most }
    }
}
