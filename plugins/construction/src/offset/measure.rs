//! How far an offset is from where it should be, measured on what is handed out.

use loftsman_kernel::error::Result;

use super::Job;
use super::chain::Chain;
use super::element::Element;

/// Places of a span, and of a part that is kept.
const PLACES: usize = 8;

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
