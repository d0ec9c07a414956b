//! Closed boundaries made of surfaces: periodic ones, seams, poles, and patches that meet edge to edge.

use super::TOGETHER;
use super::edge_curve::{EdgeCurve, coincide};
use crate::Point;
use crate::error::{Error, Result};
use crate::shape::{Shape, Stencil, Tear, edges_of, torn};
use crate::spline::Curve;
use crate::text::figure;

/// A surface that is part of a shell, and what messages call it.
#[derive(Debug, Clone)]
pub struct Member<'a> {
    /// The surface.
    pub shape: &'a dyn Shape,
    /// Its name in messages: `"hull"`, or `shape 2`.
    pub name: String,
}

/// Two combinations of control vertices, each of a member, that are one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// A member's number, and the combination of its control vertices.
    pub first: (usize, Stencil),
    /// The other one's.
    pub second: (usize, Stencil),
}

/// Surfaces that close: how each is turned, and which of their edges' points stay together.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// For each member: 1, or -1 where its `S_u × S_v` points to the other side than the first member's.
    pub senses: Vec<f64>,
    /// The points that are one: of edges that meet, and of edges that are points.
    pub ties: Vec<Tie>,
}

impl Shell {
    /// Finds for every edge the one other edge that it meets all along, within 1e-9 of the size of the whole, or that it is a
    /// point. `O(n log n)` for `n` edges that lie apart.
    ///
    /// # Errors
    /// When a member says nothing of its edges or may be torn, an edge meets no other, or the surfaces cannot be turned to
    /// one side; `what` says who asks.
    pub fn find(members: &[Member<'_>], what: &str) -> Result<Self> {
        let near = TOGETHER * size(members);
        let edges = edges(members, what)?;
        let mut ties = Vec::new();
        let mut meetings = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        for (k, (member, edge)) in edges.iter().enumerate() {
            if edge.spread() <= near {
                let pairs = edge.stencils.windows(2);
                ties.extend(
                    pairs.map(|p| Tie { first: (*member, p[1].clone()), second: (*member, p[0].clone()) }),
                );
            } else {
                open.push(k);
            }
        }
        // Edges that are one have one middle (or are closed): in the order of its x, partners are near one another.
        let middles: Vec<Option<Point>> = edges.iter().map(|(_, edge)| edge.middle(near)).collect();
        let place = |k: usize| middles[k].map_or(f64::NEG_INFINITY, |m| m.x);
        open.sort_by(|&a, &b| place(a).total_cmp(&place(b)));
        let mut alone = vec![true; open.len()];
        for at in 0..open.len() {
            if !std::mem::take(&mut alone[at]) {
                continue;
            }
            let (k, (member, edge)) = (open[at], &edges[open[at]]);
            let candidates = (at + 1..open.len()).take_while(|&j| place(open[j]) <= place(k) + near);
            let found = candidates.filter(|&j| alone[j]).find_map(|j| {
                let apart = match (middles[k], middles[open[j]]) {
                    (Some(a), Some(b)) => (b - a).norm() > near,
                    (a, b) => a.is_some() != b.is_some(),
                };
                let found = if apart { None } else { coincide(edge, &edges[open[j]].1, near) };
                found.map(|m| (j, m))
            });
            let Some((j, found)) = found else {
                // The one that is open the most, of so many as can be looked at without the work growing with their square.
                let rest = (at + 1..open.len()).filter(|&j| alone[j]).map(|j| open[j]);
                let distance = |k: usize| nearest(&edges, k).map_or(f64::INFINITY, |n| n.distance);
                let each = std::iter::once(k).chain(rest).take(32).map(|k| (distance(k), k));
                let worst = each.reduce(|worst, own| if own.0 > worst.0 { own } else { worst });
                return Err(unmatched(&edges, worst.map_or(k, |(_, k)| k), members, near, what));
            };
            alone[j] = false;
            let (other, with) = &edges[open[j]];
            let pairs = found.first.into_iter().zip(found.second);
            ties.extend(
                pairs.map(|(first, second)| Tie { first: (*member, first), second: (*other, second) }),
            );
            // Two patches turned alike run along a common edge in opposite directions.
            let forward = edge.edge.runs_with_the_boundary() == with.edge.runs_with_the_boundary();
            meetings.push((*member, *other, forward == found.reversed));
        }
        Ok(Self { senses: turned(members, &meetings, what)?, ties })
    }

    /// The largest distance of an edge to the nearest other one, or its own extent where that is less (a pole).
    ///
    /// # Errors
    /// When a member says nothing of its edges, or may be torn.
    pub fn gap(members: &[Member<'_>], what: &str) -> Result<f64> {
        let edges = edges(members, what)?;
        let gap =
            |k: usize| nearest(&edges, k).map_or(f64::INFINITY, |n| n.distance).min(edges[k].1.spread());
        Ok((0..edges.len()).map(gap).fold(0.0, f64::max))
    }
}

/// The diagonal of the box around all control vertices.
fn size(members: &[Member<'_>]) -> f64 {
    let mut all = members.iter().flat_map(|member| member.shape.control_vertices());
    let Some(&first) = all.next() else { return 0.0 };
    let (low, high) = all.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// Walks from patch to patch and turns each like its neighbour.
fn turned(members: &[Member<'_>], meetings: &[(usize, usize, bool)], what: &str) -> Result<Vec<f64>> {
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); members.len()];
    for &(a, b, alike) in meetings {
        neighbours[a].push((b, alike));
        neighbours[b].push((a, alike));
    }
    let mut senses = vec![0.0; members.len()];
    for start in 0..members.len() {
        if senses[start] != 0.0 {
            continue;
        }
        senses[start] = 1.0;
        let mut todo = vec![start];
        while let Some(here) = todo.pop() {
            for &(next, alike) in &neighbours[here] {
                let wanted = if alike { senses[here] } else { -senses[here] };
                if senses[next] == 0.0 {
                    senses[next] = wanted;
                    todo.push(next);
                } else if senses[next] != wanted {
                    return Err(Error::Invalid(format!(
                        "{what}: {} and {} cannot be turned to one side: they bound no volume (like a Möbius strip)",
                        members[here].name, members[next].name
                    )));
                }
            }
        }
    }
    Ok(senses)
}

/// All edges, each with the member that has it.
fn edges(members: &[Member<'_>], what: &str) -> Result<Vec<(usize, EdgeCurve)>> {
    let mut all = Vec::new();
    for (k, member) in members.iter().enumerate() {
        let own = edges_of(member.shape, &format!("{what} of {}", member.name))?;
        if let Some(Tear { direction, at, repeated }) = torn(member.shape, what)? {
            let (name, direction) = (&member.name, ["u", "v"][direction.min(1)]);
            let why = repeated
                .map_or_else(String::new, |times| format!(", where the knot is repeated {times} times"));
            return Err(Error::Invalid(format!(
                "{what}: {name} may be torn at {direction} = {at}{why}; split it there"
            )));
        }
        for index in 0..own.count() {
            all.push((k, EdgeCurve::of(member.shape, index, what)?));
        }
    }
    Ok(all)
}

/// The other edge that an edge is nearest to, the largest distance of the edge from it, and its largest distance from
/// whatever is next to it there (sampled).
struct Neighbour {
    edge: usize,
    distance: f64,
    in_parts: f64,
}

/// Points evenly along a curve's parameters.
fn samples(curve: &Curve) -> Vec<Point> {
    const COUNT: usize = 16;
    let (a, b) = curve.domain();
    (0..=COUNT).filter_map(|i| curve.point(a + (b - a) * i as f64 / COUNT as f64).ok()).collect()
}

fn apart(curve: &Curve, point: Point) -> f64 {
    curve.closest(point).map_or(f64::INFINITY, |c| c.distance)
}

fn nearest(edges: &[(usize, EdgeCurve)], k: usize) -> Option<Neighbour> {
    let points = samples(&edges[k].1.curve);
    let mut least = vec![f64::INFINITY; points.len()];
    let mut best: Option<(f64, usize)> = None;
    for other in (0..edges.len()).filter(|&other| other != k) {
        let mut largest = 0.0_f64;
        for (p, least) in points.iter().zip(&mut least) {
            let apart = apart(&edges[other].1.curve, *p);
            (largest, *least) = (largest.max(apart), least.min(apart));
        }
        if best.is_none_or(|(distance, _)| largest < distance) {
            best = Some((largest, other));
        }
    }
    let in_parts = least.into_iter().fold(0.0, f64::max);
    best.map(|(distance, edge)| Neighbour { edge, distance, in_parts })
}

fn unmatched(edges: &[(usize, EdgeCurve)], k: usize, members: &[Member<'_>], near: f64, what: &str) -> Error {
    let label =
        |(member, edge): &(usize, EdgeCurve)| format!("{} of {}", edge.edge.called(), members[*member].name);
    let edge = label(&edges[k]);
    let Some(Neighbour { edge: other, distance, in_parts }) = nearest(edges, k) else {
        return Error::Invalid(format!("{what}: the boundary is open at {edge}; close it"));
    };
    if coincide(&edges[k].1, &edges[other].1, near).is_some() {
        let other = label(&edges[other]);
        return Error::Invalid(format!(
            "{what}: {edge} meets {other}, which meets another edge already: of the patches that meet there, two bound \
             a volume; leave the others out"
        ));
    }
    let goes_on = samples(&edges[other].1.curve).into_iter().any(|p| apart(&edges[k].1.curve, p) > near);
    let other = label(&edges[other]);
    Error::Invalid(if distance <= near && goes_on {
        format!(
            "{what}: {edge} meets only a part of {other}; split the patch of the latter where the former ends, so \
             that every edge meets one other all along"
        )
    } else if distance <= near {
        format!(
            "{what}: {edge} and {other} meet, but run through the same points with different parameters (more than \
             scaled or reversed) or weights, so that they would part; make one from the other's curve, or rebuild the patch"
        )
    } else if in_parts <= near {
        format!(
            "{what}: {edge} meets several edges, {other} among them; split its patch where they end, so that \
             every edge meets one other all along"
        )
    } else {
        format!(
            "{what}: the boundary is open: {edge} is {distance} away from the nearest other one, {other}; close \
             it, or name all of its patches in \"objects\"",
            distance = figure(distance)
        )
    })
}
