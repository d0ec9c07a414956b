//! How the events of a session are solved.

use super::border::Border;
use crate::problem::program::Bounds;

/// How events are solved: decided when a session is prepared. (Whether only a best effort is asked for is the problem's; that axes
/// alternate, a handle slides or locations float is the session's, around whichever of these it is.)
pub(super) enum Strategy {
    /// All is linear: one solve with what was factored at mouse down (`event.rs`).
    Linear,
    /// All is linear, with inequalities: which of them are active is found at every event (`bounded.rs`).
    Bounded(Box<Bounds>),
    /// Few constraints are not linear, beside those that are, which are factored at mouse down (`curved.rs`, `border.rs`).
    Bordered(Box<Border>),
    /// Everything is linearized where the shapes are, again and again (`sequential.rs`); the rows of the last time, where some were
    /// inequalities.
    Sequential(Option<Box<Bounds>>),
}

impl Strategy {
    /// The constraints that are not linear, where they are not in the system but beside it.
    pub(super) fn border(&self) -> Option<&Border> {
        if let Self::Bordered(border) = self { Some(border) } else { None }
    }

    /// The same, to work with.
    pub(super) fn border_mut(&mut self) -> Option<&mut Border> {
        if let Self::Bordered(border) = self { Some(border) } else { None }
    }

    /// All rows, where some are inequalities: the system holds the others and the active ones.
    pub(super) fn bounds(&self) -> Option<&Bounds> {
        match self {
            Self::Bounded(bounds) | Self::Sequential(Some(bounds)) => Some(bounds),
            _ => None,
        }
    }
}
