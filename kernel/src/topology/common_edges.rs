//! Who has an edge in common with whom, edges compared at some of their points.

use super::Nearby;
use crate::shape::{Edges, Location};
use crate::{Point, Vector};

/// Points by which edges are compared: enough that two which agree there are meant to be one.
pub const SAMPLES: usize = 9;

/// Edges met so far, by where their middles lie, and who hangs together by them.
#[derive(Debug)]
pub struct CommonEdges {
    near: f64,
    places: Nearby<(usize, [Point; SAMPLES])>,
    groups: Groups,
}

impl CommonEdges {
    /// For so many owners of edges, which are one where their points are within `near` of one another; `low` is below them all.
    pub fn new(owners: usize, low: Point, near: f64) -> Self {
        Self { near, places: Nearby::new(low, near), groups: Groups::new(owners) }
    }

    /// The edges of a shape at [`SAMPLES`] evenly spaced parameters each, by `point`; `None` where a point cannot be had.
    pub fn sampled(
        edges: &dyn Edges,
        point: &dyn Fn(Location) -> Option<Point>,
    ) -> Option<Vec<[Point; SAMPLES]>> {
        let all = edges.iter().map(|edge| {
            let mut points = [Point::origin(); SAMPLES];
            for (i, place) in points.iter_mut().enumerate() {
                let share = i as f64 / (SAMPLES - 1) as f64;
                let t =
                    if i + 1 == SAMPLES { edge.end } else { edge.start + (edge.end - edge.start) * share };
                *place = point(edge.at(t))?;
            }
            Some(points)
        });
        all.collect()
    }

    /// Takes an edge: its owner hangs together with whoever has the same one, run through either way. Poles are nobody's. Amortised
    /// `O(log n)`.
    pub fn add(&mut self, owner: usize, edge: [Point; SAMPLES]) {
        if let Some(other) = self.meet(owner, edge) {
            self.groups.join(owner, other);
        }
    }

    /// Who stands for all that an owner hangs together with, itself among them.
    pub fn group(&mut self, owner: usize) -> usize {
        self.groups.root(owner)
    }

    /// Whose edge this one is too; kept where it is new.
    fn meet(&mut self, owner: usize, edge: [Point; SAMPLES]) -> Option<usize> {
        let near = self.near;
        let together = |(a, b): (&Point, &Point)| (a - b).norm() <= near;
        if edge.iter().all(|p| together((p, &edge[0]))) {
            return None;
        }
        let first = edge[0];
        let middle = first + edge.iter().map(|p| p - first).sum::<Vector>() / SAMPLES as f64;
        let same = |(_, known): &(usize, [Point; SAMPLES])| {
            known.iter().zip(&edge).all(together) || known.iter().rev().zip(&edge).all(together)
        };
        if let Some((other, _)) = self.places.find(&middle, same) {
            return Some(*other);
        }
        self.places.put(&middle, (owner, edge));
        None
    }
}

/// Disjoint sets, each known by its first member.
#[derive(Debug)]
pub(crate) struct Groups(Vec<usize>);

impl Groups {
    /// So many sets of one member each.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    pub(crate) fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
