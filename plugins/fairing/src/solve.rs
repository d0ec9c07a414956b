//! Fairing done: the least energy under equations alone, or between bounds.

use std::sync::Arc;

use loftsman_kernel::edit::EditError;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{Automatic, Solver};

use crate::between::Between;
use crate::bounds::split;
use crate::fair::{Fair, Faired};
use crate::problem::Problem;

impl<S: Shape + Clone> Fair<S> {
    /// The shape of least energy, with the default solver for the constraints.
    ///
    /// # Errors
    /// As for [`solve_with`](Self::solve_with).
    pub fn solve(self) -> Result<Faired<S>, EditError> {
        self.solve_with(Automatic)
    }

    /// The shape of least energy that meets the constraints; of several the nearest (`Σ‖dᵢ‖²` least) to the shape that the
    /// least adjustment gives. Work is linear in the control vertices of a curve.
    ///
    /// # Errors
    /// When something cannot be asked of the shapes, is not linear, or the constraints cannot all hold; when the energy needs
    /// derivatives that the degree does not have; when the constraints alone move a control vertex beyond [`within`](Self::within).
    pub fn solve_with(mut self, solver: impl Solver + 'static) -> Result<Faired<S>, EditError> {
        let solver: Arc<dyn Solver> = Arc::new(solver);
        let asked = std::mem::take(&mut self.constraints);
        let all = std::iter::once(self.shape.as_shape()).chain(self.others.iter().map(AsRef::as_ref));
        let (equations, bounds) = split(asked.clone(), &Shapes::new(all))?;
        let problem = Problem::new(&self, solver)?;
        let plain = problem.stage(equations.clone())?;
        if bounds.is_empty() {
            let least = problem.least(&plain, plain.x.clone(), self.within)?;
            return problem.hand_out(&plain, &least, &[], &[]);
        }
        let (equations, bounds) = (&equations, &bounds);
        Between { problem: &problem, plain: &plain, bounds, asked: &asked, equations }.solve()
    }
}
