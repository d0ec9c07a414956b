//! Sections of trimmed surfaces: branches of the surface, as far as the loops let them.

use loftsman_kernel::Point;
use loftsman_kernel::brep::is_around;
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Surface, Trimmed};

use super::clip::{Gate, clipped, joined};
use super::shell::ShellSection;
use super::{Section, Sides, cut, exact, flat};
use crate::error::Result;
use crate::intersections::{Options, Plane};

/// Places on each knot span of a loop's curve at which the side of the plane is asked for.
const STEPS: usize = 64;
/// How far from a branch, in tolerances, a place of a loop may be that is on it.
const REACH: f64 = 1e3;

/// The section of a trimmed surface by a plane, drawn within a tolerance (`None`: 1e-6 of the surface's size). What is inside is what an odd number
/// of loops separates from the end of the domain. Loops that cross the plane twice within a 64th of a knot span are taken not to.
///
/// # Errors
/// When the tolerance is no length, or the surface is too large for numbers.
pub fn trimmed_section(trimmed: &Trimmed, plane: &Plane, options: &Options) -> Result<ShellSection> {
    let surface = trimmed.surface();
    let Section { mut curves, touching, coincident, undecided, tolerance, area: _ } =
        cut(surface, plane, options, Sides::One)?;
    exact::Lines::new(surface, plane, tolerance).replace(&mut curves)?;
    let mut all = ShellSection { tolerance, ..ShellSection::default() };
    if !coincident.is_empty() {
        all.coincident.push(0);
    }
    if !undecided.is_empty() {
        all.undecided.push(0);
    }
    let loops: Vec<Vec<[f64; 2]>> = trimmed.loops().map(flattened).collect::<Result<_>>()?;
    let whole = loops.is_empty() || trimmed.regions().iter().any(|region| region.outer.is_empty());
    let has = |at: [f64; 2]| (loops.iter().filter(|points| is_around(points, at)).count() % 2 == 1) != whole;
    let inside = |point: Point| -> Result<Option<bool>> {
        let (u, v) = surface.closest(point)?.at;
        Ok(Some(has([u, v])))
    };
    for point in touching {
        if inside(point)? == Some(true) {
            all.touching.push(point);
        }
    }
    let mut gates: Vec<Vec<Gate>> = vec![Vec::new(); curves.len()];
    for (number, curve) in trimmed.loops().flatten().enumerate() {
        for (k, point) in crossings(curve, surface, plane)?.into_iter().enumerate() {
            let mut best: Option<(usize, f64, f64)> = None;
            for (branch, curve) in curves.iter().enumerate() {
                let found = curve.curve.closest(point)?;
                if best.is_none_or(|(_, _, distance)| found.distance < distance) {
                    best = Some((branch, found.at, found.distance));
                }
            }
            if let Some((branch, at, _)) = best.filter(|(.., distance)| *distance <= REACH * tolerance) {
                gates[branch].push(Gate { at, turn: 0, point, event: (number, k) });
            }
        }
    }
    let mut parts = Vec::new();
    for (branch, gates) in curves.iter().zip(gates) {
        parts.extend(clipped(branch, gates, 0, inside)?.unwrap_or_default());
    }
    all.curves = joined(parts)?;
    for branch in all.curves.iter_mut().filter(|branch| branch.isocurve.is_none()) {
        branch.distance += flat::lay(&mut branch.curve, plane)?;
    }
    Ok(all)
}

/// The parameters of a chain, at a few places of each knot span.
fn flattened(chain: &[ParameterCurve]) -> Result<Vec<[f64; 2]>> {
    let mut points = Vec::new();
    for part in chain {
        for t in places(part) {
            let p = part.curve().point(t)?;
            points.push([p.x, p.y]);
        }
    }
    Ok(points)
}

/// Parameters of a piece of a curve: both ends, and some between its knots.
fn places(part: &ParameterCurve) -> Vec<f64> {
    let (curve, (from, to)) = (part.curve(), part.range());
    let inner = curve.space().breakpoints().into_iter().filter(|u| *u > from && *u < to);
    let breaks: Vec<f64> = [from].into_iter().chain(inner).chain([to]).collect();
    let mut places = vec![from];
    for span in breaks.windows(2) {
        places.extend((1..STEPS).map(|k| span[0] + (span[1] - span[0]) * (k as f64 / STEPS as f64)));
        places.push(span[1]);
    }
    places
}

/// Where a loop's curve, on the surface, crosses the plane: by changes of its side, then halved to rounding.
fn crossings(part: &ParameterCurve, surface: &Surface, plane: &Plane) -> Result<Vec<Point>> {
    let clamp = |t: f64, (a, b): (f64, f64)| t.clamp(a, b);
    let at = |t: f64| -> Result<Point> {
        let p = part.curve().point(t)?;
        Ok(surface.point(clamp(p.x, surface.u().domain()), clamp(p.y, surface.v().domain()))?)
    };
    let mut found = Vec::new();
    let places = places(part);
    let mut sides = Vec::with_capacity(places.len());
    for &t in &places {
        sides.push(plane.distance(&at(t)?) >= 0.0);
    }
    for k in 1..places.len() {
        if sides[k - 1] == sides[k] {
            continue;
        }
        let (mut low, mut high) = (places[k - 1], places[k]);
        loop {
            let middle = 0.5 * (low + high);
            if !(low < middle && middle < high) {
                break;
            }
            if (plane.distance(&at(middle)?) >= 0.0) == sides[k - 1] { low = middle } else { high = middle }
        }
        found.push(at(low)?);
    }
    Ok(found)
}
