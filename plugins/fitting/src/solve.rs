//! Spline equations solved with a check: the answer, its condition, and an error instead of noise.

use loftsman_kernel::spline::Space;

use crate::banded::{Qr, Stencils};
use crate::error::{FitError, Result};

/// Above this condition the answer may have no correct digit left.
const SINGULAR: f64 = 0.01 / f64::EPSILON;

/// A solution and how far it can be trusted.
#[derive(Debug)]
pub(crate) struct Solution {
    /// `sides` numbers a vertex.
    pub(crate) vertices: Vec<f64>,
    /// Estimate of the condition number of the equations.
    pub(crate) condition: f64,
}

/// Factors, with the condition checked.
///
/// # Errors
/// [`FitError::IllConditioned`] with `advice` where the equations are singular to working precision.
pub(crate) fn factor(
    space: &Space,
    matrix: &Stencils,
    weights: Option<&[f64]>,
    rhs: &[f64],
    sides: usize,
    advice: &'static str,
) -> Result<(Qr, f64)> {
    let qr = Qr::factor(matrix, weights, rhs, sides);
    let condition = qr.condition();
    if condition < SINGULAR {
        return Ok((qr, condition));
    }
    Err(FitError::IllConditioned { condition, near: space.greville(qr.weakest()), advice })
}

/// Factors and solves.
///
/// # Errors
/// As for [`factor`].
pub(crate) fn solve(
    space: &Space,
    matrix: &Stencils,
    weights: Option<&[f64]>,
    rhs: &[f64],
    sides: usize,
    advice: &'static str,
) -> Result<Solution> {
    let (qr, condition) = factor(space, matrix, weights, rhs, sides, advice)?;
    Ok(Solution { vertices: qr.solve(), condition })
}

/// The largest `‖A x - b‖` over rows, and the sum of its squares: each row a vector of three numbers.
pub(crate) fn residual(matrix: &Stencils, x: &[f64], rhs: &[f64]) -> (f64, f64) {
    let (mut largest, mut sum) = (0.0_f64, 0.0);
    for (r, wanted) in rhs.as_chunks::<3>().0.iter().enumerate().take(matrix.len()) {
        let value = matrix.point(r, x);
        let square: f64 = value.iter().zip(wanted).map(|(v, w)| (v - w) * (v - w)).sum();
        largest = largest.max(square);
        sum += square;
    }
    (largest.sqrt(), sum)
}
