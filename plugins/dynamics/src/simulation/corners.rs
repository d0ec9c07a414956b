//! Corners that places slide to.
//!
//! Where a shape has a corner, what pulls a place along it jumps: a place rests on the corner where it is pulled forth from behind and back from
//! ahead, whatever the sizes of both (zero is between the pulls: the condition of a subdifferential, Clarke 1990). Newton's steps know one side at a
//! time. A derivative that is held has its corners where it is no more than continuous: the second one of a cubic at every knot. So a place stops at a corner that it comes to, stays for a step while all else goes on, and goes on to the side that then pulls it, if
//! one does.

use smallvec::SmallVec;

use super::Simulation;
use super::tangent::Tangent;
use crate::error::Result;
use crate::link::BESIDE;
use crate::place::Slide;

/// A place is on a corner within this share of its shape's parameters.
const ON: f64 = 1e-9;
/// Nearer than this share of the shape a place is put on the corner that it would cross.
const NEAR: f64 = 1e-4;

/// What a place does at a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum State {
    #[default]
    Free,
    /// It came to the corner, and stays.
    Stays,
    /// It goes on from there.
    Leaves,
}

/// Of each parameter of each constraint, where its shape may have corners, and what it does there.
#[derive(Debug, Default)]
pub(super) struct Corners {
    all: Vec<Vec<(Vec<f64>, State)>>,
}

/// How far it is to the next corner that is not here, in lengths.
fn way_to(corners: &[f64], slide: &Slide, at: f64, forward: bool) -> f64 {
    let whole = slide.interval.end - slide.interval.start;
    let ways = corners.iter().map(|corner| {
        let way = if forward { corner - at } else { at - corner };
        if slide.interval.periodic { way.rem_euclid(whole) } else { way }
    });
    let ways =
        ways.filter(|way| *way > ON * whole && !(slide.interval.periodic && *way > (1.0 - ON) * whole));
    ways.fold(f64::INFINITY, f64::min) / slide.pace
}

fn is_on(corners: &[f64], slide: &Slide, at: f64) -> bool {
    let whole = slide.interval.end - slide.interval.start;
    corners.iter().any(|corner| {
        let way = (corner - at).abs();
        way <= ON * whole || slide.interval.periodic && way >= (1.0 - ON) * whole
    })
}

impl Simulation {
    /// Of each place of a constraint that slides, whether it is on a corner of its shape: at a knot where what is held (the point, or a derivative) is no more
    /// than continuous, to 1e-9 of the domain. `O(knots)` a place.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn on_corners(&self, constraint: usize) -> Result<Vec<bool>> {
        let link = self.link(constraint)?;
        let (parameters, mut first) = (link.parameters(), 0);
        let mut all = Vec::new();
        for place in link.places.iter().filter(|place| place.floats) {
            let own = first..first + place.location.parameters();
            first = own.end;
            let on = |own: usize| is_on(&link.corners()[own], &link.slides[own], parameters[own]);
            all.push(own.into_iter().any(on));
        }
        Ok(all)
    }
}

impl Simulation {
    /// The highest order of derivative that a constraint holds at a place that slides; 0 of points.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub(crate) fn order(&self, constraint: usize) -> Result<usize> {
        let link = self.link(constraint)?;
        let floats = (0..link.places.len()).filter(|place| link.places[*place].floats);
        Ok(floats.map(|place| link.order_at(place)).max().unwrap_or(0))
    }
}

impl Corners {
    pub(super) fn new(simulation: &Simulation) -> Self {
        let free = |corners: &Vec<f64>| (corners.clone(), State::Free);
        Self { all: simulation.links.iter().map(|link| link.corners().iter().map(free).collect()).collect() }
    }

    /// What would leave a corner and found no way stays for another step. Whether there was such.
    pub(super) fn come_back(&mut self) -> bool {
        let mut any = false;
        for (_, state) in self.all.iter_mut().flatten().filter(|(_, state)| *state == State::Leaves) {
            (*state, any) = (State::Stays, true);
        }
        any
    }

    /// How far a parameter of a constraint goes that would go so far, both in lengths: to the next corner, no farther.
    pub(super) fn stop(&self, link: usize, own: usize, slide: &Slide, at: f64, way: f64) -> f64 {
        match self.all.get(link).and_then(|all| all.get(own)) {
            // What came to a corner in this step stays for the rest of it.
            Some((corners, state)) if *state != State::Leaves && is_on(corners, slide, at) => 0.0,
            Some((corners, _)) if !corners.is_empty() => {
                let room = way_to(corners, slide, at, way > 0.0);
                way.clamp(-room, room)
            }
            _ => way,
        }
    }
}

impl Simulation {
    /// Which parameters stay where they are: all where `still`, else those on corners that hold them, or that they have come to just now.
    /// Those that are pulled on from there, where all forces balance `fairly`, are put on the side that pulls.
    pub(super) fn stay_on_corners(&mut self, tangent: &mut Tangent, still: bool, fairly: bool) -> Result<()> {
        let mut corners = std::mem::take(&mut tangent.corners);
        let mut tried = false;
        tangent.stays.clear();
        for (link, own) in self.links.iter().zip(&mut corners.all).filter(|(link, _)| link.is_held()) {
            let pinned = link.pinned.iter().copied();
            for (((slide, at), (places, state)), pinned) in
                link.slides.iter().zip(link.parameters()).zip(own).zip(pinned)
            {
                *state = match (*state, is_on(places, slide, at)) {
                    (_, false) => State::Free,
                    (State::Free, true) => State::Stays,
                    (state, true) => {
                        tried |= state == State::Stays && !pinned;
                        state
                    }
                };
                tangent.stays.push(still || pinned || *state == State::Stays);
            }
        }
        if tried && !still && fairly {
            self.leave_corners(tangent, &mut corners)?;
        }
        tangent.corners = corners;
        Ok(())
    }

    fn leave_corners(&mut self, tangent: &mut Tangent, corners: &mut Corners) -> Result<()> {
        let [behind, ahead, _] = self.pulls_beside()?;
        let mut parameter = 0;
        for (link, own) in self.links.iter_mut().zip(&mut corners.all).filter(|(link, _)| link.is_held()) {
            let mut by: SmallVec<[f64; 4]> = SmallVec::new();
            for ((slide, (_, state)), pinned) in link.slides.iter().zip(own).zip(&link.pinned) {
                let (a, b) = (behind[parameter], ahead[parameter]);
                // Those that came just now have no forces of theirs yet.
                let leaves = *state == State::Stays
                    && !pinned
                    && tangent.tried.get(parameter) == Some(&true)
                    && !(a >= 0.0 && b <= 0.0);
                if leaves {
                    *state = State::Leaves;
                    tangent.stays[parameter] = false;
                }
                let forward = if a < 0.0 && b > 0.0 { b > -a } else { b > 0.0 };
                let way = BESIDE * slide.length();
                by.push(if !leaves {
                    0.0
                } else if forward {
                    way
                } else {
                    -way
                });
                parameter += 1;
            }
            if by.iter().any(|by| *by != 0.0) {
                let (places, _) = link.moved(|own| by[own]);
                link.put(&places);
            }
        }
        Ok(())
    }

    /// Puts places that would cross a corner close to them on it. Whether there were such.
    pub(super) fn come_to_corners(&mut self, tangent: &Tangent, by: &[f64]) -> bool {
        let mut parameter = by.len() - self.desk.parameters;
        let mut any = false;
        for (index, link) in self.links.iter_mut().enumerate().filter(|(_, link)| link.is_held()) {
            let ways: SmallVec<[f64; 4]> = (link.slides.iter().zip(link.parameters()).enumerate())
                .map(|(own, (slide, at))| {
                    let way = by[parameter + own];
                    let stop = tangent.corners.stop(index, own, slide, at, way);
                    if stop != way && stop.abs() <= NEAR * slide.length() { stop } else { 0.0 }
                })
                .collect();
            parameter += ways.len();
            if ways.iter().any(|way| *way != 0.0) {
                let (places, _) = link.moved(|own| ways[own]);
                link.put(&places);
                any = true;
            }
        }
        any
    }
}
