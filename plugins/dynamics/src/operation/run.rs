//! What a step of a recipe says: which bodies, held by what, for how long, in which frames.

use loftsman_kernel::functional::ShapeNames;
use loftsman_kernel::plugin::{
    Context, Frames, OperationError, ParameterError, Parameters, SceneShapes, SeenShapes,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::text::figure;

use super::constraints::{Words, constraint, force, pull};
use super::declared::BODY;
use super::gravity::gravity;
use super::material::{AIR, STEPS, check_all, material, stiffened};
use crate::body::{Body, Material};
use crate::scheme::Scheme;
use crate::setup::Setup;

/// More frames than this are a mistake.
const MOST_FRAMES: f64 = 1e6;

/// What a step says.
pub(super) struct Run {
    /// What constraints, pulls and forces are called, and where each stands in the recipe.
    pub(super) asked: Vec<(String, String)>,
    pub(super) setup: Setup,
    pub(super) names: Vec<String>,
    pub(super) still: Vec<bool>,
    /// The shapes at the start, in the frame in which all move.
    pub(super) first: Vec<Box<dyn Shape>>,
    pub(super) seen: Frames,
    pub(super) scheme: String,
    pub(super) rate: f64,
    pub(super) frames: usize,
    pub(super) settle: bool,
    pub(super) settle_frames: bool,
    pub(super) corners: bool,
    pub(super) notes: Vec<String>,
}

impl Run {
    pub(super) fn new(
        scene: &Scene,
        parameters: &Parameters,
        context: &Context<'_>,
        object: &str,
    ) -> Result<Self, OperationError> {
        let scheme = parameters.choice_or(
            "scheme",
            &[("epsilon", Scheme::Epsilon), ("exact", Scheme::Exact), ("implicit", Scheme::Implicit)],
            Scheme::Epsilon,
        )?;
        let settle = parameters.flag("settle")?;
        let mut notes = Vec::new();
        let (rate, frames, seconds) = timing(parameters, settle, &mut notes)?;
        let mut names = SceneShapes::new(scene, object)?;
        let tables = parameters.tables("bodies")?;
        let mut others = Vec::with_capacity(tables.len());
        for table in &tables {
            table.check(&BODY)?;
            let name = table.text("object")?;
            let index = names.shape(name).map_err(|e| table.error("object", e.to_string()))?;
            if index != others.len() + 1 {
                return Err(table.error("object", format!("\"{name}\" moves already")).into());
            }
            others.push(table);
        }
        // Objects that constraints name stand still.
        let words = Words { registry: context.registry, seconds };
        let constraints = parameters
            .tables("constraints")?
            .iter()
            .map(|table| constraint(table, &mut names, &words))
            .collect::<Result<Vec<_>, OperationError>>()?;
        for late in constraints.iter().filter(|constraint| constraint.from > seconds) {
            notes.push(format!("\"{}\" never holds: it comes at {} s, after the end", late.name, late.from));
        }
        let pulls = parameters
            .tables("pull")?
            .iter()
            .map(|table| pull(table, &mut names, &words))
            .collect::<Result<Vec<_>, OperationError>>()?;
        let forces = parameters
            .tables("forces")?
            .iter()
            .map(|table| force(table, &mut names))
            .collect::<Result<Vec<_>, OperationError>>()?;
        let acting = pulls.iter().map(|p| (&p.name, p.from)).chain(forces.iter().map(|f| (&f.name, f.from)));
        for (name, from) in acting.filter(|(_, from)| *from > seconds) {
            notes.push(format!("\"{name}\" never acts: it comes at {from} s, after the end"));
        }
        let called = |list: &'static str, names: Vec<&String>| -> Vec<(String, String)> {
            let place = |(index, name): (usize, &String)| (name.clone(), format!("{list}[{index}]"));
            names.into_iter().enumerate().map(place).collect()
        };
        let asked = [
            called("constraints", constraints.iter().map(|c| &c.name).collect()),
            called("pull", pulls.iter().map(|p| &p.name).collect()),
            called("forces", forces.iter().map(|f| &f.name).collect()),
        ]
        .concat();
        let SeenShapes { names, shapes, frames: seen } = names.into_parts()?;
        let (gravity, fall) = gravity(scene, parameters, (&names, &seen), &mut notes)?;
        let unsaid = Material { stiffness: f64::NAN, shear: f64::NAN, damping: AIR, ..Material::default() };
        let own = material(parameters, unsaid)?;
        let mut still = Vec::with_capacity(names.len());
        let mut bodies = Vec::with_capacity(names.len());
        for (index, name) in names.iter().enumerate() {
            let (made, stays) = match index.checked_sub(1) {
                None => (own, false),
                Some(other) => match others.get(other) {
                    Some(table) => (material(table, own)?, table.flag("still")?),
                    None => (own, true),
                },
            };
            let body = Body::new(&shapes[index])
                .called(name)
                .material(stiffened(made, &shapes[index], fall)?)
                .stiff_by_weight(made.stiffness.is_nan());
            bodies.push(if stays { body.still() } else { body });
            still.push(stays);
        }
        let mut bodies = bodies.into_iter();
        let Some(first) = bodies.next() else {
            return Err(parameters.error("object", "there is nothing to move").into());
        };
        let mut setup = Setup::new(first).gravity(gravity).scheme(scheme);
        for body in bodies {
            setup = setup.and(body);
        }
        for constraint in constraints {
            setup = setup.hold(constraint);
        }
        setup = setup.keep_seams();
        for force in forces {
            setup = setup.push(force);
        }
        for pull in pulls {
            setup = setup.pull(pull);
        }
        check_all(parameters, &STEPS)?;
        if parameters.has("step") {
            setup = setup.step(parameters.number("step")?);
        }
        if parameters.has("epsilon") {
            setup = setup.epsilon(parameters.number("epsilon")?);
        }
        if parameters.has("draw") {
            setup = setup.draw(parameters.number("draw")?);
        }
        let scheme = parameters.text_or("scheme", "epsilon")?.to_owned();
        let settle_frames = parameters.flag("settle_frames")?;
        if settle_frames && !(settle && frames > 0) {
            let missing = if settle {
                "`seconds`: there are no frames without"
            } else {
                "`settle = true`: nothing is settled without"
            };
            let problem = format!(
                "the rest is one more frame where there are frames and rest is looked for; give {missing}, or leave it out"
            );
            return Err(parameters.error("settle_frames", problem).into());
        }
        if parameters.has("corners") && !settle {
            let problem = "corners come where rest is looked for: give `settle = true`, or leave it out";
            return Err(parameters.error("corners", problem).into());
        }
        let corners = !parameters.has("corners") || parameters.flag("corners")?;
        Ok(Self {
            asked,
            setup,
            names,
            still,
            first: shapes,
            seen,
            scheme,
            rate,
            frames,
            settle,
            settle_frames,
            corners,
            notes,
        })
    }
}

/// The rate, the number of frames after the first, and how long all takes.
fn timing(
    parameters: &Parameters,
    settle: bool,
    notes: &mut Vec<String>,
) -> Result<(f64, usize, f64), ParameterError> {
    let rate = parameters.number_or("frames_per_second", 24.0)?;
    if rate <= 0.0 {
        return Err(parameters.error("frames_per_second", format!("{rate} is not a rate: give more than 0")));
    }
    if !parameters.has("seconds") {
        if settle {
            return Ok((rate, 0, 0.0));
        }
        return Err(parameters.error("seconds", "say how long it moves, or settle = true for where it rests"));
    }
    let seconds = parameters.number("seconds")?;
    if seconds <= 0.0 {
        return Err(parameters.error("seconds", format!("{seconds} s is no time: give more than 0")));
    }
    let frames = (seconds * rate).round().max(1.0);
    if frames > MOST_FRAMES {
        return Err(parameters.error(
            "seconds",
            format!("{frames} frames are more than {MOST_FRAMES}: give a shorter time or a lower frames_per_second"),
        ));
    }
    let whole = frames / rate;
    if (whole - seconds).abs() > 1e-9 * seconds {
        let plural = if frames == 1.0 { "" } else { "s" };
        let short =
            if whole < seconds { ", and no path that arrives later is walked to its end" } else { "" };
        notes.push(format!("it moves for {} s: {frames} whole frame{plural}{short}", figure(whole)));
    }
    Ok((rate, frames as usize, whole))
}
