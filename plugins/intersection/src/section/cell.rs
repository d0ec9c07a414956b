//! Cells in which the section is a graph, or is not.

use loftsman_kernel::Vector;

use crate::bernstein::{Polynomial, root, value};
use crate::net::{Jet, Piece};
use crate::pieces::Pieces;

/// Halvings after which a cell's edges are told by its corners alone: cells are smaller then, by far, than the loop that a plane moved by a 1e-9 of
/// the size cuts off a peak, 1e-5 of it; larger ones would miss where that passes an edge twice.
const CORNERS: usize = 44;
/// Halvings after which a cell is given up.
const DEEPEST: usize = 64;

/// A rectangle of one patch, and the distance's coefficients on it.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    pub(crate) patch: usize,
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    values: Vec<f64>,
    depth: usize,
    /// The parameter that the section runs along.
    pub(crate) along: usize,
}

/// One end of the section's part in a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    pub(crate) at: [f64; 2],
    /// The edge: the direction whose parameter is fixed on it, and whether it is the cell's upper one.
    pub(crate) edge: (usize, bool),
}

/// A cell with the section's part in it.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) cell: Cell,
    pub(crate) ends: [End; 2],
}

/// All cells of a surface that the section passes.
#[derive(Debug)]
pub(crate) struct Cells<'a> {
    pieces: &'a Pieces,
    normal: Vector,
    distance: f64,
    shift: f64,
    pub(crate) parts: Vec<Part>,
    pub(crate) coincident: Vec<[(f64, f64); 2]>,
    pub(crate) undecided: Vec<[(f64, f64); 2]>,
}

impl<'a> Cells<'a> {
    pub(crate) fn new(pieces: &'a Pieces, normal: Vector, distance: f64, shift: f64) -> Self {
        let (parts, coincident, undecided) = (Vec::new(), Vec::new(), Vec::new());
        Self { pieces, normal, distance, shift, parts, coincident, undecided }
    }

    pub(crate) fn piece(&self, cell: &Cell) -> &Piece {
        &self.pieces.pieces[cell.patch]
    }

    pub(crate) fn search(&mut self, most: usize) {
        let mut count = 0;
        for (patch, piece) in self.pieces.pieces.iter().enumerate() {
            let (normal, distance) = (self.normal, self.distance);
            let distances = |shift: f64| {
                piece.net.iter().map(move |c| {
                    normal.x * c[0] + normal.y * c[1] + normal.z * c[2] + (distance + shift) * c[3]
                })
            };
            let box_of = [(piece.low[0], piece.high[0]), (piece.low[1], piece.high[1])];
            if distances(0.0).zip(&piece.net).all(|(d, c)| d.abs() <= 0.5 * self.shift.abs() * c[3]) {
                self.coincident.push(box_of);
                continue;
            }
            let values = distances(self.shift).collect();
            let mut open = vec![Cell { patch, low: piece.low, high: piece.high, values, depth: 0, along: 0 }];
            while let Some(mut cell) = open.pop() {
                let f = Polynomial::new(cell.values.clone());
                if f.has_one_sign() {
                    continue;
                }
                count += 1;
                if let Some(along) = graph(&cell, piece.orders) {
                    cell.along = along;
                    self.parts.extend(part(cell, piece.orders));
                    continue;
                }
                let splits = |d: usize| {
                    let middle = 0.5 * cell.low[d] + 0.5 * cell.high[d];
                    cell.low[d] < middle && middle < cell.high[d]
                };
                let direction = cell.depth % 2;
                if cell.depth >= DEEPEST || count > most || !splits(direction) {
                    self.undecided.push([(cell.low[0], cell.high[0]), (cell.low[1], cell.high[1])]);
                    if count > most {
                        return;
                    }
                    continue;
                }
                open.extend(halves(&cell, piece.orders, direction));
            }
        }
    }

    /// The surface's point, in the frame, at parameters.
    pub(crate) fn point(&self, at: [f64; 2]) -> Option<Vector> {
        let holds = |p: &&Piece| (0..2).all(|d| p.low[d] <= at[d] && at[d] <= p.high[d]);
        let piece = self.pieces.pieces.iter().find(holds)?;
        Some(jet(piece, at).point)
    }

    /// The distance's derivatives by the parameters beside the jet of the patch: scaled to the parameters.
    pub(crate) fn jet(&self, cell: &Cell, at: [f64; 2]) -> (Jet, [f64; 2]) {
        let jet = jet(self.piece(cell), at);
        (jet, jet.along.map(|d| self.normal.dot(&d)))
    }
}

/// The point and derivatives by the shape's parameters.
fn jet(piece: &Piece, at: [f64; 2]) -> Jet {
    let widths = [0, 1].map(|d| piece.high[d] - piece.low[d]);
    let local = [0, 1].map(|d| ((at[d] - piece.low[d]) / widths[d]).clamp(0.0, 1.0));
    let mut jet = piece.jet(local);
    for d in 0..2 {
        jet.along[d] /= widths[d];
    }
    jet
}

/// The line of coefficients on an edge.
fn edge(cell: &Cell, orders: [usize; 2], fixed: usize, upper: bool) -> Polynomial {
    let [rows, columns] = orders;
    Polynomial::new(if fixed == 0 {
        let row = if upper { rows - 1 } else { 0 };
        cell.values[row * columns..(row + 1) * columns].to_vec()
    } else {
        let column = if upper { columns - 1 } else { 0 };
        cell.values.iter().skip(column).step_by(columns).copied().collect()
    })
}

/// The parameter along which the section is a graph, where it is one and meets each edge once at most.
fn graph(cell: &Cell, orders: [usize; 2]) -> Option<usize> {
    let [rows, columns] = orders;
    let value = |i: usize, j: usize| cell.values[i * columns + j];
    // The least slope, where all go one way.
    let one_way = |direction: usize| {
        let (r, c) = if direction == 0 { (rows - 1, columns) } else { (rows, columns - 1) };
        let slope = |k: usize| {
            let (i, j) = (k / c, k % c);
            let next = if direction == 0 { value(i + 1, j) } else { value(i, j + 1) };
            next - value(i, j)
        };
        let all = (0..r * c).map(slope);
        let one = all.clone().all(|s| s > 0.0) || all.clone().all(|s| s < 0.0);
        one.then(|| all.map(f64::abs).fold(f64::INFINITY, f64::min))
    };
    let simple = |fixed: usize| {
        [false, true].into_iter().all(|upper| {
            let line = edge(cell, orders, fixed, upper);
            line.has_one_sign() || line.is_monotone() || cell.depth >= CORNERS
        })
    };
    // Monotone across v: a graph over u, whose edges are those of fixed v. Where both are possible, the steeper: slopes of a patch that
    // is level in a direction are rounding, which may go one way.
    let across = [(1, 0), (0, 1)].map(|(across, along)| {
        let slope = one_way(across).filter(|_| simple(across))?;
        Some((slope, along))
    });
    match across {
        [Some((a, along)), Some((b, other))] => Some(if b > a { other } else { along }),
        [one, other] => one.or(other).map(|(_, along)| along),
    }
}

/// The part of the section in a cell that is a graph; none where it only passes a corner.
fn part(cell: Cell, orders: [usize; 2]) -> Option<Part> {
    let mut ends = Vec::with_capacity(2);
    for (fixed, upper) in [(0, false), (0, true), (1, false), (1, true)] {
        let line = edge(&cell, orders, fixed, upper);
        if (line.first() < 0.0) == (line.last() < 0.0) {
            continue;
        }
        let other = 1 - fixed;
        let mut at = [0.0; 2];
        at[fixed] = if upper { cell.high[fixed] } else { cell.low[fixed] };
        let (low, high) = (cell.low[other], cell.high[other]);
        at[other] = (low + (high - low) * root(&line)).clamp(low, high);
        ends.push(End { at, edge: (fixed, upper) });
    }
    let [first, second] = ends[..] else { return None };
    Some(Part { cell, ends: [first, second] })
}

/// The section's parameters in a cell where the one along it has this value.
pub(crate) fn across(cell: &Cell, orders: [usize; 2], along: f64) -> [f64; 2] {
    let (d, other) = (cell.along, 1 - cell.along);
    let local = ((along - cell.low[d]) / (cell.high[d] - cell.low[d])).clamp(0.0, 1.0);
    let [rows, columns] = orders;
    let line = |k: usize| {
        if d == 0 {
            value((0..rows).map(|i| cell.values[i * columns + k]), local)
        } else {
            value((0..columns).map(|j| cell.values[k * columns + j]), local)
        }
    };
    let f = Polynomial::new((0..if d == 0 { columns } else { rows }).map(line).collect());
    // Beyond the part's own ends it is at an edge.
    let x = if (f.first() < 0.0) == (f.last() < 0.0) {
        if f.first().abs() < f.last().abs() { 0.0 } else { 1.0 }
    } else {
        root(&f)
    };
    let mut at = [0.0; 2];
    at[d] = along;
    at[other] =
        (cell.low[other] + (cell.high[other] - cell.low[other]) * x).clamp(cell.low[other], cell.high[other]);
    at
}

fn halves(cell: &Cell, orders: [usize; 2], direction: usize) -> [Cell; 2] {
    let [rows, columns] = orders;
    let (steps, step, lines, line) =
        if direction == 0 { (rows, columns, columns, 1) } else { (columns, 1, rows, columns) };
    let middle = 0.5 * cell.low[direction] + 0.5 * cell.high[direction];
    let (mut left, mut right) = (cell.clone(), cell.clone());
    for l in 0..lines {
        let at = |s: usize| l * line + s * step;
        for r in 1..steps {
            for s in 0..steps - r {
                right.values[at(s)] = 0.5 * right.values[at(s)] + 0.5 * right.values[at(s + 1)];
            }
            left.values[at(r)] = right.values[at(0)];
        }
    }
    left.high[direction] = middle;
    right.low[direction] = middle;
    left.depth += 1;
    right.depth += 1;
    [left, right]
}
