//! The exact product of two splines on different knot vectors.

use super::bernstein::{Pieces, bernstein_blossom, mixed, partition};
use super::{Coefficient, Function};
use crate::error::{Error, MAX_DEGREE, Result};
use crate::space::{MAX_ORDER, Space};

/// How splines of two spaces are multiplied: the space that holds all products, and each of its coefficients as a bilinear form
/// of coefficients of the factors. Made once for many products.
///
/// On each piece between neighbouring breakpoints of the two both factors are in Bernstein form,
/// `c_m = Σ_{s+t=m} C(p,s) C(q,t) / C(p+q,m) · a_s b_t`; a coefficient of the product is the polar form (blossom) of one piece
/// at the coefficient's knots (Ramshaw 1987), of the piece of its support from which that extrapolates least. Exact but for rounding, which
/// a knot `d` of the piece's lengths beyond it multiplies by up to `1 + 2 d`, so that the piece is the one of which the product of these is
/// least: a long one, one in the middle, one between repeated knots. Nothing is multiplied where, as for the products of fine tuning at simple
/// knots, a coefficient is itself one of a piece's Bernstein coefficients.
#[derive(Debug, Clone)]
pub struct Product {
    space: Space,
    first: Pieces,
    second: Pieces,
    /// `C(p,s) C(q,t) / C(p+q,s+t)`, at `s · (q + 1) + t`.
    mixed: Vec<f64>,
    targets: Vec<Target>,
    /// What the targets have of the Bernstein coefficients of their pieces.
    shares: Vec<f64>,
}

/// A coefficient of the product: a combination of Bernstein coefficients `from .. from + count` of a piece.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Target {
    pub(super) piece: u32,
    from: u8,
    count: u8,
    start: u32,
}

impl Space {
    /// The space of all products of a spline of this space and one of another over the same domain: degree `p + q`, the
    /// breakpoints of both, and at each as smooth as the less smooth factor: a knot of multiplicity `m` in a space of
    /// degree `p` gets multiplicity `m + q`. Clamped at its ends; periodic where both are and the products have no jumps.
    ///
    /// # Errors
    /// When the domains differ, `p + q` exceeds 25, or two knots are so near that no piece fits between them.
    pub fn product(&self, other: &Self) -> Result<Product> {
        let (p, q) = (self.degree(), other.degree());
        let partition = partition(self, other)?;
        let space = product_space(self, other, &partition)?;
        let mut product = Product {
            first: Pieces::new(self, &partition),
            second: Pieces::new(other, &partition),
            mixed: mixed(p, q),
            targets: Vec::new(),
            shares: Vec::new(),
            space,
        };
        product.aim(&partition);
        Ok(product)
    }
}

/// The space of products, with a knot of the multiplicity that they need at each breakpoint of the partition.
pub(super) fn product_space(a: &Space, b: &Space, partition: &[f64]) -> Result<Space> {
    let degree = a.degree() + b.degree();
    if degree > MAX_DEGREE {
        return Err(Error::Degree { degree });
    }
    let (Some(&start), Some(&end)) = (partition.first(), partition.last()) else {
        return Err(Error::TooFewVertices { vertices: 0, degree, needed: degree + 1 });
    };
    let mut runs = [Runs::new(a.flat()), Runs::new(b.flat())];
    let mut inner = Vec::with_capacity(partition.len());
    for &knot in &partition[1..partition.len() - 1] {
        let [of_a, of_b] = runs.each_mut().map(|runs| runs.at(knot));
        let needed = |own: usize, other: usize| if own > 0 { own + other } else { 0 };
        inner.push((knot, needed(of_a, b.degree()).max(needed(of_b, a.degree()))));
    }
    // A seam that both close over is a knot like those inside; other ends are clamped, and so are those of products with jumps,
    // which no periodic space holds.
    let at_seam = (a.multiplicity(start) + b.degree()).max(b.multiplicity(start) + a.degree());
    let most = inner.iter().fold(at_seam, |most, (_, times)| most.max(*times));
    let periodic = a.is_periodic() && b.is_periodic() && most <= degree.max(1);
    let mut knots = vec![start; if periodic { at_seam } else { degree + 1 }];
    inner.into_iter().for_each(|(knot, times)| knots.extend(std::iter::repeat_n(knot, times)));
    knots.extend(std::iter::repeat_n(end, if periodic { 1 } else { degree + 1 }));
    if periodic { Space::periodic(degree, knots) } else { Space::open(degree, knots) }
}

/// How often knots are repeated, asked in ascending order.
pub(super) struct Runs<'a>(&'a [f64]);

impl<'a> Runs<'a> {
    pub(super) fn new(knots: &'a [f64]) -> Self {
        Self(knots)
    }

    pub(super) fn at(&mut self, knot: f64) -> usize {
        let before = self.0.iter().take_while(|k| **k < knot).count();
        let run = self.0[before..].iter().take_while(|k| **k == knot).count();
        self.0 = &self.0[before + run..];
        run
    }
}

/// By how much the errors of a piece's Bernstein coefficients grow at most in the polar form at some ascending knots: `Π (|1 - x| + |x|)`, `x` being a knot
/// from 0 to 1 along the piece. Infinite where it is no less than `most`.
fn growth(knots: &[f64], start: f64, end: f64, most: f64) -> f64 {
    let before = knots.iter().take_while(|t| **t < start).map(|t| start - t);
    let after = knots.iter().rev().take_while(|t| **t > end).map(|t| t - end);
    let mut all = 1.0;
    for beyond in before.chain(after) {
        all *= 1.0 + 2.0 * beyond / (end - start);
        if all >= most {
            return f64::INFINITY;
        }
    }
    all
}

impl Product {
    /// The space that holds the products.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Finds for each coefficient the piece of its support that is extrapolated least, and what it has of that piece's Bernstein
    /// coefficients.
    fn aim(&mut self, partition: &[f64]) {
        let (degree, flat) = (self.space.degree(), self.space.flat());
        let mut best = vec![(f64::INFINITY, 0_u32, 0_u32); self.space.len()];
        // The pieces between the ends of each support; `low` and `high` go through them once.
        let (mut low, mut high) = (0, 0);
        let last = partition.len() - 1;
        for k in 0..self.space.unrolled_len() {
            let (from, to) = (flat[k], flat[k + degree + 1]);
            while low < last && partition[low + 1] <= from {
                low += 1;
            }
            while high < last && partition[high] < to {
                high += 1;
            }
            let best = &mut best[self.space.vertex(k)];
            for piece in low..high {
                // Nothing grows less than not at all.
                if best.0 <= 1.0 {
                    break;
                }
                let growth =
                    growth(&flat[k + 1..=k + degree], partition[piece], partition[piece + 1], best.0);
                if growth < best.0 {
                    *best = (growth, piece as u32, k as u32);
                }
            }
        }
        self.targets.reserve(best.len());
        self.shares.reserve(best.len());
        let mut values = [0.0; MAX_ORDER];
        for (_, piece, k) in best {
            let (k, x) = (k as usize, partition[piece as usize]);
            let end = partition[piece as usize + 1];
            let length = end - x;
            let own = &flat[k + 1..=k + degree];
            let local = |t: &f64| if *t == end { 1.0 } else { (t - x) / length };
            bernstein_blossom(own.iter().map(local), &mut values);
            let from = values[..=degree].iter().position(|v| *v != 0.0).unwrap_or(0);
            let to = values[..=degree].iter().rposition(|v| *v != 0.0).unwrap_or(0);
            let start = self.shares.len() as u32;
            self.shares.extend(&values[from..=to]);
            self.targets.push(Target { piece, from: from as u8, count: (to + 1 - from) as u8, start });
        }
    }

    pub(super) fn factors(&self) -> [&Pieces; 2] {
        [&self.first, &self.second]
    }

    pub(super) fn target(&self, index: usize) -> Target {
        self.targets.get(index).copied().unwrap_or_default()
    }

    /// What the coefficient is made of: pairs of Bernstein coefficients of its piece, `(s, t, share)`.
    pub(super) fn pairs(&self, target: Target) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let (p, q) = (self.first.order() - 1, self.second.order() - 1);
        let own = &self.shares[target.start as usize..target.start as usize + usize::from(target.count)];
        own.iter().enumerate().flat_map(move |(m, share)| {
            let m = m + usize::from(target.from);
            (m.saturating_sub(q)..=m.min(p)).map(move |s| (s, m - s, share * self.mixed[s * (q + 1) + m - s]))
        })
    }

    /// The coefficients of the product of `Σ a_i M_i` and `Σ b_k R_k`, where `multiply` is bilinear: a number times a vector, a
    /// scalar product, a cross product. `O(n (p+1)(q+1))`.
    ///
    /// # Errors
    /// When there are not as many coefficients as the two spaces have functions.
    pub fn combine<A: Coefficient, B: Coefficient, C: Coefficient>(
        &self,
        a: &Function<A>,
        b: &Function<B>,
        multiply: impl Fn(A, B) -> C,
    ) -> Result<Function<C>> {
        let first = self.first.coefficients(|i| a.at(i));
        let second = self.second.coefficients(|i| b.at(i));
        let (m, n) = (self.first.order(), self.second.order());
        let coefficient = |target: &Target| {
            let piece = target.piece as usize;
            let (a, b) = (&first[piece * m..(piece + 1) * m], &second[piece * n..(piece + 1) * n]);
            self.pairs(*target).fold(C::zero(), |sum, (s, t, share)| sum + multiply(a[s], b[t]) * share)
        };
        Function::new(self.space.clone(), self.targets.iter().map(coefficient).collect())
    }

    /// The products with one spline `Σ a_i M_i` as a linear map of the other's coefficients: `q + 1` entries for each coefficient
    /// of the product, one behind the other, each a vertex of the second space and what the coefficient has of it.
    /// `O(n (p+1)(q+1)²)`.
    pub fn with_first<A: Coefficient>(&self, a: &Function<A>) -> Vec<(usize, A)> {
        let mut all = Vec::with_capacity(self.targets.len() * self.second.order());
        self.each_with_first(a, |vertex, value| all.push((vertex, value)));
        all
    }

    /// The entries of [`with_first`](Self::with_first) one after another, for who stores them otherwise.
    pub fn each_with_first<A: Coefficient>(&self, a: &Function<A>, mut put: impl FnMut(usize, A)) {
        let first = self.first.coefficients(|i| a.at(i));
        let (m, n) = (self.first.order(), self.second.order());
        let mut by = vec![A::zero(); n];
        for target in &self.targets {
            let piece = target.piece as usize;
            by.fill(A::zero());
            for (s, t, share) in self.pairs(*target) {
                by[t] = by[t] + first[piece * m + s] * share;
            }
            for (k, vertex) in self.second.vertices(piece).iter().enumerate() {
                let own = by.iter().zip(self.second.row(piece, k));
                put(*vertex as usize, own.fold(A::zero(), |sum, (by, row)| sum + *by * *row));
            }
        }
    }
}
