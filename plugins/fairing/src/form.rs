//! An energy as the kernel measures with one: its squares.

use loftsman_kernel::Point;
use loftsman_kernel::energy::{Energy, Squares};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{Derivative, Shape};

use crate::energy::{EnergySum, Term};
use crate::integrals::Integrals;

/// For fairing; and for edits that [make it least](loftsman_kernel::edit::Edit::minimise), event after event, and metrics: there
/// the form is the matrix `AᵀA`, whose condition is the square of what [`Fair`](crate::Fair) works with: answers are to rounding
/// in what is asked, and in the energy to some 1e-8 of it for a hundred vertices that bend.
impl Energy for EnergySum {
    fn describe(&self) -> String {
        self.to_string()
    }

    fn squares(&self, shape: &dyn Shape, origin: Point) -> Result<Option<Squares>> {
        if self.terms.is_empty() {
            return Err(nothing());
        }
        let mut squares = Integrals::default();
        for (weight, term) in &self.terms {
            if !(*weight >= 0.0 && weight.is_finite()) {
                return Err(Error::Invalid(format!(
                    "an energy's weight is {weight}: every weight must be a finite number, and not negative"
                )));
            }
            if *weight == 0.0 {
                continue;
            }
            match term {
                Term::Derivative(order) => {
                    squares.0.differentiate(*order);
                    squares.integrals(shape, *order, *weight, None)?;
                }
                Term::Near => squares.integrals(shape, 0, *weight, Some(origin))?,
                Term::Data(points) => {
                    for datum in points {
                        let good = datum.weight > 0.0
                            && datum.weight.is_finite()
                            && datum.to.coords.iter().all(|c| c.is_finite());
                        if !good {
                            return Err(Error::Invalid(format!(
                                "the point to be near to at {} needs a positive weight and finite coordinates",
                                datum.at
                            )));
                        }
                        let stencil = shape.stencil(datum.at, Derivative::POSITION)?;
                        let root = (weight * datum.weight).sqrt();
                        squares.0.open(stencil.vertices().iter().copied());
                        let target = (datum.to - origin) * root;
                        squares.0.row(stencil.coefficients().iter().map(|c| c * root), target);
                    }
                }
            }
        }
        Ok(Some(squares.0))
    }
}

/// No energy was given.
pub(crate) fn nothing() -> Error {
    Error::Invalid("say what should be small: give an energy, \"stretch\", \"bend\" or \"variation\"".into())
}
