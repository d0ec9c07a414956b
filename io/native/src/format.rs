//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Confidence, Fate, Format, FormatDeclaration, FormatError, Holds, Outgoing, ReadOptions, ReadReport, Sink,
    Source, WriteReport,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::text;

use crate::unknown::unknown;
use crate::{read, write};

/// The version of documents that this crate reads and writes.
pub const VERSION: u64 = 1;

/// The native format, `*.loft.json`: everything that a [`Scene`] holds, every number to the last bit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Native;

impl Format for Native {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "loft",
            help: "The native document: everything a scene holds, every number to the last bit.",
            extensions: &["loft.json"],
            reads: true,
            writes: true,
            plain: true,
            options: &[],
            holds: Holds::EVERYTHING,
        }
    }

    /// A JSON object with the key `"loftsman"`.
    fn confidence(&self, head: &[u8]) -> Confidence {
        if text::has_key(head, "loftsman") { Confidence::Sure } else { Confidence::No }
    }

    /// The report counts the document's objects, those of definitions too; every one is kept, or there is an error.
    /// Shapes of kinds that the options do not know are kept word for word, and the report says so.
    ///
    /// # Errors
    /// When the bytes are not a whole UTF-8 JSON document of version 1, or anything in it is not what the
    /// format allows. The error has the path, the line and the object.
    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        let scene = read::document(source.bytes(), options)?;
        let mut report = ReadReport::default();
        let defined = scene.definitions().iter().map(|d| d.objects().len()).sum::<usize>();
        report.count_many(Fate::Kept, "", scene.objects().len() + defined);
        report.notes.extend(unknown(&scene));
        Ok((scene, report))
    }

    /// Writes a document, in the scene's unit and up axis unless the options say otherwise. The same scene gives
    /// the same bytes.
    ///
    /// # Errors
    /// When the scene has what no document can hold (a number that is not finite), or the sink fails.
    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        write::document(outgoing, sink)
    }
}
