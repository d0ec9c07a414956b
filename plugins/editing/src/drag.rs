//! `drag`: an edit with a handle that follows a path, prepared once.

use loftsman_kernel::Point;
use loftsman_kernel::edit::Edit;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, put_back,
};
use loftsman_kernel::scene::{Animation, Scene, Unit};
use loftsman_kernel::shape::Shape;

use crate::problem::{Problem, SHARED, step_report};

/// The operation `drag`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Drag;

const FIELDS: [Field; SHARED.len() + 6] = {
    let own = [
        Field::required(
            "handle",
            "{ kind, …, pick = length }",
            "what is dragged; with `pick`, a place that near to an end of the curve picks the end",
        ),
        Field::required("path", "[[x, y, z], …]", "the values it takes, one event each"),
        Field::optional(
            "relative",
            "true | false",
            "false",
            "the path's values are changes of the handle's value before the drag",
        ),
        Field::optional(
            "sliding",
            "true | false",
            "false",
            "let the handle slide along with the tangential motion",
        ),
        Field::optional(
            "frames",
            "true | false",
            "false",
            "keep the start and every event as the frames of an animation",
        ),
        Field::optional("frames_per_second", "number", "24", "the rate of the animation"),
    ];
    let mut all = [own[0]; SHARED.len() + 6];
    let mut i = 0;
    while i < SHARED.len() {
        all[i] = SHARED[i];
        i += 1;
    }
    while i < all.len() {
        all[i] = own[i - SHARED.len()];
        i += 1;
    }
    all
};

impl Operation for Drag {
    fn declaration(&self) -> Declaration {
        Declaration { name: "drag", help: "an edit with a handle that follows a path", fields: &FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let problem = Problem::new(scene, parameters, context, true)?;
        let mut path = parameters.points("path")?;
        if path.is_empty() {
            return Err(parameters.error("path", "the path is empty: give at least one point").into());
        }
        if parameters.flag("relative")? {
            let start = problem.handle_value()?;
            path.iter_mut().for_each(|value| *value += start);
        }
        let rate = parameters.number_or("frames_per_second", 24.0)?;
        if rate <= 0.0 {
            return Err(parameters
                .error("frames_per_second", format!("{rate} is not a rate: give more than 0"))
                .into());
        }
        let sliding = parameters.flag("sliding")?;
        if sliding && !problem.is_curve() {
            return Err(parameters.error("sliding", "this is for curves only").into());
        }
        let keep = parameters.flag("frames")?;
        let edit = if sliding { problem.edit().sliding() } else { problem.edit() };
        let dragged = run(&problem, edit, &path, keep, scene.unit, context)?;
        let own = problem.own(&dragged.shapes);
        let after: Vec<&dyn Shape> = own.iter().map(AsRef::as_ref).collect();
        let mut report = dragged.report;
        report.notes.extend(problem.frames.note());
        report.marks = problem.marks(&after, &report.constraints);
        report.warnings.extend(problem.cut_away(scene, &after, &report.constraints));
        let mut edited = scene.clone();
        for (index, ((name, shape), frames)) in
            problem.names.iter().zip(after).zip(dragged.frames).enumerate()
        {
            put_back(&mut edited, name, shape)?;
            if keep {
                let frames = frames.iter().map(|points| problem.frames.own(index, points)).collect();
                edited.object_mut(name)?.animation = Some(Animation { rate, frames });
            }
        }
        *scene = edited;
        Ok(report)
    }
}

struct Dragged {
    shapes: Vec<Box<dyn Shape>>,
    /// The frames of each shape.
    frames: Vec<Vec<Vec<Point>>>,
    report: StepReport,
}

fn run(
    problem: &Problem,
    edit: Edit<Box<dyn Shape>>,
    path: &[Point],
    keep: bool,
    unit: Unit,
    context: &Context<'_>,
) -> Result<Dragged, OperationError> {
    let count = problem.names.len();
    let start = context.clock.seconds();
    let mut session = edit.prepare(std::sync::Arc::clone(&problem.solver))?;
    let prepare_seconds = context.clock.seconds() - start;
    let mut frames = vec![Vec::new(); count];
    if keep {
        // The starting shape is the first frame, with the knots that the edit has inserted.
        for (index, frames) in frames.iter_mut().enumerate() {
            frames.push(session.prepared_shape(index)?.control_vertices().to_vec());
        }
    }
    let mut events = Vec::with_capacity(path.len());
    for (done, &point) in path.iter().enumerate() {
        let before = context.clock.seconds();
        session.to_point(point)?;
        events.push(context.clock.seconds() - before);
        if keep {
            for (index, frames) in frames.iter_mut().enumerate() {
                frames.push(session.shape_at(index)?.control_vertices().to_vec());
            }
        }
        context.observer.proceed("drag", done as u64 + 1, path.len() as u64)?;
    }
    events.sort_by(f64::total_cmp);
    let edited = session.commit()?;
    let mut report = step_report("drag", &problem.names[0], edited.report(), unit);
    report.prepare_seconds = Some(prepare_seconds);
    report.event_seconds = Some(events[events.len() / 2]);
    let mut shapes = Vec::with_capacity(count);
    for index in 0..count {
        shapes.push(edited.shape_at(index)?.boxed());
    }
    report.asked = problem.quantities(&shapes);
    // The last frame is what stays.
    for (frames, shape) in frames.iter_mut().zip(&shapes) {
        if let Some(last) = frames.last_mut() {
            *last = shape.control_vertices().to_vec();
        }
    }
    Ok(Dragged { shapes, frames, report })
}
