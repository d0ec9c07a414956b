//! `fit POINTS OUT`: the operation `fit` from options instead of a recipe.

use std::collections::BTreeMap;
use std::process::ExitCode;

use crate::convert::Conversion;
use crate::file::{Content, Input, Outputs};
use crate::picture::{self, Look};
use crate::recipe::{InputReport, OutputReport, RunReport, with_points};
use loftsman_kernel::plugin::{
    Context, OperationError, Parameters, Registry, Source, StepReport, WriteOptions,
};
use loftsman_kernel::scene::{Geometry, Scene};
use serde_json::{Map, Value};

use super::report;
use crate::program::Usage;
use crate::program::args::FitArgs;
use crate::program::console;
use crate::program::progress::Progress;

pub(crate) fn run(args: &FitArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    super::convert::check_output(&args.out, registry)?;
    picture::check(&args.out)?;
    let mut outputs = Outputs::new();
    outputs.protect(&args.points);
    outputs.claim(&args.out)?;
    let input = Input::open(&args.points)?;
    let progress = Progress::start();
    let Content { mut scene, report: read, format } =
        Conversion::default().read(&input, &progress, registry)?;
    let object = object(&scene, args, Source::name(&input))?;
    let before = scene.clone();
    let step = fit(&mut scene, &object, args, &progress, registry)?;
    let mut written = OutputReport { path: args.out.display().to_string(), ..OutputReport::default() };
    if picture::is_picture(&args.out) {
        let (bytes, undrawn) = picture::draw(
            &args.out,
            &Look::default(),
            with_points(&before, &scene)?.as_ref(),
            None,
            &step.marks,
            registry,
        )?;
        written.notes = undrawn;
        outputs.add(&args.out, bytes, BTreeMap::new())?;
    } else {
        let options = WriteOptions { observer: &progress, ..WriteOptions::default() };
        let mut report = outputs.scene(&scene, &args.out, &options, registry)?;
        written.objects = std::mem::take(&mut report.objects);
        written.notes = report.told();
    }
    for produced in outputs.commit_watched(&progress)? {
        written.notes.extend(produced.note());
        (written.bytes, written.siblings) = (produced.bytes, produced.siblings);
    }
    drop(progress);
    let path = Source::name(&input).to_owned();
    let input = InputReport { path, format: format.name, report: read, notes: Vec::new() };
    let whole = RunReport {
        unit: scene.unit,
        input: Some(input),
        more_inputs: Vec::new(),
        steps: vec![step],
        outputs: vec![written],
    };
    if args.json.wanted {
        if let Some(input) = &whole.input {
            report::warn(&input.path, &input.report);
        }
        console::print_json(&whole)?;
    } else {
        console::print(&report::run(&whole, false))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The object to fit: the one that was named, or the only one that is points.
fn object(scene: &Scene, args: &FitArgs, file: &str) -> anyhow::Result<String> {
    if let Some(name) = &args.object {
        scene.object(name).map_err(|e| anyhow::anyhow!("{file}: {e}"))?;
        return Ok(name.clone());
    }
    let fits = |g: &Geometry| matches!(g, Geometry::Polyline(_) | Geometry::Cloud(_));
    let names: Vec<&str> = scene.objects().iter().filter(|o| fits(o.geometry())).map(|o| o.name()).collect();
    match names.as_slice() {
        [only] => Ok((*only).to_owned()),
        [] => {
            anyhow::bail!("{file}: there are no points in it, only shapes; fit takes a cloud or a polyline")
        }
        several => {
            let some: Vec<String> = several.iter().take(8).map(|n| format!("\"{n}\"")).collect();
            let more = if several.len() > 8 { ", …" } else { "" };
            let known = some.join(", ");
            anyhow::bail!(
                "{file}: it holds {} sets of points; name one with --object: {known}{more}",
                several.len()
            )
        }
    }
}

fn fit(
    scene: &mut Scene,
    object: &str,
    args: &FitArgs,
    progress: &Progress,
    registry: &Registry,
) -> anyhow::Result<StepReport> {
    let fields = fields(object, args);
    let parameters = Parameters::new(Value::Object(fields), "")?;
    let context = Context { registry, observer: progress, clock: progress };
    let operation = registry.find_operation("fit", "fit")?;
    operation.apply(scene, &parameters, &context).map_err(|error| match error {
        // The fields are the options: an error in one is an error of the command line.
        OperationError::Parameter(e) => {
            Usage(format!("--{}: {}", e.path.replace('_', "-"), e.problem)).into()
        }
        OperationError::Cancelled => crate::Error::Cancelled.into(),
        other => anyhow::anyhow!("{}, object \"{object}\": {other}", args.points.display()),
    })
}

/// The fields of the operation: each has the option of its name, hyphens for underscores.
fn fields(object: &str, args: &FitArgs) -> Map<String, Value> {
    let numbers = |all: &[f64]| (!all.is_empty()).then(|| all.to_vec().into());
    let tables = |all: &[Value]| (!all.is_empty()).then(|| all.to_vec().into());
    let all: [(&str, Option<Value>); 17] = [
        ("object", Some(object.into())),
        ("degree", Some(args.degree.into())),
        ("tolerance", args.tolerance.map(Into::into)),
        ("relative_tolerance", args.relative_tolerance.map(Into::into)),
        ("vertices", args.vertices.map(Into::into)),
        ("interpolate", args.interpolate.map(Into::into)),
        ("closed", args.closed.map(Into::into)),
        ("corners", args.corners.clone()),
        ("parameters", args.parameters.clone()),
        ("corrections", args.corrections.map(Into::into)),
        ("ends", args.ends.clone().map(Into::into)),
        ("merge", args.merge.map(Into::into)),
        ("weights", numbers(&args.weights)),
        ("constraints", tables(&args.constraints)),
        ("regularization", args.regularization.map(Into::into)),
        ("smooth", args.smooth.map(Into::into)),
        ("best_effort", args.best_effort.map(Into::into)),
    ];
    all.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}
