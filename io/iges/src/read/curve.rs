//! Curves as exact splines, with how the file counts along them.

use std::f64::consts::TAU;

use loftsman_kernel::brep::{CurveForm, Frame};
use loftsman_kernel::spline::{Curve, CurvePiece, Space};
use loftsman_kernel::{Point, Vector, direction};
use nalgebra::Matrix4;

use super::entity::{At, Entity, Got, Problem, Reader, deeper};
use super::pace::Pace;
use super::place::{finite, moved_curve, moved_frame, transform_point};

/// A curve of a file.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) curve: Curve,
    pub(crate) pace: Pace,
    /// What it is beside a spline.
    pub(crate) form: CurveForm,
    /// From where to where on that; the first is more where it runs the other way.
    pub(crate) range: [f64; 2],
}

/// Whether entities of a type are curves.
pub(crate) fn is_curve(kind: u32, form: i32) -> bool {
    matches!(kind, 100 | 102 | 104 | 110 | 112 | 126 | 130) || (kind == 106 && is_chain(form))
}

/// Whether copious data of a form are points in a row, which lines join.
pub(crate) fn is_chain(form: i32) -> bool {
    matches!(form, 11..=13 | 63)
}

impl Run {
    pub(crate) fn spline(curve: Curve, form: CurveForm) -> Self {
        let (a, b) = curve.domain();
        Self { curve, pace: Pace::even([a, b], [a, b]), form, range: CurvePiece::LINE.range }
    }

    /// The curve with what it is beside a spline.
    pub(crate) fn formed(self) -> Curve {
        let Self { curve, form, range: [from, to], .. } = self;
        let piece = match form {
            CurveForm::Spline => return curve,
            form if from > to => CurvePiece { form, range: [to, from] }.reversed(),
            form => CurvePiece { form, range: [from, to] },
        };
        // Of what is off its equation by more than rounding, as the file has it, the spline is left.
        curve.clone().with_form(piece).unwrap_or(curve)
    }

    /// Under a map.
    fn moved(self, map: &Matrix4<f64>, place: usize) -> Got<Self> {
        let form = match self.form {
            CurveForm::Circle { frame, radius } => {
                moved_frame(&frame, map).map(|frame| CurveForm::Circle { frame, radius })
            }
            CurveForm::Ellipse { frame, radii } => {
                moved_frame(&frame, map).map(|frame| CurveForm::Ellipse { frame, radii })
            }
            CurveForm::Parabola { frame, focal } => {
                moved_frame(&frame, map).map(|frame| CurveForm::Parabola { frame, focal })
            }
            CurveForm::Hyperbola { frame, radii } => {
                moved_frame(&frame, map).map(|frame| CurveForm::Hyperbola { frame, radii })
            }
            form @ (CurveForm::Spline | CurveForm::Line) => Some(form),
        };
        Ok(Self { curve: moved_curve(self.curve, map, place)?, form: form.unwrap_or_default(), ..self })
    }
}

/// As far as curves reach that one after another make a whole.
fn size<'p>(points: impl Iterator<Item = &'p Point>) -> f64 {
    let mut first = None;
    points.map(|p| (p - *first.get_or_insert(*p)).amax()).fold(0.0, f64::max)
}

impl Reader<'_, '_> {
    /// How far apart what meets may be: what the file says, or a part of the size of it.
    pub(crate) fn near(&self, size: f64) -> f64 {
        self.file.global.resolution.max(1e-6 * size)
    }

    /// A curve where it is placed.
    pub(crate) fn curve(&self, place: usize, depth: usize) -> Got<Run> {
        let depth = deeper(place, depth)?;
        let entity = self.entity(place)?;
        let run = match (entity.entry.kind, entity.entry.form) {
            (100, _) => arc(&entity),
            (102, _) => self.composite(&entity, depth),
            (104, _) => super::conic::conic(&entity),
            (106, form) if is_chain(form) => chain(&entity).and_then(|(points, _)| polyline(&points, place)),
            (110, 0) => {
                let (a, b) = (Point::from(entity.triple(1)?), Point::from(entity.triple(4)?));
                entity.has(4)?;
                let curve = Curve::line(finite(a, place)?, finite(b, place)?).at(place)?;
                Ok(Run::spline(curve, CurveForm::Line))
            }
            (110, _) => Err(Problem::new(place, "a line without ends")),
            (112, _) => super::spline::parametric_curve(&entity),
            (126, _) => super::spline::curve(&entity),
            (130, _) => self.offset(&entity, depth),
            (kind, form) => {
                Err(Problem::new(place, format!("type {kind}, form {form} is no curve that is read")))
            }
        }?;
        match self.placed(place)? {
            Some(map) => run.moved(&map, place),
            None => Ok(run),
        }
    }

    /// The parts of a curve, each where it is placed: of a composite one its constituents.
    pub(crate) fn parts(&self, place: usize, depth: usize) -> Got<Vec<Run>> {
        let depth = deeper(place, depth)?;
        if self.file.entry(place).kind != 102 {
            return Ok(vec![self.curve(place, depth)?]);
        }
        let entity = self.entity(place)?;
        let mut all = Vec::new();
        for part in constituents(&entity)? {
            all.extend(self.parts(part, depth)?);
        }
        match self.placed(place)? {
            Some(map) => all.into_iter().map(|run| run.moved(&map, place)).collect(),
            None => Ok(all),
        }
    }

    /// A composite curve (102), joined.
    fn composite(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Run> {
        let place = entity.place;
        let mut parts = Vec::new();
        for part in constituents(entity)? {
            // A point between curves says nothing of its own.
            if !matches!(self.file.entry(part).kind, 116 | 132) {
                parts.push(self.curve(part, depth)?);
            }
        }
        let reach = size(parts.iter().flat_map(|run| run.curve.points()));
        let near = self.near(reach);
        let mut parts = parts.into_iter();
        let Some(Run { mut curve, mut pace, .. }) = parts.next() else {
            return Err(Problem::new(place, "a composite curve without curves"));
        };
        for part in parts {
            let end = curve.domain().1;
            let joined = curve.join(&part.curve, near).at(place)?;
            pace = pace.then(&part.pace, end);
            curve = joined.shape;
        }
        Ok(Run { pace, ..Run::spline(curve, CurveForm::Spline) })
    }

    /// An offset (130) of a line or of a circle, which are of their own kind.
    fn offset(&self, entity: &Entity<'_, '_>, depth: usize) -> Got<Run> {
        let place = entity.place;
        let base = self.curve(entity.pointer(1)?, depth)?;
        if entity.whole(2)? != 1 {
            return Err(Problem::new(place, "an offset whose distance varies is not read"));
        }
        let (distance, normal) = (entity.real(6)?, Vector::from(entity.triple(10)?));
        let Some(normal) = direction(&normal) else {
            return Err(Problem::new(place, "the normal of its plane has no length"));
        };
        let (space, points, weights) = base.curve.into_parts();
        let moved: Vec<Point> = match base.form {
            CurveForm::Line => {
                let along = points.last().zip(points.first()).map(|(b, a)| b - a);
                let Some(along) = along.and_then(|along| direction(&along)) else {
                    return Err(Problem::new(place, "an offset of a line without length"));
                };
                let by = normal.cross(&along) * distance;
                points.iter().map(|p| p + by).collect()
            }
            CurveForm::Circle { frame, radius } => {
                // Towards the centre, seen from the tip of the normal.
                let by = if frame.z.dot(&normal) > 0.0 { distance } else { -distance };
                let factor = (radius - by) / radius;
                if factor <= 0.0 {
                    return Err(Problem::new(place, "an offset by which nothing of the circle is left"));
                }
                points.iter().map(|p| frame.origin + (p - frame.origin) * factor).collect()
            }
            _ => return Err(Problem::new(place, "an offset of a free-form curve, which is no spline")),
        };
        let curve = Curve::build(space, moved, weights).at(place)?;
        let ends = [entity.optional(13)?, entity.optional(14)?];
        let all = base.pace.range();
        if let [Some(from), Some(to)] = ends
            && [from, to] != all
            && from < to
        {
            let (Some(a), Some(b)) = (base.pace.at(from), base.pace.at(to)) else {
                return Err(Problem::new(
                    place,
                    format!("it runs from {from} to {to}, beyond its base curve"),
                ));
            };
            return Ok(Run::spline(curve.between(a, b).at(place)?, CurveForm::Spline));
        }
        Ok(Run { pace: base.pace, ..Run::spline(curve, CurveForm::Spline) })
    }
}

/// The places of what a composite curve is made of.
pub(crate) fn constituents(entity: &Entity<'_, '_>) -> Got<Vec<usize>> {
    entity.pointers(2, entity.count(1, 1)?)
}

/// A circular arc (100): counterclockwise in its plane `z = ZT`.
fn arc(entity: &Entity<'_, '_>) -> Got<Run> {
    let place = entity.place;
    let [z, x1, y1, x2, y2, x3, y3] = <[f64; 7]>::try_from(entity.reals(1, 7)?).unwrap_or_default();
    let center = finite(Point::new(x1, y1, z), place)?;
    let (start, end) = (Vector::new(x2 - x1, y2 - y1, 0.0), Vector::new(x3 - x1, y3 - y1, 0.0));
    let radius = start.norm();
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Problem::new(place, format!("an arc of the radius {radius}")));
    }
    let (from, to) = (start.y.atan2(start.x), end.y.atan2(end.x));
    let sweep = (to - from).rem_euclid(TAU);
    // Where both ends are one it goes all around.
    let full = !(1e-9..=TAU - 1e-9).contains(&sweep) || (end - start).norm() <= 1e-9 * radius;
    let sweep = if full { TAU } else { sweep };
    let across = Vector::new(-start.y, start.x, 0.0);
    let curve = Curve::elliptic_arc(center, start, across, 0.0, sweep).at(place)?;
    // Where the file says that it starts and ends it does, to the bit, unless that is no point of the circle.
    let named = [Point::new(x2, y2, z), if full { Point::new(x2, y2, z) } else { Point::new(x3, y3, z) }];
    let curve = ending(curve, named).at(place)?;
    let (a, b) = curve.domain();
    let from = from.rem_euclid(TAU);
    let pace = Pace::turn([from, from + sweep], [a, b], curve.space().spans().count(), sweep);
    let frame = Frame::new(center, Vector::z(), start);
    let form = frame.map_or(CurveForm::Spline, |frame| CurveForm::Circle { frame, radius });
    Ok(Run { curve, pace, form, range: [0.0, sweep] })
}

/// A clamped curve whose ends are these points, where they are but for rounding.
fn ending(curve: Curve, [start, end]: [Point; 2]) -> loftsman_kernel::Result<Curve> {
    let (space, mut points, weights) = curve.into_parts();
    let near =
        |a: &Point, b: &Point| (a - b).amax() <= 16.0 * f64::EPSILON * a.coords.amax().max(b.coords.amax());
    if let Some(first) = points.first_mut().filter(|first| near(first, &start)) {
        *first = start;
    }
    if let Some(last) = points.last_mut().filter(|last| near(last, &end)) {
        *last = end;
    }
    Curve::build(space, points, weights)
}

/// Points of copious data (106), and whether they close.
pub(crate) fn chain(entity: &Entity<'_, '_>) -> Got<(Vec<Point>, bool)> {
    let place = entity.place;
    let (each, first) = match entity.whole(1)? {
        1 => (2, 4),
        2 => (3, 3),
        3 => (6, 3),
        other => {
            return Err(Problem::new(
                place,
                format!("copious data of the kind {other}: 1, 2 and 3 are known"),
            ));
        }
    };
    let count = entity.count(2, each)?;
    let numbers = entity.reals(first, count * each)?;
    let z = if each == 2 { entity.real(3)? } else { 0.0 };
    let points: Vec<Point> = numbers
        .chunks(each)
        .map(|c| if each == 2 { Point::new(c[0], c[1], z) } else { Point::new(c[0], c[1], c[2]) })
        .collect();
    if points.is_empty() {
        return Err(Problem::new(place, "copious data without points"));
    }
    let closed = entity.entry.form == 63 || (points.len() > 3 && points.first() == points.last());
    Ok((points, closed))
}

fn polyline(points: &[Point], place: usize) -> Got<Run> {
    let knots: Vec<f64> = (0..points.len()).map(|k| k as f64).collect();
    let curve = Space::clamped(1, &knots).and_then(|space| Curve::new(space, points.to_vec())).at(place)?;
    Ok(Run::spline(curve, CurveForm::Spline))
}

/// Points under a map.
pub(crate) fn moved_points(points: &mut [Point], map: Option<&Matrix4<f64>>) {
    if let Some(map) = map {
        points.iter_mut().for_each(|p| *p = transform_point(map, p));
    }
}
