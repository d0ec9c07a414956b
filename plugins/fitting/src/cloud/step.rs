//! One step of a fit: the least of a model under equations.

use loftsman_kernel::Vector;
use loftsman_kernel::energy::Squares;
use loftsman_kernel::solve::{
    EnvelopeCholesky, Factored, Solver, SparseRows, Symmetric, System, SystemMetric,
};

use super::model::Model;
use crate::error::{FitError, Result};

/// A pivot of this part of its diagonal is none.
const PIVOT: f64 = 1e-13;
/// Steps of one search, and the part of its start at which the gradient, in the metric of the matrix, is small enough: where steps are to end where they
/// settle, and where these are on their way.
const STEPS: usize = 100;
pub(super) const SMALL: f64 = 1e-8;
pub(super) const COARSE: f64 = 1e-3;

/// Vectors that a trace is estimated with.
const PROBES: usize = 66;

/// The next of a sequence of signs (Steele, Lea and Flood 2014).
fn sign(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}

/// What holds while vertices move: which are free, and the equations of the constraints.
pub(super) struct Held {
    /// The vertices that may move, ascending.
    pub(super) free: Vec<usize>,
    count: usize,
    /// The rows over the free vertices (over each of their coordinates where there is one side).
    rows: SparseRows,
    pub(super) sides: usize,
}

impl Held {
    /// `system` is that of the equations, over numbers of vertices of which the first `count` are the shape's.
    pub(super) fn new(system: &System, free: Vec<usize>, count: usize) -> Self {
        let sides = system.sides();
        let mut place = vec![usize::MAX; count];
        free.iter().enumerate().for_each(|(k, &v)| place[v] = k);
        let column = |global: usize| {
            let (vertex, axis) = if sides == 3 { (global, 0) } else { (global / 3, global % 3) };
            let at = place.get(vertex).copied().filter(|&at| at != usize::MAX)?;
            Some(if sides == 3 { at } else { 3 * at + axis })
        };
        let mut rows = SparseRows::new(if sides == 3 { free.len() } else { 3 * free.len() });
        for row in 0..system.rows().len() {
            let terms = system.rows().iter_row(row);
            rows.push(terms.filter_map(|(c, value)| column(system.touched()[c]).map(|at| (at, value))));
        }
        Self { free, count, rows, sides }
    }

    /// Adds the rows that treat the axes alike to a matrix, each as heavy as what is there: what is least under the equations is the
    /// same, and vertices that only these determine are seen.
    fn strengthened(&self, matrix: Symmetric) -> Symmetric {
        if self.sides != 3 || self.rows.is_empty() {
            return matrix;
        }
        let n = matrix.size();
        let heaviest = (0..n).fold(0.0_f64, |most, i| most.max(matrix.entry(i, i)));
        let own =
            (0..n).flat_map(|i| matrix.row(i).filter(move |(j, _)| *j <= i).map(move |(j, v)| (i, j, v)));
        let mut entries: Vec<(usize, usize, f64)> = own.collect();
        for row in 0..self.rows.len() {
            let norm = self.rows.norm(row);
            if norm > 0.0 {
                let terms: Vec<(usize, f64)> = self.rows.iter_row(row).map(|(c, v)| (c, v / norm)).collect();
                for &(i, a) in &terms {
                    let below = terms.iter().filter(|(j, _)| *j <= i);
                    entries.extend(below.map(|&(j, b)| (i, j, heaviest * a * b)));
                }
            }
        }
        Symmetric::from_entries(n, entries)
    }
}

/// A matrix factored, and what projects onto the adjustments that leave the equations as they are.
pub(super) struct Metric<'a> {
    held: &'a Held,
    factor: EnvelopeCholesky,
    /// Position → free vertex.
    order: Vec<usize>,
    projection: Option<Box<dyn Factored>>,
    work: Vec<f64>,
    values: Vec<f64>,
    adjustment: Vec<f64>,
}

impl<'a> Metric<'a> {
    /// # Errors
    /// [`FitError::Undetermined`] where points, energies and equations leave vertices open.
    pub(super) fn new(model: &Model<'_>, held: &'a Held, solver: &dyn Solver) -> Result<Self> {
        if model.is_held_along() {
            // That determines nothing that was open.
            Self::of(held.strengthened(model.matrix(held.count, false).select(&held.free)), held, solver)?;
        }
        Self::of(held.strengthened(model.matrix(held.count, true).select(&held.free)), held, solver)
    }

    fn of(matrix: Symmetric, held: &'a Held, solver: &dyn Solver) -> Result<Self> {
        let n = matrix.size();
        let order = matrix.narrow_order();
        let mut position = vec![0; n];
        order.iter().enumerate().for_each(|(k, &row)| position[row] = k);
        let first = envelope(&matrix, &order);
        let mut line = (usize::MAX, vec![0.0; n]);
        let entry = |i: usize, j: usize| {
            if line.0 != i {
                line.1.fill(0.0);
                matrix.row(order[i]).for_each(|(column, value)| line.1[position[column]] = value);
                line.0 = i;
            }
            line.1[j]
        };
        let Ok(factor) = EnvelopeCholesky::factor(first.clone(), PIVOT, entry) else {
            return Err(undetermined(&matrix, held, &order, &first));
        };
        let projection = if held.rows.is_empty() {
            None
        } else {
            let columns = held.free.iter().flat_map(|&v| match held.sides {
                3 => v..v + 1,
                _ => 3 * v..3 * v + 3,
            });
            let metric = SystemMetric::Matrix(std::sync::Arc::new(matrix));
            let metric = if held.sides == 3 { metric } else { metric.per_axis() };
            let system = System::new(held.rows.clone(), columns.collect(), held.sides, metric);
            Some(solver.factor(&system).map_err(loftsman_kernel::edit::EditError::from)?)
        };
        let values = vec![0.0; held.rows.len() * held.sides];
        let work = vec![0.0; 3 * n];
        Ok(Self { held, factor, order, projection, adjustment: work.clone(), work, values })
    }

    /// `out = W⁻¹ r` for the free vertices, zero for the others.
    fn solve(&mut self, r: &[Vector], out: &mut [Vector]) {
        for (slot, &at) in self.work.as_chunks_mut::<3>().0.iter_mut().zip(&self.order) {
            *slot = r[self.held.free[at]].into();
        }
        self.factor.solve(&mut self.work, 3);
        out.fill(Vector::zeros());
        for (slot, &at) in self.work.as_chunks::<3>().0.iter().zip(&self.order) {
            out[self.held.free[at]] = Vector::from(*slot);
        }
    }

    /// `tr W⁻¹ K` over the free vertices, `K` the matrix of an energy: exactly for few of them, else by [`PROBES`] vectors of signs (Hutchinson
    /// 1990), the same ones every time, which miss it by `(2 n / PROBES)^½` at most, times its own largest eigenvalue.
    pub(super) fn trace(&mut self, energy: &Squares, count: usize) -> f64 {
        let n = self.held.free.len();
        let exact = n <= PROBES;
        let probes = if exact { n } else { PROBES };
        let zeros = || vec![Vector::zeros(); count];
        let (mut product, mut solved) = (zeros(), zeros());
        let (mut sum, mut state) = (0.0, 0_u64);
        // Three at a time, one an axis.
        for some in (0..probes).step_by(3) {
            let mut probe = zeros();
            for axis in 0..3.min(probes - some) {
                if exact {
                    probe[self.held.free[some + axis]][axis] = 1.0;
                } else {
                    self.held.free.iter().for_each(|&v| probe[v][axis] = sign(&mut state));
                }
            }
            energy.gradient(&probe, false, &mut product);
            self.solve(&product, &mut solved);
            sum += probe.iter().zip(&solved).map(|(a, b)| a.dot(b)).sum::<f64>();
        }
        if exact { sum } else { sum / probes as f64 }
    }

    /// What the equations have of an adjustment.
    fn measure(&mut self, z: &[Vector]) {
        for (slot, &v) in self.work.as_chunks_mut::<3>().0.iter_mut().zip(&self.held.free) {
            *slot = z[v].into();
        }
        self.held.rows.multiply(&self.work, self.held.sides, &mut self.values);
    }

    /// Adds the least adjustment that changes what the equations measure by these numbers.
    pub(super) fn correct(&mut self, by: &[f64], x: &mut [Vector]) {
        let Some(projection) = &mut self.projection else { return };
        projection.solve_into(by, &mut self.adjustment);
        for (slot, &v) in self.adjustment.as_chunks::<3>().0.iter().zip(&self.held.free) {
            x[v] += Vector::from(*slot);
        }
    }

    /// `z = W⁻¹ r`, without what the equations see of it.
    fn precondition(&mut self, r: &[Vector], z: &mut [Vector]) {
        self.solve(r, z);
        if self.projection.is_some() {
            self.measure(z);
            let values: Vec<f64> = self.values.iter().map(|v| -v).collect();
            self.correct(&values, z);
        }
    }

    /// The multipliers of the equations for a gradient.
    pub(super) fn multipliers(&mut self, gradient: &[Vector]) -> Vec<f64> {
        let mut way = vec![Vector::zeros(); gradient.len()];
        self.solve(gradient, &mut way);
        self.measure(&way);
        let mut all = vec![0.0; self.values.len()];
        if let Some(projection) = &mut self.projection {
            projection.multipliers_into(&self.values, &mut all);
        }
        all
    }

    /// The adjustment that makes a model least among those that leave the equations as they are, by conjugate gradients
    /// preconditioned with the matrix, until the gradient is the part `small` of what it was: with `τ = 1` one step is all, with less some `τ^-½`.
    pub(super) fn least(
        &mut self,
        model: &Model<'_>,
        tau: f64,
        gradient: &[Vector],
        small: f64,
    ) -> Vec<Vector> {
        let n = gradient.len();
        let zeros = || vec![Vector::zeros(); n];
        let dot = |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
        let (mut d, mut z, mut product) = (zeros(), zeros(), zeros());
        let mut r: Vec<Vector> = gradient.iter().map(|g| -g).collect();
        self.precondition(&r, &mut z);
        let mut p = z.clone();
        let mut size = dot(&r, &z);
        let start = size;
        for _ in 0..STEPS {
            model.multiply(tau, &p, &mut product);
            let curvature = dot(&p, &product);
            if !(curvature > 0.0 && size > small * small * start) {
                break;
            }
            let share = size / curvature;
            for k in 0..n {
                d[k] += p[k] * share;
                r[k] -= product[k] * share;
            }
            self.precondition(&r, &mut z);
            let now = dot(&r, &z);
            let keep = now / size;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + *p * keep);
            size = now;
        }
        d
    }
}

/// The rank of a matrix that has not its full one, and the vertices that it leaves open.
fn undetermined(matrix: &Symmetric, held: &Held, order: &[usize], first: &[u32]) -> FitError {
    let n = matrix.size();
    let open: Vec<usize> = dependent(matrix, order, first).into_iter().map(|row| held.free[row]).collect();
    let least = open.iter().min().copied().unwrap_or(0);
    FitError::Undetermined { rank: n - open.len(), vertices: n, first: least }
}

/// How many dimensions a positive semidefinite matrix maps to nothing.
pub(super) fn nullity(matrix: &Symmetric) -> usize {
    let order = matrix.narrow_order();
    let first = envelope(matrix, &order);
    dependent(matrix, &order, &first).len()
}

/// The envelope of a matrix whose rows come in an order: where each begins.
fn envelope(matrix: &Symmetric, order: &[usize]) -> Vec<u32> {
    let mut position = vec![0; order.len()];
    order.iter().enumerate().for_each(|(k, &row)| position[row] = k);
    let begins = |(k, &row): (usize, &usize)| matrix.row(row).map(|(j, _)| position[j]).fold(k, usize::min);
    order.iter().enumerate().map(|row| begins(row) as u32).collect()
}

/// The rows of a positive semidefinite matrix that depend on those before them in an order, by elimination within the envelope.
fn dependent(matrix: &Symmetric, order: &[usize], first: &[u32]) -> Vec<usize> {
    let n = matrix.size();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
    let mut open = Vec::new();
    for i in 0..n {
        let from = first[i] as usize;
        let mut row: Vec<f64> = (from..=i).map(|j| matrix.entry(order[i], order[j])).collect();
        for j in from..i {
            let (other, start) = (&rows[j], first[j] as usize);
            let low = from.max(start);
            let sum: f64 = (low..j).map(|k| row[k - from] * other[k - start]).sum();
            let pivot = other[j - start];
            row[j - from] = if pivot > 0.0 { (row[j - from] - sum) / pivot } else { 0.0 };
        }
        let own = row[i - from];
        let left = own - row[..i - from].iter().map(|l| l * l).sum::<f64>();
        let sound = left > PIVOT * own;
        if !sound {
            open.push(order[i]);
        }
        row[i - from] = if sound { left.sqrt() } else { 0.0 };
        rows.push(row);
    }
    open
}
