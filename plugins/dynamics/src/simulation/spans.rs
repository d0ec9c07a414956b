//! From span to span: where a place that slides rests lowest.
//!
//! Where a rope turns sharply at a ring, a spline turns within its spans and not at a point, so that its energy has a least value in each of several spans
//! of the place that slides, one beside the other, though a rope has none but the lowest of these. Newton's steps come to the nearest. From there the place is put into the
//! spans beside, all else comes to rest while it stays, then the place as well; where the energy is lower it is gone on from, by twice as many spans.

use loftsman_kernel::shape::{Location, cells_of};

use super::Simulation;
use super::descent::Start;
use super::equilibrium::Search;
use super::settle::Settled;
use crate::error::{DynamicsError, Result};

/// So often all places are tried again, as long as one has found a lower one, and no more steps than this are taken.
const SWEEPS: usize = 4;
const MOST: usize = 1000;
/// A span farther rest is found within so many steps, or not looked for.
const PATIENCE: usize = 60;
/// A place is on a knot within this share of a span.
const ON: f64 = 1e-9;
/// Lower is what falls by this share of what energies are made of.
const LOWER: f64 = 1e-9;

/// A place that slides along a curve that moves.
struct Slider {
    link: usize,
    /// Which of the link's places, and where its spans end.
    place: usize,
    spans: Vec<f64>,
    periodic: bool,
}

impl Slider {
    /// The same share of the span that is so many farther, where there is one; from a knot, which may hold it though it rests lower beside, the middles of the spans.
    fn target(&self, at: f64, by: isize) -> Option<f64> {
        let spans = self.spans.len().checked_sub(1).filter(|spans| *spans > 0)?;
        let own = self.spans.partition_point(|end| *end <= at).clamp(1, spans) - 1;
        let share = (at - self.spans[own]) / (self.spans[own + 1] - self.spans[own]);
        // The spans beside a knot are the first ones on both sides.
        let on_knot = share <= ON || share >= 1.0 - ON;
        let (first, share) = match (on_knot, by > 0, share > 0.5) {
            (false, ..) => (own as isize, share),
            (true, true, false) => (own as isize - 1, 0.5),
            (true, false, true) => (own as isize + 1, 0.5),
            (true, ..) => (own as isize, 0.5),
        };
        let to = first + by;
        let to = if self.periodic { to.rem_euclid(spans as isize) } else { to };
        let to = usize::try_from(to).ok().filter(|to| *to < spans)?;
        Some(self.spans[to] + share * (self.spans[to + 1] - self.spans[to]))
    }
}

impl Simulation {
    /// Of something at rest: places that slide along curves that move, put from span to span as long as the energy of rest falls there.
    pub(super) fn rest_over_spans(&mut self, mut settled: Settled) -> Result<Settled> {
        let sliders = self.sliders()?;
        // Steps to places that were not lower are no part of the way that is told, but of what may be taken.
        let mut spent = settled.steps;
        for _ in 0..SWEEPS {
            let mut any = false;
            for slider in &sliders {
                for side in [1, -1] {
                    let (mut spans, mut lower) = (1, false);
                    while spent < MOST {
                        if self.hop(slider, side * spans, &mut settled, &mut spent)? {
                            (spans, lower) = (2 * spans, true);
                        } else if spans > 1 {
                            spans = 1;
                        } else {
                            break;
                        }
                    }
                    any |= lower;
                    if lower {
                        break;
                    }
                }
            }
            if !any {
                break;
            }
        }
        Ok(settled)
    }

    fn sliders(&self) -> Result<Vec<Slider>> {
        let mut all = Vec::new();
        for (link, own) in self.links.iter().enumerate().filter(|(_, own)| own.is_held()) {
            for (place, at) in own.places.iter().enumerate().filter(|(_, place)| place.floats) {
                let moves = self.bodies[at.body].mass.is_some() && own.order_at(place) == 0;
                if !moves || !matches!(at.location, Location::Curve(_)) {
                    continue;
                }
                let shape = self.shape(at.body)?;
                if let Some(splines) =
                    cells_of(shape, "a place that slides").ok().and_then(|cells| cells.splines())
                {
                    let spans = splines.u.breakpoints();
                    let periodic = self.bodies[at.body].body.interval(0).is_some_and(|side| side.periodic);
                    all.push(Slider { link, place, spans, periodic });
                }
            }
        }
        Ok(all)
    }

    /// Puts a place so many spans farther, by steps that are added to those `spent`. Whether the rest that is found there is lower; else all is as it was.
    fn hop(&mut self, slider: &Slider, by: isize, settled: &mut Settled, spent: &mut usize) -> Result<bool> {
        let link = &mut self.links[slider.link];
        let mut places: crate::link::Places = link.locations().collect();
        let Location::Curve(at) = places[slider.place] else { return Ok(false) };
        let Some(to) = slider.target(at, by).filter(|_| link.is_held()) else { return Ok(false) };
        // Not through the other place of its own loop.
        if link.passes(slider.place, to, by > 0) {
            return Ok(false);
        }
        let mut start = Start::default();
        start.remember(self);
        let (before, sizes) = self.potential();
        places[slider.place] = Location::Curve(to);
        self.links[slider.link].put(&places);
        let found = match self.find_rest(Search { rested: None, still: true, most: PATIENCE }) {
            Ok(found) => {
                *spent += found.steps.max(1);
                found
            }
            // There it goes beyond all numbers, or what holds it contradicts itself: not a place to rest. How many steps that took is not told: it counts
            // as all that it might.
            Err(DynamicsError::NoRest | DynamicsError::Torn { .. } | DynamicsError::Conflict { .. }) => {
                *spent += PATIENCE;
                start.back(self);
                return Ok(false);
            }
            Err(error) => return Err(error),
        };
        let lower = found.rests
            && found.ends
            && start.is_as_held(self)
            && self.potential().0 < before - LOWER * sizes;
        if !lower {
            start.back(self);
            return Ok(false);
        }
        settled.steps += found.steps;
        (settled.residual, settled.way, settled.stable) = (found.residual, found.way, found.stable);
        Ok(true)
    }
}
