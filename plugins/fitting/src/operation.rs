//! The operation `fit`: points become a curve.

use std::borrow::Cow;

use loftsman_kernel::edit::Constraint;
use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::functional::ShapeNames;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{
    ConstraintReport, Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters,
    StepReport, asked_in_own_coordinates, constraint_from, functional_from, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::text::{figure, short, without_rounding};
use loftsman_kernel::{Error, Point};

use crate::corner::Corners;
use crate::error::FitError;
use crate::fit::{Fit, FittedCurve, Target};
use crate::interpolation::{Duplicates, Ends, Interpolation};
use crate::parameters::Parametrization;

/// The tolerance where none is given, as a share of the points' size.
const DEFAULT_RELATIVE: f64 = 1e-4;

/// A turn between neighbouring points beyond this angle is a corner: 60°.
const CORNER: f64 = std::f64::consts::FRAC_PI_3;

/// A smooth curve that leaves the straight sides of a turn by more than so many tolerances is told of,
const ROUNDED: f64 = 4.0;
/// where the points turn by 20° or more, and beside by less than this part of it;
const STRAIGHT_SIDES: f64 = std::f64::consts::PI / 9.0;
const STRAIGHT: f64 = 0.1;
/// it is looked at in so many places on a side.
const PLACES: u32 = 9;

/// The operation `fit`: a polyline, cloud or mesh (its points in their order) becomes a B-spline curve, by least
/// squares to a tolerance, with a given number of vertices, or by interpolation.
#[derive(Debug, Clone, Copy, Default)]
pub struct FitPoints;

const DECLARATION: Declaration = Declaration {
    name: "fit",
    help: "a polyline, a cloud or a mesh's points, in their order, become a B-spline curve",
    fields: &[
        Field::optional(
            "object",
            "text",
            "the only polyline; where there is none, the only cloud or mesh",
            "the object whose points are fitted; the curve takes its place",
        ),
        Field::optional("degree", "1 to 25", "3", "the degree of the curve"),
        Field::optional(
            "tolerance",
            "number",
            "none",
            "no point farther from the curve than this, in document units",
        ),
        Field::optional(
            "relative_tolerance",
            "number",
            "1e-4 where nothing else is asked for",
            "the same as a share of the diagonal of the points' box",
        ),
        Field::optional(
            "vertices",
            "whole number",
            "as many as the tolerance needs",
            "how many control vertices; with a tolerance, at most how many",
        ),
        Field::optional("interpolate", "true | false", "false", "pass through every point exactly"),
        Field::optional(
            "closed",
            "true | false",
            "as the polyline; false for others",
            "close the curve smoothly (periodic); false for a closed polyline keeps the corner where it starts",
        ),
        Field::optional(
            "corners",
            "degrees | \"auto\"",
            "none: a smooth curve",
            "divide the fit where the points turn by more than this; \"auto\": by more than 60°, and as sharply over six tolerances. Where the turn is shared by the points before and after (a round nose) there is no corner",
        ),
        Field::optional(
            "parameters",
            "\"chord\" | \"centripetal\" | \"uniform\" | [numbers]",
            "\"chord\"; \"centripetal\" where interpolation swings",
            "the parameters to start from; a list has one number a point, and one more for a closed curve",
        ),
        Field::optional(
            "corrections",
            "whole number",
            "4",
            "the most parameter corrections between two additions of knots; 0 keeps the parameters",
        ),
        Field::optional(
            "ends",
            "\"keep\" | \"free\"; interpolating: \"averaged\" | \"not-a-knot\" | \"natural\"",
            "\"keep\"; \"averaged\"",
            "what an open curve does at its ends",
        ),
        Field::optional(
            "merge",
            "true | false",
            "false",
            "leave out points that coincide with the one before, when interpolating",
        ),
        Field::optional("weights", "[numbers]", "all 1", "a positive weight a point"),
        Field::optional(
            "constraints",
            "[{ kind, …, to }, …]",
            "none",
            "what must hold exactly, at locations from 0 to 1",
        ),
        Field::optional(
            "regularization",
            "number",
            "0",
            "how strongly to straighten vertices that the points leave open (1e-6 is little)",
        ),
        Field::optional(
            "smooth",
            "true | false",
            "true",
            "spend what the tolerance leaves over on an even curvature",
        ),
        Field::optional(
            "best_effort",
            "true | false",
            "false",
            "take the best curve found where the tolerance cannot be met",
        ),
    ],
};

impl Operation for FitPoints {
    fn declaration(&self) -> Declaration {
        DECLARATION
    }

    fn object(&self, scene: &Scene, parameters: &Parameters) -> Result<String, ParameterError> {
        let lines = scene.objects().iter().any(|o| matches!(o.geometry(), Geometry::Polyline(_)));
        let fits = |g: &Geometry| match g {
            Geometry::Polyline(_) => true,
            Geometry::Cloud(_) | Geometry::Mesh(_) => !lines,
            _ => false,
        };
        object_name(scene, parameters, fits, "polyline, cloud or mesh")
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(DECLARATION.fields)?;
        let name = self.object(scene, parameters)?;
        let name = name.as_str();
        let object = scene.object(name).map_err(|e| parameters.error("object", e.to_string()))?;
        let (points, chain) = match object.geometry() {
            Geometry::Polyline(line) => (line.points.as_slice(), line.closed),
            Geometry::Cloud(cloud) => (cloud.points.as_slice(), false),
            Geometry::Mesh(mesh) => {
                one_chain(mesh).map_err(|what| {
                    Error::Invalid(format!(
                        "\"{name}\" is a mesh of {what}, and a curve would go through the points of all, one after the other: \
                         converted to OBJ and read from there each line is a polyline, to fit by itself"
                    ))
                })?;
                (mesh.points(), false)
            }
            other => {
                let kind = loftsman_kernel::text::a(&other.noun());
                return Err(Error::Invalid(format!(
                    "\"{name}\" is {kind}: points are fitted, so give a polyline, a cloud or a mesh"
                ))
                .into());
            }
        };
        let closed = if parameters.has("closed") { parameters.flag("closed")? } else { chain };
        // A closed chain that is fitted open keeps its corner where it starts, and still comes back there.
        let back = chain && !closed && !parameters.has("parameters") && !parameters.has("weights");
        let points: Cow<'_, [Point]> = match points.first() {
            Some(&first) if back => points.iter().copied().chain([first]).collect(),
            _ => points.into(),
        };
        let points = points.as_ref();
        let (curve, mut report) = if parameters.flag("interpolate")? {
            interpolate(points, closed, parameters, scene.unit)?
        } else {
            let fit = fit_of(closed, name, parameters, context)?;
            let fitted = fit.watched(points, context.observer)?;
            let mut report = report_of(&fitted, points, scene.unit);
            if parameters.has("corners") {
                report.notes.extend(rounded(&fitted, points, closed, scene.unit)?);
            }
            (fitted.curve, report)
        };
        if is_scattered(points) {
            report.warnings.push(
                "the curve goes through the points in the order in which they are, and turns back at most of them: points that lie all over a surface, and not \
                 along a line, are fitted by `fit-shape`"
                    .into(),
            );
        } else if !parameters.has("corners") {
            report.notes.extend(corner(points, closed, parameters)?);
        }
        report.notes.extend(asked_in_own_coordinates(scene, name)?);
        let report = StepReport { op: DECLARATION.name.into(), object: Some(name.to_owned()), ..report };
        scene.replace(name, curve)?;
        Ok(report)
    }
}

/// Whether a mesh of nothing but lines is one chain, else what it is.
fn one_chain(mesh: &Mesh) -> Result<(), String> {
    if mesh.face_count() > 0 || mesh.lines().next().is_none() {
        return Ok(());
    }
    let same = mesh.welded();
    // Each point's lines, and which point stands for all that hang together with it.
    let mut ends = vec![0_usize; same.len()];
    let mut above: Vec<u32> = (0..same.len() as u32).collect();
    let top = |above: &mut Vec<u32>, mut k: u32| {
        while above[k as usize] != k {
            let next = above[above[k as usize] as usize];
            above[k as usize] = next;
            k = next;
        }
        k
    };
    for pair in mesh.lines().flat_map(|line| line.windows(2)) {
        let [p, q] = [pair[0], pair[1]].map(|k| same[k as usize]);
        if p == q {
            continue;
        }
        ends[p as usize] += 1;
        ends[q as usize] += 1;
        let (p, q) = (top(&mut above, p), top(&mut above, q));
        above[p.max(q) as usize] = p.min(q);
    }
    let chains = (0..above.len()).filter(|&k| ends[k] > 0 && above[k] as usize == k).count();
    if chains > 1 {
        return Err(format!("{chains} separate lines"));
    }
    if ends.iter().any(|&count| count > 2) {
        return Err("lines that branch".into());
    }
    Ok(())
}

/// Points of which more than this part turn back are no line.
const BACK: f64 = 0.25;
/// Fewer points than this may do what they like.
const FEW: usize = 24;

/// Whether points in their order go to and fro: at more than a quarter of them by more than a right angle.
fn is_scattered(points: &[Point]) -> bool {
    let turns = points.windows(3).filter(|p| (p[1] - p[0]).dot(&(p[2] - p[1])) < 0.0).count();
    points.len() >= FEW && turns as f64 > BACK * points.len() as f64
}

/// What to say where the points turn too sharply for the curve: the sharpest corner, and what to do. One of degree 1 through all points
/// has all corners that they have.
fn corner(points: &[Point], closed: bool, parameters: &Parameters) -> Result<Option<String>, ParameterError> {
    let (interpolates, straight) = (parameters.flag("interpolate")?, degree_of(parameters)? == 1);
    if interpolates && straight {
        return Ok(None);
    }
    let n = points.len();
    let turn = |k: usize| turn(points, k);
    let range = if closed { 0..n } else { 1..n.saturating_sub(1) };
    let (angle, k) = range.map(|k| (turn(k), k)).fold((0.0, 0), |m, t| if t.0 > m.0 { t } else { m });
    if angle < CORNER {
        return Ok(None);
    }
    let advice = match (closed, k) {
        _ if interpolates => {
            "a `fit` without `interpolate` keeps such corners (corners = \"auto\", or an angle in degrees)"
        }
        (true, 0) => {
            "closed = false keeps the corner there, corners = \"auto\" (or an angle in degrees) all such"
        }
        _ => "corners = \"auto\", or an angle in degrees, keeps such corners",
    };
    let keeps = if straight {
        "a curve of degree 1 keeps only where it has a vertex there"
    } else {
        "a smooth curve can only round or overshoot"
    };
    let angle = angle.to_degrees();
    Ok(Some(format!("the points turn by {angle:.0}° at point {k}, which {keeps}: {advice}")))
}

/// The turn of a chain, which may be closed, at a point.
fn turn(points: &[Point], k: usize) -> f64 {
    let n = points.len();
    let before = points[k] - points[(k + n - 1) % n];
    let after = points[(k + 1) % n] - points[k];
    // Of unit vectors, so that no square overflows; a repeated point turns nowhere.
    let (a, b) = (before / before.amax(), after / after.amax());
    Some(a.angle(&b)).filter(|angle| angle.is_finite()).unwrap_or(0.0)
}

/// What to say where corners were asked for and the points turn, by less than that, between straight sides: where a smooth curve leaves such
/// sides farthest, and by more than [`ROUNDED`] tolerances. Beside a vertex of a round chain the points turn, too.
fn rounded(
    fitted: &FittedCurve,
    points: &[Point],
    closed: bool,
    unit: Unit,
) -> Result<Option<String>, Error> {
    let m = fitted.parameters.len().min(points.len());
    let points = &points[..m];
    let Some(tolerance) = fitted.tolerance.filter(|_| m > 4) else { return Ok(None) };
    let (start, end) = fitted.curve.domain();
    let mut worst = None::<(f64, usize)>;
    for k in if closed { 0..m } else { 2..m - 2 } {
        let own = turn(points, k);
        let flanks = turn(points, (k + m - 1) % m).max(turn(points, (k + 1) % m));
        if own < STRAIGHT_SIDES || flanks > STRAIGHT * own || fitted.corners.contains(&k) {
            continue;
        }
        for [a, b] in [[(k + m - 1) % m, k], [k, (k + 1) % m]] {
            let (from, mut to) = (fitted.parameters[a], fitted.parameters[b]);
            if to < from {
                to += end - start;
            }
            let side = points[b] - points[a];
            let along = side / side.norm();
            for i in 1..PLACES {
                let u = from + (to - from) * f64::from(i) / f64::from(PLACES);
                let off = fitted.curve.point(if u > end { u - (end - start) } else { u })? - points[a];
                let off = (off - along * off.dot(&along).clamp(0.0, side.norm())).norm();
                if off > worst.map_or(ROUNDED * tolerance, |(most, _)| most) {
                    worst = Some((off, k));
                }
            }
        }
    }
    Ok(worst.map(|(off, k)| {
        let angle = turn(points, k).to_degrees();
        format!(
            "the points turn by {angle:.0}° at point {k}, between straight sides that the smooth curve there leaves by {}: corners = {:.0} keeps the corner",
            unit.quantity(off, 1),
            (angle - 0.5).floor()
        )
    }))
}

fn degree_of(parameters: &Parameters) -> Result<usize, ParameterError> {
    let degree = parameters.count_or("degree", 3)?;
    if (1..=MAX_DEGREE).contains(&degree) {
        return Ok(degree);
    }
    Err(parameters.error("degree", format!("is from 1 to {MAX_DEGREE}, not {degree}")))
}

fn parametrization(parameters: &Parameters) -> Result<Parametrization, ParameterError> {
    if !parameters.has("parameters") {
        return Ok(Parametrization::default());
    }
    if parameters.text("parameters").is_err() {
        return Ok(Parametrization::Given(parameters.numbers("parameters")?));
    }
    let known = [("chord", 0_u8), ("centripetal", 1), ("uniform", 2)];
    Ok(match parameters.choice("parameters", &known)? {
        1 => Parametrization::Centripetal,
        2 => Parametrization::Uniform,
        _ => Parametrization::ChordLength,
    })
}

fn corners_of(parameters: &Parameters) -> Result<Corners, ParameterError> {
    if !parameters.has("corners") {
        return Ok(Corners::None);
    }
    if parameters.text("corners").is_ok() {
        return parameters.choice("corners", &[("auto", Corners::Auto)]);
    }
    let degrees = parameters.number("corners")?;
    if degrees > 0.0 && degrees < 180.0 {
        return Ok(Corners::Angle(degrees.to_radians()));
    }
    Err(parameters.error("corners", "is a turn in degrees between 0 and 180, or \"auto\""))
}

/// Interpolation, and what there is to say about it.
fn interpolate(
    points: &[Point],
    closed: bool,
    parameters: &Parameters,
    unit: Unit,
) -> Result<(loftsman_kernel::spline::Curve, StepReport), OperationError> {
    const LEAST_SQUARES: [&str; 10] = [
        "corners",
        "tolerance",
        "relative_tolerance",
        "vertices",
        "corrections",
        "weights",
        "constraints",
        "regularization",
        "smooth",
        "best_effort",
    ];
    if let Some(field) = LEAST_SQUARES.into_iter().find(|f| parameters.has(f)) {
        let problem = "has no meaning where every point is interpolated; leave it or \"interpolate\" out";
        return Err(parameters.error(field, problem).into());
    }
    let ends = if parameters.has("ends") {
        let words =
            [("averaged", Ends::Averaged), ("not-a-knot", Ends::NotAKnot), ("natural", Ends::Natural)];
        let choices: Vec<(&str, usize)> = words.iter().enumerate().map(|(i, (word, _))| (*word, i)).collect();
        let choice = parameters.choice("ends", &choices)?;
        words.into_iter().nth(choice).map(|(_, ends)| ends).unwrap_or_default()
    } else {
        Ends::default()
    };
    let interpolation = Interpolation {
        degree: degree_of(parameters)?,
        closed,
        parameters: parametrization(parameters)?,
        ends,
        duplicates: if parameters.flag("merge")? { Duplicates::Merge } else { Duplicates::Refuse },
    };
    let (through, instead) = match interpolation.curve(points) {
        // Nobody asked for these parameters.
        Err(FitError::Astray { astray, .. }) if !parameters.has("parameters") => (
            centripetal(&interpolation)
                .curve(points)
                .map_err(|error| calmed(error, &interpolation, points, true))?,
            Some(format!("centripetal parameters: by chord length the curve {astray}")),
        ),
        other => {
            let any = !parameters.has("parameters");
            (other.map_err(|error| calmed(error, &interpolation, points, any))?, None)
        }
    };
    let size = points.iter().fold(0.0_f64, |most, p| most.max(p.coords.amax()));
    let miss = match without_rounding(through.residual, size) {
        0.0 => String::new(),
        miss => format!(", to {}", unit.quantity(miss, 1)),
    };
    let mut notes = vec![format!(
        "{} control vertices through {} points{miss}",
        through.curve.points().len(),
        points.len() - through.merged.len()
    )];
    notes.extend(instead);
    if !through.merged.is_empty() {
        notes.push(format!(
            "{} coincident points merged (first: {})",
            through.merged.len(),
            through.merged[0]
        ));
    }
    let report = StepReport {
        residual: Some(through.residual),
        condition: Some(through.condition),
        iterations: Some(1),
        notes,
        leading: 1,
        ..StepReport::default()
    };
    Ok((through.curve, report))
}

fn centripetal(interpolation: &Interpolation) -> Interpolation {
    Interpolation { parameters: Parametrization::Centripetal, ..interpolation.clone() }
}

/// What to do where an interpolation does not follow its points: the highest degree below at which it does, tried, with the same parameters or, where
/// `any` will do, with centripetal ones.
fn calmed(error: FitError, interpolation: &Interpolation, points: &[Point], any: bool) -> FitError {
    let what = match &error {
        FitError::Astray { astray, .. } => format!("the curve {astray}: it goes astray between the points"),
        FitError::IllConditioned { condition, .. } => {
            format!("the equations are singular to working precision (condition {})", short(*condition))
        }
        _ => return error,
    };
    let follows = |degree: &usize| {
        let lower = Interpolation { degree: *degree, ..interpolation.clone() };
        lower.curve(points).is_ok() || any && centripetal(&lower).curve(points).is_ok()
    };
    match (1..interpolation.degree).rev().find(follows) {
        Some(degree) => FitError::Request(format!(
            "{what}; degree = {degree} follows the points, or fit to a tolerance (without \"interpolate\")"
        )),
        None => error,
    }
}

/// The fit that the fields ask for.
fn fit_of(
    closed: bool,
    object: &str,
    parameters: &Parameters,
    context: &Context<'_>,
) -> Result<Fit, OperationError> {
    if parameters.has("merge") {
        let problem = "is for interpolation only: least squares takes coincident points as they are";
        return Err(parameters.error("merge", problem).into());
    }
    let mut fit = Fit::new(degree_of(parameters)?, target_of(parameters)?);
    if let Target::Vertices(vertices) | Target::AtMost { vertices, .. } = fit.target {
        let least = if closed { 2 } else { fit.degree + 1 };
        if vertices < least {
            let shape = if closed {
                "a closed curve".to_owned()
            } else {
                format!("a curve of degree {}", fit.degree)
            };
            return Err(parameters
                .error("vertices", format!("{shape} has {least} or more, not {vertices}"))
                .into());
        }
    }
    fit.closed = closed;
    fit.parameters = parametrization(parameters)?;
    fit.corrections = parameters.count_or("corrections", fit.corrections)?;
    if parameters.has("ends") {
        fit.keep_ends = parameters.choice("ends", &[("keep", true), ("free", false)])?;
    }
    if parameters.has("weights") {
        fit.weights = Some(parameters.numbers("weights")?);
    }
    fit.corners = corners_of(parameters)?;
    fit.regularization = parameters.number_or("regularization", 0.0)?;
    if parameters.has("smooth") {
        fit.smooth = parameters.flag("smooth")?;
    }
    fit.best_effort = parameters.flag("best_effort")?;
    for table in parameters.tables("constraints")? {
        fit.constraints.push(constraint_of(&table, object, context)?);
    }
    Ok(fit)
}

fn target_of(parameters: &Parameters) -> Result<Target, OperationError> {
    let vertices = if parameters.has("vertices") { Some(parameters.count("vertices")?) } else { None };
    let absolute = if parameters.has("tolerance") { Some(parameters.number("tolerance")?) } else { None };
    if absolute.is_some() && parameters.has("relative_tolerance") {
        let problem = "stands beside \"tolerance\"; give one of them";
        return Err(parameters.error("relative_tolerance", problem).into());
    }
    let relative = parameters.number_or("relative_tolerance", DEFAULT_RELATIVE)?;
    Ok(match (absolute, vertices) {
        (Some(tolerance), Some(vertices)) => Target::AtMost { tolerance, vertices },
        (Some(tolerance), None) => Target::Tolerance(tolerance),
        (None, Some(_)) if parameters.has("relative_tolerance") => {
            let problem = "limits a \"tolerance\" in document units; give that one, or no vertices";
            return Err(parameters.error("vertices", problem).into());
        }
        (None, Some(vertices)) => Target::Vertices(vertices),
        (None, None) => Target::Relative(relative),
    })
}

/// A constraint of the recipe: the functional's own fields, and the value it must have.
fn constraint_of(
    table: &Parameters,
    object: &str,
    context: &Context<'_>,
) -> Result<Constraint, OperationError> {
    for word in ["at_least", "at_most"] {
        if table.has(word) {
            let problem =
                "a fit takes equations only, with \"to\": fit first, then edit the curve with this bound";
            return Err(table.error(word, problem).into());
        }
    }
    for word in ["by", "scale", "keep"] {
        if table.has(word) {
            let problem = "needs a shape that is there already; a fit can only be told a value, with \"to\"";
            return Err(table.error(word, problem).into());
        }
    }
    let mut names = OnlyItself { object };
    // "says nothing: give one of" would name words that a fit does not take.
    if !table.has("to")
        && !functional_from(context.registry, &table.without(&["axis"]), &mut names)?.is_condition()
    {
        return Err(table.error("to", "is missing: say which value it should have with `to`").into());
    }
    Ok(constraint_from(context.registry, table, &mut names)?)
}

/// A fit has one shape: the curve that it makes.
struct OnlyItself<'a> {
    object: &'a str,
}

impl ShapeNames for OnlyItself<'_> {
    fn shape(&mut self, object: &str) -> loftsman_kernel::Result<usize> {
        if object == self.object {
            return Ok(0);
        }
        Err(Error::Invalid(format!(
            "a fit holds constraints on \"{}\" only, not on \"{object}\"",
            self.object
        )))
    }
}

fn report_of(fitted: &FittedCurve, points: &[Point], unit: Unit) -> StepReport {
    let length = |x: f64| unit.quantity(x, 1);
    // Errors that are rounding at the size of the curve are none.
    let error = |x: f64| length(without_rounding(x, fitted.length));
    let vertices = fitted.curve.points().len();
    let place = points.get(fitted.farthest).map(|p| format!(" {}", place(p))).unwrap_or_default();
    let mut notes = vec![format!(
        "largest distance from the points {}, at point {}{place}; root mean square at their parameters {}; {vertices} control vertices for {} points",
        error(fitted.distance),
        fitted.farthest,
        error(fitted.rms_error),
        points.len()
    )];
    match fitted.tolerance {
        Some(tolerance) if !fitted.met => {
            notes.push(format!("best effort: the tolerance {} is not met", length(tolerance)));
        }
        Some(tolerance) => notes.push(format!("the tolerance {} is met", length(tolerance))),
        None => {}
    }
    let leading = notes.len();
    notes.push(format!(
        "length {}, the polygon of the points {}",
        length(fitted.length),
        length(fitted.polygon_length)
    ));
    if fitted.interpolated {
        notes.push(if fitted.tolerance.is_some() {
            "nothing less than interpolation met the tolerance".into()
        } else {
            "as many control vertices as points: interpolated".into()
        });
    }
    notes.extend(fitted.remarks.iter().cloned());
    if !fitted.corners.is_empty() {
        let first: Vec<String> = fitted.corners.iter().take(8).map(ToString::to_string).collect();
        let more = if fitted.corners.len() > 8 { ", …" } else { "" };
        let (count, plural) = (fitted.corners.len(), if fitted.corners.len() == 1 { "" } else { "s" });
        notes.push(format!("{count} corner{plural}, at point{plural} {}{more}", first.join(", ")));
    }
    if fitted.closing_point_dropped {
        notes.push("the last point repeats the first and was left out of the closed curve".into());
    }
    let kept = &fitted.kept;
    let constraint = |(name, residual): &(String, f64)| ConstraintReport {
        between: None,
        name: name.clone().into(),
        residual: *residual,
        ..ConstraintReport::default()
    };
    StepReport {
        residual: Some(kept.residuals.iter().fold(0.0, |m, (_, r)| r.max(m))),
        condition: Some(fitted.condition),
        iterations: Some(fitted.iterations),
        redundant: kept.redundant.clone(),
        constraints: kept.residuals.iter().map(constraint).collect(),
        notes,
        leading,
        ..StepReport::default()
    }
}

/// `(0.5, 0, 1)`: what is rounding beside the largest coordinate is 0.
pub(crate) fn place(point: &Point) -> String {
    let size = point.coords.amax();
    let told: Vec<String> = point.iter().map(|&x| figure(without_rounding(x, size))).collect();
    format!("({})", told.join(", "))
}
