//! What may be changed between steps.

use loftsman_kernel::Vector;

use super::ledger::Ledger;
use super::{Simulation, shapes};
use crate::constraint::{Hold, Target};
use crate::error::{DynamicsError, Result, check_vector};
use crate::link::{Link, Phase};
use crate::load::Kind;
use crate::path::Path;
use crate::place::{check_constraint, slide_of};

/// A path whose places are all finite, and no mistakes.
fn known(path: Path) -> Result<Path> {
    path.points().iter().try_for_each(|p| check_vector("a coordinate of a target", &p.coords))?;
    Ok(path)
}

impl Simulation {
    /// Another target for a constraint from now on: what it misses then is drawn in smoothly.
    ///
    /// # Errors
    /// When there are not as many constraints, or it is not of a point.
    pub fn retarget(&mut self, constraint: usize, to: impl Into<Path>) -> Result<()> {
        self.ledger = Ledger::default();
        let to = known(to.into())?;
        let count = self.links.len();
        let time = self.time;
        let link = self.links.get_mut(constraint).ok_or(DynamicsError::Missing {
            what: "constraint",
            index: constraint,
            count,
        })?;
        if !link.retarget(Target::Path(to)) {
            return Err(DynamicsError::Missing { what: "target of constraint", index: constraint, count });
        }
        link.begin(time);
        Ok(())
    }

    /// Another target for a pull from now on.
    ///
    /// # Errors
    /// When there are not as many pulls.
    pub fn pull_to(&mut self, pull: usize, path: impl Into<Path>) -> Result<()> {
        self.ledger = Ledger::default();
        let path = known(path.into())?;
        let mut pulls = self.loads.iter_mut().filter_map(|load| match &mut load.kind {
            Kind::Pull { to, .. } => Some(to),
            Kind::Force(_) => None,
        });
        match pulls.nth(pull) {
            Some(to) => {
                *to = path;
                Ok(())
            }
            None => {
                let count = self.loads.iter().filter(|load| matches!(load.kind, Kind::Pull { .. })).count();
                Err(DynamicsError::Missing { what: "pull", index: pull, count })
            }
        }
    }

    /// Another force from now on.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn push_with(&mut self, force: usize, value: impl Into<Vector>) -> Result<()> {
        self.ledger = Ledger::default();
        let value: Vector = value.into();
        check_vector("a force", &value)?;
        let mut forces = self.loads.iter_mut().filter_map(|load| match &mut load.kind {
            Kind::Force(own) => Some(own),
            Kind::Pull { .. } => None,
        });
        match forces.nth(force) {
            Some(own) => {
                *own = value;
                Ok(())
            }
            None => {
                let count = self.loads.iter().filter(|load| matches!(load.kind, Kind::Force(_))).count();
                Err(DynamicsError::Missing { what: "force", index: force, count })
            }
        }
    }

    /// Forces of the caller's own on a body's control vertices (three numbers each), until they are written anew: wind, contact. They are
    /// generalised ones: a force `F` at a place is `b_i F` on each vertex.
    ///
    /// # Errors
    /// When there are not as many bodies.
    pub fn applied_mut(&mut self, body: usize) -> Result<&mut [f64]> {
        self.ledger = Ledger::default();
        let range = self.body(body)?.range();
        Ok(&mut self.applied[range])
    }

    /// One more constraint from now on; its number. What it misses is drawn in smoothly.
    ///
    /// # Errors
    /// As for [`Setup::prepare`](crate::Setup::prepare).
    pub fn hold(&mut self, constraint: Hold, draw: f64) -> Result<usize> {
        self.ledger = Ledger::default();
        let constraint = Hold { from: constraint.from.max(self.time), ..constraint };
        let link = {
            let shapes = shapes(&self.bodies);
            check_constraint(&constraint, &shapes)?;
            Link::new(
                constraint,
                &shapes,
                &|body, axis| slide_of(self.bodies.get(body).map(|moving| &moving.body), axis),
                draw,
            )?
        };
        self.links.push(link);
        Ok(self.links.len() - 1)
    }

    /// A constraint holds no more.
    ///
    /// # Errors
    /// When there are not as many.
    pub fn release(&mut self, constraint: usize) -> Result<()> {
        self.ledger = Ledger::default();
        let (count, time) = (self.links.len(), self.time);
        let link = self.links.get_mut(constraint).ok_or(DynamicsError::Missing {
            what: "constraint",
            index: constraint,
            count,
        })?;
        link.phase = Phase::Off { time, why: "it was released" };
        Ok(())
    }
}
