//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Confidence, Format, FormatDeclaration, FormatError, Holds, Outgoing, ReadOptions, ReadReport, Sink,
    Source, UnitRule, WriteReport,
};
use loftsman_kernel::scene::{Scene, Up};

use crate::{read, write};

/// IGES files; see the [crate's page](crate).
#[derive(Debug, Clone, Copy, Default)]
pub struct Iges;

impl Format for Iges {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "iges",
            help: "IGES 5.3: curves, surfaces, trimmed surfaces, solids, subfigures",
            extensions: &["igs", "iges"],
            reads: true,
            writes: true,
            plain: true,
            options: &[],
            holds: Holds {
                unit: UnitRule::Stated,
                up: Some(Up::Z),
                exact: &["group", "instance", "curve", "surface", "trimmed", "brep", "polyline", "cloud"],
                knots: true,
                hierarchy: true,
                layers: true,
                hides: true,
                colors: true,
                splines_of_shapes: true,
                ..Holds::NOTHING
            },
        }
    }

    /// Sure of files whose first line has the letter `S` in column 73.
    fn confidence(&self, head: &[u8]) -> Confidence {
        read::confidence(head)
    }

    /// The report counts entities of the directory.
    ///
    /// # Errors
    /// When the text has no sections, or no directory that can be told, with the line; when nothing in it is geometry that is read.
    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        read::read(source, options)
    }

    /// # Errors
    /// When objects hang too deep under one another, a coordinate overflows, there are more lines than seven digits can count, or the
    /// sink fails.
    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        write::write(outgoing, sink)
    }
}
