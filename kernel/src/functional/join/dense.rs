//! What a few dense rows span, and what they leave free.

/// A row whose part outside the span of the rows before it is shorter than this (of its own length) depends on them.
const DEPENDENT: f64 = 1e-12;

/// An orthonormal basis of all vectors of some width: first of those that rows span, then of those that are orthogonal
/// to all rows.
#[derive(Debug)]
pub(super) struct Split {
    rank: usize,
    basis: Vec<Vec<f64>>,
}

impl Split {
    /// Householder reflections from the right, rows pivoted, `S P A = [L 0] Q`; the rows of `Q` are the basis. Backward
    /// stable whatever the condition. `O(r w (n + w))` for `n` rows of width `w` and rank `r`; `None` where a number is
    /// not finite.
    pub(super) fn new(mut rows: Vec<Vec<f64>>, width: usize) -> Option<Self> {
        let norm = |row: &[f64]| row.iter().map(|v| v * v).sum::<f64>().sqrt();
        for row in &mut rows {
            let largest = row.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            if !largest.is_finite() || row.iter().any(|v| v.is_nan()) {
                return None;
            }
            if largest > 0.0 {
                row.iter_mut().for_each(|v| *v /= largest);
                let length = norm(row);
                row.iter_mut().for_each(|v| *v /= length);
            }
        }
        let mut reflections: Vec<Vec<f64>> = Vec::new();
        while reflections.len() < rows.len().min(width) {
            let k = reflections.len();
            let norms: Vec<f64> = rows[k..].iter().map(|row| norm(&row[k..])).collect();
            let largest = norms.iter().fold(0.0_f64, |a, b| a.max(*b));
            if largest <= DEPENDENT {
                break;
            }
            let pick = k + norms.iter().position(|&n| n >= largest).unwrap_or(0);
            rows.swap(k, pick);
            let mut v = rows[k][k..].to_vec();
            // The sign of v₀, so that nothing cancels.
            v[0] += norm(&v).copysign(v[0]);
            let length = norm(&v);
            v.iter_mut().for_each(|x| *x /= length);
            for row in &mut rows[k + 1..] {
                reflect(&v, &mut row[k..]);
            }
            reflections.push(v);
        }
        let basis = (0..width)
            .map(|k| {
                let mut vector = vec![0.0; width];
                vector[k] = 1.0;
                for (j, v) in reflections.iter().enumerate().rev() {
                    reflect(v, &mut vector[j..]);
                }
                vector
            })
            .collect();
        Some(Self { rank: reflections.len(), basis })
    }

    /// Orthonormal vectors that span the rows.
    pub(super) fn spanned(&self) -> &[Vec<f64>] {
        &self.basis[..self.rank]
    }

    /// Orthonormal vectors that are orthogonal to all rows: what the rows leave free.
    pub(super) fn free(&self) -> &[Vec<f64>] {
        &self.basis[self.rank..]
    }
}

/// `x ← (I - 2vvᵀ) x`.
fn reflect(v: &[f64], x: &mut [f64]) {
    let dot = 2.0 * v.iter().zip(&*x).map(|(a, b)| a * b).sum::<f64>();
    x.iter_mut().zip(v).for_each(|(x, v)| *x -= dot * v);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_and_divided_rightly() {
        let rows = vec![
            vec![1.0, 2.0, 0.0, -1.0, 3.0],
            vec![0.0; 5],
            vec![2.0, 4.0, 0.0, -2.0, 6.0],
            vec![0.0, 1e-9, 1e-9, 0.0, 0.0],
            vec![1.0, 3.0, 1.0, -1.0, 3.0],
            vec![0.0, 0.0, 1.0, 1.0, 0.0],
        ];
        let split = Split::new(rows.clone(), 5).unwrap();
        assert_eq!((split.rank, split.free().len()), (3, 2));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let all: Vec<&Vec<f64>> = split.spanned().iter().chain(split.free()).collect();
        for (i, a) in all.iter().enumerate() {
            for (j, b) in all.iter().enumerate() {
                assert!((dot(a, b) - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        for (row, free) in rows.iter().flat_map(|row| split.free().iter().map(move |free| (row, free))) {
            assert!(dot(row, free).abs() < 1e-14);
        }
        assert!(Split::new(vec![vec![f64::NAN, 1.0]], 2).is_none());
        assert!(Split::new(vec![vec![f64::INFINITY, 1.0]], 2).is_none());
        assert_eq!(Split::new(Vec::new(), 3).unwrap().free().len(), 3);
        assert_eq!(Split::new(vec![vec![1.0], vec![2.0]], 1).unwrap().spanned().len(), 1);
    }
}
