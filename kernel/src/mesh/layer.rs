//! What belongs to a mesh's points or corners: normals, texture coordinates, colours.

use crate::error::{Error, Result};

/// The index of a corner that has no value.
pub const NONE: u32 = u32::MAX;

/// Values for a mesh's points, or for its corners where they differ by face.
///
/// Per corner they are kept as formats like OBJ keep them: a list of values, and for each corner of the mesh an
/// index into it, so that what faces share is held once.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer<T> {
    values: Vec<T>,
    corners: Option<Vec<u32>>,
}

impl<T> Default for Layer<T> {
    fn default() -> Self {
        Self::none()
    }
}

impl<T> Layer<T> {
    /// A layer that holds nothing.
    pub fn none() -> Self {
        Self { values: Vec::new(), corners: None }
    }

    /// Value `i` belongs to point `i`.
    pub fn per_point(values: Vec<T>) -> Self {
        Self { values, corners: None }
    }

    /// Corner `c` (of [`Mesh::corners`](super::Mesh::corners)) has `values[corners[c]]`, or nothing where that is
    /// [`NONE`].
    pub fn per_corner(values: Vec<T>, corners: Vec<u32>) -> Self {
        Self { values, corners: Some(corners) }
    }

    /// Whether there is nothing here.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values, in their order.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The values, to be changed.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The index of each corner's value; `None` where values belong to points.
    pub fn corners(&self) -> Option<&[u32]> {
        self.corners.as_deref()
    }

    /// The values and the corners' indices.
    pub fn into_parts(self) -> (Vec<T>, Option<Vec<u32>>) {
        (self.values, self.corners)
    }

    /// The index of the value at a corner, which lies at a point; [`NONE`] where there is none.
    pub fn index(&self, corner: usize, point: u32) -> u32 {
        match &self.corners {
            Some(corners) => corners.get(corner).copied().unwrap_or(NONE),
            None if self.values.is_empty() => NONE,
            None => point,
        }
    }

    /// The value at a corner, which lies at a point.
    pub fn at(&self, corner: usize, point: u32) -> Option<&T> {
        self.values.get(self.index(corner, point) as usize)
    }

    /// The same layer with other values.
    pub fn map<U>(&self, value: impl FnMut(&T) -> U) -> Layer<U> {
        Layer { values: self.values.iter().map(value).collect(), corners: self.corners.clone() }
    }

    /// Checks that the layer fits a mesh of so many points and corners.
    ///
    /// # Errors
    /// When the number of values or indices does not fit, or an index does not exist; `what` names the layer.
    pub fn check(&self, what: &str, points: usize, corners: usize) -> Result<()> {
        let Some(indices) = &self.corners else {
            let found = self.values.len();
            return if found == 0 || found == points {
                Ok(())
            } else {
                Err(Error::Invalid(format!(
                    "{found} {what} for {points} points: there must be one a point, or none"
                )))
            };
        };
        if indices.len() != corners {
            return Err(Error::Invalid(format!(
                "{} indices of {what} for {corners} corners: there must be one a corner",
                indices.len()
            )));
        }
        let known = self.values.len();
        match indices.iter().enumerate().find(|&(_, &i)| i != NONE && i as usize >= known) {
            Some((corner, index)) => Err(Error::Invalid(format!(
                "corner {corner} refers to entry {index} of the {what}, but there are only {known}"
            ))),
            None => Ok(()),
        }
    }

    /// Puts the corners' indices in another order: corner `c` gets what corner `order(c)` had.
    pub(super) fn reorder(&mut self, order: impl Fn(usize) -> usize) {
        if let Some(corners) = &mut self.corners {
            *corners = (0..corners.len()).map(|c| corners[order(c)]).collect();
        }
    }
}
