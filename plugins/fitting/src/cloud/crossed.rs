//! How much of an energy points call for that were left out of the fit.

use loftsman_kernel::Point;
use loftsman_kernel::shape::Shape;

use super::descent::{Descended, GAIN, Run, State};
use super::weight::{EACH, ROUGH};
use crate::error::{FitError, Result};

/// Parts of the points, each left out once.
const PARTS: usize = 4;
/// How weights follow one another, and how many are tried at most.
const LESS: f64 = 1.0 / 3.0;
const WEIGHTS: usize = 12;
/// Steps with each weight from the shape as it was given, and with which weights, as parts of the one meant.
const AFRESH: usize = 20;
const CHAINS: [&[f64]; 2] = [&[1.0], &[10.0, 1.0]];
/// Standard deviations of a mean square by which a weight may be worse than the best, for as little as that nobody can tell them apart: of
/// these the largest is taken.
const ALIKE: f64 = 0.5;
/// As many times the noise that is left as that of the points is at most, however few they are.
const MOST_NOISE: f64 = 4.0;
/// Shapes whose distances, energy and area differ by no more than this part are one place, or as good as one: control vertices may slide along a shape.
const SAME: f64 = 0.05;
/// Standard deviations of a mean square that are chance.
const CHANCE: f64 = 2.0;

/// Points with their shares, the sum of these 1, and what part of all they are.
struct Part {
    points: Vec<Point>,
    shares: Vec<f64>,
    sum: f64,
}

impl Part {
    /// The points of a part of all, or all but these.
    fn of<S: Shape + Clone>(run: &Run<'_, S>, part: usize, inside: bool) -> Self {
        let chosen = || (0..run.points.len()).filter(move |k| (part_of(*k) == part) == inside);
        let sum: f64 = chosen().map(|k| run.shares[k]).sum();
        let shares = chosen().map(|k| run.shares[k] / sum).collect();
        Self { points: chosen().map(|k| run.points[k]).collect(), shares, sum }
    }

    /// What is done with these points in place of all.
    fn with<'a, S, R>(&mut self, run: &mut Run<'a, S>, work: impl FnOnce(&mut Run<'a, S>) -> R) -> R {
        self.swap(run);
        let result = work(run);
        self.swap(run);
        result
    }

    fn swap<S>(&mut self, run: &mut Run<'_, S>) {
        std::mem::swap(&mut self.points, &mut run.points);
        std::mem::swap(&mut self.shares, &mut run.shares);
    }
}

/// The part of a point: of every [`PARTS`] points in a row one, which one changes as it looks by chance (the mixing of SplitMix64), so
/// that rows of a scan do not fall into one part.
fn part_of(point: usize) -> usize {
    let mut z = (point / PARTS) as u64 ^ 0x9e37_79b9_7f4a_7c15;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (point + (z ^ (z >> 31)) as usize % PARTS) % PARTS
}

/// From where steps came to with the weight that follows from the noise, to where the points are likelier to come from: with that weight, or with
/// the larger one that points which were left out call for.
///
/// That noise is underrated where few points are met by a shape that winds through them: its energy is large then, and the weight that
/// follows is up to a hundred times too small. A larger one is tried, and brought nearer to the other until steps with it lead to where the
/// points are no farther from the shape than their noise can be, `σ² = ‖d‖² / (N - 3n)` for `N` points and `n` free vertices; `stiff` is where the search for
/// it begins. With a larger weight the shape may lose its place to one that bends less and goes where no point is, so that of all places on
/// the way, those with the other weight among them, the likeliest is taken ([`Likelihood`]).
///
/// A place is where steps end, of which `left` are allowed: what is on its way out of one is told by going on.
pub(super) fn held_out<S: Shape + Clone>(
    run: &mut Run<'_, S>,
    at: usize,
    stiff: f64,
    (weight, found): (f64, Descended<S>),
    left: usize,
) -> Result<(f64, Descended<S>)> {
    let called = best_weight(run, at, stiff, weight)?;
    let likelihood = Likelihood::new(run, at, weight, &found);
    let mut places = Vec::new();
    if let Some((called, starts)) = called.filter(|(called, _)| called * LESS > weight) {
        let (mut more, mut alone) = (called, false);
        while places.is_empty() && more * LESS > weight {
            run.energies[at].0 = more;
            let ends = ends(run, at, &found, &starts)?;
            (places, alone) = likely(run, &likelihood, ends)?;
            more = (more * weight).sqrt();
        }
        // With the weight itself, too: where all ways led to one place, from there.
        run.energies[at].0 = weight;
        let ends = match places.first() {
            Some(place) if alone => vec![run.descended(Some(&place.found), AFRESH, ROUGH)?],
            _ => ends(run, at, &found, &starts)?,
        };
        places.extend(likely(run, &likelihood, ends)?.0);
    }
    run.energies[at].0 = weight;
    places.push(Place { against: likelihood.against(run, &found.state), weight, found });
    places.sort_by(|a, b| a.against.total_cmp(&b.against));
    let mut best = None::<Place<S>>;
    for place in places {
        if best.as_ref().is_some_and(|best| place.against >= best.against) {
            break;
        }
        run.energies[at].0 = place.weight;
        let found = run.descended(Some(&place.found), left, GAIN)?;
        let against = likelihood.against(run, &found.state);
        let counts = place.weight == weight || likelihood.explains(run, &found.state);
        if counts && best.as_ref().is_none_or(|best| against < best.against) {
            best = Some(Place { against, found, ..place });
        }
    }
    let Some(best) = best else { return Ok((weight, run.descended(None, left, GAIN)?)) };
    run.energies[at].0 = best.weight;
    Ok((best.weight, best.found))
}

/// Where steps ended with a weight, and what is against it.
struct Place<S> {
    against: f64,
    weight: f64,
    found: Descended<S>,
}

/// How likely points come from a shape, whatever the weight with which it was found.
///
/// Of points spread evenly over a surface of area `A`, each moved by noise of variance `σ²`, the density where they are on it is `1 / (A √(2π) σ)` (of a
/// curve its length in place of the area), and energies `E` have the density `exp(-N λE/2σ²)` with the weight `λ` that follows from the noise
/// ([`weighed`](super::weight::weighed)). Less twice its logarithm, for each of the `N` points and but for what all shapes share, is `2 log A + λE/σ²`. How
/// far the points are off says nothing more where all of it may be noise (Morozov 1966): a shape that winds nearer to them is no likelier, and one
/// that bends less is not where much of it has no points, as its area says.
struct Likelihood {
    at: usize,
    weight: f64,
    /// The variance of the noise.
    noise: f64,
    /// What noise leaves at most of the mean of the squares.
    most: f64,
}

impl Likelihood {
    fn new<S: Shape + Clone>(run: &Run<'_, S>, at: usize, weight: f64, found: &Descended<S>) -> Self {
        let (points, free) = (run.points.len() as f64, 3.0 * run.held.free.len() as f64);
        let noise = run.value(&found.state).0 * points / (points - free).max(points / MOST_NOISE);
        // Of three coordinates a distance from a surface sees one, from a curve two.
        let seen = 3.0 - found.state.shape.domain().len() as f64;
        Self { at, weight, noise: noise / seen, most: noise * (1.0 + CHANCE * (2.0 / points).sqrt()) }
    }

    /// Whether noise explains how far off the points are.
    fn explains<S: Shape + Clone>(&self, run: &Run<'_, S>, state: &State<S>) -> bool {
        run.value(state).0 <= self.most
    }

    /// The less, the likelier. Cost: some thousand points.
    fn against<S: Shape + Clone>(&self, run: &mut Run<'_, S>, state: &State<S>) -> f64 {
        let own = std::mem::replace(&mut run.energies[self.at].0, self.weight);
        let energy = run.value(state).1;
        run.energies[self.at].0 = own;
        2.0 * run.measure(&state.shape).ln() + energy / self.noise
    }
}

/// Where steps with the weight as it is lead: from where they came to before, from the shape as it was given, with a larger weight before and
/// without, and from what some of the points led to.
fn ends<S: Shape + Clone>(
    run: &mut Run<'_, S>,
    at: usize,
    found: &Descended<S>,
    starts: &[S],
) -> Result<Vec<Descended<S>>> {
    let weight = run.energies[at].0;
    let mut ends = vec![run.descended(Some(found), AFRESH, ROUGH)?];
    for chain in CHAINS {
        let mut way = None::<Descended<S>>;
        for part in chain {
            run.energies[at].0 = weight * part;
            way = run.descended_if_determined(way.as_ref(), AFRESH, ROUGH)?;
            if way.is_none() {
                break;
            }
        }
        ends.extend(way);
    }
    run.energies[at].0 = weight;
    for start in starts {
        let start = run.begun(start.clone())?;
        ends.extend(run.descended_if_determined(Some(&start), AFRESH, ROUGH)?);
    }
    Ok(ends)
}

/// Those of the places with the weight as it is where the points' noise explains how far they are off, each once, and how much is against
/// it; and whether all are one. None counts that is above the shape as it was given.
fn likely<S: Shape + Clone>(
    run: &mut Run<'_, S>,
    likelihood: &Likelihood,
    ends: Vec<Descended<S>>,
) -> Result<(Vec<Place<S>>, bool)> {
    let weight = run.energies[likelihood.at].0;
    let given = run.begun(run.begin())?;
    let most = run.sum(&given);
    let (mut places, mut seen) = (Vec::new(), Vec::new());
    for found in ends {
        let (squares, energy) = run.value(&found.state);
        let place = [squares, energy, run.measure(&found.state.shape)];
        let near = |a: f64, b: f64| (a - b).abs() <= SAME * a.min(b);
        let known = seen.iter().any(|other: &[f64; 3]| (0..3).all(|k| near(other[k], place[k])));
        if known {
            continue;
        }
        seen.push(place);
        if likelihood.explains(run, &found.state) && squares + energy <= most {
            places.push(Place { against: likelihood.against(run, &found.state), weight, found });
        }
    }
    Ok((places, seen.len() == 1))
}

/// The weight with which shapes fitted to some of the points come nearest to the others, from `most` downwards no farther than to
/// `least`, and these shapes: the first that is no longer better than the one before ends the search (cross-validation, Stone 1974), and
/// of those before it the largest is taken that is as good, but for chance (Breiman and others 1984).
///
/// A shape that folds comes near to *any* points that are about, those left out among them, so that far down the distances may
/// fall again: the least that is met first on the way from stiff to soft is the one meant. A weight is beside a mean of squares, and of
/// fewer points so much larger as they are fewer.
///
/// Nothing where some of the points leave vertices open. Cost: for each weight as many steps as [`EACH`] for each part, with the
/// other parts' points.
fn best_weight<S: Shape + Clone>(
    run: &mut Run<'_, S>,
    at: usize,
    most: f64,
    least: f64,
) -> Result<Option<(f64, Vec<S>)>> {
    let parts = (0..PARTS).map(|part| [Part::of(run, part, false), Part::of(run, part, true)]);
    let mut parts: Vec<([Part; 2], Option<Descended<S>>)> = parts.map(|parts| (parts, None)).collect();
    if parts.iter().any(|(sides, _)| sides.iter().any(|side| side.points.is_empty())) {
        return Ok(None);
    }
    let own = run.energies[at].0;
    let mut tried: Vec<(f64, f64, Vec<S>)> = Vec::new();
    let mut weight = most;
    for _ in 0..WEIGHTS {
        let mut sum = 0.0;
        for ([others, left_out], state) in &mut parts {
            run.energies[at].0 = weight / others.sum;
            let found = others.with(run, |run| run.descended_if_determined(state.as_ref(), EACH, ROUGH));
            run.energies[at].0 = own;
            let Some(found) = found? else { return Ok(None) };
            let away = left_out.with(run, |run| {
                let state = run.state(found.state.shape.clone(), None)?;
                Ok::<_, FitError>(run.value(&state).0)
            })?;
            sum += away * left_out.sum;
            *state = Some(found);
        }
        let ends = tried.last().is_some_and(|(_, before, _)| sum >= *before) || weight <= least;
        let shapes = parts.iter().flat_map(|(_, state)| state).map(|found| found.state.shape.clone());
        tried.push((weight, sum, shapes.collect()));
        if ends {
            break;
        }
        weight = (weight * LESS).max(least);
    }
    let best = tried.iter().fold(f64::INFINITY, |best, (_, sum, _)| best.min(*sum));
    let alike = best * (1.0 + ALIKE * (2.0 / run.points.len() as f64).sqrt());
    Ok(tried.into_iter().find(|(_, sum, _)| *sum <= alike).map(|(weight, _, shapes)| (weight, shapes)))
}
