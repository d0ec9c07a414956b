//! The reader: statements in their order, with the state that OBJ keeps between them.

mod build;
mod elements;
mod freeform;
mod material;
mod raw;

use std::borrow::Cow;
use std::collections::BTreeMap;

use loftsman_kernel::plugin::{Fate, FormatError, Place, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::{Scene, Unit, Up};

use crate::OPTIONS;
use crate::text::{Statements, decode, keyword, show, words};
use elements::Reader;

/// What starts a new object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Split {
    Object,
    Group,
    Never,
}

/// What becomes of points whose normals or texture coordinates differ between the faces that meet there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Corners {
    Share,
    Split,
}

/// Statements that say how something is shown, not what it is.
const DISPLAY: &[&str] = &[
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "maplib",
    "usemap",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "mg",
];

/// Free-form statements that are counted and left out.
const FREEFORM: &[&str] = &[
    "vp", "surf", "curv2", "trim", "hole", "scrv", "sp", "con", "bmat", "step", "bsp", "bzp", "cdc", "cdp",
    "res",
];

/// Whether the first bytes of a file look like OBJ: its first statements are OBJ's, and one of them is geometry.
pub(crate) fn recognises(head: &[u8]) -> bool {
    let text = decode(head);
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
                let first = words(rest).next().and_then(|w| w.first());
                if !first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b)) {
                    return false;
                }
                geometry = true;
            }
            b"o" | b"g" | b"s" | b"mtllib" | b"usemtl" | b"cstype" | b"deg" | b"curv" | b"parm" | b"end"
            | b"p" => {}
            other if DISPLAY.iter().chain(FREEFORM).any(|known| known.as_bytes() == other) => {}
            _ => return false,
        }
    }
    geometry
}

/// Reads a file.
pub(crate) fn read(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    let file = source.name();
    let own = &options.own;
    let wrong =
        |e: loftsman_kernel::plugin::ParameterError| FormatError::new(file, Place::File, e.to_string());
    own.check(OPTIONS).map_err(wrong)?;
    let text = decode(source.bytes());
    let split = match own.text_or("split", "auto").map_err(wrong)? {
        "auto" if has_objects(&text) => Split::Object,
        "auto" => Split::Group,
        _ => own
            .choice("split", &[("object", Split::Object), ("group", Split::Group), ("none", Split::Never)])
            .map_err(wrong)?,
    };
    let corners = if own.has("corners") {
        own.choice("corners", &[("share", Corners::Share), ("split", Corners::Split)]).map_err(wrong)?
    } else {
        Corners::Share
    };
    let mut reader = Reader::new(split);
    let mut report = ReadReport::default();
    let mut unknown: BTreeMap<String, usize> = BTreeMap::new();
    let mut statements = Statements::new(&text);
    let total = text.len() as u64;
    let mut count = 0_usize;
    while let Some((line, statement)) = statements.next() {
        let at = |problem: String| FormatError::new(file, Place::Line(line), problem);
        count += 1;
        if count.is_multiple_of(1 << 16) {
            if options.observer.cancelled() {
                return Err(FormatError::new(file, Place::Line(line), "reading was cancelled"));
            }
            options.observer.progress("reading", total - statements.left() as u64, total);
        }
        let (word, rest) = keyword(&statement);
        match word {
            b"v" => reader.raw.vertex(rest),
            b"vt" => reader.raw.texture(rest),
            b"vn" => reader.raw.normal(rest),
            b"f" | b"fo" => reader.face(rest, line),
            b"l" => reader.line(rest, line),
            b"p" => reader.points(rest, line),
            b"o" => reader.object(rest),
            b"g" => reader.group(rest),
            b"usemtl" => reader.material(rest),
            b"mtllib" => reader.library(rest),
            b"s" => reader.left_out("smoothing groups are not kept"),
            b"cstype" => reader.freeform.cstype(rest),
            b"deg" => reader.freeform.deg(rest),
            b"curv" => reader.curv(rest, line),
            b"surf" | b"curv2" => reader.other_element(word, line),
            b"parm" => reader.freeform.parm(rest, line),
            b"end" => reader.end(line),
            _ => {
                let name = String::from_utf8_lossy(word);
                if FREEFORM.contains(&name.as_ref()) {
                    reader.left_out(&format!("the free-form statement {name} is not read yet"))
                } else if DISPLAY.contains(&name.as_ref()) {
                    reader.left_out("statements about display are not kept")
                } else if !word.iter().all(u8::is_ascii_graphic) || (reader.statements == 0 && count > 64) {
                    Err(format!("\"{}\" is no statement of an OBJ file", show(word)))
                } else {
                    // So that a hostile file cannot make the report as large as itself.
                    let name = if unknown.len() < 32 || unknown.contains_key(&show(word)) {
                        show(word)
                    } else {
                        "others".to_owned()
                    };
                    *unknown.entry(name).or_default() += 1;
                    continue;
                }
            }
        }
        .map_err(at)?;
        reader.statements += 1;
    }
    if reader.statements == 0 {
        return Err(FormatError::new(file, Place::File, "no statement of an OBJ file was found in it"));
    }
    for (name, count) in unknown {
        report.count_many(Fate::LeftOut, &format!("unknown statement \"{name}\""), count);
    }
    let mut scene = Scene::new();
    scene.up = options.up.unwrap_or(Up::Y);
    scene.unit = options.unit.unwrap_or_else(|| {
        report.notes.push("OBJ has no unit: metres are assumed".to_owned());
        Unit::default()
    });
    if options.up.is_none() {
        report.notes.push("y is taken as up, as OBJ programs have it".to_owned());
    }
    reader.finish(source, corners, &mut scene, &mut report)?;
    Ok((scene, report))
}

/// Whether any statement is an `o`.
fn has_objects(text: &[u8]) -> bool {
    text.split(|&b| b == b'\n' || b == b'\r').any(|line| {
        let line = line.trim_ascii_start();
        line.first() == Some(&b'o') && line.get(1).is_some_and(u8::is_ascii_whitespace)
    })
}

/// The name of a file without folder and extension.
fn stem(file: &str) -> Cow<'_, str> {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.into(),
        _ => name.into(),
    }
}
