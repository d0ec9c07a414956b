//! A state of a search, and which of two is the better one.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

use crate::constraint::Holding;
use crate::error::Result;

/// A state on the way: a curve's vertices (local), its space, the points' parameters and distances.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) space: Space,
    pub(crate) vertices: Vec<f64>,
    pub(crate) sites: Vec<f64>,
    pub(crate) distances: Vec<f64>,
    pub(crate) condition: f64,
    pub(crate) held: Holding,
    /// Its length, or (where that is no longer than the polygon of the points) a bound of it from above.
    pub(crate) length: f64,
    /// Whether it goes where the points go.
    pub(crate) sound: bool,
    /// Whether it is sound and the tolerance holds.
    pub(crate) met: bool,
    pub(crate) interpolated: bool,
    /// What was done that nobody asked for.
    pub(crate) remarks: Vec<String>,
}

impl State {
    pub(crate) fn error(&self) -> f64 {
        self.distances.iter().fold(0.0, |m, d| m.max(*d))
    }

    /// The curve, in local coordinates.
    pub(crate) fn curve(&self) -> Result<Curve> {
        let vertices = self.vertices.chunks_exact(3).map(|v| Point::new(v[0], v[1], v[2])).collect();
        Ok(Curve::new(self.space.clone(), vertices)?)
    }
}

/// The one that meets the goal, or is sound at least; of two alike the later one, or the nearer where neither meets it.
pub(crate) fn better(best: Option<State>, state: State) -> State {
    let rank = |s: &State| (s.met, s.sound);
    match best {
        Some(best) if rank(&best) > rank(&state) => best,
        Some(best) if rank(&best) == rank(&state) && !state.met && best.error() < state.error() => best,
        _ => state,
    }
}
