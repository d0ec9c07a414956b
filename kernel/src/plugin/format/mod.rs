//! File formats: scenes from bytes and bytes from scenes.

mod cuts;
mod declaration;
mod error;
mod losses;
mod options;
mod outgoing;
mod report;
mod stream;

pub use cuts::Cuts;
pub use declaration::{FormatDeclaration, Holds, MeshPart, UnitRule};
pub use error::{FormatError, FormatErrorKind, Place};
pub use options::{Limits, ReadOptions, UpChoice, WriteOptions};
pub use outgoing::{InWorld, Outgoing};
pub use report::{Fate, ReadReport, WriteReport, Written};
pub use stream::{Memory, Sink, Source, refuse_utf16, utf8};

use crate::declare::Parameters;
use crate::scene::{Scene, Unit};
use crate::tessellator::Fineness;

/// How sure a format is that a file is one of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// It is none.
    No,
    /// It could be one, if nobody else is sure that it is theirs.
    Maybe,
    /// It is one: it says so.
    Sure,
}

/// A file format: what it declares, how its bytes are parsed and made. What is the same for all formats (checks of options and
/// limits, units and axes, instances where there are none, notes of what is lost) is done around that, by
/// [`read`](Self::read) and [`write`](Self::write), which others call.
pub trait Format: Send + Sync {
    /// Its name, extensions and options, and what it holds.
    fn declaration(&self) -> FormatDeclaration;

    /// What its files hold that are written with these options of its own: what it declares, unless one of them changes that.
    ///
    /// # Errors
    /// When an option's value cannot be.
    fn holds(&self, own: &Parameters) -> Result<Holds, FormatError> {
        let _ = own;
        Ok(self.declaration().holds)
    }

    /// What would be lost of a scene that is written with these options, a line for each kind of thing: the same as
    /// [`WriteReport::losses`] once it is written.
    ///
    /// # Errors
    /// When an option is unknown or its value cannot be, and where the format refuses the scene because nothing of it would
    /// go out.
    fn losses(&self, scene: &Scene, options: &WriteOptions<'_>) -> Result<Vec<String>, FormatError> {
        let declaration = self.declaration();
        declaration.check(&options.own, declaration.writing_options())?;
        let holds = self.holds(&options.own)?;
        match holds.refusal(scene) {
            Some(problem) => Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported)),
            None => {
                let mut losses = holds.losses(scene, options);
                losses.extend(self.further_losses(scene));
                Ok(losses)
            }
        }
    }

    /// What is lost or changed of a scene that no declaration says, a line for each kind of thing: names that cannot stand in a file as they
    /// are. Told behind what is declared, by [`losses`](Self::losses). Nothing by default.
    fn further_losses(&self, scene: &Scene) -> Vec<String> {
        let _ = scene;
        Vec::new()
    }

    /// How finely it has splines cut where nobody says: what its readers look at closely wants more. A thousandth of the diagonal
    /// and 15 degrees by default.
    fn fineness(&self) -> Fineness {
        Fineness::default()
    }

    /// How sure it is of the first bytes of a file (up to 4096 of them).
    fn confidence(&self, head: &[u8]) -> Confidence {
        let _ = head;
        Confidence::No
    }

    /// Parses a file: its scene, in the unit and axes that it states, and an account of every entity in it.
    ///
    /// # Errors
    /// When the bytes are not this format, or break its rules; with the place. The file's name is filled in by
    /// [`read`](Self::read).
    fn decode(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError>;

    /// Makes the bytes of a scene, and says how each object went out.
    ///
    /// # Errors
    /// When the format cannot hold the scene at all, or the sink fails. The file's name is filled in by
    /// [`write`](Self::write).
    fn encode(&self, outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError>;

    /// Reads a file: the scene, and an account of every entity in it.
    ///
    /// # Errors
    /// As for [`decode`](Self::decode); also when an option is unknown, or there is more than the options allow.
    fn read(
        &self,
        source: &dyn Source,
        options: &ReadOptions<'_>,
    ) -> Result<(Scene, ReadReport), FormatError> {
        let work = || {
            let declaration = self.declaration();
            declaration.check(&options.own, declaration.reading_options())?;
            options.limits.check_bytes(source.bytes().len())?;
            let (mut scene, mut report) = self.decode(source, options)?;
            options.limits.check_entities(report.entities)?;
            options.limits.check_depth(&scene)?;
            note_unit_and_up(declaration.holds.unit, options, &mut scene, &mut report);
            Ok((scene, report))
        };
        work().map_err(|error: FormatError| error.in_file(source.name()))
    }

    /// Writes a scene.
    ///
    /// # Errors
    /// As for [`encode`](Self::encode); also when an option is unknown, the scene is unsound, or instances show more
    /// objects than a format without them can write one by one.
    fn write(
        &self,
        scene: &Scene,
        sink: &mut dyn Sink,
        options: &WriteOptions<'_>,
    ) -> Result<WriteReport, FormatError> {
        let mut work = || {
            let declaration = self.declaration();
            scene.check()?;
            let losses = self.losses(scene, options)?;
            let outgoing = Outgoing::new(scene, &declaration.holds, options)?;
            let mut report = self.encode(&outgoing, sink).map_err(|error| match error.kind {
                // A scene that is sound: what is wrong with it is that the format cannot hold it.
                FormatErrorKind::Malformed => error.as_kind(FormatErrorKind::Unsupported),
                _ => error,
            })?;
            report.losses = losses;
            Ok(report)
        };
        let result = work();
        result.map_err(|error: FormatError| error.in_file(sink.name()))
    }
}

/// The unit and the axis that are asked for take the place of those that the file states, or does not; the report says so.
fn note_unit_and_up(rule: UnitRule, options: &ReadOptions<'_>, scene: &mut Scene, report: &mut ReadReport) {
    let stated = if rule == UnitRule::None { report.unit } else { Some(scene.unit) };
    scene.unit = options.unit.or(stated).unwrap_or(Unit::Unknown);
    let unit = scene.unit.name();
    // That a unit is unknown is said where it matters: by who writes it as another, and who measures.
    if let Some(stated) = stated.filter(|stated| *stated != scene.unit) {
        let stated = stated.name();
        report.notes.push(format!("the unit {unit} is noted instead of the file's {stated}, as asked for"));
    }
    if let Some(up) = options.up.filter(|up| *up != scene.up) {
        report
            .notes
            .push("the up axis is noted as asked for, not as the file or its format has it".to_owned());
        scene.up = up;
    }
}
