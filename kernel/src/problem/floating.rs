//! Locations that float as unknowns beside the control vertices: `[L L_s] (d, s) = b`.

use std::sync::Arc;

use super::assembly::Parameter;
use super::known::Linear;
use super::{Assembly, Problem, view};
use crate::error::{Error, Figure, Result};
use crate::shape::Derivative;
use crate::solve::{SparseRows, Symmetric, System, SystemMetric};

impl Problem {
    /// The linear system of all that is asked, with a column behind those of the vertices for each parameter of each location that
    /// [floats](crate::functional::Functional::floats): `L_s = ∂f/∂s`, where the locations and the shapes are. `weight` is what a
    /// parameter's change costs, `½ ε ṡ²`; with 0 it is [free](System::free) and eliminated, never given a tiny weight. So the
    /// conditions of paper 3 are those of this system, `d` being accelerations and the metric the mass: with `ε` its
    /// `(L M⁻¹Lᵀ + L_s L_sᵀ/ε) λ = b`, with 0 its (11), `L M⁻¹Lᵀ λ + L_s s = b` and `L_sᵀ λ = 0`.
    ///
    /// The columns are coordinates (one side). The cost is that of [`assemble`](Self::assemble).
    ///
    /// # Errors
    /// When something cannot be asked of the shapes as they are, a functional does not know how it changes along its location, or
    /// the weight is negative or not finite; when it is positive and unknowns other than vertices are moved.
    pub fn assemble_floating(&self, weight: f64) -> Result<Assembly> {
        if !(weight >= 0.0 && weight.is_finite()) {
            return Err(Error::Invalid(format!(
                "a parameter that floats cannot have the weight {}: give 0, or a positive number",
                Figure(weight)
            )));
        }
        let shapes = view(&self.shapes);
        let constraints = self.bound.iter().map(|bound| &bound.constraint);
        let mut assembly = Assembly::beside(
            &shapes,
            constraints,
            &mut Linear::default(),
            (&self.freedom, &self.metric),
            &|_| false,
            false,
        )?;
        let mut parameters = Vec::new();
        // Of each parameter: its entry in each row.
        let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
        for (constraint, bound) in self.bound.iter().enumerate() {
            let functional = &bound.constraint.functional;
            let Some((_, location)) = functional.location().filter(|_| functional.floats()) else { continue };
            if location.is_on_face() {
                return Err(Error::Invalid(format!(
                    "{}: a location on a surface of many faces does not float yet: give \"at\"",
                    functional.describe()
                )));
            }
            for axis in 0..location.parameters() {
                let order = Derivative { u: usize::from(axis == 0), v: usize::from(axis == 1) };
                let mut along = vec![0.0; functional.equations()];
                functional.along(&shapes, order, &mut along)?;
                let slots = assembly.slots(constraint);
                columns.push(slots.iter().map(|s| (s.row as usize, along[s.equation as usize])).collect());
                parameters.push(Parameter { constraint, axis });
            }
        }
        let (system, count) = (assembly.system(), parameters.len());
        let (width, rows) = (system.rows().width(), system.rows());
        let mut more: Vec<Vec<(usize, f64)>> = vec![Vec::new(); rows.len()];
        for (k, column) in columns.into_iter().enumerate() {
            column.into_iter().for_each(|(row, value)| more[row].push((width + k, value)));
        }
        let mut all = SparseRows::with_capacity(width + count, rows.len(), rows.entries() + count);
        for (row, more) in more.into_iter().enumerate() {
            all.push(rows.iter_row(row).chain(more));
        }
        let first = 3 * shapes.vertex_count();
        let touched: Vec<usize> = system.touched().iter().copied().chain(first..first + count).collect();
        let free = if weight == 0.0 { count } else { 0 };
        let metric = if free == count {
            system.metric().clone()
        } else {
            beside(system.metric(), width, count, weight)?
        };
        assembly.system = System::new(all, touched, 1, metric).with_free(free);
        assembly.parameters = parameters;
        Ok(assembly)
    }
}

/// A metric of `width` columns with `count` more of this weight.
fn beside(metric: &SystemMetric, width: usize, count: usize, weight: f64) -> Result<SystemMetric> {
    let block = |matrix: &Symmetric, own: f64| {
        let entries =
            (0..width).flat_map(|i| matrix.row(i).filter(move |(j, _)| *j <= i).map(move |(j, v)| (i, j, v)));
        let more = (width..width + count).map(|i| (i, i, own));
        Arc::new(Symmetric::from_entries(width + count, entries.chain(more).collect::<Vec<_>>()))
    };
    let weights = |each: &mut dyn Iterator<Item = f64>| {
        SystemMetric::Weights(Arc::new(each.chain(std::iter::repeat_n(weight, count)).collect()))
    };
    Ok(match metric {
        SystemMetric::Least => weights(&mut std::iter::repeat_n(1.0, width)),
        SystemMetric::Weights(own) => weights(&mut own.iter().copied()),
        SystemMetric::Matrix(matrix) => SystemMetric::Matrix(block(matrix, weight)),
        SystemMetric::Inverse(inverse) => SystemMetric::Inverse(block(inverse, 1.0 / weight)),
        SystemMetric::Through(_) => {
            return Err(Error::Invalid(
                "a parameter with a weight cannot stand beside unknowns of one's own: give it the weight 0"
                    .into(),
            ));
        }
    })
}
