//! The integrals of [`Flux`](crate::flux::Flux) over a surface that is no tensor-product spline, by its cells and stencils.

use loftsman_kernel::shape::{Cell, Derivative, Hole, Shape, Share, rows_at};
use loftsman_kernel::{Point, Result, Vector, parallel};

use crate::cone::Cones;
use crate::flux::{MOST, SETTLED, change, most, settled, unsettled};
use crate::members::Member;

/// Integrals over what fitted borders bound are refined until they change by less than this: the borders are not nearer.
const SETTLED_AT_BORDERS: f64 = 1e-10;

/// Gauss points of all cells, and of the cones over the holes that these leave, with the functions there and their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CellFlux {
    vertices: Vec<u32>,
    /// For each cell, and for the cones of each hole, where its vertices start, how many they are, and how many points it has.
    cells: Vec<(usize, usize, usize)>,
    weights: Vec<f64>,
    /// For each point the values, `u` and `v` derivatives of its cell's functions, one after another.
    rows: Vec<f64>,
    moments: bool,
}

impl CellFlux {
    /// For the surfaces that differ from this one in their control vertices only; with `moments` for all four `h`. Exact where the
    /// cells are polynomial, and what bounds them in the parameter plane; else refined, face by face, until the present integrals settle to
    /// 1e-13 (borders: to 1e-10 where they do not get nearer). Holes are closed by cones, so that integrals over what is closed do not depend on
    /// the origin.
    pub(crate) fn new(surface: &Member<'_>, moments: bool) -> Result<Self> {
        let mut counted = surface.cells.counted(surface.shape)?;
        let senses = surface.cells.senses().transpose()?;
        let sense = |face: Option<u32>| match (&senses, face) {
            (Some(senses), Some(face)) => senses.get(face as usize).copied().unwrap_or(0.0),
            _ => 1.0,
        };
        counted.retain(|(cell, _)| sense(cell.face) != 0.0);
        let faces: Vec<&[(Cell, Share)]> = counted.chunk_by(|a, b| a.0.face == b.0.face).collect();
        let shape = surface.shape;
        let made = parallel::map(faces.len(), |k| {
            let face = faces[k].first().and_then(|(cell, _)| cell.face);
            Self::of_face(shape, faces[k], sense(face), moments)
        });
        let mut all = Self::empty(moments);
        for one in made {
            all.append(one?);
        }
        // Of a part of a surface it is not known how much of a hole counts.
        let mut holes = if surface.cells.is_partial() { Vec::new() } else { surface.cells.holes() };
        holes.retain(|hole| sense(hole.face) != 0.0);
        let faces: Vec<&[Hole]> = holes.chunk_by(|a, b| a.face == b.face).collect();
        let made = parallel::map(faces.len(), |k| Self::of_holes(shape, faces[k], &sense, moments));
        for one in made {
            all.append(one?);
        }
        Ok(all)
    }

    /// The cones over the holes of a face.
    fn of_holes(
        shape: &dyn Shape,
        holes: &[Hole],
        sense: &impl Fn(Option<u32>) -> f64,
        moments: bool,
    ) -> Result<Self> {
        let mut flux = Self::empty(moments);
        for hole in holes {
            let cones = Cones::new(shape, hole, |degree| exact(degree, moments))?;
            flux.cells.push((flux.vertices.len(), cones.vertices.len(), cones.weights.len()));
            flux.vertices.extend(cones.vertices.iter().map(|&v| v as u32));
            flux.weights.extend(cones.weights.iter().map(|weight| weight * sense(hole.face)));
            flux.rows.extend(cones.rows);
        }
        Ok(flux)
    }

    fn empty(moments: bool) -> Self {
        Self { vertices: Vec::new(), cells: Vec::new(), weights: Vec::new(), rows: Vec::new(), moments }
    }

    fn append(&mut self, other: Self) {
        let start = self.vertices.len();
        self.vertices.extend(other.vertices);
        self.cells.extend(other.cells.into_iter().map(|(at, width, count)| (at + start, width, count)));
        self.weights.extend(other.weights);
        self.rows.extend(other.rows);
    }

    /// The cells of one face.
    fn of_face(shape: &dyn Shape, cells: &[(Cell, Share)], sense: f64, moments: bool) -> Result<Self> {
        let exact = |degree: usize| exact(degree, moments);
        let flux = Self::with(shape, cells, exact, 1, sense, moments)?;
        let counts = |cell: &Cell, more: usize| {
            [0, 1].map(|k| exact(cell.sides.get(k).map_or(0, |side| side.degree)) + more)
        };
        let plain = |(cell, share): &(Cell, Share)| {
            let bounded = match share {
                Share::Part(part) => part.is_exact(counts(cell, 0)),
                _ => true,
            };
            bounded && !cell.rational
        };
        if cells.iter().all(plain) {
            return Ok(flux);
        }
        // What only some cells depend on is looked at there only.
        let mut own: Vec<u32> = flux.vertices.clone();
        own.sort_unstable();
        own.dedup();
        let points: Vec<Point> =
            own.iter().filter_map(|&v| shape.control_vertices().get(v as usize)).copied().collect();
        let middle = crate::members::middle_of(&points);
        let (mut flux, mut last, mut now) = (flux, Vec::new(), Vec::new());
        let integrate = |flux: &Self, out: &mut Vec<Vec<Vector>>| {
            let mut local = flux.clone();
            local.vertices.iter_mut().for_each(|v| *v = own.binary_search(v).unwrap_or(0) as u32);
            local.integrate(&points, &middle, out);
        };
        integrate(&flux, &mut last);
        let bounded = cells.iter().any(|(_, share)| matches!(share, Share::Part(_)));
        let (mut more, mut parts) = (0, 1);
        let count = |more: usize, parts: usize| {
            let each = cells.iter().map(|(cell, _)| {
                let [p, q] = counts(cell, more);
                p.saturating_mul(q).saturating_mul(parts * parts)
            });
            each.fold(0_usize, usize::saturating_add)
        };
        let most = most(count(more, parts));
        let highest = cells.iter().flat_map(|(cell, _)| counts(cell, 0)).max().unwrap_or(1);
        let mut near = false;
        for _ in 0..12 {
            if highest + more < MOST {
                more += 4;
            } else {
                parts *= 2;
            }
            if count(more, parts) > most {
                break;
            }
            let finer = Self::with(shape, cells, |degree| exact(degree) + more, parts, sense, moments)?;
            integrate(&finer, &mut now);
            if bounded {
                let change = change(&now, &last, &points, &middle);
                if change <= SETTLED {
                    return Ok(flux);
                }
                near = change <= SETTLED_AT_BORDERS;
            } else if settled(&now, &last, &points, &middle)? {
                return Ok(flux);
            }
            flux = finer;
            std::mem::swap(&mut last, &mut now);
            if near && parts > 2 {
                return Ok(flux);
            }
        }
        if near { Ok(flux) } else { Err(unsettled()) }
    }

    /// So many points, which depend on the degree, on each of `parts` parts of a cell in either direction.
    fn with(
        shape: &dyn Shape,
        cells: &[(Cell, Share)],
        counts: impl Fn(usize) -> usize,
        parts: usize,
        sense: f64,
        moments: bool,
    ) -> Result<Self> {
        let mut flux = Self::empty(moments);
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
            flux.vertices.extend(cell.vertices.iter().map(|&v| v as u32));
            flux.weights.extend(points.iter().map(|(_, weight)| weight * sense));
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

/// So many Gauss points are exact for the flux of polynomials of a degree: it has degree `3p - 1`, with moments `4p - 1`.
fn exact(degree: usize, moments: bool) -> usize {
    if moments { (2 * degree).max(1) } else { (3 * degree).div_ceil(2).max(1) }
}
