//! Sections of Breps: branches of the faces' surfaces, clipped by the faces' edges and joined across them.
//!
//! Where the plane meets an edge is found once, on the edge itself, and is the end of the parts on both of its faces. On a branch that passes
//! there, what is inside follows from the side on which the face lies of its edge. The plane is moved by less than a quarter of the
//! tolerance first, so that it passes no vertex; where a closed Brep's branches do not close then, as the plane runs along an edge or
//! touches a face, by up to 0.85 of the tolerance to either side.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::brep::Brep;
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector, parallel};

use super::clip::{Gate, Part, ShellCurve, clipped, doubled_area, joined};
use super::{Section, Sides, cut, flat};
use crate::error::Result;
use crate::intersections::{Contact, Options, Plane};
use crate::pair::setting;
use crate::plane::curve_plane;

/// Shifts of the plane that are tried, so that it is far from all vertices.
const SHIFTS: usize = 8;
/// Shifts in tolerances that are tried where the branches of a closed Brep do not close.
const FURTHER: [f64; 6] = [0.35, -0.35, 0.65, -0.65, 0.85, -0.85];
/// The same where the plane runs along edges, in sums of theirs and that of the section.
const BEYOND: [f64; 4] = [1.5, -1.5, 4.0, -4.0];
/// How far from a branch, in tolerances, a place of an edge may be that is on it: edges lie on surfaces within a tolerance of their own, and a plane
/// that meets the surface at a small angle makes more of that.
const REACH: f64 = 1e3;
/// Places of edges towards which it is looked whether something is inside.
const PROBES: usize = 8;

/// By how much the planes are askew in which that is looked for.
const SKEW: [f64; 2] = [0.0317, 0.0193];

/// The section of a Brep by a plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShellSection {
    /// Its branches and loops. On a face they run so that, as seen from the tip of the plane's normal, what the face's normal points away from is to
    /// their left: around solids counterclockwise, around holes clockwise.
    pub curves: Vec<ShellCurve>,
    /// The area inside its loops, those of holes taken away; `None` where a branch does not close or a face is undecided.
    pub area: Option<f64>,
    /// Points where a surface only touches the plane.
    pub touching: Vec<Point>,
    /// Faces that lie in the plane: they are not cut.
    pub coincident: Vec<usize>,
    /// Faces of which it could not be said what is cut.
    pub undecided: Vec<usize>,
    /// The tolerance that was used; it is larger than what was asked for where the plane runs along edges that are known to less only.
    pub tolerance: f64,
    /// How far along its normal the plane was moved, so that it passes no vertex: where faces lie in it, the section is what is cut there, on that side of them.
    pub shift: f64,
}

/// Where the plane meets an edge.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    point: Point,
    /// The edge's direction.
    along: Vector,
}

/// The section of a Brep by a plane, drawn within a tolerance (`None`: 1e-6 of its size). Branches join exactly where faces share edges; a solid's close.
///
/// ```
/// use loftsman_intersection::{Options, Plane, brep_section};
/// use loftsman_kernel::{Point, Vector, brep::Brep};
/// let block = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0))?;
/// let plane = Plane::new(Point::new(0.0, 0.0, 0.5), Vector::z())?;
/// let cut = brep_section(&block, &plane, &Options::default())?;
/// assert!(cut.curves.len() == 1 && cut.curves[0].closed);
/// assert!((cut.area.unwrap() - 6.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the tolerance is no length, or the Brep is too large for numbers.
pub fn brep_section(brep: &Brep, plane: &Plane, options: &Options) -> Result<ShellSection> {
    let edges = edges(brep);
    let Some((low, high)) = around(brep, &edges) else { return Ok(ShellSection::default()) };
    let tolerance = match options.tolerance {
        Some(_) => setting(&[(low, high)], options)?.1,
        None => 1e-6 * setting(&[(low, high)], options)?.0.size,
    };
    let closed = brep.is_closed(&(0..brep.face_count()).collect::<Vec<_>>());
    let mut best: Option<ShellSection> = None;
    for moved in planes(brep, &edges, plane, tolerance)? {
        let mut found = at_plane(brep, &edges, [plane, &moved], tolerance)?;
        found.shift = plane.distance(&moved.point());
        let off = (moved.point() - plane.point()).norm();
        if off > tolerance {
            found.tolerance = off + tolerance;
        }
        for branch in &mut found.curves {
            branch.distance += flat::lay(&mut branch.curve, plane)?;
        }
        if best.as_ref().is_none_or(|known| lacks(&found) < lacks(known)) {
            best = Some(found);
        }
        if best.as_ref().is_some_and(|known| lacks(known) == (0, 0)) || !closed {
            break;
        }
    }
    Ok(best.unwrap_or_default())
}

/// How many faces are undecided, and how many branches do not close.
fn lacks(section: &ShellSection) -> (usize, usize) {
    (section.undecided.len(), section.curves.iter().filter(|curve| !curve.closed).count())
}

/// The section by a plane that was moved, `[as given, moved]`.
fn at_plane(
    brep: &Brep,
    edges: &[Option<Curve>],
    [original, plane]: [&Plane; 2],
    tolerance: f64,
) -> Result<ShellSection> {
    let crossings =
        parallel::map(edges.len(), |k| edges[k].as_ref().map_or(Ok(Vec::new()), |c| crossings(c, plane)));
    let crossings: Vec<Vec<Crossing>> = crossings.into_iter().collect::<Result<_>>()?;
    // Branches are drawn the nearer, the further the plane was moved: then they are laid into that given.
    let off = (plane.point() - original.point()).norm();
    let drawn = if off < tolerance { tolerance - off } else { tolerance };
    let cut = Cut { brep, edges, plane: *plane, tolerance, drawn, crossings };
    let mut all = ShellSection { tolerance, ..ShellSection::default() };
    let mut parts = Vec::new();
    for (face, found) in
        parallel::map(brep.face_count(), |face| cut.face(face, original)).into_iter().enumerate()
    {
        match found? {
            Face::Coincident => all.coincident.push(face),
            Face::Undecided => all.undecided.push(face),
            Face::Cut(own, touching) => {
                parts.extend(own);
                all.touching.extend(touching);
            }
        }
    }
    all.curves = joined(parts)?;
    if all.undecided.is_empty() && all.curves.iter().all(|curve| curve.closed) && !all.curves.is_empty() {
        let mut sum = 0.0;
        for curve in &all.curves {
            sum += 0.5 * doubled_area(&curve.curve, &plane.normal())?;
        }
        all.area = Some(sum);
    }
    Ok(all)
}

/// The edges' curves, each over its own range.
fn edges(brep: &Brep) -> Vec<Option<Curve>> {
    let curve = |number: usize| {
        let edge = brep.edge(number)?;
        edge.curve.between(edge.range.0, edge.range.1).ok()
    };
    (0..brep.edge_count()).map(curve).collect()
}

/// A box around a Brep, as far as its edges say; `None` where it has no faces.
pub(crate) fn bounds(brep: &Brep) -> Option<(Point, Point)> {
    around(brep, &edges(brep))
}

/// The box around the edges, and around the surfaces of faces that have none.
fn around(brep: &Brep, edges: &[Option<Curve>]) -> Option<(Point, Point)> {
    let whole = (0..brep.face_count()).filter(|&face| brep.loops(face).is_empty());
    let surfaces = whole.filter_map(|face| brep.surface(face)).map(|surface| surface.hull_bounds());
    let boxes = edges.iter().flatten().map(Curve::hull_bounds).chain(surfaces);
    boxes.reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))
}

/// The planes that are tried, one after another until all branches close: moved along the normal by less than a quarter of the tolerance to
/// where it is furthest from all vertices; then, as it may still run along an edge or touch a face there, by more to either side.
/// Where it runs along edges, at last by more than their tolerance.
fn planes(brep: &Brep, edges: &[Option<Curve>], plane: &Plane, tolerance: f64) -> Result<Vec<Plane>> {
    let moved = |shift: f64| Plane::new(plane.point() + plane.normal() * shift, plane.normal());
    let mut planes = vec![off_vertices(brep, plane, tolerance)?];
    for share in FURTHER {
        planes.push(moved(share * tolerance)?);
    }
    // Along edges no plane is nearer than these are known.
    let mut known = 0.0_f64;
    for (number, edge) in edges.iter().enumerate() {
        let (Some(edge), Some(own)) = (edge, brep.edge(number)) else { continue };
        let near = tolerance + own.tolerance;
        if own.tolerance > known && edge.points().iter().all(|p| plane.distance(p).abs() <= near) {
            known = own.tolerance;
        }
    }
    if known > 0.0 {
        for share in BEYOND {
            planes.push(moved(share * (known + tolerance))?);
        }
    }
    Ok(planes)
}

/// The plane, moved along its normal by less than a quarter of the tolerance to where it is furthest from all vertices.
fn off_vertices(brep: &Brep, plane: &Plane, tolerance: f64) -> Result<Plane> {
    let heights: Vec<f64> =
        brep.vertices().iter().map(|p| plane.distance(p)).filter(|h| h.abs() <= tolerance).collect();
    if heights.is_empty() {
        return Ok(*plane);
    }
    let step = 0.25 * tolerance / SHIFTS as f64;
    let far = |k: &usize| {
        let shift = step * *k as f64;
        heights.iter().map(|h| (h - shift).abs()).fold(f64::INFINITY, f64::min)
    };
    let best = (1..SHIFTS).max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a))).unwrap_or(1);
    Plane::new(plane.point() + plane.normal() * (step * best as f64), plane.normal())
}

fn crossings(edge: &Curve, plane: &Plane) -> Result<Vec<Crossing>> {
    let (low, high) = edge.hull_bounds();
    let size = low.coords.amax().max(high.coords.amax());
    if (high - low).amax() <= 1e-14 * size {
        // An edge that is a point, as at a pole.
        return Ok(Vec::new());
    }
    let meetings = curve_plane(edge, plane, &Options::default())?.meetings;
    let crossing = |m: &crate::Meeting| Ok(Crossing { point: m.point, along: edge.derivative(m.at, 1)? });
    meetings.iter().filter(|m| m.contact == Contact::Crossing).map(crossing).collect()
}

enum Face {
    /// It lies in the plane.
    Coincident,
    Undecided,
    Cut(Vec<Part>, Vec<Point>),
}

struct Cut<'b> {
    brep: &'b Brep,
    edges: &'b [Option<Curve>],
    plane: Plane,
    tolerance: f64,
    /// How near to the section by that plane branches are drawn.
    drawn: f64,
    crossings: Vec<Vec<Crossing>>,
}

impl Cut<'_> {
    fn face(&self, face: usize, original: &Plane) -> Result<Face> {
        let Some(surface) = self.brep.surface(face) else { return Ok(Face::Cut(Vec::new(), Vec::new())) };
        let heights = || surface.points().iter().map(|p| self.plane.distance(p));
        if heights().all(|h| h > 0.0) || heights().all(|h| h < 0.0) {
            let flat = surface.points().iter().all(|p| original.distance(p).abs() <= self.tolerance);
            return Ok(if flat { Face::Coincident } else { Face::Cut(Vec::new(), Vec::new()) });
        }
        if surface.points().iter().all(|p| original.distance(p).abs() <= self.tolerance) {
            return Ok(Face::Coincident);
        }
        let Section { curves, touching, undecided, .. } =
            cut(&surface, &self.plane, &Options::within(self.drawn), Sides::One)?;
        if !undecided.is_empty() {
            return Ok(Face::Undecided);
        }
        let touching = if self.brep.loops(face).is_empty() { touching } else { Vec::new() };
        let branches: Vec<&Curve> = curves.iter().map(|branch| &branch.curve).collect();
        let Some(gates) = self.gates(face, &surface, &branches, &self.crossings)? else {
            return Ok(Face::Undecided);
        };
        let mut parts = Vec::new();
        for (branch, gates) in curves.iter().zip(gates) {
            let inside = |point: Point| self.inside(face, &surface, point);
            match clipped(branch, gates, face, inside)? {
                Some(own) => parts.extend(own),
                None => return Ok(Face::Undecided),
            }
        }
        let parts = parts.into_iter().map(|part| self.oriented(part, face, &surface));
        Ok(Face::Cut(parts.collect::<Result<_>>()?, touching))
    }

    /// The unit normal of a face at a point of it.
    fn normal(&self, face: usize, surface: &Surface, point: Point) -> Result<Option<Vector>> {
        let (u, v) = surface.closest(point)?.at;
        let way = if self.brep.is_reversed(face) { -1.0 } else { 1.0 };
        Ok(surface.normal(u, v)?.vector().map(|n| n * way))
    }

    /// For each branch where it meets the edges of the face. `None` where a crossing is on none of them.
    fn gates(
        &self,
        face: usize,
        surface: &Surface,
        branches: &[&Curve],
        crossings: &[Vec<Crossing>],
    ) -> Result<Option<Vec<Vec<Gate>>>> {
        let mut gates: Vec<Vec<Gate>> = vec![Vec::new(); branches.len()];
        for one in self.brep.loops(face).iter().flatten() {
            let Some(list) = crossings.get(one.edge) else { continue };
            let own = self.brep.edge(one.edge).map_or(0.0, |edge| edge.tolerance);
            for (number, crossing) in list.iter().enumerate() {
                let mut best: Option<(usize, f64, f64)> = None;
                for (k, branch) in branches.iter().enumerate() {
                    let found = branch.closest(crossing.point)?;
                    if best.is_none_or(|(_, _, distance)| found.distance < distance) {
                        best = Some((k, found.at, found.distance));
                    }
                }
                let Some((branch, at, distance)) = best else { return Ok(None) };
                if distance > REACH * (self.tolerance + own) {
                    return Ok(None);
                }
                let Some(normal) = self.normal(face, surface, crossing.point)? else { return Ok(None) };
                let along = if one.reversed { -crossing.along } else { crossing.along };
                // The face is to the left of its edges.
                let way = branches[branch].derivative(at, 1)?.dot(&normal.cross(&along));
                let turn = if way > 0.0 { 1 } else { -1 };
                gates[branch].push(Gate { at, turn, point: crossing.point, event: (one.edge, number) });
            }
        }
        Ok(Some(gates))
    }

    /// Whether a face is all of its surface: it has no edges but seams, which it runs along both ways, and those that are points, as at poles.
    fn is_whole(&self, face: usize) -> bool {
        let mut ways: BTreeMap<usize, i32> = BTreeMap::new();
        for one in self.brep.loops(face).iter().flatten() {
            *ways.entry(one.edge).or_default() += if one.reversed { -1 } else { 1 };
        }
        let is_point = |edge: usize| {
            let Some(Some(curve)) = self.edges.get(edge) else { return false };
            let first = curve.points()[0];
            let size = first.coords.amax();
            curve.points().iter().all(|p| (p - first).amax() <= 1e-14 * size)
        };
        ways.into_iter().all(|(edge, way)| way == 0 || is_point(edge))
    }

    /// Whether a point of the surface is in the face: on the way from it to an edge, the first edge that is met says it. `None` where
    /// no way meets one.
    fn inside(&self, face: usize, surface: &Surface, point: Point) -> Result<Option<bool>> {
        let loops = self.brep.loops(face);
        if self.is_whole(face) {
            return Ok(Some(true));
        }
        let own: BTreeSet<usize> = loops.iter().flatten().map(|one| one.edge).collect();
        let mut places: Vec<Point> = Vec::new();
        for edge in own.iter().filter_map(|&edge| self.edges.get(edge)?.as_ref()) {
            let (start, end) = edge.domain();
            for x in [0.137, 0.389, 0.618, 0.871] {
                places.push(edge.point(start + (end - start) * x)?);
            }
        }
        places.sort_by(|p, q| (p - point).norm().total_cmp(&(q - point).norm()));
        let (u, v) = surface.closest(point)?.at;
        let Some(normal) = surface.normal(u, v)?.vector() else { return Ok(None) };
        let step = (places.len() / PROBES).max(1);
        for target in places.iter().step_by(step).take(PROBES) {
            // Straight ahead in space, or halfway in the parameters: around a torus the first may come back before it is there.
            let at = surface.closest(*target)?.at;
            let between = surface.point(0.5 * (u + at.0), 0.5 * (v + at.1))?;
            let ahead = target - point;
            for across in [normal.cross(&ahead), (between - point).cross(&ahead)] {
                // A little askew, so that it does not run along edges of symmetric faces.
                let across = across / across.norm() + normal * SKEW[0] + ahead * (SKEW[1] / ahead.norm());
                let Ok(way) = Plane::new(point, across) else { continue };
                let found = self.beyond(face, surface, point, &way)?;
                if found.is_some() {
                    return Ok(found);
                }
            }
        }
        Ok(None)
    }

    /// Whether a point is in the face, as the section by a plane through it says.
    fn beyond(&self, face: usize, surface: &Surface, point: Point, way: &Plane) -> Result<Option<bool>> {
        let cut = cut(surface, way, &Options::within(self.tolerance), Sides::One)?;
        let mut nearest: Option<(usize, f64, f64)> = None;
        for (k, branch) in cut.curves.iter().enumerate() {
            let found = branch.curve.closest(point)?;
            if nearest.is_none_or(|(_, _, distance)| found.distance < distance) {
                nearest = Some((k, found.at, found.distance));
            }
        }
        let Some((branch, at, _)) = nearest.filter(|(.., distance)| *distance <= REACH * self.tolerance)
        else {
            return Ok(None);
        };
        let mut crossings = vec![Vec::new(); self.edges.len()];
        for one in self.brep.loops(face).iter().flatten() {
            if let Some(Some(edge)) = self.edges.get(one.edge) {
                crossings[one.edge] = self::crossings(edge, way)?;
            }
        }
        let branches: Vec<&Curve> = cut.curves.iter().map(|branch| &branch.curve).collect();
        let Some(mut gates) = self.gates(face, surface, &branches, &crossings)? else { return Ok(None) };
        let mut gates = std::mem::take(&mut gates[branch]);
        gates.sort_by(|a, b| a.at.total_cmp(&b.at));
        // At seams and corners it comes in and goes out at once.
        let (start, end) = branches[branch].domain();
        let mut places: Vec<(f64, i32)> = Vec::new();
        for gate in &gates {
            match places.last_mut() {
                Some(last) if gate.at - last.0 <= 1e-7 * (end - start) => last.1 += gate.turn,
                _ => places.push((gate.at, gate.turn)),
            }
        }
        places.retain(|(_, turn)| *turn != 0);
        // It comes in and goes out in turn, and round a loop as often the one as the other; else it ran along an edge.
        let in_turn = places.windows(2).all(|pair| pair[0].1.signum() != pair[1].1.signum());
        if !in_turn || cut.curves[branch].closed && places.len() % 2 == 1 {
            return Ok(None);
        }
        let ahead = places.iter().find(|(place, _)| *place > at).map(|(_, turn)| *turn < 0);
        let behind = places.iter().rev().find(|(place, _)| *place < at).map(|(_, turn)| *turn > 0);
        Ok(ahead.or(behind))
    }

    /// The part running so that what the face's normal points away from is to its left, as seen from the tip of the plane's normal.
    fn oriented(&self, part: Part, face: usize, surface: &Surface) -> Result<Part> {
        let (start, end) = part.curve.domain();
        let middle = start + 0.5 * (end - start);
        let (point, along) = (part.curve.point(middle)?, part.curve.derivative(middle, 1)?);
        let Some(normal) = self.normal(face, surface, point)? else { return Ok(part) };
        if self.plane.normal().cross(&along).dot(&normal) <= 0.0 {
            return Ok(part);
        }
        let [from, to] = part.ends;
        Ok(Part { curve: part.curve.reverse()?, ends: [to, from], ..part })
    }
}
