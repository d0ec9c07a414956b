//! Mass matrices: `M_ij = ∫ m b_i b_j`, by length or area at the start; and how they are factored.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Derivative, Shape, cells_of, rows_at};
use loftsman_kernel::solve::{EnvelopeCholesky, Symmetric, Weight};
use loftsman_kernel::spline::Space;

use crate::body::Material;
use crate::error::{DynamicsError, Result};
use crate::measure::{Measure, lines};

/// A pivot below this share of its diagonal entry is none.
const SINGULAR: f64 = 1e-15;

/// The mass of a body.
#[derive(Debug, Clone)]
pub(crate) struct Mass {
    pub(crate) matrix: Symmetric,
    pub(crate) weight: Weight,
    pub(crate) order: Option<Vec<usize>>,
    /// The rows' sums: what gravity pulls at.
    pub(crate) lumped: Vec<f64>,
    /// What sums over it may be wrong by, as a share of it.
    pub(crate) missing: f64,
}

impl Mass {
    /// Of a curve the band of its basis functions, weighted by its speed; of a tensor-product surface the Kronecker product of two bands, its area
    /// element taken as the product of its means along each direction (exact where it is one: of every parallelogram, cylinder and
    /// cone; the whole mass always); of other shapes as it is, in an order that keeps neighbours together. To 1e-10 of what each cell has, by a [measure](Measure) that sees it as it is, but
    /// where creases run askew to a surface's parameters: what that [misses](Self::missing) is known.
    pub(crate) fn new(shape: &dyn Shape, material: &Material) -> Result<Self> {
        let cells = cells_of(shape, "a simulation")?;
        let splines = cells.splines().filter(|splines| splines.weights.is_none());
        let n = shape.control_vertices().len();
        if let Some((u, v)) = splines.and_then(|splines| Some((splines.u, splines.v?))) {
            return Self::grid(shape, u, v, material.mass);
        }
        let mut entries = Vec::new();
        let cells = cells.checked(shape)?;
        let mut measure = Measure::new(shape, cells.len())?;
        for cell in &cells {
            let width = cell.vertices.len();
            let mut own = vec![0.0; width * width];
            for part in measure.of(cell)? {
                let points = part.weighed();
                let rows = rows_at(shape, cell, &points, Derivative::POSITION)?;
                for ((_, share), row) in points.iter().zip(rows.chunks_exact(width)) {
                    for i in 0..width {
                        for j in 0..=i {
                            own[i * width + j] += share * row[i] * row[j];
                        }
                    }
                }
            }
            for i in 0..width {
                for j in 0..=i {
                    entries.push((cell.vertices[i], cell.vertices[j], material.mass * own[i * width + j]));
                }
            }
        }
        let matrix = Symmetric::from_entries(n, entries);
        // Along a curve vertices are in their best order as they are; a closed one's seam reaches back in its last rows.
        let order = if shape.domain().len() == 1 { None } else { Some(matrix.narrow_order()) };
        let weight = Weight::Vertices(factor(&matrix, order.as_deref())?);
        Ok(Self::from_parts(matrix, weight, order, measure.missing()))
    }

    fn grid(shape: &dyn Shape, u: &Space, v: &Space, mass: f64) -> Result<Self> {
        let lines = lines(u, v)?;
        let mut along: [Vec<(usize, usize, f64)>; 2] = [Vec::new(), Vec::new()];
        let mut whole = 0.0;
        let cells = cells_of(shape, "a simulation")?.checked(shape)?;
        let mut measure = Measure::new(shape, cells.len())?;
        for cell in &cells {
            for part in measure.of(cell)? {
                whole += part.whole();
                for k in 0..2 {
                    for (location, sum) in part.sums(k) {
                        let (x, y) = location.on_surface()?;
                        let at = if k == 0 { x } else { y };
                        let row = lines[k].stencil(at.into(), Derivative::POSITION)?;
                        for (i, a) in row.iter() {
                            along[k].extend(
                                row.iter().filter(|(j, _)| *j <= i).map(|(j, b)| (i, j, sum * a * b)),
                            );
                        }
                    }
                }
            }
        }
        let [by_u, by_v] = along;
        let (by_u, by_v) = (Symmetric::from_entries(u.len(), by_u), Symmetric::from_entries(v.len(), by_v));
        let columns = v.len();
        let scale = mass / whole;
        let entries =
            (0..u.len()).flat_map(|i| by_u.row(i).map(move |(k, a)| (i, k, a))).flat_map(|(i, k, a)| {
                let by_v = &by_v;
                (0..columns).flat_map(move |j| {
                    by_v.row(j).map(move |(l, b)| (i * columns + j, k * columns + l, scale * a * b))
                })
            });
        let lower = entries.filter(|(row, column, _)| column <= row);
        let matrix = Symmetric::from_entries(shape.control_vertices().len(), lower);
        let scaled = |matrix: &Symmetric, by: f64| {
            let rows = (0..matrix.size()).flat_map(|i| matrix.row(i).map(move |(j, c)| (i, j, by * c)));
            Symmetric::from_entries(matrix.size(), rows.filter(|(i, j, _)| j <= i))
        };
        let (by_u, by_v) = (scaled(&by_u, scale), scaled(&by_v, 1.0));
        let weight = Weight::Grid(factor(&by_u, None)?, factor(&by_v, None)?);
        Ok(Self::from_parts(matrix, weight, None, measure.missing()))
    }

    fn from_parts(matrix: Symmetric, weight: Weight, order: Option<Vec<usize>>, missing: f64) -> Self {
        let lumped = (0..matrix.size()).map(|i| matrix.row(i).map(|(_, m)| m).sum()).collect();
        Self { matrix, weight, order, lumped, missing }
    }
}

/// How far the centre of a surface's mass is from that of its area: what the product of two directions misses. 0 of curves.
pub(crate) fn off_centre(shape: &dyn Shape, mass: &Mass) -> Result<f64> {
    if shape.domain().len() != 2 {
        return Ok(0.0);
    }
    // From one of its own points, for sums to be as good as the shape is large.
    let Some(from) = shape.control_vertices().first().copied() else { return Ok(0.0) };
    let (mut area, mut sum) = (0.0, Vector::zeros());
    let cells = cells_of(shape, "a centre")?.checked(shape)?;
    let mut measure = Measure::new(shape, cells.len())?;
    for cell in &cells {
        for part in measure.of(cell)? {
            let points = part.weighed();
            let rows = rows_at(shape, cell, &points, Derivative::POSITION)?;
            for ((_, share), row) in points.iter().zip(rows.chunks_exact(cell.vertices.len().max(1))) {
                let arms = row.iter().zip(&cell.vertices);
                let arm = arms
                    .fold(Vector::zeros(), |sum, (c, &v)| sum + (shape.control_vertices()[v] - from) * *c);
                area += share;
                sum += arm * *share;
            }
        }
    }
    let whole: f64 = mass.lumped.iter().sum();
    let own = shape.control_vertices().iter().zip(&mass.lumped);
    let own = own.fold(Vector::zeros(), |sum, (p, m)| sum + (p - from) * *m) / whole;
    Ok((own - sum / area).norm())
}

/// The Cholesky factor within the envelope, rows in this order.
fn factor(matrix: &Symmetric, order: Option<&[usize]>) -> Result<EnvelopeCholesky> {
    let n = matrix.size();
    let mut place = vec![0; n];
    match order {
        Some(order) => order.iter().enumerate().for_each(|(at, &row)| place[row] = at),
        None => place.iter_mut().enumerate().for_each(|(at, place)| *place = at),
    }
    let row_at = |i: usize| order.map_or(i, |order| order[i]);
    let first: Vec<u32> = (0..n)
        .map(|i| matrix.row(row_at(i)).map(|(j, _)| place[j]).min().unwrap_or(i).min(i) as u32)
        .collect();
    EnvelopeCholesky::factor(first, SINGULAR, |i, j| matrix.entry(row_at(i), row_at(j)))
        .map_err(|row| DynamicsError::Massless { vertex: row_at(row), cage: false })
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::spline::{Curve, Surface};

    use super::*;

    /// The row of a uniform cubic of unit speed: 151/315, 397/1680, 1/42, 1/5040.
    #[test]
    fn the_row_of_a_uniform_cubic() {
        let space = Space::floating_uniform(3, 12).unwrap();
        let points = (0..12).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let line = Curve::new(space, points).unwrap();
        let mass = Mass::new(&line, &Material { mass: 2.0, ..Material::default() }).unwrap();
        for (k, value) in
            [151.0 / 315.0, 397.0 / 1680.0, 1.0 / 42.0, 1.0 / 5040.0, 0.0].into_iter().enumerate()
        {
            assert!((mass.matrix.entry(6, 6 + k) - 2.0 * value).abs() < 1e-15, "{k}");
            assert!((mass.matrix.entry(6, 6 - k) - 2.0 * value).abs() < 1e-15, "{k}");
        }
        // All of it is there: what the line weighs between its ends.
        assert!((mass.lumped.iter().sum::<f64>() - 2.0 * 9.0).abs() < 1e-13);
    }

    /// A parallelogram's is exactly the product; its whole mass is its area's, whatever the sheet.
    #[test]
    fn the_mass_of_a_sheet() {
        let u = Space::clamped_uniform(3, 7).unwrap();
        let open = Space::clamped_uniform(2, 5).unwrap();
        let points = (0..35).map(|k| {
            let (x, y) = (u.greville(k / 5), open.greville(k % 5));
            Point::new(x + 0.3 * y, 2.0 * y, 0.0)
        });
        let sheet = Surface::new(u.clone(), open.clone(), points.collect()).unwrap();
        let mass = Mass::new(&sheet, &Material::default()).unwrap();
        let area = 2.0 * u.domain().1 * open.domain().1;
        assert!((mass.lumped.iter().sum::<f64>() - area).abs() < 1e-12 * area);
        // The same by cells, which know nothing of products: of a rational one with equal weights.
        let rational = Surface::rational(u, open, sheet.points().to_vec(), vec![1.0; 35]).unwrap();
        let whole = Mass::new(&rational, &Material::default()).unwrap();
        assert!(matches!((&mass.weight, &whole.weight), (Weight::Grid(..), Weight::Vertices(_))));
        for i in 0..35 {
            for j in 0..35 {
                assert!((mass.matrix.entry(i, j) - whole.matrix.entry(i, j)).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}
