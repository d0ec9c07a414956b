//! Which parts of the elements are kept: those no nearer to the curve than the distance.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};

use super::Job;
use super::element::{Element, Place};
use super::tip::{Among, Tips};

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
    /// Whether parts are left out that bound a strip of no width.
    pub(super) strips: bool,
}

/// A place that is not kept.
struct Lost {
    /// Over so much of the way it is not, for certain.
    by: f64,
    /// Whether that is only because what lies beyond it is not either.
    strip: bool,
}

/// What is no wider than so many slacks is a strip of no width: well above what rounding makes of twice the distance.
const STRIP: f64 = 4.0;
/// A strip that is worth a word is longer than this part of the distance.
const LONG: f64 = 1e-3;

/// Goes along each element by steps no longer than the rest of the curve (all but the piece itself, or those at a corner) is further away than
/// the distance `d`: on the way it cannot come nearer than that. What comes nearer by `ε` does so over `2 √(2 d ε)` at least; steps
/// are never shorter than a third of that for the tolerance. Where it is too near, steps are as long as it stays so for certain.
/// What is inside the tip of another corner is not kept: lines are asked where they enter and leave it, all else as for the distance.
/// Nor is a place kept beyond which, a few slacks further out, another part of the curve is nearer than the distance: where two sides are twice the distance
/// apart, both their offsets run along the middle, with nothing between them.
/// `looked` counts the places of all rounds.
pub(super) fn kept(
    job: &Job<'_>,
    elements: &[Element],
    tips: &Tips,
    round: u32,
    looked: &mut usize,
) -> Result<Kept> {
    let mut kept = Kept { intervals: Vec::new(), cut: 0, strips: false };
    let away = job.distance.abs();
    let enough = away - job.slack();
    let shortest = job.blind() / (3.0 * 4_f64.powi(round as i32));
    let mut before = true;
    let most_places = job.places(elements.len());
    let most_searches = job.searches(elements.len());
    for (index, element) in elements.iter().enumerate() {
        let among = Among::new(job, element, tips);
        let beyond = |t: f64, place: &Place| -> Result<Point> {
            Ok(place.point + element.outwards(job, t, place)? * (STRIP * job.slack()))
        };
        // `None` where it is kept.
        let lost = |t: f64| -> Result<Option<Lost>> {
            let place = element.place(job, t)?;
            let near = job.around.distance(&place.point)?;
            if near < enough {
                return Ok(Some(Lost { by: enough - near, strip: false }));
            }
            if let Some(by) = among.covered(job, &place.point)? {
                return Ok(Some(Lost { by, strip: false }));
            }
            let beyond = beyond(t, &place)?;
            let strip =
                among.is_inside(&beyond) || job.around.nearest(&beyond, element.own(), enough)?.is_some();
            Ok(strip.then_some(Lost { by: 0.0, strip }))
        };
        let valid = |t: f64| lost(t).map(|lost| lost.is_none());
        let (a, b) = element.domain();
        let widest = (b - a) / element.samples(round) as f64;
        let start = element.place(job, a)?;
        let even = element.is_even();
        let mut events: Vec<f64> = Vec::new();
        if even {
            for from in [start.point, beyond(a, &start)?] {
                events.extend(among.events(&from, &start.derivative));
            }
        }
        events.sort_by(|x, y| y.total_cmp(x));
        let mut sure = lost(a)?;
        let mut last = (a, sure.is_none());
        let mut from = a;
        kept.cut += usize::from(before && !last.1);
        let mut t = a;
        let mut strip: Option<Point> = None;
        while t < b {
            *looked += 1;
            let much = if *looked > most_places {
                Some(format!("{most_places} places"))
            } else if job.around.searches() > most_searches {
                Some(format!("{most_searches} nearest places"))
            } else {
                None
            };
            if let Some(much) = much {
                return Err(Error::Invalid(format!(
                    "the offset at {} within {} takes more than {much} to follow: give a larger tolerance, or split the curve",
                    job.options.given(job.distance),
                    job.options.found(job.tolerance)
                )));
            }
            let place = element.place(job, t)?;
            let speed = place.derivative.norm();
            let free = if let Some(sure) = &sure {
                sure.by
            } else {
                let most = away + speed * widest;
                let rest =
                    job.around.nearest(&place.point, element.own(), most)?.map_or(most, |found| found.0);
                (rest - away).min(if even { f64::INFINITY } else { among.free(&place.point) })
            };
            let step = free.max(shortest) / speed;
            let here = t;
            t = if step < widest { t + step } else { t + widest };
            // No last step of rounding.
            t = if t < b - 1e-3 * widest { t } else { b };
            while let Some(event) = events.pop_if(|event| a + *event < t) {
                if a + event > here {
                    t = a + event;
                }
            }
            sure = lost(t)?;
            // Where two cross, or one enters the tip of a corner, it is so over a few slacks.
            match sure.as_ref().is_some_and(|lost| lost.strip) {
                false => strip = None,
                true => {
                    let here = element.place(job, t)?.point;
                    let began = *strip.get_or_insert(here);
                    kept.strips |= (here - began).norm() > LONG * away;
                }
            }
            let here = (t, sure.is_none());
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

/// Places around which the radius is largest that are looked at more closely, and halvings of the way to the next ones.
const PEAKS: usize = 8;
const CLOSER: usize = 16;

/// The radius of the largest circle on that side that touches the curve and has none of it inside, among those at many places and between these where they
/// are largest; none is larger than the distance.
pub(super) fn reach(job: &Job<'_>, elements: &[Element]) -> Result<f64> {
    let mut found: Vec<(f64, usize, f64, f64)> = Vec::new();
    // It is for a message: what takes long is found less near.
    let most = job.around.searches() + job.searches(elements.len());
    for (index, element) in elements.iter().enumerate() {
        let Element::Moved { piece, .. } = element else { continue };
        let (a, b) = piece.domain();
        let count = element.samples(0);
        let width = (b - a) / count as f64;
        for k in 0..count {
            if job.around.searches() > most {
                break;
            }
            let t = a + width * (k as f64 + 0.5);
            found.push((radius(job, element, t)?, index, t, width));
        }
    }
    found.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)).then(x.2.total_cmp(&y.2)));
    let mut largest = found.first().map_or(0.0, |best| best.0);
    for &(start, index, at, width) in found.iter().take(PEAKS) {
        let (a, b) = elements[index].domain();
        let (mut best, mut at, mut step) = (start, at, 0.5 * width);
        for _ in 0..CLOSER {
            let mut moved = false;
            for t in [at - step, at + step].map(|t| t.clamp(a, b)) {
                let here = radius(job, &elements[index], t)?;
                if here > best {
                    (best, at, moved) = (here, t, true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        largest = largest.max(best);
    }
    Ok(largest)
}

/// The radius of the largest circle on that side that touches the curve at a place of an element and has none of the curve inside, up to the distance:
/// shrunk until it does (J. Ma, S. W. Bae and S. Choi, 3D medial axis point approximation, Vis. Comput. 28, 2012).
fn radius(job: &Job<'_>, element: &Element, t: f64) -> Result<f64> {
    let Element::Moved { piece, .. } = element else { return Ok(0.0) };
    let foot = piece.point(t)?;
    let side = (element.place(job, t)?.point - foot) / job.distance.abs();
    let mut radius = job.distance.abs();
    for _ in 0..60 {
        let inside = radius * (1.0 - 1e-6);
        let Some((_, near)) = job.around.nearest(&(foot + side * radius), [usize::MAX; 2], inside)? else {
            break;
        };
        let way = near - foot;
        let smaller = way.norm_squared() / (2.0 * way.dot(&side));
        if !(smaller > 0.0 && smaller < radius) {
            break;
        }
        radius = smaller;
    }
    Ok(radius)
}
