//! How a surface has turned in the neighbourhood of a place: the rotation that takes it best from what it was to what it is.

use loftsman_kernel::Vector;
use loftsman_kernel::error::Error;
use loftsman_kernel::spline::Surface;

/// A neighbourhood reaches so far, as a part of the places each way.
const REACH: usize = 4;
/// Newton's steps to the nearest rotation, and when they are done.
const STEPS: usize = 60;
const STILL: f64 = 1e-12;
/// A mean of rotations whose determinant is no more than this is none: they turn every way.
const NONE: f64 = 1e-9;

/// The columns of a matrix.
type Matrix = [Vector; 3];

/// A surface's place and its frame there: the unit vectors along the first parameter, square to it, and along the normal; none where there is no tangent plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) point: Vector,
    frame: Option<Matrix>,
}

impl Look {
    /// # Errors
    /// When the place is outside.
    pub(super) fn at(surface: &Surface, u: f64, v: f64) -> Result<Self, Error> {
        let mut all = [Vector::zeros(); 4];
        surface.derivatives_into(u, v, [1, 1], &mut all)?;
        // Of unit length each, so that their product is a number whatever the size.
        let frame = unit(all[2]).zip(unit(all[1])).and_then(|(x, y)| {
            let normal = unit(x.cross(&y))?;
            Some([x, normal.cross(&x), normal])
        });
        Ok(Self { point: all[0], frame })
    }

    pub(super) fn normal(&self) -> Option<Vector> {
        self.frame.map(|[.., normal]| normal)
    }
}

fn unit(vector: Vector) -> Option<Vector> {
    let length = vector.norm();
    (length > 0.0 && length.is_finite()).then(|| vector / length)
}

/// Rotations from frames to frames on a grid of places, summed up so that the mean of any rectangle of them is known at once.
#[derive(Debug)]
pub(super) struct Turned {
    counts: [usize; 2],
    /// Of all places before a row and a column, `counts[0] + 1` by `counts[1] + 1`.
    sums: Vec<Matrix>,
}

impl Turned {
    /// Of a surface before and after, at `counts[0]` times `counts[1]` places, the second index running faster. `O(n)`.
    pub(super) fn new(counts: [usize; 2], before: &[Look], after: &[Look]) -> Self {
        let columns = counts[1] + 1;
        let mut sums = vec![[Vector::zeros(); 3]; (counts[0] + 1) * columns];
        for i in 0..counts[0] {
            let mut row = [Vector::zeros(); 3];
            for j in 0..counts[1] {
                let k = i * counts[1] + j;
                if let (Some(from), Some(to)) = (before[k].frame, after[k].frame) {
                    // Columns of the sum of products to * fromᵀ.
                    for (axis, column) in row.iter_mut().enumerate() {
                        *column += to[0] * from[0][axis] + to[1] * from[1][axis] + to[2] * from[2][axis];
                    }
                }
                for (axis, column) in row.iter().enumerate() {
                    sums[(i + 1) * columns + j + 1][axis] = sums[i * columns + j + 1][axis] + column;
                }
            }
        }
        Self { counts, sums }
    }

    /// The normal at a place turned as its neighbourhood is, a quarter of the places each way: the rotation is the one nearest to the mean of all there in the
    /// sense of least squares (W. Kabsch, Acta Cryst. A 32, 1976), by Newton's iteration for the polar factor (N. J. Higham, SIAM J. Sci. Stat. Comput. 7,
    /// 1986); none where these turn every way. `O(1)`.
    pub(super) fn expected(&self, [i, j]: [usize; 2], normal: &Vector) -> Option<Vector> {
        let range = |at: usize, count: usize| {
            let reach = (count / REACH).max(1);
            [at.saturating_sub(reach), (at + reach + 1).min(count)]
        };
        let ([a, b], [c, d]) = (range(i, self.counts[0]), range(j, self.counts[1]));
        let sum = |i: usize, j: usize, axis: usize| self.sums[i * (self.counts[1] + 1) + j][axis];
        let count = ((b - a) * (d - c)) as f64;
        let mean = [0, 1, 2]
            .map(|axis| (sum(b, d, axis) - sum(a, d, axis) - sum(b, c, axis) + sum(a, c, axis)) / count);
        let [x, y, z] = rotation(mean)?;
        Some(x * normal.x + y * normal.y + z * normal.z)
    }
}

/// The rotation nearest to a matrix.
fn rotation(mut m: Matrix) -> Option<Matrix> {
    for _ in 0..STEPS {
        let [x, y, z] = m;
        let products = [y.cross(&z), z.cross(&x), x.cross(&y)];
        let determinant = x.dot(&products[0]);
        if determinant.partial_cmp(&NONE) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let next = [0, 1, 2].map(|axis| 0.5 * (m[axis] + products[axis] / determinant));
        let moved = (0..3).map(|axis| (next[axis] - m[axis]).norm()).fold(0.0, f64::max);
        m = next;
        if moved <= STILL {
            break;
        }
    }
    Some(m)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::spline::Space;

    use super::*;

    #[test]
    fn what_is_turned_as_a_whole_is_as_expected() {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let at = |k: usize| {
            let (x, y) = ((k / 6) as f64, (k % 6) as f64);
            Point::new(x, y, (x + 0.4 * y).sin())
        };
        let points: Vec<Point> = (0..36).map(at).collect();
        let before = Surface::new(space.clone(), space.clone(), points.clone()).unwrap();
        // By 140°, far beyond a right angle.
        let (sin, cos) = 140.0_f64.to_radians().sin_cos();
        let turn = |p: &Point| Point::new(cos * p.x - sin * p.z, p.y + 7.0, sin * p.x + cos * p.z);
        let after = Surface::new(space.clone(), space, points.iter().map(turn).collect()).unwrap();
        let looks = |s: &Surface| {
            let place = |k: usize| (k as f64 + 0.5) / 9.0 * s.u().domain().1;
            (0..81).map(|k| Look::at(s, place(k / 9), place(k % 9)).unwrap()).collect::<Vec<_>>()
        };
        let (before, after) = (looks(&before), looks(&after));
        let turned = Turned::new([9, 9], &before, &after);
        for k in 0..81 {
            let [m, n] = [before[k].normal().unwrap(), after[k].normal().unwrap()];
            let found = turned.expected([k / 9, k % 9], &m).unwrap();
            assert!((found - n).norm() < 1e-9 && m.dot(&n) < 0.5, "{k}: {found} {n}");
        }
        // Turned every way there is no mean.
        assert_eq!(rotation([Vector::zeros(); 3]), None);
    }
}
