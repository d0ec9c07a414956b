//! Seams of whole spheres and tori: which side of the face each use of the edge bounds.
//!
//! Readers compute parameter curves of elementary surfaces. Where a face meets itself along an edge that is not enough: both uses are the same
//! curve in space, and one that lies a rounding error to one side of the surface's own seam has both read on that side, the face empty (a
//! sphere of which OpenCASCADE finds no area). So these alone are said: lines of a constant angle, a whole turn apart. And only of faces without other
//! edges: those would still be computed, and some readers shift them by a turn against a seam that is given.

use std::f64::consts::{PI, TAU};

use loftsman_kernel::brep::{Edge, Frame, SurfaceForm};
use loftsman_kernel::{Point, Result};

use super::parameters::Pace;
use super::print::{Printer, real};

/// Places of the edge that are compared with the line.
const EACH: usize = 8;
/// How far from it they may be, as a part of the edge's size, where its tolerance says less.
const NEAR: f64 = 1e-7;

/// A line in the parameters of a surface, over that of the written curve `t`: one of them is `value`, or a turn more, the other `at + slope t`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seam {
    /// Which of the two parameters is constant: 0 or 1.
    constant: usize,
    value: f64,
    at: f64,
    slope: f64,
    /// Whether the other parameter grows from the edge's start to its end.
    grows: bool,
}

/// The parameters of the schema at a point of a sphere or a torus: longitude, and latitude or the angle about the tube, in radians. `None` of others.
fn parameters(form: &SurfaceForm, p: Point) -> Option<[f64; 2]> {
    let around = |frame: &Frame, d: loftsman_kernel::Vector| d.dot(&frame.y()).atan2(d.dot(&frame.x));
    Some(match form {
        SurfaceForm::Sphere { frame, .. } => {
            let d = p - frame.origin;
            [around(frame, d), d.dot(&frame.z).atan2(d.dot(&frame.x).hypot(d.dot(&frame.y())))]
        }
        SurfaceForm::Torus { frame, major, .. } => {
            let d = p - frame.origin;
            let flat = d.dot(&frame.x).hypot(d.dot(&frame.y()));
            [around(frame, d), d.dot(&frame.z).atan2(flat - major)]
        }
        _ => return None,
    })
}

/// The point of a sphere or a torus at these parameters.
fn point(form: &SurfaceForm, [u, v]: [f64; 2]) -> Option<Point> {
    let across = |frame: &Frame| frame.x * u.cos() + frame.y() * u.sin();
    Some(match form {
        SurfaceForm::Sphere { frame, radius } => {
            frame.origin + across(frame) * (radius * v.cos()) + frame.z * (radius * v.sin())
        }
        SurfaceForm::Torus { frame, major, minor } => {
            frame.origin + across(frame) * (major + minor * v.cos()) + frame.z * (minor * v.sin())
        }
        _ => return None,
    })
}

/// An angle within half a turn of another.
fn beside(angle: f64, other: f64) -> f64 {
    other + (angle - other + PI).rem_euclid(TAU) - PI
}

impl Seam {
    /// The line of an edge on a surface, at the pace of its curve. `None` where the edge is no such line within its tolerance.
    pub(super) fn of(form: &SurfaceForm, edge: &Edge, pace: Pace) -> Result<Option<Self>> {
        let own = edge.curve.between(edge.range.0, edge.range.1)?;
        let points: Vec<Point> =
            (0..=EACH).map(|k| pace.point(&own, k as f64 / EACH as f64)).collect::<Result<_>>()?;
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let near = edge.tolerance.max(NEAR * size);
        let Some(middle) = parameters(form, points[EACH / 2]) else { return Ok(None) };
        // A sphere is closed in longitude only.
        let closed = if matches!(form, SurfaceForm::Torus { .. }) { 2 } else { 1 };
        for constant in 0..closed {
            // The schema's own seam where the edge is that, within its tolerance.
            for value in [0.0, middle[constant].rem_euclid(TAU)] {
                let Some(seam) = Self::along(form, &points, pace, constant, value) else { continue };
                let holds = points.iter().enumerate().all(|(k, p)| {
                    let t = pace.from + (pace.to - pace.from) * (k as f64 / EACH as f64);
                    point(form, seam.parameters(t, false)).is_some_and(|q| nalgebra::distance(&q, p) <= near)
                });
                if holds {
                    return Ok(Some(seam));
                }
            }
        }
        Ok(None)
    }

    /// The line through the edge's ends with a constant parameter.
    fn along(form: &SurfaceForm, points: &[Point], pace: Pace, constant: usize, value: f64) -> Option<Self> {
        // Place after place, so that the angle goes on through its whole turn. Poles have no longitude, but a latitude.
        let mut run = Vec::with_capacity(points.len());
        for p in points {
            let found = parameters(form, *p)?[1 - constant];
            run.push(run.last().map_or(found, |&last| beside(found, last)));
        }
        let (first, last) = (*run.first()?, *run.last()?);
        let slope = (last - first) / (pace.to - pace.from);
        // Of a circle the pace is an angle, too.
        let slope = if (slope.abs() - 1.0).abs() < NEAR { slope.signum() } else { slope };
        (slope.is_finite() && slope != 0.0).then_some(Self {
            constant,
            value,
            at: first - slope * pace.from,
            slope,
            grows: last > first,
        })
    }

    /// The parameters on one of the two sides.
    fn parameters(&self, t: f64, beyond: bool) -> [f64; 2] {
        let mut found = [self.at + self.slope * t; 2];
        found[self.constant] = self.value + if beyond { TAU } else { 0.0 };
        found
    }
}

impl Printer {
    /// The parameter curve of one use of a seam. What the use bounds is to its left where the face looks as the surface does.
    pub(super) fn seam(&mut self, seam: &Seam, surface: u64, (reversed, same): (bool, bool)) -> u64 {
        // Along v what lies left has smaller u; along u it has larger v.
        let beyond = (seam.grows != reversed) == same;
        let beyond = if seam.constant == 0 { beyond } else { !beyond };
        let [x, y] = seam.parameters(0.0, beyond);
        let origin = self.put(&format!("CARTESIAN_POINT('',({},{}))", real(x), real(y)));
        let way = [[0.0, 1.0], [1.0, 0.0]][seam.constant].map(|part| part * seam.slope.signum());
        let direction = self.put(&format!("DIRECTION('',({},{}))", real(way[0]), real(way[1])));
        let vector = self.put(&format!("VECTOR('',#{direction},{})", real(seam.slope.abs())));
        let line = self.put(&format!("LINE('',#{origin},#{vector})"));
        self.in_parameters(line, surface)
    }
}
