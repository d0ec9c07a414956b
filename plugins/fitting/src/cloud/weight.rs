//! The weight of an energy that follows from the noise of the points.

use loftsman_kernel::energy::Squares;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Symmetric;

use super::CloudFitted;
use super::crossed::held_out;
use super::descent::{Descended, GAIN, ROUNDING, Run, State};
use super::step::{Metric, nullity};
use crate::error::{FitError, Result};

/// Weights that are tried, at most, steps with each but the last, and the part by which one may be off.
const ROUNDS: usize = 16;
pub(super) const EACH: usize = 8;
const SETTLED: f64 = 0.1;
/// While the weight is on its way, a step that promises this part of what is there, and no more, is the last with one: noise and energy are
/// known better by then than the weight.
pub(super) const ROUGH: f64 = 1e-3;
/// An energy that comes to this part of the noise is at its end: a shape without any of it would have no more than twice this part
/// more noise.
const STRAIGHT: f64 = 1e-4;
/// And with the weight that is wanted to no more than this part.
const FEEBLE: f64 = 1e-2;
/// The largest weight, for matrices of trace 1: with more, what only the points determine is lost in the rounding of the energy.
const STIFFEST: f64 = 1e10;
/// With less than this, for such matrices, the points are alone.
const LEAST: f64 = 1e-6;
/// How much less is tried where a weight is more than that.
const LESS: f64 = 1e-3;
/// How far the trend of the weights is followed at once, of a step without it.
const TREND: (f64, f64) = (0.5, 6.0);
/// How many times as large as the weight that follows from the noise the first one is that is tried against points left out, at least.
const MORE: f64 = 10.0;
/// The coordinates that an energy is of.
const AXES: f64 = 3.0;
/// What is left of the points is this part of them, at least: below, it is rounding.
const LEFT: f64 = 1e-6;

/// Fits with an energy whose weight `λ` follows from the noise that is left, from more to less.
///
/// Under noise of variance `σ²` in the points and energies `E = Σ|r|²` whose rows are as likely as noise of another variance, the
/// likeliest two variances are where `λ E = (3 / c) σ² γ / (N - d - γ)` (MacKay 1992, section 4, written for means of squares): `N` points, `c` the
/// coordinates of three that distances see (two from a curve, one from a surface),
/// `d` dimensions of shapes that have no energy, and `γ = n - d - λ tr(A⁻¹K)` what the points determine of the others, of `n` free
/// vertices, with `A = M + λ K` the matrices of the distances and the energy. The larger the weight, the less `γ`: it goes with `1/λ` to 0,
/// and so does the right side, so that a shape with energy beyond the noise is not straightened because it is straight already. Where the
/// right side stays larger all the way, the likeliest shape has no energy, and the weight ends where what it has does not count
/// ([`STRAIGHT`]).
pub(super) fn weighed<S: Shape + Clone>(run: &mut Run<'_, S>, squares: Squares) -> Result<CloudFitted<S>> {
    let size = run.size();
    let first = run.state(run.asked.shape.clone(), None)?;
    let before = run.value(&first).0;
    let unseen = nullity(&matrix(&squares, &run.held.free, first.shape.control_vertices().len()));
    let trace = squares.trace();
    let stiffest = STIFFEST / trace;
    let mut weight = (before / (squares.energy(&run.relative(&first.shape)).0 + size * size)).min(stiffest);
    if !(weight > 0.0 && weight.is_finite()) {
        // Nothing to bring nearer, but what the points leave open is for the energy all the same.
        weight = if stiffest > 0.0 && stiffest.is_finite() { stiffest / STIFFEST } else { 1.0 };
    }
    let stiff = weight;
    let at = run.energies.len();
    run.energies.push((weight, squares));
    // Less noise than rounding makes is none.
    let least = (ROUNDING * size).powi(2);
    let (mut steps, mut last) = (0, None::<(f64, Descended<S>)>);
    let (mut trend, mut refused) = (None::<[f64; 2]>, None);
    // Until the weight is where it stays, nothing more is settled than it depends on.
    let (mut round, mut afresh, mut enough) = (0, false, ROUGH);
    run.hold_along(run.noise_within(&first));
    loop {
        round += 1;
        run.energies[at].0 = weight;
        let left = run.asked.iterations.saturating_sub(steps);
        let from = last.as_ref().map(|(_, found)| found);
        let (most, end) = if round < ROUNDS { (left.min(EACH), enough) } else { (left, GAIN) };
        let mut found = match run.descended(from, most, end) {
            // Too much of it, or too little.
            Err(error @ FitError::Undetermined { .. }) => {
                let good = last.as_ref().map(|(good, _)| *good);
                let next = good.map_or(LESS * weight, |good| (good * weight).sqrt());
                let near = good.is_some_and(|good| (next / good).ln().abs() <= SETTLED);
                let first = refused.get_or_insert(error).clone();
                if round >= ROUNDS || near || (next * trace).max(0.0) <= LEAST {
                    let Some((good, found)) = last else { return Err(first) };
                    run.energies[at].0 = good;
                    let mut settled = run.descended(Some(&found), left, GAIN)?;
                    settled.report.iterations += steps;
                    settled.report.before = before.sqrt();
                    return handed_out(run, at, good, settled);
                }
                (weight, trend) = (next, None);
                continue;
            }
            other => other?,
        };
        steps += found.report.iterations;
        (found.report.iterations, found.report.before) = (steps, before.sqrt());
        let noise = run.value(&found.state).0;
        let energy = run.energies[at].1.energy(&run.relative(&found.state.shape)).0;
        run.hold_along(run.noise_within(&found.state));
        let end = round >= ROUNDS || steps >= run.asked.iterations;
        if end {
            return handed_out(run, at, weight, found);
        }
        let wanted = match wanted(run, &found.state, at, [noise, energy], unseen) {
            Ok(wanted) if noise > least => wanted,
            // As far as it can be seen.
            Ok(_) | Err(FitError::Undetermined { .. }) => weight,
            Err(error) => return Err(error),
        };
        let mut way = (wanted.min(stiffest) / weight).ln();
        // A weight that is far too small leaves the energy as little to say, but is to be much larger.
        let meant = wanted * energy;
        let little = weight * energy <= STRAIGHT * noise && (meant.is_nan() || meant <= FEEBLE * noise);
        let straight = little && (way > 0.0 || !way.is_finite());
        way = if straight || !way.is_finite() { 0.0 } else { way };
        // A fixed point is come to slowly where the right side nearly follows the weight: a secant of the logarithms.
        let here = [weight.ln(), way];
        let slope = trend.map(|[x, y]| (here[1] - y) / (here[0] - x)).filter(|slope| *slope < 0.0);
        let settled = found.settled;
        way *= slope.map_or(1.0, |slope| (-1.0 / slope).clamp(TREND.0, TREND.1));
        if settled && way.abs() <= SETTLED {
            // A weight that began too large may have led where no smaller one leads back from: not where what was given leads.
            if noise > least && !std::mem::replace(&mut afresh, true) {
                let other = run.descended_if_determined(None, EACH, ROUGH)?;
                if let Some(other) = other.filter(|o| run.sum(o) < (1.0 - SETTLED) * run.sum(&found)) {
                    (last, trend) = (Some((weight, other)), None);
                    continue;
                }
            }
            if enough > GAIN && noise > least && !straight {
                let left = run.asked.iterations.saturating_sub(steps);
                let stiff = stiff.max(MORE * weight).min(stiffest);
                let (weight, mut settled) = held_out(run, at, stiff, (weight, found), left)?;
                settled.report.iterations += steps;
                settled.report.before = before.sqrt();
                return handed_out(run, at, weight, settled);
            }
            if enough > GAIN {
                (enough, last) = (GAIN, Some((weight, found)));
                continue;
            }
            return handed_out(run, at, weight, found);
        }
        trend = settled.then_some(here);
        last = Some((weight, found));
        if way.abs() > SETTLED {
            weight = (weight * way.exp()).min(stiffest);
        }
    }
}

/// What was found with a weight, measured.
fn handed_out<S: Shape + Clone>(
    run: &mut Run<'_, S>,
    at: usize,
    weight: f64,
    mut found: Descended<S>,
) -> Result<CloudFitted<S>> {
    run.energies[at].0 = weight;
    found.report.fair = Some(weight);
    run.hand_out(found)
}

/// The weight that is likeliest for what is left of noise and energy.
fn wanted<S: Shape + Clone>(
    run: &Run<'_, S>,
    state: &State<S>,
    at: usize,
    [noise, energy]: [f64; 2],
    unseen: usize,
) -> Result<f64> {
    let mut model = run.model(state)?;
    model.hold_along(None);
    let mut metric = Metric::new(&model, &run.held, run.solver)?;
    let (weight, squares) = &run.energies[at];
    let most = run.held.free.len().saturating_sub(unseen) as f64;
    let determined =
        (most - weight * metric.trace(squares, state.shape.control_vertices().len())).clamp(0.0, most);
    let points = run.points.len() as f64;
    let left = (points - unseen as f64 - determined).max(LEFT * points);
    // Of three coordinates a distance from a surface sees one, from a curve two.
    let seen = 3.0 - state.shape.domain().len() as f64;
    Ok(noise / seen * (AXES * determined) / (left * energy))
}

/// The matrix of an energy over the free vertices.
fn matrix(squares: &Squares, free: &[usize], count: usize) -> Symmetric {
    let mut entries = Vec::new();
    squares.entries(|i, j, value| entries.push((i.max(j), i.min(j), value)));
    Symmetric::from_entries(count, entries).select(free)
}
