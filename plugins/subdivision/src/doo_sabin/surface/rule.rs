//! What intervals make of a face of a refined cage: the same on all levels.

use std::sync::Arc;

use super::node::{Sums, middle, of_face};
use crate::doo_sabin::limit::{plane, position};
use crate::doo_sabin::refine::Weights;
use crate::eigen::{self, Matrix, Plane};

/// How a ring of vertices is refined by its intervals. Number `k` of these is across the edge from corner `k` to the next: a vertex has
/// number `k - 1` in the direction of the edge that follows, `k` in that of the one before.
#[derive(Debug, Clone)]
pub(super) enum Rule {
    /// A quad, which is a part of a tensor-product spline.
    Quad([f64; 4]),
    /// A face whose intervals are all the same.
    Even(f64),
    /// Another face, the first of the ring being one of its corners.
    Other(Arc<Extraordinary>, usize),
}

/// How far from one half the two eigenvalues of the tangent plane may be found to be: they are one half but for rounding, or another one is larger.
const HALF: f64 = 1e-6;

/// A face of another number of corners than four. Its intervals are halved alike at every level, so that the matrix stays the same.
#[derive(Debug)]
pub(super) struct Extraordinary {
    intervals: Vec<f64>,
    matrix: Matrix,
    position: Vec<f64>,
    plane: Plane,
}

impl Extraordinary {
    /// Of these intervals; `None` where the surface is not smooth there. One half is an eigenvalue twice whatever they are; of five corners and more
    /// intervals far from each other make others as large (1:9 among five is still smooth, among twelve 1:2), and then its plane is not that
    /// which all comes to. Cost: some fifty times the square of its size.
    pub(super) fn new(intervals: Vec<f64>) -> Option<Self> {
        let n = intervals.len();
        let own: Vec<[f64; 2]> = (0..n).map(|k| [intervals[(k + n - 1) % n], intervals[k]]).collect();
        let matrix = Weights::new(&own)?.matrix();
        let position = position(&matrix)?;
        let plane = plane(&matrix, &position)?;
        let is_half = (0..2).all(|a| {
            let image = eigen::times(&plane.rows[a], &matrix);
            (0..2).all(|b| {
                let by: f64 = image.iter().zip(&plane.places[b]).map(|(x, y)| x * y).sum();
                (by - if a == b { 0.5 } else { 0.0 }).abs() <= HALF
            })
        });
        is_half.then_some(Self { intervals, matrix, position, plane })
    }

    /// The directions in the tangent plane of the sides at a corner: between it and the one before, and between it and the next, each where the
    /// knot line is. Where they are half a turn apart and more, as intervals far from each other have it, an eighth of a turn to either side of
    /// the corner instead, so that the second is to the left of the first always.
    fn sides(&self, corner: usize) -> [[f64; 2]; 2] {
        let n = self.intervals.len();
        let (at, d) =
            (|k: usize| self.plane.places.each_ref().map(|x| x[k % n]), |k: usize| self.intervals[k % n]);
        let own = at(corner);
        let side = |other: usize, here: f64, there: f64| {
            let other = at(other);
            [0, 1].map(|axis| own[axis] + part(here, there) * (other[axis] - own[axis]))
        };
        let first = side(corner + n - 1, d(corner), d(corner + n - 2));
        let second = side(corner + 1, d(corner + n - 1), d(corner + 1));
        if first[0] * second[1] - first[1] * second[0] > 0.0 {
            return [first, second];
        }
        let [x, y] = if own == [0.0; 2] { [1.0, 0.0] } else { own };
        [[x + y, y - x], [x - y, x + y]]
    }
}

/// `a / (a + b)`, a half of nothing.
fn part(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { a / (a + b) } else { 0.5 }
}

/// The sum of multiples of a ring's vertices.
fn sum<T: Sums>(ring: &[T], weight: impl Fn(usize) -> f64) -> T {
    let mut all = ring[0].times(weight(0));
    ring.iter().enumerate().skip(1).for_each(|(k, x)| all.add(x, weight(k)));
    all
}

impl Rule {
    /// Interval `k` of `n`, counted round from the first.
    pub(super) fn interval(&self, k: usize) -> f64 {
        match self {
            Self::Quad(all) => all[k % 4],
            Self::Even(interval) => *interval,
            Self::Other(face, start) => face.intervals[(start + k) % face.intervals.len()],
        }
    }

    /// The last of them, or so many before that.
    pub(super) fn last(&self, back: usize) -> f64 {
        match self {
            Self::Quad(all) => all[3 - back % 4],
            Self::Even(interval) => *interval,
            Self::Other(face, start) => {
                let n = face.intervals.len();
                face.intervals[(start + n - 1 - back) % n]
            }
        }
    }

    /// The new vertices of a ring's corners (Sederberg, Zheng, Sewell and Sabin 1998, section 3).
    pub(super) fn refined<T: Sums>(&self, ring: &[T]) -> Vec<T> {
        match self {
            Self::Quad([a, b, c, d]) => {
                // Along the edges 0 and 2, and along 1 and 3: what of a corner goes to the next.
                let along = [0.5 * part(*d, *b), 0.5 * part(*b, *d)];
                let across = [0.5 * part(*a, *c), 0.5 * part(*c, *a)];
                let one = |k: usize| {
                    let (i, j) = (usize::from(k == 1 || k == 2), usize::from(k > 1));
                    let (s, t) = (along[i], across[j]);
                    // Seen from the corner: it, that beside it along the edges 0 and 2, the one across, the one along the others.
                    let [beside, over, before] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]][k];
                    let mut all = ring[k].times((1.0 - s) * (1.0 - t));
                    all.add(&ring[beside], s * (1.0 - t));
                    all.add(&ring[over], s * t);
                    all.add(&ring[before], (1.0 - s) * t);
                    all
                };
                (0..4).map(one).collect()
            }
            Self::Even(_) => of_face(ring),
            Self::Other(face, start) => {
                let n = ring.len();
                let one = |k: usize| {
                    let row = &face.matrix[(start + k) % n];
                    sum(ring, |j| row[(start + j) % n].1)
                };
                (0..n).map(one).collect()
            }
        }
    }

    /// The limit of a ring's middle, and two tangents: towards the sides between its first vertex and the last, and between the first
    /// and the second.
    pub(super) fn limit<T: Sums>(&self, ring: &[T]) -> (T, [T; 2]) {
        match self {
            Self::Quad([a, b, c, d]) => {
                let (along, across) = ([part(*b, *d), part(*d, *b)], [part(*c, *a), part(*a, *c)]);
                let at = |k: usize| (usize::from(k == 1 || k == 2), usize::from(k > 1));
                let sign = |k: usize| if k == 0 { 1.0 } else { -1.0 };
                let position = sum(ring, |k| along[at(k).0] * across[at(k).1]);
                let first = sum(ring, |k| sign(at(k).0) * across[at(k).1]);
                let second = sum(ring, |k| sign(at(k).1) * along[at(k).0]);
                (position, [first, second])
            }
            Self::Even(_) => middle(ring),
            Self::Other(face, start) => {
                let n = ring.len();
                let along = face.sides(*start).map(|way| {
                    let rows = &face.plane.rows;
                    sum(ring, |k| (0..2).map(|axis| way[axis] * rows[axis][(start + k) % n]).sum())
                });
                (sum(ring, |k| face.position[(start + k) % n]), along)
            }
        }
    }
}

/// How much of the first of its three vertices, and of the last, is in those of the quadratic with uniform knots that is the same over the middle
/// one of these spans; the rest is of the one between, which stays.
pub(super) fn uniform([before, own, after]: [f64; 3]) -> [f64; 2] {
    [2.0 * part(own, before), 2.0 * part(own, after)]
}
