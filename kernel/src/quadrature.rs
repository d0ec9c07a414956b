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

/// Binomial coefficient `C(n, k)` as a float; exact for the degrees in use (`n ≤ 50`).
pub(crate) fn binomial(n: usize, k: usize) -> f64 {
    let k = k.min(n - k.min(n));
    let mut result = 1.0;
    for i in 0..k {
        result = result * (n - i) as f64 / (i + 1) as f64;
    }
    result.round()
}
