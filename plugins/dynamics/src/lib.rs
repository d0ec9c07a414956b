//! Ropes, laces and sheets: splines that move under constraints that slide.
//!
//! A [`Simulation`] moves shapes by their control vertices: `M q̈ = Q + Lᵀλ` with the mass matrix `M` of their basis functions, factored once
//! (Lenoir, Grisoni, Meseure, Rémion and Chaillou 2004, "Smooth constraints for spline variational modeling"). By Gauß's principle a step is a least
//! adjustment: of the free accelerations, in the mass metric. What a constraint looks at may float along its shape, so that a
//! lace slides through its holes and a knot is drawn tight; the parameters that float are unknowns of the same system, of a small mass `ε` or
//! of none ([`Scheme`]).
//!
//! Constraints ([`fixed`], [`sliding`], [`knot`], [`double_sliding`], [`tied`], or any linear functional, [`holds`]) are stabilised after Baumgarte; what they
//! miss as they come is drawn in smoothly; one whose parameter leaves its shape lets go. Their multipliers are the forces with which they
//! hold ([`Simulation::force_of`]).
//!
//! Explicit steps are leapfrogs, of second order and symplectic where nothing slides, with a bound of what is stable that is computed beforehand
//! ([`Simulation::stable_step`]); [`Scheme::Implicit`] is backward Euler, for what is stiff. [`Simulation::settle`] goes to where everything rests,
//! with corners in ropes that do not bend where they turn at what slides along them ([`Simulation::settle_without_corners`] with their knots as they are).
//!
//! ```
//! use loftsman_dynamics::{Body, Scheme, Setup, fixed, sliding};
//! use loftsman_kernel::Point;
//! use loftsman_kernel::spline::{Curve, Space};
//!
//! let points = (0..20).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
//! let rope = Curve::new(Space::clamped_uniform(3, 20)?, points)?;
//! let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(200.0))
//!     .hold(fixed(0.0))
//!     .hold(sliding(6.0))                                   // through a ring, wherever along the rope
//!     .hold(fixed(17.0).to([25.0, 0.0, 0.0]))
//!     .scheme(Scheme::Exact)
//!     .prepare()?;
//! assert!(simulation.settle()?.rests);
//! // Both sides of the ring are stretched alike.
//! let rope = simulation.shape(0)?;
//! let speeds = [rope.value(2.0.into(), 1.into())?.norm(), rope.value(15.0.into(), 1.into())?.norm()];
//! assert!((speeds[0] / speeds[1] - 1.0).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not here: contact of a shape with itself or others, friction, twist.

mod body;
mod constraint;
mod elastic;
mod error;
mod link;
mod load;
mod mass;
mod measure;
mod operation;
mod path;
mod place;
mod points;
mod scheme;
mod seam;
mod setup;
mod simulation;
mod stability;
mod stiffness;
mod strain;
mod whole;

pub use body::{Body, Material};
pub use constraint::{
    Force, Hold, Pull, Spot, double_sliding, fixed, force, holds, knot, pull, sliding, sliding_curvature,
    sliding_tangent, tied,
};
pub use error::DynamicsError;
pub use operation::Simulate;
pub use path::Path;
pub use scheme::Scheme;
pub use setup::Setup;
pub use simulation::{Audit, Corner, Energy, Event, Settled, Simulation, Unrest};

use loftsman_kernel::plugin::{Plugin, Registry};

/// The plug-in: registers the operation `simulate`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Dynamics;

impl Plugin for Dynamics {
    fn register(&self, registry: &mut Registry) {
        registry.operation(Simulate);
    }
}
