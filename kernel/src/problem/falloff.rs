//! How much a moved control vertex takes others along.

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::shape::{Grid, Neighbours, Shape};

/// How near a walk over a net comes to being one that a matrix cannot be told from a singular one: less than 1.
const STEP: f64 = 0.9;

/// Entries of `W⁻¹` for one vertex: calls `found` with every vertex that is taken along, and by how much (1 for itself).
///
/// On a [grid](Shape::grid) it is the product of Wendland's `φ(distance/radius)` in both directions. On any other net of
/// [neighbours](Shape::neighbours), where no function of the distance need be positive definite, it is
/// `Π_k (I + θ_k D^(-½) A D^(-½))`, scaled to a unit diagonal: `A` the net's adjacency, `D` the number of each vertex's
/// neighbours, one factor for each vertex that the radius goes beyond the first, `θ = 0.9`, the last one's less by what
/// the radius is short of a whole number. Each factor is positive definite, they commute, and so their product is; and
/// nothing that is so far away as the radius is taken along.
///
/// # Errors
/// When the shape does not say which vertices are neighbours, or these are not mutual.
pub(super) fn falloff(
    shape: &dyn Shape,
    vertex: usize,
    radius: f64,
    mut found: impl FnMut(usize, f64),
) -> Result<()> {
    if let Some(grid) = shape.grid() {
        on_grid(&grid, vertex, radius, found);
        return Ok(());
    }
    let net = shape.neighbours().ok_or_else(|| {
        Error::Invalid(format!(
            "a falloff goes from a control vertex to its neighbours, and a shape ({}) does not say which these are: use \"least\", \
             or weights",
            shape.type_name()
        ))
    })?;
    let walk = Walk { shape, net, radius };
    let own = walk.from(vertex)?;
    let scale = own.get(&vertex).copied().unwrap_or(1.0);
    for (&near, &value) in &own {
        // The diagonal of the other one, so that the matrix is symmetric.
        let other = if near == vertex { scale } else { walk.from(near)?.get(&near).copied().unwrap_or(1.0) };
        found(near, value / (scale * other).sqrt());
    }
    Ok(())
}

/// Whether a falloff of a radius is one on a closed shape.
///
/// # Errors
/// When it goes more than once around.
pub(super) fn check_radius(shape: &dyn Shape, radius: f64) -> Result<()> {
    match shape.grid().as_ref().and_then(wrapped).filter(|&length| 2.0 * radius > length as f64) {
        None => Ok(()),
        Some(length) => Err(Error::Invalid(format!(
            "a falloff radius of {radius} goes more than once around a closed shape of {length} \
             control vertices: give at most {}",
            length / 2
        ))),
    }
}

/// Steps over a net.
struct Walk<'a> {
    shape: &'a dyn Shape,
    net: &'a dyn Neighbours,
    radius: f64,
}

impl Walk<'_> {
    /// The row of the product of all factors that belongs to a vertex. `O(r v)` for the `v` vertices nearer than the radius.
    fn from(&self, vertex: usize) -> Result<BTreeMap<usize, f64>> {
        let mut row = BTreeMap::from([(vertex, 1.0)]);
        let count = self.shape.control_vertices().len();
        let steps = (self.radius.ceil() - 1.0).clamp(0.0, count as f64) as usize;
        for step in 0..steps {
            let part = STEP * (self.radius - 1.0 - step as f64).min(1.0);
            let mut next = row.clone();
            for (&here, &value) in &row {
                let around = self.net.around(here);
                for &there in &around {
                    let back = if there < count { self.net.around(there) } else { Default::default() };
                    if there == here || !back.contains(&here) {
                        return Err(Error::Invalid(format!(
                            "a shape ({}) says that control vertex {there} is next to {here}, but not the other way round: which are \
                             neighbours is mutual",
                            self.shape.type_name()
                        )));
                    }
                    let share = part / ((around.len() * back.len()) as f64).sqrt();
                    *next.entry(there).or_insert(0.0) += share * value;
                }
            }
            row = next;
        }
        Ok(row)
    }
}

/// The shortest way around the grid, where it is closed in a direction.
fn wrapped(grid: &Grid) -> Option<usize> {
    let rows = grid.rows_wrap.then_some(grid.rows);
    let columns = grid.columns_wrap.then_some(grid.columns);
    rows.into_iter().chain(columns).min()
}

/// Calls `found` with every vertex within the radius in both directions of the grid, and the product of the
/// falloffs.
fn on_grid(grid: &Grid, vertex: usize, radius: f64, mut found: impl FnMut(usize, f64)) {
    let phi = |distance: usize| {
        let r = distance as f64 / radius;
        if r >= 1.0 { 0.0 } else { (1.0 - r).powi(3) * (3.0 * r + 1.0) }
    };
    // No farther than the grid goes, however large the radius.
    let reach = |length: usize| (radius.ceil().min(length as f64) as usize).min(length.saturating_sub(1));
    let line = |at: usize, length: usize, wrap: bool| {
        let reach = if wrap { reach(length).min(length / 2) } else { reach(length) };
        let low = if wrap { at + length - reach } else { at.saturating_sub(reach) };
        let high = if wrap { at + length + reach } else { (at + reach).min(length.saturating_sub(1)) };
        let centre = if wrap { at + length } else { at };
        // Where the two ends of a wrap meet, count the vertex once.
        let low = if wrap && high - low + 1 > length { high + 1 - length } else { low };
        (low..=high).map(move |i| (if wrap { i % length } else { i }, i.abs_diff(centre)))
    };
    let columns = grid.columns.max(1);
    for (row, row_distance) in line(vertex / columns, grid.rows, grid.rows_wrap) {
        let across = phi(row_distance);
        if across == 0.0 {
            continue;
        }
        for (column, distance) in line(vertex % columns, columns, grid.columns_wrap) {
            let value = across * phi(distance);
            if value != 0.0 {
                found(row * columns + column, value);
            }
        }
    }
}
