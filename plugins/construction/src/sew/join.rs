//! Vertices that are one, edges that run through a vertex, edges that are one.

use std::collections::{BTreeMap, HashMap};

use loftsman_kernel::Point;
use loftsman_kernel::brep::{Edge, Parts, Use};
use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::trimmed::ParameterCurve;

use super::gather::{Healed, extent};
use super::twice;

/// Edges are compared at so many places of each span, and at no more than so many.
const PLACES: usize = 8;
const MOST: usize = 400;

/// What became of open edges.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// How many pairs of edges became one.
    pub(super) edges: usize,
    /// The widest gap between two of them that was found.
    pub(super) gap: f64,
    /// How many edges were cut at a vertex of another.
    pub(super) cut: usize,
    /// How many faces lay on others, and were left out.
    pub(super) twice: usize,
}

/// How often each edge is used.
pub(super) fn uses(parts: &Parts) -> Vec<usize> {
    let mut counts = vec![0; parts.edges.len()];
    parts.faces.iter().flat_map(|face| face.loops.iter().flatten()).for_each(|one| counts[one.edge] += 1);
    counts
}

/// The open edges: those that one loop has, once.
pub(super) fn open(parts: &Parts) -> Vec<usize> {
    let counts = uses(parts);
    (0..counts.len()).filter(|&edge| counts[edge] == 1).collect()
}

/// The part of its curve that an edge is.
pub(super) fn segment(edge: &Edge) -> Result<Curve> {
    let whole = edge.range == edge.curve.domain() && edge.curve.is_clamped();
    if whole { Ok(edge.curve.clone()) } else { edge.curve.between(edge.range.0, edge.range.1) }
}

/// Makes open edges one that are within `near` of one another. About `O(n log n)` in their number where few lie near one another.
///
/// # Errors
/// When an evaluation overflows.
pub(super) fn join(parts: &mut Parts, near: f64, healed: &mut Healed) -> Result<Joined> {
    let mut joined = Joined::default();
    merge_vertices(parts, near);
    drop_short(parts, near, healed)?;
    cut_edges(parts, near, &mut joined)?;
    joined.twice = twice::drop(parts, near)?;
    pair_edges(parts, near, &mut joined)?;
    parts.drop_unused();
    Ok(joined)
}

/// Vertices of open edges within the tolerance of one another become the first of them.
fn merge_vertices(parts: &mut Parts, near: f64) {
    let mut is_open = vec![false; parts.vertices.len()];
    for edge in open(parts) {
        parts.edges[edge].ends.iter().for_each(|&end| is_open[end] = true);
    }
    // Cells beyond what can be counted are one: what lies there is compared all the same.
    const LAST: f64 = (1_i64 << 60) as f64;
    let cell = |p: &Point| [p.x, p.y, p.z].map(|c| (c / near).floor().clamp(-LAST, LAST) as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut now: Vec<usize> = (0..parts.vertices.len()).collect();
    for vertex in (0..is_open.len()).filter(|&vertex| is_open[vertex]) {
        let point = parts.vertices[vertex].point;
        let [x, y, z] = cell(&point);
        let around = (0..27_i64).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
        let found = around.filter_map(|key| cells.get(&key)).flatten().copied();
        let first = found
            .map(|other| ((parts.vertices[other].point - point).norm(), other))
            .filter(|(distance, _)| *distance <= near)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match first {
            Some((distance, first)) => {
                now[vertex] = first;
                let reach = distance + parts.vertices[vertex].tolerance;
                let known = &mut parts.vertices[first].tolerance;
                *known = known.max(reach);
            }
            None => cells.entry(cell(&point)).or_default().push(vertex),
        }
    }
    for edge in &mut parts.edges {
        edge.ends = edge.ends.map(|end| now[end]);
    }
    for face in &mut parts.faces {
        face.points.iter_mut().for_each(|vertex| *vertex = now[*vertex]);
    }
}

/// Open edges that end where they start and are no longer than the tolerance are none.
fn drop_short(parts: &mut Parts, near: f64, healed: &mut Healed) -> Result<()> {
    let mut drop = vec![false; parts.edges.len()];
    for edge in open(parts) {
        let [start, end] = parts.edges[edge].ends;
        if start != end {
            continue;
        }
        let long = extent(&segment(&parts.edges[edge])?);
        if long <= near {
            drop[edge] = true;
            healed.left_out(long, near);
        }
    }
    parts.faces.retain_mut(|face| {
        // Without loops it is the whole of a surface that closes.
        let is_whole = face.loops.is_empty();
        face.loops.iter_mut().for_each(|uses| uses.retain(|one| !drop[one.edge]));
        face.loops.retain(|uses| !uses.is_empty());
        // What has no other border is no larger than the tolerance.
        is_whole || !face.loops.is_empty()
    });
    Ok(())
}

/// Where an edge is cut: at which parameter of its curve, at which vertex, and how far from that.
struct Cut {
    at: f64,
    vertex: usize,
    distance: f64,
}

/// Cuts open edges where a vertex of another one lies on them.
fn cut_edges(parts: &mut Parts, near: f64, joined: &mut Joined) -> Result<()> {
    let open = open(parts);
    let mut vertices: Vec<usize> = open.iter().flat_map(|&edge| parts.edges[edge].ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let place = |vertex: usize| parts.vertices[vertex].point;
    vertices.sort_by(|&a, &b| place(a).x.total_cmp(&place(b).x).then(a.cmp(&b)));
    let mut cuts: Vec<(usize, Vec<Cut>)> = Vec::new();
    for &edge in &open {
        let curve = segment(&parts.edges[edge])?;
        let ends = parts.edges[edge].ends;
        let (low, high) = curve.hull_bounds();
        let inside = |p: &Point| (0..3).all(|k| p[k] >= low[k] - near && p[k] <= high[k] + near);
        let start = vertices.partition_point(|&vertex| place(vertex).x < low.x - near);
        let mut found: Vec<Cut> = Vec::new();
        for &vertex in vertices[start..].iter().take_while(|&&vertex| place(vertex).x <= high.x + near) {
            let point = place(vertex);
            if ends.contains(&vertex) || !inside(&point) {
                continue;
            }
            let foot = curve.closest(point)?;
            let (from, to) = parts.edges[edge].range;
            if foot.distance <= near && from < foot.at && foot.at < to {
                found.push(Cut { at: foot.at, vertex, distance: foot.distance });
            }
        }
        found.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.vertex.cmp(&b.vertex)));
        found.dedup_by(|a, b| a.at == b.at);
        if !found.is_empty() {
            cuts.push((edge, found));
        }
    }
    let mut became: HashMap<usize, Vec<usize>> = HashMap::new();
    for (edge, found) in cuts {
        let whole = parts.edges[edge].clone();
        let (mut from, mut start, mut list) = (whole.range.0, whole.ends[0], Vec::new());
        let stops = found.iter().map(|cut| (cut.at, cut.vertex));
        for (to, end) in stops.chain([(whole.range.1, whole.ends[1])]) {
            list.push(parts.edges.len());
            parts.edges.push(Edge { range: (from, to), ends: [start, end], ..whole.clone() });
            (from, start) = (to, end);
        }
        for Cut { vertex, distance, .. } in found {
            let known = &mut parts.vertices[vertex].tolerance;
            *known = known.max(distance);
            joined.cut += 1;
        }
        became.insert(edge, list);
    }
    let edges = &parts.edges;
    for face in &mut parts.faces {
        let surface = &face.surface;
        for uses in &mut face.loops {
            if uses.iter().all(|one| !became.contains_key(&one.edge)) {
                continue;
            }
            let mut all = Vec::with_capacity(uses.len());
            for one in uses.drain(..) {
                let Some(list) = became.get(&one.edge) else {
                    all.push(one);
                    continue;
                };
                let mut pieces: Vec<Use> = list
                    .iter()
                    .map(|&edge| {
                        let parameters = one.parameters.as_ref();
                        let parameters =
                            parameters.and_then(|whole| part_of(whole, &edges[edge], surface, near));
                        Use { edge, reversed: one.reversed, parameters }
                    })
                    .collect();
                if one.reversed {
                    pieces.reverse();
                }
                all.extend(pieces);
            }
            *uses = all;
        }
    }
    Ok(())
}

/// The part of a parameter curve that belongs to a part of its edge, where both run at the same speed; what has none is computed where it is needed.
fn part_of(
    whole: &ParameterCurve,
    edge: &Edge,
    surface: &loftsman_kernel::spline::Surface,
    near: f64,
) -> Option<ParameterCurve> {
    let (from, to) = edge.range;
    let part = ParameterCurve::new(whole.curve().clone(), from, to).ok()?;
    let same = [from, 0.5 * (from + to), to].into_iter().all(|t| {
        let (Ok(at), Ok(p)) = (whole.curve().point(t), edge.curve.point(t)) else { return false };
        surface.point(at.x, at.y).is_ok_and(|q| (p - q).norm() <= near.max(edge.tolerance))
    });
    same.then_some(part)
}

/// Edges that may be one.
struct Pair {
    gap: f64,
    edges: [usize; 2],
    opposite: bool,
}

fn pair_edges(parts: &mut Parts, near: f64, joined: &mut Joined) -> Result<()> {
    let mut between: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for edge in open(parts) {
        let mut ends = parts.edges[edge].ends;
        ends.sort_unstable();
        between.entry(ends).or_default().push(edge);
    }
    let mut into: HashMap<usize, (usize, bool)> = HashMap::new();
    for edges in between.values().filter(|edges| edges.len() > 1) {
        let curves = edges.iter().map(|&edge| segment(&parts.edges[edge])).collect::<Result<Vec<_>>>()?;
        let boxes: Vec<(Point, Point)> = curves.iter().map(Curve::hull_bounds).collect();
        let mut pairs = Vec::new();
        for (i, a) in curves.iter().enumerate() {
            for (j, b) in curves.iter().enumerate().skip(i + 1) {
                let apart =
                    |k: usize| boxes[i].0[k] > boxes[j].1[k] + near || boxes[j].0[k] > boxes[i].1[k] + near;
                if (0..3).any(apart) {
                    continue;
                }
                let gap = match distance(a, b, near)? {
                    None => continue,
                    Some(one) => match distance(b, a, near)? {
                        None => continue,
                        Some(other) => one.max(other),
                    },
                };
                let (one, other) = (&parts.edges[edges[i]], &parts.edges[edges[j]]);
                let opposite =
                    if one.ends[0] == one.ends[1] { runs_back(a, b)? } else { one.ends != other.ends };
                pairs.push(Pair { gap, edges: [edges[i], edges[j]], opposite });
            }
        }
        // The nearest first; each edge once.
        pairs.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.edges.cmp(&b.edges)));
        let mut taken = Vec::new();
        for Pair { gap, edges: [one, other], opposite } in pairs {
            if taken.contains(&one) || taken.contains(&other) {
                continue;
            }
            taken.extend([one, other]);
            let tolerance = parts.edges[other].tolerance.max(gap);
            let known = &mut parts.edges[one].tolerance;
            *known = known.max(tolerance);
            into.insert(other, (one, opposite));
            joined.edges += 1;
            joined.gap = joined.gap.max(gap);
        }
    }
    for one in parts.faces.iter_mut().flat_map(|face| face.loops.iter_mut().flatten()) {
        if let Some(&(edge, opposite)) = into.get(&one.edge) {
            one.edge = edge;
            if opposite {
                one.reversed = !one.reversed;
                one.parameters = one.parameters.take().and_then(|whole| turned(&whole));
            }
        }
    }
    Ok(())
}

/// How far the places of a curve are from another at most; `None` where that is more than the tolerance.
fn distance(a: &Curve, b: &Curve, near: f64) -> Result<Option<f64>> {
    let (from, to) = a.domain();
    let count = (PLACES * a.space().spans().count()).min(MOST);
    let (start, end) = b.domain();
    let mut most = 0.0_f64;
    let mut last = None;
    for k in 0..=count {
        let share = k as f64 / count as f64;
        let point = a.point(from + (to - from) * share)?;
        // From the foot of the place before, or from the ends: a foot within the tolerance is one that counts. Else all of the curve is looked at.
        let starts = last.map_or([start, end], |t| [t, t]);
        let mut found = None;
        for t in starts {
            let foot = downhill(b, point, t)?;
            if found.is_none_or(|(_, away)| foot.1 < away) {
                found = Some(foot);
            }
        }
        let (at, away) = match found.filter(|(_, away)| *away <= near) {
            Some(found) => found,
            None => {
                let closest = b.closest(point)?;
                (closest.at, closest.distance)
            }
        };
        if away > near {
            return Ok(None);
        }
        last = Some(at);
        most = most.max(away);
    }
    Ok(Some(most))
}

/// Steps from a place of a curve to the foot of a point near it.
const STEPS: usize = 16;

/// A place of a curve that is as near to a point as those around it, from a place near it: Gauss and Newton's steps, halved until they lead nearer. Its
/// parameter, and how far it is.
fn downhill(curve: &Curve, point: Point, from: f64) -> Result<(f64, f64)> {
    let (start, end) = curve.domain();
    let mut d = [loftsman_kernel::Vector::zeros(); 2];
    curve.derivatives_into(from, &mut d)?;
    let (mut t, mut away) = (from, (point.coords - d[0]).norm());
    for _ in 0..STEPS {
        let squared = d[1].norm_squared();
        if squared == 0.0 {
            break;
        }
        let mut step = d[1].dot(&(point.coords - d[0])) / squared;
        let mut nearer = false;
        for _ in 0..6 {
            let next = (t + step).clamp(start, end);
            let mut there = d;
            curve.derivatives_into(next, &mut there)?;
            let distance = (point.coords - there[0]).norm();
            if next != t && distance < away {
                (t, away, d, nearer) = (next, distance, there, true);
                break;
            }
            step *= 0.5;
        }
        if !nearer || step.abs() <= 1e-15 * (end - start) {
            break;
        }
    }
    Ok((t, away))
}

/// Whether a closed curve runs against another that starts where it does.
fn runs_back(a: &Curve, b: &Curve) -> Result<bool> {
    let (from, to) = a.domain();
    let at = |share: f64| -> Result<f64> { Ok(b.closest(a.point(from + (to - from) * share)?)?.at) };
    Ok(at(1.0 / 3.0)? > at(2.0 / 3.0)?)
}

/// A parameter curve run through from its end.
fn turned(whole: &ParameterCurve) -> Option<ParameterCurve> {
    let (start, end) = whole.curve().domain();
    let (from, to) = whole.range();
    ParameterCurve::new(whole.curve().reverse().ok()?, start + end - to, start + end - from).ok()
}
