//! Both partial derivatives scaled at once, as nearly as there is a surface for it.

use loftsman_kernel::Vector;
use loftsman_kernel::solve::{EnvelopeCholesky, SparseRows, Symmetric};
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space};

use crate::error::{FineTuneError, Result};
use crate::lift::{Alpha, lifted};
use crate::lines::{along_u, derivative_u, size, start_row, turned};

/// The given surface in the space of the fit: along `u` that of `∫ α S_u du`, along `v` that of `∫ β S_v dv`.
pub(crate) fn raised(given: &Field<Vector>, fields: &[Field<f64>; 2]) -> Result<Field<Vector>> {
    let line = |field: &Field<f64>, direction| -> Result<Alpha> {
        let space = field.space(direction).clone();
        let values = vec![1.0; space.len()];
        Ok(Alpha::Line(Function::new(space, values)?))
    };
    let closes = |direction: Direction| given.space(direction).is_periodic();
    let along = lifted(given, &line(&fields[0], Direction::U)?, closes(Direction::U), ["u", "v"])?;
    let both = lifted(&turned(&along)?, &line(&fields[1], Direction::V)?, closes(Direction::V), ["v", "u"])?;
    turned(&both)
}

/// `min ∫∫ |D_u - αS_u|² + |D_v - βS_v|²` over all `D` in the space of `start`, the given surface raised, with `kept` rows at
/// the start and at the end along `u` and columns along `v` as `start` has them; where none are kept, `D` starts where `S` does. And
/// `(least / ∫∫ |αS_u|² + |βS_v|²)^½`. One factorisation of a sparse matrix, `O(n b²)` for `n` control vertices in a band of `b`.
///
/// # Errors
/// When no vertex is left to move, or numbers overflow.
pub(crate) fn fitted(
    given: &Field<Vector>,
    fields: &[Field<f64>; 2],
    start: &Field<Vector>,
    kept: [[usize; 2]; 2],
) -> Result<(Field<Vector>, f64)> {
    let (u, v) = (start.space(Direction::U), start.space(Direction::V));
    let (rows, columns) = (u.len(), v.len());
    let wanted = [
        derivative_u(given)?.times(&fields[0])?,
        turned(&derivative_u(&turned(given)?)?.times(&turned(&fields[1])?)?)?,
    ];
    let edge = |k: usize, of: usize, [first, last]: [usize; 2]| k < first || k + last >= of;
    let mut free: Vec<usize> = (0..rows * columns)
        .filter(|k| !edge(k / columns, rows, kept[0]) && !edge(k % columns, columns, kept[1]))
        .collect();
    if free.is_empty() {
        return Err(FineTuneError::Contradiction(format!(
            "of {rows} × {columns} control vertices of the tuned surface none would be free with {} rows and {} columns kept at \
             their ends: keep fewer, or give α more knots",
            kept[0][0] + kept[0][1],
            kept[1][0] + kept[1][1]
        )));
    }
    let floats = free.len() == rows * columns;
    if floats {
        free.remove(0);
    }
    let stiffness = stiffness(u, v);
    let mut pull = right_side(&wanted, u, v)?;
    let mut held = vec![Vector::zeros(); pull.len()];
    multiply(&stiffness, start.coefficients(), &mut held);
    pull.iter_mut().zip(&held).for_each(|(p, h)| *p -= h);
    let own: Vec<Vector> = free.iter().map(|k| pull[*k]).collect();
    let way = solve(&stiffness.select(&free), &own)?;
    let mut all = start.coefficients().to_vec();
    free.iter().zip(way).for_each(|(k, way)| all[*k] += way);
    let mut found = Field::new(u.clone(), v.clone(), all)?;
    if floats {
        let first = |field: &Field<Vector>| -> Result<Vector> {
            let row = start_row(field)?;
            Ok(row.value(row.space().domain().0)?)
        };
        let by = first(given)? - first(&found)?;
        found = found.mapped(|c| c + by)?;
    }
    let residual = residual(&found, &wanted)?;
    Ok((found, residual))
}

/// `∫∫ M_i,u M_j,u + M_i,v M_j,v` of the products of B-splines.
fn stiffness(u: &Space, v: &Space) -> Symmetric {
    let own = |space: &Space, order| Symmetric::from_entries(space.len(), space.gram(order));
    let n = v.len();
    let mut entries = Vec::new();
    for (a, b) in [(own(u, 1), own(v, 0)), (own(u, 0), own(v, 1))] {
        for i in 0..a.size() {
            for (k, x) in a.row(i).filter(|(k, _)| *k <= i) {
                for j in 0..n {
                    let lower = b.row(j).map(|(l, y)| (i * n + j, k * n + l, x * y));
                    entries.extend(lower.filter(|(row, column, _)| column <= row));
                }
            }
        }
    }
    Symmetric::from_entries(u.len() * n, entries)
}

/// `∫∫ (N_i M_j)_u αS_u + (N_i M_j)_v βS_v`.
fn right_side(wanted: &[Field<Vector>; 2], u: &Space, v: &Space) -> Result<Vec<Vector>> {
    let mut all = pairing(
        &slopes(u, wanted[0].space(Direction::U))?,
        &inner(v, wanted[0].space(Direction::V))?,
        &wanted[0],
    );
    let other = pairing(
        &inner(u, wanted[1].space(Direction::U))?,
        &slopes(v, wanted[1].space(Direction::V))?,
        &wanted[1],
    );
    all.iter_mut().zip(other).for_each(|(a, b)| *a += b);
    Ok(all)
}

fn inner(space: &Space, other: &Space) -> Result<SparseRows> {
    Ok(space.inner_products(other)?)
}

/// `∫ N_i' R_k` of the B-splines of a space and of another: the derivatives of those of the clamped space, `p (N_i - N_{i+1})`
/// each over its length, and the conversion there.
fn slopes(space: &Space, other: &Space) -> Result<SparseRows> {
    let clamping = space.clamping()?;
    let (open, p) = (clamping.to(), space.degree());
    let derived = open.derived()?;
    let inner = derived.inner_products(other)?;
    let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); space.len()];
    for i in 0..derived.len() {
        let by = p as f64 / (open.flat()[i + p + 1] - open.flat()[i + 1]);
        for (k, sign) in [(i + 1, by), (i, -by)] {
            for (vertex, w) in clamping.row(k) {
                rows[vertex].extend(inner.iter_row(i).map(|(c, x)| (c, x * w * sign)));
            }
        }
    }
    let mut all = SparseRows::new(other.len());
    rows.into_iter().for_each(|row| all.push(row));
    Ok(all)
}

/// `A W Bᵀ`.
fn pairing(a: &SparseRows, b: &SparseRows, w: &Field<Vector>) -> Vec<Vector> {
    let width = b.len();
    let each = w.coefficients().chunks_exact(b.width().max(1));
    let across: Vec<Vec<Vector>> = each
        .map(|row| {
            (0..width).map(|j| b.iter_row(j).fold(Vector::zeros(), |sum, (k, x)| sum + row[k] * x)).collect()
        })
        .collect();
    let sum = |i: usize, j: usize| a.iter_row(i).fold(Vector::zeros(), |sum, (k, x)| sum + across[k][j] * x);
    (0..a.len()).flat_map(|i| (0..width).map(move |j| (i, j))).map(|(i, j)| sum(i, j)).collect()
}

fn multiply(matrix: &Symmetric, x: &[Vector], out: &mut [Vector]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = matrix.row(i).fold(Vector::zeros(), |sum, (k, w)| sum + x[k] * w);
    }
}

/// By a Cholesky factorisation in an order that keeps neighbours together, and one step of refinement.
fn solve(matrix: &Symmetric, pull: &[Vector]) -> Result<Vec<Vector>> {
    let order = matrix.narrow_order();
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, old)| place[*old] = new);
    let first =
        |(i, old): (usize, &usize)| matrix.row(*old).fold(i, |first, (k, _)| first.min(place[k])) as u32;
    let first = order.iter().enumerate().map(first).collect();
    let entry = |i: usize, k: usize| matrix.entry(order[i], order[k]);
    let factor = EnvelopeCholesky::factor(first, 1e-14, entry).map_err(|row| {
        FineTuneError::Contradiction(format!(
            "the derivatives do not determine control vertex {} of the fit: knots are too near to one another, remove some",
            order.get(row).copied().unwrap_or(row)
        ))
    })?;
    let once = |pull: &[Vector]| {
        let mut x: Vec<f64> = order.iter().flat_map(|k| [pull[*k].x, pull[*k].y, pull[*k].z]).collect();
        factor.solve(&mut x, 3);
        let mut all = vec![Vector::zeros(); pull.len()];
        order.iter().zip(x.as_chunks::<3>().0).for_each(|(k, x)| all[*k] = Vector::from(*x));
        all
    };
    let mut way = once(pull);
    let mut left = vec![Vector::zeros(); way.len()];
    multiply(matrix, &way, &mut left);
    let left: Vec<Vector> = pull.iter().zip(left).map(|(p, l)| p - l).collect();
    way.iter_mut().zip(once(&left)).for_each(|(w, more)| *w += more);
    Ok(way)
}

/// How far the derivatives are from what was wanted, relative to it.
fn residual(found: &Field<Vector>, wanted: &[Field<Vector>; 2]) -> Result<f64> {
    let (mut off, mut whole) = (0.0, 0.0);
    let other = [turned(found)?, turned(&wanted[1])?];
    for (found, wanted) in [(found, &wanted[0]), (&other[0], &other[1])] {
        let opened = |field: &Field<Vector>| {
            let along = along_u(field, |line| Ok(line.opened()?))?;
            turned(&along_u(&turned(&along)?, |line| Ok(line.opened()?))?)
        };
        let (derivative, wanted) = (opened(&derivative_u(&opened(found)?)?)?, opened(wanted)?);
        off += squared(&derivative.plus(-1.0, &wanted)?)?;
        whole += squared(&wanted)?;
    }
    Ok(if whole > 0.0 { (off / whole).sqrt() } else { 0.0 })
}

/// `∫∫ |f|²`, of the function scaled to size 1 so that no square underflows, and scaled back.
fn squared(field: &Field<Vector>) -> Result<f64> {
    let scale = size(field);
    if scale == 0.0 {
        return Ok(0.0);
    }
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let unit = field.mapped(|c| c / scale)?;
    let images = pairing(&inner(u, u)?, &inner(v, v)?, &unit);
    let sum: f64 = images.iter().zip(unit.coefficients()).map(|(a, b)| a.dot(b)).sum();
    Ok(sum.max(0.0) * scale * scale)
}
