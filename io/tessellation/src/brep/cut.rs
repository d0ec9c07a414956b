//! Edges cut into chords, once for all faces along them, and where their points are on each of these faces.
//!
//! A chord is near enough to its stretch of the edge, and every face that has it is near enough, between its two ends, to anything that
//! is linear in the box of parameters that the stretch takes there: so a triangle along it can be certified whatever the tolerance,
//! when it is thin enough, and no face has to cut an edge on its own.

mod crossing;
mod flaw;

use loftsman_kernel::plugin::{Chord, Fineness};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Error, Point, Result};

use super::carrier::{Carrier, Searches};
use crate::curve;

/// The part of the tolerance that chords may take.
const SHARE: f64 = 0.4;
/// The part that a face may bend in the box of a chord: together less than all of it.
pub(crate) const BESIDE: f64 = 0.55;
/// Places closer to a crease, a seam or a pole than this part of the tolerance are on it.
const SNAP: f64 = 0.02;
/// Places closer than this (in the frame) are one.
pub(crate) const ONE_PLACE: f64 = 1e-9;
/// The largest part of a closed direction that a chord takes.
const TURN: f64 = 0.2;
/// An edge that is further from a face than this, in the frame, is on another surface: what would be made of the face bounds nothing, and could take
/// any number of chords.
const FAR: f64 = 0.25;
/// As far is too far where so much was searched for the places of an edge that no more is.
const FAR_UNSEARCHED: f64 = 0.01;
/// The most chords of an edge: a ten-billionth of its bends is less than is ever asked for.
const MOST: usize = 1 << 17;
/// Steps to where an edge crosses a line.
const STEPS: usize = 60;

/// What the whole is cut to, in the frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    pub(crate) chord: f64,
    pub(crate) angle: f64,
    /// The unit of the frame, as a length.
    pub(crate) size: f64,
    pub(crate) budget: usize,
    /// Which part of the tolerance of the whole `chord` is: less than 1 for edges that are cut finer than all others.
    pub(crate) part: f64,
}

impl Goal {
    /// The same with a part of its tolerance.
    pub(crate) fn finer(self, part: f64) -> Self {
        Self { chord: part * self.chord, part: part * self.part, ..self }
    }
}

/// Where the points of an edge are on a face.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    pub(crate) face: usize,
    /// The parameters of each point. At a pole one of them is not a number.
    pub(crate) at: Vec<[f64; 2]>,
    /// How far each point is from there, in the frame.
    pub(crate) off: Vec<f64>,
    /// The same places as the file has them, to start searches from.
    pub(crate) guide: Option<Guide>,
    /// How far it was found from the face, in the frame, where that is too far: it is on none of its places then.
    pub(crate) lost: Option<f64>,
    /// How long its places may still be searched for.
    pub(crate) searches: Searches,
}

impl Track {
    /// Of an edge on a face, before it is cut.
    pub(crate) fn new(face: usize, guide: Option<Guide>) -> Self {
        Self { face, at: Vec::new(), off: Vec::new(), guide, lost: None, searches: Searches::default() }
    }

    /// Whether so far off is on another surface.
    fn is_far(&self, off: f64) -> bool {
        off > if self.searches.are_over() { FAR_UNSEARCHED } else { FAR }
    }

    /// It is on none of its places.
    fn lose(&mut self, off: f64) {
        self.lost = Some(off);
        self.at.fill([f64::NAN; 2]);
    }
}

/// An edge in the parameters of a face, over its own parameters.
#[derive(Debug, Clone)]
pub(crate) struct Guide {
    pub(crate) curve: Curve,
    pub(crate) range: (f64, f64),
}

/// What an edge is made of.
#[derive(Debug, Clone)]
pub(crate) enum Path {
    /// A curve in space; its ends are put to these points.
    Space { curve: Curve, ends: [Point; 2] },
    /// A curve in the parameters of the only face that it has.
    Lifted(Curve),
}

/// An edge cut into chords.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    pub(crate) path: Path,
    pub(crate) parameters: Vec<f64>,
    /// The points, ends included, as the edge has them.
    pub(crate) points: Vec<Point>,
    pub(crate) tracks: Vec<Track>,
    /// How far chords can be from the edge, in the frame.
    pub(crate) bend: f64,
    /// What faces bend along it at most, in the boxes of chords.
    pub(crate) beside: f64,
    /// How far the edge was found from its faces, and from which of them furthest.
    pub(crate) off: f64,
    pub(crate) off_face: Option<usize>,
    /// How far from a face it may be, as the file says, in the frame.
    pub(crate) tolerance: f64,
    /// What it is cut to.
    pub(crate) goal: Goal,
}

/// What is wrong with a chord: where it has to be cut.
enum Flaw {
    At(f64),
    /// Where a track is on a line: the track, the direction, the place.
    On(f64, usize, usize, f64),
}

/// A point of an edge and where it is on each of the faces.
struct Sample {
    point: Point,
    at: Vec<[f64; 2]>,
    off: Vec<f64>,
}

impl Chain {
    /// Cuts an edge, in `least` chords at least.
    ///
    /// # Errors
    /// When the curve cannot be cut.
    pub(crate) fn new(
        path: Path,
        tracks: Vec<Track>,
        tolerance: f64,
        least: usize,
        carriers: &[Option<Carrier>],
        goal: Goal,
    ) -> Result<Self> {
        let mut chain = Self {
            path,
            parameters: Vec::new(),
            points: Vec::new(),
            tracks,
            bend: 0.0,
            beside: 0.0,
            off: 0.0,
            off_face: None,
            tolerance,
            goal,
        };
        let mut parameters = match &chain.path {
            // A line is its own chord.
            Path::Space { curve, .. } if curve.points().len() == 2 => Vec::new(),
            Path::Space { curve, .. } => {
                let fineness =
                    Fineness { chord: Chord::Absolute(SHARE * goal.chord * goal.size), angle: goal.angle };
                let moving = curve::moving(std::slice::from_ref(curve), &fineness, goal.budget)?;
                chain.bend = moving.error / goal.size;
                let mut all = moving.parameters;
                // Where the polyline closes, its last parameter is the first again.
                if moving.closed {
                    all.push(curve.domain().1);
                }
                all.dedup();
                all
            }
            Path::Lifted(curve) => curve.space().breakpoints(),
        };
        let (start, end) = match &chain.path {
            Path::Space { curve, .. } | Path::Lifted(curve) => curve.domain(),
        };
        if parameters.len() < 2 {
            parameters = vec![start, end];
        }
        while parameters.len() <= least {
            let middles: Vec<f64> = parameters.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
            parameters.extend(middles);
            parameters.sort_unstable_by(f64::total_cmp);
            parameters.dedup();
        }
        let mut near = None;
        for &t in &parameters {
            let sample = chain.sample(t, near.as_deref(), carriers)?;
            near = Some(sample.at.clone());
            chain.insert(chain.points.len(), t, sample);
        }
        chain.settle(carriers)?;
        Ok(chain)
    }

    fn domain(&self) -> (f64, f64) {
        match &self.path {
            Path::Space { curve, .. } | Path::Lifted(curve) => curve.domain(),
        }
    }

    /// How near to a crease or pole is on it.
    fn snap(&self) -> f64 {
        (SNAP * self.goal.chord).max(2.0 * self.tolerance).max(ONE_PLACE)
    }

    /// How near to a point a foot is believed to be the nearest: not more than what would be seen, whatever the file says of itself, and of an
    /// edge that is cut finer less in proportion: where a surface comes near to itself, feet on the wrong part of it are in the way of others.
    fn enough(&self) -> f64 {
        (2.0 * self.goal.part * self.tolerance).min(SNAP * self.goal.chord).max(10.0 * ONE_PLACE)
    }

    fn sample(&mut self, t: f64, near: Option<&[[f64; 2]]>, carriers: &[Option<Carrier>]) -> Result<Sample> {
        let point = match &self.path {
            Path::Space { curve, ends } => {
                let (start, end) = curve.domain();
                if t <= start {
                    ends[0]
                } else if t >= end {
                    ends[1]
                } else {
                    curve.point(t)?
                }
            }
            Path::Lifted(_) => Point::origin(),
        };
        let (start, end) = self.domain();
        let (enough, near_line) = (self.enough(), self.snap());
        let mut sample = Sample { point, at: Vec::new(), off: Vec::new() };
        for (k, track) in self.tracks.iter_mut().enumerate() {
            let carrier = carriers.get(track.face).and_then(Option::as_ref);
            let Some(carrier) = carrier.filter(|_| track.lost.is_none()) else {
                sample.at.push([f64::NAN; 2]);
                sample.off.push(0.0);
                continue;
            };
            let (at, off) = match &self.path {
                Path::Lifted(curve) => {
                    let p = curve.point(t)?;
                    let at = [0, 1].map(|d: usize| {
                        let side = &carrier.sides[d];
                        let x = [p.x, p.y][d];
                        if side.closed { x } else { x.clamp(side.low, side.high) }
                    });
                    ([0, 1].map(|d: usize| carrier.sides[d].wrapped(at[d])), 0.0)
                }
                Path::Space { .. } => {
                    let known = near.and_then(|near| near.get(k)).copied();
                    let known = known.filter(|at| at.iter().all(|x| x.is_finite()));
                    let guided = match &track.guide {
                        Some(Guide { curve, range }) => {
                            let share = (t - start) / (end - start);
                            let (from, to) = *range;
                            let p = curve.point((from + (to - from) * share).clamp(from, to))?;
                            Some([p.x, p.y])
                        }
                        None => None,
                    };
                    carrier.foot(&point, guided.or(known), enough, &mut track.searches)?
                }
            };
            let place = match &self.path {
                Path::Lifted(_) => carrier.point(at),
                Path::Space { .. } => carrier.framed(&point),
            };
            if matches!(self.path, Path::Lifted(_)) {
                sample.point = carrier.unframed(&place);
            }
            let snap = match &self.path {
                Path::Lifted(_) => ONE_PLACE,
                Path::Space { .. } => near_line,
            };
            sample.at.push(carrier.settled(at, &place, snap));
            sample.off.push(off);
        }
        Ok(sample)
    }

    fn insert(&mut self, index: usize, t: f64, sample: Sample) {
        self.parameters.insert(index, t);
        self.points.insert(index, sample.point);
        for (k, (at, off)) in sample.at.into_iter().zip(sample.off).enumerate() {
            let Some(track) = self.tracks.get_mut(k) else { break };
            track.at.insert(index, at);
            track.off.insert(index, off);
            if track.is_far(off) {
                track.lose(off);
                continue;
            }
            self.is_off(k, off);
        }
    }

    /// It was found so far from the face of a track.
    fn is_off(&mut self, track: usize, off: f64) {
        if off > self.off {
            (self.off, self.off_face) = (off, self.tracks.get(track).map(|track| track.face));
        }
    }

    /// Cuts a chord in two, and again until all holds.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub(crate) fn halve(&mut self, part: usize, carriers: &[Option<Carrier>]) -> Result<bool> {
        let [Some(&a), Some(&b)] = [part, part + 1].map(|k| self.parameters.get(k)) else { return Ok(false) };
        let middle = 0.5 * (a + b);
        let length = nalgebra::distance(&self.points[part], &self.points[part + 1]) / self.goal.size;
        // What is off its face by more than a chord is long is in the way of something because of that: shorter chords are, too.
        let offs = self.tracks.iter().flat_map(|track| [track.off[part], track.off[part + 1]]);
        let least = offs.fold(4.0 * ONE_PLACE, f64::max);
        if middle <= a || middle >= b || length <= least {
            return Ok(false);
        }
        let sample = self.sample(middle, Some(&self.places(part)), carriers)?;
        self.insert(part + 1, middle, sample);
        Ok(true)
    }

    /// Where a point is on each face.
    fn places(&self, index: usize) -> Vec<[f64; 2]> {
        self.tracks.iter().map(|track| track.at[index]).collect()
    }

    /// Cuts until every chord holds.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub(crate) fn settle(&mut self, carriers: &[Option<Carrier>]) -> Result<()> {
        // What is behind the chord that is looked at waits, the nearest last: nothing is moved along for a chord that is cut.
        let mut waiting = Vec::new();
        while self.parameters.len() > 2 {
            waiting.extend(self.pop());
        }
        let settled = self.settle_before(&mut waiting, carriers);
        while let Some((t, sample)) = waiting.pop() {
            self.insert(self.points.len(), t, sample);
        }
        settled
    }

    fn settle_before(
        &mut self,
        waiting: &mut Vec<(f64, Sample)>,
        carriers: &[Option<Carrier>],
    ) -> Result<()> {
        let (start, end) = self.domain();
        let least = 1e-12 * (end - start);
        let most = self.goal.budget.min(MOST);
        let mut part = 0;
        while part + 1 < self.parameters.len() {
            if self.parameters.len() + waiting.len() > most {
                return Err(Error::Invalid(format!(
                    "an edge needs more than {most} chords: choose a coarser tolerance or angle"
                )));
            }
            let (a, b) = (self.parameters[part], self.parameters[part + 1]);
            match self.flaw(part, carriers)? {
                Some(flaw) if b - a > least => {
                    let (t, on) = match flaw {
                        Flaw::At(t) => (t, None),
                        Flaw::On(t, track, d, line) => (t, Some((track, d, line))),
                    };
                    let mut sample = self.sample(t, Some(&self.places(part)), carriers)?;
                    if let Some((track, d, line)) = on {
                        let place = &mut sample.at[track];
                        place[d] = line;
                        if place[1 - d].is_nan() {
                            place[1 - d] = self.tracks[track].at[part][1 - d];
                        }
                    }
                    waiting.extend(self.pop());
                    self.insert(part + 1, t, sample);
                }
                _ => {
                    part += 1;
                    if let Some((t, sample)) = waiting.pop() {
                        self.insert(part + 1, t, sample);
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes the last point off.
    fn pop(&mut self) -> Option<(f64, Sample)> {
        let (t, point) = (self.parameters.pop()?, self.points.pop()?);
        let (at, off) = self
            .tracks
            .iter_mut()
            .map(|track| (track.at.pop().unwrap_or([f64::NAN; 2]), track.off.pop().unwrap_or(0.0)))
            .unzip();
        Some((t, Sample { point, at, off }))
    }

    /// The two ends of a chord on a face, the second as near to the first as it can be; none where all of it is a pole.
    pub(crate) fn ends(track: &Track, part: usize, carrier: &Carrier) -> Option<[[f64; 2]; 2]> {
        let (mut a, mut b) = (track.at[part], track.at[part + 1]);
        for d in 0..2 {
            if a[d].is_nan() {
                a[d] = b[d];
            }
            if b[d].is_nan() {
                b[d] = a[d];
            }
            if a[d].is_nan() {
                return None;
            }
            b[d] = carrier.sides[d].unwrapped(b[d], a[d]);
        }
        Some([a, b])
    }
}
