//! Linear algebra for spline equations: rows of a few neighbouring columns, perhaps around a circle.
//!
//! One engine serves interpolation and least squares, open and closed: an orthogonal factorization by Givens
//! rotations, row by row (George and Heath 1980). Interpolation is least squares with nothing left over.

mod qr;
mod stencils;

pub(crate) use qr::Qr;
pub(crate) use stencils::Stencils;
