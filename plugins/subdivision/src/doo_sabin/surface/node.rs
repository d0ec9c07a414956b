//! The neighbourhood of one piece of a surface, refined where a place is.

use std::f64::consts::TAU;

use loftsman_kernel::Vector;

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
}

/// The new vertices of a face's corners (Doo and Sabin 1978), by the sums over the face: linear in its size.
fn of_face<T: Sums>(ring: &[T]) -> Vec<T> {
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

impl<T: Sums> Node<T> {
    /// Whether the piece is biquadratic.
    pub(super) fn is_regular(&self) -> bool {
        self.rings.iter().all(|ring| ring.len() == 4)
    }

    /// The 9 vertices of the uniform biquadratic B-spline over a regular piece, `u` after `u`.
    pub(super) fn net(&self) -> [&T; 9] {
        let [a, b, c, d] = &self.rings;
        [&a[2], &a[1], &d[2], &a[3], &a[0], &c[3], &b[2], &b[3], &c[2]]
    }

    /// The neighbourhood of the quarter at each corner, the same corner its own with the same number.
    pub(super) fn quarters(&self) -> [Self; 4] {
        let new = self.rings.each_ref().map(|ring| of_face(ring));
        [0, 1, 2, 3].map(|k| Self::quarter(&new, k))
    }

    /// The quarter at one corner.
    pub(super) fn quarter_at(&self, corner: usize) -> Self {
        Self::quarter(&self.rings.each_ref().map(|ring| of_face(ring)), corner)
    }

    fn quarter(new: &[Vec<T>; 4], corner: usize) -> Self {
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
        Self { rings }
    }

    /// The limit of the middle of the face at a corner, and two tangents there, along `u` and along `v` as far as the middle of an
    /// extraordinary face has such directions: their lengths say nothing.
    pub(super) fn corner(&self, corner: usize) -> (T, [T; 2]) {
        let ring = &self.rings[corner];
        let n = ring.len() as f64;
        let sum = |weight: &dyn Fn(f64) -> f64| {
            let mut all = ring[0].times(weight(0.0));
            ring.iter().enumerate().skip(1).for_each(|(i, x)| all.add(x, weight(TAU * i as f64 / n)));
            all
        };
        // The vertex itself is in the middle between the two sides: seen from the corner they are an eighth of a turn away, whatever the
        // face's size, in a chart in which its corners lie at equal angles.
        let half = TAU / n / 2.0;
        let (first, second) = (sum(&|t| (t + half).cos()), sum(&|t| (t - half).cos()));
        // First is the side towards the face before, second that towards the one after; signs make them u and v.
        let tangents = match corner {
            0 => [first, second],
            1 => [second.times(-1.0), first],
            2 => [first.times(-1.0), second.times(-1.0)],
            _ => [second, first.times(-1.0)],
        };
        (sum(&|_| 1.0 / n), tangents)
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
