//! Frames along a line that turn about it as little as can be.

use std::f64::consts::TAU;

use loftsman_kernel::{Point, Vector, direction};

use super::line::State;

/// A vector across the line at each of its points, of length 1: as the line arrives there, and as it leaves. They differ
/// at corners only.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frames {
    pub(super) arriving: Vec<Vector>,
    pub(super) leaving: Vec<Vector>,
    /// By how much a closed line's frames are turned on the way round, so that the last meets the first: spread by arc length.
    twist: f64,
}

impl Frames {
    /// The frames of a state: each goes over into the next by the rotation-minimising double reflection (Wang, Jüttler, Zheng
    /// and Liu 2008, table 1), whose error is of fourth order in the step, and over corners by the smallest rotation. What
    /// is missing after a closed line's way round is spread evenly over its length.
    ///
    /// Of a state that follows another all frames are then turned by one angle, so that they are as near to those before as
    /// can be: `Σ lᵢ ‖rᵢ - rᵢ'‖²` is least; and a closed line's twist is that of the same number of turns.
    /// `O(points)`.
    pub(super) fn of(state: &State, closed: bool, before: Option<(&State, &Self)>) -> Self {
        let (points, arrive, leave) = (&state.points, &state.arrive, &state.leave);
        let start = match before {
            Some((before, frames)) => turned(&frames.leaving[0], &before.leave[0], &leave[0]),
            None => across(&leave[0]),
        };
        let count = points.len();
        let mut arriving = Vec::with_capacity(count);
        let mut leaving = vec![start];
        arriving.push(turned(&start, &leave[0], &arrive[0]));
        for i in 1..count {
            let ends = [&points[i - 1], &points[i]];
            let next = reflected_twice(&leaving[i - 1], ends, &leave[i - 1], &arrive[i]);
            leaving.push(turned(&next, &arrive[i], &leave[i]));
            arriving.push(next);
        }
        let mut found = Self { arriving, leaving, twist: 0.0 };
        if closed {
            let last = count - 1;
            let ends = [&points[last], &points[0]];
            let round = reflected_twice(&found.leaving[last], ends, &leave[last], &arrive[0]);
            let round = turned(&round, &arrive[0], &leave[0]);
            found.twist = angle(&round, &start, &leave[0]);
            if let Some((_, frames)) = before {
                found.twist += TAU * ((frames.twist - found.twist) / TAU).round();
            }
            let whole = state.lengths[count];
            for i in 0..count {
                let share = if whole > 0.0 { state.lengths[i] / whole } else { i as f64 / count as f64 };
                found.turn(i, found.twist * share, state);
            }
            // A corner at the start is arrived at with the whole of it.
            found.arriving[0] = turned(&found.leaving[0], &leave[0], &arrive[0]);
        }
        if let Some((_, frames)) = before {
            let (mut along, mut aside) = (0.0, 0.0);
            for i in 0..count {
                let share = state.lengths[i + 1] - state.lengths[i];
                let share = if share > 0.0 { share } else { f64::MIN_POSITIVE };
                let (old, new) = (&frames.leaving[i], &found.leaving[i]);
                along += share * old.dot(new);
                aside += share * old.dot(&leave[i].cross(new));
            }
            let by = aside.atan2(along);
            if by.is_finite() {
                (0..count).for_each(|i| found.turn(i, by, state));
            }
        }
        found
    }

    fn turn(&mut self, i: usize, angle: f64, state: &State) {
        let (sine, cosine) = angle.sin_cos();
        for (r, t) in [(&mut self.arriving[i], &state.arrive[i]), (&mut self.leaving[i], &state.leave[i])] {
            *r = upright(&(*r * cosine + t.cross(r) * sine), t);
        }
    }
}

/// Any direction across another: the part across of the axis that it has least of.
fn across(t: &Vector) -> Vector {
    let mut axis = Vector::zeros();
    axis[t.iamin()] = 1.0;
    upright(&axis, t)
}

/// The part of a vector across a direction, of length 1.
fn upright(r: &Vector, t: &Vector) -> Vector {
    let across = r - t * t.dot(r);
    across.try_normalize(1e-6).unwrap_or_else(|| {
        let mut axis = Vector::zeros();
        axis[t.iamin()] = 1.0;
        (axis - t * t.dot(&axis)).normalize()
    })
}

/// A vector across `from` after the smallest rotation that takes `from` to `to`; where that is half a turn, which has no
/// axis of its own, about the vector itself.
pub(super) fn turned(r: &Vector, from: &Vector, to: &Vector) -> Vector {
    let both = from + to;
    let sum = 1.0 + from.dot(to);
    if sum < 1e-12 {
        return upright(r, to);
    }
    upright(&(r - both * (to.dot(r) / sum)), to)
}

/// The frame at the end of a chord: reflected in the plane across its middle, then in the one that takes the direction
/// that is left to the one that is there.
fn reflected_twice(r: &Vector, [from, to]: [&Point; 2], leave: &Vector, arrive: &Vector) -> Vector {
    let chord = to - from;
    let Some(way) = direction(&chord) else {
        return turned(r, leave, arrive);
    };
    let mirrored = |v: &Vector, across: &Vector| v - across * (2.0 * across.dot(v));
    let (r, t) = (mirrored(r, &way), mirrored(leave, &way));
    let r = match (arrive - t).try_normalize(1e-12) {
        Some(second) => mirrored(&r, &second),
        None => r,
    };
    upright(&r, arrive)
}

/// The angle about `t` from one vector across it to another.
fn angle(from: &Vector, to: &Vector, t: &Vector) -> f64 {
    to.dot(&t.cross(from)).atan2(to.dot(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tube::line::State;
    use std::f64::consts::PI;

    /// A state of a line given by points and directions.
    fn state(of: impl Fn(f64) -> (Point, Vector), count: usize, closed: bool) -> State {
        let at = |i: usize| of(i as f64 / (count - usize::from(!closed)) as f64);
        let points: Vec<Point> = (0..count).map(|i| at(i).0).collect();
        let directions: Vec<Vector> = (0..count).map(|i| at(i).1.normalize()).collect();
        State::new(points, directions.clone(), directions, closed)
    }

    fn helix(pitch: f64) -> impl Fn(f64) -> (Point, Vector) {
        move |t| {
            let (sine, cosine) = (4.0 * PI * t).sin_cos();
            let point = Point::new(cosine, sine, pitch * t);
            (point, Vector::new(-4.0 * PI * sine, 4.0 * PI * cosine, pitch))
        }
    }

    #[test]
    fn frames_of_a_helix_turn_back_by_its_torsion() {
        // Against the principal normal a rotation-minimising frame turns by -∫ τ ds, τ = h / (1 + h²) with pitch 2πh.
        let pitch = 3.0;
        let h = pitch / (4.0 * PI);
        let expected = -h / (1.0 + h * h) * 4.0 * PI * (1.0 + h * h).sqrt();
        let mut errors = Vec::new();
        for count in [41, 81, 161] {
            let line = state(helix(pitch), count, false);
            let frames = Frames::of(&line, false, None);
            let normal = |i: usize| Vector::new(-line.points[i].x, -line.points[i].y, 0.0);
            let at = |i: usize| angle(&normal(i), &frames.leaving[i], &line.leave[i]);
            let found = at(count - 1) - at(0);
            let off = (found - expected) / TAU;
            errors.push(((off - off.round()) * TAU).abs());
        }
        assert!(errors[0] < 1e-3, "{errors:?}");
        let order = (errors[0] / errors[2]).log2() / 2.0;
        assert!(order > 3.7, "of fourth order: {order} from {errors:?}");
    }

    #[test]
    fn closed_lines_meet_their_start_and_spread_what_is_missing() {
        // A ring that leaves its plane.
        let of = |t: f64| {
            let a = TAU * t;
            let point = Point::new(a.cos(), a.sin(), 0.5 * (2.0 * a).sin() + 0.3 * (3.0 * a).cos());
            (point, Vector::new(-a.sin(), a.cos(), (2.0 * a).cos() - 0.9 * (3.0 * a).sin()))
        };
        let line = state(of, 200, true);
        let frames = Frames::of(&line, true, None);
        assert!(frames.twist.abs() > 1e-2, "a case that needs it: {}", frames.twist);
        let step = |i: usize| {
            let next = (i + 1) % 200;
            let ends = [&line.points[i], &line.points[next]];
            let carried = reflected_twice(&frames.leaving[i], ends, &line.leave[i], &line.arrive[next]);
            angle(&carried, &frames.leaving[next], &line.leave[next])
        };
        let whole = line.lengths[200];
        for i in 0..200 {
            let share = (line.lengths[i + 1] - line.lengths[i]) / whole * frames.twist;
            assert!((step(i) - share).abs() < 1e-9, "{i}: {} against {share}", step(i));
        }
    }

    #[test]
    fn frames_stay_with_those_before() {
        // A line that swings about: what turns as it does is nowhere far from what it was a moment ago.
        let swung = |time: f64| {
            move |t: f64| {
                let a = 3.0 * t;
                let point = Point::new(t + 0.2 * (time + a).sin(), (time * 0.9 + a).cos(), (time + t).sin());
                let along = Vector::new(
                    1.0 + 0.6 * (time + a).cos(),
                    -3.0 * (time * 0.9 + a).sin(),
                    (time + t).cos(),
                );
                (point, along)
            }
        };
        let mut before = state(swung(0.0), 60, false);
        let mut frames = Frames::of(&before, false, None);
        for k in 1..400 {
            let next = state(swung(f64::from(k) * 0.02), 60, false);
            let found = Frames::of(&next, false, Some((&before, &frames)));
            let worst = (0..60)
                .map(|i| {
                    let carried = turned(&frames.leaving[i], &before.leave[i], &next.leave[i]);
                    angle(&carried, &found.leaving[i], &next.leave[i]).abs()
                })
                .fold(0.0, f64::max);
            assert!(worst < 0.1, "a jump of {worst} at frame {k}");
            (before, frames) = (next, found);
        }
    }

    #[test]
    fn reversals_and_points_without_way_have_frames() {
        let x = Vector::x();
        for to in [-x, x, Vector::new(-1.0, 1e-9, 0.0).normalize(), Vector::y()] {
            let r = turned(&Vector::y(), &x, &to);
            assert!(r.dot(&to).abs() < 1e-12 && (r.norm() - 1.0).abs() < 1e-12, "{to}: {r}");
        }
        let p = Point::new(1.0, 2.0, 3.0);
        let r = reflected_twice(&Vector::y(), [&p, &p], &x, &Vector::z());
        assert!(r.dot(&Vector::z()).abs() < 1e-12 && (r.norm() - 1.0).abs() < 1e-12);
    }
}
