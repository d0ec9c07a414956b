//! Tessellations of what is in the file exactly, too: they are left out, so that nothing is in the scene twice.

use std::collections::HashSet;

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::scene::Geometry;

use super::facets;
use super::items::Item;
use super::product::Node;
use super::report::Account;
use crate::part21::File;

/// How far the box around a tessellation may be from that around what it stands for, as a part of its diagonal: what is cut to a tenth of a radius
/// is nearer.
const BESIDE: f64 = 0.02;
/// Places of an edge that are looked at for the box around a Brep.
const LOOKS: usize = 8;

/// Leaves out tessellations whose exact shape was read, by what they name or because both are of one product and as large, and those that a product has already; the
/// rest is kept in the account. Each is told.
pub(super) fn leave_out(
    file: &File<'_>,
    nodes: &[Node],
    items: &mut [Vec<Item>],
    account: &mut Account<'_, '_>,
) {
    let mut seen: HashSet<u64> = HashSet::new();
    let mut kept = Vec::new();
    for (node, found) in nodes.iter().zip(items) {
        if found.iter().all(|item| item.tessellation.is_none()) {
            continue;
        }
        let exact: Vec<Brep> = found.iter().filter_map(brep).cloned().collect();
        found.retain(|item| {
            let Some(number) = item.tessellation else { return true };
            let links = facets::links(file, number);
            let why = if !links.is_empty() && links.iter().all(|&link| account.is_whole(link)) {
                let more = if links.len() > 1 { " and others" } else { "" };
                format!("#{}{more}, which it names and which is read exactly", links[0])
            } else if links.is_empty() && stands_for(&item.geometry, &exact) {
                "what its product has exactly, too, and is as large".to_owned()
            } else if !seen.insert(number) && node.is_lone {
                // The other representation has it, be it left out or kept.
                return false;
            } else {
                kept.push(number);
                return true;
            };
            seen.insert(number);
            account.tessellates(number, &format!("left out: it is the tessellation of {why}"));
            false
        });
    }
    account.keep_whole(&kept);
}

fn brep(item: &Item) -> Option<&Brep> {
    match &*item.geometry {
        Geometry::Brep(brep) => Some(brep),
        _ => None,
    }
}

/// Whether a mesh is as large as one of some Breps, or as all of them: it lies in the box around the control vertices and covers that around the edges.
fn stands_for(mesh: &Geometry, exact: &[Brep]) -> bool {
    let Some(own) = Box::around(mesh.points()) else { return false };
    let slack = BESIDE * (own.high - own.low).norm();
    let is_that = |around: &[Box; 2]| own.is_in(&around[0], slack) && around[1].is_in(&own, slack);
    let around: Vec<[Box; 2]> = exact.iter().filter_map(boxes).collect();
    let all = around.iter().copied().reduce(|[a, b], [c, d]| [a.with(c), b.with(d)]);
    around.iter().chain(&all).any(is_that)
}

/// The boxes around the control vertices of a Brep and around its edges.
fn boxes(brep: &Brep) -> Option<[Box; 2]> {
    let mut on_edges = brep.vertices().to_vec();
    for edge in (0..brep.edge_count()).filter_map(|edge| brep.edge(edge)) {
        let (start, end) = edge.range;
        let at = |k: usize| start + (end - start) * (k as f64 / LOOKS as f64);
        on_edges.extend((1..LOOKS).filter_map(|k| edge.curve.point(at(k)).ok()));
    }
    Some([Box::around(brep.points())?, Box::around(&on_edges)?])
}

#[derive(Debug, Clone, Copy)]
struct Box {
    low: Point,
    high: Point,
}

impl Box {
    fn around(points: &[Point]) -> Option<Self> {
        let first = *points.first()?;
        let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        Some(Self { low, high })
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn is_in(&self, other: &Self, slack: f64) -> bool {
        (0..3).all(|k| self.low[k] >= other.low[k] - slack && self.high[k] <= other.high[k] + slack)
    }
}
