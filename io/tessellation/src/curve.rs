//! Curves as polylines: Bézier pieces divided until their control polygon says that they are flat.

use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::Fineness;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::{Result, Vector};
use nalgebra::Vector4;

use crate::bezier::extraction;
use crate::bounds;
use crate::fineness::{Frame, Target, over_budget};

/// A piece is divided evenly into at most this many; where more are needed it is halved, and each half decides
/// anew, so that the points follow the bend.
const EVEN: f64 = 8.0;

/// Pieces shorter than this fraction of the curve are not divided to meet the angle: at a cusp or where the
/// parameter stands still no division would.
const CORNER: f64 = 1e-5;

/// The polyline through the points at [`parameters`].
pub(crate) fn polyline(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Polyline> {
    let mut points = Vec::new();
    for u in parameters(curve, fineness, budget)? {
        let point = curve.point(u)?;
        // Spans on which the curve stands still give no segment.
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    let closed = match points.as_slice() {
        [first, .., last] if points.len() > 3 => {
            let resolved = 4.0 * f64::EPSILON * first.coords.amax().max(last.coords.amax());
            curve.is_periodic() || (last - first).amax() <= resolved
        }
        _ => false,
    };
    if closed {
        points.pop();
    }
    Ok(Polyline { points, closed })
}

/// The parameters at which a curve is cut into chords, both ends of the domain included.
pub(crate) fn parameters(curve: &Curve, fineness: &Fineness, budget: usize) -> Result<Vec<f64>> {
    let frame = Frame::of(curve.points())?;
    let space = curve.space();
    let flat = space.flat();
    let mut samples = Vec::new();
    for span in space.spans() {
        let (a, b) = (flat[span], flat[span + 1]);
        for k in 0..=4 {
            samples.push(curve.point((a + (b - a) * f64::from(k) / 4.0).min(b))?);
        }
    }
    let target = frame.target(fineness, samples)?;
    let mut cutter = Cutter { curve, frame, target, rows: Vec::new(), cuts: vec![curve.domain().0] };
    // Explicit stack of stretches still to be looked at, the next one last.
    let mut open: Vec<(usize, f64, f64)> = Vec::new();
    let spans: Vec<usize> = space.spans().collect();
    for span in spans {
        open.push((span, flat[span], flat[span + 1]));
        while let Some((span, a, b)) = open.pop() {
            let pieces = cutter.pieces(span, a, b);
            if cutter.cuts.len() as f64 + pieces > budget as f64 {
                let needed = cutter.cuts.len() as f64 + pieces;
                return Err(over_budget(fineness, needed, "segments", budget));
            }
            let n = if pieces > EVEN { 2 } else { pieces as usize };
            let at = |k: usize| if k == n { b } else { a + (b - a) * (k as f64 / n as f64) };
            // A stretch that doubles cannot divide any further is taken as it is.
            if n <= 1 || (1..=n).any(|k| at(k) <= at(k - 1)) {
                cutter.cuts.push(b);
            } else {
                open.extend((1..=n).rev().map(|k| (span, at(k - 1), at(k))));
            }
        }
    }
    Ok(cutter.cuts)
}

struct Cutter<'a> {
    curve: &'a Curve,
    frame: Frame,
    target: Target,
    rows: Vec<[f64; MAX_ORDER]>,
    cuts: Vec<f64>,
}

impl Cutter<'_> {
    /// How many even pieces a stretch needs: 1 where it is flat enough as it is.
    fn pieces(&mut self, span: usize, a: f64, b: f64) -> f64 {
        let (space, p) = (self.curve.space(), self.curve.degree());
        extraction(space, span, a, b, &mut self.rows);
        let mut net = [Vector4::zeros(); MAX_ORDER];
        for (row, out) in self.rows.iter().zip(&mut net) {
            for (i, &share) in row[..=p].iter().enumerate() {
                let vertex = space.vertex(span - p + i);
                let weight = self.curve.weights().map_or(1.0, |w| w[vertex]) * share;
                let local = (self.curve.points()[vertex] - self.frame.centre) / self.frame.size;
                *out += (local * weight).push(weight);
            }
        }
        let net = &net[..=p];
        let polygon = net.map_points();
        let second =
            if self.curve.weights().is_some() { bounds::rational_second(net) } else { bounds::second(net) };
        let chord = (second / (8.0 * self.target.chord)).sqrt().ceil();
        let flat = chord <= 1.0 || from_segment(&polygon) <= self.target.chord;
        let turns = if flat && self.straight(&polygon) {
            1.0
        } else {
            // All turning of the curve is at most that of its control polygon.
            (turning(&polygon) / self.target.angle).ceil().max(2.0)
        };
        if flat { turns } else { chord.max(2.0).max(turns.min(EVEN)) }
    }

    /// Whether all legs of a control polygon are within half the angle of its chord. The tangents at both ends
    /// then are too, and so two neighbouring chords are within the angle.
    fn straight(&self, polygon: &[Vector]) -> bool {
        let (Some(first), Some(last)) = (polygon.first(), polygon.last()) else { return true };
        let chord = last - first;
        let legs = polygon.windows(2).map(|pair| pair[1] - pair[0]);
        let length: f64 = legs.clone().map(|leg| leg.norm()).sum();
        if length <= CORNER {
            return true;
        }
        let half = 0.5 * self.target.angle;
        // Legs of rounding size have no direction.
        legs.filter(|leg| leg.norm() > 1e-12).all(|leg| chord.norm() > 1e-12 && chord.angle(&leg) <= half)
    }
}

/// Control points out of homogeneous ones.
trait MapPoints {
    fn map_points(&self) -> Vec<Vector>;
}

impl MapPoints for [Vector4<f64>] {
    fn map_points(&self) -> Vec<Vector> {
        self.iter().map(|h| h.xyz() / h.w).collect()
    }
}

/// The largest distance of a control point from the segment between the first and the last.
///
/// The curve is in the convex hull of its control points and distance from a segment is convex, so no point of
/// the curve is further; and as the curve joins both ends, no point of the segment is further from the curve.
fn from_segment(polygon: &[Vector]) -> f64 {
    let (Some(a), Some(b)) = (polygon.first(), polygon.last()) else { return 0.0 };
    let chord = b - a;
    let squared = chord.norm_squared();
    let distance = |p: &Vector| {
        let along = if squared > 0.0 { ((p - a).dot(&chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (p - (a + chord * along)).norm()
    };
    polygon.iter().map(distance).fold(0.0, f64::max)
}

/// The sum of the angles between the legs of a control polygon.
fn turning(polygon: &[Vector]) -> f64 {
    let legs: Vec<Vector> =
        polygon.windows(2).map(|pair| pair[1] - pair[0]).filter(|leg| leg.norm() > 1e-12).collect();
    legs.windows(2).map(|pair| pair[0].angle(&pair[1])).sum()
}
