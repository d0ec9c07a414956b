//! The smoothness form of any shape that consists of cells.

use super::{Derivative, Shape, cells_of, charted_rows, rows_at};
use crate::error::Result;
use crate::quadrature::binomial;
use crate::solve::Symmetric;

/// What moving a control vertex costs at least, as a share of what it costs on the mean: vertices of a cage can move so that nothing of its
/// surface does (those of a cube, every other one outwards and inwards), and the form is to be definite.
const AT_LEAST: f64 = 1e-9;

/// Gauss points a direction, beyond those for polynomials, on rational cells.
const RATIONAL_POINTS: usize = 8;

/// [`Shape::smoothness`] by Gauss points on the shape's cells: of a surface, `L_u²|S_u|² + L_v²|S_v|²` for order 1 and the thin
/// plate for order 2, over the area of the domain; where the shape has a [chart](super::Cells::chart), by its coordinates. Exact for polynomial cells; on rational ones of the rational functions
/// themselves, with eight points more. `O(n p²)` rows a cell.
///
/// # Errors
/// When the shape has no cells, or they are wrong.
pub(super) fn smoothness<S: Shape + ?Sized>(shape: &S, order: usize) -> Result<Symmetric> {
    let boxed = shape.boxed();
    let shape = boxed.as_ref();
    // A surface of many faces, each over the same domain, is as long as if these lay in a square: the numbers are those of one spline of so many spans.
    let side = shape.faces().map_or(1.0, |faces| (faces.max(1) as f64).sqrt());
    let lengths: Vec<f64> = shape.domain().iter().map(|one| (one.end - one.start) * side).collect();
    let whole: f64 = lengths.iter().product();
    let mut entries = Vec::new();
    let cells = cells_of(shape, "a stretch or bend metric")?;
    for cell in cells.checked(shape)? {
        let mut add = |derivative: Derivative, factor: f64| -> Result<()> {
            let count = |k: usize, by: usize| {
                let degree = cell.sides.get(k).map_or(0, |side| side.degree);
                if cell.rational { degree + 1 + RATIONAL_POINTS } else { degree + 1 - by.min(degree) }
            };
            let points = cell.gauss_points([count(0, derivative.u), count(1, derivative.v)]);
            let rows = rows_at(shape, &cell, &points, derivative)?;
            let width = cell.vertices.len();
            for i in 0..width {
                for j in 0..=i {
                    let sum: f64 = points
                        .iter()
                        .zip(rows.chunks_exact(width))
                        .map(|((_, w), row)| w * row[i] * row[j])
                        .sum();
                    entries.push((cell.vertices[i], cell.vertices[j], factor * sum));
                }
            }
            Ok(())
        };
        add(Derivative::POSITION, 1.0 / whole)?;
        if let Some(rows) = charted_rows(shape, cells, &cell, order)? {
            for i in 0..cell.vertices.len() {
                for j in 0..=i {
                    let sum: f64 = rows.iter().map(|charted| charted.row[i] * charted.row[j]).sum();
                    let scale = side.powi(2 * order as i32) / whole;
                    entries.push((cell.vertices[i], cell.vertices[j], sum * scale));
                }
            }
            continue;
        }
        match lengths[..] {
            [u, v, ..] => {
                for k in 0..=order {
                    let scale = u.powi(2 * (order - k) as i32) * v.powi(2 * k as i32) / whole;
                    add(Derivative { u: order - k, v: k }, binomial(order, k) * scale)?;
                }
            }
            [u] => add(Derivative { u: order, v: 0 }, u.powi(2 * order as i32) / whole)?,
            [] => {}
        }
    }
    let count = shape.control_vertices().len();
    let mean = entries.iter().filter(|(i, j, _)| i == j).map(|(.., c)| c).sum::<f64>() / count.max(1) as f64;
    entries.extend((0..count).map(|k| (k, k, AT_LEAST * mean)));
    Ok(Symmetric::from_entries(count, entries))
}
