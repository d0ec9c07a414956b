//! Circles in a plane across the mirror: the nearest symmetric shape is the same circle about the foot of its centre.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::{Mirror, Symmetric, long, mirrored, settled};

/// What is round, across the mirror or symmetric to this part of its size is so.
const EXACT: f64 = 1e-12;
/// A circle's normal that is nearer to the mirror than this, as an angle, is in it.
const ACROSS: f64 = 1e-9;

/// So many knots are tried as starts.
const STARTS: usize = 16;

/// A circle that is run through once, moved along the mirror's normal and turned in its plane so that it begins in the mirror: with its own knots and
/// weights, where these are symmetric from any knot on, else with those of [`Curve::circle`]. Nothing where the curve is no such circle.
pub(super) fn moved(curve: &Curve, mirror: &Mirror) -> Result<Option<Symmetric<Curve>>> {
    let Some(circle) = Circle::of(curve)? else { return Ok(None) };
    if circle.normal.dot(&mirror.normal).abs() > ACROSS {
        return Ok(None);
    }
    let breaks = curve.space().breakpoints();
    for &start in breaks.iter().take(breaks.len().min(STARTS + 1) - 1) {
        let begun = curve.started_at(start)?;
        let arm = begun.point(begun.domain().0)? - circle.center;
        if let Some(found) = turned(&begun, &Circle { start: arm, ..circle }, mirror)? {
            return Ok(Some(found));
        }
    }
    let usual = Curve::circle(circle.center, circle.normal, circle.radius)?;
    let usual = usual.elevate(curve.degree().saturating_sub(2))?;
    let (a, b) = curve.domain();
    let mut usual = usual.reparametrise(a, b)?;
    if curve.is_periodic() {
        usual = usual.to_periodic(1e-14 * circle.radius)?.shape;
    }
    let start = usual.point(a)? - circle.center;
    turned(&usual, &Circle { start, ..circle }, mirror)
}

/// The circle moved and turned, if it is symmetric then.
fn turned(curve: &Curve, circle: &Circle, mirror: &Mirror) -> Result<Option<Symmetric<Curve>>> {
    // The place in the mirror's plane to which its start is nearest, and the turn that takes it there.
    let ahead = mirror.normal.cross(&circle.normal).normalize();
    let arm = circle.start / circle.radius;
    let ahead = if ahead.dot(&arm) < 0.0 { -ahead } else { ahead };
    let (sine, cosine) = (arm.cross(&ahead).dot(&circle.normal), arm.dot(&ahead));
    let reach = sine.hypot(cosine);
    let (sine, cosine) = (sine / reach, cosine / reach);
    let height = mirror.height(&circle.center);
    let center = circle.center - mirror.normal * height;
    let turned = |p: &Point| {
        let v = p - circle.center;
        center + v * cosine + circle.normal.cross(&v) * sine
    };
    let (space, points, weights) = curve.clone().into_parts();
    let periodic = space.is_periodic();
    let shape = Curve::build(space, points.iter().map(turned).collect(), weights)?;
    let open = shape.to_clamped()?;
    let image = mirrored(&open, mirror)?;
    // As it is only where knots and weights are symmetric, too.
    let knots = open.space().flat().iter().zip(image.space().flat());
    let size = circle.radius + center.coords.amax();
    let near = |x: f64, y: f64, size: f64| (x - y).abs() <= EXACT * size;
    let weight = |curve: &Curve, k: usize| curve.weights().map_or(1.0, |w| w[k]);
    let largest = (0..open.points().len()).map(|k| weight(&open, k)).fold(0.0, f64::max);
    let mut is_symmetric = knots.into_iter().all(|(x, y)| near(*x, *y, open.space().length()));
    for (k, (p, q)) in open.points().iter().zip(image.points()).enumerate() {
        is_symmetric &= long(&(p - q)) <= EXACT * size && near(weight(&open, k), weight(&image, k), largest);
    }
    if !is_symmetric {
        return Ok(None);
    }
    let shape = settled(&open, mirror, periodic)?;
    Ok(Some(Symmetric { shape, moved: Some(height.abs()), corners: Vec::new() }))
}

/// A circle.
#[derive(Clone, Copy)]
struct Circle {
    center: Point,
    /// About which it runs counterclockwise.
    normal: Vector,
    radius: f64,
    /// From the centre to where it starts.
    start: Vector,
}

impl Circle {
    /// The circle that a closed curve is, once round. A rational piece of degree `p` is one if `2p + 1` of its places are on it.
    fn of(curve: &Curve) -> Result<Option<Self>> {
        let (Some(_), (a, b)) = (curve.weights(), curve.domain()) else { return Ok(None) };
        let at = |x: f64| curve.point(a + (b - a) * x);
        let (first, p, q) = (at(0.0)?, at(1.0 / 3.0)?, at(2.0 / 3.0)?);
        let size = long(&(p - first)).max(long(&(q - first)));
        if !(size > 0.0 && size.is_finite()) {
            return Ok(None);
        }
        // At the size 1, at which squares are numbers.
        let (p, q) = ((p - first) / size, (q - first) / size);
        let normal = p.cross(&q);
        let square = normal.norm_squared();
        if square <= EXACT {
            return Ok(None);
        }
        let arm =
            (q.cross(&normal) * p.norm_squared() - p.cross(&normal) * q.norm_squared()) / (2.0 * square);
        let (center, radius, normal) = (first + arm * size, arm.norm(), normal.normalize());
        let allowed = EXACT * (radius + center.coords.amax() / size);
        let mut turn = 0.0;
        let mut last = -arm;
        let places = 2 * curve.degree() + 2;
        for span in curve.space().breakpoints().windows(2) {
            for k in 1..=places {
                let x = k as f64 / places as f64;
                let place = (curve.point((span[0] * (1.0 - x) + span[1] * x).min(b))? - center) / size;
                if (place.norm() - radius).abs() > allowed || place.dot(&normal).abs() > allowed {
                    return Ok(None);
                }
                turn += last.cross(&place).dot(&normal).atan2(last.dot(&place));
                last = place;
            }
        }
        // Through three places in their order it runs counterclockwise.
        let once = (turn - std::f64::consts::TAU).abs() < 1e-6;
        Ok(once.then(|| Self { center, normal, radius: radius * size, start: -arm }))
    }
}
