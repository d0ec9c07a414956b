//! B-splines by the book, and quadratic programs by a library: what fairing is measured with. Shares no code with the kernel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use loftsman_kernel::Point;
use loftsman_kernel::spline::Curve;

/// A curve's knots and weights, evaluated by de Boor's recursion.
pub(crate) struct Book {
    pub(crate) flat: Vec<f64>,
    pub(crate) degree: usize,
    pub(crate) count: usize,
    pub(crate) weights: Vec<f64>,
    pub(crate) domain: (f64, f64),
    /// How many vertices further back those of the basis functions are: closed curves begin `degree` earlier.
    shift: usize,
}

impl Book {
    pub(crate) fn new(curve: &Curve) -> Self {
        let (space, count) = (curve.space(), curve.points().len());
        let weights = curve.weights().map_or_else(|| vec![1.0; count], <[f64]>::to_vec);
        let flat = space.flat().to_vec();
        let degree = space.degree();
        let shift = if space.is_periodic() { (degree + 1) * count - degree } else { 0 };
        Self { flat, degree, count, weights, domain: curve.domain(), shift }
    }

    /// Every basis function of a degree, or one of its derivatives.
    fn basis(&self, degree: usize, u: f64, order: usize) -> Vec<f64> {
        let t = &self.flat;
        let all = t.len() - 1 - degree;
        if order > degree {
            return vec![0.0; all];
        }
        if degree == 0 {
            // Half-open spans, but for the end of the domain.
            let last = (0..t.len() - 1).rfind(|&i| t[i] < t[i + 1] && t[i] < self.domain.1);
            let at = match u >= self.domain.1 {
                true => last,
                false => (0..t.len() - 1).find(|&i| t[i] <= u && u < t[i + 1]),
            };
            let mut values = vec![0.0; all];
            if let Some(at) = at {
                values[at] = 1.0;
            }
            return values;
        }
        let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let (p, down) = (degree as f64, order.saturating_sub(1));
        let lower = self.basis(degree - 1, u, down);
        let each = (0..all).map(|i| {
            let (left, right) = (t[i + degree] - t[i], t[i + degree + 1] - t[i + 1]);
            if order > 0 {
                p * (part(lower[i], left) - part(lower[i + 1], right))
            } else {
                part((u - t[i]) * lower[i], left) + part((t[i + degree + 1] - u) * lower[i + 1], right)
            }
        });
        each.collect()
    }

    /// The coefficients of the control vertices in the derivative of an order.
    pub(crate) fn row(&self, u: f64, order: usize) -> Vec<f64> {
        let mut all: Vec<Vec<f64>> = Vec::new();
        let mut whole = Vec::new();
        for k in 0..=order {
            let mut row = vec![0.0; self.count];
            for (i, value) in self.basis(self.degree, u, k).into_iter().enumerate() {
                let vertex = (i + self.shift) % self.count;
                row[vertex] += value * self.weights[vertex];
            }
            whole.push(row.iter().sum::<f64>());
            if self.weights.iter().all(|w| *w == 1.0) {
                all.push(row);
                continue;
            }
            let mut choose = 1.0;
            for j in 1..=k {
                choose *= (k - j + 1) as f64 / j as f64;
                for (r, before) in row.iter_mut().zip(&all[k - j]) {
                    *r -= choose * whole[j] * before;
                }
            }
            row.iter_mut().for_each(|r| *r /= whole[0]);
            all.push(row);
        }
        all.swap_remove(order)
    }

    pub(crate) fn value(&self, points: &[Point], u: f64, order: usize, axis: usize) -> f64 {
        self.row(u, order).iter().zip(points).map(|(c, p)| c * p[axis]).sum()
    }

    /// Weighted rows whose squares sum to the integral of a squared derivative.
    pub(crate) fn integral(&self, order: usize) -> Vec<Vec<f64>> {
        // Gauss and Legendre, five nodes, on several parts of every span.
        const NODES: [(f64, f64); 5] = [
            (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let mut breaks: Vec<f64> =
            self.flat.iter().copied().filter(|t| *t >= self.domain.0 && *t <= self.domain.1).collect();
        breaks.extend([self.domain.0, self.domain.1]);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        let mut rows = Vec::new();
        for span in breaks.windows(2) {
            let parts = if self.weights.iter().all(|w| *w == 1.0) { 8 } else { 96 };
            let step = (span[1] - span[0]) / f64::from(parts);
            for part in 0..parts {
                for (x, w) in NODES {
                    let u = span[0] + step * (f64::from(part) + 0.5 + 0.5 * x);
                    let root = (0.5 * step * w).sqrt();
                    rows.push(self.row(u, order).iter().map(|c| c * root).collect());
                }
            }
        }
        rows
    }
}

/// `|A x - r|²` least for one axis, each row of `G x` equal to (the first `equations`) or not below its value. The least, or
/// `None` where the library does not arrive.
pub(crate) fn least(
    squares: &[(Vec<f64>, f64)],
    rows: &[(Vec<f64>, f64)],
    equations: usize,
    n: usize,
) -> Option<f64> {
    let mut p = vec![vec![0.0; n]; n];
    let (mut q, mut constant) = (vec![0.0; n], 0.0);
    for (a, r) in squares {
        for i in 0..n {
            for j in 0..n {
                p[i][j] += 2.0 * a[i] * a[j];
            }
            q[i] -= 2.0 * a[i] * r;
        }
        constant += r * r;
    }
    let scale = p.iter().flatten().fold(1e-300_f64, |m, v| m.max(v.abs()));
    p.iter_mut().flatten().for_each(|v| *v /= scale);
    q.iter_mut().for_each(|v| *v /= scale);
    let (_, found) = solve(&p, &q, rows, equations)?;
    found.map(|least| least * scale + constant)
}

/// By how much some row must be missed: 0 where all can hold. `rows` as for [`least`].
pub(crate) fn violation(rows: &[(Vec<f64>, f64)], equations: usize, n: usize) -> f64 {
    // x and t: t least, every row met to t.
    let mut all: Vec<(Vec<f64>, f64)> = Vec::new();
    for (k, (row, value)) in rows.iter().enumerate() {
        let length = row.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-12);
        let unit: Vec<f64> = row.iter().map(|c| c / length).collect();
        let with = |sign: f64| {
            let mut terms: Vec<f64> = unit.iter().map(|c| sign * c).collect();
            terms.push(1.0);
            (terms, sign * value / length)
        };
        all.push(with(1.0));
        if k < equations {
            all.push(with(-1.0));
        }
    }
    let mut floor = vec![0.0; n + 1];
    floor[n] = 1.0;
    all.push((floor, -1.0));
    let mut p = vec![vec![0.0; n + 1]; n + 1];
    (0..n).for_each(|i| p[i][i] = 1e-14);
    let mut q = vec![0.0; n + 1];
    q[n] = 1.0;
    match solve(&p, &q, &all, 0) {
        Some((x, Some(_))) => x[n].max(0.0),
        _ => f64::NAN,
    }
}

type Solution = (Vec<f64>, Option<f64>);

fn solve(p: &[Vec<f64>], q: &[f64], rows: &[(Vec<f64>, f64)], equations: usize) -> Option<Solution> {
    let n = q.len();
    let upper: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if j >= i { p[i][j] } else { 0.0 }).collect()).collect();
    let (mut ri, mut ci, mut vals) = (Vec::new(), Vec::new(), Vec::new());
    let mut b = Vec::new();
    for (k, (row, value)) in rows.iter().enumerate() {
        for (j, c) in row.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            ri.push(k);
            ci.push(j);
            vals.push(-c);
        }
        b.push(-value);
    }
    let a = CscMatrix::new_from_triplets(rows.len(), n, ri, ci, vals);
    let (mut ri, mut ci, mut vals) = (Vec::new(), Vec::new(), Vec::new());
    for (i, row) in upper.iter().enumerate() {
        for (j, v) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            ri.push(i);
            ci.push(j);
            vals.push(*v);
        }
    }
    let p = CscMatrix::new_from_triplets(n, n, ri, ci, vals);
    let cones = [ZeroConeT(equations), NonnegativeConeT(rows.len() - equations)];
    let settings = DefaultSettingsBuilder::default().verbose(false).build().ok()?;
    let mut solver = DefaultSolver::new(&p, q, &a, &b, &cones, settings).ok()?;
    solver.solve();
    let good = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    Some((solver.solution.x.clone(), good.then_some(solver.solution.obj_val)))
}
