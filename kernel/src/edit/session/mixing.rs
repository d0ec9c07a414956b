//! Mixing of the last steps of an iteration, so that it converges where whole steps would circle.

/// The most steps that are mixed.
const DEPTH: usize = 5;

/// Anderson's mixing (1965) of a fixed-point iteration `d ← d + r(d)`: of the last points and their steps, the combination
/// whose step would be shortest if `r` were linear there; equivalent to a quasi-Newton method (Fang and Saad 2009), which
/// learns the curvature of the constraints from what the steps did.
#[derive(Debug, Default)]
pub(super) struct Mixing {
    /// Differences of neighbouring points and of their steps.
    points: Vec<Vec<f64>>,
    steps: Vec<Vec<f64>>,
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Mixing {
    /// Forgets everything.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The mixed point after `point`, whose own step is `step`; `None` where there is nothing to mix yet.
    pub(super) fn next(&mut self, point: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        if let Some((last_point, last_step)) = self.last.replace((point.to_vec(), step.to_vec())) {
            if self.points.len() == DEPTH {
                self.points.remove(0);
                self.steps.remove(0);
            }
            self.points.push(difference(point, &last_point));
            self.steps.push(difference(step, &last_step));
        }
        // The least squares of `step - Σ γ (differences of steps)`, by orthogonalisation, the newest first; one that the
        // newer ones nearly imply is left out.
        let mut rest = step.to_vec();
        let mut mixed: Vec<f64> = point.iter().zip(step).map(|(p, s)| p + s).collect();
        let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for (point, step) in self.points.iter().zip(&self.steps).rev() {
            let (mut q, mut move_by) = (step.clone(), sum(point, step));
            let whole = dot(&q, &q);
            for (other, its_move) in &basis {
                let share = dot(other, &q);
                q.iter_mut().zip(other).for_each(|(q, o)| *q -= share * o);
                move_by.iter_mut().zip(its_move).for_each(|(m, o)| *m -= share * o);
            }
            let square = dot(&q, &q);
            if !(square > 1e-10 * whole && square.is_finite()) {
                continue;
            }
            let scale = 1.0 / square.sqrt();
            q.iter_mut().chain(&mut move_by).for_each(|v| *v *= scale);
            let share = dot(&q, &rest);
            rest.iter_mut().zip(&q).for_each(|(r, q)| *r -= share * q);
            mixed.iter_mut().zip(&move_by).for_each(|(m, by)| *m -= share * by);
            basis.push((q, move_by));
        }
        (!basis.is_empty()).then_some(mixed)
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `d ← d + (b - A d)` with eigenvalues of `A` from -3 to 40 diverges; mixed, three unknowns need four steps.
    #[test]
    fn a_diverging_linear_iteration_arrives() {
        let a = [[4.0, 1.0, 0.0], [1.0, -3.0, 2.0], [0.0, 2.0, 40.0]];
        let b = [1.0, 2.0, 3.0];
        let step = |d: &[f64]| -> Vec<f64> { (0..3).map(|i| b[i] - dot(&a[i], d)).collect() };
        let (mut mixing, mut d) = (Mixing::default(), vec![0.0; 3]);
        for _ in 0..5 {
            let r = step(&d);
            d = mixing.next(&d, &r).unwrap_or_else(|| sum(&d, &r));
        }
        assert!(step(&d).iter().all(|r| r.abs() < 1e-9), "{:?}", step(&d));
    }
}
