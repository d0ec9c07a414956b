//! Where two pieces come nearest, from a start: Gauss–Newton on the difference of their points, within their ends.

use loftsman_kernel::Vector;

use crate::net::{Jet, Piece};

/// A pair of pieces: a curve's, and one of a curve or a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub(crate) a: &'a Piece,
    pub(crate) b: &'a Piece,
}

/// A place of a pair: local parameters `(t; u, v)`, and how far apart the two points are there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) at: [f64; 3],
    pub(crate) distance: f64,
}

impl Pair<'_> {
    pub(crate) fn unknowns(&self) -> usize {
        1 + self.b.parameters()
    }

    /// The difference of the two points and its derivatives.
    pub(crate) fn difference(&self, at: [f64; 3]) -> (Vector, [Vector; 3], [Jet; 2]) {
        let (a, b) = (self.a.jet([at[0], 0.0]), self.b.jet([at[1], at[2]]));
        (a.point - b.point, [a.along[0], -b.along[0], -b.along[1]], [a, b])
    }

    /// The nearest that is found from a start, with `held` first unknowns left as they are. Steps are damped
    /// (Levenberg and Marquardt) and an unknown at its end that would leave stays there.
    pub(crate) fn nearest(&self, start: [f64; 3], held: usize) -> Spot {
        let n = self.unknowns();
        let mut at = start;
        let (mut r, mut j, _) = self.difference(at);
        let mut damping = 0.0;
        for _ in 0..60 {
            let mut free = [false; 3];
            for k in held..n {
                let slope = r.dot(&j[k]);
                // What moves nothing, as the angle at a pole, is left alone.
                free[k] =
                    j[k].norm() > 0.0 && !((at[k] <= 0.0 && slope > 0.0) || (at[k] >= 1.0 && slope < 0.0));
            }
            let Some(step) = step(&r, &j, free, damping) else {
                damping = if damping == 0.0 { 1e-10 } else { damping * 100.0 };
                if damping > 1e10 {
                    break;
                }
                continue;
            };
            let mut next = at;
            for k in 0..3 {
                if free[k] {
                    next[k] = (at[k] + step[k]).clamp(0.0, 1.0);
                }
            }
            let change = (0..3).map(|k| (next[k] - at[k]).abs()).fold(0.0, f64::max);
            let (r2, j2, _) = self.difference(next);
            if r2.norm() < r.norm() {
                (at, r, j) = (next, r2, j2);
                damping *= 0.1;
                if damping < 1e-12 {
                    damping = 0.0;
                }
            } else if change <= 1e-15 {
                break;
            } else {
                damping = if damping == 0.0 { 1e-6 } else { damping * 10.0 };
                if damping > 1e10 {
                    break;
                }
            }
            if r.norm() == 0.0 {
                break;
            }
        }
        Spot { at, distance: r.norm() }
    }
}

/// A start for a place of the first piece: the best of a few places of the other.
pub(crate) fn coarse(pair: &Pair<'_>, t: f64) -> [f64; 3] {
    let count = |order: usize| if order == 1 { 1 } else { 2 * order.min(6) };
    let point = pair.a.jet([t, 0.0]).point;
    let (rows, columns) = (count(pair.b.orders[0]), count(pair.b.orders[1]));
    let local = |k: usize, n: usize| if n == 1 { 0.0 } else { k as f64 / (n - 1) as f64 };
    let mut best = (f64::INFINITY, [t, 0.5, 0.5]);
    for i in 0..rows {
        for j in 0..columns {
            let at = [local(i, rows), local(j, columns)];
            let distance = (pair.b.jet(at).point - point).norm();
            if distance < best.0 {
                best = (distance, [t, at[0], at[1]]);
            }
        }
    }
    best.1
}

/// `-(JᵀJ + λ diag)⁻¹ Jᵀr` over the free unknowns, by elimination; `None` where that is singular.
fn step(r: &Vector, j: &[Vector; 3], free: [bool; 3], damping: f64) -> Option<[f64; 3]> {
    let index: Vec<usize> = (0..3).filter(|&k| free[k]).collect();
    let n = index.len();
    // The columns are made as long as one another first: parameters have no common unit.
    let scale: Vec<f64> = index.iter().map(|&k| j[k].norm()).collect();
    if n == 0 || scale.contains(&0.0) {
        return None;
    }
    let mut q = [Vector::zeros(); 3];
    let mut upper = [[0.0; 3]; 3];
    let mut right = [0.0; 3];
    let mut out = [0.0; 3];
    if damping == 0.0 {
        // Orthogonal: the condition is not squared.
        let mut rest = -*r;
        for c in 0..n {
            let mut column = j[index[c]] / scale[c];
            for k in 0..c {
                upper[k][c] = q[k].dot(&column);
                column -= q[k] * upper[k][c];
            }
            upper[c][c] = column.norm();
            if upper[c][c] < 1e-12 {
                return None;
            }
            q[c] = column / upper[c][c];
            right[c] = q[c].dot(&rest);
            rest -= q[c] * right[c];
        }
        for c in (0..n).rev() {
            let known: f64 = (c + 1..n).map(|k| upper[c][k] * out[index[k]]).sum();
            out[index[c]] = (right[c] - known) / upper[c][c];
        }
    } else {
        for c in 0..n {
            for k in 0..n {
                upper[c][k] = j[index[c]].dot(&j[index[k]]) / (scale[c] * scale[k]);
            }
            upper[c][c] += damping;
            right[c] = -r.dot(&j[index[c]]) / scale[c];
        }
        for c in 0..n {
            for k in c + 1..n {
                let factor = upper[k][c] / upper[c][c];
                for l in c..n {
                    upper[k][l] -= factor * upper[c][l];
                }
                right[k] -= factor * right[c];
            }
        }
        for c in (0..n).rev() {
            let known: f64 = (c + 1..n).map(|k| upper[c][k] * out[index[k]]).sum();
            out[index[c]] = (right[c] - known) / upper[c][c];
        }
    }
    for c in 0..n {
        out[index[c]] /= scale[c];
    }
    out.iter().all(|x| x.is_finite()).then_some(out)
}
