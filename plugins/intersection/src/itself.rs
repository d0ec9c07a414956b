//! Where a curve meets itself.
//!
//! Pieces are cut until each turns by no more than an eighth of a turn: then it runs forwards along its chord and meets itself nowhere, and so
//! do two such neighbours that go over into one another. Every other pair of pieces is one of two curves.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::Curve;

use crate::error::Result;
use crate::intersections::{Intersections, Options};
use crate::net::{Frame, Piece};
use crate::pair::{Answer, setting};
use crate::pieces::Pieces;
use crate::search::{Found, Search};

/// Places between two parameters that tell a meeting from the curve passing there.
const PLACES: usize = 16;
/// Halvings of a piece that turns.
const HALVINGS: usize = 60;

/// Where a curve crosses or touches itself, and what of it runs together: each meeting by its two parameters, the smaller one
/// first ([`Meeting::at`](crate::Meeting::at)). Where the curve ends where it starts, or only passes, is no meeting; nor is a loop
/// that leaves a point by less than 8 tolerances.
///
/// As [`curves`](crate::curves): pairs of pieces are cut until they are apart or shown to meet once.
///
/// ```
/// use loftsman_intersection::{Options, self_intersections};
/// use loftsman_kernel::{Point, spline::Curve};
/// let points = [[0.0, 0.0], [3.0, 3.0], [-2.0, 3.0], [1.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0));
/// let found = self_intersections(&Curve::bezier(points.to_vec())?, &Options::default())?;
/// assert!(found.meetings.len() == 1 && (found.meetings[0].point.x - 0.5).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`curves`](crate::curves).
pub fn self_intersections(curve: &Curve, options: &Options) -> Result<Intersections> {
    let (frame, tolerance) = setting(&[curve.hull_bounds()], options)?;
    let inner = tolerance / frame.size;
    let pieces = straightened(Pieces::of_curve(curve, &frame)?, inner);
    let closed = seam(curve, &frame, inner)?;
    let last = pieces.pieces.len() - 1;
    let passes = |i: usize, j: usize| {
        let [a, b] = [&pieces.pieces[i], &pieces.pieces[j]];
        j == i + 1 && forwards(a, b, inner) || closed && i == 0 && j == last && forwards(b, a, inner)
    };
    let mut search = Search::itself(&pieces, &passes, inner);
    let mut kept: Vec<Found> = Vec::new();
    for found in std::mem::take(&mut search.found) {
        if !stays(curve, &found, closed, 8.0 * tolerance)? {
            kept.push(found);
        }
    }
    search.found = kept;
    let spaces = [Some(curve.space()), Some(curve.space()), None];
    Answer { a: curve, b: curve, spaces, frame, tolerance, both: Location::Curve }.of(search)
}

fn seam(curve: &Curve, frame: &Frame, inner: f64) -> Result<bool> {
    let (a, b) = curve.domain();
    Ok(curve.is_periodic() || (curve.point(a)? - curve.point(b)?).norm() <= inner * frame.size)
}

/// The pieces cut until they turn by an eighth of a turn at most, or are as small as the tolerance.
fn straightened(pieces: Pieces, tolerance: f64) -> Pieces {
    let mut straight = Vec::new();
    for piece in pieces.pieces {
        let mut open = vec![(piece, 0)];
        while let Some((piece, depth)) = open.pop() {
            let turns = turning(&legs(&piece, tolerance)) > std::f64::consts::FRAC_PI_4;
            if turns && depth < HALVINGS && piece.splits(0) && piece.extent() > tolerance {
                // Where it turns back on a straight line, halves would only come near to the place.
                let at = turning_back(&piece, tolerance).unwrap_or(0.5);
                open.extend(piece.cut(0, at).into_iter().rev().map(|part| (part, depth + 1)));
            } else {
                straight.push(piece);
            }
        }
    }
    Pieces::new(straight)
}

/// Legs of a control polygon shorter than this part of the tolerance have no direction: they are rounding.
const SHORTEST: f64 = 1e-3;

fn point(c: &[f64; 4]) -> Vector {
    Vector::new(c[0], c[1], c[2]) / c[3]
}

/// The legs of the control polygon that have a direction.
fn legs(piece: &Piece, tolerance: f64) -> Vec<Vector> {
    let least = SHORTEST * tolerance;
    piece.net.windows(2).map(|w| point(&w[1]) - point(&w[0])).filter(|leg| leg.norm() > least).collect()
}

/// Where a piece that lies in a straight line, within the tolerance, turns back first, as far as some places of it tell: a local parameter.
fn turning_back(piece: &Piece, tolerance: f64) -> Option<f64> {
    let longest = |best: Vector, leg: Vector| if leg.norm() > best.norm() { leg } else { best };
    let way = legs(piece, tolerance).into_iter().fold(Vector::zeros(), longest).try_normalize(0.0)?;
    let first = point(piece.net.first()?);
    if piece.net.iter().any(|c| (point(c) - first).cross(&way).norm() > tolerance) {
        return None;
    }
    let speed = |t: f64| piece.jet([t, 0.0]).along[0].dot(&way);
    let places = 4 * piece.orders[0];
    let mut low = (0.0, speed(0.0));
    for k in 1..=places {
        let t = k as f64 / places as f64;
        let mut high = (t, speed(t));
        if low.1 * high.1 < 0.0 {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low.0 + high.0);
                let found = speed(middle);
                if found * low.1 > 0.0 { low = (middle, found) } else { high = (middle, found) }
            }
            // What turns back at an end does not turn within.
            return Some(low.0).filter(|t| (1e-9..=1.0 - 1e-9).contains(t));
        }
        if high.1 != 0.0 {
            low = high;
        }
    }
    None
}

/// The angle by which a polygon turns: no part of its curve turns by more.
fn turning(legs: &[Vector]) -> f64 {
    legs.windows(2).map(|w| w[0].cross(&w[1]).norm().atan2(w[0].dot(&w[1]))).sum()
}

/// Whether the second goes on where the first ends, and both run forwards along the way from start to end: all differences of
/// control vertices are within a half-space then, and with them those of points (weights being positive).
fn forwards(first: &Piece, second: &Piece, tolerance: f64) -> bool {
    let ends = [first.net.last(), second.net.first()].map(|c| c.map_or(Vector::zeros(), point));
    let mut all = legs(first, tolerance);
    all.extend(legs(second, tolerance));
    let way: Vector = all.iter().sum();
    (ends[0] - ends[1]).norm() <= 1e-14 && all.iter().all(|leg| leg.dot(&way) > 0.0)
}

/// Whether the curve stays within a distance of the place on the way from one parameter to the other.
fn stays(curve: &Curve, found: &Found, closed: bool, within: f64) -> Result<bool> {
    let (a, b) = curve.domain();
    let (s, t) = (found.at[0].min(found.at[1]), found.at[0].max(found.at[1]));
    let around = |from: f64, to: f64| -> Result<bool> {
        let first = curve.point(from)?;
        for k in 0..=PLACES {
            let u = if k == PLACES { to } else { from + (to - from) * k as f64 / PLACES as f64 };
            if (curve.point(u)? - first).norm() > within {
                return Ok(false);
            }
        }
        Ok(true)
    };
    Ok(around(s, t)? || closed && around(a, s)? && around(t, b)?)
}
