//! What the legend and the notes of a page say.

use std::collections::{HashMap, HashSet};

use loftsman_kernel::text::counted;

use super::Stroke;
use crate::text;
use crate::theme::Color;

/// What an entry of the legend shows beside its words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample {
    /// A line.
    Line(Stroke),
    /// A line of two strokes in turn.
    Alternate(Stroke, Stroke),
    /// A line with squares at its ends.
    Net(Stroke),
    /// A thin arrow from vertex to vertex.
    Movement,
    /// A few teeth of a comb.
    Comb(Color),
    /// A bead.
    Bead(Color),
    /// A dot of a cloud.
    Dot(Color),
    /// One of a few loose points.
    Spot(Color),
    /// A piece of a face.
    Face(Fill),
    /// A piece of a face, and a line that runs on from it: a mesh with loose lines.
    Lined(Fill, Stroke),
    /// The number of a label that has no room in the drawing.
    Number(usize),
    /// A mark's glyph.
    Mark(loftsman_kernel::plugin::MarkKind),
}

/// What faces are filled with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fill {
    /// A colour.
    Plain(Color),
    /// Zebra stripes.
    Stripes,
    /// The colours of a scale.
    Map,
}

/// What the reader of a page is caption under it; the sheets of all panels add to it.
#[derive(Debug, Default)]
pub(crate) struct Caption {
    /// Sample and words of each entry of the legend, in the order in which they came up.
    pub(crate) legend: Vec<(Sample, String)>,
    /// What colours of faces mean.
    pub(crate) scales: Vec<Scale>,
    /// What was left out.
    pub(crate) notes: Vec<String>,
    /// The same, to be found.
    noted: HashSet<String>,
    names: Vec<Names>,
    /// What has a name in the legend.
    entered: HashSet<String>,
    /// The words of labels that have a number in the drawings, and are in the legend: in the order of their numbers, from 1 on.
    pub(crate) apart: Vec<String>,
    /// The objects that have none, since there are too many, with what they are.
    unnamed: HashMap<String, &'static str>,
    /// What is thinned out, of which object and in which drawing.
    thinned: Vec<Thinned>,
}

/// What of an object is left out of a drawing.
#[derive(Debug, PartialEq)]
struct Thinned {
    why: Why,
    object: String,
    /// How many, in words: `18 of 25`, or `3`.
    count: String,
    /// The drawing, where there are several.
    drawing: Option<String>,
}

/// Why something is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Why {
    /// Things of this name that cover one another.
    Close(&'static str),
    /// Parameters for whose numbers there is no room.
    Unlabelled,
    /// Parameters of places that are out of sight.
    Behind,
}

impl Why {
    /// What is said where there is one object, and where there are several.
    fn words(self, only: Option<&str>, list: &str) -> String {
        match (self, only) {
            (Self::Close(things), Some(name)) => {
                format!("{name}: {list} {things} are drawn, the others are too close to be told apart")
            }
            (Self::Close(things), None) => {
                format!("{things} too close to be told apart are left out: drawn are {list}")
            }
            (Self::Unlabelled, _) => {
                format!("labels for which there is no room: {list}")
            }
            (Self::Behind, _) => format!("labels out of sight: {list}"),
        }
    }
}

/// A note names so many parts at most.
const LISTED: usize = 12;

/// What colours of faces mean.
#[derive(Debug)]
pub(crate) struct Scale {
    pub(crate) words: String,
    /// The value at the end of the map.
    pub(crate) end: f64,
    /// The least and the largest value there is.
    pub(crate) range: (f64, f64),
}

impl Scale {
    /// Whether there are values beyond its ends at all.
    pub(crate) fn is_exceeded(&self) -> bool {
        self.range.0.abs().max(self.range.1.abs()) > self.end * (1.0 + 1e-6)
    }

    /// Its title; where values are well beyond an end, which has two figures, with the value furthest beyond it.
    pub(crate) fn title(&self) -> String {
        const WELL: f64 = 1.05;
        let (least, most) = self.range;
        let mut title = self.words.clone();
        if least < -WELL * self.end {
            title += &format!(", the least {}", text::number(least));
        }
        if most > WELL * self.end {
            title += &format!(", the largest {}", text::number(most));
        }
        title
    }
}

/// Objects that share an entry of the legend.
#[derive(Debug)]
struct Names {
    sample: Sample,
    old: bool,
    /// What they are called, and in how many places each is.
    called: Vec<(String, usize)>,
    entry: usize,
}

impl Names {
    fn words(&self) -> String {
        let one = |(name, count): &(String, usize)| match count {
            1 => name.clone(),
            count => format!("{} in {count} places", last(name)),
        };
        let all: Vec<String> = self.called.iter().map(one).collect();
        format!("{}{}", all.join(", "), if self.old { ", before" } else { "" })
    }
}

/// What an object of a definition is called where it is one of many: `nut` of `nut_2/nut`.
fn last(name: &str) -> &str {
    name.rsplit('/').next().filter(|last| !last.is_empty()).unwrap_or(name)
}

/// A line of the legend names so many letters at most, and so many objects.
const LETTERS: usize = 60;
const SHARED: usize = 4;

impl Caption {
    /// Adds an entry to the legend unless it is there.
    pub(crate) fn explain(&mut self, sample: Sample, words: impl Into<String>) {
        let words = words.into();
        if !self.legend.iter().any(|(s, w)| *s == sample && *w == words) {
            self.legend.push((sample, words));
        }
    }

    /// Explains the colours of faces, once.
    pub(crate) fn scale(&mut self, words: String, end: f64, range: (f64, f64)) {
        match self.scales.iter_mut().find(|scale| scale.words == words) {
            Some(Scale { range: known, .. }) => *known = (known.0.min(range.0), known.1.max(range.1)),
            None => self.scales.push(Scale { words, end, range }),
        }
    }

    /// Enters an object, or its state before. Objects of the same sample share an entry.
    pub(crate) fn name(&mut self, sample: Sample, name: &str, old: bool) {
        let suffix = if old { ", before" } else { "" };
        let words = format!("{name}{suffix}");
        if !self.entered.insert(words.clone()) {
            return;
        }
        if self.again(sample, name, old) {
            return;
        }
        let room = |names: &Names| {
            let long = names.words().chars().count() + name.chars().count();
            names.called.len() < SHARED && long < LETTERS
        };
        let shared = self.names.iter_mut().find(|n| n.sample == sample && n.old == old && room(n));
        if let Some(names) = shared {
            names.called.push((name.to_owned(), 1));
            let words = names.words();
            if let Some(entry) = self.legend.get_mut(names.entry) {
                entry.1 = words;
            }
            return;
        }
        self.names.push(Names { sample, old, called: vec![(name.to_owned(), 1)], entry: self.legend.len() });
        self.legend.push((sample, words));
    }

    /// Counts an object that is another instance of one that has a name in the legend; `false` where it is none.
    fn again(&mut self, sample: Sample, name: &str, old: bool) -> bool {
        if !name.contains('/') {
            return false;
        }
        for names in self.names.iter_mut().filter(|n| n.sample == sample && n.old == old) {
            let same = |(known, _): &&mut (String, usize)| known.contains('/') && last(known) == last(name);
            if let Some((_, count)) = names.called.iter_mut().find(same) {
                *count += 1;
                let words = names.words();
                if let Some(entry) = self.legend.get_mut(names.entry) {
                    entry.1 = words;
                }
                return true;
            }
        }
        false
    }

    /// Leaves an object out of the legend, which counts it, unless it is an instance of one that is there.
    pub(crate) fn leave_unnamed(&mut self, sample: Sample, name: &str, kind: &'static str) {
        if self.entered.contains(name) || self.unnamed.contains_key(name) {
            return;
        }
        if self.again(sample, name, false) {
            self.entered.insert(name.to_owned());
        } else {
            self.unnamed.insert(name.to_owned(), kind);
        }
    }

    /// What is said of the objects that the legend does not name.
    pub(crate) fn others(&self) -> Option<String> {
        let mut kinds = self.unnamed.values();
        let first = *kinds.next()?;
        let kind = if kinds.all(|kind| *kind == first) { first } else { "object[|s]" };
        Some(format!("and {}", counted(self.unnamed.len(), &format!("more {kind}"))))
    }

    /// Adds an entry to the legend unless there is one of the same words, whatever its sample.
    pub(crate) fn explain_once(&mut self, sample: Sample, words: impl Into<String>) {
        let words = words.into();
        if !self.legend.iter().any(|(_, w)| *w == words) {
            self.legend.push((sample, words));
        }
    }

    /// Adds a note unless it is there.
    pub(crate) fn note(&mut self, words: String) {
        // By their hash: in a scene of many objects each may have something to be said.
        if self.noted.insert(words.clone()) {
            self.notes.push(words);
        }
    }

    /// All notes: what was said, and what is thinned out, in a sentence for each reason; of its parts as many, whole, as `fit`, and how many more there are.
    pub(crate) fn all_notes(&self, fits: impl Fn(&str) -> bool) -> Vec<String> {
        let mut notes = self.notes.clone();
        let mut said: Vec<Why> = Vec::new();
        for Thinned { why, .. } in &self.thinned {
            if said.contains(why) {
                continue;
            }
            said.push(*why);
            let list: Vec<&Thinned> = self.thinned.iter().filter(|other| other.why == *why).collect();
            let only = list.first().filter(|first| list.iter().all(|other| other.object == first.object));
            let only =
                only.filter(|_| matches!(why, Why::Close(_))).map(|only| text::clipped(&only.object, 30));
            let part = |of: &&Thinned| {
                let whose = match only {
                    Some(_) => String::new(),
                    None => format!(" of {}", text::clipped(&of.object, 30)),
                };
                let place =
                    of.drawing.as_ref().map(|drawing| format!(" in \"{drawing}\"")).unwrap_or_default();
                format!("{}{whose}{place}", of.count)
            };
            // Whole parts: half a number is another.
            let parts: Vec<String> = list.iter().take(LISTED).map(part).collect();
            let told = |count: usize| {
                let more = match list.len() - count {
                    0 => String::new(),
                    more => format!(" and {more} more"),
                };
                why.words(only.as_deref(), &format!("{}{more}", parts[..count].join(", ")))
            };
            let count = (1..=parts.len()).rev().find(|&count| fits(&told(count)));
            notes.push(told(count.unwrap_or(parts.len().min(1))));
        }
        notes
    }

    pub(super) fn thin(&mut self, why: Why, object: &str, count: String, drawing: Option<&String>) {
        let thinned = Thinned { why, object: object.to_owned(), count, drawing: drawing.cloned() };
        // Each drawing says what it leaves out of an object once: what repeats follows at once.
        if self.thinned.last() != Some(&thinned) {
            self.thinned.push(thinned);
        }
    }
}
