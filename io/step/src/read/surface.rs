//! Surfaces: what the file says that they are, and as splines large enough for the points that are needed.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::spline::{Curve, Direction, Surface, SurfacePiece};
use loftsman_kernel::{Point, Vector};

use super::curve::Basis;
use super::entity::{At, Got, Problem, deeper};
use super::place::Space;
use super::spline::{SURFACES, is_one};
use super::swept::{Sweep, extruded, kept, open_extrusion, open_revolution};

/// How far splines may be from the offsets that they stand for, as a part of their size.
const NEAR: f64 = 1e-7;

/// A surface as the file has it, perhaps without ends.
pub(crate) enum Sheet {
    /// A plane, a cylinder or their like; `true` where its normal in the file is the other one.
    Elementary(SurfaceForm, bool),
    /// A spline.
    Spline(Surface),
    /// A spline near to what the file has, which is none, and how far it was found to be off.
    Near(Surface, f64),
    /// A curve with ends that is turned all around.
    Turned(Surface, Box<Turned>),
    /// A curve along a vector, without end.
    Extrusion { curve: Curve, basis: Basis, along: Vector, has_ends: bool },
    /// A conic without ends along a vector, without end.
    OpenExtrusion { basis: Basis, along: Vector },
    /// A line or a conic without ends about an axis.
    OpenRevolution { basis: Basis, axis: (Point, Vector) },
}

/// A curve that is turned about an axis.
pub(crate) struct Turned {
    form: SurfaceForm,
    profile: Curve,
    /// What the profile is on, and whether it is a piece of that: else parameters of the file are those of the basis.
    basis: Basis,
    has_ends: bool,
    axis: (Point, Vector),
}

/// A surface of a face.
pub(crate) struct Covering {
    pub(crate) surface: Surface,
    pub(crate) form: SurfaceForm,
    /// Whether `S_u × S_v` points against the normal in the file.
    pub(crate) reversed: bool,
}

impl Space<'_, '_> {
    /// A surface.
    pub(crate) fn sheet(&self, number: u64, depth: usize) -> Got<Sheet> {
        let depth = deeper(number, depth)?;
        let entity = self.entity(number)?;
        if is_one(&entity, &SURFACES) {
            return Ok(Sheet::Spline(self.spline_surface(&entity)?));
        }
        let args = entity.args();
        let frame = || self.frame(args.reference(1)?);
        let length = |index: usize| args.real(index).map(|number| self.length(number));
        let elementary = |form| Ok(Sheet::Elementary(form, false));
        match entity.only() {
            b"PLANE" => elementary(SurfaceForm::Plane { frame: frame()? }),
            b"CYLINDRICAL_SURFACE" => {
                elementary(SurfaceForm::Cylinder { frame: frame()?, radius: length(2)? })
            }
            b"CONICAL_SURFACE" => self.cone(number, frame()?, length(2)?, args.real(3)?),
            b"SPHERICAL_SURFACE" => elementary(SurfaceForm::Sphere { frame: frame()?, radius: length(2)? }),
            b"TOROIDAL_SURFACE" | b"DEGENERATE_TOROIDAL_SURFACE" => {
                elementary(SurfaceForm::Torus { frame: frame()?, major: length(2)?, minor: length(3)? })
            }
            b"SURFACE_OF_LINEAR_EXTRUSION" => {
                let (curve, along) = (args.reference(1)?, self.vector(args.reference(2)?)?);
                self.extrusion(curve, along, number, depth)
            }
            b"SURFACE_OF_REVOLUTION" => {
                let (curve, axis) = (args.reference(1)?, self.axis(args.reference(2)?)?);
                self.revolution(curve, axis, number, depth)
            }
            b"OFFSET_SURFACE" => {
                let distance = length(2)?;
                match self.sheet(args.reference(1)?, depth)? {
                    Sheet::Elementary(form, turned) => {
                        let by = if turned { -distance } else { distance };
                        match form.offset(by) {
                            Some(form) => Ok(Sheet::Elementary(form, turned)),
                            None => {
                                Err(Problem::new(number, "an offset by which nothing of the surface is left"))
                            }
                        }
                    }
                    Sheet::Spline(surface) | Sheet::Turned(surface, _) => {
                        let (surface, error) = surface.offset(distance, NEAR).at(number)?;
                        Ok(Sheet::Near(surface, error))
                    }
                    _ => {
                        Err(Problem::new(number, "an offset of a surface that is no spline and has no ends"))
                    }
                }
            }
            b"RECTANGULAR_TRIMMED_SURFACE" => {
                let basis = self.sheet(args.reference(1)?, depth)?;
                let (u, v) = ((args.real(2)?, args.real(3)?), (args.real(4)?, args.real(5)?));
                self.trimmed_sheet(number, &basis, [u, v], [args.flag(6)?, args.flag(7)?])
            }
            b"CURVE_BOUNDED_SURFACE" => Err(Problem::new(number, "a surface that curves bound is not read")),
            _ => Err(Problem::new(number, format!("{} is no surface that is read", entity.kinds()))),
        }
    }

    /// A cone, whose angle may be given either way round: a negative one opens downwards.
    fn cone(&self, number: u64, frame: Frame, radius: f64, angle: f64) -> Got<Sheet> {
        let angle = angle * self.units.angle;
        if angle == 0.0 {
            return Err(Problem::new(number, "a cone of angle 0: it is a cylinder"));
        }
        // The same circle seen from below; `x` stays, so that angles count from the same place.
        let frame = if angle < 0.0 { Frame { z: -frame.z, ..frame } } else { frame };
        if radius < 0.0 || angle.abs() >= FRAC_PI_2 {
            return Err(Problem::new(number, format!("a cone of radius {radius} and half angle {angle}")));
        }
        Ok(Sheet::Elementary(SurfaceForm::Cone { frame, radius, angle: angle.abs() }, false))
    }

    fn extrusion(&self, curve: u64, along: Vector, number: u64, depth: usize) -> Got<Sheet> {
        let (basis, _) = self.basis(curve, depth)?;
        match basis {
            Basis::Line { origin, vector } => match Frame::new(origin, vector.cross(&along), vector) {
                Some(frame) => Ok(Sheet::Elementary(SurfaceForm::Plane { frame }, false)),
                None => Err(Problem::new(number, "a line along itself is no surface")),
            },
            Basis::Ellipse { frame, radii, circle: true }
                if along.cross(&frame.z).norm() <= 1e-12 * along.norm() =>
            {
                let turned = along.dot(&frame.z) < 0.0;
                Ok(Sheet::Elementary(SurfaceForm::Cylinder { frame, radius: radii[0] }, turned))
            }
            Basis::Parabola { .. } | Basis::Hyperbola { .. } if !self.has_ends(curve, depth)? => {
                Ok(Sheet::OpenExtrusion { basis, along })
            }
            basis => {
                let has_ends = self.has_ends(curve, depth)?;
                Ok(Sheet::Extrusion { curve: self.bounded(curve, depth)?, basis, along, has_ends })
            }
        }
    }

    fn revolution(&self, curve: u64, axis: (Point, Vector), number: u64, depth: usize) -> Got<Sheet> {
        let (basis, _) = self.basis(curve, depth)?;
        let (origin, direction) = axis;
        let form = turned(basis.form(true), axis);
        let profile = match basis {
            Basis::Line { .. } => return Ok(Sheet::OpenRevolution { basis, axis }),
            Basis::Parabola { .. } | Basis::Hyperbola { .. } if !self.has_ends(curve, depth)? => {
                return Ok(Sheet::OpenRevolution { basis, axis });
            }
            // A circle about a point of the axis would go over its sphere twice: one half is enough.
            Basis::Ellipse { ref frame, radii, circle: true }
                if super::entity::kind(self.file, curve) == b"CIRCLE" && {
                    let off = frame.origin - origin;
                    (off - direction * off.dot(&direction)).norm() <= 1e-9 * radii[0]
                } =>
            {
                let start = basis.parameter(frame.origin - direction * radii[0]).at(number)?;
                let range = [start, start + PI];
                basis.formed(basis.piece(range[0], range[1], number)?, range, true)
            }
            _ => self.bounded(curve, depth)?,
        };
        let surface = Surface::revolution(&profile, origin, direction, TAU).at(number)?;
        let has_ends = self.has_ends(curve, depth)?;
        Ok(Sheet::Turned(surface, Box::new(Turned { form, profile, basis, has_ends, axis })))
    }

    /// The part of a profile between parameters of the file, with what it is beside a spline.
    fn profile_part(&self, profile: &Curve, basis: &Basis, ends: [f64; 2], number: u64) -> Got<Curve> {
        let [from, to] = match basis {
            Basis::Ellipse { .. } => self.around(ends),
            Basis::Spline(_) if (ends[0], ends[1]) == profile.domain() => return Ok(profile.clone()),
            _ => ends,
        };
        Ok(basis.formed(basis.piece(from, to, number)?, [from, to], true))
    }

    /// Angles of the file from the first to the second, no more than all around.
    fn around(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let (a, b) = (a * self.units.angle, b * self.units.angle);
        if b > a { [a, b.min(a + TAU)] } else { [a, b + TAU] }
    }

    /// Whether a curve is a piece of what it is on, looked at through what is on surfaces.
    fn has_ends(&self, curve: u64, depth: usize) -> Got<bool> {
        let depth = deeper(curve, depth)?;
        let entity = self.entity(curve)?;
        Ok(match entity.only() {
            b"SURFACE_CURVE" | b"SEAM_CURVE" | b"INTERSECTION_CURVE" => {
                self.has_ends(entity.args().reference(1)?, depth)?
            }
            kind => kind == b"TRIMMED_CURVE",
        })
    }

    fn trimmed_sheet(
        &self,
        number: u64,
        basis: &Sheet,
        [u, v]: [(f64, f64); 2],
        [u_sense, v_sense]: [bool; 2],
    ) -> Got<Sheet> {
        let ordered = |(a, b): (f64, f64), sense: bool| if sense { [a, b] } else { [b, a] };
        let ([a, b], [c, d]) = (ordered(u, u_sense), ordered(v, v_sense));
        // Of a curve that is a piece of another the parameters are its own.
        let part = |profile: &Curve, basis: &Basis, has_ends: bool, ends: [f64; 2]| {
            if !has_ends {
                return self.profile_part(profile, basis, ends, number);
            }
            let whole = (ends[0], ends[1]) == profile.domain();
            if whole { Ok(profile.clone()) } else { profile.between(ends[0], ends[1]).at(number) }
        };
        let surface = match basis {
            Sheet::Spline(surface) | Sheet::Near(surface, _) => surface
                .between(Direction::U, a, b)
                .and_then(|part| part.between(Direction::V, c, d))
                .at(number)?,
            Sheet::Elementary(form, _) => {
                let angle = self.units.angle;
                let around = |ends| self.around(ends);
                let straight = |[a, b]: [f64; 2]| [self.length(a), self.length(b)];
                let (u, v) = match form {
                    SurfaceForm::Plane { .. } => (straight([a, b]), straight([c, d])),
                    SurfaceForm::Cylinder { .. } | SurfaceForm::Cone { .. } => {
                        (around([a, b]), straight([c, d]))
                    }
                    SurfaceForm::Torus { .. } => (around([a, b]), around([c, d])),
                    _ => (around([a, b]), [c * angle, d * angle]),
                };
                if !(u[0] < u[1] && v[0] < v[1]) {
                    let text = format!(
                        "it runs from {} to {} and from {} to {}: the second must be more",
                        u[0], u[1], v[0], v[1]
                    );
                    return Err(Problem::new(number, text));
                }
                let turned =
                    |[low, high]: [f64; 2], sense: bool| if sense { [low, high] } else { [high, low] };
                let ranges = [turned(u, u_sense), turned(v, v_sense)];
                return formed(SurfacePiece { form: *form, ranges }, number).map(Sheet::Spline);
            }
            Sheet::Extrusion { curve, basis, along, has_ends } => {
                let part = part(curve, basis, *has_ends, [a, b])?;
                let sweep = Sweep { profile: part, senses: [u_sense, v_sense], number };
                return sweep.extruded(*along, [c, d]).map(Sheet::Spline);
            }
            Sheet::OpenExtrusion { basis, along } => {
                let part = basis.formed(basis.piece(a, b, number)?, [a, b], true);
                let sweep = Sweep { profile: part, senses: [u_sense, v_sense], number };
                return sweep.extruded(*along, [c, d]).map(Sheet::Spline);
            }
            Sheet::Turned(_, turned) => {
                let Turned { profile, basis, has_ends, axis, .. } = &**turned;
                let part = part(profile, basis, *has_ends, [c, d])?;
                let sweep = Sweep { profile: part, senses: [u_sense, v_sense], number };
                return sweep.turned(*axis, self.around([a, b])).map(Sheet::Spline);
            }
            Sheet::OpenRevolution { basis, axis } => {
                let part = basis.formed(basis.piece(c, d, number)?, [c, d], true);
                let sweep = Sweep { profile: part, senses: [u_sense, v_sense], number };
                return sweep.turned(*axis, self.around([a, b])).map(Sheet::Spline);
            }
        };
        let turn = |surface: Surface, direction, sense: bool| {
            if sense { Ok(surface) } else { surface.reverse(direction).at(number) }
        };
        let surface = turn(turn(surface, Direction::U, u_sense)?, Direction::V, v_sense)?;
        Ok(match basis {
            Sheet::Near(_, error) => Sheet::Near(surface, *error),
            _ => Sheet::Spline(surface),
        })
    }
}

/// A rectangle of an elementary surface as a spline that keeps what it is.
fn formed(piece: SurfacePiece, number: u64) -> Got<Surface> {
    piece.form.patch(piece.ranges).and_then(|surface| surface.with_form(piece)).at(number)
}

/// What a curve of a form is that is turned about an axis.
fn turned(profile: CurveForm, (origin, direction): (Point, Vector)) -> SurfaceForm {
    let frame = Frame::new(origin, direction, Vector::zeros());
    frame.map_or(SurfaceForm::Spline, |frame| SurfaceForm::Revolution { frame, profile })
}

impl Sheet {
    /// The surface as a spline that holds these points; as a whole where it has ends.
    pub(crate) fn covering(&self, points: &[Point], number: u64) -> Got<Covering> {
        let spline = |surface: Surface| Covering { surface, form: SurfaceForm::Spline, reversed: false };
        let swept = |surface: Surface, form: SurfaceForm| Covering { surface, form, reversed: false };
        match self {
            Self::Elementary(form, reversed) => {
                let surface = form.covering(points).at(number)?;
                Ok(Covering { surface, form: *form, reversed: *reversed })
            }
            Self::Spline(surface) | Self::Near(surface, _) => Ok(spline(surface.clone())),
            Self::Turned(surface, turned) => Ok(swept(surface.clone(), turned.form)),
            Self::Extrusion { curve, basis, along, .. } => {
                let unit = along / along.norm_squared();
                let range = |points: &[Point]| {
                    let heights = points.iter().map(|p| p.coords.dot(&unit));
                    heights
                        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
                };
                let ([low, high], [first, last]) = (range(points), range(curve.points()));
                // A point is at most as far along as it is beyond the lowest point of the curve.
                let ends = [low - last, high - first];
                let margin = (ends[1] - ends[0]) / 64.0;
                if !(margin > 0.0 && margin.is_finite()) {
                    return Err(Problem::new(number, "no points say how far the curve goes along"));
                }
                let surface = extruded(curve, *along, [ends[0] - margin, ends[1] + margin]).at(number)?;
                Ok(swept(surface, SurfaceForm::Extrusion { along: *along, profile: basis.form(true) }))
            }
            Self::OpenExtrusion { basis, along } => {
                let form = SurfaceForm::Extrusion { along: *along, profile: basis.form(true) };
                Ok(swept(open_extrusion(basis, *along, points, number)?, form))
            }
            Self::OpenRevolution { basis, axis } => {
                Ok(swept(open_revolution(basis, *axis, points, number)?, turned(basis.form(true), *axis)))
            }
        }
    }

    /// What is said of a surface that is not what the file has, but near to it.
    pub(crate) fn told(&self, number: u64) -> Option<String> {
        let Self::Near(_, error) = self else { return None };
        let error = loftsman_kernel::text::short(*error);
        Some(format!(
            "#{number}: an offset of a free-form surface, approximated by a B-spline: up to {error} off"
        ))
    }

    /// The surface where no face says how large it is.
    pub(crate) fn whole(&self, number: u64) -> Got<Surface> {
        match self {
            Self::Spline(surface) | Self::Near(surface, _) => Ok(surface.clone()),
            Self::Turned(surface, turned) => {
                let of = turned.profile.form().copied();
                Ok(kept(surface.clone(), SurfacePiece::turned(surface, turned.axis, TAU, of)))
            }
            Self::Elementary(form, _) => match form.whole() {
                Some(ranges) => formed(SurfacePiece { form: *form, ranges }, number),
                None => Err(Problem::new(number, format!("a {} without ends", form.name()))),
            },
            _ => Err(Problem::new(number, "a surface without ends")),
        }
    }
}
