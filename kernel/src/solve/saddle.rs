//! The bordered matrix `[P Gᵀ; G 0]` of a least adjustment under equations, factored within its envelope.

use super::symmetric::Symmetric;
use super::system::SparseRows;

/// The most multiplications of a factorisation.
const WORK: usize = 50_000_000;
/// A row whose squared length outside the span of the rows before it is this part of its own (in the metric) is left out.
const DEPENDENT: f64 = 1e-12;

/// `P` and `G`, and the order of the unknowns in which the envelope of `P` is narrow.
#[derive(Debug)]
pub(super) struct Bordered<'a> {
    metric: &'a Symmetric,
    rows: &'a SparseRows,
    /// The unknowns in their order, and the place of each in it.
    order: Vec<usize>,
    place: Vec<usize>,
}

/// `L D Lᵀ` of the bordered matrix, with each row of `G` right behind the last unknown that it touches: then every leading
/// part is a least adjustment under equations of its own, and regular, and the envelope stays as narrow as `P` and the rows
/// are. No pivots are sought, so that answers want to be corrected by their own residuals.
#[derive(Debug)]
pub(super) struct Saddle {
    nodes: Vec<Node>,
    first: Vec<usize>,
    starts: Vec<usize>,
    lower: Vec<f64>,
    /// Reciprocals of `D`; zero for rows that were left out.
    reciprocals: Vec<f64>,
    weakest: f64,
}

/// Why a bordered matrix is not factored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It would be too much work.
    Work,
    /// `P` is not positive definite, at this unknown.
    Indefinite(usize),
}

#[derive(Debug, Clone, Copy)]
enum Node {
    Unknown(usize),
    /// Which of the kept rows.
    Row(usize),
}

impl<'a> Bordered<'a> {
    pub(super) fn new(metric: &'a Symmetric, rows: &'a SparseRows) -> Self {
        let n = metric.size();
        let envelope = |place: &[usize]| {
            let reach = |i: usize| metric.row(i).map(|(j, _)| place[i].saturating_sub(place[j])).max();
            (0..n).filter_map(reach).sum::<usize>()
        };
        let inverse = |order: &[usize]| {
            let mut place = vec![0; n];
            order.iter().enumerate().for_each(|(at, &unknown)| place[unknown] = at);
            place
        };
        let (natural, narrow) = ((0..n).collect::<Vec<_>>(), metric.narrow_order());
        let (as_is, turned) = (inverse(&natural), inverse(&narrow));
        if envelope(&turned) < envelope(&as_is) {
            Self { metric, rows, order: narrow, place: turned }
        } else {
            Self { metric, rows, order: natural, place: as_is }
        }
    }

    /// The last place that a row touches.
    pub(super) fn last(&self, row: usize) -> Option<usize> {
        self.rows.iter_row(row).filter(|(_, v)| *v != 0.0).map(|(column, _)| self.place[column]).max()
    }

    /// Factors with some of the rows, which must come by ascending last place.
    ///
    /// # Errors
    /// When that is too much work, or `P` is not positive definite.
    pub(super) fn factor(&self, kept: &[usize]) -> Result<Saddle, Refusal> {
        let mut nodes = Vec::with_capacity(self.order.len() + kept.len());
        let mut at = vec![0; self.order.len()];
        let mut waiting = (0..kept.len()).peekable();
        for (place, &unknown) in self.order.iter().enumerate() {
            at[unknown] = nodes.len();
            nodes.push(Node::Unknown(unknown));
            while let Some(k) = waiting.next_if(|&k| self.last(kept[k]).is_none_or(|last| last <= place)) {
                nodes.push(Node::Row(k));
            }
        }
        nodes.extend(waiting.map(Node::Row));
        let entries = |i: usize, put: &mut dyn FnMut(usize, f64)| match nodes[i] {
            Node::Unknown(u) => {
                self.metric.row(u).filter(|(j, _)| at[*j] <= i).for_each(|(j, v)| put(at[j], v));
            }
            Node::Row(k) => {
                self.rows.iter_row(kept[k]).filter(|(_, v)| *v != 0.0).for_each(|(j, v)| put(at[j], v));
            }
        };
        let mut first = Vec::with_capacity(nodes.len());
        let mut starts = vec![0];
        let mut work = 0;
        for i in 0..nodes.len() {
            let mut low = i;
            entries(i, &mut |j, _| low = low.min(j));
            work += (low..i).map(|j: usize| j - low.max(first[j])).sum::<usize>();
            if work > WORK {
                return Err(Refusal::Work);
            }
            first.push(low);
            starts.push(starts[i] + i - low);
        }
        let mut lower = vec![0.0; starts[nodes.len()]];
        let mut reciprocals = Vec::with_capacity(nodes.len());
        let mut weakest = 1.0_f64;
        for i in 0..nodes.len() {
            let (done, rest) = lower.split_at_mut(starts[i]);
            let (low, row) = (first[i], &mut rest[..i - first[i]]);
            let mut diagonal = 0.0;
            entries(i, &mut |j, v| if j == i { diagonal += v } else { row[j - low] += v });
            let whole = diagonal;
            for j in low..i {
                let other = &done[starts[j]..starts[j + 1]];
                let from = low.max(first[j]);
                let products: f64 =
                    row[from - low..j - low].iter().zip(&other[from - first[j]..]).map(|(a, b)| a * b).sum();
                row[j - low] -= products;
            }
            // Of a row of G: the squared length, and what the rows before took of it.
            let (mut length, mut taken) = (0.0, 0.0);
            for (w, reciprocal) in row.iter_mut().zip(&reciprocals[low..]) {
                let share = *w * *w * reciprocal;
                if *reciprocal > 0.0 {
                    length += share;
                } else {
                    taken -= share;
                }
                *w *= reciprocal;
            }
            let pivot = diagonal - length + taken;
            if matches!(nodes[i], Node::Row(_)) {
                let share = -pivot / length;
                // Nothing is left of a row without a length, nor of what is no number.
                weakest = weakest.min(if share > 0.0 { share } else { 0.0 });
            }
            reciprocals.push(match nodes[i] {
                Node::Unknown(_) if pivot > 4.0 * f64::EPSILON * whole && pivot.is_finite() => 1.0 / pivot,
                Node::Unknown(u) => return Err(Refusal::Indefinite(u)),
                Node::Row(_) if -pivot > DEPENDENT * length && pivot.is_finite() => 1.0 / pivot,
                Node::Row(_) => 0.0,
            });
        }
        Ok(Saddle { nodes, first, starts, lower, reciprocals, weakest })
    }
}

impl Saddle {
    /// Adds to `x` and `y` the solution of `P x + Gᵀ y = a`, `G x = b`. Of rows that were left out, `y` stays. `all` is room for
    /// it.
    pub(super) fn solve(&self, a: &[f64], b: &[f64], x: &mut [f64], y: &mut [f64], all: &mut Vec<f64>) {
        let given = |node: &Node| match *node {
            Node::Unknown(u) => a[u],
            Node::Row(k) => b[k],
        };
        all.clear();
        all.extend(self.nodes.iter().map(given));
        for i in 0..all.len() {
            let row = &self.lower[self.starts[i]..self.starts[i + 1]];
            let sum: f64 = row.iter().zip(&all[self.first[i]..]).map(|(l, v)| l * v).sum();
            all[i] -= sum;
        }
        all.iter_mut().zip(&self.reciprocals).for_each(|(v, r)| *v *= r);
        for i in (0..all.len()).rev() {
            let row = &self.lower[self.starts[i]..self.starts[i + 1]];
            let value = all[i];
            all[self.first[i]..i].iter_mut().zip(row).for_each(|(v, l)| *v -= l * value);
        }
        for ((node, &mut value), reciprocal) in self.nodes.iter().zip(all).zip(&self.reciprocals) {
            match *node {
                Node::Unknown(u) => x[u] += value,
                Node::Row(k) if *reciprocal != 0.0 => y[k] += value,
                Node::Row(_) => {}
            }
        }
    }

    /// The least squared length of a row outside the span of those before it, as a share of its own (in the metric).
    pub(super) fn weakest(&self) -> f64 {
        self.weakest
    }

    /// Which of the kept rows were left out, for they are combinations of others.
    pub(super) fn left_out(&self) -> impl Iterator<Item = usize> + '_ {
        self.nodes.iter().zip(&self.reciprocals).filter_map(|(node, reciprocal)| match node {
            Node::Row(k) if *reciprocal == 0.0 => Some(*k),
            _ => None,
        })
    }
}
