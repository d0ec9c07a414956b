//! Which parts of the elements are kept: those no nearer to the curve than the distance.

use loftsman_kernel::error::{Error, Figure, Result};

use super::Job;
use super::element::Element;

/// Halvings of the parameter between a place that is kept and one that is not.
const BISECTIONS: usize = 40;

/// A part of an element, by its parameters.
#[derive(Clone, Copy)]
pub(super) struct Interval {
    pub(super) element: usize,
    pub(super) from: f64,
    pub(super) to: f64,
}

pub(super) struct Kept {
    /// In the curve's order.
    pub(super) intervals: Vec<Interval>,
    /// How many parts between them are not kept.
    pub(super) cut: usize,
}

/// Goes along each element by steps no longer than the rest of the curve (all but the piece itself, or those at a corner) is further away than
/// the distance `d`: on the way it cannot come nearer than that. What comes nearer by `ε` does so over `2 √(2 d ε)` at least; steps
/// are never shorter than a third of that for the tolerance.
pub(super) fn kept(job: &Job<'_>, elements: &[Element], round: u32) -> Result<Kept> {
    let mut kept = Kept { intervals: Vec::new(), cut: 0 };
    let away = job.distance.abs();
    let enough = away - job.slack();
    let shortest = job.blind() / (3.0 * 4_f64.powi(round as i32));
    let mut before = true;
    let most_places = job.places(elements.len());
    let mut looked = 0;
    for (index, element) in elements.iter().enumerate() {
        let valid =
            |t: f64| -> Result<bool> { Ok(job.around.distance(&element.place(job, t)?.point)? >= enough) };
        let (a, b) = element.domain();
        let widest = (b - a) / element.samples(round) as f64;
        let mut last = (a, valid(a)?);
        let mut from = a;
        kept.cut += usize::from(before && !last.1);
        let mut t = a;
        while t < b {
            looked += 1;
            if looked > most_places {
                return Err(Error::Invalid(format!(
                    "the offset at {} within {} takes more than {most_places} places to follow: give a larger tolerance, or split the curve",
                    Figure(job.distance),
                    crate::fields::figure(job.tolerance)
                )));
            }
            let place = element.place(job, t)?;
            let speed = place.derivative.norm();
            let most = away + speed * widest;
            let free =
                job.around.nearest(&place.point, element.own(), most)?.map_or(most, |found| found.0) - away;
            let step = free.max(shortest) / speed;
            t = if step < widest { t + step } else { t + widest };
            // No last step of rounding.
            t = if t < b - 1e-3 * widest { t } else { b };
            let here = (t, valid(t)?);
            if here.1 != last.1 {
                let edge = edge(last, here, &valid)?;
                if last.1 {
                    kept.intervals.push(Interval { element: index, from, to: edge });
                    kept.cut += 1;
                }
                from = edge;
            }
            last = here;
        }
        if last.1 {
            kept.intervals.push(Interval { element: index, from, to: b });
        }
        before = last.1;
    }
    kept.intervals.retain(|i| i.from < i.to);
    Ok(kept)
}

/// The last kept parameter between one that is and one that is not.
fn edge(a: (f64, bool), b: (f64, bool), valid: &impl Fn(f64) -> Result<bool>) -> Result<f64> {
    let (mut kept, mut cut) = if a.1 { (a.0, b.0) } else { (b.0, a.0) };
    for _ in 0..BISECTIONS {
        let middle = 0.5 * kept + 0.5 * cut;
        if middle == kept || middle == cut {
            break;
        }
        if valid(middle)? {
            kept = middle;
        } else {
            cut = middle;
        }
    }
    Ok(kept)
}

/// The radius of the largest circle on that side that touches the curve and has none of it inside, among those at many places:
/// shrunk until it does (J. Ma, S. W. Bae and S. Choi, 3D medial axis point approximation, Vis. Comput. 28, 2012).
pub(super) fn reach(job: &Job<'_>, elements: &[Element]) -> Result<f64> {
    let mut largest = 0.0_f64;
    for element in elements {
        let Element::Moved { piece, .. } = element else { continue };
        let (a, b) = piece.domain();
        let count = element.samples(0);
        for k in 0..count {
            let t = a + (b - a) * (k as f64 + 0.5) / count as f64;
            let foot = piece.point(t)?;
            let side = (element.place(job, t)?.point - foot) / job.distance.abs();
            let mut radius = job.distance.abs();
            for _ in 0..60 {
                let inside = radius * (1.0 - 1e-6);
                let Some((_, near)) = job.around.nearest(&(foot + side * radius), [usize::MAX; 2], inside)?
                else {
                    break;
                };
                let way = near - foot;
                let smaller = way.norm_squared() / (2.0 * way.dot(&side));
                if !(smaller > 0.0 && smaller < radius) {
                    break;
                }
                radius = smaller;
            }
            largest = largest.max(radius);
        }
    }
    Ok(largest)
}
