//! Polynomials of one variable by their Bernstein coefficients on `[0, 1]`.

use loftsman_kernel::error::MAX_DEGREE;

/// A polynomial.
#[derive(Debug, Clone)]
pub(crate) struct Polynomial(Vec<f64>);

impl Polynomial {
    pub(crate) fn new(coefficients: Vec<f64>) -> Self {
        Self(coefficients)
    }

    pub(crate) fn coefficients(&self) -> &[f64] {
        &self.0
    }

    pub(crate) fn first(&self) -> f64 {
        self.0.first().copied().unwrap_or(0.0)
    }

    pub(crate) fn last(&self) -> f64 {
        self.0.last().copied().unwrap_or(0.0)
    }

    /// The value.
    pub(crate) fn value(&self, t: f64) -> f64 {
        value(self.0.iter().copied(), t)
    }

    /// Whether the coefficients run one way, and with them the values.
    pub(crate) fn is_monotone(&self) -> bool {
        self.0.windows(2).all(|w| w[0] < w[1]) || self.0.windows(2).all(|w| w[0] > w[1])
    }

    /// Whether all coefficients are on one side of 0.
    pub(crate) fn has_one_sign(&self) -> bool {
        self.0.iter().all(|c| *c > 0.0) || self.0.iter().all(|c| *c < 0.0)
    }

    pub(crate) fn halves(&self) -> [Self; 2] {
        let (mut left, mut right) = (self.0.clone(), self.0.clone());
        for r in 1..left.len() {
            for i in 0..right.len() - r {
                right[i] = 0.5 * right[i] + 0.5 * right[i + 1];
            }
            left[r] = right[0];
        }
        [Self(left), Self(right)]
    }
}

/// The value of the polynomial with these coefficients (de Casteljau). Allocates nothing for shapes' own degrees.
pub(crate) fn value(coefficients: impl ExactSizeIterator<Item = f64>, t: f64) -> f64 {
    let count = coefficients.len();
    if count > MAX_DEGREE + 1 {
        return casteljau(&mut coefficients.collect::<Vec<_>>(), t);
    }
    let mut room = [0.0; MAX_DEGREE + 1];
    room.iter_mut().zip(coefficients).for_each(|(to, c)| *to = c);
    casteljau(&mut room[..count], t)
}

fn casteljau(c: &mut [f64], t: f64) -> f64 {
    for r in 1..c.len() {
        for i in 0..c.len() - r {
            c[i] = (1.0 - t) * c[i] + t * c[i + 1];
        }
    }
    c.first().copied().unwrap_or(0.0)
}

/// The root of a polynomial with ends of different signs, or an end that is 0: bisection with secants (Illinois).
pub(crate) fn root(f: &Polynomial) -> f64 {
    let (mut a, mut b, mut fa, mut fb) = (0.0, 1.0, f.first(), f.last());
    if fa == 0.0 {
        return a;
    }
    if fb == 0.0 {
        return b;
    }
    for k in 0..200 {
        let secant = (a * fb - b * fa) / (fb - fa);
        let middle = 0.5 * (a + b);
        let x = if k % 4 == 3 || !(secant > a && secant < b) { middle } else { secant };
        if x <= a || x >= b || b - a <= f64::EPSILON * b {
            break;
        }
        let fx = f.value(x);
        if fx == 0.0 {
            return x;
        }
        if (fx < 0.0) == (fa < 0.0) {
            (a, fa) = (x, fx);
            fb *= 0.5;
        } else {
            (b, fb) = (x, fx);
            fa *= 0.5;
        }
    }
    if f.value(a).abs() <= f.value(b).abs() { a } else { b }
}
