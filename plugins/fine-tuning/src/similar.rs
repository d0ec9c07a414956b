//! Edges kept by one turn and one scale of all lines, where there are such that keep them.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Direction;
use loftsman_kernel::spline::algebra::Field;
use loftsman_kernel::text::short;
use nalgebra::{Matrix3, Rotation3, SVD};

use crate::error::{FineTuneError, Result};
use crate::lines::size;
use crate::turn::least_turn;

/// The tuned surface with `fixed` rows at either end along `u` as the given one (in the same space) has them. The rest of each `u`-line is turned and
/// scaled about the innermost of its first rows, all lines alike: `D_i = G_f + s R (T_i - T_f)` with `T` the tuned lines, `G` the given ones, so that
/// `D_u = s R α S_u`. Of a curve there always are such `s`, `R`; of a surface where all of its `u`-lines want the same, as those of an extrusion, or of one curve
/// moved and made larger or smaller.
///
/// # Errors
/// When none takes these rows there within `1e-9` of the surface's size, or there are not as many.
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
    let row = |field: &Field<Vector>, k: usize| field.coefficients()[k * width..(k + 1) * width].to_vec();
    let chords = |field: &Field<Vector>| -> Vec<Vector> {
        let (first, last) = (row(field, fixed - 1), row(field, n - fixed));
        last.iter().zip(&first).map(|(b, a)| b - a).collect()
    };
    let (from, to) = (chords(tuned), chords(given));
    let turn = Turn::nearest(&from, &to);
    let off = from.iter().zip(&to).fold(0.0_f64, |m, (a, b)| m.max((turn.apply(a) - b).norm()));
    let extent = size(given).max(size(tuned));
    // Written so that NaN fails too.
    if off.is_nan() || off > 1e-9 * extent {
        return Err(FineTuneError::Contradiction(format!(
            "the {name}-lines of the surface want different rotations and scales to keep their ends: the nearest that is one for all \
             of them misses by {off}. Use ends = \"exact\" with α(u, v), which changes α for each of them",
            off = short(off)
        )));
    }
    let (start, wanted) = (row(tuned, fixed - 1), row(given, fixed - 1));
    let lines = start.iter().zip(&wanted).cycle();
    let moved = tuned.coefficients().iter().zip(lines);
    let mut all: Vec<Vector> = moved.map(|(c, (start, to))| to + turn.apply(&(c - start))).collect();
    let (kept, last) = (fixed * width, all.len() - fixed * width);
    all[..kept].copy_from_slice(&given.coefficients()[..kept]);
    all[last..].copy_from_slice(&given.coefficients()[last..]);
    Ok((Field::new(u.clone(), v.clone(), all)?, turn.scale))
}

struct Turn {
    turn: Rotation3<f64>,
    scale: f64,
}

impl Turn {
    /// The one that takes vectors nearest to others, in the sum of squares (Umeyama 1991, without a translation); where all are along one line, by the
    /// rotation of least angle.
    fn nearest(from: &[Vector], to: &[Vector]) -> Self {
        let largest = |all: &[Vector]| all.iter().fold(0.0_f64, |m, p| m.max(p.norm()));
        let (of_a, of_b) = (largest(from), largest(to));
        let none = Self { turn: Rotation3::identity(), scale: 1.0 };
        if !(of_a > 0.0 && of_b > 0.0) {
            return none;
        }
        let pairs = || from.iter().zip(to).map(|(p, q)| (p / of_a, q / of_b));
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
        Self { turn, scale: trace / spread * (of_b / of_a) }
    }

    fn apply(&self, p: &Vector) -> Vector {
        self.turn * p * self.scale
    }
}
