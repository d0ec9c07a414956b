//! Closed boundaries made of surfaces: periodic ones, seams, poles, and patches that meet edge to edge.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::Stencil;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Curve, Space, Surface};
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

/// How an edge lies on another.
struct Match {
    distance: f64,
    /// For each vertex of the first edge, that of the second.
    vertices: Vec<usize>,
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
        while let Some(k) = open.pop() {
            let edge = &edges[k];
            let found = open.iter().enumerate().find_map(|(at, &other)| {
                lies_on(&edge.curve, &edges[other].curve).filter(|m| m.distance <= near).map(|m| (at, m))
            });
            let Some((at, found)) = found else {
                return Err(unmatched(&edges, k, members, near, what));
            };
            let other = &edges[open.remove(at)];
            let (a, b) = (members[edge.member].shape, members[other.member].shape);
            for (i, &j) in found.vertices.iter().enumerate() {
                ties.push(Tie {
                    first: (a, edge.stencils[i].clone()),
                    second: (b, other.stencils[j].clone()),
                });
            }
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
            nearest(&edges, k).map_or(f64::INFINITY, |(d, _)| d).min(spread(edges[k].curve.points()))
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

/// Whether two curves have the same space and weights, so that they are one where their vertices are; and how far these are
/// apart, run the way in which they are nearer. `None` where they differ.
fn lies_on(first: &Curve, second: &Curve) -> Option<Match> {
    let n = second.points().len();
    // The other way round, each vertex numbered by where it came from.
    let numbers: Vec<Point> = (0..n).map(|i| Point::new(i as f64, 0.0, 0.0)).collect();
    let numbered = Curve::new(second.space().clone(), numbers).ok()?.reverse().ok()?;
    let backwards: Vec<usize> = numbered.points().iter().map(|p| p.x.round() as usize).collect();
    let both =
        [(second.space().clone(), (0..n).collect(), false), (numbered.space().clone(), backwards, true)];
    let fitting = both.into_iter().filter_map(|(space, vertices, reversed)| {
        if !same(first.space(), &space) || !proportional(first, second, &vertices) {
            return None;
        }
        let apart = |(p, &j): (&Point, &usize)| (p - second.points()[j]).norm();
        let distance = first.points().iter().zip(&vertices).map(apart).fold(0.0, f64::max);
        Some(Match { distance, vertices, reversed })
    });
    fitting.reduce(|a, b| if b.distance < a.distance { b } else { a })
}

/// Whether two spaces are the same but for where their domains lie.
fn same(a: &Space, b: &Space) -> bool {
    let relative = |space: &Space, k: f64| (k - space.domain().0) / space.length();
    a.degree() == b.degree()
        && a.is_periodic() == b.is_periodic()
        && a.len() == b.len()
        && a.flat().iter().zip(b.flat()).all(|(x, y)| (relative(a, *x) - relative(b, *y)).abs() <= TOGETHER)
}

fn proportional(a: &Curve, b: &Curve, vertices: &[usize]) -> bool {
    let weight = |curve: &Curve, i: usize| curve.weights().map_or(1.0, |w| w[i]);
    let factor = weight(a, 0) / weight(b, vertices[0]);
    (0..vertices.len()).all(|i| {
        let (x, y) = (weight(a, i), factor * weight(b, vertices[i]));
        (x - y).abs() <= TOGETHER * x
    })
}

/// The other edge that an edge is nearest to, and the largest distance of the edge from it (sampled).
fn nearest(edges: &[EdgeCurve], k: usize) -> Option<(f64, usize)> {
    const SAMPLES: usize = 16;
    let own = &edges[k].curve;
    let (a, b) = own.domain();
    let points: Vec<Point> =
        (0..=SAMPLES).filter_map(|i| own.point(a + (b - a) * i as f64 / SAMPLES as f64).ok()).collect();
    let others = (0..edges.len()).filter(|&other| other != k);
    let measured = others.map(|other| {
        let apart = |p: &Point| edges[other].curve.closest(*p).map_or(f64::INFINITY, |c| c.distance);
        (points.iter().map(apart).fold(0.0, f64::max), other)
    });
    measured.reduce(|a, b| if b.0 < a.0 { b } else { a })
}

fn unmatched(edges: &[EdgeCurve], k: usize, members: &[On], near: f64, what: &str) -> Error {
    let label = |edge: &EdgeCurve| format!("{} of {}", NAMES[edge.side], name_of(&members[edge.member]));
    let edge = &edges[k];
    Error::Invalid(match nearest(edges, k) {
        Some((distance, other)) if distance <= near => format!(
            "{what}: the edges {} and {} meet, but have other knots or weights, so that they would part; refine or elevate \
             one so that they match",
            label(edge),
            label(&edges[other])
        ),
        Some((distance, other)) => format!(
            "{what}: the boundary is open: the edge {} is {distance:.3e} away from the nearest other one, {}; close it, or \
             name all of its patches in \"objects\"",
            label(edge),
            label(&edges[other])
        ),
        None => format!("{what}: the boundary is open at the edge {}; close it", label(edge)),
    })
}
