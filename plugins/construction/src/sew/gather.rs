//! The faces of objects with edges and vertices of their own, before anything is sewn.

use loftsman_kernel::Point;
use loftsman_kernel::brep::{CurveForm, Edge, Face, Parts, SurfaceForm, Use, Vertex};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Trimmed};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::text::a;

use super::inward;

/// At so many places of a curve in the parameter plane it is seen which way its loop runs.
const PLACES: usize = 16;

/// An edge that is no longer than this part of the tolerance is a point.
const POINT: f64 = 1e-3;

/// What was done to faces before they were sewn, and while they were.
#[derive(Debug, Default)]
pub(super) struct Healed {
    /// How many edges no longer than the tolerance were left out; and the longest of them. Points, as sides at poles are, are none.
    pub(super) short: usize,
    pub(super) longest: f64,
    /// How many faces were all of their surface but what they should be.
    pub(super) inverted: usize,
}

impl Healed {
    /// An edge so long is left out.
    pub(super) fn left_out(&mut self, long: f64, near: f64) {
        if long > POINT * near {
            self.short += 1;
            self.longest = self.longest.max(long);
        }
    }
}

/// A piece of a loop as it is followed: a curve in space and in the parameter plane.
struct Piece {
    curve: Curve,
    parameters: ParameterCurve,
    /// Whether the loop runs from its end to its start.
    reversed: bool,
    /// How far the curve may be from the surface.
    off: f64,
}

impl Piece {
    fn ends(&self) -> Result<[Point; 2]> {
        let (from, to) = self.curve.domain();
        let ends = [self.curve.point(from)?, self.curve.point(to)?];
        Ok(if self.reversed { [ends[1], ends[0]] } else { ends })
    }

    fn turned(mut self) -> Self {
        self.reversed = !self.reversed;
        self
    }
}

/// Adds the faces of a Brep, a surface or a trimmed surface to parts. Edges of surfaces are their isocurves, exactly; those of trimmed surfaces lie within
/// `near` of the images of their loops. What is no longer than `near`, as the side at a pole, is no edge. Shells and solids are left behind.
///
/// # Errors
/// When the geometry is none of these, or an evaluation overflows.
pub(super) fn gather(parts: &mut Parts, geometry: &Geometry, near: f64, healed: &mut Healed) -> Result<()> {
    match geometry {
        Geometry::Brep(brep) => {
            let mut own = brep.parts();
            healed.inverted += inward::turn_beyond(brep, &mut own)?;
            append(parts, own);
        }
        Geometry::Surface(surface) => {
            let loops = vec![sides(surface)?];
            face(parts, surface, loops, near, healed)?;
        }
        Geometry::Trimmed(trimmed) => of_trimmed(parts, trimmed, near, healed)?,
        other => {
            let problem = format!("it is {}, which has no faces: name breps and surfaces", a(&other.noun()));
            return Err(Error::Invalid(problem));
        }
    }
    Ok(())
}

fn append(parts: &mut Parts, mut more: Parts) {
    let (vertices, edges) = (parts.vertices.len(), parts.edges.len());
    for edge in &mut more.edges {
        edge.ends = edge.ends.map(|end| end + vertices);
    }
    for face in &mut more.faces {
        face.loops.iter_mut().flatten().for_each(|one| one.edge += edges);
        face.points.iter_mut().for_each(|vertex| *vertex += vertices);
    }
    parts.vertices.extend(more.vertices);
    parts.edges.extend(more.edges);
    parts.faces.extend(more.faces);
}

/// The four sides of a surface, counterclockwise.
fn sides(surface: &Surface) -> Result<Vec<Piece>> {
    let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
    let side = |still: Direction, at: f64, reversed: bool| -> Result<Piece> {
        let curve = surface.isocurve(still, at)?;
        let place = |t: f64| match still {
            Direction::U => Point::new(at, t, 0.0),
            Direction::V => Point::new(t, at, 0.0),
        };
        // At the same speed, so that places on one are those on the other.
        let (from, to) = curve.domain();
        let line = Curve::new(Space::clamped(1, &[from, to])?, vec![place(from), place(to)])?;
        Ok(Piece { curve, parameters: ParameterCurve::whole(line)?, reversed, off: 0.0 })
    };
    Ok(vec![
        side(Direction::V, v0, false)?,
        side(Direction::U, u1, false)?,
        side(Direction::V, v1, true)?,
        side(Direction::U, u0, true)?,
    ])
}

fn of_trimmed(parts: &mut Parts, trimmed: &Trimmed, near: f64, healed: &mut Healed) -> Result<()> {
    let surface = trimmed.surface();
    if trimmed.regions().is_empty() {
        return face(parts, surface, vec![sides(surface)?], near, healed);
    }
    for region in trimmed.regions() {
        let outer = match &region.outer[..] {
            [] => sides(surface)?,
            curves => chain(surface, curves, true, near)?,
        };
        let mut loops = vec![outer];
        for hole in &region.holes {
            loops.push(chain(surface, hole, false, near)?);
        }
        face(parts, surface, loops, near, healed)?;
    }
    Ok(())
}

/// A loop of curves in the parameter plane, run through so that what it bounds is to its left.
fn chain(surface: &Surface, curves: &[ParameterCurve], outer: bool, near: f64) -> Result<Vec<Piece>> {
    let mut pieces = Vec::with_capacity(curves.len());
    for one in curves {
        let lifted = one.on(surface, near)?;
        let off = lifted.deviation.unwrap_or(0.0);
        pieces.push(Piece { curve: lifted.curve, parameters: one.clone(), reversed: false, off });
    }
    if (area(curves)? > 0.0) != outer {
        pieces.reverse();
        pieces = pieces.into_iter().map(Piece::turned).collect();
    }
    Ok(pieces)
}

/// Twice the area that a loop in the parameter plane runs around counterclockwise, by chords.
fn area(curves: &[ParameterCurve]) -> Result<f64> {
    let mut points = Vec::new();
    for one in curves {
        let (from, to) = one.range();
        for k in 0..PLACES {
            points.push(one.curve().point(from + (to - from) * (k as f64 / PLACES as f64))?);
        }
    }
    let first = points.first().copied().unwrap_or_default();
    let next = points.iter().cycle().skip(1);
    Ok(points.iter().zip(next).map(|(p, q)| (p - first).cross(&(q - first)).z).sum())
}

/// Adds a face with edges and vertices of its own.
fn face(
    parts: &mut Parts,
    surface: &Surface,
    loops: Vec<Vec<Piece>>,
    near: f64,
    healed: &mut Healed,
) -> Result<()> {
    let mut all = Vec::with_capacity(loops.len());
    for pieces in loops {
        let uses = uses(parts, pieces, near, healed)?;
        if !uses.is_empty() {
            all.push(uses);
        }
    }
    if all.is_empty() {
        return Err(Error::Invalid("its border is no longer than the tolerance: give a smaller one".into()));
    }
    parts.faces.push(Face {
        name: None,
        color: None,
        surface: surface.clone(),
        form: SurfaceForm::Spline,
        reversed: false,
        loops: all,
        points: Vec::new(),
    });
    Ok(())
}

fn uses(parts: &mut Parts, pieces: Vec<Piece>, near: f64, healed: &mut Healed) -> Result<Vec<Use>> {
    let mut kept = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let long = extent(&piece.curve);
        if long > near {
            kept.push(piece);
        } else {
            healed.left_out(long, near);
        }
    }
    let ends = kept.iter().map(Piece::ends).collect::<Result<Vec<_>>>()?;
    let (count, base) = (kept.len(), parts.vertices.len());
    for (k, [start, _]) in ends.iter().enumerate() {
        // What was left out or does not quite meet is within the vertex.
        let before = ends[(k + count - 1) % count][1];
        parts.vertices.push(Vertex { point: *start, tolerance: (before - start).norm() });
    }
    let mut uses = Vec::with_capacity(count);
    for (k, piece) in kept.into_iter().enumerate() {
        let (start, end) = (base + k, base + (k + 1) % count);
        let ends = if piece.reversed { [end, start] } else { [start, end] };
        let edge = parts.edges.len();
        let range = piece.curve.domain();
        parts.edges.push(Edge {
            curve: piece.curve,
            range,
            ends,
            tolerance: piece.off,
            form: CurveForm::Spline,
        });
        uses.push(Use { edge, reversed: piece.reversed, parameters: Some(piece.parameters) });
    }
    Ok(uses)
}

/// The largest side of the box around a curve's control vertices.
pub(super) fn extent(curve: &Curve) -> f64 {
    let (low, high) = curve.hull_bounds();
    (high - low).amax()
}
