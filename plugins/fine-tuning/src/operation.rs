//! `fine-tune`: derivatives scaled, in recipes.

mod springs;
mod surface;

use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::error::{Figure, MAX_DEGREE};
use loftsman_kernel::functional::position;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Mark, MarkKind, Operation, OperationError, ParameterError, Parameters,
    SceneShapes, StepReport, asked_in_own_coordinates, constraint_from, editable, object_name, put_back,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::text::{a, figure};

use crate::{Ends, FineTune, TuneReport, alpha_of, alpha_space};

/// The operation `fine-tune`.
#[derive(Debug, Clone, Copy, Default)]
pub struct FineTuneOperation;

const FIELDS: [Field; 15] = [
    Field::optional("object", "text", "the only curve or surface", "the object to tune"),
    Field::optional(
        "alpha",
        "number | [value, …] | { degree, knots, values } | [{ edge = [vertex, vertex], value }, …]",
        "needed, but for surfaces with alpha_u or alpha_v",
        "what the derivative is multiplied by, so that curvature is divided by it: values on the derivative's own knots (one less than \
         an open curve has vertices; as many as a periodic one with simple knots), or a spline function of its own, over the curve's domain \
         or the range; of a surface rows of values, or { degree = [p, q], knots = [[…], […]], values }; of a mesh or a polyline what its \
         edges are multiplied by, 1 where nothing is said",
    ),
    Field::optional(
        "alpha_u",
        "number | [value, …] | { degree, knots, values }",
        "1",
        "what a surface's derivative along u is multiplied by, a function of u",
    ),
    Field::optional(
        "alpha_v",
        "number | [value, …] | { degree, knots, values }",
        "1",
        "what its derivative along v is multiplied by, a function of v",
    ),
    Field::optional(
        "direction",
        "\"u\" | \"v\" | \"both\"",
        "needed where alpha is of a surface",
        "alpha is then a number or rows of values, for this direction's derivative or, in least squares, for both",
    ),
    Field::optional(
        "ends",
        "\"exact\" | \"free\" | \"position\" | \"tangent\" | \"curvature\" | [u, v]",
        "exact",
        "exact: the ends stay, because alpha is changed for it as little as it can be; free: the start stays; the others turn and scale \
         the whole, and put the outermost one, two or three control vertices at either end back to where they were; of a surface of both directions, or one of u and one of v",
    ),
    Field::optional(
        "range",
        "[from, to] | [[from, to], [from, to]], each a number or { closest = [x, y, z] }",
        "the whole",
        "tune this part only; the rest stays as it is; of a surface [] is all of a direction",
    ),
    Field::optional(
        "continuity",
        "0 | 1 | 2",
        "2 where a range joins the rest, else 0",
        "derivatives that stay at the ends; exact ends only",
    ),
    Field::optional(
        "through",
        "[{ at, to }, …]",
        "none",
        "points that the tuned curve passes; exact ends only",
    ),
    Field::optional(
        "alpha_at",
        "[{ at, to }, …]",
        "none",
        "places where alpha has just this value, and the curvature is divided by just this; of a surface at = [u, v]; exact ends only",
    ),
    Field::optional(
        "constraints",
        "[{ kind, …, to | by | scale | keep | at_least | at_most }, …]",
        "none",
        "what else is asked of the tuned curve; exact ends only",
    ),
    Field::optional(
        "lock",
        "[index, …]",
        "the first of each piece",
        "vertices that stay; of meshes and polylines only",
    ),
    Field::optional(
        "any_sign",
        "true | false",
        "false",
        "let alpha be zero or negative, so that tangents turn round",
    ),
    Field::optional(
        "force",
        "true | false",
        "false",
        "take the answer also where what is asked nearly contradicts itself, so that alpha changes by far more than each alone would take",
    ),
    Field::optional(
        "solver",
        "name",
        "automatic",
        "the solver; `loftsman plugins` lists them; exact ends only",
    ),
];

impl Operation for FineTuneOperation {
    fn declaration(&self) -> Declaration {
        Declaration {
            name: "fine-tune",
            help: "scale the derivative: directions stay, curvature is divided by alpha",
            fields: &FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let object = tuned_object(scene, parameters)?;
        let curve = match scene.object(&object)?.geometry() {
            Geometry::Curve(curve) => curve.clone(),
            Geometry::Mesh(_) | Geometry::Polyline(_) => return springs::sprung(scene, parameters, &object),
            Geometry::Surface(surface) => {
                let surface = surface.clone();
                return of_surface(scene, parameters, context, &object, &surface);
            }
            other => {
                let own = match other {
                    Geometry::Custom(_) => " (of a cage its mesh, before it is the cage of a surface)",
                    _ => "",
                };
                let problem = format!(
                    "\"{object}\" is {}: what is tuned is a curve, a surface, or the edges of a mesh or a polyline{own}",
                    a(other.kind())
                );
                return Err(parameters.error("object", problem).into());
            }
        };
        for name in ["alpha_u", "alpha_v", "direction"] {
            if parameters.has(name) {
                return Err(parameters.error(name, "is for surfaces: a curve has one alpha").into());
            }
        }
        if parameters.has("lock") {
            return Err(parameters
                .error("lock", "is for meshes and polylines; a curve keeps its ends")
                .into());
        }
        let (range, ends) = (range(parameters)?, ends(parameters)?);
        check_solved(parameters, ends)?;
        let alpha = alpha(parameters, "alpha", &curve, range, ends)?;
        let over = alpha.space().clone();
        let mut tune = FineTune::new(&curve, alpha).ends(ends);
        if let Some((a, b)) = range {
            tune = tune.between(a, b);
        }
        if parameters.has("continuity") {
            tune = tune.continuity(continuity(parameters)?);
        }
        if parameters.flag("any_sign")? {
            tune = tune.any_sign();
        }
        if parameters.flag("force")? {
            tune = tune.force();
        }
        let mut asked = Vec::new();
        for place in places(parameters, "through")? {
            let (at, to) = (place.number("at")?, place.point("to")?);
            curve.space().locate(at).map_err(|error| place.error("at", error.to_string()))?;
            asked.push(position(at).to(to));
            tune = tune.through(at, to);
        }
        for (k, place) in places(parameters, "alpha_at")?.iter().enumerate() {
            let at = over_the_seam(place.number("at")?, &curve, range);
            over.locate(at).map_err(|error| place.error("at", error.to_string()))?;
            let value = position(at).on(1).axis(Axis::X).to(alpha_there(parameters, place)?);
            tune = tune.ask(value.called(&format!("alpha_at[{k}]")));
        }
        let mut names = SceneShapes::new(scene, &object)?;
        for (k, table) in parameters.tables("constraints")?.iter().enumerate() {
            let constraint = constraint_from(context.registry, table, &mut names)?;
            let name = constraint.describe();
            let known = asked.iter().any(|other: &Constraint| other.describe() == name);
            let constraint =
                if known { constraint.called(&format!("{name} (constraints[{k}])")) } else { constraint };
            if names.shapes().len() > 1 {
                return Err(table
                    .error(
                        "",
                        "what is asked beside fine tuning is asked of the curve alone, not of other objects",
                    )
                    .into());
            }
            asked.push(constraint.clone());
            tune = tune.ask(constraint);
        }
        let solver = parameters.text_or("solver", "automatic")?;
        let solver = context.registry.find_solver(solver, &format!("{}.solver", parameters.path()))?;
        let start = context.clock.seconds();
        let tuned = tune.solve_with(Arc::clone(solver))?;
        let seconds = context.clock.seconds() - start;
        let mut report = report(&object, &curve, tuned.curve(), tuned.report(), seconds, (ends, &asked));
        if !asked.is_empty() {
            report.notes.extend(asked_in_own_coordinates(scene, &object)?);
        }
        put_back(scene, &object, tuned.curve())?;
        Ok(report)
    }
}

/// A surface's derivatives scaled.
fn of_surface(
    scene: &mut Scene,
    parameters: &Parameters,
    context: &Context<'_>,
    object: &str,
    given: &Surface,
) -> Result<StepReport, OperationError> {
    let solver = parameters.text_or("solver", "automatic")?;
    let solver = context.registry.find_solver(solver, &format!("{}.solver", parameters.path()))?;
    let start = context.clock.seconds();
    let (tuned, report) = surface::tuned(parameters, given, Arc::clone(solver))?;
    let seconds = context.clock.seconds() - start;
    put_back(scene, object, &tuned)?;
    Ok(StepReport {
        op: "fine-tune".into(),
        object: Some(object.into()),
        prepare_seconds: Some(seconds),
        ..report
    })
}

fn report(
    object: &str,
    before: &Curve,
    after: &Curve,
    tuned: &TuneReport,
    seconds: f64,
    (ends, asked): (Ends, &[Constraint]),
) -> StepReport {
    let [least, most] = tuned.alpha;
    let mut notes = vec![format!(
        "alpha {} to {}, changed by {} in the mean; degree {} → {}",
        short(least),
        short(most),
        figure(tuned.change),
        before.degree(),
        after.degree()
    )];
    if tuned.scale != 1.0 {
        notes.push(format!(
            "scaled by {} to keep the ends: curvature is divided by alpha times that{}",
            short(tuned.scale),
            match ends {
                Ends::Tangent | Ends::Curvature => ", but near the ends, which are bent back",
                _ => "",
            }
        ));
    }
    notes.extend(tuned.notes.iter().cloned());
    let names = [object.to_owned()];
    let (was, is): ([Box<dyn Shape>; 1], [&dyn Shape; 1]) = ([before.boxed()], [after]);
    let mut marks: Vec<Mark> = asked.iter().filter_map(|c| Mark::of(c, &names, &was, &is)).collect();
    let (a, b) = before.domain();
    if !before.is_periodic() {
        let ends = [a, b]
            .map(|u| Mark::on(object, (MarkKind::Kept, "end".into()), Location::Curve(u), before, after));
        let size = before.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let kept = |mark: &Mark| (mark.position - mark.before).norm() <= 1e-9 * size;
        marks.extend(ends.into_iter().flatten().filter(kept));
    }
    let report = StepReport {
        op: "fine-tune".into(),
        object: Some(object.into()),
        prepare_seconds: Some(seconds),
        notes,
        marks,
        ..StepReport::default()
    };
    let Some(solved) = &tuned.solved else { return report };
    let notes = report.notes.iter().chain(&solved.notes).cloned().collect();
    StepReport {
        notes,
        solver: Some(solved.solver.clone()),
        equations: Some(solved.equations),
        rank: Some(solved.rank),
        // Ends and continuity are kept without being asked for.
        redundant: solved.redundant.iter().filter(|name| !is_own(name)).cloned().collect(),
        residual: Some(solved.residual),
        condition: Some(solved.condition),
        iterations: Some(solved.iterations),
        convergence: solved.convergence,
        active: solved.active.clone(),
        constraints: solved.constraints.clone(),
        ..report
    }
}

/// Whether an equation is one that keeps ends where they are, as nobody asked.
fn is_own(name: &str) -> bool {
    name.starts_with("the end at ") || name.starts_with("closing") || name.contains(" (continuity)")
}

/// What a step tunes where it does not say: the only curve or surface, or where there is none the only mesh or polyline.
fn tuned_object(scene: &Scene, parameters: &Parameters) -> Result<String, ParameterError> {
    let spline = editable(scene);
    if scene.objects().iter().any(|object| spline(object.geometry())) {
        return object_name(scene, parameters, spline, "curve or surface");
    }
    let fits = |g: &Geometry| matches!(g, Geometry::Mesh(_) | Geometry::Polyline(_));
    object_name(scene, parameters, fits, "curve, surface, mesh or polyline")
}

/// Refuses what is said of a solution where nothing is solved.
fn check_solved(parameters: &Parameters, ends: Ends) -> Result<(), ParameterError> {
    match ["solver", "force"].into_iter().find(|name| parameters.has(name)) {
        Some(name) if ends != Ends::Exact => {
            Err(parameters.error(name, "nothing is solved with these ends: it is for ends = \"exact\""))
        }
        _ => Ok(()),
    }
}

/// A number to five digits.
fn short(x: f64) -> Figure {
    Figure(format!("{x:.4e}").parse().unwrap_or(x))
}

/// Tables with `at` and `to` and nothing else.
fn places(parameters: &Parameters, name: &str) -> Result<Vec<Parameters>, ParameterError> {
    const KNOWN: [Field; 2] =
        [Field::required("at", "a place", ""), Field::required("to", "what is there", "")];
    let tables = parameters.tables(name)?;
    tables.iter().try_for_each(|table| table.check(&KNOWN))?;
    Ok(tables)
}

/// What α is to be somewhere.
fn alpha_there(parameters: &Parameters, place: &Parameters) -> Result<f64, ParameterError> {
    let value = place.number("to")?;
    if value > 0.0 || parameters.flag("any_sign")? {
        return Ok(value);
    }
    Err(place.error(
        "to",
        format!("{value} is not positive, as α has to be (any_sign = true takes it as it comes)"),
    ))
}

fn range(parameters: &Parameters) -> Result<Option<(f64, f64)>, ParameterError> {
    if !parameters.has("range") {
        return Ok(None);
    }
    match parameters.numbers("range")?[..] {
        [from, to] => Ok(Some((from, to))),
        _ => Err(parameters.error("range", "two parameters [from, to] are needed")),
    }
}

/// A place as the α of a range knows it that goes over the seam of a closed curve.
fn over_the_seam(at: f64, curve: &Curve, range: Option<(f64, f64)>) -> f64 {
    let again = at + curve.space().length();
    let is_beyond = |(a, b): (f64, f64)| curve.is_periodic() && at < a && again <= b;
    if range.is_some_and(is_beyond) { again } else { at }
}

const ENDS: [(&str, Ends); 5] = [
    ("exact", Ends::Exact),
    ("free", Ends::Free),
    ("position", Ends::Position),
    ("tangent", Ends::Tangent),
    ("curvature", Ends::Curvature),
];

fn ends(parameters: &Parameters) -> Result<Ends, ParameterError> {
    if parameters.has("ends") { parameters.choice("ends", &ENDS) } else { Ok(Ends::default()) }
}

/// The same of a surface: of both directions, or one for each.
fn ends_of_both(parameters: &Parameters) -> Result<[Ends; 2], ParameterError> {
    let Some(list) = parameters.value("ends").and_then(|ends| ends.as_array()) else {
        return Ok([ends(parameters)?; 2]);
    };
    let [u, v] = &list[..] else {
        let problem =
            format!("{} values: give one for both directions, or two, [along u, along v]", list.len());
        return Err(parameters.error("ends", problem));
    };
    let each = |name: &str, value: &_| {
        Parameters::empty(parameters.path()).with(name, Clone::clone(value)).choice(name, &ENDS)
    };
    Ok([each("ends[0]", u)?, each("ends[1]", v)?])
}

fn continuity(parameters: &Parameters) -> Result<u8, ParameterError> {
    match parameters.count("continuity")? {
        level @ 0..=2 => Ok(level as u8),
        level => Err(parameters.error("continuity", format!("{level} is not 0, 1 or 2"))),
    }
}

/// α as it is given: one number, values on the derivative's own knots, or a spline function over the curve's domain or the range.
fn alpha(
    parameters: &Parameters,
    name: &str,
    curve: &Curve,
    range: Option<(f64, f64)>,
    ends: Ends,
) -> Result<Function<f64>, OperationError> {
    let wrong = |problem: String| parameters.error(name, problem);
    match parameters.value(name) {
        Some(value) if value.is_array() => {
            alpha_of(curve, parameters.numbers(name)?).map_err(|error| wrong(error.to_string()).into())
        }
        Some(value) if value.is_object() => {
            let table = parameters.table(name)?;
            let given = function(&table)?;
            let (own, whole) = (given.space().domain(), curve.domain());
            if own != whole && Some(own) != range {
                let range = range.map_or(String::new(), |(a, b)| format!(" or over the range [{a}, {b}]"));
                return Err(wrong(format!(
                    "alpha is over [{}, {}], and needs to be over the curve's domain [{}, {}]{range}",
                    own.0, own.1, whole.0, whole.1
                ))
                .into());
            }
            Ok(given)
        }
        _ => {
            // A loop closes whatever its number is: where nothing else is asked it need not change.
            let asks =
                ["range", "through", "alpha_at", "constraints"].iter().any(|name| parameters.has(name));
            let changes = ends == Ends::Exact && (asks || !curve.is_periodic());
            Ok(Function::constant(number_space(curve, changes)?, parameters.number(name)?)?)
        }
    }
}

/// The space of α that is given as a number: where it has to change, that of the derivative, in a lower degree if the tuned curve's
/// would be too high; else the constants.
fn number_space(curve: &Curve, changes: bool) -> Result<Space, OperationError> {
    let space = alpha_space(curve)?;
    if !changes {
        return Ok(Space::open(0, <[f64; 2]>::from(space.domain()).to_vec())?);
    }
    let most = MAX_DEGREE - 1 - space.degree().min(MAX_DEGREE - 1);
    if space.degree() <= most {
        return Ok(space);
    }
    Ok(if space.is_periodic() {
        Space::periodic(most, space.breakpoints())?
    } else {
        Space::clamped(most, &space.breakpoints())?
    })
}

/// A spline function by its degree, knots and values: open, or periodic where there is one knot more than values.
fn function(table: &Parameters) -> Result<Function<f64>, OperationError> {
    const KNOWN: [Field; 3] = [
        Field::required("degree", "number", ""),
        Field::required("knots", "[knot, …]", ""),
        Field::required("values", "[value, …]", ""),
    ];
    table.check(&KNOWN)?;
    let (degree, knots, values) = (table.count("degree")?, table.numbers("knots")?, table.numbers("values")?);
    let space = space(degree, knots, values.len()).map_err(|problem| table.error("knots", problem))?;
    Function::new(space, values).map_err(|error| table.error("values", error.to_string()).into())
}

/// The space of so many values: open, or periodic where there is one knot more than values.
fn space(degree: usize, knots: Vec<f64>, values: usize) -> Result<Space, String> {
    let found = knots.len();
    let space = if found == values + degree + 1 {
        Space::open(degree, knots)
    } else if found == values + 1 {
        Space::periodic(degree, knots)
    } else {
        return Err(format!(
            "{found} knots and {values} values of degree {degree}: an open function has {} knots, a periodic one {}",
            values + degree + 1,
            values + 1
        ));
    };
    space.map_err(|error| error.to_string())
}
