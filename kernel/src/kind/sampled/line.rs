//! A shape of one parameter as segments.

use super::{HALVED, HALVED_FOR_ANGLE, MOST, Sampler, leaps};
use crate::error::Result;
use crate::kind::facets::{Drawn, Faceted};
use crate::mesh::Polyline;
use crate::mesh::distance::from_segment;
use crate::shape::Location;

/// The segments, from one end of the domain to the other.
pub(super) fn sampled(sampler: &Sampler<'_>) -> Result<Faceted> {
    let count = sampler.start;
    let mut open: Vec<(f64, f64, u32)> =
        (0..count).rev().map(|i| (i as f64 / count as f64, (i + 1) as f64 / count as f64, 0)).collect();
    let (mut places, mut error) = (vec![0.0], 0.0_f64);
    // Depth first and in order, so that pieces come out one after another.
    while let Some((from, to, halved)) = open.pop() {
        let (apart, too_far, turns) = look(sampler, from, to)?;
        if too_far && halved >= HALVED {
            return Err(sampler.gap(0, from));
        }
        if too_far || (turns && halved < HALVED_FOR_ANGLE) {
            let middle = 0.5 * (from + to);
            open.push((middle, to, halved + 1));
            open.push((from, middle, halved + 1));
        } else {
            error = error.max(apart);
            places.push(to);
        }
        if places.len() + open.len() > MOST {
            return Err(sampler.too_many());
        }
    }
    let closed = sampler.domain[0].periodic;
    if closed {
        places.pop();
    }
    let points = |state: usize| places.iter().map(|&u| sampler.on_line(state, u)).collect::<Result<Vec<_>>>();
    let states = (0..sampler.states.len()).map(points).collect::<Result<Vec<_>>>()?;
    let line = Polyline { points: states.first().cloned().unwrap_or_default(), closed };
    let places = places.iter().map(|&u| Location::Curve(sampler.parameter(0, u))).collect();
    Ok(Faceted {
        drawn: Drawn::Line(line),
        states,
        tolerance: sampler.tolerance,
        error,
        certified: false,
        places,
        corners: Vec::new(),
    })
}

/// How far the shape is from the segment over a piece, whether that is too far in any state, and whether it turns too
/// much.
fn look(sampler: &Sampler<'_>, from: f64, to: f64) -> Result<(f64, bool, bool)> {
    let (mut worst, mut too_far, mut turns) = (0.0_f64, false, false);
    for (state, &chord) in sampler.chords.iter().enumerate() {
        let at = |k: usize| sampler.on_line(state, from + (to - from) * k as f64 / 4.0);
        let points = [at(0)?, at(1)?, at(2)?, at(3)?, sampler.on_line(state, to)?];
        for p in &points[1..4] {
            let apart = from_segment(p, &points[0], &points[4]);
            worst = worst.max(apart);
            too_far |= apart > chord;
        }
        too_far |= leaps(&points, chord);
        turns |= sampler.turns(&points[0], &points[2], &points[4]);
    }
    Ok((worst, too_far, turns))
}
