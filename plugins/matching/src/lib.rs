//! Surfaces that meet what stands beside them along a whole edge, whatever the parametrisations:
//!
//! * [`edge_on`], in recipes the constraint `edge`: an edge kept on a curve;
//! * [`matching`], in recipes the constraint `match`: an edge kept on the edge of another surface, with the same tangent planes
//!   (G¹) and the same curvature across (G²). Unlike a [join](loftsman_kernel::functional::Join) it asks for no equal derivatives,
//!   and the other surface stands still;
//! * [`MatchOperation`], the operation `match`: the same for one surface, with knots inserted along the edge until it
//!   holds within tolerances, and the deviation in position, angle and curvature reported.
//!
//! ```
//! use loftsman_kernel::edit::{Ask, Edit};
//! use loftsman_kernel::functional::{Edge, Shapes};
//! use loftsman_kernel::spline::{Space, Surface};
//! use loftsman_kernel::Point;
//! use loftsman_matching::{Limits, matching};
//!
//! // A roof that rises to x = 1, and a flat sheet beyond it.
//! let space = |n| Space::clamped_uniform(3, n);
//! let at = |k: usize| (k / 5, k % 5);
//! let roof = (0..25).map(|k| Point::new(at(k).0 as f64 / 4.0, at(k).1 as f64, at(k).0 as f64 / 4.0)).collect();
//! let roof = Surface::new(space(5)?, space(5)?, roof)?;
//! let flat = (0..25).map(|k| Point::new(1.1 + at(k).0 as f64, at(k).1 as f64, 0.8)).collect();
//! let flat = Surface::new(space(5)?, space(5)?, flat)?;
//! let smooth = matching(Edge::UStart, 1, Edge::UEnd, 1, Limits::default());
//! let edited = Edit::new(&flat)
//!     .with(Box::new(roof.clone()))
//!     .ask(smooth.clone().hold())
//!     .solve()?;
//! let apart = smooth.deviation(&Shapes::new([edited.shape() as &dyn loftsman_kernel::shape::Shape, &roof]))?;
//! assert!(apart.distance < 1e-12 && apart.angle < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! An edge on a curve:
//!
//! ```
//! use loftsman_kernel::edit::{Ask, Edit};
//! use loftsman_kernel::functional::Edge;
//! use loftsman_kernel::spline::{Curve, Space, Surface};
//! use loftsman_kernel::Point;
//! use loftsman_matching::edge_on;
//!
//! let space = Space::clamped_uniform(3, 5)?;
//! let points = (0..25).map(|k| Point::new((k / 5) as f64, (k % 5) as f64, 0.0)).collect();
//! let sheet = Surface::new(space.clone(), space.clone(), points)?;
//! let rail = Curve::new(space, (0..5).map(|k| Point::new(4.0, k as f64, (k % 2) as f64)).collect())?;
//! let edited = Edit::new(&sheet).with(Box::new(rail.clone())).ask(edge_on(Edge::UEnd, 1).hold()).solve()?;
//! assert!((edited.shape().point(2.0, 0.3)? - rail.point(0.3)?).norm() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod along;
mod beside;
mod contact;
mod deviation;
mod edge_on;
mod fields;
mod foot;
mod history;
mod matching;
mod near;
mod operation;

use loftsman_kernel::plugin::{Plugin, Registry};

pub use deviation::{Deviation, Limits};
pub use edge_on::{EdgeOn, edge_on};
pub use matching::{Matching, matching};
pub use operation::MatchOperation;

/// Registers the constraints `edge` and `match`, and the operation `match`.
#[derive(Debug, Clone, Copy, Default)]
pub struct MatchingPlugin;

impl Plugin for MatchingPlugin {
    fn register(&self, registry: &mut Registry) {
        registry.functional::<EdgeOn>();
        registry.functional::<Matching>();
        registry.operation(MatchOperation);
    }
}
