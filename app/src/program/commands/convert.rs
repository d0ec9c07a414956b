//! `convert IN OUT`, and with `--into` many inputs at once ([`super::convert_many`]).

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use loftsman_kernel::plugin::{Fate, Format, FormatErrorKind, Registry};

use super::report;
use crate::convert::{Converted, Converter};
use crate::file::{Input, Sequence, output};
use crate::program::Usage;
use crate::program::args::{ConvertArgs, check_options};
use crate::program::console::{self, BOLD, bytes, styled};
use crate::program::progress::Progress;

/// Says on the standard error what is missing from the output, where standard output is for programs.
pub(super) fn warn(converted: &Converted) {
    report::warn(&converted.input, &converted.report);
    for object in converted.objects.iter().filter(|o| o.fate == Fate::LeftOut) {
        let reason = object.reason.as_deref().unwrap_or("the format cannot hold it");
        console::warning(&format!("{}: \"{}\" was left out: {reason}", converted.output, object.object));
    }
}

pub(crate) fn run(args: &ConvertArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    if let Some(folder) = &args.into {
        return super::convert_many::run(args, folder, registry);
    }
    let [input, output] = args.files.as_slice() else {
        let text = "convert takes IN and OUT; for many inputs give --into DIR";
        return Err(Usage(text.to_owned()).into());
    };
    let to_stdout = output.as_os_str() == "-";
    let format = target(output, args.to.as_deref(), to_stdout, registry)?;
    if to_stdout && args.json.wanted {
        return Err(Usage("--json and an output to - cannot share the standard output".to_owned()).into());
    }
    let conversion = args.how.conversion(format.as_ref(), registry)?;
    let input = open(input, args.from.as_deref(), registry)?;
    sequence(output)?;
    let progress = Progress::start();
    let converter =
        Converter { format: format.as_ref(), conversion: &conversion, observer: &progress, registry };
    if to_stdout {
        check_reading(&converter, &input)?;
        let (memory, converted) = converter.encode(&input, "output").map_err(usage)?;
        drop(progress);
        warn(&converted);
        converted.notes.iter().for_each(|note| console::warning(note));
        let beside: Vec<&str> =
            memory.siblings.keys().chain(memory.pictures.keys()).map(String::as_str).collect();
        if !beside.is_empty() {
            console::warning(&format!(
                "the standard output takes one file: {} left out, which it names; name a file to get all",
                beside.join(", ")
            ));
        }
        console::print_bytes(&memory.bytes)?;
        return Ok(ExitCode::SUCCESS);
    }
    let converted = convert(&converter, &input, output)?;
    drop(progress);
    if args.json.wanted {
        warn(&converted);
        console::print_json(&converted)?;
    } else {
        console::print(&text(&converted))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The input, read as `from` where that is given.
pub(super) fn open(path: &Path, from: Option<&str>, registry: &Registry) -> anyhow::Result<Input> {
    if let Some(extension) = from {
        let known = registry.format_of(&format!("x.{extension}")).is_some_and(|f| f.declaration().reads);
        if !known {
            return Err(Usage(format!("--from {extension}: no readable format has this extension")).into());
        }
    }
    let input = Input::open(path)?;
    Ok(match from {
        Some(extension) => input.with_extension(extension),
        None => input,
    })
}

/// Reads, converts and writes one file.
pub(super) fn convert(converter: &Converter<'_>, input: &Input, output: &Path) -> anyhow::Result<Converted> {
    check_reading(converter, input)?;
    converter.file(input, output).map_err(usage)
}

/// Refuses options that the input's format does not have.
fn check_reading(converter: &Converter<'_>, input: &Input) -> anyhow::Result<()> {
    let Converter { conversion, registry, .. } = converter;
    check_options("--read", &input.format(registry)?.declaration(), &conversion.read, registry)?;
    Ok(())
}

/// A value that an option of a format cannot have is a fault of the command line.
fn usage(error: crate::Error) -> anyhow::Error {
    match &error {
        crate::Error::Format(e) if e.kind == FormatErrorKind::Option => Usage(error.to_string()).into(),
        _ => error.into(),
    }
}

/// The format to write: `to`, or what the output's name says.
fn target(
    output: &Path,
    to: Option<&str>,
    to_stdout: bool,
    registry: &Registry,
) -> anyhow::Result<Arc<dyn Format>> {
    let format = match to {
        Some(extension) => format_of(extension, registry)?,
        None if to_stdout => {
            return Err(Usage("an output to - needs --to EXT, which says in which format".to_owned()).into());
        }
        None => {
            check_output(output, registry)?;
            format_of(&output.file_name().unwrap_or_default().to_string_lossy(), registry)?
        }
    };
    if to_stdout && !format.declaration().plain {
        let name = format.declaration().name;
        return Err(Usage(format!("{name} is not plain text, and may be several files: name a file")).into());
    }
    Ok(format)
}

/// The writable format of an extension.
pub(super) fn format_of(extension: &str, registry: &Registry) -> anyhow::Result<Arc<dyn Format>> {
    let extension = extension.trim_start_matches('.');
    let file = format!("x.{extension}");
    let format = output::format_for(Path::new(&file), registry);
    format.cloned().map_err(|e| Usage(e.to_string().replacen(&file, extension, 1)).into())
}

/// The sequence of files that an output of the command line is.
pub(super) fn sequence(output: &Path) -> anyhow::Result<Option<Sequence>> {
    Sequence::of(output).map_err(|e| Usage(e.to_string()).into())
}

/// Refuses an output of the command line whose format is unknown, or that has two numbers.
pub(super) fn check_output(output: &Path, registry: &Registry) -> anyhow::Result<()> {
    sequence(output)?;
    if !crate::picture::is_picture(output) {
        output::format_for(output, registry).map_err(|e| Usage(e.to_string()))?;
    }
    Ok(())
}

fn text(converted: &Converted) -> String {
    let head = format!("{} → {}", converted.input, styled(BOLD, &converted.output));
    let objects = report::written(&converted.objects, converted.unit, &converted.notes);
    format!("{head}, {}\n{}{objects}", bytes(converted.bytes), report::read(&converted.report))
}
