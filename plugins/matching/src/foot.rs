//! The nearest place of a curve, or of a surface, to a point: by descent from a place that is near.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::beside::closed;

/// The most steps to a nearest place, and halvings of one.
const STEPS: usize = 12;
/// Newton's step is taken where the distance bends up by more than this part of what it would along a straight line.
const BENDS: f64 = 0.1;

/// A curve whose nearest places are looked for.
pub(crate) struct Foot {
    curve: Curve,
    /// Whether it ends where it begins, so that there is no end to stop at.
    closed: bool,
}

impl Foot {
    pub(crate) fn new(curve: Curve) -> Result<Self> {
        let closed = closed(&curve)?;
        Ok(Self { curve, closed })
    }

    /// The parameter near to `u` where the curve is nearest to a point, and the way from the point to it: Newton's steps for the squared distance, or
    /// along the tangent where that does not bend up, each halved until it comes nearer.
    pub(crate) fn of(&self, mut u: f64, point: &Point) -> Result<(f64, Vector)> {
        let (a, b) = self.curve.domain();
        let inside = |u: f64| match u {
            u if self.closed && u < a => (u + (b - a)).clamp(a, b),
            u if self.closed && u > b => (u - (b - a)).clamp(a, b),
            u => u.clamp(a, b),
        };
        let mut from = self.curve.point(u)? - point;
        for _ in 0..STEPS {
            let (tangent, second) = (self.curve.derivative(u, 1)?, self.curve.derivative(u, 2)?);
            let straight = tangent.norm_squared();
            let bent = straight + from.dot(&second);
            let step = from.dot(&tangent) / if bent > BENDS * straight { bent } else { straight };
            let nearer = (0..STEPS as i32).find_map(|half| {
                let next = inside(u - step * 0.5_f64.powi(half));
                let now = self.curve.point(next).ok()? - point;
                (now.norm() < from.norm()).then_some((next, now))
            });
            let Some((next, now)) = nearer else { break };
            let done = (next - u).abs() <= 1e-9 * (b - a);
            (u, from) = (next, now);
            if done {
                break;
            }
        }
        Ok((u, from))
    }
}

/// How far a point is from a surface, from these parameters on downwards: steps in the tangent plane (Gauss and Newton), each halved until it comes nearer. No
/// less than the distance of the nearest place of all, and no more than that of these parameters.
///
/// # Errors
/// When the parameters are outside.
pub(crate) fn descend(surface: &Surface, [mut u, mut v]: [f64; 2], point: &Point) -> Result<f64> {
    let inside = |space: &Space, t: f64| {
        let (a, b) = space.domain();
        match t {
            t if space.is_periodic() && t < a => (t + (b - a)).clamp(a, b),
            t if space.is_periodic() && t > b => (t - (b - a)).clamp(a, b),
            t => t.clamp(a, b),
        }
    };
    let mut all = [Vector::zeros(); 4];
    surface.derivatives_into(u, v, [1, 1], &mut all)?;
    let mut from = all[0] - point.coords;
    for _ in 0..STEPS {
        let ([x, y], r) = ([all[2], all[1]], from);
        let (e, f, g) = (x.norm_squared(), x.dot(&y), y.norm_squared());
        let (p, q) = (r.dot(&x), r.dot(&y));
        let determinant = e * g - f * f;
        let plane = [(g * p - f * q) / determinant, (e * q - f * p) / determinant];
        // At a border the step along it, and where there is no tangent plane what each parameter brings.
        let steps = [plane, [p / e, 0.0], [0.0, q / g]];
        let mut nearer = None;
        for [du, dv] in steps.into_iter().filter(|[du, dv]| du.is_finite() && dv.is_finite()) {
            for half in 0..STEPS as i32 {
                let by = 0.5_f64.powi(half);
                let next = [inside(surface.u(), u - du * by), inside(surface.v(), v - dv * by)];
                let now = surface.point(next[0], next[1])?.coords - point.coords;
                if now.norm() < from.norm() {
                    nearer = Some((next, now));
                    break;
                }
            }
            if nearer.is_some() {
                break;
            }
        }
        let Some((next, now)) = nearer else { break };
        let done = from.norm() - now.norm() <= 1e-6 * now.norm();
        ([u, v], from) = (next, now);
        if done {
            break;
        }
        surface.derivatives_into(u, v, [1, 1], &mut all)?;
    }
    Ok(from.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_foot_of_a_circle_is_on_the_ray_to_its_middle() {
        let circle = Foot::new(Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap()).unwrap();
        assert!(circle.closed);
        // Beyond the seam as well.
        for (degrees, from) in
            [(3.0, 20.0), (50.0, 70.0), (130.0, 150.0), (275.0, 295.0), (350.0, 10.0), (10.0, 350.0)]
        {
            let (s, c) = f64::to_radians(degrees).sin_cos();
            let (at, way) = circle.of(f64::to_radians(from), &Point::new(2.3 * c, 2.3 * s, 0.4)).unwrap();
            let found = circle.curve.point(at).unwrap();
            assert!((found - Point::new(2.0 * c, 2.0 * s, 0.0)).norm() < 1e-7, "{degrees}: {found}");
            assert!((way.norm() - 0.5).abs() < 1e-9, "{degrees}: {way}");
        }
    }

    #[test]
    fn a_point_above_a_sheet_is_as_far_as_it_is_high_and_beyond_its_border_as_that() {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let at = |k: usize| Point::new(0.3 * ((k / 6) * (k / 6)) as f64, (k % 6) as f64, 0.0);
        let sheet = Surface::new(space.clone(), space, (0..36).map(at).collect()).unwrap();
        let (a, b) = sheet.u().domain();
        for (x, y, z, far) in [
            (2.0, 3.0, 0.5, 0.5),
            (6.0, 1.0, 0.0, 0.0),
            (8.5, 2.0, 0.0, 1.0),
            (-3.0, 9.0, 12.0, 13.0_f64.hypot(0.0)),
        ] {
            let found = descend(&sheet, [0.5 * (a + b), 0.4 * (a + b)], &Point::new(x, y, z)).unwrap();
            assert!((found - far).abs() < 1e-4, "{x} {y} {z}: {found}");
        }
    }
}
