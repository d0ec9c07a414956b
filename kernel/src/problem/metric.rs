//! What "least" means: the metric of the adjustment, over all control vertices of an edit.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::shape::{Grid, Shape};
use crate::solve::{Symmetric, SystemMetric};

/// What "least" means. Vertices are numbered through all shapes of the edit.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Metric {
    /// `Σ‖d_i‖²` (paper 1, equation (1)).
    #[default]
    Least,
    /// `Σ w_i‖d_i‖²`: heavy vertices move less. One positive weight a vertex.
    Weights(Vec<f64>),
    /// A moved vertex takes its neighbours along, less and less up to this many vertices away (paper 4's warp):
    /// `W⁻¹ = φ(distance/radius)`, `φ(r) = (1-r)³(3r+1)` (Wendland 1995), which is positive definite. The radius
    /// is at least 1 (1 is [`Least`](Self::Least)).
    Falloff(f64),
    /// `(1/L) ∫ |d|² + L²|d'|²`: the displacement changes little along the shape. `L` is the length of the domain.
    Stretch,
    /// `(1/L) ∫ |d|² + L⁴|d''|²`: the displacement bends little.
    Bend,
    /// Any symmetric positive definite matrix.
    Matrix(Arc<Symmetric>),
}

impl Metric {
    /// The global vertices that move where these do: more than themselves only with a falloff or a matrix.
    /// Ascending. `may_move` tells which vertices are free.
    pub(crate) fn widen(
        &self,
        shapes: &Shapes<'_>,
        touched: Vec<usize>,
        may_move: &dyn Fn(usize) -> bool,
    ) -> Result<Vec<usize>> {
        match self {
            Self::Least | Self::Weights(_) => Ok(touched),
            Self::Stretch | Self::Bend | Self::Matrix(_) => {
                Ok((0..shapes.vertex_count()).filter(|&v| may_move(v)).collect())
            }
            Self::Falloff(radius) => {
                let mut all = Vec::new();
                for &vertex in &touched {
                    let (shape, offset) = shape_of(shapes, vertex)?;
                    neighbours(&grid_of(shape)?, vertex - offset, *radius, |near, _| {
                        if may_move(offset + near) {
                            all.push(offset + near);
                        }
                    });
                }
                all.sort_unstable();
                all.dedup();
                Ok(all)
            }
        }
    }

    /// The metric over the vertices that move (ascending global numbers).
    pub(crate) fn resolve(
        &self,
        shapes: &Shapes<'_>,
        moving: &[usize],
        per_axis: bool,
    ) -> Result<SystemMetric> {
        let spread = |matrix: Symmetric| Arc::new(if per_axis { matrix.per_axis() } else { matrix });
        match self {
            Self::Least => Ok(SystemMetric::Least),
            Self::Weights(weights) => {
                if weights.len() != shapes.vertex_count() {
                    return Err(Error::WeightCount {
                        weights: weights.len(),
                        vertices: shapes.vertex_count(),
                    });
                }
                if let Some((index, &value)) =
                    weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w > 0.0))
                {
                    return Err(Error::Weight { index, value });
                }
                let copies = if per_axis { 3 } else { 1 };
                let some = moving.iter().flat_map(|&v| std::iter::repeat_n(weights[v], copies)).collect();
                Ok(SystemMetric::Weights(Arc::new(some)))
            }
            Self::Falloff(radius) => {
                if !(radius.is_finite() && *radius >= 1.0) {
                    return Err(Error::Invalid(format!(
                        "a falloff radius of {radius} is not possible: give 1 or more control vertices"
                    )));
                }
                let mut entries = Vec::new();
                for (i, &vertex) in moving.iter().enumerate() {
                    let (shape, offset) = shape_of(shapes, vertex)?;
                    let grid = grid_of(shape)?;
                    if let Some(length) = wrapped(&grid).filter(|&length| 2.0 * radius > length as f64) {
                        return Err(Error::Invalid(format!(
                            "a falloff radius of {radius} goes more than once around a closed shape of {length} \
                             control vertices: give at most {}",
                            length / 2
                        )));
                    }
                    neighbours(&grid, vertex - offset, *radius, |near, value| {
                        if let Some(j) = moving.binary_search(&(offset + near)).ok().filter(|&j| j <= i) {
                            entries.push((i, j, value));
                        }
                    });
                }
                Ok(SystemMetric::Inverse(spread(Symmetric::from_entries(moving.len(), entries))))
            }
            Self::Stretch | Self::Bend => {
                let order = if *self == Self::Stretch { 1 } else { 2 };
                let mut entries = Vec::new();
                for index in 0..shapes.len() {
                    let (shape, offset) = (shapes.get(index)?, shapes.offset(index));
                    let matrix = shape.smoothness(order).ok_or_else(|| {
                        Error::Invalid(format!(
                            "shape {index} has no stretch or bend metric: use \"least\" or a falloff"
                        ))
                    })?;
                    let count = shape.control_vertices().len();
                    if matrix.size() != count {
                        return Err(Error::Invalid(format!(
                            "shape {index} ({}) has {count} control vertices and a stretch or bend metric of size {}",
                            shape.type_name(),
                            matrix.size()
                        )));
                    }
                    for i in 0..matrix.size() {
                        entries.extend(
                            matrix.row(i).filter(|(j, _)| *j <= i).map(|(j, v)| (offset + i, offset + j, v)),
                        );
                    }
                }
                let all = Symmetric::from_entries(shapes.vertex_count(), entries);
                Ok(SystemMetric::Matrix(spread(all.select(moving))))
            }
            Self::Matrix(matrix) => {
                if matrix.size() != shapes.vertex_count() {
                    let (found, vertices) = (matrix.size(), shapes.vertex_count());
                    return Err(Error::Invalid(format!(
                        "a metric of size {found} does not fit {vertices} control vertices"
                    )));
                }
                Ok(SystemMetric::Matrix(spread(matrix.select(moving))))
            }
        }
    }
}

fn shape_of<'a>(shapes: &Shapes<'a>, vertex: usize) -> Result<(&'a dyn Shape, usize)> {
    let index = (0..shapes.len()).rev().find(|&i| shapes.offset(i) <= vertex).unwrap_or(0);
    Ok((shapes.get(index)?, shapes.offset(index)))
}

/// The grid of a shape's control vertices.
fn grid_of(shape: &dyn Shape) -> Result<Grid> {
    shape.grid().ok_or_else(|| {
        Error::Invalid(format!(
            "a falloff goes from a control vertex to its neighbours, and a shape ({}) does not say which these are: use \"least\", \
             or weights",
            shape.type_name()
        ))
    })
}

/// The shortest way around the grid, where it is closed in a direction.
fn wrapped(grid: &Grid) -> Option<usize> {
    let rows = grid.rows_wrap.then_some(grid.rows);
    let columns = grid.columns_wrap.then_some(grid.columns);
    rows.into_iter().chain(columns).min()
}

/// Calls `found` with every vertex within the radius in both directions of the grid, and the product of the
/// falloffs.
fn neighbours(grid: &Grid, vertex: usize, radius: f64, mut found: impl FnMut(usize, f64)) {
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
