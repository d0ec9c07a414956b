//! Unknowns that are not the columns of a system: a linear map `d = B x` from these to those.

use std::fmt::Debug;
use std::sync::Arc;

use smallvec::SmallVec;

use super::SolveError;
use super::symmetric::Symmetric;
use super::system::SparseRows;

/// A linear map `B` from unknowns to numbers, applied without being stored: a running sum costs `O(n)` and would be
/// `O(n²)` numbers.
pub trait Operator: Debug + Send + Sync {
    /// How many unknowns there are: the length of `x`.
    fn unknowns(&self) -> usize;

    /// How many numbers they make: the length of `d`.
    fn columns(&self) -> usize;

    /// `d = B x`; `d` comes with any content.
    fn apply(&self, x: &[f64], d: &mut [f64]);

    /// `x = Bᵀ f`; `x` comes with any content.
    fn apply_transposed(&self, f: &[f64], x: &mut [f64]);

    /// The unknowns that columns `d = B x` come from, where some columns show them: whether `x` was written. `false` (the default) where that
    /// has to be solved for.
    fn read_back(&self, d: &[f64], x: &mut [f64]) -> bool {
        let _ = (d, x);
        false
    }

    /// What a column has of each unknown, where that is little: an equation of such columns then costs what they have, and not an
    /// application of the whole. `None` (the default) where it is much, or not known.
    fn row(&self, column: usize) -> Option<SmallVec<[(usize, f64); 4]>> {
        let _ = column;
        None
    }
}

/// How unknowns `x` make the columns of a system, `d = B x`.
#[derive(Debug, Clone)]
pub enum Map {
    /// The rows of `B`: of each column, what it has of each unknown; the same for all sides.
    Sparse(Arc<SparseRows>),
    /// Applied, not stored: for systems with one side.
    Operator(Arc<dyn Operator>),
}

/// The adjustment a system allows is `d = B x`, and `xᵀMx` is what is least.
#[derive(Debug, Clone)]
pub struct Through {
    /// `B`.
    pub map: Map,
    /// `M`, symmetric positive definite over the unknowns; the identity where there is none.
    pub measure: Option<Arc<Symmetric>>,
    /// Whether `M` measures the unknowns themselves; else it is made of `B` and the metric of what they move.
    pub is_own: bool,
}

/// A map and its transpose should be one: these many roundings apart at most, of the terms that the products are made of.
const ADJOINT: f64 = 1e-9;

impl Map {
    /// An operator, tried out: `⟨B x, f⟩ = ⟨x, Bᵀf⟩` on numbers of all signs, all finite.
    ///
    /// # Errors
    /// When the two are not each other's transpose, so that answers would be neither least nor right.
    pub fn operator(operator: Arc<dyn Operator>) -> Result<Self, SolveError> {
        let (n, m) = (operator.unknowns(), operator.columns());
        let wave =
            |i: usize, k: usize| (1.0 + ((i * 7 + k) % 11) as f64 / 11.0) * (1.0 - 2.0 * (i / k % 2) as f64);
        let (mut x, mut f) = (vec![0.0; n], vec![0.0; m]);
        let (mut d, mut g) = (vec![f64::NAN; m], vec![f64::NAN; n]);
        for k in [3, 5] {
            // Waves come again after 22 k numbers: remainders are found once.
            for (numbers, k) in [(&mut x, k), (&mut f, k + 1)] {
                let period: SmallVec<[f64; 132]> = (0..22 * k).map(|i| wave(i, k)).collect();
                numbers.chunks_mut(period.len()).for_each(|part| part.copy_from_slice(&period[..part.len()]));
            }
            d.fill(f64::NAN);
            g.fill(f64::NAN);
            operator.apply(&x, &mut d);
            operator.apply_transposed(&f, &mut g);
            let product = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).fold((0.0, 0.0), |(sum, size), (a, b)| (sum + a * b, size + (a * b).abs()))
            };
            let ((there, one), (back, other)) = (product(&d, &f), product(&x, &g));
            let apart = (there - back).abs();
            if apart.is_nan() || apart > ADJOINT * (one + other) {
                return Err(SolveError::Unsupported(format!(
                    "the map from {n} unknowns to {m} numbers ({operator:?}) and its transpose do not belong together: for the same \
                     numbers ⟨B x, f⟩ = {there:.6e} and ⟨x, Bᵀf⟩ = {back:.6e}; mend apply_transposed"
                )));
            }
        }
        Ok(Self::Operator(operator))
    }

    /// The number of unknowns.
    pub fn unknowns(&self) -> usize {
        match self {
            Self::Sparse(rows) => rows.width(),
            Self::Operator(operator) => operator.unknowns(),
        }
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        match self {
            Self::Sparse(rows) => rows.len(),
            Self::Operator(operator) => operator.columns(),
        }
    }

    /// `d = B x`, with `sides` numbers an unknown and a column.
    pub fn apply(&self, x: &[f64], sides: usize, d: &mut [f64]) {
        match self {
            Self::Sparse(rows) => rows.multiply(x, sides, d),
            Self::Operator(operator) => operator.apply(x, d),
        }
    }

    /// `x = Bᵀ f`, with `sides` numbers each.
    pub fn apply_transposed(&self, f: &[f64], sides: usize, x: &mut [f64]) {
        match self {
            Self::Sparse(rows) => {
                x.fill(0.0);
                for (row, f) in f.chunks_exact(sides).enumerate() {
                    for (unknown, value) in rows.iter_row(row) {
                        let own = &mut x[unknown * sides..(unknown + 1) * sides];
                        own.iter_mut().zip(f).for_each(|(x, f)| *x += value * f);
                    }
                }
            }
            Self::Operator(operator) => operator.apply_transposed(f, x),
        }
    }

    /// The least `x` with `B x` nearest to `d` (`‖B x - d‖`): by conjugate gradients on `BᵀB`, which need no more of the map than
    /// to be applied, and as many steps as there are unknowns where rounding allows it; at once of an operator that can
    /// [read them back](Operator::read_back). To measure what came out.
    pub fn nearest_unknowns(&self, d: &[f64], sides: usize, x: &mut [f64]) {
        if let Self::Operator(operator) = self
            && operator.read_back(d, x)
        {
            return;
        }
        let mut missing = d.to_vec();
        let mut gradient = vec![0.0; x.len()];
        let mut image = vec![0.0; d.len()];
        x.fill(0.0);
        self.apply_transposed(&missing, sides, &mut gradient);
        let mut way = gradient.clone();
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        let first = square(&gradient);
        let mut slope = first;
        for _ in 0..2 * x.len() {
            if slope.is_nan() || slope <= f64::EPSILON * f64::EPSILON * first {
                break;
            }
            self.apply(&way, sides, &mut image);
            let step = slope / square(&image);
            if !step.is_finite() {
                break;
            }
            x.iter_mut().zip(&way).for_each(|(x, w)| *x += step * w);
            missing.iter_mut().zip(&image).for_each(|(m, i)| *m -= step * i);
            self.apply_transposed(&missing, sides, &mut gradient);
            let next = square(&gradient);
            way.iter_mut().zip(&gradient).for_each(|(w, g)| *w = g + next / slope * *w);
            slope = next;
        }
    }

    /// The rows `F B` over the unknowns that belong to rows `F` over the columns. Of a sparse map they are as sparse as it lets
    /// them be; of an operator `O(columns)` each.
    pub fn rows(&self, rows: &SparseRows) -> SparseRows {
        let mut mapped = SparseRows::with_capacity(self.unknowns(), rows.len(), rows.entries());
        match self {
            Self::Sparse(map) => {
                for row in 0..rows.len() {
                    let terms =
                        rows.iter_row(row).flat_map(|(c, v)| map.iter_row(c).map(move |(j, b)| (j, v * b)));
                    mapped.push(terms.collect::<Vec<_>>());
                }
            }
            Self::Operator(operator) => {
                let (mut f, mut x) = (vec![0.0; operator.columns()], vec![0.0; operator.unknowns()]);
                for row in 0..rows.len() {
                    let few = rows.iter_row(row).map(|(c, v)| Some((operator.row(c)?, v)));
                    if let Some(few) = few.collect::<Option<SmallVec<[_; 4]>>>() {
                        let terms = few.iter().flat_map(|(own, v)| own.iter().map(move |(j, b)| (*j, v * b)));
                        mapped.push(terms);
                        continue;
                    }
                    f.fill(0.0);
                    rows.iter_row(row).for_each(|(c, v)| f[c] += v);
                    operator.apply_transposed(&f, &mut x);
                    mapped.push(x.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(j, v)| (j, *v)));
                }
            }
        }
        mapped
    }

    /// `BᵀWB`, of `W` or of the identity: what a form over the columns is over the unknowns. Of an operator it is dense: as many
    /// applications as there are unknowns.
    pub fn form(&self, w: Option<&Symmetric>) -> Symmetric {
        let n = self.unknowns();
        match self {
            Self::Sparse(map) => {
                let mut entries = Vec::new();
                for i in 0..map.len() {
                    let mut add = |j: usize, w: f64| {
                        for (a, va) in map.iter_row(i) {
                            let own = map.iter_row(j).filter(|(b, _)| *b <= a);
                            entries.extend(own.map(|(b, vb)| (a, b, va * w * vb)));
                        }
                    };
                    match w {
                        None => add(i, 1.0),
                        Some(w) => w.row(i).for_each(|(j, value)| add(j, value)),
                    }
                }
                Symmetric::from_entries(n, entries)
            }
            Self::Operator(operator) => {
                let m = operator.columns();
                let (mut x, mut d, mut f, mut g) = (vec![0.0; n], vec![0.0; m], vec![0.0; m], vec![0.0; n]);
                let mut entries = Vec::with_capacity(n * (n + 1) / 2);
                for a in 0..n {
                    x[a] = 1.0;
                    operator.apply(&x, &mut d);
                    x[a] = 0.0;
                    let image = match w {
                        None => &d,
                        Some(w) => {
                            w.multiply(&d, 1, &mut f);
                            &f
                        }
                    };
                    operator.apply_transposed(image, &mut g);
                    entries.extend((0..=a).map(|b| (a, b, g[b])));
                }
                Symmetric::from_entries(n, entries)
            }
        }
    }
}
