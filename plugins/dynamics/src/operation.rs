//! `simulate`: a shape in motion; the last shape stays in the object, and the frames as its animation.

mod constraints;
mod declared;
mod folds;
mod gravity;
mod marks;
mod report;
mod seams;

use loftsman_kernel::Point;
use loftsman_kernel::functional::ShapeNames;
use loftsman_kernel::plugin::{
    Context, Declaration, Frames, Operation, OperationError, ParameterError, Parameters, SceneShapes,
    SeenShapes, StepReport, Table, editable, object_name, put_back,
};
use loftsman_kernel::scene::{Animation, Scene};
use loftsman_kernel::shape::{Shape, cells_of, refine_of};
use loftsman_kernel::text::{figure, short};

use self::constraints::{Words, constraint, force, pull};
use self::declared::{BODY, FIELDS, TABLES};
use self::gravity::gravity;
use self::marks::Spots;
use self::report::report;
use self::seams::Seams;
use crate::body::{Body, Material};
use crate::error::{DynamicsError, check, check_damping, check_mass, check_rest, check_time};
use crate::scheme::Scheme;
use crate::setup::Setup;
use crate::simulation::{Audit, Corner, Simulation};

/// The operation `simulate`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Simulate;

/// How much heavier than itself what a rope carries would have to be to stretch it to twice its length.
const STIFF: f64 = 200.0;
/// How fast motion dies away where nothing is said of it: a swing loses two fifths of its speed in a second, so that a first try comes to rest.
const AIR: f64 = 0.5;
/// More steps than this for one frame would take minutes.
const MOST_STEPS: f64 = 5e4;
/// What ends stretched to more than so many times its length was pulled by mistake.
const TORN: f64 = 1e3;
/// A rise of energy of no more than so many percent is rounding.
const NO_RISE: f64 = 1e-10;
/// More frames than this are a mistake.
const MOST_FRAMES: f64 = 1e6;

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
            report.notes.extend(folds::off_centre(name, &simulation, index)?);
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

/// What a step says.
struct Run {
    /// What constraints, pulls and forces are called, and where each stands in the recipe.
    asked: Vec<(String, String)>,
    setup: Setup,
    names: Vec<String>,
    still: Vec<bool>,
    /// The shapes at the start, in the frame in which all move.
    first: Vec<Box<dyn Shape>>,
    seen: Frames,
    scheme: String,
    rate: f64,
    frames: usize,
    settle: bool,
    settle_frames: bool,
    corners: bool,
    notes: Vec<String>,
}

impl Run {
    fn new(
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
        let (gravity, fall) = gravity(scene, parameters, &names, &mut notes)?;
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

/// The larger of two stretches, whichever way.
fn wider(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
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

/// The numbers of a material: their fields, and what is asked of each.
type Checked = (&'static str, fn(f64) -> Result<f64, DynamicsError>);
const NUMBERS: [Checked; 7] = [
    ("stiffness", |value| check("the stiffness", value, false)),
    ("mass", |value| check_mass("the mass", value)),
    ("shear", |value| check("the shear stiffness", value, true)),
    ("bending", |value| check("the bending stiffness", value, true)),
    ("damping", |value| check_damping("the damping", value)),
    ("viscosity", |value| check("the viscosity", value, true)),
    ("rest", check_rest),
];
/// And of steps.
const STEPS: [Checked; 3] = [
    ("epsilon", |value| check("epsilon", value, false)),
    ("step", |value| check_time("the step", value)),
    ("draw", |value| check_time("the time in which constraints are drawn in", value)),
];

/// Looks at those of the fields that are there.
fn check_all(parameters: &Parameters, all: &[Checked]) -> Result<(), ParameterError> {
    for (field, checked) in all {
        if parameters.has(field)
            && let Err(error) = checked(parameters.number(field)?)
        {
            return Err(parameters.error(field, error.to_string()));
        }
    }
    Ok(())
}

fn material(parameters: &Parameters, other: Material) -> Result<Material, ParameterError> {
    let number = |name: &str, or: f64| if parameters.has(name) { parameters.number(name) } else { Ok(or) };
    let stiffness = number("stiffness", other.stiffness)?;
    if stiffness <= 0.0 {
        let problem = format!("a stiffness of {stiffness} keeps nothing together: give more than 0");
        return Err(parameters.error("stiffness", problem));
    }
    // At its place in the recipe, and with 0 only where it means something.
    check_all(parameters, &NUMBERS)?;
    let shear = if parameters.has("shear") {
        parameters.number("shear")?
    } else if parameters.has("stiffness") {
        0.5 * stiffness
    } else {
        other.shear
    };
    Ok(Material {
        mass: number("mass", other.mass)?,
        stiffness,
        shear,
        rest: number("rest", other.rest)?,
        bending: number("bending", other.bending)?,
        damping: number("damping", other.damping)?,
        viscosity: number("viscosity", other.viscosity)?,
    })
}

/// What is not said of its stiffness follows from its weight: that of its own length, of a surface of its own size.
fn stiffened(mut material: Material, shape: &dyn Shape, fall: f64) -> Result<Material, OperationError> {
    if material.stiffness.is_nan() {
        material.stiffness = STIFF * material.mass * fall * reach(shape)?;
    }
    if material.shear.is_nan() {
        material.shear = 0.5 * material.stiffness;
    }
    Ok(material)
}

/// Gauss points more than its degree in each span.
const MORE: usize = 8;

/// The arc length of a curve, the largest extent of a surface: of the shape itself, whatever its control vertices.
pub(super) fn reach(shape: &dyn Shape) -> Result<f64, OperationError> {
    if shape.domain().len() != 1 {
        return Ok(crate::body::extent(shape.control_vertices()));
    }
    let mut length = 0.0;
    for cell in cells_of(shape, "a length")?.checked(shape)? {
        let degree = cell.sides.first().map_or(0, |side| side.degree);
        for (at, weight) in cell.gauss_points([degree + MORE, 0]) {
            length += weight * shape.stencil(at, 1.into())?.apply(shape.control_vertices()).norm();
        }
    }
    Ok(length)
}
