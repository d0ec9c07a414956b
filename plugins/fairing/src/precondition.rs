//! What makes the search short: a Cholesky factor of `AᵀA + δ I + ρ FᵀF` within an envelope.
//!
//! Restricted to adjustments that the constraints allow (`F d = 0`), it is `AᵀA + δ I` as `ρ` grows: there the energy's
//! eigenvalues become 1, but for those below `δ`, the few longest waves of many vertices. So the number of steps hardly
//! depends on the number of vertices. `δ` is what rounding leaves of a zero eigenvalue, so that directions without energy do
//! no harm; the answer depends on neither `δ` nor `ρ`.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Grid;
use loftsman_kernel::solve::{EnvelopeCholesky, Symmetric, System};

use crate::squares::Squares;

/// `ρ`, times the largest diagonal entry of `AᵀA`, for constraints scaled to unit length.
const PENALTY: f64 = 1e3;
/// Rows that touch more vertices than this stay out: they would fill the envelope, and each costs a step or two.
const WIDE: usize = 64;
/// The most multiplications for the factor that treats axes apart; beyond it, constraints that couple axes stay out.
const COUPLED_WORK: f64 = 4e9;
/// The most numbers the envelope may have: 1.6 GB.
pub(crate) const ENVELOPE_LIMIT: usize = 200_000_000;

pub(crate) struct Preconditioner {
    /// The place of each vertex among those that may move, in the factor's order.
    place: Vec<u32>,
    factor: EnvelopeCholesky,
    /// Unknowns a vertex in the factor: 1 where the axes are alike, 3 where they are not.
    axes: usize,
    work: Vec<f64>,
}

/// The place of a vertex that may not move.
pub(crate) const LOCKED: u32 = u32::MAX;

impl Preconditioner {
    /// Factors for the vertices that may move. `None` where the envelope is beyond all memory, or nothing can be factored.
    pub(crate) fn new(squares: &Squares, free: &[bool], grid: &Grid, system: &System) -> Option<Self> {
        let rows = Rows::new(system, free);
        let place = order(squares, free, grid, &rows);
        let count = place.iter().filter(|&&p| p != LOCKED).count();
        let alone = envelope(squares, &place, count, &rows, false);
        let work = work(&alone);
        // Axes apart: three times the rows, each three times as long.
        let coupled = rows.coupled() && 27.0 * work <= COUPLED_WORK;
        let axes = if coupled { 3 } else { 1 };
        let first = if coupled {
            let wide = envelope(squares, &place, count, &rows, true);
            wide.iter().flat_map(|&f| [3 * f; 3]).collect()
        } else {
            alone
        };
        if first.iter().enumerate().map(|(i, &f)| i + 1 - f as usize).sum::<usize>() > ENVELOPE_LIMIT {
            return None;
        }
        let mut matrix = Envelope::new(first);
        matrix.energy(squares, &place, axes);
        let largest = matrix.diagonal().fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        rows.add(system, &place, axes, PENALTY * largest, &mut matrix);
        let scale = matrix.diagonal().fold(0.0, f64::max);
        let mut shift = 32.0 * f64::EPSILON * scale;
        for _ in 0..6 {
            let entry = |i: usize, j: usize| matrix.at(i, j) + if i == j { shift } else { 0.0 };
            if let Ok(factor) = EnvelopeCholesky::factor(matrix.first.clone(), 0.0, entry) {
                let work = vec![0.0; 3 * count];
                return Some(Self { place, factor, axes, work });
            }
            shift *= 100.0;
        }
        None
    }

    /// `out = C r`.
    pub(crate) fn apply(&mut self, r: &[Vector], out: &mut [Vector]) {
        let sides = 3 / self.axes;
        for (&place, r) in self.place.iter().zip(r) {
            if place != LOCKED {
                self.work[3 * place as usize..3 * place as usize + 3].copy_from_slice(r.as_slice());
            }
        }
        self.factor.solve(&mut self.work, sides);
        for (&place, out) in self.place.iter().zip(out) {
            *out = match place {
                LOCKED => Vector::zeros(),
                _ => Vector::from_column_slice(&self.work[3 * place as usize..3 * place as usize + 3]),
            };
        }
    }
}

/// The rows of the constraints that are narrow enough to take in, as vertices.
pub(crate) struct Rows {
    /// Row of the system, and its vertices.
    narrow: Vec<(usize, Vec<u32>)>,
    sides: usize,
}

impl Rows {
    /// No rows at all.
    pub(crate) fn none() -> Self {
        Self { narrow: Vec::new(), sides: 3 }
    }

    fn new(system: &System, free: &[bool]) -> Self {
        let (rows, sides) = (system.rows(), system.sides());
        let vertex = |column: usize| {
            let global = system.touched()[column];
            if sides == 3 { global } else { global / 3 }
        };
        let mut narrow = Vec::new();
        for row in 0..rows.len() {
            let mut vertices: Vec<u32> = rows.iter_row(row).map(|(c, _)| vertex(c) as u32).collect();
            vertices.dedup();
            let known = vertices.iter().all(|&v| free.get(v as usize) == Some(&true));
            if known && !vertices.is_empty() && vertices.len() <= WIDE {
                narrow.push((row, vertices));
            }
        }
        Self { narrow, sides }
    }

    fn coupled(&self) -> bool {
        self.sides == 1 && !self.narrow.is_empty()
    }

    /// Adds `ρ FᵀF`, rows scaled to unit length.
    fn add(&self, system: &System, place: &[u32], axes: usize, penalty: f64, matrix: &mut Envelope) {
        if (self.sides == 1) != (axes == 3) {
            return;
        }
        for (row, _) in &self.narrow {
            let norm = system.rows().norm(*row);
            if !(norm > 0.0 && norm.is_finite()) {
                continue;
            }
            let terms: Vec<(usize, f64)> = system
                .rows()
                .iter_row(*row)
                .map(|(column, value)| {
                    let global = system.touched()[column];
                    let at = if axes == 1 {
                        place[global] as usize
                    } else {
                        3 * place[global / 3] as usize + global % 3
                    };
                    (at, value / norm)
                })
                .collect();
            for &(i, a) in &terms {
                for &(j, b) in terms.iter().filter(|(j, _)| *j <= i) {
                    matrix.add(i, j, penalty * a * b);
                }
            }
        }
    }
}

/// A symmetric matrix kept from each row's first entry to its diagonal.
pub(crate) struct Envelope {
    pub(crate) first: Vec<u32>,
    starts: Vec<usize>,
    values: Vec<f64>,
}

impl Envelope {
    pub(crate) fn new(first: Vec<u32>) -> Self {
        let mut starts = Vec::with_capacity(first.len() + 1);
        let mut total = 0;
        starts.push(0);
        for (i, &f) in first.iter().enumerate() {
            total += i + 1 - f as usize;
            starts.push(total);
        }
        Self { first, starts, values: vec![0.0; total] }
    }

    /// Adds `AᵀA` and the tethers, for each of `axes` unknowns a place.
    pub(crate) fn energy(&mut self, squares: &Squares, place: &[u32], axes: usize) {
        for block in squares.blocks() {
            let width = block.vertices.len();
            for (i, &vi) in block.vertices.iter().enumerate() {
                for (j, &vj) in block.vertices[..=i].iter().enumerate() {
                    let (a, b) = (place[vi as usize], place[vj as usize]);
                    if a == LOCKED || b == LOCKED {
                        continue;
                    }
                    let value: f64 = block.rows.chunks_exact(width).map(|row| row[i] * row[j]).sum();
                    for axis in 0..axes {
                        self.add(a as usize * axes + axis, b as usize * axes + axis, value);
                    }
                }
            }
        }
        for (&place, weight) in place.iter().zip(squares.tethers()) {
            if place != LOCKED {
                for axis in 0..axes {
                    let at = place as usize * axes + axis;
                    self.add(at, at, *weight);
                }
            }
        }
    }

    fn add(&mut self, i: usize, j: usize, value: f64) {
        let (i, j) = (i.max(j), i.min(j));
        self.values[self.starts[i] + j - self.first[i] as usize] += value;
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.values[self.starts[i] + j - self.first[i] as usize]
    }

    pub(crate) fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        self.starts[1..].iter().map(|&end| self.values[end - 1])
    }
}

/// The first place that each place shares a square or a constraint with.
pub(crate) fn envelope(squares: &Squares, place: &[u32], count: usize, rows: &Rows, all: bool) -> Vec<u32> {
    let mut first: Vec<u32> = (0..count as u32).collect();
    let mut meet = |vertices: &[u32]| {
        let places = || vertices.iter().map(|&v| place[v as usize]).filter(|&p| p != LOCKED);
        let Some(low) = places().min() else { return };
        for p in places() {
            first[p as usize] = first[p as usize].min(low);
        }
    };
    squares.blocks().for_each(|block| meet(block.vertices));
    if all || rows.sides == 3 {
        rows.narrow.iter().for_each(|(_, vertices)| meet(vertices));
    }
    first
}

/// Multiplications of a factorisation within an envelope, about.
fn work(first: &[u32]) -> f64 {
    let lengths = || first.iter().enumerate().map(|(i, &f)| (i + 1 - f as usize) as f64);
    let mean = lengths().sum::<f64>() / first.len().max(1) as f64;
    // A long row meets rows that are as long as most.
    lengths().map(|l| 0.5 * l * l.min(2.0 * mean)).sum()
}

/// An order of the vertices that keeps the envelope small: as they are, along the other direction of a grid, or (where
/// constraints tie distant vertices together) by breadth-first search.
pub(crate) fn order(squares: &Squares, free: &[bool], grid: &Grid, rows: &Rows) -> Vec<u32> {
    let numbered = |order: &mut dyn Iterator<Item = usize>| {
        let mut place = vec![LOCKED; free.len()];
        let moving = order.filter(|&v| free.get(v) == Some(&true));
        for (next, vertex) in moving.enumerate() {
            place[vertex] = next as u32;
        }
        place
    };
    let count = free.iter().filter(|f| **f).count();
    let cost = |place: &[u32]| work(&envelope(squares, place, count, rows, true));
    let natural = numbered(&mut (0..free.len()));
    let mut best = (cost(&natural), natural);
    if grid.rows > 1 && grid.columns > grid.rows && grid.rows * grid.columns == free.len() {
        let across = |k: usize| (k % grid.rows) * grid.columns + k / grid.rows;
        let turned = numbered(&mut (0..free.len()).map(across));
        let cost = cost(&turned);
        if cost < best.0 {
            best = (cost, turned);
        }
    }
    let bare = work(&envelope(squares, &best.1, count, &Rows::none(), false));
    if best.0 > 6.0 * bare && best.0 > 1e6 {
        let mut pairs = Vec::new();
        let sets = squares.blocks().map(|b| b.vertices).chain(rows.narrow.iter().map(|(_, v)| v.as_slice()));
        for set in sets {
            for (i, &a) in set.iter().enumerate() {
                pairs.extend(set[..i].iter().map(|&b| (a.max(b), a.min(b))));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let pattern = Symmetric::from_entries(
            free.len(),
            pairs.into_iter().map(|(a, b)| (a as usize, b as usize, 1.0)),
        );
        let searched = numbered(&mut pattern.narrow_order().into_iter());
        if cost(&searched) < best.0 {
            return searched;
        }
    }
    best.1
}
