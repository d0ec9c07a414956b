//! Whether a face of a brep moved much further than what was asked of it.

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::edit::Constraint;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::text::figure;

/// Something moved much further than what was asked where it did so by more than this.
const MUCH: f64 = 3.0;
/// A place that moved by less than this part of the size was kept.
const KEPT: f64 = 1e-9;
/// Steps of a grid over each face's domain.
const STEPS: usize = 24;

/// The warning that a place of a face moved more than three times as far as any place that was asked about: how far, where, and what to do. Displacements are
/// those of equal parameters, at the places of a grid of 25 × 25 on each face that moved which its loops leave. `None` where nothing did, or no place was asked to move.
pub(crate) fn far_beyond(
    before: &Brep,
    after: &Brep,
    (index, asked): (usize, &[Constraint]),
    scale: f64,
    unit: Unit,
) -> Option<String> {
    let way = |constraint: &Constraint| -> Option<f64> {
        let (_, at) = constraint.functional().location().filter(|(shape, _)| *shape == index)?;
        let place = |brep: &Brep| {
            let row = brep.stencil(at, Derivative::default()).ok()?;
            Some(row.apply(brep.control_vertices()))
        };
        Some((place(after)? - place(before)?).norm())
    };
    let asked = asked.iter().filter_map(way).fold(0.0, f64::max);
    // Places that are kept are moved by rounding, where it is a volume that is asked for.
    let vertices = before.control_vertices();
    let size = vertices.iter().map(|p| (p - vertices[0]).amax()).fold(0.0, f64::max);
    if asked <= KEPT * size {
        return None;
    }
    let mut most: (f64, usize, Point) = (MUCH * asked, 0, Point::origin());
    let mut found = false;
    for face in 0..after.face_count() {
        let (Some(old), Some(new)) = (before.surface(face), after.surface(face)) else { continue };
        if old == new {
            continue;
        }
        let Ok(part) = before.part(face) else { continue };
        let ((a, b), (c, d)) = (new.u().domain(), new.v().domain());
        for k in 0..(STEPS + 1) * (STEPS + 1) {
            let share = [k / (STEPS + 1), k % (STEPS + 1)].map(|k| k as f64 / STEPS as f64);
            let at = [a + (b - a) * share[0], c + (d - c) * share[1]];
            let there = part.wrapped(at);
            if !part.has(there) {
                continue;
            }
            if let (Ok(from), Ok(to)) = (old.point(there[0], there[1]), new.point(at[0], at[1]))
                && (to - from).norm() > most.0
            {
                (most, found) = (((to - from).norm(), face, from), true);
            }
        }
    }
    let (far, face, Point { coords: at }) = most;
    found.then(|| {
        format!(
            "face {face} moved by {} near [{}, {}, {}], {} times as far as the furthest place that was asked about: ask for a place further from what stands \
             still, let more or fewer faces move, or keep places where they are",
            unit.quantity(scale * far, 1),
            figure(at.x),
            figure(at.y),
            figure(at.z),
            figure(far / asked),
        )
    })
}
