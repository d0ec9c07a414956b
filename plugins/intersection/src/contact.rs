//! How two shapes meet at a place: by their derivatives on both sides of it, which differ at knots.
//!
//! From a place a curve goes out in two rays, forwards and backwards; at its ends in one. Two shapes touch where both rays leave the other shape to the
//! same side, as at a corner; else they cross. Where a ray runs along the other shape, the sides are those to which the curve has gone where it is away
//! by some tolerances.

use loftsman_kernel::shape::{Derivative, Location, Shape, Side, Sides};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::error::Result;
use crate::intersections::{Contact, Plane};

/// What is left of a direction of parameters beside a pole, as a part of the size.
const POLE: f64 = 1e-3;
/// Steps to the place where shapes are level, and how far it may be, as a part of the size, from where it was looked for.
const STEPS: usize = 8;
const NEAR: f64 = 1e-3;
/// Angles that are rounding of derivatives.
const LEVEL: f64 = 1e-9;
/// So many tolerances away from what it ran along a curve is on a side of it.
const AWAY: f64 = 8.0;
/// Sides are opposite whose cosine is this near to -1.
const OPPOSITE: f64 = 0.1;
/// Halvings of a span on the way to where that is.
const HALVINGS: i32 = 40;
/// How far directions may be out of a plane that are in it.
const FLAT: f64 = 1e-7;

/// The way in which a curve leaves a place, of length 1, and how it bends there (by arc length).
#[derive(Debug, Clone, Copy)]
struct Ray {
    way: Vector,
    bend: Vector,
}

/// What a curve meets.
pub(crate) trait Met: Shape {
    /// Whether it nearly stands still in a direction of its parameters, as beside a pole.
    fn stands(&self, place: Location) -> Result<bool>;

    /// Where a curve that touches it about there runs along it most nearly: the place to rounding, where the search knows it to the root of the tolerance only.
    /// `None` where that is not to be found.
    fn level(&self, curve: &Curve, at: f64, place: Location) -> Result<Option<(f64, Location)>>;

    /// How far a point is from all of it.
    fn off(&self, point: &Point) -> Result<f64>;

    /// How a curve meets it, at the curve's parameter and a place of its own.
    fn contact(&self, judge: &Judge, curve: &Curve, at: f64, place: Location) -> Result<Contact>;
}

impl Met for Curve {
    fn stands(&self, _: Location) -> Result<bool> {
        Ok(false)
    }

    fn off(&self, point: &Point) -> Result<f64> {
        Ok(self.closest(*point)?.distance)
    }

    fn level(&self, curve: &Curve, at: f64, place: Location) -> Result<Option<(f64, Location)>> {
        // A curve is nearest to itself everywhere.
        if std::ptr::eq(self, curve) {
            return Ok(None);
        }
        let gap = |s: f64| -> Result<Option<(f64, f64)>> {
            let t = self.closest(curve.point(s)?)?.at;
            let (Some(p), Some(q)) = (ray(curve, s, Side::Right)?, ray(self, t, Side::Right)?) else {
                return Ok(None);
            };
            let bend = p.bend - q.bend;
            let across = bend - p.way * bend.dot(&p.way);
            let other = if p.way.dot(&q.way) < 0.0 { -q.way } else { q.way };
            let length = across.norm();
            Ok((length > 0.0).then(|| ((p.way - other).dot(&across) / length, length)))
        };
        let Some(s) = level(curve, at, &gap)? else { return Ok(None) };
        let t = self.closest(curve.point(s)?)?.at;
        let near = is_near(t - place.on_curve()?, self.space());
        Ok(near.then_some((s, Location::Curve(t))))
    }

    fn contact(&self, judge: &Judge, curve: &Curve, at: f64, place: Location) -> Result<Contact> {
        judge.curves(curve, at, self, place.on_curve()?)
    }
}

impl Met for Surface {
    fn stands(&self, place: Location) -> Result<bool> {
        let (u, v) = place.on_surface()?;
        let (low, high) = self.hull_bounds();
        let least = POLE * (high - low).amax();
        let along = self.derivative(u, v, 1, 0)?.norm() * self.u().length();
        Ok(along <= least || self.derivative(u, v, 0, 1)?.norm() * self.v().length() <= least)
    }

    fn off(&self, point: &Point) -> Result<f64> {
        Ok(self.closest(*point)?.distance)
    }

    fn level(&self, curve: &Curve, at: f64, place: Location) -> Result<Option<(f64, Location)>> {
        let gap = |s: f64| -> Result<Option<(f64, f64)>> {
            let place = self.closest(curve.point(s)?)?.at;
            ray(curve, s, Side::Right)?.map_or(Ok(None), |ray| beside(self, place, &ray))
        };
        let Some(s) = level(curve, at, &gap)? else { return Ok(None) };
        let (u, v) = self.closest(curve.point(s)?)?.at;
        let old = place.on_surface()?;
        let near = is_near(u - old.0, self.u()) && is_near(v - old.1, self.v());
        Ok(near.then_some((s, Location::Surface(u, v))))
    }

    fn contact(&self, judge: &Judge, curve: &Curve, at: f64, place: Location) -> Result<Contact> {
        judge.surface(curve, at, self, place.on_surface()?)
    }
}

/// What tells a touching from crossings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judge {
    /// The tolerance of the search.
    tolerance: f64,
    /// How far shapes may come apart between two crossings that are one touching, in tolerances.
    gap: f64,
}

impl Judge {
    /// For a place that was shown to be the only one around, or only found by the tolerance: places closer together than some
    /// tolerances were taken for one then.
    pub(crate) fn new(tolerance: f64, simple: bool) -> Self {
        Self { tolerance, gap: if simple { 1.0 } else { 8.0 } }
    }

    /// Whether something that leaves at an angle with this sine, and bends back, is along: where it comes back (`s = 2 sin / bend`), it was
    /// away by `sin² / (2 bend)`.
    fn along(&self, sine: f64, bend: f64) -> bool {
        sine.abs() <= LEVEL || sine * sine <= 2.0 * bend.abs() * self.gap * self.tolerance
    }

    /// How two curves meet.
    fn curves(&self, curve: &Curve, s: f64, with: &Curve, t: f64) -> Result<Contact> {
        let (a, b) = (self.rays(curve, s)?, self.rays(with, t)?);
        for p in &a {
            for q in &b {
                let bend = p.bend - q.bend;
                let across = bend - p.way * bend.dot(&p.way);
                if p.way.dot(&q.way) > 0.0 && self.along(p.way.cross(&q.way).norm(), across.norm()) {
                    if std::ptr::eq(curve, with) || b.len() < 2 {
                        return Ok(Contact::Touching);
                    }
                    return self.passing(curve, s, &|s| {
                        let point = curve.point(s)?;
                        let foot = with.closest(point)?;
                        // The side is square to the plane of what is passed and the way to it, which at a corner is not square to both of its ways.
                        let mut side = Vector::zeros();
                        for (way, sign) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
                            let Some(ray) = ray(with, foot.at, way)? else { continue };
                            let across = ray.way.cross(&(point - foot.point)) * sign;
                            if across.norm() > side.norm() {
                                side = across;
                            }
                        }
                        Ok(Some(side).filter(|side| side.norm() >= 0.5 * foot.distance))
                    });
                }
            }
        }
        let ([p, q], [x, y]) = (&a[..], &b[..]) else { return Ok(Contact::Crossing) };
        // The plane of all four, if there is one.
        let all = [p.way, q.way, x.way, y.way];
        let pairs = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j)));
        let products = pairs.map(|(i, j)| all[i].cross(&all[j]));
        let normal = products.fold(Vector::zeros(), |m, n| if n.norm() > m.norm() { n } else { m });
        let length = normal.norm();
        if length <= LEVEL || all.iter().any(|way| way.dot(&normal).abs() > FLAT * length) {
            return Ok(Contact::Crossing);
        }
        let normal = normal / length;
        let turn = |way: &Vector| {
            let angle = p.way.cross(way).dot(&normal).atan2(p.way.dot(way));
            if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
        };
        let end = turn(&q.way);
        Ok(if (turn(&x.way) < end) == (turn(&y.way) < end) { Contact::Touching } else { Contact::Crossing })
    }

    /// How a curve meets a plane.
    pub(crate) fn plane(&self, curve: &Curve, at: f64, plane: &Plane) -> Result<Contact> {
        let rays = self.rays(curve, at)?;
        let normal = plane.normal();
        let sides = rays.iter().map(|ray| (ray.way.dot(&normal), ray.bend.dot(&normal)));
        if let Some(contact) = self.sides(sides) {
            return Ok(contact);
        }
        self.passing(curve, at, &|s| Ok(Some(normal * plane.distance(&curve.point(s)?))))
    }

    /// How a curve meets a surface.
    fn surface(&self, curve: &Curve, at: f64, surface: &Surface, place: (f64, f64)) -> Result<Contact> {
        let off = |u: f64, v: f64| Ok((surface.point(u, v)? - surface.point(place.0, place.1)?).norm());
        let u = self.knot(surface.u(), place.0, |u| off(u, place.1))?;
        let v = self.knot(surface.v(), place.1, |v| off(place.0, v))?;
        let place = (u, v);
        let mut sides = Vec::with_capacity(2);
        for ray in self.rays(curve, at)? {
            let Some(side) = beside(surface, place, &ray)? else { return Ok(Contact::Touching) };
            sides.push(side);
        }
        if let Some(contact) = self.sides(sides.into_iter()) {
            return Ok(contact);
        }
        self.passing(curve, at, &|s| {
            let point = curve.point(s)?;
            let foot = surface.closest(point)?;
            let (u, v) = foot.at;
            let across = surface.derivative(u, v, 1, 0)?.cross(&surface.derivative(u, v, 0, 1)?);
            let Some(across) = across.try_normalize(0.0) else { return Ok(None) };
            // Beyond an edge there is no side.
            let height = (point - foot.point).dot(&across);
            Ok((height.abs() >= 0.5 * foot.distance).then(|| Vector::z() * height))
        })
    }

    /// From the heights at which rays leave, and how they bend away. `None` where one of them runs along.
    fn sides(&self, mut sides: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Contact> {
        if sides.clone().any(|(sine, bend)| self.along(sine, bend)) {
            return None;
        }
        let (first, second) = (sides.next(), sides.next());
        let same = first.zip(second).is_some_and(|(a, b)| (a.0 > 0.0) == (b.0 > 0.0));
        Some(if same || first.is_none() { Contact::Touching } else { Contact::Crossing })
    }

    /// What a curve does that runs along something at a place: it crosses where it has come from one side and goes to the other. `side` says to which side it is
    /// at a parameter, by a vector as long as it is away; `None` where there are no sides.
    fn passing(
        &self,
        curve: &Curve,
        at: f64,
        side: &dyn Fn(f64) -> Result<Option<Vector>>,
    ) -> Result<Contact> {
        let (before, after) = (self.leaves(curve, at, -1.0, side)?, self.leaves(curve, at, 1.0, side)?);
        // Curves that are in no common plane there have no sides.
        let crosses = before.zip(after).is_some_and(|(a, b)| a.dot(&b) < -1.0 + OPPOSITE);
        Ok(if crosses { Contact::Crossing } else { Contact::Touching })
    }

    /// The side, of length 1, on which a curve is where it is away from something by some tolerances, going forwards or backwards from a place as far as to the next
    /// knot; `None` where it does not come so far.
    fn leaves(
        &self,
        curve: &Curve,
        at: f64,
        way: f64,
        side: &dyn Fn(f64) -> Result<Option<Vector>>,
    ) -> Result<Option<Vector>> {
        let (start, end) = curve.domain();
        let at = self.knot(curve.space(), at, |knot| Ok((curve.point(knot)? - curve.point(at)?).norm()))?;
        let place = curve.point(at)?;
        let closed =
            curve.is_periodic() || (curve.point(start)? - curve.point(end)?).norm() <= self.tolerance;
        let from = match (closed, way < 0.0) {
            (true, true) if at <= start => end,
            (true, false) if at >= end => start,
            _ => at,
        };
        // As far as the next knot that is another place: where a curve touches, the place is known to the root of the tolerance only.
        let (low, high) = curve.hull_bounds();
        let apart = NEAR * (high - low).norm();
        let breaks = curve.space().breakpoints();
        let ahead: Vec<f64> = if way < 0.0 {
            breaks.iter().rev().copied().filter(|knot| *knot < from).collect()
        } else {
            breaks.iter().copied().filter(|knot| *knot > from).collect()
        };
        let mut room = None;
        for knot in ahead {
            room = Some(knot - from);
            if (curve.point(knot)? - place).norm() > apart {
                break;
            }
        }
        let Some(room) = room else { return Ok(None) };
        let enough = AWAY * self.tolerance;
        for k in (0..=HALVINGS).rev() {
            let s = if k == 0 { from + room } else { from + room * 0.5_f64.powi(k) };
            let s = s.clamp(start, end);
            if (curve.point(s)? - place).norm() <= enough {
                continue;
            }
            if let Some(side) = side(s)?
                && side.norm() > enough
            {
                return Ok(side.try_normalize(0.0));
            }
        }
        Ok(None)
    }

    /// The knot that a parameter is at, as far as the tolerance tells, or the parameter.
    fn knot(&self, space: &Space, at: f64, off: impl Fn(f64) -> Result<f64>) -> Result<f64> {
        let knots = space.knots();
        let next = knots.partition_point(|knot| *knot < at);
        let (low, high) = space.domain();
        let mut best = (self.tolerance, at);
        for knot in [next.checked_sub(1), Some(next)].into_iter().flatten().filter_map(|k| knots.get(k)) {
            // What is far away may be at the same point, but is another place.
            if *knot >= low && *knot <= high && (knot - at).abs() <= 1e-3 * space.length() {
                let found = off(*knot)?;
                if found <= best.0 {
                    best = (found, *knot);
                }
            }
        }
        Ok(best.1)
    }

    /// The ways out of a place of a curve: backwards and forwards, at ends one of them. A closed curve has both where it starts.
    fn rays(&self, curve: &Curve, at: f64) -> Result<Vec<Ray>> {
        let (start, end) = curve.domain();
        let at = self.knot(curve.space(), at, |knot| Ok((curve.point(knot)? - curve.point(at)?).norm()))?;
        let mut places = vec![(at, Side::Left), (at, Side::Right)];
        if !curve.is_periodic() && (at <= start || at >= end) {
            let closed = (curve.point(start)? - curve.point(end)?).norm() <= self.tolerance;
            places = match (closed, at <= start) {
                (true, _) => vec![(end, Side::Left), (start, Side::Right)],
                (false, true) => vec![(start, Side::Right)],
                (false, false) => vec![(end, Side::Left)],
            };
        }
        let mut rays = Vec::with_capacity(2);
        for (at, side) in places {
            rays.extend(ray(curve, at, side)?);
        }
        Ok(rays)
    }
}

/// Whether two places of something closed or not, which are known to be at one point, are near by their difference: across a seam, too.
fn is_near(difference: f64, space: &Space) -> bool {
    let part = difference.abs() / space.length();
    part <= NEAR || part >= 1.0 - NEAR
}

/// Where a curve about a parameter is level to something that it touches, whose `gap` says the sine of the angle between the two and how much one bends
/// away from the other: by Newton's method, whose steps are `-sine / bend` of its length.
fn level(curve: &Curve, at: f64, gap: &dyn Fn(f64) -> Result<Option<(f64, f64)>>) -> Result<Option<f64>> {
    let (low, high) = curve.hull_bounds();
    let size = (high - low).norm();
    let (start, end) = curve.domain();
    let Some(mut here) = gap(at)? else { return Ok(None) };
    let (first, mut s) = (here.0.abs(), at);
    for _ in 0..STEPS {
        let step = -here.0 / here.1;
        if !(here.1.abs() * size >= FLAT && step.abs() <= NEAR * size) {
            return Ok(None);
        }
        if step.abs() <= f64::EPSILON * size {
            break;
        }
        let next = s + step / curve.derivative(s, 1)?.norm();
        if !next.is_finite() {
            return Ok(None);
        }
        // At an end it is level there, or nowhere.
        let next = next.clamp(start, end);
        if next == s {
            break;
        }
        s = next;
        let Some(found) = gap(s)? else { return Ok(None) };
        here = found;
    }
    let far = (curve.point(s)? - curve.point(at)?).norm();
    Ok((here.0.abs() <= first && far <= NEAR * size).then_some(s))
}

/// The way out on a side: that of the first derivative that is none.
fn ray(curve: &Curve, at: f64, side: Side) -> Result<Option<Ray>> {
    let by = |order: usize| -> Result<Vector> {
        let row = curve.stencil_on(Location::Curve(at), Derivative::from(order), side.into())?;
        Ok(row.apply(curve.points()))
    };
    let sign = if side == Side::Left { -1.0 } else { 1.0_f64 };
    let length = curve.space().length();
    let (low, high) = curve.hull_bounds();
    let least = 1e-10 * (high - low).norm();
    let first = by(1)?;
    if first.norm() * length > least {
        let speed = first.norm();
        let way = first / speed;
        let second = by(2)? / (speed * speed);
        return Ok(Some(Ray { way: way * sign, bend: second - way * second.dot(&way) }));
    }
    let mut power = length;
    for order in 2..=curve.degree() {
        power *= length;
        let d = by(order)?;
        if d.norm() * power > least {
            let way = d.normalize() * if order % 2 == 0 { 1.0 } else { sign };
            return Ok(Some(Ray { way, bend: Vector::zeros() }));
        }
    }
    Ok(None)
}

/// The height at which a ray leaves the tangent plane of the part of a surface that it leaves over, and how much it bends away from the surface.
/// `None` where the surface has no normal.
fn beside(surface: &Surface, (u, v): (f64, f64), ray: &Ray) -> Result<Option<(f64, f64)>> {
    let mut best: Option<(f64, (f64, f64))> = None;
    for (one, su) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
        for (other, sv) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
            let by = |a: usize, b: usize| -> Result<Vector> {
                let sides = Sides { u: one, v: other };
                let row = surface.stencil_on(Location::Surface(u, v), Derivative { u: a, v: b }, sides)?;
                Ok(row.apply(surface.points()))
            };
            let (du, dv) = (by(1, 0)?, by(0, 1)?);
            let normal = du.cross(&dv);
            let square = normal.norm_squared();
            if square.is_nan() || square <= 1e-20 * du.norm_squared() * dv.norm_squared() {
                continue;
            }
            // The way in the tangent plane, in the parameters.
            let (x, y) = (ray.way.cross(&dv).dot(&normal) / square, du.cross(&ray.way).dot(&normal) / square);
            let (x, y) = (x * du.norm(), y * dv.norm());
            // How far this quarter is from having the way in it.
            let outside = (-x * su).max(0.0).max((-y * sv).max(0.0));
            if best.as_ref().is_some_and(|(known, _)| *known <= outside) {
                continue;
            }
            let unit = normal / square.sqrt();
            let (x, y) = (x / du.norm(), y / dv.norm());
            let second = by(2, 0)? * (x * x) + by(1, 1)? * (2.0 * x * y) + by(0, 2)? * (y * y);
            best = Some((outside, (ray.way.dot(&unit), (ray.bend - second).dot(&unit))));
        }
    }
    if let Some((_, side)) = best {
        return Ok(Some(side));
    }
    // A pole: its normal is a limit, and what bends there is as large as the surface at least.
    let (low, high) = surface.hull_bounds();
    let bend = ray.bend.norm() + 4.0 / (high - low).norm();
    Ok(surface.normal(u, v)?.vector().map(|unit| (ray.way.dot(&unit), bend)))
}
