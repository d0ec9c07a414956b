//! Where its places are, and how those that float move along their shapes.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Derivative, Interval, Location, Shape, cells_of};
use nalgebra::Matrix3;
use smallvec::SmallVec;

use super::{LEFT, Link, Phase};
use crate::constraint::Place;
use crate::error::Result;

/// What goes on from a corner starts so far beside it, as a share of its shape's parameters.
pub(crate) const BESIDE: f64 = 1e-10;

/// The knots of a shape along a parameter where the derivative of this order is no more than continuous, if that (the point itself is of order 0), ascending. None
/// where its splines are not known.
fn sharp_knots(shape: &dyn Shape, axis: usize, order: usize) -> Vec<f64> {
    let splines = cells_of(shape, "a place that slides").ok().and_then(|cells| cells.splines());
    let Some(space) = splines.and_then(|splines| if axis == 0 { Some(splines.u) } else { splines.v }) else {
        return Vec::new();
    };
    let (start, end) = space.domain();
    let inside = |u: f64| u < end && (space.is_periodic() || u > start);
    let all = space.breakpoints().into_iter();
    all.filter(|u| inside(*u) && space.multiplicity(*u) + order >= space.degree()).collect()
}

/// Whether a curve whose ends are kept together arrives there otherwise than it sets out: in another direction, or not as fast in its parameter.
fn jumps(shape: &dyn Shape, ends: Interval) -> bool {
    let way = |at: f64| shape.value(Location::Curve(at), Derivative::from(1));
    let (Ok(first), Ok(last)) = (way(ends.start), way(ends.end)) else { return true };
    (first - last).norm() > 1e-9 * first.norm().max(last.norm())
}

/// What turned round so often across a corner stands on it.
const OFTEN: usize = 3;

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

    /// One of its parameters that has turned round often enough, over a corner that is no farther than it went last, stands on that. Whether it does so now.
    pub(crate) fn stand_where_it_turns(&mut self, own: usize) -> bool {
        let (last, turns) = self.turns[own];
        let Some(at) = self.parameters().get(own).copied().filter(|_| turns >= OFTEN && !self.stands[own])
        else {
            return false;
        };
        let corner = if self.is_on_corner(own, at) {
            Some((at, 0.0))
        } else {
            let sides = [true, false].map(|forward| self.next_corner(own, at, forward));
            sides.into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let Some((corner, _)) = corner.filter(|(_, way)| *way <= last.abs()) else { return false };
        self.put_at(own, corner, 0.0);
        (self.stands[own], self.rates[own]) = (true, 0.0);
        true
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
        terms.map(|term| term.order).max().unwrap_or(0)
    }

    /// Two places of one shape that have come together: a loop drawn shut. On a curve of degree 1 or 2 there is none within one span: it would have no
    /// length, or lie upon itself.
    pub(crate) fn is_shut(&self, length: f64) -> bool {
        if let [
            Place { body: a, location: Location::Surface(u, v), floats },
            Place { body: b, location: Location::Surface(s, t), floats: other },
        ] = &self.places[..]
        {
            if a != b || !(*floats || *other) {
                return false;
            }
            // The way from one to the other as the parameters go, in lengths.
            let along = |axis: usize, apart: f64| {
                let both = [axis, axis + 2].into_iter().filter_map(|own| self.slides.get(own));
                let pace = both.map(|slide| slide.pace).fold(0.0, f64::max);
                let whole = self.slides.get(axis).map(|slide| slide.interval);
                let round = whole.filter(|whole| whole.periodic).map(|whole| whole.end - whole.start - apart);
                round.map_or(apart, |round| apart.min(round)) / pace
            };
            return along(0, (u - s).abs()).hypot(along(1, (v - t).abs())) < length;
        }
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

    /// Which share of a way its two places on one curve can go until they meet, its parameters by these lengths; `None` where they do not.
    pub(crate) fn meets(&self, by: &[f64]) -> Option<f64> {
        let [
            Place { body: a, location: Location::Curve(u), floats },
            Place { body: b, location: Location::Curve(w), floats: other },
        ] = &self.places[..]
        else {
            return None;
        };
        let slide = self.slides.first().filter(|_| a == b)?;
        let mut ways = by.iter().zip(&self.slides).map(|(way, slide)| way * slide.pace);
        let mut next = |floats: bool| if floats { ways.next().unwrap_or(0.0) } else { 0.0 };
        let (first, second) = (next(*floats), next(*other));
        let (apart, way) = (u - w, first - second);
        let whole = slide.interval.end - slide.interval.start;
        // Round a closed curve they meet on either side.
        let (apart, ahead) =
            if slide.interval.periodic { (apart.rem_euclid(whole), whole) } else { (apart, f64::INFINITY) };
        let room = match apart >= 0.0 {
            true if way < 0.0 => apart,
            true => ahead - apart,
            false if way > 0.0 => -apart,
            false => f64::INFINITY,
        };
        (way.abs() >= room).then(|| room / way.abs())
    }

    /// Whether one of its places, put forth or back along its curve to another one, would go through its other place on the same.
    pub(crate) fn passes(&self, place: usize, to: f64, forth: bool) -> bool {
        let [
            Place { body: a, location: Location::Curve(u), .. },
            Place { body: b, location: Location::Curve(w), .. },
        ] = &self.places[..]
        else {
            return false;
        };
        let Some(slide) = self.slides.first().filter(|_| a == b) else { return false };
        let (own, other) = if place == 0 { (*u, *w) } else { (*w, *u) };
        if !slide.interval.periodic {
            return (own - other) * (to - other) <= 0.0;
        }
        let whole = slide.interval.end - slide.interval.start;
        let way = |from: f64, to: f64| if forth { to - from } else { from - to }.rem_euclid(whole);
        way(own, other) <= way(own, to)
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

    /// What it knows of the corners along which its places slide.
    pub(super) fn look_for_corners(&mut self, shapes: &Shapes<'_>) -> Result<()> {
        let mut all = Vec::with_capacity(self.slides.len());
        for (index, place) in self.places.iter().enumerate().filter(|(_, place)| place.floats) {
            let shape = shapes.get(place.body)?;
            for axis in 0..place.location.parameters() {
                let mut sharp = sharp_knots(shape, axis, self.order_at(index));
                let slide = self.slides.get(all.len()).map(|slide| slide.interval);
                let own = shape.domain().get(axis).copied();
                if let Some((own, _)) = own.zip(slide).filter(|(own, slide)| slide.periodic && !own.periodic)
                    && (self.order_at(index) > 0 || jumps(shape, own))
                {
                    sharp.insert(0, own.start);
                }
                all.push(sharp);
            }
        }
        self.corners = all;
        self.stands.clear();
        self.stands.resize(self.slides.len(), false);
        Ok(())
    }

    /// Of each of its parameters that floats, in turn, where it is.
    pub(crate) fn parameters(&self) -> SmallVec<[f64; 4]> {
        let floats = self.places.iter().filter(|place| place.floats);
        floats
            .flat_map(|place| match place.location {
                Location::Curve(u) => SmallVec::<[f64; 2]>::from_slice(&[u]),
                Location::Surface(u, v) | Location::Face(_, u, v) => SmallVec::from_slice(&[u, v]),
                Location::Vertex(_) => SmallVec::new(),
            })
            .collect()
    }

    /// The next corner of one of its parameters that is not here, forwards or backwards: where it is, and the way there in lengths. `O(log n)` for `n` corners.
    pub(crate) fn next_corner(&self, own: usize, at: f64, forward: bool) -> Option<(f64, f64)> {
        let (corners, slide) = (self.corners.get(own)?, self.slides.get(own)?);
        let whole = slide.interval.end - slide.interval.start;
        let (next, round) = if forward {
            (corners.get(corners.partition_point(|corner| *corner <= at)), corners.first())
        } else {
            (corners[..corners.partition_point(|corner| *corner < at)].last(), corners.last())
        };
        let way = |corner: f64| if forward { corner - at } else { at - corner };
        match next {
            Some(corner) => Some((*corner, way(*corner) / slide.pace)),
            // Round the seam.
            None if slide.interval.periodic => {
                round.map(|corner| (*corner, (way(*corner) + whole) / slide.pace))
            }
            None => None,
        }
    }

    /// Whether one of its parameters is exactly on a corner.
    pub(crate) fn is_on_corner(&self, own: usize, at: f64) -> bool {
        self.corners.get(own).is_some_and(|corners| corners.binary_search_by(|c| c.total_cmp(&at)).is_ok())
    }

    /// Puts one of its parameters on a corner, or close beside it: ahead of it (1.0) or behind (-1.0).
    pub(crate) fn put_at(&mut self, own: usize, corner: f64, side: f64) {
        let Some(interval) = self.slides.get(own).map(|slide| slide.interval) else { return };
        let whole = interval.end - interval.start;
        let to = corner + side * BESIDE * whole;
        let to = if interval.periodic && !(interval.start..interval.end).contains(&to) {
            interval.start + (to - interval.start).rem_euclid(whole)
        } else {
            to
        };
        let mut all = self.parameters();
        if let Some(at) = all.get_mut(own) {
            *at = to;
        }
        let mut all = all.into_iter();
        let mut next = |at: f64| all.next().unwrap_or(at);
        let places: Places = self
            .places
            .iter()
            .map(|place| match place.location {
                location if !place.floats => location,
                Location::Curve(u) => Location::Curve(next(u)),
                Location::Surface(u, v) => Location::Surface(next(u), next(v)),
                Location::Face(face, u, v) => Location::Face(face, next(u), next(v)),
                Location::Vertex(vertex) => Location::Vertex(vertex),
            })
            .collect();
        self.put(&places);
    }

    /// The force that its multipliers make along one of its parameters where it is: `L_sᵀλ`, forth of which is positive.
    pub(crate) fn pull_along(&self, shapes: &Shapes<'_>, own: usize, along: &mut Vec<f64>) -> Result<f64> {
        let (mut first, mut pull) = (0, 0.0);
        for (index, place) in self.places.iter().enumerate().filter(|(_, place)| place.floats) {
            let count = place.location.parameters();
            if !(first..first + count).contains(&own) {
                first += count;
                continue;
            }
            let order = if own == first { Derivative { u: 1, v: 0 } } else { Derivative { u: 0, v: 1 } };
            let mut multipliers = self.multipliers.iter();
            for part in &self.parts {
                let count = part.value.len();
                let asked = |k: &usize| count != 3 || self.axes[*k];
                let own: SmallVec<[f64; 6]> =
                    multipliers.by_ref().take((0..count).filter(asked).count()).copied().collect();
                for term in part.terms.iter().filter(|term| term.place == Some(index)) {
                    along.clear();
                    along.resize(count, 0.0);
                    term.functional.along(shapes, order, along)?;
                    let asked = (0..count).filter(asked);
                    pull += term.sign * asked.zip(&own).map(|(k, force)| along[k] * force).sum::<f64>();
                }
            }
            return Ok(pull);
        }
        Ok(pull)
    }
}
