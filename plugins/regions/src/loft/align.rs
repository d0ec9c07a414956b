//! Sections made to face one another: which way they run, and where they start.
//!
//! A loft joins what has the same parameter. So before anything is interpolated, each section is turned to run as the one
//! before it does, and begun where it faces that one's start. Both are exact: a curve is reversed, or begun elsewhere with
//! a knot more.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Curve, Space};

use crate::error::Result;

/// What was done to a section.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aligned {
    /// Whether it runs the other way now.
    pub reversed: bool,
    /// Where it starts now, as a share of its parameters from its own start on, in the direction in which it runs now;
    /// 0 where it starts as it did.
    pub turned: f64,
}

/// Places at which sections are compared.
const SAMPLES: usize = 512;
/// A start this near to another that needs no new knot, or fewer, becomes that one: a share of the period. What it costs in
/// twist is less than 1e-6 of any length.
const SNAP: f64 = 1e-4;
/// Sections nearer than this to one another, as a share of their size, tell nothing by where they lie.
const APART: f64 = 0.5;

/// The sections, each turned round and begun so that it faces the one before it as well as it can, over `[0, L]` with `L`
/// the length of the first one's domain.
///
/// *Sense.* Closed sections with an area: `n` their area vectors, the later one carried back along the chord `d` between the
/// centres. `n·m + 10 (n·d)(m·d)` is positive where they run alike: the first term decides for sections that are nearly
/// parallel (sheared as they may be), the second one for a pipe that bends by more than a quarter turn. Others: whichever
/// sense can be brought nearer.
///
/// *Start.* With the plane of the one before rotated onto its own (the least rotation) and centres on one another, the
/// start that makes `Σ |p_i - q_i|²` least over 512 places of equal parameter; since each sum of squares stays, that is
/// where `Σ p_i·q_i(s)` is largest. The best of 512 is refined by a root of the derivative, and moved to a knot nearby.
///
/// Open sections are reversed where their points are nearer then.
///
/// # Errors
/// When rounding makes knots coincide that were apart.
pub(super) fn align(sections: &[Curve]) -> Result<(Vec<Curve>, Vec<Aligned>)> {
    let closed = sections.iter().all(is_closed);
    let mut curves: Vec<Curve> = Vec::with_capacity(sections.len());
    let mut changes = Vec::with_capacity(sections.len());
    let mut before: Option<Sampled> = None;
    let length = sections.first().map_or(1.0, |s| s.space().length());
    for section in sections {
        let section = section.reparametrise(0.0, length)?;
        let mut own = Sampled::new(&section);
        let mut change = Aligned::default();
        let mut curve = section;
        if let (Some(before), Some(last)) = (&before, curves.last()) {
            change.reversed = if closed { before.opposes(&own) } else { before.nearer_reversed(&own) };
            if change.reversed {
                curve = curve.reverse()?;
                own = own.reversed();
            }
            if closed {
                change.turned = snapped(before.best_start(&own, &curve), last.space(), curve.space());
                if change.turned > 0.0 {
                    let at = at_share(curve.space(), change.turned);
                    curve = curve.started_at(at)?.reparametrise(0.0, length)?;
                    own = Sampled::new(&curve);
                }
            }
        }
        before = Some(own);
        curves.push(curve);
        changes.push(change);
    }
    Ok((curves, changes))
}

/// Whether a curve ends where it starts, to rounding.
fn is_closed(curve: &Curve) -> bool {
    let (a, b) = curve.domain();
    let size = curve.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    let gap = || Some((curve.point(a).ok()? - curve.point(b).ok()?).amax());
    curve.is_periodic() || gap().is_some_and(|gap| gap <= 64.0 * f64::EPSILON * size)
}

/// The knot at a share of the domain, to the last bit where it is one.
fn at_share(space: &Space, share: f64) -> f64 {
    let (a, b) = space.domain();
    let at = a + share * (b - a);
    let slack = 8.0 * f64::EPSILON * a.abs().max(b.abs());
    space.breakpoints().into_iter().find(|k| (k - at).abs() <= slack).unwrap_or(at)
}

/// A start moved to a place nearby that costs fewer knots: none, where the section has a knot; else where one of its knots
/// then meets one of the section before.
fn snapped(start: f64, before: &Space, own: &Space) -> f64 {
    let shares = |space: &Space| {
        let (a, b) = space.domain();
        let mut shares: Vec<f64> = space.breakpoints().iter().map(|k| (k - a) / (b - a)).collect();
        shares.pop();
        shares
    };
    let (own, before) = (shares(own), shares(before));
    let nearest = |at: f64| {
        let next = own.partition_point(|&k| k < at);
        let (low, high) = (next.checked_sub(1).map(|i| own[i]), own.get(next).copied());
        // Round the seam: the last knot of the turn before, and the first of the next.
        let low = low.unwrap_or_else(|| own.last().copied().unwrap_or(0.0) - 1.0);
        let high = high.unwrap_or_else(|| own.first().copied().unwrap_or(0.0) + 1.0);
        if at - low <= high - at { low } else { high }
    };
    let mut best = (SNAP, start);
    for (i, &k) in before.iter().enumerate() {
        let wrapped = (start + k).rem_euclid(1.0);
        let off = nearest(wrapped) - wrapped;
        if off.abs() <= best.0 {
            best = (off.abs(), start + off);
            if i == 0 {
                break;
            }
        }
    }
    let turned = best.1.rem_euclid(1.0);
    // Rounding round the seam: a start that is the start.
    if (1e-14..=1.0 - 1e-14).contains(&turned) { turned } else { 0.0 }
}

/// A section at places of equal parameter.
struct Sampled {
    /// From the centre, over the size.
    points: Vec<Vector>,
    centre: Vector,
    /// The largest distance from the centre.
    size: f64,
    /// The unit normal of its area vector; none where it has no area to speak of.
    normal: Option<Vector>,
}

impl Sampled {
    fn new(curve: &Curve) -> Self {
        let (a, b) = curve.domain();
        let at = |i: usize| a + (b - a) * (i as f64 + 0.5) / SAMPLES as f64;
        let points: Vec<Vector> =
            (0..SAMPLES).map(|i| curve.point(at(i)).map_or_else(|_| Vector::zeros(), |p| p.coords)).collect();
        let centre = points.iter().fold(Vector::zeros(), |sum, p| sum + p / SAMPLES as f64);
        let size = points.iter().fold(0.0_f64, |m, p| m.max((p - centre).amax()));
        let unit = if size > 0.0 { size } else { 1.0 };
        let points: Vec<Vector> = points.iter().map(|p| (p - centre) / unit).collect();
        let area = area_vector(&points);
        let normal = area.try_normalize(1e-3);
        Self { points, centre, size, normal }
    }

    fn reversed(self) -> Self {
        let points = self.points.into_iter().rev().collect();
        Self { points, normal: self.normal.map(|n| -n), ..self }
    }

    /// Whether another closed section runs the other way round.
    fn opposes(&self, other: &Self) -> bool {
        if let (Some(n), Some(m)) = (self.normal, other.normal) {
            let chord = other.centre - self.centre;
            let near = chord.amax() <= APART * self.size.max(other.size);
            let along = chord.try_normalize(f64::MIN_POSITIVE).filter(|_| !near);
            let bend = along.map_or(0.0, |d| 10.0 * n.dot(&d) * m.dot(&d));
            let score = n.dot(&m) + bend;
            if score.abs() > 0.05 {
                return score < 0.0;
            }
        }
        let best =
            |points: &[Vector]| self.correlations(points).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let backwards: Vec<Vector> = other.points.iter().rev().copied().collect();
        let (same, opposite) = (best(&other.points), best(&backwards));
        opposite > same + 1e-9 * same.abs()
    }

    /// Whether the points of another open section, run through backwards, are nearer.
    fn nearer_reversed(&self, other: &Self) -> bool {
        let unit = self.size.max(other.size).max(f64::MIN_POSITIVE);
        let place = |s: &Self, i: usize| s.points[i] * (s.size / unit) + s.centre / unit;
        let sum = |other_of: &dyn Fn(usize) -> usize| -> f64 {
            (0..SAMPLES).map(|i| (place(self, i) - place(other, other_of(i))).norm_squared()).sum()
        };
        let (same, opposite) = (sum(&|i| i), sum(&|i| SAMPLES - 1 - i));
        opposite < same - 1e-9 * same
    }

    /// The points in the other section's plane: the least rotation that brings the normal there.
    fn carried_to(&self, other: &Self) -> Vec<Vector> {
        let (Some(n), Some(m)) = (self.normal, other.normal) else { return self.points.clone() };
        let (axis, cosine) = (n.cross(&m), n.dot(&m));
        if cosine > -0.999 {
            let turn = |v: &Vector| {
                let once = axis.cross(v);
                v + once + axis.cross(&once) / (1.0 + cosine)
            };
            return self.points.iter().map(turn).collect();
        }
        // A half turn about the line across which a pipe would bend back.
        let Some(axis) = n.cross(&(other.centre - self.centre)).try_normalize(0.0) else {
            return self.points.clone();
        };
        self.points.iter().map(|v| axis * (2.0 * axis.dot(v)) - v).collect()
    }

    /// `Σ p_i·q_(i+j)` for every shift `j`.
    fn correlations(&self, others: &[Vector]) -> Vec<f64> {
        correlate(&self.points, others)
    }

    /// The share of `curve`'s parameters, sampled as `own`, at which it should start.
    fn best_start(&self, own: &Self, curve: &Curve) -> f64 {
        let carried = self.carried_to(own);
        let sums = correlate(&carried, &own.points);
        let largest = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
        // Nothing to choose by, or the start as it is as good as any.
        let spread = largest - least;
        if spread.is_nan() || spread <= 1e-9 * SAMPLES as f64 || sums[0] >= largest - 1e-12 * spread {
            return 0.0;
        }
        let Some(best) = sums.iter().position(|&s| s == largest) else { return 0.0 };
        let (a, b) = curve.domain();
        let slope = |share: f64| -> f64 {
            let mut sum = 0.0;
            for (i, p) in carried.iter().enumerate() {
                let at = (share + (i as f64 + 0.5) / SAMPLES as f64).rem_euclid(1.0);
                let mut out = [Vector::zeros(); 2];
                if curve.derivatives_into((a + at * (b - a)).min(b), &mut out).is_ok() {
                    sum += p.dot(&out[1]);
                }
            }
            sum
        };
        let step = 1.0 / SAMPLES as f64;
        let middle = best as f64 * step;
        root(middle - step, middle + step, slope).unwrap_or(middle)
    }
}

/// `½ Σ p_i × p_(i+1)`.
pub(super) fn area_vector(points: &[Vector]) -> Vector {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).fold(Vector::zeros(), |sum, (p, q)| sum + p.cross(q)) * 0.5
}

fn correlate(points: &[Vector], others: &[Vector]) -> Vec<f64> {
    let n = others.len();
    let twice: Vec<Vector> = others.iter().chain(others).copied().collect();
    (0..n).map(|j| points.iter().zip(&twice[j..j + n]).map(|(p, q)| p.dot(q)).sum()).collect()
}

/// Where a function falls through zero between `low` and `high`, by the Illinois method; none where it does not.
fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut left, mut right) = (f(low), f(high));
    if !(left >= 0.0 && right <= 0.0 && left > right) {
        return None;
    }
    let mut side = 0;
    for _ in 0..40 {
        let at = (low * right - high * left) / (right - left);
        if !(at > low && at < high) || high - low < 1e-13 {
            return Some(at.clamp(low, high));
        }
        let value = f(at);
        if value > 0.0 {
            (low, left) = (at, value);
            if side == 1 {
                right *= 0.5;
            }
            side = 1;
        } else if value < 0.0 {
            (high, right) = (at, value);
            if side == -1 {
                left *= 0.5;
            }
            side = -1;
        } else {
            return Some(at);
        }
    }
    Some(0.5 * (low + high))
}
