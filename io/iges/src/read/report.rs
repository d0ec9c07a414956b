//! The account of every entity: what is in the scene, what is not, and why.

use std::collections::BTreeMap;

use loftsman_kernel::plugin::{Fate, FormatError, FormatErrorKind, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::clip;

use super::entity::Problem;
use super::tree::is_shown;
use crate::text::File;

/// So many entities at fault are named one by one.
const NAMED: usize = 20;
/// So many lines of the same kind are noted.
const NOTES: usize = 20;

/// What became of the entities of a file.
pub(crate) struct Account<'r, 'f> {
    file: &'r File<'f>,
    kept: Vec<bool>,
    aside: Vec<bool>,
    changed: BTreeMap<usize, String>,
    at_fault: BTreeMap<usize, String>,
    notes: Vec<String>,
    unsaid: usize,
}

/// How it ends what is said of an entity of which a part is at fault.
pub(crate) const LEFT_OUT: &str = " in it is left out";

impl<'r, 'f> Account<'r, 'f> {
    pub(crate) fn new(file: &'r File<'f>) -> Self {
        Self {
            file,
            kept: vec![false; file.len()],
            aside: vec![false; file.len()],
            changed: BTreeMap::new(),
            at_fault: BTreeMap::new(),
            notes: Vec::new(),
            unsaid: 0,
        }
    }

    /// Entities that are in the scene.
    pub(crate) fn keep(&mut self, places: &[usize]) {
        for &place in places {
            self.kept[place] = true;
        }
    }

    /// Parameter curves of edges, which are computed anew.
    pub(crate) fn set_aside(&mut self, places: &[usize]) {
        places.iter().for_each(|&place| self.aside[place] = true);
    }

    /// Entities that are in the scene as another thing.
    pub(crate) fn changed(&mut self, changes: Vec<Problem>) {
        for Problem { place, text } in changes {
            self.changed.entry(place).or_insert(text);
        }
    }

    /// Entities that are left out, and why; the first that is said of each.
    pub(crate) fn problems(&mut self, problems: Vec<Problem>) {
        for Problem { place, text } in problems {
            self.at_fault.entry(place).or_insert(text);
        }
    }

    pub(crate) fn note(&mut self, note: String) {
        if self.notes.len() < NOTES {
            self.notes.push(note);
        } else {
            self.unsaid += 1;
        }
    }

    /// An entity in words: `D17 (126), line 23: why`.
    fn told(&self, place: usize, text: &str) -> String {
        let (number, entry) = (self.file.number(place), self.file.entry(place));
        format!("D{number} ({}), line {}: {text}", entry.kind, entry.line)
    }

    /// The scene with the report.
    pub(crate) fn finish(self, scene: Scene) -> Result<(Scene, ReadReport), FormatError> {
        let mut report = ReadReport::default();
        let global = &self.file.global;
        let mut said = Vec::new();
        if let Some(version) = global.version.and_then(version) {
            said.push(format!("IGES {version}"));
        }
        for (what, text) in [("from", &global.system), ("written by", &global.writer)] {
            if !text.is_empty() {
                said.push(format!("{what} {}", clip(text)));
            }
        }
        if !said.is_empty() {
            report.notes.push(said.join(", "));
        }
        if let Some(scale) = global.scale {
            report.notes.push(format!(
                "the file says that its lengths are {scale} times the real ones: numbers are taken as they are"
            ));
        }
        report.notes.extend(self.file.notes.iter().cloned());
        let defined = scene.definitions().iter().flat_map(|d| d.objects());
        let empty = scene.objects().iter().chain(defined).all(|o| matches!(o.geometry(), Geometry::Group));
        // Groups of which nothing is left are nothing.
        if scene.objects().is_empty() || (empty && !self.at_fault.is_empty()) {
            // The cause, not that what holds it goes with it.
            let cause = self.at_fault.iter().find(|(_, text)| !text.ends_with(LEFT_OUT));
            let first = cause.or(self.at_fault.iter().next()).map(|(place, text)| self.told(*place, text));
            let cut = self.file.notes.first().map(|note| format!(" ({note})")).unwrap_or_default();
            let problem = match first {
                Some(first) => format!("nothing in it can be read: {first}{cut}"),
                None if self.file.len() == 0 => {
                    format!("there are no entities in it: its directory section is missing{cut}")
                }
                None => format!(
                    "there is no geometry in it that is read: {}; export curves, surfaces or solids{cut}",
                    self.told(0, &reason(self.file, 0))
                ),
            };
            return Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported));
        }
        report.notes.extend(self.notes.iter().cloned());
        if self.unsaid > 0 {
            report.notes.push(format!("{} more of these", self.unsaid));
        }
        let mut named = 0;
        for (place, &kept) in self.kept.iter().enumerate() {
            let mut tell = |fate: Fate, text: &str| {
                named += 1;
                if named <= NAMED {
                    report.count(fate, &self.told(place, text));
                } else {
                    report.count(fate, "further entities that are at fault, not read, or read as others");
                }
            };
            if let Some(text) = self.at_fault.get(&place) {
                tell(Fate::LeftOut, text);
            } else if let Some(text) = self.changed.get(&place).filter(|_| kept) {
                tell(Fate::Approximated, text);
            } else if kept {
                report.count(Fate::Kept, "");
            } else if self.aside[place] {
                report.count(Fate::LeftOut, "parameter curves of edges are computed anew");
            } else {
                report.count(Fate::LeftOut, &reason(self.file, place));
            }
        }
        Ok((scene, report))
    }
}

/// The version of a flag.
fn version(flag: f64) -> Option<&'static str> {
    let names = [
        "1.0",
        "ANSI Y14.26M-1981",
        "2.0",
        "3.0",
        "ASME Y14.26M-1987",
        "4.0",
        "ASME Y14.26M-1989",
        "5.0",
        "5.1",
        "5.2",
        "5.3",
    ];
    if flag.fract() != 0.0 || !(1.0..=11.0).contains(&flag) {
        return None;
    }
    names.get(flag as usize - 1).copied()
}

/// Why an entity is not in the scene, where nothing is wrong with it.
fn reason(file: &File<'_>, place: usize) -> String {
    let entry = file.entry(place);
    let (kind, form) = (entry.kind, entry.form);
    let why = match kind {
        0 => "null entities",
        106 if !is_shown(kind, form) => "drawing and annotation",
        125 | 202..=230 | 312 | 404 | 410 => "drawing and annotation",
        _ if entry.purpose == 1 => "drawing and annotation",
        132..=138 | 146 | 148 | 320 | 322 | 418 | 420 | 422 => "finite elements, networks and attributes",
        150..=182 => {
            "solids of primitives and of Boolean operations, which are not read: export them as B-reps (186)"
        }
        302 | 304 | 306 | 310 | 316 | 402 | 406 => "definitions, properties and associations",
        412 | 414 => "arrays of subfigures, which are not read: export them one by one",
        416 => "references to other files, which are not followed: put all into one file",
        124 | 314 => "matrices and colours that nothing uses",
        _ if is_shown(kind, form) || matches!(kind, 123 | 141 | 190..=198 | 308 | 502..=508) => {
            "parts of what is left out, curves in parameters, definitions that nothing shows"
        }
        _ => return format!("type {kind}, which is not read"),
    };
    why.to_owned()
}
