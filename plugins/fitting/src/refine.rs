//! Where a fit gets its next knots.

use loftsman_kernel::spline::Space;

use crate::error::Result;

/// Points that each half of a divided span must have. With two the curve has little freedom to swing between
/// them; one is for spans that nothing else helps (a corner in the data).
const POINTS_A_HALF: [usize; 2] = [2, 1];

/// The spans of a space, each with its points and how far they are from the curve.
#[derive(Debug)]
pub(crate) struct Spans {
    breaks: Vec<f64>,
    spans: Vec<Span>,
}

#[derive(Debug, Clone, Copy)]
struct Span {
    error: f64,
    /// Where to divide it, so that each half has as many points as `POINTS_A_HALF` says; none where it has too few.
    middle: [Option<f64>; 2],
}

impl Spans {
    /// Sorts the points into spans. `sites` do not decrease. `O(m + n)`.
    pub(crate) fn of(space: &Space, sites: &[f64], distances: &[f64]) -> Self {
        let breaks = space.breakpoints();
        let mut first = 0;
        let spans = breaks
            .windows(2)
            .map(|ends| {
                let inside = sites[first..].iter().take_while(|&&u| u < ends[1]).count();
                let range = first..first + inside;
                first += inside;
                Span {
                    error: distances[range.clone()].iter().fold(0.0, |m, d| m.max(*d)),
                    middle: POINTS_A_HALF
                        .map(|least| divide(&sites[range.clone()], &distances[range.clone()], least)),
                }
            })
            .collect();
        Self { breaks, spans }
    }

    /// The spans' errors, where one that cannot be divided hands its own on to the next ones on both sides that
    /// can: the curve gets the freedom it lacks as near by as there are points for it. `O(spans)`.
    fn handed_on(&self) -> Vec<f64> {
        let mut errors = vec![0.0_f64; self.spans.len()];
        let mut sweep = |order: &mut dyn Iterator<Item = usize>| {
            let mut carried = 0.0_f64;
            for i in order {
                carried = carried.max(self.spans[i].error);
                if self.spans[i].middle[1].is_some() {
                    errors[i] = errors[i].max(carried);
                    carried = 0.0;
                }
            }
        };
        sweep(&mut (0..self.spans.len()));
        sweep(&mut (0..self.spans.len()).rev());
        errors
    }
}

/// The middle between the two neighbouring points that share the span's squared error most evenly.
fn divide(sites: &[f64], distances: &[f64], least: usize) -> Option<f64> {
    if sites.len() < 2 * least {
        return None;
    }
    let total: f64 = distances.iter().map(|d| d * d).sum();
    let mut sum = 0.0;
    let half = distances.iter().take_while(|&&d| {
        sum += d * d;
        sum < 0.5 * total
    });
    let at = half.count().clamp(least, sites.len() - least);
    let (a, b) = (sites[at - 1], sites[at]);
    let middle = 0.5 * (a + b);
    // Coincident points cannot be parted.
    (middle > a && middle < b && middle > sites[0]).then_some(middle)
}

/// The space with one more knot in every span whose error is above the tolerance, the worst spans first, at most
/// `room` of them. Without a tolerance: in those near the largest error, and in as many as fill a quarter of the
/// room, so that few rounds fill it. `None` where no such span can be divided.
///
/// # Errors
/// As for [`Space::open`].
pub(crate) fn refine(
    space: &Space,
    spans: &Spans,
    tolerance: Option<f64>,
    room: usize,
) -> Result<Option<Space>> {
    let largest = spans.spans.iter().fold(0.0_f64, |m, s| m.max(s.error));
    let pick = |errors: &[f64], choice: usize| {
        let all = spans.spans.iter().zip(errors);
        let mut chosen: Vec<(f64, f64)> = all
            .filter(|&(_, &error)| tolerance.is_none_or(|t| error > t))
            .filter_map(|(s, &error)| s.middle[choice].map(|middle| (error, middle)))
            .collect();
        chosen.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
        if tolerance.is_none() {
            let near = chosen.iter().take_while(|c| c.0 >= 0.25 * largest).count();
            chosen.truncate(near.max(room.div_ceil(4)));
        }
        chosen.truncate(room);
        chosen
    };
    let errors: Vec<f64> = spans.spans.iter().map(|s| s.error).collect();
    let mut chosen = pick(&errors, 0);
    if chosen.is_empty() {
        chosen = pick(&errors, 1);
    }
    if chosen.is_empty() {
        chosen = pick(&spans.handed_on(), 1);
    }
    if chosen.is_empty() {
        return Ok(None);
    }
    let mut breaks = spans.breaks.clone();
    breaks.extend(chosen.iter().map(|&(_, middle)| middle));
    breaks.sort_by(f64::total_cmp);
    let p = space.degree();
    Ok(Some(if space.is_periodic() { Space::periodic(p, breaks)? } else { Space::clamped(p, &breaks)? }))
}
