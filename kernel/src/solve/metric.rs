//! The metric of the least adjustment, and the coordinates in which it is the Euclidean one.

use std::sync::Arc;

use super::SolveError;
use super::envelope::EnvelopeCholesky;
use super::map::Through;
use super::symmetric::Symmetric;
use super::system::{SparseRows, System};

/// `W` in `dᵀWd`, over the touched columns of a system.
#[derive(Debug, Clone, Default)]
pub enum SystemMetric {
    /// The identity: least adjustment (paper 1, equation (1)).
    #[default]
    Least,
    /// A diagonal: one positive weight a column. Heavy vertices move less.
    Weights(Arc<Vec<f64>>),
    /// A sparse symmetric positive definite matrix `W`.
    Matrix(Arc<Symmetric>),
    /// The inverse `W⁻¹` as a sparse symmetric positive definite matrix (falloff: how a vertex takes others along).
    Inverse(Arc<Symmetric>),
    /// Of unknowns that are not the columns: `W⁻¹ = B M⁻¹ Bᵀ`, of their number as rank.
    Through(Arc<Through>),
}

impl SystemMetric {
    /// The same for x, y and z of each column beside one another: column `3 i + axis` for column `i`.
    #[must_use]
    pub fn per_axis(self) -> Self {
        match self {
            Self::Least | Self::Through(_) => self,
            Self::Weights(weights) => Self::Weights(Arc::new(weights.iter().flat_map(|w| [*w; 3]).collect())),
            Self::Matrix(matrix) => Self::Matrix(Arc::new(matrix.per_axis())),
            Self::Inverse(matrix) => Self::Inverse(Arc::new(matrix.per_axis())),
        }
    }
}

/// The rows in coordinates `e` with `‖e‖² = dᵀWd`, and the way back `d = T e`: where the metric is not the identity.
#[derive(Debug, Clone)]
pub(crate) struct Whitened {
    pub(crate) rows: Arc<SparseRows>,
    back: Back,
}

#[derive(Debug, Clone)]
enum Back {
    Scale(Vec<f64>),
    Triangular {
        factor: EnvelopeCholesky,
        order: Vec<usize>,
        inverse: bool,
        work: Vec<f64>,
    },
    /// From unknowns, in which the measure is the identity once it is taken out.
    Through {
        through: Arc<Through>,
        measure: Option<Box<Back>>,
        x: Vec<f64>,
    },
}

impl System {
    /// The rows in the coordinates of the metric; `None` where they are the system's own.
    #[inline]
    pub(crate) fn whitened(&self) -> Result<Option<Box<Whitened>>, SolveError> {
        match self.metric() {
            SystemMetric::Least => Ok(None),
            metric => self.transformed(metric).map(|whitened| Some(Box::new(whitened))),
        }
    }

    fn transformed(&self, metric: &SystemMetric) -> Result<Whitened, SolveError> {
        match metric {
            SystemMetric::Least => self.scaled(self.rows(), &vec![1.0; self.rows().width()]),
            SystemMetric::Weights(weights) => self.scaled(self.rows(), weights),
            // W = R Rᵀ: e = Rᵀd, so a row f becomes R⁻¹f and d = R⁻ᵀe.
            SystemMetric::Matrix(matrix) => self.triangular(self.rows(), matrix, false),
            // W⁻¹ = L Lᵀ: d = L e, so a row f becomes Lᵀf.
            SystemMetric::Inverse(matrix) => self.triangular(self.rows(), matrix, true),
            // d = B x: a row f becomes Bᵀf, measured by M.
            SystemMetric::Through(through) => {
                let rows = through.map.rows(self.rows());
                let x = vec![0.0; rows.width() * self.sides()];
                let (rows, measure) = match &through.measure {
                    None => (Arc::new(rows), None),
                    Some(matrix) => {
                        let Whitened { rows, back } = self
                            .triangular(&rows, matrix, false)
                            .map_err(|error| unmeasured(through, matrix, error))?;
                        (rows, Some(Box::new(back)))
                    }
                };
                Ok(Whitened { rows, back: Back::Through { through: Arc::clone(through), measure, x } })
            }
        }
    }

    fn scaled(&self, rows: &SparseRows, weights: &[f64]) -> Result<Whitened, SolveError> {
        if let Some(at) = weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
            return Err(self.bad_metric(at));
        }
        let scale: Vec<f64> = weights.iter().map(|w| 1.0 / w.sqrt()).collect();
        let mut scaled = SparseRows::with_capacity(rows.width(), rows.len(), rows.entries());
        for row in 0..rows.len() {
            scaled.push(rows.iter_row(row).map(|(c, v)| (c, v * scale[c])));
        }
        Ok(Whitened { rows: Arc::new(scaled), back: Back::Scale(scale) })
    }

    fn triangular(
        &self,
        rows: &SparseRows,
        matrix: &Symmetric,
        inverse: bool,
    ) -> Result<Whitened, SolveError> {
        let (factor, order) = factor_symmetric(matrix).map_err(|row| self.bad_metric(row))?;
        let n = matrix.size();
        let mut place = vec![0; n];
        for (position, &row) in order.iter().enumerate() {
            place[row] = position;
        }
        let mut whitened = SparseRows::new(n);
        let mut dense = vec![0.0; n];
        for row in 0..rows.len() {
            dense.fill(0.0);
            for (column, value) in rows.iter_row(row) {
                dense[place[column]] += value;
            }
            if inverse {
                factor.multiply_upper(&mut dense, 1);
            } else {
                factor.forward(&mut dense, 1);
            }
            whitened.push(dense.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(c, v)| (c, *v)));
        }
        let work = vec![0.0; n * self.sides()];
        let back = Back::Triangular { factor, order, inverse, work };
        Ok(Whitened { rows: Arc::new(whitened), back })
    }

    pub(super) fn bad_metric(&self, column: usize) -> SolveError {
        let column = self.touched().get(column).copied().unwrap_or(column);
        SolveError::Metric { vertex: if self.sides() == 3 { column } else { column / 3 } }
    }
}

impl System {
    /// `P` and `G` of the same problem without a metric beside them: `xᵀPx` least under `G x = b`. The unknowns are the adjustment
    /// `x = d` with `P = W`; of a metric that is known by its inverse `x = W d`, so that `P = W⁻¹` and `G = F W⁻¹`. Both are as
    /// sparse as what they are made of. Of a metric [through](SystemMetric::Through) a map they are those of its unknowns.
    pub fn matrices(&self) -> (Symmetric, SparseRows) {
        let (rows, n) = (self.rows(), self.rows().width());
        let diagonal = |value: &dyn Fn(usize) -> f64| {
            Symmetric::from_entries(n, (0..n).map(|i| (i, i, value(i))).collect::<Vec<_>>())
        };
        match self.metric() {
            SystemMetric::Least => (diagonal(&|_| 1.0), rows.as_ref().clone()),
            SystemMetric::Weights(w) => (diagonal(&|i| w[i]), rows.as_ref().clone()),
            SystemMetric::Matrix(matrix) => (matrix.as_ref().clone(), rows.as_ref().clone()),
            SystemMetric::Inverse(inverse) => {
                let mut products = SparseRows::new(n);
                for row in 0..rows.len() {
                    let of = |(c, v): (usize, f64)| inverse.row(c).map(move |(j, m)| (j, v * m));
                    products.push(rows.iter_row(row).flat_map(of).collect::<Vec<_>>());
                }
                (inverse.as_ref().clone(), products)
            }
            SystemMetric::Through(through) => {
                let n = through.map.unknowns();
                let identity = || Symmetric::from_entries(n, (0..n).map(|i| (i, i, 1.0)));
                let measure = through.measure.as_ref().map_or_else(identity, |m| m.as_ref().clone());
                (measure, through.map.rows(rows))
            }
        }
    }
}

/// The error for unknowns that cannot be measured, by its cause.
#[cold]
fn unmeasured(through: &Through, measure: &Symmetric, error: SolveError) -> SolveError {
    let (SolveError::Metric { .. }, Err(unknown)) = (&error, factor_symmetric(measure)) else { return error };
    let count = measure.size();
    SolveError::Unsupported(match (measure.first_not_finite(), through.is_own) {
        (Some(unknown), true) => {
            format!(
                "row {unknown} of the matrix that measures the {count} unknowns has a number that is not finite"
            )
        }
        (Some(unknown), false) => format!(
            "how far unknown {unknown} of {count} moves the control vertices is beyond what numbers hold: give the unknowns in \
             other units, so that the products of what they do stay finite"
        ),
        (None, true) => format!(
            "the matrix that measures the {count} unknowns is not positive definite (at unknown {unknown}): every change of them \
             must cost something; `measured(None)` takes ‖x‖² instead"
        ),
        (None, false) => format!(
            "unknown {unknown} of {count} moves nothing that others do not move as well: leave it out, or measure the unknowns \
             themselves with `measured(None)`"
        ),
    })
}

/// `W⁻¹` of a system's metric, ready to be applied.
#[derive(Debug, Clone)]
pub(crate) enum InverseMetric {
    Same,
    /// A factor for each column.
    Scale(Vec<f64>),
    /// A symmetric matrix to multiply with.
    Multiply(Arc<Symmetric>),
    /// A matrix to solve with, in its order.
    Solve {
        factor: EnvelopeCholesky,
        order: Vec<usize>,
    },
    /// `B M⁻¹ Bᵀ`.
    Through {
        through: Arc<Through>,
        measure: Box<InverseMetric>,
        room: [Vec<f64>; 3],
    },
}

impl System {
    /// `W⁻¹` as something that can be applied again and again.
    pub(crate) fn inverse_metric(&self) -> Result<InverseMetric, SolveError> {
        match self.metric() {
            SystemMetric::Least => Ok(InverseMetric::Same),
            SystemMetric::Weights(weights) => {
                match weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
                    Some(at) => Err(self.bad_metric(at)),
                    None => Ok(InverseMetric::Scale(weights.iter().map(|w| 1.0 / w).collect())),
                }
            }
            SystemMetric::Inverse(matrix) => Ok(InverseMetric::Multiply(Arc::clone(matrix))),
            SystemMetric::Matrix(matrix) => self.solving(matrix),
            SystemMetric::Through(through) => {
                let measure = Box::new(match &through.measure {
                    None => InverseMetric::Same,
                    Some(matrix) => {
                        self.solving(matrix).map_err(|error| unmeasured(through, matrix, error))?
                    }
                });
                let room = std::array::from_fn(|_| vec![0.0; through.map.unknowns() * self.sides()]);
                Ok(InverseMetric::Through { through: Arc::clone(through), measure, room })
            }
        }
    }

    fn solving(&self, matrix: &Symmetric) -> Result<InverseMetric, SolveError> {
        let (factor, order) = factor_symmetric(matrix).map_err(|row| self.bad_metric(row))?;
        Ok(InverseMetric::Solve { factor, order })
    }
}

impl InverseMetric {
    /// `out = W⁻¹ x`, `sides` entries a column. `work` is as long as `x`.
    pub(crate) fn apply(&mut self, x: &[f64], sides: usize, out: &mut [f64], work: &mut [f64]) {
        match self {
            Self::Same => out.copy_from_slice(x),
            Self::Scale(scale) => {
                let columns = out.chunks_exact_mut(sides).zip(x.chunks_exact(sides));
                for ((out, x), s) in columns.zip(scale) {
                    out.iter_mut().zip(x).for_each(|(o, x)| *o = x * *s);
                }
            }
            Self::Multiply(matrix) => {
                for (i, out) in out.chunks_exact_mut(sides).enumerate() {
                    out.fill(0.0);
                    for (j, value) in matrix.row(i) {
                        for (o, x) in out.iter_mut().zip(&x[j * sides..]) {
                            *o += value * x;
                        }
                    }
                }
            }
            Self::Solve { factor, order } => {
                for (work, &row) in work.chunks_exact_mut(sides).zip(order.iter()) {
                    work.copy_from_slice(&x[row * sides..(row + 1) * sides]);
                }
                factor.solve(work, sides);
                for (work, &row) in work.chunks_exact(sides).zip(order.iter()) {
                    out[row * sides..(row + 1) * sides].copy_from_slice(work);
                }
            }
            Self::Through { through, measure, room: [f, e, work] } => {
                through.map.apply_transposed(x, sides, f);
                measure.apply(f, sides, e, work);
                through.map.apply(e, sides, out);
            }
        }
    }
}

impl Whitened {
    /// `dᵀWd`, `sides` numbers a column; of a map's unknowns `xᵀMx` for the least `x` with `B x` nearest to `d`.
    pub(crate) fn squared_length(&mut self, d: &[f64], sides: usize) -> f64 {
        self.back.squared_length(d, sides)
    }

    /// `d = T e`, `sides` numbers a column. `e` and `d` are as long as one another, but where a map makes columns of unknowns.
    pub(crate) fn finish(&mut self, e: &[f64], d: &mut [f64], sides: usize) {
        self.back.finish(e, d, sides);
    }
}

impl Back {
    fn squared_length(&mut self, d: &[f64], sides: usize) -> f64 {
        match self {
            Self::Scale(scale) => {
                let share = |(d, s): (&[f64], &f64)| d.iter().map(|v| (v / s) * (v / s)).sum::<f64>();
                d.chunks_exact(sides).zip(&*scale).map(share).sum()
            }
            Self::Triangular { factor, order, inverse, work } => {
                let work = &mut work[..d.len()];
                for (value, &row) in work.chunks_exact_mut(sides).zip(order.iter()) {
                    value.copy_from_slice(&d[row * sides..(row + 1) * sides]);
                }
                if *inverse {
                    factor.forward(work, sides);
                } else {
                    factor.multiply_upper(work, sides);
                }
                work.iter().map(|v| v * v).sum()
            }
            Self::Through { through, measure, x } => {
                through.map.nearest_unknowns(d, sides, x);
                match measure {
                    None => x.iter().map(|v| v * v).sum(),
                    Some(measure) => measure.squared_length(x, sides),
                }
            }
        }
    }

    fn finish(&mut self, e: &[f64], d: &mut [f64], sides: usize) {
        match self {
            Self::Scale(scale) => {
                let columns = d.chunks_exact_mut(sides).zip(e.chunks_exact(sides));
                for ((d, e), s) in columns.zip(scale) {
                    d.iter_mut().zip(e).for_each(|(d, e)| *d = e * *s);
                }
            }
            Self::Triangular { factor, order, inverse, work } => {
                let work = &mut work[..e.len()];
                work.copy_from_slice(e);
                if *inverse {
                    factor.multiply_lower(work, sides);
                } else {
                    factor.backward(work, sides);
                }
                for (value, &row) in work.chunks_exact(sides).zip(order.iter()) {
                    d[row * sides..(row + 1) * sides].copy_from_slice(value);
                }
            }
            Self::Through { through, measure, x } => {
                let x = match measure {
                    None => e,
                    Some(measure) => {
                        measure.finish(e, x, sides);
                        x
                    }
                };
                through.map.apply(x, sides, d);
            }
        }
    }
}

/// The Cholesky factor of a sparse symmetric matrix in an order that keeps its envelope small, and that order.
///
/// # Errors
/// The row where the matrix is not positive definite.
fn factor_symmetric(matrix: &Symmetric) -> Result<(EnvelopeCholesky, Vec<usize>), usize> {
    let n = matrix.size();
    let envelope = |order: &[usize]| {
        let mut place = vec![0; n];
        for (position, &row) in order.iter().enumerate() {
            place[row] = position;
        }
        let first: Vec<u32> = order
            .iter()
            .enumerate()
            .map(|(position, &row)| {
                matrix.row(row).map(|(c, _)| place[c]).min().unwrap_or(position).min(position) as u32
            })
            .collect();
        let size: usize = first.iter().enumerate().map(|(i, &f)| i + 1 - f as usize).sum();
        (first, size)
    };
    let natural: Vec<usize> = (0..n).collect();
    let (first, size) = envelope(&natural);
    let narrow = matrix.narrow_order();
    let (narrow_first, narrow_size) = envelope(&narrow);
    let (order, first) = if narrow_size < size { (narrow, narrow_first) } else { (natural, first) };
    let factor = EnvelopeCholesky::factor(first, f64::EPSILON * 4.0, |i, j| matrix.entry(order[i], order[j]))
        .map_err(|i| order[i])?;
    Ok((factor, order))
}
