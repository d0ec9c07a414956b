//! Which knot to insert where too few vertices can move.

use super::assembly::Assembly;
use super::constraint::Constraint;
use super::metric::Metric;
use crate::Point;
use crate::functional::Shapes;
use crate::problem::Freedom;
use crate::shape::{Location, Shape, Splines};
use crate::solve::{Automatic, Solver};
use crate::spline::{Curve, Space};

/// A knot that makes the constraints independent when inserted into their curve: the middle of a span near them,
/// tried out. `None` where there is none, or they are not about one curve.
pub(crate) fn knot_that_helps(
    shapes: &Shapes<'_>,
    constraints: &[&Constraint],
    freedom: &Freedom,
) -> Option<f64> {
    let mut places = Vec::new();
    for constraint in constraints {
        match constraint.functional.location() {
            Some((0, Location::Curve(u))) => places.push(u),
            _ => return None,
        }
    }
    if shapes.len() != 1 || freedom.unknowns.is_some() {
        return None;
    }
    let curve = shapes.get(0).ok()?;
    // Knots are what splines have; only a curve's stencils are at one of them alone.
    let Splines { u: space, v: None, .. } = curve.cells()?.splines()? else { return None };
    let middle = places.iter().sum::<f64>() / places.len() as f64;
    let breaks = space.breakpoints();
    let mut candidates: Vec<f64> = breaks.windows(2).map(|s| 0.5 * (s[0] + s[1])).collect();
    candidates.sort_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
    // The influence of a knot reaches p spans: farther ones cannot help.
    candidates.truncate(2 * space.degree() + 2);
    let rank = |curve: &dyn Shape, freedom: &Freedom| -> Option<(usize, usize)> {
        let shapes = Shapes::one(curve);
        let assembly = Assembly::new(&shapes, constraints, freedom, &Metric::Least).ok()?;
        let factored = Automatic.factor(&assembly.system).ok()?;
        Some((factored.diagnosis().rank, assembly.system.rows().len()))
    };
    let (before, _) = rank(curve, freedom)?;
    for knot in candidates {
        let Some((refined, shifted)) = with_knot(space, freedom, knot) else { continue };
        if rank(&refined, &shifted).is_some_and(|(after, rows)| after > before && after == rows) {
            // A rounder number that is in the same span serves as well and reads better.
            return Some(round_within(space, knot));
        }
    }
    None
}

/// A curve on the space with one more knot (its points do not matter for rank), and the locks on it.
fn with_knot(space: &Space, freedom: &Freedom, knot: f64) -> Option<(Curve, Freedom)> {
    let mut knots = space.knots().to_vec();
    let at = knots.partition_point(|&k| k <= knot);
    knots.insert(at, knot);
    let p = space.degree();
    let refined =
        if space.is_periodic() { Space::periodic(p, knots).ok()? } else { Space::open(p, knots).ok()? };
    // Vertices before the span's first function stay, later ones move up by one; the new one is free.
    let first = space.vertex(space.span(knot) - p);
    let shift = |v: &usize| if *v > first { v + 1 } else { *v };
    let moved = Freedom {
        locked: freedom.locked.iter().map(shift).collect(),
        only: freedom.only.as_ref().map(|only| {
            let mut only: Vec<usize> = only.iter().map(shift).chain([first + 1]).collect();
            only.sort_unstable();
            only.dedup();
            only
        }),
        within: freedom.within,
        ..Freedom::default()
    };
    let points = (0..refined.len()).map(|i| Point::new(i as f64, (i % 3) as f64, 0.0)).collect();
    Some((Curve::new(refined, points).ok()?, moved))
}

fn round_within(space: &Space, knot: f64) -> f64 {
    let span = space.span(knot);
    let (low, high) = (space.flat()[span], space.flat()[span + 1]);
    let step = 10_f64.powf((0.25 * (high - low)).log10().floor());
    let rounded = (knot / step).round() * step;
    // Only where the division is exact enough to print shortly.
    let short: f64 = format!("{rounded:.12}").parse().unwrap_or(knot);
    if short > low && short < high { short } else { knot }
}
