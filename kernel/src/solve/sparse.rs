//! The solver for many equations: Cholesky of `F W⁻¹ Fᵀ` within its envelope.

use super::envelope::EnvelopeCholesky;
use super::metric::Whitened;
use super::rank::{Dependency, Diagnosis, reduce};
use super::system::{SparseRows, System};
use super::{Factored, SolveError, Solver};

/// Sparse Cholesky of `F̂ = F W⁻¹ Fᵀ`. Rows that touch nearby vertices are put side by side, so that `F̂` is a band
/// (or a narrow envelope) and the work is linear in the number of equations; neither preparing nor solving
/// depends on the number of control vertices. The condition number is squared, so answers are corrected by their
/// own residuals where that matters, and nearly dependent systems are refused.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sparse;

/// Below this relative pivot the rows are looked at by reflections.
const SUSPECT: f64 = 1e-8;
/// Below this relative pivot the answer is not to be had from `F̂` at all.
const HOPELESS: f64 = 1e-12;
/// Below this relative pivot an answer is corrected once, and twice below its square root of `SUSPECT`.
const CORRECT: f64 = 1e-2;
/// The most numbers the envelope may have.
const ENVELOPE_LIMIT: usize = 200_000_000;

struct FactoredSparse {
    whitened: Whitened,
    sides: usize,
    /// Position → row.
    order: Vec<u32>,
    /// Reciprocal length of each row, by position.
    scale: Vec<f64>,
    factor: EnvelopeCholesky,
    corrections: usize,
    dependencies: Vec<Dependency>,
    /// `y` by position, and the residual's adjustment.
    work: Vec<f64>,
}

impl Solver for Sparse {
    fn name(&self) -> &'static str {
        "sparse"
    }

    fn factor(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let whitened = system.whitened()?;
        let count = whitened.rows.len() as u32;
        match gram(&whitened.rows, (0..count).collect(), SUSPECT)? {
            Some(done) => Ok(Box::new(finish(whitened, system.sides(), done, Vec::new()))),
            None => {
                let (kept, diagnosis) = reduce(&whitened, self.name()).map_err(undecided)?;
                let kept = kept.into_iter().map(|r| r as u32).collect();
                match gram(&whitened.rows, kept, HOPELESS)? {
                    Some(done) => {
                        Ok(Box::new(finish(whitened, system.sides(), done, diagnosis.dependencies)))
                    }
                    None => Err(SolveError::IllConditioned {
                        solver: self.name().into(),
                        condition: diagnosis.condition,
                        better: "householder-qr",
                    }),
                }
            }
        }
    }
}

/// Dependent rows in a block that is too large to find out which: no solver can.
fn undecided(error: SolveError) -> SolveError {
    match error {
        SolveError::TooLarge { equations, unknowns, .. } => SolveError::Unsupported(format!(
            "{equations} equations with {unknowns} unknowns depend on one another, too many to find out which do: ask for \
             fewer constraints at once"
        )),
        other => other,
    }
}

struct Gram {
    order: Vec<u32>,
    scale: Vec<f64>,
    factor: EnvelopeCholesky,
}

fn finish(whitened: Whitened, sides: usize, done: Gram, dependencies: Vec<Dependency>) -> FactoredSparse {
    let Gram { order, scale, factor } = done;
    let pivot = factor.smallest_pivot();
    let corrections =
        usize::from(pivot < CORRECT) + usize::from(pivot < SUSPECT.sqrt()) + usize::from(pivot < SUSPECT);
    let room = if corrections > 0 { 2 } else { 1 };
    let work = vec![0.0; order.len() * sides * room];
    FactoredSparse { whitened, sides, order, scale, factor, corrections, dependencies, work }
}

/// The factor of the Gram matrix of the kept rows; `None` where a relative pivot is not above `threshold`.
fn gram(rows: &SparseRows, kept: Vec<u32>, threshold: f64) -> Result<Option<Gram>, SolveError> {
    if kept.iter().any(|&r| rows.row(r as usize).0.is_empty()) {
        return Ok(None);
    }
    let (order, first) = narrow(rows, kept);
    let size = size_of(&first);
    if size > ENVELOPE_LIMIT {
        let (equations, unknowns) = (order.len(), rows.width());
        return Err(SolveError::TooLarge {
            solver: "sparse".into(),
            equations,
            unknowns,
            better: "householder-qr",
        });
    }
    let scale: Vec<f64> = order.iter().map(|&r| 1.0 / rows.norm(r as usize)).collect();
    if scale.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return Ok(None);
    }
    let factor = EnvelopeCholesky::factor(first, threshold, |i, j| {
        if i == j { 1.0 } else { rows.dot(order[i] as usize, order[j] as usize) * scale[i] * scale[j] }
    });
    Ok(factor.ok().map(|factor| Gram { order, scale, factor }))
}

/// For each position, the first position whose row shares a column with it.
fn envelope(rows: &SparseRows, order: &[u32]) -> Vec<u32> {
    let mut earliest = vec![u32::MAX; rows.width()];
    let mut first = Vec::with_capacity(order.len());
    for (position, &row) in order.iter().enumerate() {
        let mut low = position as u32;
        for &column in rows.row(row as usize).0 {
            let seen = &mut earliest[column as usize];
            if *seen == u32::MAX {
                *seen = position as u32;
            }
            low = low.min(*seen);
        }
        first.push(low);
    }
    first
}

fn size_of(first: &[u32]) -> usize {
    first.iter().enumerate().map(|(i, &f)| i + 1 - f as usize).sum()
}

/// Rows in an order that keeps the envelope of their Gram matrix small, and that envelope: by first column where that is
/// narrow (curves), by breadth-first search over shared columns elsewhere (surfaces, seams, pairs of vertices).
fn narrow(rows: &SparseRows, mut kept: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
    let first = |r: u32| rows.row(r as usize).0.first().copied().unwrap_or(0);
    if !kept.windows(2).all(|pair| first(pair[0]) <= first(pair[1])) {
        kept.sort_by_key(|&r| (first(r), r));
    }
    let by_column = envelope(rows, &kept);
    let size = size_of(&by_column);
    if kept.len() < 16 || size <= kept.len() * 8 {
        return (kept, by_column);
    }
    let searched = breadth_first(rows, &kept);
    let by_search = envelope(rows, &searched);
    if size_of(&by_search) < size { (searched, by_search) } else { (kept, by_column) }
}

fn breadth_first(rows: &SparseRows, kept: &[u32]) -> Vec<u32> {
    // Which kept rows touch a column: counting sort.
    let mut starts = vec![0_u32; rows.width() + 1];
    for &row in kept {
        for &column in rows.row(row as usize).0 {
            starts[column as usize + 1] += 1;
        }
    }
    for i in 0..rows.width() {
        starts[i + 1] += starts[i];
    }
    let mut fill = starts.clone();
    let mut touching = vec![0_u32; starts.last().map_or(0, |&s| s as usize)];
    for (at, &row) in kept.iter().enumerate() {
        for &column in rows.row(row as usize).0 {
            let slot = &mut fill[column as usize];
            touching[*slot as usize] = at as u32;
            *slot += 1;
        }
    }
    let (mut seen, mut expanded) = (vec![false; kept.len()], vec![false; rows.width()]);
    let mut order: Vec<u32> = Vec::with_capacity(kept.len());
    for start in 0..kept.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut head = order.len();
        order.push(start as u32);
        while head < order.len() {
            let row = kept[order[head] as usize];
            // A column is expanded once: a row that everything shares does not cost the square.
            for &column in rows.row(row as usize).0 {
                let column = column as usize;
                if std::mem::replace(&mut expanded[column], true) {
                    continue;
                }
                for &next in &touching[starts[column] as usize..starts[column + 1] as usize] {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        order.push(next);
                    }
                }
            }
            head += 1;
        }
    }
    order.reverse();
    order.into_iter().map(|at| kept[at as usize]).collect()
}

impl FactoredSparse {
    /// `λ` (by position) of a right-hand side, without corrections.
    fn positions(&mut self, rhs: &[f64]) {
        let sides = self.sides;
        for ((y, &row), s) in self.work.chunks_exact_mut(sides).zip(&self.order).zip(&self.scale) {
            for (y, b) in y.iter_mut().zip(&rhs[row as usize * sides..]) {
                *y = b * s;
            }
        }
        let y = &mut self.work[..self.order.len() * sides];
        self.factor.solve(y, sides);
        for (y, s) in y.chunks_exact_mut(sides).zip(&self.scale) {
            y.iter_mut().for_each(|v| *v *= s);
        }
    }

    /// `λ ← λ + (F̂)⁻¹ (b - F e)`, once for each correction, `e = Fᵀλ` in `e`.
    fn correct(&mut self, rhs: &[f64], e: &mut [f64]) {
        let (sides, used) = (self.sides, self.order.len() * self.sides);
        for _ in 0..self.corrections {
            let (total, step) = self.work.split_at_mut(used);
            let step = &mut step[..used];
            for ((r, &row), s) in step.chunks_exact_mut(sides).zip(&self.order).zip(&self.scale) {
                r.copy_from_slice(&rhs[row as usize * sides..(row as usize + 1) * sides]);
                for (column, value) in self.whitened.rows.iter_row(row as usize) {
                    for (r, e) in r.iter_mut().zip(&e[column * sides..]) {
                        *r -= value * e;
                    }
                }
                r.iter_mut().for_each(|r| *r *= s);
            }
            self.factor.solve(step, sides);
            for ((step, total), s) in
                step.chunks_exact_mut(sides).zip(total.chunks_exact_mut(sides)).zip(&self.scale)
            {
                for (step, total) in step.iter_mut().zip(total) {
                    *step *= s;
                    *total += *step;
                }
            }
            add_transposed(&self.whitened.rows, &self.order, step, sides, e);
        }
    }
}

/// `e += Fᵀ y`, rows by position.
fn add_transposed(rows: &SparseRows, order: &[u32], y: &[f64], sides: usize, e: &mut [f64]) {
    if sides == 3 {
        let ((y, _), (e, _)) = (y.as_chunks::<3>(), e.as_chunks_mut::<3>());
        for (y, &row) in y.iter().zip(order) {
            let (columns, values) = rows.row(row as usize);
            for (&column, value) in columns.iter().zip(values) {
                let e = &mut e[column as usize];
                for s in 0..3 {
                    e[s] += value * y[s];
                }
            }
        }
        return;
    }
    for (y, &row) in y.chunks_exact(sides).zip(order) {
        for (column, value) in rows.iter_row(row as usize) {
            for (e, y) in e[column * sides..].iter_mut().zip(y) {
                *e += value * y;
            }
        }
    }
}

impl Factored for FactoredSparse {
    fn solver(&self) -> &'static str {
        "sparse"
    }

    fn rank(&self) -> usize {
        self.order.len()
    }

    fn diagnosis(&self) -> Diagnosis {
        let condition = self.factor.condition().sqrt();
        Diagnosis { rank: self.order.len(), condition, dependencies: self.dependencies.clone() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        self.positions(rhs);
        d.fill(0.0);
        let used = self.order.len() * self.sides;
        add_transposed(&self.whitened.rows, &self.order, &self.work[..used], self.sides, d);
        if self.corrections > 0 {
            self.correct(rhs, d);
        }
        self.whitened.finish(d, self.sides);
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        self.positions(rhs);
        multipliers.fill(0.0);
        for (y, &row) in self.work.chunks_exact(self.sides).zip(&self.order) {
            multipliers[row as usize * self.sides..(row as usize + 1) * self.sides].copy_from_slice(y);
        }
    }
}
