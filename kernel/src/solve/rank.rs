//! Householder reflections from the right with row pivoting: rank, and which rows the others imply.

mod block;

use self::block::Block;
use super::SolveError;
use super::metric::SystemMetric;
use super::system::{SparseRows, System};

/// Rank and condition of a system, and the rows that were left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagnosis {
    /// Independent rows.
    pub rank: usize,
    /// Estimate of the condition number of the independent rows, each scaled to unit length.
    pub condition: f64,
    /// Every dependent row, and how the others imply it.
    pub dependencies: Vec<Dependency>,
}

/// A row that is a combination of others: `row = Σ factor · other`. With no others, the row is zero: no vertex
/// that may move touches it.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependency {
    /// The dependent row.
    pub row: usize,
    /// The independent rows it is made of, ascending, with their factors.
    pub combination: Vec<(usize, f64)>,
}

/// In a block of more numbers than this, rows are sorted, so that rows far apart cost each other nothing.
const LARGE: usize = 100_000;

/// The most numbers a dense block may have: 1.6 GB.
const BLOCK_LIMIT: usize = 200_000_000;

/// Numbers that differ by so many roundings, of the numbers they come from, agree.
const AGREE: f64 = 64.0 * f64::EPSILON;

impl Dependency {
    /// Whether an adjustment that meets the independent rows meets this one as well, on every side, to what rounding explains:
    /// of what is wanted of it (a number made of numbers of `size`) and of the rows that it is made of, and of rows that differ
    /// by rounding from those that were meant, times the largest adjustment in reach of them (of all, where a metric couples them). It
    /// is the answer that is judged, not the factors of the combination.
    ///
    /// `rhs` and `size` have an entry for each row and side, `d` for each column and side.
    pub fn agrees(&self, system: &System, rhs: &[f64], size: &[f64], d: &[f64]) -> bool {
        (0..system.sides()).all(|side| {
            let missed = (rhs[self.row * system.sides() + side] - self.reached(system, d, side)).abs();
            // Written so that NaN does not agree.
            missed <= AGREE * self.scale(system, rhs, size, d, side)
        })
    }

    fn reached(&self, system: &System, d: &[f64], side: usize) -> f64 {
        system
            .rows()
            .iter_row(self.row)
            .map(|(column, value)| value * d[column * system.sides() + side])
            .sum()
    }

    /// The size of the numbers that the row's misfit is made of.
    fn scale(&self, system: &System, rhs: &[f64], size: &[f64], d: &[f64], side: usize) -> f64 {
        let (rows, sides) = (system.rows(), system.sides());
        let largest = |row: usize| {
            rows.iter_row(row).fold(0.0_f64, |most, (column, _)| most.max(d[column * sides + side].abs()))
        };
        let most = match system.metric() {
            SystemMetric::Least | SystemMetric::Weights(_) => {
                let others = self.combination.iter().map(|&(row, _)| largest(row));
                others.fold(largest(self.row), f64::max)
            }
            // What couples the columns spreads the rounding of one to all.
            _ => d.iter().skip(side).step_by(sides).fold(0.0_f64, |most, d| most.max(d.abs())),
        };
        let of = |row: usize| {
            let at = row * sides + side;
            size[at] + rhs[at].abs() + most * rows.row(row).1.iter().map(|v| v.abs()).sum::<f64>()
        };
        of(self.row) + self.combination.iter().map(|&(row, factor)| factor.abs() * of(row)).sum::<f64>()
    }
}

/// `S P A = [L 0] Q`: the rows `A`, scaled to unit length (`S`) and reordered (`P`), reflected from the right into
/// a lower triangle (paper 4, §4), one dense block for each set of rows connected by shared columns.
#[derive(Debug, Clone)]
pub(crate) struct Reflections {
    blocks: Vec<Block>,
    /// Rows without any entry.
    empty: Vec<usize>,
}

impl Reflections {
    /// Of the rows `kept`. A row whose part outside the span of the rows before it is no longer than `tolerance` (of its own
    /// length) depends on them. Reflections are backward stable, so that rounding leaves some `10 ε`, whatever the condition.
    pub(crate) fn new(
        rows: &SparseRows,
        kept: impl Iterator<Item = usize> + Clone,
        tolerance: f64,
        solver: &str,
    ) -> Result<Self, SolveError> {
        let mut empty = Vec::new();
        let mut blocks = Vec::new();
        for (members, columns) in components(rows, kept, &mut empty) {
            if members.len().saturating_mul(columns.len()) > BLOCK_LIMIT {
                let (equations, unknowns) = (members.len(), columns.len());
                return Err(SolveError::TooLarge {
                    solver: solver.into(),
                    equations,
                    unknowns,
                    better: "sparse",
                });
            }
            blocks.push(Block::new(rows, members, columns, tolerance));
        }
        Ok(Self { blocks, empty })
    }

    /// The shortest part of an independent row outside the span of those before it (of its own length): about the smallest
    /// singular value of the rows at unit length.
    pub(crate) fn weakest(&self) -> f64 {
        self.blocks.iter().flat_map(|b| &b.diagonal).fold(1.0, |least, d| d.abs().min(least))
    }

    /// The length of that part of each independent row, as long as the row is.
    pub(crate) fn outside(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let block = |b: &'_ Block| -> Vec<(usize, f64)> {
            let parts = b.rows.iter().zip(&b.diagonal).zip(&b.scale);
            parts.map(|((&row, d), s)| (row, d.abs() / s)).collect()
        };
        self.blocks.iter().flat_map(block)
    }

    pub(crate) fn rank(&self) -> usize {
        self.blocks.iter().map(|b| b.rank).sum()
    }

    /// The rows that are not independent.
    pub(crate) fn dependencies(&self) -> Vec<Dependency> {
        let mut dependencies: Vec<Dependency> =
            self.empty.iter().map(|&row| Dependency { row, combination: Vec::new() }).collect();
        for block in &self.blocks {
            dependencies.extend((block.rank..block.rows.len()).map(|i| block.dependency(i)));
        }
        dependencies.sort_by_key(|d| d.row);
        dependencies
    }

    /// Estimate of the condition number. Blocks share nothing: it is that of the largest and smallest singular values of all.
    pub(crate) fn condition(&self) -> f64 {
        let extremes = self.blocks.iter().map(Block::singular_values);
        let (high, low) = extremes.fold((0.0_f64, f64::INFINITY), |(h, l), (a, b)| (h.max(a), l.min(b)));
        if self.rank() == 0 { 1.0 } else { (high / low).max(1.0) }
    }

    /// The independent rows, ascending.
    pub(crate) fn independent(&self) -> Vec<usize> {
        let mut rows: Vec<usize> =
            self.blocks.iter().flat_map(|b| b.rows[..b.rank].iter().copied()).collect();
        rows.sort_unstable();
        rows
    }

    /// The shortest `e` with `A e = b` on the independent rows.
    pub(crate) fn solve_into(&self, b: &[f64], sides: usize, e: &mut [f64], work: &mut [f64]) {
        e.fill(0.0);
        for block in &self.blocks {
            for side in 0..sides {
                let x = &mut work[..block.columns.len()];
                x.fill(0.0);
                block.lower(b, sides, side, x);
                block.reflect_back(x);
                for (&column, value) in block.columns.iter().zip(&*x) {
                    e[column as usize * sides + side] = *value;
                }
            }
        }
    }

    /// `λ` with `A Aᵀ λ = b`: `Lᵀ S⁻¹ λ = y`, `L y = S b`.
    pub(crate) fn multipliers_into(
        &self,
        b: &[f64],
        sides: usize,
        multipliers: &mut [f64],
        work: &mut [f64],
    ) {
        multipliers.fill(0.0);
        for block in &self.blocks {
            for side in 0..sides {
                let y = &mut work[..block.columns.len()];
                block.lower(b, sides, side, y);
                block.upper(block.rank, y);
                for k in 0..block.rank {
                    multipliers[block.rows[k] * sides + side] = y[k] * block.scale[k];
                }
            }
        }
    }

    /// Numbers of scratch that the solves need.
    pub(crate) fn scratch(&self) -> usize {
        self.blocks.iter().map(|b| b.columns.len()).max().unwrap_or(0)
    }
}

/// The connected sets of rows (sharing columns), each with its columns; rows without entries go to `empty`.
fn components(
    rows: &SparseRows,
    kept: impl Iterator<Item = usize> + Clone,
    empty: &mut Vec<usize>,
) -> Vec<(Vec<usize>, Vec<u32>)> {
    let mut parent: Vec<u32> = (0..rows.width() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for row in kept.clone() {
        let (columns, _) = rows.row(row);
        if let Some((&first, rest)) = columns.split_first() {
            for &column in rest {
                let (a, b) = (root(&mut parent, first), root(&mut parent, column));
                // The smaller number becomes the root: the outcome does not depend on the order of unions.
                let (low, high) = (a.min(b), a.max(b));
                parent[high as usize] = low;
            }
        }
    }
    let mut number = vec![u32::MAX; rows.width()];
    let mut sets: Vec<(Vec<usize>, Vec<u32>)> = Vec::new();
    for row in kept {
        let (columns, values) = rows.row(row);
        let Some(&first) = columns.first().filter(|_| values.iter().any(|v| *v != 0.0)) else {
            empty.push(row);
            continue;
        };
        let r = root(&mut parent, first) as usize;
        if number[r] == u32::MAX {
            number[r] = sets.len() as u32;
            sets.push((Vec::new(), Vec::new()));
        }
        sets[number[r] as usize].0.push(row);
    }
    for column in 0..rows.width() as u32 {
        let r = root(&mut parent, column) as usize;
        if number[r] != u32::MAX {
            sets[number[r] as usize].1.push(column);
        }
    }
    sets
}

/// The independent rows of a system, and what was left out. For solvers that find a pivot they do not trust. The metric does
/// not matter to which rows depend on others, and is not asked: taking it out would add its condition to the rounding, and
/// connect rows that share nothing.
pub(crate) fn reduce(system: &System, solver: &str) -> Result<(Vec<usize>, Vec<Dependency>), SolveError> {
    let rows = system.rows();
    let reflections = Reflections::new(rows, 0..rows.len(), system.tolerance(), solver)?;
    Ok((reflections.independent(), reflections.dependencies()))
}

/// Estimate of the condition number of some rows that are independent.
pub(crate) fn condition_of(rows: &SparseRows, kept: &[usize]) -> f64 {
    Reflections::new(rows, kept.iter().copied(), 0.0, "").map_or(f64::INFINITY, |r| r.condition())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::block::side_by_side;
    use super::*;

    /// Rows along an edge of a surface, that touch three strips of columns which are far apart by number, one of them twice: the same rank, the later one of
    /// the two left out, and the same least answer, as where the columns are numbered side by side.
    #[test]
    fn rows_along_an_edge_are_put_side_by_side() {
        const LENGTH: usize = 150;
        let system = |number: &dyn Fn(usize, usize) -> usize| {
            let mut rows = SparseRows::new(3 * (LENGTH + 3));
            let row = |k: usize, strip: usize| {
                let at = move |j: usize| 1.0 / (1.0 + (7 * k + 3 * j + strip) as f64 % 5.0);
                (0..=strip).flat_map(move |s| (0..4).map(move |j| (s, k + j, at(j + s))))
            };
            for strip in 0..3 {
                for k in 0..LENGTH {
                    let mut all: Vec<_> = row(k, strip).map(|(s, j, v)| (number(s, j), v)).collect();
                    all.sort_by_key(|(column, _)| *column);
                    rows.push(all);
                }
            }
            let mut again: Vec<_> = row(70, 2).map(|(s, j, v)| (number(s, j), 2.0 * v)).collect();
            again.sort_by_key(|(column, _)| *column);
            rows.push(again);
            rows
        };
        let strips = |s: usize, j: usize| s * (LENGTH + 3) + j;
        let beside = |s: usize, j: usize| 3 * j + s;
        let mut answers = Vec::new();
        for number in [&strips as &dyn Fn(usize, usize) -> usize, &beside] {
            let rows = system(number);
            let found = Reflections::new(&rows, 0..rows.len(), 1e-12, "").unwrap();
            assert_eq!(found.rank(), 3 * LENGTH);
            let dependencies = found.dependencies();
            assert_eq!(dependencies.iter().map(|d| d.row).collect::<Vec<_>>(), [3 * LENGTH]);
            let combination = &dependencies[0].combination;
            assert!(combination.len() == 1 && combination[0].0 == 2 * LENGTH + 70, "{combination:?}");
            assert!((combination[0].1 - 2.0).abs() < 1e-12, "{combination:?}");
            let rhs: Vec<f64> = (0..=3 * LENGTH).map(|i| (i as f64).sin()).collect();
            let (mut answer, mut work) = (vec![0.0; rows.width()], vec![0.0; found.scratch()]);
            found.solve_into(&rhs, 1, &mut answer, &mut work);
            answers.push(
                (0..LENGTH + 3)
                    .flat_map(|j| (0..3).map(move |s| (s, j)))
                    .map(|(s, j)| answer[number(s, j)])
                    .collect::<Vec<_>>(),
            );
            // Rows meet few columns: those that are far apart by number are put side by side.
            let mut members: Vec<usize> = (0..3 * LENGTH).collect();
            let columns: Vec<u32> = (0..rows.width() as u32).collect();
            let place = side_by_side(&rows, &mut members, &columns);
            let ends = |row: usize| rows.iter_row(row).map(|(column, _)| place[column]);
            let widest =
                members.iter().map(|&row| ends(row).max().unwrap_or(0) - ends(row).min().unwrap_or(0)).max();
            assert!(widest < Some(60), "{widest:?}");
        }
        let largest = answers[0].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (x, y) in answers[0].iter().zip(&answers[1]) {
            assert!((x - y).abs() < 1e-7 * largest, "{x} {y}");
        }
    }
}
