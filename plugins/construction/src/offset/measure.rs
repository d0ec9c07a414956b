//! How far an offset is from where it should be, measured on what is handed out.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;

use super::chain::Chain;
use super::element::Element;
use super::tip::Tips;
use super::{Corners, Job};

/// Places of a span, and of a part that is kept.
const PLACES: usize = 8;
/// So many tolerances from where a part ends it is asked why.
const FURTHER: f64 = 10.0;

/// Whether everything that ends should end there. The offset of a piece is cut where another piece comes as near as the distance: where it
/// comes so on the side that is offset, its own offset begins there, and what is put together goes on. (On the other side, as where the curve
/// crosses itself, nothing does.)
pub(super) fn complete(job: &Job<'_>, elements: &[Element], tips: &Tips, chains: &[Chain]) -> Result<bool> {
    if job.options.corners == Corners::Open {
        return Ok(true);
    }
    let ends = job.curve.domain();
    let own_ends = [job.curve.point(ends.0)?, job.curve.point(ends.1)?];
    for chain in chains.iter().filter(|chain| !chain.closed) {
        let (a, b) = chain.curve.domain();
        for (t, part) in [(a, chain.parts.first()), (b, chain.parts.last())] {
            let end = chain.curve.point(t)?;
            let own = part.map_or([usize::MAX; 2], |(interval, _)| elements[interval.element].own());
            // The ends of an open curve are ends of its offset.
            let near = |p: &Point| (p - end).norm() <= job.distance.abs() + 10.0 * job.tolerance;
            if !job.plane.closed && own_ends.iter().any(near) {
                continue;
            }
            // What ends at the tip of a corner goes on along its sides, unless they come to the other side of the curve there.
            if tips.touch(&end, job.tolerance) && !crosses_over(job, elements, &end)? {
                return Ok(false);
            }
            let reach = job.distance.abs() + job.tolerance;
            for (_, piece) in job.around.pieces.iter().enumerate().filter(|(k, _)| !own.contains(k)) {
                let found = piece.closest(end)?;
                let (c, d) = piece.domain();
                let inside = found.at > c && found.at < d;
                if found.distance <= reach && inside {
                    let along = piece.derivative(found.at, 1)?;
                    let side = along.cross(&job.plane.normal) * job.distance;
                    if side.dot(&(end - found.point)) > 0.0 {
                        return Ok(false);
                    }
                }
            }
        }
    }
    Ok(true)
}

/// Whether a side of a tip that a place is on lies beyond the curve a little further on, as far away as asked for.
fn crosses_over(job: &Job<'_>, elements: &[Element], end: &Point) -> Result<bool> {
    let enough = job.distance.abs() - job.tolerance;
    for element in elements {
        let Element::Side { from, to, .. } = element else { continue };
        let way = to - from;
        let length = way.norm();
        let at = (end - from).dot(&way) / length;
        if (from + way * (at / length) - end).norm() > job.tolerance
            || at < -job.tolerance
            || at > length + job.tolerance
        {
            continue;
        }
        let further = (FURTHER * job.tolerance).min(0.25 * length);
        for beside in [at - further, at + further] {
            if !(0.0..=length).contains(&beside) {
                continue;
            }
            let point = from + way * (beside / length);
            if job.around.distance(&point)? >= enough && !job.around.beside(job, &point)? {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// The largest difference between the distance of a place of the offset from the curve and the one asked for, and the largest distance of
/// a place that should be passed from the offset. Tips of sharp corners may be further away than asked for.
pub(super) fn deviation(job: &Job<'_>, elements: &[Element], chains: &[Chain]) -> Result<f64> {
    let mut largest = 0.0_f64;
    for chain in chains {
        let curve = &chain.curve;
        let mut part = 0;
        for span in curve.space().breakpoints().windows(2) {
            for k in 0..=PLACES {
                let t = if k == PLACES {
                    span[1]
                } else {
                    span[0] + (span[1] - span[0]) * k as f64 / PLACES as f64
                };
                while part + 1 < chain.parts.len() && t > chain.parts[part].1.1 {
                    part += 1;
                }
                let off = job.around.distance(&curve.point(t)?)? - job.distance.abs();
                let tip = elements[chain.parts[part].0.element].is_side();
                largest = largest.max(if tip { -off } else { off.abs() });
            }
        }
        for (interval, _) in &chain.parts {
            let element = &elements[interval.element];
            for k in 0..=PLACES {
                let t = interval.from + (interval.to - interval.from) * k as f64 / PLACES as f64;
                let place = element.place(job, t.min(interval.to))?;
                largest = largest.max(curve.closest(place.point)?.distance);
            }
        }
    }
    Ok(largest)
}
