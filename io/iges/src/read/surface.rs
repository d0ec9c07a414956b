//! Surfaces: what the file says that they are, as splines with how the file counts along them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::spline::{Curve, Surface, SurfacePiece};
use loftsman_kernel::text::short;
use loftsman_kernel::{Point, Vector, direction};
use nalgebra::Matrix4;

use super::curve::Run;
use super::entity::{At, Entity, Got, Problem, Reader, deeper};
use super::pace::Pace;
use super::place::{linear, moved_frame, moved_surface};

/// How far splines may be from the offsets that they stand for, as a part of their size.
const NEAR: f64 = 1e-7;

/// A surface of a file.
#[allow(
    clippy::large_enum_variant,
    reason = "one at a time, looked at and taken apart: a few hundred bytes buy plain matching"
)]
pub(crate) enum Sheet {
    /// A spline with ends.
    Whole(Whole),
    /// A plane, a cylinder or their like.
    Elementary(SurfaceForm),
}

/// A surface with ends, as a spline.
pub(crate) struct Whole {
    pub(crate) surface: Surface,
    pub(crate) form: SurfaceForm,
    /// How the file counts along `u` and `v` of the spline.
    pub(crate) paces: [Pace; 2],
    /// Whether the file's first parameter is `v`: then its normal is `-S_u × S_v`.
    pub(crate) swapped: bool,
    /// The rectangle of an elementary or swept surface that it is.
    pub(crate) piece: Option<Box<SurfacePiece>>,
}

/// A surface of a face.
pub(crate) struct Covering {
    pub(crate) surface: Surface,
    pub(crate) form: SurfaceForm,
    /// Whether `S_u × S_v` points against the normal in the file.
    pub(crate) reversed: bool,
}

/// Whether entities of a type are surfaces.
pub(crate) fn is_surface(kind: u32) -> bool {
    matches!(kind, 108 | 114 | 118 | 120 | 122 | 128 | 140 | 190 | 192 | 194 | 196 | 198)
}

impl Whole {
    fn plain(surface: Surface) -> Self {
        let pace = |(a, b): (f64, f64)| Pace::even([a, b], [a, b]);
        let paces = [pace(surface.u().domain()), pace(surface.v().domain())];
        Self { surface, form: SurfaceForm::Spline, paces, swapped: false, piece: None }
    }
}

impl Reader<'_, '_> {
    /// A surface where it is placed.
    pub(crate) fn sheet(&self, place: usize, depth: usize) -> Got<Sheet> {
        let depth = deeper(place, depth)?;
        let entity = self.entity(place)?;
        let sheet = match entity.entry.kind {
            108 => plane(&entity),
            114 => super::spline::parametric_surface(&entity).map(|s| Sheet::Whole(Whole::plain(s))),
            118 => self.ruled(&entity, depth),
            120 => self.revolved(&entity, depth),
            122 => self.tabulated(&entity, depth),
            128 => super::spline::surface(&entity).map(|s| Sheet::Whole(Whole::plain(s))),
            140 => self.offset_sheet(&entity, depth),
            190 | 192 | 194 | 196 | 198 => self.elementary(&entity).map(Sheet::Elementary),
            kind => Err(Problem::new(place, format!("type {kind} is no surface that is read"))),
        }?;
        match self.placed(place)? {
            Some(map) => sheet.moved(&map, place),
            None => Ok(sheet),
        }
    }

    /// A ruled surface (118).
    fn ruled(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Sheet> {
        let place = entity.place;
        let (first, mut second) =
            (self.curve(entity.pointer(1)?, depth)?, self.curve(entity.pointer(2)?, depth)?);
        if entity.whole(3)? == 1 {
            second.curve = second.curve.reverse().at(place)?;
            second.form = CurveForm::Spline;
        }
        // Lines run evenly, and arcs, so that form 0 (equal arc lengths) and form 1 (equal parameters) say the same of two of a kind.
        let alike = matches!(
            (&first.form, &second.form),
            (CurveForm::Line, CurveForm::Line) | (CurveForm::Circle { .. }, CurveForm::Circle { .. })
        );
        let even = first.pace.affine().is_some() && second.pace.affine().is_some();
        if !(alike || (even && entity.entry.form == 1)) {
            let by = if entity.entry.form == 1 { "parameters" } else { "arc lengths" };
            self.change(
                place,
                &format!("a ruled surface between points of equal {by}: its lines join points of equal shares of the splines"),
            );
        }
        let surface = Surface::ruled(&first.curve, &second.curve).at(place)?;
        let paces = [first.pace.over([0.0, 1.0]), Pace::even([0.0, 1.0], [0.0, 1.0])];
        Ok(Sheet::Whole(Whole { surface, form: SurfaceForm::Spline, paces, swapped: false, piece: None }))
    }

    /// A surface of revolution (120): its first parameter is that of the curve, its second the angle.
    fn revolved(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Sheet> {
        let place = entity.place;
        let axis = self.curve(entity.pointer(1)?, depth)?;
        let run = self.curve(entity.pointer(2)?, depth)?;
        let (formed, Run { curve, pace, form, range }) = (run.clone().formed(), run);
        let (start, end) = (entity.real(3)?, entity.real(4)?);
        let ends = axis.curve.points();
        let axis = match (axis.form, ends) {
            (CurveForm::Line, [a, b]) => (*a, b - a),
            _ => return Err(Problem::new(place, "its axis is no line")),
        };
        let Some(direction) = direction(&axis.1) else {
            return Err(Problem::new(place, "its axis has no length"));
        };
        let sweep = end - start;
        let sweep = if sweep <= 0.0 { sweep + TAU } else { sweep };
        // Files have a full turn with nine digits or so.
        let sweep = if (sweep - TAU).abs() <= 1e-7 { TAU } else { sweep };
        let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_unchecked(direction), start);
        let (space, points, weights) = curve.into_parts();
        let points =
            if start == 0.0 { points } else { points.iter().map(|p| axis.0 + turn * (p - axis.0)).collect() };
        let profile = Curve::build(space, points, weights).at(place)?;
        let surface = Surface::revolution(&profile, axis.0, direction, sweep).at(place)?;
        let (a, b) = surface.u().domain();
        let around = Pace::turn([start, start + sweep], [a, b], surface.u().spans().count(), sweep);
        let form = revolved_form(&profile, &form, axis.0, direction);
        let elementary = revolved_piece(&profile, range, &form, direction, sweep);
        let piece = elementary.filter(|piece| piece.check(&surface).is_ok()).or_else(|| {
            let [there, back] = [-axis.0.coords, axis.0.coords].map(|by| Matrix4::new_translation(&by));
            let turned = match start {
                0.0 => Ok(formed),
                _ => formed.transformed(&(back * turn.to_homogeneous() * there)),
            };
            SurfacePiece::turned(&surface, (axis.0, direction), sweep, turned.ok()?.form().copied())
        });
        let piece = piece.map(Box::new);
        Ok(Sheet::Whole(Whole { surface, form, paces: [around, pace], swapped: true, piece }))
    }

    /// A tabulated cylinder (122): a curve along a vector, both from 0 to 1.
    fn tabulated(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Sheet> {
        let place = entity.place;
        let run = self.curve(entity.pointer(1)?, depth)?;
        let (formed, Run { curve, pace, form, .. }) = (run.clone().formed(), run);
        let to = Point::from(entity.triple(2)?);
        let from = curve.point(curve.domain().0).at(place)?;
        let surface = Surface::extrusion(&curve, to - from).at(place)?;
        let paces = [pace.over([0.0, 1.0]), Pace::even([0.0, 1.0], [0.0, 1.0])];
        let piece = match form {
            CurveForm::Line => plane_piece(&curve, &form, to - from),
            _ => Some(SurfacePiece::extruded(&surface, formed.form().copied())),
        };
        let piece = piece.map(Box::new);
        Ok(Sheet::Whole(Whole { surface, form: SurfaceForm::Spline, paces, swapped: false, piece }))
    }

    /// An offset (140): of an elementary surface one of its kind, of another a spline near to it.
    fn offset_sheet(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Sheet> {
        let place = entity.place;
        let Some(toward) = direction(&Vector::from(entity.triple(1)?)) else {
            return Err(Problem::new(place, "its indicator has no direction"));
        };
        let distance = entity.real(4)?;
        // The indicator says to which side, where both parameters start.
        let to_side = |normal: Vector| if normal.dot(&toward) < 0.0 { -distance } else { distance };
        match self.sheet(entity.pointer(5)?, depth)? {
            Sheet::Elementary(form) => {
                let outwards = match form {
                    SurfaceForm::Plane { frame } => frame.z,
                    SurfaceForm::Cone { frame, angle, .. } => frame.x * angle.cos() - frame.z * angle.sin(),
                    // The latitude starts at the south pole; where the indicator says nothing of that it is of the equator.
                    SurfaceForm::Sphere { frame, .. } if toward.dot(&frame.z).abs() > 1e-6 => -frame.z,
                    SurfaceForm::Cylinder { frame, .. }
                    | SurfaceForm::Sphere { frame, .. }
                    | SurfaceForm::Torus { frame, .. } => frame.x,
                    // No sheet is one of these.
                    SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
                        toward
                    }
                };
                let form = form.offset(to_side(outwards));
                let none = || Problem::new(place, "an offset by which nothing of the surface is left");
                form.map(Sheet::Elementary).ok_or_else(none)
            }
            Sheet::Whole(whole) => {
                let [u, v] = [whole.surface.u().domain().0, whole.surface.v().domain().0];
                let normal = whole.surface.normal(u, v).at(place)?.vector();
                let Some(normal) = normal else {
                    return Err(Problem::new(
                        place,
                        "an offset of a surface that has no normal where its parameters start",
                    ));
                };
                let (surface, error) = whole.surface.offset(to_side(normal), NEAR).at(place)?;
                self.change(
                    place,
                    &format!(
                        "an offset of a free-form surface, approximated by a B-spline: up to {} off",
                        short(error)
                    ),
                );
                Ok(Sheet::Whole(Whole { surface, form: SurfaceForm::Spline, piece: None, ..whole }))
            }
        }
    }

    /// The surfaces of solids: plane (190), cylinder (192), cone (194), sphere (196), torus (198).
    fn elementary(&self, entity: &Entity<'_, '_>) -> Got<SurfaceForm> {
        let place = entity.place;
        let origin = self.point(entity.pointer(1)?)?;
        let direction = |index: usize| match entity.pointed(index)? {
            Some(of) => self.direction(of).map(Some),
            None => Ok(None),
        };
        let frame = |axis: usize, reference: usize| {
            let (z, x) =
                (direction(axis)?.unwrap_or(Vector::z()), direction(reference)?.unwrap_or(Vector::x()));
            Frame::new(origin, z, x).ok_or_else(|| Problem::new(place, "its axis has no direction"))
        };
        let length = |index: usize| {
            let length = entity.real(index)?;
            if length > 0.0 && length.is_finite() {
                return Ok(length);
            }
            Err(Problem::new(place, format!("the radius {length}: it must be positive")))
        };
        Ok(match entity.entry.kind {
            190 => SurfaceForm::Plane { frame: frame(2, 3)? },
            192 => SurfaceForm::Cylinder { frame: frame(2, 4)?, radius: length(3)? },
            194 => {
                let (radius, angle) = (entity.real(3)?, entity.real(4)?.to_radians());
                if !(radius >= 0.0 && angle > 0.0 && angle < FRAC_PI_2) {
                    let text = format!("a cone of radius {radius} and half angle {angle}");
                    return Err(Problem::new(place, text));
                }
                SurfaceForm::Cone { frame: frame(2, 5)?, radius, angle }
            }
            196 => SurfaceForm::Sphere { frame: frame(3, 4)?, radius: length(2)? },
            _ => SurfaceForm::Torus { frame: frame(2, 5)?, major: length(3)?, minor: length(4)? },
        })
    }
}

/// A plane by its equation `A x + B y + C z = D` (108).
fn plane(entity: &Entity<'_, '_>) -> Got<Sheet> {
    let place = entity.place;
    let [a, b, c] = entity.triple(1)?;
    let (normal, d) = (Vector::new(a, b, c), entity.real(4)?);
    let origin = Point::from(normal * (d / normal.norm_squared()));
    match Frame::new(origin, normal, Vector::x()) {
        Some(frame) => Ok(Sheet::Elementary(SurfaceForm::Plane { frame })),
        None => Err(Problem::new(place, "a plane without a normal")),
    }
}

/// A line along a vector across it: a rectangle of a plane.
fn plane_piece(line: &Curve, form: &CurveForm, along: Vector) -> Option<SurfacePiece> {
    let (CurveForm::Line, [a, b]) = (form, line.points()) else { return None };
    let x = b - a;
    let frame = Frame::new(*a, x.cross(&along), x)?;
    Some(SurfacePiece {
        form: SurfaceForm::Plane { frame },
        ranges: [[0.0, x.norm()], [0.0, along.dot(&frame.y())]],
    })
}

/// Which rectangle of an elementary surface a profile turned by an angle is; whether it is that is for others to check.
fn revolved_piece(
    profile: &Curve,
    range: [f64; 2],
    form: &SurfaceForm,
    direction: Vector,
    sweep: f64,
) -> Option<SurfacePiece> {
    let (frame, major) = match *form {
        SurfaceForm::Cylinder { frame, .. } | SurfaceForm::Cone { frame, .. } => (frame, None),
        SurfaceForm::Sphere { frame, .. } => (frame, Some(0.0)),
        SurfaceForm::Torus { frame, major, .. } => (frame, Some(major)),
        _ => return None,
    };
    let (low, high) = profile.domain();
    let at = |k: f64| profile.point(low + k * (high - low)).ok().map(|p| p - frame.origin);
    // The half plane in which the profile is, by a place of it that is not on the axis.
    let middle = at(0.5)?;
    let start = middle.dot(&frame.y()).atan2(middle.dot(&frame.x));
    let start = if start.abs() <= 1e-12 { 0.0 } else { start };
    let turns = if frame.z.dot(&direction) < 0.0 { -sweep } else { sweep };
    let out = frame.x * start.cos() + frame.y() * start.sin();
    let height = |p: Vector| p.dot(&frame.z);
    let v = match major {
        None => [height(at(0.0)?), height(at(1.0)?)],
        Some(major) => {
            let angle = |p: Vector| height(p).atan2(p.dot(&out) - major);
            let (from, quarter) = (angle(at(0.0)?), angle(at(0.25)?));
            let along = (quarter - from + PI).rem_euclid(TAU) - PI > 0.0;
            let length = range[1] - range[0];
            [from, if along { from + length } else { from - length }]
        }
    };
    Some(SurfacePiece { form: *form, ranges: [[start, start + turns], v] })
}

/// What a turned line or arc is, where that is elementary.
fn revolved_form(profile: &Curve, form: &CurveForm, origin: Point, direction: Vector) -> SurfaceForm {
    let found = || {
        let split = |p: &Point| {
            let d = p - origin;
            let height = d.dot(&direction);
            (height, d - direction * height)
        };
        let (first, last) = (profile.points().first()?, profile.points().last()?);
        let ((h1, r1), (h2, r2)) = (split(first), split(last));
        let size = (last - first).norm().max(r1.norm()).max(r2.norm());
        match form {
            CurveForm::Line => {
                // A line askew to the axis turns into a hyperboloid.
                let plane = r1.cross(&r2).norm() <= 1e-9 * size * size;
                let side = r1.dot(&r2) >= -1e-18 * size * size;
                let (a, b) = (r1.norm(), r2.norm());
                if !plane || !side {
                    return None;
                }
                if (a - b).abs() <= 1e-9 * size {
                    let frame = Frame::new(origin + direction * h1, direction, r1)?;
                    return (a > 1e-9 * size).then_some(SurfaceForm::Cylinder { frame, radius: a });
                }
                let (low, high) = if a < b { ((h1, a), (h2, r2)) } else { ((h2, b), (h1, r1)) };
                let rise = (high.0 - low.0).abs();
                if rise <= 1e-9 * size {
                    let frame = Frame::new(origin + direction * h1, direction, high.1)?;
                    return Some(SurfaceForm::Plane { frame });
                }
                let axis = direction * (high.0 - low.0).signum();
                let frame = Frame::new(origin + direction * low.0, axis, high.1)?;
                let angle = ((high.1.norm() - low.1) / rise).atan();
                Some(SurfaceForm::Cone { frame, radius: low.1, angle })
            }
            CurveForm::Circle { frame: circle, radius } => {
                let (height, off) = split(&circle.origin);
                // Its plane must hold the axis.
                if circle.z.dot(&direction).abs() > 1e-9 || off.dot(&circle.z).abs() > 1e-9 * size {
                    return None;
                }
                let center = origin + direction * height;
                let x = if off.norm() > 1e-9 * radius { off } else { r1 + r2 };
                let frame = Frame::new(center, direction, x)?;
                if off.norm() <= 1e-9 * radius {
                    return Some(SurfaceForm::Sphere { frame, radius: *radius });
                }
                Some(SurfaceForm::Torus { frame, major: off.norm(), minor: *radius })
            }
            _ => None,
        }
    };
    found().unwrap_or_default()
}

impl Sheet {
    fn moved(self, map: &Matrix4<f64>, place: usize) -> Got<Self> {
        Ok(match self {
            Self::Elementary(form) => Self::Elementary(moved_form(form, map).ok_or_else(|| {
                Problem::new(
                    place,
                    "its matrix does not keep angles and lengths: such a surface is no longer one",
                )
            })?),
            Self::Whole(whole) => {
                let form = moved_form(whole.form, map).unwrap_or_default();
                let surface = match whole.piece {
                    // Where the map keeps lengths the piece goes along.
                    Some(piece) => match whole.surface.clone().with_form(*piece) {
                        Ok(formed) => formed.transformed(map).at(place)?,
                        Err(_) => moved_surface(whole.surface, map, place)?,
                    },
                    None => moved_surface(whole.surface, map, place)?,
                };
                let piece = surface.form().copied().map(Box::new);
                let surface = surface.without_form();
                // The normal of the file's parameters is mirrored along with the surface: nothing is turned round.
                Self::Whole(Whole { surface, form, piece, paces: whole.paces, swapped: whole.swapped })
            }
        })
    }

    /// The surface as a spline that holds these points; as a whole where it has ends.
    pub(crate) fn covering(&self, points: &[Point], place: usize) -> Got<Covering> {
        match self {
            Self::Elementary(form) => {
                Ok(Covering { surface: form.covering(points).at(place)?, form: *form, reversed: false })
            }
            Self::Whole(whole) => {
                Ok(Covering { surface: whole.surface.clone(), form: whole.form, reversed: whole.swapped })
            }
        }
    }

    /// The surface where nothing says how large it is.
    pub(crate) fn whole(self, place: usize) -> Got<Surface> {
        match self {
            Self::Whole(Whole { surface, piece: Some(piece), .. }) => {
                // Of what is that to fewer digits the spline is left.
                Ok(surface.clone().with_form(*piece).unwrap_or(surface))
            }
            Self::Whole(whole) => Ok(whole.surface),
            Self::Elementary(form) => match form.whole() {
                Some(ranges) => {
                    let piece = SurfacePiece { form, ranges };
                    form.patch(ranges).and_then(|surface| surface.with_form(piece)).at(place)
                }
                None => Err(Problem::new(place, format!("a {} without ends", form.name()))),
            },
        }
    }
}

/// A form under a map that keeps angles and lengths.
fn moved_form(form: SurfaceForm, map: &Matrix4<f64>) -> Option<SurfaceForm> {
    Some(match form {
        SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
            SurfaceForm::Spline
        }
        SurfaceForm::Plane { frame } => {
            let z = linear(map, &frame.z);
            let moved = moved_frame(&frame, map)?;
            // A mirror turns the frame over, while the plane's normal is mirrored.
            let z = if moved.z.dot(&z) < 0.0 { -moved.z } else { moved.z };
            SurfaceForm::Plane { frame: Frame { z, ..moved } }
        }
        SurfaceForm::Cylinder { frame, radius } => {
            SurfaceForm::Cylinder { frame: moved_axis(&frame, map)?, radius }
        }
        SurfaceForm::Cone { frame, radius, angle } => {
            SurfaceForm::Cone { frame: moved_axis(&frame, map)?, radius, angle }
        }
        SurfaceForm::Sphere { frame, radius } => {
            SurfaceForm::Sphere { frame: moved_axis(&frame, map)?, radius }
        }
        SurfaceForm::Torus { frame, major, minor } => {
            SurfaceForm::Torus { frame: moved_axis(&frame, map)?, major, minor }
        }
    })
}

/// A frame whose axis goes where the map brings it, also under a mirror.
fn moved_axis(frame: &Frame, map: &Matrix4<f64>) -> Option<Frame> {
    let moved = moved_frame(frame, map)?;
    Frame::new(moved.origin, linear(map, &frame.z), moved.x)
}
