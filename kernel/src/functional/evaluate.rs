//! What a functional is of a shape, in one call.

use super::{Functional, Shapes, checked};
use crate::Vector;
use crate::error::{Error, Result};
use crate::shape::Shape;
use crate::text::counted;

/// The numbers that a functional is, as a caller wants them: an `f64` of one that is one number, a [`Vector`] of one that is
/// three, a `Vec<f64>` of any.
pub trait Numbers: Sized {
    /// Them, where they are as many as this holds.
    fn from_numbers(numbers: Vec<f64>) -> Option<Self>;
}

impl Numbers for f64 {
    fn from_numbers(numbers: Vec<f64>) -> Option<Self> {
        <[f64; 1]>::from_numbers(numbers).map(|[number]| number)
    }
}

impl Numbers for Vector {
    fn from_numbers(numbers: Vec<f64>) -> Option<Self> {
        <[f64; 3]>::from_numbers(numbers).map(Self::from)
    }
}

impl Numbers for Vec<f64> {
    fn from_numbers(numbers: Self) -> Option<Self> {
        Some(numbers)
    }
}

impl<const N: usize> Numbers for [f64; N] {
    fn from_numbers(numbers: Vec<f64>) -> Option<Self> {
        numbers.try_into().ok()
    }
}

/// The value of a functional; every functional has it.
///
/// ```
/// use loftsman_kernel::functional::{Evaluate, magnitude, position};
/// use loftsman_kernel::spline::Curve;
/// use loftsman_kernel::{Point, Vector};
///
/// let line = Curve::line(Point::origin(), Point::new(3.0, 4.0, 0.0))?;
/// let speed: f64 = magnitude(0.5).evaluate(&line)?;
/// let middle: Vector = position(0.5).evaluate(&line)?;
/// assert!((speed - 5.0).abs() < 1e-14 && (middle.y - 2.0).abs() < 1e-15);
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
pub trait Evaluate: Functional + Sized {
    /// Its value of one shape. What it takes from the shape at the start of an edit (a direction to keep) it takes from this.
    ///
    /// # Errors
    /// As for [`Functional::value`]; when it is not as many numbers as are wanted, or looks at further shapes.
    fn evaluate<T: Numbers>(&self, shape: &dyn Shape) -> Result<T> {
        self.evaluate_all(&Shapes::one(shape))
    }

    /// Its value of the shapes of a problem, numbered as [`On`](super::On) has them.
    ///
    /// # Errors
    /// As for [`evaluate`](Self::evaluate).
    fn evaluate_all<T: Numbers>(&self, shapes: &Shapes<'_>) -> Result<T> {
        let bound = self.bind(shapes)?;
        let functional: &dyn Functional = match &bound {
            Some(bound) => bound.as_ref(),
            None => self,
        };
        let count = checked::equations_of(functional)?;
        let mut numbers = vec![0.0; count];
        checked::value_of(functional, shapes, &mut numbers)?;
        T::from_numbers(numbers).ok_or_else(|| {
            let what = functional.describe();
            Error::Invalid(format!(
                "{what} is {}: ask for as many, or for a Vec<f64>",
                counted(count, "number[|s]")
            ))
        })
    }
}

impl<F: Functional> Evaluate for F {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::functional::{curvature, magnitude, position, tangent};
    use crate::spline::Curve;

    #[test]
    fn a_value_is_one_call_and_says_when_it_is_other_numbers() {
        let circle = Curve::circle(Point::new(1.0, 2.0, 3.0), Vector::z(), 2.0).unwrap();
        let (start, end) = circle.domain();
        let place: Vector = position(start).evaluate(&circle).unwrap();
        assert!((place - circle.point(start).unwrap().coords).norm() < 1e-14);
        // In its plane, and across it.
        let [across, along]: [f64; 2] = curvature(0.3 * start + 0.7 * end).evaluate(&circle).unwrap();
        assert!((across.hypot(along) - 0.5).abs() < 1e-12, "{across} {along}");
        let all: Vec<f64> = position(start).evaluate(&circle).unwrap();
        assert_eq!(all, place.as_slice());
        // A direction to keep is kept.
        let kept: Vec<f64> = tangent(start).evaluate(&circle).unwrap();
        assert!(kept.iter().all(|x| x.abs() < 1e-14), "{kept:?}");
        let wrong = position(start).evaluate::<f64>(&circle).unwrap_err().to_string();
        assert!(wrong.contains("3 numbers"), "{wrong}");
        assert!(magnitude(end + 1.0).evaluate::<f64>(&circle).is_err());
        // Another shape that is not there.
        assert!(position(start).on(1).evaluate::<Vector>(&circle).is_err());
    }
}
