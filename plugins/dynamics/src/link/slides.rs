//! Where its places are, and how those that float move along their shapes.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::shape::Location;
use nalgebra::Matrix3;
use smallvec::SmallVec;

use super::{LEFT, Link, Phase};
use crate::constraint::Place;

/// Locations of a constraint's places.
pub(crate) type Places = SmallVec<[Location; 2]>;

impl Link {
    /// Whether a parameter has turned round.
    pub(crate) fn has_turned(&self) -> bool {
        self.turns.iter().any(|(_, turns)| *turns > 0)
    }

    /// Its places, those that float moved by lengths along their shapes as far as these go, one for each of its parameters in turn; and whether
    /// one would leave its shape.
    pub(crate) fn moved(&self, by: impl Fn(usize) -> f64) -> (Places, bool) {
        let (mut own, mut left) = (0, false);
        let mut along = |at: f64| {
            let Some(slide) = self.slides.get(own) else { return at };
            let (to, leaves) = slide.moved(at, by(own));
            (own, left) = (own + 1, left | leaves);
            to
        };
        let places = self.places.iter().map(|place| match place.location {
            location if !place.floats => location,
            Location::Curve(u) => Location::Curve(along(u)),
            Location::Surface(u, v) => Location::Surface(along(u), along(v)),
            Location::Face(face, u, v) => Location::Face(face, along(u), along(v)),
            Location::Vertex(vertex) => Location::Vertex(vertex),
        });
        let places = places.collect();
        (places, left)
    }

    /// A step of Newton's iteration begins. Where it `remembers`, with what it learnt in the step before but the last turn.
    pub(crate) fn begin_turns(&mut self, remembers: bool) {
        let kept = |turns: usize| if remembers { turns.saturating_sub(1) } else { 0 };
        self.turns.iter_mut().for_each(|(last, turns)| (*last, *turns) = (0.0, kept(*turns)));
    }

    /// Remembers which way its parameters went.
    pub(crate) fn turn(&mut self, by: &[f64]) {
        for ((last, turns), by) in self.turns.iter_mut().zip(by) {
            *turns += usize::from(*last * by < 0.0 && by.abs() > 0.2 * last.abs());
            *last = *by;
        }
    }

    /// Moves its parameters by lengths along the shape; switches it off where one leaves its shape.
    pub(crate) fn slide(&mut self, by: &[f64], time: f64) {
        let (places, left) = self.moved(|own| by[own]);
        if left {
            self.leave(time);
        }
        self.put(&places);
    }

    /// It has left its shape, and holds no more.
    pub(crate) fn leave(&mut self, time: f64) {
        self.phase = Phase::Off { time, why: LEFT };
    }

    /// Of one that holds by three equations what slides by three parameters, as a curve on a surface where both places float: the sine of the angle between
    /// the curve and the surface, `|det L_s|` of columns of unit length. Where it is none, nothing tells where they meet.
    pub(crate) fn crossing(&self, changes: &[(usize, usize, f64)]) -> Option<f64> {
        let parameter = changes.first()?.1;
        if self.slides.len() != 3 || self.equations != 3 {
            return None;
        }
        let mut matrix = Matrix3::<f64>::zeros();
        for &(equation, at, by) in changes {
            *matrix.get_mut((equation - self.first, at - parameter))? += by;
        }
        // The surface's own parameters may be oblique: its normal counts.
        let [a, b, c]: [Vector; 3] = [0, 1, 2].map(|k| matrix.column(k).normalize());
        let volume = a.dot(&b.cross(&c)).abs();
        // The surface's are those of the place that has two.
        let curve_first = self.places.iter().find(|place| place.floats)?.location.parameters() == 1;
        let area = if curve_first { b.cross(&c) } else { a.cross(&b) }.norm();
        Some(volume / area).filter(|sine| sine.is_finite())
    }

    /// The highest derivative that is held at one of its places; the point itself is of order 0.
    pub(crate) fn order_at(&self, place: usize) -> usize {
        let terms = self.parts.iter().flat_map(|part| &part.terms).filter(|term| term.place == Some(place));
        terms.filter_map(|term| term.order).max().unwrap_or(0)
    }

    /// Two places of one curve that have come together: a loop drawn shut. Of degree 1 or 2 there is none within one span: it would have no length, or lie
    /// upon itself.
    pub(crate) fn is_shut(&self, length: f64) -> bool {
        let [
            Place { body: a, location: Location::Curve(u), floats },
            Place { body: b, location: Location::Curve(w), floats: other },
        ] = &self.places[..]
        else {
            return false;
        };
        let Some(slide) = self.slides.first().filter(|_| a == b && (*floats || *other)) else { return false };
        let whole = slide.interval.end - slide.interval.start;
        let apart = (u - w).abs();
        let apart = if slide.interval.periodic { apart.min(whole - apart) } else { apart };
        let (low, high) = (u.min(*w), u.max(*w));
        // Round the seam the lower one is behind the end.
        let beyond = if slide.interval.periodic { low + whole } else { f64::NAN };
        let within =
            |low: f64, high: f64| self.spans.windows(2).any(|span| span[0] <= low && high <= span[1]);
        apart < length * slide.pace || within(low, high) || within(high, beyond)
    }

    /// Puts its places back.
    pub(crate) fn put(&mut self, locations: &[Location]) {
        for (index, location) in locations.iter().enumerate() {
            if !self.places[index].floats {
                continue;
            }
            self.places[index].location = *location;
            for term in self.parts.iter_mut().flat_map(|part| &mut part.terms) {
                if term.place == Some(index)
                    && let Some(functional) = Arc::get_mut(&mut term.functional)
                {
                    functional.slide(*location);
                }
            }
        }
    }

    /// Where it is.
    pub(crate) fn locations(&self) -> impl Iterator<Item = Location> + '_ {
        self.places.iter().map(|place| place.location)
    }
}
