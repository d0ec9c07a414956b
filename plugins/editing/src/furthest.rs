//! Whether a face of a brep moved much further than what was asked of it.

use loftsman_kernel::brep::Brep;
use loftsman_kernel::edit::Constraint;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::text::figure;

use crate::paths::Path;

/// Something moved much further than what was asked where it did so by more than this.
const MUCH: f64 = 3.0;
/// A place that moved by less than this part of the size was kept.
const KEPT: f64 = 1e-9;

/// The warning that one of these places of faces moved more than three times as far as any place that was asked about: how far, where, and what to do. `None` where
/// nothing did, or no place was asked to move.
pub(crate) fn far_beyond(
    before: &Brep,
    after: &Brep,
    paths: &[Path],
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
    let far = |path: &Path| (path.to - path.from).norm();
    let most = paths.iter().filter(|path| far(path) > MUCH * asked);
    let most = most.max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let (Path { face, from: at, .. }, far) = (most, far(most));
    Some(format!(
        "face {face} moved by {} near [{}, {}, {}], {} times as far as the furthest place that was asked about: ask for a place further from what stands \
         still, let more or fewer faces move, or keep places where they are",
        unit.quantity(scale * far, 1),
        figure(at.x),
        figure(at.y),
        figure(at.z),
        figure(far / asked),
    ))
}
