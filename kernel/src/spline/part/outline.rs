//! Which side of loops a place of the parameter plane is on.

use super::tree::{Bounds, Search, Tree};
use crate::spline::ParameterSide;
use crate::spline::closest::Kept;

/// A piece of a loop, as straight as it is taken for.
type Chord = [[f64; 2]; 2];

/// Units in the last place by which a box may be nearer than it looks.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Coordinates that differ by less than this part of the domain are one: a loop along an axis of the parameter plane is met by no line along it, and what
/// rounding tilts would be.
const LEVEL: f64 = 1e-12;

/// The coordinates of lines in a direction, ascending, those within `near` after one left out.
fn alike(lines: &[Vec<[f64; 2]>], direction: usize, near: f64) -> Vec<f64> {
    let mut all: Vec<f64> = lines.iter().flatten().map(|at| at[direction]).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.dedup_by(|next, kept| *next - *kept <= near);
    all
}

/// The last of ascending numbers that is not more than another.
fn leveled(known: &[f64], x: f64) -> f64 {
    let above = known.partition_point(|kept| *kept <= x);
    above.checked_sub(1).map_or(x, |k| known[k])
}

/// Loops as chords in the parameter plane, each run through with the part on its left. Those that go around a closed surface end a
/// period from where they start. A question takes about the logarithm of the number of chords, as long as they are not all in each other's way.
pub(super) struct Outline {
    /// In the order of the loops.
    chords: Vec<Chord>,
    tree: Tree<2>,
    sides: [ParameterSide; 2],
    /// By how much a place is moved to meet loops that run on around the surface, in each direction.
    turns: [Vec<f64>; 2],
    /// There are no loops: all of the surface.
    all: bool,
    /// Whether a place is left from which no loop is met along the axes.
    beyond: bool,
}

impl Outline {
    /// `O(n log n)` for `n` chords. Their ends are moved by 1e-12 of the domain at most, so that what runs along an axis to rounding does.
    pub(super) fn new(lines: &[Vec<[f64; 2]>], sides: [ParameterSide; 2]) -> Self {
        let known = [0, 1].map(|d| alike(lines, d, LEVEL * sides[d].length()));
        let level = |at: [f64; 2]| [0, 1].map(|d: usize| leveled(&known[d], at[d]));
        let chords: Vec<Chord> = lines
            .iter()
            .flat_map(|line| line.windows(2))
            .map(|pair| [level(pair[0]), level(pair[1])])
            .collect();
        let boxes: Vec<Bounds<2>> =
            chords.iter().map(|[a, b]| [0, 1].map(|d: usize| [a[d].min(b[d]), a[d].max(b[d])])).collect();
        let turns = sides.map(|side| {
            let t = side.length();
            if side.closed { vec![-2.0 * t, -t, 0.0, t, 2.0 * t] } else { vec![0.0] }
        });
        Self {
            tree: Tree::new(&boxes),
            chords,
            sides,
            turns,
            all: lines.is_empty(),
            beyond: is_left_beyond(lines),
        }
    }

    pub(super) fn sides(&self) -> &[ParameterSide; 2] {
        &self.sides
    }

    /// Whether a place is inside: the first piece of a loop beside it, in any direction along the axes, has it on its left.
    pub(super) fn has(&self, at: [f64; 2]) -> bool {
        if self.all {
            return true;
        }
        let mut ray = Ray { chords: &self.chords, at, along: 1, turn: [(0, 0.0); 2], nearest: None };
        for along in [1, 0] {
            ray.along = along;
            for across in self.turns[1 - along].iter().copied().enumerate() {
                ray.turn[1 - along] = across;
                for beside in self.turns[along].iter().copied().enumerate() {
                    ray.turn[along] = beside;
                    self.tree.search(&mut ray);
                }
            }
        }
        ray.nearest.map_or(self.beyond, |nearest| nearest.inside)
    }
}

/// Whether what lies beyond all loops is left: where the largest of them is a hole. (Of a surface that closes loops may be holes alone, as that of a ball with a hole;
/// a line that runs round it is met from everywhere.)
fn is_left_beyond(lines: &[Vec<[f64; 2]>]) -> bool {
    let area = |line: &Vec<[f64; 2]>| {
        let Some(from) = line.first() else { return 0.0 };
        let away = |p: &[f64; 2]| [p[0] - from[0], p[1] - from[1]];
        let pairs = line.windows(2).map(|pair| [away(&pair[0]), away(&pair[1])]);
        pairs.map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    };
    lines.iter().map(area).max_by(|a, b| a.abs().total_cmp(&b.abs())).is_some_and(|area| area < 0.0)
}

impl Kept for Outline {
    fn has(&self, at: [f64; 2]) -> bool {
        Self::has(self, at)
    }

    fn share(&self, box_: [(f64, f64); 2]) -> Option<bool> {
        // What lies along a side of the box reaches into it, but for rounding.
        let near = self.sides.map(|side| 1e-9 * side.length());
        let mut reach = Reach { chords: &self.chords, by: [0.0; 2], box_, near, met: false };
        for &u in &self.turns[0] {
            for &v in &self.turns[1] {
                reach.by = [u, v];
                self.tree.search(&mut reach);
                if reach.met {
                    return None;
                }
            }
        }
        Some(Self::has(self, box_.map(|(low, high)| 0.5 * low + 0.5 * high)))
    }
}

/// What is nearest to a place on the line through it along an axis, either way.
struct Ray<'a> {
    chords: &'a [Chord],
    at: [f64; 2],
    along: usize,
    /// Which turn the chords are looked at in, and by how much that moves them.
    turn: [(usize, f64); 2],
    nearest: Option<Met>,
}

/// A chord that was met.
struct Met {
    away: f64,
    /// Where the line touches a corner of a loop it meets both of its chords there. Ends on the line count as before it, so that it is one a little beyond: of
    /// chords that are as near, that counts which is nearer to such a one. So much further is this one, for each step.
    further: f64,
    /// Of those that are as near still the first counts: along `v` before `u`, then by the order of the chords and of the turns.
    rank: (usize, usize, usize, usize),
    inside: bool,
}

impl Search<2> for Ray<'_> {
    fn bound(&self, bounds: &Bounds<2>) -> f64 {
        let of = |d: usize| bounds[d].map(|x| x + self.turn[d].1 - self.at[d]);
        // Rounding never puts sums in another order, so that no chord within lies on both sides where the box does not.
        let [low, high] = of(1 - self.along);
        if (low <= 0.0) == (high <= 0.0) {
            return f64::INFINITY;
        }
        let [low, high] = of(self.along);
        let own = bounds[self.along];
        let size = own[0].abs().max(own[1].abs()) + self.turn[self.along].1.abs() + self.at[self.along].abs();
        low.max(-high).max(0.0) - ROUNDING * size
    }

    fn beyond(&self, bound: f64) -> bool {
        self.nearest.as_ref().is_some_and(|nearest| bound > nearest.away)
    }

    fn look(&mut self, index: usize) {
        let (along, across) = (self.along, 1 - self.along);
        let [a, b] = self.chords[index];
        let [low, high] = [a, b].map(|end| end[across] + self.turn[across].1 - self.at[across]);
        if (low <= 0.0) == (high <= 0.0) {
            return;
        }
        let share = low / (low - high);
        let met = a[along] + (b[along] - a[along]) * share;
        let away = met + self.turn[along].1 - self.at[along];
        // Rising across, the left side of the piece is towards smaller values along u, larger ones along v.
        let rises = high > low;
        let left_is_after = if along == 1 { rises } else { !rises };
        let inside = (away < 0.0) == left_is_after;
        // Adding 0 makes one of both zeros.
        let further = (b[along] - a[along]) / (b[across] - a[across]) * away.signum() + 0.0;
        let rank = (across, index, self.turn[across].0, self.turn[along].0);
        let nearer = |best: &Met| {
            let by = away.abs().total_cmp(&best.away).then(further.total_cmp(&best.further));
            by.then(rank.cmp(&best.rank)).is_lt()
        };
        if self.nearest.as_ref().is_none_or(nearer) {
            self.nearest = Some(Met { away: away.abs(), further, rank, inside });
        }
    }
}

/// Whether anything reaches into a box.
struct Reach<'a> {
    chords: &'a [Chord],
    by: [f64; 2],
    box_: [(f64, f64); 2],
    near: [f64; 2],
    met: bool,
}

impl Search<2> for Reach<'_> {
    fn bound(&self, bounds: &Bounds<2>) -> f64 {
        let beside = |d: usize| {
            let [low, high] = bounds[d].map(|x| x + self.by[d]);
            high < self.box_[d].0 - self.near[d] || low > self.box_[d].1 + self.near[d]
        };
        if beside(0) || beside(1) { f64::INFINITY } else { 0.0 }
    }

    fn beyond(&self, _: f64) -> bool {
        self.met
    }

    fn look(&mut self, index: usize) {
        let chord = self.chords[index].map(|end| [end[0] + self.by[0], end[1] + self.by[1]]);
        self.met = self.met || reaches(&chord, &self.box_);
    }
}

/// Whether a chord reaches into a box, its border included.
fn reaches([a, b]: &Chord, box_: &[(f64, f64); 2]) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for d in 0..2 {
        let (low, high) = box_[d];
        let step = b[d] - a[d];
        if step == 0.0 {
            if a[d] < low || a[d] > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - a[d]) / step, (high - a[d]) / step);
        (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
    }
    // Rounding does not make a chord miss a box.
    from <= to + 1e-12
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// Numbers in 0 .. 1, the same every time.
    fn random(mut seed: u64) -> impl FnMut() -> f64 {
        move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Half of what goes round: its loop's level lines are tilted by rounding, and of the other half at that level nothing is inside.
    #[test]
    fn what_runs_along_an_axis_to_rounding_does() {
        let (pi, mut random) = (std::f64::consts::PI, random(7));
        let mut tilt = || (random() - 0.5) * 4e-16;
        let low: Vec<[f64; 2]> = (0..=16).map(|k| [pi + pi * f64::from(k) / 16.0, 0.25 + tilt()]).collect();
        let high: Vec<[f64; 2]> =
            (0..=16).map(|k| [2.0 * pi - pi * f64::from(k) / 16.0, 0.75 + tilt()]).collect();
        let line: Vec<[f64; 2]> = low.iter().chain(&high).chain(&low[..1]).copied().collect();
        let sides = [
            ParameterSide { low: 0.0, high: 2.0 * pi, closed: true, poles: [false; 2] },
            ParameterSide { low: 0.0, high: 1.0, closed: false, poles: [false; 2] },
        ];
        let half = Outline::new(&[line], sides);
        for k in 0..200 {
            let u = pi * (0.01 + 0.98 * f64::from(k) / 200.0);
            for v in [0.25, 0.25 + tilt(), 0.75, 0.75 + tilt()] {
                assert!(!half.has([u, v]), "{u} {v}");
            }
            assert!(half.has([u + pi, 0.5]) && !half.has([u, 0.5]));
        }
    }

    /// A round loop that touches all four sides of the domain in corners of its chords: of the lines along the sides nothing but these corners is met.
    #[test]
    fn what_a_line_touches_it_does_not_cross() {
        for count in [4_u32, 8, 48, 192] {
            for start in 0..count {
                let corner = |k: u32| {
                    let quarter = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
                    let (k, each) = ((k + start) % count, count / 4);
                    let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
                    if k % each == 0 { quarter[(k / each) as usize] } else { [cos, sin] }
                };
                let line: Vec<[f64; 2]> = (0..=count).map(corner).collect();
                let side = ParameterSide { low: -1.0, high: 1.0, closed: false, poles: [false; 2] };
                let holes: Vec<[f64; 2]> = line.iter().rev().copied().collect();
                let (round, rest) = (Outline::new(&[line], [side; 2]), Outline::new(&[holes], [side; 2]));
                for [x, y] in [
                    [-1.0, -1.0],
                    [1.0, -1.0],
                    [1.0, 1.0],
                    [-1.0, 1.0],
                    [-0.9, 1.0],
                    [1.0, 0.8],
                    [-1.0, 0.95],
                ] {
                    assert!(!round.has([x, y]) && rest.has([x, y]), "{count} {start} {x} {y}");
                }
                for at in [[0.0, 0.0], [0.3, 0.0], [0.0, -0.4], [0.4, 0.4]] {
                    assert!(round.has(at) && !rest.has(at), "{count} {start} {at:?}");
                }
            }
        }
    }

    /// The same by asking all chords.
    fn slowly(lines: &[Vec<[f64; 2]>], sides: &[ParameterSide; 2], at: [f64; 2]) -> bool {
        if lines.is_empty() {
            return true;
        }
        let turns = |d: usize| {
            let t = sides[d].length();
            if sides[d].closed { vec![-2.0 * t, -t, 0.0, t, 2.0 * t] } else { vec![0.0] }
        };
        let mut nearest: Option<(f64, f64, bool)> = None;
        for (along, across) in [(1, 0), (0, 1)] {
            for pair in lines.iter().flat_map(|line| line.windows(2)) {
                for by in turns(across) {
                    let [low, high] = [0, 1].map(|k: usize| pair[k][across] + by - at[across]);
                    if (low <= 0.0) == (high <= 0.0) {
                        continue;
                    }
                    let met = pair[0][along] + (pair[1][along] - pair[0][along]) * (low / (low - high));
                    for by in turns(along) {
                        let away = met + by - at[along];
                        let left_is_after = (along == 1) == (high > low);
                        let slope = (pair[1][along] - pair[0][along]) / (pair[1][across] - pair[0][across]);
                        let (far, further) = (away.abs(), slope * away.signum() + 0.0);
                        if nearest.is_none_or(|(best, next, _)| far < best || far == best && further < next) {
                            nearest = Some((far, further, (away < 0.0) == left_is_after));
                        }
                    }
                }
            }
        }
        nearest.map_or(is_left_beyond(lines), |(.., inside)| inside)
    }

    fn shares_slowly(
        lines: &[Vec<[f64; 2]>],
        sides: &[ParameterSide; 2],
        box_: [(f64, f64); 2],
    ) -> Option<bool> {
        let turns = |d: usize| {
            let t = sides[d].length();
            if sides[d].closed { vec![-2.0 * t, -t, 0.0, t, 2.0 * t] } else { vec![0.0] }
        };
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            for u in turns(0) {
                for v in turns(1) {
                    if reaches(&[0, 1].map(|k: usize| [pair[k][0] + u, pair[k][1] + v]), &box_) {
                        return None;
                    }
                }
            }
        }
        Some(slowly(lines, sides, box_.map(|(low, high)| 0.5 * low + 0.5 * high)))
    }

    /// Rings, combs and zigzags (repeated places, pieces along the axes and on one another) and loops that run round what closes: whatever is asked,
    /// places on the chords and at their ends too, the answer is that of asking all of them.
    #[test]
    fn a_tree_answers_as_asking_all_chords_does() {
        let mut next = random(29);
        let side =
            |closed: bool, size: f64| ParameterSide { low: 0.0, high: size, closed, poles: [false; 2] };
        for (number, size) in [1.0, 1e-9, 1e9, 3.7].into_iter().cycle().take(48).enumerate() {
            let sides = [side(number % 2 == 1, size), side(number % 3 == 1, 2.0 * size)];
            let count = [3, 7, 40, 300][number % 4];
            let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
            for ring in 0..1 + number % 3 {
                let (middle, radius) = ([size * next(), 2.0 * size * next()], size * (0.1 + 0.4 * next()));
                let line: Vec<[f64; 2]> = (0..=count)
                    .map(|k| {
                        let angle = (k % count) as f64 / count as f64 * std::f64::consts::TAU;
                        let wave = 1.0 + 0.3 * (9.0 * angle).sin() * f64::from(ring as u8);
                        // Rounded to a grid: places that repeat, chords along the axes.
                        let grid =
                            |x: f64| if number % 5 < 2 { (x / size * 16.0).round() / 16.0 * size } else { x };
                        [
                            grid(middle[0] + radius * wave * angle.cos()),
                            grid(middle[1] + radius * wave * angle.sin()),
                        ]
                    })
                    .collect();
                lines.push(line);
            }
            if sides[0].closed {
                let (start, height) = (size * next(), 2.0 * size * next());
                lines.push((0..=count).map(|k| [start + size * k as f64 / count as f64, height]).collect());
            }
            let outline = Outline::new(&lines, sides);
            // What is one to rounding is one here, too.
            let known = [0, 1].map(|d| alike(&lines, d, LEVEL * sides[d].length()));
            let level = |at: &mut [f64; 2]| *at = [0, 1].map(|d: usize| leveled(&known[d], at[d]));
            lines.iter_mut().flatten().for_each(level);
            let ends: Vec<[f64; 2]> = lines.iter().flatten().copied().collect();
            let mut met = [0_usize; 2];
            for k in 0..400 {
                let any = [size * (1.4 * next() - 0.2), 2.0 * size * (1.4 * next() - 0.2)];
                let end = ends[(next() * ends.len() as f64) as usize % ends.len()];
                let at = match k % 4 {
                    0 => end,
                    1 => [end[0], any[1]],
                    2 => [any[0], end[1]],
                    _ => any,
                };
                let found = outline.has(at);
                assert_eq!(found, slowly(&lines, &sides, at), "{number}: {at:?}");
                met[usize::from(found)] += 1;
                let low = [size * next(), 2.0 * size * next()];
                let wide = size * 0.3 * next() * next();
                let box_ = [(low[0], low[0] + wide), (low[1], low[1] + wide)];
                assert_eq!(outline.share(box_), shares_slowly(&lines, &sides, box_), "{number}: {box_:?}");
            }
            assert!(met[0] > 0 && met[1] > 0, "{number}: {met:?}");
        }
        let nothing = Outline::new(&[], [side(false, 1.0); 2]);
        assert!(nothing.has([0.5, 0.5]) && nothing.share([(0.0, 1.0); 2]) == Some(true));
        let one = Outline::new(&[vec![[0.5, 0.5]]], [side(false, 1.0); 2]);
        assert!(!one.has([0.5, 0.5]) && !one.has([f64::NAN, f64::INFINITY]));
    }
}
