//! Corners that an edit makes: the places that it touches are measured before and after.

use std::collections::BTreeMap;

use super::columns::Columns;
use super::joint::Joint;
use crate::functional::{On, Shapes};
use crate::problem::Corner;
use crate::shape::{Derivative, Location, SMOOTH, Shape, Side, Sides};
use crate::{Point, Vector};

/// A place where both sides of a joint are compared; on a surface all those along a span of the knot line.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    on: On,
    face: Option<u32>,
    direction: usize,
    /// The knot as the left and as the right side come to it.
    knots: [f64; 2],
    /// The span along the knot line of a surface, and its degree.
    along: Option<(f64, f64, usize)>,
    /// How long the spans across it are.
    lengths: [f64; 2],
    /// The control vertices that have a part in it, as they were: what was measured is found from them, wherever it is asked for.
    before: Vec<(usize, Point)>,
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
    /// The directions on both sides.
    directions: [Option<Vector>; 2],
    /// How far the sides are apart.
    gap: f64,
    /// The size of the pieces there.
    size: f64,
}

/// Where along a knot line, seen from which side of it.
type Along = Option<(f64, Side)>;

/// A place along a knot line is told another than the ends and the middle of a span where the corner there is sharper by this share.
const SHARPER: f64 = 1e-4;
/// A normal has turned far by more than some 15 degrees between two places; so often are they halved.
const FAR: f64 = 0.966;
const HALVINGS: usize = 10;
/// So often is the interval with the sharpest place along a span made shorter, by the golden section: to 1e-7 of itself.
const SECTIONS: usize = 34;

impl Watch {
    /// What to compare along a joint: one place of a curve, a span of a surface.
    pub(super) fn along(
        shapes: &Shapes<'_>,
        net: &Columns<'_>,
        joint: &Joint,
        span: usize,
        on: &On,
    ) -> Option<Self> {
        let along = net.along.map(|along| (along.flat()[span], along.flat()[span + 1], along.degree()));
        let mut watch = Self {
            on: on.clone(),
            face: net.face,
            direction: net.direction,
            knots: [joint.left.1, joint.right.1],
            along,
            lengths: joint.lengths(net.across),
            before: Vec::new(),
        };
        let shape = shapes.get(net.shape).ok()?;
        let middle = along.map(|(a, b, _)| (0.5 * a + 0.5 * b, Side::Right));
        for (at, sides) in watch.places(middle) {
            for &vertex in shape.stencil_on(at, Derivative::POSITION, sides).ok()?.vertices() {
                watch.before.push((vertex, *shape.control_vertices().get(vertex)?));
            }
        }
        watch.before.sort_by_key(|(vertex, _)| *vertex);
        watch.before.dedup_by_key(|(vertex, _)| *vertex);
        Some(watch)
    }

    /// The places on the left and on the right, and the sides that they are seen from.
    fn places(&self, t: Along) -> [(Location, Sides); 2] {
        let place = |knot: f64, side: Side| match (t, self.direction) {
            (None, _) => (Location::Curve(knot), Sides::from(side)),
            (Some((v, other)), 0) => (on_surface(self.face, knot, v), Sides::from([side, other])),
            (Some((v, other)), _) => (on_surface(self.face, v, knot), Sides::from([other, side])),
        };
        [place(self.knots[0], Side::Left), place(self.knots[1], Side::Right)]
    }

    /// What the two sides do at a place, with the control vertices of the shape as they are or were.
    fn measure(
        &self,
        shape: &dyn Shape,
        point: &dyn Fn(usize) -> Option<Point>,
        t: Along,
    ) -> Option<Measured> {
        let places = self.places(t);
        let value = |side: usize, derivative: Derivative| -> Option<Vector> {
            let (at, sides) = places[side];
            let stencil = shape.stencil_on(at, derivative, sides).ok()?;
            stencil.iter().try_fold(Vector::zeros(), |sum, (i, c)| Some(sum + point(i)?.coords * c))
        };
        let ends = [value(0, Derivative::POSITION)?, value(1, Derivative::POSITION)?];
        let (mut size, mut reach) = (0.0_f64, 0.0_f64);
        for ((at, sides), end) in places.into_iter().zip(&ends) {
            for &i in shape.stencil_on(at, Derivative::POSITION, sides).ok()?.vertices() {
                let p = point(i)?.coords;
                size = size.max((p - end).norm());
                reach = reach.max(p.amax());
            }
        }
        let least = (1e-9 * size).max(64.0 * f64::EPSILON * reach);
        let unit = |v: Vector, way: f64| (way > least && way.is_finite()).then(|| v / v.norm());
        let direction = |side: usize| -> Option<Vector> {
            if let Some((a, b, _)) = self.along {
                let of =
                    |k: usize| if k == 0 { Derivative { u: 1, v: 0 } } else { Derivative { u: 0, v: 1 } };
                let across = value(side, of(self.direction))?;
                let along = value(side, of(1 - self.direction))?;
                let (far, wide) = (across.norm() * self.lengths[side], along.norm() * (b - a));
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
        let directions = [direction(0), direction(1)];
        let angle = directions[0].zip(directions[1]).map(|(a, b)| a.cross(&b).norm().atan2(a.dot(&b)));
        let gap = (ends[1] - ends[0]).norm();
        Some(Measured { angle, directions, gap, size: size.max(reach * f64::EPSILON * 1e8) })
    }

    /// What a place has become, if that is another corner than it was, or a gap.
    fn changed(&self, shape: &dyn Shape, t: Along) -> Option<Corner> {
        self.now(shape, t).and_then(|now| self.corner(shape, t, &now))
    }

    fn now(&self, shape: &dyn Shape, t: Along) -> Option<Measured> {
        self.measure(shape, &|i| shape.control_vertices().get(i).copied(), t)
    }

    fn corner(&self, shape: &dyn Shape, t: Along, now: &Measured) -> Option<Corner> {
        let was = |i: usize| {
            let at = self.before.binary_search_by_key(&i, |(vertex, _)| *vertex).ok()?;
            Some(self.before[at].1)
        };
        let before = self.measure(shape, &was, t)?;
        let meets = |m: &Measured| m.gap <= 1e-6 * m.size;
        let opened = meets(&before) && !meets(now);
        let turned = match (before.angle, now.angle) {
            _ if !meets(now) => false,
            (Some(before), Some(after)) => after > SMOOTH && (after - before).abs() > SMOOTH,
            (None, Some(after)) => after > SMOOTH,
            _ => false,
        };
        (opened || turned).then(|| Corner {
            place: self.place(t.map(|(t, _)| t)),
            degrees: now.angle.filter(|_| turned).map(f64::to_degrees),
            before: before.angle.map(f64::to_degrees),
            gap: opened.then_some(now.gap),
        })
    }

    /// The sharpest corner that is found at the ends, in the middle and at places between them, as many as a span's normals of this degree can
    /// turn between; and where it may be sharper beside them.
    fn sharpest<'a>(&'a self, shape: &dyn Shape) -> (Option<Corner>, Vec<Peak<'a>>) {
        let Some((a, b, degree)) = self.along else { return (self.changed(shape, None), Vec::new()) };
        let intervals = 4 * degree + 4;
        let at = |k: usize| match k {
            0 => (a, Side::Right),
            k if k == intervals => (b, Side::Left),
            k if 2 * k == intervals => (0.5 * a + 0.5 * b, Side::Right),
            k => (a + (b - a) * (k as f64 / intervals as f64), Side::Right),
        };
        let mut places: Vec<(f64, Side)> = (0..=intervals).map(at).collect();
        let mut seen: Vec<Option<Measured>> = places.iter().map(|t| self.now(shape, Some(*t))).collect();
        // Where a normal is nearly none it turns at once: between places where one has turned far there are more of them.
        for _ in 0..HALVINGS {
            let far = |k: usize| {
                let ends = seen[k].as_ref().zip(seen[k + 1].as_ref());
                ends.is_none_or(|(one, other)| {
                    (0..2).any(|side| {
                        let both = one.directions[side].zip(other.directions[side]);
                        both.is_none_or(|(one, other)| one.dot(&other) < FAR)
                    })
                })
            };
            let wide: Vec<usize> = (0..places.len() - 1).filter(|k| far(*k)).take(intervals).collect();
            for k in wide.into_iter().rev() {
                let middle = (0.5 * places[k].0 + 0.5 * places[k + 1].0, Side::Right);
                if places[k].0 < middle.0 && middle.0 < places[k + 1].0 {
                    seen.insert(k + 1, self.now(shape, Some(middle)));
                    places.insert(k + 1, middle);
                }
            }
        }
        let last = places.len() - 1;
        let each = places.iter().zip(&seen);
        let all: Vec<Option<Corner>> =
            each.map(|(t, now)| self.corner(shape, Some(*t), now.as_ref()?)).collect();
        let half = places.iter().position(|(t, _)| *t == 0.5 * a + 0.5 * b).unwrap_or(0);
        let first = [0, half, last];
        let mut best: Option<&Corner> = None;
        for (k, corner) in first.into_iter().map(|k| (k, &all[k])).chain(all.iter().enumerate()) {
            let Some(corner) = corner else { continue };
            let share = if first.contains(&k) { 0.0 } else { SHARPER };
            if best.is_none_or(|best| sharper(corner, best, share)) {
                best = Some(corner);
            }
        }
        let height = |k: usize| all[k].as_ref().map_or((0.0, 0.0), sharpness);
        let peak = |k: usize| {
            let (low, high) = (k.saturating_sub(1), (k + 1).min(last));
            let (own, left, right) = (height(k), height(low), height(high));
            let is = own > (0.0, 0.0) && own >= left && own >= right;
            let more = |pick: fn((f64, f64)) -> f64| 2.0 * pick(own) - pick(left).min(pick(right));
            is.then(|| Peak {
                watch: self,
                between: (places[low].0, places[high].0),
                hope: (more(|s| s.0), more(|s| s.1)),
            })
        };
        (best.cloned(), (0..=last).filter_map(peak).collect())
    }

    /// Which knot of which shape: corners of one line are one corner.
    fn line(&self) -> (usize, Option<u32>, usize, u64) {
        (self.on.shape, self.face, self.direction, self.knots[1].to_bits())
    }

    fn place(&self, t: Option<f64>) -> String {
        let (knot, on) = (self.knots[1], format!("{}{}", super::on_face(self.face), self.on));
        let Some((t, (a, b, _))) = t.zip(self.along) else { return format!("at {knot}{on}") };
        let t = if t == a || t == b || t == 0.5 * a + 0.5 * b { t } else { brief(t, b - a) };
        match self.direction {
            0 => format!("along u = {knot}{on} (at v = {t})"),
            _ => format!("along v = {knot}{on} (at u = {t})"),
        }
    }
}

/// A parameter to a thousandth of a span of this width: a corner is as sharp there.
fn brief(t: f64, width: f64) -> f64 {
    let decimals = (3.0 - width.log10().floor()).clamp(0.0, 17.0) as usize;
    format!("{t:.decimals$}").parse().unwrap_or(t)
}

/// Where along a span a corner may be sharper than at the places that were looked at: how much it could be.
struct Peak<'a> {
    watch: &'a Watch,
    between: (f64, f64),
    hope: (f64, f64),
}

impl Peak<'_> {
    /// The sharpest corner there, by the golden section (Kiefer 1953).
    fn climb(&self, shape: &dyn Shape) -> Option<Corner> {
        let (mut a, mut b) = self.between;
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let look = |t: f64| {
            let corner = self.watch.changed(shape, Some((t, Side::Right)));
            (corner.as_ref().map_or((0.0, 0.0), sharpness), corner)
        };
        let (mut s, mut t) = (b - golden * (b - a), a + golden * (b - a));
        let (mut low, mut high) = (look(s), look(t));
        for _ in 0..SECTIONS {
            if low.0 >= high.0 {
                (b, t, high) = (t, s, low);
                s = b - golden * (b - a);
                low = look(s);
            } else {
                (a, s, low) = (s, t, high);
                t = a + golden * (b - a);
                high = look(t);
            }
        }
        if low.0 >= high.0 { low.1 } else { high.1 }
    }
}

/// Gaps before corners.
fn sharpness(corner: &Corner) -> (f64, f64) {
    (corner.gap.unwrap_or(0.0), corner.degrees.unwrap_or(0.0))
}

/// Whether one is sharper than another by more than a share.
fn sharper(one: &Corner, other: &Corner, share: f64) -> bool {
    let (other, more) = (sharpness(other), 1.0 + share);
    let one = sharpness(one);
    one.0 > other.0 * more || one.0 >= other.0 && one.1 > other.1 * more
}

/// The corners that have changed, of a knot line where it is sharpest; in the order of the watches. Costs some `20 p` looks for each span
/// of degree `p`, and some dozens more where it may be sharpest.
pub(super) fn corners<'a>(watches: impl Iterator<Item = &'a Watch>, shapes: &Shapes<'_>) -> Vec<Corner> {
    let mut found: Vec<(Corner, Vec<Peak<'a>>)> = Vec::new();
    let mut lines = BTreeMap::new();
    for watch in watches {
        let Ok(shape) = shapes.get(watch.on.shape) else { continue };
        let (Some(corner), peaks) = watch.sharpest(shape) else { continue };
        let known = *lines.entry(watch.line()).or_insert(found.len());
        match found.get_mut(known) {
            Some((known, all)) => {
                all.extend(peaks);
                if sharpness(known) < sharpness(&corner) {
                    *known = corner;
                }
            }
            None => found.push((corner, peaks)),
        }
    }
    for (best, peaks) in &mut found {
        for peak in &*peaks {
            if peak.hope.0 < sharpness(best).0 || peak.hope.1 < sharpness(best).1 * (1.0 + SHARPER) {
                continue;
            }
            let Ok(shape) = shapes.get(peak.watch.on.shape) else { continue };
            if let Some(corner) = peak.climb(shape).filter(|corner| sharper(corner, best, SHARPER)) {
                *best = corner;
            }
        }
    }
    found.into_iter().map(|(corner, _)| corner).collect()
}
