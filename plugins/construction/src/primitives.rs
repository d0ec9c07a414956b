//! `line`, `polyline`, `circle`, `arc`, `ellipse`: curves from numbers.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport,
};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::fields::{NAME, direction, free_name, length, made, point_or_origin, turn};

const PERIODIC: Field = Field::optional(
    "periodic",
    "true | false",
    "false",
    "without ends: of the same points, closed as smoothly as its parameters are",
);

/// Adds a curve to the scene.
fn add(
    op: &'static str,
    scene: &mut Scene,
    p: &Parameters,
    curve: Curve,
) -> Result<StepReport, OperationError> {
    let name = free_name(scene, p, op)?;
    scene.add(Object::new(&name, curve.into()))?;
    Ok(made(op, name, Vec::new()))
}

/// The operation `line`: [`Curve::line`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Line;

impl Operation for Line {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("from", "[x, y, z]", "where it starts"),
            Field::required("to", "[x, y, z]", "where it ends"),
            NAME,
        ];
        Declaration {
            name: "line",
            help: "add a straight line, a curve of degree 1 over [0, 1]; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let (from, to) = (p.point("from")?, p.point("to")?);
        if from == to {
            return Err(p.error("to", "is where the line starts: give another point").into());
        }
        add("line", scene, p, Curve::line(from, to)?)
    }
}

/// The operation `polyline`: a chain of points, or the curve of degree 1 through them.
#[derive(Debug, Clone, Copy, Default)]
pub struct PolylineOf;

impl Operation for PolylineOf {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("points", "[[x, y, z], …]", "its points, two at least, in their order"),
            Field::optional("closed", "true | false", "false", "join the last point to the first"),
            Field::optional(
                "curve",
                "true | false",
                "false",
                "make it a curve of degree 1, whose parameters at the points are 0, 1, 2, …",
            ),
            NAME,
        ];
        Declaration {
            name: "polyline",
            help: "add a chain of points joined by straight segments; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let line = Polyline { points: p.points("points")?, closed: p.flag("closed")? };
        let as_curve = p.flag("curve")?;
        let curve = curve_through(&line).map_err(|e| p.error("points", e.to_string()))?;
        let name = free_name(scene, p, "polyline")?;
        let notes = vec![format!("{} points", line.points.len())];
        let geometry = if as_curve { curve.into() } else { line.into() };
        scene.add(Object::new(&name, geometry))?;
        Ok(made("polyline", name, notes))
    }
}

/// The curve of degree 1 through the points of a polyline, whose parameters there are 0, 1, 2, …: periodic where that is closed.
pub(crate) fn curve_through(line: &Polyline) -> Result<Curve> {
    let count = line.points.len();
    let needed = if line.closed { 3 } else { 2 };
    if count < needed {
        let closed = if line.closed { " closed" } else { "" };
        return Err(Error::Invalid(format!(
            "a{closed} polyline needs {needed} points at least, and has {count}"
        )));
    }
    let space = if line.closed {
        Space::periodic(1, (0..=count).map(|k| k as f64).collect())?
    } else {
        Space::clamped(1, &(0..count).map(|k| k as f64).collect::<Vec<_>>())?
    };
    let mut points = line.points.clone();
    if line.closed {
        // Vertex `i` of a periodic curve of degree 1 is at knot `i + 1`.
        points.rotate_left(1);
    }
    Curve::new(space, points)
}

/// The operation `circle`: [`Curve::circle`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Circle;

impl Operation for Circle {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("radius", "length", "its radius"),
            Field::optional("center", "[x, y, z]", "[0, 0, 0]", "its centre"),
            Field::optional("normal", "[x, y, z]", "[0, 0, 1]", "across its plane; it runs counterclockwise"),
            PERIODIC,
            NAME,
        ];
        Declaration {
            name: "circle",
            help: "add a circle, exact: a rational curve of degree 2 over the angles; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let (radius, center) = (length(p, "radius")?, point_or_origin(p, "center")?);
        let circle = Curve::circle(center, direction(p, "normal", Vector::z())?, radius)?;
        add("circle", scene, p, periodic(p, circle)?)
    }
}

/// The same without ends, where that is asked for.
fn periodic(p: &Parameters, curve: Curve) -> Result<Curve, OperationError> {
    Ok(if p.flag("periodic")? { curve.to_periodic(0.0)?.shape } else { curve })
}

/// The operation `arc`: through three points, or from a point about a centre.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arc;

impl Operation for Arc {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("from", "[x, y, z]", "where it starts"),
            Field::optional("through", "[x, y, z]", "with to", "a point on the way"),
            Field::optional("to", "[x, y, z]", "with through", "where it ends"),
            Field::optional(
                "center",
                "[x, y, z]",
                "without through and to: [0, 0, 0]",
                "a point of its axis",
            ),
            Field::optional(
                "normal",
                "[x, y, z]",
                "[0, 0, 1]",
                "the direction of its axis; it turns counterclockwise",
            ),
            Field::optional("degrees", "degrees, -360 to 360", "360", "how far it turns about the axis"),
            NAME,
        ];
        Declaration {
            name: "arc",
            help: "add an arc of a circle, exact, through three points or from one about an axis; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let from = p.point("from")?;
        let curve = if p.has("through") || p.has("to") {
            // What is there is read before what is missing is asked for.
            let to = if p.has("to") { Some(p.point("to")?) } else { None };
            let through = p.point("through")?;
            let to = to.map_or_else(|| p.point("to"), Ok)?;
            if let Some(field) = ["center", "normal", "degrees"].into_iter().find(|field| p.has(field)) {
                let problem = "says nothing of an arc through three points: leave it out, or through and to";
                return Err(p.error(field, problem).into());
            }
            arc_through(from, through, to).map_err(|e| p.error("through", e.to_string()))?
        } else {
            let (center, normal) = (point_or_origin(p, "center")?, direction(p, "normal", Vector::z())?);
            let sweep = turn(p, "degrees")?;
            Curve::arc(from, center, normal, sweep).map_err(|e| p.error("from", e.to_string()))?
        };
        add("arc", scene, p, curve)
    }
}

/// The arc of a circle from a point through a second to a third: clamped, degree 2, over the angle in radians.
///
/// The centre is `a + (|v|² (u×v)×u + |u|² v×(u×v)) / (2 |u×v|²)` with `u = b - a`, `v = c - a`.
///
/// # Errors
/// When two of the points are the same or all are on a line to rounding, or a number is not finite.
pub fn arc_through(from: Point, through: Point, to: Point) -> Result<Curve> {
    let (u, v) = (through - from, to - from);
    let size = u.amax().max(v.amax());
    let straight = || {
        Error::Invalid(
            "the three points lie on a line, or two of them are one: an arc needs a bend; take a line".into(),
        )
    };
    if !(size > 0.0 && size.is_finite()) {
        return Err(straight());
    }
    let (u, v) = (u / size, v / size);
    let normal = u.cross(&v);
    let across = normal.norm_squared();
    // Below this the coordinates' own rounding decides which way it bends.
    let rounding = 16.0 * f64::EPSILON * (1.0 + from.coords.amax().max(to.coords.amax()) / size);
    if across.sqrt() <= rounding * u.norm() * v.norm() || (v - u).norm() <= rounding {
        return Err(straight());
    }
    let center = (normal.cross(&u) * v.norm_squared() + v.cross(&normal) * u.norm_squared()) / (2.0 * across);
    let normal = normal / across.sqrt();
    let (start, end) = (-center, v - center);
    // The normal is such that the way from the first over the second to the third is counterclockwise.
    let angle = normal.dot(&start.cross(&end)).atan2(start.dot(&end)).rem_euclid(std::f64::consts::TAU);
    Curve::arc(from, from + center * size, normal, angle)
}

/// The operation `ellipse`: [`Curve::elliptic_arc`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Ellipse;

impl Operation for Ellipse {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("x", "[x, y, z]", "half a diameter, to where it starts"),
            Field::required("y", "[x, y, z]", "half another, which is conjugate: to a quarter turn later"),
            Field::optional("center", "[x, y, z]", "[0, 0, 0]", "its centre"),
            Field::optional("start", "degrees", "0", "where an arc of it starts, from x towards y"),
            Field::optional("degrees", "degrees, -360 to 360", "360", "how far an arc of it goes"),
            PERIODIC,
            NAME,
        ];
        Declaration {
            name: "ellipse",
            help: "add an ellipse or an arc of one, exact: center + x cos t + y sin t; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let (x, y) = (p.vector("x")?, p.vector("y")?);
        let (center, sweep) = (point_or_origin(p, "center")?, turn(p, "degrees")?);
        let start = p.number_or("start", 0.0)?.to_radians();
        if p.flag("periodic")? && sweep.abs() < std::f64::consts::TAU {
            return Err(p.error("periodic", "an arc has ends: leave it out, or degrees").into());
        }
        let curve =
            Curve::elliptic_arc(center, x, y, start, sweep).map_err(|e| p.error("y", e.to_string()))?;
        add("ellipse", scene, p, periodic(p, curve)?)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn arcs_pass_three_points_on_one_circle(
            scale in -9.0..9.0_f64, shift in -1.0..1.0_f64, a in 0.0..6.0_f64, b in 0.05..0.95_f64, c in 0.02..0.99_f64,
        ) {
            let size = 10.0_f64.powf(scale);
            let sweep = c * std::f64::consts::TAU;
            let at = |t: f64| {
                let (sin, cos) = t.sin_cos();
                Point::new(shift * size + size * cos, size * (0.6 * sin - shift), 0.8 * size * sin)
            };
            let (from, through, to) = (at(a), at(a + b * sweep), at(a + sweep));
            let arc = arc_through(from, through, to).unwrap();
            let (start, end) = arc.domain();
            prop_assert!((end - start - sweep).abs() < 1e-9, "{end} {sweep}");
            let near = 1e-10 * size;
            prop_assert!((arc.point(end).unwrap() - to).norm() < near);
            prop_assert!(arc.closest(through).unwrap().distance < near);
        }
    }

    #[test]
    fn points_on_a_line_bend_nowhere() {
        let at = |x: f64| Point::new(x, 2.0 * x, -x);
        assert!(arc_through(at(0.0), at(1.0), at(2.0)).is_err());
        assert!(arc_through(at(0.0), at(0.0), at(2.0)).is_err());
        assert!(arc_through(at(0.0), at(1.0), at(0.0)).is_err());
        assert!(arc_through(at(0.0), at(f64::NAN), at(1.0)).is_err());
        assert!(arc_through(at(0.0), at(1.0), at(f64::INFINITY)).is_err());
    }

    #[test]
    fn closed_polylines_start_at_their_first_point() {
        let points = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
        for closed in [false, true] {
            let line = Polyline { points: points.clone(), closed };
            let curve = curve_through(&line).unwrap();
            for (k, p) in points.iter().enumerate() {
                assert_eq!(curve.point(k as f64).unwrap(), *p);
            }
        }
        assert!(curve_through(&Polyline { points: points[..2].to_vec(), closed: true }).is_err());
        assert!(curve_through(&Polyline { points: points[..1].to_vec(), closed: false }).is_err());
    }
}
