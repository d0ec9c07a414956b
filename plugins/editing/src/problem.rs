//! What `edit` and `drag` share: the problem of a recipe step.

use std::collections::BTreeSet;
use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::brep::Moving;
use loftsman_kernel::edit::{Constraint, Edit, Metric, Report, Wanted, pick};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Functional, Shapes, value_of};
use loftsman_kernel::plugin::{
    AskedQuantity, ConstraintReport, Context, Field, Frames, Mark, MarkKind, Measured, OperationError,
    ParameterError, Parameters, SceneShapes, SeenShapes, Spot, StepReport, ask_once, constraint_from,
    editable, functional_from, nearest, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::shape::{Location, Shape, vertex_index};
use loftsman_kernel::solve::Solver;

pub(crate) const OBJECT: Field =
    Field::optional("object", "text", "the only curve or surface", "the object to edit");
pub(crate) const SHARED: [Field; 13] = [
    OBJECT,
    Field::optional(
        "constraints",
        "[{ kind, …, to | by | scale | keep | at_least | at_most }, …]",
        "none",
        "what is asked",
    ),
    Field::optional("solver", "name", "automatic", "the solver; `loftsman plugins` lists them"),
    Field::optional(
        "metric",
        "\"least\" | \"bend\" | \"stretch\" | { falloff = vertices } | { weights = […] }",
        "least",
        "what the least adjustment is least in",
    ),
    Field::optional("lock", "[index, …]", "none", "control vertices that may not move; -1 is the last"),
    Field::optional("locality", "count", "all", "only so many control vertices may move"),
    Field::optional(
        "within",
        "[from, to], each a number or { closest = [x, y, z] }",
        "everywhere",
        "keep the edit in an interval of the parameter, inserting knots; curves only",
    ),
    Field::optional(
        "best_effort",
        "true | false",
        "false",
        "accept least squares where constraints conflict",
    ),
    Field::optional(
        "force",
        "true | false",
        "false",
        "take an adjustment that is out of all proportion to what is asked (never a residual)",
    ),
    Field::optional(
        "axes",
        "\"together\" | \"alternating\"",
        "together",
        "whether one axis an event makes up for area and volume, or all at once",
    ),
    Field::optional(
        "smooth",
        "0 | 1 | 2",
        "1",
        "at repeated knots, what was smooth stays so: 1 tangents, 2 curvatures too, 0 corners may appear",
    ),
    Field::optional(
        "faces",
        "[number or name, …]",
        "those that are asked about",
        "the faces of a brep that may move; all others stand still",
    ),
    Field::optional(
        "neighbours",
        "count",
        "0",
        "so many rings of faces around them may move too; edges between faces that move go along",
    ),
];

/// The shapes of a step's problem: the step's object first, others as constraints name them.
pub(crate) struct Problem {
    pub(crate) names: Vec<String>,
    pub(crate) shapes: Vec<Box<dyn Shape>>,
    /// The frame that they are in.
    pub(crate) frames: Frames,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) handle: Option<Arc<dyn Functional>>,
    pub(crate) metric: Metric,
    pub(crate) lock: Vec<i64>,
    pub(crate) locality: Option<usize>,
    pub(crate) within: Option<(f64, f64)>,
    pub(crate) best_effort: bool,
    pub(crate) alternating: bool,
    pub(crate) forced: bool,
    pub(crate) smooth: u8,
    pub(crate) solver: Arc<dyn Solver>,
}

impl Problem {
    pub(crate) fn new(
        scene: &Scene,
        parameters: &Parameters,
        context: &Context<'_>,
        with_handle: bool,
    ) -> Result<Self, OperationError> {
        let object = object_name(scene, parameters, editable(scene), "curve, surface or brep")?;
        let mut names = SceneShapes::with_solids(scene, &object, moving(scene, &object, parameters)?)?;
        let tables = parameters.tables("constraints")?;
        let mut constraints = Vec::with_capacity(tables.len());
        let mut known = BTreeSet::new();
        for (k, table) in tables.iter().enumerate() {
            let constraint = constraint_from(context.registry, table, &mut names)?;
            let (label, name) = (constraint.label(), constraint.describe());
            // What is asked of one thing twice is told apart by where it is asked.
            let twice = format!("{name} (constraints[{k}])");
            constraints.push(if known.insert(label) { constraint } else { constraint.called(&twice) });
        }
        if !parameters.has("within") {
            ask_once(names.shapes(), &constraints, &tables)?;
        }
        let mut handle = None;
        if with_handle {
            let table = picked(&parameters.table("handle")?, names.shapes()[0].as_ref())?;
            handle = Some(functional_from(context.registry, &table, &mut names)?);
        }
        let solver = parameters.text_or("solver", "automatic")?;
        let solver =
            Arc::clone(context.registry.find_solver(solver, &format!("{}.solver", parameters.path()))?);
        let SeenShapes { names, shapes, frames } = names.into_parts()?;
        let problem = Self {
            names,
            shapes,
            frames,
            constraints,
            handle,
            metric: metric(parameters)?,
            lock: if parameters.has("lock") { parameters.integers("lock")? } else { Vec::new() },
            locality: if parameters.has("locality") { Some(parameters.count("locality")?) } else { None },
            within: within(parameters)?,
            best_effort: parameters.flag("best_effort")?,
            forced: parameters.flag("force")?,
            alternating: parameters.has("axes")
                && parameters.choice("axes", &[("together", false), ("alternating", true)])?,
            smooth: smooth(parameters)?,
            solver,
        };
        if problem.within.is_some() && !problem.is_curve() {
            return Err(parameters.error("within", "only curves can be edited within an interval").into());
        }
        Ok(problem)
    }

    /// Whether what is edited has one parameter.
    pub(crate) fn is_curve(&self) -> bool {
        self.shapes[0].domain().len() == 1
    }

    /// The edit.
    pub(crate) fn edit(&self) -> Edit<Box<dyn Shape>> {
        let mut edit = Edit::new(&self.shapes[0]).metric(self.metric.clone()).lock(self.lock.iter().copied());
        edit = edit.smooth(self.smooth);
        for (index, other) in self.shapes.iter().enumerate().skip(1) {
            edit = edit.with(other.boxed());
            if let Some(name) = self.names.get(index) {
                edit = edit.named(index, name.as_str());
            }
        }
        for constraint in &self.constraints {
            edit = edit.ask(constraint.clone());
        }
        if let Some(count) = self.locality {
            edit = edit.locality(count);
        }
        if let Some((start, end)) = self.within {
            edit = edit.within(start, end);
        }
        if let Some(handle) = &self.handle {
            edit = edit.shared_handle(Arc::clone(handle));
        }
        let edit = if self.alternating { edit.alternating() } else { edit };
        let edit = if self.forced { edit.force() } else { edit };
        if self.best_effort { edit.best_effort() } else { edit }
    }

    /// The value that the handle has.
    ///
    /// # Errors
    /// When it has none at its location, or is not a vector.
    pub(crate) fn handle_value(&self) -> Result<Vector, Error> {
        let mut value = [0.0; 3];
        if let Some(handle) = &self.handle {
            if handle.equations() != value.len() {
                let what = handle.describe();
                return Err(Error::Invalid(format!("\"{what}\" is not a vector: drag something that is")));
            }
            value_of(handle.as_ref(), &Shapes::new(self.shapes.iter().map(AsRef::as_ref)), &mut value)?;
        }
        Ok(Vector::from(value))
    }

    /// Shapes in their objects' own coordinates.
    pub(crate) fn own(&self, shapes: &[Box<dyn Shape>]) -> Vec<Box<dyn Shape>> {
        let each = shapes.iter().enumerate();
        each.map(|(index, shape)| self.frames.own_shape(index, shape.as_ref())).collect()
    }

    /// The lengths, areas and volumes that it changes, before and `after` (in the frame of the problem). What cannot be told, as where a location floated, is left
    /// out. Costs two evaluations of each.
    pub(crate) fn quantities(&self, after: &[Box<dyn Shape>]) -> Vec<AskedQuantity> {
        let asked = self.constraints.iter().filter_map(|constraint| {
            let functional = constraint.functional();
            let dimension = functional.dimension().filter(|power| (1..=3).contains(power))?;
            if functional.equations() != 1 || matches!(constraint.wanted(), Wanted::Keep | Wanted::Hold) {
                return None;
            }
            let of = |shapes: &[Box<dyn Shape>]| -> Option<f64> {
                // What it takes from the shape at the start it has from that. A shape of several pieces has other control vertices since it was made
                // ready to be moved: of that everything is taken as it is.
                let is_ready = shapes.iter().any(|shape| shape.bonds().is_some());
                let start = if is_ready { shapes } else { &self.shapes[..] };
                let bound = functional.bind(&Shapes::new(start.iter().map(AsRef::as_ref))).ok()?;
                let shapes = Shapes::new(shapes.iter().map(AsRef::as_ref));
                let mut value = [0.0];
                value_of(bound.as_deref().unwrap_or(functional.as_ref()), &shapes, &mut value).ok()?;
                value[0].is_finite().then_some(value[0])
            };
            let value = Measured { before: Some(of(&self.shapes)?), after: Some(of(after)?) };
            Some(AskedQuantity { name: constraint.describe(), dimension, value })
        });
        asked.collect()
    }

    /// What a picture of the edit should mark, locations that floated where they came to rest. `after` are in their objects' own
    /// coordinates.
    pub(crate) fn marks(&self, after: &[&dyn Shape], reports: &[ConstraintReport]) -> Vec<Mark> {
        let before = self.own(&self.shapes);
        let on = |(k, c): (usize, &Constraint)| {
            let rested = reports.get(k).and_then(|report| report.rested(c.functional()));
            let rested = rested.map(|f| Constraint::new(f, c.wanted().clone()));
            Mark::of(rested.as_ref().unwrap_or(c), &self.names, &before, after)
        };
        let mut marks: Vec<Mark> = self.constraints.iter().enumerate().filter_map(on).collect();
        if let Some(handle) = &self.handle
            && let name = handle.describe()
            && let rested =
                reports.iter().find(|report| report.name == name).and_then(|report| report.rested(handle))
            && let Some((shape, at)) = rested.as_ref().unwrap_or(handle).location()
            && let (Some(name), Some(before), Some(after)) =
                (self.names.get(shape), before.get(shape), after.get(shape))
        {
            let what = (MarkKind::of(handle.as_ref(), false), handle.describe());
            marks.extend(Mark::on(name, what, at, before.as_ref(), *after));
        }
        if let (Some(shape), Some(name)) = (after.first(), self.names.first()) {
            for &index in &self.lock {
                let vertices = shape.control_vertices();
                if let Ok(i) = vertex_index(index, vertices.len()) {
                    let position = vertices[i];
                    let label = format!("vertex {index} locked");
                    let (object, kind) = (name.clone(), MarkKind::Locked);
                    let (before, spot) = (position, Some(Spot::Vertex(i)));
                    marks.push(Mark {
                        object,
                        kind,
                        position,
                        before,
                        vector: None,
                        label,
                        spot,
                        track: None,
                    });
                }
            }
        }
        marks
    }
}

/// The handle's table with its location moved to the end of the curve where it is picked near enough (paper 4, §2).
fn picked(handle: &Parameters, shape: &dyn Shape) -> Result<Parameters, OperationError> {
    if !handle.has("pick") {
        return Ok(handle.clone());
    }
    let tolerance = handle.number("pick")?;
    let (1, Location::Curve(u)) = (shape.domain().len(), handle.location("at")?) else {
        return Err(handle.error("pick", "only a location on a curve can be picked").into());
    };
    let u = pick(shape, u, tolerance)?;
    let mut table = serde_json::Map::new();
    for name in handle.names().filter(|n| *n != "pick") {
        if let Some(value) = handle.value(name) {
            table.insert(name.to_owned(), value.clone());
        }
    }
    table.insert("at".into(), u.into());
    Ok(Parameters::new(table.into(), handle.path())?)
}

/// Which faces of a brep may move.
fn moving(scene: &Scene, object: &str, parameters: &Parameters) -> Result<Moving, OperationError> {
    let mut moving = Moving::new();
    let Geometry::Brep(brep) = scene.object(object)?.geometry() else {
        if let Some(field) = ["faces", "neighbours"].into_iter().find(|field| parameters.has(field)) {
            let problem = format!("\"{object}\" is no brep: only its faces can be told apart");
            return Err(parameters.error(field, problem).into());
        }
        return Ok(moving);
    };
    if parameters.has("faces") {
        let mut faces = Vec::new();
        for (k, value) in parameters.list("faces")?.iter().enumerate() {
            let fail = |problem: String| parameters.error(&format!("faces[{k}]"), problem);
            let count = brep.face_count();
            if let Some(name) = value.as_str() {
                let named = (0..count).filter(|face| brep.face_name(*face) == Some(name));
                let before = faces.len();
                faces.extend(named);
                if faces.len() == before {
                    return Err(fail(format!("no face of \"{object}\" is called \"{name}\"")).into());
                }
                continue;
            }
            let number = value.as_u64().and_then(|number| usize::try_from(number).ok());
            match number.filter(|number| *number < count) {
                Some(number) => faces.push(number),
                None => {
                    let problem = format!(
                        "{value} is no face of \"{object}\": it has {count}, numbered from 0, or give a name"
                    );
                    return Err(fail(problem).into());
                }
            }
        }
        moving = moving.faces(faces);
    }
    moving = moving.neighbours(parameters.count_or("neighbours", 0)?);
    Ok(if smooth(parameters)? == 0 { moving.sharp() } else { moving })
}

fn within(parameters: &Parameters) -> Result<Option<(f64, f64)>, ParameterError> {
    if !parameters.has("within") {
        return Ok(None);
    }
    match parameters.numbers("within")?[..] {
        [start, end] => Ok(Some((start, end))),
        _ => Err(parameters.error("within", "two parameters [from, to] are needed")),
    }
}

fn smooth(parameters: &Parameters) -> Result<u8, ParameterError> {
    match parameters.count_or("smooth", 1)? {
        level @ 0..=2 => Ok(level as u8),
        level => Err(parameters.error("smooth", format!("{level} is not 0, 1 or 2"))),
    }
}

fn metric(parameters: &Parameters) -> Result<Metric, ParameterError> {
    let Some(value) = parameters.value("metric") else { return Ok(Metric::Least) };
    if !value.is_object() {
        const WORDS: [(&str, u8); 3] = [("least", 0), ("bend", 1), ("stretch", 2)];
        return Ok(match parameters.choice("metric", &WORDS)? {
            1 => Metric::Bend,
            2 => Metric::Stretch,
            _ => Metric::Least,
        });
    }
    let table = parameters.table("metric")?;
    let names: Vec<&str> = table.names().collect();
    match names[..] {
        ["falloff"] => table.number("falloff").map(Metric::Falloff),
        ["weights"] => table.numbers("weights").map(Metric::Weights),
        [other] => {
            let hint = nearest(other, ["falloff", "weights"]).unwrap_or("falloff");
            Err(table.error("", format!("unknown metric \"{other}\"; did you mean \"{hint}\"?")))
        }
        _ => Err(table.error("", "give one of falloff or weights")),
    }
}

/// A step's report from an edit's, where lengths are in this unit.
pub(crate) fn step_report(op: &str, object: &str, report: &Report, unit: Unit) -> StepReport {
    let mut notes = report.notes.clone();
    if report.best_effort {
        // What is not linear may be met by a shape that is farther away.
        let why = match report.convergence {
            Some(_) => "no shape near by was found that meets all constraints, and these",
            None => "the constraints conflict and",
        };
        // What is left of the slope where looking on would cost too much.
        let rough = match &report.convergence {
            Some(found) if found.change > 1e-5 => {
                " (a little less may be possible: looking on would cost too much)"
            }
            _ => "",
        };
        notes.push(format!(
            "best effort: {why} are met in the least-squares sense only; missed: {}{rough}",
            report.missed_in(unit).join(", ")
        ));
    }
    StepReport {
        op: op.into(),
        object: Some(object.into()),
        solver: Some(report.solver.clone()),
        equations: Some(report.equations),
        rank: Some(report.rank),
        best_effort: report.best_effort,
        redundant: report.redundant.clone(),
        residual: Some(report.residual),
        condition: Some(report.condition),
        adjustment: Some(report.adjustment),
        iterations: Some(report.iterations),
        convergence: report.convergence,
        active: report.active.clone(),
        constraints: report.constraints.clone(),
        smooth: Some(report.smooth.clone()).filter(|smooth| !smooth.is_empty()),
        notes,
        ..StepReport::default()
    }
}
