//! Corners in a chain of points: where a smooth curve cannot follow, and a fit is divided.

mod scattered;

use loftsman_kernel::Vector;

pub use self::scattered::{Doubt, Scatter};

/// The turn beyond which [`Corners::Auto`] takes a point for a corner: 60°.
const SHARP: f64 = std::f64::consts::FRAC_PI_3;
/// For [`Corners::Auto`] the points must turn as sharply over so many tolerances on both sides: noise does not.
const ARM: f64 = 6.0;
/// A turn that noise does not make beside a corner: 10°.
const FLANK: f64 = std::f64::consts::PI / 18.0;
/// What is behind a flank counts up to so many times the flank.
const BEHIND: f64 = 2.0;
/// Two turns so many tolerances apart may be one corner that lies between them.
const PAIR: f64 = 3.0;
/// Places nearer to each other than this share of the points' size are one place.
const SAME: f64 = 1e-9;

/// Where a fitted curve has corners.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Corners {
    /// Nowhere: the curve is smooth.
    #[default]
    None,
    /// At points where the polygon of the points turns by more than this angle, in radians, unless it is round there.
    Angle(f64),
    /// As for an angle of 60°, where the points turn as sharply over six tolerances to both sides, too. Where points scatter, by less than the tolerance allows, two
    /// curves that are fitted to the points on either side have to make that angle: [`Scatter`].
    Auto,
}

impl Corners {
    /// The corners of a chain of points, ascending; of an open chain never the ends. `tolerance`: what distance does
    /// not matter.
    ///
    /// The points of a round nose turn sharply as well, but the turn is shared: it goes on, in the same sense, at the
    /// points before and after, and *falls off* from point to point. A run of sharp turns is round where on both of its
    /// sides the next turn (the flank) has the same sense, and
    /// * it is at least half the run's last turn (its edge); or an eighth of it, and 1.5 times the turn behind it or
    ///   with that one 0.55 of the edge; or a fifth of it, where the edge is less than 0.6 of the run's sharpest turn;
    ///   or (a nose of three points) 10° and 6 % of it, and 2.5 times the turn behind it;
    /// * or the flanks and the turns behind them make up 1.1 times their edges, and a quarter of it on either side.
    ///
    /// The corner of a polygon, whose sides are straight or evenly curved, has no such flanks. `O(n)`.
    pub(crate) fn find(
        self,
        points: &[Vector],
        closed: bool,
        tolerance: f64,
    ) -> (Vec<usize>, Option<Scatter>) {
        if self == Self::Auto
            && let Some((corners, scatter)) = scattered::find(points, closed, tolerance, SHARP)
        {
            return (corners, Some(scatter));
        }
        (self.turned(points, closed, tolerance), None)
    }

    /// The corners by the turns from point to point.
    fn turned(self, points: &[Vector], closed: bool, tolerance: f64) -> Vec<usize> {
        let least = match self {
            Self::None => return Vec::new(),
            Self::Angle(angle) => angle,
            Self::Auto => SHARP,
        };
        let size = points.iter().fold(0.0_f64, |m, p| m.max((p - points[0]).amax()));
        let least_apart = tolerance.max(SAME * size);
        let mut chain = places(points, closed, least_apart);
        if self == Self::Auto {
            chain = paired(points, chain, closed, PAIR * least_apart, least);
        }
        let n = chain.len();
        if n < 3 {
            return Vec::new();
        }
        let at = |j: usize| points[chain[j % n]];
        // Turns as angles, and the axes they turn about; the ends of an open chain do not turn.
        let turns: Vec<Turn> = (0..n)
            .map(|j| {
                if !closed && (j == 0 || j + 1 == n) {
                    Turn::none()
                } else {
                    Turn::at(at(j + n - 1), at(j), at(j + 1))
                }
            })
            .collect();
        let turn = |j: isize| {
            let inside = closed || (j >= 0 && (j as usize) < n);
            if inside { turns[j.rem_euclid(n as isize) as usize] } else { Turn::none() }
        };
        let mut corners = Vec::new();
        for j in 0..n as isize {
            if turn(j).angle <= least || round(&turn, j, least, n) {
                continue;
            }
            if self == Self::Auto && self.blunt(&at, j as usize, n, closed, ARM * tolerance, least) {
                continue;
            }
            let (before, after) = (at(j as usize + n - 1), at(j as usize + 1));
            corners.push(apex(points, chain[j as usize], closed, least_apart, before, after));
        }
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// Whether the points turn by less than `least` where they are looked at from `arm` away.
    fn blunt(
        self,
        at: &impl Fn(usize) -> Vector,
        j: usize,
        n: usize,
        closed: bool,
        arm: f64,
        least: f64,
    ) -> bool {
        let here = at(j);
        let walk = |back: bool| {
            let most = if closed {
                n / 2
            } else if back {
                j
            } else {
                n - 1 - j
            };
            let place = |i: usize| at(if back { j + n - i } else { j + i });
            let far = (1..=most).find(|&i| (place(i) - here).norm() >= arm);
            place(far.unwrap_or(most))
        };
        Turn::at(walk(true), here, walk(false)).angle <= least
    }
}

/// The turn of a chain at a place: its angle and axis.
#[derive(Debug, Clone, Copy)]
struct Turn {
    angle: f64,
    axis: Vector,
}

impl Turn {
    fn none() -> Self {
        Self { angle: 0.0, axis: Vector::zeros() }
    }

    fn at(before: Vector, here: Vector, after: Vector) -> Self {
        let (a, b) = ((here - before).normalize(), (after - here).normalize());
        let axis = a.cross(&b);
        let angle = axis.norm().atan2(a.dot(&b));
        if angle.is_finite() { Self { angle, axis } } else { Self::none() }
    }

    /// Its angle where it turns the same way as the other, else 0.
    fn with(&self, other: &Self) -> f64 {
        if self.axis.dot(&other.axis) > 0.0 { self.angle } else { 0.0 }
    }
}

/// Whether the run of sharp turns around place `j` falls off on both sides.
fn round(turn: &impl Fn(isize) -> Turn, j: isize, least: f64, n: usize) -> bool {
    let Some((left, right)) = side(turn, j, least, n, -1).zip(side(turn, j, least, n, 1)) else {
        return false;
    };
    let peak = left.peak.max(right.peak);
    let falls = |&Side { edge, flank, behind, .. }: &Side| {
        flank >= 0.5 * edge
            || (flank >= 0.125 * edge && (flank >= 1.5 * behind || flank + behind >= 0.55 * edge))
            || (flank >= 0.2 * edge && edge <= 0.6 * peak)
            || (flank >= (0.06 * edge).max(FLANK) && flank >= 2.5 * behind)
    };
    // With noise one side may look steeper than it is.
    let shares = [&left, &right].map(|s| (s.flank + s.behind) / s.edge);
    (falls(&left) && falls(&right)) || (shares[0] + shares[1] >= 1.1 && shares[0].min(shares[1]) >= 0.25)
}

/// One side of a run of sharp turns: its last turn, the two beyond it as far as they have its sense, and the sharpest.
#[derive(Debug)]
struct Side {
    edge: f64,
    flank: f64,
    behind: f64,
    peak: f64,
}

/// The side of the run around place `j` in the direction of `step`; none where the run goes all around.
fn side(turn: &impl Fn(isize) -> Turn, j: isize, least: f64, n: usize, step: isize) -> Option<Side> {
    let (mut last, mut peak) = (j, 0.0_f64);
    for _ in 0..n {
        let (here, next) = (turn(last), turn(last + step));
        let flank = next.with(&here);
        peak = peak.max(here.angle);
        if flank <= least {
            let behind = turn(last + 2 * step).with(&next);
            // What turns as sharply behind a flank is the next corner, and no turn that falls off: between two corners a flank is whatever rounding left of it. So
            // is what turns far more than the flank does.
            let most = if behind > least { flank } else { BEHIND * flank };
            let behind = behind.min(most);
            return Some(Side { edge: here.angle, flank, behind, peak });
        }
        last += step;
    }
    None
}

/// Of the points that are one place with `here`, which follow it (in a closed chain lie before it, too, where that is its first), the one at which the
/// corner is: the farthest from the chord between the places before and after. A curve through another one would have to turn twice.
fn apex(points: &[Vector], here: usize, closed: bool, least: f64, before: Vector, after: Vector) -> usize {
    let near = |k: &usize| (points[*k] - points[here]).norm() <= least;
    let behind = (here + 1..points.len()).take_while(near);
    let ahead = (here + 1..points.len()).rev().take_while(|k| closed && here == 0 && near(k));
    let along = (after - before).normalize();
    let off = |k: usize| {
        let from = points[k] - before;
        let off = (from - along * along.dot(&from)).norm();
        // Where the points run back on themselves there is no chord.
        if off.is_finite() { off } else { from.norm() }
    };
    // Of equals the first.
    behind.chain(ahead).fold(here, |best, k| if off(k) > off(best) { k } else { best })
}

/// The places with one for two where a corner lies between them: they turn the same way within `near` of each other, none of them by more than `least` and
/// both together by more. The point for both is the one that is farthest from the chord between the places beside them, of those from the first
/// to the last that is one place with the second: where points crowd at a corner, the corner may be within the tolerance of a place before it, and be left out.
fn paired(points: &[Vector], chain: Vec<usize>, closed: bool, near: f64, least: f64) -> Vec<usize> {
    let n = chain.len();
    if n < 5 {
        return chain;
    }
    let at = |j: usize| points[chain[j % n]];
    let turn = |j: usize| {
        let end = !closed && (j == 0 || j + 1 >= n);
        if end { Turn::none() } else { Turn::at(at(j + n - 1), at(j), at(j + 1)) }
    };
    let mut kept = Vec::with_capacity(n);
    let mut j = 0;
    while j < n {
        let next = j + 1;
        let pair = next < n && (at(next) - at(j)).norm() <= near && {
            let (a, b) = (turn(j), turn(next));
            let both = a.angle + b.with(&a);
            a.angle.max(b.angle) <= least && b.with(&a) > 0.0 && both > least
        };
        if !pair {
            kept.push(chain[j]);
            j += 1;
            continue;
        }
        let (before, after) = (at(j + n - 1), at(j + 2));
        let along = (after - before).normalize();
        let off = |k: usize| {
            let from = points[k] - before;
            (from - along * along.dot(&from)).norm()
        };
        let last = if j + 2 < n { chain[j + 2] } else { points.len() };
        let best = (chain[j]..last).fold(chain[j], |best, k| if off(k) > off(best) { k } else { best });
        kept.push(best);
        j += 2;
    }
    kept
}

/// The points without those within `least` of the one before; of an open chain the last one stays.
fn places(points: &[Vector], closed: bool, least: f64) -> Vec<usize> {
    let far = |a: usize, b: usize| (points[a] - points[b]).norm() > least;
    let mut chain: Vec<usize> = Vec::with_capacity(points.len());
    for k in 0..points.len() {
        if chain.last().is_none_or(|&before| far(before, k)) {
            chain.push(k);
        }
    }
    let last = points.len() - 1;
    if closed {
        while chain.len() > 1 && !far(chain[0], chain[chain.len() - 1]) {
            chain.pop();
        }
    } else if chain.last() != Some(&last) {
        if chain.len() > 1 {
            chain.pop();
        }
        chain.push(last);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[(f64, f64)], each: usize) -> Vec<Vector> {
        let at = |i: usize| Vector::new(corners[i % corners.len()].0, corners[i % corners.len()].1, 0.0);
        (0..corners.len() * each)
            .map(|k| at(k / each).lerp(&at(k / each + 1), (k % each) as f64 / each as f64))
            .collect()
    }

    #[test]
    fn polygons_have_their_corners() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        for way in [Corners::Angle(0.7), Corners::Auto] {
            assert_eq!(way.turned(&polygon(&square, 1), true, 1e-4), [0, 1, 2, 3]);
            assert_eq!(way.turned(&polygon(&square, 7), true, 1e-4), [0, 7, 14, 21]);
            assert_eq!(way.turned(&polygon(&square, 7), false, 1e-4), [7, 14, 21]);
        }
        assert!(Corners::Angle(1.6).turned(&polygon(&square, 7), true, 1e-4).is_empty());
        assert!(Corners::None.turned(&polygon(&square, 7), true, 1e-4).is_empty());
    }

    /// Sides of one point between corners are straight to rounding, or to what an outline is printed with, and turn one way or the other by that.
    #[test]
    fn corners_with_one_point_between_them_are_corners() {
        for (sides, off) in
            [(3, 0.0), (3, 1e-9), (3, 1e-5), (3, 1e-3), (4, 1e-9), (4, 1e-3), (5, 1e-9), (5, 1e-3)]
        {
            for sense in [1.0, -1.0] {
                let corner = |i: usize| {
                    let a = std::f64::consts::TAU * i as f64 / sides as f64;
                    Vector::new(a.cos(), a.sin(), 0.0)
                };
                let ring: Vec<Vector> = (0..2 * sides)
                    .map(|k| match k % 2 {
                        0 => corner(k / 2),
                        _ => (corner(k / 2) + corner(k / 2 + 1)) * (0.5 * (1.0 + sense * off)),
                    })
                    .collect();
                let corners: Vec<usize> = (0..sides).map(|k| 2 * k).collect();
                assert_eq!(Corners::Auto.turned(&ring, true, 1e-4), corners, "{sides} {off:e} {sense}");
            }
        }
        // 128° between legs of 1060 and 5970 tolerances, with a point on each side, as a program printed it.
        let outline: Vec<Vector> = [
            (-5938.14526042387, 10161.457581268467),
            (-4676.699536000648, -5926.375051325225),
            (-4646.742928192168, -6308.36981332745),
            (8942.439781744677, -1756.605410630642),
            (12261.78361605135, -644.3615219895319),
            (-4222.989536363662, 10160.505614545315),
            (-6031.013558400202, 11345.318824151644),
        ]
        .map(|(x, y)| Vector::new(x, y, 0.0))
        .to_vec();
        assert_eq!(Corners::Auto.turned(&outline, true, 3.293), [2, 4, 6]);
    }

    /// Three corners one after another, with a point between them or none: what turns behind a flank of rounding is no share of this one's turn.
    #[test]
    fn a_flank_of_rounding_has_nothing_behind_it() {
        // Turns in degrees with the legs before them, of closed outlines that a program sampled at random: (turn, leg behind it).
        let chains: [(&[(f64, f64)], usize); 3] = [
            (
                &[
                    (0.0, 368.0),
                    (0.1, 32.0),
                    (53.4, 895.0),
                    (0.0, 792.0),
                    (78.8, 123.0),
                    (0.0, 1231.0),
                    (39.6, 277.0),
                    (0.0, 295.0),
                ],
                4,
            ),
            (
                &[
                    (0.0, 400.0),
                    (48.1, 1507.0),
                    (-0.01, 405.0),
                    (43.8, 2418.0),
                    (79.7, 2753.0),
                    (0.02, 415.0),
                    (52.4, 2226.0),
                ],
                4,
            ),
            (
                &[
                    (0.0, 600.0),
                    (44.2, 568.0),
                    (0.0, 1185.0),
                    (57.4, 2273.0),
                    (71.3, 1061.0),
                    (0.0, 706.0),
                    (22.9, 1757.0),
                    (0.0, 500.0),
                ],
                4,
            ),
        ];
        for (chain, corner) in chains {
            let (mut at, mut way) = (Vector::zeros(), 0.0_f64);
            let mut points = vec![Vector::new(-500.0, 0.0, 0.0), at];
            for (k, &(turn, leg)) in chain.iter().enumerate() {
                way += if k == 0 { 0.0 } else { turn.to_radians() };
                at += Vector::new(way.cos(), way.sin(), 0.0) * leg;
                points.push(at);
            }
            let found = Corners::Auto.turned(&points, false, 1.0);
            assert_eq!(found, [corner + 1], "{chain:?}");
        }
    }

    /// Where points crowd at a corner, the corner may be left out for a place before it, and its turn be shared by two: it is one corner all the same, and that
    /// point.
    #[test]
    fn a_corner_that_is_shared_by_two_places_is_one_corner() {
        for (before, turn) in [(0.3, 87.0_f64), (0.7, 87.0), (0.9, 110.0), (0.9, 70.0), (0.5, 66.0)] {
            for mirrored in [false, true] {
                let out = Vector::new(turn.to_radians().cos(), turn.to_radians().sin(), 0.0);
                let mut points: Vec<Vector> =
                    [-400.0, -120.0, -30.0, -7.0, -2.2, -before].map(|x| Vector::new(x, 0.0, 0.0)).to_vec();
                let corner = points.len();
                points.push(Vector::zeros());
                points.extend([0.4, 1.1, 3.0, 9.0, 40.0, 300.0].map(|t| out * t));
                let n = points.len();
                if mirrored {
                    points.reverse();
                }
                let corner = if mirrored { n - 1 - corner } else { corner };
                let found = Corners::Auto.turned(&points, false, 1.0);
                assert_eq!(found.len(), 1, "{before} {turn} {mirrored}: {found:?}");
                let off = (points[found[0]] - points[corner]).norm();
                assert!(off <= 1.0, "{before} {turn} {mirrored}: {found:?}");
            }
        }
    }

    /// A point of a smooth side may be within the tolerance of the corner: the corner is where it is, on whichever side that point lies, wherever the chain begins.
    #[test]
    fn a_corner_beside_a_point_within_the_tolerance_is_the_corner() {
        let right = [(0.0, 0.0), (1.0, 0.05), (2.0, 0.12), (2.68, 0.176), (2.71, 0.1789), (2.714, 0.1793)];
        let down = [(2.714, -13.87), (2.714, -27.9), (2.1, -27.98), (0.0, -28.0), (0.0, -14.0)];
        let outline: Vec<Vector> = right.iter().chain(&down).map(|&(x, y)| Vector::new(x, y, 0.0)).collect();
        let n = outline.len();
        for way in [Corners::Auto, Corners::Angle(0.8)] {
            for mirrored in [false, true] {
                for first in 0..n {
                    let turned: Vec<Vector> =
                        (0..n).map(|k| outline[(if mirrored { 2 * n - k } else { k } + first) % n]).collect();
                    let found = way.turned(&turned, true, 0.005);
                    let places: Vec<Vector> = found.iter().map(|&k| turned[k]).collect();
                    assert!(places.contains(&outline[5]), "{first} {mirrored}: {places:?}");
                    assert!(!places.contains(&outline[4]), "{first} {mirrored}: {places:?}");
                }
            }
        }
        // Points that are one place are one corner: the first of them.
        let square = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], 3);
        let doubled: Vec<Vector> = square.iter().flat_map(|p| [*p, *p]).collect();
        assert_eq!(Corners::Auto.turned(&doubled, true, 1e-4), [0, 6, 12, 18]);
    }

    #[test]
    fn circles_and_noise_below_the_tolerance_have_none() {
        for n in [9_u32, 12, 40] {
            let ring: Vec<Vector> = (0..n)
                .map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(n))
                .map(|a| Vector::new(a.cos(), a.sin(), 0.0))
                .collect();
            assert!(Corners::Auto.turned(&ring, true, 1e-4).is_empty());
        }
        let rough: Vec<Vector> = (0..200_u32)
            .map(|i| Vector::new(f64::from(i) * 1e-3, 1e-3 * f64::from((i * 7919) % 13) / 13.0, 0.0))
            .collect();
        assert!(Corners::Auto.turned(&rough, false, 1e-3).is_empty());
    }
}
