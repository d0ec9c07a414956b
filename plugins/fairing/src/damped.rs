//! The energy with a little of every vertex's own stiffness added: a Cholesky factor of `H + D`, `H = AᵀA`, `D = τ² diag H`.
//!
//! It sees every motion, and with the damping relative to each vertex it is as good for knots of unlike distances as for
//! even ones. What it is for (motions without energy, and fairing between bounds) corrects itself by residuals of `A`, so
//! that `τ` shows in no answer.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Grid;
use loftsman_kernel::solve::EnvelopeCholesky;

use crate::orthogonal::{add, dot, eigenvectors, span};
use crate::precondition::{ENVELOPE_LIMIT, Envelope, LOCKED, Rows, envelope, order};
use crate::squares::Squares;

/// `τ²`: well above what rounding leaves of a zero eigenvalue, well below what the longest waves of a thousand vertices have.
const DAMPING: f64 = 1e-12;
/// The energy of a motion without any, in each span relative to the numbers that it comes from: what rounding leaves, and
/// what is 10¹⁰ times less stiff than the span is.
pub(crate) const NOTHING: f64 = 1e-20;
/// How often the energetic part of a motion is taken out, and what may then be left of it.
const FILTERS: usize = 6;
const FILTERED: f64 = 1e-6;
/// The most multiplications for finding motions without energy, and the most motions to tell from long waves.
const SEARCH: usize = 1_000_000_000;
const WAVES: usize = 256;

/// `H + D` over the vertices that may move, factored.
pub(crate) struct Damped {
    place: Vec<u32>,
    count: usize,
    factor: EnvelopeCholesky,
}

impl Damped {
    /// `None` where the energy vanishes or overflows, or the envelope is beyond all memory.
    pub(crate) fn new(squares: &Squares, free: &[bool], grid: &Grid) -> Option<Self> {
        let rows = Rows::none();
        let place = order(squares, free, grid, &rows);
        let count = place.iter().filter(|&&p| p != LOCKED).count();
        let first = envelope(squares, &place, count, &rows, false);
        if first.iter().enumerate().map(|(i, &f)| i + 1 - f as usize).sum::<usize>() > ENVELOPE_LIMIT {
            return None;
        }
        let mut matrix = Envelope::new(first);
        matrix.energy(squares, &place, 1);
        let largest = matrix.diagonal().fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return None;
        }
        let diagonal: Vec<f64> = matrix.diagonal().map(|h| if h > 0.0 { h } else { largest }).collect();
        let mut damping = DAMPING;
        for _ in 0..3 {
            let entry =
                |i: usize, j: usize| matrix.at(i, j) + if i == j { damping * diagonal[i] } else { 0.0 };
            if let Ok(factor) = EnvelopeCholesky::factor(matrix.first.clone(), 0.0, entry) {
                return Some(Self { place, count, factor });
            }
            damping *= 100.0;
        }
        None
    }

    /// The vertices that may move.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The place of a vertex in the factor; `None` where it may not move.
    pub(crate) fn place(&self, vertex: usize) -> Option<usize> {
        self.place.get(vertex).filter(|&&p| p != LOCKED).map(|&p| p as usize)
    }

    /// `x ← L⁻¹ x`, one number a place.
    pub(crate) fn forward(&self, x: &mut [f64]) {
        self.factor.forward(x, 1);
    }

    /// `x ← L⁻ᵀ x`, one number a place.
    pub(crate) fn backward(&self, x: &mut [f64]) {
        self.factor.backward(x, 1);
    }

    /// `v ← (H + D)⁻¹ v`, nothing for vertices that may not move.
    pub(crate) fn solve(&self, v: &mut [Vector]) {
        let mut work = vec![0.0; 3 * self.count];
        for (v, &place) in v.iter().zip(&self.place).filter(|(_, p)| **p != LOCKED) {
            work[3 * place as usize..3 * place as usize + 3].copy_from_slice(v.as_slice());
        }
        self.factor.solve(&mut work, 3);
        for (v, &place) in v.iter_mut().zip(&self.place) {
            *v = match place {
                LOCKED => Vector::zeros(),
                _ => Vector::from_column_slice(&work[3 * place as usize..3 * place as usize + 3]),
            };
        }
    }

    /// All motions of vertices that may move which cost no energy, as an orthonormal basis: the whole shape's, and those of its
    /// parts against each other where the knots are so many that the energy does not tie them together. `None` where there are
    /// too many to be found.
    ///
    /// Some motions are freed of what is energetic in them, by `v ← v - (H + D)⁻¹Aᵀ(A v)` again and again (each time a wave's
    /// part shrinks to `δ / (σ² + δ)` of itself); twice as many are taken until some of them are left with nothing. Of what
    /// remains, the eigenvectors of `(A V)ᵀ(A V)` tell motions without energy from long waves.
    pub(crate) fn null_space(&self, squares: &Squares) -> Option<Vec<Vec<f64>>> {
        let n = self.place.len();
        let mut width = 8.min(self.count);
        let basis = loop {
            if self.count * width * width > SEARCH {
                return None;
            }
            let mut motions = self.start(width);
            for motions in motions.chunks_mut(3) {
                self.filter(squares, motions, n);
            }
            let basis = span(motions, FILTERED);
            if basis.len() < width || width == self.count {
                break basis;
            }
            width = (2 * width).min(self.count);
        };
        if basis.iter().all(|motion| squares.vanishes(motion, NOTHING)) {
            return Some(basis);
        }
        if basis.len() > WAVES {
            return None;
        }
        let found = costless(squares, &basis, &mut |motion| {
            self.filter(squares, std::slice::from_mut(motion), n);
        });
        Some(span(found, 0.5))
    }

    /// Motions to begin with: a unit vector each where that is all, else of no order but the same on every machine.
    fn start(&self, width: usize) -> Vec<Vec<f64>> {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut motions = vec![vec![0.0; self.place.len()]; width];
        for (vertex, &place) in self.place.iter().enumerate().filter(|(_, p)| **p != LOCKED) {
            for (k, motion) in motions.iter_mut().enumerate() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                motion[vertex] = match width == self.count {
                    true => f64::from(u8::from(place as usize == k)),
                    false => (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0,
                };
            }
        }
        for motion in &mut motions {
            let norm = dot(motion, motion).sqrt();
            if norm > 0.0 {
                motion.iter_mut().for_each(|x| *x /= norm);
            }
        }
        motions
    }

    /// Takes out of up to three motions what costs energy.
    fn filter(&self, squares: &Squares, motions: &mut [Vec<f64>], n: usize) {
        let mut all = lifted(motions, n);
        let mut out = vec![Vector::zeros(); n];
        for _ in 0..FILTERS {
            squares.gradient(&all, false, &mut out);
            self.solve(&mut out);
            all.iter_mut().zip(&out).for_each(|(v, o)| *v -= o);
        }
        for (k, motion) in motions.iter_mut().enumerate() {
            motion.iter_mut().zip(&all).for_each(|(x, v)| *x = v[k]);
        }
    }
}

/// Up to three motions as the axes of one.
fn lifted(motions: &[Vec<f64>], n: usize) -> Vec<Vector> {
    let at = |i: usize, k: usize| motions.get(k).map_or(0.0, |m: &Vec<f64>| m[i]);
    (0..n).map(|i| Vector::new(at(i, 0), at(i, 1), at(i, 2))).collect()
}

/// Of the span of orthonormal motions, a basis of those that cost no energy: eigenvectors of `(A V)ᵀ(A V)`, each refined.
pub(crate) fn costless(
    squares: &Squares,
    motions: &[Vec<f64>],
    refine: &mut dyn FnMut(&mut Vec<f64>),
) -> Vec<Vec<f64>> {
    let Some(n) = motions.first().map(Vec::len) else { return Vec::new() };
    let each = eigenvectors(squares.gram(motions)).into_iter().map(|weights| {
        let mut motion = vec![0.0; n];
        motions.iter().zip(&weights).for_each(|(m, w)| add(&mut motion, *w, m));
        refine(&mut motion);
        motion
    });
    each.filter(|motion| squares.vanishes(motion, NOTHING)).collect()
}
