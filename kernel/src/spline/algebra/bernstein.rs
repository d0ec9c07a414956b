//! B-splines in Bernstein form, piece by piece: the form in which polynomials are multiplied and integrated.

use super::Coefficient;
use crate::error::{Error, Result};
use crate::space::{MAX_ORDER, Space};

/// On each piece between neighbours of a partition, the `p + 1` B-splines that live there as Bernstein polynomials of it.
#[derive(Debug, Clone)]
pub(super) struct Pieces {
    order: usize,
    /// The control vertices of these B-splines, `order` a piece.
    vertices: Vec<u32>,
    /// Their Bernstein coefficients, `order²` a piece: coefficient `s` of function `i` at `i · order + s`.
    rows: Vec<f64>,
}

impl Pieces {
    /// `O(p³)` a piece. The partition holds all of the space's breakpoints.
    pub(super) fn new(space: &Space, partition: &[f64]) -> Self {
        let (p, t, end) = (space.degree(), space.flat(), space.unrolled_len());
        let (order, count) = (p + 1, partition.len().saturating_sub(1));
        let mut pieces = Self { order, vertices: Vec::new(), rows: Vec::new() };
        pieces.vertices.reserve(count * order);
        pieces.rows.reserve(count * order * order);
        let mut span = p;
        let mut values = [0.0; MAX_ORDER];
        for ends in partition.windows(2) {
            while span + 1 < end && t[span + 1] <= ends[0] {
                span += 1;
            }
            pieces.vertices.extend((span - p..=span).map(|k| space.vertex(k) as u32));
            let start = pieces.rows.len();
            pieces.rows.resize(start + order * order, 0.0);
            for s in 0..=p {
                blossom(t, span, p, |r| ends[usize::from(r + s >= p)], &mut values);
                for (i, value) in values[..order].iter().enumerate() {
                    pieces.rows[start + i * order + s] = *value;
                }
            }
        }
        pieces
    }

    pub(super) fn order(&self) -> usize {
        self.order
    }

    /// The control vertices of a piece.
    pub(super) fn vertices(&self, piece: usize) -> &[u32] {
        &self.vertices[piece * self.order..(piece + 1) * self.order]
    }

    /// The Bernstein coefficients of function `i` of a piece.
    pub(super) fn row(&self, piece: usize, i: usize) -> &[f64] {
        let start = (piece * self.order + i) * self.order;
        &self.rows[start..start + self.order]
    }

    /// Bernstein coefficients of `Σ a_i N_i` on all pieces, `order` each; `a(i)` is the coefficient of vertex `i`.
    pub(super) fn coefficients<T: Coefficient>(&self, a: impl Fn(usize) -> T) -> Vec<T> {
        let mut all = vec![T::zero(); self.vertices.len()];
        for (piece, out) in all.chunks_exact_mut(self.order).enumerate() {
            for (i, vertex) in self.vertices(piece).iter().enumerate() {
                let a = a(*vertex as usize);
                for (out, row) in out.iter_mut().zip(self.row(piece, i)) {
                    *out = *out + a * *row;
                }
            }
        }
        all
    }
}

/// The values at `u_0, …, u_{p-1}` of the polar forms of the B-splines `span - p ..= span` on their span (Ramshaw 1987), into
/// `out`: de Boor's recurrence with another argument in each step. `O(p²)`.
pub(super) fn blossom(
    t: &[f64],
    span: usize,
    p: usize,
    u: impl Fn(usize) -> f64,
    out: &mut [f64; MAX_ORDER],
) {
    out[0] = 1.0;
    for r in 1..=p {
        let u = u(r - 1);
        let mut carried = 0.0;
        for j in 0..r {
            let (low, high) = (t[span + 1 + j - r], t[span + 1 + j]);
            let share = (u - low) / (high - low);
            let own = out[j];
            out[j] = carried + own * (1.0 - share);
            carried = own * share;
        }
        out[r] = carried;
    }
}

/// The values of the polar forms of the Bernstein polynomials of degree `P` of `[0, 1]` at `P` arguments, into `out`.
pub(super) fn bernstein_blossom(arguments: impl Iterator<Item = f64>, out: &mut [f64; MAX_ORDER]) -> usize {
    out[0] = 1.0;
    let mut degree = 0;
    for x in arguments {
        let mut carried = 0.0;
        for value in &mut out[..=degree] {
            let own = *value;
            *value = carried + own * (1.0 - x);
            carried = own * x;
        }
        degree += 1;
        out[degree] = carried;
    }
    degree
}

/// The breakpoints of two spaces over one domain, both ends included.
pub(super) fn partition(a: &Space, b: &Space) -> Result<Vec<f64>> {
    let ((start, end), (from, to)) = (a.domain(), b.domain());
    if (start, end) != (from, to) {
        return Err(Error::Invalid(format!(
            "a spline over [{start}, {end}] and one over [{from}, {to}] have no common domain: restrict or reparametrise one of them"
        )));
    }
    let (mut all, others) = (a.breakpoints(), b.breakpoints());
    if all != others {
        all.extend(others);
        all.sort_by(f64::total_cmp);
        all.dedup();
    }
    Ok(all)
}

/// `C(p,s) C(q,t) / C(p+q,s+t)`, at `s (q + 1) + t`: what Bernstein polynomials give to the product of two.
pub(super) fn mixed(p: usize, q: usize) -> Vec<f64> {
    let (first, second, both) = (binomials(p), binomials(q), binomials(p + q));
    let mut all = Vec::with_capacity((p + 1) * (q + 1));
    for s in 0..=p {
        all.extend((0..=q).map(|t| first[s] * second[t] / both[s + t]));
    }
    all
}

/// `C(n, k)` for `k` up to `n`, at most 50; each from the one before, exactly: what is divided is whole, and below 2⁵³.
fn binomials(n: usize) -> [f64; 2 * MAX_ORDER - 1] {
    let mut all = [1.0; 2 * MAX_ORDER - 1];
    for k in 1..=n.min(all.len() - 1) {
        all[k] = all[k - 1] * (n - k + 1) as f64 / k as f64;
    }
    all
}
