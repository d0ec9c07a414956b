//! One pass of knot removal over an open or a periodic space.

use nalgebra::DMatrix;

use super::sweep::{Limits, Measure, Rows, Strip, largest};
use crate::error::Result;
use crate::spline::space::periodic_knot;
use crate::spline::{Conversion, Space};

/// The knots removed so far, ascending; as they were, so that inserting them again gives back the old space.
pub(super) struct Gone {
    pub(super) knots: Vec<f64>,
    pub(super) domain: (f64, f64),
    pub(super) closed: bool,
}

impl Gone {
    pub(super) fn extend(&mut self, knots: Vec<f64>) {
        self.knots.extend(knots);
        self.knots.sort_by(f64::total_cmp);
    }

    /// How many copies of a knot are gone; of the seam, those at the end of the period count as well.
    pub(super) fn count(&self, knot: f64) -> usize {
        let run = |u: f64| {
            let at = self.knots.partition_point(|&k| k < u);
            self.knots[at..].iter().take_while(|&&k| k == u).count()
        };
        run(knot) + if self.closed && knot == self.domain.0 { run(self.domain.1) } else { 0 }
    }
}

/// The shape between passes.
pub(super) struct State {
    pub(super) space: Space,
    pub(super) rows: Rows,
    pub(super) errors: Vec<f64>,
    pub(super) kept: Vec<Option<usize>>,
}

impl State {
    /// One pass; the knots removed.
    pub(super) fn pass(
        &mut self,
        measure: &Measure,
        limits: &Limits,
        allowance: impl Fn(f64, usize) -> usize,
    ) -> Result<Vec<f64>> {
        let p = self.space.degree();
        if !self.space.is_periodic() {
            let given = Strip {
                knots: self.space.flat().to_vec(),
                rows: std::mem::take(&mut self.rows),
                errors: std::mem::take(&mut self.errors),
                kept: std::mem::take(&mut self.kept),
            };
            let (done, removed) = Strip::sweep(&given, limits, measure, |_, u, s| allowance(u, s));
            self.space = Space::open(p, done.knots)?;
            (self.rows, self.errors, self.kept) = (done.rows, done.errors, done.kept);
            return Ok(removed.iter().flat_map(|&(i, c)| std::iter::repeat_n(given.knots[i], c)).collect());
        }
        let mut gone = Gone { knots: Vec::new(), domain: self.space.domain(), closed: true };
        // Two ways round, cut open at opposite places, since knots near a cut cannot be removed.
        for half in [0, 1] {
            if self.space.len() < 4 * p + 4 {
                let found = self.remove_from_short_period(measure, limits, &allowance, &gone)?;
                gone.extend(found);
                break;
            }
            let cut = half * self.space.len() / 2;
            let found = self.sweep_round(cut, measure, limits, |u, s| {
                let spent = gone.count(u);
                allowance(u, s + spent).saturating_sub(spent)
            })?;
            gone.extend(found);
        }
        Ok(gone.knots)
    }

    /// A sweep over a periodic space cut open at knot `cut`.
    fn sweep_round(
        &mut self,
        cut: usize,
        measure: &Measure,
        limits: &Limits,
        allowance: impl Fn(f64, usize) -> usize,
    ) -> Result<Vec<f64>> {
        let (p, n) = (self.space.degree(), self.space.len());
        let (start, end) = self.space.domain();
        let knots = self.space.knots();
        let line = |k: usize| (cut + k) as isize - p as isize;
        let vertex = |k: usize| line(k).rem_euclid(n as isize) as usize;
        let mut given = Strip {
            knots: (0..=n + 2 * p).map(|k| periodic_knot(knots, line(k))).collect(),
            rows: Rows { width: self.rows.width, data: Vec::with_capacity((n + p) * self.rows.width) },
            ..Strip::default()
        };
        for k in 0..n + p {
            given.rows.push(self.rows.row(vertex(k)));
            given.errors.push(self.errors[vertex(k)]);
            given.kept.push(self.kept[vertex(k)]);
        }
        // The first p and the last p vertices are the same ones: what changes must be strictly between.
        let limits = Limits { first_row: p, rows_after: p, ..*limits };
        let value = |u: f64, k: usize| if u == end { start } else { knots[vertex(k)] };
        let (done, removed) = Strip::sweep(&given, &limits, measure, |k, u, s| allowance(value(u, k), s));
        // Which knots of the period stay: of the copies at the seam, the first of the period always.
        let mut stays = vec![true; n];
        let mut gone = Vec::new();
        for (first, count) in removed {
            let u = given.knots[first];
            let run = (first..).take_while(|&k| given.knots.get(k) == Some(&u));
            for i in run.map(vertex).filter(|&i| i != 0).take(count) {
                stays[i] = false;
                gone.push(knots[i]);
            }
        }
        let mut left: Vec<f64> = (0..n).filter(|&i| stays[i]).map(|i| knots[i]).collect();
        left.push(end);
        let m = left.len() - 1;
        // Vertex k of the line's period belongs to the k-th knot that stays from the cut on.
        let offset = stays[..cut].iter().filter(|&&s| s).count();
        self.space = Space::periodic(p, left)?;
        let row = |i: usize| p + (i + m - offset % m) % m;
        let mut rows = Rows { width: self.rows.width, data: Vec::with_capacity(m * self.rows.width) };
        (0..m).for_each(|i| rows.push(done.rows.row(row(i))));
        self.rows = rows;
        self.errors = (0..m).map(|i| done.errors[row(i)]).collect();
        self.kept = (0..m).map(|i| done.kept[row(i)]).collect();
        Ok(gone)
    }

    /// Removal where functions reach round the whole period: one knot after the other by dense least squares.
    fn remove_from_short_period(
        &mut self,
        measure: &Measure,
        limits: &Limits,
        allowance: impl Fn(f64, usize) -> usize,
        before: &Gone,
    ) -> Result<Vec<f64>> {
        let (start, _) = self.space.domain();
        let mut gone: Vec<f64> = Vec::new();
        let mut breakpoints = self.space.breakpoints();
        breakpoints.pop();
        for u in breakpoints {
            let mut copies = 0;
            while self.space.len() > 2 {
                let spent = before.count(u) + copies;
                let multiplicity = self.space.multiplicity(u);
                let stays = usize::from(u == start);
                if multiplicity <= stays || allowance(u, multiplicity + spent) <= spent {
                    break;
                }
                let mut knots = self.space.knots().to_vec();
                // The last copy; the seam's copies at the end of the period first.
                let end = knots.len() - 1;
                let at = if u == start && knots[end - 1] == knots[end] {
                    end
                } else {
                    knots.partition_point(|&k| k <= u) - 1
                };
                knots.remove(at);
                let coarse = Space::periodic(self.space.degree(), knots)?;
                let removed = if at == end { self.space.domain().1 } else { u };
                let back = coarse.inserting(&[removed])?;
                if *back.to() != self.space || !self.solve(&back, measure, limits) {
                    break;
                }
                self.space = coarse;
                gone.push(removed);
                copies += 1;
            }
        }
        Ok(gone)
    }

    /// The least-squares vertices whose conversion comes nearest to the present ones, if near enough.
    fn solve(&mut self, back: &Conversion, measure: &Measure, limits: &Limits) -> bool {
        let (n, m, width) = (back.to().len(), back.from().len(), self.rows.width);
        let mut matrix = DMatrix::<f64>::zeros(n, m);
        for k in 0..n {
            for (i, c) in back.row(k) {
                matrix[(k, i)] += c;
            }
        }
        let given = DMatrix::from_row_slice(n, width, &self.rows.data);
        let qr = matrix.clone().qr();
        let Some(solution) = qr.r().solve_upper_triangular(&(qr.q().transpose() * &given)) else {
            return false;
        };
        let defect = (&matrix * &solution - &given).transpose();
        let error = defect.column_iter().map(|c| measure.bound(c.as_slice()));
        let own = error.fold(0.0, largest);
        let error = own + self.errors.iter().copied().fold(0.0, largest);
        let new = solution.transpose();
        let sound = |v: &[f64]| v.iter().all(|x| x.is_finite()) && v.get(3).is_none_or(|&w| w > 0.0);
        let near = own <= limits.each && error <= limits.tolerance;
        if !(near && new.as_slice().chunks_exact(measure.size).all(sound)) {
            return false;
        }
        self.rows.data = new.as_slice().to_vec();
        self.errors = vec![error; m];
        self.kept = vec![None; m];
        true
    }

    /// The deviation from the rows given at first, as large as it really is, and from it every vertex's share.
    pub(super) fn measure_against(&mut self, rows: &Rows, measure: &Measure, back: &Conversion) -> f64 {
        let mut worst = 0.0_f64;
        self.errors.fill(0.0);
        let difference = self.difference(rows, back);
        for (k, change) in difference.chunks_exact(rows.width).enumerate() {
            let error = measure.bound(change);
            worst = worst.max(error);
            back.row(k)
                .filter(|&(_, c)| c > 0.0)
                .for_each(|(i, _)| self.errors[i] = self.errors[i].max(error));
        }
        worst
    }

    /// The rows given at first less those that the present ones give once the knots are inserted again.
    pub(super) fn difference(&self, rows: &Rows, back: &Conversion) -> Vec<f64> {
        let mut data = rows.data.clone();
        for (k, change) in data.chunks_exact_mut(rows.width).enumerate() {
            for (i, c) in back.row(k) {
                for (x, q) in change.iter_mut().zip(self.rows.row(i)) {
                    *x -= c * q;
                }
            }
        }
        data
    }
}
