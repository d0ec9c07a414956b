//! Cholesky factors of small dense matrices whose rows may depend on one another.

/// A row depends on those before it where this share of its diagonal entry is left, or less. The matrix is one of products
/// `l_i · l_j`: rows that differ by an angle of less than the root of this count as one.
const DEPENDENT: f64 = 1e-13;

/// `A = L Lᵀ` of a positive semidefinite matrix, the lower triangle row after row in place: the diagonal of `L` as its reciprocal,
/// zero in rows that depend on those before them, which take no part. The number of those that take part. `O(n³/3)`.
pub(super) fn factor(a: &mut [f64], n: usize) -> usize {
    let mut rank = 0;
    for i in 0..n {
        let (done, rest) = a.split_at_mut(i * n);
        let row = &mut rest[..=i];
        let whole = row[i];
        let mut diagonal = whole;
        for j in 0..i {
            let other = &done[j * n..=j * n + j];
            let products: f64 = row[..j].iter().zip(other).map(|(a, b)| a * b).sum();
            let value = (row[j] - products) * other[j];
            row[j] = value;
            diagonal -= value * value;
        }
        if diagonal > DEPENDENT * whole && diagonal.is_finite() {
            row[i] = 1.0 / diagonal.sqrt();
            rank += 1;
        } else {
            row.fill(0.0);
        }
    }
    rank
}

/// `x ← L⁻¹ x`, `sides` entries a row; zero in rows that take no part.
pub(super) fn forward(l: &[f64], n: usize, x: &mut [f64], sides: usize) {
    for i in 0..n {
        let (before, rest) = x.split_at_mut(i * sides);
        let own = &mut rest[..sides];
        let row = &l[i * n..=i * n + i];
        for (a, x) in row[..i].iter().zip(before.chunks_exact(sides)) {
            own.iter_mut().zip(x).for_each(|(own, x)| *own -= a * x);
        }
        own.iter_mut().for_each(|own| *own *= row[i]);
    }
}

/// `x ← L⁻ᵀ x`, `sides` entries a row; zero in rows that take no part.
pub(super) fn backward(l: &[f64], n: usize, x: &mut [f64], sides: usize) {
    for i in (0..n).rev() {
        let (before, rest) = x.split_at_mut(i * sides);
        let own = &mut rest[..sides];
        let row = &l[i * n..=i * n + i];
        own.iter_mut().for_each(|own| *own *= row[i]);
        for (a, x) in row[..i].iter().zip(before.chunks_exact_mut(sides)) {
            x.iter_mut().zip(&*own).for_each(|(x, own)| *x -= a * own);
        }
    }
}
