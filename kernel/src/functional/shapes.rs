//! The shapes of a problem, with their control vertices numbered through.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::shape::{Derivative, Location, Shape, Sides, Stencil};
use crate::{Point, Vector};

/// The shapes of a problem. Their control vertices are numbered through: vertex `i` of shape `s` is
/// `offset(s) + i`.
#[derive(Debug, Clone)]
pub struct Shapes<'a> {
    count: usize,
    // A few are kept in place, so that looking at them anew at every event allocates nothing.
    few: [Option<&'a dyn Shape>; FEW],
    starts: [usize; FEW + 1],
    many: Vec<&'a dyn Shape>,
    offsets: Vec<usize>,
}

/// So many shapes are kept in place.
const FEW: usize = 4;

impl<'a> Shapes<'a> {
    /// These shapes, in this order.
    pub fn new(shapes: impl IntoIterator<Item = &'a dyn Shape>) -> Self {
        let mut all = Self::none();
        let mut total = 0;
        for shape in shapes {
            if all.count == FEW {
                all.many = all.few.into_iter().flatten().collect();
                all.offsets = all.starts.to_vec();
            }
            total += shape.control_vertices().len();
            if all.count < FEW {
                all.few[all.count] = Some(shape);
                all.starts[all.count + 1] = total;
            } else {
                all.many.push(shape);
                all.offsets.push(total);
            }
            all.count += 1;
        }
        all
    }

    fn none() -> Self {
        Self { count: 0, few: [None; FEW], starts: [0; FEW + 1], many: Vec::new(), offsets: Vec::new() }
    }

    /// Where each shape's vertices start, and the number of all.
    fn offsets(&self) -> &[usize] {
        if self.count <= FEW { &self.starts[..=self.count] } else { &self.offsets }
    }

    fn find(&self, index: usize) -> Option<&'a dyn Shape> {
        if self.count <= FEW { self.few.get(index).copied().flatten() } else { self.many.get(index).copied() }
    }

    /// One shape.
    pub fn one(shape: &'a dyn Shape) -> Self {
        let (mut all, count) = (Self::none(), shape.control_vertices().len());
        (all.count, all.few[0], all.starts[1]) = (1, Some(shape), count);
        all
    }

    /// How many shapes there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Shape `index`.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn get(&self, index: usize) -> Result<&'a dyn Shape> {
        self.find(index).ok_or_else(|| {
            let count = self.count;
            Error::Invalid(format!(
                "there is no shape {index} in the problem: it has {count}, numbered from 0"
            ))
        })
    }

    /// The stencil of a derivative of shape `index` at a location, checked: whoever made the shape is told where it names a
    /// control vertex that is not there, or gives it a coefficient that is no number. `O(p)`.
    ///
    /// # Errors
    /// As for [`get`](Self::get) and [`Shape::stencil`]; where the stencil is wrong, naming the shape's type.
    pub fn stencil(&self, index: usize, at: Location, derivative: Derivative) -> Result<Stencil> {
        let shape = self.get(index)?;
        checked(index, shape, at, shape.stencil(at, derivative))
    }

    /// The value of a derivative of shape `index` at a location, by its [stencil](Self::stencil).
    ///
    /// # Errors
    /// As for [`stencil`](Self::stencil).
    pub fn value(&self, index: usize, at: Location, derivative: Derivative) -> Result<Vector> {
        let shape = self.get(index)?;
        let stencil = checked(index, shape, at, shape.stencil(at, derivative));
        stencil.map(|stencil| stencil.apply(shape.control_vertices()))
    }

    /// The same from a side of each parameter, where that is a knot at which they differ.
    ///
    /// # Errors
    /// As for [`stencil`](Self::stencil).
    pub fn stencil_on(
        &self,
        index: usize,
        at: Location,
        derivative: Derivative,
        sides: Sides,
    ) -> Result<Stencil> {
        let shape = self.get(index)?;
        checked(index, shape, at, shape.stencil_on(at, derivative, sides))
    }

    /// Where the control vertices of shape `index` start; for `index = len()`, their total number.
    pub fn offset(&self, index: usize) -> usize {
        self.offsets()[index.min(self.count)]
    }

    /// The numbers of the control vertices of shape `index`; `None` where there is no such shape.
    pub(crate) fn range(&self, index: usize) -> Option<Range<usize>> {
        (index < self.count).then(|| self.offset(index)..self.offset(index + 1))
    }

    /// All control vertices of all shapes: their number.
    pub fn vertex_count(&self) -> usize {
        self.offset(self.count)
    }

    /// The control vertex of this number, counted through all shapes. The origin where there is none.
    pub fn vertex(&self, global: usize) -> Point {
        if let (1, Some(shape)) = (self.count, self.few[0]) {
            return shape.control_vertices().get(global).copied().unwrap_or_else(Point::origin);
        }
        let offsets = self.offsets();
        let shape = offsets.partition_point(|&o| o <= global).saturating_sub(1);
        let local = global - offsets.get(shape).copied().unwrap_or(0);
        let points = self.find(shape).map(|s| s.control_vertices());
        points.and_then(|p| p.get(local)).copied().unwrap_or_else(Point::origin)
    }
}

/// A stencil as it came from a shape, or what is wrong with it. (The result itself is handed on: moving a stencil costs as much
/// as looking at it.)
#[inline]
fn checked(index: usize, shape: &dyn Shape, at: Location, found: Result<Stencil>) -> Result<Stencil> {
    let mut found = found;
    let count = shape.control_vertices().len();
    let wrong = |stencil: &Stencil| {
        // Zero times what is not finite is NaN; the last vertex is the largest.
        let sum = stencil.coefficients().iter().fold(0.0, |sum, c| sum + c * 0.0);
        sum != 0.0 || stencil.vertices().last().is_some_and(|&vertex| vertex >= count)
    };
    if found.as_ref().is_ok_and(wrong) {
        found = found.and_then(|stencil| flaw(index, shape, at, &stencil).map_or(Ok(stencil), Err));
    }
    found
}

/// What is wrong with a stencil.
#[cold]
fn flaw(index: usize, shape: &dyn Shape, at: Location, stencil: &Stencil) -> Option<Error> {
    let count = shape.control_vertices().len();
    let (vertex, c) = stencil.iter().find(|&(vertex, c)| vertex >= count || !c.is_finite())?;
    Some(Error::Invalid(format!(
        "shape {index} ({}) is made of {c} times control vertex {vertex} at {at}, but it has {count} of them, and \
         coefficients are finite: its stencil is wrong",
        shape.type_name()
    )))
}
