//! Faces whose loops run the wrong way round, so that they are all of their surface but what they should be.

use loftsman_kernel::Vector;
use loftsman_kernel::brep::{Brep, Face, Parts, Use};
use loftsman_kernel::error::Result;
use loftsman_kernel::spline::part::Part;

/// Directions into two faces at their edge whose cosine is more than this: one lies back on the other.
const BACK: f64 = 0.999;
/// Places of an edge at which they are compared, and of a side of the parameter plane at which it is asked what is inside.
const PLACES: [f64; 3] = [0.21, 0.5, 0.83];

/// Turns round the loops of the faces of a Brep of which what they leave reaches beyond the ends of the surface; how many. The normals stay.
pub(super) fn turn_beyond(brep: &Brep, parts: &mut Parts) -> Result<usize> {
    let mut turned = 0;
    for (number, face) in parts.faces.iter_mut().enumerate() {
        if !face.loops.is_empty() && reaches_beyond(&brep.part(number)?)? {
            turn_loops(face);
            turned += 1;
        }
    }
    Ok(turned)
}

/// Turns round the loops of faces of surfaces that close, so that either part may be meant, and that lie back on the faces beside them at
/// their edges: the other part goes on from these smoothly. How many. The normals stay.
pub(super) fn turn_back(parts: &mut Parts) -> Result<usize> {
    let back = lying_back(parts)?;
    back.iter().for_each(|&face| turn_loops(&mut parts.faces[face]));
    Ok(back.len())
}

fn turn_loops(face: &mut Face) {
    for uses in &mut face.loops {
        uses.reverse();
        uses.iter_mut().for_each(|one| one.reversed = !one.reversed);
    }
}

/// Whether what the loops of a face leave goes on where its surface ends.
fn reaches_beyond(part: &Part) -> Result<bool> {
    let surface = part.surface();
    let size = surface.points().iter().map(|p| (p - surface.points()[0]).amax()).fold(0.0, f64::max);
    let sides = surface.parameter_sides(1e-6 * size)?;
    for d in 0..2 {
        let (side, other) = (&sides[d], &sides[1 - d]);
        if side.closed || side.poles.iter().any(|pole| *pole) {
            continue;
        }
        for share in PLACES {
            let across = other.low + (other.high - other.low) * share;
            for along in [side.low - 0.5 * side.length(), side.high + 0.5 * side.length()] {
                if part.has(if d == 0 { [along, across] } else { [across, along] }) {
                    return Ok(true);
                }
            }
        }
    }
    Ok(false)
}

/// The faces of surfaces that close which lie back on those beside them at every edge where the two meet in one tangent plane, and do so at one at least.
fn lying_back(parts: &Parts) -> Result<Vec<usize>> {
    let mut uses: Vec<Vec<(usize, &Use)>> = vec![Vec::new(); parts.edges.len()];
    for (number, face) in parts.faces.iter().enumerate() {
        for one in face.loops.iter().flatten() {
            uses[one.edge].push((number, one));
        }
    }
    let mut may = Vec::with_capacity(parts.faces.len());
    for face in &parts.faces {
        may.push(closes(face)?);
    }
    let mut votes = vec![[0_usize; 2]; parts.faces.len()];
    for (edge, uses) in uses.iter().enumerate() {
        let [(f, one), (g, other)] = uses[..] else { continue };
        if f == g || !(may[f] || may[g]) {
            continue;
        }
        let mut cosines = Vec::new();
        for share in PLACES {
            if let (Some(a), Some(b)) =
                (into(parts, edge, f, one, share)?, into(parts, edge, g, other, share)?)
            {
                cosines.push(a.dot(&b));
            }
        }
        let all = |test: &dyn Fn(f64) -> bool| !cosines.is_empty() && cosines.iter().all(|c| test(*c));
        for (back, test) in [(0, &(|c: f64| c < -BACK) as &dyn Fn(f64) -> bool), (1, &|c: f64| c > BACK)] {
            if all(test) {
                votes[f][back] += 1;
                votes[g][back] += 1;
            }
        }
    }
    let mut all = Vec::new();
    for (face, [on, back]) in votes.into_iter().enumerate() {
        if on == 0 && back > 0 && may[face] {
            all.push(face);
        }
    }
    Ok(all)
}

/// Whether a surface closes in some direction, and ends nowhere.
fn closes(face: &Face) -> Result<bool> {
    let points = face.surface.points();
    let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
    let sides = face.surface.parameter_sides(1e-6 * size)?;
    let ends = |d: usize| !sides[d].closed && !sides[d].poles.iter().all(|pole| *pole);
    Ok((0..2).any(|d| sides[d].closed) && !(0..2).any(ends))
}

/// The direction into a face across an edge of it: to the left of the way that its loop runs, seen against its normal.
fn into(parts: &Parts, edge: usize, face: usize, one: &Use, share: f64) -> Result<Option<Vector>> {
    let own = &parts.edges[edge];
    let t = own.range.0 + (own.range.1 - own.range.0) * share;
    let (point, along) = (own.curve.point(t)?, own.curve.derivative(t, 1)?);
    let face = &parts.faces[face];
    let (u, v) = face.surface.closest_foot(point)?.at;
    let normal = face.surface.derivative(u, v, 1, 0)?.cross(&face.surface.derivative(u, v, 0, 1)?);
    let turned = one.reversed != face.reversed;
    let across = normal.cross(&along) * if turned { -1.0 } else { 1.0 };
    Ok(across.try_normalize(0.0).filter(|across| across.iter().all(|c| c.is_finite())))
}
