//! Doo and Sabin's limit edited, joined, dragged, faired and measured, each against refinement by hand.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

mod fair;
mod joins;
mod moves;

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_subdivision::doo_sabin::DooSabinSurface;

use crate::shapes::duals::{Spot, spot};
use crate::shapes::plain::Plain;
use crate::shapes::wild::{self, Dice};

/// The mesh with the points that an edit came to.
pub(crate) fn moved(plain: &Plain, shape: &dyn Shape) -> Plain {
    let points = shape.control_vertices().iter().map(|p| p.coords).collect();
    Plain { points, ..plain.clone() }
}

/// A mesh of any size and anywhere, closed, open, or with a face that is a hole; of triangles to octagons, three to eight edges at a vertex.
pub(crate) struct Case {
    pub(crate) plain: Plain,
    pub(crate) surface: DooSabinSurface,
    pub(crate) size: f64,
    pub(crate) name: String,
}

pub(crate) fn case(seed: u64) -> Option<Case> {
    let mut dice = Dice::new(seed + 40_000);
    let mut plain = wild::closed(seed);
    let kind = ["closed", "open", "with a hole", "refined"][(seed % 4) as usize];
    match kind {
        "open" => plain = wild::opened(plain, seed),
        "refined" => plain = plain.dual(),
        _ => {}
    }
    let size = [1.0, 1e-9, 1e9, 1.0][(seed / 4 % 4) as usize];
    let aside = dice.vector() * if seed.is_multiple_of(3) { 5.0 } else { 0.0 };
    plain.points.iter_mut().for_each(|p| *p = (*p + aside) * size);
    let mut cage = plain.cage().unwrap();
    if kind == "with a hole" {
        cage = cage.with_hole(dice.below(plain.faces.len())).unwrap();
    }
    // A vertex of two edges has no surface round it, and one of the boundary none at all.
    let surface = DooSabinSurface::new(cage).ok()?;
    Some(Case { plain, surface, size, name: format!("{seed}, {kind}, size {size:e}") })
}

impl Case {
    /// A face of the surface and a place of it, in sixteenths, where the surface is one polynomial.
    pub(crate) fn place(&self, dice: &mut Dice) -> (u32, [f64; 2]) {
        let face = dice.below(self.surface.faces().unwrap()) as u32;
        (face, [0, 1].map(|_| (1 + 2 * dice.below(8)) as f64 / 16.0))
    }

    /// By hand, of the points that a shape has.
    pub(crate) fn spot(&self, shape: &dyn Shape, (face, at): (u32, [f64; 2])) -> Spot {
        let (of, corner) = self.surface.cage_corner(face).unwrap();
        spot(&moved(&self.plain, shape), of, corner, at)
    }
}

pub(crate) fn location((face, [u, v]): (u32, [f64; 2])) -> Location {
    Location::Face(face, u, v)
}

/// The number of an edge of the surface: of the quarter at the corner `inner` of a face, the side that ends between it and `outer`, a vertex of the boundary.
pub(crate) fn side(surface: &DooSabinSurface, face: usize, inner: usize, outer: usize) -> usize {
    let corners = surface.cage().topology().face(face);
    let at = corners.iter().position(|&v| v as usize == inner).unwrap();
    let before = corners[(at + corners.len() - 1) % corners.len()] as usize == outer;
    let own = surface.face_of(face, at).unwrap().unwrap();
    let name = format!("{own} {}", if before { "v=0" } else { "u=0" });
    Shape::edges(surface).unwrap().iter().position(|e| e.name == name).unwrap()
}

/// The same side by hand: the place at `t` from the middle of the face, and the derivative into the surface.
pub(crate) fn on_side(plain: &Plain, face: usize, inner: usize, outer: usize, t: f64) -> [Vector; 2] {
    let corners = &plain.faces[face];
    let at = corners.iter().position(|&v| v == inner).unwrap();
    let before = corners[(at + corners.len() - 1) % corners.len()] == outer;
    let Spot { place, along } = spot(plain, face, at, if before { [t, 0.0] } else { [0.0, t] });
    [place, along[usize::from(before)]]
}
