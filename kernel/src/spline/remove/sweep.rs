//! One pass of knot removal along an open line of knots: the heart of knot removal.

/// Control vertices as rows of numbers: all columns of a surface side by side, each with 3 coordinates or 4
/// homogeneous ones.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Numbers a row.
    pub(super) width: usize,
    /// The rows, one after the other.
    pub(super) data: Vec<f64>,
}

impl Rows {
    pub(super) fn len(&self) -> usize {
        self.data.len() / self.width
    }

    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.width..(i + 1) * self.width]
    }

    pub(super) fn push(&mut self, row: &[f64]) {
        self.data.extend_from_slice(row);
    }
}

/// How far a change of control vertices can move the shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure {
    /// Numbers a vertex: 3, or 4 where rational.
    pub(super) size: usize,
    /// Where distances are measured from (rational only), and how far the shape is from there at most.
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
    /// The smallest weight.
    pub(super) weight: f64,
}

impl Measure {
    /// A bound of the distance that a row's change moves any point by: the length of the change, largest over the
    /// columns. For rational shapes `C = Σ N w P / W` and `C'` with changed `wP` and `w`,
    /// `W (C - C') = Σ N_i (Δ(w_i P_i) - Δw_i C')`, from any origin, so `|Δ(wP)|` and `|Δw|` times the distance of
    /// `C'`, over the smallest weight, bound it.
    pub(super) fn bound(&self, change: &[f64]) -> f64 {
        let length = |v: &[f64]| v.iter().fold(0.0_f64, |length, &x| length.hypot(x));
        let one = |v: &[f64]| match *v {
            [x, y, z, w] => {
                let [a, b, c] = self.center;
                (length(&[x - w * a, y - w * b, z - w * c]) + w.abs() * self.radius) / self.weight
            }
            _ => length(v),
        };
        change.chunks_exact(self.size).map(one).fold(0.0, largest)
    }
}

/// The larger of two numbers, or NaN where there is one (which [`f64::max`] would hide).
pub(super) fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// A line under removal: what has been gone through, knots and vertices, ready to be changed again.
#[derive(Debug, Default)]
pub(super) struct Strip {
    pub(super) knots: Vec<f64>,
    pub(super) rows: Rows,
    /// A bound of the deviation so far as a spline of its own: `|C - C_0| ≤ Σ N_i errors_i`.
    pub(super) errors: Vec<f64>,
    /// The vertex as it was given that a row still is, if any.
    pub(super) kept: Vec<Option<usize>>,
}

/// What may be removed in a pass.
pub(super) struct Limits {
    pub(super) degree: usize,
    /// Rows below this one, and from this number on counted from the end, stay as they are.
    pub(super) first_row: usize,
    pub(super) rows_after: usize,
    /// The bound of the deviation by all removals together.
    pub(super) tolerance: f64,
    /// The bound for a single one.
    pub(super) each: f64,
}

impl Strip {
    /// Goes through a line from left to right and removes each knot as often as `copies(index, value, multiplicity)`
    /// wants and the tolerance allows. Returns the new line, and how many copies were removed of the run of equal
    /// knots that starts at each given index.
    ///
    /// Everything a removal changes lies left of the knot, on top of what has been gone through, so that one pass is
    /// linear: `O(n p)` a column.
    pub(super) fn sweep(
        given: &Self,
        limits: &Limits,
        measure: &Measure,
        mut copies: impl FnMut(usize, f64, usize) -> usize,
    ) -> (Self, Vec<(usize, usize)>) {
        let (p, n) = (limits.degree, given.rows.len());
        let mut done = Self {
            knots: given.knots[..=p].to_vec(),
            rows: Rows { width: given.rows.width, data: Vec::with_capacity(given.rows.data.len()) },
            ..Self::default()
        };
        let (mut next, mut next_row, mut removed) = (p + 1, 0, Vec::new());
        let mut work = Vec::new();
        while next < n {
            let u = given.knots[next];
            let run = given.knots[next..n].iter().take_while(|&&k| k == u).count();
            let inside = u > given.knots[p] && u < given.knots[n];
            let mut left = run;
            // A tear, where no vertex is shared, is left alone.
            let wanted = if inside && run <= p { copies(next, u, run).min(run) } else { 0 };
            while run - left < wanted {
                while done.rows.len() <= done.knots.len() {
                    done.take(given, next_row);
                    next_row += 1;
                }
                let rows_left = n - next_row;
                let first = done.knots.len() + left - p - 2;
                if first < limits.first_row
                    || rows_left < limits.rows_after
                    || !done.remove_one(u, left, &given.knots[next + run..], limits, measure, &mut work)
                {
                    break;
                }
                left -= 1;
            }
            if left < run {
                removed.push((next, run - left));
            }
            done.knots.extend(std::iter::repeat_n(u, left));
            next += run;
        }
        while next_row < n {
            done.take(given, next_row);
            next_row += 1;
        }
        done.knots.extend_from_slice(&given.knots[n..]);
        (done, removed)
    }

    fn take(&mut self, given: &Self, row: usize) {
        self.rows.push(given.rows.row(row));
        self.errors.push(given.errors[row]);
        self.kept.push(given.kept[row]);
    }

    /// Removes one of `s` copies of the knot `u` that follows the knots gone through, if the deviation allows;
    /// `right` are the knots after `u`.
    ///
    /// With `Q` the vertices without the knot, inserting it again gives `P_i = α_i Q_i + β_i Q_{i-1}` for
    /// `i = r-p … r-s`, the outermost `Q` known: one equation more than unknowns. The left null vector `λ` of this
    /// bidiagonal system alternates in sign, so its defect `δ = Σ λ_i P_i` is spread over all equations evenly,
    /// `ε_i = sign(λ_i) δ / Σ|λ|`: the least change of the `P_i`, in the largest norm, that makes them consistent.
    /// Then each `Q` is solved from the side on which its own coefficient is at least ½ (`α` falls with `i`), so
    /// that no error grows on the way.
    fn remove_one(
        &mut self,
        u: f64,
        s: usize,
        right: &[f64],
        limits: &Limits,
        measure: &Measure,
        work: &mut Vec<f64>,
    ) -> bool {
        let (p, width, last) = (limits.degree, self.rows.width, self.knots.len());
        let first = last + s - 1 - p;
        let m = p - s + 1;
        let mut alpha = [0.0; crate::error::MAX_DEGREE];
        let mut beta = [0.0; crate::error::MAX_DEGREE];
        let mut lambda = [1.0; crate::error::MAX_DEGREE];
        for j in 0..m {
            let (a, b) = (self.knots[first + j], right[j]);
            alpha[j] = (u - a) / (b - a);
            beta[j] = (b - u) / (b - a);
            if j > 0 {
                lambda[j] = lambda[j - 1] * alpha[j - 1] / beta[j];
            }
        }
        let total: f64 = lambda[..m].iter().sum();
        // The right-hand sides, and after them the defect.
        work.clear();
        work.extend_from_slice(&self.rows.data[first * width..last * width]);
        work.resize((m + 1) * width, 0.0);
        let (sides, defect) = work.split_at_mut(m * width);
        for c in 0..width {
            sides[c] -= beta[0] * self.rows.row(first - 1)[c];
            sides[(m - 1) * width + c] -= alpha[m - 1] * self.rows.row(last)[c];
            let terms =
                (0..m).map(|j| if j % 2 == 0 { lambda[j] } else { -lambda[j] } * sides[j * width + c]);
            defect[c] = terms.sum::<f64>() / total;
            for j in 0..m {
                sides[j * width + c] -= if j % 2 == 0 { defect[c] } else { -defect[c] };
            }
        }
        let before = self.errors[first - 1..=last].iter().fold(0.0_f64, |m, &e| m.max(e));
        let own = measure.bound(defect);
        let error = before + own;
        if !(own <= limits.each && error <= limits.tolerance) {
            return false;
        }
        let forward = (0..m - 1).take_while(|&j| alpha[j] >= beta[j]).count();
        for c in 0..width {
            let mut previous = 0.0;
            for j in 0..forward {
                previous = (sides[j * width + c] - beta[j] * previous) / alpha[j];
                sides[j * width + c] = previous;
            }
            // Equation `forward` is the one left over; those after it give the vertex before theirs.
            previous = 0.0;
            for j in (forward + 1..m).rev() {
                let side = std::mem::take(&mut sides[j * width + c]);
                previous = (side - alpha[j] * previous) / beta[j];
                sides[j * width + c] = previous;
            }
        }
        // Now the new vertices are at 0 .. forward and forward + 1 .. m.
        sides.copy_within((forward + 1) * width.., forward * width);
        let new = &sides[..(m - 1) * width];
        let sound = |v: &[f64]| v.iter().all(|x| x.is_finite()) && v.get(3).is_none_or(|&w| w > 0.0);
        if !new.chunks_exact(measure.size).all(sound) {
            return false;
        }
        self.rows.data.splice(first * width..last * width, new.iter().copied());
        self.errors.remove(first);
        self.errors[first - 1..last].fill(error);
        self.kept.remove(first);
        self.kept[first..last - 1].fill(None);
        true
    }
}
