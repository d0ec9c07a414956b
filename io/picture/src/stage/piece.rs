//! Curves as Bézier pieces on the stage: what can be drawn and differentiated exactly.

use loftsman_kernel::Vector;
use nalgebra::Vector4;

/// A Bézier piece in homogeneous coordinates `(w x, w y, w z, w)`, over `[0, 1]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    /// `degree + 1` control points.
    pub(crate) control: Vec<Vector4<f64>>,
    /// Whether the weights differ, so that the piece is no polynomial.
    pub(crate) rational: bool,
}

/// Point and first two derivatives (by the piece's own parameter) of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet {
    pub(crate) point: Vector,
    pub(crate) first: Vector,
    pub(crate) second: Vector,
}

impl Piece {
    /// The degree.
    pub(crate) fn degree(&self) -> usize {
        self.control.len().saturating_sub(1)
    }

    /// Point and derivatives at `t`: de Casteljau down to three points, whose differences give the derivatives
    /// of the homogeneous curve, then the quotient rule.
    pub(crate) fn jet(&self, t: f64) -> Jet {
        let p = self.degree();
        let mut row = [Vector4::zeros(); loftsman_kernel::spline::space::MAX_ORDER];
        let row = &mut row[..=p.min(loftsman_kernel::error::MAX_DEGREE)];
        row.copy_from_slice(&self.control[..row.len()]);
        let reduce = |row: &mut [Vector4<f64>], count: usize| {
            for i in 0..count {
                row[i] = row[i] * (1.0 - t) + row[i + 1] * t;
            }
        };
        for count in (3..=p).rev() {
            reduce(row, count);
        }
        let (n, mut second) = (p as f64, Vector4::zeros());
        if p >= 2 {
            second = (row[2] - row[1] * 2.0 + row[0]) * (n * (n - 1.0));
            reduce(row, 2);
        }
        let first = (row[1] - row[0]) * n;
        reduce(row, 1);
        let weight = row[0].w;
        let point = row[0].xyz() / weight;
        let first_of = (first.xyz() - point * first.w) / weight;
        let second_of = (second.xyz() - point * second.w - first_of * (2.0 * first.w)) / weight;
        Jet { point, first: first_of, second: second_of }
    }

    /// The point at `t`.
    pub(crate) fn point(&self, t: f64) -> Vector {
        self.jet(t).point
    }

    /// Whether `next` goes on where this piece ends: it does not where a curve is torn.
    pub(crate) fn meets(&self, next: &Self) -> bool {
        self.vertex(self.degree()) == next.vertex(0)
    }

    /// Control point `i`, divided by its weight.
    pub(crate) fn vertex(&self, i: usize) -> Vector {
        self.control[i].xyz() / self.control[i].w
    }
}

impl Jet {
    /// The curvature vector `κN = (C'' − T (T·C'')) / |C'|²`; `None` where the curve stands still.
    pub(crate) fn curvature(&self) -> Option<Vector> {
        let speed = self.first.norm();
        let tangent = self.first / speed;
        let across = (self.second - tangent * tangent.dot(&self.second)) / (speed * speed);
        across.iter().all(|c| c.is_finite()).then_some(across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_quarter_circle_has_curvature_one_over_radius() {
        let w = 0.5_f64.sqrt();
        let control = vec![
            Vector4::new(2.0, 0.0, 0.0, 1.0),
            Vector4::new(2.0 * w, 2.0 * w, 0.0, w),
            Vector4::new(0.0, 2.0, 0.0, 1.0),
        ];
        let arc = Piece { control, rational: true };
        for t in [0.0, 0.3, 0.5, 1.0] {
            let jet = arc.jet(t);
            let expected = jet.point * (-1.0 / 4.0);
            assert!((jet.curvature().unwrap() - expected).norm() < 1e-14);
        }
    }

    #[test]
    fn a_point_that_stands_still_has_no_curvature() {
        let control = vec![Vector4::new(1.0, 1.0, 0.0, 1.0); 4];
        assert_eq!(Piece { control, rational: false }.jet(0.5).curvature(), None);
    }
}
