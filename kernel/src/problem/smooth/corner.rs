//! Corners that an edit makes: the places that it touches are measured before and after.

use std::collections::BTreeMap;

use super::columns::Columns;
use super::joint::Joint;
use crate::Vector;
use crate::functional::{On, Shapes};
use crate::problem::Corner;
use crate::shape::{Derivative, Location, SMOOTH, Shape, Side, Sides};

/// A place where both sides of a joint are compared.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    on: On,
    face: Option<u32>,
    direction: usize,
    /// The knot, and for a surface where along it.
    at: (f64, Option<f64>),
    /// The places on the left and on the right, and the sides that they are seen from.
    places: [(Location, Sides); 2],
    lengths: [f64; 2],
    /// How long the span along the knot line of a surface is.
    width: f64,
    before: Measured,
}

/// A place of a surface, or of a face of many.
fn on_surface(face: Option<u32>, u: f64, v: f64) -> Location {
    face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
}

/// What was found there.
#[derive(Debug, Clone, Copy, Default)]
struct Measured {
    /// The angle between the tangents (of a surface: between the normals), in radians, where both exist.
    angle: Option<f64>,
    /// How far the sides are apart.
    gap: f64,
    /// The size of the pieces there.
    size: f64,
}

impl Watch {
    /// The places to compare along a joint: one of a curve, on a surface the ends and the middle of a span.
    pub(super) fn along(
        shapes: &Shapes<'_>,
        net: &Columns<'_>,
        joint: &Joint,
        span: usize,
        on: &On,
    ) -> Vec<Self> {
        let lengths = joint.lengths(net.across);
        let width = net.along.map_or(0.0, |along| along.flat()[span + 1] - along.flat()[span]);
        let at = |t: Option<(f64, Side)>| -> Option<Self> {
            let place = |knot: f64, side: Side| match (t, net.direction) {
                (None, _) => (Location::Curve(knot), Sides::from(side)),
                (Some((v, other)), 0) => (on_surface(net.face, knot, v), Sides::from([side, other])),
                (Some((v, other)), _) => (on_surface(net.face, v, knot), Sides::from([other, side])),
            };
            let places = [place(joint.left.1, Side::Left), place(joint.right.1, Side::Right)];
            let (on, at) = (on.clone(), (joint.right.1, t.map(|(v, _)| v)));
            let mut watch = Self {
                on,
                face: net.face,
                direction: net.direction,
                at,
                places,
                lengths,
                width,
                before: Measured::default(),
            };
            watch.before = watch.measure(shapes.get(net.shape).ok()?)?;
            Some(watch)
        };
        let Some(along) = net.along else { return at(None).into_iter().collect() };
        let (a, b) = (along.flat()[span], along.flat()[span + 1]);
        let samples = [(a, Side::Right), (0.5 * a + 0.5 * b, Side::Right), (b, Side::Left)];
        samples.into_iter().filter_map(|sample| at(Some(sample))).collect()
    }

    fn measure(&self, shape: &dyn Shape) -> Option<Measured> {
        let value = |side: usize, derivative: Derivative| -> Option<Vector> {
            let (at, sides) = self.places[side];
            Some(shape.stencil_on(at, derivative, sides).ok()?.apply(shape.control_vertices()))
        };
        let ends = [value(0, Derivative::POSITION)?, value(1, Derivative::POSITION)?];
        let (mut size, mut reach) = (0.0_f64, 0.0_f64);
        for ((at, sides), end) in self.places.into_iter().zip(&ends) {
            for &i in shape.stencil_on(at, Derivative::POSITION, sides).ok()?.vertices() {
                let p = shape.control_vertices().get(i)?.coords;
                size = size.max((p - end).norm());
                reach = reach.max(p.amax());
            }
        }
        let least = (1e-9 * size).max(64.0 * f64::EPSILON * reach);
        let unit = |v: Vector, way: f64| (way > least && way.is_finite()).then(|| v / v.norm());
        let direction = |side: usize| -> Option<Vector> {
            if self.at.1.is_some() {
                let of =
                    |k: usize| if k == 0 { Derivative { u: 1, v: 0 } } else { Derivative { u: 0, v: 1 } };
                let across = value(side, of(self.direction))?;
                let along = value(side, of(1 - self.direction))?;
                let (far, wide) = (across.norm() * self.lengths[side], along.norm() * self.width);
                // Either may be rounding beside the other: where the surface is but a curve there is no normal.
                let normal = unit(across, far)?.cross(&unit(along, wide)?);
                return unit(normal, normal.norm() * far.min(wide));
            }
            // The first derivative that does not vanish has the direction in which the curve goes on; before the joint, one
            // of even order points back.
            let mut reached = 1.0;
            (1..=25).find_map(|k: usize| {
                reached *= self.lengths[side] / k as f64;
                let derivative = value(side, k.into())?;
                let back = if side == 0 && k.is_multiple_of(2) { -1.0 } else { 1.0 };
                unit(derivative * back, derivative.norm() * reached)
            })
        };
        let angle = direction(0).zip(direction(1)).map(|(a, b)| a.cross(&b).norm().atan2(a.dot(&b)));
        Some(Measured { angle, gap: (ends[1] - ends[0]).norm(), size: size.max(reach * f64::EPSILON * 1e8) })
    }

    /// What the place has become, if that is another corner than it was, or a gap.
    fn changed(&self, shapes: &Shapes<'_>) -> Option<Corner> {
        let now = self.measure(shapes.get(self.on.shape).ok()?)?;
        let meets = |m: &Measured| m.gap <= 1e-6 * m.size;
        let opened = meets(&self.before) && !meets(&now);
        let turned = match (self.before.angle, now.angle) {
            _ if !meets(&now) => false,
            (Some(before), Some(after)) => after > SMOOTH && (after - before).abs() > SMOOTH,
            (None, Some(after)) => after > SMOOTH,
            _ => false,
        };
        (opened || turned).then(|| Corner {
            place: self.place(),
            degrees: now.angle.filter(|_| turned).map(f64::to_degrees),
            before: self.before.angle.map(f64::to_degrees),
            gap: opened.then_some(now.gap),
        })
    }

    /// Which knot of which shape: corners of one line are one corner.
    fn line(&self) -> (usize, Option<u32>, usize, u64) {
        (self.on.shape, self.face, self.direction, self.at.0.to_bits())
    }

    fn place(&self) -> String {
        let (knot, on) = (self.at.0, format!("{}{}", super::on_face(self.face), self.on));
        match (self.at.1, self.direction) {
            (None, _) => format!("at {knot}{on}"),
            (Some(v), 0) => format!("along u = {knot}{on} (at v = {v})"),
            (Some(u), _) => format!("along v = {knot}{on} (at u = {u})"),
        }
    }
}

/// The corners that have changed, of a knot line the sharpest one; in the order of the watches.
pub(super) fn corners<'a>(watches: impl Iterator<Item = &'a Watch>, shapes: &Shapes<'_>) -> Vec<Corner> {
    let mut found: Vec<Corner> = Vec::new();
    let mut lines = BTreeMap::new();
    for watch in watches {
        let Some(corner) = watch.changed(shapes) else { continue };
        let sharpness = |c: &Corner| (c.gap.unwrap_or(0.0), c.degrees.unwrap_or(0.0));
        let known = *lines.entry(watch.line()).or_insert(found.len());
        match found.get_mut(known) {
            Some(known) if sharpness(known) < sharpness(&corner) => *known = corner,
            Some(_) => {}
            None => found.push(corner),
        }
    }
    found
}
