//! The neighbourhood of one piece of a surface, refined where a place is.

use std::borrow::Cow;
use std::f64::consts::TAU;

use loftsman_kernel::Vector;

use super::rule::{Rule, uniform};

/// What is refined: points, or rows over the vertices of the cage.
pub(super) trait Sums: Clone {
    /// Adds a multiple of another.
    fn add(&mut self, other: &Self, by: f64);
    /// A multiple.
    fn times(&self, by: f64) -> Self;
}

impl Sums for Vector {
    fn add(&mut self, other: &Self, by: f64) {
        *self += other * by;
    }

    fn times(&self, by: f64) -> Self {
        self * by
    }
}

/// A row, one number for each vertex near by.
impl Sums for Vec<f64> {
    fn add(&mut self, other: &Self, by: f64) {
        self.iter_mut().zip(other).for_each(|(own, c)| *own += c * by);
    }

    fn times(&self, by: f64) -> Self {
        self.iter().map(|c| c * by).collect()
    }
}

/// A vertex of a refined cage with the four faces round it, which lie at the corners of its piece of the surface: `[0, 1]²` between the
/// limits of the faces' middles, corner 0 at `(0, 0)`, the others counterclockwise. Each face is a ring of vertices, counterclockwise
/// from the vertex itself, so that the last of a ring is the second of the next.
///
/// Faces 1 and 3 lie on edges of the cage and are quads; 0 lies on a face and 2 on a vertex. Where these are quads, too, the
/// piece is biquadratic.
#[derive(Debug, Clone)]
pub(super) struct Node<T> {
    pub(super) rings: [Vec<T>; 4],
    /// What intervals make of each ring; nothing where all of the cage's are the same.
    pub(super) rules: Option<Box<[Rule; 4]>>,
}

/// The new vertices of a face's corners (Doo and Sabin 1978), by the sums over the face: linear in its size.
pub(super) fn of_face<T: Sums>(ring: &[T]) -> Vec<T> {
    let n = ring.len();
    let sum = |weight: &dyn Fn(usize) -> f64| {
        let mut all = ring[0].times(weight(0));
        ring.iter().enumerate().skip(1).for_each(|(i, x)| all.add(x, weight(i)));
        all
    };
    let combined = |parts: &[(&T, f64)]| {
        let mut all = parts[0].0.times(parts[0].1);
        parts[1..].iter().for_each(|(x, by)| all.add(x, *by));
        all
    };
    if n == 4 {
        let one = |i: usize| {
            let [own, next, across, before] = [0, 1, 2, 3].map(|k| &ring[(i + k) % 4]);
            combined(&[(own, 0.5625), (next, 0.1875), (across, 0.0625), (before, 0.1875)])
        };
        return (0..n).map(one).collect();
    }
    let count = n as f64;
    let wave = |i: usize| (TAU * i as f64 / count).sin_cos();
    let (all, cosines, sines) = (sum(&|_| 1.0), sum(&|i| wave(i).1), sum(&|i| wave(i).0));
    // Of itself 1/4, of all 3/(4n), and (cos over the difference of angles)/(2n).
    let one = |i: usize| {
        let (sin, cos) = wave(i);
        combined(&[
            (&ring[i], 0.25),
            (&all, 0.75 / count),
            (&cosines, 0.5 * cos / count),
            (&sines, 0.5 * sin / count),
        ])
    };
    (0..n).map(one).collect()
}

/// The limit of the middle of a face, and two tangents there: towards the sides between the first vertex of its ring and the last, and
/// between the first and the second.
pub(super) fn middle<T: Sums>(ring: &[T]) -> (T, [T; 2]) {
    let n = ring.len() as f64;
    let sum = |weight: &dyn Fn(f64) -> f64| {
        let mut all = ring[0].times(weight(0.0));
        ring.iter().enumerate().skip(1).for_each(|(i, x)| all.add(x, weight(TAU * i as f64 / n)));
        all
    };
    // The vertex itself is in the middle between the two sides: seen from the corner they are an eighth of a turn away, whatever the
    // face's size, in a chart in which its corners lie at equal angles.
    let half = TAU / n / 2.0;
    (sum(&|_| 1.0 / n), [sum(&|t| (t + half).cos()), sum(&|t| (t - half).cos())])
}

impl<T: Sums> Node<T> {
    /// Whether the piece is biquadratic.
    pub(super) fn is_regular(&self) -> bool {
        self.rings.iter().all(|ring| ring.len() == 4)
    }

    /// The 9 vertices of the uniform biquadratic B-spline over a regular piece, `u` after `u`: by intervals of the one that is the same there.
    pub(super) fn net(&self) -> [Cow<'_, T>; 9] {
        let [a, b, c, d] = &self.rings;
        let own = [&a[2], &a[1], &d[2], &a[3], &a[0], &c[3], &b[2], &b[3], &c[2]];
        let Some(rules) = &self.rules else { return own.map(Cow::Borrowed) };
        let [first, second, _, fourth] = &**rules;
        let along_u = uniform([first.interval(1), first.last(0), second.interval(2)]);
        let along_v = uniform([first.interval(2), first.interval(0), fourth.interval(1)]);
        // Of the vertex at a place, and of the one in the middle: of the middle itself all.
        let share = |[low, high]: [f64; 2], k: usize| match k {
            0 => low,
            1 => 1.0,
            _ => high,
        };
        std::array::from_fn(|k| {
            let (i, j) = (k / 3, k % 3);
            let (x, y) = (share(along_u, i), share(along_v, j));
            let mut sum = own[k].times(x * y);
            if i != 1 {
                sum.add(own[3 + j], (1.0 - x) * y);
            }
            if j != 1 {
                sum.add(own[3 * i + 1], x * (1.0 - y));
            }
            if i != 1 && j != 1 {
                sum.add(own[4], (1.0 - x) * (1.0 - y));
            }
            Cow::Owned(sum)
        })
    }

    /// Whether by intervals the piece has no extent along `u`, and along `v`: it is a line or a point of the surface.
    pub(super) fn vanishes(&self) -> [bool; 2] {
        self.rules
            .as_ref()
            .map_or([false; 2], |rules| [rules[0].last(0), rules[0].interval(0)].map(|d| d <= 0.0))
    }

    /// The new vertices of all rings.
    fn refined(&self) -> [Vec<T>; 4] {
        match &self.rules {
            None => self.rings.each_ref().map(|ring| of_face(ring)),
            Some(rules) => [0, 1, 2, 3].map(|k| rules[k].refined(&self.rings[k])),
        }
    }

    /// The neighbourhood of the quarter at each corner, the same corner its own with the same number.
    pub(super) fn quarters(&self) -> [Self; 4] {
        let new = self.refined();
        [0, 1, 2, 3].map(|k| self.quarter(&new, k))
    }

    /// The quarter at one corner.
    pub(super) fn quarter_at(&self, corner: usize) -> Self {
        self.quarter(&self.refined(), corner)
    }

    fn quarter(&self, new: &[Vec<T>; 4], corner: usize) -> Self {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &new[(corner + k) % 4]);
        let (last, end) = (&a[a.len() - 1], &d[d.len() - 1]);
        let own = [
            a.clone(),
            [&a[0], last, &b[1], &b[0]].map(T::clone).to_vec(),
            [&a[0], &b[0], &c[0], &d[0]].map(T::clone).to_vec(),
            [&a[0], &d[0], end, &a[1]].map(T::clone).to_vec(),
        ];
        let mut rings = own;
        rings.rotate_right(corner);
        // Halved at every level, all of them: only ratios count. The vertex has one interval along the edge that follows in the ring at the
        // corner, and one along the edge before; its neighbours there have others.
        let rules = self.rules.as_ref().map(|rules| {
            let ring = &rules[corner];
            let (along, across) = (ring.last(0), ring.interval(0));
            let mut own = Box::new([
                ring.clone(),
                Rule::Quad([along, ring.last(1), along, across]),
                Rule::Quad([across, along, across, along]),
                Rule::Quad([along, across, ring.interval(1), across]),
            ]);
            own.rotate_right(corner);
            own
        });
        Self { rings, rules }
    }

    /// The limit of the middle of the face at a corner, and two tangents there, along `u` and along `v` as far as the middle of an
    /// extraordinary face has such directions: their lengths say nothing.
    pub(super) fn corner(&self, corner: usize) -> (T, [T; 2]) {
        let ring = &self.rings[corner];
        let (position, [first, second]) = match &self.rules {
            None => middle(ring),
            Some(rules) => rules[corner].limit(ring),
        };
        // First is the side towards the face before, second that towards the one after; signs make them u and v.
        let tangents = match corner {
            0 => [first, second],
            1 => [second.times(-1.0), first],
            2 => [first.times(-1.0), second.times(-1.0)],
            _ => [second, first.times(-1.0)],
        };
        (position, tangents)
    }

    /// The piece that holds a place, the place in it, and how often it was halved: at most so many times. `None` where it is not regular
    /// then.
    pub(super) fn piece(&self, (mut u, mut v): (f64, f64), most: u32) -> Option<(Self, (f64, f64), u32)> {
        let mut node = self.clone();
        for level in 0..=most {
            if node.is_regular() {
                return Some((node, (u, v), level));
            }
            let right = [u >= 0.5, v >= 0.5];
            let corner = match right {
                [false, false] => 0,
                [true, false] => 1,
                [true, true] => 2,
                [false, true] => 3,
            };
            node = node.quarter_at(corner);
            [u, v] = [u, v].map(|x| 2.0 * x);
            u -= f64::from(u8::from(right[0]));
            v -= f64::from(u8::from(right[1]));
        }
        None
    }
}
