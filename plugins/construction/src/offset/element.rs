//! What an offset consists of before anything is cut away: moved pieces of the curve, and joins at its corners.

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::tip::{Tip, Tips};
use super::{Corners, Job};

/// What is straight or round to this part of its size is so.
const EXACT: f64 = 1e-12;
/// The furthest that the tip of a sharp corner may be from it, in distances.
const TIP: f64 = 4.0;
/// Halvings of a polynomial piece.
const HALVINGS: usize = 30;

/// A moved piece, or a join.
pub(super) enum Element {
    /// A polynomial piece of the curve, moved.
    Moved { piece: Curve, kind: Kind, index: usize },
    /// An arc about a corner, from the vector `from`, over `[0, width]`.
    Arc { corner: Point, from: Vector, sweep: f64, width: f64, between: [usize; 2] },
    /// A side of a sharp corner, over `[0, width]`: the first or the second of a tip.
    Side { from: Point, to: Point, width: f64, between: [usize; 2], tip: (usize, usize) },
}

/// What a piece is.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Straight,
    /// An arc of a circle about this centre.
    Circle(Point),
    Free,
}

/// A place of an element and its derivative by the parameter.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) point: Point,
    pub(super) derivative: Vector,
}

impl Element {
    pub(super) fn domain(&self) -> (f64, f64) {
        match self {
            Self::Moved { piece, .. } => piece.domain(),
            Self::Arc { width, .. } | Self::Side { width, .. } => (0.0, *width),
        }
    }

    /// Whether it is the side of a tip, which is further away than asked for.
    pub(super) fn is_side(&self) -> bool {
        matches!(self, Self::Side { .. })
    }

    /// The tip of which it is a side, and which side.
    pub(super) fn tip(&self) -> Option<(usize, usize)> {
        if let Self::Side { tip, .. } = self { Some(*tip) } else { None }
    }

    /// A box that it does not leave.
    pub(super) fn bounds(&self, job: &Job<'_>) -> (Point, Point) {
        let reach = Vector::repeat(job.distance.abs());
        match self {
            Self::Moved { piece, .. } => {
                let (low, high) = piece.hull_bounds();
                (low - reach, high + reach)
            }
            Self::Arc { corner, .. } => (corner - reach, corner + reach),
            Self::Side { from, to, .. } => (from.inf(to), from.sup(to)),
        }
    }

    /// Whether it is straight and passed at one speed.
    pub(super) fn is_even(&self) -> bool {
        match self {
            Self::Moved { piece, kind, .. } => {
                matches!(kind, Kind::Straight) && piece.degree() == 1 && piece.weights().is_none()
            }
            Self::Arc { .. } => false,
            Self::Side { .. } => true,
        }
    }

    /// The pieces that it comes from, which it is the distance away from.
    pub(super) fn own(&self) -> [usize; 2] {
        match self {
            Self::Moved { index, .. } => [*index; 2],
            Self::Arc { between, .. } | Self::Side { between, .. } => *between,
        }
    }

    /// How many places at least say whether it is kept.
    pub(super) fn samples(&self, round: u32) -> usize {
        let base = match self {
            Self::Moved { piece, kind: Kind::Free | Kind::Circle(_), .. } => 24 + 4 * piece.degree().min(10),
            Self::Moved { .. } => 16,
            Self::Arc { sweep, .. } => 4 + (sweep.abs() * 10.0) as usize,
            Self::Side { .. } => 8,
        };
        base * 4_usize.pow(round)
    }

    pub(super) fn place(&self, job: &Job<'_>, t: f64) -> Result<Place> {
        match self {
            Self::Moved { piece, .. } => {
                let (foot, speed, tangent, turn) = direction(piece, t)?;
                let normal = job.plane.normal;
                Ok(Place {
                    point: foot + tangent.cross(&normal) * job.distance,
                    derivative: speed + turn.cross(&normal) * job.distance,
                })
            }
            Self::Arc { corner, from, sweep, width, .. } => {
                let (sine, cosine) = (sweep * t / width).sin_cos();
                let side = job.plane.normal.cross(from);
                let (arm, along) = (from * cosine + side * sine, side * cosine - from * sine);
                Ok(Place { point: corner + arm, derivative: along * (sweep / width) })
            }
            Self::Side { from, to, width, .. } => {
                let way = to - from;
                Ok(Place { point: from + way * (t / width), derivative: way / *width })
            }
        }
    }

    /// The direction at a place of it that leads away from the curve.
    pub(super) fn outwards(&self, job: &Job<'_>, t: f64, place: &Place) -> Result<Vector> {
        let away = match self {
            // Where the curve stops, the derivative has no direction.
            Self::Moved { piece, .. } => place.point - piece.point(t)?,
            Self::Arc { corner, .. } => place.point - corner,
            Self::Side { .. } => place.derivative.cross(&job.plane.normal) * job.distance.signum(),
        };
        Ok(away / away.norm())
    }

    /// The part between two parameters as a curve over `[a, b]`: exact where it is straight or round, else cubics within `tolerance`.
    pub(super) fn curve(&self, job: &Job<'_>, a: f64, b: f64, tolerance: f64) -> Result<Curve> {
        match self {
            Self::Moved { piece, kind: Kind::Circle(center), .. } => {
                let part = piece.between(a, b)?;
                let arm = part.point(a)? - center;
                let moved = self.place(job, a)?.point - center;
                let factor = moved.dot(&arm) / arm.norm_squared();
                let (space, points, weights) = part.into_parts();
                let points = points.into_iter().map(|p| center + (p - center) * factor).collect();
                Curve::build(space, points, weights)
            }
            Self::Arc { corner, sweep, width, .. } => {
                let from = self.place(job, a)?.point;
                Curve::arc(from, *corner, job.plane.normal, sweep * (b - a) / width)?.reparametrise(a, b)
            }
            Self::Side { .. } | Self::Moved { kind: Kind::Straight, .. } => {
                let (from, to) = (self.place(job, a)?.point, self.place(job, b)?.point);
                Curve::new(Space::clamped(1, &[a, b])?, vec![from, to])
            }
            Self::Moved { .. } => self.cubics(job, a, b, tolerance),
        }
    }

    /// Cubics with the places and derivatives at their ends.
    fn cubics(&self, job: &Job<'_>, a: f64, b: f64, tolerance: f64) -> Result<Curve> {
        let first = self.place(job, a)?;
        let mut points = vec![first.point];
        let mut knots = vec![a; 4];
        let mut open = vec![(a, first, b, self.place(job, b)?, 0)];
        while let Some((s, start, e, end, depth)) = open.pop() {
            let third = (e - s) / 3.0;
            let inner = [start.point + start.derivative * third, end.point - end.derivative * third];
            let mut off = 0.0_f64;
            for x in [0.1, 0.25, 0.5, 0.75, 0.9] {
                let y: f64 = 1.0 - x;
                let point = start.point.coords * (y * y * y)
                    + inner[0].coords * (3.0 * y * y * x)
                    + inner[1].coords * (3.0 * y * x * x)
                    + end.point.coords * (x * x * x);
                off = off.max((point - self.place(job, s + (e - s) * x)?.point.coords).norm());
            }
            let middle = 0.5 * s + 0.5 * e;
            if off > tolerance {
                if depth >= HALVINGS || !(s < middle && middle < e) {
                    return Err(Error::Invalid(format!(
                        "the curve turns at {} faster than can be followed: give a larger tolerance, or round it there",
                        Figure(middle)
                    )));
                }
                let half = self.place(job, middle)?;
                open.push((middle, half, e, end, depth + 1));
                open.push((s, start, middle, half, depth + 1));
                continue;
            }
            if s > a {
                knots.extend([s, s]);
            }
            points.extend(inner);
            if e == b {
                points.push(end.point);
            }
        }
        knots.extend([b; 4]);
        Curve::new(Space::open(3, knots)?, points)
    }
}

/// A piece's point, derivative, unit tangent, and the tangent's derivative. Where a piece starts or ends with vertices that fall together,
/// its direction is that of the first derivative that is not 0: `C'(h) ∝ ±(C⁽ᵏ⁾ + C⁽ᵏ⁺¹⁾ h/k)`.
pub(super) fn direction(piece: &Curve, t: f64) -> Result<(Point, Vector, Vector, Vector)> {
    let (a, b) = piece.domain();
    let run: f64 = piece.points().windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let orders = (piece.degree() + 1).min(loftsman_kernel::error::MAX_DEGREE);
    let mut d = vec![Vector::zeros(); orders + 1];
    piece.derivatives_into(t, &mut d[..3])?;
    let point = Point::from(d[0]);
    let speed = d[1];
    let length = b - a;
    if speed.norm() * length > 1e-9 * run {
        let (tangent, norm) = (speed.normalize(), speed.norm());
        let turn = (d[2] - tangent * tangent.dot(&d[2])) / norm;
        return Ok((point, speed, tangent, turn));
    }
    if t == a || t == b {
        piece.derivatives_into(t, &mut d)?;
        let mut scale = length;
        for k in 2..orders {
            scale *= length / k as f64;
            let norm = d[k].norm();
            if norm * scale > 1e-9 * run {
                let sign = if t == b && k % 2 == 0 { -1.0 } else { 1.0 };
                let unit = d[k] / norm;
                let next = d[k + 1];
                let turn = (next - unit * unit.dot(&next)) / (k as f64 * norm);
                return Ok((point, speed, unit * sign, turn * sign));
            }
        }
    }
    Err(Error::Invalid(format!("the curve stops at {} and has no side there: split it there", Figure(t))))
}

/// What an offset consists of before anything is cut away.
#[derive(Default)]
pub(super) struct Elements {
    /// In the curve's order.
    pub(super) all: Vec<Element>,
    tips: Vec<Tip>,
    /// How many sharp corners are round.
    pub(super) blunted: usize,
}

/// All elements in the curve's order, and the tips of its corners.
pub(super) fn elements(job: &Job<'_>) -> Result<(Elements, Tips)> {
    let pieces = &job.around.pieces;
    // The mean of 1 / |C'|.
    let run: f64 = pieces.iter().flat_map(|p| p.points().windows(2).map(|w| (w[1] - w[0]).norm())).sum();
    let pace = job.curve.space().length() / run;
    let mut elements = Elements::default();
    for (k, piece) in pieces.iter().enumerate() {
        elements.all.push(Element::Moved { piece: piece.clone(), kind: kind(job, piece)?, index: k });
        let next = if k + 1 < pieces.len() { k + 1 } else { 0 };
        if next > 0 || job.plane.closed {
            join(job, [k, next], pace, &mut elements)?;
        }
    }
    let tips = Tips::new(std::mem::take(&mut elements.tips));
    Ok((elements, tips))
}

fn join(job: &Job<'_>, between: [usize; 2], pace: f64, elements: &mut Elements) -> Result<()> {
    let [piece, next] = between.map(|k| &job.around.pieces[k]);
    let (corner, arriving, before, _) = direction(piece, piece.domain().1)?;
    let (start, leaving, after, _) = direction(next, next.domain().0)?;
    let reach = job.distance.abs();
    if (start - corner).norm() > 1e-11 * job.size || reach * (after - before).norm() <= 1e-3 * job.tolerance {
        return Ok(());
    }
    let normal = job.plane.normal;
    let (sine, cosine) = (before.cross(&after).dot(&normal), before.dot(&after));
    let back = cosine < 0.0 && sine.abs() <= 1e-9;
    if sine * job.distance <= 0.0 && !back || job.options.corners == Corners::Open {
        return Ok(());
    }
    let sweep = if back { std::f64::consts::PI.copysign(job.distance) } else { sine.atan2(cosine) };
    let arms = [before, after].map(|t| t.cross(&normal) * job.distance);
    // A join goes on at the curve's own speed, where that is not 0.
    let paces =
        [arriving, leaving].map(|v| 1.0 / v.norm()).map(|own| if own < 1e9 * pace { own } else { pace });
    // The tip is 1 / cos(turn / 2) distances away.
    let near = (0.5 * (1.0 + cosine)).max(0.0).sqrt();
    if job.options.corners == Corners::Sharp && !back && near * TIP >= 1.0 {
        let tip = corner + (arms[0] + arms[1]) / (1.0 + cosine);
        let ends = [corner + arms[0], tip, corner + arms[1]];
        let index = elements.tips.len();
        for k in 0..2 {
            let (from, to) = (ends[k], ends[k + 1]);
            let width = (to - from).norm() * paces[k];
            elements.all.push(Element::Side { from, to, width, between, tip: (index, k) });
        }
        elements.tips.push(Tip::new(corner, arms, tip, &normal));
        return Ok(());
    }
    elements.blunted += usize::from(job.options.corners == Corners::Sharp);
    let width = reach * sweep.abs() * 0.5 * (paces[0] + paces[1]);
    elements.all.push(Element::Arc { corner, from: arms[0], sweep, width, between });
    Ok(())
}

/// Whether a piece runs straight ahead, or along a circle: a rational piece of degree `p` does that if `2p + 1` of its points do.
fn kind(job: &Job<'_>, piece: &Curve) -> Result<Kind> {
    let points = piece.points();
    let (first, last) = (points[0], points[points.len() - 1]);
    let chord = last - first;
    let length = chord.norm();
    let ahead = points.windows(2).all(|w| (w[1] - w[0]).dot(&chord) >= -EXACT * length * length);
    if ahead && points.iter().all(|p| (p - first).cross(&chord).norm() <= EXACT * length * length) {
        return Ok(Kind::Straight);
    }
    if piece.weights().is_none() {
        return Ok(Kind::Free);
    }
    let (a, b) = piece.domain();
    let at = |x: f64| piece.point(if x >= 1.0 { b } else { a + (b - a) * x });
    let (p, q) = (at(1.0 / 3.0)? - first, at(2.0 / 3.0)? - first);
    let normal = p.cross(&q);
    let square = normal.norm_squared();
    if square <= 1e-12 * p.norm_squared() * q.norm_squared() {
        return Ok(Kind::Free);
    }
    let arm = (q.cross(&normal) * p.norm_squared() - p.cross(&normal) * q.norm_squared()) / (2.0 * square);
    let (center, radius) = (first + arm, arm.norm());
    let places = 2 * piece.degree() + 2;
    for k in 0..=places {
        if ((at(k as f64 / places as f64)? - center).norm() - radius).abs()
            > EXACT * (radius + job.plane.size)
        {
            return Ok(Kind::Free);
        }
    }
    Ok(Kind::Circle(center))
}
