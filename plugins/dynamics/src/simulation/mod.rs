//! Bodies in motion: state, forces, one step after another.

mod advance;
mod audit;
mod bounds;
mod conflict;
mod corners;
mod descent;
mod equilibrium;
mod explicit;
mod gather;
mod hanging;
mod here;
mod implicit;
mod kinks;
mod ledger;
mod moving;
mod overload;
mod saddle;
mod settle;
mod sides;
mod spans;
mod steer;
mod stops;
mod tangent;
mod told;
mod unheld;
mod velocities;

use loftsman_kernel::Vector;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::RangeSpace;

use self::advance::Before;
pub use self::audit::Audit;
use self::conflict::contradictions;
use self::here::Aside;
use self::implicit::Implicit;
pub use self::kinks::Corner;
use self::ledger::Ledger;
pub(crate) use self::moving::{Moving, stable_step};
pub use self::settle::{Settled, Unrest};
use self::stops::Stops;
pub use self::told::Energy;
pub(crate) use self::told::Unseen;
use crate::body::Material;
use crate::error::{DynamicsError, Result};
use crate::link::{self, Desk, Link, Phase};
use crate::load::Load;
use crate::points::Rule;
use crate::scheme::Scheme;

/// More sub-steps than this for one step are not taken.
const MOST: f64 = 1e6;
/// Of so many explicit steps one is looked at.
const LOOKS: usize = 16;
/// A loop this short, as a share of the size, is drawn shut.
const SHUT: f64 = 1e-6;

/// What happened to a constraint.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, in seconds.
    pub time: f64,
    /// The constraint's number.
    pub constraint: usize,
    /// What it is called.
    pub name: String,
    /// What happened.
    pub what: &'static str,
    /// Whether it let go by itself; its time may be over, or somebody released it.
    pub let_go: bool,
}

/// Things in motion, prepared once and stepped by whoever asks: a game loop, a browser, an animation. A step allocates nothing (up to bicubic
/// shapes, four bodies, and while no constraint comes or goes).
#[derive(Debug)]
pub struct Simulation {
    pub(crate) bodies: Vec<Moving>,
    pub(crate) gravity: Vector,
    pub(crate) links: Vec<Link>,
    pub(crate) loads: Vec<Load>,
    pub(crate) space: RangeSpace,
    pub(crate) scheme: Scheme,
    pub(crate) size: f64,
    pub(crate) time: f64,
    /// Within an implicit step, which looks at its end: half of it, for in its middle loads act that do so in all of it.
    pub(crate) late: f64,
    /// Velocities half a step behind (explicit), or now (implicit), three numbers a vertex.
    pub(crate) half: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    /// The length of the last explicit step; 0 where there was none.
    pub(crate) last: f64,
    /// The length of the last step as a whole, wherever it stopped.
    length: f64,
    pub(crate) forces: Vec<f64>,
    applied: Vec<f64>,
    pub(crate) right: Vec<f64>,
    pub(crate) gap_rates: Vec<f64>,
    pub(crate) multipliers: Vec<f64>,
    pub(crate) rates: Vec<f64>,
    pub(crate) desk: Desk,
    /// What is asked for, what is stable, and the mass of a parameter.
    step: Option<f64>,
    stable: f64,
    parameter_mass: f64,
    pub(crate) implicit: Option<Box<Implicit>>,
    events: Vec<Event>,
    sub_steps: usize,
    /// How often steps stopped on their way at corners, or were halved.
    pauses: usize,
    /// The largest error of a constraint since the last was drawn in.
    worst: f64,
    /// The same at the last of Newton's steps.
    missed: f64,
    pub(crate) rank: usize,
    /// The stable step, or all of the way that it goes on where that is shorter; and which share of it keeps constraints where they are.
    reach: f64,
    fineness: f64,
    /// The least share that is tried.
    finest: f64,
    patience: usize,
    /// Whether it looks for rest, and time stands still.
    pub(crate) settling: bool,
    /// How many constraints held when it was last looked whether what settles is held at all.
    held: Option<usize>,
    /// Where the last advance started.
    before: Before,
    /// Where one is while it is looked back.
    here: Before,
    aside: Aside,
    ledger: Ledger,
    /// How short, as a share of its length at rest, anything was since the last advance started.
    slackest: f64,
    /// What stops at corners.
    stops: Stops,
    /// Those that were made.
    corners: Vec<Corner>,
}

impl Simulation {
    pub(crate) fn new(
        bodies: Vec<Moving>,
        gravity: Vector,
        links: Vec<Link>,
        loads: Vec<Load>,
        space: RangeSpace,
        scheme: Scheme,
        size: f64,
    ) -> Self {
        let numbers = 3 * space.vertices();
        let mut half = vec![0.0; numbers];
        for body in bodies.iter().filter(|body| body.mass.is_some()) {
            let own = &mut half[body.range()];
            for (out, v) in own.chunks_exact_mut(3).zip(body.velocity.control_vertices()) {
                out.copy_from_slice(v.coords.as_slice());
            }
        }
        Self {
            bodies,
            gravity,
            links,
            loads,
            space,
            scheme,
            size,
            time: 0.0,
            late: 0.0,
            half,
            acceleration: vec![0.0; numbers],
            last: 0.0,
            length: 0.0,
            forces: vec![0.0; numbers],
            applied: vec![0.0; numbers],
            right: Vec::new(),
            gap_rates: Vec::new(),
            multipliers: Vec::new(),
            rates: Vec::new(),
            desk: Desk::default(),
            step: None,
            stable: f64::INFINITY,
            parameter_mass: 0.0,
            implicit: None,
            events: Vec::new(),
            sub_steps: 0,
            worst: 0.0,
            missed: 0.0,
            rank: 0,
            reach: f64::INFINITY,
            fineness: 1.0,
            finest: 0.0,
            patience: 0,
            settling: false,
            held: None,
            before: Before::default(),
            here: Before::default(),
            aside: Aside::default(),
            ledger: Ledger::default(),
            slackest: f64::INFINITY,
            pauses: 0,
            stops: Stops::default(),
            corners: Vec::new(),
        }
    }

    /// Prepared: constraints come that hold from the start, and are looked at.
    pub(crate) fn begin(&mut self) -> Result<()> {
        if self.half.iter().any(|v| *v != 0.0) {
            self.project_velocities()?;
        }
        if self.scheme == Scheme::Implicit {
            let (implicit, space) = Implicit::new(&self.bodies);
            self.space = space;
            self.implicit = Some(Box::new(implicit));
        }
        let parameters = self.links.iter().map(|link| link.slides.len()).sum();
        self.stops.prepare(self.half.len(), parameters);
        self.come_and_go()?;
        contradictions(self, &mut Desk::default())
    }

    pub(crate) fn limits(&mut self, step: Option<f64>, stable: f64, parameter_mass: f64) {
        (self.step, self.stable, self.parameter_mass) = (step, stable, parameter_mass);
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// A body as it is.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn shape(&self, body: usize) -> Result<&dyn Shape> {
        Ok(self.body(body)?.body.shape.as_ref())
    }

    /// A body as it was at the start, by the knots that it has now.
    pub(crate) fn start_of(&self, body: usize) -> Result<Box<dyn Shape>> {
        let Moving { body, first, .. } = self.body(body)?;
        let mut start = body.shape.boxed();
        start.control_vertices_mut().copy_from_slice(first);
        Ok(start)
    }

    /// What a body is made of.
    pub(crate) fn material(&self, body: usize) -> Result<Material> {
        Ok(self.body(body)?.body.material)
    }

    /// The velocities of a body's control vertices.
    ///
    /// # Errors
    /// When there are not as many bodies.
    pub fn velocities(&self, body: usize) -> Result<Vec<Vector>> {
        let range = self.body(body)?.range();
        let ahead = 0.5 * self.last;
        let all = self.half[range.clone()].iter().zip(&self.acceleration[range]).map(|(v, a)| v + ahead * a);
        let all: Vec<f64> = all.collect();
        Ok(all.chunks_exact(3).map(Vector::from_column_slice).collect())
    }

    /// What a body is called.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn body_name(&self, body: usize) -> Result<&str> {
        Ok(&self.body(body)?.body.name)
    }

    fn body(&self, index: usize) -> Result<&Moving> {
        let count = self.bodies.len();
        self.bodies.get(index).ok_or(DynamicsError::Missing { what: "body", index, count })
    }

    fn link(&self, index: usize) -> Result<&Link> {
        let count = self.links.len();
        self.links.get(index).ok_or(DynamicsError::Missing { what: "constraint", index, count })
    }

    /// Where a constraint is on its shapes now: of each place that it looks at.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn locations(&self, constraint: usize) -> Result<Vec<Location>> {
        Ok(self.link(constraint)?.locations().collect())
    }

    /// The same, each with the number of its body.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn places(&self, constraint: usize) -> Result<Vec<(usize, Location)>> {
        Ok(self.link(constraint)?.places.iter().map(|place| (place.body, place.location)).collect())
    }

    /// Whether a constraint holds now; not before its time, and not when it has left its shape.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn holds(&self, constraint: usize) -> Result<bool> {
        Ok(self.link(constraint)?.is_held())
    }

    /// Whether a place of a constraint floats along its shape.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn slides(&self, constraint: usize) -> Result<bool> {
        Ok(self.link(constraint)?.places.iter().any(|place| place.floats))
    }

    /// Whether one of the places of a constraint floats along its shape, by its number among them.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn slides_at(&self, constraint: usize, place: usize) -> Result<bool> {
        Ok(self.link(constraint)?.places.get(place).is_some_and(|place| place.floats))
    }

    /// The forces with which a constraint holds: one number for each of its equations, `λ` of the last step. Of a point they are what is needed
    /// there, in x, y and z.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn force_of(&self, constraint: usize) -> Result<&[f64]> {
        let link = self.link(constraint)?;
        Ok(if link.is_held() { &link.multipliers } else { &[] })
    }

    /// What has happened to constraints: those that came, went, or left their shapes.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// How many constraints there are.
    pub fn constraints(&self) -> usize {
        self.links.len()
    }

    /// What a constraint is called.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn name_of(&self, constraint: usize) -> Result<&str> {
        Ok(&self.link(constraint)?.name)
    }

    /// How many steps were taken.
    pub fn sub_steps(&self) -> usize {
        self.sub_steps
    }

    /// How often steps were interrupted, each of which costs as much as a step: explicit ones where a place came to a corner of its shape, implicit ones where they had to be
    /// halved; those of steps that were taken again as well.
    pub fn pauses(&self) -> usize {
        self.pauses
    }

    /// The longest explicit step that is known to be stable, in seconds.
    pub fn stable_step(&self) -> f64 {
        self.stable
    }

    /// The scalar equations of the last step, and how many of them were independent.
    pub fn equations(&self) -> (usize, usize) {
        (self.space.equations(), self.rank)
    }

    /// The largest error of a constraint at any step since all were drawn in, in lengths.
    pub fn worst_error(&self) -> f64 {
        self.worst
    }

    /// Where constraints say the same: whether they still do, for their targets may move.
    pub(crate) fn agree(&mut self) -> Result<()> {
        if self.rank >= self.space.equations() {
            return Ok(());
        }
        let mut desk = std::mem::take(&mut self.desk);
        let checked = contradictions(self, &mut desk);
        self.desk = desk;
        checked
    }

    /// One step of exactly this length, stable or not. What comes or goes within it does so at its end. What slides faster and faster, as without damping, loses its
    /// place in the end by steps that are stable but always alike; [`advance`](Self::advance) takes shorter ones by the drift.
    ///
    /// # Errors
    /// As for [`advance`](Self::advance).
    pub fn step(&mut self, step: f64) -> Result<()> {
        if !self.settling {
            self.see(Rule::Full);
        }
        if self.come_and_go()? {
            let mut desk = std::mem::take(&mut self.desk);
            let checked = contradictions(self, &mut desk);
            self.desk = desk;
            checked?;
        }
        match self.scheme {
            Scheme::Implicit => self.step_implicitly(step)?,
            Scheme::Epsilon | Scheme::Exact => self.step_explicitly(step)?,
        }
        self.time += step;
        self.length = step;
        self.sub_steps += 1;
        self.look_after(step)
    }

    /// What became of the constraints, and whether all numbers are numbers.
    fn look_after(&mut self, step: f64) -> Result<()> {
        self.note_events();
        self.bounded(step, self.sub_steps.is_multiple_of(LOOKS) || self.scheme == Scheme::Implicit)
    }

    /// Loops that are drawn shut let go; what let go is written down.
    pub(crate) fn note_events(&mut self) {
        let (time, size) = (self.time, self.size);
        for (index, link) in self.links.iter_mut().enumerate() {
            let was = link.is_held();
            if was && link.is_shut(SHUT * size) {
                link.phase = Phase::Off { time, why: link::SHUT };
            }
            if let Phase::Off { time: since, why } = link.phase
                && !self.events.iter().any(|e| e.constraint == index && e.time == since && e.what == why)
            {
                self.events.push(Event {
                    time: since,
                    constraint: index,
                    name: link.name.clone(),
                    what: why,
                    let_go: link.phase.gone().is_some(),
                });
            }
        }
    }

    /// What constraints still let themselves miss is nothing from now on.
    pub(crate) fn let_all_go(&mut self) {
        self.links.iter_mut().for_each(Link::let_go);
    }

    /// Velocities are none any more.
    pub(crate) fn rest(&mut self) {
        self.half.fill(0.0);
        self.acceleration.fill(0.0);
        self.last = 0.0;
        self.ledger = Ledger::default();
        for link in &mut self.links {
            link.rates.fill(0.0);
            link.accelerations.fill(0.0);
            link.forget_where();
        }
    }
}

/// The bodies' shapes.
pub(crate) fn shapes(bodies: &[Moving]) -> Shapes<'_> {
    Shapes::new(bodies.iter().map(|body| body.body.shape.as_ref()))
}
