//! What a shape promises: stencils, and each further thing that it says it can do.

use super::holes::holes;
use super::nets::nets;
use super::{Lcg, Verdict, guarded};
use crate::error::Result;
use crate::shape::{
    BoundaryEdge, Cell, CellSide, Derivative, Location, Neighbours, Patch, Shape, Splines, Stencil, Strip,
    cells_of, strips,
};
use crate::spline::Product;
use crate::spline::gram::gauss_legendre;
use crate::spline::space::{MAX_ORDER, Space};

/// Cells, edges and vertices that are looked at, at most: some of many.
const SOME: usize = 48;

/// So much of its parameters the cells of a surface of many faces may leave out.
const LEFT_OUT: f64 = 1e-3;

/// Whether a shape is one, and everything that it says of itself true.
///
/// * *Stencils*: vertices that there are, ascending, finite coefficients; those of a position sum to 1, those of a derivative to 0;
///   derivatives agree with differences of those of one order less; what is outside the domain, or has another number of
///   parameters, is refused.
/// * *Cells* cover the domain (of a surface of many faces that of each, but for a thousandth) once; each names all vertices that its points depend on, and no others; where it is not rational its
///   functions are polynomials of its degree. *Holes*, where it says any, are all that they leave out, each with a border along which it is a
///   polynomial. Where it says that they are of tensor-product splines, these have its stencils. *Nets*, where it says any, are those of all cells, and the patches that its stencils are there. Where it says that
///   cells always meet they do.
/// * *Edges*: stencils along them are those of their strips.
/// * *Neighbours* are mutual; a grid has as many places as there are vertices.
/// * *Refined* it is the same shape, with more vertices, and cells end where they were asked to.
///
/// What it does not say is not asked.
pub fn shape_conformance(shape: &dyn Shape) -> Verdict {
    guarded(|verdict| {
        let mut random = Lcg::new(7);
        vertices(verdict, shape);
        stencils(verdict, shape, &mut random)?;
        if shape.cells().is_some() {
            cells(verdict, shape, &mut random)?;
        }
        if shape.edges().is_some() {
            edges(verdict, shape)?;
        }
        neighbours(verdict, shape);
        if shape.refine().is_some() {
            refine(verdict, shape, &mut random)?;
        }
        Some(())
    })
}

fn vertices(verdict: &mut Verdict, shape: &dyn Shape) {
    let count = shape.control_vertices().len();
    let mut copy = shape.boxed();
    verdict.check(copy.control_vertices_mut().len() == count, || {
        "it has not as many control vertices to move as to look at".into()
    });
    verdict.check(copy.control_vertices() == shape.control_vertices(), || "its copy is another shape".into());
    let domain = shape.domain();
    let sound =
        domain.iter().all(|side| side.start.is_finite() && side.end.is_finite() && side.start < side.end);
    verdict.check((1..=2).contains(&domain.len()) && sound, || format!("its domain is {domain:?}"));
    if let Some(grid) = shape.grid() {
        verdict.check(grid.rows.checked_mul(grid.columns) == Some(count), || {
            format!("it has {count} control vertices in a grid of {} × {}", grid.rows, grid.columns)
        });
    }
}

/// Some of many, evenly.
pub(super) fn some<T>(all: Vec<T>) -> Vec<T> {
    let step = all.len().div_ceil(SOME).max(1);
    all.into_iter().step_by(step).collect()
}

/// The cells to look at; the whole domain as one where there are none.
fn pieces(shape: &dyn Shape) -> Vec<Cell> {
    if let Ok(cells) = cells_of(shape, "a check").and_then(|cells| cells.checked(shape)) {
        return some(cells);
    }
    let side = |side: &crate::shape::Interval| CellSide { start: side.start, end: side.end, degree: 3 };
    vec![Cell { sides: shape.domain().iter().map(side).collect(), ..Cell::default() }]
}

fn share(random: &mut Lcg) -> f64 {
    0.5 + 0.45 * random.next()
}

/// The sum of the sizes of a stencil's coefficients.
fn size(stencil: &Stencil) -> f64 {
    stencil.coefficients().iter().map(|c| c.abs()).sum()
}

/// The size of what two stencils differ by.
pub(super) fn apart(a: &Stencil, b: &Stencil, by: f64) -> f64 {
    size(&a.iter().chain(b.iter().map(|(v, c)| (v, -by * c))).collect())
}

fn stencils(verdict: &mut Verdict, shape: &dyn Shape, random: &mut Lcg) -> Option<()> {
    let (count, parameters) = (shape.control_vertices().len(), shape.domain().len());
    for cell in pieces(shape) {
        let shares = [share(random), share(random)];
        let at = cell.at(shares);
        let row = |by: [usize; 2]| shape.stencil(at, Derivative::from(by));
        let orders: &[[usize; 2]] = if parameters == 1 {
            &[[0, 0], [1, 0], [2, 0], [3, 0]]
        } else {
            &[[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2]]
        };
        for &order in orders {
            let stencil =
                verdict.take(row(order), |e| format!("no stencil of order {order:?} at {at}: {e}"))?;
            let sound = stencil.iter().all(|(v, c)| v < count && c.is_finite());
            verdict.check(sound && stencil.vertices().windows(2).all(|v| v[0] < v[1]), || {
                format!("the stencil of order {order:?} at {at} is not one: {stencil:?}")
            });
            let sum: f64 = stencil.coefficients().iter().sum();
            let wanted = if order == [0, 0] { 1.0 } else { 0.0 };
            verdict.check((sum - wanted).abs() <= 1e-9 * size(&stencil).max(1.0), || {
                format!("the stencil of order {order:?} at {at} sums to {sum}, and not to {wanted}")
            });
            let direct = shape.value(at, Derivative::from(order)).ok();
            let value = stencil.apply(shape.control_vertices());
            let reach = shape.control_vertices().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
            verdict
                .check(direct.is_some_and(|v| (v - value).amax() <= 1e-9 * reach * size(&stencil)), || {
                    format!("its value of order {order:?} at {at} is not its stencil's")
                });
            if order != [0, 0] {
                differences(verdict, shape, &cell, shares, order, &stencil);
            }
        }
        let other = match at {
            Location::Curve(u) => Location::Surface(u, u),
            _ => Location::Curve(0.5),
        };
        verdict.check(shape.stencil(other, Derivative::POSITION).is_err(), || {
            format!("it takes {other}, which has another number of parameters than it")
        });
    }
    outside(verdict, shape);
    Some(())
}

/// Whether a derivative is the limit of differences of the one before.
fn differences(
    verdict: &mut Verdict,
    shape: &dyn Shape,
    cell: &Cell,
    shares: [f64; 2],
    order: [usize; 2],
    stencil: &Stencil,
) {
    const STEP: f64 = 1e-4;
    let k = usize::from(order[0] == 0);
    let mut lower = order;
    lower[k] -= 1;
    let Some(side) = cell.sides.get(k) else { return };
    let length = side.end - side.start;
    let beside = |step: f64| {
        let mut shares = shares;
        shares[k] += step;
        shape.stencil(cell.at(shares), Derivative::from(lower))
    };
    let (Ok(before), Ok(after)) = (beside(-STEP), beside(STEP)) else {
        verdict.check(false, || format!("no stencil of order {lower:?} in {cell:?}"));
        return;
    };
    let rate: Stencil = after.iter().chain(before.iter().map(|(v, c)| (v, -c))).collect();
    let rate = rate.scaled(1.0 / (2.0 * STEP * length));
    let by = (side.degree.max(1) as f64) / length;
    let scale = size(stencil).max(by * size(&before));
    let off = apart(stencil, &rate, 1.0);
    verdict.check(off <= 1e-3 * scale, || {
        format!("the stencil of order {order:?} in {cell:?} is not the rate of that of order {lower:?}: {off:.1e} off")
    });
}

/// What is outside the domain is refused, where a direction is not closed.
fn outside(verdict: &mut Verdict, shape: &dyn Shape) {
    let domain = shape.domain();
    if let Some(faces) = shape.faces() {
        let u = domain.first().map_or(0.0, |side| 0.5 * side.start + 0.5 * side.end);
        let beyond = u32::try_from(faces).unwrap_or(u32::MAX);
        let count = u32::try_from(shape.control_vertices().len()).unwrap_or(u32::MAX);
        for at in [Location::Surface(u, u), Location::Face(beyond, u, u), Location::Vertex(count)] {
            verdict.check(shape.stencil(at, Derivative::POSITION).is_err(), || {
                format!("it has a point at {at}, which is no place of it")
            });
        }
    }
    for (k, side) in domain.iter().enumerate().filter(|(_, side)| !side.periodic) {
        for at in
            [side.start - 0.1 * (side.end - side.start), side.end + 0.1 * (side.end - side.start), f64::NAN]
        {
            let mut place: Vec<f64> = domain.iter().map(|side| 0.5 * side.start + 0.5 * side.end).collect();
            place[k] = at;
            let location = match place[..] {
                [u, v, ..] if shape.faces().is_some() => Location::Face(0, u, v),
                [u, v, ..] => Location::Surface(u, v),
                _ => Location::Curve(at),
            };
            verdict.check(shape.stencil(location, Derivative::POSITION).is_err(), || {
                format!("it has a point at {location}, outside its domain")
            });
        }
    }
}

fn cells(verdict: &mut Verdict, shape: &dyn Shape, random: &mut Lcg) -> Option<()> {
    let all = cells_of(shape, "a check").and_then(|cells| cells.checked(shape));
    let all = verdict.take(all, |e| e.to_string())?;
    let area =
        |domain: crate::shape::Domain| domain.iter().map(|side| side.end - side.start).product::<f64>();
    let whole = match shape.faces() {
        Some(faces) => (0..faces as u32).map(|face| area(shape.face_domain(face))).sum(),
        None => area(shape.domain()),
    };
    let covered: f64 = all.iter().map(Cell::size).sum();
    // A surface of many faces may leave out what lies round vertices where it has infinitely many.
    let left_out = if shape.faces().is_some() { LEFT_OUT } else { 1e-9 };
    verdict.check(covered - whole <= 1e-9 * whole && whole - covered <= left_out * whole, || {
        format!("its cells have {covered} of parameters, and its domain {whole}")
    });
    holes(verdict, shape, shape.cells()?, [whole, covered])?;
    nets(verdict, shape, shape.cells()?, random)?;
    for _ in 0..SOME {
        let face = shape.faces().map(|count| random.below(count.max(1)) as u32);
        let domain = face.map_or_else(|| shape.domain(), |face| shape.face_domain(face));
        let place: Vec<f64> =
            domain.iter().map(|side| side.start + (side.end - side.start) * share(random)).collect();
        let inside = |cell: &Cell| cell.sides.iter().zip(&place).all(|(s, x)| (s.start..s.end).contains(x));
        let count = all.iter().filter(|cell| cell.face == face && inside(cell)).count();
        verdict.check(count == 1, || format!("{place:?} of face {face:?} is in {count} of its cells"));
    }
    for cell in some(all) {
        if shape.cells()?.always_meet() {
            meets(verdict, shape, &cell, share(random))?;
        }
        let stencil = shape.stencil(cell.at([share(random), share(random)]), Derivative::POSITION);
        let stencil = verdict.take(stencil, |e| format!("no point in {cell:?}: {e}"))?;
        if let Some(patch) = shape.cells()?.patch(cell.face) {
            let off = off_patch(shape, &cell, &patch, [share(random), share(random)]);
            let off = verdict.take(off, |e| format!("no point in {cell:?}: {e}"))?;
            verdict.check(off <= 1e-12, || {
                format!("{cell:?} is said to be of a tensor-product spline, and is {off:.1e} off it")
            });
        }
        let own: Vec<usize> = stencil.iter().filter(|(_, c)| *c != 0.0).map(|(v, _)| v).collect();
        verdict.check(own == cell.vertices[..], || {
            format!("{cell:?} depends on control vertices {own:?}, and not on those that it names")
        });
        if !cell.rational {
            for k in 0..cell.sides.len() {
                let off = beyond(shape, &cell, k, share(random));
                let off = verdict.take(off, |e| format!("no point in {cell:?}: {e}"))?;
                verdict.check(off <= 1e-8, || {
                    format!("{cell:?} is no polynomial of its degree in parameter {k}: {off:.1e} off")
                });
            }
        }
    }
    Some(())
}

/// How far the coefficients of a place are from those of the tensor-product spline that it is said to be on.
fn off_patch(shape: &dyn Shape, cell: &Cell, patch: &Patch<'_>, shares: [f64; 2]) -> Result<f64> {
    let at = cell.at(shares);
    let own = shape.stencil(at, Derivative::POSITION)?;
    let Splines { u, v, weights } = patch.splines;
    match (at, v) {
        (Location::Surface(s, t) | Location::Face(_, s, t), Some(v)) => {
            let product = Product { u, v, weights, first: patch.first };
            Ok(apart(&own, &product.stencil((s, t), Derivative::POSITION, None)?, 1.0))
        }
        // What a curve's stencils are is looked at with its cells.
        (Location::Curve(_), None) => Ok(0.0),
        _ => Ok(f64::INFINITY),
    }
}

/// Where it says that its cells always meet, a cell and what is before it do.
fn meets(verdict: &mut Verdict, shape: &dyn Shape, cell: &Cell, other: f64) -> Option<()> {
    const BESIDE: f64 = 1e-7;
    for (k, (side, domain)) in cell.sides.iter().zip(shape.domain()).enumerate() {
        if side.start <= domain.start {
            continue;
        }
        let beside = |share: f64| {
            let at = cell.at(if k == 0 { [share, other] } else { [other, share] });
            shape.stencil(at, Derivative::POSITION)
        };
        let [before, after] = [-BESIDE, BESIDE].map(beside);
        let before = verdict.take(before, |e| format!("no point before {cell:?}: {e}"))?;
        let after = verdict.take(after, |e| format!("no point in {cell:?}: {e}"))?;
        let off = apart(&before, &after, 1.0);
        verdict.check(off <= 1e-4, || {
            format!("it says that its cells always meet, and {cell:?} does not meet what is before it: {off:.1e} off")
        });
    }
    Some(())
}

/// By how much the stencils along a line of a cell differ, at a place beyond those that determine a polynomial of its degree,
/// from that polynomial.
fn beyond(shape: &dyn Shape, cell: &Cell, side: usize, other: f64) -> Result<f64> {
    let (nodes, _) = gauss_legendre(cell.sides[side].degree + 1);
    let at = |x: f64| {
        shape.stencil(cell.at(if side == 0 { [x, other] } else { [other, x] }), Derivative::POSITION)
    };
    let mut worst = 0.0_f64;
    for x in [0.03, 0.31, 0.77] {
        let weight = |k: usize| -> f64 {
            let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
            others.map(|(_, node)| (x - node) / (nodes[k] - node)).product()
        };
        let mut sum = Stencil::new();
        for (k, node) in nodes.iter().enumerate() {
            at(*node)?.iter().for_each(|(v, c)| sum.add(v, c * weight(k)));
        }
        worst = worst.max(apart(&at(x)?, &sum, 1.0));
    }
    Ok(worst)
}

fn edges(verdict: &mut Verdict, shape: &dyn Shape) -> Option<()> {
    let edges = shape.edges()?;
    for index in 0..edges.count() {
        let edge = edges.edge(index);
        verdict
            .check(edge.is_some(), || format!("it has {} edges, and none of number {index}", edges.count()));
        let edge = edge?;
        for corner in edge.corners() {
            verdict
                .take(shape.stencil(corner, Derivative::POSITION), |e| format!("{}: {e}", edge.called()))?;
        }
        let rational = shape.cells().is_some_and(|cells| cells.is_rational());
        let degree = shape.cells().map_or(1, |cells| cells.degrees()[usize::from(!edge.along_u)]);
        for order in 0..=if rational { 0 } else { degree.min(2) } {
            let all = verdict.take(strips(shape, index, order), |e| format!("{}: {e}", edge.called()))?;
            verdict.check(all.len() == order + 1, || format!("{} has {} strips", edge.called(), all.len()));
            let ends = all.iter().all(|strip| strip.space.domain() == (edge.start, edge.end));
            verdict
                .check(ends, || format!("the strips of {} run over another interval than it", edge.called()));
            strip_agrees(verdict, shape, &edge, order, all.last()?)?;
        }
    }
    verdict.check(edges.edge(edges.count()).is_none(), || "it has more edges than it says".into());
    Some(())
}

/// Whether a strip is the derivative across an edge, in the middle of some of its spans.
fn strip_agrees(
    verdict: &mut Verdict,
    shape: &dyn Shape,
    edge: &BoundaryEdge,
    order: usize,
    strip: &Strip,
) -> Option<()> {
    let space: &Space = &strip.space;
    for span in some(space.spans().collect()) {
        let t = 0.4 * space.flat()[span] + 0.6 * space.flat()[span + 1];
        let mut values = [0.0; MAX_ORDER];
        space.basis_into(span, t, 0, &mut values);
        let mut row = Stencil::new();
        for (k, value) in (span - space.degree()..=span).zip(values) {
            let own = strip.coefficients.get(space.vertex(k))?;
            own.iter().for_each(|(v, c)| row.add(v, c * value));
        }
        let found = shape.stencil(edge.at(t), edge.across(order));
        let found = verdict.take(found, |e| format!("{}: {e}", edge.called()))?;
        // A strip is that of `w S`: for positions the weights sum up to `w`.
        let weight: f64 = if order == 0 { row.coefficients().iter().sum() } else { 1.0 };
        let off = apart(&found, &row, 1.0 / weight);
        verdict.check(off <= 1e-8 * size(&found).max(1.0), || {
            format!("order {order} of {} at {t} is not its strip's: {off:.1e} off", edge.called())
        });
    }
    Some(())
}

fn neighbours(verdict: &mut Verdict, shape: &dyn Shape) {
    let grid = shape.grid();
    let net: &dyn Neighbours = match (shape.neighbours(), &grid) {
        (Some(net), _) => net,
        (None, Some(grid)) => grid,
        (None, None) => return,
    };
    let count = shape.control_vertices().len();
    for vertex in 0..count {
        let around = net.around(vertex);
        let sound =
            around.windows(2).all(|v| v[0] < v[1]) && around.iter().all(|&v| v < count && v != vertex);
        verdict.check(sound, || format!("the neighbours of control vertex {vertex} are {around:?}"));
        for &there in around.iter().filter(|&&v| v < count) {
            verdict.check(net.around(there).contains(&vertex), || {
                format!("control vertex {there} is next to {vertex}, but not the other way round")
            });
        }
    }
    verdict.check(net.around(count).is_empty(), || "a vertex that there is not has neighbours".into());
}

fn refine(verdict: &mut Verdict, shape: &dyn Shape, random: &mut Lcg) -> Option<()> {
    let refine = shape.refine()?;
    let all = pieces(shape);
    for direction in 0..shape.domain().len() {
        let side = all.get(all.len() / 2)?.sides.get(direction)?;
        let at = side.start + (side.end - side.start) * share(random);
        let finer = refine.refined(direction, &[at]);
        let finer =
            verdict.take(finer, |e| format!("it cannot be refined at {at} of parameter {direction}: {e}"))?;
        let (before, after) = (shape.control_vertices().len(), finer.control_vertices().len());
        verdict.check(after > before, || {
            format!("refined it has {after} control vertices, and {before} before")
        });
        verdict.check(finer.domain() == shape.domain(), || "refined it has another domain".into());
        let reach = shape.control_vertices().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        for cell in &all {
            let place = cell.at([share(random), share(random)]);
            let both = [shape, finer.as_ref()].map(|s| s.value(place, Derivative::POSITION).ok());
            let same = both[0].zip(both[1]).is_some_and(|(a, b)| (a - b).amax() <= 1e-10 * reach);
            verdict.check(same, || format!("refined it is another shape at {place}"));
        }
        if let Some(cells) = finer.cells() {
            let ends = cells.iter().any(|cell| cell.sides.get(direction).is_some_and(|s| s.start == at));
            verdict.check(ends, || format!("refined at {at} of parameter {direction} no cell ends there"));
        }
    }
    verdict.check(refine.refined(shape.domain().len(), &[]).is_err(), || {
        "it can be refined in a direction that it has not".into()
    });
    Some(())
}
