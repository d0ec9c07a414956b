//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Field, Format, FormatDeclaration, FormatError, Place, ReadOptions, ReadReport, Registry, Sink, Source,
    WriteOptions, WriteReport,
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

/// Registers [`Points`].
#[derive(Debug, Clone, Copy, Default)]
pub struct PointsPlugin;

impl loftsman_kernel::plugin::Plugin for PointsPlugin {
    fn register(&self, registry: &mut Registry) {
        registry.format(Points);
    }
}

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
        }
    }

    /// At least two rows of numbers behind at most three lines of text.
    fn recognises(&self, head: &[u8]) -> bool {
        read::recognises(head)
    }

    /// Reads a point file. The report counts its rows and the columns that were left out, and its notes say
    /// which kind of file was recognised.
    ///
    /// # Errors
    /// When the bytes are no text, there is no row of two numbers or more, or a row has another number of
    /// columns, a number that is not finite, or text; with the line.
    fn read(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        options
            .own
            .check(self.declaration().reading_options())
            .map_err(|e| FormatError::new(source.name(), Place::File, e.to_string()))?;
        read::file(source, options)
    }

    /// Writes clouds and polylines, in the scene's coordinates: columns separated by commas under a header in a
    /// `.csv`, by blanks otherwise. A closed polyline repeats its first point at the end. Other objects are left
    /// out, and the report says so.
    ///
    /// # Errors
    /// When there is nothing to write, a coordinate is not finite, or the sink fails.
    fn write(
        &self,
        scene: &Scene,
        sink: &mut dyn Sink,
        options: &WriteOptions<'_>,
    ) -> Result<WriteReport, FormatError> {
        options
            .own
            .check(self.declaration().writing_options())
            .map_err(|e| FormatError::new(sink.name(), Place::File, e.to_string()))?;
        write::file(scene, sink, options)
    }
}
