//! What a step is made of where things are: which constraints hold, their rows, and all other forces.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::Shapes;

use super::{Simulation, shapes};
use crate::error::{DynamicsError, Result};
use crate::link::{Desk, Link};
use crate::scheme::Scheme;

/// A curve crosses the surface that it slides on, both ways, by an angle of at least this sine.
const ALONG: f64 = 1e-2;

impl Simulation {
    /// Constraints come and go with their times. Whether one has come.
    pub(crate) fn come_and_go(&mut self) -> Result<bool> {
        let mut came = false;
        let shapes = shapes(&self.bodies);
        for link in &mut self.links {
            if link.at_time(self.time) {
                link.keep_what_is(&shapes)?;
                came = true;
            }
        }
        let new = |link: &Link| link.is_held() && (link.is_new() || link.equations == 0);
        if !came && !self.links.iter().any(new) {
            return Ok(false);
        }
        // What is missing as they come is let go slowly.
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        let mut now = std::mem::take(&mut self.gap_rates);
        now.clear();
        now.resize(self.space.equations(), 0.0);
        self.space.apply(&self.half, &self.rates, &mut now);
        now.iter_mut().zip(&desk.target_rate).for_each(|(now, target)| *now -= target);
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            if link.is_new() {
                let own = link.first..link.first + link.equations;
                link.start(&desk.gap[own.clone()], &now[own], 1e-12 * self.size);
            }
        }
        (self.desk, self.gap_rates) = (desk, now);
        self.worst = 0.0;
        collected.map(|()| came)
    }

    /// Pushes the rows of all constraints that hold, where things are.
    pub(crate) fn collect(&mut self, desk: &mut Desk) -> Result<()> {
        self.space.clear();
        desk.clear();
        let shapes = shapes(&self.bodies);
        let velocities = Shapes::new(self.bodies.iter().map(|body| body.velocity.as_ref()));
        for link in self.links.iter_mut().filter(|link| link.is_held()) {
            let before = desk.changes.len();
            link.push(&shapes, &velocities, self.time, &mut self.space, desk)?;
            if let Some(sine) = link.crossing(&desk.changes[before..])
                && sine < ALONG
            {
                let (name, time) = (link.name.clone(), self.time);
                return Err(DynamicsError::Along { name, time, degrees: sine.asin().to_degrees() });
            }
        }
        self.space.float(desk.parameters, self.weight_of_parameters());
        for &(equation, parameter, by) in &desk.changes {
            self.space.change(equation, parameter, by);
        }
        for &(parameter, factor) in &desk.damped {
            self.space.damp(parameter, factor);
        }
        self.rates.clear();
        let held = self.links.iter().filter(|link| link.is_held());
        self.rates.extend(held.flat_map(|link| &link.rates));
        if !self.settling {
            return Ok(());
        }
        // What looks for rest must be held, at first and when something has let go.
        let held = self.links.iter().filter(|link| link.is_held()).count();
        if self.held != Some(held) {
            self.check_held()?;
            self.held = Some(held);
        }
        Ok(())
    }

    /// The mass of what slides.
    pub(crate) fn weight_of_parameters(&self) -> f64 {
        if self.scheme == Scheme::Epsilon { self.parameter_mass } else { 0.0 }
    }

    /// Velocities that are half a step behind, ahead by the last acceleration: into the shapes of velocities.
    pub(crate) fn predict(&mut self) {
        let ahead = 0.5 * self.last;
        for body in self.bodies.iter_mut().filter(|body| body.mass.is_some()) {
            let range = body.range();
            let (v, a) = (&self.half[range.clone()], &self.acceleration[range]);
            let vertices = body.velocity.control_vertices_mut().iter_mut();
            for ((vertex, v), a) in vertices.zip(v.chunks_exact(3)).zip(a.chunks_exact(3)) {
                for axis in 0..3 {
                    vertex[axis] = v[axis] + ahead * a[axis];
                }
            }
        }
    }

    /// All forces but those of constraints, at the present places and predicted velocities.
    pub(crate) fn gather_forces(&mut self) {
        self.forces.copy_from_slice(&self.applied);
        for body in &self.bodies {
            let (Some(elastic), Some(mass)) = (&body.elastic, &body.mass) else { continue };
            let out = &mut self.forces[body.range()];
            let (q, v) = (body.body.shape.control_vertices(), body.velocity.control_vertices());
            for (out, m) in out.chunks_exact_mut(3).zip(&mass.lumped) {
                (0..3).for_each(|axis| out[axis] += m * self.gravity[axis]);
            }
            let slackest = elastic.add_forces(q, v, out);
            self.slackest = self.slackest.min(slackest);
            let damping = body.body.material.damping;
            if damping > 0.0 {
                for (i, out) in out.chunks_exact_mut(3).enumerate() {
                    let momentum =
                        mass.matrix.row(i).fold(Vector::zeros(), |sum, (j, m)| sum + v[j].coords * m);
                    (0..3).for_each(|axis| out[axis] -= damping * momentum[axis]);
                }
            }
        }
        for load in self.loads.iter().filter(|load| load.acts(self.time - self.late)) {
            let Some(body) = self.bodies.iter().find(|body| body.start == load.offset()) else { continue };
            let (q, v) = (body.body.shape.control_vertices(), body.velocity.control_vertices());
            load.add(q, v, self.time, self.settling, &mut self.forces);
        }
    }
}
