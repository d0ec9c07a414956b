//! The integrals of [`Flux`](crate::flux::Flux) over a surface that is no tensor-product spline as a whole, by its cells: by the faces' splines, or by stencils.

use std::sync::Arc;

use loftsman_kernel::shape::{Cell, Hole, Shape, Share};
use loftsman_kernel::{Point, Result, Vector, parallel};

use crate::flux::{MOST, SETTLED, change, most, settled, unsettled};
use crate::members::Member;
use crate::row_flux::RowFlux;
use crate::span_flux::{self, SpanFlux, Spline};

/// Integrals over what fitted borders bound are refined until they change by less than this: the borders are not nearer.
const SETTLED_AT_BORDERS: f64 = 1e-10;

/// Gauss points of all cells, and of the cones over the holes that these leave.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CellFlux {
    parts: Vec<Part>,
    moments: bool,
}

/// What an integration works with.
#[derive(Debug, Default)]
pub(crate) struct Room {
    /// The vertices of a part, and what belongs to these.
    points: Vec<Point>,
    found: Vec<Vec<Vector>>,
    spans: span_flux::Room,
}

/// Some cells, or cones.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    own: Arc<Own>,
    points: Points,
}

/// The vertices that a part depends on: only there is it looked at.
#[derive(Debug, PartialEq)]
enum Own {
    /// Those of a spline.
    Of(Arc<Spline>),
    /// Ascending.
    These(Vec<u32>),
}

#[derive(Debug, Clone, PartialEq)]
enum Points {
    /// Of a face that is a spline.
    Spans(SpanFlux),
    /// Of any other one, and of cones.
    Rows(RowFlux),
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
        let face = |cells: &&[(Cell, Share)]| {
            let sense = sense(cells.first().and_then(|(cell, _)| cell.face));
            Face::new(surface, cells, sense, moments)
        };
        let own: Vec<Face<'_>> = faces.iter().map(face).collect();
        let made = parallel::map(faces.len(), |k| own[k].parts(faces[k]));
        let mut parts = Vec::new();
        for one in made {
            parts.extend(one?);
        }
        // Of a part of a surface it is not known how much of a hole counts.
        let mut holes = if surface.cells.is_partial() { Vec::new() } else { surface.cells.holes() };
        holes.retain(|hole| sense(hole.face) != 0.0);
        let faces: Vec<&[Hole]> = holes.chunk_by(|a, b| a.face == b.face).collect();
        let shape = surface.shape;
        let made = parallel::map(faces.len(), |k| {
            RowFlux::of_holes(shape, faces[k], |degree| exact(degree, moments), sense)
        });
        for one in made {
            let (own, rows) = one?;
            parts.push(Part { own: Arc::new(Own::These(own)), points: Points::Rows(rows) });
        }
        Ok(Self { parts, moments })
    }

    /// `F_i` for each `h`, one a vertex, into `out`; coordinates are taken from `origin`. Allocates nothing where `work` and `out` have been
    /// through it before.
    pub(crate) fn integrate(
        &self,
        points: &[Point],
        origin: &Point,
        work: &mut Room,
        out: &mut Vec<Vec<Vector>>,
    ) {
        start(out, self.moments, points.len());
        let Room { points: local, found, spans } = work;
        for part in &self.parts {
            part.own.gather(points, local);
            start(found, self.moments, local.len());
            part.points.integrate(local, origin, spans, found);
            for (out, found) in out.iter_mut().zip(found.iter()) {
                part.own.scatter(found, out);
            }
        }
    }
}

/// Zeros, one a vertex for each `h`.
fn start(out: &mut Vec<Vec<Vector>>, moments: bool, vertices: usize) {
    out.resize_with(if moments { 4 } else { 1 }, Vec::new);
    for out in out.iter_mut() {
        out.clear();
        out.resize(vertices, Vector::zeros());
    }
}

impl Own {
    fn gather(&self, all: &[Point], own: &mut Vec<Point>) {
        own.clear();
        match self {
            Self::Of(spline) => own.extend_from_slice(&all[spline.vertices()]),
            Self::These(vertices) => own.extend(vertices.iter().map(|&v| all[v as usize])),
        }
    }

    /// Adds what belongs to its vertices.
    fn scatter(&self, own: &[Vector], all: &mut [Vector]) {
        match self {
            Self::Of(spline) => {
                all[spline.vertices()].iter_mut().zip(own).for_each(|(all, own)| *all += own);
            }
            Self::These(vertices) => vertices.iter().zip(own).for_each(|(&v, own)| all[v as usize] += own),
        }
    }
}

impl Points {
    /// Adds their integrals, one for each of the part's own vertices.
    fn integrate(
        &self,
        points: &[Point],
        origin: &Point,
        work: &mut span_flux::Room,
        out: &mut [Vec<Vector>],
    ) {
        match self {
            Self::Spans(flux) => flux.integrate(points, origin, work, out),
            Self::Rows(flux) => flux.integrate(points, origin, out),
        }
    }
}

/// The cells of one face.
struct Face<'s> {
    shape: &'s dyn Shape,
    own: Arc<Own>,
    sense: f64,
    moments: bool,
}

impl<'s> Face<'s> {
    fn new(surface: &Member<'s>, cells: &[(Cell, Share)], sense: f64, moments: bool) -> Self {
        let face = cells.first().and_then(|(cell, _)| cell.face);
        let spline = surface.cells.patch(face).and_then(|patch| Spline::of(&patch));
        let known = surface.points().len();
        let whole = |spline: &Spline| {
            spline.vertices().end <= known && cells.iter().all(|(cell, _)| spline.has(cell))
        };
        let spline = spline.filter(whole);
        let own = match spline {
            Some(spline) => Own::Of(Arc::new(spline)),
            None => {
                let mut own: Vec<u32> =
                    cells.iter().flat_map(|(cell, _)| &cell.vertices).map(|&v| v as u32).collect();
                own.sort_unstable();
                own.dedup();
                Own::These(own)
            }
        };
        Self { shape: surface.shape, own: Arc::new(own), sense, moments }
    }

    /// So many points, beyond those that are exact for polynomials, on each of `parts` parts of cells in either direction.
    fn points(&self, cells: &[&(Cell, Share)], more: usize, parts: usize) -> Result<Points> {
        let counts = |degree: usize| exact(degree, self.moments) + more;
        match &*self.own {
            Own::Of(spline) => Ok(Points::Spans(SpanFlux::with(spline, cells, counts, parts, self.sense))),
            Own::These(own) => {
                RowFlux::with(self.shape, cells, own, counts, parts, self.sense).map(Points::Rows)
            }
        }
    }

    fn part(&self, points: Points) -> Part {
        Part { own: Arc::clone(&self.own), points }
    }

    /// The points of cells for which a rule is exact, and those of the others, refined until the integrals of both settle.
    fn parts(&self, cells: &[(Cell, Share)]) -> Result<Vec<Part>> {
        let counts = |cell: &Cell, more: usize| {
            [0, 1].map(|k| exact(cell.sides.get(k).map_or(0, |side| side.degree), self.moments) + more)
        };
        let is_exact = |(cell, share): &&(Cell, Share)| {
            let bounded = match share {
                Share::Part(part) => part.is_exact(counts(cell, 0)),
                _ => true,
            };
            bounded && !cell.rational
        };
        let (plain, cells): (Vec<_>, Vec<_>) = cells.iter().partition(is_exact);
        let plain = self.points(&plain, 0, 1)?;
        if cells.is_empty() {
            return Ok(vec![self.part(plain)]);
        }
        let mut points = Vec::new();
        self.own.gather(self.shape.control_vertices(), &mut points);
        let middle = crate::members::middle_of(&points);
        let (mut beside, mut last, mut now) = (Vec::new(), Vec::new(), Vec::new());
        let mut work = span_flux::Room::default();
        start(&mut beside, self.moments, points.len());
        plain.integrate(&points, &middle, &mut work, &mut beside);
        let mut integrate = |found: &Points, out: &mut Vec<Vec<Vector>>| {
            out.clone_from(&beside);
            found.integrate(&points, &middle, &mut work, out);
        };
        let mut found = self.points(&cells, 0, 1)?;
        integrate(&found, &mut last);
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
        let both = |found: Points| vec![self.part(plain.clone()), self.part(found)];
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
            let finer = self.points(&cells, more, parts)?;
            integrate(&finer, &mut now);
            if bounded {
                let change = change(&now, &last, &points, &middle);
                if change <= SETTLED {
                    return Ok(both(found));
                }
                near = change <= SETTLED_AT_BORDERS;
            } else if settled(&now, &last, &points, &middle)? {
                return Ok(both(found));
            }
            found = finer;
            std::mem::swap(&mut last, &mut now);
            if near && parts > 2 {
                return Ok(both(found));
            }
        }
        if near { Ok(both(found)) } else { Err(unsettled()) }
    }
}

/// So many Gauss points are exact for the flux of polynomials of a degree: it has degree `3p - 1`, with moments `4p - 1`.
fn exact(degree: usize, moments: bool) -> usize {
    if moments { (2 * degree).max(1) } else { (3 * degree).div_ceil(2).max(1) }
}
