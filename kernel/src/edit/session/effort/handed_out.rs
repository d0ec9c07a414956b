//! What was found, as reports and the next event take it.

use super::super::Session;
use super::super::strategy::Strategy;
use super::squares::amax;
use super::{MET, Search};
use crate::edit::report::Convergence;
use crate::problem::program::Bounds;
use crate::problem::{EditError, Numbers};
use crate::shape::Shape;
use crate::solve::Sense;

impl<S: Shape> Session<S> {
    /// What was found, with the rows that nothing contradicts met to rounding, for reports and for the next event.
    pub(super) fn hand_out(&mut self, search: Search) -> Result<(), EditError> {
        let Search { squares, at, steps, shortened, slope, .. } = search;
        let mut here = self.linearize_at(&at)?;
        let lengths = |rhs: &[f64]| -> Vec<f64> {
            rhs.iter().enumerate().map(|(entry, rhs)| squares.length(entry, *rhs)).collect()
        };
        let missed = lengths(&here.rhs);
        let equal = |row: usize| squares.senses[row] == Sense::Equal;
        let pulls = squares.forces.iter().any(|force| *force > 0.0);
        let largest = missed.iter().enumerate().map(|(entry, miss)| {
            if equal(entry / squares.sides) {
                miss.abs()
            } else {
                squares.given[entry] * squares.weights[entry / squares.sides]
            }
        });
        let slight = MET[0] * largest.fold(0.0, f64::max) + MET[1] * amax(&at.d);
        let of = |row: usize| row * squares.sides..(row + 1) * squares.sides;
        let active: Vec<usize> = (0..squares.senses.len())
            .filter(|&row| !equal(row) && of(row).any(|entry| missed[entry] >= -slight))
            .collect();
        // Bounds that are touched hold to rounding, on whichever side of them the search has stopped; one that pulls does, whatever the search has left.
        let met: Vec<usize> = (0..squares.senses.len())
            .filter(|&row| {
                let pulled = of(row).any(|entry| squares.forces[entry] > 0.0);
                of(row).all(|entry| (pulled || missed[entry].abs() <= slight) && squares.given[entry] == 0.0)
            })
            .collect();
        for _ in 0..4 {
            let part = here.assembly.select(&met);
            let mut factored = self.solver.factor(&part.system)?;
            let rhs: Numbers = met.iter().flat_map(|&row| of(row)).map(|entry| here.rhs[entry]).collect();
            let mut d = vec![0.0; at.d.len()];
            factored.solve_into(&rhs, &mut d);
            // More than what the search left is not rounding: what it would meet depends on what cannot hold.
            if !(pulls || amax(&d) <= 1e3 * (slight + MET[1] * self.prepared.check.reach)) {
                break;
            }
            self.prepared.d.iter_mut().zip(&d).for_each(|(to, d)| *to += d);
            self.place();
            here = self.linearize()?;
            if amax(&d) <= f64::EPSILON * self.prepared.check.reach {
                break;
            }
        }
        let mut wanted = Numbers::from_elem(0.0, here.rhs.len());
        here.assembly.system.rows().multiply(&self.prepared.d, squares.sides, &mut wanted);
        wanted.iter_mut().zip(&here.rhs).for_each(|(w, b)| *w += b);
        let kept: Vec<usize> = (0..squares.senses.len())
            .filter(|row| equal(*row) || active.binary_search(row).is_ok())
            .collect();
        let part = here.assembly.select(&kept);
        let factored = self.solver.factor(&part.system)?;
        let dependencies = factored.diagnosis().dependencies;
        let gather = |all: &[f64]| -> Numbers {
            kept.iter().flat_map(|&row| of(row)).map(|entry| all[entry]).collect()
        };
        let prepared = self.prepared.as_mut();
        (prepared.rhs, prepared.size) = (gather(&wanted), gather(&here.size));
        (prepared.factored, prepared.dependencies, prepared.assembly) = (factored, dependencies, part);
        let bounds = Bounds { full: here.assembly, rhs: wanted, size: here.size, active };
        match &mut prepared.strategy {
            Strategy::Bounded(own) => own.active = bounds.active,
            strategy => {
                let bounded = squares.senses.iter().any(|sense| *sense != Sense::Equal);
                *strategy = Strategy::Sequential(bounded.then(|| Box::new(bounds)));
            }
        }
        prepared.iterations = steps.max(1);
        prepared.convergence = Some(Convergence { iterations: steps, shortened, change: slope });
        prepared.gave_way = true;
        Ok(())
    }
}
