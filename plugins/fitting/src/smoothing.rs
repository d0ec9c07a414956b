//! Equations that ask for nothing but smoothness, in the least-squares sense.

use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

use crate::banded::Stencils;
use crate::solve::residual;

/// Rows that vanish where three neighbouring vertices are what a straight line, evenly run through, would have:
/// divided second differences over the Greville abscissae (first differences for degree 1), of length 1.
pub(crate) fn straighten(space: &Space, matrix: &mut Stencils) {
    let (n, p) = (space.len(), space.degree());
    let reach = p.min(2);
    let period = if space.is_periodic() { space.length() } else { 0.0 };
    if n <= reach {
        return;
    }
    let rows = if space.is_periodic() { n } else { n - reach };
    for i in 0..rows {
        let step = |j: usize| {
            let (a, b) = (space.greville((i + j) % n), space.greville((i + j + 1) % n));
            // Around the seam of a closed curve abscissae start again.
            if b < a { b - a + period } else { b - a }
        };
        let row = if reach == 1 {
            [1.0, -1.0, 0.0]
        } else {
            let (left, right) = (step(0), step(1));
            if !(left > 0.0 && right > 0.0) {
                continue;
            }
            [1.0 / left, -1.0 / left - 1.0 / right, 1.0 / right]
        };
        matrix.push(i, &row[..=reach]);
        matrix.normalize(matrix.len() - 1);
    }
}

/// Rows whose squares sum to nearly `∫ |C^(r)|² du` over a domain of length 1, `r = 3` (the degree, where that is
/// less): the control vertices of the `r`-th derivative, each times the root of the length it stands for.
///
/// They come from the difference formula `P⁽ᵏ⁾_i = (p-k+1) (P⁽ᵏ⁻¹⁾_{i+1} - P⁽ᵏ⁻¹⁾_i) / (t_{i+p+1} - t_{i+k})`. Where
/// knots coincide so that the derivative jumps, there is no such vertex and no row.
pub(crate) fn smooth(space: &Space, matrix: &mut Stencils) {
    let (p, t, length) = (space.degree(), space.flat(), space.length());
    let r = p.min(3);
    let count = space.unrolled_len();
    // Each vertex of a closed curve once.
    let (first, last) = if space.is_periodic() { (p, count) } else { (0, count.saturating_sub(r)) };
    'rows: for i in first..last {
        // triangle[j]: what P⁽ᵏ⁾_{i+j} has of P_i … P_{i+r}.
        let mut triangle = [[0.0; 4]; 4];
        for (j, line) in triangle.iter_mut().enumerate() {
            line[j] = 1.0;
        }
        for k in 1..=r {
            for j in 0..=r - k {
                let width = (unrolled(t, i + j + p + 1, space) - unrolled(t, i + j + k, space)) / length;
                if width <= 0.0 {
                    continue 'rows;
                }
                for c in 0..=r {
                    triangle[j][c] = (p - k + 1) as f64 * (triangle[j + 1][c] - triangle[j][c]) / width;
                }
            }
        }
        let share = (unrolled(t, i + p + 1, space) - unrolled(t, i + r, space)) / length / (p + 1 - r) as f64;
        let mut row = [0.0; MAX_ORDER];
        for c in 0..=r {
            row[c] = triangle[0][c] * share.sqrt();
        }
        matrix.push(space.vertex(i), &row[..=r]);
    }
}

/// `∫ |C'''|²` over a domain of length 1, nearly: of vertices of three numbers each.
pub(crate) fn energy(space: &Space, vertices: &[f64]) -> f64 {
    let mut matrix = Stencils::new(space, space.len());
    smooth(space, &mut matrix);
    let rows = matrix.len();
    residual(&matrix, vertices, &vec![0.0; 3 * rows]).1
}

/// The factor of each row of [`smooth`], adapted to how much of the tolerance the points in its support leave.
#[derive(Debug)]
pub(crate) struct Factors {
    values: Vec<f64>,
    growth: Vec<f64>,
    /// The support of each row, on the unrolled line.
    supports: Vec<(f64, f64)>,
    period: Option<f64>,
}

impl Factors {
    /// The same factor for all rows. The space has simple interior knots, so that no row is missing.
    pub(crate) fn new(space: &Space, start: f64) -> Self {
        let (p, t) = (space.degree(), space.flat());
        let rows = if space.is_periodic() { space.len() } else { space.len().saturating_sub(p.min(3)) };
        let first = if space.is_periodic() { p } else { 0 };
        let reach = p.min(3) + p + 1;
        let supports =
            (first..first + rows).map(|i| (unrolled(t, i, space), unrolled(t, i + reach, space))).collect();
        let period = space.is_periodic().then(|| space.length());
        Self { values: vec![start; rows], growth: vec![4.0; rows], supports, period }
    }

    /// One factor a row.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Less smoothing where a point is beyond the tolerance, more where all are well within; by steps that get
    /// smaller each time the limit is passed. `sites` ascend. `O(rows · points a support)`.
    pub(crate) fn adapt(&mut self, sites: &[f64], distances: &[f64], tolerance: f64) {
        for (row, &(start, end)) in self.supports.iter().enumerate() {
            let worst = |from: f64, to: f64| {
                let first = sites.partition_point(|&u| u < from);
                let inside = sites[first..].iter().zip(&distances[first..]).take_while(|(u, _)| **u <= to);
                inside.fold(0.0_f64, |m, (_, d)| m.max(*d))
            };
            let around = self.period.map_or(0.0, |period| worst(start - period, end - period));
            let error = worst(start, end).max(around);
            if error > tolerance {
                self.growth[row] = self.growth[row].sqrt();
                self.values[row] /= self.growth[row] * self.growth[row];
            } else if error < 0.8 * tolerance {
                self.values[row] *= self.growth[row];
            }
        }
    }
}

/// Knot `index` of the unrolled knots, continued around a closed curve.
fn unrolled(t: &[f64], index: usize, space: &Space) -> f64 {
    if index < t.len() || !space.is_periodic() {
        return t[index.min(t.len() - 1)];
    }
    let turns = (index - t.len()) / space.len() + 1;
    t[index - turns * space.len()] + turns as f64 * space.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of the squared rows times the vertices.
    fn squares(space: &Space, vertices: &[f64]) -> f64 {
        let mut matrix = Stencils::new(space, 0);
        smooth(space, &mut matrix);
        let vertices: Vec<f64> = vertices.iter().flat_map(|&v| [v, 0.0, 0.0]).collect();
        (0..matrix.len()).map(|r| matrix.point(r, &vertices)[0].powi(2)).sum()
    }

    #[test]
    fn third_derivative_of_a_cubic_and_none_of_a_parabola() {
        let space = Space::clamped(3, &[0.0, 0.3, 0.4, 1.0]).unwrap();
        let t = space.flat();
        // Blossoms: vertex i of u³ is t_{i+1} t_{i+2} t_{i+3}; of u² the mean of the three products of two.
        let cube: Vec<f64> = (0..6).map(|i| t[i + 1] * t[i + 2] * t[i + 3]).collect();
        let square: Vec<f64> =
            (0..6).map(|i| (t[i + 1] * t[i + 2] + t[i + 1] * t[i + 3] + t[i + 2] * t[i + 3]) / 3.0).collect();
        assert!((squares(&space, &cube) - 36.0).abs() < 1e-9);
        assert!(squares(&space, &square) < 1e-20);
    }

    #[test]
    fn closed_curves_have_a_row_a_vertex() {
        let space = Space::periodic(3, vec![0.0, 0.1, 0.25, 0.5, 0.6, 0.85, 1.0]).unwrap();
        let mut matrix = Stencils::new(&space, 0);
        smooth(&space, &mut matrix);
        assert_eq!(matrix.len(), 6);
        assert!(squares(&space, &[1.0; 6]) < 1e-16);
    }
}
