//! An edge of a surface, cut by its own data alone: surfaces whose edges coincide get the same points there.

use loftsman_kernel::{Point, Vector};

use crate::bezier::restrict;
use crate::flat::Chord;
use crate::patch::{Homogeneous, project, xyz};

/// The part of the tolerance that edges may take: cells beside them keep the rest for what bends across. Less than half,
/// so that a cell that is thin enough along an edge can always be certified (see `Judge::hugging`).
pub(crate) const SHARE: f64 = 0.45;
/// Halvings of an edge at most.
const DEPTH: u32 = 30;
/// Halvings until the foot of a point is left to Newton's steps, and how many of these.
const FOOT_DEPTH: u32 = 8;
const STEPS: usize = 12;
/// How many parts of an edge are looked at for a foot.
const LOOKS: usize = 4096;

/// One Bézier piece of an edge, in the surface's own coordinates.
pub(crate) struct Border {
    /// Control points in an order that does not depend on which way the surface runs.
    net: Vec<Homogeneous>,
    turned: bool,
}

impl Border {
    /// The edge with these control points.
    pub(crate) fn new(mut net: Vec<Homogeneous>) -> Self {
        let backward = net.iter().rev().map(project);
        let order = |(a, b): (Vector, Vector)| {
            let unequal = (0..3).find(|&k| a[k] != b[k])?;
            Some(a[unequal] > b[unequal])
        };
        let turned = net.iter().map(project).zip(backward).find_map(order).unwrap_or(false);
        if turned {
            net.reverse();
        }
        Self { net, turned }
    }

    /// The fractions (of the surface's parameter, ascending) at which the edge is cut into chords that are within
    /// not quite half the tolerance of it and turn by no more than the angle. All are reached by halving.
    ///
    /// Nothing but the edge's own control points, the tolerance (a length) and the angle has a say.
    pub(crate) fn fractions(&self, chord: f64, angle: f64) -> Vec<f64> {
        let points: Vec<Vector> = self.net.iter().map(project).collect();
        let Some(&origin) = points.first() else { return Vec::new() };
        let size = points.iter().map(|p| (p - origin).amax()).fold(0.0, f64::max);
        if !(size > 0.0 && size.is_finite()) {
            return Vec::new();
        }
        // Relative to the edge itself, so that neither place nor unit matters.
        let local = |h: &Homogeneous| {
            let p = (project(h) - origin) / size * h[3];
            [p.x, p.y, p.z, h[3]]
        };
        let net: Vec<Homogeneous> = self.net.iter().map(local).collect();
        let mut part = net.clone();
        let mut cuts = Vec::new();
        let mut open = vec![(0_u32, 0.0, 1.0)];
        while let Some((depth, a, b)) = open.pop() {
            part.copy_from_slice(&net);
            restrict(&mut part, net.len(), 1, [a, 0.0], [b, 1.0]);
            let (from, to) = (project(&part[0]), project(&part[part.len() - 1]));
            let rule = Chord { from, to, reach: SHARE * chord / size, half: 0.5 * angle };
            let meets = bound(&part) <= rule.reach && rule.holds(&part);
            // At rounding size nothing can be told any more.
            if depth < DEPTH && rule.reach > f64::EPSILON && !meets {
                let middle = 0.5 * (a + b);
                open.extend([(depth + 1, middle, b), (depth + 1, a, middle)]);
            } else if b < 1.0 {
                cuts.push(b);
            }
        }
        if self.turned {
            cuts.reverse();
            // Exact: the fractions are dyadic.
            cuts.iter_mut().for_each(|x| *x = 1.0 - *x);
        }
        cuts
    }

    /// The box of the control points.
    pub(crate) fn extent(&self) -> (Vector, Vector) {
        let first = self.net.first().map_or(Vector::zeros(), project);
        self.net.iter().map(project).fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)))
    }

    /// The fraction of a point on the edge, or within `near` of it; `None` where it is not.
    ///
    /// Halves whose control points' box is further away are left out, so that no other place can be nearer; the last is polished by Gauss and Newton's
    /// steps on `|C(t) - x|`, the slope by differences. `O(p² log 1 / near)`.
    pub(crate) fn foot(&self, point: Point, near: f64) -> Option<f64> {
        let x = point.coords;
        let within = |net: &[Homogeneous]| {
            (0..3).all(|k| {
                let of = net.iter().map(|h| project(h)[k] - x[k]);
                let (low, high) = of.fold((f64::MAX, f64::MIN), |(low, high), c| (low.min(c), high.max(c)));
                low <= near && high >= -near
            })
        };
        let mut part = self.net.clone();
        let mut best: Option<(f64, f64)> = None;
        let mut open = vec![(0_u32, 0.0, 1.0)];
        // What stands still is looked at no closer than this many times.
        let mut looks = 0;
        while let Some((depth, a, b)) = open.pop() {
            part.copy_from_slice(&self.net);
            restrict(&mut part, self.net.len(), 1, [a, 0.0], [b, 1.0]);
            looks += 1;
            if !within(&part) || looks > LOOKS {
                continue;
            }
            let middle = 0.5 * (a + b);
            if depth < FOOT_DEPTH {
                open.extend([(depth + 1, middle, b), (depth + 1, a, middle)]);
                continue;
            }
            for t in [a, middle, b] {
                let t = self.polished(x, t);
                let distance = (self.at(t) - x).norm();
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, t));
                }
            }
        }
        let (_, t) = best.filter(|(distance, _)| *distance <= near)?;
        Some(if self.turned { 1.0 - t } else { t })
    }

    /// A parameter nearer to the foot of a point, if it can be had.
    fn polished(&self, x: Vector, from: f64) -> f64 {
        let mut t = from;
        for _ in 0..STEPS {
            let h = 1e-4;
            let (a, b) = ((t - h).max(0.0), (t + h).min(1.0));
            let slope = (self.at(b) - self.at(a)) / (b - a);
            let square = slope.norm_squared();
            if !(square > 0.0 && square.is_finite()) {
                return t;
            }
            let next = (t - (self.at(t) - x).dot(&slope) / square).clamp(0.0, 1.0);
            if next == t {
                break;
            }
            t = next;
        }
        t
    }

    fn at(&self, t: f64) -> Vector {
        let mut net = self.net.clone();
        restrict(&mut net, self.net.len(), 1, [t, 0.0], [1.0, 1.0]);
        project(&net[0])
    }

    /// The point at a fraction of the surface's parameter.
    pub(crate) fn point(&self, fraction: f64) -> Point {
        self.at(if self.turned { 1.0 - fraction } else { fraction }).into()
    }
}

/// The distance from the chord as cells beside the edge bound it, in any direction across the chord: an eighth of the
/// largest second derivative of `A - C(0) W`, over the least weight (see [`form`](crate::form)).
fn bound(net: &[Homogeneous]) -> f64 {
    let (from, to) = (project(&net[0]), project(&net[net.len() - 1]));
    let along = (to - from).try_normalize(0.0).unwrap_or_default();
    let p = net.len() as f64 - 1.0;
    let least = net.iter().map(|h| h[3]).fold(f64::MAX, f64::min);
    let off = |h: &Homogeneous| {
        let x = xyz(h) - from * h[3];
        x - along * x.dot(&along)
    };
    let second =
        net.windows(3).map(|b| (off(&b[2]) - off(&b[1]) * 2.0 + off(&b[0])).norm()).fold(0.0, f64::max);
    p * (p - 1.0) * second / (8.0 * least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_run_backwards_is_cut_at_the_same_points() {
        let net: Vec<Homogeneous> =
            [[0.0, 1.0, 2.0, 0.1], [1.0, -2.0, 0.3, 0.7], [2.5, 3.0, 1.0, 1.0], [4.0, 0.0, 0.0, 0.9]]
                .to_vec();
        let forward = Border::new(net.clone());
        let backward = Border::new(net.into_iter().rev().collect());
        let (a, b) = (forward.fractions(1e-2, 1.0), backward.fractions(1e-2, 1.0));
        assert!(a.len() > 3 && a.len() == b.len());
        for (x, y) in a.iter().zip(b.iter().rev()) {
            assert_eq!(forward.point(*x), backward.point(*y));
        }
    }
}
