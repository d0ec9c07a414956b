//! Faces of solids moved: what meets goes on meeting.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod edits;
mod family;
mod smooth;
mod told;

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::shape::Shape;

/// The size of the box around a Brep.
fn size(brep: &Brep) -> f64 {
    let points = brep.control_vertices();
    points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max)
}

/// How far the faces of each edge are apart, measured by nothing that edits know: points of a face along its parameter curve from the other
/// face's surface, at a thousand places.
fn gaps(brep: &Brep) -> Vec<f64> {
    let curves: Vec<_> = (0..brep.face_count()).map(|face| brep.parameter_curves(face).unwrap()).collect();
    let surfaces: Vec<_> = (0..brep.face_count()).map(|face| brep.surface(face).unwrap()).collect();
    (0..brep.edge_count())
        .map(|edge| {
            let uses = brep.uses(edge);
            let mut worst = 0.0_f64;
            for (one, other) in uses.iter().flat_map(|a| uses.iter().map(move |b| (a, b))) {
                if one == other {
                    continue;
                }
                let curve = &curves[one.face][one.chain][one.number].curve;
                let (from, to) = curve.range();
                let mut start: Option<(f64, f64)> = None;
                for k in 0..=1000 {
                    let t = if k == 1000 { to } else { from + (to - from) * f64::from(k) / 1000.0 };
                    let at = curve.curve().point(t).unwrap();
                    let point = on(&surfaces[one.face], at);
                    let beside = &surfaces[other.face];
                    let mut foot = match start {
                        Some(start) => beside.foot(point, start).map(|f| (f.at, f.distance)).unwrap(),
                        None => ((0.0, 0.0), f64::INFINITY),
                    };
                    if foot.1 > 1e-13 {
                        let closest = beside.closest(point).unwrap();
                        if closest.distance < foot.1 {
                            foot = (closest.at, closest.distance);
                        }
                    }
                    start = Some(foot.0);
                    worst = worst.max(foot.1);
                }
            }
            worst
        })
        .collect()
}

/// The point of a surface at parameters that rounding may have left beside its domain.
fn on(surface: &loftsman_kernel::spline::Surface, at: Point) -> Point {
    let into = |space: &loftsman_kernel::spline::Space, t: f64| {
        let (a, b) = space.domain();
        if space.is_periodic() { t } else { t.clamp(a, b) }
    };
    surface.point(into(surface.u(), at.x), into(surface.v(), at.y)).unwrap()
}
