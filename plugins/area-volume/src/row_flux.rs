//! The integrals of [`Flux`](crate::flux::Flux) over cells by their stencils, and over the cones of holes: rows are kept.

use loftsman_kernel::shape::{Cell, Derivative, Hole, Shape, Share, rows_at};
use loftsman_kernel::{Point, Result, Vector};

use crate::cone::Cones;

/// Gauss points of cells and of the cones over holes, with the functions there and their derivatives.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct RowFlux {
    /// By their places among its own.
    vertices: Vec<u32>,
    /// For each cell, and for the cones of each hole, where its vertices start, how many they are, and how many points it has.
    cells: Vec<(usize, usize, usize)>,
    weights: Vec<f64>,
    /// For each point the values, `u` and `v` derivatives of its cell's functions, one after another.
    rows: Vec<f64>,
}

impl RowFlux {
    /// The cones over holes, times their faces' senses, and the vertices that they depend on; `count` says how many Gauss points are taken along a border of a
    /// degree.
    pub(crate) fn of_holes(
        shape: &dyn Shape,
        holes: &[Hole],
        count: impl Fn(usize) -> usize,
        sense: impl Fn(Option<u32>) -> f64,
    ) -> Result<(Vec<u32>, Self)> {
        let mut flux = Self::default();
        for hole in holes {
            let cones = Cones::new(shape, hole, &count)?;
            flux.cells.push((flux.vertices.len(), cones.vertices.len(), cones.weights.len()));
            flux.vertices.extend(cones.vertices.iter().map(|&v| v as u32));
            flux.weights.extend(cones.weights.iter().map(|weight| weight * sense(hole.face)));
            flux.rows.extend(cones.rows);
        }
        let mut own = flux.vertices.clone();
        own.sort_unstable();
        own.dedup();
        flux.vertices.iter_mut().for_each(|v| *v = own.binary_search(v).unwrap_or(0) as u32);
        Ok((own, flux))
    }

    /// So many points, which depend on the degree, on each of `parts` parts of what counts of a cell in either direction, times a sense; the cells' vertices are among
    /// its `own`, which are ascending.
    pub(crate) fn with(
        shape: &dyn Shape,
        cells: &[&(Cell, Share)],
        own: &[u32],
        counts: impl Fn(usize) -> usize,
        parts: usize,
        sense: f64,
    ) -> Result<Self> {
        let mut flux = Self::default();
        flux.cells.reserve(cells.len());
        for (cell, share) in cells {
            let per = [0, 1].map(|k| counts(cell.sides.get(k).map_or(0, |side| side.degree)));
            let width = cell.vertices.len();
            let points = share.gauss_points(cell, per, parts);
            let of = |by: [usize; 2]| rows_at(shape, cell, &points, Derivative::from(by));
            let (values, by_u, by_v) = (of([0, 0])?, of([1, 0])?, of([0, 1])?);
            for at in 0..points.len() {
                for rows in [&values, &by_u, &by_v] {
                    flux.rows.extend_from_slice(&rows[at * width..(at + 1) * width]);
                }
            }
            flux.cells.push((flux.vertices.len(), width, points.len()));
            let place = |v: &usize| own.binary_search(&(*v as u32)).unwrap_or(0) as u32;
            flux.vertices.extend(cell.vertices.iter().map(place));
            flux.weights.extend(points.iter().map(|(_, weight)| weight * sense));
        }
        Ok(flux)
    }

    /// Adds `F_i` for each `h`, one for each of its own vertices, which are `points`; coordinates are taken from `origin`.
    pub(crate) fn integrate(&self, points: &[Point], origin: &Point, out: &mut [Vec<Vector>]) {
        let (mut weights, mut rows) = (self.weights.iter(), self.rows.as_slice());
        for &(start, width, count) in &self.cells {
            let vertices = &self.vertices[start..start + width];
            for weight in weights.by_ref().take(count) {
                let (own, rest) = rows.split_at(3 * width);
                rows = rest;
                let sum = |row: &[f64]| {
                    let terms = vertices.iter().zip(row);
                    terms.fold(Vector::zeros(), |sum, (&v, c)| sum + (points[v as usize] - origin) * *c)
                };
                let (values, slopes) = own.split_at(width);
                let (by_u, by_v) = slopes.split_at(width);
                let (point, normal) = (sum(values), sum(by_u).cross(&sum(by_v)) * *weight);
                for (kind, out) in out.iter_mut().enumerate() {
                    let scaled = if kind == 0 { normal } else { normal * point[kind - 1] };
                    for (&v, c) in vertices.iter().zip(values) {
                        out[v as usize] += scaled * *c;
                    }
                }
            }
        }
    }
}
