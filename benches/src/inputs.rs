//! The inputs of the workloads. The formulas are the definition, so that programs in other languages can take the
//! same ones.

use std::collections::HashMap;

/// `u_k` in `[0, 1)`: `x ← (1664525 x + 1013904223) mod 2³²`, `u = x / 2³²`, the first value after one step.
pub fn sequence(seed: u32, count: usize) -> Vec<f64> {
    let mut x = seed;
    (0..count)
        .map(|_| {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(x) / 4_294_967_296.0
        })
        .collect()
}

/// Clamped knots of `n` vertices on `[0, 1]`: `n - p` spans of lengths `0.5 + u_k`, divided by their sum.
pub fn knots(n: usize, p: usize, seed: u32) -> Vec<f64> {
    let mut inner = vec![0.0];
    let mut at = 0.0;
    for u in sequence(seed, n - p) {
        at += 0.5 + u;
        inner.push(at);
    }
    inner.iter_mut().for_each(|t| *t /= at);
    let mut knots = vec![0.0; p];
    knots.extend(inner);
    knots.extend(vec![1.0; p]);
    knots
}

/// A wavy coil of `n` control vertices.
pub fn coil(n: usize) -> Vec<[f64; 3]> {
    (0..n)
        .map(|i| {
            let i = i as f64;
            let r = 1.0 + 0.3 * (0.31 * i).sin();
            [(0.05 * i).cos() * r, (0.05 * i).sin() * r, 0.01 * i]
        })
        .collect()
}

/// W2: the net of a wavy rational sheet of `n × n` vertices, row after row: `x, y, z` and the weight.
pub fn sheet(n: usize) -> Vec<[f64; 4]> {
    let last = (n - 1) as f64;
    let at = |k: usize| ((k / n) as f64, (k % n) as f64);
    let vertex = |(i, j): (f64, f64)| {
        let z = 0.1 * (0.7 * i).sin() * (0.5 * j).cos();
        [i / last, j / last, z, 1.0 + 0.5 * (0.9 * i + 1.3 * j).sin()]
    };
    (0..n * n).map(at).map(vertex).collect()
}

/// `(k + ½) / m`.
pub fn parameters(m: usize) -> Vec<f64> {
    (0..m).map(|k| (k as f64 + 0.5) / m as f64).collect()
}

/// W4: `c` rows of four entries on a cubic of `n` vertices at `t_k = (k + 0.37) / c`: for even `k` the value, for odd
/// `k` the derivative divided by `n - 3`.
#[derive(Debug, Clone)]
pub struct Rows {
    /// Vertices of the curve.
    pub n: usize,
    /// The knots.
    pub knots: Vec<f64>,
    /// The location of each row.
    pub at: Vec<f64>,
    /// The first column of each row.
    pub first: Vec<usize>,
    /// Its four entries.
    pub values: Vec<[f64; 4]>,
}

impl Rows {
    /// The rows of `c` constraints on `n` vertices.
    pub fn new(n: usize, c: usize) -> Self {
        let knots = knots(n, 3, 4);
        let at: Vec<f64> = (0..c).map(|k| (k as f64 + 0.37) / c as f64).collect();
        let (mut first, mut values) = (Vec::new(), Vec::new());
        for (k, &u) in at.iter().enumerate() {
            let span = knots[..=n].partition_point(|&t| t <= u).clamp(4, n) - 1;
            first.push(span - 3);
            values.push(if k % 2 == 0 {
                cubic(&knots, span, u)
            } else {
                cubic_slope(&knots, span, u).map(|d| d / (n - 3) as f64)
            });
        }
        Self { n, knots, at, first, values }
    }

    /// How many rows there are.
    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// The right-hand side of drag event `drag`.
    pub fn wanted(&self, drag: usize) -> Vec<[f64; 3]> {
        let turn = 0.01 * drag as f64;
        (0..self.count())
            .map(|k| {
                let k = k as f64;
                [(k + 1.0 + turn).sin(), (2.0 * k + turn).cos(), 0.5 * (3.0 * k + turn).sin()]
            })
            .collect()
    }
}

/// The four cubic basis functions that do not vanish in `[t[span], t[span + 1])`.
pub fn cubic(t: &[f64], span: usize, u: f64) -> [f64; 4] {
    let quadratic = quadratic(t, span, u);
    let mut row = [0.0; 4];
    for (j, value) in quadratic.into_iter().enumerate() {
        let (left, right) = (t[span + j - 2], t[span + j + 1]);
        row[j] += (right - u) / (right - left) * value;
        row[j + 1] += (u - left) / (right - left) * value;
    }
    row
}

/// Their first derivatives.
pub fn cubic_slope(t: &[f64], span: usize, u: f64) -> [f64; 4] {
    let mut row = [0.0; 4];
    for (j, value) in quadratic(t, span, u).into_iter().enumerate() {
        let share = 3.0 * value / (t[span + j + 1] - t[span + j - 2]);
        row[j] -= share;
        row[j + 1] += share;
    }
    row
}

fn quadratic(t: &[f64], s: usize, u: f64) -> [f64; 3] {
    let a = (u - t[s]) / (t[s + 1] - t[s]);
    let left = (t[s + 1] - u) / (t[s + 1] - t[s - 1]);
    let right = (u - t[s]) / (t[s + 2] - t[s]);
    [(1.0 - a) * left, (1.0 - a) * (1.0 - left) + a * (1.0 - right), a * right]
}

/// The skin of a cube of cells with a square hole through it, as `peers/opensubdiv.cpp` has it: vertices of valence 3, 4 and 5.
pub fn lattice(cells: i32, hole: std::ops::Range<i32>) -> (Vec<[i32; 3]>, Vec<[usize; 4]>) {
    let there = |c: [i32; 3]| {
        c.iter().all(|x| (0..cells).contains(x)) && !(hole.contains(&c[0]) && hole.contains(&c[1]))
    };
    let (mut numbers, mut points, mut faces) = (HashMap::new(), Vec::new(), Vec::new());
    for number in 0..cells.pow(3) {
        let cell = [number / (cells * cells), number / cells % cells, number % cells];
        for (axis, plus) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beyond = cell;
            beyond[axis] += 2 * plus - 1;
            if !there(cell) || there(beyond) {
                continue;
            }
            let first = (axis + if plus == 1 { 1 } else { 2 }) % 3;
            let second = (axis + if plus == 1 { 2 } else { 1 }) % 3;
            faces.push(std::array::from_fn(|corner| {
                let mut p = cell;
                p[axis] += plus;
                p[first] += i32::from(corner == 1 || corner == 2);
                p[second] += i32::from(corner >= 2);
                *numbers.entry(p).or_insert_with(|| {
                    points.push(p);
                    points.len() - 1
                })
            }));
        }
    }
    (points, faces)
}

/// Places of a lattice, in a cube of edge 1.
pub fn scaled(points: &[[i32; 3]], cells: i32) -> impl Iterator<Item = [f64; 3]> {
    points.iter().map(move |p| p.map(|x| f64::from(x) / f64::from(cells)))
}
