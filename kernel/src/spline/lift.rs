//! Curves on surfaces: the image in space of a curve in the parameter plane.

use super::trimmed::ParameterCurve;
use super::{Curve, Direction, Space, Surface};
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// As often at most a piece is halved.
const DEEPEST: usize = 12;
/// Where on a piece it is looked how far it is off.
const LOOKS: [f64; 7] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
/// A patch of degree 1 whose fourth corner is off the parallelogram of the others by less than this part of its size is affine.
const FLAT: f64 = 8.0 * f64::EPSILON;

/// A curve on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Lifted {
    /// The curve in space, over the part's own parameters wherever these are not those of an isocurve.
    pub curve: Curve,
    /// How far it is at most from the surface's points at the same parameters, measured at seven places of each of its pieces; `None` where it
    /// is the image exactly.
    pub deviation: Option<f64>,
}

impl ParameterCurve {
    /// Its image `S(u(t), v(t))` on a surface as a curve in space: exactly along an isocurve (a line at constant `u` or `v`) and where the
    /// surface is one affine patch (`S = P + u A + v B`, so that control vertices are mapped), else by cubic pieces that keep point and tangent
    /// `S_u u' + S_v v'` at their ends (Hermite), halved until they are within `tolerance` of the image, 12 times at most: where the surface
    /// has creases [`Lifted::deviation`] may be larger. `O(pieces)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::{Curve, Surface, trimmed::ParameterCurve}};
    /// let line = Curve::line(Point::new(1.0, 0.0, 0.0), Point::new(1.0, 0.0, 2.0))?;
    /// let cylinder = Surface::revolution(&line, Point::origin(), Vector::z(), 1.5)?;
    /// let level = Curve::line(Point::new(0.2, 0.5, 0.0), Point::new(0.8, 0.5, 0.0))?;
    /// let lifted = ParameterCurve::whole(level)?.on(&cylinder, 1e-9)?;
    /// assert_eq!(lifted.deviation, None);
    /// assert!((lifted.curve.point(0.2)? - cylinder.point(0.2, 0.5)?).norm() < 1e-15);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When it runs outside the domain of a surface that is not periodic there by more than a clamp puts right, or its points overflow.
    pub fn on(&self, surface: &Surface, tolerance: f64) -> Result<Lifted> {
        let (from, to) = self.range();
        let whole = (from, to) == self.curve().domain();
        let part = if whole { self.curve().clone() } else { self.curve().between(from, to)? };
        let flat = part.clamped()?;
        let exact = match isoline(surface, &flat)? {
            None => affine(surface, &flat)?,
            found => found,
        };
        if let Some(curve) = exact {
            return Ok(Lifted { curve, deviation: None });
        }
        pieces(surface, &flat, tolerance)
    }
}

/// The part of an isocurve that a straight line at constant `u` or `v` is.
fn isoline(surface: &Surface, flat: &Curve) -> Result<Option<Curve>> {
    let [first, last] = flat.points() else { return Ok(None) };
    if flat.degree() != 1 || flat.weights().is_some() {
        return Ok(None);
    }
    for (direction, at, ends) in [
        (Direction::U, [first.x, last.x], [first.y, last.y]),
        (Direction::V, [first.y, last.y], [first.x, last.x]),
    ] {
        if at[0] != at[1] || ends[0] == ends[1] {
            continue;
        }
        let along = surface.space(direction.other()).domain();
        let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let (across, inner) = (surface.space(direction).domain(), low >= along.0 && high <= along.1);
        if inner && (across.0..=across.1).contains(&at[0]) {
            let curve = surface.isocurve(direction, at[0])?;
            let part = if (low, high) == along { curve } else { curve.between(low, high)? };
            return if ends[0] < ends[1] { Ok(Some(part)) } else { part.reverse().map(Some) };
        }
    }
    Ok(None)
}

/// The image on a surface that is one affine patch: its control vertices are mapped, with their weights.
fn affine(surface: &Surface, flat: &Curve) -> Result<Option<Curve>> {
    let [a, b, c, d] = surface.points() else { return Ok(None) };
    let (u, v) = (surface.u(), surface.v());
    let clamped = |space: &Space| space.degree() == 1 && space.len() == 2 && !space.is_periodic();
    if !(clamped(u) && clamped(v)) || surface.weights().is_some() {
        return Ok(None);
    }
    // Rows are along v: a, b at the start of u.
    let size = [a, b, c, d].iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let twist = (a - b) - (c - d);
    if twist.amax() > FLAT * size || flat.points().iter().any(|p| !(p.x.is_finite() && p.y.is_finite())) {
        return Ok(None);
    }
    // By the ends of the patch: a corner of it is met to the last bit.
    let share = |space: &Space, x: f64| {
        let (start, end) = space.domain();
        (x - start) / (end - start)
    };
    let points: Vec<Point> = flat
        .points()
        .iter()
        .map(|p| {
            let (s, t) = (share(u, p.x), share(v, p.y));
            let mixed =
                (a.coords * (1.0 - t) + b.coords * t) * (1.0 - s) + (c.coords * (1.0 - t) + d.coords * t) * s;
            Point::from(mixed)
        })
        .collect();
    match flat.weights() {
        None => Curve::new(flat.space().clone(), points).map(Some),
        Some(weights) => Curve::rational(flat.space().clone(), points, weights.to_vec()).map(Some),
    }
}

/// By cubic pieces.
fn pieces(surface: &Surface, flat: &Curve, tolerance: f64) -> Result<Lifted> {
    let mut lift = Lift { surface, tolerance, knots: Vec::new(), net: Vec::new(), deviation: 0.0 };
    // Span by span: where it turns a corner, each side has a tangent of its own.
    for span in flat.bezier_segments()? {
        let (from, to) = span.domain();
        lift.piece(&span, from, to, 0)?;
    }
    let (start, end) = flat.domain();
    let mut knots = vec![start];
    knots.extend(lift.knots.iter().flat_map(|t| [*t; 3]));
    knots.extend([end; 4]);
    Ok(Lifted { curve: Curve::new(Space::open(3, knots)?, lift.net)?, deviation: Some(lift.deviation) })
}

/// Pieces of a curve on a surface.
struct Lift<'a> {
    surface: &'a Surface,
    tolerance: f64,
    /// Where the pieces start.
    knots: Vec<f64>,
    net: Vec<Point>,
    deviation: f64,
}

impl Lift<'_> {
    /// Point and derivative at a parameter.
    fn at(&self, flat: &Curve, t: f64) -> Result<(Point, Vector)> {
        let (p, d) = (flat.point(t)?, flat.derivative(t, 1)?);
        // What is periodic goes round.
        let clamp = |space: &Space, x: f64| {
            if space.is_periodic() { x } else { x.clamp(space.domain().0, space.domain().1) }
        };
        let (u, v) = (clamp(self.surface.u(), p.x), clamp(self.surface.v(), p.y));
        let along = self.surface.derivative(u, v, 1, 0)? * d.x + self.surface.derivative(u, v, 0, 1)? * d.y;
        Ok((self.surface.point(u, v)?, along))
    }

    fn piece(&mut self, flat: &Curve, from: f64, to: f64, depth: usize) -> Result<()> {
        let h = to - from;
        let ((a, da), (b, db)) = (self.at(flat, from)?, self.at(flat, to)?);
        let piece = [a, a + da * (h / 3.0), b - db * (h / 3.0), b];
        let mut off = 0.0_f64;
        for s in LOOKS {
            let r = 1.0 - s;
            let by = [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s];
            let on: Vector = piece.iter().zip(by).map(|(p, w)| p.coords * w).sum();
            // Without squares, which may overflow; what is no number stays that.
            let away = on - self.at(flat, from + s * h)?.0.coords;
            let away = away.x.hypot(away.y).hypot(away.z);
            off = if away <= off { off } else { away };
        }
        if !off.is_finite() {
            return Err(Error::Invalid(
                "a curve on a trimmed surface overflows; scale the surface down".into(),
            ));
        }
        let middle = 0.5 * (from + to);
        if off > self.tolerance && depth < DEEPEST && from < middle && middle < to {
            self.piece(flat, from, middle, depth + 1)?;
            return self.piece(flat, middle, to, depth + 1);
        }
        self.deviation = self.deviation.max(off);
        self.knots.push(from);
        self.net.pop();
        self.net.extend(piece);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(corners: [[f64; 3]; 4]) -> Surface {
        let s = Space::clamped(1, &[0.0, 2.0]).unwrap();
        Surface::new(s.clone(), s, corners.map(Point::from).to_vec()).unwrap()
    }

    fn circle() -> ParameterCurve {
        let circle = Curve::circle(Point::new(1.0, 1.0, 0.0), Vector::z(), 0.5);
        ParameterCurve::whole(circle.unwrap()).unwrap()
    }

    fn off(lifted: &Curve, surface: &Surface, flat: &Curve) -> f64 {
        let (a, b) = flat.domain();
        let at = |k: u32| if k == 500 { b } else { a + (b - a) * f64::from(k) / 500.0 };
        let one = |k: u32| {
            let p = flat.point(at(k)).unwrap();
            (lifted.point(at(k)).unwrap() - surface.point(p.x, p.y).unwrap()).norm()
        };
        (0..=500).map(one).fold(0.0, f64::max)
    }

    #[test]
    fn a_circle_on_a_parallelogram_is_an_ellipse_exactly() {
        for size in [1e-9, 1.0, 1e9] {
            let corners = [[1.0, 2.0, 3.0], [2.0, 5.0, 3.5], [4.0, 1.0, 7.0], [5.0, 4.0, 7.5]];
            let surface = patch(corners.map(|p| p.map(|x| x * size)));
            let lifted = circle().on(&surface, 1e-3 * size).unwrap();
            assert_eq!(lifted.deviation, None);
            assert!(lifted.curve.weights().is_some());
            assert!(off(&lifted.curve, &surface, circle().curve()) < 1e-14 * size);
        }
    }

    #[test]
    fn what_is_not_exact_is_within_its_tolerance_and_says_how_far_it_is_off() {
        for size in [1e-9, 1.0, 1e9] {
            let corners = [[0.0, 0.0, 0.0], [0.0, 2.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 0.0]];
            let surface = patch(corners.map(|p| p.map(|x| x * size)));
            let mut before = f64::INFINITY;
            for tolerance in [1e-2, 1e-5, 1e-8] {
                let lifted = circle().on(&surface, tolerance * size).unwrap();
                let told = lifted.deviation.unwrap();
                let found = off(&lifted.curve, &surface, circle().curve());
                assert!(told <= tolerance * size && found <= 1.05 * told, "{tolerance}: {told} {found}");
                assert!(found < before);
                before = found;
            }
        }
    }
}
