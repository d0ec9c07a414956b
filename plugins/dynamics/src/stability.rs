//! The longest step that is stable.
//!
//! Explicit steps of length `h` are stable while `h ω ≤ 2` for the highest frequency `ω` of the free body. Tension never stiffens a rope across
//! more than it is along (`k/ℓ - k/|P'| < k/ℓ`), so `K` is bounded for all time by that of its basis functions' derivatives, the same for
//! x, y and z; and by Irons and Treharne (1971) `ω²` of the whole is no more than the largest of its spans'. Constraints only
//! lower it (Rayleigh). Bending is a matrix that stays: its highest frequency is bounded by a Cholesky factor of `λM - K`, closely.
//!
//! It is a bound, shorter than what is just stable the higher the degree: `h ω ≤ 1` is half of the limit, and a span alone swings faster than
//! with its neighbours, of uniform knots by 1, 2.4, 4.1 and 8.7 times for degrees 1, 2, 3 and 5 (`ω²` 12, 60, 170, 739 of `∫p'²/∫p²` over polynomials of degrees 1, 2, 3 and
//! 5, against 12, 10, 9.9, 9.9 of the whole). Steps through rings are no longer for a sharper one: there the drift of constraints is what shortens them.

use loftsman_kernel::shape::{Derivative, Shape, cells_of, rows_at};
use loftsman_kernel::solve::{EnvelopeCholesky, RangeSpace, Symmetric};
use nalgebra::DMatrix;

use crate::body::Material;
use crate::elastic::Elastic;
use crate::error::Result;
use crate::mass::Mass;

/// How much of the limit is used: `h ω ≤ 1`, so that the energy of the highest frequency stays within a quarter of its own.
pub(crate) const SHARE: f64 = 1.0;
/// More spans than this are not looked at one by one on surfaces: power iteration takes over.
const SPANS: usize = 400;
/// What power iteration may have missed, of surfaces.
const SAFE: f64 = 1.1;
/// Power iteration rests where it changes by this share; and where a factor tells what is above.
const STILL: f64 = 1e-4;
const ROUGHLY: f64 = 1e-2;
/// What is above the highest frequency of bending is looked for from this times what power iteration says, each time so many times farther, so often at most.
const NEAR: f64 = 1.05;
const FARTHER: f64 = 1.1;
const TRIES: usize = 200;
/// Shear and stretch of a surface stiffen it by no more than this, while strains stay below a half.
const SHEARED: f64 = 4.0;

/// A bound of `ω²` of the free body: rigorous for curves; for surfaces for strains below a half, and where there are many spans by power
/// iteration with a tenth to spare.
pub(crate) fn highest(shape: &dyn Shape, material: &Material, elastic: &Elastic, mass: &Mass) -> Result<f64> {
    let cells = cells_of(shape, "a simulation")?.checked(shape)?;
    let by_spans = elastic.points.directions == 1 || cells.len() <= SPANS;
    if by_spans && elastic.points.cells.iter().all(|cell| cell.face.is_none()) {
        let mut highest = 0.0_f64;
        let mut sound = true;
        for (index, cell) in cells.iter().enumerate() {
            let width = cell.vertices.len();
            let counts = [0, 1].map(|k| cell.sides.get(k).map_or(0, |side| side.degree) + 3);
            let points = cell.gauss_points(counts);
            let rows = rows_at(shape, cell, &points, Derivative::POSITION)?;
            // The least mass that the metric can have there.
            let least = elastic.points.rest[elastic.points.cells[index].first..]
                [..elastic.points.cells[index].count]
                .iter()
                .map(|rest| rest.measure)
                .fold(f64::INFINITY, f64::min);
            let mut m = DMatrix::zeros(width, width);
            for ((_, weight), row) in points.iter().zip(rows.chunks_exact(width)) {
                let row = nalgebra::RowDVector::from_row_slice(row);
                m += row.transpose() * &row * (weight * material.mass * least);
            }
            let mut k = DMatrix::zeros(width, width);
            add_bound(elastic, index, |i, j, value| k[(i, j)] += value);
            match largest_eigenvalue(&m, &k) {
                Some(value) => highest = highest.max(value),
                None => {
                    sound = false;
                    break;
                }
            }
        }
        // The highest of a sum is no more than the sum of both highest (Weyl).
        let bent = match &elastic.bend {
            Some(bend) => highest_of_bending(bend, mass),
            None => Some(0.0),
        };
        if let Some(bent) = bent.filter(|bent| sound && (highest + bent).is_finite()) {
            return Ok(highest + bent);
        }
    }
    let (mut entries, mut own) = (Vec::new(), Vec::new());
    for (index, cell) in elastic.points.cells.iter().enumerate() {
        let vertices = elastic.points.of(cell);
        let width = cell.width;
        own.clear();
        own.resize(width * width, 0.0);
        add_bound(elastic, index, |i, j, value| own[i * width + j] += value);
        for (i, row) in vertices.iter().zip(own.chunks_exact(width)) {
            let lower = vertices.iter().zip(row).filter(|(j, _)| *j <= i);
            entries.extend(lower.map(|(j, value)| (*i as usize, *j as usize, *value)));
        }
    }
    if let Some(bend) = &elastic.bend {
        for i in 0..bend.size() {
            entries.extend(bend.row(i).filter(|(j, _)| *j <= i).map(|(j, value)| (i, j, value)));
        }
    }
    let stiffness = Symmetric::from_entries(mass.matrix.size(), entries);
    Ok(SAFE * power(&stiffness, mass, STILL))
}

/// A bound of `ω²` of bending alone, a few per cent above it: power iteration comes from below, and `λM - K` has a Cholesky factor where `λ` is above. None where no such
/// `λ` shows. `O(n w²)` for envelopes of the width `w`.
fn highest_of_bending(bend: &Symmetric, mass: &Mass) -> Option<f64> {
    let n = mass.matrix.size();
    let row_at = |i: usize| mass.order.as_ref().map_or(i, |order| order[i]);
    let mut place = vec![0; n];
    (0..n).for_each(|i| place[row_at(i)] = i);
    let rows = |i: usize| mass.matrix.row(row_at(i)).chain(bend.row(row_at(i)));
    let first: Vec<u32> = (0..n).map(|i| rows(i).map(|(j, _)| place[j]).fold(i, usize::min) as u32).collect();
    let entry = |lambda: f64, i: usize, j: usize| {
        let (i, j) = (row_at(i), row_at(j));
        lambda * mass.matrix.entry(i, j) - bend.entry(i, j)
    };
    let from = power(bend, mass, ROUGHLY);
    let all = std::iter::successors(Some(NEAR * from), |last| Some(FARTHER * last)).take(TRIES);
    all.filter(|lambda| lambda.is_finite() && *lambda > 0.0)
        .find(|&lambda| EnvelopeCholesky::factor(first.clone(), 0.0, |i, j| entry(lambda, i, j)).is_ok())
}

/// Adds the matrix that bounds a cell's stiffness, by the numbers of its own vertices.
fn add_bound(elastic: &Elastic, index: usize, mut add: impl FnMut(usize, usize, f64)) {
    let points = &elastic.points;
    let cell = &points.cells[index];
    for point in 0..cell.count {
        let rest = &points.rest[cell.first + point];
        for direction in 0..points.directions {
            let scale = if points.directions == 1 {
                rest.weight * elastic.stiffness / rest.speed[0]
            } else {
                let speed = rest.speed[direction];
                rest.weight * rest.size * (elastic.stiffness + SHEARED * elastic.shear) / (speed * speed)
            };
            let row = points.row(cell, point, direction);
            for i in 0..cell.width {
                for j in 0..cell.width {
                    add(i, j, scale * row[i] * row[j]);
                }
            }
        }
    }
}

/// The largest `λ` with `K x = λ M x`; `None` where `M` is not positive definite to rounding.
fn largest_eigenvalue(m: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<f64> {
    let size = m.amax();
    let factor = (m / size).cholesky()?;
    let half = factor.l().solve_lower_triangular(k)?;
    let whole = factor.l().solve_lower_triangular(&half.transpose())?;
    let symmetric = (&whole + whole.transpose()) * 0.5;
    let largest = symmetric.symmetric_eigenvalues().iter().fold(0.0_f64, |most, v| most.max(*v));
    Some(largest / size).filter(|v| v.is_finite())
}

/// The largest eigenvalue of `M⁻¹K` by power iteration, until it changes by no more than this share of it.
fn power(stiffness: &Symmetric, mass: &Mass, still: f64) -> f64 {
    let n = mass.matrix.size();
    let mut space = RangeSpace::new([(mass.weight.clone(), mass.order.clone())]);
    space.factor();
    let (mut x, mut y) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
    // All frequencies in it, the same on every machine; one axis of three.
    (0..n).for_each(|i| x[3 * i] = 1.0 + ((i * 7 + 3) % 11) as f64 / 11.0 - 2.0 * (i % 2) as f64);
    let mut value = 0.0;
    for _ in 0..200 {
        let size = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(size > 0.0 && size.is_finite()) {
            return value;
        }
        x.iter_mut().for_each(|v| *v /= size);
        mass.matrix.multiply(&x, 3, &mut y);
        let weight: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
        stiffness.multiply(&x, 3, &mut y);
        let next = x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>() / weight;
        space.solve(&mut y, &[], &mut [], &mut []);
        std::mem::swap(&mut x, &mut y);
        let rests = (next - value).abs() <= still * next;
        value = next;
        if rests {
            break;
        }
    }
    value
}

/// The longest step of frequencies `ω² ≤ highest`, with friction within the shape (`viscosity / stiffness` of the stiffness) and the air's damping.
pub(crate) fn longest_step(highest: f64, material: &Material) -> f64 {
    let by_stiffness = SHARE / highest.sqrt();
    // Friction's rates, which velocities half a step old must not overshoot.
    let rate = if material.stiffness > 0.0 { highest * material.viscosity / material.stiffness } else { 0.0 };
    let by_friction = 0.5 / (rate + material.damping);
    by_stiffness.min(by_friction)
}
