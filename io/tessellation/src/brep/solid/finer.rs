//! Edges of faces whose chords stay in each other's way cut anew, finer.
//!
//! How near to a crease or a seam is on it, and how near to a point a foot is believed to be its own, are parts of the tolerance: loops
//! that come nearer to one another than that cross, as chords, however often these are halved. So the edges of such a face, and of no other,
//! are cut to a part of the tolerance; the faces beside it have the same ones. Where that parts no loops, or puts others in each other's way,
//! all is left as it was.

use std::collections::BTreeSet;

use loftsman_kernel::{Point, Vector, parallel};

use super::Cut;
use super::lay::Laid;
use super::untangle::Before;
use crate::brep::cut::{Chain, ONE_PLACE};

/// The part of the tolerance that edges are cut to where chords stay in each other's way.
pub(super) const FINER_BY: f64 = 0.1;
/// How often edges are cut finer by that.
const FINER_TIMES: usize = 2;
/// The part of the tolerance that they are cut to at last.
pub(super) const FINEST: f64 = FINER_BY * FINER_BY;
/// Of chords that are in the way of others so many are looked at for one that meets another in space.
const LOOKED_AT: usize = 64;
/// Chords that are shorter than so many times what is one place meet by rounding.
const SHORT: f64 = 100.0;

impl Cut<'_> {
    /// Cuts the edges of faces finer whose chords are in each other's way, and keeps what parts them.
    ///
    /// Chords of different edges that meet in space are given up at once: finer ones meet there, too. Others cost some ten times as much
    /// as the face itself.
    pub(super) fn cut_finer(&mut self) {
        for face in 0..self.brep.face_count() {
            let mut part = 1.0;
            for _ in 0..FINER_TIMES {
                part *= FINER_BY;
                if self.clash_of(face).is_none_or(|clash| self.meet(face, clash)) || self.parts(face, part) {
                    break;
                }
            }
        }
    }

    /// Cuts the edges of a face to a part of the tolerance; whether that parts its loops. All is as it was where it does not.
    fn parts(&mut self, face: usize, part: f64) -> bool {
        let edges: BTreeSet<usize> = self.brep.loops(face).iter().flatten().map(|one| one.edge).collect();
        let coarse = |edge: &usize| {
            self.chains.get(*edge).and_then(Option::as_ref).is_some_and(|chain| chain.goal.part > part)
        };
        let edges: Vec<usize> = edges.into_iter().filter(coarse).collect();
        let goal = self.goal.finer(part);
        let made = parallel::map(edges.len(), |k| self.chain(edges[k], goal));
        let mut before = Before::default();
        for (&edge, chain) in edges.iter().zip(made) {
            // One that would need too many chords stays as it is.
            if let Ok(Some(chain)) = chain {
                before.chains.insert(edge, self.chains[edge].replace(chain));
            }
        }
        if before.chains.is_empty() {
            return false;
        }
        self.untangle(&mut BTreeSet::from([face]), false, Some(&mut before));
        let mut parted = self.is_cut(face);
        if parted {
            let uses = before.chains.keys().flat_map(|&edge| self.brep.uses(edge));
            let mut beside: BTreeSet<usize> = uses.map(|place| place.face).collect();
            self.untangle(&mut beside, true, Some(&mut before));
            let known = &mut before.planes;
            beside.retain(|&other| {
                let was = known.get_mut(&other).and_then(Option::as_mut);
                other == face || was.is_some_and(Laid::is_cut)
            });
            parted = beside.iter().all(|&other| self.is_cut(other));
        }
        if !parted {
            before.chains.into_iter().for_each(|(edge, chain)| self.chains[edge] = chain);
            before.planes.into_iter().for_each(|(face, laid)| self.planes[face] = laid);
        }
        parted
    }

    fn is_cut(&mut self, face: usize) -> bool {
        self.planes.get_mut(face).and_then(Option::as_mut).is_some_and(Laid::is_cut)
    }

    /// Whether a chord that is in the way of others meets one of another edge of its face in space, and not at an end of both.
    pub(super) fn meet(&self, face: usize, clash: &[(usize, usize)]) -> bool {
        let near = ONE_PLACE * self.goal.size;
        let chord = |chain: &Chain, part: usize| -> Option<[Point; 2]> {
            let ends = [*chain.points.get(part)?, *chain.points.get(part + 1)?];
            (nalgebra::distance(&ends[0], &ends[1]) > SHORT * near).then_some(ends)
        };
        let chain = |edge: usize| self.chains.get(edge).and_then(Option::as_ref);
        let edges: BTreeSet<usize> = self.brep.loops(face).iter().flatten().map(|one| one.edge).collect();
        clash.iter().take(LOOKED_AT).any(|&(edge, part)| {
            let Some(one) = chain(edge).and_then(|chain| chord(chain, part)) else { return false };
            edges.iter().filter(|other| **other != edge).filter_map(|&other| chain(other)).any(|other| {
                (0..other.points.len().saturating_sub(1)).filter_map(|part| chord(other, part)).any(|other| {
                    let shared = one.iter().filter(|p| other.contains(p)).count();
                    shared == 2 || shared == 0 && apart(&one, &other) <= near
                })
            })
        })
    }
}

/// The distance of two segments.
fn apart(one: &[Point; 2], other: &[Point; 2]) -> f64 {
    let (d, e, w) = (one[1] - one[0], other[1] - other[0], one[0] - other[0]);
    let (a, b, c) = (d.norm_squared(), d.dot(&e), e.norm_squared());
    let share = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
    // On the first where the two lines are nearest, on the second what is nearest to that, and back.
    let s = share((b * e.dot(&w) - c * d.dot(&w)) / (a * c - b * b));
    let t = share((e.dot(&w) + s * b) / c);
    let s = share((t * b - d.dot(&w)) / a);
    let apart: Vector = w + d * s - e * t;
    apart.norm()
}
