//! The removal of knots from a control net, pass after pass.

use super::passes::{Gone, State};
use super::sweep::{Limits, Measure, Rows};
use crate::Point;
use crate::error::{Error, Result};
use crate::spline::Space;

/// Passes over all knots, each with the share of the tolerance that a single removal may take: what costs least goes
/// first, so that a knot that matters is not given up for one that does not. A pass counts errors with caution, and
/// a further one may still find room.
pub(super) const ALL: &[f64] = &[1e-6, 1e-4, 1e-2, 1e-1, 1.0, 1.0, 1.0];

/// The one pass that copies of a single knot need.
pub(super) const ONE: &[f64] = &[1.0];

/// Rounds of refinement, and the deviation, as a share of the largest coordinate, up to which it may be rounding's.
const REFINEMENTS: usize = 4;
const ROUNDING: f64 = 1e-7;

/// A control net along one direction: an array of `outer × n × inner` vertices.
pub(super) struct Net<'a> {
    pub(super) space: &'a Space,
    pub(super) points: &'a [Point],
    pub(super) weights: Option<&'a [f64]>,
    pub(super) outer: usize,
    pub(super) inner: usize,
}

/// New space, points and weights, knots removed, deviation.
pub(super) type Outcome = (Space, Vec<Point>, Option<Vec<f64>>, usize, f64);

impl Net<'_> {
    /// Removes what `copies(value, multiplicity)` wants and the tolerance allows.
    pub(super) fn remove(
        &self,
        tolerance: f64,
        passes: &[f64],
        copies: impl Fn(f64, usize) -> usize,
    ) -> Result<Outcome> {
        if tolerance.is_nan() || tolerance < 0.0 {
            return Err(Error::Invalid(format!(
                "the tolerance {tolerance} is no length: give zero or a positive number"
            )));
        }
        let rows = self.rows();
        let measure = self.measure(tolerance);
        let n = self.space.len();
        let mut state = State {
            space: self.space.clone(),
            rows: rows.clone(),
            errors: vec![0.0; n],
            kept: (0..n).map(Some).collect(),
        };
        let mut gone =
            Gone { knots: Vec::new(), domain: self.space.domain(), closed: self.space.is_periodic() };
        let mut deviation = 0.0;
        for &share in passes {
            let limits = Limits {
                degree: self.space.degree(),
                first_row: 0,
                rows_after: 0,
                tolerance,
                each: share * tolerance,
            };
            // The copies that earlier passes removed count.
            let allowance = |knot: f64, multiplicity: usize| {
                let already = gone.count(knot);
                let total = copies(knot, multiplicity + already).saturating_sub(already);
                // A periodic space starts at a knot, which stays.
                let stays = usize::from(gone.closed && knot == gone.domain.0);
                total.min(multiplicity.saturating_sub(stays))
            };
            let removed = state.pass(&measure, &limits, allowance)?;
            if removed.is_empty() {
                continue;
            }
            gone.extend(removed);
            let back = state.space.inserting(&gone.knots)?;
            deviation = state.measure_against(&rows, &measure, &back);
        }
        if !gone.knots.is_empty() {
            deviation = self.refine(&mut state, &rows, &measure, &gone, deviation)?;
        }
        let (points, weights) = self.vertices_of(&state);
        Ok((state.space, points, weights, gone.knots.len(), deviation))
    }

    /// Takes away what rounding has left, and gives the deviation then.
    ///
    /// Removing many copies of a knot loses digits: vertices far apart from one Bézier piece's few are extrapolated, by
    /// about `2^p`. Where nothing but that is left of the deviation, it is removed from the given shape's difference to the
    /// new one in turn, and the result added (iterative refinement); each round is kept only if it is better.
    fn refine(
        &self,
        state: &mut State,
        rows: &Rows,
        measure: &Measure,
        gone: &Gone,
        mut deviation: f64,
    ) -> Result<f64> {
        let size = self.points.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let back = state.space.inserting(&gone.knots)?;
        for _ in 0..REFINEMENTS {
            if !(deviation > 8.0 * f64::EPSILON * size && deviation <= ROUNDING * size) {
                break;
            }
            let mut rest = State {
                space: self.space.clone(),
                rows: Rows { width: rows.width, data: state.difference(rows, &back) },
                errors: vec![0.0; self.space.len()],
                kept: vec![None; self.space.len()],
            };
            // Differences of weights are no weights: pairs of numbers, whose sign does not matter.
            let measure_rest =
                Measure { size: if measure.size == 4 { 2 } else { 3 }, weight: 1.0, ..*measure };
            let limits = Limits {
                degree: self.space.degree(),
                first_row: 0,
                rows_after: 0,
                tolerance: f64::INFINITY,
                each: f64::INFINITY,
            };
            rest.pass(&measure_rest, &limits, |knot, _| gone.count(knot))?;
            if rest.space != state.space {
                break;
            }
            let mut better = State {
                space: state.space.clone(),
                rows: state.rows.clone(),
                errors: state.errors.clone(),
                kept: state.kept.clone(),
            };
            for k in (0..better.rows.len()).filter(|&k| better.kept[k].is_none()) {
                let range = k * rows.width..(k + 1) * rows.width;
                better.rows.data[range].iter_mut().zip(rest.rows.row(k)).for_each(|(x, d)| *x += d);
            }
            let sound = |v: &[f64]| v.iter().all(|x| x.is_finite()) && v.get(3).is_none_or(|&w| w > 0.0);
            if !better.rows.data.chunks_exact(measure.size).all(sound) {
                break;
            }
            let left = better.measure_against(rows, measure, &back);
            if left.is_nan() || left >= deviation {
                break;
            }
            (*state, deviation) = (better, left);
        }
        Ok(deviation)
    }

    /// The vertices as rows across the direction, homogeneous where rational.
    fn rows(&self) -> Rows {
        let size = if self.weights.is_some() { 4 } else { 3 };
        let (n, lines) = (self.space.len(), self.outer * self.inner);
        let mut rows = Rows { width: size * lines, data: Vec::with_capacity(size * lines * n) };
        for k in 0..n {
            for line in 0..lines {
                let i = self.index(line, k, n);
                let weight = self.weights.map_or(1.0, |w| w[i]);
                rows.data.extend(self.points[i].coords.iter().map(|c| c * weight));
                rows.data.extend(self.weights.map(|w| w[i]));
            }
        }
        rows
    }

    /// Where vertex `k` of a line is in an array with `n` vertices along the direction.
    fn index(&self, line: usize, k: usize, n: usize) -> usize {
        (line / self.inner * n + k) * self.inner + line % self.inner
    }

    fn vertices_of(&self, state: &State) -> (Vec<Point>, Option<Vec<f64>>) {
        let (n, lines) = (state.space.len(), self.outer * self.inner);
        let mut points = vec![Point::origin(); n * lines];
        let mut weights = self.weights.map(|_| vec![1.0; n * lines]);
        let size = state.rows.width / lines;
        for k in 0..n {
            for line in 0..lines {
                let to = self.index(line, k, n);
                // Vertices that stay do so to the last bit.
                if let Some(old) = state.kept[k] {
                    let from = self.index(line, old, self.space.len());
                    points[to] = self.points[from];
                    if let (Some(weights), Some(old)) = (&mut weights, self.weights) {
                        weights[to] = old[from];
                    }
                    continue;
                }
                let v = &state.rows.row(k)[line * size..(line + 1) * size];
                let weight = v.get(3).copied().unwrap_or(1.0);
                points[to] = Point::new(v[0] / weight, v[1] / weight, v[2] / weight);
                if let Some(weights) = &mut weights {
                    weights[to] = weight;
                }
            }
        }
        (points, weights)
    }

    fn measure(&self, tolerance: f64) -> Measure {
        let Some(weights) = self.weights else {
            return Measure { size: 3, center: [0.0; 3], radius: 0.0, weight: 1.0 };
        };
        let (mut low, mut high) = (self.points[0], self.points[0]);
        for p in self.points {
            (low, high) = (low.inf(p), high.sup(p));
        }
        let center = nalgebra::center(&low, &high);
        Measure {
            size: 4,
            center: center.coords.into(),
            // The new shape, which is meant, is at most the tolerance further out than the old one.
            radius: (high - center).norm() + tolerance,
            weight: weights.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }
}
