//! The elements of one object-to-be.

use std::collections::HashMap;

use loftsman_kernel::mesh::{FaceGroup, NONE};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};

use super::part::Parsed;
use crate::fingerprint;

/// A free-form element that has been read.
#[derive(Debug)]
pub(crate) enum Shape {
    Curve(Curve),
    Surface(Surface),
    Trimmed(Trimmed),
}

/// A free-form element with the name it would like and its number among the surfaces.
#[derive(Debug)]
pub(crate) struct Element {
    pub(crate) shape: Shape,
    pub(crate) name: Option<String>,
    pub(crate) surface: Option<usize>,
    pub(crate) material: Option<usize>,
}

/// The material and the first group that held for lines or points, by their places among all names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Look {
    pub(crate) material: Option<usize>,
    pub(crate) group: Option<usize>,
}

/// What holds for the faces that come now.
#[derive(Debug, Clone, Default)]
pub(crate) struct State {
    /// Groups, by their place among all names.
    pub(crate) groups: Vec<usize>,
    /// The smoothing group, once one was named.
    pub(crate) smoothing: Option<u32>,
    /// The material, by its place among all names.
    pub(crate) material: Option<usize>,
}

/// The elements of one object-to-be.
#[derive(Debug, Default)]
pub(crate) struct Section {
    pub(crate) name: String,
    /// The colour of its own that a comment of ours says.
    pub(crate) color: Option<[f64; 4]>,
    /// Vertex of every corner, and where each face starts.
    pub(crate) corners: Vec<u32>,
    pub(crate) starts: Vec<usize>,
    /// Texture vertex and normal of every corner, or [`NONE`]; shorter where the last ones have none.
    pub(crate) textures: Vec<u32>,
    pub(crate) normals: Vec<u32>,
    /// Slot of every face; shorter where the last ones have the first.
    pub(crate) materials: Vec<u32>,
    /// The material of each slot; `None` for faces before any `usemtl`.
    pub(crate) slots: Vec<Option<usize>>,
    slot_of: HashMap<Option<usize>, u32>,
    pub(crate) smoothing: Vec<u32>,
    smoothing_said: bool,
    pub(crate) groups: Vec<FaceGroup>,
    group_of: HashMap<usize, usize>,
    pub(crate) chains: Vec<u32>,
    pub(crate) chain_starts: Vec<usize>,
    /// What held for each chain: its material, and a group where it was in one.
    pub(crate) chain_looks: Vec<Look>,
    pub(crate) dots: Vec<u32>,
    /// What held for runs of points, each from this point on.
    pub(crate) dot_looks: Vec<(usize, Look)>,
    pub(crate) elements: Vec<Element>,
    /// Whether its normals were made when it was written.
    pub(crate) made_normals: bool,
    /// The mark of its mesh, which shows a surface; that of its surface, and of the mesh that shows it.
    pub(crate) shows: Option<u64>,
    pub(crate) shown: Option<(u64, u64)>,
}

/// Appends a run of a list that is shorter where its last entries are [`NONE`].
fn append(to: &mut Vec<u32>, before: usize, from: &[u32], run: std::ops::Range<usize>) {
    let run = run.start.min(from.len())..run.end.min(from.len());
    if !run.is_empty() {
        to.resize(before, NONE);
        to.extend_from_slice(&from[run]);
    }
}

impl State {
    fn look(&self) -> Look {
        Look { material: self.material, group: self.groups.first().copied() }
    }
}

impl Section {
    /// An empty one.
    pub(crate) fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    pub(crate) fn face_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether it has faces, lines or points, none of which are in a group: what that group names comes behind them.
    pub(crate) fn is_before(&self, group: usize) -> bool {
        let has_some = !(self.corners.is_empty() && self.chains.is_empty() && self.dots.is_empty());
        let mut looks = self.chain_looks.iter().chain(self.dot_looks.iter().map(|(_, look)| look));
        has_some && !self.group_of.contains_key(&group) && !looks.any(|look| look.group == Some(group))
    }

    /// Whether it is one surface, which is still what its mark says.
    pub(crate) fn is_as_written(&self) -> bool {
        let found = match &self.elements[..] {
            [Element { shape: Shape::Surface(surface), .. }] => fingerprint::surface(surface),
            [Element { shape: Shape::Trimmed(trimmed), .. }] => fingerprint::trimmed(trimmed),
            _ => return false,
        };
        self.shown.is_some_and(|(own, _)| own == found)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.corners.is_empty() && self.chains.is_empty() && self.dots.is_empty() && self.elements.is_empty()
    }

    /// Takes the faces of a run.
    pub(crate) fn faces(
        &mut self,
        parsed: &Parsed<'_>,
        run: std::ops::Range<usize>,
        state: &State,
        names: &[String],
    ) {
        if run.is_empty() {
            return;
        }
        let first = run.start.checked_sub(1).map_or(0, |k| parsed.ends[k] as usize);
        let last = parsed.ends[run.end - 1] as usize;
        let before = self.corners.len();
        self.corners.extend_from_slice(&parsed.corners[first..last]);
        append(&mut self.textures, before, &parsed.textures, first..last);
        append(&mut self.normals, before, &parsed.normals, first..last);
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let face = self.face_count();
        self.starts.extend(parsed.ends[run.clone()].iter().map(|&end| end as usize - first + before));
        let after = self.face_count();
        let next = self.slots.len() as u32;
        let slot = *self.slot_of.entry(state.material).or_insert(next);
        if slot == next {
            self.slots.push(state.material);
        }
        if slot != 0 {
            self.materials.resize(face, 0);
            self.materials.resize(after, slot);
        }
        if let Some(group) = state.smoothing {
            self.smoothing_said = true;
            if group != 0 {
                self.smoothing.resize(face, 0);
                self.smoothing.resize(after, group);
            }
        }
        for &name in &state.groups {
            let next = self.groups.len();
            let at = *self.group_of.entry(name).or_insert(next);
            if at == next {
                self.groups.push(FaceGroup { name: names[name].clone(), faces: Vec::new() });
            }
            self.groups[at].faces.extend(face as u32..after as u32);
        }
    }

    /// Takes the lines of a run: each is joined to the one before where it starts at its end.
    pub(crate) fn lines(&mut self, parsed: &Parsed<'_>, run: std::ops::Range<usize>, state: &State) {
        let look = state.look();
        for k in run {
            let start = k.checked_sub(1).map_or(0, |k| parsed.chain_ends[k] as usize);
            let mut chain = &parsed.chains[start..parsed.chain_ends[k] as usize];
            if self.chain_starts.is_empty() {
                self.chain_starts.push(0);
            }
            if let [.., start, _] = self.chain_starts[..] {
                let last = &self.chains[start..];
                // A chain that has come back to its start is complete.
                let complete = last.len() > 2 && last.first() == last.last();
                let alike = self.chain_looks.last() == Some(&look);
                if !complete && alike && last.last() == chain.first() {
                    chain = &chain[1..];
                    self.chain_starts.pop();
                    self.chain_looks.pop();
                }
            }
            self.chains.extend_from_slice(chain);
            self.chain_starts.push(self.chains.len());
            self.chain_looks.push(look);
        }
    }

    /// Takes the point statements of a run.
    pub(crate) fn dots(&mut self, parsed: &Parsed<'_>, run: std::ops::Range<usize>, state: &State) {
        let look = state.look();
        if !run.is_empty() && self.dot_looks.last().is_none_or(|(_, last)| *last != look) {
            self.dot_looks.push((self.dots.len(), look));
        }
        let end = |k: usize| k.checked_sub(1).map_or(0, |k| parsed.dot_ends[k] as usize);
        self.dots.extend_from_slice(&parsed.dots[end(run.start)..end(run.end)]);
    }

    /// Brings the lists to their full length.
    pub(crate) fn finish(&mut self) {
        let (faces, corners) = (self.face_count(), self.corners.len());
        for list in [&mut self.textures, &mut self.normals] {
            if !list.is_empty() {
                list.resize(corners, NONE);
            }
        }
        if !self.materials.is_empty() {
            self.materials.resize(faces, 0);
        }
        if self.smoothing_said {
            self.smoothing.resize(faces, 0);
        }
    }
}
