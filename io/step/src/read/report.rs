//! The account of every entity: what is in the scene, what is not, and why.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::plugin::{Fate, FormatError, FormatErrorKind, ReadReport};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::text::clip;

use super::entity::Problem;
use crate::part21::{File, Kind};

/// So many entities at fault are named one by one.
const NAMED: usize = 20;
/// So many types that are not read are told apart.
const KINDS: usize = 100;
/// Why parameter curves are left out.
const PARAMETERS: &str = "parameter curves are computed anew";
/// So many lines of the same kind are noted.
const NOTES: usize = 20;

/// What became of an entity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nobody asked for it.
    Unread,
    /// It is in the scene.
    Kept,
    /// It is part of a parameter curve.
    Parameters,
}

/// What became of the entities of a file.
pub(crate) struct Account<'r, 'f> {
    file: &'r File<'f>,
    state: Vec<State>,
    at_fault: BTreeMap<u64, String>,
    notes: Vec<String>,
    unsaid: usize,
    parameter_curves: Vec<usize>,
}

impl<'r, 'f> Account<'r, 'f> {
    pub(crate) fn new(file: &'r File<'f>) -> Self {
        let state = vec![State::Unread; file.len()];
        Self {
            file,
            state,
            at_fault: BTreeMap::new(),
            notes: Vec::new(),
            unsaid: 0,
            parameter_curves: Vec::new(),
        }
    }

    /// Entities that are in the scene, themselves.
    pub(crate) fn keep_alone(&mut self, numbers: &[u64]) {
        for place in numbers.iter().filter_map(|&number| self.file.place(number)) {
            self.state[place] = State::Kept;
        }
    }

    /// Parameter curves that are in the scene, with what they name.
    pub(crate) fn keep_parameters(&mut self, numbers: &[u64]) {
        for &number in numbers {
            let Some(place) = self.file.place(number) else { continue };
            self.state[place] = State::Kept;
            let mut named = Vec::new();
            self.file.references(place, |number| named.push(number));
            self.keep_whole(&named);
        }
    }

    /// Entities that are in the scene with all that they name. Parameter curves that are not taken are computed anew: what they name stays out.
    pub(crate) fn keep_whole(&mut self, numbers: &[u64]) {
        let file = self.file;
        let mut waiting: Vec<usize> = numbers.iter().filter_map(|&number| file.place(number)).collect();
        while let Some(place) = waiting.pop() {
            if self.state[place] == State::Kept {
                continue;
            }
            if file.kind(place) == Kind::One(b"PCURVE") {
                self.parameter_curves.push(place);
                continue;
            }
            self.state[place] = State::Kept;
            file.references(place, |number| waiting.extend(file.place(number)));
        }
    }

    /// What nothing names but parameter curves.
    fn set_aside(&mut self) {
        let file = self.file;
        let mut waiting = std::mem::take(&mut self.parameter_curves);
        while let Some(place) = waiting.pop() {
            if self.state[place] == State::Unread {
                self.state[place] = State::Parameters;
                file.references(place, |number| waiting.extend(file.place(number)));
            }
        }
    }

    /// Entities that are left out, and why; the first that is said of each.
    pub(crate) fn problems(&mut self, problems: Vec<Problem>) {
        for Problem { number, text } in problems {
            self.at_fault.entry(number).or_insert(text);
        }
    }

    pub(crate) fn note(&mut self, note: String) {
        if self.notes.len() < NOTES {
            self.notes.push(note);
        } else {
            self.unsaid += 1;
        }
    }

    /// An entity in words: `#345 (CARTESIAN_POINT), line 812: why`.
    fn told(&self, number: u64, text: &str) -> String {
        match self.file.place(number) {
            Some(place) => {
                let kind = match self.file.kind(place) {
                    Kind::One(name) => clip(&String::from_utf8_lossy(name)),
                    Kind::Several => "of several types".to_owned(),
                };
                format!("#{number} ({kind}), line {}: {text}", self.file.line_of(place))
            }
            None => format!("#{number}: {text}"),
        }
    }

    /// The scene with the report.
    pub(crate) fn finish(mut self, scene: Scene) -> Result<(Scene, ReadReport), FormatError> {
        self.set_aside();
        let mut report = ReadReport::default();
        let header = &self.file.header;
        let mut said = Vec::new();
        if !header.schemas.is_empty() {
            said.push(format!("schema {}", clip(&header.schemas.join(", "))));
        }
        for (what, text) in [("from", &header.system), ("written by", &header.writer)] {
            if !text.is_empty() {
                said.push(format!("{what} {}", clip(text)));
            }
        }
        if !said.is_empty() {
            report.notes.push(said.join(", "));
        }
        if scene.objects().is_empty() {
            let first = self.at_fault.iter().next().map(|(number, text)| self.told(*number, text));
            let problem = match first {
                Some(first) => format!("nothing in it can be read: {first}"),
                None => {
                    "there is no geometry in it that is read: no solid, surface, curve or mesh of a product"
                        .to_owned()
                }
            };
            return Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported));
        }
        let missing = self.at_fault.iter().filter(|(number, _)| self.file.place(**number).is_none());
        for (count, (number, text)) in missing.enumerate() {
            if count < NOTES {
                report.notes.push(self.told(*number, text));
            }
        }
        report.notes.extend(self.notes.iter().cloned());
        if self.unsaid > 0 {
            report.notes.push(format!("{} more of these", self.unsaid));
        }
        let (mut named, mut kinds) = (0, BTreeSet::new());
        for (place, &state) in self.state.iter().enumerate() {
            let number = self.file.number(place);
            if let Some(text) = self.at_fault.get(&number) {
                named += 1;
                if named <= NAMED {
                    report.count(Fate::LeftOut, &self.told(number, text));
                } else {
                    report.count(Fate::LeftOut, "further entities that are at fault or not read");
                }
            } else if state == State::Kept {
                report.count(Fate::Kept, "");
            } else {
                let reason = match self.file.kind(place) {
                    _ if state == State::Parameters => PARAMETERS.to_owned(),
                    Kind::One(name) => reason(&String::from_utf8_lossy(name)),
                    Kind::Several => "of several types at once: no geometry of a product".to_owned(),
                };
                if kinds.contains(&reason) || kinds.len() < KINDS {
                    report.count(Fate::LeftOut, &reason);
                    kinds.insert(reason);
                } else {
                    report.count(Fate::LeftOut, "other types");
                }
            }
        }
        report.count_many(Fate::LeftOut, "its number is that of an entity before", self.file.doubled);
        Ok((scene, report))
    }
}

/// Why an entity of a type is not in the scene, where nothing is wrong with it.
fn reason(kind: &str) -> String {
    let is = |words: &[&str]| words.iter().any(|word| kind.contains(word));
    let why = if is(&["PCURVE", "DEFINITIONAL_REPRESENTATION"]) {
        PARAMETERS
    } else if is(&[
        "PERSON",
        "ORGANIZATION",
        "APPROVAL",
        "DATE",
        "TIME",
        "SECURITY",
        "CERTIFICATION",
        "CONTRACT",
    ]) {
        "who made it, when, and who approved it"
    } else if is(&["PRODUCT", "APPLICATION", "DOCUMENT", "IDENTIFICATION"]) {
        "what the product is apart from its shape"
    } else if is(&[
        "STYLE",
        "COLOUR",
        "PRESENTATION",
        "DRAUGHTING",
        "ANNOTATION",
        "TEXT",
        "SYMBOL",
        "CALLOUT",
    ]) {
        "drawing and annotation"
    } else if is(&[
        "PROPERTY",
        "MEASURE",
        "UNIT",
        "DIMENSION",
        "TOLERANCE",
        "SHAPE_ASPECT",
        "DATUM",
        "EXPONENTS",
    ]) {
        "dimensions, tolerances and properties"
    } else {
        return format!("{} that no geometry of a product names, or that is not read", clip(kind));
    };
    why.to_owned()
}
