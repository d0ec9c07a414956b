//! What a match takes from the shapes as they are when an edit starts.

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{Functional, Shapes};
use loftsman_kernel::shape::{Shape, Stencil, strips};
use loftsman_kernel::topology::EdgeCurve;

use super::Matching;
use crate::beside::{Askew, Beside, Track, edge_of};
use crate::contact::{Contact, Frame, Partials};
use crate::deviation::Deviation;
use crate::edge_on::rows;
use crate::near::Place;

/// Positions that are to be equal to rounding are looked at between with this part of the edge's size.
pub(super) const ROUNDING: f64 = 1e-9;
/// Tangent planes before and behind a place, in radians, that differ by no more are one.
pub(super) const SHARP: f64 = 1e-4;
/// A surface whose curvatures are smaller than this, divided by the edge's size, is flat to rounding.
pub(super) const FLAT: f64 = 1e-8;

/// What is fixed when an edit starts.
#[derive(Debug, PartialEq)]
pub(super) struct Bound {
    pub(super) rows: Vec<(Stencil, Point)>,
    pub(super) contacts: Vec<Contact>,
    /// Contacts with what lies before a corner of the other edge where there is one with what lies behind it, or the other way round.
    pub(super) corners: Vec<Contact>,
    pub(super) between: Vec<Place>,
    /// How the other edge's parameters go along with this one's.
    pub(super) track: Track,
    /// Whether closed edges were not begun where they are nearest to one another.
    pub(super) askew: Option<Askew>,
    /// How far the edges may be apart between the places where they meet.
    pub(super) distance: f64,
    /// What differences of curvatures are measured by: the largest curvature of the surface that stands still.
    pub(super) curvature: f64,
    /// The largest of its curvatures square to the edge; 0 where these are rounding.
    pub(super) square: f64,
    /// Whether that one is flat along the edge, so that this is rounding.
    pub(super) flat: bool,
    /// Places of the edges that are no further apart are at one another.
    pub(super) apart: f64,
    /// Whether the surface stood at less than a right angle over the other one when this was bound, and whether it lay on it.
    pub(super) folded: [bool; 2],
    /// How many times as fast as the other surface's lines across arrive at the edge those of this one leave it, where that is asked.
    pub(super) lead: Option<f64>,
}

impl Bound {
    /// Equations of a contact.
    pub(super) fn each(&self, continuity: usize) -> usize {
        continuity + usize::from(self.lead.is_some())
    }
}

impl Matching {
    pub(super) fn fail<T>(&self, problem: &str) -> Result<T> {
        Err(Error::Invalid(format!("{}: {problem}", self.describe())))
    }

    pub(super) fn fixed(&self, shapes: &Shapes<'_>) -> Result<Arc<Bound>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        let (what, limits) = (self.describe(), &self.limits);
        if self.continuity > 2 {
            return self.fail(&format!("continuity {} is not 0, 1 or 2", self.continuity));
        }
        let wrong = |x: f64| !(x > 0.0 && x.is_finite());
        if limits.distance.is_some_and(wrong) || wrong(limits.angle) || wrong(limits.curvature) {
            return self.fail("its limits are to be finite numbers above 0");
        }
        if self.on.shape == self.other.shape {
            return self.fail("a surface cannot be matched to itself: it would have to stand still");
        }
        let other = shapes.get(self.other.shape)?;
        let there = edge_of(shapes, &self.other, self.other_edge, &what)?;
        if there.spread() == 0.0 {
            return self.fail("the edge beside is a point (a pole), which runs along nothing");
        }
        let edge = edge_of(shapes, &self.on, self.edge, &what)?;
        let size = edge.spread().max(there.spread());
        let beside = match self.begun {
            Some(begun) => Beside::begun(edge, &there.curve, begun)?,
            None => Beside::new(edge, &there.curve, limits.distance.is_none() || !self.free)?,
        };
        let (rows, exact) = rows(&beside, shapes, &self.on, limits.distance, &what)?;
        let step = self.step(shapes)?;
        let contact = |t: f64| -> Result<Contact> {
            Ok(Contact {
                at: beside.at(t),
                by: Partials::new(&beside.edge.edge),
                at_end: beside.edge.edge.at_end,
                step,
                frame: Frame::new(other, &there.edge, beside.there(t))?,
            })
        };
        let contacts = if self.continuity > 0 {
            beside.greville().into_iter().map(contact).collect::<Result<_>>()?
        } else {
            Vec::new()
        };
        let corners = self.corners(&beside, &contacts, &contact)?;
        let between = self.between(&beside, exact && self.continuity == 0, &there, &contact)?;
        let curvature = between.iter().fold(0.0, |m: f64, place| m.max(place.contact.frame.largest));
        let square = between.iter().fold(0.0, |m: f64, place| m.max(place.contact.frame.curvature.abs()));
        let rounding = FLAT / size;
        let square = if square > rounding { square } else { 0.0 };
        let (curvature, flat) = (curvature.max(rounding), curvature <= rounding);
        let distance = limits.distance.unwrap_or(ROUNDING * size);
        let apart = ROUNDING * size;
        let mut bound = Bound {
            rows,
            contacts,
            corners,
            between,
            track: beside.track(),
            askew: beside.askew(),
            distance,
            curvature,
            square,
            flat,
            apart,
            folded: [false; 2],
            lead: None,
        };
        if self.led {
            bound.lead = lead(shapes.get(self.on.shape)?, &bound.contacts)?;
        }
        if self.continuity > 0 {
            let profile = self.deviations(shapes, &bound)?;
            bound.folded = [Deviation::folded(&profile), Deviation::lies_on(&profile, limits)];
        }
        Ok(Arc::new(bound))
    }

    /// Where the other surface has another tangent plane before a place of contact than behind it, as at a corner of its edge, the surface that moves has to lie
    /// in both: it can, along the line in which they meet, where its own edge has a corner, too.
    pub(super) fn corners(
        &self,
        beside: &Beside,
        contacts: &[Contact],
        contact: &dyn Fn(f64) -> Result<Contact>,
    ) -> Result<Vec<Contact>> {
        let mut corners = Vec::new();
        if contacts.is_empty() {
            return Ok(corners);
        }
        for (k, sides) in beside.knots_met() {
            // Which of them the place itself shows is a matter of rounding.
            for side in sides {
                let (at, here) = (contact(side)?, &contacts[k]);
                if at.frame.normal.cross(&here.frame.normal).norm() > SHARP {
                    corners.push(Contact { at: here.at, ..at });
                }
            }
        }
        Ok(corners)
    }

    /// The parameter step by which derivatives across are made lengths.
    pub(super) fn step(&self, shapes: &Shapes<'_>) -> Result<f64> {
        let shape = shapes.get(self.on.shape)?;
        let largest =
            strips(shape, self.edge.number_on(shape)?, 1)?.get(1).map_or(0.0, |strip| strip.largest);
        let step = 1.0 / largest;
        if step > 0.0 && step.is_finite() {
            return Ok(step);
        }
        self.fail("the surface is too short across the edge: choose a longer domain")
    }

    pub(super) fn between(
        &self,
        beside: &Beside,
        exact: bool,
        there: &EdgeCurve,
        contact: &dyn Fn(f64) -> Result<Contact>,
    ) -> Result<Vec<Place>> {
        let mut all = Vec::new();
        for t in beside.between(exact) {
            let u = beside.there(t);
            let point = there.curve.point(u)?;
            match contact(t) {
                Ok(contact) => all.push(Place { t, point, u, contact }),
                // Of position alone, a pole somewhere matters not.
                Err(_) if self.continuity == 0 => {}
                Err(error) => return Err(error),
            }
        }
        Ok(all)
    }
}

/// By what factor the lines across of a surface leave its edge faster than those of the other one arrive there, in the mean; `None` where one of them does not.
pub(super) fn lead(shape: &dyn Shape, contacts: &[Contact]) -> Result<Option<f64>> {
    let (mut own, mut other) = (0.0, 0.0);
    for contact in contacts {
        own += contact.across(shape)?;
        other += contact.lead().1;
    }
    let lead: f64 = own / other;
    Ok(Some(lead).filter(|lead| *lead > 0.0 && lead.is_finite()))
}
