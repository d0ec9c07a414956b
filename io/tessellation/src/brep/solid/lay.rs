//! A face laid out with the edges as they are cut, and how its points are numbered.

use std::collections::BTreeMap;

use loftsman_kernel::{Error, Point};

use super::Cut;
use crate::brep::arrange::{Layout, Leg, arrange};
use crate::brep::carrier::Searches;
use crate::brep::cut::ONE_PLACE;
use crate::brep::plane::{Plane, Trouble};

/// A face laid out, or why it cannot be. Its points have numbers of its own, so that it stays as it is where edges of others are cut again.
pub(super) struct Laid<'b> {
    pub(super) plane: Result<Plane<'b>, Trouble>,
    numbers: Numbers,
}

/// The numbers of the points of some edges: vertices have their own, those inside of edges follow, edge by edge.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    /// Where those inside of each edge start.
    starts: BTreeMap<usize, u32>,
    /// The edges by where they start, ascending.
    edges: Vec<(u32, usize)>,
    /// The number after all.
    pub(super) next: u32,
}

impl Numbers {
    /// The number of a point in the numbering of all edges.
    fn of_all(&self, number: u32, vertices: u32, all: &Self) -> u32 {
        if number < vertices {
            return number;
        }
        if number >= self.next {
            return number - self.next + all.next;
        }
        let behind = self.edges.partition_point(|(start, _)| *start <= number);
        let found = behind.checked_sub(1).map(|k| self.edges[k]);
        found.map_or(number, |(start, edge)| {
            number - start + all.starts.get(&edge).copied().unwrap_or_default()
        })
    }
}

impl<'b> Laid<'b> {
    /// Whether it is laid out, and its loops say what is inside.
    pub(super) fn is_cut(&mut self) -> bool {
        self.plane.as_mut().is_ok_and(|plane| plane.labels().is_ok())
    }

    /// The plane with its points numbered as all are.
    pub(super) fn of_all(self, vertices: usize, all: &Numbers) -> Result<Plane<'b>, Trouble> {
        let numbers = self.numbers;
        self.plane.map(|mut plane| {
            for vertex in &mut plane.vertices {
                vertex.point = vertex.point.map(|number| numbers.of_all(number, vertices as u32, all));
            }
            plane
        })
    }
}

impl<'b> Cut<'b> {
    /// Numbers the points of edges, and gives those inside of them.
    pub(super) fn numbered(&self, edges: impl Iterator<Item = usize>) -> (Numbers, Vec<Point>) {
        let mut numbers = Numbers { next: self.brep.vertices().len() as u32, ..Numbers::default() };
        let mut points = Vec::new();
        for edge in edges {
            let Some(Some(chain)) = self.chains.get(edge) else { continue };
            if numbers.starts.contains_key(&edge) {
                continue;
            }
            numbers.starts.insert(edge, numbers.next);
            numbers.edges.push((numbers.next, edge));
            let inner = chain.points.get(1..chain.points.len() - 1).unwrap_or_default();
            numbers.next += inner.len() as u32;
            points.extend_from_slice(inner);
        }
        (numbers, points)
    }

    /// The numbers of the points of an edge.
    pub(super) fn numbers(&self, edge: usize, all: &Numbers) -> Vec<u32> {
        let (Some(ends), Some(Some(chain)), Some(&start)) =
            (self.brep.ends(edge), self.chains.get(edge), all.starts.get(&edge))
        else {
            return Vec::new();
        };
        let [first, last] = ends.map(|end| self.vertices[end]);
        let inner = (0..chain.points.len().saturating_sub(2) as u32).map(|k| start + k);
        std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect()
    }

    /// Lays out a face and joins its nodes; none of one that is whole or left out.
    pub(super) fn laid(&self, face: usize) -> Option<Laid<'b>> {
        if self.carriers[face].is_none() || self.troubles.contains_key(&face) {
            return None;
        }
        let (numbers, inner) = self.numbered(self.brep.loops(face).iter().flatten().map(|one| one.edge));
        let plane = self.plane(face, &numbers, &inner)?;
        Some(Laid { plane, numbers })
    }

    fn plane(&self, face: usize, all: &Numbers, inner: &[Point]) -> Option<Result<Plane<'b>, Trouble>> {
        let carrier = self.carriers[face].as_ref()?;
        let mut legs = Vec::new();
        for one in self.brep.loops(face).iter().flatten() {
            let Some(Some(chain)) = self.chains.get(one.edge) else { continue };
            let Some(track) = chain.tracks.iter().find(|track| track.face == face) else { continue };
            if let Some(off) = track.lost {
                let (number, off) = (one.edge, loftsman_kernel::text::short(off * self.goal.size));
                return Some(Err(Trouble::Other(Error::Invalid(format!(
                    "its edge {number} is {off} off its surface: it lies on another one, or one of the two is wrong"
                )))));
            }
            let numbers = self.numbers(one.edge, all);
            let of = |part: usize| {
                let (a, b) = (part, part + 1);
                let [a, b] = if one.reversed { [b, a] } else { [a, b] };
                Leg {
                    points: [numbers[a], numbers[b]],
                    ends: [track.at[a], track.at[b]],
                    edge: one.edge,
                    part,
                }
            };
            let parts = 0..track.at.len().saturating_sub(1);
            if one.reversed { legs.extend(parts.rev().map(of)) } else { legs.extend(parts.map(of)) }
        }
        let mut lone = Vec::new();
        for &vertex in self.brep.lone_vertices(face) {
            let point = self.brep.vertices()[vertex];
            let snap = (self.brep.tolerances()[vertex] / self.goal.size).max(ONE_PLACE);
            match carrier.foot(&point, None, 2.0 * snap, &mut Searches::default()) {
                Ok((at, off)) if off <= 2.0 * snap => {
                    let mut at = carrier.settled(at, &carrier.framed(&point), 2.0 * snap);
                    for d in 0..2 {
                        if at[d].is_nan() {
                            at[d] = carrier.sides[d].low;
                        }
                    }
                    lone.push((at, self.vertices[vertex]));
                }
                _ => {}
            }
        }
        let layout = Layout {
            legs: &legs,
            followed: &[],
            reversed: self.brep.is_reversed(face),
            merges: false,
            first_own: all.next,
            lone: &lone,
        };
        let arranged = match arrange(carrier, &layout, &self.goal) {
            Ok(arranged) => arranged,
            Err(clash) => return Some(Err(Trouble::Clash(clash))),
        };
        let vertices = self.brep.vertices();
        let place = |number: u32| {
            let number = number as usize;
            carrier.framed(vertices.get(number).unwrap_or_else(|| &inner[number - vertices.len()]))
        };
        Some(Plane::new(carrier, &arranged, all.next, place, &self.goal))
    }
}
