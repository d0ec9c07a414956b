//! Uniform B-splines over one span.

/// The three uniform quadratic B-splines over `[0, 1]`, or their derivatives.
pub(crate) fn quadratic(x: f64, order: usize) -> [f64; 3] {
    let y = 1.0 - x;
    match order {
        0 => [0.5 * y * y, 0.5 + x * y, 0.5 * x * x],
        1 => [-y, 1.0 - 2.0 * x, x],
        2 => [1.0, -2.0, 1.0],
        _ => [0.0; 3],
    }
}

/// The four uniform cubic B-splines over `[0, 1]`, or their derivatives.
pub(crate) fn cubic(x: f64, order: usize) -> [f64; 4] {
    let y = 1.0 - x;
    match order {
        0 => [
            y * y * y / 6.0,
            (4.0 - 3.0 * x * x * (1.0 + y)) / 6.0,
            (4.0 - 3.0 * y * y * (1.0 + x)) / 6.0,
            x * x * x / 6.0,
        ],
        1 => [-0.5 * y * y, 0.5 * x * (3.0 * x - 4.0), -0.5 * y * (3.0 * y - 4.0), 0.5 * x * x],
        2 => [y, 3.0 * x - 2.0, 3.0 * y - 2.0, x],
        3 => [-1.0, 3.0, -3.0, 1.0],
        _ => [0.0; 4],
    }
}
