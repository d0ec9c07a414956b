//! Edges kept by one similarity of the whole surface, where there is one that keeps them.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Direction;
use loftsman_kernel::spline::algebra::Field;
use loftsman_kernel::text::short;
use nalgebra::{Matrix3, Rotation3, SVD};

use crate::error::{FineTuneError, Result};
use crate::lines::size;
use crate::turn::least_turn;

/// The tuned surface with `fixed` rows at either end along `u` as the given one (in the same space) has them, the rest brought
/// there by the similarity that takes the innermost two of these rows to where they should be. Of a curve there always is one; of
/// a surface only where all of its `u`-lines want the same.
///
/// # Errors
/// When no similarity takes these rows there within `1e-9` of the surface's size, or there are not as many.
pub(crate) fn matched(
    tuned: &Field<Vector>,
    given: &Field<Vector>,
    fixed: usize,
    name: &str,
) -> Result<(Field<Vector>, f64)> {
    let (u, v) = (tuned.space(Direction::U), tuned.space(Direction::V));
    let (n, width) = (u.len(), v.len());
    if n < 2 * fixed || given.coefficients().len() != tuned.coefficients().len() {
        return Err(FineTuneError::Contradiction(format!(
            "{n} rows of control vertices along {name} are too few to keep {fixed} at either end: insert knots first, or keep less"
        )));
    }
    let rows = |field: &Field<Vector>| {
        let row = |k: usize| field.coefficients()[k * width..(k + 1) * width].to_vec();
        [row(fixed - 1), row(n - fixed)].concat()
    };
    let (from, to) = (rows(tuned), rows(given));
    let similarity = Similarity::nearest(&from, &to);
    let off = from.iter().zip(&to).fold(0.0_f64, |m, (a, b)| m.max((similarity.apply(a) - b).norm()));
    let extent = size(given).max(size(tuned));
    // Written so that NaN fails too.
    if off.is_nan() || off > 1e-9 * extent {
        return Err(FineTuneError::Contradiction(format!(
            "the {name}-lines of the surface want different rotations and scales to keep their ends: the nearest that is one for all \
             of them misses by {off}. Use ends = \"exact\" with α(u, v), which changes α for each of them",
            off = short(off)
        )));
    }
    let mut all: Vec<Vector> = tuned.coefficients().iter().map(|c| similarity.apply(c)).collect();
    let (kept, last) = (fixed * width, all.len() - fixed * width);
    all[..kept].copy_from_slice(&given.coefficients()[..kept]);
    all[last..].copy_from_slice(&given.coefficients()[last..]);
    Ok((Field::new(u.clone(), v.clone(), all)?, similarity.scale))
}

struct Similarity {
    from: Vector,
    to: Vector,
    turn: Rotation3<f64>,
    scale: f64,
}

impl Similarity {
    /// The one that takes points nearest to others, in the sum of squares (Umeyama 1991); where all points are on a line, with the
    /// rotation of least angle.
    fn nearest(from: &[Vector], to: &[Vector]) -> Self {
        let middle = |all: &[Vector]| all.iter().sum::<Vector>() / all.len().max(1) as f64;
        let (a, b) = (middle(from), middle(to));
        let extent =
            |all: &[Vector], middle: Vector| all.iter().fold(0.0_f64, |m, p| m.max((p - middle).norm()));
        let (of_a, of_b) = (extent(from, a), extent(to, b));
        let none = Self { from: a, to: b, turn: Rotation3::identity(), scale: 1.0 };
        if !(of_a > 0.0 && of_b > 0.0) {
            return none;
        }
        let pairs = || from.iter().zip(to).map(|(p, q)| ((p - a) / of_a, (q - b) / of_b));
        let covariance = pairs().fold(Matrix3::zeros(), |sum, (p, q)| sum + q * p.transpose());
        let spread: f64 = pairs().map(|(p, _)| p.norm_squared()).sum();
        let svd = SVD::new(covariance, true, true);
        let (Some(left), Some(right)) = (svd.u, svd.v_t) else { return none };
        let values = svd.singular_values;
        let (turn, trace) = if values[1] <= 1e-14 * values[0] {
            let (p, q) = pairs().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap_or_default();
            (least_turn(&p, &q), values[0])
        } else {
            let sign = (left.determinant() * right.determinant()).signum();
            let flip = Matrix3::from_diagonal(&Vector::new(1.0, 1.0, sign));
            let turn = Rotation3::from_matrix_unchecked(left * flip * right);
            (turn, values[0] + values[1] + sign * values[2])
        };
        Self { from: a, to: b, turn, scale: trace / spread * (of_b / of_a) }
    }

    fn apply(&self, p: &Vector) -> Vector {
        self.to + self.turn * (p - self.from) * self.scale
    }
}
