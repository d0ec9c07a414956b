//! One file into another, or into one for each frame.

use std::path::Path;

use loftsman_kernel::plugin::{
    Fate, Format, FormatDeclaration, Memory, Observer, Quiet, ReadReport, Registry, Source, WriteOptions,
    WriteReport, Written,
};
use loftsman_kernel::scene::{Scene, Unit};

use super::Conversion;
use crate::error::Result;
use crate::file::output::{self, format_for};
use crate::file::{Content, Input, Outputs, Produced, Sequence};

/// What a conversion read and wrote.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Converted {
    /// The file that was read.
    pub input: String,
    /// Its format.
    pub format: &'static str,
    /// The file that was written.
    pub output: String,
    /// Its size.
    pub bytes: u64,
    /// What was written beside it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub siblings: Vec<Produced>,
    /// Of a sequence, the file of each frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<Produced>,
    /// What was kept of the input and what was left out.
    pub report: ReadReport,
    /// The unit of the scene, in which distances of these are.
    pub unit: Unit,
    /// What became of each object.
    pub objects: Vec<Written>,
    /// What else there is to say.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl Converted {
    /// Entities that the reader left out, and objects that the writer did.
    pub fn left_out(&self) -> usize {
        let objects = self.objects.iter().filter(|o| o.fate == Fate::LeftOut).count();
        self.report.left_out.values().sum::<usize>() + objects
    }
}

/// Converts a file to the format that the output's name says (with `#` in it, one file for each frame of the animation).
/// Everything is written, or nothing.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("loftsman-convert-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// # let (points, out) = (folder.join("p.xyz"), folder.join("p.obj"));
/// # std::fs::write(&points, "0 0 0\n1 0 0\n1 1 0\n")?;
/// use loftsman::convert::Conversion;
/// let done = loftsman::convert(&points, &out, &Conversion::default(), loftsman::registry())?;
/// assert_eq!((done.format, done.objects.len(), done.left_out()), ("points", 1, 0));
/// # std::fs::remove_dir_all(folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the input cannot be read, nothing of it can be kept, or the output cannot be written; nothing is written then.
pub fn convert(
    input: impl AsRef<Path>,
    output: impl AsRef<Path>,
    conversion: &Conversion,
    registry: &Registry,
) -> Result<Converted> {
    let output = output.as_ref();
    let format = format_for(output, registry)?;
    let input = Input::open(input)?;
    Converter { format: format.as_ref(), conversion, observer: &Quiet, registry }.file(&input, output)
}

/// How files are converted: to which format, with what asked of it, watched by whom.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "formats and observers are not")]
pub struct Converter<'a> {
    /// The format to write.
    pub format: &'a dyn Format,
    /// What is asked.
    pub conversion: &'a Conversion,
    /// Who watches.
    pub observer: &'a dyn Observer,
    /// Which formats there are.
    pub registry: &'a Registry,
}

impl Converter<'_> {
    /// Converts one file, or of an output with `#` in its name each frame of one.
    ///
    /// # Errors
    /// As for [`convert`].
    pub fn file(&self, input: &Input, output: &Path) -> Result<Converted> {
        if let Some(sequence) = Sequence::of(output)? {
            return self.frames(input, &sequence);
        }
        let mut outputs = Outputs::new();
        outputs.protect(Source::name(input));
        outputs.claim(output)?;
        let (memory, mut converted) = self.encode(input, &name_of(output))?;
        outputs.add_memory(output, memory)?;
        for produced in outputs.commit_watched(self.observer)? {
            converted.notes.extend(produced.note());
            converted.output = produced.path;
            converted.siblings = produced.siblings;
        }
        Ok(converted)
    }

    /// Converts to memory, under a name.
    ///
    /// # Errors
    /// As for [`convert`].
    pub fn encode(&self, input: &Input, name: &str) -> Result<(Memory, Converted)> {
        let read = self.read(input)?;
        let (memory, written) = self.write(input, &read.scene, &read.format, name)?;
        let bytes = memory.bytes.len() as u64;
        Ok((memory, self.converted(input, read, name.to_owned(), bytes, written)))
    }

    fn frames(&self, input: &Input, sequence: &Sequence) -> Result<Converted> {
        let mut outputs = Outputs::new();
        outputs.protect(Source::name(input));
        outputs.claim(sequence.file(0))?;
        let read = self.read(input)?;
        let reports = sequence.each(&read.scene, self.observer, |file, moment| {
            let (memory, report) =
                self.write(input, &read.scene.at(moment)?, &read.format, &name_of(file))?;
            outputs.add_memory(file, memory)?;
            Ok(report)
        })?;
        let count = reports.len();
        let mut converted = self.converted(input, read, sequence.shown(), 0, Sequence::report(reports));
        converted.notes.extend(sequence.notes(count));
        let files = outputs.commit_watched(self.observer)?;
        converted.notes.extend(files.iter().filter_map(Produced::note));
        converted.bytes = sequence.produced(&files).bytes;
        converted.frames = files;
        Ok(converted)
    }

    fn read(&self, input: &Input) -> Result<Content> {
        self.conversion.read(input, self.observer, self.registry)
    }

    fn write(
        &self,
        input: &Input,
        scene: &Scene,
        from: &FormatDeclaration,
        name: &str,
    ) -> Result<(Memory, WriteReport)> {
        let asked = self.conversion.write_options(Some(from), self.format);
        let options = WriteOptions { observer: self.observer, pictures: Some(input), ..asked };
        output::encode(scene, name, self.format, &options, self.registry)
    }

    fn converted(
        &self,
        input: &Input,
        read: Content,
        output: String,
        bytes: u64,
        mut written: WriteReport,
    ) -> Converted {
        let objects = std::mem::take(&mut written.objects);
        let mut notes = written.told();
        notes.extend(self.conversion.idle_fineness(&objects));
        Converted {
            input: Source::name(input).to_owned(),
            format: read.format.name,
            output,
            bytes,
            siblings: Vec::new(),
            frames: Vec::new(),
            report: read.report,
            unit: read.scene.unit,
            objects,
            notes,
        }
    }
}

/// The name of a file without its folder.
fn name_of(file: &Path) -> String {
    file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}
