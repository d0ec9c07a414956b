//! `convert IN… --to EXT --into DIR [--jobs N]`: one that fails does not stop the rest.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use loftsman_kernel::plugin::Registry;
use rayon::prelude::*;

use super::convert::{convert, format_of, open, warn};
use crate::convert::{Converted, Converter};
use crate::program::args::ConvertArgs;
use crate::program::console::{self, bytes, count};
use crate::program::progress::{self, Silent};
use crate::program::{Interrupted, Usage};

#[derive(serde::Serialize)]
struct Summary {
    converted: usize,
    failed: usize,
    files: Vec<Outcome>,
}

#[derive(serde::Serialize)]
#[serde(untagged)]
enum Outcome {
    Done(Box<Converted>),
    Failed { input: String, error: String },
}

/// The extension of what is written unless told otherwise.
const USUAL: &str = "glb";

pub(super) fn run(args: &ConvertArgs, folder: &Path, registry: &Registry) -> anyhow::Result<ExitCode> {
    let extension = args.to.as_deref().unwrap_or(USUAL).trim_start_matches('.');
    let format = format_of(extension, registry)?;
    let conversion = args.how.conversion(format.as_ref(), registry)?;
    if folder.exists() && !folder.is_dir() {
        anyhow::bail!("{}: this is a file; --into names a folder", folder.display());
    }
    std::fs::create_dir_all(folder)
        .map_err(|e| anyhow::anyhow!("{}: the folder cannot be made: {e}", folder.display()))?;
    let jobs = usize::from(args.jobs.unwrap_or(0));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build()?;
    let targets = targets(&args.files, folder, extension, registry);
    let bar = progress::bar(targets.len() as u64);
    let files: Vec<Outcome> = pool.install(|| {
        let work = targets.par_iter().map(|(input, output)| {
            if progress::interrupted() {
                let error = crate::Error::Cancelled.to_string();
                return Outcome::Failed { input: input.display().to_string(), error };
            }
            let converter =
                Converter { format: format.as_ref(), conversion: &conversion, observer: &Silent, registry };
            let outcome = one(input, output, &converter, args);
            bar.inc(1);
            outcome
        });
        work.collect()
    });
    bar.finish_and_clear();
    if progress::interrupted() {
        let done = files.iter().filter(|f| matches!(f, Outcome::Done(_))).count();
        let count = files.len();
        let text =
            format!("interrupted: {done} of {count} files were written, whole; the rest are as they were");
        return Err(Interrupted(text).into());
    }
    let failed = files.iter().filter(|f| matches!(f, Outcome::Failed { .. })).count();
    let summary = Summary { converted: files.len() - failed, failed, files };
    for file in &summary.files {
        match file {
            Outcome::Done(done) => warn(done),
            Outcome::Failed { error, .. } => console::error(error),
        }
    }
    if args.json.wanted {
        console::print_json(&summary)?;
    } else {
        console::print(&text(&summary))?;
    }
    Ok(ExitCode::from(u8::from(failed > 0)))
}

/// Where each input goes, or why it cannot go anywhere: two inputs must not become one file.
fn targets(
    inputs: &[PathBuf],
    folder: &Path,
    extension: &str,
    registry: &Registry,
) -> Vec<(PathBuf, Result<PathBuf, String>)> {
    let mut taken: BTreeMap<PathBuf, &PathBuf> = BTreeMap::new();
    let mut targets = Vec::with_capacity(inputs.len());
    for input in inputs {
        let target = if input.as_os_str() == "-" {
            Err("-: the standard input has no name to write under; give --into files".to_owned())
        } else {
            let output = folder.join(format!("{}.{extension}", stem(input, registry)));
            match taken.insert(output.clone(), input) {
                None => Ok(output),
                Some(first) => Err(format!(
                    "{}: {} would become the same file, {}; rename one or use another folder",
                    input.display(),
                    first.display(),
                    output.display()
                )),
            }
        };
        targets.push((input.clone(), target));
    }
    targets
}

/// The name without the extension of its format, compound ones (`loft.json`) included.
fn stem(input: &Path, registry: &Registry) -> String {
    let name = input.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let lower = name.to_lowercase();
    let known = registry.formats().iter().flat_map(|f| f.declaration().extensions);
    let longest = known.filter(|e| lower.ends_with(&format!(".{e}"))).map(|e| e.len() + 1).max();
    match longest {
        Some(length) if length < name.len() => name[..name.len() - length].to_owned(),
        _ => input.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

fn one(
    input: &Path,
    output: &Result<PathBuf, String>,
    converter: &Converter<'_>,
    args: &ConvertArgs,
) -> Outcome {
    let name = input.display().to_string();
    let result = match output {
        Ok(output) => open(input, args.from.as_deref(), converter.registry)
            .and_then(|file| convert(converter, &file, output)),
        Err(problem) => Err(Usage(problem.clone()).into()),
    };
    match result {
        Ok(converted) => Outcome::Done(Box::new(converted)),
        Err(error) => Outcome::Failed { input: name, error: error.to_string() },
    }
}

fn text(summary: &Summary) -> String {
    let mut text = String::new();
    for file in &summary.files {
        if let Outcome::Done(done) = file {
            let left_out = match done.left_out() {
                0 => String::new(),
                number => format!(", {number} left out"),
            };
            text += &format!("{} → {}, {}{left_out}\n", done.input, done.output, bytes(done.bytes));
        }
    }
    let failed = if summary.failed > 0 { format!(", {} failed", summary.failed) } else { String::new() };
    text + &format!("{} converted{failed}\n", count(summary.converted, "file"))
}
