//! An edge as a spline along it, found from a shape's cells and stencils.

use super::edges::{BoundaryEdge, Strip, cells_at};
use super::{CellSide, Cells, Derivative, Shape, Side, Sides, Stencil};
use crate::error::{Error, MAX_DEGREE, Result};
use crate::quadrature::binomial;
use crate::quadrature::gauss_legendre;
use crate::space::Space;

/// Stencils that differ by no more than this part of their largest coefficient are one.
const SAME: f64 = 1e-9;

/// One piece of an edge: its ends, and for each order the Bernstein coefficients of the derivative across it.
struct Piece {
    start: f64,
    end: f64,
    bernstein: Vec<Vec<Stencil>>,
}

/// The derivatives across an edge as splines along it; see [`strips`](super::strips).
pub(super) fn from_cells(
    shape: &dyn Shape,
    edge: &BoundaryEdge,
    cells: &dyn Cells,
    order: usize,
) -> Result<Vec<Strip>> {
    let wrong =
        |what: &str| Error::Invalid(format!("{} of a shape ({}) {what}", edge.called(), shape.type_name()));
    let cells = cells.checked(shape)?;
    let sides = cells_at(edge, &cells);
    let mut all = sides.iter().map(|(run, _)| (run.start, run.end));
    let covered = all.try_fold(edge.start, |reached, (start, end)| (reached == start).then_some(end));
    if covered != Some(edge.end) {
        return Err(wrong("is not covered once by the cells that lie at it"));
    }
    if cells.iter().any(|cell| cell.rational) {
        return Err(wrong(
            "is rational, and the shape does not say its strips: it can be joined only where it does",
        ));
    }
    let degree = sides.iter().map(|(run, _)| run.degree).max().unwrap_or(0).clamp(1, MAX_DEGREE);
    let pieces =
        sides.iter().map(|(run, _)| piece(shape, edge, *run, degree, order)).collect::<Result<Vec<_>>>()?;
    let space = space(shape, edge, &pieces, degree, order)?;
    let mut largest = vec![0.0; order + 1];
    for (_, across) in &sides {
        // What the Bernstein functions' derivatives come to at the end of a piece of this degree and length.
        for (k, largest) in largest.iter_mut().enumerate().filter(|(k, _)| *k <= across.degree) {
            let falling: f64 = (0..k).map(|i| (across.degree - i) as f64).product();
            let own = falling * (binomial(k, k / 2)) / (across.end - across.start).powi(k as i32);
            *largest = f64::max(*largest, own);
        }
    }
    let coefficients = |k: usize| -> Result<Vec<Stencil>> {
        (0..space.len()).map(|i| coefficient(&space, edge, &pieces, k, i)).collect()
    };
    (0..=order)
        .map(|k| Ok(Strip { space: space.clone(), coefficients: coefficients(k)?, largest: largest[k] }))
        .collect()
}

/// The Bernstein coefficients of the derivatives across one piece, by interpolation at its Gauss points.
fn piece(
    shape: &dyn Shape,
    edge: &BoundaryEdge,
    run: CellSide,
    degree: usize,
    order: usize,
) -> Result<Piece> {
    let (nodes, _) = gauss_legendre(degree + 1);
    let inverse = inverted(&nodes, degree)
        .ok_or_else(|| Error::Invalid(format!("an edge of degree {degree} cannot be interpolated")))?;
    let bernstein = (0..=order)
        .map(|k| {
            let at = |x: &f64| shape.stencil(edge.at(run.start + (run.end - run.start) * x), edge.across(k));
            let values = nodes.iter().map(at).collect::<Result<Vec<_>>>()?;
            Ok((0..=degree).map(|i| combined(values.iter().zip(inverse[i].iter().copied()))).collect())
        })
        .collect::<Result<_>>()?;
    Ok(Piece { start: run.start, end: run.end, bernstein })
}

/// The inverse of the matrix of the Bernstein functions at some places.
fn inverted(nodes: &[f64], degree: usize) -> Option<Vec<Vec<f64>>> {
    let value =
        |x: f64, i: usize| binomial(degree, i) * x.powi(i as i32) * (1.0 - x).powi((degree - i) as i32);
    let matrix = nalgebra::DMatrix::from_fn(degree + 1, degree + 1, |r, c| value(nodes[r], c));
    let inverse = matrix.try_inverse()?;
    Some((0..=degree).map(|r| inverse.row(r).iter().copied().collect()).collect())
}

/// A sum of stencils, without what is rounding beside its largest coefficient.
fn combined<'s>(terms: impl Iterator<Item = (&'s Stencil, f64)>) -> Stencil {
    let sum: Stencil = terms.flat_map(|(s, by)| s.iter().map(move |(v, c)| (v, c * by))).collect();
    let largest = sum.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    sum.iter().filter(|(_, c)| c.abs() > 1e-14 * largest).collect()
}

/// Whether two stencils are one, beside numbers of this size.
fn same(a: &Stencil, b: &Stencil, size: f64) -> bool {
    let difference: Stencil = a.iter().chain(b.iter().map(|(v, c)| (v, -c))).collect();
    difference.coefficients().iter().all(|c| c.abs() <= SAME * size)
}

/// The space over the edge: at each place where pieces meet as smooth as they do there.
fn space(
    shape: &dyn Shape,
    edge: &BoundaryEdge,
    pieces: &[Piece],
    degree: usize,
    order: usize,
) -> Result<Space> {
    let smooth = |left: f64, right: f64| -> Result<usize> {
        for along in 0..degree {
            for across in 0..=order {
                let [d, e] = [edge.along(along), edge.across(across)];
                let by = Derivative { u: d.u + e.u, v: d.v + e.v };
                let on = |side| {
                    if edge.along_u {
                        Sides { u: side, v: Side::Right }
                    } else {
                        Sides { u: Side::Right, v: side }
                    }
                };
                let (a, b) = (
                    shape.stencil_on(edge.at(left), by, on(Side::Left))?,
                    shape.stencil_on(edge.at(right), by, on(Side::Right))?,
                );
                let size =
                    a.coefficients().iter().chain(b.coefficients()).fold(0.0_f64, |m, c| m.max(c.abs()));
                if !same(&a, &b, size) {
                    return Ok(along);
                }
            }
        }
        Ok(degree)
    };
    let mut knots = Vec::new();
    let ends = if edge.periodic {
        (degree + 1 - smooth(edge.end, edge.start)?).clamp(1, degree)
    } else {
        degree + 1
    };
    knots.extend(std::iter::repeat_n(edge.start, ends));
    for pair in pieces.windows(2) {
        // Where cells meet that are smoother than any polynomial piece can tell, the place is kept all the same.
        let times = (degree + 1 - smooth(pair[0].end, pair[1].start)?).max(1);
        knots.extend(std::iter::repeat_n(pair[1].start, times));
    }
    if edge.periodic {
        knots.push(edge.end);
        return Space::periodic(degree, knots);
    }
    knots.extend(std::iter::repeat_n(edge.end, ends));
    Space::open(degree, knots)
}

/// Coefficient `i` of a spline over the pieces: the blossom of one of them at the knots inside the function's support.
fn coefficient(
    space: &Space,
    edge: &BoundaryEdge,
    pieces: &[Piece],
    order: usize,
    i: usize,
) -> Result<Stencil> {
    let (p, flat) = (space.degree(), space.flat());
    let first = if space.is_periodic() { i + p } else { i };
    // The span in the middle of the support, of those in the domain; a function that starts late is met again a period earlier.
    let spans =
        |k: usize| (k.max(p)..=(k + p).min(space.unrolled_len() - 1)).filter(|&s| flat[s] < flat[s + 1]);
    let unrolled = [first, first.wrapping_sub(space.len())];
    let mut found = None;
    for k in unrolled.into_iter().filter(|&k| k < space.unrolled_len() && space.vertex(k) == i) {
        let middle = 0.5 * (flat[k] + flat[k + p + 1]);
        let away = |s: &usize| (0.5 * (flat[*s] + flat[*s + 1]) - middle).abs();
        let best = spans(k).min_by(|a, b| away(a).total_cmp(&away(b))).map(|s| (away(&s), k, s));
        found = match (found, best) {
            (Some(a), Some(b)) => Some(if b < a { b } else { a }),
            (a, b) => a.or(b),
        };
    }
    let lost =
        || Error::Invalid(format!("{} has a function along it that none of its pieces shows", edge.called()));
    let (_, k, span) = found.ok_or_else(lost)?;
    let piece = pieces.iter().find(|piece| piece.start == flat[span]).ok_or_else(lost)?;
    let mut row = piece.bernstein[order].clone();
    for (level, knot) in flat[k + 1..=k + p].iter().enumerate() {
        let x = (knot - piece.start) / (piece.end - piece.start);
        for j in 0..p - level {
            row[j] = combined([(&row[j], 1.0 - x), (&row[j + 1], x)].into_iter());
        }
    }
    row.into_iter().next().ok_or_else(lost)
}
