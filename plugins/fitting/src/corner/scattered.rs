//! Corners of points that scatter: where two curves, each near the points of one side, meet at an angle.
//!
//! The turn from point to point says nothing there. On either side of a place a parabola is fitted to the points normal to where they go, by as many of them as
//! the scatter asks for: the standard error of a parabola's slope at the end of `m` points a distance `h` apart, each off by `σ`, is
//! `σ/h · √(192/m³)` (Draper and Smith, 1998, section 1.4, for orthogonal polynomials; 192 is its limit for many points). A corner is where the two tangents make more than
//! the angle while what both leave over is scatter and no more (a ratio of variances, F). Round a bend that is no corner either the tangents agree or
//! the parabolas do not follow, or one cubic follows as well. Of neighbouring places the one with the largest turn is looked at, and the point moved to where the two curves leave least.

use loftsman_kernel::Vector;
use nalgebra::{Matrix3, Matrix4, Matrix4x3, Vector4};

/// The points turn at random by so much (the standard error of a slope from point to point), before scatter counts: 1.7°.
const SEEN: f64 = 0.03;
/// A tolerance of so many standard deviations is what points that scatter are fitted to, those of each direction by themselves; what is larger is their shape.
const MEANT: f64 = 2.0;
/// The standard error of a tangent that is aimed at: 7°.
const SLOPE: f64 = 0.12;
/// As many points a side give that, times `(σ / (h · SLOPE))^(2/3)`.
const POINTS: f64 = 5.77;
/// The fewest points beside a place,
const FEWEST: usize = 5;
/// and the most means of points.
const MOST: usize = 24;
/// A second look is at fewer points by this, for corners that lie nearer to each other: its error is twice as large. Where points crowd, the first one
/// is at more by as much, until the turn is known to [`KNOWN`], at most [`GROWN`] times as many.
const NEARER: f64 = 0.63;
const KNOWN: f64 = 0.2;
const GROWN: usize = 6;
/// A turn that is not known to this (17°) says nothing.
const UNKNOWN: f64 = 0.3;
/// A turn is in doubt by so many standard errors.
const DOUBT: f64 = 2.0;
/// From this turn on (115°) a corner and a nose look alike by few points: they are told apart by up to so many times as many.
const SHARP: f64 = 2.0;
const FARTHER: usize = 4;
/// What is left may be larger than the scatter by so many standard deviations of a sum of squares.
const LEFT: f64 = 3.5;
/// The fewest points on either side of one in the estimate of the scatter, and places looked at.
const LOCAL: usize = 3;
/// Points that leave their plane by less than this part of their scatter scatter within it.
const FLAT: f64 = 0.1;
/// Scatter is told from where points go over so many times its own size.
const LONG: f64 = 10.0;
const SAMPLES: usize = 2000;
/// One curve for two may leave so many squares of scatter more: with a law of χ² for the two coefficients that it lacks in each of two directions, once in 16.
const WORSE: f64 = 9.0;
/// Times that a curve is weighed by the one before.
const WEIGHED: usize = 6;
/// Chords for its distances.
const CHORDS: u32 = 48;
/// Times that a corner is moved.
const MOVED: usize = 8;

/// What points that scatter tell of corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// The standard deviation of the points from smooth curves, each normal to where these go.
    pub deviation: f64,
    /// How many points on a side a corner is judged by.
    pub points: usize,
    /// Where it is doubtful whether there is a corner.
    pub doubtful: Vec<Doubt>,
}

/// A place where scatter leaves in doubt whether there is a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// The point.
    pub point: usize,
    /// The angle by which the curves beside it turn, in radians,
    pub turn: f64,
    /// and twice its standard error.
    pub give: f64,
    /// Whether it was taken for a corner.
    pub taken: bool,
}

/// The corners beyond the angle `least`, ascending, where points scatter visibly and the tolerance is meant for it; else none: `O(n)`.
pub(super) fn find(
    points: &[Vector],
    closed: bool,
    tolerance: f64,
    least: f64,
) -> Option<(Vec<usize>, Scatter)> {
    let whole = Chain { points, closed };
    let (deviation, apart) = whole.scatter()?;
    if deviation < SEEN * apart || MEANT * deviation > tolerance * whole.directions(deviation).sqrt() {
        return None;
    }
    let wanted = (POINTS * (deviation / (SLOPE * apart)).powf(2.0 / 3.0)).ceil();
    let arm = (wanted as usize).max(FEWEST);
    if points.len() < 4 * arm {
        return None;
    }
    // Means of `each` points scatter less by √each and are farther apart: as many a side do as if each counted.
    let each = arm.div_ceil(MOST);
    let means: Vec<Vector> = points
        .chunks_exact(each)
        .map(|chunk| chunk.iter().fold(Vector::zeros(), |sum, p| sum + p) / each as f64)
        .collect();
    let chain = Chain { points: if each == 1 { points } else { &means }, closed };
    let given = deviation / (each as f64).sqrt();
    let full = arm.div_ceil(each);
    let mut found: Vec<Doubt> = Vec::new();
    for look in [Look::First, Look::Nearer] {
        let seen = |k: usize| chain.seen(k, full, given, least, look);
        let mut turns: Vec<(usize, usize, Bend)> =
            (0..chain.points.len()).filter_map(|k| seen(k).map(|(arm, bend)| (k, arm, bend))).collect();
        turns.sort_by(|a, b| b.2.turn.total_cmp(&a.2.turn));
        for (k, arm, bend) in turns {
            let reach = arm * each;
            let place = whole.moved(k * each + each / 2, reach);
            if !found.iter().any(|other| whole.steps(other.point, place) <= reach) {
                let (turn, give) = (bend.turn, DOUBT * bend.error * given);
                found.push(Doubt { point: place, turn, give, taken: turn > least });
            }
        }
    }
    found.sort_by_key(|doubt| doubt.point);
    let corners = found.iter().filter(|doubt| doubt.taken).map(|doubt| doubt.point).collect();
    let doubtful = found.into_iter().filter(|doubt| (doubt.turn - least).abs() < doubt.give).collect();
    Some((corners, Scatter { deviation, points: arm, doubtful }))
}

#[derive(Debug, Clone, Copy)]
struct Chain<'a> {
    points: &'a [Vector],
    closed: bool,
}

/// Over how many points a place is looked at.
#[derive(Debug, Clone, Copy)]
enum Look {
    First,
    Nearer,
}

/// How the curves on both sides of a place meet.
#[derive(Debug, Clone, Copy)]
struct Bend {
    turn: f64,
    /// The standard error of the turn, for points that are off by 1.
    error: f64,
    /// The sum of squares that both leave, and its degrees of freedom.
    left: f64,
    freedom: f64,
}

impl Bend {
    fn fits(&self, deviation: f64) -> bool {
        follows(self.left, deviation, self.freedom)
    }
}

/// Whether a sum of squares is no more than scatter leaves, by a normal law for χ².
fn follows(left: f64, deviation: f64, freedom: f64) -> bool {
    left <= deviation * deviation * freedom * (1.0 + LEFT * (2.0 / freedom).sqrt())
}

impl Chain<'_> {
    fn at(&self, k: isize) -> Vector {
        self.points[k.rem_euclid(self.points.len() as isize) as usize]
    }

    /// How many points there are to each side of one, up to `most`.
    fn room(&self, k: usize, most: usize) -> [usize; 2] {
        if self.closed { [most; 2] } else { [k.min(most), (self.points.len() - 1 - k).min(most)] }
    }

    /// How many steps two points are apart.
    fn steps(&self, a: usize, b: usize) -> usize {
        let apart = a.abs_diff(b);
        if self.closed { apart.min(self.points.len() - apart) } else { apart }
    }

    /// The points from one to another, both included.
    fn run(&self, from: isize, to: isize) -> impl DoubleEndedIterator<Item = Vector> + Clone + '_ {
        (from..=to).map(|k| self.at(k))
    }

    /// The standard deviation of the points from curves, and how far they are apart: medians, which corners do not change.
    fn scatter(&self) -> Option<(f64, f64)> {
        let n = self.points.len();
        let mut beside = LOCAL;
        loop {
            if n < 8 * beside {
                return None;
            }
            let (range, reach) = (if self.closed { 0..n } else { beside..n - beside }, beside as isize);
            let (mut off, mut way): (Vec<f64>, Vec<f64>) = range
                .step_by(n.div_ceil(SAMPLES).max(beside / LOCAL))
                .filter_map(|k| {
                    let k = k as isize;
                    let side = Side::of(self.run(k - reach, k + reach), 2 * beside + 1)?;
                    Some((side.left / side.freedom, side.length))
                })
                .unzip();
            let median = |all: &mut Vec<f64>| {
                all.sort_by(f64::total_cmp);
                all.get(all.len() / 2).copied().filter(|x| x.is_finite())
            };
            // The median of χ² as a share of its mean (Wilson and Hilferty, 1931).
            let middle = (1.0 - 2.0 / (9.0 * (2 * beside - 2) as f64)).powi(3);
            let (deviation, way) = ((median(&mut off)? / middle).sqrt(), median(&mut way)?);
            if way > LONG * deviation {
                return Some((deviation, way / (2 * beside + 1) as f64));
            }
            beside *= 2;
        }
    }

    /// In how many directions, of those normal to where they go, the points scatter by so much in all: in one where they lie in a plane, else in two.
    fn directions(&self, deviation: f64) -> f64 {
        let n = self.points.len() as f64;
        let middle = self.points.iter().fold(Vector::zeros(), |sum, p| sum + p / n);
        let spread = self.points.iter().fold(Matrix3::zeros(), |sum, p| {
            let from = (p - middle) / deviation;
            sum + from * from.transpose() / n
        });
        if spread.symmetric_eigenvalues().min() > FLAT * FLAT { 2.0 } else { 1.0 }
    }

    /// How the curves beside a place meet, and with how many points on a side, where that may be a corner.
    fn seen(&self, k: usize, full: usize, deviation: f64, least: f64, look: Look) -> Option<(usize, Bend)> {
        let mut arm = full;
        loop {
            let bend = self.bend(k, arm, least)?;
            let known = bend.error * deviation;
            if known > KNOWN && arm < GROWN * full {
                arm = (arm as f64 / NEARER).ceil() as usize;
                continue;
            }
            return match look {
                Look::First => {
                    let may_be =
                        known <= UNKNOWN && bend.fits(deviation) && bend.turn > least - DOUBT * known;
                    if !may_be {
                        None
                    } else if !self.is_smooth(k, arm, deviation, bend.left) {
                        Some((arm, bend))
                    } else {
                        self.decided(k, arm, deviation, least)
                    }
                }
                // It is asked where the first one sees that it is no curve beside another, and has to be sure.
                Look::Nearer if bend.fits(deviation) => None,
                Look::Nearer => {
                    let arm = ((NEARER * arm as f64).ceil() as usize).max(FEWEST - 1);
                    let bend = self.bend(k, arm, least)?;
                    let known = bend.error * deviation;
                    (known <= UNKNOWN
                        && bend.fits(deviation)
                        && bend.turn > least + DOUBT * known
                        && !self.is_smooth(k, arm, deviation, bend.left))
                    .then_some((arm, bend))
                }
            };
        }
    }

    /// The bend over more points, where those beside a sharp turn are followed as well by one narrow curve: what tells a corner from a nose is how far the ways run on.
    /// As soon as two curves follow and one does not any more; none where there are no more points.
    fn decided(&self, k: usize, arm: usize, deviation: f64, least: f64) -> Option<(usize, Bend)> {
        let mut more = arm;
        loop {
            more = (more as f64 / NEARER).ceil() as usize;
            if more > FARTHER * arm || self.room(k, more) != [more; 2] {
                return None;
            }
            let bend = self.bend(k, more, least)?;
            let two = bend.turn > SHARP && bend.fits(deviation);
            if two && !self.is_smooth(k, more, deviation, bend.left) {
                return Some((arm, bend));
            }
        }
    }

    /// How the curves beside a place meet; none where it lies too near an end, or the points go on as before.
    fn bend(&self, k: usize, arm: usize, least: f64) -> Option<Bend> {
        let [a, b] = self.room(k, arm);
        if a + 1 < FEWEST || b + 1 < FEWEST {
            return None;
        }
        let (here, k) = (self.at(k as isize), k as isize);
        let before = self.run(k - a as isize, k);
        let after = self.run(k, k + b as isize);
        let rough = way(before.clone(), a + 1).angle(&way(after.clone(), b + 1));
        if rough.is_nan() || rough < least / 3.0 {
            return None;
        }
        let (before, after) = (Side::of(before, a + 1)?, Side::of(after, b + 1)?);
        let [s, t] = [before.tangent(here), after.tangent(here)];
        Some(Bend {
            turn: s.0.angle(&t.0),
            error: s.1.hypot(t.1),
            left: before.left + after.left,
            freedom: before.freedom + after.freedom,
        })
    }

    /// Whether one cubic, over the line between the two ways, follows the points around a place as well as the two parabolas, which leave `left`, by what scatter tells
    /// (a ratio of likelihoods): a nose looks like two parabolas as well.
    fn is_smooth(&self, k: usize, arm: usize, deviation: f64, left: f64) -> bool {
        let [a, b] = self.room(k, arm).map(|room| room as isize);
        let (here, k) = (self.at(k as isize), k as isize);
        let ways = [way(self.run(k - a, k), a as usize + 1), way(self.run(k, k + b), b as usize + 1)];
        let along = (ways[0].normalize() + ways[1].normalize()).normalize();
        let all = self.run(k - a, k + b);
        let long = all.clone().map(|p| (p - here).dot(&along).abs()).fold(0.0, f64::max);
        let parts = all.map(|p| {
            let from = p - here;
            let x = from.dot(&along);
            (x / long, (from - along * x) / long)
        });
        let mut curve = Matrix4x3::zeros();
        for _ in 0..WEIGHED {
            // Where it is steep a distance normal to it is less than one across: weights by the curve before.
            let (mut square, mut right) = (Matrix4::zeros(), Matrix4x3::zeros());
            for (x, off) in parts.clone() {
                let powers = Vector4::new(1.0, x, x * x, x * x * x);
                let steep = curve.transpose() * Vector4::new(0.0, 1.0, 2.0 * x, 3.0 * x * x);
                let weight = 1.0 / (1.0 + steep.norm_squared());
                square += powers * powers.transpose() * weight;
                right += powers * off.transpose() * weight;
            }
            let Some(solved) = square.cholesky() else { return false };
            curve = solved.solve(&right);
            // By distances from chords: what is across a steep piece of it says nothing of a point that is far from it.
            let at = |i: u32| {
                let x = 2.0 * f64::from(i) / f64::from(CHORDS) - 1.0;
                (x, curve.transpose() * Vector4::new(1.0, x, x * x, x * x * x))
            };
            let chords: Vec<(f64, Vector)> = (0..=CHORDS).map(at).collect();
            let off = |(x, off): (f64, Vector)| {
                let from = |pair: &[(f64, Vector)]| {
                    let (step, rise) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                    let (own, up) = (x - pair[0].0, off - pair[0].1);
                    let t = (own * step + up.dot(&rise)) / (step * step + rise.norm_squared());
                    let t = t.clamp(0.0, 1.0);
                    (own - step * t).powi(2) + (up - rise * t).norm_squared()
                };
                chords.windows(2).map(from).fold(f64::INFINITY, f64::min)
            };
            let once = parts.clone().map(off).sum::<f64>() * long * long;
            if once <= left + WORSE * deviation * deviation {
                return true;
            }
        }
        false
    }

    /// The point near one at which the curves on both sides leave least, each summed up to there: until it stays. `O(arm)` a time.
    fn moved(&self, from: usize, arm: usize) -> usize {
        let mut place = from.min(self.points.len() - 1);
        for _ in 0..MOVED {
            let [a, b] = self.room(place, arm).map(|room| room as isize);
            let (start, k, end) = (place as isize - a, place as isize, place as isize + b);
            let sides =
                Side::of(self.run(start, k), a as usize + 1).zip(Side::of(self.run(k, end), b as usize + 1));
            let Some((before, after)) = sides else { break };
            // Everything by the curve behind it, then one point after another goes over to the one before it; the corner counts with both.
            let mut sum: f64 = self.run(start, end).map(|p| after.off(p)).sum();
            let mut best = (f64::INFINITY, k);
            for j in start..=end {
                let [own, other] = [before.off(self.at(j)), after.off(self.at(j))];
                let both = sum + own;
                if (start + a / 2..=end - b / 2).contains(&j) && both < best.0 {
                    best = (both, j);
                }
                sum += own - other;
            }
            let next = best.1.rem_euclid(self.points.len() as isize) as usize;
            if next == place {
                break;
            }
            place = next;
        }
        place
    }
}

/// Where a run of points goes: from the mean of its first half to that of the other.
fn way(points: impl DoubleEndedIterator<Item = Vector> + Clone, count: usize) -> Vector {
    let half = count / 2;
    let sum = |all: &mut dyn Iterator<Item = Vector>| all.fold(Vector::zeros(), |sum, p| sum + p);
    sum(&mut points.clone().rev().take(half)) - sum(&mut points.take(half))
}

/// A parabola near a run of points: what is normal to the way they go, against how far they are along it.
#[derive(Debug, Clone, Copy)]
struct Side {
    along: Vector,
    middle: Vector,
    /// Coefficients of the orthogonal polynomials `x` and `(x - shift) x - mean`, and these polynomials' squares summed.
    slope: Vector,
    bend: Vector,
    shift: f64,
    mean: f64,
    squares: [f64; 2],
    left: f64,
    freedom: f64,
    length: f64,
}

impl Side {
    fn of(points: impl DoubleEndedIterator<Item = Vector> + Clone, count: usize) -> Option<Self> {
        let along = way(points.clone(), count);
        let long = along.norm();
        let along = along / long;
        let many = count as f64;
        let middle = points.clone().fold(Vector::zeros(), |sum, p| sum + p) / many;
        let parts = points.map(|p| {
            let from = p - middle;
            let x = from.dot(&along);
            (x, from - along * x)
        });
        let (mut second, mut third, mut slope) = (0.0, 0.0, Vector::zeros());
        for (x, off) in parts.clone() {
            second += x * x;
            third += x * x * x;
            slope += off * x;
        }
        let (shift, mean) = (third / second, second / many);
        let slope = slope / second;
        let (mut fourth, mut bend) = (0.0, Vector::zeros());
        for (x, off) in parts.clone() {
            let q = (x - shift) * x - mean;
            fourth += q * q;
            bend += off * q;
        }
        let bend = bend / fourth;
        let left =
            parts.map(|(x, off)| (off - slope * x - bend * ((x - shift) * x - mean)).norm_squared()).sum();
        let side = Self {
            along,
            middle,
            slope,
            bend,
            shift,
            mean,
            squares: [second, fourth],
            left,
            freedom: many - 3.0,
            // The middles of its halves are half of it apart.
            length: 2.0 * long / (count / 2) as f64,
        };
        // Points on one another go nowhere.
        (side.left.is_finite() && slope.norm().is_finite() && bend.norm().is_finite()).then_some(side)
    }

    /// The direction beside a point, and its standard error for points that are off by 1.
    fn tangent(&self, here: Vector) -> (Vector, f64) {
        let x = (here - self.middle).dot(&self.along);
        let steep = 2.0 * x - self.shift;
        let error = (1.0 / self.squares[0] + steep * steep / self.squares[1]).sqrt();
        (self.along + self.slope + self.bend * steep, error)
    }

    /// The square of a point's distance from the parabola, normal to the way.
    fn off(&self, point: Vector) -> f64 {
        let from = point - self.middle;
        let x = from.dot(&self.along);
        (from - self.along * x - self.slope * x - self.bend * ((x - self.shift) * x - self.mean))
            .norm_squared()
    }
}
