//! Forces at places, and pulls: damped springs to where somebody holds them.

use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Derivative, Location, Stencil};
use loftsman_kernel::solve::RangeSpace;
use loftsman_kernel::{Point, Vector};

use crate::constraint::{Force, Pull};
use crate::error::{Result, check, check_vector};
use crate::path::Path;

/// A force at a place that stays on its shape.
#[derive(Debug)]
pub(crate) struct Load {
    pub(crate) body: usize,
    pub(crate) at: Location,
    offset: usize,
    stencil: Stencil,
    pub(crate) kind: Kind,
    from: f64,
    until: f64,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Force(Vector),
    Pull {
        to: Path,
        stiffness: f64,
        damping: f64,
        /// `b M⁻¹ bᵀ`: what a unit force there accelerates.
        mobility: f64,
    },
}

impl Load {
    pub(crate) fn force(force: Force, shapes: &Shapes<'_>) -> Result<Self> {
        let Force { body, at, force, from, until, .. } = force;
        check_vector("a force", &force)?;
        let stencil = shapes.get(body)?.stencil(at, Derivative::POSITION)?;
        Ok(Self { body, at, offset: shapes.offset(body), stencil, kind: Kind::Force(force), from, until })
    }

    pub(crate) fn pull(pull: Pull, shapes: &Shapes<'_>, space: &mut RangeSpace) -> Result<Self> {
        let Pull { body, at, to, stiffness, from, until, .. } = pull;
        check("the stiffness of a pull", stiffness, false)?;
        to.points().iter().try_for_each(|p| check_vector("a coordinate of a pull's target", &p.coords))?;
        let stencil = shapes.get(body)?.stencil(at, Derivative::POSITION)?;
        let kind = Kind::Pull { to, stiffness, damping: 0.0, mobility: 0.0 };
        let mut pull = Self { body, at, offset: shapes.offset(body), stencil, kind, from, until };
        pull.refit(shapes, space)?;
        Ok(pull)
    }

    /// Prepares it for shapes as they are now, which may have other knots; `space` being that of their masses.
    pub(crate) fn refit(&mut self, shapes: &Shapes<'_>, space: &mut RangeSpace) -> Result<()> {
        self.stencil = shapes.get(self.body)?.stencil(self.at, Derivative::POSITION)?;
        self.offset = shapes.offset(self.body);
        let Self { stencil, offset, kind: Kind::Pull { stiffness, damping, mobility, .. }, .. } = self else {
            return Ok(());
        };
        let mut x = vec![0.0; 3 * space.vertices()];
        stencil.iter().for_each(|(v, c)| x[3 * (*offset + v)] += c);
        space.clear();
        space.float(0, 0.0);
        space.factor();
        space.solve(&mut x, &[], &mut [], &mut []);
        *mobility = stencil.iter().map(|(v, c)| c * x[3 * (*offset + v)]).sum();
        // Critically damped, for the mass that is felt there.
        *damping = if *mobility > 0.0 { 2.0 * (*stiffness / *mobility).sqrt() } else { 0.0 };
        Ok(())
    }

    /// `ω²` of a pull: of its spring on the mass that is felt there.
    pub(crate) fn frequency(&self) -> f64 {
        match self.kind {
            Kind::Force(_) => 0.0,
            Kind::Pull { stiffness, mobility, .. } => stiffness * mobility,
        }
    }

    /// When it comes and goes.
    pub(crate) fn times(&self) -> [f64; 2] {
        [self.from, self.until]
    }

    pub(crate) fn acts(&self, time: f64) -> bool {
        (self.from..self.until).contains(&time)
    }

    fn value(&self, of: &[Point]) -> Vector {
        self.stencil.iter().fold(Vector::zeros(), |sum, (v, c)| sum + of[v].coords * c)
    }

    /// Adds it to the forces, three numbers a vertex through all bodies; `q` and `v` are its own body's. Where time stands `still`, so does the
    /// target of a pull.
    pub(crate) fn add(&self, q: &[Point], v: &[Point], time: f64, still: bool, out: &mut [f64]) {
        let force = match &self.kind {
            Kind::Force(force) => *force,
            Kind::Pull { to, stiffness, damping, .. } => {
                let [place, rate, _] = to.at(time);
                let rate = if still { Vector::zeros() } else { rate };
                (place - self.value(q)) * *stiffness + (rate - self.value(v)) * *damping
            }
        };
        for (vertex, c) in self.stencil.iter() {
            let out = &mut out[3 * (self.offset + vertex)..][..3];
            out.iter_mut().zip(force.iter()).for_each(|(out, f)| *out += c * f);
        }
    }

    /// Adds `factor` times its stiffness and `rate` times its damping, entry by entry of the lower triangle, by coordinates of all bodies.
    pub(crate) fn add_stiffness(&self, factor: f64, rate: f64, mut add: impl FnMut(usize, usize, f64)) {
        let Kind::Pull { stiffness, damping, .. } = self.kind else { return };
        let scale = factor * stiffness + rate * damping;
        for (i, a) in self.stencil.iter() {
            for (j, b) in self.stencil.iter().take_while(|(j, _)| *j <= i) {
                for axis in 0..3 {
                    add(3 * (self.offset + i) + axis, 3 * (self.offset + j) + axis, scale * a * b);
                }
            }
        }
    }

    /// How strong it is, of a pull where its own body's vertices are `q`.
    pub(crate) fn strength(&self, q: &[Point], time: f64) -> f64 {
        match &self.kind {
            Kind::Force(force) => force.norm(),
            Kind::Pull { to, stiffness, .. } => stiffness * (to.at(time)[0] - self.value(q)).norm(),
        }
    }

    /// The energy in its spring.
    pub(crate) fn energy(&self, q: &[Point], time: f64) -> f64 {
        match &self.kind {
            Kind::Pull { to, stiffness, .. } => {
                0.5 * stiffness * (to.at(time)[0] - self.value(q)).norm_squared()
            }
            Kind::Force(_) => 0.0,
        }
    }

    /// What it would do on the way from the origin: of a force `-F·P`, of a pull the energy in its spring.
    pub(crate) fn potential(&self, q: &[Point], time: f64) -> f64 {
        match &self.kind {
            Kind::Force(force) => -force.dot(&self.value(q)),
            Kind::Pull { .. } => self.energy(q, time),
        }
    }

    /// The force, where it stays as it is.
    pub(crate) fn constant(&self) -> Option<Vector> {
        match self.kind {
            Kind::Force(force) => Some(force),
            Kind::Pull { .. } => None,
        }
    }

    /// Whether it does work from outside: it comes, goes, or draws to a place that moves.
    pub(crate) fn feeds(&self) -> bool {
        let moves = matches!(&self.kind, Kind::Pull { to, .. } if to.points().len() > 1);
        moves || self.from > 0.0 || self.until.is_finite()
    }

    /// Whether it draws to a place.
    pub(crate) fn is_pull(&self) -> bool {
        matches!(self.kind, Kind::Pull { .. })
    }

    /// Whose it is, by where its vertices start.
    pub(crate) fn offset(&self) -> usize {
        self.offset
    }
}
