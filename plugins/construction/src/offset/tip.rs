//! The tips of sharp corners: what the prolonged sides of a corner enclose with the corner itself.

use loftsman_kernel::error::Result;
use loftsman_kernel::{Point, Vector};

use super::Job;
use super::element::Element;

/// Sides whose directions differ by less run along one another.
const ALONG: f64 = 1e-9;
/// What is this part of the distance ahead of a corner is not beside it.
const AHEAD: f64 = 1e-6;
/// So much less than 1 is the cosine of the angle between arms at most that end in one line.
const SAME: f64 = 1e-6;

/// The corner, where both its sides begin, and the tip between: a convex quadrangle that belongs to what lies nearer than the distance.
pub(super) struct Tip {
    pub(super) corner: Point,
    /// From the corner to where the sides begin.
    pub(super) arms: [Vector; 2],
    /// A point of each edge, and inwards across it.
    edges: [(Point, Vector); 4],
    /// The directions of the sides, in the curve's order.
    ways: [Vector; 2],
    low: Point,
    high: Point,
}

impl Tip {
    pub(super) fn new(corner: Point, arms: [Vector; 2], tip: Point, normal: &Vector) -> Self {
        let points = [corner, corner + arms[0], tip, corner + arms[1]];
        let middle = corner + (tip - corner) * 0.5;
        let edges = std::array::from_fn(|k| {
            let (from, to) = (points[k], points[(k + 1) % 4]);
            let across = normal.cross(&(to - from)).normalize();
            (from, if across.dot(&(middle - from)) < 0.0 { -across } else { across })
        });
        let ways = [(tip - points[1]).normalize(), (points[3] - tip).normalize()];
        let low = points.iter().skip(1).fold(corner, |low, p| low.inf(p));
        let high = points.iter().skip(1).fold(corner, |high, p| high.sup(p));
        Self { corner, arms, edges, ways, low, high }
    }

    /// How far a point is inside, from its nearest edge; outside the distance is at least what this is below 0.
    pub(super) fn depth(&self, point: &Point) -> f64 {
        self.edges.iter().map(|(at, across)| (point - at).dot(across)).fold(f64::INFINITY, f64::min)
    }

    /// The part of a line, in lengths along `way` from a point, that is deeper inside than `margin`.
    fn part(&self, from: &Point, way: &Vector, margin: f64) -> Option<(f64, f64)> {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (at, across) in &self.edges {
            let (depth, rate) = ((from - at).dot(across) - margin, way.dot(across));
            if rate > 0.0 {
                low = low.max(-depth / rate);
            } else if rate < 0.0 {
                high = high.min(-depth / rate);
            } else if depth <= 0.0 {
                return None;
            }
        }
        (low < high).then_some((low, high))
    }
}

/// All tips, to be found by place.
pub(super) struct Tips {
    pub(super) all: Vec<Tip>,
    /// By the least x.
    sorted: Vec<usize>,
    widest: f64,
}

impl Tips {
    pub(super) fn new(all: Vec<Tip>) -> Self {
        let mut sorted: Vec<usize> = (0..all.len()).collect();
        sorted.sort_by(|&a, &b| all[a].low.x.total_cmp(&all[b].low.x).then(a.cmp(&b)));
        let widest = all.iter().map(|tip| tip.high.x - tip.low.x).fold(0.0, f64::max);
        Self { all, sorted, widest }
    }

    /// Those whose boxes meet a box, in the curve's order.
    fn meeting(&self, low: &Point, high: &Point) -> Vec<usize> {
        let from = self.sorted.partition_point(|&k| self.all[k].low.x < low.x - self.widest);
        let near = self.sorted[from..].iter().copied().take_while(|&k| self.all[k].low.x <= high.x);
        let mut found: Vec<usize> = near
            .filter(|&k| {
                let tip = &self.all[k];
                (0..3).all(|axis| tip.low[axis] <= high[axis] && tip.high[axis] >= low[axis])
            })
            .collect();
        found.sort_unstable();
        found
    }

    /// Whether a point is at the edge of a tip, to a width, or inside.
    pub(super) fn touch(&self, point: &Point, width: f64) -> bool {
        let reach = Vector::repeat(width);
        self.meeting(&(point - reach), &(point + reach)).iter().any(|&k| self.all[k].depth(point) >= -width)
    }
}

/// The tips that an element may meet, and how far inside is inside.
pub(super) struct Among<'a> {
    near: Vec<(&'a Tip, f64)>,
    /// The tip of which the element is a side, and which side.
    own: Option<(&'a Tip, usize)>,
    /// The pieces on both sides of its corner.
    between: [usize; 2],
    slack: f64,
}

impl<'a> Among<'a> {
    pub(super) fn new(job: &Job<'_>, element: &Element, tips: &'a Tips) -> Self {
        let slack = job.slack();
        let (low, high) = element.bounds(job);
        let reach = Vector::repeat(slack);
        let own = element.tip();
        let near = tips.meeting(&(low - reach), &(high + reach)).into_iter();
        let near = near.filter(|&k| own.is_none_or(|(mine, _)| mine != k)).map(|k| {
            // Of sides that run along one another the first is kept.
            let tip = &tips.all[k];
            let along = own.is_some_and(|(mine, side)| {
                let way = tips.all[mine].ways[side];
                k < mine && tip.ways.iter().any(|w| w.dot(&way) > 0.0 && w.cross(&way).norm() <= ALONG)
            });
            (tip, if along { -slack } else { slack })
        });
        Self {
            near: near.collect(),
            own: own.map(|(k, side)| (&tips.all[k], side)),
            between: element.own(),
            slack,
        }
    }

    /// Over which length to all sides a point of the element is inside another tip, or is no edge for another reason; `None` where it is one.
    pub(super) fn covered(&self, job: &Job<'_>, point: &Point) -> Result<Option<f64>> {
        for (tip, margin) in &self.near {
            let depth = tip.depth(point);
            if depth > *margin {
                return Ok(Some(depth - margin));
            }
        }
        let Some((own, side)) = self.own else { return Ok(None) };
        // A side along the moved piece of another part of the curve is there already.
        let away = job.distance.abs();
        let arm = own.arms[side];
        if let Some((_, foot)) = job.around.nearest(point, self.between, away + self.slack)? {
            let way = if side == 0 { own.ways[0] } else { -own.ways[1] };
            let ahead = (foot - own.corner).dot(&way) > AHEAD * away;
            if ahead && (point - foot).dot(&arm) >= (1.0 - SAME) * away * away {
                return Ok(Some(0.0));
            }
        }
        // Beyond the curve there is the other side of it.
        Ok((!job.around.beside(job, point)?).then_some(0.0))
    }

    /// Whether a point is inside another tip.
    pub(super) fn is_inside(&self, point: &Point) -> bool {
        self.near.iter().any(|(tip, _)| tip.depth(point) > self.slack)
    }

    /// How far the point is from all other tips at least.
    pub(super) fn free(&self, point: &Point) -> f64 {
        self.near.iter().map(|(tip, _)| (-tip.depth(point)).max(0.0)).fold(f64::INFINITY, f64::min)
    }

    /// Where a line enters and leaves tips, and between, in lengths along `way`, ascending.
    pub(super) fn events(&self, from: &Point, way: &Vector) -> Vec<f64> {
        let parts = self.near.iter().filter_map(|(tip, margin)| tip.part(from, way, *margin));
        let mut events: Vec<f64> =
            parts.flat_map(|(low, high)| [low, 0.5 * low + 0.5 * high, high]).collect();
        events.sort_by(f64::total_cmp);
        events
    }
}
