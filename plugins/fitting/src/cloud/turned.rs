//! Where a surface looks the other way than it did.

use loftsman_kernel::error::Result;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::{Point, Vector};

use super::foot::{Foot, feet};
use super::patches::Patches;

/// Places that are looked at, at most but for one a face.
const PLACES: usize = 4000;

/// Where a fitted surface looks the other way than the one that it was: folded, or turned inside out.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Turned {
    /// The part of its places.
    pub share: f64,
    /// Faces (boxes of the parameters, of a surface that is one patch) with such places.
    pub faces: usize,
    /// All faces.
    pub of: usize,
    /// A place that does, in the middle of the first.
    pub at: Option<[f64; 3]>,
}

/// Looks at places of the fitted surface for those whose normal is against that of the given one both where this is nearest and at the same parameters: a shape
/// that slides along itself, and a thin one that moves by more than it is thick, differ in one of them alone. What the given one looks like is, at the same parameters, the
/// mean of a patch, and where it is nearest that within the distance of its control vertices: its own wrinkles are none of the fit's.
///
/// Cost: a foot for each of some thousand places, and for each that is against the patch a look at as many. Nothing where the search is cancelled.
pub(super) fn turned(
    patches: &Patches,
    given: &dyn Shape,
    fitted: &[Point],
    cancelled: &dyn Fn() -> bool,
) -> Result<Option<Turned>> {
    if patches.is_curve() {
        return Ok(Some(Turned::default()));
    }
    let vertices = given.control_vertices();
    let [was, is] = [vertices, fitted].map(|vertices| patches.middles(vertices));
    let mut sides = vec![Vector::zeros(); patches.count()];
    was.iter().enumerate().for_each(|(k, [_, normal])| sides[patches.patch(k) as usize] += normal);
    let looked = || (0..is.len()).step_by(patches.step(PLACES));
    let chosen: Vec<usize> =
        looked().filter(|&k| is[k][1].dot(&sides[patches.patch(k) as usize]) < 0.0).collect();
    let places: Vec<Point> = chosen.iter().map(|&k| Point::from(is[k][0])).collect();
    let Some((feet, _)) = feet(given, patches, &places, None, cancelled)? else { return Ok(None) };
    let near = patches.measure(vertices) / vertices.len() as f64;
    let against = |k: usize, foot: &Foot| {
        let (at, [u, v]) = (is[k][0] + foot.away, foot.jet.first);
        let about = was.iter().filter(|[place, _]| (place - at).norm_squared() < near);
        let side = about.fold(Vector::zeros(), |sum, [_, normal]| sum + normal);
        let side = if side == Vector::zeros() { u.cross(&v) } else { side };
        is[k][1].dot(&side) < 0.0
    };
    let found: Vec<usize> =
        chosen.iter().zip(&feet).filter(|(k, foot)| against(**k, foot)).map(|(k, _)| *k).collect();
    let mut faces: Vec<u32> = found.iter().map(|&k| patches.patch(k)).collect();
    faces.dedup();
    Ok(Some(Turned {
        share: found.len() as f64 / looked().count().max(1) as f64,
        faces: faces.len(),
        of: patches.count(),
        at: found.get(found.len() / 2).map(|&k| is[k][0].into()),
    }))
}
