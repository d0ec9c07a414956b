//! B-spline curves and surfaces.

use loftsman_kernel::spline::{Curve, Space, Surface};

use super::print::{Printer, list, real, reals, references};

/// How often each knot is there, and the knots.
fn knots(space: &Space) -> (String, String) {
    let (mut multiplicities, mut values): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    for &knot in space.knots() {
        match (values.last(), multiplicities.last_mut()) {
            (Some(&last), Some(count)) if last == knot => *count += 1,
            _ => {
                values.push(knot);
                multiplicities.push(1);
            }
        }
    }
    (list(multiplicities.iter().map(usize::to_string)), reals(&values))
}

impl Printer {
    /// A [clamped](Curve::clamped) curve.
    pub(crate) fn curve(&mut self, curve: &Curve) -> u64 {
        let points = self.points(curve.points());
        self.curve_of(curve, &points)
    }

    /// The same with control points that are written already.
    pub(crate) fn curve_of(&mut self, curve: &Curve, points: &str) -> u64 {
        let common = format!("{},{points},.UNSPECIFIED.,.F.,.U.", curve.degree());
        let (multiplicities, values) = knots(curve.space());
        let own = format!("{multiplicities},{values},.UNSPECIFIED.");
        match curve.weights() {
            None => self.put(&format!("B_SPLINE_CURVE_WITH_KNOTS('',{common},{own})")),
            Some(weights) => self.put(&format!(
                "(BOUNDED_CURVE()B_SPLINE_CURVE({common})B_SPLINE_CURVE_WITH_KNOTS({own})CURVE()\
                 GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({})REPRESENTATION_ITEM(''))",
                reals(weights)
            )),
        }
    }

    /// A [clamped](Surface::clamped) surface.
    pub(crate) fn surface(&mut self, surface: &Surface) -> u64 {
        let columns = surface.v().len();
        let numbers: Vec<u64> = surface.points().iter().map(|p| self.point(p)).collect();
        let points = list(numbers.chunks(columns).map(references));
        let degrees = [surface.u().degree(), surface.v().degree()];
        let common = format!("{},{},{points},.UNSPECIFIED.,.F.,.F.,.U.", degrees[0], degrees[1]);
        let ((u_count, u), (v_count, v)) = (knots(surface.u()), knots(surface.v()));
        let own = format!("{u_count},{v_count},{u},{v},.UNSPECIFIED.");
        match surface.weights() {
            None => self.put(&format!("B_SPLINE_SURFACE_WITH_KNOTS('',{common},{own})")),
            Some(weights) => {
                let rows = weights.chunks(columns).map(|row| list(row.iter().map(|&w| real(w))));
                let weights = list(rows);
                self.put(&format!(
                    "(BOUNDED_SURFACE()B_SPLINE_SURFACE({common})B_SPLINE_SURFACE_WITH_KNOTS({own})\
                     GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE({weights})REPRESENTATION_ITEM('')SURFACE())"
                ))
            }
        }
    }
}
