//! What is told of the present state: energies, errors, stretches.

use loftsman_kernel::Vector;

use super::settle::{SLIGHT, UNSEEN};
use super::{Moving, Simulation};
use crate::error::Result;

/// Energies at a time, in mass · length² / s².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// Of stretching, shearing and bending.
    pub elastic: f64,
    /// Of height, from the origin.
    pub gravity: f64,
    /// Of pulls.
    pub pulls: f64,
}

impl Energy {
    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity + self.pulls
    }
}

/// What steps do not see of how a body is stretched.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Unseen {
    /// The energy of stretching and shearing as steps see it, and how much more there is.
    pub(crate) seen: f64,
    pub(crate) more: f64,
    /// The stretch that has so much more on average: the root of the mean square.
    pub(crate) strain: f64,
    /// Whether that is worth a word.
    pub(crate) differs: bool,
}

impl Simulation {
    /// Energies now: of motion by velocities where things are. Of explicit steps, which know velocities half a step behind, it costs as much as a step.
    pub fn energy(&mut self) -> Energy {
        if self.last > 0.0 {
            self.velocities_here();
        } else {
            self.predict();
        }
        self.energy_seen()
    }

    /// Energies now, by the shapes of velocities.
    pub(super) fn energy_seen(&self) -> Energy {
        let mut all = Energy::default();
        for body in &self.bodies {
            let (Some(elastic), Some(mass)) = (&body.elastic, &body.mass) else { continue };
            let (q, v) = (body.body.shape.control_vertices(), body.velocity.control_vertices());
            for (i, v_i) in v.iter().enumerate() {
                let momentum = mass.matrix.row(i).fold(Vector::zeros(), |sum, (j, m)| sum + v[j].coords * m);
                all.kinetic += 0.5 * v_i.coords.dot(&momentum);
            }
            all.elastic += elastic.energy(q).0;
            all.gravity -=
                q.iter().zip(&mass.lumped).map(|(q, m)| m * q.coords.dot(&self.gravity)).sum::<f64>();
        }
        for load in self.loads.iter().filter(|load| load.acts(self.time)) {
            if let Some(body) = self.bodies.iter().find(|body| body.start == load.offset()) {
                all.pulls += load.energy(body.body.shape.control_vertices(), self.time);
            }
        }
        all
    }

    /// How much more of stretching and shearing there is in all bodies than what [`energy`](Self::energy) says, which sums it up where steps do: at as many Gauss points a
    /// span as the degree, at one more on surfaces and where spans are few. Here two rules of more points are compared, and spans halved until both say the same (of curves to 1e-4 or so); between both there is more the more stretch
    /// varies within spans. `O(n)`, and it allocates.
    ///
    /// # Errors
    /// When a shape cannot be evaluated.
    pub fn unseen_energy(&self) -> Result<f64> {
        (0..self.bodies.len()).map(|body| self.unseen(body).map(|unseen| unseen.more)).sum()
    }

    /// What steps do not see of how a body is stretched.
    pub(crate) fn unseen(&self, body: usize) -> Result<Unseen> {
        let own = self.body(body)?;
        let Moving { body, first, elastic: Some(elastic), .. } = own else { return Ok(Unseen::default()) };
        let seen = elastic.energy_of_stretching(body.shape.control_vertices());
        let more = crate::whole::stretching(body.shape.as_ref(), first, &body.material)? - seen;
        let strain = (2.0 * more.abs() / (elastic.given * elastic.size())).sqrt();
        let differs = more.abs() > UNSEEN * seen + self.rounding_of(own) && strain > SLIGHT;
        Ok(Unseen { seen, more, strain, differs })
    }

    /// What of the elastic energy of a body is in its bending. `O(n)`.
    pub(crate) fn energy_of_bending(&self, body: usize) -> Result<f64> {
        let body = self.body(body)?;
        let q = body.body.shape.control_vertices();
        Ok(body.elastic.as_ref().map_or(0.0, |elastic| elastic.energy(q).0 - elastic.energy_of_stretching(q)))
    }

    /// The largest stretch of a body (`|P'|/ℓ - 1`, with its sign) where its energy is summed up, along its parameters: cheap enough for every
    /// frame. What lies between may be [stretched more](Self::largest_stretch).
    ///
    /// # Errors
    /// When there are not as many bodies.
    pub fn stretch(&self, body: usize) -> Result<f64> {
        let body = self.body(body)?;
        let vertices = body.body.shape.control_vertices();
        Ok(body.elastic.as_ref().map_or(0.0, |elastic| elastic.energy(vertices).1))
    }

    /// The largest stretch of a body anywhere, with its sign: of a curve `|P'|/ℓ - 1`, of a surface the larger of the principal stretches, which sees shear as
    /// well. Looked for in places close together in each span, its ends among them, and from the best of these on to its peak: of peaks that show
    /// between them nothing is missed. `O(n)`, and it allocates. 0 of what stands still.
    ///
    /// # Errors
    /// When there are not as many bodies.
    pub fn largest_stretch(&self, body: usize) -> Result<f64> {
        let Moving { body, first, elastic, .. } = self.body(body)?;
        match elastic {
            Some(_) => crate::strain::largest(body.shape.as_ref(), first, body.material.rest),
            None => Ok(0.0),
        }
    }

    /// What the mass of a body may be wrong by, as a share of it: 0, or as good as that, of all that is smooth within its cells; some 1e-7 of surfaces that have creases there
    /// which run askew to their parameters. 0 of what stands still.
    ///
    /// # Errors
    /// When there are not as many bodies.
    pub fn missing_mass(&self, body: usize) -> Result<f64> {
        Ok(self.body(body)?.mass.as_ref().map_or(0.0, |mass| mass.missing))
    }

    /// How far the centre of a surface's mass is from that of its area, as it was at the start: of a tensor product mass is spread as the product of what there is in
    /// both directions, all of it but not quite where it is; 0 where the area element is such a product (parallelograms, cylinders, cones), and of curves.
    ///
    /// # Errors
    /// When there are not as many bodies, or a shape cannot be evaluated.
    pub fn off_centre(&self, body: usize) -> Result<f64> {
        let start = self.start_of(body)?;
        match &self.body(body)?.mass {
            Some(mass) => crate::mass::off_centre(start.as_ref(), mass),
            None => Ok(0.0),
        }
    }

    /// How far each constraint that holds is from what it asks, measured where things are now; what it is still let miss counts.
    ///
    /// # Errors
    /// When one cannot be asked.
    pub fn errors(&mut self) -> Result<Vec<f64>> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        let errors = self.links.iter().map(|link| {
            let own = link.first..link.first + link.equations;
            if link.is_held() { desk.gap[own].iter().map(|g| g * g).sum::<f64>().sqrt() } else { 0.0 }
        });
        let errors = errors.collect();
        self.desk = desk;
        collected.map(|()| errors)
    }
}
