//! The few dense rows of a border: sums, and Cholesky's factor of their products.

/// A gradient whose part outside the span of the others, squared, is below this (of its own square) depends on them.
const DEPENDENT: f64 = 1e-11;

/// Four sums side by side: shorter chains of rounding, and of waiting.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a4, a1), (b4, b1)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a4.iter().zip(b4) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a1.iter().zip(b1).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

pub(super) fn add(to: &mut [f64], factor: f64, x: &[f64]) {
    for (to, x) in to.iter_mut().zip(x) {
        *to += factor * x;
    }
}

/// `S = L Lᵀ` in the lower triangle, the diagonal's reciprocal in its place; false where a pivot is not above its share of
/// `own`.
pub(super) fn cholesky(s: &mut [f64], m: usize, own: &[f64]) -> bool {
    for i in 0..m {
        for j in 0..=i {
            let products: f64 = (0..j).map(|k| s[i * m + k] * s[j * m + k]).sum();
            let value = s[i * m + j] - products;
            if i == j {
                // Written so that NaN fails too.
                if !(value > DEPENDENT * own[i] && value.is_finite()) {
                    return false;
                }
                s[i * m + i] = 1.0 / value.sqrt();
            } else {
                s[i * m + j] = value * s[j * m + j];
            }
        }
    }
    true
}

pub(super) fn solve(l: &[f64], m: usize, x: &mut [f64]) {
    for i in 0..m {
        let products: f64 = (0..i).map(|k| l[i * m + k] * x[k]).sum();
        x[i] = (x[i] - products) * l[i * m + i];
    }
    for i in (0..m).rev() {
        let products: f64 = (i + 1..m).map(|k| l[k * m + i] * x[k]).sum();
        x[i] = (x[i] - products) * l[i * m + i];
    }
}
