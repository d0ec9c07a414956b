//! What nothing holds: directions in which something may go for ever, and weight or forces draw it there.
//!
//! Forces that stay as they are work without end along translations alone: what is shaped otherwise resists, what turns comes round. A
//! translation `t` of each body is allowed where no constraint sees it, `Σ (Σ_i a_i) · t = 0` over the bodies of each equation; a place that slides holds
//! until it leaves its shape. Of all forces on the bodies, what is left when the allowed part is taken out by Gram and Schmidt is nothing, or the
//! way down.

use loftsman_kernel::Vector;

use super::Simulation;
use crate::error::{DynamicsError, Result};

/// What is left of vectors below this share of them is rounding.
const ROUNDING: f64 = 1e-9;

impl Simulation {
    /// A body that nothing holds where its weight or a force draws it, and the direction of that: constraints that hold now, and pulls, are asked.
    /// `None` where everything can come to rest. `O(m²)` for `m` equations.
    ///
    /// # Errors
    /// When constraints cannot be asked.
    pub fn unheld(&mut self) -> Result<Option<(usize, Vector)>> {
        let mut desk = std::mem::take(&mut self.desk);
        let collected = self.collect(&mut desk);
        self.desk = desk;
        collected?;
        Ok(self.unheld_by_rows())
    }

    /// The same, by the rows that were collected last.
    pub(super) fn unheld_by_rows(&self) -> Option<(usize, Vector)> {
        let moving: Vec<usize> = (0..self.bodies.len()).filter(|&k| self.bodies[k].mass.is_some()).collect();
        let width = 3 * moving.len();
        let mut left = self.drawn(&moving);
        let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let whole = norm(&left);
        if whole == 0.0 || !whole.is_finite() {
            return None;
        }
        let mut of = vec![None; self.space.vertices()];
        for (own, &body) in moving.iter().enumerate() {
            let body = &self.bodies[body];
            of[body.start..body.start + body.count()].fill(Some(own));
        }
        let mut rows = vec![(vec![0.0; width], vec![0.0_f64; width]); self.space.equations()];
        self.space.entries(|equation, coordinate, value| {
            if let Some(own) = of[coordinate / 3] {
                let (row, sizes) = &mut rows[equation];
                row[3 * own + coordinate % 3] += value;
                sizes[3 * own + coordinate % 3] += value.abs();
            }
        });
        for load in self.loads.iter().filter(|load| load.is_pull() && load.acts(self.time)) {
            if let Some(own) = moving.iter().position(|&body| self.bodies[body].start == load.offset()) {
                for axis in 0..3 {
                    let mut row = vec![0.0; width];
                    row[3 * own + axis] = 1.0;
                    rows.push((row.clone(), row));
                }
            }
        }
        let mut seen: Vec<Vec<f64>> = Vec::new();
        for (mut row, sizes) in rows {
            let size = norm(&sizes);
            // Twice, for what rounding leaves.
            for _ in 0..2 {
                for other in &seen {
                    let by: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                    row.iter_mut().zip(other).for_each(|(a, b)| *a -= by * b);
                }
            }
            let length = norm(&row);
            if length > ROUNDING * size {
                row.iter_mut().for_each(|a| *a /= length);
                let by: f64 = row.iter().zip(&left).map(|(a, b)| a * b).sum();
                left.iter_mut().zip(&row).for_each(|(left, a)| *left -= by * a);
                seen.push(row);
            }
            if seen.len() == width {
                return None;
            }
        }
        // The first of those that go alike.
        let ways: Vec<Vector> = left.chunks_exact(3).map(Vector::from_column_slice).collect();
        let most = ways.iter().fold(0.0_f64, |most, way| most.max(way.norm()));
        let (own, way) = ways.iter().enumerate().find(|(_, way)| way.norm() >= 0.999 * most)?;
        (way.norm() > ROUNDING * whole).then(|| (moving[own], way.normalize()))
    }

    /// Where weight, forces and those of the caller draw each of these bodies: three numbers each.
    fn drawn(&self, moving: &[usize]) -> Vec<f64> {
        let mut all = Vec::with_capacity(3 * moving.len());
        for &index in moving {
            let body = &self.bodies[index];
            let mass: f64 = body.mass.iter().flat_map(|mass| &mass.lumped).sum();
            let mut whole = self.gravity * mass;
            let own = |load: &&crate::load::Load| load.acts(self.time) && load.offset() == body.start;
            whole += self.loads.iter().filter(own).filter_map(|load| load.constant()).sum::<Vector>();
            for force in self.applied[body.range()].chunks_exact(3) {
                whole += Vector::from_column_slice(force);
            }
            all.extend_from_slice(whole.as_slice());
        }
        all
    }

    /// # Errors
    /// Naming what nothing holds, and what let it go.
    pub(super) fn check_held(&self) -> Result<()> {
        let Some((body, way)) = self.unheld_by_rows() else { return Ok(()) };
        let gone = self.links.iter().filter_map(|link| Some((&link.name, link.phase.gone()?)));
        let let_go = gone.map(|(name, why)| format!("\"{name}\": {why}")).collect();
        Err(DynamicsError::Unheld { body: self.bodies[body].body.name.clone(), way, let_go })
    }
}
