//! `convert IN OUT`, and with `--into` many inputs at once ([`super::convert_many`]).

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use loftsman::convert::Conversion;
use loftsman::file::{Content, Input, Outputs, Produced, Sequence, output};
use loftsman::kernel::plugin::{
    Fate, Format, FormatDeclaration, FormatErrorKind, Memory, Observer, ReadReport, Source, WriteOptions,
    WriteReport, Written,
};
use loftsman::kernel::scene::Scene;

use super::report;
use crate::Usage;
use crate::args::{ConvertArgs, check_options};
use crate::console::{self, BOLD, bytes, styled};
use crate::progress::Progress;

/// What a conversion read and wrote.
#[derive(serde::Serialize)]
pub(super) struct Converted {
    pub(super) input: String,
    pub(super) format: &'static str,
    pub(super) output: String,
    pub(super) bytes: u64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    siblings: Vec<Produced>,
    /// Of a sequence, the file of each frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frames: Vec<Produced>,
    report: ReadReport,
    objects: Vec<Written>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
}

impl Converted {
    /// Says on the standard error what is missing from the output, where standard output is for programs.
    pub(super) fn warn(&self) {
        report::warn(&self.input, &self.report);
        for object in self.objects.iter().filter(|o| o.fate == Fate::LeftOut) {
            let reason = object.reason.as_deref().unwrap_or("the format cannot hold it");
            console::warning(&format!("{}: \"{}\" was left out: {reason}", self.output, object.object));
        }
    }

    /// Entities that the reader left out, and objects that the writer did.
    pub(super) fn left_out(&self) -> usize {
        let objects = self.objects.iter().filter(|o| o.fate == Fate::LeftOut).count();
        self.report.left_out.values().sum::<usize>() + objects
    }
}

pub(crate) fn run(args: &ConvertArgs) -> anyhow::Result<ExitCode> {
    if let Some(folder) = &args.into {
        return super::convert_many::run(args, folder);
    }
    let [input, output] = args.files.as_slice() else {
        let text = "convert takes IN and OUT; for many inputs give --into DIR";
        return Err(Usage(text.to_owned()).into());
    };
    let to_stdout = output.as_os_str() == "-";
    let format = target(output, args.to.as_deref(), to_stdout)?;
    if to_stdout && args.json.wanted {
        return Err(Usage("--json and an output to - cannot share the standard output".to_owned()).into());
    }
    let conversion = args.how.conversion(format.as_ref())?;
    let input = open(input, args.from.as_deref())?;
    let progress = Progress::start();
    if to_stdout {
        let (memory, converted) = encode(&input, "output", format.as_ref(), &conversion, &progress)?;
        drop(progress);
        converted.warn();
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
    let converted = match sequence(output)? {
        Some(sequence) => convert_frames(&input, &sequence, format.as_ref(), &conversion, &progress)?,
        None => convert(&input, output, format.as_ref(), &conversion, &progress)?,
    };
    drop(progress);
    if args.json.wanted {
        converted.warn();
        console::print_json(&converted)?;
    } else {
        console::print(&text(&converted))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The input, read as `from` where that is given.
pub(super) fn open(path: &Path, from: Option<&str>) -> anyhow::Result<Input> {
    let registry = loftsman::registry();
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
pub(super) fn convert(
    input: &Input,
    output: &Path,
    format: &dyn Format,
    conversion: &Conversion,
    observer: &dyn Observer,
) -> anyhow::Result<Converted> {
    let mut outputs = Outputs::new();
    outputs.protect(Source::name(input));
    outputs.claim(output)?;
    let name = output.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let (memory, mut converted) = encode(input, &name, format, conversion, observer)?;
    outputs.add_memory(output, memory)?;
    for produced in outputs.commit_watched(observer)? {
        converted.notes.extend(produced.note());
        converted.output = produced.path;
        converted.siblings = produced.siblings;
    }
    Ok(converted)
}

/// Reads a file and writes one for each frame of it.
fn convert_frames(
    input: &Input,
    sequence: &Sequence,
    format: &dyn Format,
    conversion: &Conversion,
    observer: &dyn Observer,
) -> anyhow::Result<Converted> {
    let mut outputs = Outputs::new();
    outputs.protect(Source::name(input));
    outputs.claim(sequence.file(0))?;
    let read = read(input, conversion, observer)?;
    let reports = sequence
        .each(&read.scene, observer, |file, moment| {
            let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            let (memory, report) =
                write(input, &read.scene.at(moment)?, &read.format, &name, format, conversion, observer)?;
            outputs.add_memory(file, memory)?;
            Ok(report)
        })
        .map_err(usage)?;
    let count = reports.len();
    let mut converted = converted(input, read, sequence.shown(), 0, Sequence::report(reports), conversion);
    converted.notes.extend(sequence.notes(count));
    let files = outputs.commit_watched(observer)?;
    converted.notes.extend(files.iter().filter_map(Produced::note));
    converted.bytes = sequence.produced(&files).bytes;
    converted.frames = files;
    Ok(converted)
}

fn encode(
    input: &Input,
    name: &str,
    format: &dyn Format,
    conversion: &Conversion,
    observer: &dyn Observer,
) -> anyhow::Result<(Memory, Converted)> {
    let read = read(input, conversion, observer)?;
    let (memory, written) =
        write(input, &read.scene, &read.format, name, format, conversion, observer).map_err(usage)?;
    let bytes = memory.bytes.len() as u64;
    Ok((memory, converted(input, read, name.to_owned(), bytes, written, conversion)))
}

fn read(input: &Input, conversion: &Conversion, observer: &dyn Observer) -> anyhow::Result<Content> {
    let registry = loftsman::registry();
    check_options("--read", &input.format(registry)?.declaration(), &conversion.read)?;
    conversion.read(input, observer, registry).map_err(usage)
}

fn write(
    input: &Input,
    scene: &Scene,
    from: &FormatDeclaration,
    name: &str,
    format: &dyn Format,
    conversion: &Conversion,
    observer: &dyn Observer,
) -> loftsman::Result<(Memory, WriteReport)> {
    let asked = conversion.write_options(Some(from), format.declaration().name);
    let options = WriteOptions { observer, pictures: Some(input), ..asked };
    output::encode(scene, name, format, &options, loftsman::registry())
}

fn converted(
    input: &Input,
    read: Content,
    output: String,
    bytes: u64,
    mut written: WriteReport,
    conversion: &Conversion,
) -> Converted {
    let objects = std::mem::take(&mut written.objects);
    let mut notes = written.told();
    notes.extend(conversion.idle_fineness(&objects));
    Converted {
        input: Source::name(input).to_owned(),
        format: read.format.name,
        output,
        bytes,
        siblings: Vec::new(),
        frames: Vec::new(),
        report: read.report,
        objects,
        notes,
    }
}

/// A value that an option of a format cannot have is a fault of the command line.
fn usage(error: loftsman::Error) -> anyhow::Error {
    match &error {
        loftsman::Error::Format(e) if e.kind == FormatErrorKind::Option => Usage(error.to_string()).into(),
        _ => error.into(),
    }
}

/// The format to write: `to`, or what the output's name says.
fn target(output: &Path, to: Option<&str>, to_stdout: bool) -> anyhow::Result<Arc<dyn Format>> {
    let format = match to {
        Some(extension) => format_of(extension)?,
        None if to_stdout => {
            return Err(Usage("an output to - needs --to EXT, which says in which format".to_owned()).into());
        }
        None => {
            check_output(output)?;
            format_of(&output.file_name().unwrap_or_default().to_string_lossy())?
        }
    };
    if to_stdout && !format.declaration().plain {
        let name = format.declaration().name;
        return Err(Usage(format!("{name} is not plain text, and may be several files: name a file")).into());
    }
    Ok(format)
}

/// The writable format of an extension.
pub(super) fn format_of(extension: &str) -> anyhow::Result<Arc<dyn Format>> {
    let extension = extension.trim_start_matches('.');
    let file = format!("x.{extension}");
    let format = output::format_for(Path::new(&file), loftsman::registry());
    format.cloned().map_err(|e| Usage(e.to_string().replacen(&file, extension, 1)).into())
}

/// The sequence of files that an output of the command line is.
pub(super) fn sequence(output: &Path) -> anyhow::Result<Option<Sequence>> {
    Sequence::of(output).map_err(|e| Usage(e.to_string()).into())
}

/// Refuses an output of the command line whose format is unknown, or that has two numbers.
pub(super) fn check_output(output: &Path) -> anyhow::Result<()> {
    sequence(output)?;
    if !loftsman::picture::is_picture(output) {
        output::format_for(output, loftsman::registry()).map_err(|e| Usage(e.to_string()))?;
    }
    Ok(())
}

fn text(converted: &Converted) -> String {
    let head = format!("{} → {}", converted.input, styled(BOLD, &converted.output));
    let objects = report::written(&converted.objects, &converted.notes);
    format!("{head}, {}\n{}{objects}", bytes(converted.bytes), report::read(&converted.report))
}
