//! Edges cut finer where chords are in each other's way.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::parallel;

use super::Cut;
use super::lay::Laid;
use crate::brep::arrange::Clash;
use crate::brep::cut::Chain;
use crate::brep::plane::Trouble;

/// How often edges are cut finer because chords are in each other's way.
const ROUNDS: usize = 12;
/// As often where all of them have been cut finer already.
const AGAIN: usize = 6;
/// No more than so many times the points that edges have, and so many beside, are put on them for that: loops that cross stay crossed.
const FINER: usize = 4;
const CHORDS: usize = 20_000;

/// Edges and faces as they were before they were changed.
#[derive(Default)]
pub(super) struct Before<'b> {
    pub(super) chains: BTreeMap<usize, Option<Chain>>,
    pub(super) planes: BTreeMap<usize, Option<Laid<'b>>>,
}

impl<'b> Cut<'b> {
    /// Lays out the faces, and cuts edges finer where chords are in each other's way, until none are.
    pub(super) fn untangle_all(&mut self) {
        let mut all = (0..self.brep.face_count()).collect();
        self.untangle(&mut all, true, None);
    }

    /// How the chords of a face are in each other's way, if they are.
    pub(super) fn clash_of(&self, face: usize) -> Option<&Clash> {
        match self.planes.get(face)?.as_ref()?.plane.as_ref().err()? {
            Trouble::Clash(clash) => Some(clash),
            Trouble::Other(_) => None,
        }
    }

    /// Lays out some faces, and cuts their edges finer where chords are in each other's way, until none are. Of faces beside them, which have
    /// these edges too, those join them where they are to `spread`. What is changed is kept in `before`, where there is one.
    pub(super) fn untangle(
        &mut self,
        faces: &mut BTreeSet<usize>,
        spread: bool,
        mut before: Option<&mut Before<'b>>,
    ) {
        let mut rounds = if before.is_some() { AGAIN } else { ROUNDS };
        let most = FINER * self.count() + CHORDS;
        let mut changed: Vec<usize> = faces.iter().copied().collect();
        loop {
            let laid = parallel::map(changed.len(), |k| self.laid(changed[k]));
            for (&face, laid) in changed.iter().zip(laid) {
                let old = std::mem::replace(&mut self.planes[face], laid);
                if let Some(before) = before.as_mut() {
                    before.planes.entry(face).or_insert(old);
                }
            }
            if rounds == 0 || self.count() > most {
                return;
            }
            rounds -= 1;
            let mut wanted: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
            for &face in faces.iter() {
                for (edge, part) in self.clash_of(face).into_iter().flatten() {
                    wanted.entry(*edge).or_default().insert(*part);
                }
            }
            let (mut cut, mut beside) = (false, BTreeSet::new());
            for (edge, parts) in wanted {
                let Some(Some(chain)) = self.chains.get_mut(edge) else { continue };
                if let Some(before) = before.as_mut() {
                    before.chains.entry(edge).or_insert_with(|| Some(chain.clone()));
                }
                for part in parts.into_iter().rev() {
                    cut |= chain.halve(part, self.carriers).unwrap_or(false);
                }
                if chain.settle(self.carriers).is_err() {
                    // It will not get better: what still clashes is left out.
                    rounds = 0;
                }
                beside.extend(self.brep.uses(edge).iter().map(|place| place.face));
            }
            if !cut {
                return;
            }
            if spread {
                faces.extend(&beside);
            } else {
                beside.retain(|face| faces.contains(face));
            }
            changed = beside.into_iter().collect();
        }
    }

    /// The points that edges have.
    fn count(&self) -> usize {
        self.brep.vertices().len()
            + self.chains.iter().flatten().map(|chain| chain.points.len()).sum::<usize>()
    }
}
