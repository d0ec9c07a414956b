//! Curves and surfaces by themselves as the lines, conics and elementary surfaces that they are.

use std::f64::consts::TAU;

use loftsman_kernel::Point;
use loftsman_kernel::brep::CurveForm;
use loftsman_kernel::spline::{Curve, CurvePiece, Surface};

use super::print::{Printer, flag, real};

/// Beyond these the squares of lengths are no numbers that can be computed with.
const LENGTHS: std::ops::Range<f64> = 1e-150..1e150;

impl Printer {
    /// A curve as the line or conic that it is: its number and what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed(&mut self, curve: &Curve) -> Option<(u64, &'static str)> {
        // Asked once more: what is written is never another curve.
        let piece = *curve.form().filter(|piece| piece.check(curve).is_ok())?;
        let ends = [*curve.points().first()?, *curve.points().last()?];
        let length = nalgebra::distance(&ends[0], &ends[1]);
        let CurvePiece { form, range } = piece.upright();
        let whole = range == [0.0, TAU];
        let (basis, range) = match form {
            CurveForm::Spline => return None,
            CurveForm::Line if !LENGTHS.contains(&length) => return None,
            CurveForm::Line => {
                let origin = self.point(&ends[0]);
                let direction = self.direction(&(ends[1] - ends[0]));
                let vector = self.put(&format!("VECTOR('',#{direction},1.)"));
                (self.put(&format!("LINE('',#{origin},#{vector})")), [0.0, length])
            }
            CurveForm::Circle { frame, radius } => {
                let placement = self.frame(&frame);
                let number = self.put(&format!("CIRCLE('',#{placement},{})", real(radius)));
                (number, range)
            }
            CurveForm::Ellipse { frame, radii: [a, b] } => {
                let placement = self.frame(&frame);
                let number = self.put(&format!("ELLIPSE('',#{placement},{},{})", real(a), real(b)));
                (number, range)
            }
            CurveForm::Parabola { frame, focal } => {
                let placement = self.frame(&frame);
                let number = self.put(&format!("PARABOLA('',#{placement},{})", real(focal)));
                (number, range)
            }
            CurveForm::Hyperbola { frame, radii: [a, b] } => {
                let placement = self.frame(&frame);
                let number = self.put(&format!("HYPERBOLA('',#{placement},{},{})", real(a), real(b)));
                (number, range)
            }
        };
        // OpenCASCADE takes the parameters of a parabola for others than the schema has.
        let counts = if let CurveForm::Parabola { .. } = form { "CARTESIAN" } else { "PARAMETER" };
        let number = if whole { basis } else { self.part(basis, ends, range, counts) };
        Some((number, piece.noun()))
    }

    /// A surface as the rectangle of an elementary one that it is: its number and what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed_surface(&mut self, surface: &Surface) -> Option<(u64, &'static str)> {
        let piece = *surface.form().filter(|piece| piece.check(surface).is_ok())?;
        let [[a, b], [c, d]] = piece.ranges;
        // Around against the angle runs the mirror image of a cone.
        if a > b {
            return None;
        }
        let basis = self.elementary(&piece.form)?;
        // Also what is whole: OpenCASCADE shows no surface without ends.
        let [a, b, c, d] = [a, b, c, d].map(real);
        let along = flag(piece.ranges[1][0] < piece.ranges[1][1]);
        let number =
            self.put(&format!("RECTANGULAR_TRIMMED_SURFACE('',#{basis},{a},{b},{c},{d},.T.,{along})"));
        Some((number, piece.noun()))
    }

    /// A part of a curve: its ends as points and as parameters, and which of these count.
    fn part(&mut self, basis: u64, ends: [Point; 2], range: [f64; 2], counts: &str) -> u64 {
        let [a, b] = ends.map(|end| self.point(&end));
        let [from, to] = range.map(real);
        self.put(&format!(
            "TRIMMED_CURVE('',#{basis},(#{a},PARAMETER_VALUE({from})),(#{b},PARAMETER_VALUE({to})),.T.,.{counts}.)"
        ))
    }
}
