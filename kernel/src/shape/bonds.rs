//! What holds a shape of several pieces together while some of them move.

use super::{Shape, Stencil};
use crate::error::Result;

/// Linear rows over a shape's control vertices whose values an edit keeps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bond {
    /// What they keep, for people: `edge 4 of faces 0 and 2`.
    pub name: String,
    /// The rows, alike in x, y and z.
    pub rows: Vec<Stencil>,
}

/// What a shape can say that consists of pieces which meet: which control vertices stand still, which rows keep the pieces together, and
/// (by [`Shape::follow`]) where what lies between them goes.
///
/// Before an edit such a shape is made *ready*: the pieces that may move are given control vertices enough, where they lack them, and what
/// holds them is prepared once. All editors take it from here, so that none of them needs to know what the pieces are.
pub trait Bonds {
    /// Whether it is ready: then the rest of this trait speaks of the edit to come.
    fn is_ready(&self) -> bool;

    /// The same shape ready to be moved at these places (a face and its parameters each), each of which should be able to move freely.
    /// Parameters stay what they are; control vertices may get other numbers.
    ///
    /// # Errors
    /// When a place is none, or can have no freedom of its own, in words that say what to do.
    fn ready(&self, places: &[(u32, [f64; 2])]) -> Result<Box<dyn Shape>>;

    /// The control vertices that no edit moves by itself, ascending: those of pieces that stand still, and those that follow.
    fn held(&self) -> &[usize];

    /// What keeps the pieces together.
    fn bonds(&self) -> &[Bond];
}
