//! How many meetings two pieces can have: at most one where a matrix of ranges is diagonally dominant.
//!
//! Two points are one where `F(t, u, v) = A₃(t) B_w(u, v) - B₃(u, v) A_w(t) = 0` (`A₃`, `A_w` homogeneous). By the mean
//! value theorem `F(x) - F(y) = J (x - y)` with `J` within the ranges of the derivatives over the box. Where `Y J` is
//! strictly diagonally dominant for a fixed `Y`, `F` is one-to-one; and every root lies in Krawczyk's box
//! `c - Y F(c) + (I - Y J)(x - c)` (R. Krawczyk, Computing 4, 1969).

use loftsman_kernel::Vector;

use crate::meeting::Pair;
use crate::net::Range;

/// What is known of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Known {
    /// It does not come within the tolerance.
    Apart,
    /// It meets once at most.
    Once,
    /// Nothing.
    Open,
}

pub(crate) fn known(pair: &Pair<'_>, tolerance: f64) -> Known {
    let n = pair.unknowns();
    let middle = [0.5, 0.5, 0.5];
    let (difference, columns, [a, b]) = pair.difference(middle);
    let Some(inverse) = left_inverse(&columns[..n]) else { return Known::Open };
    let around = (a.point + b.point) * 0.5;
    let (va, vb) = (pair.a.values(&around), pair.b.values(&around));
    // F at the middle is the difference times both weights there; the rows of Y are over their product.
    let mut ranges = [[Range::EMPTY; 3]; 3];
    let slopes_a = pair.a.slopes(0, &around);
    for k in 0..3 {
        ranges[0][k] = slopes_a[k].times(vb[3]).minus(vb[k].times(slopes_a[3]));
    }
    for d in 0..n - 1 {
        let slopes = pair.b.slopes(d, &around);
        for k in 0..3 {
            ranges[1 + d][k] = va[k].times(slopes[3]).minus(slopes[k].times(va[3]));
        }
    }
    let weights = weight_at_middle(pair);
    let product = va[3].high * vb[3].high / weights;
    let mut dominant = true;
    for (i, row) in inverse[..n].iter().enumerate() {
        let mut off = 0.0;
        let mut spread = 0.0;
        let mut diagonal = 0.0;
        let mut rounding = 0.0;
        for (c, column) in ranges[..n].iter().enumerate() {
            let mut entry = Range { low: 0.0, high: 0.0 };
            for k in 0..3 {
                entry = entry.plus(column[k].scaled(row[k] / weights));
                rounding += 16.0 * f64::EPSILON * column[k].magnitude() * row[k].abs() / weights;
            }
            if i == c {
                diagonal = entry.low;
                spread += Range { low: 1.0 - entry.high, high: 1.0 - entry.low }.magnitude();
            } else {
                off += entry.magnitude();
                spread += entry.magnitude();
            }
        }
        // Where directions become one at an end of the box, what is left of the diagonal is rounding.
        dominant &= diagonal > off * (1.0 + 1e-12) + rounding;
        let reach = 0.5 * spread + row.norm() * tolerance * product;
        if (row.dot(&difference)).abs() > 0.5 + reach + 1e-12 {
            return Known::Apart;
        }
    }
    if dominant { Known::Once } else { Known::Open }
}

fn weight_at_middle(pair: &Pair<'_>) -> f64 {
    let at = |piece: &crate::net::Piece| {
        let [rows, columns] = piece.orders;
        let (u, v) = (binomials(rows - 1), binomials(columns - 1));
        let mut sum = 0.0;
        for i in 0..rows {
            for j in 0..columns {
                sum += u[i] * v[j] * piece.net[i * columns + j][3];
            }
        }
        sum
    };
    at(pair.a) * at(pair.b)
}

/// The Bernstein polynomials at 1/2.
fn binomials(degree: usize) -> Vec<f64> {
    let mut row = vec![1.0];
    for _ in 0..degree {
        let mut next = vec![0.5; row.len() + 1];
        for (i, x) in next.iter_mut().enumerate() {
            let before = if i > 0 { row[i - 1] } else { 0.0 };
            *x = 0.5 * before + 0.5 * row.get(i).copied().unwrap_or(0.0);
        }
        row = next;
    }
    row
}

/// Rows that take the columns to the unit vectors: `(JᵀJ)⁻¹Jᵀ` for two columns, `J⁻¹` for three.
fn left_inverse(columns: &[Vector]) -> Option<[Vector; 3]> {
    let rows = match *columns {
        [a, b] => {
            let normal = a.cross(&b);
            let square = normal.norm_squared();
            if square <= 1e-20 * a.norm_squared() * b.norm_squared() {
                return None;
            }
            [b.cross(&normal) / square, normal.cross(&a) / square, Vector::zeros()]
        }
        [a, b, c] => {
            let determinant = a.dot(&b.cross(&c));
            if determinant.abs() <= 1e-10 * a.norm() * b.norm() * c.norm() {
                return None;
            }
            [b.cross(&c) / determinant, c.cross(&a) / determinant, a.cross(&b) / determinant]
        }
        _ => return None,
    };
    rows.iter().all(|r| r.iter().all(|x| x.is_finite())).then_some(rows)
}
