//! What is handed out, measured afresh.

use loftsman_kernel::shape::Shape;
use loftsman_kernel::{Point, Vector, parallel};

use super::descent::{Descended, Run};
use super::model::value;
use super::near::Near;
use super::turned::{Turned, turned};
use super::{CloudFitted, CloudReport};
use crate::error::{FitError, Result};

/// Energies outweigh points where these are off by more than so much of their own distance from their centre, and little of the size is left.
const LITTLE: f64 = 0.25;
const FEW: f64 = 0.5;
/// Points that are off by no more than this part of the size are met.
const MET: f64 = 1e-6;

impl<S: Shape + Clone> Run<'_, S> {
    /// How far shapes with these control vertices lie from the nearest point, at most.
    fn beyond(&self, shapes: [&[Point]; 2]) -> [f64; 2] {
        let near = Near::new(&self.points);
        shapes.map(|vertices| {
            let places = self.patches.points(vertices);
            let away = parallel::map(places.len(), |k| near.distance(&places[k]));
            away.into_iter().fold(0.0, f64::max)
        })
    }

    /// Where a surface looks the other way than the one that was given.
    pub(super) fn turned(&self, shape: &S) -> Result<Turned> {
        let (given, cancelled) = (self.asked.shape.as_shape(), || self.observer.cancelled());
        turned(&self.patches, given, shape.control_vertices(), &cancelled)?.ok_or(FitError::Cancelled)
    }

    /// Whether energies of given weights leave little to the points.
    fn outweighed(&self, report: &CloudReport) -> bool {
        let sum = |of: &dyn Fn(&Point) -> Vector| -> Vector {
            self.points.iter().zip(&self.shares).map(|(p, share)| of(p) * *share).sum()
        };
        let center = sum(&|p| p.coords);
        let spread = sum(&|p| (p.coords - center).map(|c| c * c)).sum().sqrt();
        let [was, is] = report.measure;
        let less = report.rms > report.before || is < FEW * was;
        !self.asked.energies.is_empty() && report.rms > LITTLE * spread && less
    }

    /// What was found, measured.
    pub(super) fn hand_out(&self, descended: Descended<S>) -> Result<CloudFitted<S>> {
        let Descended { state, mut report, multipliers, .. } = descended;
        // What is handed out is measured afresh; a foot that was known stays where nothing nearer is found.
        let known = state.feet;
        let mut state = self.state(state.shape, None)?;
        for (foot, known) in state.feet.iter_mut().zip(known) {
            if known.distance < foot.distance {
                *foot = known;
            }
        }
        let shapes = self.among(&state.shape);
        let assembly = self.nearest.assembly();
        self.problem.verify(assembly, &shapes, self.solver.name())?;
        let missing = self.problem.misfit(assembly, &shapes)?;
        let multipliers: Vec<f64> = multipliers.iter().map(|m| 2.0 * m).collect();
        report.constraints = self.problem.account(assembly, &missing, &multipliers);
        report.residual = report.constraints.iter().fold(0.0, |m: f64, c| m.max(c.residual));
        let (squares, energy) =
            value(&state.feet, &self.shares, &self.energies, &self.relative(&state.shape));
        (report.rms, report.energy) = (squares.sqrt(), energy);
        for (k, foot) in state.feet.iter().enumerate() {
            if foot.distance > report.largest {
                (report.largest, report.worst) = (foot.distance, k);
            }
        }
        report.measure = [self.measure(&self.asked.shape), self.measure(&state.shape)];
        report.beyond = self.beyond([self.asked.shape.control_vertices(), state.shape.control_vertices()]);
        report.turned = self.turned(&state.shape)?;
        report.outweighed = self.outweighed(&report);
        // A distance from a surface is one number, from a curve two.
        let numbers = self.points.len() * 3_usize.saturating_sub(state.shape.domain().len());
        report.few = numbers <= 3 * self.held.free.len();
        report.met = report.few && report.largest <= MET * self.size();
        report.solver = self.nearest.solver().to_owned();
        (report.equations, report.rank) = (self.nearest.equations(), self.nearest.rank());
        report.redundant = self.nearest.redundant().to_vec();
        let ways = state.shape.control_vertices().iter().zip(self.asked.shape.control_vertices());
        report.adjustment = ways.map(|(a, b)| (a - b).norm()).fold(0.0, f64::hypot);
        let feet = state.feet.iter().map(|foot| foot.at).collect();
        Ok(CloudFitted { shape: state.shape, feet, report })
    }
}
