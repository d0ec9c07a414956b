//! W2: a grid on a rational bicubic surface.

use crate::inputs::{cubic, cubic_slope};

/// Points and unit normals at `at × at` on a rational bicubic with the same clamped knots `u` and `v` of single interior
/// knots and the net `[x, y, z, w]`: one row of vertices is summed for each `u`, then four of them a point.
pub fn grid(u: &[f64], v: &[f64], net: &[[f64; 4]], at: &[f64], out: &mut [[[f64; 3]; 2]]) {
    let (rows, columns) = (u.len() - 4, v.len() - 4);
    let homogeneous: Vec<[f64; 4]> =
        net.iter().map(|p| [p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3]]).collect();
    let span = |t: &[f64], n: usize, u: f64| t[4..n].partition_point(|&k| k <= u) + 3;
    let basis: Vec<(usize, [f64; 4], [f64; 4])> = at
        .iter()
        .map(|&x| {
            let s = span(v, columns, x);
            (s - 3, cubic(v, s, x), cubic_slope(v, s, x))
        })
        .collect();
    let mut lines = vec![[[0.0; 4]; 2]; columns];
    for (&x, out) in at.iter().zip(out.chunks_exact_mut(at.len())) {
        let s = span(u, rows, x);
        let (value, slope) = (cubic(u, s, x), cubic_slope(u, s, x));
        for (j, line) in lines.iter_mut().enumerate() {
            *line = [[0.0; 4]; 2];
            for k in 0..4 {
                let h = &homogeneous[(s - 3 + k) * columns + j];
                for q in 0..4 {
                    line[0][q] += value[k] * h[q];
                    line[1][q] += slope[k] * h[q];
                }
            }
        }
        for ((first, value, slope), out) in basis.iter().zip(out) {
            let mut jet = [[0.0; 4]; 3];
            for (k, line) in lines[*first..*first + 4].iter().enumerate() {
                for q in 0..4 {
                    jet[0][q] += value[k] * line[0][q];
                    jet[1][q] += value[k] * line[1][q];
                    jet[2][q] += slope[k] * line[0][q];
                }
            }
            let over = 1.0 / jet[0][3];
            let p = [jet[0][0] * over, jet[0][1] * over, jet[0][2] * over];
            let part = |d: &[f64; 4]| [d[0] - p[0] * d[3], d[1] - p[1] * d[3], d[2] - p[2] * d[3]];
            let (a, b) = (part(&jet[1]), part(&jet[2]));
            let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let over = 1.0 / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            *out = [p, n.map(|c| c * over)];
        }
    }
}
