//! Conic arcs (104): pieces of `A x² + B xy + C y² + D x + E y + F = 0` in the plane `z = ZT`.

use std::f64::consts::TAU;

use loftsman_kernel::brep::{CurveForm, Frame};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::curve::Run;
use super::entity::{At, Entity, Got, Problem};
use super::pace::Pace;

/// A discriminant of no more than this, where the largest coefficient of the squares is 1, is that of a parabola.
const FLAT: f64 = 1e-12;

/// The equation of a conic.
struct Conic {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
    f: f64,
}

/// A conic arc from its start to its end, counterclockwise where it is an ellipse.
pub(crate) fn conic(entity: &Entity<'_, '_>) -> Got<Run> {
    let place = entity.place;
    let all = entity.reals(1, 11)?;
    let [a, b, c, d, e, f, z, x1, y1, x2, y2] = <[f64; 11]>::try_from(all).unwrap_or_default();
    // Numbers of a size: the equation times anything is the same.
    let largest = [a, b, c].into_iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return Err(Problem::new(place, "the equation of a conic without squares"));
    }
    let [a, b, c, d, e, f] = [a, b, c, d, e, f].map(|x| x / largest);
    let conic = Conic { a, b, c, d, e, f };
    let (start, end) = (Point::new(x1, y1, z), Point::new(x2, y2, z));
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < -FLAT { conic.ellipse(start, end, place) } else { conic.open(start, end, place) }
}

impl Conic {
    /// The polar form of two points: 0 of a point and itself where that is on the conic.
    fn polar(&self, p: &Point, q: &Point) -> f64 {
        self.a * p.x * q.x
            + 0.5 * self.b * (p.x * q.y + p.y * q.x)
            + self.c * p.y * q.y
            + 0.5 * self.d * (p.x + q.x)
            + 0.5 * self.e * (p.y + q.y)
            + self.f
    }

    fn ellipse(&self, start: Point, end: Point, place: usize) -> Got<Run> {
        let Self { a, b, c, d, e, .. } = *self;
        let discriminant = 4.0 * a * c - b * b;
        let center =
            Point::new((b * e - 2.0 * c * d) / discriminant, (b * d - 2.0 * a * e) / discriminant, start.z);
        let value = -self.polar(&center, &center);
        let ([x, y], [first, second]) = self.axes();
        let radii = [(value / first).sqrt(), (value / second).sqrt()];
        if !radii.iter().all(|r| *r > 0.0 && r.is_finite()) {
            return Err(Problem::new(
                place,
                "an ellipse without points: its coefficients are of no real one",
            ));
        }
        let at = |p: Point| {
            let v = p - center;
            (v.dot(&y) / radii[1]).atan2(v.dot(&x) / radii[0])
        };
        let from = at(start);
        let sweep = (at(end) - from).rem_euclid(TAU);
        let sweep = if !(1e-9..=TAU - 1e-9).contains(&sweep) { TAU } else { sweep };
        let curve = Curve::elliptic_arc(center, x * radii[0], y * radii[1], from, sweep).at(place)?;
        let (low, high) = curve.domain();
        let range = [from, from + sweep];
        let from = from.rem_euclid(TAU);
        let pace = Pace::turn([from, from + sweep], [low, high], curve.space().spans().count(), sweep);
        let frame = Frame::new(center, Vector::z(), x);
        let form = frame.map_or(CurveForm::Spline, |frame| CurveForm::Ellipse { frame, radii });
        Ok(Run { curve, pace, form, range })
    }

    /// The directions in which the quadratic form has its extremes, and these.
    fn axes(&self) -> ([Vector; 2], [f64; 2]) {
        let Self { a, b, c, .. } = *self;
        // In standard position the axes are those of the plane, to the bit.
        let (sin, cos) = if b == 0.0 { (0.0, 1.0) } else { (0.5 * b.atan2(a - c)).sin_cos() };
        let first = a * cos * cos + b * sin * cos + c * sin * sin;
        let second = a * sin * sin - b * sin * cos + c * cos * cos;
        ([Vector::new(cos, sin, 0.0), Vector::new(-sin, cos, 0.0)], [first, second])
    }

    /// What a parabola is: in the axes `k v² + l u + m v + f = 0`.
    fn parabola(&self, z: f64) -> Option<CurveForm> {
        let ([x, y], [first, second]) = self.axes();
        let linear = |axis: Vector| self.d * axis.x + self.e * axis.y;
        let (along, across, k) = if first.abs() < second.abs() { (x, y, second) } else { (y, x, first) };
        let (l, m) = (linear(along), linear(across));
        let v = -0.5 * m / k;
        let u = (k * v * v - self.f) / l;
        let origin = Point::from(along * u + across * v) + Vector::z() * z;
        let frame = Frame::new(origin, Vector::z(), along * -(l / k).signum())?;
        Some(CurveForm::Parabola { frame, focal: 0.25 * (l / k).abs() })
    }

    /// What a hyperbola is: the branch that a point is on.
    fn hyperbola(&self, on: Point) -> Option<CurveForm> {
        let Self { a, b, c, d, e, .. } = *self;
        let discriminant = 4.0 * a * c - b * b;
        let center =
            Point::new((b * e - 2.0 * c * d) / discriminant, (b * d - 2.0 * a * e) / discriminant, on.z);
        let value = -self.polar(&center, &center);
        let ([x, y], [first, second]) = self.axes();
        let (along, own, other) = if value / first > 0.0 { (x, first, second) } else { (y, second, first) };
        let side = (on - center).dot(&along).signum();
        let frame = Frame::new(center, Vector::z(), along * side)?;
        Some(CurveForm::Hyperbola { frame, radii: [(value / own).sqrt(), (-value / other).sqrt()] })
    }

    /// A piece of a parabola or a hyperbola: one rational Bézier curve, whose middle vertex is where the tangents at the ends meet.
    /// With the polar form `Q` and the weight `w` there, all points are on the conic where `w² = -Q(P₀, P₂) / (2 Q(P₁, P₁))`.
    fn open(&self, start: Point, end: Point, place: usize) -> Got<Run> {
        let gradient = |p: &Point| {
            (2.0 * self.a * p.x + self.b * p.y + self.d, self.b * p.x + 2.0 * self.c * p.y + self.e)
        };
        let ((a1, b1), (a2, b2)) = (gradient(&start), gradient(&end));
        let determinant = a1 * b2 - b1 * a2;
        let (r1, r2) = (a1 * start.x + b1 * start.y, a2 * end.x + b2 * end.y);
        let middle =
            Point::new((r1 * b2 - b1 * r2) / determinant, (a1 * r2 - r1 * a2) / determinant, start.z);
        let square = -0.5 * self.polar(&start, &end) / self.polar(&middle, &middle);
        // Ends on both branches of a hyperbola, or off the conic, give no weight.
        if !(middle.iter().all(|c| c.is_finite()) && square > 0.0 && square.is_finite()) {
            return Err(Problem::new(place, "its ends are not on one branch of its conic"));
        }
        let (weight, space) = (square.sqrt(), Space::clamped(2, &[0.0, 1.0]).at(place)?);
        let on = [&start, &end].iter().all(|p| {
            let (gx, gy) = gradient(p);
            let off = self.polar(p, p).abs() / gx.hypot(gy);
            off <= 1e-4 * nalgebra::distance(&start, &end)
        });
        if !on {
            return Err(Problem::new(place, "its ends are off its conic"));
        }
        let points = vec![start, middle, end];
        let curve = if (weight - 1.0).abs() <= 1e-12 {
            Curve::new(space, points)
        } else {
            Curve::rational(space, points, vec![1.0, weight, 1.0])
        };
        let discriminant = self.b * self.b - 4.0 * self.a * self.c;
        let is_parabola = discriminant <= FLAT;
        let form = if is_parabola { self.parabola(start.z) } else { self.hyperbola(start) };
        let form = form.unwrap_or_default();
        let at = |p: Point| match form {
            CurveForm::Parabola { frame, focal } => (p - frame.origin).dot(&frame.y()) / (2.0 * focal),
            CurveForm::Hyperbola { frame, radii } => ((p - frame.origin).dot(&frame.y()) / radii[1]).asinh(),
            _ => 0.0,
        };
        Ok(Run { range: [at(start), at(end)], ..Run::spline(curve.at(place)?, form) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_on_their_conics() {
        // x² - y² = 1, y = x², and a hyperbola that is turned.
        let cosh = |t: f64| Point::new(t.cosh(), t.sinh(), 3.0);
        let square = |t: f64| Point::new(t, t * t, 3.0);
        let inverse = |t: f64| Point::new(t, 1.0 / t, 3.0);
        let conic = |[a, b, c, d, e, f]: [f64; 6]| Conic { a, b, c, d, e, f };
        for (conic, start, end) in [
            (conic([1.0, 0.0, -1.0, 0.0, 0.0, -1.0]), cosh(-1.5), cosh(0.5)),
            (conic([1.0, 0.0, 0.0, 0.0, -1.0, 0.0]), square(-1.0), square(2.0)),
            (conic([0.0, 1.0, 0.0, 0.0, 0.0, -1.0]), inverse(0.25), inverse(3.0)),
        ] {
            let run = conic.open(start, end, 0).unwrap();
            for k in 0..=20 {
                let p = run.curve.point(f64::from(k) / 20.0).unwrap();
                assert!(conic.polar(&p, &p).abs() < 1e-13, "{p}");
                assert!((p.z - 3.0).abs() < 1e-15);
            }
        }
        // x²/4 + y² = 1 about (1, 2).
        let ellipse = conic([0.25, 0.0, 1.0, -0.5, -4.0, 3.25]);
        let run = ellipse.ellipse(Point::new(3.0, 2.0, 0.0), Point::new(1.0, 3.0, 0.0), 0).unwrap();
        let [from, to] = run.pace.range();
        assert!((to - from - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
        for k in 0..=20 {
            let t = run.pace.at(from + (to - from) * f64::from(k) / 20.0).unwrap();
            let p = run.curve.point(t).unwrap();
            assert!(ellipse.polar(&p, &p).abs() < 1e-14);
            assert!(p.x > 1.0 - 1e-12 && p.y > 2.0 - 1e-12);
        }
        assert!(ellipse.open(Point::origin(), Point::new(5.0, 5.0, 0.0), 0).is_err());
    }
}
