//! Sections of surfaces by planes.
//!
//! On a patch the signed distance times the weight is a polynomial whose coefficients are the distances of the control vertices.
//! Cells of the parameters are halved until the coefficients are on one side of 0 (no section there), or those of a
//! derivative are (the section is a graph there), and the cell's edges are met once at most: which edges are then
//! follows from the signs at the corners. So the section's branches and loops are known before one of them is drawn.
//!
//! The plane is moved by an eighth of the tolerance first, so that none of this happens at 0: an edge in the plane, a
//! peak that touches it, branches that cross. It is moved both ways: what only one of the two meets is an edge in the plane, which belongs to
//! the section on whichever side the rest of the surface lies, or it only touches the plane, in a place (a peak, a pit) or along a line.

mod cell;
mod chain;
mod clip;
mod exact;
mod flat;
mod shell;
mod touch;
mod trace;
mod trimmed;

pub use clip::ShellCurve;
pub(crate) use shell::bounds;
pub use shell::{ShellSection, brep_section};
pub use trimmed::trimmed_section;

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Direction, Surface};

use crate::error::Result;
use crate::intersections::{Options, Plane};
use crate::mesh::nested;
use crate::net::Range;
use crate::pair::setting;
use crate::pieces::Pieces;
use cell::Cells;
use clip::doubled_area;

/// Cells of all patches together before the rest is called undecided.
const CELLS: usize = 400_000;

/// Branches that are no further apart than this many tolerances run along one another.
const ALONG: f64 = 4.0;
/// What only touches the plane is met in a strip no wider than this part of the surface's size.
const STRIP: f64 = 1e-2;
/// A branch no larger than this part of the surface's size may be one that is there only because the plane was moved.
const SMALL: f64 = 1e-2;
/// Places of a branch that are looked at for that.
const PLACES: usize = 16;
/// Sides of a polygon for each span of a loop that was drawn, to tell which loop is inside which.
const SIDES: usize = 4;
/// The same of an isocurve, which has few spans.
const LINE_SIDES: usize = 64;

/// One branch of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionCurve {
    /// The branch: a cubic spline with continuous tangents, but where the surface has none; where it is an
    /// [isocurve](Self::isocurve), that.
    pub curve: Curve,
    /// Whether it is a loop; the curve is periodic then.
    pub closed: bool,
    /// The largest distance from the section that was measured between its points.
    pub distance: f64,
    /// The surface parameters of the ends of its spans, in order.
    pub parameters: Vec<[f64; 2]>,
    /// Of a branch that is exact, because it is an isocurve of the surface: which parameter stands still, and where.
    pub isocurve: Option<(Direction, f64)>,
}

/// The section of a surface by a plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Its branches and loops.
    pub curves: Vec<SectionCurve>,
    /// Points where the surface only touches the plane; of a line along which it does, one.
    pub touching: Vec<Point>,
    /// Parameters `[(u₀, u₁), (v₀, v₁)]` of patches that lie in the plane.
    pub coincident: Vec<[(f64, f64); 2]>,
    /// Parameters, as these, of cells where the search was given up: where this is empty, every branch and loop larger than the tolerance was found.
    pub undecided: Vec<[(f64, f64); 2]>,
    /// The area inside its loops, what an even number of them goes around left out; `None` where a branch does not close, some of the surface lies in the
    /// plane, or is undecided.
    pub area: Option<f64>,
    /// The tolerance that was used.
    pub tolerance: f64,
}

/// The section of a surface by a plane, drawn within a tolerance (`None`: 1e-6 of the surface's size).
///
/// Which branches and loops there are is known to an eighth of the tolerance: branches that pass one another more
/// closely may be joined the other way. Where one is a whole [isocurve](Surface::isocurve) of the surface, to rounding, it is given as that: of a surface of
/// revolution across its axis the rational circles themselves. An edge of the surface that lies in the plane is a branch as others, on whichever side of the plane
/// the surface is; of a line along which it only touches the plane one point is told. `O(n)` for patches that do not meet the plane, then what the section passes.
///
/// ```
/// use loftsman_intersection::{Options, Plane, section};
/// use loftsman_kernel::{Point, Vector, spline::{Curve, Surface}};
/// let ring = Curve::circle(Point::origin(), Vector::z(), 1.0)?;
/// let pipe = Surface::extrusion(&ring, Vector::z() * 5.0)?;
/// let cut = section(&pipe, &Plane::new(Point::new(0.0, 0.0, 2.0), Vector::z())?, &Options::within(1e-7))?;
/// assert!(cut.curves.len() == 1 && cut.curves[0].closed);
/// assert!((cut.curves[0].curve.length(1e-9)?.value - std::f64::consts::TAU).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the tolerance is no length, or the surface is too large for numbers.
pub fn section(surface: &Surface, plane: &Plane, options: &Options) -> Result<Section> {
    let mut found = cut(surface, plane, options, Sides::Both)?;
    for branch in found.curves.iter_mut().filter(|branch| branch.isocurve.is_none()) {
        branch.distance += flat::lay(&mut branch.curve, plane)?;
    }
    Ok(found)
}

/// Which lines along which a surface touches a plane belong to its section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sides {
    /// Those of either side, each once.
    Both,
    /// What the plane meets where it is moved to one side: of faces that share edges this is what closes.
    One,
}

/// The section as it is where the plane is moved to one side, or to both.
fn cut(surface: &Surface, plane: &Plane, options: &Options, sides: Sides) -> Result<Section> {
    let (frame, least) = setting(&[surface.hull_bounds()], &Options::default())?;
    let tolerance = match options.tolerance {
        Some(_) => setting(&[surface.hull_bounds()], options)?.1,
        None => 1e-6 * frame.size,
    };
    let pieces = Pieces::of_surface(surface, &frame)?;
    let distance = plane.distance(&frame.center) / frame.size;
    let inner = tolerance / frame.size;
    let shift = (0.125 * tolerance).min(least) / frame.size;
    let mut result = Section { tolerance, ..Section::default() };
    let height = touch::Height::new(surface, plane, frame.size)?;
    let mut sides_of = Vec::new();
    for (sign, main) in [(1.0, true), (-1.0, false)] {
        let mut cells = Cells::new(&pieces, plane.normal(), distance, sign * shift);
        cells.search(CELLS);
        for chain in chain::chains(&cells, surface) {
            // Of faces the other side is asked for peaks and pits only.
            let small = extent(&cells, &chain) <= SMALL;
            if !(main || small || sides == Sides::Both) {
                continue;
            }
            if small && let Some(point) = touches(&height, &cells, &chain, &frame, shift * frame.size)? {
                if result.touching.iter().all(|q| (q - point).norm() > ALONG * tolerance) {
                    result.touching.push(point);
                }
                continue;
            }
            if !main && sides == Sides::One {
                continue;
            }
            let traced = trace::trace(&cells, &chain, &frame, plane, inner)?;
            if !main && traced.closed {
                // What touches an edge of the surface from within is open on one side only, where the plane was moved past that edge.
                let opened = opened(&result.curves, &traced, tolerance)?;
                if !opened.is_empty() {
                    for k in opened.into_iter().rev() {
                        result.curves.remove(k);
                        sides_of.remove(k);
                    }
                    result.curves.push(traced);
                    sides_of.push(main);
                    continue;
                }
            }
            if main && sides == Sides::One
                || sides == Sides::Both && !is_there(&result.curves, &traced, tolerance)?
            {
                result.curves.push(traced);
                sides_of.push(main);
            }
        }
        if main {
            result.coincident = cells.coincident;
            result.undecided = cells.undecided;
        }
    }
    if sides == Sides::Both {
        let off = 4.0 * shift * frame.size;
        let strip = Strip { surface, plane, height: &height, tolerance, width: STRIP * frame.size, off };
        touched(&mut result, sides_of, &strip)?;
        exact::Lines::new(surface, plane, tolerance).replace(&mut result.curves)?;
        result.area = area(&result, plane)?;
    }
    Ok(result)
}

/// The area inside the loops of a section.
fn area(section: &Section, plane: &Plane) -> Result<Option<f64>> {
    let open = section.curves.iter().any(|curve| !curve.closed);
    if open || section.curves.is_empty() || !section.coincident.is_empty() || !section.undecided.is_empty() {
        return Ok(None);
    }
    let normal = plane.normal();
    let across = normal.iamax();
    let (mut loops, mut own) = (Vec::new(), Vec::new());
    for SectionCurve { curve, isocurve, .. } in &section.curves {
        let sides = if isocurve.is_some() { LINE_SIDES } else { SIDES };
        let mut points = Vec::new();
        for span in curve.space().breakpoints().windows(2) {
            for k in 0..sides {
                let p = curve.point(span[0] + (span[1] - span[0]) * k as f64 / sides as f64)?;
                points.push([p[(across + 1) % 3], p[(across + 2) % 3]]);
            }
        }
        loops.push(points);
        own.push(0.5 * doubled_area(curve, &normal)?);
    }
    Ok(Some(nested(&loops, &own)))
}

/// What tells the two sides of a strip that is there only because the plane was moved.
struct Strip<'a> {
    surface: &'a Surface,
    plane: &'a Plane,
    height: &'a touch::Height<'a>,
    tolerance: f64,
    /// How wide it may be.
    width: f64,
    /// How far from the plane the surface is between them, at most.
    off: f64,
}

/// Takes away pairs of branches between which the surface only touches the plane, and leaves a point of each: both are where the plane was moved to one side.
/// Those where it was moved to either side are one branch, at which the surface leaves the plane at a small angle.
fn touched(section: &mut Section, mut sides: Vec<bool>, strip: &Strip<'_>) -> Result<()> {
    let mut k = 0;
    while k < section.curves.len() {
        let mut found = None;
        for other in k + 1..section.curves.len() {
            if let Some(point) = strip.between(&section.curves[k].curve, &section.curves[other].curve)? {
                found = Some((other, point));
                break;
            }
        }
        match found {
            Some((other, point)) => {
                section.curves.remove(other);
                if sides.remove(other) == sides[k] {
                    section.curves.remove(k);
                    sides.remove(k);
                    section.touching.push(point);
                }
            }
            None => k += 1,
        }
    }
    Ok(())
}

impl Strip<'_> {
    /// A point of the surface between two branches, where all along the first the other is beside it and the surface between them in the plane, but
    /// for how far that was moved.
    fn between(&self, one: &Curve, other: &Curve) -> Result<Option<Point>> {
        let [(low, high), (l, h)] = [one.hull_bounds(), other.hull_bounds()];
        if (0..3).any(|k| l[k] > high[k] + self.width || low[k] > h[k] + self.width) {
            return Ok(None);
        }
        let (a, b) = one.domain();
        let mut middle = None;
        for k in 0..PLACES {
            let point = one.point(a + (b - a) * (k as f64 + 0.5) / PLACES as f64)?;
            let foot = other.closest(point)?;
            let halfway = Point::from(point.coords * 0.5 + foot.point.coords * 0.5);
            if foot.distance <= ALONG * self.tolerance || foot.distance > self.width {
                return Ok(None);
            }
            let found = self.surface.closest(halfway)?;
            let between = found.point;
            if self.plane.distance(&between).abs() > self.off {
                return Ok(None);
            }
            if k == PLACES / 2 {
                // Halfway between two lines that are only near is only near to the place.
                let level = self.height.level(found.at.into(), between, [self.width, self.off])?;
                middle = Some(level.unwrap_or(between));
            }
        }
        Ok(middle)
    }
}

/// Whether most of a branch runs along those that are there already, nearer to them than what the two sides of the plane may be apart.
fn is_there(known: &[SectionCurve], branch: &SectionCurve, tolerance: f64) -> Result<bool> {
    let (low, high) = branch.curve.hull_bounds();
    let near = ALONG * tolerance;
    let beside = known.iter().filter(|one| {
        let (l, h) = one.curve.hull_bounds();
        (0..3).all(|k| l[k] <= high[k] + near && low[k] <= h[k] + near)
    });
    let beside: Vec<&Curve> = beside.map(|one| &one.curve).collect();
    if beside.is_empty() {
        return Ok(false);
    }
    Ok(2 * places_along(&branch.curve, &beside, near)? > PLACES)
}

/// The open branches all of which run along a loop, which are that loop where the plane was moved to the other side.
fn opened(known: &[SectionCurve], ring: &SectionCurve, tolerance: f64) -> Result<Vec<usize>> {
    let near = ALONG * tolerance;
    let (l, h) = ring.curve.hull_bounds();
    let mut found = Vec::new();
    for (k, one) in known.iter().enumerate().filter(|(_, one)| !one.closed) {
        let (low, high) = one.curve.hull_bounds();
        let within = (0..3).all(|k| low[k] >= l[k] - near && high[k] <= h[k] + near);
        if within && places_along(&one.curve, &[&ring.curve], near)? == PLACES {
            found.push(k);
        }
    }
    Ok(found)
}

/// How many of the places on a branch are on others.
fn places_along(branch: &Curve, others: &[&Curve], near: f64) -> Result<usize> {
    let (a, b) = branch.domain();
    let mut along = 0;
    for k in 0..PLACES {
        let point = branch.point(a + (b - a) * (k as f64 + 0.5) / PLACES as f64)?;
        for curve in others {
            if curve.closest(point)?.distance <= near {
                along += 1;
                break;
            }
        }
    }
    Ok(along)
}

/// The extent of a chain, as a part of the surface's size.
fn extent(cells: &Cells<'_>, chain: &chain::Chain) -> f64 {
    let mut ranges = [Range::EMPTY; 3];
    for &(index, _) in &chain.parts {
        let part = &cells.parts[index];
        for end in &part.ends {
            let point = cells.jet(&part.cell, end.at).0.point;
            (0..3).for_each(|k| ranges[k].add(point[k]));
        }
    }
    ranges.iter().map(|r| r.high - r.low).fold(0.0, f64::max)
}

/// Where the surface touches the plane, if a small chain is there only because the plane was moved: an extreme of the distance near to it that is no larger
/// than twice that shift.
fn touches(
    height: &touch::Height<'_>,
    cells: &Cells<'_>,
    chain: &chain::Chain,
    frame: &crate::net::Frame,
    shift: f64,
) -> Result<Option<Point>> {
    let Some(part) = chain.parts.first().map(|&(index, _)| &cells.parts[index]) else { return Ok(None) };
    let start = part.ends[0].at;
    let Some(from) = cells.point(start) else { return Ok(None) };
    height.level(start, frame.center + from * frame.size, [2.0 * SMALL * frame.size, 2.0 * shift])
}
