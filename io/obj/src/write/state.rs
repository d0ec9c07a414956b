//! What holds for the faces that come, as OBJ keeps it between statements; and where it changes within a mesh.

use std::collections::BTreeSet;

use loftsman_kernel::mesh::FaceGroup;

/// What the last `usemtl`, `s` and `g` said.
#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) material: Option<String>,
    pub(super) smoothing: u32,
    pub(super) groups: bool,
}

/// Where the groups of a mesh's faces change: the face, and which groups hold from there on. The sum of all runs of
/// consecutive faces is what this takes, not groups times faces.
pub(super) struct Changes {
    /// Face, group, whether it starts there.
    events: Vec<(u32, usize, bool)>,
    next: usize,
    active: BTreeSet<usize>,
}

impl Changes {
    pub(super) fn new(groups: &[FaceGroup]) -> Self {
        let mut events = Vec::new();
        for (number, group) in groups.iter().enumerate() {
            for run in group.faces.chunk_by(|a, b| *b == *a + 1) {
                if let (Some(&first), Some(&last)) = (run.first(), run.last()) {
                    events.push((first, number, true));
                    events.push((last + 1, number, false));
                }
            }
        }
        events.sort_unstable();
        Self { events, next: 0, active: BTreeSet::new() }
    }

    /// The groups from a face on, where they are others than before it. Faces come in their order.
    pub(super) fn at(&mut self, face: u32) -> Option<&BTreeSet<usize>> {
        let before = self.next;
        while let Some(&(at, group, starts)) = self.events.get(self.next).filter(|(at, ..)| *at <= face) {
            debug_assert!(at == face);
            if starts {
                self.active.insert(group);
            } else {
                self.active.remove(&group);
            }
            self.next += 1;
        }
        (self.next > before).then_some(&self.active)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_come_and_go() {
        let group = |name: &str, faces: &[u32]| FaceGroup { name: name.into(), faces: faces.into() };
        let mut changes = Changes::new(&[group("a", &[0, 1, 4]), group("b", &[1, 2])]);
        let at: Vec<Option<Vec<usize>>> =
            (0..5).map(|f| changes.at(f).map(|set| set.iter().copied().collect())).collect();
        assert_eq!(at, [Some(vec![0]), Some(vec![0, 1]), Some(vec![1]), Some(vec![]), Some(vec![0])]);
    }
}
