//! What is measured of control vertices: quadratic forms, and what they pull at.
//!
//! An [`Energy`] is `E(P) = (P - P*)ᵀ W (P - P*)` over the control vertices of the shapes of a problem, the same for x, y and z.
//! Its form `W` alone measures adjustments: what "least" means in an edit ([`Edit::metric`](crate::edit::Edit::metric)). With its
//! pull, the way to where it is least by itself, it is what an edit makes least
//! ([`Edit::minimise`](crate::edit::Edit::minimise)).

use std::fmt::Debug;

use crate::Vector;
use crate::error::Result;
use crate::functional::Shapes;
use crate::solve::SystemMetric;

/// A quadratic form over the control vertices of some shapes, numbered through all of them.
pub trait Energy: Debug + Send + Sync {
    /// What it is, for people and reports.
    fn describe(&self) -> String;

    /// `W` over the control vertices `moving` (ascending), the others staying where they are: one row and column for each,
    /// positive definite.
    ///
    /// # Errors
    /// When it cannot be measured on these shapes.
    fn form(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<SystemMetric>;

    /// `W (P* - P)`: half of what the energy falls by where each of the vertices `moving` moves. None (the default) for what
    /// measures adjustments only: it is least where nothing moves.
    ///
    /// # Errors
    /// As for [`form`](Self::form).
    fn pull(&self, shapes: &Shapes<'_>, moving: &[usize]) -> Result<Vec<Vector>> {
        let _ = (shapes, moving);
        Ok(Vec::new())
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
