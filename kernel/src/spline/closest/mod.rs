//! The closest point of a curve or a surface to a given point: the global one, not a neighbouring minimum.
//!
//! Branch and bound. Every span starts with the distance to the box of its control vertices as a bound from below;
//! the span with the least bound is taken first, in Bézier form. With `D = A - W Q` (homogeneous, measured from the
//! given point `Q`) a piece is done when
//! * all Bernstein coefficients of `D·D - r² W²` are at least 0 (`r` is the best distance, less the tolerance): by
//!   the convex hull property nothing on the piece is closer. This settles circles around their centre at once;
//! * (curves) the coefficients of `(D·D)' W - (D·D) W'`, the sign of the distance's slope, change sign at most once:
//!   then so does the slope, and the ends or one bracketed root hold the minimum.
//!
//! Otherwise it is halved. Variation diminishing: Farin, *Curves and Surfaces for CAGD*, 5th ed., ch. 6.

mod bernstein;
mod curve;
mod surface;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use super::Space;
use crate::Point;
use crate::error::{Error, Result};

pub(crate) use surface::Kept;

/// Nothing closer than this much of the distance is missed, relative to the distance …
const RELATIVE: f64 = 1e-10;
/// … and to the size of the shape seen from the point.
const ABSOLUTE: f64 = 1e-13;
/// Pieces looked at before the search stops with what it has.
const PIECES: usize = 200_000;

/// The closest point that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest<L> {
    /// Where on the shape: `u`, or `(u, v)`.
    pub at: L,
    /// The point there.
    pub point: Point,
    /// Its distance.
    pub distance: f64,
    /// No point of the shape is closer than `distance - gap`. As a rule `1e-10 distance + 1e-13 size`, with the
    /// extent of the shape as seen from the point as size; more only where a search of 200,000 pieces was not enough.
    pub gap: f64,
}

type Homogeneous = [f64; 4];

/// A piece of a shape in Bézier form around the given point, and the parameters it covers.
struct Piece {
    bound: f64,
    order: usize,
    u: (f64, f64),
    v: (f64, f64),
    net: Vec<Homogeneous>,
    /// How far, about, one step of the parameters' last digit goes, where that is more than rounding: its bound is larger by so much than the piece.
    resolution: f64,
    /// The spans of a piece that is not yet in Bézier form.
    spans: (usize, usize),
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    /// The least bound is the greatest piece; of equal ones the first made, so that the answer is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.order.cmp(&self.order))
    }
}

/// Where a span ends. Where the shape is torn there, its value at the knot is that of what follows: the number before the knot
/// stands for the end of this span.
fn end_of(space: &Space, span: usize) -> f64 {
    let end = space.flat()[span + 1];
    let inside = space.is_periodic() || end < space.domain().1;
    if inside && space.multiplicity(end) > space.degree() { end.next_down() } else { end }
}

/// The best point so far.
struct Best<L> {
    at: L,
    point: Point,
    distance: f64,
    size: f64,
    /// What was left open: nothing below this bound was missed.
    open: f64,
    /// By how much less, and by what part, would not be worth finding, if that is more than rounding.
    slack: (f64, f64),
}

impl<L: Copy> Best<L> {
    fn new(at: L, size: f64) -> Self {
        Self {
            at,
            point: Point::origin(),
            distance: f64::INFINITY,
            size,
            open: f64::INFINITY,
            slack: (0.0, 0.0),
        }
    }

    fn offer(&mut self, at: L, (point, distance): (Point, f64)) {
        if distance < self.distance {
            (self.at, self.point, self.distance) = (at, point, distance);
        }
    }

    /// The distance below which a point would be worth finding.
    fn enough(&self) -> f64 {
        let (absolute, relative) = self.slack;
        let relative = relative.max(RELATIVE);
        (self.distance * (1.0 - relative) - absolute.max(ABSOLUTE * self.size)).max(0.0)
    }

    fn answer(self) -> Closest<L> {
        let gap = self.distance - self.enough().min(self.open);
        Closest { at: self.at, point: self.point, distance: self.distance, gap }
    }
}

impl<L: Copy> Closest<L> {
    /// What was found of a shape that was scaled, said of the shape.
    fn scaled_back(self, factor: f64, point: impl Fn(L) -> Result<Point>) -> Result<Self> {
        let (distance, gap) = (self.distance / factor, self.gap / factor);
        if !distance.is_finite() {
            return Err(Error::Invalid(
                "the distance to the point is larger than any number: scale both down".into(),
            ));
        }
        Ok(Self { at: self.at, point: point(self.at)?, distance, gap })
    }
}

/// Sizes between which fourth powers (determinants of squares), and products of squares with weights, neither overflow nor vanish.
const SQUARES: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// The power of two that brings points, seen from a place, to a size near 1; none where their squares are numbers as they are.
fn factor_for_squares(points: &[Point], from: Point) -> Option<f64> {
    // Halves, so that no difference overflows.
    let far = |p: &Point| (p.coords * 0.5 - from.coords * 0.5).amax();
    let reach = points.iter().map(far).fold(0.0, f64::max);
    // What is much larger than the shape would still overflow when it is squared.
    let size = points.iter().chain([&from]).map(|p| p.coords.amax()).fold(reach, f64::max);
    let power = |size: f64| 2.0_f64.powi((-size.log2().ceil()).clamp(-1022.0, 1022.0) as i32);
    if size > *SQUARES.end() {
        return Some(power(size));
    }
    // What is small and lies far out stays where it is: nothing of it is to overflow.
    let small = reach > 0.0 && reach < *SQUARES.start();
    Some(power(reach)).filter(|factor| small && size * factor <= *SQUARES.end())
}

fn times(points: &[Point], factor: f64) -> Vec<Point> {
    points.iter().map(|p| p * factor).collect()
}

fn check(point: Point) -> Result<()> {
    if point.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    let Point { coords } = point;
    Err(Error::Invalid(format!("the point ({}, {}, {}) must be finite", coords.x, coords.y, coords.z)))
}
