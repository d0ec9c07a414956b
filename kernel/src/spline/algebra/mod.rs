//! B-spline algebra: products, integrals, derivatives and sums of spline functions as spline functions, exactly.
//!
//! * [`Function`]: a spline function of one parameter with numbers or vectors as values; [`Field`]: of two parameters.
//! * [`Product`]: how splines of two spaces are multiplied.
//! * [`Space::integrals`](crate::spline::Space::integrals), [`Space::inner_products`](crate::spline::Space::inner_products).

mod bernstein;
mod field;
mod function;
mod inner;
mod product;
#[cfg(test)]
mod tests;
mod times;

use std::fmt::Debug;
use std::ops::{Add, Mul, Sub};

use nalgebra::SVector;

pub use field::Field;
pub use function::Function;
pub use product::Product;

/// What a coefficient of a spline function can be: a number, or a vector of some.
pub trait Coefficient:
    Copy + PartialEq + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
    /// Zero.
    fn zero() -> Self;

    /// Its largest number, without sign.
    fn size(&self) -> f64;

    /// Whether all of its numbers are finite.
    fn is_finite(&self) -> bool;
}

impl Coefficient for f64 {
    fn zero() -> Self {
        0.0
    }

    fn size(&self) -> f64 {
        self.abs()
    }

    fn is_finite(&self) -> bool {
        f64::is_finite(*self)
    }
}

impl<const L: usize> Coefficient for SVector<f64, L> {
    fn zero() -> Self {
        Self::zeros()
    }

    fn size(&self) -> f64 {
        self.amax()
    }

    fn is_finite(&self) -> bool {
        self.iter().all(|c| c.is_finite())
    }
}
