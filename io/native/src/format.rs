//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Fate, Format, FormatDeclaration, FormatError, Place, ReadOptions, ReadReport, Registry, Sink, Source,
    WriteOptions, WriteReport,
};
use loftsman_kernel::scene::Scene;

use crate::unknown::unknown;
use crate::{read, write};

/// The version of documents that this crate reads and writes.
pub const VERSION: u64 = 1;

/// The native format, `*.loft.json`: everything that a [`Scene`] holds, every number to the last bit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Native;

/// Registers [`Native`].
#[derive(Debug, Clone, Copy, Default)]
pub struct NativePlugin;

impl loftsman_kernel::plugin::Plugin for NativePlugin {
    fn register(&self, registry: &mut Registry) {
        registry.format(Native);
    }
}

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
        }
    }

    /// A JSON object with the key `"loftsman"` near its start.
    fn recognises(&self, head: &[u8]) -> bool {
        const KEY: &[u8] = b"\"loftsman\"";
        let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head).trim_ascii_start();
        head.starts_with(b"{")
            && head.windows(KEY.len()).enumerate().any(|(at, window)| {
                window == KEY && head[at + KEY.len()..].trim_ascii_start().starts_with(b":")
            })
    }

    /// Reads a document. The report counts its objects, those of definitions too; every one is kept, or there is an error.
    /// Shapes of kinds that the options do not know are kept word for word, and the report says so.
    ///
    /// # Errors
    /// When the bytes are not a whole UTF-8 JSON document of version 1, or anything in it is not what the
    /// format allows. The error has the path, the line and the object.
    fn read(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        options
            .own
            .check(self.declaration().options)
            .map_err(|e| FormatError::new(source.name(), Place::File, e.to_string()))?;
        let mut scene = read::document(source.name(), source.bytes(), options)?;
        let mut report = ReadReport::default();
        let defined = scene.definitions().iter().map(|d| d.objects().len()).sum::<usize>();
        report.count_many(Fate::Kept, "", scene.objects().len() + defined);
        report.notes.extend(unknown(&scene));
        if let Some(unit) = options.unit.filter(|&unit| unit != scene.unit) {
            let (new, old) = (unit.name(), scene.unit.name());
            report
                .notes
                .push(format!("the unit {new} is noted instead of the document's {old}, as asked for"));
            scene.unit = unit;
        }
        if let Some(up) = options.up.filter(|&up| up != scene.up) {
            report.notes.push("the up axis is noted as asked for, not as in the document".to_owned());
            scene.up = up;
        }
        Ok((scene, report))
    }

    /// Writes a document, in the scene's unit and up axis unless the options say otherwise. The same scene gives
    /// the same bytes.
    ///
    /// # Errors
    /// When the scene has what no document can hold (a number that is not finite, a hierarchy that does not end,
    /// lists of unequal length), or the sink fails.
    fn write(
        &self,
        scene: &Scene,
        sink: &mut dyn Sink,
        options: &WriteOptions<'_>,
    ) -> Result<WriteReport, FormatError> {
        options
            .own
            .check(self.declaration().options)
            .map_err(|e| FormatError::new(sink.name(), Place::File, e.to_string()))?;
        write::document(scene, sink, options)
    }
}
