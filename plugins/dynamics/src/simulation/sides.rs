//! How much a curve is stretched on both sides of a place that slides.

use loftsman_kernel::shape::{Location, cells_of};

use super::Simulation;
use crate::error::Result;
use crate::points::order;

/// Gauss points more than its degree in each span: a span that turns sharply is no polynomial of low degree in its length.
const MORE: usize = 24;

impl Simulation {
    /// Of each place of a constraint that slides along a curve that moves: the mean stretch of its two sides, behind and ahead (to smaller parameters and to
    /// larger ones), `L / L₀ - 1` of the length `L` from there to the next place of the curve that a constraint holds or where a force or pull acts, or to its end, and the length `L₀` of
    /// that part at rest. Without weight, bending and motion both are the same where a rope may slide freely, to what half a span is of the sides (a spline turns
    /// within a span, not at a point); weight makes the higher side the tauter one. 0 of a side without length. `O(n)` for `n` control vertices.
    ///
    /// # Errors
    /// When there are not as many constraints.
    pub fn side_stretches(&self, constraint: usize) -> Result<Vec<[f64; 2]>> {
        let link = self.link(constraint)?;
        let mut all = Vec::new();
        for place in link.places.iter().filter(|place| place.floats && link.is_held()) {
            let (Location::Curve(at), moving) = (place.location, &self.bodies[place.body]) else { continue };
            if moving.mass.is_none() {
                continue;
            }
            let [behind, ahead] = self.ways(place.body, at)?;
            all.push([
                self.stretch_between(place.body, at - behind, at)?,
                self.stretch_between(place.body, at, at + ahead)?,
            ]);
        }
        Ok(all)
    }

    /// How far it is along a curve, in parameters, from a place to the next on both sides where a constraint holds it or a force or pull acts, or to its end: behind
    /// and ahead.
    pub(super) fn ways(&self, body: usize, at: f64) -> Result<[f64; 2]> {
        let Some(interval) = self.bodies[body].body.interval(0) else {
            return Ok([0.0; 2]);
        };
        let whole = interval.end - interval.start;
        // Where it is held, as ways from here: of what is closed, round the seam.
        let held = self.links.iter().filter(|link| link.is_held()).flat_map(|link| &link.places);
        let loads = self.loads.iter().filter(|load| load.acts(self.time)).map(|load| (load.body, load.at));
        let others = held.map(|other| (other.body, other.location)).chain(loads);
        let others = others.filter(|other| other.0 == body).filter_map(|other| match other.1 {
            Location::Curve(u) if u != at => Some(u - at),
            _ => None,
        });
        let (mut behind, mut ahead) = match interval.periodic {
            true => (whole, whole),
            false => (at - interval.start, interval.end - at),
        };
        for way in others {
            if interval.periodic {
                (behind, ahead) = (behind.min((-way).rem_euclid(whole)), ahead.min(way.rem_euclid(whole)));
            } else if way < 0.0 {
                behind = behind.min(-way);
            } else {
                ahead = ahead.min(way);
            }
        }
        Ok([behind, ahead])
    }

    /// The strain that a side has where it ends, at the first of these parameters: of each place between `at` and `to` what it would be at `at`, taken together by their
    /// lengths at rest. Along a rope that does not bend and that nothing but its weight acts on tension grows by what height takes, `(1 + ε) dT = -m g·dP` with the mass `m` of a length at
    /// rest, or `(1 + ε)² k/2 + m g·P` is the same all along,
    /// so that it does not matter from what place it is seen; where spans are too long to be strained as evenly as a rope is, all of them have their say. Without weight it is
    /// the mean stretch. `O(n)`.
    pub(super) fn strain_at_end(&self, body: usize, at: f64, to: f64) -> Result<f64> {
        let moving = &self.bodies[body];
        let (shape, material) = (moving.body.shape.as_ref(), &moving.body.material);
        let here = self.wrapped(body, at);
        let here = shape.value(Location::Curve(here), order(0, 0))?;
        let (mut strained, mut whole) = (0.0, 0.0);
        self.between(body, at.min(to), at.max(to), |place, weight| {
            let stencil = shape.stencil(place, order(0, 1))?;
            let [now, first] =
                [shape.control_vertices(), &moving.first].map(|points| stencil.apply(points).norm());
            let rest = first * material.rest;
            let above = -self.gravity.dot(&(here - shape.value(place, order(0, 0))?));
            let by = 2.0 * above * material.mass / (material.rest * material.stiffness);
            let ratio = if rest > 0.0 { now / rest } else { 1.0 };
            strained += weight * rest * ((ratio * ratio + by).max(0.0).sqrt() - 1.0);
            whole += weight * rest;
            Ok(())
        })?;
        Ok(if whole > 0.0 { strained / whole } else { 0.0 })
    }

    /// The mean stretch of a curve between two parameters, which may be beyond the seam of a closed one by less than its whole domain.
    pub(super) fn stretch_between(&self, body: usize, from: f64, to: f64) -> Result<f64> {
        let moving = &self.bodies[body];
        let shape = moving.body.shape.as_ref();
        let (mut now, mut rest) = (0.0, 0.0);
        self.between(body, from, to, |at, weight| {
            let stencil = shape.stencil(at, order(0, 1))?;
            now += weight * stencil.apply(shape.control_vertices()).norm();
            rest += weight * stencil.apply(&moving.first).norm();
            Ok(())
        })?;
        let rest = rest * moving.body.material.rest;
        Ok(if rest > 0.0 { now / rest - 1.0 } else { 0.0 })
    }

    /// Gauss points, with their weights, of the spans of a curve between two parameters, which may be beyond the seam of a closed one by less than its whole domain.
    fn between(
        &self,
        body: usize,
        from: f64,
        to: f64,
        mut each: impl FnMut(Location, f64) -> Result<()>,
    ) -> Result<()> {
        let shape = self.bodies[body].body.shape.as_ref();
        let whole = shape.domain().first().map_or(0.0, |interval| interval.end - interval.start);
        for cell in cells_of(shape, "a stretch")?.checked(shape)? {
            let Some(side) = cell.sides.first().copied() else { continue };
            for turn in [-whole, 0.0, whole] {
                let mut part = cell.clone();
                let own = &mut part.sides[0];
                (own.start, own.end) = (side.start.max(from - turn), side.end.min(to - turn));
                if own.start >= own.end {
                    continue;
                }
                for (at, weight) in part.gauss_points([side.degree + MORE, 0]) {
                    each(at, weight)?;
                }
            }
        }
        Ok(())
    }
}
