//! Curves as polylines with as few chords as the tolerance permits, all about equally far from the curve.
//!
//! Each chord reaches as far along the curve as it may (across knots, too), found by bisection with the decision of
//! [`Chord::holds`]. The last chord of a run so found is shorter than the others; all are then shortened by the same
//! share. Runs end at corners, where the directions before and after differ.

use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::Fineness;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result, Vector};

use crate::bezier::{extraction, restrict};
use crate::fineness::{Frame, Target, over_budget};
use crate::flat::Chord;
use crate::patch::{Homogeneous, project};

/// Directions before and after a knot that differ by more than this make a corner: well above rounding.
const CORNER: f64 = 1e-6;
/// How sharply the end of a chord is found, relative to its length.
const SHARP: f64 = 2e-3;
/// How many times more chords than allowed an estimate must see to be believed.
const BEYOND: f64 = 8.0;

/// The polyline, and where on the curve its points are.
pub(crate) fn polyline(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Polyline> {
    let mut points: Vec<Point> = Vec::new();
    for place in places(curve, fineness, budget)? {
        let point = match place {
            Place::At(u) => curve.point(u)?,
            Place::Before(point) => point,
        };
        // Spans on which the curve stands still give no segment.
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    let closed = match points.as_slice() {
        [first, .., last] if points.len() > 3 => {
            let resolved = 4.0 * f64::EPSILON * first.coords.amax().max(last.coords.amax());
            curve.is_periodic() || (last - first).amax() <= resolved
        }
        _ => false,
    };
    if closed {
        points.pop();
    }
    Ok(Polyline { points, closed })
}

/// The parameters at which a curve is cut into chords, both ends of the domain included.
pub(crate) fn parameters(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Vec<f64>> {
    let at = |place| match place {
        Place::At(u) => Some(u),
        Place::Before(_) => None,
    };
    Ok(places(curve, fineness, budget)?.into_iter().filter_map(at).collect())
}

/// A point of the polyline.
enum Place {
    At(f64),
    /// The end of a piece where the curve jumps: its parameter belongs to the next.
    Before(Point),
}

fn places(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Vec<Place>> {
    let frame = Frame::of(curve.points())?;
    let pieces = pieces(curve, &frame);
    let samples = pieces.iter().flat_map(|piece| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| piece.at(t)));
    let target = frame.target(fineness, samples.map(|p| frame.centre + p * frame.size))?;
    let over = |chords: Option<f64>| Err(over_budget(fineness, chords, ("segments", 0.5), budget));
    let estimate: f64 = pieces.iter().map(|piece| piece.estimate(&target)).sum();
    if estimate > BEYOND * budget as f64 {
        return over(Some(estimate));
    }
    let mut places = vec![Place::At(curve.domain().0)];
    let mut start = 0;
    for end in 1..=pieces.len() {
        let open = end < pieces.len();
        if open && !corner(&pieces[end - 1], &pieces[end]) {
            continue;
        }
        let run = Run { pieces: &pieces[start..end], target: &target };
        let Some(cuts) = run.cuts(budget.saturating_sub(places.len() - 1)) else {
            return over(None);
        };
        let (last, jumps) = (pieces[end - 1].at(1.0), open && jumps(&pieces[end - 1], &pieces[end]));
        for (k, &u) in cuts.iter().enumerate() {
            if jumps && k + 1 == cuts.len() {
                places.push(Place::Before(frame.centre + last * frame.size));
            }
            places.push(Place::At(u));
        }
        start = end;
    }
    Ok(places)
}

/// A Bézier piece of the curve between two parameters.
struct Piece {
    a: f64,
    b: f64,
    net: Vec<Homogeneous>,
}

impl Piece {
    /// The point at a fraction of the piece.
    fn at(&self, t: f64) -> Vector {
        let mut net = self.net.clone();
        restrict(&mut net, self.net.len(), 1, [t, 0.0], [1.0, 1.0]);
        project(&net[0])
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
    let piece = |span: usize| {
        let (a, b) = (flat[span], flat[span + 1]);
        extraction(space, span, a, b, &mut rows);
        let combine = |shares: &[f64]| {
            let mut sum = [0.0; 4];
            for (i, share) in shares.iter().enumerate() {
                let vertex = space.vertex(span - p + i);
                let w = share * curve.weights().map_or(1.0, |w| w[vertex]);
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

/// A stretch without corners.
struct Run<'a> {
    pieces: &'a [Piece],
    target: &'a Target,
}

impl Run<'_> {
    /// The ends of the chords after the start of the run; nothing where more than `most` are needed.
    fn cuts(&self, most: usize) -> Option<Vec<f64>> {
        let (start, end) = (self.pieces.first()?.a, self.pieces.last()?.b);
        let mut cuts = vec![start];
        let mut step = end - start;
        let mut from = start;
        while from < end {
            let to = self.reach(from, end, step);
            if cuts.len() > most {
                return None;
            }
            step = to - from;
            cuts.push(to);
            from = to;
        }
        let even = self.evened(&cuts);
        let mut cuts = even.unwrap_or(cuts);
        cuts.remove(0);
        Some(cuts)
    }

    /// The farthest end of a chord from a parameter, to a small part of the chord: first in steps that grow or
    /// shrink, from a guess, then by bisection.
    fn reach(&self, from: f64, end: f64, guess: f64) -> f64 {
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
            // A stretch that doubles cannot divide any further is taken as it is.
            if to <= low || to >= high {
                return if low > from { low } else { high.min(end) };
            }
            if self.holds(from, to) {
                if to >= end {
                    return end;
                }
                low = to;
                step *= 1.25;
            } else {
                high = to;
                step = 0.7 * (to - from);
            }
        }
        low
    }

    /// The same number of chords, each a little shorter, so that the last is not the only one with room to spare.
    fn evened(&self, cuts: &[f64]) -> Option<Vec<f64>> {
        let [.., before, end] = cuts else { return None };
        let n = cuts.len() - 1;
        if n < 2 {
            return None;
        }
        let last = self.share(*before, *end);
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

    /// About what part of the longest chord a chord is, by its distance from the curve or its angle.
    fn share(&self, from: f64, to: f64) -> f64 {
        let chord = self.chord(from, to);
        let sample = |k: usize| self.point(from + (to - from) * k as f64 / 8.0);
        let samples: Vec<Vector> = (0..=8).map(sample).collect();
        let far = samples.iter().map(|p| chord.distance(p)).fold(0.0, f64::max);
        let legs: Vec<Vector> = samples.windows(2).map(|p| p[1] - p[0]).collect();
        let turn: f64 = legs.windows(2).map(|legs| legs[0].angle(&legs[1])).sum::<f64>() * 8.0 / 7.0;
        (far / self.target.chord).sqrt().max(turn / self.target.angle).clamp(0.01, 1.0)
    }

    fn chord(&self, from: f64, to: f64) -> Chord {
        let (from, to) = (self.point(from), self.point(to));
        Chord { from, to, reach: self.target.chord, half: 0.5 * self.target.angle }
    }

    fn index(&self, u: f64) -> usize {
        self.pieces.partition_point(|piece| piece.b <= u).min(self.pieces.len() - 1)
    }

    fn point(&self, u: f64) -> Vector {
        let piece = &self.pieces[self.index(u)];
        piece.at(((u - piece.a) / (piece.b - piece.a)).clamp(0.0, 1.0))
    }

    /// Whether one chord will do between two parameters.
    fn holds(&self, from: f64, to: f64) -> bool {
        let chord = self.chord(from, to);
        let mut net = Vec::new();
        let first = self.index(from);
        // Ends first: where a chord is far too long it mostly shows there.
        self.pieces[first..].iter().take_while(|piece| piece.a < to).all(|piece| {
            let local = |u: f64| ((u - piece.a) / (piece.b - piece.a)).clamp(0.0, 1.0);
            net.clone_from(&piece.net);
            restrict(&mut net, piece.net.len(), 1, [local(from), 0.0], [local(to), 1.0]);
            chord.holds(&net)
        })
    }
}
