//! The reader: finds the entities, then builds what nothing else owns.

mod brep;
mod conic;
mod curve;
mod emit;
mod entity;
mod face;
mod pace;
mod place;
mod report;
mod spline;
mod style;
mod surface;
mod torn;
mod tree;
mod trim;
mod turned;
mod whole;

use loftsman_kernel::plugin::{Confidence, FormatError, Place, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::Scene;

use crate::text::{File, Length};
use emit::Emitter;
use entity::Reader;
use report::Account;
use style::Styles;

/// How sure the first bytes of a file are those of an IGES file.
pub(crate) fn confidence(head: &[u8]) -> Confidence {
    crate::text::confidence(loftsman_kernel::text::unmarked(head))
}

/// Reads a file.
pub(crate) fn read(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    loftsman_kernel::plugin::refuse_utf16(source.bytes(), 0)?;
    let file = File::scan(source.bytes()).map_err(|fault| {
        let place = if fault.line == 0 { Place::File } else { Place::Line(fault.line) };
        FormatError::new(place, fault.problem)
    })?;
    options.limits.check_entities(file.len())?;
    let reader = Reader::new(&file);
    let mut account = Account::new(&file);
    let styles = Styles::new(&reader);
    account.keep(&reader.take_used());
    let name = source.name().rsplit(['/', '\\']).next().unwrap_or_default();
    let stem = name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("object");
    let mut scene = Emitter::new(&reader, &styles, &mut account, stem).scene(options)?;
    scene.unit = file.global.length.unit();
    match &file.global.length {
        Length::Known(_) => {}
        Length::Unsaid => {
            account.note("no unit is named: lengths are inches, which is the default of IGES; name the unit of the input if it is another".to_owned());
        }
        Length::Nameless(flag) => {
            let flag = loftsman_kernel::text::clip(flag);
            account.note(format!(
                "the flag \"{flag}\" of the unit comes without a name and is none of its own: the unit is unknown, numbers are taken as they are"
            ));
        }
        Length::Other(name) => {
            let name = loftsman_kernel::text::clip(name);
            account.note(format!("the unit \"{name}\" is none that is known: numbers are taken as they are; name the unit of the input"));
        }
    }
    account.finish(scene)
}
