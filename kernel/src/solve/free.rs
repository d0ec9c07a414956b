//! Unknowns that cost nothing, taken out before any solver: parameters that float without a mass of their own.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::in_metric::MinimumNorm;
use super::rank::{Dependency, Diagnosis};
use super::refine::Refinement;
use super::system::{SparseRows, System};
use super::{Factored, SolveError};

/// What is left of a free column outside the span of the others, relative to it: not more counts as nothing.
const NOTHING: f64 = 1e-12;

/// `[L S] (d, s) = b` with the last columns `S` free: by an orthogonal `[Q₁ Q₂]` with `S = Q₁ R`, `Q₂ᵀL d = Q₂ᵀb` is what binds
/// the others, and `s = R⁻¹ Q₁ᵀ(b - L d)` follows. Only the rows that have free entries are mixed, so that the others stay as
/// sparse as they are. Nothing is given a tiny weight, and no condition is squared.
struct Freed {
    core: Core,
    refinement: Box<Refinement>,
    rank: usize,
    dependencies: Vec<Dependency>,
}

struct Core {
    inner: Box<dyn Factored>,
    /// The rows that are independent, and which these are.
    system: System,
    kept: Vec<usize>,
    mixing: Mixing,
    given: Vec<f64>,
    rhs: Vec<f64>,
    multipliers: Vec<f64>,
}

/// How the rows with free entries become rows without.
struct Mixing {
    /// Rows without free entries, then those with.
    plain: Vec<usize>,
    mixed: Vec<usize>,
    /// The reciprocal length of each of the latter.
    scale: Vec<f64>,
    /// `Qᵀ` of the free part of these, at unit length: its first rows are `Q₁ᵀ`.
    q: DMatrix<f64>,
    /// `R` of the free columns that are independent, and which these are.
    r: DMatrix<f64>,
    columns: Vec<usize>,
    room: DVector<f64>,
}

impl Mixing {
    fn new(system: &System) -> Self {
        let (rows, weighed) = (system.rows(), system.weighed());
        let has_free = |&row: &usize| rows.iter_row(row).any(|(c, v)| c >= weighed && v != 0.0);
        let (mixed, plain): (Vec<usize>, Vec<usize>) = (0..rows.len()).partition(has_free);
        let scale: Vec<f64> = mixed.iter().map(|&row| 1.0 / rows.norm(row)).collect();
        let mut s = DMatrix::zeros(mixed.len(), system.free());
        for (k, (&row, scale)) in mixed.iter().zip(&scale).enumerate() {
            rows.iter_row(row)
                .filter(|(c, _)| *c >= weighed)
                .for_each(|(c, v)| s[(k, c - weighed)] += v * scale);
        }
        // Householder reflections, the column with the longest remainder first.
        let (m, k) = s.shape();
        let mut q = DMatrix::identity(m, m);
        let lengths: Vec<f64> = (0..k).map(|j| s.column(j).norm()).collect();
        let mut columns: Vec<usize> = (0..k).collect();
        let mut rank = 0;
        while rank < m.min(k) {
            let rest = |j: usize| -> f64 {
                s.view((rank, j), (m - rank, 1)).norm() / lengths[j].max(f64::MIN_POSITIVE)
            };
            let best =
                (rank..k).fold(rank, |best, j| if rest(columns[j]) > rest(columns[best]) { j } else { best });
            if rest(columns[best]).is_nan() || rest(columns[best]) <= NOTHING {
                break;
            }
            columns.swap(rank, best);
            let mut v: DVector<f64> = s.view((rank, columns[rank]), (m - rank, 1)).column(0).into_owned();
            v[0] += v.norm().copysign(v[0]);
            let beta = 2.0 / v.norm_squared();
            for matrix in [&mut s, &mut q] {
                let mut below = matrix.rows_mut(rank, m - rank);
                let products = below.tr_mul(&v) * beta;
                below.ger(-1.0, &v, &products, 1.0);
            }
            rank += 1;
        }
        columns.truncate(rank);
        let r = DMatrix::from_fn(rank, rank, |i, j| if i <= j { s[(i, columns[j])] } else { 0.0 });
        let room = DVector::zeros(m);
        Self { plain, mixed, scale, q, r, columns, room }
    }

    fn bound(&self) -> usize {
        self.mixed.len() - self.columns.len()
    }

    /// The rows without their free columns. Of a row of which no more is left than rounding, nothing is.
    fn rows(&self, system: &System) -> SparseRows {
        let (rows, weighed) = (system.rows(), system.weighed());
        let mut all = SparseRows::with_capacity(weighed, self.plain.len() + self.bound(), rows.entries());
        self.plain.iter().for_each(|&row| all.push(rows.iter_row(row)));
        // What the rows of length 1 have beside their free entries: `Q` is known to rounding only, and so is what it makes of this.
        let entries = self.mixed.iter().zip(&self.scale).flat_map(|(&row, scale)| {
            let weighed = rows.iter_row(row).filter(|(c, _)| *c < weighed);
            weighed.map(move |(_, v)| (v * scale).abs())
        });
        let rounding = System::FINE * entries.fold(0.0, f64::max);
        for i in self.columns.len()..self.mixed.len() {
            let mut terms: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
            for (k, (&row, scale)) in self.mixed.iter().zip(&self.scale).enumerate() {
                let factor = self.q[(i, k)] * scale;
                for (column, value) in rows.iter_row(row).filter(|(c, _)| *c < weighed) {
                    let (sum, size) = terms.entry(column).or_default();
                    (*sum, *size) = (*sum + value * factor, *size + (value * factor).abs());
                }
            }
            let largest = |pick: fn(&(f64, f64)) -> f64| terms.values().map(pick).fold(0.0, f64::max);
            let something = largest(|t| t.0.abs()) > rounding.max(system.tolerance() * largest(|t| t.1));
            all.push(terms.iter().filter(|_| something).map(|(&column, &(sum, _))| (column, sum)));
        }
        all
    }

    /// What row `row` of those is of the given ones.
    fn combination(&self, row: usize) -> Vec<(usize, f64)> {
        if row < self.plain.len() {
            return vec![(self.plain[row], 1.0)];
        }
        let i = row - self.plain.len() + self.columns.len();
        let each = self.mixed.iter().zip(&self.scale).enumerate();
        each.map(|(k, (&row, scale))| (row, self.q[(i, k)] * scale)).collect()
    }

    /// Dependencies among the rows without free columns as dependencies among the given ones. Each leaves out one row: a plain one
    /// itself, of those that were mixed the one that has most part in it; and it is taken out of the others, so that what is
    /// left out is made of rows that are kept.
    fn dependencies(&self, inner: &[Dependency], rows: usize) -> Vec<Dependency> {
        let mut all: Vec<(usize, Vec<f64>)> = Vec::with_capacity(inner.len());
        let take_out = |from: &mut [f64], (own, sum): (usize, &[f64])| {
            let share = from[own];
            if share != 0.0 {
                from.iter_mut().zip(sum).for_each(|(from, sum)| *from -= share * sum);
                from[own] = 0.0;
            }
        };
        for dependency in inner {
            let mut sum = vec![0.0; rows];
            let mut add = |row: usize, factor: f64| {
                self.combination(row).into_iter().for_each(|(at, c)| sum[at] += factor * c);
            };
            add(dependency.row, 1.0);
            dependency.combination.iter().for_each(|&(row, factor)| add(row, -factor));
            all.iter().for_each(|(own, other)| take_out(&mut sum, (*own, other)));
            let part = |row: usize| sum[row].abs() / self.scale_of(row);
            let most = |best: usize, row: usize| if part(row) > part(best) { row } else { best };
            let own = match self.plain.get(dependency.row) {
                Some(&row) => row,
                None => self.mixed.iter().copied().fold(self.mixed[0], most),
            };
            let whole = sum[own];
            if whole == 0.0 {
                continue;
            }
            sum.iter_mut().for_each(|s| *s /= whole);
            all.iter_mut().for_each(|(_, other)| take_out(other, (own, &sum)));
            all.push((own, sum));
        }
        all.sort_by_key(|(own, _)| *own);
        let of = |(own, sum): (usize, Vec<f64>)| {
            let others = sum.iter().enumerate().filter(|&(row, s)| row != own && *s != 0.0);
            Dependency { row: own, combination: others.map(|(row, s)| (row, -s)).collect() }
        };
        all.into_iter().map(of).collect()
    }

    fn scale_of(&self, row: usize) -> f64 {
        self.mixed.binary_search(&row).map_or(1.0, |k| self.scale[k])
    }
}

/// Factors a system with free unknowns with a solver for those without. Rank is that of all columns: a row that only a free
/// unknown can meet is met by it.
///
/// # Errors
/// The solver's own; when there is more than one side.
pub(super) fn factor(
    solver: &str,
    factor: &MinimumNorm<'_>,
    system: &System,
) -> Result<Box<dyn Factored>, SolveError> {
    if system.sides() != 1 {
        return Err(SolveError::Unsupported(
            "unknowns that float without weight need a system whose columns are coordinates, with one side"
                .into(),
        ));
    }
    let rows = system.rows().len();
    let mut mixing = Mixing::new(system);
    let mut inner = factor(&system.without_free(mixing.rows(system)))?;
    let rank = inner.rank() + mixing.columns.len();
    let dependencies = mixing.dependencies(&inner.diagnosis().dependencies, rows);
    let mut kept: Vec<usize> = (0..rows).collect();
    let mut part = system.clone();
    if !dependencies.is_empty() {
        // What is asked of a row that others imply must not mix with what is asked of these.
        kept.retain(|row| dependencies.binary_search_by_key(row, |dependency| dependency.row).is_err());
        part = system.select(&kept).finely();
        mixing = Mixing::new(&part);
        inner = factor(&part.without_free(mixing.rows(&part)))?;
    }
    let count = mixing.plain.len() + mixing.bound();
    let [rhs, multipliers] = [vec![0.0; count], vec![0.0; count]];
    let given = vec![0.0; kept.len()];
    let all: Vec<u32> = kept.iter().map(|&row| row as u32).collect();
    let mut core = Core { inner, system: part, kept, mixing, given, rhs, multipliers };
    match Refinement::new(system, all.into_iter(), |rhs, d| core.solve_into(rhs, d)) {
        Some(refinement) => Ok(Box::new(Freed { core, refinement, rank, dependencies })),
        None => Err(SolveError::IllConditioned {
            solver: solver.into(),
            condition: core.inner.diagnosis().condition,
            better: "householder-qr",
        }),
    }
}

impl Core {
    fn mix(&mut self, all: &[f64]) {
        self.given.iter_mut().zip(&self.kept).for_each(|(own, &row)| *own = all[row]);
        let rhs = &self.given;
        let Mixing { plain, mixed, scale, q, columns, room, .. } = &mut self.mixing;
        self.rhs.iter_mut().zip(plain.iter()).for_each(|(own, &row)| *own = rhs[row]);
        room.iter_mut().zip(mixed.iter().zip(scale.iter())).for_each(|(own, (&row, s))| *own = rhs[row] * s);
        for (i, own) in (columns.len()..mixed.len()).zip(&mut self.rhs[plain.len()..]) {
            *own = q.row(i).iter().zip(room.iter()).map(|(q, b)| q * b).sum();
        }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        self.mix(rhs);
        let (d, free) = d.split_at_mut(self.system.weighed());
        self.inner.solve_into(&self.rhs, d);
        let Mixing { mixed, scale, q, r, columns, room, .. } = &mut self.mixing;
        for ((own, &row), scale) in room.iter_mut().zip(mixed.iter()).zip(scale.iter()) {
            let terms = self.system.rows().iter_row(row).filter(|(c, _)| *c < d.len());
            *own = (self.given[row] - terms.map(|(c, v)| v * d[c]).sum::<f64>()) * scale;
        }
        free.fill(0.0);
        for i in (0..columns.len()).rev() {
            let wanted: f64 = q.row(i).iter().zip(room.iter()).map(|(q, b)| q * b).sum();
            let known: f64 = (i + 1..columns.len()).map(|j| r[(i, j)] * free[columns[j]]).sum();
            free[columns[i]] = (wanted - known) / r[(i, i)];
        }
    }
}

impl Factored for Freed {
    fn solver(&self) -> &str {
        self.core.inner.solver()
    }

    fn rank(&self) -> usize {
        self.rank
    }

    fn diagnosis(&self) -> Diagnosis {
        let condition = self.core.inner.diagnosis().condition;
        Diagnosis { rank: self.rank, condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let Self { core, refinement, .. } = self;
        core.solve_into(rhs, d);
        refinement.refine(rhs, d, |missed, more| core.solve_into(missed, more));
    }

    /// `λ = Q₂ λ'`, so that `Sᵀλ = 0`: what costs nothing feels no force.
    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        let core = &mut self.core;
        core.mix(rhs);
        core.inner.multipliers_into(&core.rhs, &mut core.multipliers);
        let Mixing { plain, mixed, scale, q, columns, .. } = &core.mixing;
        multipliers.fill(0.0);
        plain.iter().zip(&core.multipliers).for_each(|(&row, own)| multipliers[core.kept[row]] = *own);
        for (i, own) in (columns.len()..mixed.len()).zip(&core.multipliers[plain.len()..]) {
            for (k, (&row, scale)) in mixed.iter().zip(scale).enumerate() {
                multipliers[core.kept[row]] += q[(i, k)] * scale * own;
            }
        }
    }
}
