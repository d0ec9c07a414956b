//! Curves and surfaces by themselves as the lines, conics, elementary and swept surfaces that they are.

use std::f64::consts::TAU;

use loftsman_kernel::Point;
use loftsman_kernel::brep::{CurveForm, SurfaceForm};
use loftsman_kernel::spline::{Curve, CurvePiece, Surface, SurfacePiece};

use super::print::{Printer, flag, real};

/// Beyond these the squares of lengths are no numbers that can be computed with.
const LENGTHS: std::ops::Range<f64> = 1e-150..1e150;

impl Printer {
    /// A curve as the line or conic that it is: its number and what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed(&mut self, curve: &Curve) -> Option<(u64, &'static str)> {
        // Asked once more: what is written is never another curve.
        let piece = *curve.form().filter(|piece| piece.check(curve).is_ok())?;
        let ends = [*curve.points().first()?, *curve.points().last()?];
        let CurvePiece { form, range } = piece.upright();
        let whole = range == [0.0, TAU];
        let (basis, range) = self.line_or_conic(&form, range, ends)?;
        let by_points = matches!(form, CurveForm::Parabola { .. });
        let number = if whole { basis } else { self.part(basis, ends, range, true, by_points) };
        Some((number, piece.noun()))
    }

    /// A line or conic without ends, and from where to where the piece between two points is on it. `None` of a spline, and of a line whose length is none
    /// that can be computed with.
    fn line_or_conic(
        &mut self,
        form: &CurveForm,
        range: [f64; 2],
        ends: [Point; 2],
    ) -> Option<(u64, [f64; 2])> {
        let length = nalgebra::distance(&ends[0], &ends[1]);
        Some(match *form {
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
        })
    }

    /// A surface as the rectangle of an elementary one that it is: its number and what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed_surface(&mut self, surface: &Surface) -> Option<(u64, &'static str)> {
        let piece = *surface.form().filter(|piece| piece.check(surface).is_ok())?;
        if let SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } = piece.form {
            return self.swept_piece(surface, &piece).map(|number| (number, piece.noun()));
        }
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

    /// A curve along a vector or about an axis: a rectangle of what it sweeps. Profiles are what they are without ends, which the rectangle has; of
    /// parabolas, whose parameters are others in OpenCASCADE, the spline is left, and so it is of what is extruded and of turned lines where the unit is
    /// not the millimetre.
    fn swept_piece(&mut self, surface: &Surface, piece: &SurfacePiece) -> Option<u64> {
        let profile = piece.profile(surface).ok()??;
        let of = profile.form().map(|piece| piece.form);
        if let Some(CurveForm::Parabola { .. }) = of {
            return None;
        }
        // In other units OpenCASCADE takes the lengths of rectangles of these for millimetres.
        let is_length = match piece.form {
            SurfaceForm::Extrusion { .. } => true,
            _ => matches!(of, Some(CurveForm::Line)),
        };
        if is_length && !self.millimetres {
            return None;
        }
        let rectangle = |number: u64, [u, v]: [[f64; 2]; 2]| {
            let [[a, b], [c, d]] = [u.map(real), v.map(real)];
            format!("RECTANGULAR_TRIMMED_SURFACE('',#{number},{a},{b},{c},{d},.T.,.T.)")
        };
        match piece.form {
            SurfaceForm::Extrusion { along, .. } => {
                let length = along.norm();
                if !LENGTHS.contains(&length) {
                    return None;
                }
                let (basis, range) = self.swept_profile(&profile)?;
                let direction = self.direction(&along);
                let vector = self.put(&format!("VECTOR('',#{direction},1.)"));
                let number = self.put(&format!("SURFACE_OF_LINEAR_EXTRUSION('',#{basis},#{vector})"));
                Some(self.put(&rectangle(number, [range, [0.0, length]])))
            }
            SurfaceForm::Revolution { frame, .. } => {
                let (basis, range) = self.swept_profile(&profile)?;
                let (origin, axis) = (self.point(&frame.origin), self.direction(&frame.z));
                let placement = self.put(&format!("AXIS1_PLACEMENT('',#{origin},#{axis})"));
                let number = self.put(&format!("SURFACE_OF_REVOLUTION('',#{basis},#{placement})"));
                Some(self.put(&rectangle(number, [piece.ranges[0], range])))
            }
            _ => None,
        }
    }

    /// A profile without ends, and from where to where it is swept.
    fn swept_profile(&mut self, profile: &Curve) -> Option<(u64, [f64; 2])> {
        let Some(piece) = profile.form() else {
            let (from, to) = profile.domain();
            return Some((self.curve(profile), [from, to]));
        };
        let CurvePiece { form, range } = piece.upright();
        let ends = [*profile.points().first()?, *profile.points().last()?];
        self.line_or_conic(&form, range, ends)
    }

    /// A part of a curve, along it or against it: its ends as points and as parameters, of which the parameters count unless it is said otherwise:
    /// OpenCASCADE takes those of a parabola for others than the schema has.
    pub(super) fn part(
        &mut self,
        basis: u64,
        ends: [Point; 2],
        range: [f64; 2],
        along: bool,
        by_points: bool,
    ) -> u64 {
        let [a, b] = ends.map(|end| self.point(&end));
        let [from, to] = range.map(real);
        let (sense, counts) = (flag(along), if by_points { "CARTESIAN" } else { "PARAMETER" });
        self.put(&format!(
            "TRIMMED_CURVE('',#{basis},(#{a},PARAMETER_VALUE({from})),(#{b},PARAMETER_VALUE({to})),{sense},.{counts}.)"
        ))
    }
}
