//! What became of everything: of the entities of a file that was read, of the objects of a scene that was written.

use std::collections::BTreeMap;

use crate::scene::{Object, Unit};
use crate::text::counted;

/// What became of an entity of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// It is in the scene, exactly.
    Kept,
    /// It is in the scene, changed or approximated.
    Approximated,
    /// It is not in the scene.
    LeftOut,
}

/// What a reader found, kept and left out: every entity of the file is counted once.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct ReadReport {
    /// Entities in the file, of whatever the format calls one (statements, nodes, rows).
    pub entities: usize,
    /// Those that are in the scene exactly.
    pub kept: usize,
    /// Those that are in the scene changed, with why; grouped by reason.
    pub approximated: BTreeMap<String, usize>,
    /// Those that are not in the scene, with why; grouped by reason.
    pub left_out: BTreeMap<String, usize>,
    /// Anything else worth saying (a unit assumed, an axis noted).
    pub notes: Vec<String>,
    /// The unit that this file states, of a format whose files need not ([`UnitRule::None`](super::UnitRule::None)).
    #[serde(skip)]
    pub unit: Option<Unit>,
}

impl ReadReport {
    /// Counts one entity.
    pub fn count(&mut self, fate: Fate, reason: &str) {
        self.count_many(fate, reason, 1);
    }

    /// Counts several entities of one fate.
    pub fn count_many(&mut self, fate: Fate, reason: &str, count: usize) {
        if count == 0 {
            return;
        }
        self.entities += count;
        match fate {
            Fate::Kept => self.kept += count,
            Fate::Approximated => *self.approximated.entry(reason.to_owned()).or_default() += count,
            Fate::LeftOut => *self.left_out.entry(reason.to_owned()).or_default() += count,
        }
    }

    /// Whether kept, approximated and left out add up to the entities found.
    pub fn adds_up(&self) -> bool {
        self.entities
            == self.kept + self.approximated.values().sum::<usize>() + self.left_out.values().sum::<usize>()
    }
}

/// How one object went out.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Written {
    /// The object.
    pub object: String,
    /// As what: `"NURBS curve"`, `"1200 triangles"`, `"line strip"`.
    pub form: String,
    /// Exactly, approximated, or not at all.
    pub fate: Fate,
    /// The chord tolerance in the scene's unit, where approximated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// How far the triangles of a surface are from it at most, in the scene's unit: what the tessellator has certified,
    /// before coordinates are rounded to those of the format.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Why, where not exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Written {
    /// An object that goes out exactly, as `form`.
    pub fn kept(object: &Object, form: impl Into<String>) -> Self {
        let (object, form) = (object.name().to_owned(), form.into());
        Self { object, form, fate: Fate::Kept, tolerance: None, error: None, reason: None }
    }

    /// An object that does not go out.
    pub fn left_out(object: &Object, reason: impl Into<String>) -> Self {
        Self { fate: Fate::LeftOut, reason: Some(reason.into()), ..Self::kept(object, "nothing") }
    }

    /// It does not go out after all.
    pub fn leave_out(&mut self, reason: impl Into<String>) {
        (self.fate, self.reason) = (Fate::LeftOut, Some(reason.into()));
    }

    /// It is cut into segments or triangles: the chord tolerance and the certified error, as lengths in the scene's unit.
    pub fn cut(&mut self, tolerance: f64, error: Option<f64>) {
        (self.tolerance, self.error) = (Some(tolerance), error);
    }

    /// It goes out changed, and why, behind what was said before; unless it is left out anyway.
    pub fn change(&mut self, reason: &str) {
        if self.fate != Fate::LeftOut {
            self.fate = Fate::Approximated;
            let before = self.reason.take().map(|before| before + "; ").unwrap_or_default();
            self.reason = Some(before + reason);
        }
    }
}

/// What a writer wrote, object by object.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct WriteReport {
    /// Every object of the scene.
    pub objects: Vec<Written>,
    /// What the format does not hold of the scene, a line for each kind of thing, as [`Format::losses`](super::Format::losses)
    /// tells beforehand.
    pub losses: Vec<String>,
    /// Anything else worth saying.
    pub notes: Vec<String>,
}

impl WriteReport {
    /// All that is to be said beside the objects: what was lost, then the notes.
    pub fn told(self) -> Vec<String> {
        [self.losses, self.notes].concat()
    }

    /// Notes how many there are of something, where there are any; words that one and several differ in as in [`counted`].
    pub fn say(&mut self, count: usize, what: &str) {
        if count > 0 {
            self.notes.push(counted(count, what));
        }
    }
}
