//! Running a recipe: read, apply every step, write everything or nothing.

use std::borrow::Cow;
use std::path::PathBuf;

use loftsman_kernel::plugin::{
    Chord, Clock, Context, FormatDeclaration, Mark, NoClock, Observer, Parameters, Quiet, Registry, Source,
    StepReport, WriteOptions, hint,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use serde_json::Value;

use super::Recipe;
use super::aftermath::Beforehand;
use super::changes::{self, Known};
use super::closest;
use super::elsewhere;
use super::failed::{advised, step_error};
use super::inputs::Inputs;
use super::merge;
use super::report::{InputReport, OutputReport, RunReport};
use super::within::{Lifted, UNIQUE};
use crate::error::Result;
use crate::file::output::format_for;
use crate::file::{Input, Outputs, Produced, Sequence};
use crate::picture;

/// Runs recipes: with which registry, watched by whom, with which clock and solver.
#[derive(Clone)]
pub struct Runner<'a> {
    registry: &'a Registry,
    observer: &'a dyn Observer,
    clock: &'a dyn Clock,
    solver: Option<String>,
    outputs: Option<Vec<PathBuf>>,
}

/// What the steps of a recipe made.
#[derive(Debug, Clone)]
pub struct Applied {
    /// The scene after all steps.
    pub scene: Scene,
    /// Each object as it was before the steps that edit it: for a fitted curve, as the fit left it.
    pub before: Scene,
    /// The input, where there was one; the first of several.
    pub input: Option<InputReport>,
    /// The inputs after the first.
    pub more_inputs: Vec<InputReport>,
    /// Each step.
    pub steps: Vec<StepReport>,
    /// What a picture of the scene should mark: the marks of all steps, where their places are after the last.
    pub marks: Vec<Mark>,
    /// How many marks have no place any more.
    pub lost_marks: usize,
    /// The points that objects were fitted to, which the scene no longer has; a picture may show them.
    pub fitted: Vec<Object>,
    /// The format of the input, and the file, for its pictures.
    format: Option<FormatDeclaration>,
    source: Option<Input>,
}

impl Applied {
    /// The scene as a picture shows it: with the points that objects of it were fitted to, where these are wanted.
    fn drawn(&self, points: bool) -> Result<Cow<'_, Scene>> {
        with(&self.scene, if points { &self.fitted } else { &[] })
    }

    /// No steps yet.
    fn new(inputs: Inputs) -> Self {
        let Inputs { scene, first, more, format, source } = inputs;
        Self {
            before: scene.clone(),
            scene,
            input: first,
            more_inputs: more,
            steps: Vec::new(),
            marks: Vec::new(),
            lost_marks: 0,
            fitted: Vec::new(),
            format,
            source,
        }
    }
}

/// A scene with the points that objects of it were fitted to, which it no longer has.
fn with<'s>(scene: &'s Scene, fitted: &[Object]) -> Result<Cow<'s, Scene>> {
    let mut drawn = Cow::Borrowed(scene);
    for object in fitted {
        let drawn = drawn.to_mut();
        let mut object = object.renamed(drawn.unique_name(object.name()));
        object.parent = object.parent.filter(|parent| drawn.get(parent).is_some());
        drawn.add(object)?;
    }
    Ok(drawn)
}

/// A scene as a picture shows it, with the points of the one before that objects of it were fitted to.
pub(crate) fn with_points<'s>(before: &Scene, scene: &'s Scene) -> Result<Cow<'s, Scene>> {
    with(scene, &changes::Before::of(before).fitted(scene))
}

/// The usual chord, or a tenth of the smallest distance that a step keeps a shape `within`, where that is less: how far the
/// shape went could not be seen otherwise. Not below a tenth of the usual: all that is written is cut as finely, named in the step or not, into about as
/// many more triangles as the chord is shorter.
fn no_coarser(usual: Chord, recipe: &Recipe, scene: &Scene) -> Chord {
    let Chord::Relative(share) = usual else { return usual };
    let bounds = recipe.steps.iter().filter_map(|step| step.get("within")?.as_f64());
    let bound = bounds.filter(|bound| *bound > 0.0).fold(f64::INFINITY, f64::min) / 10.0;
    let size = scene.bounds().map_or(0.0, |(low, high)| (high - low).norm());
    if bound < share * size { Chord::Absolute(bound.max(FINER * share * size)) } else { usual }
}

/// The least chord that a step's `within` brings about, of the usual one.
const FINER: f64 = 0.1;

impl<'a> Runner<'a> {
    /// A runner that nobody watches and where time stands still.
    pub fn new(registry: &'a Registry) -> Self {
        Self { registry, observer: &Quiet, clock: &NoClock, solver: None, outputs: None }
    }

    /// The same, watched.
    #[must_use]
    pub fn watched(self, observer: &'a dyn Observer, clock: &'a dyn Clock) -> Self {
        Self { observer, clock, ..self }
    }

    /// The same, with this solver in every step that takes one.
    #[must_use]
    pub fn with_solver(self, name: impl Into<String>) -> Self {
        Self { solver: Some(name.into()), ..self }
    }

    /// The same, writing these files instead of the recipe's own outputs.
    #[must_use]
    pub fn with_outputs(self, files: Vec<PathBuf>) -> Self {
        Self { outputs: Some(files), ..self }
    }

    /// Reads the input, applies every step and writes every output, all of them or none.
    ///
    /// # Errors
    /// When the input cannot be read, a step fails or an output cannot be written; nothing is written then.
    pub fn run(&self, recipe: &Recipe) -> Result<RunReport> {
        let files = self
            .outputs
            .clone()
            .unwrap_or_else(|| recipe.outputs.iter().map(|o| recipe.resolve(o)).collect());
        let mut outputs = Outputs::new().create_folders(recipe.create_folders);
        outputs.protect(&recipe.name);
        for input in &recipe.inputs {
            outputs.protect(recipe.resolve(input));
        }
        for (number, step) in recipe.steps.iter().enumerate() {
            let op = step.get("op").and_then(Value::as_str).unwrap_or_default();
            let declared = self.operation(recipe, op, number)?.declaration().fields;
            for file in merge::files(step, declared) {
                outputs.protect(recipe.resolve(file));
            }
        }
        if self.outputs.is_none() && !files.is_empty() {
            self.unused(recipe, &files)?;
        }
        // Whatever can be refused is refused before the work.
        for file in &files {
            if picture::is_picture(file) {
                picture::check(file)?;
            } else {
                format_for(file, self.registry)?;
            }
            match Sequence::of(file)? {
                Some(sequence) => outputs.claim(sequence.file(0))?,
                None => outputs.claim(file)?,
            }
        }
        let applied = self.apply(recipe)?;
        let drawn = applied.drawn(recipe.look.points)?;
        if files.iter().any(|file| picture::is_picture(file))
            && let Some((place, problem)) = recipe.look.absent(&drawn)
        {
            return Err(recipe.error(place, problem));
        }
        let mut reports = Vec::with_capacity(files.len());
        let mut counts = Vec::with_capacity(files.len());
        for file in &files {
            self.observer.proceed("outputs", reports.len() as u64, files.len() as u64)?;
            let sequence = Sequence::of(file)?;
            let mut count = 1;
            let mut report = OutputReport { path: file.display().to_string(), ..OutputReport::default() };
            if picture::is_picture(file) {
                report.notes = recipe.look.unmet(&applied.scene);
                if let (1.., true) = (applied.lost_marks, recipe.look.marks) {
                    let (count, plural) =
                        (applied.lost_marks, if applied.lost_marks == 1 { "" } else { "s" });
                    report
                        .notes
                        .push(format!("{count} mark{plural} left out: later steps took the place away"));
                }
                let (before, marks) = (Some(&applied.before), &applied.marks);
                let none = std::collections::BTreeMap::new;
                if let Some(sequence) = &sequence {
                    let look = &recipe.look;
                    let notes = sequence.each(&drawn, self.observer, |file, moment| {
                        let look = look.clone().at(moment);
                        let (bytes, undrawn) =
                            picture::draw(file, &look, &drawn, None, marks, self.registry)?;
                        outputs.add(file, bytes, none())?;
                        Ok(undrawn)
                    })?;
                    count = notes.len();
                    report.notes.extend(notes.into_iter().next().unwrap_or_default());
                } else {
                    let (bytes, undrawn) =
                        picture::draw(file, &recipe.look, &drawn, before, marks, self.registry)?;
                    report.notes.extend(undrawn);
                    outputs.add(file, bytes, none())?;
                }
            } else {
                let output = format_for(file, self.registry)?;
                let mut asked = recipe.conversion.write_options(applied.format.as_ref(), output.as_ref());
                if recipe.conversion.chord.is_none() {
                    asked.fineness.chord = no_coarser(asked.fineness.chord, recipe, &applied.scene);
                }
                let pictures = applied.source.as_ref().map(|source| source as &dyn Source);
                let options = WriteOptions { observer: self.observer, pictures, ..asked };
                let mut written;
                if let Some(sequence) = &sequence {
                    (written, count) = outputs.frames(&applied.scene, sequence, &options, self.registry)?;
                } else {
                    written = outputs.scene(&applied.scene, file, &options, self.registry)?;
                }
                report.objects = std::mem::take(&mut written.objects);
                report.notes = written.told();
            }
            report.notes.extend(sequence.iter().flat_map(|sequence| sequence.notes(count)));
            reports.push(report);
            counts.push((sequence, count));
        }
        let idle = recipe.conversion.idle_fineness(reports.iter().flat_map(|report| &report.objects));
        if let Some(last) = reports.last_mut() {
            last.notes.extend(idle);
        }
        let mut produced = outputs.commit_watched(self.observer)?.into_iter();
        for (report, (sequence, count)) in reports.iter_mut().zip(counts) {
            let mut files: Vec<Produced> = produced.by_ref().take(count).collect();
            report.notes.extend(files.iter().filter_map(Produced::note));
            if let Some(sequence) = sequence {
                report.bytes = sequence.produced(&files).bytes;
                report.frames = files;
            } else if let Some(file) = files.pop() {
                (report.bytes, report.siblings) = (file.bytes, file.siblings);
            }
        }
        let Applied { scene, input, more_inputs, steps, .. } = applied;
        Ok(RunReport { unit: scene.unit, input, more_inputs, steps, outputs: reports })
    }

    /// Refuses what is asked of outputs that the recipe does not have.
    fn unused(&self, recipe: &Recipe, files: &[PathBuf]) -> Result<()> {
        if recipe.look != picture::Look::default() && !files.iter().any(|file| picture::is_picture(file)) {
            let problem = "no output is a picture (.svg or .png): add one, or leave this out";
            return Err(recipe.error("picture", problem));
        }
        let formats: Vec<&str> = files
            .iter()
            .filter(|file| !picture::is_picture(file))
            .map(|file| Ok(format_for(file, self.registry)?.declaration().name))
            .collect::<Result<_>>()?;
        match recipe.conversion.write.keys().find(|name| !formats.contains(&name.as_str())) {
            Some(name) if self.registry.formats().iter().any(|f| f.declaration().name == name) => {
                let problem = format!("no output is in the format {name}: add one, or leave this out");
                Err(recipe.error(format!("write.{name}"), problem))
            }
            _ => Ok(()),
        }
    }

    /// Reads the input and applies every step; writes nothing.
    ///
    /// # Errors
    /// When the input cannot be read or a step fails.
    pub fn apply(&self, recipe: &Recipe) -> Result<Applied> {
        let steps = self.prepare(recipe)?;
        let mut applied = Applied::new(Inputs::read(recipe, self.observer, self.registry)?);
        let context = Context { registry: self.registry, observer: self.observer, clock: self.clock };
        let mut known = Known::default();
        for (number, Step { op, parameters, unique }) in steps.iter().enumerate() {
            self.observer.proceed(op, number as u64, steps.len() as u64)?;
            let operation = self.operation(recipe, op, number)?;
            let locate = |e: loftsman_kernel::plugin::ParameterError| {
                step_error(recipe, number, op, parameters, e.into())
            };
            let mut notes = Vec::new();
            let lifted = Lifted::lift(&mut applied.scene, parameters, *unique).map_err(locate)?;
            let before = Beforehand::of(&applied.scene);
            let geometry = changes::Before::of(&applied.scene);
            let declared = operation.declaration().fields;
            let pointed = closest::resolve(&applied.scene, parameters, operation.as_ref(), &mut notes)
                .map_err(locate)?;
            let place = |file: &str| recipe.resolve(file).display().to_string();
            let pointed = merge::relative(pointed, declared, place).map_err(locate)?;
            let report = operation
                .apply(&mut applied.scene, &pointed, &context)
                .map_err(|e| step_error(recipe, number, op, parameters, e));
            let mut report = report.map_err(|error| advised(error, &applied.scene, parameters))?;
            if report.op.is_empty() {
                report.op.clone_from(op);
            }
            before.drop_stale(&mut applied.scene, &mut report)?;
            for (old, new) in geometry.renamed(&applied.scene) {
                let old = changes::points_of(&old);
                for points in applied.fitted.iter_mut().filter(|points| points.name() == old) {
                    *points = points.renamed(changes::points_of(&new));
                }
            }
            applied.fitted.extend(geometry.fitted(&applied.scene));
            geometry.tell(&applied.scene, &mut known, &mut report);
            if applied.scene.unit == Unit::Unknown && (report.area.is_some() || report.volume.is_some()) {
                let what = "areas and volumes are of the file's numbers; give the recipe a `unit`";
                report.notes.push(format!("the unit is unknown: {what}"));
            }
            applied.lost_marks += before.follow(&applied.scene, &mut applied.marks, &report.marks);
            applied.marks.extend(report.marks.iter().cloned());
            lifted.put_back(&mut applied.scene, parameters, &mut report).map_err(locate)?;
            report.notes.append(&mut notes);
            applied.steps.push(report);
            remember(&mut applied.before, &applied.scene)?;
        }
        Ok(applied)
    }

    /// The operation and the fields of each step, checked as far as their declarations allow.
    fn prepare(&self, recipe: &Recipe) -> Result<Vec<Step>> {
        let locate = |e: loftsman_kernel::plugin::ParameterError| recipe.error(e.path, e.problem);
        for format in recipe.conversion.write.keys() {
            let known: Vec<&str> = self.registry.formats().iter().map(|f| f.declaration().name).collect();
            if !known.contains(&format.as_str()) {
                let hint = hint(format, known.iter().copied(), || format!("known are {}", known.join(", ")));
                return Err(recipe.error("write", format!("unknown format \"{format}\"; {hint}")));
            }
        }
        let mut steps = Vec::with_capacity(recipe.steps.len());
        for (number, step) in recipe.steps.iter().enumerate() {
            let path = format!("step[{number}]");
            let all = Parameters::new(step.clone(), &path).map_err(locate)?;
            let op = all.text("op").map_err(locate)?.to_owned();
            let fields = self.operation(recipe, &op, number)?.declaration().fields;
            let unique = all.flag(UNIQUE).map_err(locate)?;
            let mut parameters = all.without(&["op", UNIQUE]);
            if let Some(solver) = self.solver.as_ref().filter(|_| fields.iter().any(|f| f.name == "solver")) {
                let mut table = step.clone();
                if let Value::Object(map) = &mut table {
                    map.shift_remove("op");
                    map.shift_remove(UNIQUE);
                    map.insert("solver".to_owned(), Value::String(solver.clone()));
                }
                parameters = Parameters::new(table, &path).map_err(locate)?;
            }
            parameters.check(fields).map_err(locate)?;
            steps.push(Step { op, parameters, unique });
        }
        Ok(steps)
    }

    fn operation(
        &self,
        recipe: &Recipe,
        op: &str,
        number: usize,
    ) -> Result<&'a std::sync::Arc<dyn loftsman_kernel::plugin::Operation>> {
        self.registry.find_operation(op, &format!("step[{number}].op")).map_err(|e| {
            let ours = elsewhere::called(op, self.registry);
            let problem = ours.map(|ours| format!("unknown operation \"{op}\"; did you mean \"{ours}\"?"));
            let problem =
                problem.or_else(|| elsewhere::absent(op).map(|why| format!("no operation \"{op}\": {why}")));
            recipe.error(e.path, problem.unwrap_or(e.problem))
        })
    }
}

/// A step: its operation, the fields of that, and whether what it edits of a definition is made unique before.
struct Step {
    op: String,
    parameters: Parameters,
    unique: bool,
}

/// Keeps the first state of each object in which it was of its present kind.
fn remember(before: &mut Scene, scene: &Scene) -> Result<()> {
    // What an instance shows is not among the objects.
    for object in scene.objects().iter().filter(|o| !matches!(o.geometry(), Geometry::Instance(_))) {
        match before.get(object.name()) {
            Some(old) if old.geometry().kind() == object.geometry().kind() => {}
            Some(_) => before.replace_shared(object.name(), object.shared_geometry().clone())?,
            None => {
                // Where it is now: it has been nowhere else.
                let mut first = Object::sharing(object.name(), object.shared_geometry().clone());
                let is_kept = |name: &&String| {
                    scene.get(name).is_some_and(|o| !matches!(o.geometry(), Geometry::Instance(_)))
                };
                first.parent = object.parent.as_ref().filter(is_kept).cloned();
                first.transform = object.transform;
                before.add(first)?;
            }
        }
    }
    before.retain(|o| scene.get(o.name()).is_some() || matches!(o.geometry(), Geometry::Group));
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use loftsman_kernel::mesh::Polyline;
    use loftsman_kernel::{Point, Vector};
    use serde_json::json;

    use super::*;

    /// What a step has made or merged was nowhere else before: its first state is where it hangs.
    #[test]
    fn what_is_new_is_remembered_where_it_is() {
        let line = Polyline { points: vec![Point::origin(), Point::new(2.0, 0.0, 0.0)], closed: false };
        let mut scene = Scene::new();
        let mut group = Object::new("group", Geometry::Group);
        group.transform = Some(loftsman_kernel::nalgebra::Matrix4::new_scaling(3.0));
        let mut new = Object::new("line", line.into());
        (new.parent, new.transform) =
            (Some("group".into()), Some(loftsman_kernel::nalgebra::Matrix4::new_translation(&Vector::x())));
        // In either order.
        scene.add(new).unwrap();
        scene.add(group).unwrap();
        let mut before = Scene::new();
        remember(&mut before, &scene).unwrap();
        let [then, now] = [&before, &scene].map(|scene| scene.flattened(10).unwrap().into_owned());
        assert_eq!(then.get("line").unwrap().transform, now.get("line").unwrap().transform);
        assert_eq!(before.get("line").unwrap().parent.as_deref(), Some("group"));
    }

    /// A step that keeps within a distance has its output cut to a tenth of it, where that is finer than usual, and by ten times at most: what no step names is cut as finely.
    #[test]
    fn outputs_are_no_coarser_than_what_steps_keep_within() {
        let mut scene = Scene::new();
        let line = Polyline { points: vec![Point::origin(), Point::new(2.0, 0.0, 0.0)], closed: false };
        scene.add(Object::new("line", line.into())).unwrap();
        let usual = Chord::Relative(1e-4);
        let of = |within: &[Value], usual: Chord| {
            let steps: Vec<Value> = within.iter().map(|w| json!({ "op": "fair", "within": w })).collect();
            let text = json!({ "input": "a.obj", "step": steps }).to_string();
            let recipe = Recipe::parse("r.json", text.as_bytes(), Path::new("")).unwrap();
            no_coarser(usual, &recipe, &scene)
        };
        assert_eq!(of(&[], usual), usual);
        assert_eq!(of(&[json!(0.1)], usual), usual);
        assert_eq!(of(&[json!(0.1), json!(1e-3)], usual), Chord::Absolute(1e-3 / 10.0));
        assert_eq!(of(&[json!(1e-12)], usual), Chord::Absolute(0.1 * 1e-4 * 2.0));
        // An interval of parameters is no distance; nor is nothing, or less.
        assert_eq!(of(&[json!([0.0, 1e-6]), json!(0), json!(-1.0)], usual), usual);
        assert_eq!(of(&[json!(1e-4)], Chord::Absolute(0.5)), Chord::Absolute(0.5));
    }
}
