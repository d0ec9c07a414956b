//! Mass matrices: `M_ij = ∫ m b_i b_j`, by length or area at the start; and how they are factored.

use loftsman_kernel::shape::{Cell, Derivative, Location, Shape, cells_of, rows_at};
use loftsman_kernel::solve::{EnvelopeCholesky, Symmetric, Weight};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::body::Material;
use crate::error::{DynamicsError, Result};
use crate::points::order;

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
}

impl Mass {
    /// Of a curve the band of its basis functions, weighted by its speed; of a tensor-product surface the Kronecker product of two bands, its area
    /// element taken as the product of its means along each direction (exact where it is one: of every parallelogram, cylinder and
    /// cone; the whole mass always); of other shapes as it is, in an order that keeps neighbours together. Exact to rounding where the speed is
    /// constant or a low polynomial, else by Gauss points with three (one in each direction) more than that takes, of curves by twice as many again until these see no other length.
    pub(crate) fn new(shape: &dyn Shape, material: &Material) -> Result<Self> {
        let cells = cells_of(shape, "a simulation")?;
        let splines = cells.splines().filter(|splines| splines.weights.is_none());
        let n = shape.control_vertices().len();
        if let Some((u, v)) = splines.and_then(|splines| Some((splines.u, splines.v?))) {
            return Self::grid(shape, u, v, material.mass);
        }
        let mut entries = Vec::new();
        for cell in cells.checked(shape)? {
            let (points, measures) = seen_whole(shape, &cell)?;
            let rows = rows_at(shape, &cell, &points, Derivative::POSITION)?;
            let width = cell.vertices.len();
            for (((_, weight), row), measure) in points.iter().zip(rows.chunks_exact(width)).zip(measures) {
                let mass = material.mass * weight * measure;
                for i in 0..width {
                    for j in 0..=i {
                        entries.push((cell.vertices[i], cell.vertices[j], mass * row[i] * row[j]));
                    }
                }
            }
        }
        let matrix = Symmetric::from_entries(n, entries);
        // Along a curve vertices are in their best order as they are; a closed one's seam reaches back in its last rows.
        let order = if shape.domain().len() == 1 { None } else { Some(matrix.narrow_order()) };
        let weight = Weight::Vertices(factor(&matrix, order.as_deref())?);
        Ok(Self::from_parts(matrix, weight, order))
    }

    fn grid(shape: &dyn Shape, u: &Space, v: &Space, mass: f64) -> Result<Self> {
        // Curves without extent, for their basis functions.
        let line = |space: &Space| Curve::new(space.clone(), vec![Point::origin(); space.len()]);
        let lines = [line(u)?, line(v)?];
        let mut along: [Vec<(usize, usize, f64)>; 2] = [Vec::new(), Vec::new()];
        let mut whole = 0.0;
        for cell in cells_of(shape, "a simulation")?.checked(shape)? {
            let points = gauss(&cell);
            let measures = measures(shape, &cell, &points)?;
            let counts = cell.sides.iter().map(|side| side.degree + 1 + more(2, false)).collect::<Vec<_>>();
            // The area element's sums along each direction, at the points of the other.
            let mut sums = [vec![0.0; counts[0]], vec![0.0; counts[1]]];
            for (index, ((_, weight), measure)) in points.iter().zip(&measures).enumerate() {
                let (i, j) = (index / counts[1], index % counts[1]);
                sums[0][i] += weight * measure;
                sums[1][j] += weight * measure;
                whole += weight * measure;
            }
            for k in 0..2 {
                for (at, sum) in sums[k].iter().enumerate() {
                    let location = points[if k == 0 { at * counts[1] } else { at }].0;
                    let (x, y) = location.on_surface()?;
                    let row = lines[k].stencil((if k == 0 { x } else { y }).into(), Derivative::POSITION)?;
                    for (i, a) in row.iter() {
                        along[k]
                            .extend(row.iter().filter(|(j, _)| *j <= i).map(|(j, b)| (i, j, sum * a * b)));
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
        Ok(Self::from_parts(matrix, Weight::Grid(factor(&by_u, None)?, factor(&by_v, None)?), None))
    }

    fn from_parts(matrix: Symmetric, weight: Weight, order: Option<Vec<usize>>) -> Self {
        let lumped = (0..matrix.size()).map(|i| matrix.row(i).map(|(_, m)| m).sum()).collect();
        Self { matrix, weight, order, lumped }
    }
}

/// Gauss points beyond those that are exact where the speed is constant.
fn more(directions: usize, rational: bool) -> usize {
    (if directions == 1 { 3 } else { 1 }) + if rational { 4 } else { 0 }
}

fn gauss(cell: &Cell) -> Vec<(Location, f64)> {
    let count = |k: usize| {
        let degree = cell.sides.get(k).map_or(0, |side| side.degree);
        degree + 1 + more(cell.sides.len(), cell.rational)
    };
    cell.gauss_points([count(0), count(1)])
}

/// Gauss points with their weights.
type Weighed = Vec<(Location, f64)>;

/// Where twice as many points see another length by this share of it, these are taken, up to so many.
const SEEN: f64 = 1e-9;
const MOST: usize = 128;

/// The points of a cell with the measures there: of a curve so many that more see the same length, for the speed of what turns sharply is no polynomial.
fn seen_whole(shape: &dyn Shape, cell: &Cell) -> Result<(Weighed, Vec<f64>)> {
    let mut points = gauss(cell);
    let mut found = measures(shape, cell, &points)?;
    if cell.sides.len() != 1 {
        return Ok((points, found));
    }
    let whole = |points: &[(Location, f64)], found: &[f64]| -> f64 {
        points.iter().zip(found).map(|((_, weight), measure)| weight * measure).sum()
    };
    let mut length = whole(&points, &found);
    while 2 * points.len() <= MOST {
        let more = cell.gauss_points([2 * points.len(), 0]);
        let there = measures(shape, cell, &more)?;
        let now = whole(&more, &there);
        if (now - length).abs() <= SEEN * now {
            break;
        }
        (points, found, length) = (more, there, now);
    }
    Ok((points, found))
}

/// How far the centre of a surface's mass is from that of its area: what the product of two directions misses. 0 of curves.
pub(crate) fn off_centre(shape: &dyn Shape, mass: &Mass) -> Result<f64> {
    if shape.domain().len() != 2 {
        return Ok(0.0);
    }
    // From one of its own points, for sums to be as good as the shape is large.
    let Some(from) = shape.control_vertices().first().copied() else { return Ok(0.0) };
    let (mut area, mut sum) = (0.0, Vector::zeros());
    for cell in cells_of(shape, "a centre")?.checked(shape)? {
        let points = gauss(&cell);
        let rows = rows_at(shape, &cell, &points, Derivative::POSITION)?;
        let measures = measures(shape, &cell, &points)?;
        let width = cell.vertices.len();
        for (((_, weight), row), measure) in points.iter().zip(rows.chunks_exact(width)).zip(measures) {
            let arm = row
                .iter()
                .zip(&cell.vertices)
                .fold(Vector::zeros(), |sum, (c, &v)| sum + (shape.control_vertices()[v] - from) * *c);
            area += weight * measure;
            sum += arm * (weight * measure);
        }
    }
    let whole: f64 = mass.lumped.iter().sum();
    let own = shape.control_vertices().iter().zip(&mass.lumped);
    let own = own.fold(Vector::zeros(), |sum, (p, m)| sum + (p - from) * *m) / whole;
    Ok((own - sum / area).norm())
}

/// `|P'|`, or `|P_u × P_v|`, at points of a cell.
fn measures(shape: &dyn Shape, cell: &Cell, points: &[(Location, f64)]) -> Result<Vec<f64>> {
    let vertices = shape.control_vertices();
    let width = cell.vertices.len();
    let tangents = (0..cell.sides.len())
        .map(|k| {
            let rows = rows_at(shape, cell, points, order(k, 1))?;
            Ok(rows
                .chunks_exact(width)
                .map(|row| {
                    row.iter()
                        .zip(&cell.vertices)
                        .fold(Vector::zeros(), |sum, (c, &v)| sum + vertices[v].coords * *c)
                })
                .collect::<Vec<_>>())
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(match &tangents[..] {
        [u, v] => u.iter().zip(v).map(|(u, v)| u.cross(v).norm()).collect(),
        all => all.iter().flatten().map(|t| t.norm()).collect(),
    })
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
    use loftsman_kernel::spline::Surface;

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
