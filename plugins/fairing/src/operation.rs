//! `fair`: the fairest shape that meets the constraints.

use std::sync::Arc;

use loftsman_kernel::edit::Constraint;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Mark, Operation, OperationError, ParameterError, Parameters, SceneShapes,
    SeenShapes, StepReport, ask_once, constraint_from, editable, object_name, put_back,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Solver;
use loftsman_kernel::text::figure;

use crate::energy::{Datum, EnergySum, bend, data, near, stretch, variation};
use crate::fair::{Fair, FairReport};

/// The operation `fair`.
#[derive(Debug, Clone, Copy, Default)]
pub struct FairOperation;

const FIELDS: [Field; 7] = [
    Field::optional("object", "text", "the only curve or surface", "the object to make fair"),
    Field::optional(
        "energy",
        "\"stretch\" | \"membrane\" | \"bend\" | \"thin-plate\" | \"variation\" | [{ kind, weight, points = [{ at, to, weight }, …] }, …]",
        "bend",
        "what is to be small; a sum may also have the kinds \"near\" (the old shape) and \"data\" (points)",
    ),
    Field::optional(
        "constraints",
        "[{ kind, …, to | by | scale | keep | at_least | at_most }, …]",
        "none",
        "what is asked; other objects that it names stay as they are",
    ),
    Field::optional("lock", "[index, …]", "none", "control vertices that may not move; -1 is the last"),
    Field::optional(
        "within",
        "number",
        "any distance",
        "how far no control vertex may move, so no point either",
    ),
    Field::optional(
        "smooth",
        "0 | 1 | 2",
        "1",
        "at repeated knots, what was smooth stays so: 1 tangents, 2 curvatures too, 0 corners may appear",
    ),
    Field::optional("solver", "name", "automatic", "the constraints' solver; `loftsman plugins` lists them"),
];

impl Operation for FairOperation {
    fn declaration(&self) -> Declaration {
        Declaration {
            name: "fair",
            help: "the shape of least energy that meets the constraints",
            fields: &FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let object = object_name(scene, parameters, editable(scene), "curve or surface")?;
        let mut names = SceneShapes::new(scene, &object)?;
        let tables = parameters.tables("constraints")?;
        let mut constraints = Vec::with_capacity(tables.len());
        for table in &tables {
            constraints.push(constraint_from(context.registry, table, &mut names)?);
        }
        ask_once(names.shapes(), &constraints, &tables)?;
        let solver = parameters.text_or("solver", "automatic")?;
        let solver = context.registry.find_solver(solver, &format!("{}.solver", parameters.path()))?;
        let SeenShapes { names, shapes, frames } = names.into_parts()?;
        let problem = Problem {
            energy: energy(parameters)?,
            constraints,
            lock: if parameters.has("lock") { parameters.integers("lock")? } else { Vec::new() },
            within: if parameters.has("within") { Some(parameters.number("within")?) } else { None },
            smooth: smooth(parameters)?,
            solver: Arc::clone(solver),
        };
        let start = context.clock.seconds();
        let (fair, report) = problem.solve(&shapes)?;
        let mut report = step_report(&object, &report);
        report.prepare_seconds = Some(context.clock.seconds() - start);
        // Other objects that constraints name stay as they are, and so do marks on them.
        let before: Vec<Box<dyn Shape>> =
            (0..shapes.len()).map(|index| frames.own_shape(index, shapes[index].as_ref())).collect();
        let fair = frames.own_shape(0, fair.as_ref());
        let after: Vec<&dyn Shape> =
            std::iter::once(fair.as_ref()).chain(before[1..].iter().map(AsRef::as_ref)).collect();
        let asked = &problem.constraints;
        report.marks = asked.iter().filter_map(|c| Mark::of(c, &names, &before, &after)).collect();
        report.notes.extend(frames.note());
        put_back(scene, &object, fair.as_ref())?;
        Ok(report)
    }
}

struct Problem {
    energy: EnergySum,
    constraints: Vec<Constraint>,
    lock: Vec<i64>,
    within: Option<f64>,
    smooth: u8,
    solver: Arc<dyn Solver>,
}

impl Problem {
    fn solve(&self, shapes: &[Box<dyn Shape>]) -> Result<(Box<dyn Shape>, FairReport), OperationError> {
        let mut fair = Fair::new(&shapes[0]).energy(self.energy.clone()).lock(self.lock.iter().copied());
        fair = fair.smooth(self.smooth);
        if let Some(distance) = self.within {
            fair = fair.within(distance);
        }
        for other in &shapes[1..] {
            fair = fair.with(other.boxed());
        }
        for constraint in &self.constraints {
            fair = fair.ask(constraint.clone());
        }
        let done = fair.solve_with(Arc::clone(&self.solver))?;
        let report = done.report().clone();
        Ok((done.into_shape(), report))
    }
}

fn smooth(parameters: &Parameters) -> Result<u8, ParameterError> {
    match parameters.count_or("smooth", 1)? {
        level @ 0..=2 => Ok(level as u8),
        level => Err(parameters.error("smooth", format!("{level} is not 0, 1 or 2"))),
    }
}

fn energy(parameters: &Parameters) -> Result<EnergySum, ParameterError> {
    const WORDS: [(&str, u8); 5] =
        [("stretch", 0), ("membrane", 0), ("bend", 1), ("thin-plate", 1), ("variation", 2)];
    const KINDS: [(&str, u8); 7] = [
        ("stretch", 0),
        ("membrane", 0),
        ("bend", 1),
        ("thin-plate", 1),
        ("variation", 2),
        ("near", 3),
        ("data", 4),
    ];
    let named = |word| match word {
        0 => stretch(),
        1 => bend(),
        _ => variation(),
    };
    match parameters.value("energy") {
        None => Ok(bend()),
        Some(value) if !value.is_array() => Ok(named(parameters.choice("energy", &WORDS)?)),
        Some(_) => {
            let mut sum: Option<EnergySum> = None;
            for table in parameters.tables("energy")? {
                let kind = table.choice("kind", &KINDS)?;
                let term = match kind {
                    3 => near(),
                    4 => data(points(&table)?),
                    word => named(word),
                };
                let known = ["kind", "weight", "points"].map(|name| Field::optional(name, "", "", ""));
                table.check(&known[..if kind == 4 { 3 } else { 2 }])?;
                let weight = table.number_or("weight", 1.0)?;
                if !(weight > 0.0 && weight.is_finite()) {
                    return Err(table.error("weight", "a positive number is needed"));
                }
                let term = weight * term;
                sum = Some(match sum {
                    None => term,
                    Some(sum) => sum + term,
                });
            }
            sum.ok_or_else(|| parameters.error("energy", "a sum needs at least one energy"))
        }
    }
}

fn points(table: &Parameters) -> Result<Vec<Datum>, ParameterError> {
    let known = ["at", "to", "weight"].map(|name| Field::optional(name, "", "", ""));
    let each = table.tables("points")?.into_iter().map(|point| {
        point.check(&known)?;
        let weight = point.number_or("weight", 1.0)?;
        if !(weight > 0.0 && weight.is_finite()) {
            return Err(point.error("weight", "a positive number is needed"));
        }
        Ok(Datum { at: point.location("at")?, to: point.point("to")?, weight })
    });
    each.collect()
}

fn step_report(object: &str, report: &FairReport) -> StepReport {
    let mut notes = vec![format!(
        "{}: {} → {}",
        report.energy,
        figure(report.energy_before),
        figure(report.energy_after)
    )];
    notes.extend(report.notes.iter().cloned());
    StepReport {
        op: "fair".into(),
        object: Some(object.into()),
        solver: Some(report.solver.clone()),
        equations: Some(report.equations),
        rank: Some(report.rank),
        redundant: report.redundant.clone(),
        residual: Some(report.residual),
        condition: Some(report.condition),
        adjustment: Some(report.adjustment),
        iterations: Some(report.iterations),
        active: report.active.clone(),
        constraints: report.constraints.clone(),
        smooth: Some(report.smooth.clone()).filter(|smooth| !smooth.is_empty()),
        energy: Some([report.energy_before, report.energy_after]),
        notes,
        ..StepReport::default()
    }
}
