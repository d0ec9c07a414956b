//! Isocurves: the curves on a surface along which one parameter stands still.

use super::conversion::Direction;
use super::{Curve, Surface};
use crate::Vector;
use crate::error::{MAX_DEGREE, Result};

impl Surface {
    /// The isocurve at which the parameter of a direction is `at`, exactly: a curve in the other direction's space,
    /// over its domain, closed where that is.
    ///
    /// Its control vertices are `Q_j = Σ_i N_i(at) w_ij P_ij / W_j` with weights `W_j = Σ_i N_i(at) w_ij`; where the
    /// surface has none, `Q_j = Σ_i N_i(at) P_ij`. At a clamped end they are the surface's own, to the last bit. `O(p n)`.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::{Curve, Direction, Surface}};
    /// let line = Curve::line(Point::new(1.0, 0.0, 0.0), Point::new(3.0, 0.0, 2.0))?;
    /// let cone = Surface::revolution(&line, Point::origin(), Vector::z(), 1.5)?;
    /// let parallel = cone.isocurve(Direction::V, 0.5)?;
    /// assert!((parallel.point(0.7)? - cone.point(0.7, 0.5)?).norm() < 1e-15);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `at` is outside the domain (a periodic direction wraps it).
    pub fn isocurve(&self, direction: Direction, at: f64) -> Result<Curve> {
        let across = self.space(direction);
        let along = self.space(direction.other());
        let at = across.locate(at)?;
        let (span, p) = (across.span(at), across.degree());
        let mut row = [0.0; MAX_DEGREE + 1];
        across.basis_into(span, at, 0, &mut row);
        let columns = self.v().len();
        let index = |i: usize, j: usize| match direction {
            Direction::U => i * columns + j,
            Direction::V => j * columns + i,
        };
        let mut points = Vec::with_capacity(along.len());
        let mut weights = Vec::with_capacity(along.len());
        // A single basis function that is not 0, and so 1: the vertices themselves.
        let mut others = (0..=p).filter(|&k| row[k] != 0.0);
        let single = others.next().filter(|_| others.next().is_none());
        for j in 0..along.len() {
            let own = |k: usize| index(across.vertex(span - p + k), j);
            let weight = |k: usize| self.weights().map_or(1.0, |w| w[k]);
            if let Some(k) = single {
                points.push(self.points()[own(k)]);
                weights.push(weight(own(k)));
                continue;
            }
            let (mut sum, mut total) = (Vector::zeros(), 0.0);
            for (k, &value) in row[..=p].iter().enumerate() {
                let value = value * weight(own(k));
                sum += self.points()[own(k)].coords * value;
                total += value;
            }
            points.push((if self.weights().is_some() { sum / total } else { sum }).into());
            weights.push(total);
        }
        Curve::build(along.clone(), points, self.weights().map(|_| weights))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_surface, parameters};
    use super::*;

    proptest! {
        #[test]
        fn isocurves_lie_on_their_surface(surface in any_surface(), s in 0.0..=1.0_f64) {
            for direction in [Direction::U, Direction::V] {
                let (a, b) = surface.space(direction).domain();
                let at = (a + s * (b - a)).min(b);
                let curve = surface.isocurve(direction, at).unwrap();
                prop_assert_eq!(curve.space(), surface.space(direction.other()));
                let (c, d) = curve.domain();
                for t in parameters(c, d).step_by(3) {
                    let (u, v) = if direction == Direction::U { (at, t) } else { (t, at) };
                    let gap = (curve.point(t).unwrap() - surface.point(u, v).unwrap()).norm();
                    prop_assert!(gap < 1e-12, "{gap:e} at {u} {v}");
                }
            }
        }

        #[test]
        fn clamped_edges_are_the_surfaces_own_vertices(surface in any_surface()) {
            prop_assume!(surface.u().is_clamped());
            let n = surface.v().len();
            let (a, b) = surface.u().domain();
            let (first, last) = (surface.isocurve(Direction::U, a).unwrap(), surface.isocurve(Direction::U, b).unwrap());
            prop_assert_eq!(first.points(), &surface.points()[..n]);
            prop_assert_eq!(last.points(), &surface.points()[surface.points().len() - n..]);
            prop_assert_eq!(first.weights(), surface.weights().map(|w| &w[..n]));
        }
    }

    #[test]
    fn places_outside_are_refused() {
        let line = super::super::testing::line_of(2, 4);
        let sheet = Surface::extrusion(&line, Vector::z()).unwrap();
        assert!(sheet.isocurve(Direction::V, 1.5).is_err());
        assert!(sheet.isocurve(Direction::U, f64::NAN).is_err());
    }
}
