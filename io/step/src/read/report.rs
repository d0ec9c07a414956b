//! The account of every entity: what is in the scene, what is not, and why.

mod nothing;

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
/// Why tessellations are left out.
const TESSELLATIONS: &str = "tessellations of what is read exactly";
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
    /// It is part of the tessellation of something exact.
    Tessellation,
}

/// What became of the entities of a file.
pub(crate) struct Account<'r, 'f> {
    file: &'r File<'f>,
    state: Vec<State>,
    at_fault: BTreeMap<u64, String>,
    notes: Vec<String>,
    unsaid: usize,
    parameter_curves: Vec<usize>,
    tessellations: Vec<usize>,
    partial: BTreeSet<u64>,
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
            tessellations: Vec::new(),
            partial: BTreeSet::new(),
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

    /// Solids and shells that are in the scene, but for parts of theirs that are not.
    pub(crate) fn keep_partial(&mut self, numbers: &[u64]) {
        self.keep_alone(numbers);
        self.partial.extend(numbers);
    }

    /// Whether an entity is in the scene, with all of its parts.
    pub(crate) fn is_whole(&self, number: u64) -> bool {
        let is_kept = self.file.place(number).is_some_and(|place| self.state[place] == State::Kept);
        is_kept && !self.partial.contains(&number)
    }

    /// A tessellation that is not in the scene, because what it stands for is.
    pub(crate) fn tessellates(&mut self, number: u64, text: &str) {
        self.tessellations.extend(self.file.place(number));
        self.note(self.told(number, text));
    }

    /// What nothing names but parameter curves, and what nothing does but tessellations that are left out.
    fn set_aside(&mut self) {
        let file = self.file;
        let parameters = std::mem::take(&mut self.parameter_curves);
        let tessellations = std::mem::take(&mut self.tessellations);
        for (mut waiting, state) in [(parameters, State::Parameters), (tessellations, State::Tessellation)] {
            while let Some(place) = waiting.pop() {
                if self.state[place] == State::Unread {
                    self.state[place] = state;
                    file.references(place, |number| waiting.extend(file.place(number)));
                }
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
    pub(crate) fn told(&self, number: u64, text: &str) -> String {
        format!("{}: {text}", self.named(number))
    }

    /// The first entity that names each of some numbers: one pass over the file.
    fn who_names(&self, numbers: &[u64]) -> Vec<(u64, Option<usize>)> {
        let mut found: BTreeMap<u64, Option<usize>> = numbers.iter().map(|number| (*number, None)).collect();
        if !found.is_empty() {
            for place in 0..self.file.len() {
                self.file.references(place, |number| {
                    if let Some(by) = found.get_mut(&number) {
                        by.get_or_insert(place);
                    }
                });
            }
        }
        found.into_iter().collect()
    }

    /// What is said of a number that no entity has.
    fn told_missing(&self, number: u64, by: Option<usize>) -> String {
        match by {
            Some(place) => {
                let what = format!(
                    "#{number} is named, but is not in the file: get the file again, or take the name out"
                );
                self.told(self.file.number(place), &what)
            }
            None => format!("#{number} is named, but is not in the file"),
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
        report.notes.extend(unknown_schema(&header.schemas));
        if scene.objects().is_empty() {
            return Err(FormatError::whole(self.nothing()).as_kind(FormatErrorKind::Unsupported));
        }
        let missing: Vec<u64> =
            self.at_fault.keys().copied().filter(|number| self.file.place(*number).is_none()).collect();
        let named = self.who_names(&missing[..missing.len().min(NOTES)]);
        report.notes.extend(named.iter().map(|(number, place)| self.told_missing(*number, *place)));
        if missing.len() > NOTES {
            report.notes.push(format!("{} more are named and not in the file", missing.len() - NOTES));
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
                    _ if state == State::Tessellation => TESSELLATIONS.to_owned(),
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
        for doubled in self.file.doubled.iter().take(NAMED) {
            let (kind, line, first) = self.file.doubled_lines(doubled);
            let (number, kind) = (doubled.number, clip(&String::from_utf8_lossy(kind)));
            report.count(
                Fate::LeftOut,
                &format!("#{number} ({kind}), line {line}: its number is that of the entity in line {first}, which is kept: give one of them another number"),
            );
        }
        let more = self.file.doubled.len().saturating_sub(NAMED);
        report.count_many(Fate::LeftOut, "further entities whose numbers are those of entities before", more);
        Ok((scene, report))
    }
}

/// What schemas of STEP files that hold shapes are called, up to what follows their names: AP203, AP214, AP242, and those that are read as them.
const SCHEMAS: [&str; 16] = [
    "CONFIG_CONTROL_DESIGN",
    "CONFIG_CONTROLLED_3D_DESIGN",
    "AUTOMOTIVE_DESIGN",
    "CORE_AUTOMOTIVE_DESIGN",
    "ASSOCIATIVE_DRAUGHTING",
    "EXPLICIT_DRAUGHTING",
    "GEOMETRIC_VALIDATION_PROPERTIES",
    "SHAPE_APPEARANCE_LAYER",
    "STRUCTURAL_ANALYSIS",
    "INTEGRATED_CNC",
    "AP203",
    "AP209",
    "AP210",
    "AP214",
    "AP238",
    "AP242",
];

/// What is said of a file none of whose schemas is known.
fn unknown_schema(schemas: &[String]) -> Option<String> {
    let is_known = |schema: &String| {
        let schema = schema.to_ascii_uppercase();
        SCHEMAS.iter().any(|known| schema.starts_with(known))
    };
    if schemas.iter().all(|schema| schema.is_empty()) {
        return Some("the header names no schema: what is in it is read as AP242".to_owned());
    }
    (!schemas.iter().any(is_known)).then(|| {
        format!(
            "the schema {} is none that is known: what is in it is read as AP242, where it is called as there; export it as AP203, AP214 or AP242",
            clip(&schemas.join(", "))
        )
    })
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
