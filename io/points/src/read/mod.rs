//! Reading: what the rows of a file mean.

mod airfoil;
mod columns;
mod line;
mod number;
mod scan;
mod tecplot;

use crate::marks::Kind;
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{
    Confidence, Fate, FormatError, FormatErrorKind, Place, Quiet, ReadOptions, ReadReport, Source,
    refuse_utf16,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::text::{decoded, unmarked};

use line::Separator;
use scan::{Block, Scan};

/// How sure it is that the first bytes of a file are those of a point file.
pub(crate) fn confidence(head: &[u8]) -> Confidence {
    let long = head.len() >= 4096;
    let head = unmarked(head).trim_ascii_start();
    // Of a longer file the last line may be cut off.
    let end = head.iter().rposition(|&b| b == b'\n').filter(|_| long);
    let whole = end.map_or(head, |end| &head[..end]);
    match Scan::new(whole, &Quiet) {
        Ok(scan) if scan.own => Confidence::Sure,
        Ok(scan) if scan.rows() >= 2 && is_plain(head, &scan) => Confidence::Maybe,
        _ => Confidence::No,
    }
}

/// Whether what stands above rows could be a name, or names of columns: not markup, nor words over more than two coordinates
/// that are not their names.
fn is_plain(head: &[u8], scan: &Scan) -> bool {
    let is_outline = scan.columns.as_ref().is_some_and(|columns| columns.count == 2);
    !head.starts_with(b"<") && !head.contains(&0) && scan.words.len() <= if is_outline { 3 } else { 0 }
}

/// The scene of a point file.
pub(crate) fn file(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    let kinds = [("polyline", Some(Kind::Polyline { closed: None })), ("cloud", Some(Kind::Cloud))];
    let asked = options.own.choice_or("as", &kinds, None)?;
    let (text, encoding) = decoded(check_text(source.bytes())?);
    let mut scan = Scan::new(&text, options.observer)?;
    options.limits.check_entities(scan.rows())?;
    let mut reading = Reading::default();
    if let Some(encoding) = encoding {
        reading.note(format!("the text is not UTF-8: it was read as {encoding}"));
    }
    reading.preface(&mut scan, source.name())?;
    let blocks = std::mem::take(&mut scan.blocks);
    // Headers without rows (a zone of remarks) are no objects, unless the file is our own.
    let several = blocks.iter().filter(|b| !b.points.is_empty()).count() > 1;
    if scan.headed {
        reading.note("text between rows is the name of what follows");
    }
    for line in &scan.footnotes {
        reading.report.count(Fate::LeftOut, &format!("line {line}: text below the rows"));
    }
    for (place, mut block) in blocks.into_iter().enumerate() {
        if place == 0 && scan.headed {
            block.name = block.name.or_else(|| reading.name.clone());
        }
        if block.points.is_empty() && !scan.own {
            continue;
        }
        let object = reading.object(block, &scan, several, source.name(), asked)?;
        reading.scene.add(object)?;
    }
    let Reading { mut scene, mut report, .. } = reading;
    report.unit = scan.unit;
    scene.up = scan.up.unwrap_or(scene.up);
    Ok((scene, report))
}

/// The bytes without their byte order mark, if they can be text at all.
fn check_text(bytes: &[u8]) -> Result<&[u8], FormatError> {
    let refuse = |byte, problem: &str| {
        Err(FormatError::new(Place::Byte(byte), problem).as_kind(FormatErrorKind::Unsupported))
    };
    refuse_utf16(bytes, 0)?;
    let bytes = unmarked(bytes);
    if bytes.trim_ascii().is_empty() {
        return Err(FormatError::whole(
            "the file is empty: a point file has the coordinates of a point a line",
        ));
    }
    // Digits and blanks in two bytes each: every other one is zero from the start on.
    let every_other =
        |from: usize| bytes.len() > 3 && bytes.iter().skip(from).step_by(2).take(4).all(|&b| b == 0);
    match bytes.iter().take(4096).position(|&b| b == 0) {
        Some(byte) if byte < 2 && every_other(byte) => refuse(
            byte,
            "every other byte is zero: this is UTF-16 text or a binary file; save it as UTF-8 or ASCII",
        ),
        Some(byte) => refuse(byte, "there is a zero byte: this is a binary file, not rows of coordinates"),
        None => Ok(bytes),
    }
}

/// The scene and the report that are being made.
#[derive(Default)]
struct Reading {
    scene: Scene,
    report: ReadReport,
    /// The name that a line of its own gives.
    name: Option<String>,
    /// Whether the first row is AeroDyn's reference point.
    aerodyn: bool,
}

impl Reading {
    /// Once for all outlines of a file.
    fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.report.notes.contains(&note) {
            self.report.notes.push(note);
        }
    }

    /// Everything before and beside the rows: name, counts, columns.
    fn preface(&mut self, scan: &mut Scan, file: &str) -> Result<(), FormatError> {
        let rows = scan.rows();
        if scan.tecplot {
            self.note("Tecplot headers: a polyline a zone");
        }
        if scan.own {
            self.note("comments that say what each object is");
        }
        if let Some(at) = scan.words.iter().position(|(_, words)| words.contains("NumCoords")) {
            let (line, words) = scan.words.remove(at);
            self.aerodyn = true;
            self.note("AeroDyn/OpenFAST airfoil coordinates");
            check_count(words.split_whitespace().next(), rows, line)?;
        }
        if let Some((single, spelling)) = scan.single.take() {
            // `2412` may be a name, but in files that do not come from airfoil collections it is a count.
            let designation =
                (4..=6).contains(&spelling.len()) && spelling.bytes().all(|b| b.is_ascii_digit());
            if single.value == rows as f64 {
                self.note(format!("line {} counts the rows: {spelling}", single.line));
            } else if designation && scan.words.is_empty() && has_extension(file, &["dat", "txt"]) {
                self.note(format!("line {} is taken as the name: {spelling}", single.line));
                self.name = Some(spelling);
            } else {
                check_count(Some(&spelling), rows, single.line)?;
            }
        }
        let mut words = std::mem::take(&mut scan.words).into_iter();
        if self.name.is_none() {
            self.name = words.next().map(|(_, name)| without_padding(&name).to_owned());
        }
        let rest = words.count();
        self.report.count_many(Fate::LeftOut, "further lines of text before the rows", rest);
        let Some(columns) = &scan.columns else { return Ok(()) };
        let kind = match columns.separator() {
            Separator::Blanks => "blanks",
            Separator::Comma => "commas",
            Separator::Semicolon => "semicolons",
        };
        let (count, dimension) = (columns.count, columns.dimension());
        self.note(format!("{count} columns separated by {kind}, {dimension} of them coordinates"));
        if let Some(names) = columns.names.as_ref().filter(|_| !columns.named) {
            let names: Vec<String> = names.iter().take(dimension).map(|n| line::clip(n.as_bytes())).collect();
            self.note(format!(
                "the header names no x and y: {} are taken for the coordinates",
                names.join(", ")
            ));
        }
        for other in columns.others() {
            self.report.count(Fate::LeftOut, &format!("column {other} is not a coordinate"));
        }
        if dimension == 2 {
            self.note("two coordinates: z is 0");
        }
        if scan.signs.commas {
            self.note("commas are decimal signs");
        } else if columns.separator() == Separator::Comma && !scan.signs.points && matches!(count, 4 | 6) {
            self.note(
                "no number has a decimal point: if commas are decimal signs here, separate columns by ;",
            );
        }
        Ok(())
    }

    /// The object of a block.
    fn object(
        &mut self,
        mut block: Block,
        scan: &Scan,
        several: bool,
        file: &str,
        asked: Option<Kind>,
    ) -> Result<Object, FormatError> {
        if self.aerodyn && !block.points.is_empty() {
            self.aerodyn = false;
            let reference = block.points.remove(0);
            self.report.count(Fate::LeftOut, "the airfoil reference point is not part of the outline");
            self.note(format!("the reference point is ({}, {})", reference.x, reference.y));
            block.kind = Some(Kind::Polyline { closed: None });
        } else if (!several || scan.headed)
            && block.kind.is_none()
            && scan.columns.as_ref().is_some_and(|c| c.count == 2)
        {
            self.airfoil(&mut block)?;
        }
        if scan.tecplot && !block.gaps.is_empty() || block.kind.is_none() && !block.gaps.is_empty() {
            self.note("blank lines between rows do not separate objects: all rows are one");
        }
        let said = block.name.take().or_else(|| if several { None } else { self.name.clone() });
        let name = self.scene.unique_name(said.as_deref().unwrap_or(stem(file)));
        let geometry = self.geometry(block, file, asked);
        Ok(Object::new(name, geometry).labelled(&said.unwrap_or_default()))
    }

    /// Lednicer's two surfaces become one outline; Selig's order is noted.
    fn airfoil(&mut self, block: &mut Block) -> Result<(), FormatError> {
        let counted = airfoil::lednicer_counts(block);
        let found = counted.or_else(|| airfoil::lednicer_blocks(block));
        if let Some((upper, lower)) = found {
            if let (None, Some(first)) = (counted, block.points.first()) {
                self.note(format!(
                    "line {} counts {} and {} rows, but {upper} and {lower} follow: these are taken",
                    block.line, first.x, first.y
                ));
            }
            let outline = airfoil::lednicer_outline(&block.points[1..], upper);
            self.note(format!(
                "Lednicer airfoil: {upper} and {lower} rows from the leading edge became one outline, from the \
                 trailing edge over the upper side and the nose to the lower trailing edge"
            ));
            outline.notes.iter().for_each(|&note| self.note(note));
            self.report.count(Fate::LeftOut, "the row that counts the others is no point");
            let shared = usize::from(outline.shared_nose);
            self.report.count_many(
                Fate::LeftOut,
                "the nose is in both surfaces, and once in the outline",
                shared,
            );
            block.points = outline.points;
            block.gaps.clear();
            block.kind = Some(Kind::Polyline { closed: None });
        } else if let Some((upper, lower, rows)) = airfoil::wrong_counts(block) {
            let blocks = block.gaps.len();
            let several = if blocks > 2 { format!(" in {blocks} blocks") } else { String::new() };
            let problem = format!(
                "the first row counts {upper} and {lower} rows, but {rows} follow{several}: the file is cut off, or the counts are wrong"
            );
            return Err(FormatError::new(Place::Line(block.line), problem));
        } else if airfoil::is_selig(&block.points) {
            self.note("Selig airfoil: from the trailing edge around the nose and back");
            block.kind = Some(Kind::Polyline { closed: None });
        } else if let Some((x, y)) = airfoil::stray(block) {
            let rows = block.points.len() - 1;
            self.note(format!(
                "line {} is taken as the point ({x}, {y}), far from all others: if it counts rows, it is not the {rows} that follow",
                block.line
            ));
        }
        Ok(())
    }

    /// Chain or cloud; what closes a chain is left out.
    fn geometry(&mut self, block: Block, file: &str, asked: Option<Kind>) -> Geometry {
        let loose = has_extension(file, &["xyz", "asc", "pts"]) && self.name.is_none();
        let usual = if loose { Kind::Cloud } else { Kind::Polyline { closed: None } };
        let kind = asked.or(block.kind).unwrap_or(usual);
        if asked.is_none() && block.kind.is_none() {
            let (kind, other) = if loose { ("cloud", "polyline") } else { ("polyline", "cloud") };
            self.note(format!(
                "the rows are taken as a {kind}; the option as = \"{other}\" takes them otherwise"
            ));
        }
        let mut points = block.points;
        let Kind::Polyline { closed } = kind else {
            self.report.count_many(Fate::Kept, "", points.len());
            return Cloud { points }.into();
        };
        let ends_meet = points.len() > 1 && points.first() == points.last();
        // Two points there and back are no closed chain, unless the file says so.
        let closed = closed.unwrap_or(ends_meet && points.len() > 3);
        if closed && ends_meet {
            points.pop();
            self.report
                .count(Fate::LeftOut, "the last row repeats the first: the polyline is closed instead");
        }
        self.report.count_many(Fate::Kept, "", points.len());
        Polyline { points, closed }.into()
    }
}

/// A line that counts the rows must count right.
fn check_count(spelling: Option<&str>, rows: usize, line: usize) -> Result<(), FormatError> {
    let spelling = spelling.unwrap_or_default();
    if spelling.parse::<f64>().is_ok_and(|count| count == rows as f64) {
        return Ok(());
    }
    let count = line::clip(spelling.as_bytes());
    let problem = format!(
        "the line counts {count} rows, but there are {rows}: the file is cut off, or the count is wrong"
    );
    Err(FormatError::new(Place::Line(line), problem))
}

/// A name without the separators that pad the rows of tables.
fn without_padding(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_whitespace() || matches!(c, ',' | ';')).trim_start()
}

/// The file's name without folder and extension; never empty.
fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    if stem.is_empty() || stem == "-" { "points" } else { stem }
}

fn has_extension(file: &str, extensions: &[&str]) -> bool {
    let lower = file.to_ascii_lowercase();
    extensions.iter().any(|e| lower.strip_suffix(e).is_some_and(|rest| rest.ends_with('.')))
}
