//! Splines: the space of functions a shape is made of, and the shapes.
//!
//! * [`space`]: degree and knot vector.
//! * [`algebra`]: products, integrals and sums of spline functions.
//! * [`arc_length`]: parameters at arc lengths, many at once.
//! * [`basis`]: B-spline basis functions and their derivatives.
//! * [`batch`]: evaluation of many points at once.
//! * [`bezier`]: Bézier form, pieces and de Casteljau's algorithm.
//! * [`bounds`]: axis-parallel boxes.
//! * [`catmull_rom`]: cubic curves through their vertices.
//! * [`close`]: closed shapes made periodic.
//! * [`closest`]: the closest point of a curve or a surface.
//! * [`closing`]: where a surface closes, and where it ends in a point.
//! * [`common`]: one space for two shapes.
//! * [`compose`]: with a linear map of the parameter before it.
//! * [`conic`]: lines, circles, ellipses and arcs.
//! * [`conversion`]: the linear maps between spaces that refinement, elevation and cutting are.
//! * [`curve`]: B-spline curves, polynomial and rational, open and periodic.
//! * [`curvature`]: frames, fundamental forms and curvatures.
//! * [`elevate`]: degree elevation.
//! * [`extrude`]: extrusions and ruled surfaces.
//! * [`foot`]: the foot of a point on a surface, from a place nearby.
//! * [`form`]: what curves and surfaces are beside splines: lines, circles, cylinders and their like.
//! * [`gram`]: Gram matrices of basis functions.
//! * [`hodograph`]: the derivative as a spline.
//! * [`insert`]: knot insertion.
//! * [`isocurve`]: curves on a surface along which one parameter stands still.
//! * [`join`]: two shapes end to end.
//! * [`length`]: arc length.
//! * [`offset`]: surfaces beside surfaces.
//! * [`part`]: the part of a surface that loops bound: what is in it, and which place of it is nearest to a point.
//! * [`pieces`]: curves in the parameter plane, interpolated piece by piece.
//! * [`region`]: what loops bound in a surface's parameter plane, cell by cell.
//! * [`remove`]: knot removal.
//! * [`reverse`]: backwards, or over another domain.
//! * [`revolve`]: surfaces of revolution.
//! * [`split`]: parts of splines, opening what is periodic.
//! * [`start`]: closed curves begun elsewhere.
//! * [`surface`]: tensor-product surfaces of the same kinds.
//! * [`trimmed`]: surfaces of which loops in the parameter plane bound a part.

pub mod algebra;
pub mod arc_length;
pub mod basis;
pub mod batch;
pub mod bezier;
pub mod bounds;
pub mod catmull_rom;
mod cells;
pub mod close;
pub mod closest;
pub mod closing;
pub mod common;
pub mod compose;
pub mod conic;
pub mod conversion;
pub mod curvature;
pub mod curve;
mod edges;
pub mod elevate;
pub mod extrude;
pub mod foot;
pub mod form;
pub mod gram;
pub mod hodograph;
pub mod insert;
pub mod isocurve;
mod jet;
pub mod join;
pub mod length;
mod lift;
pub mod offset;
pub mod part;
mod piece;
pub mod pieces;
mod refine;
pub mod region;
pub mod remove;
pub mod reverse;
pub mod revolve;
pub mod split;
pub mod start;
pub mod surface;
#[cfg(test)]
pub(crate) mod testing;
pub mod trimmed;

pub(crate) use crate::quadrature::binomial;
pub use crate::space::{self, Space};
pub use arc_length::ArcLength;
pub use catmull_rom::{CatmullRom, Spacing};
pub use closing::ParameterSide;
pub use conversion::{Conversion, Direction};
pub use curve::Curve;
pub use form::{CurvePiece, SurfacePiece};
pub(crate) use gram::smoothness_of_product;
pub use lift::Lifted;
pub use region::ParameterRegion;
pub(crate) use surface::Product;
pub use surface::Surface;
pub use trimmed::Trimmed;
