//! The largest of distances over a box of parameters, of one dimension or two.

/// Of so many places where such a way is longest among those around, the distance is taken.
const SUSPECTS: usize = 32;
/// From so many of all these places, the furthest that are further than those around them, further ones are looked for.
const CLIMBED: usize = 4;
/// Halvings of the step of such a search.
const HALVINGS: usize = 12;
/// A closest place is known to this part of its distance: what is further by less is no further.
const KNOWN: f64 = 1e-10;
/// A bound that is larger than the distance by no more than this part of it is the distance.
const CERTAIN: f64 = 1e-9;
/// Steps of one length at most.
const STEPS: usize = 16;

/// Places of a grid in a box.
struct Places<'a, const N: usize>(&'a [Vec<f64>; N]);

impl<const N: usize> Places<'_, N> {
    fn count(&self) -> usize {
        self.0.iter().map(Vec::len).product()
    }

    fn indices(&self, mut k: usize) -> [usize; N] {
        let mut all = [0; N];
        for d in (0..N).rev() {
            (all[d], k) = (k % self.0[d].len(), k / self.0[d].len());
        }
        all
    }

    fn place(&self, k: usize) -> [f64; N] {
        let at = self.indices(k);
        std::array::from_fn(|d| self.0[d][at[d]])
    }

    /// Those at which a value is larger than at all places around (of equal ones the first), the largest first.
    fn peaks(&self, values: &[f64]) -> Vec<usize> {
        let is_peak = |k: usize| {
            let at = self.indices(k);
            // The neighbours are counted with a digit for each direction: before, beside, after.
            (0..3_usize.pow(N as u32)).all(|mut which| {
                let mut other = 0;
                for (d, here) in at.into_iter().enumerate() {
                    let Some(there) = (here + which % 3).checked_sub(1).filter(|t| *t < self.0[d].len())
                    else {
                        return true;
                    };
                    which /= 3;
                    other = other * self.0[d].len() + there;
                }
                values[k] > values[other] || (values[k] == values[other] && k <= other)
            })
        };
        let mut peaks: Vec<usize> = (0..values.len()).filter(|k| is_peak(*k)).collect();
        peaks.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
        peaks
    }
}

/// Where points of the same parameters are furthest from one another among those around: no distance of such a place is larger than the `way`, nor than its
/// `bound`, so that they are looked at in the order of their ways until no other one can be further.
pub(super) fn suspects<const N: usize>(
    dense: &[Vec<f64>; N],
    way: impl Fn([f64; N]) -> Option<f64>,
    away: &dyn Fn([f64; N]) -> Option<f64>,
    bound: &dyn Fn([f64; N]) -> Option<f64>,
) -> Option<Vec<[f64; N]>> {
    let places = Places(dense);
    let ways: Vec<f64> = (0..places.count()).map(|k| way(places.place(k))).collect::<Option<_>>()?;
    let (mut most, mut found) = (0.0_f64, Vec::new());
    for k in places.peaks(&ways).into_iter().take(SUSPECTS) {
        if ways[k] <= most {
            break;
        }
        let here = places.place(k);
        if found.len() >= CLIMBED && bound(here).is_some_and(|bound| bound <= most) {
            continue;
        }
        let far = away(here)?;
        most = most.max(far);
        found.push((far, here));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(CLIMBED);
    Some(found.into_iter().map(|(_, here)| here).collect())
}

/// The largest of distances over a box: at the places of a grid, and uphill from the largest of these and of `more`, by steps that are halved. `None` where one is not
/// known. No distance is larger than its `bound`, which costs less, if there is one, and most often is the distance: what is told is a distance all the same.
pub(super) fn furthest<const N: usize>(
    grid: &[Vec<f64>; N],
    more: &[[f64; N]],
    distance: &dyn Fn([f64; N]) -> Option<f64>,
    bound: &dyn Fn([f64; N]) -> Option<f64>,
) -> Option<f64> {
    let places = Places(grid);
    let count = places.count();
    let mut known = vec![false; count];
    let mut values = vec![0.0; count];
    for k in 0..count {
        values[k] = match bound(places.place(k)) {
            Some(bound) => bound,
            None => {
                known[k] = true;
                distance(places.place(k))?
            }
        };
    }
    // The largest of bounds are made distances, until the largest are.
    let peaks = loop {
        let mut peaks = places.peaks(&values);
        peaks.truncate(CLIMBED);
        if peaks.iter().all(|k| known[*k]) {
            break peaks;
        }
        for k in peaks {
            if !known[k] {
                (known[k], values[k]) = (true, distance(places.place(k))?);
            }
        }
    };
    let mut starts: Vec<(f64, [f64; N])> = peaks.into_iter().map(|k| (values[k], places.place(k))).collect();
    for at in more {
        starts.push((distance(*at)?, *at));
    }
    // The sort is stable: of equal ones the first.
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    starts.truncate(CLIMBED);
    let mut most = 0.0_f64;
    for start in starts {
        most = most.max(start.0);
        // By bounds, where what is found so is a distance.
        if let Some((above, here)) = uphill(grid, start, bound, &|_| None) {
            let far = distance(here)?;
            most = most.max(far);
            if far >= above * (1.0 - CERTAIN) {
                continue;
            }
        }
        most = most.max(uphill(grid, start, distance, bound)?.0);
    }
    Some(most).filter(|d| d.is_finite())
}

/// The place of a value that is larger than those around it, uphill from a place by steps that are halved; no value is larger than its bound.
fn uphill<const N: usize>(
    grid: &[Vec<f64>; N],
    (mut at, mut here): (f64, [f64; N]),
    value: &dyn Fn([f64; N]) -> Option<f64>,
    bound: &dyn Fn([f64; N]) -> Option<f64>,
) -> Option<(f64, [f64; N])> {
    let ends: [(f64, f64); N] = std::array::from_fn(|d| (grid[d][0], grid[d][grid[d].len() - 1]));
    let mut step: [f64; N] = std::array::from_fn(|d| (ends[d].1 - ends[d].0) / grid[d].len() as f64);
    for _ in 0..HALVINGS {
        for _ in 0..STEPS {
            let mut better = (at, here);
            for (d, way) in (0..N).flat_map(|d| [(d, 1.0), (d, -1.0)]) {
                let mut there = here;
                there[d] = (here[d] + way * step[d]).clamp(ends[d].0, ends[d].1);
                let enough = better.0 * (1.0 + KNOWN);
                if bound(there).is_some_and(|bound| bound <= enough) {
                    continue;
                }
                let far = value(there)?;
                if far > enough {
                    better = (far, there);
                }
            }
            if better.0 <= at {
                break;
            }
            (at, here) = better;
        }
        step = step.map(|s| 0.5 * s);
    }
    Some((at, here))
}
