//! What is to be small, near to a shape as it is: squares of distances and of energies.

use std::cell::OnceCell;

use loftsman_kernel::Vector;
use loftsman_kernel::energy::Squares;
use loftsman_kernel::error::Result;
use loftsman_kernel::parallel;
use loftsman_kernel::shape::{Derivative, Shape, Stencil};
use loftsman_kernel::solve::Symmetric;

use super::foot::Foot;
use super::rows::Rows;
use super::sliding::Sliding;

/// The squared distances and energies near to a shape as it is, as a quadratic of the adjustment `d` of the control vertices.
///
/// Half the squared distance of a point `Q` is the least of `½ |S(t) + N(t) d - Q|²` over the parameters `t` of the foot, `N` the
/// shape's row there. With `e = S - Q`, `A = [∂ᵢS·∂ⱼS + e·∂ᵢ∂ⱼS]` and `bᵢ = ∂ᵢS·N d + e·∂ᵢN d` its gradient is `Nᵀe` and its second
/// derivative, exactly, `|N d|² - bᵀA⁻¹b`: what the foot gains by going along (Newton's method; without `e` in `A` and `b` Gauss's).
/// Of that gain the part `1 - τ` is taken: with `τ = 1` the foot stays, and the quadratic is never less than what it is a model of.
pub(super) struct Model<'a> {
    pub(super) rows: Rows,
    slopes: [Rows; 2],
    along: Vec<Along>,
    feet: &'a [Foot],
    order: &'a [u32],
    shares: &'a [f64],
    energies: &'a [(f64, Squares)],
    /// How much the shape is held where it is, and the matrix of the mean square of its way.
    still: Option<(f64, &'a Symmetric)>,
    /// How much the shape is held from sliding along itself.
    sliding: Option<(f64, &'a Sliding)>,
    /// The matrices of `H` without what holds the shape, once they were needed, where products with these cost less than with the rows.
    full: OnceCell<Option<Full>>,
}

/// `H = K ⊗ 1 - (1 - τ) G`, all entries.
struct Full {
    alike: Vec<f64>,
    along: Vec<f64>,
}

/// A product with all entries is for where it costs no more than this part of one with the rows: these are summed first.
const CHEAP: f64 = 0.2;

/// Feet whose rows are looked for together.
const SOME: usize = 4096;

/// How a foot goes along.
struct Along {
    /// `A⁻¹` over the free parameters, zero elsewhere.
    inverse: [f64; 3],
    /// `e`, or nothing where there is no second derivative or the distance has none that is least.
    away: Vector,
}

impl Along {
    fn new(foot: &Foot) -> Self {
        let [a, b] = foot.jet.first;
        let plain = [a.dot(&a), a.dot(&b), b.dot(&b)];
        let full = foot.jet.curvature(&foot.away).and_then(|full| inverse(full, plain, foot.free));
        if let Some(inverse) = full {
            return Self { inverse, away: foot.away };
        }
        Self { inverse: inverse(plain, plain, foot.free).unwrap_or([0.0; 3]), away: Vector::zeros() }
    }

    /// `A⁻¹ b`.
    fn gain(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.inverse;
        [a * x + b * y, b * x + c * y]
    }
}

/// The inverse of a matrix over the free parameters, where it is positive definite, safely at the size of another.
fn inverse([a, b, c]: [f64; 3], plain: [f64; 3], free: [bool; 2]) -> Option<[f64; 3]> {
    let sound = |x: f64, size: f64| x > 1e-3 * size && x > 0.0;
    match free {
        [false, false] => Some([0.0; 3]),
        [true, false] => sound(a, plain[0]).then(|| [1.0 / a, 0.0, 0.0]),
        [false, true] => sound(c, plain[2]).then(|| [0.0, 0.0, 1.0 / c]),
        [true, true] => {
            let determinant = a * c - b * b;
            let usable = sound(a, plain[0]) && sound(c, plain[2]) && determinant > 1e-6 * a * c;
            usable.then(|| [c / determinant, -b / determinant, a / determinant])
        }
    }
}

/// The mean square of the distances, and what the energies come to, at points `x` relative to the origin of these.
pub(super) fn value(feet: &[Foot], shares: &[f64], energies: &[(f64, Squares)], x: &[Vector]) -> (f64, f64) {
    let squares = feet.iter().zip(shares).map(|(foot, share)| share * foot.distance * foot.distance);
    let energies = energies.iter().map(|(weight, squares)| weight * squares.energy(x).0);
    // A sum of nothing is -0.
    (squares.sum::<f64>() + 0.0, energies.sum::<f64>() + 0.0)
}

impl<'a> Model<'a> {
    /// `shares` are the weights of the points, their sum 1.
    ///
    /// # Errors
    /// When the shape has no rows where the feet are.
    pub(super) fn new(
        shape: &dyn Shape,
        feet: &'a [Foot],
        order: &'a [u32],
        shares: &'a [f64],
        energies: &'a [(f64, Squares)],
    ) -> Result<Self> {
        let (mut rows, mut slopes) = (Rows::default(), [Rows::default(), Rows::default()]);
        let mut along = Vec::with_capacity(feet.len());
        for some in order.chunks(SOME) {
            let found = parallel::map(some.len(), |k| -> Result<[Stencil; 3]> {
                let foot = &feet[some[k] as usize];
                let slope = |side: usize, u: usize, v: usize| {
                    if foot.free[side] {
                        shape.stencil(foot.at, Derivative { u, v })
                    } else {
                        Ok(Stencil::new())
                    }
                };
                Ok([shape.stencil(foot.at, Derivative::POSITION)?, slope(0, 1, 0)?, slope(1, 0, 1)?])
            });
            for (&k, stencils) in some.iter().zip(found) {
                let [position, u, v] = stencils?;
                rows.push(&position);
                slopes[0].push(&u);
                slopes[1].push(&v);
                along.push(Along::new(&feet[k as usize]));
            }
        }
        Ok(Self {
            rows,
            slopes,
            along,
            feet,
            order,
            shares,
            energies,
            still: None,
            sliding: None,
            full: OnceCell::new(),
        })
    }

    /// Adds so much of the mean square of the shape's way: where no point sees it, it goes no farther than that allows (Levenberg and Marquardt).
    pub(super) fn hold(&mut self, by: f64, still: &'a Symmetric) {
        self.still = Some((by, still));
    }

    /// Adds so much of the mean square of how far the shape slides along itself.
    pub(super) fn hold_along(&mut self, sliding: Option<(f64, &'a Sliding)>) {
        self.sliding = sliding;
    }

    /// Whether it is held so.
    pub(super) fn is_held_along(&self) -> bool {
        self.sliding.is_some()
    }

    /// What is added for an adjustment.
    pub(super) fn held(&self, d: &[Vector]) -> f64 {
        let Some((by, still)) = self.still else { return 0.0 };
        by * form(still, d)
    }

    /// The feet in the order of the rows, with their shares.
    fn each(&self) -> impl Iterator<Item = (usize, &'a Foot, f64)> + '_ {
        let (feet, shares) = (self.feet, self.shares);
        self.order.iter().enumerate().map(move |(row, &k)| (row, &feet[k as usize], shares[k as usize]))
    }

    /// `out = H d`.
    pub(super) fn multiply(&self, tau: f64, d: &[Vector], out: &mut [Vector]) {
        if let Some(full) = self.full.get_or_init(|| self.full(d.len())) {
            full.multiply(tau, d, out);
            self.hold_back(d, out);
            return;
        }
        out.fill(Vector::zeros());
        for (row, foot, share) in self.each() {
            let (way, along) = (self.rows.sum(row, d), &self.along[row]);
            let b = std::array::from_fn(|side| {
                foot.jet.first[side].dot(&way) + along.away.dot(&self.slopes[side].sum(row, d))
            });
            let gain = along.gain(b).map(|g| g * (1.0 - tau));
            let left = way - foot.jet.first[0] * gain[0] - foot.jet.first[1] * gain[1];
            self.rows.spread(row, left * share, out);
            for (slopes, gain) in self.slopes.iter().zip(gain) {
                slopes.spread(row, along.away * (-gain * share), out);
            }
        }
        let mut work = vec![Vector::zeros(); if self.energies.is_empty() { 0 } else { d.len() }];
        for (weight, squares) in self.energies {
            squares.gradient(d, false, &mut work);
            out.iter_mut().zip(&work).for_each(|(out, g)| *out += g * *weight);
        }
        self.hold_back(d, out);
    }

    /// Adds what holds the shape.
    fn hold_back(&self, d: &[Vector], out: &mut [Vector]) {
        if let Some((by, still)) = self.still {
            spread(by, still, d, out);
        }
        if let Some((by, sliding)) = self.sliding {
            sliding.multiply(by, d, out);
        }
    }

    /// All entries, where products with them are cheap. Cost: those of the vertices of each foot, squared.
    fn full(&self, count: usize) -> Option<Full> {
        let terms: usize = (0..self.rows.len()).map(|row| self.rows.row(row).0.len()).sum();
        // A term is read for the row and two slopes, three coordinates each, once to sum and once to spread.
        if (9 * count * count) as f64 > CHEAP * (18 * terms) as f64 {
            return None;
        }
        let (mut alike, side) = (vec![0.0; count * count], 3 * count);
        let mut along = vec![0.0; side * side];
        let mut b = [vec![0.0; side], vec![0.0; side]];
        let mut touched: Vec<usize> = Vec::new();
        for (row, foot, share) in self.each() {
            let (vertices, coefficients) = self.rows.row(row);
            for (&i, a) in vertices.iter().zip(coefficients) {
                for (&j, c) in vertices.iter().zip(coefficients) {
                    alike[i as usize * count + j as usize] += share * a * c;
                }
            }
            let [p, q, r] = self.along[row].inverse;
            if [p, q, r] == [0.0; 3] {
                continue;
            }
            // What the foot goes along by: b = B d.
            touched.clear();
            for (k, b) in b.iter_mut().enumerate() {
                let terms = [(&self.rows, foot.jet.first[k]), (&self.slopes[k], self.along[row].away)];
                for (rows, by) in terms {
                    let (vertices, coefficients) = rows.row(row);
                    for (&v, c) in vertices.iter().zip(coefficients) {
                        let at = 3 * v as usize;
                        (0..3).for_each(|axis| b[at + axis] += c * by[axis]);
                        touched.push(at);
                    }
                }
            }
            touched.sort_unstable();
            touched.dedup();
            for i in touched.iter().flat_map(|&at| at..at + 3) {
                let (x, y) = (share * b[0][i], share * b[1][i]);
                let (x, y) = (p * x + q * y, q * x + r * y);
                let line = &mut along[i * side..(i + 1) * side];
                for &j in &touched {
                    (j..j + 3).for_each(|j| line[j] += x * b[0][j] + y * b[1][j]);
                }
            }
            for b in &mut b {
                touched.iter().for_each(|&at| b[at..at + 3].fill(0.0));
            }
        }
        for (weight, squares) in self.energies {
            squares.entries(|i, j, value| {
                alike[i * count + j] += weight * value;
                if i != j {
                    alike[j * count + i] += weight * value;
                }
            });
        }
        Some(Full { alike, along })
    }

    /// Half the gradient of what is to be small, at points `x` relative to the origin of the energies.
    pub(super) fn gradient(&self, x: &[Vector], out: &mut [Vector]) {
        out.fill(Vector::zeros());
        for (row, foot, share) in self.each() {
            self.rows.spread(row, foot.away * share, out);
        }
        let mut work = vec![Vector::zeros(); if self.energies.is_empty() { 0 } else { x.len() }];
        for (weight, squares) in self.energies {
            squares.gradient(x, true, &mut work);
            out.iter_mut().zip(&work).for_each(|(out, g)| *out += g * *weight);
        }
        if let Some((by, sliding)) = self.sliding {
            sliding.gradient(by, x, out);
        }
    }

    /// The matrix of the model with `τ = 1`, the same for x, y and z: no other has more. Feet side by side share their vertices, so
    /// that most of it is added in dense blocks. With or without what
    /// holds it along itself.
    pub(super) fn matrix(&self, count: usize, along: bool) -> Symmetric {
        let mut lower: Vec<Vec<(u32, f64)>> = vec![Vec::new(); count];
        let mut block: (&[u32], Vec<f64>) = (&[], Vec::new());
        for (row, _, share) in self.each() {
            let (vertices, coefficients) = self.rows.row(row);
            gather(vertices, coefficients, share, &mut block, &mut lower);
        }
        if let Some((by, held)) = self.sliding.filter(|_| along) {
            let (rows, shares) = held.rows();
            for (row, share) in shares.iter().enumerate() {
                let (vertices, coefficients) = rows.row(row);
                gather(vertices, coefficients, by * share, &mut block, &mut lower);
            }
        }
        flush(&block, &mut lower);
        for (weight, squares) in self.energies {
            squares.entries(|i, j, value| add(&mut lower, i, j, weight * value));
        }
        if let Some((by, still)) = self.still {
            for i in 0..count {
                let below = still.row(i).filter(|(j, _)| *j <= i);
                below.for_each(|(j, value)| add(&mut lower, i, j, by * value));
            }
        }
        symmetric(lower)
    }
}

/// The mean of the squares of rows: `RᵀR / m` of `m` of them.
pub(super) fn mean_square(rows: &Rows, count: usize) -> Symmetric {
    let mut lower: Vec<Vec<(u32, f64)>> = vec![Vec::new(); count];
    let mut block: (&[u32], Vec<f64>) = (&[], Vec::new());
    let share = 1.0 / rows.len().max(1) as f64;
    for row in 0..rows.len() {
        let (vertices, coefficients) = rows.row(row);
        gather(vertices, coefficients, share, &mut block, &mut lower);
    }
    flush(&block, &mut lower);
    symmetric(lower)
}

fn symmetric(lower: Vec<Vec<(u32, f64)>>) -> Symmetric {
    let count = lower.len();
    let entries = lower.into_iter().enumerate();
    let entries = entries.flat_map(|(i, row)| row.into_iter().map(move |(j, value)| (i, j as usize, value)));
    Symmetric::from_entries(count, entries)
}

/// `dᵀK d`.
fn form(matrix: &Symmetric, d: &[Vector]) -> f64 {
    let line = |i: usize| matrix.row(i).map(|(j, value)| d[j] * value).sum::<Vector>();
    d.iter().enumerate().map(|(i, way)| way.dot(&line(i))).sum()
}

/// `out += by K d`.
fn spread(by: f64, matrix: &Symmetric, d: &[Vector], out: &mut [Vector]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out += matrix.row(i).map(|(j, value)| d[j] * (by * value)).sum::<Vector>();
    }
}

/// Adds a row to the block of its vertices, that of others put away before.
fn gather<'a>(
    vertices: &'a [u32],
    coefficients: &[f64],
    share: f64,
    block: &mut (&'a [u32], Vec<f64>),
    lower: &mut [Vec<(u32, f64)>],
) {
    if vertices != block.0 {
        flush(block, lower);
        *block = (vertices, vec![0.0; vertices.len() * vertices.len()]);
    }
    for (line, a) in block.1.chunks_exact_mut(vertices.len().max(1)).zip(coefficients) {
        let by = share * a;
        line.iter_mut().zip(coefficients).for_each(|(sum, b)| *sum += by * b);
    }
}

impl Full {
    fn multiply(&self, tau: f64, d: &[Vector], out: &mut [Vector]) {
        let (count, side) = (d.len(), 3 * d.len());
        for (i, out) in out.iter_mut().enumerate() {
            let alike = &self.alike[i * count..(i + 1) * count];
            *out = alike.iter().zip(d).map(|(value, d)| d * *value).sum();
            for axis in 0..3 {
                let line = &self.along[(3 * i + axis) * side..(3 * i + axis + 1) * side];
                let blocks = line.as_chunks::<3>().0.iter().zip(d);
                let gain: f64 = blocks.map(|([x, y, z], d)| x * d.x + y * d.y + z * d.z).sum();
                out[axis] -= (1.0 - tau) * gain;
            }
        }
    }
}

fn flush((vertices, block): &(&[u32], Vec<f64>), lower: &mut [Vec<(u32, f64)>]) {
    for (a, line) in block.chunks_exact(vertices.len().max(1)).enumerate() {
        for (b, value) in line.iter().enumerate() {
            if vertices[b] <= vertices[a] {
                add(lower, vertices[a] as usize, vertices[b] as usize, *value);
            }
        }
    }
}

fn add(lower: &mut [Vec<(u32, f64)>], i: usize, j: usize, value: f64) {
    let (i, j) = (i.max(j), i.min(j) as u32);
    let row = &mut lower[i];
    match row.binary_search_by_key(&j, |(column, _)| *column) {
        Ok(at) => row[at].1 += value,
        Err(at) => row.insert(at, (j, value)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use loftsman_kernel::Point;
    use loftsman_kernel::spline::{Space, Surface};

    use super::super::foot::feet;
    use super::super::patches::Patches;
    use super::*;

    #[test]
    fn all_entries_give_what_rows_give() {
        let bumpy = |k: usize| Point::new((k / 4) as f64, (k % 4) as f64, (k as f64).sin());
        let space = || Space::clamped_uniform(2, 4).unwrap();
        let surface = Surface::new(space(), space(), (0..16).map(bumpy).collect()).unwrap();
        let points: Vec<Point> = (0..200)
            .map(|k| Point::new(f64::from(k / 14) * 0.22, f64::from(k % 14) * 0.23, 0.3 * f64::from(k % 3)))
            .collect();
        let patches = Patches::new(&surface).unwrap();
        let (feet, order) = feet(&surface, &patches, &points, None, &|| false).unwrap().unwrap();
        let shares = vec![1.0 / 200.0; 200];
        let mut model = Model::new(&surface, &feet, &order, &shares, &[]).unwrap();
        model.hold(0.01, patches.still(16));
        let way: Vec<Vector> =
            (0..16).map(|k| Vector::new(1.0, f64::from(k), (2.0 * f64::from(k)).cos())).collect();
        for tau in [1.0, 0.1, 1e-6] {
            let (mut full, mut rows) = (way.clone(), way.clone());
            model.full = OnceCell::new();
            model.multiply(tau, &way, &mut full);
            assert!(model.full.get().unwrap().is_some());
            model.full = OnceCell::from(None);
            model.multiply(tau, &way, &mut rows);
            for (a, b) in full.iter().zip(&rows) {
                assert!((a - b).norm() < 1e-13 * (1.0 + b.norm()), "{tau}: {a} {b}");
            }
        }
    }
}
