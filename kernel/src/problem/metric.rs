//! What "least" means: the metric of the adjustment, over all control vertices of an edit.

use std::sync::Arc;

use super::falloff::{check_radius, falloff};
use crate::Vector;
use crate::energy::Energy;
use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::shape::Shape;
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
    /// is at least 1 (1 is [`Least`](Self::Least)). That is on a grid of control vertices; on another net of
    /// [neighbours](crate::shape::Neighbours) it is a product of steps to these, positive definite too.
    Falloff(f64),
    /// `(1/L) ∫ |d|² + L²|d'|²`: the displacement changes little along the shape. `L` is the length of the domain.
    Stretch,
    /// `(1/L) ∫ |d|² + L⁴|d''|²`: the displacement bends little.
    Bend,
    /// Any symmetric positive definite matrix.
    Matrix(Arc<Symmetric>),
    /// The form of any energy.
    Energy(Measured),
}

/// An energy that several hold. It equals itself only.
#[derive(Debug, Clone)]
pub struct Measured(pub Arc<dyn Energy>);

impl PartialEq for Measured {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Energy for Metric {
    fn describe(&self) -> String {
        match self {
            Self::Least => "least".into(),
            Self::Weights(_) => "weights".into(),
            Self::Falloff(radius) => format!("falloff {radius}"),
            Self::Stretch => "stretch".into(),
            Self::Bend => "bend".into(),
            Self::Matrix(_) => "matrix".into(),
            Self::Energy(Measured(energy)) => energy.describe(),
        }
    }

    /// More than themselves only with a falloff or a matrix.
    fn takes_along(
        &self,
        shapes: &Shapes<'_>,
        touched: Vec<usize>,
        may_move: &dyn Fn(usize) -> bool,
    ) -> Result<Vec<usize>> {
        match self {
            Self::Least | Self::Weights(_) => Ok(touched),
            Self::Energy(Measured(energy)) => energy.takes_along(shapes, touched, may_move),
            Self::Stretch | Self::Bend | Self::Matrix(_) => {
                Ok((0..shapes.vertex_count()).filter(|&v| may_move(v)).collect())
            }
            Self::Falloff(radius) => {
                let mut all = Vec::new();
                for &vertex in &touched {
                    let (shape, offset) = shape_of(shapes, vertex)?;
                    falloff(shape, vertex - offset, *radius, |near, _| {
                        if may_move(offset + near) {
                            all.push(offset + near);
                        }
                    })?;
                }
                all.sort_unstable();
                all.dedup();
                Ok(all)
            }
        }
    }

    fn takes_all(&self) -> bool {
        match self {
            Self::Least | Self::Weights(_) | Self::Falloff(_) => false,
            Self::Stretch | Self::Bend | Self::Matrix(_) => true,
            Self::Energy(Measured(energy)) => energy.takes_all(),
        }
    }

    fn pull(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<Vec<Vector>> {
        match self {
            Self::Energy(Measured(energy)) => energy.pull(shapes, moving),
            _ => Ok(Vec::new()),
        }
    }

    fn form(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric> {
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
                Ok(SystemMetric::Weights(Arc::new(moving.iter().map(|&v| weights[v]).collect())))
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
                    check_radius(shape, *radius)?;
                    falloff(shape, vertex - offset, *radius, |near, value| {
                        if let Some(j) = moving.binary_search(&(offset + near)).ok().filter(|&j| j <= i) {
                            entries.push((i, j, value));
                        }
                    })?;
                }
                Ok(SystemMetric::Inverse(Arc::new(Symmetric::from_entries(moving.len(), entries))))
            }
            Self::Stretch | Self::Bend => {
                let order = if *self == Self::Stretch { 1 } else { 2 };
                let mut entries = Vec::new();
                for index in 0..shapes.len() {
                    let (shape, offset) = (shapes.get(index)?, shapes.offset(index));
                    // Nothing is measured of what stands still: knots too close for it matter not, and it need have no such metric.
                    let first = moving.partition_point(|&v| v < offset);
                    if moving.get(first).is_none_or(|&v| v >= offset + shape.control_vertices().len()) {
                        continue;
                    }
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
                Ok(SystemMetric::Matrix(Arc::new(all.select(moving))))
            }
            Self::Matrix(matrix) => {
                if matrix.size() != shapes.vertex_count() {
                    let (found, vertices) = (matrix.size(), shapes.vertex_count());
                    return Err(Error::Invalid(format!(
                        "a metric of size {found} does not fit {vertices} control vertices"
                    )));
                }
                Ok(SystemMetric::Matrix(Arc::new(matrix.select(moving))))
            }
            Self::Energy(Measured(energy)) => {
                checked(energy.form(shapes, moving)?, moving.len(), energy.as_ref())
            }
        }
    }
}

/// The form of an energy of somebody else's, as large as it should be.
fn checked(form: SystemMetric, count: usize, energy: &dyn Energy) -> Result<SystemMetric> {
    let size = match &form {
        SystemMetric::Least => count,
        SystemMetric::Weights(weights) => weights.len(),
        SystemMetric::Matrix(matrix) | SystemMetric::Inverse(matrix) => matrix.size(),
        SystemMetric::Through(_) => {
            return Err(Error::Invalid(format!(
                "the energy \"{}\" gives a form of unknowns of its own: it must be one of control vertices",
                energy.describe()
            )));
        }
    };
    if size == count {
        return Ok(form);
    }
    Err(Error::Invalid(format!(
        "the energy \"{}\" gives a form of size {size} for {count} control vertices that move",
        energy.describe()
    )))
}

fn shape_of<'a>(shapes: &Shapes<'a>, vertex: usize) -> Result<(&'a dyn Shape, usize)> {
    let index = (0..shapes.len()).rev().find(|&i| shapes.offset(i) <= vertex).unwrap_or(0);
    Ok((shapes.get(index)?, shapes.offset(index)))
}
