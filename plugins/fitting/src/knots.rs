//! Knots for given sites, so that interpolation and least squares have one answer.

use loftsman_kernel::spline::Space;

use crate::error::{FitError, Result};

/// Clamped space with as many vertices as sites, interior knots the means of `p` neighbouring sites (de Boor):
/// `t_{j+p} = (u_j + … + u_{j+p-1}) / p`. The Schoenberg–Whitney conditions hold for distinct sites.
pub(crate) fn averaged(degree: usize, sites: &[f64]) -> Result<Space> {
    let n = sites.len();
    if n < degree + 1 {
        return Err(too_few(n, degree));
    }
    let mut knots = Vec::with_capacity(n + degree + 1);
    knots.resize(degree + 1, sites[0]);
    knots.extend((1..n - degree).map(|j| mean(&sites[j..j + degree])));
    knots.resize(n + degree + 1, sites[n - 1]);
    Ok(Space::open(degree, knots)?)
}

/// Clamped space with as many vertices as sites, knots at the sites (between them for even degrees) but the
/// first and last few: the *not-a-knot* spline, one polynomial near each end.
pub(crate) fn not_a_knot(degree: usize, sites: &[f64]) -> Result<Space> {
    let n = sites.len();
    if n < degree + 1 {
        return Err(too_few(n, degree));
    }
    let skip = degree.div_ceil(2);
    let mut knots = vec![sites[0]; degree + 1];
    if degree % 2 == 1 {
        knots.extend_from_slice(&sites[skip..n - skip]);
    } else {
        knots.extend((skip..n - 1 - skip).map(|i| 0.5 * (sites[i] + sites[i + 1])));
    }
    knots.resize(knots.len() + degree + 1, sites[n - 1]);
    Ok(Space::open(degree, knots)?)
}

/// Clamped space with a knot at every site: `sites + degree - 1` vertices.
pub(crate) fn at_sites(degree: usize, sites: &[f64]) -> Result<Space> {
    if sites.len() < 2 {
        return Err(FitError::TooFewPoints { found: sites.len(), needed: 2, degree, possible: 0 });
    }
    Ok(Space::clamped(degree, sites)?)
}

/// Periodic space with a vertex a site; `sites` end with the first one a period later.
///
/// Odd degrees have their knots at the sites. For even degrees those equations are singular (an even number of
/// uniform sites shows it: the alternating spline vanishes at every knot), so the knots go halfway between.
pub(crate) fn around(degree: usize, sites: &[f64]) -> Result<Space> {
    if degree % 2 == 1 {
        return Ok(Space::periodic(degree, sites.to_vec())?);
    }
    let n = sites.len() - 1;
    let period = sites[n] - sites[0];
    let middle = |i: usize| 0.5 * (sites[i] + sites[i + 1]);
    // The domain starts half a step before the first site, so that this one stays inside.
    let first = middle(n - 1) - period;
    let mut knots = vec![first];
    knots.extend((0..n).map(middle));
    knots[n] = first + period;
    Ok(Space::periodic(degree, knots)?)
}

/// Breakpoints that share the sites out evenly: `spans + 1` of them, ends included.
pub(crate) fn shared(sites: &[f64], spans: usize) -> Vec<f64> {
    let last = sites.len() - 1;
    let mut breaks: Vec<f64> = (0..=spans)
        .map(|i| {
            let at = (i * last) as f64 / spans as f64;
            let k = (at as usize).min(last.saturating_sub(1));
            sites[k] + (at - k as f64) * (sites[k + 1] - sites[k])
        })
        .collect();
    breaks[spans] = sites[last];
    breaks.dedup();
    breaks
}

/// Checks that every basis function of an open space has a site of its own where it does not vanish (Schoenberg
/// and Whitney 1953): `t_i < u_{k_i} < t_{i+p+1}` with increasing, distinct `u_{k_i}`. That is necessary and
/// sufficient for a unique interpolant or least-squares fit. `O(n + m)`.
///
/// # Errors
/// [`FitError::NoData`] with the first vertex that has none, and a knot to remove.
pub(crate) fn check_data(space: &Space, sites: &[f64]) -> Result<()> {
    let (p, t) = (space.degree(), space.flat());
    let (a, b) = space.domain();
    let mut k = 0;
    for vertex in 0..space.unrolled_len() {
        let (start, end) = (t[vertex], t[vertex + p + 1]);
        // The first function of a clamped space does not vanish at its start, the last one not at its end.
        let reaches_start = start == a && t[vertex + p] == a;
        let reaches_end = end == b && t[vertex + 1] == b;
        while k < sites.len() && (sites[k] < start || (sites[k] == start && !reaches_start)) {
            k += 1;
        }
        let found = k < sites.len() && (sites[k] < end || (sites[k] == end && reaches_end));
        if !found {
            let inner = t[p + 1..space.unrolled_len()].iter().copied();
            let middle = 0.5 * start + 0.5 * end;
            let knot = inner.fold(f64::NAN, |best: f64, knot| {
                if best.is_nan() || (knot - middle).abs() < (best - middle).abs() { knot } else { best }
            });
            if knot.is_nan() {
                return Err(too_few(distinct(sites), p));
            }
            return Err(FitError::NoData { vertex, start, end, knot });
        }
        let used = sites[k];
        while k < sites.len() && sites[k] <= used {
            k += 1;
        }
    }
    Ok(())
}

pub(crate) fn too_few(found: usize, degree: usize) -> FitError {
    FitError::TooFewPoints { found, needed: degree + 1, degree, possible: found.saturating_sub(1) }
}

fn distinct(sites: &[f64]) -> usize {
    usize::from(!sites.is_empty()) + sites.windows(2).filter(|w| w[0] < w[1]).count()
}

fn mean(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().sum();
    // Rounding must not take the mean past the values it is the mean of.
    let (low, high) = (values[0], values[values.len() - 1]);
    (sum / values.len() as f64).max(low).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_of_the_book() {
        // Piegl and Tiller, The NURBS Book, example 9.1.
        let sites = [0.0, 5.0 / 17.0, 9.0 / 17.0, 14.0 / 17.0, 1.0];
        let space = averaged(3, &sites).unwrap();
        assert!((space.knots()[4] - 28.0 / 51.0).abs() < 1e-15);
        assert_eq!(space.len(), 5);
    }

    #[test]
    fn missing_data_are_named() {
        let space = Space::clamped(3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        let sites = [0.0, 0.2, 0.4, 0.6, 0.8, 5.2, 5.4, 5.6, 5.8, 6.0];
        let Err(FitError::NoData { start, end, knot, .. }) = check_data(&space, &sites) else { panic!() };
        assert!(start < knot && knot < end);
        let even: Vec<f64> = (0..=8).map(|i| 6.0 * f64::from(i) / 8.0).collect();
        check_data(&space, &even).unwrap();
        assert!(check_data(&space, &even[..8]).is_err());
    }
}
