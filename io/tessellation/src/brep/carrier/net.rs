//! How the patches of a carrier hang together: what meets along lines and at poles, and where it has a crease.

use loftsman_kernel::Vector;

use crate::patch::{Homogeneous, Patch, project};

/// A jump of the first derivative over the spans around a knot that is more than this part of the tolerance is a crease.
pub(super) const CREASE: f64 = 0.05;

/// The patches of a surface side by side.
pub(super) struct Net<'p> {
    pub(super) patches: &'p [Patch],
    pub(super) counts: [usize; 2],
    /// How near to each other points are one.
    pub(super) one: f64,
}

impl Net<'_> {
    fn patch(&self, direction: usize, along: usize, across: usize) -> &Patch {
        let [i, j] = if direction == 0 { [along, across] } else { [across, along] };
        &self.patches[i * self.counts[1] + j]
    }

    /// The sides of patches at the low and at the high end of a direction.
    fn side(direction: usize, end: usize) -> usize {
        [[3, 1], [0, 2]][direction][end]
    }

    /// The point that a side of the domain is.
    pub(super) fn pole(&self, direction: usize, end: usize) -> Option<Vector> {
        let along = [0, self.counts[direction] - 1][end];
        let points = (0..self.counts[1 - direction]).flat_map(|across| {
            self.patch(direction, along, across).side(Self::side(direction, end)).map(project)
        });
        let mut points = points;
        let first = points.next()?;
        points.all(|p| (p - first).norm() <= self.one).then_some(first)
    }

    /// Whether the patches `before` end where those `after` begin.
    pub(super) fn meets(&self, direction: usize, before: usize, after: usize) -> bool {
        (0..self.counts[1 - direction]).all(|across| {
            let a = self.patch(direction, before, across).side(Self::side(direction, 1));
            let b = self.patch(direction, after, across).side(Self::side(direction, 0));
            let scale =
                |mut side: Box<dyn Iterator<Item = &Homogeneous> + '_>| side.next().map_or(1.0, |h| h[3]);
            let (wa, wb) = (scale(Box::new(a.clone())), scale(Box::new(b.clone())));
            a.zip(b).all(|(x, y)| {
                let (x3, y3) = (x[3] / wa, y[3] / wb);
                (project(x) - project(y)).norm() <= self.one && (x3 - y3).abs() <= 1e-6 * x3.max(y3)
            })
        })
    }

    /// The most that the first derivative across a knot line jumps by: with the jump `(D, d)` of `(A, W)`'s derivative,
    /// that of `A / W` is `(D W - A d) / W²`, whose numerator is bounded by its Bézier points.
    pub(super) fn jump(&self, direction: usize, k: usize, [before, after]: [f64; 2]) -> f64 {
        let mut most = 0.0_f64;
        for across in 0..self.counts[1 - direction] {
            let (one, other) = (self.patch(direction, k - 1, across), self.patch(direction, k, across));
            let lines = |patch: &Patch, last: bool| -> [Vec<Homogeneous>; 2] {
                let (p, q) = (patch.rows, patch.columns);
                let order = [p, q][direction];
                let row = |r: usize| -> Vec<Homogeneous> {
                    if direction == 0 {
                        patch.net[r * q..(r + 1) * q].to_vec()
                    } else {
                        (0..p).map(|i| patch.net[i * q + r]).collect()
                    }
                };
                if last { [row(order - 2), row(order - 1)] } else { [row(0), row(1)] }
            };
            let degree = [one.rows, one.columns][direction] as f64 - 1.0;
            let [inner, edge] = lines(one, true);
            let [start, next] = lines(other, false);
            // Patches scale their weights on their own.
            let same = edge[0][3] / start[0][3];
            let slope = |k: usize, l: usize| {
                degree * ((next[k][l] - start[k][l]) * same / after - (edge[k][l] - inner[k][l]) / before)
            };
            let order = edge.len();
            let light = edge.iter().map(|h| h[3]).fold(f64::INFINITY, f64::min);
            let binomials = |n: usize| {
                let mut row = vec![1.0; n + 1];
                for i in 1..=n {
                    row[i] = row[i - 1] * (n + 1 - i) as f64 / i as f64;
                }
                row
            };
            let (single, double) = (binomials(order - 1), binomials(2 * order - 2));
            let mut product = vec![Vector::zeros(); 2 * order - 1];
            for a in 0..order {
                let d = [0, 1, 2, 3].map(|l| slope(a, l));
                let d = (Vector::new(d[0], d[1], d[2]), d[3]);
                for b in 0..order {
                    let h = &edge[b];
                    let share = single[a] * single[b] / double[a + b];
                    product[a + b] += (d.0 * h[3] - Vector::new(h[0], h[1], h[2]) * d.1) * share;
                }
            }
            let largest = product.iter().map(Vector::norm).fold(0.0, f64::max);
            most = most.max(largest / (light * light));
        }
        // What is left of equal derivatives after rounding.
        let rounding = 1e-12 / before.min(after);
        if most <= rounding { 0.0 } else { most }
    }
}
