//! How far places are from the curve, or from all of it but some pieces.

use std::cell::Cell;

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::Job;
use super::element::direction;

/// The curve in polynomial pieces that turn by no more than a right angle, and the boxes around them.
pub(super) struct Around {
    pub(super) pieces: Vec<Curve>,
    boxes: Vec<(Point, Point)>,
    /// How many nearest places of pieces were asked for.
    searches: Cell<usize>,
}

/// What is this part of its distance ahead of an end is not beside it.
const AHEAD: f64 = 1e-9;

/// A way of the curve through a place.
struct Way {
    /// To which it is moved, as seen from the first to the last of its pieces together.
    side: Vector,
    /// The first and the last of its pieces.
    pieces: [usize; 2],
    /// Their directions there.
    tangents: [Vector; 2],
    /// Whether the first one starts there, and the last one ends.
    starts: bool,
    ends: bool,
}

/// Halvings of a piece that turns.
const HALVINGS: usize = 8;

impl Around {
    /// Pieces that are points are left out. A torn curve is that on both sides of a tear.
    pub(super) fn new(curve: &Curve, least: f64) -> Result<Self> {
        let mut pieces = Vec::new();
        for segment in curve.bezier_segments()? {
            if segment.points().iter().all(|q| (q - segment.points()[0]).norm() <= least) {
                continue;
            }
            // Where it stops and turns back its way has no side: that is an end of pieces, which is found to the last bit.
            let mut whole = vec![segment];
            for at in stops(&whole[0])? {
                let Some(last) = whole.pop() else { break };
                whole.extend(last.split(at)?);
            }
            let mut open: Vec<(Curve, usize)> = whole.into_iter().rev().map(|piece| (piece, 0)).collect();
            while let Some((piece, depth)) = open.pop() {
                let (a, b) = piece.domain();
                let middle = 0.5 * a + 0.5 * b;
                if depth < HALVINGS
                    && turning(&piece) > std::f64::consts::FRAC_PI_2
                    && a < middle
                    && middle < b
                {
                    let halves = piece.split(middle)?;
                    open.extend(halves.into_iter().rev().map(|half| (half, depth + 1)));
                } else {
                    pieces.push(piece);
                }
            }
        }
        let boxes = pieces.iter().map(Curve::hull_bounds).collect();
        Ok(Self { pieces, boxes, searches: Cell::new(0) })
    }

    /// The distance of a point from all pieces but some, and the place there; none where it is not below `most`.
    pub(super) fn nearest(
        &self,
        point: &Point,
        without: [usize; 2],
        most: f64,
    ) -> Result<Option<(f64, Point)>> {
        let mut near: Vec<(f64, usize)> = (self.boxes.iter().enumerate())
            .map(|(k, (low, high))| ((point.sup(low).inf(high) - point).norm(), k))
            .filter(|(bound, k)| *bound < most && !without.contains(k))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(f64, Point)> = None;
        for (bound, k) in near {
            let least = best.map_or(most, |b| b.0);
            if bound >= least {
                break;
            }
            self.searches.set(self.searches.get() + 1);
            let found = self.pieces[k].closest(*point)?;
            if found.distance < least {
                best = Some((found.distance, found.point));
            }
        }
        Ok(best)
    }

    /// How many nearest places of pieces were asked for so far.
    pub(super) fn searches(&self) -> usize {
        self.searches.get()
    }

    /// Whether a point off the curve lies on the side to which it is moved, as seen from its nearest place: at a corner from both pieces there, and where the curve comes
    /// to that place several times, as at the root of a spike, on one of its ways through at least. What lies ahead of an end has no side.
    pub(super) fn beside(&self, job: &Job<'_>, point: &Point) -> Result<bool> {
        let Some((distance, foot)) = self.nearest(point, [usize::MAX; 2], f64::INFINITY)? else {
            return Ok(true);
        };
        let same = 1e-11 * job.size;
        let mut ways: Vec<Way> = Vec::new();
        for (k, (piece, (low, high))) in self.pieces.iter().zip(&self.boxes).enumerate() {
            if (foot.sup(low).inf(high) - foot).norm() > same {
                continue;
            }
            let found = piece.closest(*point)?;
            if found.distance > distance + same || (found.point - foot).norm() > same {
                continue;
            }
            let (_, _, tangent, _) = direction(piece, found.at)?;
            let side = tangent.cross(&job.plane.normal) * job.distance;
            let (a, b) = piece.domain();
            let [starts, ends] = [piece.point(a)?, piece.point(b)?].map(|end| (end - foot).norm() <= same);
            match ways.last_mut() {
                Some(way) if starts && way.ends && way.pieces[1] + 1 == k => {
                    way.side += side;
                    way.pieces[1] = k;
                    way.tangents[1] = tangent;
                    way.ends = ends;
                }
                _ => ways.push(Way { side, pieces: [k; 2], tangents: [tangent; 2], starts, ends }),
            }
        }
        // The last piece of a closed curve goes on in the first.
        if let [first, .., last] = &mut ways[..] {
            let seam = first.starts && first.pieces[0] == 0;
            if job.plane.closed && seam && last.ends && last.pieces[1] + 1 == self.pieces.len() {
                first.side += last.side;
                first.starts = last.starts;
                first.tangents[0] = last.tangents[0];
                ways.pop();
            }
        }
        let arm = point - foot;
        let ahead = AHEAD * distance;
        Ok(ways.iter().any(|way| {
            way.side.dot(&arm) >= 0.0
                || way.starts && way.tangents[0].dot(&arm) < -ahead
                || way.ends && way.tangents[1].dot(&arm) > ahead
        }))
    }

    /// The distance of a point from the curve.
    pub(super) fn distance(&self, point: &Point) -> Result<f64> {
        Ok(self.nearest(point, [usize::MAX; 2], f64::INFINITY)?.map_or(f64::INFINITY, |found| found.0))
    }
}

/// Places of a piece of which the slowest are looked at, for each of its degrees.
const PLACES: usize = 8;
/// Slower than this part of its mean speed a piece stops.
const STOPS: f64 = 1e-9;

/// Where within a piece its derivative vanishes, ascending: around the slowest of some places the least speed, then where `C'` changes its sign along `C''`.
fn stops(piece: &Curve) -> Result<Vec<f64>> {
    let run: f64 = piece.points().windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let (a, b) = piece.domain();
    let count = PLACES * (piece.degree() + 1);
    let at = |k: usize| a + (b - a) * k as f64 / count as f64;
    let speeds: Vec<f64> =
        (0..=count).map(|k| Ok(piece.derivative(at(k).min(b), 1)?.norm())).collect::<Result<_>>()?;
    let mut found = Vec::new();
    for k in 1..count {
        if speeds[k] > speeds[k - 1] || speeds[k] >= speeds[k + 1] || speeds[k] * (b - a) > 0.5 * run {
            continue;
        }
        let (mut low, mut high) = (at(k - 1), at(k + 1));
        for _ in 0..60 {
            let [x, y] = [0.382, 0.618].map(|share| low + (high - low) * share);
            if piece.derivative(x, 1)?.norm() <= piece.derivative(y, 1)?.norm() { high = y } else { low = x }
        }
        let near = 0.5 * low + 0.5 * high;
        let bend = piece.derivative(near, 2)?;
        let along = |u: f64| piece.derivative(u, 1).map(|d| d.dot(&bend));
        // The least of a square is known to the root of rounding: the sign is known better.
        let reach = 1e-6 * (b - a);
        let (mut low, mut high) = ((near - reach).max(a), (near + reach).min(b));
        if !(along(low)? < 0.0 && along(high)? > 0.0) {
            continue;
        }
        while low < high {
            let middle = 0.5 * low + 0.5 * high;
            if !(low < middle && middle < high) {
                break;
            }
            if along(middle)? < 0.0 { low = middle } else { high = middle }
        }
        if piece.derivative(high, 1)?.norm() * (b - a) <= STOPS * run && a < high && high < b {
            found.push(high);
        }
    }
    Ok(found)
}

/// How far the control polygon turns, and so the piece at most.
fn turning(piece: &Curve) -> f64 {
    let legs: Vec<_> =
        piece.points().windows(2).map(|w| w[1] - w[0]).filter(|leg| leg.norm() > 0.0).collect();
    legs.windows(2).map(|w| w[0].cross(&w[1]).norm().atan2(w[0].dot(&w[1]))).sum()
}
