//! How far a shape is stretched anywhere, not only where its energy is summed up.

use loftsman_kernel::shape::{Cell, Location, Shape, cells_of, rows_at};
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use crate::error::Result;
use crate::points::order;

/// Between the ends of a span so many places more than its degree (of a curve, twice its degree) are looked at.
const MORE: usize = 6;
/// The ends of spans are looked at from within.
const WITHIN: f64 = 1e-9;
/// Where a shape's speed at rest is less than this share of the largest, it has no length there.
const COLLAPSED: f64 = 1e-9;
/// A peak is found to this share of its span: of what it is, to the square of that, or this where it is sharp.
const FINE: f64 = 1e-6;
/// Stretches that differ by less are the same: what is stretched alike everywhere has no peaks.
const ALIKE: f64 = 1e-9;
/// More than so many places are not looked at for one peak.
const MOST: usize = 2000;

/// The largest stretch (by its amount, with its sign) of a shape that had the control vertices `first` at the start, `rest` times as long at rest: of a curve
/// `|P'|/ℓ - 1`; of a surface in any direction, the principal stretches `√μ - 1`, `μ` being the eigenvalues of `G` relative to `G` at rest, with
/// `G_ij = P_i·P_j`. Looked at in `2 degree + 7` places of every span of a curve, `degree + 7` in each direction of a surface, its ends among them;
/// from each of these places that no neighbour exceeds, and that may come to be the largest, it climbs on to its peak, by steps that are halved.
/// `O(w)` for each place.
pub(crate) fn largest(shape: &dyn Shape, first: &[Point], rest: f64) -> Result<f64> {
    let cells = cells_of(shape, "a stretch")?.checked(shape)?;
    let mut looks = Vec::with_capacity(cells.len());
    let mut longest = 0.0_f64;
    for cell in &cells {
        let look = Look::new(shape, cell, first, rest);
        let grid = look.grid()?;
        longest = grid.iter().fold(longest, |most, place| most.max(place.size));
        looks.push((look, grid));
    }
    // The peaks of the grids, the highest first: of the larger stretch, and of the smaller one as what it lacks.
    let mut peaks = Vec::new();
    for (index, (look, grid)) in looks.iter_mut().enumerate() {
        look.least = COLLAPSED * longest;
        for which in [Which::Larger, Which::Smaller] {
            for at in 0..grid.len() {
                let own = look.amount(&grid[at], which);
                let around = look.around(at).map(|other| look.amount(&grid[other], which));
                let (highest, lowest) = around.fold((own, own), |(high, low), v| {
                    (high.max(v), if v.is_finite() { low.min(v) } else { low })
                });
                if own.is_finite() && own >= highest {
                    peaks.push((own, 2.0 * own - lowest, index, at, which));
                }
            }
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.2, a.3).cmp(&(b.2, b.3))));
    let (mut found, mut best) = (0.0_f64, f64::NEG_INFINITY);
    for (own, reach, index, at, which) in peaks {
        // A smooth peak is higher than what was looked at by no more than that is than its neighbours.
        if reach <= best + ALIKE * (1.0 + best.abs()) {
            continue;
        }
        let amount = looks[index].0.climb(at, own, which)?;
        best = best.max(amount);
        let stretch = which.sign() * amount;
        if stretch.abs() > found.abs() {
            found = stretch;
        }
    }
    Ok(found)
}

/// Which of the two principal stretches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Which {
    Larger,
    Smaller,
}

impl Which {
    fn sign(self) -> f64 {
        match self {
            Self::Larger => 1.0,
            Self::Smaller => -1.0,
        }
    }
}

/// What was seen at a place: the length or area at rest of a unit of parameters, and the principal stretches, the larger one first.
#[derive(Debug, Clone, Copy)]
struct Seen {
    size: f64,
    stretches: [f64; 2],
}

/// A look at one cell.
#[derive(Debug)]
struct Look<'a> {
    shape: &'a dyn Shape,
    cell: &'a Cell,
    first: &'a [Point],
    rest: f64,
    /// Places of the grid in each direction.
    counts: [usize; 2],
    /// What is smaller has no length.
    least: f64,
}

impl<'a> Look<'a> {
    fn new(shape: &'a dyn Shape, cell: &'a Cell, first: &'a [Point], rest: f64) -> Self {
        let times = if cell.sides.len() == 1 { 2 } else { 1 };
        let count = |k: usize| cell.sides.get(k).map_or(1, |side| times * side.degree + 1 + MORE);
        Self { shape, cell, first, rest, counts: [count(0), count(1)], least: 0.0 }
    }

    /// The share of each side where a place of the grid is.
    fn shares(&self, at: usize) -> [f64; 2] {
        let share = |i: usize, n: usize| WITHIN + (1.0 - 2.0 * WITHIN) * i as f64 / (n - 1).max(1) as f64;
        [share(at / self.counts[1], self.counts[0]), share(at % self.counts[1], self.counts[1])]
    }

    /// The neighbours of a place of the grid.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let [rows, columns] = self.counts;
        let (row, column) = (at / columns, at % columns);
        let near = |i: usize, n: usize| i.saturating_sub(1)..(i + 2).min(n);
        near(row, rows)
            .flat_map(move |i| near(column, columns).map(move |j| i * columns + j))
            .filter(move |other| *other != at)
    }

    fn grid(&self) -> Result<Vec<Seen>> {
        let shares: Vec<[f64; 2]> = (0..self.counts[0] * self.counts[1]).map(|at| self.shares(at)).collect();
        self.see(&shares)
    }

    /// By how much it is stretched (or compressed, where that is asked for); nothing where it has no length.
    fn amount(&self, seen: &Seen, which: Which) -> f64 {
        let stretch = which.sign() * seen.stretches[usize::from(which == Which::Smaller)];
        if seen.size > self.least && stretch.is_finite() { stretch } else { f64::NEG_INFINITY }
    }

    /// From a place of the grid on to the peak: to the best of all neighbours as long as one is better, by steps that are halved where none is.
    fn climb(&self, at: usize, own: f64, which: Which) -> Result<f64> {
        let mut here = self.shares(at);
        let mut step = self.counts.map(|count| 0.5 / (count - 1).max(1) as f64);
        let (mut best, mut looked) = (own, 0);
        let across: &[i32] = if self.cell.sides.len() == 1 { &[0] } else { &[-1, 0, 1] };
        while step[0] > FINE && looked < MOST {
            let around: Vec<[f64; 2]> = [-1, 0, 1]
                .iter()
                .flat_map(|i| across.iter().map(move |j| [*i, *j]))
                .filter(|by| *by != [0, 0])
                .map(|by| {
                    std::array::from_fn(|k| {
                        let to = here[k] + f64::from(by[k]) * step[k];
                        if self.counts[k] > 1 { to.clamp(WITHIN, 1.0 - WITHIN) } else { here[k] }
                    })
                })
                .collect();
            looked += around.len();
            let mut better = None;
            for (seen, place) in self.see(&around)?.iter().zip(&around) {
                let amount = self.amount(seen, which);
                if amount > best {
                    (best, better) = (amount, Some(*place));
                }
            }
            match better {
                Some(place) => here = place,
                None => step = step.map(|step| 0.5 * step),
            }
        }
        Ok(best)
    }

    /// What is at these shares of the sides.
    fn see(&self, shares: &[[f64; 2]]) -> Result<Vec<Seen>> {
        let Self { shape, cell, first, rest, .. } = *self;
        let now = shape.control_vertices();
        let points: Vec<(Location, f64)> = shares.iter().map(|shares| (cell.at(*shares), 0.0)).collect();
        let width = cell.vertices.len();
        let rows = (0..cell.sides.len())
            .map(|k| rows_at(shape, cell, &points, order(k, 1)))
            .collect::<loftsman_kernel::Result<Vec<_>>>()?;
        let seen = (0..points.len()).map(|point| {
            let tangents = |of: &[Point]| -> SmallVec<[Vector; 2]> {
                let along = |row: &Vec<f64>| {
                    let row = row[point * width..][..width].iter().zip(&cell.vertices);
                    row.fold(Vector::zeros(), |sum, (c, &v)| sum + of[v].coords * *c)
                };
                rows.iter().map(along).collect()
            };
            let (metric, own) = (metric(&tangents(first)), metric(&tangents(now)));
            let size = (metric[0] * metric[2] - metric[1] * metric[1]).max(0.0).sqrt();
            // Eigenvalues of the metric in an orthonormal frame of that at rest, by differences, so that equal ones come out equal: of a curve
            // its one, twice.
            let lower = [metric[0].sqrt(), metric[1] / metric[0].sqrt(), size / metric[0].sqrt()];
            let a = own[0] / metric[0];
            let b = (own[1] - lower[1] * own[0] / lower[0]) / size;
            let slant = lower[1] / lower[0];
            let c = (own[2] - 2.0 * slant * own[1] + slant * slant * own[0]) / (lower[2] * lower[2]);
            let (half, root) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
            let stretches = [half + root, half - root].map(|value| value.max(0.0).sqrt() / rest - 1.0);
            Seen { size, stretches }
        });
        Ok(seen.collect())
    }
}

/// `P_u·P_u`, `P_u·P_v`, `P_v·P_v`; of a curve as if it were as stretched across as along.
fn metric(tangents: &[Vector]) -> [f64; 3] {
    match tangents {
        [u, v] => [u.dot(u), u.dot(v), v.dot(v)],
        all => {
            let square = all.first().map_or(0.0, |t| t.dot(t));
            [square, 0.0, square]
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::{Curve, Space, Surface};

    use super::*;

    /// Simple shear by γ: principal stretches `√(1 + γ²/4) ± γ/2`, wherever and whichever way the parameters run.
    #[test]
    fn a_sheared_sheet_is_stretched_along_its_diagonal() {
        let space = Space::clamped_uniform(3, 6).unwrap();
        let points: Vec<Point> = (0..36)
            .map(|k| (space.greville(k / 6), space.greville(k % 6)))
            .map(|(u, v)| Point::new(u + 0.4 * v, 2.0 * v - 0.3 * u, 0.0))
            .collect();
        for (shear, rest) in [(0.0, 1.0), (0.3, 1.0), (-0.8, 1.2)] {
            let sheared = points.iter().map(|p| Point::new(p.x + shear * p.y, p.y, 0.0)).collect();
            let sheet = Surface::new(space.clone(), space.clone(), sheared).unwrap();
            let found = largest(&sheet, &points, rest).unwrap();
            let stretches = [0.5, -0.5]
                .map(|half: f64| ((1.0_f64 + 0.25 * shear * shear).sqrt() + half * shear.abs()) / rest - 1.0);
            let wanted = if stretches[0].abs() > stretches[1].abs() { stretches[0] } else { stretches[1] };
            assert!((found - wanted).abs() < 1e-9, "{shear} {rest}: {found} {wanted}");
        }
    }

    /// A quadratic piece whose speed is `2 + 4 t` against 2 at the start is stretched most at its end, where no Gauss point is.
    #[test]
    fn the_end_of_a_span_counts() {
        let space = Space::clamped_uniform(2, 3).unwrap();
        let line = |x: [f64; 3]| x.map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let curve = Curve::new(space, line([0.0, 1.0, 4.0])).unwrap();
        let found = largest(&curve, &line([0.0, 1.0, 2.0]), 1.0).unwrap();
        assert!((found - 2.0).abs() < 1e-6, "{found}");
    }

    /// Curves of every kind, shaken: what is told is what a very dense sampling finds, and no less.
    #[test]
    fn no_dense_sampling_finds_more() {
        let mut seed = 7_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        for round in 0..120 {
            let degree = [1, 2, 3, 4, 5, 6, 7, 25][round % 8];
            let n = degree + 2 + round % 7;
            let space = match round % 3 {
                0 => Space::clamped_uniform(degree, n),
                1 => Space::floating_uniform(degree, n),
                _ => Space::periodic_uniform(degree, n),
            }
            .unwrap();
            let first: Vec<Point> = (0..n)
                .map(|i| {
                    let t = i as f64 / n as f64 * if round % 3 == 2 { std::f64::consts::TAU } else { 3.0 };
                    if round % 3 == 2 {
                        Point::new(t.cos(), t.sin(), 0.2 * random())
                    } else {
                        Point::new(t, t.sin(), 0.0)
                    }
                })
                .collect();
            let by = [0.05, 0.3, 1.5][round % 3] / if degree == 25 { 10.0 } else { 1.0 };
            let now: Vec<Point> = first
                .iter()
                .map(|p| p * 1.02 + Vector::new(random(), random(), random()) * by / n as f64)
                .collect();
            let weights: Option<Vec<f64>> =
                (round % 4 == 1).then(|| (0..n).map(|_| 1.2 + random()).collect());
            let before = Curve::build(space.clone(), first.clone(), weights.clone()).unwrap();
            let after = Curve::build(space.clone(), now, weights).unwrap();
            let rest = 1.0 + 0.2 * random();
            let (a, b) = space.domain();
            let dense = (0..=8_000).map(|k| a + (b - a) * f64::from(k) / 8_000.0).map(|u| {
                after.derivative(u, 1).unwrap().norm() / before.derivative(u, 1).unwrap().norm() / rest - 1.0
            });
            let dense = dense.fold(0.0_f64, |most, s| if s.abs() > most.abs() { s } else { most });
            let found = largest(&after, &first, rest).unwrap();
            let what = format!("{round}, degree {degree}, {n}: {found} told, {dense} seen");
            assert!(found.abs() >= dense.abs() * (1.0 - 1e-6) - 1e-9, "{what}");
            assert!(found.abs() <= dense.abs() * (1.0 + 1e-3) + 1e-9, "{what}");
        }
    }

    /// Sheets of every degree: against the eigenvalues at 25 by 25 places of each cell.
    #[test]
    fn no_dense_sampling_of_a_sheet_finds_more() {
        let shaken = |k: usize, by: f64| ((k * k) as f64 * 0.7 + 1.3 * k as f64).sin() * by;
        for round in 0..24 {
            let (p, q) = (1 + round % 4, 1 + (round / 4) % 3);
            let (n, m) = (p + 2 + round % 3, q + 2);
            let space = |degree: usize, n: usize| Space::clamped_uniform(degree, n).unwrap();
            let (u, v) = (space(p, n), space(q, m));
            let first: Vec<Point> = (0..n * m)
                .map(|k| (u.greville(k / m), v.greville(k % m), k))
                .map(|(x, y, k)| Point::new(x + 0.2 * y + shaken(k + round, 0.05), y, 0.3 * x * y))
                .collect();
            let now: Vec<Point> = first
                .iter()
                .enumerate()
                .map(|(k, p)| p + Vector::new(shaken(k, 0.2), shaken(3 * k + 1, 0.2), shaken(5 * k + 2, 0.2)))
                .collect();
            let weights: Option<Vec<f64>> =
                (round % 3 == 0).then(|| (0..n * m).map(|k| 1.2 + shaken(k, 0.4)).collect());
            let before = Surface::build(u.clone(), v.clone(), first.clone(), weights.clone()).unwrap();
            let after = Surface::build(u.clone(), v.clone(), now, weights).unwrap();
            let metric = |of: &Surface, at: Location| {
                let d = [0, 1].map(|k| of.value(at, order(k, 1)).unwrap());
                nalgebra::Matrix2::new(d[0].dot(&d[0]), d[0].dot(&d[1]), d[1].dot(&d[0]), d[1].dot(&d[1]))
            };
            let mut dense = 0.0_f64;
            for cell in cells_of(&after, "a test").unwrap().checked(&after).unwrap() {
                for k in 0..625 {
                    let share = |i: usize| (i as f64 / 24.0).clamp(1e-9, 1.0 - 1e-9);
                    let at = cell.at([share(k / 25), share(k % 25)]);
                    let half = metric(&before, at).cholesky().unwrap().l().try_inverse().unwrap();
                    let own = half * metric(&after, at) * half.transpose();
                    for value in own.symmetric_eigenvalues().iter() {
                        let stretch = value.max(0.0).sqrt() - 1.0;
                        dense = if stretch.abs() > dense.abs() { stretch } else { dense };
                    }
                }
            }
            let found = largest(&after, &first, 1.0).unwrap();
            let what = format!("{round}, degrees {p} and {q}: {found} told, {dense} seen");
            assert!(found.abs() >= dense.abs() * (1.0 - 1e-9), "{what}");
            assert!(found.abs() <= dense.abs() * 1.05, "{what}");
        }
    }
}
