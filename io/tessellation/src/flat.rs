//! Whether a chord stands for a stretch of a curve: decided from Bézier points, as sharply as one likes.

use loftsman_kernel::Vector;
use smallvec::{SmallVec, smallvec};

use crate::bezier::restrict;
use crate::patch::{Homogeneous, project};

/// How often a stretch is halved to decide between a hull that sticks out and a curve that does.
const DEPTH: u32 = 12;
/// Legs shorter than this (in the shape's frame) are rounding and have no direction.
const LEG: f64 = 1e-13;

/// Angles above this are told by their cosines.
const SMALL_ANGLE: f64 = 0.01;

/// A chord, and what a curve must keep to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord {
    pub(crate) from: Vector,
    pub(crate) to: Vector,
    /// The largest distance.
    pub(crate) reach: f64,
    /// The largest angle between the chord and the curve: half of what neighbouring chords may turn. Not asked of
    /// chords no longer than twice `reach`.
    pub(crate) half: f64,
}

/// One answer: certainly, certainly not, or not to be told from these Bézier points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    Yes,
    No,
    Unknown,
}

impl Chord {
    /// Whether a Bézier piece is within reach of the chord and within the angle.
    ///
    /// A curve is in the hull of its control points and distance from a segment is convex; its tangents are in the
    /// cone of its control polygon's legs. Where hull and cone are not enough but no point of the curve breaks the
    /// rule, the piece is halved, at most twelve times: what is then still open is a "no".
    pub(crate) fn holds(&self, net: &[Homogeneous]) -> bool {
        match self.ask(net) {
            Answer::Yes => return true,
            Answer::No => return false,
            Answer::Unknown => {}
        }
        let mut open: SmallVec<[(u32, f64, f64); 16]> = smallvec![(0_u32, 0.0, 1.0)];
        let mut part = SmallVec::<[Homogeneous; 8]>::from_slice(net);
        while let Some((depth, a, b)) = open.pop() {
            let middle = 0.5 * (a + b);
            for (a, b) in [(middle, b), (a, middle)] {
                part.copy_from_slice(net);
                restrict(&mut part, net.len(), 1, [a, 0.0], [b, 1.0]);
                match self.ask(&part) {
                    Answer::Yes => {}
                    Answer::Unknown if depth < DEPTH => open.push((depth + 1, a, b)),
                    _ => return false,
                }
            }
        }
        true
    }

    fn ask(&self, net: &[Homogeneous]) -> Answer {
        let along = self.to - self.from;
        let length = along.norm();
        let turning = length > 2.0 * self.reach && self.half < std::f64::consts::PI;
        // Of angles that are not small their cosines tell as well.
        let least = if self.half > SMALL_ANGLE { self.half.cos() * length } else { f64::NAN };
        let mut answer = Answer::Yes;
        let last = net.len() - 1;
        let mut before: Option<Vector> = None;
        for (k, h) in net.iter().enumerate() {
            let point = project(h);
            let end = k == 0 || k == last;
            if self.distance(&point) > self.reach {
                if end {
                    return Answer::No;
                }
                answer = Answer::Unknown;
            }
            if let Some(before) = before.filter(|_| turning) {
                // The first and last legs are tangents of the curve.
                let leg = point - before;
                let off = if least.is_nan() {
                    self.off(&leg) > self.half
                } else {
                    let size = leg.norm();
                    size > LEG && along.dot(&leg) < least * size
                };
                if off {
                    if k == 1 || k == last {
                        return Answer::No;
                    }
                    answer = Answer::Unknown;
                }
            }
            before = Some(point);
        }
        answer
    }

    /// A bound of how far a Bézier piece is from the chord, and the chord's part from it: at most `1.05` times what some point
    /// of the piece is, unless that is less than `known`, of which nothing is gained. `holds` is known of it.
    pub(crate) fn bound(&self, net: &[Homogeneous], known: f64) -> f64 {
        let mut worst = known;
        let mut open: SmallVec<[(u32, f64, f64); 16]> = smallvec![(0_u32, 0.0, 1.0)];
        let mut part = SmallVec::<[Homogeneous; 8]>::from_slice(net);
        while let Some((depth, a, b)) = open.pop() {
            part.copy_from_slice(net);
            restrict(&mut part, net.len(), 1, [a, 0.0], [b, 1.0]);
            let hull = part.iter().map(|h| self.distance(&project(h))).fold(0.0, f64::max);
            let ends = [0, part.len() - 1].map(|k| self.distance(&project(&part[k])));
            worst = worst.max(ends[0]).max(ends[1]);
            if hull <= 1.05 * worst || depth == 6 {
                worst = worst.max(hull.min(self.reach));
            } else {
                let middle = 0.5 * (a + b);
                open.extend([(depth + 1, a, middle), (depth + 1, middle, b)]);
            }
        }
        worst
    }

    /// The distance from the chord.
    pub(crate) fn distance(&self, point: &Vector) -> f64 {
        let (chord, to) = (self.to - self.from, point - self.from);
        let squared = chord.norm_squared();
        let along = if squared > 0.0 { (to.dot(&chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (to - chord * along).norm()
    }

    fn off(&self, leg: &Vector) -> f64 {
        if leg.norm() <= LEG { 0.0 } else { (self.to - self.from).angle(leg) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_circle_is_flat_from_its_sagitta_and_its_angle_on() {
        let h = 0.5_f64.sqrt();
        let net = [[1.0, 0.0, 0.0, 1.0], [h, h, 0.0, h], [0.0, 1.0, 0.0, 1.0]];
        let sagitta = 1.0 - h;
        let chord = |reach: f64, half: f64| Chord { from: Vector::x(), to: Vector::y(), reach, half };
        assert!(chord(sagitta * 1.001, 10.0).holds(&net) && !chord(sagitta * 0.999, 10.0).holds(&net));
        let eighth = std::f64::consts::FRAC_PI_4;
        assert!(chord(0.3, eighth * 1.001).holds(&net) && !chord(0.3, eighth * 0.999).holds(&net));
    }

    #[test]
    fn what_runs_beyond_the_ends_of_its_chord_is_off_it() {
        let net = [0.0, 6.0, -5.0, 1.0].map(|x| [x, 0.0, 0.0, 1.0]);
        let chord = |reach| Chord { from: Vector::zeros(), to: Vector::x(), reach, half: 10.0 };
        assert!(!chord(0.05).holds(&net) && chord(2.0).holds(&net));
    }
}
