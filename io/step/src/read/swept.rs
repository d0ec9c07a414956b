//! Curves extruded and turned about axes: rectangles of what they sweep, and of parabolas, hyperbolas and lines without ends pieces as large as some points on
//! the surface need.

use std::f64::consts::TAU;

use loftsman_kernel::spline::{Curve, CurvePiece, Direction, Surface, SurfacePiece};
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix4, Rotation3, Unit};

use super::curve::Basis;
use super::entity::{At, Got, Problem};

/// By how much of the extent of the points a piece goes on beyond them.
const MARGIN: f64 = 1.0 / 64.0;
/// So many times the extent of the points the axis may be away to be where a piece ends.
const NEAR_AXIS: f64 = 4.0;
/// What is this part of the size at hand is rounding.
const ROUNDING: f64 = 1e-9;

/// A curve along a vector, `v` the multiple of it.
pub(super) fn extruded(
    curve: &Curve,
    along: Vector,
    [from, to]: [f64; 2],
) -> loftsman_kernel::Result<Surface> {
    let (space, points, weights) = curve.clone().into_parts();
    let start = Curve::build(space, points.iter().map(|p| p + along * from).collect(), weights)?;
    Surface::extrusion(&start, along * (to - from))?.reparametrise(Direction::V, from, to)
}

/// A surface with what it is beside a spline; the spline alone where it is that to fewer digits.
pub(super) fn kept(surface: Surface, piece: Option<SurfacePiece>) -> Surface {
    match piece {
        Some(piece) => surface.clone().with_form(piece).unwrap_or(surface),
        None => surface,
    }
}

/// A curve with ends that is swept by itself, and whether the surface runs as the file counts, along `u` and along `v`.
pub(super) struct Sweep {
    pub(super) profile: Curve,
    pub(super) senses: [bool; 2],
    pub(super) number: u64,
}

impl Sweep {
    /// The profile, the other way where it is to run so.
    fn directed(&self, along: bool) -> Got<Curve> {
        if along {
            return Ok(self.profile.clone());
        }
        let turned = self.profile.reverse().at(self.number)?;
        let piece = self.profile.form().copied().map(CurvePiece::reversed);
        Ok(match piece {
            Some(piece) => turned.clone().with_form(piece).unwrap_or(turned),
            None => turned,
        })
    }

    /// Along a vector, from a multiple of it to another.
    pub(super) fn extruded(&self, along: Vector, [from, to]: [f64; 2]) -> Got<Surface> {
        let [u_sense, v_sense] = self.senses;
        let [first, last] = if v_sense { [from, to] } else { [to, from] };
        let shift = Matrix4::new_translation(&(along * first));
        let start = self.directed(u_sense)?.transformed(&shift).at(self.number)?;
        let surface = Surface::extrusion(&start, along * (last - first))
            .and_then(|surface| surface.reparametrise(Direction::V, from, to))
            .at(self.number)?;
        let piece = SurfacePiece::extruded(&surface, start.form().copied());
        Ok(kept(surface, Some(piece)))
    }

    /// About an axis, from an angle to another.
    pub(super) fn turned(&self, (base, direction): (Point, Vector), [from, to]: [f64; 2]) -> Got<Surface> {
        let [u_sense, v_sense] = self.senses;
        let (first, direction) = if u_sense { (from, direction) } else { (to, -direction) };
        let mut start = self.directed(v_sense)?;
        if first != 0.0 {
            let turn = Rotation3::from_axis_angle(
                &Unit::new_normalize(direction),
                if u_sense { first } else { -first },
            );
            let turn = turn.to_homogeneous();
            let [there, back] = [-base.coords, base.coords].map(|by| Matrix4::new_translation(&by));
            start = start.transformed(&(back * turn * there)).at(self.number)?;
        }
        // A full turn that does not start at 0 is one but for rounding.
        let sweep =
            if (to - from - TAU).abs() <= 8.0 * f64::EPSILON * (from.abs() + TAU) { TAU } else { to - from };
        let surface = Surface::revolution(&start, base, direction, sweep).at(self.number)?;
        let piece = SurfacePiece::turned(&surface, (base, direction), sweep, start.form().copied());
        Ok(kept(surface, piece))
    }
}

/// A curve without ends along a vector, as long as points on the surface need: `u` is the curve's parameter, `v` the multiple of the vector.
///
/// Along the vector each point comes to the plane of the curve, after `v = (p - o)·z / (a·z)` of it, and there it is on the curve.
pub(super) fn open_extrusion(basis: &Basis, along: Vector, points: &[Point], number: u64) -> Got<Surface> {
    let Some(frame) = basis.frame() else {
        return Err(Problem::new(number, "an extrusion of a curve without ends that is in no plane"));
    };
    let rise = frame.z.dot(&along);
    if rise.abs() <= 1e-12 * along.norm() {
        return Err(Problem::new(number, "a curve that is extruded within its own plane is no surface"));
    }
    let (mut u, mut v) = (Ends::default(), Ends::default());
    for p in points {
        let by = (p - frame.origin).dot(&frame.z) / rise;
        v.add(by);
        u.add(basis.parameter(p - along * by).at(number)?);
    }
    let ([a, b], [c, d]) = (u.padded(), v.padded());
    if a >= b || c >= d || !(b - a).is_finite() || !(d - c).is_finite() {
        return Err(Problem::new(number, "no points say how large a piece of the extruded curve is needed"));
    }
    extruded(&basis.piece(a, b, number)?, along, [c, d]).at(number)
}

/// A curve without ends turned about an axis, as long as points on the surface need, and to the axis where it comes to that: `v` is the curve's parameter.
pub(super) fn open_revolution(
    basis: &Basis,
    (base, direction): (Point, Vector),
    points: &[Point],
    number: u64,
) -> Got<Surface> {
    let turned = Turned { basis, base, direction };
    let mut ends = Ends::default();
    for &p in points {
        ends.add(turned.parameter(p).at(number)?.ok_or_else(|| {
            Problem::new(number, "a curve without ends that is turned in a plane across its axis is not read")
        })?);
    }
    let [low, high] = ends.padded();
    let span = ends.high - ends.low;
    // No further than to the axis, beyond which the surface would be there twice; and as far as that where it is near, or a circle alone says nothing of
    // an extent, since loops may bound what is around it.
    let reach = if matches!(basis, Basis::Line { .. }) { MARGIN } else { NEAR_AXIS } * span;
    let is_end = |away: f64| away >= -MARGIN * span && (away <= reach || span <= 1e-6 * away);
    let places = turned.on_axis().at(number)?;
    let before = places.iter().filter(|t| is_end(ends.low - **t)).copied().reduce(f64::max);
    let behind = places.iter().filter(|t| is_end(**t - ends.high)).copied().reduce(f64::min);
    let low = before.unwrap_or(low);
    let high = behind.filter(|t| *t > low).unwrap_or(high);
    if low >= high || !(high - low).is_finite() {
        return Err(Problem::new(number, "no points say how long the turned curve is"));
    }
    Surface::revolution(&basis.piece(low, high, number)?, base, direction, TAU).at(number)
}

/// From where to where numbers reach.
struct Ends {
    low: f64,
    high: f64,
}

impl Default for Ends {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl Ends {
    fn add(&mut self, number: f64) {
        (self.low, self.high) = (self.low.min(number), self.high.max(number));
    }

    fn padded(&self) -> [f64; 2] {
        let by = MARGIN * (self.high - self.low);
        [self.low - by, self.high + by]
    }
}

/// A curve that is turned about an axis.
struct Turned<'b> {
    basis: &'b Basis,
    base: Point,
    direction: Vector,
}

impl Turned<'_> {
    fn across(&self, p: Point) -> Vector {
        let d = p - self.base;
        d - self.direction * d.dot(&self.direction)
    }

    /// Where the curve is as high along the axis as a point, and as far from it; of two such places, as a curve has them that is symmetrical about the axis,
    /// the later one. A straight line across the axis is all in one height: there it is by how far it is from the axis.
    fn parameter(&self, p: Point) -> loftsman_kernel::Result<Option<f64>> {
        let radius = self.across(p).norm();
        let mut places = self.basis.across_plane(self.direction, p);
        if let (true, Basis::Line { origin, vector }) = (places.is_empty(), self.basis) {
            let across = self.across(*origin);
            let (a, b) = (vector.norm_squared(), across.dot(vector));
            let root = (b * b - a * (across.norm_squared() - radius * radius)).max(0.0).sqrt();
            // On the side where the line starts.
            places.push(if b >= 0.0 { (-b + root) / a } else { (-b - root) / a });
        }
        places.sort_by(|a, b| b.total_cmp(a));
        let mut best: Option<(f64, f64)> = None;
        for t in places {
            let found = self.across(self.basis.point(t)?).norm();
            let off = (found - radius).abs();
            if best.is_none_or(|(known, _)| off < known - ROUNDING * (radius + found)) {
                best = Some((off, t));
            }
        }
        Ok(best.map(|(_, t)| t))
    }

    /// Where the curve comes to the axis.
    fn on_axis(&self) -> loftsman_kernel::Result<Vec<f64>> {
        let normal = match self.basis {
            Basis::Line { origin, vector } => vector.cross(&(self.base - origin)),
            basis => basis.frame().map_or_else(Vector::zeros, |frame| frame.z),
        };
        let toward = match self.basis {
            // Of a line through the axis's own point any direction across both will do.
            Basis::Line { vector, .. } if normal.norm() <= ROUNDING * vector.norm() => {
                self.across(self.base + vector)
            }
            _ => self.direction.cross(&normal),
        };
        let mut found = Vec::new();
        for t in self.basis.across_plane(toward, self.base) {
            let p = self.basis.point(t)?;
            let size = (p - self.base).norm() + self.basis.size();
            if self.across(p).norm() <= ROUNDING * size {
                found.push(t);
            }
        }
        Ok(found)
    }
}

impl Basis {
    /// Where the curve goes through the plane of points that are as far along a direction as `p`; nowhere where it goes along that plane.
    fn across_plane(&self, direction: Vector, p: Point) -> Vec<f64> {
        match self {
            Self::Line { origin, vector } => {
                let slope = vector.dot(&direction);
                let level = slope.abs() <= ROUNDING * vector.norm() * direction.norm();
                if level { Vec::new() } else { vec![(p - origin).dot(&direction) / slope] }
            }
            Self::Parabola { frame, focal } => roots(
                focal * frame.x.dot(&direction),
                2.0 * focal * frame.y().dot(&direction),
                (frame.origin - p).dot(&direction),
                focal * direction.norm(),
            ),
            // With `w = exp t` the cosine and sine are `(w ± 1/w) / 2`.
            Self::Hyperbola { frame, radii } => {
                let (a, b) = (radii[0] * frame.x.dot(&direction), radii[1] * frame.y().dot(&direction));
                let c = (frame.origin - p).dot(&direction);
                let size = radii[0].max(radii[1]) * direction.norm();
                let found = roots(0.5 * (a + b), c, 0.5 * (a - b), size);
                found.into_iter().filter(|w| *w > 0.0).map(f64::ln).collect()
            }
            _ => Vec::new(),
        }
    }

    /// About how large it is where it is most bent.
    fn size(&self) -> f64 {
        match self {
            Self::Parabola { focal, .. } => *focal,
            Self::Hyperbola { radii, .. } => radii[0].max(radii[1]),
            Self::Line { vector, .. } => vector.norm(),
            _ => 0.0,
        }
    }
}

/// The real roots of `a t² + b t + c`, of which those that rounding alone keeps apart, or from being real, are one. None where neither `a` nor `b` is more than
/// rounding of `size`.
fn roots(a: f64, b: f64, c: f64, size: f64) -> Vec<f64> {
    let least = 1e-12 * size;
    if a.abs() <= least {
        return if b.abs() <= least { Vec::new() } else { vec![-c / b] };
    }
    let square = b * b - 4.0 * a * c;
    if square.abs() <= ROUNDING * ROUNDING * (b * b + (4.0 * a * c).abs()) {
        return vec![-0.5 * b / a];
    }
    if square < 0.0 {
        // A point that is off its surface by rounding may be just beyond the vertex of the curve.
        let almost = square >= -ROUNDING * (b * b + (4.0 * a * c).abs());
        return if almost { vec![-0.5 * b / a] } else { Vec::new() };
    }
    let half = -0.5 * (b + square.sqrt().copysign(b));
    vec![half / a, c / half]
}
