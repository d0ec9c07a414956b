//! Bases of small spaces, by orthogonalization with pivots: nothing here divides by what may vanish, and every loop is bounded.

/// Sweeps of Jacobi's method; it converges quadratically, and ten are plenty for any size.
const SWEEPS: usize = 30;

/// `a · b`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a ← a + s b`.
pub(crate) fn add(a: &mut [f64], s: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += s * b);
}

/// An orthonormal basis of the span of some vectors: Gram and Schmidt's process, the vector of which most is left first, each
/// taken out twice (Giraud, Langou, Rozložník 2005: twice is enough). What is left of a vector counts as nothing below
/// `least`; so does what is not finite. `O(rank · vectors · size)`.
pub(crate) fn span(mut vectors: Vec<Vec<f64>>, least: f64) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    loop {
        let longest = vectors
            .iter()
            .enumerate()
            .map(|(i, v)| (i, dot(v, v).sqrt()))
            .filter(|(_, norm)| norm.is_finite() && *norm > least)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, norm)) = longest else { return basis };
        let mut next = vectors.swap_remove(i);
        next.iter_mut().for_each(|x| *x /= norm);
        for b in &basis {
            let share = dot(b, &next);
            add(&mut next, -share, b);
        }
        let norm = dot(&next, &next).sqrt();
        // Most of it was rounding after all.
        if norm < 0.5 {
            continue;
        }
        next.iter_mut().for_each(|x| *x /= norm);
        for v in &mut vectors {
            let share = dot(&next, v);
            add(v, -share, &next);
        }
        basis.push(next);
    }
}

/// An orthonormal basis of all that is orthogonal to an orthonormal basis. `O(size³)`.
pub(crate) fn complement(basis: &[Vec<f64>], size: usize) -> Vec<Vec<f64>> {
    let units = (0..size).map(|i| {
        let mut unit = vec![0.0; size];
        unit[i] = 1.0;
        for b in basis {
            add(&mut unit, -b[i], b);
        }
        unit
    });
    // Some unit vector keeps at least this much of its length, however many directions are left.
    let mut rest = span(units.collect(), 0.1 / (size.max(1) as f64).sqrt());
    rest.truncate(size.saturating_sub(basis.len()));
    rest
}

/// The eigenvectors of a small symmetric matrix, one after another, by Jacobi's rotations. `O(size³)` a sweep.
pub(crate) fn eigenvectors(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = matrix.len();
    let mut vectors: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let mut unit = vec![0.0; n];
            unit[i] = 1.0;
            unit
        })
        .collect();
    for _ in 0..SWEEPS {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let (a, b, c) = (matrix[p][p], matrix[q][q], matrix[p][q]);
                if !(c.abs() > f64::EPSILON * (a.abs() * b.abs()).sqrt() && c.is_finite()) || c == 0.0 {
                    continue;
                }
                turned = true;
                let theta = 0.5 * (b - a) / c;
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let t = if theta == 0.0 { 1.0 } else { t };
                let cos = 1.0 / t.hypot(1.0);
                let sin = t * cos;
                for row in &mut matrix {
                    (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
                }
                let (upper, lower) = matrix.split_at_mut(q);
                for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
                    (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
                }
                let (upper, lower) = vectors.split_at_mut(q);
                for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
                    (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
                }
            }
        }
        if !turned {
            break;
        }
    }
    vectors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_vanishing_and_infinite_vectors_do_no_harm() {
        let vectors = vec![
            vec![0.0, 0.0, 0.0],
            vec![1.0, 2.0, 2.0],
            vec![2.0, 4.0, 4.0],
            vec![f64::NAN, 0.0, 1.0],
            vec![1e-15, 0.0, 0.0],
            vec![0.0, 1.0, -1.0],
        ];
        let basis = span(vectors, 1e-11);
        assert_eq!(basis.len(), 2);
        let rest = complement(&basis, 3);
        assert_eq!(rest.len(), 1);
        for b in &basis {
            assert!(dot(b, &rest[0]).abs() < 1e-15 && (dot(b, b) - 1.0).abs() < 1e-15);
        }
        assert_eq!(complement(&[], 4).len(), 4);
        assert!(complement(&complement(&[], 4), 4).is_empty());
    }

    #[test]
    fn eigenvectors_make_the_matrix_diagonal() {
        let n = 7;
        let entry = |i: usize, j: usize| ((i * j) as f64).cos() + if i == j { i as f64 } else { 0.0 };
        let matrix: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        let vectors = eigenvectors(matrix.clone());
        for (i, v) in vectors.iter().enumerate() {
            let image: Vec<f64> = matrix.iter().map(|row| dot(row, v)).collect();
            for (j, w) in vectors.iter().enumerate() {
                assert!((dot(v, w) - f64::from(u8::from(i == j))).abs() < 1e-14);
                assert!(i == j || dot(w, &image).abs() < 1e-13);
            }
        }
        assert_eq!(eigenvectors(vec![vec![0.0; 2]; 2]).len(), 2);
        assert_eq!(eigenvectors(vec![vec![f64::NAN; 2]; 2]).len(), 2);
    }
}
