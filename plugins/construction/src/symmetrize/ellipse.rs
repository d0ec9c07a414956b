//! The mean of an ellipse and its mirror image: an ellipse, for it is that of `c + X cos θ + Y sin θ` and of `c' + X' cos(σ - θ) + Y' sin(σ - θ)`.
//!
//! The `σ` at which these are nearest to one another, all the way round, maximises `cos σ (X·X' - Y·Y') + sin σ (X·Y' + Y·X')`.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix2, Matrix5, Vector2, Vector5};

use super::{Mirror, Symmetric, long, settled};

/// What is an ellipse to this part of its size is one.
const EXACT: f64 = 1e-11;
/// An ellipse that is flatter than this is a line.
const FLAT: f64 = 1e-9;

/// The mean of an ellipse that is run through once and its mirror image, begun in the mirror. Nothing where the curve is none, or the mean is but a line.
pub(super) fn mean(curve: &Curve, mirror: &Mirror) -> Result<Option<Symmetric<Curve>>> {
    let Some(Ellipse { center, arms: [x, y], start }) = Ellipse::of(curve)? else { return Ok(None) };
    let flip = |v: Vector| v - mirror.normal * (2.0 * v.dot(&mirror.normal));
    let size = long(&x).max(long(&y));
    // At the size 1, at which squares are numbers.
    let (x, y, start) = (x / size, y / size, start / size);
    let (p, q) = (flip(x), flip(y));
    let (sine, cosine) = (x.dot(&q) + y.dot(&p), x.dot(&p) - y.dot(&q));
    let turn = sine.atan2(cosine);
    let (sine, cosine) = turn.sin_cos();
    let even = [0.5 * (x + p * cosine + q * sine), 0.5 * (y + p * sine - q * cosine)];
    let off = [x - even[0], y - even[1]];
    // Begun in the mirror, where it goes straight across.
    let (sine, cosine) = (0.5 * turn).sin_cos();
    let ahead = even[0] * cosine + even[1] * sine;
    let across = even[1] * cosine - even[0] * sine;
    let ahead = ahead - mirror.normal * ahead.dot(&mirror.normal);
    let across = mirror.normal * across.dot(&mirror.normal);
    let [ahead, across] = if ahead.dot(&start) < 0.0 { [-ahead, -across] } else { [ahead, across] };
    if ahead.norm().min(across.norm()) < FLAT {
        return Ok(None);
    }
    let unit = Curve::circle(Point::origin(), Vector::z(), 1.0)?;
    let unit = unit.elevate(curve.degree().saturating_sub(2))?;
    let (a, b) = curve.domain();
    let unit = unit.reparametrise(a, b)?;
    let first = unit.point(a)?.coords.normalize();
    let second = Vector::z().cross(&first);
    let height = mirror.height(&center);
    let middle = center - mirror.normal * height;
    let (space, points, weights) = unit.into_parts();
    let moved =
        |p: &Point| middle + ahead * (p.coords.dot(&first) * size) + across * (p.coords.dot(&second) * size);
    let shape = Curve::build(space, points.iter().map(moved).collect(), weights)?;
    let shape = settled(&shape, mirror, curve.is_periodic())?;
    // No place moves further than the centre and the longest of the ellipse of differences.
    let gram =
        Matrix2::new(off[0].dot(&off[0]), off[0].dot(&off[1]), off[1].dot(&off[0]), off[1].dot(&off[1]));
    let longest = gram.symmetric_eigenvalues().max().max(0.0).sqrt() * size;
    Ok(Some(Symmetric { shape, moved: Some(height.abs() + longest), corners: Vec::new() }))
}

/// An ellipse.
struct Ellipse {
    center: Point,
    /// Conjugate half diameters, from the first to the second of which it runs.
    arms: [Vector; 2],
    /// From the centre to where it starts.
    start: Vector,
}

impl Ellipse {
    /// The ellipse that a closed curve is, once round. A rational piece of degree `p` is one if `2p + 1` of its places are on it.
    fn of(curve: &Curve) -> Result<Option<Self>> {
        let (Some(_), (a, b)) = (curve.weights(), curve.domain()) else { return Ok(None) };
        let at = |x: f64| curve.point(a + (b - a) * x);
        // Three places on it make it about round, seen along their differences.
        let (first, p, q) = (at(0.0)?, at(1.0 / 3.0)? - at(0.0)?, at(2.0 / 3.0)? - at(0.0)?);
        let size = long(&p).max(long(&q));
        if !(size > 0.0 && size.is_finite()) {
            return Ok(None);
        }
        let (p, q) = (p / size, q / size);
        let normal = p.cross(&q);
        let square = normal.norm_squared();
        if square.sqrt() <= FLAT {
            return Ok(None);
        }
        let middle = (p + q) / 3.0;
        let flat = |point: Point| {
            let v = (point - first) / size - middle;
            let seen = Vector2::new(v.cross(&q).dot(&normal), p.cross(&v).dot(&normal)) / square;
            (seen, v.dot(&normal) / square.sqrt())
        };
        // `a x² + b x y + c y² + d x + e y = 1` through five places; the origin is within.
        let mut rows = Matrix5::zeros();
        for k in 0..5 {
            let (v, _) = flat(at([0.0, 0.17, 0.39, 0.61, 0.83][k])?);
            rows.set_row(k, &Vector5::new(v.x * v.x, v.x * v.y, v.y * v.y, v.x, v.y).transpose());
        }
        let Some(conic) = rows.full_piv_lu().solve(&Vector5::repeat(1.0)) else { return Ok(None) };
        let form = Matrix2::new(conic[0], 0.5 * conic[1], 0.5 * conic[1], conic[2]);
        let half = Vector2::new(0.5 * conic[3], 0.5 * conic[4]);
        let Some(foot) = form.try_inverse().map(|inverse| -(inverse * half)) else { return Ok(None) };
        let level = 1.0 - half.dot(&foot);
        if !(level > 0.0 && level.is_finite()) {
            return Ok(None);
        }
        // `(v - foot)ᵀ form (v - foot) = level`: with `form / level = L Lᵀ` the ellipse is where `Lᵀ (v - foot)` is of length 1.
        let Some(root) = (form / level).cholesky().map(|c| c.l().transpose()) else { return Ok(None) };
        let Some(back) = root.try_inverse() else { return Ok(None) };
        let allowed = EXACT * (1.0 + first.coords.amax() / size);
        let seen = |u: f64| -> Result<(Vector2<f64>, f64)> {
            let (v, off) = flat(curve.point(u)?);
            Ok((root * (v - foot), off))
        };
        let (mut last, _) = seen(a)?;
        let mut turn = 0.0;
        let places = 2 * curve.degree() + 2;
        for span in curve.space().breakpoints().windows(2) {
            for k in 1..=places {
                let x = k as f64 / places as f64;
                let (place, off) = seen((span[0] * (1.0 - x) + span[1] * x).min(b))?;
                if !((place.norm() - 1.0).abs() <= allowed && off.abs() <= allowed) {
                    return Ok(None);
                }
                turn += (last.x * place.y - last.y * place.x).atan2(last.dot(&place));
                last = place;
            }
        }
        if (turn.abs() - std::f64::consts::TAU).abs() > 1e-6 {
            return Ok(None);
        }
        let out = |v: Vector2<f64>| (p * v.x + q * v.y) * size;
        let center = first + middle * size + out(foot);
        let sense = turn.signum();
        let arms = [out(back * Vector2::x()), out(back * Vector2::y() * sense)];
        Ok(Some(Self { center, arms, start: first - center }))
    }
}
