//! Curves as polylines with as few chords as the tolerance permits, all about equally far from the curve.
//!
//! Each chord reaches as far along the curve as it may (across knots, too), found by bisection with the decision of
//! [`Chord::holds`]. The last chord of a run so found is shorter than the others; all are then shortened by the same
//! share. Runs end at corners, where the directions before and after differ.
//!
//! A curve that moves has several states, cut at the same parameters: a chord reaches as far as it may in all of them.

use std::cell::Cell;
use std::ops::Range;

use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{Fineness, MovingLine};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Error, Point, Result, Vector};
use smallvec::SmallVec;

use crate::bezier::{extraction, restrict};
use crate::fineness::{Frame, Target, over_budget, targets};
use crate::flat::Chord;
use crate::patch::{Homogeneous, project};
use crate::weights;

/// Directions before and after a knot that differ by more than this make a corner: well above rounding.
const CORNER: f64 = 1e-6;
/// How sharply the end of a chord is found, relative to its length.
const SHARP: f64 = 2e-3;
/// How many times more chords than allowed an estimate must see to be believed.
const BEYOND: f64 = 3.0;

/// The polyline.
pub(crate) fn polyline(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Polyline> {
    let curves = std::slice::from_ref(curve);
    let line = Places::of(curves, fineness, budget, false)?.line(curves)?;
    Ok(Polyline { points: line.states.into_iter().next().unwrap_or_default(), closed: line.closed })
}

/// The parameters at which a curve is cut into chords, both ends of the domain included.
pub(crate) fn parameters(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Vec<f64>> {
    let at = |place: &Place| match place {
        Place::At(u) => Some(*u),
        Place::Before(_) => None,
    };
    let found = Places::of(std::slice::from_ref(curve), fineness, budget, false)?;
    Ok(found.places.iter().filter_map(at).collect())
}

/// All states of a curve, cut alike.
pub(crate) fn moving(curves: &[Curve], fineness: &Fineness, budget: usize) -> Result<MovingLine> {
    Places::of(curves, fineness, budget, true)?.line(curves)
}

impl Places {
    fn line(self, curves: &[Curve]) -> Result<MovingLine> {
        let found = self;
        let mut states: Vec<Vec<Point>> = vec![Vec::with_capacity(found.places.len()); curves.len()];
        let mut parameters = Vec::with_capacity(found.places.len());
        let mut starts = vec![0];
        let mut point = vec![Point::origin(); curves.len()];
        for (k, place) in found.places.iter().enumerate() {
            for (point, (curve, state)) in point.iter_mut().zip(curves.iter().zip(&found.states)) {
                *point = match (place, state) {
                    (Place::At(u), _) => curve.point(*u)?,
                    (Place::Before(piece), Some(state)) => {
                        state.frame.centre + state.pieces[*piece].at(1.0) * state.frame.size
                    }
                    // All of it is one point.
                    (Place::Before(_), None) => curve.points()[0],
                };
            }
            // Spans on which the curve stands still in all states give no segment.
            let stands = states.iter().zip(&point).all(|(points, point)| points.last() == Some(point));
            let torn = starts.last() == Some(&states[0].len());
            if !stands || torn {
                states.iter_mut().zip(&point).for_each(|(points, point)| points.push(*point));
                // The end of a part has the parameter of the start of the next, which comes right behind it.
                let own = found.places[k..].iter().find_map(|place| match place {
                    Place::At(u) => Some(*u),
                    Place::Before(_) => None,
                });
                parameters.extend(own);
            }
            if matches!(place, Place::Before(_)) {
                starts.push(states[0].len());
            }
        }
        let closed = starts.len() == 1
            && states.iter().all(|points| match points.as_slice() {
                [first, .., last] if points.len() > 3 => {
                    let resolved = 4.0 * f64::EPSILON * first.coords.amax().max(last.coords.amax());
                    curves[0].is_periodic() || (last - first).amax() <= resolved
                }
                _ => false,
            });
        if closed {
            states.iter_mut().for_each(|points| _ = points.pop());
            parameters.pop();
        }
        let Self { tolerance, error, .. } = found;
        Ok(MovingLine { states, parameters, starts, closed, tolerance, error })
    }
}
/// A point of the polyline.
enum Place {
    At(f64),
    /// The end of a piece where the curve jumps: its parameter belongs to the next.
    Before(usize),
}

/// A curve in one state, in its own frame.
struct State {
    frame: Frame,
    pieces: Vec<Piece>,
    target: Target,
}

/// Where the states of a curve are cut.
struct Places {
    places: Vec<Place>,
    /// `None` where all of the curve is one point.
    states: Vec<Option<State>>,
    /// The largest chord asked for, as a length.
    tolerance: f64,
    /// The largest certified distance, as a length.
    error: f64,
}

impl Places {
    /// `measured` says whether the error is asked for.
    fn of(curves: &[Curve], fineness: &Fineness, budget: usize, measured: bool) -> Result<Self> {
        let Some(first) = curves.first() else {
            return Err(Error::Invalid("a curve without states cannot be tessellated".into()));
        };
        if curves.iter().any(|c| c.space() != first.space() || c.weights() != first.weights()) {
            let problem = "the states of a moving curve have other knots or weights: they must be the same";
            return Err(Error::Invalid(problem.into()));
        }
        let budget = (budget / curves.len()).max(1);
        let mut found = Vec::with_capacity(curves.len());
        for curve in curves {
            found.push(match Frame::of(curve.points()) {
                Ok(frame) => Some((frame, pieces(curve, &frame))),
                Err(Error::NoExtent(_)) if curves.len() > 1 => None,
                Err(error) => return Err(error),
            });
        }
        let Some((_, pieces)) = found.iter().flatten().next() else {
            return Err(Error::NoExtent("all control vertices coincide in every state".into()));
        };
        if first.weights().is_some() {
            pieces.iter().try_for_each(|piece| weights::resolved(&piece.net))?;
        }
        let samples = |frame: &Frame, pieces: &[Piece]| -> Vec<Point> {
            let at = |piece: &Piece| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| piece.at(t));
            pieces.iter().flat_map(at).map(|p| frame.centre + p * frame.size).collect()
        };
        let live = found.iter().flatten().map(|(frame, pieces)| (frame, samples(frame, pieces)));
        let (targets, tolerance) = targets(live, fineness)?;
        let mut targets = targets.into_iter();
        let states: Vec<Option<State>> = found
            .into_iter()
            .map(|state| {
                let (frame, pieces) = state?;
                Some(State { frame, pieces, target: targets.next()? })
            })
            .collect();
        let mut all = Self { places: vec![Place::At(first.domain().0)], states, tolerance, error: 0.0 };
        let over = |chords: Option<f64>| Err(over_budget(fineness, chords, ("segments", 0.5), budget));
        let estimate = all.live().map(State::estimate).fold(0.0, f64::max);
        if estimate > BEYOND * budget as f64 {
            return over(Some(estimate));
        }
        if !all.cut(budget, measured)? {
            return over(None);
        }
        Ok(all)
    }

    fn live(&self) -> impl Iterator<Item = &State> {
        self.states.iter().flatten()
    }

    /// Cuts run by run; false where more than `budget` chords are needed.
    fn cut(&mut self, budget: usize, measured: bool) -> Result<bool> {
        let live: Vec<&State> = self.states.iter().flatten().collect();
        let count = live.first().map_or(0, |state| state.pieces.len());
        let (mut places, mut error) = (Vec::new(), 0.0_f64);
        let mut start = 0;
        for end in 1..=count {
            let open = end < count;
            let any = |of: fn(&Piece, &Piece) -> bool| {
                live.iter().any(|state| of(&state.pieces[end - 1], &state.pieces[end]))
            };
            if open && !any(corner) {
                continue;
            }
            let run = Run { states: &live, pieces: start..end, last: Cell::new(0) };
            let Some(cuts) = run.cuts(budget.saturating_sub(places.len()))? else {
                return Ok(false);
            };
            if measured {
                error = error.max(run.error(&cuts));
            }
            let jumps = open && any(jumps);
            for (k, &u) in cuts.iter().enumerate().skip(1) {
                if jumps && k + 1 == cuts.len() {
                    places.push(Place::Before(end - 1));
                }
                places.push(Place::At(u));
            }
            start = end;
        }
        self.places.extend(places);
        self.error = error;
        Ok(true)
    }
}

impl State {
    /// About how many chords it needs.
    fn estimate(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.estimate(&self.target)).sum()
    }
}

/// The Bézier points of a piece or of a part of one: of low degrees without an allocation.
type Net = SmallVec<[Homogeneous; 8]>;

/// A Bézier piece of the curve between two parameters.
struct Piece {
    a: f64,
    b: f64,
    net: Vec<Homogeneous>,
}

impl Piece {
    /// The point at a fraction of the piece.
    fn at(&self, t: f64) -> Vector {
        let mut net = Net::from_slice(&self.net);
        restrict(&mut net, self.net.len(), 1, [t, 0.0], [1.0, 1.0]);
        project(&net[0])
    }

    /// The control points of what is between two parameters.
    fn between(&self, from: f64, to: f64) -> Net {
        let local = |u: f64| ((u - self.a) / (self.b - self.a)).clamp(0.0, 1.0);
        let mut net = Net::from_slice(&self.net);
        restrict(&mut net, self.net.len(), 1, [local(from), 0.0], [local(to), 1.0]);
        net
    }

    /// About how many chords it needs: from how far its middle is from its chord.
    fn estimate(&self, target: &Target) -> f64 {
        let chord = Chord { from: self.at(0.0), to: self.at(1.0), reach: 0.0, half: 0.0 };
        (chord.distance(&self.at(0.5)) / target.chord).sqrt()
    }

    /// The direction at the start or the end: that of the first leg that has one.
    fn direction(&self, at_end: bool) -> Option<Vector> {
        let points: Vec<Vector> = self.net.iter().map(project).collect();
        let mut legs: Vec<Vector> = points.windows(2).map(|p| p[1] - p[0]).collect();
        if at_end {
            legs.reverse();
        }
        legs.iter().find_map(|leg| leg.try_normalize(1e-12))
    }
}

fn pieces(curve: &Curve, frame: &Frame) -> Vec<Piece> {
    let (space, p) = (curve.space(), curve.degree());
    let flat = space.flat();
    let mut rows = Vec::new();
    // Scaled by a power of two, so that nothing is rounded and no product with a coordinate vanishes.
    let heaviest = curve.weights().map_or(1.0, |w| w.iter().copied().fold(f64::MIN_POSITIVE, f64::max));
    let scale = heaviest.log2().floor().exp2();
    let piece = |span: usize| {
        let (a, b) = (flat[span], flat[span + 1]);
        extraction(space, span, a, b, &mut rows);
        let combine = |shares: &[f64]| {
            let mut sum = [0.0; 4];
            for (i, share) in shares.iter().enumerate() {
                let vertex = space.vertex(span - p + i);
                let w = share * curve.weights().map_or(1.0, |w| w[vertex] / scale);
                let x = (curve.points()[vertex] - frame.centre) / frame.size;
                [x.x, x.y, x.z, 1.0].iter().enumerate().for_each(|(l, x)| sum[l] += w * x);
            }
            sum
        };
        Piece { a, b, net: rows.iter().map(|row| combine(&row[..=p])).collect() }
    };
    space.spans().map(piece).collect()
}

/// Whether the curve breaks between two pieces.
fn jumps(before: &Piece, after: &Piece) -> bool {
    (before.at(1.0) - after.at(0.0)).norm() > 1e-12
}

/// Whether the curve turns at once between two pieces, or breaks.
fn corner(before: &Piece, after: &Piece) -> bool {
    let turns = match (before.direction(true), after.direction(false)) {
        (Some(a), Some(b)) => (a - b).norm() > CORNER,
        _ => false,
    };
    turns || jumps(before, after)
}

/// A stretch without corners in any state.
struct Run<'a> {
    states: &'a [&'a State],
    pieces: Range<usize>,
    /// The state that last forbade a chord: it is asked first, since it mostly forbids the next, too.
    last: Cell<usize>,
}

impl Run<'_> {
    fn parameters(&self) -> (f64, f64) {
        let pieces = self.states[0].part(&self.pieces);
        (pieces[0].a, pieces[pieces.len() - 1].b)
    }

    /// The ends of the chords, the start of the run first; nothing where more than `most` are needed.
    ///
    /// # Errors
    /// When the curve moves too far between parameters that doubles cannot tell apart.
    fn cuts(&self, most: usize) -> Result<Option<Vec<f64>>> {
        let (start, end) = self.parameters();
        let mut cuts = vec![start];
        let mut step = end - start;
        let mut from = start;
        while from < end {
            let Some(to) = self.reach(from, end, step) else {
                return Err(Error::Invalid(format!(
                    "the curve moves by more than the chord tolerance between the parameter {from} and the next number that there is: its weights are too unlike, or its knots too close together for where they are"
                )));
            };
            if cuts.len() > most {
                return Ok(None);
            }
            step = to - from;
            cuts.push(to);
            from = to;
        }
        let even = self.evened(&cuts);
        Ok(Some(even.unwrap_or(cuts)))
    }

    /// The farthest end of a chord from a parameter, to a small part of the chord: first in steps that grow or
    /// shrink, from a guess, then by bisection. `None` where no chord holds, however short.
    fn reach(&self, from: f64, end: f64, guess: f64) -> Option<f64> {
        let (mut low, mut high) = (from, f64::INFINITY);
        let mut step = guess;
        while high == f64::INFINITY || high - low > SHARP * (low - from) {
            let to = if high == f64::INFINITY {
                (from + step).min(end)
            } else if low > from {
                0.5 * (low + high)
            } else {
                from + step
            };
            // A stretch that doubles cannot divide any further.
            if to <= low || to >= high {
                let next = from.next_up().min(end);
                return if low > from { Some(low) } else { self.holds(from, next).then_some(next) };
            }
            if self.holds(from, to) {
                if to >= end {
                    return Some(end);
                }
                low = to;
                step *= 1.25;
            } else {
                high = to;
                step = 0.7 * (to - from);
            }
        }
        Some(low)
    }

    /// The same number of chords, each a little shorter, so that the last is not the only one with room to spare.
    fn evened(&self, cuts: &[f64]) -> Option<Vec<f64>> {
        let [.., before, end] = cuts else { return None };
        let n = cuts.len() - 1;
        if n < 2 {
            return None;
        }
        let share = |state: &&State| state.share(&self.pieces, *before, *end);
        let last = self.states.iter().map(share).fold(0.0, f64::max);
        let scale = (n as f64 - 1.0 + last) / n as f64;
        let place = |k: usize| {
            let x = k as f64 * scale;
            let whole = (x.floor() as usize).min(n - 1);
            let part = if whole == n - 1 { (x - whole as f64) / last } else { x - whole as f64 };
            cuts[whole] + (cuts[whole + 1] - cuts[whole]) * part.min(1.0)
        };
        let even: Vec<f64> = (0..=n).map(|k| if k == n { *end } else { place(k) }).collect();
        let holds = even.windows(2).all(|ends| ends[0] < ends[1] && self.holds(ends[0], ends[1]));
        holds.then_some(even)
    }

    /// Whether one chord will do between two parameters in all states.
    fn holds(&self, from: f64, to: f64) -> bool {
        let last = self.last.get();
        let ask = |k: usize| self.states[k].holds(&self.pieces, from, to);
        if !ask(last) {
            return false;
        }
        let found = (0..self.states.len()).find(|&k| k != last && !ask(k));
        found.into_iter().for_each(|k| self.last.set(k));
        found.is_none()
    }

    /// The largest certified distance, as a length.
    fn error(&self, cuts: &[f64]) -> f64 {
        let of = |state: &&State| {
            let bound = |known: f64, ends: &[f64]| state.bound(&self.pieces, ends[0], ends[1], known);
            cuts.windows(2).fold(0.0, bound) * state.frame.size
        };
        self.states.iter().map(of).fold(0.0, f64::max)
    }
}

impl State {
    fn part(&self, range: &Range<usize>) -> &[Piece] {
        &self.pieces[range.clone()]
    }

    /// About what part of the longest chord a chord is, by its distance from the curve or its angle.
    fn share(&self, range: &Range<usize>, from: f64, to: f64) -> f64 {
        let pieces = self.part(range);
        let chord = self.chord(pieces, from, to);
        let sample = |k: usize| point(pieces, from + (to - from) * k as f64 / 8.0);
        let samples: SmallVec<[Vector; 9]> = (0..=8).map(sample).collect();
        let far = samples.iter().map(|p| chord.distance(p)).fold(0.0, f64::max);
        let legs: SmallVec<[Vector; 8]> = samples.windows(2).map(|p| p[1] - p[0]).collect();
        let turn: f64 = legs.windows(2).map(|legs| legs[0].angle(&legs[1])).sum::<f64>() * 8.0 / 7.0;
        (far / self.target.chord).sqrt().max(turn / self.target.angle).clamp(0.01, 1.0)
    }

    fn chord(&self, pieces: &[Piece], from: f64, to: f64) -> Chord {
        let (from, to) = (point(pieces, from), point(pieces, to));
        Chord { from, to, reach: self.target.chord, half: 0.5 * self.target.angle }
    }

    /// Whether one chord will do between two parameters.
    fn holds(&self, range: &Range<usize>, from: f64, to: f64) -> bool {
        let pieces = self.part(range);
        let chord = self.chord(pieces, from, to);
        // Ends first: where a chord is far too long it mostly shows there.
        pieces[index(pieces, from)..]
            .iter()
            .take_while(|piece| piece.a < to)
            .all(|piece| chord.holds(&piece.between(from, to)))
    }

    /// The certified distance between a chord that holds and its stretch, in the state's frame, if it is more than `known`.
    fn bound(&self, range: &Range<usize>, from: f64, to: f64, known: f64) -> f64 {
        let pieces = self.part(range);
        let chord = self.chord(pieces, from, to);
        let among = pieces[index(pieces, from)..].iter().take_while(|piece| piece.a < to);
        among.fold(known, |known, piece| chord.bound(&piece.between(from, to), known))
    }
}

fn index(pieces: &[Piece], u: f64) -> usize {
    pieces.partition_point(|piece| piece.b <= u).min(pieces.len() - 1)
}

fn point(pieces: &[Piece], u: f64) -> Vector {
    let piece = &pieces[index(pieces, u)];
    piece.at(((u - piece.a) / (piece.b - piece.a)).clamp(0.0, 1.0))
}
