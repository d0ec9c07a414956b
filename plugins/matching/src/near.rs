//! How far two edges are from one another at a place, and how the surfaces lie there: by the places that are nearest, not by parameters.

use loftsman_kernel::error::Result;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{BoundaryEdge, Derivative, Shape};
use loftsman_kernel::topology::EdgeCurve;
use loftsman_kernel::{Point, Vector};

use crate::contact::{Contact, Frame, Measured};
use crate::foot::Foot;

/// A place between those where anything is imposed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Place {
    /// Where on both edges, by the first one's parameter.
    pub(crate) t: f64,
    pub(crate) point: Point,
    /// The other edge's own parameter there.
    pub(crate) u: f64,
    pub(crate) contact: Contact,
}

/// Both edges as they are, for the places of them that are nearest to one another.
pub(crate) struct Near<'a> {
    other: &'a dyn Shape,
    there: Foot,
    /// The shape that moves.
    on: usize,
    own: Foot,
    /// The edge that stands still, for its places.
    edge: BoundaryEdge,
    /// Places of the edges that are no further apart are at one another.
    apart: f64,
}

/// What lies where.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    /// From the edge that stands still to the one that moves: of the ways from a place of each to the nearest one of the other, the longer.
    pub(crate) apart: Vector,
    pub(crate) measured: Measured,
}

impl<'a> Near<'a> {
    /// Of the edge `there` of the surface `other`, and of shape `on`'s edge `own`.
    ///
    /// # Errors
    /// When numbers overflow.
    pub(crate) fn new(
        other: &'a dyn Shape,
        there: EdgeCurve,
        on: usize,
        own: EdgeCurve,
        apart: f64,
    ) -> Result<Self> {
        let edge = there.edge;
        Ok(Self { other, there: Foot::new(there.curve)?, on, own: Foot::new(own.curve)?, edge, apart })
    }

    /// How far the edges are apart at a place of both: the place of each that is nearest to that of the other (a descent from there: no
    /// nearer one is beside it), and how the surface lies to the other one where that is.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn measure(&self, shapes: &Shapes<'_>, place: &Place) -> Result<Found> {
        let shape = shapes.get(self.on)?;
        let at = Point::from(shape.value(place.contact.at, Derivative::POSITION)?);
        let apart = at - place.point;
        if apart.norm() <= self.apart {
            return Ok(Found { apart, measured: place.contact.measure(shape)? });
        }
        let (u, here) = self.there.of(place.u, &at)?;
        let (_, back) = self.own.of(place.t, &place.point)?;
        let apart = if back.norm() > here.norm() { back } else { -here };
        let measured = match Frame::new(self.other, &self.edge, u) {
            Ok(frame) => place.contact.beside(frame).measure(shape)?,
            // A pole that is nearer tells nothing.
            Err(_) => place.contact.measure(shape)?,
        };
        Ok(Found { apart, measured })
    }
}
