//! What to do where faces run an edge the same way, or too many meet at one.

use std::collections::{BTreeMap, VecDeque};

use super::Topology;

/// So many faces are named at most.
const NAMED: usize = 8;

impl Topology {
    /// What is wrong where two faces run an edge the same way, and what helps: one is the other once more, or turning some over, or a cut where
    /// no turning helps since the faces have one side only (a Möbius band). `O(n log n)`, only ever of a mesh that is refused.
    pub(super) fn same_way(&self, one: usize, other: usize) -> String {
        if let Some(problem) = self.repeated(&[one, other]) {
            return problem;
        }
        let run = format!("is run the same way by faces {one} and {other}");
        let Some(faces) = self.turned(one) else {
            return format!(
                "{run}, and turning faces over does not help: they have one side only, as a Möbius band has; cut the mesh apart along a row of edges"
            );
        };
        let named: Vec<String> = faces.iter().take(NAMED).map(usize::to_string).collect();
        let more = match faces.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let what = if faces.len() == 1 { "face" } else { "faces" };
        format!(
            "{run}: turn {what} {}{more} over, or all others, whichever leaves all counterclockwise from outside",
            named.join(", ")
        )
    }

    /// What is wrong where two of some faces have the same vertices; `None` where no two have.
    pub(super) fn repeated(&self, faces: &[usize]) -> Option<String> {
        let vertices = |face: usize| {
            let mut all = self.face(face).to_vec();
            all.sort_unstable();
            all
        };
        let mut known = BTreeMap::new();
        for &face in faces {
            if let Some(first) = known.insert(vertices(face), face) {
                return Some(format!(
                    "belongs to faces {first} and {face}, which have the same vertices: remove one of them"
                ));
            }
        }
        None
    }

    /// The fewest faces to turn over so that all that hang together with one run their edges against each other. `None` where there is no way.
    fn turned(&self, first: usize) -> Option<Vec<usize>> {
        let sides = |face: usize| {
            let own = self.face(face);
            own.iter().enumerate().map(|(k, &a)| (a, own[(k + 1) % own.len()]))
        };
        let mut at: BTreeMap<(u32, u32), Vec<(usize, bool)>> = BTreeMap::new();
        for face in 0..self.face_count() {
            for (a, b) in sides(face) {
                at.entry((a.min(b), a.max(b))).or_default().push((face, a < b));
            }
        }
        let mut found = BTreeMap::from([(first, false)]);
        let mut open = VecDeque::from([first]);
        while let Some(face) = open.pop_front() {
            let is_turned = found.get(&face).copied().unwrap_or_default();
            for (a, b) in sides(face) {
                let [one, two] = at.get(&(a.min(b), a.max(b)))?[..] else { continue };
                let next = if one.0 == face { two.0 } else { one.0 };
                let wanted = is_turned ^ (one.1 == two.1);
                match found.insert(next, wanted) {
                    Some(before) if before != wanted => return None,
                    Some(_) => {}
                    None => open.push_back(next),
                }
            }
        }
        let turned = found.values().filter(|is_turned| **is_turned).count();
        let fewer = 2 * turned <= found.len();
        Some(found.into_iter().filter(|(_, is_turned)| *is_turned == fewer).map(|(face, _)| face).collect())
    }
}
