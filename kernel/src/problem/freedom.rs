//! Which control vertices may move.

/// Which vertices may move: global numbers, ascending.
#[derive(Debug, Clone, Default)]
pub(crate) struct Freedom {
    pub(crate) locked: Vec<usize>,
    pub(crate) only: Option<Vec<usize>>,
    /// The interval that the edit is kept within, where `only` comes from one.
    pub(crate) within: Option<(f64, f64)>,
}

impl Freedom {
    pub(crate) fn may_move(&self, vertex: usize) -> bool {
        self.locked.binary_search(&vertex).is_err()
            && self.only.as_ref().is_none_or(|only| only.binary_search(&vertex).is_ok())
    }

    /// What could be done where nothing that may move has influence.
    pub(crate) fn advice(&self) -> String {
        match (self.within, self.only.is_some(), self.locked.is_empty()) {
            (Some((start, end)), _, true) => format!("widen within = [{start}, {end}], or release it"),
            (Some((start, end)), _, false) => format!("unlock one, or widen within = [{start}, {end}]"),
            (None, true, true) => "widen the locality, or release it".to_owned(),
            (None, true, false) => "unlock one, or widen the locality".to_owned(),
            (None, false, false) => "unlock one, or release it".to_owned(),
            (None, false, true) => "release it".to_owned(),
        }
    }
}
