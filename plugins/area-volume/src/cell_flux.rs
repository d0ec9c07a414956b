//! The integrals of [`Flux`](crate::flux::Flux) over a surface that is no tensor-product spline, by its cells and stencils.

use loftsman_kernel::shape::{Cell, Derivative, rows_at};
use loftsman_kernel::{Point, Result, Vector};

use crate::flux::{MOST, most, settled, unsettled};
use crate::members::Member;

/// Gauss points of all cells, with the functions there and their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CellFlux {
    vertices: Vec<u32>,
    /// For each cell where its vertices start, how many they are, and how many points it has.
    cells: Vec<(usize, usize, usize)>,
    weights: Vec<f64>,
    /// For each point the values, `u` and `v` derivatives of its cell's functions, one after another.
    rows: Vec<f64>,
    moments: bool,
}

impl CellFlux {
    /// For the surfaces that differ from this one in their control vertices only; with `moments` for all four `h`. Exact where the
    /// cells are polynomial; where they are rational, refined until the present integrals settle to 1e-13.
    pub(crate) fn new(surface: &Member<'_>, moments: bool) -> Result<Self> {
        let cells = surface.cells.checked(surface.shape)?;
        let exact =
            |degree: usize| if moments { (2 * degree).max(1) } else { (3 * degree).div_ceil(2).max(1) };
        let flux = Self::with(surface, &cells, exact, 1, moments)?;
        if !surface.cells.is_rational() {
            return Ok(flux);
        }
        let middle = crate::members::middle_of(surface.points());
        let (mut flux, mut last, mut now) = (flux, Vec::new(), Vec::new());
        flux.integrate(surface.points(), &middle, &mut last);
        let (mut more, mut parts) = (0, 1);
        let count = |more: usize, parts: usize| {
            let [p, q] = surface.cells.degrees().map(|degree| (exact(degree) + more) * parts);
            cells.len().saturating_mul(p).saturating_mul(q)
        };
        let most = most(count(more, parts));
        for _ in 0..12 {
            if surface.cells.degrees().into_iter().map(exact).max().unwrap_or(1) + more < MOST {
                more += 4;
            } else {
                parts *= 2;
            }
            if count(more, parts) > most {
                break;
            }
            let finer = Self::with(surface, &cells, |degree| exact(degree) + more, parts, moments)?;
            finer.integrate(surface.points(), &middle, &mut now);
            if settled(&now, &last, surface.points(), &middle)? {
                return Ok(flux);
            }
            flux = finer;
            std::mem::swap(&mut last, &mut now);
        }
        Err(unsettled())
    }

    /// So many points, which depend on the degree, on each of `parts` parts of a cell in either direction.
    fn with(
        surface: &Member<'_>,
        cells: &[Cell],
        counts: impl Fn(usize) -> usize,
        parts: usize,
        moments: bool,
    ) -> Result<Self> {
        let (vertices, weights, rows) = (Vec::new(), Vec::new(), Vec::new());
        let mut flux = Self { vertices, cells: Vec::with_capacity(cells.len()), weights, rows, moments };
        for cell in cells {
            let per = [0, 1].map(|k| counts(cell.sides.get(k).map_or(0, |side| side.degree)));
            let width = cell.vertices.len();
            let mut points = Vec::new();
            for (i, j) in (0..parts).flat_map(|i| (0..parts).map(move |j| (i, j))) {
                let mut piece = cell.clone();
                for (side, k) in piece.sides.iter_mut().zip([i, j]) {
                    let step = (side.end - side.start) / parts as f64;
                    side.start += step * k as f64;
                    side.end = side.start + step;
                }
                points.extend(piece.gauss_points(per));
            }
            let of = |by: [usize; 2]| rows_at(surface.shape, cell, &points, Derivative::from(by));
            let (values, by_u, by_v) = (of([0, 0])?, of([1, 0])?, of([0, 1])?);
            for at in 0..points.len() {
                for rows in [&values, &by_u, &by_v] {
                    flux.rows.extend_from_slice(&rows[at * width..(at + 1) * width]);
                }
            }
            flux.cells.push((flux.vertices.len(), width, points.len()));
            flux.vertices.extend(cell.vertices.iter().map(|&v| v as u32));
            flux.weights.extend(points.iter().map(|(_, weight)| weight));
        }
        Ok(flux)
    }

    /// `F_i` for each `h`, one a vertex, into `out`; coordinates are taken from `origin`.
    pub(crate) fn integrate(&self, points: &[Point], origin: &Point, out: &mut Vec<Vec<Vector>>) {
        out.resize_with(if self.moments { 4 } else { 1 }, Vec::new);
        for out in out.iter_mut() {
            out.clear();
            out.resize(points.len(), Vector::zeros());
        }
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
