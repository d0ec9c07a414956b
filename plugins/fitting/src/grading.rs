//! Knots spread so that every span has the same share of the error.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Curve, Space};

use crate::error::Result;

/// A span's density is at least this share of the mean, so that no span becomes endless.
const FLOOR: f64 = 0.05;

/// How densely knots should lie: the integral of `|C^(p+1)|^(1/(p+1))` up to each breakpoint.
///
/// The best spline's error on a span of length `h` is nearly a constant times `h^(p+1) |C^(p+1)|`, so equal shares
/// of this integral give equal errors (de Boor, *A Practical Guide to Splines*, chapter XII, `NEWKNT`). The
/// derivative is read off the jumps of `C^(p)`, which is constant on each span.
#[derive(Debug)]
pub(crate) struct Grading {
    breaks: Vec<f64>,
    integral: Vec<f64>,
}

impl Grading {
    /// The density that a fitted curve shows. `O(n p²)`.
    ///
    /// # Errors
    /// As for [`Curve::derivative`].
    pub(crate) fn of(curve: &Curve) -> Result<Self> {
        let (p, breaks) = (curve.degree(), curve.space().breakpoints());
        let spans = breaks.len() - 1;
        let closed = curve.is_periodic();
        let width = |s: usize| breaks[s + 1] - breaks[s];
        let top: Vec<Vector> = (0..spans)
            .map(|s| curve.derivative(0.5 * breaks[s] + 0.5 * breaks[s + 1], p))
            .collect::<Result<_, _>>()?;
        // Between span s - 1 and span s; none at the ends of an open curve.
        let jump = |s: usize| {
            let (left, right) = ((s + spans - 1) % spans, s % spans);
            let inside = closed || (s > 0 && s < spans);
            inside.then(|| 2.0 * (top[right] - top[left]).norm() / (width(left) + width(right)))
        };
        let raw: Vec<f64> = (0..spans)
            .map(|s| {
                let sides = [jump(s), jump(s + 1)];
                let known = sides.iter().flatten().count().max(1) as f64;
                (sides.iter().flatten().sum::<f64>() / known).powf(1.0 / (p + 1) as f64)
            })
            .collect();
        let mean = (0..spans).map(|s| raw[s] * width(s)).sum::<f64>() / (breaks[spans] - breaks[0]);
        let mut integral = vec![0.0];
        let mut sum = 0.0;
        for s in 0..spans {
            // One span's estimate is noisy: its neighbours have a say.
            let next = |s: usize| raw.get(s).copied();
            let (before, after) = if closed {
                (next((s + spans - 1) % spans), next((s + 1) % spans))
            } else {
                (s.checked_sub(1).and_then(next), next(s + 1))
            };
            let density = 0.5 * raw[s] + 0.25 * before.unwrap_or(raw[s]) + 0.25 * after.unwrap_or(raw[s]);
            sum += density.max(FLOOR * mean) * width(s);
            integral.push(sum);
        }
        Ok(Self { breaks, integral })
    }

    /// A space of the same kind with `spans` spans (or fewer: each keeps two of the `sites`, which ascend), knots
    /// at equal shares of the density. `None` where there is no density (a curve that is a polynomial already).
    ///
    /// # Errors
    /// As for [`Space::open`].
    pub(crate) fn space(&self, like: &Space, spans: usize, sites: &[f64]) -> Result<Option<Space>> {
        let total = self.integral[self.integral.len() - 1];
        let (start, end) = (self.breaks[0], self.breaks[self.breaks.len() - 1]);
        if !total.is_normal() || spans == 0 {
            return Ok(None);
        }
        let mut breaks = vec![start];
        let (mut used, mut s) = (0, 0);
        for k in 1..spans {
            let share = total * k as f64 / spans as f64;
            while s + 2 < self.integral.len() && self.integral[s + 1] < share {
                s += 1;
            }
            let inside = (share - self.integral[s]) / (self.integral[s + 1] - self.integral[s]);
            let knot = self.breaks[s] + inside * (self.breaks[s + 1] - self.breaks[s]);
            let passed = used + sites[used..].iter().take_while(|&&u| u < knot).count();
            if passed >= used + 2 && passed + 2 <= sites.len() && knot < end {
                breaks.push(knot);
                used = passed;
            }
        }
        breaks.push(end);
        let p = like.degree();
        if like.is_periodic() {
            if breaks.len() < 4 {
                return Ok(None);
            }
            return Ok(Some(Space::periodic(p, breaks)?));
        }
        Ok(Some(Space::clamped(p, &breaks)?))
    }
}
