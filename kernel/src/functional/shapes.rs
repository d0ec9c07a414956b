//! The shapes of a problem, with their control vertices numbered through.

use smallvec::SmallVec;

use crate::Point;
use crate::error::{Error, Result};
use crate::shape::Shape;

/// The shapes of a problem. Their control vertices are numbered through: vertex `i` of shape `s` is
/// `offset(s) + i`.
#[derive(Debug, Clone)]
pub struct Shapes<'a> {
    // A few are kept in place, so that looking at them anew at every event allocates nothing.
    shapes: SmallVec<[&'a dyn Shape; 4]>,
    offsets: SmallVec<[usize; 5]>,
}

impl<'a> Shapes<'a> {
    /// These shapes, in this order.
    pub fn new(shapes: impl IntoIterator<Item = &'a dyn Shape>) -> Self {
        let shapes: SmallVec<[_; 4]> = shapes.into_iter().collect();
        let mut offsets = SmallVec::with_capacity(shapes.len() + 1);
        let mut total = 0;
        offsets.push(0);
        for shape in &shapes {
            total += shape.control_vertices().len();
            offsets.push(total);
        }
        Self { shapes, offsets }
    }

    /// One shape.
    pub fn one(shape: &'a dyn Shape) -> Self {
        Self::new([shape])
    }

    /// How many shapes there are.
    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Shape `index`.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn get(&self, index: usize) -> Result<&'a dyn Shape> {
        self.shapes.get(index).copied().ok_or_else(|| {
            let count = self.shapes.len();
            Error::Invalid(format!(
                "there is no shape {index} in the problem: it has {count}, numbered from 0"
            ))
        })
    }

    /// Where the control vertices of shape `index` start; for `index = len()`, their total number.
    pub fn offset(&self, index: usize) -> usize {
        self.offsets[index.min(self.shapes.len())]
    }

    /// All control vertices of all shapes: their number.
    pub fn vertex_count(&self) -> usize {
        self.offset(self.shapes.len())
    }

    /// The control vertex of this number, counted through all shapes. The origin where there is none.
    pub fn vertex(&self, global: usize) -> Point {
        let shape = self.offsets.partition_point(|&o| o <= global).saturating_sub(1);
        let local = global - self.offsets.get(shape).copied().unwrap_or(0);
        let points = self.shapes.get(shape).map(|s| s.control_vertices());
        points.and_then(|p| p.get(local)).copied().unwrap_or_else(Point::origin)
    }
}
