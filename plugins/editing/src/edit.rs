//! `edit`: the least adjustment that meets the constraints.

use std::any::Any;

use loftsman_kernel::brep::Brep;
use loftsman_kernel::edit::{Edit, Report};
use loftsman_kernel::plugin::{
    Context, Declaration, Operation, OperationError, Parameters, StepReport, put_back,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::{Location, Shape};

use crate::furthest::far_beyond;
use crate::passages::passages;
use crate::paths::paths;
use crate::problem::{Problem, SHARED, step_report};

/// The operation `edit`.
#[derive(Debug, Clone, Copy, Default)]
pub struct EditOperation;

impl Operation for EditOperation {
    fn declaration(&self) -> Declaration {
        Declaration { name: "edit", help: "the least adjustment that meets the constraints", fields: &SHARED }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let problem = Problem::new(scene, parameters, context, false)?;
        if problem.constraints.is_empty() {
            let text = "nothing is asked, so nothing would change: give at least one constraint";
            return Err(parameters.error("constraints", text).into());
        }
        let solved = run(&problem, problem.edit(), context)?;
        let own = problem.own(&solved.shapes);
        let after: Vec<&dyn Shape> = own.iter().map(AsRef::as_ref).collect();
        let mut report = step_report("edit", &problem.names[0], &solved.report, scene.unit);
        report.asked = problem.quantities(&solved.shapes);
        report.prepare_seconds = Some(solved.prepare_seconds);
        report.event_seconds = Some(solved.event_seconds);
        report.notes.extend(problem.frames.note());
        report.marks = problem.marks(&after, &report.constraints);
        report.warnings.extend(problem.cut_away(scene, &after, &report.constraints));
        let mut edited = scene.clone();
        for (index, (name, shape)) in problem.names.iter().zip(after).enumerate() {
            let any: &dyn Any = shape;
            let (Geometry::Brep(before), Some(brep)) =
                (scene.object(name)?.geometry(), any.downcast_ref::<Brep>())
            else {
                put_back(&mut edited, name, shape)?;
                continue;
            };
            let brep = brep.without_spare_knots()?;
            let scale = scene.standing(name).map_or(1.0, |standing| standing.most());
            let places = problem.constraints.iter().filter_map(|constraint| {
                match constraint.functional().location() {
                    Some((on, Location::Face(face, u, v))) if on == index => Some((face, [u, v])),
                    _ => None,
                }
            });
            let paths = paths(before, &brep, &places.collect::<Vec<_>>());
            let asked = (index, &problem.constraints[..]);
            report.warnings.extend(far_beyond(before, &brep, &paths, asked, scale, scene.unit));
            report.warnings.extend(passages(before, &brep, &paths, scale, scene.unit));
            put_back(&mut edited, name, &brep)?;
        }
        *scene = edited;
        Ok(report)
    }
}

struct Solved {
    shapes: Vec<Box<dyn Shape>>,
    report: Report,
    prepare_seconds: f64,
    event_seconds: f64,
}

fn run(
    problem: &Problem,
    edit: Edit<Box<dyn Shape>>,
    context: &Context<'_>,
) -> Result<Solved, OperationError> {
    let start = context.clock.seconds();
    let mut session = edit.prepare(std::sync::Arc::clone(&problem.solver))?;
    let prepared = context.clock.seconds();
    session.apply()?;
    let event_seconds = context.clock.seconds() - prepared;
    let edited = session.commit()?;
    let mut shapes = Vec::with_capacity(problem.names.len());
    for index in 0..problem.names.len() {
        shapes.push(edited.shape_at(index)?.boxed());
    }
    Ok(Solved { shapes, report: edited.report().clone(), prepare_seconds: prepared - start, event_seconds })
}
