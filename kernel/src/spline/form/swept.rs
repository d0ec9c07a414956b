//! Surfaces that are curves along a vector or about an axis: the form kept beside the spline, and checked against it.

use std::f64::consts::TAU;

use nalgebra::Matrix4;

use super::patch::alike;
use super::{CurveForm, CurvePiece, Frame, Similarity, SurfaceForm, SurfacePiece};
use crate::error::{Error, Result};
use crate::spline::{Curve, Space, Surface};
use crate::{Point, Vector};

/// How far a spline may be from the one that its form is, in parts of the largest coordinate and of the weights: what a few dozen roundings make, and no
/// more.
const ROUNDING: f64 = 1e-12;

/// The domain of a space.
fn domain(space: &Space) -> [f64; 2] {
    let (from, to) = space.domain();
    [from, to]
}

/// What a profile is beside a spline, and from where to where; of a spline over its domain.
fn profile(piece: Option<CurvePiece>, space: &Space) -> (CurveForm, [f64; 2]) {
    match piece {
        Some(piece) => (piece.form, piece.range),
        None => (CurveForm::Spline, domain(space)),
    }
}

impl SurfacePiece {
    /// What a curve along a vector is as a surface ([`Surface::extrusion`]): the vector leads from the first row along `v` to the last one, which is the
    /// `v` from 0 to 1 of its ranges. `of` is what the curve, where `v` starts, is beside a spline.
    pub fn extruded(surface: &Surface, of: Option<CurvePiece>) -> Self {
        let (form, range) = profile(of, surface.u());
        let points = surface.points();
        let last = points.get(surface.v().len() - 1).or(points.last());
        let along = points.first().zip(last).map_or_else(Vector::zeros, |(a, b)| b - a);
        Self { form: SurfaceForm::Extrusion { along, profile: form }, ranges: [range, [0.0, 1.0]] }
    }

    /// What a curve about an axis is as a surface ([`Surface::revolution`]): `axis` is a point of it and its direction, which is turned round where the sweep
    /// is negative. `of` is what the curve, where `u` starts, is beside a spline. `None` where the axis has no direction.
    pub fn turned(
        surface: &Surface,
        (origin, direction): (Point, Vector),
        sweep: f64,
        of: Option<CurvePiece>,
    ) -> Option<Self> {
        let (form, range) = profile(of, surface.v());
        let direction = if sweep < 0.0 { -direction } else { direction };
        let frame = Frame::new(origin, direction, Vector::zeros())?;
        Some(Self {
            form: SurfaceForm::Revolution { frame, profile: form },
            ranges: [[0.0, sweep.abs()], range],
        })
    }

    /// The curve that is moved or turned, where `v` of an extrusion or `u` of a revolution starts, with what it is beside a spline. `None` of an elementary
    /// surface.
    ///
    /// # Errors
    /// When that is not what the form says.
    pub fn profile(&self, surface: &Surface) -> Result<Option<Curve>> {
        let columns = surface.v().len();
        let (form, range, space, step) = match self.form {
            SurfaceForm::Extrusion { profile, .. } => (profile, self.ranges[0], surface.u(), columns),
            SurfaceForm::Revolution { profile, .. } => (profile, self.ranges[1], surface.v(), 1),
            _ => return Ok(None),
        };
        let count = space.len();
        let points = surface.points().iter().step_by(step).take(count).copied().collect();
        let weights = surface
            .weights()
            .map(|weights| weights.iter().step_by(step).take(count).copied().collect::<Vec<f64>>());
        // The weights of a surface may all be those of the turn.
        let weights = weights.filter(|weights| weights.iter().any(|weight| *weight != 1.0));
        let curve = Curve::build(space.clone(), points, weights)?;
        if form == CurveForm::Spline {
            return if range == domain(space) {
                Ok(Some(curve))
            } else {
                Err(Error::Invalid(format!(
                    "its profile, a spline, runs from {} to {}, and not over its domain",
                    range[0], range[1]
                )))
            };
        }
        curve.with_form(CurvePiece { form, range }).map(Some)
    }

    /// As [`moved`](Self::moved), of what is swept.
    pub(super) fn moved_sweep(&self, map: &Matrix4<f64>) -> Option<Self> {
        let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector = map.fixed_view::<3, 1>(0, 3).into_owned();
        let moved = |form: CurveForm, range: [f64; 2]| match form {
            CurveForm::Spline => Some(CurveForm::Spline),
            form => CurvePiece { form, range }.moved(map).map(|piece| piece.form),
        };
        let form = match self.form {
            SurfaceForm::Extrusion { along, profile } => {
                SurfaceForm::Extrusion { along: linear * along, profile: moved(profile, self.ranges[0])? }
            }
            SurfaceForm::Revolution { frame, profile } => {
                let mut frame = Similarity::of(&linear, shift)?.frame(&frame)?;
                // Mirrored, it turns the other way about its axis.
                if (linear / linear.amax()).determinant() < 0.0 {
                    frame.z = -frame.z;
                }
                SurfaceForm::Revolution { frame, profile: moved(profile, self.ranges[1])? }
            }
            _ => return None,
        };
        Some(Self { form, ranges: self.ranges })
    }

    /// As [`check`](Self::check), of what is swept.
    pub(super) fn check_sweep(&self, surface: &Surface) -> Result<()> {
        let no = |why: String| Err(Error::Invalid(format!("the surface is no {}: {why}", self.form.name())));
        self.form.check()?;
        if !(surface.u().is_clamped() && surface.v().is_clamped()) {
            return no("its knots are not clamped".to_owned());
        }
        let Some(profile) = self.profile(surface)? else { return no("it is elementary".to_owned()) };
        match self.form {
            SurfaceForm::Extrusion { profile: CurveForm::Line, .. } => {
                no("a line along a vector is a part of a plane".to_owned())
            }
            SurfaceForm::Extrusion { along, .. } => {
                if surface.v().degree() != 1 || surface.v().len() != 2 {
                    return no("along the vector it is not of degree 1 with two vertices".to_owned());
                }
                if self.ranges[1] != [0.0, 1.0] {
                    return no(format!("along the vector it runs from and to {:?}", self.ranges[1]));
                }
                let own = Surface::extrusion(&profile, along)?;
                self.same(surface, &own, &Point::origin())
            }
            SurfaceForm::Revolution { frame, .. } => {
                let [from, sweep] = self.ranges[0];
                if from != 0.0 || !(sweep > 0.0 && sweep <= TAU) {
                    return no(format!("it turns from and to {:?}", self.ranges[0]));
                }
                let own = Surface::revolution(&profile, frame.origin, frame.z, sweep)?;
                self.same(surface, &own, &frame.origin)
            }
            _ => no("it is elementary".to_owned()),
        }
    }

    /// That a surface is another to rounding, over whatever domains.
    fn same(&self, surface: &Surface, own: &Surface, origin: &Point) -> Result<()> {
        let no = |why: String| Err(Error::Invalid(format!("the surface is no {}: {why}", self.form.name())));
        for (space, own) in [(surface.u(), own.u()), (surface.v(), own.v())] {
            if space.degree() != own.degree() || space.len() != own.len() || !alike(space, own) {
                return no("it has other knots than that".to_owned());
            }
        }
        let weight = |surface: &Surface, k: usize| surface.weights().map_or(1.0, |weights| weights[k]);
        let reach = own.points().iter().map(|p| p.coords.amax()).fold(origin.coords.amax(), f64::max);
        for (k, (p, q)) in surface.points().iter().zip(own.points()).enumerate() {
            let off = (p - q).amax();
            if off > ROUNDING * reach || off.is_nan() {
                return no(format!("a vertex is {off:e} from where that has it"));
            }
            let (one, other) = (weight(surface, k), weight(own, k));
            if (one - other).abs() > ROUNDING * other {
                return no("it has other weights than that".to_owned());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use crate::spline::Direction;

    fn axis() -> (Point, Vector) {
        (Point::new(3.0, -2.0, 7.0), Vector::new(0.3, -0.5, 0.8))
    }

    /// Curves, and what they are.
    fn profiles(scale: f64) -> Vec<Curve> {
        let frame =
            Frame::new(Point::new(9.0, 1.0, 2.0) * scale, Vector::new(0.1, 1.0, 0.2), Vector::x()).unwrap();
        let knots = Space::clamped(3, &[0.0, 1.0, 2.5]).unwrap();
        let points = (0..5).map(|k| Point::new(8.0 + f64::from(k * k), f64::from(k), 1.5) * scale).collect();
        let spline = Curve::rational(knots, points, vec![1.0, 2.0, 1.5, 0.5, 1.0]).unwrap();
        let (radii, focal) = ([2.0 * scale, 3.0 * scale], 0.5 * scale);
        let form = CurveForm::Ellipse { frame, radii };
        let arc =
            Curve::elliptic_arc(frame.origin, frame.x * radii[0], frame.y() * radii[1], 0.5, 2.0).unwrap();
        let arc = arc.with_form(CurvePiece { form, range: [0.5, 2.5] }).unwrap();
        let at = |a: f64, b: f64| frame.origin + frame.x * (focal * a * b) + frame.y() * (focal * (a + b));
        let parabola = Curve::new(
            Space::clamped(2, &[-1.0, 2.0]).unwrap(),
            vec![at(-1.0, -1.0), at(-1.0, 2.0), at(2.0, 2.0)],
        );
        let form = CurveForm::Parabola { frame, focal };
        vec![spline, arc, parabola.unwrap().with_form(CurvePiece { form, range: [-1.0, 2.0] }).unwrap()]
    }

    fn family(scale: f64) -> Vec<Surface> {
        let mut all = Vec::new();
        let (origin, direction) = axis();
        for profile in profiles(scale) {
            let of = profile.form().copied();
            let surface = Surface::extrusion(&profile, Vector::new(1.0, 2.0, -3.0) * scale).unwrap();
            let piece = SurfacePiece::extruded(&surface, of);
            all.push(surface.with_form(piece).unwrap());
            for sweep in [TAU, 1.2, -2.5] {
                let surface = Surface::revolution(&profile, origin * scale, direction, sweep).unwrap();
                let piece = SurfacePiece::turned(&surface, (origin * scale, direction), sweep, of).unwrap();
                all.push(surface.with_form(piece).unwrap());
            }
        }
        let line = Curve::line(Point::new(8.0, 0.0, 0.0) * scale, Point::new(9.0, 4.0, 1.0) * scale).unwrap();
        let surface = Surface::revolution(&line, origin * scale, direction, 2.0).unwrap();
        let piece =
            SurfacePiece::turned(&surface, (origin * scale, direction), 2.0, Some(CurvePiece::LINE)).unwrap();
        all.push(surface.with_form(piece).unwrap());
        all
    }

    #[test]
    fn sweeps_are_told_from_what_is_none() {
        for formed in [1.0, 1e-9, 1e9].into_iter().flat_map(family) {
            let (piece, plain) = (*formed.form().unwrap(), formed.clone().without_form());
            let size = (plain.points()[0] - plain.points()[plain.points().len() / 2]).norm();
            for k in 0..plain.points().len() {
                let mut bent = plain.clone();
                bent.control_vertices_mut()[k] += Vector::new(0.3, 0.5, 0.7) * (1e-6 * size);
                assert!(bent.with_form(piece).is_err(), "{piece:?} {k}");
            }
            let [[a, b], [c, d]] = piece.ranges;
            for ranges in [
                [[a, b + 1e-6], [c, d]],
                [[a + 1e-6, b], [c, d]],
                [[a, b], [c, d + 1e-6]],
                [[b, a], [c, d]],
                [[a, b], [d, c]],
                [[a, f64::NAN], [c, d]],
            ] {
                assert!(SurfacePiece { ranges, ..piece }.check(&plain).is_err(), "{piece:?} {ranges:?}");
            }
            let profile = piece.profile(&formed).unwrap().unwrap();
            let (u, v) = (formed.u().domain().0, formed.v().domain().0);
            assert!((profile.points()[0] - formed.point(u, v).unwrap()).norm() <= 1e-14 * size.max(1e-9));
            for direction in [Direction::U, Direction::V] {
                assert!(formed.elevate(direction, 1).unwrap().form().is_none());
                assert!(formed.reverse(direction).unwrap().form().is_none());
            }
        }
    }

    #[test]
    fn sweeps_move_with_their_surfaces() {
        let turn = Matrix4::new_rotation(Vector::new(0.4, 1.0, -2.0));
        let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-1.0, 1.0, 1.0));
        let shift = Matrix4::new_translation(&Vector::new(5.0, -6.0, 1.0));
        let stretch = Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, 1.0));
        for formed in family(1.0) {
            for map in
                [turn, mirror, shift * mirror * turn * Matrix4::new_scaling(25.4), Matrix4::new_scaling(1e-3)]
            {
                let moved = formed.transformed(&map).unwrap();
                moved.form().unwrap_or_else(|| panic!("{:?} {map}", formed.form())).check(&moved).unwrap();
            }
            // Along a vector whatever is stretched stays; a conic does not.
            let kept = formed.transformed(&stretch).unwrap().form().is_some();
            let form = formed.form().unwrap().form;
            assert_eq!(kept, matches!(form, SurfaceForm::Extrusion { profile: CurveForm::Spline, .. }));
        }
    }

    #[test]
    fn a_line_along_a_vector_is_none() {
        let line = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
        let surface = Surface::extrusion(&line, Vector::new(1.0, 2.0, 0.0)).unwrap();
        let piece = SurfacePiece::extruded(&surface, Some(CurvePiece::LINE));
        assert!(surface.with_form(piece).is_err());
    }
}
