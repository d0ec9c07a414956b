//! What is measured of control vertices: quadratic forms, and what they pull at.
//!
//! An [`Energy`] is `E(P) = (P - P*)ᵀ W (P - P*)` over the control vertices of the shapes of a problem, the same for x, y and z.
//! Its form `W` alone measures adjustments: what "least" means in an edit ([`Edit::metric`](crate::edit::Edit::metric)). With its
//! pull, the way to where it is least by itself, it is what an edit makes least
//! ([`Edit::minimise`](crate::edit::Edit::minimise)).

mod squares;

use std::fmt::Debug;
use std::sync::Arc;

pub use self::squares::{Block, Squares};
use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::shape::Shape;
use crate::solve::{Symmetric, SystemMetric};
use crate::{Point, Vector};

/// A quadratic form over the control vertices of some shapes, numbered through all of them: given as a matrix (or its inverse), by
/// [`form`](Self::form) and, where it pulls, [`pull`](Self::pull); or as [`squares`](Self::squares) of each shape alone, from
/// which both follow.
pub trait Energy: Debug + Send + Sync {
    /// What it is, for people and reports.
    fn describe(&self) -> String;

    /// The energy of one shape as squares `‖A (P - origin) - r‖²`, which lose no accuracy to `AᵀA`; points are relative to an origin,
    /// which loses none of a shape far away. `None` (the default) for what is known by its matrix alone.
    ///
    /// # Errors
    /// When it cannot be measured on this shape.
    fn squares(&self, shape: &dyn Shape, origin: Point) -> Result<Option<Squares>> {
        let _ = (shape, origin);
        Ok(None)
    }

    /// `W` over the control vertices `moving` (ascending), the others staying where they are: one row and column for each,
    /// positive definite. By default `AᵀA` of the [squares](Self::squares).
    ///
    /// # Errors
    /// When it cannot be measured on these shapes.
    fn form(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric> {
        let mut entries = Vec::new();
        for (index, squares) in of_each(self, shapes)?.into_iter().enumerate() {
            let (squares, _) = squares.ok_or_else(|| {
                Error::Invalid(format!("\"{}\" says neither its matrix nor its squares", self.describe()))
            })?;
            let offset = shapes.offset(index);
            squares.entries(|i, j, value| entries.push((offset + i, offset + j, value)));
        }
        let all = Symmetric::from_entries(shapes.vertex_count(), entries);
        Ok(SystemMetric::Matrix(Arc::new(all.select(moving))))
    }

    /// `W (P* - P)`: half of what the energy falls by where each of the vertices `moving` moves. By default that of the
    /// [squares](Self::squares); none for what has none, which measures adjustments only: it is least where nothing moves.
    ///
    /// # Errors
    /// As for [`form`](Self::form).
    fn pull(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<Vec<Vector>> {
        let mut all = Vec::with_capacity(shapes.vertex_count());
        for (index, squares) in of_each(self, shapes)?.into_iter().enumerate() {
            let Some((squares, origin)) = squares else { return Ok(Vec::new()) };
            let x: Vec<Vector> = shapes.get(index)?.control_vertices().iter().map(|p| p - origin).collect();
            let mut gradient = vec![Vector::zeros(); x.len()];
            squares.gradient(&x, true, &mut gradient);
            all.extend(gradient.into_iter().map(|g| -g));
        }
        Ok(moving.iter().map(|&v| all[v]).collect())
    }

    /// The vertices that move where these do, ascending, as far as they may: all (the default), where `W` has no zeros to speak
    /// of.
    ///
    /// # Errors
    /// As for [`form`](Self::form).
    fn takes_along(
        &self,
        shapes: &Shapes<'_>,
        touched: Vec<usize>,
        may_move: &dyn Fn(usize) -> bool,
    ) -> Result<Vec<usize>> {
        let _ = touched;
        Ok((0..shapes.vertex_count()).filter(|&v| may_move(v)).collect())
    }

    /// Whether [`takes_along`](Self::takes_along) is all that may move, whatever moves.
    fn takes_all(&self) -> bool {
        true
    }
}

/// The squares of each shape, and the point that they are relative to.
fn of_each(energy: &(impl Energy + ?Sized), shapes: &Shapes<'_>) -> Result<Vec<Option<(Squares, Point)>>> {
    let each = (0..shapes.len()).map(|index| {
        let shape = shapes.get(index)?;
        let vertices = shape.control_vertices();
        let origin = vertices.first().copied().unwrap_or_else(Point::origin);
        let squares = energy.squares(shape, origin)?;
        squares.iter().try_for_each(|squares| squares.check(vertices.len()))?;
        Ok(squares.map(|squares| (squares, origin)))
    });
    each.collect()
}
