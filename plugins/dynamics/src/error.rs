//! Why a simulation cannot be, or cannot go on: one variant a reason.

use loftsman_kernel::Vector;
use loftsman_kernel::error::{Error, Figure};
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::text::{figure, short};

use crate::scheme::Scheme;

/// The result of what a simulation does.
pub(crate) type Result<T, E = DynamicsError> = std::result::Result<T, E>;

/// Why a simulation could not be made, or stopped. Every message says what was found and what to do.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// A number that cannot be.
    #[error("{what} is {}: {needed}", Figure(*.value))]
    Number {
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is needed.
        needed: &'static str,
    },
    /// The shape has no extent somewhere, so that nothing can be stretched there.
    #[error(
        "the shape stands still at {at}: a rope or sheet needs a length everywhere before it can be stretched; {}", apart(*.surface)
    )]
    Collapsed {
        /// Where, by its parameters.
        at: String,
        /// Whether it is a surface.
        surface: bool,
    },
    /// Bending of what has no second derivative.
    #[error(
        "{body:?} is of degree 1{along}, where nothing resists being folded at a corner: `bending` would do nothing; give a shape of degree 2 or more \
         (fit a curve or surface to its points), or leave `bending` out{own}"
    )]
    Unbending {
        /// What it is called.
        body: String,
        /// Along which of the parameters of a surface.
        along: &'static str,
        /// What else can be done.
        own: &'static str,
    },
    /// All of a shape that is to move is one point.
    #[error(
        "{body:?} is a single point: what moves needs a length, a sheet an area; give it control vertices that differ, or let another object move"
    )]
    Point {
        /// What it is called.
        body: String,
    },
    /// The mass matrix is not positive definite.
    #[error("the mass matrix of the shape is singular to rounding at control vertex {vertex}: {}", massless(*.cage))]
    Massless {
        /// The control vertex.
        vertex: usize,
        /// Whether it is the cage of a subdivision surface.
        cage: bool,
    },
    /// Constraints ask different things of the same.
    #[error("{}", contradiction(.names, *.apart))]
    Conflict {
        /// What they are called.
        names: Vec<String>,
        /// How far apart what they ask for is.
        apart: f64,
    },
    /// What nothing holds does not come to rest.
    #[error("{}", unheld(.body, .way, .let_go))]
    Unheld {
        /// What it is called.
        body: String,
        /// Where its weight or a force draws it.
        way: Vector,
        /// What let it go, and why.
        let_go: Vec<String>,
    },
    /// A curve that slides on a surface, both places floating, and lies along it.
    #[error(
        "\"{name}\": {} s after the start the curve lies along the surface on which it slides (they cross by {} degrees), so that nothing tells where they \
         meet: let one of both places stay (give `at` for `near`), or let the curve cross the surface more steeply",
        Figure(*.time), Figure((*.degrees * 1e3).round() / 1e3)
    )]
    Along {
        /// What the constraint is called.
        name: String,
        /// When.
        time: f64,
        /// The angle between the curve and the surface.
        degrees: f64,
    },
    /// A location that is not on its shape.
    #[error("{constraint}: {} is not on the shape, whose parameters run from {} to {}", Figure(*.at), Figure(*.start), Figure(*.end))]
    Outside {
        /// The constraint, force or pull.
        constraint: String,
        /// The parameter.
        at: f64,
        /// Where the domain starts.
        start: f64,
        /// Where it ends.
        end: f64,
    },
    /// Something that is not linear in the control vertices.
    #[error(
        "{what} is not linear in the control vertices: a simulation can hold what is (positions, derivatives, sums of them)"
    )]
    NotLinear {
        /// What was asked.
        what: String,
    },
    /// There is no such thing in this simulation.
    #[error("there is no {what} {index} in this simulation: it has {count}")]
    Missing {
        /// What was looked for.
        what: &'static str,
        /// Its number.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The numbers left all bounds.
    #[error(
        "the simulation blows up after {} s, in a step of {} s: {}",
        figure(*.time), figure(*.step), what_to_do((*.step, *.stable), *.scheme, (*.fed, *.slides), *.strain, .lost.as_deref())
    )]
    BlowsUp {
        /// When.
        time: f64,
        /// The step that was taken.
        step: f64,
        /// What is known to be stable of explicit steps; infinite where nothing bounds it.
        stable: f64,
        /// How steps were taken.
        scheme: Scheme,
        /// Whether anything is asked to move, comes or goes, or is still drawn in.
        fed: bool,
        /// Whether a place that is held slides.
        slides: bool,
        /// By how many times its length forces, pulls and weight together would stretch a body, the most of all.
        strain: f64,
        /// A constraint whose place ran away along its shape.
        lost: Option<String>,
    },
    /// There is no place any more that does what is only followed.
    #[error(
        "{constraint:?} has no place on its shape any more after {} s: it asks for no more numbers than its place has parameters, so that it is followed and nothing holds it, and here \
         two such places meet and vanish; scheme \"epsilon\" holds the last one there is, a place that stays (`at`) holds what it asks for, or end it sooner (`until`)",
        figure(*.time)
    )]
    Vanishes {
        /// What is followed.
        constraint: String,
        /// When.
        time: f64,
    },
    /// Energy came from nowhere.
    #[error(
        "the simulation blows up after {} s, in a step of {} s: nothing was put in, and energy rose by {} % of what moved and was stretched; {}",
        figure(*.time), figure(*.step), short(100.0 * *.rise), where_from(*.step, *.stable, *.implicit, *.held)
    )]
    Rises {
        /// When.
        time: f64,
        /// The last step.
        step: f64,
        /// What is known to be stable of explicit steps.
        stable: f64,
        /// By which share of what moved and was stretched.
        rise: f64,
        /// Whether the step was implicit.
        implicit: bool,
        /// Whether anything holds it then.
        held: bool,
    },
    /// On the way to rest numbers grew beyond all bounds.
    #[error(
        "rest was not found: on the way to it the shape went beyond all numbers; give smaller forces, pulls and stiffness, and targets that are nearer"
    )]
    NoRest,
    /// Stretched beyond all sense.
    #[error(
        "{body:?} is stretched to {} times its length at rest after {} s (explicit steps are stable up to {} s): what pulls it is too strong for its stiffness; \
         give smaller forces, pulls or weight, or more stiffness",
        figure(1.0 + .stretch), figure(*.time), figure(*.stable)
    )]
    Torn {
        /// What it is called.
        body: String,
        /// The largest stretch, `|P'|/ℓ - 1`.
        stretch: f64,
        /// When.
        time: f64,
        /// What is known to be stable of explicit steps.
        stable: f64,
    },
    /// Stiffness so large beside mass that the sum of both is the stiffness alone.
    #[error(
        "{body:?}: its stiffness, bending or pulls are so large for its mass that a step of {} s drowns the mass in rounding; give {}",
        Figure(*.step), lighter(*.by_weight)
    )]
    Drowned {
        /// What it is called.
        body: String,
        /// The step.
        step: f64,
        /// Whether its stiffness follows from its weight, because none was given.
        by_weight: bool,
    },
    /// A step so short that the run would not end.
    #[error(
        "{} sub-steps would be needed for each step of {} s (stable ones are {} s long): the shape is very stiff or damped for its mass; give scheme \
         \"implicit\", a lower stiffness (or damping), or more mass",
        figure(*.needed), figure(*.step), figure(*.stable)
    )]
    TooStiff {
        /// Sub-steps.
        needed: f64,
        /// The step asked for.
        step: f64,
        /// The stable step.
        stable: f64,
    },
    /// A step that was asked for, so short that the run would not end.
    #[error(
        "the step of {} s is too short: of so short ones more than a million would be needed for {} s; give a `step` of {} s or more, or leave it out for the \
         longest that is stable",
        figure(*.step), figure(*.whole), figure(*.least)
    )]
    TooShort {
        /// The step asked for.
        step: f64,
        /// What is to be gone on by.
        whole: f64,
        /// The shortest that would do.
        least: f64,
    },
    /// What the kernel says.
    #[error(transparent)]
    Geometry(#[from] Error),
}

fn lighter(by_weight: bool) -> &'static str {
    if by_weight {
        "less gravity, or a `stiffness`: where none is given it goes with the weight, so that more mass does not help"
    } else {
        "smaller ones, or more mass"
    }
}

fn where_from(step: f64, stable: f64, implicit: bool, held: bool) -> String {
    let longer = step > stable;
    let stable = figure(stable);
    match (implicit, held) {
        (true, true) => {
            "what holds it moved too far along it, or turned, in one step; give a smaller step, or hold it elsewhere".to_owned()
        }
        (true, false) => "nothing holds it, and it folds or turns too far in one step; give a smaller step".to_owned(),
        (false, _) if longer => format!("steps up to {stable} s are stable; give a smaller step, or leave it out"),
        (false, true) => format!(
            "steps up to {stable} s are stable, but it turns or folds too fast for them, or what holds it drifts in them and is drawn back; give a smaller step or scheme \"implicit\", or hold it elsewhere: where it does not turn so \
             sharply, and farther from an end"
        ),
        (false, false) => format!(
            "steps up to {stable} s are stable where it is stretched, but nothing holds it, and it folds; give a smaller step, some `bending` or `viscosity`, or scheme \"implicit\""
        ),
    }
}

/// What is pulled so strongly that it would be stretched by so many times its length is pulled too strongly.
const OVERLOADED: f64 = 100.0;

fn what_to_do(
    (step, stable): (f64, f64),
    scheme: Scheme,
    (fed, slides): (bool, bool),
    strain: f64,
    lost: Option<&str>,
) -> String {
    let implicit = scheme == Scheme::Implicit;
    let longer = step > stable && !implicit;
    let stable = figure(stable);
    // In what a step that is too long does forces are no cause.
    let would =
        if implicit { String::new() } else { format!("steps up to {stable} s would be stable, but ") };
    if strain > OVERLOADED && !longer {
        return format!(
            "{would}forces, pulls and weight together would stretch it to {} times its length: they are too strong for its stiffness; give smaller ones, or more `stiffness`",
            figure(strain)
        );
    }
    if let Some(name) = lost.filter(|_| !longer) {
        let what = format!(
            "{would}\"{name}\" runs away along its shape, as where what it asks for hardly changes along that and nothing tells where it is"
        );
        let slower = if fed { ", what moves or is drawn in more slowly (`arrive`, `draw`)" } else { "" };
        return match scheme {
            Scheme::Exact => format!(
                "{what}; give scheme \"epsilon\", in which such a place has a mass, a smaller step{slower}, or a location that stays (`at`)"
            ),
            Scheme::Epsilon => {
                format!(
                    "{what}; give a smaller step{slower}, scheme \"implicit\", or a location that stays (`at`)"
                )
            }
            Scheme::Implicit => {
                format!("{what}; give a smaller step{slower}, or a location that stays (`at`)")
            }
        };
    }
    match (implicit, fed) {
        (true, true) => format!(
            "what is asked moves, comes or is drawn in too fast; give a smaller step (explicit ones are stable up to {stable} s), more damping, a later `arrive` or a longer `draw`"
        ),
        (true, false) if slides => format!(
            "no place near does what is asked, though none of that moves: where a place slides, what it asks for may be nowhere on the shape any more; give a smaller step (explicit ones are stable up to {stable} s), more damping, \
             or scheme \"epsilon\""
        ),
        (true, false) => format!(
            "forces, pulls or speeds are too large for so long a step; give smaller ones, a smaller step (explicit ones are stable up to {stable} s), or more damping"
        ),
        (false, _) if longer => {
            format!("steps up to {stable} s are stable; give a smaller step, or scheme \"implicit\"")
        }
        (false, true) => format!(
            "steps up to {stable} s would be stable, but what is asked moves, comes or is drawn in too fast, or forces and pulls are too large; give a smaller step, scheme \"implicit\", a later `arrive` or a longer `draw`"
        ),
        (false, false) => format!(
            "steps up to {stable} s would be stable, but forces, pulls or speeds are too large{}; give a smaller step, or scheme \"implicit\"",
            if slides { ", or what slides is lost" } else { "" }
        ),
    }
}

/// What to do where a shape stands still.
fn apart(surface: bool) -> &'static str {
    if surface {
        "move repeated control vertices apart (operation fair, or an edit)"
    } else {
        "give it control vertices that differ: take points along it (operation sample) and fit a curve to those (operation fit)"
    }
}

fn massless(cage: bool) -> &'static str {
    if cage {
        "the limit surface of this cage does not tell all of its vertices (as of a cube, where all have three edges), or some have no part of it; subdivide the cage once"
    } else {
        "its basis functions hardly differ there (very high degrees), or some have no part of the shape; fit a curve of lower degree, or simplify the shape"
    }
}

fn contradiction(names: &[String], apart: f64) -> String {
    let all: Vec<String> = names
        .iter()
        .map(|name| if name.contains('"') { name.clone() } else { format!("\"{name}\"") })
        .collect();
    match &all[..] {
        [one] => format!(
            "{one} cannot hold: it misses by {} wherever the shape goes; correct what it asks",
            Figure(apart)
        ),
        _ => format!(
            "{} cannot all hold: what they ask for is {} apart; release one of them, or give them different locations or times",
            all.join(" and "),
            Figure(apart)
        ),
    }
}

/// A direction for people.
pub(crate) fn direction(way: &Vector) -> String {
    let [x, y, z] = [way.x, way.y, way.z].map(|v| (v * 1e6).round() / 1e6 + 0.0);
    format!("[{x}, {y}, {z}]")
}

fn unheld(body: &str, way: &Vector, let_go: &[String]) -> String {
    let along = direction(way);
    let since = if let_go.is_empty() { String::new() } else { format!(" any more ({})", let_go.join("; ")) };
    format!(
        "nothing holds \"{body}\"{since} along {along}, where its weight or a force draws it, so that it never rests: hold a point of it in that \
         direction (a constraint of all axes, or of that one), or give a pull"
    )
}

impl From<DynamicsError> for OperationError {
    fn from(error: DynamicsError) -> Self {
        match error {
            DynamicsError::Geometry(error) => error.into(),
            other => Error::Invalid(other.to_string()).into(),
        }
    }
}

/// Larger numbers are mistakes.
const ABSURD: f64 = 1e100;

/// A vector whose coordinates must be finite, and no mistakes.
pub(crate) fn check_vector(what: &'static str, value: &Vector) -> Result<()> {
    match value.iter().find(|v| v.is_nan() || v.abs() > ABSURD) {
        Some(bad) if bad.is_finite() => {
            Err(DynamicsError::Number { what, value: *bad, needed: "give numbers below 1e100" })
        }
        Some(bad) => Err(DynamicsError::Number { what, value: *bad, needed: "give finite numbers" }),
        None => Ok(()),
    }
}

/// Stiffness, bending and viscosity beyond these are mistakes.
const STRONG: [f64; 2] = [1e-50, 1e50];
/// Masses a unit of length or area beyond these are mistakes.
const HEAVY: [f64; 2] = [1e-30, 1e30];
/// Times in seconds beyond these are mistakes.
const LONG: [f64; 2] = [1e-12, 1e9];
/// What dies away faster, in 1/s, does so within what a step rounds.
const DAMPED: f64 = 1e6;

fn within([low, high]: [f64; 2], what: &'static str, value: f64, needed: &'static str) -> Result<f64> {
    if (low..=high).contains(&value) { Ok(value) } else { Err(DynamicsError::Number { what, value, needed }) }
}

/// A strength that must be finite and positive, or not negative, and no mistake.
pub(crate) fn check(what: &'static str, value: f64, zero: bool) -> Result<f64> {
    match zero {
        true if value == 0.0 => Ok(value),
        true => within(STRONG, what, value, "give 0, or a number above 0: between 1e-50 and 1e50"),
        false => within(STRONG, what, value, "give a number above 0: between 1e-50 and 1e50"),
    }
}

/// What a length at rest is of that at the start beyond these is a mistake.
const RESTS: [f64; 2] = [1e-3, 1e3];

/// What the length at rest is of that at the start.
pub(crate) fn check_rest(value: f64) -> Result<f64> {
    within(
        RESTS,
        "the rest length's factor",
        value,
        "give a number between 0.001 and 1000: 1 is as long as it is at the start",
    )
}

/// A mass a unit of length or area.
pub(crate) fn check_mass(what: &'static str, value: f64) -> Result<f64> {
    within(HEAVY, what, value, "give a number above 0: between 1e-30 and 1e30")
}

/// A time in seconds.
pub(crate) fn check_time(what: &'static str, value: f64) -> Result<f64> {
    within(LONG, what, value, "give a number above 0: between 1e-12 and 1e9 seconds")
}

/// A rate in 1/s at which motion dies away.
pub(crate) fn check_damping(what: &'static str, value: f64) -> Result<f64> {
    let needed = "give a number of 0 or more, up to 1e6: then motion dies away within a microsecond";
    within([0.0, DAMPED], what, value, needed)
}
