//! Coordinates in which the energies of a surface are taken where its parameters are not the right ones.

use super::{Cell, Cells, Derivative, Location, Shape, rows_at};
use crate::error::Result;

/// Gauss points a direction beyond those for polynomials: `|∂x/∂u|` and its reciprocals are smooth, and no polynomials.
const MORE: usize = 2;

/// The first and second derivatives, by the parameters `u` and `v`, of two coordinates `x` and `y` at a location.
///
/// Round an extraordinary vertex of a subdivision surface the surface is smooth and its parameters are not: with `n` edges they shrink
/// by ½ from level to level, the surface by another factor, and second derivatives by them have infinite energy. In the coordinates of the characteristic
/// map (Reif 1995) the surface is smooth where it is, and its thin plate has a finite energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chart {
    /// `[x_u, y_u]`, `[x_v, y_v]`.
    pub first: [[f64; 2]; 2],
    /// `[x_uu, y_uu]`, `[x_uv, y_uv]`, `[x_vv, y_vv]`.
    pub second: [[f64; 2]; 3],
}

/// A derivative by the coordinates as a sum of those by the parameters.
type Sum = Vec<(Derivative, f64)>;

impl Chart {
    /// The area of the coordinates for that of the parameters: `|x_u y_v - x_v y_u|`.
    pub fn area(&self) -> f64 {
        let [[a, b], [c, d]] = self.first;
        (a * d - b * c).abs()
    }

    /// `∂u/∂x`, `∂v/∂x` and `∂u/∂y`, `∂v/∂y`.
    fn inverse(&self) -> [[f64; 2]; 2] {
        let [[a, b], [c, d]] = self.first;
        let determinant = a * d - b * c;
        [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
    }

    /// The derivatives of an order, 1 or 2, by the coordinates: `f_x` and `f_y`, or `f_xx`, `√2 f_xy` and `f_yy`, whose squares sum to the
    /// energy's density. By the chain rule: `∇_u f = J ∇_x f`, `H_u f = J H_x f Jᵀ + f_x H_u x + f_y H_u y`. None of other orders.
    fn derivatives(&self, order: usize) -> Vec<Sum> {
        let g = self.inverse();
        let along =
            |k: usize| [(1, 0), (0, 1)].into_iter().zip(g[k]).map(|((u, v), c)| (Derivative { u, v }, c));
        match order {
            1 => vec![along(0).collect(), along(1).collect()],
            2 => [(0, 0, 1.0), (0, 1, std::f64::consts::SQRT_2), (1, 1, 1.0)]
                .into_iter()
                .map(|(a, b, root)| {
                    let [uu, vv] = [0, 1].map(|k| g[a][k] * g[b][k]);
                    let uv = g[a][0] * g[b][1] + g[a][1] * g[b][0];
                    let second = [(2, 0, uu), (1, 1, uv), (0, 2, vv)];
                    let mut sum: Sum =
                        second.iter().map(|&(u, v, c)| (Derivative { u, v }, root * c)).collect();
                    for k in 0..2 {
                        let bent = uu * self.second[0][k] + uv * self.second[1][k] + vv * self.second[2][k];
                        sum.extend(along(k).map(|(by, c)| (by, -root * bent * c)));
                    }
                    sum
                })
                .collect(),
            _ => Vec::new(),
        }
    }
}

/// A derivative by the coordinates of a [chart](Cells::chart) at one Gauss point.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartedRow {
    /// Where.
    pub at: Location,
    /// The root of the point's weight, by the area of the coordinates.
    pub root: f64,
    /// The row over the cell's own vertices, that root in it.
    pub row: Vec<f64>,
}

/// Rows over a cell's own vertices whose squares sum to the integral of the squared derivatives of an order, 1 or 2, by the coordinates of its
/// [chart](Cells::chart), one for each derivative at each point; mixed derivatives count twice. `None` where the parameters are the
/// coordinates, and of other orders. By Gauss points, two more in each direction than a polynomial's of the cell's degree takes.
///
/// # Errors
/// As for [`rows_at`].
pub fn charted_rows(
    shape: &dyn Shape,
    cells: &dyn Cells,
    cell: &Cell,
    order: usize,
) -> Result<Option<Vec<ChartedRow>>> {
    if !(1..=2).contains(&order) || cell.sides.len() < 2 || cells.chart(cell.at([0.5; 2])).is_none() {
        return Ok(None);
    }
    let count = |k: usize| cell.sides[k].degree + MORE;
    let points = cell.gauss_points([count(0), count(1)]);
    let all: Vec<Derivative> =
        (1..=order).flat_map(|n| (0..=n).map(move |v| Derivative { u: n - v, v })).collect();
    let rows = all.iter().map(|&by| rows_at(shape, cell, &points, by)).collect::<Result<Vec<_>>>()?;
    let width = cell.vertices.len();
    let mut found = Vec::with_capacity(points.len() * (order + 1));
    for (index, &(at, weight)) in points.iter().enumerate() {
        let Some(chart) = cells.chart(at) else { return Ok(None) };
        let root = (weight * chart.area()).sqrt();
        for sum in chart.derivatives(order) {
            let mut row = vec![0.0; width];
            for (by, c) in sum {
                let Some(of) = all.iter().position(|known| *known == by) else { continue };
                row.iter_mut().zip(&rows[of][index * width..]).for_each(|(x, r)| *x += root * c * r);
            }
            found.push(ChartedRow { at, root, row });
        }
    }
    Ok(Some(found))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of `f(x, y) = x³ - 2 x y² + 3 y` with `x = u + ¼ v² `, `y = v - ½ u v`: derivatives by `x` and `y` from those by `u` and `v`, which are found from
    /// differences.
    #[test]
    fn derivatives_by_coordinates_are_those_of_the_chain_rule() {
        let place = |u: f64, v: f64| [u + 0.25 * v * v, v - 0.5 * u * v];
        let f = |u: f64, v: f64| {
            let [x, y] = place(u, v);
            x.powi(3) - 2.0 * x * y * y + 3.0 * y
        };
        let (u, v) = (0.3, 0.7);
        let chart = Chart {
            first: [[1.0, -0.5 * v], [0.5 * v, 1.0 - 0.5 * u]],
            second: [[0.0, 0.0], [0.0, -0.5], [0.5, 0.0]],
        };
        let h = 1e-3;
        let by = |d: Derivative| match (d.u, d.v) {
            (1, 0) => (f(u + h, v) - f(u - h, v)) / (2.0 * h),
            (0, 1) => (f(u, v + h) - f(u, v - h)) / (2.0 * h),
            (2, 0) => (f(u + h, v) - 2.0 * f(u, v) + f(u - h, v)) / (h * h),
            (0, 2) => (f(u, v + h) - 2.0 * f(u, v) + f(u, v - h)) / (h * h),
            _ => (f(u + h, v + h) - f(u + h, v - h) - f(u - h, v + h) + f(u - h, v - h)) / (4.0 * h * h),
        };
        let values = |order| -> Vec<f64> {
            chart.derivatives(order).iter().map(|sum| sum.iter().map(|&(d, c)| c * by(d)).sum()).collect()
        };
        let [x, y] = place(u, v);
        let first = [3.0 * x * x - 2.0 * y * y, -4.0 * x * y + 3.0];
        let second = [6.0 * x, -4.0 * y * std::f64::consts::SQRT_2, -4.0 * x];
        for (found, wanted) in [(values(1), first.to_vec()), (values(2), second.to_vec())] {
            for (a, b) in found.iter().zip(&wanted) {
                assert!((a - b).abs() < 1e-5, "{found:?} {wanted:?}");
            }
        }
        assert!(chart.derivatives(3).is_empty());
    }
}
