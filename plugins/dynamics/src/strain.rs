//! How far a shape is stretched anywhere, not only where its energy is summed up.

use loftsman_kernel::shape::{Location, Shape, cells_of, rows_at};
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use crate::error::Result;
use crate::points::order;

/// Between the ends of a span so many places more than its degree are looked at.
const MORE: usize = 6;
/// The ends of spans are looked at from within.
const WITHIN: f64 = 1e-9;
/// Where a shape's speed at rest is less than this share of the largest, it has no length there.
const COLLAPSED: f64 = 1e-9;

/// The largest stretch (by its amount, with its sign) of a shape that had the control vertices `first` at the start, `rest` times as long at rest: of a curve
/// `|P'|/ℓ - 1`; of a surface in any direction, the principal stretches `√μ - 1`, `μ` being the eigenvalues of `G` relative to `G` at rest, with
/// `G_ij = P_i·P_j`. Looked at in `degree + 7` places of every span (in each direction), its ends among them. `O(w)` for each place.
pub(crate) fn largest(shape: &dyn Shape, first: &[Point], rest: f64) -> Result<f64> {
    let directions = shape.domain().len();
    let now = shape.control_vertices();
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut longest = 0.0_f64;
    for cell in cells_of(shape, "a stretch")?.checked(shape)? {
        let count = |k: usize| cell.sides.get(k).map_or(1, |side| side.degree + 1 + MORE);
        let share = |i: usize, n: usize| WITHIN + (1.0 - 2.0 * WITHIN) * i as f64 / (n - 1).max(1) as f64;
        let points: Vec<(Location, f64)> = (0..count(0))
            .flat_map(|i| (0..count(1)).map(move |j| (i, j)))
            .map(|(i, j)| (cell.at([share(i, count(0)), share(j, count(1))]), 0.0))
            .collect();
        let width = cell.vertices.len();
        let rows = (0..directions)
            .map(|k| rows_at(shape, &cell, &points, order(k, 1)))
            .collect::<loftsman_kernel::Result<Vec<_>>>()?;
        for point in 0..points.len() {
            let tangents = |of: &[Point]| -> SmallVec<[Vector; 2]> {
                let along = |row: &Vec<f64>| {
                    let row = row[point * width..][..width].iter().zip(&cell.vertices);
                    row.fold(Vector::zeros(), |sum, (c, &v)| sum + of[v].coords * *c)
                };
                rows.iter().map(along).collect()
            };
            let (before, after) = (tangents(first), tangents(now));
            let (metric, own) = (metric(&before), metric(&after));
            let size = (metric[0] * metric[2] - metric[1] * metric[1]).max(0.0).sqrt();
            longest = longest.max(size);
            // Eigenvalues of the metric in an orthonormal frame of that at rest, by differences, so that equal ones come out equal: of a curve
            // its one, twice.
            let lower = [metric[0].sqrt(), metric[1] / metric[0].sqrt(), size / metric[0].sqrt()];
            let a = own[0] / metric[0];
            let b = (own[1] - lower[1] * own[0] / lower[0]) / size;
            let slant = lower[1] / lower[0];
            let c = (own[2] - 2.0 * slant * own[1] + slant * slant * own[0]) / (lower[2] * lower[2]);
            let (half, root) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
            for value in [half + root, half - root] {
                found.push((size, value.max(0.0).sqrt() / rest - 1.0));
            }
        }
    }
    let seen = found.iter().filter(|(size, _)| *size > COLLAPSED * longest).map(|(_, stretch)| *stretch);
    Ok(seen.fold(0.0, |most: f64, stretch| if stretch.abs() > most.abs() { stretch } else { most }))
}

/// `P_u·P_u`, `P_u·P_v`, `P_v·P_v`; of a curve as if it were as stretched across as along.
fn metric(tangents: &[Vector]) -> [f64; 3] {
    match tangents {
        [u, v] => [u.dot(u), u.dot(v), v.dot(v)],
        all => {
            let square = all.first().map_or(0.0, |t| t.dot(t));
            [square, 0.0, square]
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::{Curve, Space, Surface};

    use super::*;

    /// Simple shear by γ: principal stretches `√(1 + γ²/4) ± γ/2`, wherever and whichever way the parameters run.
    #[test]
    fn a_sheared_sheet_is_stretched_along_its_diagonal() {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let points: Vec<Point> = (0..36)
            .map(|k| (space.greville(k / 6), space.greville(k % 6)))
            .map(|(u, v)| Point::new(u + 0.4 * v, 2.0 * v - 0.3 * u, 0.0))
            .collect();
        for (shear, rest) in [(0.0, 1.0), (0.3, 1.0), (-0.8, 1.2)] {
            let sheared = points.iter().map(|p| Point::new(p.x + shear * p.y, p.y, 0.0)).collect();
            let sheet = Surface::new(space.clone(), space.clone(), sheared).unwrap();
            let found = largest(&sheet, &points, rest).unwrap();
            let stretches = [0.5, -0.5]
                .map(|half: f64| ((1.0_f64 + 0.25 * shear * shear).sqrt() + half * shear.abs()) / rest - 1.0);
            let wanted = if stretches[0].abs() > stretches[1].abs() { stretches[0] } else { stretches[1] };
            assert!((found - wanted).abs() < 1e-9, "{shear} {rest}: {found} {wanted}");
        }
    }

    /// A quadratic piece whose speed is `2 + 4 t` against 2 at the start is stretched most at its end, where no Gauss point is.
    #[test]
    fn the_end_of_a_span_counts() {
        let space = Space::clamped_uniform(2, 3).unwrap();
        let line = |x: [f64; 3]| x.map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let curve = Curve::new(space, line([0.0, 1.0, 4.0])).unwrap();
        let found = largest(&curve, &line([0.0, 1.0, 2.0]), 1.0).unwrap();
        assert!((found - 2.0).abs() < 1e-6, "{found}");
    }
}
