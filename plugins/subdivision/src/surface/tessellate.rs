//! A surface as triangles between limits of vertices.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{Chord, Drawn, Faceted, Fineness};
use loftsman_kernel::{Point, Vector};

use super::apart::apart;
use super::places::Places;
use super::sampled::sampled;
use super::template::Templates;
use super::{SubdivisionSurface, refused};
use crate::cage::Cage;
use crate::catmull_clark::{Refinement, limit_frames, limit_points};

/// Vertices of a level, at most.
const MOST: usize = 1 << 21;
/// Levels more than the chord needs, at most, for the sake of the angle: where the surface is folded it is never small.
const FOR_ANGLE: usize = 4;
/// Levels more than were found to be enough, at most, for the sake of a proof: round vertices that are sharp to a finite degree bounds are
/// coarse.
const FOR_PROOF: usize = 1;
/// Vertices of a level that is made for the sake of the angle, at most.
const MOST_FOR_ANGLE: usize = 1 << 17;

/// The states of a surface as the same triangles: all faces refined as often as the worst of them needs, vertices at their limits, quads
/// halved. The error is a bound of the distance that any point of the surface has from the triangles: of regular quads by the second
/// differences of their Bézier points, of others by those of the quadrants they consist of, down to one whose neighbourhood, in the hull of which
/// it lies, is near enough. Where that takes more than a
/// level beyond what is found to be enough in the middles of edges and faces, it is that, and not certified. Cost: linear in the finest level, for every level and state.
///
/// # Errors
/// [`Error::NoExtent`] where all is one point; when there is no state, the states are different surfaces, the fineness is not positive,
/// or more than two million vertices are needed.
pub(super) fn tessellate(states: &[&SubdivisionSurface], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
    };
    let alike = |s: &&SubdivisionSurface| {
        let (a, b) = (&s.cage, &first.cage);
        a.topology() == b.topology()
            && (&a.creases, &a.corners, &a.holes, a.boundary)
                == (&b.creases, &b.corners, &b.holes, b.boundary)
    };
    if !states.iter().all(alike) {
        return Err(Error::Invalid(
            "the states of the surface have different faces or creases: they are not one surface".into(),
        ));
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let (Chord::Absolute(chord) | Chord::Relative(chord)) = fineness.chord;
    if !positive(chord) || !positive(fineness.angle) {
        return Err(Error::Invalid(
            "the chord and the angle of a tessellation must be positive and finite".into(),
        ));
    }
    let mut cages: Vec<Cage> = states.iter().map(|s| s.cage.clone()).collect();
    let mut limits = all_limits(&cages)?;
    let sizes: Vec<f64> = limits.iter().map(|points| diagonal(points)).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(Error::NoExtent("all of the surface is one point".into()));
    }
    if !largest.is_finite() {
        return Err(Error::Invalid("the surface has points that are not finite".into()));
    }
    let chords: Vec<f64> = sizes
        .iter()
        .map(|size| match fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(part) => part * size.max(largest * 1e-3),
        })
        .collect();
    let templates = Templates::default();
    let (mut since_chord, mut since_found) = (0, 0);
    let mut places = Places::new(first);
    loop {
        let topology = cages[0].topology();
        let count = topology.vertex_count() + topology.edge_count() + topology.face_count();
        if count > MOST {
            return Err(Error::Invalid(format!(
                "the tessellation would take more than {MOST} vertices: ask for a larger chord than {chord}"
            )));
        }
        let errors = bounds(&templates, &cages, &limits, &chords)?;
        let near = errors.is_some();
        since_chord += usize::from(near);
        let enough = since_chord > FOR_ANGLE || count > MOST_FOR_ANGLE;
        if let Some(error) = errors
            && (enough || cages.iter().all(|c| turns(c) <= fineness.angle))
        {
            let tolerance = chords.iter().copied().fold(0.0, f64::max);
            let drawn = Drawn::Mesh(mesh(&cages[0], &limits[0])?);
            let places = places.of_vertices(&cages[0]);
            return Ok(Faceted { drawn, states: limits, tolerance, error, certified: true, places });
        }
        let next = cages.iter().map(next_level).collect::<Result<Vec<_>>>()?;
        let finer = all_limits(&next)?;
        let found: Vec<f64> = (0..cages.len()).map(|k| sampled(&cages[k], &limits[k], &finer[k])).collect();
        since_found += usize::from(found.iter().zip(&chords).all(|(error, chord)| *error <= 0.9 * chord));
        if !near && since_found > FOR_PROOF && topology.is_quads() {
            let tolerance = chords.iter().copied().fold(0.0, f64::max);
            let error = found.into_iter().fold(0.0, f64::max);
            let drawn = Drawn::Mesh(mesh(&cages[0], &limits[0])?);
            let places = places.of_vertices(&cages[0]);
            return Ok(Faceted { drawn, states: limits, tolerance, error, certified: false, places });
        }
        places = places.refined(topology);
        (cages, limits) = (next, finer);
    }
}

/// A bound of the distance of the surface from the triangles, in the worst state; `None` where it is more than the chord somewhere, or
/// faces are no quads yet.
fn bounds(
    templates: &Templates,
    cages: &[Cage],
    limits: &[Vec<Point>],
    chords: &[f64],
) -> Result<Option<f64>> {
    let mut most: f64 = 0.0;
    for ((cage, limits), &chord) in cages.iter().zip(limits).zip(chords) {
        if !cage.topology().is_quads() {
            return Ok(None);
        }
        match apart(templates, cage, limits, chord)? {
            Some(error) => most = most.max(error),
            None => return Ok(None),
        }
    }
    Ok(Some(most))
}

fn all_limits(cages: &[Cage]) -> Result<Vec<Vec<Point>>> {
    cages.iter().map(|cage| limit_points(cage).map_err(refused)).collect()
}

fn next_level(cage: &Cage) -> Result<Cage> {
    let refinement = Refinement::new(cage.clone(), 1).map_err(refused)?;
    Ok(refinement.finest().clone())
}

pub(super) fn diagonal(points: &[Point]) -> f64 {
    let start = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    let (low, high) = points.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// The triangles of a quad between the diagonal from its first corner.
pub(super) const HALVES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// The largest angle between normals at the ends of an edge, as far as there are normals.
fn turns(cage: &Cage) -> f64 {
    let Ok(frames) = limit_frames(cage) else { return 0.0 };
    let normals: Vec<Option<Vector>> = frames.iter().map(crate::LimitFrame::normal).collect();
    let topology = cage.topology();
    let sharp = |v: u32| {
        cage.vertex_sharpness(v as usize) > 0.0
            || topology.vertex_edges(v as usize).any(|e| cage.crease(e as usize) > 0.0)
    };
    let turn = |[a, b]: [u32; 2]| match (normals[a as usize], normals[b as usize]) {
        (Some(m), Some(n)) if !sharp(a) && !sharp(b) => m.angle(&n),
        _ => 0.0,
    };
    (0..topology.edge_count()).filter_map(|e| topology.edge(e)).map(turn).fold(0.0, f64::max)
}

fn mesh(cage: &Cage, limits: &[Point]) -> Result<Mesh> {
    let topology = cage.topology();
    let faces = (0..topology.face_count()).filter(|&f| !cage.is_hole(f));
    let corners: Vec<u32> =
        faces.flat_map(|f| HALVES.as_flattened().iter().map(move |&k| topology.face(f)[k])).collect();
    let starts = (0..=corners.len() / 3).map(|k| 3 * k).collect();
    let mut mesh = Mesh::from_parts(limits.to_vec(), corners, starts)?;
    let normals = limit_frames(cage).map_err(refused)?;
    let normals: Vec<Vector> = normals.iter().map(|f| f.normal().unwrap_or_else(Vector::z)).collect();
    mesh.normals = Layer::per_point(normals);
    Ok(mesh)
}
