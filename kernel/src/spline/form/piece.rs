//! Curves that are pieces of lines and conics: the form kept beside the spline, and checked against it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Matrix4;

use super::{CurveForm, Frame, Similarity};
use crate::error::{Error, Result};
use crate::spline::Curve;
use crate::{Point, Vector};

/// How far a spline may be from the form that it is of, in parts of the largest coordinate: what a few dozen roundings make, and no more.
const ROUNDING: f64 = 1e-12;
/// By so much more than a full turn an angle may go: files write one with a dozen digits.
const TURN: f64 = 1e-9;

/// A piece of a line or conic: of which, and from where to where on it.
///
/// The parameter of an ellipse or circle is the angle `t` of `origin + r₁ cos t x + r₂ sin t y`, that of a parabola or hyperbola the `t` of its
/// formula ([`CurveForm`]); a line is there from 0 to 1, from its first point to its last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePiece {
    /// The line or conic.
    pub form: CurveForm,
    /// Where the piece starts and where it ends, which is more.
    pub range: [f64; 2],
}

impl CurveForm {
    /// The point at a parameter, as [`CurvePiece`] counts it. `None` of a spline and of a line, of which the form does not say where it is.
    pub fn point(&self, t: f64) -> Option<Point> {
        let at = |frame: &Frame, x: f64, y: f64| frame.origin + frame.x * x + frame.y() * y;
        Some(match self {
            Self::Spline | Self::Line => return None,
            Self::Circle { frame, radius } => at(frame, radius * t.cos(), radius * t.sin()),
            Self::Ellipse { frame, radii } => at(frame, radii[0] * t.cos(), radii[1] * t.sin()),
            Self::Parabola { frame, focal } => at(frame, focal * t * t, 2.0 * focal * t),
            Self::Hyperbola { frame, radii } => at(frame, radii[0] * t.cosh(), radii[1] * t.sinh()),
        })
    }

    fn frame_mut(&mut self) -> Option<&mut Frame> {
        match self {
            Self::Spline | Self::Line => None,
            Self::Circle { frame, .. }
            | Self::Ellipse { frame, .. }
            | Self::Parabola { frame, .. }
            | Self::Hyperbola { frame, .. } => Some(frame),
        }
    }

    fn frame(&self) -> Option<&Frame> {
        match self {
            Self::Spline | Self::Line => None,
            Self::Circle { frame, .. }
            | Self::Ellipse { frame, .. }
            | Self::Parabola { frame, .. }
            | Self::Hyperbola { frame, .. } => Some(frame),
        }
    }

    /// How far a point is from a conic, to first order: from its plane, or `|F| / |∇F|` of its equation `F = 0` there.
    fn off(&self, p: Point) -> f64 {
        let Some(frame) = self.frame() else { return 0.0 };
        let d = p - frame.origin;
        let [x, y] = [d.dot(&frame.x), d.dot(&frame.y())];
        let flat = match *self {
            Self::Spline | Self::Line => 0.0,
            Self::Circle { radius, .. } => (x.hypot(y) - radius).abs(),
            Self::Ellipse { radii: [a, b], .. } => {
                // `F = r - 1` with `r² = (x/a)² + (y/b)²`.
                let r = (x / a).hypot(y / b);
                (r - 1.0).abs() * r / (x / a / a).hypot(y / b / b)
            }
            Self::Parabola { focal, .. } => (y * y - 4.0 * focal * x).abs() / (4.0 * focal).hypot(2.0 * y),
            Self::Hyperbola { radii: [a, b], .. } => {
                let (s, t) = (x / a, y / b);
                // On its own branch.
                if x > 0.0 {
                    ((s - t) * (s + t) - 1.0).abs() / (2.0 * (s / a).hypot(t / b))
                } else {
                    x.abs() + a
                }
            }
        };
        let across = d.dot(&frame.z).abs();
        if flat.is_nan() { f64::INFINITY } else { flat.max(across) }
    }

    /// Where a point on it is; of an ellipse an angle within half a turn.
    fn parameter(&self, p: Point) -> f64 {
        let Some(frame) = self.frame() else { return 0.0 };
        let d = p - frame.origin;
        let [x, y] = [d.dot(&frame.x), d.dot(&frame.y())];
        match *self {
            Self::Spline | Self::Line => 0.0,
            Self::Circle { .. } => y.atan2(x),
            Self::Ellipse { radii: [a, b], .. } => (y / b).atan2(x / a),
            Self::Parabola { focal, .. } => y / (2.0 * focal),
            Self::Hyperbola { radii: [_, b], .. } => (y / b).asinh(),
        }
    }
}

impl CurvePiece {
    /// A line from the first vertex to the last.
    pub const LINE: Self = Self { form: CurveForm::Line, range: [0.0, 1.0] };

    /// Whether it goes all around an ellipse or circle.
    pub fn is_whole(&self) -> bool {
        let round = matches!(self.form, CurveForm::Circle { .. } | CurveForm::Ellipse { .. });
        round && self.range[1] - self.range[0] >= TAU - TURN
    }

    /// What it is in words: `"line"`, `"circle"`, `"arc of a circle"`, `"ellipse"`, `"arc of an ellipse"`, `"piece of a parabola"`,
    /// `"piece of a hyperbola"`, `"spline"`.
    pub fn noun(&self) -> &'static str {
        match (self.form, self.is_whole()) {
            (CurveForm::Spline, _) => "spline",
            (CurveForm::Line, _) => "line",
            (CurveForm::Circle { .. }, true) => "circle",
            (CurveForm::Circle { .. }, false) => "arc of a circle",
            (CurveForm::Ellipse { .. }, true) => "ellipse",
            (CurveForm::Ellipse { .. }, false) => "arc of an ellipse",
            (CurveForm::Parabola { .. }, _) => "piece of a parabola",
            (CurveForm::Hyperbola { .. }, _) => "piece of a hyperbola",
        }
    }

    /// The same piece, an ellipse by its longer half diameter first: some programs know no other.
    #[must_use]
    pub fn upright(self) -> Self {
        match self {
            Self { form: CurveForm::Ellipse { frame, radii: [a, b] }, range } if a < b => {
                let frame = Frame { x: frame.y(), ..frame };
                let form = CurveForm::Ellipse { frame, radii: [b, a] };
                Self { form, range: range.map(|t| t - FRAC_PI_2) }
            }
            other => other,
        }
    }

    /// The same piece the other way: the plane of a conic is seen from behind.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        if let Some(frame) = self.form.frame_mut() {
            frame.z = -frame.z;
            self.range = [-self.range[1], -self.range[0]];
        }
        self
    }

    /// The piece under the map of a curve. `None` where that does not keep the form.
    pub(crate) fn moved(&self, map: &Matrix4<f64>) -> Option<Self> {
        let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector = map.fixed_view::<3, 1>(0, 3).into_owned();
        let mut form = self.form.moved(Similarity::of(&linear, shift).as_ref());
        // `y = z × x` has to go where the map brings it.
        if (linear / linear.amax()).determinant() < 0.0
            && let Some(frame) = form.frame_mut()
        {
            frame.z = -frame.z;
        }
        (form != CurveForm::Spline).then_some(Self { form, ..*self })
    }

    /// That a curve is this piece, to rounding: a clamped one of degree 1 with two vertices, or of degree 2 whose spans all lie on the conic and run
    /// along it, from one end of the range to the other. On a span of degree 2 the equation of a conic is a polynomial of degree 4 over a square, 0
    /// everywhere where it is at five places, and no span turns back: nothing is left to samples. `O(vertices)`.
    ///
    /// # Errors
    /// When it is not, with what is wrong.
    pub fn check(&self, curve: &Curve) -> Result<()> {
        let no = |why: String| Err(Error::Invalid(format!("the curve is no {}: {why}", self.form.name())));
        self.form.check()?;
        let degree = match self.form {
            CurveForm::Spline => return no("a spline has no form to keep".to_owned()),
            CurveForm::Line => 1,
            _ => 2,
        };
        if curve.degree() != degree || !curve.space().is_clamped() {
            return no(format!("it is not clamped and of degree {degree}"));
        }
        let [from, to] = self.range;
        if !(from < to && from.is_finite() && to.is_finite()) {
            return no(format!("it runs from {from} to {to}, and the second must be more"));
        }
        if self.form == CurveForm::Line {
            return match (curve.points().len(), curve.weights()) {
                (2, None) if self.range == [0.0, 1.0] => Ok(()),
                (2, None) => no(format!("a line runs from 0 to 1, not from {from} to {to}")),
                (2, Some(_)) => no("it has weights".to_owned()),
                (count, _) => no(format!("it has {count} vertices, and a line has 2")),
            };
        }
        self.along(curve)
    }

    fn along(&self, curve: &Curve) -> Result<()> {
        let no = |why: String| Err(Error::Invalid(format!("the curve is no {}: {why}", self.form.name())));
        let [from, to] = self.range;
        let round = matches!(self.form, CurveForm::Circle { .. } | CurveForm::Ellipse { .. });
        if round && to - from > TAU + TURN {
            return no(format!("it runs from {from} to {to}, more than all around"));
        }
        let origin = self.form.frame().map_or_else(Point::origin, |frame| frame.origin);
        let reach = curve.points().iter().map(|p| p.coords.amax()).fold(origin.coords.amax(), f64::max);
        let near = ROUNDING * reach;
        let (mut sum, mut before) = (0.0, None);
        let knots = curve.space().knots();
        for span in curve.space().spans() {
            let (start, end) = (knots[span], knots[span + 1]);
            let at = |k: f64| curve.point_on(span, start + (end - start) * k);
            let off =
                [0.0, 0.25, 0.5, 0.75, 1.0].map(|k| self.form.off(at(k))).into_iter().fold(0.0, f64::max);
            if off > near {
                return no(format!("it is {off:e} off"));
            }
            let (first, last) = (at(0.0), at(1.0));
            if before.is_some_and(|before| nalgebra::distance(&before, &first) > near) {
                return no("it has a gap".to_owned());
            }
            let step = self.form.parameter(last) - self.form.parameter(first);
            // A span of positive weights turns by less than half a turn.
            let step = if round { (step + PI).rem_euclid(TAU) - PI } else { step };
            if step <= 0.0 || step.is_nan() {
                return no("it does not run along it".to_owned());
            }
            sum += step;
            before = Some(last);
        }
        // Both ends are where the range says, and so often around as that.
        let ((first, last), half) = (curve.domain(), 0.5 * (to - from));
        for (u, t) in [(first, from), (last, to)] {
            let apart = self.form.point(t).map(|p| Ok::<_, Error>(nalgebra::distance(&p, &curve.point(u)?)));
            let apart = apart.transpose()?.unwrap_or(f64::INFINITY);
            // Angles that are not small are rounded, too.
            let slack = near + f64::EPSILON * t.abs() * curve_speed(&self.form, t);
            if apart > slack || apart.is_nan() {
                return no(format!("its range ends at {t}, {apart:e} from where the curve does"));
            }
        }
        if (sum - (to - from)).abs() < half {
            Ok(())
        } else {
            no("its range is another part of it".to_owned())
        }
    }
}

/// How fast the point of a conic runs.
fn curve_speed(form: &CurveForm, t: f64) -> f64 {
    match *form {
        CurveForm::Spline | CurveForm::Line => 0.0,
        CurveForm::Circle { radius, .. } => radius,
        CurveForm::Ellipse { radii: [a, b], .. } => a.max(b),
        CurveForm::Parabola { focal, .. } => 2.0 * focal * t.hypot(1.0),
        CurveForm::Hyperbola { radii: [a, b], .. } => a.hypot(b) * t.cosh(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::Space;

    fn frame() -> Frame {
        Frame::new(Point::new(3.0, -2.0, 7.0), Vector::new(0.3, -0.5, 0.8), Vector::new(1.0, 0.2, 0.1))
            .unwrap()
    }

    fn arc(radii: [f64; 2], from: f64, sweep: f64, frame: &Frame) -> Curve {
        Curve::elliptic_arc(frame.origin, frame.x * radii[0], frame.y() * radii[1], from, sweep).unwrap()
    }

    /// One of each form, with the curve.
    fn family(scale: f64) -> Vec<(CurvePiece, Curve)> {
        let mut frame = frame();
        frame.origin *= scale;
        let (radius, radii) = (2.0 * scale, [3.0 * scale, 0.5 * scale]);
        let bezier = |[a, b]: [f64; 2], form: CurveForm, weight: f64, middle: Point| {
            let points = vec![form.point(a).unwrap(), middle, form.point(b).unwrap()];
            let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
            (
                CurvePiece { form, range: [a, b] },
                Curve::rational(space, points, vec![1.0, weight, 1.0]).unwrap(),
            )
        };
        let circle = CurveForm::Circle { frame, radius };
        let ellipse = CurveForm::Ellipse { frame, radii };
        let focal = 0.7 * scale;
        let parabola = CurveForm::Parabola { frame, focal };
        let hyperbola = CurveForm::Hyperbola { frame, radii };
        let at = |x: f64, y: f64| frame.origin + frame.x * x + frame.y() * y;
        vec![
            (CurvePiece::LINE, Curve::line(at(0.0, 1.0), at(4.0, scale)).unwrap()),
            (CurvePiece { form: circle, range: [0.4, 4.9] }, arc([radius; 2], 0.4, 4.5, &frame)),
            (CurvePiece { form: circle, range: [0.0, TAU] }, arc([radius; 2], 0.0, TAU, &frame)),
            (CurvePiece { form: circle, range: [-7.0, -7.0 + 0.1] }, arc([radius; 2], -7.0, 0.1, &frame)),
            (CurvePiece { form: ellipse, range: [-2.0, 1.0] }, arc(radii, -2.0, 3.0, &frame)),
            bezier([-1.0, 2.0], parabola, 1.0, at(-2.0 * focal, focal)),
            bezier([-0.5, 1.5], hyperbola, 1.0_f64.cosh(), {
                let (x, y) = (radii[0] * 0.5_f64.cosh(), radii[1] * 0.5_f64.sinh());
                at(x / 1.0_f64.cosh(), y / 1.0_f64.cosh())
            }),
        ]
    }

    #[test]
    fn pieces_are_told_from_what_is_none() {
        for scale in [1.0, 1e-9, 1e9] {
            for (piece, curve) in family(scale) {
                piece.check(&curve).unwrap_or_else(|e| panic!("{piece:?}: {e}"));
                let backwards = curve.reverse().unwrap();
                piece.reversed().check(&backwards).unwrap_or_else(|e| panic!("{piece:?}: {e}"));
                if piece.form == CurveForm::Line {
                    continue;
                }
                assert!(piece.check(&backwards).is_err() && piece.reversed().check(&curve).is_err());
                // Any vertex moved by a millionth, and another part or size.
                for k in 0..curve.points().len() {
                    let (space, mut points, weights) = curve.clone().into_parts();
                    let by = (points[0] - points[1]) * 1e-6;
                    points[k] += by;
                    let bent = Curve::build(space, points, weights).unwrap();
                    assert!(piece.check(&bent).is_err(), "{piece:?} vertex {k}");
                }
                let [from, to] = piece.range;
                for range in
                    [[from, to - 1e-6], [from - 1e-6, to], [from, to + TAU], [to, from], [from, f64::NAN]]
                {
                    assert!(CurvePiece { range, ..piece }.check(&curve).is_err(), "{piece:?} {range:?}");
                }
                assert!(piece.check(&curve.elevate(1).unwrap()).is_err());
            }
        }
    }

    #[test]
    fn pieces_move_with_their_curves() {
        let turn = Matrix4::new_rotation(Vector::new(0.4, 1.0, -2.0));
        let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-1.0, 1.0, 1.0));
        let shift = Matrix4::new_translation(&Vector::new(5.0, -6.0, 1.0));
        let stretch = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0));
        for (piece, curve) in family(1.0) {
            for map in [turn, mirror, shift, shift * mirror * turn * 25.4, turn.try_inverse().unwrap() * 1e-3]
            {
                let mut map = map;
                map[(3, 3)] = 1.0;
                let formed = curve.clone().with_form(piece).unwrap();
                let moved = formed.transformed(&map).unwrap();
                let found = *moved.form().unwrap();
                assert_eq!(found.range, piece.range);
                found.check(&moved).unwrap();
            }
            let stretched = curve.clone().with_form(piece).unwrap().transformed(&stretch).unwrap();
            assert_eq!(stretched.form().is_some(), piece.form == CurveForm::Line);
        }
    }

    #[test]
    fn nothing_stale_is_left() {
        use crate::shape::Shape;
        for (piece, curve) in family(1.0) {
            let formed = curve.clone().with_form(piece).unwrap();
            assert!(formed != curve && formed.clone() == formed);
            let (a, b) = curve.domain();
            let mut touched = formed.clone();
            touched.control_vertices_mut()[0].x += 1.0;
            let parts = [
                formed.between(a, 0.5 * (a + b)).unwrap(),
                formed.elevate(1).unwrap(),
                formed.reverse().unwrap(),
                formed.reparametrise(0.0, 7.0).unwrap(),
                formed.clone().without_form(),
                touched,
            ];
            assert!(parts.iter().all(|part| part.form().is_none()));
            assert_eq!(formed.clamped().unwrap().form(), Some(&piece));
        }
    }
}
