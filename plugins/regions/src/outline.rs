//! Closed curves from a scene's objects.

use loftsman_kernel::placement::transform_point;
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Error, Point};

use crate::error::{RegionError, Result};

/// Ends closer than this share of a curve's size are one point: files print six digits or more.
const MEETING: f64 = 1e-6;

/// A closed curve that bounds a region, in the scene's coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// The object, or the objects whose ends meet.
    pub name: String,
    /// The curve: periodic, or with its last point where its first is.
    pub curve: Curve,
    /// The straight line that closes it, where one had to.
    pub bridge: Option<[Point; 2]>,
}

/// The closed curves that some objects of a scene make: closed curves and polylines as they are, open ones joined end
/// to end, turned round where that is needed. In the order of the objects; parents' transforms are applied. What
/// leads nowhere is closed by a straight line where `bridge` says so.
///
/// # Errors
/// When an object does not exist or is no curve, or an open one leads nowhere and may not be bridged.
pub fn outlines(scene: &Scene, objects: &[String], bridge: bool) -> Result<Vec<Outline>> {
    let world = scene.world_transforms()?;
    let mut closed = Vec::new();
    let mut open: Vec<Option<Outline>> = Vec::new();
    for name in objects {
        let object = scene.object(name)?;
        let curve = match object.geometry() {
            Geometry::Curve(curve) => curve.clone(),
            Geometry::Polyline(line) => chords(&line.points, line.closed)?,
            other => return Err(RegionError::Kind { object: name.clone(), kind: other.noun().into_owned() }),
        };
        let curve = match scene.position(name).and_then(|i| world[i]) {
            None => curve,
            Some(map) => {
                let (space, points, weights) = curve.into_parts();
                Curve::build(space, points.iter().map(|p| transform_point(&map, p)).collect(), weights)?
            }
        };
        let outline = Outline { name: name.clone(), curve, bridge: None };
        match close(outline)? {
            Ok(outline) => closed.push(outline),
            Err(outline) => open.push(Some(outline)),
        }
    }
    for first in 0..open.len() {
        let Some(mut chain) = open[first].take() else { continue };
        loop {
            chain = match close(chain)? {
                Ok(outline) => {
                    closed.push(outline);
                    break;
                }
                Err(chain) => extend(chain, &mut open, bridge)?,
            };
        }
    }
    Ok(closed)
}

/// A polyline as a curve of degree 1.
fn chords(points: &[Point], closed: bool) -> Result<Curve> {
    let knots = |count: usize| (0..count).map(|k| k as f64).collect::<Vec<_>>();
    let space = match (closed, points.len()) {
        (true, n) => Space::periodic(1, knots(n + 1))?,
        (false, 0 | 1) => {
            return Err(Error::Invalid("a polyline of fewer than two points bounds nothing".into()).into());
        }
        (false, n) => Space::clamped(1, &knots(n))?,
    };
    Ok(Curve::new(space, points.to_vec())?)
}

/// The curve with its ends in one point, or as it was where they are apart.
fn close(outline: Outline) -> Result<Result<Outline, Outline>> {
    let curve = &outline.curve;
    if curve.is_periodic() {
        return Ok(Ok(outline));
    }
    let curve = curve.to_clamped()?;
    let (start, end) = ends(&curve);
    if (end - start).norm() > MEETING * size(&curve) {
        return Ok(Err(outline));
    }
    let (space, mut points, weights) = curve.into_parts();
    if let Some(last) = points.last_mut() {
        *last = start;
    }
    Ok(Ok(Outline { curve: Curve::build(space, points, weights)?, ..outline }))
}

/// The chain with the next open curve that starts, or ends, where it ends, or else with a line back to its start.
fn extend(chain: Outline, open: &mut [Option<Outline>], bridge: bool) -> Result<Outline> {
    let (start, end) = ends(&chain.curve);
    let slack = MEETING * size(&chain.curve);
    for slot in open.iter_mut() {
        let Some(next) = slot else { continue };
        let slack = slack.max(MEETING * size(&next.curve));
        let (from, to) = ends(&next.curve);
        let curve = if (from - end).norm() <= slack {
            next.curve.clone()
        } else if (to - end).norm() <= slack {
            next.curve.reverse()?
        } else {
            continue;
        };
        let joined = Outline {
            name: format!("{} + {}", chain.name, next.name),
            curve: chain.curve.join(&curve, 2.0 * slack)?.shape,
            bridge: None,
        };
        *slot = None;
        return Ok(joined);
    }
    if bridge {
        // The line gets a share of the parameter like its length: a loft joins what has the same parameter.
        let line = Curve::line(end, start)?;
        let (length, (a, b)) = (chain.curve.length(1e-6)?.value, chain.curve.domain());
        let share = (start - end).norm() / length * (b - a);
        let line = if share.is_normal() { line.reparametrise(0.0, share)? } else { line };
        let curve = chain.curve.join(&line, slack)?.shape;
        return Ok(Outline { curve, name: chain.name, bridge: Some([end, start]) });
    }
    Err(RegionError::Open { object: chain.name, gap: (end - start).norm() })
}

fn ends(curve: &Curve) -> (Point, Point) {
    let (a, b) = curve.domain();
    let at = |u: f64| curve.point(u).unwrap_or_default();
    (at(a), at(b))
}

fn size(curve: &Curve) -> f64 {
    let (low, high) = curve.bounds();
    (high - low).amax()
}
