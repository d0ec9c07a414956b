//! The reader: parts of the file in parallel, then what depends on the order of its statements.

mod build;
mod freeform;
mod mesh;
mod mtl;
mod ours;
mod part;
mod raw;
mod reader;
mod section;
mod statement;
mod tally;
mod unbroken;

use loftsman_kernel::plugin::{FormatError, Place, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::{Scene, Unit, Up};

use crate::text::{Statements, decode, keyword, tokens};
use part::Counts;
use reader::Reader;

pub(crate) use mtl::{CHANNELS, GREY, roughness};

/// What starts a new object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Split {
    Object,
    Group,
    Never,
}

/// How many parts are read before what they hold goes into the sections: enough for many threads, few enough that
/// what they hold stays small.
const WAVE: usize = 16;

/// Whether the first bytes of a file look like OBJ: its first statements are OBJ's, and one of them is geometry.
pub(crate) fn recognises(head: &[u8]) -> bool {
    let (text, _) = decode(head);
    let mut statements = Statements::new(&text);
    let mut geometry = false;
    while let Some((_, statement)) = statements.next() {
        // The last statement of a head may be cut off.
        if statements.left() == 0 && geometry {
            break;
        }
        let (word, rest) = keyword(&statement);
        match word {
            b"v" | b"vn" | b"vt" | b"vp" | b"f" | b"l" => {
                let first = tokens(rest).next().and_then(|w| w.first());
                if !first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b)) {
                    return false;
                }
                geometry = true;
            }
            b"p" | b"fo" => {}
            // A comment that was written here.
            b"#" => {}
            _ if word.starts_with(crate::text::MRGB) => {}
            other
                if statement::known(other).is_some()
                    || [statement::DISPLAY, statement::OBSOLETE].iter().any(|list| list.contains(&other)) => {
            }
            _ => return false,
        }
    }
    geometry
}

/// Every item in its order, in parallel where that feature is on.
#[cfg(feature = "parallel")]
fn each<T: Send, R: Send>(items: Vec<T>, work: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    items.into_par_iter().map(work).collect()
}

#[cfg(not(feature = "parallel"))]
fn each<T, R>(items: Vec<T>, work: impl Fn(T) -> R) -> Vec<R> {
    items.into_iter().map(work).collect()
}

/// Reads a file.
pub(crate) fn read(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    let words = [("object", Split::Object), ("group", Split::Group), ("none", Split::Never)];
    let split = options.own.choice_or("split", &words, Split::Object)?;
    let (text, encoding) = decode(source.bytes());
    let parts = part::split(&text);
    let counts = each(parts.clone(), part::count);
    let total = counts.iter().copied().fold(Counts::default(), Counts::and);
    options.limits.check_entities(total.points + total.uvs + total.normals)?;
    let mut reader = Reader::new(split, total, text.len() / 2 + 4096);
    let mut before = Counts::default();
    let mut done = 0_u64;
    for (parts, counts) in parts.chunks(WAVE).zip(counts.chunks(WAVE)) {
        options.observer.proceed("reading", done, text.len() as u64)?;
        let mut at = before;
        let mut work = Vec::with_capacity(parts.len());
        let slots = reader.raw.slots(before, counts);
        for ((part, count), slots) in parts.iter().zip(counts).zip(slots) {
            work.push((*part, at, slots));
            at = at.and(*count);
        }
        let parsed = each(work, |(part, before, slots)| (part::parse(part, before, total, slots), before));
        for (parsed, before) in parsed {
            reader.take(parsed, before);
        }
        before = at;
        done += parts.iter().map(|part| part.len() as u64).sum::<u64>();
    }
    let head = ours::head(&text);
    // What was written here of objects that OBJ has no statements for, as groups, is a file all the same.
    if reader.understood == 0 && head.is_none() {
        // Where there are some, and all of them are wrong, the first of them is.
        if let Some((line, problem)) = reader.first_wrong {
            return Err(FormatError::new(Place::Line(line), problem));
        }
        return Err(FormatError::whole("no statement of an OBJ file was found in it"));
    }
    let mut report = ReadReport::default();
    let mut scene = Scene::new();
    scene.up = Up::Y;
    if let Some((unit, up)) = head {
        (report.unit, scene.up) = (Some(unit).filter(|unit| *unit != Unit::Unknown), up);
    } else if options.up.is_none() {
        report.notes.push("y is taken as up, as OBJ programs have it".to_owned());
    }
    reader.old = encoding.map(|encoding| (source.name().to_owned(), encoding)).into_iter().collect();
    reader.finish(source, &text, &mut scene, &mut report)?;
    Ok((scene, report))
}
