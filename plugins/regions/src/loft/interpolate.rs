//! Numbers given at sections, interpolated across them by a spline.

use loftsman_kernel::Result;
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

/// The collocation matrix `B_kj = N_j(v_k)` of as many sites as a space has functions, factored.
///
/// Such a matrix is totally positive, so that Gaussian elimination *without* pivoting loses nothing: no number in it ever
/// grows (de Boor and Pinkus 1977, *Backward error analysis for totally positive linear systems*). Normal equations would
/// square its condition, which grows as `2^p`: at degree 25 nothing would be left. Banded, `O(n p²)`; `O(n p)` a
/// right-hand side.
#[derive(Debug)]
pub(super) struct Collocation {
    n: usize,
    half: usize,
    /// Row `i` has columns `i - half ..= i + half`; below the diagonal the factors of the elimination.
    band: Vec<f64>,
}

impl Collocation {
    /// Nothing where a section is too near to another for the numbers to tell them apart.
    pub(super) fn new(space: &Space, sites: &[f64]) -> Result<Option<Self>> {
        let (n, half) = (sites.len(), space.degree());
        let width = 2 * half + 1;
        let mut new = Self { n, half, band: vec![0.0; n * width] };
        let mut row = [0.0; MAX_ORDER];
        for (k, &v) in sites.iter().enumerate() {
            let at = space.locate(v)?;
            let span = space.span(at);
            space.basis_into(span, at, 0, &mut row);
            for (j, &value) in row[..=half].iter().enumerate() {
                let column = span - half + j;
                if value != 0.0 {
                    let Some(place) = (column + half).checked_sub(k).filter(|&p| p < width) else {
                        return Ok(None);
                    };
                    new.band[k * width + place] = value;
                }
            }
        }
        for k in 0..n {
            let pivot = new.band[k * width + half];
            if pivot.is_nan() || pivot <= f64::EPSILON * f64::EPSILON {
                return Ok(None);
            }
            for i in k + 1..n.min(k + half + 1) {
                let below = i * width + half + k - i;
                let factor = new.band[below] / pivot;
                new.band[below] = factor;
                if factor != 0.0 {
                    for j in 1..=half.min(n - 1 - k) {
                        new.band[below + j] -= factor * new.band[k * width + half + j];
                    }
                }
            }
        }
        Ok(Some(new))
    }

    /// The coefficients of the values, in place: one for each site, `L` numbers each.
    pub(super) fn solve<const L: usize>(&self, values: &mut [[f64; L]]) {
        let (n, half, width) = (self.n, self.half, 2 * self.half + 1);
        for i in 0..n {
            for j in i.saturating_sub(half)..i {
                let factor = self.band[i * width + half + j - i];
                for a in 0..L {
                    values[i][a] -= factor * values[j][a];
                }
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n.min(i + half + 1) {
                let factor = self.band[i * width + half + j - i];
                for a in 0..L {
                    values[i][a] -= factor * values[j][a];
                }
            }
            let pivot = self.band[i * width + half];
            values[i].iter_mut().for_each(|x| *x /= pivot);
        }
    }
}

/// Clamped knots whose inner ones are means of `degree` parameters each (de Boor 1978, chapter XIII).
pub(super) fn averaged(v: &[f64], degree: usize) -> Vec<f64> {
    let mut knots = vec![0.0; degree + 1];
    knots.extend(v[1..v.len() - 1].windows(degree).map(|w| w.iter().sum::<f64>() / degree as f64));
    knots.extend(vec![1.0; degree + 1]);
    knots
}
