//! Sections of surfaces by planes.
//!
//! On a patch the signed distance times the weight is a polynomial whose coefficients are the distances of the control vertices.
//! Cells of the parameters are halved until the coefficients are on one side of 0 (no section there), or those of a
//! derivative are (the section is a graph there), and the cell's edges are met once at most: which edges are then
//! follows from the signs at the corners. So the section's branches and loops are known before one of them is drawn.
//!
//! The plane is moved by an eighth of the tolerance first, so that none of this happens at 0: an edge in the plane, a
//! peak that touches it, branches that cross. Its two sides tell peaks and pits that only touch.

mod cell;
mod chain;
mod clip;
mod shell;
mod trace;
mod trimmed;

pub use clip::ShellCurve;
pub(crate) use shell::bounds;
pub use shell::{ShellSection, brep_section};
pub use trimmed::trimmed_section;

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Surface};

use crate::error::Result;
use crate::intersections::{Options, Plane};
use crate::net::Range;
use crate::pair::setting;
use crate::pieces::Pieces;
use cell::Cells;

/// Cells of all patches together before the rest is called undecided.
const CELLS: usize = 400_000;

/// One branch of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionCurve {
    /// The branch: a cubic spline with continuous tangents, but where the surface has none.
    pub curve: Curve,
    /// Whether it is a loop; the curve is periodic then.
    pub closed: bool,
    /// The largest distance from the section that was measured between its points.
    pub distance: f64,
    /// The surface parameters of the ends of its spans, in order.
    pub parameters: Vec<[f64; 2]>,
}

/// The section of a surface by a plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Its branches and loops.
    pub curves: Vec<SectionCurve>,
    /// Points where the surface only touches the plane.
    pub touching: Vec<Point>,
    /// Parameters `[(u₀, u₁), (v₀, v₁)]` of patches that lie in the plane.
    pub coincident: Vec<[(f64, f64); 2]>,
    /// Parameters, as these, of cells where the search was given up: where this is empty, every branch and loop larger than the tolerance was found.
    pub undecided: Vec<[(f64, f64); 2]>,
    /// The tolerance that was used.
    pub tolerance: f64,
}

/// The section of a surface by a plane, drawn within a tolerance (`None`: 1e-6 of the surface's size).
///
/// Which branches and loops there are is known to an eighth of the tolerance: branches that pass one another more
/// closely may be joined the other way. `O(n)` for patches that do not meet the plane, then what the section passes.
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
    for (sign, main) in [(1.0, true), (-1.0, false)] {
        let mut cells = Cells::new(&pieces, plane.normal(), distance, sign * shift);
        cells.search(CELLS);
        for chain in chain::chains(&cells, surface) {
            // The other side is asked for peaks and pits only.
            let small = chain.closed && is_small(&cells, &chain);
            if !(main || small) {
                continue;
            }
            let traced = trace::trace(&cells, &chain, &frame, plane, inner)?;
            if traced.closed && is_touching(&traced, &cells, plane, &frame, shift) {
                result.touching.push(middle(&traced.curve));
            } else if main {
                result.curves.push(traced);
            }
        }
        if main {
            result.coincident = cells.coincident;
            result.undecided = cells.undecided;
        }
    }
    Ok(result)
}

/// Whether all of a chain is within a hundredth of the surface's size.
fn is_small(cells: &Cells<'_>, chain: &chain::Chain) -> bool {
    let mut ranges = [Range::EMPTY; 3];
    for &(index, _) in &chain.parts {
        let part = &cells.parts[index];
        for end in &part.ends {
            let point = cells.jet(&part.cell, end.at).0.point;
            (0..3).for_each(|k| ranges[k].add(point[k]));
        }
    }
    ranges.iter().all(|r| r.high - r.low <= 1e-2)
}

fn middle(curve: &Curve) -> Point {
    let (low, high) = curve.hull_bounds();
    Point::from(low.coords * 0.5 + high.coords * 0.5)
}

/// Whether a loop is there only because the plane was moved.
fn is_touching(
    loop_: &SectionCurve,
    cells: &Cells<'_>,
    plane: &Plane,
    frame: &crate::net::Frame,
    shift: f64,
) -> bool {
    let mut range = [Range::EMPTY; 2];
    for p in &loop_.parameters {
        range[0].add(p[0]);
        range[1].add(p[1]);
    }
    let (low, high) = loop_.curve.hull_bounds();
    if (high - low).amax() > 1e-2 * frame.size {
        return false;
    }
    // At the middle the distance is largest, nearly: it is the shift, if nothing else is there.
    let at = range.map(|r| 0.5 * r.low + 0.5 * r.high);
    cells.point(at).is_some_and(|point| {
        plane.distance(&(frame.center + point * frame.size)).abs() <= 2.0 * shift * frame.size
    })
}
