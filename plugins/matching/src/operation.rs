//! `match`: an edge of a surface made to meet another surface's edge, with as many knots as that needs.

mod changed;
mod made;
mod remedy;
mod seam;
mod turned;
mod ways;

use std::any::Any;

use loftsman_kernel::edit::{Ask, Edit, EditError, Metric};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Edge, On, Shapes};
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, SceneShapes, SeenShapes, StepReport,
    object_name, other_object_name, put_back,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{SaddlePoint, SolveError};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::text::{a, figure, short};
use loftsman_kernel::topology::EdgeCurve;

use crate::beside::{Begun, Beside, edge_of};
use crate::deviation::{Deviation, Limits};
use crate::history::{Attempt, History, Stuck};
use crate::matching::{CONTINUITY, EDGE, LIMITS, Matching, WITH, continuity, limits, matching, other};
use changed::Changed;
use made::Made;
use remedy::{Refused, Why};
use seam::Kept;

/// The default tolerance, of the edge's size.
const TOLERANCE: f64 = 1e-4;
/// The most control vertices along the edge, or twice as many as it had, with continuity 0, 1 and 2.
const MOST: [usize; 3] = [256, 192, 128];
/// So many control vertices along the edge are tried with a surface's own knots alone before those of the other edge are, with continuity 2.
const ENOUGH: usize = 64;
/// Knots stop where estimates, which are rough, say that this many times as many control vertices would be needed.
const DOUBTFUL: usize = 2;
/// Spans that are shorter than this part of the domain are not halved.
const SHORTEST: f64 = 1e-6;

/// The operation `match`.
///
/// Its work is bounded: knots are inserted until there are 256, 192 or 128 (by continuity) control vertices along the edge (or twice as many as it had),
/// and where the whole surface bends only as long as the bordered system stays within what the solver `saddle-point` takes. Knots
/// stop where three estimates in a row, from what the last ones brought, say that twice as many as that would be needed. What is refused so is tried once more with
/// the degree and the knots of the other edge, and the remedies that a refusal names were tried, with no more than some times its own work.
#[derive(Debug, Clone, Copy, Default)]
pub struct MatchOperation;

impl Operation for MatchOperation {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only other surface", "the surface that moves"),
            EDGE,
            WITH,
            CONTINUITY,
            Field::optional(
                "tolerance",
                "length",
                "1/10,000 of the edge's size",
                "how far the edges may be apart",
            ),
            LIMITS[1],
            LIMITS[2],
            Field::optional(
                "keep",
                "0 | 1 | 2 | \"nothing\"",
                "as continuity",
                "what stays at the opposite edge: position, tangent planes, curvature",
            ),
            Field::optional(
                "metric",
                "\"bend\" | \"least\"",
                "bend; least where that folds or goes much farther",
                "whether the whole surface follows, bending little, or only what is beside the edge",
            ),
            Field::optional(
                "refine",
                "true | false",
                "true",
                "insert knots where that brings it within the limits",
            ),
        ];
        Declaration {
            name: "match",
            help: "move an edge of a surface to another surface's, smoothly (G1, G2), with knots inserted as needed; reports what \
                   is left",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let with = other(p)?;
        let beside = with.text("object")?.to_owned();
        scene.object(&beside).map_err(|e| with.error("object", e.to_string()))?;
        let object = if p.has("object") {
            object_name(scene, p, |_| true, "surface")?
        } else {
            let fits = |g: &Geometry| matches!(g, Geometry::Surface(_));
            other_object_name(scene, p, &beside, fits, "other surface")?
        };
        if object == beside {
            return Err(with
                .error("object", "the surface that moves cannot stand still: name another")
                .into());
        }
        let still = scene.object(&beside)?;
        if still.geometry().shape().is_ok_and(|shape| shape.domain().len() == 1) {
            let problem = format!(
                "\"{beside}\" is {}, which has no edge: the edge of a surface is brought onto a curve by the constraint `edge`, in an `edit`",
                a(&still.geometry().noun())
            );
            return Err(with.error("object", problem).into());
        }
        if !matches!(scene.object(&object)?.geometry(), Geometry::Surface(_)) {
            let kind = a(&scene.object(&object)?.geometry().noun());
            let problem = match scene.object(&object)?.geometry() {
                Geometry::Curve(_) => format!(
                    "\"{object}\" is {kind}: `match` moves surfaces. Curves are brought together by the constraint `join`, with continuity = 0, 1 or 2, \
                     in an `edit`"
                ),
                Geometry::Custom(_) | Geometry::Brep(_) | Geometry::Trimmed(_) => format!(
                    "\"{object}\" is {kind}: only B-spline surfaces get knots as they need them; ask for the constraint `match` in an `edit`"
                ),
                _ => format!("\"{object}\" is {kind}: `match` moves B-spline surfaces"),
            };
            return Err(p.error("object", problem).into());
        }
        let mut names = SceneShapes::new(scene, &object)?;
        let asked = Asked::new(p, &with, &mut names, scene.unit)?;
        let SeenShapes { names, shapes, frames } = names.into_parts()?;
        let [first, second] = &shapes[..] else {
            return Err(Error::Invalid("two surfaces are needed".into()).into());
        };
        let any: &dyn Any = first.as_shape();
        let Some(surface) = any.downcast_ref::<Surface>() else {
            return Err(Error::Invalid(format!("\"{object}\" is no B-spline surface")).into());
        };
        let made = asked.run(surface, second.as_ref(), context)?;
        let mut report = made.report("match", &object, &asked);
        report.notes.extend(frames.note());
        let mut edited = scene.clone();
        put_back(&mut edited, &names[0], frames.own_shape(0, made.edited.shape()).as_ref())?;
        *scene = edited;
        Ok(report)
    }
}

/// What is asked.
#[derive(Debug, Clone)]
struct Asked {
    edge: Edge,
    other: On,
    other_edge: Edge,
    continuity: usize,
    limits: Limits,
    keep: Option<usize>,
    /// Whether that was said, and is not as the continuity.
    keeps: bool,
    /// Whether limits were given that a lower continuity has not.
    limited: bool,
    bend: bool,
    /// Whether the metric was said.
    measured: bool,
    refine: bool,
    /// Whether a closed edge may begin between the knots of the other.
    free: bool,
    /// Whether the lines across leave the edge as those of the other surface arrive there.
    led: bool,
    unit: Unit,
}

impl Asked {
    fn new(
        p: &Parameters,
        with: &Parameters,
        names: &mut SceneShapes<'_>,
        unit: Unit,
    ) -> Result<Self, OperationError> {
        let other = crate::edge_on::named(with, "object", names)?;
        let continuity = continuity(p)?;
        let keep = if !p.has("keep") {
            Some(continuity)
        } else if p.value("keep").is_some_and(|keep| keep.is_string()) {
            match p.text("keep")? {
                "nothing" => None,
                other => {
                    return Err(p.error("keep", format!("\"{other}\" is not 0, 1, 2 or \"nothing\"")).into());
                }
            }
        } else {
            match p.count("keep")? {
                order @ 0..=2 => Some(order),
                order => {
                    return Err(p.error("keep", format!("{order} is not 0, 1, 2 or \"nothing\"")).into());
                }
            }
        };
        Ok(Self {
            edge: Edge::from_parameters(p, "edge")?,
            other,
            other_edge: Edge::from_parameters(with, "edge")?,
            continuity,
            limits: limits(p, continuity)?,
            keep,
            keeps: p.has("keep"),
            limited: p.has("angle") || p.has("curvature"),
            bend: !p.has("metric") || p.choice("metric", &[("bend", true), ("least", false)])?,
            measured: p.has("metric"),
            refine: !p.has("refine") || p.flag("refine")?,
            free: true,
            led: false,
            unit,
        })
    }

    /// The match with these limits.
    fn matching(&self, limits: Limits) -> Matching {
        matching(self.edge, self.other.clone(), self.other_edge, self.continuity, limits)
            .free(self.free)
            .led(self.led)
    }

    /// Rows of control vertices, from an edge on, that a continuity moves.
    fn rows(continuity: usize) -> usize {
        continuity + 1
    }

    /// Whether the edge begins beside the other where that has no knots, and would not have to.
    fn starts_between(&self, surface: &Surface, other: &dyn Shape) -> Result<bool, Error> {
        let shapes = Shapes::new([surface as &dyn Shape, other]);
        let there = edge_of(&shapes, &self.other, self.other_edge, "match")?;
        let track = |exact: bool| -> Result<_, Error> {
            let edge = edge_of(&shapes, &On::default(), self.edge, "match")?;
            Ok(Beside::new(edge, &there.curve, exact)?.track())
        };
        Ok(track(false)? != track(true)?)
    }

    /// With the surface's own knots first, and those of the other edge where they are not enough.
    fn attempt(
        &self,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let shapes = Shapes::new([surface as &dyn Shape, other]);
        let edge = edge_of(&shapes, &On::default(), self.edge, "match")?;
        let there = edge_of(&shapes, &self.other, self.other_edge, "match")?;
        let size = edge.spread().max(there.spread());
        let distance = self.limits.distance.unwrap_or(TOLERANCE * size);
        let limits = Limits { distance: Some(distance), ..self.limits };
        let along = if edge.edge.along_u { Direction::U } else { Direction::V };
        let begun = Beside::new(edge.clone(), &there.curve, !self.free)?.begins();
        let profile = self.matching(limits).begun(begun).profile(&shapes)?;
        let case = Case {
            surface,
            other,
            along,
            at_end: edge.edge.at_end,
            begun,
            size,
            distance,
            before: Deviation::worst(&profile).without_rounding(size),
            lay_on: self.continuity > 0 && Deviation::lies_on(&profile, &limits),
        };
        if Deviation::folded(&profile) && self.continuity > 1 && !self.led {
            // With tangent planes alone, by linear equations, it is there still, if it is with curvature, which costs many times as much.
            let planes = Self { continuity: 1, ..self.clone() };
            if let Ok(Err(refused)) = planes.attempt(surface, other, context, work)
                && matches!(refused.why, Why::LayOn | Why::Folds)
            {
                return Ok(Err(refused));
            }
        }
        let start = self.with_rows(surface, along.other())?;
        if !self.refine {
            return self.from(start, usize::MAX, &case, context, work);
        }
        let (refined, exact) = as_the_other(&start, along, edge, &there, begun)?
            .map_or((None, false), |found| (Some(found.0), found.1));
        match refined {
            None => self.from(start, usize::MAX, &case, context, work),
            Some(refined) if exact => self.from(refined, usize::MAX, &case, context, work),
            Some(refined) => {
                // With curvature each round is work by the square: its own knots are tried as long as they are not many more than those of both.
                // A closed edge that begins between the other's knots has no use for these.
                let together = self.continuity > 1 && !(self.free && self.starts_between(surface, other)?);
                let as_many =
                    if together { (2 * refined.space(along).len()).max(ENOUGH) } else { usize::MAX };
                let first = match self.from(start, as_many, &case, context, work)? {
                    Ok(made) => return Ok(Ok(made)),
                    // How many would be needed was not asked for all that may be.
                    Err(refused) if as_many < usize::MAX && matches!(refused.why, Why::Needs { .. }) => {
                        Refused { why: Why::Limits, ..refused }
                    }
                    Err(refused) => refused,
                };
                // With other weights it is not that curve, but bends and has corners where that does.
                match self.from(refined, usize::MAX, &case, context, work) {
                    Ok(Err(refused)) => Ok(Err(if refused.worst.is_some() { refused } else { first })),
                    Ok(made) => Ok(made),
                    Err(_) => {
                        // Whoever asked may have had enough; all else says no more than what was refused first.
                        context.observer.proceed(work.called, 0, 0)?;
                        Ok(Err(first))
                    }
                }
            }
        }
    }

    /// From a surface with these knots on, to so many control vertices along the edge at most.
    fn from(
        &self,
        mut start: Surface,
        as_many: usize,
        case: &Case<'_>,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let Case { surface, other, along, size, distance, before, .. } = *case;
        // What the equations leave between is judged here, by the limits: no curvature is too much beside a flat surface either.
        let lax = Limits { distance: Some(1e6 * size), angle: std::f64::consts::TAU, curvature: 1e200 };
        let most = MOST[self.continuity].max(2 * surface.space(along).len()).min(as_many);
        let (mut history, mut kept) = (History::default(), Kept::Smooth);
        loop {
            let count = start.space(along).len();
            if work.done >= work.most {
                return Ok(Err(Refused::of(history.last(), size, Why::Work)));
            }
            work.done += count;
            context.observer.proceed(work.called, count as u64, most as u64)?;
            let asked =
                self.matching(lax).begun(case.begun).bound_to(&Shapes::new([&start as &dyn Shape, other]))?;
            let made = |kept: Kept| -> Result<Edit<Surface>, OperationError> {
                let still = 0..other.control_vertices().len() as i64;
                let mut edit =
                    Edit::new(&start).with(other.boxed()).lock(self.locked(&start, along)?).lock_on(1, still);
                if let Some(name) = &self.other.name {
                    edit = edit.named(1, name.clone());
                }
                if self.bend {
                    edit = edit.metric(Metric::Bend);
                }
                let mut edit = edit.smooth(u8::from(kept == Kept::Smooth)).ask(asked.clone().hold());
                if kept == Kept::Shut {
                    for tie in self.seam(&start, along)? {
                        edit = edit.ask(tie);
                    }
                }
                Ok(edit)
            };
            // With knots of its own a surface is moved whatever that takes; knots are inserted while that is quick.
            let quick = self.bend && history.last().is_some();
            let edit = |kept: Kept| -> Result<_, OperationError> {
                if !quick {
                    return Ok(made(kept)?.solve());
                }
                Ok(match made(kept)?.solve_with(SaddlePoint) {
                    // What it takes for nearly dependent others take.
                    Err(EditError::Solve(SolveError::IllConditioned { .. })) => made(kept)?.solve(),
                    solved => solved,
                })
            };
            // Where the other edge has corners that the surface has not, the two conflict: there they appear. What meets along a seam goes on meeting, if it can.
            let mut solved = edit(kept)?;
            while let (
                Err(EditError::Solve(SolveError::Conflict { .. } | SolveError::NearConflict { .. })),
                Some(less),
            ) = (&solved, kept.less())
            {
                kept = less;
                solved = edit(kept)?;
            }
            let edited = match (solved, history.last()) {
                (Ok(edited), _) => edited,
                (Err(EditError::Solve(SolveError::TooLarge { .. })), Some(last)) => {
                    return Ok(Err(Refused::of(Some(last), size, Why::Work)));
                }
                (
                    Err(EditError::Solve(
                        SolveError::NotConverged { .. }
                        | SolveError::StillMoving { .. }
                        // Equations that are nearly dependent, all but met.
                        | SolveError::Missed { .. },
                    )),
                    _,
                ) => {
                    return Ok(Err(Refused { count, worst: None, size, why: Why::NoneFound }));
                }
                (Err(EditError::Solve(SolveError::Metric { .. })), _) if self.bend => {
                    return Ok(Err(Refused {
                        count,
                        worst: None,
                        size,
                        why: Why::Unmeasured(too_close(&start)),
                    }));
                }
                (Err(error), _) => return Err(error.into()),
            };
            let profile = asked.profile(&Shapes::new([edited.shape() as &dyn Shape, other]))?;
            let worst = Deviation::worst(&profile).without_rounding(size);
            if worst.within(self.continuity, distance, &self.limits) {
                let degrees = |s: &Surface| [along, along.other()].map(|d| s.space(d).degree());
                let count = |s: &Surface, direction| s.space(direction).len();
                let (along, across) = (along, along.other());
                let changed = Changed::of([surface, edited.shape()], along, case.at_end, size)?;
                return Ok(Ok(Made {
                    size,
                    changed,
                    before,
                    after: worst,
                    along: [count(surface, along), count(&start, along)],
                    across: [count(surface, across), count(&start, across)],
                    degrees: [degrees(surface), degrees(&start)],
                    edited,
                    cornered: kept != Kept::Smooth,
                    shut: kept == Kept::Shut && !self.seam(&start, along)?.is_empty(),
                    way: None,
                }));
            }
            let excess = worst.excess(self.continuity, distance, &self.limits);
            history.push(Attempt { count, excess, worst });
            start = match self.halved(&start, case, most, &profile, &mut history)? {
                Ok(halved) => halved,
                Err(why) => return Ok(Err(Refused::of(history.last(), size, why))),
            };
        }
    }

    /// The surface with enough rows across: those that move, and those that stay.
    fn with_rows(&self, surface: &Surface, across: Direction) -> Result<Surface, Error> {
        let mut surface = surface.clone();
        let degree = surface.space(across).degree();
        let least = Self::rows(self.continuity);
        if degree < least {
            surface = surface.elevate(across, least - degree)?;
        }
        let rows = |rows: usize| say(surface.space(across), rows);
        let needed = rows(least) + self.keep.map_or(1, |keep| rows(Self::rows(keep)));
        while surface.space(across).len() < needed {
            let breaks = surface.space(across).breakpoints();
            let longest = breaks.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
            let Some(&[a, b]) = longest else { break };
            surface = surface.insert_knots(across, &[0.5 * a + 0.5 * b])?;
        }
        Ok(surface)
    }

    /// The rows at the opposite edge that stay.
    fn locked(&self, surface: &Surface, along: Direction) -> Result<Vec<i64>, Error> {
        let Some(keep) = self.keep else { return Ok(Vec::new()) };
        let (rows, columns) = (surface.u().len(), surface.v().len());
        let edge = self.edge.number_on(surface)?;
        let edge = EdgeCurve::of(surface, edge, "match")?.edge;
        let across = surface.space(along.other());
        let say = say(across, Self::rows(keep));
        let count = across.len();
        let stays = |i: usize| if edge.at_end { i < say } else { i + say >= count };
        let mut locked = Vec::new();
        for i in 0..rows {
            for j in 0..columns {
                if stays(if along == Direction::U { j } else { i }) {
                    locked.push((i * columns + j) as i64);
                }
            }
        }
        Ok(locked)
    }

    /// The surface with the spans halved along which the match is outside its limits; or why that would not help.
    fn halved(
        &self,
        surface: &Surface,
        case: &Case<'_>,
        most: usize,
        profile: &[(f64, Deviation)],
        history: &mut History,
    ) -> Result<Result<Surface, Why>, OperationError> {
        let (space, folded) = (surface.space(case.along), self.continuity > 0 && Deviation::folded(profile));
        let stuck = history.is_stuck();
        let outside = |a: f64, b: f64| {
            let within = |one: &Deviation| one.within(self.continuity, case.distance, &self.limits);
            profile.iter().any(|(t, one)| *t >= a && *t <= b && !within(one))
        };
        let mut knots = Vec::new();
        for piece in space.breakpoints().windows(2) {
            let (a, b) = (piece[0], piece[1]);
            // Where knots at some spans only moved what is left to others, all are halved.
            if (stuck.is_some() || outside(a, b)) && b - a > SHORTEST * space.length() {
                knots.push(0.5 * a + 0.5 * b);
            }
        }
        let hopeless = stuck == Some(Stuck::Everywhere) || folded;
        let needed = history.needed().filter(|needed| *needed > DOUBTFUL * most);
        if hopeless
            || needed.is_some()
            || knots.is_empty()
            || space.len() + knots.len() > most
            || !self.refine
        {
            let back = |(_, one): &(f64, Deviation)| one.angle > std::f64::consts::FRAC_PI_2;
            return Ok(Err(if case.lay_on && folded {
                Why::LayOn
            } else if folded {
                Why::Folds
            } else if self.continuity > 0 && profile.iter().any(back) {
                Why::FoldsInPart
            } else if let (true, false, Some(needed)) = (self.refine, hopeless, needed) {
                Why::Needs { needed, most }
            } else {
                Why::Limits
            }));
        }
        if stuck.is_some() {
            history.all_halved();
        }
        Ok(Ok(surface.insert_knots(case.along, &knots)?))
    }
}

/// How many rows have a say in so many derivatives at an end: at one that is not clamped, all of the last span.
fn say(across: &Space, rows: usize) -> usize {
    if across.is_clamped() { rows } else { across.degree().max(rows) }
}

/// What is matched.
struct Case<'a> {
    surface: &'a Surface,
    other: &'a dyn Shape,
    along: Direction,
    /// Whether the edge is where the parameter across ends.
    at_end: bool,
    /// How the other edge runs beside this one, and where it begins.
    begun: Begun,
    /// The larger edge's size.
    size: f64,
    /// The allowed distance.
    distance: f64,
    before: Deviation,
    /// Whether the surface lay on the other, folded back, before.
    lay_on: bool,
}

/// Control vertices along the edge of all surfaces that were tried, and how many there may be.
struct Work {
    called: &'static str,
    done: usize,
    most: usize,
}

impl Work {
    /// As much again as was done, and so much in any case, for another way.
    fn as_much_again(&self) -> Self {
        const LEAST: usize = 1024;
        Self { called: self.called, done: 0, most: (2 * self.done).max(LEAST) }
    }
}

/// Knots that are closer together than this part of their domain hide how much a surface bends.
const CLOSE: f64 = 1e-4;

/// Why it cannot be measured how much a surface bends: its degree, or which of its knots are closest together, by the length of their domain.
fn too_close(surface: &Surface) -> String {
    let mut closest = (f64::INFINITY, "u", 0.0, 0.0);
    for (name, space) in [("u", surface.u()), ("v", surface.v())] {
        for pair in space.breakpoints().windows(2) {
            let (gap, share) = (pair[1] - pair[0], (pair[1] - pair[0]) / space.length());
            if share < closest.0 {
                closest = (share, name, pair[0], gap);
            }
        }
    }
    let (share, name, at, gap) = closest;
    if share > CLOSE {
        let degree = surface.u().degree().max(surface.v().degree());
        return format!(
            "how much the surface bends cannot be measured: rounding hides that of degree {degree}"
        );
    }
    format!(
        "how much the surface bends cannot be measured: its knots at {name} = {} are only {} apart",
        figure(at),
        short(gap)
    )
}

/// The surface raised and refined along its edge so that its space there has the knots and the degree of the other edge, and whether it holds that then, which
/// other weights keep it from; `None` where it does already, or where spaces do not go together.
fn as_the_other(
    surface: &Surface,
    along: Direction,
    edge: EdgeCurve,
    there: &EdgeCurve,
    begun: Begun,
) -> Result<Option<(Surface, bool)>, Error> {
    let beside = Beside::begun(edge, &there.curve, begun)?;
    if beside.exactly()?.is_ok() {
        return Ok(None);
    }
    let Ok(common) = surface.space(along).common(beside.curve.space()) else { return Ok(None) };
    if common.first.last().is_some_and(|step| step.to().len() > MOST[2]) {
        return Ok(None);
    }
    let mut refined = surface.clone();
    for step in &common.first {
        refined = refined.convert(along, step)?;
    }
    let shapes = [&refined as &dyn Shape];
    let index = beside.edge.edge.name.clone();
    let shape = shapes[0];
    let number = loftsman_kernel::shape::edges_of(shape, "match")?.iter().position(|e| e.name == index);
    let Some(number) = number else { return Ok(None) };
    let alike = Beside::begun(EdgeCurve::of(shape, number, "match")?, &there.curve, begun)?;
    let exact = alike.exactly()?.is_ok();
    Ok((exact || !common.first.is_empty()).then_some((refined, exact)))
}
