//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Confidence, Field, Format, FormatDeclaration, FormatError, Holds, Outgoing, ReadOptions, ReadReport,
    Sink, Source, WriteReport,
};
use loftsman_kernel::scene::Scene;

use crate::{read, write};

const OPTIONS: &[Field] = &[
    Field::optional(
        "as",
        "\"polyline\" | \"cloud\"",
        "by content and extension",
        "reading: whether the rows are a chain in their order or loose points",
    ),
    Field::optional(
        "comments",
        "true | false",
        "true",
        "writing: comments with unit, names and kinds, which reading understands",
    ),
];

/// Point files: airfoil outlines, csv, xyz; see the [crate's page](crate).
#[derive(Debug, Clone, Copy, Default)]
pub struct Points;

impl Format for Points {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "points",
            help: "Rows of coordinates: airfoil outlines (Selig, Lednicer, AeroDyn), csv, xyz.",
            extensions: &["xyz", "csv", "dat", "txt", "cpt", "asc", "pts"],
            reads: true,
            writes: true,
            plain: true,
            options: OPTIONS,
            holds: Holds { exact: &["polyline", "cloud"], refuses_nothing: true, ..Holds::NOTHING },
        }
    }

    /// At least two rows of numbers behind at most three lines of text; sure of files that were written here.
    fn confidence(&self, head: &[u8]) -> Confidence {
        read::confidence(head)
    }

    /// The report counts a file's rows and the columns that were left out, and its notes say which kind of file was
    /// recognised.
    ///
    /// # Errors
    /// When the bytes are no text, there is no row of two numbers or more, or a row has another number of
    /// columns, a number that is not finite, or text that is neither heading nor footnote; with the line.
    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        read::file(source, options)
    }

    /// Writes clouds and polylines, in the scene's coordinates: columns separated by commas under a header in a
    /// `.csv`, by blanks otherwise. A closed polyline repeats its first point at the end. Other objects are left
    /// out, and the report says so.
    ///
    /// # Errors
    /// When there is nothing to write, a coordinate is not finite, or the sink fails.
    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        write::file(outgoing, sink)
    }
}
