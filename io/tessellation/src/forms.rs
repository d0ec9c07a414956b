//! Forms of cells that are halved one after the other: each half is made from its whole, not from the patch.

use crate::form::Form;
use crate::patch::Patch;

/// The form of a cell, and those of the cells that wait. Their room is used again.
#[derive(Debug, Default)]
#[expect(clippy::vec_box, reason = "forms change places at every cell, and are large")]
pub(crate) struct Forms {
    now: Box<Form>,
    /// Whether there is a form in `now`.
    known: bool,
    /// What waits, the next one last.
    waiting: Vec<Box<Form>>,
    spare: Vec<Box<Form>>,
}

impl Forms {
    /// Makes that of the cell last taken ready to be asked.
    pub(crate) fn arrange(&mut self) {
        self.now.arrange();
    }

    /// That of the cell last taken.
    pub(crate) fn now(&self) -> &Form {
        &self.now
    }

    /// Makes ready for another patch.
    pub(crate) fn clear(&mut self) {
        self.known = false;
        self.spare.append(&mut self.waiting);
    }

    /// Takes the cell from `low` to `high` of the patch.
    pub(crate) fn take(&mut self, patch: &Patch, low: [f64; 2], high: [f64; 2]) {
        if self.known && self.now.is(low, high) {
            return;
        }
        match self.waiting.pop() {
            Some(next) if next.is(low, high) => self.spare.push(std::mem::replace(&mut self.now, next)),
            other => {
                // Cells are not taken in the order in which they were halved: none of what waits can be trusted to be next.
                self.spare.extend(other);
                self.spare.append(&mut self.waiting);
                self.now.set(patch, low, high);
            }
        }
        self.known = true;
    }

    /// Halves the cell in a direction; one half is the next to be taken, and the other will be after all halves of that.
    pub(crate) fn halve(&mut self, direction: usize, upper_first: bool) {
        let mut other = self.spare.pop().unwrap_or_default();
        self.now.halve(&mut other, direction);
        if upper_first {
            std::mem::swap(&mut self.now, &mut other);
        }
        self.waiting.push(other);
    }
}
