//! Places that slide over corners while things move.
//!
//! At a corner the tangent jumps along which a place slides: velocities that kept the constraint until there break it from there on. A step therefore stops where a
//! place comes to a corner, and what breaks the constraint is taken out of all velocities by an impulse, `min ½ δvᵀ M δv` under `L (v + δv) + L_s ṡ = ` the targets'
//! rates with the tangent of the far side (Gauß's principle of an impact; energy is lost, none is made). Where the place would turn back by that, as at a corner
//! sharper than a right angle, it stands on the corner: as a place that does not float, `ṡ = 0`, until its constraint's force draws it forth on the side ahead, or back on the side
//! behind. So a place that is drawn to its corner from both sides rests there, as it does where rest is looked for.

use super::{Simulation, shapes};
use crate::error::Result;

/// After so many stops in a step a place that comes to a corner stands there until the next.
const STOPS: usize = 16;
/// What comes to corners within this share of a step comes there at once.
const AT_ONCE: f64 = 1e-9;

/// One parameter that came to a corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrival {
    link: usize,
    own: usize,
    corner: f64,
    /// Where it came to: 1.0 where parameters grow.
    side: f64,
}

/// What stops need; their rooms are kept.
#[derive(Debug, Default)]
pub(crate) struct Stops {
    arrivals: Vec<Arrival>,
    velocities: Vec<f64>,
    rates: Vec<f64>,
    along: Vec<f64>,
}

impl Stops {
    /// Rooms for so many velocities and parameters.
    pub(crate) fn prepare(&mut self, velocities: usize, parameters: usize) {
        self.velocities.reserve(velocities);
        self.rates.reserve(parameters);
        self.arrivals.reserve(parameters);
        self.along.reserve(8);
    }
}

/// When what starts at rest at 0, with this rate and acceleration, has gone so far: the first time after 0.
fn first_time(way: f64, rate: f64, acceleration: f64) -> Option<f64> {
    // rate t + acceleration t²/2 = way, by the form that does not cancel.
    let root = (rate * rate + 2.0 * acceleration * way).sqrt();
    let times = [2.0 * way / (rate + root), 2.0 * way / (rate - root)];
    times.into_iter().filter(|t| t.is_finite() && *t >= 0.0).min_by(f64::total_cmp)
}

impl Simulation {
    /// What is exactly on a corner goes on from there to the side to which it goes, and stands there if it goes nowhere.
    pub(super) fn stand_on_corners(&mut self) {
        for link in self.links.iter_mut().filter(|link| link.is_held() && link.has_corners()) {
            for own in 0..link.slides.len() {
                let Some(at) = link.parameters().get(own).copied() else { continue };
                if link.stands[own] || !link.is_on_corner(own, at) {
                    continue;
                }
                match link.rates[own] {
                    0.0 => link.stands[own] = true,
                    rate => link.put_at(own, at, rate.signum()),
                }
            }
        }
    }

    /// What stands on a corner and is drawn from there goes on, from rest. Whether there was such. To be asked when forces of constraints are known.
    pub(super) fn leave_corners_in_motion(&mut self) -> Result<bool> {
        let mut any = false;
        let mut along = std::mem::take(&mut self.stops.along);
        let shapes = shapes(&self.bodies);
        let mut done = Ok(());
        'all: for link in self.links.iter_mut().filter(|link| link.is_held() && link.has_corners()) {
            for own in 0..link.stands.len() {
                let Some(at) = link.parameters().get(own).copied().filter(|_| link.stands[own]) else {
                    continue;
                };
                let mut pulls = [0.0; 2];
                for (pull, side) in pulls.iter_mut().zip([-1.0, 1.0]) {
                    link.put_at(own, at, side);
                    match link.pull_along(&shapes, own, &mut along) {
                        Ok(found) => *pull = found,
                        Err(error) => {
                            done = Err(error);
                            break 'all;
                        }
                    }
                }
                let [back, forth] = [-pulls[0], pulls[1]];
                if back <= 0.0 && forth <= 0.0 {
                    link.put_at(own, at, 0.0);
                    continue;
                }
                link.put_at(own, at, if forth >= back { 1.0 } else { -1.0 });
                (link.stands[own], link.rates[own], any) = (false, 0.0, true);
            }
        }
        self.stops.along = along;
        done.map(|()| any)
    }

    /// When the first place comes to a corner within so many seconds, and which come there then: from velocities half a step behind, by the accelerations that are known.
    pub(super) fn next_stop(&mut self, within: f64) -> Option<f64> {
        let mut arrivals = std::mem::take(&mut self.stops.arrivals);
        arrivals.clear();
        let (mut first, half) = (f64::INFINITY, 0.5 * self.last);
        for pass in 0..2 {
            for (index, link) in self.links.iter().enumerate() {
                if !link.is_held() || !link.has_corners() {
                    continue;
                }
                for (own, at) in link.parameters().into_iter().enumerate() {
                    if link.stands[own] {
                        continue;
                    }
                    let a = link.accelerations[own];
                    let rate = link.rates[own] + half * a;
                    let way = within * (rate + 0.5 * within * a);
                    let forward = way > 0.0;
                    let Some((corner, room)) =
                        link.next_corner(own, at, forward).filter(|(_, room)| *room <= way.abs())
                    else {
                        continue;
                    };
                    let room = if forward { room } else { -room };
                    let Some(time) = first_time(room, rate, a).map(|time| time.min(within)) else { continue };
                    if pass == 0 {
                        first = first.min(time);
                    } else if time <= first + AT_ONCE * within {
                        arrivals.push(Arrival {
                            link: index,
                            own,
                            corner,
                            side: if forward { 1.0 } else { -1.0 },
                        });
                    }
                }
            }
            if first.is_infinite() {
                break;
            }
        }
        self.stops.arrivals = arrivals;
        first.is_finite().then_some(first)
    }

    /// What came to corners is put there, on the side from which it came.
    pub(super) fn put_on_stops(&mut self) {
        for Arrival { link, own, corner, side } in self.stops.arrivals.iter().copied() {
            if self.links[link].is_held() {
                self.links[link].put_at(own, corner, -side);
            }
        }
    }

    /// The impulse with which what came to corners goes on beyond these; what would turn back stands, all where they `stay`.
    pub(super) fn strike(&mut self, stay: bool) -> Result<()> {
        let mut stops = std::mem::take(&mut self.stops);
        stops.velocities.clone_from(&self.half);
        stops.rates.clear();
        stops.rates.extend(self.links.iter().flat_map(|link| &link.rates));
        for Arrival { link, own, corner, side } in stops.arrivals.iter().copied() {
            self.links[link].put_at(own, corner, if stay { 0.0 } else { side });
            self.links[link].stands[own] = stay;
        }
        let mut done = Ok(());
        // Each time one more stands, or none.
        for _ in 0..=stops.arrivals.len() {
            self.half.copy_from_slice(&stops.velocities);
            let mut rates = stops.rates.iter();
            for link in &mut self.links {
                for ((own, rate), stands) in link.rates.iter_mut().zip(&mut rates).zip(&link.stands) {
                    *own = if *stands { 0.0 } else { *rate };
                }
            }
            done = self.keep_to_rates();
            let mut turned = false;
            for Arrival { link, own, corner, side } in stops.arrivals.iter().copied() {
                let link = &mut self.links[link];
                if !link.stands[own] && link.rates[own] * side <= 0.0 {
                    link.put_at(own, corner, 0.0);
                    (link.stands[own], turned) = (true, true);
                }
            }
            if done.is_err() || !turned {
                break;
            }
        }
        self.stops = stops;
        done
    }

    /// Whether more stops in this step would be too many.
    pub(super) fn too_many(stops: usize) -> bool {
        stops >= STOPS
    }
}

#[cfg(test)]
mod tests {
    use super::first_time;

    #[test]
    fn the_first_time_is_found() {
        for (way, rate, acceleration, wanted) in [
            (1.0, 2.0, 0.0, Some(0.5)),
            (-1.0, -2.0, 0.0, Some(0.5)),
            (1.0, 0.0, 2.0, Some(1.0)),
            // There and back again: the first of both.
            (1.0, 3.0, -4.0, Some(0.5)),
            // It turns round before.
            (1.0, 1.0, -4.0, None),
            // It starts the other way.
            (-1.0, 1.0, -4.0, Some(1.0)),
            (0.0, 1.0, 1.0, Some(0.0)),
            (1.0, 0.0, 0.0, None),
        ] {
            let found = first_time(way, rate, acceleration);
            let same = match (found, wanted) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(same, "{way} {rate} {acceleration}: {found:?} {wanted:?}");
        }
    }
}
