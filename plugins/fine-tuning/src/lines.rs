//! Spline functions of two parameters, line by line along `u`; what concerns `v` is asked of them turned over.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::algebra::{Coefficient, Field, Function};
use loftsman_kernel::spline::{Direction, Space};
use loftsman_kernel::text::short;

use crate::alpha::check_torn;
use crate::error::{FineTuneError, Result};

/// The other direction.
pub(crate) fn across(direction: Direction) -> Direction {
    match direction {
        Direction::U => Direction::V,
        Direction::V => Direction::U,
    }
}

/// A direction's place in pairs.
pub(crate) fn index(direction: Direction) -> usize {
    match direction {
        Direction::U => 0,
        Direction::V => 1,
    }
}

/// What messages call a direction.
pub(crate) fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::U => "u",
        Direction::V => "v",
    }
}

/// `f(v, u)`. `O(rows × columns)`.
pub(crate) fn turned<T: Coefficient>(field: &Field<T>) -> Result<Field<T>> {
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let all = field.coefficients();
    let each = (0..v.len()).flat_map(|j| (0..u.len()).map(move |i| all[i * v.len() + j]));
    Ok(Field::new(v.clone(), u.clone(), each.collect())?)
}

/// The function so that `direction` is its first one: itself, or turned over.
pub(crate) fn facing<T: Coefficient>(field: &Field<T>, direction: Direction) -> Result<Field<T>> {
    match direction {
        Direction::U => Ok(field.clone()),
        Direction::V => turned(field),
    }
}

/// Each line along `u` changed, and put together again.
pub(crate) fn along_u<T: Coefficient>(
    field: &Field<T>,
    change: impl Fn(Function<T>) -> Result<Function<T>>,
) -> Result<Field<T>> {
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let all = field.coefficients();
    let line = |j: usize| {
        let own = (0..u.len()).map(|i| all[i * v.len() + j]).collect();
        change(Function::new(u.clone(), own)?)
    };
    let lines = (0..v.len()).map(line).collect::<Result<Vec<_>>>()?;
    let Some(first) = lines.first() else { return Ok(field.clone()) };
    let space = first.space().clone();
    let lines = &lines;
    let each = (0..space.len()).flat_map(|i| lines.iter().map(move |line| line.coefficients()[i]));
    let each = each.collect();
    Ok(Field::new(space, v.clone(), each)?)
}

/// Each line along a direction changed, and put together again.
pub(crate) fn along<T: Coefficient>(
    field: &Field<T>,
    direction: Direction,
    change: impl Fn(Function<T>) -> Result<Function<T>>,
) -> Result<Field<T>> {
    match direction {
        Direction::U => along_u(field, change),
        Direction::V => turned(&along_u(&turned(field)?, change)?),
    }
}

/// The derivative along `u`; of a closed function with corners opened at its seam.
///
/// # Errors
/// When a line along `u` is torn.
pub(crate) fn derivative_u<T: Coefficient>(field: &Field<T>) -> Result<Field<T>> {
    check_torn(field.space(Direction::U), "surface")?;
    let opened = || along_u(field, |line| Ok(line.opened()?));
    Ok(field.derivative(Direction::U).or_else(|_| match opened() {
        Ok(opened) => opened.derivative(Direction::U),
        Err(_) => field.derivative(Direction::U),
    })?)
}

/// The line `f(u₀, v)` where the domain of `u` starts.
pub(crate) fn start_row<T: Coefficient>(field: &Field<T>) -> Result<Function<T>> {
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let (at, p) = (u.domain().0, u.degree());
    let span = u.span(at);
    let mut values = vec![0.0; p + 1];
    u.basis_into(span, at, 0, &mut values);
    let own = |j: usize| {
        let each = values.iter().enumerate().filter(|(_, n)| **n != 0.0);
        each.fold(T::zero(), |sum, (i, n)| {
            sum + field.coefficients()[u.vertex(span - p + i) * v.len() + j] * *n
        })
    };
    Ok(Function::new(v.clone(), (0..v.len()).map(own).collect())?)
}

/// The largest number among some coefficients.
pub(crate) fn size(field: &Field<Vector>) -> f64 {
    field.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.amax()))
}

/// The periodic space in which a clamped one over the same period is closed, with corners at its seam: its last B-spline is its
/// first.
fn closed_space(open: &Space) -> Result<Space> {
    let (p, t) = (open.degree(), open.knots());
    let knots = t.get(1..t.len().saturating_sub(p)).unwrap_or_default();
    Ok(Space::periodic(p, knots.to_vec())?)
}

/// A function, clamped along `u`, whose first and last rows are the same but for rounding, as a periodic one: the last row is the
/// first.
///
/// # Errors
/// When they differ by more than `1e-9` of the function's size.
pub(crate) fn closed_u(field: &Field<Vector>, what: &str) -> Result<Field<Vector>> {
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let all = field.coefficients();
    let (first, last) = (&all[..v.len()], &all[all.len() - v.len()..]);
    let gap = first.iter().zip(last).fold(0.0_f64, |m, (a, b)| m.max((a - b).amax()));
    if gap > 1e-9 * size(field) {
        return Err(FineTuneError::Contradiction(format!(
            "the surface is closed along {what}, and would have a gap of {gap} there: give α(u, v) a periodic space along \
             {what} ({{ degree, knots, values }} with one knot there more than values along {what}: those of one period), or tune a region of it",
            gap = short(gap)
        )));
    }
    // The open space's first B-spline is the first that the span behind the seam knows.
    let space = closed_space(u)?;
    let before = space.span(space.domain().0) - space.degree();
    let mut rows = vec![Vector::zeros(); space.len() * v.len()];
    for (i, row) in all.chunks_exact(v.len()).take(space.len()).enumerate() {
        let at = space.vertex(before + i) * v.len();
        rows[at..at + v.len()].copy_from_slice(row);
    }
    Ok(Field::new(space, v.clone(), rows)?)
}
