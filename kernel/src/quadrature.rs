//! Nodes and weights, and the numbers that go with polynomials.

/// Nodes and weights of Gauss–Legendre quadrature on `[0, 1]` with `n` points: exact to degree `2n - 1`. Newton's
/// iteration on the Legendre polynomial from the asymptotic guess of its zeros (Abramowitz and Stegun, 22.16.6).
pub fn gauss_legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut nodes, mut weights) = (vec![0.5; n], vec![1.0; n]);
    for i in 0..n {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut value, mut before) = (1.0, 0.0);
            for k in 0..n {
                let next = ((2 * k + 1) as f64 * x * value - k as f64 * before) / (k + 1) as f64;
                (before, value) = (value, next);
            }
            slope = n as f64 * (x * value - before) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() <= 2.0 * f64::EPSILON {
                break;
            }
        }
        nodes[i] = 0.5 * (1.0 - x);
        weights[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    (nodes, weights)
}

/// Nodes and weights of Gauss–Lobatto quadrature on `[0, 1]` with `n ≥ 2` points, both ends among them: exact to degree `2n - 3`. The inner nodes are
/// the zeros of the derivative of the Legendre polynomial of degree `n - 1`, by Newton's iteration from those of Chebyshev's (Abramowitz and
/// Stegun, 25.4.32). Of `n < 2` as of 2.
pub fn gauss_lobatto(n: usize) -> (Vec<f64>, Vec<f64>) {
    let n = n.max(2);
    let last = n - 1;
    let (mut nodes, mut weights) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let mut x = (std::f64::consts::PI * i as f64 / last as f64).cos();
        let mut value = 1.0;
        for _ in 0..100 {
            let mut before = 1.0;
            value = x;
            for k in 1..last {
                let next = ((2 * k + 1) as f64 * x * value - k as f64 * before) / (k + 1) as f64;
                (before, value) = (value, next);
            }
            // `(x² - 1) P' = m (x P - Q)` for the one before, `Q`, and `((x² - 1) P')' = m (m + 1) P`.
            let step = (x * value - before) / (n as f64 * value);
            x -= step;
            if step.abs() <= 2.0 * f64::EPSILON {
                break;
            }
        }
        nodes[i] = 0.5 * (1.0 - x);
        weights[i] = 1.0 / ((n * last) as f64 * value * value);
    }
    // Exactly the ends.
    (nodes[0], nodes[last]) = (0.0, 1.0);
    (nodes, weights)
}

/// Binomial coefficient `C(n, k)` as a float; exact for the degrees in use (`n ≤ 50`).
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    let k = k.min(n - k.min(n));
    let mut result = 1.0;
    for i in 0..k {
        result = result * (n - i) as f64 / (i + 1) as f64;
    }
    result.round()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ x^k = 1/(k + 1)`, to the degree to which each rule is exact, and no farther.
    #[test]
    fn both_rules_are_exact_as_far_as_they_say() {
        let of = |rule: &(Vec<f64>, Vec<f64>), k: i32| -> f64 {
            rule.0.iter().zip(&rule.1).map(|(x, w)| w * x.powi(k)).sum()
        };
        for n in 1..40_usize {
            let rules = [(gauss_legendre(n), 2 * n as i32 - 1), (gauss_lobatto(n + 1), 2 * n as i32 - 1)];
            for (rule, exact) in rules {
                for k in 0..=exact {
                    let off = of(&rule, k) * f64::from(k + 1) - 1.0;
                    assert!(off.abs() < 1e-13, "{n} {k}: {off}");
                }
                if n < 8 {
                    assert!((of(&rule, exact + 1) * f64::from(exact + 2) - 1.0).abs() > 1e-10, "{n}");
                }
            }
        }
        let (nodes, weights) = gauss_lobatto(4);
        assert!((nodes[1] - 0.5 * (1.0 - 0.2_f64.sqrt())).abs() < 1e-15 && nodes[3] == 1.0);
        assert!((weights[0] - 1.0 / 12.0).abs() < 1e-15 && (weights[2] - 5.0 / 12.0).abs() < 1e-15);
    }
}
