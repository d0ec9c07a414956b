//! An energy as the kernel measures with one: the form and the pull of its squares.

use std::sync::Arc;

use loftsman_kernel::energy::Energy;
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::solve::{Symmetric, SystemMetric};
use loftsman_kernel::{Point, Vector};

use crate::energy::EnergySum;
use crate::squares::Squares;

/// The squares of each shape of a problem, with the number of its first vertex, and the point that they are relative to.
fn squares(energy: &EnergySum, shapes: &Shapes<'_>) -> Result<Vec<(Squares, usize, Point)>> {
    let each = (0..shapes.len()).map(|index| {
        let shape = shapes.get(index)?;
        let origin = shape.control_vertices().first().copied().unwrap_or_else(Point::origin);
        Ok((Squares::new(shape, energy, origin)?, shapes.offset(index), origin))
    });
    each.collect()
}

/// For edits that [make it least](loftsman_kernel::edit::Edit::minimise), event after event, and metrics. The form is the matrix
/// `AᵀA`, whose condition is the square of what [`Fair`](crate::Fair) works with: answers are to rounding in what is asked, and
/// in the energy to some 1e-8 of it for a hundred vertices that bend.
impl Energy for EnergySum {
    fn describe(&self) -> String {
        self.to_string()
    }

    fn form(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric> {
        let mut entries = Vec::new();
        for (squares, offset, _) in squares(self, shapes)? {
            squares.entries(|i, j, value| entries.push((offset + i, offset + j, value)));
        }
        let all = Symmetric::from_entries(shapes.vertex_count(), entries);
        Ok(SystemMetric::Matrix(Arc::new(all.select(moving))))
    }

    fn pull(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<Vec<Vector>> {
        let mut all = Vec::with_capacity(shapes.vertex_count());
        for (index, (squares, _, origin)) in squares(self, shapes)?.into_iter().enumerate() {
            let vertices = shapes.get(index)?.control_vertices();
            let x: Vec<Vector> = vertices.iter().map(|p| p - origin).collect();
            let mut gradient = vec![Vector::zeros(); x.len()];
            squares.gradient(&x, true, &mut gradient);
            all.extend(gradient.into_iter().map(|g| -g));
        }
        Ok(moving.iter().map(|&v| all[v]).collect())
    }
}
