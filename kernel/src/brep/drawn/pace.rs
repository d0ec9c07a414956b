//! How curves that stand for edges run along these.

use std::f64::consts::TAU;

use crate::brep::{CurveForm, Edge, Frame};
use crate::error::Result;
use crate::spline::Curve;
use crate::{Point, Vector};

/// The parameters of the curve that stands for an edge where the edge starts and ends; the second is less where the edge runs against it.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// The parameter where the edge starts.
    pub from: f64,
    /// The parameter where it ends.
    pub to: f64,
    /// The axes and half diameters of what has angles for parameters, or areas as a hyperbola.
    round: Option<(Frame, [f64; 2])>,
    hyperbolic: bool,
}

impl Pace {
    /// That of the curve which stands for an edge, the way it runs or [turned round](can_turn): a circle's is its angle.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn of(edge: &Edge, back: bool) -> Result<Self> {
        let (from, to) = edge.range;
        let points = [edge.curve.point(from)?, edge.curve.point(to)?];
        let around = |frame: &Frame, radii: [f64; 2]| -> Result<Self> {
            let frame = if back { turned(frame) } else { *frame };
            let along = turns_with(&frame, points[0], edge.curve.derivative(from, 1)?);
            Ok(Self::around(frame, radii, points, along, edge.ends[0] == edge.ends[1]))
        };
        Ok(match &edge.form {
            CurveForm::Line if is_length(points) && back => Self::even(1.0, 0.0),
            CurveForm::Line if is_length(points) => Self::even(0.0, 1.0),
            CurveForm::Circle { frame, radius } => around(frame, [*radius; 2])?,
            CurveForm::Ellipse { frame, radii } => around(frame, *radii)?,
            CurveForm::Parabola { frame, focal } => {
                let [a, b] = points.map(|p| (p - frame.origin).dot(&frame.y()) / (2.0 * focal));
                Self::even(a, b)
            }
            CurveForm::Hyperbola { frame, radii } => {
                let [from, to] = points.map(|p| ((p - frame.origin).dot(&frame.y()) / radii[1]).asinh());
                Self { from, to, round: Some((*frame, *radii)), hyperbolic: true }
            }
            _ if back => {
                let (low, high) = if edge.curve.is_periodic() { (from, to) } else { edge.curve.domain() };
                Self::even(low + (high - from), low + (high - to))
            }
            _ => Self::even(from, to),
        })
    }

    /// That of a curve over the edge's own parameters, or over parameters that run along with them.
    fn even(from: f64, to: f64) -> Self {
        Self { from, to, round: None, hyperbolic: false }
    }

    /// That of an arc from a point to another, or all around.
    fn around(frame: Frame, radii: [f64; 2], [start, end]: [Point; 2], along: bool, closes: bool) -> Self {
        let angle = |p: Point| {
            let d = p - frame.origin;
            (d.dot(&frame.y()) / radii[1]).atan2(d.dot(&frame.x) / radii[0])
        };
        let (from, rest) = (angle(start), angle(end));
        let turn = if along { (rest - from).rem_euclid(TAU) } else { (from - rest).rem_euclid(TAU) };
        let turn = if closes || turn <= 1e-9 { TAU } else { turn };
        // The lesser one from 0 to a turn, as angles of a circle are counted.
        let low = if along { from } else { from - turn }.rem_euclid(TAU);
        let low = if low > TAU - 1e-9 { low - TAU } else { low };
        let (from, to) = if along { (low, low + turn) } else { (low + turn, low) };
        Self { from, to, round: Some((frame, radii)), hyperbolic: false }
    }

    /// Whether the edge runs along that curve.
    pub fn along(&self) -> bool {
        self.from < self.to
    }

    /// Whether equal shares of the way are equal shares of the spline's parameters.
    pub fn is_even(&self) -> bool {
        self.round.is_none()
    }

    /// The parameter of that curve at a share of the edge.
    pub fn at(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }

    /// The point of that curve at a share of the way, of which `own` is the spline.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn point(&self, own: &Curve, share: f64) -> Result<Point> {
        let Some((frame, [a, b])) = self.round else {
            let (from, to) = own.domain();
            return own.point(if share >= 1.0 { to } else { from + (to - from) * share });
        };
        let angle = self.at(share);
        let (x, y) = if self.hyperbolic { (angle.cosh(), angle.sinh()) } else { (angle.cos(), angle.sin()) };
        Ok(frame.origin + frame.x * (a * x) + frame.y() * (b * y))
    }
}

/// Whether the curve of an edge can be turned round: the same, the other way.
pub fn can_turn(edge: &Edge) -> bool {
    !matches!(edge.form, CurveForm::Parabola { .. } | CurveForm::Hyperbola { .. })
}

/// The frame of the same circle seen from the other side.
pub fn turned(frame: &Frame) -> Frame {
    Frame { z: -frame.z, ..*frame }
}

/// Whether a line is as long as can be computed with: beyond this the squares of lengths are no numbers.
pub fn is_length(ends: [Point; 2]) -> bool {
    (1e-150..1e150).contains(&nalgebra::distance(&ends[0], &ends[1]))
}

/// Whether a curve through `p` in the direction `d` turns about the frame's axis as that has it.
fn turns_with(frame: &Frame, p: Point, d: Vector) -> bool {
    frame.z.cross(&(p - frame.origin)).dot(&d) >= 0.0
}
