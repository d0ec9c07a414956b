//! `tube`: a circle swept round a curve, in all frames of its animation.

mod frames;
mod line;
mod sweep;

use loftsman_kernel::text::{figure, short};
use std::f64::consts::PI;

use loftsman_kernel::Point;
use loftsman_kernel::error::Error;

use loftsman_kernel::plugin::{
    Chord, Context, CustomShape, Declaration, Field, Fineness, Operation, OperationError, ParameterError,
    Parameters, StepReport, in_own_coordinates, object_name,
};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene};

use frames::Frames;
use line::{Bend, Line, Part, State};
use sweep::{Caps, Profile};

/// The most points of a tube, all frames together: 1.2 GB.
const MOST: usize = 50_000_000;

/// The most sides of a circle.
const SIDES: usize = 100_000;

/// The operation `tube`: the surface of all circles of a radius round a curve, as a mesh.
///
/// Each circle lies across the curve; from one to the next they turn about it as little as can be (rotation-minimising frames by
/// double reflection), round a closed curve by what is missing there, spread evenly, and from frame to frame of an animation
/// so that the tube stays as near to where it was as can be. All frames are cut at the same parameters, as finely as each
/// needs. At corners the circles lie in the plane half way (mitred, to three radii at most). `O(points · frames)`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tube;

const CAPS: [(&str, Caps); 3] = [("flat", Caps::Flat), ("round", Caps::Round), ("none", Caps::None)];

impl Operation for Tube {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only curve or polyline", "what it is swept round"),
            Field::required("radius", "length", "of the circle"),
            Field::optional(
                "sides",
                "count",
                "as the tolerance needs",
                "points round each circle, 3 at least",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1/1000 of the curve's size",
                "largest distance between the mesh and the round tube, where that does not overlap itself",
            ),
            Field::optional("angle", "degrees", "15", "largest angle between neighbouring pieces along it"),
            Field::optional(
                "caps",
                "\"flat\" | \"round\" | \"none\"",
                "flat",
                "what closes the ends of an open tube",
            ),
            Field::optional(
                "uvs",
                "true | false",
                "true",
                "texture coordinates: u round it, v along it by arc length",
            ),
            Field::optional("keep", "true | false", "true", "leave the curve in the scene beside it"),
            Field::optional("name", "text", "after the curve", "the name of the tube"),
        ];
        Declaration {
            name: "tube",
            help: "a round tube about a curve or polyline, in all frames of its animation",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let fits = |g: &Geometry| match g {
            Geometry::Curve(_) | Geometry::Polyline(_) => true,
            Geometry::Custom(custom) => is_curve(custom),
            _ => false,
        };
        let name = object_name(scene, p, fits, "curve or polyline")?;
        let object = scene.object(&name)?;
        let keep = !p.has("keep") || p.flag("keep")?;
        let new = new_name(scene, p, &name, keep)?;
        let asked = Asked::of(object, p)?;
        let named = |e: Error| match e {
            Error::NoExtent(_) => {
                Error::NoExtent(format!("\"{name}\" has no extent: a tube needs a way to go"))
            }
            Error::Invalid(problem) => Error::Invalid(format!("\"{name}\": {problem}")),
            other => other,
        };
        let line = Line::of(object, context.registry.tessellator(), &asked.fineness).map_err(named)?;
        let profile = asked.profile(&line, p)?;
        let states = line.parts.first().map_or(0, |part| part.states.len());
        let points: usize = line.parts.iter().map(|part| profile.points(part)).sum();
        if points.saturating_mul(states) > MOST || points > u32::MAX as usize / 8 {
            let problem = format!(
                "{points} points in {states} states are more than the {MOST} that a tube may have: take fewer sides or a larger tolerance"
            );
            return Err(p.error(if p.has("sides") { "sides" } else { "tolerance" }, problem).into());
        }
        let swept = sweep(&line, &profile, states, context)?;
        let mut tube = object.renamed(&new);
        let (sides, count) = (profile.sides, swept.mesh.face_count());
        tube.set_geometry(swept.mesh);
        tube.statements.clear();
        tube.animation = object
            .animation
            .as_ref()
            .map(|animation| Animation { rate: animation.rate, frames: swept.frames });
        let mut notes = vec![format!("{count} faces, {sides} round it")];
        notes.extend(overlap(&line, profile.radius));
        notes.extend(in_own_coordinates(scene, &name, p, &[], &["radius", "tolerance"])?);
        let mut made = scene.clone();
        if !keep {
            made.remove(&name)?;
        }
        made.add(tube)?;
        *scene = made;
        Ok(StepReport { op: "tube".into(), object: Some(new), notes, ..StepReport::default() })
    }
}

fn is_curve(custom: &CustomShape) -> bool {
    custom.shape().is_ok_and(|shape| shape.domain().len() == 1)
}

/// The name of the tube: free, or the curve's own where that goes.
fn new_name(scene: &Scene, p: &Parameters, name: &str, keep: bool) -> Result<String, ParameterError> {
    if !p.has("name") {
        return Ok(if keep { scene.unique_name(&format!("{name} tube")) } else { name.to_owned() });
    }
    let asked = p.text("name")?;
    if asked.is_empty() || (scene.get(asked).is_some() && (keep || asked != name)) {
        return Err(p.error("name", format!("\"{asked}\" is taken or empty: choose another")));
    }
    Ok(asked.to_owned())
}

/// What is asked of the circle and of how finely it is swept.
struct Asked {
    radius: f64,
    sides: Option<usize>,
    caps: Caps,
    uvs: bool,
    /// Of all that a mesh may be away from the tube, a third is for the curve's chords.
    fineness: Fineness,
}

impl Asked {
    fn of(object: &Object, p: &Parameters) -> Result<Self, ParameterError> {
        let radius = p.number("radius")?;
        if radius <= 0.0 {
            return Err(p.error("radius", format!("{radius} is no radius: give a length above 0")));
        }
        let points = object.geometry().points();
        let largest = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if radius < 64.0 * f64::EPSILON * largest || radius < f64::MIN_POSITIVE * 1e9 {
            let problem = format!(
                "{radius:e} is less than coordinates of {largest:e} can resolve: give a larger radius"
            );
            return Err(p.error("radius", problem));
        }
        let sides = if p.has("sides") { Some(p.count("sides")?) } else { None };
        if let Some(sides) = sides.filter(|sides| !(3..=SIDES).contains(sides)) {
            return Err(p.error("sides", format!("{sides} sides make no tube: give 3 to {SIDES}")));
        }
        let mut fineness = Fineness::default();
        if p.has("tolerance") {
            let tolerance = p.number("tolerance")?;
            if tolerance <= 0.0 {
                return Err(
                    p.error("tolerance", format!("{tolerance} is no tolerance: give a length above 0"))
                );
            }
            fineness.chord = Chord::Absolute(tolerance / 3.0);
        } else {
            fineness.chord = Chord::Relative(1e-3 / 3.0);
        }
        if p.has("angle") {
            fineness.angle = p.number("angle")?.to_radians();
            if !(fineness.angle > 0.0 && fineness.angle <= PI) {
                return Err(p.error("angle", "give more than 0 and at most 180 degrees"));
            }
        }
        // The outside of a bend has the angle's chords, too.
        let whole = match fineness.chord {
            Chord::Absolute(third) => third,
            Chord::Relative(third) => third * line::diagonal(points),
        };
        if whole > 0.0 {
            fineness.angle = fineness.angle.min(chord_angle(whole, radius));
        }
        let caps = p.choice_or("caps", &CAPS, Caps::Flat)?;
        let uvs = !p.has("uvs") || p.flag("uvs")?;
        Ok(Self { radius, sides, caps, uvs, fineness })
    }

    fn profile(&self, line: &Line, p: &Parameters) -> Result<Profile, ParameterError> {
        let sides = match self.sides {
            Some(sides) => sides,
            None => {
                let needed = (2.0 * PI / chord_angle(line.tolerance, self.radius)).ceil();
                if needed > SIDES as f64 {
                    let problem = format!(
                        "a circle would need {needed} sides, and {SIDES} are the most: give `sides`, or a larger tolerance",
                        needed = short(needed)
                    );
                    return Err(p.error(if p.has("tolerance") { "tolerance" } else { "sides" }, problem));
                }
                // A whole number of them a quarter, so that a circle fills its box.
                (needed as usize).max(8).next_multiple_of(4)
            }
        };
        Ok(Profile { radius: self.radius, sides, caps: self.caps, uvs: self.uvs })
    }
}

/// The angle of a chord of a circle that is nowhere further from it: `r (1 - cos ½α) = h`.
fn chord_angle(height: f64, radius: f64) -> f64 {
    let share = (height / radius).min(1.0);
    // By the half-angle: for a small share a cosine near 1 would have no digits left.
    (4.0 * (share / 2.0).sqrt().asin()).min(PI)
}

struct Swept {
    mesh: loftsman_kernel::mesh::Mesh,
    frames: Vec<Vec<Point>>,
}

/// The mesh of the line as it is, and the points of each frame. Frames go along with time, so the line as it is comes after
/// them, and is the frame that it is alike.
fn sweep(
    line: &Line,
    profile: &Profile,
    states: usize,
    context: &Context<'_>,
) -> Result<Swept, OperationError> {
    let mut points: Vec<Vec<Point>> = vec![Vec::new(); states];
    let mut first = Vec::with_capacity(line.parts.len());
    let total = states * line.parts.len();
    for (number, part) in line.parts.iter().enumerate() {
        let mut before: Option<(&State, Frames)> = None;
        let mut alike: Option<Frames> = None;
        // 1, 2, …, and the line as it is at last.
        for (done, k) in (1..states).chain([0]).enumerate() {
            let state = &part.states[k];
            let known = if k == 0 { alike.take() } else { None };
            let frames = known.unwrap_or_else(|| {
                Frames::of(state, part.closed, before.as_ref().map(|(state, frames)| (*state, frames)))
            });
            profile.state(state, &frames, part.closed, &mut points[k]);
            if k != 0 && alike.is_none() && state.points == part.states[0].points {
                alike = Some(frames.clone());
            }
            if k == 0 {
                first.push(frames);
            } else {
                before = Some((state, frames));
            }
            context.observer.proceed("tube", (number * states + done) as u64 + 1, total as u64)?;
        }
    }
    let parts: Vec<(&Part, &Frames)> = line.parts.iter().zip(&first).collect();
    let mut points = points.into_iter();
    let mesh = sweep::mesh(&parts, profile, points.next().unwrap_or_default())?;
    let frames: Vec<Vec<Point>> = points.collect();
    for (k, frame) in frames.iter().enumerate() {
        if !frame.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Err(Error::Invalid(format!("the tube overflows in frame {k}")).into());
        }
    }
    Ok(Swept { mesh, frames })
}

/// What is said where the radius is more than the curve's bends leave room for.
fn overlap(line: &Line, radius: f64) -> Option<String> {
    let Bend { radius: least, state, at } = line.bend.filter(|bend| bend.radius < radius)?;
    let place = at.map_or_else(|| " (at a corner)".to_owned(), |at| format!(" (at {at:.4})"));
    let frame = state.checked_sub(1).map_or_else(String::new, |frame| format!(" in frame {frame}"));
    Some(format!(
        "the tube overlaps itself: its radius is {radius}, and the least radius of curvature is {least}{frame}{place}",
        least = figure(least)
    ))
}
