//! `simulate`: a shape in motion; the last shape stays in the object, and the frames as its animation.

mod constraints;
mod creases;
mod declared;
mod folds;
mod gravity;
mod marks;
mod material;
mod report;
mod run;
mod seams;

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{
    Context, Declaration, Operation, OperationError, Parameters, StepReport, Table, editable, object_name,
    put_back,
};
use loftsman_kernel::scene::{Animation, Scene};
use loftsman_kernel::shape::{Shape, refine_of};
use loftsman_kernel::text::{figure, short};

use self::declared::{FIELDS, TABLES};
use self::marks::Spots;
use self::report::report;
use self::run::Run;
use self::seams::Seams;
use crate::error::DynamicsError;
use crate::simulation::{Audit, Corner, Simulation};

/// The operation `simulate`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Simulate;

/// More steps than this for one frame would take minutes.
const MOST_STEPS: f64 = 5e4;
/// What ends stretched to more than so many times its length was pulled by mistake.
const TORN: f64 = 1e3;
/// A rise of energy of no more than so many percent is rounding.
const NO_RISE: f64 = 1e-10;

impl Operation for Simulate {
    fn declaration(&self) -> Declaration {
        Declaration {
            name: "simulate",
            help: "a curve or surface in motion, held by constraints that slide",
            fields: &FIELDS,
        }
    }

    fn tables(&self) -> &'static [Table] {
        &TABLES
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let object = object_name(scene, parameters, editable(scene), "curve or surface")?;
        let run = Run::new(scene, parameters, context, &object)?;
        let start = context.clock.seconds();
        let mut simulation = run.setup.prepare().map_err(|error| blamed(error, parameters, &run.asked))?;
        let prepare_seconds = context.clock.seconds() - start;
        let stable = simulation.stable_step();
        if run.frames > 0 && run.scheme != "implicit" && 1.0 / (run.rate * stable) > MOST_STEPS {
            let step = 1.0 / run.rate;
            return Err(DynamicsError::TooStiff { needed: (step / stable).ceil(), step, stable }.into());
        }
        let before = simulation.energy().total();
        let count = run.names.len();
        let seams = (0..count).map(|index| Ok(Seams::of(simulation.shape(index)?)));
        let seams: Vec<Seams> = seams.collect::<Result<_, OperationError>>()?;
        let mut frames: Vec<Vec<Vec<Point>>> = vec![Vec::new(); count];
        let mut spots = Spots::default();
        let mut keep =
            |simulation: &Simulation, frames: &mut Vec<Vec<Vec<Point>>>| -> Result<(), OperationError> {
                for (index, frames) in frames.iter_mut().enumerate() {
                    frames.push(simulation.shape(index)?.control_vertices().to_vec());
                }
                spots.keep(simulation)
            };
        let mut stretch = simulation.stretch(0)?;
        let mut audit = (run.frames > 0 && !simulation.is_fed()).then(Audit::default);
        if let Some(audit) = &mut audit {
            audit.look(&mut simulation);
        }
        let started = context.clock.seconds();
        if run.frames > 0 {
            keep(&simulation, &mut frames)?;
            for frame in 0..run.frames {
                simulation.advance(1.0 / run.rate)?;
                keep(&simulation, &mut frames)?;
                stretch = wider(stretch, simulation.stretch(0)?);
                if let Some(audit) = &mut audit {
                    audit.look(&mut simulation);
                    if audit.is_broken() {
                        return Err(simulation.risen(audit.rise()).into());
                    }
                }
                context.observer.proceed("simulate", frame as u64 + 1, run.frames as u64)?;
            }
        }
        let steps = simulation.sub_steps();
        let event_seconds = (context.clock.seconds() - started) / steps.max(1) as f64;
        let settled = if run.settle {
            context.observer.proceed("settle", 0, 1)?;
            let settled =
                if run.corners { simulation.settle()? } else { simulation.settle_without_corners()? };
            let corners = simulation.corners();
            for (index, frames) in frames.iter_mut().enumerate() {
                let knots = inserted(corners, index);
                if !knots.is_empty() {
                    refine_frames(run.first[index].as_ref(), &knots, frames)?;
                }
            }
            if run.frames > 0 && run.settle_frames {
                keep(&simulation, &mut frames)?;
            }
            Some(settled)
        } else {
            None
        };
        for (index, name) in run.names.iter().enumerate() {
            // Of a surface where energy is summed up: at a pole, which opens as it deforms, there is no bound to it.
            let stretch = match simulation.shape(index)?.domain().len() {
                1 => simulation.largest_stretch(index)?,
                _ => simulation.stretch(index)?,
            };
            if stretch > TORN {
                return Err(DynamicsError::Torn {
                    body: name.clone(),
                    stretch,
                    time: simulation.time(),
                    stable,
                }
                .into());
            }
        }
        let mut report = report(
            &object,
            &mut simulation,
            settled,
            (before, stretch, stable),
            &run.scheme,
            (&run.seen, scene.unit),
        )?;
        report.prepare_seconds = Some(prepare_seconds);
        report.event_seconds = (steps > 0).then_some(event_seconds);
        if let Some(audit) = audit {
            let rise = 100.0 * audit.rise();
            report.notes.push(if audit.is_noise() {
                "nothing was put in, and nothing moves or is stretched but by rounding".into()
            } else if rise <= NO_RISE {
                "nothing was put in, and energy never rose".into()
            } else {
                format!(
                    "nothing was put in, and energy rose by {} % of what moved and was stretched at most",
                    short(rise)
                )
            });
        }
        for (index, (seams, name)) in seams.iter().zip(&run.names).enumerate() {
            report.warnings.extend(seams.lost(
                name,
                simulation.shape(index)?,
                &made(simulation.corners(), index),
            ));
        }
        for (index, name) in run.names.iter().enumerate().filter(|(index, _)| !run.still[*index]) {
            report.warnings.extend(folds::folded(name, &simulation, index)?);
            report.warnings.extend(folds::shrunk(name, &simulation, index)?);
            report.notes.extend(folds::mass(name, &simulation, index)?);
        }
        report.notes.extend(told(simulation.corners(), &simulation, &run.names)?);
        report.notes.extend(run.notes);
        report.notes.extend(run.seen.note());
        report.marks = spots.marks(&simulation, run.rate, &run.names, &run.seen, &run.first)?;
        let mut moved = scene.clone();
        for (index, name) in run.names.iter().enumerate() {
            if run.still[index] {
                continue;
            }
            let shape = run.seen.own_shape(index, simulation.shape(index)?);
            put_back(&mut moved, name, shape.as_ref())?;
            if run.frames > 0 {
                let frames = frames[index].iter().map(|points| run.seen.own(index, points)).collect();
                moved.object_mut(name)?.animation = Some(Animation { rate: run.rate, frames });
            }
        }
        *scene = moved;
        Ok(report)
    }
}

/// The knots that a body was given, in turn.
fn inserted(corners: &[Corner], body: usize) -> Vec<f64> {
    let own = corners.iter().filter(|corner| corner.body == body);
    own.flat_map(|corner| std::iter::repeat_n(corner.at, corner.knots)).collect()
}

/// Where a body was given corners.
fn made(corners: &[Corner], body: usize) -> Vec<f64> {
    corners.iter().filter(|corner| corner.body == body).map(|corner| corner.at).collect()
}

/// The same frames of a shape that has these knots as well.
fn refine_frames(
    shape: &dyn Shape,
    knots: &[f64],
    frames: &mut [Vec<Point>],
) -> Result<(), loftsman_kernel::Error> {
    let mut coarse = shape.boxed();
    for frame in frames {
        coarse.control_vertices_mut().copy_from_slice(frame);
        *frame = refine_of(coarse.as_ref(), "a frame")?.refined(0, knots)?.control_vertices().to_vec();
    }
    Ok(())
}

/// So many corners have a line each.
const CORNERS: usize = 20;

/// Which corners there are now, in words.
fn told(
    corners: &[Corner],
    simulation: &Simulation,
    names: &[String],
) -> Result<Vec<String>, OperationError> {
    let mut lines = Vec::new();
    for Corner { constraint, body, at, knots } in corners.iter().take(CORNERS) {
        let at = figure(*at);
        let knots = match knots {
            0 => format!("at the knot {at}"),
            1 => format!("at {at}, where a knot was inserted"),
            _ => format!("at {at}, where {knots} knots were inserted"),
        };
        lines.push(format!(
            "{:?} turns at \"{}\": it has a corner there, {knots}, so that both sides are stretched alike (`corners = false` for none)",
            names[*body],
            simulation.name_of(*constraint)?,
        ));
    }
    if let more @ 1.. = corners.len().saturating_sub(CORNERS) {
        lines.push(format!("… and {more} more corners"));
    }
    Ok(lines)
}

/// The error at the place of the one constraint, force or pull that it is about, where it is about one: `asked` are their
/// names, with the lists in the recipe and the places in these.
fn blamed(error: DynamicsError, parameters: &Parameters, asked: &[(String, String)]) -> OperationError {
    let text = error.to_string();
    let about = |name: &str| {
        let rest = text.strip_prefix(name).or_else(|| text.strip_prefix(&format!("\"{name}\"")));
        rest.is_some_and(|rest| rest.starts_with([':', ' ']))
    };
    // Of several that a conflict names, the first.
    match asked.iter().filter(|(name, _)| about(name)).max_by_key(|(name, _)| name.len()) {
        Some((_, place)) => parameters.error(place, text).into(),
        None => error.into(),
    }
}

/// The larger of two stretches, whichever way.
fn wider(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
