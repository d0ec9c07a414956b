//! How far a surface is from triangles between limits of vertices, certified.

use std::cmp::Ordering;

use loftsman_kernel::error::Result;
use loftsman_kernel::{Point, Vector, parallel};

use super::net::{Net, beyond, beyond_all, bezier, hull_of, largest, net_of};
use super::pattern::{Pattern, Quadrant};
use super::refused;
use super::regular;
use super::template::{Near, Templates};
use super::tessellate::HALVES;
use super::triangle::from_triangle;
use crate::cage::Cage;

/// A neighbourhood that is no further from a triangle than this part of the chord is not looked into.
const ENOUGH: f64 = 0.02;
/// Levels that are looked into, at most. Neighbourhoods shrink by a third and more a level, so that this is beyond rounding.
const LEVELS: u32 = 56;

/// A bound of the distance that the limit of a cage of quads has from the two triangles of each, between limits of vertices; `None` where
/// it is more than the chord. Cost: linear; of an irregular quad that of its quadrants.
pub(super) fn apart(templates: &Templates, cage: &Cage, limits: &[Point], chord: f64) -> Result<Option<f64>> {
    let faces = parallel::map(cage.topology().face_count(), |face| {
        if cage.is_hole(face) { Ok(0.0) } else { of_face(templates, cage, limits, face, chord) }
    });
    let mut most = Some(0.0_f64);
    for bound in faces {
        let bound = bound?;
        most = most.filter(|_| bound <= chord).map(|most| most.max(bound));
    }
    Ok(most)
}

fn of_face(templates: &Templates, cage: &Cage, limits: &[Point], face: usize, chord: f64) -> Result<f64> {
    let corners = cage.topology().face(face);
    let triangles = HALVES.map(|half| half.map(|k| limits[corners[k] as usize]));
    if let Some(rows) = regular::net(cage, face) {
        let point = |v: u32| cage.points()[v as usize].coords;
        let net: Net = rows.map(|row| row.iter().fold(Vector::zeros(), |sum, &(v, c)| sum + point(v) * c));
        let patch = bezier(&net);
        let own = beyond(&patch, [&triangles[0], &triangles[1]], chord);
        return Ok(if own <= chord { own } else { beyond_all(&patch, &round(cage, limits, face), chord, 0) });
    }
    let pattern = Pattern::of_quad(cage, face);
    let near = Near::from_corner(cage, face, 0).map_err(refused)?;
    let point = |k: usize| cage.points()[near.base[k] as usize].coords;
    let (mut most, mut rest) = (0.0_f64, Quadrant::WHOLE.parts().to_vec());
    while let Some(quadrant) = rest.pop() {
        if most > chord {
            break;
        }
        if pattern.is_regular(quadrant)
            && let Some(piece) = templates.piece(cage, &near, quadrant).map_err(refused)?
        {
            let patch = bezier(&net_of(&piece, point));
            let own = of_piece(&patch, quadrant, &triangles, chord);
            let bound =
                if own <= chord { own } else { beyond_all(&patch, &round(cage, limits, face), chord, 0) };
            most = most.max(bound);
            continue;
        }
        let local = templates.local(cage, &near, quadrant).map_err(refused)?;
        let hull: Vec<Point> = hull_of(&local, point).into_iter().map(Point::from).collect();
        let from = |t: &[Point; 3]| largest(hull.iter().map(|q| from_triangle(q, t)));
        let bound = from(&triangles[0]).min(from(&triangles[1]));
        if bound <= most.max(ENOUGH * chord) || quadrant.level >= LEVELS {
            most = most.max(bound);
        } else {
            rest.extend(quadrant.parts());
        }
    }
    Ok(most)
}

/// A quadrant beside the diagonal belongs to one triangle, one on it with either half to another.
fn of_piece(patch: &Net, quadrant: Quadrant, triangles: &[[Point; 3]; 2], chord: f64) -> f64 {
    let Quadrant { i, j, .. } = quadrant;
    let own = match i.cmp(&j) {
        Ordering::Greater => [0, 0],
        Ordering::Less => [1, 1],
        Ordering::Equal => [0, 1],
    };
    beyond(patch, own.map(|half| &triangles[half]), chord)
}

/// The triangles of a quad and of all that share a vertex with it, without holes.
fn round(cage: &Cage, limits: &[Point], face: usize) -> Vec<[Point; 3]> {
    let topology = cage.topology();
    let mut faces: Vec<u32> =
        topology.face(face).iter().flat_map(|&v| topology.vertex_faces(v as usize)).collect();
    faces.sort_unstable();
    faces.dedup();
    let shown = faces.into_iter().filter(|&f| !cage.is_hole(f as usize));
    let corner = |f: u32, k: usize| limits[topology.face(f as usize)[k] as usize];
    shown.flat_map(|f| HALVES.map(|half| half.map(|k| corner(f, k)))).collect()
}
