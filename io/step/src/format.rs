//! The format as the registry knows it.

use loftsman_kernel::plugin::{
    Confidence, Format, FormatDeclaration, FormatError, Holds, Outgoing, ReadOptions, ReadReport, Sink,
    Source, UnitRule, WriteReport,
};
use loftsman_kernel::scene::{Scene, Up};

use crate::{read, write};

/// STEP files; see the [crate's page](crate).
#[derive(Debug, Clone, Copy, Default)]
pub struct Step;

impl Format for Step {
    fn declaration(&self) -> FormatDeclaration {
        FormatDeclaration {
            name: "step",
            help: "STEP (AP203, AP214, AP242): curves, surfaces, solids, assemblies",
            extensions: &["step", "stp", "p21"],
            reads: true,
            writes: true,
            plain: true,
            options: &[],
            holds: Holds {
                unit: UnitRule::Stated,
                up: Some(Up::Z),
                exact: &[
                    "group", "instance", "curve", "surface", "trimmed", "brep", "mesh", "polyline", "cloud",
                ],
                knots: true,
                hierarchy: true,
                layers: true,
                layer_trees: true,
                hides: true,
                colors: true,
                base_colors: true,
                labels: true,
                splines_of_shapes: true,
                statements: &[crate::OCCURRENCE],
                ..Holds::NOTHING
            },
        }
    }

    /// Sure of files that begin with `ISO-10303-21`.
    fn confidence(&self, head: &[u8]) -> Confidence {
        read::confidence(head)
    }

    /// The report counts entities (`#number = …`).
    ///
    /// # Errors
    /// When the text breaks the rules of ISO 10303-21, with the line; when nothing in it is geometry that is read.
    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        read::read(source, options)
    }

    /// # Errors
    /// When objects hang too deep under one another, a coordinate overflows, or the sink fails.
    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
        write::write(outgoing, sink)
    }
}
