//! Closed boundaries made of surfaces: periodic ones, seams, poles, and patches that meet edge to edge.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::Stencil;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Conversion, Curve, Space, Surface};
use loftsman_kernel::{Point, Result};

use crate::contour::TOGETHER;
use crate::members::{extent, name_of, surface};
use crate::ties::Tie;

/// Surfaces that close: how each is turned, and which of their edges' points stay together.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shell {
    /// For each member: 1, or -1 where its `S_u × S_v` points to the other side than the first member's.
    pub(crate) senses: Vec<f64>,
    pub(crate) ties: Vec<Tie>,
}

const INSTEAD: &str = "a volume is bounded by surfaces; ask for its area, or its length";
const NAMES: [&str; 4] = ["u0", "u1", "v0", "v1"];

/// One edge of a member, as a curve along it whose control vertices are combinations of the surface's.
struct EdgeCurve {
    member: usize,
    /// In the order of [`NAMES`].
    side: usize,
    curve: Curve,
    stencils: Vec<Stencil>,
}

/// Two edges that are one curve, in one space: their vertices in pairs.
struct Match {
    first: Vec<Stencil>,
    second: Vec<Stencil>,
    /// Whether the second runs the other way.
    reversed: bool,
}

impl Shell {
    /// # Errors
    /// When a member is not a surface, an edge meets no other, or the surfaces cannot be turned to one side.
    pub(crate) fn find(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Self> {
        let (_, size) = extent(shapes, members)?;
        let near = TOGETHER * size;
        let edges = edges(shapes, members, what)?;
        let mut ties = Vec::new();
        let mut meetings = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        for (k, edge) in edges.iter().enumerate() {
            if spread(edge.curve.points()) <= near {
                let shape = members[edge.member].shape;
                let pairs = edge.stencils.windows(2);
                ties.extend(
                    pairs.map(|p| Tie { first: (shape, p[1].clone()), second: (shape, p[0].clone()) }),
                );
            } else {
                open.push(k);
            }
        }
        // Edges that are one have one middle (or are closed): in the order of its x, partners are near one another.
        let middles: Vec<Option<Point>> = edges.iter().map(|edge| middle(&edge.curve, near)).collect();
        let place = |k: usize| middles[k].map_or(f64::NEG_INFINITY, |m| m.x);
        open.sort_by(|&a, &b| place(a).total_cmp(&place(b)));
        let mut alone = vec![true; open.len()];
        for at in 0..open.len() {
            if !std::mem::take(&mut alone[at]) {
                continue;
            }
            let (k, edge) = (open[at], &edges[open[at]]);
            let candidates = (at + 1..open.len()).take_while(|&j| place(open[j]) <= place(k) + near);
            let found = candidates.filter(|&j| alone[j]).find_map(|j| {
                let apart = match (middles[k], middles[open[j]]) {
                    (Some(a), Some(b)) => (b - a).norm() > near,
                    (a, b) => a.is_some() != b.is_some(),
                };
                let found = if apart { None } else { lies_on(edge, &edges[open[j]], near) };
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
            let other = &edges[open[j]];
            let (a, b) = (members[edge.member].shape, members[other.member].shape);
            let pairs = found.first.into_iter().zip(found.second);
            ties.extend(pairs.map(|(first, second)| Tie { first: (a, first), second: (b, second) }));
            // Around a patch its edges run v0, u1, -v1, -u0; two patches turned alike run along a common edge in
            // opposite directions.
            let forward = |side: usize| side == 1 || side == 2;
            let alike = (forward(edge.side) == forward(other.side)) == found.reversed;
            meetings.push((edge.member, other.member, alike));
        }
        Ok(Self { senses: turned(members, &meetings, what)?, ties })
    }

    /// The largest distance of an edge to the nearest other one, or its own extent where that is less (a pole).
    pub(crate) fn gap(shapes: &Shapes<'_>, members: &[On]) -> Result<f64> {
        let edges = edges(shapes, members, "gap")?;
        let gap = |k: usize| {
            nearest(&edges, k).map_or(f64::INFINITY, |n| n.distance).min(spread(edges[k].curve.points()))
        };
        Ok((0..edges.len()).map(gap).fold(0.0, f64::max))
    }
}

/// Walks from patch to patch and turns each like its neighbour.
fn turned(members: &[On], meetings: &[(usize, usize, bool)], what: &str) -> Result<Vec<f64>> {
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
                        name_of(&members[here]),
                        name_of(&members[next])
                    )));
                }
            }
        }
    }
    Ok(senses)
}

fn edges(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Vec<EdgeCurve>> {
    let mut all = Vec::new();
    for (member, on) in members.iter().enumerate() {
        let own = surface(shapes, on, what, INSTEAD)?;
        for (space, direction) in [(own.u(), "u"), (own.v(), "v")] {
            let breaks = space.breakpoints();
            let torn = breaks[1..breaks.len() - 1].iter().find(|&&t| space.multiplicity(t) > space.degree());
            if let Some(t) = torn {
                return Err(Error::Invalid(format!(
                    "{what}: {} may be torn at {direction} = {t}, where the knot is repeated {} times; split it there",
                    name_of(on),
                    space.multiplicity(*t)
                )));
            }
        }
        for side in 0..4 {
            let across = if side < 2 { own.u() } else { own.v() };
            if !across.is_periodic() {
                all.push(edge(own, member, side)?);
            }
        }
    }
    Ok(all)
}

/// The edge's curve: for a rational surface its weights are `W_j = Σ N_i w_ij` and its vertices `Σ N_i w_ij P_ij / W_j`.
fn edge(own: &Surface, member: usize, side: usize) -> Result<EdgeCurve> {
    let along_u = side >= 2;
    let (run, across) = if along_u { (own.u(), own.v()) } else { (own.v(), own.u()) };
    let (a, b) = across.domain();
    let at = if side.is_multiple_of(2) { a } else { b };
    let span = across.span(at);
    let mut row = [0.0; MAX_ORDER];
    across.basis_into(span, at, 0, &mut row);
    let columns = own.v().len();
    let mut stencils = Vec::with_capacity(run.len());
    let mut weights = Vec::with_capacity(run.len());
    for j in 0..run.len() {
        let first = span - across.degree();
        let terms = row[..=across.degree()].iter().enumerate().filter(|(_, n)| **n != 0.0).map(|(k, n)| {
            let i = across.vertex(first + k);
            let vertex = if along_u { j * columns + i } else { i * columns + j };
            (vertex, n * own.weights().map_or(1.0, |w| w[vertex]))
        });
        let stencil: Stencil = terms.collect();
        let weight: f64 = stencil.coefficients().iter().sum();
        stencils.push(stencil.scaled(1.0 / weight));
        weights.push(weight);
    }
    let points: Vec<Point> = stencils.iter().map(|s| Point::from(s.apply(own.points()))).collect();
    let weights = own.weights().is_some().then_some(weights);
    Ok(EdgeCurve { member, side, curve: Curve::build(run.clone(), points, weights)?, stencils })
}

/// The diagonal of the box around some points.
fn spread(points: &[Point]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// The point in the middle of a curve's parameters, wherever they run from; none of a closed curve, which may start anywhere.
fn middle(curve: &Curve, near: f64) -> Option<Point> {
    let (a, b) = curve.domain();
    let (start, end) = (curve.point(a).ok()?, curve.point(b).ok()?);
    if curve.is_periodic() || (end - start).norm() <= near {
        None
    } else {
        curve.point(0.5 * a + 0.5 * b).ok()
    }
}

impl EdgeCurve {
    /// The edge in another space: of a rational one, `c_i W_i / Σ c_i W_i` of each stencil.
    fn converted(&self, conversion: &Conversion) -> Result<Self> {
        let weight = |i: usize| self.curve.weights().map_or(1.0, |w| w[i]);
        let row = |k: usize| -> Stencil {
            let total: f64 = conversion.row(k).map(|(i, c)| c * weight(i)).sum();
            let terms = conversion.row(k).filter(|(_, c)| *c != 0.0);
            let terms = terms.map(|(i, c)| (i, c * weight(i) / total));
            terms.flat_map(|(i, share)| self.stencils[i].iter().map(move |(v, c)| (v, share * c))).collect()
        };
        Ok(Self {
            curve: self.curve.convert(conversion)?,
            stencils: (0..conversion.to().len()).map(row).collect(),
            ..*self
        })
    }

    fn through(&self, steps: &[Conversion]) -> Result<Self> {
        let mut edge = Self { curve: self.curve.clone(), stencils: self.stencils.clone(), ..*self };
        for step in steps {
            edge = edge.converted(step)?;
        }
        Ok(edge)
    }
}

/// Whether two edges are one curve, run either way with parameters that differ by scale and shift, and closed ones from
/// anywhere: in the space that holds both, their weights are proportional and their vertices the same to `near`. The ties of
/// these vertices keep them one, however the edges' own knots and degrees differ.
fn lies_on(first: &EdgeCurve, second: &EdgeCurve, near: f64) -> Option<Match> {
    if first.curve.is_periodic() && !second.curve.is_periodic() {
        let Match { first, second, reversed } = lies_on(second, first, near)?;
        return Some(Match { first: second, second: first, reversed });
    }
    let reversed = second.converted(&second.curve.space().reversing().ok()?).ok()?;
    let mut candidates = vec![(second, false), (&reversed, true)];
    // A periodic curve starts where the other one does.
    let mut turned = Vec::new();
    for &(edge, reversed) in &candidates {
        if edge.curve.is_periodic()
            && let Some(turned_edge) = starting(edge, first.curve.point(first.curve.domain().0).ok()?)
        {
            turned.push((turned_edge, reversed));
        }
    }
    candidates.extend(turned.iter().map(|(edge, reversed)| (edge, *reversed)));
    candidates.into_iter().find_map(|(second, reversed)| {
        let (first, second) = if same(first.curve.space(), second.curve.space()) {
            (first.through(&[]).ok()?, second.through(&[]).ok()?)
        } else {
            let second = snapped(second, first.curve.space())?;
            let common = first.curve.space().common(second.curve.space()).ok()?;
            (first.through(&common.first).ok()?, second.through(&common.second).ok()?)
        };
        let pairs = first.curve.points().iter().zip(second.curve.points());
        let together = pairs.into_iter().all(|(a, b)| (a - b).norm() <= near);
        (together && proportional(&first.curve, &second.curve)).then_some(Match {
            first: first.stencils,
            second: second.stencils,
            reversed,
        })
    })
}

/// The edge over another space's domain, its knots on those of that space where they are nearly there: else the spans between
/// them, made of nothing but rounding, would ask for ties that say nearly the same.
fn snapped(edge: &EdgeCurve, to: &Space) -> Option<EdgeCurve> {
    let (a, b) = to.domain();
    let moved = edge.converted(&edge.curve.space().reparametrising(a, b).ok()?).ok()?;
    let (targets, slack) = (to.breakpoints(), TOGETHER * (b - a));
    let nearest = |&k: &f64| {
        let at = targets.partition_point(|&t| t < k - slack);
        targets.get(at).filter(|&&t| t <= k + slack).copied().unwrap_or(k)
    };
    let space = moved.curve.space();
    let knots: Vec<f64> = space.knots().iter().map(nearest).collect();
    let p = space.degree();
    let space = if space.is_periodic() { Space::periodic(p, knots) } else { Space::open(p, knots) }.ok()?;
    let (_, points, weights) = moved.curve.into_parts();
    Some(EdgeCurve { curve: Curve::build(space, points, weights).ok()?, ..moved })
}

/// A periodic edge opened where it is nearest to a point.
fn starting(edge: &EdgeCurve, point: Point) -> Option<EdgeCurve> {
    let space = edge.curve.space();
    let found = edge.curve.closest(point).ok()?.at;
    // Where that is a knot but for rounding, it is the knot.
    let slack = TOGETHER * space.length();
    let start = space.breakpoints().into_iter().find(|k| (k - found).abs() <= slack).unwrap_or(found);
    edge.converted(&space.restricting(start, start + space.length()).ok()?).ok()
}

/// Whether two spaces are the same but for where their domains lie.
fn same(a: &Space, b: &Space) -> bool {
    let relative = |space: &Space, k: f64| (k - space.domain().0) / space.length();
    a.degree() == b.degree()
        && a.is_periodic() == b.is_periodic()
        && a.len() == b.len()
        && a.flat().iter().zip(b.flat()).all(|(x, y)| (relative(a, *x) - relative(b, *y)).abs() <= TOGETHER)
}

fn proportional(a: &Curve, b: &Curve) -> bool {
    let weight = |curve: &Curve, i: usize| curve.weights().map_or(1.0, |w| w[i]);
    let factor = weight(a, 0) / weight(b, 0);
    (0..a.points().len()).all(|i| {
        let (x, y) = (weight(a, i), factor * weight(b, i));
        (x - y).abs() <= TOGETHER * x
    })
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

fn nearest(edges: &[EdgeCurve], k: usize) -> Option<Neighbour> {
    let points = samples(&edges[k].curve);
    let mut least = vec![f64::INFINITY; points.len()];
    let mut best: Option<(f64, usize)> = None;
    for other in (0..edges.len()).filter(|&other| other != k) {
        let mut largest = 0.0_f64;
        for (p, least) in points.iter().zip(&mut least) {
            let apart = apart(&edges[other].curve, *p);
            (largest, *least) = (largest.max(apart), least.min(apart));
        }
        if best.is_none_or(|(distance, _)| largest < distance) {
            best = Some((largest, other));
        }
    }
    let in_parts = least.into_iter().fold(0.0, f64::max);
    best.map(|(distance, edge)| Neighbour { edge, distance, in_parts })
}

fn unmatched(edges: &[EdgeCurve], k: usize, members: &[On], near: f64, what: &str) -> Error {
    let label = |edge: &EdgeCurve| format!("{} of {}", NAMES[edge.side], name_of(&members[edge.member]));
    let edge = label(&edges[k]);
    let Some(Neighbour { edge: other, distance, in_parts }) = nearest(edges, k) else {
        return Error::Invalid(format!("{what}: the boundary is open at the edge {edge}; close it"));
    };
    if lies_on(&edges[k], &edges[other], near).is_some() {
        let other = label(&edges[other]);
        return Error::Invalid(format!(
            "{what}: the edge {edge} meets {other}, which meets another edge already: of the patches that meet there, two bound \
             a volume; leave the others out"
        ));
    }
    let goes_on = samples(&edges[other].curve).into_iter().any(|p| apart(&edges[k].curve, p) > near);
    let other = label(&edges[other]);
    Error::Invalid(if distance <= near && goes_on {
        format!(
            "{what}: the edge {edge} meets only a part of {other}; split the patch of the latter where the former ends, so \
             that every edge meets one other all along"
        )
    } else if distance <= near {
        format!(
            "{what}: the edges {edge} and {other} meet, but run through the same points with different parameters (more than \
             scaled or reversed) or weights, so that they would part; make one from the other's curve, or rebuild the patch"
        )
    } else if in_parts <= near {
        format!(
            "{what}: the edge {edge} meets several edges, {other} among them; split its patch where they end, so that \
             every edge meets one other all along"
        )
    } else {
        format!(
            "{what}: the boundary is open: the edge {edge} is {distance:.3e} away from the nearest other one, {other}; close \
             it, or name all of its patches in \"objects\""
        )
    })
}
