//! Curves and surfaces: B-splines, lines, circles, elementary surfaces.

use std::borrow::Cow;

use loftsman_kernel::brep::{CurveForm, Edge, Frame, SurfaceForm};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Result, Vector};
use nalgebra::Matrix4;

use super::print::{Look, Printer, Purpose, Record};

/// Coordinates one after another.
fn coordinates(points: &[Point]) -> impl Iterator<Item = &f64> {
    points.iter().flat_map(|p| p.iter())
}

/// So many times 1, where there are no weights.
fn weights(weights: Option<&[f64]>, count: usize) -> Cow<'_, [f64]> {
    weights.map_or_else(|| Cow::Owned(vec![1.0; count]), Cow::Borrowed)
}

impl Printer {
    /// A curve with [clamped](Curve::clamped) knots.
    pub(crate) fn curve(&mut self, curve: &Curve, look: Look, properties: &[u32]) -> u32 {
        let points = curve.points();
        let flat = look.purpose == Purpose::Parametric;
        let closed = points.first() == points.last();
        let (start, end) = curve.domain();
        let record = Record::new(126)
            .count(points.len() - 1)
            .count(curve.degree())
            .whole(i64::from(flat))
            .whole(i64::from(closed))
            .whole(i64::from(curve.weights().is_none()))
            .whole(0)
            .reals(curve.space().knots())
            .reals(weights(curve.weights(), points.len()).iter())
            .reals(coordinates(points))
            .real(start)
            .real(end)
            .reals(&[0.0, 0.0, if flat { 1.0 } else { 0.0 }])
            .properties(properties);
        self.put(record, look)
    }

    /// A surface with [clamped](Surface::clamped) knots.
    pub(crate) fn surface(&mut self, surface: &Surface, look: Look, properties: &[u32]) -> u32 {
        let (rows, columns) = (surface.u().len(), surface.v().len());
        // The first direction runs fastest in the file.
        let order: Vec<usize> = (0..columns).flat_map(|j| (0..rows).map(move |i| i * columns + j)).collect();
        let points: Vec<Point> = order.iter().map(|&k| surface.points()[k]).collect();
        let all = weights(surface.weights(), rows * columns);
        let all: Vec<f64> = order.iter().map(|&k| all[k]).collect();
        let same = |mut pairs: Box<dyn Iterator<Item = (usize, usize)>>| {
            pairs.all(|(a, b)| surface.points()[a] == surface.points()[b])
        };
        let closed_u = same(Box::new((0..columns).map(|j| (j, (rows - 1) * columns + j))));
        let closed_v = same(Box::new((0..rows).map(|i| (i * columns, i * columns + columns - 1))));
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        let record = Record::new(128)
            .count(rows - 1)
            .count(columns - 1)
            .count(surface.u().degree())
            .count(surface.v().degree())
            .whole(i64::from(closed_u))
            .whole(i64::from(closed_v))
            .whole(i64::from(surface.weights().is_none()))
            .whole(0)
            .whole(0)
            .reals(surface.u().knots())
            .reals(surface.v().knots())
            .reals(&all)
            .reals(coordinates(&points))
            .reals(&[a, b, c, d])
            .properties(properties);
        self.put(record, look)
    }

    pub(crate) fn point(&mut self, p: &Point, look: Look, properties: &[u32]) -> u32 {
        let record = Record::new(116).reals(p.iter()).whole(0).properties(properties);
        self.put(record, look)
    }

    fn direction(&mut self, v: &Vector) -> u32 {
        let look = Look::PART.purpose(Purpose::Definition);
        self.put(Record::new(123).reals(v.iter()), look)
    }

    /// A matrix, which turns or mirrors, and shifts.
    pub(crate) fn matrix(&mut self, map: &Matrix4<f64>) -> u32 {
        let rows: Vec<f64> = (0..3).flat_map(|i| (0..4).map(move |j| (i, j))).map(|at| map[at]).collect();
        let mirrors = map.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        self.put(Record::new(124).reals(&rows), Look::default().form(i32::from(mirrors)))
    }

    /// The curve of an edge as what it is: from its start to its end, which may be those of its vertices.
    pub(crate) fn edge_curve(&mut self, edge: &Edge) -> Result<u32> {
        let (from, to) = edge.range;
        let [a, b] = [edge.curve.point(from)?, edge.curve.point(to)?];
        Ok(match edge.form {
            CurveForm::Line => {
                let record = Record::new(110).reals(coordinates(&[a, b]));
                self.put(record, Look::PART)
            }
            CurveForm::Circle { frame, .. } => {
                let turns = frame.z.cross(&(a - frame.origin)).dot(&edge.curve.derivative(from, 1)?) >= 0.0;
                let frame = if turns { frame } else { Frame { z: -frame.z, ..frame } };
                let mut map = Matrix4::identity();
                for (k, axis) in [frame.x, frame.y(), frame.z, frame.origin.coords].iter().enumerate() {
                    map.fixed_view_mut::<3, 1>(0, k).copy_from(axis);
                }
                let matrix = self.matrix(&map);
                let local = |p: Point| [(p - frame.origin).dot(&frame.x), (p - frame.origin).dot(&frame.y())];
                let start = local(a);
                // All around both are the same number.
                let end = if edge.ends[0] == edge.ends[1] { start } else { local(b) };
                let record = Record::new(100).reals(&[0.0; 3]).reals(&start).reals(&end);
                self.put(record, Look { matrix: Some(matrix), ..Look::PART })
            }
            _ => {
                let whole = edge.range == edge.curve.domain();
                let part = if whole { edge.curve.clone() } else { edge.curve.between(from, to)? };
                let plain = part.clamped()?;
                self.curve(&plain, Look::PART, &[])
            }
        })
    }

    /// A surface as what it is, and whether its normal in the file is that of the spline.
    pub(crate) fn sheet(&mut self, surface: &Surface, form: &SurfaceForm) -> Result<(u32, bool)> {
        if let Some((frame, same)) = elementary(surface, form)? {
            let position = Look::PART.purpose(Purpose::Definition);
            let origin = self.point(&frame.origin, position, &[]);
            let (axis, toward) = (self.direction(&frame.z), self.direction(&frame.x));
            let record = match *form {
                SurfaceForm::Cylinder { radius, .. } => {
                    Record::new(192).entities(&[origin, axis]).real(radius).entity(toward)
                }
                SurfaceForm::Cone { radius, angle, .. } => Record::new(194)
                    .entities(&[origin, axis])
                    .real(radius)
                    .real(angle.to_degrees())
                    .entity(toward),
                SurfaceForm::Sphere { radius, .. } => {
                    Record::new(196).entity(origin).real(radius).entities(&[axis, toward])
                }
                SurfaceForm::Torus { major, minor, .. } => {
                    Record::new(198).entities(&[origin, axis]).real(major).real(minor).entity(toward)
                }
                _ => Record::new(190).entities(&[origin, axis, toward]),
            };
            return Ok((self.put(record, Look::PART.form(1)), same));
        }
        let plain = surface.clamped()?;
        Ok((self.surface(&plain, Look::PART, &[]), true))
    }
}

/// The frame of a form that the file has.
fn frame_of(form: &SurfaceForm) -> Option<Frame> {
    match *form {
        SurfaceForm::Plane { frame }
        | SurfaceForm::Cylinder { frame, .. }
        | SurfaceForm::Cone { frame, .. }
        | SurfaceForm::Sphere { frame, .. } => Some(frame),
        SurfaceForm::Torus { frame, major, minor } if major > minor => Some(frame),
        _ => None,
    }
}

/// The frame of a surface that goes out as what it is, and whether its normal in the file is that of the spline; `None` of one that goes out as a spline.
pub(crate) fn elementary(surface: &Surface, form: &SurfaceForm) -> Result<Option<(Frame, bool)>> {
    let Some(frame) = frame_of(form) else { return Ok(None) };
    Ok(same_side(surface, form)?.map(|same| (frame, same)))
}

/// Whether the normal of a spline points as that of its form does; `None` where the spline is of no form, or has no normal anywhere
/// that was looked.
fn same_side(surface: &Surface, form: &SurfaceForm) -> Result<Option<bool>> {
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let across = |frame: &Frame, p: Point| {
        let d = p - frame.origin;
        d - frame.z * d.dot(&frame.z)
    };
    for (s, t) in [(0.37, 0.41), (0.61, 0.53), (0.13, 0.29)] {
        let (u, v) = (a + s * (b - a), c + t * (d - c));
        let normal = surface.derivative(u, v, 1, 0)?.cross(&surface.derivative(u, v, 0, 1)?);
        let p = surface.point(u, v)?;
        let outwards = match form {
            SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
                return Ok(None);
            }
            SurfaceForm::Plane { frame } => frame.z,
            SurfaceForm::Sphere { frame, .. } => p - frame.origin,
            SurfaceForm::Cylinder { frame, .. } | SurfaceForm::Cone { frame, .. } => across(frame, p),
            SurfaceForm::Torus { frame, major, .. } => {
                p - (frame.origin + across(frame, p).try_normalize(0.0).unwrap_or(frame.x) * *major)
            }
        };
        let side = normal.dot(&outwards);
        if side != 0.0 && side.is_finite() {
            return Ok(Some(side > 0.0));
        }
    }
    Ok(None)
}
