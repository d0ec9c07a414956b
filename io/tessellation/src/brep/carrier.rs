//! The surface of a face, prepared: its patches, what of it is one (seams, poles), where it creases, how much it bends.

mod affine;
mod net;
mod side;

use std::sync::Arc;

use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point, Result, Vector};

use self::affine::Affine;
use self::net::{CREASE, Net};
pub(crate) use self::side::{Searches, Side};
use super::bounds::{Bounds, Spread, exactly};
use crate::fineness::Frame;
use crate::normals::normal;
use crate::patch::{Jet, Patch, Patches};
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
/// So many patches cost as much as one piece before any is looked at.
const PREPARED: usize = 16;
/// Points of a surface's own edges that are closer than this, in the frame of the whole, are one.
const ONE_POINT: f64 = 1e-9;

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
