//! Curves: what the file says that they are, and their pieces as exact splines.

use std::f64::consts::TAU;

use loftsman_kernel::brep::{CurveForm, Frame};
use loftsman_kernel::spline::{Curve, CurvePiece, Space as Knots};
use loftsman_kernel::{Point, Vector};

use super::entity::{Args, At, Got, Problem, deeper, real};
use super::place::Space;
use super::spline::{CURVES, is_one};
use crate::part21::{Entity, Value};

/// A curve as the file has it, perhaps without ends.
#[derive(Debug, Clone)]
pub(crate) enum Basis {
    /// `origin + t vector`.
    Line { origin: Point, vector: Vector },
    /// `origin + r₁ cos t x + r₂ sin t y`.
    Ellipse { frame: Frame, radii: [f64; 2], circle: bool },
    /// `origin + f t² x + 2 f t y`.
    Parabola { frame: Frame, focal: f64 },
    /// `origin + r₁ cosh t x + r₂ sinh t y`.
    Hyperbola { frame: Frame, radii: [f64; 2] },
    /// In its own space.
    Spline(Curve),
}

impl Space<'_, '_> {
    /// A curve, and whether it is meant in its own direction: parts of curves are looked through, since edges say where they end.
    pub(crate) fn basis(&self, number: u64, depth: usize) -> Got<(Basis, bool)> {
        let depth = deeper(number, depth)?;
        let entity = self.entity(number)?;
        if is_one(&entity, &CURVES) {
            return Ok((Basis::Spline(self.spline_curve(&entity)?), true));
        }
        let args = entity.args();
        let along = |basis| Ok((basis, true));
        let radius = |index: usize| {
            let radius = self.length(args.real(index)?);
            if radius > 0.0 && radius.is_finite() {
                return Ok(radius);
            }
            Err(Problem::new(number, format!("the radius {radius}: it must be positive")))
        };
        match entity.only() {
            b"LINE" => along(Basis::Line {
                origin: self.point(args.reference(1)?)?,
                vector: self.vector(args.reference(2)?)?,
            }),
            b"CIRCLE" => {
                let (frame, radius) = (self.frame(args.reference(1)?)?, radius(2)?);
                along(Basis::Ellipse { frame, radii: [radius; 2], circle: true })
            }
            b"ELLIPSE" => {
                let (frame, radii) = (self.frame(args.reference(1)?)?, [radius(2)?, radius(3)?]);
                along(Basis::Ellipse { frame, radii, circle: false })
            }
            b"PARABOLA" => {
                along(Basis::Parabola { frame: self.frame(args.reference(1)?)?, focal: radius(2)? })
            }
            b"HYPERBOLA" => {
                let (frame, radii) = (self.frame(args.reference(1)?)?, [radius(2)?, radius(3)?]);
                along(Basis::Hyperbola { frame, radii })
            }
            b"POLYLINE" => along(Basis::Spline(self.polyline(&entity)?)),
            b"TRIMMED_CURVE" => {
                let (basis, along) = self.basis(args.reference(1)?, depth)?;
                Ok((basis, along == args.flag(4)?))
            }
            b"SURFACE_CURVE" | b"SEAM_CURVE" | b"INTERSECTION_CURVE" => self.basis(args.reference(1)?, depth),
            b"COMPOSITE_CURVE" => along(Basis::Spline(self.composite(&entity, depth)?)),
            _ => Err(Problem::new(number, format!("{} is no curve that is read", entity.kinds()))),
        }
    }

    /// The points of a POLYLINE.
    pub(crate) fn polyline_points(&self, entity: &Entity<'_>) -> Got<Vec<Point>> {
        self.points(&entity.of("POLYLINE")?.references(1)?)
    }

    fn polyline(&self, entity: &Entity<'_>) -> Got<Curve> {
        let points = self.polyline_points(entity)?;
        let knots: Vec<f64> = (0..points.len()).map(|k| k as f64).collect();
        Knots::clamped(1, &knots).and_then(|space| Curve::new(space, points)).at(entity.number)
    }

    /// A curve with ends, as a spline that keeps what it is.
    pub(crate) fn bounded(&self, number: u64, depth: usize) -> Got<Curve> {
        let depth = deeper(number, depth)?;
        let entity = self.entity(number)?;
        let args = entity.args();
        match entity.only() {
            b"TRIMMED_CURVE" => self.trimmed(&entity, depth),
            b"SURFACE_CURVE" | b"SEAM_CURVE" | b"INTERSECTION_CURVE" => {
                self.bounded(args.reference(1)?, depth)
            }
            b"COMPOSITE_CURVE" => self.composite(&entity, depth),
            b"EDGE_CURVE" => self.edge_curve(&entity, depth),
            _ => match self.basis(number, depth)?.0 {
                Basis::Spline(curve) => Ok(curve),
                basis @ Basis::Ellipse { .. } => {
                    Ok(basis.formed(basis.piece(0.0, TAU, number)?, [0.0, TAU], true))
                }
                _ => Err(Problem::new(number, format!("{} has no ends", entity.kinds()))),
            },
        }
    }

    /// An EDGE_CURVE without faces.
    fn edge_curve(&self, entity: &Entity<'_>, depth: usize) -> Got<Curve> {
        let (number, args) = (entity.number, entity.of("EDGE_CURVE")?);
        let ends = [args.reference(1)?, args.reference(2)?];
        let point = |vertex: u64| self.point(self.entity(vertex)?.of("VERTEX_POINT")?.reference(1)?);
        let points = [point(ends[0])?, point(ends[1])?];
        let (basis, along) = self.basis(args.reference(3)?, depth)?;
        let near = self.units.tolerance.max(1e-6 * (points[1] - points[0]).amax());
        let along = along == args.flag(4)?;
        let closes = ends[0] == ends[1];
        let found = basis.edge(points, closes, along, near, number)?;
        let curve = if found.range == found.curve.domain() && found.curve.space().is_clamped() {
            found.curve
        } else {
            found.curve.between(found.range.0, found.range.1).at(number)?
        };
        let curve = if found.reversed { curve.reverse().at(number)? } else { curve };
        let [a, b] = points.map(|p| basis.parameter(p));
        let (low, high) = if along { (a.at(number)?, b.at(number)?) } else { (b.at(number)?, a.at(number)?) };
        let high = match basis {
            Basis::Ellipse { .. } if closes => low + TAU,
            Basis::Ellipse { .. } => low + turn(high - low),
            _ => high,
        };
        Ok(basis.formed(curve, [low, high], along))
    }

    /// A TRIMMED_CURVE: of both ways to say where it ends the one that the file prefers.
    fn trimmed(&self, entity: &Entity<'_>, depth: usize) -> Got<Curve> {
        let (number, args) = (entity.number, entity.of("TRIMMED_CURVE")?);
        let (basis, same) = self.basis(args.reference(1)?, depth)?;
        let along = args.flag(4)?;
        if !same {
            return Err(Problem::new(number, "a trimmed curve of a trimmed curve that runs backwards"));
        }
        let by_points = matches!(args.values.get(5), Some(Value::Enumeration(b"CARTESIAN")));
        let end = |index: usize| self.trim(&args, index, &basis, by_points);
        let (first, second) = (end(2)?, end(3)?);
        let (low, mut high) = if along { (first, second) } else { (second, first) };
        if let Basis::Ellipse { .. } = basis {
            high = low + turn(high - low);
        }
        let curve = match &basis {
            Basis::Spline(curve) if low >= high && !curve.is_periodic() => {
                closed_part(curve, low, high).at(number)?
            }
            Basis::Line { .. } => {
                let (from, to) = if along { (2, 3) } else { (3, 2) };
                let line = basis.piece(low, high, number)?;
                let ends = [(line.points()[0], from), (line.points()[1], to)];
                let [a, b] = ends.map(|(end, index)| self.named_end(&args, index, end));
                Curve::line(a?, b?).at(number)?
            }
            basis => basis.piece(low, high, number)?,
        };
        let curve = if along { curve } else { curve.reverse().at(number)? };
        Ok(basis.formed(curve, [low, high], along))
    }

    /// The end of a line as the point that the file names there, where that is the same but for rounding.
    fn named_end(&self, args: &Args<'_, '_>, index: usize, end: Point) -> Got<Point> {
        for value in args.list(index)? {
            if let Value::Reference(number) = value {
                let named = self.point(*number)?;
                let near = 16.0 * f64::EPSILON * named.coords.amax();
                return Ok(if (named - end).amax() <= near { named } else { end });
            }
        }
        Ok(end)
    }

    fn trim(&self, args: &Args<'_, '_>, index: usize, basis: &Basis, by_points: bool) -> Got<f64> {
        let values = args.list(index)?;
        let point = values.iter().find_map(|value| match value {
            Value::Reference(number) => Some(*number),
            _ => None,
        });
        let parameter = values.iter().find_map(real);
        match (point, parameter) {
            (Some(point), parameter) if by_points || parameter.is_none() => {
                let found = basis.parameter(self.point(point)?).at(args.number)?;
                let angle = if let Basis::Ellipse { .. } = basis { self.units.angle } else { 1.0 };
                // The parameter that stands beside the point where both are the same but for rounding.
                let near = |named: &f64| (named - found).abs() <= SAME * (1.0 + found.abs());
                Ok(parameter.map(|named| named * angle).filter(near).unwrap_or(found))
            }
            (_, Some(parameter)) => Ok(match basis {
                Basis::Ellipse { .. } => parameter * self.units.angle,
                _ => parameter,
            }),
            _ => Err(Problem::new(
                args.number,
                "it does not say where it ends: neither by a point nor by a number",
            )),
        }
    }

    /// A COMPOSITE_CURVE, joined.
    fn composite(&self, entity: &Entity<'_>, depth: usize) -> Got<Curve> {
        let number = entity.number;
        let mut parts: Vec<Curve> = Vec::new();
        for segment in entity.of("COMPOSITE_CURVE")?.references(1)? {
            let segment = self.entity(segment)?;
            let args = segment.of("COMPOSITE_CURVE_SEGMENT")?;
            let curve = self.bounded(args.reference(2)?, depth)?;
            parts.push(if args.flag(1)? { curve } else { curve.reverse().at(number)? });
        }
        let mut parts = parts.into_iter();
        let mut all =
            parts.next().ok_or_else(|| Problem::new(number, "a composite curve without segments"))?;
        for part in parts {
            let size = all.points().iter().chain(part.points()).map(|p| (p - all.points()[0]).amax());
            let gap = (1e-6 * size.fold(0.0, f64::max)).max(self.units.tolerance);
            all = all.join(&part, gap).at(number)?.shape;
        }
        Ok(all)
    }
}

/// Parameters no further apart, as parts of them and of 1, are one.
const SAME: f64 = 1e-13;
/// A full turn is written with so much rounding: `6.28318530718` is 4e-13 more.
const ROUND: f64 = 1e-9;

/// An angle as one more than 0, at most a full turn. What is no more than rounding beyond a full turn is one, and no arc that nobody sees.
fn turn(angle: f64) -> f64 {
    let rest = angle.rem_euclid(TAU);
    let is_round = rest <= ROUND && !(0.0..=ROUND).contains(&angle);
    if rest > 0.0 && !is_round { rest } else { TAU }
}

/// The part of a clamped curve that closes, through its seam.
fn closed_part(curve: &Curve, from: f64, to: f64) -> loftsman_kernel::Result<Curve> {
    let (start, end) = curve.domain();
    let gap = closing_gap(curve)?;
    if from >= end {
        return if to <= start { curve.to_clamped() } else { curve.between(start, to) };
    }
    let first = curve.between(from, end)?;
    if to <= start {
        return Ok(first);
    }
    Ok(first.join(&curve.between(start, to)?, gap * 1.000_001)?.shape)
}

/// How far apart the ends of a curve are.
fn closing_gap(curve: &Curve) -> loftsman_kernel::Result<f64> {
    let (start, end) = curve.domain();
    Ok(nalgebra::distance(&curve.point(start)?, &curve.point(end)?))
}

impl Basis {
    /// The parameter of a point on it.
    pub(crate) fn parameter(&self, p: Point) -> loftsman_kernel::Result<f64> {
        let in_frame = |frame: &Frame| {
            let d = p - frame.origin;
            (d.dot(&frame.x), d.dot(&frame.y()))
        };
        Ok(match self {
            Self::Line { origin, vector } => (p - origin).dot(vector) / vector.norm_squared(),
            Self::Ellipse { frame, radii, .. } => {
                let (x, y) = in_frame(frame);
                (y / radii[1]).atan2(x / radii[0])
            }
            Self::Parabola { frame, focal } => in_frame(frame).1 / (2.0 * focal),
            Self::Hyperbola { frame, radii } => (in_frame(frame).1 / radii[1]).asinh(),
            Self::Spline(curve) => curve.closest(p)?.at,
        })
    }

    /// The plane of a conic.
    pub(crate) fn frame(&self) -> Option<&Frame> {
        match self {
            Self::Ellipse { frame, .. } | Self::Parabola { frame, .. } | Self::Hyperbola { frame, .. } => {
                Some(frame)
            }
            _ => None,
        }
    }

    /// The point at a parameter.
    pub(crate) fn point(&self, t: f64) -> loftsman_kernel::Result<Point> {
        Ok(match self {
            Self::Line { origin, vector } => origin + vector * t,
            Self::Ellipse { frame, radii, .. } => {
                frame.origin + frame.x * (radii[0] * t.cos()) + frame.y() * (radii[1] * t.sin())
            }
            Self::Parabola { frame, focal } => {
                frame.origin + frame.x * (focal * t * t) + frame.y() * (2.0 * focal * t)
            }
            Self::Hyperbola { frame, radii } => {
                frame.origin + frame.x * (radii[0] * t.cosh()) + frame.y() * (radii[1] * t.sinh())
            }
            Self::Spline(curve) => curve.point(t)?,
        })
    }

    /// The piece between two parameters, the first less than the second, as a spline.
    pub(crate) fn piece(&self, from: f64, to: f64, number: u64) -> Got<Curve> {
        if from.partial_cmp(&to) != Some(std::cmp::Ordering::Less) {
            let text = format!("it runs from {from} to {to} on its curve: the second must be more");
            return Err(Problem::new(number, text));
        }
        match self {
            Self::Line { .. } => self.point(from).and_then(|a| Curve::line(a, self.point(to)?)),
            Self::Ellipse { frame, radii, .. } => {
                Curve::elliptic_arc(frame.origin, frame.x * radii[0], frame.y() * radii[1], from, to - from)
            }
            Self::Parabola { frame, focal } => {
                let at =
                    |a: f64, b: f64| frame.origin + frame.x * (focal * a * b) + frame.y() * (focal * (a + b));
                Knots::clamped(2, &[from, to])
                    .and_then(|space| Curve::new(space, vec![at(from, from), at(from, to), at(to, to)]))
            }
            Self::Hyperbola { frame, radii } => hyperbola(frame, radii, from, to),
            Self::Spline(curve) => {
                let whole = (from, to) == curve.domain() && curve.space().is_clamped();
                if whole { Ok(curve.clone()) } else { curve.between(from, to) }
            }
        }
        .at(number)
    }

    /// A part of it, from one parameter to another or the other way, with what it is beside a spline.
    pub(crate) fn formed(&self, curve: Curve, range: [f64; 2], along: bool) -> Curve {
        let piece = match self {
            Self::Spline(_) => return curve,
            Self::Line { .. } => CurvePiece::LINE,
            _ => CurvePiece { form: self.form(true), range },
        };
        // Of what cannot be computed with to rounding (a circle much smaller than its coordinates) the spline is left.
        curve.clone().with_form(if along { piece } else { piece.reversed() }).unwrap_or(curve)
    }

    /// What it is beside a spline, where an edge runs along it or against it.
    pub(crate) fn form(&self, along: bool) -> CurveForm {
        let turned = |frame: &Frame| if along { *frame } else { Frame { z: -frame.z, ..*frame } };
        match self {
            Self::Line { .. } => CurveForm::Line,
            Self::Ellipse { frame, radii, circle: true } => {
                CurveForm::Circle { frame: turned(frame), radius: radii[0] }
            }
            Self::Ellipse { frame, radii, .. } => CurveForm::Ellipse { frame: turned(frame), radii: *radii },
            Self::Parabola { frame, focal } => CurveForm::Parabola { frame: *frame, focal: *focal },
            Self::Hyperbola { frame, radii } => CurveForm::Hyperbola { frame: *frame, radii: *radii },
            Self::Spline(_) => CurveForm::Spline,
        }
    }
}

/// A piece of a hyperbola: rational Bézier curves of degree 2 whose middle weight is `cosh h`, `2h` the range of each.
fn hyperbola(frame: &Frame, radii: &[f64; 2], from: f64, to: f64) -> loftsman_kernel::Result<Curve> {
    // Beyond this cosh overflows; the pieces are short so that weights stay near 1.
    let pieces = (to - from).ceil().clamp(1.0, 1500.0) as usize;
    let half = 0.5 * (to - from) / pieces as f64;
    let at = |t: f64, by: f64| {
        frame.origin + frame.x * (radii[0] * t.cosh() * by) + frame.y() * (radii[1] * t.sinh() * by)
    };
    let (mut points, mut weights, mut knots) = (vec![at(from, 1.0)], vec![1.0], vec![from; 3]);
    for k in 0..pieces {
        let start = from + 2.0 * half * k as f64;
        let end = if k + 1 == pieces { to } else { start + 2.0 * half };
        points.extend([at(start + half, 1.0 / half.cosh()), at(end, 1.0)]);
        weights.extend([half.cosh(), 1.0]);
        knots.extend([end; 2]);
    }
    knots.push(to);
    Curve::rational(Knots::open(2, knots)?, points, weights)
}

/// A curve of an edge: where on it the edge is, whether that runs from the edge's end to its start, and what it is.
pub(crate) struct OnCurve {
    pub(crate) curve: Curve,
    pub(crate) range: (f64, f64),
    pub(crate) reversed: bool,
    pub(crate) form: CurveForm,
}

impl Basis {
    /// The part of it between two points, from the first to the second (all around where they are one), along it or against it.
    /// Lines go from point to point where these are within `near` of it; splines stay as they are.
    pub(crate) fn edge(
        &self,
        [start, end]: [Point; 2],
        closes: bool,
        along: bool,
        near: f64,
        number: u64,
    ) -> Got<OnCurve> {
        match self {
            Self::Line { .. } => {
                let foot = |p: Point| {
                    let foot = self.point(self.parameter(p)?)?;
                    Ok(if nalgebra::distance(&foot, &p) <= near { p } else { foot })
                };
                let curve = foot(start).and_then(|a| Curve::line(a, foot(end)?)).at(number)?;
                let range = curve.domain();
                Ok(OnCurve { curve, range, reversed: false, form: CurveForm::Line })
            }
            Self::Ellipse { frame, radii, .. } => {
                let (a, b) = (self.parameter(start).at(number)?, self.parameter(end).at(number)?);
                let sweep = if closes {
                    TAU
                } else if along {
                    turn(b - a)
                } else {
                    turn(a - b)
                };
                let sign = if along { 1.0 } else { -1.0 };
                let (x, y) = (frame.x * radii[0], frame.y() * radii[1]);
                let curve = Curve::elliptic_arc(frame.origin, x, y, a, sign * sweep).at(number)?;
                let range = curve.domain();
                Ok(OnCurve { curve, range, reversed: false, form: self.form(along) })
            }
            Self::Parabola { .. } | Self::Hyperbola { .. } => {
                let (a, b) = (self.parameter(start).at(number)?, self.parameter(end).at(number)?);
                let (from, to) = if along { (a, b) } else { (b, a) };
                let curve = self.piece(from, to, number)?;
                let range = curve.domain();
                Ok(OnCurve { curve, range, reversed: !along, form: self.form(true) })
            }
            Self::Spline(curve) => {
                let [first, last] = if along { [start, end] } else { [end, start] };
                let (curve, range) = on_spline(curve, [first, last], closes, near).at(number)?;
                Ok(OnCurve { curve, range, reversed: !along, form: CurveForm::Spline })
            }
        }
    }
}

/// The range of a spline from a point to another, along it; the spline itself is another one only where it closes and the range
/// goes through its seam.
fn on_spline(
    curve: &Curve,
    [first, last]: [Point; 2],
    closes: bool,
    near: f64,
) -> loftsman_kernel::Result<(Curve, (f64, f64))> {
    let (start, end) = curve.domain();
    let (head, tail) = (curve.point(start)?, curve.point(end)?);
    let at_head = |p: Point| nalgebra::distance(&p, &head) <= near;
    let at_tail = |p: Point| nalgebra::distance(&p, &tail) <= near;
    // Ends that are meant are taken as they are, whatever lies nearer in between.
    if at_head(first) && at_tail(last) && (closes || !at_tail(first) || !at_head(last)) {
        return Ok((curve.clone(), (start, end)));
    }
    let from = if at_head(first) { start } else { curve.closest(first)?.at };
    let to = if at_tail(last) { end } else { curve.closest(last)?.at };
    let to = if closes { from } else { to };
    if from < to {
        return Ok((curve.clone(), (from, to)));
    }
    // What closes goes on through its seam.
    if nalgebra::distance(&head, &tail) <= near {
        let curve = closed_part(curve, from, to)?;
        let range = curve.domain();
        return Ok((curve, range));
    }
    Err(loftsman_kernel::Error::Invalid(format!(
        "its ends are at {from} and {to} on a curve that does not close: they do not follow one another"
    )))
}
