//! A shape in pieces so small that triangles between their points are near to it: what feet are looked for on.

use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Derivative, Domain, Location, Shape};
use loftsman_kernel::solve::Symmetric;
use loftsman_kernel::{Point, Vector};
use std::sync::OnceLock;

use super::model::mean_square;
use super::rows::Rows;

/// Pieces of a surface, and of a curve, at least; and divisions of a patch in one direction, at most.
const SURFACE: usize = 1000;
const CURVE: usize = 200;
const DIVISIONS: usize = 32;
/// How many times the size of points and shape together any place of it goes from where it began. Without an energy a loop that no point sees may
/// grow for ever, each step nearer by less: then nobody finds feet on it, nor wants it.
const REACH: f64 = 10.0;

/// A face of the shape, or a box of its parameters.
#[derive(Debug, Clone, Copy)]
struct Patch {
    face: Option<u32>,
    start: [f64; 2],
    end: [f64; 2],
}

/// A piece of a patch, and the numbers of nine of its points: three rows along `u`, each of three along `v`. Those of a curve are
/// three, each three times.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    patch: u32,
    start: [f64; 2],
    end: [f64; 2],
    samples: [[u32; 3]; 3],
}

/// The pieces of a shape, and the rows of their points over its control vertices: they do not change where these move.
#[derive(Debug)]
pub(super) struct Patches {
    patches: Vec<Patch>,
    pieces: Vec<Piece>,
    rows: Rows,
    curve: bool,
    domain: Domain,
    still: OnceLock<Symmetric>,
}

impl Patches {
    /// Those of the faces, where a shape has many; else of its cells; of one that does not say them as many as it has control
    /// vertices. Cost: some rows a piece.
    ///
    /// # Errors
    /// When the shape's cells or its stencils are wrong.
    pub(super) fn new(shape: &dyn Shape) -> Result<Self> {
        let domain = shape.domain();
        let curve = domain.len() < 2;
        let patches = patches_of(shape, &domain)?;
        let wanted = if curve { CURVE as f64 } else { SURFACE as f64 };
        let share = wanted / patches.len().max(1) as f64;
        let divisions = (if curve { share } else { share.sqrt() }).ceil() as usize;
        let divisions = divisions.clamp(2, DIVISIONS);
        let (rows, still) = (Rows::default(), OnceLock::new());
        let mut all = Self { patches, pieces: Vec::new(), rows, curve, domain, still };
        for patch in 0..all.patches.len() {
            all.divide(shape, patch, divisions)?;
        }
        Ok(all)
    }

    fn divide(&mut self, shape: &dyn Shape, index: usize, divisions: usize) -> Result<()> {
        let patch = self.patches[index];
        let first = self.rows.len() as u32;
        let lines = 2 * divisions + 1;
        let columns = if self.curve { 1 } else { lines };
        let share = |k: usize| k as f64 / (lines - 1) as f64;
        for i in 0..lines {
            for j in 0..columns {
                let at = patch.at([share(i), if self.curve { 0.0 } else { share(j) }], self.curve);
                self.rows.push(&shape.stencil(at, Derivative::POSITION)?);
            }
        }
        let across = if self.curve { 1 } else { divisions };
        for i in 0..divisions {
            for j in 0..across {
                let number = |a: usize, b: usize| {
                    let column = if self.curve { 0 } else { 2 * j + b };
                    first + ((2 * i + a) * columns + column) as u32
                };
                let samples = std::array::from_fn(|a| std::array::from_fn(|b| number(a, b)));
                let inner =
                    |k: usize| [share(2 * i + 2 * k), if self.curve { 0.0 } else { share(2 * j + 2 * k) }];
                let (start, end) = (patch.place(inner(0)), patch.place(inner(1)));
                self.pieces.push(Piece { patch: index as u32, start, end, samples });
            }
        }
        Ok(())
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    pub(super) fn is_curve(&self) -> bool {
        self.curve
    }

    /// Whether pieces are of one room: a face, or the whole shape.
    pub(super) fn alike(&self, a: usize, b: usize) -> bool {
        let face = |piece: usize| self.patches[self.pieces[piece].patch as usize].face;
        face(a) == face(b)
    }

    /// How long a piece is in either direction.
    pub(super) fn size(&self, piece: usize) -> [f64; 2] {
        let Piece { start, end, .. } = self.pieces[piece];
        std::array::from_fn(|k| end[k] - start[k])
    }

    /// The points of all pieces, of a shape with these control vertices.
    pub(super) fn points(&self, vertices: &[Point]) -> Vec<Vector> {
        (0..self.rows.len()).map(|k| self.rows.apply(k, vertices)).collect()
    }

    /// The part of a way of the control vertices that takes no point of a piece farther than `size` at once, or than half of what is left to
    /// [`REACH`] times as far from where it `began`.
    ///
    /// Control vertices by themselves say nothing of how far a shape goes: those at the ends of knots that are not clamped are thousands of
    /// sizes away where it moves by a hundredth.
    pub(super) fn within(&self, began: &[Vector], vertices: &[Point], way: &[Vector], size: f64) -> f64 {
        let mut share = 1.0_f64;
        for (row, from) in began.iter().enumerate() {
            let (away, way) =
                ((self.rows.apply(row, vertices) - from) / size, self.rows.sum(row, way) / size);
            let (length, left) = (way.norm(), 0.5 * (REACH - away.norm()).max(0.0));
            let most = if (away + way).norm() > REACH - left { left.min(1.0) } else { 1.0 };
            if length > most {
                share = share.min(most / length);
            }
        }
        share
    }

    /// The matrix of the mean square of the way of the points of all pieces.
    pub(super) fn still(&self, count: usize) -> &Symmetric {
        self.still.get_or_init(|| mean_square(&self.rows, count))
    }

    /// The area of a surface, or the length of a curve, with these control vertices: that of triangles and lines between the points of all pieces.
    pub(super) fn measure(&self, vertices: &[Point]) -> f64 {
        let points = self.points(vertices);
        let by = |piece: &Piece, [a, b]: [usize; 2], [c, d]: [usize; 2]| {
            points[piece.samples[c][d] as usize] - points[piece.samples[a][b] as usize]
        };
        let line = |piece: &Piece| (0..2).map(|a| by(piece, [a, 0], [a + 1, 0]).norm()).sum::<f64>();
        // Half the product of the diagonals of each quarter.
        let quarters = |piece: &Piece| {
            let all = [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter();
            all.map(|[a, b]| {
                let (one, other) = (by(piece, [a, b], [a + 1, b + 1]), by(piece, [a, b + 1], [a + 1, b]));
                one.cross(&other).norm() / 2.0
            })
            .sum::<f64>()
        };
        self.pieces.iter().map(|piece| if self.curve { line(piece) } else { quarters(piece) }).sum()
    }

    /// The middle of each piece, and a vector along the normal there, as the diagonals of its corners have it.
    pub(super) fn middles(&self, vertices: &[Point]) -> Vec<[Vector; 2]> {
        let points = self.points(vertices);
        let at = |piece: &Piece, a: usize, b: usize| points[piece.samples[a][b] as usize];
        let middle = |piece: &Piece| {
            let [one, other] = [at(piece, 2, 2) - at(piece, 0, 0), at(piece, 0, 2) - at(piece, 2, 0)];
            [at(piece, 1, 1), one.cross(&other)]
        };
        self.pieces.iter().map(middle).collect()
    }

    /// Every how many pieces one is to be looked at, for no more than so many, or one a patch.
    pub(super) fn step(&self, most: usize) -> usize {
        let each = self.pieces.len().div_ceil(self.patches.len().max(1)).max(1);
        self.pieces.len().div_ceil(most).clamp(1, each)
    }

    /// Adds the row of the middle of a piece.
    pub(super) fn push_middle(&self, piece: usize, rows: &mut Rows) {
        rows.push_row(self.rows.row(self.pieces[piece].samples[1][1] as usize));
    }

    /// How many patches there are.
    pub(super) fn count(&self) -> usize {
        self.patches.len()
    }

    /// The patch of a piece.
    pub(super) fn patch(&self, piece: usize) -> u32 {
        self.pieces[piece].patch
    }

    /// The box of parameters that a foot may be looked for in from a piece, and the directions in which it is closed.
    pub(super) fn room(&self, piece: usize) -> Room {
        let face = self.patches[self.pieces[piece].patch as usize].face;
        let side = |k: usize| self.domain.get(k).map_or([0.0, 0.0], |i| [i.start, i.end]);
        let wraps = |k: usize| face.is_none() && self.domain.get(k).is_some_and(|i| i.periodic);
        Room { face, sides: [side(0), side(1)], wraps: [wraps(0), wraps(1)], curve: self.curve }
    }
}

/// The parameters of a face, or of the whole shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    face: Option<u32>,
    pub(super) sides: [[f64; 2]; 2],
    pub(super) wraps: [bool; 2],
    pub(super) curve: bool,
}

impl Room {
    pub(super) fn at(&self, [u, v]: [f64; 2]) -> Location {
        location(self.face, [u, v], self.curve)
    }

    /// The place with these parameters: once round where the direction is closed, else no farther than the border.
    pub(super) fn hold(&self, place: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| {
            let [start, end] = self.sides[k];
            if self.wraps[k] {
                (start + (place[k] - start).rem_euclid(end - start)).clamp(start, end)
            } else {
                place[k].clamp(start, end)
            }
        })
    }
}

impl Patch {
    fn place(&self, shares: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| self.start[k] + (self.end[k] - self.start[k]) * shares[k])
    }

    fn at(&self, shares: [f64; 2], curve: bool) -> Location {
        location(self.face, self.place(shares), curve)
    }
}

impl Piece {
    pub(super) fn samples(&self) -> &[[u32; 3]; 3] {
        &self.samples
    }

    /// The place with these shares of the piece.
    pub(super) fn place(&self, shares: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| self.start[k] + (self.end[k] - self.start[k]) * shares[k])
    }
}

fn location(face: Option<u32>, [u, v]: [f64; 2], curve: bool) -> Location {
    match face {
        Some(face) => Location::Face(face, u, v),
        None if curve => Location::Curve(u),
        None => Location::Surface(u, v),
    }
}

fn patches_of(shape: &dyn Shape, domain: &Domain) -> Result<Vec<Patch>> {
    let side = |k: usize| domain.get(k).map_or([0.0, 0.0], |i| [i.start, i.end]);
    let [u, v] = [side(0), side(1)];
    let whole = |face| Patch { face, start: [u[0], v[0]], end: [u[1], v[1]] };
    if let Some(count) = shape.faces() {
        return Ok((0..count).map(|face| whole(Some(face as u32))).collect());
    }
    if let Some(cells) = shape.cells() {
        let cells = cells.checked(shape)?;
        let ends = |sides: &[loftsman_kernel::shape::CellSide]| {
            let at = |k: usize| sides.get(k).map_or([0.0, 0.0], |side| [side.start, side.end]);
            let [u, v] = [at(0), at(1)];
            Patch { face: None, start: [u[0], v[0]], end: [u[1], v[1]] }
        };
        return Ok(cells.iter().map(|cell| ends(&cell.sides)).collect());
    }
    let count = shape.control_vertices().len() as f64;
    let each = (if domain.len() < 2 { count } else { count.sqrt() }).ceil().max(1.0) as usize;
    let across = if domain.len() < 2 { 1 } else { each };
    let part = |k: usize, of: usize, [start, end]: [f64; 2]| start + (end - start) * (k as f64 / of as f64);
    let patch = |k: usize| {
        let (i, j) = (k / across, k % across);
        let corner = |a: usize| [part(i + a, each, u), part(j + a, across, v)];
        Patch { face: None, start: corner(0), end: corner(1) }
    };
    Ok((0..each * across).map(patch).collect())
}
