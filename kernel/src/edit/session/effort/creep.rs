//! Downhill where the sum has no second derivatives: slower, and it arrives all the same.

use super::super::Session;
use super::squares::{Place, dot};
use super::{LEAST, Search};
use crate::problem::EditError;
use crate::shape::Shape;

/// Steps at most, of which so many are remembered.
const CREEPS: usize = 2000;
const PAIRS: usize = 40;
/// The sum gets no less where so many steps have brought no more than this share of it.
const PATIENCE: usize = 20;
const STALLED: f64 = 1e-8;

impl<S: Shape> Session<S> {
    /// From where the search is, where the sum has no second derivatives (where a piece of a curve has shrunk to a point, its length has none), by the
    /// limited-memory method of Broyden, Fletcher, Goldfarb and Shanno with weak Wolfe steps, which arrives there all the same (Lewis and
    /// Overton 2013): until the slope is none or the sum gets no less.
    pub(super) fn creep(&mut self, search: &mut Search) -> Result<(), EditError> {
        let here = self.linearize_at(&search.at)?;
        let mut downhill = Self::slope(search, &here)?;
        let mut memory: Vec<(Place, Vec<f64>, f64)> = Vec::new();
        let mut values = vec![downhill.value];
        for _ in 0..CREEPS {
            if search.slope <= LEAST || search.looks >= search.most {
                return Ok(());
            }
            // H ∇ by two loops (Nocedal 1980), with γ W⁻¹ in the middle.
            let mut dual = downhill.down.dual.clone();
            let mut shares = Vec::with_capacity(memory.len());
            for (step, bend, product) in memory.iter().rev() {
                let share = dot(&step.d, &dual) / product;
                dual.iter_mut().zip(bend).for_each(|(q, y)| *q -= share * y);
                shares.push(share);
            }
            let mut way = Place { d: search.squares.raise(&dual), dual };
            if let Some((_, bend, product)) = memory.last() {
                let gamma = product / dot(&search.squares.raise(bend), bend);
                way = way.times(gamma);
            } else {
                way = way.times(1.0 / search.squares.largest);
            }
            for ((step, bend, product), share) in memory.iter().zip(shares.iter().rev()) {
                let back = dot(bend, &way.d) / product;
                way = way.plus(share - back, step);
            }
            let slope = -dot(&way.d, &downhill.down.dual);
            if slope >= 0.0 || slope.is_nan() {
                if memory.is_empty() {
                    break;
                }
                memory.clear();
                continue;
            }
            let (from, sloped) = (search.at.clone(), search.slope);
            let (mut low, mut high, mut share) = (0.0, f64::INFINITY, 1.0);
            let mut found = None;
            for _ in 0..50 {
                search.at = from.plus(-share, &way);
                search.looks += 2;
                let there = self.linearize_at(&search.at).and_then(|there| Self::slope(search, &there));
                match there {
                    Ok(next) if next.value <= downhill.value + 1e-4 * share * slope => {
                        if -dot(&way.d, &next.down.dual) < 0.9 * slope {
                            low = share;
                            found = Some((next, search.at.clone(), search.slope));
                        } else {
                            found = Some((next, search.at.clone(), search.slope));
                            break;
                        }
                    }
                    _ => high = share,
                }
                share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
                if high.is_finite() && high - low <= 1e-10 * high {
                    break;
                }
            }
            search.steps += 1;
            let Some((next, at, slope)) = found else {
                // Nothing less along this way: nor along the steepest one, or from there again.
                (search.at, search.slope) = (from, sloped);
                if memory.is_empty() {
                    break;
                }
                memory.clear();
                continue;
            };
            (search.at, search.slope) = (at, slope);
            let step = search.at.plus(-1.0, &from);
            let bend: Vec<f64> = next.down.dual.iter().zip(&downhill.down.dual).map(|(a, b)| a - b).collect();
            let product = dot(&step.d, &bend);
            if product > 0.0 {
                if memory.len() == PAIRS {
                    memory.remove(0);
                }
                memory.push((step, bend, product));
            }
            downhill = next;
            values.push(downhill.value);
            if let Some(earlier) = values.len().checked_sub(PATIENCE + 1).map(|k| values[k])
                && earlier - downhill.value <= STALLED * downhill.value
            {
                break;
            }
        }
        Ok(())
    }
}
